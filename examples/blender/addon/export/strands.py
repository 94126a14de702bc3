# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair of curves objects and of particle systems -> triangles: tubes that take as much light, on average, as the round hairs that Cycles has."""

from dataclasses import dataclass, replace
from math import pi, sin

import bpy
import numpy as np

from .meshes import Triangles, extent_of

#: Sides of tubes, the best first, and how many triangles a mesh of such may have; where there are more hairs they have fewer.
_SIDES = {12: 500_000, 6: 1_500_000, 4: 3_000_000, 3: 4_000_000}

#: Parts of a segment, the best first; how far a part may be off a curve, in radii.
_PARTS, _OFF = (4, 2, 1), 0.25

#: Shares of a turn that are this far apart fill it evenly.
_GOLDEN = (5**0.5 - 1) / 2

#: What curves have as their type where they are polygons.
_POLYGON = 1

#: Cycles' radius where curves have none [m].
_NO_RADIUS = 0.005


@dataclass(frozen=True)
class Strands:
    """Hairs, one after the other."""

    #: Places and radii of their points [m], float64 (n, 3) and (n,).
    positions: np.ndarray
    radii: np.ndarray
    #: First points of each, and the end of the last, int (k + 1,).
    offsets: np.ndarray
    #: Material slots of each, int (k,).
    slots: np.ndarray
    #: Whether they are straight between points: Catmull-Rom splines if not.
    straight: bool


def of_curves(curves, scene):
    """The Strands of an evaluated bpy.types.Curves, as Cycles takes them in a bpy.types.Scene; None without points."""
    count = len(curves.points)
    if count == 0:
        return None
    positions, offsets = np.empty(3 * count, np.float32), np.zeros(len(curves.curves) + 1, np.int32)
    curves.position_data.foreach_get("vector", positions)
    curves.curve_offset_data.foreach_get("value", offsets)
    radii, found = np.full(count, _NO_RADIUS, np.float32), curves.attributes.get("radius")
    if found is not None and found.domain == "POINT" and found.data_type == "FLOAT":
        found.data.foreach_get("value", radii)
    slots = np.zeros(len(offsets) - 1, np.int32)
    return Strands(positions.reshape(-1, 3).astype(np.float64), radii.astype(np.float64), offsets, slots, _is_straight(scene, curves))


def of_particles(thing, depsgraph):
    """The Strands of all particle systems of an object, evaluated in a depsgraph, that are rendered as paths, in its own space; None if there
    are none."""
    in_view = depsgraph.mode == "VIEWPORT"
    slots, parts = max(len(thing.material_slots), 1), []
    into = np.linalg.pinv(np.array(thing.matrix_world, np.float64))
    for system in thing.particle_systems:
        settings = system.settings
        if settings.type != "HAIR" or settings.render_type != "PATH":
            continue
        points = 2 ** (settings.display_step if in_view else settings.render_step) + 1
        points += settings.kink_extra_steps if settings.kink == "SPIRAL" else 0
        parents, children = len(system.particles), len(system.child_particles)
        if in_view:
            children = int(children * settings.display_percentage / 100)
        # Children stand for their parents.
        first = parents if settings.child_type != "NONE" and children else 0
        hairs = parents + children - first
        if hairs == 0:
            continue
        places = [system.co_hair(object=thing, particle_no=hair, step=step) for hair in range(first, first + hairs) for step in range(points)]
        positions = np.array(places, np.float64) @ into[:3, :3].T + into[:3, 3]
        steps = np.linalg.norm(np.diff(positions.reshape(hairs, points, 3), axis=1), axis=2)
        along = np.concatenate([np.zeros((hairs, 1)), steps.cumsum(axis=1)], axis=1)
        radii = _tapered(settings, along / np.where(along[:, -1:] > 0, along[:, -1:], 1))
        slot = min(max(settings.material - 1, 0), slots - 1)
        parts.append((positions, radii.ravel(), np.full(hairs, points), np.full(hairs, slot, np.int32)))
    if not parts:
        return None
    positions, radii, counts, slots = (np.concatenate(of) for of in zip(*parts))
    return Strands(positions, radii, np.concatenate([[0], counts.cumsum()]), slots, _is_straight(depsgraph.scene_eval))


