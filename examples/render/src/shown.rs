//! Lamps and skies that are seen: by the camera, in mirrors and through glass.
//!
//! Lamps hide nothing, as no shadow ray ends at one: what a ray sees of them is the sum of all whose shining sides it meets before a surface
//! ends it. Those that shine on one side are not there from behind.

mod border;
mod small;

pub(crate) use border::{Fill, Pixels};
pub use small::SmallLamps;

use crate::geometry::intersect_box;
use crate::kind::Kind;
use crate::optics::Interior;
use crate::passage::passage;
use crate::scene::{Light, Scene};
use crate::starts::{EyeStart, EyeStarts};
use covbeam::Medium;
use covbeam_geometry::hit::Hit;
use glam::{DVec3, Vec3};
use smallvec::SmallVec;

/// How far behind a surface that ends a ray a lamp may lie on it, in shares of the way and of the largest coordinate, and in twice
/// [`Hit::offset`] across the surface: ten times what rounding makes of all of them. Lamps hang in ceilings.
const ON_SURFACE: f64 = 1e-6;

/// And along the ray no farther than so many times that: a ray along a surface meets others where these are.
const ALONG: f64 = 256.0;

/// Boxes are larger than lamps by this share of their coordinates, for rounding.
const MARGIN: f64 = 1e-6;

/// Places where a ray meets lamps: distance, and radiance.
pub(crate) type Meetings = SmallVec<[(f64, Vec3); 4]>;

/// The lights of a scene that are seen, as a binary tree of boxes around them.
#[derive(Clone, Debug, Default)]
pub struct Shown {
    /// Halves of halves, down to single lamps. The nodes of the first half follow their parent, and those of the second half them.
    nodes: Vec<Node>,
    /// Numbers of the lamps in the tree, in its order.
    order: Vec<u32>,
    /// Numbers of those infinitely far away.
    far: Vec<u32>,
    /// Of the brightest one, in the channel that has most.
    brightest: f32,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    min: DVec3,
    max: DVec3,
}

impl Shown {
    /// Those of some lights; `is_seen` by number. What has no surface, and is no sky or sun with an angle, is seen by nobody.
    pub fn new(lights: &[Light], is_seen: impl Fn(usize) -> bool) -> Self {
        let mut shown = Self::default();
        let mut near: Vec<(u32, Node)> = Vec::new();
        for (number, light) in (0..).zip(lights).filter(|(number, _)| is_seen(*number as usize)) {
            let Some(brightest) = light.brightest() else { continue };
            shown.brightest = shown.brightest.max(brightest.max_element());
            match light.extent() {
                Some((min, max)) => {
                    let margin = MARGIN * min.abs().max(max.abs()).max_element();
                    near.push((number, Node { min: min - margin, max: max + margin }));
                }
                None => shown.far.push(number),
            }
        }
        if !near.is_empty() {
            shown.add(&mut near);
        }
        shown
    }

    fn add(&mut self, lamps: &mut [(u32, Node)]) {
        let unite = |a: Node, (_, b): &(u32, Node)| Node { min: a.min.min(b.min), max: a.max.max(b.max) };
        let all = lamps.iter().fold(Node { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY }, unite);
        self.nodes.push(all);
        let half = lamps.len() / 2;
        if half == 0 {
            self.order.push(lamps[0].0);
            return;
        }
        let axis = (all.max - all.min).max_position();
        let key = |(number, node): &(u32, Node)| (node.min[axis] + node.max[axis], *number);
        lamps.sort_by(|a, b| {
            let (a, b) = (key(a), key(b));
            a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
        });
        let (first, second) = lamps.split_at_mut(half);
        self.add(first);
        self.add(second);
    }

    /// Whether none is seen.
    pub fn is_empty(&self) -> bool {
        self.order.is_empty() && self.far.is_empty()
    }

    /// Of the brightest one, in the channel that has most [W/(m² sr)]; 0 if there is none.
    pub fn brightest(&self) -> f32 {
        self.brightest
    }

    /// Where a ray meets those that are `wanted`, by number, at distances above the first of `ends` and up to the second; what is infinitely far
    /// away where that is infinite.
    fn met(
        &self,
        lights: &[Light],
        wanted: impl Fn(u32) -> bool,
        origin: Vec3,
        direction: Vec3,
        ends: [f64; 2],
        found: &mut Meetings,
    ) {
        let mut meet = |lamp: u32| {
            if wanted(lamp) {
                lights[lamp as usize].met(origin, direction, ends, found);
            }
        };
        self.far.iter().copied().for_each(&mut meet);
        let (o, d) = (origin.as_dvec3(), direction.as_dvec3());
        let is_met = |min: DVec3, max: DVec3| {
            intersect_box(min, max, o, d).is_some_and(|(near, far)| far > ends[0] && near <= ends[1])
        };
        self.visit(is_met, meet);
    }

