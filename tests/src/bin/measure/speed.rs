//! What this core can do, how near the gather comes to it, and how both grow with the number of beams.

use crate::Outcome;
use covbeam::{Beam, BeamMap, EyeRay, GatherScratch, Gathered, Medium, Vec3, cross};
use covbeam_session::random::Random;
use covbeam_tests::kernel::plain;
use cpu_time::ThreadTime;
use fearless_simd::{Level, Simd, SimdBase, SimdFloat, dispatch, f32x8, f32x16};
use std::hint::black_box;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// Runs of which the median is taken.
const RUNS: usize = 7;

/// Sums that grow side by side, so that none waits for the one before.
const CHAINS: usize = 12;

/// Beams whose speed of growth is measured.
const COUNTS: [usize; 4] = [1_000, 10_000, 100_000, 1_000_000];

/// Beams that a ray meets on average, about.
const HITS: f32 = 60.0;

/// Pixels along a side of the picture, and of a tile.
const SIDE: u32 = 256;
const TILE: u32 = 32;

/// Operations on numbers in a test of one ray against one sub-beam: `Pairs::new` of core/src/beam_map/eight.rs up to `candidates`,
/// sums, differences and products each counted as one. Normal 9, its square 5, offset 3, triple product 5, both distances 14 each, and the
/// bounds: near 2, on the ray 2, on the beam 4. (And 5 comparisons, not counted.)
const FLOPS_OF_A_TEST: f64 = 58.0;

const FOG: Medium = Medium::homogeneous(0.2, 0.02);

pub(crate) fn run() -> Outcome<()> {
    println!(
        "CPU time of the thread that works, median of {RUNS} runs; SIMD as chosen on this machine: {:?}",
        Level::new()
    );
    tests(ceilings());
    let first = growth("a picture of the whole box", |_| 0.5);
    growth("a picture as much narrower as the beams are thinner", |thinner| 0.5 / thinner);
    builds();
    two_threads(&first);
    Ok(())
}

/// Core-seconds of a run: the median.
fn median(mut run: impl FnMut()) -> f64 {
    run();
    let mut times = [0.0; RUNS];
    for time in &mut times {
        let start = ThreadTime::now();
        run();
        *time = start.elapsed().as_secs_f64();
    }
    times.sort_by(f64::total_cmp);
    times[RUNS / 2]
}

#[inline(always)]
fn multiply_and_add<S: Simd, V: SimdFloat<S> + SimdBase<S, Element = f32>>(simd: S, rounds: usize) -> f32 {
    let (factor, term) = (V::splat(simd, black_box(0.999)), V::splat(simd, black_box(1e-3)));
    let mut sums = [V::splat(simd, 2.0); CHAINS];
    for _ in 0..rounds {
        for sum in &mut sums {
            *sum = sum.mul_add(factor, term);
        }
    }
    sums.iter().map(|sum| sum.as_slice().iter().sum::<f32>()).sum()
}

#[inline(always)]
fn sum<S: Simd>(simd: S, numbers: &[f32]) -> f32 {
    let mut sums = [f32x16::splat(simd, 0.0); 8];
    for numbers in numbers.chunks_exact(8 * 16) {
        for (sum, numbers) in sums.iter_mut().zip(numbers.chunks_exact(16)) {
            *sum += f32x16::from_slice(simd, numbers);
        }
    }
    sums.iter().map(|sum| sum.as_slice().iter().sum::<f32>()).sum()
}

