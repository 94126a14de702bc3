//! Knots along an eye ray, from which shadow rays are placed.

use crate::check::{finite, unit, vector};
use crate::heap::reserved;
use crate::memory::{Element, outputs};
use crate::status::{Failure, covbeam_status, covbeam_status::*, fail, run};
use covbeam_core::MarchKnot;

/// One knot of the table along an eye ray, from which shadow rays are placed.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_march_knot {
    /// From the ray's origin [m].
    pub distance: f32,
    /// Light that one metre of the ray scatters to the eye if nothing is in the lights' way, as one number such
    /// as its luminance [W/(m^3 sr)]: transmittance to the eye x scattering coefficient x phase function x
    /// transmittance to the light x intensity / squared distance. NaN, infinity and negative numbers count as 0.
    pub radiance: f32,
    /// Standard deviation of the fluence's spectrum along the ray [cycles/m]: the root of
    /// covbeam_spectrum_variance_along. NaN, infinity and negative numbers: not known.
    pub deviation: f32,
    /// Share of the light that is expected to arrive, in [0, 1], such as that of a few rays from the
    /// light past this place. NaN and negative numbers: not known.
    pub visibility: f32,
}

impl From<covbeam_march_knot> for MarchKnot {
    fn from(knot: covbeam_march_knot) -> Self {
        let covbeam_march_knot { distance, radiance, deviation, visibility } = knot;
        Self { distance, radiance, deviation, visibility }
    }
}

impl From<MarchKnot> for covbeam_march_knot {
    fn from(knot: MarchKnot) -> Self {
        let MarchKnot { distance, radiance, deviation, visibility } = knot;
        Self { distance, radiance, deviation, visibility }
    }
}

/// Two knots or more.
pub(super) fn enough(count: usize) -> Result<(), Failure> {
    if count >= 2 {
        Ok(())
    } else {
        Err(fail(COVBEAM_SHORT_BUFFER, format_args!("count: {count}, but a table needs two knots or more")))
    }
}

/// Lays knots along a stretch of a ray, at equal steps of the angle at which a light sees it. Each is dark, and
/// nothing is known: the host writes its radiance, deviation and visibility.
///
/// @param origin of the ray [m].
/// @param direction of the ray, unit.
/// @param from where the stretch begins [m], finite.
/// @param to where it ends [m] >= from; infinity stands for where the light sees the rest under 1/1000 rad.
/// @param light its position, or centre [m]. On the ray itself, the steps are equal in distance.
/// @param count number of knots >= 2; 97 serve well.
/// @param knots, knot_stride receive them, from near to far.
/// @note Kulla and Fajardo 2012. About 5 ns a knot.
/// @kinds <f:fff <f:uuu $f $N <f:fff >place
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_march_lay(
    origin: *const f32,
    direction: *const f32,
    from: f32,
    to: f32,
    light: *const f32,
    count: usize,
    knots: *mut covbeam_march_knot,
    knot_stride: usize,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let origin = vector(unsafe { Element::read(origin.cast(), "origin") }?)?;
        // SAFETY: by the caller's promise.
        let direction = unit(unsafe { Element::read(direction.cast(), "direction") }?)?;
        let from = finite(Element::single(from, "from"))?;
        let end = Element::single(to, "to");
        if !(to >= from) {
            return Err(end.is(format_args!("{to} is not >= from, {from}")));
        }
        // SAFETY: by the caller's promise.
        let light = vector(unsafe { Element::read(light.cast(), "light") }?)?;
        enough(count)?;
        outputs!(count, knots, knot_stride);
        let mut laid = reserved(count)?;
        laid.resize(count, MarchKnot::default());
        MarchKnot::lay(origin, direction, from, to, light, &mut laid).map_err(|_| {
            end.is(format_args!("the stretch or the light lies farther than a float can tell"))
        })?;
        for (i, knot) in laid.into_iter().enumerate() {
            knots.set(i, knot.into());
        }
        Ok(())
    })
}
