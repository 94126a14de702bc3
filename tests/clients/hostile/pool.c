#include "pool.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct slot pool[SLOTS];
covbeam_light_field fields[16];
unsigned char *saved;
size_t saved_size;

const covbeam_grid_layout layouts[4] = {
    { { 0, 0, 0 }, { 1, 1, 1 }, { 2, 3, 2 } },
    { { 0, 0, 0 }, { 1, 1, 1 }, { 1, 1, 1 } },
    { { -1, -1, -1 }, { 2, 1, 3 }, { 3, 3, 3 } },
    { { 0.25f, 0, 0 }, { 0.5f, 4, 1 }, { 1, 9, 2 } },
};

size_t layout_cells(const covbeam_grid_layout *layout) {
    const uint32_t *cells = layout->cells;
    return (size_t)cells[0] * cells[1] * cells[2];
}

enum kind kind_named(const char *name) {
    static const char *const names[KINDS] = { "grid", "map", "density", "scratch", "picture", "march",
                                              "importance" };
    for (int kind = 0; kind < KINDS; kind++)
        if (strcmp(names[kind], name) == 0) return (enum kind)kind;
    fprintf(stderr, "calls.h: no kind of handle is called %s\n", name);
    exit(2);
}

int pick(enum kind kind) {
    int found[SLOTS], count = 0;
    for (int i = 0; i < SLOTS; i++)
        if (pool[i].kind == kind) found[count++] = i;
    return found[below((uint32_t)count)];
}

void pool_start(void) {
    static const enum kind kinds[SLOTS] = { GRID, GRID, GRID, GRID, MAP, MAP, MAP, DENSITY, DENSITY, SCRATCH, SCRATCH,
                                           PICTURE, PICTURE, MARCH, MARCH, IMPORTANCE, IMPORTANCE, IMPORTANCE };
    for (int i = 0; i < SLOTS; i++) {
        memset(&pool[i], 0, sizeof pool[i]);
        pool[i].kind = kinds[i];
        pool[i].tame = true;
    }
    for (int i = 0; i < 16; i++) {
        const float direction[3] = { uniform(-1, 1), uniform(-1, 1), 0.5f };
        if (covbeam_light_field_disk(direction, direction, uniform(0, 1), uniform(0, 9), &fields[i]) != COVBEAM_OK) abort();
    }
}

void slot_free(struct slot *slot) {
    switch (slot->kind) {
    case GRID: covbeam_grid_free(slot->handle); break;
    case MAP: covbeam_beam_map_free(slot->handle); break;
    case DENSITY: covbeam_density_free(slot->handle); break;
    case PICTURE: covbeam_film_free(slot->handle); break;
    case MARCH: covbeam_march_free(slot->handle); break;
    case IMPORTANCE: covbeam_importance_free(slot->handle); break;
    default: covbeam_scratch_free(slot->handle); break;
    }
    free(slot->cells);
    free(slot->means);
    slot->handle = NULL;
    slot->cells = NULL;
    slot->means = NULL;
}

void pool_end(void) {
    for (int i = 0; i < SLOTS; i++) slot_free(&pool[i]);
    free(saved);
    saved = NULL;
    saved_size = 0;
}

/* The host may write into its own memory. */
void scribble(struct slot *slot) {
    if (!slot->cells) return;
    size_t cell = below((uint32_t)layout_cells(&slot->layout));
    uint64_t bits = chance(2) ? draw() : 0x7ff8000000000000u;
    if (chance(2))
        memcpy((unsigned char *)&slot->cells[cell] + 8 * below(7), &bits, 8);
    else
        memcpy((unsigned char *)&slot->means[cell] + 4 * below(7), (unsigned char *)&bits + 4, 4);
    slot->scribbled = true;
    slot->tame = false;
}

static uint64_t hash(uint64_t state, const void *bytes, size_t size) {
    const unsigned char *byte = bytes;
    for (size_t i = 0; i < size; i++) state = (state ^ byte[i]) * 0x100000001b3u;
    return state;
}

static uint64_t grid_digest(const struct slot *slot) {
    uint64_t state = 0xcbf29ce484222325u;
    covbeam_grid_layout layout;
    const covbeam_grid_cell *cells = NULL;
    const covbeam_fluence_cell *means = NULL;
    size_t count = 0, size = 0;
    int32_t status = covbeam_grid_get_layout(slot->handle, &layout);
    status |= covbeam_grid_get_cells(slot->handle, &cells, &count);
    status |= covbeam_grid_get_saved_size(slot->handle, &size);
    if (status != COVBEAM_OK) abort();
    state = hash(state, &layout, sizeof layout);
    state = hash(state, &size, sizeof size);
    state = hash(state, cells, count * sizeof *cells);
    status = covbeam_grid_get_means(slot->handle, &means, &count);
    state = hash(state, &status, sizeof status);
    return status == COVBEAM_OK ? hash(state, means, count * sizeof *means) : state;
}