/// Prints what the core can do at most. Returns its multiplications and additions a second, two for a fused one, with 8 and 16 lanes.
fn ceilings() -> [f64; 2] {
    const ROUNDS: usize = 4_000_000;
    let level = Level::new();
    let eight = median(|| {
        black_box(dispatch!(level, simd => multiply_and_add::<_, f32x8<_>>(simd, black_box(ROUNDS))));
    });
    let sixteen = median(|| {
        black_box(dispatch!(level, simd => multiply_and_add::<_, f32x16<_>>(simd, black_box(ROUNDS))));
    });
    let speed = |lanes: f64, seconds: f64| 2.0 * lanes * (CHAINS * ROUNDS) as f64 / seconds;
    let (eight, sixteen) = (speed(8.0, eight), speed(16.0, sixteen));
    println!("\nceilings of one core");
    println!("fused multiply-add, 8 lanes    {:7.1} Gflop/s", eight / 1e9);
    println!("fused multiply-add, 16 lanes   {:7.1} Gflop/s", sixteen / 1e9);
    for (name, bytes) in [("256 MB", 256 << 20), ("1 MB", 1 << 20)] {
        let numbers = vec![1.0_f32; bytes / 4];
        let times = (256 << 20) / bytes;
        let seconds = median(|| {
            for _ in 0..times {
                black_box(dispatch!(level, simd => sum(simd, black_box(&numbers))));
            }
        });
        println!("read from an array of {name:7}  {:7.1} GB/s", (bytes * times) as f64 / seconds / 1e9);
    }
    [eight, sixteen]
}

fn gather(map: &BeamMap, rays: &[EyeRay], gathered: &mut [Gathered], scratch: &mut GatherScratch) {
    map.gather(&FOG, rays, &plain(map.max_radius()), gathered, scratch).unwrap();
}

/// Accepted pairs of some rays.
fn hits(map: &BeamMap, rays: &[EyeRay]) -> u64 {
    let mut gathered = vec![Gathered::default(); rays.len()];
    gather(map, rays, &mut gathered, &mut GatherScratch::default());
    gathered.iter().map(|sums| u64::from(sums.pairs)).sum()
}

fn direction(random: &mut Random) -> Vec3 {
    let z = 2.0 * random.uniform() - 1.0;
    let (sin, cos) = (std::f32::consts::TAU * random.uniform()).sin_cos();
    let r = (1.0 - z * z).sqrt();
    Vec3::new(r * cos, r * sin, z)
}

/// The even bits of a number, side by side: along this curve neighbours in the list are neighbours in the tile.
fn every_second_bit(number: u32) -> u32 {
    (0..16).map(|bit| (number >> (2 * bit) & 1) << bit).sum()
}

/// Rays from `origin` along z through a square tile of pixels, `spacing` apart at distance 1.
fn tile(origin: Vec3, side: u32, spacing: f32) -> Vec<EyeRay> {
    let middle = 0.5 * (side - 1) as f32;
    (0..side * side)
        .map(|place| {
            let [x, y] = [place, place >> 1].map(|bits| spacing * (every_second_bit(bits) as f32 - middle));
            EyeRay { origin, direction: Vec3::new(x, y, 1.0).normalize(), length: 16.0 }
        })
        .collect()
}

