/*
 * covbeam_extra.h: what hosts that gather beams do not need, for those with hierarchies, kernels or grids of their own:
 * pairs of beam and eye ray, columns as tables, the parts of kernels and filters, spectra, voxels of a grid. Of the same
 * library, under the conventions of covbeam.h.
 * MIT or Apache-2.0. Made from ffi/src; do not edit.
 */

#ifndef COVBEAM_EXTRA_H
#define COVBEAM_EXTRA_H

#include "covbeam.h"

/**
 * Derivatives of a relative density, in world axes.
 */
typedef struct covbeam_derivatives {
    /**
     * First derivatives [1/m].
     */
    float gradient[3];
    /**
     * Second derivatives xx, yy, zz, xy, xz, yz [1/m^2].
     */
    float hessian[6];
} covbeam_derivatives;

/**
 * The column along one ray as a function of the distance. Made by covbeam_medium_column.
 *
 * A host with media of its own may write one: VOXELS with a table of its own, whatever the density is made of.
 */
typedef struct covbeam_column {
    /**
     * A value of covbeam_density_kind; the fields below are read as it needs them.
     */
    uint32_t kind;
    /**
     * Exponential: relative density at the ray's origin, finite and >= 0.
     */
    float density;
    /**
     * Exponential: the density falls as exp(-rate x distance) [1/m], of either sign.
     */
    float rate;
    /**
     * Voxels: the host's table, which stays in place and unchanged while the column is used; NULL if
     * knot_count is 0.
     */
    const struct covbeam_knot *knots;
    /**
     * Voxels: number of knots; 0 is empty space.
     */
    size_t knot_count;
} covbeam_column;

/**
 * What one voxel has collected. All 0 is empty.
 */
typedef struct covbeam_grid_cell {
    /**
     * Sum of weight x (xx, yy, zz, xy, xz, yz).
     */
    double sum[6];
    /**
     * Sum of the weights.
     */
    double weight;
} covbeam_grid_cell;

/**
 * The mean spectrum of one voxel, for look-ups.
 */
typedef struct covbeam_fluence_cell {
    /**
     * Flux-weighted mean of what was deposited.
     */
    struct covbeam_spectrum spectrum;
    /**
     * Fluence over that of the brightest voxel, in (0, 1]; 0 = no data.
     */
    float weight;
} covbeam_fluence_cell;

/**
 * Closest approach of an eye ray's line and a beam's line.
 */
typedef struct covbeam_crossing {
    /**
     * Distance along the eye ray [m]; may lie outside it.
     */
    float ray_distance;
    /**
     * Distance along the beam [m]; may lie outside it.
     */
    float beam_distance;
    /**
     * Distance between the two closest points [m].
     */
    float gap;
    /**
     * Sine of the angle between the directions, in (0, 1].
     */
    float sin_theta;
    /**
     * Unit common perpendicular, on which the kernel acts.
     */
    float axis[3];
} covbeam_crossing;

/**
 * Covariance of a Gaussian reconstruction filter [pixels^2]: x to the right, y down. All 0 is no filter.
 */
typedef struct covbeam_image_filter {
    /**
     * Variance across.
     */
    float xx;
    /**
     * Covariance of across and down.
     */
    float xy;
    /**
     * Variance down.
     */
    float yy;
} covbeam_image_filter;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * Attenuation by a stretch of medium whose optical depth varies across the ray. covbeam_light_field_carry does
 * this for the built-in media.
 *
 * @param count number of fields; with 0 nothing is done.
 * @param fields, field_stride the light fields, changed in place.
 * @param gradients, gradient_stride of the optical depth of the stretch, in world axes [1/m].
 * @param hessians, hessian_stride of the same, [xx, yy, zz, xy, xz, yz] [1/m^2].
 * @note Thesis 5.3.1.
 */
covbeam_status covbeam_light_fields_attenuate(size_t count,
                                              struct covbeam_light_field *fields,
                                              size_t field_stride,
                                              const float *gradients,
                                              size_t gradient_stride,
                                              const float *hessians,
                                              size_t hessian_stride);

static inline covbeam_status covbeam_light_field_attenuate(struct covbeam_light_field *field,
                                                           const float *gradient, const float *hessian)
{
    return covbeam_light_fields_attenuate(1, field, 0, gradient, 0, hessian, 0);
}

/**
 * Variance of the fluence's spectrum along the ray, from how the rays spread and from extinction; for light
 * that has not been scattered.
 *
 * @param count number of fields; with 0 nothing is done.
 * @param fields, field_stride the light fields.
 * @param extinctions, extinction_stride around the ray [1/m] >= 0.
 * @param variance_out, out_stride [cycles^2/m^2] >= 0.
 * @note Derived.
 */
covbeam_status covbeam_light_fields_variance_along_ray(size_t count,
                                                       const struct covbeam_light_field *fields,
                                                       size_t field_stride,
                                                       const float *extinctions,
                                                       size_t extinction_stride,
                                                       float *variance_out,
                                                       size_t out_stride);

