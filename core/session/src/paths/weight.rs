//! Weights of light paths: one measure for roulette, free flights, splitting and the end of long paths, of plain and guided paths alike.
//!
//! A path's *weight* in a channel is its power over the power that it started with in that channel; a guided path's, over what paths have on
//! average. Its *limit* at a place, after so many events, is the same for all channels of equal fog: 1, but more far out in the fog of the world
//! and after many events. What weighs less than the limit in every channel is kept with a probability of the largest ratio, and weighs as much
//! then; what weighs more than [`CHANNELS`] times the limit in any channel is split into equal parts. So no plain path ever goes on with a weight
//! above 3 x limit in any channel, and no guided one above the limit, or `MOST_POWER` times what it is where something is seen if that is more,
//! however it came by it; the mean of what is kept is what was.
//!
//! Up to [`ENDLESS`] events the limit is at most [`LONG_WEIGHT`] but far out: a plain path weighs at most 24 where anything is seen.
//!
//! Plain paths are never split where the limit is 1. A flight draws its length from the mixture of the channels' densities, each with its share
//! q of the weights over their limits (one-sample balance heuristic, E. Veach and L. Guibas 1995): weight w becomes w f/Σ q f ≤ w/q, and Σ w is as before.
//! Lobes are drawn alike. Roulette raises only what weighs less than 1 in every channel, up to 1 in the largest: Σ w ≤ 3 again. With
//! Σ w = 3 at the start, no channel ever weighs more than 3.
//!
//! Roulette on the ratio of one event's powers instead lets channels drift apart without bound: what one channel has lost never comes back.

use crate::random::PathSampler;
use crate::scene::geometry::bounds_of_scene;
use crate::scene::{MediumDensity, Scene};
use covbeam::Medium;
use glam::Vec3;

/// A path weighs at most so many times its limit in any channel.
pub(super) const CHANNELS: f32 = 3.0;

/// After this many events the limit grows with each by 1/[`GOING_ON`], up to [`LONG_WEIGHT`]: of light that hardly anything absorbs few paths
/// are followed to its end.
pub(crate) const LONG_PATH: u32 = 64;
pub(crate) const GOING_ON: f32 = 0.95;
const LONG_WEIGHT: f32 = 8.0;

/// Beyond so many events the limit grows with their square. Where nothing is absorbed and nothing escapes light has no end, and no finite number
/// of paths of bounded weight has its mean.
const ENDLESS: f32 = 1024.0;

/// Far out in the fog of the world the limit is (1 + x/p)ᵖ < eˣ, x the optical depth to the box of all objects, lamps and the camera. At most e⁻ˣ of
/// a path's light gets there straight, so that no path brings more than 3 to the box that way from anywhere.
///
/// Light that is not absorbed wanders about, and returns as 1/x of what is there: a path of weight W that is split on its way back brings W/x, all of one
/// colour. Each doubling of the distance adds W/x² to the variance of what returns and x²/W events to the cost: with W = x² both grow alike, with
/// more the variance is that of the few paths farthest away. Three and a half is the least with which fog without end costs less than 1.5 times what
/// 13 scatterings cost.
const FAR: f32 = 3.5;

/// How much paths may weigh.
pub(super) struct Limits {
    /// Corners of the box of what there is, and extinction of the fog around it; None: vacuum, or fog that is not the same everywhere.
    around: Option<([Vec3; 2], Vec3)>,
}

impl Limits {
    pub(super) fn new(scene: &Scene) -> Self {
        let fog = scene.outside.map(|outside| scene.medium_of(scene.region(outside, false)));
        let uniform = fog.filter(|fog| matches!(fog.density, MediumDensity::Uniform));
        let (min, max) = bounds_of_scene(scene);
        let camera = scene.camera.position;
        let corners = [min.min(camera), max.max(camera)];
        Self { around: uniform.map(|fog| (corners, fog.medium.extinction())) }
    }

