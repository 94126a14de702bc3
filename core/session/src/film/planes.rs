//! Whole numbers in few bytes: of 64 at a time, those that are not 0 with as many bytes as the largest needs.
//!
//! The sums of few passes are short (a value has 24 digits) and, with planned eye rays, mostly 0. This is as fast as memory to read, which a
//! general compressor is not, and as small as one makes it.

/// Numbers that are written together.
pub(crate) const RUN: usize = 64;

/// Most bytes of a run.
pub(crate) const MOST_BYTES: usize = 8 + 1 + 8 * RUN;

/// Bytes that are no run of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct NoRun;

/// Writes a run.
pub(crate) fn put(numbers: &[u64; RUN], out: &mut Vec<u8>) {
    let (mut mask, mut all) = (0_u64, 0);
    for (place, number) in numbers.iter().enumerate() {
        mask |= u64::from(*number != 0) << place;
        all |= number;
    }
    out.extend(mask.to_le_bytes());
    if mask == 0 {
        return;
    }
    let bytes = (u64::BITS - all.leading_zeros()).div_ceil(8) as usize;
    out.push(bytes as u8);
    for number in numbers.iter().filter(|number| **number != 0) {
        out.extend_from_slice(&number.to_le_bytes()[..bytes]);
    }
}

/// Reads a run from the start of `bytes` and goes past it.
pub(crate) fn take(bytes: &mut &[u8]) -> Result<[u64; RUN], NoRun> {
    let mut numbers = [0; RUN];
    let (mask, rest) = bytes.split_first_chunk().ok_or(NoRun)?;
    let mut mask = u64::from_le_bytes(*mask);
    *bytes = rest;
    if mask == 0 {
        return Ok(numbers);
    }
    let (width, rest) = rest.split_first().ok_or(NoRun)?;
    let width = usize::from(*width);
    let length = mask.count_ones() as usize * width;
    if !(1..=8).contains(&width) || rest.len() < length {
        return Err(NoRun);
    }
    let (mut packed, rest) = rest.split_at(length);
    *bytes = rest;
    let digits = u64::MAX >> (u64::BITS as usize - 8 * width);
    while mask != 0 {
        let number = match packed.first_chunk() {
            // Reads into the next ones, which is faster than a copy of so many bytes.
            Some(eight) => u64::from_le_bytes(*eight) & digits,
            None => {
                let mut eight = [0; 8];
                eight[..width].copy_from_slice(&packed[..width]);
                u64::from_le_bytes(eight)
            }
        };
        if number == 0 {
            return Err(NoRun);
        }
        numbers[mask.trailing_zeros() as usize] = number;
        packed = &packed[width..];
        mask &= mask - 1;
    }
    Ok(numbers)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn written(numbers: &[u64; RUN]) -> Vec<u8> {
        let mut out = Vec::new();
        put(numbers, &mut out);
        out
    }

    #[test]
    fn nothing_takes_eight_bytes_and_small_numbers_one_each() {
        let mut numbers = [0; RUN];
        assert_eq!(written(&numbers).len(), 8);
        (numbers[3], numbers[63]) = (255, 1);
        assert_eq!(written(&numbers), [8, 0, 0, 0, 0, 0, 0, 0x80, 1, 255, 1]);
        assert_eq!(written(&[u64::MAX; RUN]).len(), MOST_BYTES);
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_back(
            numbers in prop::array::uniform32((0..64_u32, any::<u64>())),
            after in any::<[u8; 3]>(),
        ) {
            let mut run = [0; RUN];
            for (place, (shift, number)) in numbers.into_iter().enumerate() {
                run[2 * place] = number >> shift;
            }
            let bytes = [written(&run), after.to_vec()].concat();
            let mut rest = &bytes[..];
            prop_assert_eq!(take(&mut rest), Ok(run));
            prop_assert_eq!(rest, after);
            let mut cut = &bytes[..bytes.len() - 4];
            prop_assert_eq!(take(&mut cut), Err(NoRun));
        }

        #[test]
        fn any_bytes_are_a_run_that_is_written_so_or_none(bytes in prop::collection::vec(any::<u8>(), 0..600)) {
            let mut rest = &bytes[..];
            if let Ok(numbers) = take(&mut rest) {
                // A width may be larger than it need be.
                prop_assert!(written(&numbers).len() <= bytes.len() - rest.len());
            }
        }
    }
}
