/* The functions on arrays: all lines of a name at once, in padded arrays. */
#include "calls.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_ARRAYS = 6 };

/* Plurals: where a line has the elements of each array, and the call. */
struct array {
    int in, out; /* first word among the inputs, the outputs; -1 if not there */
    int words;   /* 0: a byte */
};

enum common { NONE, PHASE, MEDIUM };

struct plural {
    const char *name;
    enum common common; /* what all elements share, and where it is */
    int at;
    struct array arrays[MOST_ARRAYS];
    covbeam_status (*run)(size_t n, const void *common, void **p, const size_t *s);
};

#define MANY(name, arguments)                                                                  \
    static covbeam_status many_##name(size_t n, const void *common, void **p, const size_t *s) \
    {                                                                                          \
        (void)common;                                                                          \
        return covbeam_##name arguments;                                                       \
    }
#define A1 p[0], s[0]
#define A2 A1, p[1], s[1]
#define A3 A2, p[2], s[2]
#define A4 A3, p[3], s[3]
#define A5 A4, p[4], s[4]
MANY(light_fields_point, (n, A3))
MANY(light_fields_disk, (n, A5))
MANY(light_fields_collimated, (n, A3))
MANY(light_fields_gaussian, (n, A5))
MANY(light_fields_travel, (n, A2))
MANY(light_fields_carry, (n, A1, common, p[1], s[1], p[2], s[2]))
MANY(light_fields_rotate, (n, A2))
MANY(light_fields_reflect, (n, A3))
MANY(light_fields_refract, (n, A5))
MANY(light_fields_occlude, (n, A3))
MANY(light_fields_attenuate, (n, A3))
MANY(light_fields_narrow, (n, A3))
MANY(light_fields_scatter, (n, A3))
MANY(light_fields_diffuse, (n, A3))
MANY(light_fields_slice, (n, A2))
MANY(light_fields_fluence, (n, A3))
MANY(light_fields_variance_along_ray, (n, A3))
MANY(spectra_variance_along, (n, A3))
MANY(spectra_add_along, (n, A3))
MANY(image_spectra_filter, (n, A4))
MANY(image_filters_density, (n, A2))
MANY(phase_evaluate_many, (common, n, A2))
MANY(phase_sample_many, (common, n, A3))
MANY(phase_sample_cosine_many, (common, n, A2))
MANY(medium_density_at_many, (common, n, A2))
MANY(medium_derivatives_at_many, (common, n, A2))
MANY(medium_column_at_many, (common, n, A4))
MANY(medium_distance_at_many, (common, n, A5))
MANY(medium_transmittance_many, (common, n, A4))
MANY(medium_column_transmittance_many, (common, n, A2))
MANY(medium_reach_many, (common, n, A3))

