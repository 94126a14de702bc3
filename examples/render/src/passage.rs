//! What is left of light on the straight way between two points.

use crate::media;
use crate::optics::{Boundary, Interior};
use crate::scene::{Material, Scene};
use covbeam::Medium;
use glam::Vec3;

/// Surfaces that a way may cross, there and back through as many as an [`Interior`] holds.
const MOST_BOUNDARIES: usize = 2 * Interior::DEEPEST;

/// Per channel, what is left of light between two points; 0 if anything is between them but sides of dielectrics where the index is the same
/// on both, which bound a medium and do not bend light, and what is transparent in part.
///
/// - `interior`: of `from`. Ends on surfaces should be moved off them.
pub(crate) fn passage(scene: &Scene, fogs: &[Medium], mut interior: Interior, from: Vec3, to: Vec3) -> Vec3 {
    let through = |interior: &Interior, from, to| {
        let fog = interior.medium(scene).map(|id| &fogs[id as usize]);
        fog.map_or(Vec3::ONE, |fog| media::transmittance(fog, from, to))
    };
    if !scene.occluded(from, to) {
        return through(&interior, from, to);
    }
    if !scene.may_be_seen_through() {
        return Vec3::ZERO;
    }
    let (mut left, mut start) = (Vec3::ONE, from);
    for _ in 0..MOST_BOUNDARIES {
        let distance = start.distance(to);
        let direction = (to - start) / distance;
        // What is exactly at the end does not lie between, and at its start nothing is left of a way.
        let hit = if distance > 0.0 { scene.intersect(start, direction, distance) } else { None };
        let Some(hit) = hit else { return left * through(&interior, start, to) };
        let (share, beyond) = match scene.objects[hit.object as usize].material {
            Material::Dielectric { .. } => {
                let boundary = Boundary::new(scene, &hit, direction, &interior);
                if !boundary.is_matched() {
                    return Vec3::ZERO;
                }
                (Vec3::ONE, boundary.beyond)
            }
            Material::Lobes(lobes) if lobes.transparent != Vec3::ZERO => {
                let beyond = if lobes.is_glass() { interior.beyond(&hit, direction) } else { interior };
                (lobes.transparent, beyond)
            }
            _ => return Vec3::ZERO,
        };
        left *= share * through(&interior, start, hit.position);
        interior = beyond;
        start = hit.leave(direction);
    }
    Vec3::ZERO
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn scene(index: f32, more: &str) -> Scene {
        let text = format!(
            "outside_medium = \"haze\"\n\
             [camera]\nposition = [0, 0, -9]\nlook_at = [0, 0, 0]\nvertical_fov = 40\nwidth = 8\nheight = 8\n\
             [[medium]]\nname = \"haze\"\nscattering = 0.1\nabsorption = 0\n\
             [[medium]]\nname = \"fog\"\nscattering = [1, 2, 3]\nabsorption = 0\n\
             [[object]]\nname = \"box\"\nshape = \"box\"\nmin = [-1, -1, -1]\nmax = [1, 1, 1]\n\
             material = {{ dielectric = {{ index = {index} }} }}\ninside = \"fog\"\n{more}\
             [[light]]\nkind = \"point\"\nposition = [0, 4, 0]\nintensity = 1\n"
        );
        Scene::parse(&text, "box of fog", Path::new("")).expect("a valid scene")
    }

    fn found(scene: &Scene, from: Vec3, to: Vec3) -> Vec3 {
        passage(scene, &media::all(scene), Interior::at(scene, from), from, to)
    }

    /// Half a metre of fog and three of haze out of the box; two and six through it.
    #[test]
    fn light_goes_straight_through_a_box_of_fog_and_loses_what_each_medium_takes() {
        let scene = scene(1.0, "");
        let fog = Vec3::new(1.0, 2.0, 3.0);
        let cases = [
            (Vec3::new(0.0, 0.5, 0.0), Vec3::new(0.0, 4.0, 0.0), [0.5, 3.0]),
            (Vec3::new(0.0, -4.0, 0.0), Vec3::new(0.0, 4.0, 0.0), [2.0, 6.0]),
            (Vec3::new(0.0, -0.5, 0.0), Vec3::new(0.0, 0.5, 0.0), [1.0, 0.0]),
            (Vec3::new(0.0, 2.0, 0.0), Vec3::new(0.0, 4.0, 0.0), [0.0, 2.0]),
        ];
        for (from, to, [in_fog, in_haze]) in cases {
            let expected = (-fog * in_fog - Vec3::splat(0.1) * in_haze).exp();
            for (from, to) in [(from, to), (to, from)] {
                let found = found(&scene, from, to);
                assert!((found / expected - 1.0).abs().max_element() < 1e-5, "{found} for {expected}");
            }
        }
    }

    #[test]
    fn glass_and_what_stands_in_the_box_cast_shadows() {
        let (from, to) = (Vec3::new(0.0, -4.0, 0.0), Vec3::new(0.0, 4.0, 0.0));
        assert_eq!(found(&scene(1.5, ""), from, to), Vec3::ZERO);
        let ball = "[[object]]\nshape = \"sphere\"\ncenter = [0, 0, 0]\nradius = 0.5\nmaterial = ";
        for material in ["\"black\"\n", "{ dielectric = { index = 1.5 } }\n"] {
            assert_eq!(found(&scene(1.0, &format!("{ball}{material}")), from, to), Vec3::ZERO);
        }
    }
}
