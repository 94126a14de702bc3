use super::scene;
use covbeam_render::scene_file;
use covbeam_session::camera::Projection;
use covbeam_session::scene::{Light, Material, Scene, Shape};
use std::path::Path;

/// The hundred scenes of seed 1, which `measure fleet --grid` takes, have every feature that people's have.
#[test]
fn snapped_scenes_have_every_feature() {
    let scenes: Vec<Scene> = (1..=100).map(|number| parse(&scene([1, number, 0], 16, false))).collect();
    let has = |what: &str, test: &dyn Fn(&Scene) -> bool| {
        assert!(scenes.iter().any(&test), "no scene with {what}");
    };
    has("300 lamps, or nearly", &|scene| scene.lights.len() > 100);
    has("one lamp", &|scene| scene.lights.len() == 1);
    has("parallel rays", &|scene| scene.camera.projection == Projection::Orthographic);
    has("a view along an axis", &|scene| scene.camera.forward.abs().max_element() == 1.0);
    has("a sun along the view", &|scene| {
        let along = |light: &Light| matches!(light, Light::Sun(sun) if sun.direction.dot(scene.camera.forward).abs() > 0.999_999);
        scene.lights.iter().any(along)
    });
    has("a lamp in a ceiling", &|scene| {
        let room = scene.objects.iter().find(|object| object.name == "room");
        let ceiling = room.map(|room| room.shape.bounds().1.y);
        let in_it = |light: &Light| match light {
            Light::Point { position, .. } | Light::Spot { position, .. } => Some(position.y) == ceiling,
            Light::Rectangle { corner, .. } => Some(corner.y) == ceiling,
            _ => false,
        };
        scene.lights.iter().any(in_it)
    });
    has("a lamp on a face of fog", &|scene| {
        let on = |light: &Light| {
            scene
                .objects
                .iter()
                .any(|object| object.name == "fog" && object.shape.bounds().1.y == light.position().y)
        };
        scene.lights.iter().any(on)
    });
    has("a camera on a face of fog", &|scene| {
        scene
            .objects
            .iter()
            .any(|object| object.name == "fog" && object.shape.bounds().0.z == scene.camera.position.z)
    });
    has("fog as large as its room", &|scene| {
        let of = |name: &str| {
            scene.objects.iter().find(|object| object.name == name).map(|object| object.shape.bounds())
        };
        // The floor may lie on the room's.
        let (Some(room), Some(fog)) = (of("room"), of("fog")) else { return false };
        fog.1 == room.1 && fog.0.with_y(0.0) == room.0.with_y(0.0)
    });
    has("two boxes of fog", &|scene| scene.objects.iter().any(|object| object.name == "haze"));
    has("a drink", &|scene| scene.objects.iter().any(|object| object.name == "drink"));
    has("glass that reaches into glass", &|scene| scene.objects.iter().any(|object| object.priority == 1));
    has("a mirror", &|scene| {
        scene.objects.iter().any(|object| matches!(object.material, Material::Mirror { .. }))
    });
    has("a ball", &|scene| scene.objects.iter().any(|object| matches!(object.shape, Shape::Sphere { .. })));
    has("fog without end", &|scene| scene.outside.is_some());
    has("channels 30:1 apart", &|scene| {
        scene.media.iter().any(|medium| {
            let scattering = medium.medium.scattering;
            scattering.max_element() > 30.0 * scattering.min_element()
        })
    });
}

/// A scene of the same number is the same scene, and one a hair apart has the same things, all moved by less
/// than a thousandth.
#[test]
fn scenes_a_hair_apart_have_the_same_things() {
    for number in 1..=100 {
        let text = scene([1, number, 0], 16, false);
        assert_eq!(text, scene([1, number, 0], 16, false));
        let moved = scene([1, number, 0], 16, true);
        assert_ne!(text, moved);
        let (here, apart) = (parse(&text), parse(&moved));
        assert_eq!(here.objects.len(), apart.objects.len());
        assert_eq!(here.lights.len(), apart.lights.len());
        let size = (here.grid.max - here.grid.min).max_element();
        let moved = here.objects.iter().zip(&apart.objects).map(|(a, b)| {
            let ((low, high), (min, max)) = (a.shape.bounds(), b.shape.bounds());
            (low - min).abs().max((high - max).abs()).max_element()
        });
        // The grid covers a twelfth of a scene, or more.
        assert!(moved.fold(0.0, f32::max) < 2e-3 * size, "scene {number}");
    }
}

fn parse(text: &str) -> Scene {
    scene_file::parse(text, "snapped", Path::new(".")).expect("a valid scene")
}
