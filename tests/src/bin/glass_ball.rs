//! Whether a C host and the Rust renderer make the same picture of `examples/scenes/open-glass-ball.toml`.
//!
//! `glass_ball SCENE PASSES PHOTONS PICTURE.pfm...`: the host's pictures, of one size and with different seeds. The
//! scene is rendered as often, at that size, with seeds of its own and at equal work. Fails where the mean radiance
//! of a region differs (Welch's t-test).

use covbeam::{GridLayout, Schedule};
use covbeam_render::film::Film;
use covbeam_render::pass::{Method, Renderer};
use covbeam_render::render::{Goal, render};
use covbeam_render::scene::Scene;
use covbeam_tests::statistics::{Sample, sidak, welch};
use glam::Vec3;
use std::convert::Infallible;
use std::error::Error;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

/// A square grey picture, row by row from the upper left pixel.
struct Grey {
    size: usize,
    radiance: Vec<f64>,
}

/// A name, and which points (x, y) of a picture 256 wide belong to it; from the middle, y downwards.
type Region = (&'static str, fn(f32, f32) -> bool);

/// The ball has a radius of 44. The lamp stands at the upper left, so the caustic runs to the lower right.
const REGIONS: [Region; 6] = [
    ("whole", |_, _| true),
    ("left", |x, _| x < -60.0),
    ("right", |x, _| x > 60.0),
    ("ball", |x, y| x.hypot(y) < 40.0),
    ("caustic", |x, y| beyond_ball(x, y) && from_axis(x, y) < 8.0),
    ("shadow", |x, y| beyond_ball(x, y) && (14.0..30.0).contains(&from_axis(x, y))),
];

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
            eprintln!("glass_ball: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &[String]) -> Result<(), Box<dyn Error>> {
    let [scene, passes, photons, files @ ..] = arguments else {
        return Err("usage: glass_ball SCENE.toml PASSES PHOTONS PICTURE.pfm...".into());
    };
    let (passes, photons) = (passes.parse()?, photons.parse()?);
    let host = files.iter().map(|file| read_pfm(Path::new(file))).collect::<Result<Vec<_>, _>>()?;
    let size = host.first().map_or(0, |picture| picture.size);
    if host.len() < 2 || host.iter().any(|picture| picture.size != size) {
        return Err("two pictures or more, of one size: their scatter is the measure".into());
    }
    let mut scene = Scene::load(Path::new(scene))?;
    (scene.camera.width, scene.camera.height) = (size as u32, size as u32);
    // VOXELS and SCHEDULE of the C program: other kernels have another bias.
    scene.grid = GridLayout { min: Vec3::new(-3.0, -3.0, -4.0), max: Vec3::splat(3.0), cells: [32; 3] };
    let shape = scene.settings.schedule.shape;
    scene.settings.schedule = Schedule { shape, radius: 0.05, alpha: 0.5, max_radius: 0.1, error: 0.01 };
    let seeds = 1001..=1000 + host.len() as u32;
    let rust: Vec<Grey> =
        seeds.map(|seed| picture(&scene, passes, photons, seed)).collect::<Result<_, _>>()?;

    let level = sidak(0.01, REGIONS.len());
    println!(
        "{} runs of {passes} x {photons} light paths each; Welch's t-test rejects below {level:.1e}",
        host.len()
    );
    println!("         host               Rust               p       noise of a pixel: host, Rust");
    let mut differ = Vec::new();
    for (name, contains) in REGIONS {
        let place = |i: usize| (i as f32 + 0.5) * 256.0 / size as f32 - 128.0;
        let inside: Vec<usize> =
            (0..size * size).filter(|i| contains(place(i % size), place(i / size))).collect();
        let (a, b) = (region_mean(&host, &inside), region_mean(&rust, &inside));
        let p = welch(a, b);
        let show = |s: Sample| format!("{:.5} ± {:.2} %", s.mean, 100.0 * s.error / s.mean);
        let noise = |pictures| 100.0 * pixel_noise(pictures, &inside);
        println!(
            "{name:8} {:18} {:18} {p:.4}  {:.1} %, {:.1} %",
            show(a),
            show(b),
            noise(&host),
            noise(&rust)
        );
        if p < level {
            differ.push(name);
        }
    }
    if differ.is_empty() { Ok(()) } else { Err(format!("the means differ: {}", differ.join(", ")).into()) }
}

/// The mean of each picture over some pixels.
fn region_mean(pictures: &[Grey], pixels: &[usize]) -> Sample {
    let mean = |p: &Grey| pixels.iter().map(|i| p.radiance[*i]).sum::<f64>() / pixels.len() as f64;
    Sample::of(&pictures.iter().map(mean).collect::<Vec<_>>())
}

/// Root mean square of the relative standard deviation of some pixels from picture to picture.
fn pixel_noise(pictures: &[Grey], pixels: &[usize]) -> f64 {
    let relative_variance = |i: &usize| {
        let sample = Sample::of(&pictures.iter().map(|p| p.radiance[*i]).collect::<Vec<_>>());
        sample.count * (sample.error / sample.mean).powi(2)
    };
    (pixels.iter().map(relative_variance).sum::<f64>() / pixels.len() as f64).sqrt()
}

fn picture(scene: &Scene, passes: u32, photons: u32, seed: u32) -> Result<Grey, Box<dyn Error>> {
    let mut renderer = Renderer::new(scene, Method::Adaptive, photons, seed);
    let mut film = Film::of_scene(scene);
    let pass = |index, cancelled: &(dyn Fn() -> bool + Sync)| renderer.pass(index, cancelled);
    let goal = Goal { passes: Some(passes), ..Goal::default() };
    render(&mut film, &goal, Instant::now(), &|| false, pass, |_, _| Ok::<_, Infallible>(None))?;
    let grey = |radiance: &Vec3| f64::from(radiance.element_sum()) / 3.0;
    let radiance = film.picture().radiance.iter().map(grey).collect();
    Ok(Grey { size: scene.camera.width as usize, radiance })
}

/// A square portable float map with three channels, in this machine's byte order; rows come from the bottom.
fn read_pfm(file: &Path) -> Result<Grey, Box<dyn Error>> {
    let refuse = |what: &str| Box::<dyn Error>::from(format!("{}: {what}", file.display()));
    let bytes = std::fs::read(file).map_err(|error| refuse(&error.to_string()))?;
    let mut parts = bytes.splitn(4, |byte| *byte == b'\n');
    let mut line = || std::str::from_utf8(parts.next().unwrap_or_default()).unwrap_or_default();
    let (kind, sides, order) = (line(), line(), line());
    let size: usize = sides.split(' ').next().unwrap_or_default().parse().map_err(|_| refuse("no size"))?;
    let native = if cfg!(target_endian = "little") { "-1.0" } else { "1.0" };
    if kind != "PF" || sides != format!("{size} {size}") || order != native {
        return Err(refuse("not a square picture with three channels in this machine's byte order"));
    }
    let (pixels, rest) = parts.next().unwrap_or_default().as_chunks::<12>();
    if pixels.len() != size * size || !rest.is_empty() {
        return Err(refuse("too short or too long"));
    }
    let grey = |pixel: &[u8; 12]| {
        let (channels, _) = pixel.as_chunks::<4>();
        channels.iter().map(|channel| f64::from(f32::from_ne_bytes(*channel))).sum::<f64>() / 3.0
    };
    let radiance: Vec<f64> = pixels.chunks(size).rev().flatten().map(grey).collect();
    if radiance.iter().any(|value| !(value.is_finite() && *value > 0.0)) {
        return Err(refuse("a pixel is black or not finite"));
    }
    Ok(Grey { size, radiance })
}
