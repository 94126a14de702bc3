# SPDX-License-Identifier: GPL-3.0-or-later
"""The objects and instances of an evaluated depsgraph -> geometry, fog and lights."""

from dataclasses import dataclass, replace

import numpy as np
from covbeam.session import Geometry

from ..host import ask
from ..host.scene import MATERIAL, OBJECT_RULES, Light, LightKind, Rays
from .facts import found, wanted
from .flags import bounces_of, hidden_from, note_fog_flags, note_left_out, note_light_flags, of_objects
from .lights import light
from .linking import BLOCKERS, RECEIVERS, Linking
from .meshes import FARTHEST, in_world, inset, reach
from .shapes import KINDS, TOO_FAR, Shapes
from .volumes import Filled, Frame


@dataclass(frozen=True)
class Origin:
    """What of Blender's something placed comes from."""

    name: str
    #: As of linking.Linking.
    pointers: tuple
    hidden: Rays
    #: Its light group's name; empty: none.
    group: str
    is_catcher: bool


class Objects:
    """What a depsgraph has in it. Fields as in host.scene.Scene; `geometry` is not built yet. `filled`: volumes.Filled, by volume.

    - shows: whether an evaluated object is there; home: as of scene.home_of.
    """

    def __init__(self, depsgraph, shows, report, poll, home):
        # Motion blur compares what is there at its instants.
        self.geometry = Geometry(has_digest=depsgraph.scene_eval.render.use_motion_blur)
        self.lights, self.filled, self.object_volumes, self.object_closed = [], [], [], []
        self._home, self._report, self._depsgraph, self._view_layer = home, report, depsgraph, depsgraph.view_layer_eval
        # By object: the Origin. By light: the keys of its collections.
        self._origins, self._linked = [], []
        self._receivers, self._blockers = Linking(RECEIVERS), Linking(BLOCKERS)
        self._shapes = Shapes(self.geometry, depsgraph, report, poll)
        # Corners of emitting triangles by number of the material, what it is hidden from, light group, and keys of collections: lists of float32 (n, 3, 3).
        self._emitting = {}
        # Largest coordinate of all that is placed [m], and what only bounds fog: arguments of _bound.
        self._reach, self._bounds = 0.0, []
        for count, instance in enumerate(depsgraph.object_instances):
            if count % 64 == 0:
                ask(poll)
            if instance.show_self and shows(instance.object):
                self._add(instance)
            if instance.show_particles and shows(instance.object):
                self._add_shape(instance, self._shapes.hair(instance))
        for bound in self._bounds:
            self._bound(*bound)
        for (number, hidden, group, *keys), corners in self._emitting.items():
            self._linked.append(keys)
            self.lights.append(
                Light(
                    name=self._shapes.materials[number].name,
                    kind=LightKind.MESH,
                    group=group,
                    radiance=self._shapes.materials[number].emission,
                    triangles=np.concatenate(corners),
                    hidden_from=hidden,
                )
            )
        self._link()

    @property
    def materials(self):
        """MATERIAL, (n,)."""
        return np.array([m.row for m in self._shapes.materials], MATERIAL)

    def heeded(self, volumes):
        """The same host.scene.Volumes, of `filled`, with the rules of what they fill; the world's is in the sets that no collection has."""
        of_volumes = {int(volume): number for number, volume in enumerate(self.object_volumes) if volume >= 0}
        made = [replace(volume, **self._rules_of(number, of_volumes)) for number, volume in enumerate(volumes)]
        for number, volume in enumerate(volumes):
            rules = [self._rules_of(part, of_volumes) for part in volume.parts]
            if any(each != rules[0] for each in rules):
                self._report.add(
                    f'Volume of "{volume.name}"',
                    "overlaps fog that other lamps light, or other rays see",
                    "they light and see both alike",
                    in_fog=True,
                )
            if rules:
                made[number] = replace(volume, **rules[0])
        return made

    def _rules_of(self, volume, of_volumes):
        """Of a volume by its number. of_volumes: numbers of the objects that volumes fill; the world's has none."""
        if volume not in of_volumes:
            return {"light_set": self._world_set}
        hidden, light_set, shadow_set = self.object_rules[of_volumes[volume]].tolist()
        hidden |= Rays.SHADOW if self.filled[volume].fog.is_unshadowed else 0
        return {"hidden_from": Rays(hidden), "light_set": light_set, "shadow_set": shadow_set}

    def _link(self):
        """Makes `object_rules`, and links the lights."""
        self.object_rules = np.zeros(len(self._origins), OBJECT_RULES)
        self.object_rules["hidden_from"] = [of_objects(origin.hidden) for origin in self._origins]
        things = [*(origin.pointers for origin in self._origins), None]
        both = [each.sets(things) for each in (self._receivers, self._blockers)]
        if None in both:
            self._report.add("Light Linking", "more than 64 sets of objects", "lamps light, and are shadowed by, everything", in_fog=True)
            both = [self._receivers.none(things)] * 2
        (lit, unlit), (shadowed, unshadowed) = both
        self.object_rules["light_set"], self.object_rules["shadow_set"] = lit[:-1], shadowed[:-1]
        self._world_set = int(lit[-1])
        self.lights = [
            replace(each, unlit=unlit(receivers), unshadowed=unshadowed(blockers)) for each, (receivers, blockers) in zip(self.lights, self._linked)
        ]

    def _add(self, instance):
        # Object and matrix are Blender's only until the next instance: nothing of them is kept.
        thing = instance.object
        matrix = np.array(instance.matrix_world, np.float64)
        if thing.type in KINDS:
            self._add_shape(instance, self._shapes.shape(instance, matrix))
        elif thing.type == "LIGHT":
            note_light_flags(thing, self._report)
            facts = found(wanted(thing.data.node_tree), instance, self._depsgraph)
            made = light(thing.data, thing.name, self._moved(matrix), self._report, facts)
            if made is not None:
                origin = self._origin(instance)
                self.lights.append(replace(made, hidden_from=origin.hidden, group=origin.group, bounces=bounces_of(thing.data)))
                self._linked.append(self._keys(thing))
        else:
            note_left_out(thing, self._report)

    def _origin(self, instance):
        """The Origin of what an instance places."""
        thing, maker = instance.object, instance.parent if instance.is_instance else None
        # Blender has triangles of curves and the like as instances that they make themselves.
        maker = None if maker is None or maker.original == thing.original else maker
        pointers = thing.original.as_pointer(), maker.original.as_pointer() if maker is not None else None
        is_catcher = thing.is_shadow_catcher or (maker is not None and maker.is_shadow_catcher)
        return Origin(thing.name, pointers, hidden_from(thing, maker, self._view_layer), thing.lightgroup, is_catcher)

    def _add_shape(self, instance, shape):
        """Places a Shape, or None, where an instance is."""
        if shape is not None:
            keys = self._keys(instance.object) if shape.emitting else ()
            self._place(shape, self._moved(np.array(instance.matrix_world, np.float64)), self._origin(instance), keys)

    def _keys(self, thing):
        """Of the collections that an evaluated emitter is linked to."""
        return self._receivers.of(thing), self._blockers.of(thing)

    def _moved(self, matrix):
        """A transform (4, 4) to where the scene is moved."""
        matrix = matrix.copy()
        matrix[:3, 3] -= self._home
        return matrix

    def _place(self, shape, matrix, origin, keys):
        """Places a Shape. keys: of the collections of what shines."""
        if not reach(shape.mesh, matrix) <= FARTHEST:
            self._report.add(f'Object "{origin.name}"', *TOO_FAR)
            return
        self._reach = max(self._reach, reach(shape.mesh, matrix))
        invertible = _invertible(matrix)
        if shape.fog is not None and shape.is_bound and invertible:
            self._bounds.append((shape, matrix, origin, keys))
            return
        number = self._number(origin, shape.is_solid)
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
            self._fill(shape, matrix, origin, world.min(axis=0), world.max(axis=0))
        self._shine(shape, world, origin, keys)

    def _bound(self, shape, matrix, origin, keys):
        """Places an object that does nothing but bound fog, once `_reach` is known: drawn in by a hair."""
        number, world = self._number(origin, False), in_world(shape.mesh, matrix)
        smaller, low, high = inset(matrix, world.min(axis=0), world.max(axis=0), self._reach, number)
        material = shape.materials if isinstance(shape.materials, int) else -1
        self.geometry.add_instance(shape.number, smaller, number, material)
        self._fill(shape, matrix, origin, low, high)
        self._shine(shape, world, origin, keys)

    def _number(self, origin, is_closed):
        """The number of an object of an Origin."""
        self._origins.append(origin)
        self.object_closed.append(is_closed)
        return len(self._origins) - 1

    def _fill(self, shape, matrix, origin, low, high):
        """Fills the last object, of a shape between two corners [m], with its fog."""
        note_fog_flags(origin.name, origin.hidden, origin.is_catcher, self._report)
        self.object_volumes.append(len(self.filled))
        frame = Frame(matrix, *shape.texture_space, self._home, shape.grids)
        self.filled.append(Filled(origin.name, shape.fog, np.float64(low), np.float64(high), frame))

    def _shine(self, shape, world, origin, keys):
        """Notes the triangles of a shape that shine. world: its vertices [m]; keys: of its collections."""
        for material, corners in shape.emitting:
            self._emitting.setdefault((material, origin.hidden, origin.group, *keys), []).append(world[corners])


def _invertible(matrix):
    """Whether a transform does not flatten, seen as covbeam does: its columns, made unit, span a volume."""
    lengths = np.linalg.norm(matrix[:3, :3], axis=0)
    return bool(np.all(lengths > 0)) and abs(np.linalg.det(matrix[:3, :3] / lengths)) > 1e-6
