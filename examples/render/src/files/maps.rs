//! Pictures of where the eye rays were and how their light was filtered, after the thesis' Figure 5.20.

use crate::files::preview::preview;
use covbeam::ImageFilter;
use covbeam_session::film::{Maps, Picture};
use std::f32::consts::TAU;

/// Densities are shown on a logarithmic scale from this one, in black, to one eye ray a pixel, in white.
const DARKEST: f32 = 1.0 / 256.0;

/// The picture of the filters is this many times as large.
const SCALE: u32 = 3;

/// A filter is drawn for every twelfth pixel across and down.
const SPACING: u32 = 12;

/// Of the layers' filters.
const COLORS: [[u8; 3]; 3] = [[255, 190, 60], [90, 160, 255], [110, 230, 120]];

/// 8-bit sRGB, three bytes a pixel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Bitmap {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Row by row from the upper left.
    pub bytes: Vec<u8>,
}

/// Eye rays a pixel and pass, of the layer that has most: white is one, black one in 256 or fewer, each step of grey the same ratio.
pub fn density_map(picture: &Picture, maps: &Maps) -> Bitmap {
    let grey = |density: &f32| {
        [(255.0 * (1.0 - libm::logf(density.max(DARKEST)) / libm::logf(DARKEST)) + 0.5) as u8; 3]
    };
    Bitmap {
        width: picture.width,
        height: picture.height,
        bytes: maps.density().iter().flat_map(grey).collect(),
    }
}

/// The filters over the darkened picture, three times as large: outlines at one standard deviation, a dot where there is none. Those of
/// the first layer of light, or of all light, are amber, the others blue and green.
pub fn filter_map(picture: &Picture, maps: &Maps) -> Bitmap {
    let (width, height) = (picture.width * SCALE, picture.height * SCALE);
    let shown = preview(picture);
    let source = |x: u32, y: u32| ((y / SCALE * picture.width + x / SCALE) * 3) as usize;
    let dark = (0..width * height).flat_map(|i| {
        let at = source(i % width, i / width);
        [shown[at], shown[at + 1], shown[at + 2]].map(|value| value / 2)
    });
    let mut bitmap = Bitmap { width, height, bytes: dark.collect() };
    for y in (SPACING / 2..picture.height).step_by(SPACING as usize) {
        for x in (SPACING / 2..picture.width).step_by(SPACING as usize) {
            for (layer, color) in maps.layers.iter().zip(COLORS) {
                bitmap.outline([x, y], &layer.filters[(y * picture.width + x) as usize], color);
            }
        }
    }
    bitmap
}

impl Bitmap {
    fn outline(&mut self, center: [u32; 2], filter: &ImageFilter, color: [u8; 3]) {
        // The Cholesky root of the covariance takes the unit circle to the outline.
        let a = filter.xx.sqrt();
        let b = if a > 0.0 { filter.xy / a } else { 0.0 };
        let c = (filter.yy - b * b).max(0.0).sqrt();
        let scale = SCALE as f32;
        let steps = (TAU * scale * (filter.xx + filter.yy).sqrt()).ceil().max(1.0) * 2.0;
        for step in 0..steps as u32 {
            let (sin, cos) = libm::sincosf(TAU * step as f32 / steps);
            let x = (center[0] as f32 + 0.5 + a * cos) * scale;
            let y = (center[1] as f32 + 0.5 + b * cos + c * sin) * scale;
            if x >= 0.0 && y >= 0.0 && x < self.width as f32 && y < self.height as f32 {
                let at = (y as usize * self.width as usize + x as usize) * 3;
                self.bytes[at..at + 3].copy_from_slice(&color);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use covbeam_session::film::LayerMaps;
    use glam::Vec3;
    use std::sync::Arc;

    #[test]
    fn a_density_is_grey_by_its_logarithm() {
        let picture = Picture { width: 3, height: 1, radiance: vec![Vec3::ONE; 3], ..Picture::default() };
        let density = vec![1.0, 1.0 / 16.0, 1e-6];
        let layer = |density| LayerMaps {
            kind: None,
            filters: vec![ImageFilter::NONE; 3],
            density: Arc::new(density),
        };
        let layers = vec![layer(density), layer(vec![0.01, 1e-6, 0.0])];
        let maps = Maps { volume: vec![Vec3::ONE; 3], layers };
        // 1/16 is half-way between 1 and 1/256.
        assert_eq!(density_map(&picture, &maps).bytes, [255, 255, 255, 128, 128, 128, 0, 0, 0]);
    }

    #[test]
    fn a_filter_is_outlined_at_one_standard_deviation() {
        let (width, height) = (48, 48);
        let radiance = vec![Vec3::ZERO; 48 * 48];
        let picture = Picture { width, height, radiance, ..Picture::default() };
        let mut filters = vec![ImageFilter::NONE; 48 * 48];
        // Standard deviations 5 along (1, 1)/√2 and 1 across.
        filters[18 * 48 + 18] = ImageFilter { xx: 13.0, xy: 12.0, yy: 13.0 };
        let layer = LayerMaps { kind: None, filters, density: Arc::default() };
        let maps = Maps { volume: Vec::new(), layers: vec![layer] };
        let bitmap = filter_map(&picture, &maps);
        assert_eq!((bitmap.width, bitmap.height), (144, 144));
        let lit = |x: f32, y: f32| bitmap.bytes[(y as usize * 144 + x as usize) * 3] > 0;
        let middle = 18.5 * 3.0;
        let near = |along: f32, across: f32| {
            let x = middle + 3.0 * (along + across) / 2.0_f32.sqrt();
            let y = middle + 3.0 * (along - across) / 2.0_f32.sqrt();
            (-1..=1).any(|dx| (-1..=1).any(|dy| lit(x + dx as f32, y + dy as f32)))
        };
        assert!(near(5.0, 0.0) && near(-5.0, 0.0) && near(0.0, 1.0) && near(0.0, -1.0));
        assert!(!near(7.0, 0.0) && !near(0.0, 2.5) && !near(2.0, 0.0));
        // The other filters are dots.
        assert!(lit(6.5 * 3.0, 6.5 * 3.0) && !lit(6.5 * 3.0 + 2.0, 6.5 * 3.0));
    }
}
