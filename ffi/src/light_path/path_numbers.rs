//! Numbers that a light path's decisions are drawn with.

use crate::arrays::write;
use crate::memory::{inputs, outputs};
use crate::status::{covbeam_status, run};
use covbeam_core::path_number;

/// Decisions of a light path that covbeam_path_number stratifies.
pub const COVBEAM_EMISSION_DIMENSIONS: u32 = 8;

const _: () = assert!(COVBEAM_EMISSION_DIMENSIONS == covbeam_core::EMISSION_DIMENSIONS);

/// The number of one decision of one light path, uniform in [0, 1). The first COVBEAM_EMISSION_DIMENSIONS
/// decisions are the coordinates of a scrambled Sobol' point, which place 2^k paths in a row evenly; those after
/// them are independent. At equal numbers of paths the picture's error is 1.2 to 8 times below that of
/// independent numbers.
///
/// @param seed another seed is another scramble of all sequences.
/// @param sequence keeps sequences of one seed apart, such as paths with light fields and those without.
/// @param count number of paths; with 0 nothing is done.
/// @param paths, path_stride the path's place in the sequence, counted on over the passes of a picture.
/// @param dimension which decision of the path, from 0 on.
/// @param numbers, number_stride in [0, 1), a multiple of 2^-24.
/// @kinds #any #any <word #any >f:r
/// @single covbeam_path_number
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_path_numbers(
    seed: u32,
    sequence: u32,
    count: usize,
    paths: *const u32,
    path_stride: usize,
    dimension: u32,
    numbers: *mut f32,
    number_stride: usize,
) -> covbeam_status {
    run(|| {
        inputs!(count, paths, path_stride);
        outputs!(count, numbers, number_stride);
        let number = |path| path_number(seed, sequence, path, dimension);
        write(numbers, |i| Ok(paths.get(i).value), number)
    })
}

#[cfg(test)]
#[allow(clippy::undocumented_unsafe_blocks, reason = "every argument is a local, or refused")]
mod tests {
    use super::*;
    use crate::hostile::{UNTOUCHED, padded, refuses, values};
    use crate::status::covbeam_status::*;

    #[test]
    fn a_bad_argument_is_refused_and_nothing_is_written() {
        refuses(2, &[], |bad, _| {
            let mut number = UNTOUCHED;
            let (path, to) = (bad.at(0, &7), bad.at_mut(1, &mut number));
            let status = unsafe { covbeam_path_numbers(1, 2, 1, path, 0, 3, to, 0) };
            (status, number != UNTOUCHED)
        });
    }

    #[test]
    fn many_are_the_bits_of_the_core() {
        let paths = padded(&[0, 1, 77, u32::MAX]);
        for dimension in [0, 7, 8, u32::MAX] {
            let mut numbers = padded(&[UNTOUCHED; 4]);
            let status = unsafe {
                let (from, stride) = (&raw const paths[0].value, size_of_val(&paths[0]));
                covbeam_path_numbers(5, 6, 4, from, stride, dimension, &mut numbers[0].value, stride)
            };
            assert_eq!(status, COVBEAM_OK);
            for (number, path) in values(&numbers).into_iter().zip(values(&paths)) {
                let mut one = UNTOUCHED;
                assert_eq!(
                    unsafe { covbeam_path_numbers(5, 6, 1, &path, 0, dimension, &mut one, 0) },
                    COVBEAM_OK
                );
                assert_eq!([number, one], [path_number(5, 6, path, dimension); 2]);
            }
        }
    }
}