static uint64_t map_digest(const struct slot *slot) {
    size_t count = 0, bytes = 0;
    if (covbeam_beam_map_get_count(slot->handle, &count) != COVBEAM_OK) abort();
    uint64_t state = hash(0xcbf29ce484222325u, &count, sizeof count);
    /* Any max_radius above that of the commit would be refused, which is a state too. */
    const float widest = slot->committed ? slot->max_radius : 1;
    const covbeam_kernel kernel = { sizeof kernel, COVBEAM_KERNEL_BIWEIGHT, widest, widest, 0.1f };
    const covbeam_eye_ray probes[2] = { { { 0.5f, 0.5f, -1 }, { 0, 0, 1 }, 9 }, { { -1, 0.3f, 0.4f }, { 1, 0, 0 }, 3 } };
    covbeam_gathered gathered[2];
    memset(gathered, 0, sizeof gathered);
    int32_t status = covbeam_beam_map_gather(slot->handle, &kernel, NULL, 2, probes, sizeof *probes, gathered,
                                             sizeof *gathered, NULL, NULL, NULL);
    if (slot->committed && covbeam_beam_map_get_memory(slot->handle, &bytes) != COVBEAM_OK) abort();
    state = hash(state, &status, sizeof status);
    state = hash(state, &bytes, sizeof bytes);
    return hash(state, gathered, sizeof gathered);
}

static uint64_t density_digest(const struct slot *slot) {
    covbeam_medium medium;
    memset(&medium, 0, sizeof medium);
    medium.struct_size = sizeof medium;
    medium.density = COVBEAM_DENSITY_VOXELS;
    medium.voxels = slot->handle;
    const float points[3][3] = { { 0.5f, 0.5f, 0.5f }, { 0.3f, 0.1f, 0.9f }, { 0, 0, 0 } };
    float densities[3];
    if (covbeam_medium_density_at_many(&medium, 3, points[0], sizeof *points, densities, 4) != COVBEAM_OK) abort();
    return hash(0xcbf29ce484222325u, densities, sizeof densities);
}

static uint64_t picture_digest(const struct slot *slot) {
    const size_t count = (size_t)slot->width * slot->height;
    /* A large picture would take most of the time of all calls: of it, whether there is one. */
    const size_t shown = count > 12 ? 0 : count;
    size_t bytes = 0;
    float densities[81];
    covbeam_film_pixel pixels[12];
    memset(densities, 0, sizeof densities);
    memset(pixels, 0, sizeof pixels);
    if (count > 81 || covbeam_film_get_memory(slot->handle, &bytes) != COVBEAM_OK) abort();
    const int32_t statuses[2] = { covbeam_film_density(slot->handle, count, densities, 4),
                                  covbeam_film_picture(slot->handle, 0, shown, pixels, sizeof *pixels) };
    if ((statuses[0] == COVBEAM_OK) != slot->resolved || (statuses[1] == COVBEAM_OK) != slot->committed) abort();
    uint64_t state = hash(0xcbf29ce484222325u, &bytes, sizeof bytes);
    state = hash(state, densities, sizeof densities);
    return hash(state, pixels, sizeof pixels);
}

static uint64_t march_digest(const struct slot *slot) {
    covbeam_march_expected expected = { 0, 0 };
    int32_t status = covbeam_march_get_expected(slot->handle, &expected);
    if ((status == COVBEAM_OK) != slot->resolved) abort();
    return hash(0xcbf29ce484222325u, &expected, sizeof expected);
}

static uint64_t importance_digest(const struct slot *slot) {
    const float points[3][3] = { { 0.5f, 0.5f, 0.5f }, { 0.3f, 0.1f, 0.9f }, { 9, 9, 9 } };
    covbeam_importance_cell cells[3];
    memset(cells, 0, sizeof cells);
    int32_t status = covbeam_importance_at(slot->handle, 3, points[0], sizeof *points, cells, sizeof *cells);
    if ((status == COVBEAM_OK) != slot->resolved) abort();
    return hash(0xcbf29ce484222325u, cells, sizeof cells);
}

uint64_t digest(const struct slot *slot) {
    if (!slot->handle) return 0;
    switch (slot->kind) {
    case GRID: return grid_digest(slot);
    case MAP: return map_digest(slot);
    case DENSITY: return density_digest(slot);
    case PICTURE: return picture_digest(slot);
    case MARCH: return march_digest(slot);
    case IMPORTANCE: return importance_digest(slot);
    default: return 1;
    }
}
