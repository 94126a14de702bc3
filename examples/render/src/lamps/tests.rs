use super::*;
use crate::random::Random;
use std::cell::Cell;
use std::f32::consts::PI;
use std::path::Path;

/// Lamps of some kinds and sizes in a box of 8 x 3 x 8 m, some of them in one place, with a sun beside them if asked for.
fn scene(count: u32, kinds: &[&str], has_sun: bool) -> Scene {
    let mut text = String::from(
        "[camera]\nposition = [0, 1, -9]\nlook_at = [0, 1, 0]\nvertical_fov = 40\nwidth = 8\nheight = 8\n\
         [[object]]\nshape = \"sphere\"\ncenter = [0, 1, 0]\nradius = 4\nmaterial = \"black\"\n",
    );
    let mut random = Random::new([1, count, 0, 0]);
    let mut place = [0.0; 3];
    for lamp in 0..count as usize {
        if lamp % 7 != 3 {
            place = [8.0, 3.0, 8.0].map(|side| side * random.uniform());
        }
        let [x, y, z] = [place[0] - 4.0, place[1], place[2] - 4.0];
        let power = 10.0_f32.powf(2.0 * random.uniform() - 1.0);
        let size = 10.0_f32.powf(random.uniform() - 2.0);
        let axis = [0; 3].map(|_| 2.0 * random.uniform() - 1.0);
        let [a, b, c] = axis;
        text += "[[light]]\n";
        text += &match kinds[lamp % kinds.len()] {
            "point" => format!("kind = \"point\"\nposition = [{x}, {y}, {z}]\nintensity = {power}\n"),
            "spot" => format!(
                "kind = \"spot\"\nposition = [{x}, {y}, {z}]\nlook_at = [{}, {}, {}]\nintensity = {power}\n\
                 inner_angle = 20\nouter_angle = 30\n",
                x + a,
                y + b,
                z + c
            ),
            "disk" => format!(
                "kind = \"disk\"\ncenter = [{x}, {y}, {z}]\nnormal = [{a}, {b}, {c}]\nradius = {size}\nradiance = {power}\n"
            ),
            "area" => format!(
                "kind = \"area\"\ncenter = [{x}, {y}, {z}]\nedge_u = [{size}, 0, 0]\nedge_v = [0, {size}, {size}]\n\
                 spread = 25\nradiance = {power}\n"
            ),
            kind => {
                format!("kind = \"{kind}\"\ncenter = [{x}, {y}, {z}]\nradius = {size}\nradiance = {power}\n")
            }
        };
    }
    if has_sun {
        text += "[[light]]\nkind = \"sun\"\ndirection = [0.1, -1, 0]\nirradiance = 2\n";
    }
    Scene::parse(&text, "lamps", Path::new("")).expect("a valid scene")
}

const KINDS: [&str; 5] = ["point", "spot", "disk", "sphere", "area"];

fn stretches() -> Vec<(Vec3, Vec3)> {
    let mut random = Random::new([2, 0, 0, 0]);
    let mut number = || 2.0 * random.uniform() - 1.0;
    (0..20)
        .map(|_| {
            let origin = Vec3::new(3.0 * number(), 1.0 + number(), 3.0 * number() - 4.0);
            (origin, Vec3::new(number(), 0.3 * number(), 1.2).normalize())
        })
        .collect()
}

/// As of lamps in a vacuum: the integral of 1/(d² + softening²) where the lamp shines, and a distance there.
fn seen(light: &Light, origin: Vec3, direction: Vec3, to: f32) -> Option<(f32, f32)> {
    let (from, to) = light.lit_stretch(origin, direction, 0.0, to)?;
    let (middle, softening) = light.middle();
    let foot = (middle - origin).dot(direction);
    let height = (middle - origin - foot * direction).length().hypot(softening);
    let angle = ((to - foot) / height).atan() - ((from - foot) / height).atan();
    Some((angle / height, 0.5 * (from + to)))
}

