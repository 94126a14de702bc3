//! Small scenes of placed meshes.

use covbeam_geometry::instance::Instance;
use covbeam_geometry::instances::Instances;
use covbeam_geometry::model::Model;
use covbeam_geometry::triangles::{Frame, Triangles};
use covbeam_render::scene_file;
use covbeam_session::medium::fogs::{AddedFogs, FogSum, FogVolume};
use covbeam_session::scene::{Lobes, Material, Placed, PlacedObject, Scene};
use glam::{DMat4, DVec3, Vec3};
use std::f64::consts::{PI, TAU};
use std::path::Path;
use std::sync::Arc;

/// Triangles, counter-clockwise from the front, and their normals if they are smooth.
#[derive(Clone, Debug)]
pub(crate) struct Mesh {
    pub(crate) corners: Vec<[DVec3; 3]>,
    pub(crate) normals: Vec<[Vec3; 3]>,
}

/// Counter-clockwise from outside.
pub(crate) fn cube(min: Vec3, max: Vec3) -> Mesh {
    let ends = [min.as_dvec3(), max.as_dvec3()];
    let corner = |i: usize| DVec3::new(ends[i & 1].x, ends[i >> 1 & 1].y, ends[i >> 2].z);
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let corners = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]].map(|t| t.map(corner)));
    Mesh { corners: corners.collect(), normals: Vec::new() }
}

/// Around the origin, or elsewhere.
pub(crate) fn block(half: f32, center: Vec3) -> Mesh {
    cube(center - half, center + half)
}

/// A smooth sphere of 2 rows² quads, as large as a ball of this radius.
pub(crate) fn ball(radius: f64, center: Vec3, rows: u32) -> Mesh {
    let point = |row: u32, column: u32| {
        let ring = if row == 0 || row == rows { 0.0 } else { (PI * f64::from(row) / f64::from(rows)).sin() };
        let azimuth = TAU * f64::from(column % (2 * rows)) / f64::from(2 * rows);
        DVec3::new(ring * azimuth.cos(), ring * azimuth.sin(), (PI * f64::from(row) / f64::from(rows)).cos())
    };
    let mut points = Vec::new();
    for (row, column) in (0..rows).flat_map(|row| (0..2 * rows).map(move |column| (row, column))) {
        let [a, b] = [point(row, column), point(row + 1, column)];
        let [c, d] = [point(row + 1, column + 1), point(row, column + 1)];
        points.extend((row + 1 < rows).then_some([a, b, c]));
        points.extend((row > 0).then_some([a, c, d]));
    }
    let volume: f64 = points.iter().map(|[a, b, c]| a.dot(b.cross(*c)) / 6.0).sum();
    let scale = radius * (4.0 / 3.0 * PI / volume).cbrt();
    let corners = points.iter().map(|corners| corners.map(|p| scale * p + center.as_dvec3())).collect();
    Mesh { corners, normals: points.iter().map(|corners| corners.map(|p| p.as_vec3())).collect() }
}

/// An open sheet, seen from above in the front.
pub(crate) fn sheet(corner: Vec3, edge_u: Vec3, edge_v: Vec3) -> Mesh {
    let [a, b, c, d] =
        [corner, corner + edge_u, corner + edge_u + edge_v, corner + edge_v].map(|p| p.as_dvec3());
    Mesh { corners: vec![[a, b, c], [a, c, d]], normals: Vec::new() }
}

/// With its triangles turned round.
pub(crate) fn inverted(mut mesh: Mesh) -> Mesh {
    mesh.corners.iter_mut().for_each(|corners| corners.swap(1, 2));
    mesh.normals.iter_mut().for_each(|normals| {
        normals.swap(1, 2);
        normals.iter_mut().for_each(|normal| *normal = -*normal);
    });
    mesh
}

/// A mesh in a scene.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    pub(crate) mesh: Mesh,
    pub(crate) material: Material,
    pub(crate) fog: Option<u8>,
    pub(crate) is_closed: bool,
    pub(crate) transform: DMat4,
}

/// Of a material, without fog.
pub(crate) fn part(mesh: Mesh, material: Material) -> Part {
    Part { mesh, material, fog: None, is_closed: true, transform: DMat4::IDENTITY }
}

/// The bound of a volume of fog.
pub(crate) fn bound(mesh: Mesh, fog: u8) -> Part {
    Part { fog: Some(fog), ..part(mesh, Material::Clear) }
}

