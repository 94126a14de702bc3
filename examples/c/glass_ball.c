/*
 * A glass ball in fog: the least that a renderer has to do for covbeam.
 *
 * In a pass, photons leave the lamp, and every straight piece of their paths through the fog is a beam. A tenth
 * of them also carry a light field, which says how quickly the light around them varies. Then eye rays gather the
 * beams, each as wide as the light there allows. The picture is the mean of the passes.
 */
#include "renderer.h"
#include <covbeam.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { TILE = 8, KINDS = 5 };
enum { PHOTONS, PIXELS }; /* sequences of decisions */

static const float LAMP[3] = { 1.0f, 2.4f, 0.0f }; /* a point */
static const float INTENSITY = 25.0f;              /* W/sr; all is grey here: one number for three channels */
static const float EYE[3] = { 0.0f, 0.0f, -4.0f }; /* a pinhole that looks along +z; +y is up, +x on the left */
static const float TAN_HALF = 0.36397023f;         /* of 40 degrees from top to bottom */
static const covbeam_medium FOG = { .struct_size = sizeof FOG, /* without end */
    .scattering = { 0.15f, 0.15f, 0.15f }, .absorption = { 0.15f, 0.15f, 0.15f } };
static const float ALBEDO = 0.5f, EXTINCTION = 0.3f; /* the same once more */
static const covbeam_grid_layout VOXELS = { { -3, -3, -4 }, { 3, 3, 3 }, { 32, 32, 32 } }; /* all that is seen */
static const covbeam_schedule SCHEDULE = { .struct_size = sizeof SCHEDULE,
    .shape = COVBEAM_KERNEL_EPANECHNIKOV, .radius = 0.05f, .alpha = 0.5f, .max_radius = 0.1f, .error = 0.01f };

#define TRY(call) check(call, #call, __LINE__)

static void check(covbeam_status status, const char *call, int line)
{
    if (status == COVBEAM_OK)
        return;
    fprintf(stderr, "line %d: %s\n%s: %s\n", line, call, covbeam_status_name(status), covbeam_last_error());
    exit(EXIT_FAILURE);
}

/* Leaves the light field of a beam in the grid, and moves it on by the photon's flight. The silhouette of the ball
 * cuts the light that passes it or falls into it; farther away than a quarter of its depth it does not matter. For
 * shapes without a formula there is covbeam_find_edges. */
static void leave_field(covbeam_light_field *field, const path *p, const covbeam_beam *beam, int unscattered,
    float flight, covbeam_grid *grid)
{
    covbeam_segment segment = { .length = beam->length, .power = beam->power[0], .field = *field };
    segment.unscattered = (uint32_t)unscattered;
    copy(p->position, segment.origin);
    covbeam_edge *edge = &segment.edges[0];
    float depth = -dot(p->position, p->direction);
    add(p->position, depth, p->direction, edge->towards);
    edge->depth = fminf(depth, beam->length);
    edge->distance = fabsf(sqrtf(dot(edge->towards, edge->towards)) - RADIUS);
    segment.edge_count = p->place == IN_FOG && depth > 0 && edge->distance < 0.25f * depth
        && dot(edge->towards, edge->towards) > 0;
    TRY(covbeam_grid_deposit(grid, &FOG, 1, &segment, sizeof segment, NULL, NULL));
    TRY(covbeam_segment_field_at(&segment, &FOG, flight, field));
}

/* What chance decides on a path: the first decisions of many paths are spread evenly. */
typedef struct {
    uint32_t seed, sequence, path, next;
} decisions;

static float decide(decisions *d)
{
    float number;
    TRY(covbeam_path_number(d->seed, d->sequence, d->path, d->next++, &number));
    return number;
}

