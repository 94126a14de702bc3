//! Light paths that go where the picture needs them: emitted, split and ended so that power x importance is
//! about the same for all.
//!
//! A path is a tree. Whatever is certain is not left to chance: what passes a medium goes on with what is
//! left of it, and what the medium scatters is drawn as often as that is worth. Where light scatters, several
//! directions are looked at, and those go on that are worth it.

mod collisions;
mod directions;
mod glass;
mod lobes;

use crate::color::mean;
use crate::paths::emission::{Lights, choose_light};
use crate::paths::events::Ways;
use crate::paths::guidance::{Guidance, of_ray};
use crate::paths::photon::Photon;
use crate::paths::record::{PhotonRecord, Record, add};
use crate::paths::transport::Transport;
use crate::paths::weight::{self, inverse, patience};
use crate::random::PathSampler;
use crate::scene::bounces::Bounce;
use covbeam::Knot;
use glam::Vec3;

/// Most directions, and most collisions on a segment.
const MOST: f32 = 64.0;

/// Nothing goes on with less than this probability, so that what is worth more than it seems is not worth a
/// tenfold surprise.
const LEAST: f32 = 0.1;

/// And nothing with more than so many times the power that a path has on average, in any channel, or its
/// [`Limits`](weight::Limits) if these are more far out; of long paths as many times more as they may weigh.
pub(super) const MOST_POWER: f32 = 20.0;

/// Paths of which less than this is left behind a medium are thinned out; and those with less than this of a
/// path's mean power that only one way is left to.
const FAINT: f32 = 0.1;

/// With every so many segments of one tree twice as much is asked of its next branches: where importance
/// seems to grow a thousandfold along each path, as inside a ball of milk, a tree would have millions. Those
/// of plain scenes have a few hundred at most.
const LARGE_TREE: u32 = 1024;

/// What one tree of paths needs.
struct Tree<'t, 'a> {
    transport: &'t Transport<'a>,
    guidance: &'t Guidance,
    /// Power x importance of each path that is not long.
    unit: f32,
    /// Mean power of a path.
    power: Vec3,
    record: Record,
    /// Segments that do not wait any more.
    followed: u32,
    waiting: Vec<Branch>,
}

/// A path of a tree, up to where it is.
struct Branch {
    photon: Photon,
    sampler: PathSampler,
    /// Events so far.
    depth: u32,
}

/// Like [`plain::trace`](crate::paths::plain::trace), with guidance.
pub(super) fn trace(
    transport: &Transport,
    lights: &Lights,
    guidance: &Guidance,
    mut sampler: PathSampler,
    paths: u32,
    record: Record,
    out: &mut PhotonRecord,
) {
    let (light, share) = choose_light(guidance.lamps(), &mut sampler);
    let (place, density) = guidance.emission(light).warp(sampler.uniform_pair());
    let emitted = transport.scene.lights[light].emit_at(place, &mut sampler);
    let power = emitted.power / (share * density * paths as f32);
    let Some(photon) = lights.start(transport, light, &emitted, power, (record, &mut sampler), out) else {
        return;
    };
    let mut tree = Tree {
        transport,
        guidance,
        unit: guidance.total() / paths as f32,
        power: lights.flux / paths as f32,
        record,
        followed: 0,
        waiting: vec![Branch { photon, sampler, depth: 0 }],
    };
    let mut knots = Vec::new();
    while let Some(branch) = tree.waiting.pop() {
        tree.follow(branch, &mut knots, out);
    }
}

impl Tree<'_, '_> {
    /// The power x importance that a path may have before it is split. What has been followed says nothing of
    /// what is drawn next, so that the light is right in the mean.
    fn unit(&self, depth: u32) -> f32 {
        let segments = self.followed + self.waiting.len() as u32;
        patience(depth) * libm::exp2f((segments / LARGE_TREE) as f32) * self.unit
    }

    /// One over the most power that a path may have in each channel.
    fn most(&self, place: Vec3, depth: u32) -> Vec3 {
        let near = Vec3::splat(MOST_POWER * patience(depth));
        inverse(self.power * self.transport.limits.at(place, depth).max(near))
    }

