"""Pairs of an eye ray and a beam, for hosts with a hierarchy of their own."""

import ctypes

from . import _abi
from ._arrays import COUNT, FLAG, FLOAT, Argument, Kind, elementwise, given, made, single, struct, two_outs
from ._handles import using
from ._library import lib
from .column import Column
from .dtypes import BEAM, CROSSING, EYE_RAY, GATHERED
from .kernel import Kernel
from .media import Medium


def cross(ray, beams, *, out=None):
    """Closest approach of an eye ray's line and beams' lines: (crossings, crosses), CROSSING and bool.

    False where ray and beam are nearly parallel: such a crossing stays as it was (0 if new).

    - ray: one EYE_RAY.
    - beams: BEAM.
    """
    ray = single("ray", ray, Kind(EYE_RAY))
    crossings, crosses = two_outs(out)
    return elementwise(
        lib.covbeam_cross_many,
        ray.address,
        COUNT,
        given("beams", beams, Kind(BEAM)),
        made("crossings", crossings, Kind(CROSSING)),
        made("crosses", crosses, FLAG),
    )


def gather_pair(ray, beams, froms, tos, medium, kernel, grid, gathered, *, ray_column=None, beam_columns=None, out=None):
    """Gathers beams one after the other, and adds them to what the eye ray has gathered. Returns bool: which of them count.

    - ray: one EYE_RAY.
    - beams: BEAM, in the same medium.
    - froms, tos: part of each beam that counts [m] >= 0: 0 and the beam's length, or more, for all of it.
    - medium: a Medium.
    - kernel, grid: as in BeamMap.gather.
    - gathered: one GATHERED, changed in place; all 0 to begin with.
    - ray_column: a Column; None takes the closed form (voxels have none).
    - beam_columns: a Column, or a list of one for each beam; None likewise.
    """
    ray = single("ray", ray, Kind(EYE_RAY))
    gathered = single("gathered", gathered, Kind(GATHERED), written=True)
    columns = _columns(beam_columns)
    with using(grid) as [handle]:
        return elementwise(
            lib.covbeam_gather_pairs,
            ray.address,
            COUNT,
            given("beams", beams, Kind(BEAM)),
            given("froms", froms, FLOAT),
            given("tos", tos, FLOAT),
            struct("medium", medium, Medium),
            None if ray_column is None else struct("ray_column", ray_column, Column),
            columns,
            struct("kernel", kernel, Kernel),
            handle,
            gathered.address,
            made("out", out, FLAG),
        )


def _columns(columns):
    argument = Argument("beam_columns", None, written=False)
    if columns is None:
        return argument
    if isinstance(columns, Column):
        argument.memory = columns._struct
    else:
        structs = []
        for index, column in enumerate(columns):
            struct(f"beam_columns[{index}]", column, Column)
            structs.append(column._struct)
        argument.memory = (_abi.Column * len(structs))(*structs)
        argument.count, argument.stride = len(structs), ctypes.sizeof(_abi.Column)
    argument.address = ctypes.addressof(argument.memory)
    return argument


def filter_beams(ray, beams, max_radius, *, out=None):
    """Which beams an eye ray may be paired with, without looking at grid or surfaces: bool. Errs towards accepting.

    - ray: one EYE_RAY.
    - beams: BEAM, each as a whole.
    - max_radius: largest kernel radius [m] > 0: Kernel.max_radius.
    """
    ray = single("ray", ray, Kind(EYE_RAY))
    return elementwise(
        lib.covbeam_filter_beams,
        ray.address,
        COUNT,
        given("beams", beams, Kind(BEAM)),
        max_radius,
        made("out", out, FLAG),
    )
