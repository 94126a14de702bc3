//! The plain structs of the ABI, and their way to and from the core's.

use crate::check::{finite, finite_each, finite_not_negative, not_negative, unit, unit_or_zero, vector};
use crate::memory::{Element, field};
use crate::status::Failure;
use covbeam_core as core_types;
use glam::Vec3;

/// Square root of the covariance of a local light field's spectrum. Made by covbeam_light_field_point and its
/// kin; the numbers are the host's to copy, store and send, not to write.
///
/// Error of what it says of the fluence, relative to the largest entry of its covariance: one rounding of the
/// ten numbers per operator; below 1e-6 after tens of events and 1e-5 after 1000, but near a focus, where it
/// is as large as what the rounding of the inputs changes. Long ways of strongly bent light lose more: of 1000
/// random chains of up to 1000 events, with ways of 1e-3 to 1e3 m and curvatures of 0.01 to 100 per m, half are
/// within 1e-7, 99 % within 7e-6, all within 2e-4. Where curvature times distance is beyond 1e7, 24 bits hold
/// only one axis of the light.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_light_field {
    /// Lower-triangular L with covariance L L^T, rows (u, v, x, y), packed row by row [uu, vu, vv, xu, xv, xx,
    /// yu, yv, yx, yy]: u, v in cycles/rad, x, y in cycles/m.
    pub root: [f32; 10],
    /// The frame's x axis: unit, across direction; y = direction x x_axis.
    pub x_axis: [f32; 3],
    /// Direction of propagation, unit.
    pub direction: [f32; 3],
}

/// Curvature of a surface at a hit [1/m], positive where it is convex on the side of the normal; all 0 is a
/// plane.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_curvature {
    /// First axis of the tensor, in the surface, any length; 0 if along equals across.
    pub tangent: [f32; 3],
    /// Normal curvature along tangent.
    pub along: f32,
    /// Normal curvature along normal x tangent.
    pub across: f32,
    /// The off-diagonal entry.
    pub twist: f32,
}

/// Covariance of the spectrum of the fluence around a point, in world axes [cycles^2/m^2].
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_spectrum {
    /// Variance along world x.
    pub xx: f32,
    /// Variance along world y.
    pub yy: f32,
    /// Variance along world z.
    pub zz: f32,
    /// Covariance of x and y.
    pub xy: f32,
    /// Covariance of x and z.
    pub xz: f32,
    /// Covariance of y and z.
    pub yz: f32,
}

/// Box and resolution of a grid or of a density. Voxels lie in memory x first, then y, then z.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_grid_layout {
    /// Lower corner [m].
    pub min: [f32; 3],
    /// Upper corner [m], above min on every axis.
    pub max: [f32; 3],
    /// Voxels along x, y, z, each >= 1; at most 2^24 in all.
    pub cells: [u32; 3],
}

/// What one voxel has collected. All 0 is empty.
/// @extra
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_grid_cell {
    /// Sum of weight x (xx, yy, zz, xy, xz, yz).
    pub sum: [f64; 6],
    /// Sum of the weights.
    pub weight: f64,
}

/// The mean spectrum of one voxel, for look-ups.
/// @extra
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_fluence_cell {
    /// Flux-weighted mean of what was deposited.
    pub spectrum: covbeam_spectrum,
    /// Fluence over that of the brightest voxel, in (0, 1]; 0 = no data.
    pub weight: f32,
}

/// An edge of an occluder beside a ray.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_edge {
    /// Distance along the ray at which the edge passes by [m], finite; one at a depth <= 0 does not count.
    pub depth: f32,
    /// Distance from the ray to the edge there [m] >= 0; infinity is no edge.
    pub distance: f32,
    /// Direction from the ray to the nearest point of the edge, any length but 0.
    pub towards: [f32; 3],
}

/// Where a probe ray meets a surface, for covbeam_find_edges.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_probe_hit {
    /// Along the probe [m] > 0; infinity where it meets nothing.
    pub distance: f32,
    /// Geometric normal, any length but 0, either side; not looked at where nothing is met.
    pub normal: [f32; 3],
    /// How far off this surface rays start that leave it [m], finite and >= 0: what the host's rays are moved by
    /// so as not to meet it again. A hit nearer than 4096 times that is on the surface which the ray itself left,
    /// and no edge, if the ray starts within twice the offset of the hit's tangent plane.
    pub offset: f32,
}

