//! What an eye ray meets first: fog, and the surface that ends it.

use crate::eye::starts::EyeStart;
use crate::scene::geometry::MOST_BOUNDS;
use crate::scene::optics::Interior;
use crate::scene::passage::clear;
use crate::scene::{MediumId, Rays, Scene};
use covbeam::EyeRay;
use covbeam_geometry::hit::Hit;

/// The first piece of fog on an eye ray's way to the first surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstFog {
    /// Distance from the ray's start to where it begins.
    pub from: f32,
    /// And to where it ends; infinite if nothing ends it.
    pub to: f32,
    /// Its medium.
    pub medium: MediumId,
    /// Whether it is all the fog before the first surface: no other piece lies behind it.
    pub is_alone: bool,
}

/// What an eye ray meets first. Surfaces that do nothing but bound media are none.
#[derive(Clone, Copy, Debug)]
pub struct Sight {
    /// The first piece of fog; None: there is none before the first surface.
    pub fog: Option<FirstFog>,
    /// Whether any of the fog before the first surface sends out light.
    pub glows: bool,
    /// Distance from the ray's start to the first surface; infinite: there is none.
    pub end: f32,
    /// That surface, and what the ray is inside of before it.
    pub surface: Option<(Hit, Interior)>,
}

impl Sight {
    /// Follows a ray. Behind 64 bounds of media it counts what comes next as a surface.
    pub fn new(scene: &Scene, start: &EyeStart) -> Self {
        let EyeStart { mut origin, direction, mut interior, sees, .. } = *start;
        if !sees {
            return Self { fog: None, glows: false, end: f32::INFINITY, surface: None };
        }
        let mut fog: Option<FirstFog> = None;
        let mut glows = false;
        let (mut passed, mut bounds) = (0.0, 0);
        loop {
            let hit = scene.intersect(origin, direction, f32::INFINITY);
            let end = passed + hit.as_ref().map_or(f32::INFINITY, |hit| hit.distance);
            if let Some(medium) =
                interior.medium(scene).filter(|&medium| !scene.is_hidden(medium, Rays::CAMERA))
            {
                let length = end - passed;
                let glow = scene.medium_of(medium).glow.as_ref();
                glows |= glow.is_some_and(|glow| glow.is_met(&EyeRay { origin, direction, length }));
                match &mut fog {
                    Some(first) => first.is_alone = false,
                    None => fog = Some(FirstFog { from: passed, to: end, medium, is_alone: true }),
                }
            }
            let Some(hit) = hit else { return Self { fog, glows, end, surface: None } };
            let beyond =
                clear(scene, &hit, direction, &interior, Rays::CAMERA).filter(|_| bounds < MOST_BOUNDS);
            let Some(beyond) = beyond else {
                return Self { fog, glows, end, surface: Some((hit, interior)) };
            };
            (origin, interior) = (hit.leave(direction), beyond);
            passed = (origin - start.origin).dot(direction);
            bounds += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::eye::starts::EyeStarts;
    use crate::scene::made::{BOUND, Made, camera, cuboid, point};

    /// Boxes around the z axis that hold fog and bend nothing, along which the camera at `z` looks; with fog around them if asked for.
    fn scene(z: f32, near: f32, in_fog: bool, boxes: &[[f32; 2]]) -> Scene {
        let camera = Camera { near, ..camera([0.0, 0.0, z], [0.0, 0.0, 99.0], 10.0, [3, 3]) };
        let mut made = Made::new(camera).fog(1.0, 0.0).light(point([0.0, 4.0, 0.0], 1.0));
        if in_fog {
            made = made.in_fog();
        }
        for &[low, high] in boxes {
            made = made.filled(cuboid([-1.0, -1.0, low], [1.0, 1.0, high]), BOUND, 0);
        }
        made.scene()
    }

    fn seen(scene: &Scene) -> Sight {
        Sight::new(scene, &EyeStarts::new(scene).middle(1, 1))
    }

    #[test]
    fn the_near_plane_cuts_fog_that_the_camera_is_in_or_before() {
        for z in [-3.0, -1.001, 0.5] {
            for near in [0.0_f32, 0.25, 1.999, 2.5, 3.9] {
                let (low, high) = (near.max(-1.0 - z), 1.0 - z);
                let found = seen(&scene(z, near, false, &[[-1.0, 1.0]])).fog;
                if low >= high {
                    assert_eq!(found, None);
                    continue;
                }
                let fog = found.expect("fog before the first surface");
                // Places are moved off surfaces, a few roundings of them.
                assert!(
                    (near + fog.from - low).abs() < 1e-5 && (near + fog.to - high).abs() < 1e-5,
                    "{fog:?}"
                );
                assert!(fog.is_alone);
            }
        }
    }

    #[test]
    fn bounds_of_fog_are_no_surfaces_and_a_second_piece_is_told() {
        let two = [[1.0, 2.0], [5.0, 7.0]];
        let found = seen(&scene(0.0, 0.0, false, &two));
        let fog = found.fog.expect("fog");
        assert!((fog.from - 1.0).abs() < 1e-5 && (fog.to - 2.0).abs() < 1e-5 && !fog.is_alone);
        assert!(found.end == f32::INFINITY && found.surface.is_none());
        // From fog into fog, too.
        let fog = seen(&scene(0.0, 0.0, true, &two)).fog.expect("fog");
        assert!(fog.from == 0.0 && (fog.to - 1.0).abs() < 1e-5 && !fog.is_alone);
        // A wall in the box hides the second.
        let mut scene = scene(0.0, 0.0, false, &two);
        scene.objects[1].material = crate::scene::Material::Black;
        scene.objects[1].inside = None;
        let found = seen(&scene);
        assert!(found.fog.is_some_and(|fog| fog.is_alone) && (found.end - 5.0).abs() < 1e-5);
        assert_eq!(found.surface.map(|(hit, _)| hit.object), Some(1));
    }
}
