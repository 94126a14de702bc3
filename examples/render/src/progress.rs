//! Progress of a long command on standard error: a bar in a terminal, else a line every few seconds.

use indicatif::{ProgressBar, ProgressStyle};
use std::io::{IsTerminal, stderr};
use std::sync::Mutex;
use std::time::{Duration, Instant};

const LINES_EVERY: Duration = Duration::from_secs(5);
const STEPS: f64 = 1000.0;

/// What is shown, and when.
pub struct Display {
    bar: Option<ProgressBar>,
    start: Instant,
    next_line: Mutex<Instant>,
}

impl Display {
    /// Starts the clock.
    #[allow(clippy::new_without_default, reason = "a clock that starts is no default")]
    pub fn new() -> Self {
        let bar = stderr().is_terminal().then(|| {
            let style = ProgressStyle::with_template("[{bar:30}] {elapsed} {msg}").expect("a valid template");
            let bar = ProgressBar::new(STEPS as u64).with_style(style.progress_chars("=> "));
            bar.enable_steady_tick(Duration::from_millis(200));
            bar
        });
        Self { bar, start: Instant::now(), next_line: Mutex::new(Instant::now() + LINES_EVERY) }
    }

    /// `step`: what is being done; `share` of all that is done, in \[0, 1\].
    pub fn show(&self, step: &str, share: f64) {
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

    /// Takes the bar off the terminal.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

/// A time in the unit that fits.
pub fn seconds(time: Duration) -> String {
    let all = time.as_secs_f64();
    match all {
        ..60.0 => format!("{all:.1} s"),
        60.0..3600.0 => format!("{} min {:02} s", time.as_secs() / 60, time.as_secs() % 60),
        _ => format!("{} h {:02} min", time.as_secs() / 3600, time.as_secs() / 60 % 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_is_shown_in_the_unit_that_fits() {
        assert_eq!(seconds(Duration::from_millis(1540)), "1.5 s");
        assert_eq!(seconds(Duration::from_secs(61)), "1 min 01 s");
        assert_eq!(seconds(Duration::from_secs(2 * 3600 + 5 * 60 + 59)), "2 h 05 min");
    }
}
