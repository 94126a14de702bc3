# SPDX-License-Identifier: GPL-3.0-or-later
"""Places on a mesh, and what nodes find there: texture coordinates, and attributes by name."""

import numpy as np

from .textures import Places

#: By type of an attribute: name of the property, and how many numbers it has.
_KINDS = {
    "FLOAT": ("value", 1),
    "INT": ("value", 1),
    "BOOLEAN": ("value", 1),
    "FLOAT2": ("vector", 2),
    "FLOAT_VECTOR": ("vector", 3),
    "FLOAT_COLOR": ("color", 4),
    "BYTE_COLOR": ("color", 4),
}


class Surface:
    """The triangles of an evaluated bpy.types.Mesh, whose Triangles have been made."""

    def __init__(self, data, mesh):
        """mesh: meshes.Triangles of `data`."""
        self._data, self._mesh = data, mesh
        self._found = {}

    def places(self, triangles, shares):
        """textures.Places in some triangles, int (n,); shares: of their corners, float64 (n, 3)."""
        on = OnSurface(self, triangles, shares)
        at = on.of_corners(self._mesh.positions[self._mesh.corners])
        middle, half = (np.array(of, np.float64) for of in (self._data.texspace_location, self._data.texspace_size))
        generated = 0.5 * (on.of_corners(self._undeformed()) - middle) / np.where(half > 0, half, 1) + 0.5
        return Places(object=at, generated=generated, surface=on)

    def areas(self, triangles):
        """Areas of some triangles [m^2]: float64 (n,)."""
        return _areas(self._mesh.positions[self._mesh.corners[triangles]].astype(np.float64))

    def uv_areas(self, triangles):
        """The same where no name of texture coordinates is needed; zeros without any."""
        found = self.attribute(self.uv_map())
        if found is None:
            return np.zeros(len(triangles))
        return _areas(np.pad(found[triangles][..., :2], ((0, 0), (0, 0), (0, 1))))

    def uv_map(self):
        """Name of the texture coordinates that are used where none is named; None if there are none."""
        return next((layer.name for layer in self._data.uv_layers if layer.active_render), None)

    def colours(self):
        """The same of colours."""
        index, layers = self._data.color_attributes.render_color_index, self._data.color_attributes
        return layers[index].name if 0 <= index < len(layers) else None

    def attribute(self, name):
        """What the corners of all triangles have by that name, float64 (m, 3, channels), or None."""
        if name not in self._found:
            self._found[name] = self._read(name)
        return self._found[name]

    def _read(self, name):
        attribute = self._data.attributes.get(name) if name else None
        if attribute is None or attribute.data_type not in _KINDS or attribute.domain not in ("POINT", "CORNER", "FACE"):
            return None
        key, channels = _KINDS[attribute.data_type]
        values = np.empty(len(attribute.data) * channels, {"INT": np.int32, "BOOLEAN": bool}.get(attribute.data_type, np.float32))
        attribute.data.foreach_get(key, values)
        values = np.nan_to_num(values.reshape(-1, channels).astype(np.float64))
        if attribute.domain == "POINT":
            return values[self._mesh.corners]
        count = len(self._mesh.corners)
        index = np.empty(count * 3 if attribute.domain == "CORNER" else count, np.int32)
        if attribute.domain == "CORNER":
            self._data.loop_triangles.foreach_get("loops", index)
            return values[index.reshape(-1, 3)]
        self._data.loop_triangle_polygons.foreach_get("value", index)
        return np.repeat(values[index][:, None], 3, axis=1)

    def _undeformed(self):
        """Where corners are before modifiers: float (m, 3, 3) [m]."""
        if "" not in self._found:
            places = np.empty(len(self._data.vertices) * 3, np.float32)
            self._data.vertices.foreach_get("undeformed_co", places)
            self._found[""] = places.reshape(-1, 3)[self._mesh.corners]
        return self._found[""]


def _areas(corners):
    """Areas of triangles, (n, 3, 3)."""
    return 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)


class OnSurface:
    """What places on a Surface have; arguments as of Surface.places."""

    def __init__(self, surface, triangles, shares):
        self._surface, self._triangles, self._shares = surface, triangles, shares

    def of_corners(self, values):
        """Values of the corners of all triangles, (m, 3, channels), at the places: float64 (n, channels)."""
        return np.einsum("nc,nck->nk", self._shares, values[self._triangles])

    def uv(self, name=""):
        """Texture coordinates, (n, 3); zeros if there are none, as in Cycles."""
        found = self._at(name or self._surface.uv_map())
        return self._three(found)

    def colour(self, name=""):
        """A colour or vector, (n, 3); black if there is none."""
        return self._three(self._at(name or self._surface.colours()))

    def number(self, name):
        """A number, (n, 1); 0 if there is none."""
        found = self._at(name)
        if found is None:
            return np.zeros((len(self._triangles), 1))
        return found[:, :1] if found.shape[1] < 3 else found[:, :3].mean(axis=1, keepdims=True)

    def alpha(self, name=""):
        """Alpha of a colour, (n, 1); 1 of what has none, 0 if there is nothing."""
        found = self._at(name or self._surface.colours())
        if found is None:
            return np.zeros((len(self._triangles), 1))
        return found[:, 3:] if found.shape[1] == 4 else np.ones((len(found), 1))

    def _at(self, name):
        values = self._surface.attribute(name)
        return None if values is None else self.of_corners(values)

    def _three(self, found):
        """As a vector: what is missing of it is 0, and a number is three of it."""
        if found is None:
            return np.zeros((len(self._triangles), 3))
        if found.shape[1] == 1:
            return np.repeat(found, 3, axis=1)
        return np.pad(found[:, :3], ((0, 0), (0, 3 - min(found.shape[1], 3))))
