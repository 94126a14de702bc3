//! Regions that face themselves across a silhouette.

use super::regions::{misses, picture, plane, regions, scene};
use covbeam::{PartError, RegionNode, part_regions};
use proptest::prelude::*;
use std::collections::HashSet;

fn parts(width: u32, depth: &[f32]) -> Vec<u32> {
    let mut labels = regions(width, depth);
    let mut nodes = vec![RegionNode::default(); depth.len()];
    part_regions(width, depth.len() as u32 / width, depth, &mut labels, &mut nodes).unwrap();
    labels
}

/// The labels of some pixels, but for those at borders.
fn labels_of(labels: &[u32], wanted: impl Fn(usize) -> bool) -> HashSet<u32> {
    (0..labels.len())
        .filter(|pixel| wanted(*pixel))
        .map(|pixel| labels[pixel])
        .filter(|label| *label > 0)
        .collect()
}

/// From 2 m above a floor: a wall behind, and a pillar that stands on the floor before it.
#[test]
fn a_pillar_that_stands_on_a_floor_is_cut_off_where_it_meets_the_floor() {
    let size = 512;
    let floor = plane(size, [0.0, 2.0, 0.0], [0.0, 1.0, 0.0]);
    let ends_at = |z: f64| plane(size, [0.0, 0.0, z], [0.0, 0.0, 1.0]);
    let (wall, front) = (ends_at(20.0), ends_at(8.0));
    let ground = |x, y| {
        let floor = floor(x, y);
        if floor > 0.0 { floor.min(wall(x, y)) } else { wall(x, y) }
    };
    // As wide as 96 pixels, and as high as 240 from where the floor is 8 m away.
    let is_pillar = |x: u32, y: u32| (200..296).contains(&x) && y > 144 && ground(x, y) > front(x, y);
    let depth = picture(size, |x, y| if is_pillar(x, y) { front(x, y) } else { ground(x, y) });
    assert_eq!(labels_of(&regions(size, &depth), |_| true).len(), 1, "floor, wall and pillar hang together");
    let labels = parts(size, &depth);
    // Of two pixels at the crease each may go with either side.
    let among = |wanted: bool| {
        labels_of(&labels, |pixel| {
            let (x, y) = (pixel as u32 % size, pixel as u32 / size);
            (y.saturating_sub(2)..=y + 2).all(|row| is_pillar(x, row) == wanted)
        })
    };
    let (pillar, rest) = (among(true), among(false));
    assert_eq!((pillar.len(), rest.len()), (1, 1), "{pillar:?} {rest:?}");
    assert!(pillar.is_disjoint(&rest));
    // The crease between floor and wall parts nothing.
    assert_eq!(labels[0], labels[labels.len() - 1]);
}

/// Smooth all the way around the end of a silhouette, and yet no part has both sides of it.
#[test]
fn a_smooth_fold_is_taken_apart_somewhere() {
    let size = 96_u32;
    let at = |pixel: u32| (f64::from(pixel) + 0.5) / f64::from(size) - 0.5;
    // A sheet that rises towards the viewer and overhangs more and more, from the right end to the left.
    let depth = picture(size, |x, y| {
        let (x, y) = (at(x), at(y));
        let overhang = (0.3 - x).max(0.0);
        5.0 - if y > 0.0 { 3.0 * overhang * (1.0 - y) } else { 0.0 }
    });
    let before = regions(size, &depth);
    let labels = parts(size, &depth);
    let facing = facing(size, &depth, &before, &before);
    assert!(facing > 20, "{facing} pairs face each other");
    assert_eq!(self::facing(size, &depth, &before, &labels), 0);
    // And few parts do.
    assert!(labels_of(&labels, |_| true).len() <= 4);
}

/// Pairs of pixels of one part on both sides of two at a border, between which no surface goes on: neither as it is nor as a plane.
fn facing(width: u32, depth: &[f32], regions: &[u32], parts: &[u32]) -> usize {
    let (width, height) = (width as usize, parts.len() / width as usize);
    let mut count = 0;
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        for (fits, stride) in [(x + 3 < width, 1), (y + 3 < height, width)] {
            if !fits {
                continue;
            }
            let pixel = y * width + x;
            let (near, side) = if stride == 1 { ((x + 1, y), (1, 0)) } else { ((x, y + 1), (0, 1)) };
            let goes_on = misses(width, depth, (near.0 as i64, near.1 as i64), side);
            count += usize::from(
                goes_on.iter().all(|miss| miss.is_nan() || *miss > 0.0)
                    && regions[pixel + stride] == 0
                    && regions[pixel + 2 * stride] == 0
                    && parts[pixel] != 0
                    && parts[pixel] == parts[pixel + 3 * stride],
            );
        }
    }
    count
}

