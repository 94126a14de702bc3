/* The fields of the structs of covbeam_session.h, and what may be done to each. */
#ifndef HOSTILE_SESSION_H
#define HOSTILE_SESSION_H

#include "covbeam_session.h"

/*
 * type: f float, d double, u 32-bit integer, z size_t, p pointer
 * rule: x may be refused; ! must be, where it is no finite number; e an enumeration, w a side of a picture: must be where no such value is
 *   t threads, g voxels, h light paths, l limits of which stand in the header
 *   N a pointer that may not be NULL, 0 one that may, n the number of what a pointer shows: must be refused where no memory has so many;
 *   m the same in 32 bits: fewer than there are
 */
struct field {
    const char *name;
    size_t offset;
    char type, rule;
    int count; /* of an array */
};

#define FIELD(s, name, type, rule, count) { #name, offsetof(s, name), type, rule, count },
#define TABLE(s) static const struct field s##_fields[] =

static const struct field float_fields[] = { { "number", 0, 'f', '!', 1 } };
static const struct field covbeam_scene_fields[] = { { "handle", 0, 'p', 'N', 1 } };
static const struct field int32_t_fields[] = { { "number", 0, 'u', 'x', 1 } };

TABLE(covbeam_mesh) {
    FIELD(covbeam_mesh, material_count, 'u', 'm', 1) FIELD(covbeam_mesh, materials, 'p', 'N', 1)
    FIELD(covbeam_mesh, position_count, 'z', 'n', 1) FIELD(covbeam_mesh, positions, 'p', 'N', 1)
    FIELD(covbeam_mesh, triangle_count, 'z', 'n', 1) FIELD(covbeam_mesh, triangles, 'p', 'N', 1)
    FIELD(covbeam_mesh, normals, 'p', '0', 1)
};

TABLE(covbeam_instance) {
    FIELD(covbeam_instance, matrix, 'd', '!', 16) FIELD(covbeam_instance, mesh, 'u', 'x', 1)
    FIELD(covbeam_instance, object, 'u', 'x', 1) FIELD(covbeam_instance, material, 'u', 'x', 1)
};

TABLE(covbeam_material) {
    FIELD(covbeam_material, diffuse, 'f', '!', 3) FIELD(covbeam_material, translucent, 'f', '!', 3)
    FIELD(covbeam_material, metal, 'f', '!', 3) FIELD(covbeam_material, edge, 'f', '!', 3)
    FIELD(covbeam_material, glass_reflection, 'f', '!', 3) FIELD(covbeam_material, glass_transmission, 'f', '!', 3)
    FIELD(covbeam_material, coat, 'f', '!', 3) FIELD(covbeam_material, transparent, 'f', '!', 3)
    FIELD(covbeam_material, ior, 'f', '!', 1) FIELD(covbeam_material, alpha, 'f', '!', 1) FIELD(covbeam_material, asks, 'u', 'e', 1)
};

TABLE(covbeam_object) { FIELD(covbeam_object, volume, 'u', 'x', 1) FIELD(covbeam_object, is_closed, 'u', 'x', 1) };

TABLE(covbeam_shape) {
    FIELD(covbeam_shape, kind, 'u', 'e', 1) FIELD(covbeam_shape, material, 'u', 'x', 1) FIELD(covbeam_shape, volume, 'u', 'x', 1)
    FIELD(covbeam_shape, priority, 'u', 'x', 1) FIELD(covbeam_shape, a, 'f', '!', 3) FIELD(covbeam_shape, b, 'f', 'x', 3)
    FIELD(covbeam_shape, c, 'f', 'x', 3) FIELD(covbeam_shape, radius, 'f', 'x', 1)
};

TABLE(covbeam_volume) {
    FIELD(covbeam_volume, scattering, 'd', '!', 3) FIELD(covbeam_volume, absorption, 'd', '!', 3)
    FIELD(covbeam_volume, phase, 'u', 'e', 1) FIELD(covbeam_volume, asymmetry, 'd', '!', 1)
    FIELD(covbeam_volume, min, 'd', 'x', 3) FIELD(covbeam_volume, max, 'd', 'x', 3)
    FIELD(covbeam_volume, density_min, 'd', '!', 3) FIELD(covbeam_volume, density_max, 'd', '!', 3)
    FIELD(covbeam_volume, glow_min, 'd', 'x', 3) FIELD(covbeam_volume, glow_max, 'd', 'x', 3)
    FIELD(covbeam_volume, density_cells, 'u', 'm', 3) FIELD(covbeam_volume, density, 'p', '0', 1)
};

