//! What low-discrepancy emission is worth.

use crate::rendering::{Run, in_region, load, regions};
use crate::{Outcome, Size};
use covbeam_session::random::Emission;
use covbeam_session::scene::{Material, Scene, SceneMedium};
use covbeam_session::settings::Method;
use glam::Vec3;
use std::path::Path;

/// Scales scattering down by a thousand at equal extinction and makes diffuse surfaces black: the second order of
/// scattering is lost in the first.
fn scatter_once(scene: &mut Scene) {
    for SceneMedium { medium, .. } in &mut scene.media {
        let extinction = medium.extinction();
        medium.scattering *= 1e-3;
        medium.absorption = extinction - medium.scattering;
    }
    for object in &mut scene.objects {
        if let Material::Lambert { albedo } = &mut object.material {
            *albedo = Vec3::ZERO;
        }
    }
}

pub(crate) fn run(path: &Path, passes: u32, pairs: u32, size: Size) -> Outcome<()> {
    println!("noise (relMSE) after {passes} passes: independent photons, low-discrepancy photons, ratio");
    for single in [false, true] {
        let mut scene = load(path, size)?;
        let regions = regions(path, &scene, None);
        if single {
            scatter_once(&mut scene);
        }
        for (name, method) in [("ppb", Method::Plain), ("adaptive", Method::Thesis)] {
            let mut noise = [vec![0.0; regions.len()], vec![0.0; regions.len()]];
            for (noise, emission) in noise.iter_mut().zip([Emission::Independent, Emission::LowDiscrepancy]) {
                for pair in 0..pairs {
                    let picture = |seed| Run { emission, ..Run::new(&scene, method, seed, passes) }.picture();
                    let ((a, _), (b, _)) = (picture(2 * pair + 1)?, picture(2 * pair + 2)?);
                    for (noise, region) in noise.iter_mut().zip(&regions) {
                        *noise += 0.5 * in_region(&a, &b, region)?.rel_mse / f64::from(pairs);
                    }
                }
            }
            println!("{name}, {}", if single { "single scattering" } else { "the scene as it is" });
            for (i, region) in regions.iter().enumerate() {
                let [independent, low] = [noise[0][i], noise[1][i]];
                println!("  {:8} {independent:.2e} {low:.2e} {:6.2}", region.name, independent / low);
            }
        }
    }
    Ok(())
}
