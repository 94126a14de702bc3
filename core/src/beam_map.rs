//! All beams of a pass that a packet of eye rays may touch, found through a bounding volume hierarchy.

use crate::beam::{BLOCK, Beam, BeamBlock, EyeRay, Gathered, Passage, gather_pair};
use crate::{Column, Density, KernelRadius, Knot, Medium};
use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::{Boundable, BvhBuildParams};
use std::time::Duration;
use std::vec::Vec;

/// Pieces that an average beam is cut into: a long beam's box is mostly empty.
const PIECES_PER_BEAM: f32 = 3.0;

/// A packet whose rays spread more than this (chord between unit directions) is gathered ray by ray.
const WIDEST_PACKET: f32 = 0.5;

/// A part `[from, to]` of a beam, with its end points.
#[derive(Clone, Copy, Debug)]
struct Piece {
    start: Vec3,
    end: Vec3,
    beam: u32,
    from: f32,
    to: f32,
}

/// A piece with the radius of the kernel around it, for the hierarchy's builder.
struct Capsule {
    start: Vec3A,
    end: Vec3A,
    radius: f32,
}

impl Boundable for Capsule {
    fn aabb(&self) -> Aabb {
        // An accepted eye point lies within `radius` of the segment, caps included (see `gather_pair`).
        let reach = Vec3A::splat(self.radius);
        Aabb::new(self.start.min(self.end) - reach, self.start.max(self.end) + reach)
    }
}

/// What the columns along the beams are computed from. A homogeneous medium stores nothing.
#[derive(Clone)]
enum BeamColumns {
    Uniform,
    /// The density at each beam's origin.
    Exponential(Vec<f32>),
    /// The tables of all beams one after the other; that of beam i is `first[i]..first[i + 1]`.
    Tables {
        knots: Vec<Knot>,
        first: Vec<u32>,
    },
}

/// The beams of one medium and one pass.
///
/// About 36 bytes a piece and 48 bytes a node (fewer nodes than pieces), on top of the beams themselves. An exponential
/// density adds 4 bytes a beam, a density grid 8 bytes a knot of the beams' columns ([`Density::knots`]).
#[derive(Clone)]
pub struct BeamMap {
    beams: Vec<Beam>,
    pieces: Vec<Piece>,
    hierarchy: Bvh2,
    columns: BeamColumns,
    ceiling: f32,
}

/// Buffers of a gather that a thread keeps between calls so that they are not allocated again.
#[derive(Clone, Debug, Default)]
pub struct GatherScratch {
    stack: Vec<u32>,
    pieces: Vec<Piece>,
    blocks: Vec<BeamBlock>,
    /// Of one eye ray's column.
    knots: Vec<Knot>,
}

impl BeamColumns {
    fn new(beams: &[Beam], medium: &Medium, density: &Density) -> Self {
        match density {
            Density::Uniform => Self::Uniform,
            Density::Exponential(_) => {
                Self::Exponential(beams.iter().map(|beam| density.at(beam.origin)).collect())
            }
            Density::Grid(_) => {
                let (mut knots, mut first) = (Vec::new(), Vec::with_capacity(beams.len() + 1));
                for beam in beams {
                    first.push(knots.len() as u32);
                    let Beam { origin, direction, length, .. } = *beam;
                    density.tabulate(medium, origin, direction, length, &mut |knot| knots.push(knot));
                }
                first.push(knots.len() as u32);
                Self::Tables { knots, first }
            }
        }
    }

    #[inline]
    fn of<'a>(&'a self, index: usize, beam: &Beam, density: &Density) -> Column<'a> {
        match (self, density) {
            (Self::Exponential(densities), Density::Exponential(exponential)) => {
                Column::Exponential { density: densities[index], rate: exponential.rate(beam.direction) }
            }
            (Self::Tables { knots, first }, _) => {
                Column::Knots(&knots[first[index] as usize..first[index + 1] as usize])
            }
            _ => Column::Uniform,
        }
    }
}

