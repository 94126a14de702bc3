"""Blur kernels, their radii, and how both shrink over the passes of a picture."""

import ctypes
from enum import IntEnum

from . import _abi
from ._arrays import COUNT, FLOAT, VECTOR, elementwise, given, made, two_outs
from ._handles import using
from ._library import check, lib


class KernelShape(IntEnum):
    """Shape of the kernel K_r(d), whose integral over [-r, r] is 1. With q = d / r: 1/(2r), 3(1 - q^2)/(4r), 15(1 - q^2)^2/(16r)."""

    BOX = 0
    EPANECHNIKOV = 1
    BIWEIGHT = 2


class Kernel:
    """How wide the pairs of one pass are gathered: within max(min_radius, min(max_radius, what the spectrum allows)).

    - shape: a KernelShape.
    - min_radius: radius where the grid has no data, and the smallest one [m] > 0.
    - max_radius: the largest radius [m] >= min_radius.
    - error: accepted relative bias of a pair > 0; without a grid it has no effect.
    """

    def __init__(self, shape, min_radius, max_radius, error):
        self._struct = _abi.Kernel(ctypes.sizeof(_abi.Kernel), KernelShape(shape), min_radius, max_radius, error)

    shape = property(lambda self: KernelShape(self._struct.shape))
    min_radius = property(lambda self: self._struct.min_radius)
    max_radius = property(lambda self: self._struct.max_radius)
    error = property(lambda self: self._struct.error)

    def __repr__(self):
        return f"Kernel({self.shape!s}, {self.min_radius}, {self.max_radius}, {self.error})"

    def radius_at(self, grid, positions, axes, *, out=None):
        """Kernel radii [m] of pairs, and the deviations [cycles/m] of the spectrum along their axes (0 where the grid knows
        nothing): (radii, sigmas).

        - grid: a Grid that has been resolved; None gives the progressive radius.
        - positions: the closest points on the eye rays [m].
        - axes: of the kernel, unit, across ray and beam: those of CROSSING.
        """
        radii, sigmas = two_outs(out)
        with using(grid) as [handle]:
            return elementwise(
                lib.covbeam_kernel_radius_at_many,
                ctypes.addressof(self._struct),
                handle,
                COUNT,
                given("positions", positions, VECTOR),
                given("axes", axes, VECTOR),
                made("radii", radii, FLOAT),
                made("sigmas", sigmas, FLOAT),
            )


class Schedule:
    """How the kernel shrinks over the passes of a picture.

    - shape: a KernelShape.
    - radius: progressive radius of pass 1 [m] > 0.
    - alpha: in (0, 1]; the progressive radius falls as pass^(alpha - 1), 1 keeps it.
    - max_radius: largest radius that a spectrum may ask for [m] > 0.
    - error: accepted relative bias of a pair in pass 1, > 0; it falls as pass^(-2/5).
    """

    def __init__(self, shape, radius, alpha, max_radius, error):
        self._struct = _abi.Schedule(ctypes.sizeof(_abi.Schedule), KernelShape(shape), radius, alpha, max_radius, error)

    def kernel(self, pass_):
        """The Kernel of a pass, counted from 1. Passes may run in any order."""
        kernel = Kernel(0, 0, 0, 0)
        check(lib.covbeam_schedule_kernel(ctypes.addressof(self._struct), _pass(pass_), ctypes.addressof(kernel._struct)))
        return kernel


def progressive_radius(radius, alpha, pass_):
    """The progressive radius of a pass: r_1 = radius, r_(i+1) = r_i (i + alpha) / (i + 1)."""
    return _number(lib.covbeam_progressive_radius, radius, alpha, _pass(pass_))


def error_bound(error, pass_):
    """The bound on the relative bias in a pass: error x pass^(-2/5)."""
    return _number(lib.covbeam_error_bound, error, _pass(pass_))


def evaluate(shape, distance, radius):
    """A kernel's value K_r(d) [1/m]: 0 where the distance [m] is the radius [m] or more."""
    return _number(lib.covbeam_kernel_evaluate, KernelShape(shape), distance, radius)


def second_moment(shape):
    """Second moment of a kernel of radius 1; that of radius r is r^2 times it."""
    return _number(lib.covbeam_kernel_second_moment, KernelShape(shape))


def radius_from_error(shape, error, variance):
    """The radius [m] at which the kernel costs a relative bias: sqrt(error / (2 pi^2 second_moment variance)).

    - variance: of the fluence's spectrum along the kernel's axis [cycles^2/m^2] >= 0: spectrum.variance_along.
    """
    return _number(lib.covbeam_kernel_radius_from_error, KernelShape(shape), error, variance)


def _pass(number):
    # ctypes would take it modulo 2^32.
    if not 1 <= number < 1 << 32:
        raise ValueError(f"pass_: {number}; passes are counted from 1")
    return number


def _number(function, *arguments):
    number = ctypes.c_float()
    check(function(*arguments, ctypes.addressof(number)))
    return number.value
