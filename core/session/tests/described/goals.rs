//! Goals of sessions: when they are reached, what is kept of a stopped one, and that calls come one at a time.

use crate::scenes::{QUICK, assert_same, fill, options, picture, session, shown, sphere_in_fog, view};
use covbeam_session::film::Picture;
use covbeam_session::film::passes::PassRange;
use covbeam_session::render::{End, Goal};
use covbeam_session::scene::{Scene, Sees};
use covbeam_session::session::{Options, Session};
use covbeam_session::settings::{Layers, Settings};
use covbeam_session::work::failure::{Failure, Result};
use glam::Vec3;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Nothing is reached: only the caller ends it.
const NEVER: Goal = Goal { passes: None, time: None, error: None };

fn scene() -> Arc<Scene> {
    sphere_in_fog(view(16))
}

/// Without the pilot, which says nothing about goals and takes most of the time.
fn unguided(photons: u32) -> Options {
    let options = options(photons);
    Options { settings: Settings { guided: false, ..options.settings }, ..options }
}

fn made(photons: u32) -> Session {
    session(&scene(), unguided(photons))
}

fn until(session: &Session, goal: Goal) -> End {
    session.until(goal, &mut || true).expect("no failure")
}

fn passes(count: u32) -> Goal {
    Goal { passes: Some(count), ..NEVER }
}

#[track_caller]
fn assert_passes(session: &Session, count: u32) {
    assert_eq!(session.passes().ranges(), [PassRange { start: 0, end: count }]);
    assert_eq!(session.info().passes, count);
}

#[test]
fn passes_until_a_goal_are_those_that_are_asked_for_one_by_one() {
    let (goals, one_by_one) = (made(1000), made(1000));
    assert_eq!(until(&goals, passes(3)), End::Reached);
    assert_passes(&goals, 3);
    assert_same(&shown(&goals), &picture(&one_by_one, 3));
    // Reached already.
    assert_eq!(until(&goals, passes(2)), End::Reached);
    assert_passes(&goals, 3);
    fill(&goals, 4);
    assert_eq!(until(&goals, passes(5)), End::Reached);
    assert_same(&shown(&goals), &picture(&one_by_one, 5));
    let info = goals.info();
    assert!(info.times.total() > 0.0 && info.picture > 0.0 && info.times.pairs > 0, "{info:?}");
    assert_eq!(info.times.pairs, one_by_one.info().times.pairs);
}

/// Median of the lit pixels' standard error over their luminance, of Rec. 709.
fn median(picture: &Picture) -> f64 {
    let errors = picture.error.as_ref().expect("two halves of the passes");
    let luminance = |color: &Vec3| color.as_dvec3().dot(glam::DVec3::new(0.2126, 0.7152, 0.0722));
    let lit = picture.radiance.iter().zip(errors).filter(|(color, _)| luminance(color) > 0.0);
    let mut relative: Vec<f64> = lit.map(|(color, error)| f64::from(*error) / luminance(color)).collect();
    relative.sort_by(f64::total_cmp);
    relative[relative.len() / 2]
}

#[test]
fn passes_go_on_until_the_error_is_small_enough_or_something_else_ends_them() {
    let begun = made(200);
    let before = median(&picture(&begun, 4));
    let goal = 0.6 * before;
    assert_eq!(until(&begun, Goal { error: Some(goal), ..NEVER }), End::Reached);
    // Roundings of single precision.
    assert!(median(&shown(&begun)) <= goal * (1.0 + 1e-5), "{} after {before}", median(&shown(&begun)));
    let reached = begun.info().passes;
    // Errors fall as the root of the passes, give or take a factor of 2.
    assert!((5..=45).contains(&reached), "{reached} passes");
    let end = until(&begun, Goal { error: Some(1e-6), ..passes(reached + 2) });
    assert_eq!((end, begun.info().passes), (End::NotReached, reached + 2));
}

#[test]
fn a_time_that_is_over_cuts_a_pass() {
    let (begun, time) = (made(1000), Duration::from_millis(250));
    // One pass is always made.
    assert_eq!(until(&begun, Goal { time: Some(Duration::ZERO), ..NEVER }), End::Reached);
    assert_passes(&begun, 1);
    let start = Instant::now();
    assert_eq!(until(&begun, Goal { time: Some(time), ..NEVER }), End::Reached);
    let elapsed = start.elapsed();
    assert!(elapsed >= time && elapsed < time + QUICK, "{elapsed:?}");
    let done = begun.info().passes;
    assert!(done > 1);
    assert_same(&picture(&begun, done + 1), &picture(&made(1000), done + 1));
}

