"""Image space: how many eye rays the in-scattered light needs where, and the picture from those that were traced.

    spectra = image.along(grid, medium, rays, steps)           # of the pixels, or of some of them
    filters = image.filters(spectra, error, widest)
    chosen = image.thresholds(pass_, seed, pixels) < image.densities(filters)
    ...                                                         # trace those; samples: sums over light / density, 1 / density
    picture = Reconstruction(width, height)
    picture.update(samples, regions(width, height, depths))
    light = picture.pixels(pixels, filters)
"""

import numpy as np

from ._arrays import COUNT, FLOAT, PIXEL, VECTOR, WORD, Kind, elementwise, given, made, optional, struct
from ._handles import Object, Owner, using
from ._library import lib
from .dtypes import EYE_RAY, FILM_SAMPLE, IMAGE_FILTER, IMAGE_SPECTRUM, PIXEL_STEP
from .media import Medium


def along(grid, medium, rays, steps, *, out=None):
    """The spectrum of the in-scattered light around pixels, read off a grid along their eye rays: IMAGE_SPECTRUM, all 0 where the
    grid has no opinion.

    - grid: a Grid that has been resolved.
    - medium: a Medium that the rays are in.
    - rays: EYE_RAY, from the eye to where the light that they gather ends, or infinite.
    - steps: PIXEL_STEP of shape (2,) or (n, 2): how each ray changes with a pixel to the right, and with one down.
    """
    with using(grid) as [handle]:
        return elementwise(
            lib.covbeam_image_spectra_along,
            handle,
            struct("medium", medium, Medium),
            COUNT,
            given("rays", rays, Kind(EYE_RAY)),
            given("steps", steps, Kind(PIXEL_STEP, 2)),
            made("out", out, Kind(IMAGE_SPECTRUM)),
        )


def filters(spectra, errors, widests, *, out=None):
    """The reconstruction filters that blur the picture by a relative bias: IMAGE_FILTER, all 0 where the grid had no opinion.

    - spectra: IMAGE_SPECTRUM.
    - errors: the relative bias > 0.
    - widests: largest standard deviation [pixels] > 0.
    """
    return elementwise(
        lib.covbeam_image_spectra_filter,
        COUNT,
        given("spectra", spectra, Kind(IMAGE_SPECTRUM)),
        given("errors", errors, FLOAT),
        given("widests", widests, FLOAT),
        made("out", out, Kind(IMAGE_FILTER)),
    )


def densities(filters, *, out=None):
    """Eye rays that pixels need in a pass, in (0, 1]: two under each filter.

    - filters: IMAGE_FILTER.
    """
    return elementwise(
        lib.covbeam_image_filters_density,
        COUNT,
        given("filters", filters, Kind(IMAGE_FILTER)),
        made("out", out, FLOAT),
    )


def thresholds(pass_, seed, pixels, *, out=None):
    """Thresholds of pixels in a pass, in [0, 1): a pixel gets an eye ray if its density is above.

    - pass_, seed: any numbers below 2^32; each pass chooses other pixels, the seed shifts the pattern.
    - pixels: x and y, uint32 of shape (2,) or (n, 2).
    """
    return elementwise(
        lib.covbeam_pixel_threshold_many,
        _word("pass_", pass_),
        _word("seed", seed),
        COUNT,
        given("pixels", pixels, PIXEL),
        made("out", out, FLOAT),
    )


def regions(width, height, depths, *, out=None):
    """The parts of a picture in which the depth of the first surface is continuous: uint32, the number of the first pixel of each
    pixel's region, from 1 on, or 0 at a border.

    - depths: of the first surface [m] along the viewing axis, of shape (width x height,), row by row from the upper left.
      inf where there is none; NaN, 0 or less makes the pixel a border.
    """
    return elementwise(
        lib.covbeam_film_regions,
        _word("width", width),
        _word("height", height),
        COUNT,
        given("depths", depths, FLOAT),
        made("out", out, WORD),
    )


class Reconstruction(Object):
    """The samples of a picture, and each pixel through its filter: 27 bytes a pixel. Without rays so far, every pixel is 0.

    - width, height: of the picture, each 1 to 65536; at most 2^31 pixels.
    """

    def __init__(self, width, height):
        words = _word("width", width), _word("height", height)
        self._owner = Owner(lib.covbeam_reconstruction_new, lib.covbeam_reconstruction_free, *words)

    def update(self, samples, regions=None):
        """Takes the samples of the passes so far, in place of those before.

        - samples: FILM_SAMPLE of shape (width x height,), row by row from the upper left, copied. One that is not finite counts as a
          pixel without rays.
        - regions: of image.regions; None: one everywhere.
        """
        with using(changed=self) as [picture]:
            elementwise(
                lib.covbeam_reconstruction_update,
                picture,
                COUNT,
                given("samples", samples, Kind(FILM_SAMPLE)),
                optional("regions", regions, WORD),
            )

    def pixels(self, pixels, filters, *, out=None):
        """The radiance of pixels through their filters: float32, (n, 3).

        - pixels: x and y, uint32 of shape (2,) or (n, 2), inside the picture.
        - filters: IMAGE_FILTER; all 0 is the mean of a pixel's own rays.
        """
        with using(self) as [picture]:
            return elementwise(
                lib.covbeam_reconstruction_pixel_many,
                picture,
                COUNT,
                given("pixels", pixels, PIXEL),
                given("filters", filters, Kind(IMAGE_FILTER)),
                made("out", out, VECTOR),
            )


def _word(name, number):
    # ctypes would take it modulo 2^32.
    if not 0 <= number < 1 << 32:
        raise ValueError(f"{name}: {number} is not in 0 to 2^32 - 1")
    return int(number)


def pixels(width, height):
    """All pixels of a picture, or of a tile: x and y, row by row."""
    y, x = np.mgrid[0:height, 0:width].astype(np.uint32)
    return np.stack([x.reshape(-1), y.reshape(-1)], axis=-1)
