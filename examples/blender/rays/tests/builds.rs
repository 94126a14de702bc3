//! Builds on native threads, their end, and results that do not depend on how many threads there are.

mod shapes;

use covbeam::Edge;
use covbeam_rays::failure::Failure;
use covbeam_rays::geometry::Geometry;
use covbeam_rays::job::Job;
use covbeam_rays::records::HitRecord;
use covbeam_rays::tasks;
use glam::{DMat4, DVec3};
use rayon::ThreadPoolBuilder;
use shapes::{Random, add, alone, built, icosphere, lumpy, rows};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// What a caller does not notice.
const QUICK: Duration = Duration::from_millis(50);

#[test]
fn hits_and_edges_do_not_depend_on_the_number_of_threads() {
    let geometry = Geometry::default();
    let mesh = add(&geometry, &lumpy(4), 3, None);
    let mut random = Random(6);
    for object in 0..30 {
        geometry.add_instance(mesh, &rows(random.transform()), object, -1).expect("valid");
    }
    let scene = built(&geometry);
    let origins: Vec<[f32; 3]> = (0..20_000).map(|_| (8.0 * random.cube()).as_vec3().to_array()).collect();
    let directions: Vec<[f32; 3]> =
        (0..20_000).map(|_| random.direction().as_vec3().normalize().to_array()).collect();
    let found = [1, 2, 3, 7].map(|count| {
        let pool = ThreadPoolBuilder::new().num_threads(count).build().expect("starts");
        let mut hits = vec![HitRecord::MISS; origins.len()];
        pool.install(|| scene.cast_many(&origins, &directions, &[f32::INFINITY], &mut hits))
            .expect("valid rays");
        let (few, mut counts, mut edges) = (1000, [0; 1000], [[Edge::default(); 4]; 1000]);
        let search = || {
            let (origins, directions) = (&origins[..few], &directions[..few]);
            scene.edges_many(origins, directions, &hits[..few], &[0; 4], &mut counts, &mut edges)
        };
        pool.install(search).expect("valid rays");
        (hits, counts, edges)
    });
    let (hits, counts, _) = &found[0];
    assert!(hits.iter().filter(|hit| hit.object >= 0).count() > 2000);
    assert!(counts.iter().filter(|count| **count > 0).count() > 100);
    assert!(found[1..].iter().all(|others| *others == found[0]));
}

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
            assert!(matches!(geometry.scene().map(|_| ()), Err(Failure::Order(_))));
        }
        assert!(start.elapsed() < QUICK, "{:?}", start.elapsed());
    }
}

#[test]
fn a_job_that_panics_fails() {
    let job: Arc<Job<()>> = Job::start(|_, _| panic!("a broken job")).expect("starts");
    let failure = job.wait(Duration::from_secs(5)).expect("ends").expect_err("fails");
    assert_eq!(failure, Failure::Panicked("a defect of covbeam_rays: a broken job".into()));
    assert!(matches!(job.wait(Duration::ZERO), Some(Err(Failure::Order(_)))), "its result is given once");
}

#[test]
fn a_job_goes_on_until_it_is_stopped_and_blocks_nothing_else() {
    let job = Job::start(|pool, job: &Job<()>| {
        // On all its threads.
        pool.broadcast(|_| {
            while job.go_on().is_ok() {
                std::thread::sleep(Duration::from_millis(1));
            }
        });
        job.go_on()
    });
    let job = job.expect("starts");
    assert_eq!(job.wait(Duration::from_millis(20)), None);
    let start = Instant::now();
    alone(&icosphere(1), None, DMat4::from_translation(DVec3::X));
    assert!(start.elapsed() < QUICK, "{:?}", start.elapsed());
    job.stop();
    assert_eq!(job.wait(Duration::ZERO), Some(Err(Failure::Cancelled)));
    assert!(start.elapsed() < 2 * QUICK, "{:?}", start.elapsed());
}

#[test]
fn tasks_begin_in_their_order_and_each_runs_once() {
    for count in [1, 2, 3] {
        let pool = ThreadPoolBuilder::new().num_threads(count).build().expect("starts");
        let begun = Mutex::new(Vec::new());
        let task = |worker: usize, task: usize| {
            begun.lock().expect("whole").push((worker, task));
            std::thread::sleep(Duration::from_micros(200));
            Ok(())
        };
        let go_on = AtomicBool::new(false);
        pool.install(|| tasks::run(&pool, count, 100, &go_on, task)).expect("all are run");
        let begun = begun.into_inner().expect("whole");
        // Two threads that take their tasks at the same moment may note them the other way round.
        assert!(begun.iter().enumerate().all(|(i, (_, task))| i.abs_diff(*task) < count), "{begun:?}");
        assert!(begun.iter().all(|(worker, _)| *worker < count));
        let mut numbers: Vec<usize> = begun.iter().map(|(_, task)| *task).collect();
        numbers.sort_unstable();
        assert_eq!(numbers, (0..100).collect::<Vec<_>>());
    }
}

#[test]
fn the_first_task_that_fails_ends_the_others_and_so_does_the_flag() {
    let pool = ThreadPoolBuilder::new().num_threads(3).build().expect("starts");
    let ran = AtomicUsize::new(0);
    let fail_from_ten_on = |_: usize, task: usize| {
        ran.fetch_add(1, Ordering::Relaxed);
        // All that are at work when the first fails have failed, too.
        std::thread::sleep(Duration::from_millis(1));
        if task < 10 { Ok(()) } else { Err(Failure::Covbeam(task as i32, "no".into())) }
    };
    let go_on = AtomicBool::new(false);
    let result = pool.install(|| tasks::run(&pool, 3, 1000, &go_on, fail_from_ten_on));
    assert_eq!(result, Err(Failure::Covbeam(10, "no".into())));
    assert!(ran.load(Ordering::Relaxed) <= 13);

    let stop = AtomicBool::new(false);
    let stop_at_twenty = |_: usize, task: usize| {
        stop.fetch_or(task == 20, Ordering::Relaxed);
        Ok(())
    };
    let result = pool.install(|| tasks::run(&pool, 3, 1000, &stop, stop_at_twenty));
    assert_eq!(result, Err(Failure::Cancelled));
}
