# SPDX-License-Identifier: GPL-3.0-or-later
"""What emitters of all kinds of light have in common."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

#: 1/(4 pi^2): a relative curvature [1/rad^2] as an angular variance [cycles^2/rad^2].
CURVATURE = 1 / (4 * np.pi**2)


@dataclass(frozen=True)
class Ball:
    """A ball, for aiming at what is in it."""

    center: np.ndarray
    radius: float

    @staticmethod
    def around(low, high):
        """The ball around a box."""
        return Ball(0.5 * (low + high), 0.5 * float(np.linalg.norm(high - low)))


class Starts(NamedTuple):
    """What an emitter gives Emitted; dark and until for all of them, or of each."""

    origin: np.ndarray
    direction: np.ndarray
    power: np.ndarray
    normal: np.ndarray
    dark: np.ndarray | float = 0.0
    until: np.ndarray | float = np.inf


class Emitting:
    """What all emitters are worth, in photons a watt: 1, but for the insides of balls."""

    worth = 1.0


def f32(v):
    return np.asarray(v, np.float32)


def disk(u, v):
    """Points of the unit disk: (n, 2)."""
    r, phi = np.sqrt(u), np.float32(2 * np.pi) * v
    return np.stack([r * np.cos(phi), r * np.sin(phi)], axis=1)
