/*
 * Calls on objects that another call uses: from each callback of the library, and from another thread meanwhile, every function
 * that takes such an object. What would change or free an object that is used, or look at one that is changed, answers
 * COVBEAM_BUSY; what only looks at objects that are only looked at works. Nothing of it shows in what the first call does.
 */
#include <covbeam_extra.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAP = 1, GRID = 2, SCRATCH = 4, FILM = 8, VOXELS = 16 };
enum { RAYS = 300, WIDTH = 16, PIXELS = WIDTH * WIDTH, VOXEL_COUNT = 8 };

static const covbeam_grid_layout box = { { 0, 0, 0 }, { 1, 1, 1 }, { 2, 2, 2 } };
static const covbeam_kernel kernel = { sizeof kernel, COVBEAM_KERNEL_BIWEIGHT, 0.1f, 0.1f, 0.01f };
static covbeam_beam beams[40];
static covbeam_eye_ray rays[RAYS];
static covbeam_film_ray seen[PIXELS];
static covbeam_segment segment;
static covbeam_medium smoke;
static covbeam_image_spectrum spectra[PIXELS];
static size_t nodes;

/* What the calls are made on; the first call's results. */
static covbeam_beam_map *map;
static covbeam_grid *grid, *other_grid;
static covbeam_scratch *scratch;
static covbeam_film *film;
static covbeam_density *voxels;
static covbeam_gathered gathered[RAYS];

static void fail(const char *what, int32_t status)
{
    fprintf(stderr, "reentry: %s: %s (%s)\n", what, covbeam_status_name(status), covbeam_last_error());
    exit(1);
}

static void must(int32_t status)
{
    if (status != COVBEAM_OK) fail("a call that nothing disturbs", status);
}

static int32_t shade(void *user, const covbeam_contact *contacts, size_t count, float *values);
static int32_t poll(void *user);

/* Results of calls inside of calls. */
static covbeam_gathered more[RAYS];
static float numbers[PIXELS];
static covbeam_film_pixel pixels[PIXELS];
static uint32_t words[2 * PIXELS];
static unsigned char bytes[56 + 56 * VOXEL_COUNT];
static size_t size;

#define GATHER(scratch) \
    covbeam_beam_map_gather(map, &kernel, NULL, RAYS, rays, sizeof *rays, more, sizeof *more, scratch, NULL, NULL)
#define CALL(name, call) static int32_t name(void) { return call; }
CALL(map_clear, covbeam_beam_map_clear(map))
CALL(map_add, covbeam_beam_map_add(map, 1, beams, sizeof *beams))
CALL(map_commit, covbeam_beam_map_commit(map, 0.1f, NULL, NULL))
CALL(map_free, covbeam_beam_map_free(map))
CALL(map_count, covbeam_beam_map_get_count(map, &size))
CALL(map_memory, covbeam_beam_map_get_memory(map, &size))
CALL(map_gather, GATHER(NULL))
CALL(scratch_gather, GATHER(scratch))
CALL(scratch_shaded, covbeam_beam_map_gather_shaded(map, &kernel, NULL, RAYS, rays, sizeof *rays, more, sizeof *more, scratch, shade,
                                                    NULL, NULL))
CALL(scratch_free, covbeam_scratch_free(scratch))
CALL(grid_clear, covbeam_grid_clear(grid))
CALL(grid_deposit, covbeam_grid_deposit(grid, &smoke, 1, &segment, 0, NULL, NULL))
CALL(grid_deposit_spectra, covbeam_grid_deposit_spectra(grid, 1, segment.origin, 0, (covbeam_spectrum[1]){ { 1, 1, 1, 0, 0, 0 } }, 0,
                                                        (float[1]){ 1 }, 0))
