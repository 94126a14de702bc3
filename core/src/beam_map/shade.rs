//! What pairs add to their rays, in a medium of the core's or of the host's.

use super::cancel::{Poll, Stop};
use super::columns::{BeamColumns, Bunch, up_to};
use super::eight::{Pairs, phases, transmittance, vector};
use super::exponential;
use super::rays::RayTables;
use super::room::make_room;
use super::search::Shade;
use super::simd::{Floats, LANES, bits, load};
use crate::beam::{Beam, EyeRay};
use crate::medium::{Density, Medium};
use crate::pair::Gathered;
use fearless_simd::Simd;
use glam::Vec3;
use std::vec::Vec;

/// An eye ray that meets a beam, for a host that knows the medium ([`crate::BeamMap::gather_contacts`]). A
/// pair along the ray (sin θ < [`crate::ALONG_SINE`]) has [`crate::PLACES`] of them.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Contact {
    /// The point on the eye ray that is closest to the beam \[m\], or one of those of a pair along the ray.
    pub position: Vec3,
    /// Which eye ray: index in the call's rays.
    pub ray: u32,
    /// Which beam: index in the order in which the beams were given.
    pub beam: u32,
    /// Distance of the position from the start of the eye ray \[m\], in \[0, length\].
    pub ray_distance: f32,
    /// Distance along the beam of its point closest to the eye ray \[m\]: within the beam, or out of it by
    /// less than the kernel radius at an end that a surface cuts at a slant.
    pub beam_distance: f32,
    /// dot(propagation of the beam's light, propagation of light to the eye): forward is +1. What
    /// [`crate::PhaseFunction::evaluate`] takes; rounding may carry it past ±1.
    pub cos_theta: f32,
    /// K_r(d)/sin θ \[1/m\]: what the pair's product is multiplied by, besides the beam's power; of a pair
    /// along the ray this place's share of its integral.
    pub kernel: f32,
    /// The kernel's radius r \[m\].
    pub radius: f32,
    /// σ along the kernel's axis \[cycles/m\], 0 where the grid has no data.
    pub sigma: f32,
}

/// Contacts that a host is given at a time.
const CONTACTS: usize = 256;

/// Adds pairs in a medium that the core knows.
pub(super) struct OurMedium<'a> {
    pub(super) columns: &'a BeamColumns,
    pub(super) rays: &'a [EyeRay],
    pub(super) medium: &'a Medium<'a>,
    pub(super) gathered: &'a mut [Gathered],
    pub(super) tables: &'a mut RayTables,
}

impl Shade for OurMedium<'_> {
    #[inline(always)]
    fn pairs<S: Simd>(&mut self, simd: S, ray: usize, pairs: &Pairs<S>, poll: &mut Poll) -> Result<(), Stop> {
        if pairs.accepted == 0 {
            return Ok(());
        }
        let mut scale = phases(simd, self.medium, pairs.cos_theta);
        let column = match (&self.medium.density, self.columns) {
            (Density::Exponential(exponential), BeamColumns::Exponential(at_origins)) => {
                let (column, density) =
                    exponential::columns(simd, exponential, &self.rays[ray], at_origins, pairs);
                scale = scale.map(|scale| density * scale);
                column
            }
            (_, BeamColumns::Tables(bunches)) => {
                let (column, density) = self.tabulated(ray, pairs, bunches, poll)?;
                scale = scale.map(|scale| load(simd, &density) * scale);
                load(simd, &column)
            }
            _ => pairs.beam_distance + pairs.ray_distance,
        };
        let Medium { scattering, .. } = *self.medium;
        let transmittance = transmittance(simd, self.medium, column);
        let mut radiance = scale;
        for channel in 0..3 {
            let product = scattering[channel] * transmittance[channel] * scale[channel];
            radiance[channel] = product * load(simd, &pairs.block.power[channel]) * pairs.kernel;
        }
        self.gathered[ray].add_lanes(pairs.accepted, radiance, pairs.radius, pairs.sigma);
        Ok(())
    }
}

