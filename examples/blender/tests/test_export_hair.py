# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair and points, which have no triangles in Blender: what covbeam's take of the light, against closed forms and against Cycles' pictures."""

import sys
import unittest
from math import pi, sqrt
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

sys.path[:0] = [str(Path(__file__).parents[1]), str(Path(__file__).parent)]

import harness  # noqa: E402
import scenes_export as scenes  # noqa: E402

from addon.export.points import balls  # noqa: E402
from addon.export.scene import export  # noqa: E402
from addon.export.strands import Strands, tubes  # noqa: E402


class Reader(bpy.types.RenderEngine):
    """Keeps what is exported of a scene as it is rendered, with children and steps of particles for that."""

    bl_idname, bl_label = "COVBEAM_READER", "Reader"
    found = None

    def render(self, depsgraph):
        Reader.found = export(depsgraph)


def rendered():
    """The host.scene.Scene and the Report of the scene as it is rendered."""
    scene = bpy.context.scene
    engine, kind = scene.render.engine, scene.camera.data.type
    scene.render.engine, scene.camera.data.type = Reader.bl_idname, "PERSP"
    bpy.ops.render.render()
    scene.render.engine, scene.camera.data.type = engine, kind
    return Reader.found


def covered(made, camera, size, rays):
    """Shares of size x size pixels of an orthographic camera with something in them, by rays^2 random rays each: (size, size)."""
    count = size * rays
    jitter = np.random.default_rng(1).random((2, count, count))
    y, x = ((np.indices((count, count)) + jitter) / count - 0.5) * camera.data.ortho_scale
    matrix = np.array(camera.matrix_world)
    places = np.stack([x.ravel(), -y.ravel(), np.zeros(count * count)], axis=1) @ matrix[:3, :3].T + matrix[:3, 3]
    ways = np.broadcast_to(np.float32(-matrix[:3, 2]), places.shape)
    hit = made.geometry.cast(places.astype(np.float32), ways)["distance"] < 1e4
    return hit.reshape(size, rays, size, rays).mean(axis=(1, 3))


