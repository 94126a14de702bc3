//! What each feature costs: variants of the glass ball at the same passes and light paths, by part.

use super::measure::Parts;
use covbeam::{
    BeamMap, ExponentialDensity, FluenceCell, GridCell, GridLayout, Medium, PhaseFunction, PhaseKind,
};
use covbeam_session::medium::volume::Volume;
use covbeam_session::pass::Renderer;
use covbeam_session::paths::{PhotonRecord, PhotonTracer, Record};
use covbeam_session::random::Emission;
use covbeam_session::scene::media;
use covbeam_session::scene::{Material, MediumDensity, Scene};
use covbeam_session::settings::{Layers, Method, Settings};
use glam::Vec3;
use serde::Serialize;

/// Runs of each variant; of each part the fastest one counts, as other programs only make it slower.
const REPEATS: u32 = 3;

/// Cost of a variant.
#[derive(Clone, Debug, Serialize)]
pub struct Feature {
    /// What is switched on.
    pub name: &'static str,
    /// What it is, for a reader.
    pub about: &'static str,
    /// Core-seconds a pass.
    pub parts: Parts,
    /// Total over that of the first variant.
    pub ratio: f64,
}

/// A row of the table.
struct Variant {
    name: &'static str,
    about: &'static str,
    method: Method,
    settings: fn(&mut Settings),
    change: fn(&mut Scene),
}

const PLAIN: Variant = Variant {
    name: "plain",
    about: "the glass ball with plain beams",
    method: Method::Plain,
    settings: |_| {},
    change: |_| {},
};

const DEFAULT: Variant = Variant {
    name: "+ guided light paths",
    about: "light paths go where the picture needs them: what covbeam render does",
    method: Method::Covbeam,
    settings: |_| {},
    change: |_| {},
};

/// In the order of the table.
const VARIANTS: [Variant; 14] = [
    PLAIN,
    Variant {
        name: "+ light fields and grid",
        about: "a tenth of the light paths carry a light field into the grid; each pair looks it up, but no kernel grows",
        method: Method::Thesis,
        change: |scene| scene.settings.schedule.max_radius = 0.0,
        ..PLAIN
    },
    Variant {
        name: "+ adaptive kernels",
        about: "kernels grow where the grid says that the light is smooth",
        method: Method::Thesis,
        ..PLAIN
    },
    Variant {
        name: "+ planned eye rays",
        about: "few eye rays where the picture is smooth",
        method: Method::Thesis,
        settings: |settings| settings.planned = true,
        ..PLAIN
    },
    Variant {
        name: "+ straight light",
        about: "light that comes straight from the lamps by shadow rays, not by beams",
        method: Method::Thesis,
        settings: |settings| {
            *settings = Settings { shadow_rays: true, layers: Layers::Together, planned: true, ..*settings }
        },
        ..PLAIN
    },
    DEFAULT,
    Variant {
        name: "default, no glass",
        about: "what covbeam render does, the ball taken away",
        change: without_glass,
        ..DEFAULT
    },
    Variant {
        name: "default, black walls",
        about: "what covbeam render does, all surfaces black and no glass",
        change: |scene| {
            without_glass(scene);
            scene.objects.iter_mut().for_each(|object| object.material = Material::Black);
        },
        ..DEFAULT
    },
    Variant {
        name: "default, no fog",
        about: "what covbeam render does, the ball and its walls in a vacuum",
        change: |scene| {
            scene.outside = None;
            scene.media.clear();
            scene.objects.iter_mut().for_each(|object| object.inside = None);
        },
        ..DEFAULT
    },
    Variant {
        name: "exponential density",
        about: "plain, in fog that thins with height",
        change: |scene| {
            let density = ExponentialDensity { origin: scene.grid.min, up: Vec3::Y, scale_height: 4.0 };
            fill(scene, &MediumDensity::Exponential(density));
        },
        ..PLAIN
    },
    Variant {
        name: "voxel density",
        about: "plain, in fog given by 32³ voxels",
        change: |scene| {
            let layout = GridLayout { cells: [32; 3], ..scene.grid };
            // Waves between 0.5 and 1.5, so that no voxel is like its neighbours.
            let wave = |i: u32| {
                1.0 + 0.5 * ((i % 32) as f32).sin() * ((i / 32 % 32) as f32).sin() * ((i / 1024) as f32).sin()
            };
            fill(
                scene,
                &MediumDensity::Grid(Volume { layout, values: (0..32 * 32 * 32).map(wave).collect() }),
            );
        },
        ..PLAIN
    },
    Variant {
        name: "coloured extinction",
        about: "plain, with another extinction for each channel",
        change: |scene| {
            for medium in &mut scene.media {
                medium.medium.absorption += medium.medium.scattering * Vec3::new(0.0, 0.1, 0.2);
            }
        },
        ..PLAIN
    },
    Variant {
        name: "Henyey-Greenstein",
        about: "plain, with a phase function of asymmetry 0.7",
        change: |scene| {
            for medium in &mut scene.media {
                medium.medium.phase = PhaseFunction { kind: PhaseKind::HenyeyGreenstein, asymmetry: 0.7 };
            }
        },
        ..PLAIN
    },
    Variant {
        name: "without the glass",
        about: "plain, the ball taken away",
        change: without_glass,
        ..PLAIN
    },
];

