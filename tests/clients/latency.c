/*
 * How soon a long call comes back when the host wants it to: latency [BEAMS]
 *
 * BEAMS, a million unless told, through the unit cube are committed and gathered, in a homogeneous medium and in voxels.
 * Measured: the longest time without a question to poll (from the call's start and to its end too), and the time from a
 * cancel request, made by another thread at some moment, to the call's return. The requirement is 50 ms. What the library
 * answers for is the processor time between questions: that must keep to it; the time on the clock, which other programs
 * prolong, gets ten times as long before this fails. Other programs prolong the processor's time, too (pages that the system
 * has to find, shared caches): what is too long is measured again, and what the library does, it does each time.
 * After the cancelled calls the map is committed and gathers the same bits as one that was never disturbed.
 */
#define _POSIX_C_SOURCE 200809L
#include "covbeam_extra.h"
#include <pthread.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static const double required = 50, tolerated = 500; /* [ms] */
enum { CANCELS = 8, TRIES = 3, TILE = 64, PICTURE = 100000, PROBES = 64 };

static void check(bool holds, const char *what) {
    if (holds) return;
    fprintf(stderr, "latency: %s (%s)\n", what, covbeam_last_error());
    exit(1);
}

static void ok(int32_t status) { check(status == COVBEAM_OK, covbeam_status_name(status)); }

static double milliseconds(clockid_t clock) {
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec * 1e-6;
}

static double now(void) { return milliseconds(CLOCK_MONOTONIC); }
static double processor(void) { return milliseconds(CLOCK_THREAD_CPUTIME_ID); }

/* One call that is watched, and perhaps asked to stop. */
struct watch {
    double last, last_processor;
    double delay; /* after which the request comes [ms] */
    pthread_mutex_t lock;
    double requested; /* when, or 0 */
};

static double longest_question, longest_processor, longest_answer;

/* The time since the last question. */
static void note(struct watch *w) {
    const double t = now(), p = processor();
    if (t - w->last > longest_question) longest_question = t - w->last;
    if (p - w->last_processor > longest_processor) longest_processor = p - w->last_processor;
    w->last = t;
    w->last_processor = p;
}

static int32_t ask(void *user) {
    struct watch *w = user;
    note(w);
    pthread_mutex_lock(&w->lock);
    const bool stop = w->requested > 0;
    pthread_mutex_unlock(&w->lock);
    return stop;
}

static void *request(void *user) {
    struct watch *w = user;
    const struct timespec delay = { (time_t)(w->delay / 1e3), (long)((w->delay - 1e3 * (double)(int)(w->delay / 1e3)) * 1e6) };
    nanosleep(&delay, NULL);
    pthread_mutex_lock(&w->lock);
    w->requested = now();
    pthread_mutex_unlock(&w->lock);
    return NULL;
}

typedef int32_t (*long_call)(void *object, struct watch *w);

/* Runs a call to its end, or until it answers a request that comes after `delay` ms; the time it took. */
static double run(long_call call, void *object, double delay, double *answer) {
    struct watch w = { 0, 0, delay, PTHREAD_MUTEX_INITIALIZER, 0 };
    pthread_t other;
    if (delay > 0) check(pthread_create(&other, NULL, request, &w) == 0, "no thread");
    w.last_processor = processor();
    const double start = w.last = now();
    const int32_t status = call(object, &w);
    const double end = now();
    note(&w);
    if (delay > 0) pthread_join(other, NULL);
    check(status == COVBEAM_OK || status == COVBEAM_CANCELLED, covbeam_status_name(status));
    check(delay > 0 || status == COVBEAM_OK, "cancelled without a request");
    *answer = status == COVBEAM_CANCELLED ? end - w.requested : -1;
    return end - start;
}

static float random_number(uint64_t *state) {
    *state ^= *state >> 12;
    *state ^= *state << 25;
    *state ^= *state >> 27;
    return (float)(*state * 0x2545f4914f6cdd1du >> 40) / 16777216.0f;
}

