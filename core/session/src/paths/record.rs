//! What light paths leave behind: beams, photons on surfaces, segments of light fields, connections, and a balance.

use crate::kind::Kind;
use crate::surface::SurfacePhoton;
use covbeam::{Beam, Column, Edges, LightField, Segment};
use glam::Vec3;
use std::time::Duration;

/// A segment of a light path that carries a light field.
#[derive(Clone, Copy, Debug)]
pub struct FieldSegment {
    /// Its start.
    pub origin: Vec3,
    /// Up to the next surface, or until nothing is left of the light.
    pub length: f32,
    /// The light field at `origin`.
    pub field: LightField,
    /// Flux at `origin` (mean of the channels).
    pub power: f32,
    /// Whether it has met neither medium nor diffuse surfaces since its light.
    pub unscattered: bool,
    /// What it has met.
    pub kind: Kind,
    /// The edges beside it.
    pub edges: Edges,
}

impl FieldSegment {
    /// The same with the column along it.
    pub fn with<'a>(&'a self, column: Column<'a>) -> Segment<'a> {
        let Self { origin, length, field, power, unscattered, ref edges, .. } = *self;
        Segment { origin, length, power, unscattered, field, edges, column }
    }
}

/// A beam of a light path.
#[derive(Clone, Copy, Debug)]
pub struct PathBeam {
    /// Index of its medium.
    pub medium: u32,
    /// What its light has met.
    pub kind: Kind,
    /// How much of its start lies next to the lamp \[m\], where no shadow rays look for straight light; >= 0.
    pub near: f32,
    /// The beam.
    pub beam: Beam,
}

/// A contribution of a path vertex to one pixel.
#[derive(Clone, Copy, Debug)]
pub struct Splat {
    /// Row-major index.
    pub pixel: u32,
    /// Radiance.
    pub radiance: Vec3,
}

/// Where the power of some light paths went, per channel \[W\]; `emitted` = the sum of the others.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// Left the lights.
    pub emitted: [f64; 3],
    /// Absorbed by media.
    pub medium: [f64; 3],
    /// Absorbed by surfaces.
    pub surfaces: [f64; 3],
    /// Left the scene.
    pub escaped: [f64; 3],
    /// Had as many bounces as the scene's settings allow, and was to have another.
    pub spent: [f64; 3],
    /// Taken minus given back by random decisions: zero on average.
    pub roulette: [f64; 3],
}

/// Adds a power to a sum over light paths.
pub(crate) fn add(sum: &mut [f64; 3], power: Vec3) {
    for (sum, power) in sum.iter_mut().zip(power.to_array()) {
        *sum += f64::from(power);
    }
}

/// A power times a factor; what it loses is added to a sum over light paths.
#[inline]
pub(super) fn scaled(power: Vec3, factor: Vec3, lost: &mut [f64; 3]) -> Vec3 {
    let after = power * factor;
    add(lost, power - after);
    after
}

/// What light paths leave behind.
#[derive(Clone, Debug, Default)]
pub struct PhotonRecord {
    /// Beams.
    pub beams: Vec<PathBeam>,
    /// Photons on diffuse surfaces, without those that came straight from a light.
    pub surface: Vec<SurfacePhoton>,
    /// What light fields leave in the covariance grid, with the index of their medium.
    pub deposits: Vec<(u32, FieldSegment)>,
    /// Connections with the camera.
    pub splats: Vec<Splat>,
    /// Balance.
    pub energy: Energy,
    /// Time spent on light fields and probes.
    pub field_time: Duration,
}

impl PhotonRecord {
    /// Appends another record.
    pub fn append(&mut self, mut other: Self) {
        self.beams.append(&mut other.beams);
        self.surface.append(&mut other.surface);
        self.deposits.append(&mut other.deposits);
        self.splats.append(&mut other.splats);
        let pairs = [
            (&mut self.energy.emitted, other.energy.emitted),
            (&mut self.energy.medium, other.energy.medium),
            (&mut self.energy.surfaces, other.energy.surfaces),
            (&mut self.energy.escaped, other.energy.escaped),
            (&mut self.energy.spent, other.energy.spent),
            (&mut self.energy.roulette, other.energy.roulette),
        ];
        for (sum, add) in pairs {
            for (sum, add) in sum.iter_mut().zip(add) {
                *sum += add;
            }
        }
        self.field_time += other.field_time;
    }
}

/// What to record of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Record {
    /// Beams and surface photons.
    Beams,
    /// The same, and the light field's deposits.
    BeamsAndField,
    /// Deposits only: the path's beams were recorded before.
    Field,
    /// Deposits of the light that comes straight from the lights alone.
    Direct,
    /// Connections with the camera.
    Connections,
}

impl Record {
    /// Whether beams and surface photons are recorded.
    #[inline]
    pub(super) fn has_beams(self) -> bool {
        matches!(self, Self::Beams | Self::BeamsAndField)
    }
}
