//! Error curves: means over the seeds, their spread, and what is read off them.

use super::methods::Compared;
use super::{SceneResult, fit};

/// What a curve runs over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Over {
    CpuTime,
    Passes,
}

/// After some passes, over the seeds that made them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CurvePoint {
    pub(super) passes: f64,
    pub(super) cpu_seconds: f64,
    /// Mean relMSE, and the least and the largest of the seeds.
    pub(super) error: f64,
    pub(super) low: f64,
    pub(super) high: f64,
    /// Mean bias.
    pub(super) bias: f64,
    /// Standard error of the mean relMSE.
    pub(super) standard_error: f64,
}

/// An error is told from nothing if it is so many standard errors above it.
const CERTAIN: f64 = 3.0;

/// A number, and whether the noise of the measurement is no small part of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Value {
    pub(super) number: f64,
    pub(super) is_doubtful: bool,
}

/// A method in a region.
pub(super) struct Curve {
    pub(super) method: &'static Compared,
    pub(super) points: Vec<CurvePoint>,
}

impl Curve {
    pub(super) fn new(scene: &SceneResult, method: &'static Compared, region: usize) -> Self {
        let runs = || scene.runs.iter().filter(|run| run.method == method.name);
        let longest = runs().map(|run| run.points.as_slice()).max_by_key(|points| points.len());
        let mean = |passes: u32| {
            let found: Vec<_> =
                runs().flat_map(|run| run.points.iter().find(|point| point.passes == passes)).collect();
            let count = found.len() as f64;
            let errors = || found.iter().map(|point| point.errors[region].rel_mse);
            CurvePoint {
                passes: f64::from(passes),
                cpu_seconds: found.iter().map(|point| point.cpu_seconds).sum::<f64>() / count,
                error: errors().sum::<f64>() / count,
                low: errors().fold(f64::INFINITY, f64::min),
                high: errors().fold(f64::NEG_INFINITY, f64::max),
                standard_error: found
                    .iter()
                    .map(|point| point.errors[region].standard_error.powi(2))
                    .sum::<f64>()
                    .sqrt()
                    / count,
                bias: found.iter().map(|point| point.errors[region].bias).sum::<f64>() / count,
            }
        };
        let points = longest.into_iter().flatten().map(|point| mean(point.passes)).collect();
        Self { method, points }
    }

    /// Points whose mean error is above its noise, so that it has a logarithm.
    pub(super) fn positive(&self) -> impl Iterator<Item = &CurvePoint> {
        self.points.iter().filter(|point| point.error > 0.0)
    }

    pub(super) fn slope(&self, over: Over) -> Option<f64> {
        let fitted = self.points.iter().filter(|point| point.passes >= fit::FIRST_FITTED);
        fit::slope(fitted.map(|point| (point.x(over), point.error)))
    }

    fn by_time(&self) -> Vec<(f64, f64)> {
        self.positive().map(|point| (point.cpu_seconds, point.error)).collect()
    }

    /// Error when so many CPU-seconds are spent; None outside the measured ones.
    pub(super) fn error_at(&self, cpu_seconds: f64) -> Option<Value> {
        let next = self.positive().position(|point| point.cpu_seconds >= cpu_seconds)?;
        let around: Vec<_> =
            self.positive().skip(next.saturating_sub(1)).take(if next == 0 { 1 } else { 2 }).collect();
        let is_doubtful = around.iter().any(|point| point.error < CERTAIN * point.standard_error);
        Some(Value { number: fit::at(&self.by_time(), cpu_seconds)?, is_doubtful })
    }

    /// CPU-seconds until the error has fallen so far; None if that was not measured.
    pub(super) fn time_to(&self, error: f64) -> Option<f64> {
        fit::reached(&self.by_time(), error)
    }
}

impl CurvePoint {
    pub(super) fn x(&self, over: Over) -> f64 {
        match over {
            Over::CpuTime => self.cpu_seconds,
            Over::Passes => self.passes,
        }
    }
}

/// All methods that were run in a scene, in the order of the table of methods.
pub(super) fn curves(scene: &SceneResult, region: usize) -> Vec<Curve> {
    let was_run = |method: &&Compared| scene.runs.iter().any(|run| run.method == method.name);
    super::METHODS.iter().filter(was_run).map(|method| Curve::new(scene, method, region)).collect()
}

/// The latest CPU time that all curves have reached: where methods are compared at equal time.
pub(super) fn common_time(curves: &[Curve]) -> Option<f64> {
    let ends = curves.iter().map(|curve| curve.points.last().map(|point| point.cpu_seconds));
    ends.collect::<Option<Vec<f64>>>()?.into_iter().min_by(f64::total_cmp)
}
