//! Scenes of unit tests, made in a few words.

use crate::camera::{Camera, Frame, Projection};
use crate::light::shown::Shown;
use crate::medium::SceneMedium;
use crate::medium::density::MediumDensity;
use crate::object::Object;
use crate::pilot::defaults::{Given, NO_GRID};
use crate::scene::visibility::Heed;
use crate::scene::{GlowingFog, Light, Material, Scene, Sees, Sky, Sun, nest};
use covbeam::{Medium, PhaseFunction};
use covbeam_geometry::shape::Shape;
use glam::{DVec3, Mat3, Vec3};

/// A pinhole camera, upright, with a vertical field of view \[degrees\].
pub(crate) fn camera(position: [f32; 3], look_at: [f32; 3], fov: f32, [width, height]: [u32; 2]) -> Camera {
    let position = Vec3::from(position);
    let forward = (Vec3::from(look_at).as_dvec3() - position.as_dvec3()).normalize();
    let right = forward.cross(DVec3::Y).normalize();
    Camera {
        position,
        forward: forward.as_vec3().normalize(),
        right: right.as_vec3().normalize(),
        up: right.cross(forward).as_vec3().normalize(),
        projection: Projection::Perspective,
        frame: Frame::Middle { half_height: libm::tan((0.5 * f64::from(fov)).to_radians()) as f32 },
        width,
        height,
        near: 0.0,
        lens: None,
        is_own: false,
    }
}

/// The same with parallel rays, so much of the scene from bottom to top.
pub(crate) fn parallel(position: [f32; 3], look_at: [f32; 3], size: f32, pixels: [u32; 2]) -> Camera {
    let frame = Frame::Middle { half_height: 0.5 * size };
    Camera { projection: Projection::Orthographic, frame, ..camera(position, look_at, 40.0, pixels) }
}

pub(crate) fn sphere(center: [f32; 3], radius: f32) -> Shape {
    Shape::Sphere { center: center.into(), radius }
}

pub(crate) fn cuboid(min: [f32; 3], max: [f32; 3]) -> Shape {
    Shape::Box { min: min.into(), max: max.into() }
}

pub(crate) fn rectangle(corner: [f32; 3], edge_u: [f32; 3], edge_v: [f32; 3]) -> Shape {
    Shape::Rectangle { corner: corner.into(), edge_u: edge_u.into(), edge_v: edge_v.into() }
}

pub(crate) fn lambert(albedo: f32) -> Material {
    Material::Lambert { albedo: Vec3::splat(albedo) }
}

/// What bounds fog and bends nothing.
pub(crate) const BOUND: Material = Material::Dielectric { index: 1.0 };

/// Grey.
pub(crate) fn point(position: [f32; 3], intensity: f32) -> Light {
    Light::Point { position: position.into(), intensity: Vec3::splat(intensity) }
}

/// Grey; half-angles in degrees.
pub(crate) fn spot(position: [f32; 3], look_at: [f32; 3], intensity: f32, angles: [f32; 2]) -> Light {
    let position = Vec3::from(position);
    let direction = (Vec3::from(look_at).as_dvec3() - position.as_dvec3()).normalize().as_vec3().normalize();
    let [inner_angle, outer_angle] = angles.map(f32::to_radians);
    Light::Spot { position, direction, intensity: Vec3::splat(intensity), inner_angle, outer_angle }
}

/// Grey, of any density.
pub(crate) fn medium(
    scattering: f32,
    absorption: f32,
    phase: PhaseFunction,
    density: MediumDensity,
) -> SceneMedium {
    SceneMedium {
        medium: Medium { phase, ..Medium::homogeneous(scattering, absorption) },
        more: Vec::new(),
        density,
        glow: None,
        heed: Heed::default(),
    }
}

/// A scene in the making. Media and objects come before suns and skies, which shine on them.
pub(crate) struct Made {
    scene: Scene,
}

impl Made {
    pub(crate) fn new(camera: Camera) -> Self {
        let settings = Given::default().settings;
        let (placed, outside, sees) = (None, None, Sees::Everything);
        let (objects, lights, media, notes) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let shown = Shown::default();
        let (grid, links) = (NO_GRID, Vec::new());
        Self {
            scene: Scene {
                objects,
                placed,
                lights,
                shown,
                links,
                media,
                outside,
                camera,
                grid,
                settings,
                sees,
                notes,
            },
        }
    }

    pub(crate) fn medium(mut self, medium: SceneMedium) -> Self {
        self.scene.media.push(medium);
        self
    }

    /// Grey fog that scatters evenly.
    pub(crate) fn fog(self, scattering: f32, absorption: f32) -> Self {
        self.medium(medium(scattering, absorption, PhaseFunction::ISOTROPIC, MediumDensity::Uniform))
    }

    /// Where nothing else is, the first medium is.
    pub(crate) fn in_fog(self) -> Self {
        self.outside(0)
    }

    /// The same, of the medium of a number.
    pub(crate) fn outside(mut self, medium: u32) -> Self {
        self.scene.outside = Some(medium);
        self
    }

    pub(crate) fn object(self, shape: Shape, material: Material) -> Self {
        self.holding(shape, material, None)
    }

    /// An object that holds the medium of a number.
    pub(crate) fn filled(self, shape: Shape, material: Material, medium: u32) -> Self {
        self.holding(shape, material, Some(medium))
    }

    fn holding(mut self, shape: Shape, material: Material, inside: Option<u32>) -> Self {
        let name = format!("object[{}]", self.scene.objects.len());
        self.scene.objects.push(Object { name, shape, material, inside, priority: 0, inner: Vec::new() });
        nest(&mut self.scene.objects);
        self
    }

    pub(crate) fn light(mut self, light: Light) -> Self {
        self.scene.lights.push(light);
        self
    }

    /// `angle`: across all of it \[degrees\].
    pub(crate) fn sun(self, direction: [f32; 3], angle: f32, irradiance: Vec3) -> Self {
        let direction = Vec3::from(direction).as_dvec3().normalize().as_vec3().normalize();
        let Scene { objects, media, outside, .. } = &self.scene;
        let sun =
            Sun::new((direction, (0.5 * angle).to_radians(), irradiance), objects, None, media, *outside);
        self.light(Light::Sun(sun.expect("something that the sun shines on")))
    }

    /// As bright all around.
    pub(crate) fn sky(self, radiance: f32) -> Self {
        let Scene { objects, media, outside, .. } = &self.scene;
        let upright = Mat3::from_cols(Vec3::X, Vec3::Z, Vec3::NEG_Y);
        let sky = Sky::new((vec![Vec3::splat(radiance)], 1, upright), objects, media, *outside);
        self.light(Light::Sky(sky.expect("something that the sky shines on")))
    }

    /// What has a surface is seen, but for suns.
    pub(crate) fn scene(mut self) -> Scene {
        let Scene { lights, media, shown, .. } = &mut self.scene;
        *shown = Shown::new(lights, |number| {
            let light = &lights[number];
            light.brightest().is_some() && !matches!(light, Light::Sun(_))
        });
        lights.extend(GlowingFog::all(media).map(Light::Glow));
        self.scene.complete(&Given::default());
        self.scene
    }
}
