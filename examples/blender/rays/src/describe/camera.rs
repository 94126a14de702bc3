//! The camera.

use super::fields::Fields;
use crate::failure::Result;
use covbeam_geometry::MAX_COORDINATE;
use covbeam_session::camera::{Camera, Frame, Lens, Projection};
use covbeam_session::scene::MAX_IMAGE_SIDE;
use std::f64::consts::{PI, TAU};

/// Largest coordinate in the plane of a picture.
const FARTHEST: f64 = 1e6;

/// A camera, and the part of its picture that is rendered. See Camera in the extension's `host/scene.py`.
#[repr(C)]
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
    /// Place of the upper left corner in the picture's plane, towards `right`, in the projection's unit.
    pub left: f64,
    /// And towards `up`.
    pub top: f64,
    /// A pixel's width and height in it.
    pub step: [f64; 2],
    /// Of a fisheye, the largest angle that it shows \[rad\]; of others it is not read.
    pub widest: f64,
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
    /// 0 perspective, 1 orthographic, 2 equirectangular, 3 fisheye.
    pub projection: u32,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
}

impl CameraFields {
    pub(super) fn camera(&self) -> Result<Camera> {
        let fields = Fields::alone("camera");
        for (name, side) in [("width", self.width), ("height", self.height)] {
            if !(1..=MAX_IMAGE_SIDE).contains(&side) {
                return Err(fields.wrong(name, side, format_args!("a number from 1 to {MAX_IMAGE_SIDE}")));
            }
        }
        let axes = fields.axes(["right", "up", "forward"], [self.right, self.up, self.forward])?;
        let [right, up, forward] = axes.map(|axis| axis.as_vec3().normalize());
        let place = |name, value| fields.number(name, value, -FARTHEST..=FARTHEST);
        let step = |value| fields.number("step", value, 1e-12..=FARTHEST);
        let [across, down] = self.step;
        Ok(Camera {
            position: fields.point("position", self.position)?.as_vec3(),
            forward,
            right,
            up,
            projection: self.projection()?,
            frame: Frame::Part {
                left: place("left", self.left)?,
                top: place("top", self.top)?,
                step: [step(across)?, step(down)?],
            },
            width: self.width,
            height: self.height,
            near: fields.number("near", self.near, 0.0..=f64::from(MAX_COORDINATE))?,
            lens: if self.aperture == 0.0 { None } else { Some(self.lens()?) },
        })
    }

    fn projection(&self) -> Result<Projection> {
        let fields = Fields::alone("camera");
        match self.projection {
            0 => Ok(Projection::Perspective),
            1 => Ok(Projection::Orthographic),
            2 => Ok(Projection::Equirectangular),
            3 => Ok(Projection::Fisheye { widest: fields.number("widest", self.widest, 0.0..=PI)? }),
            other => Err(fields.wrong("projection", other, "a number from 0 to 3")),
        }
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
