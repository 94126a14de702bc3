# SPDX-License-Identifier: GPL-3.0-or-later
"""Gradient noise with the lattice of Blender's, so that a cloud has the same shape.

Sources: K. Perlin, "Improving Noise" (2002); lattice points are hashed by B. Jenkins' lookup3 (2006).
"""

import numpy as np

#: What makes 3D noise fill -1 to 1.
_SCALE = 0.982

#: The directions of its gradients, by their number: of x, y and z.
_GRADIENTS = np.array(
    [
        [1, -1, 1, -1, 1, -1, 1, -1, 0, 0, 0, 0, 1, 0, -1, 0],
        [1, 1, -1, -1, 0, 0, 0, 0, 1, -1, 1, -1, 1, -1, 1, -1],
        [0, 0, 0, 0, 1, 1, -1, -1, 1, 1, -1, -1, 0, 1, 0, -1],
    ],
    np.float32,
)

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
    if not np.abs(places).max(initial=0.0) < _PERIOD:
        far = 0.5 * (np.abs(places) >= 10 * _PERIOD)
        places = np.nan_to_num(np.fmod(np.where(np.isfinite(places), places, np.nan), _PERIOD) + far)
    return np.concatenate([_perlin(places[i : i + _SLICE].T) for i in range(0, len(places), _SLICE)])


def _perlin(places):
    low = np.floor(places, order="C")
    rest = np.subtract(places, low, order="C").astype(np.float32)
    shares = [(1 - of, of) for of in rest * rest * rest * (rest * (6 * rest - 15) + 10)]
    steps = [(of, of - 1) for of in rest]
    at, (x, y, z) = _gradients(low.astype(np.int64))
    total = 0
    for i, j, k in np.ndindex(2, 2, 2):
        corner = at(i, j, k)
        along = x[corner] * steps[0][i] + y[corner] * steps[1][j] + z[corner] * steps[2][k]
        total = total + shares[0][i] * shares[1][j] * shares[2][k] * along
    return _SCALE * total


def _gradients(cells):
    """Where those of the corners i, j, k (0 or 1 each) of cells (3, n) are in a table, and its columns of x, y and z."""
    first = cells.min(axis=1, keepdims=True)
    inside = cells - first
    size = inside.max(axis=1) + 2
    if size.prod() <= inside.shape[1]:
        # Many places in few cells: each point of the lattice once.
        index = np.ravel_multi_index(inside, size)
        table = _hash(*np.ix_(*(np.arange(of, of + count) for of, count in zip(first[:, 0], size)))).ravel()
        return lambda i, j, k: index + ((i * size[1] + j) * size[2] + k), _GRADIENTS[:, table]
    count = inside.shape[1]
    table = np.concatenate([_hash(*(of + up for of, up in zip(cells, corner))) for corner in np.ndindex(2, 2, 2)])
    return lambda i, j, k: slice((4 * i + 2 * j + k) * count, (4 * i + 2 * j + k + 1) * count), _GRADIENTS[:, table]


def _hash(x, y, z):
    """A number from 0 to 15 at points of the lattice."""
    return hash_words([of.astype(np.uint32) for of in (x, y, z)]) & np.uint32(15)


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
