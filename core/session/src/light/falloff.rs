//! Falloff: how a lamp's straight light changes along its way, beside growing thin as it spreads.

/// Light times dᵃ d²/(s + d²) at a distance d from where it left its lamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Falloff {
    /// a: 1 makes light of a point fall with the distance, and not with its square; 2 lets it be as strong everywhere.
    exponent: f32,
    /// s \[m²\].
    smooth: f32,
    /// How far it shines, where paths have the power that they start with \[m\]. In fog without end what is scattered farther away has that, too, or it
    /// would have any.
    typical: f32,
}

impl Default for Falloff {
    /// None.
    fn default() -> Self {
        Self { exponent: 0.0, smooth: 0.0, typical: 1.0 }
    }
}

/// A beam of such light is as many as its length grows by this factor, each as strong all along.
const GROWTH: f32 = 1.25;

impl Falloff {
    /// - `exponent`, `smooth`: >= 0; `typical`: > 0, to the farthest place that it shines on.
    pub(crate) fn new(exponent: f32, smooth: f32, typical: f32) -> Self {
        let made = Self { exponent, smooth, typical };
        // One that changes nothing is like any other that does not.
        if made.acts() { made } else { Self::default() }
    }

    /// Whether it changes anything.
    #[inline]
    pub(crate) fn acts(&self) -> bool {
        self.exponent != 0.0 || self.smooth != 0.0
    }

    /// The factor at a distance >= 0.
    #[inline]
    pub(crate) fn at(&self, distance: f32) -> f32 {
        if !self.acts() {
            return 1.0;
        }
        let squared = distance * distance;
        let smoothed = if self.smooth > 0.0 { squared / (self.smooth + squared) } else { 1.0 };
        smoothed * libm::powf(distance, self.exponent)
    }

    /// The power of the distance that it is like around a distance > 0.
    fn slope(&self, distance: f32) -> f32 {
        let smoothed =
            if self.smooth > 0.0 { 2.0 * self.smooth / (self.smooth + distance * distance) } else { 0.0 };
        self.exponent + smoothed
    }

    /// That at the typical distance.
    pub(crate) fn typical(&self) -> f32 {
        self.at(self.typical)
    }

    /// The factor at a distance over that at the typical one, which is in the power of paths.
    #[inline]
    pub(crate) fn share(&self, distance: f32) -> f32 {
        self.at(distance.min(self.typical)) / self.typical()
    }

    /// Pieces of its way between two distances, each with a factor over that at the typical distance. With shifts at random the mean of the factors
    /// at any place is the factor there, but for the third order of how its slope changes: a power's mean is sinh(x)/x times that in the piece's
    /// middle.
    ///
    /// - `shift`: uniform.
    pub(crate) fn pieces(self, [from, to]: [f32; 2], shift: f32) -> impl Iterator<Item = ([f32; 2], f32)> {
        let step = libm::logf(GROWTH);
        // Nearer than this there is nothing to speak of.
        let least = 1e-3 * self.typical;
        let number = |distance: f32| libm::floorf(libm::logf(distance.max(least)) / step - shift);
        let end = move |number: f32| libm::expf((number + shift) * step);
        let [first, last] = [number(from), number(to)];
        (0..=(last - first) as u32).map(move |piece| {
            let piece = first + piece as f32;
            let low = if piece == first { from } else { end(piece) };
            let high = if piece == last { to } else { end(piece + 1.0) };
            let middle = end(piece + 0.5);
            let x = 0.5 * step * self.slope(middle);
            let mean = if x > 1e-3 { libm::sinhf(x) / x } else { 1.0 };
            ([low, high.max(low)], self.share(middle) / mean)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The light on a way is the integral of the factor along it.
    #[test]
    fn pieces_of_a_way_have_all_of_its_light() {
        for (exponent, smooth) in [(1.0, 0.0), (2.0, 0.0), (0.0, 3.0), (2.0, 3.0)] {
            let falloff = Falloff::new(exponent, smooth, 8.0);
            for ends in [[0.0, 7.0], [0.75, 3.5], [4.0, 4.01]] {
                let shifts = 4096;
                let mut sum = 0.0;
                for shift in 0..shifts {
                    let shift = (shift as f32 + 0.5) / shifts as f32;
                    let mut at = ends[0];
                    for ([low, high], factor) in falloff.pieces(ends, shift) {
                        assert!((low - at).abs() < 1e-5 && high >= low, "{low}..{high} after {at}");
                        sum += f64::from(factor * (high - low));
                        at = high;
                    }
                    assert_eq!(at, ends[1]);
                }
                let (steps, width) = (100_000, f64::from(ends[1] - ends[0]));
                let factor = |step: usize| {
                    let d = f64::from(ends[0]) + (step as f64 + 0.5) * width / steps as f64;
                    let at = |d: f64| libm::pow(d, f64::from(exponent)) * d * d / (f64::from(smooth) + d * d);
                    at(d) / at(8.0)
                };
                let expected = (0..steps).map(factor).sum::<f64>() * width / steps as f64;
                let found = sum / f64::from(shifts);
                println!("{exponent}, {smooth}, {ends:?}: {found} of {expected}");
                // What is smoothed is no power of the distance within a piece.
                assert!((found / expected - 1.0).abs() < 2e-3);
            }
        }
    }
}
