//! Light paths that go where the picture needs them: emitted, split and ended so that power x importance is about the same for all.
//!
//! A path is a tree. Whatever is certain is not left to chance: what passes a medium goes on with what is left of it, and what the medium
//! scatters is drawn as often as that is worth. Where light scatters, several directions are looked at, and those go on that are worth it.

use crate::color::mean;
use crate::light::cosine_direction;
use crate::paths::guidance::Guidance;
use crate::paths::operators::Operator;
use crate::paths::record::{FieldSegment, PhotonRecord, Record, add};
use crate::paths::weight::{self, channel, inverse, patience};
use crate::paths::{Photon, PhotonTracer, choose_light};
use crate::random::{PathSampler, spread};
use crate::scene::Material;
use crate::scene::media;
use crate::scene::optics::{Boundary, facing_normal};
use covbeam::{Column, Knot, Medium, weight_window};
use covbeam_geometry::hit::Hit;
use glam::Vec3;
use smallvec::SmallVec;
use std::time::Instant;

/// Directions that are looked at for each that is expected to go on. With 8 or 16 beams are more alike, and looking costs more than that is
/// worth.
const CANDIDATES: f32 = 4.0;

/// Most directions, and most collisions on a segment.
const MOST: f32 = 64.0;

/// Nothing goes on with less than this probability, so that what is worth more than it seems is not worth a tenfold surprise.
const LEAST: f32 = 0.1;

/// And nothing with more than so many times the power that a path has on average, in any channel, or its [`Limits`](weight::Limits) if these are more
/// far out; of long paths as many times more as they may weigh.
pub(super) const MOST_POWER: f32 = 20.0;

/// Of a direction's expected worth, this share of the mean one's is taken for granted.
const FOR_GRANTED: f32 = 0.1;

/// Of the light fields that are scattered for the first time, this share goes on, and stands for the others: scattered light is smooth, and
/// its fields are most of what fields cost. Straight light has the edges, and needs all.
const SCATTERED_FIELDS: f32 = 0.3;

/// Paths of which less than this is left behind a medium are thinned out; and those with less than this of a path's mean power that only one
/// way is left to.
const FAINT: f32 = 0.1;

/// With every so many segments of one tree twice as much is asked of its next branches: where importance seems to grow a thousandfold along
/// each path, as inside a ball of milk, a tree would have millions. Those of plain scenes have a few hundred at most.
const LARGE_TREE: u32 = 1024;

/// What one tree of paths needs.
struct Tree<'t, 'a> {
    tracer: &'t PhotonTracer<'a>,
    guidance: &'t Guidance,
    /// Power x importance of each path that is not long.
    unit: f32,
    /// Mean power of a path.
    power: Vec3,
    record: Record,
    /// Segments that do not wait any more.
    followed: u32,
    waiting: Vec<(Photon, PathSampler, u32)>,
    knots: Vec<Knot>,
    /// Of the segment that is being followed.
    segment: Option<FieldSegment>,
}

/// A direction in which a photon may go on.
#[derive(Clone, Copy)]
struct Candidate {
    direction: Vec3,
    origin: Vec3,
}

impl<'a> PhotonTracer<'a> {
    /// Like [`PhotonTracer::trace`], with guidance.
    pub(super) fn trace_guided(
        &self,
        guidance: &Guidance,
        mut sampler: PathSampler,
        paths: u32,
        record: Record,
        out: &mut PhotonRecord,
    ) {
        let (light, share) = choose_light(guidance.lamps(), &mut sampler);
        let (place, density) = guidance.emission(light).warp(sampler.uniform_pair());
        let emitted = self.scene.lights[light].emit_at(place, &mut sampler);
        let power = emitted.power / (share * density * paths as f32);
        let Some(photon) = self.start(light, &emitted, power, record) else { return };
        add(&mut out.energy.emitted, power);
        if !(power.max_element() > 0.0) {
            return;
        }
        let mut tree = Tree {
            tracer: self,
            guidance,
            unit: guidance.total() / paths as f32,
            power: self.lights.flux / paths as f32,
            record,
            followed: 0,
            waiting: vec![(photon, sampler, 0)],
            knots: Vec::new(),
            segment: None,
        };
        while let Some((photon, sampler, depth)) = tree.waiting.pop() {
            tree.follow(photon, sampler, depth, out);
        }
    }
}

