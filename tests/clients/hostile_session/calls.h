/* The functions of covbeam_session.h, called on a few objects. */
#ifndef HOSTILE_SESSION_CALLS_H
#define HOSTILE_SESSION_CALLS_H

#include <stddef.h>
#include <stdint.h>

extern const struct session_call {
    const char *name;
    int32_t (*call)(void);
} session_calls[];
extern const size_t session_call_count;

/* Objects of all kinds, so that the calls have something to work on; and their end. */
void furnish(void);
void unfurnish(void);

/* Of everything that can be seen of an object from outside; 0: there is none. */
enum { OBJECTS = 9 };
uint64_t digest(int object);

#endif
