//! Cameras: the rays that a picture is made of.

mod frame;
mod lens;
mod projection;

pub use frame::Frame;
pub use lens::Lens;
pub use projection::Projection;

use covbeam::PixelStep;
use glam::{DVec3, Vec3};
use projection::View;

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
    /// Whether a host says where its rays go; what is said here is an estimate then.
    pub is_own: bool,
}

impl Camera {
    /// Pixels down of a picture of the same shape that is so many pixels wide; at least 1.
    pub fn height_for(&self, width: u32) -> u32 {
        let height = f64::from(self.height) * f64::from(width) / f64::from(self.width);
        (height.round() as u32).max(1)
    }

    /// Scales the picture to a width; the height follows.
    pub fn set_width(&mut self, width: u32) {
        let before = self.size();
        (self.width, self.height) = (width, self.height_for(width));
        self.frame.resize(before, self.size());
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
            let [right, above] = self.projection.lens_axes(&self.view(), direction);
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
        self.projection.direction(&self.view(), self.place(x, y))
    }

    /// Whether there is a ray through the picture point `(x, y)`: a fisheye's picture is dark beyond its widest angle.
    pub fn sees(&self, x: f32, y: f32) -> bool {
        self.projection.sees(self.place(x, y))
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
                let [_, by_h, by_v] = self.projection.around(&self.view(), self.place(x, y));
                [across * by_h, -down * by_v]
            }
        };
        let start = self.near / self.depth_along(direction);
        turned.map(|direction| PixelStep { origin: start * direction, direction })
    }

    /// How much farther along the viewing axis a unit along a ray gets; of panoramas, how much farther from the camera. > 0.
    pub(crate) fn depth_along(&self, direction: Vec3) -> f32 {
        self.projection.depth_along(&self.view(), direction)
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
        let [right, bottom] = self.size();
        [(0.0, 0.0), (right, 0.0), (0.0, bottom), (right, bottom)].map(|(x, y)| self.ray(x, y, [0.0; 2]).0)
    }

    /// Side of a square as large as what the picture shows at some distance [scene unit].
    pub(crate) fn side_at(&self, distance: f32) -> f32 {
        let side = self.frame.side(self.size());
        if self.projection == Projection::Orthographic { side } else { side * distance }
    }

    /// Whether a point's light is seen in one place only of the picture: through a pinhole that nothing is too near to, in perspective.
    pub fn is_pinhole(&self) -> bool {
        self.projection == Projection::Perspective && self.lens.is_none() && self.near == 0.0 && !self.is_own
    }

    /// The picture point of a world point, with its importance: the solid angle of the pixel there is
    /// `1 / importance` sr. None outside the picture or behind the camera, and for cameras that are no pinhole ([`Camera::is_pinhole`]).
    pub fn project(&self, point: Vec3) -> Option<(f32, f32, f32)> {
        if !self.is_pinhole() {
            return None;
        }
        let [x, y] = self.seen_at(point)?;
        let is_inside = x >= 0.0 && y >= 0.0 && x < self.width as f32 && y < self.height as f32;
        let [across, down] = self.steps();
        let offset = point - self.position;
        let cosine = offset.dot(self.forward) / offset.length();
        is_inside.then(|| (x, y, 1.0 / (across * down * cosine * cosine * cosine)))
    }

    /// The picture point, which may lie beside the picture, where a world point is seen through the middle of the lens, in perspective; None: it is
    /// behind the camera.
    fn seen_at(&self, point: Vec3) -> Option<[f32; 2]> {
        let offset = point - self.position;
        let depth = offset.dot(self.forward);
        let place = [offset.dot(self.right), offset.dot(self.up)];
        (depth > 0.0).then(|| self.frame.point(self.size(), place, depth))
    }

    /// Corners of a box in the picture [pixels], which may lie beside it; None: some of it is behind the camera, or the camera does not see in
    /// perspective.
    pub(crate) fn footprint(&self, min: DVec3, max: DVec3) -> Option<[[f32; 2]; 2]> {
        if self.projection != Projection::Perspective || self.is_own {
            return None;
        }
        let (mut low, mut high) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]);
        for corner in 0..8 {
            let side = |axis: usize| if corner >> axis & 1 == 0 { min[axis] } else { max[axis] };
            let corner = self.seen_at(DVec3::new(side(0), side(1), side(2)).as_vec3())?;
            for (axis, at) in corner.into_iter().enumerate() {
                (low[axis], high[axis]) = (low[axis].min(at), high[axis].max(at));
            }
        }
        Some([low, high])
    }

    /// Numbers, row by row, of the pixels that a part of the picture plane lies in which is larger by a margin all around [pixels].
    pub(crate) fn pixels_within(&self, [low, high]: [[f32; 2]; 2], margin: f32) -> impl Iterator<Item = u32> {
        let ends = |axis: usize, end: u32| {
            let last = (high[axis] + margin).min(end as f32 - 1.0);
            (low[axis] - margin).max(0.0) as u32..(last + 1.0).max(0.0) as u32
        };
        let (width, columns) = (self.width, ends(0, self.width));
        ends(1, self.height).flat_map(move |y| columns.clone().map(move |x| y * width + x))
    }

    fn view(&self) -> View {
        View { forward: self.forward, right: self.right, up: self.up }
    }

    /// Pixels across and down.
    fn size(&self) -> [f32; 2] {
        [self.width as f32, self.height as f32]
    }

    /// A pixel's width and height.
    fn steps(&self) -> [f32; 2] {
        self.frame.step(self.size())
    }

    /// (h, v) of a picture point.
    fn place(&self, x: f32, y: f32) -> [f32; 2] {
        self.frame.place(self.size(), [x, y])
    }
}

#[cfg(test)]
mod tests;
