//! The loop over passes: how long it goes on, what it adds up, and that it can be stopped.

use crate::film::{Film, FilmError, PassImage};
use crate::pass::PassTimes;
use std::time::{Duration, Instant};

/// When a render is finished.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// After this many passes, > 0.
    Passes(u32),
    /// When the next pass, as long as the last one, would end later than this after the start; at least one pass.
    Time(Duration),
}

/// Where a render stands, after a pass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Progress {
    /// Passes added to the film.
    pub passes: u32,
    /// Time since the start.
    pub elapsed: Duration,
    /// Time of the last pass.
    pub last: Duration,
    /// Sums over the passes.
    pub times: PassTimes,
}

impl Progress {
    /// Whether the goal is reached.
    pub fn reaches(&self, goal: Goal) -> bool {
        match goal {
            Goal::Passes(passes) => self.passes >= passes,
            Goal::Time(time) => self.passes > 0 && self.elapsed + self.last > time,
        }
    }

    /// Expected time until the goal is reached, from the mean pass so far; None before the first pass.
    pub fn left(&self, goal: Goal) -> Option<Duration> {
        let mean = self.elapsed.checked_div(self.passes)?;
        Some(match goal {
            Goal::Passes(passes) => mean * passes.saturating_sub(self.passes),
            Goal::Time(time) => time.saturating_sub(self.elapsed),
        })
    }
}

/// How a render ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The goal is reached.
    Reached,
    /// `cancelled` became true; the film holds the passes finished until then.
    Cancelled,
}

/// Why a render failed; the film holds the passes before.
#[derive(Debug, thiserror::Error)]
pub enum RenderError<E> {
    /// A pass holds a value that no estimate of light can have.
    #[error("pass {pass} went wrong and was left out: {source}")]
    Pass {
        /// Index of the pass, counted from 1.
        pass: u32,
        /// What is wrong with it.
        source: FilmError,
    },
    /// What `report` said.
    #[error("{0}")]
    Report(E),
}

