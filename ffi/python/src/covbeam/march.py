"""Shadow rays along an eye ray, for light scattered once: placed where they are worth their cost.

    march = March()                                    # one a thread
    knots = lay(origin, direction, 0, length, lamp, 97)
    knots["radiance"], knots["deviation"] = ...        # without shadow rays; from Grid.look_up and spectrum.variance_along
    march.update(knots)
    first = march.place(jitters)                       # first["visibility"] = ... by shadow rays
    second = march.refine(first, more_jitters)
    light = (second["weight"] * radiance * visibility).sum()
"""

import ctypes

import numpy as np

from . import _abi
from ._arrays import COUNT, FLOAT, VECTOR, Kind, elementwise, given, made, single
from ._handles import Object, Owner, using
from ._library import check, lib
from .dtypes import MARCH_KNOT, MARCH_SAMPLE


def lay(origin, direction, from_, to, light, count=97):
    """Knots along a stretch of a ray, at equal steps of the angle at which a light sees it: MARCH_KNOT, dark, with nothing known.

    - origin, direction: of the ray [m]; unit.
    - from_, to: the stretch [m]; inf stands for where the light sees the rest under 1/1000 rad.
    - light: its position, or centre [m].
    - count: of knots, >= 2.
    """
    knots = np.zeros(count, MARCH_KNOT)
    start, along, lamp = (
        single(name, vector, VECTOR) if isinstance(vector, np.ndarray) else given(name, vector, VECTOR)
        for name, vector in (("origin", origin), ("direction", direction), ("light", light))
    )
    made_here = knots.ctypes.data, knots.itemsize
    check(lib.covbeam_march_lay(start.address, along.address, from_, to, lamp.address, count, *made_here))
    return knots


class March(Object):
    """The table along one eye ray, and the memory that placing shadow rays needs: one a thread, for one ray after the other."""

    def __init__(self):
        self._owner = Owner(lib.covbeam_march_new, lib.covbeam_march_free)

    def update(self, knots):
        """Takes the table of the next eye ray: MARCH_KNOT of shape (n,), n >= 2, by distance; copied.

        Between knots the radiance is taken as linear, and where two neighbours are dark no shadow ray is placed.
        """
        with using(changed=self) as [march]:
            elementwise(lib.covbeam_march_update, march, COUNT, given("knots", knots, Kind(MARCH_KNOT)))

    def expected(self):
        """What the table says before any shadow ray is traced: (radiance, error).

        The light that is expected to be scattered to the eye [W/(m^2 sr)]; the standard deviation that an estimate from one round
        is expected to have, times the number of its shadow rays.
        """
        both = _abi.MarchExpected()
        with using(self) as [march]:
            check(lib.covbeam_march_get_expected(march, ctypes.addressof(both)))
        return both.radiance, both.error

    def first_round(self, rays):
        """How many of so many shadow rays should be spent on a first round; 0: all in one round."""
        first = ctypes.c_size_t()
        with using(self) as [march]:
            check(lib.covbeam_march_get_first_round(march, rays, ctypes.addressof(first)))
        return first.value

    def place(self, jitters, *, out=None):
        """Places a round of shadow rays from the table alone: MARCH_SAMPLE, from near to far.

        - jitters: a uniform number in [0, 1) a shadow ray, float32 of shape (n,).
        """
        with using(changed=self) as [march]:
            return elementwise(
                lib.covbeam_march_place,
                march,
                COUNT,
                given("jitters", jitters, FLOAT),
                made("out", out, Kind(MARCH_SAMPLE)),
            )

    def refine(self, firsts, jitters, *, out=None):
        """Places a second round, dense where the first one saw changes; the estimate is the sum over the second round alone.

        - firsts: what `place` returned, with the visibilities found, each in [0, 1]; NaN says nothing.
        - jitters: as for `place`, independent of the first round.
        """
        first = given("firsts", firsts, Kind(MARCH_SAMPLE))
        with using(changed=self) as [march]:
            return elementwise(
                lib.covbeam_march_refine,
                march,
                1 if first.count is None else first.count,
                first.address,
                first.stride,
                COUNT,
                given("jitters", jitters, FLOAT),
                made("out", out, Kind(MARCH_SAMPLE)),
            )
