//! How many light paths a pass has and how many branches these have: as many as lower the picture's noise more than they slow a pass down.
//!
//! A pass has a variance `rays` that its light paths do not change, of straight light and of edges inside of pixels, and `paths`, of the light
//! paths; it costs C for its eye rays and P for its paths and the pairs with their beams. With n times as many branches the product
//! of variance and cost is (rays + paths/n) (C + P n), least for n² = paths C/(rays P). From what guidance gives by itself they double as long as
//! that promises a tenth.

use super::instant::Poll;
use super::look::{LATTICE, LEAST_OF_PICTURE, Look, Memory};
use super::trial;
use crate::camera::Camera;
use crate::color::luminance;
use crate::paths::PhotonTracer;
use crate::random::Random;
use covbeam::Medium;
use rayon::prelude::*;

/// Guided light paths of either half.
const PATHS: u32 = 1024;

/// Purposes of random numbers, and sequences of light paths.
const KEY: u32 = 0x3b7a;

/// A pixel's relative variance counts for at most this much: of the rare bright pixel a thousand rays say nothing.
const MOST_SPREAD: f32 = 0.25;

/// And that of straight light, which has four looks where an edge crosses a pixel.
const MOST_STRAIGHT_SPREAD: f32 = MOST_SPREAD / 4.0;

/// Costs in microseconds: of a beam, with its part of the path, of the directions looked at and of the hierarchy; of a pair; of an eye ray,
/// which is 1.5 among walls and 3 to 7 among meshes; of a shadow ray. Only their ratios matter, and of these the square root.
const BEAM: f32 = 2.0;
const PAIR: f32 = 0.04;
const EYE_RAY: f32 = 2.5;
const SHADOW_RAY: f32 = 0.1;

/// Pairs of a pass' eye ray over those here, where kernels are wider: 0.2 to 0.5 in 32 scenes.
const PAIRS_OF_A_PASS: f32 = 0.35;

/// Paths get this many times what the formula says: the variance of straight light and of edges falls faster than with the passes, as
/// they fill lines and pixels evenly. With 1 voxels of smoke have 1.2 times the error; with 2 as many seconds leave leaves and posts 1.15 times.
const IN_FAVOUR: f32 = 1.5;

/// And no fewer branches than this.
const LEAST: f32 = 1.0 / 30.0;

/// Nor more: their beams are kept.
const MOST: f32 = 4.0;

/// Where a guided light path leaves fewer beams than this, as most of its light ends on what the camera does not see, a pass has as many more
/// paths: they cost little, and each is more like the others than its branches are. Of hall, posts, leaves and cards the error after 6 s falls
/// to .23, .30, .31 and .40 by it; with 4 in place of 3 to as much, with 2 to .24, .42, .41 and .49. The figurine and the glass ball, whose paths
/// leave about as many, have 1.8 and 1.2 times the error with four times the paths.
const BEAMS: f32 = 3.0;

/// Most times as many, and most where each has [`FEWEST_BRANCHES`] at least. In a hall whose sun comes through windows variance x CPU time falls to
/// .61 by 16 in place of 8, and to .49 by 24, at 128 pixels; at 1920 x 1080 it stays with 14, while passes take twice as long.
const MOST_PATHS: [f32; 2] = [8.0, 24.0];

/// Share of its branches that a path of so many keeps.
const FEWEST_BRANCHES: f32 = 0.2;

/// Most in all: their numbers are counted in 32 bits.
const MOST_IN_ALL: f64 = (1_u32 << 31) as f64;

/// From one on branches double as long as variance x cost falls to this by it: costs are known to a fifth.
const PAYS: f32 = 0.9;

/// What a thousand eye rays found.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Spread {
    /// Relative variance of a pixel that is not the light paths'.
    rays: f32,
    /// Relative variance of a pixel for one light path a pass.
    paths: f32,
    /// Beams of a light path.
    beams: f32,
    /// Pairs with the beams of one light path, of an eye ray.
    pairs: f32,
    /// Shadow rays of an eye ray, or what costs as much.
    shadow_rays: f32,
}

/// What the rays of a pixel saw.
struct Seen {
    /// Luminance with either set of paths, of either place: of straight light, and of all other.
    light: [[[f32; 2]; 2]; 2],
    pairs: u32,
    shadow_rays: u32,
}

impl Seen {
    /// Mean of the four rays.
    fn brightness(&self) -> f32 {
        0.25 * self.light.iter().flatten().flatten().sum::<f32>()
    }
}

