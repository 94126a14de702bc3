/*
 * A host with threads of its own: threads [busy | race]
 *
 * Shares of photons deposited by 1, 2 and 8 threads give the same bits. Eight threads take rows of one film at once, and together
 * get the bits of one. Eight threads look at one map, one grid and one density at once, while some of them fail calls on purpose and others cancel: each gets the bits of a single thread, and its own
 * message.
 * `busy`: two threads add to one map at once, and what one of them cannot add is refused.
 * `race` breaks the header's rule where the library cannot notice: two threads change one light field at once. A race detector must see that.
 */
#define _POSIX_C_SOURCE 200809L
#include "covbeam_extra.h"
#include <pthread.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { THREADS = 8, SHARES = 12, SEGMENTS = 6, BEAMS = 400, RAYS = 70, ROUNDS = 6, MANY = 100 };

static const covbeam_grid_layout layout = { { 0, 0, 0 }, { 1, 1, 1 }, { 5, 5, 5 } };

static void check(bool holds, const char *what) {
    if (holds) return;
    fprintf(stderr, "threads: %s (%s)\n", what, covbeam_last_error());
    exit(1);
}

static void ok(int32_t status) { check(status == COVBEAM_OK, covbeam_status_name(status)); }

/* Repeatable numbers in [0, 1). */
static float random_number(uint64_t *state) {
    *state ^= *state >> 12;
    *state ^= *state << 25;
    *state ^= *state >> 27;
    return (float)(*state * 0x2545f4914f6cdd1du >> 40) / 16777216.0f;
}

static covbeam_medium smoke(const covbeam_density *voxels) {
    covbeam_medium medium;
    memset(&medium, 0, sizeof medium);
    medium.struct_size = sizeof medium;
    for (int i = 0; i < 3; i++) medium.scattering[i] = 0.5f + 0.1f * (float)i;
    medium.density = COVBEAM_DENSITY_VOXELS;
    medium.voxels = voxels;
    return medium;
}

static covbeam_density *make_density(void) {
    float values[125];
    uint64_t state = 5;
    for (int i = 0; i < 125; i++) values[i] = random_number(&state);
    covbeam_density *density;
    ok(covbeam_density_new(&layout, values, sizeof *values, 125, &density));
    return density;
}

static void beam_at(uint64_t *state, covbeam_beam *beam) {
    memset(beam, 0, sizeof *beam);
    for (int i = 0; i < 3; i++) {
        beam->origin[i] = random_number(state);
        beam->power[i] = 1;
    }
    const covbeam_phase phase = { COVBEAM_PHASE_ISOTROPIC, 0 };
    const float z[3] = { 0, 0, 1 }, xi[2] = { random_number(state), random_number(state) };
    ok(covbeam_phase_sample(&phase, z, xi, beam->direction));
    beam->length = 1;
}

/* Part one: shares of the photons. */

static covbeam_grid *shares[SHARES];
static int next_share;
static pthread_mutex_t share_lock = PTHREAD_MUTEX_INITIALIZER;
static covbeam_density *density;

static void deposit_share(int share) {
    const covbeam_medium medium = smoke(density);
    uint64_t state = 17 + (uint64_t)share;
    covbeam_segment segments[SEGMENTS];
    memset(segments, 0, sizeof segments);
    for (int i = 0; i < SEGMENTS; i++) {
        covbeam_beam beam;
        beam_at(&state, &beam);
        memcpy(segments[i].origin, beam.origin, sizeof beam.origin);
        segments[i].length = 2;
        segments[i].power = 1;
        segments[i].unscattered = 1;
        ok(covbeam_light_field_point(beam.direction, 0.1f, &segments[i].field));
        ok(covbeam_light_field_travel(&segments[i].field, 0.5f));
    }
    ok(covbeam_grid_deposit(shares[share], &medium, SEGMENTS, segments, sizeof *segments, NULL, NULL));
}

static void *deposit_shares(void *unused) {
    for (;;) {
        pthread_mutex_lock(&share_lock);
        const int share = next_share++;
        pthread_mutex_unlock(&share_lock);
        if (share >= SHARES) return unused;
        deposit_share(share);
    }
}

/* What all shares have collected, by some number of threads. */
static covbeam_grid *collect(int threads) {
    pthread_t others[THREADS];
    next_share = 0;
    for (int i = 0; i < SHARES; i++) ok(covbeam_grid_new(&layout, &shares[i]));
    for (int i = 0; i < threads; i++) check(pthread_create(&others[i], NULL, deposit_shares, NULL) == 0, "no thread");
    for (int i = 0; i < threads; i++) pthread_join(others[i], NULL);
    covbeam_grid *sum;
    ok(covbeam_grid_new(&layout, &sum));
    ok(covbeam_grid_merge(sum, (const covbeam_grid *const *)shares, SHARES));
    ok(covbeam_grid_resolve(sum));
    for (int i = 0; i < SHARES; i++) covbeam_grid_free(shares[i]);
    return sum;
}

