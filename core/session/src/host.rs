//! Hosts that keep their own geometry, and if they like their own materials, lamps and camera: what they are asked, and what becomes of answers
//! that mean nothing.

mod checked;

pub use checked::Host;

use crate::material::Lobes;
use covbeam_geometry::hit::Hit;
use glam::{DVec3, Vec3};
use std::fmt;

/// What a renderer that embeds covbeam knows of its scene. Asked from many threads at once; the same question must get the same answer, or
/// pictures depend on luck. What it says is checked: no answer makes a NaN or a pass without end.
///
/// Only [`bounds`](HostScene::bounds) and [`cast`](HostScene::cast) are asked of all hosts. The others are asked for materials, lights and the
/// camera that are described as the host's own (`asks`, `is_own`): what is described of these is then an estimate, by which the method decides
/// where light is worth following; the picture has what the host says.
pub trait HostScene: fmt::Debug + Send + Sync {
    /// Lower and upper corner of a box around all surfaces \[scene unit\].
    fn bounds(&self) -> (Vec3, Vec3);

    /// The nearest surface at a distance in (0, `reach`), from either side; `direction` is unit. Objects of glass and such that fog fills must
    /// be met each time that their inside is entered and left.
    ///
    /// Of the hit: [`Hit::object`] and [`Hit::material`] are numbers of what the scene has of them, counted from 0; [`Hit::offset`] is more than
    /// rounding can have moved `position`: some 4 ulps of the largest coordinate; curvature 0 makes light fields see the surface as flat.
    ///
    /// A hit that is out of reach or has numbers that mean nothing is none; a way that meets more than 512 surfaces ends there.
    fn cast(&self, origin: DVec3, direction: DVec3, reach: f64) -> Option<Hit>;

    /// Whether anything is met at a distance in (0, `reach`); None: see what [`HostScene::cast`] finds.
    fn is_blocked(&self, _origin: DVec3, _direction: DVec3, _reach: f64) -> Option<bool> {
        None
    }

    /// What a surface is at this very place: textures, masks.
    ///
    /// - `lobes`: as its material is described, which is the most that any place of it has: larger factors are cut to those, and its index of
    ///   refraction and whether it is of glass stay as they are. A roughness outside of 0..=1 is that of the material.
    fn lobes(&self, _hit: &Hit, lobes: &Lobes) -> Lobes {
        *lobes
    }

    /// The ways on for light, or an eye path, that meets a surface of the host's own scattering function along a unit direction. Its materials
    /// are described by lobes, of which what is transparent, the index of refraction and whether it is of glass count here, too.
    ///
    /// - `xi`: uniform, to draw the directions of rough ways with.
    fn ways(&self, _hit: &Hit, _direction: Vec3, _xi: [f32; 2]) -> HostWays {
        HostWays::default()
    }

    /// The photon of a place in the unit square, of a light by its number in the description. Neighbouring places should go neighbouring ways:
    /// guides learn which of them the picture needs.
    ///
    /// - `xi`: uniform, for the point of a light that is described with a size.
    fn emit(&self, _light: u32, _place: [f32; 2], _xi: [f32; 2]) -> HostPhoton {
        HostPhoton::default()
    }

    /// Light that arrives straight from a light on a small ball at a place, over the ball's cross section \[W/m²\], if nothing is in its way; and
    /// where it comes from.
    ///
    /// - `xi`: uniform, chooses the point that stands for all of a light that has a size; (0, 0): the middle of it, about.
    fn illuminate(&self, _light: u32, _place: Vec3, _xi: [f32; 2]) -> (Vec3, Vec3) {
        (Vec3::ZERO, Vec3::ZERO)
    }

    /// Where the eye ray through a picture point starts, and its unit direction; None: there is none.
    ///
    /// - `place`: from the upper left corner \[pixels\]; `lens`: uniform, (0, 0) is the middle.
    fn eye(&self, _place: [f32; 2], _lens: [f32; 2]) -> Option<(Vec3, Vec3)> {
        None
    }
}

/// Ways on from a surface, as factors per channel on the light that arrives, each 0..=1; what they leave is absorbed, and more than all is scaled
/// down.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HostWays {
    /// Of Lambert reflection.
    pub diffuse: Vec3,
    /// Of Lambert transmission.
    pub translucent: Vec3,
    /// Back, sharp or rough.
    pub reflected: [HostWay; 3],
    /// Into glass or out of it.
    pub refracted: HostWay,
}

/// A way that goes one direction, or a rough one of which one direction has been drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HostWay {
    /// What goes on like this of light that arrives, over the probability density of the direction. 0: nothing does, and the rest is not read.
    pub factor: Vec3,
    /// Unit.
    pub direction: Vec3,
    /// Standard deviation of its directions \[rad\]; 0: it is sharp.
    pub deviation: f32,
}

/// A photon that leaves a light of the host.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HostPhoton {
    /// Start.
    pub origin: Vec3,
    /// Unit direction.
    pub direction: Vec3,
    /// Flux of the light if all of its light left like this photon: emission over probability density \[W\]. Its mean over the unit square is the
    /// light's flux, and no more than 10⁴ times what is described as that is taken.
    pub power: Vec3,
    /// Normal of the emitting surface; zero of a light without one.
    pub normal: Vec3,
    /// Radius of a disk that looks as large as the light from along the photon's way \[scene unit\]; 0: a point.
    pub radius: f32,
    /// How its light varies with direction \[cycles²/rad²\]: 1/(4π² w²) where that falls off within an angle of w; 0: it is even.
    pub angular_variance: f32,
}
