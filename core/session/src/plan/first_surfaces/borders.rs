//! Borders in the picture: silhouettes that a lens blurs, and what crosses pixels.

use super::look::{Look, Looks};
use crate::plan::blurred::blurred as spread;
use rayon::prelude::*;

/// A shadow's border crosses a pixel around which straight light varies by more than this.
const EDGE: f32 = 0.5;

/// Which pixels the lens blurs a border into; empty: none.
pub(super) fn blurred(looks: &Looks, regions: &[u32]) -> Vec<bool> {
    let size = [looks.camera.width, looks.camera.height];
    // More than the whole picture is no wider.
    let most = size[0].max(size[1]) as f32;
    if looks.camera.lens.is_none() {
        return Vec::new();
    }
    let nearest = |look: &Look| match look.fog {
        Some(fog) if fog.from > 0.0 => look.depth.min(look.start),
        // Fog around the camera is no thing that could be blurred.
        _ => look.depth,
    };
    let blur = looks.all.par_iter().map(|look| looks.camera.blur(nearest(look)).min(most));
    let blur: Vec<f32> = blur.collect();
    if blur.iter().all(|blur| *blur == 0.0) { Vec::new() } else { spread(size, regions, &blur) }
}

/// Whether a pixel and those around it are black, without a silhouette, and whether a silhouette or the border of a shadow crosses it.
pub(super) fn is_black_or_edge(looks: &Looks, pixel: u32, regions: &[u32]) -> (bool, bool) {
    let width = looks.camera.width;
    let has_silhouette = regions[pixel as usize] == 0;
    let around = || looks.around(pixel % width, pixel / width);
    let [least, most] = around().fold([f32::INFINITY, 0.0], |[least, most], pixel| {
        [looks.all[pixel].lit.min(least), looks.all[pixel].lit.max(most)]
    });
    let is_black = !has_silhouette && around().all(|pixel| looks.all[pixel].is_black);
    (is_black, has_silhouette || least < EDGE * most)
}
