//! Light that facets send on to others: how much more leaves a rough surface than what has met a single facet.
//!
//! Source: E. Turquin, "Practical Multiple Scattering Compensation for Microfacet Models", 2019, as in Cycles: what has met a single one, times a gain
//! by the angle at which the camera looks, so that a white surface keeps nothing. The mean of Fresnel's term for dielectrics: C. Kulla and A.
//! Conty, "Revisiting Physically Based Shading at Imageworks", 2017.

use glam::Vec3;

/// Steps of a row and of a column.
const STEPS: f32 = 8.0;

/// Share of light that leaves white facets of GGX after one reflection: in rows of the roughness √α from 1/8 to 1, by the root of the cosine from 0
/// to 1. The smooth surface, whose row would be 1, keeps nothing.
const ALBEDO: [[f32; 9]; 8] = [
    [0.9999, 0.8920, 0.9645, 0.9927, 0.9978, 0.9991, 0.9996, 0.9998, 1.0000],
    [1.0000, 0.9504, 0.8887, 0.9185, 0.9614, 0.9819, 0.9903, 0.9940, 0.9959],
    [1.0000, 0.9710, 0.9117, 0.8752, 0.8880, 0.9217, 0.9494, 0.9662, 0.9755],
    [1.0000, 0.9737, 0.9212, 0.8686, 0.8401, 0.8433, 0.8663, 0.8934, 0.9158],
    [1.0000, 0.9690, 0.9114, 0.8499, 0.7994, 0.7697, 0.7631, 0.7745, 0.7956],
    [1.0000, 0.9601, 0.8889, 0.8130, 0.7445, 0.6898, 0.6523, 0.6320, 0.6269],
    [0.9999, 0.9484, 0.8584, 0.7630, 0.6749, 0.5992, 0.5372, 0.4885, 0.4521],
    [0.9999, 0.9348, 0.8229, 0.7056, 0.5976, 0.5040, 0.4253, 0.3603, 0.3069],
];

/// Means of its rows over the hemisphere, by cosines.
const MEAN_ALBEDO: [f32; 8] = [0.9992, 0.9886, 0.9515, 0.8823, 0.7803, 0.6562, 0.5273, 0.4091];

/// Of a table by roughness, with 1 where that is 0.
fn by_roughness(alpha: f32, row: impl Fn(usize) -> f32) -> f32 {
    let at = STEPS * alpha.clamp(0.0, 1.0).sqrt();
    let low = (at as usize).min(STEPS as usize - 1);
    let of = |step: usize| step.checked_sub(1).map_or(1.0, &row);
    let share = at - low as f32;
    (1.0 - share) * of(low) + share * of(low + 1)
}

/// Share of light that leaves white facets after one reflection, by the cosine of light or view. Within .03, but for grazing light on
/// what is nearly smooth.
pub(crate) fn albedo(cosine: f32, alpha: f32) -> f32 {
    let at = STEPS * cosine.clamp(0.0, 1.0).sqrt();
    let low = (at as usize).min(STEPS as usize - 1);
    let share = at - low as f32;
    by_roughness(alpha, |row| (1.0 - share) * ALBEDO[row][low] + share * ALBEDO[row][low + 1])
}

/// What leaves in all over what has met a single facet, >= 1.
///
/// - `cosine`: at which the camera looks; `reflectance`: of facets, the mean over all angles, in [0, 1].
pub(crate) fn gain(cosine: f32, alpha: f32, reflectance: Vec3) -> Vec3 {
    let (here, mean) = (albedo(cosine, alpha), by_roughness(alpha, |row| MEAN_ALBEDO[row]));
    let others = reflectance * mean / (Vec3::ONE - reflectance * (1.0 - mean));
    Vec3::ONE + others * ((1.0 - here) / here)
}

/// Mean over all angles, by their cosines, of what a dielectric reflects.
///
/// - `index`: of the inside over that of the outside; below 1 as 1.
pub(crate) fn mean_dielectric(index: f32) -> f32 {
    let index = index.max(1.0);
    (index - 1.0) / (4.08567 + 1.00071 * index)
}

