//! Which beams the eye rays meet: the walk of packets through the hierarchy, and packets halved until few
//! rays test few sub-beams.

use super::bvh::Bvh;
use super::cancel::{Poll, Stop};
use super::eight::{Block, Lines, Pairs, Ray, fill};
use super::packet::{PACKET, Packet};
use super::room::make_room;
use super::simd::{LANES, bits};
use super::sub_beams::{ROOM, SubBeam};
use crate::beam::{BLOCK, Beam, BeamBlock, EyeRay};
use crate::kernel::Kernel;
use core::ops::Range;
use fearless_simd::{Level, Simd, dispatch};
use std::vec::Vec;

/// Sub-beams that are gathered at a time: with the blocks made of them, what a processor's own cache holds.
const BATCH: usize = 1 << 14;

/// Nodes visited between two questions to the host, where few are found on the way.
const VISITS: usize = 1 << 14;

/// Eye rays that test each other's sub-beams: fewer are not worth a packet of their own.
const FEW: usize = 16;

/// What is done with the pairs.
pub(super) trait Shade {
    /// Some pairs of ray `ray`.
    fn pairs<S: Simd>(&mut self, simd: S, ray: usize, pairs: &Pairs<S>, poll: &mut Poll) -> Result<(), Stop>;

    /// The rays of a packet have met all their beams.
    fn packet(&mut self, _: &mut Poll) -> Result<(), Stop> {
        Ok(())
    }
}

/// Buffers of a search, as large as [`Search::reserve`] says.
#[derive(Clone, Debug, Default)]
pub(super) struct Search {
    stack: Vec<u32>,
    /// Sub-beams that some ray of a packet may touch; then those that its halves may touch, and so on.
    sub_beams: Vec<SubBeam>,
    blocks: Vec<Block>,
}

/// What does not change during a search.
#[derive(Clone, Copy)]
pub(super) struct Query<'a> {
    /// The processor's vector instructions that are used.
    pub(super) level: Level,
    pub(super) beams: &'a [Beam],
    pub(super) bvh: &'a Bvh,
    pub(super) rays: &'a [EyeRay],
    pub(super) kernel: &'a Kernel<'a>,
}

impl Search {
    /// Gives `shade` the pairs of all rays, packet after packet, those of a ray in the order of the
    /// hierarchy.
    pub(super) fn all(&mut self, query: &Query, poll: &mut Poll, shade: &mut impl Shade) -> Result<(), Stop> {
        if query.bvh.nodes.is_empty() {
            return Ok(());
        }
        let count = query.rays.len();
        self.reserve(query.bvh, count.min(PACKET))?;
        for first in (0..count).step_by(PACKET) {
            self.packet(query, first..(first + PACKET).min(count), poll, shade)?;
            shade.packet(poll)?;
        }
        Ok(())
    }

    /// Room for all that packets of so many rays may find at a time: on the way no memory is asked for.
    fn reserve(&mut self, bvh: &Bvh, mut rays: usize) -> Result<(), Stop> {
        // A batch ends behind the node that fills it.
        let batch = bvh.sub_beams.len().min(BATCH + LANES * BLOCK);
        let mut levels = 1;
        while rays > FEW {
            rays = rays.div_ceil(2);
            levels += 1;
        }
        let Self { stack, sub_beams, blocks } = self;
        stack.clear();
        sub_beams.clear();
        blocks.clear();
        make_room(stack, bvh.most_waiting)?;
        make_room(sub_beams, levels * batch)?;
        make_room(blocks, batch.div_ceil(LANES))
    }

    /// The pairs of some rays, side by side or not.
    fn packet(
        &mut self,
        query: &Query,
        rays: Range<usize>,
        poll: &mut Poll,
        shade: &mut impl Shade,
    ) -> Result<(), Stop> {
        let Some(packet) = Packet::new(&query.rays[rays.clone()]) else {
            if rays.len() > 1 {
                for half in halves(rays) {
                    self.packet(query, half, poll, shade)?;
                }
            }
            return Ok(());
        };
        self.stack.clear();
        self.stack.push(0);
        while !self.stack.is_empty() {
            self.collect(query, &packet, poll)?;
            if !self.sub_beams.is_empty() {
                self.halve(query, rays.clone(), 0, poll, shade)?;
            }
        }
        Ok(())
    }

    /// Goes on with the walk that `stack` is in the middle of, until there is a batch or the walk is at its
    /// end.
    fn collect(&mut self, query: &Query, packet: &Packet, poll: &mut Poll) -> Result<(), Stop> {
        let Self { stack, sub_beams, .. } = self;
        sub_beams.clear();
        let (bvh, radius) = (query.bvh, query.kernel.max_radius);
        let visits = dispatch!(query.level, simd => walk(simd, bvh, packet, radius, stack, sub_beams, poll))?;
        poll.spend(visits + sub_beams.len(), 20)
    }