static inline covbeam_status covbeam_light_field_variance_along_ray(const struct covbeam_light_field *field,
                                                                    float extinction, float *out)
{
    return covbeam_light_fields_variance_along_ray(1, field, 0, &extinction, 0, out, 0);
}

/**
 * The value of a phase function [1/sr]: 1 in all over the sphere.
 *
 * @param phase the phase function.
 * @param count number of values; with 0 nothing is done.
 * @param cosines, cosine_stride dot(propagation before, propagation after), forward 1; in [-1, 1], rounding
 *     past the ends is harmless.
 * @param values, value_stride [1/sr] >= 0.
 */
covbeam_status covbeam_phase_evaluate_many(const struct covbeam_phase *phase,
                                           size_t count,
                                           const float *cosines,
                                           size_t cosine_stride,
                                           float *values,
                                           size_t value_stride);

static inline covbeam_status covbeam_phase_evaluate(const struct covbeam_phase *phase, float cosine,
                                                    float *value)
{
    return covbeam_phase_evaluate_many(phase, 1, &cosine, 0, value, 0);
}

/**
 * Samples the cosine of the scattering angle in proportion to the phase function.
 *
 * @param phase the phase function.
 * @param count number of cosines; with 0 nothing is done.
 * @param xis, xi_stride uniform in [0, 1); 0 gives -1, and the cosine grows with it.
 * @param cosines, cosine_stride in [-1, 1].
 */
covbeam_status covbeam_phase_sample_cosine_many(const struct covbeam_phase *phase,
                                                size_t count,
                                                const float *xis,
                                                size_t xi_stride,
                                                float *cosines,
                                                size_t cosine_stride);

static inline covbeam_status covbeam_phase_sample_cosine(const struct covbeam_phase *phase, float xi,
                                                         float *cosine)
{
    return covbeam_phase_sample_cosine_many(phase, 1, &xi, 0, cosine, 0);
}

/**
 * Relative density of a medium at a point.
 *
 * @param medium the medium.
 * @param count number of points; with 0 nothing is done.
 * @param positions, position_stride [m].
 * @param densities, density_stride >= 0: 1 where the medium's coefficients hold. An exponential one is held
 *     beyond e^80 and e^-80.
 * @note Costs nothing, an exponential, or a trilinear look-up.
 */
covbeam_status covbeam_medium_density_at_many(const struct covbeam_medium *medium,
                                              size_t count,
                                              const float *positions,
                                              size_t position_stride,
                                              float *densities,
                                              size_t density_stride);

static inline covbeam_status covbeam_medium_density_at(const struct covbeam_medium *medium,
                                                       const float *position, float *density)
{
    return covbeam_medium_density_at_many(medium, 1, position, 0, density, 0);
}

/**
 * Derivatives of the relative density at a point. Their integrals along a way, times the extinction, are what
 * covbeam_light_field_attenuate takes.
 *
 * @param medium the medium.
 * @param count number of points; with 0 nothing is done.
 * @param positions, position_stride [m].
 * @param derivatives, derivative_stride exact for an exponential density; differences between neighbouring
 *     voxels, 0 outside the box.
 */
covbeam_status covbeam_medium_derivatives_at_many(const struct covbeam_medium *medium,
                                                  size_t count,
                                                  const float *positions,
                                                  size_t position_stride,
                                                  struct covbeam_derivatives *derivatives,
                                                  size_t derivative_stride);

static inline covbeam_status covbeam_medium_derivatives_at(const struct covbeam_medium *medium,
                                                           const float *position,
                                                           struct covbeam_derivatives *derivative)
{
    return covbeam_medium_derivatives_at_many(medium, 1, position, 0, derivative, 0);
}

/**
 * Largest step [m] over which the second derivatives may be taken as constant, for a host that sums them
 * itself.
 *
 * @param medium the medium.
 * @param step [m] > 0: infinity where the medium is homogeneous, half the scale height, or a voxel's smallest
 *     side.
 */
covbeam_status covbeam_medium_step(const struct covbeam_medium *medium, float *step);

/**
 * Column along a ray: the integral of the relative density. Extinction x column is the optical depth.
 *
 * @param medium the medium.
 * @param count number of rays; with 0 nothing is done.
 * @param origins, origin_stride of the ray [m].
 * @param directions, direction_stride of the ray, unit.
 * @param distances, distance_stride along the ray [m] >= 0; infinity allowed.
 * @param columns, column_stride [m] >= 0; infinite only for an infinite distance in a homogeneous medium.
 * @note Voxels: exact, about 20 ns a voxel passed. For many distances on one ray see covbeam_medium_column.
 */
covbeam_status covbeam_medium_column_at_many(const struct covbeam_medium *medium,
                                             size_t count,
                                             const float *origins,
                                             size_t origin_stride,
                                             const float *directions,
                                             size_t direction_stride,
                                             const float *distances,
                                             size_t distance_stride,
                                             float *columns,
                                             size_t column_stride);

