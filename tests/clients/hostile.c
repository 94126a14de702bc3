/*
 * A host that does everything wrong: hostile SEQUENCES SEED
 *
 * First each parameter of each function is spoiled in turn, in every way; then come random sequences of calls on a few objects,
 * with some arguments spoiled. After each call: the status is one that the spoiled arguments allow (and COVBEAM_OK if none is spoiled),
 * a failure has a message that names a parameter, has written nothing and changed no object, and what a success has
 * written are numbers. In the end each function has succeeded at least once. Compiled with -DSCARCE and linked as scarce.h says, each call is made again and again, with the first of
 * its requests for memory refused, then the second, and so on: each time it says so, and has written and changed nothing; and in
 * the end all memory has been given back. `hostile --list` prints the functions that it calls; `hostile --lie` passes an array that is shorter than
 * it says, which no library can notice, but a memory checker must.
 */
#include "hostile/arguments.h"
#include "hostile/pool.h"
#ifdef SCARCE
#include "scarce.h"
#endif
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define POINTER(i) a[i].pointer
#define SIZE(i) a[i].size
#define NUMBER(i) a[i].number
#define WORD(i) a[i].word
#define POLL(i) a[i].poll
#define SHADE(i) a[i].shade
#define PROBE(i) a[i].probe

#define OTHER(name)
#define CALL(name, description, ...) \
    static int32_t call_##name(const union argument *a) { return name(__VA_ARGS__); }
#include "hostile/calls.h"
#undef CALL

#define CALL(name, description, ...) { #name, description, call_##name, 0, { { { 0 }, 0, { 0 }, NULL, 0, 0, 0, 0, 0, 0 } } },
struct function functions[] = {
#include "hostile/calls.h"
};
#undef CALL
#undef OTHER
const size_t function_count = sizeof functions / sizeof *functions;

static bool succeeded[sizeof functions / sizeof *functions];
static uint64_t seed, sequence, calls, by_status[COVBEAM_BUSY + 1], cancelled_later;

static void complain(const struct prepared *call, int32_t status, const char *message, const char *what) {
    fprintf(stderr, "hostile: seed %llu, sequence %llu, call %llu: %s returned %s (%s)\n  %s\n", (unsigned long long)seed,
            (unsigned long long)sequence, (unsigned long long)calls, call->function->name, covbeam_status_name(status),
            message, what);
    fprintf(stderr, "  allowed: %s%s", call->sure ? "" : "COVBEAM_OK ", call->unsure ? "COVBEAM_INVALID_VALUE " : "");
    for (int32_t s = 1; s <= COVBEAM_BUSY; s++)
        if (call->statuses >> s & 1) fprintf(stderr, "%s ", covbeam_status_name(s));
    fprintf(stderr, "\n  %s\n ", call->tame ? "tame" : "wild");
    for (int i = 0; i < call->function->parameter_count; i++) {
        const struct parameter *p = &call->function->parameters[i];
        const union argument *a = &call->arguments[i];
        if (p->kind == '$')
            fprintf(stderr, " %s=%g", p->name, (double)a->number);
        else if (p->kind == '#')
            fprintf(stderr, " %s=%u", p->name, a->word);
        else if (strchr("nsk", p->kind))
            fprintf(stderr, " %s=%zu", p->name, a->size);
        else if (strchr("<>=@!+", p->kind))
            fprintf(stderr, " %s=%p", p->name, a->pointer);
        if (strchr("<=>", p->kind) && p->type->size % 4 == 0 && p->type->size < 129)
            for (size_t k = 0; k < call->buffers[i].length / 4 && k < 96; k++) {
                float v;
                memcpy(&v, call->buffers[i].first + 4 * k, 4);
                fprintf(stderr, "%c%g", k ? ' ' : '{', (double)v);
            }
        if (strchr("<=>", p->kind)) fprintf(stderr, "}");
    }
    fprintf(stderr, "\n");
    exit(1);
}

/* Whether the message names a parameter, or a part of its name: an element is checked as an array of one, "axis" as "axes". */
static bool names(const char *message, const struct parameter *p) {
    for (const char *part = p->name; *part;) {
        const size_t length = strcspn(part, "_");
        char stem[32];
        memcpy(stem, part, length);
        stem[length > 4 ? length - 2 : strcmp(p->name, "axis") == 0 ? 2 : length] = 0;
        if (strstr(message, stem)) return true;
        part += length;
        part += *part == '_';
    }
    return false;
}

