/*
 * covbeam: frequency-aware photon beams. Fog, smoke and water lit by strong lights.
 * MIT or Apache-2.0. Made by cbindgen from ffi/src; do not edit.
 *
 * A pass of a picture
 *
 *   covbeam_schedule_kernel(&schedule, pass, &kernel);      radius and accepted error of this pass, counted from 1
 *   covbeam_beam_map_clear(map);                            one map for each medium
 *
 *   For each photon path of the host's tracer (a tenth of the paths also carry a light field):
 *       covbeam_light_field_point(direction, COVBEAM_EVEN_LAMP, &field);    at the lamp
 *       each straight piece through a medium is a covbeam_beam, and with a light field a covbeam_segment too
 *       covbeam_find_edges(direction, &hit, probe, user, segment.edges, &segment.edge_count);     what casts shadows
 *       covbeam_segment_field_at(&segment, &fog, distance, &field);         on to the next event: refract,
 *       covbeam_light_field_refract(&field, normal, &curvature, eta, &passed);      reflect, scatter, diffuse
 *
 *   covbeam_beam_map_add(map, beam_count, beams, sizeof *beams);
 *   covbeam_grid_deposit(grid, &fog, segment_count, segments, sizeof *segments);
 *   covbeam_grid_resolve(grid);
 *   covbeam_beam_map_commit(map, kernel.max_radius, NULL, NULL);
 *
 *   For each tile of 8x8 pixels: rays of the host's camera, cut by surfaces into pieces inside one medium:
 *       covbeam_beam_map_gather(map, &kernel, grid, 64, rays, sizeof *rays, gathered, sizeof *gathered,
 *                               scratch, NULL, NULL);
 *       pixel += weight of the piece x gathered.radiance;   the mean over the passes is the picture
 *
 * examples/c is a whole host.
 *
 * Few eye rays where the picture is smooth: covbeam_film_*. Few shadow rays for light scattered once: covbeam_march_*.
 * Photons where the picture needs them: covbeam_importance_*, covbeam_weight_window, covbeam_emission_guide_*.
 *
 * Conventions
 *
 * Units: any unit of length will do (written m here), power in watts per channel, angles in radians,
 * frequencies in cycles/m and cycles/rad. Axes are right-handed. A direction of propagation is the light's,
 * away from the lamp.
 *
 * Pointers: none may be NULL unless that is said. A `const float*` that is a vector points to 3 floats;
 * other lengths are said. What a pointer shows must stay readable (or writable) during the call, and
 * outputs must not overlap inputs. Pointers and strides are multiples of the alignment of what they point
 * to.
 *
 * Arrays: count, first element, stride. Element i lies stride x i bytes after the first. The stride of an
 * input may be 0: all elements are then the first. Elements of an output must not overlap. With a count of
 * 0 the pointer is not looked at.
 *
 * Names: covbeam_light_fields_travel is covbeam_light_field_travel for many fields;
 * covbeam_medium_density_at_many asks one medium about many points. Both do what the single function does,
 * to the bit, and check all elements before they change the first.
 *
 * Options: structs that begin with struct_size, which is to be set to sizeof of themselves. Fields that a
 * newer header adds are 0 for an older host; an older library refuses new fields that are not 0.
 *
 * Failure: every function that can fail returns a covbeam_status. All but COVBEAM_OK leave the outputs
 * unwritten and the objects as they were, and covbeam_last_error() says which parameter it was and what to
 * do. NaN, infinities without a meaning, and vectors that should have a direction but do not are refused.
 * Nothing is ever printed. A defect of the library that ends in a panic returns COVBEAM_PANICKED; the
 * object that the call was changing then answers COVBEAM_POISONED until it is freed.
 *
 * Handles: made by _new, freed by _free, for which NULL is fine. A handle of the wrong kind is refused; one
 * that has been freed often is, but do not rely on that: its memory may be in other use.
 *
 * Threads: objects passed by pointer to const may be used by several threads at once, those passed without
 * const by one at a time. The library starts no thread and keeps no state but each thread's last message.
 * The same calls give the same bits.
 *
 * Costs: an operator of a light field takes 0.1 to 0.5 us; whatever costs more says so. Everything is
 * linear in its counts unless that is said.
 *
 * Versions: COVBEAM_ABI_VERSION changes when a host must be compiled anew, and with it the SONAME, which is
 * libcovbeam.so.1 now.
 */


#ifndef COVBEAM_H
#define COVBEAM_H

#include <stddef.h>
#include <stdint.h>

/**
 * Of the ABI that the header declares. A host compares it with covbeam_abi_version().
 */
#define COVBEAM_ABI_VERSION 2

/**
 * Most edges of a segment.
 */
#define COVBEAM_MOST_EDGES 4

/**
 * Angular variance of the emission of a lamp that shines evenly [cycles^2/rad^2]: its light falls off as 1/d^2, a relative curvature of
 * 2/d^2 across its rays, so that 2/(4 pi^2).
 */
#define COVBEAM_EVEN_LAMP 0.05066059

/**
 * Decisions of a light path that covbeam_path_number stratifies.
 */
#define COVBEAM_EMISSION_DIMENSIONS 8

/**
 * How a call ended. All but COVBEAM_OK have changed nothing, unless the function says otherwise.
 */
enum covbeam_status
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * Done.
     */
    COVBEAM_OK = 0,
    /**
     * A pointer is NULL that may not be.
     */
    COVBEAM_NULL_POINTER = 1,
    /**
     * A pointer or a stride is not a multiple of the alignment of what it points to.
     */
    COVBEAM_MISALIGNED = 2,
    /**
     * A number is NaN, infinite or out of its range, a vector has no length, or a struct_size is unknown.
     */
    COVBEAM_INVALID_VALUE = 3,
    /**
     * A count or a stride that no array in memory can have, or more elements than the library takes.
     */
    COVBEAM_INVALID_ARRAY = 4,
    /**
     * A buffer is not as long as it must be.
     */
    COVBEAM_SHORT_BUFFER = 5,
    /**
     * The pointer is not a handle of this kind, or no longer.
     */
    COVBEAM_INVALID_HANDLE = 6,
    /**
     * The call comes too early or too late in the cycle of its object.
     */
    COVBEAM_WRONG_ORDER = 7,
    /**
     * Two objects that must agree do not, such as the layouts of two grids.
     */
    COVBEAM_MISMATCH = 8,
    /**
     * The bytes are not what the library saves.
     */
    COVBEAM_BAD_DATA = 9,
    /**
     * Memory could not be had.
     */
    COVBEAM_OUT_OF_MEMORY = 10,
    /**
     * The host's poll asked to stop.
     */
    COVBEAM_CANCELLED = 11,
    /**
     * The host's shade callback reported a failure.
     */
    COVBEAM_CALLBACK_FAILED = 12,
    /**
     * An earlier call on this object ended in COVBEAM_PANICKED: free it.
     */
    COVBEAM_POISONED = 13,
    /**
     * A defect of the library: please report the message.
     */
    COVBEAM_PANICKED = 14,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum covbeam_status covbeam_status;
#else
typedef int32_t covbeam_status;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * How the density of a medium varies in space.
 */
enum covbeam_density_kind
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * 1 everywhere: a homogeneous medium.
     */
    COVBEAM_DENSITY_UNIFORM = 0,
    /**
     * exp(-height / scale_height).
     */
    COVBEAM_DENSITY_EXPONENTIAL = 1,
    /**
     * A covbeam_density.
     */
    COVBEAM_DENSITY_VOXELS = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum covbeam_density_kind covbeam_density_kind;
#else
typedef uint32_t covbeam_density_kind;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Shape of the blur kernel K_r(d), whose integral over [-r, r] is 1. With q = d / r:
 */
enum covbeam_kernel_shape
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * 1 / (2r).
     */
    COVBEAM_KERNEL_BOX = 0,
    /**
     * 3 (1 - q^2) / (4r).
     */
    COVBEAM_KERNEL_EPANECHNIKOV = 1,
    /**
     * 15 (1 - q^2)^2 / (16r).
     */
    COVBEAM_KERNEL_BIWEIGHT = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum covbeam_kernel_shape covbeam_kernel_shape;
#else
typedef uint32_t covbeam_kernel_shape;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Which phase function.
 */
enum covbeam_phase_kind
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * The same in all directions.
     */
    COVBEAM_PHASE_ISOTROPIC = 0,
    /**
     * Henyey-Greenstein.
     */
    COVBEAM_PHASE_HENYEY_GREENSTEIN = 1,
    /**
     * Rayleigh.
     */
    COVBEAM_PHASE_RAYLEIGH = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum covbeam_phase_kind covbeam_phase_kind;
#else
typedef uint32_t covbeam_phase_kind;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * The beams of one medium and one pass. The cycle of a pass: clear, add (any number of times), commit, gather
 * (any number of times, from any number of threads).
 */
typedef struct covbeam_beam_map covbeam_beam_map;

/**
 * A relative density given at the centres of voxels, copied from the host. Nothing changes it: any number of
 * threads and beam maps may use it at once.
 */
typedef struct covbeam_density covbeam_density;

/**
 * Few eye rays for a picture whose light is smooth: where they are needed, what they saw, and the picture from
 * them. A pass:
 *
 * covbeam_film_plan from spectra at some pixels; covbeam_film_density, and an eye ray through each pixel whose
 * covbeam_pixel_threshold is below its density; covbeam_film_add what they saw. When a picture is wanted,
 * covbeam_film_verify, then covbeam_film_picture, by several threads at once. About 60 bytes a pixel, 40 more with light
 * from beyond the fog, and 35 or 70 once verified.
 */
typedef struct covbeam_film covbeam_film;

/**
 * A grid of fluence spectra. It collects (covbeam_grid_deposit), adds up (covbeam_grid_merge), is resolved
 * once the photons of a pass are in (covbeam_grid_resolve), and is looked up from then on, by
 * covbeam_beam_map_gather too. It keeps what it has collected over the passes of a picture.
 *
 * Deposits from several threads: give each *share of the photons*, not each thread, a grid of its own, and
 * merge these in their order. The result is then the same, to the bit, for any number of threads. With one
 * grid for all photons, deposit in order.
 */
typedef struct covbeam_grid covbeam_grid;

/**
 * Where the picture needs photons. Importance is the share of the picture's light, relative to its brightness,
 * that a watt brings about. It collects what the camera sees (covbeam_importance_add_eye_rays, _add_paths,
 * _add_surfaces), is resolved once, before the first pass, and is looked up from then on by what traces the
 * light. Only probabilities follow from it: a wrong importance costs noise and never makes a picture wrong.
 *
 * Several threads: as for covbeam_grid, one for each *share of the paths*, merged in order.
 */
typedef struct covbeam_importance covbeam_importance;

/**
 * The table along one eye ray, and the memory that placing shadow rays needs: one a thread, for one ray after
 * the other. For each ray: covbeam_march_lay and the host's radiances make the knots; covbeam_march_update;
 * covbeam_march_place, and the shadow rays of the round; covbeam_march_refine, and those of a second one.
 */
typedef struct covbeam_march covbeam_march;

/**
 * Memory that gathers need, kept from call to call: one a thread.
 */
typedef struct covbeam_scratch covbeam_scratch;

/**
 * Square root of the covariance of a local light field's spectrum. Made by covbeam_light_field_point and its
 * kin; the numbers are the host's to copy, store and send, not to write.
 */
typedef struct covbeam_light_field {
    /**
     * Lower-triangular L with covariance L L^T, rows (u, v, x, y), packed row by row [uu, vu, vv, xu, xv, xx,
     * yu, yv, yx, yy]: u, v in cycles/rad, x, y in cycles/m.
     */
    float root[10];
    /**
     * The frame's x axis: unit, across direction; y = direction x x_axis.
     */
    float x_axis[3];
    /**
     * Direction of propagation, unit.
     */
    float direction[3];
} covbeam_light_field;

/**
 * A phase function: how scattered light is spread over directions.
 */
typedef struct covbeam_phase {
    /**
     * A value of covbeam_phase_kind.
     */
    uint32_t kind;
    /**
     * Mean cosine of Henyey-Greenstein, in (-1, 1), forward positive; ignored by the others.
     */
    float asymmetry;
} covbeam_phase;