static inline covbeam_status covbeam_medium_column_at(const struct covbeam_medium *medium,
                                                      const float *origin, const float *direction,
                                                      float distance, float *column)
{
    return covbeam_medium_column_at_many(medium, 1, origin, 0, direction, 0, &distance, 0, column, 0);
}

/**
 * The share of light that a column leaves, per channel: for a host that has the column already.
 *
 * @param medium the medium; its density does not matter.
 * @param count number of columns; with 0 nothing is done.
 * @param columns, column_stride [m] >= 0; infinity allowed.
 * @param transmittances, transmittance_stride three numbers in [0, 1]: exp(-extinction x column).
 */
covbeam_status covbeam_medium_column_transmittance_many(const struct covbeam_medium *medium,
                                                        size_t count,
                                                        const float *columns,
                                                        size_t column_stride,
                                                        float *transmittances,
                                                        size_t transmittance_stride);

static inline covbeam_status covbeam_medium_column_transmittance(const struct covbeam_medium *medium,
                                                                 float column, float *transmittance)
{
    return covbeam_medium_column_transmittance_many(medium, 1, &column, 0, transmittance, 0);
}

/**
 * The table of columns along a ray through voxels: points between which a straight line is within `error` of
 * the column. None for other densities, whose columns are closed forms.
 *
 * @param medium the medium.
 * @param origin of the ray [m].
 * @param direction of the ray, unit.
 * @param length of the ray [m] >= 0; infinity ends where it leaves the voxels.
 * @param error of a column [m] > 0; infinity keeps the ends alone. Times the extinction it is the error of the
 *     optical depth.
 * @param most the table ends at the first point with a larger column [m] >= 0; infinity for the whole ray.
 * @param knots packed, room for `capacity` of them; NULL with a capacity of 0 only counts.
 * @param capacity of knots; 64 x (voxels along x + y + z + 2) is always enough.
 * @param count number of knots.
 * @note If the capacity is too small: COVBEAM_SHORT_BUFFER, and the message says what is needed. About 40 ns a
 *     voxel passed.
 */
covbeam_status covbeam_medium_knots(const struct covbeam_medium *medium,
                                    const float *origin,
                                    const float *direction,
                                    float length,
                                    float error,
                                    float most,
                                    struct covbeam_knot *knots,
                                    size_t capacity,
                                    size_t *count);

/**
 * covbeam_medium_knots as a gather wants them: within 5e-4 of the optical depth of the channel that is
 * attenuated most, up to where every channel is opaque.
 *
 * @param medium the medium.
 * @param origin of the ray [m].
 * @param direction of the ray, unit.
 * @param length of the ray [m] >= 0; infinity ends where it leaves the voxels.
 * @param knots packed, room for `capacity` of them; NULL with a capacity of 0 only counts.
 * @param capacity of knots.
 * @param count number of knots.
 * @note A capacity that is too small is answered as by covbeam_medium_knots. About 40 ns a voxel passed.
 */
covbeam_status covbeam_medium_tabulate(const struct covbeam_medium *medium,
                                       const float *origin,
                                       const float *direction,
                                       float length,
                                       struct covbeam_knot *knots,
                                       size_t capacity,
                                       size_t *count);

/**
 * The column along a ray, by value: a closed form, or the table that covbeam_medium_tabulate made of it.
 *
 * @param medium the medium.
 * @param origin of the ray [m].
 * @param direction of the ray, unit.
 * @param knots packed, not copied: they stay in place while the column is used; ignored, and may be NULL,
 *     unless the density is voxels.
 * @param knot_count number of knots.
 * @param column the column.
 * @note Checks the table: finite, distances and columns not falling. Nothing that is given a column checks
 *     that again.
 */
covbeam_status covbeam_medium_column(const struct covbeam_medium *medium,
                                     const float *origin,
                                     const float *direction,
                                     const struct covbeam_knot *knots,
                                     size_t knot_count,
                                     struct covbeam_column *column);

/**
 * The column up to a distance.
 *
 * @param column the column along the ray.
 * @param count number of distances; with 0 nothing is done.
 * @param distances, distance_stride along the ray [m] >= 0; infinity allowed.
 * @param values, value_stride [m] >= 0, never falling with distance.
 * @note Costs nothing, an exponential, or a binary search. The order of the knots is not checked; without
 *     it, value means nothing.
 */
covbeam_status covbeam_column_at_many(const struct covbeam_column *column,
                                      size_t count,
                                      const float *distances,
                                      size_t distance_stride,
                                      float *values,
                                      size_t value_stride);

static inline covbeam_status covbeam_column_at(const struct covbeam_column *column, float distance,
                                               float *value)
{
    return covbeam_column_at_many(column, 1, &distance, 0, value, 0);
}

