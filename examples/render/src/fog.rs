//! A scene's media as light meets them: how far it flies, what is left of it, and what its spectrum gains on the way.

use crate::scene::{MediumDensity, Scene, SceneMedium};
use covbeam::{Attenuation, Column, Density, DensityGrid, Knot, LightField, Medium};
use glam::Vec3;

/// One medium of a scene.
#[derive(Clone, Copy, Debug)]
pub struct Fog<'a> {
    /// Coefficients at density 1, and the phase function.
    pub medium: &'a Medium,
    /// How much of it there is where.
    pub density: Density<'a>,
}

impl<'a> Fog<'a> {
    /// The media of a scene, by their index.
    pub fn all(scene: &'a Scene) -> Vec<Self> {
        scene.media.iter().map(Self::new).collect()
    }

    fn new(SceneMedium { medium, density }: &'a SceneMedium) -> Self {
        let density = match density {
            MediumDensity::Uniform => Density::Uniform,
            MediumDensity::Exponential(exponential) => Density::Exponential(*exponential),
            MediumDensity::Grid(volume) => Density::Grid(
                DensityGrid::new(volume.layout, &volume.values).expect("the scene's volume was validated"),
            ),
        };
        Self { medium, density }
    }

    /// The column along a ray, to 5e-4 in the optical depth of the channel that is attenuated most; `knots` is the table's
    /// memory, used by density grids only.
    ///
    /// The table ends where light of every channel is down to 4e-8.
    pub fn column<'k>(
        &self,
        origin: Vec3,
        direction: Vec3,
        length: f32,
        knots: &'k mut Vec<Knot>,
    ) -> Column<'k> {
        knots.clear();
        self.density.tabulate(self.medium, origin, direction, length, &mut |knot| knots.push(knot));
        self.density.column(origin, direction, knots)
    }

    /// Per channel, what is left of light between two points.
    pub fn transmittance(&self, from: Vec3, to: Vec3) -> Vec3 {
        let offset = to - from;
        let distance = offset.length();
        if !(distance > 0.0) {
            return Vec3::ONE;
        }
        let mut knots = Vec::new();
        let column = self.column(from, offset / distance, distance, &mut knots);
        self.medium.transmittance(column.at(distance))
    }

    /// Distance beyond which nothing is left of light that starts at `origin`; `column` is the one along this ray.
    pub fn reach(&self, origin: Vec3, direction: Vec3, column: &Column) -> f32 {
        let knots = if let Column::Knots(knots) = *column { knots } else { &[] };
        self.density.reach(origin, direction, self.medium.opaque_column(), knots)
    }

    /// Mean extinction of the channels at density 1.
    pub fn mean_extinction(&self) -> f32 {
        self.medium.extinction().element_sum() / 3.0
    }

    /// What attenuates the mean of the channels along the ray of `column`.
    pub fn attenuation<'k>(&'k self, column: Column<'k>) -> Attenuation<'k> {
        Attenuation { extinction: self.mean_extinction(), density: self.density, column }
    }

    /// Moves a light field along its ray, attenuating its spectrum on the way.
    pub fn carry(&self, field: &mut LightField, origin: Vec3, distance: f32) {
        self.density.carry(field, origin, distance, self.mean_extinction());
    }
}
