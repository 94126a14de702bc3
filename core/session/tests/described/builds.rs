//! Builds of geometry on native threads, and their end.

use crate::shapes::{add, built, hit, icosphere, lumpy, rows};
use covbeam_session::describe::geometry::Geometry;
use covbeam_session::work::failure::{Failure, Result};
use glam::{DMat4, Vec3};
use std::time::{Duration, Instant};

/// What a caller does not notice.
const QUICK: Duration = Duration::from_millis(50);

fn assert_order<T>(result: Result<T>) {
    match result {
        Err(Failure::Order(message)) => assert!(message.contains("make a new"), "{message}"),
        Err(other) => panic!("{other:?}"),
        Ok(_) => panic!("no failure"),
    }
}

#[test]
fn a_geometry_whose_build_is_stopped_lets_go_at_once() {
    let shape = lumpy(7);
    let geometry = Geometry::default();
    for _ in 0..4 {
        let mesh = add(&geometry, &shape, 0, None);
        geometry.add_instance(mesh, &rows(DMat4::IDENTITY), 0, -1).expect("valid");
    }
    let mut refused = None;
    let built = geometry.build(&mut || {
        refused = Some(Instant::now());
        false
    });
    let refused = refused.expect("a million triangles are built before anybody is asked");
    assert!(refused.elapsed() < QUICK, "{:?}", refused.elapsed());
    assert_eq!(built, Err(Failure::Cancelled));
    // It is of no more use.
    assert_order(geometry.built());
    assert_order(geometry.build(&mut || true));
    assert_order(geometry.add_instance(0, &rows(DMat4::IDENTITY), 0, -1));
}

#[test]
fn a_geometry_is_built_once_and_hit_afterwards_only() {
    let geometry = Geometry::default();
    let ball = icosphere(2);
    let mesh = add(&geometry, &ball, 0, None);
    geometry.add_instance(mesh, &rows(DMat4::IDENTITY), 7, -1).expect("valid");
    let Err(Failure::Order(message)) = geometry.built() else { panic!("it is not built yet") };
    assert!(message.contains("call build first"), "{message}");
    let scene = built(&geometry);
    assert_eq!(hit(&scene, Vec3::new(0.1, 0.2, -4.0), Vec3::Z).object, 7);
    assert_order(geometry.build(&mut || true));
    assert_order(geometry.add_instance(mesh, &rows(DMat4::IDENTITY), 0, -1));
    // What was built is there all the same.
    assert_eq!(geometry.built().expect("still built").triangle_count(), scene.triangle_count());
}
