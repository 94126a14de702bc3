//! The moving photon of a light path, and what an event makes of it.

use crate::kind::Kind;
use crate::light::falloff::Falloff;
use crate::paths::reception::Reception;
use crate::paths::record::{PhotonRecord, Record, add};
use crate::paths::scattering::Scattering;
use crate::scene::bounces::{Bounce, Counted};
use crate::scene::optics::{Boundary, Interior, curvature_towards, reflect};
use crate::scene::{Rays, Scene};
use crate::surface::SurfacePhoton;
use crate::surface::encounter::{Encounter, Lobe, Way};
use covbeam::{Curvature, LightField};
use covbeam_geometry::hit::Hit;
use glam::Vec3;

/// The moving photon.
#[derive(Clone)]
pub(super) struct Photon {
    pub(super) origin: Vec3,
    pub(super) direction: Vec3,
    pub(super) power: Vec3,
    /// Over the power of a path of weight 1.
    pub(super) unit: Vec3,
    /// Events so far that count for its limit: of plain paths. Of guided ones their trees count, and it is 0.
    pub(super) events: u32,
    pub(super) interior: Interior,
    /// Normal of the surface that it left, towards the side it is on; zero in the open.
    pub(super) normal: Vec3,
    pub(super) direct: bool,
    pub(super) specular: bool,
    /// The light that it comes from.
    pub(super) light: u32,
    /// Rays that see its light: what it comes to next sends it on as if it were one of these that leaves there.
    pub(super) seen_by: Rays,
    /// What the surface that it is at makes of it.
    pub(super) reception: Reception,
    /// How often it has been scattered, reflected and refracted.
    pub(super) bounces: u32,
    /// The same by kind.
    pub(super) counted: Counted,
    /// How far from here its light begins, and ends: of lamps with a size, as long as it goes straight on.
    pub(super) dark: f32,
    pub(super) until: f32,
    /// How far from here it is next to its lamp.
    pub(super) near: f32,
    /// How its straight light fades, whose power is that of a typical distance.
    pub(super) falloff: Falloff,
    /// How far from its lamp it is, as long as it goes straight on.
    pub(super) gone: f32,
    /// Uniform, for where its beams are divided.
    pub(super) shift: f32,
    pub(super) field: Option<LightField>,
    /// Paths without a light field that this one's stands for, and itself.
    pub(super) stands_for: f32,
}

impl Photon {
    /// In each channel.
    #[inline]
    pub(super) fn weights(&self) -> Vec3 {
        self.power * self.unit
    }

    /// What its light has met.
    #[inline]
    pub(super) fn kind(&self) -> Kind {
        match self {
            Self { direct: true, .. } => Kind::Straight,
            Self { specular: true, .. } => Kind::Focused,
            _ => Kind::Scattered,
        }
    }

    /// Whether it has bounced more often than it may; it is lost then.
    #[inline]
    pub(super) fn is_spent(&self, scene: &Scene, out: &mut PhotonRecord) -> bool {
        let is_spent = !(scene.allows(self.bounces) && is_seen(scene, &self.counted));
        if is_spent {
            add(&mut out.energy.spent, self.power);
        }
        is_spent
    }

    /// Whether fog may send it to the camera.
    #[inline]
    pub(super) fn is_seen_in_fog(&self, scene: &Scene) -> bool {
        scene.may_be_seen(&self.counted, Bounce::Volume)
    }

    /// Whether surfaces may.
    #[inline]
    pub(super) fn is_seen_on_surfaces(&self, scene: &Scene) -> bool {
        scene.shows_surfaces() && scene.may_be_seen(&self.counted, Bounce::Diffuse)
    }

    /// Whether anything may send it to the camera once an event of a kind has scattered it.
    pub(super) fn may_be_seen_after(&self, scene: &Scene, bounce: Bounce) -> bool {
        let mut counted = self.counted;
        counted.add(scene.settings.limits.as_ref(), bounce, false);
        is_seen(scene, &counted)
    }

    /// Counts an event. `is_sharp`: whether light keeps its directions in it.
    #[inline]
    pub(super) fn count(&mut self, scene: &Scene, bounce: Bounce, is_sharp: bool) {
        self.counted.add(scene.settings.limits.as_ref(), bounce, is_sharp);
    }

    /// Leaves what arrives on a diffuse surface that is seen for disks there; straight light is looked up by
    /// shadow rays.
    ///
    /// - `normal`: towards the side that it comes from.
    #[inline]
    pub(super) fn arrive(
        &self,
        scene: &Scene,
        hit: &Hit,
        normal: Vec3,
        record: Record,
        out: &mut PhotonRecord,
    ) {
        let is_sent = self.reception.sends(Lobe::Diffuse) || self.reception.sends(Lobe::Translucent);
        if record.has_beams() && !self.direct && is_sent && self.is_seen_on_surfaces(scene) {
            let (position, power, caustic) = (hit.position, self.power, self.specular);
            out.surface.push(SurfacePhoton { position, normal, power, caustic });
        }
    }

