//! Sessions: the same bits for any number of threads, and no trace of what was stopped.

mod shapes;

use covbeam_rays::describe::{Description, Light, LightFields, MaterialFields, Volume, VolumeFields};
use covbeam_rays::failure::Failure;
use covbeam_rays::geometry::Geometry;
use covbeam_rays::picture::Picture;
use covbeam_rays::session::{Session, SettingsFields, Task};
use covbeam_session::scene::Scene;
use glam::DMat4;
use shapes::{CAMERA, Random, add, built, icosphere, rows};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// What a caller does not notice: asked for is a tenth of a second, of which the machine has a part.
const QUICK: Duration = Duration::from_millis(100);

const SETTINGS: SettingsFields = SettingsFields {
    radius: 0.0,
    quality: 0.01,
    seed: 1,
    photons: 2000,
    grid: 0,
    bounces: -1,
    beyond: 1,
    threads: 2,
};

/// A ball of glass in endless fog, and a lamp.
fn scene() -> Arc<Scene> {
    let ball = icosphere(3);
    let geometry = Geometry::default();
    let mesh = add(&geometry, &ball, 0, Some(&ball.radial_normals()));
    geometry.add_instance(mesh, &rows(DMat4::from_scale(glam::DVec3::splat(0.5))), 0, -1).expect("valid");
    let glass = [1.0; 3];
    let glass =
        MaterialFields { glass_reflection: glass, glass_transmission: glass, ior: 1.5, ..Default::default() };
    let fog = VolumeFields {
        scattering: [0.15; 3],
        absorption: [0.1; 3],
        min: [f64::NEG_INFINITY; 3],
        max: [f64::INFINITY; 3],
        asymmetry: 0.0,
        density_min: [0.0; 3],
        density_max: [0.0; 3],
        glow_min: [0.0; 3],
        glow_max: [0.0; 3],
        cells: [0; 3],
        glow_cells: [0; 3],
        phase: 0,
    };
    let lamp = LightFields {
        position: [1.0, 2.4, 0.0],
        axis: [0.0; 3],
        u: [0.0; 3],
        v: [0.0; 3],
        intensity: [25.0; 3],
        radiance: [0.0; 3],
        irradiance: [0.0; 3],
        axes: [[0.0; 3]; 3],
        radius: 0.0,
        cosine: 0.0,
        blend: 0.0,
        spread: 0.0,
        angle: 0.0,
        reach: 0.0,
        kind: 0,
        soft: 0,
        round: 0,
        rows: 0,
        columns: 0,
    };
    let description = Description {
        materials: &[glass],
        object_volumes: &[-1],
        object_closed: &[1],
        volumes: vec![Volume { fields: fog, densities: None, glow: None, parts: &[] }],
        world_volume: 0,
        lights: vec![Light { fields: lamp, triangles: &[], cells: None }],
        camera: CAMERA,
    };
    Arc::new(description.scene(built(&geometry)).expect("valid"))
}

fn ended(session: &Session) {
    while !session.wait(Duration::from_secs(1)).expect("no failure") {}
}

fn ready(scene: &Arc<Scene>, settings: &SettingsFields) -> Session {
    let session = Session::new(std::slice::from_ref(scene), settings).expect("valid");
    ended(&session);
    session
}

fn done(session: &Session, task: Task) {
    session.start(task).expect("starts");
    ended(session);
}

fn picture(session: &Session, passes: u32) -> Picture {
    while session.info().passes < passes {
        done(session, Task::Pass);
    }
    done(session, Task::Picture);
    session.picture().expect("made")
}

