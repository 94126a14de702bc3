//! Where eye rays start: at the camera, in its lens or in its plane, and inside of what.

use crate::eye::facet::Facet;
use crate::random::{Random, mix};
use crate::scene::Scene;
use crate::scene::optics::Interior;
use crate::surface::origin::Origin;
use covbeam::path_number;
use glam::Vec3;

/// Sequence of places in the lens.
const LENS_SEQUENCE: u32 = 0x001e_4500;

/// An eye ray where it starts.
#[derive(Clone, Copy, Debug)]
pub struct EyeStart {
    /// Where: what is nearer to the camera is not there.
    pub origin: Vec3,
    /// Unit.
    pub direction: Vec3,
    /// What it is inside of.
    pub interior: Interior,
    /// The picture point that it goes through \[pixels\].
    pub place: [f32; 2],
    /// Whether it is there: a picture may have dark places, see [`Camera::sees`](crate::camera::Camera::sees).
    pub sees: bool,
    /// By which it goes on from a rough surface, if that is the first it meets; None: by any.
    pub facet: Option<Facet>,
}

/// Where eye rays of a scene start.
#[derive(Clone, Copy)]
pub struct EyeStarts<'a> {
    scene: &'a Scene,
    camera: Origin,
}

impl<'a> EyeStarts<'a> {
    /// Those of a scene.
    pub fn new(scene: &'a Scene) -> Self {
        Self { scene, camera: Origin::new(scene, scene.camera.position) }
    }

    /// What the camera's position is inside of.
    pub fn interior(&self) -> Interior {
        self.camera.interior()
    }

    /// The eye ray through a picture point and a place in the lens, as [`Camera::ray`](crate::camera::Camera::ray) or a host has them.
    pub fn at(&self, [x, y]: [f32; 2], lens: [f32; 2]) -> EyeStart {
        let camera = &self.scene.camera;
        let host = self.scene.host().filter(|_| camera.is_own);
        let own = host.and_then(|host| host.eye([x, y], lens));
        let (origin, direction) = own.unwrap_or_else(|| camera.ray(x, y, lens));
        let sees = if host.is_some() { own.is_some() } else { camera.sees(x, y) };
        // What is too near to be seen bounds media all the same.
        let (origin, interior) = self.camera.beside(self.scene, origin, direction);
        EyeStart { origin, direction, interior, place: [x, y], sees, facet: None }
    }

    /// Where an eye ray of a pinhole starts that goes along an offset of any length, and what it is inside of there.
    pub(crate) fn towards(&self, offset: Vec3) -> (Vec3, Interior) {
        self.camera.towards(self.scene, offset)
    }

    /// The same through the middle of a pixel and of the lens.
    pub fn middle(&self, x: u32, y: u32) -> EyeStart {
        self.at([x as f32 + 0.5, y as f32 + 0.5], [0.0; 2])
    }

    /// The same through some place in the lens.
    pub(crate) fn anywhere(&self, point: [f32; 2], random: &mut Random) -> EyeStart {
        self.at(point, if self.has_lens() { [random.uniform(), random.uniform()] } else { [0.0; 2] })
    }

    /// Whether it matters where in the lens rays start: of a host's camera nobody else knows.
    fn has_lens(&self) -> bool {
        self.scene.camera.lens.is_some() || self.scene.camera.is_own
    }

    /// A place in the lens for a pixel: even over the looks that this takes through it, numbered on over the passes.
    pub(crate) fn place_in_lens(&self, seed: u32, pixel: u32, look: u32) -> [f32; 2] {
        if !self.has_lens() {
            return [0.0; 2];
        }
        // The same points for all pixels, turned differently in each.
        let turn = mix((u64::from(seed) << 32 | u64::from(pixel)) ^ u64::from(LENS_SEQUENCE));
        let turns = [(turn >> 32) as u32, turn as u32];
        [0, 1].map(|axis| {
            let turn = f64::from(turns[axis]) / 4_294_967_296.0;
            let point = f64::from(path_number(seed, LENS_SEQUENCE, look, axis as u32)) + turn;
            (point.fract() as f32).min(1.0 - f32::EPSILON)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Lens;
    use crate::scene::made::{Made, camera, point};

    #[test]
    fn looks_of_a_pixel_fill_the_lens_evenly_and_others_otherwise() {
        let camera = camera([0.0; 3], [0.0, 0.0, 1.0], 40.0, [4, 4]);
        let mut scene = Made::new(camera).light(point([0.0, 4.0, 0.0], 1.0)).scene();
        assert_eq!(EyeStarts::new(&scene).place_in_lens(1, 2, 3), [0.0; 2]);
        let lens = Lens { radius: 0.1, focus_distance: 1.0, blades: 0, rotation: 0.0, ratio: 1.0 };
        scene.camera.lens = Some(lens);
        let starts = EyeStarts::new(&scene);
        let (mut first, mut spread) = (Vec::new(), 0.0);
        for pixel in 0..50 {
            let mut cells = [0_i32; 16];
            for look in 0..64 {
                let [u, v] = starts.place_in_lens(7, pixel, look);
                cells[(4.0 * u) as usize * 4 + (4.0 * v) as usize] += 1;
            }
            let squares = cells.iter().map(|count| f64::from((count - 4) * (count - 4)));
            spread += squares.sum::<f64>() / (16.0 * 50.0);
            first.push(starts.place_in_lens(7, pixel, 0)[0]);
        }
        // Four in each cell, but for what turns move across the borders of cells. Of random places, 64 x 1/16 x 15/16.
        assert!(spread < 3.75 / 3.0, "{spread}");
        first.sort_by(f32::total_cmp);
        assert!(first.windows(2).all(|two| two[0] < two[1]), "each pixel has a turn of its own");
    }
}