/**
 * The distance at which the column reaches a value: the inverse of covbeam_column_at. See
 * covbeam_medium_distance_at.
 *
 * @param column the column along the ray.
 * @param count number of values; with 0 nothing is done.
 * @param values, value_stride [m] >= 0; infinity allowed.
 * @param distances, distance_stride [m]; infinity if it never does.
 * @note Costs nothing, a logarithm, or a binary search. The order of the knots is not checked; without it,
 *     distance means nothing.
 */
covbeam_status covbeam_column_distance_at_many(const struct covbeam_column *column,
                                               size_t count,
                                               const float *values,
                                               size_t value_stride,
                                               float *distances,
                                               size_t distance_stride);

static inline covbeam_status covbeam_column_distance_at(const struct covbeam_column *column, float value,
                                                        float *distance)
{
    return covbeam_column_distance_at_many(column, 1, &value, 0, distance, 0);
}

/**
 * A spectrum's variance along an axis: what covbeam_kernel_radius_from_error takes.
 *
 * @param count number of spectra; with 0 nothing is done.
 * @param spectra, spectrum_stride of the fluence.
 * @param axes, axis_stride unit.
 * @param variances, variance_stride [cycles^2/m^2] >= 0, to a few roundings of xx + yy + zz.
 * @note Thesis 5.3.4.
 */
covbeam_status covbeam_spectra_variance_along(size_t count,
                                              const struct covbeam_spectrum *spectra,
                                              size_t spectrum_stride,
                                              const float *axes,
                                              size_t axis_stride,
                                              float *variances,
                                              size_t variance_stride);

static inline covbeam_status covbeam_spectrum_variance_along(const struct covbeam_spectrum *spectrum,
                                                             const float *axis, float *variance)
{
    return covbeam_spectra_variance_along(1, spectrum, 0, axis, 0, variance, 0);
}

/**
 * Adds a variance along an axis, such as that of covbeam_light_field_variance_along_ray.
 *
 * @param count number of spectra; with 0 nothing is done.
 * @param spectra, spectrum_stride of the fluence, changed in place.
 * @param axes, axis_stride unit.
 * @param variances, variance_stride [cycles^2/m^2], finite and >= 0.
 */
covbeam_status covbeam_spectra_add_along(size_t count,
                                         struct covbeam_spectrum *spectra,
                                         size_t spectrum_stride,
                                         const float *axes,
                                         size_t axis_stride,
                                         const float *variances,
                                         size_t variance_stride);

static inline covbeam_status covbeam_spectrum_add_along(struct covbeam_spectrum *spectrum, const float *axis,
                                                        float variance)
{
    return covbeam_spectra_add_along(1, spectrum, 0, axis, 0, &variance, 0);
}

/**
 * Writes a guide of a lamp's emission: a warp of the unit square in which the place and direction of its light
 * are drawn, that sends more paths where they are worth more. What is stratified in the square stays so.
 *
 * @param side the guide has side x side cells of the square, >= 1.
 * @param weights, weight_count what light that leaves through each cell is worth, such as the mean of
 *     covbeam_importance_of_segments over some of its rays; side x side numbers, the second coordinate of the
 *     square running fastest, finite and >= 0. Their scale does not matter.
 * @param even share of the paths that go everywhere alike, in (0, 1], and at least 1e-37 a cell: no more than
 *     1/even times its own power has any path, however wrong the weights are. Where all weights are 0, all do.
 * @param guide, guide_count receives the guide: side x (side + 1) numbers.
 */
covbeam_status covbeam_emission_guide_fill(uint32_t side,
                                           const float *weights,
                                           size_t weight_count,
                                           float even,
                                           float *guide,
                                           size_t guide_count);

/**
 * Where points of the unit square go, and how dense they are there.
 *
 * @param side as it was for covbeam_emission_guide_fill.
 * @param guide, guide_count what it has written: all of it is looked at once a call.
 * @param count number of points; with 0 nothing is done.
 * @param points, point_stride pairs of numbers in [0, 1), such as covbeam_path_numbers of dimensions 0 and 1.
 * @param places, place_stride receive where they go: pairs of numbers in [0, 1), with which the lamp's place and
 *     direction are drawn.
 * @param densities, density_stride receive the density of points there, whose mean over the square is 1, and
 *     which is at least `even`: divide the path's power by it.
 */
covbeam_status covbeam_emission_guide_warp(uint32_t side,
                                           const float *guide,
                                           size_t guide_count,
                                           size_t count,
                                           const float *points,
                                           size_t point_stride,
                                           float *places,
                                           size_t place_stride,
                                           float *densities,
                                           size_t density_stride);

/**
 * Makes a grid in the host's memory, which is the grid's until it is freed: between calls on the grid the host
 * may read it, and write it too (numbers that deposits cannot make are voxels without data).
 *
 * @param layout box and resolution.
 * @param cells, cell_count as many as the layout has; their content stays: zero them for an empty grid.
 * @param means, mean_count as many as the layout has; written by covbeam_grid_resolve.
 * @param out the handle.
 */