static void random_direction(uint64_t *state, float *direction) {
    const covbeam_phase phase = { COVBEAM_PHASE_ISOTROPIC, 0 };
    const float z[3] = { 0, 0, 1 }, xi[2] = { random_number(state), random_number(state) };
    ok(covbeam_phase_sample(&phase, z, xi, direction));
}

static const covbeam_kernel wide = { sizeof wide, COVBEAM_KERNEL_BIWEIGHT, 0.05f, 0.05f, 0.1f };
static covbeam_eye_ray *rays;
static covbeam_gathered *gathered;
static covbeam_scratch *scratch;

static size_t beam_count;
static covbeam_beam *beams;

static void begin(covbeam_beam_map *map) {
    ok(covbeam_beam_map_clear(map));
    ok(covbeam_beam_map_add(map, beam_count, beams, sizeof *beams));
}

static int32_t commit(void *map, struct watch *w) { return covbeam_beam_map_commit(map, wide.max_radius, ask, w); }

static int32_t gather(void *map, size_t count, struct watch *w) {
    return covbeam_beam_map_gather(map, &wide, NULL, count, rays, sizeof *rays, gathered, sizeof *gathered, scratch, ask, w);
}

static int32_t gather_tile(void *map, struct watch *w) { return gather(map, TILE, w); }
static int32_t gather_picture(void *map, struct watch *w) { return gather(map, PICTURE, w); }

static int32_t host_shade(void *user, const covbeam_contact *contacts, size_t count, float *values) {
    (void)user;
    for (size_t i = 0; i < 3 * count; i++) values[i] = contacts[i / 3].cos_theta + 2;
    return 0;
}

static int32_t gather_shaded(void *map, struct watch *w) {
    return covbeam_beam_map_gather_shaded(map, &wide, NULL, PICTURE, rays, sizeof *rays, gathered, sizeof *gathered, scratch,
                                          host_shade, ask, w);
}

/* Cancels a call at moments spread over most of `span` ms and prints what was measured; whether it kept to the time at work. */
static bool disturbed(const char *name, long_call call, covbeam_beam_map *map, double span) {
    longest_question = longest_processor = longest_answer = 0;
    int answered = 0;
    for (int i = 0; i < CANCELS; i++) {
        double answer;
        run(call, map, 1 + 0.7 * span * (i + 0.5) / CANCELS, &answer);
        if (call == commit && answer < 0) begin(map); /* it was too late: the map is committed */
        if (answer > longest_answer) longest_answer = answer;
        answered += answer >= 0;
    }
    printf("  %-28s %d of %d requests answered, within %.2f ms; longest time without a question %.2f ms, %.2f ms of it at work%s\n",
           name, answered, CANCELS, longest_answer, longest_question, longest_processor,
           longest_answer > required || longest_question > required ? " (MORE THAN 50)" : "");
    fflush(stdout);
    check(answered >= CANCELS / 4, "too few requests came in time");
    check(longest_answer < tolerated && longest_question < tolerated, "far too long");
    return longest_processor <= required;
}

static void disturb(const char *name, long_call call, covbeam_beam_map *map, double span) {
    for (int i = 0; i < TRIES; i++)
        if (disturbed(name, call, map, span)) return;
    check(false, "more than 50 ms of work between two questions, each time");
}

/* What the probes gather, with a narrow kernel. */
static void probe(covbeam_beam_map *map, covbeam_gathered *out) {
    const covbeam_kernel narrow = { sizeof narrow, COVBEAM_KERNEL_BIWEIGHT, 0.001f, 0.001f, 0.1f };
    ok(covbeam_beam_map_gather(map, &narrow, NULL, PROBES, rays, sizeof *rays, out, sizeof *out, NULL, NULL, NULL));
}

