//! Boundaries of glass and water on guided paths.

use super::{Branch, Tree};
use crate::color::mean;
use crate::paths::guidance::of_ray;
use crate::paths::record::{PhotonRecord, add};
use crate::paths::transport::Transport;
use crate::scene::optics::Boundary;
use covbeam::weight_window;
use covbeam_geometry::hit::Hit;

impl Tree<'_, '_> {
    /// What is reflected and what goes through, both of them where both are worth it. Neither is less likely
    /// than its share.
    pub(super) fn cross(&mut self, branch: Branch, hit: &Hit, boundary: &Boundary, out: &mut PhotonRecord) {
        let Some(refracted) = boundary.refracted.filter(|_| boundary.reflectance > 0.0) else {
            return self.go_one_way(branch, hit, boundary, out);
        };
        let Branch { photon, mut sampler, depth } = branch;
        let ways = [
            (boundary.reflectance, None, boundary.reflected, photon.interior),
            (1.0 - boundary.reflectance, Some(refracted), refracted, boundary.beyond),
        ];
        let (unit, most) = (self.unit(depth), self.most(hit.position, depth));
        let importance = self.guidance.importance();
        let mut factors = ways.map(|(share, _, direction, interior)| {
            let Transport { scene, ref fogs, .. } = *self.transport;
            let (origin, bounces) = (hit.leave(direction), photon.bounces + 1);
            let worth = of_ray(scene, fogs, &importance, (origin, direction), &interior, bounces);
            let power = share * mean(photon.power);
            let excess = (share * photon.power * most).max_element();
            (power * worth / unit).max(excess).clamp(share, 1.0)
        });
        weight_window(&mut factors, sampler.uniform());
        let branch = sampler.branch();
        // The low-discrepancy numbers are for the larger share.
        let samplers = if boundary.reflectance < 0.5 { [branch, sampler] } else { [sampler, branch] };
        add(&mut out.energy.roulette, photon.power);
        for (((share, through, ..), factor), sampler) in ways.into_iter().zip(factors).zip(samplers) {
            if factor > 0.0 {
                let mut child = photon.clone();
                child.power *= share * factor;
                add(&mut out.energy.roulette, -child.power);
                self.transport.cross(&mut child, hit, boundary, through);
                self.wait(Branch { photon: child, sampler, depth }, out);
            }
        }
    }

    /// All of it goes through, or is held by total reflection.
    fn go_one_way(&mut self, mut branch: Branch, hit: &Hit, boundary: &Boundary, out: &mut PhotonRecord) {
        self.transport.cross(&mut branch.photon, hit, boundary, boundary.refracted);
        match boundary.refracted {
            Some(_) => self.wait(branch, out),
            None => self.follow_if_worth_it(branch, out),
        }
    }
}
