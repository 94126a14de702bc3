//! Benchmarks of the hot paths. Estimates of the floor, for a core at 3 GHz that starts four operations on 8 lanes of single precision in a
//! cycle, or two fused ones (96 Gflop/s either way), and reads 30 GB/s from memory and 150 GB/s from its own cache (`measure speed` prints
//! what this core does):
//!
//! - look-up: 8 cells x 28 bytes = 224 bytes, in cache for 32³ (0.9 MB); 2 x 56 flops: 2 to 6 ns, latency-bound.
//! - deposit: one slice (about 60 flops) and 56 bytes read and written a voxel: 5 ns.
//! - test of a pair: 58 flops and 5 comparisons, none fused, as the bits are those of the definition: 0.66 ns. A piece is read (36 bytes, and 16
//!   of its beam's 76) and written side by side (76 bytes) once for 16 rays: 0.05 ns a test from cache, 0.2 ns if each is a line from
//!   memory of its own.
//! - accepted pair, homogeneous: about 60 flops with one exp, 0.6 ns; five divisions and a square root of 8 lanes at 5 cycles each, 1.3 ns where
//!   all eight are accepted, 10 ns where one is; seven sums, one pair after the other at 4 cycles, 1.3 ns: 3 ns at best. A look-up adds
//!   224 bytes and 112 flops, its cells added up pair by pair: 4 ns.
//! - build, a beam of 3.5 pieces: each a ticket of 16 bytes that is moved 8 times, a piece of 36 bytes written twice, two nodes of 32 bytes
//!   written twice and 11 bytes of wide ones: 1.8 kB a beam, 60 ns from memory; about 10 boxes a piece joined and measured at 12
//!   flops, scalar: 60 ns.
//! - spectrum of a pixel, a step: a look-up, 60 flops and an exp: 20 ns; in voxels a second trilinear look-up, 21 more voxels for the
//!   derivatives and 100 flops: 60 ns.
//! - pixel through a filter: a circle of 3 standard deviations holds 113 to 452 blocks of a half to a quarter of one; 30 flops, an exp and
//!   20 bytes each, scalar: 5 ns, so 0.6 to 2.3 µs; one of 1:8 holds 8 times as many.
//! - places along an eye ray: 97 knots and 30 samples of about 60 flops in f64, a cube root a knot: 2 µs.
//! - nodes of a picture: 20 bytes a pixel read, a third as many written: 1.3 ns a pixel.

