//! Where the picture needs photons: a pilot finds the importance of light in the voxels, and from it how each lamp emits.
//!
//! The pilot is a function of the scene alone: a coarse picture; paths from the camera that carry the inverse of its brightness; rays from
//! each lamp that ask what the light in a direction is worth; and a few guided paths that find out whether they are worth more than plain ones, and
//! how much of the picture's noise is theirs.

mod branches;
pub mod defaults;
mod importons;
mod instant;
mod lamps;
mod look;
mod survey;
mod trial;

pub(crate) use branches::Spread;
pub(crate) use instant::{Instant, Poll};

use crate::paths::guidance::Guidance;
use covbeam::{Importance, ImportanceCell, ImportanceGrid, ImportanceSums};
use std::sync::Arc;

const FITS: &str = "as many cells as the layout has";

/// What guides light paths at each instant of one scene, all with the same grid; what light is worth is a mean over them. None where no light reaches the camera,
/// and where all that does comes straight from lamps.
///
/// - `instants`: at least one. Cost: 50 to 90 core-milliseconds in the scenes of the repository, and a tenth of that for each instant more.
///   Where `cancelled` says yes, which it must go on to say, it returns soon, and what it says is of no use.
pub(crate) fn guidance(instants: &[Instant], cancelled: Poll) -> Vec<Option<Guidance>> {
    let dark = || instants.iter().map(|_| None).collect();
    let Some(pixels) = look::pixels(instants, cancelled) else { return dark() };
    let found = importons::walk(instants, &pixels, cancelled);
    let around = &instants[0].scene.grid;
    let layout = found.layout(around.min, around.max);
    let mut sums = vec![ImportanceSums::default(); layout.cell_count()];
    let mut grid = ImportanceGrid::new(layout, &mut sums).expect("the scene's grid was validated");
    found.add_to(&mut grid, instants);
    let mut cells = vec![ImportanceCell::default(); layout.cell_count()];
    grid.resolve(&mut cells).expect(FITS);
    let cells = Arc::<[ImportanceCell]>::from(cells);
    let importance = Importance::new(layout, &cells).expect(FITS);
    let of_instant = |&Instant { scene, fogs }: &Instant| {
        let lamps = lamps::emission(scene, fogs, &importance, cancelled)?;
        Some(Guidance::new(layout, Arc::clone(&cells), lamps))
    };
    instants.iter().map(of_instant).collect()
}