impl Spread {
    /// Looks at a scene's picture. None where guided paths are worth less than plain ones. Cost: 12 to 70 core-milliseconds.
    /// `cancelled` as in [`super::guidance`].
    pub(crate) fn of(tracer: &PhotonTracer, fogs: &[Medium], cancelled: Poll) -> Option<Self> {
        let looks = looks(tracer, fogs, PATHS, cancelled);
        let worth = looks.each_ref().map(|look| look.worth.as_slice()).concat();
        let beams = looks.iter().map(|look| look.beams).sum();
        trial::pays(tracer.guidance()?, tracer.scene(), fogs, &worth, beams, cancelled)
            .then(|| spread(&looks, PATHS, cancelled))
    }

    /// Light paths a pass where `photons` are asked for: as many, or up to [`MOST_PATHS`] times as many where they leave few beams.
    pub(crate) fn paths(&self, photons: u32, camera: &Camera) -> u32 {
        let [often, most] = MOST_PATHS;
        let most = (best(self, photons as f32, pixels(camera)) / FEWEST_BRANCHES).clamp(often, most);
        let times = (BEAMS / self.beams).clamp(1.0, most);
        (f64::from(photons) * f64::from(times)).min(MOST_IN_ALL).round() as u32
    }

    /// The share of the branches that guided light paths should have, up to [`MOST`].
    ///
    /// - `photons`: light paths a pass.
    pub(crate) fn share_of_branches(&self, photons: u32, camera: &Camera) -> f32 {
        share(self, photons as f32, pixels(camera))
    }
}

fn pixels(camera: &Camera) -> f32 {
    (camera.width * camera.height) as f32
}

/// Costs of a pass in microseconds: of its eye rays, and of its light paths with all their branches.
fn costs(spread: &Spread, photons: f32, pixels: f32) -> [f32; 2] {
    let of_rays = pixels * (EYE_RAY + SHADOW_RAY * spread.shadow_rays);
    let of_paths = photons * (BEAM * spread.beams + PAIR * PAIRS_OF_A_PASS * spread.pairs * pixels);
    [of_rays, of_paths]
}

/// The share of branches by the formula: one over the number of light paths, so that these have as many together whatever their number.
fn best(spread: &Spread, photons: f32, pixels: f32) -> f32 {
    let [of_rays, of_paths] = costs(spread, photons, pixels);
    let square = spread.paths / photons * of_rays / (spread.rays * of_paths);
    // Without noise of either kind: as many as there are.
    if square.is_nan() { 1.0 } else { IN_FAVOUR * square.sqrt() }
}

fn share(spread: &Spread, photons: f32, pixels: f32) -> f32 {
    let best = best(spread, photons, pixels);
    if best <= 1.0 {
        return best.max(LEAST);
    }
    let [of_rays, of_paths] = costs(spread, photons, pixels);
    let paths = IN_FAVOUR * IN_FAVOUR * spread.paths / photons;
    let product = |share: f32| (spread.rays + paths / share) * (of_rays + of_paths * share);
    let mut share = 1.0;
    while share < MOST && product(2.0 * share) < PAYS * product(share) {
        share *= 2.0;
    }
    share
}

/// At the same picture, with two sets of `paths` light paths.
fn looks<'a>(
    tracer: &'a PhotonTracer<'a>,
    fogs: &'a [Medium<'a>],
    paths: u32,
    cancelled: Poll,
) -> [Look<'a>; 2] {
    [1, 2].map(|half| Look::new(tracer, fogs, [KEY + half, paths], half, cancelled))
}

