//! Where a light shines, and how strongly, in a few numbers: for choosing among many.

use super::kinds::Light;
use super::seen::patch::front;
use crate::color::mean;
use glam::Vec3;
use std::f32::consts::{FRAC_PI_2, PI};

/// What is told of a light that is not far away, about. Its middle and how it falls off are [`Light::middle`]'s.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shine {
    /// Flux into a steradian where it shines most \[W/sr\]; of patterns the mean.
    pub(crate) strength: f32,
    /// Unit.
    pub(crate) axis: Vec3,
    /// Largest angle between the axis and a direction in which it shines, from far away \[rad\]; π: all around.
    pub(crate) angle: f32,
    /// Whether a cosine dims it towards the side.
    pub(crate) is_flat: bool,
    /// Of a ball around the middle that holds all of it.
    pub(crate) radius: f32,
}

impl Light {
    /// Of a light with a place.
    pub(crate) fn shine(&self) -> Shine {
        let even = |radius| Shine {
            strength: mean(self.flux()) / (4.0 * PI),
            axis: Vec3::Y,
            angle: PI,
            is_flat: false,
            radius,
        };
        let flat = |axis, radius| Shine {
            strength: mean(self.flux()) / PI,
            axis,
            angle: FRAC_PI_2,
            is_flat: true,
            radius,
        };
        match *self {
            Self::Point { .. } | Self::Sun(_) | Self::Sky(_) | Self::Glow(_) => even(0.0),
            Self::Spot { direction, intensity, outer_angle, .. } => {
                Shine { strength: mean(intensity), axis: direction, angle: outer_angle, ..even(0.0) }
            }
            Self::Disk { normal, radius, .. } => flat(normal, radius),
            Self::Rectangle { edge_u, edge_v, .. } => {
                flat(front(edge_u, edge_v), 0.5 * (edge_u.length() + edge_v.length()))
            }
            Self::Sphere { radius, .. } => even(radius),
            Self::Lamp(ref lamp) => Shine {
                strength: mean(lamp.mean_intensity()),
                ..lamp.cone.map_or(even(lamp.radius), |cone| Shine {
                    axis: cone.axis,
                    angle: libm::acosf(cone.cosine.clamp(-1.0, 1.0)),
                    ..even(lamp.radius)
                })
            },
            Self::Area(area) => Shine {
                strength: mean(area.intensity()),
                angle: area.spread.min(FRAC_PI_2),
                ..flat(area.normal(), 0.5 * (area.edge_u.length() + area.edge_v.length()))
            },
            Self::Own(ref own) => own.described.shine(),
            Self::Mesh(ref mesh) => {
                let (min, max) = mesh.bounds();
                even(0.5 * (max - min).length())
            }
        }
    }
}
