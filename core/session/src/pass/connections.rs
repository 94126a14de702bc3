//! Passes of light tracing: light paths connected with the camera.

use super::times::{PassTimes, timed};
use super::{CONNECTION_SEQUENCE, Renderer};
use crate::film::samples::PassImage;
use crate::paths::Record;
use crate::random::Random;
use glam::Vec3;
use rayon::prelude::*;

/// Purpose of the random numbers that say where light tracing looks for lamps.
const SHOWN_KEY: u32 = 0x5403;

impl Renderer<'_> {
    pub(super) fn light_trace(
        &mut self,
        index: u32,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Option<(PassImage, PassTimes)> {
        let (record, mut seconds) =
            self.trace(CONNECTION_SEQUENCE, index, self.paths, Record::Connections, cancelled)?;
        self.energy = record.energy;
        let (width, height) = (self.scene.camera.width, self.scene.camera.height);
        let mut radiance = vec![Vec3::ZERO; (width * height) as usize];
        for splat in record.splats {
            radiance[splat.pixel as usize] += splat.radiance;
        }
        if self.scene.camera.is_pinhole() && self.scene.shows_surfaces() && !self.scene.shown.is_empty() {
            // Connections start where light has met something.
            let row = |(y, row): (usize, &mut [Vec3])| {
                let add =
                    || row.iter_mut().zip(0..).for_each(|(sum, x)| *sum += self.shown(index, [x, y as u32]));
                (!cancelled()).then(|| timed(add).1)
            };
            seconds += radiance.par_chunks_mut(width as usize).enumerate().map(row).sum::<Option<f64>>()?;
        }
        let times = PassTimes { trace: seconds, ..PassTimes::default() };
        Some((PassImage { pass: index, width, height, radiance, ..PassImage::default() }, times))
    }

    /// Lamps that an eye ray somewhere through a pixel sees straight.
    fn shown(&self, index: u32, corner: [u32; 2]) -> Vec3 {
        let pixel = corner[1] * self.scene.camera.width + corner[0];
        let mut random = Random::new([self.settings.seed, index, pixel, SHOWN_KEY]);
        let start = self.starts.at(corner.map(|corner| corner as f32 + random.uniform()), [0.0; 2]);
        let seen = self.scene.shown.seen(self.scene, &self.small, &self.starts, &start);
        seen.iter().map(|seen| seen.dimmed(self.scene, self.tracer.fogs())).sum()
    }
}
