//! Regions of pictures in which errors are reported.

use covbeam_session::color::luminance;
use covbeam_session::film::Picture;

/// Pixels darker than this share of the picture's mean are neither sharp nor smooth: their changes are noise.
const DARK: f64 = 0.01;

/// Distance of the pixels whose difference tells how sharp the picture is.
const REACH: i64 = 2;

/// Share of the pixels that are not dark that counts as sharp, and as smooth.
const SHARP: f64 = 0.2;
const SMOOTH: f64 = 0.5;

/// A named set of pixels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Region {
    /// Name.
    pub name: &'static str,
    width: u32,
    pixels: Vec<bool>,
}

impl Region {
    /// Whether pixel (x, y) belongs to it; (0, 0) = upper left.
    ///
    /// # Panics
    /// Outside the picture.
    pub fn contains(&self, x: u32, y: u32) -> bool {
        self.pixels[(y * self.width + x) as usize]
    }

    /// Number of its pixels.
    pub fn count(&self) -> usize {
        self.pixels.iter().filter(|inside| **inside).count()
    }

    fn new(name: &'static str, width: u32, height: u32, contains: impl Fn(u32, u32) -> bool + Copy) -> Self {
        let row = |y: u32| (0..width).map(move |x| contains(x, y));
        Self { name, width, pixels: (0..height).flat_map(row).collect() }
    }
}

/// The whole picture.
pub fn whole(width: u32, height: u32) -> Region {
    Region::new("whole", width, height, |_, _| true)
}

/// Regions of any scene, read off its reference: `whole`, `smooth`, `sharp`.
///
/// On the reference averaged over 3x3 pixels, a pixel's change is the length of the vector of the luminance's differences
/// between the pixels 2 to the right and 2 to the left, and 2 below and 2 above, over its own luminance (beyond the
/// picture's border: the nearest pixel). Pixels below 1 % of the mean are left out. Of the others, `sharp` is
/// the fifth that changes most, `smooth` the half that changes least.
pub fn by_sharpness(reference: &Picture) -> [Region; 3] {
    let (width, height) = (reference.width, reference.height);
    let columns = i64::from(width);
    let nearest = |x: i64, y: i64| {
        let (x, y) = (x.clamp(0, columns - 1), y.clamp(0, i64::from(height) - 1));
        (y * columns + x) as usize
    };
    let place = |index: usize| (index as i64 % columns, index as i64 / columns);
    let blurred: Vec<f64> = (0..reference.radiance.len())
        .map(|index| {
            let (x, y) = place(index);
            let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (x + dx, y + dy)));
            around.map(|(x, y)| f64::from(luminance(reference.radiance[nearest(x, y)]))).sum::<f64>() / 9.0
        })
        .collect();
    let change = |index: usize| {
        let (x, y) = place(index);
        let across = blurred[nearest(x + REACH, y)] - blurred[nearest(x - REACH, y)];
        let down = blurred[nearest(x, y + REACH)] - blurred[nearest(x, y - REACH)];
        across.hypot(down) / blurred[index]
    };
    let mean = blurred.iter().sum::<f64>() / blurred.len() as f64;
    let mut lit: Vec<(usize, f64)> = (0..blurred.len())
        .filter(|index| blurred[*index] > 0.0 && blurred[*index] >= DARK * mean)
        .map(|index| (index, change(index)))
        .collect();
    lit.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
    let part = |name, chosen: &[(usize, f64)]| {
        let mut pixels = vec![false; blurred.len()];
        chosen.iter().for_each(|(index, _)| pixels[*index] = true);
        Region { name, width, pixels }
    };
    let share = |share: f64| (share * lit.len() as f64).round() as usize;
    [
        whole(width, height),
        part("smooth", &lit[..share(SMOOTH)]),
        part("sharp", &lit[lit.len() - share(SHARP)..]),
    ]
}

/// Regions in which errors of a scene's pictures are told: [`by_sharpness`], and in the ball scenes `volume`, `caustic` and
/// `glass`; those that have pixels.
pub fn of_scene(name: &str, reference: &Picture) -> Vec<Region> {
    let mut regions = by_sharpness(reference).to_vec();
    if is_ball(name) && reference.width == reference.height {
        let named = of_ball(reference.width).into_iter();
        regions.extend(named.filter(|region| ["volume", "caustic", "glass"].contains(&region.name)));
    }
    regions.retain(|region| region.count() > 0);
    regions
}

/// Whether a scene's pictures have the places that [`of_ball`] names.
pub fn is_ball(name: &str) -> bool {
    ["glass-ball", "black-ball"].contains(&name)
}

