# SPDX-License-Identifier: GPL-3.0-or-later
"""Normals that bump and normal maps give to surfaces that are seen in: meshes cut finely enough for these at their corners."""

from dataclasses import dataclass, replace

import numpy as np

from ..host import ask
from .materials import leads_somewhere
from .nodes import Values, closures, find, follow
from .quarters import Pieces, corners, depths
from .relief import bent_by

#: Pieces of a mesh, and of one that hardly reflects, or one a triangle if that is more; and places that are looked at together.
_MOST, _MOST_DULL, _SLICE = 1 << 18, 1 << 16, 1 << 17

#: Normals in the middles of a piece's sides are no farther off what is between those at its corners [rad].
_OFF = np.radians(0.5)

#: How far away heights are looked at for slopes, in pieces.
_STEP = 1 / 8

#: What a closure counts of 1 that reflects as paint does, and what one counts at least that is more than that.
_PAINT, _GLOSSY = 0.04, 0.1

#: Rougher paint is as good as matt.
_ROUGH = 0.5

#: Closures that reflect or refract light into few directions.
_SEEN_IN = {"BSDF_GLASS", "BSDF_REFRACTION", "BSDF_GLOSSY", "BSDF_METALLIC", "BSDF_PRINCIPLED"}


@dataclass(frozen=True)
class Bend:
    """What bends the normals of a bpy.types.Material: the input of a node in some groups, of normals or of displacements."""

    node: object
    identifier: str
    groups: tuple
    #: Whether it displaces, and whether the surface, which is bent from where it was, is displaced too.
    is_displacement: bool
    is_moved: bool
    #: Whether most light leaves in few directions.
    is_seen_in: bool = False


def bend(material, report):
    """The Bend of a material that nodes describe, or None if its normals stay those of the mesh."""
    output = material.node_tree.get_output_node("CYCLES")
    if output is None:
        return None
    values = Values(f'Material "{material.name}"', report)
    lifted = material.displacement_method != "DISPLACEMENT" and leads_somewhere(output.inputs["Displacement"])
    raised = Bend(output, "Displacement", (), True, material.displacement_method == "BOTH") if lifted else None
    found = {}
    for node, groups, weight in closures(values.quiet(), output.inputs["Surface"], (), 1.0):
        own = Bend(node, "Normal", groups, False, False) if values.linked(node, "Normal") else raised
        found[own] = found.get(own, 0.0) + float(np.mean(weight)) * _seen_in(values.quiet(), node, groups)
    if not any(found):
        return None
    chosen = max(found, key=found.get)
    if not found[chosen] > 0:
        # Fog above a floor of waves of 60 degrees is darker by 1.5 %, that beside a card of such of 30 degrees by 3 %. Vectors that move a surface
        # sideways are no bump of what it has become.
        is_far = raised is not None and raised.is_moved and follow(output.inputs["Displacement"]).node.type == "VECTOR_DISPLACEMENT"
        values.note("bump or normal map of a matt surface", "ignored, as light that it scatters hardly depends on it", in_fog=is_far)
        return None
    if sum(strength > 0 for strength in found.values()) > 1:
        values.note("several normals in one material", "those of the strongest closure are used for all", in_fog=True)
    if chosen is None:
        return None
    if chosen.is_displacement or follow(find(chosen.node.inputs, "Normal"), chosen.groups).node.type == "BUMP":
        values.note("bump seen from behind", "what rises in front falls there; in Cycles it rises on both sides")
    return replace(chosen, is_seen_in=found[chosen] > _GLOSSY)


def _seen_in(values, node, groups):
    """How much of a closure's light leaves in few directions."""
    if node.type not in _SEEN_IN:
        return 0.0
    if node.type != "BSDF_PRINCIPLED":
        return 1.0
    clear = max(float(np.mean(values.number(node, name, groups))) for name in ("Metallic", "Transmission Weight"))
    smooth = np.mean(values.number(node, "Roughness", groups)) < _ROUGH and np.mean(values.number(node, "Specular IOR Level", groups)) > 0
    return max(clear, _PAINT if smooth else 0.0)


def normals_of(ground, triangles, material, found, report, poll):
    """The Normals of some triangles that bear a material with this Bend."""
    return Normals(ground, triangles, _bent(material, found, report), _MOST if found.is_seen_in else _MOST_DULL, poll)