#define F { 0, 0, 16 }
static const struct plural plurals[] = {
    { "light_field_point", NONE, 0, { { 0, -1, 3 }, { 3, -1, 1 }, { -1, 0, 16 } }, many_light_fields_point },
    { "light_field_disk", NONE, 0, { { 0, -1, 3 }, { 3, -1, 3 }, { 6, -1, 1 }, { 7, -1, 1 }, { -1, 0, 16 } },
      many_light_fields_disk },
    { "light_field_collimated", NONE, 0, { { 0, -1, 3 }, { 3, -1, 1 }, { -1, 0, 16 } },
      many_light_fields_collimated },
    { "light_field_gaussian", NONE, 0, { { 0, -1, 3 }, { 3, -1, 3 }, { 6, -1, 2 }, { 8, -1, 2 }, { -1, 0, 16 } },
      many_light_fields_gaussian },
    { "light_field_travel", NONE, 0, { F, { 16, -1, 1 } }, many_light_fields_travel },
    { "light_field_carry", MEDIUM, 16, { F, { 32, -1, 3 }, { 35, -1, 1 } }, many_light_fields_carry },
    { "light_field_rotate", NONE, 0, { F, { 16, -1, 3 } }, many_light_fields_rotate },
    { "light_field_reflect", NONE, 0, { F, { 16, -1, 3 }, { 19, -1, 6 } }, many_light_fields_reflect },
    { "light_field_refract", NONE, 0, { { 0, 1, 16 }, { 16, -1, 3 }, { 19, -1, 6 }, { 25, -1, 1 }, { -1, 0, 0 } },
      many_light_fields_refract },
    { "light_field_occlude", NONE, 0, { F, { 16, -1, 3 }, { 19, -1, 1 } }, many_light_fields_occlude },
    { "light_field_attenuate", NONE, 0, { F, { 16, -1, 3 }, { 19, -1, 6 } }, many_light_fields_attenuate },
    { "light_field_narrow", NONE, 0, { F, { 16, -1, 3 }, { 19, -1, 1 } }, many_light_fields_narrow },
    { "light_field_scatter", NONE, 0, { F, { 16, -1, 3 }, { 19, -1, 1 } }, many_light_fields_scatter },
    { "light_field_diffuse", NONE, 0, { F, { 16, -1, 3 }, { 19, -1, 3 } }, many_light_fields_diffuse },
    { "light_field_slice", NONE, 0, { { 0, -1, 16 }, { -1, 0, 3 } }, many_light_fields_slice },
    { "light_field_fluence", NONE, 0, { { 0, -1, 16 }, { 16, -1, 1 }, { -1, 0, 6 } }, many_light_fields_fluence },
    { "light_field_variance_along_ray", NONE, 0, { { 0, -1, 16 }, { 16, -1, 1 }, { -1, 0, 1 } },
      many_light_fields_variance_along_ray },
    { "spectrum_variance_along", NONE, 0, { { 0, -1, 6 }, { 6, -1, 3 }, { -1, 0, 1 } },
      many_spectra_variance_along },
    { "spectrum_add_along", NONE, 0, { { 0, 0, 6 }, { 6, -1, 3 }, { 9, -1, 1 } }, many_spectra_add_along },
    { "image_spectrum_filter", NONE, 0, { { 0, -1, 4 }, { 4, -1, 1 }, { 5, -1, 1 }, { -1, 0, 3 } },
      many_image_spectra_filter },
    { "image_filter_density", NONE, 0, { { 0, -1, 3 }, { -1, 0, 1 } }, many_image_filters_density },
    { "phase_evaluate", PHASE, 0, { { 2, -1, 1 }, { -1, 0, 1 } }, many_phase_evaluate_many },
    { "phase_sample", PHASE, 0, { { 2, -1, 3 }, { 5, -1, 2 }, { -1, 0, 3 } }, many_phase_sample_many },
    { "phase_sample_cosine", PHASE, 0, { { 2, -1, 1 }, { -1, 0, 1 } }, many_phase_sample_cosine_many },
    { "medium_density_at", MEDIUM, 0, { { 16, -1, 3 }, { -1, 0, 1 } }, many_medium_density_at_many },
    { "medium_derivatives_at", MEDIUM, 0, { { 16, -1, 3 }, { -1, 0, 9 } }, many_medium_derivatives_at_many },
    { "medium_column_at", MEDIUM, 0, { { 16, -1, 3 }, { 19, -1, 3 }, { 22, -1, 1 }, { -1, 0, 1 } },
      many_medium_column_at_many },
    { "medium_distance_at", MEDIUM, 0,
      { { 16, -1, 3 }, { 19, -1, 3 }, { 22, -1, 1 }, { 23, -1, 1 }, { -1, 0, 1 } }, many_medium_distance_at_many },
    { "medium_transmittance", MEDIUM, 0, { { 16, -1, 3 }, { 19, -1, 3 }, { 22, -1, 1 }, { -1, 0, 3 } },
      many_medium_transmittance_many },
    { "medium_column_transmittance", MEDIUM, 0, { { 16, -1, 1 }, { -1, 0, 3 } },
      many_medium_column_transmittance_many },
    { "medium_reach", MEDIUM, 0, { { 16, -1, 3 }, { 19, -1, 3 }, { -1, 0, 1 } }, many_medium_reach_many },
};
enum { PLURALS = sizeof plurals / sizeof plurals[0] };

/* Lines that wait for their plural. */
static struct {
    const struct line **lines;
    size_t count;
} waiting[PLURALS];
size_t plural_calls, plural_elements;

