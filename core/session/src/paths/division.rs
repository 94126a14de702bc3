//! Division of a photon where not all of its light meets a surface or a medium.

use crate::paths::photon::Photon;
use crate::paths::reception::Part;
use crate::paths::record::{PhotonRecord, add};
use crate::paths::segment::Loss;
use crate::paths::transport::Transport;
use crate::scene::{Links, Rays, media};
use covbeam_geometry::hit::Hit;
use glam::Vec3;

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
