//! What rays do not see, what lamps do not light, and what casts no shadow of them: pictures of scenes that are described otherwise.

use crate::own::{assert_alike, quarters};
use crate::scenes::{BLACK, FOG, GLASS, LAMP, light, view, volume};
use crate::shapes::{add, built, icosphere, rows};
use covbeam_session::describe::geometry::Geometry;
use covbeam_session::describe::{Description, LightFields, MaterialFields, ObjectFields};
use covbeam_session::scene::{Rays, Scene, Sees};
use covbeam_session::work::failure::Failure;
use glam::{DMat4, DVec3};
use std::sync::Arc;

const OBJECT: ObjectFields =
    ObjectFields { volume: -1, is_closed: false, hidden_from: 0, light_set: 0, shadow_set: 0 };

/// Above a grey floor in fog a ball right below a lamp, if it is there.
fn described<T>(has_ball: bool, of: impl FnOnce(Description, Geometry) -> T) -> T {
    let geometry = Geometry::default();
    let ball = icosphere(3);
    let mesh = add(&geometry, &ball, 0, Some(&ball.radial_normals()));
    let place = |y: f64, scale: DVec3, number: i32| {
        let matrix = DMat4::from_translation(DVec3::new(0.0, y, 0.0)) * DMat4::from_scale(scale);
        geometry.add_instance(mesh, &rows(matrix), number, number).expect("valid");
    };
    place(-1.5, DVec3::new(3.0, 0.2, 3.0), 0);
    if has_ball {
        place(0.3, DVec3::splat(0.5), 1);
    }
    let grey = MaterialFields { diffuse: [0.5; 3], ..BLACK };
    let lamp = LightFields { position: [0.0, 2.0, 0.0], ..LAMP };
    let description = Description {
        materials: vec![grey, BLACK],
        objects: vec![OBJECT; 2],
        shapes: Vec::new(),
        volumes: vec![volume(FOG)],
        world_volume: 0,
        lights: vec![light(lamp)],
        camera: view(16),
        sees: Sees::FogAlone,
    };
    of(description, geometry)
}

fn scene(has_ball: bool, change: impl FnOnce(&mut Description)) -> Arc<Scene> {
    described(has_ball, |mut description, geometry| {
        change(&mut description);
        Arc::new(description.scene(built(&geometry)).expect("valid"))
    })
}

fn without_ball() -> [[f64; 2]; 4] {
    quarters(&scene(false, |_| {}))
}

#[test]
fn what_no_ray_sees_is_not_there() {
    let hidden = scene(true, |given| given.objects[1].hidden_from = Rays::ALL.bits());
    assert_alike("hidden", &hidden, without_ball());
}

/// A black ball that only casts no shadow is in the way of other light and of the camera; one whose lamp passes it, too.
#[test]
fn lamps_pass_what_they_cast_no_shadow_of() {
    let seen = (Rays::ALL.bits() & !Rays::SHADOW.bits(), Rays::SHADOW.bits());
    let hidden = quarters(&scene(true, |given| given.objects[1].hidden_from = seen.1));
    let passed = scene(true, |given| {
        given.objects[1].shadow_set = 5;
        given.lights[0].fields.unshadowed = 1 << 5;
    });
    assert_alike("passed", &passed, hidden);
    // For straight light it is not there then, and nothing else is to be seen of it by the other rays.
    let rest = scene(true, |given| {
        given.objects[1].hidden_from = seen.0;
        given.objects[1].shadow_set = 5;
        given.lights[0].fields.unshadowed = 1 << 5;
    });
    assert_alike("passed and hidden", &rest, without_ball());
}

/// Glass whose shadow is clear makes no caustic: for lamps it is not there, and white as it is other light goes through it as before.
#[test]
fn glass_without_a_shadow_lets_straight_light_by() {
    let fake = |index: f32| {
        scene(true, |given| {
            given.materials[1] = MaterialFields { shadow: Some([1.0; 3]), ior: index, ..GLASS };
            given.objects[1].hidden_from = Rays::CAMERA.bits();
        })
    };
    // Glass of 1.001 bends next to nothing: what is left of it is what is fake.
    assert_alike("clear glass", &fake(1.001), without_ball());
    let tinted = scene(true, |given| {
        given.materials[1] = MaterialFields { shadow: Some([0.25; 3]), transparent: [0.25; 3], ..BLACK };
        given.objects[1].hidden_from = Rays::CAMERA.bits();
    });
    let through = scene(true, |given| {
        given.materials[1] = MaterialFields { transparent: [0.25; 3], ..BLACK };
        given.objects[1].hidden_from = Rays::CAMERA.bits();
    });
    assert_alike("what is transparent", &tinted, quarters(&through));
}

