#include "elements.h"
#include "pool.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

void may(struct prepared *call, int32_t status) { call->statuses |= 1u << status; }

void must(struct prepared *call, int32_t status) {
    may(call, status);
    call->sure = true;
}

struct buffer memory(size_t count, size_t stride, size_t size, uint32_t misalignment) {
    struct buffer b = { NULL, NULL, NULL, 0, stride, count };
    b.length = count == 0 ? 0 : (count - 1) * stride + size;
    b.memory = malloc(b.length + misalignment);
    if (!b.memory) abort();
    b.first = b.memory + misalignment;
    memset(b.first, 0xa5, b.length);
    return b;
}

/* A table of columns of its own, exactly as long as it says; freed with the call. */
static unsigned char *tables[512];
static size_t table_count;

covbeam_knot *new_table(size_t count, uint32_t misalignment, bool ordered) {
    unsigned char *bytes = malloc(count * sizeof(covbeam_knot) + misalignment);
    if (!bytes || table_count == sizeof tables / sizeof *tables) abort();
    tables[table_count++] = bytes;
    float distance = 0, column = 0;
    for (size_t i = 0; i < count; i++) {
        covbeam_knot knot = { distance, column };
        if (!ordered) knot.distance = hostile_number(below(2) ? 0 : 2);
        memcpy(bytes + misalignment + i * sizeof knot, &knot, sizeof knot);
        distance += uniform(0.01f, 1);
        column += uniform(0, 1);
    }
    return (covbeam_knot *)(void *)(bytes + misalignment);
}

static bool is_segment(const struct type *type) { return is(type, "segment") || is(type, "way"); }

static void sound_edges(covbeam_segment *segment, uint32_t count) {
    float depth = -0.5f;
    segment->edge_count = count;
    for (uint32_t i = 0; i < count; i++) {
        const covbeam_edge edge = { depth += uniform(0, 1), uniform(0, 1), { uniform(-1, 1), 1, 0 } };
        segment->edges[i] = edge;
    }
}

static void spoil_edges(covbeam_segment *segment, uint32_t variant) {
    sound_edges(segment, 3);
    switch (variant % 5) {
    case 0: segment->edge_count = variant % 2 ? 5 : 0xffffffffu; break;
    case 1: segment->edges[2].depth = variant % 2 ? NAN : INFINITY; break;
    case 2: segment->edges[1].depth = segment->edges[0].depth - 1; break;
    case 3: segment->edges[1].distance = variant % 2 ? NAN : -1; break;
    default: segment->edges[2].towards[1] = segment->edges[2].towards[0] = 0;
    }
}

void sound_element(struct prepared *call, const struct parameter *p, unsigned char *at) {
    const struct type *type = p->type;
    uint32_t words[64] = { 0 };
    for (size_t i = 0; i < type->size / 4; i++) {
        const char rule = type->rules[i];
        if (strchr("uvd", rule)) {
            sound_vector(rule, call->tame, words + i);
            i += 2;
        } else if (rule == 'e') {
            words[i] = below(3);
        } else if (rule == 'b') {
            words[i] = below(2);
        } else if (rule == 'i') {
            words[i] = below(9);
        } else if (rule == 'S') {
            words[i] = (uint32_t)type->size;
        } else if (strchr("zF-", rule) == NULL) {
            words[i] = bits_of(sound_number(rule, call->tame));
        }
    }
    if (is(type, "layout")) {
        call->layout = (int)below(4);
        memcpy(words, &layouts[call->layout], sizeof *layouts);
    } else if (is(type, "kernel")) {
        float narrow = float_of(words[2]), wide = float_of(words[3]);
        words[2] = bits_of(fminf(narrow, wide));
        words[3] = bits_of(fmaxf(narrow, wide));
        const int map = call->handles[0];
        if (map >= 0 && pool[map].committed && !chance(4))
            for (int i = 2; i < 4; i++) words[i] = bits_of(fminf(float_of(words[i]), pool[map].max_radius));
    } else if (is(type, "field") || is_segment(type)) {
        memcpy(words + (is(type, "field") ? 0 : 6), &fields[below(16)], sizeof *fields);
    }
    if (is(type, "seen") && call->handles[0] >= 0) {
        words[0] = below(pool[call->handles[0]].width);
        words[1] = below(pool[call->handles[0]].height);
    }
    memcpy(at, words, type->size);
    if (is(type, "medium")) {
        covbeam_medium *medium = (covbeam_medium *)(void *)at;
        if (medium->density == COVBEAM_DENSITY_VOXELS) {
            const struct slot *slot = &pool[pick(DENSITY)];
            medium->voxels = slot->handle;
            if (!slot->handle) medium->density = COVBEAM_DENSITY_UNIFORM;
            if (!slot->tame) call->tame = false;
        }
        call->density_kind = medium->density;
    } else if (is_segment(type)) {
        covbeam_segment *segment = (covbeam_segment *)(void *)at;
        sound_edges(segment, below(COVBEAM_MOST_EDGES + 1));
        if (is(type, "segment") && chance(3)) {
            segment->knot_count = below(4);
            segment->knots = new_table(segment->knot_count, 0, true);
        }
    } else if (is(type, "column")) {
        covbeam_column *column = (covbeam_column *)(void *)at;
        column->knot_count = below(4);
        column->knots = column->knot_count || chance(2) ? new_table(column->knot_count, 0, true) : NULL;
    }
}

