//! The gather of pairs, for hosts with a hierarchy of their own.

use crate::arrays::each;
use crate::beam::{beam, covbeam_beam};
use crate::check::not_negative;
use crate::eye_ray::{covbeam_eye_ray, covbeam_gathered, gathered, read_ray};
use crate::grid::handle::covbeam_grid;
use crate::kernel::options::{covbeam_kernel, read_kernel};
use crate::medium::column::{column, covbeam_column};
use crate::medium::options::{covbeam_medium, read_medium};
use crate::memory::{Element, Inputs, Slot, inputs, outputs};
use crate::status::{Failure, covbeam_status, covbeam_status::*, fail, run};
use covbeam_core::{Column, Density, Gathered, Medium, PLACES, gather_pair};
use glam::Vec3;

/// Columns along rays: the host's, or without them those of closed forms.
struct Columns<'a> {
    given: Option<Inputs<'a, covbeam_column>>,
    name: &'a str,
}

impl<'a> Columns<'a> {
    /// # Safety
    /// NULL, or readable while this lives, and their knots too.
    unsafe fn new(
        first: *const covbeam_column,
        stride: usize,
        count: usize,
        name: &'a str,
    ) -> Result<Self, Failure> {
        // SAFETY: by this function's contract.
        Ok(Self { given: unsafe { Inputs::optional(first, stride, count, name) }?, name })
    }

    fn along(
        &self,
        index: usize,
        medium: &Medium,
        origin: Vec3,
        direction: Vec3,
    ) -> Result<Column<'a>, Failure> {
        let Self { given, name } = self;
        if let Some(given) = given {
            // SAFETY: by the contract of `new`.
            return unsafe { column(given.get(index)) };
        }
        if let Density::Grid(_) = medium.density {
            let message = format_args!(
                "{name}: NULL, but voxels have no closed form; make one by covbeam_medium_column"
            );
            return Err(fail(COVBEAM_NULL_POINTER, message));
        }
        Ok(medium.density.column(origin, direction, &[]))
    }
}

/// What an eye ray has gathered so far, with room to count the pairs of `count` more beams.
fn so_far(e: Element<covbeam_gathered>, count: usize) -> Result<Gathered, Failure> {
    let sum = gathered(e)?;
    let most = count.checked_mul(PLACES).and_then(|most| u32::try_from(most).ok());
    if most.and_then(|most| sum.pairs.checked_add(most)).is_none() {
        let message = format_args!("gathered: {} pairs, no room to count {count} x {PLACES} more", sum.pairs);
        return Err(fail(COVBEAM_INVALID_VALUE, message));
    }
    Ok(sum)
}

/// Gathers one beam, and adds it to what the eye ray has gathered: scattering x phase function x transmittance
/// along both x flux of the beam x kernel(gap) / sin(angle), if the gap is less than the kernel's radius,
/// looked up on the eye ray. Where that sine is below .05 it is the integral along the eye ray of a kernel on
/// both axes across the beam, finite down to parallel pairs, from eight places.
///
/// @param ray the eye ray.
/// @param count number of beams; with 0 nothing is done.
/// @param beams, beam_stride the beam, in the same medium.
/// @param froms, from_stride, tos, to_stride part of the beam that counts [m] >= 0, [from, to): 0 and the
///     beam's length, or more, for all of it. Cutting a beam into adjoining parts changes nothing.
/// @param medium that both lie in.
/// @param ray_column along the ray; NULL takes the closed form (voxels have none: COVBEAM_NULL_POINTER).
/// @param beam_columns, beam_column_stride along the beams; NULL likewise, for all of them.
/// @param kernel the kernel of the pass.
/// @param grid as in covbeam_kernel_radius_at.
/// @param gathered in and out, one for all beams, added in their order: finite numbers, all 0 to begin with.
///     Its pairs need room for eight a beam.
/// @param accepted, accepted_stride 1 if the pair counts, else 0.
/// @note Thesis 5.3.4. A beam that starts or ends on a surface is cut by its tangent plane. The order of the
///     columns' knots is not checked.
/// @kinds <ray <beam <f:p <f:p <medium <column? <column? <kernel @grid.resolved? =gathered >flag
/// @single covbeam_gather_pair
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_gather_pairs(
    ray: *const covbeam_eye_ray,
    count: usize,
    beams: *const covbeam_beam,
    beam_stride: usize,
    froms: *const f32,
    from_stride: usize,
    tos: *const f32,
    to_stride: usize,
    medium: *const covbeam_medium,
    ray_column: *const covbeam_column,
    beam_columns: *const covbeam_column,
    beam_column_stride: usize,
    kernel: *const covbeam_kernel,
    grid: *const covbeam_grid,
    gathered: *mut covbeam_gathered,
    accepted: *mut u8,
    accepted_stride: usize,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let ray = unsafe { read_ray(ray) }?;
        inputs!(count, beams, beam_stride);
        inputs!(count, froms, from_stride);
        inputs!(count, tos, to_stride);
        // SAFETY: by the caller's promise.
        let medium = unsafe { read_medium(medium, "medium") }?;
        // SAFETY: by the caller's promise.
        let kernel = unsafe { read_kernel(kernel, grid) }?;
        // SAFETY: by the caller's promise.
        let mut sum = so_far(unsafe { Element::read(gathered, "gathered") }?, count)?;
        let out = Slot::new(gathered, "gathered")?;
        outputs!(count, accepted, accepted_stride);
        // SAFETY: by the caller's promise.
        let ray_columns = unsafe { Columns::new(ray_column, 0, 1, "ray_column") }?;
        let ray_column = ray_columns.along(0, &medium, ray.origin, ray.direction)?;
        // SAFETY: by the caller's promise.
        let columns = unsafe { Columns::new(beam_columns, beam_column_stride, count, "beam_columns") }?;
        let arguments = |i| {
            let beam = beam(beams.get(i))?;
            let column = columns.along(i, &medium, beam.origin, beam.direction)?;
            Ok((beam, [not_negative(froms.get(i))?, not_negative(tos.get(i))?], column))
        };
        each(count, arguments, |i, (beam, part, column)| {
            let found = gather_pair(&ray, &beam, part, &medium, &[ray_column, column], &kernel, &mut sum);
            accepted.set(i, u8::from(found));
        })?;
        out.set(sum.into());
        Ok(())
    })
}