impl Tree<'_, '_> {
    /// The power x importance that a path may have before it is split. What has been followed says nothing of what is drawn next, so that the light
    /// is right in the mean.
    fn unit(&self, depth: u32) -> f32 {
        let segments = self.followed + self.waiting.len() as u32;
        patience(depth) * ((segments / LARGE_TREE) as f32).exp2() * self.unit
    }

    /// One over the most power that a path may have in each channel.
    fn most(&self, place: Vec3, depth: u32) -> Vec3 {
        let near = Vec3::splat(MOST_POWER * patience(depth));
        inverse(self.power * self.tracer.limits.at(place, depth).max(near))
    }

    /// One segment, what it scatters on its way, and the event at its end.
    fn follow(&mut self, mut photon: Photon, mut sampler: PathSampler, depth: u32, out: &mut PhotonRecord) {
        // As much more as long paths may weigh, fewer of them there are.
        let fewer = patience(depth.saturating_sub(1)) / patience(depth);
        if fewer < 1.0 && !survives(&mut photon, fewer, &mut sampler, out) {
            return;
        }
        self.followed += 1;
        let tracer = self.tracer;
        let scene = tracer.scene;
        let hit = scene.intersect(photon.origin, photon.direction, f32::INFINITY);
        let reach = hit.map_or(f32::INFINITY, |hit| hit.distance);
        // What is farther away gets no light of it.
        let end = reach.min(photon.until);
        match photon.interior.medium(scene) {
            Some(id) => {
                let fog = tracer.fogs[id as usize];
                let mut knots = std::mem::take(&mut self.knots);
                let column = media::column(&fog, photon.origin, photon.direction, reach, &mut knots);
                if self.record != Record::Field {
                    out.beams.extend(photon.beam(id, hit.as_ref(), &fog, &column));
                }
                let opaque = media::opaque_distance(&fog, photon.origin, photon.direction, &column);
                self.carry_field(&photon, reach.min(opaque), hit.as_ref(), Some((id, &fog, &column)), out);
                let left = fog.transmittance(column.at(end));
                self.scatter(&photon, &fog, &column, [end, end.min(opaque)], &mut sampler, depth, out);
                photon.power *= left;
                photon.field = self.field_at(&tracer.acting(&fog), end, out);
                self.knots = knots;
                let left = mean(left);
                if left < FAINT && !survives(&mut photon, (left / FAINT).max(1e-3), &mut sampler, out) {
                    return;
                }
            }
            None => {
                self.carry_field(&photon, reach, hit.as_ref(), None, out);
                photon.field = self.field_at(&Medium::default(), end, out);
            }
        }
        let Some(hit) = hit.filter(|hit| hit.distance < photon.until) else {
            add(&mut out.energy.escaped, photon.power);
            return;
        };
        match *scene.material(&hit) {
            Material::Lambert { albedo } if photon.is_lit(hit.distance) => {
                self.reflect(photon, albedo, &hit, &mut sampler, depth, out);
            }
            Material::Dielectric { .. } => self.cross(photon, &hit, sampler, depth, out),
            ref material => {
                // Its weight now is what it is to weigh: what it is worth then decides whether it goes on.
                photon.unit = inverse(photon.power);
                if tracer.interact(&mut photon, &hit, &mut sampler, self.record, out) {
                    match material {
                        Material::Clear => self.wait((photon, sampler, depth + 1), out),
                        _ => self.follow_if_worth_it(photon, sampler, depth, out),
                    }
                }
            }
        }
    }

    /// The only way that a photon can go. Light that is held in glass or between mirrors fades from piece to piece: what is faint goes on if it is
    /// worth it. What glass makes of it is not known, so that none comes out brighter than a faint path.
    fn follow_if_worth_it(
        &mut self,
        mut photon: Photon,
        mut sampler: PathSampler,
        depth: u32,
        out: &mut PhotonRecord,
    ) {
        let power = mean(photon.power);
        let mut chance = power / (FAINT * mean(self.power));
        if chance < 1.0 {
            let Photon { origin, direction, bounces, .. } = photon;
            let (scene, fogs) = (self.tracer.scene, &self.tracer.fogs);
            let worth = self.guidance.of_ray(scene, fogs, origin, direction, &photon.interior, bounces);
            chance = chance.max(power * worth / self.unit(depth));
        }
        if chance >= 1.0 || survives(&mut photon, chance, &mut sampler, out) {
            self.wait((photon, sampler, depth + 1), out);
        }
    }

