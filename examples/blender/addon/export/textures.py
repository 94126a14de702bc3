# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader nodes that compute values from places: what varies in a volume or in a lamp's light, as Cycles computes it.

Numbers of n places are float64 (n, 1), colours and vectors (n, 3).
"""

from dataclasses import dataclass

import numpy as np
from mathutils import Euler

from .arithmetic import Elsewhere, NotConstant, as_colour
from .ies import Unreadable, measured
from .images import SKY_COLUMNS, blocks, is_multiplied, is_plain, linear
from .noise import fractal, hashed, perlin
from .relief import RELIEF

#: Vectors are not larger.
_FAR = 1e12


@dataclass(frozen=True)
class Places:
    """Places in or on an object, or directions from a lamp; each float64 (n, 3), or None where it has no meaning."""

    #: In the world, in the object's space [m], and from 0 to 1 across its texture space.
    world: np.ndarray | None = None
    object: np.ndarray | None = None
    generated: np.ndarray | None = None
    #: Unit normals of a lamp, away from it: in its own space, and in the world; and where its light goes, in the world, if not along these.
    away: np.ndarray | None = None
    away_in_world: np.ndarray | None = None
    leaving: np.ndarray | None = None
    #: From a lamp [m], float64 (n, 1); infinity: from a sun.
    distance: np.ndarray | None = None
    #: grids.Lookup of what a volume holds there; surface_places.OnSurface.
    held: object = None
    surface: object = None
    #: relief.Standing of places on a surface, three by three.
    standing: object = None
    #: sky_texture.Sky, or why there is none, by pointer of Sky Texture nodes; and suns to show, as radiance (3,), by the same.
    skies: dict | None = None
    suns: dict | None = None

    @property
    def uv(self):
        """Texture coordinates, (n, 3)."""
        return self.surface.uv() if self.surface is not None else None


def _coordinates(node, output, argument, places):
    if output.identifier == "Object" and node.object is not None and places.world is not None:
        matrix = np.linalg.pinv(np.array(node.object.matrix_world, np.float64))
        return places.world @ matrix[:3, :3].T + matrix[:3, 3]
    found = {
        "Generated": places.generated,
        "Object": places.object if node.object is None else None,
        "Normal": places.away,
        "UV": None if node.from_instancer else places.uv,
    }
    return _known(node, output, found.get(output.identifier))


def _uv_map(node, output, argument, places):
    return _known(node, output, None if node.from_instancer or places.surface is None else places.surface.uv(node.uv_map))


def _colour_attribute(node, output, argument, places):
    if places.surface is None:
        raise NotConstant(node.name)
    look = places.surface.alpha if output.identifier == "Alpha" else places.surface.colour
    return look(node.layer_name)


def _geometry(node, output, argument, places):
    away = places.away_in_world
    leaving = away if places.leaving is None else places.leaving
    found = {"Position": places.world, "Normal": away, "True Normal": away, "Incoming": leaving}
    return _known(node, output, found.get(output.identifier))


#: By output of a Light Falloff node, the power of the distance that its light is multiplied with.
_FALLOFF = {"Quadratic": 0, "Linear": 1, "Constant": 2}


def _falloff(node, output, argument, places):
    distance, strength = _known(node, output, places.distance), argument("Strength")
    # Cycles' suns are infinitely far away, and do not fall off.
    if np.isinf(distance).all():
        return strength
    squared, smooth = distance**2, np.maximum(argument("Smooth"), 0)
    smoothed = np.where(smooth > 0, squared / np.where(smooth > 0, smooth + squared, 1), 1)
    return strength * smoothed * distance ** _FALLOFF[output.identifier]


def _known(node, output, value):
    if value is None:
        raise NotConstant(f"{node.name}, {output.name}")
    return value


def _vector(argument):
    """The input Vector, (n, 3); (1, 3) if it is the same everywhere. What is no number is 0, and nothing is beyond _FAR."""
    return np.clip(np.nan_to_num(np.atleast_2d(as_colour(argument("Vector")))), -_FAR, _FAR)


def _attribute(node, output, argument, places):
    if places.surface is not None and node.attribute_name:
        look = {"Fac": places.surface.number, "Alpha": places.surface.alpha}.get(output.identifier, places.surface.colour)
        return look(node.attribute_name)
    return _held(node, output.identifier, node.attribute_name, places)


def _volume_info(node, output, argument, places):
    return _held(node, {"Color": "Color"}.get(output.identifier, "Fac"), output.identifier.lower(), places)


def _held(node, kind, name, places):
    """What a volume holds by a name: nothing of it is 0, as in Cycles."""
    if places.held is None:
        raise NotConstant(node.name)
    look = {"Fac": places.held.number, "Alpha": places.held.alpha}.get(kind, places.held.colour)
    value, missing = look(name), 0.0 if kind in ("Fac", "Alpha") else np.zeros(3)
    return missing if value is None else value


def _mapping(node, output, argument, places):
    vector, scale, rotation = _vector(argument), argument("Scale"), argument("Rotation")
    if np.ndim(rotation) > 1:
        raise Elsewhere(f"{node.name}, whose rotation varies")
    # Columns of the matrix are where the axes go.
    turn = np.array(Euler(rotation, "XYZ").to_matrix(), np.float64)
    if node.vector_type == "POINT":
        return (vector * scale) @ turn.T + argument("Location")
    if node.vector_type == "TEXTURE":
        moved = (vector - argument("Location")) @ turn
        return np.where(scale != 0, moved / np.where(scale != 0, scale, 1), 0)
    if node.vector_type == "VECTOR":
        return (vector * scale) @ turn.T
    raise Elsewhere(f"{node.name} of a normal")


def _gradient(node, output, argument, places):
    x, y, z = _vector(argument).T[..., None]
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


def _ies(node, output, argument, places):
    try:
        found = measured(node)
    except (Unreadable, OSError) as reason:
        raise NotConstant(f"{node.name}, whose file cannot be read ({reason})") from reason
    x, y, z = _vector(argument).T
    length = np.maximum(np.sqrt(x * x + y * y + z * z), 1e-30)
    return argument("Strength") * found.at(np.arccos(np.clip(-z / length, -1, 1)), np.arctan2(x, y) + np.pi)[:, None]


def _environment(node, output, argument, places):
    if node.projection != "EQUIRECTANGULAR":
        raise Elsewhere(f"{node.name}, which is no equirectangular picture")
    if not is_plain(node.image):
        raise Elsewhere(f"{node.name}, whose colours are {node.image.colorspace_settings.name}")
    cells = blocks(node.image, SKY_COLUMNS)
    if cells is None:
        raise NotConstant(f"{node.name}, whose image cannot be read")
    vector = _vector(argument)
    far = np.maximum(np.linalg.norm(vector, axis=1, keepdims=True), 1e-30)
    return cells[sky_cells(vector / far, *cells.shape[:2])]


def sky_cells(direction, rows, columns):
    """Rows and columns of a sky (host.scene.Light) that lie in unit directions (n, 3): int (n,) both."""
    row = np.clip(np.arccos(np.clip(direction[:, 2], -1, 1)) * (rows / np.pi), 0, rows - 1).astype(int)
    azimuth = np.arctan2(direction[:, 1], direction[:, 0])
    return row, np.clip((1 - azimuth / np.pi) * (0.5 * columns), 0, columns - 1).astype(int)


def _sky(node, output, argument, places):
    sky = (places.skies or {}).get(node.as_pointer())
    if sky is None or isinstance(sky, str):
        raise NotConstant(f"{node.name} ({sky})" if sky else node.name)
    vector = _vector(argument)
    far = np.maximum(np.linalg.norm(vector, axis=1, keepdims=True), 1e-30)
    return sky.cells[sky_cells(vector / far, *sky.cells.shape[:2])] + (places.suns or {}).get(node.as_pointer(), np.zeros(3))


def image_at(node, output, argument, pixels):
    """Colour or alpha of an Image Texture node whose image has these pixels, (h, w, 4), as images.picture has them; raises NotConstant for
    what is not flat."""
    if node.projection != "FLAT" or node.extension not in ("REPEAT", "EXTEND", "CLIP"):
        raise Elsewhere(f"{node.name} ({node.projection}, {node.extension})".lower())
    if not is_plain(node.image):
        raise Elsewhere(f"{node.name}, whose colours are {node.image.colorspace_settings.name}")
    height, width, _ = pixels.shape
    place = _vector(argument)[:, :2] * (width, height) - 0.5
    steps = (0, 1) if node.interpolation != "Closest" else (0,)
    if len(steps) == 1:
        place = place + 0.5
    low, found = np.floor(place), 0
    rest = place - low
    for dx in steps:
        for dy in steps:
            at, inside = low + (dx, dy), True
            if node.extension == "CLIP":
                inside = ((at >= 0) & (at < (width, height))).all(axis=1, keepdims=True)
            wrapped = at % (width, height) if node.extension == "REPEAT" else np.clip(at, 0, (width - 1, height - 1))
            x, y = wrapped.astype(int).T
            weight = (rest[:, 0] if dx else 1 - rest[:, 0]) * (rest[:, 1] if dy else 1 - rest[:, 1])
            found = found + (weight[:, None] if len(steps) == 2 else 1) * np.where(inside, pixels[y, x], 0)
    colour, alpha = found[:, :3], found[:, 3:]
    if output.identifier == "Alpha":
        return alpha
    # Cycles divides by alpha where that is asked for too.
    if next(s for s in node.outputs if s.identifier == "Alpha").is_linked and is_multiplied(node.image):
        colour = colour / np.where((alpha > 0) & (alpha < 1), alpha, 1)
    return linear(node.image, colour)


def _noise(node, output, argument, places):
    # Before Blender 4.1 there is no other kind and no choice.
    if node.noise_dimensions != "3D" or getattr(node, "noise_type", "FBM") != "FBM":
        raise Elsewhere(f"{node.name} ({node.noise_dimensions}, {getattr(node, 'noise_type', 'FBM')})")
    if output.identifier == "Color":
        raise Elsewhere(f"{node.name}, {output.name}")
    at = _vector(argument) * argument("Scale")
    distortion = argument("Distortion")
    if np.any(distortion):
        at = at + distortion * np.stack([perlin(at + _offset(k)) for k in range(3)], axis=-1)
    octaves = [argument(name) for name in ("Detail", "Roughness", "Lacunarity")]
    if any(np.ndim(value) for value in octaves):
        raise Elsewhere(f"{node.name}, whose detail varies")
    detail, roughness, lacunarity = np.nan_to_num(octaves)
    value = fractal(at, np.clip(detail, 0, 15), max(roughness, 0), lacunarity, getattr(node, "normalize", True))
    return value[:, None]


def _offset(k):
    """Where the k-th noise is read that distorts another."""
    return 100 + 100 * np.array([hashed(k, axis) for axis in range(3)])


#: By type of node: function of the node, its output, the values of its inputs by identifier, and the Places.
TEXTURES = {
    "TEX_COORD": _coordinates,
    "NEW_GEOMETRY": _geometry,
    "MAPPING": _mapping,
    "TEX_GRADIENT": _gradient,
    "TEX_NOISE": _noise,
    "TEX_IES": _ies,
    "TEX_ENVIRONMENT": _environment,
    "TEX_SKY": _sky,
    "ATTRIBUTE": _attribute,
    "VOLUME_INFO": _volume_info,
    "UVMAP": _uv_map,
    "VERTEX_COLOR": _colour_attribute,
    "LIGHT_FALLOFF": _falloff,
    **RELIEF,
}

#: What stands for an input "Vector" without a link: a field of Places.
UNLINKED = {
    "TEX_IMAGE": "uv",
    "TEX_GRADIENT": "generated",
    "TEX_NOISE": "generated",
    "TEX_VORONOI": "generated",
    "TEX_WAVE": "generated",
    "TEX_MAGIC": "generated",
    "TEX_BRICK": "generated",
    "TEX_CHECKER": "generated",
    "TEX_GABOR": "generated",
    "TEX_IES": "away",
    "TEX_ENVIRONMENT": "world",
    "TEX_SKY": "world",
}
