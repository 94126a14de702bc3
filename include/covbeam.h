/*
 * covbeam: frequency-aware photon beams. Fog, smoke and water lit by strong lights.
 * MIT or Apache-2.0. Made by cbindgen from ffi/src; do not edit.
 *
 * A pass of a picture
 *
 *   covbeam_schedule_kernel(&schedule, pass, &kernel);      radius and accepted error of this pass, counted from 1
 *   covbeam_beam_map_clear(map);                            one map for each medium
 *
 *   For each photon path of the host's tracer (a tenth of the paths, by a sequence of their own, also carry a light field):
 *       covbeam_light_field_point(direction, COVBEAM_EVEN_LAMP, &field);    at the lamp
 *       each straight piece through a medium is a covbeam_beam, and with a light field a covbeam_segment too
 *       covbeam_find_edges(direction, &hit, probe, user, segment.edges, &segment.edge_count);     what casts shadows
 *       covbeam_segment_field_at(&segment, &fog, distance, &field);         on to the next event: refract,
 *       covbeam_light_field_refract(&field, normal, &curvature, eta, &passed);      reflect, scatter, diffuse
 *
 *   covbeam_beam_map_add(map, beam_count, beams, sizeof *beams);
 *   covbeam_grid_deposit(grid, &fog, segment_count, segments, sizeof *segments, NULL, NULL);
 *   covbeam_grid_resolve(grid);
 *   covbeam_beam_map_commit(map, kernel.max_radius, NULL, NULL);
 *
 *   For each tile of 8x8 pixels: rays of the host's camera, cut by surfaces into pieces inside one medium:
 *       covbeam_beam_map_gather(map, &kernel, grid, 64, rays, sizeof *rays, gathered, sizeof *gathered,
 *                               scratch, NULL, NULL);
 *       pixel += weight of the piece x gathered.radiance;   the mean over the passes is the picture
 *
 * examples/c is a whole host. What those with hierarchies, kernels or grids of their own need is in covbeam_extra.h.
 *
 * The numbers
 *
 * Of a host's own, or, where it knows nothing better, what serves in most scenes:
 *
 *   Grid's box: what the camera sees of lit media, not the whole scene: of each eye ray all but the 2.5 % of its light that
 *       comes nearest and the 2.5 % that comes from farthest away. Beyond the box kernels have min_radius.
 *   Grid's cells: about cubes, 14,000 in all (24 x 24 x 24).
 *   covbeam_schedule: radius 1/160 of the side of a cube as large as the scene, but 1/80 to 1/45 of the picture's side where
 *       the light is; alpha 0.8; max_radius 0.15 of a cell's shortest side, wider ones leak past what the cells know;
 *       error 0.01.
 *   Photons a pass: as many as let an eye ray meet some 64 beams, within 1,000 and 10,000: few paths and many passes
 *       smooth silhouettes.
 *   Light fields: a tenth of the paths. Every tenth point of one sequence of covbeam_path_number is not one: even indices
 *       lie in one half of its first dimension, and half of the lamp would have none. Give them a sequence number of their own.
 *   Passes with light fields: all of the first eight, then one in eight; the grid keeps what it has.
 *
 * A grid costs light fields and, at each pair of beam and ray, a look-up. Where the light is rough everywhere (caustics that
 * fill the picture, kernels that are hardly wider than min_radius: see covbeam_gathered.radius) it costs more than it gives;
 * gather with NULL for the grid then.
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
 * One element: covbeam_light_field_travel is covbeam_light_fields_travel for one field, covbeam_phase_sample is
 * covbeam_phase_sample_many for one direction: each follows the function on arrays, which it calls with a count of
 * 1, and which is described. Those check all elements before they change the first.
 *
 * Options: structs that begin with struct_size, which is to be set to sizeof of themselves. Fields that a
 * newer header adds are 0 for an older host; an older library refuses new fields that are not 0.
 *
 * Uniform random numbers are in [0, 1). 1 itself, to which (float)0.99999999 rounds, counts as the largest
 * number below.
 *
 * Failure: every function that can fail returns a covbeam_status. All but COVBEAM_OK leave the outputs
 * unwritten and the objects as they were, unless the function says otherwise, and covbeam_last_error()
 * names the parameter, the element and the field, "beams[12].direction: ...", and what to do. NaN, infinities
 * without a meaning, and vectors that should have a direction but do not are refused. Nothing is ever
 * printed. A defect of the library that ends in a panic returns COVBEAM_PANICKED; the object that the call
 * was changing then answers COVBEAM_POISONED until it is freed.
 *
 * Memory: where it cannot be had the call returns COVBEAM_OUT_OF_MEMORY, and the message says how many
 * bytes were wanted. (Loaded with dlopen, the library leaves each thread's message, 300 bytes, to the
 * loader, which ends the process if it has none when a thread calls for the first time. Linked, it has them
 * from the thread's start.)
 *
 * Handles: made by _new, freed by _free, for which NULL is fine. A handle of the wrong kind is refused; one
 * that has been freed often is, but do not rely on that: its memory may be in other use.
 *
 * Callbacks run in the thread of the call. They must return (no exception, no longjmp), and may call the
 * library: what would change or free an object of the call, or look at one that the call changes, returns
 * COVBEAM_BUSY.
 *
 * Threads: objects passed by pointer to const may be used by several threads at once, those passed without
 * const by one at a time. A call that comes too early returns COVBEAM_BUSY; do not rely on that, because one
 * on a handle that another thread is just freeing comes too late to be told. The library starts no thread
 * and keeps no state but each thread's last message. The same calls give the same bits.
 *
 * Costs: an operator of a light field takes 0.1 to 0.5 us; whatever costs more says so. Everything is
 * linear in its counts unless that is said.
 *
 * Versions: COVBEAM_ABI_VERSION changes when a host must be compiled anew, and with it the SONAME, which
 * ends in it.
 */