    /// One segment, what it scatters on its way, and the event at its end. `knots` is memory for its column.
    fn follow(&mut self, mut branch: Branch, knots: &mut Vec<Knot>, out: &mut PhotonRecord) {
        let Branch { ref mut photon, ref mut sampler, depth } = branch;
        // As much more as long paths may weigh, fewer of them there are.
        let fewer = patience(depth.saturating_sub(1)) / patience(depth);
        if fewer < 1.0 && photon.survive(fewer, sampler.uniform(), out).is_none() {
            return;
        }
        self.followed += 1;
        let transport = self.transport;
        let segment = transport.segment(photon, knots);
        if self.record.has_beams() && photon.is_seen_in_fog(transport.scene) {
            photon.leave_beams(&segment, out);
        }
        let field = transport.carry_field(photon, &segment, out);
        // What is farther away gets no light of it.
        let end = segment.reach.min(photon.until);
        let mut left = 1.0;
        if let Some(inside) = &segment.inside {
            let transmittance = inside.left(end);
            if inside.scatters {
                self.collide(&mut branch, inside, field.as_ref(), [end, end.min(inside.opaque)], out);
            } else {
                add(&mut out.energy.medium, branch.photon.power * (Vec3::ONE - transmittance));
            }
            branch.photon.power *= transmittance;
            left = mean(transmittance);
        }
        let Branch { ref mut photon, ref mut sampler, .. } = branch;
        photon.field = field.map(|field| field.at(end, out));
        if left < FAINT && photon.survive((left / FAINT).max(1e-3), sampler.uniform(), out).is_none() {
            return;
        }
        let Some(hit) = segment.met(photon, out) else { return };
        if let Some(passing) = transport.divide(photon, hit, out) {
            self.wait(Branch { photon: passing, sampler: sampler.branch(), depth }, out);
        }
        let Branch { ref mut photon, ref mut sampler, depth: _ } = branch;
        // Its weight now is what it is to weigh: what it is worth then decides whether it goes on.
        photon.unit = inverse(photon.power);
        if let Some(lobes) = self.diffuse_lobes(photon, hit) {
            return self.divide(branch, hit, &lobes, out);
        }
        match transport.meet(photon, hit, sampler, self.record, out) {
            Ways::Nowhere => {}
            Ways::Straight => self.wait(branch, out),
            Ways::One => self.follow_if_worth_it(branch, out),
            Ways::Scattered(by) => self.scatter_at(&mut branch, &by, out),
            Ways::Glass(boundary) => self.cross(branch, hit, &boundary, out),
        }
    }

    /// The only way that a photon can go. Light that is held in glass or between mirrors fades from piece to
    /// piece: what is faint goes on if it is worth it. What glass makes of it is not known, so that none
    /// comes out brighter than a faint path.
    fn follow_if_worth_it(&mut self, mut branch: Branch, out: &mut PhotonRecord) {
        let Branch { ref mut photon, ref mut sampler, depth } = branch;
        let power = mean(photon.power);
        let mut chance = power / (FAINT * mean(self.power));
        if chance < 1.0 {
            let Photon { origin, direction, ref interior, bounces, .. } = *photon;
            let Transport { scene, ref fogs, .. } = *self.transport;
            let worth =
                of_ray(scene, fogs, &self.guidance.importance(), (origin, direction), interior, bounces);
            chance = chance.max(power * worth / self.unit(depth));
        }
        if chance >= 1.0 || photon.survive(chance, sampler.uniform(), out).is_some() {
            self.wait(branch, out);
        }
    }

    /// Follows a path later, after an event, in parts where it has more power than it may.
    fn wait(&mut self, branch: Branch, out: &mut PhotonRecord) {
        let Branch { mut photon, mut sampler, depth } = branch;
        if photon.is_spent(self.transport.scene, out) {
            return;
        }
        let depth = depth + 1;
        let parts = weight::parts((photon.power * self.most(photon.origin, depth)).max_element());
        photon.power /= parts as f32;
        let part = |_| Branch { photon: photon.clone(), sampler: sampler.branch(), depth };
        self.waiting.extend((1..parts).map(part));
        self.waiting.push(Branch { photon, sampler, depth });
    }

    /// Whether anything is scattered, and may be; chance decides what of it goes on.
    ///
    /// - `power`: of all that is scattered.
    fn is_scattered(&self, photon: &Photon, bounce: Bounce, power: Vec3, out: &mut PhotonRecord) -> bool {
        if !(power.max_element() > 0.0) {
            return false;
        }
        let scene = self.transport.scene;
        let is_allowed = scene.allows(photon.bounces + 1) && photon.may_be_seen_after(scene, bounce);
        add(if is_allowed { &mut out.energy.roulette } else { &mut out.energy.spent }, power);
        is_allowed
    }
}

#[cfg(test)]
mod tests {
    use super::LARGE_TREE;
    use crate::color::mean;
    use crate::paths::{PhotonRecord, PhotonTracer, Record};
    use crate::pilot::of_still;
    use crate::random::Emission;
    use crate::scene::made::{BOUND, Made, camera, cuboid, lambert, point, rectangle, sphere, spot};
    use crate::scene::{Material, Scene, media};

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
