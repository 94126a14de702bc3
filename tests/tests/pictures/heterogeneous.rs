//! Light in media whose density varies, or is the same everywhere: beams against quadrature, beams against light tracing, energy.

use covbeam_render::scene_file;
use covbeam_session::film::Film;
use covbeam_session::pass::Renderer;
use covbeam_session::scene::Scene;
use covbeam_session::settings::{Method, Settings};
use covbeam_tests::energy::taken_by_chance;
use covbeam_tests::single_scatter::{Density, Emission, Lamp, World};
use covbeam_tests::statistics::{Sample, sidak, welch};
use glam::{DVec3, Vec3};
use std::path::Path;

const SCALE_HEIGHT: f64 = 1.5;

const CELLS: [usize; 3] = [9, 11, 10];
const BOX: [[f32; 3]; 2] = [[-3.0, -1.2, -3.5], [2.8, 4.1, 3.0]];

/// Densities from 0 to 3 that are as rough as voxels can be, so that a wrong interpolation shows.
fn voxels() -> Vec<f32> {
    let count = CELLS.iter().product::<usize>() as u32;
    (0..count).map(|i| (i.wrapping_mul(2_654_435_761) >> 16 & 0xff) as f32 / 85.0).collect()
}

/// Mitsuba's format: "VOL", version 3, encoding 1 = f32, size, channels, box, values with x fastest.
fn write_volume(path: &Path, values: &[f32]) {
    let mut bytes = b"VOL\x03".to_vec();
    let header = [1, CELLS[0] as i32, CELLS[1] as i32, CELLS[2] as i32, 1];
    bytes.extend(header.iter().flat_map(|n| n.to_le_bytes()));
    bytes.extend(BOX.iter().flatten().chain(values).flat_map(|x| x.to_le_bytes()));
    std::fs::write(path, bytes).expect("a temporary file");
}

/// What fills the room.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Air {
    Even,
    Exponential,
    Voxels,
}

/// A black room with a black ball in it, filled with a medium of the given coefficients.
fn scene(air: Air, medium: &str, size: u32) -> Scene {
    let dir = tempfile::tempdir().expect("a temporary directory");
    write_volume(&dir.path().join("air.vol"), &voxels());
    let density = match air {
        Air::Even => String::new(),
        Air::Exponential => {
            format!(
                "density = {{ exponential = {{ origin = [0, 0, 0], up = [0, 1, 0], scale_height = {SCALE_HEIGHT} }} }}"
            )
        }
        Air::Voxels => "density = { volume = { file = \"air.vol\" } }".to_owned(),
    };
    let text = format!(
        "outside_medium = \"air\"\n\
         [camera]\nposition = [0.0, 0.5, -5.5]\nlook_at = [0.0, 0.7, 0.0]\nvertical_fov = 40.0\nwidth = {size}\nheight = {size}\n\
         [[medium]]\nname = \"air\"\n{medium}\n{density}\n\
         [[object]]\nshape = \"sphere\"\ncenter = [0.2, 0.3, 0.1]\nradius = 0.7\nmaterial = \"black\"\n\
         [[object]]\nshape = \"box\"\nmin = [-4.0, -1.5, -6.0]\nmax = [4.0, 4.5, 4.0]\nmaterial = \"black\"\n\
         [[light]]\n{LIGHT}\n\
         [grid]\nmin = [-4.0, -1.5, -6.0]\nmax = [4.0, 4.5, 4.0]\ncells = [12, 12, 12]\n\
         [render]\nradius = 0.04\nmax_radius = 0.08\nerror = 0.002\n"
    );
    scene_file::parse(&text, "heterogeneous", dir.path()).expect("a valid scene")
}

const LIGHT: &str = "kind = \"spot\"\nposition = [-1.4, 3.2, -1.0]\nlook_at = [0.1, 0.2, 0.0]\n\
                    intensity = [30.0, 20.0, 10.0]\ninner_angle = 14.0\nouter_angle = 26.0\n";

/// So little scattering that second and higher orders are below 1e-3 of the first: 2e-4 x density 1 to 3 x a few units.
const THIN: &str = "scattering = [1e-4, 2e-4, 1.5e-4]\nabsorption = [0.05, 0.15, 0.4]\n\
                    phase = { henyey_greenstein = 0.4 }";

