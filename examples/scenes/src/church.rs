//! A nave of 8 x 13 x 25 m under a pointed barrel vault, with a rose window of bar tracery in its west front.
//!
//! The front stands at z = 0, the nave reaches to z = 25, the floor is y = 0, +y is up. Lengths in metres.

use crate::outline::{Outline, arc, circle, crossing, foil, turned, unit};
use crate::solid::Solid;
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Half the clear width.
const HALF_WIDTH: f64 = 4.0;
/// Clear length.
const LENGTH: f64 = 25.0;
/// Height at which the vault springs from the walls; its arcs have the clear width as radius (an equilateral arch).
const SPRINGING: f64 = 6.0;
/// Middle of the rose.
const ROSE_CENTER: DVec2 = DVec2::new(0.0, 7.0);
/// Radius of the opening in the front that the tracery fills.
const ROSE_RADIUS: f64 = 3.0;
/// Petals of the rose.
const PETALS: u32 = 12;

/// The pointed arch over the walls, `offset` outside the vault's inner face, from the right springing point over the
/// apex to the left one.
fn vault(offset: f64) -> Outline {
    let radius = 2.0 * HALF_WIDTH + offset;
    let apex = libm::acos(HALF_WIDTH / radius);
    let mut outline = arc(DVec2::new(-HALF_WIDTH, SPRINGING), radius, 0.0, apex);
    // The apex is the other arc's first point.
    outline.pop();
    outline.extend(arc(DVec2::new(HALF_WIDTH, SPRINGING), radius, PI - apex, PI));
    outline
}

/// Section of the clear space.
fn clear_section() -> Outline {
    let mut outline = vec![DVec2::new(-HALF_WIDTH, 0.0), DVec2::new(HALF_WIDTH, 0.0)];
    outline.extend(vault(0.0));
    outline
}

/// Section of the building, walls and pitched roof, `margin` larger all around.
fn outer_section(margin: f64) -> Outline {
    let right = HALF_WIDTH + 0.8 + margin;
    let (foot, eaves, ridge) = (-0.6 - margin, 9.0 + margin, 15.0 + margin);
    [(-right, foot), (right, foot), (right, eaves), (0.0, ridge), (-right, eaves)].map(DVec2::from).to_vec()
}

/// The building without its tracery: a tunnel of stone, closed by a front with the rose's opening and by a plain
/// east wall; wall shafts with transverse ribs; pews.
pub fn nave() -> Solid {
    let opening = circle(ROSE_CENTER, ROSE_RADIUS, 96);
    // The tunnel ends inside the end walls: no two faces meet edge to edge, so no light gets through between them.
    let mut nave = Solid::extruded(&outer_section(0.0), &[clear_section()], -0.4, LENGTH + 0.4);
    nave.append(Solid::extruded(&outer_section(0.2), &[opening], -0.8, 0.0));
    nave.append(Solid::extruded(&outer_section(0.2), &[], LENGTH, LENGTH + 0.8));
    for bay in 0..5 {
        let z = 2.5 + 5.0 * f64::from(bay);
        for side in [-1.0_f64, 1.0] {
            nave.append(Solid::lathed(side * (HALF_WIDTH - 0.05), z, &wall_shaft(), 24));
        }
        nave.append(rib(z));
    }
    for row in 0..8 {
        let z = 4.0 + 1.5 * f64::from(row);
        for side in [-1.0_f64, 1.0] {
            let (near, far) = (side * 0.7, side * 3.1);
            let block = |low: f64, high: f64, from: f64, to: f64| {
                Solid::block(
                    DVec3::new(near.min(far), low, z + from),
                    DVec3::new(near.max(far), high, z + to),
                )
            };
            nave.append(block(0.42, 0.47, 0.0, 0.4));
            nave.append(block(-0.1, 0.95, -0.03, 0.02));
        }
    }
    nave
}

/// (radius, height) of a wall shaft with base and capital; its foot stands in the floor.
fn wall_shaft() -> Vec<DVec2> {
    [
        (0.42, -0.1),
        (0.42, 0.35),
        (0.36, 0.5),
        (0.38, 0.58),
        (0.28, 0.7),
        (0.28, 5.35),
        (0.33, 5.42),
        (0.30, 5.5),
        (0.45, 5.85),
        (0.45, 6.1),
    ]
    .map(DVec2::from)
    .to_vec()
}

