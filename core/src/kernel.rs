//! stub
use crate::FluenceGrid;

/// 1D kernels, normalised over [-r, r].
#[repr(u32)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kernel {
    /// 1/(2r).
    Box = 0,
    /// 3/(4r)(1-q²).
    #[default]
    Epanechnikov = 1,
    /// 15/(16r)(1-q²)².
    Biweight = 2,
}

impl Kernel {
    /// K_r(d) \[1/m\]; 0 for d >= r.
    pub fn evaluate(self, distance: f32, radius: f32) -> f32 {
        let _ = (distance, radius);
        todo!()
    }
    /// μ₂ for r = 1.
    pub fn second_moment(self) -> f32 {
        todo!()
    }
    /// r_σ = sqrt(ε/(2π² μ₂ σ²)); infinite at σ² = 0.
    pub fn radius_from_error(self, error: f32, variance: f32) -> f32 {
        let _ = (error, variance);
        todo!()
    }
}

/// r_i of plain progressive photon beams, `pass` counted from 1: r_{i+1} = r_i (i+α)/(i+1).
pub fn progressive_radius(initial: f32, alpha: f32, pass: u32) -> f32 {
    let _ = (initial, alpha, pass);
    todo!()
}

/// ε_i = ε_1 i^(-2/5), `pass` counted from 1.
pub fn error_bound(initial: f32, pass: u32) -> f32 {
    let _ = (initial, pass);
    todo!()
}

/// How wide each pair is gathered in this pass: d < max(r_i, r_σ).
#[derive(Clone, Copy, Debug)]
pub struct KernelRadius<'a> {
    /// Shape.
    pub kernel: Kernel,
    /// r_i \[m\] > 0: the radius where the grid has no opinion, and the smallest one.
    pub progressive: f32,
    /// Largest radius \[m\]; what the hierarchy over the beams must allow for.
    pub ceiling: f32,
    /// Accepted relative bias ε > 0 of one pair.
    pub error: f32,
    /// Where σ² comes from; None = plain progressive photon beams.
    pub grid: Option<FluenceGrid<'a>>,
}
