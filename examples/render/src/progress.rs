//! Progress of a long command: a bar in a terminal, else a line every few seconds; or lines for a program to read.
//!
//! What cannot be said, because nobody listens or the disk that it goes to is full, costs no work.

use indicatif::{ProgressBar, ProgressStyle};
use std::fmt::Display as Show;
use std::io::{IsTerminal, Write, stderr, stdout};
use std::sync::Mutex;
use std::time::{Duration, Instant};

const STEPS: f64 = 1000.0;

/// Whom progress is for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Listener {
    /// A person, on standard error.
    #[default]
    Person,
    /// A program, on standard output: a JSON object a line, with the field `event`.
    Json,
    /// An Open Job Description runner, on standard output: lines `openjd_progress`, `openjd_status` and `openjd_fail`.
    Openjd,
}

impl Listener {
    /// Between two lines.
    fn every(self) -> Duration {
        match self {
            Self::Person => Duration::from_secs(5),
            Self::Json | Self::Openjd => Duration::from_secs(1),
        }
    }

    /// Says that the work failed, and how.
    pub fn failed(self, code: u8, message: &str) {
        match self {
            Self::Person => {}
            Self::Json => {
                tell(format!(
                    "{}\n",
                    serde_json::json!({ "event": "failed", "code": code, "message": message })
                ));
            }
            Self::Openjd => tell(format!("openjd_fail: {}\n", message.replace('\n', " "))),
        }
        say(format!("error: {message}"));
    }

    /// Says that the work is done: `text` for a person, `facts` for a program.
    pub fn done(self, text: &str, facts: serde_json::Value) {
        if self == Self::Openjd {
            tell("openjd_progress: 100\n");
        }
        self.end("done", text, facts);
    }

    /// Says that the work was stopped; the same.
    pub fn stopped(self, text: &str, facts: serde_json::Value) {
        self.end("stopped", text, facts);
    }

    fn end(self, event: &str, text: &str, mut facts: serde_json::Value) {
        match self {
            Self::Person => tell(text),
            Self::Json => {
                facts["event"] = event.into();
                tell(format!("{facts}\n"));
            }
            Self::Openjd => {
                tell(format!("openjd_status: {event}: {}\n", text.lines().next().unwrap_or_default()));
                say(text);
            }
        }
    }
}

/// A line on standard error, if anybody listens.
pub fn say(text: impl Show) {
    // There is nowhere to say that it could not be said.
    drop(writeln!(stderr(), "{text}"));
}

/// A text on standard output, if anybody listens.
pub fn tell(text: impl Show) {
    let mut out = stdout();
    drop(write!(out, "{text}").and_then(|()| out.flush()));
}

/// What is shown, and when.
pub struct Display {
    listener: Listener,
    bar: Option<ProgressBar>,
    start: Instant,
    next_line: Mutex<Instant>,
}

/// Where the work stands.
pub struct Standing<'a> {
    /// What is being done, for a person.
    pub step: &'a str,
    /// Of all that is done, in \[0, 1\]; None: not known.
    pub share: Option<f64>,
    /// Time left; None: not known.
    pub left: Option<Duration>,
    /// More for a program: a JSON object.
    pub facts: serde_json::Value,
}

impl Display {
    /// Starts the clock, for a person who sees the first line after some seconds.
    #[allow(clippy::new_without_default, reason = "a clock that starts is no default")]
    pub fn new() -> Self {
        let display = Self::for_listener(Listener::Person);
        Self { next_line: Mutex::new(Instant::now() + Listener::Person.every()), ..display }
    }

    /// Starts the clock, for a listener who gets the first line at once.
    pub fn for_listener(listener: Listener) -> Self {
        let bar = (listener == Listener::Person && stderr().is_terminal()).then(|| {
            let style = ProgressStyle::with_template("[{bar:30}] {elapsed} {msg}").expect("a valid template");
            let bar = ProgressBar::new(STEPS as u64).with_style(style.progress_chars("=> "));
            bar.enable_steady_tick(Duration::from_millis(200));
            bar
        });
        let start = Instant::now();
        Self { listener, bar, start, next_line: Mutex::new(start) }
    }

    /// `step`: what is being done; `share` of all that is done, in \[0, 1\].
    pub fn show(&self, step: &str, share: f64) {
        let left = (share > 0.0).then(|| self.start.elapsed().mul_f64((1.0 - share) / share.max(1e-3)));
        let text = left.map_or(step.to_owned(), |left| format!("{step}, about {} left", seconds(left)));
        self.show_all(&Standing { step: &text, share: Some(share), left, facts: serde_json::json!({}) });
    }

    /// The same with all that is known.
    pub fn show_all(&self, standing: &Standing) {
        let Standing { step, share, left, facts } = standing;
        if let Some(bar) = &self.bar {
            bar.set_position((STEPS * share.unwrap_or(0.0)) as u64);
            bar.set_message((*step).to_owned());
            return;
        }
        let Ok(mut next) = self.next_line.try_lock() else { return };
        if Instant::now() < *next {
            return;
        }
        *next = Instant::now() + self.listener.every();
        match self.listener {
            Listener::Person => say(step),
            Listener::Json => {
                let mut line = serde_json::json!({ "event": "progress" });
                let known = [("share", *share), ("left", left.map(|left| left.as_secs_f64()))];
                known.iter().for_each(|(name, value)| line[*name] = serde_json::json!(value));
                facts.as_object().into_iter().flatten().for_each(|(name, value)| line[name] = value.clone());
                tell(format!("{line}\n"));
            }
            Listener::Openjd => {
                let progress =
                    share.map_or(String::new(), |share| format!("openjd_progress: {:.1}\n", 100.0 * share));
                tell(format!("{progress}openjd_status: {step}\n"));
            }
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
