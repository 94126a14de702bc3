//! Kinds of light, by what it has met on its way.

use crate::scene::Scene;
use glam::Vec3;

/// What light has met before it reaches the fog or the surface that sends it to the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "lowercase"))]
pub enum Kind {
    /// Nothing: it comes straight from a lamp.
    Straight,
    /// Mirrors and glass alone.
    Focused,
    /// A medium or a diffuse surface.
    Scattered,
}

impl Kind {
    /// All, in the order of [`ByKind`].
    pub const ALL: [Self; 3] = [Self::Straight, Self::Focused, Self::Scattered];

    /// As files call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Straight => "straight",
            Self::Focused => "focused",
            Self::Scattered => "scattered",
        }
    }
}

/// Layers that a picture has at most.
pub(crate) const MOST_LAYERS: usize = 3;

/// Radiance of each kind, in the order of [`Kind::ALL`].
pub type ByKind = [Vec3; 3];

/// Which kinds of light have a layer of their own: spectra, beam maps, eye rays and filters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(transparent))]
pub struct Split {
    /// By kind.
    of: [u8; 3],
}

impl Split {
    /// One layer for all.
    pub const TOGETHER: Self = Self { of: [0; 3] };

    /// Straight light apart from the others.
    pub const STRAIGHT_APART: Self = Self { of: [0, 1, 1] };

    /// A layer for each kind.
    pub const EACH: Self = Self { of: [0, 1, 2] };

    /// A layer for each kind that a scene can have: without mirrors and glass no light is focused.
    pub fn of_each_kind(scene: &Scene) -> Self {
        let has_focused = scene.materials().any(|material| material.bends_light());
        if has_focused { Self::EACH } else { Self::STRAIGHT_APART }
    }

    /// The layer of a kind.
    pub fn of(self, kind: Kind) -> usize {
        self.of[kind as usize].into()
    }

    /// The kinds of light that are told apart: one a layer.
    pub fn kinds(self) -> impl Iterator<Item = Kind> {
        (0..self.count()).map(move |layer| self.last_kind(layer))
    }

    /// How many there are.
    pub fn count(self) -> usize {
        usize::from(self.of[2]) + 1
    }

    /// The last kind of a layer.
    pub(crate) fn last_kind(self, layer: usize) -> Kind {
        let of_layer = |kind: &Kind| self.of(*kind) == layer;
        Kind::ALL.into_iter().rev().find(of_layer).unwrap_or(Kind::Scattered)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::made::{Made, camera, point, sphere};
    use crate::scene::{Lobes, Material};

    /// Artists' materials have a roughness of .5 unless somebody changes it: such a scene pays for no layer of its own.
    #[test]
    fn what_rough_surfaces_reflect_is_scattered() {
        let split = |roughness: f32| {
            let lobes = Lobes { coat: Vec3::ONE, index: 1.5, alpha: roughness * roughness, ..Lobes::NONE };
            let made = Made::new(camera([0.0, 0.0, -3.0], [0.0; 3], 40.0, [8, 8])).fog(0.1, 0.0).in_fog();
            let made = made.object(sphere([0.0; 3], 0.5), Material::Lobes(lobes));
            Split::of_each_kind(&made.light(point([0.0, 2.0, 0.0], 1.0)).scene())
        };
        assert_eq!([0.0, 0.3, 0.5].map(split), [Split::EACH, Split::EACH, Split::STRAIGHT_APART]);
    }
}
