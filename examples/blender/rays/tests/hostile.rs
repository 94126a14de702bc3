//! Arguments that no module should pass: each is refused by a status and a message that says what is wrong and where.

#![allow(unsafe_code, reason = "the C interface is what is tested")]
#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "what is wrong on purpose is refused before it is touched"
)]

mod calls;
mod shapes;

use calls::{message, refused};
use core::ffi::c_void;
use covbeam_rays::abi::*;
use covbeam_rays::cast::HitRecord;
use covbeam_rays::describe::{CameraFields, LightFields, MaterialFields, VolumeFields};
use covbeam_rays::session::{SessionInfo, SettingsFields};
use shapes::CAMERA;
use std::ptr::{null, null_mut};

const POSITIONS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const TRIANGLES: [[i32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];
const IDENTITY: [f64; 16] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];

fn geometry() -> *mut c_void {
    let mut geometry = null_mut();
    assert_eq!(unsafe { covbeam_rays_geometry_new(&mut geometry) }, 0);
    geometry
}

fn add(
    geometry: *const c_void,
    positions: &[[f32; 3]],
    triangles: &[[i32; 3]],
    materials: &[i32],
    normals: Option<&[[[f32; 3]; 3]]>,
) -> i32 {
    let (mut mesh, mut dropped) = (0, 0);
    unsafe {
        covbeam_rays_geometry_add_mesh(
            geometry,
            positions.len(),
            positions.as_ptr(),
            triangles.len(),
            triangles.as_ptr(),
            materials.len(),
            materials.as_ptr(),
            normals.map_or(null(), <[_]>::as_ptr),
            &mut mesh,
            &mut dropped,
        )
    }
}

fn built() -> *mut c_void {
    let geometry = geometry();
    assert_eq!(add(geometry, &POSITIONS, &TRIANGLES, &[0], None), 0);
    let mut done = 0;
    unsafe {
        assert_eq!(covbeam_rays_geometry_add_instance(geometry, 0, IDENTITY.as_ptr(), 0, -1), 0);
        assert_eq!(covbeam_rays_geometry_build(geometry), 0);
        while done == 0 {
            assert_eq!(covbeam_rays_geometry_wait(geometry, 1000, &mut done), 0);
        }
    }
    geometry
}

#[test]
fn meshes_that_are_wrong_are_refused_with_what_is_wrong_and_where() {
    let geometry = geometry();
    let with = |index: usize, value: [f32; 3]| {
        let mut positions = POSITIONS;
        positions[index] = value;
        positions
    };
    refused(
        add(geometry, &with(2, [0.0, f32::NAN, 0.0]), &TRIANGLES, &[0], None),
        1,
        &["positions[2]", "finite"],
    );
    refused(add(geometry, &with(3, [2e9, 0.0, 0.0]), &TRIANGLES, &[0], None), 1, &["positions[3]", "1e9"]);
    refused(
        add(geometry, &POSITIONS, &[[0, 1, 2], [0, 1, 4]], &[0], None),
        1,
        &["triangles[1]", "0 to 4 - 1"],
    );
    refused(add(geometry, &POSITIONS, &[[0, 1, -1]], &[0], None), 1, &["triangles[0]", "-1"]);
    refused(add(geometry, &POSITIONS, &TRIANGLES, &[0, 1, 2], None), 1, &["materials", "3", "2 triangles"]);
    refused(add(geometry, &POSITIONS, &TRIANGLES, &[], None), 1, &["materials: 0"]);
    let up = [0.0, 0.0, 1.0];
    for wrong in [[0.0, 0.0, 0.9], [0.0; 3], [f32::NAN, 0.0, 0.0], [f32::INFINITY, 0.0, 0.0]] {
        let normals = [[up; 3], [up, up, wrong]];
        let status = add(geometry, &POSITIONS, &TRIANGLES, &[0], Some(&normals));
        refused(status, 1, &["normals[1, 2]", "length 1"]);
    }
    unsafe {
        let (mut mesh, mut dropped) = (0, 0);
        let mut add = |count: usize, positions: *const [f32; 3], triangles: *const [i32; 3]| {
            let material = 0;
            covbeam_rays_geometry_add_mesh(
                geometry,
                count,
                positions,
                2,
                triangles,
                1,
                &material,
                null(),
                &raw mut mesh,
                &raw mut dropped,
            )
        };
        let (positions, triangles) = (POSITIONS.as_ptr(), TRIANGLES.as_ptr());
        refused(add(4, null(), triangles), 1, &["positions", "NULL"]);
        refused(add(4, positions, null()), 1, &["triangles", "NULL"]);
        refused(add(4, positions.byte_add(2), triangles), 1, &["positions", "multiple of 4"]);
        refused(add(usize::MAX / 2, positions, triangles), 1, &["positions", "more than memory"]);
        refused(add(usize::MAX, positions, triangles), 1, &["positions", "more than memory"]);
        // None of them has become a mesh.
        let place = covbeam_rays_geometry_add_instance(geometry, 0, IDENTITY.as_ptr(), 0, -1);
        refused(place, 1, &["mesh: 0", "there are 0"]);
        assert_eq!(covbeam_rays_geometry_free(geometry), 0);
    }
}

