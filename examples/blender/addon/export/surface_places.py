# SPDX-License-Identifier: GPL-3.0-or-later
"""Places on a mesh, and what nodes find there: texture coordinates, and attributes by name."""

from dataclasses import replace

import bpy
import numpy as np

from .meshes import flat_normals
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

    def __init__(self, data, mesh, made=None):
        """mesh: meshes.Triangles of `data`; made: what they have become, moved and cut."""
        self._data, self._mesh = data, mesh
        #: The triangles that all functions count.
        self.mesh = mesh if made is None else made
        self._found = {}

    def become(self, made):
        """The Surface of what these triangles have become: Triangles whose `part_of` says where they were in Blender's."""
        return Surface(self._data, self._mesh, made)

    def places(self, triangles, shares):
        """textures.Places in some triangles, int (n,); shares: of their corners, float64 (n, 3)."""
        on = self._on(triangles, shares)
        at = np.einsum("nc,nck->nk", shares, self.mesh.positions[self.mesh.corners[triangles]])
        middle, half = (np.array(of, np.float64) for of in (self._data.texspace_location, self._data.texspace_size))
        generated = 0.5 * (on.of_corners(self._undeformed()) - middle) / np.where(half > 0, half, 1) + 0.5
        return Places(object=at, generated=generated, surface=on)

    def _on(self, triangles, shares):
        """OnSurface of the same arguments, of Blender's triangles."""
        if self.mesh.part_of is not None:
            whole, corners = self.mesh.part_of
            triangles, shares = whole[triangles], np.einsum("nc,nck->nk", shares, corners[triangles])
        return OnSurface(self, triangles, shares)

    def edges(self, triangles):
        """From the first corners of some triangles to the second and the third [m]: float64 (n, 3) each."""
        a, b, c = (self.mesh.positions[self.mesh.corners[triangles, k]].astype(np.float64) for k in range(3))
        return b - a, c - a

    def normals(self, triangles, shares):
        """Unit normals in some triangles, float64 (n, 3); arguments as of `places`."""
        if self.mesh.normals is None:
            return flat_normals(self.mesh.positions.astype(np.float64), self.mesh.corners[triangles])
        between = np.einsum("nc,nck->nk", shares, self.mesh.normals[triangles])
        length = np.linalg.norm(between, axis=1, keepdims=True)
        return np.where(length > 1e-6, between / np.maximum(length, 1e-6), self.mesh.normals[triangles, 0])

    def vertex_normals(self, triangles, shares):
        """What is between the normals of vertices, of length 1 or less, float64 (n, 3); arguments as of `places`."""
        if "normals" not in self._found:
            found = np.empty(len(self._data.vertices) * 3, np.float32)
            self._data.vertex_normals.foreach_get("vector", found)
            self._found["normals"] = np.nan_to_num(found.reshape(-1, 3)[self._mesh.corners])
        return self._on(triangles, shares).of_corners(self._found["normals"])

    def is_smooth(self):
        """Which triangles are shaded smooth: bool (m,)."""
        whole = np.arange(len(self.mesh.corners)) if self.mesh.part_of is None else self.mesh.part_of[0]
        sharp = self._data.attributes.get("sharp_face")
        if sharp is None:
            return np.ones(len(whole), bool)
        of_faces = np.empty(len(self._data.polygons), bool)
        sharp.data.foreach_get("value", of_faces)
        return ~of_faces[self._faces()][whole]

    def apart(self):
        """The Triangles as Cycles moves them: torn where edges are sharp, as normals at them differ; and whether they may be. With normals
        that are given it tears all faces apart, and none since Blender 5.0."""
        given = self._data.has_custom_normals
        if self._data.normals_domain != "CORNER" or self.mesh.part_of is not None or (given and bpy.app.version >= (5, 0)):
            return self.mesh, False
        corners = self.mesh.corners.ravel()
        ways = self._loops().reshape(-1, 1) if given else np.round(self.mesh.normals.reshape(-1, 3) * 1e4).astype(np.int32)
        _, first, index = np.unique(np.column_stack([corners, ways]), axis=0, return_index=True, return_inverse=True)
        return replace(self.mesh, positions=self.mesh.positions[corners[first]], corners=index.reshape(-1, 3).astype(np.int32)), True

    def tangents(self, name, triangles, shares):
        """Unit vectors along the first of the texture coordinates of a name, or of those for rendering if it is empty, (n, 3), and 1 or -1 for the
        side of the second, (n, 1); None without such coordinates. Arguments as of `places`."""
        name = name or self.uv_map()
        if name is None or name not in self._data.uv_layers:
            return None
        key = name, "tangents"
        if key not in self._found:
            self._found[key] = self._tangents(name)
        tangents, sides = self._found[key]
        on = self._on(triangles, shares)
        found = on.of_corners(tangents)
        length = np.linalg.norm(found, axis=1, keepdims=True)
        return np.where(length > 1e-6, found / np.maximum(length, 1e-6), 0), np.where(on.of_corners(sides) < 0, -1.0, 1.0)

    def _tangents(self, name):
        """The same at the corners of all of Blender's triangles: float64 (m, 3, 3) and (m, 3, 1)."""
        loops, corners = self._loops(), np.empty(len(self._data.polygons), np.int32)
        self._data.polygons.foreach_get("loop_total", corners)
        if corners.max() > 4:
            # Blender has none for such faces.
            return self._flat_tangents(name)
        self._data.calc_tangents(uvmap=name)
        found, sides = np.empty(len(self._data.loops) * 3, np.float32), np.empty(len(self._data.loops), np.float32)
        self._data.loops.foreach_get("tangent", found)
        self._data.loops.foreach_get("bitangent_sign", sides)
        self._data.free_tangents()
        return found.reshape(-1, 3)[loops].astype(np.float64), sides[loops][..., None].astype(np.float64)

    def _flat_tangents(self, name):
        """The same of triangles each for itself."""
        uv = self.attribute(name)[..., :2]
        a, b, c = (self._mesh.positions[self._mesh.corners[:, k]].astype(np.float64) for k in range(3))
        one, other = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
        area = one[:, :1] * other[:, 1:] - one[:, 1:] * other[:, :1]
        along = ((b - a) * other[:, 1:] - (c - a) * one[:, 1:]) * np.sign(area)
        length = np.linalg.norm(along, axis=1, keepdims=True)
        along = np.where(length > 0, along / np.where(length > 0, length, 1), [1.0, 0.0, 0.0])
        return np.repeat(along[:, None], 3, axis=1), np.repeat(np.where(area < 0, -1.0, 1.0)[:, None], 3, axis=1)

    def areas(self, triangles):
        """Areas of some triangles [m^2]: float64 (n,)."""
        return _areas(self.mesh.positions[self.mesh.corners[triangles]].astype(np.float64))

    def uv_areas(self, triangles):
        """The same where no name of texture coordinates is needed; zeros without any."""
        found = self.attribute(self.uv_map())
        if found is None:
            return np.zeros(len(triangles))
        found = found[..., :2]
        if self.mesh.part_of is not None:
            whole, corners = self.mesh.part_of
            found = np.einsum("mkc,mcx->mkx", corners[triangles], found[whole[triangles]])
        else:
            found = found[triangles]
        return _areas(np.pad(found, ((0, 0), (0, 0), (0, 1))))

    def uv_map(self):
        """Name of the texture coordinates that are used where none is named; None if there are none."""
        return next((layer.name for layer in self._data.uv_layers if layer.active_render), None)

    def colours(self):
        """The same of colours."""
        index, layers = self._data.color_attributes.render_color_index, self._data.color_attributes
        return layers[index].name if 0 <= index < len(layers) else None

    def attribute(self, name):
        """What the corners of all triangles have by that name, float64 (m, 3, channels), or None."""
        key = name, "attribute"
        if key not in self._found:
            self._found[key] = self._read(name)
        return self._found[key]

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
        if attribute.domain == "CORNER":
            return values[self._loops()]
        return np.repeat(values[self._faces()][:, None], 3, axis=1)

    def _loops(self):
        """Loops of Blender's at the corners of all of its triangles, int (m, 3)."""
        loops = np.empty(len(self._mesh.corners) * 3, np.int32)
        self._data.loop_triangles.foreach_get("loops", loops)
        return loops.reshape(-1, 3)

    def _faces(self):
        """Faces of Blender's that its triangles are of, int (m,)."""
        faces = np.empty(len(self._mesh.corners), np.int32)
        self._data.loop_triangle_polygons.foreach_get("value", faces)
        return faces

    def _undeformed(self):
        """Where corners are before modifiers: float (m, 3, 3) [m]."""
        if "undeformed" not in self._found:
            places = np.empty(len(self._data.vertices) * 3, np.float32)
            self._data.vertices.foreach_get("undeformed_co", places)
            self._found["undeformed"] = places.reshape(-1, 3)[self._mesh.corners]
        return self._found["undeformed"]


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
