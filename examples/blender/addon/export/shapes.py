# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes with the materials that objects give them, each made once."""

from dataclasses import dataclass

import numpy as np

from ..host.scene import MATERIAL
from .flags import note_mesh_flags
from .materials import translate
from .meshes import FARTHEST, Triangles, is_closed, reach, triangles
from .volumes import Fog

#: What the report says of what is beyond meshes.FARTHEST.
TOO_FAR = ("coordinates that are too large or no numbers", "left out")


@dataclass(frozen=True)
class Shape:
    """A mesh with the materials of an object."""

    mesh: Triangles
    #: Material numbers of the triangles, int32 (n,), or one number.
    materials: np.ndarray | int
    #: Number of the mesh in the geometry, whose triangles bear these materials if it is not one for all.
    number: int
    #: What it is filled with, or None.
    fog: Fog | None
    #: Middle and half size of the texture space, float64 (2, 3).
    texture_space: np.ndarray
    #: Whether it does nothing but bound fog; and whether it is of glass and closed.
    is_bound: bool
    is_solid: bool
    #: For each material whose light reaches fog: its number and the corners of its triangles, int32 (n, 3).
    emitting: list


class Shapes:
    """Makes Shapes in a covbeam_rays.Geometry."""

    def __init__(self, geometry, view_layer, report):
        #: materials.Translated, by material number.
        self.materials = []
        self._geometry, self._view_layer, self._report = geometry, view_layer, report
        # By what identifies them in Blender as long as the depsgraph lives:
        self._numbers, self._shapes, self._meshes = {}, {}, {}

    def shape(self, thing):
        """The Shape of an evaluated mesh object, or None if it has nothing to render."""
        key = (thing.original.as_pointer(), thing.data.as_pointer())
        if key not in self._shapes:
            self._shapes[key] = self._make(thing)
        return self._shapes[key]

    def _make(self, thing):
        source = f'Object "{thing.name}"'
        note_mesh_flags(thing, self._view_layer, self._report)
        if _is_smoke(thing):
            self._report.add(source, "smoke domain", "left out", in_fog=True)
            return None
        mesh, made = self._mesh(thing.data, source)
        if mesh is None:
            return None
        slots = [slot.material for slot in thing.material_slots] or [None]
        of_slots = np.array([self._number(material) for material in slots], np.int32)
        # A slot that does not exist is the last one.
        used = np.unique(of_slots[np.minimum(mesh.used, len(slots) - 1)])
        if len(used) == 1:
            # Such a mesh can be shared whatever the material is: instances bear it.
            materials, key = int(used[0]), None
        else:
            materials = of_slots[np.minimum(mesh.slots, len(slots) - 1)]
            key = of_slots.tobytes()
        if key not in made:
            made[key] = self._geometry.add_mesh(mesh.positions, mesh.corners, materials, mesh.normals)
        rows = np.array([self.materials[m].row for m in used], MATERIAL)
        return Shape(
            mesh=mesh,
            is_bound=bool((rows["transparent"] >= 1).all()),
            is_solid=bool((rows["glass_transmission"] > 0).any()) and is_closed(mesh),
            materials=materials,
            number=made[key],
            fog=self._fog(mesh, used, source),
            texture_space=np.array([thing.data.texspace_location, thing.data.texspace_size], np.float64),
            emitting=self._emitting(mesh, materials, used) if thing.visible_volume_scatter else [],
        )

    def _mesh(self, data, source):
        """The Triangles of a bpy.types.Mesh or None, and its numbers in the geometry by what its triangles know."""
        pointer = data.as_pointer()
        if pointer not in self._meshes:
            mesh = triangles(data)
            if mesh is not None and not reach(mesh, np.eye(4)) <= FARTHEST:
                self._report.add(source, *TOO_FAR)
                mesh = None
            self._meshes[pointer] = mesh, {}
        return self._meshes[pointer]

    def _number(self, material):
        """Number of a bpy.types.Material, or of what stands for None."""
        pointer = material.as_pointer() if material is not None else None
        if pointer not in self._numbers:
            self._numbers[pointer] = len(self.materials)
            self.materials.append(translate(material, self._report))
        return self._numbers[pointer]

    def _fog(self, mesh, used, source):
        fogs = [self.materials[m].fog for m in used if self.materials[m].fog is not None]
        if not fogs:
            return None
        if len(fogs) > 1:
            self._report.add(source, "several materials with volumes", "the first of them fills all of it", True)
        if not is_closed(mesh):
            self._report.add(source, "a volume in a mesh that is not closed", "fog is missing or too much in places")
        return fogs[0]

    def _emitting(self, mesh, materials, used):
        shining = [int(m) for m in used if self.materials[m].emission.any()]
        return [(m, mesh.corners if len(used) == 1 else mesh.corners[materials == m]) for m in shining]


def _is_smoke(thing):
    for modifier in thing.modifiers:
        if modifier.type == "FLUID" and modifier.fluid_type == "DOMAIN":
            return modifier.domain_settings.domain_type == "GAS"
    return False
