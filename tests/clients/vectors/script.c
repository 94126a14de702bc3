/* The lines of the file, their words, and what the calls have in common. */
#include "calls.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { CHUNK = 1 << 16 };

struct line *lines;
size_t line_count;
long number;
covbeam_density *density;
covbeam_grid *grid;
covbeam_beam_map *map;
covbeam_scratch *scratch;
covbeam_film *film;
covbeam_march *march;
covbeam_importance *importance;

void fail(const char *what)
{
    fprintf(stderr, "line %ld: %s\n", number, what);
    exit(1);
}

void must(covbeam_status status)
{
    if (status != COVBEAM_OK) {
        fprintf(stderr, "line %ld: %s: %s\n", number, covbeam_status_name(status), covbeam_last_error());
        exit(1);
    }
}

void equal(const void *a, const void *b, size_t size, const char *what)
{
    if (memcmp(a, b, size) != 0)
        fail(what);
}

void *memory(size_t size)
{
    void *bytes = malloc(size > 0 ? size : 1);
    if (bytes == NULL)
        fail("no memory");
    return bytes;
}

void take(struct call *c, void *to, size_t words)
{
    size_t i;
    if (c->line->ins - c->next < words)
        fail("too few inputs");
    for (i = 0; i < words; i++) {
        uint32_t word = (uint32_t)c->line->in[c->next++];
        memcpy((char *)to + 4 * i, &word, 4);
    }
}

size_t left(const struct call *c, size_t words)
{
    size_t have = c->line->ins - c->next;
    if (have % words != 0)
        fail("inputs are left over");
    return have / words;
}

float take_float(struct call *c)
{
    float value;
    take(c, &value, 1);
    return value;
}

uint32_t take_u32(struct call *c)
{
    uint32_t value;
    take(c, &value, 1);
    return value;
}

covbeam_medium take_medium(struct call *c)
{
    covbeam_medium medium;
    memset(&medium, 0, sizeof medium);
    medium.struct_size = sizeof medium;
    take(c, medium.scattering, MEDIUM_WORDS);
    medium.voxels = medium.density == COVBEAM_DENSITY_VOXELS ? density : NULL;
    return medium;
}

covbeam_segment take_segment(struct call *c)
{
    covbeam_segment segment;
    memset(&segment, 0, sizeof segment);
    take(c, &segment, SEGMENT_WORDS - 1);
    segment.edge_count = take_u32(c);
    take(c, segment.edges, 5 * segment.edge_count);
    return segment;
}

covbeam_kernel take_kernel(struct call *c)
{
    covbeam_kernel kernel;
    kernel.struct_size = sizeof kernel;
    take(c, &kernel.shape, 4);
    return kernel;
}

void give(struct call *c, const void *from, size_t words)
{
    size_t i;
    c->got = realloc(c->got, c->length + 9 * words + 1);
    if (c->got == NULL)
        fail("no memory");
    for (i = 0; i < words; i++) {
        uint32_t word;
        memcpy(&word, (const char *)from + 4 * i, 4);
        c->length += (size_t)sprintf(c->got + c->length, " %08" PRIx32, word);
    }
}

void give_flag(struct call *c, uint8_t flag)
{
    uint32_t word = flag;
    give(c, &word, 1);
}

void give_long(struct call *c, uint64_t word)
{
    c->got = realloc(c->got, c->length + 18);
    if (c->got == NULL)
        fail("no memory");
    c->length += (size_t)sprintf(c->got + c->length, " %016" PRIx64, word);
}

void *spread(struct call *c, size_t count, size_t words, size_t pad)
{
    size_t i, stride = 4 * words + pad;
    char *array = memory(count * stride);
    memset(array, 0xa5, count * stride);
    for (i = 0; i < count; i++)
        take(c, array + i * stride, words);
    return array;
}

static uint64_t *words(char *text, size_t *count)
{
    uint64_t *all = memory((strlen(text) / 9 + 1) * sizeof *all);
    char *end;
    for (*count = 0; *text != '\0'; text = end) {
        all[*count] = strtoull(text, &end, 16);
        if (end == text || (end - text != 9 && end - text != 17))
            fail("a word has neither 8 nor 16 digits");
        ++*count;
    }
    return all;
}

void read_lines(char *text)
{
    char *at = text, *end;
    for (number = 1; *at != '\0'; number++, at = end + 1) {
        struct line line;
        char *arrow, *space;
        end = strchr(at, '\n');
        if (end == NULL)
            fail("the line has no end");
        *end = '\0';
        if (*at == '#' || *at == '\0')
            continue;
        arrow = strstr(at, " ->");
        if (arrow == NULL)
            fail("no arrow");
        *arrow = '\0';
        line.number = number;
        line.text = arrow + 3;
        line.out = words(arrow + 3, &line.outs);
        space = strchr(at, ' ');
        line.in = words(space != NULL ? space : arrow, &line.ins);
        if (space != NULL)
            *space = '\0';
        line.name = at;
        lines = realloc(lines, (line_count + 1) * sizeof *lines);
        if (lines == NULL)
            fail("no memory");
        lines[line_count++] = line;
    }
}

char *contents(const char *path)
{
    FILE *file = fopen(path, "rb");
    size_t length = 0, got;
    char *text = NULL;
    if (file == NULL) {
        perror(path);
        exit(1);
    }
    do {
        text = realloc(text, length + CHUNK + 1);
        if (text == NULL)
            fail("no memory");
        got = fread(text + length, 1, CHUNK, file);
        length += got;
    } while (got > 0);
    fclose(file);
    text[length] = '\0';
    return text;
}
