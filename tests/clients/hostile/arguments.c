#include "arguments.h"
#include "elements.h"
#include "pool.h"
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

struct callbacks callbacks;

static int32_t ask(void *user) {
    callbacks.polls++;
    if (user != &callbacks || callbacks.refused || callbacks.failed) callbacks.wrong = true;
    if (callbacks.polls == callbacks.refuse_poll) callbacks.refused = true;
    return callbacks.refused ? -1 : 0;
}

static int32_t shade(void *user, const covbeam_contact *contacts, size_t count, float *values) {
    callbacks.shades++;
    if (user != &callbacks || callbacks.refused || callbacks.failed || count == 0 || count > 256) callbacks.wrong = true;
    for (size_t i = 0; i < count; i++) {
        const covbeam_contact *c = &contacts[i];
        if (c->ray >= callbacks.call->count || !(c->radius > 0) || !(fabsf(c->cos_theta) <= 1.001f)) callbacks.wrong = true;
        for (int channel = 0; channel < 3 && callbacks.shade_values != 3; channel++)
            values[3 * i + (size_t)channel] =
                callbacks.shade_values == 1 ? NAN : callbacks.shade_values == 2 ? FLT_MAX : 0.25f;
    }
    if (callbacks.shades == callbacks.refuse_shade) callbacks.failed = true;
    return callbacks.failed ? -7 : 0;
}

static int32_t probe(void *user, const float *direction, covbeam_probe_hit *hit) {
    const float length2 = direction[0] * direction[0] + direction[1] * direction[1] + direction[2] * direction[2];
    callbacks.shades++;
    if (user != &callbacks || callbacks.failed || callbacks.nonsense || !(fabsf(length2 - 1) < 1e-3f)) callbacks.wrong = true;
    if (hit->distance != INFINITY) callbacks.wrong = true;
    if (direction[2] > 0.2f && callbacks.shade_values != 3) {
        hit->distance = 1 / direction[2];
        hit->normal[2] = 1;
    }
    if (callbacks.shade_values == 1) hit->distance = NAN;
    callbacks.nonsense = callbacks.shade_values == 1;
    if (callbacks.shades == callbacks.refuse_shade) callbacks.failed = true;
    return callbacks.failed ? -7 : 0;
}

/* How many ways there are to spoil a parameter in this manner, for the systematic part. */
int variants(const struct function *function, int parameter, enum fault_kind kind, bool *numbers) {
    const struct parameter *p = &function->parameters[parameter];
    const bool pointer = strchr("<>=@!+", p->kind) != NULL;
    *numbers = false;
    switch (kind) {
    case NULL_POINTER: return pointer || p->kind == 'h' || p->kind == 'x';
    case MISALIGNED: return pointer && (!p->type || p->type->alignment > 1) ? 3 : 0;
    case WORD:
        *numbers = true;
        if (p->kind == '$' || p->kind == '#') return 1;
        return strchr("<=", p->kind) ? (int)p->type->size / 4 : 0;
    case HUGE_COUNT: return p->kind == 'n' ? 5 : 0;
    case HOSTILE_STRIDE: return p->kind == 's' ? 6 : 0;
    case WRONG_HANDLE: return strchr("@!", p->kind) ? 3 : 0;
    case STRUCT_SIZE: return p->type && p->type->rules[0] == 'S' ? 12 : 0;
    case WRONG_LENGTH: return p->kind == 'k' ? 4 : 0;
    case INSIDE: return p->type && p->kind == '<' && strchr("mscw", p->type->name[0]) && p->type->alignment == 8 ? 24 : 0;
    case CALLBACK: return strchr("phx", p->kind) ? 6 : 0;
    default: return 0;
    }
}

static bool wrong_state(const struct parameter *p, const struct slot *slot) {
    return (p->resolved && !slot->resolved) || (p->committed && !slot->committed) || (p->adding && slot->committed);
}

