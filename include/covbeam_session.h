/*
 * covbeam_session.h: covbeam's whole method, for hosts that describe their scenes: meshes, materials, lights, volumes and a camera go in,
 * pictures come out, and the library does the rest: guided light paths, shadow rays, kernels, few eye rays and filters. Of the same library as
 * covbeam.h, and under its conventions. (Not there in a library that was built without the feature `session`.)
 * EXPERIMENTAL: structs and functions of this header may change until 0.2.
 * MIT or Apache-2.0. Made from ffi/src/session; do not edit.
 *
 * A picture
 *
 *   covbeam_geometry_new(&geometry);  add_mesh, add_instances, build       meshes, if there are any; shapes need none
 *   covbeam_scene_new(geometry, &description, &scene);                     all else, in plain structs
 *   covbeam_session_new(1, &scene, 0, &settings, NULL, NULL, &session);    settings = { .struct_size = sizeof settings } is the default method
 *   covbeam_session_until(session, &goal, poll, user, NULL);               passes, seconds or an error; or covbeam_session_pass, one by one
 *   covbeam_session_picture(session, COVBEAM_LAYER_ALL, pixels, rgb, 0, NULL, NULL);
 *
 * A renderer that keeps its own geometry gives functions in place of meshes (covbeam_host, covbeam_scene_new_of_host): the nearest surface of a ray,
 * and, if it is cheaper, whether a ray is blocked. It may keep textures, scattering functions, lamps and camera, too: materials, lights and a camera
 * that are described as its own are an estimate, by which the library decides what is worth following, and the picture has what its functions say.
 * The library's threads call them (or the host's: covbeam_session_settings.spawn); the same question must get the same answer.
 *
 * Numbers: a picture of so many passes depends on scene, settings and seed alone, and has the same bits on any number of threads. Sums of passes
 * are exact: machines that render some each (first_pass) give the same bits as one that renders all (covbeam_session_save, _merge).
 *
 * What a scene must be: closed objects of glass are watertight and their normals point outwards; a volume is around nothing but what its corners
 * hold. Where that is not so a ray takes what it meets for what it says: light may go straight through what leaks, but no value is NaN, and nothing
 * hangs. Lights and materials may be anything that their fields allow.
 *
 * Threads: a session has threads of its own, as many as its settings say; poll runs in the thread of the call.
 *
 * Memory: what a picture needs is estimated before (covbeam_session_info.memory), and COVBEAM_OUT_OF_MEMORY says that it is not there. A system
 * that refuses what was there a moment ago ends the process.
 */

#ifndef COVBEAM_SESSION_H
#define COVBEAM_SESSION_H

#include "covbeam.h"

/**
 * What a host that keeps its own geometry (covbeam_host) is asked for where a material is met.
 */
enum covbeam_asks
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * Nothing: the material is the same everywhere.
     */
    COVBEAM_ASKS_NOTHING = 0,
    /**
     * Which lobes there are at the hit. The material is the most that any place has: larger weights are cut to its own, and its index of
     * refraction and whether it is of glass hold everywhere.
     */
    COVBEAM_ASKS_LOBES = 1,
    /**
     * That, if the host has a function for it, and the ways on, which a scattering function of the host's draws. The material is an estimate,
     * by which the library decides what is worth following; what it lets straight through, its index and whether it is of glass hold.
     */
    COVBEAM_ASKS_WAYS = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum covbeam_asks covbeam_asks;
#else
typedef uint32_t covbeam_asks;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Kinds of shapes.
 */
enum covbeam_shape_kind
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * Around `a`, of `radius`.
     */
    COVBEAM_SHAPE_SPHERE = 0,
    /**
     * From the lower corner `a` to the upper one `b`.
     */
    COVBEAM_SHAPE_BOX = 1,
    /**
     * The parallelogram at the corner `a` with the edges `b` and `c`; its normal is along b x c.
     */
    COVBEAM_SHAPE_RECTANGLE = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum covbeam_shape_kind covbeam_shape_kind;
#else
typedef uint32_t covbeam_shape_kind;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Kinds of lights.
 */
enum covbeam_light_kind
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * A point or ball that shines all around, or by a pattern: position, intensity, radius, soft.
     */
    COVBEAM_LIGHT_POINT = 0,
    /**
     * The same into a cone: axis, cosine, blend, too.
     */
    COVBEAM_LIGHT_SPOT = 1,
    /**
     * A parallelogram or ellipse around its position that shines towards u x v: u, v, radiance, spread, is_round.
     */
    COVBEAM_LIGHT_AREA = 2,
    /**
     * A disk infinitely far away: axis, irradiance, angle.
     */
    COVBEAM_LIGHT_SUN = 3,
    /**
     * Triangles that shine on both sides: triangles, radiance.
     */
    COVBEAM_LIGHT_MESH = 4,
    /**
     * What is around the scene, infinitely far away: cells, rows, columns, axes.
     */
    COVBEAM_LIGHT_SKY = 5,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum covbeam_light_kind covbeam_light_kind;
#else
typedef uint32_t covbeam_light_kind;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * How places in the picture become rays.
 */
enum covbeam_projection
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * Through a point, or a lens around it. The unit of its plane: the tangent of the angle from the axis.
     */
    COVBEAM_PROJECTION_PERSPECTIVE = 0,
    /**
     * Parallel rays; the unit is that of length.
     */
    COVBEAM_PROJECTION_ORTHOGRAPHIC = 1,
    /**
     * All around a point: longitude and latitude [rad].
     */
    COVBEAM_PROJECTION_EQUIRECTANGULAR = 2,
    /**
     * The distance from the middle is the angle from the axis [rad].
     */
    COVBEAM_PROJECTION_FISHEYE = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum covbeam_projection covbeam_projection;
#else
typedef uint32_t covbeam_projection;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Methods, from the catalogue of the reference renderer.
 */
