/* Image space: spectra of pixels, their filters, regions, and the picture. */
#include "calls.h"

#include <stdlib.h>
#include <string.h>

void image_spectrum_along(struct call *c)
{
    covbeam_medium medium = take_medium(c);
    covbeam_eye_ray ray;
    covbeam_pixel_step steps[2];
    covbeam_image_spectrum spectrum, again[3];
    take(c, &ray, 7);
    take(c, steps, 12);
    must(covbeam_image_spectrum_along(grid, &medium, &ray, steps, &spectrum));
    give(c, &spectrum, 4);
    must(covbeam_image_spectra_along(grid, &medium, 2, &ray, 0, steps, 0, again, 2 * sizeof again[0]));
    equal(&again[2], &spectrum, sizeof spectrum, "covbeam_image_spectra_along: another spectrum");
}

void pixel_threshold(struct call *c)
{
    uint32_t pass = take_u32(c), seed = take_u32(c), pixel[2];
    float threshold, again[4];
    take(c, pixel, 2);
    must(covbeam_pixel_threshold(pass, seed, pixel, &threshold));
    give(c, &threshold, 1);
    must(covbeam_pixel_threshold_many(pass, seed, 2, pixel, 0, again, 12));
    equal(&again[3], &threshold, sizeof threshold, "covbeam_pixel_threshold_many: another threshold");
}

void film_regions(struct call *c)
{
    uint32_t width = take_u32(c), height = take_u32(c);
    size_t i, count = left(c, 1);
    float *depths = spread(c, count, 1, 4);
    uint32_t *labels = memory(12 * count);
    must(covbeam_film_regions(width, height, count, depths, 8, labels, 12));
    for (i = 0; i < count; i++)
        give(c, &labels[3 * i], 1);
    free(depths);
    free(labels);
}

void film_new(struct call *c)
{
    uint32_t width = take_u32(c), height = take_u32(c);
    float typical = take_float(c);
    size_t count = left(c, 1);
    uint32_t *regions = spread(c, count, 1, 8);
    covbeam_film_free(film);
    must(covbeam_film_new(width, height, typical, count, regions, 12, &film));
    free(regions);
}

void film_nodes(struct call *c)
{
    size_t i, count;
    uint32_t *pixels;
    must(covbeam_film_get_node_count(film, &count));
    pixels = memory(12 * count);
    must(covbeam_film_nodes(film, count, pixels, 12));
    for (i = 0; i < count; i++)
        give(c, &pixels[3 * i], 2);
    free(pixels);
}

void film_plan(struct call *c)
{
    uint32_t pass = take_u32(c), paths;
    float error = take_float(c);
    size_t count;
    covbeam_image_spectrum *spectra;
    paths = take_u32(c);
    count = left(c, 4);
    spectra = spread(c, count, 4, 4);
    must(covbeam_film_plan(film, pass, error, paths, count, spectra, sizeof *spectra + 4, NULL, NULL));
    free(spectra);
}

/* As many as the picture has pixels: those of the current line's results. */
static size_t results(struct call *c, size_t words) { return c->line->outs / words; }

void film_density(struct call *c)
{
    size_t i, count = results(c, 1);
    float *densities = memory(8 * count);
    must(covbeam_film_density(film, count, densities, 8));
    for (i = 0; i < count; i++)
        give(c, &densities[2 * i], 1);
    free(densities);
}

void film_add(struct call *c)
{
    size_t count = left(c, 10);
    covbeam_film_ray *rays = spread(c, count, 10, 4);
    must(covbeam_film_add(film, count, rays, sizeof *rays + 4));
    free(rays);
}

void film_picture(struct call *c)
{
    size_t i, count = results(c, 8);
    covbeam_film_pixel *pixels = memory(count * sizeof *pixels);
    must(covbeam_film_verify(film, NULL, NULL));
    must(covbeam_film_picture(film, 0, count, pixels, sizeof *pixels));
    for (i = 0; i < count; i++)
        give(c, &pixels[i], 8);
    free(pixels);
}

void film_errors(struct call *c)
{
    uint32_t width = take_u32(c), height = take_u32(c);
    size_t i, count = left(c, 2);
    covbeam_film_pixel *pixels = memory(count * sizeof *pixels);
    float *errors = memory(8 * count);
    memset(pixels, 0, count * sizeof *pixels);
    for (i = 0; i < count; i++) {
        pixels[i].variance = take_float(c);
        pixels[i].difference = take_float(c);
    }
    must(covbeam_film_errors(width, height, count, pixels, sizeof *pixels, errors, 8));
    for (i = 0; i < count; i++)
        give(c, &errors[2 * i], 1);
    free(pixels);
    free(errors);
}
