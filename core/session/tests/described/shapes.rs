//! Meshes known in closed form, transforms, and a ray tracer that is slow and simple.

use covbeam_geometry::hit::Hit;
use covbeam_geometry::instances::Instances;
use covbeam_session::camera::{Frame, Projection};
use covbeam_session::describe::geometry::Geometry;
use covbeam_session::describe::{CameraFields, MeshArrays};
use glam::{DMat4, DQuat, DVec3, EulerRot, Vec3};
use std::collections::HashMap;
use std::sync::Arc;

/// Looks along z from -4.
pub(crate) const CAMERA: CameraFields = CameraFields {
    position: [0.0, 0.0, -4.0],
    right: [1.0, 0.0, 0.0],
    up: [0.0, 1.0, 0.0],
    forward: [0.0, 0.0, 1.0],
    frame: Frame::Part { left: -0.4, top: 0.4, step: [0.05; 2] },
    near: 0.0,
    aperture: 0.0,
    focus: 0.0,
    rotation: 0.0,
    ratio: 0.0,
    blades: 0,
    projection: Projection::Perspective,
    width: 16,
    height: 16,
    is_own: false,
};

/// SplitMix64 (Steele, Lea and Flood 2014).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [-1, 1).
    pub(crate) fn signed(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// Uniform in [-1, 1)³.
    pub(crate) fn cube(&mut self) -> DVec3 {
        DVec3::new(self.signed(), self.signed(), self.signed())
    }

    /// Uniform on the sphere of directions.
    pub(crate) fn direction(&mut self) -> DVec3 {
        loop {
            let p = self.cube();
            if (0.01..1.0).contains(&p.length_squared()) {
                return p.normalize();
            }
        }
    }

    /// Uniform in 0..count.
    pub(crate) fn index(&mut self, count: usize) -> usize {
        (self.bits() % count as u64) as usize
    }

    /// Turned, stretched by up to 3 along each axis, sheared, one in two mirrored, moved by up to 5.
    pub(crate) fn transform(&mut self) -> DMat4 {
        let stretch = DVec3::new(self.stretch(), self.stretch(), self.stretch());
        let mut shear = DMat4::IDENTITY;
        shear.y_axis.x = 0.5 * self.signed();
        DMat4::from_translation(5.0 * self.cube()) * self.turn() * shear * DMat4::from_scale(stretch)
    }

    /// Turned anyhow.
    pub(crate) fn turn(&mut self) -> DMat4 {
        let angles = 3.0 * self.cube();
        DMat4::from_quat(DQuat::from_euler(EulerRot::XYZ, angles.x, angles.y, angles.z))
    }

    fn stretch(&mut self) -> f64 {
        let size = 3.0f64.powf(self.signed());
        if self.signed() < 0.0 { -size } else { size }
    }
}

/// Triangles with shared vertices.
#[derive(Clone)]
pub(crate) struct Shape {
    pub(crate) positions: Vec<Vec3>,
    pub(crate) triangles: Vec<[i32; 3]>,
}

impl Shape {
    /// Corners of a triangle.
    pub(crate) fn corners(&self, triangle: usize) -> [Vec3; 3] {
        self.triangles[triangle].map(|corner| self.positions[corner as usize])
    }

    /// Moves all vertices.
    pub(crate) fn moved(mut self, map: impl Fn(Vec3) -> Vec3) -> Self {
        self.positions.iter_mut().for_each(|p| *p = map(*p));
        self
    }

    /// The vertices as normals: those of a sphere around the origin.
    pub(crate) fn radial_normals(&self) -> Vec<[[f32; 3]; 3]> {
        (0..self.triangles.len()).map(|t| self.corners(t).map(|p| p.normalize().to_array())).collect()
    }
}

