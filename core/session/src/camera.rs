//! Cameras: the rays that a picture is made of.

mod lens;

pub use lens::Lens;

use covbeam::PixelStep;
use glam::{Quat, Vec3};

/// How a place in the picture's plane becomes a ray. A place is (h, v), to the right and up, in a unit of the projection's own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Through a point, or a lens around it: (h, v) are tangents, those of the plane at distance 1 in front of the camera.
    Perspective,
    /// Parallel rays along the viewing axis: (h, v) is where they start, from the camera's position [scene unit].
    Orthographic,
    /// All around a point: h is the longitude, from the viewing axis towards the right, v the latitude [rad].
    Equirectangular,
    /// A fisheye: the length of (h, v) is the angle from the viewing axis [rad].
    Fisheye {
        /// Largest angle that it shows, up to π; what its picture has beyond is dark.
        widest: f32,
    },
}

/// Which part of its plane a picture shows, in the unit of the [`Projection`].
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

/// A camera, and the part of its picture that is rendered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The pinhole, the middle of the lens, or of the plane that parallel rays start from.
    pub position: Vec3,
    /// Viewing direction, unit.
    pub forward: Vec3,
    /// Towards the right edge of the picture, unit.
    pub right: Vec3,
    /// Towards the upper edge, unit.
    pub up: Vec3,
    /// How places in the picture become rays.
    pub projection: Projection,
    /// Which part of it is rendered.
    pub frame: Frame,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// What is nearer than this along the viewing axis (of panoramas: to the camera) is not there [scene unit], >= 0.
    pub near: f32,
    /// None: a pinhole.
    pub lens: Option<Lens>,
}

impl Camera {
    /// Pixels down of a picture of the same shape that is so many pixels wide; at least 1.
    pub fn height_for(&self, width: u32) -> u32 {
        let height = f64::from(self.height) * f64::from(width) / f64::from(self.width);
        (height.round() as u32).max(1)
    }

    /// Scales the picture to a width; the height follows.
    pub fn set_width(&mut self, width: u32) {
        let height = self.height_for(width);
        if let Frame::Part { step, .. } = &mut self.frame {
            step[0] *= self.width as f32 / width as f32;
            step[1] *= self.height as f32 / height as f32;
        }
        (self.width, self.height) = (width, height);
    }

    /// The ray through the picture point `(x, y)` in pixels, (0, 0) = upper left corner: where it starts, and its unit direction.
    ///
    /// - `lens`: two numbers in [0, 1), even ones for even places in the lens; (0, 0) is its middle. Without a lens they do not count.
    pub fn ray(&self, x: f32, y: f32, lens: [f32; 2]) -> (Vec3, Vec3) {
        let mut direction = self.direction(x, y);
        let mut origin = self.position;
        if self.projection == Projection::Orthographic {
            let [h, v] = self.place(x, y);
            origin += h * self.right + v * self.up;
        }
        if let Some(opening) = &self.lens {
            let [across, up] = opening.place(lens);
            let [right, above] = self.lens_axes(direction);
            let offset = across * right + up * above;
            let sharp = opening.focus_distance / self.depth_along(direction) * direction;
            origin += offset;
            direction = (sharp - offset).normalize();
        }
        if self.near > 0.0 {
            origin += self.near / self.depth_along(direction) * direction;
        }
        (origin, direction)
    }

    /// Unit direction of the ray through the picture point `(x, y)` and the middle of the lens.
    pub fn direction(&self, x: f32, y: f32) -> Vec3 {
        let [h, v] = self.place(x, y);
        match self.projection {
            Projection::Perspective => (self.forward + h * self.right + v * self.up).normalize(),
            Projection::Orthographic => self.forward,
            Projection::Equirectangular | Projection::Fisheye { .. } => self.around(h, v)[0],
        }
    }

    /// Whether there is a ray through the picture point `(x, y)`: a fisheye's picture is dark beyond its widest angle.
    pub fn sees(&self, x: f32, y: f32) -> bool {
        let Projection::Fisheye { widest } = self.projection else { return true };
        let [h, v] = self.place(x, y);
        h.hypot(v) <= widest
    }