#ifndef COVBEAM_H
#define COVBEAM_H

#include <stddef.h>
#include <stdint.h>

/**
 * Of the ABI that the header declares. A host compares it with covbeam_abi_version().
 */
#define COVBEAM_ABI_VERSION 3

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
    /**
     * Another call on the object, of this thread or of another, has not returned yet.
     */
    COVBEAM_BUSY = 15,
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
 *
 * Error of what it says of the fluence, relative to the largest entry of its covariance: one rounding of the
 * ten numbers per operator; below 1e-6 after tens of events and 1e-5 after 1000, but near a focus, where it
 * is as large as what the rounding of the inputs changes. Long ways of strongly bent light lose more: of 1000
 * random chains of up to 1000 events, with ways of 1e-3 to 1e3 m and curvatures of 0.01 to 100 per m, half are
 * within 1e-7, 99 % within 7e-6, all within 2e-4. Where curvature times distance is beyond 1e7, 24 bits hold
 * only one axis of the light.
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
     * How far off this surface rays start that leave it [m], finite and >= 0: what the host's rays are moved by
     * so as not to meet it again. A hit nearer than 4096 times that is on the surface which the ray itself left,
     * and no edge, if the ray starts within twice the offset of the hit's tangent plane.
     */
    float offset;
} covbeam_probe_hit;

/**
 * Casts a ray from the origin of the search along direction, 3 floats, unit. It sets hit to where the ray meets
 * the nearest surface that casts shadows; before the call distance is infinity, which is nothing met. Return 0,
 * or anything else to give up.
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
     * Flux at the origin [W] > 0, mean of the channels. Only its ratio to that of other segments matters: where
     * a tenth of the photons carry fields, it need not be ten times the beam's.
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
 * Asked now and then during a long call: return 0 to go on, anything else to stop.
 */
typedef int32_t (*covbeam_poll)(void *user);

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
     * Accepted pairs of ray and beam; one of nearly one direction (sine below .05) counts as eight.
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
 * A place where a beam comes within the kernel radius of an eye ray, for covbeam_beam_map_gather_shaded. A
 * pair of nearly one direction (sine below .05) has eight, along the eye ray.
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
     * multiplies; of the eight places of a pair along the ray, each one's share of its integral.
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
 * anything else to give up.
 */
typedef int32_t (*covbeam_shade)(void *user,
                                 const struct covbeam_contact *contacts,
                                 size_t count,
                                 float *values);

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
 * @param count number of fields; with 0 nothing is done.
 * @param directions, direction_stride of propagation, normalised by the library: any length but 0.
 * @param angular_variances, angular_variance_stride of the emission [cycles^2/rad^2] >= 0:
 *     COVBEAM_EVEN_LAMP for a lamp that shines evenly, because of the fall-off with the square of the
 *     distance; more where its intensity changes with the angle.
 * @param out, out_stride the light fields.
 * @note Thesis 5.3.1.
 */
