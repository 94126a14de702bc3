//! How a call ends: a status, a message for the thread, and no panic beyond the boundary.

use core::ffi::{CStr, c_char, c_void};
use core::fmt::{self, Write};
use covbeam_core::GridError;
use std::cell::{Cell, RefCell};
use std::panic::{self, AssertUnwindSafe, PanicHookInfo};
use std::sync::OnceLock;

/// How a call ended. All but COVBEAM_OK have changed nothing, unless the function says otherwise.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum covbeam_status {
    /// Done.
    COVBEAM_OK = 0,
    /// A pointer is NULL that may not be.
    COVBEAM_NULL_POINTER = 1,
    /// A pointer or a stride is not a multiple of the alignment of what it points to.
    COVBEAM_MISALIGNED = 2,
    /// A number is NaN, infinite or out of its range, a vector has no length, or a struct_size is unknown.
    COVBEAM_INVALID_VALUE = 3,
    /// A count or a stride that no array in memory can have, or more elements than the library takes.
    COVBEAM_INVALID_ARRAY = 4,
    /// A buffer is not as long as it must be.
    COVBEAM_SHORT_BUFFER = 5,
    /// The pointer is not a handle of this kind, or no longer.
    COVBEAM_INVALID_HANDLE = 6,
    /// The call comes too early or too late in the cycle of its object.
    COVBEAM_WRONG_ORDER = 7,
    /// Two objects that must agree do not, such as the layouts of two grids.
    COVBEAM_MISMATCH = 8,
    /// The bytes are not what the library saves.
    COVBEAM_BAD_DATA = 9,
    /// Memory could not be had.
    COVBEAM_OUT_OF_MEMORY = 10,
    /// The host's poll asked to stop.
    COVBEAM_CANCELLED = 11,
    /// The host's shade callback reported a failure.
    COVBEAM_CALLBACK_FAILED = 12,
    /// An earlier call on this object ended in COVBEAM_PANICKED: free it.
    COVBEAM_POISONED = 13,
    /// A defect of the library: please report the message.
    COVBEAM_PANICKED = 14,
    /// Another call on the object, of this thread or of another, has not returned yet.
    COVBEAM_BUSY = 15,
}

use covbeam_status::*;

/// A status that is not COVBEAM_OK, whose message has been written.
#[derive(Debug)]
pub(crate) struct Failure(pub(crate) covbeam_status);

/// Longest message, its NUL included.
const MESSAGE: usize = 256;

struct Message {
    text: [u8; MESSAGE],
    length: usize,
}

impl Write for Message {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for character in text.chars() {
            let mut utf8 = [0; 4];
            let bytes = character.encode_utf8(&mut utf8).as_bytes();
            // Cut between characters, with room for the NUL.
            if self.length + bytes.len() >= MESSAGE {
                return Err(fmt::Error);
            }
            self.text[self.length..self.length + bytes.len()].copy_from_slice(bytes);
            self.length += bytes.len();
        }
        Ok(())
    }
}

thread_local! {
    // Without destructor and allocation: a thread that ends leaves nothing behind.
    static LAST: RefCell<Message> = const { RefCell::new(Message { text: [0; MESSAGE], length: 0 }) };
    /// In how many calls the thread is: more than one in callbacks.
    static CALLS: Cell<u32> = const { Cell::new(0) };
    /// Whether it works for a session, and was started by the host for that.
    static WORKS: Cell<bool> = const { Cell::new(false) };
}

/// Writes the thread's message. A longer one is cut.
pub(crate) fn fail(status: covbeam_status, message: fmt::Arguments) -> Failure {
    LAST.with_borrow_mut(|last| {
        last.length = 0;
        let _cut = last.write_fmt(message);
        let end = last.length;
        last.text[end] = 0;
    });
    Failure(status)
}

/// Runs the body of a call. A panic becomes COVBEAM_PANICKED.
pub(crate) fn run(body: impl FnOnce() -> Result<(), Failure>) -> covbeam_status {
    keep_panics_quiet();
    let outer = CALLS.replace(CALLS.get() + 1);
    let result = panic::catch_unwind(AssertUnwindSafe(body));
    CALLS.set(outer);
    match result {
        Ok(Ok(())) => COVBEAM_OK,
        Ok(Err(Failure(status))) => status,
        Err(payload) => {
            // What a payload does when it is dropped is not ours to know.
            core::mem::forget(payload);
            COVBEAM_PANICKED
        }
    }
}

