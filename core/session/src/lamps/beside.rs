//! Pixels beside lamps that have a size: across them light goes as one over the distance from the lamp, so that a few such pixels have nearly all of
//! the noise of straight light, and each is worth many eye rays.

use crate::scene::{Light, Scene};
use glam::DVec3;

/// Eye rays through such a pixel. With 16, 32 and 48 coloured fog around three spots has .83, .63 and .61 of the error at equal time, a rig of 60
/// .56, .49 and .54.
const LOOKS: u32 = 32;

/// Most of all of them, in pixels of the picture: else a thousand lamps slow passes down.
const MOST: usize = 8;

/// How far from a lamp pixels are beside it, in pixels.
const REACH: f32 = 2.0;

/// The most pixels that such a lamp lies across: light beside larger ones is about the same all over a pixel.
const MOST_ACROSS: f32 = 6.0;

/// The pixels of a picture that are beside lamps.
#[derive(Clone, Debug, Default)]
pub(crate) struct BesideLamps {
    /// Their numbers, row by row, rising.
    pixels: Vec<u32>,
    width: u32,
    looks: u32,
}

impl BesideLamps {
    pub(crate) fn new(scene: &Scene) -> Self {
        let (width, height) = (scene.camera.width, scene.camera.height);
        let footprints = scene.lights.iter().filter_map(|light| footprint(scene, light));
        let mut pixels: Vec<u32> =
            footprints.flat_map(|corners| scene.camera.pixels_within(corners, REACH)).collect();
        pixels.sort_unstable();
        pixels.dedup();
        let most = MOST * width as usize * height as usize / pixels.len().max(1);
        let looks = most.min(LOOKS as usize) as u32;
        Self { pixels, width, looks }
    }

    /// Eye rays that pixel (x, y) is worth; None: it is beside no lamp.
    pub(crate) fn looks(&self, [x, y]: [u32; 2]) -> Option<u32> {
        self.pixels.binary_search(&(y * self.width + x)).is_ok().then_some(self.looks)
    }
}

/// Corners in the picture of a lamp that is small there, but not a point.
fn footprint(scene: &Scene, light: &Light) -> Option<[[f32; 2]; 2]> {
    let (min, max) = match light {
        Light::Lamp(lamp) if light.has_size() => {
            let (middle, radius) = (lamp.position.as_dvec3(), DVec3::splat(lamp.radius.into()));
            (middle - radius, middle + radius)
        }
        light => light.extent()?,
    };
    let [low, high] = scene.camera.footprint(min, max)?;
    (high[0] - low[0] <= MOST_ACROSS && high[1] - low[1] <= MOST_ACROSS).then_some([low, high])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::made::{Made, camera};
    use glam::Vec3;

    /// Pixels around a ball of light of some radius at a place, seen from the origin along z in 64 pixels square that show 2 m 1 m away.
    fn beside(lamps: &[([f32; 3], f32)]) -> BesideLamps {
        let mut made = Made::new(camera([0.0; 3], [0.0, 0.0, 1.0], 90.0, [64, 64]));
        for &(center, radius) in lamps {
            made = made.light(Light::Sphere { center: Vec3::from(center), radius, radiance: Vec3::ONE });
        }
        BesideLamps::new(&made.scene())
    }

    #[test]
    fn pixels_two_around_a_small_lamp_are_beside_it() {
        // In a picture 64 wide and 48 high, whose 2 m up and down 1 m away are its height, a metre has 24 pixels. Looking along z with y up,
        // x points to the left: the lamp is at pixel (32 - 12, 24 - 6), and lies across a tenth of the pixels around.
        let lamp = Light::Sphere { center: Vec3::new(0.5, 0.25, 1.0), radius: 0.002, radiance: Vec3::ONE };
        let camera = camera([0.0; 3], [0.0, 0.0, 1.0], 90.0, [64, 48]);
        let beside = BesideLamps::new(&Made::new(camera).light(lamp).scene());
        for y in 0..48 {
            for x in 0..64 {
                let is_near = (17..23).contains(&x) && (15..21).contains(&y);
                assert_eq!(beside.looks([x, y]), is_near.then_some(LOOKS), "{x} {y}");
            }
        }
    }

    #[test]
    fn lamps_at_the_border_beside_the_picture_behind_the_camera_and_large_ones_are_none_or_cut() {
        let count = |lamp| beside(&[lamp]).pixels.len();
        assert_eq!(count(([1.0, 0.0, 1.0], 0.002)), 3 * 6);
        assert_eq!([count(([2.0, 0.0, 1.0], 0.002)), count(([0.0, 0.0, -1.0], 0.002))], [0; 2]);
        assert_eq!([count(([0.0, 0.0, 1.0], 0.2)), count(([0.0, 0.0, 0.1], 0.2))], [0; 2]);
    }

    #[test]
    fn lamps_all_over_the_picture_share_a_few_looks() {
        let lamps =
            (0..1024).map(|n| ([(n % 32) as f32 / 16.0 - 1.0, (n / 32) as f32 / 16.0 - 1.0, 1.0], 1e-3));
        let beside = beside(&lamps.collect::<Vec<_>>());
        assert_eq!((beside.pixels.len(), beside.looks), (64 * 64, MOST as u32));
    }
}
