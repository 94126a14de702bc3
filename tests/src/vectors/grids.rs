//! Segments with their edges, grids: deposits, look-ups, and the radii that these allow.

use super::hard::{Fog, Hard, Voxels};
use super::kernels::{SHAPES, spectrum};
use super::media::medium;
use super::words::{Script, Words, fnv};
use covbeam::{
    Column, CovarianceGrid, Edge, FluenceCell, FluenceGrid, FluenceSpectrum, GridCell, GridLayout, Kernel,
    LightField, Vec3,
};

/// A grid with what it has collected and what look-ups see.
pub(super) struct Grid {
    layout: GridLayout,
    cells: Vec<GridCell>,
    means: Vec<FluenceCell>,
}

impl Grid {
    pub(super) fn new(script: &mut Script, layout: GridLayout) -> Self {
        script.call("grid_new", &[&layout], &[]);
        let count = layout.cell_count();
        Self { layout, cells: vec![GridCell::default(); count], means: vec![FluenceCell::default(); count] }
    }

    fn collecting(&mut self) -> CovarianceGrid<'_> {
        CovarianceGrid::new(self.layout, &mut self.cells).expect("made so")
    }

    pub(super) fn fluence(&self) -> FluenceGrid<'_> {
        FluenceGrid::new(self.layout, &self.means).expect("made so")
    }

    pub(super) fn deposit(&mut self, script: &mut Script, fog: &Fog, segments: &[Segment]) {
        script.call("grid_deposit", &[fog, &Many(segments)], &[]);
        for segment in segments {
            let Segment { origin, length, ref field, .. } = *segment;
            let medium = fog.view();
            let mut knots = Vec::new();
            medium.tabulate(origin, field.direction, length, &mut |knot| knots.push(knot));
            let column = medium.density.column(origin, field.direction, &knots);
            self.collecting().deposit(&medium, &segment.with(column));
        }
    }

    fn deposit_spectrum(
        &mut self,
        script: &mut Script,
        position: Vec3,
        spectrum: FluenceSpectrum,
        weight: f32,
    ) {
        self.collecting().deposit_spectrum(position, &spectrum, weight);
        script.call("grid_deposit_spectra", &[&position, &spectrum, &weight], &[]);
    }

    pub(super) fn resolve(&mut self, script: &mut Script) {
        let grid = CovarianceGrid::new(self.layout, &mut self.cells).expect("made so");
        grid.resolve(&mut self.means).expect("as long");
        script.call("grid_resolve", &[], &[]);
    }

    pub(super) fn save(&self, script: &mut Script) {
        let mut bytes = vec![0; self.layout.saved_size()];
        self.layout.save(&self.cells, &mut bytes).expect("deposits are possible");
        script.call("grid_save", &[], &[&(bytes.len() as u64), &fnv(&bytes)]);
    }

    fn look_up(&self, script: &mut Script, positions: &[Vec3]) {
        let found: Vec<Found> = positions.iter().map(|point| Found(self.fluence().look_up(*point))).collect();
        script.call("grid_look_up", &[&Many(positions)], &[&found]);
    }
}

/// One after the other.
struct Many<'a, T>(&'a [T]);

impl<T: Words> Words for Many<'_, T> {
    fn append(&self, line: &mut String) {
        self.0.append(line);
    }
}

struct Found(Option<FluenceSpectrum>);

impl Words for Found {
    fn append(&self, line: &mut String) {
        self.0.is_some().append(line);
        self.0.unwrap_or_default().append(line);
    }
}

/// A `covbeam_segment`.
#[derive(Clone)]
pub(super) struct Segment {
    pub(super) origin: Vec3,
    pub(super) length: f32,
    pub(super) power: f32,
    pub(super) unscattered: bool,
    pub(super) field: LightField,
    pub(super) edges: Vec<Edge>,
}

impl Segment {
    fn with<'a>(&'a self, column: Column<'a>) -> covbeam::Segment<'a> {
        let Self { origin, length, power, unscattered, field, ref edges } = *self;
        covbeam::Segment { origin, length, power, unscattered, field, edges, column }
    }
}

impl Words for Segment {
    fn append(&self, line: &mut String) {
        let Self { origin, length, power, unscattered, field, edges } = self;
        let count = edges.len() as u32;
        let words: [&dyn Words; 7] = [origin, length, power, unscattered, field, &count, edges];
        words.iter().for_each(|word| word.append(line));
    }
}