covbeam_status covbeam_grid_new_in(const struct covbeam_grid_layout *layout,
                                   struct covbeam_grid_cell *cells,
                                   size_t cell_count,
                                   struct covbeam_fluence_cell *means,
                                   size_t mean_count,
                                   struct covbeam_grid **out);

/**
 * The grid's box and resolution.
 *
 * @param grid the grid.
 * @param layout receives them.
 */
covbeam_status covbeam_grid_get_layout(const struct covbeam_grid *grid, struct covbeam_grid_layout *layout);

/**
 * Adds spectra to the voxels around points, in their order: for hosts that estimate bandwidth in a way of
 * their own.
 *
 * @param grid the grid.
 * @param count number of points; with 0 nothing is done.
 * @param positions, position_stride points [m]; one outside the grid adds nothing.
 * @param spectra, spectrum_stride spectra [cycles^2/m^2], finite; covariances, or the grid cannot be saved.
 * @param weights, weight_stride contributions to the fluence [W m], finite and >= 0.
 */
covbeam_status covbeam_grid_deposit_spectra(struct covbeam_grid *grid,
                                            size_t count,
                                            const float *positions,
                                            size_t position_stride,
                                            const struct covbeam_spectrum *spectra,
                                            size_t spectrum_stride,
                                            const float *weights,
                                            size_t weight_stride);

/**
 * The spectrum of the fluence around points: the flux-weighted mean of the eight voxels around each, with
 * trilinear weights.
 *
 * @param grid a grid that has been resolved.
 * @param count number of points; with 0 nothing is done.
 * @param positions, position_stride points [m].
 * @param spectra, spectrum_stride receive the spectra [cycles^2/m^2]; 0 where the grid has no data.
 * @param found, found_stride receive 1, or 0 where the grid has no data: outside, and where no light has
 *     passed. May be NULL.
 * @note Thesis Eq 5.15. 20 ns a point.
 */
covbeam_status covbeam_grid_look_up(const struct covbeam_grid *grid,
                                    size_t count,
                                    const float *positions,
                                    size_t position_stride,
                                    struct covbeam_spectrum *spectra,
                                    size_t spectrum_stride,
                                    uint8_t *found,
                                    size_t found_stride);

/**
 * What the voxels have collected, to read or to upload.
 *
 * @param grid the grid.
 * @param cells receives the first; valid until the grid is changed or freed.
 * @param count receives their number.
 */
covbeam_status covbeam_grid_get_cells(const struct covbeam_grid *grid,
                                      const struct covbeam_grid_cell **cells,
                                      size_t *count);

/**
 * The mean spectra that look-ups see, to read or to upload.
 *
 * @param grid a grid that has been resolved.
 * @param means receives the first; valid until the grid is changed or freed.
 * @param count receives their number.
 */
covbeam_status covbeam_grid_get_means(const struct covbeam_grid *grid,
                                      const struct covbeam_fluence_cell **means,
                                      size_t *count);

/**
 * The progressive radius of a pass: r_1 = radius, r_(i+1) = r_i (i + alpha) / (i + 1).
 *
 * @param radius of pass 1 [m] > 0.
 * @param alpha in (0, 1]; 1 keeps the radius.
 * @param pass i, counted from 1.
 * @param result [m].
 * @note A few ns a pass up to pass 4096, and no more from there on. Jarosz et al. 2011.
 */
covbeam_status covbeam_progressive_radius(float radius, float alpha, uint32_t pass, float *result);

/**
 * The bound on the relative bias in a pass: error x pass^(-2/5), so that the bias of the mean over passes goes
 * to 0.
 *
 * @param error in pass 1, > 0.
 * @param pass counted from 1.
 * @param result the bound in that pass.
 */
covbeam_status covbeam_error_bound(float error,
                                   uint32_t pass,
                                   float *result);

/**
 * A kernel's value K_r(d).
 *
 * @param shape a value of covbeam_kernel_shape.
 * @param distance d [m], of either sign.
 * @param radius r [m] > 0.
 * @param value [1/m]: 0 where the distance is r or more.
 */
covbeam_status covbeam_kernel_evaluate(uint32_t shape, float distance, float radius, float *value);

/**
 * Second moment of a kernel of radius 1; that of radius r is r^2 times it.
 *
 * @param shape a value of covbeam_kernel_shape.
 * @param moment of the kernel.
 */
covbeam_status covbeam_kernel_second_moment(uint32_t shape, float *moment);

/**
 * The radius at which the kernel costs a relative bias: sqrt(error / (2 pi^2 second_moment variance)).
 *
 * @param shape a value of covbeam_kernel_shape.
 * @param error the relative bias > 0.
 * @param variance of the fluence's spectrum along the kernel's axis [cycles^2/m^2] >= 0; infinity gives 0.
 * @param radius [m]: infinite for a variance of 0.
 * @note Thesis 5.3.4.
 */