    /// The limit at a place, after some events.
    pub(super) fn at(&self, place: Vec3, events: u32) -> Vec3 {
        let long = patience(events);
        let Some(([min, max], extinction)) = self.around else { return Vec3::splat(long) };
        let outside = place - place.clamp(min, max);
        if outside == Vec3::ZERO {
            return Vec3::splat(long);
        }
        let depth = extinction * outside.length();
        let far = Vec3::ONE + depth / FAR;
        // As much as f32 holds in the weights of all.
        (long * far.powf(FAR)).min(Vec3::splat(1e12))
    }
}

/// How much more than others a path of so many events may weigh.
pub(super) fn patience(events: u32) -> f32 {
    let long = events.saturating_sub(LONG_PATH).min(1 << 10) as i32;
    let endless = (events as f32 / ENDLESS).max(1.0);
    libm::powf(GOING_ON, -long as f32).min(LONG_WEIGHT) * endless * endless
}

/// One over each channel; 0 where there is none.
pub(super) fn inverse(power: Vec3) -> Vec3 {
    Vec3::select(power.cmpgt(Vec3::ZERO), power.recip().min(Vec3::MAX), Vec3::ZERO)
}

/// Into how many equal parts a path is split that weighs so many times what it may, in its largest channel.
pub(super) fn parts(excess: f32) -> u32 {
    // Rounding alone splits nothing.
    if excess > 1.0 + 1e-4 { excess.ceil().min(1e6) as u32 } else { 1 }
}

/// The channel that a number in [0, 1) chooses in proportion to weights, and the number made uniform again.
pub(super) fn channel(weights: Vec3, number: f32) -> (usize, f32) {
    let mut left = number * weights.element_sum();
    let mut last = 0;
    for channel in 0..3 {
        let weight = weights[channel];
        if weight > 0.0 {
            if left < weight {
                return (channel, (left / weight).min(1.0 - f32::EPSILON));
            }
            last = channel;
            left -= weight;
        }
    }
    (last, 1.0 - f32::EPSILON)
}

/// The column up to the next collision, from the mixture of the channels' densities.
pub(super) fn free_column(weights: Vec3, medium: &Medium, sampler: &mut PathSampler) -> f32 {
    let u = sampler.uniform();
    let extinction = medium.extinction();
    let grey = extinction.x == extinction.y && extinction.y == extinction.z;
    let (extinction, u) = if grey {
        (extinction.x, u)
    } else {
        let (channel, u) = channel(weights, u);
        (extinction[channel], u)
    };
    if extinction > 0.0 { -libm::log1pf(-u) / extinction } else { f32::INFINITY }
}

/// σ_t T / pdf per channel after a column; the density at the collision stands in both.
pub(super) fn of_collision(weights: Vec3, medium: &Medium, column: f32) -> Vec3 {
    let density = medium.extinction() * medium.transmittance(column);
    density / (density.dot(weights) / weights.element_sum())
}