/**
 * A medium. Coefficients hold where the relative density is 1.
 *
 * covbeam_medium fog = { sizeof fog, { 0.2f, 0.2f, 0.2f } }; is homogeneous and isotropic.
 */
typedef struct covbeam_medium {
    /**
     * sizeof(covbeam_medium).
     */
    uint32_t struct_size;
    /**
     * Scattering coefficient per channel [1/m], each finite and >= 0.
     */
    float scattering[3];
    /**
     * Absorption coefficient per channel [1/m], each finite and >= 0; all coefficients add up to a finite
     * number.
     */
    float absorption[3];
    /**
     * How scattered light is spread.
     */
    struct covbeam_phase phase;
    /**
     * A value of covbeam_density_kind; the fields below are read as it needs them.
     */
    uint32_t density;
    /**
     * Exponential: a point where the density is 1 [m].
     */
    float origin[3];
    /**
     * Exponential: direction in which the density falls, any length but 0.
     */
    float up[3];
    /**
     * Exponential: height over which it falls by the factor e [m] > 0.
     */
    float scale_height;
    /**
     * Voxels: the densities.
     */
    const struct covbeam_density *voxels;
} covbeam_medium;

/**
 * Curvature of a surface at a hit [1/m], positive where it is convex on the side of the normal; all 0 is a
 * plane.
 */
typedef struct covbeam_curvature {
    /**
     * First axis of the tensor, in the surface, any length; 0 if along equals across.
     */
    float tangent[3];
    /**
     * Normal curvature along tangent.
     */
    float along;
    /**
     * Normal curvature along normal x tangent.
     */
    float across;
    /**
     * The off-diagonal entry.
     */
    float twist;
} covbeam_curvature;

/**
 * Covariance of the spectrum of the fluence around a point, in world axes [cycles^2/m^2].
 */
typedef struct covbeam_spectrum {
    /**
     * Variance along world x.
     */
    float xx;
    /**
     * Variance along world y.
     */
    float yy;
    /**
     * Variance along world z.
     */
    float zz;
    /**
     * Covariance of x and y.
     */
    float xy;
    /**
     * Covariance of x and z.
     */
    float xz;
    /**
     * Covariance of y and z.
     */
    float yz;
} covbeam_spectrum;

/**
 * Box and resolution of a grid or of a density. Voxels lie in memory x first, then y, then z.
 */
typedef struct covbeam_grid_layout {
    /**
     * Lower corner [m].
     */
    float min[3];
    /**
     * Upper corner [m], above min on every axis.
     */
    float max[3];
    /**
     * Voxels along x, y, z, each >= 1; at most 2^24 in all.
     */
    uint32_t cells[3];
} covbeam_grid_layout;

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
 * A point of a table of columns.
 */
typedef struct covbeam_knot {
    /**
     * Distance along the ray [m].
     */
    float distance;
    /**
     * Integral of the relative density up to there [m].
     */
    float column;
} covbeam_knot;

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
 * Where a probe ray meets a surface, for covbeam_find_edges.
 */
typedef struct covbeam_probe_hit {
    /**
     * Along the probe [m] > 0; infinity where it meets nothing.
     */
    float distance;
    /**
     * Geometric normal, any length but 0, either side; not looked at where nothing is met.
     */
    float normal[3];
    /**
     * How far off this surface rays start that leave it [m], finite and >= 0; no farther than rounding asks
     * for. Nearer than 4096 times that, it is the surface which the ray itself left, and no edge.
     */
    float offset;
} covbeam_probe_hit;

/**
 * Casts a ray from the origin of the search along direction, 3 floats, unit. It sets hit to where the ray meets
 * the nearest surface that casts shadows; before the call distance is infinity, which is nothing met. Return 0,
 * or anything else to give up. Called in the thread of the call; it must return (no exception, no longjmp).
 */
typedef int32_t (*covbeam_probe)(void *user, const float *direction, struct covbeam_probe_hit *hit);

/**
 * An edge of an occluder beside a ray.
 */
typedef struct covbeam_edge {
    /**
     * Distance along the ray at which the edge passes by [m], finite; one at a depth <= 0 does not count.
     */
    float depth;
    /**
     * Distance from the ray to the edge there [m] >= 0; infinity is no edge.
     */
    float distance;
    /**
     * Direction from the ray to the nearest point of the edge, any length but 0.
     */
    float towards[3];
} covbeam_edge;

/**
 * A straight piece of a photon's path that carries a light field.
 */
typedef struct covbeam_segment {
    /**
     * Where it starts [m], in or out of the grid. It runs along field.direction.
     */
    float origin[3];
    /**
     * Length [m] > 0; infinity reaches the end of the grid.
     */
    float length;
    /**
     * Flux at the origin [W] > 0, mean of the channels.
     */
    float power;
    /**
     * 1 if the light comes from its source without scattering in a medium or on a diffuse surface (mirrors and
     * glass are no scattering), else 0.
     */
    uint32_t unscattered;
    /**
     * The light field at the origin.
     */
    struct covbeam_light_field field;
    /**
     * The edges that the light passes, sorted by depth: such as covbeam_find_edges finds, or 0.
     */
    struct covbeam_edge edges[COVBEAM_MOST_EDGES];
    /**
     * Number of edges that count.
     */
    uint32_t edge_count;
    /**
     * How the light is attenuated: NULL takes it from the medium. A host with media of its own gives a table
     * of (distance from the origin, optical depth up to there / extinction of the medium passed), both finite,
     * neither falling.
     */
    const struct covbeam_knot *knots;
    /**
     * Number of knots; 0 if knots is NULL.
     */
    size_t knot_count;
} covbeam_segment;

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
 * How the kernel shrinks over the passes of a picture.
 */
typedef struct covbeam_schedule {
    /**
     * sizeof(covbeam_schedule).
     */
    uint32_t struct_size;
    /**
     * A value of covbeam_kernel_shape.
     */
    uint32_t shape;
    /**
     * Progressive radius of pass 1 [m] > 0.
     */
    float radius;
    /**
     * In (0, 1]: the progressive radius falls as pass^(alpha - 1); 1 keeps it.
     */
    float alpha;
    /**
     * Largest radius that a spectrum may ask for [m] > 0.
     */
    float max_radius;
    /**
     * Accepted relative bias of a pair in pass 1, > 0; it falls as pass^(-2/5).
     */
    float error;
} covbeam_schedule;

/**
 * How wide the pairs of one pass are gathered: within max(min_radius, min(max_radius, what the spectrum
 * allows)).
 */
typedef struct covbeam_kernel {
    /**
     * sizeof(covbeam_kernel).
     */
    uint32_t struct_size;
    /**
     * A value of covbeam_kernel_shape.
     */
    uint32_t shape;
    /**
     * The radius where the grid has no data, and the smallest one [m] > 0.
     */
    float min_radius;
    /**
     * The largest radius [m], finite and >= min_radius.
     */
    float max_radius;
    /**
     * Accepted relative bias of a pair > 0; without a grid it has no effect.
     */
    float error;
} covbeam_kernel;

/**
 * A photon beam: a straight piece of a photon's path through a medium. It runs on to the next surface,
 * whatever the photon's free flight was; the gather multiplies by the transmittance ("long beams").
 */
typedef struct covbeam_beam {
    /**
     * Where it starts [m].
     */
    float origin[3];
    /**
     * Direction of propagation, unit.
     */
    float direction[3];
    /**
     * Length [m] to the next surface, finite and >= 0; where there is none, covbeam_medium_reach is far
     * enough.
     */
    float length;
    /**
     * Flux at the origin per channel [W], already divided by the number of light paths of the pass.
     */
    float power[3];
    /**
     * Unit normal of the surface on which it starts, towards the medium; 0 if it starts in the open.
     */
    float start_normal[3];
    /**
     * Unit normal of the surface on which it ends, towards the medium; 0 if it ends in the open.
     */
    float end_normal[3];
} covbeam_beam;

/**
 * Asked now and then during a long call, in the thread of the call: return 0 to go on, anything else to stop.
 * It must return (no exception, no longjmp) and must not use the objects of the call.
 */
typedef int32_t (*covbeam_poll)(void *user);

/**
 * One straight piece of an eye path inside one medium.
 */
typedef struct covbeam_eye_ray {
    /**
     * Where it starts [m].
     */
    float origin[3];
    /**
     * Direction, unit, away from the eye.
     */
    float direction[3];
    /**
     * Length [m] >= 0 to the next surface; infinity allowed.
     */
    float length;
} covbeam_eye_ray;

/**
 * What an eye ray has gathered.
 */
typedef struct covbeam_gathered {
    /**
     * In-scattered radiance at the ray's origin [W/(m^2 sr)].
     */
    float radiance[3];
    /**
     * Accepted pairs of ray and beam.
     */
    uint32_t pairs;
    /**
     * Sum over the pairs of their contribution (mean of the channels): the weight of the next two.
     */
    float weight;
    /**
     * Weighted sum of the kernel radii [m].
     */
    float radius;
    /**
     * Weighted sum of the light's bandwidth along the kernel's axis [cycles/m].
     */
    float sigma;
} covbeam_gathered;

/**
 * A place where a beam comes within the kernel radius of an eye ray, for covbeam_beam_map_gather_shaded.
 */
typedef struct covbeam_contact {
    /**
     * The closest point on the eye ray [m].
     */
    float position[3];
    /**
     * Index of the eye ray in the call.
     */
    uint32_t ray;
    /**
     * Index of the beam, in the order in which they were added.
     */
    uint32_t beam;
    /**
     * Distance along the eye ray [m].
     */
    float ray_distance;
    /**
     * Distance along the beam [m]; at an end on a surface it may be outside the beam by less than radius. At a
     * negative one, -s, the beam has the optical depth -(the one at s), as if the medium went on behind the
     * surface.
     */
    float beam_distance;
    /**
     * Cosine between the light's propagation before and after scattering towards the eye: forward +1.
     */
    float cos_theta;
    /**
     * The blur kernel over the sine of the angle between beam and ray [1/m], with which the library
     * multiplies.
     */
    float kernel;
    /**
     * Kernel radius [m].
     */
    float radius;
    /**
     * Bandwidth along the kernel's axis [cycles/m]; 0 without a grid.
     */
    float sigma;
} covbeam_contact;

/**
 * Fills values with three floats a contact: scattering coefficient x phase function x transmittance along the
 * eye ray up to the contact x transmittance along the beam up to it, per channel [1/(m sr)]. Return 0, or
 * anything else to give up. Called in the thread of the call; it must return (no exception, no longjmp) and
 * must not use the objects of the call.
 */
typedef int32_t (*covbeam_shade)(void *user,
                                 const struct covbeam_contact *contacts,
                                 size_t count,
                                 float *values);

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
 * How much an eye ray changes from one pixel to the next.
 */
typedef struct covbeam_pixel_step {
    /**
     * Of its origin [m/pixel]: 0 for a pinhole.
     */
    float origin[3];
    /**
     * Of its unit direction [1/pixel]: 0 for an orthographic camera. Only what is across the ray counts.
     */
    float direction[3];
} covbeam_pixel_step;

/**
 * Covariance of the spectrum of the in-scattered light around a pixel, in the plane of the picture
 * [cycles^2/pixel^2]: x to the right, y down.
 */
typedef struct covbeam_image_spectrum {
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
    /**
     * In-scattered light on the way, in the grid's relative unit; 0 = the grid has no data, and the other
     * numbers are 0.
     */
    float weight;
} covbeam_image_spectrum;

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

/**
 * What one eye ray saw of what it was asked for.
 */
typedef struct covbeam_film_ray {
    /**
     * x to the right and y down.
     */
    uint32_t pixel[2];
    /**
     * 1 if it was asked for the fog before the first surface, whose light is filtered; else 0.
     */
    uint32_t has_volume;
    /**
     * 1 if it was asked for what lies beyond, which the pixel keeps to itself; else 0.
     */
    uint32_t has_rest;
    /**
     * The fog's radiance, per channel, finite and not negative [W/(m^2 sr)].
     */
    float volume[3];
    /**
     * That of the rest.
     */
    float rest[3];
} covbeam_film_ray;

/**
 * A pixel of a picture.
 */
typedef struct covbeam_film_pixel {
    /**
     * All light, per channel [W/(m^2 sr)].
     */
    float radiance[3];
    /**
     * That of the fog before the first surface.
     */
    float volume[3];
    /**
     * Squared standard error of the filtered luminance; 0 = not known, or none is.
     */
    float variance;
    /**
     * Luminance of the odd passes minus that of the even ones, of the light that is not filtered.
     */
    float difference;
} covbeam_film_pixel;

