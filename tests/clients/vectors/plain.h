/* Made from the headers by `cargo run -p covbeam-tests --bin header`; do not edit. */

static void light_field_point(struct call *c)
{
    float direction[3];
    float angular_variance;
    covbeam_light_field out;
    take(c, direction, 3);
    take(c, &angular_variance, 1);
    must(covbeam_light_field_point(direction, angular_variance, &out));
    give(c, &out, 16);
}

static covbeam_status many_light_field_point(size_t n, const void *common, void **p, const size_t *s)
{
    (void)common;
    return covbeam_light_fields_point(n, p[0], s[0], p[1], s[1], p[2], s[2]);
}

static void light_field_disk(struct call *c)
{
    float direction[3];
    float normal[3];
    float radius;
    float angular_variance;
    covbeam_light_field out;
    take(c, direction, 3);
    take(c, normal, 3);
    take(c, &radius, 1);
    take(c, &angular_variance, 1);
    must(covbeam_light_field_disk(direction, normal, radius, angular_variance, &out));
    give(c, &out, 16);
}

static covbeam_status many_light_field_disk(size_t n, const void *common, void **p, const size_t *s)
{
    (void)common;
    return covbeam_light_fields_disk(n, p[0], s[0], p[1], s[1], p[2], s[2], p[3], s[3], p[4], s[4]);
}

static void light_field_collimated(struct call *c)
{
    float direction[3];
    float radius;
    covbeam_light_field out;
    take(c, direction, 3);
    take(c, &radius, 1);
    must(covbeam_light_field_collimated(direction, radius, &out));
    give(c, &out, 16);
}

static covbeam_status many_light_field_collimated(size_t n, const void *common, void **p, const size_t *s)
{
    (void)common;
    return covbeam_light_fields_collimated(n, p[0], s[0], p[1], s[1], p[2], s[2]);
}

static void light_field_gaussian(struct call *c)
{
    float direction[3];
    float x_axis[3];
    float spatial_variance[2];
    float angular_variance[2];
    covbeam_light_field out;
    take(c, direction, 3);
    take(c, x_axis, 3);
    take(c, spatial_variance, 2);
    take(c, angular_variance, 2);
    must(covbeam_light_field_gaussian(direction, x_axis, spatial_variance, angular_variance, &out));
    give(c, &out, 16);
}

static covbeam_status many_light_field_gaussian(size_t n, const void *common, void **p, const size_t *s)
{
    (void)common;
    return covbeam_light_fields_gaussian(n, p[0], s[0], p[1], s[1], p[2], s[2], p[3], s[3], p[4], s[4]);
}

static void light_field_travel(struct call *c)
{
    covbeam_light_field field;
    float distance;
    take(c, &field, 16);
    take(c, &distance, 1);
    must(covbeam_light_field_travel(&field, distance));
    give(c, &field, 16);
}

static covbeam_status many_light_field_travel(size_t n, const void *common, void **p, const size_t *s)
{
    (void)common;
    return covbeam_light_fields_travel(n, p[0], s[0], p[1], s[1]);
}

static void light_field_carry(struct call *c)
{
    covbeam_light_field field;
    covbeam_medium medium;
    float origin[3];
    float distance;
    take(c, &field, 16);
    medium = take_medium(c);
    take(c, origin, 3);
    take(c, &distance, 1);
    must(covbeam_light_field_carry(&field, &medium, origin, distance));
    give(c, &field, 16);
}

static covbeam_status many_light_field_carry(size_t n, const void *common, void **p, const size_t *s)
{
    (void)common;
    return covbeam_light_fields_carry(n, p[0], s[0], common, p[1], s[1], p[2], s[2]);
}

static void light_field_rotate(struct call *c)
{
    covbeam_light_field field;
    float x_axis[3];
    take(c, &field, 16);
    take(c, x_axis, 3);
    must(covbeam_light_field_rotate(&field, x_axis));
    give(c, &field, 16);
}