static void measure(const char *name, const covbeam_medium *medium) {
    covbeam_beam_map *map;
    double answer;
    covbeam_gathered before[PROBES], after[PROBES];
    printf("%s, %zu beams\n", name, beam_count);
    ok(covbeam_beam_map_new(medium, &map));
    double undisturbed = 0;
    longest_processor = 2 * required;
    for (int i = 0; i < TRIES && longest_processor > required; i++) {
        begin(map);
        longest_question = longest_processor = 0;
        undisturbed = run(commit, map, 0, &answer);
    }
    printf("  commit takes %.0f ms; longest time without a question %.2f ms, %.2f ms of it at work\n", undisturbed,
           longest_question, longest_processor);
    check(longest_processor <= required, "more than 50 ms of work between two questions, each time");
    probe(map, before);
    uint64_t pairs = 0;
    for (int i = 0; i < PROBES; i++) pairs += before[i].pairs;
    check(pairs > 0, "the probes gather nothing");

    begin(map);
    disturb("commit", commit, map, undisturbed);
    size_t left;
    ok(covbeam_beam_map_get_count(map, &left));
    check(left == beam_count, "beams are lost");
    ok(covbeam_beam_map_commit(map, wide.max_radius, NULL, NULL));

    const double tile = run(gather_tile, map, 0, &answer);
    printf("  a tile of %d rays takes %.0f ms\n", TILE, tile);
    disturb("gather, 64 rays", gather_tile, map, tile);
    memset(gathered, 0x5a, PICTURE * sizeof *gathered);
    disturb("gather, 100,000 rays", gather_picture, map, 300);
    disturb("gather shaded, 100,000 rays", gather_shaded, map, 300);
    for (size_t i = 0; i < PICTURE * sizeof *gathered; i++)
        check(((unsigned char *)gathered)[i] == 0x5a, "a cancelled gather has written");
    probe(map, after);
    check(memcmp(before, after, sizeof before) == 0, "a map that was disturbed gathers other bits");
    printf("  after all of this the map gathers the same bits (%llu pairs)\n", (unsigned long long)pairs);
    covbeam_beam_map_free(map);
}

int main(int argc, char **argv) {
    beam_count = argc > 1 ? (size_t)strtoull(argv[1], NULL, 10) : 1000000;
    uint64_t state = 1;
    beams = calloc(beam_count, sizeof *beams);
    rays = calloc(PICTURE, sizeof *rays);
    gathered = calloc(PICTURE, sizeof *gathered);
    check(beams && rays && gathered, "no memory");
    ok(covbeam_scratch_new(&scratch));
    for (size_t i = 0; i < beam_count; i++) {
        for (int k = 0; k < 3; k++) {
            beams[i].origin[k] = random_number(&state);
            beams[i].power[k] = 1;
        }
        random_direction(&state, beams[i].direction);
        beams[i].length = 1;
    }
    for (size_t i = 0; i < PICTURE; i++) {
        rays[i].origin[0] = random_number(&state);
        rays[i].origin[1] = random_number(&state);
        rays[i].origin[2] = -1;
        rays[i].direction[2] = 1;
        rays[i].length = 3;
    }
    covbeam_medium fog;
    memset(&fog, 0, sizeof fog);
    fog.struct_size = sizeof fog;
    for (int k = 0; k < 3; k++) fog.scattering[k] = 0.5f;
    measure("homogeneous", &fog);

    const covbeam_grid_layout layout = { { 0, 0, 0 }, { 1, 1, 1 }, { 32, 32, 32 } };
    float *values = malloc(32768 * sizeof *values);
    check(values != NULL, "no memory");
    for (int i = 0; i < 32768; i++) values[i] = 2 * random_number(&state);
    covbeam_density *density;
    ok(covbeam_density_new(&layout, values, sizeof *values, 32768, &density));
    free(values);
    covbeam_medium smoke = fog;
    smoke.density = COVBEAM_DENSITY_VOXELS;
    smoke.voxels = density;
    measure("voxels", &smoke);
    covbeam_density_free(density);
    covbeam_scratch_free(scratch);
    free(gathered);
    free(rays);
    free(beams);
    return 0;
}
