//! Reception: how a surface divides light that not all rays see, or that comes straight from a lamp of which it casts no shadow, or another
//! one than it looks like.

use crate::paths::photon::Photon;
use crate::paths::record::{PhotonRecord, add};
use crate::paths::segment::Loss;
use crate::paths::transport::Transport;
use crate::scene::{Links, Rays, media};
use crate::surface::encounter::Lobe;
use covbeam_geometry::hit::Hit;
use glam::Vec3;

/// What the surface that a photon meets makes of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reception {
    /// Rays that see the surface: those that see what leaves it.
    pub(super) seen_by: Rays,
    /// The lobes that send it on; None: all of the surface's.
    pub(super) part: Option<Part>,
}

/// Of a surface's lobes, those that a part of the light knows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    /// That one of these rays leaves.
    rays: Rays,
    /// Whether it goes straight on, too.
    straight: bool,
    /// Whether glass is among them.
    glass: bool,
}

impl Reception {
    /// Of what everything sees.
    pub(super) const PLAIN: Self = Self { seen_by: Rays::LIGHT, part: None };

    /// Whether a lobe sends the light on.
    #[inline]
    pub(super) fn sends(&self, lobe: Lobe) -> bool {
        self.part.is_none_or(|part| match lobe {
            Lobe::Transparent => part.straight,
            Lobe::GlassReflection | Lobe::GlassTransmission => part.glass && part.rays.has(lobe.ray()),
            _ => part.rays.has(lobe.ray()),
        })
    }

    /// Whether none does.
    pub(super) fn is_void(&self) -> bool {
        self.part.is_some_and(|part| !part.straight && !part.rays.has(Rays::LIGHT))
    }
}

impl Transport<'_> {
    /// Whether a medium scatters a photon's light.
    #[inline]
    pub(super) fn is_scattered_in(&self, photon: &Photon, region: u32) -> bool {
        let is_lit =
            || !photon.direct || self.links(photon).lights(self.scene.medium_of(region).heed.light_set);
        self.is_plain || photon.seen_by.has(Rays::VOLUME) && is_lit()
    }

    /// What a medium takes of a photon's light, up to a distance: without an end all that it does.
    #[inline]
    pub(super) fn loss_in(&self, photon: &Photon, region: u32, end: f32) -> Loss {
        if self.is_plain || !photon.direct || !end.is_finite() {
            return Loss::All;
        }
        let heed = self.scene.medium_of(region).heed;
        if heed.hidden.has(Rays::SHADOW) {
            return Loss::None;
        }
        if heed.is_in_way(&self.links(photon)) {
            return Loss::All;
        }
        let lamp = photon.origin - photon.gone * photon.direction;
        Loss::Inside(media::transmittance(&self.fogs[region as usize], lamp, photon.origin))
    }

    fn links(&self, photon: &Photon) -> Links {
        self.scene.links_of(photon.light as usize)
    }

    /// Divides a photon at a surface that it has come to: it keeps the part that meets that, and what goes on as if nothing were there is
    /// returned, on its way.
    #[inline]
    pub(super) fn divide(&self, photon: &mut Photon, hit: &Hit, out: &mut PhotonRecord) -> Option<Photon> {
        if self.is_plain {
            return None;
        }
        let (passing, share) = if photon.direct {
            (photon.seen_by, self.receive_straight(photon, hit))
        } else {
            (self.receive(photon, hit), Vec3::ONE)
        };
        if share == Vec3::ZERO || passing == Rays::NONE {
            return None;
        }
        let mut by = photon.clone();
        by.power *= share;
        by.seen_by = passing;
        add(&mut out.energy.roulette, -by.power);
        by.pass(self.scene, hit);
        Some(by)
    }

    /// Of straight light the share that passes, as shadow rays have it; what the surface sends on is not lessened by that. Glass that lets
    /// light by more freely than it looks does so instead of refracting and reflecting it.
    fn receive_straight(&self, photon: &mut Photon, hit: &Hit) -> Vec3 {
        let (links, object) = (self.links(photon), self.scene.object_of(hit));
        let material = self.scene.material_at(hit);
        let (share, transparent) = (object.lets_by(&links, &material), material.transparent());
        let rays = if links.lights(object.heed.light_set) { photon.seen_by } else { Rays::NONE };
        photon.reception.seen_by = Rays::LIGHT.without(object.heed.hidden);
        if share == transparent && (rays == Rays::LIGHT || material.is_clear()) {
            return Vec3::ZERO;
        }
        let glass = !share.cmpgt(transparent).any();
        photon.reception.part = Some(Part { rays, straight: false, glass });
        share
    }

    /// Of other light the rays that do not see the surface.
    fn receive(&self, photon: &mut Photon, hit: &Hit) -> Rays {
        let hidden = self.scene.object_of(hit).heed.hidden;
        let passing = photon.seen_by.and(hidden);
        photon.seen_by = photon.seen_by.without(passing);
        photon.reception.seen_by = Rays::LIGHT.without(hidden);
        if photon.seen_by != Rays::LIGHT {
            let straight = photon.seen_by != Rays::NONE;
            photon.reception.part = Some(Part { rays: photon.seen_by, straight, glass: true });
        }
        passing
    }
}
