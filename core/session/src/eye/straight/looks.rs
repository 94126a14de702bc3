//! How many eye rays look for straight light through each pixel: more where a few that were tried first differ more.
//!
//! Straight light is smooth nearly everywhere, and has its noise in few pixels: beside lamps, where it goes as one over the distance, and where the
//! borders of beams and shadows pass through a pixel. With variance v a look, n looks leave v/n: of as many looks in all, the sum is least for n in
//! proportion to the root of v. Where a lamp is so small that four looks may miss it, pixels beside it have a number of their own.

use super::{Straight, cost_in};
use crate::color::luminance;
use crate::eye::EyeTracer;
use crate::lamps::beside::BesideLamps;
use crate::random::Random;
use rayon::prelude::*;

/// Pixels that are tried, at most, of all instants: of larger pictures one in each block of pixels. Fewer by what a shadow ray costs more among
/// voxels. With 10,000 leaves, slats and sixty spots have the same error after as many passes, half a second later.
const TRIED: usize = 2_500;

/// Looks through each of them.
const TRIALS: u32 = 4;

/// Standard deviation of a look, over the picture's mean of straight light, at which one is enough: what is smoother falls fast with the passes by
/// itself. With .02 posts and cards take a quarter more time for nothing, with .3 slats have 1.2 times the variance.
const SMOOTH: f32 = 0.1;

/// Most looks of a pixel.
const MOST: f32 = 64.0;

/// Most looks beyond one a pixel, over the picture's pixels.
const BEYOND: f32 = 1.0;

/// Purposes of random numbers: which pixel of a block, and where in it.
const BLOCK_KEY: u32 = 0x0b10_c000;
const PLACE_KEY: u32 = 0x91ac_e000;

/// Looks by pixel.
#[derive(Clone, Debug)]
pub(crate) struct StraightLooks {
    side: u32,
    across: u32,
    /// Of the pixels of each block, row by row.
    looks: Vec<u32>,
    beside: BesideLamps,
}