static covbeam_status many_light_field_rotate(size_t n, const void *common, void **p, const size_t *s)
{
    (void)common;
    return covbeam_light_fields_rotate(n, p[0], s[0], p[1], s[1]);
}

static void light_field_reflect(struct call *c)
{
    covbeam_light_field field;
    float normal[3];
    covbeam_curvature curvature;
    take(c, &field, 16);
    take(c, normal, 3);
    take(c, &curvature, 6);
    must(covbeam_light_field_reflect(&field, normal, &curvature));
    give(c, &field, 16);
}

static covbeam_status many_light_field_reflect(size_t n, const void *common, void **p, const size_t *s)
{
    (void)common;
    return covbeam_light_fields_reflect(n, p[0], s[0], p[1], s[1], p[2], s[2]);
}

static void light_field_refract(struct call *c)
{
    covbeam_light_field field;
    float normal[3];
    covbeam_curvature curvature;
    float eta;
    uint8_t passed = 2;
    take(c, &field, 16);
    take(c, normal, 3);
    take(c, &curvature, 6);
    take(c, &eta, 1);
    must(covbeam_light_field_refract(&field, normal, &curvature, eta, &passed));
    give_flag(c, passed);
    give(c, &field, 16);
}

static covbeam_status many_light_field_refract(size_t n, const void *common, void **p, const size_t *s)
{
    (void)common;
    return covbeam_light_fields_refract(n, p[0], s[0], p[1], s[1], p[2], s[2], p[3], s[3], p[4], s[4]);
}

static void light_field_occlude(struct call *c)
{
    covbeam_light_field field;
    float towards_edge[3];
    float distance;
    take(c, &field, 16);
    take(c, towards_edge, 3);
    take(c, &distance, 1);
    must(covbeam_light_field_occlude(&field, towards_edge, distance));
    give(c, &field, 16);
}

static covbeam_status many_light_field_occlude(size_t n, const void *common, void **p, const size_t *s)
{
    (void)common;
    return covbeam_light_fields_occlude(n, p[0], s[0], p[1], s[1], p[2], s[2]);
}

static void light_field_attenuate(struct call *c)
{
    covbeam_light_field field;
    float gradient[3];
    float hessian[6];
    take(c, &field, 16);
    take(c, gradient, 3);
    take(c, hessian, 6);
    must(covbeam_light_field_attenuate(&field, gradient, hessian));
    give(c, &field, 16);
}

static covbeam_status many_light_field_attenuate(size_t n, const void *common, void **p, const size_t *s)
{
    (void)common;
    return covbeam_light_fields_attenuate(n, p[0], s[0], p[1], s[1], p[2], s[2]);
}

static void light_field_narrow(struct call *c)
{
    covbeam_light_field field;
    float across[3];
    float angular_variance;
    take(c, &field, 16);
    take(c, across, 3);
    take(c, &angular_variance, 1);
    must(covbeam_light_field_narrow(&field, across, angular_variance));
    give(c, &field, 16);
}

static covbeam_status many_light_field_narrow(size_t n, const void *common, void **p, const size_t *s)
{
    (void)common;
    return covbeam_light_fields_narrow(n, p[0], s[0], p[1], s[1], p[2], s[2]);
}

static void light_field_scatter(struct call *c)
{
    covbeam_light_field field;
    float direction[3];
    float angular_variance;
    take(c, &field, 16);
    take(c, direction, 3);
    take(c, &angular_variance, 1);
    must(covbeam_light_field_scatter(&field, direction, angular_variance));
    give(c, &field, 16);
}

static covbeam_status many_light_field_scatter(size_t n, const void *common, void **p, const size_t *s)
{
    (void)common;
    return covbeam_light_fields_scatter(n, p[0], s[0], p[1], s[1], p[2], s[2]);
}

static void light_field_diffuse(struct call *c)
{
    covbeam_light_field field;
    float normal[3];
    float direction[3];
    take(c, &field, 16);
    take(c, normal, 3);
    take(c, direction, 3);
    must(covbeam_light_field_diffuse(&field, normal, direction));
    give(c, &field, 16);
}

