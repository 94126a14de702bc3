//! Straight ways through the scene: what is left of light between two points, what a way crosses, and which surfaces only bound media.

use crate::object::geometry::Shading;
use crate::object::placed::hair;
use crate::scene::geometry::MOST_BOUNDS;
use crate::scene::media;
use crate::scene::optics::{Boundary, Interior};
use crate::scene::{Links, Material, Placed, PlacedObject, Rays, Scene};
use covbeam::Medium;
use covbeam_geometry::hit::Hit;
use glam::Vec3;

/// What a ray is inside of behind a surface that does nothing but bound media, through which all light goes straight on; None: another one.
///
/// - `ray`: its kind; what is hidden from it does nothing else.
pub(crate) fn clear(
    scene: &Scene,
    hit: &Hit,
    direction: Vec3,
    interior: &Interior,
    ray: Rays,
) -> Option<Interior> {
    if scene.object_of(hit).heed.hidden.has(ray) {
        return Some(interior.beyond(scene, hit, direction));
    }
    match *scene.material_at(hit) {
        Material::Dielectric { .. } => {
            let boundary = Boundary::new(scene, hit, direction, interior);
            boundary.is_matched().then_some(boundary.beyond)
        }
        Material::Lobes(lobes) if lobes.transparent.min_element() >= 1.0 => {
            Some(interior.through(scene, hit, direction))
        }
        Material::Clear => Some(interior.through(scene, hit, direction)),
        Material::Lobes(_) | Material::Black | Material::Lambert { .. } | Material::Mirror { .. } => None,
    }
}

/// Who looks along a straight way.
#[derive(Clone, Copy)]
pub(crate) enum Looks<'l> {
    /// A shadow ray, for light of a lamp.
    For(&'l Links),
    /// The camera.
    Camera,
}

impl Looks<'_> {
    /// Whether a medium takes anything from it.
    #[inline]
    fn is_dimmed(self, scene: &Scene, region: u32) -> bool {
        let ray = if matches!(self, Self::Camera) { Rays::CAMERA } else { Rays::SHADOW };
        !scene.is_hidden(region, ray)
    }

    /// Whether it passes anything as if that were not there.
    #[inline]
    fn passes_any(self) -> bool {
        matches!(self, Self::For(links) if links.passes_any())
    }

    /// Whether it enters and leaves what fills an object; a shadow ray stays inside of what it started in, if that is not in its way.
    #[inline]
    fn crosses(self, object: &PlacedObject) -> bool {
        match self {
            Self::For(links) => object.heed.is_in_way(links),
            Self::Camera => true,
        }
    }

    /// What a surface lets by.
    #[inline]
    fn past(self, object: &PlacedObject, material: &Material) -> Vec3 {
        match self {
            Self::For(links) => object.lets_by(links, material),
            Self::Camera if object.heed.hidden.has(Rays::CAMERA) => Vec3::ONE,
            Self::Camera => material.transparent(),
        }
    }
}

/// Per channel, what is left of light between two points; 0 if anything is between them but sides of dielectrics where the index is the same
/// on both, which bound a medium and do not bend light, and what is transparent; or if that is more than [`MOST_BOUNDS`] surfaces.
///
/// - `interior`: of `from`. Ends on surfaces should be moved off them.
pub(crate) fn passage(
    scene: &Scene,
    fogs: &[Medium],
    mut interior: Interior,
    [from, to]: [Vec3; 2],
    looks: Looks,
) -> Vec3 {
    let through = |interior: &Interior, from, to| {
        let fog = interior.medium(scene).filter(|&region| looks.is_dimmed(scene, region));
        let fog = fog.map(|id| &fogs[id as usize]);
        fog.map_or(Vec3::ONE, |fog| media::transmittance(fog, from, to))
    };
    // Among bounds of fog something is nearly always met, whatever it is.
    let shown = scene.placed.as_ref().filter(|placed| placed.shows_through() || looks.passes_any());
    if let Some(placed) = shown.filter(|_| scene.objects.is_empty()) {
        return among_placed(scene, placed, interior, [from, to], (looks, through));
    }
    if shown.is_none() {
        if !scene.occluded(from, to) {
            return through(&interior, from, to);
        }
        if !scene.may_be_seen_through() {
            return Vec3::ZERO;
        }
    }
    let (mut left, mut start) = (Vec3::ONE, from);
    for _ in 0..MOST_BOUNDS {
        let distance = start.distance(to);
        let direction = (to - start) / distance;
        // What is exactly at the end does not lie between, and at its start nothing is left of a way.
        let hit = if distance > 0.0 { scene.intersect_flat(start, direction, distance) } else { None };
        // A lamp may hang in a ceiling, which then ends nothing.
        let Some(hit) = hit.filter(|hit| !hit.lies_in_plane(to)) else {
            return left * through(&interior, start, to);
        };
        let material = scene.material_at(&hit);
        let boundary = matches!(*material, Material::Dielectric { .. })
            .then(|| Boundary::new(scene, &hit, direction, &interior))
            .filter(Boundary::is_matched);
        let (share, beyond) = match boundary {
            Some(boundary) => (Vec3::ONE, boundary.beyond),
            None => {
                let object = scene.object_of(&hit);
                let share = looks.past(&object, &material);
                if share == Vec3::ZERO {
                    return Vec3::ZERO;
                }
                let crosses = looks.crosses(&object);
                (share, if crosses { interior.through(scene, &hit, direction) } else { interior })
            }
        };
        left *= share * through(&interior, start, hit.position);
        interior = beyond;
        start = hit.leave(direction);
    }
    Vec3::ZERO
}

