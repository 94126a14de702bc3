//! Light straight from the lamp, scattered once: known but for the ball's shadow, so that a few shadow rays an
//! eye ray tell more of it than beams.

use crate::ball::Ray;
use crate::photons::march_number;
use crate::scene::Scene;
use covbeam::{EyeRay, March, MarchCell, MarchKnot, MarchSample, Vec3};

const KNOTS: usize = 17;
const SHADOW_RAYS: usize = 8;

/// Radiance \[W/(m² sr)\] at the start of an eye ray.
///
/// - `numbers`: which numbers place its shadow rays: a sequence, and a place in it.
pub(crate) fn straight_light(scene: &Scene, ray: &EyeRay, numbers: [u32; 2]) -> Vec3 {
    let far = ray.length.min(scene.fog.opaque_column());
    let Some([from, to]) = scene.lit_stretch(ray, far) else { return Vec3::ZERO };
    let mut knots = [MarchKnot::default(); KNOTS];
    let laid = MarchKnot::lay(ray.origin, ray.direction, from, to, scene.lamp(), &mut knots);
    if laid.is_err() {
        return Vec3::ZERO;
    }
    let scattered = |distance: f32| scene.scattered(ray.origin + distance * ray.direction, distance);
    knots.iter_mut().for_each(|knot| knot.radiance = scattered(knot.distance));
    let mut cells = [MarchCell::default(); KNOTS];
    let Ok(march) = March::new(&knots, &mut cells) else { return Vec3::ZERO };
    let jitter: [f32; SHADOW_RAYS] = std::array::from_fn(|i| march_number(scene.seed, numbers, i as u32));
    let mut samples = [MarchSample::default(); SHADOW_RAYS];
    march.place(&jitter, &mut samples);
    let mut sum = 0.0;
    for sample in samples.iter().filter(|sample| sample.weight > 0.0) {
        let position = ray.origin + sample.distance * ray.direction;
        if !is_shadowed(scene, position) {
            sum += sample.weight * scattered(sample.distance);
        }
    }
    sum * scene.single_scattering_color()
}

/// Whether the ball is between the lamp and a point: what it refracts is light of other paths.
fn is_shadowed(scene: &Scene, position: Vec3) -> bool {
    let way = position - scene.lamp();
    let length = way.length();
    scene.ball.distance(&Ray::in_fog(scene.lamp(), way / length)) < length
}