covbeam_status covbeam_light_fields_point(size_t count,
                                          const float *directions,
                                          size_t direction_stride,
                                          const float *angular_variances,
                                          size_t angular_variance_stride,
                                          struct covbeam_light_field *out,
                                          size_t out_stride);

static inline covbeam_status covbeam_light_field_point(const float *direction, float angular_variance,
                                                       struct covbeam_light_field *out)
{
    return covbeam_light_fields_point(1, direction, 0, &angular_variance, 0, out, 0);
}

/**
 * Light of a disk source, at its centre.
 *
 * @param count number of fields; with 0 nothing is done.
 * @param directions, direction_stride of propagation, normalised by the library: any length but 0.
 * @param normals, normal_stride of the disk, any length, either sign.
 * @param radii, radius_stride [m] >= 0: 0 is a point, infinity a uniform field.
 * @param angular_variances, angular_variance_stride as for covbeam_light_field_point.
 * @param out, out_stride the light fields.
 * @note Thesis 5.3.1.
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

static inline covbeam_status covbeam_light_field_disk(const float *direction, const float *normal,
                                                      float radius, float angular_variance,
                                                      struct covbeam_light_field *out)
{
    return covbeam_light_fields_disk(1, direction, 0, normal, 0, &radius, 0, &angular_variance, 0, out, 0);
}

/**
 * An exactly parallel beam, such as sunlight or a laser.
 *
 * @param count number of fields; with 0 nothing is done.
 * @param directions, direction_stride of propagation, normalised by the library: any length but 0.
 * @param radii, radius_stride of the beam [m] >= 0: infinity for a uniform one.
 * @param out, out_stride the light fields.
 * @note Thesis 5.3.1.
 */
covbeam_status covbeam_light_fields_collimated(size_t count,
                                               const float *directions,
                                               size_t direction_stride,
                                               const float *radii,
                                               size_t radius_stride,
                                               struct covbeam_light_field *out,
                                               size_t out_stride);

static inline covbeam_status covbeam_light_field_collimated(const float *direction, float radius,
                                                            struct covbeam_light_field *out)
{
    return covbeam_light_fields_collimated(1, direction, 0, &radius, 0, out, 0);
}

/**
 * A light field without correlations, from its four variances. A Gaussian of standard deviation w has 1/(4
 * pi^2 w^2).
 *
 * @param count number of fields; with 0 nothing is done.
 * @param directions, direction_stride of propagation, normalised by the library: any length but 0.
 * @param x_axes, x_axis_stride its part across the direction is the x axis of the variances; some axis if
 *     it has none.
 * @param spatial_variances, spatial_variance_stride along x and y [cycles^2/m^2], each >= 0: 0 is uniform,
 *     infinity a point or a line.
 * @param angular_variances, angular_variance_stride along x and y [cycles^2/rad^2], each >= 0: 0 is
 *     isotropic, infinity parallel.
 * @param out, out_stride the light fields.
 * @note Thesis Eq 5.12.
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

static inline covbeam_status covbeam_light_field_gaussian(const float *direction, const float *x_axis,
                                                          const float *spatial_variance,
                                                          const float *angular_variance,
                                                          struct covbeam_light_field *out)
{
    return covbeam_light_fields_gaussian(1, direction, 0, x_axis, 0, spatial_variance, 0, angular_variance, 0,
                                         out, 0);
}

/**
 * Travel through vacuum or a homogeneous medium. The frame turns to the principal axes of the light's angles,
 * where a rounding costs least.
 *
 * @param count number of fields; with 0 nothing is done.
 * @param fields, field_stride the light fields, changed in place.
 * @param distances, distance_stride [m], finite; 0 changes nothing, a negative one goes back.
 * @note Thesis 5.3.1.
 */
covbeam_status covbeam_light_fields_travel(size_t count,
                                           struct covbeam_light_field *fields,
                                           size_t field_stride,
                                           const float *distances,
                                           size_t distance_stride);

static inline covbeam_status covbeam_light_field_travel(struct covbeam_light_field *field, float distance)
{
    return covbeam_light_fields_travel(1, field, 0, &distance, 0);
}