/// Regions of the pictures of the glass-ball and black-ball scenes, which are square. The ball is in the middle, with a
/// radius of 40.8 pixels of 256.
///
/// `volume`: fog in front of the walls, outside the ball; `smooth`: the part of it more than half a ball's radius away from the
/// ball's silhouette; `caustic`: the volumetric caustic below the ball and the floor behind it; `glass`: what is seen
/// through the ball; `floor`: rows that see the floor, outside the caustic.
pub fn of_ball(size: u32) -> [Region; 6] {
    // Numbers below are pixels of a picture 256 wide.
    let at = move |pixel: u32| (pixel as f32 + 0.5) * 256.0 / size as f32;
    let from_ball = move |x, y| (at(x) - 128.0).hypot(at(y) - 128.0);
    let below = move |x: u32| (116.0..140.0).contains(&at(x));
    [
        whole(size, size),
        Region::new("volume", size, size, |x, y| at(y) < 165.0 && from_ball(x, y) > 43.0),
        Region::new("smooth", size, size, |x, y| at(y) < 165.0 && from_ball(x, y) > 61.0),
        Region::new("caustic", size, size, |x, y| (172.0..236.0).contains(&at(y)) && below(x)),
        Region::new("glass", size, size, |x, y| from_ball(x, y) < 40.0),
        Region::new("floor", size, size, |x, y| at(y) >= 180.0 && !below(x)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn picture(width: u32, height: u32, value: impl Fn(u32, u32) -> f32) -> Picture {
        let pixels = (0..width * height).map(|i| Vec3::splat(value(i % width, i / width)));
        Picture { width, height, radiance: pixels.collect(), ..Picture::default() }
    }

    #[test]
    fn the_fifth_around_an_edge_is_sharp_and_the_half_away_from_it_is_smooth() {
        // An edge between columns 14 and 15 of 30; blurred by 1 and compared over 2 to each side, it is felt by three
        // columns on each side of it: exactly a fifth. A ramp down the rows, weaker than the edge, orders the others.
        let ramp = |y: u32| 1.0 + 0.001 * (y * y) as f32;
        let reference = picture(30, 20, |x, y| if x < 15 { 1.0 } else { 2.0 } * ramp(y));
        let [whole, smooth, sharp] = by_sharpness(&reference);
        assert_eq!((whole.count(), smooth.count(), sharp.count()), (600, 300, 120));
        for y in 0..20 {
            for x in 0..30 {
                assert_eq!(sharp.contains(x, y), (12..18).contains(&x), "({x}, {y})");
                assert!(!(smooth.contains(x, y) && sharp.contains(x, y)));
            }
        }
        // The half of 20 rows is 12 or 13 of these columns' rows: the last two, where the picture ends, and the first ones.
        assert!((0..9).all(|y| smooth.contains(2, y) && smooth.contains(27, y)));
        assert!((11..18).all(|y| !smooth.contains(2, y) && !smooth.contains(27, y)));
    }

    #[test]
    fn a_change_counts_in_proportion_to_the_light() {
        // Steps of the same height on a bright and on a dim ground, 40 rows apart.
        let step = |x: u32| if x < 10 { 0.0 } else { 0.3 };
        let reference = picture(20, 80, |x, y| step(x) + if y < 40 { 10.0 } else { 1.0 });
        let [_, _, sharp] = by_sharpness(&reference);
        assert!(!sharp.contains(10, 20) && sharp.contains(10, 60));
    }

    #[test]
    fn dark_pixels_are_neither_sharp_nor_smooth() {
        // Mean 0.5; the right half holds 1e-3 of it or less, however it changes.
        let reference = picture(40, 10, |x, _| if x < 20 { 1.0 } else { 5e-4 * (x % 2) as f32 });
        let [_, smooth, sharp] = by_sharpness(&reference);
        for y in 0..10 {
            // Column 20 shares in the light of column 19.
            for x in 21..40 {
                assert!(!smooth.contains(x, y) && !sharp.contains(x, y), "({x}, {y})");
            }
        }
        assert_eq!((smooth.count(), sharp.count()), (105, 42), "a half and a fifth of 21 columns");
    }

    #[test]
    fn the_regions_of_the_ball_keep_their_places_at_other_sizes() {
        for (large, small) in of_ball(256).iter().zip(of_ball(64)) {
            let ratio = large.count() as f32 / small.count() as f32;
            // Borders of a pixel at most, on regions at least 6 pixels wide at the smaller size.
            assert!((ratio / 16.0 - 1.0).abs() < 0.1, "{}: {ratio}", large.name);
        }
        let [_, volume, smooth, caustic, glass, floor] = of_ball(256);
        assert!(glass.contains(128, 128) && !volume.contains(128, 128));
        assert!(volume.contains(128, 80) && !smooth.contains(128, 80) && smooth.contains(128, 60));
        assert!(caustic.contains(116, 172) && caustic.contains(139, 235) && !caustic.contains(140, 200));
        assert!(floor.contains(115, 180) && !floor.contains(116, 180) && !floor.contains(10, 179));
    }
}
