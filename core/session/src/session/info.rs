//! Where a session stands, and the numbers that its scene has.

use crate::pass::PassTimes;
use covbeam::{GridLayout, Schedule};

/// Where a session stands.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Info {
    /// Passes done.
    pub passes: u32,
    /// Light paths of a pass.
    pub photons: u32,
    /// Those that the settings ask for.
    pub most_photons: u32,
    /// What light and picture are expected to take at most \[bytes\].
    pub memory: u64,
    /// Seconds on the clock that passes have taken, and the getting ready as part of `plan`, shared out by what their parts took of all threads.
    pub times: PassTimes,
    /// Seconds that pictures have taken.
    pub picture: f64,
    /// What the survey has chosen, or the scene said.
    pub chosen: Chosen,
}

/// Numbers that a scene is rendered with: what hosts of the kernel library would choose by hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chosen {
    /// Box and cells of the covariance grid.
    pub grid: GridLayout,
    /// Kernels of the passes.
    pub schedule: Schedule,
    /// Light paths a pass, of those that go where their power goes.
    pub photons: u32,
    /// Light paths a pass, of those that go where the picture needs them.
    pub guided_photons: u32,
}

impl Default for Chosen {
    fn default() -> Self {
        let grid = crate::pilot::defaults::NO_GRID;
        let schedule = crate::pilot::defaults::Given::default().settings.schedule;
        Self { grid, schedule, photons: 0, guided_photons: 0 }
    }
}

impl Info {
    /// Adds a pass that has taken so long on the clock.
    pub(super) fn add(&mut self, pass: &PassTimes, seconds: f64) {
        let scale = seconds / pass.total().max(f64::MIN_POSITIVE);
        self.times += PassTimes {
            trace: scale * pass.trace,
            light_fields: scale * pass.light_fields,
            grid: scale * pass.grid,
            build: scale * pass.build,
            plan: scale * pass.plan,
            gather: scale * pass.gather,
            pairs: pass.pairs,
            shadow_rays: pass.shadow_rays,
        };
    }
}
