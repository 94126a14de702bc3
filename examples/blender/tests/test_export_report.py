# SPDX-License-Identifier: GPL-3.0-or-later
"""What the report says: everything that is not rendered as Cycles renders it, by name, and nothing else."""

import ast
import sys
import unittest
from pathlib import Path

import bpy

sys.path[:0] = [str(Path(__file__).parents[1]), str(Path(__file__).parent)]

import scenes_export as scenes  # noqa: E402
import scenes_unsupported  # noqa: E402

from addon.export.report import Report  # noqa: E402
from addon.export.scene import export  # noqa: E402

#: Words of entries that ask nothing, and why: what they name changes fog's light by no more than its noise, or not at all.
_HARMLESS = {
    "bump seen from behind": "what Cycles makes of the back of a bump is its own; seen from in front it is the same",
    "spot without Soft Falloff": "inside of the lamp's own ball alone",
    "edge tint of metal": "the same at 0 and at 82 degrees; between, by less than a hundredth of what it reflects",
    "stereoscopy": "Add Beams refuses it",
    "limits of Cycles' Light Paths": "the artist has chosen all orders",
    "more {what} than are rendered": "hairs and points that are fewer are wider: the same shadow on average",
    "smoke domain without smoke": "Cycles shows nothing there either",
    "Physical Conductor": "the same at normal and at grazing incidence",
    "microfacets": "lobes of the same width",
    "grid {name} of {what} with more than": "means of cells: the same light in all",
}


def _entry(call):
    """What a call notes for the report, as source text, and whether it is in_fog for sure or by a measure; None: it notes nothing."""
    if not isinstance(call, ast.Call):
        return None
    name = call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")
    of_report = name == "add" and isinstance(call.func, ast.Attribute) and ast.unparse(call.func.value).endswith("report")
    if not (of_report or name == "note"):
        return None
    given = {keyword.arg: keyword.value for keyword in call.keywords}
    words = call.args[1:] if of_report else call.args
    if any(isinstance(word, ast.Starred) for word in words):
        # A tuple of all that an entry needs, which has its own in_fog.
        return ast.unparse(call), True
    in_fog = given.get("in_fog", words[2] if len(words) > 2 else None)
    is_false = in_fog is None or (isinstance(in_fog, ast.Constant) and not in_fog.value)
    return (ast.unparse(words[0]) if words else ast.unparse(call)), not is_false


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

    def test_all_that_is_not_rendered_asks_but_for_what_changes_nothing(self):
        """Every entry that the export may make, by its own words: it is missing in fog, and Add Beams asks, or stands here with a reason."""
        folder, harmless = Path(__file__).parents[1] / "addon" / "export", dict(_HARMLESS)
        found = 0
        for path in sorted(folder.glob("*.py")):
            for call in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                made = _entry(call)
                if made is None:
                    continue
                found += 1
                what, in_fog = made
                if in_fog:
                    continue
                words = next((words for words in harmless if words in what), None)
                self.assertIsNotNone(words, f"{path.name}, line {call.lineno}: {what} is not in_fog, and no reason is known")
                self.assertTrue(_HARMLESS[words])
                harmless[words] = ""
        self.assertEqual([words for words, reason in harmless.items() if reason], [], "no entry has these words")
        self.assertGreater(found, 50)

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
