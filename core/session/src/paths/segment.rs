//! Segments of light paths: up to the next surface, through the medium before it.

use crate::paths::photon::Photon;
use crate::paths::record::{PhotonRecord, add};
use crate::paths::transport::Transport;
use crate::scene::media;
use covbeam::{Column, Knot, Medium};
use covbeam_geometry::hit::Hit;
use glam::Vec3;

/// Optical depth of a piece of a beam whose light is not dimmed.
const PIECE: f32 = 0.4;

/// A segment of a light path.
pub(super) struct PathSegment<'s> {
    /// Where it ends; None: nowhere.
    pub(super) hit: Option<Hit>,
    /// How far that is.
    pub(super) reach: f32,
    /// None: it is in a vacuum.
    pub(super) inside: Option<Inside<'s>>,
}

/// The medium of a segment.
pub(super) struct Inside<'s> {
    /// The region.
    pub(super) id: u32,
    pub(super) fog: &'s Medium<'s>,
    /// Along the segment.
    pub(super) column: Column<'s>,
    /// Where nothing is left of light, as [`media::opaque_distance`] has it.
    pub(super) opaque: f32,
    /// Whether any of the photon's light is scattered in it, or all that is lost is lost.
    pub(super) scatters: bool,
    /// What of it is lost on the way.
    pub(super) loss: Loss,
}

impl PathSegment<'_> {
    /// What a photon meets at the end; None: it leaves the scene, or its light ends before.
    #[inline]
    pub(super) fn met(&self, photon: &Photon, out: &mut PhotonRecord) -> Option<&Hit> {
        let hit = self.hit.as_ref().filter(|hit| hit.distance < photon.until);
        if hit.is_none() {
            add(&mut out.energy.escaped, photon.power);
        }
        hit
    }
}

/// What a medium takes of light.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Loss {
    /// What it scatters and absorbs.
    All,
    /// Nothing, and scatters it all the same: shadow rays do not see it.
    None,
    /// That of what it scatters, as if it began at the lamp; nothing of what goes on: shadow rays that start in it never leave it, and others never
    /// enter it. This is what is left where the segment starts.
    Inside(Vec3),
}

impl Inside<'_> {
    /// Whether it takes anything of what goes on.
    #[inline]
    pub(super) fn dims(&self) -> bool {
        self.loss == Loss::All
    }

    /// What goes on after a distance.
    #[inline]
    pub(super) fn left(&self, distance: f32) -> Vec3 {
        if self.dims() { self.fog.transmittance(self.column.at(distance)) } else { Vec3::ONE }
    }

    /// What may be scattered there.
    #[inline]
    pub(super) fn lit(&self, distance: f32) -> Vec3 {
        match self.loss {
            Loss::All => self.fog.transmittance(self.column.at(distance)),
            Loss::None => Vec3::ONE,
            Loss::Inside(before) => before * self.fog.transmittance(self.column.at(distance)),
        }
    }

    /// Pieces of a stretch on which nothing of the light is lost, and factors on beams there, which lose what they do: with shifts at random their
    /// mean is all of the light everywhere.
    ///
    /// - `shift`: uniform.
    pub(super) fn pieces(&self, [from, to]: [f32; 2], shift: f32, mut each: impl FnMut([f32; 2], Vec3)) {
        let extinction = self.fog.extinction();
        let step = PIECE / extinction.max_element().max(f32::MIN_POSITIVE);
        let lost = extinction * step;
        let factor = Vec3::select(
            lost.cmpgt(Vec3::splat(1e-4)),
            lost / lost.map(|lost| -libm::expm1f(-lost)).max(Vec3::splat(f32::MIN_POSITIVE)),
            Vec3::ONE,
        );
        let [first, last] = [from, to].map(|end| self.column.at(end));
        let (mut start, mut next) = (from, first + shift * step);
        // The first one began before.
        let mut kept = factor * self.fog.transmittance((1.0 - shift) * step);
        while next < last {
            let end = self.column.distance_at(next).clamp(start, to);
            each([start, end], kept);
            (start, next, kept) = (end, next + step, factor);
        }
        each([start, to], kept);
    }
}

impl Transport<'_> {
    /// The segment that a photon starts. `knots` is memory for its column.
    #[inline]
    pub(super) fn segment<'s>(&'s self, photon: &Photon, knots: &'s mut Vec<Knot>) -> PathSegment<'s> {
        let Photon { origin, direction, ref interior, .. } = *photon;
        let hit = self.scene.intersect(origin, direction, f32::INFINITY);
        let reach = hit.map_or(f32::INFINITY, |hit| hit.distance);
        let inside = interior.medium(self.scene).map(|id| {
            let fog = &self.fogs[id as usize];
            let column = media::column(fog, origin, direction, reach, knots);
            let opaque = media::opaque_distance(fog, origin, direction, &column);
            let scatters = self.is_scattered_in(photon, id);
            let loss = self.loss_in(photon, id, reach.min(photon.until));
            let opaque = if loss == Loss::None { f32::INFINITY } else { opaque };
            Inside { id, fog, column, opaque, scatters, loss }
        });
        PathSegment { hit, reach, inside }
    }
}