/// Most edges of a segment.
pub const COVBEAM_MOST_EDGES: usize = 4;

const _: () = assert!(COVBEAM_MOST_EDGES == core_types::MOST_EDGES);

/// A straight piece of a photon's path that carries a light field.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct covbeam_segment {
    /// Where it starts [m], in or out of the grid. It runs along field.direction.
    pub origin: [f32; 3],
    /// Length [m] > 0; infinity reaches the end of the grid.
    pub length: f32,
    /// Flux at the origin [W] > 0, mean of the channels. Only its ratio to that of other segments matters: where
    /// a tenth of the photons carry fields, it need not be ten times the beam's.
    pub power: f32,
    /// 1 if the light comes from its source without scattering in a medium or on a diffuse surface (mirrors and
    /// glass are no scattering), else 0.
    pub unscattered: u32,
    /// The light field at the origin.
    pub field: covbeam_light_field,
    /// The edges that the light passes, sorted by depth: such as covbeam_find_edges finds, or 0.
    pub edges: [covbeam_edge; COVBEAM_MOST_EDGES],
    /// Number of edges that count.
    pub edge_count: u32,
    /// How the light is attenuated: NULL takes it from the medium. A host with media of its own gives a table
    /// of (distance from the origin, optical depth up to there / extinction of the medium passed), both finite,
    /// neither falling.
    pub knots: *const covbeam_knot,
    /// Number of knots; 0 if knots is NULL.
    pub knot_count: usize,
}

/// A phase function: how scattered light is spread over directions.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_phase {
    /// A value of covbeam_phase_kind.
    pub kind: u32,
    /// Mean cosine of Henyey-Greenstein, in (-1, 1), forward positive; ignored by the others.
    pub asymmetry: f32,
}

/// Which phase function.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum covbeam_phase_kind {
    /// The same in all directions.
    COVBEAM_PHASE_ISOTROPIC = 0,
    /// Henyey-Greenstein.
    COVBEAM_PHASE_HENYEY_GREENSTEIN = 1,
    /// Rayleigh.
    COVBEAM_PHASE_RAYLEIGH = 2,
}

/// A point of a table of columns.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_knot {
    /// Distance along the ray [m].
    pub distance: f32,
    /// Integral of the relative density up to there [m].
    pub column: f32,
}

/// Derivatives of a relative density, in world axes.
/// @extra
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_derivatives {
    /// First derivatives [1/m].
    pub gradient: [f32; 3],
    /// Second derivatives xx, yy, zz, xy, xz, yz [1/m^2].
    pub hessian: [f32; 6],
}

/// A photon beam: a straight piece of a photon's path through a medium. It runs on to the next surface,
/// whatever the photon's free flight was; the gather multiplies by the transmittance ("long beams").
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_beam {
    /// Where it starts [m].
    pub origin: [f32; 3],
    /// Direction of propagation, unit.
    pub direction: [f32; 3],
    /// Length [m] to the next surface, finite and >= 0; where there is none, covbeam_medium_reach is far
    /// enough.
    pub length: f32,
    /// Flux at the origin per channel [W], already divided by the number of light paths of the pass.
    pub power: [f32; 3],
    /// Unit normal of the surface on which it starts, towards the medium; 0 if it starts in the open.
    pub start_normal: [f32; 3],
    /// Unit normal of the surface on which it ends, towards the medium; 0 if it ends in the open.
    pub end_normal: [f32; 3],
}

/// One straight piece of an eye path inside one medium.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_eye_ray {
    /// Where it starts [m].
    pub origin: [f32; 3],
    /// Direction, unit, away from the eye.
    pub direction: [f32; 3],
    /// Length [m] >= 0 to the next surface; infinity allowed.
    pub length: f32,
}

/// What an eye ray has gathered.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_gathered {
    /// In-scattered radiance at the ray's origin [W/(m^2 sr)].
    pub radiance: [f32; 3],
    /// Accepted pairs of ray and beam; one of nearly one direction (sine below .05) counts as eight.
    pub pairs: u32,
    /// Sum over the pairs of their contribution (mean of the channels): the weight of the next two.
    pub weight: f32,
    /// Weighted sum of the kernel radii [m].
    pub radius: f32,
    /// Weighted sum of the light's bandwidth along the kernel's axis [cycles/m].
    pub sigma: f32,
}