/// Light from a lamp, from an edge, or scattered, somewhere in the box.
pub(super) fn segment(hard: &mut Hard, size: f64) -> Segment {
    let origin = hard.point(1.2 * size);
    let mut field = match hard.below(3) {
        0 => LightField::point(hard.unit(), hard.extreme(-2.0, 2.0)),
        1 => LightField::collimated(hard.unit(), hard.extreme(-3.0, 3.0)),
        _ => LightField::disk(hard.unit(), hard.unit(), hard.decades(-3.0, 1.0), hard.decades(-3.0, 3.0)),
    };
    field.travel(hard.decades(-2.0, 1.0));
    if hard.chance(0.5) {
        field.occlude(hard.unit(), hard.decades(-3.0, 1.0));
    }
    let unscattered = hard.chance(0.5);
    if !unscattered {
        field.scatter(hard.unit(), hard.decades(-2.0, 2.0));
    }
    let length = if hard.chance(0.2) { f32::INFINITY } else { hard.decades(-2.0, 1.0) };
    Segment { origin, length, power: hard.decades(-6.0, 3.0), unscattered, field, edges: Vec::new() }
}

/// The same past some edges: some behind it, some that it does not reach.
fn with_edges(hard: &mut Hard, count: u32) -> Segment {
    let mut edges: Vec<Edge> = (0..count)
        .map(|_| Edge {
            depth: hard.between(-0.3, 2.0),
            distance: hard.extreme(-3.0, 1.0),
            towards: hard.direction(),
        })
        .collect();
    edges.sort_by(|a, b| a.depth.total_cmp(&b.depth));
    Segment { edges, ..segment(hard, 2.0) }
}

pub(super) fn write(script: &mut Script) {
    let hard = &mut Hard::new(4);
    script.comment("Grids");
    let voxels = Voxels::new(hard, Vec3::splat(-1.5), Vec3::new(1.0, 1.5, 2.0), [5, 4, 3], 3.0);
    script.call("density_new", &[&voxels.layout, &voxels.values], &[]);
    for cells in [[1, 1, 1], [8, 8, 8], [3, 17, 1], [6, 5, 4]] {
        let (min, max) = (Vec3::new(-2.0, -1.0, -2.0), Vec3::new(2.0, 3.0, 1.0));
        let mut grid = Grid::new(script, GridLayout { min, max, cells });
        // Empty.
        grid.save(script);
        grid.resolve(script);
        look_ups(script, hard, &grid);
        let fogs = [
            Fog::homogeneous(medium(hard)),
            Fog::exponential(medium(hard), hard.point(1.0), hard.direction(), hard.decades(-0.5, 1.0)),
            Fog::voxels(medium(hard), &voxels),
        ];
        for fog in &fogs {
            for count in [1, 12] {
                let segments: Vec<Segment> = (0..count).map(|_| segment(hard, 2.0)).collect();
                grid.deposit(script, fog, &segments);
            }
            for _ in 0..3 {
                let (position, spectrum) = (hard.point(2.5), spectrum(hard));
                let weight = if hard.chance(0.2) { 0.0 } else { hard.decades(-6.0, 2.0) };
                grid.deposit_spectrum(script, position, spectrum, weight);
            }
            grid.resolve(script);
            look_ups(script, hard, &grid);
            grid.save(script);
        }
    }
    past_edges(script, &mut Hard::new(8), &voxels);
}

fn past_edges(script: &mut Script, hard: &mut Hard, voxels: &Voxels) {
    let (min, max) = (Vec3::splat(-2.0), Vec3::splat(2.0));
    let mut grid = Grid::new(script, GridLayout { min, max, cells: [7, 6, 5] });
    let fogs = [
        Fog::homogeneous(medium(hard)),
        Fog::exponential(medium(hard), hard.point(1.0), hard.direction(), hard.decades(-0.5, 1.0)),
        Fog::voxels(medium(hard), voxels),
    ];
    for fog in &fogs {
        let segments: Vec<Segment> = [1, 4, 3].map(|count| with_edges(hard, count)).to_vec();
        grid.deposit(script, fog, &segments);
        for segment in &segments {
            let distance = hard.between(0.0, 2.0);
            let field = segment.with(Column::Uniform).field_at(&fog.view(), distance);
            script.call("segment_field_at", &[segment, fog, &distance], &[&field]);
        }
    }
    grid.save(script);
}

fn look_ups(script: &mut Script, hard: &mut Hard, grid: &Grid) {
    let GridLayout { min, max, .. } = grid.layout;
    // Corners belong to the box.
    let mut positions = vec![min, max, 0.5 * (min + max), max + Vec3::X];
    positions.extend((0..8).map(|_| hard.point(2.5)));
    grid.look_up(script, &positions);
    for use_grid in [true, true, true, false] {
        let min_radius = hard.decades(-4.0, 0.0);
        let kernel = Kernel {
            shape: SHAPES[hard.below(3) as usize],
            min_radius,
            max_radius: min_radius * hard.decades(0.0, 4.0),
            error: hard.decades(-3.0, 0.0),
            grid: use_grid.then(|| grid.fluence()),
        };
        // Neighbours share the kernel, so that clients ask for both at once.
        for _ in 0..2 {
            let (position, axis) = (hard.point(2.0), hard.unit());
            let (radius, sigma) = kernel.radius_at(position, axis);
            script.call("kernel_radius_at", &[&use_grid, &kernel, &position, &axis], &[&radius, &sigma]);
        }
    }
}