/**
 * One knot of the table along an eye ray, from which shadow rays are placed.
 */
typedef struct covbeam_march_knot {
    /**
     * From the ray's origin [m].
     */
    float distance;
    /**
     * Light that one metre of the ray scatters to the eye if nothing is in the lights' way, as one number such
     * as its luminance [W/(m^3 sr)]: transmittance to the eye x scattering coefficient x phase function x
     * transmittance to the light x intensity / squared distance. NaN, infinity and negative numbers count as 0.
     */
    float radiance;
    /**
     * Standard deviation of the fluence's spectrum along the ray [cycles/m]: the root of
     * covbeam_spectrum_variance_along. NaN, infinity and negative numbers: not known.
     */
    float deviation;
    /**
     * Share of the light that is expected to arrive, in [0, 1], such as that of a few rays from the
     * light past this place. NaN and negative numbers: not known.
     */
    float visibility;
} covbeam_march_knot;

/**
 * What a table along an eye ray says before any shadow ray is traced.
 */
typedef struct covbeam_march_expected {
    /**
     * The light that is expected to be scattered to the eye [W/(m^2 sr)]: with the knots' visibility, half
     * where it is not known.
     */
    float radiance;
    /**
     * Expected standard deviation of the estimate from one round, times the number of its shadow rays
     * [W/(m^2 sr)]. To spread rays over pixels, give to each in proportion to a power of it.
     */
    float error;
} covbeam_march_expected;

/**
 * A place for a shadow ray.
 */
typedef struct covbeam_march_sample {
    /**
     * From the ray's origin [m].
     */
    float distance;
    /**
     * The sum over a round of weight x radiance x visibility, at distance, is the estimate of the light
     * scattered to the eye [m]. 0 = no shadow ray is needed.
     */
    float weight;
    /**
     * What the shadow ray found, in [0, 1], written by the host; read from the first round by
     * covbeam_march_refine.
     */
    float visibility;
    /**
     * 0.
     */
    uint32_t reserved;
    /**
     * The table's expected light up to distance [W/(m^2 sr)], by which covbeam_march_refine finds the first
     * round.
     */
    double mass;
} covbeam_march_sample;

/**
 * Importance around a point.
 */
typedef struct covbeam_importance_cell {
    /**
     * Of a watt of beam on each metre, with the medium's density [1/(W m)].
     */
    float beam;
    /**
     * Of a watt that is scattered there, by the medium or by a diffuse surface, into no direction more than
     * others [1/W].
     */
    float scattered;
    /**
     * Of a watt that arrives on surfaces there [1/W], but for what they scatter.
     */
    float surface;
} covbeam_importance_cell;

/**
 * What a watt that flies along a segment is worth.
 */
typedef struct covbeam_segment_importance {
    /**
     * As a beam, of a watt at the segment's start [1/W].
     */
    float beam;
    /**
     * Of what the medium scatters from a watt on its way [1/W].
     */
    float scattered;
    /**
     * What is left of a watt where it leaves the voxels, or at its end if that is before.
     */
    float transmittance;
} covbeam_segment_importance;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * The ABI of the library that runs, which is COVBEAM_ABI_VERSION of the header it was built with.
 *
 * Equal numbers fit together. The shared library's SONAME changes with it.
 */
uint32_t covbeam_abi_version(void);

/**
 * The version of the library that runs, such as "0.1.0".
 *
 * @return a static string.
 */
const char *covbeam_version(void);

/**
 * The name of a status, such as "COVBEAM_SHORT_BUFFER".
 *
 * @param status a value of covbeam_status; any other number gives "unknown status".
 * @return a static string, never NULL. Any thread, any time.
 */
const char *covbeam_status_name(int32_t status);

/**
 * What went wrong in the latest call of this thread that did not return COVBEAM_OK: names the parameter and
 * the remedy.
 *
 * @return UTF-8, at most 255 bytes, never NULL, empty before the first failure; valid until the thread's next
 *     call that fails.
 */
const char *covbeam_last_error(void);

/**
 * Light of an exact point source.
 *
 * @param direction of propagation, normalised by the library: any length but 0.
 * @param angular_variance of the emission [cycles^2/rad^2] >= 0: COVBEAM_EVEN_LAMP for a lamp that shines
 *     evenly, because of the fall-off with the square of the distance; more where its intensity changes with
 *     the angle.
 * @param out the light field.
 * @note Thesis 5.3.1.
 */
covbeam_status covbeam_light_field_point(const float *direction,
                                         float angular_variance,
                                         struct covbeam_light_field *out);

/**
 * Light of a disk source, at its centre.
 *
 * @param direction of propagation, normalised by the library: any length but 0.
 * @param normal of the disk, any length, either sign.
 * @param radius [m] >= 0: 0 is a point, infinity a uniform field.
 * @param angular_variance as for covbeam_light_field_point.
 * @param out the light field.
 * @note Thesis 5.3.1.
 */
covbeam_status covbeam_light_field_disk(const float *direction,
                                        const float *normal,
                                        float radius,
                                        float angular_variance,
                                        struct covbeam_light_field *out);

/**
 * An exactly parallel beam, such as sunlight or a laser.
 *
 * @param direction of propagation, normalised by the library: any length but 0.
 * @param radius of the beam [m] >= 0: infinity for a uniform one.
 * @param out the light field.
 * @note Thesis 5.3.1.
 */
covbeam_status covbeam_light_field_collimated(const float *direction,
                                              float radius,
                                              struct covbeam_light_field *out);

/**
 * A light field without correlations, from its four variances. A Gaussian of standard deviation w has 1/(4
 * pi^2 w^2).
 *
 * @param direction of propagation, normalised by the library: any length but 0.
 * @param x_axis its part across the direction is the x axis of the variances; some axis if it has none.
 * @param spatial_variance along x and y [cycles^2/m^2], each >= 0: 0 is uniform, infinity a point or a line.
 * @param angular_variance along x and y [cycles^2/rad^2], each >= 0: 0 is isotropic, infinity parallel.
 * @param out the light field.
 * @note Thesis Eq 5.12.
 */
covbeam_status covbeam_light_field_gaussian(const float *direction,
                                            const float *x_axis,
                                            const float *spatial_variance,
                                            const float *angular_variance,
                                            struct covbeam_light_field *out);

/**
 * Travel through vacuum or a homogeneous medium.
 *
 * @param field the light field, changed in place.
 * @param distance [m], finite; 0 changes nothing, a negative one goes back.
 * @note Thesis 5.3.1.
 */
covbeam_status covbeam_light_field_travel(struct covbeam_light_field *field, float distance);

/**
 * Travel through a medium: in a homogeneous one covbeam_light_field_travel, else with the attenuation that
 * varies across the ray.
 *
 * @param field the light field, changed in place; it moves along its direction.
 * @param medium what it travels in; the mean extinction of the channels counts.
 * @param origin where the field is [m].
 * @param distance [m] >= 0, finite.
 * @note Thesis 5.3.1. Costs up to 256 look-ups of the density's derivatives.
 */
covbeam_status covbeam_light_field_carry(struct covbeam_light_field *field,
                                         const struct covbeam_medium *medium,
                                         const float *origin,
                                         float distance);

/**
 * Turns the frame about the ray, to read covbeam_light_field_slice along given axes. The light stays what it
 * is.
 *
 * @param field the light field, changed in place.
 * @param x_axis any length but 0; its part across the ray becomes the x axis; along the ray: nothing changes.
 * @note Thesis 5.3.1.2.
 */
covbeam_status covbeam_light_field_rotate(struct covbeam_light_field *field, const float *x_axis);

/**
 * Reflection by a smooth mirror. A ray that grazes it to below 1e-12 is left as it was.
 *
 * @param field the light field, changed in place.
 * @param normal at the hit, any length, either side.
 * @param curvature of the surface on the side of the normal; may be NULL: a plane.
 * @note Coddington's equations.
 */
covbeam_status covbeam_light_field_reflect(struct covbeam_light_field *field,
                                           const float *normal,
                                           const struct covbeam_curvature *curvature);

/**
 * Refraction through a smooth surface.
 *
 * @param field the light field, changed in place.
 * @param normal at the hit, any length, either side.
 * @param curvature of the surface on the side of the normal; may be NULL: a plane.
 * @param eta refractive index on the incoming side over that on the other, > 0.
 * @param passed 1 if light passes; 0 on total reflection (and exactly grazing light), which leaves the field
 *     as it was.
 * @note Coddington's equations.
 */
covbeam_status covbeam_light_field_refract(struct covbeam_light_field *field,
                                           const float *normal,
                                           const struct covbeam_curvature *curvature,
                                           float eta,
                                           uint8_t *passed);

/**
 * Occlusion by an edge beside the ray, such as a silhouette that it passes.
 *
 * @param field the light field, changed in place.
 * @param towards_edge from the ray to the nearest point of the edge, any length; along the ray: nothing
 *     changes.
 * @param distance between ray and edge [m] >= 0; infinity is no edge.
 * @note Thesis 5.3.1.
 */
covbeam_status covbeam_light_field_occlude(struct covbeam_light_field *field,
                                           const float *towards_edge,
                                           float distance);

/**
 * Attenuation by a stretch of medium whose optical depth varies across the ray. covbeam_light_field_carry does
 * this for the built-in media.
 *
 * @param field the light field, changed in place.
 * @param gradient of the optical depth of the stretch, in world axes [1/m].
 * @param hessian of the same, [xx, yy, zz, xy, xz, yz] [1/m^2].
 * @note Thesis 5.3.1.
 */
covbeam_status covbeam_light_field_attenuate(struct covbeam_light_field *field,
                                             const float *gradient,
                                             const float *hessian);

/**
 * Narrowing of the directions across one axis, such as by the soft rim of a spot light (a Gaussian rim of
 * standard deviation s has 1/(4 pi^2 s^2)).
 *
 * @param field the light field, changed in place.
 * @param across in which the light falls off, any length; along the ray: nothing changes.
 * @param angular_variance [cycles^2/rad^2] >= 0: 0 changes nothing, infinity leaves one direction.
 * @note Thesis 5.3.1.
 */
covbeam_status covbeam_light_field_narrow(struct covbeam_light_field *field,
                                          const float *across,
                                          float angular_variance);

/**
 * Scattering in a medium, or by a rough surface's lobe, into a new direction.
 *
 * @param field the light field, changed in place.
 * @param direction of propagation after the event, any length but 0.
 * @param angular_variance of the lobe [cycles^2/rad^2] >= 0, see covbeam_phase_angular_variance: 0 is
 *     isotropic, infinity does not blur.
 * @note Thesis 5.3.1.
 */
covbeam_status covbeam_light_field_scatter(struct covbeam_light_field *field,
                                           const float *direction,
                                           float angular_variance);

/**
 * Diffuse reflection or transmission into a new direction. A cosine below 1e-12 on either side leaves the
 * field as it was.
 *
 * @param field the light field, changed in place.
 * @param normal of the surface, any length, either sign.
 * @param direction of propagation after the event, any length but 0.
 * @note Thesis 5.3.1.
 */
covbeam_status covbeam_light_field_diffuse(struct covbeam_light_field *field,
                                           const float *normal,
                                           const float *direction);

/**
 * The spectrum of the fluence across the ray, along the frame's axes.
 *
 * @param field the light field.
 * @param variances [xx, xy, yy] [cycles^2/m^2].
 * @note Thesis Eq 5.14.
 */
covbeam_status covbeam_light_field_slice(const struct covbeam_light_field *field, float *variances);

/**
 * The spectrum of the fluence around the ray, in world axes.
 *
 * @param field the light field.
 * @param limit largest deviation kept [cycles/m] > 0, such as the Nyquist frequency 1/(2h) of voxels of side
 *     h; infinity keeps all.
 * @param spectrum covariance [cycles^2/m^2].
 * @note Thesis Eq 5.14.
 */
covbeam_status covbeam_light_field_fluence(const struct covbeam_light_field *field,
                                           float limit,
                                           struct covbeam_spectrum *spectrum);

