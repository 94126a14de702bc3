//! Hosts with geometry of their own: the bits of meshes that are built here where they tell the truth, and sound pictures where they lie.

use crate::scenes::{BLACK, FOG, GLASS, LAMP, light, options, session, view, volume};
use crate::shapes::{add, built, icosphere, rows};
use covbeam_geometry::hit::Hit;
use covbeam_geometry::instances::Instances;
use covbeam_session::describe::geometry::Geometry;
use covbeam_session::describe::{Description, MaterialFields, ObjectFields};
use covbeam_session::film::Picture;
use covbeam_session::host::HostScene;
use covbeam_session::scene::{Scene, Sees};
use covbeam_session::work::failure::Failure;
use glam::{DMat4, DVec3, Vec3};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Meshes behind a host's interface.
#[derive(Debug)]
pub(crate) struct Truthful(pub(crate) Arc<Instances>);

impl HostScene for Truthful {
    fn bounds(&self) -> (Vec3, Vec3) {
        self.0.bounds()
    }

    fn cast(&self, origin: DVec3, direction: DVec3, reach: f64) -> Option<Hit> {
        self.0.intersect(origin, direction, reach).map(|hit| self.0.describe(&hit))
    }

    fn is_blocked(&self, origin: DVec3, direction: DVec3, reach: f64) -> Option<bool> {
        Some(self.0.occluded(origin, direction, reach))
    }
}

/// The same, of which one answer in `one_in` is one of many kinds of lies, another one each time that it is asked.
#[derive(Debug)]
struct Liar {
    truth: Truthful,
    asked: AtomicU64,
    one_in: u64,
}

impl Liar {
    /// SplitMix64 (Steele, Lea and Flood 2014) of the number of the question.
    fn dice(&self) -> u64 {
        let asked = self.asked.fetch_add(1, Ordering::Relaxed);
        let mut z = asked.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
}

impl HostScene for Liar {
    fn bounds(&self) -> (Vec3, Vec3) {
        self.truth.bounds()
    }

