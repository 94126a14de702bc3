#include "types.h"
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

uint64_t random_state = 1;

uint64_t draw(void) {
    random_state ^= random_state >> 12;
    random_state ^= random_state << 25;
    random_state ^= random_state >> 27;
    return random_state * 0x2545f4914f6cdd1du;
}

uint32_t below(uint32_t end) { return (uint32_t)(((draw() >> 32) * end) >> 32); }
float uniform(float from, float to) { return from + (to - from) * (float)(draw() >> 40) / 16777216.0f; }
bool chance(uint32_t in) { return below(in) == 0; }

/*
 * Rules, a letter for each 32-bit word:
 *   f finite; F finite, and more is asked of it; p >= 0; q finite, >= 0; k the same, and so is the sum of all k
 *   + finite, > 0; m the same, and more is asked of it; P > 0
 *   * any number, NaN too; o NaN or in [0, 1]
 *   r in [0, 1], where 1 counts as the largest below; c in [-1, 1]; t in [0, 1]; a in (-1, 1); l in (0, 1]; L the same, and more is asked of it; N not NaN
 *   E 1, such as the end of a guide
 *   u of a unit vector; v of a unit vector or 0; d of a vector that is not 0
 *   S struct_size; e an enumeration of three; b 0 or 1; z a number of voxels; i any integer; - not looked at as a number
 */
static const struct type types[] = {
    { "beam", sizeof(covbeam_beam), 4, "fffuuuqfffvvvvvv" },
    { "ray", sizeof(covbeam_eye_ray), 4, "fffuuup" },
    { "segment", sizeof(covbeam_segment), 8, "fffP+bffffffffffuuuuuu--------------------------" },
    { "way", sizeof(covbeam_segment), 8, "fff---ffffffffffuuuuuu--------------------------" },
    { "hit", sizeof(covbeam_probe_hit), 4, "Pdddq" },
    { "edges", COVBEAM_MOST_EDGES * sizeof(covbeam_edge), 4, "pqfffpqfffpqfffpqfff" },
    { "word", 4, 4, "i" },
    { "field", sizeof(covbeam_light_field), 4, "ffffffffffuuuuuu" },
    { "medium", sizeof(covbeam_medium), 8, "Skkkkkkeaefffddd+---" },
    { "kernel", sizeof(covbeam_kernel), 4, "Semm+" },
    { "schedule", sizeof(covbeam_schedule), 4, "Seml+m" },
    { "phase", sizeof(covbeam_phase), 4, "ea" },
    { "layout", sizeof(covbeam_grid_layout), 4, "FFFFFFzzz" },
    { "spectrum", sizeof(covbeam_spectrum), 4, "ffffff" },
    { "curvature", sizeof(covbeam_curvature), 4, "ffffff" },
    { "derivatives", sizeof(covbeam_derivatives), 4, "fffffffff" },
    { "column", sizeof(covbeam_column), 8, "eqN-----" },
    { "knot", sizeof(covbeam_knot), 4, "FF" },
    { "gathered", sizeof(covbeam_gathered), 4, "fffifff" },
    { "crossing", sizeof(covbeam_crossing), 4, "ffqufff" },
    { "cell", sizeof(covbeam_grid_cell), 8, "--------------" },
    { "mean", sizeof(covbeam_fluence_cell), 4, "-------" },
    { "steps", 2 * sizeof(covbeam_pixel_step), 4, "ffffffffffff" },
    { "image", sizeof(covbeam_image_spectrum), 4, "fffq" },
    { "filter", sizeof(covbeam_image_filter), 4, "qfq" },
    { "seen", sizeof(covbeam_film_ray), 4, "iibbqqqqqq" },
    { "shown", sizeof(covbeam_film_pixel), 4, "qqqqqqqf" },
    { "pixel", sizeof(covbeam_film_pixel), 4, "******qf" },
    { "place", sizeof(covbeam_march_knot), 4, "F***" },
    { "aim", sizeof(covbeam_march_sample), 8, "fqoi--" },
    { "size", sizeof(size_t), 8, "--" },
    { "pointer", sizeof(void *), 8, "--" },
    { "grids", sizeof(void *), 8, "--" },
    { "importances", sizeof(void *), 8, "--" },
    { "worth", sizeof(covbeam_importance_cell), 4, "ppp" },
    { "flag", 1, 1, "" },
    { "byte", 1, 1, "" },
    { "saved", 1, 1, "" },
};

bool is(const struct type *type, const char *name) { return strcmp(type->name, name) == 0; }

const struct type *type_named(const char *name) {
    static struct type floats[64];
    static size_t known;
    if (strncmp(name, "f:", 2) == 0) {
        for (size_t i = 0; i < known; i++)
            if (strcmp(floats[i].name, name) == 0) return &floats[i];
        if (known < 64) {
            floats[known] = (struct type){ name, 4 * strlen(name + 2), 4, name + 2 };
            return &floats[known++];
        }
    }
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (strcmp(types[i].name, name) == 0) return &types[i];
    fprintf(stderr, "calls.h: no type is called %s\n", name);
    exit(2);
}