proptest! {
    /// Rectangles over one another, some as far away as each other: parts lie within regions, hang together, are numbered by their first
    /// pixels, and differ from regions only where one faces itself.
    #[test]
    fn parts_are_connected_and_lie_within_regions((width, depth) in scene()) {
        let (before, labels) = (regions(width as u32, &depth), parts(width as u32, &depth));
        let height = depth.len() / width;
        for (pixel, label) in labels.iter().enumerate() {
            prop_assert_eq!(*label == 0, before[pixel] == 0);
            if *label == 0 {
                continue;
            }
            prop_assert!(*label as usize <= pixel + 1);
            prop_assert_eq!((labels[*label as usize - 1], before[*label as usize - 1]), (*label, before[pixel]));
        }
        // Each part in one piece.
        let mut seen = vec![false; labels.len()];
        let mut numbers = HashSet::new();
        for first in 0..labels.len() {
            if labels[first] == 0 || seen[first] {
                continue;
            }
            prop_assert!(numbers.insert(labels[first]), "part {} is in pieces", labels[first]);
            let mut open = vec![first];
            while let Some(pixel) = open.pop() {
                if std::mem::replace(&mut seen[pixel], true) {
                    continue;
                }
                let (x, y) = (pixel % width, pixel / width);
                let around = [(x > 0, pixel.wrapping_sub(1)), (x + 1 < width, pixel + 1),
                    (y > 0, pixel.wrapping_sub(width)), (y + 1 < height, pixel + width)];
                open.extend(around.into_iter().filter(|(is_in, _)| *is_in).map(|(_, next)| next)
                    .filter(|next| labels[*next] == labels[first]));
            }
        }
        prop_assert_eq!(facing(width as u32, &depth, &before, &labels), 0);
        if facing(width as u32, &depth, &before, &before) == 0 {
            prop_assert_eq!(labels, before);
        }
    }
}

/// Rows whose inverse depths are 1/3, 2/3 and 1 are a plane, though each is more than 1 % off the next one.
#[test]
fn steps_that_are_a_plane_part_nothing() {
    let width = 18;
    let depth: Vec<f32> = (0..19 * width)
        .map(|pixel| match (pixel % width, pixel / width) {
            (6..=10, 0..=14) | (17, 16) | (_, 18) => 1.0,
            (0..=16, 17) => 1.5,
            _ => 3.0,
        })
        .collect();
    let (before, labels) = (regions(width, &depth), parts(width, &depth));
    assert_eq!(facing(width, &depth, &before, &before), 0);
    assert_eq!(labels, before);
}

#[test]
fn labels_that_are_no_first_pixels_number_are_refused_and_nothing_changes() {
    // Of no pixel, of a pixel at a border, and of one that is of another region.
    for wrong in [[1, 1, 0, 0, 7, 7], [1, 1, 0, 0, u32::MAX, 5], [1, 1, 0, 0, 3, 5], [1, 1, 0, 0, 2, 5]] {
        let mut labels = wrong;
        let found = part_regions(6, 1, &[1.0; 6], &mut labels, &mut [RegionNode::default(); 6]);
        assert_eq!((found, labels), (Err(PartError::Label), wrong));
    }
}

#[test]
fn slices_of_another_length_are_refused_and_nothing_changes() {
    let refused = |width: u32, height: u32, depths: usize, count: usize, nodes: usize| {
        let mut labels = vec![77; count];
        let mut nodes = vec![RegionNode::default(); nodes];
        let found = part_regions(width, height, &vec![1.0; depths], &mut labels, &mut nodes);
        labels.iter().all(|label| *label == 77) && found == Err(PartError::Size)
    };
    assert!(refused(4, 3, 11, 12, 12) && refused(4, 3, 12, 13, 12) && refused(4, 3, 12, 12, 11));
    assert!(refused(65_537, 1, 65_537, 65_537, 65_537) && refused(1 << 31, 2, 0, 0, 0));
    assert_eq!(part_regions(0, 3, &[], &mut [], &mut []), Ok(()));
}
