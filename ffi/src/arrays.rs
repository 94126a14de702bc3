//! Calls on arrays: everything is checked before anything is written, since a host would not look at a
//! status an element.

use crate::memory::Outputs;
use crate::status::Failure;

/// Checks the arguments of every element, then hands them on in their order.
pub(crate) fn each<A>(
    count: usize,
    arguments: impl Fn(usize) -> Result<A, Failure>,
    mut apply: impl FnMut(usize, A),
) -> Result<(), Failure> {
    for i in 0..count {
        arguments(i)?;
    }
    for i in 0..count {
        apply(i, arguments(i)?);
    }
    Ok(())
}

/// Checks every argument, then writes the results.
pub(crate) fn write<A, T: Copy>(
    mut out: Outputs<T>,
    arguments: impl Fn(usize) -> Result<A, Failure>,
    result: impl Fn(A) -> T,
) -> Result<(), Failure> {
    each(out.count(), arguments, |i, argument| out.set(i, result(argument)))
}
