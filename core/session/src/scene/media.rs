//! A scene's media as light meets them: how far it flies, and what is left of it.

use crate::scene::{MediumDensity, Scene, SceneMedium};
use covbeam::{Column, Density, DensityGrid, Knot, Medium};
use glam::Vec3;

/// The media of a scene's regions, by the regions' number.
pub fn all(scene: &Scene) -> Vec<Medium<'_>> {
    (0..scene.region_count()).map(|region| of(scene.medium_of(region as u32))).collect()
}

fn of(SceneMedium { medium, more, density, .. }: &SceneMedium) -> Medium<'_> {
    let density = match density {
        MediumDensity::Uniform => Density::Uniform,
        MediumDensity::Exponential(exponential) => Density::Exponential(*exponential),
        MediumDensity::Grid(volume) => Density::Grid(
            DensityGrid::new(volume.layout, &volume.values).expect("the scene's volume was validated"),
        ),
    };
    Medium { more, density, ..*medium }
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
    let column = medium.density.column_over(from, offset / distance, distance, medium.opaque_column());
    medium.transmittance(column)
}

/// Distance beyond which nothing is left to see of light that starts at `origin`, in any channel that the medium scatters: what it does not
/// scatter shows nothing, however far it gets; `column` is the one along this ray.
pub fn opaque_distance(medium: &Medium, origin: Vec3, direction: Vec3, column: &Column) -> f32 {
    let knots = if let Column::Knots(knots) = *column { knots } else { &[] };
    let shows = medium.scattering.cmpgt(Vec3::ZERO);
    // A channel that ends at once ends no other one early.
    let hidden = if shows.any() { Vec3::select(shows, Vec3::ZERO, Vec3::MAX) } else { Vec3::ZERO };
    let shown = Medium { absorption: medium.absorption + hidden, ..*medium };
    medium.density.opaque_distance(origin, direction, shown.opaque_column(), knots)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_is_followed_as_far_as_any_channel_shows() {
        let of = |scattering: Vec3, absorption: Vec3| {
            let medium = Medium { scattering, absorption, ..Medium::default() };
            opaque_distance(&medium, Vec3::ZERO, Vec3::X, &Column::Uniform)
        };
        let (blue, thin) = (Vec3::new(0.0, 0.0, 0.25), Vec3::new(0.5, 0.25, 1.0));
        // e^-17 is left: of the thinnest channel, or of the only one that scatters.
        assert_eq!(of(thin, Vec3::ZERO), 17.0 / 0.25);
        assert_eq!(of(blue, Vec3::ZERO), 17.0 / 0.25);
        assert_eq!(of(blue, Vec3::new(0.01, 0.0, 0.75)), 17.0);
        assert_eq!(of(Vec3::ZERO, thin), 17.0 / 0.25);
        assert_eq!(of(Vec3::ZERO, Vec3::ZERO), f32::INFINITY);
    }
}
