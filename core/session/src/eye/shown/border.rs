//! Borders of lamps: pixels that a lamp fills in part, where one eye ray sees all or nothing of it.

use crate::eye::shown::{Sighting, SmallLamps};
use crate::eye::starts::{EyeStart, EyeStarts};
use crate::light::Meetings;
use crate::random::spread;
use crate::scene::Scene;
use covbeam::Medium;
use covbeam_geometry::shape::intersect_box;
use glam::{DVec3, Vec3};
use smallvec::SmallVec;

/// Rays that look for lamps through a pixel that a border of one crosses, and places that they find of which it is asked whether anything hides
/// them. They gather no beams, so they cost a twentieth of a pass where hundreds of lamps are seen; borders have a third of the squared error that
/// the many passes of plain beams leave in the same time, and five times as much with a single ray.
const LOOKS: u32 = 64;
const ASKED: u32 = 16;

/// Rays that look whether there is one, through the pixel and as much of those around it: a corner of a lamp fills next to nothing of a pixel,
/// and seen by one ray in hundreds is a white dot. As long as none meets a lamp whose box is there, there are more of them.
const TRIES: u32 = 32;
const MOST_TRIES: u32 = 256;
const ACROSS: f32 = 2.0;

/// Lamps narrower than so many radii of what a pixel sees have borders in all pixels that they may lie in: rays may miss them.
const NARROW: f32 = 4.0;

/// A border crosses a pixel in which some ray sees less than this share of what another one sees.
const EVEN: f32 = 0.75;

/// What a pixel sees is wider than its middle says, away from the axis, by this factor at most.
const WIDER: f32 = 1.25;

/// What lamps fill of a pixel, if nothing hides them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fill {
    /// Nothing.
    Empty,
    /// All of it, evenly.
    Even,
    /// A part of it, or some of it more brightly.
    Uneven,
}

/// Looks for lamps through the pixels of a picture.
pub(crate) struct Pixels<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) small: &'a SmallLamps,
    pub(crate) starts: &'a EyeStarts<'a>,
}

impl Pixels<'_> {
    /// What lamps fill of pixel (x, y); where small ones lie they do so unevenly.
    pub(crate) fn fill(&self, [x, y]: [u32; 2]) -> Fill {
        let Self { scene, small, starts } = *self;
        if scene.shown.is_empty() {
            return Fill::Empty;
        }
        let middle = starts.middle(x, y);
        if !small.in_pixel(scene, &middle).is_empty() {
            return Fill::Uneven;
        }
        let lamps = self.lamps_near([x, y]);
        if lamps.is_empty() {
            return Fill::Empty;
        }
        let cone = Cone::new(scene, [x, y]);
        let is_narrow = |&lamp: &u32| {
            scene.lights[lamp as usize].extent().is_some_and(|(min, max)| {
                let farthest = cone.farthest(middle.origin.as_dvec3(), min, max);
                (max - min).length() < f64::from(NARROW) * farthest
            })
        };
        if lamps.iter().any(is_narrow) {
            return Fill::Uneven;
        }
        let pixel = y * scene.camera.width + x;
        let [mut least, mut most] = [f32::INFINITY, 0.0_f32];
        for look in 0..MOST_TRIES {
            if look >= TRIES && most > 0.0 {
                break;
            }
            let [right, down] = spread([0.0; 2], look as usize).map(|place| 0.5 + ACROSS * (place - 0.5));
            let lens = starts.place_in_lens(0, pixel, look);
            let start = starts.at([x as f32 + right, y as f32 + down], lens);
            let met = met(scene, &lamps, &start);
            let seen = met.iter().map(|(_, radiance)| radiance.element_sum()).sum();
            (least, most) = (least.min(seen), most.max(seen));
        }
        match most {
            0.0 => Fill::Empty,
            _ if least < EVEN * most => Fill::Uneven,
            _ => Fill::Even,
        }
    }

    /// Mean radiance of lamps that pixel (x, y) sees straight, through nothing but fog, its bounds, and what is transparent.
    ///
    /// - `start`: of the eye rays that look for them, by number, and how many there are.
    /// - `shift`: a number in [0, 1) that no `start` depends on.
    pub(crate) fn radiance(
        &self,
        fogs: &[Medium],
        pixel: [u32; 2],
        start: impl Fn(u32, u32) -> EyeStart,
        shift: f32,
    ) -> Vec3 {
        let lamps = self.lamps_near(pixel);
        // What is asked is then spread over the pixel.
        let mut looks: SmallVec<[EyeStart; LOOKS as usize]> =
            (0..LOOKS).map(|look| start(look, LOOKS)).collect();
        looks.sort_by_key(sixteenth);
        let mut seen = Vec::new();
        for start in looks {
            if start.sees {
                self.scene.shown.add_seen(self.scene, &met(self.scene, &lamps, &start), &start, &mut seen);
                self.small.add_seen(self.scene, self.starts, &start, &mut seen);
            }
        }
        let dimmed = |(seen, times): (&Sighting, f32)| times * seen.dimmed(self.scene, fogs);
        drawn(&seen, shift).map(dimmed).sum::<Vec3>() / LOOKS as f32
    }

    /// Lamps that are not small and may be seen in pixel (x, y).
    fn lamps_near(&self, [x, y]: [u32; 2]) -> SmallVec<[u32; 8]> {
        let Self { scene, small, starts } = *self;
        let middle = starts.middle(x, y);
        let (origin, direction) = (middle.origin.as_dvec3(), middle.direction.as_dvec3());
        let cone = Cone::new(scene, [x, y]);
        let is_near = |min: DVec3, max: DVec3| {
            let margin = cone.farthest(origin, min, max);
            intersect_box(min - margin, max + margin, origin, direction).is_some_and(|(_, far)| far > 0.0)
        };
        let mut lamps: SmallVec<[u32; 8]> = scene.shown.far.iter().copied().collect();
        scene.shown.visit(is_near, |lamp| lamps.extend((!small.has(lamp)).then_some(lamp)));
        lamps
    }
}

