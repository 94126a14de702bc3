"""Image space: how many eye rays the in-scattered light needs where, and the picture from those that were traced.

    film = Film(width, height, typical_radiance, regions(width, height, depths))
    spectra = image.along(grid, medium, rays, steps)           # of the eye rays through film.nodes()
    film.plan(pass_, error, light_paths, spectra)
    chosen = image.thresholds(pass_, seed, pixels) < film.densities()
    ...                                                         # trace those
    film.add(rays)                                              # FILM_RAY
    film.verify()
    light = film.picture()                                      # FILM_PIXEL
"""

import ctypes

import numpy as np

from ._arrays import COUNT, FLOAT, PIXEL, WORD, Kind, elementwise, given, made, struct, word
from ._callbacks import Call
from ._handles import Object, Owner, using
from ._library import check, lib
from .dtypes import EYE_RAY, FILM_PIXEL, FILM_RAY, IMAGE_FILTER, IMAGE_SPECTRUM, PIXEL_STEP
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
        word("pass_", pass_),
        word("seed", seed),
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
        word("width", width),
        word("height", height),
        COUNT,
        given("depths", depths, FLOAT),
        made("out", out, WORD),
    )


def errors(width, height, pixels, *, out=None):
    """Standard errors of a picture's luminance [W/(m^2 sr)], from the two halves of its passes: float32 (n,).

    - width, height: of the picture, or of a part of it: rows at least 2 away from the part's ends have the errors of the whole.
    - pixels: FILM_PIXEL of shape (width x height,).
    """
    return elementwise(
        lib.covbeam_film_errors,
        word("width", width),
        word("height", height),
        COUNT,
        given("pixels", pixels, Kind(FILM_PIXEL)),
        made("out", out, FLOAT),
    )


class Film(Object):
    """Few eye rays for a picture whose light is smooth: where they are needed, what they saw, and the picture from them.

    The cycle of a pass: plan, densities, add. When a picture is wanted: verify, then picture.

    - width, height: of the picture, each 1 to 65536; at most 2^31 pixels.
    - typical_radiance: of the picture, give or take a factor of a thousand [W/(m^2 sr)] > 0: light is added up in whole multiples of
      2^-32 of it, so that the order of passes and rays does not count.
    - regions: of image.regions, copied; None: one everywhere.
    """

    def __init__(self, width, height, typical_radiance, regions=None):
        #: Pixels across and down.
        self.width, self.height = word("width", width), word("height", height)
        count, address, stride = width * height, None, 0
        if regions is not None:
            labels = given("regions", regions, WORD)
            address, stride = labels.address, labels.stride
            count = 1 if labels.count is None else labels.count
        arguments = self.width, self.height, typical_radiance, count, address, stride
        self._owner = Owner(lib.covbeam_film_new, lib.covbeam_film_free, *arguments)

    @property
    def memory(self):
        """How much memory the film holds [bytes]."""
        return self._number(lib.covbeam_film_get_memory)

    def nodes(self):
        """At which pixels the spectrum of the picture is wanted: x and y, uint32 (n, 2)."""
        count = self._number(lib.covbeam_film_get_node_count)
        out = np.zeros((count, 2), np.uint32)
        with using(self) as [film]:
            return elementwise(lib.covbeam_film_nodes, film, COUNT, made("out", out, PIXEL))

    def plan(self, pass_, error, light_paths, spectra, *, poll=None):
        """Plans a pass: filters as wide as the spectra allow, none of which reaches where a narrower one is asked for.

        - pass_: its number. Passes with odd numbers are one half of all, the others are the other: they tell the error.
        - error: relative bias > 0 that a filter may cause: Kernel.error.
        - light_paths: of the pass; it gets at least half as many eye rays.
        - spectra: IMAGE_SPECTRUM (n,), of the eye rays through nodes(); all 0 where there is no fog.
        - poll: as in BeamMap.commit.
        """
        call = Call(poll)
        with using(changed=self) as [film]:
            elementwise(
                lib.covbeam_film_plan,
                film,
                word("pass_", pass_),
                error,
                word("light_paths", light_paths),
                COUNT,
                given("spectra", spectra, Kind(IMAGE_SPECTRUM)),
                call.poll,
                None,
                ended=call.check,
            )

    def densities(self, *, out=None):
        """Eye rays that pixels get in the pass that is planned, in (0, 1]: float32 (width x height,)."""
        out = np.zeros(self.width * self.height, np.float32) if out is None else out
        with using(self) as [film]:
            return elementwise(lib.covbeam_film_density, film, COUNT, made("out", out, FLOAT))

    def add(self, rays):
        """Adds the pass that is planned.

        - rays: FILM_RAY (n,), all of the pass, in any order.
        """
        with using(changed=self) as [film]:
            elementwise(lib.covbeam_film_add, film, COUNT, given("rays", rays, Kind(FILM_RAY)))

    def verify(self, *, poll=None):
        """Narrows the latest pass' filters where the two halves of the passes disagree with them, and makes the film ready for picture().

        - poll: as in BeamMap.commit.
        """
        call = Call(poll)
        with using(changed=self) as [film]:
            call.check(lib.covbeam_film_verify(film, call.poll, None))

    def picture(self, first_row=0, rows=None, *, out=None):
        """Rows of the picture: FILM_PIXEL (rows x width,). Threads may share the work.

        - first_row: a multiple of 8.
        - rows: their number, a multiple of 8 or up to the last; None for all from first_row on.
        """
        if out is None:
            count = self.width * (self.height - first_row if rows is None else rows)
            out = np.zeros(max(count, 0), FILM_PIXEL)
        with using(self) as [film]:
            return elementwise(
                lib.covbeam_film_picture, film, word("first_row", first_row), COUNT, made("out", out, Kind(FILM_PIXEL))
            )

    def _number(self, function):
        number = ctypes.c_size_t()
        with using(self) as [film]:
            check(function(film, ctypes.addressof(number)))
        return number.value


def pixels(width, height):
    """All pixels of a picture, or of a tile: x and y, row by row."""
    y, x = np.mgrid[0:height, 0:width].astype(np.uint32)
    return np.stack([x.reshape(-1), y.reshape(-1)], axis=-1)