def _tapered(settings, along):
    """Radii of a particle system's hairs, (k, n), at shares of their length."""
    root, tip, shape = (getattr(settings, name) for name in ("root_radius", "tip_radius", "shape"))
    left = np.clip(1 - along, 0, 1) ** (1 + shape if shape < 0 else 1 / max(1 - shape, 1e-6))
    radii = 0.5 * settings.radius_scale * (tip + left * (root - tip))
    if settings.use_close_tip:
        radii[:, -1] = 0
    return radii


def _is_straight(scene, curves=None):
    """Whether Cycles has hair straight between its points in a bpy.types.Scene: there are settings for it since Blender 5.0, and it is so where
    the first of a bpy.types.Curves is a polygon."""
    types = curves.attributes.get("curve_type") if curves is not None and bpy.app.version >= (5, 0) else None
    if types is not None and len(types.data) and types.data[0].value == _POLYGON:
        return True
    # Blender without Cycles has no such setting.
    return getattr(getattr(scene, "cycles_curves", None), "shape", "") == "THICK_LINEAR"


def tubes(strands):
    """The Triangles of Strands, or None if they have none, and of how many hairs one is there, as thick as all of them."""
    coarsest, most = list(_SIDES.items())[-1]
    strands, every = _fewer(strands, most // (2 * coarsest))
    for parts in (1,) if strands.straight else _PARTS:
        lines = _lines(strands, parts)
        if 2 * coarsest * len(lines.positions) <= most:
            break
    sides = next((n for n, most in _SIDES.items() if 2 * n * len(lines.positions) <= most), coarsest)
    return (_around(lines, sides) if len(lines.positions) else None), every


def _fewer(strands, most):
    """Strands of no more than about so many points, each as thick as several, and how many."""
    every = -(-len(strands.positions) // most)
    if every <= 1:
        return strands, 1
    starts, counts = strands.offsets[:-1:every], np.diff(strands.offsets)[::every]
    offsets = np.concatenate([[0], counts.cumsum()])
    of = np.repeat(starts - offsets[:-1], counts) + np.arange(offsets[-1])
    return replace(strands, positions=strands.positions[of], radii=strands.radii[of] * every, offsets=offsets, slots=strands.slots[::every]), every


def _lines(strands, parts):
    """Strands that are straight between points, of splines cut into so many parts at most where they bend."""
    values = np.column_stack([strands.positions, np.maximum(strands.radii, 0)])
    counts = np.diff(strands.offsets)
    strand = np.repeat(np.arange(len(counts)), counts)
    # Segments start at all points but the last of each strand.
    last = np.zeros(len(values), bool)
    last[strands.offsets[1:][counts > 0] - 1] = True
    start = np.flatnonzero(~last)
    before = np.maximum(start - 1, strands.offsets[strand[start]])
    after = np.minimum(start + 2, strands.offsets[strand[start] + 1] - 1)
    a, b, c, d = (values[of] for of in (before, start, start + 1, after))
    if strands.straight:
        # Each for itself, or they would be thin at bends.
        found, offsets = np.stack([b, c], axis=1).reshape(-1, 4), 2 * np.arange(len(start) + 1)
        return Strands(found[:, :3], found[:, 3], offsets, strands.slots[strand[start]], True)
    cut = _cuts(a, b, c, d, parts)
    segment = np.repeat(np.arange(len(start)), cut)
    t = ((np.arange(len(segment)) - np.repeat(cut.cumsum() - cut, cut)) / cut[segment])[:, None]
    a, b, c, d = (of[segment] for of in (a, b, c, d))
    found = b + 0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)))
    # Last points follow the parts of the last segments.
    ends = np.flatnonzero(last)
    which = np.concatenate([start[segment] + t[:, 0], ends])
    order = np.argsort(which, kind="stable")
    found = np.concatenate([found, values[ends]])[order]
    counts = np.bincount(strand[which[order].astype(int)], minlength=len(counts))
    kept = counts > 1
    found = found[np.repeat(kept, counts)]
    offsets = np.concatenate([[0], counts[kept].cumsum()])
    return Strands(found[:, :3], np.maximum(found[:, 3], 0), offsets, strands.slots[kept], True)


