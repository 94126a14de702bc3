//! The loop over passes: how long it goes on, what it adds up, and that it can be stopped.

use crate::film::samples::PassImage;
use crate::film::{Film, FilmError};
use crate::pass::PassTimes;
use std::time::{Duration, Instant};

/// When a render is finished: as soon as one of these is reached. One pass is always made.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Goal {
    /// After this many passes, > 0.
    pub passes: Option<u32>,
    /// So long after the start, with the picture written: a pass that would end later is cut.
    pub time: Option<Duration>,
    /// When the median over the lit pixels of standard error over luminance is below this, > 0.
    pub error: Option<f64>,
}

/// Where a render stands, after a pass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Progress {
    /// Passes in the film.
    pub passes: u32,
    /// How many of them were in it before this render.
    pub before: u32,
    /// Time since the start.
    pub elapsed: Duration,
    /// Time of the last pass.
    pub last: Duration,
    /// Time that making and writing the picture took when that was last done.
    pub saving: Duration,
    /// The median relative error when it was last looked at, and after how many passes.
    pub error: Option<(f64, u32)>,
    /// Sums over the passes.
    pub times: PassTimes,
}

/// The error is looked at after this many passes first: two halves of two.
const FIRST_LOOK: u32 = 4;

/// Passes after which a picture without any light is not expected to get some.
const DARK: u32 = 64;

/// Writing the last picture may take this much longer than it did before.
const SAVING_MARGIN: f64 = 1.15;

impl Progress {
    /// When passes have to end for the picture to be written in time.
    fn deadline(&self, goal: &Goal) -> Option<Duration> {
        goal.time.map(|time| time.saturating_sub(self.saving.mul_f64(SAVING_MARGIN)))
    }

    /// Whether the goal is reached.
    pub fn reaches(&self, goal: &Goal) -> bool {
        let late = self.deadline(goal).is_some_and(|deadline| self.elapsed >= deadline);
        self.passes > 0
            && (late
                || goal.passes.is_some_and(|passes| self.passes >= passes)
                || goal.error.is_some_and(|goal| self.error.is_some_and(|(error, _)| error <= goal)))
    }

    /// Expected time until the goal is reached, from the mean pass of this render; None before the first, and where only the
    /// error counts and is not known yet.
    pub fn left(&self, goal: &Goal) -> Option<Duration> {
        let mean = self.elapsed.checked_div(self.passes - self.before)?;
        let passes = goal.passes.map(|passes| mean * passes.saturating_sub(self.passes));
        let time = goal.time.map(|time| time.saturating_sub(self.elapsed));
        let error = self.passes_for(goal).map(|passes| mean * passes.saturating_sub(self.passes));
        [passes, time, error].into_iter().flatten().min()
    }

    /// Passes after which the error is expected to be small enough: it falls as the square root of their number.
    fn passes_for(&self, goal: &Goal) -> Option<u32> {
        let (error, passes) = self.error?;
        let times = error / goal.error?;
        Some((f64::from(passes) * times * times).ceil().min(f64::from(u32::MAX)) as u32)
    }

    /// Whether the error is looked at now: at the first chance, and then not more often than at every tenth pass.
    fn looks(&self, goal: &Goal) -> bool {
        let Some((_, before)) = self.error else { return goal.error.is_some() && self.passes >= FIRST_LOOK };
        let expected = self.passes_for(goal).unwrap_or(u32::MAX);
        goal.error.is_some()
            && self.passes >= expected.clamp(before + before / 10 + 1, before.saturating_mul(2))
    }
}

/// How a render ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The goal is reached.
    Reached,
    /// Passes or time were over before the error was small enough.
    NotReached,
    /// An error was asked for, and no light reaches the picture.
    Dark,
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