#[test]
fn transforms_that_are_wrong_are_refused() {
    let geometry = geometry();
    assert_eq!(add(geometry, &POSITIONS, &TRIANGLES, &[0], None), 0);
    let place = |changes: &[(usize, f64)]| {
        let mut matrix = IDENTITY;
        changes.iter().for_each(|&(index, value)| matrix[index] = value);
        unsafe { covbeam_rays_geometry_add_instance(geometry, 0, matrix.as_ptr(), 0, -1) }
    };
    refused(place(&[(3, f64::NAN)]), 1, &["matrix", "not finite"]);
    refused(place(&[(0, f64::INFINITY)]), 1, &["matrix", "not finite"]);
    refused(place(&[(12, 0.5)]), 1, &["matrix", "last row", "affine"]);
    refused(place(&[(10, 0.0)]), 1, &["matrix", "flattens", "leave"]);
    // Two columns of the same direction, and a size whose inverse is beyond double precision.
    refused(place(&[(5, 0.0), (1, 1.0)]), 1, &["matrix", "flattens"]);
    refused(place(&[(0, 1e-310), (5, 1e-310), (10, 1e-310)]), 1, &["matrix", "flattens"]);
    refused(place(&[(3, 2e9)]), 1, &["matrix", "1e9"]);
    unsafe {
        refused(covbeam_rays_geometry_add_instance(geometry, 0, null(), 0, -1), 1, &["matrix", "NULL"]);
        refused(covbeam_rays_geometry_add_instance(geometry, 1, IDENTITY.as_ptr(), 0, -1), 1, &["mesh: 1"]);
        // Small and thin is fine.
        assert_eq!(place(&[(0, 1e-9), (5, 1e-9), (10, 1e-3)]), 0, "{}", message());
        assert_eq!(covbeam_rays_geometry_free(geometry), 0);
    }
}

/// A scene that is right: a lamp in a ball of fog, seen from outside.
struct Given {
    materials: [MaterialFields; 2],
    object_volumes: Vec<i32>,
    object_closed: Vec<u8>,
    volumes: Vec<VolumeFields>,
    densities: Option<Vec<f32>>,
    glow: Option<Vec<[f32; 3]>>,
    parts: Vec<i32>,
    world_volume: i32,
    light: LightFields,
    triangles: Vec<[[f32; 3]; 3]>,
    cells: Option<Vec<[f32; 3]>>,
    camera: CameraFields,
}

