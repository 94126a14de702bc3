//! Meshes and instances.

use super::*;

#[test]
fn meshes_that_are_wrong_are_refused_with_what_is_wrong_and_where() {
    let geometry = geometry();
    let with = |index: usize, value: [f32; 3]| {
        let mut positions = POSITIONS;
        positions[index] = value;
        positions
    };
    refused(
        add(geometry, &with(2, [0.0, f32::NAN, 0.0]), &TRIANGLES, &[0], None),
        COVBEAM_INVALID_VALUE,
        &["positions[2]", "finite"],
    );
    refused(
        add(geometry, &with(3, [2e9, 0.0, 0.0]), &TRIANGLES, &[0], None),
        COVBEAM_INVALID_VALUE,
        &["positions[3]", "1e9"],
    );
    refused(
        add(geometry, &POSITIONS, &[[0, 1, 2], [0, 1, 4]], &[0], None),
        COVBEAM_INVALID_VALUE,
        &["triangles[1]", "0 to 4 - 1"],
    );
    refused(
        add(geometry, &POSITIONS, &[[0, 1, -1]], &[0], None),
        COVBEAM_INVALID_VALUE,
        &["triangles[0]", "-1"],
    );
    refused(
        add(geometry, &POSITIONS, &TRIANGLES, &[0, 1, 2], None),
        COVBEAM_INVALID_VALUE,
        &["materials", "3", "2 triangles"],
    );
    refused(add(geometry, &POSITIONS, &TRIANGLES, &[], None), COVBEAM_INVALID_VALUE, &["materials: 0"]);
    let up = [0.0, 0.0, 1.0];
    for wrong in [[0.0, 0.0, 0.9], [0.0; 3], [f32::NAN, 0.0, 0.0], [f32::INFINITY, 0.0, 0.0]] {
        let normals = [[up; 3], [up, up, wrong]];
        let status = add(geometry, &POSITIONS, &TRIANGLES, &[0], Some(&normals));
        refused(status, COVBEAM_INVALID_VALUE, &["normals[1, 2]", "length 1"]);
    }
    let given = mesh(&POSITIONS, &TRIANGLES, &[0], None);
    let add = |change: &dyn Fn(&mut covbeam_mesh)| {
        let mut given = given;
        change(&mut given);
        // SAFETY: what is wrong is refused before it is looked at.
        unsafe { covbeam_geometry_add_mesh(geometry, &given, null_mut()) }
    };
    let (null_pointer, misaligned) = (COVBEAM_NULL_POINTER, COVBEAM_MISALIGNED);
    refused(add(&|given| given.positions = null()), null_pointer, &["positions", "NULL"]);
    refused(add(&|given| given.triangles = null()), null_pointer, &["triangles", "NULL"]);
    refused(
        add(&|given| given.positions = given.positions.wrapping_byte_add(2)),
        misaligned,
        &["positions", "multiple of 4"],
    );
    for count in [usize::MAX / 2, usize::MAX] {
        refused(
            add(&|given| given.position_count = count),
            COVBEAM_INVALID_ARRAY,
            &["positions", "more than memory"],
        );
    }
    refused(add(&|given| given.struct_size = 4), COVBEAM_INVALID_VALUE, &["mesh", "struct_size is 4"]);
    // SAFETY: what is misaligned is not written to.
    let status =
        unsafe { covbeam_geometry_add_mesh(geometry, &given, null_mut::<usize>().wrapping_byte_add(1)) };
    refused(status, misaligned, &["dropped"]);
    // None of them has become a mesh.
    refused(place(geometry, 0, IDENTITY), COVBEAM_INVALID_VALUE, &["instances[0].mesh: 0", "there are 0"]);
    // SAFETY: a live handle.
    assert_eq!(unsafe { covbeam_geometry_free(geometry) }, COVBEAM_OK);
}

#[test]
fn transforms_that_are_wrong_are_refused() {
    let geometry = geometry();
    assert_eq!(add(geometry, &POSITIONS, &TRIANGLES, &[0], None), COVBEAM_OK);
    let changed = |changes: &[(usize, f64)]| {
        let mut matrix = IDENTITY;
        changes.iter().for_each(|&(index, value)| matrix[index] = value);
        place(geometry, 0, matrix)
    };
    refused(changed(&[(3, f64::NAN)]), COVBEAM_INVALID_VALUE, &["matrix", "not finite"]);
    refused(changed(&[(0, f64::INFINITY)]), COVBEAM_INVALID_VALUE, &["matrix", "not finite"]);
    refused(changed(&[(12, 0.5)]), COVBEAM_INVALID_VALUE, &["matrix", "last row", "affine"]);
    refused(changed(&[(10, 0.0)]), COVBEAM_INVALID_VALUE, &["matrix", "flattens", "leave"]);
    // Two columns of the same direction, and a size whose inverse is beyond double precision.
    refused(changed(&[(5, 0.0), (1, 1.0)]), COVBEAM_INVALID_VALUE, &["matrix", "flattens"]);
    refused(
        changed(&[(0, 1e-310), (5, 1e-310), (10, 1e-310)]),
        COVBEAM_INVALID_VALUE,
        &["matrix", "flattens"],
    );
    refused(changed(&[(3, 2e9)]), COVBEAM_INVALID_VALUE, &["matrix", "1e9"]);
    // SAFETY: a live handle.
    let status = unsafe { covbeam_geometry_add_instances(geometry, 1, null(), 0) };
    refused(status, COVBEAM_NULL_POINTER, &["instances: NULL"]);
    refused(place(geometry, 1, IDENTITY), COVBEAM_INVALID_VALUE, &["mesh: 1"]);
    // Small and thin is fine.
    assert_eq!(changed(&[(0, 1e-9), (5, 1e-9), (10, 1e-3)]), COVBEAM_OK, "{}", message());
    // SAFETY: a live handle.
    assert_eq!(unsafe { covbeam_geometry_free(geometry) }, COVBEAM_OK);
}