/// Half of the light scatters, half of that again.
const THICK: &str =
    "scattering = [0.15, 0.2, 0.1]\nabsorption = [0.02, 0.01, 0.05]\nphase = { henyey_greenstein = 0.4 }";

/// The same room for the quadrature.
fn world(air: Air) -> World {
    let axis = (DVec3::new(0.1, 0.2, 0.0) - DVec3::new(-1.4, 3.2, -1.0)).normalize();
    let lamp = Lamp {
        position: DVec3::new(-1.4, 3.2, -1.0),
        intensity: DVec3::new(30.0, 20.0, 10.0),
        emission: Emission::Spot { axis, inner: 14f64.to_radians(), outer: 26f64.to_radians() },
    };
    let density = match air {
        Air::Even => Density::Exponential { scale_height: 1e12 },
        Air::Exponential => Density::Exponential { scale_height: SCALE_HEIGHT },
        Air::Voxels => Density::Voxels {
            min: Vec3::from(BOX[0]).as_dvec3(),
            max: Vec3::from(BOX[1]).as_dvec3(),
            cells: CELLS,
            values: voxels().into_iter().map(f64::from).collect(),
        },
    };
    World {
        density,
        scattering: DVec3::new(1e-4, 2e-4, 1.5e-4),
        absorption: DVec3::new(0.05, 0.15, 0.4),
        asymmetry: 0.4,
        lamp,
        ball: (DVec3::new(0.2, 0.3, 0.1), 0.7),
        room: (DVec3::new(-4.0, -1.5, -6.0), DVec3::new(4.0, 4.5, 4.0)),
    }
}

fn picture(scene: &Scene, method: Method, photons: u32, seed: u32, passes: u32) -> Vec<Vec3> {
    let mut renderer = Renderer::new(scene, Settings::of(method, photons, seed));
    let mut film = Film::of_scene(scene);
    for index in 1..=passes {
        let (image, _) = renderer.pass(index, &|| false).expect("not cancelled");
        film.add(&image).expect("finite");
    }
    film.picture().radiance
}

/// Rows of the picture, as shares of its height: all of it, above the ball, the ball and its shadow.
const REGIONS: [(&str, f64, f64); 3] =
    [("whole", 0.0, 1.0), ("upper half", 0.0, 0.5), ("lower half", 0.5, 1.0)];

/// Mean of a region per channel.
fn mean(picture: &[DVec3], (_, from, to): (&str, f64, f64)) -> DVec3 {
    let at = |share: f64| (share * picture.len() as f64).round() as usize;
    let pixels = &picture[at(from)..at(to)];
    pixels.iter().sum::<DVec3>() / pixels.len() as f64
}

fn in_double(picture: &[Vec3]) -> Vec<DVec3> {
    picture.iter().map(|color| color.as_dvec3()).collect()
}

/// Pictures of `runs` seeds from `first` on.
fn pictures(
    scene: &Scene,
    method: Method,
    (photons, passes): (u32, u32),
    first: u32,
    runs: u32,
) -> Vec<Vec<DVec3>> {
    let run = |seed| in_double(&picture(scene, method, photons, seed, passes));
    (first..first + runs).map(run).collect()
}

/// What the quadrature says of a picture of 24 by 24 pixels, with so many by so many rays a pixel.
fn quadrature(world: &World, scene: &Scene, across: u32) -> Vec<DVec3> {
    let camera = &scene.camera;
    let ray = |pixel: u32, i: u32| {
        let at = |pixel: u32, i: u32| pixel as f32 + (i as f32 + 0.5) / across as f32;
        let (x, y) = (at(pixel % camera.width, i % across), at(pixel / camera.width, i / across));
        world.radiance(camera.position.as_dvec3(), camera.direction(x, y).as_dvec3().normalize(), 60)
    };
    let rays = across * across;
    (0..camera.width * camera.height)
        .map(|pixel| (0..rays).map(|i| ray(pixel, i)).sum::<DVec3>() / f64::from(rays))
        .collect()
}

