"""Media: what scatters and absorbs, how densely, and what that does to light along rays."""

import ctypes
from math import inf
from typing import NamedTuple

import numpy as np

from . import _abi
from ._arrays import COUNT, FLOAT, VECTOR, Kind, elementwise, given, made, packed, voxels
from ._handles import Object, Owner
from ._library import check, lib
from .column import Column
from .dtypes import DERIVATIVES, KNOT
from .phase import Phase


class GridLayout(NamedTuple):
    """Box and resolution of a Grid or of a Density. Voxels lie in memory x first: arrays of them have the shape (nz, ny, nx)."""

    #: Lower corner [m].
    min: tuple[float, float, float]
    #: Upper corner [m], above min on every axis.
    max: tuple[float, float, float]
    #: Voxels along x, y, z, each >= 1; at most 2^24 in all.
    cells: tuple[int, int, int]

    def _c(self):
        if not all(0 <= n < 1 << 32 for n in self.cells):
            raise ValueError(f"layout: cells {self.cells} are not three numbers >= 1")
        return _abi.GridLayout(tuple(self.min), tuple(self.max), tuple(self.cells))


def _layout(layout):
    if not isinstance(layout, GridLayout):
        raise TypeError(f"layout: a {type(layout).__name__}; give a GridLayout(min, max, cells)")
    return layout._c()


class Exponential(NamedTuple):
    """A density exp(-height / scale_height)."""

    #: A point where the density is 1 [m].
    origin: tuple[float, float, float]
    #: Direction in which the density falls, any length but 0.
    up: tuple[float, float, float]
    #: Height over which it falls by the factor e [m] > 0.
    scale_height: float


class Density(Object):
    """A relative density given at the centres of voxels: trilinear between them, held over the half voxel at the border, 0 outside.

    Copies the values, 4 bytes a voxel. Any number of media may use it.

    - layout: a GridLayout.
    - values: float32 of shape (nz, ny, nx) or (n,), each finite and >= 0.
    """

    def __init__(self, layout, values):
        struct = _layout(layout)
        argument = voxels("values", values, np.dtype(np.float32), layout.cells)
        self._owner = Owner(
            lib.covbeam_density_new,
            lib.covbeam_density_free,
            ctypes.addressof(struct),
            argument.address,
            argument.stride,
            argument.count,
        )


