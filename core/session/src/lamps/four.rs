//! Lamps in groups of four, side by side: what each of four groups is worth to a ray or to a place on a surface.

use super::node::Node;
use super::stretch::Stretch;
use glam::{Vec3, Vec4};
use smallvec::SmallVec;
use std::f32::consts::{FRAC_PI_2, PI};

/// Lamps are taken to shine with this share of their strength where they do not seem to: balls and cones around many are coarse, and no lamp
/// that may light a place must be left out.
const BESIDE: f32 = 0.05;

/// Mean over all directions of a cosine that is not below 0: what is left of it amid many lamps, and half of what is on surfaces beside them, which
/// are lit from one side. Between these and the largest cosines, of 300 and of 4,000 lamps in a room and in the open, draws have a third of the variance.
const MEAN: f32 = 0.25;
const ON_SURFACES: f32 = 2.0;

/// What a group, or a place among four, holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Below {
    Nothing,
    /// One, by number, and whether it shines all around.
    Lamp(u32, bool),
    /// Four, by index.
    Groups(u32),
}

/// Three numbers of four.
#[derive(Clone, Copy)]
struct Vec3x4 {
    x: Vec4,
    y: Vec4,
    z: Vec4,
}

impl Vec3x4 {
    fn of(all: [Vec3; 4]) -> Self {
        let axis = |axis: usize| Vec4::from_array(all.map(|one| one[axis]));
        Self { x: axis(0), y: axis(1), z: axis(2) }
    }

    fn minus(&self, point: Vec3) -> Self {
        let [x, y, z] = point.to_array().map(Vec4::splat);
        Self { x: self.x - x, y: self.y - y, z: self.z - z }
    }

    fn along(&self, direction: Vec3) -> Vec4 {
        direction.x * self.x + direction.y * self.y + direction.z * self.z
    }

    fn dot(&self, other: &Self) -> Vec4 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }
}

/// Four groups of lamps, of which some may be empty: worth nothing. Numbers are those of [`Node`].
pub(super) struct Four {
    pub(super) below: [Below; 4],
    center: Vec3x4,
    radius: Vec4,
    /// Flux into a steradian that is taken for granted.
    least: Vec4,
    around: Vec4,
    strength: Vec4,
    axis: Vec3x4,
    /// Cosine and sine of the cones' angles.
    edge: [Vec4; 2],
    /// 1 where a cosine dims the light towards the side, else 0.
    flat: Vec4,
    /// Of the sine under which a ball is seen, the share by which cosines to its lamps are larger than to its middle.
    wider: Vec4,
    softening2: Vec4,
}

impl Four {
    /// At least one and at most four of them.
    pub(super) fn of(nodes: &[(Node, Below)]) -> Self {
        let numbers = |of: &dyn Fn(&Node) -> f32, or: f32| {
            Vec4::from_array([0, 1, 2, 3].map(|place| nodes.get(place).map_or(or, |(node, _)| of(node))))
        };
        let vectors = |of: &dyn Fn(&Node) -> Vec3| {
            Vec3x4::of([0, 1, 2, 3].map(|place| nodes.get(place).map_or(Vec3::ZERO, |(node, _)| of(node))))
        };
        let flag = |is: bool| if is { 1.0 } else { 0.0 };
        Self {
            below: [0, 1, 2, 3].map(|place| nodes.get(place).map_or(Below::Nothing, |(_, below)| *below)),
            center: vectors(&|node| node.center),
            radius: numbers(&|node| node.radius, 0.0),
            least: numbers(&|node| BESIDE * node.most, 0.0),
            around: numbers(&|node| node.around, 0.0),
            strength: numbers(&|node| node.strength, 0.0),
            axis: vectors(&|node| node.axis),
            edge: [
                numbers(&|node| libm::cosf(node.angle), 1.0),
                numbers(&|node| libm::sinf(node.angle), 0.0),
            ],
            flat: numbers(&|node| flag(node.is_flat), 0.0),
            wider: numbers(&|node| if node.is_mean { MEAN } else { 1.0 }, 1.0),
            softening2: numbers(&|node| node.softening2 + node.gap2, 1.0),
        }
    }

