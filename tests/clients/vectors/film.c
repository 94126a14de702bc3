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

void image_spectrum_filter(struct call *c)
{
    covbeam_image_spectrum spectrum;
    covbeam_image_filter filter;
    float error, widest;
    take(c, &spectrum, 4);
    error = take_float(c);
    widest = take_float(c);
    must(covbeam_image_spectrum_filter(&spectrum, error, widest, &filter));
    give(c, &filter, 3);
}

void image_filter_density(struct call *c)
{
    covbeam_image_filter filter;
    float density_of;
    take(c, &filter, 3);
    must(covbeam_image_filter_density(&filter, &density_of));
    give(c, &density_of, 1);
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

void reconstruction_new(struct call *c)
{
    uint32_t width = take_u32(c), height = take_u32(c);
    covbeam_reconstruction_free(picture);
    must(covbeam_reconstruction_new(width, height, &picture));
}

void reconstruction_update(struct call *c)
{
    size_t count = left(c, 5);
    covbeam_film_sample *samples = spread(c, count, 4, 4);
    uint32_t *regions = spread(c, count, 1, 8);
    must(covbeam_reconstruction_update(picture, count, samples, sizeof *samples + 4, regions, 12));
    free(samples);
    free(regions);
}

void reconstruction_pixel(struct call *c)
{
    uint32_t pixel[2];
    covbeam_image_filter filter;
    float radiance[3], again[7];
    take(c, pixel, 2);
    take(c, &filter, 3);
    must(covbeam_reconstruction_pixel(picture, pixel, &filter, radiance));
    give(c, radiance, 3);
    must(covbeam_reconstruction_pixel_many(picture, 2, pixel, 0, &filter, 0, again, 16));
    equal(&again[4], radiance, sizeof radiance, "covbeam_reconstruction_pixel_many: another radiance");
}
