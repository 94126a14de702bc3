//! Media, and where they are.

use super::fields::{BRIGHTEST, Fields};
use crate::camera::Camera;
use crate::medium::density::{densest_corner, too_dense};
use crate::medium::fogs::{AddedFogs, FogSum, FogVolume};
use crate::medium::glow::Glow;
use crate::medium::volume::{MAX_DENSITY, MAX_VOXELS, Volume as Voxels};
use crate::scene::{Light as RenderLight, MediumDensity, MediumId, SceneMedium};
use crate::work::failure::{Result, invalid};
use covbeam::{ExponentialDensity, GridLayout, Medium, PhaseFunction, PhaseKind, PhaseShare};
use covbeam_geometry::MAX_COORDINATE;
use glam::{DVec3, Vec3};
use std::sync::Arc;

/// A medium and where it is. See Volume in the extension's `host/scene.py`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VolumeFields {
    /// Coefficient where the relative density is 1 \[1/m\].
    pub scattering: [f64; 3],
    /// The same.
    pub absorption: [f64; 3],
    /// Lower corner of what it fills \[m\]; the world's is not read.
    pub min: [f64; 3],
    /// Upper corner.
    pub max: [f64; 3],
    /// Mean cosine of Henyey-Greenstein, in (-1, 1).
    pub asymmetry: f64,
    /// Lower corner of the voxels of the density \[m\]; these three are not read without.
    pub density_min: [f64; 3],
    /// Upper corner.
    pub density_max: [f64; 3],
    /// Lower corner of the voxels of what it sends out \[m\]; these three are not read without.
    pub glow_min: [f64; 3],
    /// Upper corner.
    pub glow_max: [f64; 3],
    /// Voxels of the density along x, y and z.
    pub cells: [u32; 3],
    /// Voxels of what it sends out.
    pub glow_cells: [u32; 3],
    /// 0 = isotropic, 1 = Henyey-Greenstein, 2 = Rayleigh.
    pub phase: u32,
    /// Height in which the density of the world's volume falls to 1/e \[m\]; 0: it does not, and the next two are not read.
    pub scale_height: f64,
    /// Where it is 1 \[m\].
    pub origin: [f64; 3],
    /// Where it falls to, unit.
    pub up: [f64; 3],
    /// Rays that do not see it, by the bits of [`Rays`](crate::scene::visibility::Rays): of the camera, and to lamps, whose straight light is not dimmed
    /// in it then, and scattered all the same.
    pub hidden_from: u32,
    /// Which set it is in, for lamps that light some only: below 64.
    pub light_set: u32,
    /// And for those that some only dim.
    pub shadow_set: u32,
}

/// A phase function of a mixture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LobeFields {
    /// As of [`VolumeFields`].
    pub phase: u32,
    /// As of [`VolumeFields`].
    pub asymmetry: f64,
    /// How much of what is scattered it spreads, per channel, 0 to 1.
    pub share: [f64; 3],
}

/// The same with its arrays.
#[derive(Clone, Debug, Default)]
pub struct Volume<'a> {
    /// All that is a number.
    pub fields: VolumeFields,
    /// Density, one number a voxel; None = 1 everywhere.
    pub densities: Option<&'a [f32]>,
    /// Emission coefficient, one colour a voxel [W/(m³ sr)]; None = it is dark.
    pub glow: Option<&'a [[f32; 3]]>,
    /// Numbers of the volumes that this is the sum of, where all of them and no others are.
    pub parts: &'a [i32],
    /// Phase functions beside its own, of which it is a mixture.
    pub lobes: Vec<LobeFields>,
}

