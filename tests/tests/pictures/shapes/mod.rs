//! Meshes whose surface is known in closed form, and random numbers to shoot at them.

use covbeam_geometry::mesh::Mesh;
use covbeam_geometry::obj::ObjTriangles;
use covbeam_render::scene_file;
use covbeam_session::scene::{Material, Object, Scene, Shape};
use glam::{DVec3, Vec3};

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

    /// Uniform in [0, 1).
    pub(crate) fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in [-1, 1)³.
    pub(crate) fn cube(&mut self) -> DVec3 {
        DVec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }

    /// Uniform on the sphere of directions.
    pub(crate) fn direction(&mut self) -> Vec3 {
        loop {
            let p = self.cube();
            if (0.01..1.0).contains(&p.length_squared()) {
                return p.normalize().as_vec3().normalize();
            }
        }
    }

    /// Uniform in 0..count.
    pub(crate) fn index(&mut self, count: usize) -> usize {
        (self.bits() % count as u64) as usize
    }
}

/// The unit sphere as `rows` by `2 rows` quads, outward; vertices are rounded, otherwise exact.
pub(crate) fn globe(rows: u32) -> ObjTriangles {
    let columns = 2 * rows;
    let point = |row: u32, column: u32| {
        let polar = std::f64::consts::PI * f64::from(row) / f64::from(rows);
        let azimuth = std::f64::consts::TAU * f64::from(column % columns) / f64::from(columns);
        // The exact pole: sin(π) is not zero in f64.
        let ring = if row == 0 || row == rows { 0.0 } else { polar.sin() };
        DVec3::new(ring * azimuth.cos(), ring * azimuth.sin(), polar.cos()).as_vec3()
    };
    let (mut positions, mut indices) = (Vec::new(), Vec::new());
    for row in 0..rows {
        for column in 0..columns {
            let first = positions.len() as u32;
            positions.extend([
                point(row, column),
                point(row + 1, column),
                point(row + 1, column + 1),
                point(row, column + 1),
            ]);
            if row + 1 < rows {
                indices.push([first, first + 1, first + 2]);
            }
            if row > 0 {
                indices.push([first, first + 2, first + 3]);
            }
        }
    }
    ObjTriangles { positions, normals: Vec::new(), indices }
}

/// Moves every vertex; normals are dropped.
pub(crate) fn deformed(mut source: ObjTriangles, map: impl Fn(Vec3) -> Vec3) -> ObjTriangles {
    source.positions.iter_mut().for_each(|p| *p = map(*p));
    source.normals.clear();
    source
}

/// A lumpy closed surface with concave parts and thin triangles, like a scanned figurine.
pub(crate) fn lumpy(rows: u32) -> ObjTriangles {
    deformed(globe(rows), |p| {
        let wave = (7.0 * p.x).sin() * (5.0 * p.y + 1.0).cos() * (6.0 * p.z).sin();
        p * (0.7 + 0.3 * wave) * Vec3::new(0.6, 1.4, 0.9)
    })
}

/// A scene that holds only these shapes.
pub(crate) fn scene_of(shapes: Vec<(Shape, Material)>) -> Scene {
    let text = "[camera]\nposition=[0,0,0]\nlook_at=[0,0,1]\nvertical_fov=40\nwidth=4\nheight=4\n\
                [grid]\nmin=[-1,-1,-1]\nmax=[1,1,1]\n[[light]]\nkind=\"point\"\nposition=[0,1,0]\nintensity=1";
    let mut scene = scene_file::parse(text, "test", std::path::Path::new("")).expect("valid");
    scene.objects = shapes
        .into_iter()
        .map(|(shape, material)| Object {
            name: "test".to_owned(),
            shape,
            material,
            inside: None,
            priority: 0,
            inner: Vec::new(),
        })
        .collect();
    scene
}

/// A scene of one glass mesh.
pub(crate) fn glass(mesh: Mesh) -> Scene {
    scene_of(vec![(Shape::Mesh(mesh), Material::Dielectric { index: 1.5 })])
}
