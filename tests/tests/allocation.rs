//! The core never allocates: every function is called with the allocator counting.

use std::hint::black_box;

use allocation_counter::measure;
use covbeam::{
    Beam, BeamBlock, Column, CovarianceGrid, Curvature, Density, DensityGrid, EmissionGuide,
    ExponentialDensity, EyeRay, FILM_TILE_PIXELS, FilmEvidence, FilmFilterNode, FilmFilters, FilmLattice,
    FilmNode, FilmPixel, FilmSample, FilmSums, FilmUnit, FluenceCell, FluenceGrid, FluenceSpectrum, Gathered,
    GridCell, GridError, GridLayout, ImageFilter, ImageSpectrum, Importance, ImportanceCell, ImportanceGrid,
    ImportanceSums, Kernel, KernelShape, Knot, LightField, March, MarchCell, MarchKnot, MarchSample, Medium,
    PhaseFunction, PhaseKind, PixelStep, ProbeHit, Reconstruction, Schedule, Segment, Vec2, Vec3, cross,
    error_bound, film_regions, find_edges, gather_pair, path_number, pixel_threshold, progressive_radius,
    standard_errors, verify_filters, weight_window,
};

const LAYOUT: GridLayout = GridLayout { min: Vec3::splat(-2.0), max: Vec3::splat(2.0), cells: [8, 8, 8] };

fn allocations(run: impl FnOnce()) -> u64 {
    measure(run).count_total
}

#[test]
fn the_counter_counts() {
    assert_eq!(allocations(|| drop(black_box(Box::new(1_u8)))), 1);
    assert_eq!(allocations(|| ()), 0);
}

#[test]
fn light_fields_do_not_allocate() {
    let count = allocations(|| {
        let slope = Vec3::new(0.6, 0.0, 0.8);
        let curvature = Curvature { tangent: Vec3::X, along: 0.5, across: 0.3, twist: 0.1 };
        for mut field in [
            LightField::point(Vec3::Z, 0.1),
            LightField::disk(Vec3::Z, slope, 0.2, 0.1),
            LightField::collimated(Vec3::Z, 0.1),
            LightField::gaussian(Vec3::Z, Vec3::X, [0.1, 0.2], [0.3, 0.4]),
        ] {
            field.travel(1.0);
            field.rotate(slope);
            field.occlude(Vec3::X, 0.1);
            field.attenuate(Vec3::X, &[0.1, 0.2, 0.3, 0.1, 0.0, 0.1]);
            field.narrow(Vec3::Y, 0.2);
            black_box(field.refract(-Vec3::Z, &curvature, 1.0 / 1.5));
            field.travel(0.5);
            field.reflect(slope, &curvature);
            field.scatter(slope, 0.7);
            field.travel(0.3);
            field.diffuse(Vec3::Y, Vec3::Y);
            black_box((
                field.fluence_within(10.0),
                field.variance_along_ray(0.2),
                field.slice(),
                field.fluence().variance_along(Vec3::X),
                field.fluence().to_array(),
            ));
        }
    });
    assert_eq!(count, 0);
}

#[test]
fn the_grid_does_not_allocate() {
    let mut cells = vec![GridCell::default(); LAYOUT.cell_count()];
    let more = cells.clone();
    let mut means = vec![FluenceCell::default(); LAYOUT.cell_count()];
    let mut bytes = vec![0; LAYOUT.saved_size()];
    let mut found = None;
    let count = allocations(|| {
        let mut grid = CovarianceGrid::new(LAYOUT, &mut cells).unwrap();
        grid.deposit_spectrum(Vec3::ZERO, &FluenceSpectrum::from_array([1.0; 6]), 1.0);
        let field = LightField::point(Vec3::X, 0.1);
        let probe = |to: Vec3| {
            (to.z > 0.1).then_some(ProbeHit { distance: 1.0 / to.x, normal: Vec3::X, offset: 0.0 })
        };
        let edges = find_edges(Vec3::X, None, probe);
        black_box(path_number(1, 2, 3, edges.len() as u32));
        let mut spectrum = field.fluence();
        spectrum.add_along(Vec3::X, 0.1);
        black_box(spectrum);
        let medium = Medium::homogeneous(0.0, 0.4);
        let segment = Segment {
            origin: Vec3::new(-3.0, 0.1, 0.1),
            length: 9.0,
            power: 1.0,
            unscattered: true,
            field,
            edges: &edges,
            column: Column::Uniform,
        };
        grid.deposit(&medium, &segment);
        black_box(segment.field_at(&medium, 5.0));
        grid.merge(&more).unwrap();
        grid.resolve(&mut means).unwrap();
        LAYOUT.save(&more, &mut bytes).unwrap();
        grid.load(&bytes).unwrap();
        black_box((GridLayout::of_saved(&bytes) == Ok(LAYOUT), LAYOUT.saved_size()));
        black_box(CovarianceGrid::new(LAYOUT, &mut []).err() == Some(GridError::Length));
        let look_up = FluenceGrid::new(LAYOUT, &means).unwrap();
        found = look_up.look_up(Vec3::splat(0.1));
    });
    assert!(found.is_some());
    assert_eq!(count, 0);
}

