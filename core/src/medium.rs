//! stub
use glam::Vec3;

/// Which phase function.
#[repr(u32)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PhaseKind {
    /// 1/(4π).
    #[default]
    Isotropic = 0,
    /// Henyey-Greenstein.
    HenyeyGreenstein = 1,
    /// Rayleigh.
    Rayleigh = 2,
}

/// Phase function by value.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PhaseFunction {
    /// Kind.
    pub kind: PhaseKind,
    /// Mean cosine g of Henyey-Greenstein, in (-1, 1); ignored by the others.
    pub asymmetry: f32,
}

impl PhaseFunction {
    /// Isotropic.
    pub const ISOTROPIC: Self = Self { kind: PhaseKind::Isotropic, asymmetry: 0.0 };
    /// Value \[1/sr\].
    pub fn evaluate(&self, cos_theta: f32) -> f32 {
        let _ = cos_theta;
        todo!()
    }
    /// Samples cos θ exactly in proportion to the phase function; `xi` in [0, 1).
    pub fn sample_cosine(&self, xi: f32) -> f32 {
        let _ = xi;
        todo!()
    }
    /// Samples an outgoing direction; weight 1.
    pub fn sample(&self, direction: Vec3, xi: [f32; 2]) -> Vec3 {
        let _ = (direction, xi);
        todo!()
    }
    /// Angular variance of the lobe's spectrum \[cycles²/rad²\].
    pub fn angular_variance(&self) -> f32 {
        todo!()
    }
}

/// Homogeneous medium.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Medium {
    /// σ_s per channel \[1/m\], >= 0.
    pub scattering: Vec3,
    /// σ_a per channel \[1/m\], >= 0.
    pub absorption: Vec3,
    /// Phase function.
    pub phase: PhaseFunction,
}

impl Medium {
    /// σ_t = σ_s + σ_a.
    pub fn extinction(&self) -> Vec3 {
        self.scattering + self.absorption
    }
    /// exp(-σ_t distance).
    pub fn transmittance(&self, distance: f32) -> Vec3 {
        let _ = distance;
        todo!()
    }
}
