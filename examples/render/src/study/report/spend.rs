//! Passes within a budget of time, told to the user.

use covbeam_session::film::{Film, FilmError};
use covbeam_session::pass::{PassTimes, Renderer};
use cpu_time::ProcessTime;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// When a run ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Budget {
    /// When the next pass, as long as the last one, would bring the run above these CPU-seconds; at least one pass.
    CpuSeconds(f64),
    /// After so many passes, > 0.
    Passes(u32),
}

/// What a run has used up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Spent {
    pub(super) passes: u32,
    pub(super) cpu_seconds: f64,
    pub(super) times: PassTimes,
}

/// Where a report stands, for the user, and whether the user has had enough.
pub struct Watch<'a> {
    cancelled: &'a (dyn Fn() -> bool + Sync),
    show: &'a (dyn Fn(&str, f64) + Sync),
    /// CPU-seconds that all steps may take together.
    all: f64,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    step: String,
    /// CPU-seconds expected of the steps before, and of this one.
    before: f64,
    expected: f64,
}

impl<'a> Watch<'a> {
    /// `cancelled` is asked a few hundred times a pass; `show` is told what is done, and which share of the whole is.
    pub fn new(
        all: f64,
        cancelled: &'a (dyn Fn() -> bool + Sync),
        show: &'a (dyn Fn(&str, f64) + Sync),
    ) -> Self {
        Self { cancelled, show, all, state: Mutex::default() }
    }

    /// Whether to stop.
    pub fn is_cancelled(&self) -> bool {
        (self.cancelled)()
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The next step. A number of passes counts as no time: the run before it said how long they take.
    pub(super) fn begin(&self, step: String, budget: Budget) {
        let expected = match budget {
            Budget::CpuSeconds(seconds) => seconds,
            Budget::Passes(_) => self.state().expected,
        };
        let mut state = self.state();
        state.before += state.expected;
        state.expected = expected;
        state.step = step;
        (self.show)(&state.step, (state.before / self.all).min(1.0));
    }

    fn spent(&self, seconds: f64) {
        let state = self.state();
        (self.show)(&state.step, ((state.before + seconds.min(state.expected)) / self.all).min(1.0));
    }
}

/// Adds passes to the film until the budget is used. `already`: CPU-seconds that getting ready took. `after` is called after each pass;
/// true = it was the last. None: cancelled.
pub(super) fn spend(
    renderer: &mut Renderer,
    film: &mut Film,
    budget: Budget,
    already: f64,
    watch: &Watch,
    mut after: impl FnMut(&Spent, &Film, bool),
) -> Result<Option<Spent>, FilmError> {
    let mut spent = Spent { cpu_seconds: already, ..Spent::default() };
    loop {
        let start = ProcessTime::now();
        let Some((image, times)) = renderer.pass(spent.passes + 1, watch.cancelled) else { return Ok(None) };
        film.add(&image)?;
        let last = start.elapsed().as_secs_f64();
        spent.passes += 1;
        spent.cpu_seconds += last;
        spent.times += times;
        let ends = match budget {
            Budget::CpuSeconds(seconds) => spent.cpu_seconds + last > seconds,
            Budget::Passes(passes) => spent.passes >= passes,
        };
        watch.spent(spent.cpu_seconds);
        after(&spent, film, ends);
        if ends {
            return Ok(Some(spent));
        }
        if watch.is_cancelled() {
            return Ok(None);
        }
    }
}