#[test]
fn media_and_kernels_do_not_allocate() {
    let count = allocations(|| {
        for kind in [PhaseKind::Isotropic, PhaseKind::HenyeyGreenstein, PhaseKind::Rayleigh] {
            let phase = PhaseFunction { kind, asymmetry: 0.6 };
            let scattering = Vec3::new(0.1, 0.2, 0.3);
            let medium = Medium { scattering, phase, ..Medium::homogeneous(0.0, 1.0) };
            black_box((
                medium.extinction(),
                medium.mean_extinction(),
                medium.opaque_column(),
                medium.transmittance(2.0),
            ));
            black_box((phase.evaluate(0.3), phase.sample_cosine(0.7), phase.angular_variance()));
            black_box(phase.sample(Vec3::Y, Vec2::new(0.3, 0.7).to_array()));
        }
        for kernel in [KernelShape::Box, KernelShape::Epanechnikov, KernelShape::Biweight] {
            black_box((
                kernel.evaluate(0.1, 0.3),
                kernel.second_moment(),
                kernel.radius_from_error(0.01, 4.0),
            ));
        }
        black_box((progressive_radius(0.1, 0.7, 64), error_bound(0.1, 64)));
        let shape = KernelShape::Biweight;
        let schedule = Schedule { shape, radius: 0.1, alpha: 0.7, max_radius: 0.2, error: 0.1 };
        black_box(schedule.kernel(64, None));
    });
    assert_eq!(count, 0);
}

#[test]
fn densities_do_not_allocate() {
    let values = vec![1.5; LAYOUT.cell_count()];
    let mut knots = [Knot::default(); 64];
    let mut used = 0;
    let count = allocations(|| {
        let air = ExponentialDensity { origin: Vec3::ZERO, up: Vec3::Y, scale_height: 2.0 };
        let grid = DensityGrid::new(LAYOUT, &values).unwrap();
        for density in [Density::Uniform, Density::Exponential(air), Density::Grid(grid)] {
            used = 0;
            density.knots(Vec3::splat(-0.1), Vec3::X, 2.0, 1e-3, 9.0, &mut |knot| {
                knots[used] = knot;
                used += 1;
            });
            let medium = Medium { density, ..Medium::homogeneous(0.1, 0.1) };
            medium.tabulate(Vec3::ZERO, Vec3::X, 1.0, &mut |_| ());
            let column: Column = density.column(Vec3::splat(-0.1), Vec3::X, &knots[..used]);
            black_box((column.at(0.3), column.distance_at(0.2)));
            black_box(density.opaque_distance(Vec3::ZERO, Vec3::X, 9.0, &knots[..used]));
            black_box((
                density.most_knots(),
                density.at(Vec3::ZERO),
                density.derivatives(Vec3::ZERO),
                density.step(),
            ));
            LightField::point(Vec3::X, 0.1).travel_through(&medium, Vec3::ZERO, 1.0);
        }
    });
    assert!(used > 1);
    assert_eq!(count, 0);
}

