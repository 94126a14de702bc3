//! A host's functions, called.

use super::fields::*;
use crate::session::description::material;
use crate::session::fields::{covbeam_asks, covbeam_material};
use ::covbeam_geometry::hit::Hit;
use ::covbeam_session::host::{HostPhoton, HostScene, HostWay, HostWays};
use ::covbeam_session::scene::Lobes;
use covbeam_core::Curvature;
use glam::{DVec3, Vec3};

/// A host that has all functions that its scene asks for.
#[derive(Debug)]
pub(super) struct Host(pub(super) covbeam_host);

// SAFETY: the host promises that its functions may be called from any thread.
unsafe impl Send for Host {}
// SAFETY: and from several at once.
unsafe impl Sync for Host {}

/// Answers of functions that write nothing.
const MISS: covbeam_host_hit = covbeam_host_hit {
    distance: 0.0,
    position: [0.0; 3],
    geometric_normal: [0.0; 3],
    normal: [0.0; 3],
    offset: 0.0,
    tangent: [0.0; 3],
    along: 0.0,
    across: 0.0,
    twist: 0.0,
    object: 0,
    material: 0,
    mark: [0; 3],
};
const LOST: covbeam_host_way = covbeam_host_way { factor: [0.0; 3], direction: [0.0; 3], deviation: 0.0 };
const ABSORBED: covbeam_host_ways =
    covbeam_host_ways { diffuse: [0.0; 3], translucent: [0.0; 3], reflected: [LOST; 3], refracted: LOST };
const DARK: covbeam_host_photon = covbeam_host_photon {
    origin: [0.0; 3],
    direction: [0.0; 3],
    power: [0.0; 3],
    normal: [0.0; 3],
    radius: 0.0,
    angular_variance: 0.0,
};
const NOTHING: covbeam_host_arrival = covbeam_host_arrival { density: [0.0; 3], from: [0.0; 3] };
const NOWHERE: covbeam_host_eye_ray = covbeam_host_eye_ray { origin: [0.0; 3], direction: [0.0; 3] };

/// What a function makes of one question.
macro_rules! ask {
    ($host:ident . $function:ident, $question:expr, $answer:expr) => {{
        let (question, mut answer) = ($question, $answer);
        if let Some(function) = $host.0.$function {
            // SAFETY: the host's function, with what the host gave for it; both arrays have one element.
            unsafe { function($host.0.user, 1, &question, &mut answer) };
        }
        answer
    }};
}

impl HostScene for Host {
    fn bounds(&self) -> (Vec3, Vec3) {
        (self.0.min.into(), self.0.max.into())
    }

    fn cast(&self, origin: DVec3, direction: DVec3, reach: f64) -> Option<Hit> {
        let hit = ask!(self.cast, ray(origin, direction, reach), MISS);
        // False for NaN.
        (hit.distance > 0.0).then(|| Hit {
            distance: hit.distance,
            position: hit.position.into(),
            geometric_normal: hit.geometric_normal.into(),
            normal: hit.normal.into(),
            curvature: curvature(&hit),
            object: hit.object,
            material: hit.material,
            mark: hit.mark,
            is_alone: false,
            offset: hit.offset,
        })
    }

    fn is_blocked(&self, origin: DVec3, direction: DVec3, reach: f64) -> Option<bool> {
        self.0.blocked?;
        Some(ask!(self.blocked, ray(origin, direction, reach), 0) != 0)
    }

    fn lobes(&self, hit: &Hit, lobes: &Lobes) -> Lobes {
        let there = material(&ask!(self.lobes, given(hit), described(lobes)));
        Lobes {
            diffuse: there.diffuse.into(),
            translucent: there.translucent.into(),
            metal: there.metal.into(),
            edge: there.edge.into(),
            glass_reflection: there.glass_reflection.into(),
            glass_transmission: there.glass_transmission.into(),
            coat: there.coat.into(),
            transparent: there.transparent.into(),
            alpha: there.roughness,
            ..*lobes
        }
    }

    fn ways(&self, hit: &Hit, direction: Vec3, xi: [f32; 2]) -> HostWays {
        let meeting = covbeam_host_meeting { hit: given(hit), direction: direction.into(), xi };
        let ways = ask!(self.scatter, meeting, ABSORBED);
        let way = |way: covbeam_host_way| HostWay {
            factor: way.factor.into(),
            direction: way.direction.into(),
            deviation: way.deviation,
        };
        HostWays {
            diffuse: ways.diffuse.into(),
            translucent: ways.translucent.into(),
            reflected: ways.reflected.map(way),
            refracted: way(ways.refracted),
        }
    }

    fn emit(&self, light: u32, place: [f32; 2], xi: [f32; 2]) -> HostPhoton {
        let photon = ask!(self.emit, covbeam_host_draw { light, place, xi }, DARK);
        HostPhoton {
            origin: photon.origin.into(),
            direction: photon.direction.into(),
            power: photon.power.into(),
            normal: photon.normal.into(),
            radius: photon.radius,
            angular_variance: photon.angular_variance,
        }
    }

    fn illuminate(&self, light: u32, place: Vec3, xi: [f32; 2]) -> (Vec3, Vec3) {
        let question = covbeam_host_question { light, place: place.into(), xi };
        let arrival = ask!(self.illuminate, question, NOTHING);
        (arrival.density.into(), arrival.from.into())
    }

    fn eye(&self, place: [f32; 2], lens: [f32; 2]) -> Option<(Vec3, Vec3)> {
        let ray = ask!(self.eye, covbeam_host_pixel { place, lens }, NOWHERE);
        Some((ray.origin.into(), ray.direction.into()))
    }
}

fn ray(origin: DVec3, direction: DVec3, reach: f64) -> covbeam_host_ray {
    covbeam_host_ray { origin: origin.to_array(), direction: direction.to_array(), reach }
}

/// A hit as the host gave it.
fn given(hit: &Hit) -> covbeam_host_hit {
    let Curvature { tangent, along, across, twist } = hit.curvature;
    covbeam_host_hit {
        distance: hit.distance,
        position: hit.position.into(),
        geometric_normal: hit.geometric_normal.into(),
        normal: hit.normal.into(),
        offset: hit.offset,
        tangent: tangent.into(),
        along,
        across,
        twist,
        object: hit.object,
        material: hit.material,
        mark: hit.mark,
    }
}

/// A material as it was described.
fn described(lobes: &Lobes) -> covbeam_material {
    covbeam_material {
        diffuse: lobes.diffuse.into(),
        translucent: lobes.translucent.into(),
        metal: lobes.metal.into(),
        edge: lobes.edge.into(),
        glass_reflection: lobes.glass_reflection.into(),
        glass_transmission: lobes.glass_transmission.into(),
        coat: lobes.coat.into(),
        transparent: lobes.transparent.into(),
        ior: lobes.index,
        alpha: lobes.alpha,
        asks: covbeam_asks::COVBEAM_ASKS_NOTHING as u32,
        has_shadow: lobes.shadow.is_some().into(),
        shadow: lobes.shadow.unwrap_or_default().into(),
    }
}

/// Of a hit; along any direction where it is flat.
fn curvature(hit: &covbeam_host_hit) -> Curvature {
    let covbeam_host_hit { tangent, along, across, twist, .. } = *hit;
    let tangent = match [along, across, twist] == [0.0; 3] {
        true => Vec3::from(hit.normal).try_normalize().unwrap_or(Vec3::Z).any_orthonormal_vector(),
        false => tangent.into(),
    };
    Curvature { tangent, along, across, twist }
}
