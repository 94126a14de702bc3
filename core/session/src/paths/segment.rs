//! Segments of light paths: up to the next surface, through the medium before it.

use crate::paths::photon::Photon;
use crate::paths::record::{PhotonRecord, add};
use crate::paths::transport::Transport;
use crate::scene::media;
use covbeam::{Column, Knot, Medium};
use covbeam_geometry::hit::Hit;

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
            Inside { id, fog, column, opaque }
        });
        PathSegment { hit, reach, inside }
    }
}
