//! Lamps so small in the picture that hardly any eye ray meets them: the pixels that they lie in ask for their light, at a point of the lamp.
//!
//! A ray somewhere through a pixel meets what fills a hundredth of it once in a hundred passes, and sees a hundred times what the pixel has then:
//! white dots. A point of the lamp has all of its light, or where its pixel is another one none.

use crate::eye::shown::Sighting;
use crate::eye::starts::{EyeStart, EyeStarts};
use crate::scene::{Light, Scene};
use covbeam::Medium;
use glam::Vec3;

/// Largest area of a small lamp [pixels]: what fills more covers the middle of a pixel, so that passes know where to look for it.
const MOST_AREA: f32 = 2.0;

/// Most pixels that it lies across, each way: of more each would have few of its points.
const MOST_ACROSS: f32 = 4.0;

/// Of the points asked for, from lamp to lamp: irrational.
const TURNS: [f32; 2] = [0.618_034, 0.414_213_56];

/// Boxes are larger than lamps by this part of a pixel, for rounding.
const MARGIN: f32 = 0.01;

/// The small lamps of a scene that the camera sees straight.
#[derive(Clone, Debug, Default)]
pub struct SmallLamps {
    /// Each pixel that one may lie in, row by row, with the lamp's number; in this order.
    places: Vec<(u32, u32)>,
    /// Their numbers, rising.
    lamps: Vec<u32>,
}

impl SmallLamps {
    /// Those of a scene; none for cameras that are no pinhole ([`crate::camera::Camera::is_pinhole`]).
    pub fn new(scene: &Scene) -> Self {
        let mut small = Self::default();
        if !scene.camera.is_pinhole() || !scene.shows_surfaces() {
            return small;
        }
        for &lamp in &scene.shown.order {
            small.add(scene, lamp);
        }
        small.places.sort_unstable();
        small.lamps.sort_unstable();
        small
    }

    fn add(&mut self, scene: &Scene, lamp: u32) {
        let (camera, light) = (&scene.camera, &scene.lights[lamp as usize]);
        let Some([low, high]) = light.extent().and_then(|(min, max)| camera.footprint(min, max)) else {
            return;
        };
        if high[0] - low[0] > MOST_ACROSS || high[1] - low[1] > MOST_ACROSS {
            return;
        }
        let brightest = light.brightest().map_or(0.0, Vec3::max_element);
        let pixels =
            seen(light, scene, [0.5; 2]).map_or(0.0, |(radiance, ..)| radiance.max_element() / brightest);
        if !(pixels > 0.0 && pixels < MOST_AREA) {
            return;
        }
        self.places.extend(camera.pixels_within([low, high], MARGIN).map(|pixel| (pixel, lamp)));
        self.lamps.push(lamp);
    }

    /// Whether a lamp is one of them.
    pub(super) fn has(&self, lamp: u32) -> bool {
        self.lamps.binary_search(&lamp).is_ok()
    }

    pub(super) fn in_pixel(&self, scene: &Scene, start: &EyeStart) -> &[(u32, u32)] {
        if self.places.is_empty() {
            return &[];
        }
        let pixel = pixel(scene, start.place);
        let first = self.places.partition_point(|place| place.0 < pixel);
        let count = self.places[first..].partition_point(|place| place.0 == pixel);
        &self.places[first..first + count]
    }

    /// Those of the pixel that an eye ray goes through, each of the mean radiance that it has there.
    pub(super) fn add_seen(
        &self,
        scene: &Scene,
        starts: &EyeStarts,
        start: &EyeStart,
        found: &mut Vec<Sighting>,
    ) {
        let of_lamp = |&(place, lamp): &(u32, u32)| {
            // Where in their pixels the rays of a pass lie, which is the same for all of them: so they ask for one point of the lamp, that has its
            // light in one of the pixels.
            let turn = |number: f32, step: f32| (number.fract() + (lamp as f32 * step).fract()).fract();
            let xi = [turn(start.place[0], TURNS[0]), turn(start.place[1], TURNS[1])];
            let (radiance, from, at) = seen(&scene.lights[lamp as usize], scene, xi)?;
            (pixel(scene, at) == place).then(|| {
                let (eye, interior) = starts.towards(from - scene.camera.position);
                Sighting { radiance, eye, interior, place: from }
            })
        };
        found.extend(self.in_pixel(scene, start).iter().filter_map(of_lamp));
    }

    /// Their light, after what dims and hides it.
    pub(crate) fn radiance(
        &self,
        scene: &Scene,
        fogs: &[Medium],
        starts: &EyeStarts,
        start: &EyeStart,
    ) -> Vec3 {
        let mut seen = Vec::new();
        self.add_seen(scene, starts, start, &mut seen);
        seen.iter().map(|seen| seen.dimmed(scene, fogs)).sum()
    }

    /// About the radiance of those nearer than `end`, if nothing dims them and they lie in no other pixel.
    pub(super) fn undimmed(&self, scene: &Scene, start: &EyeStart, end: f64) -> Vec3 {
        let of_lamp = |&(_, lamp): &(u32, u32)| match seen(&scene.lights[lamp as usize], scene, [0.5; 2]) {
            Some((radiance, from, _)) if f64::from(from.distance(scene.camera.position)) <= end => radiance,
            _ => Vec3::ZERO,
        };
        self.in_pixel(scene, start).iter().map(of_lamp).sum()
    }
}

/// Number of the pixel of a picture point within the picture.
fn pixel(scene: &Scene, [x, y]: [f32; 2]) -> u32 {
    y as u32 * scene.camera.width + x as u32
}

/// What a light adds to a pixel if all of it were in the one where a point of it is seen, that point, and where in the picture it is. None: that
/// point shines elsewhere, or is not in the picture.
fn seen(light: &Light, scene: &Scene, xi: [f32; 2]) -> Option<(Vec3, Vec3, [f32; 2])> {
    let (flux_density, from) = light.flux_density(scene.camera.position, xi);
    if !(flux_density.max_element() > 0.0) {
        return None;
    }
    let (x, y, importance) = scene.camera.project(from)?;
    Some((flux_density * importance, from, [x, y]))
}
