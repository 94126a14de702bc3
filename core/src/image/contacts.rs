//! Regions that face themselves across a silhouette, taken apart where their surface bends most.

use super::regions::{inverse_depth, is_apart, root};
use core::fmt;

use super::pixel_count;

/// Bends of inverse depth are told apart by factors of 2, from this share of it on; rounding is below.
const LEAST_BEND: f32 = 1e-6;

/// So many factors of 2 above, all are alike.
const BENDS: u8 = 16;

/// In place of a bend: there is no link to the next pixel.
const NO_LINK: u8 = u8::MAX;

/// Pixels from one side of a silhouette to the other: between them is one at a border on each side.
const ACROSS: u32 = 3;

/// Pairs of parts that are remembered as not to be joined.
const REMEMBERED: usize = 64;

/// Scratch memory of [`part_regions`]: one a pixel.
#[derive(Clone, Copy, Debug, Default)]
pub struct RegionNode {
    /// Of a part's first pixel: a pixel of it that faces something across a silhouette, counted from 1, or 0; and how many do.
    head: u32,
    count: u32,
    /// Of a pixel that does: the next one of its part, around.
    next: u32,
    /// Where it faces its own region: the next pixel but two in its row, the one before, and in its column.
    faces: u8,
    /// Of its links to the next pixel in its row and column.
    bends: [u8; 2],
    /// Whether its region is taken apart.
    is_parted: bool,
}

/// Why [`part_regions`] refused a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PartError {
    /// A slice of another length than the picture has pixels, or a picture that is too large, as in [`super::FilmSizeError`].
    Size,
    /// A label that is neither 0 nor the number of a pixel which has that label.
    Label,
}

impl fmt::Display for PartError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            PartError::Size => super::FilmSizeError.fmt(f),
            PartError::Label => f.write_str("a label is not the number of a region's first pixel"),
        }
    }
}

impl core::error::Error for PartError {}

/// Takes regions of [`super::film_regions`] apart that lie on both sides of a silhouette. A pillar that stands on
/// a floor is one surface with it, and with what is behind its top; a filter there would reach over the pillar's
/// border.
///
/// - `width`, `height`, `depth`, `labels`: as that function took and left them. Regions that face themselves
///   nowhere stay what they are, and pixels at borders 0. Parts have the number of their first pixel.
/// - `nodes`: one a pixel; what they hold does not matter.
///
/// Neighbours are joined from those between which the surface bends least, to those where it does most, as long
/// as none that face each other across a silhouette are joined: a pillar is cut off where it meets the floor, and
/// a smooth fold somewhere.
///
/// Cost: 15 ns a pixel, in regions that are taken apart up to 140 ns. Errors: [`PartError`]; nothing changes.
pub fn part_regions(
    width: u32,
    height: u32,
    depth: &[f32],
    labels: &mut [u32],
    nodes: &mut [RegionNode],
) -> Result<(), PartError> {
    let count = pixel_count(width, height).map_err(|_| PartError::Size)?;
    if depth.len() != count || labels.len() != count || nodes.len() != count {
        return Err(PartError::Size);
    }
    let is_first = |label: u32| label == 0 || labels.get(label as usize - 1) == Some(&label);
    if !labels.iter().all(|label| is_first(*label)) {
        return Err(PartError::Label);
    }
    nodes.fill(RegionNode::default());
    let lines = Lines { width, height, depth };
    if !lines.find_faces(labels, nodes) {
        return Ok(());
    }
    for (pixel, label) in labels.iter().enumerate().filter(|(_, label)| **label > 0) {
        nodes[pixel].is_parted = nodes[*label as usize - 1].is_parted;
    }
    lines.find_bends(nodes);
    for (pixel, (label, node)) in labels.iter_mut().zip(nodes.iter_mut()).enumerate() {
        if !node.is_parted {
            continue;
        }
        let own = pixel as u32 + 1;
        *label = own;
        if node.faces != 0 {
            (node.head, node.count, node.next) = (own, 1, own);
        }
    }
    let mut parts = Parts { labels, nodes, width, refused: [[0; 2]; REMEMBERED] };
    for bend in 0..=BENDS {
        for (axis, stride) in [(0, 1), (1, width)] {
            for pixel in 0..count {
                if parts.nodes[pixel].is_parted && parts.nodes[pixel].bends[axis] == bend {
                    parts.join(pixel as u32 + 1, pixel as u32 + 1 + stride);
                }
            }
        }
    }
    for pixel in 0..count {
        if nodes[pixel].is_parted {
            labels[pixel] = root(labels, pixel as u32 + 1);
        }
    }
    Ok(())
}

/// A picture's rows and columns.
struct Lines<'a> {
    width: u32,
    height: u32,
    depth: &'a [f32],
}

/// A pixel in its row or column: its number, its place in it, how many that has, and the step from one to the next.
struct Place {
    pixel: usize,
    at: usize,
    count: usize,
    stride: usize,
}

