//! Which beams the eye rays meet: the walk of packets through the tree, and packets halved until few rays test few pieces.

use super::PACKET;
use super::lanes::{Block, LANES, Lanes, Ray, bits, fill};
use super::meter::{Meter, Stop};
use super::packet::{Packet, ROOM};
use super::pieces::Piece;
use super::tree::Tree;
use crate::KernelRadius;
use crate::beam::{Beam, BeamBlock, EyeRay};
use core::ops::Range;
use fearless_simd::{Level, Simd, dispatch};
use std::vec::Vec;

/// Pieces that are gathered at a time: with the blocks made of them, what a processor's own cache holds.
const BATCH: usize = 1 << 14;

/// Nodes visited between two questions to the host, where few are found on the way.
const VISITS: usize = 1 << 14;

/// Eye rays that test each other's pieces: fewer are not worth a packet of their own.
const FEW: usize = 16;

/// What is done with the pairs.
pub(super) trait Settle {
    /// Some pairs of ray `ray`.
    fn pairs<S: Simd>(
        &mut self,
        simd: S,
        ray: usize,
        pairs: &Lanes<S>,
        meter: &mut Meter,
    ) -> Result<(), Stop>;

    /// The rays of a packet have met all their beams.
    fn packet(&mut self, meter: &mut Meter) -> Result<(), Stop>;
}

/// Buffers of a search.
#[derive(Clone, Debug, Default)]
pub(super) struct Search {
    stack: Vec<u32>,
    /// Pieces that some ray of a packet may touch; then those that its halves may touch, and so on.
    pieces: Vec<Piece>,
    blocks: Vec<Block>,
}

/// What does not change during a search.
#[derive(Clone, Copy)]
struct Query<'a> {
    level: Level,
    beams: &'a [Beam],
    tree: &'a Tree,
    rays: &'a [EyeRay],
    radius: &'a KernelRadius<'a>,
}

impl Search {
    /// Gives `settle` the pairs of all rays, packet after packet, those of a ray in the order of the tree.
    pub(super) fn all(
        &mut self,
        beams: &[Beam],
        tree: &Tree,
        rays: &[EyeRay],
        radius: &KernelRadius,
        meter: &mut Meter,
        settle: &mut impl Settle,
    ) -> Result<(), Stop> {
        if tree.nodes.is_empty() {
            return Ok(());
        }
        let query = Query { level: Level::new(), beams, tree, rays, radius };
        for first in (0..rays.len()).step_by(PACKET) {
            self.packet(&query, first..(first + PACKET).min(rays.len()), meter, settle)?;
            settle.packet(meter)?;
        }
        Ok(())
    }

    /// The pairs of some rays, side by side or not.
    fn packet(
        &mut self,
        query: &Query,
        rays: Range<usize>,
        meter: &mut Meter,
        settle: &mut impl Settle,
    ) -> Result<(), Stop> {
        let Some(packet) = Packet::new(&query.rays[rays.clone()]) else {
            if rays.len() > 1 {
                for half in halves(rays) {
                    self.packet(query, half, meter, settle)?;
                }
            }
            return Ok(());
        };
        self.stack.clear();
        self.stack.push(0);
        while !self.stack.is_empty() {
            self.collect(query, &packet, meter)?;
            if !self.pieces.is_empty() {
                self.halve(query, rays.clone(), 0, meter, settle)?;
            }
        }
        Ok(())
    }

    /// Goes on with the walk that `stack` is in the middle of, until there is a batch or the walk is at its end.
    fn collect(&mut self, query: &Query, packet: &Packet, meter: &mut Meter) -> Result<(), Stop> {
        let Self { stack, pieces, .. } = self;
        pieces.clear();
        let (tree, radius) = (query.tree, query.radius.ceiling);
        let visits = dispatch!(query.level, simd => walk(simd, tree, packet, radius, stack, pieces, meter))?;
        meter.spend(visits + pieces.len(), 20)
    }

