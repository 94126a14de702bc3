//! The fog around lamps that are in the picture, by quadrature: beams lose none of it; what a kernel blurs stays beside the lamp.

use covbeam_render::scene_file;
use covbeam_session::film::Film;
use covbeam_session::pass::Renderer;
use covbeam_session::scene::Scene;
use covbeam_session::settings::{Method, Settings};
use covbeam_tests::single_scatter::{Density, Emission, Lamp, World, sunflower};
use covbeam_tests::statistics::Sample;
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::PI;
use std::path::Path;

/// Pixels a side; the picture is 2 m wide at the lamp, which is where its four middle pixels meet.
const SIZE: u32 = 32;
/// \[1/m\]: light scattered twice is 2e-3 of it at most.
const SCATTERING: f64 = 1e-4;
const ABSORPTION: f64 = 0.1;
/// Half the room's side \[m\].
const ROOM: f64 = 6.0;
/// From the camera to the lamp \[m\].
const DISTANCE: f64 = 5.0;

/// A black room with a lamp in the middle; kernels of one radius, or up to twice that.
fn scene(light: &str, radius: f64) -> Scene {
    let widest = 2.0 * radius;
    let text = format!(
        "outside_medium = \"air\"\n\
         [camera]\nposition = [0.0, 0.0, -{DISTANCE}]\nlook_at = [0.0, 0.0, 0.0]\nvertical_fov = {}\nwidth = {SIZE}\nheight = {SIZE}\n\
         [[medium]]\nname = \"air\"\nscattering = {SCATTERING}\nabsorption = {ABSORPTION}\n\
         [[object]]\nshape = \"box\"\nmin = [-{ROOM}, -{ROOM}, -{ROOM}]\nmax = [{ROOM}, {ROOM}, {ROOM}]\nmaterial = \"black\"\n\
         [[light]]\n{light}\nvisible = false\n\
         [grid]\ncells = [24, 24, 24]\n[render]\nradius = {radius}\nmax_radius = {widest}\nerror = 0.01\n",
        2.0 * (1.0 / DISTANCE).atan().to_degrees()
    );
    scene_file::parse(&text, "lamp", Path::new(".")).expect("a valid scene")
}

/// The same room for the quadrature.
fn world(emission: Emission, position: DVec3) -> World {
    World {
        density: Density::Exponential { scale_height: 1e12 },
        scattering: DVec3::splat(SCATTERING),
        absorption: DVec3::splat(ABSORPTION),
        asymmetry: 0.0,
        lamp: Lamp { position, intensity: DVec3::ONE, emission },
        ball: (DVec3::new(0.0, -50.0, 0.0), 1.0),
        room: (DVec3::splat(-ROOM), DVec3::splat(ROOM)),
    }
}

/// Distance of a pixel's centre from the lamp, in pixels.
fn aside(pixel: u32) -> f64 {
    let middle = 0.5 * f64::from(SIZE - 1);
    (f64::from(pixel % SIZE) - middle).hypot(f64::from(pixel / SIZE) - middle)
}

/// Mean of what `radiance` says of the rays through a pixel, each by its number. Around the lamp, where it is as 1/h, 64 x 64 rays: their midpoint rule misses below
/// 1 % of the four innermost pixels' light, a quarter of that of all within 4 pixels.
/// Of pixels beyond these 3 x 3 miss 6e-4 at most.
fn pixel_mean(scene: &Scene, pixel: u32, radiance: &impl Fn(u32, DVec3, DVec3) -> f64) -> f64 {
    let rays = match aside(pixel) {
        ..1.0 => 64,
        ..4.0 => 6,
        _ => 3,
    };
    let at = |index: u32, i: u32| (f64::from(index) + (f64::from(i) + 0.5) / f64::from(rays)) as f32;
    let ray = |i: u32| {
        let direction = scene.camera.direction(at(pixel % SIZE, i % rays), at(pixel / SIZE, i / rays));
        radiance(i, scene.camera.position.as_dvec3(), direction.as_dvec3().normalize())
    };
    (0..rays * rays).map(ray).sum::<f64>() / f64::from(rays * rays)
}

