//! A hierarchy of eight boxes a node, for rays that have nothing in common: the eight are tested side by side, and a
//! ray waits for memory a third as often as in a binary one.

use crate::triangles::{Hierarchy, build_hierarchy};
use glam::Vec4;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::ray::Ray;
use smallvec::SmallVec;

/// Boxes of a node.
const WIDTH: usize = 8;

/// Eight numbers.
type Eight = [Vec4; 2];

/// Boxes side by side, and what is in them.
#[derive(Clone, Copy)]
#[repr(align(64))]
struct Node {
    /// Lower x, y, z, upper x, y, z. An empty box is the wrong way round: nothing hits it.
    planes: [Eight; 6],
    /// The number of a node, or of the first element of a leaf.
    first: [u32; WIDTH],
    /// Elements of a leaf; 0 for a node.
    count: [u8; WIDTH],
}

/// The hierarchy.
#[derive(Default)]
pub struct Wide {
    nodes: Vec<Node>,
    order: Vec<u32>,
}

/// A box that a ray meets.
#[derive(Clone, Copy)]
struct Met {
    first: u32,
    count: u32,
    distance: f32,
}

impl Wide {
    /// Adds the node that stands for one of the binary tree; returns its number.
    fn add(&mut self, tree: &Bvh2, root: usize) -> u32 {
        let mut children: SmallVec<[usize; WIDTH]> = SmallVec::from_slice(&[root]);
        while children.len() < WIDTH {
            let area = |child: &usize| tree.nodes[*child].aabb().half_area();
            let inner = (0..children.len()).filter(|&i| !tree.nodes[children[i]].is_leaf());
            let Some(largest) = inner.max_by(|&i, &j| area(&children[i]).total_cmp(&area(&children[j])))
            else {
                break;
            };
            let opened = children.swap_remove(largest);
            let first = tree.nodes[opened].first_index as usize;
            children.extend([first, first + 1]);
        }
        let (lower, upper) = ([Vec4::INFINITY; 2], [Vec4::NEG_INFINITY; 2]);
        let planes = [lower, lower, lower, upper, upper, upper];
        let mut node = Node { planes, first: [0; WIDTH], count: [0; WIDTH] };
        let number = self.nodes.len();
        self.nodes.push(node);
        for (i, &child) in children.iter().enumerate() {
            let of = &tree.nodes[child];
            for axis in 0..3 {
                node.planes[axis][i / 4][i % 4] = of.aabb().min[axis];
                node.planes[axis + 3][i / 4][i % 4] = of.aabb().max[axis];
            }
            (node.first[i], node.count[i]) = match of.is_leaf() {
                // `build_hierarchy` makes leaves of at most eight.
                true => (of.first_index, of.prim_count as u8),
                false => (self.add(tree, child), 0),
            };
        }
        self.nodes[number] = node;
        number as u32
    }
}

impl Hierarchy for Wide {
    fn over(boxes: &[Aabb]) -> Self {
        if boxes.is_empty() {
            return Self::default();
        }
        let mut tree = build_hierarchy(boxes);
        let mut wide = Self { nodes: Vec::new(), order: std::mem::take(&mut tree.primitive_indices) };
        wide.add(&tree, 0);
        wide.nodes.shrink_to_fit();
        wide
    }

    fn order(&self) -> &[u32] {
        &self.order
    }

    fn memory(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.order[..])
    }

    fn any(&self, ray: Ray, mut test: impl FnMut(&Ray, usize) -> bool) -> bool {
        let mut is_met = false;
        self.nearest(ray, |ray, index| {
            is_met = is_met || test(ray, index);
            // Nothing is nearer than that.
            if is_met { 0.0 } else { f32::INFINITY }
        });
        is_met
    }

    #[inline(always)]
    fn nearest(&self, mut ray: Ray, mut test: impl FnMut(&Ray, usize) -> f32) {
        let [ox, oy, oz] = ray.origin.to_array().map(Vec4::splat);
        let [ix, iy, iz] = ray.inv_direction.to_array().map(Vec4::splat);
        // Which plane of each axis the ray meets first.
        let near = [0, 1, 2].map(|axis| if ray.inv_direction[axis] < 0.0 { axis + 3 } else { axis });
        let far = near.map(|plane| (plane + 3) % 6);
        // Those still to be visited, the nearest of a node's last. Seven stay at a level: enough for 500,000 triangles.
        let mut stack: SmallVec<[Met; 96]> = SmallVec::new();
        let mut number = 0;
        while let Some(node) = self.nodes.get(number as usize) {
            let base = stack.len();
            for half in 0..2 {
                let [nx, ny, nz] = near.map(|plane| node.planes[plane][half]);
                let [fx, fy, fz] = far.map(|plane| node.planes[plane][half]);
                let enter = ((nx - ox) * ix).max((ny - oy) * iy).max(((nz - oz) * iz).max(Vec4::ZERO));
                let leave =
                    ((fx - ox) * ix).min((fy - oy) * iy).min(((fz - oz) * iz).min(Vec4::splat(ray.tmax)));
                let distances = enter.to_array();
                let mut met = enter.cmple(leave).bitmask();
                while met != 0 {
                    let lane = met.trailing_zeros() as usize;
                    met &= met - 1;
                    let distance = distances[lane];
                    let (first, count) = (node.first[4 * half + lane], node.count[4 * half + lane].into());
                    let mut place = stack.len();
                    stack.push(Met { first, count, distance });
                    while place > base && stack[place - 1].distance < distance {
                        stack.swap(place - 1, place);
                        place -= 1;
                    }
                }
            }
            number = loop {
                let Some(Met { first, count, distance }) = stack.pop() else { return };
                if distance >= ray.tmax {
                    continue;
                }
                if count == 0 {
                    break first;
                }
                for index in first..first + count {
                    ray.tmax = ray.tmax.min(test(&ray, index as usize));
                }
            };
        }
    }
}
