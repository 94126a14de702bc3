//! The weight window, which splits and ends light paths.

use crate::check::{finite_not_negative, random};
use crate::heap::reserved;
use crate::memory::{Element, outputs};
use crate::status::{covbeam_status, run};
use covbeam_core::weight_window;

/// Splits and ends light paths: of some candidates, such as directions in which a path may go on or the paths
/// of a wave, which do, and by what their power is multiplied. The mean of each factor over u is 1, so that
/// nothing is added to the light or lost; of all together as many go on as are expected, up to one.
///
/// @param count number of candidates; with 0 nothing is done.
/// @param factors, factor_stride in: of each candidate, how many of it should go on: its power times its
///     importance, over what power times importance is to be; finite and >= 0, and above 0 unless it carries no
///     light. Out: the factor of its power, 0 where it ends. It goes on once, also where it could more often.
/// @param u uniform in [0, 1), a new one for each call.
/// @note Booth and Hendricks 1984; systematic resampling, Baker 1987.
/// @kinds =f:q $r
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_weight_window(
    count: usize,
    factors: *mut f32,
    factor_stride: usize,
    u: f32,
) -> covbeam_status {
    run(|| {
        outputs!(count, factors, factor_stride);
        let u = random(Element::single(u, "u"))?;
        let mut expected = reserved(count)?;
        for i in 0..count {
            expected.push(finite_not_negative(factors.get(i))?);
        }
        weight_window(&mut expected, u);
        for (i, factor) in expected.into_iter().enumerate() {
            factors.set(i, factor);
        }
        Ok(())
    })
}
