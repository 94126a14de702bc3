//! Visibility: which rays see objects and lamps, on what a lamp's straight light falls, and what casts shadows of it.
//!
//! Rays go from the eye to the light, and are of a kind by what they leave: the camera, a lobe of a surface, a place in fog that scatters. Light
//! goes the other way, and has the kind of what it comes to next. A shadow ray is what light comes along straight from its lamp.

use crate::light::falloff::Falloff;

/// A set of kinds of rays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rays(u8);

impl Rays {
    /// None of them.
    pub const NONE: Self = Self(0);
    /// From the camera.
    pub const CAMERA: Self = Self(1);
    /// From a diffuse surface.
    pub const DIFFUSE: Self = Self(1 << 1);
    /// From one that reflects as metal, coats and glass do.
    pub const GLOSSY: Self = Self(1 << 2);
    /// From one that lets light through, refracted or diffusely.
    pub const TRANSMISSION: Self = Self(1 << 3);
    /// From a place in a medium.
    pub const VOLUME: Self = Self(1 << 4);
    /// From anywhere to a lamp.
    pub const SHADOW: Self = Self(1 << 5);
    /// All that light comes along which is seen or sent on.
    pub(crate) const LIGHT: Self =
        Self(Self::DIFFUSE.0 | Self::GLOSSY.0 | Self::TRANSMISSION.0 | Self::VOLUME.0);
    /// All.
    pub const ALL: Self = Self(Self::CAMERA.0 | Self::LIGHT.0 | Self::SHADOW.0);

    /// The set of these bits, counted from that of the camera in the order above; None: there are others.
    pub fn from_bits(bits: u32) -> Option<Self> {
        u8::try_from(bits).ok().map(Self).filter(|rays| Self::ALL.0 & rays.0 == rays.0)
    }

    /// Its bits.
    pub const fn bits(self) -> u32 {
        self.0 as u32
    }

    /// Whether any of some kinds are in it.
    #[inline]
    pub fn has(self, kinds: Self) -> bool {
        self.0 & kinds.0 != 0
    }

    /// Those that are in both.
    #[inline]
    pub(crate) fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// Those that are not in the other.
    #[inline]
    pub(crate) fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }
}

/// Sets that an object or a medium can be in, for lamps to tell apart.
pub const SETS: u32 = 64;

/// By which rays and lamps an object or a medium is not heeded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Heed {
    /// Rays that do not see it: to them it is not there.
    pub hidden: Rays,
    /// Which of the [`SETS`] it is in, for lamps that light some only.
    pub light_set: u8,
    /// And for those of which some only cast shadows.
    pub shadow_set: u8,
}

impl Heed {
    /// Whether it casts shadows of a lamp.
    #[inline]
    pub(crate) fn is_in_way(&self, links: &Links) -> bool {
        !self.hidden.has(Rays::SHADOW) && links.unshadowed >> self.shadow_set & 1 == 0
    }
}

/// On what a lamp's straight light falls, what casts shadows of it, and how it fades: by default on all, all, and only as it spreads.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Links {
    /// Sets of objects and media that it does not fall on, a bit each.
    pub unlit: u64,
    /// Sets of objects that it passes as if they were not there.
    pub unshadowed: u64,
    /// Rays that do not see it: it does not fall on what they leave. The camera's and those to lamps do not count.
    pub hidden: Rays,
    /// How it fades.
    pub falloff: Falloff,
    /// Events of its light on the way to the camera, of which the limit of bounces counts one fewer at least; None: as many as that says.
    pub bounces: Option<u32>,
}

impl Links {
    /// Whether it falls on what is in a set.
    #[inline]
    pub(crate) fn lights(&self, set: u8) -> bool {
        self.unlit >> set & 1 == 0
    }

    /// Whether it passes anything as if that were not there.
    #[inline]
    pub(crate) fn passes_any(&self) -> bool {
        self.unshadowed != 0
    }

    /// Whether a medium in a set scatters it.
    #[inline]
    pub(crate) fn lights_medium(&self, set: u8) -> bool {
        self.lights(set) && !self.hidden.has(Rays::VOLUME)
    }

    /// Rays that see it where it falls.
    #[inline]
    pub(crate) fn seen_by(&self) -> Rays {
        Rays::LIGHT.without(self.hidden)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_that_mean_nothing_are_no_rays() {
        assert_eq!(Rays::from_bits(0), Some(Rays::NONE));
        assert_eq!(Rays::from_bits(0b11_1111), Some(Rays::ALL));
        assert_eq!(Rays::from_bits(0b1_0000), Some(Rays::VOLUME));
        for bits in [1 << 6, 1 << 8 | 1, u32::MAX] {
            assert_eq!(Rays::from_bits(bits), None);
        }
    }
}