    /// Follows a path later, in parts where it has more power than it may.
    fn wait(&mut self, path: (Photon, PathSampler, u32), out: &mut PhotonRecord) {
        let (mut photon, mut sampler, depth) = path;
        if self.tracer.is_spent(&photon, out) {
            return;
        }
        let parts = weight::parts((photon.power * self.most(photon.origin, depth)).max_element());
        photon.power /= parts as f32;
        self.waiting.extend((1..parts).map(|_| (photon.clone(), sampler.branch(), depth)));
        self.waiting.push((photon, sampler, depth));
    }

    /// The light field's segment, and its deposit in the medium.
    fn carry_field(
        &mut self,
        photon: &Photon,
        length: f32,
        hit: Option<&Hit>,
        inside: Option<(u32, &Medium, &Column)>,
        out: &mut PhotonRecord,
    ) {
        let Some(field) = photon.field else {
            self.segment = None;
            return;
        };
        let start = Instant::now();
        let segment = self.tracer.field_segment(photon, field, length, hit);
        let lit = inside.and_then(|(id, fog, column)| {
            Some((id, photon.lit_segment(segment, fog, &self.tracer.acting(fog), column)?))
        });
        self.tracer.deposit(lit, out);
        self.segment = Some(segment);
        out.field_time += start.elapsed();
    }

    fn field_at(&self, fog: &Medium, distance: f32, out: &mut PhotonRecord) -> Option<covbeam::LightField> {
        let segment = self.segment.as_ref()?;
        let start = Instant::now();
        let field = segment.with(Column::Uniform).field_at(fog, distance);
        out.field_time += start.elapsed();
        Some(field)
    }

    /// What the medium scatters on a segment: as many collisions as that is worth, spread over what is lost.
    #[allow(clippy::too_many_arguments)]
    fn scatter(
        &mut self,
        photon: &Photon,
        fog: &Medium,
        column: &Column,
        [reach, visible]: [f32; 2],
        sampler: &mut PathSampler,
        depth: u32,
        out: &mut PhotonRecord,
    ) {
        let gone = Vec3::ONE - fog.transmittance(column.at(reach));
        let extinction = fog.extinction();
        let albedo = fog.scattering / extinction.max(Vec3::splat(f32::MIN_POSITIVE));
        let scattered = photon.power * gone * albedo;
        add(&mut out.energy.medium, photon.power * gone - scattered);
        if !(scattered.max_element() > 0.0) {
            return;
        }
        if !self.tracer.scene.allows(photon.bounces + 1) {
            add(&mut out.energy.spent, scattered);
            return;
        }
        let importance = self.guidance.importance();
        let dark = photon.dark.min(visible);
        let from = photon.origin + dark * photon.direction;
        let found = importance.of_segment(fog, from, photon.direction, visible - dark);
        // What is lost, by the most that a collision may have of it: with the sum of the channels none of them has more.
        let lost = photon.power * gone * self.most(photon.origin, depth);
        let expected = (mean(photon.power) * found.scattered / self.unit(depth))
            .max(LEAST * gone.max_element())
            .min(MOST)
            .max(lost.element_sum() * albedo.max_element());
        let count = (expected + sampler.uniform()).floor();
        let shift = sampler.uniform();
        add(&mut out.energy.roulette, scattered);
        // Collisions are placed by the mixture of the channels' densities.
        let lost = lost / lost.element_sum();
        for collision in 0..count as u32 {
            let mut sampler = sampler.branch();
            let (channel, _) = channel(lost, sampler.uniform());
            let u = ((collision as f32 + shift) / count).min(1.0 - f32::EPSILON);
            let target = -(-u * gone[channel]).ln_1p() / extinction[channel];
            let distance = column.distance_at(target);
            if !(distance < reach && distance >= photon.dark) {
                continue;
            }
            let density = extinction * fog.transmittance(target);
            let drawn = (lost * density / gone.max(Vec3::splat(f32::MIN_POSITIVE))).element_sum();
            let mut child = photon.clone();
            child.power = photon.power * albedo * density / (drawn * expected);
            child.origin = photon.origin + distance * photon.direction;
            if !self.keeps_field(&mut child, &mut sampler) {
                continue;
            }
            if child.field.is_some() {
                child.field = self.field_at(&self.tracer.acting(fog), distance, out);
            }
            child.normal = Vec3::ZERO;
            child.direct = false;
            child.specular = false;
            child.bounces += 1;
            child.begin();
            let direction =
                |xi| Candidate { direction: fog.phase.sample(photon.direction, xi), origin: child.origin };
            let blur = match self.tracer.acts(Operator::Scattering) {
                true => fog.phase.angular_variance(),
                false => f32::INFINITY,
            };
            self.go_on(&child, &mut sampler, direction, depth, out, |field, direction| {
                field.scatter(direction, blur);
            });
        }
    }