covbeam_status covbeam_kernel_radius_from_error(uint32_t shape, float error, float variance, float *radius);

/**
 * The kernel radius of a pair of beam and eye ray.
 *
 * @param kernel the kernel of the pass.
 * @param grid where the spectrum is looked up, resolved; NULL gives the progressive radius.
 * @param count number of pairs; with 0 nothing is done.
 * @param positions, position_stride the closest point on the eye ray [m].
 * @param axes, axis_stride of the kernel, unit, across ray and beam: that of the covbeam_crossing.
 * @param radii, radius_stride [m] in [min_radius, max_radius].
 * @param sigmas, sigma_stride deviation of the spectrum along the axis [cycles/m]; 0 where the grid has no
 *     data.
 * @note Thesis 5.3.4.
 */
covbeam_status covbeam_kernel_radius_at_many(const struct covbeam_kernel *kernel,
                                             const struct covbeam_grid *grid,
                                             size_t count,
                                             const float *positions,
                                             size_t position_stride,
                                             const float *axes,
                                             size_t axis_stride,
                                             float *radii,
                                             size_t radius_stride,
                                             float *sigmas,
                                             size_t sigma_stride);

static inline covbeam_status covbeam_kernel_radius_at(const struct covbeam_kernel *kernel,
                                                      const struct covbeam_grid *grid, const float *position,
                                                      const float *axis, float *radius, float *sigma)
{
    return covbeam_kernel_radius_at_many(kernel, grid, 1, position, 0, axis, 0, radius, 0, sigma, 0);
}

/**
 * How many beams a map has.
 *
 * @param map the map, committed or not.
 * @param count receives their number.
 */
covbeam_status covbeam_beam_map_get_count(const struct covbeam_beam_map *map, size_t *count);

/**
 * How much memory a map holds.
 *
 * @param map the map, committed or not.
 * @param bytes receives it.
 */
covbeam_status covbeam_beam_map_get_memory(const struct covbeam_beam_map *map, size_t *bytes);

/**
 * Closest approach of an eye ray's line and a beam's line.
 *
 * @param ray the eye ray; its length does not matter.
 * @param count number of beams; with 0 nothing is done.
 * @param beams, beam_stride the beam; its length does not matter.
 * @param crossings, crossing_stride the closest approach; untouched if they are nearly parallel.
 * @param crosses, cross_stride 1, or 0 if the sine of the angle between them is below 1e-5: the crossing
 *     would be rounding. (covbeam_gather_pair needs none below .05.)
 */
covbeam_status covbeam_cross_many(const struct covbeam_eye_ray *ray,
                                  size_t count,
                                  const struct covbeam_beam *beams,
                                  size_t beam_stride,
                                  struct covbeam_crossing *crossings,
                                  size_t crossing_stride,
                                  uint8_t *crosses,
                                  size_t cross_stride);

static inline covbeam_status covbeam_cross(const struct covbeam_eye_ray *ray, const struct covbeam_beam *beam,
                                           struct covbeam_crossing *crossing, uint8_t *cross)
{
    return covbeam_cross_many(ray, 1, beam, 0, crossing, 0, cross, 0);
}

/**
 * Gathers one beam, and adds it to what the eye ray has gathered: scattering x phase function x transmittance
 * along both x flux of the beam x kernel(gap) / sin(angle), if the gap is less than the kernel's radius,
 * looked up on the eye ray. Where that sine is below .05 it is the integral along the eye ray of a kernel on
 * both axes across the beam, finite down to parallel pairs, from eight places.
 *
 * @param ray the eye ray.
 * @param count number of beams; with 0 nothing is done.
 * @param beams, beam_stride the beam, in the same medium.
 * @param froms, from_stride, tos, to_stride part of the beam that counts [m] >= 0, [from, to): 0 and the
 *     beam's length, or more, for all of it. Cutting a beam into adjoining parts changes nothing.
 * @param medium that both lie in.
 * @param ray_column along the ray; NULL takes the closed form (voxels have none: COVBEAM_NULL_POINTER).
 * @param beam_columns, beam_column_stride along the beams; NULL likewise, for all of them.
 * @param kernel the kernel of the pass.
 * @param grid as in covbeam_kernel_radius_at.
 * @param gathered in and out, one for all beams, added in their order: finite numbers, all 0 to begin with.
 *     Its pairs need room for eight a beam.
 * @param accepted, accepted_stride 1 if the pair counts, else 0.
 * @note Thesis 5.3.4. A beam that starts or ends on a surface is cut by its tangent plane. The order of the
 *     columns' knots is not checked.
 */
covbeam_status covbeam_gather_pairs(const struct covbeam_eye_ray *ray,
                                    size_t count,
                                    const struct covbeam_beam *beams,
                                    size_t beam_stride,
                                    const float *froms,
                                    size_t from_stride,
                                    const float *tos,
                                    size_t to_stride,
                                    const struct covbeam_medium *medium,
                                    const struct covbeam_column *ray_column,
                                    const struct covbeam_column *beam_columns,
                                    size_t beam_column_stride,
                                    const struct covbeam_kernel *kernel,
                                    const struct covbeam_grid *grid,
                                    struct covbeam_gathered *gathered,
                                    uint8_t *accepted,
                                    size_t accepted_stride);

