//! Importance in voxels, and what follows from it for light paths.

use crate::words::Words;
use covbeam::{
    DensityGrid, EmissionGuide, GridLayout, Importance, ImportanceCell, ImportanceGrid, ImportanceSums,
    weight_window,
};

/// The largest grid, window and guide of the file.
const CELLS: usize = 60;
const FACTORS: usize = 8;
const SIDE: usize = 3;

/// The importance that lines speak of.
pub struct Voxels {
    layout: Option<GridLayout>,
    sums: [ImportanceSums; CELLS],
    cells: [ImportanceCell; CELLS],
}

impl Voxels {
    pub fn new() -> Self {
        Self {
            layout: None,
            sums: [ImportanceSums::default(); CELLS],
            cells: [ImportanceCell::default(); CELLS],
        }
    }

    pub fn call(
        &mut self,
        name: &[u8],
        density: Option<DensityGrid>,
        i: &mut Words,
        o: &mut Words,
    ) -> Option<()> {
        match name {
            b"importance_new" => {
                let layout = i.layout()?;
                self.sums.get(..layout.cell_count())?;
                self.layout = Some(layout);
                return Some(());
            }
            b"importance_at" | b"importance_of_segments" => return self.look_up(name, density, i, o),
            b"weight_window" => return window(i, o),
            b"emission_guide_fill" | b"emission_guide_warp" => return guide(name, i, o),
            _ => {}
        }
        let layout = self.layout?;
        let count = layout.cell_count();
        let mut grid = ImportanceGrid::new(layout, &mut self.sums[..count]).ok()?;
        match name {
            b"importance_add_eye_rays" | b"importance_add_paths" => {
                let medium = i.medium(density)?;
                while !i.is_empty() {
                    let (origin, direction, [length, weight]) = (i.vector()?, i.vector()?, i.floats()?);
                    if name == b"importance_add_paths" {
                        grid.add_path(&medium, origin, direction, length, weight);
                    } else {
                        grid.add_eye_ray(&medium, origin, direction, length, weight);
                    }
                }
            }
            b"importance_add_surfaces" => {
                while !i.is_empty() {
                    grid.add_surface(i.vector()?, i.float()?);
                }
            }
            b"importance_resolve" => grid.resolve(&mut self.cells[..count]).ok()?,
            _ => return None,
        }
        Some(())
    }

    fn look_up(&self, name: &[u8], density: Option<DensityGrid>, i: &mut Words, o: &mut Words) -> Option<()> {
        let layout = self.layout?;
        let importance = Importance::new(layout, &self.cells[..layout.cell_count()]).ok()?;
        if name == b"importance_at" {
            while !i.is_empty() {
                let found = importance.at(i.vector()?);
                o.are(&[found.beam, found.scattered, found.surface])?;
            }
            return Some(());
        }
        let medium = i.medium(density)?;
        while !i.is_empty() {
            let (origin, direction, length) = (i.vector()?, i.vector()?, i.float()?);
            let found = importance.of_segment(&medium, origin, direction, length);
            o.are(&[found.beam, found.scattered, found.transmittance])?;
        }
        Some(())
    }
}

fn window(i: &mut Words, o: &mut Words) -> Option<()> {
    let (mut numbers, mut count) = ([0.0; FACTORS], 0);
    while !i.is_empty() {
        *numbers.get_mut(count)? = i.float()?;
        count += 1;
    }
    // The last one is the random number.
    let (factors, u) = numbers[..count].split_at_mut(count.checked_sub(1)?);
    weight_window(factors, u[0]);
    o.are(factors)
}

fn guide(name: &[u8], i: &mut Words, o: &mut Words) -> Option<()> {
    let mut cumulative = [0.0; SIDE * (SIDE + 1)];
    if i.int()? as usize != SIDE {
        return None;
    }
    if name == b"emission_guide_fill" {
        let weights: [f32; SIDE * SIDE] = i.floats()?;
        EmissionGuide::fill(SIDE, &weights, i.float()?, &mut cumulative).ok()?;
        return o.are(&cumulative);
    }
    cumulative = i.floats()?;
    let guide = EmissionGuide::new(SIDE, &cumulative).ok()?;
    while !i.is_empty() {
        let ([x, y], density) = guide.warp(i.floats()?);
        o.are(&[x, y, density])?;
    }
    Some(())
}
