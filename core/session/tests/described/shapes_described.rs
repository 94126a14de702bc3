//! Shapes in descriptions: the same pictures as of a scene that is made by hand, light through fog in closed form, and what is refused.

use crate::scenes::{
    BLACK, FOG, GLASS, LAMP, assert_same, light, options, picture, session, sphere, view, volume,
    without_meshes,
};
use crate::shapes::{add, built, icosphere};
use covbeam::{Medium, PhaseFunction};
use covbeam_geometry::mesh::{Mesh, Placement};
use covbeam_geometry::obj::ObjTriangles;
use covbeam_session::camera::{Camera, Projection};
use covbeam_session::describe::LightKind;
use covbeam_session::describe::geometry::Geometry;
use covbeam_session::describe::{
    Description, LightFields, MaterialFields, ObjectFields, ShapeFields, Volume, VolumeFields,
};
use covbeam_session::film::{Film, Picture};
use covbeam_session::kind::Split;
use covbeam_session::pass::Renderer;
use covbeam_session::pilot::defaults::{Given, NO_GRID};
use covbeam_session::scene::{
    Area, Cone, Heed, Lamp, Light as SceneLight, Material, MediumDensity, Object, Scene, SceneMedium, Sees,
    Shape, Shown, nest,
};
use covbeam_session::session::Options;
use covbeam_session::settings::{Gather, Layers, Method, Settings};
use covbeam_session::work::failure::Failure;
use glam::{DVec3, Vec3};
use std::sync::Arc;

/// Glass of the index of what is around it: a mere bound.
const BOUND: MaterialFields = MaterialFields { ior: 1.0, ..GLASS };

const WHITE: MaterialFields = MaterialFields { diffuse: [0.8; 3], ..BLACK };

/// Shines down into a cone of 60°, and all points see a disk of it; it has no surface that is seen.
const SPOT: LightFields = LightFields {
    position: [0.5, 2.0, 0.5],
    axis: [0.0, -1.0, 0.0],
    radius: 0.25,
    cosine: 0.5,
    blend: 0.25,
    kind: LightKind::Spot,
    soft: 1,
    ..LAMP
};

/// Two metres wide, before the camera and facing it.
const SQUARE: LightFields = LightFields {
    position: [0.0, 0.0, 3.0],
    u: [0.0, 2.0, 0.0],
    v: [2.0, 0.0, 0.0],
    radiance: [8.0, 4.0, 2.0],
    spread: std::f64::consts::PI,
    kind: LightKind::Area,
    is_visible: true,
    ..LAMP
};

fn cuboid(min: [f32; 3], max: [f32; 3]) -> ShapeFields {
    ShapeFields { shape: Shape::Box { min: min.into(), max: max.into() }, ..sphere(Vec3::ZERO, 1.0) }
}

/// In the world's fog a ball of glass that sticks into a box of denser fog, on a white floor.
fn described(lamp: LightFields) -> Scene {
    let floor = Shape::Rectangle {
        corner: Vec3::new(-2.0, -1.0, -2.0),
        edge_u: 4.0 * Vec3::Z,
        edge_v: 4.0 * Vec3::X,
    };
    let shapes = [
        sphere(Vec3::new(-0.3, 0.0, 0.0), 0.6),
        ShapeFields { material: 1, volume: 1, priority: -1, ..cuboid([0.0, -1.0, -0.5], [1.0, 0.75, 0.5]) },
        ShapeFields { shape: floor, material: 2, volume: -1, priority: 0 },
    ];
    let dense = VolumeFields { scattering: [1.0, 0.75, 0.5], absorption: [0.125; 3], ..FOG };
    let description = Description {
        materials: vec![GLASS, BOUND, WHITE],
        objects: Vec::new(),
        shapes: shapes.into(),
        volumes: vec![volume(FOG), volume(dense)],
        world_volume: 0,
        lights: vec![light(lamp)],
        camera: view(16),
        sees: Sees::Everything,
    };
    description.scene(built(&Geometry::default())).expect("valid")
}

