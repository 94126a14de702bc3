//! Values as words, and the lines of the file.

use covbeam::{
    Beam, Crossing, Curvature, Derivatives, Edge, EyeRay, FilmPixel, FluenceSpectrum, Gathered, GridLayout,
    ImageFilter, ImageSpectrum, Kernel, KernelShape, Knot, LightField, MarchKnot, MarchSample, PhaseFunction,
    PhaseKind, PixelStep, Vec3,
};
use std::fmt::Write;

/// What has a place in a line.
pub(super) trait Words {
    /// Appends it, a space before each word.
    fn append(&self, line: &mut String);
}

/// Several values as one.
fn append_all(values: &[&dyn Words], line: &mut String) {
    for value in values {
        value.append(line);
    }
}

impl Words for f32 {
    fn append(&self, line: &mut String) {
        assert!(!self.is_nan(), "a NaN has no bits of its own");
        self.to_bits().append(line);
    }
}

impl Words for u32 {
    fn append(&self, line: &mut String) {
        write!(line, " {self:08x}").expect("a string takes all");
    }
}

impl Words for bool {
    fn append(&self, line: &mut String) {
        u32::from(*self).append(line);
    }
}

impl Words for u64 {
    fn append(&self, line: &mut String) {
        write!(line, " {self:016x}").expect("a string takes all");
    }
}

impl<T: Words> Words for [T] {
    fn append(&self, line: &mut String) {
        self.iter().for_each(|value| value.append(line));
    }
}

impl<T: Words, const N: usize> Words for [T; N] {
    fn append(&self, line: &mut String) {
        self.as_slice().append(line);
    }
}

impl<T: Words> Words for Vec<T> {
    fn append(&self, line: &mut String) {
        self.as_slice().append(line);
    }
}

impl Words for Vec3 {
    fn append(&self, line: &mut String) {
        self.to_array().append(line);
    }
}

impl Words for LightField {
    fn append(&self, line: &mut String) {
        append_all(&[&self.root, &self.x_axis, &self.direction], line);
    }
}

impl Words for Edge {
    fn append(&self, line: &mut String) {
        append_all(&[&self.depth, &self.distance, &self.towards], line);
    }
}

impl Words for Curvature {
    fn append(&self, line: &mut String) {
        append_all(&[&self.tangent, &self.along, &self.across, &self.twist], line);
    }
}

impl Words for FluenceSpectrum {
    fn append(&self, line: &mut String) {
        self.to_array().append(line);
    }
}

impl Words for PhaseFunction {
    fn append(&self, line: &mut String) {
        let kind: u32 = match self.kind {
            PhaseKind::Isotropic => 0,
            PhaseKind::HenyeyGreenstein => 1,
            PhaseKind::Rayleigh => 2,
        };
        append_all(&[&kind, &self.asymmetry], line);
    }
}

impl Words for Derivatives {
    fn append(&self, line: &mut String) {
        append_all(&[&self.gradient, &self.hessian], line);
    }
}

impl Words for Knot {
    fn append(&self, line: &mut String) {
        append_all(&[&self.distance, &self.column], line);
    }
}

impl Words for GridLayout {
    fn append(&self, line: &mut String) {
        append_all(&[&self.min, &self.max, &self.cells], line);
    }
}

impl Words for KernelShape {
    fn append(&self, line: &mut String) {
        let shape: u32 = match self {
            KernelShape::Box => 0,
            KernelShape::Epanechnikov => 1,
            KernelShape::Biweight => 2,
        };
        shape.append(line);
    }
}

/// A `covbeam_kernel`; whether its grid is passed is a word of its own.
impl Words for Kernel<'_> {
    fn append(&self, line: &mut String) {
        append_all(&[&self.shape, &self.min_radius, &self.max_radius, &self.error], line);
    }
}

impl Words for Beam {
    fn append(&self, line: &mut String) {
        let Self { origin, direction, length, power, start_normal, end_normal } = self;
        append_all(&[origin, direction, length, power, start_normal, end_normal], line);
    }
}

impl Words for EyeRay {
    fn append(&self, line: &mut String) {
        append_all(&[&self.origin, &self.direction, &self.length], line);
    }
}

impl Words for Crossing {
    fn append(&self, line: &mut String) {
        let Self { ray_distance, beam_distance, gap, sin_theta, axis } = self;
        append_all(&[ray_distance, beam_distance, gap, sin_theta, axis], line);
    }
}

impl Words for Gathered {
    fn append(&self, line: &mut String) {
        append_all(&[&self.radiance, &self.pairs, &self.weight, &self.radius, &self.sigma], line);
    }
}

impl Words for PixelStep {
    fn append(&self, line: &mut String) {
        append_all(&[&self.origin, &self.direction], line);
    }
}

impl Words for ImageSpectrum {
    fn append(&self, line: &mut String) {
        append_all(&[&self.xx, &self.xy, &self.yy, &self.weight], line);
    }
}

impl Words for ImageFilter {
    fn append(&self, line: &mut String) {
        append_all(&[&self.xx, &self.xy, &self.yy], line);
    }
}

/// What its error is found from.
impl Words for FilmPixel {
    fn append(&self, line: &mut String) {
        append_all(&[&self.variance, &self.difference], line);
    }
}

impl Words for MarchKnot {
    fn append(&self, line: &mut String) {
        append_all(&[&self.distance, &self.radiance, &self.deviation, &self.visibility], line);
    }
}

/// As it lies in memory: 0, and the mass as two words, the lower first.
impl Words for MarchSample {
    fn append(&self, line: &mut String) {
        let mass = self.mass.to_bits();
        let (low, high) = (mass as u32, (mass >> 32) as u32);
        append_all(&[&self.distance, &self.weight, &self.visibility, &0_u32, &low, &high], line);
    }
}

/// The lines so far.
pub(super) struct Script(String);

impl Script {
    pub(super) fn new() -> Self {
        Self(String::new())
    }

    pub(super) fn comment(&mut self, text: &str) {
        writeln!(self.0, "# {text}").expect("a string takes all");
    }

    pub(super) fn call(&mut self, name: &str, inputs: &[&dyn Words], outputs: &[&dyn Words]) {
        self.0.push_str(name);
        append_all(inputs, &mut self.0);
        self.0.push_str(" ->");
        append_all(outputs, &mut self.0);
        self.0.push('\n');
    }

    pub(super) fn into_text(self) -> String {
        self.0
    }
}

/// FNV-1a of 64 bits (Fowler, Noll, Vo).
pub fn fnv(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}