/// Adds passes to `film`, after those that it has, until `goal` is reached or `cancelled` is true. `start` is when its time began; `pass`
/// renders the pass of an index, of which the film's first has 1 (None: it was cancelled); `report` is called after each with where the
/// render stands and with the film, and answers how long saving the picture took, if it did.
///
/// # Errors
/// A pass that the film refuses, or an error of `report`.
pub fn render<E>(
    film: &mut Film,
    goal: &Goal,
    start: Instant,
    cancelled: &(dyn Fn() -> bool + Sync),
    mut pass: impl FnMut(u32, &(dyn Fn() -> bool + Sync)) -> Option<(PassImage, PassTimes)>,
    mut report: impl FnMut(&Progress, &Film) -> Result<Option<Duration>, E>,
) -> Result<(End, Progress), RenderError<E>> {
    let before = film.passes();
    let mut progress = Progress { passes: before, before, ..Progress::default() };
    while !progress.reaches(goal) {
        let index = progress.passes + 1;
        let deadline = progress.deadline(goal).filter(|_| progress.passes > 0);
        let late = || deadline.is_some_and(|deadline| start.elapsed() >= deadline);
        let begun = start.elapsed();
        let made = if cancelled() { None } else { pass(index, &|| cancelled() || late()) };
        let Some((image, times)) = made else {
            progress.elapsed = start.elapsed();
            if cancelled() {
                return Ok((End::Cancelled, progress));
            }
            break;
        };
        film.add(&image).map_err(|source| RenderError::Pass { pass: index, source })?;
        // Before a picture takes its place.
        drop(image);
        progress.passes = index;
        progress.last = start.elapsed() - begun;
        progress.elapsed = start.elapsed();
        progress.times += times;
        if progress.looks(goal) {
            match film.picture().median_relative_error() {
                Some(error) => progress.error = Some((error, index)),
                None if index >= DARK => return Ok((End::Dark, progress)),
                None => {}
            }
        }
        if let Some(saving) = report(&progress, film).map_err(RenderError::Report)? {
            progress.saving = saving;
        }
        progress.elapsed = start.elapsed();
    }
    let small = goal.error.is_none_or(|goal| progress.error.is_some_and(|(error, _)| error <= goal));
    Ok((if small { End::Reached } else { End::NotReached }, progress))
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

    fn passes(passes: u32) -> Goal {
        Goal { passes: Some(passes), ..Goal::default() }
    }

    fn time(time: Duration) -> Goal {
        Goal { time: Some(time), ..Goal::default() }
    }

    fn error(error: f64) -> Goal {
        Goal { error: Some(error), ..Goal::default() }
    }

    fn quiet(_: &Progress, _: &Film) -> Result<Option<Duration>, Infallible> {
        Ok(None)
    }

    #[test]
    fn passes_are_counted_from_one_and_averaged() {
        let mut film = Film::new(1, 1);
        let pass = |index, _: &(dyn Fn() -> bool + Sync)| Some((image(index as f32), times()));
        let mut reports = Vec::new();
        let report = |p: &Progress, f: &Film| -> Result<Option<Duration>, Infallible> {
            reports.push((p.passes, f.passes()));
            Ok(None)
        };
        let (end, progress) = render(&mut film, &passes(4), Instant::now(), &|| false, pass, report).unwrap();
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
        let (end, progress) =
            render(&mut film, &passes(100), Instant::now(), &cancelled, pass, quiet).unwrap();
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
        let (end, _) = render(&mut film, &passes(1), Instant::now(), &|| true, pass, quiet).unwrap();
        assert_eq!((end, calls.into_inner(), film.passes()), (End::Cancelled, 0, 0));
    }

    #[test]
    fn a_time_that_is_too_short_still_gives_one_pass() {
        let mut film = Film::new(1, 1);
        let pass = |_, _: &(dyn Fn() -> bool + Sync)| Some((image(1.0), times()));
        let (end, _) =
            render(&mut film, &time(Duration::from_nanos(1)), Instant::now(), &|| false, pass, quiet)
                .unwrap();
        assert_eq!((end, film.passes()), (End::Reached, 1));
    }

    #[test]
    fn a_pass_that_would_end_too_late_is_cut_and_leaves_time_to_save() {
        let (pass_time, saving, all) =
            (Duration::from_millis(40), Duration::from_millis(100), Duration::from_millis(420));
        let mut film = Film::new(1, 1);
        let pass = |_, cancelled: &(dyn Fn() -> bool + Sync)| {
            let begun = Instant::now();
            while begun.elapsed() < pass_time {
                if cancelled() {
                    return None;
                }
            }
            Some((image(1.0), times()))
        };
        let report = |_: &Progress, _: &Film| -> Result<Option<Duration>, Infallible> { Ok(Some(saving)) };
        let start = Instant::now();
        let (end, progress) = render(&mut film, &time(all), start, &|| false, pass, report).unwrap();
        let left = all.checked_sub(start.elapsed()).expect("in time");
        assert_eq!(end, End::Reached);
        // 420 - 1.15 x 100 ms = 305 ms hold seven passes and a cut one, fewer on a machine that does other work too.
        assert!((1..=7).contains(&progress.passes), "{} passes", progress.passes);
        assert!(left >= saving && progress.elapsed <= all - saving, "{left:?} left");
    }

    #[test]
    fn the_time_left_is_that_of_the_nearest_goal() {
        let seconds = Duration::from_secs;
        let progress = |error| Progress { passes: 10, elapsed: seconds(20), error, ..Progress::default() };
        assert_eq!(progress(None).left(&passes(25)), Some(seconds(30)));
        assert_eq!(progress(None).left(&time(seconds(35))), Some(seconds(15)));
        assert_eq!(progress(None).left(&error(0.02)), None);
        // Twice the error needs four times the passes.
        assert_eq!(progress(Some((0.04, 10))).left(&error(0.02)), Some(seconds(60)));
        let both = Goal { time: Some(seconds(35)), ..error(0.02) };
        assert_eq!(progress(Some((0.04, 10))).left(&both), Some(seconds(15)));
        assert_eq!(Progress::default().left(&passes(3)), None);
    }

    /// Odd passes are brighter than 1 by `spread`, even ones darker: half the difference of the halves is that.
    fn noisy(spread: f32) -> impl FnMut(u32, &(dyn Fn() -> bool + Sync)) -> Option<(PassImage, PassTimes)> {
        move |pass, _| {
            let value = if pass.is_multiple_of(2) { 1.0 - spread } else { 1.0 + spread };
            Some((PassImage { pass, ..image(value) }, times()))
        }
    }

    #[test]
    fn an_error_that_is_small_enough_ends_the_render() {
        let mut film = Film::new(1, 1);
        let (end, progress) =
            render(&mut film, &error(0.5), Instant::now(), &|| false, noisy(0.1), quiet).unwrap();
        assert_eq!((end, progress.passes), (End::Reached, FIRST_LOOK));
        assert!((progress.error.unwrap().0 - 0.1).abs() < 1e-6);
    }

    #[test]
    fn an_error_that_is_not_reached_is_said() {
        let goal = Goal { passes: Some(12), ..error(0.01) };
        let mut film = Film::new(1, 1);
        let (end, progress) = render(&mut film, &goal, Instant::now(), &|| false, noisy(0.5), quiet).unwrap();
        assert_eq!((end, progress.passes), (End::NotReached, 12));
        assert!((progress.error.unwrap().0 - 0.5).abs() < 1e-6);
    }

    #[test]
    fn a_picture_without_light_ends_a_render_that_waits_for_an_error() {
        let dark =
            |pass: u32, _: &(dyn Fn() -> bool + Sync)| Some((PassImage { pass, ..image(0.0) }, times()));
        let mut film = Film::new(1, 1);
        let (end, progress) =
            render(&mut film, &error(0.01), Instant::now(), &|| false, dark, quiet).unwrap();
        assert_eq!((end, progress.passes), (End::Dark, DARK));
    }

    #[test]
    fn a_pass_with_nan_stops_the_render_and_is_left_out() {
        let mut film = Film::new(1, 1);
        let pass = |index, _: &(dyn Fn() -> bool + Sync)| {
            Some((image(if index == 2 { f32::NAN } else { 1.0 }), times()))
        };
        let error =
            render(&mut film, &passes(5), Instant::now(), &|| false, pass, quiet).unwrap_err().to_string();
        assert!(error.contains("pass 2") && error.contains("pixel (0, 0)"), "{error}");
        assert_eq!(film.passes(), 1);
    }
}
