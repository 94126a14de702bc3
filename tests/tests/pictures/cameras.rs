//! Cameras of all kinds, by quadrature of light that is scattered once along rays that this file lays itself; and fog seen from outside.

use covbeam_render::scene_file;
use covbeam_session::camera::Frame;
use covbeam_session::film::{Film, Picture};
use covbeam_session::pass::Renderer;
use covbeam_session::scene::Scene;
use covbeam_session::settings::{Method, Settings};
use covbeam_tests::single_scatter::{Density, Emission, Lamp, World, sunflower};
use covbeam_tests::statistics::Sample;
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::PI;
use std::path::Path;
use std::sync::OnceLock;

/// \[1/m\]: light scattered twice is 1e-3 of it at most.
const SCATTERING: f64 = 1e-4;
const ABSORPTION: f64 = 0.1;
/// Half the room's side \[m\].
const ROOM: f64 = 4.0;
const BALL: f64 = 0.5;
const LAMP: DVec3 = DVec3::new(0.3, 2.2, 0.4);
const EYE: DVec3 = DVec3::new(0.4, 0.3, -3.2);
const AIM: DVec3 = DVec3::new(0.1, 0.2, 0.0);

/// A black room with a lamp and a black ball.
fn scene(camera: &str, [width, height]: [u32; 2]) -> Scene {
    let text = format!(
        "outside_medium = \"air\"\n\
         [camera]\nposition = {EYE}\nlook_at = {AIM}\nwidth = {width}\nheight = {height}\n{camera}\n\
         [[medium]]\nname = \"air\"\nscattering = {SCATTERING}\nabsorption = {ABSORPTION}\n\
         [[object]]\nshape = \"box\"\nmin = [-{ROOM}, -{ROOM}, -{ROOM}]\nmax = [{ROOM}, {ROOM}, {ROOM}]\nmaterial = \"black\"\n\
         [[object]]\nshape = \"sphere\"\ncenter = [0, 0, 0]\nradius = {BALL}\nmaterial = \"black\"\n\
         [[light]]\nkind = \"point\"\nposition = {LAMP}\nintensity = 1.0\n"
    );
    scene_file::parse(&text, "room", Path::new(".")).expect("a valid scene")
}

fn world() -> World {
    World {
        density: Density::Exponential { scale_height: 1e12 },
        scattering: DVec3::splat(SCATTERING),
        absorption: DVec3::splat(ABSORPTION),
        asymmetry: 0.0,
        lamp: Lamp { position: LAMP, intensity: DVec3::ONE, emission: Emission::Even },
        ball: (DVec3::ZERO, BALL),
        room: (DVec3::splat(-ROOM), DVec3::splat(ROOM)),
    }
}

/// Towards the right, up and forward.
fn axes() -> [DVec3; 3] {
    let forward = (AIM - EYE).normalize();
    let right = forward.cross(DVec3::Y).normalize();
    [right, right.cross(forward), forward]
}

/// A ray: where it starts, its unit direction, and how much nearer to the viewing axis' far end a metre along it gets.
type Ray = (DVec3, DVec3, f64);

/// Through (h, v), to the right and up from the middle, in units of the picture's half height.
type Rays = fn([f64; 2]) -> Ray;

fn perspective([h, v]: [f64; 2], tangent: f64) -> Ray {
    let [right, up, forward] = axes();
    let direction = (forward + tangent * (h * right + v * up)).normalize();
    (EYE, direction, direction.dot(forward))
}

fn parallel([h, v]: [f64; 2]) -> Ray {
    let [right, up, forward] = axes();
    (EYE + 1.4 * (h * right + v * up), forward, 1.0)
}

fn map([h, v]: [f64; 2]) -> Ray {
    let [right, up, forward] = axes();
    let (longitude, latitude) = (0.5 * PI * h, 0.5 * PI * v);
    let level = longitude.cos() * forward + longitude.sin() * right;
    (EYE, latitude.cos() * level + latitude.sin() * up, 1.0)
}

fn fisheye([h, v]: [f64; 2]) -> Ray {
    let [right, up, forward] = axes();
    let angle = 100_f64.to_radians() * h.hypot(v);
    (EYE, angle.cos() * forward + angle.sin() * (h * right + v * up).normalize_or_zero(), 1.0)
}

struct Case {
    name: &'static str,
    size: [u32; 2],
    rays: Rays,
    near: f64,
    /// Radius, height over width and focus of the lens.
    lens: Option<[f64; 3]>,
}

