//! `tests/vectors.txt`, computed without std; its format is described in `tests/src/vectors/mod.rs`.

use crate::importance::Voxels;
use crate::operators;
use crate::words::Words;
use covbeam::{
    BLOCK, BeamBlock, Column, CovarianceGrid, Density, DensityGrid, Edge, FluenceCell, FluenceGrid,
    FluenceSpectrum, Gathered, GridCell, GridLayout, ImageSpectrum, Knot, LightField, MOST_EDGES, Medium,
    Schedule, Segment, cross, error_bound, gather_pair, path_number, pixel_threshold, progressive_radius,
};

/// The largest grids and tables of the file.
const CELLS: usize = 1000;
const VALUES: usize = 216;
const KNOTS: usize = 512;
const SAVED: usize = 64 * 1024;

/// What needs memory of its own: these lines are left out.
const LEFT_OUT: [&[u8]; 3] = [b"beam_map_", b"film_", b"march_"];

/// How far a replay came.
#[derive(Default)]
#[repr(C)]
pub struct Replay {
    /// Calls computed, with the bits of the file.
    pub replayed: u32,
    /// Calls left out.
    pub left_out: u32,
    /// The first line that could not be read or has other bits, counted from 1; 0: none.
    pub wrong: u32,
}

/// Replays a file.
pub fn replay(text: &[u8]) -> Replay {
    let (mut replay, mut now) = (Replay::default(), Now::new());
    for (number, line) in text.split(|byte| *byte == b'\n').enumerate() {
        if line.is_empty() || line.starts_with(b"#") {
            continue;
        }
        if LEFT_OUT.iter().any(|start| line.starts_with(start)) {
            replay.left_out += 1;
        } else if now.call(line).is_some() {
            replay.replayed += 1;
        } else {
            replay.wrong = number as u32 + 1;
            break;
        }
    }
    replay
}

/// The density and the grid that lines speak of.
struct Now {
    voxels: Option<GridLayout>,
    values: [f32; VALUES],
    grid: Option<GridLayout>,
    cells: [GridCell; CELLS],
    means: [FluenceCell; CELLS],
    importance: Voxels,
}

impl Now {
    fn new() -> Self {
        let (cells, means) = ([GridCell::default(); CELLS], [FluenceCell::default(); CELLS]);
        Self { voxels: None, values: [0.0; VALUES], grid: None, cells, means, importance: Voxels::new() }
    }