/// The same without any description.
fn by_hand(lamp: LightFields) -> Scene {
    let object = |shape, material, inside, priority| Object {
        name: String::new(),
        shape,
        material,
        inside,
        priority,
        inner: Vec::new(),
    };
    let (center, corner) = (Vec3::new(-0.3, 0.0, 0.0), Vec3::new(-2.0, -1.0, -2.0));
    let (min, max) = (Vec3::new(0.0, -1.0, -0.5), Vec3::new(1.0, 0.75, 0.5));
    let floor = Shape::Rectangle { corner, edge_u: 4.0 * Vec3::Z, edge_v: 4.0 * Vec3::X };
    let mut objects = vec![
        object(Shape::Sphere { center, radius: 0.6 }, Material::Dielectric { index: 1.5 }, None, 0),
        object(Shape::Box { min, max }, Material::Dielectric { index: 1.0 }, Some(1), -1),
        object(floor, Material::Lambert { albedo: Vec3::splat(0.8) }, None, 0),
    ];
    nest(&mut objects);
    let medium = |scattering: [f32; 3], absorption: f32| SceneMedium {
        medium: Medium {
            scattering: scattering.into(),
            absorption: Vec3::splat(absorption),
            phase: PhaseFunction::ISOTROPIC,
            ..Medium::homogeneous(0.0, 0.0)
        },
        more: Vec::new(),
        density: MediumDensity::Uniform,
        glow: None,
        heed: Heed::default(),
    };
    let lights = vec![light_by_hand(lamp)];
    Scene {
        objects,
        placed: None,
        shown: Shown::new(&lights, |_| lamp.is_visible),
        lights,
        links: Vec::new(),
        media: vec![medium([0.15; 3], 0.1), medium([1.0, 0.75, 0.5], 0.125)],
        outside: Some(0),
        camera: Camera {
            position: Vec3::new(0.0, 0.0, -4.0),
            forward: Vec3::Z,
            right: Vec3::X,
            up: Vec3::Y,
            projection: Projection::Perspective,
            frame: view(16).frame,
            width: 16,
            height: 16,
            near: 0.0,
            lens: None,
            is_own: false,
        },
        grid: NO_GRID,
        settings: Given::default().settings,
        sees: Sees::Everything,
        notes: Vec::new(),
    }
}

fn light_by_hand(lamp: LightFields) -> SceneLight {
    if lamp.kind == LightKind::Area {
        return SceneLight::Area(Area {
            center: Vec3::new(0.0, 0.0, 3.0),
            edge_u: 2.0 * Vec3::Y,
            edge_v: 2.0 * Vec3::X,
            round: false,
            spread: std::f32::consts::FRAC_PI_2,
            radiance: Vec3::new(8.0, 4.0, 2.0),
        });
    }
    SceneLight::Lamp(Lamp {
        position: Vec3::from(lamp.position.map(|x| x as f32)),
        intensity: Vec3::splat(25.0),
        radius: lamp.radius as f32,
        soft: lamp.soft == 1,
        cone: (lamp.kind == LightKind::Spot).then_some(Cone { axis: Vec3::NEG_Y, cosine: 0.5, blend: 0.25 }),
        pattern: None,
        // Nothing glows inside of points and of soft lamps.
        glow: 1.0,
    })
}

/// What a host does that has no session.
fn rendered(mut scene: Scene, settings: Settings, passes: u32) -> Picture {
    scene.complete(&Given::default());
    let (mut film, mut renderer) = (Film::of_scene(&scene), Renderer::new(&scene, settings));
    if settings.layers == Layers::EachKind && settings.gather != Gather::LightTrace {
        film.keep_kinds(Split::of_each_kind(&scene));
    }
    for pass in 1..=passes {
        let (image, _) = renderer.pass(pass, &|| false).expect("never cancelled");
        film.add(&image).expect("a picture");
    }
    film.picture()
}