/// Rings around the lamp, in pixels.
const RINGS: [[f64; 2]; 5] = [[0.0, 1.0], [1.0, 2.0], [2.0, 4.0], [4.0, 8.0], [8.0, 16.0]];

/// Sums over rings, and over all up to each ring's outer border.
fn rings(picture: &[f64]) -> [[f64; 2]; 5] {
    RINGS.map(|[from, to]| {
        let sum = |from: f64| {
            let of = (0..SIZE * SIZE).filter(|&pixel| (from..to).contains(&aside(pixel)));
            of.map(|pixel| picture[pixel as usize]).sum()
        };
        [sum(from), sum(0.0)]
    })
}

/// Rings of pictures of four seeds, over those of `truth`. Each picture is the mean of some first passes: all kernels have the radius asked for.
fn measured(scene: &Scene, method: Method, passes: u32, truth: [[f64; 2]; 5]) -> [[Sample; 2]; 5] {
    measured_by(scene, Settings::of(method, 20_000, 0), passes, truth)
}

/// The same by other settings; their seed does not count.
fn measured_by(scene: &Scene, settings: Settings, passes: u32, truth: [[f64; 2]; 5]) -> [[Sample; 2]; 5] {
    let runs: Vec<[[f64; 2]; 5]> = (0..4)
        .map(|run| {
            let mut film = Film::new(SIZE, SIZE);
            for seed in 0..passes {
                let mut renderer = Renderer::new(scene, Settings { seed: passes * run + seed, ..settings });
                let (image, _) = renderer.pass(1, &|| false).expect("not cancelled");
                film.add(&image).expect("finite");
            }
            let radiance = film.picture().radiance;
            rings(&radiance.iter().map(|color| f64::from(color.x)).collect::<Vec<_>>())
        })
        .collect();
    std::array::from_fn(|ring| {
        [0, 1].map(|sum| {
            Sample::of(&runs.iter().map(|run| run[ring][sum] / truth[ring][sum]).collect::<Vec<_>>())
        })
    })
}

/// Airlight of a point without σ_s I/4π, for an eye ray that passes it at `h`, from the camera to the wall: the midpoint rule in the angle.
fn airlight(h: f64) -> f64 {
    let (low, high) = ((-DISTANCE / h).atan(), (ROOM / h).atan());
    let steps = 400;
    let step = (high - low) / f64::from(steps);
    let at = |k: i32| {
        let angle = low + (f64::from(k) + 0.5) * step;
        (-(ABSORPTION + SCATTERING) * (h / angle.cos() + h * angle.tan() + DISTANCE)).exp()
    };
    (0..steps).map(at).sum::<f64>() * step / h
}

/// What kernels of radius r make of it. A beam that leaves the lamp at an azimuth φ about the eye ray passes it at
/// v = h sin φ, and meets it where one would if the ray passed the lamp at h cos φ: ∫K_r(v) A(√(h²-v²)) dv, |v| < h. All of the light over the plane is
/// kept, and moved outwards, from w to √(w²+v²).
fn blurred(h: f64, radius: f64, airlight: &impl Fn(f64) -> f64) -> f64 {
    let steps = 200;
    let widest = (radius / h).min(1.0).asin();
    let step = widest / f64::from(steps);
    let at = |k: i32| {
        let (s, c) = ((f64::from(k) + 0.5) * step).sin_cos();
        let q = h * s / radius;
        2.0 * 0.75 / radius * (1.0 - q * q) * airlight(h * c) * h * c
    };
    (0..steps).map(at).sum::<f64>() * step
}

const POINT: &str = "kind = \"point\"\nposition = [0, 0, 0]\nintensity = 1.0\n";