    /// How the ray through `(x, y)` and the middle of the lens changes with a pixel to the right and a pixel down.
    pub fn pixel_steps(&self, x: f32, y: f32) -> [PixelStep; 2] {
        let direction = self.direction(x, y);
        let [across, down] = self.steps();
        let turned = match self.projection {
            Projection::Perspective => {
                // The directions are normalised: at distance 1 along the axis a pixel is this large, here it is seen from further away.
                let cosine = direction.dot(self.forward);
                [(self.right, across), (-self.up, down)].map(|(axis, pixel)| {
                    let moved = pixel * cosine * axis;
                    moved - moved.dot(direction) * direction
                })
            }
            Projection::Orthographic => {
                let [right, below] = [across * self.right, -down * self.up];
                return [right, below].map(|origin| PixelStep { origin, direction: Vec3::ZERO });
            }
            Projection::Equirectangular | Projection::Fisheye { .. } => {
                let [h, v] = self.place(x, y);
                let [_, by_h, by_v] = self.around(h, v);
                [across * by_h, -down * by_v]
            }
        };
        let start = self.near / self.depth_along(direction);
        turned.map(|direction| PixelStep { origin: start * direction, direction })
    }

    /// How much farther along the viewing axis a unit along a ray gets; of panoramas, how much farther from the camera. > 0.
    pub(crate) fn depth_along(&self, direction: Vec3) -> f32 {
        match self.projection {
            Projection::Perspective | Projection::Orthographic => direction.dot(self.forward),
            Projection::Equirectangular | Projection::Fisheye { .. } => 1.0,
        }
    }

    /// Radius that the lens blurs a point to which is at some depth, as [`Camera::depth_along`] counts it [pixels]; 0 without a lens.
    pub(crate) fn blur(&self, depth: f32) -> f32 {
        let Some(lens) = &self.lens else { return 0.0 };
        let [across, down] = self.steps();
        let apart = match self.projection {
            Projection::Orthographic => (1.0 - depth / lens.focus_distance).abs(),
            _ => (lens.focus_distance.recip() - depth.max(1e-30).recip()).abs(),
        };
        lens.reach() * apart / across.min(down)
    }

    /// Where the rays through the picture's corners start.
    pub fn corners(&self) -> [Vec3; 4] {
        let (right, bottom) = (self.width as f32, self.height as f32);
        [(0.0, 0.0), (right, 0.0), (0.0, bottom), (right, bottom)].map(|(x, y)| self.ray(x, y, [0.0; 2]).0)
    }

    /// Side of a square as large as what the picture shows at some distance [scene unit].
    pub(crate) fn side_at(&self, distance: f32) -> f32 {
        let side = match self.frame {
            Frame::Middle { half_height } => {
                let aspect = self.width as f32 / self.height as f32;
                2.0 * half_height * aspect.sqrt()
            }
            Frame::Part { step: [across, down], .. } => {
                (self.width as f32 * across * (self.height as f32 * down)).sqrt()
            }
        };
        if self.projection == Projection::Orthographic { side } else { side * distance }
    }

    /// Whether a point's light is seen in one place only of the picture: through a pinhole that nothing is too near to, in perspective.
    pub fn is_pinhole(&self) -> bool {
        self.projection == Projection::Perspective && self.lens.is_none() && self.near == 0.0
    }

    /// The picture point of a world point, with its importance: the solid angle of the pixel there is
    /// `1 / importance` sr. None outside the picture or behind the camera, and for cameras that are no pinhole ([`Camera::is_pinhole`]).
    pub fn project(&self, point: Vec3) -> Option<(f32, f32, f32)> {
        let inside = |&(x, y, _): &(f32, f32, f32)| {
            x >= 0.0 && y >= 0.0 && x < self.width as f32 && y < self.height as f32
        };
        self.image(point).filter(inside)
    }

    /// The same of what may lie beside the picture.
    pub(crate) fn image(&self, point: Vec3) -> Option<(f32, f32, f32)> {
        if !self.is_pinhole() {
            return None;
        }
        let offset = point - self.position;
        let depth = offset.dot(self.forward);
        if depth <= 0.0 {
            return None;
        }
        let [across, down] = self.steps();
        let [h, v] = [offset.dot(self.right), offset.dot(self.up)];
        let (x, y) = match self.frame {
            Frame::Middle { .. } => (
                h / (depth * across) + 0.5 * self.width as f32,
                0.5 * self.height as f32 - v / (depth * down),
            ),
            Frame::Part { left, top, .. } => ((h / depth - left) / across, (top - v / depth) / down),
        };
        let cosine = depth / offset.length();
        Some((x, y, 1.0 / (across * down * cosine * cosine * cosine)))
    }

