#include "spoil.h"
#include "../hostile/types.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct call call;
struct polls polls;
int faulty, variant, limits[16];
uint64_t seed, calls;

static int argument;

void fail(const char *what, int32_t status) {
    fprintf(stderr, "hostile_session: seed %llu, call %llu, %s, argument %d, variant %d: %s: %s (%s)\n", (unsigned long long)seed,
            (unsigned long long)calls, call.name, faulty, variant, what, covbeam_status_name(status), covbeam_last_error());
    exit(1);
}

void may(int32_t status) { call.statuses |= 1u << status; }

void must(int32_t status) {
    may(status);
    call.sure = true;
}

/* Memory of the call, to the byte as long as it may use it. */
static struct block {
    unsigned char *memory, *before;
    size_t size;
    bool is_output;
} blocks[64];
static int block_count;

void *block(const void *bytes, size_t size, size_t misalignment, bool is_output) {
    struct block *b = &blocks[block_count++];
    b->memory = malloc(size + misalignment);
    b->before = malloc(size + misalignment);
    b->size = size + misalignment;
    b->is_output = is_output;
    if (block_count == 64 || !b->memory || !b->before) abort();
    memset(b->memory, 0xa5, b->size);
    if (bytes && size > 0) memcpy(b->memory + misalignment, bytes, size);
    memcpy(b->before, b->memory, b->size);
    return b->memory + misalignment;
}

void spoiled(void) {
    const struct block *b = &blocks[block_count - 1];
    memcpy(b->before, b->memory, b->size);
}

void free_blocks(int32_t status) {
    for (; block_count > 0; block_count--) {
        struct block *b = &blocks[block_count - 1];
        const bool partial = status == COVBEAM_SHORT_BUFFER && strcmp(call.name, "covbeam_session_save") == 0;
        if ((status != COVBEAM_OK || !b->is_output) && !partial && memcmp(b->memory, b->before, b->size) != 0)
            fail("written in spite of the failure, or into an input", status);
        free(b->memory);
        free(b->before);
    }
}

static int32_t ask(void *user) {
    if (user != &polls || polls.refused || !pthread_equal(pthread_self(), polls.thread)) polls.wrong = true;
    polls.refused = ++polls.asked == polls.refuse;
    return polls.refused ? -7 : 0;
}

void begin(const char *name) {
    memset(&call, 0, sizeof call);
    memset(&polls, 0, sizeof polls);
    if (faulty < 0) memset(limits, 0, sizeof limits);
    call.name = name;
    argument = 0;
}

bool is_turn(int ways) {
    limits[argument] = ways;
    return argument++ == faulty && variant < ways;
}

covbeam_poll a_poll(void) {
    const bool turn = is_turn(4);
    polls.thread = pthread_self();
    if (turn) polls.refuse = 1 + variant;
    return turn || chance(2) ? ask : NULL;
}

static void spoil_integer(const struct field *field, uint32_t number, uint32_t *word) {
    static const uint32_t any[] = { 0, 1, 2, 3, 4, 5, 100, 0x7fffffffu, 0x80000000u, 0xffffffffu };
    static const uint32_t wrong[] = { 0, 0x4001, 0x80000000u, 0xffffffffu };
    switch (field->rule) {
    case 'e': *word = number % 2 ? 7 : 0xffffffffu; break;
    case 'w': *word = wrong[number % 4]; break;
    case 't': *word = number % 2 ? 1025 : 0xffffffffu; break;
    case 'g': *word = number % 2 ? 257 : 0xffffffffu; break;
    case 'm': *word = 0; may(COVBEAM_INVALID_VALUE); return;
    case 'h': /* more than any machine has memory for, and more than the library takes */
        *word = number % 2 ? 1u << 28 : number % 4 ? (1u << 28) + 1 : 0xffffffffu;
        must(COVBEAM_INVALID_VALUE);
        may(COVBEAM_OUT_OF_MEMORY);
        return;
    default: *word = any[number % 10]; may(COVBEAM_INVALID_VALUE); return;
    }
    must(COVBEAM_INVALID_VALUE);
}

