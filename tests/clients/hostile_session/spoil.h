/* Arguments of the running call: what is right, and every way to spoil one of them. */
#ifndef HOSTILE_SESSION_SPOIL_H
#define HOSTILE_SESSION_SPOIL_H

#include "covbeam_session.h"
#include "fields.h"
#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>

enum { NUMBERS = 16 };

/* The argument that is spoiled, from 0 (-1: none is), and how. In how many ways each could be, after a call. */
extern int faulty, variant, limits[16];
extern uint64_t seed, calls;

extern struct call {
    const char *name;
    uint32_t statuses; /* that may come of what has been done */
    bool sure;         /* one of them must */
} call;

/* The polls of it. */
extern struct polls {
    int asked, refuse;
    bool refused, wrong;
    pthread_t thread;
} polls;

void begin(const char *name);
void fail(const char *what, int32_t status);

/* A status that may, or must, come of what has been done to an argument. */
void may(int32_t status);
void must(int32_t status);

/* Memory of the call, to the byte as long as it may use it. */
void *block(const void *bytes, size_t size, size_t misalignment, bool is_output);
/* Says that what is in the last block is what the call gets. */
void spoiled(void);
void free_blocks(int32_t status);

/* Whether it is the turn of the next argument, which can be spoiled in so many ways. */
bool is_turn(int ways);

covbeam_poll a_poll(void);
/* A copy of so many structs, of which the last may be spoiled. */
void *structs(const void *given, size_t size, size_t count, const struct field *fields, size_t field_count);
/* The same of one that begins with its size, and what can be done to that. */
void *options(const void *given, size_t size, const struct field *fields, size_t field_count);
/* Where a result goes. */
void *out(size_t size, bool nullable);
/* An array with a stride: structs, or room for results where there are no fields. */
void *strided(const void *given, size_t size, size_t alignment, size_t count, size_t *says, size_t *stride, const struct field *fields,
              size_t field_count);

#define STRUCTS(type, given, count) structs(given, sizeof(type), count, type##_fields, sizeof type##_fields / sizeof *type##_fields)
#define STRIDED(type, given, size, alignment, count, says, stride) \
    strided(given, size, alignment, count, says, stride, type##_fields, sizeof type##_fields / sizeof *type##_fields)
#define OPTIONS(type, given) options(given, sizeof(type), type##_fields, sizeof type##_fields / sizeof *type##_fields)

#endif
