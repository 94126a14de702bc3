//! Eye paths: up to the ball, reflected there, and what leaves it again.

use crate::ball::{Place, Ray};
use crate::scene::{EYE, HALF_HEIGHT, Scene};
use covbeam::{EyeRay, Vec3};

/// Pixels of a tile's side, whose eye rays are gathered side by side.
pub(crate) const TILE: u32 = 32;

/// Kinds of pieces: up to the ball, reflected there, what leaves it after 0 and 1 reflections inside.
pub(crate) const KINDS: usize = 4;

/// Pieces that a pixel sees less of are left out.
const FAINT: f32 = 0.004;

/// A straight piece of an eye path through the fog.
pub(crate) struct Piece {
    pub(crate) ray: EyeRay,
    pub(crate) pixel: usize,
    /// How much of its light the pixel sees.
    pub(crate) weight: f32,
}

/// What a tile of pixels sees, by kind: pieces of a kind run side by side.
#[derive(Default)]
pub(crate) struct Tile {
    pub(crate) pieces: [Vec<Piece>; KINDS],
}

/// Width and height of the picture in pixels, multiples of [`TILE`].
#[derive(Clone, Copy)]
pub(crate) struct Size {
    pub(crate) width: u32,
    pub(crate) height: u32,
}

impl Size {
    pub(crate) fn pixels(self) -> usize {
        self.width as usize * self.height as usize
    }
}

/// The eye ray through a place in a pixel, in [0, 1)².
pub(crate) fn eye_ray(size: Size, [x, y]: [u32; 2], [u, v]: [f32; 2]) -> Ray {
    let scale = 2.0 * HALF_HEIGHT / size.height as f32;
    let right = (x as f32 + u - 0.5 * size.width as f32) * scale;
    let up = (0.5 * size.height as f32 - y as f32 - v) * scale;
    Ray::in_fog(EYE, Vec3::new(right, up, 1.0).normalize())
}

impl Tile {
    /// The eye paths of the tile whose first pixel is (`x0`, `y0`), at one place in all pixels. The fog before
    /// the ball is seen where `chooses` says so.
    pub(crate) fn trace(
        &mut self,
        scene: &Scene,
        size: Size,
        [x0, y0]: [u32; 2],
        place: [f32; 2],
        chooses: impl Fn(usize) -> bool,
    ) {
        self.pieces.iter_mut().for_each(Vec::clear);
        for y in y0..y0 + TILE {
            for x in x0..x0 + TILE {
                let pixel = (y * size.width + x) as usize;
                let ray = eye_ray(size, [x, y], place);
                let distance = scene.ball.distance(&ray);
                if chooses(pixel) {
                    self.see(0, &ray, distance, 1.0, pixel);
                }
                if distance < f32::INFINITY {
                    self.trace_ball(scene, &ray, distance, pixel);
                }
            }
        }
    }

    fn trace_ball(&mut self, scene: &Scene, ray: &Ray, distance: f32, pixel: usize) {
        let mut weight = scene.fog.transmittance(distance).x;
        let mut split = scene.ball.split(ray, distance);
        self.see(1, &split.reflected, f32::INFINITY, weight * split.reflectance, pixel);
        weight *= 1.0 - split.reflectance;
        let mut inside = split.refracted;
        for kind in 2..KINDS {
            split = scene.ball.split(&inside, scene.ball.distance(&inside));
            self.see(kind, &split.refracted, f32::INFINITY, weight * (1.0 - split.reflectance), pixel);
            weight *= split.reflectance;
            inside = split.reflected;
        }
    }

    fn see(&mut self, kind: usize, ray: &Ray, length: f32, weight: f32, pixel: usize) {
        debug_assert!(ray.place != Place::Inside);
        if weight >= FAINT {
            let ray = EyeRay { origin: ray.origin, direction: ray.direction, length };
            self.pieces[kind].push(Piece { ray, pixel, weight });
        }
    }
}