impl StraightLooks {
    /// Tries the fog before the first surface, at one of so many `instants`. `cancelled` is polled; None = it said yes.
    pub(crate) fn new(
        straight: &Straight,
        tracer: &EyeTracer,
        instants: usize,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Option<Self> {
        let camera = &straight.scene.camera;
        let (width, height) = (camera.width, camera.height);
        let dearest = straight.scene.media.iter().map(cost_in).fold(1.0, f32::max);
        let most = ((TRIED as f32 / dearest) as usize / instants).max(1);
        let side = (1..).find(|side| (width.div_ceil(*side) * height.div_ceil(*side)) as usize <= most)?;
        let (across, down) = (width.div_ceil(side), height.div_ceil(side));
        let tried = |block: u32| {
            let mut random = Random::new([straight.seed, block, 0, BLOCK_KEY]);
            let mut place = |block: u32, end: u32| {
                let (from, to) = (block * side, ((block + 1) * side).min(end));
                (from + ((to - from) as f32 * random.uniform()) as u32).min(to - 1)
            };
            let pixel = [place(block % across, width), place(block / across, height)];
            (!cancelled()).then(|| mean_and_variance(straight, tracer, pixel))
        };
        let tried: Option<Vec<[f32; 2]>> = (0..across * down).into_par_iter().map(tried).collect();
        let tried = tried?;
        let mean = tried.iter().map(|[mean, _]| mean).sum::<f32>() / tried.len() as f32;
        let variances: Vec<f32> = tried.iter().map(|[_, variance]| *variance).collect();
        let looks = shared_out(&around(&variances, across as usize), SMOOTH * mean);
        Some(Self { side, across, looks, beside: BesideLamps::new(straight.scene) })
    }

    /// Those of pixel (x, y).
    pub(crate) fn at(&self, x: u32, y: u32) -> u32 {
        let tried = self.looks[(y / self.side * self.across + x / self.side) as usize];
        self.beside.looks([x, y]).map_or(tried, |beside| beside.max(tried))
    }
}

/// Mean and variance of the looks through a pixel, each at places of its own.
fn mean_and_variance(straight: &Straight, tracer: &EyeTracer, [x, y]: [u32; 2]) -> [f32; 2] {
    let pixel = y * straight.scene.camera.width + x;
    let (mut pieces, mut knots) = (Vec::new(), Vec::new());
    let (mut sum, mut squares) = (0.0, 0.0);
    for look in 0..TRIALS {
        let mut random = Random::new([straight.seed, look, pixel, PLACE_KEY]);
        let place = [x, y].map(|pixel| pixel as f32 + random.uniform());
        let start = tracer.starts.at(place, tracer.starts.place_in_lens(straight.seed, pixel, look));
        pieces.clear();
        tracer.trace_wanted(&start, pixel, [true, false], &mut random, &mut pieces);
        // Not the places of any pass: those would be chosen by what is seen there.
        let straight = Straight { pass: look + 1, seed: !straight.seed, ..*straight };
        let light = pieces
            .iter()
            .filter(|piece| piece.is_first())
            .map(|piece| piece.throughput * straight.radiance(piece, pixel, 1.0, (0, TRIALS), &mut knots));
        let light = luminance(light.sum());
        (sum, squares) = (sum + light, squares + light * light);
    }
    let mean = sum / TRIALS as f32;
    [mean, ((squares - sum * mean) / (TRIALS - 1) as f32).max(0.0)]
}

/// The mean over each block and those around it: four looks may all miss a border that crosses their pixel.
fn around(values: &[f32], across: usize) -> Vec<f32> {
    let down = values.len() / across;
    let mean = |at: usize| {
        let near = |place: usize, count: usize| place.saturating_sub(1)..(place + 2).min(count);
        let (columns, rows) = (near(at % across, across), near(at / across, down));
        let count = columns.len() * rows.len();
        rows.map(|row| values[row * across..][columns.clone()].iter().sum::<f32>()).sum::<f32>()
            / count as f32
    };
    (0..values.len()).map(mean).collect()
}

/// Looks in proportion to the root of a variance, one where that is `smooth`; no more than [`BEYOND`] in all.
fn shared_out(variances: &[f32], smooth: f32) -> Vec<u32> {
    let looks = |variance: f32, scale: f32| (variance.sqrt() * scale).clamp(1.0, MOST);
    let beyond = |scale: f32| variances.iter().map(|variance| looks(*variance, scale) - 1.0).sum::<f32>();
    let most = BEYOND * variances.len() as f32;
    let (mut low, mut high) = (0.0, smooth.recip());
    if !high.is_finite() {
        return vec![1; variances.len()];
    }
    if beyond(high) > most {
        // Halved as often as f32 has bits.
        for _ in 0..24 {
            let middle = 0.5 * (low + high);
            *(if beyond(middle) > most { &mut high } else { &mut low }) = middle;
        }
        high = low;
    }
    variances.iter().map(|variance| looks(*variance, high).round() as u32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paths::PhotonTracer;
    use crate::random::Emission;
    use crate::scene::Scene;
    use crate::scene::made::{Made, camera, cuboid, lambert, spot};
    use crate::surface::SurfaceMap;
    use crate::{eye::starts::EyeStarts, scene::Light};
    use glam::Vec3;

    fn looks(scene: &Scene) -> StraightLooks {
        let paths = PhotonTracer::new(scene, 1, Emission::default());
        let no_photons = SurfaceMap::empty();
        let (fogs, lamps) = (paths.fogs(), paths.lamps());
        let straight = Straight { scene, fogs, lamps, seed: 1, pass: 1, near: Some(paths.near()) };
        let tracer = EyeTracer {
            scene,
            fogs,
            starts: EyeStarts::new(scene),
            lamps,
            surfaces: &no_photons,
            beyond: false,
            shown: None,
            is_apart: false,
        };
        StraightLooks::new(&straight, &tracer, 1, &|| false).expect("never cancelled")
    }

    fn lit(lights: Vec<Light>, pixels: [u32; 2]) -> Scene {
        let camera = camera([0.0, 1.0, -9.0], [0.0, 1.0, 0.0], 40.0, pixels);
        let block = cuboid([-0.5, 0.0, -0.5], [0.5, 1.0, 0.5]);
        let made = Made::new(camera).fog(0.1, 0.02).in_fog().object(block, lambert(0.2));
        lights.into_iter().fold(made, Made::light).scene()
    }

    #[test]
    fn pixels_at_a_lamp_and_at_borders_of_beams_have_more_looks_than_smooth_ones() {
        let (center, radius, radiance) = (Vec3::new(2.0, 2.5, 0.0), 0.05, Vec3::splat(500.0));
        let made = looks(&lit(vec![Light::Sphere { center, radius, radiance }], [48, 32]));
        // 9 m away: a pixel is .2 m there.
        let pixels_of =
            |at: Vec3| [24.0 - at.x / 0.205, 16.0 - (at.y - 1.0) / 0.205].map(|place| place as u32);
        let [x, y] = pixels_of(center);
        let beside = (x - 1..=x + 1).flat_map(|x| (y - 1..=y + 1).map(move |y| (x, y)));
        let most = beside.map(|(x, y)| made.at(x, y)).max();
        let mirrored = made.at(47 - x, y);
        assert!(
            most >= Some(8) && made.at(2, 29) == 1 && mirrored < 4,
            "{most:?} {mirrored} {:?}",
            made.looks
        );

        // The border of a narrow beam, and its dark sides.
        let beam = looks(&lit(vec![spot([0.0, 4.0, 0.0], [0.0, 0.0, 0.0], 50.0, [4.0, 4.1])], [48, 32]));
        let row: Vec<u32> = (0..48).map(|x| beam.at(x, 8)).collect();
        assert!(row[21..27].iter().any(|looks| *looks > 1), "{row:?}");
        assert!(row[..16].iter().chain(&row[32..]).all(|looks| *looks == 1), "{row:?}");
    }

    #[test]
    fn a_dark_picture_has_one_look_a_pixel_and_a_large_one_is_tried_in_blocks() {
        // The lamp is behind the camera, and shines away from it.
        let dark = looks(&lit(vec![spot([0.0, 1.0, -20.0], [0.0, 1.0, -40.0], 50.0, [4.0, 5.0])], [48, 32]));
        assert!(dark.looks.iter().all(|looks| *looks == 1));
        let large = looks(&lit(vec![spot([0.0, 4.0, 0.0], [0.0, 0.0, 0.0], 50.0, [20.0, 40.0])], [403, 201]));
        assert!(large.looks.len() <= TRIED && large.side == 6);
        assert!((0..201).all(|y| (0..403).all(|x| large.at(x, y) >= 1)));
    }

    #[test]
    fn looks_go_with_the_root_of_the_variance_and_have_a_bound() {
        let mut variances = vec![0.0; 96];
        variances.extend([1.0, 4.0, 16.0, 1e6]);
        let looks = shared_out(&variances, 0.5);
        assert_eq!(looks[..96], [1; 96]);
        assert_eq!(looks[96..], [2, 4, 8, 64]);
        // Where all are as noisy each has as many as the bound leaves, whatever the noise.
        for variance in [1e-30, 1.0, 1e30] {
            assert_eq!(shared_out(&[variance; 100], 1e-3 * f32::sqrt(variance)), [2; 100], "{variance}");
        }
        // What is looked at without any light has no noise to compare with.
        assert_eq!(shared_out(&[0.0; 4], 0.0), [1; 4]);
    }

    #[test]
    fn variances_are_shared_with_the_blocks_around() {
        let mut variances = vec![0.0; 20];
        variances[7] = 18.0;
        // Five across; a corner has four around it, a side six.
        let shared = around(&variances, 5);
        let expected = [0.0, 3.0, 3.0, 3.0, 0.0, 0.0, 2.0, 2.0, 2.0, 0.0, 0.0, 2.0, 2.0, 2.0, 0.0];
        assert_eq!(shared[..15], expected);
        assert_eq!(shared[15..], [0.0; 5]);
    }
}
