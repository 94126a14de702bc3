//! Reads the `[[medium]]` tables of a scene file: coefficients, phase functions, densities.

use covbeam::{Density, ExponentialDensity, Medium, PhaseFunction, PhaseKind};
use covbeam_geometry::MAX_COORDINATE;
use glam::Vec3;

use super::shape::read_corners;
use crate::scene_file::fields::{Field, SceneError, Table};
use crate::scene_file::files::SceneFiles;
use covbeam_session::camera::Camera;
use covbeam_session::medium::density::{densest_corner, largest_extinction, too_dense};
use covbeam_session::medium::volume::{MAX_DENSITY, Volume};
use covbeam_session::scene::{Heed, Light, MediumDensity, MediumId, Object, SceneMedium};

/// Most voxels of all volumes of a scene: 256 MiB of densities.
const MAX_SCENE_VOXELS: usize = 1 << 26;

/// The media and their names, in the order of the file; what they send out is read once the objects are known.
pub(crate) fn read_media<'a>(
    root: &Table<'a>,
    files: &SceneFiles<'_>,
) -> Result<(Vec<SceneMedium>, Vec<&'a str>), SceneError> {
    let (mut media, mut names) = (Vec::new(), Vec::new());
    let mut voxels = 0;
    for table in root.tables("medium")? {
        table.only(&["name", "scattering", "absorption", "phase", "density", "emission"])?;
        let name = table.required("name")?;
        let text = name.text("a name in quotes")?;
        if names.contains(&text) {
            return Err(name.refuse("a name that no other medium has"));
        }
        let coefficient = |key| {
            let coefficient = |value: f32| (0.0..=MAX_COORDINATE).contains(&value);
            table.required(key)?.color("a coefficient in 0..=1e9, per unit of length", coefficient)
        };
        let medium = Medium {
            scattering: coefficient("scattering")?,
            absorption: coefficient("absorption")?,
            phase: table
                .optional("phase")
                .map_or(Ok(PhaseFunction::ISOTROPIC), |field| read_phase(&field))?,
            more: &[],
            density: Density::Uniform,
        };
        let density = table
            .optional("density")
            .map_or(Ok(MediumDensity::Uniform), |field| read_density(&field, &medium, &mut voxels, files))?;
        media.push(SceneMedium { medium, more: Vec::new(), density, glow: None, heed: Heed::default() });
        names.push(text);
    }
    Ok((media, names))
}

/// `voxels`: those of the scene's volumes so far.
fn read_density(
    field: &Field<'_>,
    medium: &Medium,
    voxels: &mut usize,
    files: &SceneFiles<'_>,
) -> Result<MediumDensity, SceneError> {
    let expected = "{ exponential = { origin, up, scale_height } } or { volume = { file, min, max } }; without \
                    this field the density is 1 everywhere";
    match field.choice(expected)? {
        ("exponential", Some(fields)) => {
            let table = fields.table()?;
            table.only(&["origin", "up", "scale_height"])?;
            Ok(MediumDensity::Exponential(ExponentialDensity {
                origin: table.optional("origin").map_or(Ok(Vec3::ZERO), |field| field.vector())?,
                up: table.optional("up").map_or(Ok(Vec3::Y), |field| field.direction())?,
                scale_height: table.required("scale_height")?.size()?,
            }))
        }
        ("volume", Some(fields)) => {
            let table = fields.table()?;
            table.only(&["file", "min", "max"])?;
            let file = table.required("file")?;
            let path = files.path(&file, "a .vol file")?;
            let given = table.optional("min").is_some() || table.optional("max").is_some();
            let corners = given.then(|| read_corners(&table)).transpose()?;
            let volume = Volume::load(&path, corners)
                .map_err(|source| file.refuse_volume(path.display().to_string(), source))?;
            *voxels += volume.values.len();
            if *voxels > MAX_SCENE_VOXELS {
                return Err(file
                    .refuse(format!("volumes of at most {MAX_SCENE_VOXELS} voxels in all media together")));
            }
            let (most, largest) = (largest_extinction(medium), f64::from(volume.largest()));
            if most * largest > f64::from(MAX_DENSITY) {
                return Err(file.refuse(format!(
                    "density x (scattering + absorption) of at most 1e9, but the largest density {largest:e} times \
                     {most:e} is above: scale the densities or the coefficients down"
                )));
            }
            Ok(MediumDensity::Grid(volume))
        }
        _ => Err(field.refuse(expected)),
    }
}

/// An exponential density grows below its origin without end: it must be moderate where the scene is, which is the
/// grid's box (without one, the objects), the camera and the lights.
pub(crate) fn check_exponential(
    root: &Table<'_>,
    media: &[SceneMedium],
    outside: Option<MediumId>,
    grid: Option<(Vec3, Vec3)>,
    objects: &[Object],
    camera: &Camera,
    lights: &[Light],
) -> Result<(), SceneError> {
    let Some(id) = outside else { return Ok(()) };
    let SceneMedium { medium, density: MediumDensity::Exponential(exponential), .. } = &media[id as usize]
    else {
        return Ok(());
    };
    let below = |corners| densest_corner(exponential, corners);
    let boxes = match grid {
        Some(corners) => vec![corners],
        None => objects.iter().map(|object| object.shape.bounds()).collect(),
    };
    let points =
        lights.iter().map(Light::position).chain(boxes.into_iter().map(below)).chain(camera.corners());
    if let Some((lowest, logarithm)) = too_dense(medium, exponential, points.chain([camera.position])) {
        let table = &root.tables("medium")?[id as usize];
        return Err(table.required("density")?.refuse(format!(
            "a density, and a density x (scattering + absorption), of at most 1e9 in the grid, at the camera and \
             at the lights, but at {lowest} the density is e^{logarithm:.1}: raise scale_height, or lower origin"
        )));
    }
    Ok(())
}

fn read_phase(field: &Field<'_>) -> Result<PhaseFunction, SceneError> {
    let expected = "\"isotropic\", \"rayleigh\" or { henyey_greenstein = g }";
    match field.choice(expected)? {
        ("isotropic", None) => Ok(PhaseFunction::ISOTROPIC),
        ("rayleigh", None) => Ok(PhaseFunction { kind: PhaseKind::Rayleigh, asymmetry: 0.0 }),
        ("henyey_greenstein", Some(g)) => {
            // 1 - |g| is squared and divided by.
            let asymmetry = g.number("a mean cosine in -0.999..=0.999", |g| g.abs() <= 0.999)?;
            Ok(PhaseFunction { kind: PhaseKind::HenyeyGreenstein, asymmetry })
        }
        _ => Err(field.refuse(expected)),
    }
}

/// The medium that a field names.
pub(crate) fn read_medium_name(field: &Field<'_>, names: &[&str]) -> Result<MediumId, SceneError> {
    let name = field.text("the name of a [[medium]] in quotes")?;
    match names.iter().position(|known| *known == name) {
        Some(index) => Ok(index as MediumId),
        None if names.is_empty() => Err(field.refuse("the name of a [[medium]], but there is none")),
        None => Err(field.refuse(format!("one of the media {}", names.join(", ")))),
    }
}
