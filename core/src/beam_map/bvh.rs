//! A bounding volume hierarchy over sub-beams, eight to a node, made from a binary one; built in slices of
//! bounded work.
//!
//! Clusters are merged as obvhs merges them (locally ordered clustering). Its own builder cannot be stopped,
//! and takes quadratic time over many equal boxes.

use super::cancel::{Poll, STRETCH, Stop};
use super::room::{Pieces, grow, release, with_room};
use super::simd::{LANES, Vectors};
use super::sub_beams::{Cut, MortonCode, ROOM, SubBeam};
use crate::beam::{BLOCK, Beam};
use glam::{Vec3, Vec3A};
use std::vec::Vec;

/// Sub-beams of the largest subtree that is built at a time: its working memory fits a processor's own cache.
const CHUNK: usize = 1 << 14;

/// A box, and what is in it: the sub-beams `first..first + count`, or with `count` 0 the nodes `first` and
/// `first + 1`.
#[derive(Clone, Copy, Default)]
struct Node {
    low: Vec3,
    first: u32,
    high: Vec3,
    count: u32,
}

impl Node {
    fn new(low: Vec3A, high: Vec3A, first: u32, count: u32) -> Self {
        Self { low: low.into(), first, high: high.into(), count }
    }

    fn around(sub_beam: &SubBeam, padding: f32, first: u32) -> Self {
        // An accepted eye point lies within the radius of the segment, caps included (see `gather_pair`).
        let [start, end] = sub_beam.ends();
        let (low, high) = (start.min(end), start.max(end));
        // Far from the world's origin the ends are rounded by more than kernels are wide.
        let padding = padding + 2.0 * f32::EPSILON * low.abs().max(high.abs()).max_element();
        Self { low: low - padding, first, high: high + padding, count: 1 }
    }

    #[inline]
    fn low(&self) -> Vec3A {
        self.low.into()
    }

    #[inline]
    fn high(&self) -> Vec3A {
        self.high.into()
    }

    #[inline]
    fn union(&self, other: &Self) -> (Vec3A, Vec3A) {
        (self.low().min(other.low()), self.high().max(other.high()))
    }

    fn half_area(&self) -> f32 {
        half_area((self.low(), self.high()))
    }
}

#[inline]
fn half_area((low, high): (Vec3A, Vec3A)) -> f32 {
    let extent = high - low;
    (extent * Vec3A::new(extent.y, extent.z, extent.x)).element_sum()
}

/// Up to eight boxes side by side, and what is in each: the sub-beams `first..first + count`, or with `count`
/// 0 the node `first`.
#[derive(Clone, Copy, Default)]
pub(super) struct WideNode {
    pub(super) low: Vectors,
    pub(super) high: Vectors,
    pub(super) first: [u32; LANES],
    pub(super) count: [u32; LANES],
    /// A bit for each lane that holds a box.
    pub(super) lanes: u32,
}

impl WideNode {
    fn set(&mut self, lane: usize, node: &Node) {
        for axis in 0..3 {
            self.low[axis][lane] = node.low[axis];
            self.high[axis][lane] = node.high[axis];
        }
        (self.first[lane], self.count[lane]) = (node.first, node.count);
        self.lanes |= 1 << lane;
    }
}

/// The nodes, root first (none over no sub-beams), and the sub-beams in the order in which a walk meets them:
/// a leaf's are neighbours in memory, and so are those of a subtree.
#[derive(Clone)]
pub(super) struct Bvh {
    pub(super) nodes: Vec<WideNode>,
    pub(super) sub_beams: Vec<SubBeam>,
    /// What each box is grown by \[m\].
    pub(super) padding: f32,
    /// Nodes that are found and not yet visited by a walk through all of them, at most.
    pub(super) most_waiting: usize,
}

impl Bvh {
    /// - `max_radius`: largest radius that it is asked about \[m\].
    pub(super) fn new(
        beams: &[Beam],
        cut: &Cut,
        codes: &[MortonCode],
        max_radius: f32,
        poll: &mut Poll,
    ) -> Result<Self, Stop> {
        let padding = max_radius * ROOM;
        BinaryBvh::new(beams, cut, codes, padding, poll)?.widen(padding, poll)
    }
}