enum covbeam_method
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * covbeam's: guided light paths, straight light by shadow rays, adaptive kernels for the rest, few eye rays and verified filters.
     */
    COVBEAM_METHOD_COVBEAM = 0,
    /**
     * Section 5.3 of the thesis alone: adaptive kernels from a grid of covariances.
     */
    COVBEAM_METHOD_THESIS = 1,
    /**
     * Plain photon beams: kernels of one radius a pass.
     */
    COVBEAM_METHOD_PLAIN = 2,
    /**
     * Light paths connected with the camera, without kernels: an oracle without bias.
     */
    COVBEAM_METHOD_LIGHT_TRACE = 3,
    /**
     * Light scattered once, by shadow rays along eye rays.
     */
    COVBEAM_METHOD_MARCH = 4,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum covbeam_method covbeam_method;
#else
typedef uint32_t covbeam_method;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * How covbeam_session_until has ended.
 */
enum covbeam_end
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * The goal is reached.
     */
    COVBEAM_END_REACHED = 0,
    /**
     * Passes or time were over before the error was small enough.
     */
    COVBEAM_END_NOT_REACHED = 1,
    /**
     * An error was asked for, and no light reaches the picture.
     */
    COVBEAM_END_DARK = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum covbeam_end covbeam_end;
#else
typedef uint32_t covbeam_end;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What of a picture is asked for: three floats a pixel, linear Rec. 709 [W/(m2 sr)], unless it says one.
 */
enum covbeam_layer
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * All light.
     */
    COVBEAM_LAYER_ALL = 0,
    /**
     * Light that nothing has scattered, reflected or bent before what sends it to the camera. It and the next two add up to all light, and need
     * kinds_apart.
     */
    COVBEAM_LAYER_STRAIGHT = 1,
    /**
     * Light that has met mirrors and glass alone: caustics.
     */
    COVBEAM_LAYER_FOCUSED = 2,
    /**
     * Light that was scattered before.
     */
    COVBEAM_LAYER_SCATTERED = 3,
    /**
     * What fog scatters before the first surface; needs first_apart.
     */
    COVBEAM_LAYER_FIRST = 4,
    /**
     * Standard error of the luminance of all light, one float; 0 after a single pass.
     */
    COVBEAM_LAYER_ERROR = 5,
    /**
     * Mean kernel radius [m], weighted by light, one float; 0 where nothing was gathered.
     */
    COVBEAM_LAYER_RADIUS = 6,
    /**
     * Mean bandwidth of the fluence across the kernel [cycles/m], the same.
     */
    COVBEAM_LAYER_BANDWIDTH = 7,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum covbeam_layer covbeam_layer;
#else
typedef uint32_t covbeam_layer;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Meshes and where they are placed: first added, then built, then in any number of scenes.
 */
typedef struct covbeam_geometry covbeam_geometry;

/**
 * What is rendered: a description and a geometry. It does not change, and any number of sessions may use it.
 */
typedef struct covbeam_scene covbeam_scene;

/**
 * A render of a scene, pass by pass, on native threads of its own. One call renders at a time; meanwhile other threads may ask for
 * covbeam_session_get_info and for layers of a picture that has been made, and for all else they are told COVBEAM_BUSY.
 */
typedef struct covbeam_session covbeam_session;

/**
 * A mesh.
 */
typedef struct covbeam_mesh {
    /**
     * sizeof(covbeam_mesh).
     */
    uint32_t struct_size;
    /**
     * How many materials: one, or one a triangle.
     */
    uint32_t material_count;
    /**
     * Numbers of materials of a description.
     */
    const int32_t *materials;
    /**
     * How many vertices.
     */
    size_t position_count;
    /**
     * In the mesh's own space, three floats each, finite, up to 1e9.
     */
    const float *positions;
    /**
     * How many triangles.
     */
    size_t triangle_count;
    /**
     * Three numbers of vertices each, counter-clockwise seen from the front.
     */
    const int32_t *triangles;
    /**
     * Unit normals of the three corners of each triangle, nine floats; NULL = shaded flat.
     */
    const float *normals;
} covbeam_mesh;

/**
 * A mesh in one place.
 */
typedef struct covbeam_instance {
    /**
     * By rows, affine, from the mesh's space to the world [m]. One that flattens is refused.
     */
    double matrix[16];
    /**
     * Number of the mesh: they count from 0, in the order in which they were added.
     */
    uint32_t mesh;
    /**
     * Number of its object in a description.
     */
    int32_t object;
    /**
     * Number of the material of all of it; -1: those of its triangles.
     */
    int32_t material;
} covbeam_instance;

/**
 * What has been built.
 */
typedef struct covbeam_geometry_info {
    /**
     * Triangles of all meshes, each counted once however many instances it has.
     */
    uint64_t triangle_count;
    /**
     * Memory held [bytes].
     */
    uint64_t memory;
    /**
     * Lower corner of a box around all instances [m]; 0 without any.
     */
    float min[3];
    /**
     * Upper corner.
     */
    float max[3];
} covbeam_geometry_info;

/**
 * Where a ray meets a surface.
 */
typedef struct covbeam_surface_hit {
    /**
     * Along the unit direction [m]; infinity: nothing is hit, then all else is 0 but material and object, which are -1.
     */
    float distance;
    /**
     * The point, moved onto the surface [m].
     */
    float position[3];
    /**
     * Unit, of the triangle: counter-clockwise from its front.
     */
    float geometric_normal[3];
    /**
     * Unit shading normal, on the same side.
     */
    float normal[3];
    /**
     * Given with the instance, or if that is -1 with the triangle.
     */
    int32_t material;
    /**
     * Given with the instance.
     */
    int32_t object;
} covbeam_surface_hit;

/**
 * How a surface treats light: weights per channel, 0 to 1, of the lobes that it is the sum of; what they leave is absorbed. All 0: black.
 */