static void check_message(const struct prepared *call, int32_t status, const char *message) {
    if (strlen(message) < 8 || strlen(message) > 255) complain(call, status, message, "a message of a strange length");
    for (int i = 0; i < call->function->parameter_count; i++)
        if (names(message, &call->function->parameters[i])) return;
    complain(call, status, message, "the message names no parameter");
}

/* What a successful call has written: numbers, where numbers are promised. */
static void check_outputs(const struct prepared *call, const char *message) {
    for (int i = 0; i < call->function->parameter_count; i++) {
        const struct parameter *p = &call->function->parameters[i];
        const struct buffer *b = &call->buffers[i];
        if (!strchr(">=", p->kind) || !call->arguments[i].pointer) continue;
        const struct type *type = p->type;
        for (size_t k = 0; k < b->count; k++) {
            const unsigned char *at = b->first + k * b->stride;
            if (strcmp(type->name, "flag") == 0 && *at > 1) complain(call, 0, message, "a flag is neither 0 nor 1");
            if (strcmp(type->name, "knot") == 0) break; /* only the first `count` are written */
            if (memcmp(at, b->before + k * b->stride, type->size) == 0) continue; /* where lines do not cross */
            for (size_t word = 0; word < type->size / 4; word++) {
                float v;
                memcpy(&v, at + 4 * word, 4);
                const char rule = type->rules[word];
                if (strchr("-iSez*", rule)) continue;
                const bool promised = call->tame || strcmp(type->name, "field") == 0;
                if (isnan(v) && !call->meaningless && (promised || rule == 't')) complain(call, 0, message, "an output is NaN");
                if (promised && !call->meaningless && !number_fits(rule, v))
                    complain(call, 0, message, "an output is out of its range");
            }
            const size_t gap = k + 1 < b->count ? b->stride - type->size : 0;
            if (memcmp(at + type->size, b->before + k * b->stride + type->size, gap) != 0)
                complain(call, 0, message, "written between the elements");
        }
    }
}

static void replace(int slot, const struct slot *made) {
    const enum kind kind = pool[slot].kind;
    slot_free(&pool[slot]);
    pool[slot] = *made;
    pool[slot].kind = kind;
}

/* What the host knows of its objects after a successful call. */
static void remember(struct prepared *call) {
    const struct function *f = call->function;
    const char *name = f->name + strlen("covbeam_");
    struct slot *first = call->handles[0] >= 0 ? &pool[call->handles[0]] : NULL;
    if (f->parameters[0].kind == '!' && strcmp(f->parameters[0].word, "scratch") != 0 && first) first->tame &= call->tame;
    if (strcmp(name, "beam_map_clear") == 0) {
        first->committed = false;
        first->tame = true;
    } else if (strcmp(name, "beam_map_commit") == 0) {
        first->committed = true;
        first->max_radius = call->max_radius;
    } else if (strcmp(name, "grid_clear") == 0) {
        first->resolved = false;
        first->tame = true;
        first->scribbled = false;
    } else if (strcmp(name, "grid_resolve") == 0 || strcmp(name, "march_update") == 0 || strcmp(name, "film_plan") == 0 ||
               strcmp(name, "importance_resolve") == 0) {
        first->resolved = true;
    } else if (strcmp(name, "film_add") == 0) {
        first->resolved = first->committed = false;
    } else if (strcmp(name, "film_verify") == 0) {
        first->committed = true;
    } else if (strcmp(name, "grid_deposit_spectra") == 0) {
        first->scribbled = true; /* any numbers, not only covariances */
    } else if (strcmp(name, "grid_merge") == 0) {
        for (int i = 0; i < SLOTS; i++) first->scribbled |= pool[i].scribbled;
    } else if (strcmp(name, "grid_save") == 0) {
        free(saved);
        saved_size = call->buffers[1].length;
        saved = malloc(saved_size);
        if (!saved) abort();
        memcpy(saved, call->buffers[1].first, saved_size);
    }
    for (int i = 0; i < f->parameter_count; i++) {
        const struct parameter *p = &f->parameters[i];
        if (p->kind == '+') {
            struct slot made;
            memset(&made, 0, sizeof made);
            memcpy(&made.handle, call->buffers[i].first, sizeof made.handle);
            made.tame = call->tame;
            /* What loaded bytes hold is not known. */
            made.scribbled = strcmp(name, "grid_load") == 0;
            if (kind_named(p->word) == GRID && covbeam_grid_get_layout(made.handle, &made.layout) != COVBEAM_OK) abort();
            if (kind_named(p->word) == IMPORTANCE) memcpy(&made.layout, call->buffers[0].first, sizeof made.layout);
            made.width = call->arguments[0].word;
            made.height = call->arguments[1].word;
            if (strcmp(name, "grid_new_in") == 0) {
                made.cells = (covbeam_grid_cell *)(void *)call->buffers[1].memory;
                made.means = (covbeam_fluence_cell *)(void *)call->buffers[3].memory;
                call->buffers[1].memory = call->buffers[3].memory = NULL;
            }
            const enum kind kind = kind_named(p->word);
            replace(pick(kind), &made);
        } else if (p->type && strcmp(p->type->name, "field") == 0 && p->kind != '<' && call->buffers[i].count > 0) {
            memcpy(&fields[below(16)], call->buffers[i].first, sizeof *fields);
        }
    }
    if (call->function->call && strstr(name, "_free")) {
        if (first) {
            first->handle = NULL; /* before slot_free, which would free it again */
            slot_free(first);
        }
    }
}

