//! What the ABI adds to a gather: `cargo test -p covbeam-ffi --release -- --ignored --nocapture overhead`.
//!
//! In instructions, which are steadier: the test's program under callgrind, `covbeam_beam_map_gather` over
//! `BeamMap::gather_while` in it. 80 pairs a ray: 0.96 %.
#![allow(clippy::print_stdout)]

use super::gather::covbeam_beam_map_gather;
use super::handle::{covbeam_beam_map_add, covbeam_beam_map_commit, covbeam_beam_map_new};
use super::scratch::covbeam_scratch_new;
use crate::beam::covbeam_beam;
use crate::eye_ray::{covbeam_eye_ray, covbeam_gathered};
use crate::kernel::options::covbeam_kernel;
use crate::medium::options::covbeam_medium;
use crate::medium::phase::covbeam_phase;
use crate::status::covbeam_status::*;
use covbeam_core::{Beam, BeamMap, EyeRay, GatherScratch, Gathered, Kernel, KernelShape, Medium};
use glam::Vec3;
use std::ptr::{null, null_mut};
use std::time::Instant;

const RADIUS: f32 = 0.02;
const TILES: u32 = 256;

/// Points that fill a cube of side 2 evenly: multiples of the golden ratio's relatives.
fn point(index: u32, shift: f64) -> Vec3 {
    let turn = |step: f64| ((f64::from(index) * step + shift).fract() * 2.0 - 1.0) as f32;
    Vec3::new(turn(0.819_172_513_396), turn(0.671_043_606_703), turn(0.549_700_477_901))
}

fn beams() -> Vec<Beam> {
    (0..5000)
        .map(|i| {
            let (from, to) = (point(i, 0.1), point(i, 0.7) + Vec3::splat(1e-3));
            let power = Vec3::splat(1e-3);
            let (direction, length) = ((to - from).normalize(), 2.0);
            Beam { origin: from, direction, length, power, ..Beam::default() }
        })
        .collect()
}

/// 64 rays side by side from in front of the cube.
fn tile(index: u32) -> Vec<EyeRay> {
    let aim = point(index, 0.3);
    (0..64)
        .map(|i| {
            let origin = Vec3::new(0.0, 0.0, -5.0);
            let pixel = Vec3::new((i % 8) as f32, (i / 8) as f32, 0.0) * 0.01;
            EyeRay { origin, direction: (aim + pixel - origin).normalize(), length: 10.0 }
        })
        .collect()
}

#[test]
#[ignore = "a measurement, to be run alone and in release"]
fn overhead_of_a_gather() {
    let fog = Medium { scattering: Vec3::splat(0.2), absorption: Vec3::splat(0.02), ..Medium::default() };
    let tiles: Vec<Vec<EyeRay>> = (0..TILES).map(tile).collect();
    let kernel = Kernel {
        shape: KernelShape::Epanechnikov,
        min_radius: RADIUS,
        max_radius: RADIUS,
        error: 0.01,
        grid: None,
    };
    let map = BeamMap::build(beams(), RADIUS, &fog);
    let mut scratch = GatherScratch::default();
    let mut rust = move |out: &mut Vec<Gathered>| {
        out.clear();
        let start = Instant::now();
        for rays in &tiles {
            let mut gathered = [Gathered::default(); 64];
            map.gather(&fog, rays, &kernel, &mut gathered, &mut scratch).unwrap();
            out.extend(gathered);
        }
        start.elapsed().as_secs_f64()
    };

    let to_c = |b: &Beam| covbeam_beam {
        origin: b.origin.into(),
        direction: b.direction.into(),
        length: b.length,
        power: b.power.into(),
        start_normal: [0.0; 3],
        end_normal: [0.0; 3],
    };
    let list: Vec<covbeam_beam> = beams().iter().map(to_c).collect();
    let ray = |r: &EyeRay| covbeam_eye_ray {
        origin: r.origin.into(),
        direction: r.direction.into(),
        length: r.length,
    };
    let tiles: Vec<Vec<covbeam_eye_ray>> = (0..TILES).map(|i| tile(i).iter().map(ray).collect()).collect();
    let medium = covbeam_medium {
        struct_size: size_of::<covbeam_medium>() as u32,
        scattering: [0.2; 3],
        absorption: [0.02; 3],
        phase: covbeam_phase { kind: 0, asymmetry: 0.0 },
        density: 0,
        origin: [0.0; 3],
        up: [0.0; 3],
        scale_height: 0.0,
        voxels: null(),
    };
    let kernel = covbeam_kernel {
        struct_size: size_of::<covbeam_kernel>() as u32,
        shape: 1,
        min_radius: RADIUS,
        max_radius: RADIUS,
        error: 0.01,
    };
    let (mut map, mut scratch) = (null_mut(), null_mut());
    // SAFETY: all pointers are to locals that outlive the calls, with their own strides.
    unsafe {
        assert_eq!(covbeam_beam_map_new(&medium, &mut map), COVBEAM_OK);
        assert_eq!(
            covbeam_beam_map_add(map, list.len(), list.as_ptr(), size_of::<covbeam_beam>()),
            COVBEAM_OK
        );
        assert_eq!(covbeam_beam_map_commit(map, RADIUS, None, null_mut()), COVBEAM_OK);
        assert_eq!(covbeam_scratch_new(&mut scratch), COVBEAM_OK);
    }
    let none = covbeam_gathered { radiance: [0.0; 3], pairs: 0, weight: 0.0, radius: 0.0, sigma: 0.0 };
    let c = move |out: &mut Vec<covbeam_gathered>| {
        out.clear();
        let start = Instant::now();
        for rays in &tiles {
            let mut gathered = [none; 64];
            // SAFETY: as above.
            let status = unsafe {
                covbeam_beam_map_gather(
                    map,
                    &kernel,
                    null(),
                    64,
                    rays.as_ptr(),
                    size_of::<covbeam_eye_ray>(),
                    gathered.as_mut_ptr(),
                    size_of::<covbeam_gathered>(),
                    scratch,
                    None,
                    null_mut(),
                )
            };
            assert_eq!(status, COVBEAM_OK);
            out.extend(gathered);
        }
        start.elapsed().as_secs_f64()
    };

    let (mut by_rust, mut by_c) = (Vec::new(), Vec::new());
    rust(&mut by_rust);
    c(&mut by_c);
    assert!(by_rust.iter().zip(&by_c).all(|(a, b)| covbeam_gathered::from(*a) == *b), "the same bits");
    let pairs: u64 = by_c.iter().map(|g| u64::from(g.pairs)).sum();
    // Pairs of runs, in turn: what else the machine does hits both alike. The median shrugs off the rest.
    let mut ratios: Vec<f64> = (0..101)
        .map(|i| {
            if i % 2 == 0 {
                let first = rust(&mut by_rust);
                c(&mut by_c) / first
            } else {
                let first = c(&mut by_c);
                first / rust(&mut by_rust)
            }
        })
        .collect();
    ratios.sort_by(f64::total_cmp);
    let rays = by_c.len();
    println!(
        "{rays} rays, {pairs} pairs: C ABI / Rust = {:.4} (median of 101; quartiles {:.4}, {:.4})",
        ratios[50], ratios[25], ratios[75]
    );
}
