//! The words of a line of `tests/vectors.txt`, read as what they stand for.

use covbeam::{
    Beam, Column, Curvature, Density, DensityGrid, Edge, ExponentialDensity, EyeRay, FluenceGrid,
    FluenceSpectrum, GridLayout, ImageFilter, ImageSpectrum, Kernel, KernelShape, LightField, MOST_EDGES,
    Medium, PhaseFunction, PhaseKind, PixelStep, Segment, Vec3,
};

/// Numbers in hexadecimal with spaces between them. `None` of any reading: there is no such word.
#[derive(Clone, Copy)]
pub struct Words<'t>(pub &'t [u8]);

impl<'t> Words<'t> {
    /// All text before the next space.
    pub fn text(&mut self) -> &'t [u8] {
        let end = self.0.iter().position(|byte| *byte == b' ').unwrap_or(self.0.len());
        let (word, rest) = self.0.split_at(end);
        self.0 = rest.get(1..).unwrap_or(&[]);
        word
    }

    /// Whether all is read.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// 16 digits or 8.
    pub fn long(&mut self) -> Option<u64> {
        u64::from_str_radix(core::str::from_utf8(self.text()).ok()?, 16).ok()
    }

    pub fn int(&mut self) -> Option<u32> {
        u32::try_from(self.long()?).ok()
    }

    pub fn float(&mut self) -> Option<f32> {
        self.int().map(f32::from_bits)
    }

    pub fn floats<const N: usize>(&mut self) -> Option<[f32; N]> {
        let mut floats = [0.0; N];
        for float in &mut floats {
            *float = self.float()?;
        }
        Some(floats)
    }

    pub fn vector(&mut self) -> Option<Vec3> {
        self.floats().map(Vec3::from_array)
    }

    /// Whether the next words are these numbers, bit for bit.
    pub fn are(&mut self, floats: &[f32]) -> Option<()> {
        floats.iter().try_for_each(|float| self.is(float.to_bits()))
    }

    /// Whether the next word is this one.
    pub fn is(&mut self, wanted: u32) -> Option<()> {
        (self.int()? == wanted).then_some(())
    }

    pub fn field(&mut self) -> Option<LightField> {
        Some(LightField { root: self.floats()?, x_axis: self.vector()?, direction: self.vector()? })
    }

    /// A segment without its column, whose edges are put into `edges`.
    pub fn segment<'e>(&mut self, edges: &'e mut [Edge; MOST_EDGES]) -> Option<Segment<'e>> {
        let (origin, [length, power]) = (self.vector()?, self.floats()?);
        let (unscattered, field, count) = (self.int()? == 1, self.field()?, self.int()? as usize);
        for edge in edges.get_mut(..count)? {
            let ([depth, distance], towards) = (self.floats()?, self.vector()?);
            *edge = Edge { depth, distance, towards };
        }
        let (edges, column) = (&edges[..count], Column::Uniform);
        Some(Segment { origin, length, power, unscattered, field, edges, column })
    }

    pub fn is_field(&mut self, field: &LightField) -> Option<()> {
        self.are(&field.root)?;
        self.are(&field.x_axis.to_array())?;
        self.are(&field.direction.to_array())
    }

    pub fn curvature(&mut self) -> Option<Curvature> {
        let (tangent, [along, across, twist]) = (self.vector()?, self.floats()?);
        Some(Curvature { tangent, along, across, twist })
    }

    pub fn spectrum(&mut self) -> Option<FluenceSpectrum> {
        self.floats().map(FluenceSpectrum::from_array)
    }

    pub fn phase(&mut self) -> Option<PhaseFunction> {
        let kind = match self.int()? {
            0 => PhaseKind::Isotropic,
            1 => PhaseKind::HenyeyGreenstein,
            2 => PhaseKind::Rayleigh,
            _ => return None,
        };
        Some(PhaseFunction { kind, asymmetry: self.float()? })
    }

    pub fn layout(&mut self) -> Option<GridLayout> {
        let (min, max) = (self.vector()?, self.vector()?);
        Some(GridLayout { min, max, cells: [self.int()?, self.int()?, self.int()?] })
    }

    /// One of kind 2 has the density `voxels`.
    pub fn medium<'v>(&mut self, voxels: Option<DensityGrid<'v>>) -> Option<Medium<'v>> {
        let (scattering, absorption, phase) = (self.vector()?, self.vector()?, self.phase()?);
        let kind = self.int()?;
        let (origin, up, scale_height) = (self.vector()?, self.vector()?, self.float()?);
        let density = match kind {
            0 => Density::Uniform,
            1 => {
                // As the C ABI takes one of any length.
                let up = (up / up.abs().max_element()).normalize();
                Density::Exponential(ExponentialDensity { origin, up, scale_height })
            }
            _ => Density::Grid(voxels?),
        };
        Some(Medium { scattering, absorption, phase, more: &[], density })
    }

    pub fn shape(&mut self) -> Option<KernelShape> {
        [KernelShape::Box, KernelShape::Epanechnikov, KernelShape::Biweight]
            .get(self.int()? as usize)
            .copied()
    }

    pub fn kernel<'g>(&mut self, grid: Option<FluenceGrid<'g>>) -> Option<Kernel<'g>> {
        let (shape, [min_radius, max_radius, error]) = (self.shape()?, self.floats()?);
        Some(Kernel { shape, min_radius, max_radius, error, grid })
    }

    pub fn ray(&mut self) -> Option<EyeRay> {
        Some(EyeRay { origin: self.vector()?, direction: self.vector()?, length: self.float()? })
    }

    pub fn beam(&mut self) -> Option<Beam> {
        let (origin, direction, length) = (self.vector()?, self.vector()?, self.float()?);
        let (power, start_normal, end_normal) = (self.vector()?, self.vector()?, self.vector()?);
        Some(Beam { origin, direction, length, power, start_normal, end_normal })
    }

    pub fn steps(&mut self) -> Option<[PixelStep; 2]> {
        let mut step = || Some(PixelStep { origin: self.vector()?, direction: self.vector()? });
        Some([step()?, step()?])
    }

    pub fn image_spectrum(&mut self) -> Option<ImageSpectrum> {
        let [xx, xy, yy, weight] = self.floats()?;
        Some(ImageSpectrum { xx, xy, yy, weight })
    }

    pub fn image_filter(&mut self) -> Option<ImageFilter> {
        let [xx, xy, yy] = self.floats()?;
        Some(ImageFilter { xx, xy, yy })
    }
}
