//! Where the picture needs photons: a pilot finds the importance of light in the voxels, and from it how each lamp emits.
//!
//! The pilot is a function of the scene alone: a coarse picture; paths from the camera that carry the inverse of its brightness; rays from
//! each lamp that ask what the light in a direction is worth; and a few guided paths that find out whether they are worth more than plain ones, and
//! how much of the picture's noise is theirs.

mod branches;
mod importons;
mod instant;
mod lamps;
mod look;
mod trial;

pub(crate) use branches::Spread;
pub(crate) use instant::{Instant, Poll};

use crate::guidance::Guidance;
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
    use crate::media;
    use crate::optics::Interior;
    use crate::scene::Scene;
    use glam::Vec3;
    use std::path::Path;

    /// A floor below a ball of fog is worth something where the camera sees it, through a boundary that bends nothing; the sky is not. Fog as
    /// thin as this scatters a twentieth.
    #[test]
    fn light_that_leaves_a_ball_of_fog_is_worth_what_it_meets() {
        let scene = "[camera]\nposition = [0, 1, -6]\nlook_at = [0, 0.8, 0]\nvertical_fov = 40\nwidth = 48\nheight = 32\n\
            [[medium]]\nname = \"fog\"\nscattering = 0.1\nabsorption = 0\n\
            [[object]]\nshape = \"sphere\"\ncenter = [0, 2, 0]\nradius = 0.5\n\
            material = { dielectric = { index = 1.0 } }\ninside = \"fog\"\n\
            [[object]]\nshape = \"rectangle\"\ncorner = [-9, 0, -9]\nedge_u = [0, 0, 18]\nedge_v = [18, 0, 0]\n\
            material = { lambert = { albedo = 0.5 } }\n\
            [[light]]\nkind = \"spot\"\nposition = [0, 6, 0]\nlook_at = [0, 2, 0]\nintensity = 60\ninner_angle = 4\nouter_angle = 5\n";
        let scene = Scene::parse(scene, "ball of fog", Path::new("")).expect("a valid scene");
        let fogs = media::all(&scene);
        let guidance = of_still(&scene, &fogs).expect("light");
        let center = Vec3::new(0.0, 2.0, 0.0);
        let interior = Interior::at(&scene, center);
        let of_ray = |direction| guidance.of_ray(&scene, &fogs, center, direction, &interior, 0);
        let [floor, sky] = [Vec3::new(0.0, -2.0, -2.0).normalize(), Vec3::Y].map(of_ray);
        println!("{floor} {sky}");
        assert!(sky > 0.0 && floor > 5.0 * sky, "{floor} {sky}");
    }

    /// The same of a cube in larger ones: through any number of bounds, and of nothing but fog, no surface.
    #[test]
    fn light_that_leaves_cubes_of_fog_is_worth_what_it_meets() {
        let text = "[camera]\nposition = [0, 1, -6]\nlook_at = [0, 0.8, 0]\nvertical_fov = 40\nwidth = 48\nheight = 32\n\
            [[medium]]\nname = \"fog\"\nscattering = 0.1\nabsorption = 0\n\
            [[object]]\nshape = \"rectangle\"\ncorner = [-9, 0, -9]\nedge_u = [0, 0, 18]\nedge_v = [18, 0, 0]\n\
            material = { lambert = { albedo = 0.5 } }\n\
            [[light]]\nkind = \"spot\"\nposition = [0, 6, 0]\nlook_at = [0, 2, 0]\nintensity = 60\ninner_angle = 4\nouter_angle = 5\n";
        let mut scene = Scene::parse(text, "cubes of fog", Path::new("")).expect("a valid scene");
        let center = Vec3::new(0.0, 2.0, 0.0);
        let cubes: Vec<(Vec3, f32)> = (0..6).map(|i| (center, 0.4 + 0.02 * i as f32)).collect();
        scene.media = vec![scene.media[0].clone(); 6];
        scene.placed = Some(crate::placed::tests::fogs(&cubes));
        let worth = |scene: &Scene| {
            let fogs = media::all(scene);
            let guidance = of_still(scene, &fogs).expect("light");
            let interior = Interior::at(scene, center);
            let of_ray = |direction: Vec3| guidance.of_ray(scene, &fogs, center, direction, &interior, 0);
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

    /// A camera that looks at one floor, then at another: of the mean picture each floor is half.
    #[test]
    fn what_instants_see_is_worth_its_share_of_their_mean() {
        let seen_from = |x: f32| {
            let text = format!(
                "outside_medium = \"fog\"\n\
                 [camera]\nposition = [{x}, 2, 0]\nlook_at = [{x}, 0, 0.01]\nvertical_fov = 40\nwidth = 32\nheight = 32\n\
                 [[medium]]\nname = \"fog\"\nscattering = 0.05\nabsorption = 0\n\
                 [[object]]\nshape = \"rectangle\"\ncorner = [-6, 0, -2]\nedge_u = [0, 0, 4]\nedge_v = [12, 0, 0]\n\
                 material = {{ lambert = {{ albedo = 0.5 }} }}\n\
                 [[light]]\nkind = \"point\"\nposition = [0, 3, 0]\nintensity = 9\n"
            );
            let mut scene = Scene::parse(&text, "two floors", Path::new("")).expect("a valid scene");
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