/// The unit sphere: an icosahedron whose triangles are cut in four `levels` times.
pub(crate) fn icosphere(levels: u32) -> Shape {
    let golden = (1.0 + 5.0f64.sqrt()) / 2.0;
    let mut positions: Vec<DVec3> = Vec::new();
    for (a, b) in [(-1.0, golden), (1.0, golden), (-1.0, -golden), (1.0, -golden)] {
        positions.extend([DVec3::new(a, b, 0.0), DVec3::new(0.0, a, b), DVec3::new(b, 0.0, a)]);
    }
    positions.iter_mut().for_each(|p| *p = p.normalize());
    // The faces are the triples of neighbours, turned outwards. Neighbours are 1.05 apart, others at least 1.7.
    let near = |i: usize, j: usize| positions[i].distance(positions[j]) < 1.2;
    let mut triangles = Vec::new();
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                if near(i, j) && near(j, k) && near(i, k) {
                    let [a, b, c] = [i, j, k].map(|v| positions[v]);
                    let outwards = (b - a).cross(c - a).dot(a) > 0.0;
                    triangles.push(if outwards { [i, j, k] } else { [i, k, j] });
                }
            }
        }
    }
    for _ in 0..levels {
        let mut middles = HashMap::new();
        let mut middle = |a: usize, b: usize| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                positions.push((positions[a] + positions[b]).normalize());
                positions.len() - 1
            })
        };
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
            })
            .collect();
    }
    Shape {
        positions: positions.iter().map(|p| p.as_vec3()).collect(),
        triangles: triangles.iter().map(|t| t.map(|v| v as i32)).collect(),
    }
}

/// A lumpy closed surface with concave parts.
pub(crate) fn lumpy(levels: u32) -> Shape {
    icosphere(levels).moved(|p| {
        let wave = (7.0 * p.x).sin() * (5.0 * p.y + 1.0).cos() * (6.0 * p.z).sin();
        p * (0.7 + 0.3 * wave) * Vec3::new(0.6, 1.4, 0.9)
    })
}

/// A matrix by rows, as the interface takes it.
pub(crate) fn rows(matrix: DMat4) -> [f64; 16] {
    matrix.transpose().to_cols_array()
}

/// Adds a shape with one material.
pub(crate) fn add(
    geometry: &Geometry,
    shape: &Shape,
    material: i32,
    normals: Option<&[[[f32; 3]; 3]]>,
) -> u32 {
    let positions: Vec<[f32; 3]> = shape.positions.iter().map(Vec3::to_array).collect();
    let arrays =
        MeshArrays { positions: &positions, triangles: &shape.triangles, materials: &[material], normals };
    geometry.add_mesh(&arrays).expect("a valid mesh").0
}

/// Builds and waits.
pub(crate) fn built(geometry: &Geometry) -> Arc<Instances> {
    geometry.build(&mut || true).expect("builds");
    geometry.built().expect("is built")
}

/// A scene of one shape in one place.
pub(crate) fn alone(shape: &Shape, normals: Option<&[[[f32; 3]; 3]]>, matrix: DMat4) -> Arc<Instances> {
    let geometry = Geometry::default();
    let mesh = add(&geometry, shape, 0, normals);
    geometry.add_instance(mesh, &rows(matrix), 0, -1).expect("a valid instance");
    built(&geometry)
}

/// The nearest hit with distance in (0, max_distance).
pub(crate) fn cast(scene: &Instances, origin: Vec3, direction: Vec3, max_distance: f32) -> Option<Hit> {
    let hit = scene.intersect(origin.as_dvec3(), direction.as_dvec3(), max_distance.into());
    hit.map(|hit| scene.describe(&hit))
}

/// The same of a ray that meets something.
#[track_caller]
pub(crate) fn hit(scene: &Instances, origin: Vec3, direction: Vec3) -> Hit {
    cast(scene, origin, direction, f32::INFINITY).expect("something is hit")
}

/// Distance to a triangle in double precision (Möller and Trumbore 1997).
pub(crate) fn distance_to(origin: DVec3, direction: DVec3, [a, b, c]: [DVec3; 3]) -> Option<f64> {
    let (ab, ac) = (b - a, c - a);
    let across = direction.cross(ac);
    let determinant = ab.dot(across);
    let from = origin - a;
    let u = from.dot(across) / determinant;
    let turned = from.cross(ab);
    let v = direction.dot(turned) / determinant;
    let distance = ac.dot(turned) / determinant;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 0.0).then_some(distance)
}