impl Default for Given {
    fn default() -> Self {
        let fog = VolumeFields {
            scattering: [0.3; 3],
            absorption: [0.1; 3],
            min: [-1.0; 3],
            max: [1.0; 3],
            asymmetry: 0.4,
            density_min: [-1.0; 3],
            density_max: [1.0; 3],
            glow_min: [-1.0; 3],
            glow_max: [1.0; 3],
            cells: [2, 1, 1],
            glow_cells: [1, 2, 1],
            phase: 1,
        };
        Self {
            materials: [MaterialFields { ior: 1.5, transparent: [1.0; 3], ..MaterialFields::default() }; 2],
            object_volumes: vec![0],
            object_closed: vec![1],
            volumes: vec![fog; 3],
            densities: None,
            glow: None,
            parts: vec![0, 1],
            world_volume: -1,
            light: LIGHT,
            triangles: vec![[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]],
            cells: None,
            camera: CAMERA,
        }
    }
}

const LIGHT: LightFields = LightFields {
    position: [0.5, 2.0, 0.0],
    axis: [0.0, -1.0, 0.0],
    u: [1.0, 0.0, 0.0],
    v: [0.0, 0.0, 1.0],
    intensity: [10.0; 3],
    radiance: [1.0; 3],
    irradiance: [1.0; 3],
    axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    radius: 0.1,
    cosine: 0.5,
    blend: 0.1,
    spread: 1.0,
    angle: 0.01,
    reach: 3.0,
    kind: 0,
    soft: 0,
    round: 0,
    rows: 2,
    columns: 2,
};

impl Given {
    /// The status of a scene made of it, and the scene, which is NULL if it was refused.
    fn scene(&self, geometry: *const c_void) -> (i32, *mut c_void) {
        let volumes: Vec<covbeam_rays_volume> = self
            .volumes
            .iter()
            .enumerate()
            .map(|(index, &fields)| covbeam_rays_volume {
                fields,
                densities: self.densities.as_ref().filter(|_| index == 0).map_or(null(), |d| d.as_ptr()),
                glow: self.glow.as_ref().filter(|_| index == 0).map_or(null(), |glow| glow.as_ptr()),
                // The third is the sum of the others.
                part_count: if index == 2 { self.parts.len() } else { 0 },
                parts: self.parts.as_ptr(),
            })
            .collect();
        let light = covbeam_rays_light {
            fields: self.light,
            triangle_count: self.triangles.len(),
            triangles: self.triangles.as_ptr(),
            cells: self.cells.as_ref().map_or(null(), |cells| cells.as_ptr()),
        };
        let description = covbeam_rays_description {
            material_count: 2,
            materials: self.materials.as_ptr(),
            object_count: self.object_volumes.len(),
            object_volumes: self.object_volumes.as_ptr(),
            object_closed: self.object_closed.as_ptr(),
            volume_count: volumes.len(),
            volumes: volumes.as_ptr(),
            light_count: 1,
            lights: &light,
            world_volume: self.world_volume,
            camera: self.camera,
        };
        let mut scene = null_mut();
        let status = unsafe { covbeam_rays_scene_new(geometry, &description, &mut scene) };
        (status, scene)
    }
}

/// Numbers that no field takes that is a length or a place.
const HOSTILE: [f64; 4] = [f64::NAN, f64::INFINITY, -f64::INFINITY, 3e38];

