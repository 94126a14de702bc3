/* Phase functions, kernels and schedules; numbers of light paths. */
#include "calls.h"

#include <string.h>

/* Numbers in and one out, after the kernel's shape. */
#define OF_SHAPE(name, made)          \
    void name(struct call *c)         \
    {                                 \
        uint32_t shape = take_u32(c); \
        float a[2], result;           \
        take(c, a, 2);                \
        must(made);                   \
        give(c, &result, 1);          \
    }
OF_SHAPE(kernel_evaluate, covbeam_kernel_evaluate(shape, a[0], a[1], &result))
OF_SHAPE(kernel_radius_from_error, covbeam_kernel_radius_from_error(shape, a[0], a[1], &result))

void phase_angular_variance(struct call *c)
{
    covbeam_phase phase;
    float variance;
    take(c, &phase, 2);
    must(covbeam_phase_angular_variance(&phase, &variance));
    give(c, &variance, 1);
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

void path_number(struct call *c)
{
    uint32_t seed = take_u32(c), sequence = take_u32(c), path = take_u32(c), dimension = take_u32(c);
    float number;
    must(covbeam_path_number(seed, sequence, path, dimension, &number));
    give(c, &number, 1);
}
