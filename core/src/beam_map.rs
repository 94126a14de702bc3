//! All beams of a pass that a packet of eye rays may touch, found through a bounding volume hierarchy.

mod columns;
mod meter;
mod packet;
mod pieces;
mod rays;
mod tree;

pub use meter::Stop;

use crate::beam::{BLOCK, Beam, BeamBlock, EyeRay, Gathered, Meeting, Passage, cos_theta, gather_pair, meet};
use crate::{Column, Density, KernelRadius, Medium};
use columns::BeamColumns;
use glam::Vec3;
use meter::Meter;
use packet::Packet;
use pieces::{PIECES_PER_BEAM, Piece, tickets};
use rays::RayTables;
use std::vec::Vec;
use tree::{Node, Tree};

/// The most beams that a [`BeamMap`] takes, 2²⁸: their pieces, and the nodes over these, are counted in 32 bits.
pub const MAX_BEAMS: usize = 1 << 28;

// At most a piece more a beam than on average, a node less than two a piece, and room for rounding.
const _: () = assert!(2 * (PIECES_PER_BEAM + 1) * MAX_BEAMS <= 1 << 31);

/// Eye rays that share a walk through the hierarchy.
const PACKET: usize = 64;

/// Pieces that are gathered at a time: with the blocks made of them, what a processor's own cache holds.
const BATCH: usize = 1 << 14;

/// Nodes visited between two questions to the host, where few are found on the way.
const VISITS: usize = 1 << 14;

/// Contacts that the host is given at a time.
const CONTACTS: usize = 256;

/// The beams of one medium and one pass.
///
/// About 36 bytes a piece and 32 bytes a node (one to two nodes a piece; up to four pieces a beam), on top of the beams
/// themselves. An exponential density adds 4 bytes a beam, a density grid 8 bytes a knot of the beams' columns
/// ([`Density::knots`]).
#[derive(Clone)]
pub struct BeamMap {
    beams: Vec<Beam>,
    tree: Tree,
    columns: BeamColumns,
    ceiling: f32,
}

/// Beams that did not become a [`BeamMap`].
#[derive(Clone, Debug)]
pub struct Unfinished {
    /// As they were given.
    pub beams: Vec<Beam>,
    /// Why.
    pub reason: Stop,
}

/// An eye ray that meets a beam, for a host that knows the medium ([`BeamMap::gather_contacts`]).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Contact {
    /// The point on the eye ray that is closest to the beam \[m\].
    pub position: Vec3,
    /// Which eye ray: index in the call's rays.
    pub ray: u32,
    /// Which beam: index in the order in which the beams were given.
    pub beam: u32,
    /// Distance of the position from the start of the eye ray \[m\], in \[0, length\].
    pub ray_distance: f32,
    /// Distance along the beam of its point closest to the eye ray \[m\]: within the beam, or out of it by less than
    /// `radius` at an end that a surface cuts at a slant.
    pub beam_distance: f32,
    /// dot(propagation of the beam's light, propagation of light to the eye): forward is +1. What
    /// [`crate::PhaseFunction::evaluate`] takes; rounding may carry it past ±1.
    pub cos_theta: f32,
    /// K_r(d)/sin θ \[1/m\]: what the pair's product is multiplied by, besides the beam's power.
    pub kernel: f32,
    /// The kernel's radius r \[m\].
    pub radius: f32,
    /// σ along the kernel's axis \[cycles/m\], 0 where the grid has no data.
    pub sigma: f32,
}

/// Buffers of a gather that a thread keeps between calls so that they are not allocated again.
///
/// About 1.5 MB at most, and 8 bytes a knot of 64 eye rays' columns, however many beams there are.
#[derive(Clone, Debug, Default)]
pub struct GatherScratch {
    stack: Vec<u32>,
    candidates: Candidates,
    tables: RayTables,
    contacts: Vec<Contact>,
    products: Vec<Vec3>,
}

/// Pieces that some ray of a packet may touch, and the same in blocks.
#[derive(Clone, Debug, Default)]
struct Candidates {
    pieces: Vec<Piece>,
    blocks: Vec<BeamBlock>,
}

