"""Segments of light paths: the edges beside them, and the light field on its way along them.

A segment is deposited whole (Grid.deposit); the light field goes on from where the photon has its next event (field_at).
"""

import ctypes

import numpy as np

from ._arrays import COUNT, FLOAT, VECTOR, Kind, elementwise, given, made, struct
from ._callbacks import Call
from ._library import lib
from .dtypes import EDGE, LIGHT_FIELD, PROBE_HIT, SEGMENT
from .media import Medium


def field_at(segments, medium, distances, *, out=None):
    """The light fields at distances from segments' origins, moved on and occluded by the edges up to there: LIGHT_FIELD.

    - segments: SEGMENT; origin, field and edges count, the rest is not looked at.
    - medium: a Medium; Medium(0) is vacuum.
    - distances: [m] >= 0, finite: to the photons' next events.
    """
    return elementwise(
        lib.covbeam_segments_field_at,
        COUNT,
        given("segments", segments, Kind(SEGMENT)),
        struct("medium", medium, Medium),
        given("distances", distances, FLOAT),
        made("out", out, Kind(LIGHT_FIELD)),
    )


def find_edges(direction, probe, hit=None):
    """Edges of occluders beside one ray, by up to 128 probe rays: EDGE, up to 4 of them, sorted by depth.

    - direction: of the ray, unit.
    - probe: a function (direction) that casts a ray from the same origin: (distance, normal, offset) of the nearest surface that
      casts shadows, None where it meets none. normal: geometric, any length; offset: how far off the surface rays start
      that leave it [m]. What it raises ends the call.
    - hit: what the ray itself meets, likewise.
    """
    if probe is None:
        raise TypeError("probe: None; give a function (direction)")
    along = given("direction", direction, VECTOR)
    if along.count not in (None, 1):
        raise ValueError(f"direction: {along.count} vectors, but one is wanted")
    own = None if hit is None else np.array((hit[0], tuple(hit[1]), hit[2]), PROBE_HIT)
    edges, count = np.zeros(4, EDGE), ctypes.c_uint32()
    call = Call(probe=probe)
    call.check(
        lib.covbeam_find_edges(
            along.address,
            None if own is None else own.ctypes.data,
            call.probe,
            None,
            edges.ctypes.data,
            ctypes.addressof(count),
        )
    )
    return edges[: count.value]
