//! Light that comes straight from the lamps and is scattered once on its way to the camera: shadow rays, from places along
//! the eye rays.

pub(crate) mod looks;
mod places;

use crate::eye::segment::EyeSegment;
use crate::lamps::near::Near;
use crate::lamps::{Drawn, LampTree, MOST_ASKED, Stretch};
use crate::random::{Random, spread};
use crate::scene::media;
use crate::scene::passage::{Looks, passage};
use crate::scene::{MediumDensity, Scene, SceneMedium};
use covbeam::{Column, EyeRay, Knot, Medium};
use glam::Vec3;
use places::{Angles, Places, Seen};

/// Places on a piece of an eye path, for each lamp, in a pass; fewer by the root of what a shadow ray costs more among voxels. With 8 a rose
/// window has twice the error at equal time, and smooth light twice the noise of straight light after 20 seconds; 32 cost as much as they are
/// worth.
const PLACES: f32 = 16.0;

/// The same behind the first surface, where the noise is that of the paths: with 16 a figurine in fog has the same error and a tenth more
/// time, fog in a glass box a quarter more; with 1 they have a twentieth more variance.
const PLACES_BEHIND: f32 = 4.0;

/// What a voxel on a shadow ray's way costs, over the ray.
const VOXEL: f32 = 0.08;

/// Most places, where few eye rays stand for many pixels.
const MOST_PLACES: f32 = 64.0;

/// Lamps that a piece of an eye path asks; of more, as many times the places are drawn by what each lamp is worth to it.
const LAMPS: usize = 4;

/// What a look at a lamp that was drawn costs, in shadow rays to the lamps of a scene with few: it is chosen by some ten
/// looks at groups, and what is around many lamps is more than what is around few.
const DRAWN: u32 = 6;

/// Turns from pass to pass: the fractions of √2, √3 and √7, which no whole numbers of them, of the golden ratio and of the plastic number
/// bring together. With the golden ratio, by which a plan chooses the passes in which a pixel gets an eye ray, a pixel would look at the same
/// places in all of these.
const PLACE_STEP: f64 = std::f64::consts::SQRT_2 - 1.0;
const POINT_STEPS: [f64; 2] = [0.732_050_807_568_877_3, 0.645_751_311_064_590_6];

/// Purpose of random numbers.
const KEY: u32 = 0x57a1;

/// Shadow rays of a piece of an eye path, alone in its pixel, or what costs as much.
pub(crate) fn rays_of_piece(scene: &Scene, segment: &EyeSegment) -> u32 {
    let all = scene.lights.iter().filter(|light| light.is_straight()).take(LAMPS + 1).count();
    let places = (cost_in(scene.medium_of(segment.medium)) * places_on(scene, segment)) as u32;
    if all > LAMPS { DRAWN * places * LAMPS as u32 } else { places * all as u32 }
}

/// The same of a place on a surface, beyond those to as few lamps as most scenes have.
pub(crate) fn rays_of_surface(lamps: &LampTree) -> u32 {
    let asked = lamps.count().min(MOST_ASKED) as u32;
    let each = if lamps.is_drawn_on_surfaces() { DRAWN } else { 1 };
    each * asked.saturating_sub(LAMPS as u32)
}

fn places_on(scene: &Scene, segment: &EyeSegment) -> f32 {
    if segment.is_first() { PLACES / cost_in(scene.medium_of(segment.medium)).sqrt() } else { PLACES_BEHIND }
}

/// What a shadow ray costs over one in even fog: in voxels it walks through half of the box, about.
fn cost_in(medium: &SceneMedium) -> f32 {
    match &medium.density {
        MediumDensity::Grid(volume) => {
            let across = volume.layout.cells.iter().sum::<u32>() as f32 / 3.0;
            1.0 + VOXEL * 0.5 * across
        }
        MediumDensity::Uniform | MediumDensity::Exponential(_) => 1.0,
    }
}

/// The straight light of a pass.
#[derive(Clone, Copy)]
pub(crate) struct Straight<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) fogs: &'a [Medium<'a>],
    /// For drawing some of many.
    pub(crate) lamps: &'a LampTree,
    pub(crate) seed: u32,
    pub(crate) pass: u32,
    /// Where it is left to beams, next to lamps; None: nowhere.
    pub(crate) near: Option<&'a Near>,
}

