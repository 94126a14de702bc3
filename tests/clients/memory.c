/*
 * A host of ordinary size that runs out of memory. Linked as scarce.h says.
 *
 * First every request for memory of a pass through voxels is refused in turn, the first, the second, and so on; hostile.c does
 * that for every function, with objects so small that they fill no buffer. Then the process may have little more memory than
 * it has: 0 to 20 MB in steps of 100 KB. Always a status, never a signal, and what failed works once there is memory.
 */
#include "scarce.h"
#include <covbeam_extra.h>
#include <malloc.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

enum { BEAMS = 100000, RAYS = 65536, FEW_BEAMS = 12000, FEW_RAYS = 600 };

static covbeam_beam beams[BEAMS];
static covbeam_eye_ray rays[RAYS];
static covbeam_gathered gathered[RAYS];
static covbeam_segment segments[8];
static covbeam_medium fog, smoke;
static covbeam_beam_map *map;
static covbeam_grid *grid;
static covbeam_scratch *scratch;
static const covbeam_kernel kernel = { sizeof kernel, COVBEAM_KERNEL_BIWEIGHT, 0.02f, 0.02f, 0.01f };

static void fail(const char *what, int32_t status)
{
    fprintf(stderr, "memory: %s: %s (%s)\n", what, covbeam_status_name(status), covbeam_last_error());
    exit(1);
}

static void must(int32_t status)
{
    if (status != COVBEAM_OK) fail("a call with enough memory", status);
}

static float uniform(void)
{
    static uint64_t state = 1;
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (float)(state >> 40) / 16777216;
}

static void towards(float *direction)
{
    float length = 0;
    for (int i = 0; i < 3; i++) direction[i] = uniform() - 0.5f;
    for (int i = 0; i < 3; i++) length += direction[i] * direction[i];
    for (int i = 0; i < 3; i++) direction[i] /= sqrtf(length);
}

/* In the unit cube, which rays cross side by side. */
static void furnish(void)
{
    const covbeam_grid_layout box = { { 0, 0, 0 }, { 1, 1, 1 }, { 16, 16, 16 } };
    static float densities[16 * 16 * 16];
    for (int i = 0; i < 16 * 16 * 16; i++) densities[i] = uniform();
    fog.struct_size = sizeof fog;
    for (int i = 0; i < 3; i++) fog.scattering[i] = 0.1f;
    smoke = fog;
    smoke.density = COVBEAM_DENSITY_VOXELS;
    covbeam_density *voxels = NULL;
    must(covbeam_density_new(&box, densities, sizeof(float), 16 * 16 * 16, &voxels));
    smoke.voxels = voxels;
    for (int i = 0; i < BEAMS; i++) {
        for (int k = 0; k < 3; k++) beams[i].origin[k] = uniform(), beams[i].power[k] = 1;
        towards(beams[i].direction);
        beams[i].length = 0.4f * uniform() + 0.01f;
    }
    for (int i = 0; i < RAYS; i++) {
        const covbeam_eye_ray ray = { { (float)(i % 256) / 256, (float)(i / 256) / 256, -0.5f }, { 0, 0, 1 }, 2 };
        rays[i] = ray;
    }
    for (int i = 0; i < 8; i++) {
        for (int k = 0; k < 3; k++) segments[i].origin[k] = uniform();
        segments[i].length = 0.5f;
        segments[i].power = 1;
        segments[i].unscattered = 1;
        towards(beams[i].direction);
        must(covbeam_light_field_point(beams[i].direction, 0.1f, &segments[i].field));
        must(covbeam_light_field_travel(&segments[i].field, 0.3f));
    }
    must(covbeam_grid_new(&box, &grid));
}

static int32_t shade(void *user, const covbeam_contact *contacts, size_t count, float *values)
{
    (void)user, (void)contacts;
    for (size_t i = 0; i < 3 * count; i++) values[i] = 1;
    return 0;
}

