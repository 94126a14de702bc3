//! The search for edges beside a ray, by probes that the host casts.

use super::edge::{COVBEAM_MOST_EDGES, covbeam_edge};
use crate::check::{direction, finite_not_negative, positive_or_infinite, unit};
use crate::memory::{Element, Outputs, Slot, field};
use crate::status::{Failure, covbeam_status, covbeam_status::*, fail, run};
use core::ffi::c_void;
use covbeam_core::{ProbeHit, find_edges};

/// Where a probe ray meets a surface, for covbeam_find_edges.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_probe_hit {
    /// Along the probe [m] > 0; infinity where it meets nothing.
    pub distance: f32,
    /// Geometric normal, any length but 0, either side; not looked at where nothing is met.
    pub normal: [f32; 3],
    /// How far off this surface rays start that leave it [m], finite and >= 0: what the host's rays are moved by
    /// so as not to meet it again. A hit nearer than 4096 times that is on the surface which the ray itself left,
    /// and no edge, if the ray starts within twice the offset of the hit's tangent plane.
    pub offset: f32,
}

/// Casts a ray from the origin of the search along direction, 3 floats, unit. It sets hit to where the ray meets
/// the nearest surface that casts shadows; before the call distance is infinity, which is nothing met. Return 0,
/// or anything else to give up.
pub type covbeam_probe = Option<
    unsafe extern "C" fn(user: *mut c_void, direction: *const f32, hit: *mut covbeam_probe_hit) -> i32,
>;

const NOTHING: covbeam_probe_hit =
    covbeam_probe_hit { distance: f32::INFINITY, normal: [0.0; 3], offset: 0.0 };

/// What a host says that a ray meets, if it is sound.
fn probe_hit(e: Element<covbeam_probe_hit>) -> Result<Option<ProbeHit>, Failure> {
    let distance = positive_or_infinite(field!(e, distance))?;
    if distance == f32::INFINITY {
        return Ok(None);
    }
    let normal = direction(field!(e, normal))?;
    Ok(Some(ProbeHit { distance, normal, offset: finite_not_negative(field!(e, offset))? }))
}

/// Edges of occluders beside a ray, from nothing but rays that the host casts: those up to four that mask its
/// light most, for the edges of a covbeam_segment. Where the depth jumps as the ray is tilted there is an edge,
/// whosever surface is on either side; edges of what the ray hits that lie deeper than the hit are moved there.
///
/// @param direction of the ray, unit.
/// @param hit where the ray itself meets a surface; may be NULL: nowhere.
/// @param probe casts a ray from the same origin; called up to 128 times.
/// @param user given to probe.
/// @param edges receives COVBEAM_MOST_EDGES edges, sorted by depth, towards unit and across the ray; those that
///     were not found are 0.
/// @param edge_count receives how many were found.
/// @note 28 probes where there is no edge, about 80 where there are some. The nearest edge is within 20 % on
///     spheres, and in nine of ten cases on figurines and tracery; bars and tips that pass between the probes
///     are missed.
/// @kinds <f:uuu <hit? >edges >word
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_find_edges(
    direction: *const f32,
    hit: *const covbeam_probe_hit,
    probe: covbeam_probe,
    user: *mut c_void,
    edges: *mut covbeam_edge,
    edge_count: *mut u32,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let along = unit(unsafe { Element::read(direction.cast(), "direction") }?)?;
        let hit = match hit.is_null() {
            true => None,
            // SAFETY: by the caller's promise.
            false => probe_hit(unsafe { Element::read(hit, "hit") }?)?,
        };
        let Some(probe) = probe else {
            return Err(fail(COVBEAM_NULL_POINTER, format_args!("probe: NULL")));
        };
        // SAFETY: by the caller's promise.
        let mut edges =
            unsafe { Outputs::new(edges, size_of::<covbeam_edge>(), COVBEAM_MOST_EDGES, "edges") }?;
        let edge_count = Slot::new(edge_count, "edge_count")?;
        let mut failure = None;
        let found = find_edges(along, hit, |towards| {
            if failure.is_some() {
                return None;
            }
            let mut hit = NOTHING;
            // SAFETY: the host promises that it may be called with `user`.
            let returned = unsafe { probe(user, towards.to_array().as_ptr(), &mut hit) };
            let answer = match returned {
                0 => probe_hit(Element::single(hit, "what probe has hit")),
                _ => Err(fail(COVBEAM_CALLBACK_FAILED, format_args!("probe: returned {returned}"))),
            };
            answer.unwrap_or_else(|error| {
                failure = Some(error);
                None
            })
        });
        if let Some(failure) = failure {
            return Err(failure);
        }
        for i in 0..COVBEAM_MOST_EDGES {
            edges.set(i, found.get(i).copied().unwrap_or_default().into());
        }
        edge_count.set(found.len() as u32);
        Ok(())
    })
}

#[cfg(test)]
#[allow(clippy::undocumented_unsafe_blocks, reason = "every argument is a local, or refused")]
mod tests {
    use super::*;
    use crate::hostile::{Rule::*, UNTOUCHED, refuses};
    use core::ptr;
    use glam::Vec3;