def _bent(material, found, report):
    """The normals of such a material: a function of textures.Places, three by three, that returns those of the first of them: unit (n, 3)."""
    values = Values(f'Material "{material.name}"', report)

    def at(places):
        normals = places.standing.normals
        with np.errstate(all="ignore"):
            value = values.at(places).known(found.node, found.identifier, found.groups)
            if isinstance(value, str):
                values.note(f"bump or normal map by {value}", "ignored", True)
                return normals
            value = np.broadcast_to(value, (3 * len(normals), 3))
            if not found.is_displacement:
                return value[: len(normals)]
            # Where the surface is moved Cycles takes slopes in the object's space, of displacements in the world.
            standing = places.standing.in_object() if found.is_moved else places.standing
            height = (value * np.tile(standing.normals, (3, 1))).sum(axis=1, keepdims=True)
            raised = bent_by(height, standing, standing.normals, 1.0)
            return places.standing.to_world(raised) if found.is_moved else raised

    return at


class Normals:
    """The normals of some triangles, int (n,), of a relief.Ground. look: as `_bent` returns it; most: how many pieces."""

    def __init__(self, ground, triangles, look, most, poll):
        self._ground, self._look, self._poll = ground, look, poll
        self._depths = np.zeros(len(ground.surface.mesh.corners), int)
        areas, flat = ground.surface.areas(triangles), ground.surface.uv_areas(triangles)
        # Half of the pieces by how large triangles are, half by how much of an image is on them.
        self._depths[triangles] = found = depths(sum(of / max(float(of.sum()), 1e-300) for of in (areas, flat)), most)
        #: Pieces within which normals are about what is between those at their corners.
        parts = [self._cut(triangles[found == depth], depth) for depth in np.unique(found)]
        self.pieces = Pieces.together(parts)

    def __call__(self, triangles, shares):
        """Unit normals in the object's space, (n, 3), at shares of the corners of some of the triangles."""
        found = np.empty((len(triangles), 3))
        for start in range(0, len(triangles), _SLICE):
            ask(self._poll)
            part = slice(start, start + _SLICE)
            step = _STEP / 2.0 ** self._depths[triangles[part], None]
            places = self._ground.places(triangles[part], shares[part], step)
            found[part] = places.standing.to_object(self._look(places))
        return found

    def _cut(self, triangles, depth):
        """Pieces of triangles that are cut no more often than `depth` times."""
        side = (1 << depth) + 1
        j, i = np.indices((side, side))
        inside = (i + j < side).ravel()
        at = np.stack([i.ravel(), j.ravel()], axis=1)[inside] / (side - 1)
        shares = np.column_stack([1 - at.sum(axis=1), at])
        normals = np.zeros((len(triangles), side * side, 3), np.float32)
        normals[:, inside] = self(np.repeat(triangles, len(shares)), np.tile(shares, (len(triangles), 1))).reshape(len(triangles), -1, 3)
        whole = [np.ones((len(triangles), 4**depth), bool)]
        for level in reversed(range(depth)):
            ends = corners(level) << (depth - level)
            a, b, c = (normals[:, ends[:, k, 0] + side * ends[:, k, 1]] for k in range(3))
            even = whole[0].reshape(len(triangles), -1, 4).all(axis=2)
            for (k, one), (m, other) in (((0, a), (1, b)), ((1, b), (2, c)), ((2, c), (0, a))):
                middle = (ends[:, k] + ends[:, m]) // 2
                even &= _apart(normals[:, middle[:, 0] + side * middle[:, 1]], one + other) <= _OFF
            whole.insert(0, even)
        parts, before = [], np.zeros((len(triangles), 1), bool)
        for level, even in enumerate(whole):
            triangle, number = np.nonzero(even & ~before)
            parts.append(Pieces(triangles[triangle], np.full(len(triangle), level), number, np.zeros(len(triangle), np.int64)))
            before = np.repeat(even | before, 4, axis=1)
        return Pieces.together(parts)

    def off(self, count=4096):
        """How far normals in the middles of pieces are off what is between their corners, on average [rad]."""
        pieces = self.pieces[np.random.default_rng(0).choice(len(self.pieces.level), count)]
        ends = np.empty((count, 3, 3))
        for level in np.unique(pieces.level):
            of = pieces.level == level
            at = corners(level)[pieces.number[of]] / 2**level
            ends[of] = np.concatenate([1 - at.sum(axis=2, keepdims=True), at], axis=2)
        found = [self(pieces.triangle, ends[:, k]) for k in range(3)]
        area = 4.0**-pieces.level * self._ground.surface.areas(pieces.triangle)
        return float(np.average(_apart(self(pieces.triangle, ends.mean(axis=1)), sum(found)), weights=area + 1e-300))


def _apart(ones, others):
    """Angles between unit vectors and vectors of any length [rad]."""
    cross = np.linalg.norm(np.cross(ones, others), axis=-1)
    return np.arctan2(cross, (ones * others).sum(axis=-1))
