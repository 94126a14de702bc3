//! Light paths: from a light through media and surfaces until they are absorbed or escape.

pub mod guidance;
mod guided;
mod lit;
pub mod operators;
pub mod record;
mod weight;

use crate::kind::Kind;
use crate::lamps::LampTree;
use crate::lamps::near::Near;
use crate::light::{EmittedPhoton, cosine_direction};
use crate::paths::guidance::Guidance;
use crate::paths::operators::Operator;
use crate::paths::record::add;
pub use crate::paths::record::{Energy, FieldSegment, PathBeam, PhotonRecord, Record, Splat};
use crate::random::{Emission, PathSampler};
use crate::scene::media;
use crate::scene::optics::{Boundary, Interior, curvature_towards, facing_normal, reflect};
use crate::scene::passage::passage;
use crate::scene::{Light, Material, Scene};
use crate::surface::SurfacePhoton;
use crate::surface::encounter::{Encounter, Lobe};
use crate::surface::origin::Origin;
use covbeam::{Column, CovarianceGrid, Curvature, Density, Edges, Knot, LightField, Medium};
use covbeam_geometry::hit::Hit;
use glam::Vec3;
use std::time::Instant;
pub(crate) use weight::{GOING_ON, LONG_PATH};
use weight::{Limits, inverse};

/// Of light that goes evenly all around, what goes into a steradian.
const EVENLY: f32 = 0.25 * std::f32::consts::FRAC_1_PI;

/// Beams of a guided path, on average, at most: where each of very many scatterings matters, paths branch less than the picture would like,
/// or a pass would not end.
const MOST_BEAMS: f32 = 6.0;

/// Times that this is tried, at most.
const TRIALS: u32 = 8;

/// Paths that find out.
const TRIAL_PATHS: u32 = 64;
const TRIAL_SEQUENCE: u32 = 0x7e57;

/// Traces light paths of a scene.
pub struct PhotonTracer<'a> {
    scene: &'a Scene,
    fogs: Vec<Medium<'a>>,
    lights: Lights,
    lamps: LampTree,
    near: Near,
    camera: Origin,
    limits: Limits,
    seed: u32,
    emission: Emission,
    left_out: Option<Operator>,
    /// None: paths are drawn as their power goes.
    guidance: Option<Guidance>,
}

struct Lights {
    /// Cumulative shares of the flux.
    cumulative: Vec<f32>,
    /// Of all of them \[W\].
    flux: Vec3,
    /// Where each light is.
    origins: Vec<Origin>,
}

/// The moving photon.
#[derive(Clone)]
struct Photon {
    origin: Vec3,
    direction: Vec3,
    power: Vec3,
    /// Over the power of a path of weight 1.
    unit: Vec3,
    /// Events so far that count for its limit.
    events: u32,
    interior: Interior,
    /// Normal of the surface that it left, towards the side it is on; zero in the open.
    normal: Vec3,
    direct: bool,
    specular: bool,
    /// How often it has been scattered, reflected and refracted.
    bounces: u32,
    /// How far from here its light begins, and ends: of lamps with a size, as long as it goes straight on.
    dark: f32,
    until: f32,
    /// How far from here it is next to its lamp.
    near: f32,
    field: Option<LightField>,
    /// Paths without a light field that this one's stands for, and itself.
    stands_for: f32,
}

impl Photon {
    /// Leaves what arrives on a diffuse surface that is seen for disks there; straight light is looked up by shadow rays.
    ///
    /// - `normal`: towards the side that it comes from.
    fn arrive(&self, scene: &Scene, hit: &Hit, normal: Vec3, record: Record, out: &mut PhotonRecord) {
        let is_recorded = matches!(record, Record::Beams | Record::BeamsAndField);
        if is_recorded && !self.direct && scene.shows_surfaces() {
            let (position, power, caustic) = (hit.position, self.power, self.specular);
            out.surface.push(SurfacePhoton { position, normal, power, caustic });
        }
    }

    /// In each channel.
    fn weights(&self) -> Vec3 {
        self.power * self.unit
    }

