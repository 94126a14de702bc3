//! Eye paths: from the camera through media, which may send out light, and specular surfaces to the first diffuse or black one.

mod branch;
pub mod facet;
pub mod segment;
pub(crate) mod shown;
pub mod sight;
pub mod starts;
pub(crate) mod straight;

use crate::eye::branch::{Branch, REFLECTED, REFRACTED};
use crate::eye::segment::EyeSegment;
pub use crate::eye::shown::SmallLamps;
use crate::eye::starts::{EyeStart, EyeStarts};
use crate::kind::{ByKind, Kind};
use crate::lamps::LampTree;
use crate::light::Meetings;
use crate::random::Random;
use crate::scene::geometry::MOST_BOUNDS;
use crate::scene::media;
use crate::scene::optics::{Boundary, Interior, facing_normal, reflect};
use crate::scene::passage::{Looks, clear, passage};
use crate::scene::{Light, Material, Rays, Scene, SceneMedium};
use crate::surface::clearance::{Clearance, Ground, flat_within};
use crate::surface::encounter::{Encounter, Met};
use crate::surface::{Around, SurfaceMap};
use covbeam::{Knot, Medium};
use covbeam_geometry::hit::Hit;
use glam::Vec3;
use smallvec::SmallVec;
use std::f32::consts::FRAC_1_PI;

/// Both branches of a dielectric are followed this many times in a row, then one is drawn at random.
const SPLITS: u32 = 4;

/// Follows eye paths of one scene.
#[derive(Clone, Copy)]
pub struct EyeTracer<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Its media.
    pub fogs: &'a [Medium<'a>],
    /// Where eye paths start.
    pub starts: EyeStarts<'a>,
    /// Its lamps.
    pub lamps: &'a LampTree,
    /// Light on diffuse surfaces.
    pub surfaces: &'a SurfaceMap,
    /// Whether anything is wanted from the first surface on that is more than a bound of media.
    pub beyond: bool,
    /// Of the lamps that are shown those that are small in the picture; None: none are wanted that are shown.
    pub shown: Option<&'a SmallLamps>,
    /// Whether those that are seen straight are looked for apart.
    pub is_apart: bool,
}

/// An eye path that is followed.
struct Path<'s> {
    pixel: u32,
    /// What it has seen.
    radiance: ByKind,
    /// Its pieces in media.
    segments: &'s mut Vec<EyeSegment>,
    /// Still to be followed.
    branches: SmallVec<[Branch; 8]>,
    knots: Vec<Knot>,
}

impl<'s> Path<'s> {
    fn new(pixel: u32, segments: &'s mut Vec<EyeSegment>) -> Self {
        let (radiance, branches) = (ByKind::default(), SmallVec::new());
        Self { pixel, radiance, segments, branches, knots: Vec::new() }
    }

    #[inline]
    fn add(&mut self, throughput: Vec3, seen: ByKind) {
        for (sum, seen) in self.radiance.iter_mut().zip(seen) {
            *sum += throughput * seen;
        }
    }
}

