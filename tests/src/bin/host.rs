//! Whether a host and the Rust renderer make the same picture at equal work, and one as noisy.
//!
//! `host NAME SCENE.toml PASSES PHOTONS PICTURE.pfm...`: NAME is one of [`HOSTS`]; the host's pictures, of one size and with different
//! seeds, of the scene. It is rendered as often by what the host does (of kernels, beams as wide as the covariance allows and an eye ray through
//! every pixel; of a session, the default method, with PHOTONS 0 as many as the scene asks for), at that size, with seeds of its own and at equal
//! work. Fails where the mean radiance of a region differs (Welch's t-test), and where the host's error is more than [`Host::more`] times the
//! renderer's.

use covbeam::{GridLayout, Schedule};
use covbeam_render::scene_file;
use covbeam_session::film::Film;
use covbeam_session::pass::Renderer;
use covbeam_session::render::{Goal, render};
use covbeam_session::scene::Scene;
use covbeam_session::settings::{Method, Settings};
use covbeam_tests::statistics::{Sample, sidak, welch};
use glam::Vec3;
use std::convert::Infallible;
use std::error::Error;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

/// Largest error of a host over the renderer's, where many pictures tell.
const MORE: f64 = 1.1;

/// Regions that are compared of pictures of examples/embree.
const EMBREE: [Region; 4] = [
    ("whole", |_, _| true),
    ("upper", |_, y| y < -40.0),
    ("lower", |_, y| y > 60.0),
    ("middle", |x, y| x.hypot(y) < 40.0),
];

/// A grey picture, row by row from the upper left pixel.
struct Grey {
    size: [usize; 2],
    radiance: Vec<f64>,
}

/// So many pictures or fewer do not tell how often a pixel is far too bright.
const FEW: usize = 5;