/// Closest approach of an eye ray's line and a beam's line.
/// @extra
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_crossing {
    /// Distance along the eye ray [m]; may lie outside it.
    pub ray_distance: f32,
    /// Distance along the beam [m]; may lie outside it.
    pub beam_distance: f32,
    /// Distance between the two closest points [m].
    pub gap: f32,
    /// Sine of the angle between the directions, in (0, 1].
    pub sin_theta: f32,
    /// Unit common perpendicular, on which the kernel acts.
    pub axis: [f32; 3],
}

/// A place where a beam comes within the kernel radius of an eye ray, for covbeam_beam_map_gather_shaded. A
/// pair of nearly one direction (sine below .05) has eight, along the eye ray.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_contact {
    /// The closest point on the eye ray [m].
    pub position: [f32; 3],
    /// Index of the eye ray in the call.
    pub ray: u32,
    /// Index of the beam, in the order in which they were added.
    pub beam: u32,
    /// Distance along the eye ray [m].
    pub ray_distance: f32,
    /// Distance along the beam [m]; at an end on a surface it may be outside the beam by less than radius. At a
    /// negative one, -s, the beam has the optical depth -(the one at s), as if the medium went on behind the
    /// surface.
    pub beam_distance: f32,
    /// Cosine between the light's propagation before and after scattering towards the eye: forward +1.
    pub cos_theta: f32,
    /// The blur kernel over the sine of the angle between beam and ray [1/m], with which the library
    /// multiplies; of the eight places of a pair along the ray, each one's share of its integral.
    pub kernel: f32,
    /// Kernel radius [m].
    pub radius: f32,
    /// Bandwidth along the kernel's axis [cycles/m]; 0 without a grid.
    pub sigma: f32,
}

/// How much an eye ray changes from one pixel to the next.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_pixel_step {
    /// Of its origin [m/pixel]: 0 for a pinhole.
    pub origin: [f32; 3],
    /// Of its unit direction [1/pixel]: 0 for an orthographic camera. Only what is across the ray counts.
    pub direction: [f32; 3],
}

/// Covariance of the spectrum of the in-scattered light around a pixel, in the plane of the picture
/// [cycles^2/pixel^2]: x to the right, y down.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_image_spectrum {
    /// Variance across.
    pub xx: f32,
    /// Covariance of across and down.
    pub xy: f32,
    /// Variance down.
    pub yy: f32,
    /// In-scattered light on the way, in the grid's relative unit; 0 = the grid has no data, and the other
    /// numbers are 0.
    pub weight: f32,
}

/// Covariance of a Gaussian reconstruction filter [pixels^2]: x to the right, y down. All 0 is no filter.
/// @extra
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_image_filter {
    /// Variance across.
    pub xx: f32,
    /// Covariance of across and down.
    pub xy: f32,
    /// Variance down.
    pub yy: f32,
}

/// What one eye ray saw of what it was asked for.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_film_ray {
    /// x to the right and y down.
    pub pixel: [u32; 2],
    /// 1 if it was asked for the fog before the first surface, whose light is filtered; else 0.
    pub has_volume: u32,
    /// 1 if it was asked for what lies beyond, which the pixel keeps to itself; else 0.
    pub has_rest: u32,
    /// The fog's radiance, per channel, finite and not negative [W/(m^2 sr)].
    pub volume: [f32; 3],
    /// That of the rest.
    pub rest: [f32; 3],
}

/// A pixel of a picture.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_film_pixel {
    /// All light, per channel [W/(m^2 sr)].
    pub radiance: [f32; 3],
    /// That of the fog before the first surface.
    pub volume: [f32; 3],
    /// Squared standard error of the filtered luminance; 0 = not known, or none is.
    pub variance: f32,
    /// Luminance of the odd passes minus that of the even ones, of the light that is not filtered.
    pub difference: f32,
}

