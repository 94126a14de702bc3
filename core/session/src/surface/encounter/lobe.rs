//! Lobes of a surface: which there are, how directions behave in each, and the share of light that each takes.

use crate::material::{Lobes, kept};
use crate::scene::bounces::Bounce;
use crate::scene::optics::refract;
use crate::scene::visibility::Rays;
use glam::Vec3;

/// A lobe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lobe {
    Transparent,
    Diffuse,
    Translucent,
    Metal,
    Coat,
    GlassReflection,
    GlassTransmission,
}

impl Lobe {
    pub(super) const ALL: [Self; 7] = [
        Self::Transparent,
        Self::Diffuse,
        Self::Translucent,
        Self::Metal,
        Self::Coat,
        Self::GlassReflection,
        Self::GlassTransmission,
    ];

    /// Those that keep directions apart, or nearly.
    pub(super) const SHARP: [Self; 5] =
        [Self::Transparent, Self::Metal, Self::Coat, Self::GlassReflection, Self::GlassTransmission];

    /// The kind of event that it is; None: light goes straight on.
    pub(crate) fn bounce(self) -> Option<Bounce> {
        match self {
            Self::Transparent => None,
            Self::Diffuse => Some(Bounce::Diffuse),
            Self::Metal | Self::Coat | Self::GlassReflection => Some(Bounce::Glossy),
            Self::Translucent | Self::GlassTransmission => Some(Bounce::Transmission),
        }
    }

    /// The kind of a ray that it sends on, which was of another one: what goes straight on stays of that.
    #[inline]
    pub(crate) fn sent_on(self, ray: Rays) -> Rays {
        if self == Self::Transparent { ray } else { self.ray() }
    }

    /// The kind of the ray that comes to light which it sends on: of what is transparent none of its own.
    #[inline]
    pub(crate) fn ray(self) -> Rays {
        match self {
            Self::Transparent => Rays::NONE,
            Self::Diffuse => Rays::DIFFUSE,
            Self::Metal | Self::Coat | Self::GlassReflection => Rays::GLOSSY,
            Self::Translucent | Self::GlassTransmission => Rays::TRANSMISSION,
        }
    }

    /// Whether light leaves it diffusely.
    #[inline]
    pub(crate) fn is_diffuse(self) -> bool {
        matches!(self, Self::Diffuse | Self::Translucent)
    }

    /// Whether it is of glass.
    #[inline]
    pub(super) fn is_glass(self) -> bool {
        matches!(self, Self::GlassReflection | Self::GlassTransmission)
    }

    /// Whether it sends light through the surface.
    #[inline]
    pub(crate) fn crosses(self) -> bool {
        matches!(self, Self::Transparent | Self::Translucent | Self::GlassTransmission)
    }
}

/// Share that a metal reflects, by Schlick's curve.
#[inline]
pub(super) fn metal(lobes: &Lobes, direction: Vec3, facet: Vec3) -> Vec3 {
    let rest = 1.0 - (-direction.dot(facet)).clamp(0.0, 1.0);
    let squared = rest * rest;
    lobes.metal + (lobes.edge - lobes.metal) * (rest * squared * squared)
}

/// Share that a coat reflects: it is thin, and met from outside on either side.
#[inline]
pub(super) fn coat(lobes: &Lobes, direction: Vec3, facet: Vec3) -> Vec3 {
    lobes.coat * refract(direction, facet, 1.0 / lobes.index).0
}

/// What leaves the rough facets of metal or of a coat in all over what has met a single one, by the cosine at which the camera looks.
pub(super) fn gain(lobes: &Lobes, lobe: Lobe, cosine: f32) -> Vec3 {
    let reflectance = match lobe {
        Lobe::Metal => kept::mean_metal(lobes.metal, lobes.edge),
        _ => lobes.coat * kept::mean_dielectric(lobes.index),
    };
    kept::gain(cosine, lobes.alpha, reflectance)
}

/// What a coat takes from the diffuse part below it: all that leaves the coat.
pub(super) fn coated(lobes: &Lobes, direction: Vec3, normal: Vec3, facet: Vec3) -> Vec3 {
    if !(lobes.multiscatter && lobes.is_rough()) {
        return coat(lobes, direction, normal);
    }
    let cosine = (-direction.dot(normal)).clamp(0.0, 1.0);
    coat(lobes, direction, facet) * (kept::albedo(cosine, lobes.alpha) * gain(lobes, Lobe::Coat, cosine))
}
