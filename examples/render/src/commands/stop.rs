//! Being asked to stop by a signal: Ctrl-C, a closed terminal, or whoever ends programs; and by the clock.

use signal_hook::consts::signal::{SIGINT, SIGTERM};
use signal_hook::flag::register_usize;
use std::io;
use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

#[cfg(unix)]
const SIGNALS: [i32; 3] = [SIGINT, SIGTERM, signal_hook::consts::signal::SIGHUP];
#[cfg(not(unix))]
const SIGNALS: [i32; 2] = [SIGINT, SIGTERM];

/// Which signal came, if any.
#[derive(Clone)]
pub(crate) struct Stop(Arc<AtomicUsize>);

impl Stop {
    /// From now on these signals are noted and end nothing by themselves, but for those that whoever started the program wants to be ignored,
    /// as `nohup` does.
    pub(crate) fn on_signals() -> io::Result<Self> {
        let latest = Arc::new(AtomicUsize::new(0));
        let ignored = ignored();
        for signal in SIGNALS.into_iter().filter(|signal| ignored & (1 << (signal - 1)) == 0) {
            register_usize(signal, Arc::clone(&latest), signal as usize)?;
        }
        Ok(Self(latest))
    }

    pub(crate) fn is_asked(&self) -> bool {
        self.0.load(Ordering::Relaxed) != 0
    }

    /// What shells report of a program that the signal ended.
    pub(crate) fn exit_code(&self) -> ExitCode {
        ExitCode::from(self.code())
    }

    /// The same as a number.
    pub(crate) fn code(&self) -> u8 {
        128 + self.0.load(Ordering::Relaxed) as u8
    }
}

/// Ends the program by itself as long as there is no work to keep: what a scene is surveyed, planned and tried by polls nothing, and in scenes that
/// are hard the first pass may take minutes between two polls.
pub(crate) struct Watch(Arc<Mutex<bool>>);

/// Why a [`Watch`] ends the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ended {
    /// A signal came.
    Signal,
    /// The time is over.
    Time,
}

impl Watch {
    const EVERY: Duration = Duration::from_millis(20);

    /// Begins to watch for signals and the end of the time; `last_words` says so, and what the program returns.
    pub(crate) fn new(
        stop: Stop,
        until: Option<Instant>,
        last_words: impl Fn(Ended) -> u8 + Send + 'static,
    ) -> io::Result<Self> {
        let kept = Arc::new(Mutex::new(false));
        let seen = Arc::clone(&kept);
        let watch = move || {
            loop {
                std::thread::sleep(Self::EVERY);
                // Held while it ends: what begins to keep work waits, and is not cut off.
                let kept = seen.lock().unwrap_or_else(PoisonError::into_inner);
                let is_late = until.is_some_and(|until| Instant::now() >= until);
                match (*kept, stop.is_asked(), is_late) {
                    (true, ..) => return,
                    (_, true, _) => std::process::exit(last_words(Ended::Signal).into()),
                    (_, _, true) => std::process::exit(last_words(Ended::Time).into()),
                    _ => {}
                }
            }
        };
        std::thread::Builder::new().name("watch".to_owned()).spawn(watch)?;
        Ok(Self(kept))
    }

    /// From now on there is work to keep, or no more to watch.
    pub(crate) fn end(&self) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = true;
    }
}

/// The signals that are ignored, as bits: the first one has the lowest. 0 where the system does not tell.
fn ignored() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0)
}
