//! Pictures by both methods: sound at all ends of the sliders, and covbeam's nearer to the truth.

use covbeam_web::{Settings, View};

/// Radiance after some passes, of all channels.
fn radiance(settings: Settings, side: u32, passes: u32) -> Vec<f32> {
    let mut view = View::new(&settings, side, side);
    (0..passes).for_each(|_| view.pass());
    assert_eq!(view.passes(), passes);
    view.picture().iter().flat_map(|pixel| pixel.to_array()).collect()
}

#[test]
fn at_all_ends_of_all_sliders_pictures_are_sound() {
    // As in page/index.html, with fewer photons.
    for ends in 0..64_u32 {
        let end = |slider: u32, least: f32, most: f32| if ends >> slider & 1 == 0 { least } else { most };
        for adaptive in [false, true] {
            let settings = Settings {
                lamp_angle: end(0, 0.0, 180.0),
                ball_radius: end(1, 0.2, 0.9),
                index: end(2, 1.0, 2.5),
                extinction: end(3, 1.0 / 64.0, 0.5),
                photons: end(4, 128.0, 512.0) as u32,
                plain_radius: end(5, 0.005, 0.15),
                adaptive,
                ..Settings::FIRST
            };
            let found = radiance(settings, 32, 2);
            let sound = found.iter().all(|value| value.is_finite() && *value >= 0.0);
            assert!(sound && found.iter().sum::<f32>() > 0.0, "{settings:?}");
        }
    }
}

#[test]
fn covbeam_is_nearer_to_many_photons_than_plain_beams_of_any_radius() {
    // Of another seed, with kernels narrower than plain beams': what is left of their noise counts for both.
    let truth = radiance(Settings { photons: 8192, plain_radius: 0.02, seed: 2, ..Settings::FIRST }, 96, 16);
    let dark = 0.01 * truth.iter().sum::<f32>() / truth.len() as f32;
    let error = |adaptive, plain_radius| {
        let found = radiance(Settings { adaptive, plain_radius, ..Settings::FIRST }, 96, 16);
        let relative = |(found, truth): (&f32, &f32)| (found - truth).powi(2) / (truth * truth + dark * dark);
        found.iter().zip(&truth).map(relative).sum::<f32>() / truth.len() as f32
    };
    let covbeam = error(true, 0.0);
    let plain = [0.02, 0.03, 0.05, 0.08].map(|radius| error(false, radius));
    println!("relative squared error: plain {plain:.4?}, covbeam {covbeam:.4}");
    assert!(plain.into_iter().all(|plain| covbeam < 0.7 * plain), "{covbeam} {plain:?}");
}

#[test]
fn straight_light_by_shadow_rays_is_that_of_beams() {
    // With nothing but noise between them: means of the whole picture, through a ball that bends nothing.
    let mean = |adaptive| {
        let found = radiance(Settings { index: 1.0, adaptive, photons: 4096, ..Settings::FIRST }, 64, 16);
        found.iter().sum::<f32>() / found.len() as f32
    };
    let [plain, covbeam] = [false, true].map(mean);
    assert!((covbeam / plain - 1.0).abs() < 0.02, "{covbeam} {plain}");
}