#[test]
fn a_session_of_described_shapes_gives_the_bits_of_a_renderer_of_a_scene_made_by_hand() {
    let of = |lamp, guided| {
        let settings = Settings { guided, ..options(500).settings };
        let found = picture(&session(&Arc::new(described(lamp)), Options { settings, ..options(500) }), 3);
        assert_same(&found, &rendered(by_hand(lamp), settings, 3));
        found
    };
    // Without the pilot but for two: it takes most of the time.
    let point = of(LAMP, true);
    assert!(of(LAMP, false) != point);
    of(LightFields { radius: 0.25, soft: 1, ..LAMP }, false);
    let spot = of(SPOT, true);
    let [hidden, visible] = [false, true].map(|is_visible| of(LightFields { is_visible, ..SPOT }, false));
    assert!(visible != spot);
    assert_same(&visible, &hidden);
    let [hidden, visible] = [false, true].map(|is_visible| of(LightFields { is_visible, ..SQUARE }, false));
    let brighter = visible.radiance.iter().zip(&hidden.radiance).filter(|(seen, not)| seen.x > not.x + 0.1);
    assert!(brighter.count() > 20, "a lamp that is seen is no brighter than one that is not");
}

#[test]
fn sessions_render_with_every_method_and_keep_the_kinds_of_light_apart_where_it_tells_them() {
    let scene = Arc::new(described(SPOT));
    for method in [Method::Plain, Method::Thesis, Method::LightTrace, Method::March] {
        for layers in [Layers::Alike, Layers::EachKind] {
            let settings = Settings { layers, ..Settings::of(method, 300, 2) };
            let found = picture(&session(&scene, Options { settings, ..options(0) }), 2);
            assert_same(&found, &rendered(by_hand(SPOT), settings, 2));
            assert!(found.radiance.iter().any(|color| *color != Vec3::ZERO));
            let tells = layers == Layers::EachKind && method != Method::LightTrace;
            assert_eq!(found.kinds.len(), if tells { 3 } else { 0 });
        }
    }
}

/// Radiance of the middle of a picture whose camera looks 7 m through air or fog into a square lamp, with boxes between them.
fn through(shapes: &[ShapeFields], world: i32) -> Vec3 {
    let absorbing = |absorption: f64| {
        let (scattering, absorption) = ([0.0; 3], [absorption; 3]);
        volume(VolumeFields { scattering, absorption, min: [-1.0; 3], max: [1.0; 3], ..FOG })
    };
    let scene = without_meshes(&Description {
        materials: vec![BLACK, BOUND],
        objects: Vec::new(),
        shapes: shapes.to_vec(),
        volumes: vec![absorbing(0.25), absorbing(0.75)],
        world_volume: world,
        lights: vec![light(SQUARE)],
        camera: view(16),
        sees: Sees::Everything,
    });
    let settings = Settings { guided: false, ..options(200).settings };
    let found = picture(&session(&scene, Options { settings, ..options(200) }), 2);
    found.radiance[8 * 16 + 8]
}

#[test]
fn a_box_of_index_one_holds_its_own_fog_or_none() {
    // The picture's middle pixel looks by 2° past the axis, which is a thousandth more of a way.
    let close = |found: Vec3, depth: f64| {
        let expected = DVec3::from(SQUARE.radiance) * (-depth).exp();
        let wrong = (found.as_dvec3() / expected - 1.0).abs().max_element();
        assert!(wrong < 3e-3, "{found} is not {expected}");
    };
    let boxed = |volume| [ShapeFields { material: 1, volume, ..cuboid([-1.0, -1.0, -1.5], [1.0, 1.0, 0.5]) }];
    close(through(&[], -1), 0.0);
    close(through(&[], 0), 0.25 * 7.0);
    // Two metres of the seven are of other fog, or of none.
    close(through(&boxed(1), 0), 0.25 * 5.0 + 0.75 * 2.0);
    close(through(&boxed(-1), 0), 0.25 * 5.0);
    close(through(&boxed(1), -1), 0.75 * 2.0);
    close(through(&boxed(-1), -1), 0.0);
    // Of higher priority is the one that counts, wherever it was given.
    let large = ShapeFields { material: 1, volume: 1, ..cuboid([-2.0, -2.0, -3.0], [2.0, 2.0, 0.75]) };
    // Dense fog of 3.75 m and 3.25 m of thin fog; or 2 m of it are clear.
    for (priority, depth) in [(-1, 0.75 * 3.75 + 0.25 * 3.25), (1, 0.75 * 1.75 + 0.25 * 3.25)] {
        let small = ShapeFields { priority, ..boxed(-1)[0].clone() };
        close(through(&[small.clone(), large.clone()], 0), depth);
        close(through(&[large.clone(), small], 0), depth);
    }
}

