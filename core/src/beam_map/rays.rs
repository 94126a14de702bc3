//! The columns along the eye rays of a packet, tabulated once however many batches of beams the rays meet.

use super::cancel::Stop;
use super::packet::PACKET;
use super::room::{make_room, tabulate};
use crate::beam::EyeRay;
use crate::medium::{Knot, Medium};
use core::ops::Range;
use std::vec::Vec;

/// Tables of the rays of one packet that met a beam; empty unless the density is a grid.
#[derive(Clone, Debug, Default)]
pub(super) struct RayTables {
    packet: usize,
    knots: Vec<Knot>,
    /// Where the table of each ray lies, if it was asked for.
    tables: Vec<Option<Range<usize>>>,
}

impl RayTables {
    /// Forgets the rays of the call before.
    pub(super) fn clear(&mut self) -> Result<(), Stop> {
        self.tables.clear();
        make_room(&mut self.tables, PACKET)?;
        self.begin(0);
        Ok(())
    }

    fn begin(&mut self, packet: usize) {
        self.packet = packet;
        self.knots.clear();
        self.tables.clear();
        self.tables.resize(PACKET, None);
    }

    /// Whether there is a table of the call's ray `index`.
    #[inline]
    pub(super) fn has(&self, index: usize) -> bool {
        index / PACKET == self.packet && self.tables[index % PACKET].is_some()
    }

    /// Makes the table of the call's ray `index`, which has none, and returns how many knots that took.
    /// Packets are asked for in order, their rays in any.
    pub(super) fn make(&mut self, index: usize, ray: &EyeRay, medium: &Medium) -> Result<usize, Stop> {
        let (packet, slot) = (index / PACKET, index % PACKET);
        if packet != self.packet {
            self.begin(packet);
        }
        let knots = &mut self.knots;
        let first = knots.len();
        tabulate(knots, medium, (ray.origin, ray.direction), ray.length)?;
        self.tables[slot] = Some(first..knots.len());
        Ok(knots.len() - first)
    }

    /// The table that was made for ray `index`.
    pub(super) fn of(&self, index: usize) -> &[Knot] {
        self.tables[index % PACKET].clone().map_or(&[], |table| &self.knots[table])
    }
}