typedef struct covbeam_material {
    /**
     * Of Lambert reflection.
     */
    float diffuse[3];
    /**
     * Of Lambert transmission: paper, leaves.
     */
    float translucent[3];
    /**
     * Reflectance of a metal at normal incidence.
     */
    float metal[3];
    /**
     * And at grazing incidence; Schlick's curve lies between them.
     */
    float edge[3];
    /**
     * Factor on what Fresnel's equations reflect at a boundary of glass or water.
     */
    float glass_reflection[3];
    /**
     * And on what they refract. With either of the two the object is a dielectric, and may hold a volume.
     */
    float glass_transmission[3];
    /**
     * Factor on what a clear coat over the diffuse part reflects; the diffuse part gets what is left of it.
     */
    float coat[3];
    /**
     * Of light that goes straight on, as if nothing were there.
     */
    float transparent[3];
    /**
     * Index of refraction of glass and coat, over that of the side that the normal points to, 1e-3 to 1e3; 0 = 1.5. Glass of index 1 bounds a
     * volume and bends nothing.
     */
    float ior;
    /**
     * GGX's alpha of metal, glass and coat, 0 to 1; below 1e-3 they are perfectly smooth.
     */
    float alpha;
    /**
     * A value of covbeam_asks.
     */
    uint32_t asks;
    /**
     * Not 0: of light on its way from a lamp another share goes straight on, which is the next.
     */
    uint32_t has_shadow;
    /**
     * Of that light; the other lobes lose nothing for it, but glass does not act on light that it lets by more freely than `transparent` says.
     */
    float shadow[3];
} covbeam_material;

/**
 * What instances of one object have in common.
 */
typedef struct covbeam_object {
    /**
     * Number of the volume that fills it, or -1: what is around it goes on inside. Glass that no fog goes on in wants a volume without coefficients.
     */
    int32_t volume;
    /**
     * Not 0: it has an inside. Fog inside of what is of glass is kept apart from that outside.
     */
    uint32_t is_closed;
    /**
     * Sum of values of covbeam_rays that do not see it: to them it is not there.
     */
    uint32_t hidden_from;
    /**
     * Which set it is in, below 64, for lamps that light some only.
     */
    uint32_t light_set;
    /**
     * And for those of which some only cast shadows.
     */
    uint32_t shadow_set;
} covbeam_object;

/**
 * A shape, exact where a mesh would have corners. Of closed ones of glass that overlap, that of higher priority counts; of equal priority what
 * lies inside of another one counts before that, else the later one.
 */
typedef struct covbeam_shape {
    /**
     * A value of covbeam_shape_kind.
     */
    uint32_t kind;
    /**
     * Number of its material.
     */
    uint32_t material;
    /**
     * Number of the volume that fills it, or -1; one without voxels, in what is of glass.
     */
    int32_t volume;
    /**
     * From -1000 to 1000.
     */
    int32_t priority;
    /**
     * Centre, or lower corner, or corner [m].
     */
    float a[3];
    /**
     * Upper corner, or first edge [m].
     */
    float b[3];
    /**
     * Second edge [m].
     */
    float c[3];
    /**
     * Of a sphere [m] > 0.
     */
    float radius;
} covbeam_shape;

/**
 * A phase function of a mixture.
 */
typedef struct covbeam_phase_lobe {
    /**
     * A value of covbeam_phase_kind.
     */
    uint32_t phase;
    /**
     * Not read.
     */
    uint32_t unused;
    /**
     * Mean cosine of Henyey-Greenstein, in (-1, 1).
     */
    double asymmetry;
    /**
     * How much of what is scattered it spreads, per channel, 0 to 1; all of a volume sum to no more than 1.
     */
    double share[3];
} covbeam_phase_lobe;

/**
 * A medium and where it is.
 */
typedef struct covbeam_volume {
    /**
     * Scattering coefficient where the relative density is 1 [1/m], 0 to 1e9.
     */
    double scattering[3];
    /**
     * Absorption coefficient [1/m].
     */
    double absorption[3];
    /**
     * A value of covbeam_phase_kind.
     */
    uint32_t phase;
    /**
     * How many volumes this is the sum of; 0: it is none.
     */
    uint32_t part_count;
    /**
     * Mean cosine of Henyey-Greenstein, in (-1, 1).
     */
    double asymmetry;
    /**
     * Lower corner of what it fills [m]; of the world's, of what fills shapes, and of sums it is not read.
     */
    double min[3];
    /**
     * Upper corner.
     */
    double max[3];
    /**
     * Lower corner of the voxels of the density [m].
     */
    double density_min[3];
    /**
     * Upper corner.
     */
    double density_max[3];
    /**
     * Lower corner of the voxels of what it sends out [m].
     */
    double glow_min[3];
    /**
     * Upper corner.
     */
    double glow_max[3];
    /**
     * Voxels of the density along x, y and z.
     */
    uint32_t density_cells[3];
    /**
     * Voxels of what it sends out.
     */
    uint32_t glow_cells[3];
    /**
     * Relative density at the middles of voxels, x first, then y, then z; NULL = 1 everywhere.
     */
    const float *density;
    /**
     * Emission coefficient in the same order, three floats each [W/(m3 sr)]; NULL = it is dark.
     */
    const float *glow;
    /**
     * The numbers of the volumes of which this is the sum, where all of them and no others are.
     */
    const int32_t *parts;
    /**
     * Of the world's volume: height in which its density falls to 1/e [m]; 0: it does not, and the next two are not read.
     */
    double scale_height;
    /**
     * Where it is 1 [m].
     */
    double origin[3];
    /**
     * Where it falls to, unit.
     */
    double up[3];
    /**
     * Sum of values of covbeam_rays that do not see it: of the camera, and to lamps, whose straight light is not dimmed in it then, and scattered all
     * the same. What has no end dims all light.
     */
    uint32_t hidden_from;
    /**
     * Which set it is in, below 64, for lamps that light some only.
     */
    uint32_t light_set;
    /**
     * And for those of which some only cast shadows: of others' straight light it takes from what it scatters as much as if it reached to the lamp, and
     * nothing from all else.
     */
    uint32_t shadow_set;
    /**
     * How many phase functions there are beside its own, of which it is a mixture.
     */
    uint32_t lobe_count;
    /**
     * These.
     */
    const struct covbeam_phase_lobe *lobes;
} covbeam_volume;

