//! Emission: the light that a path starts from, and the photon that leaves it.

use crate::lamps::near::Near;
use crate::light::EmittedPhoton;
use crate::paths::photon::Photon;
use crate::paths::reception::Reception;
use crate::paths::record::{PhotonRecord, Record, add};
use crate::paths::transport::Transport;
use crate::paths::weight::inverse;
use crate::random::PathSampler;
use crate::scene::bounces::Counted;
use crate::scene::{Light, Scene};
use crate::surface::origin::Origin;
use glam::Vec3;

/// The lights of a scene, as paths start from them.
pub(super) struct Lights {
    /// Cumulative shares of the flux.
    pub(super) cumulative: Vec<f32>,
    /// Of all of them \[W\].
    pub(super) flux: Vec3,
    /// Where each light is.
    origins: Vec<Origin>,
    /// Where straight light is left to beams.
    pub(super) near: Near,
}

impl Lights {
    pub(super) fn new(scene: &Scene) -> Self {
        let flux = scene.lights.iter().map(|light| f64::from(light.flux().element_sum()));
        let total: f64 = flux.clone().sum();
        let mut sum = 0.0;
        let shares = flux.map(|flux| {
            sum += flux / total;
            sum as f32
        });
        let origins = scene.lights.iter().map(|light| Origin::of_light(scene, light));
        Self {
            cumulative: shares.collect(),
            flux: scene.lights.iter().map(Light::flux).sum(),
            origins: origins.collect(),
            near: Near::new(scene),
        }
    }

    /// A photon that leaves a light with a power; None: the light is not there, none of it is recorded, or it
    /// has no power.
    pub(super) fn start(
        &self,
        transport: &Transport,
        light: usize,
        emitted: &EmittedPhoton,
        power: Vec3,
        (record, sampler): (Record, &mut PathSampler),
        out: &mut PhotonRecord,
    ) -> Option<Photon> {
        let source = &transport.scene.lights[light];
        let is_straight = source.is_straight();
        if record == Record::Direct && !is_straight {
            return None;
        }
        let (origin, interior) = self.origins[light].of_photon(transport.scene, source, emitted)?;
        let links = transport.scene.links_of(light);
        let power = power * links.falloff.typical();
        add(&mut out.energy.emitted, power);
        if !(power.max_element() > 0.0) {
            return None;
        }
        Some(Photon {
            origin,
            direction: emitted.direction,
            power,
            unit: inverse(power),
            events: 0,
            interior,
            normal: emitted.normal,
            direct: is_straight,
            specular: is_straight,
            light: light as u32,
            seen_by: links.seen_by(),
            reception: Reception::PLAIN,
            bounces: 0,
            counted: Counted::of_lamp(transport.scene.settings.limits.as_ref(), links.bounces),
            dark: emitted.dark,
            until: emitted.until,
            near: self.near.reach(light),
            falloff: links.falloff,
            gone: 0.0,
            shift: if transport.is_plain { 0.0 } else { sampler.uniform() },
            field: transport.start_field(light, emitted, record),
            stands_for: 1.0,
        })
    }
}

/// The light that a path starts from, with its probability.
pub(super) fn choose_light(cumulative: &[f32], sampler: &mut PathSampler) -> (usize, f32) {
    if cumulative.len() == 1 {
        return (0, 1.0);
    }
    let u = sampler.uniform();
    let index = cumulative.partition_point(|&end| end <= u).min(cumulative.len() - 1);
    let before = if index == 0 { 0.0 } else { cumulative[index - 1] };
    (index, cumulative[index] - before)
}