def _cuts(a, b, c, d, parts):
    """Into how many parts segments of splines between b and c are cut so that straight ones are hardly off: int (n,)."""
    chord = c - b
    chord = chord / np.maximum(np.linalg.norm(chord, axis=1, keepdims=True), 1e-30)
    bend = np.zeros(len(b))
    # The second derivatives at both ends, across the chord.
    for turn in (2 * a - 5 * b + 4 * c - d, 2 * d - 5 * c + 4 * b - a):
        turn = turn - np.einsum("nk,nk->n", turn, chord)[:, None] * chord
        bend = np.maximum(bend, np.linalg.norm(turn, axis=1))
    off = np.maximum(_OFF * np.minimum(np.abs(b[:, 3]), np.abs(c[:, 3])), 1e-30)
    cut = np.ceil(np.sqrt(np.minimum(bend / 8 / off, parts**2)))
    return np.clip(np.nan_to_num(cut, nan=1), 1, parts).astype(int)


def _around(lines, sides):
    """Triangles of tubes of so many sides around straight Strands of two points and more."""
    points, first = len(lines.positions), np.zeros(len(lines.positions), bool)
    first[lines.offsets[:-1]] = True
    last = np.roll(first, -1)
    index = np.arange(points)
    along = _unit(lines.positions[np.where(last, index, (index + 1) % points)] - lines.positions[np.where(first, index, index - 1)])
    # An axis across each strand's start, carried along by the least of turns. Those of parallel hairs go all ways, so that hairs together are
    # as wide as they should be from wherever they are seen.
    start = along[lines.offsets[:-1]]
    across = _unit(np.cross(start, np.eye(3)[np.abs(start).argmin(axis=1)]))
    roll = (np.arange(len(start)) * _GOLDEN % 1 * (2 * pi))[:, None]
    across = np.cos(roll) * across + np.sin(roll) * np.cross(start, across)
    strand = np.repeat(np.arange(len(lines.slots)), np.diff(lines.offsets))
    one = _unit(_turned(_turns(along, first, lines.offsets), across[strand]))
    other = np.cross(along, one)
    angles = np.arange(sides) * (2 * pi / sides)
    out = np.cos(angles)[:, None] * one[:, None] + np.sin(angles)[:, None] * other[:, None]
    # As wide on average, from all around, as the circle is.
    radii = lines.radii * (pi / sides / sin(pi / sides))
    positions = (lines.positions[:, None] + radii[:, None, None] * out).reshape(-1, 3).astype(np.float32)
    side, after = np.arange(sides), (np.arange(sides) + 1) % sides
    ring = (sides * index[~last])[:, None]
    corners = np.stack([ring + side, ring + after, ring + sides + after, ring + side, ring + sides + after, ring + sides + side], axis=2)
    corners = corners.reshape(-1, 3).astype(np.int32)
    slots = np.repeat(lines.slots[strand[~last]], 2 * sides)
    normals = out.reshape(-1, 3).astype(np.float32)[corners] if sides > 4 else None
    return Triangles(positions, corners, slots, np.unique(slots), normals, extent_of(positions))


def _unit(vectors):
    """The same of length 1; what has no length is upright."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.where(length > 0, vectors / np.where(length > 0, length, 1), [0.0, 0.0, 1.0])


def _turns(along, first, offsets):
    """Quaternions (n, 4) that turn what stands at a strand's first point to each of its points: products of all turns up to there."""
    before = np.roll(along, 1, axis=0)
    turns = np.column_stack([1 + np.einsum("nk,nk->n", before, along), np.cross(before, along)])
    length = np.linalg.norm(turns, axis=1, keepdims=True)
    # Back where it came from is by any axis; none is as good.
    turns = np.where(first[:, None] | (length < 1e-9), [1.0, 0.0, 0.0, 0.0], turns / np.maximum(length, 1e-9))
    place = np.arange(len(along)) - np.repeat(offsets[:-1], np.diff(offsets))
    step = 1
    while step <= place.max():
        far = np.flatnonzero(place >= step)
        turns[far] = _product(turns[far], turns[far - step])
        step *= 2
    return turns


def _product(p, q):
    """Products of quaternions: q first, then p."""
    w = p[:, 0] * q[:, 0] - np.einsum("nk,nk->n", p[:, 1:], q[:, 1:])
    return np.column_stack([w, p[:, :1] * q[:, 1:] + q[:, :1] * p[:, 1:] + np.cross(p[:, 1:], q[:, 1:])])


def _turned(q, v):
    """Vectors turned by unit quaternions."""
    t = 2 * np.cross(q[:, 1:], v)
    return v + q[:, :1] * t + np.cross(q[:, 1:], t)