/**
 * Variance of the fluence's spectrum along the ray, from how the rays spread and from extinction; for light
 * that has not been scattered.
 *
 * @param field the light field.
 * @param extinction around the ray [1/m] >= 0.
 * @param variance [cycles^2/m^2] >= 0.
 * @note Derived.
 */
covbeam_status covbeam_light_field_variance_along_ray(const struct covbeam_light_field *field,
                                                      float extinction,
                                                      float *variance);

/**
 * covbeam_light_field_point for `count` light fields.
 *
 * @param count number of fields; with 0 nothing is done.
 * @param directions, direction_stride as direction there; a stride of 0 gives all fields the same.
 * @param angular_variances, angular_variance_stride as angular_variance there; a stride of 0 gives all fields
 *     the same.
 * @param out, out_stride the light fields.
 */
covbeam_status covbeam_light_fields_point(size_t count,
                                          const float *directions,
                                          size_t direction_stride,
                                          const float *angular_variances,
                                          size_t angular_variance_stride,
                                          struct covbeam_light_field *out,
                                          size_t out_stride);

/**
 * covbeam_light_field_disk for `count` light fields.
 *
 * @param count number of fields; with 0 nothing is done.
 * @param directions, direction_stride as direction there; a stride of 0 gives all fields the same.
 * @param normals, normal_stride as normal there; a stride of 0 gives all fields the same.
 * @param radii, radius_stride as radius there; a stride of 0 gives all fields the same.
 * @param angular_variances, angular_variance_stride as angular_variance there; a stride of 0 gives all fields
 *     the same.
 * @param out, out_stride the light fields.
 */
covbeam_status covbeam_light_fields_disk(size_t count,
                                         const float *directions,
                                         size_t direction_stride,
                                         const float *normals,
                                         size_t normal_stride,
                                         const float *radii,
                                         size_t radius_stride,
                                         const float *angular_variances,
                                         size_t angular_variance_stride,
                                         struct covbeam_light_field *out,
                                         size_t out_stride);

/**
 * covbeam_light_field_collimated for `count` light fields.
 *
 * @param count number of fields; with 0 nothing is done.
 * @param directions, direction_stride as direction there; a stride of 0 gives all fields the same.
 * @param radii, radius_stride as radius there; a stride of 0 gives all fields the same.
 * @param out, out_stride the light fields.
 */
covbeam_status covbeam_light_fields_collimated(size_t count,
                                               const float *directions,
                                               size_t direction_stride,
                                               const float *radii,
                                               size_t radius_stride,
                                               struct covbeam_light_field *out,
                                               size_t out_stride);

/**
 * covbeam_light_field_gaussian for `count` light fields.
 *
 * @param count number of fields; with 0 nothing is done.
 * @param directions, direction_stride as direction there; a stride of 0 gives all fields the same.
 * @param x_axes, x_axis_stride as x_axis there; a stride of 0 gives all fields the same.
 * @param spatial_variances, spatial_variance_stride as spatial_variance there; a stride of 0 gives all fields
 *     the same.
 * @param angular_variances, angular_variance_stride as angular_variance there; a stride of 0 gives all fields
 *     the same.
 * @param out, out_stride the light fields.
 */
covbeam_status covbeam_light_fields_gaussian(size_t count,
                                             const float *directions,
                                             size_t direction_stride,
                                             const float *x_axes,
                                             size_t x_axis_stride,
                                             const float *spatial_variances,
                                             size_t spatial_variance_stride,
                                             const float *angular_variances,
                                             size_t angular_variance_stride,
                                             struct covbeam_light_field *out,
                                             size_t out_stride);

/**
 * covbeam_light_field_travel for `count` light fields.
 *
 * @param count number of fields; with 0 nothing is done.
 * @param fields, field_stride array of light fields, changed in place.
 * @param distances, distance_stride as distance there; a stride of 0 gives all fields the same.
 */
covbeam_status covbeam_light_fields_travel(size_t count,
                                           struct covbeam_light_field *fields,
                                           size_t field_stride,
                                           const float *distances,
                                           size_t distance_stride);

/**
 * covbeam_light_field_carry for `count` light fields in one medium.
 *
 * @param count number of fields; with 0 nothing is done.
 * @param fields, field_stride array of light fields, changed in place.
 * @param medium as medium there.
 * @param origins, origin_stride as origin there; a stride of 0 gives all fields the same.
 * @param distances, distance_stride as distance there; a stride of 0 gives all fields the same.
 */
covbeam_status covbeam_light_fields_carry(size_t count,
                                          struct covbeam_light_field *fields,
                                          size_t field_stride,
                                          const struct covbeam_medium *medium,
                                          const float *origins,
                                          size_t origin_stride,
                                          const float *distances,
                                          size_t distance_stride);

/**
 * covbeam_light_field_rotate for `count` light fields.
 *
 * @param count number of fields; with 0 nothing is done.
 * @param fields, field_stride array of light fields, changed in place.
 * @param x_axes, x_axis_stride as x_axis there; a stride of 0 gives all fields the same.
 */
covbeam_status covbeam_light_fields_rotate(size_t count,
                                           struct covbeam_light_field *fields,
                                           size_t field_stride,
                                           const float *x_axes,
                                           size_t x_axis_stride);

/**
 * covbeam_light_field_reflect for `count` light fields.
 *
 * @param count number of fields; with 0 nothing is done.
 * @param fields, field_stride array of light fields, changed in place.
 * @param normals, normal_stride as normal there; a stride of 0 gives all fields the same.
 * @param curvatures, curvature_stride as curvature there; a stride of 0 gives all fields the same.
 */
covbeam_status covbeam_light_fields_reflect(size_t count,
                                            struct covbeam_light_field *fields,
                                            size_t field_stride,
                                            const float *normals,
                                            size_t normal_stride,
                                            const struct covbeam_curvature *curvatures,
                                            size_t curvature_stride);

/**
 * covbeam_light_field_refract for `count` light fields.
 *
 * @param count number of fields; with 0 nothing is done.
 * @param fields, field_stride array of light fields, changed in place.
 * @param normals, normal_stride as normal there; a stride of 0 gives all fields the same.
 * @param curvatures, curvature_stride as curvature there; a stride of 0 gives all fields the same.
 * @param etas, eta_stride as eta there; a stride of 0 gives all fields the same.
 * @param passed, passed_stride as passed there.
 */
covbeam_status covbeam_light_fields_refract(size_t count,
                                            struct covbeam_light_field *fields,
                                            size_t field_stride,
                                            const float *normals,
                                            size_t normal_stride,
                                            const struct covbeam_curvature *curvatures,
                                            size_t curvature_stride,
                                            const float *etas,
                                            size_t eta_stride,
                                            uint8_t *passed,
                                            size_t passed_stride);

/**
 * covbeam_light_field_occlude for `count` light fields.
 *
 * @param count number of fields; with 0 nothing is done.
 * @param fields, field_stride array of light fields, changed in place.
 * @param towards_edges, towards_edge_stride as towards_edge there; a stride of 0 gives all fields the same.
 * @param distances, distance_stride as distance there; a stride of 0 gives all fields the same.
 */
covbeam_status covbeam_light_fields_occlude(size_t count,
                                            struct covbeam_light_field *fields,
                                            size_t field_stride,
                                            const float *towards_edges,
                                            size_t towards_edge_stride,
                                            const float *distances,
                                            size_t distance_stride);

/**
 * covbeam_light_field_attenuate for `count` light fields.
 *
 * @param count number of fields; with 0 nothing is done.
 * @param fields, field_stride array of light fields, changed in place.
 * @param gradients, gradient_stride as gradient there; a stride of 0 gives all fields the same.
 * @param hessians, hessian_stride as hessian there; a stride of 0 gives all fields the same.
 */
covbeam_status covbeam_light_fields_attenuate(size_t count,
                                              struct covbeam_light_field *fields,
                                              size_t field_stride,
                                              const float *gradients,
                                              size_t gradient_stride,
                                              const float *hessians,
                                              size_t hessian_stride);

/**
 * covbeam_light_field_narrow for `count` light fields.
 *
 * @param count number of fields; with 0 nothing is done.
 * @param fields, field_stride array of light fields, changed in place.
 * @param acrosses, across_stride as across there; a stride of 0 gives all fields the same.
 * @param angular_variances, angular_variance_stride as angular_variance there; a stride of 0 gives all fields
 *     the same.
 */
covbeam_status covbeam_light_fields_narrow(size_t count,
                                           struct covbeam_light_field *fields,
                                           size_t field_stride,
                                           const float *acrosses,
                                           size_t across_stride,
                                           const float *angular_variances,
                                           size_t angular_variance_stride);

/**
 * covbeam_light_field_scatter for `count` light fields.
 *
 * @param count number of fields; with 0 nothing is done.
 * @param fields, field_stride array of light fields, changed in place.
 * @param directions, direction_stride as direction there; a stride of 0 gives all fields the same.
 * @param angular_variances, angular_variance_stride as angular_variance there; a stride of 0 gives all fields
 *     the same.
 */
covbeam_status covbeam_light_fields_scatter(size_t count,
                                            struct covbeam_light_field *fields,
                                            size_t field_stride,
                                            const float *directions,
                                            size_t direction_stride,
                                            const float *angular_variances,
                                            size_t angular_variance_stride);

/**
 * covbeam_light_field_diffuse for `count` light fields.
 *
 * @param count number of fields; with 0 nothing is done.
 * @param fields, field_stride array of light fields, changed in place.
 * @param normals, normal_stride as normal there; a stride of 0 gives all fields the same.
 * @param directions, direction_stride as direction there; a stride of 0 gives all fields the same.
 */
covbeam_status covbeam_light_fields_diffuse(size_t count,
                                            struct covbeam_light_field *fields,
                                            size_t field_stride,
                                            const float *normals,
                                            size_t normal_stride,
                                            const float *directions,
                                            size_t direction_stride);

/**
 * covbeam_light_field_slice for `count` light fields.
 *
 * @param count number of fields; with 0 nothing is done.
 * @param fields, field_stride array of light fields.
 * @param variances_out, out_stride as variances there.
 */
covbeam_status covbeam_light_fields_slice(size_t count,
                                          const struct covbeam_light_field *fields,
                                          size_t field_stride,
                                          float *variances_out,
                                          size_t out_stride);

/**
 * covbeam_light_field_fluence for `count` light fields.
 *
 * @param count number of fields; with 0 nothing is done.
 * @param fields, field_stride array of light fields.
 * @param limits, limit_stride as limit there; a stride of 0 gives all fields the same.
 * @param spectrum_out, out_stride as spectrum there.
 */
covbeam_status covbeam_light_fields_fluence(size_t count,
                                            const struct covbeam_light_field *fields,
                                            size_t field_stride,
                                            const float *limits,
                                            size_t limit_stride,
                                            struct covbeam_spectrum *spectrum_out,
                                            size_t out_stride);

/**
 * covbeam_light_field_variance_along_ray for `count` light fields.
 *
 * @param count number of fields; with 0 nothing is done.
 * @param fields, field_stride array of light fields.
 * @param extinctions, extinction_stride as extinction there; a stride of 0 gives all fields the same.
 * @param variance_out, out_stride as variance there.
 */
covbeam_status covbeam_light_fields_variance_along_ray(size_t count,
                                                       const struct covbeam_light_field *fields,
                                                       size_t field_stride,
                                                       const float *extinctions,
                                                       size_t extinction_stride,
                                                       float *variance_out,
                                                       size_t out_stride);

/**
 * The value of a phase function [1/sr]: 1 in all over the sphere.
 *
 * @param phase the phase function.
 * @param cos_theta dot(propagation before, propagation after), forward 1; in [-1, 1], rounding past the ends
 *     is harmless.
 * @param value [1/sr] >= 0.
 */
covbeam_status covbeam_phase_evaluate(const struct covbeam_phase *phase, float cos_theta, float *value);

/**
 * covbeam_phase_evaluate for `count` cosines.
 *
 * @param phase as phase there.
 * @param count number of values; with 0 nothing is done.
 * @param cosines, cosine_stride as cos_theta there.
 * @param values, value_stride as value there.
 */
covbeam_status covbeam_phase_evaluate_many(const struct covbeam_phase *phase,
                                           size_t count,
                                           const float *cosines,
                                           size_t cosine_stride,
                                           float *values,
                                           size_t value_stride);