/**
 * Travel through a medium: in a homogeneous one covbeam_light_field_travel, else with the attenuation that
 * varies across the ray.
 *
 * @param count number of fields; with 0 nothing is done.
 * @param fields, field_stride the light fields, changed in place; they move along their directions.
 * @param medium what it travels in; the mean extinction of the channels counts.
 * @param origins, origin_stride where the field is [m].
 * @param distances, distance_stride [m] >= 0, finite.
 * @note Thesis 5.3.1. Costs up to 256 look-ups of the density's derivatives.
 */
covbeam_status covbeam_light_fields_carry(size_t count,
                                          struct covbeam_light_field *fields,
                                          size_t field_stride,
                                          const struct covbeam_medium *medium,
                                          const float *origins,
                                          size_t origin_stride,
                                          const float *distances,
                                          size_t distance_stride);

static inline covbeam_status covbeam_light_field_carry(struct covbeam_light_field *field,
                                                       const struct covbeam_medium *medium,
                                                       const float *origin, float distance)
{
    return covbeam_light_fields_carry(1, field, 0, medium, origin, 0, &distance, 0);
}

/**
 * Turns the frame about the ray, to read covbeam_light_field_slice along given axes: every other operator may
 * turn it, so rotate right before. The light stays what it is.
 *
 * @param count number of fields; with 0 nothing is done.
 * @param fields, field_stride the light fields, changed in place.
 * @param x_axes, x_axis_stride any length but 0; its part across the ray becomes the x axis; along the ray:
 *     nothing changes.
 * @note Thesis 5.3.1.2.
 */
covbeam_status covbeam_light_fields_rotate(size_t count,
                                           struct covbeam_light_field *fields,
                                           size_t field_stride,
                                           const float *x_axes,
                                           size_t x_axis_stride);

static inline covbeam_status covbeam_light_field_rotate(struct covbeam_light_field *field,
                                                        const float *x_axis)
{
    return covbeam_light_fields_rotate(1, field, 0, x_axis, 0);
}

/**
 * Reflection by a smooth mirror. A ray that grazes it to below 1e-12 is left as it was.
 *
 * @param count number of fields; with 0 nothing is done.
 * @param fields, field_stride the light fields, changed in place.
 * @param normals, normal_stride at the hit, any length, either side.
 * @param curvatures, curvature_stride of the surface on the side of the normal; may be NULL: a plane.
 * @note Coddington's equations.
 */
covbeam_status covbeam_light_fields_reflect(size_t count,
                                            struct covbeam_light_field *fields,
                                            size_t field_stride,
                                            const float *normals,
                                            size_t normal_stride,
                                            const struct covbeam_curvature *curvatures,
                                            size_t curvature_stride);

static inline covbeam_status covbeam_light_field_reflect(struct covbeam_light_field *field,
                                                         const float *normal,
                                                         const struct covbeam_curvature *curvature)
{
    return covbeam_light_fields_reflect(1, field, 0, normal, 0, curvature, 0);
}

/**
 * Refraction through a smooth surface.
 *
 * @param count number of fields; with 0 nothing is done.
 * @param fields, field_stride the light fields, changed in place.
 * @param normals, normal_stride at the hit, any length, either side.
 * @param curvatures, curvature_stride of the surface on the side of the normal; may be NULL: a plane.
 * @param etas, eta_stride refractive index on the incoming side over that on the other, > 0.
 * @param passed, passed_stride 1 if light passes; 0 on total reflection (and exactly grazing light), which
 *     leaves the field as it was.
 * @note Coddington's equations.
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

static inline covbeam_status covbeam_light_field_refract(struct covbeam_light_field *field,
                                                         const float *normal,
                                                         const struct covbeam_curvature *curvature, float eta,
                                                         uint8_t *passed)
{
    return covbeam_light_fields_refract(1, field, 0, normal, 0, curvature, 0, &eta, 0, passed, 0);
}

/**
 * Occlusion by an edge beside the ray, such as a silhouette that it passes. Across the edge 1/(2 pi distance)^2
 * [cycles^2/m^2] is added to the variance of the positions, as if a Gaussian as wide as the distance masked
 * them. The field must be where the ray passes the edge: travel there first, and make one call an edge.
 * (covbeam_segment_field_at and covbeam_grid_deposit do both for the edges of a segment.)
 *
 * @param count number of fields; with 0 nothing is done.
 * @param fields, field_stride the light fields, changed in place.
 * @param towards_edges, towards_edge_stride from the ray to the nearest point of the edge, any length;
 *     along the ray: nothing changes.
 * @param distances, distance_stride between ray and edge [m] >= 0; infinity is no edge.
 * @note Thesis 5.3.1.
 */
