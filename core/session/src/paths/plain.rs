//! Plain light paths: one way on from each event, drawn as their power goes.

use crate::paths::emission::{Lights, choose_light};
use crate::paths::events::{Ways, scattered};
use crate::paths::photon::Photon;
use crate::paths::record::{PhotonRecord, Record, add, scaled};
use crate::paths::scattering::Scattering;
use crate::paths::segment::{Inside, PathSegment};
use crate::paths::transport::Transport;
use crate::paths::weight::{self, LONG_PATH};
use crate::random::PathSampler;
use covbeam::{Knot, Medium};
use covbeam_geometry::hit::Hit;

/// What one path needs.
struct Walk<'w, 'a> {
    transport: &'w Transport<'a>,
    record: Record,
    /// Parts of it that wait.
    waiting: Vec<(Photon, PathSampler)>,
}

/// Where an event is.
#[derive(Clone, Copy)]
enum Event<'e> {
    /// A collision, where the photon is.
    Collision(&'e Medium<'e>),
    Surface(&'e Hit),
}

/// Traces a path from its light to its end; its power is divided by `paths`.
pub(super) fn trace(
    transport: &Transport,
    lights: &Lights,
    mut sampler: PathSampler,
    paths: u32,
    record: Record,
    out: &mut PhotonRecord,
) {
    let (light, share) = choose_light(&lights.cumulative, &mut sampler);
    let emitted = transport.scene.lights[light].emit(&mut sampler);
    let power = emitted.power / (share * paths as f32);
    let Some(photon) = lights.start(transport, light, &emitted, power, (record, &mut sampler), out) else {
        return;
    };
    if record == Record::Connections {
        transport.connect_start(&photon, out);
    }
    let mut walk = Walk { transport, record, waiting: Vec::new() };
    let mut knots = Vec::new();
    let mut path = Some((photon, sampler));
    while let Some((photon, sampler)) = path {
        walk.follow(photon, sampler, &mut knots, out);
        path = walk.waiting.pop();
    }
}

impl Walk<'_, '_> {
    /// A path to its end, but for parts of it, which wait. `knots` is memory for the columns of its segments.
    fn follow(
        &mut self,
        mut photon: Photon,
        mut sampler: PathSampler,
        knots: &mut Vec<Knot>,
        out: &mut PhotonRecord,
    ) {
        let Transport { scene, ref limits, .. } = *self.transport;
        loop {
            photon.events += 1;
            let goes_on = self.step(&mut photon, &mut sampler, knots, out);
            // Straight light goes on through bounds of fog that is placed.
            let is_done = self.record == Record::Direct && !(photon.direct && scene.placed.is_some());
            if !goes_on || is_done || photon.is_spent(scene, out) {
                return;
            }
            if photon.events > LONG_PATH {
                let limit = limits.at(photon.origin, photon.events);
                if photon.survive_by_weight(limit, sampler.uniform(), out).is_none() {
                    return;
                }
            }
        }
    }

    /// One segment and the event at its end. False = the path has ended.
    fn step(
        &mut self,
        photon: &mut Photon,
        sampler: &mut PathSampler,
        knots: &mut Vec<Knot>,
        out: &mut PhotonRecord,
    ) -> bool {
        let transport = self.transport;
        let segment = transport.segment(photon, knots);
        if self.record.has_beams() && photon.is_seen_in_fog(transport.scene) {
            photon.leave_beams(&segment, out);
        } else if self.record == Record::Connections && photon.is_seen_in_fog(transport.scene) {
            transport.connect_segment(photon, &segment, sampler, out);
        }
        let weights = photon.weights() / transport.limits.at(photon.origin, photon.events);
        // The medium, the column up to a collision, and how far that is.
        let flight =
            segment.inside.as_ref().filter(|inside| inside.scatters && inside.dims()).map(|inside| {
                let column = weight::free_column(weights, inside.fog, sampler);
                (inside, column, inside.column.distance_at(column))
            });
        let distance = flight.map_or(f32::INFINITY, |(.., distance)| distance);
        if let Some(field) = transport.carry_field(photon, &segment, out) {
            photon.field = Some(field.at(distance.min(segment.reach), out));
        }
        if let Some((inside, column, distance)) = flight {
            let is_collision = distance < segment.reach;
            if is_collision && !photon.is_lit(distance) {
                let is_dark = distance < photon.dark;
                add(if is_dark { &mut out.energy.medium } else { &mut out.energy.escaped }, photon.power);
                return false;
            }
            let factor = match is_collision {
                true => weight::of_collision(weights, inside.fog, column),
                false => weight::of_passage(weights, inside.fog, inside.column.at(segment.reach)),
            };
            photon.power = scaled(photon.power, factor, &mut out.energy.roulette);
            if is_collision {
                photon.go(distance);
                return self.split(photon, Event::Collision(inside.fog), sampler, out);
            }
        }
        if let Some(inside) = segment.inside.as_ref().filter(|inside| !(inside.scatters && inside.dims())) {
            if inside.scatters {
                self.scatter_undimmed(photon, inside, &segment, sampler, out);
            }
            photon.power = scaled(photon.power, inside.left(segment.reach), &mut out.energy.medium);
        }
        let Some(hit) = segment.met(photon, out) else { return false };
        if let Some(passing) = transport.divide(photon, hit, out) {
            self.waiting.push((passing, sampler.branch()));
        }
        self.split(photon, Event::Surface(hit), sampler, out)
    }

