//! What a scene file need not say: box and cells of the covariance grid, radii of kernels, light paths a pass.
//!
//! All of it follows from a survey: a few light paths, of fixed number and seed, met by a few eye rays. It is a function of the scene alone,
//! never of a clock or of the machine's threads, so that a scene without numbers gives the same picture everywhere. Scaled with the scene's
//! unit of length (and the media's coefficients with its inverse), all lengths scale alike and the counts stay.

use crate::eye::{EyeSegment, EyeTracer};
use crate::fog::Fog;
use crate::mesh::MAX_COORDINATE;
use crate::optics::Interior;
use crate::photon::{PhotonRecord, PhotonTracer, Record};
use crate::radius::BeamVoxels;
use crate::random::{Emission, Random};
use crate::scene::{Scene, Settings};
use crate::surface::SurfaceMap;
use covbeam::{GridLayout, Kernel};
use glam::Vec3;

/// Light paths of the survey. Their beams need only say where there is light, not how much to a digit.
const PATHS: u32 = 2048;

/// Eye rays of the survey across and down, whatever the picture's resolution: no default depends on it but that of [`photons`].
const LATTICE: u32 = 24;

/// Places on each piece of an eye path.
const PLACES: u32 = 64;

/// Voxels of the survey's own grid: a path in two or three leaves a beam in each.
const COARSE_CELLS: u32 = 16 * 16 * 16;

/// Optical depth that the survey looks through: 2 % are left of light that comes from there.
const OPAQUE: f32 = 4.0;

/// Eye rays that meet nothing are followed this many times as far as the farthest lamp or object: light falls as 1/d².
const FAR: f32 = 4.0;

/// Eye rays darker than this share of the mean say nothing about how many beams a pixel sees.
const DARK: f64 = 0.05;

/// Share of an eye ray's light that the grid's box may leave out at each end of the ray: what is there keeps narrow kernels.
const LEFT_OUT: f64 = 0.025;

/// Voxels of the grid: 9 MB.
const CELLS: u32 = 48 * 48 * 48;

/// Radius of the first kernels, in sides of a cube as large as the space that the scene takes.
const RADIUS_IN_SPACE: f32 = 1.0 / 160.0;

/// Bounds on it, in sides of the picture where the light is.
const RADIUS_IN_PICTURE: [f32; 2] = [1.0 / 80.0, 1.0 / 45.0];

/// Beams that kernels of the first radius meet along the middle one of the eye rays, in a pass.
const MEETINGS: f64 = 64.0;

/// Light paths a pass where the camera sees no light in a medium.
const PATHS_OF_SURFACES: f64 = 5000.0;

/// Bounds on light paths a pass: of fewer the fields are too few to fill a grid; more take seconds.
const FEWEST: f64 = 1000.0;
const MOST: f64 = 200_000.0;

/// Pixels from which on a pass gets more light paths: below, it is the photons that it spends its time on.
const LARGE: f64 = 256.0 * 256.0;

/// Where the camera sees light in media, and how many beams.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Survey {
    /// Lower corner of the box that holds that light.
    pub(crate) min: Vec3,
    /// Upper corner.
    pub(crate) max: Vec3,
    /// Side of a cube as large as the space of objects, lamps and eye rays.
    pub(crate) space: f32,
    /// Side of a square as large as the picture, where the middle of the light is.
    pub(crate) view: f32,
    /// Beams of a single light path that a strip along an eye ray meets, over the strip's width \[1/m\], in the middle one of the eye rays;
    /// None = no light.
    pub(crate) meetings: Option<f64>,
}

