//! Layers of a film: a reconstruction of one kind of light, and the memory that it needs.

use crate::heap::reserved;
use crate::status::Failure;
use core::slice;
use covbeam_core::{FilmLattice, FilmNode, FilmSample, Reconstruction};

pub(super) const FITS: &str = "as long as the picture asks for";

pub(super) struct Layer {
    pub(super) samples: Vec<FilmSample>,
    pub(super) blocks: Vec<FilmNode>,
    /// Of the two above, and of the film's regions.
    pub(super) view: Reconstruction<'static>,
}

impl Layer {
    /// # Safety
    /// The memory of `regions` outlives the layer, and does not change.
    pub(super) unsafe fn new(
        lattice: &FilmLattice,
        samples: Vec<FilmSample>,
        regions: &[u32],
    ) -> Result<Self, Failure> {
        let FilmLattice { width, height, .. } = *lattice;
        let mut blocks = filled(Reconstruction::node_count(width, height), FilmNode::default())?;
        // SAFETY: the memory of a vector stays where it is when the vector moves, and neither is written again while the view lives, which
        // goes with them and is not handed out; the regions by the caller's promise.
        let (all, regions, nodes) = unsafe {
            (
                slice::from_raw_parts(samples.as_ptr(), samples.len()),
                slice::from_raw_parts(regions.as_ptr(), regions.len()),
                slice::from_raw_parts_mut(blocks.as_mut_ptr(), blocks.len()),
            )
        };
        let view = Reconstruction::new(width, height, all, regions, nodes).expect(FITS);
        Ok(Self { samples, blocks, view })
    }
}

pub(super) fn filled<T: Clone>(count: usize, value: T) -> Result<Vec<T>, Failure> {
    let mut vector = reserved(count)?;
    vector.resize(count, value);
    Ok(vector)
}