#[test]
fn around_a_point_beams_show_the_airlight_as_their_kernel_blurs_it_and_lose_none() {
    // ln(h A) over ln h is smooth: 2000 places between 1e-5 m and 2 m are good to 1e-6.
    let places = 2000;
    let log = |k: usize| (1e-5f64).ln() + (2e5f64).ln() * k as f64 / f64::from(places);
    let table: Vec<f64> = (0..=places as usize).map(|k| airlight(log(k).exp()) * log(k).exp()).collect();
    let look_up = |h: f64| {
        let x = ((h.ln() - log(0)) / (log(1) - log(0))).clamp(0.0, f64::from(places) - 1e-9);
        let (k, t) = (x as usize, x.fract());
        ((1.0 - t) * table[k] + t * table[k + 1]) / h
    };
    // Fewer beams meet narrow kernels.
    for (radius, passes) in [(0.2, 4), (0.05, 12)] {
        let scene = scene(POINT, radius);
        let radiance = |_, _: DVec3, direction: DVec3| {
            let h = DISTANCE * direction.truncate().length();
            // The foot of a ray that passes the lamp at a distance is nearer than the lamp.
            let nearer = DISTANCE * (1.0 - direction.z);
            SCATTERING / (4.0 * PI)
                * blurred(h, radius, &look_up)
                * ((ABSORPTION + SCATTERING) * nearer).exp()
        };
        let truth: Vec<f64> =
            (0..SIZE * SIZE).into_par_iter().map(|pixel| pixel_mean(&scene, pixel, &radiance)).collect();
        for (ring, [sample, _]) in RINGS.iter().zip(measured(&scene, Method::Plain, passes, rings(&truth))) {
            println!("radius {radius}, ring {ring:?}: {:.4} ± {:.4}", sample.mean, sample.error);
            // The table takes eye and wall to be square to the ray: .1 m of the stretches' ends at 1 m aside, 1e-3 of the light.
            assert!((sample.mean - 1.0).abs() < 0.004 + 4.0 * sample.error, "{radius} {ring:?}: {sample:?}");
            assert!(sample.error < 0.01, "too noisy to tell: {sample:?}");
        }
    }
}

