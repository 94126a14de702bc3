//! Passes of beams.

use super::fields::latest_field_pass;
use super::times::{PassTimes, timed};
use super::{FIELD_SEQUENCE, FITS, PLAIN_SEQUENCE, Renderer};
use crate::eye::EyeTracer;
use crate::eye::straight::Straight;
use crate::film::samples::PassImage;
use crate::gather::{BeamView, View};
use crate::kind::{Kind, Split};
use crate::paths::{PathBeam, PhotonRecord, Record};
use crate::plan::radius::{Radii, RadiusRule};
use crate::settings::Gather;
use crate::surface::{CROWD, Disks, SurfaceMap};
use covbeam::{Beam, BeamMap, FluenceGrid, Kernel};
use glam::Vec3;
use std::time::Instant;

/// How much wider than a pass' own radius spectra may make its kernels, at least. To look a radius up costs as much as two pairs do; where
/// pairs are most of a pass, kernels that are hardly wider do not earn that: plain ones have up to a third of the error at equal time.
const WORTH_LOOKING_UP: f32 = 3.0;

/// Kernel radii of surface photons in beam radii: of caustics, and of light that arrives after scattering, which is smooth.
const CAUSTIC_RADIUS_FACTOR: f32 = 2.0;
const DIFFUSE_RADIUS_FACTOR: f32 = 10.0;

/// Smallest kernel radius of focused light in a pass' own, where filters smooth the noise: guided photons are dense in a caustic, and its borders
/// sharp. Of .25, .5 and 1 the error after 8 CPU-seconds is 1, .66 and 1.8 of a headlight's, 1, 1.35 and 5.7 under a wine glass, 1, 1.0 and 3.5 beside
/// a glass figurine, 1, .72 and .60 under water; after 4, 1, 1.0 and 3.1 under the glass. Without filters it is noise that decides: up to 1.7 times
/// the error where much light came through glass.
const FOCUSED_SHARE: f32 = 0.5;

/// Kernel radius of scattered light in a pass' own, where straight light, whose borders are sharp, has shadow rays and no beams. Of 1, 2 and 3 times
/// the error after 4 s is 1, .68 and .66 in a hall, 1, .72 and .76 among posts, 1, .60 and .48 under leaves, 1, .81 and 1.05 in coloured fog, 1, .64
/// and .64 in a cloud; wider ones leak farther past thin walls.
const SCATTERED_SHARE: f32 = 2.0;

/// Photons that a disk of a caustic holds at least: its own says nothing of how far others are.
const FEWEST: usize = 2;