/**
 * A light. Fields that its kind does not name are not read.
 */
typedef struct covbeam_light {
    /**
     * A value of covbeam_light_kind.
     */
    uint32_t kind;
    /**
     * Not 0: the camera sees it, and mirrors and glass show it, if it has a surface, or is a sky or a sun with an angle.
     */
    uint32_t is_visible;
    /**
     * Not 0: all points see a disk of the lamp's radius that faces them, and no ball.
     */
    uint32_t is_soft;
    /**
     * Not 0: an area is the ellipse in its edges.
     */
    uint32_t is_round;
    /**
     * [m]
     */
    double position[3];
    /**
     * Direction in which a spot shines, or a sun's light travels; unit.
     */
    double axis[3];
    /**
     * First whole edge of an area [m].
     */
    double u[3];
    /**
     * Second one.
     */
    double v[3];
    /**
     * Of points and spots [W/sr].
     */
    double intensity[3];
    /**
     * Of areas and meshes [W/(m2 sr)].
     */
    double radiance[3];
    /**
     * Of suns, across their axis [W/m2].
     */
    double irradiance[3];
    /**
     * Of a pattern, by rows: to the right of the lamp, up, along its axis. Of a sky: the rotation into its picture.
     */
    double axes[3][3];
    /**
     * Of points and spots [m]; 0 = a point.
     */
    double radius;
    /**
     * Of the half angle of a spot's cone.
     */
    double cosine;
    /**
     * How far the cosine rises inside of that until the light is full.
     */
    double blend;
    /**
     * Half angle of an area's honeycomb [rad]; 0 = it has none.
     */
    double spread;
    /**
     * Half angle that a sun is seen under [rad].
     */
    double angle;
    /**
     * Angle from the axis that a pattern's rows end at [rad].
     */
    double reach;
    /**
     * Rows of a pattern or a sky. Of a pattern from the axis outwards; of a sky from +Z of its picture down to -Z.
     */
    uint32_t rows;
    /**
     * Columns: azimuth. Of a sky from pi, by way of +X in the middle, down to -pi.
     */
    uint32_t columns;
    /**
     * Triangles of a mesh.
     */
    size_t triangle_count;
    /**
     * Their corners, nine floats each [m].
     */
    const float *triangles;
    /**
     * Cells of a pattern or a sky, row by row, three floats each; NULL = a lamp without a pattern.
     */
    const float *cells;
    /**
     * Not 0: a host (covbeam_host) says what it sends. What is described is an estimate then, by which the library chooses among lamps and which
     * is what the camera sees of it; it shines wherever the host's lamp does.
     */
    uint32_t is_own;
    /**
     * Sum of values of covbeam_rays that do not see it: it does not fall on what they leave. Of the camera's and those to lamps none is read.
     */
    uint32_t hidden_from;
    /**
     * Sets of objects and volumes that it does not fall on straight, a bit each.
     */
    uint64_t unlit;
    /**
     * Sets of objects that cast no shadow of it: it passes them as if they were not there, and falls on them all the same.
     */
    uint64_t unshadowed;
    /**
     * Its straight light is times d^a d^2/(s + d^2) at a distance d; this is a, 0 to 4: 1 makes light of a point fall with the distance, 2 lets it
     * be as strong everywhere. Of suns and skies it is not read.
     */
    double falloff;
    /**
     * That is s [m2].
     */
    double smooth;
    /**
     * Largest number of events of its light on the way to the camera, plus 1, where settings.limits hold: 1 lights what it shines on straight, and no
     * caustics of it are let off; 0: as many as these say.
     */
    uint32_t most_events;
    /**
     * Not read.
     */
    uint32_t unused;
} covbeam_light;

/**
 * A camera, and the part of its picture that is rendered.
 */
typedef struct covbeam_camera {
    /**
     * The pinhole, the middle of the lens, or of the plane that parallel rays start from [m].
     */
    double position[3];
    /**
     * Viewing direction, any length but 0.
     */
    double forward[3];
    /**
     * Any direction but the viewing one; the picture's upper edge is towards it. Its right is forward x up.
     */
    double up[3];
    /**
     * Half of the picture's height around the middle of the view, in the projection's unit: tan(vertical field of view / 2) in perspective.
     * 0: the part is given by the next three.
     */
    double half_height;
    /**
     * Place of the upper left corner in the picture's plane, to the right.
     */
    double left;
    /**
     * And up.
     */
    double top;
    /**
     * A pixel's width and height in it.
     */
    double step[2];
    /**
     * Of a fisheye, the largest angle that it shows [rad], up to pi.
     */
    double widest;
    /**
     * What is nearer is not there [m].
     */
    double near;
    /**
     * Radius of the lens' opening [m]; 0 = a pinhole, and the next four are not read.
     */
    double aperture;
    /**
     * Distance of what is sharp [m].
     */
    double focus;
    /**
     * Angle of the middle of an edge of the opening [rad].
     */
    double rotation;
    /**
     * Height over width of the opening.
     */
    double ratio;
    /**
     * Corners of the opening; 0 = a disk.
     */
    uint32_t blades;
    /**
     * A value of covbeam_projection.
     */
    uint32_t projection;
    /**
     * Pixels across, 1 to 16384.
     */
    uint32_t width;
    /**
     * Pixels down.
     */
    uint32_t height;
    /**
     * Not 0: a host (covbeam_host) says where its rays go. What is described is an estimate then, by which the library plans.
     */
    uint32_t is_own;
    /**
     * Not read.
     */
    uint32_t unused;
} covbeam_camera;

/**
 * All that a scene is made of but its placed meshes.
 */