/// Looks at some pixels from two places in each, with two sets of light paths: what differs from place to place with both sets is not the
/// paths' noise.
fn spread(looks: &[Look; 2], paths: u32, cancelled: Poll) -> Spread {
    let camera = &looks[0].scene.camera;
    let seen: Vec<Seen> = (0..LATTICE * LATTICE)
        .into_par_iter()
        .map_init(Memory::default, |memory, node| {
            (memory.pairs, memory.shadow_rays) = (0, 0);
            if cancelled() {
                return Seen { light: Default::default(), pairs: 0, shadow_rays: 0 };
            }
            let at = |index: u32, count: u32| ((index as f32 + 0.5) / LATTICE as f32 * count as f32).floor();
            let pixel = [at(node % LATTICE, camera.width), at(node / LATTICE, camera.height)];
            let light = looks.each_ref().map(|look| {
                [1, 2].map(|place| {
                    let mut random = Random::new([place, node, 0, KEY]);
                    let point = [pixel[0] + random.uniform(), pixel[1] + random.uniform()];
                    let start = look.starts.anywhere(point, &mut random);
                    let [straight, focused, scattered] =
                        look.radiance(&start, node, &mut random, memory).map(luminance);
                    [straight, focused + scattered]
                })
            });
            Seen { light, pairs: memory.pairs, shadow_rays: memory.shadow_rays }
        })
        .collect();
    let count = seen.len() as f32;
    let mean = seen.iter().map(Seen::brightness).sum::<f32>() / count;
    let mut sum = Spread::default();
    for pixel in &seen {
        let Seen { light, pairs, shadow_rays } = pixel;
        let brightness = pixel.brightness().max(LEAST_OF_PICTURE * mean);
        let product = |a: f32, b: f32| 0.5 * a / brightness * (b / brightness);
        // [set of paths][place]
        let straight = light.map(|places| places.map(|[straight, _]| straight));
        let other = light.map(|places| places.map(|[_, other]| other));
        let between_places = |of: [[f32; 2]; 2]| of.map(|[a, b]| a - b);
        let [a, b] = between_places(straight);
        let of_straight = 0.5 * (product(a, a) + product(b, b));
        let [a, b] = between_places(other);
        let inside_pixel = product(a, b).clamp(-MOST_SPREAD, MOST_SPREAD);
        sum.rays += of_straight.min(MOST_STRAIGHT_SPREAD) + inside_pixel;
        for (a, b) in other[0].into_iter().zip(other[1]) {
            sum.paths += 0.5 * product(a - b, a - b).min(MOST_SPREAD);
        }
        // Two rays with either set.
        sum.pairs += 0.25 * *pairs as f32;
        sum.shadow_rays += 0.25 * *shadow_rays as f32;
    }
    let paths = paths as f32;
    Spread {
        rays: (sum.rays / count).max(0.0),
        paths: sum.paths / count * paths,
        beams: looks.iter().map(|look| look.beams as f32).sum::<f32>() / (2.0 * paths),
        pairs: sum.pairs / (count * paths),
        shadow_rays: sum.shadow_rays / count,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pilot::of_still;
    use crate::random::Emission;
    use crate::scene::made::{Made, camera, cuboid, lambert, point, spot};
    use crate::scene::{Material, Scene, media};

    const SPREAD: Spread = Spread { rays: 1e-2, paths: 10.0, beams: 2.0, pairs: 0.01, shadow_rays: 16.0 };

    /// Variance x cost by number of branches has its minimum where the formula says.
    #[test]
    fn the_share_is_the_best_one() {
        let (photons, pixels) = (1e4, 5e4);
        let found = share(&SPREAD, photons, pixels) / IN_FAVOUR;
        let of_rays = pixels * (EYE_RAY + SHADOW_RAY * 16.0);
        let of_paths = photons * (BEAM * 2.0 + PAIR * PAIRS_OF_A_PASS * 0.01 * pixels);
        let product = |n: f32| (1e-2 + 1e-3 / n) * (of_rays + of_paths * n);
        let best = (1..1000).map(|i| i as f32 * 1e-3).min_by(|a, b| product(*a).total_cmp(&product(*b)));
        assert!((found - best.unwrap()).abs() < 2e-3, "{found} for {best:?}");
        assert!(found > LEAST && found < 1.0 / IN_FAVOUR);
    }

    /// From the noise of few paths to that of many: no doubling is left out that pays, and none done that does not.
    #[test]
    fn branches_double_as_long_as_it_pays() {
        let (photons, pixels) = (1e4, 5e4);
        let of_rays = pixels * (EYE_RAY + SHADOW_RAY * 16.0);
        let of_paths = photons * (BEAM * 0.2 + PAIR * PAIRS_OF_A_PASS * 0.001 * pixels);
        let found = [1.0, 4.0, 10.0, 20.0, 40.0, 60.0, 1e2, 1e3, 1e4].map(|paths| {
            let share = share(&Spread { paths, beams: 0.2, pairs: 0.001, ..SPREAD }, photons, pixels);
            let product = |n: f32| (1e-2 + 2.25e-4 * paths / n) * (of_rays + of_paths * n);
            let gain = |n: f32| product(2.0 * n) / product(n);
            assert!(share <= 1.0 || gain(share / 2.0) < PAYS, "{paths}: {share}");
            assert!(share < 1.0 || share == MOST || gain(share) >= PAYS, "{paths}: {share}");
            share
        });
        assert!(found.is_sorted() && found[0] < 1.0, "{found:?}");
        assert!([1.0, 2.0, MOST].iter().all(|share| found.contains(share)), "{found:?}");
    }

    #[test]
    fn noise_of_one_kind_alone_decides() {
        let of = |rays, paths| share(&Spread { rays, paths, ..SPREAD }, 1e4, 5e4);
        assert_eq!([of(0.0, 0.0), of(0.0, 1.0), of(1.0, 0.0)], [1.0, MOST, LEAST]);
    }

    /// As many beams, until paths that leave none would be traced for nothing, or end at once; never fewer paths than are asked for.
    #[test]
    fn paths_that_leave_few_beams_are_more() {
        let small = camera([0.0, 0.0, -4.0], [0.0; 3], 50.0, [64, 64]);
        let of = |beams, photons| Spread { beams, ..SPREAD }.paths(photons, &small);
        let found = [9.0, 3.0, 1.5, 1.0, 0.1, 0.0].map(|beams| of(beams, 1000));
        assert_eq!(found, [1000, 1000, 2000, 3000, 24_000, 24_000]);
        assert_eq!([of(9.0, (1 << 28) - 1), of(0.0, 1 << 28)], [(1 << 28) - 1, 1 << 31]);
        let spread = Spread { beams: 0.1, ..SPREAD };
        let large = camera([0.0, 0.0, -4.0], [0.0; 3], 50.0, [1000, 1000]);
        let found = [500, 2000, 10_000].map(|photons| {
            let paths = spread.paths(photons, &large);
            [paths as f32 / photons as f32, spread.share_of_branches(paths, &large)]
        });
        println!("times as many paths, and what these keep of their branches: {found:?}");
        assert_eq!([found[0][0], found[2][0]], [24.0, 8.0]);
        assert!((found[1][1] / FEWEST_BRANCHES - 1.0).abs() < 1e-3, "{found:?}");
    }

    fn tracer<'a>(scene: &'a Scene, fogs: &[Medium]) -> PhotonTracer<'a> {
        let mut tracer = PhotonTracer::new(scene, 0, Emission::LowDiscrepancy);
        tracer.guide(of_still(scene, fogs).expect("light"));
        tracer
    }

    /// A room of fog with a lamp.
    fn room(scattering: f32, walls: Material) -> Made {
        Made::new(camera([0.0, 0.0, -4.0], [0.0; 3], 50.0, [64, 64]))
            .fog(scattering, 0.01)
            .in_fog()
            .object(cuboid([-5.0; 3], [5.0; 3]), walls)
            .light(point([1.0, 1.0, 0.0], 1.0))
    }

    /// Of N independent paths the variance is 1/N of one path's: four times the paths give the same answer.
    #[test]
    fn the_variance_of_paths_is_that_of_one_over_their_number() {
        let scene = room(0.3, lambert(0.5)).scene();
        let fogs = media::all(&scene);
        let tracer = tracer(&scene, &fogs);
        let [few, many] = [2 * PATHS, 8 * PATHS]
            .map(|paths| spread(&looks(&tracer, &fogs, paths, &|| false), paths, &|| false));
        // Low discrepancy makes it fall a little faster, and a fifth is chance. With fewer paths pixels reach the bound.
        let ratio = many.paths / few.paths;
        assert!((0.6..1.2).contains(&ratio), "{few:?}, {many:?}");
        assert!((few.beams / many.beams - 1.0).abs() < 0.1, "{few:?}, {many:?}");
    }

    /// Thin fog that a lamp lights evenly, with a cone whose edges are all that is noisy; thick fog around a lamp, where nothing has edges.
    #[test]
    fn thin_fog_around_a_narrow_spot_needs_few_branches_and_thick_fog_all() {
        let spot = spot([1.0, 1.0, 0.0], [-1.0, -1.0, 0.0], 100.0, [9.0, 10.0]);
        let thin = room(1e-3, Material::Black).light(spot);
        let [thin, thick] = [thin, room(0.5, lambert(0.5))].map(|made| {
            let scene = made.scene();
            let fogs = media::all(&scene);
            let spread = Spread::of(&tracer(&scene, &fogs), &fogs, &|| false).expect("guided paths pay");
            spread.share_of_branches(scene.settings.photons, &scene.camera)
        });
        assert!(thin < 0.5 && thick == 1.0, "{thin}, {thick}");
    }
}
