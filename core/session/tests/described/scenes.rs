//! Scenes in few words, and sessions of them.

use crate::shapes::{CAMERA, add, built, icosphere, rows};
use covbeam_session::camera::Frame;
use covbeam_session::describe::LightKind;
use covbeam_session::describe::geometry::Geometry;
use covbeam_session::describe::{
    CameraFields, Description, Light, LightFields, MaterialFields, ObjectFields, ShapeFields, Volume,
    VolumeFields,
};
use covbeam_session::film::Picture;
use covbeam_session::material::Asks;
use covbeam_session::scene::{Scene, Sees, Shape};
use covbeam_session::session::{Options, Session};
use covbeam_session::settings::{Method, Settings};
use glam::{DMat4, DVec3, Vec3};
use std::sync::Arc;
use std::time::Duration;

/// What a caller does not notice: asked for is a tenth of a second, of which the machine has a part.
pub(crate) const QUICK: Duration = Duration::from_millis(100);

/// A surface that absorbs everything.
pub(crate) const BLACK: MaterialFields = MaterialFields {
    diffuse: [0.0; 3],
    translucent: [0.0; 3],
    metal: [0.0; 3],
    edge: [0.0; 3],
    glass_reflection: [0.0; 3],
    glass_transmission: [0.0; 3],
    coat: [0.0; 3],
    transparent: [0.0; 3],
    shadow: None,
    ior: 1.5,
    roughness: 0.0,
    asks: Asks::Nothing,
};

pub(crate) const GLASS: MaterialFields =
    MaterialFields { glass_reflection: [1.0; 3], glass_transmission: [1.0; 3], ..BLACK };

/// Homogeneous; where it is nobody has said.
pub(crate) const FOG: VolumeFields = VolumeFields {
    scattering: [0.15; 3],
    absorption: [0.1; 3],
    min: [f64::NEG_INFINITY; 3],
    max: [f64::INFINITY; 3],
    asymmetry: 0.0,
    density_min: [0.0; 3],
    density_max: [0.0; 3],
    glow_min: [0.0; 3],
    glow_max: [0.0; 3],
    cells: [0; 3],
    glow_cells: [0; 3],
    phase: 0,
    scale_height: 0.0,
    origin: [0.0; 3],
    up: [0.0; 3],
    hidden_from: 0,
    light_set: 0,
    shadow_set: 0,
};

/// A point.
pub(crate) const LAMP: LightFields = LightFields {
    most_events: 0,
    position: [1.0, 2.4, 0.0],
    axis: [0.0; 3],
    u: [0.0; 3],
    v: [0.0; 3],
    intensity: [25.0; 3],
    radiance: [0.0; 3],
    irradiance: [0.0; 3],
    axes: [[0.0; 3]; 3],
    radius: 0.0,
    cosine: 0.0,
    blend: 0.0,
    spread: 0.0,
    angle: 0.0,
    reach: 0.0,
    kind: LightKind::Point,
    soft: 0,
    round: 0,
    rows: 0,
    columns: 0,
    is_visible: false,
    is_own: false,
    unlit: 0,
    unshadowed: 0,
    hidden_from: 0,
    falloff: 0.0,
    smooth: 0.0,
};

pub(crate) fn volume(fields: VolumeFields) -> Volume<'static> {
    Volume { fields, densities: None, glow: None, parts: &[], lobes: Vec::new() }
}

pub(crate) fn light(fields: LightFields) -> Light<'static> {
    Light { fields, triangles: &[], cells: None }
}

/// What is of shapes alone.
pub(crate) fn without_meshes(description: &Description) -> Arc<Scene> {
    Arc::new(description.scene(built(&Geometry::default())).expect("a valid description"))
}

/// A mesh of a ball of glass in endless fog, and a lamp: what fog scatters of its light.
pub(crate) fn mesh_in_fog() -> Arc<Scene> {
    let ball = icosphere(3);
    let geometry = Geometry::default();
    let mesh = add(&geometry, &ball, 0, Some(&ball.radial_normals()));
    geometry.add_instance(mesh, &rows(DMat4::from_scale(DVec3::splat(0.5))), 0, -1).expect("valid");
    let description = Description {
        materials: vec![GLASS],
        objects: vec![ObjectFields { volume: -1, is_closed: true, ..ObjectFields::default() }],
        shapes: Vec::new(),
        volumes: vec![volume(FOG)],
        world_volume: 0,
        lights: vec![light(LAMP)],
        camera: CAMERA,
        sees: Sees::FogAlone,
    };
    Arc::new(description.scene(built(&geometry)).expect("valid"))
}

/// The same of a sphere, as it is in a description without meshes.
pub(crate) fn sphere(center: Vec3, radius: f32) -> ShapeFields {
    ShapeFields { shape: Shape::Sphere { center, radius }, material: 0, volume: -1, priority: 0 }
}

/// The same view in so many pixels.
pub(crate) fn view(side: u32) -> CameraFields {
    let step = 0.8 / side as f32;
    let frame = Frame::Part { left: -0.4, top: 0.4, step: [step; 2] };
    CameraFields { frame, width: side, height: side, ..CAMERA }
}

/// A sphere of glass in endless fog, and a lamp: everything that is to be seen.
pub(crate) fn sphere_in_fog(camera: CameraFields) -> Arc<Scene> {
    sphere_at(Vec3::ZERO, camera)
}

/// The same with the sphere elsewhere.
pub(crate) fn sphere_at(center: Vec3, camera: CameraFields) -> Arc<Scene> {
    without_meshes(&Description {
        materials: vec![GLASS],
        objects: Vec::new(),
        shapes: vec![sphere(center, 0.5)],
        volumes: vec![volume(FOG)],
        world_volume: 0,
        lights: vec![light(LAMP)],
        camera,
        sees: Sees::Everything,
    })
}

/// covbeam's method on two threads, which say more than one about the order of sums.
pub(crate) fn options(photons: u32) -> Options {
    Options { settings: Settings::of(Method::Covbeam, photons, 1), threads: 2, ..Options::default() }
}

pub(crate) fn session(scene: &Arc<Scene>, options: Options) -> Session {
    Session::new(std::slice::from_ref(scene), options, &mut || true).expect("a valid session")
}

/// Renders passes until there are so many.
pub(crate) fn fill(session: &Session, passes: u32) {
    while session.info().passes < passes {
        session.pass(&mut || true).expect("a pass");
    }
}

pub(crate) fn shown(session: &Session) -> Arc<Picture> {
    session.picture(&mut || true).expect("a picture")
}

/// A picture of so many passes.
pub(crate) fn picture(session: &Session, passes: u32) -> Arc<Picture> {
    fill(session, passes);
    shown(session)
}

/// Panics unless two pictures are the same down to the bits of their colours.
#[track_caller]
pub(crate) fn assert_same(found: &Picture, expected: &Picture) {
    let of = |colors: &[Vec3]| colors.iter().flat_map(|color| color.to_array()).map(f32::to_bits).collect();
    let bits = |picture: &Picture| {
        let kinds = picture.kinds.iter().map(|(_, colors)| of(colors));
        std::iter::once(of(&picture.radiance)).chain(kinds).collect::<Vec<Vec<u32>>>()
    };
    assert!(found == expected && bits(found) == bits(expected), "{found:?} is not {expected:?}");
}