typedef struct covbeam_description {
    /**
     * sizeof(covbeam_description).
     */
    uint32_t struct_size;
    /**
     * Number of the volume outside of all objects and shapes, or -1.
     */
    int32_t world_volume;
    /**
     * Not 0: pictures show the light that fog scatters into the camera and nothing else: surfaces are black, and hide or mirror the fog that is
     * behind them.
     */
    uint32_t fog_alone;
    /**
     * How many materials.
     */
    uint32_t material_count;
    /**
     * What materials of meshes, instances and shapes are numbers of.
     */
    const struct covbeam_material *materials;
    /**
     * How many objects.
     */
    size_t object_count;
    /**
     * What objects of instances are numbers of.
     */
    const struct covbeam_object *objects;
    /**
     * How many shapes.
     */
    size_t shape_count;
    /**
     * Spheres, boxes and rectangles.
     */
    const struct covbeam_shape *shapes;
    /**
     * How many volumes; of those that fill objects up to 64.
     */
    size_t volume_count;
    /**
     * Media and where they are.
     */
    const struct covbeam_volume *volumes;
    /**
     * How many lights.
     */
    size_t light_count;
    /**
     * Lights.
     */
    const struct covbeam_light *lights;
    /**
     * The camera.
     */
    struct covbeam_camera camera;
} covbeam_description;

/**
 * A ray.
 */
typedef struct covbeam_host_ray {
    /**
     * Where it starts [m].
     */
    double origin[3];
    /**
     * Unit.
     */
    double direction[3];
    /**
     * What is farther away does not count [m]; infinity: everything does.
     */
    double reach;
} covbeam_host_ray;

/**
 * Where a ray meets a surface of the host. All numbers are checked: a hit that is none counts as nothing hit.
 */
typedef struct covbeam_host_hit {
    /**
     * In (0, reach); 0: nothing is hit, and the rest is not read.
     */
    float distance;
    /**
     * The point, moved onto the surface [m].
     */
    float position[3];
    /**
     * Unit, outward on closed surfaces, not turned towards the ray.
     */
    float geometric_normal[3];
    /**
     * Unit shading normal, on the same side.
     */
    float normal[3];
    /**
     * More than rounding can have moved the point [m], such as 4 ulps of the largest coordinate.
     */
    float offset;
    /**
     * Direction in the surface of the curvature below, unit; not read where that is 0.
     */
    float tangent[3];
    /**
     * Curvature of the shading normals along the tangent [1/m], positive = convex towards the normal; 0: light sees it as flat, and caustics of it
     * are blurred.
     */
    float along;
    /**
     * And across it.
     */
    float across;
    /**
     * And the twist.
     */
    float twist;
    /**
     * Number of the object in the description.
     */
    uint32_t object;
    /**
     * Number of the material in the description.
     */
    uint32_t material;
    /**
     * Whatever the host wants to find the place by when it is asked about it: a triangle and where in it.
     */
    uint32_t mark[3];
} covbeam_host_hit;

/**
 * Finds the nearest surfaces that rays meet, from either side, and fills a hit for each. Called from many threads at once; the same rays
 * must get the same hits. `count` is 1 today.
 */
typedef void (*covbeam_host_cast)(void *user,
                                  size_t count,
                                  const struct covbeam_host_ray *rays,
                                  struct covbeam_host_hit *hits);

/**
 * Tells of rays whether they meet anything: not 0 in `blocked`. As covbeam_host_cast.
 */
typedef void (*covbeam_host_blocked)(void *user,
                                     size_t count,
                                     const struct covbeam_host_ray *rays,
                                     uint8_t *blocked);

/**
 * Says what surfaces are at hits: `lobes` holds their materials as described, to be changed. As covbeam_host_cast.
 */
typedef void (*covbeam_host_lobes)(void *user,
                                   size_t count,
                                   const struct covbeam_host_hit *hits,
                                   struct covbeam_material *lobes);

/**
 * Light, or an eye path, that meets a surface.
 */
typedef struct covbeam_host_meeting {
    /**
     * Where, as the host gave it.
     */
    struct covbeam_host_hit hit;
    /**
     * Along which it comes, unit.
     */
    float direction[3];
    /**
     * Uniform in [0, 1): to draw the directions of rough ways with.
     */
    float xi[2];
} covbeam_host_meeting;

/**
 * A way on from a surface that goes one direction, or a rough one of which one direction has been drawn.
 */
typedef struct covbeam_host_way {
    /**
     * What goes on like this of light that arrives, over the probability density of the direction, 0 to 1; 0: nothing does, and the rest is not
     * read.
     */
    float factor[3];
    /**
     * Unit.
     */
    float direction[3];
    /**
     * Standard deviation of its directions [rad]; 0: it is sharp.
     */
    float deviation;
} covbeam_host_way;

/**
 * All ways on from a surface, each a part of the light that arrives; what they leave is absorbed, and what is more than all, together with
 * what the material lets straight through, is scaled down.
 */
typedef struct covbeam_host_ways {
    /**
     * Of Lambert reflection.
     */
    float diffuse[3];
    /**
     * Of Lambert transmission.
     */
    float translucent[3];
    /**
     * Back to the side that it comes from. Of lamps that are points, rough ones show nothing.
     */
    struct covbeam_host_way reflected[3];
    /**
     * Into glass or out of it, by the material's index of refraction.
     */
    struct covbeam_host_way refracted;
} covbeam_host_ways;

/**
 * Draws the ways on from surfaces. As covbeam_host_cast.
 */
typedef void (*covbeam_host_scatter)(void *user,
                                     size_t count,
                                     const struct covbeam_host_meeting *meetings,
                                     struct covbeam_host_ways *ways);

/**
 * A photon that is wanted of a lamp.
 */
typedef struct covbeam_host_draw {
    /**
     * Number of the light in the description.
     */
    uint32_t light;
    /**
     * In the unit square: says where it goes. Neighbouring places should go neighbouring ways, for the library learns which it needs.
     */
    float place[2];
    /**
     * Uniform in [0, 1): from which point of a lamp that has a size.
     */
    float xi[2];
} covbeam_host_draw;