#[test]
fn scenes_that_are_wrong_are_refused_with_the_name_of_the_field() {
    let geometry = built();
    let refuse = |change: &dyn Fn(&mut Given), parts: &[&str]| {
        let mut given = Given::default();
        change(&mut given);
        let (status, scene) = given.scene(geometry);
        refused(status, 1, parts);
        assert!(scene.is_null());
    };
    let (status, scene) = Given::default().scene(geometry);
    assert_eq!(status, 0, "{}", message());
    assert_eq!(unsafe { covbeam_rays_scene_free(scene) }, 0);

    for wrong in HOSTILE {
        let small = wrong as f32;
        refuse(&|given| given.materials[1].metal[2] = small, &["materials[1].metal", "from 0 to 1"]);
        refuse(&|given| given.materials[0].ior = small, &["materials[0].ior"]);
        refuse(&|given| given.volumes[0].scattering[1] = wrong, &["volumes[0].scattering"]);
        refuse(&|given| given.volumes[1].absorption[0] = wrong, &["volumes[1].absorption"]);
        refuse(&|given| given.volumes[1].min[0] = wrong, &["volumes[1].min"]);
        refuse(&|given| given.volumes[0].asymmetry = wrong, &["volumes[0].asymmetry"]);
        refuse(&|given| given.light.position[2] = wrong, &["lights[0].position", "1e9"]);
        refuse(&|given| given.light.radius = wrong, &["lights[0].radius"]);
        refuse(&|given| given.camera.position[1] = wrong, &["camera.position"]);
        refuse(&|given| given.camera.forward[1] = wrong, &["camera.forward", "length 1"]);
        refuse(&|given| given.camera.step[1] = wrong, &["camera.step"]);
        refuse(&|given| given.camera.near = wrong, &["camera.near"]);
        let fisheye = |given: &mut Given| (given.camera.projection, given.camera.widest) = (3, wrong);
        refuse(&fisheye, &["camera.widest"]);
        refuse(&|given| given.camera.aperture = wrong, &["camera.aperture.radius"]);
        let with = |kind: u32, set: &dyn Fn(&mut LightFields), parts: &[&str]| {
            refuse(
                &|given: &mut Given| {
                    given.light.kind = kind;
                    set(&mut given.light);
                },
                parts,
            );
        };
        with(1, &|light| light.axis[0] = wrong, &["lights[0].axis", "length 1"]);
        with(1, &|light| light.cosine = wrong, &["lights[0].cosine"]);
        with(1, &|light| light.blend = wrong, &["lights[0].blend"]);
        with(2, &|light| light.u[0] = wrong, &["lights[0].u"]);
        with(2, &|light| light.spread = wrong, &["lights[0].spread"]);
        with(2, &|light| light.radiance[0] = wrong, &["lights[0].radiance"]);
        with(3, &|light| light.angle = wrong, &["lights[0].angle"]);
        with(3, &|light| light.irradiance[0] = wrong, &["lights[0].irradiance"]);
        refuse(
            &|given| {
                given.light.kind = 4;
                given.triangles[0][2][1] = small;
            },
            &["lights[0].triangles[0, 2]"],
        );
        for (kind, name) in [(0, "lights[0].pattern.cells[1, 0]"), (5, "lights[0].sky[1, 0]")] {
            refuse(
                &|given| {
                    given.light.kind = kind;
                    given.cells = Some(vec![[1.0; 3], [1.0; 3], [1.0, small, 1.0], [1.0; 3]]);
                },
                &[name],
            );
        }
        refuse(&|given| given.densities = Some(vec![1.0, small]), &["volumes[0].density.values[1]"]);
        refuse(&|given| given.glow = Some(vec![[1.0; 3], [0.0, small, 0.0]]), &["volumes[0].glow.values[1]"]);
    }
    refuse(&|given| given.light.intensity[0] = -1.0, &["lights[0].intensity", "from 0"]);
    refuse(&|given| given.light.kind = 6, &["lights[0].kind: 6"]);
    refuse(&|given| given.light.kind = 5, &["lights[0].sky: \"NULL\""]);
    refuse(
        &|given| {
            (given.light.intensity, given.light.radius) = ([1e30; 3], 1e9);
            given.light.kind = 2;
            (given.light.radiance, given.light.u, given.light.v) =
                ([1e30; 3], [1e9, 0.0, 0.0], [0.0, 0.0, 1e9]);
        },
        &["lights[0].flux"],
    );
    let mirror = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]];
    refuse(
        &|given| {
            (given.light.kind, given.light.axes) = (5, mirror);
            given.cells = Some(vec![[1.0; 3]; 4]);
        },
        &["lights[0].turn", "mirror"],
    );
    refuse(&|given| given.camera.up = [1.0, 0.0, 0.0], &["camera.right", "right angles"]);
    refuse(&|given| given.camera.projection = 4, &["camera.projection: 4", "0 to 3"]);
    refuse(&|given| given.camera.width = 0, &["camera.width: 0"]);
    refuse(&|given| given.camera.height = 1 << 20, &["camera.height: 1048576"]);
    refuse(&|given| given.volumes[0].max = [-2.0; 3], &["volumes[0].max"]);
    refuse(&|given| given.volumes[0].phase = 3, &["volumes[0].phase: 3"]);
    refuse(&|given| given.parts = vec![0, 2], &["volumes[2].parts"]);
    refuse(&|given| given.parts = vec![0, -1], &["volumes[2].parts"]);
    refuse(&|given| given.world_volume = 3, &["world_volume: 3", "3 volumes"]);
    refuse(&|given| given.world_volume = 0, &["volumes[2].parts"]);
    refuse(&|given| (given.world_volume, given.parts) = (0, vec![1]), &["object_volumes[0]: 0", "neither"]);
    refuse(&|given| given.object_volumes = vec![2], &["object_volumes[0]: 2"]);
    refuse(&|given| given.object_volumes = vec![-2], &["object_volumes[0]: -2"]);
    refuse(&|given| given.object_volumes = vec![], &["object", "there are 0"]);
    // Numbers whose product no memory holds.
    refuse(
        &|given| {
            given.volumes[0].cells = [u32::MAX; 3];
            given.densities = Some(vec![1.0; 2]);
        },
        &["volumes[0].density", "more than memory"],
    );
    refuse(
        &|given| {
            given.volumes[0].glow_cells = [u32::MAX; 3];
            given.glow = Some(vec![[1.0; 3]; 2]);
        },
        &["volumes[0].glow", "more than memory"],
    );
    refuse(
        &|given| {
            given.volumes[0].glow_max[2] = -1.0;
            given.glow = Some(vec![[1.0; 3]; 2]);
        },
        &["volumes[0].glow.max", "1e-9 m wide"],
    );
    refuse(
        &|given| {
            (given.volumes[0].glow_min, given.volumes[0].glow_max) = ([-1e9; 3], [1e9; 3]);
            given.glow = Some(vec![[1e30; 3]; 2]);
        },
        &["volumes[0].glow.values", "power"],
    );
    refuse(
        &|given| {
            (given.world_volume, given.object_volumes) = (0, vec![1]);
            (given.glow, given.parts) = (Some(vec![[1.0; 3]; 2]), vec![1]);
        },
        &["volumes[0].glow", "no end"],
    );
    refuse(
        &|given| {
            (given.light.rows, given.light.columns) = (u32::MAX, u32::MAX);
            given.cells = Some(vec![[1.0; 3]; 4]);
        },
        &["lights[0].cells", "more than memory"],
    );
    refuse(
        &|given| {
            given.volumes[0].density_max[0] = -1.0;
            given.densities = Some(vec![1.0; 2]);
        },
        &["volumes[0].density.max"],
    );
    assert_eq!(unsafe { covbeam_rays_geometry_free(geometry) }, 0);
}

