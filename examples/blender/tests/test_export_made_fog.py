# SPDX-License-Identifier: GPL-3.0-or-later
"""Fog that modifiers and geometry nodes make, against Cycles, and fog in meshes that do not enclose it."""

import sys
from pathlib import Path
from unittest import mock

import bpy
import numpy as np
from mathutils import Matrix

sys.path[:0] = [str(Path(__file__).parents[1]), str(Path(__file__).parent)]

import harness  # noqa: E402
import scenes_export as scenes  # noqa: E402
from scenes_export import shader  # noqa: E402
from seen_through import SeenThrough  # noqa: E402

from addon.export import vdb  # noqa: E402
from addon.export.enclosure import wrong  # noqa: E402
from addon.export.meshes import triangles  # noqa: E402


def fog(density=1.0):
    return scenes.material("Fog", volume=shader("VolumePrincipled", {"Density": density, "Color": (0.8, 0.5, 0.3)}))


class Made(SeenThrough):
    """Pixels of what modifiers make; voxels of 32 along the longest side at most."""

    def setUp(self):
        super().setUp()
        scenes.march_volumes()

    def cube(self, density=3.0):
        """A box of fog that geometry nodes fill, denser towards one side."""
        thing, tree = scenes.box(), bpy.data.node_groups.new("Fog", "GeometryNodeTree")
        tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
        place, parts, made, material, end = (
            tree.nodes.new(kind)
            for kind in ("GeometryNodeInputPosition", "ShaderNodeSeparateXYZ", "GeometryNodeVolumeCube", "GeometryNodeSetMaterial", "NodeGroupOutput")
        )
        made.inputs["Min"].default_value, made.inputs["Max"].default_value = (0.2, -0.8, -0.5), (1.0, 0.6, 0.5)
        material.inputs["Material"].default_value = fog(density)
        for a, b in (
            (place.outputs[0], parts.inputs[0]),
            (parts.outputs["X"], made.inputs["Density"]),
            (made.outputs[0], material.inputs[0]),
            (material.outputs[0], end.inputs[0]),
        ):
            tree.links.new(a, b)
        thing.modifiers.new("Fog", "NODES").node_group = tree
        bpy.context.view_layer.update()
        return thing

    def test_geometry_nodes(self):
        self.cube().rotation_euler = (0, 0, 0.4)
        bpy.context.view_layer.update()
        self.compare(self.looked_up(), width=2.8, pixels=16, within=5e-3, steps=100)

    def test_a_mesh_that_becomes_a_volume(self):
        source = scenes.box("Source", (-0.7, -0.5, -0.5), (0.6, 0.7, 0.4))
        source.hide_render = True
        data = bpy.data.volumes.new("Cloud")
        data.materials.append(fog())
        made = scenes.add(data).modifiers.new("Made", "MESH_TO_VOLUME")
        made.object, made.density, made.voxel_amount = source, 2.0, 16
        bpy.context.view_layer.update()
        self.compare(self.looked_up(), width=2.0, pixels=16, within=5e-3, steps=100)

    def test_it_is_read_once_as_long_as_it_does_not_change(self):
        thing = self.cube()
        scenes.exported()
        with mock.patch.object(vdb, "answered", side_effect=AssertionError("read again")):
            scenes.exported()
            thing.modifiers[0].node_group.nodes["Volume Cube"].inputs["Min"].default_value = (0.4, -0.8, -0.5)
            bpy.context.view_layer.update()
            with self.assertRaises(AssertionError):
                scenes.exported()


class Enclosures(SeenThrough):
    def shape(self, *meshes):
        """The share of rays that go through joined boxes wrongly; each: two corners, and whether it is inside out."""
        joined = None
        for low, high, inverted in meshes:
            made = scenes.box("Part", low, high).data
            if inverted:
                made.flip_normals()
            joined = triangles(made) if joined is None else self.together(joined, triangles(made))
        return wrong(joined, None)

    def together(self, one, other):
        positions = np.concatenate([one.positions, other.positions])
        corners = np.concatenate([one.corners, other.corners + len(one.positions)])
        return type(one)(positions, corners, np.zeros(len(corners), np.int32), one.used, None, one.extent)

    def test_what_is_enclosed_and_what_is_not(self):
        whole, inner, beside, across = ((-1, -1, -1), (1, 1, 1)), ((-0.5,) * 3, (0.5,) * 3), ((2, -1, -1), (3, 1, 1)), ((0, 0, 0), (2, 2, 2))
        # Rays that meet an edge are about one in a thousand.
        self.assertLess(self.shape((*whole, False)), 0.005)
        self.assertLess(self.shape((*whole, False), (*beside, False)), 0.005)
        # A shell.
        self.assertLess(self.shape((*whole, False), (*inner, True)), 0.005)
        self.assertEqual(self.shape((*whole, True)), 1)
        self.assertGreater(self.shape((*whole, False), (*inner, False)), 0.1)
        self.assertGreater(self.shape((*whole, False), (*across, False)), 0.1)
        self.assertEqual(wrong(triangles(scenes.grid().data), None), 1)
        bpy.ops.mesh.primitive_uv_sphere_add()
        self.assertLess(wrong(triangles(bpy.context.object.data), None), 0.005)

    def test_fog_in_a_mesh_that_is_inside_out_is_not_there_in_cycles(self):
        """Why it is a matter of fog: seen from above, Cycles has none between its faces."""
        thing = scenes.box("Box", material=fog())
        _, report = scenes.exported()
        self.assertEqual(str(report), "")
        there = self.shown(1.0, 4).mean()
        thing.data.flip_normals()
        # Below, Cycles' fog goes on without end.
        scenes.grid("Lid", 4.0, scenes.material("White", shader("Emission", {"Color": (1, 1, 1)}))).matrix_world = Matrix.Translation((0, 0, -0.99))
        bpy.context.view_layer.update()
        self.assertLess(there, 0.5)
        self.assertGreater(self.shown(1.0, 4).mean(), 0.99)
        (entry,) = scenes.exported()[1].entries
        self.assertIn("inside out", entry.what)
        self.assertTrue(entry.in_fog)


if __name__ == "__main__":
    harness.main()