#[test]
fn pictures_do_not_depend_on_the_number_of_threads_and_have_what_is_asked_for() {
    let scene = scene();
    let [one, two, three] =
        [1, 2, 3].map(|threads| picture(&ready(&scene, &SettingsFields { threads, ..SETTINGS }), 3));
    assert!(one == two && one == three);
    let differs = |a: &[f32; 3], b: &[f32; 3]| a != b;
    let behind = one.in_scattered.iter().zip(&one.first).filter(|(all, first)| differs(all, first)).count();
    // The ball is 5 pixels wide.
    assert!((10..100).contains(&behind), "{behind} pixels see fog in glass or behind it");
    for values in [&one.radius, &one.bandwidth, &one.error] {
        assert!(values.iter().filter(|value| **value > 0.0).count() > 200, "{values:?}");
    }
    let alone = picture(&ready(&scene, &SettingsFields { beyond: 0, ..SETTINGS }), 3);
    assert_eq!(alone.in_scattered, alone.first);
}

#[test]
fn a_session_that_was_started_anew_is_as_one_with_so_many_photons() {
    let scene = scene();
    let session = ready(&scene, &SETTINGS);
    picture(&session, 2);
    session.restart(700, true).expect("nothing goes on");
    let plain = picture(&session, 1);
    session.restart(700, false).expect("nothing goes on");
    assert_eq!((session.info().passes, session.info().photons), (0, 700));
    let other = ready(&scene, &SettingsFields { photons: 700, ..SETTINGS });
    assert_eq!(picture(&session, 2), picture(&other, 2));
    session.restart(700, true).expect("nothing goes on");
    assert_eq!(picture(&session, 1), plain);
    session.restart(700, false).expect("nothing goes on");
    let guided = picture(&session, 1);
    assert!(
        guided != plain && guided == picture(&ready(&scene, &SettingsFields { photons: 700, ..SETTINGS }), 1)
    );
    session.restart(5000, false).expect("nothing goes on");
    assert_eq!(session.info().photons, 2000, "at most those of the settings");
}

#[test]
fn what_was_stopped_at_any_moment_leaves_no_trace_and_is_not_waited_for() {
    let scene = scene();
    let settings = SettingsFields { photons: 20_000, ..SETTINGS };
    let session = ready(&scene, &settings);
    let start = Instant::now();
    done(&session, Task::Pass);
    let pass = start.elapsed();
    let mut random = Random(8);
    for stopped in 0..20 {
        let task = if stopped % 4 == 3 { Task::Picture } else { Task::Pass };
        session.start(task).expect("starts");
        let share = 0.5 + 0.5 * random.signed();
        std::thread::sleep(pass.mul_f64(share * if task == Task::Pass { 1.0 } else { 0.1 }));
        let before = session.info().passes;
        let start = Instant::now();
        session.stop();
        assert!(start.elapsed() < QUICK, "{:?}", start.elapsed());
        let after = session.info().passes;
        assert!(after == before || after == before + 1);
        // What goes on behind the scenes changes nothing any more.
        std::thread::sleep(Duration::from_millis(20));
        assert_eq!(session.info().passes, after);
    }
    let passes = session.info().passes.max(2) + 1;
    assert_eq!(picture(&session, passes), picture(&ready(&scene, &settings), passes));
}

#[test]
fn a_session_that_is_dropped_or_stopped_before_it_is_ready_lets_go_at_once() {
    let scene = scene();
    for milliseconds in [0, 5, 50] {
        for stop_by_drop in [false, true] {
            let session = Session::new(&[Arc::clone(&scene)], &SETTINGS).expect("valid");
            std::thread::sleep(Duration::from_millis(milliseconds));
            let start = Instant::now();
            if stop_by_drop {
                drop(session);
            } else {
                session.stop();
                assert!(start.elapsed() < QUICK, "{:?}", start.elapsed());
                // It can only be dropped, unless it had been ready.
                session.start(Task::Pass).expect("nothing goes on");
                let end = loop {
                    match session.wait(Duration::from_secs(1)) {
                        Ok(false) => {}
                        end => break end,
                    }
                };
                assert!(matches!(end, Ok(true) | Err(Failure::Order(_))), "{end:?}");
                continue;
            }
            assert!(start.elapsed() < QUICK, "{:?}", start.elapsed());
        }
    }
}
