//! Means of regions, which all methods must agree on.

use crate::rendering::{Run, in_region, load, load_both, name, regions};
use crate::{Outcome, Size};
use covbeam_session::settings::Method;
use covbeam_tests::regions::is_ball;
use covbeam_tests::statistics::{Sample, sidak, welch};
use std::path::Path;

pub(crate) fn run(path: &Path, reference: Option<&Path>, runs: u32, size: Size) -> Outcome<()> {
    let (scene, reference) = match reference {
        Some(reference) => {
            load_both(path, reference, size).map(|(scene, found)| (scene, Some(found.picture)))?
        }
        None => (load(path, size)?, None),
    };
    // The light tracer sees neither the glass nor anything through it.
    let blind: &[&str] = if is_ball(&name(path)) { &["whole", "glass"] } else { &[] };
    let mut compared = regions(path, &scene, reference.as_ref());
    compared.retain(|region| !blind.contains(&region.name));
    let methods = [
        ("ppb", Method::Plain, 16, scene.settings.photons),
        ("adaptive", Method::Thesis, 8, scene.settings.photons),
        ("light-trace", Method::LightTrace, 1, 2_000_000),
    ];
    let mut values: Vec<Vec<Vec<f64>>> = Vec::new();
    for (name, method, passes, photons) in methods {
        let mut by_region = vec![Vec::new(); compared.len()];
        for seed in 1..=runs {
            // Seeds of one method never meet those of another.
            let seed = 100_000 * (values.len() as u32 + 1) + seed;
            let (picture, _) = Run { photons, ..Run::new(&scene, method, seed, passes) }.picture()?;
            for (values, region) in by_region.iter_mut().zip(&compared) {
                values.push(in_region(&picture, &picture, region)?.mean);
            }
        }
        eprintln!("{name}: {runs} runs of {passes} x {photons} paths");
        values.push(by_region);
    }
    let level = sidak(0.01, 3 * compared.len());
    println!("region means (luminance) and two-sided p-values of Welch's t-test; reject below {level:.1e}");
    for (index, region) in compared.iter().enumerate() {
        let [p, a, l] = [0, 1, 2].map(|method| Sample::of(&values[method][index]));
        let show = |s: Sample| format!("{:.5} ± {:.2} %", s.mean, 100.0 * s.error / s.mean);
        println!(
            "{:8} ppb {}   adaptive {}   light-trace {}   p(ppb, adaptive) {:.3}  p(ppb, light) {:.3}  p(adaptive, light) {:.3}",
            region.name,
            show(p),
            show(a),
            show(l),
            welch(p, a),
            welch(p, l),
            welch(a, l)
        );
        if let Some(reference) = &reference {
            let mean = in_region(reference, reference, region)?.mean;
            let off = |s: Sample| format!("{:+.2} σ", (mean - s.mean) / s.error);
            println!(
                "         reference {mean:.5}: {} from ppb, {} from adaptive, {} from light-trace",
                off(p),
                off(a),
                off(l)
            );
        }
        if welch(p, a) < level || welch(p, l) < level || welch(a, l) < level {
            return Err(format!("the means of '{}' differ", region.name).into());
        }
    }
    Ok(())
}
