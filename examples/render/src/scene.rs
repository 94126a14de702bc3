//! What a scene is: objects, lights, media, camera and the defaults of a render.

use crate::camera::Camera;
pub use crate::light::Sun;
pub use crate::material::{Lobes, Material};
use crate::volume::Volume;
use covbeam::{ExponentialDensity, Medium};
use covbeam_geometry::mesh::Mesh;
use glam::Vec3;
use std::f32::consts::PI;

/// Index into [`Scene::media`].
pub type MediumId = u32;

/// A whole scene, validated: nothing in it is NaN, infinite, degenerate or out of range.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Shapes with their materials.
    pub objects: Vec<Object>,
    /// At least one.
    pub lights: Vec<Light>,
    /// Scattering media.
    pub media: Vec<SceneMedium>,
    /// The medium outside all closed dielectric objects; None = vacuum.
    pub outside: Option<MediumId>,
    /// Where the picture is taken from.
    pub camera: Camera,
    /// Box of the covariance grid and its resolution.
    pub grid: covbeam::GridLayout,
    /// Defaults of a render.
    pub settings: Settings,
}

impl Scene {
    /// Radiance of the picture to within a few powers of ten [W/(m² sr)]: that of light scattered once, if all of the lights' power
    /// crossed a sphere as large as the distance from the camera to the scene.
    pub fn typical_radiance(&self) -> f32 {
        let middle = 0.5 * (self.grid.min + self.grid.max);
        let size = 0.5 * (self.grid.max - self.grid.min).length();
        let distance = size.max((self.camera.position - middle).length());
        let intensity: f32 = self.lights.iter().map(|light| light.flux().max_element() / (4.0 * PI)).sum();
        let scattering = self.media.iter().map(|medium| medium.medium.scattering.max_element());
        let scattered = (scattering.fold(0.0, f32::max) * distance).clamp(1e-3, 1.0);
        scattered * intensity / (distance * distance)
    }
}

/// A medium and where there is how much of it.
#[derive(Clone, Debug)]
pub struct SceneMedium {
    /// Coefficients at density 1, and the phase function.
    pub medium: Medium<'static>,
    /// Relative density.
    pub density: MediumDensity,
}

/// How the relative density of a medium varies.
#[derive(Clone, Debug)]
pub enum MediumDensity {
    /// 1 everywhere.
    Uniform,
    /// Falls exponentially with height.
    Exponential(ExponentialDensity),
    /// Given by voxels; nothing outside their box.
    Grid(Volume),
}

/// A shape with what it is made of.
#[derive(Clone, Debug)]
pub struct Object {
    /// For messages.
    pub name: String,
    /// Geometry.
    pub shape: Shape,
    /// What light does there.
    pub material: Material,
    /// The medium inside a closed dielectric; None = clear.
    pub inside: Option<MediumId>,
}

/// Geometry of an object.
#[derive(Clone, Debug)]
#[allow(
    clippy::large_enum_variant,
    reason = "a scene holds few shapes, and a mesh's triangles are on the heap"
)]
pub enum Shape {
    /// Normal points outwards.
    Sphere {
        /// Centre.
        center: Vec3,
        /// > 0.
        radius: f32,
    },
    /// The parallelogram `corner + a edge_u + b edge_v`, a, b in [0, 1]; normal along edge_u x edge_v.
    Rectangle {
        /// One corner.
        corner: Vec3,
        /// First edge.
        edge_u: Vec3,
        /// Second edge.
        edge_v: Vec3,
    },
    /// Axis-aligned box; normal points outwards. Hit from inside and from outside.
    Box {
        /// Lower corner.
        min: Vec3,
        /// Upper corner.
        max: Vec3,
    },
    /// Triangles.
    Mesh(Mesh),
}

/// A light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// Isotropic point light.
    Point {
        /// Where.
        position: Vec3,
        /// W/sr per channel.
        intensity: Vec3,
    },
    /// Cone; intensity falls smoothly (smoothstep in the angle) from `inner_angle` to 0 at `outer_angle`.
    Spot {
        /// Where.
        position: Vec3,
        /// Axis, unit.
        direction: Vec3,
        /// W/sr per channel on the axis.
        intensity: Vec3,
        /// Half-angle of the full cone [rad], >= 0.
        inner_angle: f32,
        /// Half-angle where light ends [rad], > inner_angle, < π/2.
        outer_angle: f32,
    },
    /// One-sided diffuse disk emitting towards `normal`.
    Disk {
        /// Centre.
        center: Vec3,
        /// Unit.
        normal: Vec3,
        /// > 0.
        radius: f32,
        /// W/(m² sr) per channel.
        radiance: Vec3,
    },
    /// One-sided diffuse parallelogram `corner + a edge_u + b edge_v`, a, b in [0, 1], emitting towards edge_u x edge_v.
    Rectangle {
        /// One corner.
        corner: Vec3,
        /// First edge.
        edge_u: Vec3,
        /// Second edge.
        edge_v: Vec3,
        /// W/(m² sr) per channel.
        radiance: Vec3,
    },
    /// Diffuse sphere, emitting outwards. Light of other lamps passes through it.
    Sphere {
        /// Centre.
        center: Vec3,
        /// > 0.
        radius: f32,
        /// W/(m² sr) per channel.
        radiance: Vec3,
    },
    /// A disk infinitely far away.
    Sun(Sun),
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
}

impl Settings {
    /// Light paths a pass.
    pub fn light_paths(&self, guided: bool) -> u32 {
        if guided { self.guided_photons } else { self.photons }
    }
}
