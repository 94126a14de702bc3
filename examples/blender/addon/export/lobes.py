# SPDX-License-Identifier: GPL-3.0-or-later
"""Sums of surface closures -> a row of host.scene.MATERIAL."""

import numpy as np

from ..host.scene import MATERIAL

#: The fields that are weights per channel, of all light.
WEIGHTS = tuple(name for name in MATERIAL.names if MATERIAL[name].shape and name != "shadow")


class Lobes:
    """What a surface's closures add up to: weights by field of MATERIAL, and emitted radiance [W/(m^2 sr)], each (3,), or (n, 3) where it
    varies over n places."""

    def __init__(self):
        self.weights = {name: np.zeros(3) for name in WEIGHTS}
        self.emission = np.zeros(3)
        #: What goes straight on of light on its way from a lamp, as a weight; None: what is transparent.
        self.shadow = None
        # Lobes that have an ior or a roughness: (largest weight, ior or None, roughness), numbers as in arithmetic.py.
        self._specular = []

    def add(self, **weights):
        """Adds weights per channel, or for all, by field."""
        for name, weight in weights.items():
            self.weights[name] = self.weights[name] + weight

    def add_specular(self, ior, roughness, **weights):
        """The same for metal, glass and coat. ior: None if it has none; roughness: Blender's, in [0, 1]."""
        self.add(**weights)
        largest = [np.max(np.atleast_1d(weight), axis=-1, keepdims=True) for weight in weights.values()]
        weight = np.maximum.reduce(np.broadcast_arrays(*largest))
        if np.any(weight > 0):
            self._specular.append((weight, ior, np.clip(roughness, 0.0, 1.0)))

    @property
    def passing(self):
        """What decides how light goes on behind the surface, and what it sends out: weights and radiance, (15,) or (n, 15)."""
        parts = [self.weights[name] for name in ("transparent", "translucent", "glass_transmission")]
        parts += [self.weights["transparent"] if self.shadow is None else self.shadow, self.emission]
        return np.concatenate(np.broadcast_arrays(*parts), axis=-1)

    def row(self, note):
        """One element of MATERIAL. note(what, instead): called with what a row cannot say."""
        return self.rows(1, note)[0]

    def rows(self, count, note):
        """MATERIAL at all places, (count,)."""
        rows = np.zeros(count, MATERIAL)
        total = np.broadcast_to(self._total(), count)
        scale = np.where(total > 1.0 + 1e-6, 1 / np.maximum(total, 1.0), 1.0)
        if np.any(scale < 1):
            note("reflects more light than it receives", f"all of its lobes are scaled by {scale.min():.3g}", in_fog=True)
        for name, weight in self.weights.items():
            rows[name] = weight * scale[:, None]
        rows["has_shadow"] = self.shadow is not None
        rows["shadow"] = rows["transparent"] if self.shadow is None else np.clip(self.shadow, 0, 1)
        rows["ior"] = self._strongest(1, note, "indices of refraction", 1.0, count)
        rows["alpha"] = self._strongest(2, note, "roughnesses", 0.0, count) ** 2
        return rows

    def _total(self):
        """Upper bound of what leaves, in the channel where it is largest: a number, or (n,)."""
        # Fresnel's equations share between both ways that glass takes, and between coat and diffuse.
        w = self.weights
        exclusive = [("diffuse", "coat"), ("metal", "edge"), ("glass_reflection", "glass_transmission")]
        total = sum(np.maximum(w[a], w[b]) for a, b in exclusive) + w["translucent"] + w["transparent"]
        return np.max(total, axis=-1)

    def _strongest(self, field, note, name, missing, count):
        """What the strongest lobe has, at each place: (count,)."""
        lobes = [lobe for lobe in self._specular if lobe[field] is not None]
        if not lobes:
            return np.full(count, missing)
        weights = np.array([np.broadcast_to(lobe[0], (count, 1))[:, 0] for lobe in lobes])
        values = np.array([np.broadcast_to(lobe[field], (count, 1))[:, 0] for lobe in lobes])
        chosen = values[np.argmax(weights, axis=0), np.arange(count)]
        differ = (np.abs(values - chosen) > 1e-3) & (weights > 0)
        if differ.any():
            shown = chosen[np.argmax(differ.any(axis=0))]
            note(f"several {name} in one material", f"that of the strongest, {shown:.3g}, is used for all", in_fog=True)
        return np.where(weights.max(axis=0) > 0, chosen, missing)