fn tests(ceilings: [f64; 2]) {
    const BEAMS: usize = 10_000;
    const SPACING: f32 = 0.002;
    let random = &mut Random::new([6, 6, 6, 6]);
    println!(
        "\ntests: {BEAMS} beams, one sub-beam of each across the cone of the rays; a test counts as {FLOPS_OF_A_TEST} flops, without \
         comparisons"
    );
    println!("rays                  radius [m]   hits    tests/core-second   of FMA ceiling: 8 lanes | 16");
    let few = tile(Vec3::ZERO, 4, SPACING);
    let many = tile(Vec3::ZERO, 16, SPACING);
    // Each sixteen that are neighbours in the list are spread over the tile: halves are as wide as the whole.
    let spread: Vec<EyeRay> = (0..256).map(|i| many[i % 16 * 16 + i / 16]).collect();
    for (name, rays, side, all_tested) in [
        ("16", &few, 4.0, true),
        ("256, in no order", &spread, 16.0, true),
        ("256, along the curve", &many, 16.0, false),
    ] {
        // Across the rays at a depth of 2 to 6, within what the packet's cone holds of the tile.
        let beams: Vec<Beam> = (0..BEAMS)
            .map(|_| {
                let depth = 2.0 + 4.0 * random.uniform();
                let half = 0.5 * (side - 1.0) * SPACING * depth;
                let [x, y] = [0; 2].map(|_| half * (2.0 * random.uniform() - 1.0));
                let mut direction = direction(random);
                direction = Vec3::new(direction.x, direction.y, 0.5 * direction.z).normalize();
                // A beam is cut in three (or four): so the rays pass one of its parts in the middle.
                Beam {
                    origin: Vec3::new(x, y, depth) - 2.5 * direction,
                    direction,
                    length: 6.0,
                    power: Vec3::ONE,
                    ..Beam::default()
                }
            })
            .collect();
        let mut gaps: Vec<f32> =
            rays.iter().flat_map(|ray| beams.iter().filter_map(|beam| Some(cross(ray, beam)?.gap))).collect();
        let middle = gaps.len() / 2;
        let half = *gaps.select_nth_unstable_by(middle, f32::total_cmp).1;
        for radius in [1e-6, half] {
            let map = BeamMap::build(beams.clone(), radius, &FOG);
            let (mut gathered, mut scratch) =
                (vec![Gathered::default(); rays.len()], GatherScratch::default());
            let times = 4096 / rays.len();
            let seconds = median(|| {
                for _ in 0..times {
                    gather(&map, rays, &mut gathered, &mut scratch);
                }
            });
            let pairs = rays.len() * BEAMS;
            let speed = (times * pairs) as f64 / seconds;
            let share = |ceiling: f64| 100.0 * speed * FLOPS_OF_A_TEST / ceiling;
            let shares = if all_tested {
                format!("{:.1} % | {:.1} %", share(ceilings[0]), share(ceilings[1]))
            } else {
                "(pairs decided, not all by a test: halves of the tile leave beams out)".to_owned()
            };
            println!(
                "{name:21} {radius:9.6} {:6.2} %  {:9.0} M                  {shares}",
                100.0 * hits(&map, rays) as f64 / pairs as f64,
                speed / 1e6,
            );
        }
    }
}

/// Beams of random directions and lengths up to 4 m in a box of side 8 m.
fn beams(count: usize) -> Vec<Beam> {
    let random = &mut Random::new([3, 3, 3, 3]);
    (0..count)
        .map(|_| Beam {
            origin: 8.0 * Vec3::from([0; 3].map(|_| random.uniform())) - Vec3::splat(4.0),
            direction: direction(random),
            length: 4.0 * random.uniform(),
            power: Vec3::ONE,
            ..Beam::default()
        })
        .collect()
}

/// The radius at which a ray across the box meets about [`HITS`] of the beams: it crosses 8 m of a medium that holds `count` x 2 m of
/// beam in 512 m³, each within 2r on an average sine of π/4.
fn radius(count: usize) -> f32 {
    HITS * 512.0 / (count as f32 * 2.0 * 8.0 * 2.0 * std::f32::consts::FRAC_PI_4)
}

/// Pieces that a map cuts beams into: the fewest equal ones no longer than half the average beam.
fn pieces(beams: &[Beam]) -> usize {
    let total: f64 = beams.iter().map(|beam| f64::from(beam.length)).sum();
    let longest = (total / (2 * beams.len()) as f64) as f32;
    beams.iter().map(|beam| (beam.length / longest).ceil().max(1.0) as usize).sum()
}

/// The tiles of a picture from before the box, `half_width` wide at distance 1 on either side.
fn picture(half_width: f32) -> Vec<Vec<EyeRay>> {
    let spacing = 2.0 * half_width / SIDE as f32;
    (0..(SIDE / TILE).pow(2))
        .map(|index| {
            let corner = [index % (SIDE / TILE), index / (SIDE / TILE)].map(|at| (at * TILE) as f32);
            (0..TILE * TILE)
                .map(|place| {
                    let [x, y] = [(corner[0], place), (corner[1], place >> 1)].map(|(corner, bits)| {
                        (corner + every_second_bit(bits) as f32 + 0.5) * spacing - half_width
                    });
                    EyeRay {
                        origin: Vec3::new(0.01, 0.02, -8.0),
                        direction: Vec3::new(x, y, 1.0).normalize(),
                        length: 16.0,
                    }
                })
                .collect()
        })
        .collect()
}