impl Volume<'_> {
    /// Corners, as given.
    pub(super) fn bounds(&self) -> (DVec3, DVec3) {
        (DVec3::from(self.fields.min), DVec3::from(self.fields.max))
    }

    /// Mean extinction of the channels, as given \[1/m\].
    pub(super) fn extinction(&self) -> f64 {
        let VolumeFields { scattering, absorption, .. } = self.fields;
        scattering.iter().chain(&absorption).sum::<f64>() / 3.0
    }

    fn medium(&self, index: usize) -> Result<SceneMedium> {
        let fields = Fields::of("volumes", index);
        let coefficient = |name, value| fields.color(name, value, f64::from(MAX_COORDINATE));
        let medium = Medium {
            scattering: coefficient("scattering", self.fields.scattering)?,
            absorption: coefficient("absorption", self.fields.absorption)?,
            phase: phase(&fields, self.fields.phase, self.fields.asymmetry)?,
            ..Medium::default()
        };
        let density = match self.densities {
            None if self.thins() => MediumDensity::Exponential(self.exponential(&fields)?),
            None => MediumDensity::Uniform,
            Some(_) if self.thins() => {
                return Err(fields.wrong(
                    "scale_height",
                    self.fields.scale_height,
                    "0 with voxels of a density",
                ));
            }
            Some(densities) => MediumDensity::Grid(self.voxels(&fields, densities)?),
        };
        let glow = self.glow.map(|glow| self.glow(&fields, glow)).transpose()?.flatten().map(Arc::new);
        let VolumeFields { hidden_from, light_set, shadow_set, .. } = self.fields;
        let heed = fields.heed(hidden_from, light_set, shadow_set)?;
        Ok(SceneMedium { medium, more: self.more(&fields)?, density, glow, heed })
    }

    /// Its phase functions beside the first.
    fn more(&self, fields: &Fields) -> Result<Vec<PhaseShare>> {
        let more = |lobe: &LobeFields| {
            let phase = phase(fields, lobe.phase, lobe.asymmetry)?;
            Ok(PhaseShare { phase, share: fields.color("lobes[].share", lobe.share, 1.0)? })
        };
        let more = self.lobes.iter().map(more).collect::<Result<Vec<_>>>()?;
        // A share may be off by the rounding of a sum.
        let total: Vec3 = more.iter().map(|more| more.share).sum();
        if total.max_element() > 1.0 + 1e-4 {
            return Err(fields.wrong("lobes[].share", total, "shares that sum to no more than 1"));
        }
        Ok(more)
    }

    /// Whether its density falls with height.
    pub(super) fn thins(&self) -> bool {
        self.fields.scale_height != 0.0
    }

    fn exponential(&self, fields: &Fields) -> Result<ExponentialDensity> {
        let VolumeFields { origin, up, scale_height, .. } = self.fields;
        Ok(ExponentialDensity {
            origin: fields.point("origin", origin)?.as_vec3(),
            up: fields.direction("up", up)?.as_vec3().normalize(),
            scale_height: fields.length("scale_height", scale_height)?,
        })
    }

    /// None: it is dark.
    fn glow(&self, fields: &Fields, glow: &[[f32; 3]]) -> Result<Option<Glow>> {
        let VolumeFields { glow_cells, glow_min, glow_max, .. } = self.fields;
        let layout = layout(fields, "glow", glow_cells, [glow_min, glow_max])?;
        let is_emission = |value: &f32| (0.0..=BRIGHTEST as f32).contains(value);
        if let Some(wrong) = glow.iter().position(|emission| !emission.iter().all(is_emission)) {
            let wanted = format_args!("numbers from 0 to {BRIGHTEST:e}");
            return Err(fields.wrong(&format!("glow.values[{wrong}]"), glow[wrong], wanted));
        }
        let made = Glow::new(layout, glow.iter().map(|&emission| Vec3::from(emission)).collect());
        match made.as_ref().map(Glow::flux).filter(|flux| !flux.is_finite()) {
            Some(flux) => {
                let wanted = "a glow whose power single precision holds";
                Err(fields.wrong("glow.values", flux.to_array(), wanted))
            }
            None => Ok(made),
        }
    }

    fn voxels(&self, fields: &Fields, densities: &[f32]) -> Result<Voxels> {
        let VolumeFields { cells, density_min, density_max, .. } = self.fields;
        let layout = layout(fields, "density", cells, [density_min, density_max])?;
        let most = f64::from(MAX_DENSITY) / self.extinction().max(1.0);
        let is_density = |density: &f32| (0.0..=most).contains(&f64::from(*density));
        if let Some(wrong) = densities.iter().position(|density| !is_density(density)) {
            let name = format!("density.values[{wrong}]");
            let wanted = "numbers from 0 to 1e9, and products with the coefficients up to 1e9";
            return Err(fields.wrong(&name, densities[wrong], wanted));
        }
        Ok(Voxels { layout, values: densities.to_vec() })
    }
}

