//! Arithmetic of a build: whether two of them make the same bits.

use std::hint::black_box;

/// CRC-32 of what the functions of mathematics give that pictures are made with, and of roundings.
///
/// Guarantee: the same on all machines for one version of `libm` (the one of `Cargo.lock`), in a thread that rounds to nearest and keeps
/// subnormal numbers. Builds with another `libm` have another value, and so has a thread whose host rounds otherwise: sums of such passes are
/// not added to each other. (Test `arithmetic_…`; `tests/golden.txt` says the same of pictures.)
pub fn arithmetic() -> u32 {
    let mut crc = crc32fast::Hasher::new();
    for step in 0..64 {
        // The compiler shall not know the argument: it has a library of its own.
        let x = black_box((f64::from(step) + 0.5) / 64.0);
        singles(x as f32).iter().for_each(|value| crc.update(&value.to_le_bytes()));
        doubles(x).iter().for_each(|value| crc.update(&value.to_le_bytes()));
    }
    crc.finalize()
}

fn singles(x: f32) -> [f32; 22] {
    let (sine, cosine) = libm::sincosf(7.0 * x);
    [
        sine,
        cosine,
        libm::sinf(x),
        libm::cosf(x),
        libm::tanf(x),
        libm::acosf(x),
        libm::atanf(9.0 * x),
        libm::atan2f(x, -0.3),
        libm::expf(-20.0 * x),
        libm::exp2f(5.0 * x),
        libm::expm1f(-x),
        libm::logf(x),
        libm::log1pf(-x),
        libm::powf(x, 0.7),
        libm::cbrtf(x),
        libm::hypotf(x, 0.6),
        libm::sqrtf(x),
        x.sqrt(),
        x.mul_add(x, -0.1),
        x / 3.0,
        f32::MIN_POSITIVE * x,
        x.rem_euclid(0.3),
    ]
}

fn doubles(x: f64) -> [f64; 14] {
    let (sine, cosine) = libm::sincos(7.0 * x);
    [
        sine,
        cosine,
        libm::sin(x),
        libm::cos(x),
        libm::tan(x),
        libm::acos(x),
        libm::atan2(x, -0.3),
        libm::log(x),
        libm::log10(x),
        libm::log1p(-x),
        libm::pow(x, 0.7),
        libm::cbrt(x),
        libm::hypot(x, 0.6),
        x.sqrt(),
    ]
}

#[cfg(test)]
mod tests {
    use super::arithmetic;

    /// Written down once: a machine or a libm that gives another value makes other pictures.
    #[test]
    fn arithmetic_is_the_same_on_all_machines() {
        assert_eq!(arithmetic(), 0xc840_8af0, "{:#010x}", arithmetic());
    }
}