impl EyeTracer<'_> {
    /// [`EyeTracer::trace`], of what is wanted from the eye ray only: the fog before the first surface that is more than a bound of media, and
    /// all else.
    pub fn trace_wanted(
        &self,
        start: &EyeStart,
        pixel: u32,
        [fog, rest]: [bool; 2],
        random: &mut Random,
        segments: &mut Vec<EyeSegment>,
    ) -> ByKind {
        let mut place = segments.len();
        let mut radiance = ByKind::default();
        if rest && self.beyond {
            radiance = self.trace(start, pixel, random, segments);
        } else {
            let sent_out = self.trace_first(start, pixel, segments);
            if rest {
                radiance[Kind::Straight as usize] = sent_out;
            }
        }
        while !fog && place < segments.len() {
            if segments[place].is_first() {
                segments.swap_remove(place);
            } else {
                place += 1;
            }
        }
        radiance
    }

    /// The pieces of the path in media before the first surface that is more than a bound of these. Returns what is seen of what they send out.
    fn trace_first(&self, start: &EyeStart, pixel: u32, segments: &mut Vec<EyeSegment>) -> Vec3 {
        if !start.sees {
            return Vec3::ZERO;
        }
        let scene = self.scene;
        let mut sent_out = Vec3::ZERO;
        let mut branch = Branch::new(start, true);
        let mut knots = Vec::new();
        for _ in 0..=MOST_BOUNDS {
            let hit = scene.intersect_flat(branch.origin, branch.direction, f32::INFINITY);
            let beyond = hit.as_ref().and_then(|hit| Some((hit, self.seen_through(hit, &branch)?)));
            let length = hit.as_ref().map_or(f32::INFINITY, |hit| hit.distance);
            if let Some(segment) = branch.segment(scene, length, pixel) {
                segments.push(segment);
                if beyond.is_some() || scene.medium_of(segment.medium).glow.is_some() {
                    let (left, glow, _) = self.crossed(&segment, &Meetings::new(), &mut knots);
                    sent_out += branch.throughput * glow;
                    branch.throughput *= left;
                }
            }
            let Some((hit, (share, interior))) = beyond else { break };
            branch.throughput *= share;
            if branch.throughput == Vec3::ZERO {
                break;
            }
            branch = branch.straight_on(hit, interior);
        }
        sent_out
    }

    /// What a surface shows of what lies straight behind it, and what a branch is inside of there; None: nothing.
    fn seen_through(&self, hit: &Hit, branch: &Branch) -> Option<(Vec3, Interior)> {
        let Branch { direction, ref interior, ray, .. } = *branch;
        if let Some(beyond) = clear(self.scene, hit, direction, interior, ray) {
            return Some((Vec3::ONE, beyond));
        }
        let share = self.scene.material_at(hit).transparent();
        (share != Vec3::ZERO).then(|| (share, interior.through(self.scene, hit, direction)))
    }

    /// What a piece of a path leaves of light, the radiance that its medium sends out along it, and what arrives from lamps on it.
    fn crossed(&self, segment: &EyeSegment, lamps: &Meetings, knots: &mut Vec<Knot>) -> (Vec3, Vec3, Vec3) {
        let (fog, ray) = (&self.fogs[segment.medium as usize], &segment.ray);
        let column = media::column(fog, ray.origin, ray.direction, ray.length, knots);
        let SceneMedium { density, glow, .. } = self.scene.medium_of(segment.medium);
        let glow = glow.as_ref().map_or(Vec3::ZERO, |glow| glow.seen(fog, density, ray, &column));
        let dimmed = |(distance, radiance): &(f64, Vec3)| {
            *radiance * fog.transmittance(column.at((*distance as f32).clamp(0.0, ray.length)))
        };
        (fog.transmittance(column.at(ray.length)), glow, lamps.iter().map(dimmed).sum())
    }

    /// Follows the path from its start, appends its pieces in media to `segments` and returns the
    /// radiance that it sees on surfaces, and that media send out.
    pub fn trace(
        &self,
        start: &EyeStart,
        pixel: u32,
        random: &mut Random,
        segments: &mut Vec<EyeSegment>,
    ) -> ByKind {
        let scene = self.scene;
        let mut path = Path::new(pixel, segments);
        path.branches.extend(start.sees.then(|| Branch::new(start, self.is_apart)));
        if let Some(small) = self.shown.filter(|_| !self.is_apart) {
            path.radiance[Kind::Straight as usize] += small.radiance(scene, self.fogs, &self.starts, start);
        }
        while let Some(mut branch) = path.branches.pop() {
            if !branch.goes_on(random) {
                continue;
            }
            let hit = scene.intersect(branch.origin, branch.direction, f32::INFINITY);
            self.travel(&mut branch, hit.as_ref(), &mut path);
            let Some(hit) = hit.filter(|_| branch.throughput != Vec3::ZERO) else { continue };
            match clear(scene, &hit, branch.direction, &branch.interior, branch.ray) {
                Some(interior) => path.branches.push(branch.straight_on(&hit, interior)),
                None => self.meet(&branch, &hit, &mut path, random),
            }
        }
        path.radiance
    }

    /// Follows a branch to where it hits a surface, or to infinity: adds what media and lamps send into it, and leaves it what is left then.
    #[inline]
    fn travel(&self, branch: &mut Branch, hit: Option<&Hit>, path: &mut Path) {
        let length = hit.map_or(f32::INFINITY, |hit| hit.distance);
        let lamps = branch.watch.look(self.scene, self.shown, branch.origin, branch.direction, hit);
        let (mut left, mut lit) = (Vec3::ONE, lamps.iter().map(|(_, radiance)| *radiance).sum::<Vec3>());
        if let Some(segment) = branch.segment(self.scene, length, path.pixel) {
            path.segments.push(segment);
            let glow;
            (left, glow, lit) = self.crossed(&segment, &lamps, &mut path.knots);
            path.radiance[Kind::Straight as usize] += branch.throughput * glow;
        }
        path.radiance[branch.watch.kind() as usize] += branch.throughput * lit;
        branch.throughput *= left;
    }

    /// Adds what is seen of a surface, and the ways on from it.
    #[inline]
    fn meet(&self, branch: &Branch, hit: &Hit, path: &mut Path, random: &mut Random) {
        let scene = self.scene;
        match *scene.material_at(hit) {
            Material::Black | Material::Clear => {}
            Material::Lambert { .. } if !scene.shows_surfaces() => {}
            Material::Lambert { albedo } => {
                path.add(branch.throughput, self.reflected(hit, branch, albedo, random));
            }
            Material::Lobes(ref lobes) => {
                let xi = branch.facet.map_or_else(|| [random.uniform(), random.uniform()], |facet| facet.xi);
                let met = Encounter::new(
                    scene,
                    hit,
                    (Met::ByEyePath, branch.direction),
                    &branch.interior,
                    lobes,
                    xi,
                );
                if scene.shows_surfaces() {
                    path.add(branch.throughput, self.seen(hit, branch, &met, random));
                }
                if branch.depth < SPLITS {
                    let ways = met.sharp_ways();
                    path.branches.extend(ways.map(|way| branch.follow(hit, &met, &way)));
                } else {
                    let way = met.draw_sharp(branch.throughput, random.uniform());
                    path.branches.extend(way.map(|way| branch.follow(hit, &met, &way)));
                }
            }
            Material::Mirror { reflectance } => {
                let normal = facing_normal(hit, branch.direction);
                let direction = reflect(branch.direction, normal);
                path.branches.push(branch.next(hit, direction, reflectance, branch.interior, REFLECTED));
            }
            Material::Dielectric { .. } => self.split(branch, hit, path, random),
        }
    }

    /// Adds the ways on from a boundary of glass: both, or after some in a row one at random.
    #[inline]
    fn split(&self, branch: &Branch, hit: &Hit, path: &mut Path, random: &mut Random) {
        let boundary = Boundary::new(self.scene, hit, branch.direction, &branch.interior);
        let reflectance = boundary.reflectance;
        // Radiance over the squared index is what refraction keeps.
        let scale = boundary.eta * boundary.eta;
        let through = boundary.refracted.map(|direction| {
            let weight = Vec3::splat((1.0 - reflectance) * scale);
            branch.next(hit, direction, weight, boundary.beyond, REFRACTED)
        });
        let weight = Vec3::splat(reflectance);
        let mut back = branch.next(hit, boundary.reflected, weight, branch.interior, REFLECTED);
        match through {
            None => path.branches.push(back),
            Some(through) if branch.depth < SPLITS => path.branches.extend([back, through]),
            Some(_) if random.uniform() < reflectance => {
                back.throughput /= reflectance;
                path.branches.push(back);
            }
            Some(mut through) => {
                through.throughput /= 1.0 - reflectance;
                path.branches.push(through);
            }
        }
    }

    /// Radiance leaving a diffuse surface: direct light and the photons that came any other way.
    fn reflected(&self, hit: &Hit, branch: &Branch, albedo: Vec3, random: &mut Random) -> ByKind {
        let normal = facing_normal(hit, branch.direction);
        self.irradiance(hit, (normal, branch.interior, Rays::DIFFUSE), random)
            .map(|irradiance| albedo * irradiance * FRAC_1_PI)
    }

    /// Radiance leaving a surface of lobes where the eye path does not follow: from the diffuse ones, and from rough ones that lamps shine on.
    fn seen(&self, hit: &Hit, branch: &Branch, met: &Encounter, random: &mut Random) -> ByKind {
        let mut sum = ByKind::default();
        let [back, through] = met.diffuse();
        let here = (met.normal, branch.interior, Rays::DIFFUSE);
        let beyond = (-met.normal, met.beyond(), Rays::TRANSMISSION);
        for (share, side) in [(back, here), (through, beyond)] {
            if share != Vec3::ZERO {
                let irradiance = self.irradiance(hit, side, random);
                sum.iter_mut()
                    .zip(irradiance)
                    .for_each(|(sum, irradiance)| *sum += share * irradiance * FRAC_1_PI);
            }
        }
        if met.is_rough() {
            let start = hit.leave(met.normal);
            let mut asked = self.lamps.on_surface(start, met.normal, self.shift(random));
            asked.retain(|(lamp, _)| self.scene.falls_on(*lamp, hit, Rays::GLOSSY));
            let arriving =
                straight_irradiance(self.scene, self.fogs, branch.interior, start, &asked, |light| {
                    let (density, from) = light.flux_density(start, [random.uniform(), random.uniform()]);
                    let towards = (from - start).normalize_or_zero();
                    (density * met.glossy_towards(towards) * towards.dot(met.normal).max(0.0), from)
                });
            sum[Kind::Straight as usize] += arriving;
        }
        sum
    }

    /// Irradiance on one side of a surface: by its normal, what is around it there, and the kind of the rays to what shines on it.
    fn irradiance(
        &self,
        hit: &Hit,
        (normal, interior, ray): (Vec3, Interior, Rays),
        random: &mut Random,
    ) -> ByKind {
        let start = hit.leave(normal);
        let ground = Ground { scene: self.scene, start, normal };
        let holds = |way| ground.holds(way);
        let mut around = Around::new(self.surfaces, hit.position, normal);
        let reach = self.surfaces.reach();
        let unbounded = Clearance::of(f32::INFINITY);
        let clear = reach.map_or(unbounded, |[least, most]| {
            let reach = [least, most.min(flat_within(&hit.curvature))];
            Clearance::new(&ground, reach, random, || around.enough(holds))
        });
        let mut irradiance = around.irradiance(&hit.curvature, clear, holds);
        let mut asked = self.lamps.on_surface(hit.position, normal, self.shift(random));
        asked.retain(|(lamp, _)| self.scene.falls_on(*lamp, hit, ray));
        irradiance[Kind::Straight as usize] =
            straight_irradiance(self.scene, self.fogs, interior, start, &asked, |light| {
                light.irradiance(hit.position, normal, random)
            });
        irradiance
    }

    /// A number for drawing lamps; none is drawn where all are asked.
    fn shift(&self, random: &mut Random) -> f32 {
        if self.lamps.is_drawn_on_surfaces() { random.uniform() } else { 0.0 }
    }
}