/**
 * A photon of a lamp.
 */
typedef struct covbeam_host_photon {
    /**
     * Where it starts [m].
     */
    float origin[3];
    /**
     * Unit.
     */
    float direction[3];
    /**
     * Flux of the lamp if all of its light left like this photon [W]: emission over the probability density of the place's photon. Its mean over
     * the unit square is the lamp's flux; no more than 1e4 times what is described as that is taken. 0: none.
     */
    float power[3];
    /**
     * Normal of the surface that it leaves; 0 of a lamp without one.
     */
    float normal[3];
    /**
     * Radius of a disk that looks as large as the lamp from along its way [m]; 0: a point.
     */
    float radius;
    /**
     * How the lamp's light varies with direction [cycles2/rad2]: 1/(4 pi2 w2) where it falls off within an angle of w; 0: it is even.
     */
    float angular_variance;
} covbeam_host_photon;

/**
 * Draws photons of lamps. As covbeam_host_cast.
 */
typedef void (*covbeam_host_emit)(void *user,
                                  size_t count,
                                  const struct covbeam_host_draw *draws,
                                  struct covbeam_host_photon *photons);

/**
 * What a shadow ray asks of a lamp.
 */
typedef struct covbeam_host_question {
    /**
     * Number of the light in the description.
     */
    uint32_t light;
    /**
     * Where light is to arrive [m].
     */
    float place[3];
    /**
     * Uniform in [0, 1): the point that stands for all of a lamp that has a size; (0, 0): the middle of it, about.
     */
    float xi[2];
} covbeam_host_question;

/**
 * What it is told, if nothing is in the way: the library finds that out.
 */
typedef struct covbeam_host_arrival {
    /**
     * What arrives on a small ball, over its cross section [W/m2].
     */
    float density[3];
    /**
     * From where [m].
     */
    float from[3];
} covbeam_host_arrival;

/**
 * Says what arrives straight from lamps. As covbeam_host_cast.
 */
typedef void (*covbeam_host_illuminate)(void *user,
                                        size_t count,
                                        const struct covbeam_host_question *questions,
                                        struct covbeam_host_arrival *arrivals);

/**
 * A ray that is wanted of the camera.
 */
typedef struct covbeam_host_pixel {
    /**
     * Place in the picture, from its upper left corner [pixels].
     */
    float place[2];
    /**
     * Uniform in [0, 1): where in the lens, by even parts of it; (0, 0): in its middle.
     */
    float lens[2];
} covbeam_host_pixel;

/**
 * A ray of the camera.
 */
typedef struct covbeam_host_eye_ray {
    /**
     * Where it starts [m].
     */
    float origin[3];
    /**
     * Unit; 0: there is none, and the place is dark.
     */
    float direction[3];
} covbeam_host_eye_ray;

/**
 * Says where rays of the camera go. As covbeam_host_cast.
 */
typedef void (*covbeam_host_eye)(void *user,
                                 size_t count,
                                 const struct covbeam_host_pixel *pixels,
                                 struct covbeam_host_eye_ray *rays);

/**
 * A host's geometry, and functions for what its description says is its own. It must outlive the scenes and sessions that are made of it: what was
 * stopped may ask it for a moment longer, until its session is freed.
 */
typedef struct covbeam_host {
    /**
     * sizeof(covbeam_host).
     */
    uint32_t struct_size;
    /**
     * Another number for another geometry, or other functions: sums of sessions are told apart by it.
     */
    uint32_t version;
    /**
     * What the functions are called with.
     */
    void *user;
    /**
     * The nearest surface of rays.
     */
    covbeam_host_cast cast;
    /**
     * Whether rays meet anything; NULL: `cast` is asked.
     */
    covbeam_host_blocked blocked;
    /**
     * What surfaces are at hits: textures, masks; for materials that ask for lobes or ways.
     */
    covbeam_host_lobes lobes;
    /**
     * Where surfaces send light; for materials that ask for ways.
     */
    covbeam_host_scatter scatter;
    /**
     * Photons; for lights that are the host's own.
     */
    covbeam_host_emit emit;
    /**
     * And what they send straight to a place.
     */
    covbeam_host_illuminate illuminate;
    /**
     * Eye rays; for a camera that is the host's own.
     */
    covbeam_host_eye eye;
    /**
     * Lower corner of a box around all surfaces [m].
     */
    float min[3];
    /**
     * Upper corner.
     */
    float max[3];
} covbeam_host;

/**
 * Starts a thread of the host's that calls `body(argument)` once, which returns when the session is freed, and returns 0 at once; or anything
 * else, without having started one: the session is refused then.
 */
typedef int32_t (*covbeam_spawn)(void *user, void (*body)(void *argument), void *argument);

/**
 * Limits of scatterings and reflections by kind, as path tracers have them: they count from the camera, every event on the way but the last one
 * before the lamp. With limited 0 there are none, and the other fields count for nothing.
 */
typedef struct covbeam_bounce_limits {
    /**
     * Not 0: the other fields hold, 0 included.
     */
    uint32_t limited;
    /**
     * Of all kinds together.
     */
    uint32_t total;
    /**
     * Diffuse reflections.
     */
    uint32_t diffuse;
    /**
     * Other reflections.
     */
    uint32_t glossy;
    /**
     * Transmissions, but for what goes straight on.
     */
    uint32_t transmission;
    /**
     * Scatterings by media, the one that sends light to the camera included: with 0 media scatter what comes straight from the lamps alone.
     */
    uint32_t volume;
    /**
     * Not 0: sharp reflections on the way from a lamp count as glossy alone, from the second one on, as if the lamp were there: caustics of
     * mirrors, of which path tracers find little, are there whatever the other limits say.
     */
    uint32_t free_reflections;
    /**
     * The same of sharp transmissions: caustics of glass and water.
     */
    uint32_t free_transmissions;
} covbeam_bounce_limits;

/**
 * How a session renders. With all fields but struct_size 0: covbeam's method, with what the scene asks for.
 */