use covbeam::{
    Beam, BeamMap, Column, Contact, CovarianceGrid, Curvature, Density, DensityGrid, ExponentialDensity,
    EyeRay, FilmNode, FilmSample, FluenceCell, FluenceGrid, FluenceSpectrum, GatherScratch, Gathered,
    GridCell, GridLayout, ImageFilter, ImageSpectrum, Kernel, LightField, MARCH_KNOTS, March, MarchCell,
    MarchKnot, MarchSample, Medium, PixelStep, Reconstruction, Segment, Vec3, gather_pair, pixel_threshold,
};
use covbeam_render::scene_file;
use covbeam_session::lamps::LampTree;
use covbeam_session::random::Random;
use covbeam_tests::kernel::plain;
use criterion::{BatchSize, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use std::path::Path;

fn direction(random: &mut Random) -> Vec3 {
    let z = 2.0 * random.uniform() - 1.0;
    let (sin, cos) = (std::f32::consts::TAU * random.uniform()).sin_cos();
    let r = (1.0 - z * z).sqrt();
    Vec3::new(r * cos, r * sin, z)
}

fn point(random: &mut Random) -> Vec3 {
    8.0 * Vec3::new(random.uniform(), random.uniform(), random.uniform()) - Vec3::splat(4.0)
}

const LAYOUT: GridLayout = GridLayout { min: Vec3::splat(-4.0), max: Vec3::splat(4.0), cells: [32, 32, 32] };

const FOG: Medium = Medium::homogeneous(0.2, 0.02);

fn cells() -> Vec<FluenceCell> {
    let mut random = Random::new([1, 1, 1, 1]);
    (0..LAYOUT.cell_count())
        .map(|_| FluenceCell {
            spectrum: FluenceSpectrum::from_array([
                random.uniform(),
                random.uniform(),
                random.uniform(),
                0.0,
                0.0,
                0.0,
            ]),
            weight: 1.0,
        })
        .collect()
}

fn operators(c: &mut Criterion) {
    let field = {
        let mut field = LightField::point(Vec3::new(0.6, 0.0, 0.8), 0.05);
        field.travel(2.0);
        field.occlude(Vec3::X, 0.1);
        field
    };
    let curvature = Curvature { tangent: Vec3::X, along: 2.0, across: 2.0, twist: 0.0 };
    let normal = Vec3::new(0.0, 0.6, -0.8);
    let mut group = c.benchmark_group("light_field");
    let mut bench = |name: &str, apply: &dyn Fn(&mut LightField)| {
        group.bench_function(name, |b| {
            b.iter(|| {
                let mut field = black_box(field);
                apply(&mut field);
                field
            });
        });
    };
    bench("travel", &|field| field.travel(black_box(1.5)));
    bench("occlude", &|field| field.occlude(Vec3::X, black_box(0.1)));
    bench("attenuate", &|field| field.attenuate(black_box(Vec3::X), &[0.1, -0.2, 0.3, 0.1, 0.0, 0.2]));
    bench("scatter", &|field| field.scatter(Vec3::Y, black_box(0.1)));
    bench("reflect", &|field| field.reflect(normal, &curvature));
    bench("refract", &|field| {
        field.refract(normal, &curvature, black_box(1.0 / 1.5));
    });
    group.bench_function("fluence", |b| b.iter(|| black_box(field).fluence()));
    group.bench_function("fluence_within", |b| b.iter(|| black_box(field).fluence_within(2.0)));
    group.bench_function("variance_along_ray", |b| b.iter(|| black_box(field).variance_along_ray(0.2)));
    group.finish();
}

fn grid(c: &mut Criterion) {
    let mut random = Random::new([2, 2, 2, 2]);
    let points: Vec<Vec3> = (0..4096).map(|_| point(&mut random)).collect();
    let cells = cells();
    let view = FluenceGrid::new(LAYOUT, &cells).unwrap();
    let mut group = c.benchmark_group("grid");
    group.throughput(Throughput::Elements(points.len() as u64));
    group.bench_function("look_up", |b| {
        b.iter(|| points.iter().filter_map(|&p| view.look_up(p)).map(|s| s.xx).sum::<f32>());
    });
    let mut sums = vec![GridCell::default(); LAYOUT.cell_count()];
    let mut accumulator = CovarianceGrid::new(LAYOUT, &mut sums).unwrap();
    let field = LightField::point(Vec3::new(0.6, 0.48, 0.64), 0.05);
    group.throughput(Throughput::Elements(1));
    group.bench_function("deposit_segment of length 6", |b| {
        b.iter(|| {
            accumulator.deposit(
                &Medium::homogeneous(0.0, 0.2),
                &Segment {
                    origin: Vec3::splat(-2.0),
                    length: 6.0,
                    power: 1.0,
                    unscattered: true,
                    field: *black_box(&field),
                    edges: &[],
                    column: Column::Uniform,
                },
            )
        });
    });
    group.finish();
}

/// Billows with features of about a metre, on 64³ voxels of the grid's box.
fn billows() -> (GridLayout, Vec<f32>) {
    let layout = GridLayout { cells: [64; 3], ..LAYOUT };
    let wave = |i: usize| (0.8 * i as f32).sin();
    let value = |i: usize| 1.0 + wave(i % 64) * wave(i / 64 % 64) * wave(i / 4096);
    (layout, (0..layout.cell_count()).map(value).collect())
}

fn densities(c: &mut Criterion) {
    let (layout, values) = billows();
    let voxels = Density::Grid(DensityGrid::new(layout, &values).unwrap());
    let air = Density::Exponential(ExponentialDensity { origin: Vec3::ZERO, up: Vec3::Y, scale_height: 2.0 });
    let mut random = Random::new([4, 4, 4, 4]);
    let rays: Vec<(Vec3, Vec3)> = (0..256).map(|_| (point(&mut random), direction(&mut random))).collect();
    let mut group = c.benchmark_group("density");
    group.throughput(Throughput::Elements(rays.len() as u64));
    let mut knots = Vec::new();
    // 5e-4 of the optical depth at an extinction of 0.22, as `BeamMap` asks for.
    let mut tabulate = |origin, direction| {
        knots.clear();
        voxels.knots(origin, direction, 4.0, 2.3e-3, f32::INFINITY, &mut |knot| knots.push(knot));
        knots.len()
    };
    let count: usize = rays.iter().map(|&(origin, direction)| tabulate(origin, direction)).sum();
    println!("{:.1} knots a ray of length 4 across 64³ voxels of 0.125", count as f64 / rays.len() as f64);
    group.bench_function("knots of a ray of length 4", |b| {
        b.iter(|| rays.iter().map(|&(origin, direction)| tabulate(origin, direction)).sum::<usize>());
    });
    group.bench_function("column over a way of length 4", |b| {
        let column = |&(origin, direction)| voxels.column_over(origin, direction, 4.0, f32::INFINITY);
        b.iter(|| rays.iter().map(column).sum::<f32>());
    });
    for (name, density) in [("exponential", air), ("voxels", voxels)] {
        let (origin, direction) = rays[0];
        let mut knots = Vec::new();
        density.knots(origin, direction, 4.0, 2.3e-3, f32::INFINITY, &mut |knot| knots.push(knot));
        let column = density.column(origin, direction, &knots);
        let distances: Vec<f32> = rays.iter().map(|ray| 0.5 * ray.0.x.abs()).collect();
        group.bench_function(BenchmarkId::new("column at a distance", name), |b| {
            b.iter(|| distances.iter().map(|&s| column.at(black_box(s))).sum::<f32>());
        });
        group.bench_function(BenchmarkId::new("density at a point", name), |b| {
            b.iter(|| rays.iter().map(|&(point, _)| density.at(black_box(point))).sum::<f32>());
        });
    }
    group.finish();
}

fn beams(count: usize) -> Vec<Beam> {
    let mut random = Random::new([3, 3, 3, 3]);
    (0..count)
        .map(|_| Beam {
            origin: point(&mut random),
            direction: direction(&mut random),
            length: 4.0 * random.uniform(),
            power: Vec3::ONE,
            ..Beam::default()
        })
        .collect()
}

/// The rays of a tile of 32 x 32 pixels, along a Z-shaped curve.
fn tile() -> Vec<EyeRay> {
    let every_second_bit = |number: u32| (0..5).map(|bit| (number >> (2 * bit) & 1) << bit).sum::<u32>();
    (0..32 * 32)
        .map(|place| {
            let [x, y] = [place, place >> 1].map(|bits| 0.002 * every_second_bit(bits) as f32);
            EyeRay {
                origin: Vec3::new(0.0, 0.0, -4.0),
                direction: Vec3::new(x, y, 1.0).normalize(),
                length: 8.0,
            }
        })
        .collect()
}

fn gather(c: &mut Criterion) {
    let cells = cells();
    let view = FluenceGrid::new(LAYOUT, &cells).unwrap();
    let mut group = c.benchmark_group("build");
    for count in [1_000, 10_000, 100_000, 1_000_000] {
        let beams = beams(count);
        group.throughput(Throughput::Elements(count as u64)).sample_size(10);
        group.bench_with_input(BenchmarkId::from_parameter(count), &beams, |b, beams| {
            b.iter_batched(
                || beams.clone(),
                |beams| BeamMap::build(beams, 0.01, &FOG),
                BatchSize::PerIteration,
            );
        });
    }
    group.finish();

    let mut group = c.benchmark_group("gather");
    let rays = tile();
    for count in [1_000, 10_000, 100_000, 1_000_000] {
        for (name, kernel) in [
            ("plain 0.05", plain(0.05)),
            ("plain 0.004", plain(0.004)),
            ("adaptive", Kernel { max_radius: 0.2, grid: Some(view), ..plain(0.004) }),
        ] {
            let map = BeamMap::build(beams(count), kernel.max_radius, &FOG);
            let mut scratch = GatherScratch::default();
            let mut gathered = vec![Gathered::default(); rays.len()];
            map.gather(&FOG, &rays, &kernel, &mut gathered, &mut scratch).unwrap();
            let pairs: u64 = gathered.iter().map(|g| u64::from(g.pairs)).sum();
            println!("{name}/{count}: {:.1} pairs a ray", pairs as f64 / rays.len() as f64);
            group.throughput(Throughput::Elements(pairs.max(1)));
            group.bench_function(BenchmarkId::new(name, count), |b| {
                b.iter(|| map.gather(&FOG, &rays, &kernel, &mut gathered, &mut scratch).unwrap());
            });
        }
    }
    let (layout, values) = billows();
    let air = ExponentialDensity { origin: Vec3::ZERO, up: Vec3::Y, scale_height: 2.0 };
    for (name, density) in [
        ("homogeneous", Density::Uniform),
        ("exponential", Density::Exponential(air)),
        ("voxels", Density::Grid(DensityGrid::new(layout, &values).unwrap())),
    ] {
        let medium = Medium { density, ..FOG };
        let map = BeamMap::build(beams(10_000), 0.05, &medium);
        println!("{name}: {:.0} bytes a beam", map.memory() as f64 / 10_000.0);
        let mut scratch = GatherScratch::default();
        let mut gathered = vec![Gathered::default(); rays.len()];
        map.gather(&medium, &rays, &plain(0.05), &mut gathered, &mut scratch).unwrap();
        let pairs: u64 = gathered.iter().map(|g| u64::from(g.pairs)).sum();
        group.throughput(Throughput::Elements(pairs));
        group.bench_function(BenchmarkId::new("medium", name), |b| {
            b.iter(|| map.gather(&medium, &rays, &plain(0.05), &mut gathered, &mut scratch).unwrap());
        });
    }
    // The homogeneous medium again, as a host's own: what the way through its callback costs.
    let map = BeamMap::build(beams(10_000), 0.05, &FOG);
    let mut scratch = GatherScratch::default();
    let mut gathered = vec![Gathered::default(); rays.len()];
    map.gather(&FOG, &rays, &plain(0.05), &mut gathered, &mut scratch).unwrap();
    let pairs: u64 = gathered.iter().map(|g| u64::from(g.pairs)).sum();
    let mut shade = |contacts: &[Contact], products: &mut [Vec3]| {
        for (contact, product) in contacts.iter().zip(products) {
            let depth = contact.ray_distance + contact.beam_distance;
            *product = FOG.scattering * FOG.phase.evaluate(contact.cos_theta) * FOG.transmittance(depth);
        }
        true
    };
    group.throughput(Throughput::Elements(pairs));
    group.bench_function(BenchmarkId::new("medium", "the host's"), |b| {
        b.iter(|| {
            map.gather_contacts(&rays, &plain(0.05), &mut gathered, &mut scratch, &mut shade, &mut || true)
        });
    });
    let beam = Beam {
        origin: Vec3::new(-1.0, 0.001, 0.0),
        direction: Vec3::X,
        length: 2.0,
        power: Vec3::ONE,
        ..Beam::default()
    };
    let radius = plain(0.05);
    group.throughput(Throughput::Elements(1));
    group.bench_function("one accepted pair", |b| {
        let mut gathered = Gathered::default();
        b.iter(|| {
            gather_pair(
                black_box(&rays[0]),
                &beam,
                [0.0, 2.0],
                &FOG,
                &[Column::Uniform; 2],
                &radius,
                &mut gathered,
            )
        });
    });
    group.finish();
}

/// A filter by its standard deviations along its axes and their angle.
fn turned(a: f32, b: f32, angle: f32) -> ImageFilter {
    let ((sin, cos), (a, b)) = (angle.sin_cos(), (a * a, b * b));
    ImageFilter {
        xx: a * cos * cos + b * sin * sin,
        xy: (a - b) * sin * cos,
        yy: a * sin * sin + b * cos * cos,
    }
}

fn film(c: &mut Criterion) {
    let cells = cells();
    let view = FluenceGrid::new(LAYOUT, &cells).unwrap();
    let (layout, values) = billows();
    let ray = EyeRay {
        origin: Vec3::new(0.3, 0.2, -4.0),
        direction: Vec3::new(0.1, 0.05, 1.0).normalize(),
        length: f32::INFINITY,
    };
    let steps = [Vec3::X, Vec3::NEG_Y].map(|step| PixelStep { origin: Vec3::ZERO, direction: 0.002 * step });
    let air = ExponentialDensity { origin: Vec3::ZERO, up: Vec3::Y, scale_height: 2.0 };
    let mut group = c.benchmark_group("film");
    // Along z, 32 voxels; a little more aslant.
    group.throughput(Throughput::Elements(33));
    for (name, density) in [
        ("homogeneous", Density::Uniform),
        ("exponential", Density::Exponential(air)),
        ("voxels", Density::Grid(DensityGrid::new(layout, &values).unwrap())),
    ] {
        let mut knots = Vec::new();
        let medium = Medium { density, ..FOG };
        medium.tabulate(ray.origin, ray.direction, ray.length, &mut |knot| knots.push(knot));
        let column = density.column(ray.origin, ray.direction, &knots);
        group.bench_function(BenchmarkId::new("spectrum", name), |b| {
            b.iter(|| ImageSpectrum::along(black_box(&ray), &steps, &view, &medium, &column));
        });
    }

    let size = 256;
    let sample = |i: u32| {
        let seen = pixel_threshold(i % size, i / size, 1, 0) < 0.25;
        let ray = FilmSample { radiance: Vec3::splat((i % 97) as f32), weight: 1.0, ..FilmSample::default() };
        if seen { ray } else { FilmSample::default() }
    };
    let samples: Vec<FilmSample> = (0..size * size).map(sample).collect();
    let regions: Vec<u32> = (0..size * size).map(|i| if i % size < 100 { 1 } else { 101 }).collect();
    let mut nodes = vec![FilmNode::default(); Reconstruction::node_count(size, size)];
    group.throughput(Throughput::Elements(u64::from(size * size)));
    group.bench_function("nodes", |b| {
        b.iter(|| Reconstruction::new(size, size, &samples, &regions, &mut nodes).is_ok());
    });
    let picture = Reconstruction::new(size, size, &samples, &regions, &mut nodes).unwrap();
    let pixels: Vec<[u32; 2]> = (0..64).map(|i| [64 + 37 * i % 128, 64 + 53 * i % 128]).collect();
    group.throughput(Throughput::Elements(pixels.len() as u64));
    for (name, filter) in [
        ("of 0.5", turned(0.5, 0.5, 0.0)),
        ("of 4", turned(4.0, 4.0, 0.0)),
        ("of 16", turned(16.0, 16.0, 0.0)),
        ("of 2 x 16", turned(2.0, 16.0, 0.6)),
    ] {
        group.bench_function(BenchmarkId::new("pixel", name), |b| {
            b.iter(|| pixels.iter().map(|[x, y]| picture.pixel(*x, *y, black_box(&filter)).x).sum::<f32>());
        });
    }
    // Silhouettes everywhere: what a filter costs that reaches over forty regions.
    let striped: Vec<u32> = (0..size * size)
        .map(|i| if i % size % 6 == 5 { 0 } else { 1 + i % size / 6 + 43 * (i / size / 100) })
        .collect();
    let mut nodes = vec![FilmNode::default(); Reconstruction::node_count(size, size)];
    let picture = Reconstruction::new(size, size, &samples, &striped, &mut nodes).unwrap();
    let filter = turned(16.0, 16.0, 0.0);
    group.bench_function("pixel among stripes, of 16", |b| {
        b.iter(|| pixels.iter().map(|[x, y]| picture.pixel(*x, *y, black_box(&filter)).x).sum::<f32>());
    });
    group.finish();
}

/// A table along an eye ray past a lamp, and its rounds with a shadow border.
fn march(c: &mut Criterion) {
    let lamp = Vec3::new(0.7, 0.0, 3.0);
    let mut knots = [MarchKnot::default(); MARCH_KNOTS];
    let mut group = c.benchmark_group("march");
    group.bench_function("knots", |b| {
        b.iter(|| MarchKnot::lay(black_box(Vec3::ZERO), Vec3::Z, 0.0, 4.0, lamp, &mut knots));
    });
    for knot in &mut knots {
        let away = knot.distance - 3.0;
        (knot.radiance, knot.deviation, knot.visibility) = (1.0 / (0.49 + away * away), 0.5, 0.5);
    }
    let mut cells = [MarchCell::default(); MARCH_KNOTS];
    group.bench_function("table", |b| {
        b.iter(|| March::new(black_box(&knots), &mut cells).map(|march| march.expected_error()));
    });
    let march = March::new(&knots, &mut cells).expect("knots as they were laid");
    let mut random = Random::new([5, 5, 5, 5]);
    let jitter: Vec<f32> = (0..20).map(|_| random.uniform()).collect();
    let (mut first, mut second) = ([MarchSample::default(); 10], [MarchSample::default(); 20]);
    group.bench_function("first round of 10", |b| {
        b.iter(|| march.place(black_box(&jitter[..10]), &mut first))
    });
    for sample in &mut first {
        sample.visibility = if sample.distance < 2.0 { 1.0 } else { 0.0 };
    }
    group.bench_function("second round of 20", |b| {
        b.iter(|| march.refine(black_box(&first), &jitter, &mut second));
    });
    group.finish();
}

/// Lamps that a place on a surface asks: all of 4; of more, 32 that a tree of four to a node is descended for.
fn lamps(c: &mut Criterion) {
    let mut group = c.benchmark_group("lamps of a place");
    for count in [4, 300, 4000] {
        let mut random = Random::new([4, 0, 0, 0]);
        let mut text = String::from(
            "[camera]\nposition = [0, 1, -9]\nlook_at = [0, 1, 0]\nvertical_fov = 40\nwidth = 8\nheight = 8\n\
             [[object]]\nshape = \"sphere\"\ncenter = [0, 0, 0]\nradius = 4\nmaterial = \"black\"\n",
        );
        for _ in 0..count {
            let Vec3 { x, y, z } = point(&mut random);
            let power = 10.0_f32.powf(2.0 * random.uniform() - 1.0);
            text +=
                &format!("[[light]]\nkind = \"point\"\nposition = [{x}, {y}, {z}]\nintensity = {power}\n");
        }
        let scene = scene_file::parse(&text, "lamps", Path::new("")).expect("a valid scene");
        let tree = LampTree::new(&scene);
        let places: Vec<(Vec3, Vec3)> =
            (0..1024).map(|_| (point(&mut random), direction(&mut random))).collect();
        let mut next = 0;
        group.bench_function(BenchmarkId::from_parameter(count), |b| {
            b.iter(|| {
                next = (next + 1) % places.len();
                let (place, normal) = places[next];
                tree.on_surface(black_box(place), normal, 0.3).len()
            })
        });
    }
    group.finish();
}

criterion_group!(benches, operators, grid, densities, gather, film, march, lamps);
criterion_main!(benches);
