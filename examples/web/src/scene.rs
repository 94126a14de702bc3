//! What is seen: a spot lamp, the ball, fog without end, a camera.

use crate::ball::Ball;
use covbeam::{EVEN_LAMP, EyeRay, LightField, Medium, Vec3};
use libm::{cosf, expf, sinf};
use std::f32::consts::{PI, TAU};

/// Where the camera stands; it looks along +z, +y is up and +x on the right.
pub(crate) const EYE: Vec3 = Vec3::new(0.0, 0.0, -5.0);

/// Half of the picture's height at unit distance.
pub(crate) const HALF_HEIGHT: f32 = 0.275;

/// From the lamp to the middle of the ball \[m\]: outside of the picture.
const LAMP_DISTANCE: f32 = 2.4;

/// Cosine of the half-angle of the lamp's cone, and how far it rises inside until the light is full.
const CONE_COSINE: f32 = 0.955;
const CONE_BLEND: f32 = 0.012;

/// Colour of the lamp on its axis \[W/sr\].
const LAMP: Vec3 = Vec3::new(1.0, 0.55, 0.3);

/// Single-scattering albedo. In sixteenths, so that with an extinction of few bits, such as steps of 1/64, all
/// channels have exactly the same: the gather then takes one exponential for the three.
const ALBEDO: Vec3 = Vec3::new(7.0 / 16.0, 10.0 / 16.0, 14.0 / 16.0);

/// The page's sliders.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Angle of the lamp above the horizon \[degrees\]: 0 is on the left, 180 on the right.
    pub lamp_angle: f32,
    /// Radius of the ball \[m\], 0.2 to 0.9.
    pub ball_radius: f32,
    /// Refractive index of the ball, 1 to 2.5.
    pub index: f32,
    /// Extinction coefficient of the fog \[1/m\], > 0.
    pub extinction: f32,
    /// Photons a pass, >= 1.
    pub photons: u32,
    /// Kernel radius of plain beams in the first pass \[m\], > 0.
    pub plain_radius: f32,
    /// Another seed gives another noise.
    pub seed: u32,
    /// covbeam, instead of plain beams.
    pub adaptive: bool,
}

impl Settings {
    /// The page's first scene, by plain beams.
    pub const FIRST: Self = Self {
        lamp_angle: 52.0,
        ball_radius: 0.5,
        index: 1.5,
        extinction: 0.125,
        photons: 1024,
        plain_radius: 0.03,
        seed: 1,
        adaptive: false,
    };
}

pub(crate) struct Scene {
    pub(crate) ball: Ball,
    pub(crate) fog: Medium<'static>,
    pub(crate) seed: u32,
    lamp: Vec3,
}

impl Scene {
    pub(crate) fn new(settings: &Settings) -> Self {
        let angle = settings.lamp_angle * (PI / 180.0);
        let scattering = settings.extinction * ALBEDO;
        let absorption = settings.extinction * (Vec3::ONE - ALBEDO);
        Self {
            ball: Ball { radius: settings.ball_radius, index: settings.index },
            seed: settings.seed,
            fog: Medium { scattering, absorption, ..Medium::default() },
            lamp: LAMP_DISTANCE * Vec3::new(-cosf(angle), sinf(angle), 0.0),
        }
    }

    pub(crate) fn lamp(&self) -> Vec3 {
        self.lamp
    }

    fn axis(&self) -> Vec3 {
        -self.lamp / LAMP_DISTANCE
    }

    /// Chance of a photon of this power to go on after a collision, and its power if it does: the largest
    /// channel keeps its own.
    pub(crate) fn survival(&self, power: Vec3) -> (f32, Vec3) {
        let left = power * ALBEDO;
        let chance = left.max_element() / power.max_element();
        (chance, left / chance)
    }

    /// A direction in which the lamp shines, from two numbers in [0, 1), and the flux of a photon: one of
    /// `count`.
    pub(crate) fn emit(&self, [u, v]: [f32; 2], count: u32) -> (Vec3, Vec3) {
        let height = 1.0 - CONE_COSINE;
        let fall = u * height;
        let r = (fall * (2.0 - fall)).sqrt();
        let axis = self.axis();
        let (across, aside) = axis.any_orthonormal_pair();
        let spread = cosf(TAU * v) * across + sinf(TAU * v) * aside;
        let direction = (r * spread + (1.0 - fall) * axis).normalize();
        let (intensity, _) = falloff(1.0 - fall);
        (direction, LAMP * (intensity * TAU * height / count as f32))
    }

