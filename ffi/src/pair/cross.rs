//! The crossing of an eye ray's line and a beam's line.

use crate::arrays::each;
use crate::beam::{beam, covbeam_beam};
use crate::eye_ray::{covbeam_eye_ray, read_ray};
use crate::memory::{inputs, outputs};
use crate::status::{covbeam_status, run};
use covbeam_core::{Crossing, cross};

/// Closest approach of an eye ray's line and a beam's line.
/// @extra
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_crossing {
    /// Distance along the eye ray [m]; may lie outside it.
    pub ray_distance: f32,
    /// Distance along the beam [m]; may lie outside it.
    pub beam_distance: f32,
    /// Distance between the two closest points [m].
    pub gap: f32,
    /// Sine of the angle between the directions, in (0, 1].
    pub sin_theta: f32,
    /// Unit common perpendicular, on which the kernel acts.
    pub axis: [f32; 3],
}

impl From<Crossing> for covbeam_crossing {
    fn from(c: Crossing) -> Self {
        Self {
            ray_distance: c.ray_distance,
            beam_distance: c.beam_distance,
            gap: c.gap,
            sin_theta: c.sin_theta,
            axis: c.axis.into(),
        }
    }
}

/// Closest approach of an eye ray's line and a beam's line.
///
/// @param ray the eye ray; its length does not matter.
/// @param count number of beams; with 0 nothing is done.
/// @param beams, beam_stride the beam; its length does not matter.
/// @param crossings, crossing_stride the closest approach; untouched if they are nearly parallel.
/// @param crosses, cross_stride 1, or 0 if the sine of the angle between them is below 1e-5: the crossing
///     would be rounding. (covbeam_gather_pair needs none below .05.)
/// @kinds <ray <beam >crossing >flag
/// @single covbeam_cross
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_cross_many(
    ray: *const covbeam_eye_ray,
    count: usize,
    beams: *const covbeam_beam,
    beam_stride: usize,
    crossings: *mut covbeam_crossing,
    crossing_stride: usize,
    crosses: *mut u8,
    cross_stride: usize,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let ray = unsafe { read_ray(ray) }?;
        inputs!(count, beams, beam_stride);
        outputs!(count, crossings, crossing_stride);
        outputs!(count, crosses, cross_stride);
        each(
            count,
            |i| beam(beams.get(i)),
            |i, beam| {
                let crossing = cross(&ray, &beam);
                crosses.set(i, u8::from(crossing.is_some()));
                if let Some(crossing) = crossing {
                    crossings.set(i, crossing.into());
                }
            },
        )
    })
}