#ifdef SCARCE
static uint64_t refused[sizeof functions / sizeof *functions];
#endif

/* The kth request for memory is refused, for every k that the call gets to. */
static int32_t called(struct prepared *call, const uint64_t *digests) {
    const struct function *f = call->function;
#ifdef SCARCE
    const struct callbacks before = callbacks;
    for (uint64_t k = 1;; k++) {
        callbacks = before;
        scarce_begin(k);
        const int32_t status = f->call(call->arguments);
        if (!scarce_end()) return status;
        refused[f - functions]++;
        const char *message = covbeam_last_error();
        if (status != COVBEAM_OUT_OF_MEMORY) complain(call, status, message, "memory was refused");
        if (!strstr(message, " bytes")) complain(call, status, message, "the message does not say how much memory was wanted");
        for (int i = 0; i < f->parameter_count; i++) {
            const struct buffer *b = &call->buffers[i];
            if (b->before && memcmp(b->before, b->first, b->length) != 0)
                complain(call, status, message, "written in spite of the failure");
        }
        for (int i = 0; i < SLOTS; i++)
            if (digest(&pool[i]) != digests[i]) complain(call, status, message, "an object has changed that must not");
    }
#else
    (void)digests;
    return f->call(call->arguments);
#endif
}

static int32_t perform(struct prepared *call, bool thorough) {
    const struct function *f = call->function;
    uint64_t digests[SLOTS] = { 0 };
#ifdef SCARCE
    thorough = true;
#endif
    if (thorough)
        for (int i = 0; i < SLOTS; i++) digests[i] = digest(&pool[i]);
    for (int i = 0; i < f->parameter_count; i++) {
        struct buffer *b = &call->buffers[i];
        if (!b->first || b->length == 0) continue;
        b->before = malloc(b->length);
        if (!b->before) abort();
        memcpy(b->before, b->first, b->length);
    }
    const int32_t status = called(call, digests);
    calls++;
    const char *message = status == COVBEAM_OK ? "" : covbeam_last_error();
    if (status < 0 || status >= COVBEAM_POISONED) complain(call, status, message, "never to be returned");
    by_status[status]++;
    if (status == COVBEAM_OK) succeeded[call->function - functions] = true;
    const bool freeing = strstr(f->name, "_free") != NULL;
    if (callbacks.wrong) complain(call, status, message, "a callback was called with something wrong, or after it had said no");
    if (callbacks.refused != (status == COVBEAM_CANCELLED) || callbacks.failed != (status == COVBEAM_CALLBACK_FAILED))
        complain(call, status, message, "the status does not say what the callbacks said");
    if (callbacks.refused && callbacks.polls > 1) cancelled_later++;
    if (!callbacks.refused && !callbacks.failed && !freeing) {
        const bool sound = status == COVBEAM_OK ? !call->sure
            : (call->statuses >> status & 1) || (call->unsure && status == COVBEAM_INVALID_VALUE);
        if (!sound) complain(call, status, message, "another status was to be expected");
    }
    if (status != COVBEAM_OK) check_message(call, status, message);
    for (int i = 0; i < f->parameter_count; i++) {
        const struct buffer *b = &call->buffers[i];
        if (!b->before) continue;
        const char kind = f->parameters[i].kind;
        const bool partial = status == COVBEAM_SHORT_BUFFER && strcmp(f->parameters[i].word, "knot") == 0;
        if ((kind == '<' || status != COVBEAM_OK) && !partial && memcmp(b->before, b->first, b->length) != 0)
            complain(call, status, message, kind == '<' ? "an input was written" : "an output was written in spite of the failure");
    }
    if (status == COVBEAM_OK && !freeing) check_outputs(call, message);
    if (thorough)
        for (int i = 0; i < SLOTS; i++) {
            const bool some = status == COVBEAM_CANCELLED && strcmp(f->name, "covbeam_grid_deposit") == 0;
            const bool changed = (status == COVBEAM_OK || some) && f->parameters[0].kind == '!' && call->handles[0] == i;
            if (!changed && digest(&pool[i]) != digests[i]) complain(call, status, message, "an object has changed that must not");
        }
    if (status == COVBEAM_OK) remember(call);
    release(call);
    return status;
}

