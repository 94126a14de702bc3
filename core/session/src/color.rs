//! Colours as one number.

use glam::Vec3;

/// Weights of Rec. 709's luminance.
const LUMINANCE: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);

/// Luminance of a linear colour with Rec. 709 primaries.
pub fn luminance(color: Vec3) -> f32 {
    color.dot(LUMINANCE)
}

/// Mean of the channels.
pub(crate) fn mean(color: Vec3) -> f32 {
    color.element_sum() / 3.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn luminance_of_white_is_one() {
        // f32 rounding of three products and two sums.
        assert!((luminance(Vec3::ONE) - 1.0).abs() < 2e-7);
    }
}
