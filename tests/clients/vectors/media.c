/* Media at points and along rays. */
#include "calls.h"

#include <stdlib.h>

void medium_step(struct call *c)
{
    covbeam_medium medium = take_medium(c);
    float step;
    must(covbeam_medium_step(&medium, &step));
    give(c, &step, 1);
}

void medium_opaque_column(struct call *c)
{
    covbeam_medium medium = take_medium(c);
    float column;
    must(covbeam_medium_opaque_column(&medium, &column));
    give(c, &column, 1);
}

void medium_column_at(struct call *c)
{
    covbeam_medium medium = take_medium(c);
    float origin[3], direction[3], distance, value, again[4];
    take(c, origin, 3);
    take(c, direction, 3);
    distance = take_float(c);
    must(covbeam_medium_column_at(&medium, origin, direction, distance, &value));
    give(c, &value, 1);
    if (medium.density != COVBEAM_DENSITY_VOXELS) {
        covbeam_column column;
        must(covbeam_medium_column(&medium, origin, direction, NULL, 0, &column));
        must(covbeam_column_at(&column, distance, &again[0]));
        must(covbeam_column_at_many(&column, 2, &distance, 0, &again[1], 8));
        equal(&again[0], &value, 4, "covbeam_column_at: another column");
        equal(&again[3], &value, 4, "covbeam_column_at_many: another column");
    }
}

void medium_distance_at(struct call *c)
{
    covbeam_medium medium = take_medium(c);
    float origin[3], direction[3], a[2], distance, again[4];
    take(c, origin, 3);
    take(c, direction, 3);
    take(c, a, 2);
    must(covbeam_medium_distance_at(&medium, origin, direction, a[0], a[1], &distance));
    give(c, &distance, 1);
    if (medium.density != COVBEAM_DENSITY_VOXELS) {
        covbeam_column column;
        must(covbeam_medium_column(&medium, origin, direction, NULL, 0, &column));
        must(covbeam_column_distance_at(&column, a[1], &again[0]));
        must(covbeam_column_distance_at_many(&column, 2, &a[1], 0, &again[1], 8));
        equal(&again[3], &again[0], 4, "covbeam_column_distance_at_many: another distance");
        if (again[0] <= a[0])
            equal(&again[0], &distance, 4, "covbeam_column_distance_at: another distance");
    }
}

void medium_knots(struct call *c)
{
    covbeam_medium medium = take_medium(c);
    float origin[3], direction[3], a[3];
    covbeam_knot *knots;
    size_t count, again;
    take(c, origin, 3);
    take(c, direction, 3);
    take(c, a, 3);
    must(covbeam_medium_knots(&medium, origin, direction, a[0], a[1], a[2], NULL, 0, &count));
    knots = memory(count * sizeof *knots);
    must(covbeam_medium_knots(&medium, origin, direction, a[0], a[1], a[2], knots, count, &again));
    equal(&count, &again, sizeof count, "covbeam_medium_knots: counted otherwise");
    give(c, knots, 2 * count);
    free(knots);
}

/* The table along a ray, and the column that it is. */
covbeam_knot *tabulated(const covbeam_medium *medium, const float *origin, const float *direction,
                               float length, size_t *count, covbeam_column *column)
{
    covbeam_knot *knots;
    must(covbeam_medium_tabulate(medium, origin, direction, length, NULL, 0, count));
    knots = memory(*count * sizeof *knots);
    must(covbeam_medium_tabulate(medium, origin, direction, length, knots, *count, count));
    must(covbeam_medium_column(medium, origin, direction, knots, *count, column));
    return knots;
}

void medium_tabulate(struct call *c)
{
    covbeam_medium medium = take_medium(c);
    float origin[3], direction[3], value;
    covbeam_column column;
    covbeam_knot *knots;
    size_t count, i;
    take(c, origin, 3);
    take(c, direction, 3);
    knots = tabulated(&medium, origin, direction, take_float(c), &count, &column);
    give(c, knots, 2 * count);
    for (i = 0; i < count; i++)
        if (i + 1 == count || knots[i + 1].distance > knots[i].distance) {
            must(covbeam_column_at(&column, knots[i].distance, &value));
            equal(&value, &knots[i].column, 4, "covbeam_column_at: not the knot's column");
        }
    free(knots);
}
