//! Descriptions of scenes.

use super::*;
use crate::session::description::covbeam_description;
use crate::session::scene::{covbeam_scene, covbeam_scene_free, covbeam_scene_new};

/// A scene that is right: a lamp in a ball of fog, seen from outside, and a ball of glass.
pub(super) struct Given {
    pub(super) materials: [covbeam_material; 2],
    pub(super) objects: Vec<covbeam_object>,
    pub(super) shapes: Vec<covbeam_shape>,
    pub(super) volumes: Vec<covbeam_volume>,
    pub(super) density: Option<Vec<f32>>,
    pub(super) glow: Option<Vec<[f32; 3]>>,
    pub(super) parts: Vec<i32>,
    pub(super) world_volume: i32,
    pub(super) light: covbeam_light,
    pub(super) triangles: Vec<[[f32; 3]; 3]>,
    pub(super) cells: Option<Vec<[f32; 3]>>,
    pub(super) camera: covbeam_camera,
}

/// All 0.
fn zeroed<T: Copy>() -> T {
    // SAFETY: structs of numbers and pointers, for which all 0 is a value.
    unsafe { core::mem::zeroed() }
}

impl Default for Given {
    fn default() -> Self {
        let fog = covbeam_volume {
            scattering: [0.3; 3],
            absorption: [0.1; 3],
            min: [-1.0; 3],
            max: [1.0; 3],
            asymmetry: 0.4,
            density_min: [-1.0; 3],
            density_max: [1.0; 3],
            glow_min: [-1.0; 3],
            glow_max: [1.0; 3],
            density_cells: [2, 1, 1],
            glow_cells: [1, 2, 1],
            phase: 1,
            ..zeroed()
        };
        let glass = covbeam_material { glass_transmission: [1.0; 3], glass_reflection: [1.0; 3], ..zeroed() };
        let ball = covbeam_shape { material: 1, volume: -1, a: [3.0, 0.0, 0.0], radius: 0.5, ..zeroed() };
        Self {
            materials: [covbeam_material { transparent: [1.0; 3], ..zeroed() }, glass],
            objects: vec![covbeam_object { volume: 0, is_closed: 1, ..zeroed() }],
            shapes: vec![ball],
            volumes: vec![fog; 3],
            density: None,
            glow: None,
            parts: vec![0, 1],
            world_volume: -1,
            light: covbeam_light {
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
                rows: 2,
                columns: 2,
                ..zeroed()
            },
            triangles: vec![[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]],
            cells: None,
            camera: covbeam_camera {
                position: [0.0, 0.0, -4.0],
                forward: [0.0, 0.0, 2.0],
                up: [0.0, 0.5, 0.1],
                left: -0.4,
                top: 0.4,
                step: [0.05; 2],
                width: 16,
                height: 16,
                ..zeroed()
            },
        }
    }
}

impl Given {
    /// The status of a scene made of it, and the scene, which is NULL if it was refused.
    pub(super) fn scene(&self, geometry: *const covbeam_geometry) -> (covbeam_status, *mut covbeam_scene) {
        // SAFETY: a live handle or NULL, and arrays as long as they say.
        self.made(|description, out| unsafe { covbeam_scene_new(geometry, description, out) })
    }

    /// The same by a function that makes scenes of descriptions.
    pub(super) fn made(
        &self,
        make: impl FnOnce(&covbeam_description, &mut *mut covbeam_scene) -> covbeam_status,
    ) -> (covbeam_status, *mut covbeam_scene) {
        let volume = |(index, &volume): (usize, &covbeam_volume)| covbeam_volume {
            density: self.density.as_ref().filter(|_| index == 0).map_or(null(), |density| density.as_ptr()),
            glow: self.glow.as_ref().filter(|_| index == 0).map_or(null(), |glow| glow.as_ptr().cast()),
            // The third is the sum of the others.
            part_count: if index == 2 { self.parts.len() as u32 } else { 0 },
            parts: self.parts.as_ptr(),
            ..volume
        };
        let volumes: Vec<covbeam_volume> = self.volumes.iter().enumerate().map(volume).collect();
        let light = covbeam_light {
            triangle_count: self.triangles.len(),
            triangles: self.triangles.as_ptr().cast(),
            cells: self.cells.as_ref().map_or(null(), |cells| cells.as_ptr().cast()),
            ..self.light
        };
        let description = covbeam_description {
            struct_size: size_of::<covbeam_description>() as u32,
            world_volume: self.world_volume,
            fog_alone: 1,
            material_count: 2,
            materials: self.materials.as_ptr(),
            object_count: self.objects.len(),
            objects: self.objects.as_ptr(),
            shape_count: self.shapes.len(),
            shapes: self.shapes.as_ptr(),
            volume_count: volumes.len(),
            volumes: volumes.as_ptr(),
            light_count: 1,
            lights: &light,
            camera: self.camera,
        };
        let mut scene = null_mut();
        let status = make(&description, &mut scene);
        (status, scene)
    }
}

/// Numbers that no field takes that is a length or a place.
const HOSTILE: [f64; 4] = [f64::NAN, f64::INFINITY, -f64::INFINITY, 3e38];

