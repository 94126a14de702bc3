//! Kinds of lights.

use super::area::Area;
use super::glow::GlowingFog;
use super::lamp::Lamp;
use super::mesh::ShiningMesh;
use super::sky::Sky;
use super::sun::Sun;
use crate::host::Host;
use glam::Vec3;

/// A light.
#[derive(Clone, Debug, PartialEq)]
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
        /// Half-angle of the full cone \[rad\], >= 0.
        inner_angle: f32,
        /// Half-angle where light ends \[rad\], > inner_angle, < π/2.
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
    /// A point or ball that shines all around, into a cone or by a pattern, as Blender's lamps do.
    Lamp(Lamp),
    /// One-sided parallelogram or ellipse, with a honeycomb before it or not.
    Area(Area),
    /// Triangles that shine on both sides.
    Mesh(ShiningMesh),
    /// What is around the scene, infinitely far away.
    Sky(Sky),
    /// A medium that glows.
    Glow(GlowingFog),
    /// One of a host's own.
    Own(OwnLight),
}

/// A light of a host.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnLight {
    /// An estimate: where the light is, how much it sends about where, and what is seen of it. It shines wherever the host's does.
    pub described: Box<Light>,
    /// Who says what it sends.
    pub host: Host,
    /// Its number, as the host knows it.
    pub number: u32,
}
