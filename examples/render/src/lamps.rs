//! Lamps drawn by place: a tree over all lamps of a scene, which a few uniform numbers descend together to those that matter to a ray or to a
//! place on a surface.

use crate::guidance::mean;
use crate::light::Shine;
use crate::random::spread;
use crate::scene::{Light, Scene};
use glam::Vec3;
use smallvec::SmallVec;
use std::f32::consts::PI;

/// Lamps that a place on a surface asks; of more, as many are drawn.
pub const MOST_ASKED: usize = 32;

/// Lamps are taken to shine with this share of their strength where they do not seem to: balls and cones around many are coarse, and no lamp
/// that may light a place must be left out.
const BESIDE: f32 = 0.05;

/// And this share is taken to be left where fog seems to let nothing through: fog may end on the way, and other places of a ray than the one
/// that stands for it may be lit.
const DIMMED: f32 = 0.05;

/// Lamps far away, and all others, have at least this share of the draws: how much they are worth is estimated in unlike ways.
const LEAST_OF_KIND: f64 = 0.1;

/// Looks at a lamp far away that tell its strength.
const TRIES: usize = 16;

/// A binary tree over lamps, with those far away beside it.
///
/// What a place, or a ray, gets of a node's lamps is estimated from a ball around them, the flux that they send into a steradian, and a cone
/// around all directions in which they shine. Both halves of a node have draws in proportion, and always some: so the chance of each lamp is known,
/// none is 0, and the light is right in the mean however coarse the estimates are. Of single lamps the estimate is exact, but for what is
/// in the way.
pub struct LampTree {
    /// Halves of halves, down to single lamps. The nodes of the first half follow their parent, and those of the second half them.
    nodes: Vec<Node>,
    /// Numbers of the lamps in the tree, in its order.
    order: Vec<u32>,
    /// Numbers of lamps far away, and their flux density, the mean of the channels.
    far: Vec<(u32, f32)>,
    /// By number; nothing is known of those far away.
    lamps: Vec<Node>,
    /// How far along a ray there is something for lamps far away to shine on, at most.
    reach: f32,
}

/// All lamps below.
#[derive(Clone, Copy)]
struct Node {
    /// Of a ball that holds them.
    center: Vec3,
    radius: f32,
    /// Where they are, and where they shine: see [`Shine`].
    shine: Shine,
    /// Squared length by which their size softens 1/d², a mean.
    softening2: f32,
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

/// A stretch of an eye ray.
pub(crate) struct Stretch<'a> {
    pub(crate) origin: Vec3,
    pub(crate) direction: Vec3,
    pub(crate) from: f32,
    pub(crate) to: f32,
    /// Share of light that is left on its way from a place to the origin, by the distance of that.
    pub(crate) left: &'a dyn Fn(f32) -> f32,
}

impl Stretch<'_> {
    fn at(&self, distance: f32) -> Vec3 {
        self.origin + distance * self.direction
    }

    /// What is left of light from there, or taken to be.
    fn dimmed(&self, distance: f32) -> f32 {
        DIMMED + (1.0 - DIMMED) * (self.left)(distance)
    }
}

/// How much each lamp and node is worth to whoever asks, > 0, and of lamps alone perhaps 0.
struct Worth<'w> {
    far: &'w dyn Fn(f32) -> f32,
    node: &'w dyn Fn(&Node) -> f32,
    lamp: &'w dyn Fn(usize) -> f32,
}

impl LampTree {
    /// Over all lamps of a scene whose light is straight.
    pub fn new(scene: &Scene) -> Self {
        let lamps: Vec<Node> = scene.lights.iter().map(Node::of).collect();
        let all = (0..).zip(&scene.lights).filter(|(_, light)| light.is_straight());
        let (far, near): (Vec<_>, Vec<_>) = all.partition(|(_, light)| light.is_far());
        let mut order: Vec<u32> = near.into_iter().map(|(lamp, _)| lamp).collect();
        let mut nodes = Vec::with_capacity(2 * order.len());
        if !order.is_empty() {
            add(&lamps, &mut order, &mut nodes);
        }
        let middle = 0.5 * (scene.grid.min + scene.grid.max);
        let strength = |light: &Light| {
            let looks = (0..TRIES).map(|index| mean(light.flux_density(middle, spread([0.5; 2], index)).0));
            // It may have been looked at where it is dark.
            (looks.sum::<f32>() / TRIES as f32).max(f32::MIN_POSITIVE)
        };
        let far = far.into_iter().map(|(lamp, light)| (lamp, strength(light))).collect();
        Self { nodes, order, far, lamps, reach: (scene.grid.max - scene.grid.min).length() }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.order.len() + self.far.len()
    }

    /// Whether a place on a surface asks some of the lamps only.
    pub(crate) fn is_drawn_on_surfaces(&self) -> bool {
        self.count() > MOST_ASKED
    }

