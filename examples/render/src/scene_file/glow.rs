//! Reads what the `[[medium]]` tables of a scene file say of the light that media send out.

use covbeam_geometry::MAX_COORDINATE;
use std::sync::Arc;

use crate::scene_file::fields::{SceneError, Table};
use covbeam_geometry::shape::unite;
use covbeam_session::medium::glow::Glow;
use covbeam_session::scene::{MediumDensity, MediumId, Object, SceneMedium};

/// Gives the media of a file, in its order, what they send out: all over the objects that they fill, or as dense as their voxels are.
pub(crate) fn read_glows(
    root: &Table<'_>,
    media: &mut [SceneMedium],
    objects: &[Object],
    outside: Option<MediumId>,
) -> Result<(), SceneError> {
    for ((table, medium), number) in root.tables("medium")?.iter().zip(media).zip(0..) {
        let Some(field) = table.optional("emission") else { continue };
        let expected = "an emission in 0..=1e9, per cubic unit of length and steradian";
        let emission = field.color(expected, |value| (0.0..=MAX_COORDINATE).contains(&value))?;
        let glow = match &medium.density {
            MediumDensity::Grid(volume) => {
                Glow::new(volume.layout, volume.values.iter().map(|&density| density * emission).collect())
            }
            MediumDensity::Uniform if outside != Some(number) => {
                let filled = objects.iter().filter(|object| object.inside == Some(number));
                let bounds = filled.map(|object| object.shape.bounds()).reduce(unite);
                bounds.and_then(|(min, max)| Glow::even(min, max, emission))
            }
            MediumDensity::Uniform | MediumDensity::Exponential(_) => {
                return Err(field.refuse(
                    "no emission of a medium without end, whose light would have none either: put the medium inside an object, or \
                     give it a `density` of a volume",
                ));
            }
        };
        if glow.as_ref().is_some_and(|glow| !glow.flux().is_finite()) {
            return Err(field.refuse("an emission whose power, all of it together, is below 1e38"));
        }
        medium.glow = glow.map(Arc::new);
    }
    Ok(())
}