    /// A pixel's width and height.
    fn steps(&self) -> [f32; 2] {
        match self.frame {
            Frame::Middle { half_height } => [2.0 * half_height / self.height as f32; 2],
            Frame::Part { step, .. } => step,
        }
    }

    /// (h, v) of a picture point.
    fn place(&self, x: f32, y: f32) -> [f32; 2] {
        let [across, down] = self.steps();
        match self.frame {
            Frame::Middle { .. } => {
                [(x - 0.5 * self.width as f32) * across, (0.5 * self.height as f32 - y) * down]
            }
            Frame::Part { left, top, .. } => [left + x * across, top - y * down],
        }
    }

    /// The direction of a panorama at (h, v), and its derivatives by both.
    fn around(&self, h: f32, v: f32) -> [Vec3; 3] {
        let Self { forward, right, up, .. } = *self;
        if self.projection == Projection::Equirectangular {
            let ((sine_h, cosine_h), (sine_v, cosine_v)) = (h.sin_cos(), v.sin_cos());
            let level = cosine_h * forward + sine_h * right;
            let east = cosine_h * right - sine_h * forward;
            return [cosine_v * level + sine_v * up, cosine_v * east, cosine_v * up - sine_v * level];
        }
        let angle = h.hypot(v);
        let (sine, cosine) = angle.sin_cos();
        // sin(r)/r, and the direction in the picture from its middle; there any one will do.
        let (sinc, [x, y]) =
            if angle > 0.0 { (sine / angle, [h / angle, v / angle]) } else { (1.0, [1.0, 0.0]) };
        let (outward, aside) = (x * right + y * up, x * up - y * right);
        let by_angle = cosine * outward - sine * forward;
        [cosine * forward + sine * outward, x * by_angle - y * sinc * aside, y * by_angle + x * sinc * aside]
    }

    /// To the right and up in the plane of the lens, which panoramas turn towards each ray.
    fn lens_axes(&self, direction: Vec3) -> [Vec3; 2] {
        match self.projection {
            Projection::Perspective | Projection::Orthographic => [self.right, self.up],
            Projection::Equirectangular | Projection::Fisheye { .. } => {
                let turn = Quat::from_rotation_arc(self.forward, direction);
                [turn * self.right, turn * self.up]
            }
        }
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
        let (projection, frame) = (Projection::Perspective, Frame::Middle { half_height: 0.3 });
        Camera {
            position,
            forward,
            right,
            up,
            projection,
            frame,
            width: 96,
            height: 64,
            near: 0.0,
            lens: None,
        }
    }

    /// The same as others, and as a part that shows the same.
    fn cameras() -> Vec<Camera> {
        let middle = camera();
        let half_height = 0.3;
        let step = [0.02, 0.015];
        let part = Frame::Part { left: -0.7, top: 0.4, step };
        [Projection::Perspective, Projection::Orthographic, Projection::Equirectangular, FISHEYE]
            .into_iter()
            .flat_map(|projection| {
                [Frame::Middle { half_height }, part].map(|frame| Camera { projection, frame, ..middle })
            })
            .collect()
    }

    const FISHEYE: Projection = Projection::Fisheye { widest: std::f32::consts::PI };

    const POINTS: [(f32, f32); 5] = [(0.5, 0.5), (95.5, 0.5), (10.25, 63.5), (48.0, 32.0), (70.0, 12.0)];

    #[test]
    fn a_part_of_a_picture_shows_what_the_whole_shows_there() {
        let whole = camera();
        let pixel = 2.0 * 0.3 / 64.0;
        let frame = Frame::Part { left: (13.0 - 48.0) * pixel, top: (32.0 - 5.0) * pixel, step: [pixel; 2] };
        let part = Camera { frame, width: 40, height: 20, ..whole };
        for (x, y) in [(0.0, 0.0), (40.0, 20.0), (7.5, 3.5)] {
            let (found, expected) = (part.direction(x, y), whole.direction(x + 13.0, y + 5.0));
            assert!((found - expected).length() < 3e-7, "{found} for {expected}");
            let (px, py, importance) = part.project(part.position + 3.0 * found).unwrap_or((x, y, 0.0));
            assert!((px - x).abs() < 1e-3 && (py - y).abs() < 1e-3);
            let (_, _, same) = whole.project(part.position + 3.0 * expected).expect("in view");
            assert!(importance == 0.0 || (importance / same - 1.0).abs() < 1e-5);
        }
    }

