/*
 * Calls inside of calls on sessions: from polls, which come from the thread of the call, and from a host's functions, which the library's own threads
 * call. What would change or free a session that renders, or render it, answers COVBEAM_BUSY; where it stands may be asked; and on other sessions and
 * scenes everything works. Nothing of it shows in the picture. And where a poll stops a call, the session may be freed at once: then none of the
 * host's functions is called any more.
 */
#define _POSIX_C_SOURCE 200809L
#include "hosted.h"
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static struct hosted hosted, other_hosted;
static covbeam_scene *scene;
static covbeam_session *session;
static const char *outer_name;
static covbeam_geometry *geometry;
static unsigned char sums[1 << 16];
static size_t sums_size;

/* Once a call: whether the calls are made, by whom, and how many were. */
static bool by_poll, by_cast, stops;
static int32_t begun, was_asked;
static int busy, fine;

static void fail(const char *what, int32_t status) {
    fprintf(stderr, "reentry_session: in %s: %s: %s (%s)\n", outer_name, what, covbeam_status_name(status), covbeam_last_error());
    exit(1);
}

static void must(const char *what, int32_t status) {
    if (status != COVBEAM_OK) fail(what, status);
}

static void refused(const char *what, int32_t status) {
    if (status != COVBEAM_BUSY || !strstr(covbeam_last_error(), "busy")) fail(what, status);
    busy++;
}

static void works(const char *what, int32_t status) {
    must(what, status);
    fine++;
}

static void doze(void) {
    const struct timespec moment = { 0, 1000000 };
    nanosleep(&moment, NULL);
}

static covbeam_session *new_session(const covbeam_scene *of) {
    covbeam_session_settings settings = hosted_settings(COVBEAM_METHOD_THESIS);
    covbeam_session *made;
    must("a session", covbeam_session_new(1, &of, 0, &settings, NULL, NULL, &made));
    return made;
}

static void picture(const covbeam_session *of, float *numbers) {
    must("a picture", covbeam_session_picture(of, COVBEAM_LAYER_ALL, HOSTED_PIXELS, numbers, 0, NULL, NULL));
}

/* Every function that takes a handle. */
static void disturb(void) {
    covbeam_session_info info;
    covbeam_goal goal = { sizeof goal, 1, 0, 0 };
    float numbers[3 * HOSTED_PIXELS];
    size_t size;
    if (session) {
        refused("pass", covbeam_session_pass(session, NULL, NULL));
        refused("until", covbeam_session_until(session, &goal, NULL, NULL, NULL));
        refused("picture", covbeam_session_picture(session, COVBEAM_LAYER_ALL, HOSTED_PIXELS, numbers, 0, NULL, NULL));
        refused("save", covbeam_session_save(session, NULL, 0, &size));
        refused("merge", covbeam_session_merge(session, sums, sums_size, NULL, NULL));
        refused("restart", covbeam_session_restart(session, 1, 1));
        refused("free", covbeam_session_free(session));
        works("get_info", covbeam_session_get_info(session, &info));
    }
    if (geometry) {
        covbeam_geometry_info built;
        const covbeam_description description = hosted_description();
        const float at[3] = { 0, 0, 1 };
        covbeam_surface_hit hit;
        covbeam_scene *made;
        covbeam_mesh mesh;
        covbeam_instance instance;
        memset(&mesh, 0, sizeof mesh);
        memset(&instance, 0, sizeof instance);
        refused("add_mesh", covbeam_geometry_add_mesh(geometry, &mesh, NULL));
        refused("add_instances", covbeam_geometry_add_instances(geometry, 1, &instance, 0));
        refused("build", covbeam_geometry_build(geometry, NULL, NULL));
        refused("get_info", covbeam_geometry_get_info(geometry, &built));
        refused("cast", covbeam_geometry_cast(geometry, 1, at, 0, at, 0, &hit, 0));
        refused("scene_new", covbeam_scene_new(geometry, &description, &made));
        refused("free", covbeam_geometry_free(geometry));
    }
    /* Another session of the same scene; and another scene. */
    const covbeam_host host = hosted_host(&other_hosted, true);
    const covbeam_description description = hosted_description();
    covbeam_scene *other;
    works("another scene", covbeam_scene_new_of_host(&host, &description, &other));
    const covbeam_scene *all[2] = { other, scene };
    for (int i = 0; i < 2; i++) {
        covbeam_session *own = new_session(all[i]);
        works("pass of another", covbeam_session_pass(own, NULL, NULL));
        picture(own, numbers);
        works("free of another", covbeam_session_free(own));
    }
    works("scene_free", covbeam_scene_free(other));
}

/* The first cast of a call waits until a poll has been asked, so that one is. */
static void meanwhile(void) {
    if (__atomic_exchange_n(&begun, 1, __ATOMIC_ACQ_REL) != 0) return;
    if (by_cast) disturb();
    while (!__atomic_load_n(&was_asked, __ATOMIC_ACQUIRE)) doze();
}

static int32_t poll(void *user) {
    if (user != &hosted) fail("another user", COVBEAM_OK);
    if (was_asked) return 0;
    if (by_poll) disturb();
    __atomic_store_n(&was_asked, 1, __ATOMIC_RELEASE);
    return stops;
}

static void *idle(void *unused) {
    disturb();
    return unused;
}