def area(mesh):
    a, b, c = (mesh.positions[mesh.corners[:, k]].astype(np.float64) for k in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()


def black():
    return scenes.material("Black", scenes.shader("BsdfDiffuse", {"Color": (0, 0, 0, 1)}))


def curves(points, radii=None):
    """A curves object of points (k, n, 3), with radii (k, n)."""
    data = bpy.data.hair_curves.new("Hair")
    data.add_curves([points.shape[1]] * len(points))
    data.position_data.foreach_set("vector", points.astype(np.float32).ravel())
    if radii is not None:
        data.attributes.new("radius", "FLOAT", "POINT").data.foreach_set("value", radii.astype(np.float32).ravel())
    data.materials.append(black())
    return scenes.add(data)


def tangle(count=80, points=5):
    rng = np.random.default_rng(2)
    places = rng.uniform(-0.4, 0.4, (count, 1, 3)) + np.cumsum(rng.normal(size=(count, points, 3)) * 0.12, axis=1)
    return places, 0.02 * rng.random((count, points))


def furry(**settings):
    """A square whose second material is that of its hair."""
    thing = scenes.grid("Skin", 0.8, black())
    thing.data.materials.append(scenes.material("Dark", scenes.shader("BsdfDiffuse", {"Color": (1e-3, 0, 0, 1)})))
    of = thing.modifiers.new("Hair", "PARTICLE_SYSTEM").particle_system.settings
    of.type, of.count, of.hair_length, of.brownian_factor = "HAIR", 60, 0.5, 0.1
    of.root_radius, of.tip_radius, of.radius_scale, of.material = 1.0, 0.4, 0.04, 2
    for name, value in settings.items():
        setattr(of, name, value)
    return thing


class ClosedForms(unittest.TestCase):
    """From all around a convex thing is seen a fourth as large as its surface is (Cauchy)."""

    def test_a_tube_is_as_wide_as_its_circle(self):
        straight = Strands(np.array([(0, 0, 0), (0, 0, 2.0), (1, 1, 0)]), np.array([0.1, 0.1, 1]), np.array([0, 2, 3]), np.arange(2), False)
        made, every = tubes(straight)
        self.assertEqual((every, list(made.used), len(made.corners)), (1, [0], 24))
        self.assertAlmostEqual(area(made), 2 * pi * 0.1 * 2, delta=1e-5)

    def test_a_bent_tube_keeps_its_width(self):
        turn = np.linspace(0, 3, 7)
        helix = np.stack([np.cos(turn), np.sin(turn), 0.3 * turn], axis=1)
        made, _ = tubes(Strands(helix, np.full(7, 0.01), np.array([0, 7]), np.zeros(1, int), False))
        # A spline through seven points of it is shorter by less than 1 %.
        self.assertAlmostEqual(area(made) / (2 * pi * 0.01 * 3 * sqrt(1.09)), 1, delta=0.01)
        axis = np.array([np.cos(1.5), np.sin(1.5), 0.45])
        self.assertLess(np.abs(np.linalg.norm(made.positions - axis, axis=1).min() - 0.01), 2e-3)

    def test_balls_are_as_wide_as_spheres(self):
        for count in (5, 60_000, 900_000):
            scenes.empty()
            cloud = self.cloud(count)
            made, every = balls(cloud)
            self.assertLessEqual(len(made.corners), 4_000_000)
            self.assertEqual(every, 1 if count < 500_000 else 2)
            self.assertAlmostEqual(area(made) / (4 * pi * 0.01**2 * count), 1, delta=1e-4)

    def cloud(self, count):
        """Points of radius 1 cm at the corners of a mesh."""
        mesh = bpy.data.meshes.new("Corners")
        mesh.vertices.add(count)
        thing = scenes.add(mesh)
        tree = bpy.data.node_groups.new("Points", "GeometryNodeTree")
        for way in ("INPUT", "OUTPUT"):
            tree.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
        start, points, end = (tree.nodes.new(kind) for kind in ("NodeGroupInput", "GeometryNodeMeshToPoints", "NodeGroupOutput"))
        points.inputs["Radius"].default_value = 0.01
        tree.links.new(start.outputs[0], points.inputs[0])
        tree.links.new(points.outputs[0], end.inputs[0])
        thing.modifiers.new("Points", "NODES").node_group = tree
        return next(i.object.data for i in bpy.context.evaluated_depsgraph_get().object_instances if i.object.type == "POINTCLOUD")


class AgainstCycles(unittest.TestCase):
    """Black things in front of a white world: what they cover of pictures from three sides."""

    size, width = 48, 1.8

    def setUp(self):
        scenes.empty()

    def compare(self, off, each=None):
        """off: how much what is covered in all may differ; each: the same of pixels on average."""
        scene = bpy.context.scene
        scenes.world(scenes.shader("Background", {"Color": (1, 1, 1, 1)}))
        camera = scene.camera
        camera.data.ortho_scale = self.width
        for way in ((0, 0, 1), (1, 0, 0.3), (0.3, 1, 0.1)):
            camera.data.type = "ORTHO"
            scenes.look(camera, Vector(way).normalized() * 3, (0, 0, 0))
            bpy.context.view_layer.update()
            expected = 1 - scenes.cycles(32, self.size, self.size).mean(axis=2)
            made, report = rendered()
            self.assertEqual(str(report), "")
            found = covered(made, camera, self.size, 6)
            self.assertGreater(expected.mean(), 0.02)
            self.assertAlmostEqual(found.mean() / expected.mean(), 1, delta=off, msg=str(way))
            if each is not None:
                # Both have noise of their own.
                self.assertLess(np.abs(found - expected).mean() / expected.mean(), each, str(way))
        return made

    def test_curves(self):
        curves(*tangle(300))
        self.compare(0.02, 0.15)
        bpy.context.scene.cycles_curves.shape = "THICK"
        self.compare(0.03, 0.15)

    def test_curves_without_radii_scaled(self):
        curves(tangle(400)[0] / 2).scale = (2, 2, 2)
        self.compare(0.02, 0.2)

    @unittest.skipIf(bpy.app.version < (5, 0), "hair has no corners before")
    def test_polygons(self):
        curves(*tangle()).data.set_types(type="POLY")
        self.compare(0.02, 0.15)

    def test_hair_of_particles(self):
        furry()
        made = self.compare(0.02, 0.15)
        # The skin's material and the hair's.
        np.testing.assert_allclose(made.materials["diffuse"][:, 0], [0, 1e-3], rtol=1e-6)

    def test_children(self):
        furry(child_type="SIMPLE", rendered_child_count=6, child_radius=0.15, use_close_tip=True, shape=0.5, radius_scale=0.02)
        self.compare(0.02, 0.2)

    def test_hair_whose_skin_is_not_rendered(self):
        furry(shape=-0.4).show_instancer_for_render = False
        # Ribbons of hairs that stand upright are hardly there from above.
        bpy.context.scene.cycles_curves.shape = "THICK"
        self.compare(0.03, 0.25)

    def test_nothing_of_it_where_the_view_layer_has_none(self):
        furry()
        curves(*tangle())
        bpy.context.view_layer.use_strand = False
        made, report = rendered()
        self.assertEqual((str(report), made.geometry.triangle_count), ("", 2))

    def test_hair_without_points(self):
        scenes.add(bpy.data.hair_curves.new("Bald"))
        scenes.add(bpy.data.pointclouds.new("Nothing"))
        curves(np.zeros((3, 1, 3)))
        curves(np.full((2, 3, 3), np.nan)).name = "Lost"
        made, report = rendered()
        self.assertEqual(made.geometry.triangle_count, 0)
        self.assertEqual(str(report), 'Object "Lost": coordinates that are too large or no numbers: left out')


if __name__ == "__main__":
    bpy.utils.register_class(Reader)
    harness.main()
