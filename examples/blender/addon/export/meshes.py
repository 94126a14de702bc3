# SPDX-License-Identifier: GPL-3.0-or-later
"""Evaluated Blender meshes -> triangles as numpy arrays."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Triangles:
    """A mesh in its own space."""

    #: [m], float32 (n, 3)
    positions: np.ndarray
    #: Indices of corners, int32 (m, 3).
    corners: np.ndarray
    #: Material slots, int32 (m,), and which there are, ascending.
    slots: np.ndarray
    used: np.ndarray
    #: Unit normals at the corners, float32 (m, 3, 3); None: flat.
    normals: np.ndarray | None
    #: Largest absolute coordinates [m], float32 (3,); NaN if one is none.
    extent: np.ndarray
    #: Of triangles that have been cut: of which of Blender's each is a part, int (m,), and shares of its corners at those of the part, float64
    #: (m, 3, 3). None: all are whole.
    part_of: tuple | None = None


def triangles(mesh):
    """The Triangles of an evaluated bpy.types.Mesh, or None if it has none."""
    mesh.calc_loop_triangles()
    count = len(mesh.loop_triangles)
    if count == 0:
        return None
    # Attributes and the arrays of triangles are copied as a whole; properties that RNA computes take longer by far.
    loops = np.empty(count * 3, np.int32)
    mesh.loop_triangles.foreach_get("loops", loops)
    vertices = np.empty(len(mesh.loops), np.int32)
    mesh.attributes[".corner_vert"].data.foreach_get("value", vertices)
    positions = np.empty(len(mesh.vertices) * 3, np.float32)
    mesh.attributes["position"].data.foreach_get("vector", positions)
    normals = None
    if mesh.normals_domain != "FACE":
        of_loops = np.empty(len(mesh.loops) * 3, np.float32)
        mesh.corner_normals.foreach_get("vector", of_loops)
        normals = of_loops.reshape(-1, 3)[loops].reshape(-1, 3, 3)
    positions, corners = positions.reshape(-1, 3), vertices[loops].reshape(-1, 3)
    if normals is not None:
        _mend(normals, positions, corners)
    slots = _slots(mesh, count)
    return Triangles(positions, corners, slots, np.flatnonzero(np.bincount(slots)), normals, extent_of(positions))


def extent_of(positions):
    """Triangles.extent of vertices, (n, 3) with n > 0."""
    return np.maximum(positions.max(axis=0), -positions.min(axis=0))


def box(low, high):
    """The Triangles of a box between two corners [m], float64 (3,), faces to the outside."""
    corners = np.array([[(low, high)[(k >> axis) & 1][axis] for axis in range(3)] for k in range(8)], np.float32)
    faces = np.array([(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)], np.int32)
    halves = np.concatenate([faces[:, [0, 1, 2]], faces[:, [0, 2, 3]]])
    return Triangles(corners, halves, np.zeros(len(halves), np.int32), np.zeros(1, np.int64), None, extent_of(corners))


def _slots(mesh, count):
    indices = mesh.attributes.get("material_index")
    if indices is None:
        return np.zeros(count, np.int32)
    of_faces = np.empty(len(mesh.polygons), np.int32)
    indices.data.foreach_get("value", of_faces)
    faces = np.empty(count, np.int32)
    mesh.loop_triangle_polygons.foreach_get("value", faces)
    # Blender takes what is below the first slot for the first.
    return np.maximum(of_faces[faces], 0)


def _mend(normals, positions, corners):
    """Replaces normals that are not unit, as faces without area give to their neighbours, by the triangles' own."""
    square = np.einsum("mck,mck->mc", normals, normals)
    bad = ~(np.abs(square - 1) < 5e-4)
    if bad.any():
        normals[bad] = np.broadcast_to(flat_normals(positions, corners)[:, None], normals.shape)[bad]


def flat_normals(positions, corners):
    """Unit normals of triangles, (m, 3); upright where they have no area."""
    a, b, c = (positions[corners[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    length = np.linalg.norm(across, axis=1, keepdims=True)
    return np.where(length > 0, across / np.where(length > 0, length, 1), np.float32([0, 0, 1]))


def is_closed(mesh):
    """Whether each edge of these Triangles has a triangle on both sides."""
    a, b, c = mesh.corners.T
    ends = np.sort(np.stack([np.concatenate([a, b, c]), np.concatenate([b, c, a])], axis=1), axis=1).astype(np.int64)
    _, counts = np.unique(ends[:, 0] << 32 | ends[:, 1], return_counts=True)
    return bool(np.all(counts % 2 == 0))


#: Coordinates beyond it, or that are no numbers, are not rendered [m].
FARTHEST = 1e9


def reach(mesh, matrix):
    """Largest coordinate that these Triangles may have after a transform (4, 4) [m]; NaN if one of them is."""
    return np.max(np.abs(matrix[:3, :3]) @ mesh.extent + np.abs(matrix[:3, 3]))


def in_world(mesh, matrix):
    """Positions of these Triangles after a transform (4, 4): float32 (n, 3)."""
    return (mesh.positions @ matrix[:3, :3].T + matrix[:3, 3]).astype(np.float32)


#: How far the bounds of fog are drawn in, in shares of the scene's largest coordinate: four times what rays start off
#: surfaces. Those of different objects differ, or the faces of fog in fog would still coincide; so many do.
_INSET, _INSETS = 2.0**-18, 8


def inset(matrix, low, high, reach, number):
    """The transform (4, 4) of an object that does nothing but bound fog, made smaller by a hair, and its corners then.

    Fog stands on floors and touches walls and other fog. Of two faces in one plane a ray would cross one only, or the
    wrong one.

    - low, high: corners of the object in the world [m]; reach: the largest coordinate of the scene [m].
    - number: of the object.
    """
    low, high = np.asarray(low, np.float64), np.asarray(high, np.float64)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    hair = np.minimum((1 + number % _INSETS) * _INSET * reach, 0.1 * half)
    smaller = np.eye(4)
    smaller[:3, :3] = np.diag(np.where(half > 0, 1 - hair / np.where(half > 0, half, 1), 1))
    smaller[:3, 3] = middle - smaller[:3, :3] @ middle
    return smaller @ matrix, low + hair, high - hair