/// Adds passes 1, 2, … to `film` until `goal` is reached or `cancelled` is true. `pass` renders the pass of an index
/// (None: it was cancelled); `report` is called after each with where the render stands and with the film.
///
/// # Errors
/// A pass that the film refuses, or an error of `report`.
pub fn render<E>(
    film: &mut Film,
    goal: Goal,
    cancelled: &(dyn Fn() -> bool + Sync),
    mut pass: impl FnMut(u32, &(dyn Fn() -> bool + Sync)) -> Option<(PassImage, PassTimes)>,
    mut report: impl FnMut(&Progress, &Film) -> Result<(), E>,
) -> Result<(End, Progress), RenderError<E>> {
    let start = Instant::now();
    let mut progress = Progress::default();
    while !progress.reaches(goal) {
        if cancelled() {
            return Ok((End::Cancelled, progress));
        }
        let index = progress.passes + 1;
        let Some((image, times)) = pass(index, cancelled) else {
            progress.elapsed = start.elapsed();
            return Ok((End::Cancelled, progress));
        };
        film.add(&image).map_err(|source| RenderError::Pass { pass: index, source })?;
        progress.passes = index;
        progress.last = start.elapsed() - progress.elapsed;
        progress.elapsed = start.elapsed();
        progress.times += times;
        report(&progress, film).map_err(RenderError::Report)?;
    }
    Ok((End::Reached, progress))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use std::convert::Infallible;
    use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

    fn image(value: f32) -> PassImage {
        PassImage { width: 1, height: 1, radiance: vec![Vec3::splat(value)], ..PassImage::default() }
    }

    fn times() -> PassTimes {
        PassTimes {
            trace: 1.0,
            light_fields: 2.0,
            grid: 3.0,
            build: 4.0,
            plan: 4.5,
            gather: 5.0,
            pairs: 6,
            shadow_rays: 7,
        }
    }

    fn quiet(_: &Progress, _: &Film) -> Result<(), Infallible> {
        Ok(())
    }

    #[test]
    fn passes_are_counted_from_one_and_averaged() {
        let mut film = Film::new(1, 1);
        let pass = |index, _: &(dyn Fn() -> bool + Sync)| Some((image(index as f32), times()));
        let mut reports = Vec::new();
        let report = |p: &Progress, f: &Film| -> Result<(), Infallible> {
            reports.push((p.passes, f.passes()));
            Ok(())
        };
        let (end, progress) = render(&mut film, Goal::Passes(4), &|| false, pass, report).unwrap();
        assert_eq!(end, End::Reached);
        assert_eq!(reports, [(1, 1), (2, 2), (3, 3), (4, 4)]);
        // (1 + 2 + 3 + 4) / 4
        assert_eq!(film.picture().radiance, [Vec3::splat(2.5)]);
        let all = PassTimes {
            trace: 4.0,
            light_fields: 8.0,
            grid: 12.0,
            build: 16.0,
            plan: 18.0,
            gather: 20.0,
            pairs: 24,
            shadow_rays: 28,
        };
        assert_eq!(progress.times, all);
    }

    #[test]
    fn a_cancelled_render_keeps_the_finished_passes() {
        let stop = AtomicBool::new(false);
        let mut film = Film::new(1, 1);
        let pass = |index, cancelled: &(dyn Fn() -> bool + Sync)| {
            stop.store(index == 3, Ordering::Relaxed);
            (!cancelled()).then(|| (image(1.0), times()))
        };
        let cancelled = || stop.load(Ordering::Relaxed);
        let (end, progress) = render(&mut film, Goal::Passes(100), &cancelled, pass, quiet).unwrap();
        assert_eq!((end, progress.passes, film.passes()), (End::Cancelled, 2, 2));
    }

    #[test]
    fn a_render_cancelled_at_once_renders_nothing() {
        let calls = AtomicU32::new(0);
        let mut film = Film::new(1, 1);
        let pass = |_, _: &(dyn Fn() -> bool + Sync)| {
            calls.fetch_add(1, Ordering::Relaxed);
            Some((image(1.0), times()))
        };
        let (end, _) = render(&mut film, Goal::Passes(1), &|| true, pass, quiet).unwrap();
        assert_eq!((end, calls.into_inner(), film.passes()), (End::Cancelled, 0, 0));
    }

    #[test]
    fn a_time_that_is_too_short_still_gives_one_pass() {
        let mut film = Film::new(1, 1);
        let pass = |_, _: &(dyn Fn() -> bool + Sync)| Some((image(1.0), times()));
        let (end, _) =
            render(&mut film, Goal::Time(Duration::from_nanos(1)), &|| false, pass, quiet).unwrap();
        assert_eq!((end, film.passes()), (End::Reached, 1));
    }

    #[test]
    fn no_pass_is_begun_that_would_end_too_late() {
        let seconds = Duration::from_secs;
        let progress = |elapsed, last| Progress {
            passes: 3,
            elapsed: seconds(elapsed),
            last: seconds(last),
            times: PassTimes::default(),
        };
        assert!(!progress(7, 3).reaches(Goal::Time(seconds(10))));
        assert!(progress(8, 3).reaches(Goal::Time(seconds(10))));
        assert_eq!(progress(6, 2).left(Goal::Passes(10)), Some(seconds(14)));
        assert_eq!(progress(6, 2).left(Goal::Time(seconds(10))), Some(seconds(4)));
        assert_eq!(Progress::default().left(Goal::Passes(10)), None);
    }

    #[test]
    fn a_pass_with_nan_stops_the_render_and_is_left_out() {
        let mut film = Film::new(1, 1);
        let pass = |index, _: &(dyn Fn() -> bool + Sync)| {
            Some((image(if index == 2 { f32::NAN } else { 1.0 }), times()))
        };
        let error = render(&mut film, Goal::Passes(5), &|| false, pass, quiet).unwrap_err().to_string();
        assert!(error.contains("pass 2") && error.contains("pixel (0, 0)"), "{error}");
        assert_eq!(film.passes(), 1);
    }
}
