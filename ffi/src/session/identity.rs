//! What sums are told apart by: a hash of all that a host has given.

use ::covbeam_session::session::Identity;
use core::fmt::Debug;

/// Collects what a host gives.
#[derive(Clone, Default)]
pub(super) struct Contents(blake3::Hasher);

impl Contents {
    /// A struct of numbers, as text: its bytes would have gaps.
    pub(super) fn note(&mut self, given: &impl Debug) {
        let text = format!("{given:?}");
        self.bytes(text.as_bytes());
    }

    /// An array of numbers.
    pub(super) fn array<T: Copy>(&mut self, given: &[T]) {
        // SAFETY: arrays of floats and integers, which have no gaps; as many bytes as they are long.
        let bytes = unsafe { core::slice::from_raw_parts(given.as_ptr().cast::<u8>(), size_of_val(given)) };
        self.bytes(bytes);
    }

    fn bytes(&mut self, bytes: &[u8]) {
        self.0.update(&(bytes.len() as u64).to_le_bytes());
        self.0.update(bytes);
    }

    /// Of what was collected so far.
    pub(super) fn identity(&self) -> Identity {
        Identity(*self.0.finalize().as_bytes())
    }
}
