//! Planned eye rays: how the error falls over passes, and what the planning costs.

use crate::rendering::{cpu_seconds, in_region, load, load_reference, name, regions};
use crate::{Outcome, Size};
use covbeam_render::film::{Film, Picture};
use covbeam_render::pass::{Method, PassTimes, Renderer};
use covbeam_tests::statistics::slope;
use std::path::Path;
use std::time::Instant;

pub(crate) fn run(path: &Path, reference: &Path, passes: u32, seed: u32, size: Size) -> Outcome<()> {
    let scene = load(path, size)?;
    let reference = load_reference(reference, &scene)?;
    let regions = regions(path, &scene, Some(&reference));
    let mut renderer = Renderer::new(&scene, Method::Adaptive, scene.settings.photons, seed);
    let start = Instant::now();
    renderer.plan_eye_rays();
    let depth_seconds = start.elapsed().as_secs_f64();
    let mut film = Film::of_scene(&scene);
    let mut times = PassTimes::default();
    let mut curves = vec![Vec::new(); regions.len()];
    println!(
        "{}: relMSE over passes of {} light paths, with the reference's noise\n",
        name(path),
        scene.settings.photons
    );
    let names: Vec<&str> = regions.iter().map(|region| region.name).collect();
    println!("| passes | core-s | eye rays a pixel and pass | {} |", names.join(" | "));
    println!("|---|---|---|{}", "---|".repeat(names.len()));
    for index in 1..=passes {
        let (image, spent) = renderer.pass(index, &|| false).expect("never cancelled");
        film.add(&image)?;
        times += spent;
        if !index.is_power_of_two() {
            continue;
        }
        let picture = film.picture();
        let density = picture.maps.as_ref().map_or(&[][..], |maps| &maps.density);
        let mean_density = density.iter().map(|d| f64::from(*d)).sum::<f64>() / density.len() as f64;
        print!("| {index} | {:.2} | {mean_density:.3} |", times.total());
        for (curve, region) in curves.iter_mut().zip(&regions) {
            let error = in_region(&picture, &reference, region)?.rel_mse;
            curve.push((f64::from(index), error));
            print!(" {error:.2e} |");
        }
        println!();
    }
    print!("| slope, last half | | |");
    for curve in &curves {
        // Of the logarithms, over the later half of the powers of two.
        let points: Vec<[f64; 2]> =
            curve[curve.len() / 2..].iter().map(|(passes, error)| [passes.ln(), error.ln()]).collect();
        print!(" {:.2} |", slope(&points));
    }
    println!();
    // The CPU clock ticks a hundred times a second.
    const REPEATS: u32 = 10;
    let start = cpu_seconds()?;
    let pictures: Vec<Picture> = (0..REPEATS).map(|_| film.picture()).collect();
    let reconstruction = (cpu_seconds()? - start) / f64::from(REPEATS);
    let (width, height) = (pictures[0].width, pictures[0].height);
    let share = |seconds: f64| 100.0 * seconds / times.total();
    println!(
        "\nthe depths of the first surfaces took {:.1} ms, once; planning {:.2} ms a pass, {:.2} % of the core time of {passes} passes; a \
         reconstruction of {width} x {height} pixels {:.0} ms of CPU time, {:.2} % of it",
        1e3 * depth_seconds,
        1e3 * times.plan / f64::from(passes),
        share(times.plan),
        1e3 * reconstruction,
        share(reconstruction),
    );
    Ok(())
}