static bool same_cells(const covbeam_grid *a, const covbeam_grid *b) {
    const covbeam_grid_cell *of_a, *of_b;
    size_t count, other;
    ok(covbeam_grid_get_cells(a, &of_a, &count));
    ok(covbeam_grid_get_cells(b, &of_b, &other));
    return count == other && memcmp(of_a, of_b, count * sizeof *of_a) == 0;
}

/* Part two: many readers. */

static covbeam_beam_map *map;
static covbeam_grid *grid;
static const covbeam_kernel kernel = { sizeof kernel, COVBEAM_KERNEL_BIWEIGHT, 0.05f, 0.2f, 0.1f };
static covbeam_eye_ray rays[RAYS];
static covbeam_gathered expected[RAYS];

static int32_t never(void *user) {
    ++*(int *)user;
    return 1;
}

static void fail_on_purpose(int thread) {
    float result = -1;
    char own[16];
    snprintf(own, sizeof own, "-%d", 1000 + thread);
    check(covbeam_error_bound((float)-(1000 + thread), 1, &result) == COVBEAM_INVALID_VALUE, "a negative error is taken");
    /* Others fail meanwhile, with numbers of their own. */
    for (int i = 0; i < 20; i++) {
        const struct timespec moment = { 0, 1000 };
        nanosleep(&moment, NULL);
        check(strstr(covbeam_last_error(), own) != NULL, "the message is another thread's");
    }
    check(result == -1, "written in spite of the failure");
}

static void *look(void *number) {
    const int thread = *(int *)number;
    covbeam_scratch *scratch;
    ok(covbeam_scratch_new(&scratch));
    const covbeam_medium medium = smoke(density);
    check(strcmp(covbeam_last_error(), "") == 0, "a new thread has a message");
    for (int round = 0; round < ROUNDS; round++) {
        covbeam_gathered gathered[RAYS];
        memset(gathered, 0x5a, sizeof gathered);
        int asked = 0;
        if (thread % 2 == 1) {
            const int32_t status = covbeam_beam_map_gather(map, &kernel, grid, RAYS, rays, sizeof *rays, gathered,
                                                           sizeof *gathered, scratch, never, &asked);
            check(status == COVBEAM_CANCELLED && asked == 1, "not cancelled");
            check(*(unsigned char *)gathered == 0x5a, "a cancelled gather has written");
        }
        ok(covbeam_beam_map_gather(map, &kernel, grid, RAYS, rays, sizeof *rays, gathered, sizeof *gathered, scratch, NULL, NULL));
        check(memcmp(gathered, expected, sizeof expected) == 0, "a gather gives other bits in a thread");
        if (thread % 3 == 0) fail_on_purpose(thread);
        covbeam_spectrum spectrum;
        size_t count;
        float radius, sigma, column;
        ok(covbeam_grid_look_up(grid, 1, rays[round].origin, 12, &spectrum, sizeof spectrum, NULL, 0));
        ok(covbeam_kernel_radius_at(&kernel, grid, rays[round].origin, rays[round].direction, &radius, &sigma));
        ok(covbeam_medium_column_at(&medium, rays[round].origin, rays[round].direction, 1, &column));
        ok(covbeam_beam_map_get_count(map, &count));
        check(count == BEAMS, "a count is wrong");
        /* Objects of the thread's own that keep the shared density alive. */
        covbeam_beam_map *own;
        covbeam_beam beam;
        uint64_t state = 3;
        beam_at(&state, &beam);
        ok(covbeam_beam_map_new(&medium, &own));
        ok(covbeam_beam_map_add(own, 1, &beam, sizeof beam));
        ok(covbeam_beam_map_commit(own, 0.2f, NULL, NULL));
        covbeam_beam_map_free(own);
    }
    covbeam_scratch_free(scratch);
    return NULL;
}

enum { WIDTH = 40, HEIGHT = 8 * THREADS, PIXELS = WIDTH * HEIGHT };

static covbeam_film *film;
static covbeam_film_pixel whole[PIXELS], together[PIXELS];

static covbeam_film *make_film(void) {
    covbeam_film *made;
    size_t nodes;
    static covbeam_film_ray seen[PIXELS];
    uint64_t state = 3;
    const covbeam_image_spectrum smooth = { 0.0001f, 0, 0.0001f, 1 };
    ok(covbeam_film_new(WIDTH, HEIGHT, 1, PIXELS, NULL, 0, &made));
    ok(covbeam_film_get_node_count(made, &nodes));
    for (uint32_t pass = 1; pass < 3; pass++) {
        for (uint32_t i = 0; i < PIXELS; i++) {
            const covbeam_film_ray ray = { { i % WIDTH, i / WIDTH }, 1, i % 3 == 0, { random_number(&state), 0, 0 }, { 0, 1, 0 } };
            seen[i] = ray;
        }
        ok(covbeam_film_plan(made, pass, 0.01f, 9, nodes, &smooth, 0, NULL, NULL));
        ok(covbeam_film_add(made, PIXELS, seen, sizeof *seen));
    }
    ok(covbeam_film_verify(made, NULL, NULL));
    return made;
}

