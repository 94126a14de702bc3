//! A scene's media as light meets them: how far it flies, and what is left of it.

use crate::scene::{MediumDensity, Scene, SceneMedium};
use covbeam::{Column, Density, DensityGrid, Knot, Medium};
use glam::Vec3;

/// The media of a scene, by their index.
pub fn all(scene: &Scene) -> Vec<Medium<'_>> {
    scene.media.iter().map(of).collect()
}

fn of(SceneMedium { medium, density }: &SceneMedium) -> Medium<'_> {
    let density = match density {
        MediumDensity::Uniform => Density::Uniform,
        MediumDensity::Exponential(exponential) => Density::Exponential(*exponential),
        MediumDensity::Grid(volume) => Density::Grid(
            DensityGrid::new(volume.layout, &volume.values).expect("the scene's volume was validated"),
        ),
    };
    Medium { density, ..*medium }
}

/// The column along a ray, to 5e-4 in the optical depth of the channel that is attenuated most; `knots` is the table's
/// memory, used by density grids only.
///
/// The table ends where light of every channel is down to 4e-8.
pub fn column<'k>(
    medium: &Medium,
    origin: Vec3,
    direction: Vec3,
    length: f32,
    knots: &'k mut Vec<Knot>,
) -> Column<'k> {
    knots.clear();
    medium.tabulate(origin, direction, length, &mut |knot| knots.push(knot));
    medium.density.column(origin, direction, knots)
}

/// Per channel, what is left of light between two points.
pub fn transmittance(medium: &Medium, from: Vec3, to: Vec3) -> Vec3 {
    let offset = to - from;
    let distance = offset.length();
    if !(distance > 0.0) {
        return Vec3::ONE;
    }
    let mut knots = Vec::new();
    let column = column(medium, from, offset / distance, distance, &mut knots);
    medium.transmittance(column.at(distance))
}

/// Distance beyond which nothing is left of light that starts at `origin`; `column` is the one along this ray.
pub fn opaque_distance(medium: &Medium, origin: Vec3, direction: Vec3, column: &Column) -> f32 {
    let knots = if let Column::Knots(knots) = *column { knots } else { &[] };
    medium.density.opaque_distance(origin, direction, medium.opaque_column(), knots)
}