    fn density(&self) -> Option<DensityGrid<'_>> {
        let layout = self.voxels?;
        DensityGrid::new(layout, &self.values[..layout.cell_count()]).ok()
    }

    fn fluence(&self) -> Option<FluenceGrid<'_>> {
        let layout = self.grid?;
        FluenceGrid::new(layout, &self.means[..layout.cell_count()]).ok()
    }

    /// None: the line cannot be read, or has other bits.
    fn call(&mut self, line: &[u8]) -> Option<()> {
        let arrow = line.windows(3).position(|bytes| bytes == b" ->")?;
        let mut inputs = Words(&line[..arrow]);
        let mut outputs = Words(line[arrow + 3..].strip_prefix(b" ").unwrap_or(&[]));
        let name = inputs.text();
        let family = name.split(|byte| *byte == b'_').next()?;
        let (i, o) = (&mut inputs, &mut outputs);
        match family {
            b"light" => self.light_field(name, i, o),
            b"phase" => phase(name, i, o),
            b"spectrum" => spectrum(name, i, o),
            b"medium" => self.medium(name, i, o),
            b"density" | b"grid" => self.grid(name, i, o),
            b"image" | b"pixel" => self.image(name, i, o),
            b"importance" | b"weight" | b"emission" => {
                let density = self
                    .voxels
                    .and_then(|layout| DensityGrid::new(layout, &self.values[..layout.cell_count()]).ok());
                self.importance.call(name, density, i, o)
            }
            _ => self.pair(name, i, o),
        }?;
        (inputs.is_empty() && outputs.is_empty()).then_some(())
    }

    fn light_field(&self, name: &[u8], i: &mut Words, o: &mut Words) -> Option<()> {
        match name {
            b"light_field_point" => o.is_field(&LightField::point(i.vector()?, i.float()?)),
            b"light_field_disk" => {
                o.is_field(&LightField::disk(i.vector()?, i.vector()?, i.float()?, i.float()?))
            }
            b"light_field_collimated" => o.is_field(&LightField::collimated(i.vector()?, i.float()?)),
            b"light_field_gaussian" => {
                o.is_field(&LightField::gaussian(i.vector()?, i.vector()?, i.floats()?, i.floats()?))
            }
            b"light_field_slice" => o.are(&i.field()?.slice()),
            b"light_field_fluence" => o.are(&i.field()?.fluence_within(i.float()?).to_array()),
            b"light_field_variance_along_ray" => o.are(&[i.field()?.variance_along_ray(i.float()?)]),
            _ => self.event(name, i, o),
        }
    }

    /// What changes a light field.
    fn event(&self, name: &[u8], i: &mut Words, o: &mut Words) -> Option<()> {
        let mut field = i.field()?;
        match name {
            b"light_field_refract" => {
                let passed = field.refract(i.vector()?, &i.curvature()?, i.float()?);
                o.is(passed.into())?;
            }
            b"light_field_carry" => {
                let medium = i.medium(self.density())?;
                field.travel_through(&medium, i.vector()?, i.float()?);
            }
            _ => operators::apply(name, &mut field, i)?,
        }
        o.is_field(&field)
    }

    fn medium(&self, name: &[u8], i: &mut Words, o: &mut Words) -> Option<()> {
        let medium = i.medium(self.density())?;
        let density = &medium.density;
        match name {
            b"medium_step" => o.are(&[density.step()]),
            b"medium_opaque_column" => o.are(&[medium.opaque_column()]),
            b"medium_column_transmittance" => o.are(&medium.transmittance(i.float()?).to_array()),
            b"medium_density_at" => o.are(&[density.at(i.vector()?)]),
            b"medium_derivatives_at" => {
                let found = density.derivatives(i.vector()?);
                o.are(&found.gradient.to_array())?;
                o.are(&found.hessian)
            }
            _ => along(name, &medium, i, o),
        }
    }

    fn grid(&mut self, name: &[u8], i: &mut Words, o: &mut Words) -> Option<()> {
        match name {
            b"density_new" => {
                let layout = i.layout()?;
                self.voxels = Some(layout);
                for value in self.values.get_mut(..layout.cell_count())? {
                    *value = i.float()?;
                }
            }
            b"grid_new" => {
                self.grid = Some(i.layout()?);
                (self.cells, self.means) = ([GridCell::default(); CELLS], [FluenceCell::default(); CELLS]);
            }
            b"grid_look_up" => {
                while !i.is_empty() {
                    let found = self.fluence()?.look_up(i.vector()?);
                    o.is(found.is_some().into())?;
                    o.are(&found.unwrap_or_default().to_array())?;
                }
            }
            b"grid_save" => {
                let (layout, mut bytes) = (self.grid?, [0; SAVED]);
                let bytes = bytes.get_mut(..layout.saved_size())?;
                layout.save(&self.cells[..layout.cell_count()], bytes).ok()?;
                let hash = bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| {
                    (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3)
                });
                return (o.long()? == bytes.len() as u64 && o.long()? == hash).then_some(());
            }
            _ => self.collect(name, i)?,
        }
        Some(())
    }

    /// What goes into the grid.
    fn collect(&mut self, name: &[u8], i: &mut Words) -> Option<()> {
        let (layout, voxels) = (self.grid?, self.voxels?);
        let count = layout.cell_count();
        let density = DensityGrid::new(voxels, &self.values[..voxels.cell_count()]).ok();
        let mut grid = CovarianceGrid::new(layout, &mut self.cells[..count]).ok()?;
        match name {
            b"grid_deposit" => {
                let medium = i.medium(density)?;
                while !i.is_empty() {
                    let mut edges = [Edge::default(); MOST_EDGES];
                    let segment = i.segment(&mut edges)?;
                    let Segment { origin, length, field: LightField { direction, .. }, .. } = segment;
                    let mut table = Table::new();
                    medium.tabulate(origin, direction, length, &mut |knot| table.push(knot));
                    let column = medium.density.column(origin, direction, table.knots()?);
                    grid.deposit(&medium, &Segment { column, ..segment });
                }
            }
            b"grid_deposit_spectra" => grid.deposit_spectrum(i.vector()?, &i.spectrum()?, i.float()?),
            b"grid_resolve" => grid.resolve(&mut self.means[..count]).ok()?,
            _ => return None,
        }
        Some(())
    }

    fn image(&self, name: &[u8], i: &mut Words, o: &mut Words) -> Option<()> {
        match name {
            b"image_spectrum_along" => {
                let (medium, ray, steps) = (i.medium(self.density())?, i.ray()?, i.steps()?);
                let mut table = Table::new();
                medium.tabulate(ray.origin, ray.direction, ray.length, &mut |knot| table.push(knot));
                let column = medium.density.column(ray.origin, ray.direction, table.knots()?);
                let found = ImageSpectrum::along(&ray, &steps, &self.fluence()?, &medium, &column);
                o.are(&[found.xx, found.xy, found.yy, found.weight])
            }
            b"image_spectrum_filter" => {
                let filter = i.image_spectrum()?.filter(i.float()?, i.float()?);
                o.are(&[filter.xx, filter.xy, filter.yy])
            }
            b"image_filter_density" => o.are(&[i.image_filter()?.density()]),
            b"pixel_threshold" => {
                let [pass, seed, x, y] = [i.int()?, i.int()?, i.int()?, i.int()?];
                o.are(&[pixel_threshold(x, y, pass, seed)])
            }
            _ => None,
        }
    }

    /// Kernels, and pairs of an eye ray and a beam.
    fn pair(&self, name: &[u8], i: &mut Words, o: &mut Words) -> Option<()> {
        match name {
            b"segment_field_at" => {
                let mut edges = [Edge::default(); MOST_EDGES];
                let (segment, medium) = (i.segment(&mut edges)?, i.medium(self.density())?);
                o.is_field(&segment.field_at(&medium, i.float()?))
            }
            b"path_number" => o.are(&[path_number(i.int()?, i.int()?, i.int()?, i.int()?)]),
            b"kernel_radius_at" => {
                let grid = if i.int()? == 1 { Some(self.fluence()?) } else { None };
                let (radius, sigma) = i.kernel(grid)?.radius_at(i.vector()?, i.vector()?);
                o.are(&[radius, sigma])
            }
            b"cross" => {
                let found = cross(&i.ray()?, &i.beam()?);
                o.is(found.is_some().into())?;
                let numbers = found.map_or([0.0; 7], |c| {
                    let [x, y, z] = c.axis.to_array();
                    [c.ray_distance, c.beam_distance, c.gap, c.sin_theta, x, y, z]
                });
                o.are(&numbers)
            }
            b"gather_pair" => {
                let grid = if i.int()? == 1 { Some(self.fluence()?) } else { None };
                let (medium, kernel) = (i.medium(None)?, i.kernel(grid)?);
                let (ends, ray, beam) = (i.floats()?, i.ray()?, i.beam()?);
                let lines = [(ray.origin, ray.direction), (beam.origin, beam.direction)];
                let columns = lines.map(|(origin, direction)| medium.density.column(origin, direction, &[]));
                let mut found = Gathered::default();
                let accepted = gather_pair(&ray, &beam, ends, &medium, &columns, &kernel, &mut found);
                o.is(accepted.into())?;
                o.are(&found.radiance.to_array())?;
                o.is(found.pairs)?;
                o.are(&[found.weight, found.radius, found.sigma])
            }
            b"filter_beams" => filter_beams(i, o),
            _ => kernel(name, i, o),
        }
    }
}