covbeam_status covbeam_light_fields_occlude(size_t count,
                                            struct covbeam_light_field *fields,
                                            size_t field_stride,
                                            const float *towards_edges,
                                            size_t towards_edge_stride,
                                            const float *distances,
                                            size_t distance_stride);

static inline covbeam_status covbeam_light_field_occlude(struct covbeam_light_field *field,
                                                         const float *towards_edge, float distance)
{
    return covbeam_light_fields_occlude(1, field, 0, towards_edge, 0, &distance, 0);
}

/**
 * Narrowing of the directions across one axis, such as by the soft rim of a spot light (a Gaussian rim of
 * standard deviation s has 1/(4 pi^2 s^2)).
 *
 * @param count number of fields; with 0 nothing is done.
 * @param fields, field_stride the light fields, changed in place.
 * @param acrosses, across_stride in which the light falls off, any length; along the ray: nothing changes.
 * @param angular_variances, angular_variance_stride [cycles^2/rad^2] >= 0: 0 changes nothing, infinity
 *     leaves one direction.
 * @note Thesis 5.3.1.
 */
covbeam_status covbeam_light_fields_narrow(size_t count,
                                           struct covbeam_light_field *fields,
                                           size_t field_stride,
                                           const float *acrosses,
                                           size_t across_stride,
                                           const float *angular_variances,
                                           size_t angular_variance_stride);

static inline covbeam_status covbeam_light_field_narrow(struct covbeam_light_field *field,
                                                        const float *across, float angular_variance)
{
    return covbeam_light_fields_narrow(1, field, 0, across, 0, &angular_variance, 0);
}

/**
 * Scattering in a medium, or by a rough surface's lobe, into a new direction.
 *
 * @param count number of fields; with 0 nothing is done.
 * @param fields, field_stride the light fields, changed in place.
 * @param directions, direction_stride of propagation after the event, any length but 0.
 * @param angular_variances, angular_variance_stride of the lobe [cycles^2/rad^2] >= 0, see
 *     covbeam_phase_angular_variance: 0 is isotropic, infinity does not blur.
 * @note Thesis 5.3.1.
 */
covbeam_status covbeam_light_fields_scatter(size_t count,
                                            struct covbeam_light_field *fields,
                                            size_t field_stride,
                                            const float *directions,
                                            size_t direction_stride,
                                            const float *angular_variances,
                                            size_t angular_variance_stride);

static inline covbeam_status covbeam_light_field_scatter(struct covbeam_light_field *field,
                                                         const float *direction, float angular_variance)
{
    return covbeam_light_fields_scatter(1, field, 0, direction, 0, &angular_variance, 0);
}

/**
 * Diffuse reflection or transmission into a new direction. A cosine below 1e-12 on either side leaves the
 * field as it was.
 *
 * @param count number of fields; with 0 nothing is done.
 * @param fields, field_stride the light fields, changed in place.
 * @param normals, normal_stride of the surface, any length, either sign.
 * @param directions, direction_stride of propagation after the event, any length but 0.
 * @note Thesis 5.3.1.
 */
covbeam_status covbeam_light_fields_diffuse(size_t count,
                                            struct covbeam_light_field *fields,
                                            size_t field_stride,
                                            const float *normals,
                                            size_t normal_stride,
                                            const float *directions,
                                            size_t direction_stride);

static inline covbeam_status covbeam_light_field_diffuse(struct covbeam_light_field *field,
                                                         const float *normal, const float *direction)
{
    return covbeam_light_fields_diffuse(1, field, 0, normal, 0, direction, 0);
}

/**
 * The spectrum of the fluence across the ray, along the frame's axes: x_axis, and direction x x_axis. They are
 * not those of the field before an operator: covbeam_light_field_rotate chooses them, and
 * covbeam_light_field_fluence answers along the axes of the world.
 *
 * @param count number of fields; with 0 nothing is done.
 * @param fields, field_stride the light fields.
 * @param variances_out, out_stride [xx, xy, yy] [cycles^2/m^2].
 * @note Thesis Eq 5.14.
 */
covbeam_status covbeam_light_fields_slice(size_t count,
                                          const struct covbeam_light_field *fields,
                                          size_t field_stride,
                                          float *variances_out,
                                          size_t out_stride);

