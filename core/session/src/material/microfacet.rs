//! GGX microfacets: how a rough surface spreads what its facets reflect and refract. Light meets one facet only: what others would catch of it
//! and send on is lost, 2 % of a white metal's light at α = 0.25, a tenth at 0.5, 40 % at 1.
//!
//! Source: B. Walter et al., "Microfacet Models for Refraction through Rough Surfaces", EGSR 2007; masking and shadowing correlated by height as
//! in E. Heitz, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs", JCGT 3(2), 2014.

use glam::Vec3;
use std::f32::consts::{PI, TAU};

/// Draws a facet in proportion to how much of it is seen.
///
/// - `view`: unit, from the surface to where light comes from or goes; `normal`: unit, on the same side.
/// - `alpha`: GGX's width, > 0.
///
/// Source: J. Dupuy and A. Benyoub, "Sampling Visible GGX Normals with Spherical Caps", HPG 2023.
pub(crate) fn visible_facet(view: Vec3, normal: Vec3, alpha: f32, [u, v]: [f32; 2]) -> Vec3 {
    let (e, f) = normal.any_orthonormal_pair();
    // The surface stretched until its facets are a hemisphere.
    let seen = Vec3::new(alpha * view.dot(e), alpha * view.dot(f), view.dot(normal)).normalize();
    let z = (1.0 - v) * (1.0 + seen.z) - seen.z;
    let (sine, cosine) = libm::sincosf(TAU * u);
    let r = (1.0 - z * z).max(0.0).sqrt();
    let half = Vec3::new(r * cosine, r * sine, z) + seen;
    (alpha * half.x * e + alpha * half.y * f + half.z.max(1e-6) * normal).normalize()
}

/// Facets a square metre of surface and steradian around an angle from the surface's normal, by its cosine.
pub(crate) fn density(cosine: f32, alpha: f32) -> f32 {
    // cos² θ (α² - 1) + 1, without its cancellation.
    let spread = (1.0 - cosine) * (1.0 + cosine) + (alpha * cosine) * (alpha * cosine);
    alpha * alpha / (PI * spread * spread)
}

/// Smith's Λ: how much more facets hide than show from a direction, by the cosine of its angle with the normal.
fn hidden(cosine: f32, alpha: f32) -> f32 {
    let tan2 = (1.0 - cosine) * (1.0 + cosine) / (cosine * cosine);
    0.5 * ((1.0 + alpha * alpha * tan2).sqrt() - 1.0)
}

/// Share of the facets that are seen from both directions.
pub(crate) fn seen_by_both(cos_in: f32, cos_out: f32, alpha: f32) -> f32 {
    1.0 / (1.0 + hidden(cos_in, alpha) + hidden(cos_out, alpha))
}

/// Of the facets seen from the first direction, the share seen from the second as well.
pub(crate) fn seen_too(cos_in: f32, cos_out: f32, alpha: f32) -> f32 {
    let first = 1.0 + hidden(cos_in, alpha);
    first / (first + hidden(cos_out, alpha))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Random, spread};

    const ALPHAS: [f32; 4] = [0.05, 0.25, 0.6, 1.0];

    /// Directions of a hemisphere around Z by a fine midpoint rule, with their solid angles; finer towards the pole, where D is narrow.
    fn hemisphere() -> impl Iterator<Item = (Vec3, f64)> {
        let (rings, parts) = (600, 400);
        (0..rings).flat_map(move |ring| {
            let s = (f64::from(ring) + 0.5) / f64::from(rings);
            // θ = π/2 s².
            let theta = 0.5 * std::f64::consts::PI * s * s;
            let solid = theta.sin() * std::f64::consts::PI * s / f64::from(rings) * std::f64::consts::TAU
                / f64::from(parts);
            (0..parts).map(move |part| {
                let (y, x) = ((f64::from(part) + 0.5) / f64::from(parts) * std::f64::consts::TAU).sin_cos();
                let direction =
                    Vec3::new((theta.sin() * x) as f32, (theta.sin() * y) as f32, theta.cos() as f32);
                (direction, solid)
            })
        })
    }

    fn views() -> [Vec3; 3] {
        [0.2f32, 0.9, 1.45].map(|angle| Vec3::new(angle.sin() * 0.6, angle.sin() * 0.8, angle.cos()))
    }

    #[test]
    fn facets_cover_the_surface_and_fill_what_is_seen_of_it() {
        for alpha in ALPHAS {
            let mut covered = 0.0;
            let mut seen = [0.0; 3];
            for (facet, solid) in hemisphere() {
                let facets = f64::from(density(facet.z, alpha)) * solid;
                covered += facets * f64::from(facet.z);
                for (seen, view) in seen.iter_mut().zip(views()) {
                    let shown = f64::from(seen_by_both(view.z, 1.0, alpha));
                    *seen += facets * f64::from(view.dot(facet).max(0.0)) * shown / f64::from(view.z);
                }
            }
            assert!((covered - 1.0).abs() < 1e-3, "{alpha}: {covered}");
            seen.iter().for_each(|seen| assert!((seen - 1.0).abs() < 2e-3, "{alpha}: {seen:?}"));
        }
    }

    /// Means of x, y, z, x², z² over the visible facets, drawn and by quadrature.
    #[test]
    fn facets_are_drawn_as_they_are_seen() {
        let moments = |facet: Vec3| [facet.x, facet.y, facet.z, facet.x * facet.x, facet.z * facet.z];
        for alpha in ALPHAS {
            for view in views() {
                let mut expected = [0.0f64; 5];
                for (facet, solid) in hemisphere() {
                    let seen =
                        f64::from(view.dot(facet).max(0.0) / view.z * seen_by_both(view.z, 1.0, alpha));
                    let weight = f64::from(density(facet.z, alpha)) * seen * solid;
                    for (sum, moment) in expected.iter_mut().zip(moments(facet)) {
                        *sum += weight * f64::from(moment);
                    }
                }
                let count = 40_000;
                let mut random = Random::new([1, 2, 3, 4]);
                let shift = [random.uniform(), random.uniform()];
                let mut found = [0.0f64; 5];
                for index in 0..count {
                    let facet = visible_facet(view, Vec3::Z, alpha, spread(shift, index));
                    assert!(view.dot(facet) > -1e-6);
                    for (sum, moment) in found.iter_mut().zip(moments(facet)) {
                        *sum += f64::from(moment) / count as f64;
                    }
                }
                for (found, expected) in found.iter().zip(expected) {
                    // The points of the sequence are even to 1e-4 or so; the quadrature is good to 1e-3.
                    assert!((found - expected).abs() < 3e-3, "α {alpha}, {view}: {found} for {expected}");
                }
            }
        }
    }
}
