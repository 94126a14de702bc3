//! Being asked to stop by a signal: Ctrl-C, a closed terminal, or whoever ends programs.

use signal_hook::consts::signal::{SIGINT, SIGTERM};
use signal_hook::flag::register_usize;
use std::io;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

#[cfg(unix)]
const SIGNALS: [i32; 3] = [SIGINT, SIGTERM, signal_hook::consts::signal::SIGHUP];
#[cfg(not(unix))]
const SIGNALS: [i32; 2] = [SIGINT, SIGTERM];

/// Which signal came, if any.
pub(crate) struct Stop(Arc<AtomicUsize>);

impl Stop {
    /// From now on these signals are noted and end nothing by themselves, but for those that whoever started the program wants to be ignored,
    /// as `nohup` does.
    pub(crate) fn on_signals() -> io::Result<Self> {
        let latest = Arc::new(AtomicUsize::new(0));
        let ignored = ignored();
        for signal in SIGNALS.into_iter().filter(|signal| ignored & (1 << (signal - 1)) == 0) {
            register_usize(signal, Arc::clone(&latest), signal as usize)?;
        }
        Ok(Self(latest))
    }

    pub(crate) fn is_asked(&self) -> bool {
        self.0.load(Ordering::Relaxed) != 0
    }

    /// What shells report of a program that the signal ended.
    pub(crate) fn exit_code(&self) -> ExitCode {
        ExitCode::from(128 + self.0.load(Ordering::Relaxed) as u8)
    }
}

/// The signals that are ignored, as bits: the first one has the lowest. 0 where the system does not tell.
fn ignored() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0)
}
