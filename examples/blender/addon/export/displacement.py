# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces that materials move: the vertices of a mesh, and its normals then, as in Cycles."""

from dataclasses import replace

import numpy as np

from .materials import leads_somewhere
from .meshes import extent_of, flat_normals
from .nodes import Values
from .relief import Ground, unit

#: Shares of a triangle at which places beside its corners are looked at, where displacements ask for slopes.
_STEP = 1e-3


def moves(material):
    """Whether a bpy.types.Material that nodes describe moves the surface."""
    output = material.node_tree.get_output_node("CYCLES")
    return output is not None and material.displacement_method != "BUMP" and leads_somewhere(output.inputs["Displacement"])


def displaced(surface, matrix, of_triangles, report):
    """The Triangles of a surface_places.Surface that stands in the world by a transform without its translation, (3, 3), moved.

    of_triangles: by bpy.types.Material that `moves`: which triangles bear it, bool (m,).
    """
    mesh, is_torn = surface.apart()
    positions, remade = mesh.positions.astype(np.float64), np.zeros(len(mesh.corners), bool)
    into = np.linalg.pinv(matrix)
    # A vertex goes where the first triangle with such a material sends it.
    order = np.full(len(positions), len(mesh.corners))
    for which in of_triangles.values():
        np.minimum.at(order, mesh.corners[which], np.flatnonzero(which)[:, None])
    for material, which in of_triangles.items():
        if material.displacement_method == "DISPLACEMENT":
            remade |= which
        triangle, corner = np.nonzero(which[:, None] & (order[mesh.corners] == np.arange(len(which))[:, None]))
        vertices, first = np.unique(mesh.corners[triangle, corner], return_index=True)
        places = Ground(surface, matrix).places(triangle[first], np.eye(3)[corner[first]], _STEP, of_vertices=not is_torn)
        positions[vertices] += _moved(material, places, report) @ into.T
    positions = positions.astype(np.float32)
    normals = _normals(mesh, positions, remade, surface.is_smooth())
    return replace(mesh, positions=positions, normals=normals, extent=extent_of(positions))


def _moved(material, places, report):
    """How far places are moved in the world, (n, 3)."""
    values = Values(f'Material "{material.name}"', report)
    output, count = material.node_tree.get_output_node("CYCLES"), len(places.standing.normals)
    with np.errstate(all="ignore"):
        value = values.at(places).known(output, "Displacement", ())
    if isinstance(value, str):
        values.note(f"displacement by {value}", "the surface stays where it is", True)
        return np.zeros((count, 3))
    value = np.broadcast_to(value, (3 * count, 3))[:count]
    return np.where(np.isfinite(value).all(axis=1, keepdims=True), value, 0)


def _normals(mesh, positions, remade, smooth):
    """Normals at corners: around vertices of triangles that are `remade` the mean of all such, each counting as much."""
    if mesh.normals is None:
        return None
    flat = flat_normals(positions.astype(np.float64), mesh.corners)
    around = np.zeros((len(positions), 3))
    np.add.at(around, mesh.corners[remade], flat[remade][:, None])
    around = unit(around)[mesh.corners]
    made = np.where(around.any(axis=2, keepdims=True), around, mesh.normals)
    return np.where(smooth[:, None, None], made, flat[:, None]).astype(np.float32)
