# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader nodes that compute values from places: what varies in a volume, as Cycles computes it.

Numbers of n places are float64 (n, 1), colours and vectors (n, 3).
"""

from dataclasses import dataclass

import numpy as np
from mathutils import Euler

from .arithmetic import NotConstant
from .noise import fractal, hashed, perlin


@dataclass(frozen=True)
class Places:
    """Places in an object, each float64 (n, 3) [m]: in the world, in the object's space, and from 0 to 1 across its texture space."""

    world: np.ndarray
    object: np.ndarray
    generated: np.ndarray


def _coordinates(node, output, argument, places):
    if output.identifier == "Generated":
        return places.generated
    if output.identifier == "Object" and node.object is None:
        return places.object
    if output.identifier == "Object":
        matrix = np.linalg.inv(np.array(node.object.matrix_world, np.float64))
        return places.world @ matrix[:3, :3].T + matrix[:3, 3]
    raise NotConstant(f"{node.name}, {output.name}")


def _geometry(node, output, argument, places):
    if output.identifier != "Position":
        raise NotConstant(f"{node.name}, {output.name}")
    return places.world


def _mapping(node, output, argument, places):
    vector, scale = argument("Vector"), argument("Scale")
    # Columns of the matrix are where the axes go.
    turn = np.array(Euler(argument("Rotation"), "XYZ").to_matrix(), np.float64)
    if node.vector_type == "POINT":
        return (vector * scale) @ turn.T + argument("Location")
    if node.vector_type == "TEXTURE":
        moved = (vector - argument("Location")) @ turn
        return np.where(scale != 0, moved / np.where(scale != 0, scale, 1), 0)
    if node.vector_type == "VECTOR":
        return (vector * scale) @ turn.T
    raise NotConstant(f"{node.name} of a normal")


def _separate(node, output, argument, places):
    return argument("Vector")[..., ["X", "Y", "Z"].index(output.identifier), None]


def _combine(node, output, argument, places):
    return np.concatenate([np.broadcast_to(argument(axis), (len(places.world), 1)) for axis in "XYZ"], axis=1)


def _gradient(node, output, argument, places):
    x, y, z = argument("Vector").T[..., None]
    far = np.maximum(0.999999 - np.sqrt(x * x + y * y + z * z), 0)
    value = {
        "LINEAR": lambda: x,
        "QUADRATIC": lambda: np.maximum(x, 0) ** 2,
        "EASING": lambda: _smooth(np.clip(x, 0, 1)),
        "DIAGONAL": lambda: 0.5 * (x + y),
        "RADIAL": lambda: np.arctan2(y, x) / (2 * np.pi) + 0.5,
        "QUADRATIC_SPHERE": lambda: far * far,
        "SPHERICAL": lambda: far,
    }[node.gradient_type]()
    return np.clip(value, 0, 1)


def _smooth(t):
    return t * t * (3 - 2 * t)


def _noise(node, output, argument, places):
    # Before Blender 4.1 there is no other kind and no choice.
    if node.noise_dimensions != "3D" or getattr(node, "noise_type", "FBM") != "FBM":
        raise NotConstant(f"{node.name} ({node.noise_dimensions}, {getattr(node, 'noise_type', 'FBM')})")
    if output.identifier == "Color":
        raise NotConstant(f"{node.name}, {output.name}")
    at = argument("Vector") * argument("Scale")
    distortion = argument("Distortion")
    if np.any(distortion):
        at = at + distortion * np.stack([perlin(at + _offset(k)) for k in range(3)], axis=-1)
    detail, roughness = np.clip(argument("Detail"), 0, 15), np.maximum(argument("Roughness"), 0)
    if np.ndim(detail) or np.ndim(roughness) or np.ndim(argument("Lacunarity")):
        raise NotConstant(f"{node.name}, whose detail varies")
    value = fractal(at, detail, roughness, argument("Lacunarity"), getattr(node, "normalize", True))
    return value[:, None]


def _offset(k):
    """Where the k-th noise is read that distorts another."""
    return 100 + 100 * np.array([hashed(k, axis) for axis in range(3)])


#: By type of node: function of the node, its output, the values of its inputs by identifier, and the Places.
TEXTURES = {
    "TEX_COORD": _coordinates,
    "NEW_GEOMETRY": _geometry,
    "MAPPING": _mapping,
    "SEPXYZ": _separate,
    "COMBXYZ": _combine,
    "TEX_GRADIENT": _gradient,
    "TEX_NOISE": _noise,
}

#: Of these an input "Vector" without a link is the place across the texture space.
GENERATED = ("TEX_GRADIENT", "TEX_NOISE")
