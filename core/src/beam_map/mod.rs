//! All beams of a pass that a packet of eye rays may touch, found through a bounding volume hierarchy.

mod bvh;
mod cancel;
mod columns;
mod eight;
mod exponential;
mod packet;
mod rays;
mod room;
mod search;
mod shade;
mod simd;
mod sub_beams;

pub use cancel::Stop;
pub use shade::Contact;

use crate::beam::{Beam, EyeRay};
use crate::kernel::Kernel;
use crate::medium::Medium;
use crate::pair::Gathered;
use bvh::{Bvh, WideNode};
use cancel::Poll;
use columns::{BeamColumns, MediumKey};
use fearless_simd::Level;
use glam::Vec3;
use rays::RayTables;
use room::release;
use search::{Query, Search, Shade};
use shade::{HostMedium, OurMedium, reserve};
use std::vec::Vec;
use sub_beams::{SUB_BEAMS_PER_BEAM, SubBeam, morton_codes};

/// The most beams that a [`BeamMap`] takes, 2²⁸: their sub-beams, and the nodes over these, are counted in 32
/// bits.
pub const MAX_BEAMS: usize = 1 << 28;

// At most a sub-beam more a beam than on average, a node less than two a sub-beam, and room for rounding.
const _: () = assert!(2 * (SUB_BEAMS_PER_BEAM + 1) * MAX_BEAMS <= 1 << 31);

/// The beams of one medium and one pass.
///
/// About 36 bytes a sub-beam, up to three sub-beams a beam, and 260 bytes a node of up to eight leaves of up
/// to eight sub-beams: with the beams themselves 76 bytes a sub-beam, 190 a beam (`measure speed`). An
/// exponential density adds 4 bytes a beam, a density grid 8 bytes a knot of the beams' columns
/// ([`crate::Density::knots`]).
#[derive(Clone)]
#[doc(alias = "BVH")]
#[doc(alias = "acceleration structure")]
pub struct BeamMap {
    beams: Vec<Beam>,
    bvh: Bvh,
    columns: BeamColumns,
    medium: MediumKey,
    max_radius: f32,
}

/// Beams that did not become a [`BeamMap`].
#[derive(Clone, Debug)]
pub struct Unfinished {
    /// As they were given.
    pub beams: Vec<Beam>,
    /// Why.
    pub reason: Stop,
}

/// Buffers of a gather that a thread keeps between calls so that they are not allocated again.
///
/// About 4 MB, and 8 bytes a knot of 256 eye rays' columns, however many beams there are.
#[derive(Clone, Debug, Default)]
pub struct GatherScratch {
    search: Search,
    tables: RayTables,
    contacts: Vec<Contact>,
    products: Vec<Vec3>,
}

impl BeamMap {
    /// [`BeamMap::build_while`] with a host that always goes on.
    ///
    /// # Panics
    /// If there are more than [`MAX_BEAMS`] beams, or memory cannot be had.
    pub fn build(beams: Vec<Beam>, max_radius: f32, medium: &Medium) -> Self {
        match Self::build_while(beams, max_radius, medium, &mut || true) {
            Ok(map) => map,
            Err(unfinished) => panic!("a map of {} beams: {}", unfinished.beams.len(), unfinished.reason),
        }
    }

    /// Builds the hierarchy over `beams`, to be gathered with kernels no wider than `max_radius` \[m\], and
    /// the columns along them, as long as `go_on` says so.
    ///
    /// - `medium`: what the beams are in, and will be gathered in.
    /// - `go_on`: asked at the start and about once in a millisecond; false stops. The work between two
    ///   questions is bounded whatever the beams; in a density grid it also grows with the voxels along one
    ///   beam. After a no the system has the memory back first, 4 to 14 ms a million beams.
    ///
    /// Beams that cannot contribute are kept, but never found: length not > 0 and finite; origin, direction,
    /// power or end not finite. The result depends on nothing but the arguments.
    ///
    /// Errors: stopped, out of memory, or more than [`MAX_BEAMS`] beams; the beams come back as they were
    /// given.
    pub fn build_while(
        beams: Vec<Beam>,
        max_radius: f32,
        medium: &Medium,
        go_on: &mut dyn FnMut() -> bool,
    ) -> Result<Self, Unfinished> {
        let mut parts = || {
            if beams.len() > MAX_BEAMS {
                return Err(Stop::TooMany);
            }
            let mut poll = Poll::new(go_on)?;
            let (cut, codes) = morton_codes(&beams, &mut poll)?;
            let bvh = Bvh::new(&beams, &cut, &codes, max_radius, &mut poll)?;
            release(codes, &mut poll)?;
            Ok((bvh, BeamColumns::new(&beams, medium, &mut poll)?))
        };
        match parts() {
            Ok((bvh, columns)) => Ok(Self { beams, bvh, columns, medium: MediumKey::of(medium), max_radius }),
            Err(reason) => Err(Unfinished { beams, reason }),
        }
    }

    /// The beams, as they were given.
    pub fn beams(&self) -> &[Beam] {
        &self.beams
    }

    /// The kernel radius \[m\] that the map was built for.
    pub fn max_radius(&self) -> f32 {
        self.max_radius
    }

    /// The beams, all of them and in the order they were given, for their memory to be used again.
    pub fn into_beams(self) -> Vec<Beam> {
        self.beams
    }

