//! Memory, asked for before it is used: where there is none, the call ends and says how much it wanted.

use super::cancel::{Poll, STRETCH, Stop};
use crate::medium::{Knot, Medium};
use glam::Vec3;
use std::vec::Vec;

/// A vector with room for `capacity` elements.
pub(super) fn with_room<T>(capacity: usize) -> Result<Vec<T>, Stop> {
    let mut vector = Vec::new();
    make_room(&mut vector, capacity)?;
    Ok(vector)
}

/// Room for exactly `more` elements behind those of a vector.
pub(super) fn make_room<T>(vector: &mut Vec<T>, more: usize) -> Result<(), Stop> {
    vector.try_reserve_exact(more).map_err(|_| out_of_memory::<T>(vector.len().saturating_add(more)))
}

/// Room for `more` elements, and where that is not there yet for so many that asking again and again costs
/// little.
#[inline]
pub(super) fn grow<T>(vector: &mut Vec<T>, more: usize) -> Result<(), Stop> {
    vector.try_reserve(more).map_err(|_| out_of_memory::<T>(vector.len().saturating_add(more)))
}

#[cold]
fn out_of_memory<T>(elements: usize) -> Stop {
    Stop::OutOfMemory { bytes: elements.saturating_mul(size_of::<T>()) }
}

/// The elements of a vector, in no more memory than they need.
pub(super) fn fitted<T: Copy>(elements: &[T], poll: &mut Poll) -> Result<Vec<T>, Stop> {
    let mut fitted = with_room(elements.len())?;
    append(&mut fitted, elements, poll)?;
    Ok(fitted)
}

/// Appends elements for which there is room.
fn append<T: Copy>(to: &mut Vec<T>, elements: &[T], poll: &mut Poll) -> Result<(), Stop> {
    for stretch in elements.chunks(STRETCH) {
        poll.spend(stretch.len(), 1 + size_of::<T>() / 4)?;
        to.extend_from_slice(stretch);
    }
    Ok(())
}

/// Gives memory back, and asks: the system takes its time for it.
pub(super) fn release<T>(elements: Vec<T>, poll: &mut Poll) -> Result<(), Stop> {
    let pages = elements.capacity() * size_of::<T>() / 4096;
    drop(elements);
    poll.spend(pages, 100)
}

/// A vector in pieces of [`STRETCH`] elements: of a long one only the last piece moves when it grows.
pub(super) struct Pieces<T> {
    pieces: Vec<Vec<T>>,
}

impl<T: Copy> Pieces<T> {
    pub(super) fn new() -> Self {
        Self { pieces: Vec::new() }
    }

    pub(super) fn len(&self) -> usize {
        self.pieces.last().map_or(0, |last| (self.pieces.len() - 1) * STRETCH + last.len())
    }

    pub(super) fn push(&mut self, element: T) -> Result<(), Stop> {
        if self.len() == self.pieces.len() * STRETCH {
            grow(&mut self.pieces, 1)?;
            self.pieces.push(Vec::new());
        }
        let last = self.pieces.last_mut().expect("one that is not full");
        grow(last, 1)?;
        last.push(element);
        Ok(())
    }

    pub(super) fn set(&mut self, index: usize, element: T) {
        self.pieces[index / STRETCH][index % STRETCH] = element;
    }

    /// All of them one after the other, in no more memory than they need.
    pub(super) fn joined(self, poll: &mut Poll) -> Result<Vec<T>, Stop> {
        let mut joined = with_room(self.len())?;
        for piece in self.pieces {
            append(&mut joined, &piece, poll)?;
            release(piece, poll)?;
        }
        Ok(joined)
    }
}

/// Appends the knots of the table along a ray.
pub(super) fn tabulate(
    knots: &mut Vec<Knot>,
    medium: &Medium,
    (origin, direction): (Vec3, Vec3),
    length: f32,
) -> Result<(), Stop> {
    let mut room = Ok(());
    medium.tabulate(origin, direction, length, &mut |knot| {
        if knots.len() == knots.capacity() && room.is_ok() {
            room = grow(knots, 1);
        }
        if knots.len() < knots.capacity() {
            knots.push(knot);
        }
    });
    room
}
