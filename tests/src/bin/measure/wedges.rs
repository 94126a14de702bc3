//! Wedges of beams that run nearly along an eye ray: how bright they are after few passes, and whether their light is all there.

use crate::rendering::load_both;
use crate::{Outcome, Size};
use covbeam_render::files::output::write_png;
use covbeam_session::color::luminance;
use covbeam_session::film::{Film, Picture};
use covbeam_session::pass::Renderer;
use covbeam_session::settings::{Method, Settings};
use covbeam_tests::regions::{Region, of_ball};
use std::path::{Path, PathBuf};

const METHODS: [(&str, Method, bool); 3] = [
    ("plain", Method::Plain, false),
    ("adaptive, every pixel", Method::Thesis, false),
    ("adaptive, planned", Method::Thesis, true),
];

pub(crate) fn run(
    path: &Path,
    reference: &Path,
    passes: u32,
    seeds: u32,
    out: Option<PathBuf>,
    size: Size,
) -> Outcome<()> {
    let (scene, reference) = load_both(path, reference, size)?;
    let regions = of_ball(scene.camera.width);
    let smooth = regions.iter().find(|region| region.name == "smooth").ok_or("no region `smooth`")?;
    println!("{passes} passes, {seeds} seeds; pixels of the region `smooth` over the reference's:");
    println!(
        "| method | brightest | 99.9 % below | above 1.5 | above 1.25 | mean of the region | its standard error |"
    );
    println!("|---|---|---|---|---|---|---|");
    for (label, method, planned) in METHODS {
        let (mut ratios, mut means) = (Vec::new(), Vec::new());
        for seed in 1..=seeds {
            let mut renderer =
                Renderer::new(&scene, Settings { planned, ..Settings::of_scene(method, &scene, seed) });
            let mut film = Film::of_scene(&scene);
            for pass in 1..=passes {
                film.add(&renderer.pass(pass, &|| false).expect("never cancelled").0)?;
            }
            let picture = film.picture();
            if let (Some(folder), 1) = (&out, seed) {
                write_png(&folder.join(format!("{}.png", label.replace([',', ' '], "-"))), &picture)?;
            }
            let (brightness, mean) = against(&picture, &reference.picture, smooth);
            ratios.extend(brightness);
            means.push(mean);
        }
        ratios.sort_by(f64::total_cmp);
        let share = |least: f64| {
            100.0 * ratios.iter().filter(|ratio| **ratio > least).count() as f64 / ratios.len() as f64
        };
        let count = means.len() as f64;
        let mean = means.iter().sum::<f64>() / count;
        let variance = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (count - 1.0).max(1.0);
        println!(
            "| {label} | {:.2} | {:.2} | {:.3} % | {:.2} % | {:.4} | {:.4} |",
            ratios[ratios.len() - 1],
            ratios[ratios.len() * 999 / 1000],
            share(1.5),
            share(1.25),
            mean,
            (variance / count).sqrt()
        );
    }
    Ok(())
}

/// Each pixel of a region over the reference's, and the same of the region's mean.
fn against(picture: &Picture, reference: &Picture, region: &Region) -> (Vec<f64>, f64) {
    let (mut ratios, mut sums) = (Vec::new(), [0.0; 2]);
    for (index, (found, wanted)) in picture.radiance.iter().zip(&reference.radiance).enumerate() {
        let index = index as u32;
        if region.contains(index % picture.width, index / picture.width) {
            let [found, wanted] = [found, wanted].map(|radiance| f64::from(luminance(*radiance)));
            ratios.push(found / wanted);
            sums[0] += found;
            sums[1] += wanted;
        }
    }
    (ratios, sums[0] / sums[1])
}