/// Pixels along the side of a block that is compared.
const BLOCK: u32 = 4;

impl Case {
    /// Rows of blocks that are compared: of large pictures those in the middle.
    fn rows(&self) -> std::ops::Range<u32> {
        let all = self.size[1] / BLOCK;
        if all > 8 { all / 2 - 1..all / 2 + 1 } else { 0..all }
    }
}

/// Mean of light over blocks of a picture, row by row; and how much it varies in them: the largest over the smallest.
fn expected(case: &Case) -> Vec<[f64; 2]> {
    let (world, [width, height]) = (world(), case.size);
    let places = match case.lens {
        Some([radius, ratio, _]) => sunflower(DVec3::ZERO, radius, DVec3::Z, 64)
            .into_iter()
            .map(|place| [place.x / ratio, place.y])
            .collect(),
        None => vec![[0.0; 2]],
    };
    let [right, up, _] = axes();
    let pixel = |x: u32, y: u32| {
        // Places in the lens move rays across pixels, too.
        let samples = if case.lens.is_some() { 2 } else { 4 };
        let mut sum = 0.0;
        for i in 0..samples * samples {
            let at = |pixel: u32, i: u32| f64::from(pixel) + (f64::from(i) + 0.5) / f64::from(samples);
            let half = 0.5 * f64::from(height);
            let (h, v) =
                ((at(x, i % samples) - 0.5 * f64::from(width)) / half, (half - at(y, i / samples)) / half);
            let (origin, direction, along) = (case.rays)([h, v]);
            for [across, above] in &places {
                let (mut start, mut way, mut cosine) = (origin, direction, along);
                if let Some([.., focus]) = case.lens {
                    let offset = *across * right + *above * up;
                    way = (focus / along * direction - offset).normalize();
                    (start, cosine) = (origin + offset, way.dot(axes()[2]));
                }
                sum += world.radiance(start + case.near / cosine * way, way, 80).x;
            }
        }
        sum / f64::from(samples * samples) / places.len() as f64
    };
    let blocks = case.rows().flat_map(|y| (0..width / BLOCK).map(move |x| (x, y)));
    let blocks: Vec<(u32, u32)> = blocks.collect();
    blocks
        .into_par_iter()
        .map(|(x, y)| {
            let inside = (0..BLOCK * BLOCK).map(|i| pixel(BLOCK * x + i % BLOCK, BLOCK * y + i / BLOCK));
            let pixels: Vec<f64> = inside.collect();
            let [least, most] = pixels.iter().fold([f64::MAX, 0.0_f64], |[a, b], p| [p.min(a), p.max(b)]);
            [pixels.iter().sum::<f64>() / f64::from(BLOCK * BLOCK), most / least]
        })
        .collect()
}

fn render(scene: &Scene, seed: u32, passes: u32, photons: u32) -> Picture {
    let settings = Settings { guided: false, ..Settings::of(Method::Covbeam, photons, seed) };
    let mut renderer = Renderer::new(scene, settings);
    let mut film = Film::of_scene(scene);
    for pass in 1..=passes {
        film.add(&renderer.pass(pass, &|| false).expect("not cancelled").0).expect("finite");
    }
    film.picture()
}

fn blocks(picture: &Picture, rows: std::ops::Range<u32>) -> Vec<f64> {
    let across = picture.width / BLOCK;
    let mut sums = vec![0.0; (across * (picture.height / BLOCK)) as usize];
    for (radiance, pixel) in picture.radiance.iter().zip(0..) {
        let (x, y) = (pixel % picture.width, pixel / picture.width);
        sums[(y / BLOCK * across + x / BLOCK) as usize] += f64::from(radiance.x) / f64::from(BLOCK * BLOCK);
    }
    sums[(rows.start * across) as usize..(rows.end * across) as usize].to_vec()
}

/// Most that a block may be off, besides four standard errors: filters may be by 1 %.
const TOLERANCE: f64 = 0.01;

/// What a camera shows, and its name.
struct Shown(&'static str, Vec<[f64; 2]>);

/// That of the pinhole.
fn pinhole() -> &'static Shown {
    static SHOWN: OnceLock<Shown> = OnceLock::new();
    SHOWN.get_or_init(|| Shown(PINHOLE.name, expected(&PINHOLE)))
}