/**
 * Samples a direction after scattering in proportion to the phase function: the weight (value / density) is 1.
 *
 * @param phase the phase function.
 * @param direction of propagation before the event, unit.
 * @param xi two independent uniform numbers in [0, 1).
 * @param scattered direction of propagation after the event, unit; may be the same array as direction.
 * @note The angle of a narrow lobe is exact: it does not pass through its cosine.
 */
covbeam_status covbeam_phase_sample(const struct covbeam_phase *phase,
                                    const float *direction,
                                    const float *xi,
                                    float *scattered);

/**
 * covbeam_phase_sample for `count` directions.
 *
 * @param phase as phase there.
 * @param count number of directions; with 0 nothing is done.
 * @param directions, direction_stride as direction there; a stride of 0 scatters one direction `count` times.
 * @param xis, xi_stride as xi there.
 * @param scattered, scattered_stride as scattered there.
 */
covbeam_status covbeam_phase_sample_many(const struct covbeam_phase *phase,
                                         size_t count,
                                         const float *directions,
                                         size_t direction_stride,
                                         const float *xis,
                                         size_t xi_stride,
                                         float *scattered,
                                         size_t scattered_stride);

/**
 * Samples the cosine of the scattering angle in proportion to the phase function.
 *
 * @param phase the phase function.
 * @param xi uniform in [0, 1); 0 gives -1, and the cosine grows with it.
 * @param cos_theta in [-1, 1].
 */
covbeam_status covbeam_phase_sample_cosine(const struct covbeam_phase *phase, float xi, float *cos_theta);

/**
 * covbeam_phase_sample_cosine for `count` random numbers.
 *
 * @param phase as phase there.
 * @param count number of cosines; with 0 nothing is done.
 * @param xis, xi_stride as xi there.
 * @param cosines, cosine_stride as cos_theta there.
 */
covbeam_status covbeam_phase_sample_cosine_many(const struct covbeam_phase *phase,
                                                size_t count,
                                                const float *xis,
                                                size_t xi_stride,
                                                float *cosines,
                                                size_t cosine_stride);

/**
 * What covbeam_light_field_scatter takes: variance, per axis, of the angular spectrum of the lobe.
 *
 * @param phase the phase function.
 * @param variance [cycles^2/rad^2]: 3|g| / (4 pi^2 (1 - |g|)^2) for Henyey-Greenstein, 1/(4 pi^2) for
 *     Rayleigh, 0 for isotropic.
 * @note Derived from the lobe's curvature at its peak.
 */
covbeam_status covbeam_phase_angular_variance(const struct covbeam_phase *phase, float *variance);

/**
 * Makes a density from voxels: trilinear between their centres, held over the half voxel at the border of the
 * box, 0 outside.
 *
 * @param layout box and resolution.
 * @param values, value_stride, value_count one a voxel, each finite and >= 0, x first, then y, then z.
 * @param out the handle.
 * @note Copies the values: 4 bytes a voxel.
 */
covbeam_status covbeam_density_new(const struct covbeam_grid_layout *layout,
                                   const float *values,
                                   size_t value_stride,
                                   size_t value_count,
                                   struct covbeam_density **out);

/**
 * Frees a density. Beam maps that were made with it keep what they need.
 *
 * @param density NULL is ignored.
 */
void covbeam_density_free(struct covbeam_density *density);

/**
 * Relative density of a medium at a point.
 *
 * @param medium the medium.
 * @param position [m].
 * @param density >= 0: 1 where the medium's coefficients hold. An exponential one is held beyond e^80 and
 *     e^-80.
 * @note Costs nothing, an exponential, or a trilinear look-up.
 */
covbeam_status covbeam_medium_density_at(const struct covbeam_medium *medium,
                                         const float *position,
                                         float *density);

/**
 * covbeam_medium_density_at for `count` points.
 *
 * @param medium as medium there.
 * @param count number of points; with 0 nothing is done.
 * @param positions, position_stride as position there.
 * @param densities, density_stride as density there.
 */
covbeam_status covbeam_medium_density_at_many(const struct covbeam_medium *medium,
                                              size_t count,
                                              const float *positions,
                                              size_t position_stride,
                                              float *densities,
                                              size_t density_stride);

/**
 * Derivatives of the relative density at a point. Their integrals along a way, times the extinction, are what
 * covbeam_light_field_attenuate takes.
 *
 * @param medium the medium.
 * @param position [m].
 * @param derivatives exact for an exponential density; differences between neighbouring voxels, 0 outside the
 *     box.
 */
covbeam_status covbeam_medium_derivatives_at(const struct covbeam_medium *medium,
                                             const float *position,
                                             struct covbeam_derivatives *derivatives);

/**
 * covbeam_medium_derivatives_at for `count` points.
 *
 * @param medium as medium there.
 * @param count number of points; with 0 nothing is done.
 * @param positions, position_stride as position there.
 * @param derivatives, derivative_stride as derivatives there.
 */
covbeam_status covbeam_medium_derivatives_at_many(const struct covbeam_medium *medium,
                                                  size_t count,
                                                  const float *positions,
                                                  size_t position_stride,
                                                  struct covbeam_derivatives *derivatives,
                                                  size_t derivative_stride);

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
 * @param origin of the ray [m].
 * @param direction of the ray, unit.
 * @param distance along the ray [m] >= 0; infinity allowed.
 * @param column [m] >= 0; infinite only for an infinite distance in a homogeneous medium.
 * @note Voxels: exact, about 20 ns a voxel passed. For many distances on one ray see covbeam_medium_column.
 */
covbeam_status covbeam_medium_column_at(const struct covbeam_medium *medium,
                                        const float *origin,
                                        const float *direction,
                                        float distance,
                                        float *column);

/**
 * covbeam_medium_column_at for `count` rays.
 *
 * @param medium as medium there.
 * @param count number of rays; with 0 nothing is done.
 * @param origins, origin_stride as origin there; a stride of 0 gives all rays the same.
 * @param directions, direction_stride as direction there; a stride of 0 gives all rays the same.
 * @param distances, distance_stride as distance there; a stride of 0 gives all rays the same.
 * @param columns, column_stride as column there.
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

/**
 * Distance along a ray at which a column is reached: the inverse of covbeam_medium_column_at.
 *
 * Free flight is sampled with it: column = -log(1 - u) / extinction for a uniform u in [0, 1) and the
 * extinction of one channel; light that gets infinity reaches the end of the ray.
 *
 * @param medium the medium.
 * @param origin of the ray [m].
 * @param direction of the ray, unit.
 * @param length of the ray [m] >= 0; infinity allowed.
 * @param column [m] >= 0; infinity allowed.
 * @param distance [m]; infinity if the ray ends before.
 * @note Voxels: the column there is within 5e-4 of the one asked for, relatively; about 20 ns a voxel passed.
 */
covbeam_status covbeam_medium_distance_at(const struct covbeam_medium *medium,
                                          const float *origin,
                                          const float *direction,
                                          float length,
                                          float column,
                                          float *distance);

/**
 * covbeam_medium_distance_at for `count` rays.
 *
 * @param medium as medium there.
 * @param count number of rays; with 0 nothing is done.
 * @param origins, origin_stride as origin there; a stride of 0 gives all rays the same.
 * @param directions, direction_stride as direction there; a stride of 0 gives all rays the same.
 * @param lengths, length_stride as length there; a stride of 0 gives all rays the same.
 * @param columns, column_stride as column there; a stride of 0 gives all rays the same.
 * @param distances, distance_stride as distance there.
 */
covbeam_status covbeam_medium_distance_at_many(const struct covbeam_medium *medium,
                                               size_t count,
                                               const float *origins,
                                               size_t origin_stride,
                                               const float *directions,
                                               size_t direction_stride,
                                               const float *lengths,
                                               size_t length_stride,
                                               const float *columns,
                                               size_t column_stride,
                                               float *distances,
                                               size_t distance_stride);

/**
 * The share of light that a stretch of medium leaves, per channel.
 *
 * @param medium the medium.
 * @param origin of the ray [m].
 * @param direction of the ray, unit.
 * @param distance along the ray [m] >= 0; infinity allowed.
 * @param transmittance three numbers in [0, 1]: exp(-extinction x column).
 * @note The column of covbeam_medium_column_at, and one exponential if the channels are equal, else three.
 */
covbeam_status covbeam_medium_transmittance(const struct covbeam_medium *medium,
                                            const float *origin,
                                            const float *direction,
                                            float distance,
                                            float *transmittance);

/**
 * covbeam_medium_transmittance for `count` rays.
 *
 * @param medium as medium there.
 * @param count number of rays; with 0 nothing is done.
 * @param origins, origin_stride as origin there; a stride of 0 gives all rays the same.
 * @param directions, direction_stride as direction there; a stride of 0 gives all rays the same.
 * @param distances, distance_stride as distance there; a stride of 0 gives all rays the same.
 * @param transmittances, transmittance_stride as transmittance there.
 */
covbeam_status covbeam_medium_transmittance_many(const struct covbeam_medium *medium,
                                                 size_t count,
                                                 const float *origins,
                                                 size_t origin_stride,
                                                 const float *directions,
                                                 size_t direction_stride,
                                                 const float *distances,
                                                 size_t distance_stride,
                                                 float *transmittances,
                                                 size_t transmittance_stride);

/**
 * The share of light that a column leaves, per channel: for a host that has the column already.
 *
 * @param medium the medium; its density does not matter.
 * @param column [m] >= 0; infinity allowed.
 * @param transmittance three numbers in [0, 1]: exp(-extinction x column).
 */
covbeam_status covbeam_medium_column_transmittance(const struct covbeam_medium *medium,
                                                   float column,
                                                   float *transmittance);

/**
 * covbeam_medium_column_transmittance for `count` columns.
 *
 * @param medium as medium there.
 * @param count number of columns; with 0 nothing is done.
 * @param columns, column_stride as column there.
 * @param transmittances, transmittance_stride as transmittance there.
 */
covbeam_status covbeam_medium_column_transmittance_many(const struct covbeam_medium *medium,
                                                        size_t count,
                                                        const float *columns,
                                                        size_t column_stride,
                                                        float *transmittances,
                                                        size_t transmittance_stride);

/**
 * The column after which light of every channel is down to e^-17 = 4e-8. In a homogeneous medium it is a
 * distance: no beam need be longer. For other media see covbeam_medium_reach.
 *
 * @param medium the medium.
 * @param column [m]; infinite if a channel has no extinction.
 */
covbeam_status covbeam_medium_opaque_column(const struct covbeam_medium *medium, float *column);

/**
 * Distance beyond which light that starts on a ray leaves nothing to see: where a host may end an eye ray or a
 * beam that no surface ends.
 *
 * @param medium the medium.
 * @param origin of the ray [m].
 * @param direction of the ray, unit.
 * @param distance [m]: where the medium becomes opaque, hardly goes on, or its voxels end; infinite if there
 *     is no such place.
 * @note Voxels: about 20 ns a voxel passed.
 */
covbeam_status covbeam_medium_reach(const struct covbeam_medium *medium,
                                    const float *origin,
                                    const float *direction,
                                    float *distance);

/**
 * covbeam_medium_reach for `count` rays.
 *
 * @param medium as medium there.
 * @param count number of rays; with 0 nothing is done.
 * @param origins, origin_stride as origin there; a stride of 0 gives all rays the same.
 * @param directions, direction_stride as direction there; a stride of 0 gives all rays the same.
 * @param distances, distance_stride as distance there.
 */
covbeam_status covbeam_medium_reach_many(const struct covbeam_medium *medium,
                                         size_t count,
                                         const float *origins,
                                         size_t origin_stride,
                                         const float *directions,
                                         size_t direction_stride,
                                         float *distances,
                                         size_t distance_stride);

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
 * @param distance along the ray [m] >= 0; infinity allowed.
 * @param value [m] >= 0, never falling with distance.
 * @note Costs nothing, an exponential, or a binary search. The order of the knots is not checked; without it,
 *     value means nothing.
 */
covbeam_status covbeam_column_at(const struct covbeam_column *column, float distance, float *value);

/**
 * covbeam_column_at for `count` distances along one ray.
 *
 * @param column as column there.
 * @param count number of distances; with 0 nothing is done.
 * @param distances, distance_stride as distance there.
 * @param values, value_stride as value there.
 */
