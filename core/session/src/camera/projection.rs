//! Projections: from places in the picture's plane to directions.

use glam::{Quat, Vec3};

/// How a place in the picture's plane becomes a ray. A place is (h, v), to the right and up, in a unit of the projection's own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Through a point, or a lens around it: (h, v) are tangents, those of the plane at distance 1 in front of the camera.
    Perspective,
    /// Parallel rays along the viewing axis: (h, v) is where they start, from the camera's position [scene unit].
    Orthographic,
    /// All around a point: h is the longitude, from the viewing axis towards the right, v the latitude \[rad\].
    Equirectangular,
    /// A fisheye: the length of (h, v) is the angle from the viewing axis \[rad\].
    Fisheye {
        /// Largest angle that it shows, up to π; what its picture has beyond is dark.
        widest: f32,
    },
}

/// Where a camera looks: unit vectors at right angles.
#[derive(Clone, Copy)]
pub(super) struct View {
    pub(super) forward: Vec3,
    pub(super) right: Vec3,
    pub(super) up: Vec3,
}

impl Projection {
    /// Unit direction of the ray at a place.
    pub(super) fn direction(&self, view: &View, [h, v]: [f32; 2]) -> Vec3 {
        match self {
            Self::Perspective => (view.forward + h * view.right + v * view.up).normalize(),
            Self::Orthographic => view.forward,
            Self::Equirectangular | Self::Fisheye { .. } => self.around(view, [h, v])[0],
        }
    }

    /// Whether there is a ray at a place.
    pub(super) fn sees(&self, [h, v]: [f32; 2]) -> bool {
        match *self {
            Self::Fisheye { widest } => libm::hypotf(h, v) <= widest,
            _ => true,
        }
    }

    /// How much farther along the viewing axis a unit along a ray gets; of panoramas, how much farther from the camera. > 0.
    pub(super) fn depth_along(&self, view: &View, direction: Vec3) -> f32 {
        match self {
            Self::Perspective | Self::Orthographic => direction.dot(view.forward),
            Self::Equirectangular | Self::Fisheye { .. } => 1.0,
        }
    }

    /// The direction of a panorama at a place, and its derivatives by both of (h, v).
    pub(super) fn around(&self, view: &View, [h, v]: [f32; 2]) -> [Vec3; 3] {
        let View { forward, right, up } = *view;
        if *self == Self::Equirectangular {
            let ((sine_h, cosine_h), (sine_v, cosine_v)) = (libm::sincosf(h), libm::sincosf(v));
            let level = cosine_h * forward + sine_h * right;
            let east = cosine_h * right - sine_h * forward;
            return [cosine_v * level + sine_v * up, cosine_v * east, cosine_v * up - sine_v * level];
        }
        let angle = libm::hypotf(h, v);
        let (sine, cosine) = libm::sincosf(angle);
        // sin(r)/r, and the direction in the picture from its middle; there any one will do.
        let (sinc, [x, y]) =
            if angle > 0.0 { (sine / angle, [h / angle, v / angle]) } else { (1.0, [1.0, 0.0]) };
        let (outward, aside) = (x * right + y * up, x * up - y * right);
        let by_angle = cosine * outward - sine * forward;
        [cosine * forward + sine * outward, x * by_angle - y * sinc * aside, y * by_angle + x * sinc * aside]
    }

    /// To the right and up in the plane of the lens, which panoramas turn towards each ray.
    pub(super) fn lens_axes(&self, view: &View, direction: Vec3) -> [Vec3; 2] {
        match self {
            Self::Perspective | Self::Orthographic => [view.right, view.up],
            Self::Equirectangular | Self::Fisheye { .. } => {
                let turn = Quat::from_rotation_arc(view.forward, direction);
                [turn * view.right, turn * view.up]
            }
        }
    }
}