/// One knot of the table along an eye ray, from which shadow rays are placed.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_march_knot {
    /// From the ray's origin [m].
    pub distance: f32,
    /// Light that one metre of the ray scatters to the eye if nothing is in the lights' way, as one number such
    /// as its luminance [W/(m^3 sr)]: transmittance to the eye x scattering coefficient x phase function x
    /// transmittance to the light x intensity / squared distance. NaN, infinity and negative numbers count as 0.
    pub radiance: f32,
    /// Standard deviation of the fluence's spectrum along the ray [cycles/m]: the root of
    /// covbeam_spectrum_variance_along. NaN, infinity and negative numbers: not known.
    pub deviation: f32,
    /// Share of the light that is expected to arrive, in [0, 1], such as that of a few rays from the
    /// light past this place. NaN and negative numbers: not known.
    pub visibility: f32,
}

/// A place for a shadow ray.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_march_sample {
    /// From the ray's origin [m].
    pub distance: f32,
    /// The sum over a round of weight x radiance x visibility, at distance, is the estimate of the light
    /// scattered to the eye [m]. 0 = no shadow ray is needed.
    pub weight: f32,
    /// What the shadow ray found, in [0, 1], written by the host; read from the first round by
    /// covbeam_march_refine.
    pub visibility: f32,
    /// 0.
    pub reserved: u32,
    /// The table's expected light up to distance [W/(m^2 sr)], by which covbeam_march_refine finds the first
    /// round.
    pub mass: f64,
}

/// What a table along an eye ray says before any shadow ray is traced.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_march_expected {
    /// The light that is expected to be scattered to the eye [W/(m^2 sr)]: with the knots' visibility, half
    /// where it is not known.
    pub radiance: f32,
    /// Expected standard deviation of the estimate from one round, times the number of its shadow rays
    /// [W/(m^2 sr)]. To spread rays over pixels, give to each in proportion to a power of it.
    pub error: f32,
}

impl From<covbeam_light_field> for core_types::LightField {
    fn from(field: covbeam_light_field) -> Self {
        Self { root: field.root, x_axis: field.x_axis.into(), direction: field.direction.into() }
    }
}

impl From<core_types::LightField> for covbeam_light_field {
    fn from(field: core_types::LightField) -> Self {
        Self { root: field.root, x_axis: field.x_axis.into(), direction: field.direction.into() }
    }
}

/// A light field as only the library writes them, up to the rounding of its frame.
pub(crate) fn light_field(e: Element<covbeam_light_field>) -> Result<core_types::LightField, Failure> {
    finite_each(field!(e, root))?;
    let x = unit(field!(e, x_axis))?;
    let z = unit(field!(e, direction))?;
    // Rounded axes are across each other to 1e-7.
    if x.dot(z).abs() <= 1e-4 {
        Ok(e.value.into())
    } else {
        Err(field!(e, x_axis).is(format_args!("{x} is not across direction {z}")))
    }
}

impl From<covbeam_edge> for core_types::Edge {
    fn from(edge: covbeam_edge) -> Self {
        Self { depth: edge.depth, distance: edge.distance, towards: edge.towards.into() }
    }
}

impl From<core_types::Edge> for covbeam_edge {
    fn from(edge: core_types::Edge) -> Self {
        Self { depth: edge.depth, distance: edge.distance, towards: edge.towards.into() }
    }
}

impl From<covbeam_curvature> for core_types::Curvature {
    fn from(c: covbeam_curvature) -> Self {
        Self { tangent: c.tangent.into(), along: c.along, across: c.across, twist: c.twist }
    }
}

pub(crate) fn curvature(e: Element<covbeam_curvature>) -> Result<core_types::Curvature, Failure> {
    vector(field!(e, tangent))?;
    for bend in [field!(e, along), field!(e, across), field!(e, twist)] {
        finite(bend)?;
    }
    Ok(e.value.into())
}

impl From<core_types::FluenceSpectrum> for covbeam_spectrum {
    fn from(s: core_types::FluenceSpectrum) -> Self {
        let [xx, yy, zz, xy, xz, yz] = s.to_array();
        Self { xx, yy, zz, xy, xz, yz }
    }
}

impl From<covbeam_spectrum> for core_types::FluenceSpectrum {
    fn from(s: covbeam_spectrum) -> Self {
        Self::from_array([s.xx, s.yy, s.zz, s.xy, s.xz, s.yz])
    }
}