    #[test]
    fn a_picture_of_another_width_shows_the_same() {
        for camera in cameras() {
            let mut wide = camera;
            wide.set_width(192);
            assert_eq!((wide.width, wide.height), (192, 128));
            for (x, y) in POINTS {
                let (a, b) = (camera.ray(x, y, [0.0; 2]), wide.ray(2.0 * x, 2.0 * y, [0.0; 2]));
                assert!((a.0 - b.0).length() < 1e-6 && (a.1 - b.1).length() < 1e-6, "{camera:?}");
            }
        }
    }

    #[test]
    fn parallel_rays_start_in_a_plane_and_fisheyes_and_maps_of_all_around_measure_angles() {
        let [forward, right, up] = [camera().forward, camera().right, camera().up];
        let of =
            |projection, half_height| Camera { projection, frame: Frame::Middle { half_height }, ..camera() };
        let parallel = of(Projection::Orthographic, 2.0);
        let (origin, direction) = parallel.ray(96.0, 0.0, [0.0; 2]);
        assert_eq!(direction, forward);
        // Half of 2 x 2 high, 3 x 2 wide.
        assert!((origin - (parallel.position + 3.0 * right + 2.0 * up)).length() < 1e-5);

        let half_turn = std::f32::consts::PI;
        let map = Camera { width: 128, ..of(Projection::Equirectangular, 0.5 * half_turn) };
        for (x, y, expected) in [
            (64.0, 32.0, forward),
            (96.0, 32.0, right),
            (32.0, 32.0, -right),
            (0.0, 32.0, -forward),
            (17.0, 0.0, up),
            (90.0, 64.0, -up),
            (64.0, 16.0, (forward + up).normalize()),
        ] {
            assert!((map.direction(x, y) - expected).length() < 1e-6, "({x}, {y})");
        }

        let fisheye = of(FISHEYE, 1.6);
        for (x, y) in POINTS {
            let angle = (x - 48.0).hypot(y - 32.0) * 1.6 / 32.0;
            let direction = fisheye.direction(x, y);
            let outward = ((x - 48.0) * right + (32.0 - y) * up).normalize_or_zero();
            let expected = angle.cos() * forward + angle.sin() * outward;
            assert!((direction - expected).length() < 1e-6, "({x}, {y})");
        }
    }

    #[test]
    fn pixels_of_a_map_of_all_around_cover_the_sphere() {
        let half_height = std::f32::consts::FRAC_PI_2;
        let frame = Frame::Middle { half_height };
        let map = Camera { projection: Projection::Equirectangular, frame, width: 128, ..camera() };
        let area = |pixel: u32| {
            let [right, down] = map.pixel_steps((pixel % 128) as f32 + 0.5, (pixel / 128) as f32 + 0.5);
            f64::from(right.direction.cross(down.direction).length())
        };
        let sum: f64 = (0..128 * 64).map(area).sum();
        // The midpoint rule over the latitude: (π/64)²/24.
        assert!((sum / (4.0 * std::f64::consts::PI) - 1.0).abs() < 2e-4, "{sum}");
    }

