/*
 * Memory that is not there, for sessions. What a picture needs is estimated before its session begins, and COVBEAM_OUT_OF_MEMORY leaves nothing
 * behind: no thread, and no piece of memory; a smaller picture of the same process goes on. What else of covbeam_session.h says so is tried with each
 * of its requests refused: handles of geometries, and rays that are cast. (Of all other requests the header promises nothing: the process ends.)
 */
#define _POSIX_C_SOURCE 200809L
#include "hosted.h"
#include "scarce.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

enum { RAYS = 100 };

static void check(bool holds, const char *what) {
    if (holds) return;
    fprintf(stderr, "scarce_session: %s (%s)\n", what, covbeam_last_error());
    exit(1);
}

static void ok(int32_t status) { check(status == COVBEAM_OK, covbeam_status_name(status)); }

/* A number of what the system says of this process. */
static unsigned long long of_process(const char *name) {
    char line[256];
    unsigned long long number = 0;
    FILE *file = fopen("/proc/self/status", "r");
    check(file != NULL, "no /proc");
    while (fgets(line, sizeof line, file))
        if (strncmp(line, name, strlen(name)) == 0) number = strtoull(line + strlen(name), NULL, 10);
    fclose(file);
    return number;
}

/* A session of a picture of this size, with so many light paths. */
static int32_t session_of(uint32_t side, uint32_t photons, covbeam_session **out) {
    static struct hosted hosted;
    const covbeam_host host = hosted_host(&hosted, true);
    covbeam_description description = hosted_description();
    covbeam_session_settings settings = hosted_settings(COVBEAM_METHOD_THESIS);
    description.camera.width = description.camera.height = side;
    settings.photons = photons;
    covbeam_scene *scene;
    ok(covbeam_scene_new_of_host(&host, &description, &scene));
    const int32_t status = covbeam_session_new(1, (const covbeam_scene *const *)&scene, 0, &settings, NULL, NULL, out);
    char message[256];
    snprintf(message, sizeof message, "%s", covbeam_last_error());
    ok(covbeam_scene_free(scene));
    check(status != COVBEAM_OUT_OF_MEMORY || strstr(message, "GB"), "the message does not say how much");
    return status;
}

static void too_large(uint32_t side, uint32_t photons) {
    covbeam_session *session = (covbeam_session *)1;
    const int64_t live = scarce_live;
    check(session_of(side, photons, &session) == COVBEAM_OUT_OF_MEMORY, "a picture that no memory holds");
    check(session == (covbeam_session *)1, "written in spite of the failure");
    check(scarce_live == live, "memory is lost");
    check(of_process("Threads:") == 1, "a thread is left");
}

static void works(void) {
    covbeam_session *session;
    ok(session_of(HOSTED_WIDTH, 50, &session));
    ok(covbeam_session_pass(session, NULL, NULL));
    ok(covbeam_session_free(session));
    /* Its threads end by themselves. */
    while (of_process("Threads:") > 1) continue;
}

static covbeam_geometry *geometry;

static int32_t make(void) {
    covbeam_geometry *made;
    const int32_t status = covbeam_geometry_new(&made);
    return status == COVBEAM_OK ? covbeam_geometry_free(made) : status;
}

static int32_t cast(void) {
    static const float origin[3] = { 0.1f, 1, 0.1f }, down[3] = { 0, -1, 0 };
    covbeam_surface_hit hits[RAYS];
    memset(hits, 0x5a, sizeof hits);
    const covbeam_surface_hit before = hits[0];
    const int32_t status = covbeam_geometry_cast(geometry, RAYS, origin, 0, down, 0, hits, sizeof *hits);
    check((status == COVBEAM_OK) == (memcmp(&before, hits, sizeof before) != 0), "written in spite of the failure");
    return status;
}

/* Each of its requests for memory is refused in turn. */
static uint64_t without(int32_t (*call)(void)) {
    const int64_t live = scarce_live;
    for (uint64_t k = 1;; k++) {
        scarce_begin(k);
        const int32_t status = call();
        const bool was_refused = scarce_end();
        check(status == (was_refused ? COVBEAM_OUT_OF_MEMORY : COVBEAM_OK), "a request that was refused");
        check(scarce_live == live, "memory is lost");
        if (!was_refused) return k - 1;
    }
}

static void build(void) {
    static const float positions[3][3] = { { 0, 0, 0 }, { 0, 0, 1 }, { 1, 0, 0 } };
    static const int32_t triangle[3] = { 0, 1, 2 }, material = 0;
    const covbeam_mesh mesh = { sizeof mesh, 1, &material, 3, positions[0], 1, triangle, NULL };
    covbeam_instance instance;
    memset(&instance, 0, sizeof instance);
    for (int axis = 0; axis < 4; axis++) instance.matrix[5 * axis] = 1;
    ok(covbeam_geometry_new(&geometry));
    ok(covbeam_geometry_add_mesh(geometry, &mesh, NULL));
    ok(covbeam_geometry_add_instances(geometry, 1, &instance, 0));
    ok(covbeam_geometry_build(geometry, NULL, NULL));
    while (of_process("Threads:") > 1) continue;
}

int main(void) {
    build();
    works();
    const uint64_t refused = without(make) + without(cast);
    check(refused >= 4, "hardly anything was refused");
    ok(covbeam_geometry_free(geometry));
    too_large(16384, 1u << 28);
    /* A process that may have some more than it has: what would fit into the machine does not fit into that. */
    const rlim_t more = (rlim_t)of_process("VmSize:") * 1024 + ((rlim_t)1 << 30);
    const struct rlimit limit = { more, more };
    check(setrlimit(RLIMIT_AS, &limit) == 0, "no limit");
    too_large(4000, 50);
    works();
    printf("scarce_session: pictures that no memory holds are refused and leave nothing behind; %llu other requests refused\n",
           (unsigned long long)refused);
    return 0;
}