    /// Of light that falls off as 1/(d² + softening²), the integrals along parts of a ray, and distances in the middle of these. Where their ball
    /// is on the way lamps lie at half of its radius, about.
    fn spans(&self, stretch: &Stretch, [from, to]: [Vec4; 2]) -> [Vec4; 2] {
        let offset = self.center.minus(stretch.origin);
        let foot = offset.along(stretch.direction);
        let [x, y, z] = stretch.direction.to_array().map(|axis| axis * foot);
        let aside = Vec3x4 { x: offset.x - x, y: offset.y - y, z: offset.z - z };
        let aside = aside.dot(&aside).sqrt();
        let height = aside.max(0.5 * (aside + self.radius));
        // At least what rounding leaves of a ray that runs into a lamp.
        let least = (1e-12 * foot * foot).max(Vec4::splat(f32::MIN_POSITIVE));
        let height = (height * height + self.softening2).max(least).sqrt();
        // The ends are seen under no angle where rounding says so.
        let seen =
            (angle((to - foot) / height) - angle((from - foot) / height)).max(Vec4::splat(f32::EPSILON));
        [seen / height, foot.max(from).min(to)]
    }

    /// What a stretch of a ray gets of each group.
    ///
    /// - `seen`: the part that a lamp shines on; None: it shines on none of it. Lamps that shine all around are not asked for.
    pub(super) fn along(&self, stretch: &Stretch, seen: &dyn Fn(usize) -> Option<(f32, f32)>) -> Vec4 {
        let [mut from, mut to] = [stretch.from, stretch.to].map(Vec4::splat);
        let mut lit = Vec4::ONE;
        for (place, below) in self.below.iter().enumerate() {
            if let Below::Lamp(lamp, false) = *below {
                match seen(lamp as usize) {
                    Some(part) => (from[place], to[place]) = part,
                    None => lit[place] = 0.0,
                }
            }
        }
        let [integral, middle] = self.spans(stretch, [from, to]);
        let [x, y, z] = stretch.direction.to_array().map(|axis| axis * middle);
        let Vec3x4 { x: cx, y: cy, z: cz } = self.center.minus(stretch.origin);
        let shines = self.shine(&Vec3x4 { x: x - cx, y: y - cy, z: z - cz });
        lit * integral * shines * middle.map(|distance| stretch.left(distance))
    }

    /// What a place on a surface gets of each group.
    pub(super) fn on_surface(&self, place: Vec3, normal: Vec3) -> Vec4 {
        let offset = self.center.minus(place);
        let distance2 = offset.dot(&offset).max(Vec4::splat(f32::MIN_POSITIVE));
        let distance = distance2.sqrt();
        let mean2 = distance2.max(0.5 * (distance2 + self.radius * self.radius)) + self.softening2;
        let wider = (ON_SURFACES * self.wider).min(Vec4::ONE);
        let of_ball = wider * (self.radius / distance).min(Vec4::ONE);
        let cosine = (offset.along(normal) / distance).max(Vec4::ZERO) + of_ball;
        let Vec3x4 { x, y, z } = offset;
        let shines = self.shine(&Vec3x4 { x: -x, y: -y, z: -z });
        cosine.clamp(Vec4::splat(BESIDE * BESIDE), Vec4::ONE) * shines / mean2
    }