static covbeam_status many_light_field_diffuse(size_t n, const void *common, void **p, const size_t *s)
{
    (void)common;
    return covbeam_light_fields_diffuse(n, p[0], s[0], p[1], s[1], p[2], s[2]);
}

static void light_field_slice(struct call *c)
{
    covbeam_light_field field;
    float out[3];
    take(c, &field, 16);
    must(covbeam_light_field_slice(&field, out));
    give(c, out, 3);
}

static covbeam_status many_light_field_slice(size_t n, const void *common, void **p, const size_t *s)
{
    (void)common;
    return covbeam_light_fields_slice(n, p[0], s[0], p[1], s[1]);
}

static void light_field_fluence(struct call *c)
{
    covbeam_light_field field;
    float limit;
    covbeam_spectrum out;
    take(c, &field, 16);
    take(c, &limit, 1);
    must(covbeam_light_field_fluence(&field, limit, &out));
    give(c, &out, 6);
}

static covbeam_status many_light_field_fluence(size_t n, const void *common, void **p, const size_t *s)
{
    (void)common;
    return covbeam_light_fields_fluence(n, p[0], s[0], p[1], s[1], p[2], s[2]);
}

static void light_field_variance_along_ray(struct call *c)
{
    covbeam_light_field field;
    float extinction;
    float out;
    take(c, &field, 16);
    take(c, &extinction, 1);
    must(covbeam_light_field_variance_along_ray(&field, extinction, &out));
    give(c, &out, 1);
}

static covbeam_status many_light_field_variance_along_ray(size_t n, const void *common, void **p, const size_t *s)
{
    (void)common;
    return covbeam_light_fields_variance_along_ray(n, p[0], s[0], p[1], s[1], p[2], s[2]);
}

static void phase_evaluate(struct call *c)
{
    covbeam_phase phase;
    float cosine;
    float value;
    take(c, &phase, 2);
    take(c, &cosine, 1);
    must(covbeam_phase_evaluate(&phase, cosine, &value));
    give(c, &value, 1);
}

static covbeam_status many_phase_evaluate(size_t n, const void *common, void **p, const size_t *s)
{
    (void)common;
    return covbeam_phase_evaluate_many(common, n, p[0], s[0], p[1], s[1]);
}

static void phase_sample(struct call *c)
{
    covbeam_phase phase;
    float direction[3];
    float xi[2];
    float scattered[3];
    take(c, &phase, 2);
    take(c, direction, 3);
    take(c, xi, 2);
    must(covbeam_phase_sample(&phase, direction, xi, scattered));
    give(c, scattered, 3);
}

static covbeam_status many_phase_sample(size_t n, const void *common, void **p, const size_t *s)
{
    (void)common;
    return covbeam_phase_sample_many(common, n, p[0], s[0], p[1], s[1], p[2], s[2]);
}

static void phase_sample_cosine(struct call *c)
{
    covbeam_phase phase;
    float xi;
    float cosine;
    take(c, &phase, 2);
    take(c, &xi, 1);
    must(covbeam_phase_sample_cosine(&phase, xi, &cosine));
    give(c, &cosine, 1);
}

static covbeam_status many_phase_sample_cosine(size_t n, const void *common, void **p, const size_t *s)
{
    (void)common;
    return covbeam_phase_sample_cosine_many(common, n, p[0], s[0], p[1], s[1]);
}

static void medium_density_at(struct call *c)
{
    covbeam_medium medium;
    float position[3];
    float density;
    medium = take_medium(c);
    take(c, position, 3);
    must(covbeam_medium_density_at(&medium, position, &density));
    give(c, &density, 1);
}

static covbeam_status many_medium_density_at(size_t n, const void *common, void **p, const size_t *s)
{
    (void)common;
    return covbeam_medium_density_at_many(common, n, p[0], s[0], p[1], s[1]);
}