pub(crate) fn spectrum(e: Element<covbeam_spectrum>) -> Result<core_types::FluenceSpectrum, Failure> {
    let diagonal = [field!(e, xx), field!(e, yy), field!(e, zz)];
    for variance in diagonal.into_iter().chain([field!(e, xy), field!(e, xz), field!(e, yz)]) {
        finite(variance)?;
    }
    Ok(e.value.into())
}

impl From<covbeam_grid_layout> for core_types::GridLayout {
    fn from(layout: covbeam_grid_layout) -> Self {
        Self { min: layout.min.into(), max: layout.max.into(), cells: layout.cells }
    }
}

impl From<core_types::GridLayout> for covbeam_grid_layout {
    fn from(layout: core_types::GridLayout) -> Self {
        Self { min: layout.min.into(), max: layout.max.into(), cells: layout.cells }
    }
}

impl From<covbeam_knot> for core_types::Knot {
    fn from(knot: covbeam_knot) -> Self {
        Self { distance: knot.distance, column: knot.column }
    }
}

impl From<core_types::Knot> for covbeam_knot {
    fn from(knot: core_types::Knot) -> Self {
        Self { distance: knot.distance, column: knot.column }
    }
}

impl From<core_types::Derivatives> for covbeam_derivatives {
    fn from(d: core_types::Derivatives) -> Self {
        Self { gradient: d.gradient.into(), hessian: d.hessian }
    }
}

fn beam_length(e: Element<f32>) -> Result<f32, Failure> {
    if e.value == f32::INFINITY {
        return Err(e.is(format_args!("inf; end it where nothing is left to see, at covbeam_medium_reach")));
    }
    finite_not_negative(e)
}

pub(crate) fn beam(e: Element<covbeam_beam>) -> Result<core_types::Beam, Failure> {
    Ok(core_types::Beam {
        origin: vector(field!(e, origin))?,
        direction: unit(field!(e, direction))?,
        length: beam_length(field!(e, length))?,
        power: vector(field!(e, power))?,
        start_normal: unit_or_zero(field!(e, start_normal))?,
        end_normal: unit_or_zero(field!(e, end_normal))?,
    })
}

#[inline(always)]
pub(crate) fn eye_ray(e: Element<covbeam_eye_ray>) -> Result<core_types::EyeRay, Failure> {
    Ok(core_types::EyeRay {
        origin: vector(field!(e, origin))?,
        direction: unit(field!(e, direction))?,
        length: not_negative(field!(e, length))?,
    })
}

impl From<core_types::Gathered> for covbeam_gathered {
    fn from(g: core_types::Gathered) -> Self {
        Self {
            radiance: g.radiance.into(),
            pairs: g.pairs,
            weight: g.weight,
            radius: g.radius,
            sigma: g.sigma,
        }
    }
}

impl From<covbeam_gathered> for core_types::Gathered {
    fn from(g: covbeam_gathered) -> Self {
        Self {
            radiance: Vec3::from(g.radiance),
            pairs: g.pairs,
            weight: g.weight,
            radius: g.radius,
            sigma: g.sigma,
        }
    }
}

/// What an eye ray has gathered so far.
pub(crate) fn gathered(e: Element<covbeam_gathered>) -> Result<core_types::Gathered, Failure> {
    finite_each(field!(e, radiance))?;
    for sum in [field!(e, weight), field!(e, radius), field!(e, sigma)] {
        finite(sum)?;
    }
    Ok(e.value.into())
}

impl From<core_types::Crossing> for covbeam_crossing {
    fn from(c: core_types::Crossing) -> Self {
        Self {
            ray_distance: c.ray_distance,
            beam_distance: c.beam_distance,
            gap: c.gap,
            sin_theta: c.sin_theta,
            axis: c.axis.into(),
        }
    }
}

pub(crate) fn pixel_step(e: Element<covbeam_pixel_step>) -> Result<core_types::PixelStep, Failure> {
    Ok(core_types::PixelStep { origin: vector(field!(e, origin))?, direction: vector(field!(e, direction))? })
}

impl From<core_types::ImageSpectrum> for covbeam_image_spectrum {
    fn from(core_types::ImageSpectrum { xx, xy, yy, weight }: core_types::ImageSpectrum) -> Self {
        Self { xx, xy, yy, weight }
    }
}