const SETTINGS: SettingsFields = SettingsFields {
    radius: 0.0,
    quality: 0.01,
    seed: 0,
    photons: 300,
    grid: 0,
    bounces: -1,
    beyond: 1,
    threads: 2,
};

/// Waits for the end of what goes on.
fn ended(session: *const c_void) -> i32 {
    let (mut done, mut status) = (0, 0);
    while done == 0 && status == 0 {
        status = unsafe { covbeam_rays_session_wait(session, 1000, &mut done) };
    }
    status
}

#[test]
fn settings_that_are_wrong_are_refused_and_calls_in_the_wrong_order() {
    let geometry = built();
    // Fog everywhere.
    let given = Given { world_volume: 2, parts: Vec::new(), ..Given::default() };
    let (_, scene) = given.scene(geometry);
    let mut session = null_mut();
    unsafe {
        let mut refuse = |settings: SettingsFields, part: &str| {
            refused(covbeam_rays_session_new(1, &scene.cast_const(), &settings, &mut session), 1, &[part]);
            assert!(session.is_null());
        };
        for radius in [f64::NAN, f64::INFINITY, -1.0, 3e38, 1e-300] {
            refuse(SettingsFields { radius, ..SETTINGS }, "settings.radius");
        }
        for quality in [f64::NAN, 0.0, -1.0, 1.1] {
            refuse(SettingsFields { quality, ..SETTINGS }, "settings.quality");
        }
        refuse(SettingsFields { photons: u32::MAX, ..SETTINGS }, "settings.photons: 4294967295");
        refuse(SettingsFields { grid: 257, ..SETTINGS }, "settings.grid: 257");
        refuse(SettingsFields { bounces: -2, ..SETTINGS }, "settings.bounces: -2");
        refuse(SettingsFields { threads: 1025, ..SETTINGS }, "settings.threads: 1025");
        refused(
            covbeam_rays_session_new(1, &geometry.cast_const(), &SETTINGS, &mut session),
            1,
            &["scene: another kind"],
        );
        refused(covbeam_rays_session_new(0, null(), &SETTINGS, &mut session), 1, &["scenes: none"]);
        refused(covbeam_rays_session_new(1, null(), &SETTINGS, &mut session), 1, &["scenes: NULL"]);
        let three = [scene.cast_const(); 3];
        refused(covbeam_rays_session_new(3, three.as_ptr(), &SETTINGS, &mut session), 1, &["power of two"]);
        for change in [
            &(|given: &mut Given| given.camera.width = 8) as &dyn Fn(&mut Given),
            &|given| given.light.intensity = [0.0; 3],
            &|given| {
                given.world_volume = 1;
                given.volumes.truncate(2);
            },
        ] {
            let mut other = Given { world_volume: 2, parts: Vec::new(), ..Given::default() };
            change(&mut other);
            let (status, other) = other.scene(geometry);
            assert_eq!(status, 0, "{}", message());
            let scenes = [scene.cast_const(), other.cast_const()];
            refused(
                covbeam_rays_session_new(2, scenes.as_ptr(), &SETTINGS, &mut session),
                1,
                &["scenes[1]: "],
            );
            assert_eq!(covbeam_rays_scene_free(other), 0);
        }
        refused(
            covbeam_rays_session_new(1, &scene.cast_const(), null(), &mut session),
            1,
            &["settings: NULL"],
        );
        refused(covbeam_rays_session_new(1, &scene.cast_const(), &SETTINGS, null_mut()), 1, &["out: NULL"]);

        assert_eq!(
            covbeam_rays_session_new(1, &scene.cast_const(), &SETTINGS, &mut session),
            0,
            "{}",
            message()
        );
        // A session needs neither any more.
        assert_eq!(covbeam_rays_scene_free(scene), 0);
        assert_eq!(covbeam_rays_geometry_free(geometry), 0);
        refused(covbeam_rays_session_start(session, 0), 2, &["wait for its end"]);
        refused(covbeam_rays_session_restart(session, 100, 0), 2, &["wait for its end"]);
        assert_eq!(ended(session), 0, "{}", message());
        let mut done = 0;
        refused(covbeam_rays_session_wait(session, 0, &mut done), 2, &["no work goes on"]);
        refused(covbeam_rays_session_start(session, 1), 2, &["a picture needs a pass"]);
        refused(covbeam_rays_session_start(session, 2), 1, &["task: 2"]);
        assert_eq!(covbeam_rays_session_start(session, 0), 0);
        assert_eq!(ended(session), 0, "{}", message());
        let (mut colors, mut values) = ([vec![[0.0_f32; 3]; 256], vec![[0.0; 3]; 256]], vec![0.0_f32; 256]);
        let mut picture = |count: usize| {
            let [all, first] = &mut colors;
            let (radius, bandwidth, mut error) = (values.as_mut_ptr(), &mut [0.0_f32; 256], [0.0_f32; 256]);
            covbeam_rays_session_picture(
                session,
                count,
                all.as_mut_ptr(),
                first.as_mut_ptr(),
                radius,
                bandwidth.as_mut_ptr(),
                error.as_mut_ptr(),
            )
        };
        refused(picture(256), 2, &["no picture has been made"]);
        refused(picture(255), 1, &["pixel_count: 255", "256"]);
        assert_eq!(covbeam_rays_session_start(session, 1), 0);
        assert_eq!(ended(session), 0, "{}", message());
        assert_eq!(picture(256), 0, "{}", message());
        refused(picture(256), 2, &["no picture has been made"]);
        let lit = colors[0].iter().filter(|color| color[0] > 0.0).count();
        assert!(lit > 20, "{lit} pixels see the fog");
        let mut info = SessionInfo::default();
        assert_eq!(covbeam_rays_session_info(session, &mut info), 0);
        assert_eq!((info.passes, info.photons, info.most_photons), (1, 300, 300));
        assert_eq!(covbeam_rays_session_restart(session, 0, 7), 0);
        assert_eq!(covbeam_rays_session_info(session, &mut info), 0);
        assert_eq!((info.passes, info.photons), (0, 1));
        refused(covbeam_rays_session_info(session, null_mut()), 1, &["info: NULL"]);
        assert_eq!(covbeam_rays_session_free(session), 0);
        assert_eq!(covbeam_rays_session_free(null_mut()), 0);
    }
}

