//! Small closed meshes, wound outward, that fit in a ball of radius 1, as Wavefront OBJ.

use glam::DVec3;
use std::f64::consts::{PI, TAU};
use std::fmt::Write;

/// A mesh that scenes name.
pub(super) struct MeshFile {
    /// Relative to the scene.
    pub(super) file: &'static str,
    /// Whether its normals are interpolated.
    pub(super) smooth: bool,
    /// The file's content.
    pub(super) text: fn() -> String,
}

pub(super) const ALL: [MeshFile; 3] = [
    MeshFile { file: "meshes/torus.obj", smooth: true, text: torus },
    MeshFile { file: "meshes/gem.obj", smooth: false, text: gem },
    MeshFile { file: "meshes/pebble.obj", smooth: true, text: pebble },
];

fn obj(points: &[DVec3], faces: &[Vec<usize>]) -> String {
    let mut text = String::new();
    for p in points {
        let _ = writeln!(text, "v {:.6} {:.6} {:.6}", p.x, p.y, p.z);
    }
    for face in faces {
        let corners: Vec<String> = face.iter().map(|corner| (corner + 1).to_string()).collect();
        let _ = writeln!(text, "f {}", corners.join(" "));
    }
    text
}

fn torus() -> String {
    let (around, across) = (32, 16);
    let points: Vec<DVec3> = (0..around * across)
        .map(|i| {
            let (u, v) =
                (TAU * (i / across) as f64 / around as f64, TAU * (i % across) as f64 / across as f64);
            let ring = 0.7 + 0.28 * v.cos();
            DVec3::new(ring * u.cos(), 0.28 * v.sin(), ring * u.sin())
        })
        .collect();
    let at = |i: usize, j: usize| (i % around) * across + j % across;
    let faces: Vec<Vec<usize>> = (0..around * across)
        .map(|k| (k / across, k % across))
        .map(|(i, j)| vec![at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)])
        .collect();
    obj(&points, &faces)
}

/// A long octahedron with a flat top.
fn gem() -> String {
    let mut points = vec![DVec3::new(0.0, -0.98, 0.0)];
    let ring = |height: f64, radius: f64| {
        (0..6).map(move |k| {
            let angle = TAU * f64::from(k) / 6.0;
            DVec3::new(radius * angle.cos(), height, radius * angle.sin())
        })
    };
    points.extend(ring(0.3, 0.9));
    points.extend(ring(0.7, 0.5));
    let mut faces: Vec<Vec<usize>> = Vec::new();
    for k in 0..6 {
        let next = (k + 1) % 6;
        faces.push(vec![0, 1 + k, 1 + next]);
        faces.push(vec![1 + k, 7 + k, 7 + next, 1 + next]);
    }
    faces.push((0..6).rev().map(|k| 7 + k).collect());
    obj(&points, &faces)
}

/// A lumpy ball with concave parts.
fn pebble() -> String {
    let (rows, columns) = (16, 32);
    let point = |row: usize, column: usize| {
        let (polar, azimuth) = (PI * row as f64 / rows as f64, TAU * column as f64 / columns as f64);
        let p = DVec3::new(polar.sin() * azimuth.cos(), polar.cos(), polar.sin() * azimuth.sin());
        p * (0.85 + 0.13 * (5.0 * p.x).sin() * (4.0 * p.y + 1.0).cos() * (3.0 * p.z).cos())
    };
    // The two poles, then the rows between them.
    let mut points = vec![point(0, 0), point(rows, 0)];
    points.extend((0..(rows - 1) * columns).map(|i| point(1 + i / columns, i % columns)));
    let at = |row: usize, column: usize| match row {
        0 => 0,
        _ if row == rows => 1,
        _ => 2 + (row - 1) * columns + column % columns,
    };
    let mut faces = Vec::new();
    for row in 0..rows {
        for column in 0..columns {
            let mut face =
                vec![at(row, column), at(row, column + 1), at(row + 1, column + 1), at(row + 1, column)];
            face.dedup();
            faces.push(face);
        }
    }
    obj(&points, &faces)
}

#[cfg(test)]
mod tests {
    use super::*;
    use covbeam_geometry::mesh::{Mesh, Placement};
    use covbeam_geometry::obj;
    use glam::{Quat, Vec3};

    #[test]
    fn meshes_are_closed_wound_outward_and_fit_in_a_unit_ball() {
        for mesh in ALL {
            let source = obj::parse((mesh.text)().as_bytes()).expect("valid");
            let corner = |i: u32| source.positions[i as usize].as_dvec3();
            // Positive where the faces turn outward (divergence theorem).
            let volume: f64 =
                source.indices.iter().map(|&[a, b, c]| corner(a).dot(corner(b).cross(corner(c))) / 6.0).sum();
            assert!(volume > 0.3, "{}: volume {volume}", mesh.file);
            assert!(source.positions.iter().all(|p| p.length() <= 1.0), "{}", mesh.file);
            let placement = Placement { scale: 1.0, rotation: Quat::IDENTITY, translation: Vec3::ZERO };
            let built = Mesh::new(source, &placement, mesh.smooth).expect("valid");
            assert_eq!(built.open_edges(), 0, "{}", mesh.file);
        }
    }
}
