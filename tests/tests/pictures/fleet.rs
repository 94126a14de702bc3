//! A small fleet of scenes that nobody tuned, and the scenes that once failed: the default method must agree with plain beams and with
//! light tracing in every block of pixels. `measure fleet` does the same with hundreds of scenes.

use covbeam::{PhaseKind, Vec3};
use covbeam_render::scene_file;
use covbeam_session::scene::{Light, Material, MediumDensity, Scene, Shape};
use covbeam_tests::fleet::agreement::{Agreement, Passes, examine, level};
use covbeam_tests::fleet::blocks::{compare, means};
use covbeam_tests::fleet::member;
use covbeam_tests::fleet::rings::{ratios, rings};
use covbeam_tests::fleet::runs::{Estimator, mean, pictures};
use std::path::Path;

/// A spot of 14° in a room of isotropic fog, with the lamp in the picture: once 1.5 times too bright beside the cone.
const SPOT: &str = include_str!("../../scenes/spot.toml");

fn spot(width: u32) -> Scene {
    let mut scene = scene_file::parse(SPOT, "spot", Path::new(".")).expect("a valid scene");
    (scene.camera.width, scene.camera.height) = (width, width);
    scene
}

/// Of which the halo below is seen in three times as many blocks as it must be.
const PASSES: Passes = Passes { default: 4, reference: 8, light: 2 };

#[test]
fn no_block_of_a_small_fleet_differs_from_plain_beams_or_light_tracing() {
    let folder = tempfile::tempdir().unwrap();
    let found = examine(&spot(48), PASSES).expect("finite");
    assert_a_halo_would_be_seen(&found);
    let mut suspects: Vec<_> =
        found.suspects.into_iter().map(|suspect| ("spot".to_owned(), suspect)).collect();
    for number in 1..=6 {
        let scene = member(1, number, 48, folder.path()).unwrap().scene;
        let found = examine(&scene, PASSES).expect("finite").suspects;
        suspects.extend(found.into_iter().map(|suspect| (format!("scene {number} of seed 1"), suspect)));
    }
    let level = level(suspects.len());
    let failing: Vec<_> = suspects.iter().filter(|(_, suspect)| suspect.fails(level)).collect();
    assert!(failing.is_empty(), "{} failing blocks: {failing:#?}", failing.len());
}

/// In the spot's pictures: the same light, spread over the picture as a filter that reaches across the cone spreads it.
fn assert_a_halo_would_be_seen(of: &Agreement) {
    let mut halo = of.tested.clone();
    for picture in &mut halo {
        // A fifth of each pixel goes evenly to the pixels up to ten to the left and right of it.
        let width = picture.width as usize;
        for row in picture.radiance.chunks_mut(width) {
            let spread: Vec<Vec3> = (0..width)
                .map(|x| {
                    let near = x.saturating_sub(10)..(x + 11).min(width);
                    let count = near.len() as f32;
                    row[near].iter().copied().sum::<Vec3>() / count
                })
                .collect();
            row.iter_mut().zip(spread).for_each(|(value, spread)| *value = 0.8 * *value + 0.2 * spread);
        }
    }
    let found = compare(&halo, &of.reference, &rings(&mean(&of.reference)));
    // The level of a hundred suspects.
    let seen = found.iter().filter(|verdict| verdict.p < level(100)).count();
    println!("{seen} of {} blocks", found.len());
    assert!(seen >= 4, "{seen} of {} blocks", found.len());
}

