//! A pane of glass without thickness in fog: it has no inside, whichever side is its front.

use super::paths::{HAZE, seen, traced};
use super::scenes::{Part, camera, inverted, lamp, lobes, medium, part, scene, sheet};
use covbeam_session::paths::Record;
use covbeam_session::scene::{Lobes, Material, Scene};
use glam::{DVec2, Vec3};

/// Where the pane is, and how far rays are followed \[m\].
const PLACE: f32 = 0.5;
const REACH: f32 = 6.0;

const LAMP: Vec3 = Vec3::new(0.3, 0.4, 2.5);

/// What a ray from a place has of either side without a pane \[m\].
fn expected(from: Vec3, direction: Vec3) -> DVec2 {
    let cut = (PLACE - from.z) / direction.z;
    let first = f64::from(if cut > 0.0 { cut.min(REACH) } else { REACH });
    let sides = DVec2::new(first, f64::from(REACH) - first);
    if from.z < PLACE { sides } else { DVec2::new(sides.y, sides.x) }
}

/// What a piece of one has, in fog that is not inside of glass.
fn of_piece(scene: &Scene, from: Vec3, (origin, direction): (Vec3, Vec3), length: f32, medium: u32) -> DVec2 {
    let length = length.min(REACH - origin.distance(from)).max(0.0);
    let is_behind = (origin + 0.5 * length * direction).z > PLACE;
    let side = if is_behind { DVec2::Y } else { DVec2::X };
    if scene.is_in_glass(medium) { DVec2::ZERO } else { f64::from(length) * side }
}

/// Fog that takes next to nothing, on both sides of a pane that bends nothing: taken for solid it would cost half of what is seen, or of the light.
#[test]
fn a_pane_without_thickness_leaves_the_fog_behind_it_lit_and_seen() {
    let eye = camera([0.0, 0.0, -4.0], [0.0; 3], 40.0, 16);
    let text = [HAZE, &eye, &lamp(LAMP.to_array(), 10.0), &medium("fog", 1e-6, 0.0)].concat();
    let air = Lobes { glass_reflection: Vec3::ONE, glass_transmission: Vec3::ONE, ..lobes(1.0001) };
    let pane = sheet(Vec3::new(-90.0, -90.0, PLACE), Vec3::X * 180.0, Vec3::Y * 180.0);
    for mesh in [pane.clone(), inverted(pane)] {
        let pane = Part { is_closed: false, ..part(mesh, Material::of_lobes(air)) };
        let scene = &scene(&text, &[pane], Vec::new());
        let (mut found, mut truth) = (DVec2::ZERO, DVec2::ZERO);
        for (x, y) in (0..16).flat_map(|y| (0..16).map(move |x| (x, y))) {
            let direction = scene.camera.direction(x as f32 + 0.5, y as f32 + 0.5).normalize();
            truth += expected(scene.camera.position, direction);
            for piece in seen(scene, direction, [true; 2], y * 16 + x).0 {
                let ray = (piece.ray.origin, piece.ray.direction);
                let length = of_piece(scene, scene.camera.position, ray, piece.ray.length, piece.medium);
                found += f64::from(piece.throughput.x) * length;
            }
        }
        println!("seen: {found} of {truth}");
        assert!((found / truth - 1.0).abs().max_element() < 2e-3, "{found} {truth}");

        let record = traced(scene, 2000, Record::Beams);
        let power = record.energy.emitted[0] / 2000.0;
        let (mut found, mut truth) = (DVec2::ZERO, DVec2::ZERO);
        for path in &record.beams {
            let ray = (path.beam.origin, path.beam.direction);
            if ray.0.distance(LAMP) < 1e-3 {
                truth += power * expected(LAMP, ray.1);
            }
            found += f64::from(path.beam.power.x) * of_piece(scene, LAMP, ray, path.beam.length, path.medium);
        }
        println!("lit: {found} of {truth}");
        assert!((found / truth - 1.0).abs().max_element() < 2e-3, "{found} {truth}");
    }
}
