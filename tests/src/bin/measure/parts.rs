//! What each part of light by kind buys, and where the error that is left comes from.

use crate::budget::spend;
use crate::rendering::{load, name, print_heads};
use crate::{Outcome, Size};
use covbeam_render::compare::luminance;
use covbeam_render::film::{Film, Picture};
use covbeam_render::pass::{Method, Parts, Renderer};
use covbeam_render::plan::FirstSurfaces;
use covbeam_render::scene::Scene;
use covbeam_tests::fleet::errors::Errors;
use covbeam_tests::fleet::runs::{Estimator, narrow};
use std::path::{Path, PathBuf};

/// First seeds of the reference's halves.
const REFERENCE_SEEDS: [u32; 2] = [5000, 6000];

/// A way to make a picture.
struct Variant {
    name: &'static str,
    method: Method,
    /// None: all light alike.
    parts: Option<Parts>,
    planned: bool,
}

const DEFAULT: Variant =
    Variant { name: "default", method: Method::Adaptive, parts: Some(Parts::DEFAULT), planned: true };

const VARIANTS: [Variant; 7] = [
    DEFAULT,
    Variant {
        name: "straight light by beams",
        parts: Some(Parts { straight: false, ..Parts::DEFAULT }),
        ..DEFAULT
    },
    Variant {
        name: "paths as power goes",
        parts: Some(Parts { guided: false, ..Parts::DEFAULT }),
        ..DEFAULT
    },
    Variant {
        name: "straight light in a layer of its own",
        parts: Some(Parts { apart: true, ..Parts::DEFAULT }),
        ..DEFAULT
    },
    Variant { name: "an eye ray in every pixel", planned: false, ..DEFAULT },
    Variant { name: "adaptive kernels alone (thesis)", parts: None, planned: false, ..DEFAULT },
    Variant { name: "plain beams", method: Method::Ppb, parts: None, planned: false },
];

impl Variant {
    fn renderer<'a>(&self, scene: &'a Scene, seed: u32) -> Renderer<'a> {
        let mut renderer = Renderer::new(scene, self.method, scene.settings.photons, seed);
        if let Some(parts) = self.parts {
            renderer.light_by_parts(parts);
        }
        if self.planned {
            renderer.plan_eye_rays();
        }
        renderer
    }
}

/// relMSE x CPU-seconds / budget, mean of the seeds, and passes of the first one.
struct Found {
    error: f64,
    passes: u32,
}

pub(crate) fn run(paths: &[PathBuf], seconds: f64, seeds: u32, reference: f64, size: Size) -> Outcome<()> {
    println!(
        "relMSE of the whole picture at {seconds} CPU-seconds, mean of {seeds} seeds, by products with two halves of plain beams at half the \
         radius, {reference} CPU-seconds each; passes in brackets\n"
    );
    print_heads(&["".to_owned()].into_iter().chain(paths.iter().map(|path| name(path))).collect::<Vec<_>>());
    let mut columns = Vec::new();
    for path in paths {
        let scene = load(path, size)?;
        columns.push(errors(path, &scene, seconds, seeds, reference)?);
    }
    for (row, variant) in VARIANTS.iter().enumerate() {
        let cells = columns.iter().map(|column| {
            let Found { error, passes } = column[row];
            format!("{error:.2e}, x {:.2} ({passes})", error / column[0].error)
        });
        println!("| {} | {} |", variant.name, cells.collect::<Vec<_>>().join(" | "));
    }
    println!(
        "\nVariance of the default, with a layer for each kind of light, over the squared brightness: share of each kind of light, at silhouettes and shadows' borders on \
         surfaces and elsewhere; and of light of all kinds from the fog before the first surface\n"
    );
    let heads = ["scene", "relative variance", "kind of light", "at edges [%]", "elsewhere [%]", "fog [%]"];
    print_heads(&heads.map(str::to_owned));
    for (path, column) in paths.iter().zip(&columns) {
        budget(&name(path), &load(path, size)?, column[0].passes, seeds)?;
    }
    Ok(())
}

