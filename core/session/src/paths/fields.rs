//! Light fields that photons carry, and what they leave in the covariance grid.

use crate::light::EmittedPhoton;
use crate::paths::operators::Operator;
use crate::paths::photon::Photon;
use crate::paths::record::{FieldSegment, PhotonRecord, Record};
use crate::paths::segment::{Inside, PathSegment};
use crate::paths::transport::Transport;
use crate::scene::media;
use covbeam::{Column, CovarianceGrid, Edges, LightField, Medium};
use std::time::Instant;

/// A light field along a segment.
pub(super) struct CarriedField<'s> {
    segment: FieldSegment,
    /// The medium as it acts on it.
    acting: Medium<'s>,
}

impl CarriedField<'_> {
    /// What becomes of it up to a distance.
    #[inline]
    pub(super) fn at(&self, distance: f32, out: &mut PhotonRecord) -> LightField {
        let start = Instant::now();
        let field = self.segment.with(Column::Uniform).field_at(&self.acting, distance);
        out.field_time += start.elapsed();
        field
    }
}

impl Transport<'_> {
    /// The light field of a photon that leaves a light; None: none is recorded.
    pub(super) fn start_field(
        &self,
        light: usize,
        emitted: &EmittedPhoton,
        record: Record,
    ) -> Option<LightField> {
        matches!(record, Record::BeamsAndField | Record::Field | Record::Direct).then(|| {
            match self.acts(Operator::Emission) {
                true => self.scene.lights[light].light_field(emitted),
                false => LightField::point(emitted.direction, 0.0),
            }
        })
    }

    /// A photon's light field along its segment, which is left in the medium there; None: it has none.
    #[inline]
    pub(super) fn carry_field<'s>(
        &self,
        photon: &Photon,
        along: &PathSegment<'s>,
        out: &mut PhotonRecord,
    ) -> Option<CarriedField<'s>> {
        let field = photon.field?;
        let start = Instant::now();
        let segment = self.field_segment(photon, field, along);
        let acting = along.inside.as_ref().map_or(Medium::default(), |inside| self.acting(inside.fog));
        // Where light is inside of glass no grid is looked up.
        let is_looked_up = |inside: &&Inside| inside.scatters && !self.scene.is_in_glass(inside.id);
        let inside = along.inside.as_ref().filter(is_looked_up);
        let lit = inside.and_then(|inside| Some((inside.id, photon.lit_segment(segment, inside, &acting)?)));
        out.deposits.extend(lit);
        out.field_time += start.elapsed();
        Some(CarriedField { segment, acting })
    }

    fn field_segment(&self, photon: &Photon, field: LightField, along: &PathSegment) -> FieldSegment {
        let Photon { origin, direction, .. } = *photon;
        let edges = match self.acts(Operator::Occlusion) {
            true => self.scene.edges_beside(origin, direction, along.hit.as_ref()),
            false => Edges::default(),
        };
        let length = along.inside.as_ref().map_or(along.reach, |inside| along.reach.min(inside.opaque));
        let power = photon.stands_for * photon.power.element_sum() / 3.0;
        let unscattered = photon.specular && self.acts(Operator::Spreading);
        FieldSegment { origin, length, field, power, unscattered, kind: photon.kind(), edges }
    }

    /// Adds deposits to a covariance grid, in their order.
    pub(super) fn deposit_into<'d>(
        &self,
        grid: &mut CovarianceGrid,
        deposits: impl IntoIterator<Item = &'d (u32, FieldSegment)>,
    ) {
        let mut knots = Vec::new();
        for (medium, segment) in deposits {
            let fog = &self.fogs[*medium as usize];
            let FieldSegment { origin, length, ref field, .. } = *segment;
            let column = media::column(fog, origin, field.direction, length, &mut knots);
            grid.deposit(&self.acting(fog), &segment.with(column));
        }
    }
}
