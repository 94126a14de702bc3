//! Triangles drawn by how much a place sees of them, about: for few shadow rays to many triangles.

use covbeam_geometry::triangles::area_vector;
use glam::{DVec3, Vec3};

/// A binary tree over triangles: halves of halves, down to single ones. The nodes of the first half follow their parent, and those of the second
/// half them.
pub(super) struct Tree {
    nodes: Vec<Node>,
    triangles: usize,
}

/// All triangles below.
struct Node {
    min: DVec3,
    max: DVec3,
    area: f64,
}

/// Places are taken to be no nearer to a box than this share of the way to its farthest corner, squared.
const LEAST: f64 = 1e-4;

impl Node {
    /// Area times the mean of 1/d², if squared distances fill evenly what they may be in the box.
    fn worth(&self, place: DVec3) -> f64 {
        let far2 = (place - self.min).abs().max((self.max - place).abs()).length_squared();
        let near2 = place.distance_squared(place.clamp(self.min, self.max)).max(LEAST * far2);
        let rise = (far2 - near2) / near2;
        let mean = if rise > 1e-9 { libm::log1p(rise) / rise } else { 1.0 };
        self.area * mean / near2
    }
}

impl Tree {
    /// Over triangles with areas, at least one, which are put in the tree's order.
    pub(super) fn new(corners: &mut [[Vec3; 3]]) -> Self {
        let mut tree = Self { nodes: Vec::with_capacity(2 * corners.len()), triangles: corners.len() };
        tree.add(corners);
        tree
    }

    fn add(&mut self, corners: &mut [[Vec3; 3]]) {
        let all = || corners.iter().flatten();
        let min = all().fold(Vec3::INFINITY, |a, &b| a.min(b)).as_dvec3();
        let max = all().fold(Vec3::NEG_INFINITY, |a, &b| a.max(b)).as_dvec3();
        let area = corners.iter().map(|&corners| 0.5 * area_vector(corners).length()).sum();
        self.nodes.push(Node { min, max, area });
        let half = corners.len() / 2;
        if half > 0 {
            let axis = (max - min)
                .to_array()
                .iter()
                .enumerate()
                .fold((0, 0.0), |most, (axis, &size)| if size > most.1 { (axis, size) } else { most });
            let place = |corners: &[Vec3; 3]| corners.iter().map(|corner| corner[axis.0]).sum::<f32>();
            corners.select_nth_unstable_by(half, |a, b| place(a).total_cmp(&place(b)));
            let (first, second) = corners.split_at_mut(half);
            self.add(first);
            self.add(second);
        }
    }

    /// A triangle that a uniform number picks for a place, what the choice leaves of the number, and how likely it was, > 0.
    ///
    /// At each node the halves have chances by [`Node::worth`]: next to a ball of 8,000 triangles the solid angle that a triangle stands for
    /// deviates by 1.7 times its mean; drawn by area it would be 17 times, by the distances of the boxes' middles 10.
    pub(super) fn pick(&self, place: DVec3, mut number: f64) -> (usize, f64, f64) {
        let (mut node, mut first, mut count, mut chance) = (0, 0, self.triangles, 1.0);
        while count > 1 {
            let half = count / 2;
            let halves = [node + 1, node + 2 * half];
            let [a, b] = halves.map(|half| self.nodes[half].worth(place));
            let share = a / (a + b);
            if number < share {
                (node, count, number, chance) = (halves[0], half, number / share, chance * share);
            } else {
                (first, number) = (first + half, (number - share) / (1.0 - share));
                (node, count, chance) = (halves[1], count - half, chance * (1.0 - share));
            }
        }
        (first, number.min(1.0), chance)
    }
}
