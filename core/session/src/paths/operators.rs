//! What changes a light field on its way, one name each, so that a study can leave one out and see what it buys.

/// An operator on light fields.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operator {
    /// The lights' own bandwidths: how emission varies with direction.
    Emission,
    /// The curvature of mirrors and dielectrics.
    Curvature,
    /// Edges beside the light's way, found by probe rays.
    Occlusion,
    /// The blur over angles by phase functions: without it, scattered light keeps all its frequencies.
    Scattering,
    /// The curvature of the extinction across the ray, in media whose density varies.
    Attenuation,
    /// The change of fluence along the ray of light that spreads or converges.
    Spreading,
}

impl Operator {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Emission,
        Self::Curvature,
        Self::Occlusion,
        Self::Scattering,
        Self::Attenuation,
        Self::Spreading,
    ];

    /// In lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Emission => "emission",
            Self::Curvature => "curvature",
            Self::Occlusion => "occlusion",
            Self::Scattering => "scattering",
            Self::Attenuation => "attenuation",
            Self::Spreading => "spreading",
        }
    }
}
