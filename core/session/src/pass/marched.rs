//! Passes of light scattered once.

use super::fields::latest_field_pass;
use super::times::PassTimes;
use super::{FIELD_SEQUENCE, Renderer};
use crate::film::samples::PassImage;
use crate::gather::march::{Guide, Marcher, Placement};
use crate::gather::pixel_offset;
use crate::paths::{PhotonRecord, Record};
use covbeam::error_bound;
use std::time::Instant;

impl Renderer<'_> {
    pub(super) fn march(
        &mut self,
        index: u32,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Option<(PassImage, PassTimes)> {
        let mut times = PassTimes::default();
        let adaptive = self.settings.marching.placement == Placement::Adaptive;
        if adaptive {
            let count = self.field_photons();
            let mut fields = PhotonRecord::default();
            if latest_field_pass(index) == index {
                (fields, times.light_fields) =
                    self.trace(FIELD_SEQUENCE, index, count, Record::Direct, cancelled)?;
            }
            let start = Instant::now();
            self.update_grid(index, &fields, cancelled)?;
            times.grid = start.elapsed().as_secs_f64();
        }
        let scene = self.scene;
        let key = [self.settings.seed, index];
        let start = Instant::now();
        let error = error_bound(scene.settings.schedule.error, index);
        let plan = if adaptive { self.plans(index, error, 0, cancelled)?.pop() } else { None };
        let guide =
            || Guide::new(scene, self.grids.look_up(0), self.settings.marching.samples, key, cancelled);
        let guide = if adaptive { Some(guide()?) } else { None };
        times.plan = start.elapsed().as_secs_f64();
        let marcher = Marcher {
            scene,
            fogs: self.tracer.fogs(),
            starts: self.starts,
            small: &self.small,
            marching: self.settings.marching,
            plan,
            guide: guide.as_ref(),
            key,
            offset: if self.settings.marching.centred {
                [0.5; 2]
            } else {
                pixel_offset(self.settings.seed, index)
            },
            beyond: self.settings.beyond,
            wants_rest: self.wants_rest(),
        };
        let (image, seconds, shadow_rays) = marcher.image(cancelled)?;
        times.shadow_rays = shadow_rays;
        times.gather = seconds;
        Some((image, times))
    }
}