/// Of 2³² numbers some fall on each lamp with a chance of more than 2e-10.
#[test]
fn chances_add_up_to_one_and_no_lamp_that_shines_is_without() {
    const DRAWS: u32 = u32::MAX;
    for has_sun in [false, true] {
        let scene = scene(300, &KINDS, has_sun);
        let tree = LampTree::new(&scene);
        for (origin, direction) in stretches() {
            let mut chances = vec![0.0_f64; scene.lights.len()];
            let mut numbers = 0;
            let mut found = |drawn: Drawn| {
                chances[drawn.lamp] += f64::from(drawn.expected()) / f64::from(DRAWS);
                numbers += drawn.draws.end - drawn.draws.start;
                let ends = [drawn.draws.start, drawn.draws.end - 1].map(|draw| drawn.rest(draw));
                assert!(0.0 <= ends[0] && ends[0] <= ends[1] && ends[1] <= 1.0, "{ends:?}");
            };
            let stretch =
                Stretch { origin, direction, from: 0.0, to: 9.0, left: &|distance| (-distance).exp() };
            let seen = |lamp: usize| seen(&scene.lights[lamp], origin, direction, 9.0);
            tree.along(&stretch, DRAWS, 0.5, &seen, &mut found);
            // Balls around many may be on the way where none of the lamps shines: there numbers find nothing.
            let share = f64::from(numbers) / f64::from(DRAWS);
            // 300 chances, each rounded to 6e-8 of itself; and those that no number met.
            let sum = chances.iter().sum::<f64>();
            assert!(share > 0.3 && (sum - share).abs() < 1e-5, "{sum} for {share}");
            // The chance of a lamp is a product of what nodes are worth over what two are.
            let nodes =
                tree.nodes.iter().map(|node| [node.along(&stretch), node.on_surface(origin, direction)]);
            assert!(nodes.flatten().all(|worth| worth > 0.0 && worth.is_finite()));
            let worth = |lamp: usize| match seen(lamp) {
                _ if scene.lights[lamp].is_far() => 1.0,
                Some((integral, middle)) => {
                    integral * tree.lamps[lamp].shines(stretch.at(middle)) * stretch.dimmed(middle)
                }
                None => 0.0,
            };
            let all: f32 = (0..chances.len()).map(worth).sum();
            for (lamp, &chance) in chances.iter().enumerate() {
                let light = &scene.lights[lamp];
                let shines = light.is_far() || seen(lamp).is_some();
                assert_eq!(worth(lamp) > 0.0, shines, "lamp {lamp}: {light:?}");
                assert!(shines || chance == 0.0, "lamp {lamp}: {light:?}");
                // Nodes are taken for less than their lamps are worth, but not for so much less.
                assert!(chance > 0.0 || worth(lamp) < 1e-7 * all, "lamp {lamp}: {light:?}");
            }
            let mut chances = vec![0.0_f64; scene.lights.len()];
            tree.for_surface(origin, direction, DRAWS, 0.5, &mut |drawn| {
                chances[drawn.lamp] += f64::from(drawn.expected()) / f64::from(DRAWS);
            });
            assert!((chances.iter().sum::<f64>() - 1.0).abs() < 1e-5);
            let mut random = Random::new([3, 0, 0, 0]);
            for (lamp, &chance) in chances.iter().enumerate() {
                let (arriving, _) = scene.lights[lamp].irradiance(origin, direction, &mut random);
                assert!(chance > 0.0 || arriving == Vec3::ZERO, "lamp {lamp}: {:?}", scene.lights[lamp]);
            }
        }
    }
}

/// Mean and its standard error.
fn mean_of(values: &[f64]) -> [f64; 2] {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
    [mean, (variance / count).sqrt()]
}

/// Whether estimates of 1 are right in the mean: within 5 standard errors, of 40 means once in 40,000 runs. That is asked of what could see a loss of a
/// percent or two.
fn is_right(values: &[f64]) -> bool {
    let [mean, error] = mean_of(values);
    assert!(error < 0.03, "{mean} ± {error}");
    // Sums in single precision.
    (mean - 1.0).abs() < 5.0 * error + 1e-5
}

