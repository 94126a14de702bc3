//! Light that comes straight from the lamps and is scattered once on its way to the camera: shadow rays, from places along
//! the eye rays.

use crate::eye::EyeSegment;
use crate::lamps::{Drawn, LampTree, Stretch};
use crate::media;
use crate::near::Near;
use crate::passage::passage;
use crate::random::{Random, spread};
use crate::scene::{Light, MediumDensity, Scene};
use covbeam::{Column, EyeRay, Knot, Medium};
use glam::Vec3;

/// Places on a piece of an eye path, for each lamp, in a pass. With 8 a rose window has twice the error at equal time, and smooth light twice
/// the noise of straight light after 20 seconds; 32 cost as much as they are worth.
const PLACES: f32 = 16.0;

/// The same behind the first surface, where the noise is that of the paths: with 16 a figurine in fog has the same error and a tenth more
/// time, fog in a glass box a quarter more; with 1 they have a twentieth more variance.
const PLACES_BEHIND: f32 = 4.0;

/// Most places, where few eye rays stand for many pixels.
const MOST_PLACES: f32 = 64.0;

/// Lamps that a piece of an eye path asks; of more, as many times the places are drawn by what each lamp is worth to it.
const LAMPS: usize = 4;

/// Turns from pass to pass: the fractions of √2, √3 and √7, which no whole numbers of them, of the golden ratio and of the plastic number
/// bring together. With the golden ratio, by which a plan chooses the passes in which a pixel gets an eye ray, a pixel would look at the same
/// places in all of these.
const PLACE_STEP: f64 = std::f64::consts::SQRT_2 - 1.0;
const POINT_STEPS: [f64; 2] = [0.732_050_807_568_877_3, 0.645_751_311_064_590_6];

/// Purpose of random numbers.
const KEY: u32 = 0x57a1;

/// Whether straight light in a region is left to beams: where density varies from voxel to voxel a shadow ray's transmittance costs as much
/// as some fifty pairs.
pub(crate) fn is_left_to_beams(scene: &Scene, medium: u32) -> bool {
    matches!(scene.medium_of(medium).density, MediumDensity::Grid(_))
}

/// Shadow rays of a piece of an eye path, alone in its pixel.
pub(crate) fn rays_of_piece(scene: &Scene, segment: &EyeSegment) -> u32 {
    let lamps = scene.lights.iter().filter(|light| light.is_straight()).take(LAMPS);
    places_on(segment) as u32 * lamps.count() as u32
}

fn places_on(segment: &EyeSegment) -> f32 {
    if segment.is_first() { PLACES } else { PLACES_BEHIND }
}

/// The straight light of a pass.
pub(crate) struct Straight<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) fogs: &'a [Medium<'a>],
    /// For drawing some of many.
    pub(crate) lamps: &'a LampTree,
    pub(crate) seed: u32,
    pub(crate) pass: u32,
    /// Where it is left to beams; None: nowhere.
    pub(crate) near: Option<&'a Near>,
}

/// A piece of an eye path that has straight light in it.
struct Piece<'a> {
    segment: &'a EyeSegment,
    fog: &'a Medium<'a>,
    column: Column<'a>,
    /// The part with light that is not lost on its way.
    from: f32,
    to: f32,
}

/// Where a lamp's places and points lie in this pass.
struct Shifts {
    place: f32,
    point: [f32; 2],
}

/// What a lamp shines on of a piece, by the angle seen from it.
struct Angles {
    /// Distances along the ray.
    from: f32,
    to: f32,
    /// Of what is nearest to the lamp, and how far from it that is.
    foot: f32,
    height: f32,
    /// Of both ends, and of those of a gap that is left to beams.
    start: f32,
    end: f32,
    gap: [f32; 2],
}

impl Angles {
    fn skipped(&self) -> f32 {
        self.gap[1] - self.gap[0]
    }

    /// Of all but the gap.
    fn width(&self) -> f32 {
        self.end - self.start - self.skipped()
    }

    /// Distance of an angle that is counted from the start, the gap left out, and the angle's tangent.
    fn place(&self, angle: f32) -> (f32, f32) {
        let angle = self.start + angle;
        let tangent = if angle < self.gap[0] { angle } else { angle + self.skipped() }.tan();
        (self.foot + self.height * tangent, tangent)
    }
}

