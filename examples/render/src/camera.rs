//! Pinhole camera.

use glam::Vec3;

/// Pinhole camera with square pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The pinhole.
    pub position: Vec3,
    /// Viewing direction, unit.
    pub forward: Vec3,
    /// Towards the right edge of the picture, unit.
    pub right: Vec3,
    /// Towards the upper edge, unit.
    pub up: Vec3,
    /// Half the picture's height at distance 1.
    pub tan_half_height: f32,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
}

impl Camera {
    /// Unit direction through the picture point `(x, y)` in pixels, (0, 0) = upper left corner.
    pub fn direction(&self, x: f32, y: f32) -> Vec3 {
        let scale = 2.0 * self.tan_half_height / self.height as f32;
        let h = (x - 0.5 * self.width as f32) * scale;
        let v = (0.5 * self.height as f32 - y) * scale;
        (self.forward + h * self.right + v * self.up).normalize()
    }

    /// The picture point of a world point, with its importance: the solid angle of the pixel there is
    /// `1 / importance` sr. None outside the picture or behind the camera.
    pub fn project(&self, point: Vec3) -> Option<(f32, f32, f32)> {
        let offset = point - self.position;
        let depth = offset.dot(self.forward);
        if depth <= 0.0 {
            return None;
        }
        let scale = 2.0 * self.tan_half_height / self.height as f32;
        let x = offset.dot(self.right) / (depth * scale) + 0.5 * self.width as f32;
        let y = 0.5 * self.height as f32 - offset.dot(self.up) / (depth * scale);
        let inside = x >= 0.0 && y >= 0.0 && x < self.width as f32 && y < self.height as f32;
        let cosine = depth / offset.length();
        inside.then(|| (x, y, 1.0 / (scale * scale * cosine * cosine * cosine)))
    }
}