    #[test]
    fn steps_are_the_differences_of_rays() {
        for plain in cameras() {
            for camera in [plain, Camera { near: 0.8, ..plain }] {
                for (x, y) in POINTS {
                    let (_, direction) = camera.ray(x, y, [0.0; 2]);
                    let across = |v: Vec3| v - v.dot(direction) * direction;
                    let steps = camera.pixel_steps(x, y);
                    for (step, [dx, dy]) in steps.iter().zip([[0.5, 0.0], [0.0, 0.5]]) {
                        let [a, b] = [-1.0, 1.0].map(|s| camera.ray(x + s * dx, y + s * dy, [0.0; 2]));
                        let size = (b.0 - a.0).length().max((b.1 - a.1).length());
                        // Positions of 3 units have roundings of 2e-7, a pixel has a hundredth; its square over 24.
                        assert!(
                            (across(b.1 - a.1) - step.direction).length() < 1e-4 * size + 2e-7,
                            "{camera:?}"
                        );
                        let moved = across(b.0 - a.0);
                        assert!((moved - across(step.origin)).length() < 1e-4 * size + 6e-7, "{camera:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn rays_through_all_of_a_lens_meet_where_it_is_sharp() {
        for plain in cameras() {
            let lens = Lens { radius: 0.3, focus_distance: 2.5, blades: 5, rotation: 0.2, ratio: 0.8 };
            let camera = Camera { lens: Some(lens), ..plain };
            for (x, y) in POINTS {
                let (start, middle) = plain.ray(x, y, [0.0; 2]);
                let sharp = start + 2.5 / plain.depth_along(middle) * middle;
                for [u, v] in [[0.0, 0.0], [0.3, 0.7], [0.99, 0.1], [0.6, 0.5]] {
                    let (origin, direction) = camera.ray(x, y, [u, v]);
                    let along = (sharp - origin).dot(direction);
                    assert!((origin + along * direction - sharp).length() < 2e-6, "{camera:?}");
                    assert!((origin - start).length() <= 0.3 / 0.8 + 1e-6, "inside of the lens");
                    let axis = if plain.depth_along(middle) == 1.0 { middle } else { plain.forward };
                    assert!((origin - start).dot(axis).abs() < 1e-6, "{camera:?}");
                    // A near plane cuts the same ray.
                    let (cut, same) = Camera { near: 0.7, ..camera }.ray(x, y, [u, v]);
                    assert_eq!(same, direction);
                    assert!(((cut - start).dot(axis) - 0.7).abs() < 1e-5 || plain.depth_along(middle) == 1.0);
                    assert!(((cut - origin).cross(direction)).length() < 1e-6);
                }
            }
        }
    }

    #[test]
    fn what_is_blurred_is_as_wide_as_rays_through_the_lens_are_apart() {
        for plain in cameras() {
            let lens = Lens { radius: 0.05, focus_distance: 2.5, blades: 0, rotation: 0.0, ratio: 0.5 };
            let camera = Camera { lens: Some(lens), ..plain };
            // Straight ahead, seen from the widest place of the lens and from its middle.
            let (x, y) = match camera.frame {
                Frame::Middle { .. } => (48.0, 32.0),
                Frame::Part { left, top, step } => (-left / step[0], top / step[1]),
            };
            let pixel = camera.pixel_steps(x, y);
            for depth in [0.5, 2.5, 10.0] {
                let apart = |v: f32| {
                    let (origin, direction) = camera.ray(x, y, [1.0 - f32::EPSILON, v]);
                    let place = origin + depth / direction.dot(camera.forward) * direction - camera.position;
                    (place - place.dot(camera.forward) * camera.forward).length()
                };
                let widest = apart(0.0).max(apart(0.25));
                let [across, down] = pixel.map(|step| (step.origin + depth * step.direction).length());
                let (found, expected) = (camera.blur(depth), widest / across.min(down));
                // Positions of 3 units have roundings of 2e-7, pixels a hundredth of the depth.
                assert!(
                    (found - expected).abs() <= 1e-3 * expected + 2e-4,
                    "{found} for {expected}: {camera:?}"
                );
            }
        }
    }

    #[test]
    fn a_fisheye_is_dark_beyond_its_widest_angle_and_nothing_else_is() {
        for camera in cameras() {
            assert!(POINTS.iter().all(|(x, y)| camera.sees(*x, *y)), "{camera:?}");
        }
        // A circle of 20 pixels around (35, 80/3), as its pixels are no squares: 20 across and 26.67 down.
        let step = [0.02, 0.015];
        let frame = Frame::Part { left: -0.7, top: 0.4, step };
        let camera = Camera { projection: Projection::Fisheye { widest: 0.4 }, frame, ..camera() };
        for (x, y, sees) in [
            (35.0, 26.7, true),
            (15.1, 26.7, true),
            (14.9, 26.7, false),
            (35.0, 53.2, true),
            (35.0, 53.4, false),
            (20.0, 8.0, false),
        ] {
            assert_eq!(camera.sees(x, y), sees, "({x}, {y})");
        }
    }

    #[test]
    fn only_a_pinhole_has_one_place_for_a_point() {
        let lens = Lens { radius: 0.3, focus_distance: 2.5, blades: 0, rotation: 0.0, ratio: 1.0 };
        let point = camera().position + 3.0 * camera().forward;
        assert!(camera().is_pinhole() && camera().project(point).is_some());
        for other in [
            Camera { lens: Some(lens), ..camera() },
            Camera { near: 0.1, ..camera() },
            Camera { projection: Projection::Orthographic, ..camera() },
            Camera { projection: Projection::Equirectangular, ..camera() },
            Camera { projection: FISHEYE, ..camera() },
        ] {
            assert!(!other.is_pinhole() && other.project(point).is_none());
        }
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
