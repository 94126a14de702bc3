//! The spread of shadow rays over the pieces of eye paths: more where more is to be found.

/// Errors below this share of the mean radiance do not count more than others.
const DARK: f32 = 0.01;

/// No piece gets more than this many times the mean number of shadow rays.
const MOST: f32 = 8.0;

/// What some pixels are expected to need tells how shadow rays are spread over all.
#[derive(Clone, Copy, Default)]
pub(super) struct Spread {
    /// Expected luminance under which errors do not count more.
    floor: f32,
    /// Mean need of a piece.
    mean: f32,
}

impl Spread {
    /// From the expected luminance of some pixels, and the expected errors of their pieces.
    pub(super) fn new(looked: &[(f32, Vec<f32>)]) -> Self {
        let floor = DARK * looked.iter().map(|seen| seen.0).sum::<f32>() / looked.len() as f32;
        let spread = Self { floor, mean: 1.0 };
        let needs = looked
            .iter()
            .flat_map(|(expected, errors)| errors.iter().map(move |error| spread.need(*error, *expected)));
        let (sum, count) = needs.fold((0.0, 0_u32), |(sum, count), need| (sum + need, count + 1));
        Self { floor, mean: if sum > 0.0 { sum / count as f32 } else { 1.0 } }
    }

    /// Shadow rays of a piece where `mean` are a piece's, at least one.
    ///
    /// - `error`: that of the piece; `expected`: its pixel's luminance.
    pub(super) fn samples(&self, mean: u32, error: f32, expected: f32) -> usize {
        let share = self.need(error, expected) / self.mean;
        ((mean as f32 * share.min(MOST)).round() as usize).max(1)
    }

    /// The sum of (error / n)² / radiance² for a given sum of n is least with n in proportion to this.
    fn need(&self, error: f32, expected: f32) -> f32 {
        let relative = error / (expected * expected + self.floor * self.floor).sqrt().max(f32::MIN_POSITIVE);
        let root = libm::cbrtf(relative);
        root * root
    }
}
