//! Importance in voxels, and what follows from it for light paths.

use super::hard::{Fog, Hard};
use super::media::medium;
use super::words::Script;
use covbeam::{
    EmissionGuide, EyeRay, GridLayout, Importance, ImportanceCell, ImportanceGrid, ImportanceSums, Vec3,
    weight_window,
};

pub(super) fn write(script: &mut Script) {
    let hard = &mut Hard::new(8);
    script.comment("Importance");
    let fogs = [
        Fog::homogeneous(medium(hard)),
        Fog::exponential(medium(hard), hard.point(1.0), hard.direction(), 1.5),
    ];
    let layout = GridLayout { min: Vec3::new(-1.0, -2.0, -1.5), max: Vec3::splat(1.5), cells: [5, 4, 3] };
    script.call("importance_new", &[&layout], &[]);
    let mut sums = vec![ImportanceSums::default(); layout.cell_count()];
    let mut grid = ImportanceGrid::new(layout, &mut sums).expect("made so");
    for fog in &fogs {
        let mut words = Vec::new();
        for _ in 0..2 {
            let (EyeRay { origin, direction, length }, weight) = (ray(hard), hard.decades(-2.0, 1.0));
            grid.add_eye_ray(&fog.view(), origin, direction, length, weight);
            grid.add_path(&fog.view(), origin, direction, length, weight);
            words.extend(origin.to_array().into_iter().chain(direction.to_array()).chain([length, weight]));
        }
        script.call("importance_add_eye_rays", &[fog, &words], &[]);
        script.call("importance_add_paths", &[fog, &words], &[]);
    }
    // The last is outside.
    let mut words = Vec::new();
    for position in [hard.point(1.0), hard.point(1.0), Vec3::splat(2.0)] {
        let weight = hard.decades(-2.0, 1.0);
        grid.add_surface(position, weight);
        words.extend(position.to_array().into_iter().chain([weight]));
    }
    script.call("importance_add_surfaces", &[&words], &[]);
    script.call("importance_resolve", &[], &[]);
    let mut cells = vec![ImportanceCell::default(); layout.cell_count()];
    grid.resolve(&mut cells).expect("as long");
    let importance = Importance::new(layout, &cells).expect("as long");

    let positions = [hard.point(1.0), hard.point(1.0), hard.point(9.0)];
    let found = positions.map(|position| {
        let ImportanceCell { beam, scattered, surface } = importance.at(position);
        [beam, scattered, surface]
    });
    script.call("importance_at", &[&positions], &[&found]);
    for fog in &fogs {
        let rays = [ray(hard), ray(hard)];
        let worths = rays.map(|EyeRay { origin, direction, length }| {
            let worth = importance.of_segment(&fog.view(), origin, direction, length);
            [worth.beam, worth.scattered, worth.transmittance]
        });
        script.call("importance_of_segments", &[fog, &rays], &[&worths]);
    }
    paths(script, hard);
}

/// Across the box, from inside or outside.
fn ray(hard: &mut Hard) -> EyeRay {
    let origin = hard.point(2.0);
    let towards = hard.point(0.5) - origin;
    let length = if hard.chance(0.3) { f32::INFINITY } else { hard.between(0.3, 6.0) };
    EyeRay { origin, direction: towards.normalize(), length }
}

/// What splits, ends and emits them.
fn paths(script: &mut Script, hard: &mut Hard) {
    for count in [1, 6] {
        let expected: Vec<f32> = (0..count).map(|_| hard.decades(-1.5, 0.5)).collect();
        let (mut factors, u) = (expected.clone(), hard.uniform());
        weight_window(&mut factors, u);
        script.call("weight_window", &[&expected, &u], &[&factors]);
    }
    let side = 3;
    let weights: Vec<f32> =
        (0..9).map(|_| if hard.chance(0.3) { 0.0 } else { hard.decades(-3.0, 2.0) }).collect();
    let mut cumulative = vec![0.0; EmissionGuide::size(side)];
    let guide = EmissionGuide::fill(side, &weights, 0.15, &mut cumulative).expect("weights that are some");
    let points = [(); 4].map(|()| [hard.uniform(), hard.uniform()]);
    let warped: Vec<f32> = points
        .iter()
        .flat_map(|point| {
            let (place, density) = guide.warp(*point);
            [place[0], place[1], density]
        })
        .collect();
    let side = side as u32;
    script.call("emission_guide_fill", &[&side, &weights, &0.15_f32], &[&cumulative]);
    script.call("emission_guide_warp", &[&side, &cumulative, &points], &[&warped]);
}
