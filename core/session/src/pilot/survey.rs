//! What the camera of a scene sees of its light: a few light paths, met by a few eye rays.

use crate::eye::EyeTracer;
use crate::eye::segment::EyeSegment;
use crate::eye::starts::EyeStarts;
use crate::lamps::LampTree;
use crate::paths::{PhotonRecord, PhotonTracer, Record};
use crate::plan::radius::BeamVoxels;
use crate::random::{Emission, Random};
use crate::scene::Scene;
use crate::scene::geometry::{bounds_of_scene, divide};
use crate::scene::media;
use crate::surface::SurfaceMap;
use covbeam::{GridLayout, Medium};
use covbeam_geometry::MAX_COORDINATE;
use covbeam_geometry::shape::unite;
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

/// Share of an eye ray's light that the grid's box may leave out at each end of the ray: what is there keeps
/// narrow kernels. With a fifth of it whole pixels see nothing of the grid, and the shaft's error is 3.5
/// times as large.
const LEFT_OUT: f64 = 0.025;

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
    /// Surveys a scene, whose grid and settings are not looked at. Cost: 5 to 20 ms, 100 ms with a large mesh of glass.
    pub(crate) fn new(scene: &Scene) -> Self {
        let fogs = media::all(scene);
        let mut pieces = eye_pieces(scene, &fogs);
        let around = bounds_of_scene(scene);
        let far = far(scene, around);
        let ends = pieces.iter_mut().flat_map(|piece| {
            let fog = &fogs[piece.medium as usize];
            let ray = &mut piece.ray;
            let mut knots = Vec::new();
            let column = media::column(fog, ray.origin, ray.direction, ray.length, &mut knots);
            let opaque = column.distance_at(opaque_column(fog));
            ray.length = ray.length.min(opaque).min(far);
            [ray.origin, ray.origin + ray.length * ray.direction]
        });
        let seen = thick(ends.map(|end| (end, end)).reduce(unite).unwrap_or(around));
        let layout = GridLayout { min: seen.0, max: seen.1, cells: divide(seen.1 - seen.0, COARSE_CELLS) };
        let mut beams = BeamVoxels::new(layout);
        beams.add(&light_paths(scene).beams, &fogs);
        let light = seen_light(scene, &pieces, &fogs, &layout, &beams);
        let (space_min, space_max) = unite(seen, around);
        let space = libm::cbrt((space_max - space_min).as_dvec3().element_product()) as f32;
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
        let view = camera.side_at(depth as f32);
        let meetings = middle(light.meetings.into_iter().map(|meetings| (meetings, 1.0)));
        Self { min, max, space, view, meetings }
    }
}

/// The column behind which e^-[`OPAQUE`] of light is left, the channels' mean.
fn opaque_column(fog: &Medium) -> f32 {
    let extinction = fog.extinction();
    // Between those of the thickest channel and of the thinnest.
    let mut near = OPAQUE / extinction.max_element();
    let mut far = OPAQUE / extinction.min_element();
    if fog.mean_transmittance(far) > libm::expf(-OPAQUE) {
        return far;
    }
    for _ in 0..16 {
        let middle = (near * far).sqrt();
        *if fog.mean_transmittance(middle) > libm::expf(-OPAQUE) { &mut near } else { &mut far } = middle;
    }
    far
}

/// What light paths leave in media.
fn light_paths(scene: &Scene) -> PhotonRecord {
    let tracer = PhotonTracer::new(scene, 0, Emission::LowDiscrepancy);
    let mut record = PhotonRecord::default();
    (0..PATHS).for_each(|index| tracer.trace(0, index, PATHS, Record::Beams, &mut record));
    record
}