/// Arrays that no memory has are refused by where they would lie.
fn wanted(parts: &[&str]) -> covbeam_status {
    if parts.contains(&"more than memory") { COVBEAM_INVALID_ARRAY } else { COVBEAM_INVALID_VALUE }
}

#[test]
fn scenes_that_are_wrong_are_refused_with_the_name_of_the_field() {
    let geometry = built();
    let refuse = |change: &dyn Fn(&mut Given), parts: &[&str]| {
        let mut given = Given::default();
        change(&mut given);
        let (status, scene) = given.scene(geometry);
        refused(status, wanted(parts), parts);
        assert!(scene.is_null());
    };
    let (status, scene) = Given::default().scene(geometry);
    assert_eq!(status, COVBEAM_OK, "{}", message());
    // SAFETY: a live handle.
    assert_eq!(unsafe { covbeam_scene_free(scene) }, COVBEAM_OK);

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
        refuse(&|given| given.camera.step[1] = wrong, &["camera.step"]);
        refuse(&|given| given.camera.near = wrong, &["camera.near"]);
        let fisheye = |given: &mut Given| (given.camera.projection, given.camera.widest) = (3, wrong);
        refuse(&fisheye, &["camera.widest"]);
        refuse(&|given| given.camera.aperture = wrong, &["camera.aperture.radius"]);
        let with = |kind: u32, set: &dyn Fn(&mut covbeam_light), parts: &[&str]| {
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
        refuse(&|given| given.density = Some(vec![1.0, small]), &["volumes[0].density.values[1]"]);
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
    refuse(&|given| given.camera.up = [0.0, 0.0, 3.0], &["camera.up", "along forward"]);
    refuse(&|given| given.camera.projection = 4, &["camera.projection: 4", "covbeam_projection"]);
    refuse(&|given| given.camera.width = 0, &["camera.width: 0"]);
    refuse(&|given| given.camera.height = 1 << 20, &["camera.height: 1048576"]);
    refuse(&|given| given.volumes[0].max = [-2.0; 3], &["volumes[0].max"]);
    refuse(&|given| given.volumes[0].phase = 3, &["volumes[0].phase: 3"]);
    refuse(&|given| given.parts = vec![0, 2], &["volumes[2].parts"]);
    refuse(&|given| given.parts = vec![0, -1], &["volumes[2].parts"]);
    refuse(&|given| given.world_volume = 3, &["world_volume: 3", "3 volumes"]);
    refuse(&|given| given.world_volume = 0, &["volumes[2].parts"]);
    refuse(&|given| (given.world_volume, given.parts) = (0, vec![1]), &["objects[0].volume: 0", "neither"]);
    refuse(&|given| given.objects[0].volume = 2, &["objects[0].volume: 2"]);
    refuse(&|given| given.objects[0].volume = -2, &["objects[0].volume: -2"]);
    refuse(&|given| given.objects.clear(), &["object", "there are 0"]);
    // Numbers whose product no memory holds.
    refuse(
        &|given| {
            given.volumes[0].density_cells = [u32::MAX; 3];
            given.density = Some(vec![1.0; 2]);
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
            (given.world_volume, given.objects[0].volume) = (0, 1);
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
            given.density = Some(vec![1.0; 2]);
        },
        &["volumes[0].density.max"],
    );
    let shape =
        |set: &dyn Fn(&mut covbeam_shape), parts: &[&str]| refuse(&|given| set(&mut given.shapes[0]), parts);
    for wrong in HOSTILE.map(|wrong| wrong as f32) {
        shape(&|shape| shape.a[1] = wrong, &["shapes[0].center"]);
        shape(&|shape| shape.radius = wrong, &["shapes[0].radius"]);
        shape(&|shape| (shape.kind, shape.b[2]) = (1, wrong), &["shapes[0].max"]);
        shape(&|shape| (shape.kind, shape.c[2]) = (2, wrong), &["shapes[0].edge_v"]);
    }
    shape(&|shape| shape.radius = 0.0, &["shapes[0].radius"]);
    shape(&|shape| shape.kind = 3, &["shapes[0].kind: 3"]);
    shape(&|shape| (shape.kind, shape.material) = (2, 0), &["shapes[0].edge_v"]);
    shape(&|shape| (shape.kind, shape.b, shape.c) = (2, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]), &["no glass"]);
    shape(&|shape| shape.material = 2, &["shapes[0].material: 2", "2 materials"]);
    shape(&|shape| shape.volume = 3, &["shapes[0].volume: 3"]);
    shape(&|shape| shape.volume = 2, &["shapes[0].volume: 2", "no sum"]);
    refuse(
        &|given| {
            (given.shapes[0].material, given.shapes[0].volume) = (0, 1);
            given.parts.clear();
        },
        &["shapes[0].volume: 1", "not of glass"],
    );
    shape(&|shape| shape.priority = 1001, &["shapes[0].priority"]);
    // SAFETY: a live handle.
    assert_eq!(unsafe { covbeam_geometry_free(geometry) }, COVBEAM_OK);
}