    /// What a medium scatters that takes nothing of the light which goes on: drawn evenly over its column.
    fn scatter_undimmed(
        &mut self,
        photon: &Photon,
        inside: &Inside,
        segment: &PathSegment,
        sampler: &mut PathSampler,
        out: &mut PhotonRecord,
    ) {
        let (mut part, mut sampler) = (photon.clone(), sampler.branch());
        let [from, to] = [photon.dark, photon.until].map(|end| inside.column.at(end.min(segment.reach)));
        let column = from + sampler.uniform() * (to - from);
        let distance = inside.column.distance_at(column);
        part.power *= inside.fog.extinction() * (to - from) * inside.lit(distance);
        if !(part.power.max_element() > 0.0 && distance < segment.reach) {
            return;
        }
        add(&mut out.energy.roulette, -part.power);
        part.go(distance);
        if self.split(&mut part, Event::Collision(inside.fog), &mut sampler, out)
            && !part.is_spent(self.transport.scene, out)
        {
            self.waiting.push((part, sampler));
        }
    }

    /// Divides a photon that weighs more than it may at an event, and lets all parts meet what is there. All
    /// but the first wait then. False = the first has ended.
    fn split(
        &mut self,
        photon: &mut Photon,
        at: Event,
        sampler: &mut PathSampler,
        out: &mut PhotonRecord,
    ) -> bool {
        let place = match at {
            Event::Collision(_) => photon.origin,
            Event::Surface(hit) => hit.position,
        };
        let limit = weight::CHANNELS * self.transport.limits.at(place, photon.events);
        let parts = weight::parts((photon.weights() / limit).max_element());
        photon.power /= parts as f32;
        for _ in 1..parts {
            let (mut part, mut sampler) = (photon.clone(), sampler.branch());
            if self.meet(&mut part, at, &mut sampler, out) && !part.is_spent(self.transport.scene, out) {
                self.waiting.push((part, sampler));
            }
        }
        self.meet(photon, at, sampler, out)
    }

    /// What a photon does at an event. False = it has ended.
    fn meet(
        &self,
        photon: &mut Photon,
        at: Event,
        sampler: &mut PathSampler,
        out: &mut PhotonRecord,
    ) -> bool {
        let transport = self.transport;
        let hit = match at {
            Event::Collision(fog) => {
                let collision = transport.collision(fog, photon.direction, photon.origin);
                photon.power = scattered(fog, photon.power, out);
                return self.scatter(photon, &collision, sampler, out);
            }
            Event::Surface(hit) => hit,
        };
        match transport.meet(photon, hit, sampler, self.record, out) {
            Ways::Nowhere => false,
            Ways::Straight | Ways::One => true,
            Ways::Scattered(by) => self.scatter(photon, &by, sampler, out),
            Ways::Glass(boundary) => {
                let goes_through = sampler.uniform() >= boundary.reflectance;
                let through = goes_through.then_some(boundary.refracted).flatten();
                transport.cross(photon, hit, &boundary, through);
                true
            }
        }
    }

    /// One direction, if it goes on. False = it does not.
    fn scatter(
        &self,
        photon: &mut Photon,
        by: &Scattering,
        sampler: &mut PathSampler,
        out: &mut PhotonRecord,
    ) -> bool {
        let [u, v] = sampler.uniform_pair();
        let limit = self.transport.limits.at(by.place(), photon.events);
        let Some(u) = photon.survive_by_weight(limit, u, out) else { return false };
        let direction = by.direction([u, v]);
        photon.power = scaled(photon.power, by.weight(direction), &mut out.energy.roulette);
        photon.scatter(self.transport.scene, by, direction);
        true
    }
}
