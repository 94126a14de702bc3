# SPDX-License-Identifier: GPL-3.0-or-later
"""Mean cosines of the phase functions that Blender offers and covbeam does not have."""

import math

import numpy as np


def draine(g, alpha):
    """Of Draine's function (doi:10.1086/379118), in closed form."""
    return g * (1 + alpha * (3 + 2 * g * g) / 5) / (1 + alpha * (1 + 2 * g * g) / 3)


def mie(diameter):
    """Of water droplets of a diameter [um]: a share of Draine's function, and Henyey-Greenstein's for the rest.

    Source: J. Jendersie and E. d'Eon, "An Approximate Mie Scattering Function for Fog and Cloud Rendering", 2023.
    """
    d = max(diameter, 1e-3)
    log = math.log(d)
    if d <= 0.1:
        g, g_draine, alpha = 13.8 * d * d, 1.1456 * d * math.sin(9.29044 * d), 250.0
        share = 0.252977 - 312.983 * d**4.3
    elif d < 1.5:
        g, alpha = 0.862 - 0.143 * log * log, 250.0
        turn = (log - 0.238604) * (log + 1.00667) / (0.507522 - 0.15677 * log)
        g_draine = 0.379685 * math.cos(1.19692 * math.cos(turn) + 1.37932 * log + 0.0625835) + 0.344213
        share = 0.146209 * math.cos(3.38707 * log + 2.11193) + 0.316072 + 0.0778917 * log
    elif d < 5:
        g = 0.0604931 * math.log(log) + 0.940256
        g_draine = 0.500411 - 0.081287 / (-2 * log + math.tan(log) + 1.27551)
        alpha = 7.30354 * log + 6.31675
        share = 0.026914 * (log - math.cos(5.68947 * (math.log(log) - 0.0292149))) + 0.3764
    else:
        g = math.exp(-0.0990567 / (d - 1.67154))
        g_draine = math.exp(-2.20679 / (d + 3.91029) - 0.428934)
        alpha = math.exp(3.62489 - 8.29288 / (d + 5.52825))
        share = math.exp(-0.599085 / (d - 0.641583) - 0.665888)
    return (1 - share) * g + share * draine(g_draine, alpha)


def fournier_forand(backscatter, ior):
    """Of Fournier and Forand's function (doi:10.1117/12.366488) for sea water, by integration over its forward peak."""
    n, b = max(ior, 1 + 1e-3), min(abs(backscatter), 0.5 - 1e-3)

    def delta(sine_squared):
        return 4 * sine_squared / (3 * (n - 1) ** 2)

    v = -math.log(2 * b * (delta(0.5) - 1) + 1) / math.log(delta(0.5))
    # Cells of equal ratio in the squared sine of half the angle: the peak is at 0.
    ends = np.geomspace(1e-14, 1, 20001)
    s = np.sqrt(ends[1:] * ends[:-1])
    d, far = delta(s), delta(1.0)
    power = d**v
    p = (v * (1 - d) - (1 - power) + (d * (1 - power) - v * (1 - d)) / s) / (4 * math.pi * (1 - d) ** 2 * power)
    p += (far**-v - 1) / ((far - 1) * 16 * math.pi) * (3 * (1 - 2 * s) ** 2 - 1)
    weight = p * np.diff(ends)
    return float(weight @ (1 - 2 * s) / weight.sum())
