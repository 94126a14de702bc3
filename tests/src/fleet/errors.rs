//! Errors against a reference that is noisy itself.
//!
//! With two independent halves A and B of a reference, the mean of (I - A)(I - B) is that of (I - R)² for a reference without noise: theirs
//! cancels in the mean. What it still adds is spread, which the standard errors show. Between two pictures held against the same halves
//! the product of the halves' noises cancels exactly, so that their difference is known better than either.

use super::blocks;
use super::rings::Ratio;
use covbeam_session::color::luminance;
use covbeam_session::film::Picture;

/// Relative squared error of a picture by block of pixels, as sums.
#[derive(Clone, Debug)]
pub struct Errors {
    /// Of (I - A)(I - B) / (R² + (0.01 mean R)²), R = (A + B) / 2: relMSE as `covbeam compare` normalises it.
    sums: Vec<f64>,
    /// The same where no pixel counts for more than an error of 100 %: a handful of rare bright pixels decides relMSE otherwise.
    bounded: Vec<f64>,
    pixels: f64,
}

impl Errors {
    /// Of a picture against both halves of a reference of its size.
    pub fn new(picture: &Picture, halves: [&Picture; 2]) -> Self {
        let values = |picture: &Picture| -> Vec<f64> {
            picture.radiance.iter().map(|value| f64::from(luminance(*value))).collect()
        };
        let (image, [a, b]) = (values(picture), halves.map(values));
        let pixels = image.len() as f64;
        let mean = a.iter().chain(&b).sum::<f64>() / (2.0 * pixels);
        let floor = (0.01 * mean).powi(2);
        let (mut sums, mut bounded) = (Vec::new(), Vec::new());
        for (pixel, ((i, a), b)) in (0..).zip(image.iter().zip(&a).zip(&b)) {
            let block = blocks::block_of(picture.width, pixel);
            sums.resize(sums.len().max(block + 1), 0.0);
            bounded.resize(sums.len(), 0.0);
            let r = 0.5 * (a + b);
            let square = (i - a) * (i - b) / (r * r + floor);
            sums[block] += square;
            bounded[block] += square.clamp(-1.0, 1.0);
        }
        Self { sums, bounded, pixels }
    }

    /// The mean of some pictures of one size held against the same halves, at least one, each multiplied by a factor.
    pub fn mean(of: &[(Self, f64)]) -> Self {
        let share = 1.0 / of.len() as f64;
        let sum = |sums: fn(&Self) -> &Vec<f64>| {
            let block =
                |block: usize| of.iter().map(|(errors, factor)| share * factor * sums(errors)[block]).sum();
            (0..sums(&of[0].0).len()).map(block).collect()
        };
        Self {
            sums: sum(|errors| &errors.sums),
            bounded: sum(|errors| &errors.bounded),
            pixels: of[0].0.pixels,
        }
    }

    /// relMSE. Where the noise of the reference is larger than the error it may come out negative.
    pub fn rel_mse(&self) -> Ratio {
        let count = self.sums.len() as f64;
        let sum: f64 = self.sums.iter().sum();
        let square: f64 = self.sums.iter().map(|part| (part - sum / count).powi(2)).sum();
        Ratio { value: sum / self.pixels, error: (count / (count - 1.0) * square).sqrt() / self.pixels }
    }

    /// relMSE over that of another picture held against the same halves, with the standard error of the jackknife over the blocks.
    ///
    /// Blocks that lie side by side share some light, so that the true spread is somewhat larger.
    pub fn over(&self, other: &Self) -> Ratio {
        Self::ratio(&self.sums, &other.sums)
    }

    /// The same where no pixel counts for more than an error of 100 %.
    pub fn bounded_over(&self, other: &Self) -> Ratio {
        Self::ratio(&self.bounded, &other.bounded)
    }

