//! For the tests: one bad argument at a time, and what must come of it.

use crate::status::{covbeam_last_error, covbeam_status, covbeam_status::*};
use core::cell::Cell;
use core::ffi::CStr;
use core::ptr;

/// What outputs hold before a call; no function computes it from the arguments of the tests.
pub(crate) const UNTOUCHED: f32 = -7.25;

/// Which values of a number are documented as fine.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Rule {
    Finite,
    NotNegative,
    FiniteNotNegative,
    Positive,
    PositiveOrInfinite,
    /// [0, 1]; 1 counts as the largest below.
    Random,
    Cosine,
    /// (-1, 1).
    Asymmetry,
    /// (0, 1].
    Alpha,
    /// A component of a unit vector along another axis.
    Across,
    /// The component of a unit vector along its axis.
    Along,
    /// Of a vector that is 0 otherwise: none, or a unit vector.
    Along0,
    /// Finite, and not less than this.
    From(f32),
}

impl Rule {
    fn takes(self, v: f32) -> bool {
        match self {
            Rule::Finite => v.is_finite(),
            Rule::NotNegative => v >= 0.0,
            Rule::FiniteNotNegative => v.is_finite() && v >= 0.0,
            Rule::Positive => v.is_finite() && v > 0.0,
            Rule::PositiveOrInfinite => v > 0.0,
            Rule::Random => (0.0..=1.0).contains(&v),
            Rule::Cosine => (-1.0..=1.0).contains(&v),
            Rule::Asymmetry => v > -1.0 && v < 1.0,
            Rule::Alpha => v > 0.0 && v <= 1.0,
            Rule::Across => v.abs() < 1e-3,
            Rule::Along => v.abs() == 1.0,
            Rule::Along0 => v == 0.0 || v.abs() == 1.0,
            Rule::From(least) => v.is_finite() && v >= least,
        }
    }
}

/// Of no number are more than these of interest: all kinds, both sides of every bound of the rules.
const NUMBERS: [f32; 14] = [
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    0.0,
    -0.0,
    1e-45,
    -1e-45,
    0.75,
    1.0,
    -1.0,
    1.5,
    -1.5,
    1e30,
    -1e30,
];

/// What is done to one pointer of a call.
pub(crate) struct Bad {
    index: usize,
    status: covbeam_status,
    met: Cell<bool>,
}

impl Bad {
    /// The pointer with this index among the call's, made bad if its turn has come.
    pub(crate) fn at<T>(&self, index: usize, pointer: *const T) -> *const T {
        if index != self.index {
            return pointer;
        }
        match self.status {
            COVBEAM_NULL_POINTER => {
                self.met.set(true);
                ptr::null()
            }
            // Bytes are always aligned.
            COVBEAM_MISALIGNED if align_of::<T>() > 1 => {
                self.met.set(true);
                pointer.wrapping_byte_add(1)
            }
            _ => pointer,
        }
    }

    pub(crate) fn at_mut<T>(&self, index: usize, pointer: *mut T) -> *mut T {
        self.at(index, pointer.cast_const()).cast_mut()
    }
}

/// Calls with good arguments, then with each pointer NULL and misaligned and each number hostile in turn.
/// `call` returns the status and whether any output has changed.
pub(crate) fn refuses(
    pointers: usize,
    numbers: &[(f32, Rule)],
    call: impl Fn(&Bad, &[f32]) -> (covbeam_status, bool),
) {
    let good: Vec<f32> = numbers.iter().map(|(value, _)| *value).collect();
    let none = || Bad { index: usize::MAX, status: COVBEAM_OK, met: Cell::new(false) };
    assert_eq!(call(&none(), &good), (COVBEAM_OK, true));
    for index in 0..pointers {
        for status in [COVBEAM_NULL_POINTER, COVBEAM_MISALIGNED] {
            let bad = Bad { index, status, met: Cell::new(false) };
            let result = call(&bad, &good);
            if bad.met.get() {
                assert_eq!(result, (status, false), "pointer {index}");
            } else {
                assert_eq!(status, COVBEAM_MISALIGNED, "there is no pointer {index}");
            }
        }
    }
    for (i, (_, rule)) in numbers.iter().enumerate() {
        for hostile in NUMBERS {
            let mut changed = good.clone();
            changed[i] = hostile;
            let (status, touched) = call(&none(), &changed);
            let expected = if rule.takes(hostile) { COVBEAM_OK } else { COVBEAM_INVALID_VALUE };
            assert_eq!(status, expected, "number {i} = {hostile}, {rule:?}");
            assert!(status == COVBEAM_OK || !touched, "number {i} = {hostile}, {rule:?}");
        }
    }
}

/// What the thread's latest failure says.
pub(crate) fn message() -> String {
    // SAFETY: never NULL, and ends with NUL.
    unsafe { CStr::from_ptr(covbeam_last_error()) }.to_str().unwrap().to_owned()
}

/// An element of an array with a stride of its own.
#[repr(C)]
#[derive(Clone, Copy)]
pub(crate) struct Padded<T> {
    pub(crate) value: T,
    padding: u64,
}

/// Values with room between them.
pub(crate) fn padded<T: Copy>(values: &[T]) -> Vec<Padded<T>> {
    values.iter().map(|value| Padded { value: *value, padding: 0x5a5a_5a5a_5a5a_5a5a }).collect()
}

pub(crate) fn values<T: Copy>(padded: &[Padded<T>]) -> Vec<T> {
    assert!(
        padded.iter().all(|element| element.padding == 0x5a5a_5a5a_5a5a_5a5a),
        "written between elements"
    );
    padded.iter().map(|element| element.value).collect()
}