/* Whether `i` is an array of the call: those in use have words, or are a byte among the outputs. */
static int in_use(const struct array *a)
{
    return a->words > 0 || (a->words == 0 && a->in < 0 && a->out == 0);
}

static void flush(size_t which)
{
    const struct plural *plural = &plurals[which];
    const struct line **all = waiting[which].lines;
    size_t n = waiting[which].count, k, i, w, stride[MOST_ARRAYS];
    void *arrays[MOST_ARRAYS];
    union {
        covbeam_phase phase;
        covbeam_medium medium;
    } common;
    if (n == 0)
        return;
    number = all[0]->number;
    memset(&common, 0, sizeof common);
    {
        struct call first = { NULL, 0, NULL, 0 };
        first.line = all[0];
        first.next = (size_t)plural->at;
        if (plural->common == PHASE)
            take(&first, &common.phase, PHASE_WORDS);
        else if (plural->common == MEDIUM)
            common.medium = take_medium(&first);
    }
    for (k = 0; k < MOST_ARRAYS; k++) {
        const struct array *a = &plural->arrays[k];
        size_t size = a->words > 0 ? 4 * (size_t)a->words : 1;
        stride[k] = a->words > 0 ? size + 4 * (k + 1) : 3;
        arrays[k] = memory(n * stride[k]);
        memset(arrays[k], 0xa5, n * stride[k]);
        if (in_use(a) && a->in >= 0)
            for (i = 0; i < n; i++) {
                struct call element = { NULL, 0, NULL, 0 };
                element.line = all[i];
                element.next = (size_t)a->in;
                take(&element, (char *)arrays[k] + i * stride[k], (size_t)a->words);
            }
    }
    must(plural->run(n, &common, arrays, stride));
    for (k = 0; k < MOST_ARRAYS; k++) {
        const struct array *a = &plural->arrays[k];
        for (i = 0; in_use(a) && a->out >= 0 && i < n; i++) {
            const unsigned char *element = (unsigned char *)arrays[k] + i * stride[k];
            size_t size = a->words > 0 ? 4 * (size_t)a->words : 1;
            number = all[i]->number;
            for (w = 0; 4 * w < size; w++) {
                uint32_t expected = (uint32_t)all[i]->out[(size_t)a->out + w], found = element[0];
                if (a->words > 0)
                    memcpy(&found, element + 4 * w, 4);
                if (found != expected) {
                    fprintf(stderr, "line %ld: the plural of %s gives word %lu as %08" PRIx32 " instead of %08" PRIx32 "\n",
                            number, plural->name, (unsigned long)((size_t)a->out + w), found, expected);
                    exit(1);
                }
            }
            for (w = size; w < stride[k]; w++)
                if (element[w] != 0xa5)
                    fail("a plural writes between the elements");
        }
        free(arrays[k]);
    }
    plural_calls++;
    plural_elements += n;
    waiting[which].count = 0;
}

void wait_for_plural(const struct line *line)
{
    size_t which;
    for (which = 0; which < PLURALS; which++) {
        const struct plural *plural = &plurals[which];
        size_t n = waiting[which].count;
        size_t words = plural->common == PHASE ? PHASE_WORDS : plural->common == MEDIUM ? MEDIUM_WORDS : 0;
        if (strcmp(plural->name, line->name) != 0)
            continue;
        if (n > 0 && memcmp(waiting[which].lines[n - 1]->in + plural->at, line->in + plural->at,
                            words * sizeof *line->in) != 0) {
            flush(which);
            n = 0;
        }
        waiting[which].lines = realloc(waiting[which].lines, (n + 1) * sizeof *waiting[which].lines);
        if (waiting[which].lines == NULL)
            fail("no memory");
        waiting[which].lines[n] = line;
        waiting[which].count = n + 1;
    }
}

void flush_media(void)
{
    size_t i;
    for (i = 0; i < PLURALS; i++)
        if (plurals[i].common == MEDIUM)
            flush(i);
}

void flush_all(void)
{
    size_t i;
    for (i = 0; i < PLURALS; i++) {
        flush(i);
        free(waiting[i].lines);
        waiting[i].lines = NULL;
    }
}
