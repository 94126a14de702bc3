//! Light next to lamps that are points, left to beams there: along an eye ray it goes as one over the distance from the lamp, and in a narrow
//! cone it is thinner than a pixel, so that it is a matter of luck whether the eye rays of some passes meet it.

use crate::scene::Scene;
use covbeam::{Kernel, Schedule};
use std::f32::consts::FRAC_PI_4;

/// How far from a lamp that shines all around its light is left to beams, in pixels there; and half of how wide a cone is where that ends.
/// Twice as far brings nothing.
const REACH: f32 = 0.5;

/// Radius of the kernels of these beams in the first pass, in pixels at the lamp, so that each eye ray through a pixel meets a line in it. They
/// fall as passes^-(1/3), faster than other ones, or the pixels beside a lamp get more light from it than they have themselves.
const RADIUS: f32 = 0.5;
const ALPHA: f32 = 2.0 / 3.0;

/// How far from each lamp its light is left to beams, and how wide these are.
pub(crate) struct Near {
    /// By lamp; infinity: wherever it shines. 0 of lamps that have a size.
    reaches: Vec<f32>,
    /// Of the kernels in the first pass; 0 where no lamp is a point.
    radius: f32,
}

impl Near {
    /// Half a pixel far from each lamp, and in a cone as far as it is thinner than one.
    pub(crate) fn new(scene: &Scene) -> Self {
        let camera = &scene.camera;
        let pixels = (camera.width as f32 * camera.height as f32).sqrt();
        let mut sides = Vec::new();
        let reaches = scene.lights.iter().map(|light| {
            let Some(half_angle) = light.half_angle_of_point() else { return 0.0 };
            let side = camera.side_at(light.position().distance(camera.position)) / pixels;
            sides.push(side);
            REACH * side / libm::tanf(half_angle.min(FRAC_PI_4))
        });
        let reaches = reaches.collect();
        sides.sort_by(f32::total_cmp);
        let radius = sides.get(sides.len() / 2).map_or(0.0, |middle| RADIUS * middle);
        Self { reaches, radius }
    }

    /// How far from a lamp its light is left to beams.
    pub(crate) fn reach(&self, lamp: usize) -> f32 {
        self.reaches[lamp]
    }

    /// What these beams are seen through in a pass; `schedule`: of other ones.
    pub(crate) fn kernel(&self, schedule: Schedule, pass: u32) -> Kernel<'static> {
        Schedule { radius: self.radius, alpha: ALPHA, max_radius: 0.0, ..schedule }.kernel(pass, None)
    }
}