static void call_function(const struct function *function, const struct fault *faults, int count, bool thorough) {
    struct prepared call;
    prepare(&call, function, faults, count);
    perform(&call, thorough);
}

static const struct function *named(const char *name) {
    for (size_t i = 0; i < function_count; i++)
        if (strcmp(functions[i].name, name) == 0) return &functions[i];
    exit(2);
}

/* Objects in every state, so that the calls have something to work on. */
static void furnish(void) {
    static const char *const usual[] = {
        "covbeam_density_new", "covbeam_density_new", "covbeam_grid_new", "covbeam_grid_new_in", "covbeam_grid_new",
        "covbeam_beam_map_new", "covbeam_beam_map_new", "covbeam_beam_map_new", "covbeam_scratch_new", "covbeam_grid_deposit",
        "covbeam_grid_deposit", "covbeam_grid_resolve", "covbeam_grid_resolve", "covbeam_beam_map_add", "covbeam_beam_map_add",
        "covbeam_beam_map_add", "covbeam_beam_map_commit", "covbeam_beam_map_commit", "covbeam_grid_save",
        "covbeam_film_new", "covbeam_film_new", "covbeam_film_plan", "covbeam_film_plan", "covbeam_film_add",
        "covbeam_film_add", "covbeam_film_plan", "covbeam_film_verify", "covbeam_film_verify", "covbeam_march_new", "covbeam_march_new", "covbeam_march_update",
        "covbeam_march_update", "covbeam_importance_new", "covbeam_importance_new", "covbeam_importance_new",
        "covbeam_importance_add_eye_rays", "covbeam_importance_resolve", "covbeam_importance_resolve",
    };
    for (size_t i = 0; i < sizeof usual / sizeof *usual; i++)
        if (!chance(6)) call_function(named(usual[i]), NULL, 0, false);
}

static struct fault random_fault(const struct function *function) {
    struct fault fault = { NO_FAULT, -1, 0, 0 };
    for (int tries = 0; tries < 16 && function->parameter_count > 0; tries++) {
        fault.parameter = (int)below((uint32_t)function->parameter_count);
        fault.kind = (enum fault_kind)(1 + below(FAULT_KINDS - 1));
        fault.variant = (uint32_t)(draw() >> 40);
        fault.number = (uint32_t)(draw() >> 40);
        bool numbers;
        if (variants(function, fault.parameter, fault.kind, &numbers) > 0) return fault;
    }
    fault.kind = NO_FAULT;
    return fault;
}

/* A sequence of calls, and of requests for memory that are all given back. */
#ifdef SCARCE
static int64_t live;
static void begin(void) {
    live = scarce_live;
    pool_start();
}
static void end(void) {
    pool_end();
    if (scarce_live == live) return;
    fprintf(stderr, "hostile: seed %llu, sequence %llu: memory is lost\n", (unsigned long long)seed, (unsigned long long)sequence);
    exit(1);
}
#else
#define begin pool_start
#define end pool_end
#endif

static void random_sequence(void) {
    static const char *const busy[] = {
        "covbeam_beam_map_add", "covbeam_beam_map_commit", "covbeam_beam_map_gather", "covbeam_beam_map_gather_shaded",
        "covbeam_grid_deposit", "covbeam_grid_merge", "covbeam_grid_resolve", "covbeam_grid_save", "covbeam_grid_load",
    };
    begin();
    furnish();
    uint32_t length = 10 + below(chance(4) ? 91 : 11);
    for (uint32_t i = 0; i < length; i++) {
        const struct function *function = &functions[below((uint32_t)function_count)];
        /* Twice as often one of those that change objects or call the host. */
        if (chance(3)) function = named(busy[below(sizeof busy / sizeof *busy)]);
        if (chance(40)) scribble(&pool[pick(GRID)]);
        struct fault faults[3];
        const uint32_t bad = below(8);
        const int count = bad < 4 ? 0 : bad < 7 ? 1 : 2 + (int)below(2);
        for (int k = 0; k < count; k++) faults[k] = random_fault(function);
        call_function(function, faults, count, chance(24));
    }
    end();
}

