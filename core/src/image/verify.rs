//! Filters checked by the samples: one is narrowed where what it gives disagrees with what narrower ones
//! give.

use super::{FilmFilterNode, FilmFilters, FilmLattice, FilmSizeError, Reconstruction};

/// Widths that are compared: the predicted one, a half, a quarter, …
pub(super) const SCALES: usize = 7;

/// Nodes to each side whose evidence counts.
const WINDOW: i32 = 4;

/// A filter's squared difference to a narrower one counts as error beyond this many of the narrower one's
/// variances. With less, noise narrows filters in patches; with 2.5 smooth light has up to 1.4 times the
/// error.
const TOLERANCE: f32 = 1.5;

/// Halves whose differences are within this share of each other's have not met by chance: what leaks differs by
/// its noise, a fifth after some ten passes.
const ALIKE: f32 = 0.25;

/// Luminance at a node through filters of all widths, of each half of the passes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FilmEvidence {
    /// Of the odd passes.
    pub first: [f32; SCALES],
    /// Of the even passes.
    pub second: [f32; SCALES],
    /// What errors count relative to: of all passes, through the widest filter, and of other layers
    /// ([`FilmEvidence::beside`]); 0 = one of the halves has no rays there.
    pub brightness: f32,
}

impl FilmEvidence {
    /// The same in a picture that keeps its light in several layers, each with filters of its own, which add
    /// up: an error counts relative to what is seen. Relative to the light of a layer that has next to none
    /// there, the few rays that meet some would seem as uncertain as filters that leak are wrong.
    ///
    /// - `others`: luminance at the node of the other layers, finite, >= 0; taken as 0 if it is negative.
    #[must_use]
    pub fn beside(mut self, others: f32) -> Self {
        if self.brightness > 0.0 {
            self.brightness += others.max(0.0);
        }
        self
    }

    /// Luminance through a filter and of other layers.
    fn seen(&self, scale: usize) -> f32 {
        self.both(scale) + (self.brightness - self.both(0))
    }

    fn both(&self, scale: usize) -> f32 {
        0.5 * (self.first[scale] + self.second[scale])
    }
}

impl FilmFilters<'_> {
    /// What the samples say of a node's filter.
    pub fn evidence(&self, node: usize, picture: &Reconstruction) -> FilmEvidence {
        let Some(found) = self.nodes.get(node) else { return FilmEvidence::default() };
        if !(found.weight > 0.0) {
            return FilmEvidence::default();
        }
        let [x, y] = self.lattice.pixel(node);
        let mut evidence = FilmEvidence::default();
        let mut filter = found.inverse.inverse();
        let mut known = None;
        for scale in 0..SCALES {
            // With too few rays: what is known of the wider one.
            if let Some(halves) = picture.sum(x, y, &filter.into()).halves() {
                known = Some(halves);
                filter = filter.map(|value| 0.25 * value);
            }
            let Some([first, second]) = known else { return FilmEvidence::default() };
            (evidence.first[scale], evidence.second[scale]) = (first, second);
        }
        evidence.brightness = evidence.both(0);
        evidence
    }
}

/// Narrows filters where the samples disagree with them, and notes the standard error of what is left.
pub fn verify_filters(
    lattice: &FilmLattice,
    evidence: &[FilmEvidence],
    nodes: &mut [FilmFilterNode],
) -> Result<(), FilmSizeError> {
    if evidence.len() != lattice.node_count() || nodes.len() != evidence.len() {
        return Err(FilmSizeError);
    }
    for index in 0..nodes.len() {
        if !(nodes[index].weight > 0.0 && evidence[index].brightness > 0.0) {
            continue;
        }
        let (scale, variance) = choose(lattice, evidence, nodes, index);
        let node = &mut nodes[index];
        let finer = (1_u32 << (2 * scale)) as f32;
        node.inverse = node.inverse.map(|value| value * finer);
        node.variance = variance * evidence[index].seen(scale) * evidence[index].seen(scale);
    }
    Ok(())
}

/// The filter of the least estimated error, and its relative variance: what it is off beyond noise by the
/// narrower ones, and its variance (the rule of A. Goldenshluger and O. Lepski, Bandwidth selection in kernel
/// density estimation, Ann. Statist. 39, 2011). The widest that agrees with all narrower ones would be
/// refused for their noise alone: beams lie across many nodes, so that two halves that agree by chance agree
/// over the whole window, and leave a patch of bare rays.
fn choose(
    lattice: &FilmLattice,
    evidence: &[FilmEvidence],
    nodes: &[FilmFilterNode],
    index: usize,
) -> (usize, f32) {
    // Means over the nodes around: of the variance of each width, and of the squared difference of each two,
    // free of noise because it is a product of the two halves'. The largest of these products is left out: a
    // pixel that is bright in both halves by chance would decide for all nodes around, and what is light is
    // seen by more than one; or, at the border of a picture or of a region, by one again and again, until both
    // halves are alike.
    let mut variance = [0.0_f32; SCALES];
    let mut bias = [[0.0_f32; SCALES]; SCALES];
    let mut largest = [[0.0_f32; SCALES]; SCALES];
    let mut count = 0.0;
    for row in -WINDOW..=WINDOW {
        for column in -WINDOW..=WINDOW {
            let Some(other) = lattice.neighbour(index, [column, row]) else { continue };
            let found = &evidence[other];
            if nodes[other].region != nodes[index].region || !(found.brightness > 0.0) {
                continue;
            }
            let weight = ((WINDOW + 1 - row.abs()) * (WINDOW + 1 - column.abs())) as f32;
            // Relative, so that no picture is too dim or too bright to be squared.
            let first = found.first.map(|light| light / found.brightness);
            let second = found.second.map(|light| light / found.brightness);
            count += weight;
            for (wide, (variance, bias)) in variance.iter_mut().zip(&mut bias).enumerate() {
                let difference = first[wide] - second[wide];
                *variance += 0.25 * weight * difference * difference;
                for (narrow, bias) in bias.iter_mut().enumerate().skip(wide + 1) {
                    let [a, b] = [first[wide] - first[narrow], second[wide] - second[narrow]];
                    let squared = weight * a * b;
                    *bias += squared;
                    if squared > largest[wide][narrow]
                        && !((a - b).abs() <= ALIKE * a.abs() && is_at_border(lattice, nodes, other))
                    {
                        largest[wide][narrow] = squared;
                    }
                }
            }
        }
    }
    // A narrower filter has fewer rays: where its variance seems less, the halves agreed by chance.
    for narrow in 1..SCALES {
        variance[narrow] = variance[narrow].max(variance[narrow - 1]);
    }
    let error = |wide: usize| {
        let beyond = |narrow| bias[wide][narrow] - largest[wide][narrow] - TOLERANCE * variance[narrow];
        variance[wide] + (wide + 1..SCALES).map(beyond).fold(0.0, f32::max)
    };
    let mut best = (0, error(0));
    for scale in 1..SCALES {
        let error = error(scale);
        if error < best.1 {
            best = (scale, error);
        }
    }
    (best.0, variance[best.0] / count)
}

/// Whether a node beside this one is missing, of another region, or sees no medium.
fn is_at_border(lattice: &FilmLattice, nodes: &[FilmFilterNode], node: usize) -> bool {
    let beside = [[-1, 0], [1, 0], [0, -1], [0, 1]].map(|step| lattice.neighbour(node, step));
    beside
        .iter()
        .any(|at| at.is_none_or(|at| nodes[at].region != nodes[node].region || !(nodes[at].weight > 0.0)))
}
