//! Maps against the definition of a pair, bit for bit: the walk through the tree, the packets and the eight lanes change nothing.

use covbeam::{
    Beam, BeamMap, Contact, Density, DensityGrid, ExponentialDensity, EyeRay, FluenceCell, FluenceGrid,
    FluenceSpectrum, GatherScratch, Gathered, GridLayout, Kernel, KernelShape, Knot, Medium, PhaseFunction,
    PhaseKind, Vec3, gather_pair,
};
use covbeam_tests::random::Stream;

/// What maps are built for.
const CEILING: f32 = 0.3;

const KERNELS: [KernelShape; 3] = [KernelShape::Box, KernelShape::Epanechnikov, KernelShape::Biweight];

const PHASES: [PhaseFunction; 4] = [
    PhaseFunction::ISOTROPIC,
    PhaseFunction { kind: PhaseKind::HenyeyGreenstein, asymmetry: 0.7 },
    PhaseFunction { kind: PhaseKind::HenyeyGreenstein, asymmetry: -0.3 },
    PhaseFunction { kind: PhaseKind::Rayleigh, asymmetry: 0.0 },
];

/// Grey, coloured, and with a channel of no extinction: scattering and absorption.
const COEFFICIENTS: [[Vec3; 2]; 3] = [
    [Vec3::splat(0.2), Vec3::splat(0.03)],
    [Vec3::new(0.3, 0.2, 0.1), Vec3::new(0.02, 0.0, 0.5)],
    [Vec3::new(0.3, 0.0, 0.2), Vec3::new(0.1, 0.0, 0.0)],
];

const AIR: Density<'static> =
    Density::Exponential(ExponentialDensity { origin: Vec3::ZERO, up: Vec3::Y, scale_height: 2.0 });

fn media(density: Density<'_>) -> impl Iterator<Item = Medium<'_>> {
    COEFFICIENTS.into_iter().flat_map(move |[scattering, absorption]| {
        PHASES.into_iter().map(move |phase| Medium { scattering, absorption, phase, density, more: &[] })
    })
}

fn bits(gathered: &Gathered) -> [u32; 7] {
    let Gathered { radiance, pairs, weight, radius, sigma } = *gathered;
    let [red, green, blue] = radiance.to_array().map(f32::to_bits);
    [red, green, blue, pairs, weight.to_bits(), radius.to_bits(), sigma.to_bits()]
}

fn all_bits(gathered: &[Gathered]) -> Vec<[u32; 7]> {
    gathered.iter().map(bits).collect()
}

fn vector(random: &mut Stream, low: f64, high: f64) -> Vec3 {
    Vec3::from([0; 3].map(|_| random.between(low, high) as f32))
}

/// Beams in a box of side 4; some start or end on a surface that meets them square-on or aslant.
fn beams(random: &mut Stream, count: usize) -> Vec<Beam> {
    (0..count)
        .map(|i| {
            let direction = random.direction();
            let towards = |n: Vec3, side: Vec3| if n.dot(side) < 0.0 { -n } else { n };
            let mut normal = |cut: bool, side: Vec3| {
                if cut { towards((random.direction() + 0.5 * side).normalize(), side) } else { Vec3::ZERO }
            };
            let start_normal = normal(i % 3 == 0, direction);
            let end_normal = normal(i % 4 < 2, -direction);
            Beam {
                origin: vector(random, -2.0, 2.0),
                direction,
                length: random.decades(-1.5, 0.7) as f32,
                power: vector(random, 0.0, 2.0),
                start_normal,
                end_normal,
            }
        })
        .collect()
}

/// A ray that passes a beam, or its line a little before or behind it, in up to 1.3 times the largest radius; one in two at an angle
/// of any order of magnitude down to 10^`flattest`.
fn ray_past(random: &mut Stream, beam: &Beam, flattest: f64) -> EyeRay {
    let angle = if random.uniform() < 0.5 { random.decades(flattest, 0.0) } else { random.between(0.0, 3.1) };
    let across = random.direction().cross(beam.direction).normalize();
    let (sin, cos) = (angle.sin() as f32, angle.cos() as f32);
    let direction = (cos * beam.direction + sin * across).normalize();
    let gap = 1.3 * CEILING * random.uniform() as f32 * beam.direction.cross(across);
    let point = beam.origin + random.between(-0.3, 1.3) as f32 * beam.length * beam.direction + gap;
    let distance = random.between(-0.3, 4.0) as f32;
    let length = if random.uniform() < 0.3 { f32::INFINITY } else { random.between(0.2, 6.0) as f32 };
    EyeRay { origin: point - distance * direction, direction, length }
}

fn shuffle<T>(random: &mut Stream, list: &mut [T]) {
    for i in (1..list.len()).rev() {
        list.swap(i, (random.uniform() * (i + 1) as f64) as usize);
    }
}

/// Cells whose spectra ask for radii from below the smallest to above the largest; one in four has no data.
fn cells(random: &mut Stream, layout: &GridLayout) -> Vec<FluenceCell> {
    (0..layout.cell_count())
        .map(|_| {
            let mut spectrum = FluenceSpectrum::default();
            for _ in 0..2 {
                spectrum.add_along(random.direction(), random.decades(-2.0, 1.5) as f32);
            }
            let weight = if random.uniform() < 0.25 { 0.0 } else { random.decades(-4.0, 0.0) as f32 };
            FluenceCell { spectrum, weight }
        })
        .collect()
}

/// Smaller than the box of the beams; the last two with axes of one voxel.
fn layouts() -> [GridLayout; 3] {
    [[5, 4, 3], [6, 1, 3], [1, 1, 1]].map(|cells| GridLayout {
        min: Vec3::new(-1.6, -1.5, -1.7),
        max: Vec3::new(1.5, 1.8, 1.4),
        cells,
    })
}

fn billows() -> (GridLayout, Vec<f32>) {
    let layout = GridLayout { min: Vec3::splat(-2.5), max: Vec3::splat(2.5), cells: [16; 3] };
    let wave = |i: usize| (0.8 * i as f32).sin();
    let value = |i: usize| 1.0 + wave(i % 16) * wave(i / 16 % 16) * wave(i / 256);
    (layout, (0..layout.cell_count()).map(value).collect())
}

fn plain(kernel: KernelShape) -> Kernel<'static> {
    Kernel { shape: kernel, min_radius: CEILING, max_radius: CEILING, error: 0.01, grid: None }
}

