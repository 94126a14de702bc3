//! How far the photons nearest to a photon are.

use super::photon::{SurfacePhoton, hierarchy};
use crate::surface::clearance::FLAT;
use glam::Vec3A;
use obvhs::bvh2::Bvh2;
use rayon::prelude::*;
use smallvec::SmallVec;

/// Most photons that a ball may be asked to hold.
pub(crate) const CROWD: usize = 16;

/// Least radius of a ball in the widest.
pub(crate) const NARROWEST: f32 = 0.1;

/// Of each photon, in order: the radius \[m\] of the ball around it that holds `crowd` of those on its side of the surface, itself included;
/// from [`NARROWEST`] of `widest` to `widest`.
///
/// - `crowd`: 1 to [`CROWD`].
///
/// Cost: about as that of a ray a photon, however dense they are.
pub(crate) fn radii(photons: &[&SurfacePhoton], crowd: usize, widest: f32) -> Vec<f32> {
    if photons.is_empty() {
        return Vec::new();
    }
    let hierarchy = hierarchy(photons.iter().map(|photon| (photon.position, 0.0)));
    let radius = |photon: &&SurfacePhoton| {
        let nearest = nearest(photons, &hierarchy, photon, crowd, widest * widest);
        let end = nearest.get(crowd - 1).map_or(widest, |distance2| distance2.sqrt());
        end.clamp(NARROWEST * widest, widest)
    };
    photons.par_iter().map(radius).collect()
}

/// Squared distances of up to `count` photons nearer than `bound`, the nearest first.
fn nearest(
    photons: &[&SurfacePhoton],
    hierarchy: &Bvh2,
    photon: &SurfacePhoton,
    count: usize,
    mut bound: f32,
) -> SmallVec<[f32; CROWD]> {
    let place = Vec3A::from(photon.position);
    let distance2 = |node: u32| {
        let around = hierarchy.nodes[node as usize].aabb();
        place.distance_squared(place.clamp(around.min, around.max))
    };
    let mut found = SmallVec::new();
    let mut waiting = SmallVec::<[u32; 64]>::from_slice(&[0]);
    while let Some(index) = waiting.pop() {
        if distance2(index) >= bound {
            continue;
        }
        let node = &hierarchy.nodes[index as usize];
        if !node.is_leaf() {
            let [left, right] = [node.first_index, node.first_index + 1];
            let left_is_nearer = distance2(left) < distance2(right);
            waiting.extend(if left_is_nearer { [right, left] } else { [left, right] });
            continue;
        }
        let first = node.first_index as usize;
        for &other in &hierarchy.primitive_indices[first..first + node.prim_count as usize] {
            let other = photons[other as usize];
            let distance2 = other.position.distance_squared(photon.position);
            if distance2 < bound && other.normal.dot(photon.normal) > FLAT {
                let at = found.partition_point(|nearer| *nearer <= distance2);
                found.truncate(count - 1);
                found.insert(at, distance2);
                if found.len() == count {
                    bound = found[count - 1];
                }
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use glam::Vec3;

    fn at(position: Vec3) -> SurfacePhoton {
        SurfacePhoton { position, normal: Vec3::Y, power: Vec3::ONE, caustic: true }
    }

    #[test]
    fn balls_hold_as_many_as_all_photons_say() {
        const PHOTONS: u32 = 700;
        const WIDEST: f32 = 0.2;
        // Half of them in a hundredth of the square; some back to back with the others.
        let photons: Vec<SurfacePhoton> = (0..PHOTONS)
            .map(|index| {
                let mut random = Random::new([index, 3, 0, 0]);
                let scale = if index % 2 == 0 { 0.1 } else { 1.0 };
                let position = scale * Vec3::new(random.uniform(), 0.0, random.uniform());
                let normal = if index % 5 == 0 { -Vec3::Y } else { Vec3::Y };
                SurfacePhoton { normal, ..at(position) }
            })
            .collect();
        let photons: Vec<&SurfacePhoton> = photons.iter().collect();
        for crowd in [1, 2, 7, CROWD] {
            let found = radii(&photons, crowd, WIDEST);
            for (photon, radius) in photons.iter().zip(found) {
                let mut distances: Vec<f32> = photons
                    .iter()
                    .filter(|other| other.normal == photon.normal)
                    .map(|other| other.position.distance(photon.position))
                    .collect();
                distances.sort_by(f32::total_cmp);
                let expected = distances[crowd - 1].clamp(NARROWEST * WIDEST, WIDEST);
                assert!((radius - expected).abs() < 1e-6, "{radius} for {expected}, {crowd} photons");
            }
        }
    }

    #[test]
    fn photons_in_one_place_and_lonely_ones() {
        let many = vec![at(Vec3::ONE); 1000];
        let photons: Vec<&SurfacePhoton> = many.iter().collect();
        assert_eq!(radii(&photons, 5, 2.0), vec![NARROWEST * 2.0; 1000]);
        let [one, other] = [at(Vec3::ZERO), at(Vec3::X)];
        assert_eq!(radii(&[&one, &other], 3, 2.0), [2.0, 2.0]);
        assert!(radii(&[], 3, 2.0).is_empty());
    }
}