/// The transverse arch over a pair of wall shafts; its back is inside the vault.
fn rib(z: f64) -> Solid {
    let mut outline = vault(0.2);
    outline.extend(vault(-0.3).into_iter().rev());
    Solid::extruded(&outline, &[], z - 0.22, z + 0.22)
}

/// The tracery: a plate of 30 cm in the middle of the front's depth, pierced by [`rose_lights`]. Its rim is inside
/// the front's stone.
pub fn rose_window() -> Solid {
    let at_center =
        |outline: Outline| -> Outline { outline.iter().map(|point| *point + ROSE_CENTER).collect() };
    let lights: Vec<Outline> = rose_lights().into_iter().map(at_center).collect();
    Solid::extruded(&circle(ROSE_CENTER, ROSE_RADIUS + 0.1, 96), &lights, -0.55, -0.25)
}

/// The openings of the rose about its centre: an oculus of eight lobes; twelve petals with trefoil heads; between
/// and above the heads small quatrefoils and roundels; a ring of 24 quatrefoils; a ring of 24 small roundels.
pub fn rose_lights() -> Vec<Outline> {
    let mut lights = vec![foil(DVec2::ZERO, 8, 0.36, 0.17, 0.0)];
    let petal = petal();
    let step = TAU / f64::from(PETALS);
    for i in 0..PETALS {
        let axis = FRAC_PI_2 + step * f64::from(i);
        let between = axis + step / 2.0;
        lights.push(turned(&petal, axis));
        lights.push(foil(2.07 * unit(between), 4, 0.09, 0.08, between));
        lights.push(circle(2.27 * unit(axis), 0.07, 24));
        for ring in [axis - step / 4.0, axis + step / 4.0] {
            lights.push(foil(2.55 * unit(ring), 4, 0.14, 0.13, ring));
        }
        for ring in [axis, between] {
            lights.push(circle(2.86 * unit(ring), 0.06, 24));
        }
    }
    lights
}

/// The petal that points along +x: a round foot, sides that leave a bar of 11 cm between neighbours, and a head of
/// three lobes, the outer two of which continue the sides smoothly.
fn petal() -> Outline {
    const BAR: f64 = 0.11;
    const LOBE: f64 = 0.2;
    let slope = PI / f64::from(PETALS);
    let half_width = |along: f64| along * libm::tan(slope) - BAR / 2.0 / libm::cos(slope);
    let foot = 0.85;
    let shoulder = 1.66;
    let mirror = |point: DVec2| DVec2::new(point.x, -point.y);
    let side_lobe = DVec2::new(shoulder, half_width(shoulder)) - LOBE * unit(slope + FRAC_PI_2);
    let top_lobe = DVec2::new(side_lobe.x + 0.17, 0.0);
    let cusp = crossing(top_lobe, LOBE, mirror(side_lobe), LOBE);
    let angle = |from: DVec2, to: DVec2| libm::atan2(to.y - from.y, to.x - from.x);

    // The lower half of the head, then the upper by reflection, counter-clockwise.
    let right = arc(mirror(side_lobe), LOBE, -slope - FRAC_PI_2, angle(mirror(side_lobe), cusp));
    let reach = angle(top_lobe, cusp);
    let mut outline = arc(DVec2::new(foot, 0.0), half_width(foot), FRAC_PI_2, 3.0 * FRAC_PI_2);
    outline.extend(&right);
    // Each arc starts where the one before ended.
    outline.pop();
    outline.extend(arc(top_lobe, LOBE, reach, -reach));
    outline.pop();
    outline.extend(right.into_iter().rev().map(mirror));
    outline
}

/// (name, OBJ text) of the files that the program `rose-window` writes.
pub fn files() -> [(&'static str, String); 2] {
    let header =
        |what: &str| format!("{what}, in metres.\nWritten by the program rose-window of covbeam-scenes.");
    [
        ("nave.obj", nave().to_obj(&header("A nave with an opening for a rose window"))),
        ("rose-window.obj", rose_window().to_obj(&header("The tracery of a rose window"))),
    ]
}