static void handle_argument(struct prepared *call, int index, const struct fault *fault) {
    const struct parameter *p = &call->function->parameters[index];
    union argument *a = &call->arguments[index];
    const enum kind kind = kind_named(p->word);
    if (p->kind == '+') {
        const uint32_t misalignment = fault->kind == MISALIGNED ? 1 + fault->variant % 3 : 0;
        call->buffers[index] = memory(1, 0, sizeof(void *), misalignment);
        a->pointer = fault->kind == NULL_POINTER ? NULL : call->buffers[index].first;
        if (fault->kind == NULL_POINTER) must(call, COVBEAM_NULL_POINTER);
        if (fault->kind == MISALIGNED) must(call, COVBEAM_MISALIGNED);
        return;
    }
    int slot = pick(kind);
    for (int tries = 0; tries < 6 && (!pool[slot].handle || wrong_state(p, &pool[slot])); tries++) slot = pick(kind);
    a->pointer = pool[slot].handle;
    if (fault->kind == NULL_POINTER || (p->nullable && chance(3))) a->pointer = NULL;
    if (fault->kind == WRONG_HANDLE) {
        const enum kind other = (enum kind)((kind + 1 + fault->variant % 3) % KINDS);
        void *wrong = pool[pick(other)].handle;
        if (wrong) {
            a->pointer = wrong;
            must(call, COVBEAM_INVALID_HANDLE);
            return;
        }
    }
    if (!a->pointer) {
        if (!p->nullable) must(call, COVBEAM_NULL_POINTER);
        return;
    }
    if (fault->kind == MISALIGNED) {
        a->pointer = (char *)a->pointer + 1 + fault->variant % 3;
        must(call, COVBEAM_MISALIGNED);
        return;
    }
    call->handles[index] = slot;
    if (!pool[slot].tame) call->tame = false;
    if (wrong_state(p, &pool[slot])) must(call, COVBEAM_WRONG_ORDER);
    if (pool[slot].scribbled && strcmp(call->function->name, "covbeam_grid_save") == 0) call->unsure = true;
}

static bool same_layout(const covbeam_grid_layout *a, const covbeam_grid_layout *b) {
    for (int i = 0; i < 3; i++)
        if (a->min[i] != b->min[i] || a->max[i] != b->max[i] || a->cells[i] != b->cells[i]) return false;
    return true;
}

/* Whether a parameter is an array of handles to merge. */
static bool are_handles(const struct type *type) { return is(type, "grids") || is(type, "importances"); }

static void handles_argument(struct prepared *call, int index, size_t count, const struct fault *fault) {
    struct buffer *b = &call->buffers[index];
    const enum kind kind = is(call->function->parameters[index].type, "grids") ? GRID : IMPORTANCE;
    *b = memory(count, sizeof(void *), sizeof(void *), fault->kind == MISALIGNED ? 1 + fault->variant % 3 : 0);
    const int target = call->handles[0];
    if (fault->kind == MISALIGNED) may(call, COVBEAM_MISALIGNED);
    if (fault->kind == MISALIGNED && count > 0) call->sure = true;
    for (size_t i = 0; i < count; i++) {
        const int slot = pick(kind);
        void *handle = pool[slot].handle;
        if (fault->kind == INSIDE && i == count - 1) handle = fault->variant % 2 ? NULL : pool[pick(MAP)].handle;
        memcpy(b->first + i * sizeof handle, &handle, sizeof handle);
        if (!handle)
            must(call, COVBEAM_NULL_POINTER);
        else if (handle != pool[slot].handle)
            must(call, COVBEAM_INVALID_HANDLE);
        else if (slot == target)
            must(call, COVBEAM_INVALID_ARRAY);
        else if (target >= 0 && !same_layout(&pool[slot].layout, &pool[target].layout))
            must(call, COVBEAM_MISMATCH);
        if (handle == pool[slot].handle && !pool[slot].tame) call->tame = false;
    }
}