    /// A sheet at depth 1 that masks x > 0.1, and a wall at depth 3; `user` is the answer to the call that it counts down to.
    unsafe extern "C" fn sheet(user: *mut c_void, direction: *const f32, hit: *mut covbeam_probe_hit) -> i32 {
        let [x, y, z] = unsafe { direction.cast::<[f32; 3]>().read() };
        assert!((x * x + y * y + z * z - 1.0).abs() < 1e-5);
        let depth = if x / z > 0.1 { 1.0 } else { 3.0 };
        unsafe {
            assert_eq!(hit.read(), NOTHING);
            hit.write(covbeam_probe_hit {
                distance: depth / z.abs(),
                normal: [0.0, 0.0, -2.0],
                offset: 1e-6,
            });
            let Some(answer) = user.cast::<Answer>().as_mut() else { return 0 };
            answer.calls += 1;
            if answer.calls == answer.at {
                if let Some(bad) = answer.hit {
                    hit.write(bad);
                }
                return answer.returned;
            }
            assert!(answer.calls < answer.at, "asked again after it gave up");
        }
        0
    }

    struct Answer {
        calls: u32,
        at: u32,
        hit: Option<covbeam_probe_hit>,
        returned: i32,
    }

    const WALL: covbeam_probe_hit =
        covbeam_probe_hit { distance: 3.0, normal: [0.0, 0.0, -1.0], offset: 0.0 };
    const NONE: covbeam_edge =
        covbeam_edge { depth: UNTOUCHED, distance: UNTOUCHED, towards: [UNTOUCHED; 3] };
    const Z: [f32; 3] = [0.0, 0.0, 1.0];

    #[test]
    fn the_edges_are_the_bits_of_the_core() {
        let (mut edges, mut count) = ([NONE; COVBEAM_MOST_EDGES], 77);
        let status = unsafe {
            covbeam_find_edges(
                Z.as_ptr(),
                &WALL,
                Some(sheet),
                ptr::null_mut(),
                edges.as_mut_ptr(),
                &mut count,
            )
        };
        let hit = ProbeHit { distance: 3.0, normal: Vec3::NEG_Z, offset: 0.0 };
        let expected = find_edges(Vec3::Z, Some(hit), |towards| {
            let depth = if towards.x / towards.z > 0.1 { 1.0 } else { 3.0 };
            Some(ProbeHit { distance: depth / towards.z, normal: -2.0 * Vec3::Z, offset: 1e-6 })
        });
        assert_eq!((status, count), (COVBEAM_OK, 1));
        assert_eq!(edges[0], expected[0].into());
        assert!((edges[0].depth - 1.0).abs() < 0.03 && (edges[0].distance - 0.1).abs() < 0.003);
        let empty = covbeam_edge { depth: 0.0, distance: 0.0, towards: [0.0; 3] };
        assert_eq!(edges[1..], [empty; 3]);
    }

    #[test]
    fn a_bad_argument_is_refused_and_nothing_is_written() {
        let numbers = [
            (0.0, Across),
            (0.0, Across),
            (1.0, Along),
            (3.0, PositiveOrInfinite),
            (0.25, Finite),
            (0.0, Finite),
            (-1.0, Finite),
            (1e-6, FiniteNotNegative),
        ];
        refuses(3, &numbers, |bad, n| {
            let hit = covbeam_probe_hit { distance: n[3], normal: [n[4], n[5], n[6]], offset: n[7] };
            let (mut edges, mut count) = ([NONE; COVBEAM_MOST_EDGES], 77);
            let status = unsafe {
                let (to, found) = (bad.at_mut(1, edges.as_mut_ptr()), bad.at_mut(2, &mut count));
                covbeam_find_edges(bad.at(0, n[..3].as_ptr()), &hit, Some(sheet), ptr::null_mut(), to, found)
            };
            (status, count != 77 || edges != [NONE; COVBEAM_MOST_EDGES])
        });
        let (mut edges, mut count) = ([NONE; COVBEAM_MOST_EDGES], 77);
        let status = unsafe {
            covbeam_find_edges(Z.as_ptr(), &WALL, None, ptr::null_mut(), edges.as_mut_ptr(), &mut count)
        };
        assert_eq!((status, count, edges), (COVBEAM_NULL_POINTER, 77, [NONE; COVBEAM_MOST_EDGES]));
    }

    #[test]
    fn a_probe_that_gives_up_or_answers_nonsense_ends_the_search() {
        let bad =
            |distance: f32, normal: [f32; 3], offset: f32| covbeam_probe_hit { distance, normal, offset };
        let nonsense = [
            bad(f32::NAN, Z, 0.0),
            bad(0.0, Z, 0.0),
            bad(-1.0, Z, 0.0),
            bad(1.0, [0.0; 3], 0.0),
            bad(1.0, [f32::NAN; 3], 0.0),
            bad(1.0, Z, -1.0),
            bad(1.0, Z, f32::INFINITY),
        ];
        let answers = nonsense.into_iter().map(|hit| (Some(hit), 0, COVBEAM_INVALID_VALUE)).chain([(
            None,
            -3,
            COVBEAM_CALLBACK_FAILED,
        )]);
        for (hit, returned, expected) in answers {
            for at in [1, 2, 30] {
                let mut answer = Answer { calls: 0, at, hit, returned };
                let (mut edges, mut count) = ([NONE; COVBEAM_MOST_EDGES], 77);
                let status = unsafe {
                    let user = (&raw mut answer).cast();
                    covbeam_find_edges(
                        Z.as_ptr(),
                        ptr::null(),
                        Some(sheet),
                        user,
                        edges.as_mut_ptr(),
                        &mut count,
                    )
                };
                assert_eq!((status, count, answer.calls), (expected, 77, at));
                assert_eq!(edges, [NONE; COVBEAM_MOST_EDGES]);
            }
        }
    }
}
