//! Lights that are seen, as a tree of boxes.

use crate::light::Meetings;
use crate::light::kinds::Light;
use covbeam_geometry::shape::intersect_box;
use glam::{DVec3, Vec3};
use smallvec::SmallVec;

/// Boxes are larger than lamps by this share of their coordinates, for rounding.
const MARGIN: f64 = 1e-6;

/// The lights of a scene that are seen, as a binary tree of boxes around them.
#[derive(Clone, Debug, Default)]
pub struct Shown {
    /// Halves of halves, down to single lamps. The nodes of the first half follow their parent, and those of the second half them.
    nodes: Vec<Node>,
    /// Numbers of the lamps in the tree, in its order.
    pub(crate) order: Vec<u32>,
    /// Numbers of those infinitely far away.
    pub(crate) far: Vec<u32>,
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
    pub(crate) fn met(
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
    pub(crate) fn visit(&self, wanted: impl Fn(DVec3, DVec3) -> bool, mut lamp: impl FnMut(u32)) {
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
