# SPDX-License-Identifier: GPL-3.0-or-later
"""What the report says: everything that is not rendered as Cycles renders it, by name, and nothing else."""

import sys
import unittest
from pathlib import Path

import bpy

sys.path[:0] = [str(Path(__file__).parents[1]), str(Path(__file__).parent)]

import scenes_export as scenes  # noqa: E402
import scenes_unsupported  # noqa: E402

from addon.export.report import Report  # noqa: E402
from addon.export.scene import export  # noqa: E402


class ReportTest(unittest.TestCase):
    def test_sixty_lamps_with_the_same_fault_are_one_short_line(self):
        scenes.empty()
        for number in range(60):
            data = bpy.data.lights.new(f"Spot {number:02}", "SPOT")
            data.energy, data.use_soft_falloff, data.shadow_soft_size = 100, False, 0.1
            scenes.add(data)
        _, report = scenes.exported()
        (entry,) = report.entries
        self.assertEqual(len(entry.sources), 60)
        self.assertRegex(str(report), r'^Light "Spot[ .0-9]+" and 59 more: spot without Soft Falloff: ')
        few = Report()
        for name in "ABC":
            few.add(name, "what", "instead", in_fog=True)
        self.assertEqual([str(few), few.entries[0].in_fog], ["A, B, C: what: instead", True])

    def test_everything_unsupported_is_named_and_nothing_else(self):
        expected = scenes_unsupported.build()
        _, report = export(bpy.context.evaluated_depsgraph_get())
        found = {(source, entry.what) for entry in report.entries for source in entry.sources}
        missing = {e for e in expected if not any(f[0] == e[0] and f[1].startswith(e[1]) for f in found)}
        surplus = {f for f in found if not any(f[0] == e[0] and f[1].startswith(e[1]) for e in expected)}
        self.assertEqual(sorted(missing), [])
        self.assertEqual(sorted(surplus), [])
        for entry in report.entries:
            self.assertTrue(entry.instead)
            self.assertNotIn("\n", str(entry))

    def test_a_scene_that_is_rendered_as_in_cycles_has_an_empty_report(self):
        scenes.empty()
        data = bpy.data.lights.new("Key", "AREA")
        scenes.add(data)
        scenes.grid(material=scenes.material("Wall", scenes.shader("BsdfPrincipled")))
        scenes.box(material=scenes.material("Glass", scenes.shader("BsdfPrincipled", {"Transmission Weight": 1.0})))
        scenes.box("Fog", (-9, -9, -9), (9, 9, 9), scenes.material("Fog", volume=scenes.shader("VolumePrincipled")))
        _, report = scenes.exported()
        self.assertEqual(str(report), "")

    def test_what_fog_lacks_is_told_from_what_surfaces_lack(self):
        """Of all that is not supported, that which takes light from fog that Cycles has in it."""
        scenes_unsupported.build()
        _, report = export(bpy.context.evaluated_depsgraph_get())
        in_fog = [entry.what for entry in report.entries if entry.in_fog]
        for words in ("light that fog without end sends out", "OpenVDB file", "hair curves", "Cast Shadow is off"):
            self.assertTrue(any(what.startswith(words) for what in in_fog), words)
        for entry in report.entries:
            if any(what in entry.what for what in ("phase function", "subsurface", "bump")):
                self.assertFalse(entry.in_fog, entry)

    def test_what_is_not_known_of_surfaces_and_of_fog_is_missing_in_fog(self):
        """Fog is lit by what surfaces scatter, too."""
        scenes.empty()
        for name, built in (
            ("Wall", {"surface": scenes.shader("BsdfDiffuse")}),
            ("Fog", {"volume": scenes.shader("VolumeScatter")}),
        ):
            material = scenes.material(name, **built)
            tree = material.node_tree
            shader = next(node for node in tree.nodes if "Color" in node.inputs)
            tree.links.new(tree.nodes.new("ShaderNodeAmbientOcclusion").outputs["Color"], shader.inputs["Color"])
            scenes.box(name, material=material)
        _, report = scenes.exported()
        found = {(entry.sources[0], entry.in_fog) for entry in report.entries if "comes from" in entry.what}
        self.assertEqual(found, {('Material "Wall"', True), ('Material "Fog"', True)})

    def test_equal_entries_are_one_line_with_all_sources_in_order(self):
        report = Report()
        for source in ("B", "A", "B"):
            report.add(source, "this", "that")
        report.add("A", "other", "that")
        self.assertEqual(str(report), "B, A: this: that\nA: other: that")
        self.assertEqual(len(report), 2)


if __name__ == "__main__":
    unittest.main()
