//! Curvature under transforms against spheres and ellipsoids.

use crate::shapes::{Random, alone, hit, icosphere};
use covbeam_geometry::hit::Hit;
use glam::{DMat3, DMat4, DVec3, Vec3};

/// The curvature tensor of a hit in world axes.
fn tensor(hit: &Hit) -> DMat3 {
    let normal = hit.normal.as_dvec3();
    let tangent = hit.curvature.tangent.as_dvec3();
    let across = normal.cross(tangent);
    let outer = |a: DVec3, b: DVec3| DMat3::from_cols(a * b.x, a * b.y, a * b.z);
    let mixed = outer(tangent, across) + outer(across, tangent);
    f64::from(hit.curvature.along) * outer(tangent, tangent)
        + f64::from(hit.curvature.across) * outer(across, across)
        + f64::from(hit.curvature.twist) * mixed
}

/// The normal and the curvature tensor of the ellipsoid |M⁻¹ p| = 1: with f = |M⁻¹ p|², the projected Hessian over the
/// length of the gradient.
fn ellipsoid(matrix: DMat3, p: DVec3) -> (DVec3, DMat3) {
    let inverse = matrix.inverse();
    let hessian = inverse.transpose() * inverse;
    let gradient = hessian * p;
    let normal = gradient.normalize();
    let project = DMat3::IDENTITY - DMat3::from_cols(normal * normal.x, normal * normal.y, normal * normal.z);
    (normal, project * hessian * project * (1.0 / gradient.length()))
}

fn size(m: DMat3) -> f64 {
    m.to_cols_array().iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Largest relative errors of normal and curvature tensor over hits of an icosphere under a linear transform.
fn errors(levels: u32, matrix: DMat3, at: DVec3) -> (f64, f64) {
    let shape = icosphere(levels);
    let normals = shape.radial_normals();
    let scene = alone(&shape, Some(&normals), DMat4::from_translation(at) * DMat4::from_mat3(matrix));
    let mut random = Random(4);
    let (mut of_normal, mut of_curvature) = (0.0f64, 0.0f64);
    for _ in 0..500 {
        let direction = random.direction().as_vec3().normalize();
        let hit = hit(&scene, at.as_vec3(), direction);
        let on_unit = (matrix.inverse() * (hit.position.as_dvec3() - at)).normalize();
        let (normal, expected) = ellipsoid(matrix, matrix * on_unit);
        of_normal = of_normal.max(hit.normal.as_dvec3().distance(normal));
        of_curvature = of_curvature.max(size(tensor(&hit) - expected) / size(expected));
    }
    (of_normal, of_curvature)
}

#[test]
fn curvature_under_any_transform_approaches_the_ellipsoids() {
    let sheared = DMat3::from_cols(DVec3::new(1.0, 0.2, 0.0), DVec3::new(-0.4, 1.3, 0.1), DVec3::Z * 0.7);
    let cases = [
        ("sphere", DMat3::IDENTITY, DVec3::ZERO),
        ("sphere of radius 1/50 at 3", DMat3::from_diagonal(DVec3::splat(0.02)), DVec3::new(3.0, 0.0, 0.0)),
        ("sphere of radius 1e4 at 1e5", DMat3::from_diagonal(DVec3::splat(1e4)), DVec3::splat(6e4)),
        ("mirrored sphere", DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)), DVec3::ZERO),
        ("ellipsoid", DMat3::from_diagonal(DVec3::new(1.0, 2.0, 0.5)), DVec3::ZERO),
        ("mirrored ellipsoid", DMat3::from_diagonal(DVec3::new(1.0, -2.0, 0.7)), DVec3::ZERO),
        ("sheared ellipsoid", sheared, DVec3::new(0.0, 2.0, 0.0)),
    ];
    for (name, matrix, at) in cases {
        let [coarse, fine] = [3, 5].map(|levels| errors(levels, matrix, at));
        // Edges a quarter as long: normals interpolated linearly err by h², curvature of flat triangles by h at
        // worst, which leaves a factor of 4; two thirds of it are asked for.
        assert!(fine.1 < 0.4 * coarse.1, "{name}: {coarse:?} {fine:?}");
        // Edges of 0.04, on the ellipsoids under the largest curvature, 4, and its change.
        assert!(fine.0 < 0.01 && fine.1 < 0.1, "{name}: {fine:?}");
    }
}

#[test]
fn a_bowl_is_concave_and_a_facet_flat() {
    // The same sphere seen from inside: triangles and normals turned.
    let mut bowl = icosphere(4);
    bowl.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    let mut normals = bowl.radial_normals();
    normals.iter_mut().flatten().flatten().for_each(|x| *x = -*x);
    let scene = alone(&bowl, Some(&normals), DMat4::from_scale(DVec3::splat(2.0)));
    let bent = hit(&scene, Vec3::ZERO, Vec3::new(0.6, 0.0, 0.8));
    // The flatness of the triangles, of edges 0.08.
    let curvature = bent.curvature;
    assert!((curvature.along + 0.5).abs() < 0.02 && (curvature.across + 0.5).abs() < 0.02, "{bent:?}");
    let scene = alone(&bowl, None, DMat4::IDENTITY);
    let hit = hit(&scene, Vec3::ZERO, Vec3::new(0.6, 0.0, 0.8));
    assert_eq!((hit.curvature.along, hit.curvature.across, hit.curvature.twist), (0.0, 0.0, 0.0));
    assert_eq!(hit.normal, hit.geometric_normal);
}
