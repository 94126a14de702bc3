# SPDX-License-Identifier: GPL-3.0-or-later
"""Random numbers that depend on nothing but (seed, sequence, path, decision): covbeam's, so that pictures repeat bit for bit, whatever
else is traced."""

import numpy as np
from covbeam import path_numbers

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


class Sampler:
    """The decisions of paths that are followed side by side: each call makes the next one of them all.

    - seed, sequence: keep pictures, and the sequences within one, apart.
    - indices: of the paths in their sequence, continued over the passes: uint32 (n,).
    """

    def __init__(self, seed, sequence, indices):
        self._key = mix(mix(seed) ^ sequence)
        self._indices = indices
        self._decision = 0

    def uniform(self):
        """Uniform in [0, 1): float32 (n,)."""
        decision = self._decision
        self._decision += 1
        return path_numbers(self._key >> 32, self._key & 0xFFFFFFFF, self._indices, decision)

    def pair(self):
        """Two decisions: float32 (n, 2)."""
        return np.stack([self.uniform(), self.uniform()], axis=1)

    def take(self, chosen):
        """Goes on with some of the paths: a bool or index array."""
        self._indices = self._indices[chosen]


def pixel_offset(seed, pass_):
    """Where in the pixel the eye rays of a pass start, in [0, 1)^2: evenly over the passes."""
    return _of_eye_rays(seed, pass_).pair()[0].tolist()


def lens_offsets(seed, pass_, pixels):
    """Where in the lens those of some pixels, by their numbers, start: float64 (n, 2) in [0, 1), evenly over the passes of each."""
    sampler = _of_eye_rays(seed, pass_)
    sampler.pair()
    shift = mix(np.asarray(pixels, np.uint64) ^ np.uint64(mix(seed ^ 0x1E45)))
    shifts = np.stack([shift >> np.uint64(32), shift & np.uint64(0xFFFFFFFF)], axis=1) / 2.0**32
    return (sampler.pair()[0].astype(np.float64) + shifts) % 1.0


def _of_eye_rays(seed, pass_):
    return Sampler(seed, 0xCA3E7A, np.array([pass_], np.uint32))
