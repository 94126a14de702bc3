# SPDX-License-Identifier: GPL-3.0-or-later
"""Gradient noise with the lattice of Blender's, so that a cloud has the same shape.

Sources: K. Perlin, "Improving Noise" (2002); lattice points are hashed by B. Jenkins' lookup3 (2006).
"""

import numpy as np

#: What makes 3D noise fill -1 to 1.
_SCALE = 0.982

#: After so many cells noise begins anew.
_PERIOD = 1e5

#: Places that are worked on at a time: what they need stays in the processor's cache.
_SLICE = 16384


def _rotated(x, k):
    return x << np.uint32(k) | x >> np.uint32(32 - k)


def _final(a, b, c):
    for of, by, k in ((2, 1, 14), (0, 2, 11), (1, 0, 25), (2, 1, 16), (0, 2, 4), (1, 0, 14), (2, 1, 24)):
        words = [a, b, c]
        words[of] = (words[of] ^ words[by]) - _rotated(words[by], k)
        a, b, c = words
    return c


def hash_words(words):
    """lookup3 of two or three arrays of uint32."""
    start = np.uint32((0xDEADBEEF + (len(words) << 2) + 13) & 0xFFFFFFFF)
    with np.errstate(over="ignore"):
        return _final(*(start + word for word in words), *([start] * (3 - len(words))))


def hashed(x, y):
    """A number in [0, 1] of two numbers."""
    words = [np.array([number], np.float32).view(np.uint32) for number in (x, y)]
    return float(hash_words(words)[0]) / 0xFFFFFFFF


def perlin(places):
    """Noise between -1 and 1 at places (n, 3): (n,). It repeats, as Blender's does; 0 where there is no number."""
    far = 0.5 * (np.abs(places) >= 10 * _PERIOD)
    places = np.nan_to_num(np.fmod(np.where(np.isfinite(places), places, np.nan), _PERIOD) + far)
    return np.concatenate([_perlin(places[i : i + _SLICE]) for i in range(0, len(places), _SLICE)])


def _perlin(places):
    low = np.floor(places)
    rest = places - low
    x, y, z = rest.T
    smooth = (rest**3 * (rest * (6 * rest - 15) + 10)).T
    shares = [(1 - of, of) for of in smooth]
    cell = low.astype(np.int64).astype(np.uint32).T
    total = 0
    for corner in np.ndindex(2, 2, 2):
        weight = shares[0][corner[0]] * shares[1][corner[1]] * shares[2][corner[2]]
        h = hash_words([cell[k] + np.uint32(corner[k]) for k in range(3)]) & np.uint32(15)
        dx, dy, dz = x - corner[0], y - corner[1], z - corner[2]
        u = np.where(h < 8, dx, dy)
        v = np.where(h < 4, dy, np.where((h == 12) | (h == 14), dx, dz))
        total = total + weight * (np.where(h & 1, -u, u) + np.where(h & 2, -v, v))
    return _SCALE * total


def fractal(places, detail, roughness, lacunarity, normalize):
    """Octaves of noise at places (n, 3), each `lacunarity` times as fine as the one before and `roughness` times as strong: (n,).

    - detail: how many there are beside the first, >= 0; of the last one a share if it is no whole number.
    - normalize: whether the sum is brought to 0 to 1.
    """
    total, most = np.zeros(len(places)), 0.0
    fine, strong = 1.0, 1.0
    whole = int(detail)

    def brought(total, most):
        return 0.5 * total / most + 0.5 if normalize else total

    for _ in range(whole + 1):
        total += strong * perlin(fine * places)
        most += strong
        strong *= roughness
        fine *= lacunarity
    found, rest = brought(total, most), detail - whole
    if rest > 0:
        more = brought(total + strong * perlin(fine * places), most + strong)
        found = (1 - rest) * found + rest * more
    return found
