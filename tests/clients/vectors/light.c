/* Light fields: sources, operators, what is read off. */
#include "calls.h"

void light_field_point(struct call *c)
{
    covbeam_light_field field;
    float direction[3];
    take(c, direction, 3);
    must(covbeam_light_field_point(direction, take_float(c), &field));
    give(c, &field, 16);
}

void light_field_disk(struct call *c)
{
    covbeam_light_field field;
    float direction[3], normal[3], radius;
    take(c, direction, 3);
    take(c, normal, 3);
    radius = take_float(c);
    must(covbeam_light_field_disk(direction, normal, radius, take_float(c), &field));
    give(c, &field, 16);
}

void light_field_collimated(struct call *c)
{
    covbeam_light_field field;
    float direction[3];
    take(c, direction, 3);
    must(covbeam_light_field_collimated(direction, take_float(c), &field));
    give(c, &field, 16);
}

void light_field_gaussian(struct call *c)
{
    covbeam_light_field field;
    float direction[3], x_axis[3], spatial[2], angular[2];
    take(c, direction, 3);
    take(c, x_axis, 3);
    take(c, spatial, 2);
    take(c, angular, 2);
    must(covbeam_light_field_gaussian(direction, x_axis, spatial, angular, &field));
    give(c, &field, 16);
}

void light_field_carry(struct call *c)
{
    covbeam_light_field field;
    covbeam_medium medium;
    float origin[3];
    take(c, &field, 16);
    medium = take_medium(c);
    take(c, origin, 3);
    must(covbeam_light_field_carry(&field, &medium, origin, take_float(c)));
    give(c, &field, 16);
}

void light_field_reflect(struct call *c)
{
    covbeam_light_field field;
    covbeam_curvature curvature;
    float normal[3];
    take(c, &field, 16);
    take(c, normal, 3);
    take(c, &curvature, 6);
    must(covbeam_light_field_reflect(&field, normal, &curvature));
    give(c, &field, 16);
}

void light_field_refract(struct call *c)
{
    covbeam_light_field field;
    covbeam_curvature curvature;
    float normal[3];
    uint8_t passed = 2;
    take(c, &field, 16);
    take(c, normal, 3);
    take(c, &curvature, 6);
    must(covbeam_light_field_refract(&field, normal, &curvature, take_float(c), &passed));
    give_flag(c, passed);
    give(c, &field, 16);
}

/* Those that take a field, and a vector, or two, or a vector and a number. */
#define FIELD(name, words, made)               \
    void light_field_##name(struct call *c) \
    {                                          \
        covbeam_light_field field;             \
        float a[9];                            \
        take(c, &field, 16);                   \
        take(c, a, words);                     \
        must(made);                            \
        give(c, &field, 16);                   \
    }
FIELD(travel, 1, covbeam_light_field_travel(&field, a[0]))
FIELD(rotate, 3, covbeam_light_field_rotate(&field, a))
FIELD(occlude, 4, covbeam_light_field_occlude(&field, a, a[3]))
FIELD(attenuate, 9, covbeam_light_field_attenuate(&field, a, a + 3))
FIELD(narrow, 4, covbeam_light_field_narrow(&field, a, a[3]))
FIELD(scatter, 4, covbeam_light_field_scatter(&field, a, a[3]))
FIELD(diffuse, 6, covbeam_light_field_diffuse(&field, a, a + 3))

void light_field_slice(struct call *c)
{
    covbeam_light_field field;
    float variances[3];
    take(c, &field, 16);
    must(covbeam_light_field_slice(&field, variances));
    give(c, variances, 3);
}

void light_field_fluence(struct call *c)
{
    covbeam_light_field field;
    covbeam_spectrum spectrum;
    take(c, &field, 16);
    must(covbeam_light_field_fluence(&field, take_float(c), &spectrum));
    give(c, &spectrum, 6);
}

void light_field_variance_along_ray(struct call *c)
{
    covbeam_light_field field;
    float variance;
    take(c, &field, 16);
    must(covbeam_light_field_variance_along_ray(&field, take_float(c), &variance));
    give(c, &variance, 1);
}

void path_number(struct call *c)
{
    uint32_t seed = take_u32(c), sequence = take_u32(c), path = take_u32(c), dimension = take_u32(c);
    float number, again;
    must(covbeam_path_number(seed, sequence, path, dimension, &number));
    must(covbeam_path_numbers(seed, sequence, 1, &path, 0, dimension, &again, 0));
    equal(&number, &again, sizeof number, "covbeam_path_numbers: another number");
    give(c, &number, 1);
}