    /// What its light has met.
    fn kind(&self) -> Kind {
        match self {
            Self { direct: true, .. } => Kind::Straight,
            Self { specular: true, .. } => Kind::Focused,
            _ => Kind::Scattered,
        }
    }
}

impl<'a> PhotonTracer<'a> {
    /// Prepares `scene`.
    pub fn new(scene: &'a Scene, seed: u32, emission: Emission) -> Self {
        let flux = scene.lights.iter().map(|light| f64::from(light.flux().element_sum()));
        let total: f64 = flux.clone().sum();
        let mut sum = 0.0;
        let shares = flux.map(|flux| {
            sum += flux / total;
            sum as f32
        });
        let origins = scene.lights.iter().map(|light| Origin::of_light(scene, light));
        let lights = Lights {
            cumulative: shares.collect(),
            flux: scene.lights.iter().map(Light::flux).sum(),
            origins: origins.collect(),
        };
        let camera = Origin::new(scene, scene.camera.position);
        Self {
            scene,
            fogs: media::all(scene),
            lamps: LampTree::new(scene),
            lights,
            near: Near::new(scene),
            camera,
            limits: Limits::new(scene),
            seed,
            emission,
            left_out: None,
            guidance: None,
        }
    }

    /// Leaves an operator out of all light fields, to see what it buys.
    pub fn leave_out(&mut self, operator: Operator) {
        self.left_out = Some(operator);
    }

    /// From now on sends light paths where the picture needs them; not those for connections with the camera.
    pub(crate) fn guide(&mut self, guidance: Guidance) {
        self.guidance = Some(guidance);
        for _ in 0..TRIALS {
            let mut record = PhotonRecord::default();
            (0..TRIAL_PATHS).for_each(|index| {
                self.trace(TRIAL_SEQUENCE, index, TRIAL_PATHS, Record::Beams, &mut record);
            });
            let excess = record.beams.len() as f32 / (TRIAL_PATHS as f32 * MOST_BEAMS);
            if let Some(guidance) = &mut self.guidance {
                guidance.coarsen(excess.max(1.0));
            }
            // Large trees are cut short, and hide how much too large they are.
            if excess < 2.0 {
                return;
            }
        }
    }

    /// Sends light paths as their power goes, as before [`PhotonTracer::guide`].
    pub(crate) fn guide_no_more(&mut self) {
        self.guidance = None;
    }

    /// Where light paths are sent, if anything says so.
    pub(crate) fn guidance(&self) -> Option<&Guidance> {
        self.guidance.as_ref()
    }

    /// Guided light paths have this many times their branches, about.
    ///
    /// - `share`: > 0.
    pub(crate) fn scale_branches(&mut self, share: f32) {
        if let Some(guidance) = &mut self.guidance {
            guidance.leave(share);
        }
    }

