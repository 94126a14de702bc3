/* Where shadow rays go along eye rays. */
#include "calls.h"

#include <stdlib.h>
#include <string.h>

void march_lay(struct call *c)
{
    float origin[3], direction[3], stretch[2], light[3];
    size_t i, count;
    struct padded {
        covbeam_march_knot knot;
        uint32_t pad;
    } *knots;
    take(c, origin, 3);
    take(c, direction, 3);
    take(c, stretch, 2);
    take(c, light, 3);
    count = take_u32(c);
    knots = memory(count * sizeof *knots);
    must(covbeam_march_lay(origin, direction, stretch[0], stretch[1], light, count, &knots[0].knot, sizeof *knots));
    for (i = 0; i < count; i++) {
        const covbeam_march_knot *knot = &knots[i].knot;
        give(c, &knot->distance, 1);
        if (knot->radiance != 0 || !(knot->deviation != knot->deviation) || !(knot->visibility != knot->visibility))
            fail("covbeam_march_lay: a knot that is not dark, or knows something");
    }
    free(knots);
}

void march_update(struct call *c)
{
    size_t count = left(c, 4);
    covbeam_march_knot *knots = spread(c, count, 4, 8);
    if (march == NULL)
        must(covbeam_march_new(&march));
    must(covbeam_march_update(march, count, knots, sizeof *knots + 8));
    free(knots);
}

void march_get_expected(struct call *c)
{
    covbeam_march_expected expected;
    must(covbeam_march_get_expected(march, &expected));
    give(c, &expected, 2);
}

void march_get_first_round(struct call *c)
{
    size_t first;
    uint32_t word;
    must(covbeam_march_get_first_round(march, take_u32(c), &first));
    word = (uint32_t)first;
    give(c, &word, 1);
}

static void give_samples(struct call *c, const covbeam_march_sample *samples, size_t count, size_t stride)
{
    size_t i;
    for (i = 0; i < count; i++)
        give(c, (const char *)samples + i * stride, 6);
}

void march_place(struct call *c)
{
    size_t count = left(c, 1), stride = sizeof(covbeam_march_sample) + 8;
    float *jitters = spread(c, count, 1, 4);
    covbeam_march_sample *samples = memory(count * stride);
    must(covbeam_march_place(march, count, jitters, 8, samples, stride));
    give_samples(c, samples, count, stride);
    free(jitters);
    free(samples);
}

void march_refine(struct call *c)
{
    size_t first_count = take_u32(c), stride = sizeof(covbeam_march_sample) + 8, count;
    covbeam_march_sample *firsts = spread(c, first_count, 6, 8), *samples;
    float *jitters;
    count = left(c, 1);
    jitters = spread(c, count, 1, 4);
    samples = memory(count * stride);
    must(covbeam_march_refine(march, first_count, firsts, stride, count, jitters, 8, samples, stride));
    give_samples(c, samples, count, stride);
    free(firsts);
    free(jitters);
    free(samples);
}