static void medium_derivatives_at(struct call *c)
{
    covbeam_medium medium;
    float position[3];
    covbeam_derivatives derivative;
    medium = take_medium(c);
    take(c, position, 3);
    must(covbeam_medium_derivatives_at(&medium, position, &derivative));
    give(c, &derivative, 9);
}

static covbeam_status many_medium_derivatives_at(size_t n, const void *common, void **p, const size_t *s)
{
    (void)common;
    return covbeam_medium_derivatives_at_many(common, n, p[0], s[0], p[1], s[1]);
}

static covbeam_status many_medium_column_at(size_t n, const void *common, void **p, const size_t *s)
{
    (void)common;
    return covbeam_medium_column_at_many(common, n, p[0], s[0], p[1], s[1], p[2], s[2], p[3], s[3]);
}

static covbeam_status many_medium_distance_at(size_t n, const void *common, void **p, const size_t *s)
{
    (void)common;
    return covbeam_medium_distance_at_many(common, n, p[0], s[0], p[1], s[1], p[2], s[2], p[3], s[3], p[4], s[4]);
}

static void medium_transmittance(struct call *c)
{
    covbeam_medium medium;
    float origin[3];
    float direction[3];
    float distance;
    float transmittance[3];
    medium = take_medium(c);
    take(c, origin, 3);
    take(c, direction, 3);
    take(c, &distance, 1);
    must(covbeam_medium_transmittance(&medium, origin, direction, distance, transmittance));
    give(c, transmittance, 3);
}

static covbeam_status many_medium_transmittance(size_t n, const void *common, void **p, const size_t *s)
{
    (void)common;
    return covbeam_medium_transmittance_many(common, n, p[0], s[0], p[1], s[1], p[2], s[2], p[3], s[3]);
}

static void medium_column_transmittance(struct call *c)
{
    covbeam_medium medium;
    float column;
    float transmittance[3];
    medium = take_medium(c);
    take(c, &column, 1);
    must(covbeam_medium_column_transmittance(&medium, column, transmittance));
    give(c, transmittance, 3);
}

static covbeam_status many_medium_column_transmittance(size_t n, const void *common, void **p, const size_t *s)
{
    (void)common;
    return covbeam_medium_column_transmittance_many(common, n, p[0], s[0], p[1], s[1]);
}

static void medium_reach(struct call *c)
{
    covbeam_medium medium;
    float origin[3];
    float direction[3];
    float distance;
    medium = take_medium(c);
    take(c, origin, 3);
    take(c, direction, 3);
    must(covbeam_medium_reach(&medium, origin, direction, &distance));
    give(c, &distance, 1);
}

static covbeam_status many_medium_reach(size_t n, const void *common, void **p, const size_t *s)
{
    (void)common;
    return covbeam_medium_reach_many(common, n, p[0], s[0], p[1], s[1], p[2], s[2]);
}

static void spectrum_variance_along(struct call *c)
{
    covbeam_spectrum spectrum;
    float axis[3];
    float variance;
    take(c, &spectrum, 6);
    take(c, axis, 3);
    must(covbeam_spectrum_variance_along(&spectrum, axis, &variance));
    give(c, &variance, 1);
}

static covbeam_status many_spectrum_variance_along(size_t n, const void *common, void **p, const size_t *s)
{
    (void)common;
    return covbeam_spectra_variance_along(n, p[0], s[0], p[1], s[1], p[2], s[2]);
}

static void spectrum_add_along(struct call *c)
{
    covbeam_spectrum spectrum;
    float axis[3];
    float variance;
    take(c, &spectrum, 6);
    take(c, axis, 3);
    take(c, &variance, 1);
    must(covbeam_spectrum_add_along(&spectrum, axis, variance));
    give(c, &spectrum, 6);
}

static covbeam_status many_spectrum_add_along(size_t n, const void *common, void **p, const size_t *s)
{
    (void)common;
    return covbeam_spectra_add_along(n, p[0], s[0], p[1], s[1], p[2], s[2]);
}

