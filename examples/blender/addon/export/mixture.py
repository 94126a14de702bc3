# SPDX-License-Identifier: GPL-3.0-or-later
"""Mixtures of phase functions, of closures that are added and of fogs that overlap -> those of host.scene.Volume."""

from dataclasses import dataclass

import numpy as np

from ..host.scene import Phase

#: So little anisotropy is none, as in Cycles; and phase functions that differ less are one.
_NONE, _SAME = 1e-3, 1e-4

#: Shares that vary from place to place by more, on average, make another picture.
_EVEN = 0.02


@dataclass(frozen=True)
class Part:
    """What scatters light by one phase function."""

    #: Scattering coefficients [1/m], float64 (3,), or (n, 3) at places.
    coefficient: np.ndarray
    phase: Phase
    #: Mean cosine of Henyey-Greenstein.
    asymmetry: float


def mixed(values, parts):
    """The phase function of what a list of Parts scatters: a Phase, its mean cosine, and the others beside it, as host.scene.Volume has them.

    values: nodes.Values, for the report.
    """
    found = {}
    for part in parts:
        is_even = part.phase == Phase.HENYEY_GREENSTEIN and abs(part.asymmetry) < _NONE
        key = (Phase.ISOTROPIC, 0.0) if is_even else (part.phase, part.asymmetry)
        key = next((other for other in found if other[0] == key[0] and abs(other[1] - key[1]) < _SAME), key)
        found[key] = found.get(key, 0) + part.coefficient
    if not found:
        return Phase.ISOTROPIC, 0.0, ()
    total = sum(found.values())
    mean = np.atleast_2d(total).mean(axis=0)
    shares = {key: np.atleast_2d(of).mean(axis=0) / np.where(mean > 0, mean, 1) for key, of in found.items()}
    # What scatters differently from place to place has one mixture all the same.
    off = sum(np.abs(of - shares[key] * total).mean() for key, of in found.items()) / max(float(mean.mean()), 1e-30)
    if off > _EVEN:
        values.note("phase functions whose shares vary from place to place", "their mean everywhere", in_fog=True)
    (first, *_), *others = shares.items()
    return *first, tuple((*key, share) for key, share in others)
