# SPDX-License-Identifier: GPL-3.0-or-later
"""The objects and instances of an evaluated depsgraph -> geometry, fog and lights."""

import numpy as np
from covbeam.session import Geometry

from ..host import ask
from ..host.scene import MATERIAL, Light, LightKind
from .flags import note_instancer_flags, note_left_out, note_light_flags
from .lights import light
from .meshes import FARTHEST, in_world, inset, reach
from .shapes import TOO_FAR, Shapes
from .volumes import Filled, Frame


class Objects:
    """What a depsgraph has in it. Fields as in host.scene.Scene; `geometry` is not built yet. `filled`: volumes.Filled, by volume.

    - shows: whether an evaluated object is there.
    """

    def __init__(self, depsgraph, shows, report, poll):
        # Motion blur compares what is there at its instants.
        self.geometry = Geometry(has_digest=depsgraph.scene_eval.render.use_motion_blur)
        self.lights, self.filled, self.object_volumes, self.object_closed = [], [], [], []
        self._report, self._view_layer = report, depsgraph.view_layer_eval
        # Objects that make instances and have been looked at.
        self._instancers = set()
        self._shapes = Shapes(self.geometry, depsgraph, report, poll)
        # Corners of emitting triangles by material number: lists of float32 (n, 3, 3).
        self._emitting = {}
        # Largest coordinate of all that is placed [m], and what only bounds fog: shapes, transforms and names.
        self._reach, self._bounds = 0.0, []
        for count, instance in enumerate(depsgraph.object_instances):
            if count % 64 == 0:
                ask(poll)
            if instance.show_self and shows(instance.object):
                self._add(instance)
        for shape, matrix, name in self._bounds:
            self._bound(shape, matrix, name)
        for number, corners in self._emitting.items():
            self.lights.append(
                Light(
                    name=self._shapes.materials[number].name,
                    kind=LightKind.MESH,
                    radiance=self._shapes.materials[number].emission,
                    triangles=np.concatenate(corners),
                )
            )

    @property
    def materials(self):
        """MATERIAL, (n,)."""
        return np.array([m.row for m in self._shapes.materials], MATERIAL)

    def _add(self, instance):
        # Object and matrix are Blender's only until the next instance: nothing of them is kept.
        thing = instance.object
        matrix = np.array(instance.matrix_world, np.float64)
        maker = instance.parent if instance.is_instance else None
        if maker is not None and maker.as_pointer() not in self._instancers:
            self._instancers.add(maker.as_pointer())
            # Blender has triangles of curves and the like as instances that they make themselves.
            if maker.original != thing.original:
                note_instancer_flags(maker, self._view_layer, self._report)
        if thing.type in ("MESH", "VOLUME"):
            shape = self._shapes.shape(thing)
            if shape is not None:
                self._place(shape, matrix, thing.name)
        elif thing.type == "LIGHT":
            note_light_flags(thing, self._report)
            made = light(thing.data, thing.name, matrix, self._report) if thing.visible_volume_scatter else None
            if made is not None:
                self.lights.append(made)
        else:
            note_left_out(thing, self._report)

    def _place(self, shape, matrix, name):
        if not reach(shape.mesh, matrix) <= FARTHEST:
            self._report.add(f'Object "{name}"', *TOO_FAR)
            return
        self._reach = max(self._reach, reach(shape.mesh, matrix))
        invertible = _invertible(matrix)
        if shape.fog is not None and shape.is_bound and invertible:
            self._bounds.append((shape, matrix, name))
            return
        number = len(self.object_volumes)
        self.object_closed.append(shape.is_solid)
        world = None
        if shape.fog is not None or shape.emitting or not invertible:
            world = in_world(shape.mesh, matrix)
        if invertible:
            material = shape.materials if isinstance(shape.materials, int) else -1
            self.geometry.add_instance(shape.number, matrix, number, material)
        else:
            # What its scale makes flat is still there, but its transform has no inverse: it becomes a mesh of its own.
            flat = self.geometry.add_mesh(world, shape.mesh.corners, shape.materials, None)
            self.geometry.add_instance(flat, np.eye(4), number)
        if shape.fog is None:
            self.object_volumes.append(-1)
        else:
            self.object_volumes.append(len(self.filled))
            self._fill(shape, matrix, name, world.min(axis=0), world.max(axis=0))
        for material, corners in shape.emitting:
            self._emitting.setdefault(material, []).append(world[corners])

    def _bound(self, shape, matrix, name):
        """Places an object that does nothing but bound fog, once `_reach` is known: drawn in by a hair."""
        number, world = len(self.object_volumes), in_world(shape.mesh, matrix)
        smaller, low, high = inset(matrix, world.min(axis=0), world.max(axis=0), self._reach, number)
        material = shape.materials if isinstance(shape.materials, int) else -1
        self.geometry.add_instance(shape.number, smaller, number, material)
        self.object_volumes.append(len(self.filled))
        self.object_closed.append(False)
        self._fill(shape, matrix, name, low, high)
        for material, corners in shape.emitting:
            self._emitting.setdefault(material, []).append(world[corners])

    def _fill(self, shape, matrix, name, low, high):
        """Adds the fog that fills a shape between two corners [m]."""
        frame = Frame(matrix, *shape.texture_space, shape.grids)
        self.filled.append(Filled(name, shape.fog, np.float64(low), np.float64(high), frame))


def _invertible(matrix):
    """Whether a transform does not flatten, seen as covbeam does: its columns, made unit, span a volume."""
    lengths = np.linalg.norm(matrix[:3, :3], axis=0)
    return bool(np.all(lengths > 0)) and abs(np.linalg.det(matrix[:3, :3] / lengths)) > 1e-6