fn phase(name: &[u8], i: &mut Words, o: &mut Words) -> Option<()> {
    let phase = i.phase()?;
    match name {
        b"phase_evaluate" => o.are(&[phase.evaluate(i.float()?)]),
        b"phase_sample_cosine" => o.are(&[phase.sample_cosine(i.float()?)]),
        b"phase_sample" => o.are(&phase.sample(i.vector()?, i.floats()?).to_array()),
        b"phase_angular_variance" => o.are(&[phase.angular_variance()]),
        _ => None,
    }
}

fn spectrum(name: &[u8], i: &mut Words, o: &mut Words) -> Option<()> {
    let mut spectrum: FluenceSpectrum = i.spectrum()?;
    match name {
        b"spectrum_variance_along" => o.are(&[spectrum.variance_along(i.vector()?)]),
        b"spectrum_add_along" => {
            spectrum.add_along(i.vector()?, i.float()?);
            o.are(&spectrum.to_array())
        }
        _ => None,
    }
}

fn kernel(name: &[u8], i: &mut Words, o: &mut Words) -> Option<()> {
    match name {
        b"kernel_second_moment" => o.are(&[i.shape()?.second_moment()]),
        b"kernel_evaluate" => o.are(&[i.shape()?.evaluate(i.float()?, i.float()?)]),
        b"kernel_radius_from_error" => o.are(&[i.shape()?.radius_from_error(i.float()?, i.float()?)]),
        b"progressive_radius" => o.are(&[progressive_radius(i.float()?, i.float()?, i.int()?)]),
        b"error_bound" => o.are(&[error_bound(i.float()?, i.int()?)]),
        b"schedule_kernel" => {
            let (shape, [radius, alpha, max_radius, error]) = (i.shape()?, i.floats()?);
            let kernel = Schedule { shape, radius, alpha, max_radius, error }.kernel(i.int()?, None);
            o.is(kernel.shape as u32)?;
            o.are(&[kernel.min_radius, kernel.max_radius, kernel.error])
        }
        _ => None,
    }
}

