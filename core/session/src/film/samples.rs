//! What the eye rays of one pass saw.

use crate::camera::Camera;
use crate::eye::segment::EyeSegment;
use crate::kind::{ByKind, Kind};
use crate::plan::Plan;
use glam::Vec3;

/// One pass' picture, row by row from the upper left pixel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PassImage {
    /// Number of the pass, counted from 1.
    pub pass: u32,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Estimate of radiance [W/(m² sr)]; empty where not every pixel has an eye ray.
    pub radiance: Vec<Vec3>,
    /// Its parts by kind of light; empty where those are not told apart, and where not every pixel has an eye ray.
    pub kinds: Vec<ByKind>,
    /// Per pixel, over accepted pairs with contribution c (luminance): Σ c, Σ c·radius, Σ c·σ, number of pairs.
    /// Empty for methods that gather nothing (light-trace), and where not every pixel has an eye ray.
    pub gather: Vec<[f32; 4]>,
    /// The eye rays, where not every pixel has one.
    pub sparse: Option<SparseSamples>,
}

impl PassImage {
    /// A pass without any light.
    pub fn black(camera: &Camera, pass: u32) -> Self {
        let (width, height) = (camera.width, camera.height);
        let radiance = vec![Vec3::ZERO; (width * height) as usize];
        Self { pass, width, height, radiance, ..Self::default() }
    }
}

/// What few eye rays saw.
#[derive(Clone, Debug, PartialEq)]
pub struct SparseSamples {
    /// The plans that the eye rays were chosen by, one a layer.
    pub plans: Vec<Plan>,
    /// The fog before the first surface.
    pub fog: Vec<FogSample>,
    /// The rest: at most one a pixel.
    pub samples: Vec<SparseSample>,
}

/// What one eye ray saw of a layer of the fog before the first surface, which is filtered as its plan says.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FogSample {
    /// Number of the pixel.
    pub pixel: u32,
    /// Number of the layer.
    pub layer: u32,
    /// Radiance.
    pub radiance: Vec3,
}

/// What one eye ray saw of all else that was wanted from it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SparseSample {
    /// Number of the pixel.
    pub pixel: u32,
    /// Whether it was asked for that.
    pub has_surfaces: bool,
    /// Surfaces, and all that is seen through and in them, and what media send out; without plans, the fog too.
    pub light: ByKind,
    /// As [`PassImage::gather`].
    pub gather: [f32; 4],
}

/// Samples of some eye rays of a pass. All of a pass lie in one block, which goes back to the system as a whole: small ones, a thread's each,
/// leave holes that the picture does not fit into.
#[derive(Debug)]
pub(crate) struct Seen<'a> {
    pub(crate) rays: &'a mut [SparseSample],
    pub(crate) fog: &'a mut [FogSample],
}

impl Seen<'_> {
    /// Adds what a piece of an eye path sees at its start.
    ///
    /// - `ray`: number of its eye ray; `fog`: number of the sample for fog before the first surface, if it has one.
    pub(crate) fn add(
        &mut self,
        ray: usize,
        fog: Option<usize>,
        segment: &EyeSegment,
        kind: Kind,
        radiance: Vec3,
    ) {
        let radiance = segment.throughput * radiance;
        match fog.filter(|_| segment.is_first()) {
            Some(fog) => self.fog[fog].radiance += radiance,
            None => self.rays[ray].light[kind as usize] += radiance,
        }
    }
}

/// Room for a pass' samples: [rays, samples of fog] for each part.
pub(crate) struct Room {
    counts: Vec<[usize; 2]>,
    rays: Vec<SparseSample>,
    fog: Vec<FogSample>,
}

impl Room {
    pub(crate) fn new(counts: Vec<[usize; 2]>) -> Self {
        let [rays, fog] = [0, 1].map(|which: usize| counts.iter().map(|count| count[which]).sum());
        Self { rays: vec![SparseSample::default(); rays], fog: vec![FogSample::default(); fog], counts }
    }

    pub(crate) fn parts(&mut self) -> Vec<Seen<'_>> {
        let (mut rays, mut fog) = (&mut self.rays[..], &mut self.fog[..]);
        let part = |&[ray_count, fog_count]: &[usize; 2]| Seen {
            rays: rays.split_off_mut(..ray_count).expect("room for all"),
            fog: fog.split_off_mut(..fog_count).expect("room for all"),
        };
        self.counts.iter().map(part).collect()
    }

    /// The pass' picture. Without plans there is one eye ray through every pixel.
    pub(crate) fn image(self, pass: u32, [width, height]: [u32; 2], plans: Vec<Plan>) -> PassImage {
        let Self { rays, fog, .. } = self;
        let mut image = PassImage { pass, width, height, ..PassImage::default() };
        if !plans.is_empty() {
            image.sparse = Some(SparseSamples { plans, fog, samples: rays });
            return image;
        }
        image.radiance.resize(rays.len(), Vec3::ZERO);
        image.kinds.resize(rays.len(), ByKind::default());
        image.gather.resize(rays.len(), [0.0; 4]);
        for SparseSample { pixel, light, gather, .. } in rays {
            let pixel = pixel as usize;
            image.radiance[pixel] = light.iter().sum();
            image.kinds[pixel] = light;
            image.gather[pixel] = gather;
        }
        image
    }
}