/// The plain radius, and one for each grid.
fn radii<'a>(kernel: KernelShape, grids: &'a [(GridLayout, Vec<FluenceCell>)]) -> Vec<Kernel<'a>> {
    let adaptive = |(layout, cells): &'a (GridLayout, Vec<FluenceCell>)| Kernel {
        min_radius: 0.02,
        grid: Some(FluenceGrid::new(*layout, cells).unwrap()),
        ..plain(kernel)
    };
    [plain(kernel)].into_iter().chain(grids.iter().map(adaptive)).collect()
}

fn grids(random: &mut Stream) -> Vec<(GridLayout, Vec<FluenceCell>)> {
    layouts().into_iter().map(|layout| (layout, cells(random, &layout))).collect()
}

fn knots(medium: &Medium, origin: Vec3, direction: Vec3, length: f32) -> Vec<Knot> {
    let mut knots = Vec::new();
    medium.tabulate(origin, direction, length, &mut |knot| knots.push(knot));
    knots
}

/// What one ray gathers from one beam by the definition of a pair.
fn defined(ray: &EyeRay, beam: &Beam, medium: &Medium, kernel: &Kernel, gathered: &mut Gathered) {
    let ray_knots = knots(medium, ray.origin, ray.direction, ray.length);
    let beam_knots = knots(medium, beam.origin, beam.direction, beam.length);
    let columns = [
        medium.density.column(ray.origin, ray.direction, &ray_knots),
        medium.density.column(beam.origin, beam.direction, &beam_knots),
    ];
    gather_pair(ray, beam, [0.0, beam.length], medium, &columns, kernel, gathered);
}

/// What each ray gathers in a call of its own.
fn one_by_one(map: &BeamMap, rays: &[EyeRay], medium: &Medium, kernel: &Kernel) -> Vec<Gathered> {
    let (mut gathered, mut scratch) = (vec![Gathered::default(); rays.len()], GatherScratch::default());
    for (ray, gathered) in rays.chunks(1).zip(gathered.chunks_mut(1)) {
        map.gather(medium, ray, kernel, gathered, &mut scratch).unwrap();
    }
    gathered
}

