/* Phase functions, spectra, kernels and schedules. */
#include "calls.h"

#include <string.h>

/* Numbers in and one out, after a phase function, a spectrum or a shape. */
#define AFTER(type, given, size, name, words, made) \
    void name(struct call *c)                       \
    {                                               \
        type given;                                 \
        float a[words], result;                     \
        take(c, &given, size);                      \
        take(c, a, words);                          \
        must(made);                                 \
        give(c, &result, 1);                        \
    }
AFTER(covbeam_phase, phase, 2, phase_evaluate, 1, covbeam_phase_evaluate(&phase, a[0], &result))
AFTER(covbeam_phase, phase, 2, phase_sample_cosine, 1, covbeam_phase_sample_cosine(&phase, a[0], &result))
AFTER(covbeam_spectrum, s, 6, spectrum_variance_along, 3, covbeam_spectrum_variance_along(&s, a, &result))
AFTER(uint32_t, shape, 1, kernel_evaluate, 2, covbeam_kernel_evaluate(shape, a[0], a[1], &result))
AFTER(uint32_t, shape, 1, kernel_radius_from_error, 2,
      covbeam_kernel_radius_from_error(shape, a[0], a[1], &result))

void phase_sample(struct call *c)
{
    covbeam_phase phase;
    float direction[3], xi[2], scattered[3];
    take(c, &phase, 2);
    take(c, direction, 3);
    take(c, xi, 2);
    must(covbeam_phase_sample(&phase, direction, xi, scattered));
    give(c, scattered, 3);
}

void phase_angular_variance(struct call *c)
{
    covbeam_phase phase;
    float variance;
    take(c, &phase, 2);
    must(covbeam_phase_angular_variance(&phase, &variance));
    give(c, &variance, 1);
}

void spectrum_add_along(struct call *c)
{
    covbeam_spectrum spectrum;
    float axis[3];
    take(c, &spectrum, 6);
    take(c, axis, 3);
    must(covbeam_spectrum_add_along(&spectrum, axis, take_float(c)));
    give(c, &spectrum, 6);
}

void kernel_second_moment(struct call *c)
{
    float moment;
    must(covbeam_kernel_second_moment(take_u32(c), &moment));
    give(c, &moment, 1);
}

void progressive_radius(struct call *c)
{
    float a[2], result;
    take(c, a, 2);
    must(covbeam_progressive_radius(a[0], a[1], take_u32(c), &result));
    give(c, &result, 1);
}

void error_bound(struct call *c)
{
    float error = take_float(c), result;
    must(covbeam_error_bound(error, take_u32(c), &result));
    give(c, &result, 1);
}

void schedule_kernel(struct call *c)
{
    covbeam_schedule schedule;
    covbeam_kernel kernel;
    memset(&kernel, 0, sizeof kernel);
    kernel.struct_size = sizeof kernel;
    schedule.struct_size = sizeof schedule;
    take(c, &schedule.shape, 5);
    must(covbeam_schedule_kernel(&schedule, take_u32(c), &kernel));
    give(c, &kernel.shape, 4);
}

void kernel_radius_at(struct call *c)
{
    covbeam_grid *used = take_u32(c) ? grid : NULL;
    covbeam_kernel kernel = take_kernel(c);
    float position[3], axis[3], result[2], radii[2], sigmas[4];
    take(c, position, 3);
    take(c, axis, 3);
    must(covbeam_kernel_radius_at(&kernel, used, position, axis, &result[0], &result[1]));
    give(c, result, 2);
    must(covbeam_kernel_radius_at_many(&kernel, used, 2, position, 0, axis, 0, radii, 4, sigmas, 8));
    equal(&radii[1], &result[0], 4, "covbeam_kernel_radius_at_many: another radius");
    equal(&sigmas[2], &result[1], 4, "covbeam_kernel_radius_at_many: another sigma");
}