/* How many elements the call reads or writes at a pointer; also sets the count and the stride that go with it. */
static size_t array_shape(struct prepared *call, int index, const struct fault *faults, int fault_count, size_t *stride) {
    const struct parameter *p = &call->function->parameters[index];
    bool applied = false; /* the first fault of a parameter counts */
    *stride = 0;
    if (p->count < 0) return 1;
    const struct parameter *counted = &call->function->parameters[p->count];
    if (counted->kind == 'k') {
        size_t right = below(4);
        if (is(p->type, "cell") || is(p->type, "mean") || (p->stride >= 0 && p->type->rules[0] == 'q'))
            right = layout_cells(&layouts[call->layout]);
        if (is(p->type, "byte")) {
            const int grid = call->handles[0];
            right = grid < 0 ? 64 : 56 + 56 * layout_cells(&pool[grid].layout);
        }
        if (is(p->type, "saved")) right = saved_size;
        if (call->side > 0) right = call->side * (call->side + (strcmp(p->name, "guide") == 0));
        if (is(p->type, "knot") && p->kind == '>') right = chance(3) ? below(4) : 64 * 27;
        size_t says = right;
        *stride = p->type->size + (p->stride >= 0 ? 4 * below(3) : 0);
        for (int i = 0; i < fault_count && !applied; i++) {
            if (faults[i].kind != WRONG_LENGTH || faults[i].parameter != p->count) continue;
            applied = true;
            const size_t wrong[4] = { right - (right > 0), right + 1, SIZE_MAX, SIZE_MAX / 4 + 2 };
            says = wrong[faults[i].variant % 4];
            if (is(p->type, "knot") && says == right + 1) says = right; /* one more would be the host's to have */
            if (are_handles(p->type) && says == right + 1) says = right;
            if (is(p->type, "saved") && says > right + 1) says = SIZE_MAX; /* less could be memory */
            if (says == right) continue;
            if (is(p->type, "knot") || are_handles(p->type)) {
                if (says > right) must(call, COVBEAM_INVALID_ARRAY);
            } else if (is(p->type, "saved")) {
                may(call, COVBEAM_BAD_DATA);
                must(call, COVBEAM_INVALID_ARRAY);
            } else {
                may(call, COVBEAM_INVALID_ARRAY);
                must(call, COVBEAM_SHORT_BUFFER);
            }
        }
        call->arguments[p->count].size = says;
        if (p->stride >= 0) call->arguments[p->stride].size = *stride;
        return says > right ? (says == right + 1 ? says : right) : says;
    }
    const size_t count = call->count, size = p->type->size, step = p->type->alignment;
    const bool input = p->kind == '<';
    *stride = size + step * (chance(2) ? 0 : below(5));
    if (input && chance(6)) *stride = 0;
    size_t says = *stride;
    for (int i = 0; i < fault_count; i++) {
        if (faults[i].kind == HUGE_COUNT && faults[i].parameter == p->count) {
            const size_t counts[5] = { SIZE_MAX, ((size_t)1 << 40) + 1, SIZE_MAX / 2, ((size_t)1 << 60) + 1, SIZE_MAX };
            const size_t strides[5] = { (size + 7) / 8 * 8, (size_t)1 << 24, (size + 7) / 8 * 8, (size_t)1 << 32, 0 };
            call->arguments[p->count].size = counts[faults[i].variant % 5];
            call->arguments[p->stride].size = strides[faults[i].variant % 5];
            must(call, COVBEAM_INVALID_ARRAY);
            if (call->whole) may(call, COVBEAM_SHORT_BUFFER);
            return 1;
        }
    }
    for (int i = 0; i < fault_count && !applied; i++) {
        if (faults[i].kind != HOSTILE_STRIDE || faults[i].parameter != p->stride || count == 0) continue;
        applied = true;
        switch (faults[i].variant % 6) {
        case 0: /* odd */
            says = size + step / 2 + (step == 1);
            if (step > 1) must(call, COVBEAM_MISALIGNED); else says = *stride;
            break;
        case 1: /* wraps */
            says = (size_t)1 << 63;
            if (count > 1) must(call, COVBEAM_INVALID_ARRAY);
            break;
        case 2:
            says = SIZE_MAX / 8 * 8;
            if (count > 1) must(call, COVBEAM_INVALID_ARRAY);
            break;
        case 3:
            says = 0;
            if (count > 1 && !input) must(call, COVBEAM_INVALID_ARRAY);
            *stride = says;
            break;
        case 4: /* elements that overlap */
            says = size > step ? size - step : 0;
            if (count > 1 && !input) must(call, COVBEAM_INVALID_ARRAY);
            if (input && count > 1) call->unsure = true;
            if (input && count > 1 && step == 8) says = size;
            *stride = says;
            break;
        default: /* negative */
            says = (size_t)0 - (size + 7) / 8 * 8;
            if (count > 1) must(call, COVBEAM_INVALID_ARRAY);
        }
    }
    call->arguments[p->stride].size = says;
    return count;
}