/// A piece of an eye path that has straight light in it.
struct Piece<'a> {
    segment: &'a EyeSegment,
    fog: &'a Medium<'a>,
    column: Column<'a>,
    seen: Seen<'a>,
    /// The part with light that is not lost on its way.
    from: f32,
    to: f32,
}

/// Where a lamp's places and points lie in this pass.
struct Shifts {
    place: f32,
    point: [f32; 2],
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
        if fog.scattering == Vec3::ZERO {
            return Vec3::ZERO;
        }
        let ray = &segment.ray;
        let column = media::column(fog, ray.origin, ray.direction, ray.length, knots);
        let to = ray.length.min(media::opaque_distance(fog, ray.origin, ray.direction, &column));
        let piece = Piece { segment, fog, column, seen: Seen::new(fog, column, 0.0, to), from: 0.0, to };
        let places = (places_on(self.scene, segment) / (density * looks as f32).sqrt())
            .round()
            .clamp(1.0, MOST_PLACES) as u32;
        let mut random = Random::new([self.seed, pixel, segment.signature as u32, KEY]);
        let mut shifts = || self.shifts(&mut random, (look, looks));
        if self.scene.lights.len() > LAMPS {
            return self.of_many(&piece, LAMPS as u32 * places, &shifts());
        }
        let lamps = 0..self.scene.lights.len();
        lamps.map(|lamp| self.of_lamp(&piece, lamp, places, &shifts())).sum()
    }

    /// Of lamps that are drawn, each with its places.
    fn of_many(&self, piece: &Piece, draws: u32, &Shifts { place, point }: &Shifts) -> Vec3 {
        let Piece { segment, fog, column, from, to, .. } = piece;
        let left = |distance: f32| fog.mean_transmittance(column.at(distance));
        let EyeRay { origin, direction, .. } = segment.ray;
        let stretch = Stretch::new([origin, direction], [*from, *to], self.lamps.reach(), left);
        let seen = |lamp: usize| {
            let light = &self.scene.lights[lamp];
            light.lit_stretch(origin, direction, *from, *to)
        };
        let mut sum = Vec3::ZERO;
        self.lamps.along(&stretch, draws, place, &seen, &mut |drawn: Drawn| {
            let Some(angles) = self.angles(piece, drawn.lamp) else { return };
            let places = Places::new(&piece.seen, &angles);
            for draw in drawn.draws.clone() {
                let (angle, stands_for) = places.at(drawn.rest(draw));
                let point = spread(point, draw as usize);
                let step = (angle, stands_for / drawn.expected());
                sum += self.at_angle(piece, drawn.lamp, &angles, step, point);
            }
        });
        sum
    }

    /// Those of a look of several: each is one in the sequences that fill [0, 1) evenly over looks and passes.
    fn shifts(&self, random: &mut Random, (look, looks): (u32, u32)) -> Shifts {
        let number = f64::from(self.pass) * f64::from(looks) + f64::from(look);
        let mut turn = |step: f64| {
            ((f64::from(random.uniform()) + step * number).fract() as f32).min(1.0 - f32::EPSILON)
        };
        Shifts { place: turn(PLACE_STEP), point: POINT_STEPS.map(turn) }
    }

    /// One place in each of steps that are worth as much, all shifted alike: by the angle seen from the lamp (C. Kulla and M. Fajardo 2012) and by
    /// what is seen of the fog. A disk's light has a bound where its middle's 1/d² has none: it is looked at from further away.
    fn of_lamp(&self, piece: &Piece, lamp: usize, places: u32, shifts: &Shifts) -> Vec3 {
        let Some(angles) = self.angles(piece, lamp) else { return Vec3::ZERO };
        let along = Places::new(&piece.seen, &angles);
        let mut sum = Vec3::ZERO;
        for index in 0..places {
            let (angle, stands_for) = along.at((index as f32 + shifts.place) / places as f32);
            let step = (angle, stands_for / places as f32);
            sum += self.at_angle(piece, lamp, &angles, step, spread(shifts.point, index as usize));
        }
        sum
    }

    /// What a lamp shines on of a piece; None: nothing.
    fn angles(&self, piece: &Piece, lamp: usize) -> Option<Angles> {
        let set = self.scene.medium_of(piece.segment.medium).heed.light_set;
        if !self.scene.links_of(lamp).lights_medium(set) {
            return None;
        }
        let light = &self.scene.lights[lamp];
        let ray = &piece.segment.ray;
        let (from, to) = light.lit_stretch(ray.origin, ray.direction, piece.from, piece.to)?;
        let (middle, softening) = light.middle();
        let to_lamp = middle - ray.origin;
        let foot = to_lamp.dot(ray.direction);
        // A ray that runs into the lamp sees it from next to it.
        let least = (1e-6 * to_lamp.length()).max(f32::MIN_POSITIVE);
        let height = libm::hypotf((to_lamp - foot * ray.direction).length(), softening).max(least);
        let angle = |distance: f32| libm::atanf((distance - foot) / height);
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
        lamp: usize,
        angles: &Angles,
        (angle, step): (f32, f32),
        point: [f32; 2],
    ) -> Vec3 {
        let (distance, tangent) = angles.place(angle);
        if !(distance >= angles.from && distance <= angles.to) {
            return Vec3::ZERO;
        }
        let weight = step * angles.height * (1.0 + tangent * tangent);
        weight * self.scattered(piece, lamp, distance, point)
    }

    /// Radiance that a metre scatters to the start of the piece, from a point of the light.
    fn scattered(&self, piece: &Piece, lamp: usize, distance: f32, point: [f32; 2]) -> Vec3 {
        let Piece { segment, fog, column, .. } = piece;
        let place = segment.ray.origin + distance * segment.ray.direction;
        let (flux_density, from) = self.scene.lights[lamp].flux_density(place, point);
        if flux_density == Vec3::ZERO {
            return Vec3::ZERO;
        }
        let links = self.scene.links_of(lamp);
        let arrives = passage(self.scene, self.fogs, segment.interior, [place, from], Looks::For(&links));
        if arrives == Vec3::ZERO {
            return Vec3::ZERO;
        }
        let incoming = (place - from).normalize_or_zero();
        let phases = fog.phases(-incoming.dot(segment.ray.direction));
        let amount = fog.scattering * (fog.density.at(place) * phases);
        flux_density
            * links.falloff.at(place.distance(from))
            * amount
            * fog.transmittance(column.at(distance))
            * arrives
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eye::straight_irradiance;
    use crate::scene::made::{Made, camera, point, sphere, spot};
    use crate::scene::optics::Interior;
    use crate::scene::{Light, Material};

    const CENTRE: Vec3 = Vec3::new(0.0, 1.0, 0.0);

    /// Forty lamps of several kinds around a ball in fog.
    fn scene() -> Scene {
        let camera = camera([0.0, 1.0, -9.0], CENTRE.to_array(), 40.0, [8, 8]);
        let ball = sphere(CENTRE.to_array(), 0.5);
        let mut made = Made::new(camera).fog(0.2, 0.05).in_fog().object(ball, Material::Black);
        let mut random = Random::new([7, 0, 0, 0]);
        for lamp in 0..40 {
            let position = [0; 3].map(|_| 6.0 * random.uniform() - 3.0);
            let power = 10.0_f32.powf(2.0 * random.uniform() - 1.0);
            let (center, radius, radiance) = (Vec3::from(position), 0.1, Vec3::splat(30.0 * power));
            made = made.light(match lamp % 4 {
                0 => point(position, power),
                1 => spot(position, [0.0, 1.0, -2.0], power, [20.0, 40.0]),
                2 => Light::Disk { center, normal: Vec3::NEG_Y, radius, radiance },
                _ => Light::Sphere { center, radius, radiance },
            });
        }
        made.scene()
    }

    #[test]
    fn looks_and_passes_fill_places_and_points_of_a_lamp_evenly() {
        let scene = scene();
        let (fogs, lamps) = (media::all(&scene), LampTree::new(&scene));
        for (passes, looks) in [(1, 64), (64, 1), (8, 32)] {
            let count = passes * looks;
            let shifts: Vec<[f32; 3]> = (1..=passes)
                .flat_map(|pass| {
                    let straight =
                        Straight { scene: &scene, fogs: &fogs, lamps: &lamps, seed: 1, pass, near: None };
                    (0..looks).map(move |look| {
                        let Shifts { place, point } =
                            straight.shifts(&mut Random::new([5, 0, 0, KEY]), (look, looks));
                        [place, point[0], point[1]]
                    })
                })
                .collect();
            for (a, b) in [(0, 1), (0, 2), (1, 2)] {
                // Squares of a grid: with numbers that know nothing of each other one in 50 has none, with two alike nearly all.
                let mut counts = [0; 16];
                for shift in &shifts {
                    counts[4 * (4.0 * shift[a]) as usize + (4.0 * shift[b]) as usize] += 1;
                }
                let expected = count / 16;
                let even = counts.iter().all(|met| *met >= expected / 2 && *met <= 2 * expected);
                assert!(even, "{passes} passes of {looks}, {a} and {b}: {counts:?}");
            }
        }
    }

    fn mean_and_error(values: &[f64]) -> [f64; 2] {
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
        [mean, (variance / count).sqrt()]
    }

    /// Both to 5 standard errors of their difference, in 20 places once in 80,000 runs; the sums to 2 %, so that a lamp left out would be seen.
    fn assert_same(all: &[f64], drawn: &[f64], what: &str) {
        let ([a, of_a], [b, of_b]) = (mean_and_error(all), mean_and_error(drawn));
        let error = of_a.hypot(of_b);
        println!("{what}: {a} ± {of_a}, drawn {b} ± {of_b}");
        assert!(error < 0.02 * a && (a - b).abs() < 5.0 * error + 1e-5 * a, "{what}: {a}, {b} ± {error}");
    }

    #[test]
    fn drawn_lamps_send_what_all_of_them_do() {
        let scene = scene();
        let fogs = media::all(&scene);
        let lamps = LampTree::new(&scene);
        let mut knots = Vec::new();
        for pixel in 0..10 {
            let mut random = Random::new([8, pixel, 0, 0]);
            let mut number = || 2.0 * random.uniform() - 1.0;
            let origin = Vec3::new(3.0 * number(), 1.0 + number(), -4.0);
            let direction = (CENTRE + Vec3::new(number(), number(), number()) - origin).normalize();
            let interior = Interior::at(&scene, origin);
            let ray = EyeRay { origin, direction, length: 3.0 };
            let segment = EyeSegment { ray, medium: 0, throughput: Vec3::ONE, pixel, interior, signature: 0 };
            let straight =
                |pass| Straight { scene: &scene, fogs: &fogs, lamps: &lamps, seed: 3, pass, near: None };
            let drawn: Vec<f64> = (0..400)
                .map(|pass| straight(pass).radiance(&segment, pass, 1.0, (0, 1), &mut knots))
                .map(|radiance| f64::from(radiance.x))
                .collect();
            let column = media::column(&fogs[0], origin, direction, 3.0, &mut knots);
            let seen = Seen::new(&fogs[0], column, 0.0, 3.0);
            let piece = Piece { segment: &segment, fog: &fogs[0], column, seen, from: 0.0, to: 3.0 };
            let all: Vec<f64> = (0..100)
                .map(|pass| {
                    let of = |lamp: usize| {
                        let straight = straight(pass);
                        let shifts = straight.shifts(&mut Random::new([9, pass, lamp as u32, pixel]), (0, 1));
                        f64::from(straight.of_lamp(&piece, lamp, 16, &shifts).x)
                    };
                    (0..40).map(of).sum()
                })
                .collect();
            assert_same(&all, &drawn, "a ray");
            let normal = (origin - CENTRE).normalize();
            let place = CENTRE + 0.51 * normal;
            let mut irradiance = |asked: &[(usize, f32)]| {
                let from = |light: &Light| light.irradiance(place, normal, &mut random);
                f64::from(straight_irradiance(&scene, &fogs, interior, place, asked, from).x)
            };
            let every: Vec<(usize, f32)> = (0..40).map(|lamp| (lamp, 1.0)).collect();
            let all: Vec<f64> = (0..100).map(|_| irradiance(&every)).collect();
            let mut shifts = Random::new([10, pixel, 0, 0]);
            let drawn: Vec<f64> =
                (0..400).map(|_| irradiance(&lamps.on_surface(place, normal, shifts.uniform()))).collect();
            assert_same(&all, &drawn, "a surface");
        }
    }
}
