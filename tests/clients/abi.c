/*
 * The layout of every public struct, the values of every enum and the versions, as numbers. Their twin is ffi/src/layout.rs: what
 * differs between the compilers of host and library fails to compile here or there.
 *
 *     abi VERSION        the version that covbeam_version() must give
 */
#include <covbeam.h>

#include <stdio.h>
#include <string.h>

#if __STDC_VERSION__ >= 201112L
#define ASSERT(name, claim) _Static_assert(claim, #claim)
#define ALIGNMENT(type) _Alignof(type)
#else
/* An array of a negative length does not compile. */
#define ASSERT(name, claim) typedef char assert_##name[(claim) ? 1 : -1]
#define ALIGNMENT(type) offsetof(struct { char first; type second; }, second)
#endif

#define SIZE(type, bytes, alignment)                                    \
    ASSERT(size_of_##type, sizeof(covbeam_##type) == (bytes));          \
    ASSERT(alignment_of_##type, ALIGNMENT(covbeam_##type) == (alignment))
#define AT(type, field, offset) ASSERT(type##_##field, offsetof(covbeam_##type, field) == (offset))
#define VALUE(name, value) ASSERT(name, COVBEAM_##name == (value))

ASSERT(pointers, sizeof(void *) == 8 && sizeof(size_t) == 8);
ASSERT(functions, sizeof(covbeam_poll) == 8 && sizeof(covbeam_shade) == 8 && sizeof(covbeam_probe) == 8);

SIZE(light_field, 64, 4);
AT(light_field, root, 0);
AT(light_field, x_axis, 40);
AT(light_field, direction, 52);

SIZE(curvature, 24, 4);
AT(curvature, tangent, 0);
AT(curvature, along, 12);
AT(curvature, across, 16);
AT(curvature, twist, 20);

SIZE(spectrum, 24, 4);
AT(spectrum, xx, 0);
AT(spectrum, yy, 4);
AT(spectrum, zz, 8);
AT(spectrum, xy, 12);
AT(spectrum, xz, 16);
AT(spectrum, yz, 20);

SIZE(grid_layout, 36, 4);
AT(grid_layout, min, 0);
AT(grid_layout, max, 12);
AT(grid_layout, cells, 24);

SIZE(grid_cell, 56, 8);
AT(grid_cell, sum, 0);
AT(grid_cell, weight, 48);

SIZE(fluence_cell, 28, 4);
AT(fluence_cell, spectrum, 0);
AT(fluence_cell, weight, 24);

SIZE(knot, 8, 4);
AT(knot, distance, 0);
AT(knot, column, 4);

SIZE(edge, 20, 4);
AT(edge, depth, 0);
AT(edge, distance, 4);
AT(edge, towards, 8);

SIZE(probe_hit, 20, 4);
AT(probe_hit, distance, 0);
AT(probe_hit, normal, 4);
AT(probe_hit, offset, 16);

SIZE(segment, 192, 8);
AT(segment, origin, 0);
AT(segment, length, 12);
AT(segment, power, 16);
AT(segment, unscattered, 20);
AT(segment, field, 24);
AT(segment, edges, 88);
AT(segment, edge_count, 168);
AT(segment, knots, 176);
AT(segment, knot_count, 184);

SIZE(phase, 8, 4);
AT(phase, kind, 0);
AT(phase, asymmetry, 4);

SIZE(medium, 80, 8);
AT(medium, struct_size, 0);
AT(medium, scattering, 4);
AT(medium, absorption, 16);
AT(medium, phase, 28);
AT(medium, density, 36);
AT(medium, origin, 40);
AT(medium, up, 52);
AT(medium, scale_height, 64);
AT(medium, voxels, 72);

SIZE(column, 32, 8);
AT(column, kind, 0);
AT(column, density, 4);
AT(column, rate, 8);
AT(column, knots, 16);
AT(column, knot_count, 24);

SIZE(derivatives, 36, 4);
AT(derivatives, gradient, 0);
AT(derivatives, hessian, 12);

SIZE(beam, 64, 4);
AT(beam, origin, 0);
AT(beam, direction, 12);
AT(beam, length, 24);
AT(beam, power, 28);
AT(beam, start_normal, 40);
AT(beam, end_normal, 52);

SIZE(eye_ray, 28, 4);
AT(eye_ray, origin, 0);
AT(eye_ray, direction, 12);
AT(eye_ray, length, 24);

SIZE(gathered, 28, 4);
AT(gathered, radiance, 0);
AT(gathered, pairs, 12);
AT(gathered, weight, 16);
AT(gathered, radius, 20);
AT(gathered, sigma, 24);

SIZE(crossing, 28, 4);
AT(crossing, ray_distance, 0);
AT(crossing, beam_distance, 4);
AT(crossing, gap, 8);
AT(crossing, sin_theta, 12);
AT(crossing, axis, 16);

SIZE(contact, 44, 4);
AT(contact, position, 0);
AT(contact, ray, 12);
AT(contact, beam, 16);
AT(contact, ray_distance, 20);
AT(contact, beam_distance, 24);
AT(contact, cos_theta, 28);
AT(contact, kernel, 32);
AT(contact, radius, 36);
AT(contact, sigma, 40);

SIZE(kernel, 20, 4);
AT(kernel, struct_size, 0);
AT(kernel, shape, 4);
AT(kernel, min_radius, 8);
AT(kernel, max_radius, 12);
AT(kernel, error, 16);

SIZE(schedule, 24, 4);
AT(schedule, struct_size, 0);
AT(schedule, shape, 4);
AT(schedule, radius, 8);
AT(schedule, alpha, 12);
AT(schedule, max_radius, 16);
AT(schedule, error, 20);

SIZE(pixel_step, 24, 4);
AT(pixel_step, origin, 0);
AT(pixel_step, direction, 12);

SIZE(image_spectrum, 16, 4);
AT(image_spectrum, xx, 0);
AT(image_spectrum, xy, 4);
AT(image_spectrum, yy, 8);
AT(image_spectrum, weight, 12);

SIZE(image_filter, 12, 4);
AT(image_filter, xx, 0);
AT(image_filter, xy, 4);
AT(image_filter, yy, 8);

SIZE(film_ray, 40, 4);
AT(film_ray, pixel, 0);
AT(film_ray, has_volume, 8);
AT(film_ray, has_rest, 12);
AT(film_ray, volume, 16);
AT(film_ray, rest, 28);

SIZE(film_pixel, 32, 4);
AT(film_pixel, radiance, 0);
AT(film_pixel, volume, 12);
AT(film_pixel, variance, 24);
AT(film_pixel, difference, 28);

SIZE(march_knot, 16, 4);
AT(march_knot, distance, 0);
AT(march_knot, radiance, 4);
AT(march_knot, deviation, 8);
AT(march_knot, visibility, 12);

SIZE(march_sample, 24, 8);
AT(march_sample, distance, 0);
AT(march_sample, weight, 4);
AT(march_sample, visibility, 8);
AT(march_sample, reserved, 12);
AT(march_sample, mass, 16);

SIZE(march_expected, 8, 4);
AT(march_expected, radiance, 0);
AT(march_expected, error, 4);

SIZE(importance_cell, 12, 4);
AT(importance_cell, beam, 0);
AT(importance_cell, scattered, 4);
AT(importance_cell, surface, 8);

SIZE(segment_importance, 12, 4);
AT(segment_importance, beam, 0);
AT(segment_importance, scattered, 4);
AT(segment_importance, transmittance, 8);

SIZE(status, 4, 4);
SIZE(phase_kind, 4, 4);
SIZE(density_kind, 4, 4);
SIZE(kernel_shape, 4, 4);

VALUE(OK, 0);
VALUE(NULL_POINTER, 1);
VALUE(MISALIGNED, 2);
VALUE(INVALID_VALUE, 3);
VALUE(INVALID_ARRAY, 4);
VALUE(SHORT_BUFFER, 5);
VALUE(INVALID_HANDLE, 6);
VALUE(WRONG_ORDER, 7);
VALUE(MISMATCH, 8);
VALUE(BAD_DATA, 9);
VALUE(OUT_OF_MEMORY, 10);
VALUE(CANCELLED, 11);
VALUE(CALLBACK_FAILED, 12);
VALUE(POISONED, 13);
VALUE(PANICKED, 14);
VALUE(PHASE_ISOTROPIC, 0);
VALUE(PHASE_HENYEY_GREENSTEIN, 1);
VALUE(PHASE_RAYLEIGH, 2);
VALUE(DENSITY_UNIFORM, 0);
VALUE(DENSITY_EXPONENTIAL, 1);
VALUE(DENSITY_VOXELS, 2);
VALUE(KERNEL_BOX, 0);
VALUE(KERNEL_EPANECHNIKOV, 1);
VALUE(KERNEL_BIWEIGHT, 2);
VALUE(ABI_VERSION, 2);

int main(int count, char **arguments)
{
    static const struct {
        covbeam_status status;
        const char *name;
    } names[] = {
#define NAME(status) { status, #status }
        NAME(COVBEAM_OK), NAME(COVBEAM_NULL_POINTER), NAME(COVBEAM_MISALIGNED), NAME(COVBEAM_INVALID_VALUE),
        NAME(COVBEAM_INVALID_ARRAY), NAME(COVBEAM_SHORT_BUFFER), NAME(COVBEAM_INVALID_HANDLE),
        NAME(COVBEAM_WRONG_ORDER), NAME(COVBEAM_MISMATCH), NAME(COVBEAM_BAD_DATA), NAME(COVBEAM_OUT_OF_MEMORY),
        NAME(COVBEAM_CANCELLED), NAME(COVBEAM_CALLBACK_FAILED), NAME(COVBEAM_POISONED), NAME(COVBEAM_PANICKED),
    };
    size_t i, known = sizeof names / sizeof names[0];
    if (count != 2) {
        fprintf(stderr, "usage: abi VERSION\n");
        return 2;
    }
    if (covbeam_abi_version() != COVBEAM_ABI_VERSION) {
        fprintf(stderr, "the library has ABI %u, the header %u\n", (unsigned)covbeam_abi_version(),
                (unsigned)COVBEAM_ABI_VERSION);
        return 1;
    }
    if (strcmp(covbeam_version(), arguments[1]) != 0) {
        fprintf(stderr, "the library is %s, not %s\n", covbeam_version(), arguments[1]);
        return 1;
    }
    for (i = 0; i < known; i++)
        if (strcmp(covbeam_status_name(names[i].status), names[i].name) != 0) {
            fprintf(stderr, "%s is called %s\n", names[i].name, covbeam_status_name(names[i].status));
            return 1;
        }
    if (strcmp(covbeam_status_name((covbeam_status)known), "unknown status") != 0 ||
        strcmp(covbeam_status_name(-1), "unknown status") != 0) {
        fprintf(stderr, "a number that is no status has a name\n");
        return 1;
    }
    if (strcmp(covbeam_last_error(), "") != 0) {
        fprintf(stderr, "a message before the first failure: %s\n", covbeam_last_error());
        return 1;
    }
    printf("covbeam %s, ABI %u, %u statuses: layouts and values equal\n", covbeam_version(),
           (unsigned)covbeam_abi_version(), (unsigned)known);
    return 0;
}