static void pointer_argument(struct prepared *call, int index, const struct fault *fault, const struct fault *faults, int fault_count) {
    const struct parameter *p = &call->function->parameters[index];
    union argument *a = &call->arguments[index];
    struct buffer *b = &call->buffers[index];
    const uint32_t misalignment = fault->kind == MISALIGNED && p->type->alignment > 1 ? 1 + fault->variant % 3 : 0;
    const struct prepared before = *call;
    size_t stride;
    const size_t count = array_shape(call, index, faults, fault_count, &stride);
    if (are_handles(p->type)) {
        handles_argument(call, index, count, fault);
    } else if (is(p->type, "saved")) {
        *b = memory(count, 1, 1, 0);
        if (saved) memcpy(b->first, saved, count < saved_size ? count : saved_size);
        if (count < 56 + 56) must(call, COVBEAM_BAD_DATA);
        if (fault->kind == INSIDE && count > 0) {
            const size_t damaged = fault->variant % 2 ? fault->variant % count : 0;
            b->first[damaged] ^= (unsigned char)(1 + below(255));
            may(call, COVBEAM_BAD_DATA);
            call->unsure = true;
        }
    } else {
        *b = memory(count, stride, p->type->size, 0);
        if (p->kind != '>' && !is(p->type, "cell") && !is(p->type, "mean"))
            for (size_t i = 0; i < count; i++) {
                unsigned char element[256];
                sound_element(call, p, element);
                memcpy(b->first + i * stride, element, p->type->size);
            }
        if (is(p->type, "place") && p->kind == '<')
            for (size_t i = 0; i < count; i++) {
                const float distance = 0.25f * (float)i;
                memcpy(b->first + i * stride, &distance, sizeof distance);
            }
        if (p->kind == '<' && is(p->type, "knot")) {
            covbeam_knot *table = new_table(count, 0, true);
            if (count > 0) memcpy(b->first, table, count * sizeof *table);
        }
        if (p->kind == '<' && is(p->type, "f:E"))
            for (size_t i = 0; i < count; i++) {
                const float share = (float)(i % call->side + 1) / (float)call->side;
                memcpy(b->first + i * stride, &share, sizeof share);
            }
        if (is(p->type, "cell") || is(p->type, "mean")) memset(b->first, 0, b->length);
        if (count > 0 && p->kind != '>') {
            unsigned char *at = b->first + (count - 1) * stride;
            unsigned char element[256];
            memcpy(element, at, p->type->size);
            if (fault->kind == WORD && p->type->size >= 4) {
                if (strchr("-", p->type->rules[0]) == NULL) spoil_word(call, p, element, fault);
            }
            if (fault->kind == INSIDE) spoil_inside(call, p, element, fault->variant);
            memcpy(at, element, p->type->size);
            if (fault->kind == STRUCT_SIZE && p->type->rules[0] == 'S') {
                struct buffer other = other_size(call, p, element, fault->variant);
                free(b->memory);
                *b = other;
            }
        }
        if (misalignment) {
            struct buffer moved = memory(b->count, b->stride, 0, misalignment);
            free(moved.memory);
            moved.memory = malloc(b->length + misalignment);
            if (!moved.memory) abort();
            moved.first = moved.memory + misalignment;
            moved.length = b->length;
            memcpy(moved.first, b->first, b->length);
            free(b->memory);
            *b = moved;
            if (count > 0 || (p->count >= 0 && call->arguments[p->count].size > 0)) must(call, COVBEAM_MISALIGNED);
        }
    }
    a->pointer = b->first;
    const size_t says = p->count < 0 ? 1 : call->arguments[p->count].size;
    bool ignored = is(p->type, "knot") && p->kind == '<' && call->density_kind != COVBEAM_DENSITY_VOXELS;
    if (fault->kind == NULL_POINTER || (p->nullable && chance(3))) {
        a->pointer = NULL;
        if (!p->nullable && says > 0) must(call, COVBEAM_NULL_POINTER);
        ignored |= p->nullable;
    } else if (says == 0 && chance(2)) {
        a->pointer = chance(2) ? NULL : (void *)1;
        if (p->type->size == 1) a->pointer = NULL;
        if (is(p->type, "byte")) a->pointer = b->first;
    }
    if (ignored) {
        /* Not looked at: nothing that is wrong with it matters. */
        call->statuses = before.statuses;
        call->sure = before.sure;
        call->unsure = before.unsure;
        call->meaningless = before.meaningless;
    }
    if (is(p->type, "column") && p->nullable && !a->pointer && says > 0 && call->density_kind == COVBEAM_DENSITY_VOXELS)
        must(call, COVBEAM_NULL_POINTER);
    if (is(p->type, "knot") && p->kind == '>' && says < 1000) {
        may(call, COVBEAM_SHORT_BUFFER);
        call->unsure = true;
    }
    if (is(p->type, "schedule") && !call->tame) call->unsure = true;
    if (is(p->type, "kernel")) memcpy(&call->max_radius, b->first + 12, 4);
}

