//! The frame of a picture: from pixels to places in the picture's plane, and back.

/// Which part of its plane a picture shows, in the unit of the [`Projection`](super::Projection).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Frame {
    /// The part around the middle of the view, in square pixels, with so much of it above the middle, > 0.
    Middle {
        /// Half the picture's height.
        half_height: f32,
    },
    /// Any part.
    Part {
        /// The upper left corner's h.
        left: f32,
        /// The upper left corner's v.
        top: f32,
        /// A pixel's width and height, > 0.
        step: [f32; 2],
    },
}

/// Pixels across and down; as numbers that places are found with.
type Size = [f32; 2];

impl Frame {
    /// A pixel's width and height.
    pub(super) fn step(&self, [_, height]: Size) -> [f32; 2] {
        match *self {
            Self::Middle { half_height } => [2.0 * half_height / height; 2],
            Self::Part { step, .. } => step,
        }
    }

    /// The place (h, v) of a picture point.
    pub(super) fn place(&self, size: Size, [x, y]: [f32; 2]) -> [f32; 2] {
        let [across, down] = self.step(size);
        match *self {
            Self::Middle { .. } => [(x - 0.5 * size[0]) * across, (0.5 * size[1] - y) * down],
            Self::Part { left, top, .. } => [left + x * across, top - y * down],
        }
    }

    /// The picture point of a place (h, v) / `depth`: of a point so far in front of a pinhole.
    pub(super) fn point(&self, size: Size, [h, v]: [f32; 2], depth: f32) -> [f32; 2] {
        let [across, down] = self.step(size);
        match *self {
            Self::Middle { .. } => [h / (depth * across) + 0.5 * size[0], 0.5 * size[1] - v / (depth * down)],
            Self::Part { left, top, .. } => [(h / depth - left) / across, (top - v / depth) / down],
        }
    }

    /// Side of a square as large as the picture.
    pub(super) fn side(&self, [width, height]: Size) -> f32 {
        match *self {
            Self::Middle { half_height } => 2.0 * half_height * (width / height).sqrt(),
            Self::Part { step: [across, down], .. } => (width * across * (height * down)).sqrt(),
        }
    }

    /// Goes on to show the same in another number of pixels.
    pub(super) fn resize(&mut self, from: Size, to: Size) {
        if let Self::Part { step, .. } = self {
            step[0] *= from[0] / to[0];
            step[1] *= from[1] / to[1];
        }
    }
}