fn together(map: &BeamMap, rays: &[EyeRay], medium: &Medium, kernel: &Kernel) -> Vec<Gathered> {
    let mut gathered = vec![Gathered::default(); rays.len()];
    map.gather(medium, rays, kernel, &mut gathered, &mut GatherScratch::default()).unwrap();
    gathered
}

/// Pairs of one density, with every kernel, medium and grid: alone and 300 rays a call. Returns how many were accepted, and how many
/// of these with a radius between the smallest and the largest.
fn check_pairs(density: &Density, seed: u64, beam_count: usize) -> [u32; 2] {
    const RAYS: usize = 300;
    let random = &mut Stream::new(seed);
    let grids = grids(random);
    let [mut accepted, mut adaptive] = [0; 2];
    for (case, beam) in beams(random, beam_count).into_iter().enumerate() {
        let mut rays: Vec<EyeRay> = (0..RAYS).map(|_| ray_past(random, &beam, -5.3)).collect();
        shuffle(random, &mut rays);
        for medium in media(*density) {
            let map = BeamMap::build(vec![beam], CEILING, &medium);
            for radius in KERNELS.into_iter().flat_map(|kernel| radii(kernel, &grids)) {
                let mut wanted = vec![Gathered::default(); RAYS];
                for (ray, gathered) in rays.iter().zip(&mut wanted) {
                    defined(ray, &beam, &medium, &radius, gathered);
                }
                let alone = one_by_one(&map, &rays, &medium, &radius);
                let packets = together(&map, &rays, &medium, &radius);
                for (ray, (wanted, (alone, packets))) in
                    rays.iter().zip(wanted.iter().zip(alone.iter().zip(&packets)))
                {
                    let about = || {
                        let crossing = covbeam::cross(ray, &beam);
                        format!("beam {case} {beam:?}\n{ray:?}\n{crossing:?}\n{medium:?} {:?}", radius.shape)
                    };
                    assert_eq!(bits(alone), bits(wanted), "alone: {alone:?} for {wanted:?}\n{}", about());
                    assert_eq!(
                        bits(packets),
                        bits(wanted),
                        "packet: {packets:?} for {wanted:?}\n{}",
                        about()
                    );
                    // One along the other counts as several.
                    accepted += u32::from(wanted.pairs > 0);
                    let between =
                        wanted.radius > 0.021 * wanted.weight && wanted.radius < 0.29 * wanted.weight;
                    adaptive += u32::from(between);
                }
            }
        }
    }
    [accepted, adaptive]
}

/// Neither nearly all nor next to none are accepted.
fn assert_telling([accepted, adaptive]: [u32; 2], beams: usize) {
    let pairs = (beams * 300 * 12 * 12) as u32;
    println!("{pairs} pairs, {accepted} accepted, {adaptive} with a radius that the grid decided");
    assert!(accepted > pairs / 20 && accepted < pairs / 2 && adaptive > pairs / 200);
}

#[test]
fn a_map_of_one_beam_gathers_the_bits_of_the_pair() {
    assert_telling(check_pairs(&Density::Uniform, 11, 24), 24);
}

#[test]
fn a_map_of_one_beam_in_an_exponential_density_gathers_the_bits_of_the_pair() {
    assert_telling(check_pairs(&AIR, 12, 12), 12);
}

#[test]
fn a_map_of_one_beam_in_voxels_gathers_the_bits_of_the_pair() {
    let (layout, values) = billows();
    let density = Density::Grid(DensityGrid::new(layout, &values).unwrap());
    assert_telling(check_pairs(&density, 13, 9), 9);
}

/// A tile of rays from one eye, in no order.
fn tile(random: &mut Stream, count: usize, width: f64) -> Vec<EyeRay> {
    (0..count)
        .map(|i| EyeRay {
            origin: Vec3::new(0.3, -0.2, -4.0),
            direction: (Vec3::Z + vector(random, -width, width)).normalize(),
            length: if i % 7 == 0 { f32::INFINITY } else { random.between(1.0, 9.0) as f32 },
        })
        .collect()
}