/* Follows a photon to its end. Its beams go into the map; field is NULL, or its light field at the lamp. */
static void trace_photon(path p, float power, covbeam_light_field *field, decisions *chance, covbeam_beam_map *map,
    covbeam_grid *grid)
{
    /* Convex on the side of the outward normal, from whichever side the light comes. */
    const covbeam_curvature curvature = { .along = 1 / RADIUS, .across = 1 / RADIUS };
    int unscattered = 1;
    float opaque, lobe;
    TRY(covbeam_medium_opaque_column(&FOG, &opaque));
    TRY(covbeam_phase_angular_variance(&FOG.phase, &lobe));
    for (;;) {
        float distance = distance_to_ball(&p), flight = INFINITY;
        if (p.place != IN_BALL) {
            /* A beam runs to the next surface, or until nothing is left of it: not to the next collision. */
            covbeam_beam beam = { .length = fminf(distance, opaque), .power = { power, power, power } };
            copy(p.position, beam.origin);
            copy(p.direction, beam.direction);
            copy(p.normal, beam.start_normal);
            if (distance <= opaque) {
                add(p.position, distance, p.direction, beam.end_normal);
                normalize(beam.end_normal);
            }
            TRY(covbeam_beam_map_add(map, 1, &beam, sizeof beam));
            flight = -log1pf(-decide(chance)) / EXTINCTION;
            if (field)
                leave_field(field, &p, &beam, unscattered, fminf(flight, distance), grid);
        } else if (field) {
            TRY(covbeam_light_field_travel(field, distance));
        }
        if (flight < distance) {
            if (decide(chance) >= ALBEDO)
                return;
            float xi[2];
            xi[0] = decide(chance);
            xi[1] = decide(chance);
            add(p.position, flight, p.direction, p.position);
            TRY(covbeam_phase_sample(&FOG.phase, p.direction, xi, p.direction));
            if (field)
                TRY(covbeam_light_field_scatter(field, p.direction, lobe));
            memset(p.normal, 0, sizeof p.normal);
            p.place = IN_FOG;
            unscattered = 0;
        } else {
            path reflected, refracted;
            float eta;
            uint8_t passed;
            int back = decide(chance) < meet_ball(&p, distance, &eta, &reflected, &refracted);
            if (field && back)
                TRY(covbeam_light_field_reflect(field, p.normal, &curvature));
            else if (field)
                TRY(covbeam_light_field_refract(field, p.normal, &curvature, eta, &passed));
            p = back ? reflected : refracted;
        }
    }
}

static void trace_photons(uint64_t pass, uint64_t photons, uint32_t seed, covbeam_beam_map *map, covbeam_grid *grid)
{
    for (uint64_t i = (pass - 1) * photons; i < pass * photons; i++) {
        decisions chance = { seed, PHOTONS, (uint32_t)i, 0 };
        float z = 1 - 2 * decide(&chance), r = sqrtf(fmaxf(1 - z * z, 0.0f)), phi = 6.2831853f * decide(&chance);
        path p = { .direction = { r * cosf(phi), r * sinf(phi), z } };
        normalize(p.direction);
        copy(LAMP, p.position);
        /* The light of a point falls off as 1/d^2: its relative curvature across the ray is 2/d^2, that of a
         * spectrum with an angular variance of 2/(4 pi^2). */
        covbeam_light_field field;
        TRY(covbeam_light_field_point(p.direction, COVBEAM_EVEN_LAMP, &field));
        float power = 12.566371f * INTENSITY / (float)photons;
        trace_photon(p, power, grid && i % 10 == 0 ? &field : NULL, &chance, map, grid);
    }
}

/* The eye rays of a tile by what they have met: a gather is quickest for rays that run side by side. */
typedef struct {
    covbeam_eye_ray rays[KINDS][TILE * TILE];
    float weights[KINDS][TILE * TILE];
    float *pixels[KINDS][TILE * TILE];
    size_t count[KINDS];
} tile;

static void see(tile *t, int kind, const path *p, float length, float weight, float *pixel)
{
    size_t i = t->count[kind]++;
    copy(p->position, t->rays[kind][i].origin);
    copy(p->direction, t->rays[kind][i].direction);
    t->rays[kind][i].length = length;
    t->weights[kind][i] = weight;
    t->pixels[kind][i] = pixel;
}

/* An eye path: up to the ball, what is reflected there, what leaves it again after 0, 1 and 2 reflections inside. */
static void trace_eye(path p, float *pixel, tile *t)
{
    path reflected, refracted;
    float eta, distance = distance_to_ball(&p), weight = expf(-EXTINCTION * distance);
    see(t, 0, &p, distance, 1, pixel);
    if (distance == INFINITY)
        return;
    float reflectance = meet_ball(&p, distance, &eta, &reflected, &refracted);
    see(t, 1, &reflected, INFINITY, weight * reflectance, pixel);
    weight *= 1 - reflectance;
    for (int kind = 2; kind < KINDS; kind++) {
        p = kind == 2 ? refracted : reflected;
        reflectance = meet_ball(&p, distance_to_ball(&p), &eta, &reflected, &refracted);
        see(t, kind, &refracted, INFINITY, weight * (1 - reflectance), pixel);
        weight *= reflectance;
    }
}

/* Adds what the pixels of a tile see. Returns the number of pairs of beam and eye ray. */
static uint64_t gather_tile(int x0, int y0, int size, const float *jitter, float (*picture)[3],
    const covbeam_beam_map *map, const covbeam_kernel *kernel, const covbeam_grid *grid, covbeam_scratch *scratch)
{
    tile t = { .count = { 0 } };
    covbeam_gathered gathered[TILE * TILE];
    float scale = 2 * TAN_HALF / (float)size, middle = 0.5f * (float)size;
    for (int y = y0; y < y0 + TILE; y++)
        for (int x = x0; x < x0 + TILE; x++) {
            path p = { .direction = { (middle - (float)x - jitter[0]) * scale,
                           (middle - (float)y - jitter[1]) * scale, 1 } };
            normalize(p.direction);
            copy(EYE, p.position);
            trace_eye(p, picture[y * size + x], &t);
        }
    uint64_t pairs = 0;
    for (int kind = 0; kind < KINDS; kind++) {
        TRY(covbeam_beam_map_gather(map, kernel, grid, t.count[kind], t.rays[kind], sizeof t.rays[kind][0],
            gathered, sizeof gathered[0], scratch, NULL, NULL));
        for (size_t i = 0; i < t.count[kind]; i++) {
            add(t.pixels[kind][i], t.weights[kind][i], gathered[i].radiance, t.pixels[kind][i]);
            pairs += gathered[i].pairs;
        }
    }
    return pairs;
}