/// Mean over all angles, by their cosines, of what Schlick's curve reflects.
pub(crate) fn mean_metal(metal: Vec3, edge: Vec3) -> Vec3 {
    metal + (edge - metal) / 21.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::microfacet::{density, seen_by_both};
    use std::f64::consts::{FRAC_PI_2, PI, TAU};

    /// ∫ D G₂/(4 cos) over the directions that light leaves in.
    fn quadrature(cosine: f32, alpha: f32) -> f64 {
        let view = [(1.0 - cosine * cosine).sqrt(), 0.0, cosine].map(f64::from);
        let (rings, parts) = (600, 300);
        let mut sum = 0.0;
        for ring in 0..rings {
            let theta = FRAC_PI_2 * (f64::from(ring) + 0.5) / f64::from(rings);
            for part in 0..parts {
                let phi = PI * (f64::from(part) + 0.5) / f64::from(parts);
                let out = [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()];
                let half = [0, 1, 2].map(|axis| out[axis] + view[axis]);
                let facet = half[2] / half.iter().map(|part| part * part).sum::<f64>().sqrt();
                let seen = seen_by_both(cosine, out[2] as f32, alpha);
                let solid = theta.sin() * FRAC_PI_2 / f64::from(rings) * TAU / f64::from(parts);
                sum += solid * f64::from(density(facet as f32, alpha) * seen) / (4.0 * f64::from(cosine));
            }
        }
        sum
    }

    #[test]
    fn the_table_is_the_integral_of_the_scattering_function() {
        for roughness in [0.5, 0.56, 0.75, 0.8, 1.0_f32] {
            let alpha = roughness * roughness;
            for cosine in [0.1, 0.3, 0.5, 0.77, 1.0] {
                let (found, expected) = (albedo(cosine, alpha), quadrature(cosine, alpha));
                assert!(
                    (f64::from(found) - expected).abs() < 0.02,
                    "{roughness}, {cosine}: {found}, {expected}"
                );
            }
            let mean = by_roughness(alpha, |row| MEAN_ALBEDO[row]);
            let expected: f32 =
                (0..200).map(|i| (i as f32 + 0.5) / 200.0).map(|c| albedo(c, alpha) * c / 100.0).sum();
            assert!((mean - expected).abs() < 0.01, "{roughness}: {mean}, {expected}");
        }
        // 1 - ln 2, in closed form.
        assert!((albedo(1.0, 1.0) - (1.0 - 2f32.ln())).abs() < 1e-3);
        assert_eq!(albedo(0.3, 0.0), 1.0);
    }

    #[test]
    fn white_keeps_nothing_and_black_gains_nothing() {
        for (cosine, alpha) in [(0.2, 0.1), (0.7, 0.5), (1.0, 1.0)] {
            let white = gain(cosine, alpha, Vec3::ONE) * albedo(cosine, alpha);
            assert!((white - 1.0).abs().max_element() < 1e-5, "{white}");
            assert_eq!(gain(cosine, alpha, Vec3::ZERO), Vec3::ONE);
        }
    }

    /// Fresnel's equations and Schlick's curve, integrated.
    #[test]
    fn mean_reflectances_are_integrals() {
        let mean = |of: &dyn Fn(f64) -> f64| -> f64 {
            (0..20_000).map(|i| (f64::from(i) + 0.5) / 2e4).map(|c| of(c) * c / 1e4).sum()
        };
        for index in [1.1_f64, 1.33, 1.5, 2.0, 2.5] {
            let fresnel = |cosine: f64| {
                let inside = (1.0 - (1.0 - cosine * cosine) / (index * index)).sqrt();
                let s = (cosine - index * inside) / (cosine + index * inside);
                let p = (index * cosine - inside) / (index * cosine + inside);
                0.5 * (s * s + p * p)
            };
            let (found, expected) = (f64::from(mean_dielectric(index as f32)), mean(&fresnel));
            // So well does the published fit.
            assert!((found - expected).abs() < 7e-3, "{index}: {found}, {expected}");
        }
        let schlick = mean(&|cosine: f64| 0.3 + 0.6 * (1.0 - cosine).powi(5));
        let found = mean_metal(Vec3::splat(0.3), Vec3::splat(0.9)).x;
        assert!((f64::from(found) - schlick).abs() < 1e-6, "{found}, {schlick}");
    }
}
