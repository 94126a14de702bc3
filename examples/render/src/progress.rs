//! Progress of a long command on standard error: a bar in a terminal, else a line every few seconds.

use crate::render_command::seconds;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::{IsTerminal, stderr};
use std::sync::Mutex;
use std::time::{Duration, Instant};

const LINES_EVERY: Duration = Duration::from_secs(5);
const STEPS: f64 = 1000.0;

/// What is shown, and when.
pub(crate) struct Display {
    bar: Option<ProgressBar>,
    start: Instant,
    next_line: Mutex<Instant>,
}

impl Display {
    pub(crate) fn new() -> Self {
        let bar = stderr().is_terminal().then(|| {
            let style = ProgressStyle::with_template("[{bar:30}] {elapsed} {msg}").expect("a valid template");
            let bar = ProgressBar::new(STEPS as u64).with_style(style.progress_chars("=> "));
            bar.enable_steady_tick(Duration::from_millis(200));
            bar
        });
        Self { bar, start: Instant::now(), next_line: Mutex::new(Instant::now() + LINES_EVERY) }
    }

    /// `step`: what is being done; `share` of all that is done, in \[0, 1\].
    pub(crate) fn show(&self, step: &str, share: f64) {
        let message = || {
            let left = self.start.elapsed().mul_f64((1.0 - share) / share.max(1e-3));
            let left = if share > 0.0 { format!(", about {} left", seconds(left)) } else { String::new() };
            format!("{step}{left}")
        };
        if let Some(bar) = &self.bar {
            bar.set_position((STEPS * share) as u64);
            bar.set_message(message());
        } else if let Ok(mut next) = self.next_line.try_lock()
            && Instant::now() >= *next
        {
            eprintln!("{}", message());
            *next = Instant::now() + LINES_EVERY;
        }
    }

    pub(crate) fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
