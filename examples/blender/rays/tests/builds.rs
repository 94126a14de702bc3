//! Work on native threads, and its end.

mod shapes;

use covbeam_rays::failure::Failure;
use covbeam_rays::geometry::Geometry;
use covbeam_rays::job::Job;
use glam::DMat4;
use shapes::{add, lumpy, rows};
use std::sync::{Arc, Barrier};
use std::time::{Duration, Instant};

/// What a caller does not notice.
const QUICK: Duration = Duration::from_millis(50);

#[test]
fn a_geometry_that_is_dropped_while_it_is_built_lets_go_at_once() {
    let shape = lumpy(7);
    for stop_by_drop in [false, true] {
        let geometry = Geometry::default();
        for _ in 0..4 {
            let mesh = add(&geometry, &shape, 0, None);
            geometry.add_instance(mesh, &rows(DMat4::IDENTITY), 0, -1).expect("valid");
        }
        geometry.build().expect("starts");
        assert_eq!(
            geometry.wait(Duration::from_millis(5)),
            Ok(false),
            "a million triangles are built in 5 ms"
        );
        let start = Instant::now();
        if stop_by_drop {
            drop(geometry);
        } else {
            geometry.cancel();
            assert!(matches!(geometry.wait(Duration::ZERO), Err(Failure::Order(_))));
            assert!(matches!(geometry.built().map(|_| ()), Err(Failure::Order(_))));
        }
        assert!(start.elapsed() < QUICK, "{:?}", start.elapsed());
    }
}

#[test]
fn a_job_that_panics_fails() {
    let job = Job::<()>::default();
    assert!(!job.run(|| panic!("a broken job")));
    let failure = job.wait(Duration::ZERO).expect("ended").expect_err("fails");
    assert_eq!(failure, Failure::Panicked("a defect of covbeam_rays: a broken job".into()));
    assert!(matches!(job.wait(Duration::ZERO), Some(Err(Failure::Order(_)))), "its result is given once");
}

#[test]
fn a_job_that_is_cancelled_is_not_waited_for_unless_it_is_closing() {
    for is_closing in [false, true] {
        let job = Arc::<Job<()>>::default();
        let (running, started) = (Arc::clone(&job), Arc::new(Barrier::new(2)));
        let begun = Arc::clone(&started);
        let thread = std::thread::spawn(move || {
            running.run(|| {
                if is_closing {
                    running.close()?;
                }
                begun.wait();
                std::thread::sleep(2 * QUICK);
                if is_closing { Ok(()) } else { running.close() }
            })
        });
        started.wait();
        assert_eq!(job.wait(Duration::from_millis(1)), None);
        let start = Instant::now();
        job.cancel();
        assert_eq!(start.elapsed() < QUICK, !is_closing, "{:?}", start.elapsed());
        assert!(thread.join().expect("no panic"));
        // What was closed in time counts; what was not has done nothing.
        let expected = if is_closing { Ok(()) } else { Err(Failure::Cancelled) };
        assert_eq!(job.wait(Duration::ZERO), Some(expected));
    }
}
