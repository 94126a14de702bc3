//! Pinhole camera.

use covbeam::PixelStep;
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
    /// Pixels down of a picture of the same shape that is so many pixels wide; at least 1.
    pub fn height_for(&self, width: u32) -> u32 {
        let height = f64::from(self.height) * f64::from(width) / f64::from(self.width);
        (height.round() as u32).max(1)
    }

    /// Scales the picture to a width; the height follows.
    pub fn set_width(&mut self, width: u32) {
        (self.width, self.height) = (width, self.height_for(width));
    }

    /// Unit direction through the picture point `(x, y)` in pixels, (0, 0) = upper left corner.
    pub fn direction(&self, x: f32, y: f32) -> Vec3 {
        let scale = 2.0 * self.tan_half_height / self.height as f32;
        let h = (x - 0.5 * self.width as f32) * scale;
        let v = (0.5 * self.height as f32 - y) * scale;
        (self.forward + h * self.right + v * self.up).normalize()
    }

    /// How the eye ray of this unit direction changes with a pixel to the right and a pixel down.
    pub fn pixel_steps(&self, direction: Vec3) -> [PixelStep; 2] {
        // The directions are normalised: at distance 1 along the axis a pixel is this large, here it is seen from further away.
        let pixel = 2.0 * self.tan_half_height / self.height as f32 * direction.dot(self.forward);
        [self.right, -self.up].map(|axis| {
            let moved = pixel * axis;
            PixelStep { origin: Vec3::ZERO, direction: moved - moved.dot(direction) * direction }
        })
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Askew and off centre, so that no sign or axis can hide.
    fn camera() -> Camera {
        let forward = Vec3::new(0.3, -0.5, 0.8).normalize();
        let right = forward.cross(Vec3::Y).normalize();
        let up = right.cross(forward);
        let position = Vec3::new(1.0, 2.0, -3.0);
        Camera { position, forward, right, up, tan_half_height: 0.3, width: 96, height: 64 }
    }

    #[test]
    fn the_middle_of_the_picture_is_straight_ahead_and_its_edges_at_half_the_field_of_view() {
        let camera = camera();
        assert!((camera.direction(48.0, 32.0) - camera.forward).length() < 1e-6);
        let top = camera.direction(48.0, 0.0);
        assert!((top.dot(camera.up) / top.dot(camera.forward) - 0.3).abs() < 1e-6, "up is row 0");
        let right = camera.direction(96.0, 32.0);
        assert!((right.dot(camera.right) / right.dot(camera.forward) - 0.45).abs() < 1e-6, "square pixels");
    }

    #[test]
    fn a_point_projects_to_where_its_direction_came_from() {
        let camera = camera();
        for (x, y) in [(0.5, 0.5), (95.5, 0.5), (10.25, 63.5), (48.0, 32.0), (70.0, 12.0)] {
            let (px, py, _) =
                camera.project(camera.position + 7.0 * camera.direction(x, y)).expect("in view");
            // f32 positions of a few units, 100 pixels a unit.
            assert!((px - x).abs() < 1e-3 && (py - y).abs() < 1e-3, "({px}, {py}) for ({x}, {y})");
        }
    }

    #[test]
    fn the_importance_is_the_inverse_of_the_pixels_solid_angle() {
        let camera = camera();
        for (x, y) in [(48.5, 32.5), (0.5, 0.5), (90.5, 60.5)] {
            let corner = |dx: f32, dy: f32| camera.direction(x + dx, y + dy).as_dvec3();
            let solid_angle = |a: glam::DVec3, b: glam::DVec3, c: glam::DVec3| {
                // van Oosterom and Strackee (1983), for unit vectors.
                2.0 * (a.dot(b.cross(c)).abs()).atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
            };
            let [a, b, c, d] = [corner(-0.5, -0.5), corner(0.5, -0.5), corner(0.5, 0.5), corner(-0.5, 0.5)];
            let expected = 1.0 / (solid_angle(a, b, c) + solid_angle(a, c, d));
            let (_, _, importance) =
                camera.project(camera.position + camera.direction(x, y)).expect("in view");
            // The importance varies by 1e-4 over a pixel; the corners' f32 directions add 1e-7 / 0.01.
            assert!((f64::from(importance) / expected - 1.0).abs() < 3e-4, "{importance} against {expected}");
        }
    }

    #[test]
    fn what_is_behind_or_beside_the_picture_is_not_projected() {
        let camera = camera();
        assert!(camera.project(camera.position - camera.forward).is_none());
        assert!(camera.project(camera.position).is_none());
        for (x, y) in [(-0.5, 10.0), (96.5, 10.0), (10.0, -0.5), (10.0, 64.5)] {
            assert!(camera.project(camera.position + camera.direction(x, y)).is_none());
        }
    }
}