#[test]
fn a_lamps_own_region_has_all_its_light() {
    let look_at = DVec3::new(1.0, -1.0, 0.4).normalize();
    let cone = Emission::Spot { axis: look_at, inner: 15f64.to_radians(), outer: 25f64.to_radians() };
    let radius = 0.05;
    // Radiance 1/(π R²): I = 1 on the axis.
    let disk = format!(
        "kind = \"disk\"\ncenter = [0, 0, 0]\nnormal = [1.0, -1.0, 0.4]\nradius = {radius}\nradiance = {}\n",
        1.0 / (PI * radius * radius)
    );
    let spot = "kind = \"spot\"\nposition = [0, 0, 0]\nlook_at = [1.0, -1.0, 0.4]\nintensity = 1.0\ninner_angle = 15.0\nouter_angle = 25.0\n";
    // A square of 0.1 m, across the view, and the middles of 4 x 4 smaller ones.
    let square = format!(
        "kind = \"rectangle\"\ncorner = [-0.05, 0, -0.05]\nedge_u = [0.1, 0, 0]\nedge_v = [0, 0, 0.1]\nradiance = {}\n",
        1.0 / 0.01
    );
    let squares = (0..16).map(|k| {
        let at = |index: u32| 0.1 * ((f64::from(index) + 0.5) / 4.0 - 0.5);
        (Emission::Lambert { normal: DVec3::NEG_Y }, DVec3::new(at(k % 4), 0.0, at(k / 4)))
    });
    // Radiance 1/(4 π R²), over pieces of its surface.
    let ball = format!(
        "kind = \"sphere\"\ncenter = [0, 0, 0]\nradius = {radius}\nradiance = {}\n",
        1.0 / (4.0 * PI * radius * radius)
    );
    let pieces = (0..32).map(|k| {
        let height = 1.0 - 2.0 * (f64::from(k) + 0.5) / 32.0;
        let (s, c) = (f64::from(k) * PI * (3.0 - 5f64.sqrt())).sin_cos();
        let aside = (1.0 - height * height).sqrt();
        let normal = DVec3::new(aside * c, height, aside * s);
        (Emission::Lambert { normal }, radius * normal)
    });
    let of_disk = sunflower(DVec3::ZERO, radius, look_at, 64);
    // Passes: those that shine into one half have few beams beside the lamp, and need more.
    let lamps = [
        ("point", POINT, vec![(Emission::Even, DVec3::ZERO)], 3),
        ("spot", spot, vec![(cone, DVec3::ZERO)], 12),
        (
            "disk",
            disk.as_str(),
            of_disk.iter().map(|&at| (Emission::Lambert { normal: look_at }, at)).collect(),
            12,
        ),
        ("rectangle", square.as_str(), squares.collect(), 3),
        ("sphere", ball.as_str(), pieces.collect(), 3),
    ];
    for (name, light, places, passes) in lamps {
        let worlds: Vec<World> = places.iter().map(|&(emission, place)| world(emission, place)).collect();
        // A different eighth of many lamps for each ray, nine of which have all of them: 3e-3 off at most.
        let shares = worlds.len().div_ceil(8);
        let radiance = |ray: u32, eye: DVec3, direction: DVec3| {
            let some = worlds.iter().skip(ray as usize % shares).step_by(shares);
            let found = some.map(|world| world.radiance(eye, direction, 60).x);
            found.sum::<f64>() * shares as f64 / worlds.len() as f64
        };
        let scene = scene(light, 0.04);
        let truth: Vec<f64> =
            (0..SIZE * SIZE).into_par_iter().map(|pixel| pixel_mean(&scene, pixel, &radiance)).collect();
        // How a lamp emits is the same for both methods: the kernels, which are not, are those around a point.
        let methods = if name == "point" { &[Method::Plain, Method::Thesis][..] } else { &[Method::Thesis] };
        for &method in methods {
            let found = measured(&scene, method, passes, rings(&truth));
            for (ring, [_, within]) in RINGS.iter().zip(found).skip(2) {
                println!(
                    "{name}, {method:?}, up to {} pixels: {:.4} ± {:.4}",
                    ring[1], within.mean, within.error
                );
                // Kernels blur the lamp's light outwards, r²/(10 ρ²) of what is within ρ = 4 pixels: with the largest, .08 m, 1 %.
                assert!(
                    (within.mean - 1.0).abs() < 0.01 + 4.0 * within.error,
                    "{name}, {method:?}, {ring:?}: {within:?}"
                );
                assert!(within.error < 0.015, "too noisy to tell: {within:?}");
            }
        }
    }
}

/// ∫ f over a range: the midpoint rule.
fn integral([low, high]: [f64; 2], steps: u32, f: impl Fn(f64) -> f64) -> f64 {
    let step = (high - low) / f64::from(steps);
    (0..steps).map(|k| f(low + (f64::from(k) + 0.5) * step)).sum::<f64>() * step
}

/// A function of the distance from a place, by its values in a table; as a root beside `edge`, smooth elsewhere, below 9.
fn tabulated(edge: f64, f: impl Fn(f64) -> f64) -> impl Fn(f64) -> f64 {
    const PLACES: usize = 3000;
    // Distances are edge (1 - (1 - t)²) below it, edge + u² beyond: of t and u nothing is a root.
    let below = |t: f64| edge * (1.0 - (1.0 - t).powi(2));
    let beyond = |u: f64| edge + u * u;
    let share = |k: usize| k as f64 / PLACES as f64;
    let inner: Vec<f64> = (0..=PLACES).map(|k| f(below(share(k)))).collect();
    let outer: Vec<f64> = (0..=PLACES).map(|k| f(beyond(3.0 * share(k)))).collect();
    move |distance: f64| {
        let (table, place) = match distance < edge {
            true => (&inner, 1.0 - (1.0 - distance / edge).sqrt()),
            false => (&outer, (distance - edge).sqrt() / 3.0),
        };
        let place = (place * PLACES as f64).min(PLACES as f64 - 1e-9);
        let (k, part) = (place as usize, place.fract());
        (1.0 - part) * table[k] + part * table[k + 1]
    }
}