class Medium:
    """A medium. Never changes; keeps its Density alive.

    - scattering, absorption: coefficients [1/m] >= 0 where the density is 1: one number, or three for the channels.
    - phase: a Phase; None: isotropic.
    - density: None for 1 everywhere, an Exponential, or a Density.

    In the methods, origins and directions (unit) are those of rays: float32 of shape (n, 3), or one tuple for all.
    """

    def __init__(self, scattering, absorption=0.0, phase=None, density=None):
        struct = _abi.Medium(struct_size=ctypes.sizeof(_abi.Medium))
        struct.scattering = _three("scattering", scattering)
        struct.absorption = _three("absorption", absorption)
        if phase is not None:
            if not isinstance(phase, Phase):
                raise TypeError(f"phase: a {type(phase).__name__}; give a Phase")
            struct.phase = phase._struct
        self._density = None
        if isinstance(density, Exponential):
            struct.density = 1
            struct.origin = _three("density.origin", density.origin)
            struct.up = _three("density.up", density.up)
            struct.scale_height = density.scale_height
        elif isinstance(density, Density):
            self._density = density._owned()
            struct.density = 2
            struct.voxels = self._density.handle
        elif density is not None:
            raise TypeError(f"density: a {type(density).__name__}; give None, an Exponential or a Density")
        self._struct = struct

    scattering = property(lambda self: tuple(self._struct.scattering), doc="Coefficients per channel [1/m].")
    absorption = property(lambda self: tuple(self._struct.absorption), doc="Coefficients per channel [1/m].")
    phase = property(lambda self: Phase(self._struct.phase.kind, self._struct.phase.asymmetry), doc="Its Phase.")

    def density_at(self, positions, *, out=None):
        """Relative density at points [m]: 1 where the coefficients hold."""
        return elementwise(
            lib.covbeam_medium_density_at_many,
            ctypes.addressof(self._struct),
            COUNT,
            given("positions", positions, VECTOR),
            made("out", out, FLOAT),
        )

    def derivatives_at(self, positions, *, out=None):
        """Derivatives of the relative density at points [m]: DERIVATIVES."""
        return elementwise(
            lib.covbeam_medium_derivatives_at_many,
            ctypes.addressof(self._struct),
            COUNT,
            given("positions", positions, VECTOR),
            made("out", out, Kind(DERIVATIVES)),
        )

    def step(self):
        """Largest step [m] over which the second derivatives may be taken as constant; inf in a homogeneous medium."""
        return self._number(lib.covbeam_medium_step)

    def column_at(self, origins, directions, distances, *, out=None):
        """Columns along rays [m]: integrals of the relative density. Extinction x column is the optical depth.

        - distances: [m] >= 0; inf allowed.
        """
        return elementwise(
            lib.covbeam_medium_column_at_many,
            ctypes.addressof(self._struct),
            COUNT,
            given("origins", origins, VECTOR),
            given("directions", directions, VECTOR),
            given("distances", distances, FLOAT),
            made("out", out, FLOAT),
        )

    def distance_at(self, origins, directions, lengths, columns, *, out=None):
        """Distances [m] at which columns are reached, inf if the ray ends before: the inverse of column_at.

        Free flight: columns = -log(1 - u) / extinction, for uniform u in [0, 1).

        - lengths: of the rays [m] >= 0; inf allowed.
        - columns: [m] >= 0; inf allowed.
        """
        return elementwise(
            lib.covbeam_medium_distance_at_many,
            ctypes.addressof(self._struct),
            COUNT,
            given("origins", origins, VECTOR),
            given("directions", directions, VECTOR),
            given("lengths", lengths, FLOAT),
            given("columns", columns, FLOAT),
            made("out", out, FLOAT),
        )

    def transmittance(self, origins, directions, distances, *, out=None):
        """The share of light that stretches of medium leave, per channel: (n, 3).

        - distances: [m] >= 0; inf allowed.
        """
        return elementwise(
            lib.covbeam_medium_transmittance_many,
            ctypes.addressof(self._struct),
            COUNT,
            given("origins", origins, VECTOR),
            given("directions", directions, VECTOR),
            given("distances", distances, FLOAT),
            made("out", out, VECTOR),
        )

    def column_transmittance(self, columns, *, out=None):
        """The share of light that columns [m] leave, per channel: (n, 3)."""
        return elementwise(
            lib.covbeam_medium_column_transmittance_many,
            ctypes.addressof(self._struct),
            COUNT,
            given("columns", columns, FLOAT),
            made("out", out, VECTOR),
        )

    def opaque_column(self):
        """The column [m] after which light of every channel is down to e^-17; inf if a channel has no extinction."""
        return self._number(lib.covbeam_medium_opaque_column)

    def reach(self, origins, directions, *, out=None):
        """Distances [m] beyond which light that starts on a ray leaves nothing to see; inf if there is no such place."""
        return elementwise(
            lib.covbeam_medium_reach_many,
            ctypes.addressof(self._struct),
            COUNT,
            given("origins", origins, VECTOR),
            given("directions", directions, VECTOR),
            made("out", out, FLOAT),
        )

    def knots(self, origin, direction, length, error, most=inf):
        """The table of columns along one ray through voxels: KNOT. Empty for other densities, whose columns are closed forms.

        - length: of the ray [m] >= 0; inf ends where it leaves the voxels.
        - error: of a column [m] > 0; inf keeps the ends alone.
        - most: the table ends at the first point with a larger column [m].
        """
        return self._table(lib.covbeam_medium_knots, origin, direction, length, error, most)

    def tabulate(self, origin, direction, length):
        """`knots` as a gather wants them: within 5e-4 of the optical depth, up to where every channel is opaque.

        - length: of the ray [m] >= 0; inf ends where it leaves the voxels.
        """
        return self._table(lib.covbeam_medium_tabulate, origin, direction, length)

    def column(self, origin, direction, knots=None):
        """The Column along one ray: a closed form, or the table that `tabulate` made.

        - knots: packed KNOT, kept and not copied; ignored unless the density is voxels.
        """
        origin, direction = given("origin", origin, VECTOR), given("direction", direction, VECTOR)
        table = None if knots is None else packed("knots", knots, KNOT)
        column = Column._empty(knots)
        check(
            lib.covbeam_medium_column(
                ctypes.addressof(self._struct),
                _one(origin),
                _one(direction),
                table and table.address,
                0 if table is None else table.count,
                ctypes.addressof(column._struct),
            )
        )
        return column

    def _number(self, function):
        number = ctypes.c_float()
        check(function(ctypes.addressof(self._struct), ctypes.addressof(number)))
        return number.value

    def _table(self, function, origin, direction, *numbers):
        origin, direction = given("origin", origin, VECTOR), given("direction", direction, VECTOR)
        ray = (ctypes.addressof(self._struct), _one(origin), _one(direction), *numbers)
        count = ctypes.c_size_t()
        check(function(*ray, None, 0, ctypes.addressof(count)))
        table = np.zeros(count.value, KNOT)
        check(function(*ray, table.ctypes.data, len(table), ctypes.addressof(count)))
        return table


def _one(argument):
    if argument.count not in (None, 1):
        raise ValueError(f"{argument.name}: {argument.count} vectors, but the call is about one ray")
    return argument.address


def _three(name, value):
    try:
        three = (float(value),) * 3 if np.ndim(value) == 0 else tuple(float(v) for v in value)
    except (TypeError, ValueError) as error:
        raise TypeError(f"{name}: {value!r} is neither a number nor three") from error
    if len(three) != 3:
        raise ValueError(f"{name}: {value!r} is neither a number nor three")
    return three
