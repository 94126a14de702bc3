# SPDX-License-Identifier: GPL-3.0-or-later
"""What materials ask of their objects, against what Cycles shows of them."""

import sys
import unittest
from pathlib import Path

import bpy
import numpy as np

sys.path[:0] = [str(Path(__file__).parents[1]), str(Path(__file__).parent)]

import scenes_export as scenes  # noqa: E402

#: Type of node, output, and settings.
_ASKED = (
    *(("ObjectInfo", output, {}) for output in ("Location", "Color", "Alpha", "Object Index", "Material Index", "Random")),
    *(
        ("Attribute", output, {"attribute_type": kind, "attribute_name": name})
        for kind in ("OBJECT", "INSTANCER")
        for name in ("number", "whole", "answer", "pair", "of data", "color", "pass_index", "location", "modifiers", "name", "12", "", "none")
        for output in ("Color", "Fac")
    ),
    *(("Attribute", "Alpha", {"attribute_type": "OBJECT", "attribute_name": name}) for name in ("color", "number", "none", "pair")),
    *(
        ("Attribute", "Vector", {"attribute_type": "VIEW_LAYER", "attribute_name": name})
        for name in ("of layer", "of scene", "of world", "frame_current", "none")
    ),
)

#: Names in these that are nobody's, or of no numbers.
_NOBODYS = ("modifiers", "name", "12", "", "none")


def _glowing(kind, output, settings):
    """A function for scenes.material: Emission of what a node gives."""

    def make(tree):
        emission, asking = scenes.node(tree, "Emission"), scenes.node(tree, kind, **settings)
        found = next(s for s in asking.outputs if s.identifier == output)
        tree.links.new(found, emission.inputs["Color"])
        return emission

    return make


class Objects(unittest.TestCase):
    def setUp(self):
        self.scene = scenes.empty()
        self.scene.cycles.max_bounces = 0
        scenes.world()["of world"] = (0.25, 0.5)
        self.scene["of scene"] = 1.5
        self.scene.view_layers[0]["of layer"] = (0.1, 0.2, 0.3)

    def square(self, k, material, name="Square"):
        """A square beside others, with all that can be asked for."""
        thing = scenes.grid(name, 1.0, material)
        thing.location, thing.color, thing.pass_index = (k, 0.004 * k, 0), (0.1 + 0.01 * k, 0.4, 0.7, 0.3), 3 + k
        thing["number"], thing["whole"], thing["answer"], thing["pair"], thing["name"] = 0.3 * (k + 1), 2, True, (0.1, 0.6), "words"
        thing["12"] = "34"
        thing.data["of data"] = (0.2, 0.3, 0.4, 0.5)
        return thing

    def compare(self, count):
        """Radiance of squares at 0, 1, 2 and so on, as exported, is that of Cycles' picture of them, which is returned."""
        camera = self.scene.camera
        camera.data.type, camera.data.ortho_scale = "ORTHO", count
        camera.location = (count - 1) / 2, 0, 5
        # Blender has no pictures of fewer than four rows.
        expected = scenes.cycles(1, count, 5)[2]
        made, report = scenes.exported()
        self.assertEqual(report.entries, [])
        found = np.zeros((count, 3))
        for light in made.lights:
            for x in light.triangles.mean(axis=1)[:, 0]:
                found[round(float(x))] = light.radiance
        # Both are kept in single precision.
        np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-6)
        return expected

    def test_what_nodes_ask_of_an_object_is_what_cycles_answers(self):
        for k, asked in enumerate(_ASKED):
            thing = self.square(k, scenes.material("Asks", _glowing(*asked)), f"Sq\u00fcare {k}")
            thing.data.materials[0].pass_index = 7
        # The first asks where it is, which is at 0.
        dark = [True, *(asked[2].get("attribute_name") in _NOBODYS for asked in _ASKED[1:])]
        self.assertEqual((~self.compare(len(_ASKED)).any(axis=1)).tolist(), dark)

    def test_objects_that_share_a_material_differ_in_what_it_asks_only(self):
        asks = scenes.material("Asks", _glowing("ObjectInfo", "Random", {}))
        plain = scenes.material("Plain", scenes.shader("Emission"))
        for k in range(6):
            self.square(k, asks if k < 3 else plain)
        self.assertEqual(len(np.unique(self.compare(6)[:, 0])), 4)
        made, _ = scenes.exported()
        self.assertEqual(len(made.materials), 4)

    def test_instances_are_asked_each(self):
        kinds = [("ObjectInfo", output, {}) for output in ("Random", "Location", "Color")]
        kinds += [
            ("Attribute", "Color", {"attribute_type": kind, "attribute_name": name})
            for kind in ("OBJECT", "INSTANCER")
            for name in ("mine", "color")
        ]
        place = 0
        for asked in kinds:
            inside, thing = bpy.data.collections.new("Inside"), self.square(0, scenes.material("Asks", _glowing(*asked)))
            bpy.context.scene.collection.objects.unlink(thing)
            thing.location, thing["mine"] = (0, 0, 0), 0.5
            inside.objects.link(thing)
            for _ in range(2):
                maker = scenes.add(None, "Maker", instance_type="COLLECTION", instance_collection=inside, location=(place, 0.1, 0))
                maker.color, maker["mine"] = (0.7, 0.1 * place, 0.2, 1), 0.1 + 0.1 * place
                place += 1
        expected = self.compare(place)
        self.assertNotEqual(*expected[:2, 0])
        self.assertNotEqual(*expected[-2:, 1])


if __name__ == "__main__":
    unittest.main()
