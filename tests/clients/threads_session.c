/*
 * A host with threads of its own, and sessions: threads_session [race]
 *
 * While one thread renders with a session, others ask where it stands, and ask for pictures and sums, which they get or are told COVBEAM_BUSY; two
 * sessions render one scene at once; and a session's threads are the host's own, which end with it. Each time the picture has the bits of a session
 * that was alone.
 * `race`: a function of the host's changes what it has, and is called from two threads at once. A race detector must see that.
 */
#define _POSIX_C_SOURCE 200809L
#include "hosted.h"
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PASSES = 12, ASKING = 3, WORKERS = 2 };

static struct hosted hosted;
static covbeam_scene *scene;
static float alone[3 * HOSTED_PIXELS];
static int32_t ended;

static void check(bool holds, const char *what) {
    if (holds) return;
    fprintf(stderr, "threads_session: %s (%s)\n", what, covbeam_last_error());
    exit(1);
}

static void ok(int32_t status) { check(status == COVBEAM_OK, covbeam_status_name(status)); }

static covbeam_session *new_session(covbeam_spawn spawn, void *user) {
    covbeam_session_settings settings = hosted_settings(COVBEAM_METHOD_COVBEAM);
    covbeam_session *made;
    settings.spawn = spawn;
    settings.spawn_user = user;
    settings.threads = WORKERS;
    ok(covbeam_session_new(1, (const covbeam_scene *const *)&scene, 0, &settings, NULL, NULL, &made));
    /* The pilot takes a second, and more with a checker. */
    ok(covbeam_session_restart(made, settings.photons, 1));
    return made;
}

static void render(const covbeam_session *session) {
    for (int i = 0; i < PASSES;) {
        const int32_t status = covbeam_session_pass(session, NULL, NULL);
        check(status == COVBEAM_OK || status == COVBEAM_BUSY, "a pass while others ask");
        i += status == COVBEAM_OK;
    }
}

static void same(const covbeam_session *session) {
    float numbers[3 * HOSTED_PIXELS];
    ok(covbeam_session_picture(session, COVBEAM_LAYER_ALL, HOSTED_PIXELS, numbers, 0, NULL, NULL));
    check(memcmp(numbers, alone, sizeof alone) == 0, "another picture than that of a session that was alone");
}

static uint64_t answered, busy;

static void *ask(void *given) {
    const covbeam_session *session = given;
    while (!__atomic_load_n(&ended, __ATOMIC_ACQUIRE)) {
        covbeam_session_info info;
        float numbers[3 * HOSTED_PIXELS];
        size_t size;
        ok(covbeam_session_get_info(session, &info));
        check(info.passes <= PASSES, "more passes than were made");
        const int32_t statuses[] = { covbeam_session_picture(session, COVBEAM_LAYER_ALL, HOSTED_PIXELS, numbers, 0, NULL, NULL),
                                     covbeam_session_save(session, NULL, 0, &size) };
        for (int i = 0; i < 2; i++) {
            const bool is_early = statuses[i] == COVBEAM_WRONG_ORDER && info.passes == 0;
            check(statuses[i] == COVBEAM_OK || statuses[i] == COVBEAM_BUSY || is_early, "another answer than busy");
            __atomic_fetch_add(statuses[i] == COVBEAM_BUSY ? &busy : &answered, 1, __ATOMIC_RELAXED);
        }
        check(info.width == HOSTED_WIDTH, "an info that is none");
    }
    return NULL;
}

static void *render_beside(void *unused) {
    covbeam_session *session = new_session(NULL, NULL);
    render(session);
    same(session);
    ok(covbeam_session_free(session));
    return unused;
}

/* The host's own threads. */
static struct worker {
    pthread_t thread;
    void (*body)(void *argument);
    void *argument;
} workers[WORKERS];

static void *work(void *given) {
    const struct worker *worker = given;
    worker->body(worker->argument);
    return NULL;
}

static int32_t spawn(void *user, void (*body)(void *argument), void *argument) {
    int *started = user;
    check(*started < WORKERS, "more threads than the settings say");
    struct worker *worker = &workers[(*started)++];
    worker->body = body;
    worker->argument = argument;
    return pthread_create(&worker->thread, NULL, work, worker);
}

static uint64_t unguarded;
static void change(void) { unguarded++; }

int main(int argc, char **argv) {
    pthread_t threads[ASKING];
    const covbeam_host host = hosted_host(&hosted, true);
    const covbeam_description description = hosted_description();
    if (argc == 2 && strcmp(argv[1], "race") == 0) hosted.meanwhile = change;
    ok(covbeam_scene_new_of_host(&host, &description, &scene));
    covbeam_session *session = new_session(NULL, NULL);
    render(session);
    ok(covbeam_session_picture(session, COVBEAM_LAYER_ALL, HOSTED_PIXELS, alone, 0, NULL, NULL));
    ok(covbeam_session_free(session));

    session = new_session(NULL, NULL);
    for (int i = 0; i < ASKING; i++) check(pthread_create(&threads[i], NULL, ask, session) == 0, "no thread");
    render(session);
    __atomic_store_n(&ended, 1, __ATOMIC_RELEASE);
    for (int i = 0; i < ASKING; i++) pthread_join(threads[i], NULL);
    same(session);
    ok(covbeam_session_free(session));

    for (int i = 0; i < 2; i++) check(pthread_create(&threads[i], NULL, render_beside, NULL) == 0, "no thread");
    for (int i = 0; i < 2; i++) pthread_join(threads[i], NULL);

    int started = 0;
    session = new_session(spawn, &started);
    render(session);
    same(session);
    ok(covbeam_session_free(session));
    check(started == WORKERS, "fewer threads than the settings say");
    for (int i = 0; i < WORKERS; i++) pthread_join(workers[i].thread, NULL);
    ok(covbeam_scene_free(scene));
    printf("threads_session: while one thread renders three others ask %llu times, busy %llu times; two sessions at once, and threads of the host's: the "
           "same bits\n",
           (unsigned long long)answered, (unsigned long long)busy);
    return 0;
}