/// Lamps with a size send the same radiance along all lines that meet their ball, and differ in where that begins. A place at the distance d from the
/// middle sees the part of it on each ring of directions, at the cosine c, through as much fog as there is since then.
#[test]
fn the_fog_in_and_around_lamps_with_a_size_has_the_light_of_the_closed_forms() {
    let (radius, extinction) = (0.3f64, ABSORPTION + SCATTERING);
    // Radiance 1/(π R²): I = 1.
    let ring = |range, back: &dyn Fn(f64) -> f64| {
        2.0 / (radius * radius) * integral(range, 40, |c| (-extinction * back(c)).exp())
    };
    let chord = |d: f64, c: f64| (radius * radius - d * d * (1.0 - c * c)).max(0.0).sqrt();
    let soft = |d: f64| ring([d / d.hypot(radius), 1.0], &|c| d * c);
    let ball = |d: f64| match d < radius {
        true => ring([-1.0, 1.0], &|c| d * c + chord(d, c)),
        false => ring([(1.0 - (radius / d).powi(2)).sqrt(), 1.0], &|c| d * c - chord(d, c)),
    };
    for (name, is_soft, fluence) in
        [("soft", true, &soft as &(dyn Fn(f64) -> f64 + Sync)), ("ball", false, &ball)]
    {
        let light = format!(
            "kind = \"lamp\"\nposition = [0, 0, 0]\nintensity = 1.0\nradius = {radius}\nsoft = {is_soft}\n"
        );
        let fluence = tabulated(radius, fluence);
        let radiance = |_, eye: DVec3, direction: DVec3| {
            let foot = -eye.dot(direction);
            let aside = (eye + foot * direction).length();
            let half = (radius * radius - aside * aside).max(0.0).sqrt();
            let cuts = [0.0, foot - half, foot + half, (ROOM - eye.z) / direction.z];
            let at = |s: f64| fluence((eye + s * direction).length()) * (-extinction * s).exp();
            // Beside the ball's surface the light falls off as a root: places crowd there.
            let piece = |from: f64, to: f64| {
                integral([0.0, 1.0], 120, |t| {
                    at(from + (to - from) * t * t * (3.0 - 2.0 * t)) * 6.0 * t * (1.0 - t) * (to - from)
                })
            };
            let pieces = cuts.windows(2).map(|ends| piece(ends[0], ends[1]));
            SCATTERING / (4.0 * PI) * pieces.sum::<f64>()
        };
        let scene = scene(&light, 0.04);
        let truth: Vec<f64> =
            (0..SIZE * SIZE).into_par_iter().map(|pixel| pixel_mean(&scene, pixel, &radiance)).collect();
        // Beams of all light; and shadow rays for straight light, which have a quarter of their noise.
        for (way, method, passes) in [("beams", Method::Thesis, 12), ("shadow rays", Method::Covbeam, 2)] {
            let settings = Settings { planned: false, ..Settings::of(method, 20_000, 0) };
            let found = measured_by(&scene, settings, passes, rings(&truth));
            for (ring, [_, within]) in RINGS.iter().zip(found).skip(1) {
                println!("{name}, {way}, up to {} pixels: {:.4} ± {:.4}", ring[1], within.mean, within.error);
                // Kernels blur the lamp's light outwards: with the largest, .08 m, 1 %.
                let off = (within.mean - 1.0).abs();
                assert!(off < 0.01 + 4.0 * within.error, "{name}, {way}, {ring:?}: {within:?}");
                assert!(within.error < 0.015, "too noisy to tell: {within:?}");
            }
        }
    }
}

