//! What a scene is: objects, lights, media, camera and the defaults of a render.

pub mod bounces;
mod coincident;
pub(crate) mod geometry;
#[cfg(test)]
pub(crate) mod made;
pub mod media;
mod nesting;
pub mod optics;
pub(crate) mod passage;
pub mod visibility;

use crate::camera::Camera;
use crate::host::Host;
pub use crate::light::kinds::Light;
pub use crate::light::shown::Shown;
pub use crate::light::{Area, Ball, Cone, GlowingFog, Lamp, Pattern, ShiningMesh, Sky, Sun};
pub use crate::material::{Lobes, Material};
pub use crate::medium::density::MediumDensity;
pub use crate::medium::{MediumId, SceneMedium};
pub use crate::object::Object;
pub use crate::object::placed::{Placed, PlacedObject};
use crate::scene::bounces::{Bounce, BounceLimits, Counted};
pub use crate::scene::visibility::{Heed, Links, Rays};
use covbeam_geometry::hit::Hit;
pub use covbeam_geometry::shape::Shape;
use glam::Vec3;
pub use nesting::nest;
use std::borrow::Cow;
use std::f32::consts::PI;

/// Most pixels along one side of the picture.
pub const MAX_IMAGE_SIDE: u32 = 16384;
/// Most light paths a pass.
pub const MAX_PHOTONS: u32 = 1 << 28;

/// Radiance that is typical of a picture, over that of the brightest lamp in it, at least.
const LEAST_OF_LAMPS: f32 = 1.0 / 16384.0;

/// And over what it is without that, at most.
const MOST_RAISED: f32 = 4096.0;

/// A whole scene, validated: nothing in it is NaN, infinite, degenerate or out of range.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Shapes with their materials.
    pub objects: Vec<Object>,
    /// Meshes placed by transforms; their objects are counted after those.
    pub placed: Option<Placed>,
    /// At least one.
    pub lights: Vec<Light>,
    /// Those that are seen.
    pub shown: Shown,
    /// By light; what lights behind the last of them shine on is everything.
    pub links: Vec<Links>,
    /// Scattering media.
    pub media: Vec<SceneMedium>,
    /// The medium outside all closed dielectric objects and all placed ones that are filled; None = vacuum.
    pub outside: Option<MediumId>,
    /// Where the picture is taken from.
    pub camera: Camera,
    /// Box of the covariance grid and its resolution.
    pub grid: covbeam::GridLayout,
    /// Defaults of a render.
    pub settings: Settings,
    /// What its pictures show.
    pub sees: Sees,
    /// What of its files was not taken as it is, for a person to read: numbers of a sky that were replaced.
    pub notes: Vec<String>,
}

/// What pictures show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sees {
    /// All light.
    #[default]
    Everything,
    /// The light that fog scatters into the camera: surfaces are black, and hide or mirror the fog that is behind them.
    FogAlone,
}

impl Scene {
    /// What was hit, as it is described.
    pub fn material(&self, hit: &Hit) -> &Material {
        match (self.objects.get(hit.object as usize), &self.placed) {
            (Some(object), _) => &object.material,
            (None, Some(placed)) => placed.material(hit),
            (None, None) => unreachable!("hits bear numbers of objects"),
        }
    }

