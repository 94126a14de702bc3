# SPDX-License-Identifier: GPL-3.0-or-later
"""The colour of what glows by its heat."""

import numpy as np

#: Lobes of the CIE 1931 colour matching functions: factor, peak [nm], and widths below and above it [1/nm].
#: Source: C. Wyman, P.-P. Sloan and P. Shirley, "Simple Analytic Approximations to the CIE XYZ Color Matching
#: Functions", JCGT 2(2), 2013.
_LOBES = (
    ((1.056, 599.8, 0.0264, 0.0323), (0.362, 442.0, 0.0624, 0.0374), (-0.065, 501.1, 0.0490, 0.0382)),
    ((0.821, 568.8, 0.0213, 0.0247), (0.286, 530.9, 0.0613, 0.0322)),
    ((1.217, 437.0, 0.0845, 0.0278), (0.681, 459.0, 0.0385, 0.0725)),
)

_REC709_OF_XYZ = np.array(
    [[3.2404542, -1.5371385, -0.4985314], [-0.9692660, 1.8760108, 0.0415560], [0.0556434, -0.2040259, 1.0572252]]
)


def blackbody(temperature):
    """Linear Rec. 709 of luminance 1, none below 0, float64 (3,). temperature: [K], which counts in 800 to 12000."""
    wavelength = np.arange(380.0, 781.0)
    kelvin = min(max(temperature, 800.0), 12000.0)
    # Planck's law but for a factor; 1.4388e7 nm K is h c / k.
    power = wavelength**-5 / np.expm1(1.4388e7 / (wavelength * kelvin))
    xyz = np.array([sum(_lobe(wavelength, *lobe) for lobe in lobes) @ power for lobes in _LOBES])
    return np.maximum(_REC709_OF_XYZ @ (xyz / xyz[1]), 0)


def _lobe(wavelength, factor, peak, below, above):
    t = (wavelength - peak) * np.where(wavelength < peak, below, above)
    return factor * np.exp(-0.5 * t * t)