    /// A diffuse surface.
    fn reflect(
        &mut self,
        mut photon: Photon,
        albedo: Vec3,
        hit: &Hit,
        sampler: &mut PathSampler,
        depth: u32,
        out: &mut PhotonRecord,
    ) {
        let normal = facing_normal(hit, photon.direction);
        photon.arrive(self.tracer.scene, hit, normal, self.record, out);
        let reflected = photon.power * albedo;
        add(&mut out.energy.surfaces, photon.power - reflected);
        if !(reflected.max_element() > 0.0) {
            return;
        }
        if !self.tracer.scene.allows(photon.bounces + 1) {
            add(&mut out.energy.spent, reflected);
            return;
        }
        add(&mut out.energy.roulette, reflected);
        if !self.keeps_field(&mut photon, sampler) {
            return;
        }
        photon.power = reflected;
        photon.origin = hit.position;
        photon.normal = normal;
        photon.direct = false;
        photon.specular = false;
        photon.bounces += 1;
        photon.begin();
        let direction = |xi| {
            let direction = cosine_direction(normal, xi);
            Candidate { direction, origin: hit.leave(direction) }
        };
        self.go_on(&photon, sampler, direction, depth, out, |field, direction| {
            field.diffuse(normal, direction);
        });
    }

    /// Glass and water: what is reflected and what goes through, both of them where both are worth it. Neither is less likely than its share.
    fn cross(
        &mut self,
        photon: Photon,
        hit: &Hit,
        mut sampler: PathSampler,
        depth: u32,
        out: &mut PhotonRecord,
    ) {
        let tracer = self.tracer;
        let boundary = Boundary::new(tracer.scene, hit, photon.direction, &photon.interior);
        let Some(refracted) = boundary.refracted.filter(|_| boundary.reflectance > 0.0) else {
            let mut photon = photon;
            if tracer.cross(&mut photon, hit, &boundary, boundary.refracted, out) {
                match boundary.refracted {
                    Some(_) => self.wait((photon, sampler, depth + 1), out),
                    None => self.follow_if_worth_it(photon, sampler, depth, out),
                }
            }
            return;
        };
        if !(boundary.is_matched() || photon.is_lit(hit.distance)) {
            add(&mut out.energy.surfaces, photon.power);
            return;
        }
        let ways = [
            (boundary.reflectance, None, boundary.reflected, photon.interior),
            (1.0 - boundary.reflectance, Some(refracted), refracted, boundary.beyond),
        ];
        let (unit, most) = (self.unit(depth), self.most(hit.position, depth));
        let mut factors = ways.map(|(share, _, direction, interior)| {
            let origin = hit.leave(direction);
            let bounces = photon.bounces + 1;
            let worth =
                self.guidance.of_ray(tracer.scene, &tracer.fogs, origin, direction, &interior, bounces);
            let power = share * mean(photon.power);
            let excess = (share * photon.power * most).max_element();
            (power * worth / unit).max(excess).clamp(share, 1.0)
        });
        weight_window(&mut factors, sampler.uniform());
        let branch = sampler.branch();
        // The low-discrepancy numbers are for the larger share.
        let samplers = if boundary.reflectance < 0.5 { [branch, sampler] } else { [sampler, branch] };
        add(&mut out.energy.roulette, photon.power);
        for (((share, through, ..), factor), sampler) in ways.into_iter().zip(factors).zip(samplers) {
            if factor > 0.0 {
                let mut child = photon.clone();
                child.power *= share * factor;
                add(&mut out.energy.roulette, -child.power);
                if tracer.cross(&mut child, hit, &boundary, through, out) {
                    self.wait((child, sampler, depth + 1), out);
                }
            }
        }
    }