/// That of voxels between two corners; `name`: of the field that has them.
fn layout(fields: &Fields, name: &str, cells: [u32; 3], [min, max]: [[f64; 3]; 2]) -> Result<GridLayout> {
    let count = cells.iter().map(|&count| u128::from(count)).product::<u128>();
    if !(1..=u128::from(MAX_VOXELS)).contains(&count) {
        let wanted = format_args!("1 to {MAX_VOXELS} voxels in all");
        return Err(fields.wrong(&format!("{name}.cells"), cells, wanted));
    }
    let field = |corner| format!("{name}.{corner}");
    let (low, high) = (fields.point(&field("min"), min)?, fields.point(&field("max"), max)?);
    let voxel = (high - low) / glam::UVec3::from(cells).as_dvec3();
    if !(voxel.min_element() >= f64::from(1.0 / MAX_COORDINATE)) {
        return Err(fields.wrong(&field("max"), max, "a box whose voxels are at least 1e-9 m wide"));
    }
    Ok(GridLayout { min: low.as_vec3(), max: high.as_vec3(), cells })
}

/// Refuses fog that thins with height where it is not the world's.
fn check_thinning(volumes: &[Volume], outside: Option<MediumId>) -> Result<()> {
    let elsewhere =
        |(index, volume): &(usize, &Volume)| volume.thins() && Some(*index as MediumId) != outside;
    let Some((index, volume)) = volumes.iter().enumerate().find(elsewhere) else { return Ok(()) };
    let given = volume.fields.scale_height;
    Err(Fields::of("volumes", index).wrong("scale_height", given, "0 to all but the world's"))
}

/// The media of a scene.
pub(super) struct Media {
    /// By volume.
    pub(super) all: Vec<SceneMedium>,
    /// That of the world.
    pub(super) outside: Option<MediumId>,
    /// Which fills a place.
    pub(super) fogs: AddedFogs,
    /// Those that are sums.
    pub(super) sums: Vec<MediumId>,
    /// By volume: its number among those that fill objects.
    places: Vec<Option<u8>>,
}