static inline covbeam_status covbeam_gather_pair(const struct covbeam_eye_ray *ray,
                                                 const struct covbeam_beam *beam, float from, float to,
                                                 const struct covbeam_medium *medium,
                                                 const struct covbeam_column *ray_column,
                                                 const struct covbeam_column *beam_column,
                                                 const struct covbeam_kernel *kernel,
                                                 const struct covbeam_grid *grid,
                                                 struct covbeam_gathered *gathered, uint8_t *accepted)
{
    return covbeam_gather_pairs(ray, 1, beam, 0, &from, 0, &to, 0, medium, ray_column, beam_column, 0, kernel,
                                grid, gathered, accepted, 0);
}

/**
 * Which of many beams an eye ray may be paired with: eight at a time, without looking at grid or surfaces.
 * Errs towards accepting: covbeam_gather_pair refuses every beam that it
 * refuses.
 *
 * @param ray the eye ray.
 * @param count number of beams; with 0 nothing is done.
 * @param beams, beam_stride the beams, each as a whole.
 * @param max_radius largest kernel radius [m] > 0: that of the covbeam_kernel.
 * @param masks, mask_stride 1 for a beam that may come within the max_radius, else 0.
 */
covbeam_status covbeam_filter_beams(const struct covbeam_eye_ray *ray,
                                    size_t count,
                                    const struct covbeam_beam *beams,
                                    size_t beam_stride,
                                    float max_radius,
                                    uint8_t *masks,
                                    size_t mask_stride);

/**
 * The reconstruction filter that blurs the picture by a relative bias: a Gaussian of covariance
 * error / (4 pi^2) x the inverse of the spectrum's, wide where the spectrum is narrow.
 *
 * @param count number of pixels; with 0 nothing is done.
 * @param spectra, spectrum_stride the spectrum around the pixel.
 * @param errors, error_stride the relative bias > 0, half of it along each principal axis.
 * @param widests, widest_stride largest standard deviation [pixels] > 0.
 * @param filters, filter_stride all 0 where the spectrum has a weight of 0.
 * @note Thesis 5.3.2, whose filter has an error of 1.
 */
covbeam_status covbeam_image_spectra_filter(size_t count,
                                            const struct covbeam_image_spectrum *spectra,
                                            size_t spectrum_stride,
                                            const float *errors,
                                            size_t error_stride,
                                            const float *widests,
                                            size_t widest_stride,
                                            struct covbeam_image_filter *filters,
                                            size_t filter_stride);

static inline covbeam_status covbeam_image_spectrum_filter(const struct covbeam_image_spectrum *spectrum,
                                                           float error, float widest,
                                                           struct covbeam_image_filter *filter)
{
    return covbeam_image_spectra_filter(1, spectrum, 0, &error, 0, &widest, 0, filter, 0);
}

/**
 * Eye rays that a pixel needs in a pass: two under each filter.
 *
 * @param count number of pixels; with 0 nothing is done.
 * @param filters, filter_stride the pixel's filter.
 * @param densities, density_stride in (0, 1]; no filter gives 1.
 * @note Thesis 5.3.2.
 */
covbeam_status covbeam_image_filters_density(size_t count,
                                             const struct covbeam_image_filter *filters,
                                             size_t filter_stride,
                                             float *densities,
                                             size_t density_stride);

static inline covbeam_status covbeam_image_filter_density(const struct covbeam_image_filter *filter,
                                                          float *density)
{
    return covbeam_image_filters_density(1, filter, 0, density, 0);
}

/**
 * How much memory a film holds.
 *
 * @param film the film.
 * @param bytes receives it.
 */
covbeam_status covbeam_film_get_memory(const struct covbeam_film *film, size_t *bytes);

/**
 * Makes an empty importance: 24 bytes a voxel, and 12 more from the first covbeam_importance_resolve on.
 *
 * @param layout box and resolution: of the lit fog, and coarse. Importance is smooth.
 * @param out the handle.
 */
covbeam_status covbeam_importance_new(const struct covbeam_grid_layout *layout,
                                      struct covbeam_importance **out);

/**
 * Frees an importance.
 *
 * @param importance NULL is ignored.
 */
covbeam_status covbeam_importance_free(struct covbeam_importance *importance);

/**
 * Adds pieces of eye rays: beams that cross them are seen.
 *
 * @param importance what is added to.
 * @param medium what the pieces run through; the means of the channels count.
 * @param count number of pieces; with 0 nothing is done.
 * @param rays, ray_stride the pieces.
 * @param weights, weight_stride of the ray at the piece's origin, finite and >= 0. At the camera it is
 *     1/(N L), for N pixels and the luminance L that this one has about: pixels count by their relative
 *     errors. Where L is next to nothing, bound it.
 * @note Costs what covbeam_importance_of_segments does.
 */