    /// Draws directions for a photon that is scattered, and keeps those that are worth it: `turn` turns its light field into one.
    fn go_on(
        &mut self,
        photon: &Photon,
        sampler: &mut PathSampler,
        direction: impl Fn([f32; 2]) -> Candidate,
        depth: u32,
        out: &mut PhotonRecord,
        turn: impl Fn(&mut covbeam::LightField, Vec3),
    ) {
        let (unit, most) = (self.unit(depth), self.most(photon.origin, depth));
        let excess = (photon.power * most).max_element();
        let here = self.guidance.importance().at(photon.origin).scattered;
        let expected = CANDIDATES * mean(photon.power) * here / unit;
        let chance = expected.max(LEAST).max(excess).min(1.0);
        if sampler.uniform() >= chance {
            return;
        }
        // Each candidate goes on once at most, so that there are as many as the power asks for.
        let count = expected.min(MOST).max(excess).max(1.0).ceil().min(1e6) as usize;
        let power = photon.power / (chance * count as f32);
        let shift = sampler.uniform_pair();
        let candidates: SmallVec<[Candidate; 8]> =
            (0..count).map(|index| direction(spread(shift, index))).collect();
        let worth = |candidate: &Candidate| {
            let Candidate { direction, origin } = *candidate;
            let tracer = self.tracer;
            let Photon { interior, bounces, .. } = photon;
            self.guidance.of_ray(tracer.scene, &tracer.fogs, origin, direction, interior, *bounces)
        };
        let mut factors: SmallVec<[f32; 8]> = candidates.iter().map(worth).collect();
        let granted = FOR_GRANTED * factors.iter().sum::<f32>() / count as f32;
        let least = (LEAST / count as f32).max((power * most).max_element());
        let number = |worth: f32| (mean(power) * (worth + granted) / unit).max(least).min(1.0);
        factors.iter_mut().for_each(|worth| *worth = number(*worth));
        weight_window(&mut factors, sampler.uniform());
        for (candidate, factor) in candidates.iter().zip(factors) {
            if factor > 0.0 {
                let mut child = photon.clone();
                child.power = power * factor;
                child.direction = candidate.direction;
                child.origin = candidate.origin;
                if let Some(field) = &mut child.field {
                    turn(field, candidate.direction);
                }
                add(&mut out.energy.roulette, -child.power);
                let sampler = sampler.branch();
                self.wait((child, sampler, depth + 1), out);
            }
        }
    }

    /// Drops the light field of most photons that are about to be scattered for the first time. False = without one the path is not wanted.
    fn keeps_field(&self, photon: &mut Photon, sampler: &mut PathSampler) -> bool {
        if photon.field.is_none() || !photon.specular {
            return true;
        }
        if sampler.uniform() < SCATTERED_FIELDS {
            photon.stands_for /= SCATTERED_FIELDS;
        } else {
            photon.field = None;
        }
        photon.field.is_some() || self.record != Record::Field
    }
}