CALL(grid_merge, covbeam_grid_merge(grid, (const covbeam_grid *const *)&other_grid, 1))
CALL(grid_merge_into, covbeam_grid_merge(other_grid, (const covbeam_grid *const *)&grid, 1))
CALL(grid_resolve, covbeam_grid_resolve(grid))
CALL(grid_free, covbeam_grid_free(grid))
CALL(grid_layout, covbeam_grid_get_layout(grid, &(covbeam_grid_layout){ { 0 }, { 0 }, { 0 } }))
CALL(grid_look_up, covbeam_grid_look_up(grid, 1, segment.origin, 0, (covbeam_spectrum[1]){ { 0 } }, 0, NULL, 0))
CALL(grid_cells, covbeam_grid_get_cells(grid, (const covbeam_grid_cell *[1]){ NULL }, &size))
CALL(grid_means, covbeam_grid_get_means(grid, (const covbeam_fluence_cell *[1]){ NULL }, &size))
CALL(grid_saved_size, covbeam_grid_get_saved_size(grid, &size))
CALL(grid_save, covbeam_grid_save(grid, bytes, sizeof bytes))
CALL(grid_radius, covbeam_kernel_radius_at_many(&kernel, grid, 1, segment.origin, 0, segment.field.direction, 0, numbers, 0,
                                                numbers + 1, 0))
CALL(film_plan, covbeam_film_plan(film, 2, 0.1f, 1, nodes, spectra, sizeof *spectra, NULL, NULL))
CALL(film_add, covbeam_film_add(film, PIXELS, seen, sizeof *seen))
CALL(film_verify, covbeam_film_verify(film, NULL, NULL))
CALL(film_free, covbeam_film_free(film))
CALL(film_memory, covbeam_film_get_memory(film, &size))
CALL(film_node_count, covbeam_film_get_node_count(film, &size))
CALL(film_nodes, covbeam_film_nodes(film, nodes, words, 8))
CALL(film_density, covbeam_film_density(film, PIXELS, numbers, 4))
CALL(film_picture, covbeam_film_picture(film, 0, PIXELS, pixels, sizeof *pixels))
CALL(voxels_free, covbeam_density_free(voxels))
CALL(voxels_look, covbeam_medium_density_at_many(&smoke, 1, segment.origin, 0, numbers, 0))
#undef CALL

/* Every function that takes a handle that some call with a callback takes, and how it takes it. */
static const struct action {
    const char *name;
    int32_t (*call)(void);
    int changes, looks;
} actions[] = {
#define ACTION(name, changes, looks) { #name, name, changes, looks }
    ACTION(map_clear, MAP, 0), ACTION(map_add, MAP, 0), ACTION(map_commit, MAP, 0), ACTION(map_free, MAP, 0),
    ACTION(map_count, 0, MAP), ACTION(map_memory, 0, MAP), ACTION(map_gather, 0, MAP),
    ACTION(scratch_gather, SCRATCH, MAP), ACTION(scratch_shaded, SCRATCH, MAP), ACTION(scratch_free, SCRATCH, 0),
    ACTION(grid_clear, GRID, 0), ACTION(grid_deposit, GRID, VOXELS), ACTION(grid_deposit_spectra, GRID, 0),
    ACTION(grid_merge, GRID, 0), ACTION(grid_merge_into, 0, GRID), ACTION(grid_resolve, GRID, 0), ACTION(grid_free, GRID, 0),
    ACTION(grid_layout, 0, GRID), ACTION(grid_look_up, 0, GRID), ACTION(grid_cells, 0, GRID), ACTION(grid_means, 0, GRID),
    ACTION(grid_saved_size, 0, GRID), ACTION(grid_save, 0, GRID), ACTION(grid_radius, 0, GRID),
    ACTION(film_plan, FILM, 0), ACTION(film_add, FILM, 0), ACTION(film_verify, FILM, 0), ACTION(film_free, FILM, 0),
    ACTION(film_memory, 0, FILM), ACTION(film_node_count, 0, FILM), ACTION(film_nodes, 0, FILM),
    ACTION(film_density, 0, FILM), ACTION(film_picture, 0, FILM),
    ACTION(voxels_free, VOXELS, 0), ACTION(voxels_look, 0, VOXELS),
#undef ACTION
};