static inline covbeam_status covbeam_light_field_slice(const struct covbeam_light_field *field, float *out)
{
    return covbeam_light_fields_slice(1, field, 0, out, 0);
}

/**
 * The spectrum of the fluence around the ray, in world axes.
 *
 * @param count number of fields; with 0 nothing is done.
 * @param fields, field_stride the light fields.
 * @param limits, limit_stride largest deviation kept [cycles/m] > 0, such as the Nyquist frequency 1/(2h)
 *     of voxels of side h; infinity keeps all.
 * @param spectrum_out, out_stride covariance [cycles^2/m^2].
 * @note Thesis Eq 5.14.
 */
covbeam_status covbeam_light_fields_fluence(size_t count,
                                            const struct covbeam_light_field *fields,
                                            size_t field_stride,
                                            const float *limits,
                                            size_t limit_stride,
                                            struct covbeam_spectrum *spectrum_out,
                                            size_t out_stride);

static inline covbeam_status covbeam_light_field_fluence(const struct covbeam_light_field *field, float limit,
                                                         struct covbeam_spectrum *out)
{
    return covbeam_light_fields_fluence(1, field, 0, &limit, 0, out, 0);
}

/**
 * Samples a direction after scattering in proportion to the phase function: the weight (value / density) is 1.
 *
 * @param phase the phase function.
 * @param count number of directions; with 0 nothing is done.
 * @param directions, direction_stride of propagation before the event, unit.
 * @param xis, xi_stride two independent uniform numbers in [0, 1).
 * @param scattered, scattered_stride direction of propagation after the event, unit; may be the same array
 *     as directions.
 * @note The angle of a narrow lobe is exact: it does not pass through its cosine.
 */
covbeam_status covbeam_phase_sample_many(const struct covbeam_phase *phase,
                                         size_t count,
                                         const float *directions,
                                         size_t direction_stride,
                                         const float *xis,
                                         size_t xi_stride,
                                         float *scattered,
                                         size_t scattered_stride);

static inline covbeam_status covbeam_phase_sample(const struct covbeam_phase *phase, const float *direction,
                                                  const float *xi, float *scattered)
{
    return covbeam_phase_sample_many(phase, 1, direction, 0, xi, 0, scattered, 0);
}

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
 * @param density NULL is fine.
 */
covbeam_status covbeam_density_free(struct covbeam_density *density);

/**
 * Distance along a ray at which a column is reached: the inverse of covbeam_medium_column_at.
 *
 * Free flight is sampled with it: column = -log(1 - u) / extinction for a uniform u in [0, 1) and the
 * extinction of one channel; light that gets infinity reaches the end of the ray.
 *
 * @param medium the medium.
 * @param count number of rays; with 0 nothing is done.
 * @param origins, origin_stride of the ray [m].
 * @param directions, direction_stride of the ray, unit.
 * @param lengths, length_stride of the ray [m] >= 0; infinity allowed.
 * @param columns, column_stride [m] >= 0; infinity allowed.
 * @param distances, distance_stride [m]; infinity if the ray ends before.
 * @note Voxels: the column there is within 5e-4 of the one asked for, relatively; about 20 ns a voxel
 *     passed.
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

static inline covbeam_status covbeam_medium_distance_at(const struct covbeam_medium *medium,
                                                        const float *origin, const float *direction,
                                                        float length, float column, float *distance)
{
    return covbeam_medium_distance_at_many(medium, 1, origin, 0, direction, 0, &length, 0, &column, 0,
                                           distance, 0);
}

/**
 * The share of light that a stretch of medium leaves, per channel.
 *
 * @param medium the medium.
 * @param count number of rays; with 0 nothing is done.
 * @param origins, origin_stride of the ray [m].
 * @param directions, direction_stride of the ray, unit.
 * @param distances, distance_stride along the ray [m] >= 0; infinity allowed.
 * @param transmittances, transmittance_stride three numbers in [0, 1]: exp(-extinction x column).
 * @note The column of covbeam_medium_column_at, and one exponential if the channels are equal, else three.
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

static inline covbeam_status covbeam_medium_transmittance(const struct covbeam_medium *medium,
                                                          const float *origin, const float *direction,
                                                          float distance, float *transmittance)
{
    return covbeam_medium_transmittance_many(medium, 1, origin, 0, direction, 0, &distance, 0, transmittance,
                                             0);
}

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
 * @param count number of rays; with 0 nothing is done.
 * @param origins, origin_stride of the ray [m].
 * @param directions, direction_stride of the ray, unit.
 * @param distances, distance_stride [m]: where the medium becomes opaque, hardly goes on, or its voxels
 *     end; infinite if there is no such place.
 * @note Voxels: about 20 ns a voxel passed.
 */