covbeam_status covbeam_column_at_many(const struct covbeam_column *column,
                                      size_t count,
                                      const float *distances,
                                      size_t distance_stride,
                                      float *values,
                                      size_t value_stride);

/**
 * The distance at which the column reaches a value: the inverse of covbeam_column_at. See
 * covbeam_medium_distance_at.
 *
 * @param column the column along the ray.
 * @param value [m] >= 0; infinity allowed.
 * @param distance [m]; infinity if it never does.
 * @note Costs nothing, a logarithm, or a binary search. The order of the knots is not checked; without it,
 *     distance means nothing.
 */
covbeam_status covbeam_column_distance_at(const struct covbeam_column *column, float value, float *distance);

/**
 * covbeam_column_distance_at for `count` values along one ray.
 *
 * @param column as column there.
 * @param count number of values; with 0 nothing is done.
 * @param values, value_stride as value there.
 * @param distances, distance_stride as distance there.
 */
covbeam_status covbeam_column_distance_at_many(const struct covbeam_column *column,
                                               size_t count,
                                               const float *values,
                                               size_t value_stride,
                                               float *distances,
                                               size_t distance_stride);

/**
 * A spectrum's variance along an axis: what covbeam_kernel_radius_from_error takes.
 *
 * @param spectrum of the fluence.
 * @param axis unit.
 * @param variance [cycles^2/m^2] >= 0, to a few roundings of xx + yy + zz.
 * @note Thesis 5.3.4.
 */
covbeam_status covbeam_spectrum_variance_along(const struct covbeam_spectrum *spectrum,
                                               const float *axis,
                                               float *variance);

/**
 * covbeam_spectrum_variance_along for `count` spectra.
 *
 * @param count number of spectra; with 0 nothing is done.
 * @param spectra, spectrum_stride as spectrum there; a stride of 0 asks one spectrum for all axes.
 * @param axes, axis_stride as axis there; a stride of 0 gives all spectra the same.
 * @param variances, variance_stride as variance there.
 */
covbeam_status covbeam_spectra_variance_along(size_t count,
                                              const struct covbeam_spectrum *spectra,
                                              size_t spectrum_stride,
                                              const float *axes,
                                              size_t axis_stride,
                                              float *variances,
                                              size_t variance_stride);

/**
 * Adds a variance along an axis, such as that of covbeam_light_field_variance_along_ray.
 *
 * @param spectrum of the fluence, changed in place.
 * @param axis unit.
 * @param variance [cycles^2/m^2], finite and >= 0.
 */
covbeam_status covbeam_spectrum_add_along(struct covbeam_spectrum *spectrum,
                                          const float *axis,
                                          float variance);

/**
 * covbeam_spectrum_add_along for `count` spectra.
 *
 * @param count number of spectra; with 0 nothing is done.
 * @param spectra, spectrum_stride as spectrum there.
 * @param axes, axis_stride as axis there; a stride of 0 gives all spectra the same.
 * @param variances, variance_stride as variance there; a stride of 0 gives all spectra the same.
 */
covbeam_status covbeam_spectra_add_along(size_t count,
                                         struct covbeam_spectrum *spectra,
                                         size_t spectrum_stride,
                                         const float *axes,
                                         size_t axis_stride,
                                         const float *variances,
                                         size_t variance_stride);

/**
 * The number of one decision of one light path, uniform in [0, 1). The first COVBEAM_EMISSION_DIMENSIONS
 * decisions are the coordinates of a scrambled Sobol' point, which place 2^k paths in a row evenly; those after
 * them are independent. At equal numbers of paths the picture's error is 1.2 to 8 times below that of
 * independent numbers.
 *
 * @param seed another seed is another scramble of all sequences.
 * @param sequence keeps sequences of one seed apart, such as paths with light fields and those without.
 * @param path its place in the sequence, counted on over the passes of a picture.
 * @param dimension which decision of the path, from 0 on.
 * @param number in [0, 1), a multiple of 2^-24.
 */
covbeam_status covbeam_path_number(uint32_t seed,
                                   uint32_t sequence,
                                   uint32_t path,
                                   uint32_t dimension,
                                   float *number);

/**
 * covbeam_path_number for `count` paths.
 *
 * @param seed as there.
 * @param sequence as there.
 * @param count number of paths; with 0 nothing is done.
 * @param paths, path_stride as path there.
 * @param dimension as there.
 * @param numbers, number_stride as number there.
 */
covbeam_status covbeam_path_numbers(uint32_t seed,
                                    uint32_t sequence,
                                    size_t count,
                                    const uint32_t *paths,
                                    size_t path_stride,
                                    uint32_t dimension,
                                    float *numbers,
                                    size_t number_stride);

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
 * Edges of occluders beside a ray, from nothing but rays that the host casts: those up to four that mask its
 * light most, for the edges of a covbeam_segment. Where the depth jumps as the ray is tilted there is an edge,
 * whosever surface is on either side; edges of what the ray hits that lie deeper than the hit are moved there.
 *
 * @param direction of the ray, unit.
 * @param hit where the ray itself meets a surface; may be NULL: nowhere.
 * @param probe casts a ray from the same origin; called up to 128 times.
 * @param user given to probe.
 * @param edges receives COVBEAM_MOST_EDGES edges, sorted by depth, towards unit and across the ray; those that
 *     were not found are 0.
 * @param edge_count receives how many were found.
 * @note 28 probes where there is no edge, about 80 where there are some. The nearest edge is within 20 % on
 *     spheres, and in nine of ten cases on figurines and tracery; bars and tips that pass between the probes
 *     are missed.
 */
covbeam_status covbeam_find_edges(const float *direction,
                                  const struct covbeam_probe_hit *hit,
                                  covbeam_probe probe,
                                  void *user,
                                  struct covbeam_edge *edges,
                                  uint32_t *edge_count);

/**
 * The light field at a distance from a segment's origin: moved on through the medium, and occluded by each edge
 * up to there where it passes it.
 *
 * @param segment the segment; origin, field and edges count, the rest is not looked at.
 * @param medium what it travels in; the mean extinction of the channels counts. Of no scattering and no
 *     absorption in vacuum.
 * @param distance [m] >= 0, finite: to the photon's next event, at most to the surface on which the segment
 *     ends.
 * @param out the light field there; segment->field is fine.
 * @note Thesis 5.3.1. In a density that varies, up to 256 look-ups of its derivatives from edge to edge.
 */
covbeam_status covbeam_segment_field_at(const struct covbeam_segment *segment,
                                        const struct covbeam_medium *medium,
                                        float distance,
                                        struct covbeam_light_field *out);

/**
 * covbeam_segment_field_at for `count` segments.
 *
 * @param count number of segments; with 0 nothing is done.
 * @param segments, segment_stride as segment there.
 * @param medium as there.
 * @param distances, distance_stride as distance there; a stride of 0 gives all segments the same.
 * @param out, out_stride as out there.
 */
covbeam_status covbeam_segments_field_at(size_t count,
                                         const struct covbeam_segment *segments,
                                         size_t segment_stride,
                                         const struct covbeam_medium *medium,
                                         const float *distances,
                                         size_t distance_stride,
                                         struct covbeam_light_field *out,
                                         size_t out_stride);

/**
 * Makes an empty grid in the library's memory: 56 bytes a voxel, and 28 more from the first
 * covbeam_grid_resolve on.
 *
 * @param layout box and resolution.
 * @param out the handle.
 */
covbeam_status covbeam_grid_new(const struct covbeam_grid_layout *layout, struct covbeam_grid **out);

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
 * Frees a grid; memory of the host's stays the host's, with what is in it.
 *
 * @param grid NULL is ignored.
 */
void covbeam_grid_free(struct covbeam_grid *grid);

/**
 * The grid's box and resolution.
 *
 * @param grid the grid.
 * @param layout receives them.
 */
covbeam_status covbeam_grid_get_layout(const struct covbeam_grid *grid, struct covbeam_grid_layout *layout);

/**
 * Empties a grid, and forgets what was resolved.
 *
 * @param grid the grid.
 */
covbeam_status covbeam_grid_clear(struct covbeam_grid *grid);

/**
 * Adds the light fields along segments of light paths, in their order; past each edge what the edge has left.
 *
 * @param grid the grid.
 * @param medium what the segments run through; the mean extinction of the channels counts.
 * @param count number of segments; with 0 nothing is done.
 * @param segments, segment_stride the segments.
 * @note Thesis 5.3.1, Eq 5.14 and 5.15. 0.2 us a voxel on the way, 0.7 us where the density varies; 2 to 40 us
 *     a segment. A tenth of a pass' photons is enough.
 */
covbeam_status covbeam_grid_deposit(struct covbeam_grid *grid,
                                    const struct covbeam_medium *medium,
                                    size_t count,
                                    const struct covbeam_segment *segments,
                                    size_t segment_stride);

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
 * Adds what other grids of the same layout have collected, in their order.
 *
 * @param grid the grid that is added to.
 * @param others array of other_count handles, none of them `grid`; they stay as they are.
 * @param other_count number of handles; with 0 nothing is done.
 * @note The sums are f64: 10^9 equal deposits keep their mean to 1e-7.
 */
covbeam_status covbeam_grid_merge(struct covbeam_grid *grid,
                                  const struct covbeam_grid *const *others,
                                  size_t other_count);

/**
 * Computes the mean spectrum of every voxel, for look-ups; they see the state of this call until the next one.
 *
 * @param grid the grid.
 * @note About 10 ns a voxel.
 */
covbeam_status covbeam_grid_resolve(struct covbeam_grid *grid);

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
 * Number of bytes that covbeam_grid_save writes.
 *
 * @param grid the grid.
 * @param size receives it: 56 and 56 a voxel.
 */
covbeam_status covbeam_grid_get_saved_size(const struct covbeam_grid *grid, size_t *size);

/**
 * Writes what the grid has collected as bytes, the same on every machine.
 *
 * @param grid the grid.
 * @param bytes, size memory of covbeam_grid_get_saved_size bytes.
 * @note 0.1 us a voxel. Cells that covariances cannot add up to are refused: written by the host, or deposited
 *     as spectra that are none.
 */
covbeam_status covbeam_grid_save(const struct covbeam_grid *grid,
                                 void *bytes,
                                 size_t size);

/**
 * Makes a grid from the bytes of covbeam_grid_save. Bytes that it has not written are refused.
 *
 * @param bytes, size the bytes.
 * @param out the handle; the grid is not resolved yet.
 * @note Memory is had only for as many voxels as there are bytes for.
 */
covbeam_status covbeam_grid_load(const void *bytes, size_t size, struct covbeam_grid **out);

/**
 * The kernel of a pass: what a host calls when it begins one.
 *
 * @param schedule how the kernel shrinks.
 * @param pass counted from 1. Passes may run in any order.
 * @param kernel set its struct_size before; the rest is written: min_radius =
 *     covbeam_progressive_radius(radius, alpha, pass), max_radius = the larger of max_radius and min_radius,
 *     error = covbeam_error_bound(error, pass).
 * @note COVBEAM_INVALID_VALUE too if the radius or the error of the pass falls below the smallest float.
 */
covbeam_status covbeam_schedule_kernel(const struct covbeam_schedule *schedule,
                                       uint32_t pass,
                                       struct covbeam_kernel *kernel);

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
 * @param position the closest point on the eye ray [m].
 * @param axis of the kernel, unit, across ray and beam: that of the covbeam_crossing.
 * @param radius [m] in [min_radius, max_radius].
 * @param sigma deviation of the spectrum along the axis [cycles/m]; 0 where the grid has no data.
 * @note Thesis 5.3.4.
 */
covbeam_status covbeam_kernel_radius_at(const struct covbeam_kernel *kernel,
                                        const struct covbeam_grid *grid,
                                        const float *position,
                                        const float *axis,
                                        float *radius,
                                        float *sigma);

/**
 * covbeam_kernel_radius_at for `count` pairs.
 *
 * @param kernel as kernel there.
 * @param grid as grid there.
 * @param count number of pairs; with 0 nothing is done.
 * @param positions, position_stride as position there; a stride of 0 gives all pairs the same.
 * @param axes, axis_stride as axis there; a stride of 0 gives all pairs the same.
 * @param radii, radius_stride as radius there.
 * @param sigmas, sigma_stride as sigma there.
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

/**
 * Makes a map without beams.
 *
 * @param medium what its beams run through; copied, and voxels are kept alive. For
 *     covbeam_beam_map_gather_shaded: any homogeneous one.
 * @param out the handle.
 */