/* The call that runs: what it changes and looks at, and how often its callback has been asked. */
static struct {
    const char *name;
    int changes, looks, asked;
    bool disturbed, threads;
} outer;
static int busy, fine;

static void *disturb(void *unused)
{
    for (size_t i = 0; i < sizeof actions / sizeof *actions; i++) {
        const struct action *action = &actions[i];
        if (!((action->changes | action->looks) & (outer.changes | outer.looks))) continue;
        const bool refused = (action->changes & (outer.changes | outer.looks)) || (action->looks & outer.changes);
        const int32_t status = action->call();
        if (status != (refused ? COVBEAM_BUSY : COVBEAM_OK)) {
            fprintf(stderr, "in %s: ", outer.name);
            fail(action->name, status);
        }
        if (refused && !strstr(covbeam_last_error(), "busy")) fail(action->name, status);
        *(refused ? &busy : &fine) += 1;
    }
    return unused;
}

static int32_t poll(void *user)
{
    (void)user;
    if (outer.asked++ > 0 || !outer.disturbed) return 0;
    if (outer.threads) {
        pthread_t thread;
        if (pthread_create(&thread, NULL, disturb, NULL) != 0 || pthread_join(thread, NULL) != 0) exit(2);
    } else {
        disturb(NULL);
    }
    return 0;
}

static int32_t shade(void *user, const covbeam_contact *contacts, size_t count, float *values)
{
    (void)contacts;
    for (size_t i = 0; i < 3 * count; i++) values[i] = 1;
    return user ? poll(NULL) : 0;
}

static uint64_t hash;
static void digest(const void *memory, size_t length)
{
    const unsigned char *byte = memory;
    for (size_t i = 0; i < length; i++) hash = (hash ^ byte[i]) * 0x100000001b3u;
}

static void digest_gather(void)
{
    must(GATHER(NULL));
    digest(more, sizeof more);
}

/* The calls that have callbacks, and what becomes of their objects. */
static int32_t by_commit(void)
{
    must(map_clear());
    must(covbeam_beam_map_add(map, 40, beams, sizeof *beams));
    const int32_t status = covbeam_beam_map_commit(map, 0.1f, poll, NULL);
    if (status == COVBEAM_OK) digest_gather();
    return status;
}
static int32_t by_gather(void)
{
    const int32_t status = covbeam_beam_map_gather(map, &kernel, grid, RAYS, rays, sizeof *rays, gathered, sizeof *gathered, scratch,
                                                   poll, NULL);
    digest(gathered, sizeof gathered);
    return status;
}
static int32_t shaded(covbeam_poll asked, void *user)
{
    const int32_t status = covbeam_beam_map_gather_shaded(map, &kernel, grid, RAYS, rays, sizeof *rays, gathered, sizeof *gathered,
                                                          scratch, shade, asked, user);
    digest(gathered, sizeof gathered);
    return status;
}
static int32_t by_shaded_poll(void) { return shaded(poll, NULL); }
static int32_t by_shaded_shade(void) { return shaded(NULL, &outer); }
static int32_t by_plan(void)
{
    const int32_t status = covbeam_film_plan(film, 1, 0.1f, 1, nodes, spectra, sizeof *spectra, poll, NULL);
    must(film_density());
    digest(numbers, sizeof numbers);
    return status;
}
static int32_t by_verify(void)
{
    const int32_t status = covbeam_film_verify(film, poll, NULL);
    must(film_picture());
    digest(pixels, sizeof pixels);
    return status;
}
static int32_t by_deposit(void)
{
    must(grid_clear());
    const int32_t status = covbeam_grid_deposit(grid, &smoke, 1, &segment, 0, poll, NULL);
    must(grid_resolve());
    must(grid_save());
    digest(bytes, sizeof bytes);
    return status;
}