    /// Halves a packet until few rays are left; each half with those of the pieces from `first` on that it may touch.
    fn halve(
        &mut self,
        query: &Query,
        rays: Range<usize>,
        first: usize,
        meter: &mut Meter,
        settle: &mut impl Settle,
    ) -> Result<(), Stop> {
        if rays.len() <= FEW {
            return self.few(query, rays, first, meter, settle);
        }
        let end = self.pieces.len();
        for half in halves(rays) {
            if let Some(packet) = Packet::new(&query.rays[half.clone()]) {
                self.append_touched(query, &packet, first..end);
                meter.spend(end - first, 3)?;
            } else {
                // Rays apart, or one that is no ray.
                self.pieces.extend_from_within(first..end);
            }
            self.halve(query, half, end, meter, settle)?;
            self.pieces.truncate(end);
        }
        Ok(())
    }

    /// Appends those of the pieces `from` that a packet may touch, in their order.
    fn append_touched(&mut self, query: &Query, packet: &Packet, from: Range<usize>) {
        let pieces = &mut self.pieces;
        pieces.reserve(from.len());
        dispatch!(query.level, simd => append_touched(simd, packet, query.radius.ceiling, pieces, from));
    }

    /// Each of a few rays tests each piece from `first` on.
    fn few(
        &mut self,
        query: &Query,
        rays: Range<usize>,
        first: usize,
        meter: &mut Meter,
        settle: &mut impl Settle,
    ) -> Result<(), Stop> {
        let Self { pieces, blocks, .. } = self;
        let pieces = &pieces[first..];
        if pieces.is_empty() {
            return Ok(());
        }
        blocks.clear();
        blocks.resize(pieces.len().div_ceil(LANES), Block::EMPTY);
        for (block, pieces) in blocks.iter_mut().zip(pieces.chunks(LANES)) {
            block.fill(query.beams, pieces);
        }
        dispatch!(query.level, simd => meet(simd, query, rays, blocks, meter, settle))
    }
}

/// See [`Search::collect`]. Returns how many nodes it visited since it last told the meter.
#[inline(always)]
fn walk<S: Simd>(
    simd: S,
    tree: &Tree,
    packet: &Packet,
    radius: f32,
    stack: &mut Vec<u32>,
    pieces: &mut Vec<Piece>,
    meter: &mut Meter,
) -> Result<usize, Stop> {
    // A tree built for wider kernels.
    let excess = tree.reach - radius * ROOM;
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
        let before = stack.len();
        for lane in bits(packet.touches_boxes(simd, node, excess)) {
            let first = node.first[lane];
            if node.count[lane] == 0 {
                stack.push(first);
            } else {
                let first = first as usize;
                let leaf = &tree.pieces[first..first + node.count[lane] as usize];
                let mut lines = BeamBlock::EMPTY;
                fill(&mut lines, leaf);
                for lane in bits(packet.touches(simd, &lines, radius)) {
                    pieces.push(leaf[lane]);
                }
            }
        }
        stack[before..].reverse();
    }
    Ok(visits)
}

/// See [`Search::append_touched`].
#[inline(always)]
fn append_touched<S: Simd>(
    simd: S,
    packet: &Packet,
    radius: f32,
    pieces: &mut Vec<Piece>,
    from: Range<usize>,
) {
    let mut first = from.start;
    while first < from.end {
        let count = (from.end - first).min(LANES);
        let mut lines = BeamBlock::EMPTY;
        fill(&mut lines, &pieces[first..first + count]);
        for lane in bits(packet.touches(simd, &lines, radius)) {
            pieces.push(pieces[first + lane]);
        }
        first += count;
    }
}

/// Each of some rays meets each of some blocks.
#[inline(always)]
fn meet<S: Simd>(
    simd: S,
    query: &Query,
    rays: Range<usize>,
    blocks: &[Block],
    meter: &mut Meter,
    settle: &mut impl Settle,
) -> Result<(), Stop> {
    for index in rays {
        let ray = Ray::new(simd, &query.rays[index]);
        let mut met = 0;
        for block in blocks {
            if let Some(pairs) = Lanes::new(simd, &ray, block, query.beams, query.radius) {
                met += 1;
                settle.pairs(simd, index, &pairs, meter)?;
            }
        }
        meter.spend(blocks.len() + 20 * met, 5)?;
    }
    Ok(())
}

/// In the middle, which for the rays of square tiles is where the curve through them crosses it.
fn halves(rays: Range<usize>) -> [Range<usize>; 2] {
    let middle = rays.start + rays.len().div_ceil(2);
    [rays.start..middle, middle..rays.end]
}
