//! Passes of a scene that moves: each shows an instant while the shutter is open.

use super::{PassTimes, Renderer};
use crate::film::samples::PassImage;
use crate::plan::FirstSurfaces;
use crate::random::mix;
use crate::scene::Scene;
use crate::settings::Settings;
use std::sync::Arc;

/// Renderers of one scene at several instants, with the same grid and with one pilot for all of them. What moves is blurred by their passes.
pub struct Instants<'a> {
    renderers: Vec<Renderer<'a>>,
    /// The instant whose renderer has the light fields.
    latest: usize,
}

impl<'a> Instants<'a> {
    /// - `scenes`: one an instant, a power of two of them, all with the grid and the numbers of the first
    ///   ([`complete_all`](crate::pilot::defaults::complete_all)).
    /// - `surfaces`: what is first behind each pixel at all instants, where eye rays are planned.
    /// - `cancelled` is polled all the time, and says yes for good once it did; None = it has.
    pub fn new(
        scenes: &'a [Scene],
        settings: Settings,
        surfaces: Option<Arc<FirstSurfaces>>,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Option<Self> {
        Some(Self { renderers: Renderer::of_instants(scenes, settings, surfaces, cancelled)?, latest: 0 })
    }

    /// As [`Renderer::restart`].
    pub fn restart(&mut self, photons: u32) {
        self.renderers.iter_mut().for_each(|renderer| renderer.restart(photons));
    }

    /// As [`Renderer::pass`].
    pub fn pass(
        &mut self,
        index: u32,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Option<(PassImage, PassTimes)> {
        let count = self.renderers.len();
        // Asked for out of order: light fields of earlier passes are those of their own instants.
        while count > 1
            && let Some(earlier) = self.renderers[self.latest].missing_fields(index)
        {
            self.go_to(instant_of(earlier, count)).add_light_fields(cancelled)?;
        }
        self.go_to(instant_of(index, count)).pass(index, cancelled)
    }

    /// The renderer of an instant, which has the light fields from now on.
    fn go_to(&mut self, instant: usize) -> &mut Renderer<'a> {
        let before = std::mem::replace(&mut self.latest, instant);
        // All instants' light fields are in one grid: kernels and filters may blur what the mean of them bears.
        if let Ok([made, before]) = self.renderers.get_disjoint_mut([instant, before]) {
            made.go_on_from(before);
        }
        &mut self.renderers[instant]
    }
}

/// The instant of a pass, of `count`, a power of two. Odd and even passes, which pictures compare, go through the same ones: any 2 `count` passes
/// from a multiple of that on have each twice, and shorter rows are spread evenly, too. Pixels are chosen by the number of a pass as well:
/// so each round has another order, a nested scrambling of the van der Corput sequence (Owen 1995).
fn instant_of(pass: u32, count: usize) -> usize {
    let turn = (pass as usize - 1) / 2;
    let (round, place) = (turn / count, turn % count);
    (0..count.trailing_zeros()).fold(0, |instant, level| {
        let before = place & ((1 << level) - 1);
        let flip = mix((round as u64) << 32 | u64::from(level) << 24 | before as u64) as usize;
        instant << 1 | ((place >> level ^ flip) & 1)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn odd_and_even_passes_go_through_all_instants_evenly_and_in_orders_of_their_own() {
        for count in [1, 2, 8, 16] {
            let rounds = (0..32).map(|round| {
                let passes = (0..count).map(|turn| 1 + 2 * (round * count + turn) as u32);
                let found: Vec<usize> = passes.clone().map(|pass| instant_of(pass, count)).collect();
                assert_eq!(found, passes.map(|pass| instant_of(pass + 1, count)).collect::<Vec<_>>());
                let mut all = found.clone();
                all.sort_unstable();
                assert_eq!(all, (0..count).collect::<Vec<_>>());
                // Two in a row lie in different halves of the time that the shutter is open.
                assert!(
                    found.chunks(2).all(|two| count == 1 || (2 * two[0] < count) != (2 * two[1] < count))
                );
                found
            });
            let orders: std::collections::HashSet<Vec<usize>> = rounds.collect();
            assert!(orders.len() >= count.min(16), "{count}: {orders:?}");
        }
    }
}