/* All of the picture, and then the rows of this thread's own. */
static void *take_rows(void *number) {
    const uint32_t first = 8 * (uint32_t)*(const int *)number;
    covbeam_film_pixel own[PIXELS];
    ok(covbeam_film_picture(film, 0, PIXELS, own, sizeof *own));
    check(memcmp(own, whole, sizeof own) == 0, "another thread sees another picture");
    ok(covbeam_film_picture(film, first, 8 * WIDTH, together + first * WIDTH, sizeof *together));
    return NULL;
}

static void *add_beams(void *added) {
    uint64_t state = 9;
    covbeam_beam beams[MANY];
    for (int i = 0; i < MANY; i++) beam_at(&state, &beams[i]);
    for (int i = 0; i < 1000; i++) {
        const int32_t status = covbeam_beam_map_add(map, MANY, beams, sizeof *beams);
        check(status == COVBEAM_OK || status == COVBEAM_BUSY, "two threads add");
        *(size_t *)added += status == COVBEAM_OK;
    }
    return NULL;
}

static covbeam_light_field field;

static void *change_field(void *unused) {
    const float distance = 0.01f;
    for (int i = 0; i < 100; i++) ok(covbeam_light_fields_travel(1, &field, 0, &distance, 0));
    return unused;
}

int main(int argc, char **argv) {
    pthread_t threads[THREADS];
    int numbers[THREADS];
    const bool race = argc == 2 && strcmp(argv[1], "race") == 0;
    density = make_density();
    const covbeam_medium medium = smoke(density);
    uint64_t state = 1;
    static covbeam_beam beams[BEAMS];
    for (int i = 0; i < BEAMS; i++) beam_at(&state, &beams[i]);
    ok(covbeam_beam_map_new(&medium, &map));
    ok(covbeam_beam_map_add(map, BEAMS, beams, sizeof *beams));
    if (race) {
        ok(covbeam_light_field_point(beams[0].direction, 0.1f, &field));
        for (int i = 0; i < 2; i++) check(pthread_create(&threads[i], NULL, change_field, NULL) == 0, "no thread");
        for (int i = 0; i < 2; i++) pthread_join(threads[i], NULL);
        covbeam_beam_map_free(map);
        covbeam_density_free(density);
        printf("threads: raced\n");
        return 0;
    }
    if (argc == 2 && strcmp(argv[1], "busy") == 0) {
        size_t added[2] = { 0, 0 }, count = 0;
        for (int i = 0; i < 2; i++) check(pthread_create(&threads[i], NULL, add_beams, &added[i]) == 0, "no thread");
        for (int i = 0; i < 2; i++) pthread_join(threads[i], NULL);
        ok(covbeam_beam_map_get_count(map, &count));
        check(count == BEAMS + MANY * (added[0] + added[1]), "beams that were added are not there");
        covbeam_beam_map_free(map);
        covbeam_density_free(density);
        printf("threads: %zu of 2000 adds of two threads at once, the others refused\n", added[0] + added[1]);
        return 0;
    }
    film = make_film();
    ok(covbeam_film_picture(film, 0, PIXELS, whole, sizeof *whole));
    for (int i = 0; i < THREADS; i++) {
        numbers[i] = i;
        check(pthread_create(&threads[i], NULL, take_rows, &numbers[i]) == 0, "no thread");
    }
    for (int i = 0; i < THREADS; i++) pthread_join(threads[i], NULL);
    check(memcmp(whole, together, sizeof whole) == 0, "rows of several threads are another picture");
    check(whole[0].radiance[1] > 0.9f && whole[PIXELS - 1].radiance[0] > 0, "a dark picture");
    covbeam_film_free(film);
    grid = collect(1);
    for (int count = 2; count <= THREADS; count += 6) {
        covbeam_grid *other = collect(count);
        check(same_cells(grid, other), "another number of threads collects other bits");
        covbeam_grid_free(other);
    }
    ok(covbeam_beam_map_commit(map, kernel.max_radius, NULL, NULL));
    for (int i = 0; i < RAYS; i++) {
        covbeam_beam beam;
        beam_at(&state, &beam);
        memcpy(rays[i].origin, beam.origin, sizeof beam.origin);
        memcpy(rays[i].direction, beam.direction, sizeof beam.direction);
        rays[i].length = 1;
    }
    ok(covbeam_beam_map_gather(map, &kernel, grid, RAYS, rays, sizeof *rays, expected, sizeof *expected, NULL, NULL, NULL));
    uint32_t pairs = 0;
    for (int i = 0; i < RAYS; i++) pairs += expected[i].pairs;
    check(pairs > 1000, "the rays gather hardly anything");
    for (int i = 0; i < THREADS; i++) {
        numbers[i] = i;
        check(pthread_create(&threads[i], NULL, look, &numbers[i]) == 0, "no thread");
    }
    for (int i = 0; i < THREADS; i++) pthread_join(threads[i], NULL);
    covbeam_beam_map_free(map);
    covbeam_grid_free(grid);
    covbeam_density_free(density);
    printf("threads: %d shares by 1, 2 and 8 threads: the same bits; 8 threads x %d gathers of %u pairs: the same bits, own messages\n",
           SHARES, ROUNDS, pairs);
    return 0;
}
