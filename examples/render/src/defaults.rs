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

/// Voxels of the grid. Few and wide: beside a shadow the dimmest voxel around bounds what a kernel may leak, and it must be seen from afar.
const CELLS: u32 = 24 * 24 * 24;

/// Largest radius of kernels, in shortest sides of a voxel: a kernel as wide as a voxel leaks past what its voxels know.
const MOST_IN_VOXEL: f32 = 0.5;

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
    /// Surveys a scene, whose grid and settings are not looked at. Cost: 5 to 20 ms, 100 ms with a large mesh of glass.
    pub(crate) fn new(scene: &Scene) -> Self {
        let fogs = Fog::all(scene);
        let mut pieces = eye_pieces(scene, &fogs);
        let around = bounds_of_scene(scene);
        let far = far(scene, around);
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
        let light = seen_light(scene, &pieces, &fogs, &layout, &beams);
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
fn seen_light(
    scene: &Scene,
    pieces: &[EyeSegment],
    fogs: &[Fog],
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

fn unite((a, b): (Vec3, Vec3), (c, d): (Vec3, Vec3)) -> (Vec3, Vec3) {
    (a.min(c), b.max(d))
}

/// Of all objects and lamps.
fn bounds_of_scene(scene: &Scene) -> (Vec3, Vec3) {
    let objects = scene.objects.iter().map(|object| object.shape.bounds());
    let lamps = scene.lights.iter().map(|light| (light.position(), light.position()));
    objects.chain(lamps).reduce(unite).expect("a scene has a light")
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

/// Numbers of about cubic cells in a box of this size, at most about `budget` together: the spectra of light know no axes.
fn divide(size: Vec3, budget: u32) -> [u32; 3] {
    let size = size.as_dvec3();
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| size[a].total_cmp(&size[b]));
    let mut cells = [1; 3];
    let mut left = f64::from(budget);
    for (place, &axis) in order.iter().enumerate() {
        // A side shorter than a cell has one, and leaves its share to the others.
        let volume: f64 = order[place..].iter().map(|&axis| size[axis]).product();
        let side = (volume / left).powf(1.0 / (3 - place) as f64);
        let count = (size[axis] / side).round().max(1.0);
        cells[axis] = count as u32;
        left /= count;
    }
    cells
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

/// Largest radius, which follows from the voxels: [`MOST_IN_VOXEL`] of them.
pub(crate) fn max_radius(grid: &GridLayout, radius: f32) -> f32 {
    let cells = Vec3::from(grid.cells.map(|n| n as f32));
    (MOST_IN_VOXEL * ((grid.max - grid.min) / cells).min_element()).max(radius)
}

/// Light paths a pass: as many as let a pixel meet [`MEETINGS`] beams, so that the eye rays of a pass cost as much in any scene; more in
/// large pictures, whose passes have much to do that no photon costs: in proportion to the root of their pixels, which shares the growth
/// between photons and pixels.
pub(crate) fn photons(scene: &Scene, survey: &Survey, radius: f32) -> u32 {
    let for_meetings = |meetings| MEETINGS / (2.0 * f64::from(radius) * meetings);
    let paths = survey.meetings.map_or(PATHS_OF_SURFACES, for_meetings);
    let pixels = f64::from(scene.camera.width) * f64::from(scene.camera.height);
    two_digits((paths * (pixels / LARGE).sqrt().max(1.0)).clamp(FEWEST, MOST))
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn scene(text: &str) -> Scene {
        Scene::parse(text, "test scene", Path::new("")).unwrap_or_else(|error| panic!("{error}"))
    }

    /// Fog with a spot, and with a ball before a wall; lengths in `scale`, all of it moved by `shift`.
    fn fog(scale: f32, shift: Vec3, objects: bool) -> Scene {
        let place = |x: f32, y: f32, z: f32| {
            let [x, y, z] = (scale * Vec3::new(x, y, z) + shift).to_array().map(f64::from);
            format!("[{x:.9}, {y:.9}, {z:.9}]")
        };
        let per_length = |coefficient: f64| format!("{:.12}", coefficient / f64::from(scale));
        let objects = if objects {
            format!(
                "[[object]]\nshape = \"sphere\"\ncenter = {}\nradius = {:.9}\nmaterial = \"black\"\n\
                 [[object]]\nshape = \"box\"\nmin = {}\nmax = {}\nmaterial = {{ lambert = {{ albedo = 0.5 }} }}\n",
                place(0.0, 0.0, 0.5),
                f64::from(0.5 * scale),
                place(-8.0, -8.0, 4.0),
                place(8.0, 8.0, 5.0)
            )
        } else {
            String::new()
        };
        scene(&format!(
            "outside_medium = \"fog\"\n\
             [camera]\nposition = {}\nlook_at = {}\nvertical_fov = 40\nwidth = 64\nheight = 48\n\
             [[medium]]\nname = \"fog\"\nscattering = {}\nabsorption = {}\n{objects}\
             [[light]]\nkind = \"spot\"\nposition = {}\nlook_at = {}\nintensity = 10\n\
             inner_angle = 15\nouter_angle = 20\n",
            place(0.0, 0.0, -5.0),
            place(0.0, 0.0, 0.0),
            per_length(0.25),
            per_length(0.0625),
            place(1.0, 2.0, 0.0),
            place(0.0, 0.0, 0.5),
        ))
    }

    #[test]
    fn lengths_scale_with_the_scene_and_counts_stay() {
        let unit = fog(1.0, Vec3::ZERO, true);
        // Powers of two scale every number without rounding.
        for scale in [1.0 / 128.0, 512.0] {
            let scaled = fog(scale, Vec3::ZERO, true);
            assert_eq!((scaled.grid.min, scaled.grid.max), (scale * unit.grid.min, scale * unit.grid.max));
            assert_eq!(scaled.grid.cells, unit.grid.cells);
            let Settings { radius, max_radius, .. } = unit.settings;
            let expected =
                Settings { radius: scale * radius, max_radius: scale * max_radius, ..unit.settings };
            assert_eq!(scaled.settings, expected);
        }
    }

    #[test]
    fn the_box_moves_with_the_scene() {
        let still = fog(1.0, Vec3::ZERO, true);
        let shift = Vec3::new(30.0, -20.0, 10.0);
        let moved = fog(1.0, shift, true);
        // A path whose roundings differ may leave its beam in the next voxel of the survey: a 16th of the box' mean side.
        let side = (still.grid.max - still.grid.min).element_product().cbrt();
        let ends = [(moved.grid.min, still.grid.min + shift), (moved.grid.max, still.grid.max + shift)];
        for (end, expected) in ends {
            assert!((end - expected).abs().max_element() < side / 15.0, "{end} for {expected}");
        }
        // Of 2048 paths and 576 eye rays few differ; photons are given to two digits.
        let ratio = |of: fn(&Settings) -> f64| of(&moved.settings) / of(&still.settings);
        assert!((ratio(|settings| settings.radius.into()) - 1.0).abs() < 0.01);
        assert!((ratio(|settings| settings.photons.into()) - 1.0).abs() < 0.05);
    }

    #[test]
    fn the_box_ends_at_the_wall_and_holds_the_lit_fog_before_it() {
        let GridLayout { min, max, .. } = fog(1.0, Vec3::ZERO, true).grid;
        // The wall is at z = 4, and the picture there 2 · 9 tan 20° = 6.55 high and 8.74 wide.
        assert!(max.z <= 4.001 && max.x - min.x <= 8.74 && max.y - min.y <= 6.56, "{min} {max}");
        // The cone runs from (1, 2, 0) to the ball.
        assert!(min.cmple(Vec3::new(-0.5, -0.5, -1.0)).all(), "{min}");
        assert!(max.cmpge(Vec3::new(0.5, 0.5, 0.5)).all(), "{max}");
    }

    #[test]
    fn fog_without_end_and_without_objects_has_a_box_around_the_light_in_it() {
        let GridLayout { min, max, .. } = fog(1.0, Vec3::ZERO, false).grid;
        assert!(
            min.cmple(Vec3::new(-0.4, -0.8, -0.3)).all() && max.cmpge(Vec3::splat(0.4)).all(),
            "{min} {max}"
        );
        // An optical depth of 4 is 12.8 away from the camera at z = -5.
        assert!(min.z >= -5.0 && max.z <= 7.81, "{min} {max}");
    }

    #[test]
    fn a_large_picture_gets_as_many_more_paths_as_the_root_of_its_pixels() {
        let mut scene = fog(1.0, Vec3::ZERO, true);
        let survey = Survey { meetings: Some(0.1), ..Survey::new(&scene) };
        let mut paths = |side| {
            (scene.camera.width, scene.camera.height) = (side, side);
            photons(&scene, &survey, 0.1)
        };
        // 64 beams of 0.1/m in strips 0.2 m wide: 3200 paths.
        assert_eq!([64, 256, 1024].map(&mut paths), [3200, 3200, 13_000]);
        assert_eq!(paths(16384), MOST as u32);
    }

    /// A lamp N paths of which pass a distance d with a density of N/(4πd²): along a line at the distance h, from -L to L about the
    /// nearest point, N ∫ dt/(4π(h² + t²)) = N atan(L/h)/(2π h).
    #[test]
    fn beams_that_eye_rays_meet_are_those_of_the_closed_form() {
        let scene = scene(
            "outside_medium = \"fog\"\n\
             [camera]\nposition = [0, 0, -40]\nlook_at = [0, 0, 0]\nvertical_fov = 1\nwidth = 8\nheight = 8\n\
             [[medium]]\nname = \"fog\"\nscattering = 1e-6\nabsorption = 0\n\
             [[object]]\nshape = \"box\"\nmin = [-40, -40, -40.5]\nmax = [40, 40, 40]\nmaterial = \"black\"\n\
             [[light]]\nkind = \"point\"\nposition = [0, 8, 0]\nintensity = 1\n",
        );
        let found = Survey::new(&scene).meetings.expect("light");
        let expected = 5.0_f64.atan() / (2.0 * std::f64::consts::PI * 8.0);
        // The survey's voxels are 0.3 wide: some 20 beams in a row of them, and the middle of four by four rows.
        assert!((found / expected - 1.0).abs() < 0.2, "{found} for {expected}");
    }

    #[test]
    fn cells_are_about_cubic_and_never_too_many() {
        assert_eq!(divide(Vec3::ONE, CELLS), [24; 3]);
        assert_eq!(divide(Vec3::new(4.0, 1.0, 2.0), CELLS), [48, 12, 24]);
        for size in [
            Vec3::new(1.0, 1e-3, 1.0),
            Vec3::new(1e-3, 1.0, 1e-3),
            Vec3::new(2e9, 2e9, 1e-9),
            Vec3::new(1e-9, 2e9, 1e-9),
        ] {
            let cells = divide(size, CELLS);
            let count: f64 = cells.iter().map(|n| f64::from(*n)).product();
            // The last count makes up for what rounding the others took, but for its own half.
            assert!((count / f64::from(CELLS) - 1.0).abs() < 0.02, "{size}: {cells:?}");
        }
    }

    #[test]
    fn scenes_with_next_to_nothing_in_them_have_sound_defaults() {
        let camera = "outside_medium = \"fog\"\n\
             [camera]\nposition = [0, 0, 0]\nlook_at = [0, 0, 1]\nvertical_fov = 0.001\nwidth = 1\nheight = 1\n";
        let medium = |coefficient: &str| {
            format!("[[medium]]\nname = \"fog\"\nscattering = {coefficient}\nabsorption = {coefficient}\n")
        };
        let lamp =
            |place: &str| format!("[[light]]\nkind = \"point\"\nposition = {place}\nintensity = 1e9\n");
        let shut = "[[object]]\nshape = \"box\"\nmin = [4, 4, 4]\nmax = [6, 6, 6]\nmaterial = \"black\"\n";
        for medium in ["0.1", "1e9", "1e-9", "0"].map(medium) {
            for light in
                [lamp("[0, 0, 0]"), lamp("[5, 5, 5]") + shut, lamp("[1e9, 1e9, -1e9]"), lamp("[0, 0, 1e-9]")]
            {
                let text = [camera, &medium, &light].concat();
                let Scene { grid, settings, .. } = scene(&text);
                let voxel = (grid.max - grid.min) / Vec3::from(grid.cells.map(|n| n as f32));
                assert!(grid.min.is_finite() && voxel.min_element() > 0.0, "{text}: {grid:?}");
                assert!(settings.radius > 0.0 && settings.radius.is_finite(), "{text}: {settings:?}");
                assert!(settings.max_radius >= settings.radius, "{text}: {settings:?}");
                assert!((FEWEST..=MOST).contains(&f64::from(settings.photons)), "{text}: {settings:?}");
            }
        }
    }
}
