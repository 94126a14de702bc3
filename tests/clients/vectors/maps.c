/* Pairs of ray and beam, and maps of beams. */
#include "calls.h"

#include <stdlib.h>
#include <string.h>

static covbeam_medium map_medium;
static covbeam_beam *beams;
static size_t beam_count;

void cross(struct call *c)
{
    covbeam_eye_ray ray;
    covbeam_beam beam;
    covbeam_crossing crossing, again[2];
    uint8_t crosses = 2, flags[4];
    memset(&crossing, 0, sizeof crossing);
    memset(again, 0, sizeof again);
    take(c, &ray, 7);
    take(c, &beam, 16);
    must(covbeam_cross(&ray, &beam, &crossing, &crosses));
    give_flag(c, crosses);
    give(c, &crossing, 7);
    must(covbeam_cross_many(&ray, 2, &beam, 0, again, sizeof again[0], flags, 3));
    equal(&again[1], &crossing, sizeof crossing, "covbeam_cross_many: another crossing");
    equal(&flags[3], &crosses, 1, "covbeam_cross_many: another flag");
}

void gather_pair(struct call *c)
{
    covbeam_grid *used = take_u32(c) ? grid : NULL;
    covbeam_medium medium = take_medium(c);
    covbeam_kernel kernel = take_kernel(c);
    float part[2];
    covbeam_eye_ray ray;
    covbeam_beam beam;
    covbeam_gathered gathered, many;
    uint8_t accepted = 2, flags[3];
    take(c, part, 2);
    take(c, &ray, 7);
    take(c, &beam, 16);
    memset(&gathered, 0, sizeof gathered);
    memset(&many, 0, sizeof many);
    must(covbeam_gather_pair(&ray, &beam, part[0], part[1], &medium, NULL, NULL, &kernel, used, &gathered,
                             &accepted));
    give_flag(c, accepted);
    give(c, &gathered, 7);
    /* Twice the same beam is the pair added to itself. */
    must(covbeam_gather_pair(&ray, &beam, part[0], part[1], &medium, NULL, NULL, &kernel, used, &gathered,
                             &accepted));
    must(covbeam_gather_pairs(&ray, 2, &beam, 0, &part[0], 0, &part[1], 0, &medium, NULL, NULL, 0, &kernel,
                              used, &many, flags, 2));
    equal(&many, &gathered, sizeof many, "covbeam_gather_pairs: another sum");
    equal(&flags[2], &accepted, 1, "covbeam_gather_pairs: another flag");
}

void filter_beams(struct call *c)
{
    covbeam_eye_ray ray;
    size_t i, count;
    covbeam_beam *some;
    uint8_t *masks;
    take(c, &ray, 7);
    count = (c->line->ins - 8) / 16;
    some = spread(c, count, 16, 12);
    masks = memory(2 * count);
    must(covbeam_filter_beams(&ray, count, some, sizeof *some + 12, take_float(c), masks, 2));
    for (i = 0; i < count; i++)
        give_flag(c, masks[2 * i]);
    free(some);
    free(masks);
}

void beam_map_new(struct call *c)
{
    map_medium = take_medium(c);
    covbeam_beam_map_free(map);
    must(covbeam_beam_map_new(&map_medium, &map));
    beam_count = 0;
}

void beam_map_clear(struct call *c)
{
    (void)c;
    must(covbeam_beam_map_clear(map));
    beam_count = 0;
}

void beam_map_add(struct call *c)
{
    size_t i, count = left(c, 16), all;
    covbeam_beam *some = spread(c, count, 16, 4);
    must(covbeam_beam_map_add(map, count, some, sizeof *some + 4));
    beams = realloc(beams, (beam_count + count + 1) * sizeof *beams);
    if (beams == NULL)
        fail("no memory");
    for (i = 0; i < count; i++)
        memcpy(&beams[beam_count++], (char *)some + i * (sizeof *some + 4), sizeof *some);
    free(some);
    must(covbeam_beam_map_get_count(map, &all));
    equal(&all, &beam_count, sizeof all, "covbeam_beam_map_get_count: another number");
}

static int32_t never(void *user)
{
    ++*(long *)user;
    return 0;
}

void beam_map_commit(struct call *c)
{
    long polled = 0;
    must(covbeam_beam_map_commit(map, take_float(c), never, &polled));
    if (polled == 0)
        fail("covbeam_beam_map_commit: did not poll");
}

static int32_t dark(void *user, const covbeam_contact *contacts, size_t count, float *values)
{
    size_t *all = user;
    (void)contacts;
    (void)values;
    *all += count;
    return 0;
}

/* A map of one beam gathers what the pair does, with the tables that the host makes. */
static void one_pair(const covbeam_kernel *kernel, const covbeam_grid *used, const covbeam_eye_ray *ray,
                     const covbeam_gathered *gathered)
{
    covbeam_column along_ray, along_beam;
    covbeam_gathered pair;
    uint8_t accepted;
    size_t count;
    covbeam_knot *of_ray =
        tabulated(&map_medium, ray->origin, ray->direction, ray->length, &count, &along_ray);
    covbeam_knot *of_beam =
        tabulated(&map_medium, beams->origin, beams->direction, beams->length, &count, &along_beam);
    memset(&pair, 0, sizeof pair);
    must(covbeam_gather_pair(ray, beams, 0.0f, beams->length, &map_medium, &along_ray, &along_beam, kernel,
                             used, &pair, &accepted));
    equal(&pair, gathered, sizeof pair, "covbeam_gather_pair: not what the map of one beam gathers");
    free(of_ray);
    free(of_beam);
}

void beam_map_gather(struct call *c)
{
    covbeam_grid *used = take_u32(c) ? grid : NULL;
    covbeam_kernel kernel = take_kernel(c);
    size_t i, count = left(c, 7), contacts = 0, pairs = 0;
    covbeam_eye_ray *rays = spread(c, count, 7, 4);
    size_t stride = sizeof *rays + 4;
    struct padded {
        covbeam_gathered gathered;
        uint32_t pad[2];
    } *gathered = memory(count * sizeof *gathered);
    must(covbeam_beam_map_gather(map, &kernel, used, count, rays, stride, &gathered[0].gathered,
                                 sizeof *gathered, scratch, NULL, NULL));
    for (i = 0; i < count; i++) {
        give(c, &gathered[i].gathered, 7);
        pairs += gathered[i].gathered.pairs;
    }
    if (count == 1 && beam_count == 1)
        one_pair(&kernel, used, rays, &gathered[0].gathered);
    must(covbeam_beam_map_gather_shaded(map, &kernel, used, count, rays, stride, &gathered[0].gathered,
                                        sizeof *gathered, NULL, dark, NULL, &contacts));
    equal(&contacts, &pairs, sizeof pairs, "covbeam_beam_map_gather_shaded: not as many contacts as pairs");
    free(rays);
    free(gathered);
}