covbeam_status covbeam_medium_reach_many(const struct covbeam_medium *medium,
                                         size_t count,
                                         const float *origins,
                                         size_t origin_stride,
                                         const float *directions,
                                         size_t direction_stride,
                                         float *distances,
                                         size_t distance_stride);

static inline covbeam_status covbeam_medium_reach(const struct covbeam_medium *medium, const float *origin,
                                                  const float *direction, float *distance)
{
    return covbeam_medium_reach_many(medium, 1, origin, 0, direction, 0, distance, 0);
}

/**
 * The number of one decision of one light path, uniform in [0, 1). The first COVBEAM_EMISSION_DIMENSIONS
 * decisions are the coordinates of a scrambled Sobol' point, which place 2^k paths in a row evenly; those after
 * them are independent. At equal numbers of paths the picture's error is 1.2 to 8 times below that of
 * independent numbers.
 *
 * @param seed another seed is another scramble of all sequences.
 * @param sequence keeps sequences of one seed apart, such as paths with light fields and those without.
 * @param count number of paths; with 0 nothing is done.
 * @param paths, path_stride the path's place in the sequence, counted on over the passes of a picture.
 * @param dimension which decision of the path, from 0 on.
 * @param numbers, number_stride in [0, 1), a multiple of 2^-24.
 */
covbeam_status covbeam_path_numbers(uint32_t seed,
                                    uint32_t sequence,
                                    size_t count,
                                    const uint32_t *paths,
                                    size_t path_stride,
                                    uint32_t dimension,
                                    float *numbers,
                                    size_t number_stride);

static inline covbeam_status covbeam_path_number(uint32_t seed, uint32_t sequence, uint32_t path,
                                                 uint32_t dimension, float *number)
{
    return covbeam_path_numbers(seed, sequence, 1, &path, 0, dimension, number, 0);
}

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
 * @param count number of segments; with 0 nothing is done.
 * @param segments, segment_stride of each, origin, field and edges count; the rest is not looked at.
 * @param medium what it travels in; the mean extinction of the channels counts. Of no scattering and no
 *     absorption in vacuum.
 * @param distances, distance_stride [m] >= 0, finite: to the photon's next event, at most to the surface on
 *     which the segment ends.
 * @param out, out_stride the light fields there; segment->field is fine.
 * @note Thesis 5.3.1. In a density that varies, up to 256 look-ups of its derivatives from edge to edge.
 */
covbeam_status covbeam_segments_field_at(size_t count,
                                         const struct covbeam_segment *segments,
                                         size_t segment_stride,
                                         const struct covbeam_medium *medium,
                                         const float *distances,
                                         size_t distance_stride,
                                         struct covbeam_light_field *out,
                                         size_t out_stride);

static inline covbeam_status covbeam_segment_field_at(const struct covbeam_segment *segment,
                                                      const struct covbeam_medium *medium, float distance,
                                                      struct covbeam_light_field *out)
{
    return covbeam_segments_field_at(1, segment, 0, medium, &distance, 0, out, 0);
}

/**
 * Makes an empty grid in the library's memory: 56 bytes a voxel, and 28 more from the first
 * covbeam_grid_resolve on.
 *
 * @param layout box and resolution.
 * @param out the handle.
 */
covbeam_status covbeam_grid_new(const struct covbeam_grid_layout *layout, struct covbeam_grid **out);

/**
 * Frees a grid; memory of the host's stays the host's, with what is in it.
 *
 * @param grid NULL is fine.
 */
covbeam_status covbeam_grid_free(struct covbeam_grid *grid);

/**
 * Empties a grid, and forgets what was resolved.
 *
 * @param grid the grid.
 */
covbeam_status covbeam_grid_clear(struct covbeam_grid *grid);

/**
 * Adds the light fields along segments of light paths, in their order; past each edge what the edge has left.
 * Stopped, the grid keeps what it has of the first segments: covbeam_grid_clear forgets that.
 *
 * @param grid the grid.
 * @param medium what the segments run through; what it leaves of light is the channels' mean.
 * @param count number of segments; with 0 nothing is done.
 * @param segments, segment_stride the segments.
 * @param poll may be NULL; asked at least every few milliseconds. Not 0 ends the call with COVBEAM_CANCELLED.
 * @param user given to poll.
 * @note Thesis 5.3.1, Eq 5.14 and 5.15. 0.2 us a voxel on the way, 0.7 us where the density varies; 2 to 40 us
 *     a segment. A tenth of a pass' photons is enough.
 */
