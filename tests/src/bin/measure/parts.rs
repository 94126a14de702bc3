//! What each part of light by kind buys, and where the error that is left comes from.

use crate::budget::spend;
use crate::rendering::{load, name, print_heads};
use crate::{Outcome, Size};
use covbeam_render::study::report::{Compared, LIGHT_BY_KIND, PLACES, error_budget};
use covbeam_session::pass::Renderer;
use covbeam_session::scene::Scene;
use covbeam_session::settings::{Layers, Method, Settings};
use covbeam_tests::fleet::errors::Errors;
use covbeam_tests::fleet::runs::{Estimator, narrow};
use std::path::{Path, PathBuf};

/// First seeds of the reference's halves.
const REFERENCE_SEEDS: [u32; 2] = [5000, 6000];

/// A way to make a picture.
struct Variant {
    name: &'static str,
    method: Method,
    change: fn(&mut Settings),
}

const DEFAULT: Variant = Variant { name: "default", method: Method::Covbeam, change: |_| {} };

const VARIANTS: [Variant; 7] = [
    DEFAULT,
    Variant { name: "straight light by beams", change: |settings| settings.shadow_rays = false, ..DEFAULT },
    Variant {
        name: "paths as power goes",
        method: Method::Thesis,
        change: |settings| {
            *settings = Settings { shadow_rays: true, layers: Layers::Together, planned: true, ..*settings }
        },
    },
    Variant {
        name: "straight light in a layer of its own",
        change: |settings| settings.layers = Layers::StraightApart,
        ..DEFAULT
    },
    Variant { name: "an eye ray in every pixel", change: |settings| settings.planned = false, ..DEFAULT },
    Variant { name: "adaptive kernels alone (thesis)", method: Method::Thesis, ..DEFAULT },
    Variant { name: "plain beams", method: Method::Plain, ..DEFAULT },
];

impl Variant {
    fn renderer<'a>(&self, scene: &'a Scene, seed: u32) -> Renderer<'a> {
        let mut settings = Settings::of_scene(self.method, scene, seed);
        (self.change)(&mut settings);
        Renderer::new(scene, settings)
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
        "\nVariance of the default, with a layer for each kind of light, over the squared brightness; shares of each kind of light, at \
         silhouettes and shadows' borders on surfaces, in pixels that see glass or a mirror first, and elsewhere; and of light of all kinds \
         from the fog before the first surface\n"
    );
    let mut heads = vec!["scene", "passes", "relative variance", "kind of light"];
    heads.extend(PLACES);
    heads.push("fog");
    print_heads(&heads.iter().map(|head| (*head).to_owned()).collect::<Vec<_>>());
    for (path, column) in paths.iter().zip(&columns) {
        print_budget(&name(path), &load(path, size)?, column[0].passes, seeds)?;
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

fn print_budget(name: &str, scene: &Scene, passes: u32, seeds: u32) -> Outcome<()> {
    eprintln!("{name}: kinds of light");
    let method = Compared::named(LIGHT_BY_KIND).expect("a method of the table");
    let budget = error_budget(scene, method, passes, seeds, &|| false)?.expect("never cancelled");
    let percent = |share: f64| format!("{:.0} %", 100.0 * share);
    for (row, kind) in budget.kinds.iter().enumerate() {
        let mut cells = vec![name.to_owned(), passes.to_string(), format!("{:.1e}", budget.variance)];
        let mut fog = percent(budget.fog);
        if row > 0 {
            cells.fill(String::new());
            fog.clear();
        }
        cells.push(kind.kind.to_owned());
        cells.extend(kind.places.map(percent));
        println!("| {} | {fog} |", cells.join(" | "));
    }
    Ok(())
}