/// Irradiance that arrives straight from the lamps at a point next to a surface.
///
/// - `interior`: of `start`; `asked`: lamps, and how many each stands for; `unshadowed`: of a lamp, and where its light comes from.
pub(crate) fn straight_irradiance(
    scene: &Scene,
    fogs: &[Medium],
    interior: Interior,
    start: Vec3,
    asked: &[(usize, f32)],
    mut unshadowed: impl FnMut(&Light) -> (Vec3, Vec3),
) -> Vec3 {
    let mut sum = Vec3::ZERO;
    for &(lamp, count) in asked {
        let (direct, from) = unshadowed(&scene.lights[lamp]);
        if direct.max_element() > 0.0 {
            let links = scene.links_of(lamp);
            let arrives = passage(scene, fogs, interior, [start, from], Looks::For(&links));
            sum += count * direct * links.falloff.at(start.distance(from)) * arrives;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::made::{Made, camera, cuboid, point};

    /// In a box of glass a ray along (1, 1, 1) meets every side at 54.7°, beyond the critical angle of 41.8°.
    #[test]
    fn a_path_that_is_reflected_for_ever_ends() {
        let scene = Made::new(camera([0.1, 0.2, 0.3], [1.1, 1.2, 1.3], 1.0, [1, 1]))
            .object(cuboid([-1.0; 3], [1.0; 3]), Material::Dielectric { index: 1.5 })
            .light(point([0.0, 5.0, 0.0], 1.0))
            .scene();
        let surfaces = SurfaceMap::empty();
        let starts = EyeStarts::new(&scene);
        let tracer = EyeTracer {
            scene: &scene,
            fogs: &[],
            starts,
            lamps: &LampTree::new(&scene),
            surfaces: &surfaces,
            beyond: true,
            shown: Some(&SmallLamps::default()),
            is_apart: false,
        };
        let seen = tracer.trace(&starts.middle(0, 0), 0, &mut Random::new([0; 4]), &mut Vec::new());
        assert_eq!(seen, ByKind::default());
    }
}
