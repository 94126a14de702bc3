"""Spectra of the fluence around points: arrays of the dtype covbeam.SPECTRUM, of shape () or (n,)."""

from ._arrays import COUNT, FLOAT, VECTOR, Kind, changed, elementwise, given, made
from ._library import lib
from .dtypes import SPECTRUM


def variance_along(spectra, axes, *, out=None):
    """Variance along axes [cycles^2/m^2]: what kernel.radius_from_error takes.

    - axes: unit.
    """
    return elementwise(
        lib.covbeam_spectra_variance_along,
        COUNT,
        given("spectra", spectra, Kind(SPECTRUM)),
        given("axes", axes, VECTOR),
        made("out", out, FLOAT),
    )


def add_along(spectra, axes, variances):
    """Adds variances along axes, in place, such as those of light_field.variance_along_ray.

    - axes: unit.
    - variances: [cycles^2/m^2], finite and >= 0.
    """
    elementwise(
        lib.covbeam_spectra_add_along,
        COUNT,
        changed("spectra", spectra, Kind(SPECTRUM)),
        given("axes", axes, VECTOR),
        given("variances", variances, FLOAT),
    )