#[test]
fn calls_in_the_wrong_order_and_wrong_handles_are_refused() {
    let (open, ready) = (geometry(), built());
    let (mut done, mut info) = (0, covbeam_rays_info::default());
    unsafe {
        refused(covbeam_rays_geometry_info(open, &mut info), 2, &["not built"]);
        refused(covbeam_rays_geometry_wait(open, 0, &mut done), 2, &["call build"]);
        refused(Given::default().scene(open).0, 2, &["not built"]);
        let mut hit = HitRecord::MISS;
        let mut cast = |geometry, origin: *const [f32; 3], direction: [f32; 3]| {
            covbeam_rays_geometry_cast(geometry, 1, origin, &direction, &mut hit)
        };
        refused(cast(open, &[0.0; 3], [0.0, 0.0, 1.0]), 2, &["not built"]);
        refused(cast(ready, null(), [0.0, 0.0, 1.0]), 1, &["origins: NULL"]);
        refused(cast(ready, &[f32::INFINITY; 3], [0.0, 0.0, 1.0]), 1, &["origins[0]", "finite"]);
        refused(cast(ready, &[0.0; 3], [f32::NAN; 3]), 1, &["directions[0]", "length 1"]);
        assert_eq!(cast(ready, &[0.1, 0.1, -1.0], [0.0, 0.0, 1.0]), 0, "{}", message());
        assert_eq!((hit.distance, hit.object), (1.0, 0));
        refused(covbeam_rays_geometry_build(ready), 2, &["geometry"]);
        refused(add(ready, &POSITIONS, &TRIANGLES, &[0], None), 2, &["meshes come before the build"]);
        let place = covbeam_rays_geometry_add_instance(ready, 0, IDENTITY.as_ptr(), 0, -1);
        refused(place, 2, &["instances come before the build"]);
        assert_eq!(covbeam_rays_geometry_info(ready, &mut info), 0);

        refused(covbeam_rays_geometry_build(null()), 1, &["geometry: NULL"]);
        refused(covbeam_rays_geometry_build(ready.byte_add(1)), 1, &["geometry", "multiple"]);
        refused(covbeam_rays_session_stop(ready), 1, &["session: another kind"]);
        refused(covbeam_rays_geometry_new(null_mut()), 1, &["out: NULL"]);
        refused(covbeam_rays_geometry_info(ready, null_mut()), 1, &["info: NULL"]);
        refused(covbeam_rays_scene_new(ready, null(), &mut null_mut()), 1, &["description: NULL"]);
        assert_eq!(covbeam_rays_geometry_free(null_mut()), 0);
        assert_eq!(covbeam_rays_geometry_free(open), 0);
        assert_eq!(covbeam_rays_geometry_free(ready), 0);
    }
}