/// Number of the sixteenth of its pixel that an eye ray goes through, so that those that follow each other touch, as do their fours.
fn sixteenth(start: &EyeStart) -> u32 {
    let [x, y] = start.place.map(|at| (4.0 * at.fract()) as u32);
    (y & 2) << 2 | (x & 2) << 1 | (y & 1) << 1 | (x & 1)
}

/// Where an eye ray meets some lamps.
fn met(scene: &Scene, lamps: &[u32], start: &EyeStart) -> Meetings {
    let mut met = Meetings::new();
    for &lamp in lamps {
        scene.lights[lamp as usize].met(start.origin, start.direction, [0.0, f64::INFINITY], &mut met);
    }
    met
}

/// Of what is seen so much that [`ASKED`] shares of its brightness have one each, and how often it stands for its own: in the mean all of it
/// once.
fn drawn(seen: &[Sighting], shift: f32) -> impl Iterator<Item = (&Sighting, f32)> {
    let brightness = |seen: &Sighting| seen.radiance.element_sum();
    let share = seen.iter().map(brightness).sum::<f32>() / ASKED as f32;
    let mut before = shift;
    seen.iter().filter_map(move |seen| {
        let shares = brightness(seen) / share;
        let (first, end) = (before.floor(), (before + shares).floor());
        before += shares;
        (end > first).then(|| (seen, (end - first) / shares))
    })
}

/// Around the ray through the middle of a pixel, what this sees.
struct Cone {
    at_start: f32,
    by_distance: f32,
}

impl Cone {
    fn new(scene: &Scene, [x, y]: [u32; 2]) -> Self {
        let camera = &scene.camera;
        let steps = camera.pixel_steps(x as f32 + 0.5, y as f32 + 0.5);
        let half = |of: fn(&covbeam::PixelStep) -> Vec3| {
            WIDER * 0.5 * steps.iter().map(|step| of(step).length()).sum::<f32>()
        };
        let [lens, slope] =
            camera.lens.map_or([0.0; 2], |lens| [lens.reach(), lens.reach() / lens.focus_distance]);
        Self {
            at_start: half(|step| step.origin) + lens,
            by_distance: half(|step| step.direction) + WIDER * slope,
        }
    }

    /// Its radius at the farthest point of a box.
    fn farthest(&self, origin: DVec3, min: DVec3, max: DVec3) -> f64 {
        let distance = (min - origin).abs().max((max - origin).abs()).length();
        f64::from(self.at_start) + f64::from(self.by_distance) * distance
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::scene::optics::Interior;

    /// Over all shifts each counts as often as it is there, and no more are asked than there are shares. Two are equal, one is dark.
    #[test]
    fn what_is_asked_stands_for_all_in_the_mean() {
        const SHIFTS: u32 = 4096;
        let mut random = Random::new([1, 2, 3, 4]);
        for count in [0, 1, 2, 5, 200] {
            let mut seen: Vec<Sighting> = Vec::new();
            for number in 0..count {
                let radiance = match number {
                    1 => seen[0].radiance,
                    2 => Vec3::ZERO,
                    _ => Vec3::new(random.uniform().powi(8), random.uniform(), 1e-3),
                };
                let (eye, interior) = (Vec3::ZERO, Interior::default());
                seen.push(Sighting { radiance, eye, interior, place: Vec3::splat(number as f32) });
            }
            let mut times = vec![0.0; seen.len()];
            for shift in 0..SHIFTS {
                let mut asked = 0;
                for (drawn, often) in drawn(&seen, shift as f32 / SHIFTS as f32) {
                    times[drawn.place.x as usize] += often / SHIFTS as f32;
                    asked += 1;
                }
                assert!(asked <= ASKED + 1, "{asked}");
            }
            let all = seen.iter().map(|seen| seen.radiance.element_sum()).sum::<f32>();
            for (seen, times) in seen.iter().zip(times) {
                let shares = seen.radiance.element_sum() / all * ASKED as f32;
                let expected = if shares == 0.0 { 0.0 } else { 1.0 };
                // Shifts are as far apart as this, which tells a small share less well.
                let apart = 1.1 / (SHIFTS as f32 * shares.max(1e-9));
                assert!((times - expected).abs() < apart + 1e-3, "{count}: {times} for {shares} shares");
            }
        }
    }
}