/// The same among nothing but what is placed: one look finds all bounds in the way, or that something is, in half of the time of a look from
/// each bound to the next.
///
/// - `looks`: as of [`passage`]; `through`: what a piece of the way leaves, by what it is inside of.
fn among_placed(
    scene: &Scene,
    placed: &Placed,
    mut interior: Interior,
    [from, to]: [Vec3; 2],
    (looks, through): (Looks, impl Fn(&Interior, Vec3, Vec3) -> Vec3),
) -> Vec3 {
    let (origin, way) = (from.as_dvec3(), to.as_dvec3() - from.as_dvec3());
    let Some(along) = way.try_normalize() else { return through(&interior, from, to) };
    // Placed glass bends light wherever it is.
    let ends = |material: u32, object: u32| {
        let object = &placed.objects()[object as usize];
        looks.past(object, &placed.materials()[material as usize]) == Vec3::ZERO
    };
    let reach = way.length() - hair(to);
    let hits = placed.surfaces().all_unless((origin, along), reach, Shading::Flat, ends);
    let Some(hits) = hits.filter(|hits| hits.len() < MOST_BOUNDS as usize) else { return Vec3::ZERO };
    let (mut left, mut start) = (Vec3::ONE, from);
    // What was met last, and how far away the same surface may be met again, at an edge.
    let (mut last, mut again) = (u32::MAX, 0.0);
    for (_, hit) in hits {
        if hit.object == last && hit.distance <= again {
            continue;
        }
        (last, again) = (hit.object, hit.distance + hit.offset);
        let object = &placed.objects()[hit.object as usize];
        let share = looks.past(object, &placed.material_at(&hit, hit.object));
        left *= share * through(&interior, start, hit.position);
        if looks.crosses(object) {
            interior = interior.through(scene, &hit, along.as_vec3());
        }
        start = hit.position;
    }
    left * through(&interior, start, to)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::medium::SceneMedium;
    use crate::medium::density::MediumDensity;
    use crate::object::placed;
    use crate::random::Random;
    use crate::scene::made::{Made, camera, cuboid, point, sphere};
    use crate::scene::visibility::Heed;

    /// A lamp above the middle.
    fn made() -> Made {
        let camera = camera([0.0, 0.0, -9.0], [0.0; 3], 40.0, [8, 8]);
        Made::new(camera).light(point([0.0, 4.0, 0.0], 1.0))
    }

    fn tinted(scattering: [f32; 3], absorption: f32) -> SceneMedium {
        let medium = Medium { scattering: scattering.into(), ..Medium::homogeneous(0.0, absorption) };
        SceneMedium {
            medium,
            more: Vec::new(),
            density: MediumDensity::Uniform,
            glow: None,
            heed: Heed::default(),
        }
    }

    /// A box of fog in haze, around a ball if it is of something.
    fn scene(index: f32, ball: Option<Material>) -> Scene {
        let made = made().fog(0.1, 0.0).in_fog().medium(tinted([1.0, 2.0, 3.0], 0.0));
        let made = made.filled(cuboid([-1.0; 3], [1.0; 3]), Material::Dielectric { index }, 1);
        match ball {
            Some(material) => made.object(sphere([0.0; 3], 0.5), material).scene(),
            None => made.scene(),
        }
    }

    fn found(scene: &Scene, from: Vec3, to: Vec3) -> Vec3 {
        passage(scene, &media::all(scene), Interior::at(scene, from), [from, to], Looks::Camera)
    }

    /// Half a metre of fog and three of haze out of the box; two and six through it.
    #[test]
    fn light_goes_straight_through_a_box_of_fog_and_loses_what_each_medium_takes() {
        let scene = scene(1.0, None);
        let fog = Vec3::new(1.0, 2.0, 3.0);
        let cases = [
            (Vec3::new(0.0, 0.5, 0.0), Vec3::new(0.0, 4.0, 0.0), [0.5, 3.0]),
            (Vec3::new(0.0, -4.0, 0.0), Vec3::new(0.0, 4.0, 0.0), [2.0, 6.0]),
            (Vec3::new(0.0, -0.5, 0.0), Vec3::new(0.0, 0.5, 0.0), [1.0, 0.0]),
            (Vec3::new(0.0, 2.0, 0.0), Vec3::new(0.0, 4.0, 0.0), [0.0, 2.0]),
        ];
        for (from, to, [in_fog, in_haze]) in cases {
            let expected = (-fog * in_fog - Vec3::splat(0.1) * in_haze).exp();
            for (from, to) in [(from, to), (to, from)] {
                let found = found(&scene, from, to);
                assert!((found / expected - 1.0).abs().max_element() < 1e-5, "{found} for {expected}");
            }
        }
    }

    #[test]
    fn glass_and_what_stands_in_the_box_cast_shadows() {
        let (from, to) = (Vec3::new(0.0, -4.0, 0.0), Vec3::new(0.0, 4.0, 0.0));
        assert_eq!(found(&scene(1.5, None), from, to), Vec3::ZERO);
        for material in [Material::Black, Material::Dielectric { index: 1.5 }] {
            assert_eq!(found(&scene(1.0, Some(material)), from, to), Vec3::ZERO);
        }
    }

    /// Through a small cube of fog in a larger one, in haze, as through boxes of scene files.
    #[test]
    fn light_goes_straight_through_bounds_of_fog_and_loses_what_each_fog_takes() {
        let fogs = || {
            made()
                .medium(tinted([1.0, 2.0, 3.0], 0.0))
                .medium(tinted([0.3, 0.2, 0.1], 0.2))
                .fog(0.1, 0.0)
                .outside(2)
        };
        let mut scene = fogs().scene();
        let v = |y: f32| Vec3::new(0.1, y, 0.2);
        scene.placed = Some(placed::tests::fogs(&[(Vec3::ZERO, 1.0), (Vec3::Y * 0.5, 2.0)]));
        // From -1.5 to 2.5 the larger one, from -1 to 1 the smaller one.
        for (from, to, [in_small, in_large, in_haze]) in [
            (v(-4.0), v(4.0), [2.0, 2.0, 4.0]),
            (v(-0.5), v(0.25), [0.75, 0.0, 0.0]),
            (v(0.5), v(4.0), [0.5, 1.5, 1.5]),
            (v(-1.25), v(1.5), [2.0, 0.75, 0.0]),
            (v(3.0), v(4.0), [0.0, 0.0, 1.0]),
        ] {
            let small = Vec3::new(1.0, 2.0, 3.0) * in_small;
            let expected = (-small - Vec3::new(0.5, 0.4, 0.3) * in_large - Vec3::splat(0.1) * in_haze).exp();
            for (from, to) in [(from, to), (to, from)] {
                let found = found(&scene, from, to);
                assert!(
                    (found / expected - 1.0).abs().max_element() < 1e-5,
                    "{from} {to}: {found} for {expected}"
                );
            }
        }
        // What stands in them casts a shadow, and so do more bounds than anybody has.
        let mut hidden = fogs().object(sphere([0.0; 3], 0.5), Material::Black).scene();
        hidden.placed = scene.placed.clone();
        assert_eq!(found(&hidden, v(-4.0), v(4.0)), Vec3::ZERO);
        assert!(found(&hidden, v(-4.0) + Vec3::X * 0.8, v(4.0) + Vec3::X * 0.8).min_element() > 0.0);
        scene.media = vec![scene.media[2].clone(); 40];
        scene.outside = Some(0);
        let layers = |count: u32| -> Vec<(Vec3, f32)> {
            (0..count).map(|i| (Vec3::ZERO, 1.0 + 0.01 * i as f32)).collect()
        };
        scene.placed = Some(placed::tests::fogs(&layers(31)));
        assert!((found(&scene, v(-4.0), v(4.0)).x / (-0.8_f32).exp() - 1.0).abs() < 1e-5);
        scene.placed = Some(placed::tests::fogs(&layers(33)));
        assert_eq!(found(&scene, v(-4.0), v(4.0)), Vec3::ZERO);
    }

    /// One look from end to end, and one from each bound to the next, which is what an object far away asks for: among cubes of fog that overlap.
    #[test]
    fn one_look_finds_what_a_look_from_each_bound_to_the_next_does() {
        // Of 0, 0.01, 0.02 and so on.
        let fogs = || (0..13).fold(made(), |made, i| made.fog(i as f32 / 100.0, 0.0)).outside(12);
        let mut random = Random::new([1, 2, 3, 4]);
        let mut number = |most: f32| most * (2.0 * random.uniform() - 1.0);
        let mut cube = |i| (Vec3::new(number(1.5), number(1.5), number(1.5)), 0.3 + 0.1 * i as f32);
        let cubes: Vec<(Vec3, f32)> = (0..12).map(&mut cube).collect();
        let far = fogs().object(sphere([900.0, 0.0, 0.0], 0.5), Material::Black);
        let scenes = [fogs(), far].map(|made| {
            let mut scene = made.scene();
            scene.placed = Some(placed::tests::fogs(&cubes));
            scene
        });
        for _ in 0..2000 {
            let mut place = || Vec3::new(number(2.0), number(2.0), number(2.0));
            let (from, to) = (place(), place());
            let [one, each] = scenes.each_ref().map(|scene| found(scene, from, to));
            assert!(
                each.min_element() > 0.0 && (one - each).abs().max_element() < 1e-5,
                "{from} {to}: {one} for {each}"
            );
        }
    }
}
