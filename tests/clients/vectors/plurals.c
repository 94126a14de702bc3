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

static const struct plural plurals[] = { PLAIN_PLURALS };
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