static int32_t poll_of_threads(void *user) {
    pthread_t thread;
    if (was_asked) return 0;
    if (pthread_create(&thread, NULL, idle, NULL) != 0 || pthread_join(thread, NULL) != 0) exit(2);
    by_poll = false;
    return poll(user);
}

static covbeam_poll asked = poll;

static int32_t by_pass(void) { return covbeam_session_pass(session, asked, &hosted); }
static int32_t by_until(void) {
    const covbeam_goal goal = { sizeof goal, 2, 0, 0 };
    return covbeam_session_until(session, &goal, asked, &hosted, NULL);
}

/* A session that is being made has no handle yet. */
static int32_t by_new(void) {
    covbeam_session_settings settings = hosted_settings(COVBEAM_METHOD_THESIS);
    covbeam_session *made, *before = session;
    session = NULL;
    const int32_t status = covbeam_session_new(1, (const covbeam_scene *const *)&scene, 0, &settings, asked, &hosted, &made);
    session = before;
    if (status == COVBEAM_OK) must("a session", covbeam_session_free(made));
    return status;
}

/* More and more triangles, until it takes so long that a poll is asked. */
static int32_t by_build(void) {
    covbeam_session *before = session;
    session = NULL;
    for (int32_t side = 100; !was_asked; side *= 2) {
        const size_t count = (size_t)side * (size_t)side;
        float *positions = malloc(count * 3 * sizeof *positions);
        int32_t *triangles = malloc(count * 3 * sizeof *triangles), material = 0;
        if (!positions || !triangles) exit(2);
        for (size_t i = 0; i < count; i++) {
            positions[3 * i] = (float)(i % (size_t)side);
            positions[3 * i + 1] = (float)(i * i % 7);
            positions[3 * i + 2] = (float)(i / (size_t)side);
            for (size_t corner = 0; corner < 3; corner++)
                triangles[3 * i + corner] = (int32_t)((i + corner * corner * (size_t)side + corner) % count);
        }
        covbeam_mesh mesh = { sizeof mesh, 1, &material, count, positions, count, triangles, NULL };
        must("a geometry", covbeam_geometry_new(&geometry));
        must("a mesh", covbeam_geometry_add_mesh(geometry, &mesh, NULL));
        free(positions);
        free(triangles);
        must("a build", covbeam_geometry_build(geometry, asked, &hosted));
        must("a geometry", covbeam_geometry_free(geometry));
    }
    geometry = NULL;
    session = before;
    return COVBEAM_OK;
}

/* A call that is stopped, and the end of its session: the host's functions are not called after that. */
static void stopped(void) {
    for (int i = 0; i < 20; i++) {
        session = new_session(scene);
        outer_name = "a pass that is stopped";
        begun = was_asked = 0;
        stops = true;
        hosted.meanwhile = meanwhile;
        const int32_t status = covbeam_session_pass(session, poll, &hosted);
        if (status != COVBEAM_CANCELLED && status != COVBEAM_OK) fail("a poll that says no", status);
        must("free", covbeam_session_free(session));
        const uint64_t before = hosted_sum(hosted.asked);
        for (int k = 0; k < 5; k++) doze();
        if (hosted_sum(hosted.asked) != before) fail("a host is asked after its sessions have been freed", status);
        hosted.meanwhile = NULL;
        stops = false;
    }
}

int main(void) {
    static const struct {
        const char *name;
        int32_t (*call)(void);
    } calls[] = { { "pass", by_pass }, { "until", by_until }, { "session_new", by_new }, { "geometry_build", by_build } };
    const covbeam_host host = hosted_host(&hosted, true);
    const covbeam_description description = hosted_description();
    outer_name = "nothing";
    must("a scene", covbeam_scene_new_of_host(&host, &description, &scene));
    covbeam_session *first = new_session(scene);
    must("a pass", covbeam_session_pass(first, NULL, NULL));
    must("sums", covbeam_session_save(first, sums, sizeof sums, &sums_size));
    must("free", covbeam_session_free(first));
    for (size_t i = 0; i < sizeof calls / sizeof *calls; i++) {
        float pictures[4][3 * HOSTED_PIXELS];
        memset(pictures, 0, sizeof pictures);
        for (int how = 0; how < 4; how++) {
            outer_name = calls[i].name;
            session = new_session(scene);
            begun = was_asked = 0;
            by_poll = how == 1;
            by_cast = how == 2 && calls[i].call != by_build;
            asked = how == 3 ? poll_of_threads : poll;
            hosted.meanwhile = calls[i].call == by_build ? NULL : meanwhile;
            must("a call that nothing disturbs", calls[i].call());
            hosted.meanwhile = NULL;
            if (!was_asked) fail("no poll was asked", COVBEAM_OK);
            if (calls[i].call == by_pass || calls[i].call == by_until) picture(session, pictures[how]);
            must("free", covbeam_session_free(session));
            if (memcmp(pictures[0], pictures[how], sizeof *pictures) != 0) fail("what was refused shows", COVBEAM_OK);
        }
    }
    stopped();
    must("scene_free", covbeam_scene_free(scene));
    printf("reentry_session: %d calls on objects in use are refused, %d on others work; from polls, other threads and the library's own; and nobody is "
           "asked after the end\n",
           busy, fine);
    return 0;
}
