# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes that materials move, or bend the normals of, each made once for all objects that are stretched alike."""

import numpy as np

from .bump import bend, normals_of
from .displacement import displaced, moves
from .flags import is_diced
from .materials import has_nodes
from .quarters import Pieces, depths, mesh_of
from .relief import Ground, is_turned

#: Pieces of a mesh that is cut before it is moved.
_MOST = 1 << 18

#: How far normals between corners may be off before it is reported [rad], and beyond which light is of another shape for it.
_TOLD, _BLURRED = np.radians(2), np.radians(8)

#: Meshes that are made of one: of more that are stretched otherwise the last has the normals.
_VARIANTS = 16


class Uneven:
    """Makes Surfaces of meshes that are not what Blender has."""

    def __init__(self, report, poll):
        self._report, self._poll = report, poll
        # By pointers that hold as long as the depsgraph lives: what materials do, meshes made, and keys by object.
        self._reliefs, self._made, self._keys = {}, {}, {}

    def key(self, thing, matrix):
        """What tells apart the meshes that are made of an evaluated object's at transforms (4, 4), or None if it is not moved or bent at all."""
        of = thing.original.as_pointer(), thing.data.as_pointer()
        if of not in self._keys:
            reliefs = [self._relief(slot.material) for slot in thing.material_slots] if thing.type == "MESH" else []
            slots = tuple(slot.material and slot.material.as_pointer() for slot in thing.material_slots)
            self._keys[of] = (any(moved or bending for moved, bending, _ in reliefs), any(turned for *_, turned in reliefs), (of[1], *slots), [])
        is_uneven, turned, shared, found = self._keys[of]
        if not is_uneven:
            return None
        linear = matrix[:3, :3]
        # Turned objects are alike, but for what goes by the directions of the world.
        stretch = linear if turned else linear.T @ linear
        size = np.abs(stretch).max()
        if not 0 < size < np.inf:
            return (*shared, None)
        name = (round(25 * np.log(size)), *np.round(50 * stretch / size).astype(int).ravel().tolist())
        if name not in found:
            if len(found) < _VARIANTS:
                found.append(name)
            else:
                self._report.add(f'Object "{thing.name}"', f"bump or displacement at more than {_VARIANTS} sizes", "that of another size", in_fog=True)
                name = found[-1]
        return (*shared, name)

    def _relief(self, material):
        """Whether a material moves surfaces, its bump.Bend or None, and whether either goes by the directions of the world."""
        pointer = material.as_pointer() if material is not None else None
        if pointer not in self._reliefs:
            found = (False, None, False)
            if material is not None and has_nodes(material):
                found = moves(material), bend(material, self._report), is_turned(material.node_tree)
            self._reliefs[pointer] = found
        return self._reliefs[pointer]

    def made(self, surface, key, thing, matrix):
        """The Surface that a Surface of an evaluated object becomes at a transform (4, 4), and a dict for its numbers in the geometry."""
        if key not in self._made:
            self._made[key] = self._bent(*self._moved(surface, thing, matrix[:3, :3]), thing, matrix[:3, :3]), {}
        return self._made[key]

    def _moved(self, surface, thing, matrix):
        """A Surface, as finely cut as it has to be, and moved."""
        moved = self._moving(surface, thing)
        if not moved:
            return surface, surface
        if is_diced(thing):
            surface = surface.become(_diced(surface))
            moved = self._moving(surface, thing)
        return surface, surface.become(displaced(surface, matrix, moved, self._report))

    def _moving(self, surface, thing):
        """Which triangles of a Surface materials move, bool (m,), by material."""
        found = {}
        for slot, which in self._borne(surface, thing):
            if self._relief(slot.material)[0] and which.any():
                found[slot.material] = found.get(slot.material, False) | which
        return found

    def _bent(self, before, surface, thing, matrix):
        """A Surface with the normals that materials give it; before: the same before it was moved."""
        mesh, parts, looks = surface.mesh, [], []
        whole = np.ones(len(mesh.corners), bool)
        for slot, which in self._borne(surface, thing):
            found = self._relief(slot.material)[1]
            triangles = np.flatnonzero(which & whole)
            if found is None or not len(triangles):
                continue
            whole[triangles] = False
            ground = Ground(before if found.is_moved else surface, matrix)
            normals = normals_of(ground, triangles, slot.material, found, self._report, self._poll)
            off = normals.off() if found.is_seen_in else 0.0
            if off > _TOLD:
                instead = f"{len(normals.pieces.kind):,} pieces, whose normals are {np.degrees(off):.1f}° off on average"
                self._report.add(f'Material "{slot.material.name}"', "bump or normal map that varies finely", instead, off > _BLURRED)
            parts.append(normals.pieces)
            looks.append((triangles, normals))
        if not parts:
            return surface
        rest, none = np.flatnonzero(whole), np.zeros(int(whole.sum()), np.int64)
        pieces = Pieces.together([*parts, Pieces(rest, none, none, none)])
        pieces.kind[:] = mesh.slots[pieces.triangle]

        def at(triangles, shares):
            found = surface.normals(triangles, shares)
            for of, normals in looks:
                here = np.isin(triangles, of)
                if here.any():
                    found[here] = normals(triangles[here], shares[here])
            return found

        return surface.become(mesh_of(mesh, pieces, at)[0])

    def _borne(self, surface, thing):
        """Material slots of an evaluated object, and which triangles of a Surface bear them, bool (m,)."""
        slots = list(thing.material_slots)
        of_triangles = np.minimum(surface.mesh.slots, len(slots) - 1)
        return [(slot, of_triangles == k) for k, slot in enumerate(slots)]


def _diced(surface):
    """The Triangles of a Surface cut about evenly into many."""
    areas = surface.areas(np.arange(len(surface.mesh.corners)))
    cuts, parts = depths(areas, _MOST), []
    for depth in np.unique(cuts):
        of = np.flatnonzero(cuts == depth)
        triangle, number = np.repeat(of, 4**depth), np.tile(np.arange(4**depth), len(of))
        parts.append(Pieces(triangle, np.full(len(triangle), depth), number, surface.mesh.slots[triangle].astype(np.int64)))
    return mesh_of(surface.mesh, Pieces.together(parts))[0]