/// The nodes, root first (none over no sub-beams), and the sub-beams in the order of the leaves.
struct BinaryBvh {
    nodes: Vec<Node>,
    sub_beams: Vec<SubBeam>,
}

impl BinaryBvh {
    /// Chunks of neighbouring sub-beams become subtrees, and these the leaves of one more tree, that at the
    /// top.
    fn new(
        beams: &[Beam],
        cut: &Cut,
        codes: &[MortonCode],
        padding: f32,
        poll: &mut Poll,
    ) -> Result<Self, Stop> {
        let mut tree = Self { nodes: Vec::new(), sub_beams: with_room(codes.len())? };
        if codes.is_empty() {
            return Ok(tree);
        }
        tree.nodes = with_room(2 * codes.len() - 1)?;
        let chunks = codes.len().div_ceil(CHUNK);
        let largest = codes.len().div_ceil(chunks);
        // The nodes at the top come first.
        tree.nodes.resize(2 * chunks - 1, Node::default());
        let mut clusters = Clusters::with_room(largest.max(chunks))?;
        let mut roots: Vec<Node> = with_room(chunks)?;
        let mut sub_beams = with_room(largest)?;
        for chunk in codes.chunks(largest) {
            sub_beams.clear();
            for stretch in chunk.chunks(STRETCH) {
                poll.spend(stretch.len(), 200)?;
                sub_beams.extend(stretch.iter().map(|code| cut.sub_beam(beams, code)));
            }
            clusters
                .build((0..).zip(&sub_beams).map(|(i, sub_beam)| Node::around(sub_beam, padding, i)), poll)?;
            clusters.collapse();
            poll.spend(chunk.len(), 60)?;
            roots.push(tree.append(&clusters.tree, &sub_beams)?);
        }
        clusters.build((0..).zip(&roots).map(|(i, root)| Node { first: i, count: 1, ..*root }), poll)?;
        for (node, top) in tree.nodes.iter_mut().zip(&clusters.tree) {
            *node = if top.count == 0 { *top } else { roots[top.first as usize] };
        }
        Ok(tree)
    }

    /// Gives each node the eight largest boxes below it.
    fn widen(self, padding: f32, poll: &mut Poll) -> Result<Bvh, Stop> {
        let mut sub_beams = with_room(self.sub_beams.len())?;
        let (mut nodes, mut most_waiting) = (Pieces::new(), 1);
        // Nodes still to be made: of which subtree, and where they go.
        let mut stack = with_room(1)?;
        if let Some(root) = self.nodes.first() {
            nodes.push(WideNode::default())?;
            stack.push((*root, 0));
        }
        while let Some((root, slot)) = stack.pop() {
            poll.spend(1, 400)?;
            let mut children = [root; LANES];
            let mut count = 1;
            while count < LANES {
                let inner = (0..count).filter(|i| children[*i].count == 0);
                let area = |i: &usize| children[*i].half_area();
                let Some(largest) = inner.max_by(|a, b| area(a).total_cmp(&area(b))) else { break };
                // Neighbours in space stay neighbours.
                children.copy_within(largest + 1..count, largest + 2);
                let pair = children[largest].first as usize;
                children[largest..largest + 2].copy_from_slice(&self.nodes[pair..pair + 2]);
                count += 1;
            }
            let mut node = WideNode::default();
            for (lane, child) in children[..count].iter_mut().enumerate() {
                let first = child.first as usize;
                if child.count > 0 {
                    child.first = sub_beams.len() as u32;
                    sub_beams.extend_from_slice(&self.sub_beams[first..first + child.count as usize]);
                }
                node.set(lane, child);
            }
            // The last is taken from the stack first: a walk and this loop meet the nodes in the same order.
            for lane in (0..count).rev().filter(|lane| children[*lane].count == 0) {
                node.first[lane] = u32::try_from(nodes.len()).map_err(|_| Stop::TooMany)?;
                grow(&mut stack, 1)?;
                stack.push((children[lane], nodes.len()));
                nodes.push(WideNode::default())?;
            }
            most_waiting = most_waiting.max(stack.len());
            nodes.set(slot, node);
        }
        release(self.nodes, poll)?;
        release(self.sub_beams, poll)?;
        Ok(Bvh { nodes: nodes.joined(poll)?, sub_beams, padding, most_waiting })
    }

