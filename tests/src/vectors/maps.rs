//! Pairs of an eye ray and a beam, and maps of beams.

use super::grids::{Grid, Segment, segment};
use super::hard::{Fog, Hard, Voxels};
use super::kernels::SHAPES;
use super::media::medium;
use super::words::{Script, Words};
use covbeam::{
    BLOCK, Beam, BeamBlock, BeamMap, Crossing, EyeRay, GatherScratch, Gathered, GridLayout, Kernel, Vec3,
    cross, gather_pair,
};

pub(super) fn write(script: &mut Script) {
    let hard = &mut Hard::new(5);
    script.comment("Pairs and maps");
    let voxels = Voxels::new(hard, Vec3::splat(-2.0), Vec3::splat(2.0), [6, 6, 6], 2.0);
    script.call("density_new", &[&voxels.layout, &voxels.values], &[]);
    let layout = GridLayout { min: Vec3::splat(-2.0), max: Vec3::splat(2.0), cells: [10, 10, 10] };
    let mut grid = Grid::new(script, layout);
    let segments: Vec<Segment> = (0..60).map(|_| segment(hard, 1.5)).collect();
    grid.deposit(script, &Fog::homogeneous(medium(hard)), &segments);
    grid.resolve(script);
    grid.save(script);

    let fogs = [
        Fog::homogeneous(medium(hard)),
        Fog::exponential(medium(hard), hard.point(1.0), hard.direction(), 1.5),
        Fog::voxels(medium(hard), &voxels),
    ];
    for fog in &fogs {
        pairs(script, hard, &grid, fog);
        maps(script, hard, &grid, fog);
    }
}

/// From a lamp to the floor at z = -1, from the floor, or in the open.
fn beam(hard: &mut Hard) -> Beam {
    let channels = hard.chance(0.5);
    let power = hard.decades(-4.0, 2.0)
        * if channels { Vec3::new(1.0, hard.uniform(), hard.uniform()) } else { Vec3::ONE };
    match hard.below(4) {
        0 | 1 => {
            let (origin, end) = (
                Vec3::new(0.3, -0.2, 1.5),
                Vec3::new(hard.between(-2.0, 2.0), hard.between(-2.0, 2.0), -1.0),
            );
            let (direction, length) = ((end - origin).normalize(), (end - origin).length());
            Beam { origin, direction, length, power, start_normal: Vec3::ZERO, end_normal: Vec3::Z }
        }
        2 => {
            let origin = Vec3::new(hard.between(-2.0, 2.0), hard.between(-2.0, 2.0), -1.0);
            let direction = hard.unit();
            let direction = if direction.z < 0.0 { -direction } else { direction };
            let length = hard.decades(-1.0, 1.0);
            Beam { origin, direction, length, power, start_normal: Vec3::Z, end_normal: Vec3::ZERO }
        }
        _ => {
            let length = if hard.chance(0.05) { 0.0 } else { hard.decades(-3.0, 2.0) };
            let (origin, direction) = (hard.point(2.0), hard.unit());
            Beam { origin, direction, length, power, start_normal: Vec3::ZERO, end_normal: Vec3::ZERO }
        }
    }
}

/// Towards a point that something may be at.
fn ray(hard: &mut Hard) -> EyeRay {
    let origin = hard.point(4.0);
    let towards = hard.point(1.0) - origin;
    let length = if hard.chance(0.3) { f32::INFINITY } else { towards.length() * hard.between(0.2, 2.0) };
    EyeRay { origin, direction: towards.normalize(), length }
}

/// Past a point of the beam, at most `gap` away from it.
fn ray_near(hard: &mut Hard, beam: &Beam, gap: f32) -> EyeRay {
    let on_beam = beam.origin + beam.length * hard.between(-0.1, 1.1) * beam.direction;
    let origin = hard.point(4.0);
    let towards = on_beam + gap * hard.uniform() * hard.unit() - origin;
    let length = if hard.chance(0.3) { f32::INFINITY } else { towards.length() * hard.between(0.8, 3.0) };
    EyeRay { origin, direction: towards.normalize(), length }
}

/// A camera's: `side` x `side` of them.
fn tile(hard: &mut Hard, side: u32) -> Vec<EyeRay> {
    let (eye, corner) =
        (Vec3::new(0.0, -4.0, 0.2), Vec3::new(hard.between(-1.0, 0.5), 0.0, hard.between(-1.0, 0.5)));
    (0..side * side)
        .map(|i| {
            let pixel = Vec3::new((i % side) as f32, 0.0, (i / side) as f32) * 0.05;
            EyeRay { origin: eye, direction: (corner + pixel - eye).normalize(), length: 7.0 }
        })
        .collect()
}