/// The map of 10⁵ beams with the picture of the whole box.
struct Case {
    map: BeamMap,
    picture: Vec<Vec<EyeRay>>,
}

/// Prints the time of a hit over the number of beams; `half_width` of the picture, given how much thinner the beams are than the thickest.
fn growth(name: &str, half_width: impl Fn(f32) -> f32) -> Case {
    println!("\ngather of {SIDE} x {SIDE} rays, {name}");
    println!(
        "beams     radius [m]   hits/ray   core-ns/ray   core-ns/hit   growth   bytes/beam   bytes/sub-beam"
    );
    let mut first = None;
    let mut kept = None;
    for count in COUNTS {
        let (beams, radius) = (beams(count), radius(count));
        let pieces = pieces(&beams);
        let map = BeamMap::build(beams, radius, &FOG);
        let picture = picture(half_width(count as f32 / COUNTS[0] as f32));
        let found: u64 = picture.iter().map(|rays| hits(&map, rays)).sum();
        let (mut gathered, mut scratch) =
            (vec![Gathered::default(); (TILE * TILE) as usize], GatherScratch::default());
        let seconds =
            median(|| picture.iter().for_each(|rays| gather(&map, rays, &mut gathered, &mut scratch)));
        let rays = f64::from(SIDE * SIDE);
        let a_hit = seconds / found as f64;
        println!(
            "{count:9} {radius:10.5} {:10.1} {:13.1} {:13.2} {:8.2} {:12.0} {:13.0}",
            found as f64 / rays,
            1e9 * seconds / rays,
            1e9 * a_hit,
            a_hit / *first.get_or_insert(a_hit),
            map.memory() as f64 / count as f64,
            map.memory() as f64 / pieces as f64,
        );
        if count == COUNTS[2] {
            kept = Some(Case { map, picture });
        }
    }
    kept.expect("one of the counts")
}

fn builds() {
    println!("\nbuild, one thread");
    println!("beams       core-ms   core-ns/beam   core-ns/(beam log2 beams)");
    for count in COUNTS {
        let (mut given, radius) = (Some(beams(count)), radius(count));
        let times = COUNTS[2].div_ceil(count);
        let seconds = median(|| {
            for _ in 0..times {
                let map = BeamMap::build(given.take().expect("given back below"), radius, &FOG);
                given = Some(map.into_beams());
            }
        }) / times as f64;
        let a_beam = 1e9 * seconds / count as f64;
        println!("{count:9} {:9.2} {a_beam:14.1} {:15.2}", 1e3 * seconds, a_beam / (count as f64).log2());
    }
}

/// Gathers a picture on some threads, each taking the next tile. Returns seconds by the clock, and the most core-seconds of a thread.
fn on_threads(case: &Case, threads: usize) -> [f64; 2] {
    let next = AtomicUsize::new(0);
    let start = Instant::now();
    let work = || {
        let start = ThreadTime::now();
        let (mut gathered, mut scratch) =
            (vec![Gathered::default(); (TILE * TILE) as usize], GatherScratch::default());
        while let Some(rays) = case.picture.get(next.fetch_add(1, Ordering::Relaxed)) {
            gather(&case.map, rays, &mut gathered, &mut scratch);
        }
        start.elapsed().as_secs_f64()
    };
    let busiest = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        workers.into_iter().map(|worker| worker.join().expect("no thread panics")).fold(0.0, f64::max)
    });
    [start.elapsed().as_secs_f64(), busiest]
}

fn two_threads(case: &Case) {
    println!("\ntwo threads against one, gather of the picture of the whole box, {} beams", COUNTS[2]);
    let best = |threads| {
        (0..RUNS)
            .map(|_| on_threads(case, threads))
            .fold([f64::INFINITY; 2], |best, run| [best[0].min(run[0]), best[1].min(run[1])])
    };
    let (one, two) = (best(1), best(2));
    println!("by the clock (less where others share the cores)              {:.2} x", one[0] / two[0]);
    println!("one thread's core time over the busier of two's (idle cores)  {:.2} x", one[1] / two[1]);
}