    /// The local light field at the lamp.
    pub(crate) fn emitted_field(&self, direction: Vec3) -> LightField {
        let axis = self.axis();
        let (_, variance) = falloff(direction.dot(axis));
        let mut field = LightField::point(direction, EVEN_LAMP);
        field.narrow(axis, variance);
        field
    }

    /// The stretch of an eye ray inside of the lamp's cone, up to `far` \[m\].
    pub(crate) fn lit_stretch(&self, ray: &EyeRay, far: f32) -> Option<[f32; 2]> {
        let axis = self.axis();
        let offset = ray.origin - self.lamp;
        let cosine2 = CONE_COSINE * CONE_COSINE;
        let (slope, height) = (ray.direction.dot(axis), offset.dot(axis));
        // Of the double cone: a t² + 2 b t + c >= 0 inside.
        let a = slope * slope - cosine2;
        let b = slope * height - cosine2 * ray.direction.dot(offset);
        let c = height * height - cosine2 * offset.length_squared();
        let root = (b * b - a * c).max(0.0).sqrt();
        let (near, last) = if a < 0.0 {
            ((-b + root) / a, (-b - root) / a)
        } else if slope > 0.0 {
            ((-b + root) / a, f32::INFINITY)
        } else {
            (f32::NEG_INFINITY, (-b - root) / a)
        };
        let (from, to) = (near.max(0.0), last.min(far));
        let middle = height + 0.5 * (from + to) * slope;
        (from < to && middle > 0.0).then_some([from, to])
    }

    /// What a metre of an eye ray scatters to the eye of the lamp's straight light, if the ball is not in its
    /// way, in units of [`Scene::single_scattering_color`] \[1/m³\].
    ///
    /// - `distance` \[m\]: from the start of the eye ray.
    pub(crate) fn scattered(&self, position: Vec3, distance: f32) -> f32 {
        let way = position - self.lamp;
        let length2 = way.length_squared();
        let length = length2.sqrt();
        let (intensity, _) = falloff(way.dot(self.axis()) / length);
        let column = distance + length;
        intensity * self.fog.transmittance(column).x * self.fog.phase.evaluate(0.0) / length2
    }

    /// Intensity of the lamp times scattering coefficient \[W/(m sr)\].
    pub(crate) fn single_scattering_color(&self) -> Vec3 {
        LAMP * self.fog.scattering
    }

    /// Factor from radiance to the tone curve: what light scattered once beside the ball has lost on its way
    /// is given back, as by a camera that adapts to the fog.
    pub(crate) fn exposure(&self) -> f32 {
        let extinction = self.fog.mean_extinction();
        let way = LAMP_DISTANCE + EYE.length();
        let thickness = 1.4;
        4.0 * PI * LAMP_DISTANCE * LAMP_DISTANCE * expf(extinction * way) / (extinction * thickness)
    }
}

/// Of the lamp's light at this cosine from the axis: what is left of it, and the angular variance that its
/// fall-off adds towards the axis \[cycles²/rad²\].
fn falloff(cosine: f32) -> (f32, f32) {
    let q = ((cosine - CONE_COSINE) / CONE_BLEND).clamp(0.0, 1.0);
    let intensity = q * q * (3.0 - 2.0 * q);
    if q <= 1e-3 || q >= 1.0 {
        return (intensity, 0.0);
    }
    // I' by the angle over I: the slope dominates at the rim, where the curvature has its inflection.
    let slope = 6.0 * q * (1.0 - q) / (CONE_BLEND * intensity);
    let curvature = (6.0 - 12.0 * q) / (CONE_BLEND * CONE_BLEND * intensity);
    let sine2 = 1.0 - cosine * cosine;
    let relative = (sine2 * curvature - cosine * slope).abs().max(sine2 * slope * slope);
    (intensity, relative / (4.0 * PI * PI))
}