    fn ratio(above: &[f64], below: &[f64]) -> Ratio {
        let parts = above.iter().zip(below);
        let [above, below]: [f64; 2] = [above, below].map(|sums| sums.iter().sum());
        let without: Vec<f64> = parts.map(|(a, b)| (above - a) / (below - b)).collect();
        let count = without.len() as f64;
        let mean = without.iter().sum::<f64>() / count;
        let square: f64 = without.iter().map(|ratio| (ratio - mean).powi(2)).sum();
        Ratio { value: above / below, error: ((count - 1.0) / count * square).sqrt() }
    }
}

/// True error over stated error of a picture: the square root of the median over the blocks of mean (I - A)(I - B) over mean stated variance,
/// so that noise of the reference cancels. None if the picture states none.
pub fn true_over_stated(picture: &Picture, [a, b]: [&Picture; 2]) -> Option<f64> {
    let stated = picture.error.as_ref()?;
    let value = |of: &Picture, pixel: usize| f64::from(luminance(of.radiance[pixel]));
    let mut sums: Vec<[f64; 2]> = Vec::new();
    for (pixel, stated) in stated.iter().enumerate() {
        let block = blocks::block_of(picture.width, pixel as u32);
        sums.resize(sums.len().max(block + 1), [0.0; 2]);
        let image = value(picture, pixel);
        sums[block][0] += (image - value(a, pixel)) * (image - value(b, pixel));
        sums[block][1] += f64::from(*stated).powi(2);
    }
    let mut ratios: Vec<f64> =
        sums.iter().filter(|[_, stated]| *stated > 0.0).map(|[truth, stated]| truth / stated).collect();
    ratios.sort_by(f64::total_cmp);
    ratios.get(ratios.len() / 2).map(|ratio| ratio.max(0.0).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;
    use glam::Vec3;

    /// A reference with halves of 10 % of noise, pictures with 10 and 20 %: relMSE .01 and .04.
    #[test]
    fn the_noise_of_the_reference_cancels() {
        let mut stream = Stream::new(3);
        let mut picture = |noise: f64| {
            // Uniform with a standard deviation of 1.
            let mut value = || 1.0 + noise * 12_f64.sqrt() * (stream.uniform() - 0.5);
            let radiance = (0..128 * 128).map(|_| Vec3::splat(value() as f32)).collect();
            Picture { width: 128, height: 128, radiance, ..Picture::default() }
        };
        let (a, b) = (picture(0.1), picture(0.1));
        let [ten, twenty] = [0.1, 0.2].map(|noise| Errors::new(&picture(noise), [&a, &b]));
        let (first, second) = (ten.rel_mse(), twenty.rel_mse());
        // R² is larger than 1 by the noise of R, .005, and its inverse by three times that.
        assert!((first.value - 0.01).abs() < 4.0 * first.error + 0.0002, "{first:?}");
        assert!((second.value - 0.04).abs() < 4.0 * second.error + 0.0008, "{second:?}");
        assert!(first.error < 0.001);
        let ratio = ten.over(&twenty);
        assert!((ratio.value - 0.25).abs() < 4.0 * ratio.error + 0.01 && ratio.error < 0.02, "{ratio:?}");
        // Half the time, half of it.
        let mean = Errors::mean(&[(ten.clone(), 0.5), (ten.clone(), 0.5)]);
        assert!((mean.over(&ten).value - 0.5).abs() < 1e-12);
    }

    /// One pixel that is 100 times too bright: relMSE 99²/N, and 1/N where pixels are bounded.
    #[test]
    fn a_rare_bright_pixel_counts_once_where_pixels_are_bounded() {
        let with = |values: [f32; 2]| {
            let radiance =
                (0..64).map(|pixel| Vec3::splat(if pixel < 2 { values[pixel] } else { 1.0 })).collect();
            Picture { width: 8, height: 8, radiance, ..Picture::default() }
        };
        let even = with([1.0, 1.0]);
        let [rare, double] =
            [with([100.0, 1.0]), with([1.0, 2.0])].map(|image| Errors::new(&image, [&even; 2]));
        assert!((rare.over(&double).value / 99_f64.powi(2) - 1.0).abs() < 1e-12);
        // Of an error of 1 / (1 + .01²).
        assert!((rare.bounded_over(&double).value - 1.0001).abs() < 1e-12);
    }
}
