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
    for stretch in elements.chunks(STRETCH) {
        poll.spend(stretch.len(), 1 + size_of::<T>() / 16)?;
        fitted.extend_from_slice(stretch);
    }
    Ok(fitted)
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