#[test]
fn the_gather_does_not_allocate() {
    let field = FluenceSpectrum { xx: 1.0, yy: 1.0, zz: 1.0, ..FluenceSpectrum::default() };
    let means = vec![FluenceCell { spectrum: field, weight: 1.0 }; LAYOUT.cell_count()];
    let mut gathered = Gathered::default();
    let mut hits = 0;
    let count = allocations(|| {
        let beam = Beam {
            origin: Vec3::new(-1.0, 0.0, 0.0),
            direction: Vec3::X,
            length: 2.0,
            power: Vec3::ONE,
            start_normal: Vec3::ZERO,
            end_normal: Vec3::ZERO,
        };
        let ray = EyeRay { origin: Vec3::new(0.0, 0.01, -1.0), direction: Vec3::Z, length: f32::INFINITY };
        let medium = Medium { scattering: Vec3::splat(0.3), ..Medium::default() };
        let grid = FluenceGrid::new(LAYOUT, &means).ok();
        let kernel = Kernel { shape: KernelShape::Box, min_radius: 0.02, max_radius: 0.1, error: 0.01, grid };
        black_box((cross(&ray, &beam), kernel.radius_at(Vec3::ZERO, Vec3::X)));
        gather_pair(&ray, &beam, [0.0, beam.length], &medium, &[Column::Uniform; 2], &kernel, &mut gathered);
        let mut block = BeamBlock::EMPTY;
        block.set(0, &beam, 0.0, beam.length);
        block.clear_from(1);
        hits = block.test(&ray, kernel.max_radius);
    });
    assert_eq!((count, gathered.pairs, hits), (0, 1, 1));
}

#[test]
fn image_space_does_not_allocate() {
    let spectrum = FluenceSpectrum { xx: 1.0, yy: 2.0, zz: 3.0, ..FluenceSpectrum::default() };
    let means = vec![FluenceCell { spectrum, weight: 1.0 }; LAYOUT.cell_count()];
    let mut samples = vec![FilmSample::default(); 33 * 17];
    let (mut regions, depth) = (vec![0; 33 * 17], vec![2.0; 33 * 17]);
    let mut nodes = vec![FilmNode::default(); Reconstruction::node_count(33, 17)];
    let mut pixel = Vec3::ZERO;
    let count = allocations(|| {
        let grid = FluenceGrid::new(LAYOUT, &means).unwrap();
        let ray = EyeRay { origin: Vec3::splat(-1.0), direction: Vec3::Z, length: f32::INFINITY };
        let steps =
            [Vec3::X, Vec3::NEG_Y].map(|step| PixelStep { origin: Vec3::ZERO, direction: 0.01 * step });
        let air = ExponentialDensity { origin: Vec3::ZERO, up: Vec3::Y, scale_height: 2.0 };
        let density = Density::Exponential(air);
        let medium = Medium { density, ..Medium::homogeneous(1.0, 0.0) };
        let column = density.column(ray.origin, ray.direction, &[]);
        let found = ImageSpectrum::along(&ray, &steps, &grid, &medium, &column);
        let filter: ImageFilter = found.filter(0.04, 16.0);
        for i in 0..33 * 17 {
            if pixel_threshold(i % 33, i / 33, 1, 0) < filter.density() {
                samples[i as usize] =
                    FilmSample { radiance: Vec3::ONE, weight: 1.0, ..FilmSample::default() };
            }
        }
        film_regions(33, 17, &depth, &mut regions).unwrap();
        black_box(Reconstruction::node_count(33, 17));
        let picture = Reconstruction::new(33, 17, &samples, &regions, &mut nodes).unwrap();
        pixel = picture.pixel(20, 9, &filter) + picture.nearby(3, 4);
    });
    assert!(pixel.x > 0.0);
    assert_eq!(count, 0);
}

