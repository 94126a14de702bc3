/*
 * A host that guides its light by importance: a lamp in fog, and a camera that looks at a small ball of it. What the lamp's beams
 * leave in the ball is known by quadrature. However the directions are chosen, it must be that, and with fewer beams or less noise.
 */
#include <covbeam_extra.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 16, CANDIDATES = 256, ROUNDS = 400 };

static const double PI = 3.14159265358979, EXTINCTION = 0.4, DISTANCE = 3, RADIUS = 0.5;
static const float LAMP[3] = { 0, 0, 0 };

static void must(covbeam_status status, int line)
{
    if (status == COVBEAM_OK)
        return;
    fprintf(stderr, "importance.c:%d: %s: %s\n", line, covbeam_status_name(status), covbeam_last_error());
    exit(1);
}
#define MUST(call) must(call, __LINE__)

/* What a beam of one watt from the lamp leaves in the ball around (3, 0, 0): the integral of its transmittance. */
static double left_in_ball(const float *direction)
{
    const double middle = DISTANCE * direction[0], aside2 = DISTANCE * DISTANCE - middle * middle;
    if (middle <= 0 || aside2 >= RADIUS * RADIUS)
        return 0;
    const double half = sqrt(RADIUS * RADIUS - aside2);
    return (exp(-EXTINCTION * (middle - half)) - exp(-EXTINCTION * (middle + half))) / EXTINCTION;
}

/* Its mean over all directions: by the midpoint rule over the cosine to the ball's axis. */
static double quadrature(void)
{
    const double least = sqrt(1 - RADIUS * RADIUS / (DISTANCE * DISTANCE));
    const int steps = 1000000;
    double sum = 0;
    for (int i = 0; i < steps; i++) {
        const float direction[3] = { (float)(least + (1 - least) * (i + 0.5) / steps), 0, 0 };
        sum += left_in_ball(direction) / steps;
    }
    return sum * (1 - least) / 2;
}

/* The direction that belongs to a point of the unit square: evenly over the sphere. */
static void aim(const float *point, float *direction)
{
    const double z = 1 - 2 * (double)point[0], r = sqrt(1 - z * z), phi = 2 * PI * (double)point[1];
    direction[0] = (float)(r * cos(phi));
    direction[1] = (float)(r * sin(phi));
    direction[2] = (float)z;
}

/* Mean and standard error of what the rounds have found, and how many beams that took. */
struct estimate {
    double sum, squares, beams;
};

static void add(struct estimate *e, double value, double beams)
{
    e->sum += value;
    e->squares += value * value;
    e->beams += beams;
}

static double error_of(const struct estimate *e)
{
    const double mean = e->sum / ROUNDS;
    return sqrt((e->squares / ROUNDS - mean * mean) / (ROUNDS - 1));
}

static void judge(const char *what, const struct estimate *e, double exact, double error_times_beams)
{
    const double mean = e->sum / ROUNDS, error = error_of(e), cost = error * error * e->beams;
    printf("importance: %s: %.4f of the exact value, standard error %.4f, %.0f beams a round\n", what, mean / exact,
           error / exact, e->beams / ROUNDS);
    /* Five standard errors: one run in two million is farther off. */
    if (fabs(mean - exact) > 5 * error) {
        fprintf(stderr, "importance: %s is not %g but %g\n", what, exact, mean);
        exit(1);
    }
    if (error_times_beams > 0 && cost > 0.2 * error_times_beams) {
        fprintf(stderr, "importance: %s saves less than four fifths of the work\n", what);
        exit(1);
    }
}

/* The camera looks along +y through the ball, and through nothing else. */
static void look(covbeam_importance *importance, const covbeam_medium *fog)
{
    const float weight = 1;
    for (int i = 0; i < 100; i++) {
        const float x = (float)DISTANCE - 0.45f + 0.1f * (float)(i % 10), z = -0.45f + 0.1f * (float)(i / 10);
        const covbeam_eye_ray ray = { { x, -5, z }, { 0, 1, 0 }, INFINITY };
        MUST(covbeam_importance_add_eye_rays(importance, fog, 1, &ray, 0, &weight, 0));
    }
    MUST(covbeam_importance_resolve(importance));
}

static void worth(const covbeam_importance *importance, const covbeam_medium *fog, float (*directions)[3], size_t count,
                  float *worths)
{
    covbeam_eye_ray *rays = malloc(count * sizeof *rays);
    covbeam_segment_importance *found = malloc(count * sizeof *found);
    if (rays == NULL || found == NULL)
        exit(1);
    for (size_t i = 0; i < count; i++) {
        memcpy(rays[i].origin, LAMP, sizeof LAMP);
        memcpy(rays[i].direction, directions[i], sizeof directions[i]);
        rays[i].length = INFINITY;
    }
    MUST(covbeam_importance_of_segments(importance, fog, count, rays, sizeof *rays, found, sizeof *found));
    for (size_t i = 0; i < count; i++)
        worths[i] = found[i].beam;
    free(rays);
    free(found);
}

