//! Scattering into directions that are drawn: a collision in a medium, or a diffuse surface.

use crate::light::cosine_direction;
use crate::scene::bounces::Bounce;
use crate::scene::optics::to_side;
use covbeam::{LightField, Medium};
use covbeam_geometry::hit::Hit;
use glam::Vec3;

/// What scatters light.
pub(super) enum Scattering<'h> {
    /// A collision.
    Medium {
        fog: &'h Medium<'h>,
        /// Where.
        place: Vec3,
        /// The direction that the light comes along.
        along: Vec3,
        /// Whether light fields are blurred.
        blurs: bool,
    },
    /// A diffuse surface.
    Surface {
        hit: &'h Hit,
        /// Towards the side that the light goes on to.
        normal: Vec3,
        /// The triangle's, to that side: what `normal` sends behind it is mirrored back.
        geometric: Vec3,
        bounce: Bounce,
    },
}

impl Scattering<'_> {
    /// Where it is.
    #[inline]
    pub(super) fn place(&self) -> Vec3 {
        match *self {
            Self::Medium { place, .. } => place,
            Self::Surface { hit, .. } => hit.position,
        }
    }

    /// What kind of event it is.
    #[inline]
    pub(super) fn bounce(&self) -> Bounce {
        match self {
            Self::Medium { .. } => Bounce::Volume,
            Self::Surface { bounce, .. } => *bounce,
        }
    }

    /// Normal of the surface; zero in a medium.
    #[inline]
    pub(super) fn normal(&self) -> Vec3 {
        match *self {
            Self::Medium { .. } => Vec3::ZERO,
            Self::Surface { normal, .. } => normal,
        }
    }

    /// A direction, drawn as the light goes.
    ///
    /// - `xi`: uniform.
    #[inline]
    pub(super) fn direction(&self, xi: [f32; 2]) -> Vec3 {
        match *self {
            Self::Medium { fog, along, .. } => fog.sample_direction(along, xi),
            Self::Surface { normal, geometric, .. } => to_side(cosine_direction(normal, xi), geometric),
        }
    }

    /// What light weighs that goes on along such a direction, per channel.
    #[inline]
    pub(super) fn weight(&self, direction: Vec3) -> Vec3 {
        match *self {
            Self::Medium { fog, along, .. } => fog.sampling_weight(along.dot(direction)),
            Self::Surface { .. } => Vec3::ONE,
        }
    }

    /// Where light starts that goes on along a direction.
    #[inline]
    pub(super) fn start(&self, direction: Vec3) -> Vec3 {
        match *self {
            Self::Medium { place, .. } => place,
            Self::Surface { hit, .. } => hit.leave(direction),
        }
    }

    /// Turns a light field into a direction.
    #[inline]
    pub(super) fn turn(&self, field: &mut LightField, direction: Vec3) {
        match *self {
            Self::Medium { fog, along, blurs, .. } => {
                let variance = || fog.angular_variance(along.dot(direction));
                field.scatter(direction, if blurs { variance() } else { f32::INFINITY });
            }
            Self::Surface { normal, .. } => field.diffuse(normal, direction),
        }
    }
}

/// Share of the light that collides with a medium that it scatters; 0 where nothing collides.
#[inline]
pub(super) fn albedo(fog: &Medium) -> Vec3 {
    fog.scattering / fog.extinction().max(Vec3::splat(f32::MIN_POSITIVE))
}