pub(crate) fn image_spectrum(
    e: Element<covbeam_image_spectrum>,
) -> Result<core_types::ImageSpectrum, Failure> {
    let covbeam_image_spectrum { xx, xy, yy, weight } = e.value;
    for variance in [field!(e, xx), field!(e, xy), field!(e, yy)] {
        finite(variance)?;
    }
    finite_not_negative(field!(e, weight))?;
    Ok(core_types::ImageSpectrum { xx, xy, yy, weight })
}

impl From<core_types::ImageFilter> for covbeam_image_filter {
    fn from(core_types::ImageFilter { xx, xy, yy }: core_types::ImageFilter) -> Self {
        Self { xx, xy, yy }
    }
}

pub(crate) fn image_filter(e: Element<covbeam_image_filter>) -> Result<core_types::ImageFilter, Failure> {
    let covbeam_image_filter { xx, xy, yy } = e.value;
    finite(field!(e, xy))?;
    for variance in [field!(e, xx), field!(e, yy)] {
        finite_not_negative(variance)?;
    }
    Ok(core_types::ImageFilter { xx, xy, yy })
}

/// - `volume`: the filtered light alone.
pub(crate) fn film_pixel(pixel: core_types::FilmPixel, volume: Vec3) -> covbeam_film_pixel {
    let core_types::FilmPixel { radiance, variance, difference } = pixel;
    covbeam_film_pixel { radiance: radiance.into(), volume: volume.into(), variance, difference }
}

/// What the error of a pixel is found from.
pub(crate) fn film_pixel_of(e: Element<covbeam_film_pixel>) -> Result<core_types::FilmPixel, Failure> {
    let covbeam_film_pixel { variance, difference, .. } = e.value;
    finite_not_negative(field!(e, variance))?;
    finite(field!(e, difference))?;
    Ok(core_types::FilmPixel { radiance: Vec3::ZERO, variance, difference })
}

impl From<covbeam_march_knot> for core_types::MarchKnot {
    fn from(knot: covbeam_march_knot) -> Self {
        let covbeam_march_knot { distance, radiance, deviation, visibility } = knot;
        Self { distance, radiance, deviation, visibility }
    }
}

impl From<core_types::MarchKnot> for covbeam_march_knot {
    fn from(knot: core_types::MarchKnot) -> Self {
        let core_types::MarchKnot { distance, radiance, deviation, visibility } = knot;
        Self { distance, radiance, deviation, visibility }
    }
}

impl From<core_types::MarchSample> for covbeam_march_sample {
    fn from(sample: core_types::MarchSample) -> Self {
        let core_types::MarchSample { distance, weight, visibility, mass } = sample;
        Self { distance, weight, visibility, reserved: 0, mass }
    }
}

/// A sample of a first round, with what its shadow ray found; NaN is nothing.
pub(crate) fn march_sample(e: Element<covbeam_march_sample>) -> Result<core_types::MarchSample, Failure> {
    let covbeam_march_sample { distance, weight, visibility, mass, .. } = e.value;
    finite(field!(e, distance))?;
    finite_not_negative(field!(e, weight))?;
    if !(visibility.is_nan() || (0.0..=1.0).contains(&visibility)) {
        return Err(field!(e, visibility).is(format_args!("{visibility} is not in [0, 1]")));
    }
    if !(mass >= 0.0 && mass.is_finite()) {
        return Err(field!(e, mass).is(format_args!("{mass} is not of covbeam_march_place")));
    }
    Ok(core_types::MarchSample { distance, weight, visibility, mass })
}

/// The structs that arrays of the host's are read as, without a copy.
macro_rules! same_layout {
    ($ours:ty, $core:ty, $last_ours:ident, $last_core:ident) => {
        const _: () = assert!(
            size_of::<$ours>() == size_of::<$core>()
                && align_of::<$ours>() == align_of::<$core>()
                && core::mem::offset_of!($ours, $last_ours) == core::mem::offset_of!($core, $last_core)
        );
    };
}
same_layout!(covbeam_grid_cell, core_types::GridCell, weight, weight);
same_layout!(covbeam_fluence_cell, core_types::FluenceCell, weight, weight);
same_layout!(covbeam_contact, core_types::Contact, sigma, sigma);
same_layout!(covbeam_knot, core_types::Knot, column, column);