/* The arrays of the call must have so many elements; now and then they have one more. */
static void whole_picture(struct prepared *call, uint32_t pixels) {
    bool arrays = false;
    for (int i = 0; i < call->function->parameter_count; i++) arrays |= call->function->parameters[i].kind == 'n';
    if (!arrays || pixels > 100) return;
    call->whole = true;
    call->count = pixels;
    if (chance(16)) {
        call->count++;
        must(call, COVBEAM_SHORT_BUFFER);
    }
}

/* The same for a film: an element a pixel, or one for each block of 2 x 2. */
static void film_count(struct prepared *call, const struct slot *slot) {
    const char *name = call->function->name;
    const bool nodes = strcmp(name, "covbeam_film_nodes") == 0 || strcmp(name, "covbeam_film_plan") == 0;
    if (strcmp(name, "covbeam_film_add") == 0) return;
    if (nodes)
        whole_picture(call, (slot->width + 1) / 2 * ((slot->height + 1) / 2));
    else
        whole_picture(call, slot->width * slot->height);
}

/* Numbers of a march that must go together. */
static void march_rules(struct prepared *call) {
    const char *name = call->function->name;
    const bool lay = strcmp(name, "covbeam_march_lay") == 0;
    if (!lay && strcmp(name, "covbeam_march_update") != 0) return;
    if (call->count < 2) must(call, COVBEAM_SHORT_BUFFER);
    if (lay && !(call->arguments[3].number >= call->arguments[2].number)) must(call, COVBEAM_INVALID_VALUE);
    /* What is far away has no angle in floats. */
    if (lay && !call->tame) call->unsure = true;
}

