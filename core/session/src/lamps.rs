//! Lamps drawn by place: a tree over all lamps of a scene, which a few uniform numbers descend together to those that matter to a ray or to a
//! place on a surface.

pub(crate) mod beside;
mod four;
pub(crate) mod near;
mod node;
mod stretch;

pub(crate) use stretch::Stretch;

use crate::color::mean;
use crate::lamps::near::Near;
use crate::light::Shine;
use crate::random::spread;
use crate::scene::{Light, Scene};
use four::{Below, Four};
use glam::{Vec3, Vec4};
use node::Node;
use smallvec::SmallVec;
use std::f32::consts::PI;

/// Lamps that a place on a surface asks; of more, as many are drawn.
pub const MOST_ASKED: usize = 32;

/// Lamps far away, and all others, have at least this share of the draws: how much they are worth is estimated in unlike ways.
const LEAST_OF_KIND: f64 = 0.1;

/// How far from a lamp its light is left to beams, in metres, where that is everywhere: farther than any scene reaches.
const EVERYWHERE: f32 = 1e9;

/// Looks at a lamp far away that tell its strength.
const TRIES: usize = 16;

/// A tree over lamps, four to a node, with those far away beside it.
///
/// What a place, or a ray, gets of a group of lamps is estimated from where they are in the mean and how far apart, and from what they send all
/// around and to one side. The four of a node have draws in proportion, and always some: so the chance of each lamp is known,
/// none is 0, and the light is right in the mean however coarse the estimates are. Of single lamps the estimate is nearly exact, but for what is
/// in the way.
pub struct LampTree {
    /// The first is the root, if there are any.
    fours: Vec<Four>,
    /// Numbers of lamps far away, and their flux density, the mean of the channels.
    far: Vec<(u32, f32)>,
    /// Of the tree.
    near: usize,
    /// Of the scene.
    lights: usize,
    /// How far along a ray there is something for lamps far away to shine on, at most.
    reach: f32,
}

/// The draws that fell on a lamp.
pub(crate) struct Drawn {
    pub(crate) lamp: usize,
    /// Their numbers.
    pub(crate) draws: std::ops::Range<u32>,
    /// Where the lamp's share of all draws begins and ends.
    from: f64,
    to: f64,
    shift: f32,
}

impl Drawn {
    /// Draws that the lamp has in the mean, > 0.
    pub(crate) fn expected(&self) -> f32 {
        (self.to - self.from) as f32
    }

    /// What the choice leaves of a draw's number, uniform in [0, 1]: of draws of one lamp in equal steps.
    pub(crate) fn rest(&self, draw: u32) -> f32 {
        let number = f64::from(draw) + f64::from(self.shift);
        ((number - self.from) / (self.to - self.from)).clamp(0.0, 1.0) as f32
    }
}

/// How much lamps far away, by their strength, and groups are worth to whoever asks.
struct Worth<'w> {
    far: &'w dyn Fn(f32) -> f32,
    four: &'w dyn Fn(&Four) -> Vec4,
}

impl LampTree {
    /// Over all lamps of a scene whose light is straight.
    pub fn new(scene: &Scene) -> Self {
        let beams = Near::new(scene);
        let lamps: Vec<Node> =
            scene.lights.iter().enumerate().map(|(lamp, light)| Node::of(light, beams.reach(lamp))).collect();
        let all = (0..).zip(&scene.lights).filter(|(_, light)| light.is_straight());
        let (far, near): (Vec<_>, Vec<_>) = all.partition(|(_, light)| light.is_far());
        let mut order: Vec<u32> = near.into_iter().map(|(lamp, _)| lamp).collect();
        let fours = if order.is_empty() { Vec::new() } else { four::build(&lamps, &mut order) };
        let middle = 0.5 * (scene.grid.min + scene.grid.max);
        let strength = |light: &Light| {
            let looks = (0..TRIES).map(|index| mean(light.flux_density(middle, spread([0.5; 2], index)).0));
            // It may have been looked at where it is dark.
            (looks.sum::<f32>() / TRIES as f32).max(f32::MIN_POSITIVE)
        };
        let far = far.into_iter().map(|(lamp, light)| (lamp, strength(light))).collect();
        let reach = (scene.grid.max - scene.grid.min).length();
        Self { fours, far, near: order.len(), lights: lamps.len(), reach }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.near + self.far.len()
    }

