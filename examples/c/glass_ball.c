/*
 * A glass ball in fog: the least that a renderer has to do for covbeam.
 *
 * In a pass, photons leave the lamp, and every straight piece of their paths through the fog is a beam. A tenth
 * of them, by a sequence of their own, also carry a light field, which says how quickly the light around them varies. Then eye rays gather the
 * beams, each as wide as the light there allows. The picture is the mean of the passes.
 */
#include "renderer.h"
#include <covbeam.h>

enum { PHOTONS, PIXELS, FIELDS }; /* sequences of decisions */

static const float INTENSITY = 25.0f; /* W/sr; all is grey here: one number for three channels */
static const covbeam_medium FOG = { .struct_size = sizeof FOG, /* without end */
    .scattering = { 0.15f, 0.15f, 0.15f }, .absorption = { 0.15f, 0.15f, 0.15f } };
static const float ALBEDO = 0.5f, EXTINCTION = 0.3f; /* the same once more */
static const covbeam_grid_layout VOXELS = { { -3, -3, -4 }, { 3, 3, 3 }, { 32, 32, 32 } }; /* all that is seen */
static const covbeam_schedule SCHEDULE = { .struct_size = sizeof SCHEDULE,
    .shape = COVBEAM_KERNEL_EPANECHNIKOV, .radius = 0.05f, .alpha = 0.5f, .max_radius = 0.1f, .error = 0.01f };

#define TRY(call) check(call, #call, __LINE__)

static void check(covbeam_status status, const char *call, int line)
{
    if (status != COVBEAM_OK) {
        fprintf(stderr, "line %d: %s\n%s: %s\n", line, call, covbeam_status_name(status), covbeam_last_error());
        exit(EXIT_FAILURE);
    }
}

/* Leaves the light field of a beam in the grid, and moves it on by the photon's flight. The silhouette of the ball
 * cuts the light that passes it or falls into it; farther away than a quarter of its depth it does not matter. For
 * shapes without a formula there is covbeam_find_edges. */