#[test]
fn single_scattering_is_that_of_the_quadrature() {
    for air in [Air::Even, Air::Exponential, Air::Voxels] {
        let scene = scene(air, THIN, 24);
        let truth = quadrature(&world(air), &scene, 4);
        // A thirtieth more of everything would be seen.
        let mut denser = world(air);
        denser.scattering *= 1.03;
        denser.absorption *= 1.03;
        let [some, more] =
            [&world(air), &denser].map(|world| mean(&quadrature(world, &scene, 1), REGIONS[0]));
        let more = more / some;
        assert!(more.x > 1.01, "{more}");
        for method in [Method::Plain, Method::Thesis] {
            let pictures = pictures(&scene, method, (3_000, 32), 1, 8);
            for region in REGIONS {
                let exact = mean(&truth, region);
                for channel in 0..3 {
                    let ratio = |picture: &Vec<DVec3>| mean(picture, region)[channel] / exact[channel];
                    let sample = Sample::of(&pictures.iter().map(ratio).collect::<Vec<_>>());
                    let name = format!("{air:?}, {method:?}, {}, channel {channel}", region.0);
                    println!("{name}: {:.5} ± {:.5}", sample.mean, sample.error);
                    // The ball's shadow is noisier, and rough voxels are.
                    let [noise, bias] = match air {
                        Air::Even if region != REGIONS[2] => [0.001, 0.003],
                        _ => [0.002, 0.005],
                    };
                    assert!(sample.error < noise, "{name}: too noisy to tell: {sample:?}");
                    assert!((sample.mean - 1.0).abs() < bias, "{name}: {sample:?}");
                }
            }
        }
    }
}

#[test]
fn beams_and_light_tracing_agree_on_all_orders_of_scattering() {
    let level = sidak(0.001, 2 * 3 * 2);
    for air in [Air::Exponential, Air::Voxels] {
        let room = scene(air, THICK, 24);
        let light = pictures(&room, Method::LightTrace, (100_000, 1), 100, 10);
        // Negative control: a sixth more scattering is told apart; the quadrature above sees far less.
        let brighter = THICK.replace("[0.15, 0.2, 0.1]", "[0.175, 0.233, 0.117]");
        assert_ne!(brighter, THICK);
        let control = pictures(&scene(air, &brighter, 24), Method::Thesis, (2_000, 10), 200, 10);
        for (method, first) in [(Method::Plain, 300), (Method::Thesis, 400)] {
            let beams = pictures(&room, method, (2_000, 10), first, 10);
            for region in REGIONS {
                let sample = |pictures: &[Vec<DVec3>]| {
                    let means = pictures.iter().map(|picture| mean(picture, region).y);
                    Sample::of(&means.collect::<Vec<_>>())
                };
                let (a, b, c) = (sample(&beams), sample(&light), sample(&control));
                println!(
                    "{air:?}, {method:?}, {}: {:.4} ± {:.4} of the light tracer's ± {:.4}, p = {:.3}; control {:.4}, p = {:.1e}",
                    region.0,
                    a.mean / b.mean,
                    a.error / b.mean,
                    b.error / b.mean,
                    welch(a, b),
                    c.mean / b.mean,
                    welch(c, b)
                );
                assert!(welch(a, b) > level, "{a:?} and {b:?} differ: p = {}", welch(a, b));
                if region == REGIONS[0] {
                    assert!(welch(c, b) < level, "{c:?} and {b:?} are not told apart: p = {}", welch(c, b));
                }
            }
        }
    }
}

/// emitted = medium + surfaces + escaped + roulette, and the roulette's share is noise around zero.
#[test]
fn no_energy_is_lost_or_made() {
    for air in [Air::Exponential, Air::Voxels] {
        let scene = scene(air, THICK, 8);
        for (c, sample) in taken_by_chance(&scene, 12).iter().enumerate() {
            println!("{air:?}, channel {c}: roulette {:.5} ± {:.5}", sample.mean, sample.error);
            // Six tests at 5 standard errors: a false alarm in 1e5.
            assert!(sample.mean.abs() < 5.0 * sample.error, "channel {c}: {sample:?}");
            assert!(sample.error < 0.003, "the test could not see a loss of a few percent: {sample:?}");
        }
    }
}