/// A name, and which points (x, y) of a picture 256 wide belong to it; from the middle, y downwards.
type Region = (&'static str, fn(f32, f32) -> bool);

/// Numbers of a host that gathers itself, for other kernels have another bias and another noise.
struct Kernels {
    grid: GridLayout,
    radius: f32,
    alpha: f32,
    max_radius: f32,
    error: f32,
    /// Scatterings of its light before the one that sends it to the camera.
    bounces: Option<u32>,
}

/// An example of a host.
struct Host {
    name: &'static str,
    /// None: it has a session.
    kernels: Option<Kernels>,
    /// Those of which the means are compared.
    regions: &'static [Region],
    /// What the errors are compared in.
    judged: Region,
    /// Largest error over the renderer's.
    more: f64,
}

const HOSTS: [Host; 4] = [
    // examples/c. The ball has a radius of 44. The lamp stands at the upper left, so the caustic runs to the lower right.
    Host {
        name: "glass-ball",
        kernels: Some(Kernels {
            grid: GridLayout { min: Vec3::new(-3.0, -3.0, -4.0), max: Vec3::splat(3.0), cells: [32; 3] },
            radius: 0.05,
            alpha: 0.5,
            max_radius: 0.1,
            error: 0.01,
            bounces: None,
        }),
        regions: &[
            ("whole", |_, _| true),
            ("left", |x, _| x < -60.0),
            ("right", |x, _| x > 60.0),
            ("ball", |x, y| x.hypot(y) < 40.0),
            ("caustic", |x, y| beyond_ball(x, y) && from_axis(x, y) < 8.0),
            ("shadow", |x, y| beyond_ball(x, y) && (14.0..30.0).contains(&from_axis(x, y))),
        ],
        judged: ("whole", |_, _| true),
        more: MORE,
    },
    // examples/cpp, which leaves out light that comes from elsewhere than the lamp to the ball and the floor: above that, beside the ball.
    Host {
        name: "shaft",
        kernels: Some(Kernels {
            grid: GridLayout {
                min: Vec3::new(-4.0, 0.0, -7.0),
                max: Vec3::new(4.0, 5.0, 4.0),
                cells: [32; 3],
            },
            radius: 0.04,
            alpha: 0.5,
            max_radius: 0.15,
            error: 0.01,
            bounces: None,
        }),
        regions: &[],
        judged: ("air", |x, y| y < 20.0 && x.hypot(y + 18.0) > 32.0),
        more: MORE,
    },
    // examples/python.
    Host {
        name: "shadow",
        kernels: Some(Kernels {
            grid: GridLayout {
                min: Vec3::new(-3.0, -3.0, -5.0),
                max: Vec3::new(3.0, 3.0, 5.0),
                cells: [24, 24, 40],
            },
            radius: 0.05,
            alpha: 0.8,
            max_radius: 0.3,
            error: 0.003,
            bounces: Some(0),
        }),
        regions: &[("air", beside_ball)],
        judged: ("air", beside_ball),
        more: MORE,
    },
    // examples/embree: of a few pictures, whose errors scatter.
    Host { name: "embree", kernels: None, regions: &EMBREE, judged: ("whole", |_, _| true), more: 1.4 },
];

/// Not on the ball of examples/python.
fn beside_ball(x: f32, y: f32) -> bool {
    x.hypot(y) > 48.0
}

/// On the side of the ball that the lamp does not see.
fn beyond_ball(x: f32, y: f32) -> bool {
    y > 0.0 && (48.0..120.0).contains(&x.hypot(y))
}

/// Distance from the line through the lamp, at (-1, -2.4) units, and the ball's centre.
fn from_axis(x: f32, y: f32) -> f32 {
    ((2.4 * x - y) / 2.6).abs()
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match run(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("host: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &[String]) -> Result<(), Box<dyn Error>> {
    let [name, scene, passes, photons, files @ ..] = arguments else {
        return Err("usage: host NAME SCENE.toml PASSES PHOTONS PICTURE.pfm...".into());
    };
    let host = HOSTS.iter().find(|host| host.name == name);
    let host = host.ok_or_else(|| format!("{name}: not one of {:?}", HOSTS.map(|host| host.name)))?;
    let (passes, photons) = (passes.parse()?, photons.parse()?);
    let pictures = files.iter().map(|file| read_pfm(Path::new(file))).collect::<Result<Vec<_>, _>>()?;
    let size = pictures.first().map_or([0; 2], |picture| picture.size);
    if pictures.len() < 2 || pictures.iter().any(|picture| picture.size != size) {
        return Err("two pictures or more, of one size: their scatter is the measure".into());
    }
    let mut scene = scene_file::load(Path::new(scene))?;
    let [width, height] = size;
    (scene.camera.width, scene.camera.height) = (width as u32, height as u32);
    if let Some(Kernels { grid, radius, alpha, max_radius, error, bounces }) = host.kernels {
        let shape = scene.settings.schedule.shape;
        scene.grid = grid;
        scene.settings.schedule = Schedule { shape, radius, alpha, max_radius, error };
        scene.settings.bounces = bounces;
    }
    let settings = |seed| match (&host.kernels, photons) {
        (Some(_), photons) => Settings::of(Method::Thesis, photons, seed),
        (None, 0) => Settings::of_scene(Method::Covbeam, &scene, seed),
        (None, photons) => Settings::of(Method::Covbeam, photons, seed),
    };
    let seeds = 1001..=1000 + pictures.len() as u32;
    let rust: Vec<Grey> =
        seeds.map(|seed| picture(&scene, passes, settings(seed))).collect::<Result<_, _>>()?;

    let inside = |contains: fn(f32, f32) -> bool| -> Vec<usize> {
        let place = |i: usize, side: usize| (i as f32 + 0.5 - 0.5 * side as f32) * 256.0 / width as f32;
        (0..width * height).filter(|i| contains(place(i % width, width), place(i / width, height))).collect()
    };
    let level = sidak(0.01, host.regions.len().max(1));
    println!(
        "{name}: {} runs of {passes} x {photons} light paths each; Welch's t-test rejects below {level:.1e}",
        pictures.len()
    );
    println!("         host               Rust               p");
    let mut differ = Vec::new();
    for (name, contains) in host.regions {
        let pixels = inside(*contains);
        let (a, b) = (region_mean(&pictures, &pixels), region_mean(&rust, &pixels));
        let p = welch(a, b);
        let show = |s: Sample| format!("{:.5} ± {:.2} %", s.mean, 100.0 * s.error / s.mean);
        println!("{name:8} {:18} {:18} {p:.4}", show(a), show(b));
        if p < level {
            differ.push(*name);
        }
    }
    let (name, contains) = host.judged;
    let pixels = inside(contains);
    let [theirs, ours] = errors(&pictures, &rust, &pixels);
    println!(
        "{name:8} relative squared error: host {theirs:.3e}, Rust {ours:.3e}, {:.2} of it",
        theirs / ours
    );
    if !differ.is_empty() {
        return Err(format!("the means differ: {}", differ.join(", ")).into());
    }
    // Nor where a pixel is black in all pictures.
    if !(theirs <= host.more * ours) {
        return Err(format!("the host's error is {:.2} times the renderer's", theirs / ours).into());
    }
    Ok(())
}

/// The mean of each picture over some pixels.
fn region_mean(pictures: &[Grey], pixels: &[usize]) -> Sample {
    let mean = |p: &Grey| pixels.iter().map(|i| p.radiance[*i]).sum::<f64>() / pixels.len() as f64;
    Sample::of(&pictures.iter().map(mean).collect::<Vec<_>>())
}

/// Relative squared error of a picture of the host and of one of the renderer, means over some pixels. Both from the mean of the renderer's: fog
/// that is blurred as in no picture of that is an error, too. Means over pictures; of [`FEW`] medians, where one pixel that is ten times too bright
/// would be a fifth of the mean.
fn errors(host: &[Grey], rust: &[Grey], pixels: &[usize]) -> [f64; 2] {
    let count = rust.len() as f64;
    let mean = |&i: &usize| rust.iter().map(|picture| picture.radiance[i]).sum::<f64>() / count;
    let means: Vec<f64> = pixels.iter().map(mean).collect();
    let error = |picture: &Grey| {
        let square = |(&i, mean): (&usize, &f64)| (picture.radiance[i] / mean - 1.0).powi(2);
        pixels.iter().zip(&means).map(square).sum::<f64>() / pixels.len() as f64
    };
    let middle = |pictures: &[Grey]| {
        let mut errors: Vec<f64> = pictures.iter().map(error).collect();
        if errors.len() > FEW {
            return errors.iter().sum::<f64>() / errors.len() as f64;
        }
        errors.sort_by(f64::total_cmp);
        0.5 * (errors[(errors.len() - 1) / 2] + errors[errors.len() / 2])
    };
    // A picture is nearer to a mean that it has a part in.
    [middle(host), middle(rust) * (count + 1.0) / (count - 1.0)]
}

fn picture(scene: &Scene, passes: u32, settings: Settings) -> Result<Grey, Box<dyn Error>> {
    let mut renderer = Renderer::new(scene, settings);
    let mut film = Film::of_scene(scene);
    let pass = |index, cancelled: &(dyn Fn() -> bool + Sync)| renderer.pass(index, cancelled);
    let goal = Goal { passes: Some(passes), ..Goal::default() };
    render(&mut film, &goal, Instant::now(), &|| false, pass, |_, _| Ok::<_, Infallible>(None))?;
    let grey = |radiance: &Vec3| f64::from(radiance.element_sum()) / 3.0;
    let radiance = film.picture().radiance.iter().map(grey).collect();
    Ok(Grey { size: [scene.camera.width, scene.camera.height].map(|side| side as usize), radiance })
}

/// A portable float map, in this machine's byte order; rows come from the bottom.
fn read_pfm(file: &Path) -> Result<Grey, Box<dyn Error>> {
    let refuse = |what: &str| Box::<dyn Error>::from(format!("{}: {what}", file.display()));
    let bytes = std::fs::read(file).map_err(|error| refuse(&error.to_string()))?;
    let mut parts = bytes.splitn(4, |byte| *byte == b'\n');
    let mut line = || std::str::from_utf8(parts.next().unwrap_or_default()).unwrap_or_default();
    let (kind, sides, order) = (line(), line(), line());
    let side = |part: Option<&str>| {
        part.and_then(|side| side.parse::<usize>().ok()).ok_or_else(|| refuse("no size"))
    };
    let mut numbers = sides.split(' ');
    let size @ [width, height] = [side(numbers.next())?, side(numbers.next())?];
    let is_native = order.parse().is_ok_and(|order: f32| (order < 0.0) == cfg!(target_endian = "little"));
    let channels = if kind == "PF" { 3 } else { 1 };
    if !["PF", "Pf"].contains(&kind) || sides != format!("{width} {height}") || !is_native {
        return Err(refuse("not a picture in this machine's byte order"));
    }
    let (values, rest) = parts.next().unwrap_or_default().as_chunks::<4>();
    if values.len() != channels * width * height || !rest.is_empty() {
        return Err(refuse("too short or too long"));
    }
    let grey = |pixel: &[[u8; 4]]| {
        pixel.iter().map(|value| f64::from(f32::from_ne_bytes(*value))).sum::<f64>() / channels as f64
    };
    let radiance: Vec<f64> =
        values.chunks(channels * width).rev().flat_map(|row| row.chunks(channels).map(grey)).collect();
    if radiance.iter().any(|value| !(value.is_finite() && *value >= 0.0)) {
        return Err(refuse("a pixel is not finite or below 0"));
    }
    Ok(Grey { size, radiance })
}
