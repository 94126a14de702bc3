//! Brute-force path tracing of a scene file, written plainly: an oracle that shares nothing with the renderer.
//!
//! It reads the file by itself, intersects in f64, and knows no beams, grids, kernels or stacks. Paths start at the camera; light is looked
//! for at lamps by shadow rays, which glass and mirrors stop, and found at lamps by paths that came by way of these. So it misses light that
//! lamps without a size send through glass or by way of mirrors, but for suns square on faces of boxes, which shadow rays go on through:
//! [`BruteForce::is_all_found`] says whether there is any.
//!
//! Balls, boxes and rectangles; black, matt, mirror and smooth glass; homogeneous media; lamps that are points, spots, disks, rectangles,
//! balls and suns; pinholes and parallel rays. All else is refused.

mod file;
mod lamps;
mod path;
mod shapes;
#[cfg(test)]
mod tests;
mod world;

use crate::random::Stream;
use covbeam_session::film::Picture;
use glam::DVec3;
use rayon::prelude::*;

/// A scene to trace.
pub struct BruteForce(world::World);

impl BruteForce {
    /// Reads the text of a scene file.
    ///
    /// # Errors
    /// What is not understood, or not known here.
    pub fn parse(text: &str) -> Result<Self, String> {
        file::read(text).map(Self)
    }

    /// Whether it finds all light: no lamp without a size shines through glass or by way of mirrors, unless it is a sun square on the faces of boxes.
    pub fn is_all_found(&self) -> bool {
        self.0.is_all_found()
    }

    /// Sets the picture's size \[pixels\].
    pub fn set_size(&mut self, [width, height]: [u32; 2]) {
        (self.0.camera.width, self.0.camera.height) = (width, height);
    }

    /// A picture of `paths` paths a pixel, at least one; the same bits for a seed, whatever the number of threads.
    pub fn picture(&self, seed: u32, paths: u32) -> Picture {
        let (width, height) = (self.0.camera.width, self.0.camera.height);
        let pixel = |number: u32| {
            let sum: DVec3 =
                (0..paths).map(|path| self.path(seed, [number % width, number / width], path)).sum();
            (sum / f64::from(paths)).as_vec3()
        };
        let radiance = (0..width * height).into_par_iter().map(pixel).collect();
        Picture { width, height, radiance, ..Picture::default() }
    }

    fn path(&self, seed: u32, [x, y]: [u32; 2], path: u32) -> DVec3 {
        let key = [seed, x, y, path].into_iter().fold(0, |key: u64, part| {
            // Mixed, since streams of neighbouring keys run into each other.
            Stream::new(key ^ u64::from(part)).bits()
        });
        let mut stream = Stream::new(key);
        let place = [x, y].map(|corner| f64::from(corner) + stream.uniform());
        path::radiance(&self.0, self.0.camera.ray(place[0], place[1]), &mut stream)
    }
}