/// The largest difference of the renderer's blocks, beyond their noise, and that of what another camera would show.
fn check(case: &Case, scene: &Scene, other: Option<&Shown>) -> Shown {
    let expected = expected(case);
    // Blocks of small pixels change along the picture from one to the next; what is not known well hides what filters lose there.
    let (seeds, noise) = if case.size[1] > 32 { (24, 0.01) } else { (4, 0.02) };
    let runs: Vec<Vec<f64>> =
        (0..seeds).map(|seed| blocks(&render(scene, seed, 8, 400), case.rows())).collect();
    let mut worst = 0.0_f64;
    let mut compared = 0;
    for (block, &[mean, spread]) in expected.iter().enumerate() {
        // Next to the lamp's place in the picture the midpoint rule over a pixel does not do.
        if spread > 4.0 {
            continue;
        }
        let sample = Sample::of(&runs.iter().map(|run| run[block]).collect::<Vec<_>>());
        let (ratio, error) = (sample.mean / mean, sample.error / mean);
        assert!(error < noise, "{}: block {block} is too noisy to tell, {error}", case.name);
        assert!(
            (ratio - 1.0).abs() < TOLERANCE + 4.0 * error,
            "{}: block {block}: {ratio} ± {error}",
            case.name
        );
        worst = worst.max((ratio - 1.0).abs());
        compared += 1;
    }
    assert!(compared > 3 * expected.len() / 4, "{}: {compared} blocks", case.name);
    println!("{}: {compared} blocks, the worst is off by {worst:.4}", case.name);
    if let Some(Shown(name, other)) = other {
        let apart = expected.iter().zip(other).filter(|(a, _)| a[1] <= 4.0);
        let apart = apart.map(|(a, b)| (b[0] / a[0] - 1.0).abs()).fold(0.0, f64::max);
        assert!(apart > 6.0 * TOLERANCE, "{}: {name} would pass, {apart}", case.name);
    }
    Shown(case.name, expected)
}

const WIDE: Rays = |at| perspective(at, 0.45);
const PINHOLE: Case = Case { name: "pinhole", size: [24, 24], rays: WIDE, near: 0.0, lens: None };
/// 2 atan 0.45
const FOV: &str = "vertical_fov = 48.455478\n";

#[test]
fn a_near_plane_hides_the_fog_before_it() {
    let case = Case { name: "near plane", near: 2.0, ..PINHOLE };
    check(&case, &scene(&format!("{FOV}near = 2.0"), case.size), Some(pinhole()));
}

#[test]
fn a_part_of_a_picture_in_pixels_that_are_not_square_shows_that_part() {
    // Twice as wide as high, and off the middle: (h, v) are in a picture of the same pixels.
    let rays = |[h, v]: [f64; 2]| perspective([0.4 + 0.5 * h, -0.3 + 0.25 * v], 0.45);
    let case = Case { name: "part", rays, ..PINHOLE };
    let mut scene = scene(FOV, case.size);
    let (left, top) = (0.45 * (0.4 - 0.5), 0.45 * (-0.3 + 0.25));
    scene.camera.frame =
        Frame::Part { left: left as f32, top: top as f32, step: [0.45 / 24.0, 0.225 / 24.0] };
    check(&case, &scene, Some(pinhole()));
}

#[test]
fn parallel_rays_show_a_room_without_perspective() {
    let case = Case { name: "orthographic", rays: parallel, ..PINHOLE };
    let fields = "projection = \"orthographic\"\nvertical_size = 2.8";
    let shown = check(&case, &scene(fields, case.size), Some(pinhole()));
    let cut = Case { name: "orthographic, near plane", near: 2.0, ..case };
    check(&cut, &scene(&format!("{fields}\nnear = 2.0"), case.size), Some(&shown));
}

#[test]
fn a_map_of_all_around_and_a_fisheye_show_what_is_at_their_angles() {
    let case = Case { name: "equirectangular", rays: map, size: [64, 32], ..PINHOLE };
    check(&case, &scene("projection = \"equirectangular\"", case.size), None);
    let case = Case { name: "fisheye", rays: fisheye, ..PINHOLE };
    check(&case, &scene("projection = \"fisheye\"\nvertical_fov = 200", case.size), None);
}