    /// Lamps, by number, in boxes within larger ones that are all `wanted`, by corner.
    fn visit(&self, wanted: impl Fn(DVec3, DVec3) -> bool, mut lamp: impl FnMut(u32)) {
        let mut waiting = SmallVec::<[[usize; 3]; 32]>::new();
        if !self.order.is_empty() {
            waiting.push([0, 0, self.order.len()]);
        }
        while let Some([node, first, count]) = waiting.pop() {
            let Node { min, max } = self.nodes[node];
            if !wanted(min, max) {
                continue;
            }
            if count == 1 {
                lamp(self.order[first]);
                continue;
            }
            let half = count / 2;
            waiting.push([node + 2 * half, first + half, count - half]);
            waiting.push([node + 1, first, half]);
        }
    }

    /// Radiance of those that an eye ray meets before a surface at `end`, or of small ones in its pixel, if nothing dims them.
    pub(crate) fn undimmed(
        &self,
        scene: &Scene,
        small: &SmallLamps,
        start: &EyeStart,
        end: f32,
        surface: Option<&Hit>,
    ) -> Vec3 {
        if self.is_empty() {
            return Vec3::ZERO;
        }
        let end = f64::from(end) + surface.map_or(0.0, |hit| slack(start.origin, start.direction, hit));
        let mut met = Meetings::new();
        let wanted = |lamp| !small.has(lamp);
        self.met(&scene.lights, wanted, start.origin, start.direction, [0.0, end], &mut met);
        let large: Vec3 = met.iter().map(|(_, radiance)| *radiance).sum();
        large + small.undimmed(scene, start, end)
    }

    /// Of those that an eye ray sees straight, or asks for because they are small, what is seen if nothing dims or hides it.
    pub(crate) fn seen(
        &self,
        scene: &Scene,
        small: &SmallLamps,
        starts: &EyeStarts,
        start: &EyeStart,
    ) -> Vec<Sighting> {
        let mut seen = Vec::new();
        if !self.is_empty() && start.sees {
            let mut met = Meetings::new();
            let wanted = |lamp| !small.has(lamp);
            let ends = [0.0, f64::INFINITY];
            self.met(&scene.lights, wanted, start.origin, start.direction, ends, &mut met);
            self.add_seen(scene, &met, start, &mut seen);
            small.add_seen(scene, starts, start, &mut seen);
        }
        seen
    }

    /// What an eye ray meets, as it is seen.
    fn add_seen(&self, scene: &Scene, met: &Meetings, start: &EyeStart, seen: &mut Vec<Sighting>) {
        let EyeStart { origin, direction, interior, .. } = *start;
        // Beyond all that the scene has, for what is infinitely far away.
        let (middle, around) =
            self.far.first().map_or((origin, 0.0), |&lamp| scene.lights[lamp as usize].middle());
        let beyond = f64::from(origin.distance(middle) + around);
        seen.extend(met.iter().map(|&(distance, radiance)| {
            let distance = if distance.is_finite() { distance } else { beyond };
            let place = (origin.as_dvec3() + distance * direction.as_dvec3()).as_vec3();
            Sighting { radiance, eye: origin, interior, place }
        }));
    }
}

/// A lamp that may be seen straight.
pub(crate) struct Sighting {
    /// If nothing dims it.
    radiance: Vec3,
    /// From where, inside of what.
    eye: Vec3,
    interior: Interior,
    place: Vec3,
}

impl Sighting {
    /// Radiance of what is seen of it, through nothing but fog, its bounds, and what is transparent.
    pub(crate) fn dimmed(&self, scene: &Scene, fogs: &[Medium]) -> Vec3 {
        self.radiance * passage(scene, fogs, self.interior, self.eye, self.place)
    }
}

/// How far past a surface, along a ray that it ends, lamps count as lying on it.
fn slack(origin: Vec3, direction: Vec3, hit: &Hit) -> f64 {
    let cosine = f64::from(hit.geometric_normal.dot(direction).abs());
    let across = 2.0 * f64::from(hit.offset) * cosine.recip().min(ALONG);
    across + ON_SURFACE * f64::from(hit.distance + origin.abs().max_element())
}

/// What an eye path sees of lamps on a straight line, which goes on through what only bounds media and what is transparent: no lamp is seen
/// twice along it.
#[derive(Clone, Copy)]
pub(crate) struct Watch {
    sees: Sees,
    /// Where the line starts.
    origin: Vec3,
    /// Distance from there up to which lamps were looked for.
    looked: f64,
    /// Whether it starts at the camera: small lamps are asked for there.
    is_first: bool,
    /// Whether all others are looked for apart, too, on the line that starts at the camera.
    is_apart: bool,
}

/// Which lamps are seen: each way from a lamp to the camera counts once. Diffuse surfaces and fog end eye paths.
#[derive(Clone, Copy)]
enum Sees {
    /// Those that are shown: nothing but mirrors and clear glass was met.
    Shown,
    /// None: a rough surface reflected the path, where shadow rays looked for all of them.
    None,
    /// All: rough glass let the path through, where no shadow ray finds any.
    All,
}

impl Watch {
    /// From the camera.
    ///
    /// - `is_apart`: whether other rays look for lamps there.
    pub(crate) fn new(origin: Vec3, is_apart: bool) -> Self {
        Self { sees: Sees::Shown, origin, looked: 0.0, is_first: true, is_apart }
    }

