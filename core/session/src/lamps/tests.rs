use super::*;
use crate::light::Area;
use crate::random::Random;
use crate::scene::Material;
use crate::scene::made::{Made, camera, point, sphere, spot};
use std::cell::Cell;
use std::f32::consts::PI;

/// Lamps of some kinds and sizes in a box of 8 x 3 x 8 m, some of them in one place, with a sun beside them if asked for.
fn scene(count: u32, kinds: &[&str], has_sun: bool) -> Scene {
    let camera = camera([0.0, 1.0, -9.0], [0.0, 1.0, 0.0], 40.0, [8, 8]);
    let mut made = Made::new(camera).object(sphere([0.0, 1.0, 0.0], 4.0), Material::Black);
    let mut random = Random::new([1, count, 0, 0]);
    let mut place = [0.0; 3];
    for lamp in 0..count as usize {
        if lamp % 7 != 3 {
            place = [8.0, 3.0, 8.0].map(|side| side * random.uniform());
        }
        let position = [place[0] - 4.0, place[1], place[2] - 4.0];
        let center = Vec3::from(position);
        let power = 10.0_f32.powf(2.0 * random.uniform() - 1.0);
        let size = 10.0_f32.powf(random.uniform() - 2.0);
        let axis = Vec3::from([0; 3].map(|_| 2.0 * random.uniform() - 1.0));
        let radiance = Vec3::splat(power);
        made = made.light(match kinds[lamp % kinds.len()] {
            "point" => point(position, power),
            "spot" => spot(position, (center + axis).to_array(), power, [20.0, 30.0]),
            "disk" => {
                let normal = axis.as_dvec3().normalize().as_vec3().normalize();
                Light::Disk { center, normal, radius: size, radiance }
            }
            "area" => {
                let (edge_u, edge_v) = (Vec3::new(size, 0.0, 0.0), Vec3::new(0.0, size, size));
                let (round, spread) = (false, 25.0_f32.to_radians());
                Light::Area(Area { center, edge_u, edge_v, round, spread, radiance })
            }
            _ => Light::Sphere { center, radius: size, radiance },
        });
    }
    if has_sun {
        made = made.sun([0.1, -1.0, 0.0], 0.0, Vec3::splat(2.0));
    }
    made.scene()
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

/// As of lamps in a vacuum: the integral of 1/(d² + softening²) along a ray where the lamp shines.
fn integral(light: &Light, origin: Vec3, direction: Vec3, to: f32) -> f32 {
    let Some((from, to)) = light.lit_stretch(origin, direction, 0.0, to) else { return 0.0 };
    let (middle, softening) = light.middle();
    let foot = (middle - origin).dot(direction);
    let height = (middle - origin - foot * direction).length().hypot(softening);
    (((to - foot) / height).atan() - ((from - foot) / height).atan()) / height
}

/// What each lamp is worth, and its chance: the product over all groups around it of what they are worth in that of the four that they are among.
/// Also the least that a group, or a lamp that is not asked, is worth.
fn enumerated(tree: &LampTree, four: &dyn Fn(&Four) -> Vec4, lights: usize) -> (Vec<[f64; 2]>, f32) {
    let mut found = vec![[0.0; 2]; lights];
    let mut least = f32::INFINITY;
    let mut waiting = vec![(0, 1.0)];
    while let Some((group, chance)) = waiting.pop() {
        let group: &Four = &tree.fours[group as usize];
        let worth = four(group);
        let sum: f64 = worth.to_array().map(f64::from).iter().sum();
        for (below, worth) in group.below.iter().zip(worth.to_array()) {
            assert!((0.0..f32::INFINITY).contains(&worth), "{worth}");
            let chance = if sum > 0.0 { chance * f64::from(worth) / sum } else { 0.0 };
            match *below {
                Below::Nothing => assert_eq!(worth, 0.0),
                Below::Lamp(lamp, _) => found[lamp as usize] = [f64::from(worth), chance],
                Below::Groups(groups) => waiting.push((groups, chance)),
            }
            if !matches!(below, Below::Nothing | Below::Lamp(_, false)) {
                least = least.min(worth);
            }
        }
    }
    (found, least)
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
                Stretch::new([origin, direction], [0.0, 9.0], f32::INFINITY, |distance| (-distance).exp());
            let seen = |lamp: usize| scene.lights[lamp].lit_stretch(origin, direction, 0.0, 9.0);
            tree.along(&stretch, DRAWS, 0.5, &seen, &mut found);
            // Balls around many may be on the way where none of the lamps shines: there numbers find nothing.
            let share = f64::from(numbers) / f64::from(DRAWS);
            // 300 chances, each rounded to 6e-8 of itself; and those that no number met.
            let sum = chances.iter().sum::<f64>();
            assert!(share > 0.3 && (sum - share).abs() < 1e-5, "{sum} for {share}");
            let near = if has_sun { 1.0 - chances[300] } else { 1.0 };
            let along = |four: &Four| four.along(&stretch, &seen);
            let (expected, least) = enumerated(&tree, &along, scene.lights.len());
            assert!(least > 0.0);
            for (lamp, [worth, chance]) in expected.into_iter().enumerate().take(300) {
                let light = &scene.lights[lamp];
                assert_eq!(worth > 0.0, seen(lamp).is_some(), "lamp {lamp}: {light:?}");
                // A number of 2³² may fall on it or not.
                let difference = (chances[lamp] - near * chance).abs();
                assert!(difference < 3e-10 + 1e-6 * chance, "lamp {lamp}: {} for {chance}", chances[lamp]);
            }
            let mut chances = vec![0.0_f64; scene.lights.len()];
            tree.for_surface(origin, direction, DRAWS, 0.5, &mut |drawn| {
                chances[drawn.lamp] += f64::from(drawn.expected()) / f64::from(DRAWS);
            });
            assert!((chances.iter().sum::<f64>() - 1.0).abs() < 1e-5);
            let on_surface = |four: &Four| four.on_surface(origin, direction);
            let (expected, least) = enumerated(&tree, &on_surface, scene.lights.len());
            assert!(least > 0.0 && expected[..300].iter().all(|[worth, _]| *worth > 0.0));
            let mut random = Random::new([3, 0, 0, 0]);
            for (lamp, &chance) in chances.iter().enumerate() {
                let (arriving, _) = scene.lights[lamp].irradiance(origin, direction, &mut random);
                assert!(chance > 0.0 || arriving == Vec3::ZERO, "lamp {lamp}: {:?}", scene.lights[lamp]);
            }
        }
    }
}