/// A lens shows the mean of what pinholes in it show: the ball is out of focus.
#[test]
fn a_lens_shows_the_mean_of_the_pinholes_in_its_opening() {
    let lens = Some([0.3, 1.5, 1.6]);
    let fields = "lens = { radius = 0.3, focus_distance = 1.6, ratio = 1.5 }";
    let case = Case { name: "lens", lens, ..PINHOLE };
    // In pixels so small that filters would reach across what is blurred.
    let fine = Case { name: "lens, fine", size: [64, 64], ..case };
    check(&fine, &scene(&format!("{FOV}{fields}"), fine.size), None);
    let shown = check(&case, &scene(&format!("{FOV}{fields}"), case.size), Some(pinhole()));
    let cut = Case { name: "lens, near plane", near: 1.0, ..case };
    check(&cut, &scene(&format!("{FOV}{fields}\nnear = 1.0"), case.size), Some(&shown));
    let wide = Case { name: "lens, orthographic", rays: parallel, lens, ..PINHOLE };
    let plain = Case { name: "orthographic", lens: None, ..wide };
    let fields = format!("projection = \"orthographic\"\nvertical_size = 2.8\n{fields}");
    check(&wide, &scene(&fields, case.size), Some(&Shown(plain.name, expected(&plain))));
}

/// A sun on a ball of fog that the camera is outside of: the light is even, but less and less fog is seen towards the border.
#[test]
fn filters_of_a_picture_from_outside_follow_how_much_fog_is_seen() {
    const FOG: [f64; 2] = [1e-3, 0.05];
    let size = 48;
    let text = format!(
        "[camera]\nposition = [0, 0, -8]\nlook_at = [0, 0, 0]\nvertical_fov = 16\nwidth = {size}\nheight = {size}\n\
         [[medium]]\nname = \"fog\"\nscattering = {}\nabsorption = {}\n\
         [[object]]\nshape = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1\nmaterial = {{ dielectric = {{ index = 1 }} }}\ninside = \"fog\"\n\
         [[light]]\nkind = \"sun\"\ndirection = [0, 0, 1]\nirradiance = 2\n",
        FOG[0], FOG[1]
    );
    let scene = scene_file::parse(&text, "ball of fog", Path::new(".")).expect("a valid scene");
    let pictures: Vec<Picture> = (0..3).map(|seed| render(&scene, seed, 3, 800)).collect();
    let maps = pictures[0].maps.as_ref().expect("eye rays are planned from outside");
    let density = maps.density();
    // Filters are wide in the middle: as few as there are light paths for.
    assert!(density[24 * 48 + 24] < 0.2, "{}", density[24 * 48 + 24]);
    assert_eq!(pictures[0].radiance, maps.volume, "all light is from before the first surface");

    // Both ways through the ball end at its front: a place at depth s is as deep in the sun's light.
    let extinction = FOG[0] + FOG[1];
    let radiance = |aside: f64| {
        let chord = 2.0 * (1.0 - aside * aside).max(0.0).sqrt();
        2.0 * FOG[0] / (4.0 * PI) * -(-2.0 * extinction * chord).exp_m1() / (2.0 * extinction)
    };
    let tangent = 8_f64.to_radians().tan() / 24.0;
    let fine = |pixel: u32| {
        let at = |pixel: u32, i: u32| (f64::from(pixel) + (f64::from(i) + 0.5) / 10.0 - 24.0) * tangent;
        let asides = (0..100).map(|i| {
            let slope = at(pixel % size, i % 10).hypot(at(pixel / size, i / 10));
            8.0 * slope / slope.hypot(1.0)
        });
        let (sum, aside) =
            asides.fold((0.0, 0.0), |(sum, all), aside| (sum + radiance(aside), all + aside * aside));
        (sum / 100.0, (aside / 100.0_f64).sqrt())
    };
    let expected: Vec<(f64, f64)> = (0..size * size).map(fine).collect();
    for [low, high] in [[0.0, 0.5], [0.5, 0.7], [0.7, 0.85]] {
        let ring = || (0..(size * size) as usize).filter(|pixel| (low..high).contains(&expected[*pixel].1));
        let truth: f64 = ring().map(|pixel| expected[pixel].0).sum();
        let found = |picture: &Picture| ring().map(|pixel| f64::from(picture.radiance[pixel].x)).sum::<f64>();
        let ratio = pictures.iter().map(found).sum::<f64>() / 3.0 / truth;
        println!("{low} to {high} of the radius: {ratio:.4}");
        // Filters may err by 1 % in the first pass.
        assert!((ratio - 1.0).abs() < 0.01, "{low} to {high} of the radius: {ratio}");
    }
}
