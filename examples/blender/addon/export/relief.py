# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader nodes that move surfaces or bend their normals, by the definitions of Cycles, and where on surfaces they are asked for them.

They are asked for places three by three: n places, n a small step beside them, and n a small step to another side. Vectors are in the world.
"""

from dataclasses import dataclass, replace

import numpy as np

from .arithmetic import NotConstant, as_colour, as_number
from .trees import nodes_in


@dataclass(frozen=True)
class Standing:
    """How a surface stands at n places of an object."""

    #: Unit, float64 (n, 3), and steps from the places to those beside them [m], float64 (n, 3) each.
    normals: np.ndarray
    steps: tuple
    #: The object's transform without its translation, float64 (3, 3).
    matrix: np.ndarray
    #: A function of the name of texture coordinates, or "", that returns unit tangents in the object's space (n, 3), and 1 or -1 for the side
    #: of the other tangent, (n, 1); None if there are none.
    tangents: object

    def to_object(self, normals):
        """Normals of the world in the object's space."""
        return unit(normals @ self.matrix)

    def to_world(self, normals):
        """And back."""
        return unit(normals @ np.linalg.pinv(self.matrix))

    def in_object(self):
        """The same in the object's space."""
        into = np.linalg.pinv(self.matrix).T
        return replace(self, normals=self.to_object(self.normals), steps=tuple(step @ into for step in self.steps), matrix=np.eye(3))


def unit(vectors):
    """The same, of length 1; what is 0 or no number is 0."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.where(length > 0, vectors / np.where(length > 0, length, 1), 0.0)


def _thrice(vectors):
    """What n places have, for those beside them too."""
    return np.tile(vectors, (3, 1))


def _here(value, count):
    """A value at the first n of 3 n places, (n, ...), whether it varies or not."""
    return np.broadcast_to(value, (3 * count, np.shape(value)[-1]))[:count] if np.ndim(value) == 2 else value


def _standing(node, places):
    if places.standing is None:
        raise NotConstant(node.name)
    return places.standing


def _normals(argument, standing):
    """The input Normal of a node, or the surface's own if nothing is linked to it."""
    given = as_colour(argument("Normal"))
    return _here(unit(given), len(standing.normals)) if np.any(given) else standing.normals


def _bump(node, output, argument, places):
    standing = _standing(node, places)
    normals, count = _normals(argument, standing), len(standing.normals)
    height, distance, strength = (as_number(argument(name)) for name in ("Height", "Distance", "Strength"))
    distance, strength = _here(distance, count), np.maximum(_here(strength, count), 0)
    bent = bent_by(height, standing, normals, -distance if node.invert else distance)
    mixed = unit(strength * bent + (1 - strength) * normals)
    return _thrice(np.where(np.any(mixed != 0, axis=1, keepdims=True), mixed, normals))


def bent_by(height, standing, normals, distance):
    """Normals (n, 3) of a surface that is raised by a height at 3 n places, times a distance [m]."""
    if np.ndim(height) == 0:
        return normals
    centre, first, second = np.split(np.broadcast_to(height, (3 * len(normals), 1)), 3)
    one, other = standing.steps
    across, along = np.cross(other, normals), np.cross(normals, one)
    area = (one * across).sum(axis=1, keepdims=True)
    slope = ((first - centre) * across + (second - centre) * along) / np.where(area != 0, area, 1)
    bent = unit(normals - distance * np.where(area != 0, slope, 0))
    return np.where(np.isfinite(bent).all(axis=1, keepdims=True), bent, normals)


def _normal_map(node, output, argument, places):
    standing = _standing(node, places)
    normals, count = standing.normals, len(standing.normals)
    colour = np.broadcast_to(_here(as_colour(argument("Color")), count), (count, 3))
    strength = np.maximum(_here(as_number(argument("Strength")), count), 0)
    turned = 2 * colour - 1
    if node.space == "TANGENT":
        found = standing.tangents(node.uv_map)
        if found is None:
            return _thrice(normals)
        tangents, sides = found
        base = standing.to_object(normals)
        x, y, z = (turned[:, k, None] for k in range(3))
        x, y, z = x * strength, y * strength, 1 + (z - 1) * np.minimum(strength, 1)
        made = standing.to_world(unit(x * tangents + y * sides * np.cross(base, tangents) + z * base))
    else:
        if node.space.startswith("BLENDER"):
            turned = turned * (1, -1, -1)
        made = standing.to_world(unit(turned)) if node.space.endswith("OBJECT") else unit(turned)
        made = unit(normals + (made - normals) * strength)
    return _thrice(np.where(np.isfinite(made).all(axis=1, keepdims=True) & np.any(made != 0, axis=1, keepdims=True), made, normals))


def _displacement(node, output, argument, places):
    standing = _standing(node, places)
    way = _normals(argument, standing)
    if node.space == "OBJECT":
        way = standing.to_object(way) @ standing.matrix.T
    height, middle, scale = (as_number(argument(name)) for name in ("Height", "Midlevel", "Scale"))
    return _thrice(way) * (height - middle) * scale


def _vector_displacement(node, output, argument, places):
    standing = _standing(node, places)
    vector, middle, scale = as_colour(argument("Vector")), as_number(argument("Midlevel")), as_number(argument("Scale"))
    moved = np.broadcast_to((vector - middle) * scale, (3 * len(standing.normals), 3))
    if node.space == "TANGENT":
        found = standing.tangents("")
        if found is None:
            raise NotConstant(f"{node.name} without texture coordinates")
        tangents, sides = found
        base = standing.to_object(standing.normals)
        frame = [_thrice(axis) for axis in (tangents, base, sides * np.cross(base, tangents))]
        moved = sum(moved[:, k, None] * axis for k, axis in enumerate(frame))
    return moved if node.space == "WORLD" else moved @ standing.matrix.T


#: As textures.TEXTURES.
RELIEF = {"BUMP": _bump, "NORMAL_MAP": _normal_map, "DISPLACEMENT": _displacement, "VECTOR_DISPLACEMENT": _vector_displacement}


def is_turned(tree):
    """Whether nodes of a tree, or of groups in it, give vectors of the world's directions."""
    return any(node.type in RELIEF and getattr(node, "space", "").endswith("WORLD") for node in nodes_in(tree))


@dataclass(frozen=True)
class Ground:
    """A surface_places.Surface that stands in the world by a transform without its translation, float64 (3, 3)."""

    surface: object
    matrix: np.ndarray

    def places(self, triangles, shares, step, of_vertices=False):
        """textures.Places, three by three, of places in some triangles, (n,), at shares of their corners (n, 3). step: how far the others are,
        in shares; of_vertices: whether normals are between those of vertices, whatever the shading."""
        beside = [shares + step * np.array(way) for way in ((-1.0, 1.0, 0.0), (-1.0, 0.0, 1.0))]
        places = self.surface.places(np.tile(triangles, 3), np.concatenate([shares, *beside]))
        edges = self.surface.edges(triangles)
        normals = (self.surface.vertex_normals if of_vertices else self.surface.normals)(triangles, shares)
        normals = unit(normals @ np.linalg.pinv(self.matrix))
        steps = tuple(step * (edge @ self.matrix.T) for edge in edges)
        return replace(places, standing=Standing(normals, steps, self.matrix, lambda name: self.surface.tangents(name, triangles, shares)))
