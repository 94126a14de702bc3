//! Where shadow rays go along eye rays.

use super::hard::Hard;
use super::words::Script;
use covbeam::{March, MarchCell, MarchKnot, MarchSample};

pub(super) fn write(script: &mut Script) {
    let hard = &mut Hard::new(7);
    script.comment("Shadow rays along eye rays");
    for count in [2, 3, 17] {
        for _ in 0..2 {
            march(script, hard, count);
        }
    }
}

fn march(script: &mut Script, hard: &mut Hard, count: u32) {
    let (origin, direction, light) = (hard.point(2.0), hard.unit(), hard.point(3.0));
    let from = if hard.chance(0.5) { 0.0 } else { hard.decades(-2.0, 0.0) };
    let to = if hard.chance(0.2) { f32::INFINITY } else { from + hard.decades(-1.0, 1.0) };
    let mut knots = vec![MarchKnot::default(); count as usize];
    MarchKnot::lay(origin, direction, from, to, light, &mut knots).expect("all are numbers");
    let distances: Vec<f32> = knots.iter().map(|knot| knot.distance).collect();
    script.call("march_lay", &[&origin, &direction, &from, &to, &light, &count], &[&distances]);
    let unknown = hard.chance(0.3);
    for knot in &mut knots {
        let dark = hard.chance(0.2);
        knot.radiance = if dark { 0.0 } else { hard.decades(-4.0, 2.0) };
        knot.deviation = if unknown { -1.0 } else { hard.decades(-2.0, 2.0) };
        knot.visibility = if unknown { -1.0 } else { hard.uniform() };
    }
    script.call("march_update", &[&knots], &[]);
    let mut cells = vec![MarchCell::default(); knots.len()];
    let march = March::new(&knots, &mut cells).expect("laid in order");
    script.call("march_get_expected", &[], &[&march.expected_radiance(), &march.expected_error()]);
    for rays in [1_u32, 40, 5000] {
        let first = march.first_round(rays as usize) as u32;
        script.call("march_get_first_round", &[&rays], &[&first]);
    }
    let jitters = |hard: &mut Hard, count: u32| -> Vec<f32> { (0..count).map(|_| hard.uniform()).collect() };
    let mut first = vec![MarchSample::default(); 5];
    let jitter = jitters(hard, 5);
    march.place(&jitter, &mut first);
    script.call("march_place", &[&jitter], &[&first]);
    for sample in &mut first {
        sample.visibility = if hard.chance(0.5) { 0.0 } else { hard.uniform() };
    }
    for used in [0_u32, 5] {
        let mut second = vec![MarchSample::default(); 9];
        let jitter = jitters(hard, 9);
        let before = &first[..used as usize];
        march.refine(before, &jitter, &mut second);
        script.call("march_refine", &[&used, &before.to_vec(), &jitter], &[&second]);
    }
    // So that a table without light is among them.
    let dark =
        [0.5_f32, 2.0].map(|distance| MarchKnot { distance, radiance: 0.0, deviation: 1.0, visibility: 1.0 });
    if count == 2 {
        script.call("march_update", &[&dark], &[]);
        let mut cells = [MarchCell::default(); 2];
        let mut samples = vec![MarchSample::default(); 2];
        March::new(&dark, &mut cells).expect("in order").place(&[0.5; 2], &mut samples);
        script.call("march_place", &[&[0.5_f32; 2]], &[&samples]);
    }
}
