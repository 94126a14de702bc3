# SPDX-License-Identifier: GPL-3.0-or-later
"""Random numbers that depend on nothing but (seed, sequence, path, decision).

The first eight decisions of a path come from a scrambled Sobol' sequence that continues over the passes, the others from a
counter-based generator: pictures repeat bit for bit, whatever else is traced.
"""

import numpy as np

DIMENSIONS = 8

_U64 = (1 << 64) - 1
_GOLDEN = 0x9E3779B97F4A7C15


def mix(z):
    """The finaliser of SplitMix64 on an int, or on an array of uint64."""
    if isinstance(z, int):
        z = (z + _GOLDEN) & _U64
        z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & _U64
        z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & _U64
        return z ^ (z >> 31)
    z = z + np.uint64(_GOLDEN)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))


def _unit(bits):
    """Multiples of 2^-24 in [0, 1) from 32 random bits."""
    return (bits >> np.uint32(8)).astype(np.float32) * np.float32(2.0**-24)


#: Degree, coefficients and first direction numbers of the primitive polynomials of dimensions 1, 2, ...
#: (S. Joe and F. Y. Kuo, 2008, new-joe-kuo-6).
_POLYNOMIALS = [
    (1, 0, (1,)),
    (2, 1, (1, 3)),
    (3, 1, (1, 3, 1)),
    (3, 2, (1, 1, 1)),
    (4, 1, (1, 1, 3, 3)),
    (4, 4, (1, 3, 5, 13)),
    (5, 2, (1, 1, 5, 5, 17)),
]


def _directions():
    table = [[1 << (31 - i) for i in range(32)]]
    for degree, coefficients, first in _POLYNOMIALS:
        v = [m << (31 - i) for i, m in enumerate(first)]
        for i in range(degree, 32):
            value = v[i - degree] ^ (v[i - degree] >> degree)
            for k in range(1, degree):
                if coefficients >> (degree - 1 - k) & 1:
                    value ^= v[i - k]
            v.append(value)
        table.append(v)
    return table


def _byte_tables():
    """For each dimension and each byte of an index, what its 256 values contribute: uint32 (8, 4, 256)."""
    tables = np.zeros((DIMENSIONS, 4, 256), np.uint32)
    for dimension, v in enumerate(_directions()):
        for byte in range(4):
            for bit in range(8):
                has = np.arange(256) >> bit & 1 == 1
                tables[dimension, byte, has] ^= np.uint32(v[8 * byte + bit])
    return tables


_TABLES = _byte_tables()


def sobol(indices, dimension):
    """Points of the Sobol' sequence in one dimension as 32-bit fractions. indices: uint32 (n,)."""
    value = np.zeros(len(indices), np.uint32)
    for byte in range(4):
        value ^= _TABLES[dimension, byte][(indices >> np.uint32(8 * byte)) & np.uint32(255)]
    return value


def _reversed_bits(x):
    for shift, mask in ((1, 0x55555555), (2, 0x33333333), (4, 0x0F0F0F0F), (8, 0x00FF00FF)):
        s, m = np.uint32(shift), np.uint32(mask)
        x = ((x >> s) & m) | ((x & m) << s)
    return (x >> np.uint32(16)) | (x << np.uint32(16))


def _owen(value, key):
    """Nested uniform scramble by a hash of the leading bits.

    Source: B. Burley, "Practical Hash-based Owen Scrambling", JCGT 2020; the hash constants are N. Vegdahl's.
    """
    x = _reversed_bits(value) + np.uint32(key)
    for factor in (0x6C50B47C, 0xB82F1E52, 0xC7AFE638, 0x8D22F6E6):
        x ^= x * np.uint32(factor)
    return _reversed_bits(x)


class Sampler:
    """The decisions of paths that are followed side by side: each call makes the next one of them all.

    - seed, sequence: keep pictures, and the sequences within one, apart.
    - indices: of the paths in their sequence, continued over the passes: uint32 (n,).
    """

    def __init__(self, seed, sequence, indices):
        self._scramble = mix(mix(seed) ^ sequence)
        self._indices = indices
        self._keys = mix(indices.astype(np.uint64) ^ np.uint64(mix(self._scramble ^ 0x5EED)))
        self._decision = 0

    def uniform(self):
        """Uniform in [0, 1): float32 (n,)."""
        decision = self._decision
        self._decision += 1
        if decision < DIMENSIONS:
            return _unit(_owen(sobol(self._indices, decision), mix(self._scramble ^ decision) & 0xFFFFFFFF))
        step = np.uint64((decision * _GOLDEN) & _U64)
        return _unit((mix(self._keys + step) >> np.uint64(32)).astype(np.uint32))

    def pair(self):
        """Two decisions: float32 (n, 2)."""
        return np.stack([self.uniform(), self.uniform()], axis=1)

    def take(self, chosen):
        """Goes on with some of the paths: a bool or index array."""
        self._indices = self._indices[chosen]
        self._keys = self._keys[chosen]


def pixel_offset(seed, pass_):
    """Where in the pixel the eye rays of a pass start, in [0, 1)^2: Roberts' R2 sequence, which fills it evenly over the passes."""
    start = mix(seed ^ 0xCA3E7A)
    x, y = (start & 0xFFFFFFFF) / 2**32, (start >> 32) / 2**32
    return (x + 0.7548776662466927 * pass_) % 1.0, (y + 0.5698402909980532 * pass_) % 1.0
