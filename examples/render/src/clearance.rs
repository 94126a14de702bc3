//! How smooth diffuse light on a surface may be, by what is around the place.

use crate::light::cosine_direction;
use crate::optics::facing_normal;
use crate::random::Random;
use crate::scene::Scene;
use crate::surface::FLAT;
use glam::Vec3;
use std::f32::consts::TAU;

/// Rays that look for other surfaces.
const CONTACT_RAYS: u32 = 2;

/// Most places along the surface, each half as far as the one before, that are looked at to find its border.
const BORDER_STEPS: u32 = 3;

/// How far light that arrives diffusely may be spread around a place \[m\], at most `reach`: no farther than other surfaces are along random
/// rays, since it varies over no less than about that (G. Ward, F. Rubinstein and R. Clear 1988 bound the gradient of irradiance by the mean
/// distance); and not beyond the border of the surface, where there are no photons.
///
/// - `start`: beside the surface; `normal`: of the surface, on that side, unit; `reach` \[m\] > 0.
///
/// Cost: six short rays, and up to four more at borders.
pub(crate) fn clearance(scene: &Scene, start: Vec3, normal: Vec3, reach: f32, random: &mut Random) -> f32 {
    let mut clear = reach;
    for _ in 0..CONTACT_RAYS {
        let direction = cosine_direction(normal, [random.uniform(), random.uniform()]);
        if let Some(hit) = scene.intersect_solid(start, direction, clear) {
            clear = hit.distance;
        }
    }
    let (across, aside) = normal.any_orthonormal_pair();
    let (sin, cos) = (TAU * random.uniform()).sin_cos();
    let along = cos * across + sin * aside;
    for side in [along, -along] {
        // Evenly over the disk.
        let mut distance = clear * (1.0 - random.uniform()).sqrt();
        for _ in 0..BORDER_STEPS {
            if goes_on(scene, start, normal, distance * side) {
                break;
            }
            clear = distance;
            distance *= 0.5;
        }
    }
    clear
}

/// Whether the surface is also there a step further, with nothing in between.
fn goes_on(scene: &Scene, start: Vec3, normal: Vec3, step: Vec3) -> bool {
    let height = 0.5 * step.length();
    let over = step + height * normal;
    let length = over.length();
    if scene.intersect_solid(start, over / length, length).is_some() {
        return false;
    }
    let below = scene.intersect_solid(start + over, -normal, 2.0 * height);
    below.is_some_and(|hit| facing_normal(&hit, -normal).dot(normal) > FLAT)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    const REACH: f32 = 0.2;

    /// At a place on a floor of 2 x 2 m: a box hovers over a part of it.
    fn found(place: [f32; 2]) -> Vec<f32> {
        let text = "[camera]\nposition = [0, 3, 0]\nlook_at = [0, 0, 0.1]\nvertical_fov = 1\nwidth = 1\nheight = 1\n\
             [[object]]\nshape = \"rectangle\"\ncorner = [-1, 0, -1]\nedge_u = [0, 0, 2]\nedge_v = [2, 0, 0]\nmaterial = \"black\"\n\
             [[object]]\nshape = \"box\"\nmin = [-0.9, 0.01, -0.9]\nmax = [-0.3, 0.5, 0.9]\nmaterial = \"black\"\n\
             [[light]]\nkind = \"point\"\nposition = [0, 5, 0]\nintensity = 1\n";
        let scene = Scene::parse(text, "floor", Path::new("")).unwrap();
        let start = Vec3::new(place[0], 1e-6, place[1]);
        (0..4000)
            .map(|index| clearance(&scene, start, Vec3::Y, REACH, &mut Random::new([index, 0, 0, 0])))
            .collect()
    }

    #[test]
    fn nothing_is_in_the_way_on_an_open_floor() {
        assert!(found([0.3, 0.0]).iter().all(|clear| *clear == REACH));
    }

    #[test]
    fn in_a_gap_it_is_about_as_wide_as_the_gap() {
        // A cosine-weighted ray goes farther than d with probability (h/d)², both of two with its square: 4/3 h is the mean.
        let found = found([-0.6, 0.0]);
        let mean = found.iter().sum::<f32>() / found.len() as f32;
        assert!(mean < 1.34 * 0.01 && mean > 0.001, "{mean}");
    }

    #[test]
    fn the_border_of_a_surface_is_found_as_often_as_a_disk_reaches_beyond_it() {
        // One of two opposite points of a disk lies beyond a line at q of its radius: 1 - q²/cos²φ for an angle φ, over all angles.
        let q = 0.1_f32;
        let expected = 2.0 / std::f32::consts::PI * (q.acos() - q * (1.0 - q * q).sqrt());
        let found = found([1.0 - q * REACH, 0.0]);
        let share = found.iter().filter(|clear| **clear < REACH).count() as f32 / found.len() as f32;
        // Three standard errors of 4,000 draws.
        assert!((share - expected).abs() < 0.016, "{share} for {expected}");
    }
}
