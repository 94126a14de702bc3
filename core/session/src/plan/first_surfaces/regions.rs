//! Regions of the picture, between silhouettes of surfaces and of the fog's bounds.

use super::look::{Look, Looks};
use covbeam::{RegionNode, film_regions, part_regions};
use std::collections::HashMap;

/// Share by which starts of the fog may differ that count as one.
const SAME_START: f32 = 1e-4;

pub(super) const FITS: &str = "a scene's picture is not too large";

/// The picture's regions: of the depth of surfaces, and of where fog starts and which. None: `cancelled`.
pub(super) fn regions(looks: &Looks, cancelled: &dyn Fn() -> bool) -> Option<Vec<u32>> {
    let [width, height] = [looks.camera.width, looks.camera.height];
    let all = &looks.all;
    let of = |depth: &dyn Fn(&Look) -> f32| {
        let depth: Vec<f32> = all.iter().map(depth).collect();
        let mut regions = vec![0; depth.len()];
        let mut nodes = vec![RegionNode::default(); depth.len()];
        film_regions(width, height, &depth, &mut regions).expect(FITS);
        part_regions(width, height, &depth, &mut regions, &mut nodes).expect(FITS);
        regions
    };
    let surfaces = of(&|look| look.depth);
    let kind = |look: &Look| look.fog.map(|fog| (fog.medium, fog.is_alone));
    let starts = all.iter().map(|look| look.start);
    let [least, most] = starts.fold([f32::INFINITY, 0.0], |[a, b], start| [start.min(a), start.max(b)]);
    let is_even = all.iter().all(|look| kind(look) == kind(&all[0]));
    if is_even && (most - least <= SAME_START * most || least == f32::INFINITY) {
        return Some(surfaces);
    }
    if cancelled() {
        return None;
    }
    // Where the fog starts it has a silhouette, too. Fog around the camera starts nearer than anything.
    let fog = of(&|look| look.start.max(f32::MIN_POSITIVE));
    let mut labels = HashMap::new();
    let numbered = surfaces.iter().zip(&fog).zip(all).zip(1..);
    let labelled = numbered.map(|(((surface, fog), look), number)| match (*surface, *fog) {
        (0, _) | (_, 0) => 0,
        pair => *labels.entry((pair, kind(look))).or_insert(number),
    });
    let mut labelled: Vec<u32> = labelled.collect();
    // Fogs side by side start and end as far away as each other, and where one begins pixels see both.
    for (pixel, label) in (0..).zip(&mut labelled) {
        let mut around = looks.around(pixel % width, pixel / width);
        let own = kind(&all[pixel as usize]);
        if around.any(|other| kind(&all[other]) != own) {
            *label = 0;
        }
    }
    Some(labelled)
}