    /// Bytes held.
    pub fn memory(&self) -> usize {
        self.beams.capacity() * size_of::<Beam>()
            + self.bvh.sub_beams.capacity() * size_of::<SubBeam>()
            + self.bvh.nodes.capacity() * size_of::<WideNode>()
            + self.columns.memory()
    }

    /// [`BeamMap::gather_while`] with a host that always goes on.
    ///
    /// # Panics
    /// If `rays` and `gathered` differ in length.
    pub fn gather(
        &self,
        medium: &Medium,
        rays: &[EyeRay],
        kernel: &Kernel,
        gathered: &mut [Gathered],
        scratch: &mut GatherScratch,
    ) -> Result<(), Stop> {
        self.gather_while(medium, rays, kernel, gathered, scratch, &mut || true)
    }

    /// Adds to `gathered[i]` what ray `rays[i]` gathers from all beams (see [`crate::gather_pair`]), as long
    /// as `go_on` says so.
    ///
    /// - `medium`: the one given to [`BeamMap::build`], a density grid over the same memory. In a density
    ///   grid each ray's column is tabulated, to 5e-4 of the transmittance.
    /// - `rays`: any number. 256 after the other share one walk through the hierarchy: give those that run
    ///   side by side together (the rays of a tile of pixels). Any rays are gathered correctly.
    /// - `kernel`: its `max_radius` must not exceed the one given to [`BeamMap::build`]; a larger one is cut
    ///   to it, with a smaller one fewer beams are tested.
    /// - `gathered`: one for each ray.
    /// - `go_on`: as in [`BeamMap::build_while`].
    ///
    /// Errors: [`Stop::OtherMedium`], with nothing gathered; [`Stop::Cancelled`] and [`Stop::OutOfMemory`],
    /// with part of the sums in `gathered`, to be thrown away.
    ///
    /// # Panics
    /// If `rays` and `gathered` differ in length.
    pub fn gather_while(
        &self,
        medium: &Medium,
        rays: &[EyeRay],
        kernel: &Kernel,
        gathered: &mut [Gathered],
        scratch: &mut GatherScratch,
        go_on: &mut dyn FnMut() -> bool,
    ) -> Result<(), Stop> {
        assert_eq!(rays.len(), gathered.len());
        if MediumKey::of(medium) != self.medium {
            return Err(Stop::OtherMedium);
        }
        let GatherScratch { search, tables, .. } = scratch;
        tables.clear()?;
        let mut shade = OurMedium { columns: &self.columns, rays, medium, gathered, tables };
        self.search(rays, kernel, search, go_on, &mut shade)
    }

    /// Adds to `gathered[i]` what ray `rays[i]` gathers from all beams in a medium that only the host knows.
    ///
    /// The pairs, their order and their radii are those of [`BeamMap::gather_while`], as are `rays`,
    /// `kernel`, `gathered` and `go_on`; the medium given to [`BeamMap::build`] plays no part. Each pair adds
    /// `product * beam.power * contact.kernel`; one whose contribution is not finite is skipped.
    ///
    /// - `shade`: is given up to 256 contacts, of rays of one packet, and as many products, which are zero.
    ///   It fills in σ_s(x) p(θ) T_eye T_beam per channel \[1/(m sr)\]: scattering coefficient and phase
    ///   function at the contact's position, transmittance from there to the start of the eye ray and from
    ///   the start of the beam to its point. False stops.
    ///
    /// Cost: with a `shade` that computes a homogeneous medium, 30 % more than the built-in one (bench
    /// `gather/medium/the host's`).
    ///
    /// Errors: [`Stop::Cancelled`] if `go_on` or `shade` stopped it, [`Stop::OutOfMemory`].
    ///
    /// # Panics
    /// If `rays` and `gathered` differ in length.
    pub fn gather_contacts(
        &self,
        rays: &[EyeRay],
        kernel: &Kernel,
        gathered: &mut [Gathered],
        scratch: &mut GatherScratch,
        shade: &mut dyn FnMut(&[Contact], &mut [Vec3]) -> bool,
        go_on: &mut dyn FnMut() -> bool,
    ) -> Result<(), Stop> {
        assert_eq!(rays.len(), gathered.len());
        let GatherScratch { search, contacts, products, .. } = scratch;
        reserve(contacts, products)?;
        let mut shade = HostMedium { beams: &self.beams, shade, gathered, contacts, products };
        self.search(rays, kernel, search, go_on, &mut shade)
    }

    /// Finds all pairs and has them shaded, ray after ray within a packet.
    fn search(
        &self,
        rays: &[EyeRay],
        kernel: &Kernel,
        search: &mut Search,
        go_on: &mut dyn FnMut() -> bool,
        shade: &mut impl Shade,
    ) -> Result<(), Stop> {
        let kernel = Kernel { max_radius: kernel.max_radius.min(self.max_radius), ..*kernel };
        let query = Query { level: Level::new(), beams: &self.beams, bvh: &self.bvh, rays, kernel: &kernel };
        Poll::new(go_on).and_then(|mut poll| search.all(&query, &mut poll, shade))
    }
}

// Processors with one set of vector instructions have only scalar code to compare it with.
#[cfg(all(test, any(feature = "scalar", target_arch = "x86", target_arch = "x86_64")))]
mod levels;
