//! The spectra of the light in the voxels, a layer each: grids that light fields are added to, and what is looked up in them.

use crate::kind::{Kind, Split};
use crate::paths::PhotonTracer;
use crate::paths::record::FieldSegment;
use crate::plan::FirstSurfaces;
use covbeam::{
    CovarianceGrid, FluenceCell, FluenceGrid, GridCell, GridError, GridLayout, ImageSpectrum, Medium,
};

const FITS: &str = "as many cells as the grid has";
const VALID: &str = "the scene's grid was validated";

/// One layer's spectra.
struct Grid {
    cells: Vec<GridCell>,
    resolved: Vec<FluenceCell>,
    /// Of the picture, from `resolved`; None: not asked for yet.
    image: Option<Vec<ImageSpectrum>>,
}

/// The spectra of all layers.
///
/// Scattered light has spectra of its own. Those of the other layers are of all light: they have voxels without any light of theirs, where
/// nothing would be known of the borders nearby. (Means over the fluence of all layers, for what a kernel or a filter gets wrong relative
/// to all light, leak light into the dark beside a cone that shines through a slit: 1.5 times its light.)
pub(crate) struct Grids {
    layout: GridLayout,
    split: Split,
    layers: Vec<Grid>,
    /// The last pass whose light fields are in the grids, and all before it.
    deposited: u32,
    /// What `deposited` was when they were resolved; 0 = never.
    resolved: u32,
}

impl Grids {
    /// Empty ones.
    pub(crate) fn new(layout: GridLayout, split: Split) -> Self {
        let count = layout.cell_count();
        let grid = || Grid {
            cells: vec![GridCell::default(); count],
            resolved: vec![FluenceCell::default(); count],
            image: None,
        };
        let layers = (0..split.count()).map(|_| grid()).collect();
        Self { layout, split, layers, deposited: 0, resolved: 0 }
    }

    /// The last pass whose light fields are in the grids, and all before it; 0 = none.
    pub(crate) fn deposited(&self) -> u32 {
        self.deposited
    }

    /// All light fields so far, one grid a layer, as the core saves them.
    pub(crate) fn save(&self) -> Vec<u8> {
        let mut bytes = vec![0; self.layout.saved_size() * self.layers.len()];
        for (grid, out) in self.layers.iter().zip(bytes.chunks_mut(self.layout.saved_size())) {
            self.layout.save(&grid.cells, out).expect(FITS);
        }
        bytes
    }

    /// Replaces all light fields by saved ones, those after pass `after`.
    ///
    /// # Errors
    /// They are of other grids; this one is of no use then.
    pub(crate) fn load(&mut self, after: u32, saved: &[u8]) -> Result<(), GridError> {
        let size = self.layout.saved_size();
        if saved.len() != size * self.layers.len() {
            return Err(GridError::Length);
        }
        for (grid, saved) in self.layers.iter_mut().zip(saved.chunks(size)) {
            CovarianceGrid::new(self.layout, &mut grid.cells)?.load(saved)?;
        }
        self.deposited = after;
        Ok(())
    }

    /// Forgets all light fields.
    pub(crate) fn clear(&mut self) {
        self.layers.iter_mut().for_each(|grid| grid.cells.fill(GridCell::default()));
        self.deposited = 0;
    }

    /// Adds the light fields of pass `pass`.
    pub(crate) fn deposit(&mut self, pass: u32, tracer: &PhotonTracer, deposits: &[(u32, FieldSegment)]) {
        for (layer, grid) in self.layers.iter_mut().enumerate() {
            let mut grid = CovarianceGrid::new(self.layout, &mut grid.cells).expect(VALID);
            let of_layer = deposits.iter().filter(|(_, segment)| self.split.of(segment.kind) == layer);
            tracer.deposit_into(&mut grid, of_layer);
        }
        self.deposited = pass;
    }

    /// Makes what was added ready to be looked up.
    pub(crate) fn resolve(&mut self) {
        // A pass that was cancelled before this leaves fields that are not resolved.
        if self.resolved == self.deposited {
            return;
        }
        self.resolved = self.deposited;
        let mut all = vec![GridCell::default(); self.layout.cell_count()];
        let mut all = CovarianceGrid::new(self.layout, &mut all).expect(VALID);
        self.layers.iter().for_each(|grid| all.merge(&grid.cells).expect(FITS));
        let scattered = self.split.of(Kind::Scattered);
        for (layer, grid) in self.layers.iter_mut().enumerate() {
            if layer == scattered {
                let own = CovarianceGrid::new(self.layout, &mut grid.cells).expect(VALID);
                own.resolve(&mut grid.resolved).expect(FITS);
            } else {
                all.resolve(&mut grid.resolved).expect(FITS);
            }
            grid.image = None;
        }
    }

    /// A layer's cells, resolved.
    pub(crate) fn cells(&self, layer: usize) -> &[FluenceCell] {
        &self.layers[layer].resolved
    }

    /// The same, to be looked up.
    pub(crate) fn look_up(&self, layer: usize) -> FluenceGrid<'_> {
        FluenceGrid::new(self.layout, self.cells(layer)).expect(FITS)
    }

    /// A layer's cells, resolved, and nothing else.
    pub(crate) fn into_cells(mut self, layer: usize) -> Vec<FluenceCell> {
        self.layers.swap_remove(layer).resolved
    }

    /// The spectrum of a layer of the picture's fog.
    pub(crate) fn image(
        &mut self,
        layer: usize,
        surfaces: &FirstSurfaces,
        fogs: &[Medium],
    ) -> &[ImageSpectrum] {
        let grid = &mut self.layers[layer];
        grid.image.get_or_insert_with(|| {
            let cells = FluenceGrid::new(self.layout, &grid.resolved).expect(FITS);
            surfaces.spectra(&cells, fogs)
        })
    }
}