    /// Lamps that a place on a surface asks, and how many each stands for: all of them, or some.
    ///
    /// - `normal`: unit, on the side that is lit; `shift`: uniform in [0, 1).
    pub(crate) fn on_surface(
        &self,
        place: Vec3,
        normal: Vec3,
        shift: f32,
    ) -> SmallVec<[(usize, f32); MOST_ASKED]> {
        if !self.is_drawn_on_surfaces() {
            return (0..self.lamps.len()).map(|lamp| (lamp, 1.0)).collect();
        }
        let worth = Worth {
            far: &|strength| strength,
            node: &|node| node.on_surface(place, normal),
            lamp: &|lamp| self.lamps[lamp].on_surface(place, normal),
        };
        let mut asked = SmallVec::new();
        self.draw(&worth, MOST_ASKED as u32, shift, &mut |drawn| {
            asked.extend(drawn.draws.clone().map(|_| (drawn.lamp, 1.0 / drawn.expected())));
        });
        asked
    }

    /// Draws lamps for a stretch of an eye ray.
    ///
    /// - `draws`: how many, at least one; `shift`: uniform in [0, 1).
    /// - `seen`: of a lamp with a place, the integral of 1/(d² + softening²) along what it shines on of the stretch, and a distance in the middle of
    ///   that; None: it shines on none of it.
    pub(crate) fn along(
        &self,
        stretch: &Stretch,
        draws: u32,
        shift: f32,
        seen: &dyn Fn(usize) -> Option<(f32, f32)>,
        found: &mut dyn FnMut(Drawn),
    ) {
        let length = (stretch.to - stretch.from).min(self.reach);
        let some = [0.1, 0.3, 0.5, 0.7, 0.9].map(|share| stretch.dimmed(stretch.from + share * length));
        let length = 0.2 * some.iter().sum::<f32>() * length;
        let worth = Worth {
            far: &|strength| strength * length,
            node: &|node| node.along(stretch),
            lamp: &|lamp| {
                seen(lamp).map_or(0.0, |(integral, middle)| {
                    integral * self.lamps[lamp].shines(stretch.at(middle)) * stretch.dimmed(middle)
                })
            },
        };
        self.draw(&worth, draws, shift, found);
    }

    /// Lets numbers (i + shift), i < `draws`, fall on shares of [0, draws) that lamps have by their worth.
    fn draw(&self, worth: &Worth, draws: u32, shift: f32, found: &mut dyn FnMut(Drawn)) {
        let far: f64 = self.far.iter().map(|&(_, strength)| f64::from((worth.far)(strength))).sum();
        let near =
            if self.order.is_empty() { 0.0 } else { f64::from(self.worth(worth, 0, 0, self.order.len())) };
        let share = match (far > 0.0, near > 0.0) {
            (true, true) => (far / (far + near)).clamp(LEAST_OF_KIND, 1.0 - LEAST_OF_KIND),
            (has_far, _) => f64::from(u8::from(has_far)),
        };
        let all = f64::from(draws);
        // The first draw at or after a place.
        let first = |place: f64| (place - f64::from(shift)).ceil().clamp(0.0, all) as u32;
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
        let mut waiting = SmallVec::<[(usize, usize, usize, f64, f64); 32]>::new();
        if near > 0.0 {
            waiting.push((0, 0, self.order.len(), share * all, all));
        }
        while let Some((node, start, count, from, to)) = waiting.pop() {
            let numbers = first(from)..first(to);
            if numbers.is_empty() {
                continue;
            }
            if count == 1 {
                found(Drawn { lamp: self.order[start] as usize, draws: numbers, from, to, shift });
                continue;
            }
            let half = count / 2;
            let [a, b] = [(node + 1, start, half), (node + 2 * half, start + half, count - half)];
            let [of_a, of_b] =
                [a, b].map(|(node, start, count)| f64::from(self.worth(worth, node, start, count)));
            if of_a + of_b > 0.0 {
                let middle = from + (to - from) * (of_a / (of_a + of_b));
                waiting.push((b.0, b.1, b.2, middle, to));
                waiting.push((a.0, a.1, a.2, from, middle));
            }
        }
    }

    fn worth(&self, worth: &Worth, node: usize, start: usize, count: usize) -> f32 {
        match count {
            1 => (worth.lamp)(self.order[start] as usize),
            _ => (worth.node)(&self.nodes[node]),
        }
    }
}

/// Adds the node of some lamps and those below it, and puts the lamps in its order.
fn add(lamps: &[Node], order: &mut [u32], nodes: &mut Vec<Node>) {
    nodes.push(Node::over(lamps, order));
    let half = order.len() / 2;
    if half > 0 {
        let centers = || order.iter().map(|&lamp| lamps[lamp as usize].center);
        let size = centers().fold(Vec3::NEG_INFINITY, Vec3::max) - centers().fold(Vec3::INFINITY, Vec3::min);
        let axis = size.max_position();
        // Lamps in one place keep the order of the file.
        let key = |lamp: &u32| (lamps[*lamp as usize].center[axis], *lamp);
        order.sort_by(|a, b| {
            let (a, b) = (key(a), key(b));
            a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
        });
        let (first, second) = order.split_at_mut(half);
        add(lamps, first, nodes);
        add(lamps, second, nodes);
    }
}

