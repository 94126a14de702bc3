# SPDX-License-Identifier: GPL-3.0-or-later
"""How much of a medium lies along rays: columns, integrals of its relative density [m]. Where that is 1 they are distances."""

import numpy as np


class Columns:
    """Columns in the volumes of a scene. `volume` in the methods: int (n,), -1 for nothing."""

    def __init__(self, scene):
        self._varied = {i: volume.medium for i, volume in enumerate(scene.volumes) if volume.varies}

    def at(self, volume, origin, direction, distance):
        """Columns up to distances [m]: float32 (n,)."""
        return self._each(volume, distance, lambda medium, of: medium.column_at(origin[of], direction[of], distance[of]))

    def distance(self, volume, origin, direction, column):
        """Distances at which columns are reached [m], inf if they never are: float32 (n,)."""
        endless = np.float32(np.inf)
        return self._each(
            volume, column, lambda medium, of: medium.distance_at(origin[of], direction[of], endless, column[of])
        )

    def media(self, volume):
        """The media whose density varies, each with where it is in `volume`."""
        for number, medium in self._varied.items():
            of = np.flatnonzero(volume == number)
            if len(of):
                yield medium, of

    def _each(self, volume, values, function):
        found = values
        for medium, of in self.media(volume):
            if found is values:
                found = values.copy()
            found[of] = function(medium, of)
        return found