/// Of all variants.
fn errors(path: &Path, scene: &Scene, seconds: f64, seeds: u32, reference: f64) -> Outcome<Vec<Found>> {
    let narrowed = narrow(scene);
    let mut halves = Vec::new();
    for seed in REFERENCE_SEEDS {
        eprintln!("{}: half of the reference, seed {seed}", name(path));
        let renderer = || Estimator::Reference.renderer(&narrowed, seed);
        halves.extend(spend(&narrowed, renderer, &[reference])?);
    }
    let halves = [&halves[0].picture, &halves[1].picture];
    let found = |variant: &Variant| {
        eprintln!("{}: {}", name(path), variant.name);
        let (mut error, mut passes) = (0.0, 0);
        for seed in 1..=seeds {
            let spent = spend(scene, || variant.renderer(scene, seed), &[seconds])?.remove(0);
            let found = Errors::new(&spent.picture, halves).rel_mse().value;
            error += found * spent.seconds / seconds / f64::from(seeds);
            passes = if seed == 1 { spent.passes } else { passes };
        }
        Ok(Found { error, passes })
    };
    VARIANTS.iter().map(found).collect()
}

/// Where the variance comes from.
fn budget(name: &str, scene: &Scene, passes: u32, seeds: u32) -> Outcome<()> {
    let mut pictures = Vec::new();
    for seed in 1..=seeds {
        eprintln!("{name}: kinds of light, seed {seed}");
        let mut renderer = DEFAULT.renderer(scene, seed);
        let mut film = Film::of_scene(scene);
        film.keep_kinds(renderer.keep_kinds());
        for pass in 1..=passes {
            film.add(&renderer.pass(pass, &|| false).expect("never cancelled").0)?;
        }
        pictures.push(film.picture());
    }
    let surfaces = FirstSurfaces::new(scene);
    let width = scene.camera.width;
    let has_edge = |pixel: usize| surfaces.has_edge(pixel as u32 % width, pixel as u32 / width);
    let light = |picture: &Picture, pixel: usize| f64::from(luminance(picture.radiance[pixel]));
    let pixels = pictures[0].radiance.len();
    let mean = |pixel: usize| pictures.iter().map(|p| light(p, pixel)).sum::<f64>() / pictures.len() as f64;
    let floor = (0..pixels).map(mean).sum::<f64>() / pixels as f64 * 0.01;
    // Of what `part` finds in each picture, at edges and elsewhere.
    let variance = |part: &dyn Fn(&Picture, usize) -> f64| {
        let mut sums = [0.0; 2];
        for pixel in 0..pixels {
            let values: Vec<f64> = pictures.iter().map(|picture| part(picture, pixel)).collect();
            let middle = values.iter().sum::<f64>() / values.len() as f64;
            let square = values.iter().map(|value| (value - middle).powi(2)).sum::<f64>();
            let variance = square / (values.len() - 1) as f64;
            sums[usize::from(!has_edge(pixel))] += variance / (mean(pixel).powi(2) + floor * floor);
        }
        sums.map(|sum| sum / pixels as f64)
    };
    let all: f64 = variance(&light).iter().sum();
    let fog = |picture: &Picture, pixel: usize| {
        picture.maps.as_ref().map_or(0.0, |maps| f64::from(luminance(maps.volume[pixel])))
    };
    let fog: f64 = variance(&fog).iter().sum();
    for (row, (kind, _)) in pictures[0].kinds.iter().enumerate() {
        let of_kind = |picture: &Picture, pixel: usize| f64::from(luminance(picture.kinds[row].1[pixel]));
        let [edges, elsewhere] = variance(&of_kind).map(|part| 100.0 * part / all);
        let first =
            if row == 0 { [name.to_owned(), format!("{all:.1e}")] } else { [String::new(), String::new()] };
        let fog = if row == 0 { format!("{:.0}", 100.0 * fog / all) } else { String::new() };
        println!("| {} | {} | {edges:.0} | {elsewhere:.0} | {fog} |", first.join(" | "), kind.name());
    }
    Ok(())
}
