//! Regions of a picture between silhouettes.

use super::size::one_a_pixel;
use crate::heap::reserved;
use crate::memory::{inputs, outputs};
use crate::status::{covbeam_status, run};
use covbeam_core::{RegionNode, film_regions, part_regions};

/// Splits a picture into regions in which the depth of the first surface is continuous: filters do not reach
/// from one into another.
///
/// @param width, height of the picture, each 1 to 65536; at most 2^31 pixels.
/// @param count width x height.
/// @param depths, depth_stride of the first surface seen through the middle of each pixel [m], row by row from
///     the upper left, measured along the viewing axis and not along the ray. Infinity where there is none; NaN,
///     0 or less makes the pixel a border.
/// @param labels, label_stride receive each pixel's region: the number of its first pixel, from 1 on; 0 for a
///     pixel at a border, which filters leave alone, because its own light may come from both sides.
/// @note Two neighbours are apart where neither surface, continued as a plane, comes within 1 % of the other in
///     inverse depth: floors seen at a grazing angle are no edges. A region that lies on both sides of a silhouette
///     is taken apart where its surface bends most: a pillar from the floor that it stands on, which goes on
///     behind its top. Needs 24 bytes a pixel for the call.
/// @kinds #extent #extent <f:* >f:i
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_film_regions(
    width: u32,
    height: u32,
    count: usize,
    depths: *const f32,
    depth_stride: usize,
    labels: *mut u32,
    label_stride: usize,
) -> covbeam_status {
    run(|| {
        one_a_pixel(count, width, height)?;
        inputs!(count, depths, depth_stride);
        outputs!(count, labels, label_stride);
        let mut depth = reserved(count)?;
        depth.extend((0..count).map(|i| depths.get(i).value));
        let mut found = reserved(count)?;
        found.resize(count, 0);
        film_regions(width, height, &depth, &mut found).expect("as many of both as pixels");
        let mut nodes = reserved(count)?;
        nodes.resize(count, RegionNode::default());
        part_regions(width, height, &depth, &mut found, &mut nodes).expect("as many of both as pixels");
        for (i, label) in found.into_iter().enumerate() {
            labels.set(i, label);
        }
        Ok(())
    })
}
