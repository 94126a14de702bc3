//! Ways that a host's own scattering function sends light on.

use super::lobe::Lobe;
use crate::host::{HostWay, HostWays};
use crate::material::FOCUSING;
use covbeam::{Curvature, LightField};
use glam::Vec3;
use std::f32::consts::{SQRT_2, TAU};

/// Of an encounter: the ways that are drawn from a direction each.
#[derive(Clone, Copy)]
pub(super) struct OwnWays {
    reflected: [HostWay; 3],
    refracted: HostWay,
}

impl OwnWays {
    /// What the host says, in the order of all lobes, and the rest of it.
    ///
    /// - `transparent`: what goes straight on.
    pub(super) fn sorted(transparent: Vec3, ways: &HostWays) -> ([Vec3; 7], Self) {
        let HostWays { diffuse, translucent, reflected, refracted } = *ways;
        let [a, b, c] = reflected.map(|way| way.factor);
        let factors = [transparent, diffuse, translucent, a, b, c, refracted.factor];
        (factors, Self { reflected, refracted })
    }

    /// Of a lobe that is neither diffuse nor transparent.
    fn of(&self, lobe: Lobe) -> &HostWay {
        match lobe {
            Lobe::Coat => &self.reflected[1],
            Lobe::GlassReflection => &self.reflected[2],
            Lobe::GlassTransmission => &self.refracted,
            _ => &self.reflected[0],
        }
    }

    pub(super) fn direction(&self, lobe: Lobe) -> Vec3 {
        self.of(lobe).direction
    }

    /// Whether the way is one of many.
    pub(super) fn is_rough(&self, lobe: Lobe) -> bool {
        self.of(lobe).deviation > 0.0
    }

    /// As [`Encounter::keeps_focus`](super::Encounter::keeps_focus): a facet of α turns what it reflects by √2 α.
    pub(super) fn keeps_focus(&self, lobe: Lobe) -> bool {
        self.of(lobe).deviation <= SQRT_2 * FOCUSING
    }

    /// As [`Encounter::turn`](super::Encounter::turn).
    ///
    /// - `normal`: against the direction that the light comes along; `curvature`: towards any normal on its side; `eta`: index on this side over that
    ///   on the other.
    pub(super) fn turn(
        &self,
        field: &mut LightField,
        lobe: Lobe,
        (along, normal): (Vec3, Vec3),
        curvature: impl Fn(Vec3) -> Curvature,
        eta: f32,
    ) {
        let HostWay { direction, deviation, .. } = *self.of(lobe);
        // The facet that it was reflected or refracted by, whichever way that faces.
        let refracts = lobe == Lobe::GlassTransmission;
        let across = if refracts { eta * along - direction } else { direction - along };
        let facet = across
            .try_normalize()
            .map_or(normal, |facet| if facet.dot(along) > 0.0 { -facet } else { facet });
        if refracts {
            field.refract(facet, &curvature(facet), eta);
        } else {
            field.reflect(facet, &curvature(facet));
        }
        if deviation > 0.0 {
            let angle = TAU * deviation.max(1e-3);
            field.scatter(direction, 1.0 / (angle * angle));
        }
    }
}