impl Survey {
    /// Surveys a scene, whose grid and settings are not looked at. Cost: some 50 ms.
    pub(crate) fn new(scene: &Scene) -> Self {
        let fogs = Fog::all(scene);
        let mut pieces = eye_pieces(scene, &fogs);
        let around = bounds_of_scene(scene);
        let far = FAR * farthest(scene, around);
        let ends = pieces.iter_mut().flat_map(|piece| {
            let fog = &fogs[piece.medium as usize];
            let ray = &mut piece.ray;
            let mut knots = Vec::new();
            let column = fog.column(ray.origin, ray.direction, ray.length, &mut knots);
            let opaque = column.distance_at(OPAQUE / fog.mean_extinction());
            ray.length = ray.length.min(opaque).min(far);
            [ray.origin, ray.origin + ray.length * ray.direction]
        });
        let seen = thick(ends.map(|end| (end, end)).reduce(unite).unwrap_or(around));
        let layout = GridLayout { min: seen.0, max: seen.1, cells: divide(seen.1 - seen.0, COARSE_CELLS) };
        let mut beams = BeamVoxels::new(layout);
        beams.add(&light_paths(scene).beams, &fogs);
        let light = seen_light(&pieces, &fogs, &layout, &beams);
        let (space_min, space_max) = unite(seen, around);
        let space = (space_max - space_min).as_dvec3().element_product().cbrt() as f32;
        let lit = light
            .places
            .iter()
            .filter(|place| place.is_inside)
            .map(|place| (place.position, place.position))
            .reduce(unite);
        let (min, max) = lit.map_or(seen, |lit| half_a_voxel_more(lit, &layout));
        let camera = &scene.camera;
        // Without light in a medium there are surfaces alone, whose photons have radii too.
        let depth = middle(light.places.iter().map(|place| (place.depth, place.weight)))
            .unwrap_or_else(|| (0.5 * (min + max) - camera.position).length().into());
        let aspect = camera.width as f32 / camera.height as f32;
        let view = 2.0 * camera.tan_half_height * aspect.sqrt() * depth as f32;
        let meetings = middle(light.meetings.into_iter().map(|meetings| (meetings, 1.0)));
        Self { min, max, space, view, meetings }
    }
}

/// What light paths leave in media.
fn light_paths(scene: &Scene) -> PhotonRecord {
    let tracer = PhotonTracer::new(scene, 0, Emission::LowDiscrepancy);
    let mut record = PhotonRecord::default();
    (0..PATHS).for_each(|index| tracer.trace(0, index, PATHS, Record::Beams, &mut record));
    record
}

/// Pieces of eye paths in media whose kernels are looked up in the grid, numbered by their eye ray.
fn eye_pieces(scene: &Scene, fogs: &[Fog]) -> Vec<EyeSegment> {
    let interior = Interior::at(scene, scene.camera.position);
    let surfaces = SurfaceMap::build(Vec::new(), 1.0, 1.0);
    let tracer = EyeTracer { scene, fogs, interior, surfaces: &surfaces };
    let mut pieces: Vec<EyeSegment> = Vec::new();
    for node in 0..LATTICE * LATTICE {
        let at = |index: u32, count: u32| (index as f32 + 0.5) / LATTICE as f32 * count as f32;
        let camera = &scene.camera;
        let direction = camera.direction(at(node % LATTICE, camera.width), at(node / LATTICE, camera.height));
        tracer.trace(direction, node, &mut Random::new([0, 0, node, 0]), &mut pieces);
    }
    // A camera in a medium plans eye rays, and kernels beyond the first surface stay narrow.
    if interior.medium(scene).is_some() {
        pieces.retain(EyeSegment::is_first);
    }
    pieces
}

/// Light seen at a place.
struct Place {
    position: Vec3,
    /// Distance from the camera.
    depth: f64,
    /// An eye ray's sum to 1: pixels count by relative error.
    weight: f64,
    /// Whether it is not among the first or last [`LEFT_OUT`] of its eye ray.
    is_inside: bool,
}

/// Light that eye rays see.
struct SeenLight {
    places: Vec<Place>,
    /// [`Survey::meetings`] of each ray that is not dark.
    meetings: Vec<f64>,
}