impl Renderer<'_> {
    pub(super) fn beams(
        &mut self,
        index: u32,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Option<(PassImage, PassTimes)> {
        let mut times = PassTimes::default();
        let numbers = self.scene.settings;
        let adaptive = self.settings.gather == Gather::Adaptive;
        let counts_only = self.radii.as_ref().is_some_and(|radii| radii.rule == RadiusRule::BeamDensity);
        // Planning needs spectra whatever the radii come from.
        let has_spectra = adaptive && (!counts_only || self.surfaces.is_some()) && !self.is_all_behind();

        let (mut record, fields) = self.traced(index, has_spectra, &mut times, cancelled)?;
        let start = Instant::now();
        if has_spectra {
            self.update_grid(index, &fields, cancelled)?;
        }
        record.append(fields);
        if adaptive {
            self.update_radii(index, &record, cancelled)?;
        }
        times.grid = start.elapsed().as_secs_f64();
        self.energy = record.energy;
        let kernel = numbers.schedule.kernel(index, None);
        let start = Instant::now();
        let plans = match has_spectra {
            true => self.plans(index, kernel.error, self.paths, cancelled)?,
            false => Vec::new(),
        };
        times.plan = start.elapsed().as_secs_f64() + std::mem::take(&mut self.pilot);

        let (beams, surfaces) = self.built(index, kernel, record, !plans.is_empty(), &mut times);
        let view = View {
            scene: self.scene,
            fogs: self.tracer.fogs(),
            tracer: self.eye(&surfaces),
            beams: &beams,
            seed: self.settings.seed,
            pass: index,
            plans,
            straight: self.settings.shadow_rays.then(|| self.straight(index)),
            looks: self.looks.as_ref(),
            wants_rest: self.wants_rest(),
            spectra: (has_spectra && self.settings.first_apart).then(|| self.grids.look_up(0)),
        };
        let (image, cost) = view.image(cancelled)?;
        (times.gather, times.pairs) = (cost.seconds, cost.pairs);
        Some((image, times))
    }

    /// The light paths of a pass without light fields and those with some, if it has any.
    fn traced(
        &self,
        index: u32,
        has_spectra: bool,
        times: &mut PassTimes,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Option<(PhotonRecord, PhotonRecord)> {
        let field_photons = self.field_photons();
        let has_fields = has_spectra && latest_field_pass(index) == index;
        let field_record = if has_fields { Record::BeamsAndField } else { Record::Beams };
        let (fields, seconds) = self.trace(FIELD_SEQUENCE, index, field_photons, field_record, cancelled)?;
        times.light_fields = fields.field_time.as_secs_f64();
        times.trace = seconds - times.light_fields;
        let plain_photons = self.paths - field_photons;
        let (record, seconds) = self.trace(PLAIN_SEQUENCE, index, plain_photons, Record::Beams, cancelled)?;
        times.trace += seconds;
        Some((record, fields))
    }

    /// Eye paths.
    ///
    /// - `surfaces`: light that they see there.
    pub(super) fn eye<'s>(&'s self, surfaces: &'s SurfaceMap) -> EyeTracer<'s> {
        EyeTracer {
            scene: self.scene,
            fogs: self.tracer.fogs(),
            starts: self.starts,
            lamps: self.tracer.lamps(),
            surfaces,
            beyond: self.settings.beyond,
            shown: Some(&self.small),
            is_apart: false,
        }
    }

    /// Shadow rays of a pass.
    pub(super) fn straight(&self, index: u32) -> Straight<'_> {
        Straight {
            scene: self.scene,
            fogs: self.tracer.fogs(),
            lamps: self.tracer.lamps(),
            seed: self.settings.seed,
            pass: index,
            near: Some(self.tracer.near()),
        }
    }

    /// Maps of the beams that light paths have left, with the kernels of a pass whose own is `kernel`, and of their photons on surfaces.
    fn built<'k>(
        &'k self,
        index: u32,
        kernel: Kernel<'k>,
        mut record: PhotonRecord,
        is_planned: bool,
        times: &mut PassTimes,
    ) -> (Vec<BeamView<'k>>, SurfaceMap) {
        let numbers = self.scene.settings;
        let adaptive = self.settings.gather == Gather::Adaptive;
        let kernel = |layer| if adaptive { self.kernel(kernel, layer) } else { kernel };
        let start = Instant::now();
        let split = self.split.unwrap_or(Split::TOGETHER);
        let by_kind = adaptive && self.split.is_some();
        let share = if by_kind && is_planned { FOCUSED_SHARE } else { 1.0 };
        let wider = if self.settings.shadow_rays { SCATTERED_SHARE } else { 1.0 };
        // In each layer: all other light, and focused light where its kernel is another.
        let mut beams = vec![[(); 2].map(|()| vec![Vec::new(); self.scene.region_count()]); split.count()];
        let mut next_to_lamps = vec![Vec::new(); self.scene.region_count()];
        for PathBeam { medium, kind, near, beam } in record.beams.drain(..) {
            if self.settings.shadow_rays && kind == Kind::Straight {
                next_to_lamps[medium as usize].extend(first_part(beam, near));
            } else {
                let is_focused = share != wider && kind == Kind::Focused;
                beams[split.of(kind)][usize::from(is_focused)][medium as usize].push(beam);
            }
        }
        let build = |(layer, [others, focused]): (usize, [Vec<Vec<Beam>>; 2])| {
            let plain = kernel(layer);
            [(others, scaled(plain, wider)), (focused, scaled(plain, share))].map(|(beams, kernel)| {
                let seen_through = kernel.min_radius.max(plain.min_radius);
                let maps = self.maps(beams, kernel.max_radius.max(seen_through));
                let behind =
                    Kernel { min_radius: seen_through, max_radius: seen_through, grid: None, ..plain };
                BeamView { layer, maps, kernel, behind, kind: split.last_kind(layer) }
            })
        };
        // A photon's disk shrinks in area as a beam's kernel shrinks in width: r² ~ 1D schedule.
        let area = kernel(0).min_radius / numbers.schedule.radius;
        let radius_on_surfaces = numbers.schedule.radius * area.sqrt();
        let disks = Disks {
            diffuse: DIFFUSE_RADIUS_FACTOR * radius_on_surfaces,
            caustic: CAUSTIC_RADIUS_FACTOR * radius_on_surfaces,
            crowd: by_kind.then(|| crowd(index)),
            within: true,
        };
        let photons = std::mem::take(&mut record.surface);
        times.build = start.elapsed().as_secs_f64();
        let ((mut beams, of_beams), (surfaces, of_photons)) = rayon::join(
            || timed(|| beams.into_iter().enumerate().flat_map(build).collect::<Vec<BeamView>>()),
            || timed(|| SurfaceMap::build(photons, disks)),
        );
        times.build += of_beams + of_photons;
        let start = Instant::now();
        beams.extend(self.next_to_lamps(next_to_lamps, index));
        times.build += start.elapsed().as_secs_f64();
        (beams, surfaces)
    }

    /// Hierarchies over the beams of each medium, for kernels up to a radius.
    fn maps(&self, beams: Vec<Vec<Beam>>, radius: f32) -> Vec<BeamMap> {
        beams
            .into_iter()
            .zip(self.tracer.fogs())
            .map(|(beams, fog)| BeamMap::build(beams, radius, fog))
            .collect()
    }

    /// Straight light next to the lamps; None: no lamp is a point.
    fn next_to_lamps(&self, beams: Vec<Vec<Beam>>, index: u32) -> Option<BeamView<'_>> {
        if beams.iter().all(Vec::is_empty) {
            return None;
        }
        let kernel = self.tracer.near().kernel(self.scene.settings.schedule, index);
        let maps = self.maps(beams, kernel.max_radius);
        let split = self.split.unwrap_or(Split::TOGETHER);
        let (layer, kind) = (split.of(Kind::Straight), Kind::Straight);
        Some(BeamView { layer, maps, kernel, behind: kernel, kind })
    }

    /// Whether all fog lies behind glass, where no filter thins rays out: wide kernels cost more than they are worth there, and spectra are of no
    /// other use. Radii by a rule are as the rule says.
    pub(super) fn is_all_behind(&self) -> bool {
        self.radii.is_none() && !self.sees_fog_first()
    }

    /// The kernel of a layer's beams in a pass whose own is `plain`.
    fn kernel<'k>(&'k self, plain: Kernel<'k>, layer: usize) -> Kernel<'k> {
        let wide_enough = plain.max_radius > WORTH_LOOKING_UP * plain.min_radius;
        let is_wide = wide_enough || self.surfaces.is_none() || self.radii.is_some();
        if !is_wide || self.is_all_behind() {
            return Kernel { max_radius: plain.min_radius, ..plain };
        }
        let rule = self.radii.as_ref();
        let by_rule = |radii: &'k Radii| FluenceGrid::new(self.scene.grid, &radii.cells).expect(FITS);
        Kernel { grid: Some(rule.map_or_else(|| self.grids.look_up(layer), by_rule)), ..plain }
    }
}

/// A kernel with so many times its smallest radius.
fn scaled(kernel: Kernel<'_>, factor: f32) -> Kernel<'_> {
    let is_plain = kernel.max_radius <= kernel.min_radius;
    let min_radius = factor * kernel.min_radius;
    Kernel {
        min_radius,
        max_radius: if is_plain { min_radius } else { kernel.max_radius.max(min_radius) },
        ..kernel
    }
}

/// The part of a beam up to a distance > 0.
fn first_part(beam: Beam, until: f32) -> Option<Beam> {
    let is_whole = beam.length <= until;
    let part = if is_whole { beam } else { Beam { length: until, end_normal: Vec3::ZERO, ..beam } };
    (until > 0.0).then_some(part)
}

/// Photons that a disk of a caustic holds in pass `index`: their number falls as index^(-1/3), since the squared bias of disks that hold k goes
/// as k² and the variance of the mean over so many passes as 1/(k index).
fn crowd(index: u32) -> usize {
    ((CROWD as f32 / libm::cbrtf(index as f32)).round() as usize).max(FEWEST)
}