impl OurMedium<'_> {
    /// The columns along both ways of pairs, and the density where they meet, in a grid.
    #[inline(never)]
    fn tabulated<S: Simd>(
        &mut self,
        ray: usize,
        pairs: &Pairs<S>,
        bunches: &[Bunch],
        poll: &mut Poll,
    ) -> Result<(Floats, Floats), Stop> {
        let Self { rays, medium, ref mut tables, .. } = *self;
        let density = &medium.density;
        let EyeRay { origin, direction, .. } = rays[ray];
        if !tables.has(ray) {
            poll.spend(tables.make(ray, &rays[ray], medium)?, 100)?;
        }
        poll.spend(pairs.accepted.count_ones() as usize, 200)?;
        let along_ray = density.column(origin, direction, tables.of(ray));
        let (ray_distance, beam_distance): (Floats, Floats) =
            (pairs.ray_distance.into(), pairs.beam_distance.into());
        let positions = pairs.position.store();
        let (mut column, mut here) = ([0.0; LANES], [0.0; LANES]);
        for lane in bits(pairs.accepted) {
            let index = pairs.block.beams[lane] as usize;
            column[lane] = up_to(bunches, beam_distance[lane], index) + along_ray.at(ray_distance[lane]);
            here[lane] = density.at(vector(&positions, lane));
        }
        Ok((column, here))
    }
}

/// Empties the memory of [`HostMedium`], which never needs more.
pub(super) fn reserve(contacts: &mut Vec<Contact>, products: &mut Vec<Vec3>) -> Result<(), Stop> {
    contacts.clear();
    products.clear();
    make_room(contacts, CONTACTS)?;
    make_room(products, CONTACTS)
}

/// Gives pairs to a host that knows the medium, and adds what it says.
pub(super) struct HostMedium<'a> {
    pub(super) beams: &'a [Beam],
    pub(super) shade: &'a mut dyn FnMut(&[Contact], &mut [Vec3]) -> bool,
    pub(super) gathered: &'a mut [Gathered],
    pub(super) contacts: &'a mut Vec<Contact>,
    pub(super) products: &'a mut Vec<Vec3>,
}

impl Shade for HostMedium<'_> {
    #[inline(always)]
    fn pairs<S: Simd>(&mut self, _: S, ray: usize, pairs: &Pairs<S>, poll: &mut Poll) -> Result<(), Stop> {
        let position = pairs.position.store();
        let (ray_distance, beam_distance): (Floats, Floats) =
            (pairs.ray_distance.into(), pairs.beam_distance.into());
        let (cos_theta, kernel): (Floats, Floats) = (pairs.cos_theta.into(), pairs.kernel.into());
        let (radius, sigma): (Floats, Floats) = (pairs.radius.into(), pairs.sigma.into());
        self.contacts.extend(bits(pairs.accepted).map(|lane| Contact {
            position: vector(&position, lane),
            ray: ray as u32,
            beam: pairs.block.beams[lane],
            ray_distance: ray_distance[lane],
            beam_distance: beam_distance[lane],
            cos_theta: cos_theta[lane],
            kernel: kernel[lane],
            radius: radius[lane],
            sigma: sigma[lane],
        }));
        if self.contacts.len() + LANES > CONTACTS { self.packet(poll) } else { Ok(()) }
    }

    fn packet(&mut self, poll: &mut Poll) -> Result<(), Stop> {
        let Self { beams, shade, gathered, contacts, products } = self;
        if contacts.is_empty() {
            return Ok(());
        }
        products.clear();
        products.resize(contacts.len(), Vec3::ZERO);
        if !shade(contacts, products) {
            return Err(Stop::Cancelled);
        }
        for (contact, product) in contacts.iter().zip(products.iter()) {
            let radiance = *product * beams[contact.beam as usize].power * contact.kernel;
            gathered[contact.ray as usize].add(radiance, contact.radius, contact.sigma);
        }
        // What the host does for a pair is taken to cost about a microsecond.
        poll.spend(contacts.len(), 1000)?;
        contacts.clear();
        Ok(())
    }
}
