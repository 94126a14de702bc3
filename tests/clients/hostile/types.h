/* The parameters of the header's functions, their types, and which numbers each word of them may hold. */
#ifndef HOSTILE_TYPES_H
#define HOSTILE_TYPES_H

#include "covbeam_extra.h"
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* A repeatable source of random numbers (xorshift64*). */
extern uint64_t random_state;
uint64_t draw(void);
uint32_t below(uint32_t end);
float uniform(float from, float to);
bool chance(uint32_t in);

union argument {
    void *pointer;
    size_t size;
    float number;
    uint32_t word;
    covbeam_poll poll;
    covbeam_shade shade;
    covbeam_probe probe;
};

enum { PARAMETERS = 20 };

/* A struct of the header as 32-bit words, with the rule of each. */
struct type {
    const char *name;
    size_t size, alignment;
    const char *rules;
};

/* A parameter, from its description in calls.h. */
struct parameter {
    char name[32];
    char kind;   /* n s k $ # p(oll) h(shade) x(probe) u(ser) @ ! + < > = */
    char word[24]; /* what follows the kind */
    const struct type *type;
    bool nullable, resolved, committed, adding;
    int stride, count; /* index of the parameter that gives it, or -1 */
};

struct function {
    const char *name;
    const char *description;
    int32_t (*call)(const union argument *a);
    int parameter_count;
    struct parameter parameters[PARAMETERS];
};

extern struct function functions[];
extern const size_t function_count;
void describe(struct function *function);

const struct type *type_named(const char *name);
bool is(const struct type *type, const char *name);

/* Whether a rule (see types.c) allows a number. */
bool number_fits(char rule, float value);

/* The rule of a word, given what the words before it say. */
char rule_of(const struct type *type, const uint32_t *words, size_t word);

/* Numbers of all the kinds that hurt; and such that a rule allows, of moderate size if `tame`. */
enum { HOSTILE_NUMBERS = 16 };
float hostile_number(uint32_t which);
float sound_number(char rule, bool tame);
void sound_vector(char rule, bool tame, uint32_t *words);

uint32_t bits_of(float value);
float float_of(uint32_t bits);

#endif
