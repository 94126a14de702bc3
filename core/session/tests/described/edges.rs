//! Edges beside rays, against those found on the same meshes placed by covbeam-geometry, which has its own hierarchy.

use crate::shapes::{CAMERA, Random, add, built, icosphere, lumpy, rows};
use covbeam::{Edge, ProbeHit, find_edges};
use covbeam_geometry::hit::Hit;
use covbeam_geometry::mesh::{Mesh, Placement};
use covbeam_geometry::obj::ObjTriangles;
use covbeam_session::describe::geometry::Geometry;
use covbeam_session::describe::{Description, MaterialFields, ObjectFields};
use covbeam_session::scene::Sees;
use glam::{DMat4, DVec3, Vec3};

/// The reference: meshes in a row, flat.
struct Meshes(Vec<Mesh>);

impl Meshes {
    fn nearest(&self, origin: Vec3, direction: Vec3) -> Option<Hit> {
        let hits = self
            .0
            .iter()
            .filter_map(|mesh| Some((mesh, mesh.intersect(origin.as_dvec3(), direction, f64::INFINITY)?)));
        let (mesh, hit) = hits.min_by(|(_, a), (_, b)| a.distance.total_cmp(&b.distance))?;
        let surface = mesh.surface(&hit);
        let rounding = f32::EPSILON * surface.position.abs().max_element() as f32;
        Some(Hit {
            distance: hit.distance as f32,
            position: surface.position.as_vec3(),
            geometric_normal: surface.geometric_normal,
            normal: surface.normal,
            curvature: surface.curvature,
            object: 0,
            material: 0,
            mark: [0; 3],
            is_alone: false,
            offset: 4.0 * (rounding + mesh.position_error()),
        })
    }
}

#[test]
fn edges_are_those_of_the_same_meshes_in_another_hierarchy() {
    compare(false);
}

#[test]
fn what_lets_light_through_has_no_edges_and_hides_none() {
    compare(true);
}

/// `bounds`: with a ball around everything and one in the midst, of a material that lets light through.
fn compare(bounds: bool) {
    let mut reference = Meshes(Vec::new());
    let geometry = Geometry::default();
    for (shape, at, scale) in [
        (lumpy(4), Vec3::ZERO, 1.0f32),
        (icosphere(4), Vec3::new(1.5, 0.5, 1.0), 0.5),
        (lumpy(3), -Vec3::X, 0.5),
    ] {
        let indices = shape.triangles.iter().map(|t| t.map(|v| v as u32)).collect();
        let source = ObjTriangles { positions: shape.positions.clone(), normals: Vec::new(), indices };
        let placement = Placement { scale, translation: at, ..Placement::default() };
        reference.0.push(Mesh::new(source, &placement, false).expect("valid"));
        let matrix = DMat4::from_translation(at.as_dvec3()) * DMat4::from_scale(DVec3::splat(scale.into()));
        geometry.add_instance(add(&geometry, &shape, 0, None), &rows(matrix), 0, -1).expect("valid");
    }
    if bounds {
        let ball = add(&geometry, &icosphere(4), 1, None);
        for (radius, at) in [(2.6, DVec3::ZERO), (0.7, DVec3::new(0.5, -0.9, 0.3))] {
            let matrix = DMat4::from_translation(at) * DMat4::from_scale(DVec3::splat(radius));
            geometry.add_instance(ball, &rows(matrix), 1, -1).expect("valid");
        }
    }
    let materials = [MaterialFields { ior: 1.0, ..Default::default() }; 2];
    let materials = [materials[0], MaterialFields { transparent: [1.0; 3], ..materials[1] }];
    let description = Description {
        materials: materials.into(),
        objects: vec![ObjectFields { volume: -1, ..ObjectFields::default() }; 2],
        shapes: Vec::new(),
        volumes: Vec::new(),
        world_volume: -1,
        lights: Vec::new(),
        camera: CAMERA,
        sees: Sees::FogAlone,
    };
    let scene = description.scene(built(&geometry)).expect("valid");

    let (mut random, count) = (Random(5), 2000);
    let (mut same, mut found) = (0, 0);
    for _ in 0..count {
        let origin = 4.0 * random.direction();
        let direction = (random.cube() - origin).normalize().as_vec3().normalize();
        let origin = origin.as_vec3();
        let hit = scene.intersect(origin, direction, f32::INFINITY);
        let edges = scene.edges_beside(origin, direction, hit.as_ref());
        let nearest = |towards: Vec3| reference.nearest(origin, towards);
        let hit = nearest(direction);
        let probe = |towards: Vec3| nearest(towards).as_ref().map(ProbeHit::from);
        let expected = find_edges(direction, hit.as_ref().map(ProbeHit::from), probe);
        found += expected.len();
        let close = |(edge, expected): (&Edge, &Edge)| {
            // A share of what the search resolves, 5 %.
            (edge.depth / expected.depth - 1.0).abs() < 0.01
                && (edge.distance / expected.distance - 1.0).abs() < 0.01
                && edge.towards.dot(expected.towards) > 0.999
        };
        let equal = edges.len() == expected.len() && edges.iter().zip(expected.iter()).all(close);
        same += usize::from(equal);
    }
    assert!(found > count / 2, "the rays pass hardly any edges");
    // The meshes' hierarchies and roundings differ; a search that splits at an edge of a triangle may go the other way.
    assert!(same as f64 > 0.995 * count as f64, "{same} of {count} rays have the same edges");
}