/// The light that pieces of eye paths see in a box, from the beams in its voxels.
fn seen_light(pieces: &[EyeSegment], fogs: &[Fog], layout: &GridLayout, beams: &BeamVoxels) -> SeenLight {
    let sums = beams.sums();
    let size = layout.max - layout.min;
    let cells = Vec3::from(layout.cells.map(|n| n as f32));
    let volume = size.as_dvec3().element_product() / sums.len() as f64;
    let (mut places, mut owners, mut knots) = (Vec::new(), Vec::new(), Vec::new());
    // Of each eye ray: Σ weight, and Σ weight² as independent beams add it.
    let mut rays = vec![[0.0; 2]; (LATTICE * LATTICE) as usize];
    for piece in pieces {
        let (ray, fog) = (&piece.ray, &fogs[piece.medium as usize]);
        let column = fog.column(ray.origin, ray.direction, ray.length, &mut knots);
        let step = ray.length / PLACES as f32;
        for index in 0..PLACES {
            let distance = (index as f32 + 0.5) * step;
            let position = ray.origin + distance * ray.direction;
            let place = (position - layout.min) / size * cells;
            let [x, y, z] =
                place.clamp(Vec3::ZERO, cells - 1.0).to_array().map(|coordinate| coordinate as usize);
            let [fluence, square] = sums[(z * layout.cells[1] as usize + y) * layout.cells[0] as usize + x];
            let left = (-fog.mean_extinction() * column.at(distance)).exp();
            let scattering = fog.medium.scattering.element_sum() * fog.density.at(position);
            let share = f64::from(piece.throughput.element_sum() * left * scattering);
            let weight = share * fluence / volume * f64::from(step);
            if weight > 0.0 && weight.is_finite() {
                let [sum, squares] = &mut rays[piece.pixel as usize];
                *sum += weight;
                *squares += share * share * square / volume * f64::from(step);
                places.push(Place { position, depth: 0.0, weight, is_inside: true });
                owners.push(piece.pixel as usize);
            }
        }
    }
    let camera = pieces.first().map_or(Vec3::ZERO, |piece| piece.ray.origin);
    let mut passed = vec![0.0; rays.len()];
    for (place, owner) in places.iter_mut().zip(owners) {
        place.depth = (place.position - camera).length().into();
        place.weight /= rays[owner][0];
        let before = passed[owner];
        passed[owner] += place.weight;
        place.is_inside = passed[owner] >= LEFT_OUT && before <= 1.0 - LEFT_OUT;
    }
    let mean = rays.iter().map(|[sum, _]| sum).sum::<f64>() / rays.len() as f64;
    let bright = rays.iter().filter(|[sum, _]| *sum > DARK * mean);
    let meetings = bright.map(|[sum, squares]| sum * sum / squares / f64::from(PATHS)).collect();
    SeenLight { places, meetings }
}

/// A box of places that stand for voxels, with the rest of these.
fn half_a_voxel_more((min, max): (Vec3, Vec3), layout: &GridLayout) -> (Vec3, Vec3) {
    let half = 0.5 * (layout.max - layout.min) / Vec3::from(layout.cells.map(|n| n as f32));
    ((min - half).max(layout.min), (max + half).min(layout.max))
}

/// The value below which half of the weights are; None = no values.
fn middle(values: impl Iterator<Item = (f64, f64)>) -> Option<f64> {
    let mut values: Vec<(f64, f64)> = values.collect();
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let total: f64 = values.iter().map(|(_, weight)| weight).sum();
    let mut sum = 0.0;
    let found = values.iter().find(|(_, weight)| {
        sum += weight;
        sum >= 0.5 * total
    });
    found.map(|(value, _)| *value)
}

fn unite((a, b): (Vec3, Vec3), (c, d): (Vec3, Vec3)) -> (Vec3, Vec3) {
    (a.min(c), b.max(d))
}

