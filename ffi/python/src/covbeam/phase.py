"""Phase functions: how scattered light is spread over directions."""

import ctypes

from . import _abi
from ._arrays import COUNT, FLOAT, PAIR, VECTOR, elementwise, given, made
from ._library import check, lib


class Phase:
    """A phase function: Phase.isotropic(), Phase.henyey_greenstein(g) or Phase.rayleigh(). Never changes."""

    ISOTROPIC, HENYEY_GREENSTEIN, RAYLEIGH = 0, 1, 2

    def __init__(self, kind=ISOTROPIC, asymmetry=0.0):
        self._struct = _abi.Phase(kind, asymmetry)

    @classmethod
    def isotropic(cls):
        """The same in all directions."""
        return cls()

    @classmethod
    def henyey_greenstein(cls, asymmetry):
        """Henyey-Greenstein of a mean cosine in (-1, 1), forward positive."""
        return cls(cls.HENYEY_GREENSTEIN, asymmetry)

    @classmethod
    def rayleigh(cls):
        """Rayleigh."""
        return cls(cls.RAYLEIGH)

    def __repr__(self):
        return f"Phase({self._struct.kind}, {self._struct.asymmetry})"

    def evaluate(self, cosines, *, out=None):
        """Values [1/sr]: 1 in all over the sphere.

        - cosines: dot(propagation before, propagation after), forward 1.
        """
        return elementwise(
            lib.covbeam_phase_evaluate_many,
            ctypes.addressof(self._struct),
            COUNT,
            given("cosines", cosines, FLOAT),
            made("out", out, FLOAT),
        )

    def sample(self, directions, xis, *, out=None):
        """Directions after scattering, unit, in proportion to the phase function: the weight is 1.

        - directions: of propagation before the event, unit.
        - xis: (n, 2), independent uniform numbers in [0, 1).
        """
        return elementwise(
            lib.covbeam_phase_sample_many,
            ctypes.addressof(self._struct),
            COUNT,
            given("directions", directions, VECTOR),
            given("xis", xis, PAIR),
            made("out", out, VECTOR),
        )

    def sample_cosine(self, xis, *, out=None):
        """Cosines of the scattering angle in proportion to the phase function.

        - xis: uniform in [0, 1); 0 gives -1, and the cosine grows with it.
        """
        return elementwise(
            lib.covbeam_phase_sample_cosine_many,
            ctypes.addressof(self._struct),
            COUNT,
            given("xis", xis, FLOAT),
            made("out", out, FLOAT),
        )

    def angular_variance(self):
        """What light_field.scatter takes: variance, per axis, of the angular spectrum of the lobe [cycles^2/rad^2]."""
        variance = ctypes.c_float()
        check(lib.covbeam_phase_angular_variance(ctypes.addressof(self._struct), ctypes.addressof(variance)))
        return variance.value