/* Spoils a field of a struct. Of pointers: what the struct shows must be there if it has a number of it. */
static void spoil(unsigned char *at, const struct field *field, uint32_t number) {
    static const double beyond[] = { 1e300, -1e300, 5e-324, 1e19 };
    at += field->offset;
    const uint32_t which = number % NUMBERS, element = below((uint32_t)field->count);
    const float single = hostile_number(which);
    const double wide = which == NUMBERS - 1 ? beyond[below(4)] : (double)single;
    const size_t huge[] = { SIZE_MAX, SIZE_MAX / 2, 0 };
    void *pointer;
    switch (field->type) {
    case 'f': memcpy(at + 4 * element, &single, 4); break;
    case 'd': memcpy(at + 8 * element, &wide, 8); break;
    case 'u': {
        uint32_t word;
        spoil_integer(field, number, &word);
        memcpy(at + 4 * element, &word, 4);
        return;
    }
    case 'z':
        memcpy(at, &huge[number % 3], sizeof *huge);
        may(COVBEAM_NULL_POINTER); /* of what showed nothing before */
        if (number % 3 == 2) may(COVBEAM_INVALID_VALUE); else must(COVBEAM_INVALID_ARRAY);
        return;
    default:
        memcpy(&pointer, at, sizeof pointer);
        if (!pointer) return;
        if (field->type == 'c' || number % 2) {
            pointer = NULL;
            if (field->rule == 'N') must(COVBEAM_NULL_POINTER); else may(COVBEAM_INVALID_VALUE);
        } else {
            pointer = (char *)pointer + 1;
            must(COVBEAM_MISALIGNED);
        }
        memcpy(at, &pointer, sizeof pointer);
        return;
    }
    if (field->rule == '!' && !isfinite(field->type == 'f' ? (double)single : wide)) must(COVBEAM_INVALID_VALUE);
    may(COVBEAM_INVALID_VALUE);
}

/* A copy of so many structs, of which the last may be spoiled. */
void *structs(const void *given, size_t size, size_t count, const struct field *fields, size_t field_count) {
    unsigned char *at = block(given, size * count, 0, false);
    if (!is_turn((int)field_count * NUMBERS) || count == 0) return at;
    spoil(at + size * (count - 1), &fields[variant / NUMBERS], (uint32_t)variant % NUMBERS);
    spoiled();
    return at;
}

/* The same of one that begins with its size, and what can be done to that. */
void *options(const void *given, size_t size, const struct field *fields, size_t field_count) {
    static const uint32_t sizes[] = { 0, 3, 4, 4097, 0xffffffffu };
    unsigned char bytes[1024];
    memcpy(bytes, given, size);
    memset(bytes + size, 0, 64);
    if (!is_turn(9)) return structs(given, size, 1, fields, field_count);
    argument++;
    size_t there = size;
    switch (variant) {
    case 0: must(COVBEAM_NULL_POINTER); return NULL;
    case 1: must(COVBEAM_MISALIGNED); return block(given, size, 1, false);
    case 7: /* of a later version, with nothing new in it */
    case 8: /* and with something */
        there += 16;
        bytes[there - 1] = variant == 8;
        if (variant == 8) must(COVBEAM_INVALID_VALUE);
        break;
    default: must(COVBEAM_INVALID_VALUE);
    }
    const uint32_t says = variant < 7 ? sizes[variant - 2] : (uint32_t)there;
    memcpy(bytes, &says, sizeof says);
    return block(bytes, there, 0, false);
}

/* Where a result goes. */
void *out(size_t size, bool nullable) {
    if (!is_turn(2)) return nullable && chance(2) ? NULL : block(NULL, size, 0, true);
    if (variant == 1) {
        must(COVBEAM_MISALIGNED);
        return block(NULL, size, 1, true);
    }
    if (!nullable) must(COVBEAM_NULL_POINTER);
    return NULL;
}

/* An array with a stride. */
void *strided(const void *given, size_t size, size_t alignment, size_t count, size_t *says, size_t *stride, const struct field *fields,
              size_t field_count) {
    const bool turn = is_turn(6);
    *says = count;
    *stride = size;
    const bool is_output = !fields;
    if (!turn) return is_output ? block(NULL, size * count, 0, true) : structs(given, size, count, fields, field_count);
    switch (variant) {
    case 0: if (count > 0) must(COVBEAM_NULL_POINTER); return NULL;
    case 1: if (count > 0) must(COVBEAM_MISALIGNED); return block(given, size * count, 1, is_output);
    case 2: *stride = size + alignment / 2; if (count > 0) must(COVBEAM_MISALIGNED); break;
    case 3: *stride = SIZE_MAX / 8 * 8; if (count > 1) must(COVBEAM_INVALID_ARRAY); break;
    case 4: *stride = size - alignment; if (count > 1 && is_output) must(COVBEAM_INVALID_ARRAY); else may(COVBEAM_INVALID_VALUE); break;
    default: *says = SIZE_MAX / 16; *stride = 64; must(COVBEAM_INVALID_ARRAY); may(COVBEAM_SHORT_BUFFER);
    }
    return block(given, size * count, 0, is_output);
}