/// A vacuum with 300 points: a ray gets the sum of I Δθ/h of them, a surface that of I cos/d². As if all lamps had the same chance they are wrong.
#[test]
fn sums_over_three_hundred_lamps_are_those_of_the_closed_forms() {
    let scene = scene(300, &["point"], false);
    let tree = LampTree::new(&scene);
    let mut wrong = [0; 2];
    for (number, (origin, direction)) in (0..).zip(stretches()) {
        let intensity = |lamp: usize| f64::from(mean(scene.lights[lamp].flux())) / f64::from(4.0 * PI);
        let along = |lamp: usize| {
            let (integral, _) =
                seen(&scene.lights[lamp], origin, direction, 9.0).expect("a point shines everywhere");
            intensity(lamp) * f64::from(integral)
        };
        let surface = |lamp: usize| {
            let offset = (scene.lights[lamp].position() - origin).as_dvec3();
            let cosine = offset.normalize().dot(direction.as_dvec3());
            intensity(lamp) * cosine.max(0.0) / offset.length_squared()
        };
        let truth = [(0..300).map(along).sum::<f64>(), (0..300).map(surface).sum::<f64>()];
        let mut random = Random::new([4, number, 0, 0]);
        let mut estimates = [[(); 2]; 2].map(|pair| pair.map(|()| Vec::new()));
        for _ in 0..400 {
            let mut sums = [[0.0; 2]; 2];
            let stretch = Stretch { origin, direction, from: 0.0, to: 9.0, left: &|_| 1.0 };
            let seen = |lamp: usize| seen(&scene.lights[lamp], origin, direction, 9.0);
            tree.along(&stretch, 64, random.uniform(), &seen, &mut |drawn| {
                let count = f64::from(drawn.draws.end - drawn.draws.start);
                sums[0][0] += count * along(drawn.lamp) / f64::from(drawn.expected());
                sums[0][1] += count * along(drawn.lamp) / (64.0 / 300.0);
            });
            for (lamp, stands_for) in tree.on_surface(origin, direction, random.uniform()) {
                sums[1][0] += surface(lamp) * f64::from(stands_for);
                sums[1][1] += surface(lamp) / (MOST_ASKED as f64 / 300.0);
            }
            for kind in 0..2 {
                for way in 0..2 {
                    estimates[kind][way].push(sums[kind][way] / truth[kind]);
                }
            }
        }
        for kind in 0..2 {
            assert!(
                is_right(&estimates[kind][0]),
                "ray or surface {kind}: {:?}",
                mean_of(&estimates[kind][0])
            );
            let [mean, error] = mean_of(&estimates[kind][1]);
            wrong[kind] += u32::from((mean - 1.0).abs() > 5.0 * error + 1e-5);
        }
    }
    assert_eq!(wrong, [20; 2], "even chances would pass");
}

/// Sixty-four numbers split at each of the first six levels of the tree, and go down the other six one by one, with two looks each.
#[test]
fn four_thousand_lamps_take_few_looks() {
    for count in [300, 4000] {
        let scene = scene(count, &KINDS, false);
        let tree = LampTree::new(&scene);
        let levels = u32::BITS - (count - 1).leading_zeros();
        for (origin, direction) in stretches() {
            let (looks, draws) = (Cell::new(0), Cell::new(0));
            let stretch = Stretch { origin, direction, from: 0.0, to: 9.0, left: &|_| 1.0 };
            let worth = Worth {
                far: &|strength| strength,
                node: &|node| {
                    looks.set(looks.get() + 1);
                    node.along(&stretch)
                },
                lamp: &|lamp| {
                    looks.set(looks.get() + 1);
                    tree.lamps[lamp].along(&stretch)
                },
            };
            let mut found = |drawn: Drawn| draws.set(draws.get() + drawn.draws.len());
            tree.draw(&worth, 64, 0.3, &mut found);
            assert_eq!(draws.get(), 64);
            // And one at the top.
            assert!(looks.get() <= 1 + 2 * (63 + 64 * (levels - 6)), "{} of {count}", looks.get());
            assert_eq!(tree.on_surface(origin, direction, 0.3).len(), MOST_ASKED);
        }
    }
}
