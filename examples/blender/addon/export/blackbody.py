# SPDX-License-Identifier: GPL-3.0-or-later
"""What glows by its heat."""

from functools import cache

import numpy as np

from .working_space import from_rec709

#: Where the colour matching functions of the CIE's standard observer of 1931 are known [nm], and what they are there.
_WAVELENGTHS = np.arange(380.0, 781.0, 10.0)
_MATCHING = np.array(
    [
        "14 42 143 435 1344 2839 3483 3362 2908 1954 956 320 49 93 633 1655 2904 4334 5945 7621 9163 10263 10622 10026 8544 6424 4479 "
        "2835 1649 874 468 227 114 58 29 14 7 3 2 1 0",
        "0 1 4 12 40 116 230 380 600 910 1390 2080 3230 5030 7100 8620 9540 9950 9950 9520 8700 7570 6310 5030 3810 2650 1750 "
        "1070 610 320 170 82 41 21 10 5 2 1 1 0 0",
        "65 201 679 2074 6456 13856 17471 17721 16692 12876 8130 4652 2720 1582 782 422 203 87 39 21 17 11 8 3 2 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0",
    ]
)

_REC709_OF_XYZ = np.array([[3.2404542, -1.5371385, -0.4985314], [-0.9692660, 1.8760108, 0.0415560], [0.0556434, -0.2040259, 1.0572252]])

#: Beyond these colours do not change [K]; and temperatures at which they are computed, as even in 1/T as colours are.
_COOLEST, _HOTTEST = 800.0, 12000.0
_TABLE = 1 / np.linspace(1 / _COOLEST, 1 / _HOTTEST, 512)

#: Of Stefan and Boltzmann, over pi, in Cycles' units: emission coefficient [W/(m^3 sr)] over the fourth power of a temperature [K].
_SIGMA = 5.670373e-14 / np.pi


def blackbody(temperature):
    """A colour of luminance 1, of which what is negative is 0: float64 (3,), or (n, 3). temperature: [K], a number or (n, 1)."""
    return np.maximum(from_rec709(_colour(temperature)), 0)


def glow(temperature, intensity):
    """The emission coefficient of a Principled Volume [W/(m^3 sr)], float64 (3,) or (n, 3), before its tint: by the law of Stefan and
    Boltzmann as far as its Blackbody Intensity goes. Both are numbers or (n, 1); temperature: [K]."""
    kelvin = np.maximum(temperature, 0.0)
    return _SIGMA * (1 + intensity * (kelvin**4 - 1)) * blackbody(kelvin)


def _colour(temperature):
    place = 1 / np.clip(temperature, _COOLEST, _HOTTEST)
    # Ascending.
    colours = [np.interp(place, 1 / _TABLE[::-1], channel[::-1]) for channel in _table().T]
    return np.concatenate(colours, axis=1) if np.ndim(temperature) else np.array(colours)


@cache
def _table():
    """The colours at _TABLE, (n, 3)."""
    matching = np.array([row.split() for row in _MATCHING], float)
    # Planck's law but for a factor; 1.4388e7 nm K is h c / k.
    power = _WAVELENGTHS**-5 / np.expm1(1.4388e7 / (_WAVELENGTHS * _TABLE[:, None]))
    xyz = power @ matching.T
    return (xyz / xyz[:, 1:2]) @ _REC709_OF_XYZ.T
