//! Events of light paths, in media and on surfaces: what is absorbed, what is recorded, and which ways are
//! left.

use crate::material::Lobes;
use crate::paths::operators::Operator;
use crate::paths::photon::Photon;
use crate::paths::record::{PhotonRecord, Record, add, scaled};
use crate::paths::scattering::{Scattering, albedo};
use crate::paths::transport::Transport;
use crate::random::PathSampler;
use crate::scene::Material;
use crate::scene::bounces::Bounce;
use crate::scene::optics::{Boundary, facing_normal};
use crate::surface::encounter::{Encounter, Lobe, Met, Way};
use covbeam::Medium;
use covbeam_geometry::hit::Hit;
use glam::Vec3;

/// The ways that light can go on from a surface. What its paths do where there are several is theirs to
/// decide.
pub(super) enum Ways<'h> {
    /// None: it is lost.
    Nowhere,
    /// Straight on; it has gone.
    Straight,
    /// One other way; it has gone.
    One,
    /// All directions; its power is what is reflected.
    Scattered(Scattering<'h>),
    /// Back and, but for total reflection, through.
    Glass(Boundary),
}

impl Transport<'_> {
    /// The collision of light that has gone along a direction to a place in a medium.
    #[inline]
    pub(super) fn collision<'f>(&self, fog: &'f Medium<'f>, along: Vec3, place: Vec3) -> Scattering<'f> {
        Scattering::Medium { fog, place, along, blurs: self.acts(Operator::Scattering) }
    }

    /// A photon meets a surface.
    #[inline]
    pub(super) fn meet<'h>(
        &self,
        photon: &mut Photon,
        hit: &'h Hit,
        sampler: &mut PathSampler,
        record: Record,
        out: &mut PhotonRecord,
    ) -> Ways<'h> {
        let is_lit = photon.is_lit(hit.distance);
        let material = self.scene.material_at(hit);
        if photon.reception.is_void() {
            return lose(photon, out);
        }
        if photon.reception.part.is_some() {
            return self.meet_lobes(photon, hit, &material.lobes(), sampler, record, out);
        }
        match *material {
            Material::Clear => {
                photon.go_straight_on(self.scene, hit);
                Ways::Straight
            }
            Material::Lambert { albedo } if is_lit => self.meet_diffuse(photon, hit, albedo, record, out),
            Material::Mirror { reflectance } if is_lit => {
                self.meet_mirror(photon, hit, reflectance, sampler, out)
            }
            Material::Black | Material::Lambert { .. } | Material::Mirror { .. } => lose(photon, out),
            Material::Lobes(ref lobes) => self.meet_lobes(photon, hit, lobes, sampler, record, out),
            Material::Dielectric { .. } => {
                let boundary = Boundary::new(self.scene, hit, photon.direction, &photon.interior);
                // What begins farther along its way has no other one.
                if boundary.is_matched() || is_lit { Ways::Glass(boundary) } else { lose(photon, out) }
            }
        }
    }

    /// Sends a photon on from the boundary of glass or water.
    ///
    /// - `through`: the direction behind it; None: it is reflected.
    #[inline]
    pub(super) fn cross(&self, photon: &mut Photon, hit: &Hit, boundary: &Boundary, through: Option<Vec3>) {
        if !boundary.is_matched() {
            let bounce = if through.is_some() { Bounce::Transmission } else { Bounce::Glossy };
            photon.count(self.scene, bounce, true);
        }
        photon.cross(hit, boundary, through, self.acts(Operator::Curvature));
    }

    #[inline]
    fn meet_diffuse<'h>(
        &self,
        photon: &mut Photon,
        hit: &'h Hit,
        albedo: Vec3,
        record: Record,
        out: &mut PhotonRecord,
    ) -> Ways<'h> {
        let normal = facing_normal(hit, photon.direction);
        photon.arrive(self.scene, hit, normal, record, out);
        photon.power = scaled(photon.power, albedo, &mut out.energy.surfaces);
        if record == Record::Connections {
            self.connect_diffuse(photon, hit, normal, out);
        }
        Ways::Scattered(Scattering::Surface { hit, normal, geometric: normal, bounce: Bounce::Diffuse })
    }

    #[inline]
    fn meet_mirror(
        &self,
        photon: &mut Photon,
        hit: &Hit,
        reflectance: Vec3,
        sampler: &mut PathSampler,
        out: &mut PhotonRecord,
    ) -> Ways<'static> {
        photon.power = scaled(photon.power, reflectance, &mut out.energy.surfaces);
        let limit = self.limits.at(hit.position, photon.events);
        if photon.survive_by_weight(limit, sampler.uniform(), out).is_none() {
            return Ways::Nowhere;
        }
        let normal = facing_normal(hit, photon.direction);
        photon.count(self.scene, Bounce::Glossy, true);
        photon.mirror(hit, normal, self.acts(Operator::Curvature));
        Ways::One
    }

    fn meet_lobes<'h>(
        &self,
        photon: &mut Photon,
        hit: &'h Hit,
        lobes: &Lobes,
        sampler: &mut PathSampler,
        record: Record,
        out: &mut PhotonRecord,
    ) -> Ways<'h> {
        let is_lit = photon.is_lit(hit.distance);
        let xi = sampler.uniform_pair();
        let met =
            Encounter::new(self.scene, hit, (Met::ByLight, photon.direction), &photon.interior, lobes, xi);
        // Where it goes is guided then.
        if let Some(albedo) = met.lambert() {
            return if is_lit && photon.reception.sends(Lobe::Diffuse) {
                self.meet_diffuse(photon, hit, albedo, record, out)
            } else {
                lose(photon, out)
            };
        }
        if is_lit && met.is_diffuse() {
            photon.arrive(self.scene, hit, met.normal, record, out);
        }
        if is_lit && record == Record::Connections {
            self.connect_lobes(photon, hit, &met, out);
        }
        let way = met.draw(self.lobe_weights(photon, hit), sampler.uniform(), sampler.uniform_pair());
        let way = way.filter(|way| is_lit || way.lobe == Lobe::Transparent);
        let Some(way) = way.filter(|way| photon.reception.sends(way.lobe)) else { return lose(photon, out) };
        photon.power = scaled(photon.power, way.factor, &mut out.energy.surfaces);
        self.take(photon, &way, hit, &met);
        Ways::One
    }

    /// Weights by which one way of several is drawn.
    pub(super) fn lobe_weights(&self, photon: &Photon, hit: &Hit) -> Vec3 {
        let weights = photon.weights() / self.limits.at(hit.position, photon.events);
        // What is below the limit is no reason to lose light here: what is lost here is what the surface takes.
        weights / weights.max_element().clamp(f32::MIN_POSITIVE, 1.0)
    }

    /// Sends a photon one way on from a surface of lobes.
    pub(super) fn take(&self, photon: &mut Photon, way: &Way, hit: &Hit, met: &Encounter) {
        if let Some(bounce) = way.lobe.bounce() {
            photon.count(self.scene, bounce, met.is_sharp(way.lobe));
        }
        photon.take(way, hit, met, self.acts(Operator::Curvature));
    }
}

/// What a medium scatters of a power that collides; it absorbs the rest.
#[inline]
pub(super) fn scattered(fog: &Medium, power: Vec3, out: &mut PhotonRecord) -> Vec3 {
    scaled(power, albedo(fog), &mut out.energy.medium)
}

/// Leaves all of a photon's light to a surface.
#[inline]
fn lose(photon: &Photon, out: &mut PhotonRecord) -> Ways<'static> {
    add(&mut out.energy.surfaces, photon.power);
    Ways::Nowhere
}