/* A call, with its kth request for memory refused. */
static int refusals;
#define EVERY_REQUEST(call, unchanged) \
    for (uint64_t k = 1;; k++) { \
        scarce_begin(k); \
        const int32_t status = call; \
        if (!scarce_end()) { \
            if (status != COVBEAM_OK) fail(#call, status); \
            break; \
        } \
        refusals++; \
        if (status != COVBEAM_OUT_OF_MEMORY || !strstr(covbeam_last_error(), " bytes")) fail(#call, status); \
        if (!(unchanged)) fail("changed: " #call, status); \
    }

static size_t count(void)
{
    size_t count = 0;
    must(covbeam_beam_map_get_count(map, &count));
    return count;
}

/* Whether a gather has written. */
static bool written(void)
{
    bool written = false;
    for (int i = 0; i < FEW_RAYS; i++) written |= gathered[i].pairs != UINT32_MAX;
    return written;
}

static bool empty(void)
{
    const covbeam_grid_cell *cells = NULL;
    size_t count = 0, filled = 0;
    must(covbeam_grid_get_cells(grid, &cells, &count));
    for (size_t i = 0; i < count; i++) filled += cells[i].weight != 0;
    return filled == 0;
}

static void refuse(const covbeam_medium *medium)
{
    EVERY_REQUEST(covbeam_beam_map_new(medium, &map), map == NULL)
    EVERY_REQUEST(covbeam_beam_map_add(map, FEW_BEAMS, beams, sizeof *beams), count() == 0)
    EVERY_REQUEST(covbeam_beam_map_commit(map, 0.02f, NULL, NULL),
                  count() == FEW_BEAMS && covbeam_beam_map_add(map, 0, NULL, 0) == COVBEAM_OK)
    for (int own = 0; own < 3; own++) {
        if (own == 1) EVERY_REQUEST(covbeam_scratch_new(&scratch), scratch == NULL)
        memset(gathered, 0xff, sizeof gathered);
        if (own < 2)
            EVERY_REQUEST(covbeam_beam_map_gather(map, &kernel, NULL, FEW_RAYS, rays, sizeof *rays, gathered, sizeof *gathered,
                                                  scratch, NULL, NULL), !written())
        else
            EVERY_REQUEST(covbeam_beam_map_gather_shaded(map, &kernel, NULL, FEW_RAYS, rays, sizeof *rays, gathered,
                                                         sizeof *gathered, NULL, shade, NULL, NULL), !written())
        uint64_t pairs = 0;
        for (int i = 0; i < FEW_RAYS; i++) pairs += gathered[i].pairs;
        if (pairs < 10 * FEW_RAYS) fail("a gather that finds nothing", COVBEAM_OK);
    }
    must(covbeam_scratch_free(scratch));
    must(covbeam_beam_map_free(map));
    map = NULL;
    scratch = NULL;
}

static int32_t few(void *left)
{
    return --*(int *)left < 0;
}

static void allowed(int32_t status, bool *wanted)
{
    if (status == COVBEAM_OUT_OF_MEMORY) *wanted = true;
    else if (status != COVBEAM_OK && status != COVBEAM_CANCELLED) _exit(9);
}

/* What a child with little memory does: 1 if there was too little to gather, and 2 if there was for something else. */
static int starved(void)
{
    bool gather = false, wanted = false;
    int left = 10;
    covbeam_beam_map *other = NULL;
    covbeam_grid *merged = NULL;
    const covbeam_grid_layout layout = { { 0, 0, 0 }, { 1, 1, 1 }, { 32, 32, 32 } };
    allowed(covbeam_beam_map_gather(map, &kernel, NULL, RAYS, rays, sizeof *rays, gathered, sizeof *gathered, NULL, few, &left),
            &gather);
    allowed(covbeam_grid_new(&layout, &merged), &wanted);
    if (merged) allowed(covbeam_grid_resolve(merged), &wanted);
    allowed(covbeam_grid_deposit(grid, &smoke, 8, segments, sizeof *segments, NULL, NULL), &wanted);
    allowed(covbeam_beam_map_new(&smoke, &other), &wanted);
    if (other) {
        allowed(covbeam_beam_map_add(other, BEAMS, beams, sizeof *beams), &wanted);
        left = 40;
        allowed(covbeam_beam_map_commit(other, 0.02f, few, &left), &wanted);
    }
    return gather + 2 * wanted;
}

static void limit(void)
{
    int ended[4] = { 0 };
    must(covbeam_beam_map_new(&fog, &map));
    must(covbeam_beam_map_add(map, BEAMS, beams, sizeof *beams));
    must(covbeam_beam_map_commit(map, 0.02f, NULL, NULL));
    /* What the C library keeps of what was freed is given back: it would be had without asking. */
    malloc_trim(0);
    for (unsigned more = 0; more <= 20000; more += 100) {
        const pid_t child = fork();
        if (child < 0) fail("fork", COVBEAM_OK);
        if (child == 0) {
            /* The stack is not to grow into what is left. */
            volatile unsigned char stack[1 << 18];
            for (size_t i = 0; i < sizeof stack; i += 1024) stack[i] = 0;
            unsigned long pages = 0;
            FILE *file = fopen("/proc/self/statm", "r");
            if (!file || fscanf(file, "%lu", &pages) != 1) _exit(10);
            fclose(file);
            const rlim_t bytes = (rlim_t)pages * (rlim_t)sysconf(_SC_PAGESIZE) + more * 1000u;
            const struct rlimit most = { bytes, bytes };
            if (setrlimit(RLIMIT_AS, &most) != 0) _exit(11);
            _exit(starved());
        }
        int status;
        if (waitpid(child, &status, 0) != child) fail("waitpid", COVBEAM_OK);
        if (!WIFEXITED(status) || WEXITSTATUS(status) > 3) {
            fprintf(stderr, "memory: with %u KB more, the process ended with %s %d\n", more,
                    WIFEXITED(status) ? "exit status" : "signal", WIFEXITED(status) ? WEXITSTATUS(status) : WTERMSIG(status));
            exit(1);
        }
        ended[WEXITSTATUS(status)]++;
    }
    if (ended[1] + ended[3] == 0 || ended[0] + ended[2] == 0) fail("limits all too low, or none", COVBEAM_OK);
    printf("memory: %d limits of 0 to 20 MB more: a status each, %d of them too low to gather, %d for another map\n",
           ended[0] + ended[1] + ended[2] + ended[3], ended[1] + ended[3], ended[2] + ended[3]);
    must(covbeam_beam_map_free(map));
}

int main(void)
{
    const int64_t before = scarce_live;
    /* Left to itself the C library keeps ever larger pieces of what was freed, between others where no trim takes them. */
    if (!mallopt(M_MMAP_THRESHOLD, 1 << 17)) fail("mallopt", COVBEAM_OK);
    furnish();
    refuse(&fog);
    refuse(&smoke);
    EVERY_REQUEST(covbeam_grid_deposit(grid, &smoke, 8, segments, sizeof *segments, NULL, NULL), empty())
    printf("memory: %d requests refused in a pass of %d beams and %d rays, twice\n", refusals, FEW_BEAMS, FEW_RAYS);
    limit();
    must(covbeam_grid_free(grid));
    must(covbeam_density_free((covbeam_density *)smoke.voxels));
    /* What the C library keeps: the buffer of the output. */
    if (scarce_live - before > 1) fail("memory is lost", COVBEAM_OK);
    return 0;
}