typedef struct covbeam_session_settings {
    /**
     * sizeof(covbeam_session_settings).
     */
    uint32_t struct_size;
    /**
     * A value of covbeam_method.
     */
    uint32_t method;
    /**
     * Another seed gives another noise, the same seed the same bits.
     */
    uint32_t seed;
    /**
     * Light paths a pass, up to 2^28; 0: as many as the scene asks for. Guided ones that leave few beams are up to 8 times as many.
     */
    uint32_t photons;
    /**
     * Voxels along the longest side of the covariance grid, up to 256; 0: the scene's own.
     */
    uint32_t grid;
    /**
     * Largest number of scatterings and reflections of light on its way, that which sends it to the camera included; 0: any.
     */
    uint32_t most_events;
    /**
     * Number of the first pass, from 0: other machines render others, and covbeam_session_merge adds them.
     */
    uint32_t first_pass;
    /**
     * Threads, up to 1024; 0: one a core. Results do not depend on it.
     */
    uint32_t threads;
    /**
     * Not 0: kinds of light are kept apart, for COVBEAM_LAYER_STRAIGHT and its kin.
     */
    uint32_t kinds_apart;
    /**
     * Not 0: the fog before the first surface is kept apart, for COVBEAM_LAYER_FIRST.
     */
    uint32_t first_apart;
    /**
     * Not 0: there is nothing from the first surface on.
     */
    uint32_t first_alone;
    /**
     * Not 0: each pass has an eye ray through every pixel.
     */
    uint32_t every_pixel;
    /**
     * Of the beams' kernels in the first pass [m]; 0: the scene's own.
     */
    double radius;
    /**
     * Relative bias that kernels and filters of the first pass may cause, 1e-6 to 1; 0: 0.01. It falls with the passes.
     */
    double error;
    /**
     * Starts its threads, once for each; NULL: they are the library's own.
     */
    covbeam_spawn spawn;
    /**
     * What it is called with.
     */
    void *spawn_user;
    /**
     * Limits of events by kind, beside most_events.
     */
    struct covbeam_bounce_limits limits;
} covbeam_session_settings;

/**
 * When a render is finished: as soon as one of these is reached. One pass is always made.
 */
typedef struct covbeam_goal {
    /**
     * sizeof(covbeam_goal).
     */
    uint32_t struct_size;
    /**
     * After so many passes in all; 0: however many.
     */
    uint32_t passes;
    /**
     * So long after the call [s]: a pass that would end later is cut; 0: however long.
     */
    double seconds;
    /**
     * When the median over the lit pixels of standard error over luminance is below this; 0: however large.
     */
    double error;
} covbeam_goal;

/**
 * Where a session stands.
 */
typedef struct covbeam_session_info {
    /**
     * Seconds that passes have taken, by part, shared out by what the parts took of all threads: light paths; the light fields that some of them
     * carry; the grid; hierarchies of beams; where eye rays and light paths are needed, the getting ready too; eye rays and the beams around them.
     */
    double seconds[6];
    /**
     * And pictures.
     */
    double picture_seconds;
    /**
     * Accepted pairs of beam and eye ray, of all passes.
     */
    uint64_t pairs;
    /**
     * What light and picture are expected to take at most [bytes].
     */
    uint64_t memory;
    /**
     * Passes that it holds.
     */
    uint32_t passes;
    /**
     * Light paths of a pass.
     */
    uint32_t photons;
    /**
     * Those that the settings ask for.
     */
    uint32_t most_photons;
    /**
     * Pixels across.
     */
    uint32_t width;
    /**
     * Pixels down.
     */
    uint32_t height;
    /**
     * What the scene asks for: box and cells of the covariance grid. Hosts of the kernels alone may take these numbers, too.
     */
    covbeam_grid_layout grid;
    /**
     * Of the kernels in the first pass [m].
     */
    float radius;
    /**
     * Largest radius [m].
     */
    float max_radius;
    /**
     * Light paths of a pass, of those that go where their power goes.
     */
    uint32_t plain_photons;
    /**
     * And of those that go where the picture needs them.
     */
    uint32_t guided_photons;
} covbeam_session_info;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * Makes an empty geometry.
 *
 * @param out the handle.
 */
covbeam_status covbeam_geometry_new(struct covbeam_geometry **out);

/**
 * Frees a geometry; scenes of it go on.
 *
 * @param geometry NULL is fine.
 */
covbeam_status covbeam_geometry_free(struct covbeam_geometry *geometry);

/**
 * Copies a mesh. Triangles of no area are left out.
 *
 * @param geometry one that has not been built.
 * @param mesh the arrays.
 * @param dropped receives the number of triangles that were left out; NULL is fine.
 */
covbeam_status covbeam_geometry_add_mesh(struct covbeam_geometry *geometry,
                                         const struct covbeam_mesh *mesh,
                                         size_t *dropped);

/**
 * Places meshes. If one is refused, those before it are placed.
 *
 * @param geometry one that has not been built.
 * @param count number of instances.
 * @param instances, instance_stride the instances.
 */
covbeam_status covbeam_geometry_add_instances(struct covbeam_geometry *geometry,
                                              size_t count,
                                              const struct covbeam_instance *instances,
                                              size_t instance_stride);

/**
 * Builds the hierarchies, on native threads: once, after all meshes and instances.
 *
 * @param geometry one that has not been built.
 * @param poll, user asked at least every 50 ms whether to go on; NULL: it always goes on. Where it is to stop, the geometry can
 *     only be freed.
 */
covbeam_status covbeam_geometry_build(struct covbeam_geometry *geometry,
                                      covbeam_poll poll,
                                      void *user);

/**
 * What has been built.
 *
 * @param geometry one that has been built.
 * @param info receives it.
 */
covbeam_status covbeam_geometry_get_info(const struct covbeam_geometry *geometry,
                                         struct covbeam_geometry_info *info);