/* What is noticed, if a word of an element becomes hostile. */
void spoil_word(struct prepared *call, const struct parameter *p, unsigned char *at, const struct fault *fault) {
    const struct type *type = p->type;
    uint32_t words[64];
    memcpy(words, at, type->size);
    const size_t word = fault->variant % (type->size / 4);
    const char rule = rule_of(type, words, word);
    const float number = hostile_number(fault->number);
    call->tame = false;
    if (p->kind == '=' && is(type, "kernel")) {
        if (word > 0) words[word] = bits_of(number); /* written over */
    } else if (rule == '-' || rule == 'S') {
        /* Pointers are spoiled as INSIDE, sizes as STRUCT_SIZE; numbers that the struct does not need may be anything. */
        if (!strchr("-S", type->rules[word])) words[word] = bits_of(number);
    } else if (rule == 'e' || rule == 'b') {
        words[word] = fault->number % 2 ? 3 : 0xffffffffu;
        call->statuses |= 1u << COVBEAM_INVALID_VALUE;
        call->sure = true;
    } else if (rule == 'z') {
        const uint32_t cells[3] = { 0, 0xffffffffu, 0x01000001u };
        words[word] = cells[fault->number % 3];
        call->statuses |= 1u << COVBEAM_INVALID_VALUE | 1u << COVBEAM_SHORT_BUFFER;
        call->sure = true;
    } else if (rule == 'i') {
        words[word] = fault->number % 2 ? 0xffffffffu : 0;
        call->unsure = true;
    } else {
        words[word] = bits_of(number);
        const bool vector = strchr("uvd", rule) != NULL;
        if (!number_fits(rule, number)) {
            call->statuses |= 1u << COVBEAM_INVALID_VALUE;
            call->sure = true;
        } else if (vector || strchr("Fm", rule) || (is(type, "gathered") && word == 3)) {
            call->unsure = true;
            call->statuses |= 1u << COVBEAM_MISMATCH;
            if (is(type, "layout")) call->statuses |= 1u << COVBEAM_SHORT_BUFFER;
        }
    }
    memcpy(at, words, type->size);
}

void spoil_inside(struct prepared *call, const struct parameter *p, unsigned char *at, uint32_t variant) {
    if (is(p->type, "medium")) {
        covbeam_medium *medium = (covbeam_medium *)(void *)at;
        medium->density = COVBEAM_DENSITY_VOXELS;
        call->density_kind = COVBEAM_DENSITY_VOXELS;
        void *other = pool[pick(variant % 2 ? GRID : MAP)].handle;
        medium->voxels = variant % 3 == 0 || !other ? NULL : other;
        if (variant % 3 == 1 && other) medium->voxels = (covbeam_density *)(void *)((char *)other + 1);
        call->statuses |= !medium->voxels ? 1u << COVBEAM_NULL_POINTER
            : variant % 3 == 1 ? 1u << COVBEAM_MISALIGNED : 1u << COVBEAM_INVALID_HANDLE;
        call->sure = true;
        return;
    }
    if (is_segment(p->type) && (is(p->type, "way") || variant % 8 > 3)) {
        spoil_edges((covbeam_segment *)(void *)at, variant / 8 * 4 + variant % 4);
        must(call, COVBEAM_INVALID_VALUE);
        return;
    }
    const bool segment = is(p->type, "segment");
    if (!segment && !is(p->type, "column")) return;
    const covbeam_knot *knots = NULL;
    size_t count = 3;
    switch (variant % 4) {
    case 0:
        call->statuses |= segment ? 1u << COVBEAM_INVALID_VALUE : 1u << COVBEAM_NULL_POINTER;
        call->sure = true;
        break;
    case 1:
        knots = new_table(3, 1 + variant / 4 % 3, true);
        call->statuses |= 1u << COVBEAM_MISALIGNED;
        call->sure = true;
        break;
    case 2:
        knots = new_table(3, 0, true);
        count = SIZE_MAX / 4 + 2;
        call->statuses |= 1u << COVBEAM_INVALID_ARRAY;
        call->sure = true;
        break;
    default:
        knots = new_table(3, 0, false);
        if (segment) {
            call->statuses |= 1u << COVBEAM_INVALID_VALUE;
            call->sure = true;
        } else {
            call->meaningless = true; /* the order of a column's knots is not checked */
        }
    }
    if (segment) {
        ((covbeam_segment *)(void *)at)->knots = knots;
        ((covbeam_segment *)(void *)at)->knot_count = count;
    } else {
        ((covbeam_column *)(void *)at)->kind = COVBEAM_DENSITY_VOXELS;
        ((covbeam_column *)(void *)at)->knots = knots;
        ((covbeam_column *)(void *)at)->knot_count = count;
    }
}

/* An options struct of another size than the header's. */
struct buffer other_size(struct prepared *call, const struct parameter *p, const unsigned char *element, uint32_t variant) {
    const size_t known = p->type->size;
    size_t says = 0, there = known;
    switch (variant % 6) {
    case 0: break;
    case 1: says = 3; break;
    case 2: says = 1u << 20; break;
    case 3: says = 0xffffffffu; break;
    default: says = there = known + 4 * (1 + variant / 6 % 5); break;
    }
    struct buffer b = memory(1, 0, there, 0);
    memcpy(b.first, element, known);
    if (there > known) memset(b.first + known, 0, there - known);
    if (variant % 6 == 5) b.first[there - 1] = 1;
    uint32_t word = (uint32_t)says;
    memcpy(b.first, &word, 4);
    if (variant % 6 != 4) {
        call->statuses |= 1u << COVBEAM_INVALID_VALUE;
        call->sure = true;
    }
    return b;
}

void free_tables(void) {
    while (table_count > 0) free(tables[--table_count]);
}
