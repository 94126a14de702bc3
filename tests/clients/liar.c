/*
 * A host that lies: liar PASSES SEED [SECONDS]
 *
 * Its geometry, materials, lamps and camera answer what is true, but for one answer in a few, a thousand or a million: NaN, infinities, numbers
 * below 0 and beyond all scenes, vectors of no length, hits that were not there before. Sessions of all methods render PASSES passes in all, or as
 * many as SECONDS allow. No call takes long; a pass is done, or refused for light that single precision does not hold; and every number of
 * every picture is finite and not below 0.
 */
#define _POSIX_C_SOURCE 200809L
#include "hosted.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* Longer than any call takes, on a machine that does much other work, and with a checker that slows it down. */
static const double longest = 60;

/* Most passes of a session, and those of a picture. */
enum { PASSES = 100, PICTURE = 10 };
/* Kinds of sessions: all methods, and covbeam's with and without its pilot, which takes as long as some hundred passes. */
enum { KINDS = 9 };

static uint64_t seed, done, refused, pictures;
static double slowest;

static void fail(const char *what, int32_t status) {
    fprintf(stderr, "liar: seed %llu, after %llu passes: %s: %s (%s)\n", (unsigned long long)seed, (unsigned long long)done, what,
            covbeam_status_name(status), covbeam_last_error());
    exit(1);
}

static double now(void) {
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

/* Notes how long a call took that began then. */
static void took(const char *what, double begun) {
    const double seconds = now() - begun;
    if (seconds > slowest) slowest = seconds;
    if (seconds > longest) fail(what, COVBEAM_OK);
}

/* All layers that the session has. */
static void look(const covbeam_session *session, uint32_t most) {
    for (uint32_t layer = 0; layer <= most; layer++) {
        float numbers[3 * HOSTED_PIXELS];
        const bool is_color = layer < COVBEAM_LAYER_ERROR;
        const double begun = now();
        const int32_t status = covbeam_session_picture(session, layer, HOSTED_PIXELS, numbers, 0, NULL, NULL);
        if (layer != COVBEAM_LAYER_ALL && status == COVBEAM_WRONG_ORDER) continue;
        if (status != COVBEAM_OK) fail("a picture", status);
        took("a picture", begun);
        for (int i = 0; i < (is_color ? 3 : 1) * HOSTED_PIXELS; i++)
            if (!(isfinite(numbers[i]) && numbers[i] >= 0)) {
                fprintf(stderr, "layer %u, number %d: %g\n", layer, i, (double)numbers[i]);
                fail("a picture holds what is no light", status);
            }
        pictures++;
    }
}

static void render(struct hosted *hosted, uint64_t number, uint64_t passes) {
    static const uint64_t rates[] = { 1, 3, 30, 1000, 1000, 1000, 1000000 };
    hosted->lies = rates[number % 7];
    hosted->seed = seed + 1000003 * number;
    const uint32_t kind = (uint32_t)(number % KINDS), method = kind < 5 ? COVBEAM_METHOD_COVBEAM : kind - 4;
    const covbeam_host host = hosted_host(hosted, number % 2);
    const covbeam_description description = hosted_description();
    covbeam_session_settings settings = hosted_settings(method);
    settings.seed = (uint32_t)number;
    settings.every_pixel = number % 4 == 0;
    if (method < COVBEAM_METHOD_PLAIN) settings.kinds_apart = number % 3 == 0;
    if (method == COVBEAM_METHOD_COVBEAM && !settings.every_pixel) settings.first_apart = number % 5 == 0;
    covbeam_scene *scene;
    covbeam_session *session;
    int32_t status = covbeam_scene_new_of_host(&host, &description, &scene);
    if (status != COVBEAM_OK) fail("a scene", status);
    double begun = now();
    status = covbeam_session_new(1, (const covbeam_scene *const *)&scene, 0, &settings, NULL, NULL, &session);
    if (status != COVBEAM_OK) fail("a session", status);
    took("a session", begun);
    if (kind > 0 && method == COVBEAM_METHOD_COVBEAM && covbeam_session_restart(session, settings.photons, 1) != COVBEAM_OK)
        fail("a plain session", status);
    bool has_pass = false;
    for (uint64_t pass = 1; pass <= passes; pass++) {
        begun = now();
        status = covbeam_session_pass(session, NULL, NULL);
        took("a pass", begun);
        done++;
        if (status == COVBEAM_INVALID_VALUE && strstr(covbeam_last_error(), "single precision"))
            refused++;
        else if (status != COVBEAM_OK)
            fail("a pass", status);
        else
            has_pass = true;
        if (has_pass && (pass % PICTURE == 0 || pass == passes)) look(session, COVBEAM_LAYER_BANDWIDTH);
    }
    covbeam_session_free(session);
    covbeam_scene_free(scene);
}

int main(int argc, char **argv) {
    if (argc != 3 && argc != 4) {
        fprintf(stderr, "usage: liar PASSES SEED [SECONDS]\n");
        return 2;
    }
    const uint64_t wanted = strtoull(argv[1], NULL, 10);
    seed = strtoull(argv[2], NULL, 10);
    const double begun = now(), end = argc == 4 ? begun + atof(argv[3]) : INFINITY;
    struct hosted hosted;
    memset(&hosted, 0, sizeof hosted);
    /* Two of each kind, if there are many or few. */
    const uint64_t share = wanted / (2 * KINDS), each = share == 0 ? 1 : share < PASSES ? share : PASSES;
    uint64_t sessions = 0;
    for (; done < wanted && now() < end; sessions++) render(&hosted, sessions, each < wanted - done ? each : wanted - done);
    printf("liar: %llu passes of %llu sessions in %.0f s, %llu refused; %llu of %llu answers were lies; %llu layers of sound numbers; the longest call "
           "took %.2f s\n",
           (unsigned long long)done, (unsigned long long)sessions, now() - begun, (unsigned long long)refused,
           (unsigned long long)hosted_sum(hosted.told), (unsigned long long)hosted_sum(hosted.asked), (unsigned long long)pictures, slowest);
    /* A host that lies about everything, and is asked about everything. */
    for (int i = 0; i < 7 && done >= 2 * KINDS; i++)
        if (hosted.told[i] == 0) fail("a function was never asked", i);
    return 0;
}
