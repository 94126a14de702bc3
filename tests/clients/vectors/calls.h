/* What the files of the client vectors.c share. */
#ifndef CALLS_H
#define CALLS_H

#include <covbeam_extra.h>

/* Of a segment without edges. */
enum { MEDIUM_WORDS = 16, PHASE_WORDS = 2, SEGMENT_WORDS = 23 };

/* One line of the file. */
struct line {
    long number;
    const char *name;
    const char *text; /* expected words, as they stand in the file */
    uint64_t *in, *out;
    size_t ins, outs;
};

/* Reads the inputs of a line and collects its results. */
struct call {
    const struct line *line;
    size_t next;
    char *got;
    size_t length;
};

/* script.c: what has been read, and what the lines so far have made. */
extern struct line *lines;
extern size_t line_count;
extern long number; /* of the current line, for messages */
extern covbeam_density *density;
extern covbeam_grid *grid;
extern covbeam_beam_map *map;
extern covbeam_scratch *scratch;
extern covbeam_film *film;
extern covbeam_march *march;
extern covbeam_importance *importance;

char *contents(const char *path);
void read_lines(char *text);

void fail(const char *what);
void must(covbeam_status status);
void equal(const void *a, const void *b, size_t size, const char *what);
void *memory(size_t size);
/* Words of 32 bits into a float, a u32, an array or a struct of these. */
void take(struct call *c, void *to, size_t words);
/* How many elements of so many words are left. */
size_t left(const struct call *c, size_t words);
float take_float(struct call *c);
uint32_t take_u32(struct call *c);
covbeam_medium take_medium(struct call *c);
covbeam_segment take_segment(struct call *c);
covbeam_kernel take_kernel(struct call *c);
/* Words of what was found. */
void give(struct call *c, const void *from, size_t words);
void give_flag(struct call *c, uint8_t flag);
void give_long(struct call *c, uint64_t word);
/* An array in memory, `pad` bytes between its elements. */
void *spread(struct call *c, size_t count, size_t words, size_t pad);

/* media.c: the table along a ray, and the column that it is. */
covbeam_knot *tabulated(const covbeam_medium *medium, const float *origin, const float *direction, float length,
                        size_t *count, covbeam_column *column);

/* plurals.c: a line waits for others of its name; flush_media() calls for those that may have the density. */
void wait_for_plural(const struct line *line);
void flush_media(void);
void flush_all(void);
extern size_t plural_calls, plural_elements;

/* The functions of the ABI, one line each. */
void phase_angular_variance(struct call *c);
void kernel_evaluate(struct call *c);
void kernel_second_moment(struct call *c);
void kernel_radius_from_error(struct call *c);
void kernel_radius_at(struct call *c);
void progressive_radius(struct call *c);
void error_bound(struct call *c);
void schedule_kernel(struct call *c);
void medium_step(struct call *c);
void medium_column_at(struct call *c);
void medium_distance_at(struct call *c);
void medium_opaque_column(struct call *c);
void medium_knots(struct call *c);
void medium_tabulate(struct call *c);
void density_new(struct call *c);
void grid_new(struct call *c);
void segment_field_at(struct call *c);
void path_number(struct call *c);
void grid_deposit(struct call *c);
void grid_deposit_spectra(struct call *c);
void grid_resolve(struct call *c);
void grid_look_up(struct call *c);
void grid_save(struct call *c);
void cross(struct call *c);
void gather_pair(struct call *c);
void filter_beams(struct call *c);
void beam_map_new(struct call *c);
void beam_map_clear(struct call *c);
void beam_map_add(struct call *c);
void beam_map_commit(struct call *c);
void beam_map_gather(struct call *c);
void image_spectrum_along(struct call *c);
void pixel_threshold(struct call *c);
void film_regions(struct call *c);
void film_new(struct call *c);
void film_nodes(struct call *c);
void film_plan(struct call *c);
void film_density(struct call *c);
void film_add(struct call *c);
void film_picture(struct call *c);
void film_errors(struct call *c);
void march_lay(struct call *c);
void march_update(struct call *c);
void march_get_expected(struct call *c);
void march_get_first_round(struct call *c);
void march_place(struct call *c);
void march_refine(struct call *c);
void importance_new(struct call *c);
void importance_add_eye_rays(struct call *c);
void importance_add_paths(struct call *c);
void importance_add_surfaces(struct call *c);
void importance_resolve(struct call *c);
void importance_at(struct call *c);
void importance_of_segments(struct call *c);
void weight_window(struct call *c);
void emission_guide_fill(struct call *c);
void emission_guide_warp(struct call *c);

#endif