/* Every parameter of every function, spoiled in every way, on objects of so many states. */
static void systematic(uint64_t states) {
    for (size_t f = 0; f < function_count; f++) {
        const struct function *function = &functions[f];
        for (uint64_t state = 0; state < states; state++) {
            begin();
            furnish();
            call_function(function, NULL, 0, true);
            for (int p = 0; p < function->parameter_count; p++)
                for (enum fault_kind kind = NULL_POINTER; kind < FAULT_KINDS; kind++) {
                    bool numbers;
                    const int count = variants(function, p, kind, &numbers);
                    for (int v = 0; v < count; v++)
                        for (uint32_t n = 0; n < (numbers ? HOSTILE_NUMBERS : 1); n++) {
                            const struct fault fault = { kind, p, (uint32_t)v, n };
                            call_function(function, &fault, 1, chance(8));
                        }
                }
            end();
        }
    }
}

/* The functions that cannot fail. */
static void check_others(void) {
    if (covbeam_abi_version() != COVBEAM_ABI_VERSION || strlen(covbeam_version()) < 5) exit(1);
    const int32_t numbers[] = { INT32_MIN, -1, COVBEAM_BUSY + 1, INT32_MAX };
    for (size_t i = 0; i < 4; i++)
        if (strcmp(covbeam_status_name(numbers[i]), "unknown status") != 0) exit(1);
    if (strcmp(covbeam_last_error(), "") != 0) exit(1);
    covbeam_beam_map_free(NULL);
    covbeam_density_free(NULL);
    covbeam_grid_free(NULL);
    covbeam_scratch_free(NULL);
    covbeam_film_free(NULL);
    covbeam_march_free(NULL);
    covbeam_importance_free(NULL);
}

int main(int argc, char **argv) {
    if (argc == 2 && strcmp(argv[1], "--list") == 0) {
#define OTHER(name) puts(#name);
#define CALL(name, description, ...) puts(#name);
#include "hostile/calls.h"
        return 0;
    }
    if (argc == 2 && strcmp(argv[1], "--lie") == 0) {
        /* One byte less than promised: what watches the memory must end this. */
        float *directions = malloc(11), angle = 1;
        covbeam_light_field fields_out[1];
        if (!directions) return 2;
        memset(directions, 0, 11);
        return (int)covbeam_light_field_point(directions, angle, fields_out);
    }
    if (argc != 3 && argc != 4) {
        fprintf(stderr, "usage: hostile SEQUENCES SEED [STATES]\n");
        return 2;
    }
    const uint64_t sequences = strtoull(argv[1], NULL, 10);
    seed = strtoull(argv[2], NULL, 10);
    random_state = seed * 0x9e3779b97f4a7c15u + 0x1234567;
    check_others();
    for (size_t i = 0; i < function_count; i++) describe(&functions[i]);
    systematic(argc == 4 ? strtoull(argv[3], NULL, 10) : 6);
    const uint64_t first = calls;
    for (sequence = 1; sequence <= sequences; sequence++) random_sequence();
    printf("seed %llu: %llu systematic calls; %llu sequences of %llu calls; %llu cancelled after the first question\n",
           (unsigned long long)seed, (unsigned long long)first, (unsigned long long)sequences,
           (unsigned long long)(calls - first), (unsigned long long)cancelled_later);
#ifdef SCARCE
    uint64_t times = 0, where = 0;
    for (size_t i = 0; i < function_count; i++) {
        times += refused[i];
        where += refused[i] > 0;
    }
    printf("  memory was refused %llu times, in %llu functions\n", (unsigned long long)times, (unsigned long long)where);
#endif
    for (int32_t status = 0; status <= COVBEAM_BUSY; status++)
        printf("  %-24s %12llu\n", covbeam_status_name(status), (unsigned long long)by_status[status]);
    for (size_t f = 0; f < function_count; f++) {
        if (succeeded[f]) continue;
        fprintf(stderr, "hostile: seed %llu: %s has never succeeded: too few sequences\n", (unsigned long long)seed, functions[f].name);
        return 1;
    }
    return 0;
}
