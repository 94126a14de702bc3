/*
 * Runs the calls of tests/vectors.txt through the C ABI and compares every bit with what the Rust library answered.
 *
 *     vectors FILE
 *
 * The format of the file is described in tests/src/vectors/mod.rs. Functions with a plural are called a second time, all lines of
 * a name at once, in padded arrays.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The parts, in one translation unit: a compiler is given this file alone. */
#include "vectors/calls.h"
#include "vectors/script.c"
#include "vectors/plain.h"
#include "vectors/kernels.c"
#include "vectors/media.c"
#include "vectors/grids.c"
#include "vectors/maps.c"
#include "vectors/film.c"
#include "vectors/march.c"
#include "vectors/importance.c"
#include "vectors/plurals.c"

#define CALL(name) { #name, name }
static const struct {
    const char *name;
    void (*run)(struct call *);
} calls[] = {
    PLAIN_CALLS, CALL(phase_angular_variance), CALL(kernel_evaluate), CALL(kernel_second_moment),
    CALL(kernel_radius_from_error), CALL(kernel_radius_at), CALL(progressive_radius), CALL(error_bound),
    CALL(schedule_kernel), CALL(medium_step), CALL(medium_column_at), CALL(medium_distance_at),
    CALL(medium_opaque_column), CALL(medium_knots), CALL(medium_tabulate), CALL(path_number),
    CALL(segment_field_at), CALL(density_new), CALL(grid_new), CALL(grid_deposit),
    CALL(grid_deposit_spectra), CALL(grid_resolve), CALL(grid_look_up), CALL(grid_save), CALL(cross),
    CALL(gather_pair), CALL(filter_beams), CALL(beam_map_new), CALL(beam_map_clear), CALL(beam_map_add),
    CALL(beam_map_commit), CALL(beam_map_gather), CALL(image_spectrum_along), CALL(pixel_threshold),
    CALL(film_regions), CALL(film_new), CALL(film_nodes), CALL(film_plan), CALL(film_density),
    CALL(film_add), CALL(film_picture), CALL(film_errors), CALL(march_lay), CALL(march_update),
    CALL(march_get_expected), CALL(march_get_first_round), CALL(march_place), CALL(march_refine),
    CALL(importance_new), CALL(importance_add_eye_rays), CALL(importance_add_paths),
    CALL(importance_add_surfaces), CALL(importance_resolve), CALL(importance_at),
    CALL(importance_of_segments), CALL(weight_window), CALL(emission_guide_fill), CALL(emission_guide_warp),
};
enum { CALLS = sizeof calls / sizeof calls[0] };

static void run(const struct line *line, unsigned char *seen)
{
    struct call call = { NULL, 0, NULL, 0 };
    size_t which;
    for (which = 0; which < CALLS && strcmp(calls[which].name, line->name) != 0; which++)
        continue;
    number = line->number;
    if (which == CALLS)
        fail("an unknown name");
    if (strcmp(line->name, "density_new") == 0)
        flush_media();
    number = line->number;
    seen[which] = 1;
    call.line = line;
    call.got = memory(1);
    call.got[0] = '\0';
    calls[which].run(&call);
    if (call.next != line->ins)
        fail("inputs are left over");
    if (strcmp(call.got, line->text) != 0) {
        fprintf(stderr, "line %ld: %s\nexpected%s\nfound   %s\n", line->number, line->name, line->text, call.got);
        exit(1);
    }
    free(call.got);
    wait_for_plural(line);
}

int main(int count, char **arguments)
{
    unsigned char seen[CALLS] = { 0 };
    size_t i, names = 0;
    char *text;
    if (count != 2) {
        fprintf(stderr, "usage: vectors FILE\n");
        return 2;
    }
    text = contents(arguments[1]);
    read_lines(text);
    must(covbeam_scratch_new(&scratch));
    for (i = 0; i < line_count; i++)
        run(&lines[i], seen);
    flush_all();
    for (i = 0; i < CALLS; i++)
        names += seen[i];
    for (i = 0; i < line_count; i++) {
        free(lines[i].in);
        free(lines[i].out);
    }
    covbeam_importance_free(importance);
    covbeam_march_free(march);
    covbeam_film_free(film);
    covbeam_scratch_free(scratch);
    covbeam_beam_map_free(map);
    covbeam_grid_free(grid);
    covbeam_density_free(density);
    free(lines);
    free(text);
    printf("%lu elements in %lu calls of plurals\n", (unsigned long)plural_elements, (unsigned long)plural_calls);
    if (names < CALLS || line_count < 500) {
        fprintf(stderr, "only %lu calls of %lu names\n", (unsigned long)line_count, (unsigned long)names);
        return 1;
    }
    printf("%lu calls, %lu names, all equal\n", (unsigned long)line_count, (unsigned long)names);
    return 0;
}
