//! Arguments: random ones over many decades, and those at which formulas go wrong.

use crate::random::Stream;
use covbeam::{
    Curvature, Density, DensityGrid, ExponentialDensity, GridLayout, Medium, PhaseFunction, PhaseKind, Vec3,
};
use std::f64::consts::TAU;

use super::words::Words;

/// Random arguments. Powers and angles come from `libm`, not from the machine's library: the same bits everywhere.
pub(super) struct Hard(Stream);

impl Hard {
    pub(super) fn new(seed: u64) -> Self {
        Self(Stream::new(seed))
    }

    pub(super) fn uniform(&mut self) -> f32 {
        // The largest double below 1 rounds to 1.
        (self.0.uniform() as f32).min(1.0 - f32::EPSILON)
    }

    pub(super) fn between(&mut self, low: f64, high: f64) -> f32 {
        self.0.between(low, high) as f32
    }

    pub(super) fn below(&mut self, count: u32) -> u32 {
        self.0.between(0.0, f64::from(count)) as u32
    }

    pub(super) fn chance(&mut self, probability: f64) -> bool {
        self.0.uniform() < probability
    }

    /// Between 10^low and 10^high.
    pub(super) fn decades(&mut self, low: f64, high: f64) -> f32 {
        libm::exp10(self.0.between(low, high)) as f32
    }

    pub(super) fn signed(&mut self, low: f64, high: f64) -> f32 {
        let size = self.decades(low, high);
        if self.chance(0.5) { size } else { -size }
    }

    /// Now and then 0 or infinity.
    pub(super) fn extreme(&mut self, low: f64, high: f64) -> f32 {
        match self.below(8) {
            0 => 0.0,
            1 => f32::INFINITY,
            _ => self.decades(low, high),
        }
    }

    /// Unit; now and then along an axis.
    pub(super) fn unit(&mut self) -> Vec3 {
        if self.chance(0.1) {
            let axis = [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z];
            return axis[self.below(6) as usize];
        }
        let z = self.0.between(-1.0, 1.0);
        let (sine, cosine) = libm::sincos(self.0.between(0.0, TAU));
        let r = libm::sqrt(1.0 - z * z);
        Vec3::new((r * cosine) as f32, (r * sine) as f32, z as f32)
    }

    /// Of any length but 0.
    pub(super) fn direction(&mut self) -> Vec3 {
        let length = if self.chance(0.5) { 1.0 } else { self.decades(-30.0, 30.0) };
        length * self.unit()
    }

    /// A normal of any length, now and then nearly across `direction`.
    pub(super) fn normal(&mut self, direction: Vec3) -> Vec3 {
        let (direction, normal) = (normalized(direction), self.unit());
        if !self.chance(0.25) {
            return normal * self.decades(-3.0, 3.0);
        }
        let grazing = normal - normal.dot(direction) * direction + self.signed(-9.0, -1.0) * direction;
        if grazing.length_squared() > 1e-6 { grazing } else { normal }
    }

    pub(super) fn curvature(&mut self) -> Curvature {
        match self.below(4) {
            0 => Curvature::default(),
            1 => {
                let both = self.signed(-3.0, 3.0);
                Curvature { along: both, across: both, ..Curvature::default() }
            }
            _ => Curvature {
                tangent: self.direction(),
                along: self.signed(-3.0, 3.0),
                across: if self.chance(0.3) { 0.0 } else { self.signed(-3.0, 3.0) },
                twist: if self.chance(0.5) { 0.0 } else { self.signed(-3.0, 1.0) },
            },
        }
    }

    /// In the box from -`size` to `size`.
    pub(super) fn point(&mut self, size: f64) -> Vec3 {
        Vec3::from_array([(); 3].map(|()| self.between(-size, size)))
    }

    pub(super) fn phase(&mut self) -> PhaseFunction {
        let kind = [PhaseKind::Isotropic, PhaseKind::HenyeyGreenstein, PhaseKind::Rayleigh];
        let asymmetry = match self.below(4) {
            0 => self.signed(-6.0, -1.0),
            1 => 1.0 - self.decades(-5.0, -1.0),
            _ => self.between(-0.95, 0.95),
        };
        PhaseFunction { kind: kind[self.below(3) as usize], asymmetry }
    }
}

/// As the ABI normalises a medium's `up`, which may have any length.
fn normalized(vector: Vec3) -> Vec3 {
    (vector / vector.abs().max_element()).normalize()
}

/// A density in voxels.
pub(super) struct Voxels {
    pub(super) layout: GridLayout,
    pub(super) values: Vec<f32>,
}

impl Voxels {
    /// Lumps between empty voxels, the densest `most`.
    pub(super) fn new(hard: &mut Hard, min: Vec3, max: Vec3, cells: [u32; 3], most: f32) -> Self {
        let layout = GridLayout { min, max, cells };
        let values = (0..layout.cell_count())
            .map(|_| if hard.chance(0.3) { 0.0 } else { most * hard.decades(-3.0, 0.0) })
            .collect();
        Self { layout, values }
    }
}

/// A `covbeam_medium`.
#[derive(Clone, Copy)]
pub(super) struct Fog<'a> {
    pub(super) medium: Medium<'static>,
    varies: Varies<'a>,
}

#[derive(Clone, Copy)]
enum Varies<'a> {
    Nowhere,
    /// Origin, up of any length, scale height.
    Height(Vec3, Vec3, f32),
    Voxels(&'a Voxels),
}

impl<'a> Fog<'a> {
    pub(super) fn homogeneous(medium: Medium<'static>) -> Self {
        Self { medium, varies: Varies::Nowhere }
    }

    pub(super) fn exponential(medium: Medium<'static>, origin: Vec3, up: Vec3, scale_height: f32) -> Self {
        Self { medium, varies: Varies::Height(origin, up, scale_height) }
    }

    pub(super) fn voxels(medium: Medium<'static>, voxels: &'a Voxels) -> Self {
        Self { medium, varies: Varies::Voxels(voxels) }
    }

    pub(super) fn is_closed_form(&self) -> bool {
        !matches!(self.varies, Varies::Voxels(_))
    }

    pub(super) fn density(&self) -> Density<'a> {
        match self.varies {
            Varies::Nowhere => Density::Uniform,
            Varies::Height(origin, up, scale_height) => {
                Density::Exponential(ExponentialDensity { origin, up: normalized(up), scale_height })
            }
            Varies::Voxels(Voxels { layout, values }) => {
                Density::Grid(DensityGrid::new(*layout, values).expect("made so"))
            }
        }
    }

    /// As core takes it.
    pub(super) fn view(&self) -> Medium<'a> {
        Medium { density: self.density(), ..self.medium }
    }
}

impl Words for Fog<'_> {
    fn append(&self, line: &mut String) {
        let (kind, origin, up, scale_height): (u32, _, _, _) = match self.varies {
            Varies::Nowhere => (0, Vec3::ZERO, Vec3::ZERO, 0.0),
            Varies::Height(origin, up, scale_height) => (1, origin, up, scale_height),
            Varies::Voxels(_) => (2, Vec3::ZERO, Vec3::ZERO, 0.0),
        };
        let Medium { scattering, absorption, phase, .. } = &self.medium;
        let words: [&dyn Words; 7] = [scattering, absorption, phase, &kind, &origin, &up, &scale_height];
        words.iter().for_each(|word| word.append(line));
    }
}