    /// How far along a ray there is anything that lamps shine on, at most.
    pub(crate) fn reach(&self) -> f32 {
        self.reach
    }

    /// Whether a place on a surface asks some of the lamps only.
    pub(crate) fn is_drawn_on_surfaces(&self) -> bool {
        self.count() > MOST_ASKED
    }

    /// Lamps that a place on a surface asks, and how many each stands for: all of them, or some.
    ///
    /// - `normal`: unit, on the side that is lit; `shift`: uniform in [0, 1).
    pub fn on_surface(&self, place: Vec3, normal: Vec3, shift: f32) -> SmallVec<[(usize, f32); MOST_ASKED]> {
        if !self.is_drawn_on_surfaces() {
            return (0..self.lights).map(|lamp| (lamp, 1.0)).collect();
        }
        let mut asked = SmallVec::new();
        self.for_surface(place, normal, MOST_ASKED as u32, shift, &mut |drawn| {
            asked.extend(drawn.draws.clone().map(|_| (drawn.lamp, 1.0 / drawn.expected())));
        });
        asked
    }

    fn for_surface(&self, place: Vec3, normal: Vec3, draws: u32, shift: f32, found: &mut dyn FnMut(Drawn)) {
        let four = |four: &Four| four.on_surface(place, normal);
        self.draw(&Worth { far: &|strength| strength, four: &four }, draws, shift, found);
    }

    /// Draws lamps for a stretch of an eye ray.
    ///
    /// - `draws`: how many, at least one; `shift`: uniform in [0, 1).
    /// - `seen`: the part of the stretch that a lamp with a place shines on; None: it shines on none of it.
    pub(crate) fn along(
        &self,
        stretch: &Stretch,
        draws: u32,
        shift: f32,
        seen: &dyn Fn(usize) -> Option<(f32, f32)>,
        found: &mut dyn FnMut(Drawn),
    ) {
        let length = stretch.length();
        let four = |four: &Four| four.along(stretch, seen);
        self.draw(&Worth { far: &|strength| strength * length, four: &four }, draws, shift, found);
    }

    /// Lets numbers (i + shift), i < `draws`, fall on shares of [0, draws) that lamps have by their worth.
    fn draw(&self, worth: &Worth, draws: u32, shift: f32, found: &mut dyn FnMut(Drawn)) {
        let far: f64 = self.far.iter().map(|&(_, strength)| f64::from((worth.far)(strength))).sum();
        let near = match self.fours.first() {
            Some(root) if far > 0.0 => (worth.four)(root).as_dvec4().element_sum(),
            root => f64::from(u8::from(root.is_some())),
        };
        let share = match (far > 0.0, near > 0.0) {
            (true, true) => (far / (far + near)).clamp(LEAST_OF_KIND, 1.0 - LEAST_OF_KIND),
            (has_far, _) => f64::from(u8::from(has_far)),
        };
        let all = f64::from(draws);
        // The first draw at or after a place.
        let first = |place: f64| {
            let place = (place - f64::from(shift)).clamp(0.0, all);
            let before = place as u32;
            before + u32::from(f64::from(before) < place)
        };
        let (mut from, mut sum) = (0.0, 0.0);
        for (index, &(lamp, strength)) in self.far.iter().enumerate() {
            sum += f64::from((worth.far)(strength));
            let to = if index + 1 == self.far.len() { share * all } else { share * all * (sum / far) };
            let numbers = first(from)..first(to);
            if !numbers.is_empty() {
                found(Drawn { lamp: lamp as usize, draws: numbers, from, to, shift });
            }
            from = to;
        }
        let mut waiting = SmallVec::<[(u32, f64, f64); 32]>::new();
        if near > 0.0 {
            waiting.push((0, share * all, all));
        }
        while let Some((group, from, to)) = waiting.pop() {
            let four = &self.fours[group as usize];
            let of_each = (worth.four)(four).as_dvec4().to_array();
            let sum: f64 = of_each.iter().sum();
            if !(sum > 0.0) {
                continue;
            }
            let (mut start, mut so_far) = (from, 0.0);
            for (below, of_one) in four.below.iter().zip(of_each) {
                so_far += of_one;
                let end = if so_far < sum { from + (to - from) * (so_far / sum) } else { to };
                let numbers = first(start)..first(end);
                match *below {
                    _ if numbers.is_empty() => {}
                    Below::Nothing => {}
                    Below::Groups(groups) => waiting.push((groups, start, end)),
                    Below::Lamp(lamp, _) => {
                        found(Drawn { lamp: lamp as usize, draws: numbers, from: start, to: end, shift });
                    }
                }
                start = end;
            }
        }
    }
}