/// The same of a scene that stands still.
#[cfg(test)]
pub(crate) fn of_still(scene: &crate::scene::Scene, fogs: &[covbeam::Medium]) -> Option<Guidance> {
    guidance(&[Instant { scene, fogs }], &|| false).pop().flatten()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paths::guidance::of_ray;
    use crate::scene::Scene;
    use crate::scene::made::{BOUND, Made, camera, cuboid, lambert, point, rectangle, sphere, spot};
    use crate::scene::media;
    use crate::scene::optics::Interior;
    use glam::Vec3;

    /// A lamp above thin fog and, once `with` has put in what holds it, a floor.
    fn above_floor(with: impl Fn(Made) -> Made) -> Scene {
        let fog = Made::new(camera([0.0, 1.0, -6.0], [0.0, 0.8, 0.0], 40.0, [48, 32])).fog(0.1, 0.0);
        with(fog)
            .object(rectangle([-9.0, 0.0, -9.0], [0.0, 0.0, 18.0], [18.0, 0.0, 0.0]), lambert(0.5))
            .light(spot([0.0, 6.0, 0.0], [0.0, 2.0, 0.0], 60.0, [4.0, 5.0]))
            .scene()
    }

    /// A floor below a ball of fog is worth something where the camera sees it, through a boundary that bends nothing; the sky is not. Fog as
    /// thin as this scatters a twentieth.
    #[test]
    fn light_that_leaves_a_ball_of_fog_is_worth_what_it_meets() {
        let scene = above_floor(|fog| fog.filled(sphere([0.0, 2.0, 0.0], 0.5), BOUND, 0));
        let fogs = media::all(&scene);
        let guidance = of_still(&scene, &fogs).expect("light");
        let center = Vec3::new(0.0, 2.0, 0.0);
        let interior = Interior::at(&scene, center);
        let of_ray =
            |direction| of_ray(&scene, &fogs, &guidance.importance(), (center, direction), &interior, 0);
        let [floor, sky] = [Vec3::new(0.0, -2.0, -2.0).normalize(), Vec3::Y].map(of_ray);
        println!("{floor} {sky}");
        assert!(sky > 0.0 && floor > 5.0 * sky, "{floor} {sky}");
    }

    /// The same of a cube in larger ones: through any number of bounds, and of nothing but fog, no surface.
    #[test]
    fn light_that_leaves_cubes_of_fog_is_worth_what_it_meets() {
        let mut scene = above_floor(|fog| fog);
        let center = Vec3::new(0.0, 2.0, 0.0);
        let cubes: Vec<(Vec3, f32)> = (0..6).map(|i| (center, 0.4 + 0.02 * i as f32)).collect();
        scene.media = vec![scene.media[0].clone(); 6];
        scene.placed = Some(crate::object::placed::tests::fogs(&cubes));
        let worth = |scene: &Scene| {
            let fogs = media::all(scene);
            let guidance = of_still(scene, &fogs).expect("light");
            let interior = Interior::at(scene, center);
            let of_ray = |direction: Vec3| {
                of_ray(scene, &fogs, &guidance.importance(), (center, direction), &interior, 0)
            };
            [Vec3::new(0.0, -2.0, -2.0).normalize(), Vec3::Y].map(of_ray)
        };
        let [floor, sky] = worth(&scene);
        println!("{floor} {sky}");
        assert!(sky > 0.0 && floor > 5.0 * sky, "{floor} {sky}");
        scene.sees = crate::scene::Sees::FogAlone;
        let [floor, sky] = worth(&scene);
        println!("{floor} {sky}");
        // The floor is black; what it scatters back into the fog is little.
        assert!(sky > 0.0 && floor < 2.0 * sky, "{floor} {sky}");
    }

    /// Two lamps that are the same on either side of the wall of a white box, in which the camera is: by its voxels, which know no sides, the one
    /// outside is worth as much, and half of all paths are its. It lights nothing that is seen; rays say so.
    #[test]
    fn few_light_paths_go_to_the_outside_of_a_wall() {
        let scene = Made::new(camera([0.0, 0.0, -1.9], [0.0; 3], 90.0, [48, 48]))
            .fog(0.02, 0.0)
            .in_fog()
            .object(cuboid([-2.0; 3], [2.0; 3]), lambert(0.8))
            .light(spot([1.0, 0.3, 0.2], [2.0, 0.3, 0.2], 9.0, [9.0, 10.0]))
            .light(spot([3.0, 0.3, 0.2], [2.0, 0.3, 0.2], 9.0, [9.0, 10.0]))
            .scene();
        let fogs = media::all(&scene);
        let guidance = of_still(&scene, &fogs).expect("light");
        let inside = guidance.lamps()[0];
        println!("{inside} of the paths are of the lamp inside");
        assert!(inside > 0.6, "{inside}");
    }

    /// A camera that looks at one floor, then at another: of the mean picture each floor is half.
    #[test]
    fn what_instants_see_is_worth_its_share_of_their_mean() {
        let seen_from = |x: f32| {
            let mut scene = Made::new(camera([x, 2.0, 0.0], [x, 0.0, 0.01], 40.0, [32, 32]))
                .fog(0.05, 0.0)
                .in_fog()
                .object(rectangle([-6.0, 0.0, -2.0], [0.0, 0.0, 4.0], [12.0, 0.0, 0.0]), lambert(0.5))
                .light(point([0.0, 3.0, 0.0], 9.0))
                .scene();
            // As while a shutter is open.
            (scene.grid.min, scene.grid.max) = (Vec3::new(-6.0, 0.0, -2.0), Vec3::new(6.0, 3.0, 2.0));
            scene
        };
        let scenes = [-4.0, 4.0].map(seen_from);
        let fogs = scenes.each_ref().map(media::all);
        let instants: Vec<Instant> =
            scenes.iter().zip(&fogs).map(|(scene, fogs)| Instant { scene, fogs }).collect();
        let together = guidance(&instants, &|| false);
        let worth = |of: &Option<Guidance>, x: f32| {
            let of = of.as_ref().expect("light");
            (0..8)
                .map(|step| of.importance().at(Vec3::new(x, 0.0, 0.15 * step as f32 - 0.5)).surface)
                .sum::<f32>()
        };
        for (instant, x) in instants.iter().zip([-4.0, 4.0]) {
            let alone = guidance(&[*instant], &|| false).remove(0);
            let share = together.iter().map(|of| worth(of, x) / worth(&alone, x)).collect::<Vec<_>>();
            println!("at {x}: {share:?}, and over there {}", worth(&alone, -x) / worth(&alone, x));
            // 8,000 of 16,000 paths, over some cells.
            assert!(share.iter().all(|share| (share - 0.5).abs() < 0.1), "{share:?}");
            assert!(worth(&alone, -x) < 0.05 * worth(&alone, x));
        }
    }
}
