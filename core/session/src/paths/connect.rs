//! Connections of light paths with the pinhole camera: light tracing.

use crate::paths::photon::Photon;
use crate::paths::record::{PhotonRecord, Splat};
use crate::paths::segment::PathSegment;
use crate::paths::transport::Transport;
use crate::random::PathSampler;
use crate::scene::passage::{Looks, passage};
use crate::surface::encounter::Encounter;
use covbeam_geometry::hit::Hit;
use glam::Vec3;
use std::f32::consts::FRAC_1_PI;

/// Of light that goes evenly all around, what goes into a steradian.
const EVENLY: f32 = 0.25 * FRAC_1_PI;

impl Transport<'_> {
    /// Connects where a path starts, if its light counts as scattered from there on.
    pub(super) fn connect_start(&self, photon: &Photon, out: &mut PhotonRecord) {
        if !photon.direct {
            self.connect(photon.origin, out, |_| EVENLY * photon.power);
        }
    }

    /// Connects one point of a segment.
    ///
    /// The point is drawn in proportion to 1/d² (equi-angular sampling, C. Kulla and M. Fajardo 2012), d its
    /// distance from the camera. Connecting the path's own vertices would be unbiased as well, but with
    /// infinite variance: a mean of them leaves out the light that scatters nearer to the camera than the
    /// nearest vertex.
    pub(super) fn connect_segment(
        &self,
        photon: &Photon,
        along: &PathSegment,
        sampler: &mut PathSampler,
        out: &mut PhotonRecord,
    ) {
        let Some(inside) = along.inside.as_ref().filter(|inside| inside.scatters) else { return };
        let fog = inside.fog;
        let reach = along.reach.min(photon.until);
        let u = sampler.uniform();
        let direction = photon.direction;
        let offset = self.scene.camera.position - photon.origin;
        let foot = offset.dot(direction);
        let distance = (offset - foot * direction).length();
        if !(distance > 0.0) {
            return;
        }
        let dark = photon.dark.min(reach);
        let (from, to) = (libm::atanf((dark - foot) / distance), libm::atanf((reach - foot) / distance));
        let s = (foot + distance * libm::tanf(from + u * (to - from))).clamp(dark, reach);
        let density = distance / ((to - from) * (distance * distance + (s - foot) * (s - foot)));
        if !(s.is_finite() && density > 0.0) {
            return;
        }
        let point = photon.origin + s * direction;
        let scattering = fog.scattering * fog.density.at(point);
        let scattered = photon.faded(s) * photon.power * inside.lit(s) * scattering / density;
        self.connect(point, out, |to_camera| scattered * fog.phases(direction.dot(to_camera)));
    }

    /// Connects light that a diffuse surface has reflected.
    pub(super) fn connect_diffuse(&self, photon: &Photon, hit: &Hit, normal: Vec3, out: &mut PhotonRecord) {
        if photon.is_seen_on_surfaces(self.scene) {
            let factor = photon.power * (photon.faded(hit.distance) * FRAC_1_PI);
            self.connect(hit.leave(normal), out, |to_camera| factor * to_camera.dot(normal).max(0.0));
        }
    }

    /// Connects light that arrives on a surface of lobes, on either side of it.
    pub(super) fn connect_lobes(&self, photon: &Photon, hit: &Hit, met: &Encounter, out: &mut PhotonRecord) {
        if photon.is_seen_on_surfaces(self.scene) {
            let from = hit.leave(self.scene.camera.position - hit.position);
            self.connect(from, out, |to_camera| {
                photon.faded(hit.distance)
                    * photon.power
                    * met.towards(to_camera)
                    * to_camera.dot(met.normal).abs()
            });
        }
    }

    /// Connects a vertex; `flux` gives the flux per steradian towards the camera.
    fn connect(&self, vertex: Vec3, out: &mut PhotonRecord, flux: impl FnOnce(Vec3) -> Vec3) {
        let camera = &self.scene.camera;
        let Some((x, y, importance)) = camera.project(vertex) else { return };
        let offset = camera.position - vertex;
        let distance2 = offset.length_squared();
        let distance = distance2.sqrt();
        let (eye, interior) = self.camera.towards(self.scene, -offset);
        let arrives = passage(self.scene, &self.fogs, interior, [eye, vertex], Looks::Camera);
        if arrives == Vec3::ZERO {
            return;
        }
        let radiance = flux(offset / distance) * arrives * (importance / distance2);
        out.splats.push(Splat { pixel: y as u32 * camera.width + x as u32, radiance });
    }
}
