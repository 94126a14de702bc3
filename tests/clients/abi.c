/*
 * The layout of every public struct, the values of every enum and the versions, as numbers. They are those of ffi/src/layout.rs:
 * what differs between the compilers of host and library fails to compile here or there.
 *
 *     abi VERSION        the version that covbeam_version() must give
 */
#include <covbeam_extra.h>

#include <stdio.h>
#include <string.h>

#if __STDC_VERSION__ >= 201112L
#define ASSERT(name, claim) _Static_assert(claim, #claim)
#define ALIGNMENT(type) _Alignof(type)
#else
/* An array of a negative length does not compile. */
#define ASSERT(name, claim) typedef char assert_##name[(claim) ? 1 : -1]
#define ALIGNMENT(type) offsetof(struct { char first; type second; }, second)
#endif

#define SIZE(type, bytes, alignment)                                    \
    ASSERT(size_of_##type, sizeof(covbeam_##type) == (bytes));          \
    ASSERT(alignment_of_##type, ALIGNMENT(covbeam_##type) == (alignment));
#define AT(type, field, offset) ASSERT(type##_##field, offsetof(covbeam_##type, field) == (offset));
#define VALUE(name, value) ASSERT(name, COVBEAM_##name == (value));

ASSERT(pointers, sizeof(void *) == 8 && sizeof(size_t) == 8);
ASSERT(functions, sizeof(covbeam_poll) == 8 && sizeof(covbeam_shade) == 8 && sizeof(covbeam_probe) == 8);

#include "layout.h"

int main(int count, char **arguments)
{
    static const struct {
        covbeam_status status;
        const char *name;
    } names[] = {
#define NAME(status) { status, #status }
        NAME(COVBEAM_OK), NAME(COVBEAM_NULL_POINTER), NAME(COVBEAM_MISALIGNED), NAME(COVBEAM_INVALID_VALUE),
        NAME(COVBEAM_INVALID_ARRAY), NAME(COVBEAM_SHORT_BUFFER), NAME(COVBEAM_INVALID_HANDLE),
        NAME(COVBEAM_WRONG_ORDER), NAME(COVBEAM_MISMATCH), NAME(COVBEAM_BAD_DATA), NAME(COVBEAM_OUT_OF_MEMORY),
        NAME(COVBEAM_CANCELLED), NAME(COVBEAM_CALLBACK_FAILED), NAME(COVBEAM_POISONED), NAME(COVBEAM_PANICKED), NAME(COVBEAM_BUSY),
    };
    size_t i, known = sizeof names / sizeof names[0];
    if (count != 2) {
        fprintf(stderr, "usage: abi VERSION\n");
        return 2;
    }
    if (covbeam_abi_version() != COVBEAM_ABI_VERSION) {
        fprintf(stderr, "the library has ABI %u, the header %u\n", (unsigned)covbeam_abi_version(),
                (unsigned)COVBEAM_ABI_VERSION);
        return 1;
    }
    if (strcmp(covbeam_version(), arguments[1]) != 0) {
        fprintf(stderr, "the library is %s, not %s\n", covbeam_version(), arguments[1]);
        return 1;
    }
    for (i = 0; i < known; i++)
        if (strcmp(covbeam_status_name(names[i].status), names[i].name) != 0) {
            fprintf(stderr, "%s is called %s\n", names[i].name, covbeam_status_name(names[i].status));
            return 1;
        }
    if (strcmp(covbeam_status_name((covbeam_status)known), "unknown status") != 0 ||
        strcmp(covbeam_status_name(-1), "unknown status") != 0) {
        fprintf(stderr, "a number that is no status has a name\n");
        return 1;
    }
    if (strcmp(covbeam_last_error(), "") != 0) {
        fprintf(stderr, "a message before the first failure: %s\n", covbeam_last_error());
        return 1;
    }
    printf("covbeam %s, ABI %u, %u statuses: layouts and values equal\n", covbeam_version(),
           (unsigned)covbeam_abi_version(), (unsigned)known);
    return 0;
}