static void render(float (*picture)[3], int size, uint32_t passes, uint64_t photons, uint32_t seed, int plain)
{
    covbeam_beam_map *map;
    covbeam_grid *grid = NULL;
    covbeam_scratch *scratch;
    TRY(covbeam_beam_map_new(&FOG, &map));
    TRY(covbeam_scratch_new(&scratch));
    if (!plain)
        TRY(covbeam_grid_new(&VOXELS, &grid));
    uint64_t pairs = 0;
    clock_t tracing = 0, committing = 0, gathering = 0;

    for (uint32_t pass = 1; pass <= passes; pass++) {
        clock_t begin = clock();
        covbeam_kernel kernel = { .struct_size = sizeof kernel };
        TRY(covbeam_schedule_kernel(&SCHEDULE, pass, &kernel));
        if (plain)
            kernel.max_radius = kernel.min_radius;
        TRY(covbeam_beam_map_clear(map));
        trace_photons(pass, photons, seed, map, grid);
        clock_t traced = clock();

        if (grid)
            TRY(covbeam_grid_resolve(grid));
        TRY(covbeam_beam_map_commit(map, kernel.max_radius, NULL, NULL));
        clock_t committed = clock();

        /* Where in the pixels the eye rays of the pass lie. */
        decisions chance = { seed, PIXELS, pass, 0 };
        float jitter[2];
        jitter[0] = decide(&chance);
        jitter[1] = decide(&chance);
        for (int y = 0; y < size; y += TILE)
            for (int x = 0; x < size; x += TILE)
                pairs += gather_tile(x, y, size, jitter, picture, map, &kernel, grid, scratch);
        tracing += traced - begin;
        committing += committed - traced;
        gathering += clock() - committed;
    }
    const double second = (double)CLOCKS_PER_SEC;
    printf("passes %u, trace %.2f s, commit %.2f s, gather %.2f s, pairs %.1f million\n", (unsigned)passes,
        (double)tracing / second, (double)committing / second, (double)gathering / second, 1e-6 * (double)pairs);
    covbeam_beam_map_free(map);
    covbeam_grid_free(grid);
    covbeam_scratch_free(scratch);
}

int main(int count, char **arguments)
{
    const char *out = "glass_ball.pfm";
    unsigned long numbers[4] = { 16, 5000, 1, 256 };
    const char *const names[4] = { "--passes", "--photons", "--seed", "--size" };
    int plain = 0, bad = 0;
    for (int i = 1; i < count; i++) {
        int option = 0;
        while (option < 4 && strcmp(arguments[i], names[option]))
            option++;
        char *end = NULL;
        if (option < 4 && i + 1 < count) {
            numbers[option] = strtoul(arguments[++i], &end, 10);
            bad |= end == arguments[i] || *end || numbers[option] < 1 || numbers[option] > 1000000;
        } else if (!strcmp(arguments[i], "--plain")) {
            plain = 1;
        } else {
            out = arguments[i];
            bad |= out[0] == '-';
        }
    }
    int size = (int)numbers[3];
    if (bad || size % TILE || size > 4096) {
        fprintf(stderr, "usage: glass_ball [OUT.pfm] [--passes N] [--photons N] [--seed N] [--size N] [--plain]\n"
                        "N is 1 to 1000000; --size: pixels across, a multiple of 8 up to 4096;\n"
                        "--plain: all kernels equally wide, as in progressive photon beams\n");
        return EXIT_FAILURE;
    }
    if (covbeam_abi_version() != COVBEAM_ABI_VERSION) {
        fprintf(stderr, "covbeam %s is not the library of this program's covbeam.h\n", covbeam_version());
        return EXIT_FAILURE;
    }
    float(*picture)[3] = calloc((size_t)size * (size_t)size, sizeof *picture);
    if (!picture) {
        perror("the picture");
        return EXIT_FAILURE;
    }
    render(picture, size, (uint32_t)numbers[0], numbers[1], (uint32_t)numbers[2], plain);
    int written = write_pfm(out, size, picture, 1 / (float)numbers[0]);
    free(picture);
    if (!written) {
        perror(out);
        return EXIT_FAILURE;
    }
    return EXIT_SUCCESS;
}
