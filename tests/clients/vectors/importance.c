/* Importance in voxels, and what follows from it for light paths. */
#include "calls.h"

#include <stdlib.h>
#include <string.h>

/* A piece of a path and its weight, as they stand side by side in a line. */
struct weighted {
    covbeam_eye_ray ray;
    float weight;
};

/* What the lines have added since the last resolve, once more: to be merged. */
static covbeam_importance *again;

void importance_new(struct call *c)
{
    covbeam_grid_layout layout;
    take(c, &layout, 9);
    covbeam_importance_free(importance);
    must(covbeam_importance_new(&layout, &importance));
    must(covbeam_importance_new(&layout, &again));
}

typedef covbeam_status add_rays(covbeam_importance *, const covbeam_medium *, size_t, const covbeam_eye_ray *, size_t,
    const float *, size_t);

/* To both, with one of the two functions that take pieces of paths. */
static void add_to_both(struct call *c, add_rays *add)
{
    const covbeam_medium medium = take_medium(c);
    const size_t count = left(c, 8), size = sizeof(struct weighted);
    struct weighted *all = spread(c, count, 8, 0);
    must(add(importance, &medium, count, &all->ray, size, &all->weight, size));
    must(add(again, &medium, count, &all->ray, size, &all->weight, size));
    free(all);
}

void importance_add_eye_rays(struct call *c)
{
    add_to_both(c, covbeam_importance_add_eye_rays);
}

void importance_add_paths(struct call *c)
{
    add_to_both(c, covbeam_importance_add_paths);
}

void importance_add_surfaces(struct call *c)
{
    const size_t count = left(c, 4);
    float *all = spread(c, count, 4, 0);
    must(covbeam_importance_add_surfaces(importance, count, all, 16, all + 3, 16));
    must(covbeam_importance_add_surfaces(again, count, all, 16, all + 3, 16));
    free(all);
}

void importance_resolve(struct call *c)
{
    const covbeam_importance *others[1];
    covbeam_importance_cell twice, once;
    const float middle[3] = { 0, 0, 0 };
    (void)c;
    /* Merged with itself it is twice as much. */
    others[0] = importance;
    must(covbeam_importance_merge(again, others, 1));
    must(covbeam_importance_resolve(again));
    must(covbeam_importance_at(again, 1, middle, 0, &twice, 0));
    covbeam_importance_free(again);
    must(covbeam_importance_resolve(importance));
    must(covbeam_importance_at(importance, 1, middle, 0, &once, 0));
    once.beam *= 2;
    once.scattered *= 2;
    once.surface *= 2;
    equal(&twice, &once, sizeof once, "covbeam_importance_merge: other sums");
}

void importance_at(struct call *c)
{
    size_t i, count = left(c, 3);
    float *positions = spread(c, count, 3, 4);
    struct padded {
        covbeam_importance_cell cell;
        uint32_t pad;
    } *cells = memory(count * sizeof *cells);
    must(covbeam_importance_at(importance, count, positions, 16, &cells[0].cell, sizeof *cells));
    for (i = 0; i < count; i++)
        give(c, &cells[i].cell, 3);
    free(positions);
    free(cells);
}

void importance_of_segments(struct call *c)
{
    const covbeam_medium medium = take_medium(c);
    const size_t count = left(c, 7);
    covbeam_eye_ray *segments = spread(c, count, 7, 0);
    covbeam_segment_importance *worths = memory(count * sizeof *worths);
    must(covbeam_importance_of_segments(importance, &medium, count, segments, sizeof *segments, worths, sizeof *worths));
    give(c, worths, 3 * count);
    free(segments);
    free(worths);
}

void weight_window(struct call *c)
{
    size_t i, count = left(c, 1) - 1;
    float *factors = spread(c, count, 1, 8), u = take_float(c);
    must(covbeam_weight_window(count, factors, 12, u));
    for (i = 0; i < count; i++)
        give(c, factors + 3 * i, 1);
    free(factors);
}

void emission_guide_fill(struct call *c)
{
    const uint32_t side = take_u32(c);
    const size_t cells = (size_t)side * side;
    float *weights = spread(c, cells, 1, 0), *guide = memory(4 * (cells + side)), even = take_float(c);
    must(covbeam_emission_guide_fill(side, weights, cells, even, guide, cells + side));
    give(c, guide, cells + side);
    free(weights);
    free(guide);
}

void emission_guide_warp(struct call *c)
{
    const uint32_t side = take_u32(c);
    const size_t numbers = (size_t)side * (side + 1);
    float *guide = spread(c, numbers, 1, 0);
    const size_t count = left(c, 2);
    float *points = spread(c, count, 2, 4), *warped = memory(12 * count);
    must(covbeam_emission_guide_warp(side, guide, numbers, count, points, 12, warped, 12, warped + 2, 12));
    give(c, warped, 3 * count);
    free(guide);
    free(points);
    free(warped);
}