void describe(struct function *function) {
    int count = 0, pointer = -1, arrays = -1;
    for (const char *rest = function->description; *rest; count++) {
        struct parameter *p = &function->parameters[count];
        int length = 0;
        char kind[32];
        if (count == PARAMETERS || sscanf(rest, "%31s %31[^;]%n", p->name, kind, &length) != 2) exit(2);
        rest += length;
        rest += strspn(rest, "; ");
        p->kind = kind[0];
        p->stride = p->count = -1;
        if (strcmp(kind, "poll") == 0) p->kind = 'p';
        if (strcmp(kind, "shade") == 0) p->kind = 'h';
        if (strcmp(kind, "probe") == 0) p->kind = 'x';
        p->nullable = kind[strlen(kind) - 1] == '?';
        p->resolved = strstr(kind, ".resolved") != NULL;
        p->committed = strstr(kind, ".committed") != NULL;
        p->adding = strstr(kind, ".adding") != NULL;
        memcpy(p->word, kind + 1, strcspn(kind + 1, ".?"));
        if (strchr("<>=", p->kind)) {
            p->type = type_named(p->word);
            if (strlen(p->type->rules) * 4 != p->type->size && p->type->size != 1) exit(2);
            pointer = count;
        }
        if (p->kind == 'n') arrays = count;
        if (p->kind == 's') {
            function->parameters[pointer].stride = count;
            function->parameters[pointer].count = arrays;
        }
        if (p->kind == 'k') function->parameters[pointer].count = count;
    }
    function->parameter_count = count;
}

bool number_fits(char rule, float v) {
    switch (rule) {
    case 'f': case 'F': return isfinite(v);
    case 'p': return v >= 0;
    case 'q': case 'k': return isfinite(v) && v >= 0;
    case '+': case 'm': return isfinite(v) && v > 0;
    case 'P': return v > 0;
    case 'r': return v >= 0 && v <= 1;
    case 'c': return v >= -1 && v <= 1;
    case 't': return v >= 0 && v <= 1;
    case 'a': return v > -1 && v < 1;
    case 'l': case 'L': return v > 0 && v <= 1;
    case 'E': return v == 1;
    case 'N': return !isnan(v);
    case '*': return true;
    case 'o': return isnan(v) || (v >= 0 && v <= 1);
    case 'u': case 'v': return fabsf(v) < 1.001f;
    default: return isfinite(v);
    }
}

uint32_t bits_of(float v) {
    uint32_t bits;
    memcpy(&bits, &v, 4);
    return bits;
}

float float_of(uint32_t bits) {
    float v;
    memcpy(&v, &bits, 4);
    return v;
}

float hostile_number(uint32_t which) {
    const float all[HOSTILE_NUMBERS] = {
        NAN, INFINITY, -INFINITY, 0.0f, -0.0f, 1e-45f, -1e-45f, FLT_MAX, -FLT_MAX, FLT_MIN, -FLT_MIN, 1.5f, -1.5f,
        1e30f, float_of(0xffffffffu), float_of((uint32_t)(draw() >> 32)),
    };
    return all[which % HOSTILE_NUMBERS];
}

/* A number that the rule allows. */
float sound_number(char rule, bool tame) {
    if (!tame && chance(6))
        for (int tries = 0; tries < 8; tries++) {
            float v = hostile_number(below(HOSTILE_NUMBERS));
            if (number_fits(rule, v) && !(rule == 'k' && v > 1e30f)) return v;
        }
    switch (rule) {
    case 'f': case 'F': return uniform(-1, 1.5f);
    case 'p': case 'P': return chance(12) ? INFINITY : uniform(0.01f, 2);
    case 'r': case 't': case 'o': return uniform(0, 0.999f);
    case 'c': case 'a': return uniform(-0.95f, 0.95f);
    case 'l': case 'L': return uniform(0.05f, 1);
    default: return uniform(0.01f, 2);
    }
}

void sound_vector(char rule, bool tame, uint32_t *words) {
    float v[3] = { 0, 0, 0 };
    if (rule == 'v' && chance(2)) {
        memcpy(words, v, sizeof v);
        return;
    }
    if (chance(6))
        v[below(3)] = chance(2) ? 1.0f : -1.0f;
    else
        for (int i = 0; i < 3; i++) v[i] = uniform(-1, 1);
    float length = sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    if (length < 0.01f) {
        v[1] = 1;
        length = sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    }
    if (rule != 'd') for (int i = 0; i < 3; i++) v[i] /= length;
    if (rule == 'd' && !tame && chance(4)) for (int i = 0; i < 3; i++) v[i] *= chance(2) ? 1e-30f : 1e30f;
    memcpy(words, v, sizeof v);
}

/* The rule of a word, given what the words before it say. */
char rule_of(const struct type *type, const uint32_t *words, size_t word) {
    const char rule = type->rules[word];
    if (is(type, "medium") && word == 8 && words[7] != COVBEAM_PHASE_HENYEY_GREENSTEIN) return '-';
    if (is(type, "medium") && word >= 10 && words[9] != COVBEAM_DENSITY_EXPONENTIAL) return '-';
    if (is(type, "phase") && word == 1 && words[0] != COVBEAM_PHASE_HENYEY_GREENSTEIN) return '-';
    if (is(type, "hit") && word >= 1 && float_of(words[0]) == INFINITY) return '-';
    if (is(type, "column") && word >= 1 && words[0] != COVBEAM_DENSITY_EXPONENTIAL) return '-';
    return rule;
}