/// Runs what a thread of a session does that the host has started.
#[cfg(feature = "session")]
pub(crate) fn work(body: impl FnOnce()) {
    WORKS.set(true);
    body();
    WORKS.set(false);
}

/// Whether the thread is in a callback of another call.
pub(crate) fn is_nested() -> bool {
    CALLS.get() > 1
}

/// A panic inside a call, or of a session's own thread, is written to the thread's message instead of the standard error. Elsewhere (Rust
/// hosts that share this copy of the standard library) nothing changes.
fn keep_panics_quiet() {
    type Hook = Box<dyn Fn(&PanicHookInfo) + Sync + Send>;
    static BEFORE: OnceLock<Hook> = OnceLock::new();
    BEFORE.get_or_init(|| {
        let before = panic::take_hook();
        // Captures nothing, so that its box needs no memory.
        panic::set_hook(Box::new(|info| {
            if CALLS.get() > 0 || WORKS.get() || is_own_thread() {
                fail(COVBEAM_PANICKED, format_args!("{info}"));
            } else {
                BEFORE.wait()(info);
            }
        }));
        before
    });
}

/// Whether the library has started the thread, which has its name then (`covbeam_session::work::threads`).
fn is_own_thread() -> bool {
    std::thread::current().name().is_some_and(|name| name.starts_with("covbeam "))
}

/// The name of a status, such as "COVBEAM_SHORT_BUFFER".
///
/// @param status a value of covbeam_status; any other number gives "unknown status".
/// @return a static string, never NULL. Any thread, any time.
#[unsafe(no_mangle)]
pub extern "C" fn covbeam_status_name(status: i32) -> *const c_char {
    const NAMES: [&CStr; 16] = [
        c"COVBEAM_OK",
        c"COVBEAM_NULL_POINTER",
        c"COVBEAM_MISALIGNED",
        c"COVBEAM_INVALID_VALUE",
        c"COVBEAM_INVALID_ARRAY",
        c"COVBEAM_SHORT_BUFFER",
        c"COVBEAM_INVALID_HANDLE",
        c"COVBEAM_WRONG_ORDER",
        c"COVBEAM_MISMATCH",
        c"COVBEAM_BAD_DATA",
        c"COVBEAM_OUT_OF_MEMORY",
        c"COVBEAM_CANCELLED",
        c"COVBEAM_CALLBACK_FAILED",
        c"COVBEAM_POISONED",
        c"COVBEAM_PANICKED",
        c"COVBEAM_BUSY",
    ];
    usize::try_from(status).ok().and_then(|i| NAMES.get(i)).unwrap_or(&c"unknown status").as_ptr()
}

/// What went wrong in the latest call of this thread that did not return COVBEAM_OK: names the parameter and
/// the remedy.
///
/// @return UTF-8, at most 255 bytes, never NULL, empty before the first failure; valid until the thread's next
///     call that fails.
#[unsafe(no_mangle)]
pub extern "C" fn covbeam_last_error() -> *const c_char {
    LAST.with_borrow(|last| last.text.as_ptr().cast())
}

/// Asked now and then during a long call: return 0 to go on, anything else to stop.
pub type covbeam_poll = Option<unsafe extern "C" fn(user: *mut c_void) -> i32>;

pub(crate) fn cancelled() -> Failure {
    fail(COVBEAM_CANCELLED, format_args!("poll: asked to stop"))
}

/// Whether the host wants to go on.
pub(crate) fn go_on(poll: covbeam_poll, user: *mut c_void) -> impl FnMut() -> bool {
    // SAFETY: the host promises that it may be called with `user` during the call.
    move || poll.is_none_or(|poll| unsafe { poll(user) } == 0)
}

/// The failure for an argument that the core refused.
pub(crate) fn refusal(name: &str, error: GridError) -> Failure {
    let status = match error {
        GridError::Layout | GridError::Value => COVBEAM_INVALID_VALUE,
        GridError::Length => COVBEAM_SHORT_BUFFER,
        GridError::OtherLayout => COVBEAM_MISMATCH,
        GridError::Format | GridError::Damaged => COVBEAM_BAD_DATA,
    };
    fail(status, format_args!("{name}: {error}"))
}
