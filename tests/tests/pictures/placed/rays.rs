//! What rays hit of placed objects, and what it is made of.

use super::scenes::{Part, ball, block, bound, camera, lamp, part, scene, volume};
use covbeam_session::scene::{Lobes, Material};
use covbeam_tests::random::Stream;
use glam::{DMat4, DVec3, Vec3};

/// Among shapes of a scene file, turned, stretched and mirrored.
#[test]
fn hits_are_the_nearest_of_all_that_is_there_and_bear_their_numbers() {
    let text = [
        camera([0.0, 0.0, -9.0], [0.0; 3], 40.0, 8),
        lamp([0.0, 5.0, 0.0], 1.0),
        "[[object]]\nshape = \"sphere\"\ncenter = [1.5, 0, 0]\nradius = 0.7\nmaterial = \"black\"\n".to_owned(),
        "[[object]]\nshape = \"box\"\nmin = [-2, -2, -2]\nmax = [-1, 2, 2]\nmaterial = { mirror = { reflectance = 1 } }\n"
            .to_owned(),
        "[[medium]]\nname = \"fog\"\nscattering = 0.1\nabsorption = 0\n".to_owned(),
    ];
    let grey = |value: f32| Material::Lambert { albedo: Vec3::splat(value) };
    let stretched = DMat4::from_translation(DVec3::new(0.0, 1.0, 0.3))
        * DMat4::from_rotation_z(0.4)
        * DMat4::from_scale(DVec3::new(-1.0, 0.5, 1.2));
    let parts = [
        Part { transform: stretched, ..part(block(0.6, Vec3::ZERO), grey(0.1)) },
        part(ball(0.5, Vec3::new(0.0, -1.0, 0.0), 32), grey(0.2)),
        bound(block(1.2, Vec3::ZERO), 0),
    ];
    let scene = scene(&text.concat(), &parts, vec![volume(0, Vec3::splat(-1.2), Vec3::splat(1.2))]);
    let mut random = Stream::new(5);
    let mut seen = [0; 5];
    for _ in 0..4000 {
        let from = 4.0 * random.direction();
        let to = Vec3::from_array([(); 3].map(|()| random.between(-1.5, 1.5) as f32));
        let direction = (to - from).normalize();
        let Some(hit) = scene.intersect(from, direction, f32::INFINITY) else { continue };
        seen[hit.object as usize] += 1;
        let expected = match hit.object {
            0 => Material::Black,
            1 => Material::Mirror { reflectance: Vec3::ONE },
            2 => grey(0.1),
            3 => grey(0.2),
            _ => Material::Clear,
        };
        assert_eq!(*scene.material(&hit), expected);
        // On the surface, from outside: all of them are closed, and turned outwards.
        assert!((hit.position - from - hit.distance * direction).length() < 1e-5);
        assert!(hit.geometric_normal.dot(direction) <= 0.0 && (hit.normal.length() - 1.0).abs() < 1e-5);
        if hit.object == 3 {
            assert!(((hit.position - Vec3::NEG_Y).length() - 0.5).abs() < 0.01);
            // Of a ball, within what its triangles are flat.
            assert!(
                (hit.curvature.along - 2.0).abs() < 0.1 && (hit.curvature.across - 2.0).abs() < 0.1,
                "{hit:?}"
            );
        }
        // Nothing lies before it, it lies before what is beyond, and behind it is not hit again.
        assert!(!scene.occluded(from, from + 0.999 * hit.distance * direction));
        assert!(scene.occluded(from, from + 1.001 * hit.distance * direction));
        assert!(scene.intersect(from, direction, 0.999 * hit.distance).is_none());
        let next = scene.intersect(hit.leave(direction), direction, f32::INFINITY);
        assert!(next.is_none_or(|next| next.distance > 1e-4 || next.object != hit.object));
    }
    assert!(seen.iter().all(|count| *count > 50), "{seen:?}");
    assert_eq!(scene.materials().count(), 5);
}

#[test]
fn materials_take_the_plainest_form_that_they_have() {
    let grey = Vec3::splat(0.4);
    let none = Lobes { multiscatter: true, index: 1.3, ..Lobes::NONE };
    let white_glass = Lobes { glass_reflection: Vec3::ONE, glass_transmission: Vec3::ONE, ..none };
    for (lobes, expected) in [
        (none, Material::Black),
        (Lobes { alpha: 0.5, ..none }, Material::Black),
        (Lobes { diffuse: grey, alpha: 0.2, ..none }, Material::Lambert { albedo: grey }),
        (Lobes { transparent: Vec3::ONE, ..none }, Material::Clear),
        (Lobes { metal: grey, edge: grey, ..none }, Material::Mirror { reflectance: grey }),
        (Lobes { metal: grey, edge: grey, alpha: 9e-4, ..none }, Material::Mirror { reflectance: grey }),
        (white_glass, Material::Dielectric { index: 1.3 }),
        (Lobes { index: 1.0, ..white_glass }, Material::Clear),
    ] {
        assert_eq!(Material::of_lobes(lobes), expected, "{lobes:?}");
    }
    for lobes in [
        Lobes { metal: grey, edge: Vec3::ONE, ..none },
        Lobes { metal: grey, edge: grey, alpha: 2e-3, ..none },
        Lobes { diffuse: grey, coat: grey, ..none },
        Lobes { transparent: Vec3::new(1.0, 1.0, 0.9), ..none },
        Lobes { glass_transmission: grey, ..white_glass },
        Lobes { alpha: 0.1, ..white_glass },
        Lobes { diffuse: grey, translucent: grey, ..none },
    ] {
        assert_eq!(Material::of_lobes(lobes), Material::Lobes(lobes));
    }
}