/// Of all objects and lamps.
fn bounds_of_scene(scene: &Scene) -> (Vec3, Vec3) {
    let objects = scene.objects.iter().map(|object| object.shape.bounds());
    let lamps = scene.lights.iter().map(|light| (light.position(), light.position()));
    objects.chain(lamps).reduce(unite).expect("a scene has a light")
}

/// Distance from the camera to the farthest corner of the scene.
fn farthest(scene: &Scene, (min, max): (Vec3, Vec3)) -> f32 {
    let from = scene.camera.position;
    (from - min).abs().max((max - from).abs()).length()
}

/// A box with a volume, which the format can hold: no side below a thousandth of the longest, corners within its limits.
fn thick((min, max): (Vec3, Vec3)) -> (Vec3, Vec3) {
    let middle = 0.5 * (min + max);
    let half = 0.5 * (max - min);
    // Far from the origin, f32 has no smaller steps.
    let least = (1e-3 * half.max_element()).max(1e-5 * middle.abs().max_element()).max(1e-6);
    let half = half.max(Vec3::splat(least));
    let limit = Vec3::splat(MAX_COORDINATE);
    ((middle - half).max(-limit), (middle + half).min(limit))
}

/// Numbers of about cubic cells in a box of this size, about `budget` together: the spectra of light know no axes.
fn divide(size: Vec3, budget: u32) -> [u32; 3] {
    let size = size.as_dvec3();
    let side = (size.element_product() / f64::from(budget)).cbrt();
    // A flat box has few cells across, but at least one.
    size.to_array().map(|length| ((length / side).round() as u32).clamp(1, budget))
}

/// Cells of the grid in a box.
pub(crate) fn cells(min: Vec3, max: Vec3) -> [u32; 3] {
    divide(max - min, CELLS)
}

/// Radius of the first pass' kernels. The larger the space that the light fills, the wider the gaps between its beams; but a kernel is never
/// small or large in the picture.
pub(crate) fn radius(survey: &Survey) -> f32 {
    let [least, most] = RADIUS_IN_PICTURE.map(|share| share * survey.view);
    (RADIUS_IN_SPACE * survey.space).clamp(least, most).clamp(1.0 / MAX_COORDINATE, MAX_COORDINATE)
}

/// Largest radius: the shortest side of a voxel. A wider kernel reaches past the voxels around it, whose dimmest bounds it.
pub(crate) fn max_radius(grid: &GridLayout, radius: f32) -> f32 {
    let cells = Vec3::from(grid.cells.map(|n| n as f32));
    ((grid.max - grid.min) / cells).min_element().max(radius)
}

/// Light paths a pass: as many as let a pixel meet [`MEETINGS`] beams, so that the eye rays of a pass cost as much in any scene; more in
/// large pictures, whose passes have much to do that no photon costs: in proportion to the root of their pixels, which shares the growth
/// between photons and pixels.
pub(crate) fn photons(scene: &Scene, survey: &Survey, radius: f32) -> u32 {
    let for_meetings = |meetings| MEETINGS / (2.0 * f64::from(radius) * meetings);
    let paths = survey.meetings.map_or(PATHS_OF_SURFACES, for_meetings).clamp(FEWEST, MOST);
    let pixels = f64::from(scene.camera.width) * f64::from(scene.camera.height);
    two_digits(paths * (pixels / LARGE).sqrt().max(1.0))
}

/// Rounded to two digits: the last ones of the survey are not the same on every processor.
fn two_digits(number: f64) -> u32 {
    let step = 10f64.powf((number.log10() - 1.0).floor());
    ((number / step).round() * step).round() as u32
}

/// Settings that depend on nothing.
pub(crate) fn settings() -> Settings {
    Settings {
        passes: 64,
        photons: 5000,
        seed: 1,
        radius: 1.0,
        alpha: 0.5,
        error: 0.01,
        max_radius: 1.0,
        light_field_share: 0.1,
        kernel: Kernel::Epanechnikov,
    }
}