impl Node {
    /// - `reach`: how far from the lamp its light is left to beams.
    fn of(light: &Light, reach: f32) -> Self {
        let (center, softening) = light.middle();
        let Shine { strength, axis, angle, is_flat, radius } = light.shine();
        let [softening2, gap2] = [softening, reach.min(EVERYWHERE)].map(|length| length * length);
        let [around, directed] = if angle >= PI { [strength, 0.0] } else { [0.0, strength] };
        Self {
            center,
            radius,
            most: strength,
            around,
            strength: directed,
            axis,
            angle,
            is_flat,
            is_mean: false,
            softening2,
            gap2,
        }
    }

    /// Along the axis, what a flat lamp without a cone sends that has the same flux, about.
    fn lobe(&self) -> f32 {
        let cosine = libm::cosf(self.angle);
        self.strength * if self.is_flat { 1.0 - cosine * cosine } else { 2.0 * (1.0 - cosine) }
    }

    /// Mean over all directions of what a single lamp sends into a steradian.
    fn mean(&self) -> f32 {
        self.around + 0.25 * self.lobe()
    }

    /// At least one lamp. What many send that look in unlike directions goes all around.
    fn over(lamps: &[Node], order: &[u32]) -> Self {
        if let [lamp] = *order {
            return lamps[lamp as usize];
        }
        let all = || order.iter().map(|&lamp| &lamps[lamp as usize]);
        let sum: f32 = all().map(Self::mean).sum();
        let share = |lamp: &Node| lamp.mean() / sum;
        let center: Vec3 = all().map(|lamp| share(lamp) * lamp.center).sum();
        let square = |lamp: &Node| center.distance_squared(lamp.center) + lamp.radius * lamp.radius;
        let radius = all().map(|lamp| share(lamp) * square(lamp)).sum::<f32>().sqrt();
        let lobes: f32 = all().map(Self::lobe).sum();
        let lobe: Vec3 = all().map(|lamp| lamp.lobe() * lamp.axis).sum();
        let (axis, strength) = lobe.try_normalize().map_or((Vec3::Y, 0.0), |axis| (axis, lobe.length()));
        let around = all().map(|lamp| lamp.around).sum::<f32>() + 0.25 * (lobes - strength).max(0.0);
        let most = all().map(|lamp| lamp.most).sum();
        let softening2 = all().map(|lamp| share(lamp) * lamp.softening2).sum();
        Self {
            center,
            radius,
            most,
            around,
            strength,
            axis,
            angle: PI,
            is_flat: true,
            is_mean: true,
            softening2,
            gap2: 0.0,
        }
    }
}

#[cfg(test)]
mod tests;
