//! Sessions: the same bits for any number of threads, and no trace of what was stopped.

use crate::scenes::{
    QUICK, assert_same, fill, mesh_in_fog, options, picture, session, shown, sphere_in_fog, view,
};
use crate::shapes::Random;
use covbeam_session::scene::Scene;
use covbeam_session::session::{Options, Session};
use covbeam_session::settings::Settings;
use covbeam_session::work::failure::{Failure, Result};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// As hosts ask for that show the fog before the first surface apart.
fn fog_apart(photons: u32) -> Options {
    let options = options(photons);
    Options { settings: Settings { first_apart: true, ..options.settings }, ..options }
}

#[test]
fn pictures_do_not_depend_on_the_number_of_threads_and_have_what_is_asked_for() {
    let scene = mesh_in_fog();
    let of = |threads| picture(&session(&scene, Options { threads, ..fog_apart(2000) }), 3);
    let [one, two, three] = [1, 2, 3].map(of);
    assert_same(&two, &one);
    assert_same(&three, &one);
    let volume = &one.maps.as_ref().expect("the eye rays are planned").volume;
    let behind = one.radiance.iter().zip(volume).filter(|(all, first)| all != first).count();
    // The ball is 5 pixels wide.
    assert!((10..100).contains(&behind), "{behind} pixels see fog in glass or behind it");
    let layers = one.layers.as_ref().expect("beams are gathered");
    let error = one.error.as_ref().expect("two halves of the passes");
    for values in [&layers.radius, &layers.sigma, error] {
        assert!(values.iter().filter(|value| **value > 0.0).count() > 200, "{values:?}");
    }
    let settings = Settings { beyond: false, ..fog_apart(2000).settings };
    let alone = picture(&session(&scene, Options { settings, ..fog_apart(0) }), 3);
    assert_eq!(alone.radiance, alone.maps.as_ref().expect("planned").volume);
}

#[test]
fn a_session_that_was_started_anew_is_as_one_with_so_many_photons() {
    let scene = mesh_in_fog();
    let begun = session(&scene, options(2000));
    picture(&begun, 2);
    begun.restart(700, true).expect("nothing goes on");
    let plain = picture(&begun, 1);
    begun.restart(700, false).expect("nothing goes on");
    let info = begun.info();
    assert_eq!((info.passes, info.photons, info.most_photons), (0, 700, 2000));
    let other = session(&scene, options(700));
    // Of a single pass first.
    let guided = picture(&begun, 1);
    assert!(guided != plain);
    assert_same(&guided, &picture(&other, 1));
    assert_same(&picture(&begun, 2), &picture(&other, 2));
    begun.restart(700, true).expect("nothing goes on");
    assert_same(&picture(&begun, 1), &plain);
    begun.restart(5000, false).expect("nothing goes on");
    assert_eq!(begun.info().photons, 2000, "at most those of the settings");
    begun.restart(0, false).expect("nothing goes on");
    assert_eq!(begun.info().photons, 1, "and at least one");
}

/// Says no at a random moment in the time that something takes; what the call returns, which it does at once then. None: it was never asked.
fn stopped<T>(
    random: &mut Random,
    longest: Duration,
    call: impl FnOnce(&mut dyn FnMut() -> bool) -> Result<T>,
) -> (Option<Duration>, Result<T>) {
    let moment = Instant::now() + longest.mul_f64(0.5 + 0.5 * random.signed());
    let mut refused = None;
    let result = call(&mut || {
        // Waits for the moment where the next question, 40 ms later, would come after it.
        let left = moment.saturating_duration_since(Instant::now());
        if left > Duration::from_millis(40) {
            return true;
        }
        std::thread::sleep(left);
        refused = Some(Instant::now());
        false
    });
    (refused.map(|refused| refused.elapsed()), result)
}