/// Of lamps that shine all around with the integral and the cosine in closed form: single ones are worth what they send, but for the angle's formula,
/// and for light that is left to beams.
#[test]
fn single_points_are_worth_what_they_send() {
    let scene = scene(300, &["point"], false);
    let tree = LampTree::new(&scene);
    let reach = Near::new(&scene);
    for (origin, direction) in stretches() {
        let stretch = Stretch::new([origin, direction], [0.0, 9.0], f32::INFINITY, |_| 1.0);
        let seen = |_: usize| panic!("points shine all around");
        let (found, _) = enumerated(&tree, &|four| four.along(&stretch, &seen), 300);
        let (on_surface, _) = enumerated(&tree, &|four| four.on_surface(origin, direction), 300);
        for (lamp, light) in scene.lights.iter().enumerate() {
            let strength = mean(light.flux()) / (4.0 * PI);
            let offset = light.position() - origin;
            let aside = (offset - offset.dot(direction) * direction).length();
            if aside < 10.0 * reach.reach(lamp) {
                continue;
            }
            // Both angles to 5e-3, of a difference that may be small; 1/h to half a percent by the gap.
            let closed = strength * integral(light, origin, direction, 9.0);
            let error = 1e-2 * strength / aside + 0.01 * closed;
            assert!((found[lamp][0] as f32 - closed).abs() < error, "{} for {closed}", found[lamp][0]);
            let cosine = offset.normalize().dot(direction);
            let closed = strength * cosine / offset.length_squared();
            if cosine > 0.01 {
                let [worth, _] = on_surface[lamp];
                assert!((worth as f32 / closed - 1.0).abs() < 0.011, "{worth} for {closed}");
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
        let along =
            |lamp: usize| intensity(lamp) * f64::from(integral(&scene.lights[lamp], origin, direction, 9.0));
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
            let stretch = Stretch::new([origin, direction], [0.0, 9.0], f32::INFINITY, |_| 1.0);
            let seen = |_: usize| panic!("points shine all around");
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

/// Sixty-four numbers split at each of the first three levels of the tree, and go down the other three one by one.
#[test]
fn four_thousand_lamps_take_few_looks() {
    for count in [300, 4000] {
        let scene = scene(count, &KINDS, false);
        let tree = LampTree::new(&scene);
        let levels = (u32::BITS - (count - 1).leading_zeros()).div_ceil(2);
        for (origin, direction) in stretches() {
            let (looks, draws) = (Cell::new(0), Cell::new(0));
            let stretch = Stretch::new([origin, direction], [0.0, 9.0], f32::INFINITY, |_| 1.0);
            let four = |four: &Four| {
                looks.set(looks.get() + 1);
                // As if all of them shone everywhere.
                four.along(&stretch, &|_| Some((0.0, 9.0)))
            };
            let worth = Worth { far: &|strength| strength, four: &four };
            let mut found = |drawn: Drawn| draws.set(draws.get() + drawn.draws.len());
            tree.draw(&worth, 64, 0.3, &mut found);
            assert_eq!(draws.get(), 64);
            assert!(looks.get() <= 1 + 4 + 16 + 64 * (levels - 3), "{} of {count}", looks.get());
            assert_eq!(tree.on_surface(origin, direction, 0.3).len(), MOST_ASKED);
        }
    }
}
