//! Asks the host at even intervals of counted work whether to go on.

/// Work between two questions: about a millisecond.
const INTERVAL: u32 = 1_000_000;

/// Elements that a loop over a long array handles between two calls of [`Poll::spend`].
pub(super) const STRETCH: usize = 1 << 12;

/// Why a [`super::BeamMap`] was not built, or not gathered to the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// The host said no.
    Cancelled,
    /// Memory could not be had.
    OutOfMemory {
        /// How much was wanted.
        bytes: usize,
    },
    /// More than [`super::MAX_BEAMS`] beams.
    TooMany,
    /// The map was built in another medium.
    OtherMedium,
}

impl core::fmt::Display for Stop {
    fn fmt(&self, f: &mut core::fmt::Formatter) -> core::fmt::Result {
        match self {
            Stop::Cancelled => f.write_str("cancelled"),
            Stop::OutOfMemory { bytes } => write!(f, "out of memory: {bytes} bytes were wanted"),
            Stop::TooMany => f.write_str("too many beams for one map"),
            Stop::OtherMedium => f.write_str("the map was built in another medium"),
        }
    }
}

impl core::error::Error for Stop {}

/// Counts work and asks the host whether to go on: when it is made, and after each [`INTERVAL`].
pub(super) struct Poll<'a> {
    left: u32,
    go_on: &'a mut dyn FnMut() -> bool,
}

impl<'a> Poll<'a> {
    pub(super) fn new(go_on: &'a mut dyn FnMut() -> bool) -> Result<Self, Stop> {
        let mut poll = Self { left: 0, go_on };
        poll.ask()?;
        Ok(poll)
    }

    /// Notes `times` bits of work of about `nanoseconds` each.
    #[inline]
    pub(super) fn spend(&mut self, times: usize, nanoseconds: usize) -> Result<(), Stop> {
        let work = times * nanoseconds;
        if work < self.left as usize {
            self.left -= work as u32;
            return Ok(());
        }
        self.ask()
    }

    #[cold]
    fn ask(&mut self) -> Result<(), Stop> {
        self.left = INTERVAL;
        if (self.go_on)() { Ok(()) } else { Err(Stop::Cancelled) }
    }
}
