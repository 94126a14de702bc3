//! Weights tilted where a filter lacks a side.

use super::FilmSample;
use glam::Vec3;

/// Squared distance between the centre of a filter's samples and its pixel, in the filter's variances, from
/// which the weights are tilted: below, the slope of the light moves the mean by less than a tenth of what it
/// does at a border.
const OFF_CENTRE: f32 = 0.01;

/// What is added to the samples' second moments, in the filter's: where all of them lie to one side, a plane
/// would be extrapolated from noise.
const RIDGE: f32 = 0.03;

/// Share of the samples' weight that tilted weights keep at least: with less, they are nothing but
/// differences.
const LEAST_LEFT: f32 = 0.1;

/// Samples under a filter, with the moments of their places in the filter's standard deviations.
#[derive(Default)]
pub(super) struct Weighed {
    pub(super) sum: FilmSample,
    first: [f32; 2],
    second: [f32; 3],
}

impl Weighed {
    pub(super) fn add(&mut self, weight: f32, [u, v]: [f32; 2], sample: &FilmSample) {
        self.sum.add(weight, sample);
        let rays = weight * sample.weight;
        self.first = [self.first[0] + rays * u, self.first[1] + rays * v];
        let [uu, uv, vv] = self.second;
        self.second = [uu + rays * u * u, uv + rays * u * v, vv + rays * v * v];
    }

    /// The weights with which the samples' centre is the pixel; None where it all but is.
    pub(super) fn tilt(&self) -> Option<Tilted> {
        let rays = self.sum.weight;
        let [u, v] = self.first.map(|first| first / rays);
        let [uu, uv, vv] = self.second.map(|second| second / rays);
        let (uu, vv) = (uu + RIDGE, vv + RIDGE);
        let determinant = uu * vv - uv * uv;
        let slope = [(uv * v - vv * u) / determinant, (uv * u - uu * v) / determinant];
        let is_off = u * u + v * v > OFF_CENTRE && (slope[0] + slope[1]).is_finite();
        let sum = FilmSample::default();
        is_off.then_some(Tilted { slope, sum, least: Vec3::INFINITY, most: Vec3::NEG_INFINITY })
    }
}

/// The same samples, each weight times 1 + slope · place, and the range of what they saw.
pub(super) struct Tilted {
    slope: [f32; 2],
    sum: FilmSample,
    least: Vec3,
    most: Vec3,
}

impl Tilted {
    pub(super) fn add(&mut self, weight: f32, [u, v]: [f32; 2], sample: &FilmSample) {
        self.sum.add(weight * (1.0 + self.slope[0] * u + self.slope[1] * v), sample);
        let seen = sample.radiance / sample.weight;
        (self.least, self.most) = (self.least.min(seen), self.most.max(seen));
    }

    /// Its sums, as if a plane through noise never left the range of what was seen; `even` where too little
    /// weight is left, or more than what `f32` holds.
    pub(super) fn bounded(&self, even: FilmSample) -> FilmSample {
        let FilmSample { radiance, weight, first, first_weight } = self.sum;
        let sound =
            weight > LEAST_LEFT * even.weight && radiance.is_finite() && (first + first_weight).is_finite();
        if !sound {
            return even;
        }
        FilmSample { radiance: weight * (radiance / weight).max(self.least).min(self.most), ..self.sum }
    }
}
