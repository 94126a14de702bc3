//! Sunlight in fog, by closed forms: a box of fog, and fog that thins with height.

use covbeam_render::scene_file;
use covbeam_session::camera::Frame;
use covbeam_session::scene::Scene;
use covbeam_session::settings::Method;
use covbeam_tests::rows::{check, rows, runs};
use std::f64::consts::PI;
use std::path::Path;

/// Pixels a side.
const SIZE: u32 = 12;
/// \[1/m\]: light scattered twice is 2e-4 of it at most.
const SCATTERING: f64 = 1e-4;
const ABSORPTION: f64 = 0.5;
/// \[W/m²\]
const IRRADIANCE: f64 = 2.0;
/// Scale height of the fog that thins with height \[m\].
const HEIGHT: f64 = 0.7;
/// From the camera to the box, or to the wall \[m\].
const DISTANCE: f64 = 40.0;

/// `sun`: its direction and angle; `angle` of the camera \[degrees\].
fn scene(outside: &str, density: &str, objects: &str, sun: &str) -> Scene {
    let text = format!(
        "{outside}\n\
         [camera]\nposition = [0.0, 0.0, -{DISTANCE}]\nlook_at = [0.0, 0.0, 0.0]\nvertical_fov = {}\nwidth = {SIZE}\nheight = {SIZE}\n\
         [[medium]]\nname = \"fog\"\nscattering = {SCATTERING}\nabsorption = {ABSORPTION}\n{density}\n{objects}\n\
         [[light]]\nkind = \"sun\"\n{sun}\nirradiance = {IRRADIANCE}\n\
         [grid]\ncells = [12, 12, 12]\n[render]\nradius = 0.05\nmax_radius = 0.1\n",
        2.0 * (0.8 / DISTANCE).atan().to_degrees()
    );
    scene_file::parse(&text, "sun", Path::new(".")).expect("a valid scene")
}

/// Compares rows of all methods with what they should be at a row's middle height \[m\].
fn check_all(name: &str, scene: &Scene, radiance: impl Fn(f64) -> f64) {
    // Passes, and how well they must know a row.
    let methods = [
        (Method::Plain, 12, 0.02),
        (Method::Thesis, 4, 0.01),
        (Method::March, 2, 0.01),
        (Method::LightTrace, 24, 0.03),
    ];
    for (method, passes, noise) in methods {
        // What is next to a camera in fog splats on it, too noisily to tell.
        if method == Method::LightTrace && scene.outside.is_some() {
            continue;
        }
        for (y, found) in rows(&runs(scene, method, passes), 0, 1).iter().enumerate() {
            let height = 0.8 * (1.0 - (2.0 * y as f64 + 1.0) / f64::from(SIZE));
            // Rays are aslant by 1/50, a row is 0.13 m high, and kernels and filters may bias by 1 %.
            check(&format!("{name}, {method:?}, row {y}"), found, radiance(height), [0.012, noise]);
        }
    }
}

/// A box from -1 to 1, 2 m deep, with the sun above it. At a height y light has come through 1 - y of fog.
#[test]
fn a_box_of_fog_in_the_sun_is_the_closed_form() {
    let object = "[[object]]\nshape = \"box\"\nmin = [-1, -1, -1]\nmax = [1, 1, 1]\n\
                  material = { dielectric = { index = 1 } }\ninside = \"fog\"";
    let extinction = SCATTERING + ABSORPTION;
    let scene = scene("", "", object, "direction = [0, -1, 0]");
    check_all("box", &scene, |y| {
        let seen = -(-2.0 * extinction).exp_m1() / extinction;
        SCATTERING / (4.0 * PI) * IRRADIANCE * (-extinction * (1.0 - y)).exp() * seen
    });
}

/// The sun is 20° wide, and shines aslant on a box of thin fog: fluence is 2/(1 + cos 10°) of the irradiance, whatever is on its way.
#[test]
fn a_wide_sun_has_the_fluence_of_its_cone() {
    let object = "[[object]]\nshape = \"box\"\nmin = [-1, -1, -1]\nmax = [1, 1, 1]\n\
                  material = { dielectric = { index = 1 } }\ninside = \"fog\"\n\
                  [[object]]\nshape = \"rectangle\"\ncorner = [-300, -2, -300]\nedge_u = [0, 0, 600]\nedge_v = [600, 0, 0]\nmaterial = \"black\"";
    let mut scene = scene("", "", object, "direction = [0.4, -1, 0.3]\nangle = 20");
    scene.media[0].medium.absorption = glam::Vec3::ZERO;
    let fluence = 2.0 * IRRADIANCE / (1.0 + 10f64.to_radians().cos());
    check_all("wide", &scene, |_| SCATTERING / (4.0 * PI) * fluence * 2.0);
}

/// Fog e^(-y/H) between the camera and a wall 2 m away.
#[test]
fn fog_that_thins_with_height_is_the_closed_form() {
    let density = format!("density = {{ exponential = {{ origin = [0, 0, 0], scale_height = {HEIGHT} }} }}");
    // The sun shines on what the scene has: a box around the wall and what the camera sees before it.
    let objects =
        "[[object]]\nshape = \"box\"\nmin = [-1.5, -1.5, 1]\nmax = [1.5, 1.5, 1.1]\nmaterial = \"black\"";
    let mut scene = scene("outside_medium = \"fog\"", &density, objects, "direction = [0, -1, 0]");
    scene.camera.position = glam::Vec3::new(0.0, 0.0, -1.0);
    let half_height = 0.4;
    scene.camera.frame = Frame::Middle { half_height };
    let extinction = SCATTERING + ABSORPTION;
    let steps = 400;
    check_all("thinning", &scene, |middle| {
        // Along the row's eye rays, at the heights that they have at the depth 1 + s.
        let slope = middle / 0.8 * f64::from(half_height);
        let mut sum = 0.0;
        for x in 0..SIZE {
            let across = (2.0 * (f64::from(x) + 0.5) / f64::from(SIZE) - 1.0) * f64::from(half_height);
            let length = (1.0 + slope * slope + across * across).sqrt();
            let (mut column, step) = (0.0, 2.0 / f64::from(steps));
            for k in 0..steps {
                let y = slope * (f64::from(k) + 0.5) * step;
                let density = (-y / HEIGHT).exp();
                column += 0.5 * density * step * length;
                sum += density * (-extinction * (density * HEIGHT + column)).exp() * step * length;
                column += 0.5 * density * step * length;
            }
        }
        SCATTERING / (4.0 * PI) * IRRADIANCE * sum / f64::from(SIZE)
    });
}
