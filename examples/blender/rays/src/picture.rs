//! Pictures as the caller gets them.

use covbeam_session::film::{Layers, Picture as Found};

/// Rows from the top, linear Rec. 709.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// All light that fog scatters to the camera [W/(m² sr)].
    pub in_scattered: Vec<[f32; 3]>,
    /// The part of it that is scattered before the first surface.
    pub first: Vec<[f32; 3]>,
    /// Mean kernel radius of that part \[m\], weighted by light; 0 where nothing was gathered.
    pub radius: Vec<f32>,
    /// Mean bandwidth of the fluence across the kernel \[cycles/m\], the same.
    pub bandwidth: Vec<f32>,
    /// Standard error of the luminance of all light; 0 after a single pass.
    pub error: Vec<f32>,
}

impl Picture {
    /// What a film gives.
    pub fn new(found: Found) -> Self {
        let count = found.radiance.len();
        let colors = |colors: Vec<glam::Vec3>| colors.iter().map(|color| color.to_array()).collect();
        let dark = || vec![[0.0; 3]; count];
        let Layers { radius, sigma, .. } = found.layers.unwrap_or_else(|| Layers {
            radius: vec![0.0; count],
            sigma: vec![0.0; count],
            samples: Vec::new(),
        });
        Self {
            first: found.maps.map_or_else(dark, |maps| colors(maps.volume)),
            in_scattered: colors(found.radiance),
            radius,
            bandwidth: sigma,
            error: found.error.unwrap_or_else(|| vec![0.0; count]),
        }
    }
}