static void furnish(void)
{
    const float densities[VOXEL_COUNT] = { 1, 2, 0.5f, 1, 3, 1, 0, 1 };
    must(covbeam_density_new(&box, densities, sizeof *densities, VOXEL_COUNT, &voxels));
    smoke.struct_size = sizeof smoke;
    for (int i = 0; i < 3; i++) smoke.scattering[i] = 0.2f;
    smoke.density = COVBEAM_DENSITY_VOXELS;
    smoke.voxels = voxels;
    for (int i = 0; i < 40; i++) {
        const covbeam_beam beam = { { 0, (float)i / 40, 0.5f }, { 1, 0, 0 }, 1, { 1, 1, 1 }, { 0, 0, 0 }, { 0, 0, 0 } };
        beams[i] = beam;
    }
    for (int i = 0; i < RAYS; i++) {
        const covbeam_eye_ray ray = { { 0.5f, (float)i / RAYS, -1 }, { 0, 0, 1 }, 3 };
        rays[i] = ray;
    }
    for (uint32_t i = 0; i < PIXELS; i++) {
        const covbeam_film_ray ray = { { i % WIDTH, i / WIDTH }, 1, 0, { 1, (float)i, 1 }, { 0, 0, 0 } };
        seen[i] = ray;
    }
    const float direction[3] = { 0, 0, 1 };
    segment.origin[0] = segment.origin[1] = segment.origin[2] = 0.3f;
    segment.length = 0.5f;
    segment.power = 1;
    must(covbeam_light_field_point(direction, 0.1f, &segment.field));
    must(covbeam_light_field_travel(&segment.field, 0.5f));
    must(covbeam_grid_new(&box, &grid));
    must(covbeam_grid_new(&box, &other_grid));
    must(covbeam_scratch_new(&scratch));
    must(covbeam_beam_map_new(&smoke, &map));
    must(covbeam_film_new(WIDTH, WIDTH, 1, PIXELS, NULL, 0, &film));
    must(covbeam_film_get_node_count(film, &nodes));
    if (nodes > PIXELS) exit(2);
    /* Twice, so that all objects are in the state that most calls want. */
    must(by_deposit());
    must(by_commit());
    must(by_plan());
    must(film_add());
    must(film_plan());
    must(film_verify());
}

int main(void)
{
    static const struct {
        const char *name;
        int32_t (*call)(void);
        int changes, looks;
    } calls[] = {
        { "poll of commit", by_commit, MAP, 0 },
        { "poll of gather", by_gather, SCRATCH, MAP | GRID },
        { "poll of gather_shaded", by_shaded_poll, SCRATCH, MAP | GRID },
        { "shade of gather_shaded", by_shaded_shade, SCRATCH, MAP | GRID },
        { "poll of grid_deposit", by_deposit, GRID, VOXELS },
        { "poll of film_plan", by_plan, FILM, 0 },
        { "poll of film_verify", by_verify, FILM, 0 },
    };
    furnish();
    for (size_t i = 0; i < sizeof calls / sizeof *calls; i++) {
        uint64_t digests[3];
        for (int how = 0; how < 3; how++) {
            outer.name = calls[i].name;
            outer.changes = calls[i].changes;
            outer.looks = calls[i].looks;
            outer.asked = 0;
            outer.disturbed = how > 0;
            outer.threads = how == 2;
            hash = 0xcbf29ce484222325u;
            const int32_t status = calls[i].call();
            if (status != COVBEAM_OK || outer.asked == 0) fail(calls[i].name, status);
            digests[how] = hash;
        }
        if (digests[0] != digests[1] || digests[0] != digests[2]) fail("what was refused shows", COVBEAM_OK);
    }
    /* Busy no more. */
    must(map_clear());
    must(covbeam_beam_map_free(map));
    must(covbeam_grid_free(grid));
    must(covbeam_grid_free(other_grid));
    must(covbeam_scratch_free(scratch));
    must(covbeam_film_free(film));
    must(covbeam_density_free(voxels));
    printf("reentry: %d calls on objects in use are refused, %d that only look work; from callbacks and from other threads\n", busy,
           fine);
    return 0;
}