    /// The same on another line.
    pub(crate) fn from(self, origin: Vec3) -> Self {
        Self { origin, looked: 0.0, is_first: false, ..self }
    }

    /// After rough glass.
    pub(crate) fn of_all(self) -> Self {
        Self { sees: Sees::All, ..self }
    }

    /// After reflection by a rough surface.
    pub(crate) fn of_none(self) -> Self {
        Self { sees: Sees::None, ..self }
    }

    /// What the light of lamps has met that is seen.
    pub(crate) fn kind(self) -> Kind {
        if matches!(self.sees, Sees::All) { Kind::Focused } else { Kind::Straight }
    }

    /// The lamps that the next piece of the line sees up to `hit`, by their distances from its start.
    ///
    /// - `small`: those that are asked for and not met; None: none are wanted that are shown.
    pub(crate) fn look(
        &mut self,
        scene: &Scene,
        small: Option<&SmallLamps>,
        start: Vec3,
        direction: Vec3,
        hit: Option<&Hit>,
    ) -> Meetings {
        let mut met = Meetings::new();
        let is_blind = match self.sees {
            Sees::None => true,
            Sees::Shown => small.is_none() || scene.shown.is_empty() || self.is_first && self.is_apart,
            Sees::All => false,
        };
        if is_blind || !scene.shows_surfaces() {
            return met;
        }
        let passed = (start.as_dvec3() - self.origin.as_dvec3()).dot(direction.as_dvec3());
        let until = |hit: &Hit| passed + f64::from(hit.distance) + slack(start, direction, hit);
        let ends = [self.looked, hit.map_or(f64::INFINITY, until)];
        match self.sees {
            Sees::All => {
                scene.lights.iter().for_each(|light| light.met(self.origin, direction, ends, &mut met))
            }
            _ => {
                let wanted = |lamp| !(self.is_first && small.is_some_and(|small| small.has(lamp)));
                scene.shown.met(&scene.lights, wanted, self.origin, direction, ends, &mut met);
            }
        }
        // The next surface may be nearer than what counts as lying on this one.
        self.looked = self.looked.max(ends[1]);
        met.iter_mut().for_each(|(distance, _)| *distance -= passed);
        met
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::scene::Area;

    fn lights(random: &mut Random, count: u32) -> Vec<Light> {
        let mut number = |most: f32| most * (2.0 * random.uniform() - 1.0);
        let light = |index: u32| {
            let mut vector = |most: f32| Vec3::new(number(most), number(most), number(most));
            let (center, radiance) = (vector(4.0), Vec3::splat(1.0 + index as f32));
            let (edge_u, edge_v) = (vector(0.8), vector(0.8));
            match index % 5 {
                0 => Light::Disk { center, normal: edge_u.normalize(), radius: 0.4, radiance },
                1 => Light::Rectangle { corner: center, edge_u, edge_v, radiance },
                2 => Light::Sphere { center, radius: 0.2, radiance },
                3 => Light::Area(Area { center, edge_u, edge_v, round: true, spread: 1.0, radiance }),
                _ => Light::Point { position: center, intensity: radiance },
            }
        };
        (0..count).map(light).collect()
    }

    /// The tree finds what a look at each lamp does, for rays from outside and from among them, and parts of rays find each meeting once.
    #[test]
    fn the_tree_finds_what_each_lamp_says() {
        let mut random = Random::new([1, 2, 3, 4]);
        let mut all = 0;
        for count in [0, 1, 2, 3, 7, 1000] {
            let lights = lights(&mut random, count);
            let is_seen = |number: usize| !number.is_multiple_of(7);
            let shown = Shown::new(&lights, is_seen);
            for _ in 0..2000 {
                let mut vector = |most: f32| [0; 3].map(|_| most * (2.0 * random.uniform() - 1.0));
                let [origin, towards] = [6.0, 4.0].map(|most| Vec3::from_array(vector(most)));
                let direction = (towards - origin).normalize();
                let sorted = |mut met: Meetings| {
                    met.sort_by(|a, b| a.0.total_cmp(&b.0));
                    met
                };
                let mut expected = Meetings::new();
                let seen = lights.iter().enumerate().filter(|(number, _)| is_seen(*number));
                seen.for_each(|(_, light)| light.met(origin, direction, [0.0, f64::INFINITY], &mut expected));
                let expected = sorted(expected);
                // One end lies exactly on a lamp.
                let middle = expected.first().map_or(3.0, |met| met.0);
                for parts in [vec![0.0, f64::INFINITY], vec![0.0, middle, middle + 1.0, f64::INFINITY]] {
                    let mut found = Meetings::new();
                    for ends in parts.windows(2) {
                        shown.met(&lights, |_| true, origin, direction, [ends[0], ends[1]], &mut found);
                    }
                    assert_eq!(sorted(found), expected);
                }
                all += expected.len();
            }
        }
        assert!(all > 1000, "{all}");
    }
}
