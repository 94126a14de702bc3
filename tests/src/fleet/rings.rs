//! Brightness by distance from the brightest part of a picture: what a filter that reaches too far gives away.

use crate::statistics::Sample;
use covbeam_session::color::luminance;
use covbeam_session::film::Picture;

/// Ends of the rings \[pixels\].
pub const ENDS: [f64; 6] = [3.0, 6.0, 10.0, 15.0, 22.0, 32.0];

/// A ratio with its standard error.
#[derive(Clone, Copy, Debug)]
pub struct Ratio {
    /// First over second.
    pub value: f64,
    /// Standard error.
    pub error: f64,
}

/// The ring of each pixel; None in the brightest part and beyond the last ring.
///
/// The brightest part is all that is above half of the 99th percentile of luminance.
pub fn rings(reference: &Picture) -> Vec<Option<usize>> {
    let values: Vec<f32> = reference.radiance.iter().map(|value| luminance(*value)).collect();
    let mut sorted = values.clone();
    sorted.sort_by(f32::total_cmp);
    let half = 0.5 * sorted[sorted.len() * 99 / 100];
    let at = |pixel: usize| {
        let pixel = pixel as u32;
        [f64::from(pixel % reference.width), f64::from(pixel / reference.width)]
    };
    let bright: Vec<[f64; 2]> = (0..values.len()).filter(|pixel| values[*pixel] > half).map(at).collect();
    let ring = |pixel: usize| {
        let [x, y] = at(pixel);
        let distances = bright.iter().map(|[u, v]| (x - u).hypot(y - v));
        let nearest = distances.fold(f64::INFINITY, f64::min);
        if nearest == 0.0 { None } else { ENDS.iter().position(|end| nearest < *end) }
    };
    (0..values.len()).map(ring).collect()
}

/// Luminance of all pixels of each ring.
pub fn sums(rings: &[Option<usize>], picture: &Picture) -> [f64; ENDS.len()] {
    let mut sums = [0.0; ENDS.len()];
    for (ring, value) in rings.iter().zip(&picture.radiance) {
        if let Some(ring) = ring {
            sums[*ring] += f64::from(luminance(*value));
        }
    }
    sums
}

/// Brightness of each ring over that of the reference, from independent pictures of either kind, at least two; None where a ring has no
/// pixels or no light.
pub fn ratios(rings: &[Option<usize>], tested: &[Picture], reference: &[Picture]) -> [Option<Ratio>; 6] {
    let [tested, reference] = [tested, reference]
        .map(|runs| runs.iter().map(|picture| sums(rings, picture)).collect::<Vec<[f64; ENDS.len()]>>());
    std::array::from_fn(|ring| {
        let [a, b] = [&tested, &reference]
            .map(|runs| Sample::of(&runs.iter().map(|sums| sums[ring]).collect::<Vec<f64>>()));
        let value = a.mean / b.mean;
        let error = value * (a.error / a.mean).hypot(b.error / b.mean);
        (b.mean > 0.0 && a.mean > 0.0).then_some(Ratio { value, error })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    /// A bright column and a picture that is 1.5 times too bright up to ten pixels from it.
    #[test]
    fn a_halo_shows_in_its_rings() {
        let picture = |halo: f32| {
            let radiance = (0..80 * 10).map(|pixel| {
                let distance = (pixel % 80_i32 - 40).abs();
                Vec3::splat(if distance == 0 {
                    10.0
                } else if distance < 10 {
                    0.1 * halo
                } else {
                    0.1
                })
            });
            let radiance: Vec<Vec3> = radiance.collect();
            Picture { width: 80, height: 10, radiance, ..Picture::default() }
        };
        let (sound, halo) = ([picture(1.0), picture(1.0)], [picture(1.5), picture(1.5)]);
        let rings = rings(&sound[0]);
        assert_eq!(rings[40], None);
        assert_eq!(rings[40 + 2], Some(0));
        assert_eq!(rings[40 - 31], Some(5));
        assert_eq!(rings[0], None);
        let found = ratios(&rings, &halo, &sound).map(|ratio| ratio.expect("light in each ring").value);
        for (value, expected) in found.into_iter().zip([1.5, 1.5, 1.5, 1.0, 1.0, 1.0]) {
            assert!((value - expected).abs() < 1e-6, "{found:?}");
        }
    }
}