static void image_spectrum_filter(struct call *c)
{
    covbeam_image_spectrum spectrum;
    float error;
    float widest;
    covbeam_image_filter filter;
    take(c, &spectrum, 4);
    take(c, &error, 1);
    take(c, &widest, 1);
    must(covbeam_image_spectrum_filter(&spectrum, error, widest, &filter));
    give(c, &filter, 3);
}

static covbeam_status many_image_spectrum_filter(size_t n, const void *common, void **p, const size_t *s)
{
    (void)common;
    return covbeam_image_spectra_filter(n, p[0], s[0], p[1], s[1], p[2], s[2], p[3], s[3]);
}

static void image_filter_density(struct call *c)
{
    covbeam_image_filter filter;
    float density;
    take(c, &filter, 3);
    must(covbeam_image_filter_density(&filter, &density));
    give(c, &density, 1);
}

static covbeam_status many_image_filter_density(size_t n, const void *common, void **p, const size_t *s)
{
    (void)common;
    return covbeam_image_filters_density(n, p[0], s[0], p[1], s[1]);
}

#define PLAIN_CALLS \
    CALL(light_field_point), \
    CALL(light_field_disk), \
    CALL(light_field_collimated), \
    CALL(light_field_gaussian), \
    CALL(light_field_travel), \
    CALL(light_field_carry), \
    CALL(light_field_rotate), \
    CALL(light_field_reflect), \
    CALL(light_field_refract), \
    CALL(light_field_occlude), \
    CALL(light_field_attenuate), \
    CALL(light_field_narrow), \
    CALL(light_field_scatter), \
    CALL(light_field_diffuse), \
    CALL(light_field_slice), \
    CALL(light_field_fluence), \
    CALL(light_field_variance_along_ray), \
    CALL(phase_evaluate), \
    CALL(phase_sample), \
    CALL(phase_sample_cosine), \
    CALL(medium_density_at), \
    CALL(medium_derivatives_at), \
    CALL(medium_transmittance), \
    CALL(medium_column_transmittance), \
    CALL(medium_reach), \
    CALL(spectrum_variance_along), \
    CALL(spectrum_add_along), \
    CALL(image_spectrum_filter), \
    CALL(image_filter_density)