/// What is refused of a description with a second shape like this; its volumes are 0 of the world, 1 even, 2 of voxels, 3 and 4 of objects, and 5
/// their sum; its materials 0 black, 1 glass, 2 a bound.
fn refusal(wrong: ShapeFields, object: i32) -> String {
    let bounded = VolumeFields { min: [-1.0; 3], max: [1.0; 3], ..FOG };
    let voxels = VolumeFields { cells: [1; 3], density_min: [-1.0; 3], density_max: [1.0; 3], ..bounded };
    let description = Description {
        materials: vec![BLACK, GLASS, BOUND],
        objects: vec![ObjectFields { volume: object, is_closed: true, ..ObjectFields::default() }],
        shapes: vec![ShapeFields { material: 1, ..sphere(Vec3::ZERO, 0.5) }, wrong],
        volumes: vec![
            volume(FOG),
            volume(bounded),
            Volume { densities: Some(&[1.0]), ..volume(voxels) },
            volume(bounded),
            volume(bounded),
            Volume { parts: &[3, 4], ..volume(FOG) },
        ],
        world_volume: 0,
        lights: vec![light(LAMP)],
        camera: view(16),
        sees: Sees::Everything,
    };
    match description.scene(built(&Geometry::default())) {
        Ok(_) => String::new(),
        Err(Failure::Invalid(message)) => message,
        Err(other) => panic!("{other:?}"),
    }
}

/// Panics unless a shape is refused with the name of this field and a remedy.
#[track_caller]
fn assert_names(field: &str, wrong: ShapeFields) {
    let message = refusal(wrong, 3);
    assert!(message.starts_with(&format!("shapes[1].{field}: ")) && message.contains("; give "), "{message}");
}

#[test]
fn shapes_that_are_none_are_refused_by_the_name_of_their_field() {
    let infinite = f32::INFINITY;
    for wrong in [f32::NAN, infinite, -infinite, 2e9] {
        let at = Vec3::new(0.0, wrong, 0.0);
        assert_names("center", sphere(at, 1.0));
        assert_names("min", cuboid(at.to_array(), [3e9; 3]));
        assert_names("max", cuboid([0.0; 3], at.to_array()));
        let rectangle = |corner, edge_u, edge_v| ShapeFields {
            shape: Shape::Rectangle { corner, edge_u, edge_v },
            ..sphere(Vec3::ZERO, 1.0)
        };
        assert_names("corner", rectangle(at, Vec3::X, Vec3::Y));
        assert_names("edge_u", rectangle(Vec3::ZERO, at, Vec3::X));
        assert_names("edge_v", rectangle(Vec3::ZERO, Vec3::X, at));
        // Without an area.
        assert_names("edge_v", rectangle(Vec3::ZERO, Vec3::X, Vec3::ZERO));
        assert_names("edge_v", rectangle(Vec3::ZERO, Vec3::ONE, 3.0 * Vec3::ONE));
    }
    for radius in [f32::NAN, infinite, -1.0, 0.0, -0.0, 1e-10, 2e9] {
        assert_names("radius", sphere(Vec3::ZERO, radius));
    }
    for max in [[1.0, 0.0, 1.0], [1.0, 1.0, -1.0], [0.0; 3]] {
        assert_names("max", cuboid([0.0; 3], max));
    }
    let ball = icosphere(0);
    let indices = ball.triangles.iter().map(|triangle| triangle.map(|corner| corner as u32)).collect();
    let source = ObjTriangles { positions: ball.positions, normals: Vec::new(), indices };
    let mesh = Mesh::new(source, &Placement::default(), false).expect("valid");
    assert_names("shape", ShapeFields { shape: Shape::Mesh(mesh), ..sphere(Vec3::ZERO, 1.0) });
}