impl Straight<'_> {
    /// Radiance of straight light at the start of a piece of an eye path.
    ///
    /// - `pixel`: the piece's; `density`: eye rays a pixel and pass around it: fewer look at more places.
    /// - `look` of `looks`: of rays through the same pixel, which share the places.
    pub(crate) fn radiance(
        &self,
        segment: &EyeSegment,
        pixel: u32,
        density: f32,
        (look, looks): (u32, u32),
        knots: &mut Vec<Knot>,
    ) -> Vec3 {
        let fog = &self.fogs[segment.medium as usize];
        if fog.scattering == Vec3::ZERO || is_left_to_beams(self.scene, segment.medium) {
            return Vec3::ZERO;
        }
        let ray = &segment.ray;
        let column = media::column(fog, ray.origin, ray.direction, ray.length, knots);
        let to = ray.length.min(media::opaque_distance(fog, ray.origin, ray.direction, &column));
        let piece = Piece { segment, fog, column, from: 0.0, to };
        let places =
            (places_on(segment) / (density * looks as f32).sqrt()).round().clamp(1.0, MOST_PLACES) as u32;
        let fraction = look as f32 / looks as f32;
        let mut random = Random::new([self.seed, pixel, segment.signature as u32, KEY]);
        let mut sum = Vec3::ZERO;
        if self.scene.lights.len() <= LAMPS {
            for lamp in 0..self.scene.lights.len() {
                sum += self.of_lamp(&piece, lamp, places, &self.shifts(&mut random, fraction));
            }
            return sum;
        }
        self.of_many(&piece, LAMPS as u32 * places, &mut random, fraction)
    }

    /// Of lamps that are drawn, each with its places.
    fn of_many(&self, piece: &Piece, draws: u32, random: &mut Random, fraction: f32) -> Vec3 {
        let Shifts { place, point } = self.shifts(random, fraction);
        let Piece { segment, fog, column, from, to } = piece;
        let left = |distance: f32| fog.mean_transmittance(column.at(distance));
        let EyeRay { origin, direction, .. } = segment.ray;
        let stretch = Stretch { origin, direction, from: *from, to: *to, left: &left };
        let seen = |lamp: usize| {
            let angles = self.angles(piece, lamp)?;
            Some((angles.width() / angles.height, angles.place(0.5 * angles.width()).0))
        };
        let mut sum = Vec3::ZERO;
        self.lamps.along(&stretch, draws, place, &seen, &mut |drawn: Drawn| {
            let Some(angles) = self.angles(piece, drawn.lamp) else { return };
            let light = &self.scene.lights[drawn.lamp];
            let step = angles.width() / drawn.expected();
            for draw in drawn.draws.clone() {
                let angle = drawn.rest(draw) * angles.width();
                sum += self.at_angle(piece, light, &angles, (angle, step), spread(point, draw as usize));
            }
        });
        sum
    }

    /// A number of this pass of a sequence that fills [0, 1) evenly over the passes.
    fn turn(&self, start: f32, step: f64) -> f32 {
        ((f64::from(start) + step * f64::from(self.pass)).fract() as f32).min(1.0 - f32::EPSILON)
    }

    fn shifts(&self, random: &mut Random, fraction: f32) -> Shifts {
        let mut turn = |step| self.turn(random.uniform(), step);
        let place = (turn(PLACE_STEP) + fraction).fract();
        let [a, b] = POINT_STEPS.map(turn);
        Shifts { place, point: [a, (b + fraction).fract()] }
    }

    /// One place in each of equal steps of the angle seen from the lamp (C. Kulla and M. Fajardo 2012), all shifted alike. A disk's light has a
    /// bound where its middle's 1/d² has none: it is looked at from further away.
    fn of_lamp(&self, piece: &Piece, lamp: usize, places: u32, shifts: &Shifts) -> Vec3 {
        let Some(angles) = self.angles(piece, lamp) else { return Vec3::ZERO };
        let light = &self.scene.lights[lamp];
        let step = angles.width() / places as f32;
        let mut sum = Vec3::ZERO;
        for index in 0..places {
            let angle = (index as f32 + shifts.place) * step;
            sum += self.at_angle(piece, light, &angles, (angle, step), spread(shifts.point, index as usize));
        }
        sum
    }

    /// What a lamp shines on of a piece; None: nothing.
    fn angles(&self, piece: &Piece, lamp: usize) -> Option<Angles> {
        let light = &self.scene.lights[lamp];
        let ray = &piece.segment.ray;
        let (from, to) = light.lit_stretch(ray.origin, ray.direction, piece.from, piece.to)?;
        let (middle, softening) = light.middle();
        let to_lamp = middle - ray.origin;
        let foot = to_lamp.dot(ray.direction);
        // A ray that runs into the lamp sees it from next to it.
        let least = (1e-6 * to_lamp.length()).max(f32::MIN_POSITIVE);
        let height = (to_lamp - foot * ray.direction).length().hypot(softening).max(least);
        let angle = |distance: f32| ((distance - foot) / height).atan();
        let [start, end] = [from, to].map(angle);
        let reach = self.near.map_or(0.0, |near| near.reach(lamp));
        let half = (reach * reach - height * height).max(0.0).sqrt();
        let gap = [foot - half, foot + half].map(|distance| angle(distance).clamp(start, end));
        Some(Angles { from, to, foot, height, start, end, gap })
    }

    /// What a step of an angle at one that is counted from the first, with the gap left out, adds.
    fn at_angle(
        &self,
        piece: &Piece,
        light: &Light,
        angles: &Angles,
        (angle, step): (f32, f32),
        point: [f32; 2],
    ) -> Vec3 {
        let (distance, tangent) = angles.place(angle);
        if !(distance >= angles.from && distance <= angles.to) {
            return Vec3::ZERO;
        }
        let weight = step * angles.height * (1.0 + tangent * tangent);
        weight * self.scattered(piece, light, distance, point)
    }

    /// Radiance that a metre scatters to the start of the piece, from a point of the light.
    fn scattered(&self, piece: &Piece, light: &Light, distance: f32, point: [f32; 2]) -> Vec3 {
        let Piece { segment, fog, column, .. } = piece;
        let place = segment.ray.origin + distance * segment.ray.direction;
        let (flux_density, from) = light.flux_density(place, point);
        if flux_density == Vec3::ZERO {
            return Vec3::ZERO;
        }
        let arrives = passage(self.scene, self.fogs, segment.interior, place, from);
        if arrives == Vec3::ZERO {
            return Vec3::ZERO;
        }
        let incoming = (place - from).normalize_or_zero();
        let phase = fog.phase.evaluate(-incoming.dot(segment.ray.direction));
        let amount = fog.scattering * (fog.density.at(place) * phase);
        flux_density * amount * fog.transmittance(column.at(distance)) * arrives
    }
}