#[test]
fn the_film_does_not_allocate() {
    let lattice = FilmLattice::new(33, 17).unwrap();
    let count = lattice.node_count();
    let spectra = vec![ImageSpectrum { weight: 1.0, ..ImageSpectrum::default() }; count];
    let (mut filters, mut verified) = (vec![FilmFilterNode::default(); count], Vec::with_capacity(count));
    let (mut samples, regions) = (vec![FilmSample::default(); 33 * 17], vec![1; 33 * 17]);
    let mut blocks = vec![FilmNode::default(); Reconstruction::node_count(33, 17)];
    let mut evidence: Vec<FilmEvidence> = Vec::with_capacity(count);
    let (mut pixels, mut errors) = (vec![FilmPixel::default(); 33 * 17], vec![0.0; 33 * 17]);
    let count = allocations(|| {
        black_box((FilmLattice::new(5, 5).is_ok(), lattice.node_count(), lattice.pixel(3), lattice.widest()));
        black_box(lattice.least_density(9));
        let found = FilmFilters::new(lattice, &regions, &spectra, 0.1, &mut filters).unwrap();
        black_box((found.lattice(), found.filter(3, 4)));
        let unit = FilmUnit::new(1.0);
        black_box(unit.whole(1.0));
        for sample in &mut samples {
            let mut sums = FilmSums::default();
            sums.add(&unit, Vec3::ONE, true);
            sums.add(&unit, Vec3::X, false);
            *sample = sums.sample(&unit, f64::from(sums.rays()));
            black_box(sample.halves());
        }
        let picture = Reconstruction::new(33, 17, &samples, &regions, &mut blocks).unwrap();
        evidence.extend((0..lattice.node_count()).map(|node| found.evidence(node, &picture).beside(0.1)));
        verified.extend_from_slice(&filters);
        verify_filters(&lattice, &evidence, &mut verified).unwrap();
        let found = FilmFilters::of(lattice, &regions, &verified).unwrap();
        let mut tile = [FilmPixel::default(); FILM_TILE_PIXELS];
        picture.tile(8, 8, &found, &mut tile);
        pixels[..FILM_TILE_PIXELS].copy_from_slice(&tile);
        standard_errors(33, 17, &pixels, 0, &mut errors).unwrap();
    });
    assert!(pixels[0].radiance.x > 0.0);
    assert_eq!(count, 0);
}

#[test]
fn the_march_does_not_allocate() {
    let mut knots = [MarchKnot::default(); 33];
    let mut cells = [MarchCell::default(); 33];
    let (mut first, mut second) = ([MarchSample::default(); 8], [MarchSample::default(); 16]);
    let count = allocations(|| {
        MarchKnot::lay(Vec3::ZERO, Vec3::Z, 0.0, 9.0, Vec3::new(1.0, 0.0, 2.0), &mut knots).unwrap();
        for knot in &mut knots {
            (knot.radiance, knot.deviation, knot.visibility) = (1.0, 0.5, 0.5);
        }
        let march = March::new(&knots, &mut cells).unwrap();
        black_box((
            march.radiance(),
            march.expected_radiance(),
            march.expected_error(),
            march.first_round(24),
        ));
        march.place(&[0.5; 8], &mut first);
        march.refine(&first, &[0.5; 16], &mut second);
    });
    assert!(second[0].weight > 0.0);
    assert_eq!(count, 0);
}

#[test]
fn importance_does_not_allocate() {
    let mut sums = [ImportanceSums::default(); 512];
    let more = [ImportanceSums { seen: 1.0, scattered: 2.0, surface: 3.0 }; 512];
    let mut cells = [ImportanceCell::default(); 512];
    let mut numbers = [0.0; EmissionGuide::size(3)];
    let (medium, origin) = (Medium::homogeneous(0.4, 0.1), Vec3::new(-3.0, 0.2, 0.1));
    let count = allocations(|| {
        let mut grid = ImportanceGrid::new(LAYOUT, &mut sums).unwrap();
        grid.add_eye_ray(&medium, origin, Vec3::X, f32::INFINITY, 0.1);
        grid.add_path(&medium, origin, Vec3::X, 4.0, 0.1);
        grid.add_surface(Vec3::ZERO, 0.1);
        grid.merge(&more).unwrap();
        grid.resolve(&mut cells).unwrap();
        let importance = Importance::new(LAYOUT, &cells).unwrap();
        black_box((importance.at(origin), importance.of_segment(&medium, origin, Vec3::X, 4.0)));
        let mut factors = [0.2, 1.5, 0.7];
        weight_window(&mut factors, 0.5);
        black_box(factors);
        black_box(EmissionGuide::fill(3, &[1.0; 9], 0.2, &mut numbers).unwrap().warp([0.3, 0.6]));
        black_box(EmissionGuide::new(3, &numbers).unwrap().warp([0.1, 0.9]));
    });
    assert_eq!(count, 0);
}
