//! Media: points and rays.

use super::hard::{Fog, Hard, Voxels};
use super::light::carry;
use super::words::Script;
use covbeam::{Column, Density, Knot, LightField, Medium, Vec3};

pub(super) fn write(script: &mut Script) {
    let hard = &mut Hard::new(3);
    script.comment("Media in closed form");
    for _ in 0..6 {
        let fog = Fog::homogeneous(medium(hard));
        medium_calls(script, hard, &fog);
    }
    for _ in 0..8 {
        let fog = Fog::exponential(medium(hard), hard.point(3.0), hard.direction(), hard.decades(-1.5, 3.0));
        medium_calls(script, hard, &fog);
    }
    script.comment("Media in voxels");
    for cells in [[1, 1, 1], [4, 3, 5], [1, 8, 2]] {
        let min = hard.point(1.0) - Vec3::splat(2.0);
        let max = min + Vec3::from_array([(); 3].map(|()| hard.between(1.0, 4.0)));
        let most = hard.decades(-1.0, 2.0);
        let voxels = Voxels::new(hard, min, max, cells, most);
        script.call("density_new", &[&voxels.layout, &voxels.values], &[]);
        for _ in 0..3 {
            let fog = Fog::voxels(medium(hard), &voxels);
            medium_calls(script, hard, &fog);
            let mut field = LightField::disk(hard.unit(), hard.unit(), 0.1, 1.0);
            for _ in 0..3 {
                carry(script, hard, &fog, &mut field);
            }
        }
    }
}

pub(super) fn medium(hard: &mut Hard) -> Medium<'static> {
    let mut coefficients = |none: f64| {
        if hard.chance(none) {
            Vec3::ZERO
        } else if hard.chance(0.3) {
            Vec3::splat(hard.decades(-2.0, 1.0))
        } else {
            Vec3::from_array([(); 3].map(|()| hard.decades(-2.0, 1.0)))
        }
    };
    let (scattering, absorption) = (coefficients(0.1), coefficients(0.5));
    Medium { scattering, absorption, phase: hard.phase(), more: &[], density: Density::Uniform }
}

fn medium_calls(script: &mut Script, hard: &mut Hard, fog: &Fog) {
    let (medium, density) = (&fog.medium, fog.density());
    script.call("medium_step", &[fog], &[&density.step()]);
    let opaque = medium.opaque_column();
    script.call("medium_opaque_column", &[fog], &[&opaque]);
    let column = hard.extreme(-4.0, 3.0);
    script.call("medium_column_transmittance", &[fog, &column], &[&medium.transmittance(column)]);
    for _ in 0..3 {
        let position = hard.point(3.0);
        script.call("medium_density_at", &[fog, &position], &[&density.at(position)]);
        script.call("medium_derivatives_at", &[fog, &position], &[&density.derivatives(position)]);
    }
    for _ in 0..3 {
        ray_calls(script, hard, fog, &density);
    }
}

fn ray_calls(script: &mut Script, hard: &mut Hard, fog: &Fog, density: &Density) {
    let medium = &fog.view();
    let (origin, direction, length) = (hard.point(3.0), hard.unit(), hard.extreme(-2.0, 2.0));
    let table = |length: f32, error: f32, most: f32| {
        let mut knots: Vec<Knot> = Vec::new();
        density.knots(origin, direction, length, error, most, &mut |knot| knots.push(knot));
        knots
    };
    let tabulated = |length: f32| {
        let mut knots: Vec<Knot> = Vec::new();
        medium.tabulate(origin, direction, length, &mut |knot| knots.push(knot));
        knots
    };

    let column = if fog.is_closed_form() {
        density.column(origin, direction, &[]).at(length)
    } else {
        table(length, f32::INFINITY, f32::INFINITY).last().map_or(0.0, |knot| knot.column)
    };
    script.call("medium_column_at", &[fog, &origin, &direction, &length], &[&column]);
    let left = medium.transmittance(column);
    script.call("medium_transmittance", &[fog, &origin, &direction, &length], &[&left]);

    let wanted = if hard.chance(0.5) { column.min(1e30) * hard.uniform() } else { hard.extreme(-2.0, 1.0) };
    let knots = table(length, 5e-4 * wanted, wanted);
    let flight = if fog.is_closed_form() {
        density.column(origin, direction, &[]).distance_at(wanted)
    } else {
        Column::Knots(&knots).distance_at(wanted)
    };
    let flight = if flight <= length { flight } else { f32::INFINITY };
    script.call("medium_distance_at", &[fog, &origin, &direction, &length, &wanted], &[&flight]);

    let whole = tabulated(f32::INFINITY);
    let reach = density.opaque_distance(origin, direction, medium.opaque_column(), &whole);
    script.call("medium_reach", &[fog, &origin, &direction], &[&reach]);

    let (error, most) = (hard.decades(-5.0, 0.0), hard.extreme(-2.0, 1.0));
    let knots = table(length, error, most);
    script.call("medium_knots", &[fog, &origin, &direction, &length, &error, &most], &[&knots]);
    script.call("medium_tabulate", &[fog, &origin, &direction, &length], &[&tabulated(length)]);
}
