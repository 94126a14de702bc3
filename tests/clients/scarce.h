/* Memory that runs out on request. Programs with this are linked with
 * -Wl,--wrap=malloc,--wrap=calloc,--wrap=realloc,--wrap=posix_memalign,--wrap=free, so that the library's requests come here. */
#ifndef SCARCE_H
#define SCARCE_H

#include <stdbool.h>
#include <stdint.h>

/* Refuses the kth request from now on, counted from 1. */
void scarce_begin(uint64_t k);
/* Refuses no more; whether one was refused. */
bool scarce_end(void);
/* Pieces of memory that have not been freed. */
extern int64_t scarce_live;

#endif