impl Node {
    fn of(light: &Light) -> Self {
        let (center, softening) = light.middle();
        let shine = light.shine();
        Self { center, radius: shine.radius, shine, softening2: softening * softening }
    }

    fn over(lamps: &[Node], order: &[u32]) -> Self {
        let all = || order.iter().map(|&lamp| &lamps[lamp as usize]);
        let min = all().map(|lamp| lamp.center - lamp.radius).fold(Vec3::INFINITY, Vec3::min);
        let max = all().map(|lamp| lamp.center + lamp.radius).fold(Vec3::NEG_INFINITY, Vec3::max);
        let center = 0.5 * (min + max);
        let radius = all().map(|lamp| center.distance(lamp.center) + lamp.radius).fold(0.0, f32::max);
        let strength: f32 = all().map(|lamp| lamp.shine.strength).sum();
        let softening2 = all().map(|lamp| lamp.shine.strength / strength * lamp.softening2).sum();
        let cones = all().map(|lamp| (lamp.shine.axis, lamp.shine.angle));
        let (axis, angle) = cones.reduce(around).unwrap_or((Vec3::Y, PI));
        let is_flat = all().all(|lamp| lamp.shine.is_flat) && order.len() == 1;
        Self { center, radius, shine: Shine { strength, axis, angle, is_flat, radius }, softening2 }
    }

    /// Flux into a steradian towards a place, or taken to be.
    fn shines(&self, place: Vec3) -> f32 {
        let Shine { strength, axis, angle, is_flat, .. } = self.shine;
        let offset = place - self.center;
        let distance = offset.length();
        if angle >= PI || distance <= self.radius {
            return strength;
        }
        let cosine = offset.dot(axis) / distance;
        let beside = cosine.clamp(-1.0, 1.0).acos() - (self.radius / distance).asin();
        let factor = if beside > angle { 0.0 } else { 1.0 };
        let factor =
            if is_flat { factor * (cosine + self.radius / distance).clamp(0.0, 1.0) } else { factor };
        strength * factor.max(BESIDE)
    }

    /// What a stretch of a ray gets of all of it. Where their ball is on the way the lamps lie at half of its radius, about.
    fn along(&self, stretch: &Stretch) -> f32 {
        let offset = self.center - stretch.origin;
        let foot = offset.dot(stretch.direction);
        let aside = (offset - foot * stretch.direction).length();
        let height2 = aside.max(0.5 * (aside + self.radius)).powi(2) + self.softening2;
        let height = height2.sqrt().max(1e-6 * offset.length()).max(f32::MIN_POSITIVE);
        let [a, b] = [stretch.from, stretch.to].map(|end| ((end - foot) / height).atan());
        let middle = foot.clamp(stretch.from, stretch.to);
        // The ends are seen under no angle where rounding says so.
        let angle = (b - a).max(f32::EPSILON);
        angle / height * self.shines(stretch.at(middle)) * stretch.dimmed(middle)
    }

    /// What a place on a surface gets of all of it.
    fn on_surface(&self, place: Vec3, normal: Vec3) -> f32 {
        let offset = self.center - place;
        let distance2 = offset.length_squared();
        let distance = distance2.sqrt();
        let mean2 = distance2.max(0.5 * (distance2 + self.radius * self.radius)) + self.softening2;
        // The largest cosine of all directions to the ball.
        let sine = self.radius / distance;
        let cosine = offset.dot(normal) / distance;
        let cosine = if sine < 1.0 {
            let nearest = (1.0 - sine * sine).sqrt();
            if cosine >= nearest {
                1.0
            } else {
                cosine * nearest + (1.0 - cosine * cosine).max(0.0).sqrt() * sine
            }
        } else {
            1.0
        };
        cosine.max(BESIDE * BESIDE) * self.shines(place) / mean2.max(f32::MIN_POSITIVE)
    }
}

/// A cone around two, by axis and angle.
fn around((a, of_a): (Vec3, f32), (b, of_b): (Vec3, f32)) -> (Vec3, f32) {
    let ((a, of_a), (b, of_b)) = if of_a >= of_b { ((a, of_a), (b, of_b)) } else { ((b, of_b), (a, of_a)) };
    let between = a.angle_between(b);
    if of_a >= PI || between + of_b <= of_a {
        return (a, of_a);
    }
    let angle = 0.5 * (of_a + of_b + between);
    let across = (b - a.dot(b) * a).try_normalize();
    let Some(across) = across.filter(|_| angle < PI) else { return (a, PI) };
    let (sine, cosine) = (angle - of_a).sin_cos();
    ((cosine * a + sine * across).normalize(), angle)
}