#[test]
fn rays_gather_the_same_bits_alone_and_in_packets_of_any_order() {
    let random = &mut Stream::new(14);
    let grids = grids(random);
    let beams = beams(random, 3000);
    let mut pairs = 0;
    let (layout, values) = billows();
    let voxels = Density::Grid(DensityGrid::new(layout, &values).unwrap());
    for density in [Density::Uniform, AIR, voxels] {
        for (medium, kernel) in media(density).step_by(5).zip(KERNELS) {
            let map = BeamMap::build(beams.clone(), CEILING, &medium);
            for (radius, width) in radii(kernel, &grids).iter().zip([0.01, 0.05, 0.3, 1.0]) {
                let rays = tile(random, 300, width);
                let alone = one_by_one(&map, &rays, &medium, radius);
                pairs += alone.iter().map(|g| g.pairs).sum::<u32>();
                assert_eq!(all_bits(&together(&map, &rays, &medium, radius)), all_bits(&alone));
                let mut order: Vec<usize> = (0..rays.len()).collect();
                shuffle(random, &mut order);
                let shuffled: Vec<EyeRay> = order.iter().map(|&i| rays[i]).collect();
                let wanted: Vec<[u32; 7]> = order.iter().map(|&i| bits(&alone[i])).collect();
                assert_eq!(all_bits(&together(&map, &shuffled, &medium, radius)), wanted);
            }
        }
    }
    println!("{pairs} pairs");
    assert!(pairs > 20_000);
}

#[test]
fn a_ray_that_meets_its_first_beam_long_after_its_neighbour_has_its_own_column() {
    let (layout, values) = billows();
    let density = Density::Grid(DensityGrid::new(layout, &values).unwrap());
    let medium = media(density).next().unwrap();
    let kernel = Kernel { min_radius: 0.05, max_radius: 0.05, ..plain(KernelShape::Epanechnikov) };
    let ray = |z: f32| EyeRay { origin: Vec3::new(-3.0, 0.0, z), direction: Vec3::X, length: f32::INFINITY };
    let random = &mut Stream::new(15);
    let beam = |x: f64, z: f64| Beam {
        origin: Vec3::new(x as f32, -0.1, z as f32),
        direction: Vec3::Y,
        length: 0.2,
        power: Vec3::ONE,
        ..Beam::default()
    };
    // Most lie low, where the tree begins, around the neighbour's ray. Some lie high, and meet no ray: a piece of its own would be met
    // at once, at the top of the tree.
    let mut beams: Vec<Beam> =
        (0..25_000).map(|_| beam(random.between(-2.0, 2.0), -1.0 + random.between(-0.04, 0.04))).collect();
    beams.extend((0..1000).map(|_| beam(random.between(-2.0, 2.0), random.between(1.1, 1.3))));
    let lonely = beam(0.5, 1.01);
    beams.push(lonely);
    for neighbours in [1, 7, 63] {
        let rays: Vec<EyeRay> = [ray(1.0)].into_iter().chain((0..neighbours).map(|_| ray(-1.0))).collect();
        let map = BeamMap::build(beams.clone(), 0.05, &medium);

        // The rays are given their contacts in order, batch by batch: the first ray gets its only one after others have had many.
        let (mut before, mut met) = (0, 0);
        let mut shade = |contacts: &[Contact], _: &mut [Vec3]| {
            for contact in contacts {
                met += u32::from(contact.ray == 0);
                before += u32::from(met == 0);
            }
            true
        };
        let (mut sums, scratch) = (vec![Gathered::default(); rays.len()], &mut GatherScratch::default());
        assert_eq!(map.gather_contacts(&rays, &kernel, &mut sums, scratch, &mut shade, &mut || true), Ok(()));
        assert!(met == 1 && before > 5000, "{met} contacts of the first ray, {before} of others before");

        let found = together(&map, &rays, &medium, &kernel);
        let mut wanted = Gathered::default();
        defined(&rays[0], &lonely, &medium, &kernel, &mut wanted);
        assert_eq!(bits(&found[0]), bits(&wanted), "{:?} for {wanted:?}", found[0]);
        assert_eq!(all_bits(&found), all_bits(&one_by_one(&map, &rays, &medium, &kernel)));
        assert_eq!(found[1].pairs, 25_000);
    }
}