/// The camera in a ball that lets through half of what is behind it sees the mean of a scene without it, and of one where it is black.
#[test]
fn fog_behind_what_is_partly_transparent_is_seen_through_it() {
    let inside = |transparent: f32| {
        scene(true, |given| {
            given.camera.position = [0.0, 0.3, 0.0];
            given.materials[1] = MaterialFields { transparent: [transparent; 3], ..BLACK };
            given.objects[1].hidden_from = Rays::ALL.bits() & !Rays::CAMERA.bits();
        })
    };
    let [without, half, black] = [1.0, 0.5, 0.0].map(|transparent| {
        let quarters = quarters(&inside(transparent));
        [0, 1].map(|which| quarters.iter().map(|quarter| quarter[which]).sum::<f64>())
    });
    assert!(
        black[0] < 0.8 * without[0],
        "hardly any fog is behind the ball: {black:?} of {without:?} before it"
    );
    let (mean, error) =
        (f64::midpoint(without[0], black[0]), (half[1] + (without[1] + black[1]) / 4.0).sqrt());
    println!("{} for {mean} ± {error}", half[0]);
    assert!(error < 0.05 * mean && (half[0] - mean).abs() < 5.0 * error);
}

/// Fog that no light of lamps falls on is as dark as where these do not shine, and what the floor reflects lights it all the same.
#[test]
fn lamps_light_what_they_are_linked_to() {
    let only = |sets: u64, hidden_from: u32| {
        scene(true, |given| {
            given.volumes[0].fields.light_set = 1;
            given.objects[1].light_set = 2;
            (given.lights[0].fields.unlit, given.lights[0].fields.hidden_from) = (sets, hidden_from);
        })
    };
    let dark = |scene: Arc<Scene>| quarters(&scene).iter().map(|[light, _]| light).sum::<f64>();
    let all = dark(only(0, 0));
    let (floor, from_volumes) = (dark(only(1 << 1, 0)), dark(only(0, Rays::VOLUME.bits())));
    println!("{all}, of the floor {floor}, {from_volumes}");
    // Two ways to say it, and noise.
    assert!(floor < 0.3 * all && (floor / from_volumes - 1.0).abs() < 0.05);
    assert_eq!(dark(only(0b11, 0)), 0.0, "nothing is lit");
}

/// Fog that hardly scatters around a lamp whose light is as strong everywhere but for what is absorbed of it.
#[test]
fn light_that_does_not_fall_off_is_as_strong_everywhere() {
    const SCATTERING: f64 = 1e-3;
    const ABSORPTION: f64 = 0.1;
    let even = scene(false, |given| {
        let fields = &mut given.volumes[0].fields;
        (fields.scattering, fields.absorption) = ([SCATTERING; 3], [ABSORPTION; 3]);
        given.materials[0] = BLACK;
        given.lights[0].fields.falloff = 2.0;
    });
    let camera = &even.camera;
    let mut expected = 0.0;
    for (y, x) in (0..16).flat_map(|y| (0..16).map(move |x| (y, x))) {
        let (h, v) = (-0.4 + 0.05 * (f64::from(x) + 0.5), 0.4 - 0.05 * (f64::from(y) + 0.5));
        let along = camera.forward.as_dvec3() + h * camera.right.as_dvec3() + v * camera.up.as_dvec3();
        let direction = along.normalize();
        let way = direction.as_vec3().normalize();
        // Where there is no floor nothing of what is farther away is left.
        let length =
            even.intersect(camera.position, way, f32::INFINITY).map_or(100.0, |hit| f64::from(hit.distance));
        let step = length / 1000.0;
        expected += (0..1000)
            .map(|index| {
                let distance = (f64::from(index) + 0.5) * step;
                let place = camera.position.as_dvec3() + distance * direction;
                let lost = (SCATTERING + ABSORPTION) * (distance + place.distance(DVec3::new(0.0, 2.0, 0.0)));
                step * SCATTERING * LAMP.intensity[0] / (4.0 * std::f64::consts::PI) * (-lost).exp()
            })
            .sum::<f64>();
    }
    let found: f64 = quarters(&even).iter().map(|[light, _]| light).sum();
    println!("{found} of {}", 3.0 * expected);
    // A few thousandths are scattered again, and the rays of 256 pixels' middles are not those of all places in them.
    assert!((found / (3.0 * expected) - 1.0).abs() < 0.02);
}

#[test]
fn what_means_nothing_is_refused() {
    let refused = |change: &dyn Fn(&mut Description), part: &str| {
        described(true, |mut given, geometry| {
            change(&mut given);
            let Err(Failure::Invalid(message)) = given.scene(built(&geometry)) else {
                panic!("taken: {part}")
            };
            assert!(message.contains(part), "{message}");
        });
    };
    refused(&|given| given.objects[1].hidden_from = 64, "objects[1].hidden_from: 64");
    refused(&|given| given.objects[0].light_set = 64, "objects[0].light_set");
    refused(&|given| given.objects[0].shadow_set = u32::MAX, "objects[0].shadow_set");
    refused(&|given| given.volumes[0].fields.light_set = 64, "volumes[0].light_set");
    refused(&|given| given.lights[0].fields.hidden_from = 1 << 20, "lights[0].hidden_from");
    refused(&|given| given.materials[1].shadow = Some([f32::NAN; 3]), "materials[1].shadow");
    refused(&|given| given.materials[1].shadow = Some([1.5; 3]), "materials[1].shadow");
    for value in [f64::NAN, -1.0, 5.0] {
        refused(&|given| given.lights[0].fields.falloff = value, "lights[0].falloff");
    }
    refused(&|given| given.lights[0].fields.smooth = -1.0, "lights[0].smooth");
}