    fn cast(&self, origin: DVec3, direction: DVec3, reach: f64) -> Option<Hit> {
        let hit = self.truth.cast(origin, direction, reach);
        let dice = self.dice();
        if !dice.is_multiple_of(self.one_in) {
            return hit;
        }
        let wrong = Hit {
            distance: 1.0,
            position: (origin + direction).as_vec3(),
            geometric_normal: -direction.as_vec3(),
            normal: -direction.as_vec3(),
            curvature: Default::default(),
            object: 0,
            material: 0,
            mark: [0; 3],
            is_alone: false,
            offset: 1e-6,
        };
        let hit = hit.unwrap_or(wrong);
        Some(match (dice / self.one_in) % 14 {
            0 => return None,
            1 => Hit { normal: Vec3::NAN, ..hit },
            2 => Hit { geometric_normal: Vec3::ZERO, ..hit },
            3 => Hit { distance: -1.0, ..hit },
            4 => Hit { distance: f32::NAN, ..hit },
            5 => Hit { distance: f32::INFINITY, ..hit },
            6 => Hit { position: Vec3::INFINITY, ..hit },
            7 => Hit { object: u32::MAX, ..hit },
            8 => Hit { material: 99, ..hit },
            9 => Hit { offset: 0.0, ..hit },
            10 => Hit { offset: f32::NAN, ..hit },
            11 => Hit { geometric_normal: -hit.geometric_normal, normal: -hit.normal, ..hit },
            12 => Hit { curvature: covbeam::Curvature { along: f32::NAN, ..hit.curvature }, ..hit },
            // Where it started, as if nothing had been passed.
            _ => Hit { distance: f32::MIN_POSITIVE, position: origin.as_vec3(), ..wrong },
        })
    }
}

/// A ball of glass, one of fog in a bound that bends nothing, and a floor.
pub(crate) fn meshes() -> Arc<Instances> {
    let geometry = Geometry::default();
    let ball = icosphere(3);
    let mesh = add(&geometry, &ball, 0, Some(&ball.radial_normals()));
    let place = |x: f64, y: f64, scale: DVec3, object: i32, material: i32| {
        let matrix = DMat4::from_translation(DVec3::new(x, y, 0.0)) * DMat4::from_scale(scale);
        geometry.add_instance(mesh, &rows(matrix), object, material).expect("valid");
    };
    place(-0.6, 0.0, DVec3::splat(0.5), 0, 0);
    place(0.7, 0.0, DVec3::splat(0.45), 1, 1);
    place(0.0, -1.5, DVec3::new(3.0, 0.2, 3.0), 2, 2);
    built(&geometry)
}

/// `bound`: what the ball of fog is bounded by.
pub(crate) fn described_with<T>(bound: MaterialFields, of: impl FnOnce(&Description) -> T) -> T {
    let grey = MaterialFields { diffuse: [0.5; 3], ..BLACK };
    let object = |volume| ObjectFields { volume, is_closed: true, ..ObjectFields::default() };
    let mut smoke = volume(FOG);
    (smoke.fields.min, smoke.fields.max) = ([0.2, -0.5, -0.5], [1.2, 0.5, 0.5]);
    smoke.fields.scattering = [0.9; 3];
    of(&Description {
        materials: vec![GLASS, bound, grey],
        objects: vec![object(-1), object(1), object(-1)],
        shapes: Vec::new(),
        volumes: vec![volume(FOG), smoke],
        world_volume: 0,
        lights: vec![light(LAMP)],
        camera: view(16),
        sees: Sees::Everything,
    })
}

fn described<T>(of: impl FnOnce(&Description) -> T) -> T {
    described_with(MaterialFields { transparent: [1.0; 3], ..BLACK }, of)
}

fn of_host(geometry: Arc<dyn HostScene>) -> Arc<Scene> {
    Arc::new(described(|description| description.scene_of_host(geometry)).expect("valid"))
}

pub(crate) fn picture(scene: &Arc<Scene>, passes: u32, photons: u32) -> Arc<Picture> {
    let session = session(scene, options(photons));
    (0..passes).for_each(|_| session.pass(&mut || true).expect("a pass"));
    session.picture(&mut || true).expect("made")
}

#[test]
fn a_host_that_tells_the_truth_has_the_bits_of_its_meshes() {
    let meshes = meshes();
    let ours = described_with(GLASS, |description| description.scene(Arc::clone(&meshes)));
    let theirs = described_with(GLASS, |description| description.scene_of_host(Arc::new(Truthful(meshes))));
    let [ours, theirs] = [ours, theirs].map(|scene| picture(&Arc::new(scene.expect("valid")), 4, 1000));
    let differing = ours.radiance.iter().zip(&theirs.radiance).filter(|(a, b)| a != b).count();
    assert_eq!(differing, 0, "of 256 pixels");
}

/// What lets light go straight on is met one by one, not all at once: the same places but for their last digits.
#[test]
fn a_host_that_tells_the_truth_has_the_picture_of_its_meshes() {
    let meshes = meshes();
    let ours = picture(&Arc::new(described(|d| d.scene(Arc::clone(&meshes))).expect("valid")), 4, 1000);
    let theirs = picture(&of_host(Arc::new(Truthful(meshes))), 4, 1000);
    let sum = |picture: &Picture| picture.radiance.iter().map(|pixel| f64::from(pixel.x)).sum::<f64>();
    let differing = ours.radiance.iter().zip(&theirs.radiance).filter(|(a, b)| a != b).count();
    println!("{differing} of 256 pixels differ, sums {} and {}", sum(&ours), sum(&theirs));
    // A path whose last digit differs may be drawn anew; of four passes that is noise of a thousandth.
    assert!((sum(&ours) / sum(&theirs) - 1.0).abs() < 0.01);
}

#[test]
fn bounds_that_are_no_box_are_refused() {
    #[derive(Debug)]
    struct Nowhere(Vec3, Vec3);
    impl HostScene for Nowhere {
        fn bounds(&self) -> (Vec3, Vec3) {
            (self.0, self.1)
        }

        fn cast(&self, _: DVec3, _: DVec3, _: f64) -> Option<Hit> {
            None
        }
    }
    for (min, max) in [(Vec3::NAN, Vec3::ONE), (Vec3::ONE, Vec3::ZERO), (Vec3::ZERO, Vec3::INFINITY)] {
        let refused = described(|description| description.scene_of_host(Arc::new(Nowhere(min, max))));
        let Err(Failure::Invalid(message)) = refused else { panic!("taken") };
        assert!(message.contains("geometry.bounds"), "{message}");
    }
}

/// Ten thousand passes would take a minute: a few dozen here, of hosts that lie seldom, often and always.
#[test]
fn hosts_that_lie_get_finite_pictures_and_no_pass_without_end() {
    for (one_in, passes) in [(1000, 20), (20, 20), (1, 20)] {
        let truth = Truthful(meshes());
        let scene = of_host(Arc::new(Liar { truth, asked: AtomicU64::new(0), one_in }));
        let made = picture(&scene, passes, 50);
        assert!(made.radiance.iter().all(|pixel| pixel.is_finite() && pixel.min_element() >= 0.0));
        assert!(made.error.as_ref().is_some_and(|error| error.iter().all(|error| error.is_finite())));
    }
}
