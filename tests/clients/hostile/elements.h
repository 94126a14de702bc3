/* The elements of arrays: sound ones, and what is done to them. */
#ifndef HOSTILE_ELEMENTS_H
#define HOSTILE_ELEMENTS_H

#include "arguments.h"

/* A status that may, or must, come of what has been done to an argument. */
void may(struct prepared *call, int32_t status);
void must(struct prepared *call, int32_t status);

struct buffer memory(size_t count, size_t stride, size_t size, uint32_t misalignment);

/* A table of columns exactly as long as it says, until free_tables. */
covbeam_knot *new_table(size_t count, uint32_t misalignment, bool ordered);
void free_tables(void);

void sound_element(struct prepared *call, const struct parameter *p, unsigned char *at);

/* Makes one word hostile, or what the struct points to. */
void spoil_word(struct prepared *call, const struct parameter *p, unsigned char *at, const struct fault *fault);
void spoil_inside(struct prepared *call, const struct parameter *p, unsigned char *at, uint32_t variant);

/* An options struct of another size than the header's. */
struct buffer other_size(struct prepared *call, const struct parameter *p, const unsigned char *element, uint32_t variant);

#endif
