//! Light fields: sources, then chains of events; the numbers of light paths.

use super::hard::{Fog, Hard};
use super::words::Script;
use covbeam::{LightField, Medium, Vec3, path_number};

pub(super) fn write(script: &mut Script) {
    script.comment("Light fields");
    let hard = &mut Hard::new(1);
    for chain in 0..68 {
        let mut field = source(script, hard, chain);
        for _ in 0..9 {
            event(script, hard, &mut field);
        }
        read(script, hard, &field);
    }
    for (seed, sequence, path) in [(0, 0, 0), (1, 2, 3), (0x1234_5678, 77, 0xdead_beef)] {
        for dimension in [0_u32, 1, 4, 7, 8, 9, 1000] {
            let number = path_number(seed, sequence, path, dimension);
            script.call("path_number", &[&seed, &sequence, &path, &dimension], &[&number]);
        }
    }
}

/// A source; the first of each kind are the singular ones.
fn source(script: &mut Script, hard: &mut Hard, chain: u32) -> LightField {
    let direction = hard.direction();
    match chain % 4 {
        0 => {
            let variance = hard.extreme(-6.0, 6.0);
            let field = LightField::point(direction, variance);
            script.call("light_field_point", &[&direction, &variance], &[&field]);
            field
        }
        1 => {
            let (normal, radius, variance) =
                (hard.normal(direction), hard.extreme(-5.0, 5.0), hard.extreme(-6.0, 6.0));
            let field = LightField::disk(direction, normal, radius, variance);
            script.call("light_field_disk", &[&direction, &normal, &radius, &variance], &[&field]);
            field
        }
        2 => {
            let radius = hard.extreme(-5.0, 5.0);
            let field = LightField::collimated(direction, radius);
            script.call("light_field_collimated", &[&direction, &radius], &[&field]);
            field
        }
        _ => {
            let x_axis = if hard.chance(0.1) { Vec3::ZERO } else { hard.direction() };
            let spatial = [hard.extreme(-8.0, 8.0), hard.extreme(-8.0, 8.0)];
            let angular = [hard.extreme(-8.0, 8.0), hard.extreme(-8.0, 8.0)];
            let field = LightField::gaussian(direction, x_axis, spatial, angular);
            script.call("light_field_gaussian", &[&direction, &x_axis, &spatial, &angular], &[&field]);
            field
        }
    }
}

fn event(script: &mut Script, hard: &mut Hard, field: &mut LightField) {
    let before = *field;
    match hard.below(14) {
        0 | 1 => {
            let distance = if hard.chance(0.1) { 0.0 } else { hard.signed(-4.0, 4.0) };
            field.travel(distance);
            script.call("light_field_travel", &[&before, &distance], &[field]);
        }
        2 => {
            let x_axis = hard.direction();
            field.rotate(x_axis);
            script.call("light_field_rotate", &[&before, &x_axis], &[field]);
        }
        3 => {
            let (normal, curvature) = (hard.normal(before.direction), hard.curvature());
            field.reflect(normal, &curvature);
            script.call("light_field_reflect", &[&before, &normal, &curvature], &[field]);
        }
        4 | 5 => {
            let (normal, curvature) = (hard.normal(before.direction), hard.curvature());
            let eta = if hard.chance(0.1) { 1.0 } else { hard.between(0.4, 2.5) };
            let passed = field.refract(normal, &curvature, eta);
            script.call("light_field_refract", &[&before, &normal, &curvature, &eta], &[&passed, field]);
        }
        6 | 7 => {
            let (towards_edge, distance) = (hard.normal(before.direction), hard.extreme(-5.0, 3.0));
            field.occlude(towards_edge, distance);
            script.call("light_field_occlude", &[&before, &towards_edge, &distance], &[field]);
        }
        8 => {
            let gradient = hard.decades(-4.0, 3.0) * hard.unit();
            let hessian = [(); 6].map(|()| hard.signed(-4.0, 3.0));
            field.attenuate(gradient, &hessian);
            script.call("light_field_attenuate", &[&before, &gradient, &hessian], &[field]);
        }
        9 => {
            let (across, variance) = (hard.normal(before.direction), hard.extreme(-6.0, 6.0));
            field.narrow(across, variance);
            script.call("light_field_narrow", &[&before, &across, &variance], &[field]);
        }
        10 => {
            let (direction, variance) = (hard.direction(), hard.extreme(-6.0, 4.0));
            field.scatter(direction, variance);
            script.call("light_field_scatter", &[&before, &direction, &variance], &[field]);
        }
        11 => {
            let (normal, direction) = (hard.normal(before.direction), hard.direction());
            field.diffuse(normal, direction);
            script.call("light_field_diffuse", &[&before, &normal, &direction], &[field]);
        }
        _ => {
            let medium = Medium { scattering: Vec3::splat(hard.decades(-3.0, 1.0)), ..Medium::default() };
            let fog = if hard.chance(0.3) {
                Fog::homogeneous(medium)
            } else {
                Fog::exponential(medium, hard.point(1.0), hard.direction(), hard.decades(-1.0, 2.0))
            };
            carry(script, hard, &fog, field);
        }
    }
}

/// A light field on its way through a medium.
pub(super) fn carry(script: &mut Script, hard: &mut Hard, fog: &Fog, field: &mut LightField) {
    let (before, origin, distance) = (*field, hard.point(2.0), hard.decades(-3.0, 1.0));
    field.travel_through(&fog.view(), origin, distance);
    script.call("light_field_carry", &[&before, fog, &origin, &distance], &[field]);
}

fn read(script: &mut Script, hard: &mut Hard, field: &LightField) {
    script.call("light_field_slice", &[field], &[&field.slice()]);
    let limit = if hard.chance(0.2) { f32::INFINITY } else { hard.decades(-3.0, 6.0) };
    script.call("light_field_fluence", &[field, &limit], &[&field.fluence_within(limit)]);
    let extinction = if hard.chance(0.3) { 0.0 } else { hard.decades(-3.0, 2.0) };
    let along = field.variance_along_ray(extinction);
    script.call("light_field_variance_along_ray", &[field, &extinction], &[&along]);
}