    /// Appends what is below the root of a chunk's tree, depth first, and returns the root.
    fn append(&mut self, chunk: &[Node], sub_beams: &[SubBeam]) -> Result<Node, Stop> {
        let mut root = chunk[0];
        let mut stack = with_room(1)?;
        stack.push((0, None));
        while let Some((index, slot)) = stack.pop() {
            let mut node: Node = chunk[index];
            if node.count == 0 {
                let (child, pair) = (node.first as usize, self.nodes.len());
                grow(&mut stack, 2)?;
                stack.extend([(child + 1, Some(pair + 1)), (child, Some(pair))]);
                self.nodes.extend([Node::default(); 2]);
                node.first = pair as u32;
            } else {
                node.first = self.sub_beams.len() as u32;
                self.append_leaves(chunk, index, sub_beams);
            }
            match slot {
                Some(slot) => self.nodes[slot] = node,
                None => root = node,
            }
        }
        Ok(root)
    }

    /// Appends the sub-beams below a node that became a leaf: at most [`BLOCK`], so the recursion is shallow.
    fn append_leaves(&mut self, chunk: &[Node], index: usize, sub_beams: &[SubBeam]) {
        let Node { first, count, .. } = chunk[index];
        if count == 1 {
            self.sub_beams.push(sub_beams[first as usize]);
        } else {
            self.append_leaves(chunk, first as usize, sub_beams);
            self.append_leaves(chunk, first as usize + 1, sub_beams);
        }
    }
}

/// Builds trees by joining neighbours in a list: two become one node where each is the one with which the
/// other has the smaller box, and so on until one is left.
///
/// Source: Meister and Bittner, Parallel Locally-Ordered Clustering (2018), with a search distance of 1.
struct Clusters {
    /// The roots of the trees so far.
    list: Vec<Node>,
    /// Per root: whether it would join the one before it rather than the one after.
    back: Vec<bool>,
    /// The nodes, root first, children after their parents and side by side.
    tree: Vec<Node>,
}

impl Clusters {
    fn with_room(leaves: usize) -> Result<Self, Stop> {
        Ok(Self { list: with_room(leaves)?, back: with_room(leaves)?, tree: with_room(2 * leaves)? })
    }

    /// Fills `tree` with the tree over `leaves`, at least one; their `first` and `count` are kept.
    fn build(&mut self, leaves: impl Iterator<Item = Node>, poll: &mut Poll) -> Result<(), Stop> {
        let Self { list, back, tree } = self;
        list.clear();
        list.extend(leaves);
        let mut free = 2 * list.len() - 1;
        tree.clear();
        tree.resize(free, Node::default());
        while list.len() > 1 {
            let count = list.len();
            poll.spend(count, 30)?;
            back.clear();
            let mut before = f32::INFINITY;
            for pair in list.windows(2) {
                let area = half_area(pair[0].union(&pair[1]));
                back.push(before < area);
                before = area;
            }
            back.push(true);
            let joins = back.windows(2).filter(|pair| !pair[0] && pair[1]).count();
            // Equal boxes, or ever smaller ones, would join one pair in a round: then all neighbours join.
            if joins < count / 16 {
                back.iter_mut().enumerate().for_each(|(i, back)| *back = i % 2 == 1);
            }
            let (mut i, mut kept) = (0, 0);
            while i < count {
                let node = list[i];
                if i + 1 < count && !back[i] && back[i + 1] {
                    free -= 2;
                    (tree[free], tree[free + 1]) = (node, list[i + 1]);
                    let (low, high) = node.union(&list[i + 1]);
                    list[kept] = Node::new(low, high, free as u32, 0);
                    i += 2;
                } else {
                    list[kept] = node;
                    i += 1;
                }
                kept += 1;
            }
            list.truncate(kept);
        }
        tree[0] = list[0];
        Ok(())
    }

    /// Makes a leaf of every node over at most [`BLOCK`] leaves: these are tested together. Its `count`
    /// becomes that of the leaves below it.
    fn collapse(&mut self) {
        for i in (0..self.tree.len()).rev() {
            let Node { first, count: 0, .. } = self.tree[i] else { continue };
            let [a, b] = [0, 1].map(|side| self.tree[first as usize + side].count);
            if a > 0 && b > 0 && a + b <= BLOCK as u32 {
                self.tree[i].count = a + b;
            }
        }
    }
}