static void leave_field(covbeam_light_field *field, const path *p, const covbeam_beam *beam, uint32_t unscattered,
    float flight, covbeam_grid *grid)
{
    covbeam_segment segment = { .length = beam->length, .power = beam->power[0], .unscattered = unscattered,
        .field = *field };
    copy(p->position, segment.origin);
    covbeam_edge *edge = &segment.edges[0];
    float depth = silhouette(p, &edge->distance, edge->towards);
    edge->depth = fminf(depth, beam->length);
    segment.edge_count = edge->distance < 0.25f * depth;
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
    uint32_t unscattered = 1;
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
            if (distance <= opaque)
                ball_normal(&p, distance, beam.end_normal);
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
            float u = decide(chance), v = decide(chance), xi[2] = { u, v };
            enter_fog(&p, flight);
            TRY(covbeam_phase_sample(&FOG.phase, p.direction, xi, p.direction));
            if (field)
                TRY(covbeam_light_field_scatter(field, p.direction, lobe));
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

/* Those of a pass that make their decisions by one sequence. Of a sequence that fills the lamp evenly every tenth point does
 * not: so those with light fields have a sequence of their own. */
static void trace_photons(uint32_t sequence, uint32_t count, uint32_t pass, const options *o, covbeam_beam_map *map,
    covbeam_grid *grid)
{
    for (uint64_t i = (uint64_t)(pass - 1) * count; i < (uint64_t)pass * count; i++) {
        decisions chance = { o->seed, sequence, (uint32_t)i, 0 };
        float u = decide(&chance), v = decide(&chance);
        path p = leave_lamp(u, v);
        covbeam_light_field field; /* the light of a point falls off as 1/d^2: COVBEAM_EVEN_LAMP */
        TRY(covbeam_light_field_point(p.direction, COVBEAM_EVEN_LAMP, &field));
        float power = 12.566371f * INTENSITY / (float)o->photons;
        trace_photon(p, power, grid ? &field : NULL, &chance, map, grid);
    }
}

/* Adds what the pixels of a tile see. Returns the number of pairs of beam and eye ray. */
static uint64_t gather_tile(const tile *t, const covbeam_kernel *kernel, const covbeam_beam_map *map,
    const covbeam_grid *grid, covbeam_scratch *scratch)
{
    uint64_t pairs = 0;
    for (int kind = 0; kind < KINDS; kind++) {
        const piece *pieces = t->pieces[kind];
        covbeam_eye_ray rays[TILE * TILE];
        covbeam_gathered gathered[TILE * TILE];
        for (size_t i = 0; i < t->count[kind]; i++) {
            copy(pieces[i].start.position, rays[i].origin);
            copy(pieces[i].start.direction, rays[i].direction);
            rays[i].length = pieces[i].length;
        }
        TRY(covbeam_beam_map_gather(map, kernel, grid, t->count[kind], rays, sizeof rays[0], gathered,
            sizeof gathered[0], scratch, NULL, NULL));
        for (size_t i = 0; i < t->count[kind]; i++) {
            add(pieces[i].pixel, pieces[i].weight, gathered[i].radiance, pieces[i].pixel);
            pairs += gathered[i].pairs;
        }
    }
    return pairs;
}

static void render(float (*picture)[3], const options *o)
{
    covbeam_beam_map *map;
    covbeam_grid *grid = NULL;
    covbeam_scratch *scratch;
    TRY(covbeam_beam_map_new(&FOG, &map));
    TRY(covbeam_scratch_new(&scratch));
    if (!o->plain)
        TRY(covbeam_grid_new(&VOXELS, &grid));
    uint64_t pairs = 0;
    double tracing = 0, committing = 0, gathering = 0;
    clock_t last = clock();
    const uint32_t fields = (o->photons + 9) / 10; /* photons with light fields: enough for the grid */
    for (uint32_t pass = 1; pass <= o->passes; pass++) {
        covbeam_kernel kernel = { .struct_size = sizeof kernel };
        TRY(covbeam_schedule_kernel(&SCHEDULE, pass, &kernel));
        if (o->plain)
            kernel.max_radius = kernel.min_radius;
        TRY(covbeam_beam_map_clear(map));
        trace_photons(FIELDS, fields, pass, o, map, grid);
        trace_photons(PHOTONS, o->photons - fields, pass, o, map, NULL);
        lap(&last, &tracing);
        if (grid)
            TRY(covbeam_grid_resolve(grid));
        TRY(covbeam_beam_map_commit(map, kernel.max_radius, NULL, NULL));
        lap(&last, &committing);
        decisions chance = { o->seed, PIXELS, pass, 0 };
        float u = decide(&chance), v = decide(&chance), in_pixel[2] = { u, v }; /* where the pass' eye rays lie */
        for (int y = 0; y < o->size; y += TILE)
            for (int x = 0; x < o->size; x += TILE) {
                tile t;
                trace_tile(x, y, o->size, in_pixel, EXTINCTION, picture, &t);
                pairs += gather_tile(&t, &kernel, map, grid, scratch);
            }
        lap(&last, &gathering);
    }
    printf("passes %u, trace %.2f s, commit %.2f s, gather %.2f s, pairs %.1f million\n", (unsigned)o->passes,
        tracing, committing, gathering, 1e-6 * (double)pairs);
    covbeam_beam_map_free(map);
    covbeam_grid_free(grid);
    covbeam_scratch_free(scratch);
}

int main(int count, char **arguments)
{
    const options o = read_options(count, arguments);
    if (covbeam_abi_version() != COVBEAM_ABI_VERSION) {
        fprintf(stderr, "covbeam %s is not the library of this program's covbeam.h\n", covbeam_version());
        return EXIT_FAILURE;
    }
    float(*picture)[3] = new_picture(o.size);
    render(picture, &o);
    write_pfm(o.out, o.size, picture, 1 / (float)o.passes);
    free(picture);
    return EXIT_SUCCESS;
}