impl Media {
    /// - `in_shapes`: numbers of the volumes that fill shapes.
    pub(super) fn new(volumes: &[Volume], world: i32, in_shapes: &[i32]) -> Result<Self> {
        let all = volumes.iter().enumerate().map(|(index, volume)| volume.medium(index));
        let all = all.collect::<Result<Vec<_>>>()?;
        let outside = match world {
            -1 => None,
            _ => {
                let number = usize::try_from(world).ok().filter(|number| *number < volumes.len());
                let count = volumes.len();
                Some(number.ok_or_else(|| {
                    invalid!("world_volume: {world}; give -1, or the number of one of the {count} volumes")
                })? as MediumId)
            }
        };
        if let Some(index) = outside.filter(|&id| all[id as usize].glow.is_some()) {
            let wanted = "None: what the world's volume sends out has no end";
            return Err(Fields::of("volumes", index as usize).wrong("glow", "voxels", wanted));
        }
        check_thinning(volumes, outside)?;
        let (mut places, mut bodies, mut sums) = (Vec::new(), Vec::new(), Vec::new());
        for (index, volume) in volumes.iter().enumerate() {
            let medium = index as MediumId;
            let fills_shapes = in_shapes.contains(&(index as i32));
            let is_body = Some(medium) != outside && volume.parts.is_empty() && !fills_shapes;
            places.push(is_body.then_some(bodies.len()));
            if is_body {
                let fields = Fields::of("volumes", index);
                let corner = |name, value| fields.point(name, value).map(|corner| corner.as_vec3());
                let [min, max] = [corner("min", volume.fields.min)?, corner("max", volume.fields.max)?];
                if !(min.cmple(max).all()) {
                    return Err(fields.wrong(
                        "max",
                        volume.fields.max,
                        "an upper corner above the lower one",
                    ));
                }
                bodies.push(FogVolume { medium, min, max });
            }
        }
        for (index, volume) in volumes.iter().enumerate().filter(|(_, volume)| !volume.parts.is_empty()) {
            let place = |&part: &i32| {
                let place = usize::try_from(part).ok().and_then(|part| *places.get(part)?);
                place.ok_or_else(|| {
                    let wanted =
                        "numbers of volumes that are neither the world's nor sums, and fill no shape";
                    Fields::of("volumes", index).wrong("parts", volume.parts, wanted)
                })
            };
            let parts = volume.parts.iter().map(place).collect::<Result<_>>()?;
            sums.push(FogSum { parts, medium: index as MediumId });
        }
        let fogs = AddedFogs::new(bodies, &sums).map_err(|error| invalid!("volumes: {error}"))?;
        let sums = sums.into_iter().map(|sum| sum.medium).collect();
        // At most 64.
        let places = places.into_iter().map(|place| place.map(|place| place as u8)).collect();
        Ok(Self { all, outside, fogs, sums, places })
    }

    /// The number among what fills objects of a volume; None: it is none of these.
    pub(super) fn place_of(&self, volume: i32) -> Option<u8> {
        usize::try_from(volume).ok().and_then(|volume| *self.places.get(volume)?)
    }

    /// Refuses a density that single precision cannot hold where the scene is.
    pub(super) fn check_height(
        &self,
        bounds: Option<(DVec3, DVec3)>,
        lights: &[RenderLight],
        camera: &Camera,
    ) -> Result<()> {
        let Some(index) = self.outside else { return Ok(()) };
        let SceneMedium { medium, density: MediumDensity::Exponential(density), .. } =
            &self.all[index as usize]
        else {
            return Ok(());
        };
        let near = lights.iter().filter(|light| !light.is_far()).map(RenderLight::position);
        let below = bounds.map(|(min, max)| densest_corner(density, (min.as_vec3(), max.as_vec3())));
        let points = near.chain(below).chain(camera.corners()).chain([camera.position]);
        let Some((place, logarithm)) = too_dense(medium, density, points) else { return Ok(()) };
        let wanted = format_args!(
            "more, or lower origin: at {place} the density is e^{logarithm:.1}, and 1e9 at most"
        );
        Err(Fields::of("volumes", index as usize).wrong("scale_height", density.scale_height, wanted))
    }

    /// Per channel, 1 where light from infinitely far away gets through what is outside of all objects, else 0. Where that thins with height it gets
    /// as far as it is followed.
    pub(super) fn far_light(&self) -> Vec3 {
        let Some(outside) = self.outside else { return Vec3::ONE };
        let SceneMedium { medium, density, .. } = &self.all[outside as usize];
        if matches!(density, MediumDensity::Exponential(_)) {
            return Vec3::ONE;
        }
        let extinction = medium.scattering + medium.absorption;
        Vec3::from(extinction.to_array().map(|extinction| if extinction == 0.0 { 1.0 } else { 0.0 }))
    }
}

/// A phase function by its number.
fn phase(fields: &Fields, kind: u32, asymmetry: f64) -> Result<PhaseFunction> {
    let kind = match kind {
        0 => PhaseKind::Isotropic,
        1 => PhaseKind::HenyeyGreenstein,
        2 => PhaseKind::Rayleigh,
        other => return Err(fields.wrong("phase", other, "0, 1 or 2")),
    };
    let most = f64::from(1.0_f32.next_down());
    Ok(PhaseFunction { kind, asymmetry: fields.number("asymmetry", asymmetry, -most..=most)? })
}