#[test]
fn passes_that_were_done_before_a_goal_was_given_up_are_kept() {
    let begun = made(5000);
    let end = begun.until(NEVER, &mut || false);
    assert_eq!(end, Ok(End::Cancelled));
    let asked = &mut 0;
    let end = begun.until(NEVER, &mut || {
        *asked += 1;
        // What is done is seen at once.
        begun.info().passes < 3
    });
    assert_eq!(end, Ok(End::Cancelled));
    assert!(*asked > 0);
    let kept = begun.info().passes;
    assert!(kept >= 3);
    assert_passes(&begun, kept);
    // None comes later.
    std::thread::sleep(Duration::from_millis(50));
    assert_passes(&begun, kept);
    assert_same(&picture(&begun, kept + 1), &picture(&made(5000), kept + 1));
}

#[test]
fn a_session_that_is_begun_anew_holds_nothing_and_renders_the_same() {
    let begun = made(1000);
    let is_too_early =
        |result: Result<()>| matches!(result, Err(Failure::Order(message)) if message.contains("render one"));
    let is_empty = || {
        assert!(begun.passes().ranges().is_empty() && begun.info().passes == 0);
        assert!(is_too_early(begun.picture(&mut || true).map(drop)));
        assert!(is_too_early(begun.save(&mut || true).map(drop)));
    };
    is_empty();
    assert_eq!(begun.size(), [16, 16]);
    assert_eq!(until(&begun, passes(2)), End::Reached);
    let first = shown(&begun);
    begun.restart(1000, false).expect("nothing goes on");
    is_empty();
    assert_eq!(until(&begun, passes(2)), End::Reached);
    assert_same(&shown(&begun), &first);
}

#[test]
fn a_dark_scene_gives_black_pictures() {
    let lit = scene();
    let unlit = Scene { lights: Vec::new(), ..lit.as_ref().clone() };
    // Light that meets no fog is not seen where fog alone is.
    let clear = Scene { media: Vec::new(), outside: None, sees: Sees::FogAlone, ..lit.as_ref().clone() };
    for scene in [unlit, clear].map(Arc::new) {
        for layers in [Layers::Together, Layers::EachKind] {
            let settings = Settings { layers, ..options(500).settings };
            let [begun, other] =
                [0, 64].map(|first_pass| session(&scene, Options { settings, first_pass, ..options(500) }));
            assert_eq!(until(&begun, passes(2)), End::Reached);
            assert_eq!(until(&begun, Goal { error: Some(0.1), ..NEVER }), End::Dark);
            assert_passes(&begun, 64);
            fill(&other, 1);
            begun.merge(&other.save(&mut || true).expect("sums"), &mut || true).expect("of the same picture");
            assert_passes(&begun, 65);
            let picture = shown(&begun);
            assert_eq!(picture.radiance, vec![Vec3::ZERO; 256]);
            let count = if layers == Layers::EachKind { 3 } else { 0 };
            assert_eq!(picture.kinds.len(), count);
            assert!(picture.kinds.iter().all(|(_, colors)| *colors == picture.radiance));
        }
    }
}

#[test]
fn a_call_from_within_a_call_is_told_that_the_session_is_busy() {
    let begun = made(5000);
    fill(&begun, 1);
    let sums = begun.save(&mut || true).expect("sums");
    let is_busy =
        |result: Result<()>| matches!(result, Err(Failure::Busy(message)) if message.contains("busy"));
    let mut answers = Vec::new();
    let end = begun.until(NEVER, &mut || {
        let go_on = &mut || panic!("asked");
        answers = vec![
            is_busy(begun.pass(go_on)),
            is_busy(begun.until(passes(1), go_on).map(drop)),
            is_busy(begun.picture(go_on).map(drop)),
            is_busy(begun.save(go_on).map(drop)),
            is_busy(begun.merge(&sums, go_on)),
            is_busy(begun.restart(1, true)),
        ];
        // What only looks is answered.
        answers.push(begun.info().passes >= 1 && begun.passes().count() >= 1);
        false
    });
    assert_eq!((end, answers), (Ok(End::Cancelled), vec![true; 7]));
    let done = begun.info().passes;
    assert_same(&picture(&begun, done + 1), &picture(&made(5000), done + 1));
}

#[test]
fn a_go_on_that_panics_stops_what_goes_on() {
    let begun = made(20_000);
    // Nobody is told of it: what is written of a panic takes longer than a pass.
    let thrown = catch_unwind(AssertUnwindSafe(|| begun.pass(&mut || resume_unwind(Box::new("a panic")))));
    assert!(thrown.is_err());
    assert_eq!(begun.info().passes, 0);
    assert_same(&picture(&begun, 1), &picture(&made(20_000), 1));
}
