/*
 * covbeam beside another library in Rust, both static: each catches its own panics. covbeam has none that a host could bring about, so
 * the C library gets a defect: linked with --wrap=clock_gettime, it has no time for a thread while `broken`, and Rust's standard library panics.
 */
#define _POSIX_C_SOURCE 200809L
#include "hosted.h"
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

int32_t other_caught(void);
int __real_clock_gettime(clockid_t clock, struct timespec *now);

/* Of the thread that calls, or of all others: the session's. */
static __thread bool broken, calls;
static volatile bool others_broken;

int __wrap_clock_gettime(clockid_t clock, struct timespec *now) {
    errno = EINVAL;
    return broken || (others_broken && !calls) ? -1 : __real_clock_gettime(clock, now);
}

static void check(bool holds, const char *what) {
    if (holds) return;
    fprintf(stderr, "two_rusts: %s (%s)\n", what, covbeam_last_error());
    exit(1);
}

enum without_time { NOBODY, CALLER, OTHERS };

static int32_t passes(uint64_t count, enum without_time who) {
    static struct hosted hosted;
    const covbeam_host host = hosted_host(&hosted, true);
    const covbeam_description description = hosted_description();
    const covbeam_session_settings settings = hosted_settings(COVBEAM_METHOD_THESIS);
    const covbeam_goal goal = { .struct_size = sizeof goal, .passes = count };
    covbeam_scene *scene;
    covbeam_session *session;
    check(covbeam_scene_new_of_host(&host, &description, &scene) == COVBEAM_OK, "no scene");
    check(covbeam_session_new(1, (const covbeam_scene *const *)&scene, 0, &settings, NULL, NULL, &session) == COVBEAM_OK, "no session");
    calls = true;
    broken = who == CALLER;
    others_broken = who == OTHERS;
    const int32_t status = covbeam_session_until(session, &goal, NULL, NULL, NULL);
    broken = others_broken = false;
    check(covbeam_session_free(session) == COVBEAM_OK && covbeam_scene_free(scene) == COVBEAM_OK, "not freed");
    return status;
}

int main(void) {
    check(other_caught() == 7, "the other library has not caught its panic");
    check(passes(2, CALLER) == COVBEAM_PANICKED, "covbeam has not caught its panic");
    check(passes(2, NOBODY) == COVBEAM_OK, "no passes after a panic");
    check(passes(2, OTHERS) == COVBEAM_PANICKED && strstr(covbeam_last_error(), "defect of covbeam"), "a panic of a session's thread");
    check(passes(2, NOBODY) == COVBEAM_OK, "no passes after a panic of a thread");
    check(other_caught() == 7, "the other library has not caught its second panic");
    return 0;
}
