//! The columns along the eye rays of a packet, tabulated once however many batches of beams the rays meet.

use super::PACKET;
use crate::{Density, EyeRay, Knot, Medium};
use std::vec::Vec;

/// Tables of the rays of one packet, one after the other; empty unless the density is a grid.
#[derive(Clone, Debug, Default)]
pub(super) struct RayTables {
    packet: usize,
    knots: Vec<Knot>,
    /// Where the table of each ray ends.
    ends: Vec<usize>,
}

impl RayTables {
    /// Forgets the rays of the call before.
    pub(super) fn clear(&mut self) {
        self.begin(0);
    }

    fn begin(&mut self, packet: usize) {
        self.packet = packet;
        self.knots.clear();
        self.ends.clear();
    }

    /// The table of the call's ray `index`. Rays are asked for in order; those of the latest packet again and again.
    pub(super) fn of(&mut self, index: usize, ray: &EyeRay, medium: &Medium, density: &Density) -> &[Knot] {
        let (packet, slot) = (index / PACKET, index % PACKET);
        if packet != self.packet {
            self.begin(packet);
        }
        // Rays that touch nothing are not asked for: empty tables.
        while self.ends.len() < slot {
            self.ends.push(self.knots.len());
        }
        if self.ends.len() == slot {
            let knots = &mut self.knots;
            density.tabulate(medium, ray.origin, ray.direction, ray.length, &mut |knot| knots.push(knot));
            self.ends.push(self.knots.len());
        }
        let start = slot.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.knots[start..self.ends[slot]]
    }
}