    /// Is scattered into a direction, by a medium or a diffuse surface.
    #[inline]
    pub(super) fn scatter(&mut self, scene: &Scene, by: &Scattering, direction: Vec3) {
        self.count(scene, by.bounce(), false);
        if let Some(field) = &mut self.field {
            by.turn(field, direction);
        }
        let distance = self.origin.distance(by.place());
        self.direction = direction;
        self.origin = by.start(direction);
        self.normal = by.normal();
        self.direct = false;
        self.specular = false;
        self.bounces += 1;
        self.begin(distance);
    }

    /// Is reflected by a mirror.
    ///
    /// - `curves`: whether the surface's curvature acts on its light field.
    #[inline]
    pub(super) fn mirror(&mut self, hit: &Hit, normal: Vec3, curves: bool) {
        if let Some(field) = &mut self.field {
            field.reflect(normal, &curvature(hit, normal, curves));
        }
        self.leave(hit, normal, reflect(self.direction, normal), false);
    }

    /// Goes on from the boundary of glass or water.
    ///
    /// - `through`: the direction behind it; None: it is reflected. `curves`: as of [`Photon::mirror`].
    #[inline]
    pub(super) fn cross(&mut self, hit: &Hit, boundary: &Boundary, through: Option<Vec3>, curves: bool) {
        let normal = boundary.normal;
        if let Some(field) = &mut self.field {
            let curvature = curvature(hit, normal, curves);
            if through.is_some() {
                field.refract(normal, &curvature, boundary.eta);
            } else {
                field.reflect(normal, &curvature);
            }
        }
        let (normal, direction) = match through {
            Some(refracted) => {
                self.interior = boundary.beyond;
                (-normal, refracted)
            }
            None => (normal, boundary.reflected),
        };
        self.leave(hit, normal, direction, boundary.is_matched());
    }

    /// Goes one of the ways on from a surface of lobes; its power is left to the caller.
    ///
    /// - `curves`: as of [`Photon::mirror`].
    #[inline]
    pub(super) fn take(&mut self, way: &Way, hit: &Hit, met: &Encounter, curves: bool) {
        if let Some(field) = &mut self.field {
            met.turn(field, hit, way, curves);
        }
        self.interior = way.interior;
        self.specular &= met.keeps_focus(way.lobe);
        let normal = if way.lobe.crosses() { -met.normal } else { met.normal };
        self.leave(hit, normal, way.direction, way.lobe == Lobe::Transparent);
    }

    /// Goes on through what lets all light go straight on: as if nothing had been met but another medium.
    #[inline]
    pub(super) fn go_straight_on(&mut self, scene: &Scene, hit: &Hit) {
        let side = if hit.geometric_normal.dot(self.direction) < 0.0 { -1.0 } else { 1.0 };
        self.interior = self.interior.through(scene, hit, self.direction);
        self.leave(hit, side * hit.geometric_normal, self.direction, true);
    }

    /// Goes on straight as if nothing had been there, whatever was.
    pub(super) fn pass(&mut self, scene: &Scene, hit: &Hit) {
        let side = if hit.geometric_normal.dot(self.direction) < 0.0 { -1.0 } else { 1.0 };
        self.interior = self.interior.beyond(scene, hit, self.direction);
        self.leave(hit, side * hit.geometric_normal, self.direction, true);
    }

    /// Leaves a surface along a direction, which may be as straight as if nothing were there.
    #[inline]
    fn leave(&mut self, hit: &Hit, normal: Vec3, direction: Vec3, is_straight: bool) {
        self.direction = direction;
        self.normal = normal;
        self.direct &= is_straight;
        self.bounces += u32::from(!is_straight);
        if is_straight {
            self.advance(hit.distance);
        } else {
            self.begin(hit.distance);
        }
        self.origin = hit.leave(direction);
    }
}

/// Whether anything may send light to the camera that has bounced so often.
#[inline]
fn is_seen(scene: &Scene, counted: &Counted) -> bool {
    scene.may_be_seen(counted, Bounce::Volume)
        || scene.shows_surfaces() && scene.may_be_seen(counted, Bounce::Diffuse)
}

/// The curvature that a light field meets at a hit.
#[inline]
fn curvature(hit: &Hit, normal: Vec3, curves: bool) -> Curvature {
    if curves { curvature_towards(hit, normal) } else { Curvature::default() }
}
