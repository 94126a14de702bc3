//! Which beams the eye rays meet: the walk of packets through the tree, and the test of rays against what it finds.

use super::meter::{Meter, Stop};
use super::packet::Packet;
use super::pieces::Piece;
use super::tree::Tree;
use super::{Contact, PACKET};
use crate::KernelRadius;
use crate::beam::{BLOCK, Beam, BeamBlock, EyeRay, Meeting, cos_theta, meet};
use core::ops::Range;
use std::vec::Vec;

/// Pieces that are gathered at a time: with the blocks made of them, what a processor's own cache holds.
const BATCH: usize = 1 << 14;

/// Nodes visited between two questions to the host, where few are found on the way.
const VISITS: usize = 1 << 14;

/// Contacts that are settled at a time.
const CONTACTS: usize = 256;

/// Buffers of a search.
#[derive(Clone, Debug, Default)]
pub(super) struct Search {
    stack: Vec<u32>,
    candidates: Candidates,
    contacts: Vec<Contact>,
}

/// Pieces that some ray of a packet may touch, and the same in blocks.
#[derive(Clone, Debug, Default)]
struct Candidates {
    pieces: Vec<Piece>,
    blocks: Vec<BeamBlock>,
}

impl Search {
    /// Gives `settle` the contacts of all rays: up to 256 at a time, all of one packet, those of a ray in the order of the tree.
    pub(super) fn all(
        &mut self,
        beams: &[Beam],
        tree: &Tree,
        rays: &[EyeRay],
        radius: &KernelRadius,
        meter: &mut Meter,
        settle: &mut impl FnMut(&[Contact], &mut Meter) -> Result<(), Stop>,
    ) -> Result<(), Stop> {
        self.contacts.clear();
        for first in (0..rays.len()).step_by(PACKET) {
            let all = first..(first + PACKET).min(rays.len());
            if let Some(packet) = Packet::new(&rays[all.clone()]) {
                self.packet(beams, tree, &packet, rays, all, radius, meter, settle)?;
            } else {
                for index in all {
                    if let Some(packet) = Packet::new(&rays[index..=index]) {
                        self.packet(beams, tree, &packet, rays, index..index + 1, radius, meter, settle)?;
                    }
                }
            }
            if !self.contacts.is_empty() {
                settle(&self.contacts, meter)?;
                self.contacts.clear();
            }
        }
        Ok(())
    }

    /// The contacts of the rays of one packet; less than a batch of them is left in `contacts`.
    #[allow(clippy::too_many_arguments)] // Each is another thing; none has a home in another.
    fn packet(
        &mut self,
        beams: &[Beam],
        tree: &Tree,
        packet: &Packet,
        rays: &[EyeRay],
        indices: Range<usize>,
        radius: &KernelRadius,
        meter: &mut Meter,
        settle: &mut impl FnMut(&[Contact], &mut Meter) -> Result<(), Stop>,
    ) -> Result<(), Stop> {
        let Self { stack, candidates, contacts } = self;
        stack.clear();
        if !tree.nodes.is_empty() {
            stack.push(0);
        }
        while !stack.is_empty() {
            candidates.collect(tree, packet, radius.ceiling, stack, meter)?;
            if candidates.pieces.is_empty() {
                continue;
            }
            candidates.fill_blocks(beams);
            for index in indices.clone() {
                // Each ray tests each block.
                meter.spend(candidates.blocks.len(), 20)?;
                let mut found = |contact: Contact| {
                    contacts.push(contact);
                    if contacts.len() < CONTACTS {
                        return Ok(());
                    }
                    settle(contacts, meter)?;
                    contacts.clear();
                    Ok(())
                };
                let tested = candidates.meet(beams, &rays[index], index as u32, radius, &mut found)?;
                meter.spend(tested, 100)?;
            }
        }
        Ok(())
    }
}

impl Candidates {
    /// Goes on with the walk that `stack` is in the middle of, until there is a batch or the walk is at its end.
    fn collect(
        &mut self,
        tree: &Tree,
        packet: &Packet,
        radius: f32,
        stack: &mut Vec<u32>,
        meter: &mut Meter,
    ) -> Result<(), Stop> {
        let pieces = &mut self.pieces;
        pieces.clear();
        let mut visits = 0;
        while pieces.len() < BATCH
            && let Some(index) = stack.pop()
        {
            visits += 1;
            if visits == VISITS {
                meter.spend(VISITS, 30)?;
                visits = 0;
            }
            let node = &tree.nodes[index as usize];
            if !packet.touches_box(node) {
                continue;
            }
            if node.count == 0 {
                stack.extend([node.first + 1, node.first]);
            } else {
                let first = node.first as usize;
                let leaf = &tree.pieces[first..first + node.count as usize];
                pieces.extend(leaf.iter().filter(|piece| packet.touches_piece(piece, radius)));
            }
        }
        meter.spend(visits + pieces.len(), 30)
    }

    fn fill_blocks(&mut self, beams: &[Beam]) {
        self.blocks.clear();
        for pieces in self.pieces.chunks(BLOCK) {
            let mut block = BeamBlock::EMPTY;
            for (slot, piece) in pieces.iter().enumerate() {
                block.set(slot, &beams[piece.beam as usize], piece.from, piece.to);
            }
            self.blocks.push(block);
        }
    }

    /// Gives `found` the contacts of one ray, and returns how many pieces came near it.
    #[inline(never)] // The hot loop compiles to fewer instructions on its own.
    fn meet(
        &self,
        beams: &[Beam],
        ray: &EyeRay,
        index: u32,
        radius: &KernelRadius,
        found: &mut impl FnMut(Contact) -> Result<(), Stop>,
    ) -> Result<usize, Stop> {
        let mut tested = 0;
        for (block, pieces) in self.blocks.iter().zip(self.pieces.chunks(BLOCK)) {
            let mut mask = block.test(ray, radius.ceiling);
            while mask != 0 {
                let piece = &pieces[mask.trailing_zeros() as usize];
                mask &= mask - 1;
                tested += 1;
                let beam = &beams[piece.beam as usize];
                let Some(meeting) = meet(ray, beam, piece.from, piece.to, radius) else { continue };
                let Meeting { point, crossing, radius: r, sigma } = meeting;
                found(Contact {
                    position: point,
                    ray: index,
                    beam: piece.beam,
                    ray_distance: crossing.ray_distance,
                    beam_distance: crossing.beam_distance,
                    cos_theta: cos_theta(ray, beam),
                    kernel: radius.kernel.evaluate(crossing.gap, r) / crossing.sin_theta,
                    radius: r,
                    sigma,
                })?;
            }
        }
        Ok(tested)
    }
}