/// What a medium is along a ray.
fn along(name: &[u8], medium: &Medium, i: &mut Words, o: &mut Words) -> Option<()> {
    let (density, origin, direction) = (&medium.density, i.vector()?, i.vector()?);
    let tabulated = |length: f32| {
        let mut table = Table::new();
        medium.tabulate(origin, direction, length, &mut |knot| table.push(knot));
        table
    };
    if name == b"medium_reach" {
        let whole = tabulated(f32::INFINITY);
        let opaque = medium.opaque_column();
        return o.are(&[density.opaque_distance(origin, direction, opaque, whole.knots()?)]);
    }
    let length = i.float()?;
    let knots = |error: f32, most: f32| {
        let mut table = Table::new();
        density.knots(origin, direction, length, error, most, &mut |knot| table.push(knot));
        table
    };
    let is_grid = matches!(density, Density::Grid(_));
    let column = || {
        let exact = knots(f32::INFINITY, f32::INFINITY);
        let last = exact.knots()?.last().map_or(0.0, |knot| knot.column);
        Some(if is_grid { last } else { density.column(origin, direction, &[]).at(length) })
    };
    match name {
        b"medium_column_at" => o.are(&[column()?]),
        b"medium_transmittance" => o.are(&medium.transmittance(column()?).to_array()),
        b"medium_distance_at" => {
            let wanted = i.float()?;
            let table = knots(5e-4 * wanted, wanted);
            let line =
                if is_grid { Column::Knots(table.knots()?) } else { density.column(origin, direction, &[]) };
            let flight = line.distance_at(wanted);
            o.are(&[if flight <= length { flight } else { f32::INFINITY }])
        }
        b"medium_knots" => are_knots(&knots(i.float()?, i.float()?), o),
        b"medium_tabulate" => are_knots(&tabulated(length), o),
        _ => None,
    }
}

fn filter_beams(i: &mut Words, o: &mut Words) -> Option<()> {
    let ray = i.ray()?;
    // The radius stands behind the beams.
    let mut radius = *i;
    while radius.0.len() > 8 {
        radius.text();
    }
    let max_radius = radius.float()?;
    while i.0.len() > 8 {
        let (mut block, mut count) = (BeamBlock::EMPTY, 0);
        while count < BLOCK && i.0.len() > 8 {
            let beam = i.beam()?;
            block.set(count, &beam, 0.0, beam.length);
            count += 1;
        }
        let hit = block.test(&ray, max_radius);
        (0..count).try_for_each(|slot| o.is(hit >> slot & 1))?;
    }
    i.float().map(|_| ())
}

fn are_knots(table: &Table, o: &mut Words) -> Option<()> {
    table.knots()?.iter().try_for_each(|knot| o.are(&[knot.distance, knot.column]))
}

/// Knots of a column.
struct Table {
    knots: [Knot; KNOTS],
    count: usize,
}

impl Table {
    fn new() -> Self {
        Self { knots: [Knot::default(); KNOTS], count: 0 }
    }

    fn push(&mut self, knot: Knot) {
        if let Some(place) = self.knots.get_mut(self.count) {
            *place = knot;
        }
        self.count += 1;
    }

    /// None if there were too many.
    fn knots(&self) -> Option<&[Knot]> {
        self.knots.get(..self.count)
    }
}
