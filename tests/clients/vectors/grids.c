/* Densities and grids. */
#include "calls.h"

#include <stdlib.h>
#include <string.h>

void density_new(struct call *c)
{
    covbeam_grid_layout layout;
    size_t count;
    float *values;
    take(c, &layout, 9);
    count = left(c, 1);
    values = spread(c, count, 1, 8);
    covbeam_density_free(density);
    must(covbeam_density_new(&layout, values, 12, count, &density));
    free(values);
}

void grid_new(struct call *c)
{
    covbeam_grid_layout layout, again;
    take(c, &layout, 9);
    covbeam_grid_free(grid);
    must(covbeam_grid_new(&layout, &grid));
    must(covbeam_grid_get_layout(grid, &again));
    equal(&layout, &again, sizeof layout, "covbeam_grid_get_layout: another layout");
}

void grid_deposit(struct call *c)
{
    covbeam_medium medium = take_medium(c);
    size_t count = 0;
    struct padded {
        covbeam_segment segment;
        double pad;
    } *segments = memory(left(c, 1) / SEGMENT_WORDS * sizeof *segments);
    while (left(c, 1) > 0)
        segments[count++].segment = take_segment(c);
    must(covbeam_grid_deposit(grid, &medium, count, &segments[0].segment, sizeof *segments, NULL, NULL));
    free(segments);
}

void segment_field_at(struct call *c)
{
    covbeam_segment segment = take_segment(c);
    covbeam_medium medium = take_medium(c);
    covbeam_light_field field;
    must(covbeam_segment_field_at(&segment, &medium, take_float(c), &field));
    give(c, &field, 16);
}

void grid_deposit_spectra(struct call *c)
{
    covbeam_spectrum spectrum;
    float position[3], weight;
    take(c, position, 3);
    take(c, &spectrum, 6);
    weight = take_float(c);
    must(covbeam_grid_deposit_spectra(grid, 1, position, 0, &spectrum, 0, &weight, 0));
}

void grid_resolve(struct call *c)
{
    const covbeam_grid_cell *cells;
    const covbeam_fluence_cell *means;
    covbeam_grid_cell *own;
    covbeam_fluence_cell *own_means;
    covbeam_grid_layout layout;
    covbeam_grid *hosted;
    size_t count, mean_count;
    (void)c;
    must(covbeam_grid_resolve(grid));
    /* The same in the host's memory. */
    must(covbeam_grid_get_layout(grid, &layout));
    must(covbeam_grid_get_cells(grid, &cells, &count));
    must(covbeam_grid_get_means(grid, &means, &mean_count));
    equal(&count, &mean_count, sizeof count, "as many means as cells");
    own = memory(count * sizeof *own);
    own_means = memory(count * sizeof *own_means);
    memcpy(own, cells, count * sizeof *own);
    must(covbeam_grid_new_in(&layout, own, count, own_means, count, &hosted));
    must(covbeam_grid_resolve(hosted));
    equal(own_means, means, count * sizeof *means, "covbeam_grid_new_in: other means");
    covbeam_grid_free(hosted);
    free(own);
    free(own_means);
}

void grid_look_up(struct call *c)
{
    size_t i, count = left(c, 3);
    float *positions = spread(c, count, 3, 4);
    struct padded {
        covbeam_spectrum spectrum;
        uint32_t pad;
    } *spectra = memory(count * sizeof *spectra);
    uint8_t *found = memory(3 * count);
    must(covbeam_grid_look_up(grid, count, positions, 16, &spectra[0].spectrum, sizeof *spectra, found, 3));
    for (i = 0; i < count; i++) {
        give_flag(c, found[3 * i]);
        give(c, &spectra[i].spectrum, 6);
    }
    free(positions);
    free(spectra);
    free(found);
}

static unsigned char *saved(covbeam_grid *of, size_t *size)
{
    unsigned char *bytes;
    must(covbeam_grid_get_saved_size(of, size));
    bytes = memory(*size);
    must(covbeam_grid_save(of, bytes, *size));
    return bytes;
}

void grid_save(struct call *c)
{
    covbeam_grid_layout layout;
    covbeam_grid *loaded, *sum, *empty;
    const covbeam_grid *others[1];
    size_t i, size, again;
    unsigned char *bytes = saved(grid, &size), *other;
    uint64_t hash = UINT64_C(0xcbf29ce484222325);
    for (i = 0; i < size; i++)
        hash = (hash ^ bytes[i]) * UINT64_C(0x100000001b3);
    give_long(c, size);
    give_long(c, hash);
    /* Loaded, and added to an empty grid, it is the same; cleared, it is empty. */
    must(covbeam_grid_load(bytes, size, &loaded));
    must(covbeam_grid_get_layout(loaded, &layout));
    must(covbeam_grid_new(&layout, &sum));
    must(covbeam_grid_new(&layout, &empty));
    others[0] = loaded;
    must(covbeam_grid_merge(sum, others, 1));
    other = saved(sum, &again);
    equal(bytes, other, size, "covbeam_grid_merge: other sums");
    free(other);
    free(bytes);
    must(covbeam_grid_clear(sum));
    bytes = saved(empty, &size);
    other = saved(sum, &again);
    equal(bytes, other, size, "covbeam_grid_clear: not empty");
    free(other);
    free(bytes);
    covbeam_grid_free(loaded);
    covbeam_grid_free(sum);
    covbeam_grid_free(empty);
}
