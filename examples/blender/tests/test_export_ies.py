# SPDX-License-Identifier: GPL-3.0-or-later
"""IES files: what is read of them, and that whatever they hold is read or refused."""

import sys
import unittest
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).parents[1]), str(Path(__file__).parent)]

import bpy  # noqa: E402
import scenes_export as scenes  # noqa: E402

from addon.export.ies import Measured, Unreadable  # noqa: E402

GOOD = "IESNA:LM-63-2002\n[TEST] none\nTILT=NONE\n1 -1 2.0 3 2 1 2 0 0 0\n0.8 1.25 100\n0 90 180\n0 90\n100 50 0\n200, 100, 0\n"

#: Blender's watts of a candela.
WATTS = 4 * np.pi / 177.83


class Ies(unittest.TestCase):
    def at(self, text, vertical, horizontal=0.0):
        return float(Measured(text).at(np.radians([float(vertical)]), np.radians([float(horizontal)]))[0])

    def test_values_are_candela_by_angle_and_quarters_are_mirrored(self):
        for vertical, horizontal, expected in ((0, 0, 200), (0, 90, 400), (90, 0, 100), (90, 180, 100), (90, 270, 200), (90, 90, 200)):
            self.assertAlmostEqual(self.at(GOOD, vertical, horizontal), expected * WATTS, delta=1e-9 * expected)

    def test_both_factors_of_the_ballast_count(self):
        for text in (GOOD.replace("0.8 1.25", "0.8 2.5"), GOOD.replace("0.8 1.25", "1.6 1.25")):
            self.assertAlmostEqual(self.at(text, 0), 2 * self.at(GOOD, 0))

    def test_tilt_that_is_included_is_passed_over(self):
        tilted = GOOD.replace("TILT=NONE", "TILT=INCLUDE\n1\n3\n0 45 90\n1 1 1")
        self.assertEqual(self.at(tilted, 0), self.at(GOOD, 0))

    def test_nothing_shines_where_nothing_was_measured(self):
        half = GOOD.replace("0 90 180", "0 45 90")
        self.assertEqual((self.at(half, 100), self.at(half, 179)), (0, 0))

    @unittest.skipIf(bpy.app.version < (5, 0), "in Cycles of Blender 4.2 it is not alike, as the next test sees")
    def test_all_around_alike_is_one_horizontal_angle(self):
        even = "TILT=NONE\n1 -1 1 2 1 1 2 0 0 0\n1 1 100\n0 180\n0\n10 10\n"
        self.assertAlmostEqual(self.at(even, 77, 123), 10 * WATTS)

    def test_in_all_directions_it_shines_as_in_cycles(self):
        uneven = "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 7 5 1 2 0 0 0\n1 1 100\n0 10 20 90 160 170 180\n0 90 180 270 360\n"
        uneven += "".join(f"900 300 {value} 400 {value} 100 700\n" for value in (900, 300, 600, 100, 900))
        even = "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 3 1 1 2 0 0 0\n1 1 100\n0 90 180\n0\n500 500 500\n"
        for text in (uneven, even):
            self.compare(text)

    def compare(self, text):
        """A lamp on a white surface, in directions on both sides of horizontal angles and near straight down and up."""
        scenes.empty()
        scenes.grid(size=40.0, material=scenes.material("White", scenes.shader("BsdfDiffuse", {"Color": (1, 1, 1)})))
        lamp = bpy.data.lights.new("Lamp", "POINT")
        lamp.energy, lamp.shadow_soft_size = 1.0, 0.0
        tree, file = scenes.tree_of(lamp), bpy.data.texts.new("Lamp")
        file.write(text)
        emission, ies = scenes.node(tree, "Emission"), scenes.node(tree, "TexIES", mode="INTERNAL", ies=file)
        tree.links.new(ies.outputs[0], emission.inputs["Strength"])
        tree.links.new(emission.outputs[0], scenes.node(tree, "OutputLight").inputs["Surface"])
        height = 2.0
        hung = scenes.add(lamp, location=(0, 0, height))
        for turned in (False, True):
            hung.rotation_euler = (np.pi if turned else 0, 0, 0)
            for off, turn in ((1.0, 70.0), (5.0, 40.0), (8.0, 130.0), (15.0, 45.0), (25.0, 170.0), (60.0, 200.0), (60.0, 340.0)):
                with self.subTest(turned=turned, off=off, turn=turn):
                    angle, x, y = np.radians(off), np.sin(np.radians(turn)), np.cos(np.radians(turn))
                    far = height * np.tan(angle)
                    shown = scenes.cycles_at((far * x, far * y, 0), samples=1)[0]
                    horizontal = np.degrees(np.arctan2(x, -y if turned else y)) + 180
                    value = self.at(text, 180 - off if turned else off, horizontal)
                    # Of a white surface: irradiance over pi. A lamp's watts go in all directions.
                    expected = value / (4 * np.pi) * np.cos(angle) ** 3 / height**2 / np.pi
                    self.assertAlmostEqual(expected / shown, 1, delta=2e-3)

    def test_what_is_no_ies_file_is_refused_and_says_why(self):
        for text, why in (
            ("", "no line TILT="),
            (GOOD.replace("TILT", "TITLE"), "no line TILT="),
            (GOOD[:-20], "too few numbers"),
            (GOOD.replace("100 50 0", "100 fifty 0"), "too few numbers, or words"),
            (GOOD.replace("2.0 3 2 1", "2.0 3 2 2"), "not of type C"),
            (GOOD.replace("0 90 180", "0 180 90"), "do not rise"),
            (GOOD.replace("0 90 180", "0 nan 180"), "do not rise"),
            (GOOD.replace("2.0 3 2 1", "2.0 3 99999999999 1"), "horizontal angles"),
            (GOOD.replace("2.0 3 2 1", "2.0 3 1e999 1"), "too few numbers"),
        ):
            with self.subTest(why), self.assertRaisesRegex(Unreadable, why):
                Measured(text)

    def test_any_bytes_are_read_or_refused(self):
        random = np.random.default_rng(0)
        read = 0
        for _ in range(3000):
            text = bytearray(GOOD.encode())
            for _ in range(random.integers(1, 4)):
                text[random.integers(len(text))] = random.choice(list(b"0123456789 .-e\nXn"))
            try:
                found = Measured(text.decode("latin-1")).at(np.linspace(0, np.pi, 9), np.linspace(0, 6, 9))
            except Unreadable:
                continue
            read += 1
            self.assertTrue((np.isfinite(found) & (found >= 0)).all(), text)
        self.assertGreater(read, 300)

    def test_a_lamp_whose_file_is_not_there_is_named(self):
        scenes.empty()
        lamp = bpy.data.lights.new("Lamp", "POINT")
        tree = scenes.tree_of(lamp)
        emission, ies = scenes.node(tree, "Emission"), scenes.node(tree, "TexIES", mode="EXTERNAL", filepath="/nowhere/lamp.ies")
        tree.links.new(ies.outputs[0], emission.inputs["Strength"])
        tree.links.new(emission.outputs[0], scenes.node(tree, "OutputLight").inputs["Surface"])
        scenes.add(lamp)
        _, report = scenes.exported()
        self.assertIn("whose file cannot be read (", str(report))
        self.assertTrue(report.entries[0].in_fog)


if __name__ == "__main__":
    unittest.main()