    /// The scene.
    pub(crate) fn scene(&self) -> &'a Scene {
        self.scene
    }

    /// The lamps that shadow rays look for.
    pub(crate) fn lamps(&self) -> &LampTree {
        &self.lamps
    }

    /// Where straight light is left to beams.
    pub(crate) fn near(&self) -> &Near {
        &self.near
    }

    fn acts(&self, operator: Operator) -> bool {
        self.left_out != Some(operator)
    }

    /// The medium as it acts on light fields.
    fn acting<'m>(&self, fog: &Medium<'m>) -> Medium<'m> {
        let density = if self.acts(Operator::Attenuation) { fog.density } else { Density::Uniform };
        Medium { density, ..*fog }
    }

    /// Adds deposits that this tracer made to a covariance grid, in their order.
    pub fn deposit_into<'d>(
        &self,
        grid: &mut CovarianceGrid,
        deposits: impl IntoIterator<Item = &'d (u32, FieldSegment)>,
    ) {
        let mut knots = Vec::new();
        for (medium, segment) in deposits {
            let fog = &self.fogs[*medium as usize];
            let FieldSegment { origin, length, ref field, .. } = *segment;
            let column = media::column(fog, origin, field.direction, length, &mut knots);
            grid.deposit(&self.acting(fog), &segment.with(column));
        }
    }

    /// Traces light path `index` of `sequence`; its power is divided by `paths`.
    pub fn trace(&self, sequence: u32, index: u32, paths: u32, record: Record, out: &mut PhotonRecord) {
        let mut sampler = PathSampler::new(self.emission, self.seed, sequence, index);
        let is_guided = matches!(record, Record::Beams | Record::BeamsAndField | Record::Field);
        if let (Some(guidance), true) = (&self.guidance, is_guided) {
            return self.trace_guided(guidance, sampler, paths, record, out);
        }
        let (light, share) = choose_light(&self.lights.cumulative, &mut sampler);
        let emitted = self.scene.lights[light].emit(&mut sampler);
        let power = emitted.power / (share * paths as f32);
        let Some(photon) = self.start(light, &emitted, power, record) else { return };
        add(&mut out.energy.emitted, photon.power);
        if !(photon.power.max_element() > 0.0) {
            return;
        }
        if record == Record::Connections && !photon.direct {
            self.connect(photon.origin, out, |_| EVENLY * photon.power);
        }
        let (mut knots, mut waiting) = (Vec::new(), Vec::new());
        let mut path = Some((photon, sampler));
        while let Some((photon, sampler)) = path {
            self.follow(photon, sampler, record, out, &mut knots, &mut waiting);
            path = waiting.pop();
        }
    }

    /// A path to its end, but for parts of it, which wait.
    fn follow(
        &self,
        mut photon: Photon,
        mut sampler: PathSampler,
        record: Record,
        out: &mut PhotonRecord,
        knots: &mut Vec<Knot>,
        waiting: &mut Vec<(Photon, PathSampler)>,
    ) {
        loop {
            photon.events += 1;
            let goes_on = self.step(&mut photon, &mut sampler, record, out, knots, waiting);
            // Straight light goes on through bounds of fog that is placed.
            let is_done = record == Record::Direct && !(photon.direct && self.scene.placed.is_some());
            if !goes_on || is_done || self.is_spent(&photon, out) {
                return;
            }
            if photon.events > LONG_PATH {
                let (power, u) = (photon.power, sampler.uniform());
                let limit = self.limits.at(photon.origin, photon.events);
                if roulette(&mut photon, power, limit, u, out).is_none() {
                    return;
                }
            }
        }
    }

    /// Divides a photon that weighs more than it may at a place, and lets all parts but the first meet what is there.
    fn split(
        &self,
        photon: &mut Photon,
        place: Vec3,
        sampler: &mut PathSampler,
        waiting: &mut Vec<(Photon, PathSampler)>,
        out: &mut PhotonRecord,
        mut meet: impl FnMut(&mut Photon, &mut PathSampler, &mut PhotonRecord) -> bool,
    ) {
        let limit = weight::CHANNELS * self.limits.at(place, photon.events);
        let parts = weight::parts((photon.weights() / limit).max_element());
        photon.power /= parts as f32;
        for _ in 1..parts {
            let (mut part, mut sampler) = (photon.clone(), sampler.branch());
            if meet(&mut part, &mut sampler, out) && !self.is_spent(&part, out) {
                waiting.push((part, sampler));
            }
        }
    }

    /// Whether a photon has bounced more often than it may; it is lost then.
    fn is_spent(&self, photon: &Photon, out: &mut PhotonRecord) -> bool {
        let is_spent = !self.scene.allows(photon.bounces);
        if is_spent {
            add(&mut out.energy.spent, photon.power);
        }
        is_spent
    }

    /// A photon that leaves a light; None: the light is not there, or none of it is recorded.
    fn start(&self, light: usize, emitted: &EmittedPhoton, power: Vec3, record: Record) -> Option<Photon> {
        let source = &self.scene.lights[light];
        let is_straight = source.is_straight();
        if record == Record::Direct && !is_straight {
            return None;
        }
        let (origin, interior) = self.lights.origins[light].of_photon(self.scene, source, emitted)?;
        Some(Photon {
            origin,
            direction: emitted.direction,
            power,
            unit: inverse(power),
            events: 0,
            interior,
            normal: emitted.normal,
            direct: is_straight,
            specular: is_straight,
            bounces: 0,
            dark: emitted.dark,
            until: emitted.until,
            near: self.near.reach(light),
            field: self.start_field(light, emitted, record),
            stands_for: 1.0,
        })
    }

    fn start_field(&self, light: usize, emitted: &EmittedPhoton, record: Record) -> Option<LightField> {
        matches!(record, Record::BeamsAndField | Record::Field | Record::Direct).then(|| {
            match self.acts(Operator::Emission) {
                true => self.scene.lights[light].light_field(emitted),
                false => LightField::point(emitted.direction, 0.0),
            }
        })
    }

    /// One segment and the event at its end. False = the path has ended. `knots` is memory for the segment's column.
    fn step(
        &self,
        photon: &mut Photon,
        sampler: &mut PathSampler,
        record: Record,
        out: &mut PhotonRecord,
        knots: &mut Vec<Knot>,
        waiting: &mut Vec<(Photon, PathSampler)>,
    ) -> bool {
        let scene = self.scene;
        let hit = scene.intersect(photon.origin, photon.direction, f32::INFINITY);
        let reach = hit.map_or(f32::INFINITY, |hit| hit.distance);
        let inside = photon.interior.medium(scene).map(|id| {
            let fog = &self.fogs[id as usize];
            (id, fog, media::column(fog, photon.origin, photon.direction, reach, knots))
        });
        if let Some((id, fog, column)) = &inside {
            match record {
                Record::Beams | Record::BeamsAndField => {
                    out.beams.extend(photon.beam(*id, hit.as_ref(), fog, column));
                }
                Record::Connections => {
                    self.connect_segment(photon, reach.min(photon.until), fog, column, sampler, out);
                }
                Record::Field | Record::Direct => {}
            }
        }
        let weights = photon.weights() / self.limits.at(photon.origin, photon.events);
        let collision = inside.map(|(_, fog, column)| {
            let target = weight::free_column(weights, fog, sampler);
            (target, column.distance_at(target))
        });
        let flight = collision.map_or(f32::INFINITY, |(_, distance)| distance);
        if let Some(field) = photon.field {
            let start = Instant::now();
            let length = inside.map_or(reach, |(_, fog, column)| {
                reach.min(media::opaque_distance(fog, photon.origin, photon.direction, &column))
            });
            let segment = self.field_segment(photon, field, length, hit.as_ref());
            let fog = inside.map_or(Medium::default(), |(_, fog, _)| self.acting(fog));
            let lit = inside
                .and_then(|(id, own, column)| Some((id, photon.lit_segment(segment, own, &fog, &column)?)));
            self.deposit(lit, out);
            photon.field = Some(segment.with(Column::Uniform).field_at(&fog, flight.min(reach)));
            out.field_time += start.elapsed();
        }
        if let (Some((_, fog, column)), Some((target, _))) = (inside, collision) {
            if flight < reach {
                if !photon.is_lit(flight) {
                    let energy = &mut out.energy;
                    let lost = if flight < photon.dark { &mut energy.medium } else { &mut energy.escaped };
                    add(lost, photon.power);
                    return false;
                }
                photon.origin += flight * photon.direction;
                let before = photon.power;
                photon.power *= weight::of_collision(weights, fog, target);
                add(&mut out.energy.roulette, before - photon.power);
                let place = photon.origin;
                self.split(photon, place, sampler, waiting, out, |part, sampler, out| {
                    self.scatter(part, fog, sampler, out)
                });
                return self.scatter(photon, fog, sampler, out);
            }
            let before = photon.power;
            photon.power *= weight::of_passage(weights, fog, column.at(reach));
            add(&mut out.energy.roulette, before - photon.power);
        }
        match hit {
            Some(hit) if reach < photon.until => {
                self.split(photon, hit.position, sampler, waiting, out, |part, sampler, out| {
                    self.interact(part, &hit, sampler, record, out)
                });
                self.interact(photon, &hit, sampler, record, out)
            }
            _ => {
                add(&mut out.energy.escaped, photon.power);
                false
            }
        }
    }

    /// A collision at the photon's origin.
    fn scatter(
        &self,
        photon: &mut Photon,
        medium: &Medium,
        sampler: &mut PathSampler,
        out: &mut PhotonRecord,
    ) -> bool {
        let before = photon.power;
        let scattered =
            before * (medium.scattering / medium.extinction().max(Vec3::splat(f32::MIN_POSITIVE)));
        add(&mut out.energy.medium, before - scattered);
        let [u, v] = sampler.uniform_pair();
        let limit = self.limits.at(photon.origin, photon.events);
        let Some(u) = roulette(photon, scattered, limit, u, out) else { return false };
        let direction = medium.phase.sample(photon.direction, [u, v]);
        if let Some(field) = &mut photon.field {
            let blurs = self.acts(Operator::Scattering);
            field.scatter(direction, if blurs { medium.phase.angular_variance() } else { f32::INFINITY });
        }
        photon.direction = direction;
        photon.normal = Vec3::ZERO;
        photon.direct = false;
        photon.specular = false;
        photon.bounces += 1;
        photon.begin();
        true
    }

    fn interact(
        &self,
        photon: &mut Photon,
        hit: &Hit,
        sampler: &mut PathSampler,
        record: Record,
        out: &mut PhotonRecord,
    ) -> bool {
        let mut stays_straight = false;
        let is_lit = photon.is_lit(hit.distance);
        match *self.scene.material(hit) {
            Material::Clear => {
                self.go_straight_on(photon, hit);
                return true;
            }
            Material::Lambert { albedo } if is_lit => {
                let normal = facing_normal(hit, photon.direction);
                photon.arrive(self.scene, hit, normal, record, out);
                let before = photon.power;
                let reflected = before * albedo;
                add(&mut out.energy.surfaces, before - reflected);
                if record == Record::Connections && self.scene.shows_surfaces() {
                    let factor = reflected * std::f32::consts::FRAC_1_PI;
                    self.connect(hit.leave(normal), out, |to_camera| factor * to_camera.dot(normal).max(0.0));
                }
                let [u, v] = sampler.uniform_pair();
                let limit = self.limits.at(hit.position, photon.events);
                let Some(u) = roulette(photon, reflected, limit, u, out) else { return false };
                let direction = cosine_direction(normal, [u, v]);
                if let Some(field) = &mut photon.field {
                    field.diffuse(normal, direction);
                }
                photon.direction = direction;
                photon.normal = normal;
                photon.specular = false;
            }
            Material::Mirror { reflectance } if is_lit => {
                let normal = facing_normal(hit, photon.direction);
                let before = photon.power;
                let reflected = before * reflectance;
                add(&mut out.energy.surfaces, before - reflected);
                let u = sampler.uniform();
                let limit = self.limits.at(hit.position, photon.events);
                if roulette(photon, reflected, limit, u, out).is_none() {
                    return false;
                }
                if let Some(field) = &mut photon.field {
                    field.reflect(normal, &self.curvature(hit, normal));
                }
                photon.direction = reflect(photon.direction, normal);
                photon.normal = normal;
            }
            Material::Black | Material::Lambert { .. } | Material::Mirror { .. } => {
                add(&mut out.energy.surfaces, photon.power);
                return false;
            }
            Material::Lobes(ref lobes) => {
                let xi = sampler.uniform_pair();
                let met = Encounter::new(self.scene, hit, photon.direction, &photon.interior, lobes, xi);
                if is_lit && lobes.diffuse.max(lobes.translucent) != Vec3::ZERO {
                    photon.arrive(self.scene, hit, met.normal, record, out);
                }
                if is_lit && record == Record::Connections && self.scene.shows_surfaces() {
                    self.connect_lobes(photon, hit, &met, out);
                }
                let before = photon.power;
                let weights = photon.weights() / self.limits.at(hit.position, photon.events);
                // What is below the limit is no reason to lose light here: what is lost here is what the surface takes.
                let weights = weights / weights.max_element().clamp(f32::MIN_POSITIVE, 1.0);
                let way = met.draw(weights, sampler.uniform(), sampler.uniform_pair());
                let way = way.filter(|way| is_lit || way.lobe == Lobe::Transparent);
                let Some(way) = way else {
                    add(&mut out.energy.surfaces, before);
                    return false;
                };
                photon.power *= way.factor;
                add(&mut out.energy.surfaces, before - photon.power);
                if let Some(field) = &mut photon.field {
                    met.turn(field, hit, &way, self.acts(Operator::Curvature));
                }
                photon.direction = way.direction;
                photon.interior = way.interior;
                photon.normal = if way.lobe.crosses() { -met.normal } else { met.normal };
                photon.specular &= met.keeps_focus(way.lobe);
                stays_straight = way.lobe == Lobe::Transparent;
            }
            Material::Dielectric { .. } => {
                let boundary = Boundary::new(self.scene, hit, photon.direction, &photon.interior);
                let through =
                    (sampler.uniform() >= boundary.reflectance).then_some(boundary.refracted).flatten();
                return self.cross(photon, hit, &boundary, through, out);
            }
        }
        photon.direct &= stays_straight;
        photon.bounces += u32::from(!stays_straight);
        photon.go_on(hit, stays_straight);
        true
    }

    /// Sends a photon on through what lets all light go straight on: as if nothing had been met but another medium.
    fn go_straight_on(&self, photon: &mut Photon, hit: &Hit) {
        let side = if hit.geometric_normal.dot(photon.direction) < 0.0 { -1.0 } else { 1.0 };
        photon.interior = photon.interior.through(self.scene, hit, photon.direction);
        photon.normal = side * hit.geometric_normal;
        photon.go_on(hit, true);
    }

    /// Sends a photon on from glass or water. False = its light begins farther along its way, which ends here.
    ///
    /// - `through`: the direction behind the boundary; None: it is reflected.
    fn cross(
        &self,
        photon: &mut Photon,
        hit: &Hit,
        boundary: &Boundary,
        through: Option<Vec3>,
        out: &mut PhotonRecord,
    ) -> bool {
        if !(boundary.is_matched() || photon.is_lit(hit.distance)) {
            add(&mut out.energy.surfaces, photon.power);
            return false;
        }
        let curvature = self.curvature(hit, boundary.normal);
        if let Some(refracted) = through {
            if let Some(field) = &mut photon.field {
                field.refract(boundary.normal, &curvature, boundary.eta);
            }
            photon.interior = boundary.beyond;
            photon.normal = -boundary.normal;
            photon.direction = refracted;
        } else {
            if let Some(field) = &mut photon.field {
                field.reflect(boundary.normal, &curvature);
            }
            photon.normal = boundary.normal;
            photon.direction = boundary.reflected;
        }
        photon.direct &= boundary.is_matched();
        photon.bounces += u32::from(!boundary.is_matched());
        photon.go_on(hit, boundary.is_matched());
        true
    }

    /// Connects light on a surface of lobes with the pinhole, on either side of it.
    fn connect_lobes(&self, photon: &Photon, hit: &Hit, met: &Encounter, out: &mut PhotonRecord) {
        let to_camera = self.scene.camera.position - hit.position;
        let from = hit.leave(to_camera);
        self.connect(from, out, |to_camera| {
            photon.power * met.towards(to_camera) * to_camera.dot(met.normal).abs()
        });
    }

    /// The curvature that a light field meets at a hit.
    fn curvature(&self, hit: &Hit, normal: Vec3) -> Curvature {
        if self.acts(Operator::Curvature) { curvature_towards(hit, normal) } else { Curvature::default() }
    }

    /// Leaves the segment of a light field in a region. Where light is inside of glass no grid is looked up.
    fn deposit(&self, segment: Option<(u32, FieldSegment)>, out: &mut PhotonRecord) {
        out.deposits.extend(segment.filter(|(region, _)| !self.scene.is_in_glass(*region)));
    }

    /// The segment of a light field that a photon carries up to `hit`.
    fn field_segment(
        &self,
        photon: &Photon,
        field: LightField,
        length: f32,
        hit: Option<&Hit>,
    ) -> FieldSegment {
        let edges = match self.acts(Operator::Occlusion) {
            true => self.scene.edges_beside(photon.origin, photon.direction, hit),
            false => Edges::default(),
        };
        let power = photon.stands_for * photon.power.element_sum() / 3.0;
        let unscattered = photon.specular && self.acts(Operator::Spreading);
        FieldSegment { origin: photon.origin, length, field, power, unscattered, kind: photon.kind(), edges }
    }

    /// Connects one point of a segment with the pinhole.
    ///
    /// The point is drawn in proportion to 1/d² (equi-angular sampling, C. Kulla and M. Fajardo 2012), d its distance
    /// from the camera. Connecting the path's own vertices would be unbiased as well, but with infinite variance: a
    /// mean of them leaves out the light that scatters nearer to the camera than the nearest vertex.
    fn connect_segment(
        &self,
        photon: &Photon,
        reach: f32,
        fog: &Medium,
        column: &Column,
        sampler: &mut PathSampler,
        out: &mut PhotonRecord,
    ) {
        let u = sampler.uniform();
        let direction = photon.direction;
        let offset = self.scene.camera.position - photon.origin;
        let foot = offset.dot(direction);
        let distance = (offset - foot * direction).length();
        if !(distance > 0.0) {
            return;
        }
        let dark = photon.dark.min(reach);
        let (from, to) = (((dark - foot) / distance).atan(), ((reach - foot) / distance).atan());
        let s = (foot + distance * (from + u * (to - from)).tan()).clamp(dark, reach);
        let density = distance / ((to - from) * (distance * distance + (s - foot) * (s - foot)));
        if !(s.is_finite() && density > 0.0) {
            return;
        }
        let (medium, point) = (fog, photon.origin + s * direction);
        let scattering = medium.scattering * fog.density.at(point);
        let scattered = photon.power * medium.transmittance(column.at(s)) * scattering / density;
        self.connect(point, out, |to_camera| scattered * medium.phase.evaluate(direction.dot(to_camera)));
    }

    /// Connects a vertex with the pinhole; `flux` gives the flux per steradian towards the camera.
    fn connect(&self, vertex: Vec3, out: &mut PhotonRecord, flux: impl FnOnce(Vec3) -> Vec3) {
        let camera = &self.scene.camera;
        let Some((x, y, importance)) = camera.project(vertex) else { return };
        let offset = camera.position - vertex;
        let distance2 = offset.length_squared();
        let distance = distance2.sqrt();
        let (eye, interior) = self.camera.towards(self.scene, -offset);
        let arrives = passage(self.scene, &self.fogs, interior, eye, vertex);
        if arrives == Vec3::ZERO {
            return;
        }
        let radiance = flux(offset / distance) * arrives * (importance / distance2);
        out.splats.push(Splat { pixel: y as u32 * camera.width + x as u32, radiance });
    }
}

/// The light that a path starts from, with its probability.
fn choose_light(cumulative: &[f32], sampler: &mut PathSampler) -> (usize, f32) {
    if cumulative.len() == 1 {
        return (0, 1.0);
    }
    let u = sampler.uniform();
    let index = cumulative.partition_point(|&end| end <= u).min(cumulative.len() - 1);
    let before = if index == 0 { 0.0 } else { cumulative[index - 1] };
    (index, cumulative[index] - before)
}

/// Keeps a photon that is to go on with the power `after` with the probability of its largest weight over its limit, and its power unchanged on
/// average. Returns `u` made uniform again, None if the path ends.
fn roulette(photon: &mut Photon, after: Vec3, limit: Vec3, u: f32, out: &mut PhotonRecord) -> Option<f32> {
    let survival = (after * photon.unit / limit).max_element().min(1.0);
    if !(u < survival) {
        add(&mut out.energy.roulette, after);
        return None;
    }
    photon.power = after / survival;
    add(&mut out.energy.roulette, after - photon.power);
    Some(u / survival)
}