TABLE(covbeam_light) {
    FIELD(covbeam_light, kind, 'u', 'e', 1) FIELD(covbeam_light, is_visible, 'u', 'x', 1) FIELD(covbeam_light, is_soft, 'u', 'x', 1)
    FIELD(covbeam_light, is_round, 'u', 'x', 1) FIELD(covbeam_light, position, 'd', 'x', 3) FIELD(covbeam_light, axis, 'd', 'x', 3)
    FIELD(covbeam_light, u, 'd', 'x', 3) FIELD(covbeam_light, v, 'd', 'x', 3) FIELD(covbeam_light, intensity, 'd', 'x', 3)
    FIELD(covbeam_light, radiance, 'd', 'x', 3) FIELD(covbeam_light, irradiance, 'd', 'x', 3) FIELD(covbeam_light, axes, 'd', 'x', 9)
    FIELD(covbeam_light, radius, 'd', 'x', 1) FIELD(covbeam_light, cosine, 'd', 'x', 1) FIELD(covbeam_light, blend, 'd', 'x', 1)
    FIELD(covbeam_light, spread, 'd', 'x', 1) FIELD(covbeam_light, angle, 'd', 'x', 1) FIELD(covbeam_light, reach, 'd', 'x', 1)
    FIELD(covbeam_light, rows, 'u', 'm', 1) FIELD(covbeam_light, columns, 'u', 'm', 1)
    FIELD(covbeam_light, triangle_count, 'z', 'n', 1) FIELD(covbeam_light, triangles, 'p', 'N', 1)
    FIELD(covbeam_light, cells, 'p', '0', 1) FIELD(covbeam_light, is_own, 'u', 'x', 1)
};

/* The camera is a part of it. */
TABLE(covbeam_description) {
    FIELD(covbeam_description, world_volume, 'u', 'x', 1) FIELD(covbeam_description, fog_alone, 'u', 'x', 1)
    FIELD(covbeam_description, material_count, 'u', 'm', 1) FIELD(covbeam_description, materials, 'p', 'N', 1)
    FIELD(covbeam_description, object_count, 'z', 'n', 1) FIELD(covbeam_description, objects, 'p', 'N', 1)
    FIELD(covbeam_description, shape_count, 'z', 'n', 1) FIELD(covbeam_description, shapes, 'p', 'N', 1)
    FIELD(covbeam_description, volume_count, 'z', 'n', 1) FIELD(covbeam_description, volumes, 'p', 'N', 1)
    FIELD(covbeam_description, light_count, 'z', 'n', 1) FIELD(covbeam_description, lights, 'p', 'N', 1)
    FIELD(covbeam_description, camera.position, 'd', '!', 3) FIELD(covbeam_description, camera.forward, 'd', '!', 3)
    FIELD(covbeam_description, camera.up, 'd', '!', 3) FIELD(covbeam_description, camera.half_height, 'd', '!', 1)
    FIELD(covbeam_description, camera.left, 'd', 'x', 1) FIELD(covbeam_description, camera.top, 'd', 'x', 1)
    FIELD(covbeam_description, camera.step, 'd', 'x', 2) FIELD(covbeam_description, camera.widest, 'd', 'x', 1)
    FIELD(covbeam_description, camera.near, 'd', '!', 1) FIELD(covbeam_description, camera.aperture, 'd', '!', 1)
    FIELD(covbeam_description, camera.focus, 'd', 'x', 1) FIELD(covbeam_description, camera.rotation, 'd', 'x', 1)
    FIELD(covbeam_description, camera.ratio, 'd', 'x', 1) FIELD(covbeam_description, camera.blades, 'u', 'x', 1)
    FIELD(covbeam_description, camera.projection, 'u', 'e', 1) FIELD(covbeam_description, camera.width, 'u', 'w', 1)
    FIELD(covbeam_description, camera.height, 'u', 'w', 1) FIELD(covbeam_description, camera.is_own, 'u', 'x', 1)
};

TABLE(covbeam_host) {
    FIELD(covbeam_host, version, 'u', 'x', 1) FIELD(covbeam_host, cast, 'c', 'N', 1) FIELD(covbeam_host, blocked, 'c', '0', 1)
    FIELD(covbeam_host, lobes, 'c', 'N', 1) FIELD(covbeam_host, scatter, 'c', 'N', 1) FIELD(covbeam_host, emit, 'c', 'N', 1)
    FIELD(covbeam_host, illuminate, 'c', 'N', 1) FIELD(covbeam_host, eye, 'c', 'N', 1)
    FIELD(covbeam_host, min, 'f', '!', 3) FIELD(covbeam_host, max, 'f', '!', 3)
};

TABLE(covbeam_session_settings) {
    FIELD(covbeam_session_settings, method, 'u', 'e', 1) FIELD(covbeam_session_settings, seed, 'u', 'x', 1)
    FIELD(covbeam_session_settings, photons, 'u', 'h', 1) FIELD(covbeam_session_settings, grid, 'u', 'g', 1)
    FIELD(covbeam_session_settings, most_events, 'u', 'x', 1) FIELD(covbeam_session_settings, first_pass, 'u', 'x', 1)
    FIELD(covbeam_session_settings, threads, 'u', 't', 1) FIELD(covbeam_session_settings, kinds_apart, 'u', 'x', 1)
    FIELD(covbeam_session_settings, first_apart, 'u', 'x', 1) FIELD(covbeam_session_settings, first_alone, 'u', 'x', 1)
    FIELD(covbeam_session_settings, every_pixel, 'u', 'x', 1) FIELD(covbeam_session_settings, radius, 'd', '!', 1)
    FIELD(covbeam_session_settings, error, 'd', '!', 1)
};

/* Without one of the three there is no goal. */
TABLE(covbeam_goal) { FIELD(covbeam_goal, seconds, 'd', '!', 1) FIELD(covbeam_goal, error, 'd', '!', 1) };

#endif
