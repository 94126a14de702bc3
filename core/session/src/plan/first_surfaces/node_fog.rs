//! The first fog at a node of the lattice, and the spectrum of its light.

use super::look::Looks;
use crate::camera::Camera;
use crate::eye::sight::FirstFog;
use crate::plan::bend::{Bend, bend};
use crate::scene::{MediumId, media};
use covbeam::{EyeRay, FluenceGrid, ImageSpectrum, Knot, Medium, PixelStep};

/// The first piece of fog of a node of the lattice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct NodeFog {
    ray: EyeRay,
    steps: [PixelStep; 2],
    medium: MediumId,
    /// Of how much of it the pixels around see.
    bend: Bend,
}

impl NodeFog {
    /// The fog at a node of the lattice, if a spectrum can be known there.
    pub(super) fn at(looks: &Looks, [x, y]: [u32; 2], regions: &[u32]) -> Option<Self> {
        let fog = looks.at(x, y).fog.filter(|fog| fog.is_alone)?;
        let steps = looks.camera.pixel_steps(x as f32 + 0.5, y as f32 + 0.5);
        let steps = steps.map(|step| PixelStep {
            origin: step.origin + fog.from * step.direction,
            direction: step.direction,
        });
        Some(Self {
            ray: ray(looks, x, y, &fog),
            steps,
            medium: fog.medium,
            bend: bend_at(looks, [x, y], regions),
        })
    }
}

/// The spectrum of a node's fog.
pub(super) fn spectrum(
    node: &Option<NodeFog>,
    grid: &FluenceGrid,
    fogs: &[Medium],
    knots: &mut Vec<Knot>,
) -> ImageSpectrum {
    let Some(NodeFog { ray, steps, medium, bend }) = node else { return ImageSpectrum::default() };
    let fog = &fogs[*medium as usize];
    let column = media::column(fog, ray.origin, ray.direction, ray.length, knots);
    let mut spectrum = ImageSpectrum::along(ray, steps, grid, fog, &column);
    if spectrum.weight > 0.0 {
        spectrum.xx += bend.xx;
        spectrum.xy += bend.xy;
        spectrum.yy += bend.yy;
    }
    spectrum
}

/// The spectrum of the mean of several lights.
pub(super) fn mean(spectra: impl ExactSizeIterator<Item = ImageSpectrum>) -> ImageSpectrum {
    let count = spectra.len() as f32;
    let sum = spectra.fold(ImageSpectrum::default(), |sum, one| ImageSpectrum {
        xx: sum.xx + one.weight * one.xx,
        xy: sum.xy + one.weight * one.xy,
        yy: sum.yy + one.weight * one.yy,
        weight: sum.weight + one.weight,
    });
    if sum.weight > 0.0 {
        let ImageSpectrum { xx, xy, yy, weight } = sum;
        ImageSpectrum { xx: xx / weight, xy: xy / weight, yy: yy / weight, weight: weight / count }
    } else {
        ImageSpectrum::default()
    }
}

/// Of how much fog is seen around a pixel; 0 beside other regions, and at the picture's border.
fn bend_at(looks: &Looks, [x, y]: [u32; 2], regions: &[u32]) -> Bend {
    let Camera { width, height, .. } = *looks.camera;
    if x == 0 || y == 0 || x + 1 == width || y + 1 == height {
        return Bend::default();
    }
    let region = |x: u32, y: u32| regions[(y * width + x) as usize];
    let is_inside = region(x, y) != 0
        && (y - 1..=y + 1).all(|row| (x - 1..=x + 1).all(|column| region(column, row) == region(x, y)));
    let seen = |x: u32, y: u32| fog_seen(looks, x, y);
    if !is_inside || !(seen(x, y) > 0.0) {
        return Bend::default();
    }
    bend([y - 1, y, y + 1].map(|row| [x - 1, x, x + 1].map(|column| seen(column, row))))
}

/// Share of the light on the way through the first fog that this takes.
fn fog_seen(looks: &Looks, x: u32, y: u32) -> f32 {
    let Some(first) = looks.at(x, y).fog else { return 0.0 };
    let (ray, fog) = (ray(looks, x, y, &first), &looks.fogs[first.medium as usize]);
    let mut knots = Vec::new();
    let column = media::column(fog, ray.origin, ray.direction, ray.length, &mut knots);
    let column = column.at(ray.length);
    let taken = |extinction: f32| if extinction > 0.0 { -libm::expm1f(-extinction * column) } else { 0.0 };
    fog.extinction().to_array().map(taken).iter().sum::<f32>() / 3.0
}

/// The piece of a pixel's eye ray in its first fog.
fn ray(looks: &Looks, x: u32, y: u32, fog: &FirstFog) -> EyeRay {
    let (origin, direction) = looks.camera.ray(x as f32 + 0.5, y as f32 + 0.5, [0.0; 2]);
    EyeRay { origin: origin + fog.from * direction, direction, length: fog.to - fog.from }
}