impl Candidates {
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
}

impl BeamMap {
    /// [`BeamMap::build_while`] with a host that always goes on.
    ///
    /// # Panics
    /// If there are more than [`MAX_BEAMS`] beams, or memory cannot be had.
    pub fn build(beams: Vec<Beam>, ceiling: f32, medium: &Medium, density: &Density) -> Self {
        match Self::build_while(beams, ceiling, medium, density, &mut || true) {
            Ok(map) => map,
            Err(unfinished) => panic!("a map of {} beams: {}", unfinished.beams.len(), unfinished.reason),
        }
    }

    /// Builds the hierarchy over `beams`, to be gathered with kernels no wider than `ceiling` \[m\], and the columns along
    /// them, as long as `go_on` says so.
    ///
    /// - `medium`, `density`: what the beams are in, and will be gathered in.
    /// - `go_on`: asked at the start and about once in a millisecond; false stops. The work between two questions is bounded
    ///   whatever the beams; in a density grid it also grows with the voxels along one beam.
    ///
    /// Beams that cannot contribute are kept, but never found: length not > 0 and finite; origin, direction, power or end
    /// not finite. The result depends on nothing but the arguments.
    ///
    /// Errors: stopped, out of memory, or more than [`MAX_BEAMS`] beams; the beams come back as they were given.
    pub fn build_while(
        beams: Vec<Beam>,
        ceiling: f32,
        medium: &Medium,
        density: &Density,
        go_on: &mut dyn FnMut() -> bool,
    ) -> Result<Self, Unfinished> {
        let mut parts = || {
            if beams.len() > MAX_BEAMS {
                return Err(Stop::TooMany);
            }
            let mut meter = Meter::new(go_on)?;
            let (cut, tickets) = tickets(&beams, &mut meter)?;
            let tree = Tree::new(&beams, &cut, &tickets, ceiling, &mut meter)?;
            drop(tickets);
            Ok((tree, BeamColumns::new(&beams, medium, density, &mut meter)?))
        };
        match parts() {
            Ok((tree, columns)) => Ok(Self { beams, tree, columns, ceiling }),
            Err(reason) => Err(Unfinished { beams, reason }),
        }
    }

    /// The beams, as they were given.
    pub fn beams(&self) -> &[Beam] {
        &self.beams
    }

    /// The kernel radius \[m\] that the map was built for.
    pub fn ceiling(&self) -> f32 {
        self.ceiling
    }

    /// The beams, all of them and in the order they were given, for their memory to be used again.
    pub fn into_beams(self) -> Vec<Beam> {
        self.beams
    }

    /// Bytes held.
    pub fn memory(&self) -> usize {
        self.beams.capacity() * size_of::<Beam>()
            + self.tree.pieces.capacity() * size_of::<Piece>()
            + self.tree.nodes.capacity() * size_of::<Node>()
            + self.columns.memory()
    }

