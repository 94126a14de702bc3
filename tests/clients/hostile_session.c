/*
 * A host that does everything wrong with sessions: hostile_session SEQUENCES SEED
 *
 * First each argument of each function of covbeam_session.h is spoiled in turn, down to each number of each struct; then come random sequences of
 * calls on a few geometries, scenes and sessions, with some arguments spoiled. After each call: the status is one that what was spoiled allows; a
 * call that was refused has a message, has written nothing, and has changed no geometry and no session; polls come from the thread of the call, and
 * not after they have said no; and pictures, of whatever scene was taken, are finite numbers not below 0. In the end each function has succeeded
 * at least once. `hostile_session --list` prints the functions that it calls.
 */
#include "hostile_session/calls.h"
#include "hostile_session/spoil.h"
#include "hostile/types.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static uint64_t by_status[COVBEAM_BUSY + 1], succeeded[64];

/* Calls a function, with this argument spoiled; -1: with none. */
static void perform(const struct session_call *function, int which, int how) {
    uint64_t digests[OBJECTS];
    for (int i = 0; i < OBJECTS; i++) digests[i] = digest(i);
    faulty = which;
    variant = how;
    begin(function->name);
    const int32_t status = function->call();
    calls++;
    if (status < 0 || status > COVBEAM_BUSY || status == COVBEAM_PANICKED || status == COVBEAM_POISONED)
        fail("never to be returned", status);
    by_status[status]++;
    succeeded[function - session_calls] += status == COVBEAM_OK;
    if (polls.wrong) fail("a poll of another thread, or after it had said no", status);
    /* What is nearly done when a poll says no is done. */
    if (status == COVBEAM_CANCELLED ? !polls.refused : status == COVBEAM_OK ? call.sure : !(call.statuses >> status & 1))
        fail("another status was to be expected", status);
    if (status != COVBEAM_OK && strlen(covbeam_last_error()) < 8) fail("no message", status);
    const bool keeps_some = (status == COVBEAM_CANCELLED && strstr(function->name, "until")) ||
        strcmp(function->name, "covbeam_geometry_add_instances") == 0 || strcmp(function->name, "covbeam_geometry_build") == 0;
    for (int i = 0; i < OBJECTS && status != COVBEAM_OK && !keeps_some; i++)
        if (digest(i) != digests[i]) fail("an object has changed that must not", status);
    free_blocks(status);
}

/* Every argument of every function, spoiled in every way. */
static void systematic(void) {
    for (size_t f = 0; f < session_call_count; f++) {
        furnish();
        perform(&session_calls[f], -1, 0);
        int ways[16];
        memcpy(ways, limits, sizeof ways);
        for (int which = 0; which < 16; which++)
            for (int how = 0; how < ways[which]; how++) {
                /* Sessions that are made in spite of it take their time. */
                if (strcmp(session_calls[f].name, "covbeam_session_new") == 0 && how > 9 && !chance(4)) continue;
                perform(&session_calls[f], which, how);
                if (strstr(session_calls[f].name, "_free")) {
                    unfurnish();
                    furnish();
                }
            }
        unfurnish();
    }
}

static void random_sequence(void) {
    furnish();
    for (uint32_t left = 10 + below(20); left > 0; left--) {
        const struct session_call *function = &session_calls[below((uint32_t)session_call_count)];
        /* Half of them render, or look at what was rendered. */
        if (chance(2)) function = &session_calls[9 + below(7)];
        perform(function, chance(3) ? (int)below(12) : -1, (int)below(chance(2) ? 6 : 400));
    }
    unfurnish();
}

int main(int argc, char **argv) {
    if (argc == 2 && strcmp(argv[1], "--list") == 0) {
        for (size_t i = 0; i < session_call_count; i++) puts(session_calls[i].name);
        return 0;
    }
    if (argc != 3) {
        fprintf(stderr, "usage: hostile_session SEQUENCES SEED | --list\n");
        return 2;
    }
    const uint64_t sequences = strtoull(argv[1], NULL, 10);
    seed = strtoull(argv[2], NULL, 10);
    random_state = seed * 0x9e3779b97f4a7c15u + 0x1234567;
    systematic();
    const uint64_t first = calls;
    for (uint64_t i = 0; i < sequences; i++) random_sequence();
    printf("sessions, seed %llu: %llu systematic calls; %llu sequences of %llu calls\n", (unsigned long long)seed, (unsigned long long)first,
           (unsigned long long)sequences, (unsigned long long)(calls - first));
    for (int32_t status = 0; status <= COVBEAM_BUSY; status++)
        if (by_status[status] > 0) printf("  %-24s %12llu\n", covbeam_status_name(status), (unsigned long long)by_status[status]);
    for (size_t i = 0; i < session_call_count; i++)
        if (succeeded[i] == 0) {
            fprintf(stderr, "hostile_session: seed %llu: %s has never succeeded: too few sequences\n", (unsigned long long)seed, session_calls[i].name);
            return 1;
        }
    return 0;
}