pub(crate) fn lobes(index: f32) -> Lobes {
    Lobes { index, multiscatter: true, ..Lobes::NONE }
}

pub(crate) fn glass() -> Material {
    Material::of_lobes(Lobes { glass_reflection: Vec3::ONE, glass_transmission: Vec3::ONE, ..lobes(1.5) })
}

/// How far bounds of fog are drawn in, in shares of the scene's largest coordinate: of two faces in one plane a ray would cross one only.
const INSET: f64 = 1.0 / (1 << 18) as f64;

/// A volume of fog in a box.
pub(crate) fn volume(medium: u32, min: Vec3, max: Vec3) -> FogVolume {
    FogVolume { medium, min, max }
}

pub(crate) fn placed(parts: &[Part], volumes: Vec<FogVolume>, sums: &[FogSum]) -> Placed {
    let reach = parts.iter().flat_map(|part| part.mesh.corners.iter().flatten());
    let reach = reach.map(|p| p.abs().max_element()).fold(0.0, f64::max);
    let (mut models, mut instances) = (Vec::new(), Vec::new());
    for (number, part) in parts.iter().enumerate() {
        let mut corners = part.mesh.corners.clone();
        let points = || corners.iter().flatten().copied();
        let (min, max) = (points().reduce(DVec3::min).unwrap(), points().reduce(DVec3::max).unwrap());
        if part.material.is_clear() {
            let hair = (1 + number % 8) as f64 * INSET * reach;
            let half = 0.5 * (max - min);
            let scale = DVec3::ONE - DVec3::splat(hair).min(0.1 * half) / half.max(DVec3::splat(1e-30));
            let middle = 0.5 * (min + max);
            corners.iter_mut().flatten().for_each(|p| *p = middle + scale * (*p - middle));
        }
        let frame = Frame::around(min, max);
        let local: Vec<[Vec3; 3]> = corners.iter().map(|corners| corners.map(|p| frame.local(p))).collect();
        let flat = |[a, b, c]: &[Vec3; 3]| (*b - *a).cross(*c - *a) == Vec3::ZERO;
        let kept: Vec<[Vec3; 3]> = local.iter().filter(|corners| !flat(corners)).copied().collect();
        let triangles = (!kept.is_empty()).then(|| Triangles::new(frame, &kept, &part.mesh.normals));
        models.push(Model::new(triangles, vec![number as u32]));
        let matrix = part.transform.transpose().to_cols_array();
        instances.push(Instance::new(number, &matrix, (min, max), number as u32, None).expect("affine"));
    }
    let materials = parts.iter().map(|part| part.material).collect();
    let objects = parts
        .iter()
        .map(|part| PlacedObject { fog: part.fog, is_closed: part.is_closed, ..PlacedObject::default() })
        .collect();
    let fogs = AddedFogs::new(volumes, sums).expect("few volumes");
    Placed::new(Arc::new(Instances::new(models, instances)), materials, objects, fogs)
        .expect("numbers that mean something")
}

/// What a scene file says of camera, lights and media, and what is placed.
pub(crate) fn scene(text: &str, parts: &[Part], volumes: Vec<FogVolume>) -> Scene {
    const REST: &str = "[grid]\nmin = [-2, -2, -2]\nmax = [2, 2, 2]\ncells = [12, 12, 12]\n[render]\nradius = 0.03\nmax_radius = 0.03\n\
        photons = 2000\n";
    let text = if text.contains("[grid]") { text.to_owned() } else { format!("{text}{REST}") };
    let mut scene = scene_file::parse(&text, "placed", Path::new("")).expect("a valid scene");
    scene.placed = (!parts.is_empty()).then(|| placed(parts, volumes, &[]));
    scene
}

pub(crate) fn camera(position: [f32; 3], look_at: [f32; 3], fov: f32, size: u32) -> String {
    format!(
        "[camera]\nposition = {position:?}\nlook_at = {look_at:?}\nvertical_fov = {fov}\nwidth = {size}\nheight = {size}\n"
    )
}

pub(crate) fn medium(name: &str, scattering: f32, absorption: f32) -> String {
    format!("[[medium]]\nname = \"{name}\"\nscattering = {scattering}\nabsorption = {absorption}\n")
}

pub(crate) fn lamp(position: [f32; 3], intensity: f32) -> String {
    format!("[[light]]\nkind = \"point\"\nposition = {position:?}\nintensity = {intensity}\n")
}
