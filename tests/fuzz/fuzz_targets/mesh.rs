//! Any bytes as an OBJ file: a mesh that can be traced, or an error.
#![no_main]

use covbeam_geometry::mesh::{Mesh, Placement};
use covbeam_geometry::obj;
use covbeam_render::scene_file;
use covbeam_session::scene::{Material, Object, Scene, Shape};
use glam::Vec3;
use libfuzzer_sys::fuzz_target;
use std::path::Path;
use std::sync::OnceLock;

const EMPTY: &str = "[camera]\nposition=[0,0,0]\nlook_at=[0,0,1]\nvertical_fov=40\nwidth=4\nheight=4\n\
    [grid]\nmin=[-1,-1,-1]\nmax=[1,1,1]\n[[light]]\nkind=\"point\"\nposition=[0,1,0]\nintensity=1";

fuzz_target!(|bytes: &[u8]| {
    static SCENE: OnceLock<Scene> = OnceLock::new();
    let Ok(source) = obj::parse(bytes) else { return };
    for smooth in [false, true] {
        let Ok(mesh) = Mesh::new(source.clone(), &Placement::default(), smooth) else { return };
        let (min, max) = mesh.bounds();
        let (center, size) = (0.5 * (min + max), (max - min).length());
        let mut scene =
            SCENE.get_or_init(|| scene_file::parse(EMPTY, "", Path::new("")).expect("valid")).clone();
        let material = if mesh.is_closed() { Material::Dielectric { index: 1.5 } } else { Material::Black };
        scene.objects = vec![Object {
            name: String::new(),
            shape: Shape::Mesh(mesh),
            material,
            inside: None,
            priority: 0,
            inner: Vec::new(),
        }];
        for direction in [Vec3::X, Vec3::NEG_Y, Vec3::new(0.48, 0.6, 0.64)] {
            let from = center - size * direction;
            if let Some(hit) = scene.intersect(from, direction, f32::INFINITY) {
                assert!(hit.distance > 0.0 && hit.position.is_finite() && hit.leave(direction).is_finite());
                assert!(hit.normal.is_normalized() && hit.geometric_normal.is_normalized());
                assert!(hit.normal.dot(hit.geometric_normal) > 0.0);
                let curvature = hit.curvature;
                assert!(!(curvature.along + curvature.across + curvature.twist).is_nan());
            }
            scene.occluded(from, center + size * direction);
        }
        scene.containing(center).count();
    }
});