#[test]
fn what_was_stopped_at_any_moment_leaves_no_trace_and_is_not_waited_for() {
    let scene = mesh_in_fog();
    let begun = session(&scene, options(20_000));
    let took = || {
        let start = Instant::now();
        fill(&begun, begun.info().passes + 1);
        start.elapsed()
    };
    let (mut random, mut cancelled) = (Random(8), 0);
    // A third of them while the pilot goes on, the others in passes like the second.
    let mut longest = Duration::from_millis(400);
    for number in 0..12 {
        if number == 4 {
            took();
            longest = took();
        }
        let before = begun.info();
        let (waited, result) = stopped(&mut random, longest, |go_on| begun.pass(go_on));
        if let Some(waited) = waited {
            assert!(waited < QUICK, "{waited:?}");
        }
        let after = begun.info();
        match result {
            Ok(()) => assert_eq!(after.passes, before.passes + 1),
            Err(failure) => {
                assert_eq!(failure, Failure::Cancelled);
                // What goes on behind the scenes changes nothing any more.
                std::thread::sleep(Duration::from_millis(20));
                assert_eq!((before, begun.info()), (after, after));
                cancelled += 1;
            }
        }
    }
    // On a machine that is four times as fast it is the pilot alone that is asked about.
    assert!(cancelled > 2, "{cancelled} passes were stopped");
    let passes = begun.info().passes + 1;
    assert_same(&picture(&begun, passes), &picture(&session(&scene, options(20_000)), passes));
}

#[test]
fn pictures_and_sums_that_were_stopped_are_made_the_next_time() {
    // Without light there is nothing to trace, and so many pixels take their time all the same.
    let scene = sphere_in_fog(view(1500));
    let dark = Arc::new(Scene { lights: Vec::new(), ..scene.as_ref().clone() });
    let begun = session(&dark, Options { threads: 1, ..options(1) });
    fill(&begun, 2);
    let (before, mut random) = (begun.info(), Random(9));
    let is_stopped = |waited: Option<Duration>, result: Result<()>| {
        assert!(waited.is_none_or(|waited| waited < QUICK), "{waited:?}");
        match result {
            Ok(()) => assert!(waited.is_none(), "it was stopped"),
            Err(failure) => assert_eq!((failure, begun.info()), (Failure::Cancelled, before)),
        }
        waited.is_some()
    };
    for _ in 0..2 {
        let (waited, result) = stopped(&mut random, Duration::ZERO, |go_on| begun.save(go_on));
        is_stopped(waited, result.map(drop));
        let (waited, result) = stopped(&mut random, Duration::ZERO, |go_on| begun.picture(go_on));
        assert!(
            is_stopped(waited, result.map(drop)),
            "a picture takes no longer than until the first question"
        );
    }
    let picture = shown(&begun);
    assert!(
        picture.radiance.len() == 1500 * 1500
            && picture.radiance.iter().all(|color| *color == glam::Vec3::ZERO)
    );
    // Kept: nobody is asked for it.
    assert!(Arc::ptr_eq(&begun.picture(&mut || panic!("asked")).expect("kept"), &picture));
}

#[test]
fn a_session_that_is_stopped_before_it_is_ready_lets_go_at_once() {
    let scene = sphere_in_fog(view(512));
    for milliseconds in [0, 5, 50, 1000] {
        let begun = Instant::now();
        let mut refused = None;
        let made = Session::new(std::slice::from_ref(&scene), options(0), &mut || {
            let goes_on = begun.elapsed() < Duration::from_millis(milliseconds);
            refused = (!goes_on).then(Instant::now);
            goes_on
        });
        if let Some(refused) = refused {
            assert!(refused.elapsed() < QUICK, "{:?}", refused.elapsed());
        }
        match made {
            Ok(session) => assert_eq!(session.info().passes, 0),
            Err(failure) => {
                assert_eq!(failure, Failure::Cancelled);
                assert!(refused.is_some());
            }
        }
    }
}