    /// What was hit, as it is at that very place: textures of a host.
    #[inline]
    pub(crate) fn material_at(&self, hit: &Hit) -> Cow<'_, Material> {
        match self.placed_hit(hit) {
            Some((placed, object)) => placed.material_at(hit, object),
            None => Cow::Borrowed(self.material(hit)),
        }
    }

    /// The host that keeps the geometry, if one does.
    pub(crate) fn host(&self) -> Option<&Host> {
        self.placed.as_ref()?.host()
    }

    /// Materials of all that is there.
    pub fn materials(&self) -> impl Iterator<Item = &Material> {
        let placed = self.placed.iter().flat_map(Placed::materials);
        self.objects.iter().map(|object| &object.material).chain(placed)
    }

    /// What was hit, counted among the placed objects; None: it is one of the others.
    pub(crate) fn placed_hit(&self, hit: &Hit) -> Option<(&Placed, u32)> {
        let object = hit.object.checked_sub(self.objects.len() as u32)?;
        Some((self.placed.as_ref()?, object))
    }

    /// On what a light falls.
    #[inline]
    pub(crate) fn links_of(&self, light: usize) -> Links {
        self.links.get(light).copied().unwrap_or_default()
    }

    /// Whether a light falls on what was hit, where rays of a kind leave that.
    #[inline]
    pub(crate) fn falls_on(&self, light: usize, hit: &Hit, ray: Rays) -> bool {
        let links = self.links_of(light);
        links == Links::default()
            || links.lights(self.object_of(hit).heed.light_set) && !links.hidden.has(ray)
    }

    /// The placed object that was hit, or one of which nothing is told.
    #[inline]
    pub(crate) fn object_of(&self, hit: &Hit) -> PlacedObject {
        self.placed_hit(hit)
            .map_or_else(PlacedObject::default, |(placed, object)| placed.objects()[object as usize])
    }

    /// Whether all rays see everything alike, and lamps light and are shadowed by everything.
    pub(crate) fn is_plain(&self) -> bool {
        let is_plain = |material: &Material| material.shadow() == material.transparent();
        self.links.iter().all(|links| *links == Links::default())
            && self.placed.as_ref().is_none_or(Placed::is_plain)
            && self.media.iter().all(|medium| medium.heed == Heed::default())
            && self.materials().all(is_plain)
    }

    /// Whether rays of a kind do not see a medium.
    #[inline]
    pub(crate) fn is_hidden(&self, region: u32, ray: Rays) -> bool {
        self.medium_of(region).heed.hidden.has(ray)
    }

    /// Whether light may be scattered and reflected so often.
    pub(crate) fn allows(&self, bounces: u32) -> bool {
        self.settings.bounces.is_none_or(|most| bounces <= most)
    }

    /// Whether light that has bounced so often may still be sent to the camera by an event of a kind.
    #[inline]
    pub(crate) fn may_be_seen(&self, counted: &Counted, by: Bounce) -> bool {
        self.settings.limits.is_none_or(|limits| counted.may_be_seen(&limits, by))
    }

    /// Whether surfaces are seen, and lamps through rough glass.
    pub(crate) fn shows_surfaces(&self) -> bool {
        self.sees == Sees::Everything
    }

    /// Whether an eye ray sees anything of, in or through a surface.
    pub(crate) fn shows(&self, material: &Material) -> bool {
        match material {
            Material::Black => false,
            Material::Lambert { .. } => self.shows_surfaces(),
            Material::Lobes(lobes) => self.shows_surfaces() || lobes.shows_through(),
            Material::Mirror { .. } | Material::Dielectric { .. } | Material::Clear => true,
        }
    }

    /// How many lists beams of a medium are kept in: 2 where fog goes on inside of glass that is placed, and else 1.
    fn sides(&self) -> u32 {
        self.placed.as_ref().map_or(1, Placed::sides)
    }

    /// How many lists there are of beams: those of media outside and inside of placed glass are kept apart.
    pub fn region_count(&self) -> usize {
        self.media.len() * self.sides() as usize
    }

    /// The region of a medium outside or inside of glass.
    pub(crate) fn region(&self, medium: MediumId, in_glass: bool) -> u32 {
        self.sides() * medium + u32::from(in_glass)
    }

    /// Whether a region is inside of placed glass.
    pub fn is_in_glass(&self, region: u32) -> bool {
        self.sides() == 2 && region % 2 == 1
    }

    /// The medium of a region.
    pub fn medium_of(&self, region: u32) -> &SceneMedium {
        &self.media[(region / self.sides()) as usize]
    }

    /// Whether any light may be scattered, or is sent out by media: a scene without is black, and nothing can be traced in it.
    pub fn lights_fog(&self) -> bool {
        let scatters = |medium: &SceneMedium| medium.medium.scattering != Vec3::ZERO;
        self.lights.iter().any(|light| light.flux() != Vec3::ZERO)
            && (self.media.iter().any(scatters) || self.glows())
    }

    /// Whether there is any light in its pictures: without, nothing can be traced in it, and they are black.
    pub fn is_lit(&self) -> bool {
        match self.sees {
            Sees::Everything => self.lights.iter().any(|light| light.flux() != Vec3::ZERO),
            Sees::FogAlone => self.lights_fog(),
        }
    }

    /// Whether any medium sends out light.
    pub(crate) fn glows(&self) -> bool {
        self.media.iter().any(|medium| medium.glow.is_some())
    }

    /// Radiance of the picture to within a few powers of ten [W/(m² sr)]: that of light scattered once, if all of the lights' power
    /// crossed a sphere as large as the distance from the camera to the scene, and that of what glows; where brighter lamps are seen 2⁻¹⁴ of the
    /// brightest, so that sums over 2¹⁷ passes hold that, but no more than 2¹² times what it is without: dark fog would be rounded to nothing.
    pub fn typical_radiance(&self) -> f32 {
        let middle = 0.5 * (self.grid.min + self.grid.max);
        let size = 0.5 * (self.grid.max - self.grid.min).length();
        let distance = size.max((self.camera.position - middle).length());
        let intensity = |(number, light): (usize, &Light)| {
            light.flux().max_element() * self.links_of(number).falloff.typical() / (4.0 * PI)
        };
        let intensity: f32 = self.lights.iter().enumerate().map(intensity).sum();
        let scattering = self.media.iter().map(|medium| medium.medium.scattering.max_element());
        let scattered = (scattering.fold(0.0, f32::max) * distance).clamp(1e-3, 1.0);
        let glow = self.media.iter().filter_map(|medium| medium.glow.as_ref());
        let glow: f32 = glow.map(|glow| glow.largest() * glow.radius()).sum();
        let without = scattered * intensity / (distance * distance) + glow;
        without.max((LEAST_OF_LAMPS * self.shown.brightest()).min(MOST_RAISED * without))
    }
}

/// Defaults of a render; the command line overrides them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Passes.
    pub passes: u32,
    /// Light paths a pass, of those that go where their power goes.
    pub photons: u32,
    /// Light paths a pass, of those that go where the picture needs them: what the default method has.
    pub guided_photons: u32,
    /// Seed.
    pub seed: u32,
    /// Kernels of the passes, of beams and (their smallest radius) of surface photons [scene unit].
    pub schedule: covbeam::Schedule,
    /// Share of the photons that carry a light field, in (0, 1].
    pub light_field_share: f32,
    /// Largest number of scatterings and reflections of light before the one that sends it to the camera, None for any. What goes straight on
    /// does not count, nor does what an eye path meets.
    pub bounces: Option<u32>,
    /// Limits by kind beside that; None: there are none.
    pub limits: Option<BounceLimits>,
}

impl Settings {
    /// Light paths a pass.
    pub fn light_paths(&self, guided: bool) -> u32 {
        if guided { self.guided_photons } else { self.photons }
    }
}