#define PLAIN_PLURALS \
    { "light_field_point", NONE, 0, { { 0, -1, 3 }, { 3, -1, 1 }, { -1, 0, 16 } }, many_light_field_point }, \
    { "light_field_disk", NONE, 0, { { 0, -1, 3 }, { 3, -1, 3 }, { 6, -1, 1 }, { 7, -1, 1 }, { -1, 0, 16 } }, many_light_field_disk }, \
    { "light_field_collimated", NONE, 0, { { 0, -1, 3 }, { 3, -1, 1 }, { -1, 0, 16 } }, many_light_field_collimated }, \
    { "light_field_gaussian", NONE, 0, { { 0, -1, 3 }, { 3, -1, 3 }, { 6, -1, 2 }, { 8, -1, 2 }, { -1, 0, 16 } }, many_light_field_gaussian }, \
    { "light_field_travel", NONE, 0, { { 0, 0, 16 }, { 16, -1, 1 } }, many_light_field_travel }, \
    { "light_field_carry", MEDIUM, 16, { { 0, 0, 16 }, { 32, -1, 3 }, { 35, -1, 1 } }, many_light_field_carry }, \
    { "light_field_rotate", NONE, 0, { { 0, 0, 16 }, { 16, -1, 3 } }, many_light_field_rotate }, \
    { "light_field_reflect", NONE, 0, { { 0, 0, 16 }, { 16, -1, 3 }, { 19, -1, 6 } }, many_light_field_reflect }, \
    { "light_field_refract", NONE, 0, { { 0, 1, 16 }, { 16, -1, 3 }, { 19, -1, 6 }, { 25, -1, 1 }, { -1, 0, 0 } }, many_light_field_refract }, \
    { "light_field_occlude", NONE, 0, { { 0, 0, 16 }, { 16, -1, 3 }, { 19, -1, 1 } }, many_light_field_occlude }, \
    { "light_field_attenuate", NONE, 0, { { 0, 0, 16 }, { 16, -1, 3 }, { 19, -1, 6 } }, many_light_field_attenuate }, \
    { "light_field_narrow", NONE, 0, { { 0, 0, 16 }, { 16, -1, 3 }, { 19, -1, 1 } }, many_light_field_narrow }, \
    { "light_field_scatter", NONE, 0, { { 0, 0, 16 }, { 16, -1, 3 }, { 19, -1, 1 } }, many_light_field_scatter }, \
    { "light_field_diffuse", NONE, 0, { { 0, 0, 16 }, { 16, -1, 3 }, { 19, -1, 3 } }, many_light_field_diffuse }, \
    { "light_field_slice", NONE, 0, { { 0, -1, 16 }, { -1, 0, 3 } }, many_light_field_slice }, \
    { "light_field_fluence", NONE, 0, { { 0, -1, 16 }, { 16, -1, 1 }, { -1, 0, 6 } }, many_light_field_fluence }, \
    { "light_field_variance_along_ray", NONE, 0, { { 0, -1, 16 }, { 16, -1, 1 }, { -1, 0, 1 } }, many_light_field_variance_along_ray }, \
    { "phase_evaluate", PHASE, 0, { { 2, -1, 1 }, { -1, 0, 1 } }, many_phase_evaluate }, \
    { "phase_sample", PHASE, 0, { { 2, -1, 3 }, { 5, -1, 2 }, { -1, 0, 3 } }, many_phase_sample }, \
    { "phase_sample_cosine", PHASE, 0, { { 2, -1, 1 }, { -1, 0, 1 } }, many_phase_sample_cosine }, \
    { "medium_density_at", MEDIUM, 0, { { 16, -1, 3 }, { -1, 0, 1 } }, many_medium_density_at }, \
    { "medium_derivatives_at", MEDIUM, 0, { { 16, -1, 3 }, { -1, 0, 9 } }, many_medium_derivatives_at }, \
    { "medium_column_at", MEDIUM, 0, { { 16, -1, 3 }, { 19, -1, 3 }, { 22, -1, 1 }, { -1, 0, 1 } }, many_medium_column_at }, \
    { "medium_distance_at", MEDIUM, 0, { { 16, -1, 3 }, { 19, -1, 3 }, { 22, -1, 1 }, { 23, -1, 1 }, { -1, 0, 1 } }, many_medium_distance_at }, \
    { "medium_transmittance", MEDIUM, 0, { { 16, -1, 3 }, { 19, -1, 3 }, { 22, -1, 1 }, { -1, 0, 3 } }, many_medium_transmittance }, \
    { "medium_column_transmittance", MEDIUM, 0, { { 16, -1, 1 }, { -1, 0, 3 } }, many_medium_column_transmittance }, \
    { "medium_reach", MEDIUM, 0, { { 16, -1, 3 }, { 19, -1, 3 }, { -1, 0, 1 } }, many_medium_reach }, \
    { "spectrum_variance_along", NONE, 0, { { 0, -1, 6 }, { 6, -1, 3 }, { -1, 0, 1 } }, many_spectrum_variance_along }, \
    { "spectrum_add_along", NONE, 0, { { 0, 0, 6 }, { 6, -1, 3 }, { 9, -1, 1 } }, many_spectrum_add_along }, \
    { "image_spectrum_filter", NONE, 0, { { 0, -1, 4 }, { 4, -1, 1 }, { 5, -1, 1 }, { -1, 0, 3 } }, many_image_spectrum_filter }, \
    { "image_filter_density", NONE, 0, { { 0, -1, 3 }, { -1, 0, 1 } }, many_image_filter_density }