/// T / P(no collision) per channel after a column.
pub(super) fn of_passage(weights: Vec3, medium: &Medium, column: f32) -> Vec3 {
    let transmittance = medium.transmittance(column);
    transmittance / (transmittance.dot(weights) / weights.element_sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kind::Kind;
    use crate::paths::{PhotonRecord, PhotonTracer, Record};
    use crate::pilot::of_still;
    use crate::random::Emission;
    use crate::scene::made::{Made, camera, lambert, medium, rectangle};
    use crate::scene::{Light, Lobes, Material, media};
    use covbeam::PhaseFunction;

    /// Fog of the world that absorbs nothing, and a lamp whose channels are 100:1 apart over a floor of 7 by 6 metres.
    fn scene(scattering: Vec3, floor: Material) -> Scene {
        let mut fog = medium(0.0, 0.0, PhaseFunction::ISOTROPIC, MediumDensity::Uniform);
        fog.medium.scattering = scattering;
        let (position, intensity) = (Vec3::new(0.0, 2.0, 0.0), Vec3::new(10.0, 0.1, 2.0));
        Made::new(camera([0.0, 1.0, -4.0], [0.0, 1.0, 0.0], 40.0, [24, 24]))
            .medium(fog)
            .in_fog()
            .object(rectangle([-3.0, 0.0, -4.0], [0.0, 0.0, 7.0], [6.0, 0.0, 0.0]), floor)
            .light(Light::Point { position, intensity })
            .scene()
    }

    /// Colours 200:1 apart, of the fog and of the floor, of one lobe or of several.
    const COLORED: Vec3 = Vec3::new(0.02, 0.4, 4.0);
    const DIFFUSE: Vec3 = Vec3::new(0.9, 0.0045, 0.2);
    const FLOORS: [Material; 2] = [
        Material::Lambert { albedo: DIFFUSE },
        Material::Lobes(Lobes {
            diffuse: DIFFUSE,
            translucent: Vec3::new(0.09, 0.49, 0.0045),
            coat: Vec3::splat(0.5),
            ..Lobes::NONE
        }),
    ];

    fn tracer(scene: &Scene) -> PhotonTracer<'_> {
        PhotonTracer::new(scene, 0, Emission::LowDiscrepancy)
    }

    /// The largest weight in any channel that gets to the box of what there is, over the mean power of a path in that channel, and how many beams
    /// there are.
    fn largest(tracer: &PhotonTracer, paths: u32) -> (f32, usize) {
        let Some(([min, max], extinction)) = tracer.transport.limits.around else {
            panic!("fog of the world")
        };
        let unit = inverse(tracer.transport.scene.lights[0].flux()) * paths as f32;
        let there = |place: Vec3| (-extinction * (place - place.clamp(min, max)).length()).exp();
        let (mut most, mut count) = (0.0, 0);
        for index in 0..paths {
            let mut record = PhotonRecord::default();
            tracer.trace(0, index, paths, Record::Beams, &mut record);
            // What comes straight from a lamp has the power that guidance gave it.
            let beams = record.beams.iter().filter(|path| path.kind != Kind::Straight);
            let beams = beams.map(|path| (path.beam.origin, path.beam.power));
            let surface = record.surface.iter().map(|photon| (photon.position, photon.power));
            let weight = |(place, power): (Vec3, Vec3)| (power * unit * there(place)).max_element();
            most = beams.chain(surface).map(weight).fold(most, f32::max);
            count += record.beams.len();
        }
        (most, count)
    }

    /// What the bound of plain paths rests on, whatever a path weighs, to twelve decades between its channels, and however far it flies: together
    /// all channels weigh what they did.
    #[test]
    fn flights_keep_what_all_channels_weigh_together() {
        let mut fog = medium(0.0, 0.0, PhaseFunction::ISOTROPIC, MediumDensity::Uniform).medium;
        (fog.scattering, fog.absorption) = (COLORED, Vec3::new(0.3, 0.0, 1.0));
        let mut sampler = PathSampler::new(Emission::Independent, 1, 0, 0);
        let mut most = 0.0_f32;
        for _ in 0..200_000 {
            let weights = Vec3::from([(); 3].map(|()| match sampler.uniform() {
                ..0.1 => 0.0,
                _ => 10_f32.powf(-12.0 * sampler.uniform()),
            }));
            let sum = weights.element_sum();
            if sum == 0.0 {
                continue;
            }
            let column = free_column(weights, &fog, &mut sampler);
            for factor in [of_collision(weights, &fog, column), of_passage(weights, &fog, column)] {
                most = most.max(((weights * factor).element_sum() / sum - 1.0).abs());
            }
        }
        assert!(most < 1e-5, "{most}");
    }

    /// Paths of up to [`ENDLESS`] events: after those the limit grows, and some are as long here. Rounding over a thousand events is below 1e-3.
    #[test]
    fn no_path_weighs_more_than_the_stated_multiple_of_what_it_started_with() {
        for floor in FLOORS {
            let mut scene = scene(COLORED, floor);
            scene.settings.bounces = Some(ENDLESS as u32 - 1);
            let (most, beams) = largest(&tracer(&scene), 100_000);
            println!("plain, {floor:?}: {most} at most, {beams} beams");
            assert!(most <= CHANNELS * LONG_WEIGHT * 1.001, "{floor:?}: {most}");
        }
    }

    #[test]
    fn no_guided_path_weighs_more_than_the_stated_multiple_of_the_mean() {
        for floor in FLOORS {
            let mut scene = scene(COLORED, floor);
            scene.settings.bounces = Some(ENDLESS as u32 - 1);
            let fogs = media::all(&scene);
            let mut tracer = tracer(&scene);
            tracer.guide(of_still(&scene, &fogs).expect("light"));
            let (most, beams) = largest(&tracer, 40_000);
            println!("guided, {floor:?}: {most} at most, {beams} beams");
            assert!(most <= crate::paths::guided::MOST_POWER * LONG_WEIGHT * 1.001, "{floor:?}: {most}");
        }
    }

    /// Mean and variance of the mean of what arrives on the floor and has been scattered, in each channel by what the lamp sends out.
    fn arrives(tracer: &PhotonTracer, paths: u32) -> [[f64; 2]; 3] {
        const PARTS: u32 = 40;
        let unit = inverse(tracer.transport.scene.lights[0].flux());
        let part = |part| {
            let mut record = PhotonRecord::default();
            let each = paths / PARTS;
            (part * each..(part + 1) * each).for_each(|index| {
                tracer.trace(part, index, each, Record::Beams, &mut record);
            });
            record.surface.iter().map(|photon| (photon.power * unit).as_dvec3()).sum::<glam::DVec3>()
        };
        let found: Vec<glam::DVec3> = (0..PARTS).map(part).collect();
        let n = f64::from(PARTS);
        let mean = found.iter().copied().sum::<glam::DVec3>() / n;
        let spread =
            found.iter().map(|found| (*found - mean).powf(2.0)).sum::<glam::DVec3>() / (n * (n - 1.0));
        [0, 1, 2].map(|channel| [mean[channel], spread[channel]])
    }

    /// 4.5 standard errors, which one of 100,000 such comparisons exceeds.
    fn agree([a, of_a]: [f64; 2], [b, of_b]: [f64; 2], what: &str) {
        let error = (of_a + of_b).sqrt();
        println!("{what}: {a:.5} and {b:.5}, error {error:.5}");
        assert!((a - b).abs() < 4.5 * error, "{what}: {a} and {b}, {error}");
        // Through the ten free paths of the thickest fog hardly any light comes down: a tenth is all that 200,000 paths tell.
        assert!(error < 0.1 * b, "{what}: {error} of {b} tells nothing");
    }

    /// What one channel decides for the others does not count in the mean: each by itself, in fog without colours, where no density is
    /// any other than its own.
    #[test]
    fn channels_have_the_mean_that_each_has_alone() {
        let floor = FLOORS[0];
        let together = scene(COLORED, floor);
        let together = arrives(&tracer(&together), 200_000);
        for (channel, scattering) in COLORED.to_array().into_iter().enumerate() {
            let alone = scene(Vec3::splat(scattering), floor);
            let alone = arrives(&tracer(&alone), 200_000);
            agree(together[channel], alone[channel], &scattering.to_string());
        }
    }

    /// And neither does how few paths are followed far out.
    #[test]
    fn light_from_far_out_arrives_as_if_every_path_were_followed() {
        let scene = scene(Vec3::splat(0.6), lambert(0.5));
        let mut tracer = tracer(&scene);
        let found = arrives(&tracer, 200_000);
        tracer.transport.limits.around = None;
        let all = arrives(&tracer, 40_000);
        agree(found[0], all[0], "far out");
    }

    /// Beams of fog without end, and of at most 13 scatterings.
    #[test]
    fn fog_of_the_world_costs_hardly_more_than_a_few_scatterings() {
        let mut scene = scene(Vec3::splat(0.4), lambert(0.5));
        let beams = |scene: &Scene| {
            let fogs = media::all(scene);
            let mut tracer = tracer(scene);
            let (_, plain) = largest(&tracer, 20_000);
            tracer.guide(of_still(scene, &fogs).expect("light"));
            let (_, guided) = largest(&tracer, 20_000);
            [plain, guided].map(|beams| beams as f32 / 20_000.0)
        };
        let endless = beams(&scene);
        scene.settings.bounces = Some(13);
        let few = beams(&scene);
        println!("beams a path, plain and guided: {endless:?}, with 13 scatterings {few:?}");
        assert!((0..2).all(|way| endless[way] < 1.5 * few[way]), "{endless:?} {few:?}");
    }
}
