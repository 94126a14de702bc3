//! How far a picture is from a reference.

use covbeam_session::color::luminance;
use covbeam_session::film::Picture;
use glam::Vec3;
use std::fmt;
use std::str::FromStr;

/// What [`compare`] found, on linear luminance, over the pixels asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// Mean of (I - R)² / (R² + (0.01 mean R)²); mean R is that of the whole reference, not of the region.
    pub rel_mse: f64,
    /// mean(I - R) / mean(R) over the region; where R is black: 0 if I is too, else infinite.
    pub bias: f64,
    /// Mean luminance of the picture.
    pub mean: f64,
    /// Mean luminance of the reference.
    pub reference_mean: f64,
}

/// Why two pictures cannot be compared.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CompareError {
    /// Different sizes.
    #[error("the picture has {0} x {1} pixels, the reference {2} x {3}; compare pictures of the same size")]
    Size(u32, u32, u32, u32),
    /// NaN or infinity.
    #[error("{count} pixels of the {which} are NaN or infinite, the first at ({x}, {y})")]
    NotFinite {
        /// "picture" or "reference".
        which: &'static str,
        /// How many pixels.
        count: usize,
        /// Column of the first.
        x: u32,
        /// Row of the first.
        y: u32,
    },
    /// The relative error has no scale.
    #[error("the reference is black everywhere: there is nothing to be relative to")]
    BlackReference,
    /// The mask leaves nothing.
    #[error("the region has no pixels")]
    EmptyRegion,
}

/// Compares `picture` with `reference` over the pixels (x, y) for which `mask` is true ((0, 0) = upper left).
///
/// Both pictures are linear; only luminance (Rec. 709) counts. A hundredth of the mean keeps black pixels from ruling the metric.
///
/// # Errors
/// Different sizes, a pixel that is NaN or infinite anywhere in either picture, a black reference, an empty mask.
pub fn compare(
    picture: &Picture,
    reference: &Picture,
    mask: impl Fn(u32, u32) -> bool,
) -> Result<Comparison, CompareError> {
    let (width, height) = (picture.width, picture.height);
    if (width, height) != (reference.width, reference.height) {
        return Err(CompareError::Size(width, height, reference.width, reference.height));
    }
    check_finite(picture, "picture")?;
    check_finite(reference, "reference")?;

    let luminance = |v: &Vec3| f64::from(luminance(*v));
    let pixels = reference.radiance.len().max(1) as f64;
    let whole_mean = reference.radiance.iter().map(luminance).sum::<f64>() / pixels;
    if whole_mean == 0.0 {
        return Err(CompareError::BlackReference);
    }
    let floor = (0.01 * whole_mean).powi(2);

    let (mut count, mut error, mut sum, mut reference_sum) = (0.0, 0.0, 0.0, 0.0);
    for (index, (i, r)) in (0_u32..).zip(picture.radiance.iter().zip(&reference.radiance)) {
        if mask(index % width, index / width) {
            let (i, r) = (luminance(i), luminance(r));
            count += 1.0;
            error += (i - r).powi(2) / (r * r + floor);
            sum += i;
            reference_sum += r;
        }
    }
    if count == 0.0 {
        return Err(CompareError::EmptyRegion);
    }
    let difference = sum - reference_sum;
    let bias = if difference == 0.0 { 0.0 } else { difference / reference_sum };
    Ok(Comparison { rel_mse: error / count, bias, mean: sum / count, reference_mean: reference_sum / count })
}

fn check_finite(picture: &Picture, which: &'static str) -> Result<(), CompareError> {
    let bad = || (0_u32..).zip(&picture.radiance).filter(|(_, v)| !v.is_finite());
    match bad().next() {
        None => Ok(()),
        Some((index, _)) => Err(CompareError::NotFinite {
            which,
            count: bad().count(),
            x: index % picture.width,
            y: index / picture.width,
        }),
    }
}

/// A rectangle of pixels: columns `x0..x1` and rows `y0..y1`, upper bounds excluded, (0, 0) = upper left.
/// Written `x0,y0,x1,y1`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    /// First column.
    pub x0: u32,
    /// First row.
    pub y0: u32,
    /// One past the last column, > x0.
    pub x1: u32,
    /// One past the last row, > y0.
    pub y1: u32,
}

impl Region {
    /// Whether the pixel is inside.
    pub fn contains(&self, x: u32, y: u32) -> bool {
        (self.x0..self.x1).contains(&x) && (self.y0..self.y1).contains(&y)
    }
}

impl FromStr for Region {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Result<Vec<u32>, _> = text.split(',').map(|part| part.trim().parse()).collect();
        let Ok([x0, y0, x1, y1]) = numbers.as_deref() else {
            return Err("expected four whole numbers x0,y0,x1,y1 (pixels; upper bounds excluded)".to_owned());
        };
        if x0 >= x1 || y0 >= y1 {
            return Err(
                "the region is empty: x0 < x1 and y0 < y1 are needed (upper bounds excluded)".to_owned()
            );
        }
        Ok(Self { x0: *x0, y0: *y0, x1: *x1, y1: *y1 })
    }
}

impl fmt::Display for Region {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{},{},{},{}", self.x0, self.y0, self.x1, self.y1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_region_reads_back_as_it_is_written() {
        let region: Region = "116,172,140,236".parse().unwrap();
        assert_eq!(region, Region { x0: 116, y0: 172, x1: 140, y1: 236 });
        assert_eq!(region.to_string(), "116,172,140,236");
        assert!(region.contains(116, 172) && region.contains(139, 235));
        assert!(!region.contains(140, 200) && !region.contains(120, 236));
    }

    #[test]
    fn a_region_that_is_no_rectangle_is_refused_with_what_was_expected() {
        for text in ["", "1,2,3", "1,2,3,4,5", "a,b,c,d", "-1,0,2,2", "0.5,0,2,2"] {
            assert!(text.parse::<Region>().unwrap_err().contains("x0,y0,x1,y1"), "{text}");
        }
        for text in ["3,0,3,4", "4,0,3,4", "0,4,3,4"] {
            assert!(text.parse::<Region>().unwrap_err().contains("empty"), "{text}");
        }
    }
}