    /// Halves a packet until few rays are left; each half with those of the sub-beams from `first` on that it
    /// may touch.
    fn halve(
        &mut self,
        query: &Query,
        rays: Range<usize>,
        first: usize,
        poll: &mut Poll,
        shade: &mut impl Shade,
    ) -> Result<(), Stop> {
        if rays.len() <= FEW {
            return self.few(query, rays, first, poll, shade);
        }
        let end = self.sub_beams.len();
        for half in halves(rays) {
            if let Some(packet) = Packet::new(&query.rays[half.clone()]) {
                let (radius, sub_beams) = (query.kernel.max_radius, &mut self.sub_beams);
                dispatch!(query.level, simd => append_touched(simd, &packet, radius, sub_beams, first..end));
                poll.spend(end - first, 3)?;
            } else {
                // Rays apart, or one that is no ray.
                self.sub_beams.extend_from_within(first..end);
            }
            self.halve(query, half, end, poll, shade)?;
            self.sub_beams.truncate(end);
        }
        Ok(())
    }

    /// Each of a few rays tests each sub-beam from `first` on.
    fn few(
        &mut self,
        query: &Query,
        rays: Range<usize>,
        first: usize,
        poll: &mut Poll,
        shade: &mut impl Shade,
    ) -> Result<(), Stop> {
        let Self { sub_beams, blocks, .. } = self;
        let sub_beams = &sub_beams[first..];
        if sub_beams.is_empty() {
            return Ok(());
        }
        blocks.clear();
        blocks.resize(sub_beams.len().div_ceil(LANES), Block::EMPTY);
        for (block, sub_beams) in blocks.iter_mut().zip(sub_beams.chunks(LANES)) {
            block.fill(query.beams, sub_beams);
        }
        dispatch!(query.level, simd => meet(simd, query, rays, blocks, poll, shade))
    }
}

/// See [`Search::collect`]. Returns how many nodes it visited since it last told the poll.
#[inline(always)]
fn walk<S: Simd>(
    simd: S,
    bvh: &Bvh,
    packet: &Packet,
    radius: f32,
    stack: &mut Vec<u32>,
    sub_beams: &mut Vec<SubBeam>,
    poll: &mut Poll,
) -> Result<usize, Stop> {
    // A hierarchy built for wider kernels.
    let excess = bvh.padding - radius * ROOM;
    let mut visits = 0;
    while sub_beams.len() < BATCH
        && let Some(index) = stack.pop()
    {
        visits += 1;
        if visits == VISITS {
            poll.spend(VISITS, 30)?;
            visits = 0;
        }
        let node = &bvh.nodes[index as usize];
        let before = stack.len();
        for lane in bits(packet.touches_boxes(simd, node, excess)) {
            let first = node.first[lane];
            if node.count[lane] == 0 {
                stack.push(first);
            } else {
                let first = first as usize;
                let leaf = &bvh.sub_beams[first..first + node.count[lane] as usize];
                let mut lines = BeamBlock::EMPTY;
                fill(&mut lines, leaf);
                for lane in bits(packet.touches(simd, &lines, radius)) {
                    sub_beams.push(leaf[lane]);
                }
            }
        }
        stack[before..].reverse();
    }
    Ok(visits)
}

/// Appends those of the sub-beams `from` that a packet may touch, in their order.
#[inline(always)]
fn append_touched<S: Simd>(
    simd: S,
    packet: &Packet,
    radius: f32,
    sub_beams: &mut Vec<SubBeam>,
    from: Range<usize>,
) {
    let mut first = from.start;
    while first < from.end {
        let count = (from.end - first).min(LANES);
        let mut lines = BeamBlock::EMPTY;
        fill(&mut lines, &sub_beams[first..first + count]);
        for lane in bits(packet.touches(simd, &lines, radius)) {
            sub_beams.push(sub_beams[first + lane]);
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
    poll: &mut Poll,
    shade: &mut impl Shade,
) -> Result<(), Stop> {
    for index in rays {
        let ray = Ray::new(simd, &query.rays[index]);
        let mut met = 0;
        for block in blocks {
            let lines = Lines::new(simd, &ray, block);
            if let Some(pairs) = Pairs::new(simd, &ray, block, &lines, query.beams, query.kernel) {
                met += 1;
                shade.pairs(simd, index, &pairs, poll)?;
            }
            for lane in bits(lines.along(simd, &ray, block, query.kernel.max_radius)) {
                met += 1;
                if let Some(along) = block.along(lane, &query.rays[index], query.beams, query.kernel) {
                    let block = block.repeated(lane);
                    shade.pairs(simd, index, &Pairs::along(simd, &ray, &block, &along), poll)?;
                }
            }
        }
        poll.spend(blocks.len() + 60 * met, 5)?;
    }
    Ok(())
}

/// In the middle, which for the rays of square tiles is where the curve through them crosses it.
fn halves(rays: Range<usize>) -> [Range<usize>; 2] {
    let middle = rays.start + rays.len().div_ceil(2);
    [rays.start..middle, middle..rays.end]
}