covbeam_status covbeam_grid_deposit(struct covbeam_grid *grid,
                                    const struct covbeam_medium *medium,
                                    size_t count,
                                    const struct covbeam_segment *segments,
                                    size_t segment_stride,
                                    covbeam_poll poll,
                                    void *user);

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
 * Makes a map without beams.
 *
 * @param medium what its beams run through; copied, for all gathers too, and voxels are kept alive. For
 *     covbeam_beam_map_gather_shaded: any homogeneous one.
 * @param out the handle.
 */
covbeam_status covbeam_beam_map_new(const struct covbeam_medium *medium, struct covbeam_beam_map **out);

/**
 * Frees a map.
 *
 * @param map NULL is fine.
 */
covbeam_status covbeam_beam_map_free(struct covbeam_beam_map *map);

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
 * Makes the memory of a thread's gathers.
 *
 * @param out the handle.
 */
covbeam_status covbeam_scratch_new(struct covbeam_scratch **out);

/**
 * Frees a thread's memory.
 *
 * @param scratch NULL is fine.
 */
covbeam_status covbeam_scratch_free(struct covbeam_scratch *scratch);

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
 * The spectrum of the in-scattered light around a pixel, read off a grid along its eye ray: how fast the
 * picture varies there.
 *
 * @param grid a grid that has been resolved.
 * @param medium what the ray is in.
 * @param count number of pixels; with 0 nothing is done.
 * @param rays, ray_stride from the eye to where the light that it gathers ends, or infinite.
 * @param steps, step_stride two a pixel, side by side: how the ray changes with a pixel to the right, and with
 *     one down.
 * @param spectra, spectrum_stride positive semi-definite up to rounding; all 0 where the grid has no data.
 * @note Surfaces that end the rays of neighbouring pixels at other distances are no part of it: see
 *     covbeam_film_regions. Thesis 5.3.2, with the exact second derivatives of density x transmittance for
 *     its attenuation. About 40 ns a voxel passed in a homogeneous medium, 95 ns in an exponential one, 200
 *     ns in voxels.
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

static inline covbeam_status covbeam_image_spectrum_along(const struct covbeam_grid *grid,
                                                          const struct covbeam_medium *medium,
                                                          const struct covbeam_eye_ray *ray,
                                                          const struct covbeam_pixel_step *step,
                                                          struct covbeam_image_spectrum *spectrum)
{
    return covbeam_image_spectra_along(grid, medium, 1, ray, 0, step, 0, spectrum, 0);
}

/**
 * A pixel's threshold in a pass: the pixel gets an eye ray if its density is above. At any density the pixels
 * chosen are spread evenly over the picture, and a pixel is chosen evenly over the passes.
 *
 * @param pass any number; each chooses other pixels.
 * @param seed any number; shifts the pattern.
 * @param count number of pixels; with 0 nothing is done.
 * @param pixels, pixel_stride two numbers: x to the right and y down, any.
 * @param thresholds, threshold_stride in [0, 1).
 */
covbeam_status covbeam_pixel_threshold_many(uint32_t pass,
                                            uint32_t seed,
                                            size_t count,
                                            const uint32_t *pixels,
                                            size_t pixel_stride,
                                            float *thresholds,
                                            size_t threshold_stride);

static inline covbeam_status covbeam_pixel_threshold(uint32_t pass, uint32_t seed, const uint32_t *pixel,
                                                     float *threshold)
{
    return covbeam_pixel_threshold_many(pass, seed, 1, pixel, 0, threshold, 0);
}

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
 *     inverse depth: floors seen at a grazing angle are no edges. A region that lies on both sides of a silhouette
 *     is taken apart where its surface bends most: a pillar from the floor that it stands on, which goes on
 *     behind its top. Needs 24 bytes a pixel for the call.
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
 * @param film NULL is fine.
 */
covbeam_status covbeam_film_free(struct covbeam_film *film);

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
 * @param march NULL is fine.
 */
covbeam_status covbeam_march_free(struct covbeam_march *march);

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

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* COVBEAM_H */
