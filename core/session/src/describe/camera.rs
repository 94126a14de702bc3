//! The camera.

use super::fields::Fields;
use crate::camera::{Camera, Frame, Lens, Projection};
use crate::scene::MAX_IMAGE_SIDE;
use crate::work::failure::Result;
use covbeam_geometry::MAX_COORDINATE;
use glam::DVec3;
use std::f32::consts::PI;
use std::f64::consts::TAU;

/// Largest coordinate in the plane of a picture.
const FARTHEST: f64 = 1e6;

/// Smallest size in it.
const LEAST_STEP: f64 = 1e-12;

/// A camera, and the part of its picture that is rendered. See Camera in the extension's `host/scene.py`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraFields {
    /// \[m\]
    pub position: [f64; 3],
    /// Unit.
    pub right: [f64; 3],
    /// Unit.
    pub up: [f64; 3],
    /// Unit.
    pub forward: [f64; 3],
    /// Which part of the picture's plane is rendered.
    pub frame: Frame,
    /// What is nearer is not there \[m\].
    pub near: f64,
    /// Radius of the lens' opening \[m\]; 0 = a pinhole, and the next four are not read.
    pub aperture: f64,
    /// What is sharp \[m\].
    pub focus: f64,
    /// Angle of the middle of an edge of the opening \[rad\].
    pub rotation: f64,
    /// Height over width of the opening.
    pub ratio: f64,
    /// Corners of the opening; 0 = a disk.
    pub blades: u32,
    /// How places in the picture become rays.
    pub projection: Projection,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Whether a host says where its rays go; what is described is an estimate then.
    pub is_own: bool,
}

impl CameraFields {
    /// A pinhole that looks at a point, upright where the y axis points up.
    ///
    /// - `half_height`: of the picture, tan(vertical field of view / 2).
    /// - `look_at`: any point that is not above, below or at the camera.
    pub fn looking(
        position: [f64; 3],
        look_at: [f64; 3],
        half_height: f32,
        [width, height]: [u32; 2],
    ) -> Self {
        let forward = (DVec3::from(look_at) - DVec3::from(position)).normalize();
        let right = forward.cross(DVec3::Y).normalize();
        Self {
            position,
            right: right.to_array(),
            up: right.cross(forward).to_array(),
            forward: forward.to_array(),
            frame: Frame::Middle { half_height },
            near: 0.0,
            aperture: 0.0,
            focus: 0.0,
            rotation: 0.0,
            ratio: 0.0,
            blades: 0,
            projection: Projection::Perspective,
            width,
            height,
            is_own: false,
        }
    }

    pub(super) fn camera(&self) -> Result<Camera> {
        let fields = Fields::alone("camera");
        for (name, side) in [("width", self.width), ("height", self.height)] {
            if !(1..=MAX_IMAGE_SIDE).contains(&side) {
                return Err(fields.wrong(name, side, format_args!("a number from 1 to {MAX_IMAGE_SIDE}")));
            }
        }
        let axes = fields.axes(["right", "up", "forward"], [self.right, self.up, self.forward])?;
        let [right, up, forward] = axes.map(|axis| axis.as_vec3().normalize());
        Ok(Camera {
            position: fields.point("position", self.position)?.as_vec3(),
            forward,
            right,
            up,
            projection: self.projection()?,
            frame: self.frame()?,
            width: self.width,
            height: self.height,
            near: fields.number("near", self.near, 0.0..=f64::from(MAX_COORDINATE))?,
            is_own: self.is_own,
            lens: if self.aperture == 0.0 { None } else { Some(self.lens()?) },
        })
    }

    fn frame(&self) -> Result<Frame> {
        let fields = Fields::alone("camera");
        let within = |name, value: f32, least| fields.number(name, f64::from(value), least..=FARTHEST);
        match self.frame {
            Frame::Middle { half_height } => within("half_height", half_height, LEAST_STEP).map(drop)?,
            Frame::Part { left, top, step: [across, down] } => {
                within("left", left, -FARTHEST)?;
                within("top", top, -FARTHEST)?;
                within("step", across, LEAST_STEP)?;
                within("step", down, LEAST_STEP)?;
            }
        }
        Ok(self.frame)
    }

    fn projection(&self) -> Result<Projection> {
        if let Projection::Fisheye { widest } = self.projection {
            Fields::alone("camera").number("widest", f64::from(widest), 0.0..=f64::from(PI))?;
        }
        Ok(self.projection)
    }

    fn lens(&self) -> Result<Lens> {
        let fields = Fields::alone("camera.aperture");
        // No sense in more corners than a disk of this many.
        if self.blades > 1000 {
            return Err(fields.wrong("blades", self.blades, "a number from 0 to 1000"));
        }
        Ok(Lens {
            radius: fields.length("radius", self.aperture)?,
            focus_distance: fields.length("focus", self.focus)?,
            blades: self.blades,
            // Any number of turns.
            rotation: fields.number("rotation", self.rotation, -1e6..=1e6)?.rem_euclid(TAU as f32),
            ratio: fields.number("ratio", self.ratio, 1e-6..=1e6)?,
        })
    }
}
