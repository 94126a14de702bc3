//! Fog under an even sky, whose light has a closed form with any number of scatterings.

use covbeam_render::scene_file;
use covbeam_session::film::Film;
use covbeam_session::pass::Renderer;
use covbeam_session::settings::{Method, Settings};
use covbeam_tests::statistics::Sample;
use std::path::Path;

const SIZE: u32 = 16;
const SCATTERING: f64 = 0.8;

/// Wherever one looks there is the sky's radiance, as long as nothing is absorbed; what is seen through the fog, e^-τ of it, is missing where nothing
/// is behind.
#[test]
fn fog_that_absorbs_nothing_is_as_bright_as_an_even_sky_but_for_what_is_seen_through_it() {
    let text = format!(
        "[camera]\nposition = [0, 0, -6]\nlook_at = [0, 0, 0]\nvertical_fov = 15\nwidth = {SIZE}\nheight = {SIZE}\n\
         [[medium]]\nname = \"fog\"\nscattering = {SCATTERING}\nabsorption = 0\n\
         [[object]]\nshape = \"box\"\nmin = [-1, -1, -1]\nmax = [1, 1, 1]\nmaterial = {{ dielectric = {{ index = 1 }} }}\ninside = \"fog\"\n\
         [[light]]\nkind = \"sky\"\nradiance = 2\nvisible = false\n"
    );
    let scene = scene_file::parse(&text, "sky", Path::new("")).expect("a valid scene");
    // Rays are at most 10° aslant: each crosses front and back, 2 m along z.
    let expected = |pixel: u32| {
        let [x, y] = [pixel % SIZE, pixel / SIZE].map(|index| index as f32 + 0.5);
        2.0 * -(-SCATTERING * 2.0 / f64::from(scene.camera.direction(x, y).z)).exp_m1()
    };
    let expected = (0..SIZE * SIZE).map(expected).sum::<f64>() / f64::from(SIZE * SIZE);
    // Beams of all light; and shadow rays for straight light.
    for method in [Method::Plain, Method::Covbeam] {
        let runs: Vec<f64> = (0..4)
            .map(|seed| {
                let settings = Settings { planned: false, ..Settings::of(method, 10_000, seed) };
                let mut renderer = Renderer::new(&scene, settings);
                let mut film = Film::new(SIZE, SIZE);
                for pass in 1..=3 {
                    let (image, _) = renderer.pass(pass, &|| false).expect("not cancelled");
                    film.add(&image).expect("finite");
                }
                let radiance = film.picture().radiance;
                radiance.iter().map(|color| f64::from(color.x)).sum::<f64>() / radiance.len() as f64
            })
            .collect();
        let found = Sample::of(&runs);
        println!("{method:?}: {:.4} ± {:.4} of {expected:.4}", found.mean, found.error);
        // Kernels lose some of the light beside the box's faces, as they may: 1 %.
        let off = (found.mean / expected - 1.0).abs();
        assert!(off < 0.01 + 4.0 * found.error / expected, "{method:?}: {found:?} {expected}");
        assert!(found.error < 0.01 * expected, "too noisy to tell: {found:?}");
    }
}