/**
 * The nearest hits of rays, to look at what was built.
 *
 * @param geometry one that has been built.
 * @param count number of rays.
 * @param origins, origin_stride where they start, three floats each [m].
 * @param directions, direction_stride unit, three floats each.
 * @param hits, hit_stride receive what is hit.
 */
covbeam_status covbeam_geometry_cast(const struct covbeam_geometry *geometry,
                                     size_t count,
                                     const float *origins,
                                     size_t origin_stride,
                                     const float *directions,
                                     size_t direction_stride,
                                     struct covbeam_surface_hit *hits,
                                     size_t hit_stride);

/**
 * Makes a scene.
 *
 * @param geometry one that has been built; NULL: there are shapes only.
 * @param description all else, copied.
 * @param out the handle.
 */
covbeam_status covbeam_scene_new(const struct covbeam_geometry *geometry,
                                 const struct covbeam_description *description,
                                 struct covbeam_scene **out);

/**
 * Frees a scene; sessions of it go on.
 *
 * @param scene NULL is fine.
 */
covbeam_status covbeam_scene_free(struct covbeam_scene *scene);

/**
 * Makes a scene of a host's geometry.
 *
 * @param host the geometry; objects and materials of its hits are numbers of the description's.
 * @param description all else, copied.
 * @param out the handle.
 */
covbeam_status covbeam_scene_new_of_host(const struct covbeam_host *host,
                                         const struct covbeam_description *description,
                                         struct covbeam_scene **out);

/**
 * Makes a session of a scene, or of the same one at several instants while a shutter is open. Numbers that nobody has given are chosen, which
 * takes up to a second or two.
 *
 * @param count number of scenes: a power of two, up to 1024. Of n of them each is in two of 2 n passes; what moves is blurred.
 * @param scenes, scene_stride handles; they may be freed afterwards. The stride of one scene may be 0.
 * @param settings how to render.
 * @param poll, user asked at least every 50 ms, in this thread, whether to go on; NULL: it always goes on.
 * @param out the handle.
 * @note COVBEAM_OUT_OF_MEMORY if the picture is expected to need more memory than there is. What is allocated later is not checked
 *     again: a system that refuses it ends the process, as it does with any Rust program.
 */
covbeam_status covbeam_session_new(size_t count,
                                   const struct covbeam_scene *const *scenes,
                                   size_t scene_stride,
                                   const struct covbeam_session_settings *settings,
                                   covbeam_poll poll,
                                   void *user,
                                   struct covbeam_session **out);

/**
 * Frees a session. If its scene is a host's, none of the host's functions is called any more when this returns (unless one of them calls it).
 *
 * @param session NULL is fine.
 */
covbeam_status covbeam_session_free(struct covbeam_session *session);

/**
 * Renders the next pass. A pass is a function of scenes, settings and its number: the same bits for any number of threads.
 *
 * @param session the session.
 * @param poll, user asked at least every 50 ms whether to go on. Where it is to stop the pass is lost, and those before are kept.
 * @note The first one takes up to a second more: a pilot finds out where light paths are needed.
 */
covbeam_status covbeam_session_pass(const struct covbeam_session *session,
                                    covbeam_poll poll,
                                    void *user);

/**
 * Renders passes until a goal is reached.
 *
 * @param session the session.
 * @param goal when it is.
 * @param poll, user as in covbeam_session_pass; the passes done are kept.
 * @param end receives a value of covbeam_end; NULL is fine.
 */
covbeam_status covbeam_session_until(const struct covbeam_session *session,
                                     const struct covbeam_goal *goal,
                                     covbeam_poll poll,
                                     void *user,
                                     uint32_t *end);

/**
 * Forgets all passes.
 *
 * @param session the session.
 * @param photons light paths of the passes to come, at least one and at most those of the settings.
 * @param plain not 0: light paths do without a pilot that learns where they are needed: far noisier, and there at once.
 */
covbeam_status covbeam_session_restart(const struct covbeam_session *session,
                                       uint32_t photons,
                                       uint32_t plain);

/**
 * Where a session stands: may be asked while another call renders.
 *
 * @param session the session.
 * @param info receives it.
 */
covbeam_status covbeam_session_get_info(const struct covbeam_session *session,
                                        struct covbeam_session_info *info);

/**
 * A layer of the picture of the passes done, at least one. The picture is made with the first layer, and kept until there is another pass.
 *
 * @param session the session.
 * @param layer a value of covbeam_layer.
 * @param count pixels: width x height, rows from the top.
 * @param out, out_stride receive three floats each, or one; a stride of 0: side by side.
 * @param poll, user asked at least every 50 ms whether to go on.
 */
covbeam_status covbeam_session_picture(const struct covbeam_session *session,
                                       uint32_t layer,
                                       size_t count,
                                       float *out,
                                       size_t out_stride,
                                       covbeam_poll poll,
                                       void *user);

/**
 * The exact sums of the passes that a session holds, as bytes: the same on every machine, and for the same passes, in whatever order they came.
 *
 * @param session one that holds a pass.
 * @param bytes memory for them; NULL: none, and only the size is said.
 * @param size bytes there.
 * @param needed receives how many there are.
 * @note COVBEAM_SHORT_BUFFER if there are more than `size`; `needed` is written then, too.
 */
covbeam_status covbeam_session_save(const struct covbeam_session *session,
                                    void *bytes,
                                    size_t size,
                                    size_t *needed);

/**
 * Adds sums of other passes of the same picture, which covbeam_session_save gave here or elsewhere. Pictures have the same bits as if all of
 * them had been rendered here, and the next passes are those that are missing.
 *
 * @param session the session.
 * @param bytes, size the sums. COVBEAM_BAD_DATA if they are none, damaged, of another scene or other settings, or of passes that are there.
 * @param poll, user asked at least every 50 ms whether to go on.
 */
covbeam_status covbeam_session_merge(const struct covbeam_session *session,
                                     const void *bytes,
                                     size_t size,
                                     covbeam_poll poll,
                                     void *user);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* COVBEAM_SESSION_H */
