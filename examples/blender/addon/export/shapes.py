# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes with the materials that objects give them, each made once."""

from dataclasses import dataclass, replace

import numpy as np

from ..host.scene import MATERIAL
from .cutting import cut
from .enclosure import wrong
from .facts import PLACED, found, in_world, wanted
from .flags import note_mesh_flags
from .grids import Grids
from .lobes import Lobes
from .materials import Translated, filling, has_surface, patterned, looked_at, translate
from .meshes import FARTHEST, Triangles, box, is_closed, reach, triangles
from .points import balls
from .quarters import Pieces, mesh_of
from .smoke import gas_domain, smoke
from .strands import of_curves, of_particles, tubes
from .surface_places import Surface
from .uneven import Uneven
from .vdb import vdb
from .volumes import Fog

#: Types of objects that have Shapes.
KINDS = {"MESH", "VOLUME", "CURVES", "POINTCLOUD"}

#: The share of rays that may meet faces of fog in a wrong order: they hit edges.
_WRONG = 0.01

#: Pieces that are off by more on average make another picture.
_TOO_COARSE = 0.05

#: What the report says of what is beyond meshes.FARTHEST.
TOO_FAR = ("coordinates that are too large or no numbers", "left out", True)


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
    #: For each material that shines: its number and the corners of its triangles, int32 (n, 3).
    emitting: list
    #: What it holds of its own, or None.
    grids: Grids | None = None


