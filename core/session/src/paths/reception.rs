//! Reception: how a surface divides light that not all rays see, or that comes straight from a lamp of which it casts no shadow, or another
//! one than it looks like.

use crate::scene::Rays;
use crate::surface::encounter::Lobe;

/// What the surface that a photon meets makes of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reception {
    /// Rays that see the surface: those that see what leaves it.
    pub(super) seen_by: Rays,
    /// The lobes that send it on; None: all of the surface's.
    pub(super) part: Option<Part>,
}

/// Of a surface's lobes, those that a part of the light knows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    /// That one of these rays leaves.
    pub(super) rays: Rays,
    /// Whether it goes straight on, too.
    pub(super) straight: bool,
    /// Whether glass is among them.
    pub(super) glass: bool,
}

impl Reception {
    /// Of what everything sees.
    pub(super) const PLAIN: Self = Self { seen_by: Rays::LIGHT, part: None };

    /// Whether a lobe sends the light on.
    #[inline]
    pub(super) fn sends(&self, lobe: Lobe) -> bool {
        self.part.is_none_or(|part| match lobe {
            Lobe::Transparent => part.straight,
            Lobe::GlassReflection | Lobe::GlassTransmission => part.glass && part.rays.has(lobe.ray()),
            _ => part.rays.has(lobe.ray()),
        })
    }

    /// Whether none does.
    pub(super) fn is_void(&self) -> bool {
        self.part.is_some_and(|part| !part.straight && !part.rays.has(Rays::LIGHT))
    }
}