/// Ends a photon with a probability of 1 - `chance`, or makes up for the others that it ends.
fn survives(photon: &mut Photon, chance: f32, sampler: &mut PathSampler, out: &mut PhotonRecord) -> bool {
    let before = photon.power;
    let lives = sampler.uniform() < chance;
    photon.power = if lives { before / chance } else { Vec3::ZERO };
    add(&mut out.energy.roulette, before - photon.power);
    lives
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pilot::of_still;
    use crate::random::Emission;
    use crate::scene::Scene;
    use crate::scene::made::{BOUND, Made, camera, cuboid, lambert, point, rectangle, sphere, spot};
    use crate::scene::media;

    const PATHS: u32 = 2000;

    fn tracer(scene: &Scene) -> PhotonTracer<'_> {
        let fogs = media::all(scene);
        let mut tracer = PhotonTracer::new(scene, 0, Emission::LowDiscrepancy);
        tracer.guide(of_still(scene, &fogs).expect("light"));
        tracer
    }

    /// All paths of a scene.
    fn trace_all(scene: &Scene) -> PhotonRecord {
        let tracer = tracer(scene);
        let mut record = PhotonRecord::default();
        (0..PATHS).for_each(|index| tracer.trace(0, index, PATHS, Record::Beams, &mut record));
        record
    }

    /// Beams of all paths, and most of one.
    fn beams(scene: &Scene) -> [usize; 2] {
        let tracer = tracer(scene);
        let of_path = |index| {
            let mut record = PhotonRecord::default();
            tracer.trace(0, index, PATHS, Record::Beams, &mut record);
            record.beams.len()
        };
        (0..PATHS).map(of_path).fold([0, 0], |[all, most], beams| [all + beams, most.max(beams)])
    }

    /// Of thin fog six beams a path on average; and where a path may have 20 times the mean power, a twentieth of the paths go on for 64 events
    /// and are ended then, one in 20 at each: 4.2. In dense fog large trees are rarer than 64 trial paths can tell: ten times as many.
    #[test]
    fn paths_end_where_nothing_is_absorbed() {
        let fog = |scattering: f32| {
            Made::new(camera([0.0, 0.0, -3.0], [0.0; 3], 40.0, [48, 32]))
                .fog(scattering, 0.0)
                .light(point([2.5, 2.0, -1.0], 10.0))
        };
        let spot = spot([0.0, 3.0, 0.0], [0.0; 3], 60.0, [9.0, 10.0]);
        let floor = rectangle([-5.0, -1.0, -8.0], [0.0, 0.0, 14.0], [10.0, 0.0, 0.0]);
        let room = |scattering| fog(scattering).in_fog().object(cuboid([-4.0; 3], [4.0; 3]), lambert(1.0));
        for (name, bound, made) in [
            ("endless", 10.2, fog(0.06).in_fog().object(floor, lambert(0.4)).light(spot)),
            ("nothing but fog", 10.2, fog(0.06).in_fog()),
            ("white room", 60.0, room(1.0)),
            ("dense white room", 60.0, room(20.0)),
            ("milk", 60.0, fog(2000.0).filled(sphere([0.0; 3], 0.8), BOUND, 0)),
        ] {
            let [all, most] = beams(&made.scene());
            let mean = all as f32 / PATHS as f32;
            println!("{name}: {mean:.1} a path, {most} at most");
            assert!(mean < bound, "{name}: {mean}");
            assert!(most < 64 * LARGE_TREE as usize, "{name}: {most}");
        }
    }

    /// All that the camera sees is what water reflects at 45°: by Fresnel's equations .0502 of the lamp's light (R_s = .0920, R_p = R_s²). It is
    /// in photons of a twentieth of the lamp's, as many as there are paths, and none of it is lost.
    #[test]
    fn what_glass_reflects_is_followed_where_that_is_all_there_is_to_see() {
        let scene = Made::new(camera([0.0, 3.0, 0.0], [4.0, 3.0, 0.0], 60.0, [48, 48]))
            .object(cuboid([-9.0; 3], [9.0, 0.0, 9.0]), Material::Dielectric { index: 1.5 })
            .object(rectangle([-8.0, -1.0, -8.0], [0.0, 0.0, 16.0], [16.0, 0.0, 0.0]), Material::Black)
            .object(rectangle([4.0, 0.5, -6.0], [0.0, 6.0, 0.0], [0.0, 0.0, 12.0]), lambert(0.5))
            .light(spot([-2.0, 2.0, 0.0], [0.0; 3], 100.0, [1.0, 2.0]))
            .scene();
        let record = trace_all(&scene);
        let caustic: Vec<f32> =
            record.surface.iter().filter(|photon| photon.caustic).map(|photon| mean(photon.power)).collect();
        let flux = caustic.iter().sum::<f32>() / record.energy.emitted[0] as f32;
        println!("{} photons, {flux}", caustic.len());
        assert!(caustic.len() > PATHS as usize * 3 / 4, "{}", caustic.len());
        // Within the cone R is within a fifth of that at its middle, on average as much: 2000 paths say it to half a percent.
        assert!((flux / 0.0502 - 1.0).abs() < 0.02, "{flux}");
    }

    /// A ball of milk in fog. What its skin holds by total reflection fades from piece to piece, and would be half of all beams of the milk, of
    /// nearly no power: they would take the branches that light outside of it needs.
    #[test]
    fn light_that_glass_holds_ends_where_it_is_worth_nothing() {
        let scene = Made::new(camera([0.0, 0.0, -3.0], [0.0; 3], 40.0, [48, 48]))
            .fog(0.5, 0.1)
            .fog(7.0, 4.0)
            .in_fog()
            .filled(sphere([0.0; 3], 0.1), Material::Dielectric { index: 1.7 }, 1)
            .object(cuboid([-4.0; 3], [4.0; 3]), Material::Black)
            .light(spot([0.4, 0.8, -0.2], [0.0; 3], 100.0, [6.0, 7.0]))
            .scene();
        let record = trace_all(&scene);
        let mean_power = mean(scene.lights[0].flux()) / PATHS as f32;
        let held: Vec<f32> =
            record.beams.iter().filter(|path| path.medium == 1).map(|path| mean(path.beam.power)).collect();
        let faint = held.iter().filter(|power| **power < 1e-6 * mean_power).count();
        println!("{} beams of milk, {faint} of them faint", held.len());
        assert!(held.len() > 1000, "{}", held.len());
        assert!(faint < held.len() / 100, "{faint} of {}", held.len());
    }
}
