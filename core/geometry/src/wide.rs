//! A hierarchy of eight boxes a node, which are tested side by side, over leaves of a few elements: a ray waits for memory a third as
//! often as in a binary one.

use crate::ray::Ray;
use glam::{Vec3, Vec4};
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, leaf_collapser::collapse, reinsertion::ReinsertionOptimizer};
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use smallvec::SmallVec;

/// Boxes of a node.
const WIDTH: usize = 8;

/// Eight numbers.
type Eight = [Vec4; 2];

/// The bit of a leaf in the number of a box's content. Leaves of triangles that need it for their own numbers are 300 GB.
const LEAF: u32 = 1 << 31;

/// The content of an empty box: a node that there is not, for rays that are not numbers and seem to meet it.
const NOTHING: u32 = LEAF - 1;

/// In a leaf, behind the numbers of its elements.
pub(crate) const VACANT: u32 = u32::MAX;

/// Boxes side by side, and what is in them.
#[derive(Clone, Copy)]
#[repr(align(64))]
struct Node {
    /// Lower x, y, z, upper x, y, z. An empty box is the wrong way round: nothing hits it.
    planes: [Eight; 6],
    /// The number of a node, or of a leaf with [`LEAF`], or [`NOTHING`].
    contents: [u32; WIDTH],
}

/// The hierarchy.
#[derive(Clone, Default)]
pub(crate) struct Wide {
    nodes: Vec<Node>,
}

/// A ray as boxes are tested against it.
struct Slabs {
    origin: [Vec4; 3],
    inverse: [Vec4; 3],
    /// Which plane of each axis the ray meets first, and last.
    near: [usize; 3],
    far: [usize; 3],
}

impl Slabs {
    #[inline(always)]
    fn new(ray: &Ray) -> Self {
        let inverse = ray.inverse();
        let planes = |axis: usize| if inverse[axis] < 0.0 { (axis + 3, axis) } else { (axis, axis + 3) };
        let [x, y, z] = [planes(0), planes(1), planes(2)];
        Self {
            origin: splat(ray.origin),
            inverse: splat(inverse),
            near: [x.0, y.0, z.0],
            far: [x.1, y.1, z.1],
        }
    }

    /// Where the ray meets the boxes, and a bit for each that it meets at a distance in [0, `end`].
    #[inline(always)]
    fn meets(&self, node: &Node, end: f32) -> ([f32; WIDTH], u32) {
        let ([ox, oy, oz], [ix, iy, iz]) = (self.origin, self.inverse);
        let mut distances = [0.0; WIDTH];
        let mut lanes = 0;
        for half in 0..2 {
            let [nx, ny, nz] = self.near.map(|plane| node.planes[plane][half]);
            let [fx, fy, fz] = self.far.map(|plane| node.planes[plane][half]);
            let enter = ((nx - ox) * ix).max((ny - oy) * iy).max(((nz - oz) * iz).max(Vec4::ZERO));
            let leave = ((fx - ox) * ix).min((fy - oy) * iy).min(((fz - oz) * iz).min(Vec4::splat(end)));
            distances[4 * half..][..4].copy_from_slice(&enter.to_array());
            lanes |= enter.cmple(leave).bitmask() << (4 * half);
        }
        (distances, lanes)
    }
}

fn splat(v: Vec3) -> [Vec4; 3] {
    [Vec4::splat(v.x), Vec4::splat(v.y), Vec4::splat(v.z)]
}

impl Wide {
    /// Over boxes, up to N a leaf; returns the numbers of those in each leaf, and [`VACANT`] behind them.
    pub(crate) fn over<const N: usize>(boxes: &[Aabb]) -> (Self, Vec<[u32; N]>) {
        let (mut wide, mut leaves) = (Self::default(), Vec::new());
        if !boxes.is_empty() {
            wide.add(&binary(boxes, N as u32), 0, &mut leaves);
        }
        wide.nodes.shrink_to_fit();
        leaves.shrink_to_fit();
        (wide, leaves)
    }

