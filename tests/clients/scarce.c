#include "scarce.h"
#include <errno.h>
#include <stddef.h>

/* Linked with --wrap for each of these: calls of the program and of the library come here. */
void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *memory, size_t size);
int __real_posix_memalign(void **memory, size_t alignment, size_t size);
void __real_free(void *memory);

static uint64_t left;
static bool failed;
int64_t scarce_live;

void scarce_begin(uint64_t k)
{
    left = k;
    failed = false;
}

bool scarce_end(void)
{
    left = 0;
    return failed;
}

/* Whether this request is the one to be refused. */
static bool refused(void)
{
    if (left == 0 || --left > 0) return false;
    failed = true;
    return true;
}

static void *counted(void *memory)
{
    scarce_live += memory != NULL;
    return memory;
}

void *__wrap_malloc(size_t size)
{
    return refused() ? NULL : counted(__real_malloc(size));
}

void *__wrap_calloc(size_t count, size_t size)
{
    return refused() ? NULL : counted(__real_calloc(count, size));
}

void *__wrap_realloc(void *memory, size_t size)
{
    if (refused()) return NULL;
    void *moved = __real_realloc(memory, size);
    return memory ? moved : counted(moved);
}

int __wrap_posix_memalign(void **memory, size_t alignment, size_t size)
{
    if (refused()) return ENOMEM;
    const int status = __real_posix_memalign(memory, alignment, size);
    scarce_live += status == 0;
    return status;
}

void __wrap_free(void *memory)
{
    scarce_live -= memory != NULL;
    __real_free(memory);
}
