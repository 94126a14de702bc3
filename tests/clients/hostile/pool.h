/* The objects of a sequence of calls, and what the host may know of each. */
#ifndef HOSTILE_POOL_H
#define HOSTILE_POOL_H

#include "arguments.h"

enum kind { GRID, MAP, DENSITY, SCRATCH, PICTURE, MARCH, IMPORTANCE, KINDS };
enum { SLOTS = 18 };

struct slot {
    enum kind kind;
    void *handle;
    bool resolved, committed, tame, scribbled;
    covbeam_grid_layout layout;
    float max_radius;
    uint32_t width, height; /* of a picture */
    covbeam_grid_cell *cells;   /* memory of the host's, or NULL */
    covbeam_fluence_cell *means;
};

extern struct slot pool[SLOTS];
extern covbeam_light_field fields[16];
extern const covbeam_grid_layout layouts[4];
extern unsigned char *saved;
extern size_t saved_size;

enum kind kind_named(const char *name);
int pick(enum kind kind);
void pool_start(void);
void pool_end(void);
void slot_free(struct slot *slot);
void scribble(struct slot *slot);
size_t layout_cells(const covbeam_grid_layout *layout);

/* Of everything that can be seen of an object from outside. */
uint64_t digest(const struct slot *slot);

#endif
