# SPDX-License-Identifier: GPL-3.0-or-later
"""Sums of surface closures -> a row of host.scene.MATERIAL."""

import numpy as np

from ..host.scene import MATERIAL

#: The fields that are weights per channel.
WEIGHTS = tuple(name for name in MATERIAL.names if MATERIAL[name].shape)


class Lobes:
    """What a surface's closures add up to: weights (3,) by field of MATERIAL, and emitted radiance [W/(m^2 sr)]."""

    def __init__(self):
        self.weights = {name: np.zeros(3) for name in WEIGHTS}
        self.emission = np.zeros(3)
        # Lobes that have an ior or a roughness: (weight, ior or None, roughness).
        self._specular = []

    def add(self, **weights):
        """Adds weights per channel, or for all, by field."""
        for name, weight in weights.items():
            self.weights[name] = self.weights[name] + weight

    def add_specular(self, ior, roughness, **weights):
        """The same for metal, glass and coat. ior: None if it has none; roughness: Blender's, in [0, 1]."""
        self.add(**weights)
        weight = max(float(np.max(w)) for w in weights.values())
        if weight > 0:
            self._specular.append((weight, ior, min(max(roughness, 0.0), 1.0)))

    def row(self, note):
        """One element of MATERIAL. note(what, instead): called with what a row cannot say."""
        row = np.zeros((), MATERIAL)
        scale = 1.0
        if self._total() > 1.0 + 1e-6:
            scale = 1 / self._total()
            note("reflects more light than it receives", f"all of its lobes are scaled by {scale:.3g}")
        for name, weight in self.weights.items():
            row[name] = weight * scale
        row["ior"] = self._strongest(1, note, "indices of refraction", 1.0)
        row["roughness"] = self._strongest(2, note, "roughnesses", 0.0) ** 2
        return row

    def _total(self):
        """Upper bound of what leaves, in the channel where it is largest."""
        # Fresnel's equations share between both ways that glass takes, and between coat and diffuse.
        w = self.weights
        exclusive = [("diffuse", "coat"), ("metal", "edge"), ("glass_reflection", "glass_transmission")]
        total = sum(np.maximum(w[a], w[b]) for a, b in exclusive) + w["translucent"] + w["transparent"]
        return float(np.max(total))

    def _strongest(self, field, note, name, missing):
        lobes = [lobe for lobe in self._specular if lobe[field] is not None]
        if not lobes:
            return missing
        chosen = max(lobes, key=lambda lobe: lobe[0])[field]
        if any(abs(lobe[field] - chosen) > 1e-3 for lobe in lobes):
            note(f"several {name} in one material", f"that of the strongest, {chosen:.3g}, is used for all")
        return chosen