#[test]
fn the_spot_has_no_halo() {
    let scene = spot(72);
    let tested = pictures(&scene, Estimator::Default, 1..9, 8).expect("finite");
    let reference = pictures(&scene, Estimator::Reference, 101..109, 32).expect("finite");
    let found = ratios(&rings(&mean(&reference)), &tested, &reference);
    // A halo is within 15 pixels of a picture twice as wide; the darkest ring, the last, would take minutes to know to a per cent.
    for (ring, ratio) in found.into_iter().take(5).enumerate() {
        let ratio = ratio.expect("light in each ring");
        println!("ring {ring}: {:.4} ± {:.4}", ratio.value, ratio.error);
        assert!(ratio.error < 0.01, "ring {ring}: too noisy to tell, {ratio:?}");
        // Filters may bias by 1 %; the noise of two standard errors on top.
        assert!((ratio.value - 1.0).abs() < 0.03, "ring {ring}: {ratio:?}, all {found:?}");
    }
    let light = |of: &[_]| means(&mean(of)).iter().sum::<f64>();
    let total = light(&tested) / light(&reference);
    assert!((total - 1.0).abs() < 0.02, "total {total}");
}

/// Scenes of the fleet have every feature, and a scene of the same number is the same scene.
#[test]
fn the_fleet_has_every_feature_and_is_always_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let scenes: Vec<Scene> =
        (1..=40).map(|number| member(7, number, 16, folder.path()).unwrap().scene).collect();
    let text =
        |number: u32| std::fs::read_to_string(folder.path().join(format!("{number:03}.toml"))).unwrap();
    let first = text(1);
    member(7, 1, 16, folder.path()).unwrap();
    assert_eq!(text(1), first);
    assert_ne!(text(2), first);
    member(7, 1, 32, folder.path()).unwrap();
    assert_eq!(text(1).replace("= 32", "= 16"), first, "the width changes nothing else");

    let has = |what: &str, test: &dyn Fn(&Scene) -> bool| {
        let count = scenes.iter().filter(|scene| test(scene)).count();
        assert!(count > 0, "no scene with {what}");
    };
    let light = |test: fn(&Light) -> bool| move |scene: &Scene| scene.lights.iter().any(test);
    has("a point lamp", &light(|light| matches!(light, Light::Point { .. })));
    has("a spot", &light(|light| matches!(light, Light::Spot { .. })));
    has("a disk", &light(|light| matches!(light, Light::Disk { .. })));
    has("a sphere", &light(|light| matches!(light, Light::Sphere { .. })));
    has("a rectangle", &light(|light| matches!(light, Light::Rectangle { .. })));
    has("three lamps", &|scene| scene.lights.len() == 3);
    let object = |test: fn(&covbeam_session::scene::Object) -> bool| {
        move |scene: &Scene| scene.objects.iter().any(test)
    };
    has("glass", &object(|object| matches!(object.material, Material::Dielectric { .. })));
    has("a mirror", &object(|object| matches!(object.material, Material::Mirror { .. })));
    has(
        "a matt ball",
        &object(|object| {
            matches!((&object.shape, object.material), (Shape::Sphere { .. }, Material::Lambert { .. }))
        }),
    );
    has("a mesh", &object(|object| matches!(object.shape, Shape::Mesh(_))));
    has("a plate", &object(|object| object.name == "plate"));
    has("milk in glass", &object(|object| object.inside.is_some() && object.name != "fog box"));
    has("a camera outside the fog", &|scene| scene.outside.is_none());
    let density = |test: fn(&MediumDensity) -> bool| {
        move |scene: &Scene| scene.media.iter().any(|medium| test(&medium.density))
    };
    has("fog that thins with height", &density(|density| matches!(density, MediumDensity::Exponential(_))));
    has("smoke", &density(|density| matches!(density, MediumDensity::Grid(_))));
    for kind in [PhaseKind::Isotropic, PhaseKind::Rayleigh, PhaseKind::HenyeyGreenstein] {
        has("a phase function", &|scene| scene.media[0].medium.phase.kind == kind);
    }
    has("coloured fog", &|scene| scene.media[0].medium.scattering.x != scene.media[0].medium.scattering.y);
    let depth = |scene: &Scene| (scene.grid.max - scene.grid.min).z;
    let (least, most) = scenes
        .iter()
        .fold((f32::MAX, 0.0_f32), |(least, most), scene| (least.min(depth(scene)), most.max(depth(scene))));
    assert!(least < 0.1 && most > 100.0, "rooms of {least} to {most}");
}