covbeam_status covbeam_importance_add_eye_rays(struct covbeam_importance *importance,
                                               const struct covbeam_medium *medium,
                                               size_t count,
                                               const struct covbeam_eye_ray *rays,
                                               size_t ray_stride,
                                               const float *weights,
                                               size_t weight_stride);

/**
 * Adds segments that paths from the camera fly after they were scattered, by the medium or by a diffuse
 * surface: light that is scattered on them goes on to where the camera sees it.
 *
 * @param importance what is added to.
 * @param medium what the segments run through; the means of the channels count.
 * @param count number of segments; with 0 nothing is done.
 * @param paths, path_stride the segments, away from the camera.
 * @param weights, weight_stride of the path at the segment's origin, finite and >= 0: that at the camera, times
 *     what scattering has left of it, over the probability that the path goes there.
 * @note Costs what covbeam_importance_of_segments does.
 */
covbeam_status covbeam_importance_add_paths(struct covbeam_importance *importance,
                                            const struct covbeam_medium *medium,
                                            size_t count,
                                            const struct covbeam_eye_ray *paths,
                                            size_t path_stride,
                                            const float *weights,
                                            size_t weight_stride);

/**
 * Adds places on diffuse surfaces that paths from the camera see. One outside the box adds nothing.
 *
 * @param importance what is added to.
 * @param count number of places; with 0 nothing is done.
 * @param positions, position_stride the places [m].
 * @param weights, weight_stride of the path there times albedo/pi, finite and >= 0.
 */
covbeam_status covbeam_importance_add_surfaces(struct covbeam_importance *importance,
                                               size_t count,
                                               const float *positions,
                                               size_t position_stride,
                                               const float *weights,
                                               size_t weight_stride);

/**
 * Adds what others of the same layout have collected, in their order.
 *
 * @param importance what is added to.
 * @param others array of other_count handles, none of them `importance`; they stay as they are.
 * @param other_count number of handles; with 0 nothing is done.
 */
covbeam_status covbeam_importance_merge(struct covbeam_importance *importance,
                                        const struct covbeam_importance *const *others,
                                        size_t other_count);

/**
 * Computes the importance of every voxel, smoothed over its neighbours, for look-ups; they see the state of this
 * call until the next one. Where there is any, it is at least a thousandth of its mean everywhere.
 *
 * @param importance what is resolved.
 */
covbeam_status covbeam_importance_resolve(struct covbeam_importance *importance);

/**
 * The importance around points: of light that is scattered there, or arrives on a surface.
 *
 * @param importance one that has been resolved.
 * @param count number of points; with 0 nothing is done.
 * @param positions, position_stride the points [m]; outside the box that of the nearest voxel.
 * @param cells, cell_stride receive it.
 */
covbeam_status covbeam_importance_at(const struct covbeam_importance *importance,
                                     size_t count,
                                     const float *positions,
                                     size_t position_stride,
                                     struct covbeam_importance_cell *cells,
                                     size_t cell_stride);

/**
 * What a watt that flies along segments of light paths is worth: to weigh directions in which a path may go on,
 * and collisions on its way. Nothing outside the box.
 *
 * @param importance one that has been resolved.
 * @param medium what the segments run through; the means of the channels count.
 * @param count number of segments; with 0 nothing is done.
 * @param segments, segment_stride the segments, each to the next surface, with the direction of the light.
 * @param worths, worth_stride receive it. On a surface behind, worth there is transmittance times what
 *     covbeam_importance_at says: surface, and albedo times scattered.
 * @note About 5 ns a voxel on the way.
 */
covbeam_status covbeam_importance_of_segments(const struct covbeam_importance *importance,
                                              const struct covbeam_medium *medium,
                                              size_t count,
                                              const struct covbeam_eye_ray *segments,
                                              size_t segment_stride,
                                              struct covbeam_segment_importance *worths,
                                              size_t worth_stride);

/**
 * Splits and ends light paths: of some candidates, such as directions in which a path may go on or the paths
 * of a wave, which do, and by what their power is multiplied. The mean of each factor over u is 1, so that
 * nothing is added to the light or lost; of all together as many go on as are expected, up to one.
 *
 * @param count number of candidates; with 0 nothing is done.
 * @param factors, factor_stride in: of each candidate, how many of it should go on: its power times its
 *     importance, over what power times importance is to be; finite and >= 0, and above 0 unless it carries no
 *     light. Out: the factor of its power, 0 where it ends. It goes on once, also where it could more often.
 * @param u uniform in [0, 1), a new one for each call.
 * @note Booth and Hendricks 1984; systematic resampling, Baker 1987.
 */
covbeam_status covbeam_weight_window(size_t count,
                                     float *factors,
                                     size_t factor_stride,
                                     float u);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* COVBEAM_EXTRA_H */
