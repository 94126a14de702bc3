//! The filter of beams, eight at a time.

use crate::beam::{beam, covbeam_beam};
use crate::check::positive;
use crate::eye_ray::{covbeam_eye_ray, read_ray};
use crate::memory::{Element, inputs, outputs};
use crate::status::{covbeam_status, run};
use covbeam_core::{BLOCK, BeamBlock};

/// Which of many beams an eye ray may be paired with: eight at a time, without looking at grid or surfaces.
/// Errs towards accepting: covbeam_gather_pair refuses every beam that it
/// refuses.
///
/// @param ray the eye ray.
/// @param count number of beams; with 0 nothing is done.
/// @param beams, beam_stride the beams, each as a whole.
/// @param max_radius largest kernel radius [m] > 0: that of the covbeam_kernel.
/// @param masks, mask_stride 1 for a beam that may come within the max_radius, else 0.
/// @kinds <ray <beam $+ >flag
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_filter_beams(
    ray: *const covbeam_eye_ray,
    count: usize,
    beams: *const covbeam_beam,
    beam_stride: usize,
    max_radius: f32,
    masks: *mut u8,
    mask_stride: usize,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let ray = unsafe { read_ray(ray) }?;
        inputs!(count, beams, beam_stride);
        let max_radius = positive(Element::single(max_radius, "max_radius"))?;
        outputs!(count, masks, mask_stride);
        for i in 0..count {
            beam(beams.get(i))?;
        }
        let mut block = BeamBlock::EMPTY;
        for first in (0..count).step_by(BLOCK) {
            let filled = BLOCK.min(count - first);
            for slot in 0..filled {
                let beam = beam(beams.get(first + slot))?;
                block.set(slot, &beam, 0.0, beam.length);
            }
            block.clear_from(filled);
            let hit = block.test(&ray, max_radius);
            for slot in 0..filled {
                masks.set(first + slot, (hit >> slot & 1) as u8);
            }
        }
        Ok(())
    })
}
