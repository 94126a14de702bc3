/*
 * Locks of Rust's standard library, for ThreadSanitizer: the library is built with it, and the standard library that comes with the compiler is not.
 * Of a lock that is free, taken by inlined code, it sees everything; but not that one which was waited for is had, that a wait gives it away
 * meanwhile, or that something is made once. Linked with --wrap for each of these, whose mangled names LOCK, WAIT, WAIT_LONG and ONCE are, it is told
 * so where it happens, of that very lock: nothing else is hidden from it.
 *
 * Nor does it know fences. Counts of owners (Arc) are let go with Release, and whoever is the last has a fence of Acquire before he frees: here each
 * of them acquires, too.
 */
#include <stdint.h>

void __tsan_acquire(void *address);
void __tsan_release(void *address);

#define JOIN(a, b) a##b
#define NAMED(prefix, name) JOIN(prefix, name)
/* In registers, as C passes them: no function of these has more. */
#define ARGUMENTS void *a, void *b, uint64_t c, uint64_t d, uint64_t e, uint64_t f

#define WRAP(name, before, after)                        \
    uint64_t NAMED(__real_, name)(ARGUMENTS);            \
    uint64_t NAMED(__wrap_, name)(ARGUMENTS) {           \
        before;                                          \
        const uint64_t result = NAMED(__real_, name)(a, b, c, d, e, f); \
        after;                                           \
        return result;                                   \
    }
WRAP(LOCK, (void)0, __tsan_acquire(a))
WRAP(WAIT, __tsan_release(b), __tsan_acquire(b))
WRAP(WAIT_LONG, __tsan_release(b), __tsan_acquire(b))
WRAP(ONCE, (void)0, (__tsan_release(a), __tsan_acquire(a)))

uint64_t __real___tsan_atomic64_fetch_sub(volatile uint64_t *address, uint64_t value, int order);
uint64_t __wrap___tsan_atomic64_fetch_sub(volatile uint64_t *address, uint64_t value, int order) {
    (void)order;
    return __real___tsan_atomic64_fetch_sub(address, value, __ATOMIC_ACQ_REL);
}