impl BeamMap {
    /// Builds the hierarchy over `beams`, to be gathered with kernels no wider than `ceiling` \[m\], and the columns along
    /// them.
    ///
    /// - `medium`, `density`: what the beams are in, and will be gathered in.
    ///
    /// Beams that cannot contribute are left out: length not > 0 and finite, origin, direction or power not finite.
    /// The result depends on nothing but the arguments.
    pub fn build(mut beams: Vec<Beam>, ceiling: f32, medium: &Medium, density: &Density) -> Self {
        beams.retain(|beam| {
            beam.length > 0.0
                && beam.length.is_finite()
                && beam.origin.is_finite()
                && beam.direction.is_finite()
                && beam.power.is_finite()
        });
        let columns = BeamColumns::new(&beams, medium, density);
        let total: f64 = beams.iter().map(|beam| f64::from(beam.length)).sum();
        let longest = (total / (f64::from(PIECES_PER_BEAM) * beams.len().max(1) as f64)) as f32;
        let mut pieces = Vec::with_capacity((PIECES_PER_BEAM as usize + 1) * beams.len());
        for (index, beam) in beams.iter().enumerate() {
            let count = libm::ceilf(beam.length / longest).max(1.0) as u32;
            let at = |i: u32| if i == count { beam.length } else { beam.length * (i as f32 / count as f32) };
            for i in 0..count {
                let (from, to) = (at(i), at(i + 1));
                let start = beam.origin + from * beam.direction;
                let end = beam.origin + to * beam.direction;
                pieces.push(Piece { start, end, beam: index as u32, from, to });
            }
        }
        if pieces.is_empty() {
            return Self { beams, pieces, hierarchy: Bvh2::default(), columns, ceiling };
        }
        let capsules: Vec<Capsule> = pieces
            .iter()
            .map(|piece| Capsule { start: piece.start.into(), end: piece.end.into(), radius: ceiling })
            .collect();
        let params = BvhBuildParams { max_prims_per_leaf: BLOCK as u32, ..BvhBuildParams::fastest_build() };
        let mut hierarchy = build_bvh2(&capsules, params, &mut Duration::default());
        // Pieces in the order of the leaves: a leaf's pieces are neighbours in memory.
        let ordered = hierarchy.primitive_indices.iter().map(|&i| pieces[i as usize]).collect();
        hierarchy.primitive_indices = Vec::new();
        Self { beams, pieces: ordered, hierarchy, columns, ceiling }
    }

    /// The beams that were kept, in the order they were given.
    pub fn beams(&self) -> &[Beam] {
        &self.beams
    }

    /// Bytes held.
    pub fn memory(&self) -> usize {
        self.beams.capacity() * size_of::<Beam>()
            + self.pieces.capacity() * size_of::<Piece>()
            + self.hierarchy.nodes.capacity() * size_of::<obvhs::bvh2::node::Bvh2Node>()
            + match &self.columns {
                BeamColumns::Uniform => 0,
                BeamColumns::Exponential(densities) => densities.capacity() * size_of::<f32>(),
                BeamColumns::Tables { knots, first } => {
                    knots.capacity() * size_of::<Knot>() + first.capacity() * size_of::<u32>()
                }
            }
    }

    /// Adds to `gathered[i]` what ray `rays[i]` gathers from all beams (see [`gather_pair`]).
    ///
    /// The rays of a call share one walk through the hierarchy: give those that run side by side together (the rays of
    /// a tile of pixels). Any rays are gathered correctly. `medium` and `density` are those given to [`BeamMap::build`]. In
    /// a density grid each ray's column is tabulated once, to 5e-4 of the transmittance. `radius.ceiling` must not exceed the one given to
    /// [`BeamMap::build`]; a larger one is cut to it.
    ///
    /// # Panics
    /// If `rays` and `gathered` differ in length.
    pub fn gather(
        &self,
        rays: &[EyeRay],
        medium: &Medium,
        density: &Density,
        radius: &KernelRadius,
        gathered: &mut [Gathered],
        scratch: &mut GatherScratch,
    ) {
        assert_eq!(rays.len(), gathered.len());
        if self.pieces.is_empty() || rays.is_empty() {
            return;
        }
        let radius = KernelRadius { ceiling: radius.ceiling.min(self.ceiling), ..*radius };
        match Packet::new(rays) {
            Some(packet) => {
                self.collect(&packet, radius.ceiling, scratch);
                for (ray, gathered) in rays.iter().zip(gathered) {
                    self.gather_candidates(ray, medium, density, &radius, gathered, scratch);
                }
            }
            None => {
                for (ray, gathered) in rays.iter().zip(gathered) {
                    if let Some(packet) = Packet::new(core::slice::from_ref(ray)) {
                        self.collect(&packet, radius.ceiling, scratch);
                        self.gather_candidates(ray, medium, density, &radius, gathered, scratch);
                    }
                }
            }
        }
    }

    /// Fills `scratch` with the pieces that some ray of the packet may touch.
    fn collect(&self, packet: &Packet, radius: f32, scratch: &mut GatherScratch) {
        let GatherScratch { stack, pieces, blocks, .. } = scratch;
        pieces.clear();
        stack.clear();
        stack.push(0);
        while let Some(index) = stack.pop() {
            let node = &self.hierarchy.nodes[index as usize];
            if !packet.touches_box(node.aabb()) {
                continue;
            }
            if node.prim_count == 0 {
                stack.extend([node.first_index + 1, node.first_index]);
            } else {
                let first = node.first_index as usize;
                let leaf = &self.pieces[first..first + node.prim_count as usize];
                pieces.extend(leaf.iter().filter(|piece| packet.touches_piece(piece, radius)));
            }
        }
        blocks.clear();
        for chunk in pieces.chunks(BLOCK) {
            let mut block = BeamBlock::EMPTY;
            for (slot, piece) in chunk.iter().enumerate() {
                block.set(slot, &self.beams[piece.beam as usize], piece.from, piece.to);
            }
            blocks.push(block);
        }
    }