impl Lines<'_> {
    /// Of all pixels, in rows (axis 0) or in columns (1).
    fn places(&self, axis: usize) -> impl Iterator<Item = Place> + use<> {
        let [width, height] = [self.width as usize, self.height as usize];
        (0..height).flat_map(move |y| (0..width).map(move |x| [x, y])).map(move |at| Place {
            pixel: at[1] * width + at[0],
            at: at[axis],
            count: [width, height][axis],
            stride: [1, width][axis],
        })
    }

    /// Marks the pixels that face their own region across a silhouette, and the first pixel of such regions. Returns whether there are any.
    fn find_faces(&self, labels: &[u32], nodes: &mut [RegionNode]) -> bool {
        let inverse = inverse_depth(self.depth);
        let mut is_any = false;
        for axis in 0..2 {
            for Place { pixel, at, count, stride } in self.places(axis) {
                if at + ACROSS as usize >= count || labels[pixel] == 0 {
                    continue;
                }
                let [near, far, beyond] = [1, 2, 3].map(|steps| pixel + steps * stride);
                let is_one = labels[near] == 0 && labels[far] == 0 && labels[beyond] == labels[pixel];
                if is_one && is_apart(&inverse, near, at + 1, count, stride) {
                    nodes[pixel].faces |= 1 << (2 * axis);
                    nodes[beyond].faces |= 2 << (2 * axis);
                    nodes[labels[pixel] as usize - 1].is_parted = true;
                    is_any = true;
                }
            }
        }
        is_any
    }

    /// How much inverse depth bends between each pixel and the next one, where both are of regions that are taken apart.
    fn find_bends(&self, nodes: &mut [RegionNode]) {
        let inverse = inverse_depth(self.depth);
        for axis in 0..2 {
            for Place { pixel, at, count, stride } in self.places(axis) {
                let is_link = at + 1 < count && nodes[pixel].is_parted && nodes[pixel + stride].is_parted;
                let bend = |pixel: usize, at: usize| {
                    if at == 0 || at + 1 >= count {
                        return 0.0;
                    }
                    let [before, here, behind] = [pixel - stride, pixel, pixel + stride].map(&inverse);
                    (before - 2.0 * here + behind).abs() / here
                };
                nodes[pixel].bends[axis] = if is_link {
                    let most = bend(pixel, at).max(bend(pixel + stride, at + 1)) / LEAST_BEND;
                    // Whole powers of 2. Where there is no surface it is 0 or NaN.
                    if most > 1.0 { ((most.to_bits() >> 23) - 127).min(u32::from(BENDS)) as u8 } else { 0 }
                } else {
                    NO_LINK
                };
            }
        }
    }
}

/// Parts of regions: trees of pixels that point at an earlier one, each with a ring of those that face something.
struct Parts<'a> {
    labels: &'a mut [u32],
    nodes: &'a mut [RegionNode],
    width: u32,
    /// First pixels of parts that were not joined.
    refused: [[u32; 2]; REMEMBERED],
}

impl Parts<'_> {
    /// Joins the parts of two pixels unless they face each other.
    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (root(self.labels, a), root(self.labels, b));
        let pair = [a.min(b), a.max(b)];
        let slot = pair[0].wrapping_mul(31).wrapping_add(pair[1]) as usize % REMEMBERED;
        if a == b || self.refused[slot] == pair {
            return;
        }
        let [first, second] = pair.map(|root| self.nodes[root as usize - 1]);
        let (few, other) = if first.count < second.count { (first, pair[1]) } else { (second, pair[0]) };
        if self.faces(&few, other) {
            self.refused[slot] = pair;
            return;
        }
        let [root, joined] = pair.map(|root| root as usize - 1);
        if first.head != 0 && second.head != 0 {
            let [one, two] = [first.head, second.head].map(|head| head as usize - 1);
            (self.nodes[one].next, self.nodes[two].next) = (self.nodes[two].next, self.nodes[one].next);
        }
        self.nodes[root].head = first.head.max(second.head);
        self.nodes[root].count = first.count + second.count;
        self.labels[joined] = pair[0];
    }

    /// Whether any pixel of a part faces one of another part.
    fn faces(&mut self, part: &RegionNode, other: u32) -> bool {
        let mut pixel = part.head;
        for _ in 0..part.count {
            let node = self.nodes[pixel as usize - 1];
            let faced =
                [ACROSS, ACROSS.wrapping_neg(), ACROSS * self.width, (ACROSS * self.width).wrapping_neg()];
            let mut is_faced = |(bit, step): (usize, u32)| {
                node.faces & 1 << bit != 0 && root(self.labels, pixel.wrapping_add(step)) == other
            };
            if faced.into_iter().enumerate().any(&mut is_faced) {
                return true;
            }
            pixel = node.next;
        }
        false
    }
}
