# SPDX-License-Identifier: GPL-3.0-or-later
"""How a lamp's strength changes with the distance from it: what nodes make of distances -> the host's falloff."""

import numpy as np

#: Distances at which nodes are asked, of which the first is what all others are told by: a metre, float64 (n, 1) [m].
DISTANCES = np.concatenate([[1.0], np.geomspace(0.05, 50, 24)])[:, None]

#: No falloff.
NONE = 0.0, 0.0

#: How far the strengths of nodes may be from what stands for them, over these.
_OFF = 1e-3


def falloff(ratios):
    """The host's falloff and smooth, d^falloff d^2 / (smooth + d^2) over that at a metre, or None where strengths change otherwise.

    - ratios: strengths at all DISTANCES but the first over those at the first, float64 (n, m) with m > 0.
    """
    distances = DISTANCES[1:]
    nearest, found = float(distances[0, 0]), float(np.median(ratios[0]))
    for exponent in range(3):
        # Where smoothing tells most, of f(d) = (1 + s) d^(2 + k) / (s + d^2).
        below = found - nearest ** (exponent + 2)
        if not below > 0:
            continue
        smooth = nearest**2 * (nearest**exponent - found) / below
        smooth = smooth if smooth > 1e-6 else 0.0
        made = (1 + smooth) * distances ** (exponent + 2) / (smooth + distances**2)
        if np.all(np.abs(ratios - made) <= _OFF * made):
            return float(exponent), smooth
    return None