    fn gather_candidates(
        &self,
        ray: &EyeRay,
        medium: &Medium,
        density: &Density,
        radius: &KernelRadius,
        gathered: &mut Gathered,
        scratch: &mut GatherScratch,
    ) {
        let GatherScratch { pieces, blocks, knots, .. } = scratch;
        if blocks.is_empty() {
            return;
        }
        knots.clear();
        density.tabulate(medium, ray.origin, ray.direction, ray.length, &mut |knot| knots.push(knot));
        let ray_column = density.column(ray.origin, ray.direction, knots);
        for (block, pieces) in blocks.iter().zip(pieces.chunks(BLOCK)) {
            let mut mask = block.test(ray, radius.ceiling);
            while mask != 0 {
                let piece = &pieces[mask.trailing_zeros() as usize];
                mask &= mask - 1;
                let index = piece.beam as usize;
                let beam = &self.beams[index];
                let passage = Passage {
                    medium,
                    density: *density,
                    ray: ray_column,
                    beam: self.columns.of(index, beam, density),
                };
                gather_pair(ray, beam, piece.from, piece.to, &passage, radius, gathered);
            }
        }
    }
}

/// A cone-like hull of some eye rays: the point at distance t of each lies within `spread + slope t` of the point
/// `origin + t axis`.
struct Packet {
    origin: Vec3,
    axis: Vec3,
    tangents: [Vec3; 2],
    inverse_axis: Vec3A,
    length: f32,
    spread: f32,
    slope: f32,
}

impl Packet {
    /// None if the rays have no common direction (or one is NaN).
    fn new(rays: &[EyeRay]) -> Option<Self> {
        let count = rays.len() as f32;
        let origin = rays.iter().map(|ray| ray.origin).sum::<Vec3>() / count;
        let axis = rays.iter().map(|ray| ray.direction).sum::<Vec3>().try_normalize()?;
        let spread = rays.iter().map(|ray| ray.origin.distance(origin)).fold(0.0, f32::max);
        let slope = rays.iter().map(|ray| ray.direction.distance(axis)).fold(0.0, f32::max);
        let length = rays.iter().map(|ray| ray.length).fold(0.0, f32::max);
        if !(slope <= WIDEST_PACKET && spread.is_finite()) {
            return None;
        }
        let tangents = axis.any_orthonormal_pair();
        // Rounding of origins far from the world's origin and of the axis.
        let scale = origin.abs().max_element();
        Some(Self {
            origin,
            axis,
            tangents: [tangents.0, tangents.1],
            inverse_axis: Vec3A::from(axis.to_array().map(|a| if a.abs() < 1e-20 { 1e20 } else { 1.0 / a })),
            length,
            spread: spread + 4.0 * f32::EPSILON * scale,
            slope: slope + 4.0 * f32::EPSILON,
        })
    }

    /// Half-width of the hull where the axial coordinate is `depth` or less.
    ///
    /// The point at distance t of a ray has an axial coordinate of at least `t (1 - slope²/2) - spread`.
    fn width(&self, depth: f32) -> f32 {
        let farthest = (depth + self.spread).max(0.0) / (1.0 - 0.5 * self.slope * self.slope);
        self.spread + self.slope * farthest.min(self.length)
    }

    fn touches_box(&self, aabb: &Aabb) -> bool {
        let origin = Vec3A::from(self.origin);
        let axis = Vec3A::from(self.axis);
        let half = 0.5 * (aabb.max - aabb.min);
        let center = 0.5 * (aabb.max + aabb.min) - origin;
        let (along, extent) = (center.dot(axis), half.dot(axis.abs()));
        let depth = along + extent;
        let width = self.width(depth);
        let grown = half + Vec3A::splat(width);
        // Slabs of the grown box against the axis.
        let near = (center - grown) * self.inverse_axis;
        let far = (center + grown) * self.inverse_axis;
        let enter = near.min(far).max_element();
        let leave = near.max(far).min_element();
        enter.max(-width) <= leave.min(self.length + width)
    }

    fn touches_piece(&self, piece: &Piece, radius: f32) -> bool {
        let (a, b) = (piece.start - self.origin, piece.end - self.origin);
        let (depth_a, depth_b) = (a.dot(self.axis), b.dot(self.axis));
        let [e, f] = self.tangents;
        let (ax, ay) = (a.dot(e), a.dot(f));
        let (ux, uy) = (b.dot(e) - ax, b.dot(f) - ay);
        let length2 = ux * ux + uy * uy;
        let s = if length2 > 0.0 { (-(ax * ux + ay * uy) / length2).clamp(0.0, 1.0) } else { 0.0 };
        let (x, y) = (ax + s * ux, ay + s * uy);
        let (nearest, farthest) = (depth_a.min(depth_b) - radius, depth_a.max(depth_b) + radius);
        let width = self.width(farthest) + radius;
        x * x + y * y <= width * width && farthest >= -self.spread && nearest <= self.length + self.spread
    }
}