/// Pictures of the default after some passes, of several seeds.
fn by_default(scene: &Scene, passes: u32, seeds: u32) -> Vec<Vec<f64>> {
    let picture = |seed| {
        let mut renderer = Renderer::new(scene, Settings::of(Method::Covbeam, 2000, seed));
        let mut film = Film::new(SIZE, SIZE);
        for pass in 1..=passes {
            film.add(&renderer.pass(pass, &|| false).expect("not cancelled").0).expect("finite");
        }
        film.picture().radiance.iter().map(|color| f64::from(color.x)).collect()
    };
    (0..seeds).map(picture).collect()
}

/// Along an eye ray the light goes as one over its distance from the lamp: of the four pixels around it shadow rays alone stray by 10 % after so
/// many passes.
#[test]
fn the_pixels_of_a_lamp_need_few_passes() {
    let scene = scene(POINT, 0.05);
    let world = world(Emission::Even, DVec3::ZERO);
    let radiance = |_, eye: DVec3, direction: DVec3| world.radiance(eye, direction, 60).x;
    let middle = [(15, 15), (16, 15), (15, 16), (16, 16)].map(|(x, y)| y * SIZE + x);
    let truth: Vec<f64> = middle.into_iter().map(|pixel| pixel_mean(&scene, pixel, &radiance)).collect();
    let found: Vec<f64> = by_default(&scene, 64, 6)
        .iter()
        .flat_map(|picture| middle.iter().zip(&truth).map(|(&pixel, truth)| picture[pixel as usize] / truth))
        .collect();
    let sample = Sample::of(&found);
    let spread = sample.error * sample.count.sqrt();
    println!("{:.4} ± {:.4}, one of them ± {spread:.4}", sample.mean, sample.error);
    // The quadrature misses 1 %.
    assert!((sample.mean - 1.0).abs() < 0.01 + 4.0 * sample.error, "{sample:?}");
    assert!(spread < 0.07, "{spread}");
}

/// A cone that is thinner than a pixel is a line of light: W/m times σ_s/4π over the square of the distance from the camera, in each column of
/// pixels over the solid angle of one of them.
#[test]
fn a_cone_thinner_than_a_pixel_is_an_even_line() {
    let (start, half_angle) = (-0.9f64, 0.5f64);
    let scene = scene(
        &format!(
            "kind = \"spot\"\nposition = [{start}, 0.04, 0]\nlook_at = [1, 0.04, 0]\nintensity = 1.0\n\
             inner_angle = {}\nouter_angle = {half_angle}\n",
            0.999 * half_angle
        ),
        0.05,
    );
    let flux = 2.0 * PI * (1.0 - half_angle.to_radians().cos());
    let side = 2.0 / f64::from(SIZE);
    let truth = |column: u32| {
        let from = -1.0 + side * f64::from(column);
        let at = |x: f64| {
            let away = x.hypot(DISTANCE);
            let pixel = side * side * DISTANCE / away.powi(3);
            let left = (-(ABSORPTION + SCATTERING) * (x - start + away)).exp();
            flux * left * SCATTERING / (4.0 * PI) / (away * away * pixel)
        };
        integral([from, from + side], 20, at)
    };
    let pictures = by_default(&scene, 16, 4);
    let mut worst = 0.0f64;
    // The lamp's own column has a part of the line.
    for column in 0..29 {
        for picture in &pictures {
            let sum: f64 = (0..SIZE).map(|row| picture[(row * SIZE + column) as usize]).sum();
            // From the right the camera sees smaller x.
            worst = worst.max((sum / truth(SIZE - 1 - column) - 1.0).abs());
        }
    }
    println!("worst column of four pictures: {worst:.3}");
    // 2000 beams a pass are all in it, and what differs is how near to it the eye rays pass: shadow rays alone miss whole columns.
    assert!(worst < 0.3, "{worst}");
}