void prepare(struct prepared *call, const struct function *function, const struct fault *faults, int fault_count) {
    static const struct fault none = { NO_FAULT, -1, 0, 0 };
    memset(call, 0, sizeof *call);
    memset(&callbacks, 0, sizeof callbacks);
    callbacks.call = call;
    call->function = function;
    call->tame = !chance(4);
    call->faulty = fault_count == 1 ? faults[0].parameter : -1;
    const uint32_t shape = below(20);
    call->count = shape < 2 ? 0 : shape < 10 ? 1 : shape < 19 ? 2 + below(4) : 1 + below(70);
    for (int i = 0; i < function->parameter_count; i++) call->handles[i] = -1;
    for (int i = 0; i < function->parameter_count; i++) {
        const struct parameter *p = &function->parameters[i];
        union argument *a = &call->arguments[i];
        const struct fault *fault = &none;
        for (int f = 0; f < fault_count; f++)
            if (faults[f].parameter == i && fault == &none) fault = &faults[f];
        switch (p->kind) {
        case 'n': a->size = call->count; break;
        case '$': {
            const char rule = p->word[0];
            a->number = sound_number(rule, call->tame);
            if (fault->kind == WORD) {
                a->number = hostile_number(fault->number);
                call->tame = false;
                if (!number_fits(rule, a->number)) must(call, COVBEAM_INVALID_VALUE);
            }
            if (rule == '+') call->max_radius = a->number;
            if (rule == 'L' && !(a->number > 1e-30f)) call->unsure = true;
            break;
        }
        case '#':
            if (strcmp(p->word, "any") == 0) {
                a->word = (uint32_t)(draw() >> 32);
                break;
            }
            if (strcmp(p->word, "side") == 0) {
                a->word = call->side = 1 + below(4);
                if (fault->kind == WORD) {
                    a->word = fault->number % 2 ? 0 : 0xffffffffu;
                    must(call, a->word ? COVBEAM_SHORT_BUFFER : COVBEAM_INVALID_VALUE);
                }
                break;
            }
            if (strcmp(p->word, "extent") == 0) {
                a->word = 1 + below(9);
                if (fault->kind == WORD) {
                    a->word = fault->number % 3 == 0 ? 0 : fault->number % 3 == 1 ? 65537 : 0xffffffffu;
                    must(call, COVBEAM_INVALID_VALUE);
                }
                if (i == 1) whole_picture(call, call->arguments[0].word * a->word);
                break;
            }
            if (strcmp(p->word, "row") == 0) {
                a->word = 0;
                if (fault->kind == WORD) {
                    a->word = fault->number % 2 ? 3 : 0xffffffffu;
                    must(call, COVBEAM_INVALID_VALUE);
                }
                break;
            }
            a->word = strcmp(p->name, "pass") == 0 ? (chance(4) ? (uint32_t)draw() | 1 : 1 + below(99)) : below(3);
            if (fault->kind == WORD) {
                if (strcmp(p->word, "row") == 0) {
                a->word = 0;
                if (fault->kind == WORD) {
                    a->word = fault->number % 2 ? 3 : 0xffffffffu;
                    must(call, COVBEAM_INVALID_VALUE);
                }
                break;
            }
            a->word = strcmp(p->name, "pass") == 0 ? 0 : fault->number % 2 ? 3 : 0xffffffffu;
                must(call, COVBEAM_INVALID_VALUE);
            }
            break;
        case 'p':
            a->poll = chance(2) || fault->kind == CALLBACK ? ask : NULL;
            if (fault->kind == CALLBACK || chance(12)) callbacks.refuse_poll = 1 + fault->variant / 2 % 3;
            break;
        case 'h':
            a->shade = fault->kind == NULL_POINTER ? NULL : shade;
            /* Without rays nothing is shaded, but the callback is looked at. */
            if (!a->shade) must(call, COVBEAM_NULL_POINTER);
            callbacks.shade_values = chance(3) ? 1 + below(3) : 0;
            if (callbacks.shade_values == 1 || callbacks.shade_values == 2) call->meaningless = true;
            if (fault->kind == CALLBACK || chance(6)) callbacks.refuse_shade = 1 + fault->variant / 2 % 3;
            break;
        case 'x':
            a->probe = fault->kind == NULL_POINTER ? NULL : probe;
            if (!a->probe) must(call, COVBEAM_NULL_POINTER);
            callbacks.shade_values = chance(3) ? 1 + below(3) : 0;
            if (callbacks.shade_values == 1) must(call, COVBEAM_INVALID_VALUE);
            if (fault->kind == CALLBACK || chance(6)) callbacks.refuse_shade = 1 + fault->variant / 2 % 3;
            break;
        case 'u': a->pointer = &callbacks; break;
        case '@': case '!': case '+':
            handle_argument(call, i, fault);
            if (call->handles[i] >= 0 && pool[call->handles[i]].kind == PICTURE) film_count(call, &pool[call->handles[i]]);
            break;
        case '<': case '>': case '=': pointer_argument(call, i, fault, faults, fault_count); break;
        default: break; /* strides and lengths are set with their arrays */
        }
    }
    march_rules(call);
    for (int i = 0; i < function->parameter_count; i++)
        if (call->whole && function->parameters[i].kind == 'n' && call->arguments[i].size != call->count)
            must(call, COVBEAM_SHORT_BUFFER);
    const int map = call->handles[0];
    if (map >= 0 && function->parameters[0].committed && pool[map].committed && call->max_radius > pool[map].max_radius)
        must(call, COVBEAM_MISMATCH);
}

void release(struct prepared *call) {
    for (int i = 0; i < call->function->parameter_count; i++) {
        free(call->buffers[i].memory);
        free(call->buffers[i].before);
    }
    free_tables();
}
