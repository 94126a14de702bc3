/* A host with geometry, materials, lamps and a camera of its own, for programs that test sessions: a ball in fog, above a floor. */
#ifndef HOSTED_H
#define HOSTED_H

#include "covbeam_session.h"
#include <stdbool.h>
#include <stdint.h>

enum { HOSTED_WIDTH = 8, HOSTED_PIXELS = HOSTED_WIDTH * HOSTED_WIDTH };

/* What a host's functions are called with. Counters are changed from many threads at once. */
struct hosted {
    uint64_t lies;           /* one answer in so many is a lie; 0: none */
    uint64_t seed;           /* of the lies; they depend on the answers before, too */
    uint64_t asked[7];       /* cast, blocked, lobes, scatter, emit, illuminate, eye */
    uint64_t told[7];        /* lies */
    void (*meanwhile)(void); /* called from each cast; NULL: nothing is */
};

/* All functions of a host; without `blocked` if it is to do without. */
covbeam_host hosted_host(struct hosted *hosted, bool has_blocked);
/* A scene of it, of which all that can be is the host's own. All arrays are static. */
covbeam_description hosted_description(void);
/* Few light paths and numbers that need no survey: a pass takes a millisecond. */
covbeam_session_settings hosted_settings(uint32_t method);

/* Answers that have been given, and lies among them. */
uint64_t hosted_sum(const uint64_t *counters);

#endif
