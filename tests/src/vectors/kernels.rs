//! Phase functions, spectra, kernels and schedules.

use super::hard::Hard;
use super::words::Script;
use covbeam::{
    FluenceSpectrum, Kernel, KernelShape, PhaseFunction, PhaseKind, error_bound, progressive_radius,
};

pub(super) const SHAPES: [KernelShape; 3] =
    [KernelShape::Box, KernelShape::Epanechnikov, KernelShape::Biweight];

pub(super) fn write(script: &mut Script) {
    let hard = &mut Hard::new(2);
    script.comment("Phase functions");
    for kind in [PhaseKind::Isotropic, PhaseKind::HenyeyGreenstein, PhaseKind::Rayleigh] {
        for asymmetry in [0.0, 0.5, -0.999] {
            phases(script, hard, PhaseFunction { kind, asymmetry });
        }
    }
    for _ in 0..12 {
        let phase = hard.phase();
        phases(script, hard, phase);
    }
    script.comment("Spectra");
    for _ in 0..24 {
        spectra(script, hard);
    }
    script.comment("Kernels and schedules");
    for shape in SHAPES {
        script.call("kernel_second_moment", &[&shape], &[&shape.second_moment()]);
    }
    for _ in 0..24 {
        kernels(script, hard);
    }
}

fn phases(script: &mut Script, hard: &mut Hard, phase: PhaseFunction) {
    for cosine in [-1.0, 1.0, hard.between(-1.0, 1.0)] {
        script.call("phase_evaluate", &[&phase, &cosine], &[&phase.evaluate(cosine)]);
    }
    for xi in [0.0, hard.uniform()] {
        script.call("phase_sample_cosine", &[&phase, &xi], &[&phase.sample_cosine(xi)]);
    }
    for _ in 0..2 {
        let (direction, xi) = (hard.unit(), [hard.uniform(), hard.uniform()]);
        script.call("phase_sample", &[&phase, &direction, &xi], &[&phase.sample(direction, xi)]);
    }
    script.call("phase_angular_variance", &[&phase], &[&phase.angular_variance()]);
}

/// A covariance: a sum of what two axes and no more have.
pub(super) fn spectrum(hard: &mut Hard) -> FluenceSpectrum {
    let mut spectrum = FluenceSpectrum::default();
    for _ in 0..2 {
        let axis = hard.unit();
        spectrum.add_along(axis, hard.decades(-4.0, 4.0));
    }
    spectrum
}

fn spectra(script: &mut Script, hard: &mut Hard) {
    let (mut spectrum, axis) = (spectrum(hard), hard.unit());
    script.call("spectrum_variance_along", &[&spectrum, &axis], &[&spectrum.variance_along(axis)]);
    let (before, axis, variance) = (spectrum, hard.unit(), hard.decades(-6.0, 6.0));
    spectrum.add_along(axis, variance);
    script.call("spectrum_add_along", &[&before, &axis, &variance], &[&spectrum]);
}

fn kernels(script: &mut Script, hard: &mut Hard) {
    let shape = SHAPES[hard.below(3) as usize];
    let radius = hard.decades(-6.0, 4.0);
    let distance = radius * hard.between(-1.2, 1.2);
    script.call("kernel_evaluate", &[&shape, &distance, &radius], &[&shape.evaluate(distance, radius)]);
    let (error, variance) = (hard.decades(-6.0, 1.0), hard.extreme(-10.0, 20.0));
    let allowed = shape.radius_from_error(error, variance);
    script.call("kernel_radius_from_error", &[&shape, &error, &variance], &[&allowed]);
    let alpha = if hard.chance(0.2) { 1.0 } else { hard.between(0.01, 1.0) };
    // Beyond 4096 passes the radius is found in another way.
    let pass = hard.decades(0.0, 7.0) as u32;
    let min_radius = progressive_radius(radius, alpha, pass);
    script.call("progressive_radius", &[&radius, &alpha, &pass], &[&min_radius]);
    let bound = error_bound(error, pass);
    script.call("error_bound", &[&error, &pass], &[&bound]);
    let max_radius = radius * hard.decades(-2.0, 2.0);
    let max_radius = if max_radius > min_radius { max_radius } else { min_radius };
    let kernel = Kernel { shape, min_radius, max_radius, error: bound, grid: None };
    script.call("schedule_kernel", &[&shape, &radius, &alpha, &max_radius, &error, &pass], &[&kernel]);
}