/// Pieces of eye paths in media whose kernels are looked up in the grid, numbered by their eye ray.
fn eye_pieces(scene: &Scene, fogs: &[Medium]) -> Vec<EyeSegment> {
    let starts = EyeStarts::new(scene);
    let surfaces = SurfaceMap::empty();
    let lamps = LampTree::new(scene);
    let tracer = EyeTracer {
        scene,
        fogs,
        starts,
        lamps: &lamps,
        surfaces: &surfaces,
        beyond: true,
        shown: None,
        is_apart: false,
    };
    let mut pieces: Vec<EyeSegment> = Vec::new();
    for node in 0..LATTICE * LATTICE {
        let at = |index: u32, count: u32| (index as f32 + 0.5) / LATTICE as f32 * count as f32;
        let camera = &scene.camera;
        let point = [at(node % LATTICE, camera.width), at(node / LATTICE, camera.height)];
        tracer.trace(&starts.at(point, [0.0; 2]), node, &mut Random::new([0, 0, node, 0]), &mut pieces);
    }
    // Where there is fog before the first surface eye rays are planned, and kernels beyond it stay narrow.
    if pieces.iter().any(EyeSegment::is_first) {
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
fn seen_light(
    scene: &Scene,
    pieces: &[EyeSegment],
    fogs: &[Medium],
    layout: &GridLayout,
    beams: &BeamVoxels,
) -> SeenLight {
    let sums = beams.sums();
    let size = layout.max - layout.min;
    let cells = Vec3::from(layout.cells.map(|n| n as f32));
    let volume = size.as_dvec3().element_product() / sums.len() as f64;
    let (mut places, mut owners, mut knots) = (Vec::new(), Vec::new(), Vec::new());
    // Of each eye ray: Σ weight, and Σ weight² as independent beams add it.
    let mut rays = vec![[0.0; 2]; (LATTICE * LATTICE) as usize];
    for piece in pieces {
        let (ray, fog) = (&piece.ray, &fogs[piece.medium as usize]);
        let column = media::column(fog, ray.origin, ray.direction, ray.length, &mut knots);
        let step = ray.length / PLACES as f32;
        for index in 0..PLACES {
            let distance = (index as f32 + 0.5) * step;
            let position = ray.origin + distance * ray.direction;
            let place = (position - layout.min) / size * cells;
            let [x, y, z] =
                place.clamp(Vec3::ZERO, cells - 1.0).to_array().map(|coordinate| coordinate as usize);
            let [fluence, square] = sums[(z * layout.cells[1] as usize + y) * layout.cells[0] as usize + x];
            let scattering = fog.scattering * fog.density.at(position);
            let seen = piece.throughput * fog.transmittance(column.at(distance)) * scattering;
            let share = f64::from(seen.element_sum());
            let weight = share * fluence / volume * f64::from(step);
            if weight > 0.0 && weight.is_finite() {
                let [sum, squares] = &mut rays[piece.pixel as usize];
                *sum += weight;
                *squares += share * share * square / volume * f64::from(step);
                let depth = (position - scene.camera.position).length().into();
                places.push(Place { position, depth, weight, is_inside: true });
                owners.push(piece.pixel as usize);
            }
        }
    }
    let mut passed = vec![0.0; rays.len()];
    for (place, owner) in places.iter_mut().zip(owners) {
        place.weight /= rays[owner][0];
        let before = passed[owner];
        passed[owner] += place.weight;
        place.is_inside = passed[owner] >= LEFT_OUT && before <= 1.0 - LEFT_OUT;
    }
    let mean = rays.iter().map(|[sum, _]| sum).sum::<f64>() / rays.len() as f64;
    let bright = rays.iter().filter(|[sum, _]| *sum > DARK * mean);
    let meetings = bright.map(|[sum, squares]| sum * sum / squares / f64::from(PATHS));
    // Where coefficients of 1e9 meet lamps of 1e9 W, squares of powers leave what f64 holds.
    let meetings = meetings.filter(|meetings| meetings.is_finite() && *meetings > 0.0).collect();
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

/// How far eye rays are followed.
fn far(scene: &Scene, (min, max): (Vec3, Vec3)) -> f32 {
    let from = scene.camera.position;
    let farthest = (from - min).abs().max((max - from).abs()).length();
    // A lamp in the camera and nothing else: the fog alone says how far.
    if farthest > 0.0 { (FAR * farthest).min(MAX_COORDINATE) } else { MAX_COORDINATE }
}

/// A box with a volume, which the format can hold: no side below a thousandth of the longest, corners within its limits.
fn thick((min, max): (Vec3, Vec3)) -> (Vec3, Vec3) {
    let middle = 0.5 * (min + max);
    let half = 0.5 * (max - min);
    // Far from the origin, f32 has no smaller steps.
    let least = (1e-3 * half.max_element()).max(1e-5 * middle.abs().max_element()).max(1.0 / MAX_COORDINATE);
    let half = half.max(Vec3::splat(least));
    let limit = Vec3::splat(MAX_COORDINATE);
    ((middle - half).max(-limit), (middle + half).min(limit))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Material;
    use crate::scene::made::{Made, camera, cuboid, point};

    /// A lamp N paths of which pass a distance d with a density of N/(4πd²): along a line at the distance h, from -L to L about the
    /// nearest point, N ∫ dt/(4π(h² + t²)) = N atan(L/h)/(2π h).
    #[test]
    fn beams_that_eye_rays_meet_are_those_of_the_closed_form() {
        let scene = Made::new(camera([0.0, 0.0, -40.0], [0.0; 3], 1.0, [8, 8]))
            .fog(1e-6, 0.0)
            .in_fog()
            .object(cuboid([-40.0, -40.0, -40.5], [40.0; 3]), Material::Black)
            .light(point([0.0, 8.0, 0.0], 1.0))
            .scene();
        let found = Survey::new(&scene).meetings.expect("light");
        let expected = 5.0_f64.atan() / (2.0 * std::f64::consts::PI * 8.0);
        // The survey's voxels are 0.3 wide: some 20 beams in a row of them, and the middle of four by four rows.
        assert!((found / expected - 1.0).abs() < 0.2, "{found} for {expected}");
    }
}