    /// [`BeamMap::gather_while`] with a host that always goes on.
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
        self.gather_while(rays, medium, density, radius, gathered, scratch, &mut || true);
    }

    /// Adds to `gathered[i]` what ray `rays[i]` gathers from all beams (see [`gather_pair`]), as long as `go_on` says so.
    /// Returns whether it came to the end.
    ///
    /// - `rays`: any number. 64 after the other share one walk through the hierarchy: give those that run side by side
    ///   together (the rays of a tile of pixels). Any rays are gathered correctly.
    /// - `medium`, `density`: those given to [`BeamMap::build`]. In a density grid each ray's column is tabulated, to 5e-4
    ///   of the transmittance.
    /// - `radius`: its `ceiling` must not exceed the one given to [`BeamMap::build`]; a larger one is cut to it.
    /// - `gathered`: one for each ray. Stopped, it holds part of the sums: to be thrown away.
    /// - `go_on`: asked at the start and about once in a millisecond; false stops. The work between two questions is
    ///   bounded whatever the beams.
    ///
    /// # Panics
    /// If `rays` and `gathered` differ in length.
    #[allow(clippy::too_many_arguments)] // Each is another thing; none has a home in another.
    pub fn gather_while(
        &self,
        rays: &[EyeRay],
        medium: &Medium,
        density: &Density,
        radius: &KernelRadius,
        gathered: &mut [Gathered],
        scratch: &mut GatherScratch,
        go_on: &mut dyn FnMut() -> bool,
    ) -> bool {
        assert_eq!(rays.len(), gathered.len());
        let radius = KernelRadius { ceiling: radius.ceiling.min(self.ceiling), ..*radius };
        let GatherScratch { stack, candidates, tables, .. } = scratch;
        tables.clear();
        let mut gather = |index: usize, candidates: &Candidates, meter: &mut Meter| {
            let (ray, gathered) = (&rays[index], &mut gathered[index]);
            let knots = tables.of(index, ray, medium, density);
            let column = density.column(ray.origin, ray.direction, knots);
            let tested = self.gather_candidates(ray, candidates, medium, density, column, &radius, gathered);
            meter.spend(knots.len() + tested, 100)
        };
        let Ok(mut meter) = Meter::new(go_on) else { return false };
        self.walk(rays, radius.ceiling, stack, candidates, &mut meter, &mut gather).is_ok()
    }

    /// Adds what one ray gathers from the candidates, and returns how many came near it.
    #[inline(never)] // The hot loop compiles to 3 % fewer instructions on its own than inside of the walk.
    #[allow(clippy::too_many_arguments)]
    fn gather_candidates(
        &self,
        ray: &EyeRay,
        candidates: &Candidates,
        medium: &Medium,
        density: &Density,
        ray_column: Column,
        radius: &KernelRadius,
        gathered: &mut Gathered,
    ) -> usize {
        let mut tested = 0;
        for (block, pieces) in candidates.blocks.iter().zip(candidates.pieces.chunks(BLOCK)) {
            let mut mask = block.test(ray, radius.ceiling);
            while mask != 0 {
                let piece = &pieces[mask.trailing_zeros() as usize];
                mask &= mask - 1;
                tested += 1;
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
        tested
    }

    /// Adds to `gathered[i]` what ray `rays[i]` gathers from all beams in a medium that only the host knows. Returns
    /// whether it came to the end.
    ///
    /// The pairs, their order and their radii are those of [`BeamMap::gather_while`], as are `rays`, `radius`, `gathered` and
    /// `go_on`; the medium given to [`BeamMap::build`] plays no part. Each pair adds
    /// `product * beam.power * contact.kernel`; one whose contribution is not finite is skipped.
    ///
    /// - `shade`: is given up to 256 contacts and as many products, which are zero. It fills in
    ///   σ_s(x) p(θ) T_eye T_beam per channel \[1/(m sr)\]: scattering coefficient and phase function at the contact's
    ///   position, transmittance from there to the start of the eye ray and from the start of the beam to its point. False
    ///   stops.
    ///
    /// Cost: with a `shade` that computes a homogeneous medium, a few per cent more than the built-in one (bench
    /// `gather/medium/the host's`).
    ///
    /// # Panics
    /// If `rays` and `gathered` differ in length.
    pub fn gather_contacts(
        &self,
        rays: &[EyeRay],
        radius: &KernelRadius,
        gathered: &mut [Gathered],
        scratch: &mut GatherScratch,
        shade: &mut dyn FnMut(&[Contact], &mut [Vec3]) -> bool,
        go_on: &mut dyn FnMut() -> bool,
    ) -> bool {
        assert_eq!(rays.len(), gathered.len());
        let radius = KernelRadius { ceiling: radius.ceiling.min(self.ceiling), ..*radius };
        let GatherScratch { stack, candidates, contacts, products, .. } = scratch;
        contacts.clear();
        let mut settle = |contacts: &mut Vec<Contact>, meter: &mut Meter| {
            products.clear();
            products.resize(contacts.len(), Vec3::ZERO);
            if !shade(contacts, products) {
                return Err(Stop::Cancelled);
            }
            for (contact, product) in contacts.iter().zip(products.iter()) {
                let radiance = *product * self.beams[contact.beam as usize].power * contact.kernel;
                gathered[contact.ray as usize].add(radiance, contact.radius, contact.sigma);
            }
            // What the host does for a pair is taken to cost about a microsecond.
            let result = meter.spend(contacts.len(), 1000);
            contacts.clear();
            result
        };
        let mut collect = |index: usize, candidates: &Candidates, meter: &mut Meter| {
            let ray = &rays[index];
            let mut tested = 0;
            for (block, pieces) in candidates.blocks.iter().zip(candidates.pieces.chunks(BLOCK)) {
                let mut mask = block.test(ray, radius.ceiling);
                while mask != 0 {
                    let piece = &pieces[mask.trailing_zeros() as usize];
                    mask &= mask - 1;
                    tested += 1;
                    let beam = &self.beams[piece.beam as usize];
                    let Some(meeting) = meet(ray, beam, piece.from, piece.to, &radius) else { continue };
                    let Meeting { point, crossing, radius: r, sigma } = meeting;
                    contacts.push(Contact {
                        position: point,
                        ray: index as u32,
                        beam: piece.beam,
                        ray_distance: crossing.ray_distance,
                        beam_distance: crossing.beam_distance,
                        cos_theta: cos_theta(ray, beam),
                        kernel: radius.kernel.evaluate(crossing.gap, r) / crossing.sin_theta,
                        radius: r,
                        sigma,
                    });
                    if contacts.len() == CONTACTS {
                        settle(contacts, meter)?;
                    }
                }
            }
            meter.spend(tested, 100)
        };
        let Ok(mut meter) = Meter::new(go_on) else { return false };
        self.walk(rays, radius.ceiling, stack, candidates, &mut meter, &mut collect).is_ok()
            && (contacts.is_empty() || settle(contacts, &mut meter).is_ok())
    }

    /// Gives `gather` the index of each ray, with each batch of pieces that the rays of its packet may touch.
    fn walk(
        &self,
        rays: &[EyeRay],
        radius: f32,
        stack: &mut Vec<u32>,
        candidates: &mut Candidates,
        meter: &mut Meter,
        gather: &mut impl FnMut(usize, &Candidates, &mut Meter) -> Result<(), Stop>,
    ) -> Result<(), Stop> {
        let mut walk_packet = |packet: &Packet, first: usize, count: usize| {
            stack.clear();
            if !self.tree.nodes.is_empty() {
                stack.push(0);
            }
            while !stack.is_empty() {
                self.collect(packet, radius, stack, candidates, meter)?;
                if candidates.pieces.is_empty() {
                    continue;
                }
                candidates.fill_blocks(&self.beams);
                for index in first..first + count {
                    // Each ray tests each block.
                    meter.spend(candidates.blocks.len(), 20)?;
                    gather(index, candidates, meter)?;
                }
            }
            Ok(())
        };
        for (i, rays) in rays.chunks(PACKET).enumerate() {
            if let Some(packet) = Packet::new(rays) {
                walk_packet(&packet, i * PACKET, rays.len())?;
                continue;
            }
            for (j, ray) in rays.iter().enumerate() {
                if let Some(packet) = Packet::new(core::slice::from_ref(ray)) {
                    walk_packet(&packet, i * PACKET + j, 1)?;
                }
            }
        }
        Ok(())
    }

    /// Goes on with the walk that `stack` is in the middle of, until `candidates` holds a batch or the walk is at its end.
    fn collect(
        &self,
        packet: &Packet,
        radius: f32,
        stack: &mut Vec<u32>,
        candidates: &mut Candidates,
        meter: &mut Meter,
    ) -> Result<(), Stop> {
        let pieces = &mut candidates.pieces;
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
            let node = &self.tree.nodes[index as usize];
            if !packet.touches_box(node) {
                continue;
            }
            if node.count == 0 {
                stack.extend([node.first + 1, node.first]);
            } else {
                let first = node.first as usize;
                let leaf = &self.tree.pieces[first..first + node.count as usize];
                pieces.extend(leaf.iter().filter(|piece| packet.touches_piece(piece, radius)));
            }
        }
        meter.spend(visits + pieces.len(), 30)
    }
}