int main(void)
{
    const covbeam_medium fog = { .struct_size = sizeof fog, .scattering = { 0.4f, 0.4f, 0.4f } };
    const covbeam_grid_layout layout = { { -1, -4, -4 }, { 7, 4, 4 }, { 16, 16, 16 } };
    static float points[CANDIDATES][2], directions[CANDIDATES][3], factors[CANDIDATES], cells[SIDE * SIDE][3];
    static float weights[SIDE * SIDE], guide[SIDE * (SIDE + 1)], places[CANDIDATES][2], densities[CANDIDATES];
    struct estimate plain = { 0, 0, 0 }, windows = { 0, 0, 0 }, guided = { 0, 0, 0 }, wrong = { 0, 0, 0 };
    const double exact = quadrature();
    double factor_sum = 0;
    covbeam_importance *importance;
    MUST(covbeam_importance_new(&layout, &importance));
    look(importance, &fog);
    for (int i = 0; i < SIDE * SIDE; i++) {
        const float middle[2] = { ((float)(i / SIDE) + 0.5f) / SIDE, ((float)(i % SIDE) + 0.5f) / SIDE };
        aim(middle, cells[i]);
    }
    worth(importance, &fog, cells, SIDE * SIDE, weights);
    MUST(covbeam_emission_guide_fill(SIDE, weights, SIDE * SIDE, 0.1f, guide, SIDE * (SIDE + 1)));

    for (uint32_t round = 0; round < ROUNDS; round++) {
        uint32_t paths[CANDIDATES];
        float u;
        double found[4] = { 0, 0, 0, 0 }, beams = 0, total = 0;
        /* Independent numbers: the spread of the rounds is then their error. */
        for (uint32_t i = 0; i < CANDIDATES; i++)
            paths[i] = round * CANDIDATES + i;
        for (uint32_t axis = 0; axis < 2; axis++)
            MUST(covbeam_path_numbers(1, 0, CANDIDATES, paths, sizeof *paths, COVBEAM_EMISSION_DIMENSIONS + axis,
                                      &points[0][axis], sizeof *points));
        MUST(covbeam_path_numbers(2, 0, 1, &round, 0, COVBEAM_EMISSION_DIMENSIONS, &u, 0));
        for (int i = 0; i < CANDIDATES; i++) {
            aim(points[i], directions[i]);
            found[0] += left_in_ball(directions[i]) / CANDIDATES;
        }
        /* Of the directions, as many as one in sixteen, those that are worth it; a tenth of these anywhere. */
        worth(importance, &fog, directions, CANDIDATES, factors);
        for (int i = 0; i < CANDIDATES; i++)
            total += factors[i];
        for (int i = 0; i < CANDIDATES; i++)
            factors[i] = (float)(CANDIDATES / 16 * (0.9 * factors[i] / total + 0.1 / CANDIDATES));
        MUST(covbeam_weight_window(CANDIDATES, factors, sizeof *factors, u));
        for (int i = 0; i < CANDIDATES; i++) {
            found[1] += (double)factors[i] * left_in_ball(directions[i]) / CANDIDATES;
            factor_sum += factors[i];
            beams += factors[i] > 0;
        }
        /* The same number of beams by the guide. */
        MUST(covbeam_emission_guide_warp(SIDE, guide, SIDE * (SIDE + 1), CANDIDATES, points[0], sizeof *points, places[0],
                                         sizeof *places, densities, sizeof *densities));
        for (int i = 0; i < CANDIDATES; i++) {
            aim(places[i], directions[i]);
            found[2] += left_in_ball(directions[i]) / ((double)densities[i] * CANDIDATES);
            found[3] += left_in_ball(directions[i]) / CANDIDATES;
        }
        add(&plain, found[0], CANDIDATES);
        add(&windows, found[1], beams);
        add(&guided, found[2], CANDIDATES);
        add(&wrong, found[3], CANDIDATES);
    }
    covbeam_importance_free(importance);

    /* No more go on than are expected, and fewer where one is worth several. The mean factor is 1, within five standard errors: the
     * variance of a factor is at most that of a path that goes on with a chance of 1/160. */
    if (windows.beams > 16.1 * ROUNDS || windows.beams < 4 * ROUNDS ||
        fabs(factor_sum / ROUNDS / CANDIDATES - 1) > 5 * sqrt(159.0 / ROUNDS / CANDIDATES)) {
        fprintf(stderr, "importance: %g beams, mean factor %g\n", windows.beams / ROUNDS, factor_sum / ROUNDS / CANDIDATES);
        return 1;
    }
    const double error = error_of(&plain), work = error * error * plain.beams;
    judge("all directions", &plain, exact, 0);
    judge("weight windows", &windows, exact, work);
    judge("the emission guide", &guided, exact, work);
    /* The comparison would see a host that forgets the densities. */
    if (fabs(wrong.sum / ROUNDS - exact) < 5 * error_of(&wrong)) {
        fprintf(stderr, "importance: densities make no difference\n");
        return 1;
    }
    return 0;
}