fn without_glass(scene: &mut Scene) {
    scene.objects.retain(|object| object.material.index().is_none());
}

fn fill(scene: &mut Scene, density: &MediumDensity) {
    scene.media.iter_mut().for_each(|medium| medium.density = density.clone());
}

/// Measures all variants of a scene, which should be the glass ball. None: cancelled.
pub(super) fn features(
    scene: &Scene,
    passes: u32,
    cancelled: &(dyn Fn() -> bool + Sync),
) -> Option<Vec<Feature>> {
    let mut best = [None::<Parts>; VARIANTS.len()];
    for _ in 0..REPEATS {
        for (variant, best) in VARIANTS.iter().zip(&mut best) {
            let mut scene = scene.clone();
            (variant.change)(&mut scene);
            let mut settings = Settings::of_scene(variant.method, &scene, 1);
            (variant.settings)(&mut settings);
            let mut renderer = Renderer::new(&scene, settings);
            let mut times = covbeam_session::pass::PassTimes::default();
            for pass in 1..=passes {
                times += renderer.pass(pass, cancelled)?.1;
            }
            let parts = Parts::from(times).a_pass(passes);
            *best = Some(best.map_or(parts, |best| best.least(&parts)));
        }
    }
    let plain = best[0]?.total();
    let feature = |(variant, parts): (&Variant, Option<Parts>)| {
        let parts = parts?;
        Some(Feature { name: variant.name, about: variant.about, parts, ratio: parts.total() / plain })
    };
    VARIANTS.iter().zip(best).map(feature).collect()
}

/// Bytes that one pass of a scene keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Memory {
    /// Beams of a pass.
    pub beams: usize,
    /// Their map with kernels of the plain radius.
    pub plain_map: usize,
    /// Their map with kernels up to the largest radius.
    pub adaptive_map: usize,
    /// The covariance grid, with the one that is looked up.
    pub grid: usize,
}

/// Of the first pass.
pub(super) fn memory(scene: &Scene) -> Memory {
    let tracer = PhotonTracer::new(scene, 1, Emission::LowDiscrepancy);
    let mut record = PhotonRecord::default();
    let paths = scene.settings.photons;
    (0..paths).for_each(|path| tracer.trace(0, path, paths, Record::Beams, &mut record));
    let map = |max_radius: f32| -> usize {
        let of_medium = |(medium, fog): (usize, &Medium)| {
            let beams =
                record.beams.iter().filter(|found| found.medium as usize == medium).map(|found| found.beam);
            BeamMap::build(beams.collect(), max_radius, fog).memory()
        };
        media::all(scene).iter().enumerate().map(of_medium).sum()
    };
    Memory {
        beams: record.beams.len(),
        plain_map: map(scene.settings.schedule.radius),
        adaptive_map: map(scene.settings.schedule.max_radius.max(scene.settings.schedule.radius)),
        grid: scene.grid.cell_count() * (size_of::<GridCell>() + size_of::<FluenceCell>()),
    }
}