#[test]
fn what_shapes_are_made_of_is_refused_by_the_name_of_their_field() {
    let ball = |material, volume| ShapeFields { material, volume, ..sphere(Vec3::ZERO, 1.0) };
    for unknown in [3, u32::MAX] {
        assert_names("material", ball(unknown, -1));
    }
    // What has no inside cannot be of glass, whatever its index is.
    let (corner, edge_u, edge_v) = (Vec3::ZERO, Vec3::X, Vec3::Y);
    for material in [1, 2] {
        let shape = Shape::Rectangle { corner, edge_u, edge_v };
        assert_names("material", ShapeFields { shape, ..ball(material, -1) });
    }
    // Only glass has an inside.
    assert_names("volume", ball(0, 1));
    for material in [1, 2] {
        // Unknown, the world's, of voxels, a sum.
        for volume in [-2, i32::MIN, 6, i32::MAX, 0, 2, 5] {
            assert_names("volume", ball(material, volume));
        }
        for priority in [-1001, 1001, i32::MIN, i32::MAX] {
            assert_names("priority", ShapeFields { priority, ..ball(material, 1) });
        }
        for priority in [-1000, 1000] {
            assert_eq!(refusal(ShapeFields { priority, ..ball(material, 1) }, 3), "");
        }
    }
    // What fills a shape fills no object and is no part of a sum.
    let message = refusal(ball(1, 1), 1);
    assert!(message.starts_with("objects[0].volume: 1; give "), "{message}");
    let message = refusal(ball(1, 3), 4);
    assert!(message.starts_with("volumes[5].parts: [3, 4]; give "), "{message}");
}

#[test]
fn shapes_lie_among_meshes() {
    // A ball of glass as a mesh before a black wall that is a shape, and the other way round.
    let ball = icosphere(2);
    let geometry = Geometry::default();
    let mesh = add(&geometry, &ball, 0, Some(&ball.radial_normals()));
    let matrix = glam::DMat4::from_scale(glam::DVec3::splat(0.5));
    geometry.add_instance(mesh, &crate::shapes::rows(matrix), 0, -1).expect("valid");
    let instances = built(&geometry);
    let of = |z: f32| {
        let wall = ShapeFields { material: 1, ..cuboid([-9.0, -9.0, z], [9.0, 9.0, z + 1.0]) };
        let description = Description {
            materials: vec![WHITE, BLACK],
            objects: vec![ObjectFields { volume: -1, is_closed: true, ..ObjectFields::default() }],
            shapes: vec![wall],
            volumes: Vec::new(),
            world_volume: -1,
            lights: vec![light(LightFields { position: [0.0, 0.0, -4.0], ..LAMP })],
            camera: view(16),
            sees: Sees::Everything,
        };
        let scene = Arc::new(description.scene(Arc::clone(&instances)).expect("valid"));
        let settings = Settings { guided: false, layers: Layers::Together, ..options(200).settings };
        picture(&session(&scene, Options { settings, ..options(200) }), 2)
    };
    let lit = |picture: &Picture| picture.radiance.iter().filter(|color| **color != Vec3::ZERO).count();
    // The ball is 5 pixels wide: 0.5 / 4 over 0.05 on either side.
    let (before, behind) = (of(1.0), of(-2.0));
    assert!((12..=32).contains(&lit(&before)), "{} pixels show the ball", lit(&before));
    assert_eq!(lit(&behind), 0);
    // Where the middle pixel's ray meets the ball, which is lit from the camera: albedo / π · I cos θ / d².
    let direction = Vec3::new(0.025, 0.025, 1.0).normalize();
    let along = 4.0 * direction.z;
    let distance = along - (along * along - 16.0 + 0.25).sqrt();
    let normal = (distance * direction - 4.0 * Vec3::Z) / 0.5;
    let expected = 0.8 / std::f32::consts::PI * 25.0 * -normal.dot(direction) / (distance * distance);
    let middle = before.radiance[8 * 16 + 8];
    assert!((middle / expected - 1.0).abs().max_element() < 0.03, "{middle} is not {expected}");
}