fn kernel<'a>(hard: &mut Hard, grid: Option<&'a Grid>, max_radius: f32) -> Kernel<'a> {
    Kernel {
        shape: SHAPES[hard.below(3) as usize],
        min_radius: max_radius * hard.decades(-1.5, 0.0),
        max_radius,
        error: hard.decades(-2.5, 0.0),
        grid: grid.map(Grid::fluence),
    }
}

fn pairs(script: &mut Script, hard: &mut Hard, grid: &Grid, fog: &Fog) {
    for i in 0..20 {
        let beam = beam(hard);
        let mut ray = ray_near(hard, &beam, 0.3);
        if i % 5 == 0 {
            // Nearly parallel, and side by side.
            ray.direction = (beam.direction + hard.decades(-7.0, -3.0) * hard.unit()).normalize();
            ray.origin = beam.origin + 0.01 * beam.direction.any_orthonormal_vector();
        }
        let none =
            Crossing { ray_distance: 0.0, beam_distance: 0.0, gap: 0.0, sin_theta: 0.0, axis: Vec3::ZERO };
        for beam in [beam, self::beam(hard)] {
            let crossing = cross(&ray, &beam);
            script.call("cross", &[&ray, &beam], &[&crossing.is_some(), &crossing.unwrap_or(none)]);
        }
        if !fog.is_closed_form() {
            continue;
        }
        let use_grid = hard.chance(0.5);
        let radius = kernel(hard, use_grid.then_some(grid), 0.5);
        let (from, to) =
            if hard.chance(0.3) { (0.5 * beam.length, 0.9 * beam.length) } else { (0.0, beam.length) };
        let medium = fog.view();
        let lines = [(ray.origin, ray.direction), (beam.origin, beam.direction)];
        let columns = lines.map(|(origin, direction)| medium.density.column(origin, direction, &[]));
        let mut gathered = Gathered::default();
        let accepted = gather_pair(&ray, &beam, [from, to], &medium, &columns, &radius, &mut gathered);
        let inputs: [&dyn Words; 7] = [&use_grid, fog, &radius, &from, &to, &ray, &beam];
        script.call("gather_pair", &inputs, &[&accepted, &gathered]);
    }
    for count in [1, 7, 8, 20] {
        let beams: Vec<Beam> = (0..count).map(|_| beam(hard)).collect();
        let (ray, max_radius) = (ray_near(hard, &beams[0], 0.2), hard.decades(-2.0, 0.0));
        let masks: Vec<u32> = beams.chunks(BLOCK).flat_map(|beams| filter(&ray, beams, max_radius)).collect();
        script.call("filter_beams", &[&ray, &beams, &max_radius], &[&masks]);
    }
}

fn filter(ray: &EyeRay, beams: &[Beam], max_radius: f32) -> Vec<u32> {
    let mut block = BeamBlock::EMPTY;
    for (slot, beam) in beams.iter().enumerate() {
        block.set(slot, beam, 0.0, beam.length);
    }
    let hit = block.test(ray, max_radius);
    (0..beams.len()).map(|slot| hit >> slot & 1).collect()
}

fn maps(script: &mut Script, hard: &mut Hard, grid: &Grid, fog: &Fog) {
    script.call("beam_map_new", &[fog], &[]);
    // The first is what a pair is, with tables of columns where there are voxels.
    for (round, count) in [1, 1, 1, 130, 0].into_iter().enumerate() {
        if round > 0 {
            script.call("beam_map_clear", &[], &[]);
        }
        let beams: Vec<Beam> = (0..count).map(|_| beam(hard)).collect();
        // In batches.
        for batch in beams.chunks(47) {
            script.call("beam_map_add", &[&batch.to_vec()], &[]);
        }
        let max_radius = 0.4;
        script.call("beam_map_commit", &[&max_radius], &[]);
        let map = BeamMap::build(beams.clone(), max_radius, &fog.view());
        let looks: Vec<Vec<EyeRay>> = if count > 1 {
            vec![tile(hard, 1), tile(hard, 8), (0..200).map(|_| ray(hard)).collect()]
        } else {
            let near = |_| {
                vec![match beams.first() {
                    Some(beam) => ray_near(hard, beam, 0.1),
                    None => ray(hard),
                }]
            };
            (0..4).map(near).collect()
        };
        for rays in looks {
            for use_grid in [false, true] {
                let radius = kernel(hard, use_grid.then_some(grid), max_radius);
                let mut gathered = vec![Gathered::default(); rays.len()];
                let scratch = &mut GatherScratch::default();
                map.gather(&fog.view(), &rays, &radius, &mut gathered, scratch).expect("its own medium");
                script.call("beam_map_gather", &[&use_grid, &radius, &rays], &[&gathered]);
            }
        }
    }
}
