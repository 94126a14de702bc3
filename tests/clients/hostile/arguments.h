/* What a hostile host passes: arguments that are right, and every way to spoil one of them. */
#ifndef HOSTILE_ARGUMENTS_H
#define HOSTILE_ARGUMENTS_H

#include "types.h"

enum fault_kind {
    NO_FAULT,
    NULL_POINTER,      /* variant: none */
    MISALIGNED,        /* variant: by how many bytes */
    WORD,              /* variant: which word, which hostile number */
    HUGE_COUNT,
    HOSTILE_STRIDE,
    WRONG_HANDLE,
    STRUCT_SIZE,
    WRONG_LENGTH,      /* of a packed array */
    INSIDE,            /* what a struct points to */
    CALLBACK,          /* poll or shade says no */
    FAULT_KINDS
};

struct fault {
    enum fault_kind kind;
    int parameter;
    uint32_t variant, number;
};

int variants(const struct function *function, int parameter, enum fault_kind kind, bool *numbers);

/* Memory of one argument, to the byte as long as the call may use it. */
struct buffer {
    unsigned char *memory, *first, *before;
    size_t length, stride, count;
};

/* A call that is ready, and what may come of it. */
struct prepared {
    const struct function *function;
    union argument arguments[PARAMETERS];
    struct buffer buffers[PARAMETERS];
    size_t count;       /* of the arrays */
    uint32_t statuses;  /* of the faults: one of these must be returned, if there are any */
    bool sure;          /* a fault that must be noticed */
    bool unsure;        /* something that may be refused */
    bool tame;          /* no numbers near the ends of the range */
    bool meaningless;   /* tables out of order, NaN from a callback: results mean nothing */
    int faulty;         /* the one parameter with a fault, or -1 */
    int layout;         /* of the grid that is made */
    bool whole;         /* the arrays have an element a pixel of a picture */
    uint32_t density_kind;
    uint32_t side;      /* of a guide, before it is spoiled */
    float max_radius;
    int handles[PARAMETERS]; /* slots of the pool, or -1 */
};

void prepare(struct prepared *call, const struct function *function, const struct fault *faults, int count);
void release(struct prepared *call);

/* What the callbacks of the running call have done. */
struct callbacks {
    const struct prepared *call;
    uint32_t polls, refuse_poll;
    uint32_t shades, refuse_shade;
    uint32_t shade_values; /* 0 sound, 1 NaN, 2 huge, 3 none; of a probe, too */
    bool refused, failed, wrong, nonsense; /* a probe has answered none */
};
extern struct callbacks callbacks;

#endif
