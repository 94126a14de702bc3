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

