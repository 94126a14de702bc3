//! Meshes as they are given.

use crate::work::failure::{Result, invalid};
use covbeam_geometry::MAX_COORDINATE;
use covbeam_geometry::model::Model;
use covbeam_geometry::triangles::{Frame, Triangles, area_vector};
use glam::{DVec3, Vec3};

/// How far the squared length of a unit normal may be from 1.
const UNIT: f32 = 1e-3;

/// The arrays of a mesh.
#[derive(Clone, Copy, Debug)]
pub struct MeshArrays<'a> {
    /// In the mesh's own space.
    pub positions: &'a [[f32; 3]],
    /// Three vertices each, counter-clockwise seen from the front.
    pub triangles: &'a [[i32; 3]],
    /// A number for each triangle, or one for all.
    pub materials: &'a [i32],
    /// Unit, one a corner; None = flat shading.
    pub normals: Option<&'a [[[f32; 3]; 3]]>,
}

/// A mesh whose arrays have been checked, without hierarchy.
#[derive(Debug)]
pub(super) struct Draft {
    frame: Option<Frame>,
    corners: Vec<[Vec3; 3]>,
    normals: Vec<[Vec3; 3]>,
    materials: Vec<u32>,
    bounds: (DVec3, DVec3),
    dropped: usize,
}

impl Draft {
    /// Checks and copies the arrays. Triangles of exactly zero area are dropped.
    pub(super) fn new(arrays: &MeshArrays) -> Result<Self> {
        let MeshArrays { positions, triangles, materials, normals } = *arrays;
        if ![1, triangles.len()].contains(&materials.len()) {
            let (given, wanted) = (materials.len(), triangles.len());
            return Err(invalid!(
                "materials: {given} numbers for {wanted} triangles; give one a triangle, or one"
            ));
        }
        if normals.is_some_and(|normals| normals.len() != triangles.len()) {
            return Err(invalid!(
                "normals: not as many as the {} triangles; give three for each",
                triangles.len()
            ));
        }
        let bounded = |p: &[f32; 3]| p.iter().all(|x| x.abs() <= MAX_COORDINATE);
        if let Some(wrong) = positions.iter().position(|p| !bounded(p)) {
            let position = positions[wrong];
            return Err(invalid!("positions[{wrong}]: {position:?}; give finite coordinates up to 1e9"));
        }
        let known = |corner: &i32| usize::try_from(*corner).is_ok_and(|corner| corner < positions.len());
        if let Some(wrong) = triangles.iter().position(|triangle| !triangle.iter().all(known)) {
            let (corners, count) = (triangles[wrong], positions.len());
            return Err(invalid!(
                "triangles[{wrong}]: {corners:?}; give numbers of vertices, 0 to {count} - 1"
            ));
        }
        let point = |corner: i32| DVec3::from(positions[corner as usize].map(f64::from));
        let used = || triangles.iter().flatten().map(|&corner| point(corner));
        let bounds = (used().fold(DVec3::INFINITY, DVec3::min), used().fold(DVec3::NEG_INFINITY, DVec3::max));
        if triangles.is_empty() || bounds.0 == bounds.1 {
            return Ok(Self::empty(triangles.len()));
        }

        let frame = Frame::around(bounds.0, bounds.1);
        let corners = |triangle: &[i32; 3]| triangle.map(|corner| frame.local(point(corner)));
        let kept: Vec<(usize, [Vec3; 3])> = triangles
            .iter()
            .map(corners)
            .enumerate()
            .filter(|(_, corners)| area_vector(*corners) != DVec3::ZERO)
            .collect();
        if kept.is_empty() {
            return Ok(Self::empty(triangles.len()));
        }
        let normals = normals.map_or(Ok(Vec::new()), |normals| {
            kept.iter().map(|&(index, _)| unit_normals(normals[index], index)).collect()
        })?;
        let materials = match materials {
            [one] => vec![*one as u32],
            all => kept.iter().map(|&(index, _)| all[index] as u32).collect(),
        };
        Ok(Self {
            frame: Some(frame),
            dropped: triangles.len() - kept.len(),
            corners: kept.into_iter().map(|(_, corners)| corners).collect(),
            normals,
            materials,
            bounds,
        })
    }

    fn empty(dropped: usize) -> Self {
        let (corners, normals, materials) = (Vec::new(), Vec::new(), Vec::new());
        let bounds = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        Self { frame: None, corners, normals, materials, bounds, dropped }
    }

    /// Triangles of no area.
    pub(super) fn dropped(&self) -> usize {
        self.dropped
    }

    /// Lower and upper corner; infinite and the wrong way round without triangles.
    pub(super) fn bounds(&self) -> (DVec3, DVec3) {
        self.bounds
    }

    /// Builds the hierarchy.
    pub(super) fn build(self) -> Model {
        let Self { frame, corners, normals, materials, .. } = self;
        Model::new(frame.map(|frame| Triangles::new(frame, &corners, &normals)), materials)
    }
}

fn unit_normals(normals: [[f32; 3]; 3], index: usize) -> Result<[Vec3; 3]> {
    let normals = normals.map(Vec3::from_array);
    for (corner, normal) in normals.iter().enumerate() {
        // Also refuses NaN.
        if !((normal.length_squared() - 1.0).abs() <= UNIT) {
            return Err(invalid!(
                "normals[{index}, {corner}]: {:?}; give vectors of length 1",
                normal.to_array()
            ));
        }
    }
    Ok(normals)
}