class Shapes:
    """Makes Shapes in a covbeam.session.Geometry."""

    def __init__(self, geometry, depsgraph, report, poll):
        #: materials.Translated, by material number.
        self.materials = []
        self._geometry, self._depsgraph, self._report = geometry, depsgraph, report
        self._poll, self._view_layer = poll, depsgraph.view_layer_eval
        # By what identifies them in Blender as long as the depsgraph lives:
        self._numbers, self._shapes, self._meshes, self._cuts, self._details = {}, {}, {}, {}, {}
        self._wanted, self._facts = {}, {}
        self._uneven = Uneven(report, poll)

    def shape(self, instance, matrix):
        """The Shape of a bpy.types.DepsgraphObjectInstance of an object of a type in KINDS that is placed by a transform (4, 4), or None if it has
        nothing to render."""
        thing = instance.object
        self._tell(instance)
        key = (thing.original.as_pointer(), thing.data.as_pointer(), self._uneven.key(thing, matrix), *self._facts.values())
        if key not in self._shapes:
            self._shapes[key] = self._make(thing, matrix)
        return self._shapes[key]

    def hair(self, instance):
        """The Shape of the hair of the particle systems of an instance's object, or None without any."""
        thing = instance.object
        self._tell(instance)
        key = (thing.original.as_pointer(), "hair", *self._facts.values())
        if key not in self._shapes:
            self._shapes[key] = self._of_strands(thing, of_particles(thing, self._depsgraph))
        return self._shapes[key]

    def _tell(self, instance):
        """Notes, by pointer of materials, what they ask of what they are on, which few do."""
        self._facts = {slot.as_pointer(): self._told(slot, instance) for slot in self._slots(instance.object) if slot is not None}

    def _told(self, material, instance):
        pointer = material.as_pointer()
        if pointer not in self._wanted:
            # Fog is told of places itself: instances of it share what it is.
            self._wanted[pointer] = wanted(material.node_tree) - (set() if has_surface(material) else {PLACED})
        return found(self._wanted[pointer], instance, self._depsgraph, material)

    def _of(self, material):
        """What a material, or None, is told apart by, and what it has been told."""
        pointer = material.as_pointer() if material is not None else None
        return pointer, self._facts.get(pointer, ())

    def _make(self, thing, matrix):
        source = f'Object "{thing.name}"'
        note_mesh_flags(thing, self._report)
        if gas_domain(thing) is not None:
            return self._of_smoke(thing, source)
        if thing.type == "VOLUME":
            return self._of_vdb(thing, source)
        if thing.type == "CURVES":
            return self._of_strands(thing, of_curves(thing.data, self._depsgraph.scene_eval))
        if thing.type == "POINTCLOUD":
            return self._of_many(thing, *balls(thing.data), "points")
        mesh, made = self._mesh(thing.data, source)
        if mesh is None:
            return None
        slots = self._slots(thing)
        key = self._uneven.key(thing, matrix)
        surface = Surface(thing.data, mesh)
        if key is not None:
            surface, made = self._uneven.made(surface, key, thing, matrix)
            mesh = surface.mesh
            if self._is_far(mesh, source):
                return None
        if any(self._detail(slots[min(slot, len(slots) - 1)]) for slot in mesh.used):
            return self._in_pieces(thing, surface, slots, source, key)
        space = np.array([thing.data.texspace_location, thing.data.texspace_size], np.float64)
        return self._plain(thing, mesh, made, slots, source, space)

    def _plain(self, thing, mesh, made, slots, source, space):
        """The Shape of Triangles of an object whose materials are the same all over. made: numbers in the geometry, by what triangles know;
        space: Shape.texture_space."""
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
            is_bound=_lets_all_through(rows),
            is_solid=bool((rows["glass_transmission"] > 0).any()) and is_closed(mesh),
            materials=materials,
            number=made[key],
            fog=self._fog(mesh, [self.materials[m].fog for m in used if self.materials[m].fog is not None], source),
            texture_space=space,
            emitting=self._emitting(mesh, materials, used),
        )

    def _in_pieces(self, thing, surface, slots, source, uneven):
        """The Shape of an object of whose materials one differs from place to place; None if nothing is left of it. uneven: Uneven.key."""
        key = thing.data.as_pointer(), uneven, *(self._of(slot) for slot in slots)
        if key not in self._cuts:
            self._cuts[key] = self._cut(surface, slots, source)
        made, materials, number, fog, is_solid = self._cuts[key]
        if made is None:
            return None
        return Shape(
            mesh=made,
            is_bound=_lets_all_through(np.array([self.materials[m].row for m in made.used], MATERIAL)),
            is_solid=is_solid,
            materials=materials,
            number=number,
            fog=fog,
            texture_space=np.array([thing.data.texspace_location, thing.data.texspace_size], np.float64),
            emitting=self._emitting(made, materials, made.used),
        )

    def _cut(self, surface, slots, source):
        """What _in_pieces needs: the mesh of the pieces, their materials, its number, what fills it, and whether it is of glass and closed."""
        mesh = surface.mesh
        of_triangles, parts = np.minimum(mesh.slots, len(slots) - 1), []
        clear, fogs = [], []
        for slot in np.unique(of_triangles):
            triangles, material = np.flatnonzero(of_triangles == slot), slots[slot]
            detail = self._detail(material)
            if detail is not None:
                fog = filling(material, self._report, self._of(material)[1])
                made = self._cut_material(surface, triangles, material, detail)
                first = len(self.materials)
                clear.append(first)
                self.materials += [Translated(material.name, row, radiance, fog) for row, radiance in zip(made.rows, made.emission)]
                parts.append(replace(made.pieces, kind=first + made.pieces.kind))
            else:
                number, none = self._number(material), np.zeros(len(triangles), np.int64)
                fog = self.materials[number].fog
                parts.append(Pieces(triangles, none, none, number + none))
            fogs.append(fog)
        pieces = Pieces.together(parts)
        fog = self._fog(mesh, [fog for fog in fogs if fog is not None], source)
        numbers = np.unique(pieces.kind)
        rows = np.array([self.materials[m].row for m in numbers], MATERIAL)
        is_solid = bool((rows["glass_transmission"] > 0).any()) and is_closed(mesh)
        if fog is None and not is_solid:
            # What is not there is left out: what light meets then has an edge.
            pieces = pieces[~np.isin(pieces.kind, clear)]
        if not len(pieces.kind):
            return None, None, None, None, False
        made, _ = mesh_of(mesh, pieces)
        number = self._geometry.add_mesh(made.positions, made.corners, made.slots, made.normals)
        return made, made.slots, number, fog, is_solid

    def _cut_material(self, surface, triangles, material, detail):
        """The cutting.Cut of some triangles of a surface_places.Surface, with what it lacks reported."""
        facts = self._of(material)[1]
        look = looked_at(material, self._report, facts)

        def at(triangles, shares):
            places = surface.places(triangles, shares)
            return look(replace(places, world=in_world(places.object, facts)), len(triangles))

        areas, flat = surface.areas(triangles), surface.uv_areas(triangles)
        # Half of the looks by how large triangles are, half by how much of an image is on them.
        wanted = sum(of / max(float(of.sum()), 1e-300) for of in (areas, flat))
        made = cut(triangles, areas, wanted, at, detail, self._poll)
        if made.error > 0.01:
            self._report.add(
                f'Material "{material.name}"',
                "varies finely in what it lets through, or shines",
                f"{len(made.pieces.kind):,} pieces, which are {made.error:.1%} off on average",
                in_fog=made.error > _TOO_COARSE,
            )
        return made

    def _slots(self, thing):
        """The materials of an object's slots, one at least: None is what Cycles shows without one. A view layer may have one for all."""
        override = self._view_layer.material_override
        return [override] if override is not None else [slot.material for slot in thing.material_slots] or [None]

    def _detail(self, material):
        """As of materials.patterned."""
        key = self._of(material)
        if key not in self._details:
            self._details[key] = patterned(material, key[1])
        return self._details[key]

    def _of_strands(self, thing, strands):
        """The Shape of an object's strands.Strands, or None for None."""
        return self._of_many(thing, *tubes(strands), "hairs") if strands is not None and self._view_layer.use_strand else None

    def _of_many(self, thing, mesh, every, what):
        """The Shape of Triangles that stand for many small things, one for each so many, or None."""
        source = f'Object "{thing.name}"'
        if every > 1:
            self._report.add(source, f"more {what} than are rendered", f"one of each {every}, as wide as all of them")
        if mesh is None or self._is_far(mesh, source):
            return None
        slots = self._slots(thing)
        # Volumes fill meshes only.
        return replace(self._plain(thing, mesh, {}, slots, source, np.zeros((2, 3))), fog=None)

    def _of_smoke(self, thing, source):
        """The Shape of a smoke domain, or None if there is nothing to render."""
        grids = smoke(thing, self._depsgraph)
        if grids is None:
            self._report.add(source, "smoke domain without smoke", "empty; bake it, or play it from its first frame")
            return None
        # Without a material Cycles shows nothing.
        fogs = [
            made for made in (filling(slot.material, self._report, self._of(slot.material)[1]) for slot in thing.material_slots) if made is not None
        ]
        space = np.array([thing.data.texspace_location, thing.data.texspace_size], np.float64)
        return self._of_grids(grids, fogs[0], source, space) if fogs else None

    def _of_vdb(self, thing, source):
        """The Shape of a volume object, or None if there is nothing to render."""
        material = thing.material_slots[0].material if thing.material_slots else None
        if material is None:
            if thing.data.filepath or not thing.data.is_evaluated:
                self._report.add(source, "OpenVDB volume without a material", "left out; give it one with a Principled Volume", True)
            return None
        fog = filling(material, self._report, self._of(material)[1])
        grids = vdb(thing.data, fog.names(), source, self._report, self._poll) if fog is not None else None
        # Generated coordinates are those of the object.
        return self._of_grids(grids, fog, source, np.full((2, 3), 0.5)) if grids is not None else None

    def _of_grids(self, grids, fog, source, texture_space):
        """The Shape of an object that holds fog of its own: a box around that."""
        clear = Lobes()
        clear.add(transparent=1.0)
        self.materials.append(Translated(source, clear.row(lambda *_: None), clear.emission, None))
        mesh = box(grids.low, grids.high)
        return Shape(
            mesh=mesh,
            materials=len(self.materials) - 1,
            number=self._geometry.add_mesh(mesh.positions, mesh.corners, len(self.materials) - 1, None),
            fog=fog,
            texture_space=texture_space,
            is_bound=True,
            is_solid=False,
            emitting=[],
            grids=grids,
        )

    def _mesh(self, data, source):
        """The Triangles of a bpy.types.Mesh or None, and its numbers in the geometry by what its triangles know."""
        pointer = data.as_pointer()
        if pointer not in self._meshes:
            mesh = triangles(data)
            self._meshes[pointer] = None if mesh is None or self._is_far(mesh, source) else mesh, {}
        return self._meshes[pointer]

    def _is_far(self, mesh, source):
        """Whether Triangles are left out for their coordinates; this is reported."""
        far = not reach(mesh, np.eye(4)) <= FARTHEST
        if far:
            self._report.add(source, *TOO_FAR)
        return far

    def _number(self, material):
        """Number of a bpy.types.Material, or of what stands for None."""
        key = self._of(material)
        if key not in self._numbers:
            self._numbers[key] = len(self.materials)
            self.materials.append(translate(material, self._report, key[1]))
        return self._numbers[key]

    def _fog(self, mesh, fogs, source):
        if not fogs:
            return None
        if len(fogs) > 1:
            self._report.add(source, "several materials with volumes", "the first of them fills all of it", True)
        if wrong(mesh, self._poll) > _WRONG:
            self._report.add(source, "a volume in a mesh that is open, inside out or goes through itself", "it ends elsewhere than in Cycles", True)
        return fogs[0]

    def _emitting(self, mesh, materials, used):
        shining = [int(m) for m in used if self.materials[m].emission.any()]
        return [(m, mesh.corners if len(used) == 1 else mesh.corners[materials == m]) for m in shining]


def _lets_all_through(rows):
    """Whether surfaces of some MATERIAL do nothing."""
    return bool((np.minimum(rows["transparent"], rows["shadow"]) >= 1).all())