covbeam_status covbeam_beam_map_new(const struct covbeam_medium *medium, struct covbeam_beam_map **out);

/**
 * Frees a map.
 *
 * @param map NULL is ignored.
 */
void covbeam_beam_map_free(struct covbeam_beam_map *map);

/**
 * Begins a pass: forgets all beams, keeps their memory.
 *
 * @param map the map.
 */
covbeam_status covbeam_beam_map_clear(struct covbeam_beam_map *map);

/**
 * Adds beams. What a map gathers depends on their order only, not on how they were cut into batches.
 *
 * @param map a map that is not committed.
 * @param count number of beams; with 0 nothing is done. At most 2^28 beams in all.
 * @param beams, beam_stride the beams, copied.
 */
covbeam_status covbeam_beam_map_add(struct covbeam_beam_map *map,
                                    size_t count,
                                    const struct covbeam_beam *beams,
                                    size_t beam_stride);

/**
 * Builds the hierarchy over the beams. Stopped, the map is as before.
 *
 * @param map a map that is not committed.
 * @param max_radius largest kernel radius that it will be gathered with [m] > 0: covbeam_kernel's max_radius.
 * @param poll may be NULL; asked at least every few milliseconds. Not 0 ends the call with COVBEAM_CANCELLED.
 * @param user given to poll.
 * @note n log n in the number of beams: at a million, 0.7 us a beam in a homogeneous medium and 2.8 us in
 *     voxels; 190 and about 390 bytes a beam afterwards.
 */
covbeam_status covbeam_beam_map_commit(struct covbeam_beam_map *map,
                                       float max_radius,
                                       covbeam_poll poll,
                                       void *user);

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
 * Makes the memory of a thread's gathers.
 *
 * @param out the handle.
 */
covbeam_status covbeam_scratch_new(struct covbeam_scratch **out);

/**
 * Frees a thread's memory.
 *
 * @param scratch NULL is ignored.
 */
void covbeam_scratch_free(struct covbeam_scratch *scratch);

/**
 * Gathers the light that beams scatter into eye rays. Stopped or failed, nothing is written.
 *
 * @param map a map that has been committed.
 * @param kernel the kernel and how wide it may be; its max_radius at most the map's.
 * @param grid a grid that has been resolved, for kernels as wide as the light's bandwidth allows. NULL: all
 *     kernels have the radius kernel->min_radius, and the max_radius may be that too.
 * @param count number of rays; with 0 nothing is done. Each 256 that follow each other share one walk through
 *     the hierarchy: give those of a tile of 8x8 pixels together.
 * @param rays, ray_stride the eye rays, all in the map's medium.
 * @param gathered, gathered_stride receive what each ray gathers.
 * @param scratch the thread's memory; NULL allocates for this call.
 * @param poll may be NULL; asked at least every few milliseconds. Not 0 ends the call with COVBEAM_CANCELLED.
 * @param user given to poll.
 * @note Thesis 5.3.4. An accepted pair costs 38 ns in a homogeneous medium, 59 ns in an exponential one, 61 ns
 *     in voxels and 3.3 us a ray.
 */
covbeam_status covbeam_beam_map_gather(const struct covbeam_beam_map *map,
                                       const struct covbeam_kernel *kernel,
                                       const struct covbeam_grid *grid,
                                       size_t count,
                                       const struct covbeam_eye_ray *rays,
                                       size_t ray_stride,
                                       struct covbeam_gathered *gathered,
                                       size_t gathered_stride,
                                       struct covbeam_scratch *scratch,
                                       covbeam_poll poll,
                                       void *user);

/**
 * covbeam_beam_map_gather in a medium that only the host knows: shade says how much light each contact lets
 * through.
 *
 * @param map, kernel, grid, count, rays, ray_stride, gathered, gathered_stride, scratch as there. The map's
 *     own medium does not matter.
 * @param shade called with up to 256 contacts at a time.
 * @param poll may be NULL, as there.
 * @param user given to shade and to poll.
 * @note About 30 ns a pair on top of what shade takes.
 */
covbeam_status covbeam_beam_map_gather_shaded(const struct covbeam_beam_map *map,
                                              const struct covbeam_kernel *kernel,
                                              const struct covbeam_grid *grid,
                                              size_t count,
                                              const struct covbeam_eye_ray *rays,
                                              size_t ray_stride,
                                              struct covbeam_gathered *gathered,
                                              size_t gathered_stride,
                                              struct covbeam_scratch *scratch,
                                              covbeam_shade shade,
                                              covbeam_poll poll,
                                              void *user);

/**
 * Closest approach of an eye ray's line and a beam's line.
 *
 * @param ray the eye ray; its length does not matter.
 * @param beam the beam; its length does not matter.
 * @param crossing the closest approach; untouched if they are nearly parallel.
 * @param crosses 1, or 0 if the sine of the angle between them is below 1e-5: such pairs are never gathered.
 */
covbeam_status covbeam_cross(const struct covbeam_eye_ray *ray,
                             const struct covbeam_beam *beam,
                             struct covbeam_crossing *crossing,
                             uint8_t *crosses);

/**
 * covbeam_cross for `count` beams.
 *
 * @param ray as ray there.
 * @param count number of beams; with 0 nothing is done.
 * @param beams, beam_stride as beam there.
 * @param crossings, crossing_stride as crossing there.
 * @param crosses, cross_stride as crosses there.
 */
covbeam_status covbeam_cross_many(const struct covbeam_eye_ray *ray,
                                  size_t count,
                                  const struct covbeam_beam *beams,
                                  size_t beam_stride,
                                  struct covbeam_crossing *crossings,
                                  size_t crossing_stride,
                                  uint8_t *crosses,
                                  size_t cross_stride);

/**
 * Gathers one beam, and adds it to what the eye ray has gathered: scattering x phase function x transmittance
 * along both x flux of the beam x kernel(gap) / sin(angle), if the gap is less than the kernel's radius,
 * looked up on the eye ray.
 *
 * @param ray the eye ray.
 * @param beam the beam, in the same medium.
 * @param from, to part of the beam that counts [m] >= 0, [from, to): 0 and the beam's length, or more, for all
 *     of it. Cutting a beam into adjoining parts changes nothing.
 * @param medium that both lie in.
 * @param ray_column along the ray; NULL takes the closed form (voxels have none: COVBEAM_NULL_POINTER).
 * @param beam_column along the beam; NULL likewise.
 * @param kernel the kernel of the pass.
 * @param grid as in covbeam_kernel_radius_at.
 * @param gathered in and out: finite numbers, all 0 to begin with.
 * @param accepted 1 if the pair counts, else 0.
 * @note Thesis 5.3.4. A beam that starts or ends on a surface is cut by its tangent plane. The order of the
 *     columns' knots is not checked.
 */
covbeam_status covbeam_gather_pair(const struct covbeam_eye_ray *ray,
                                   const struct covbeam_beam *beam,
                                   float from,
                                   float to,
                                   const struct covbeam_medium *medium,
                                   const struct covbeam_column *ray_column,
                                   const struct covbeam_column *beam_column,
                                   const struct covbeam_kernel *kernel,
                                   const struct covbeam_grid *grid,
                                   struct covbeam_gathered *gathered,
                                   uint8_t *accepted);

/**
 * covbeam_gather_pair for one eye ray and `count` beams, added in their order.
 *
 * @param ray as ray there.
 * @param count number of beams; with 0 nothing is done.
 * @param beams, beam_stride as beam there.
 * @param froms, from_stride as from there; a stride of 0 gives all beams the same.
 * @param tos, to_stride as to there; a stride of 0 gives all beams the same.
 * @param medium as medium there.
 * @param ray_column as ray_column there.
 * @param beam_columns, beam_column_stride as beam_column there; NULL for all of them.
 * @param kernel as kernel there.
 * @param grid as grid there.
 * @param gathered as gathered there, one for all beams.
 * @param accepted, accepted_stride as accepted there.
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

/**
 * Which of many beams an eye ray may be paired with: eight at a time, without looking at grid or surfaces.
 * Errs towards accepting (a parallel beam always passes): covbeam_gather_pair refuses every beam that it
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
 * The spectrum of the in-scattered light around a pixel, read off a grid along its eye ray: how fast the
 * picture varies there.
 *
 * @param grid a grid that has been resolved.
 * @param medium what the ray is in.
 * @param ray from the eye to where the light that it gathers ends, or infinite.
 * @param steps two: how the ray changes with a pixel to the right, and with one down.
 * @param spectrum positive semi-definite up to rounding; all 0 where the grid has no data.
 * @note Surfaces that end the rays of neighbouring pixels at other distances are no part of it: see
 *     covbeam_film_regions. Thesis 5.3.2, with the exact second derivatives of density x transmittance for its
 *     attenuation. About 40 ns a voxel passed in a homogeneous medium, 95 ns in an exponential one, 200 ns in
 *     voxels.
 */
covbeam_status covbeam_image_spectrum_along(const struct covbeam_grid *grid,
                                            const struct covbeam_medium *medium,
                                            const struct covbeam_eye_ray *ray,
                                            const struct covbeam_pixel_step *steps,
                                            struct covbeam_image_spectrum *spectrum);

/**
 * covbeam_image_spectrum_along for `count` pixels.
 *
 * @param grid as grid there.
 * @param medium as medium there.
 * @param count number of pixels; with 0 nothing is done.
 * @param rays, ray_stride as ray there.
 * @param steps, step_stride as steps there, the two of a pixel side by side; a stride of 0 gives all pixels the
 *     same.
 * @param spectra, spectrum_stride as spectrum there.
 */
covbeam_status covbeam_image_spectra_along(const struct covbeam_grid *grid,
                                           const struct covbeam_medium *medium,
                                           size_t count,
                                           const struct covbeam_eye_ray *rays,
                                           size_t ray_stride,
                                           const struct covbeam_pixel_step *steps,
                                           size_t step_stride,
                                           struct covbeam_image_spectrum *spectra,
                                           size_t spectrum_stride);

/**
 * The reconstruction filter that blurs the picture by a relative bias: a Gaussian of covariance
 * error / (4 pi^2) x the inverse of the spectrum's, wide where the spectrum is narrow.
 *
 * @param spectrum the spectrum around the pixel.
 * @param error the relative bias > 0, half of it along each principal axis.
 * @param widest largest standard deviation [pixels] > 0.
 * @param filter all 0 where the spectrum has a weight of 0.
 * @note Thesis 5.3.2, whose filter has an error of 1.
 */
covbeam_status covbeam_image_spectrum_filter(const struct covbeam_image_spectrum *spectrum,
                                             float error,
                                             float widest,
                                             struct covbeam_image_filter *filter);

/**
 * covbeam_image_spectrum_filter for `count` pixels.
 *
 * @param count number of pixels; with 0 nothing is done.
 * @param spectra, spectrum_stride as spectrum there.
 * @param errors, error_stride as error there; a stride of 0 gives all pixels the same.
 * @param widests, widest_stride as widest there; a stride of 0 gives all pixels the same.
 * @param filters, filter_stride as filter there.
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

/**
 * Eye rays that a pixel needs in a pass: two under each filter.
 *
 * @param filter the pixel's filter.
 * @param density in (0, 1]; no filter gives 1.
 * @note Thesis 5.3.2.
 */
covbeam_status covbeam_image_filter_density(const struct covbeam_image_filter *filter, float *density);

/**
 * covbeam_image_filter_density for `count` pixels.
 *
 * @param count number of pixels; with 0 nothing is done.
 * @param filters, filter_stride as filter there.
 * @param densities, density_stride as density there.
 */
covbeam_status covbeam_image_filters_density(size_t count,
                                             const struct covbeam_image_filter *filters,
                                             size_t filter_stride,
                                             float *densities,
                                             size_t density_stride);

/**
 * A pixel's threshold in a pass: the pixel gets an eye ray if its density is above. At any density the pixels
 * chosen are spread evenly over the picture, and a pixel is chosen evenly over the passes.
 *
 * @param pass any number; each chooses other pixels.
 * @param seed any number; shifts the pattern.
 * @param pixel two numbers: x to the right and y down, any.
 * @param threshold in [0, 1).
 */
covbeam_status covbeam_pixel_threshold(uint32_t pass, uint32_t seed, const uint32_t *pixel, float *threshold);