    /// Adds the node that stands for one of the binary tree; returns its number.
    fn add<const N: usize>(&mut self, tree: &Bvh2, root: usize, leaves: &mut Vec<[u32; N]>) -> u32 {
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
        // The leaves of a node lie beside each other in memory.
        children.sort_by_key(|&child| !tree.nodes[child].is_leaf());
        let (lower, upper) = ([Vec4::INFINITY; 2], [Vec4::NEG_INFINITY; 2]);
        let planes = [lower, lower, lower, upper, upper, upper];
        let mut node = Node { planes, contents: [NOTHING; WIDTH] };
        let number = self.nodes.len();
        self.nodes.push(node);
        for (i, &child) in children.iter().enumerate() {
            let of = &tree.nodes[child];
            for axis in 0..3 {
                node.planes[axis][i / 4][i % 4] = of.aabb().min[axis];
                node.planes[axis + 3][i / 4][i % 4] = of.aabb().max[axis];
            }
            node.contents[i] = if of.is_leaf() {
                let elements = &tree.primitive_indices[of.first_index as usize..][..of.prim_count as usize];
                let mut leaf = [VACANT; N];
                leaf[..elements.len()].copy_from_slice(elements);
                leaves.push(leaf);
                LEAF | (leaves.len() - 1) as u32
            } else {
                self.add(tree, child, leaves)
            };
        }
        self.nodes[number] = node;
        number as u32
    }

    /// Memory held \[bytes\].
    pub(crate) fn memory(&self) -> usize {
        size_of_val(&self.nodes[..])
    }

    /// Tests the leaves in the ray's way, the nearest of a node's boxes first: `test` gets where the ray ends so far and the number of a leaf,
    /// and returns where it ends then. What is as far away as its end is tested too.
    #[inline(always)]
    pub(crate) fn nearest(&self, ray: &Ray, mut test: impl FnMut(f32, usize) -> f32) {
        let slabs = Slabs::new(ray);
        let mut end = ray.end;
        // Boxes still to be visited, the nearest of a node's last. Seven stay at a level: enough for 500,000 triangles.
        let mut stack: SmallVec<[u64; 96]> = SmallVec::new();
        let mut content = 0;
        loop {
            if content & LEAF != 0 {
                end = test(end, (content & !LEAF) as usize);
            } else if let Some(node) = self.nodes.get(content as usize) {
                let (distances, mut lanes) = slabs.meets(node, end);
                let (mut met, mut count) = ([0; WIDTH], 0);
                while lanes != 0 {
                    let lane = lanes.trailing_zeros() as usize;
                    lanes &= lanes - 1;
                    // The order of numbers >= 0 is that of their bits.
                    let key = u64::from(distances[lane].to_bits()) << 32 | u64::from(node.contents[lane]);
                    let mut place = count;
                    while place > 0 && met[place - 1] < key {
                        met[place] = met[place - 1];
                        place -= 1;
                    }
                    met[place] = key;
                    count += 1;
                }
                if let [others @ .., nearest] = &met[..count] {
                    others.iter().for_each(|&key| stack.push(key));
                    content = *nearest as u32;
                    continue;
                }
            }
            content = loop {
                match stack.pop() {
                    Some(key) if f32::from_bits((key >> 32) as u32) <= end => break key as u32,
                    Some(_) => {}
                    None => return,
                }
            };
        }
    }

    /// Whether `test` says so of the number of any leaf in the ray's way, in no order.
    #[inline(always)]
    pub(crate) fn any(&self, ray: &Ray, mut test: impl FnMut(usize) -> bool) -> bool {
        let slabs = Slabs::new(ray);
        let mut stack: SmallVec<[u32; 96]> = SmallVec::new();
        stack.push(0);
        while let Some(number) = stack.pop() {
            let Some(node) = self.nodes.get(number as usize) else { continue };
            let (_, mut lanes) = slabs.meets(node, ray.end);
            while lanes != 0 {
                let content = node.contents[lanes.trailing_zeros() as usize];
                lanes &= lanes - 1;
                if content & LEAF == 0 {
                    stack.push(content);
                } else if test((content & !LEAF) as usize) {
                    return true;
                }
            }
        }
        false
    }
}

/// Builds a binary hierarchy over boxes, up to `most` a leaf, at 0.2 us each.
fn binary(boxes: &[Aabb], most: u32) -> Bvh2 {
    // The steps of obvhs' `build_bvh2` with its medium preset, without the validation that it adds in debug
    // builds.
    let mut hierarchy = PlocBuilder::with_capacity(boxes.len()).build(
        PlocSearchDistance::Medium,
        boxes,
        (0..boxes.len() as u32).collect(),
        SortPrecision::U64,
        3,
    );
    let mut optimizer = ReinsertionOptimizer::default();
    optimizer.run(&mut hierarchy, 0.05, None);
    collapse(&mut hierarchy, most, 3.0);
    optimizer.run(&mut hierarchy, 0.1, None);
    hierarchy
}