    /// Flux into a steradian that each sends along an offset from its middle, or is taken to.
    fn shine(&self, offset: &Vec3x4) -> Vec4 {
        let distance = offset.dot(offset).max(Vec4::splat(f32::MIN_POSITIVE)).sqrt();
        // The cone's angle and that under which the ball is seen, added up.
        let cosine = offset.dot(&self.axis) / distance;
        let of_ball = (self.radius / distance).min(Vec4::ONE);
        let nearest = (Vec4::ONE - of_ball * of_ball).sqrt();
        let [edge, of_axis] = self.edge;
        let is_wide = (of_axis * nearest + edge * of_ball).cmple(Vec4::ZERO);
        let is_in = is_wide | cosine.cmpge(edge * nearest - of_axis * of_ball) | of_ball.cmpge(Vec4::ONE);
        let to_side = (cosine.max(Vec4::ZERO) + self.wider * of_ball).min(Vec4::ONE);
        let factor = Vec4::select(is_in, Vec4::ONE - self.flat * (Vec4::ONE - to_side), Vec4::ZERO);
        (self.around + self.strength * factor).max(self.least)
    }
}

/// The angles of tangents, to 5e-3.
fn angle(tangent: Vec4) -> Vec4 {
    let size = tangent.abs();
    let is_small = size.cmple(Vec4::ONE);
    // x/(1 + .28 x²), and beyond 45° what it leaves of 90° for 1/x.
    let x = Vec4::select(is_small, size, Vec4::ONE / size);
    let near = x / (Vec4::ONE + 0.28 * x * x);
    Vec4::select(is_small, near, Vec4::splat(FRAC_PI_2) - near).copysign(tangent)
}

/// A tree over lamps by number, from the first of its fours on.
pub(super) fn build(lamps: &[Node], order: &mut [u32]) -> Vec<Four> {
    let mut fours = Vec::with_capacity(order.len() / 2 + 1);
    // Levels follow one another, so that the first ones are close together.
    let mut waiting = vec![order];
    let mut next = 1;
    while !waiting.is_empty() {
        let mut after = Vec::new();
        for group in waiting {
            let mut nodes = SmallVec::<[(Node, Below); 4]>::new();
            for part in parts(lamps, group) {
                let below = match *part {
                    [lamp] => Below::Lamp(lamp, lamps[lamp as usize].angle >= PI),
                    _ => Below::Groups(next),
                };
                nodes.push((Node::over(lamps, part), below));
                if matches!(below, Below::Groups(_)) {
                    next += 1;
                    after.push(part);
                }
            }
            fours.push(Four::of(&nodes));
        }
        waiting = after;
    }
    fours
}

/// Halves of halves of a group.
fn parts<'o>(lamps: &[Node], group: &'o mut [u32]) -> SmallVec<[&'o mut [u32]; 4]> {
    let mut parts: SmallVec<[&mut [u32]; 4]> = SmallVec::new();
    parts.push(group);
    for _ in 0..2 {
        let before = std::mem::take(&mut parts);
        for part in before {
            if part.len() < 2 {
                parts.push(part);
            } else {
                let (first, second) = halves(lamps, part);
                parts.push(first);
                parts.push(second);
            }
        }
    }
    parts
}

/// Of at least two lamps, across the longest side of the box around their middles.
fn halves<'o>(lamps: &[Node], group: &'o mut [u32]) -> (&'o mut [u32], &'o mut [u32]) {
    let centers = || group.iter().map(|&lamp| lamps[lamp as usize].center);
    let size = centers().fold(Vec3::NEG_INFINITY, Vec3::max) - centers().fold(Vec3::INFINITY, Vec3::min);
    let axis = size.max_position();
    // Lamps in one place keep the order of the file.
    let key = |lamp: &u32| (lamps[*lamp as usize].center[axis], *lamp);
    group.sort_unstable_by(|a, b| {
        let (a, b) = (key(a), key(b));
        a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
    });
    group.split_at_mut(group.len() / 2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_those_of_arc_tangents() {
        for exponent in -40..40 {
            let tangent = 1.3_f32.powi(exponent);
            let found = angle(Vec4::new(tangent, -tangent, 0.0, f32::INFINITY));
            let expected = Vec4::new(tangent.atan(), -tangent.atan(), 0.0, FRAC_PI_2);
            assert!((found - expected).abs().max_element() < 5e-3, "{found} for {expected}");
        }
        assert_eq!(angle(Vec4::NEG_INFINITY)[0], -FRAC_PI_2);
    }
}
