//! The machine and the build, as far as they tell; no host name, no paths.

use serde::Serialize;

const UNKNOWN: &str = "unknown";

/// What a reader needs to compare times.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Machine {
    /// Model of the processor.
    pub processor: String,
    /// Cores that the program may use.
    pub cores: usize,
    /// Threads that it used.
    pub threads: usize,
    /// Main memory.
    pub memory: String,
    /// Operating system.
    pub system: String,
    /// Compiler that built the program.
    pub compiler: &'static str,
    /// How it was built.
    pub build: String,
    /// Version of covbeam.
    pub version: &'static str,
}

impl Machine {
    /// This machine; "unknown" where the system does not tell. `threads`: that the report uses.
    pub fn here(threads: usize) -> Self {
        let cores = std::thread::available_parallelism().map_or(threads, usize::from);
        let build = format!("{}, optimisation level {}", env!("COVBEAM_PROFILE"), env!("COVBEAM_OPT_LEVEL"));
        Self {
            processor: value("/proc/cpuinfo", "model name", ':').unwrap_or_else(|| UNKNOWN.to_owned()),
            cores,
            threads,
            memory: main_memory().unwrap_or_else(|| UNKNOWN.to_owned()),
            system: format!("{}, {}", system_name(), std::env::consts::ARCH),
            compiler: env!("COVBEAM_RUSTC"),
            build,
            version: env!("CARGO_PKG_VERSION"),
        }
    }
}

/// What follows `key` and the separator in a file of such lines.
fn value(file: &str, key: &str, separator: char) -> Option<String> {
    let text = std::fs::read_to_string(file).ok()?;
    let found = text.lines().find_map(|line| {
        let (name, value) = line.split_once(separator)?;
        (name.trim() == key).then(|| value.trim().trim_matches('"').to_owned())
    });
    found.filter(|value| !value.is_empty())
}

fn main_memory() -> Option<String> {
    let kibibytes: f64 = value("/proc/meminfo", "MemTotal", ':')?.strip_suffix("kB")?.trim().parse().ok()?;
    Some(format!("{:.1} GiB", kibibytes / f64::from(1 << 20)))
}

fn system_name() -> String {
    value("/etc/os-release", "PRETTY_NAME", '=').unwrap_or_else(|| std::env::consts::OS.to_owned())
}

/// The largest resident set from now on.
pub(super) struct PeakMemory;

impl PeakMemory {
    /// Starts anew; None where the system cannot.
    pub(super) fn watch() -> Option<Self> {
        // "5" resets the peak, see proc(5).
        std::fs::write("/proc/self/clear_refs", "5").ok().map(|()| Self)
    }

    /// So far.
    pub(super) fn bytes(&self) -> Option<u64> {
        covbeam_session::pass::memory::peak()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_peak_of_memory_starts_anew() {
        if !cfg!(target_os = "linux") {
            return;
        }
        const LARGE: usize = 64 << 20;
        let touched: u64 = std::hint::black_box(vec![1_u8; LARGE]).iter().map(|byte| u64::from(*byte)).sum();
        assert_eq!(touched, LARGE as u64);
        let before = PeakMemory::watch().unwrap();
        let low = before.bytes().unwrap();
        // A large allocation is returned to the system when it is dropped; half of it leaves room for other tests.
        std::hint::black_box(vec![1_u8; LARGE]);
        assert!(before.bytes().unwrap() >= low + LARGE as u64 / 2);
        assert!(PeakMemory::watch().unwrap().bytes().unwrap() < low + LARGE as u64 / 2);
    }

    #[test]
    fn what_is_not_known_is_said_to_be_unknown() {
        assert_eq!(value("/proc/no such file", "model name", ':'), None);
        let here = Machine::here(3);
        assert_eq!(here.threads, 3);
        assert!(
            here.cores >= 1 && here.compiler.starts_with("rustc ") && !here.processor.is_empty(),
            "{here:?}"
        );
    }
}