/**
 * covbeam_pixel_threshold for `count` pixels, such as those of a tile.
 *
 * @param pass as pass there.
 * @param seed as seed there.
 * @param count number of pixels; with 0 nothing is done.
 * @param pixels, pixel_stride as pixel there.
 * @param thresholds, threshold_stride as threshold there.
 */
covbeam_status covbeam_pixel_threshold_many(uint32_t pass,
                                            uint32_t seed,
                                            size_t count,
                                            const uint32_t *pixels,
                                            size_t pixel_stride,
                                            float *thresholds,
                                            size_t threshold_stride);

/**
 * Splits a picture into regions in which the depth of the first surface is continuous: filters do not reach
 * from one into another.
 *
 * @param width, height of the picture, each 1 to 65536; at most 2^31 pixels.
 * @param count width x height.
 * @param depths, depth_stride of the first surface seen through the middle of each pixel [m], row by row from
 *     the upper left, measured along the viewing axis and not along the ray. Infinity where there is none; NaN,
 *     0 or less makes the pixel a border.
 * @param labels, label_stride receive each pixel's region: the number of its first pixel, from 1 on; 0 for a
 *     pixel at a border, which filters leave alone, because its own light may come from both sides.
 * @note Two neighbours are apart where neither surface, continued as a plane, comes within 1 % of the other in
 *     inverse depth: floors seen at a grazing angle are no edges. Needs 8 bytes a pixel for the call.
 */
covbeam_status covbeam_film_regions(uint32_t width,
                                    uint32_t height,
                                    size_t count,
                                    const float *depths,
                                    size_t depth_stride,
                                    uint32_t *labels,
                                    size_t label_stride);

/**
 * Makes the film of a picture, without rays so far.
 *
 * @param width, height of the picture, each 1 to 65536; at most 2^31 pixels.
 * @param typical_radiance of the picture, give or take a factor of a thousand [W/(m^2 sr)] > 0: light is added up in whole
 *     multiples of 2^-32 of it, so that the order of passes and rays does not count; sums stop at 2^31 times it.
 * @param count width x height.
 * @param regions, region_stride of covbeam_film_regions, copied: filters do not reach from one into another, and
 *     leave pixels with 0 alone. NULL is one region everywhere.
 * @param out the handle.
 */
covbeam_status covbeam_film_new(uint32_t width,
                                uint32_t height,
                                float typical_radiance,
                                size_t count,
                                const uint32_t *regions,
                                size_t region_stride,
                                struct covbeam_film **out);

/**
 * Frees a film.
 *
 * @param film NULL is ignored.
 */
void covbeam_film_free(struct covbeam_film *film);

/**
 * How much memory a film holds.
 *
 * @param film the film.
 * @param bytes receives it.
 */
covbeam_status covbeam_film_get_memory(const struct covbeam_film *film, size_t *bytes);

/**
 * At how many pixels the spectrum of the picture is wanted: about 43 x 43, whatever the picture's size.
 *
 * @param film the film.
 * @param count receives their number.
 */
covbeam_status covbeam_film_get_node_count(const struct covbeam_film *film, size_t *count);

/**
 * At which pixels the spectrum of the picture is wanted.
 *
 * @param film the film.
 * @param count as many as covbeam_film_get_node_count says.
 * @param pixels, pixel_stride receive two numbers each: x to the right and y down.
 */
covbeam_status covbeam_film_nodes(const struct covbeam_film *film,
                                  size_t count,
                                  uint32_t *pixels,
                                  size_t pixel_stride);

/**
 * Plans a pass: as wide filters as the spectra allow, none of which reaches where a narrower one is asked for; and two
 * eye rays under each. In place of the plan before, if that has not been added. Stopped, that stays.
 *
 * @param film the film.
 * @param pass its number. The passes with odd numbers are one half of all, the others are the other: what they differ by
 *     tells the error, so a picture needs as many of both.
 * @param error relative bias > 0 that a filter may cause, as covbeam_image_spectrum_filter takes it: of a
 *     covbeam_kernel.
 * @param light_paths of the pass: it gets at least half as many eye rays.
 * @param count as many as covbeam_film_get_node_count says.
 * @param spectra, spectrum_stride of covbeam_image_spectra_along the eye rays through the middles of the pixels of
 *     covbeam_film_nodes; all 0 where there is no fog: such pixels have no filter, and a ray in each pass.
 * @param poll may be NULL; asked at least every few milliseconds. Not 0 ends the call with COVBEAM_CANCELLED.
 * @param user given to poll.
 * @note Thesis 5.3.2. 1 us a node and 30 ns a pixel.
 */
covbeam_status covbeam_film_plan(struct covbeam_film *film,
                                 uint32_t pass,
                                 float error,
                                 uint32_t light_paths,
                                 size_t count,
                                 const struct covbeam_image_spectrum *spectra,
                                 size_t spectrum_stride,
                                 covbeam_poll poll,
                                 void *user);

/**
 * Eye rays that pixels get in the pass that is planned.
 *
 * @param film a film with a plan whose pass has not been added.
 * @param count width x height.
 * @param densities, density_stride receive numbers in (0, 1].
 */
covbeam_status covbeam_film_density(const struct covbeam_film *film,
                                    size_t count,
                                    float *densities,
                                    size_t density_stride);

/**
 * Adds the pass that is planned: what its eye rays saw.
 *
 * @param film a film with a plan whose pass has not been added.
 * @param count number of rays, in any order, any number of them through a pixel; 0 is a pass that saw nothing.
 * @param rays, ray_stride all of the pass.
 * @note 20 ns a ray and 2 ns a pixel.
 */
covbeam_status covbeam_film_add(struct covbeam_film *film,
                                size_t count,
                                const struct covbeam_film_ray *rays,
                                size_t ray_stride);

/**
 * Makes a film ready for covbeam_film_picture: where a filter of the latest pass disagrees with narrower ones by more
 * than the noise of the two halves of the passes, it is narrowed. Stopped, the film is as before.
 *
 * @param film the film.
 * @param poll may be NULL; asked at least every few milliseconds, in a picture of a million pixels. Not 0 ends the call with
 *     COVBEAM_CANCELLED.
 * @param user given to poll.
 * @note After O. V. Lepski (1991): the widest filter that agrees with all narrower ones. 50 ms, and 30 ns a pixel.
 */
covbeam_status covbeam_film_verify(struct covbeam_film *film,
                                   covbeam_poll poll,
                                   void *user);

/**
 * Some rows of the picture. Threads may share the work, each with rows of its own.
 *
 * @param film a film that has been verified since the latest pass was added.
 * @param first_row a multiple of 8.
 * @param count width x number of rows, which is a multiple of 8 or reaches the last row.
 * @param pixels, pixel_stride receive the rows; 0 in a picture without rays.
 * @note 0.2 us a pixel where filters are wide, up to 3 us where they are not.
 */
covbeam_status covbeam_film_picture(const struct covbeam_film *film,
                                    uint32_t first_row,
                                    size_t count,
                                    struct covbeam_film_pixel *pixels,
                                    size_t pixel_stride);

/**
 * Standard errors of a picture, from the two halves of its passes: squared differences averaged over 5x5 pixels, and what
 * is known of the filtered light.
 *
 * @param width, height of the picture, or of a part of it that threads share: then rows at least 2 away from the
 *     part's ends have the errors that they have in the whole.
 * @param count width x height.
 * @param pixels, pixel_stride of covbeam_film_picture.
 * @param errors, error_stride receive the standard error of each pixel's luminance (Rec. 709) [W/(m^2 sr)].
 * @note 40 ns and 20 bytes a pixel for the call.
 */
covbeam_status covbeam_film_errors(uint32_t width,
                                   uint32_t height,
                                   size_t count,
                                   const struct covbeam_film_pixel *pixels,
                                   size_t pixel_stride,
                                   float *errors,
                                   size_t error_stride);

/**
 * Lays knots along a stretch of a ray, at equal steps of the angle at which a light sees it. Each is dark, and
 * nothing is known: the host writes its radiance, deviation and visibility.
 *
 * @param origin of the ray [m].
 * @param direction of the ray, unit.
 * @param from where the stretch begins [m], finite.
 * @param to where it ends [m] >= from; infinity stands for where the light sees the rest under 1/1000 rad.
 * @param light its position, or centre [m]. On the ray itself, the steps are equal in distance.
 * @param count number of knots >= 2; 97 serve well.
 * @param knots, knot_stride receive them, from near to far.
 * @note Kulla and Fajardo 2012. About 5 ns a knot.
 */
covbeam_status covbeam_march_lay(const float *origin,
                                 const float *direction,
                                 float from,
                                 float to,
                                 const float *light,
                                 size_t count,
                                 struct covbeam_march_knot *knots,
                                 size_t knot_stride);

/**
 * Makes the memory of a thread's marches.
 *
 * @param out the handle.
 */
covbeam_status covbeam_march_new(struct covbeam_march **out);

/**
 * Frees a thread's memory.
 *
 * @param march NULL is ignored.
 */
void covbeam_march_free(struct covbeam_march *march);

/**
 * Takes the table of the next eye ray, in place of the one before.
 *
 * @param march the thread's memory.
 * @param count number of knots >= 2.
 * @param knots, knot_stride by distance, which are finite and do not fall; copied. Between them the radiance is
 *     taken as linear, and where two neighbours are dark no shadow ray is placed: lay them where light is, such
 *     as inside a spot's cone.
 * @note 25 ns a knot.
 */
covbeam_status covbeam_march_update(struct covbeam_march *march,
                                    size_t count,
                                    const struct covbeam_march_knot *knots,
                                    size_t knot_stride);

/**
 * What the table says before any shadow ray is traced.
 *
 * @param march a march that has a table.
 * @param expected receives it.
 */
covbeam_status covbeam_march_get_expected(const struct covbeam_march *march,
                                          struct covbeam_march_expected *expected);

/**
 * How many of a ray's shadow rays should be spent on a first round.
 *
 * @param march a march that has a table.
 * @param rays shadow rays in all.
 * @param first receives their number; 0 = all in one round, because the expected changes are too many to be
 *     found one by one. For a light with an extent one round is better whatever this says: two shadow rays to
 *     different points of it differ without a border between them.
 */
covbeam_status covbeam_march_get_first_round(const struct covbeam_march *march, size_t rays, size_t *first);

/**
 * Places a round of shadow rays from the table alone. The sum of weight x radiance x visibility over the round
 * is an unbiased estimate, whatever the table says, as long as it hides no light between two dark knots.
 *
 * @param march a march that has a table.
 * @param count number of shadow rays; with 0 nothing is done.
 * @param jitters, jitter_stride uniform numbers in [0, 1), independent of each other.
 * @param samples, sample_stride receive the places, from near to far, with a visibility of 0; without light on
 *     the ray, with a weight of 0 at the first knot.
 * @note Thesis 5.3.3; for light that is known without a shadow ray, the density that is best for strata. About
 *     1 us for 30.
 */
covbeam_status covbeam_march_place(struct covbeam_march *march,
                                   size_t count,
                                   const float *jitters,
                                   size_t jitter_stride,
                                   struct covbeam_march_sample *samples,
                                   size_t sample_stride);

/**
 * Places a second round of shadow rays, dense where the first one saw changes. The estimate is the sum over
 * the second round alone, and unbiased likewise.
 *
 * @param march the march, with the table that the first round was placed with.
 * @param first_count number of shadow rays of the first round.
 * @param firsts, first_stride what covbeam_march_place wrote, with the visibilities found, each in [0, 1]. A
 *     NaN, and a weight of 0, say nothing.
 * @param count number of shadow rays of the second round; with 0 nothing is done.
 * @param jitters, jitter_stride as for covbeam_march_place, independent of the first round.
 * @param samples, sample_stride as there.
 * @note About 3 us for 10 and 20.
 */
covbeam_status covbeam_march_refine(struct covbeam_march *march,
                                    size_t first_count,
                                    const struct covbeam_march_sample *firsts,
                                    size_t first_stride,
                                    size_t count,
                                    const float *jitters,
                                    size_t jitter_stride,
                                    struct covbeam_march_sample *samples,
                                    size_t sample_stride);

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
void covbeam_importance_free(struct covbeam_importance *importance);

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

#endif  /* COVBEAM_H */
