//! `covbeam spectrum`: the truth test from a scene file to tables and plots on the disk.

use crate::commands::cli::{LineArgument, SpectrumArgs};
use crate::commands::failure::{Refused, Usage};
use crate::commands::stop::Stop;
use covbeam::GridLayout;
use covbeam_render::files::output::{check_writable, replace_file};
use covbeam_render::progress::{Display, say};
use covbeam_render::scene_file;
use covbeam_render::study::spectrum::{
    Analysis, BATCHES, Line, Options, Point, Prediction, analyse, default_lines, default_points,
    draw_gaussians, draw_lines, draw_slice, focus, summary, write_table,
};
use covbeam_session::scene::Scene;
use glam::Vec3;
use std::error::Error;
use std::io::{BufWriter, Write, stdout};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Most voxels: their 16 batches take 256 bytes each.
const MOST_VOXELS: usize = 1 << 21;

/// What is written into the folder.
const FILES: [&str; 7] =
    ["summary.txt", "table.csv", "lines.svg", "gaussians.svg", "slice-x.svg", "slice-y.svg", "slice-z.svg"];

pub(crate) fn run(args: &SpectrumArgs) -> Result<ExitCode, Box<dyn Error>> {
    let scene = scene_file::load(&args.scene)?;
    let name = args.scene.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let options = options(args, &scene);
    let layout = GridLayout { cells: options.cells, ..scene.grid };
    check_places(args, &layout)?;
    if layout.cell_count() > MOST_VOXELS {
        let [x, y, z] = layout.cells;
        return Err(Refused(format!(
            "{}: a grid of {x} x {y} x {z} voxels is too large for this test; choose one of at most 128³, with --grid",
            args.scene.display()
        ))
        .into());
    }
    let folder = args.out.clone().unwrap_or_else(|| PathBuf::from(format!("{name}-spectrum")));
    std::fs::create_dir_all(&folder).map_err(|error| {
        format!("cannot create the folder {}: {error}; choose another with --out", folder.display())
    })?;
    for file in FILES {
        check_writable(&folder.join(file))?;
    }

    let stop = Stop::on_signals()?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(args.threads as usize).build()?;
    let display = Display::new();
    let report = |share: f64| {
        display.show(&format!("{:.0} % of the light paths", 100.0 * share), share);
        !stop.is_asked()
    };
    let analysis = pool.install(|| analyse(&scene, &options, &report));
    display.finish();
    let Some(analysis) = analysis else {
        say("stopped before the measurement was finished: nothing is written");
        return Ok(stop.exit_code());
    };
    save(args, &scene, &analysis, &name, &folder)
}

fn options(args: &SpectrumArgs, scene: &Scene) -> Options {
    let settings = &scene.settings;
    let share = args.share.unwrap_or(settings.light_field_share);
    let field_paths = ((settings.photons as f32 * share).round() as u32).clamp(1, settings.photons);
    Options {
        cells: args.grid.map_or(scene.grid.cells, |n| [n; 3]),
        prediction: Prediction {
            passes: args.passes.unwrap_or(settings.passes),
            field_paths,
            seed: args.seed.unwrap_or(settings.seed),
        },
        paths: args.photons.next_multiple_of(BATCHES),
    }
}

fn check_places(args: &SpectrumArgs, layout: &GridLayout) -> Result<(), Usage> {
    let (min, max) = (layout.min, layout.max);
    let inside = |point: &Vec3| point.cmpge(min).all() && point.cmple(max).all();
    let points = args.points.iter().chain(args.lines.iter().flat_map(|line| [&line.from, &line.to]));
    match points.into_iter().find(|point| !inside(point)) {
        None => Ok(()),
        Some(point) => {
            let text =
                format!("the point {point} lies outside the scene's grid, which reaches from {min} to {max}");
            Err(Usage(text))
        }
    }
}

fn save(
    args: &SpectrumArgs,
    scene: &Scene,
    analysis: &Analysis,
    name: &str,
    folder: &Path,
) -> Result<ExitCode, Box<dyn Error>> {
    let lines: Vec<Line> = match args.lines.as_slice() {
        [] => default_lines(analysis),
        lines => lines.iter().map(|&LineArgument { from, to }| Line { from, to }).collect(),
    };
    let points: Vec<Point> = match args.points.as_slice() {
        [] => default_points(analysis, scene),
        points => points.iter().filter_map(|point| Point::at(analysis, *point)).collect(),
    };
    let through =
        points.first().filter(|_| !args.points.is_empty()).map_or_else(|| focus(analysis), |p| p.cell);
    let text = summary(analysis, name);
    let write =
        |file: &str, content: &str| replace_file(&folder.join(file), |out| out.write_all(content.as_bytes()));
    replace_file(&folder.join("table.csv"), |out| {
        let mut out = BufWriter::new(out);
        write_table(analysis, &mut out)?;
        out.flush()
    })?;
    write("lines.svg", &draw_lines(analysis, &lines)?)?;
    write("gaussians.svg", &draw_gaussians(analysis, &points)?)?;
    for (normal, file) in ["slice-x.svg", "slice-y.svg", "slice-z.svg"].into_iter().enumerate() {
        write(file, &draw_slice(analysis, through, normal)?)?;
    }
    write("summary.txt", &text)?;
    let wrote = format!("\nwrote {} into {}\n", FILES.join(", "), folder.display());
    stdout().write_all((text + &wrote).as_bytes())?;
    Ok(ExitCode::SUCCESS)
}
