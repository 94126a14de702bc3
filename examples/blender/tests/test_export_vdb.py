# SPDX-License-Identifier: GPL-3.0-or-later
"""OpenVDB volumes: cells against those written, what they let through against Cycles, and files that are no good."""

import resource
import shutil
import struct
import sys
import tempfile
from pathlib import Path
from unittest import mock

import bpy
import numpy as np

sys.path[:0] = [str(Path(__file__).parents[1]), str(Path(__file__).parent)]

import harness  # noqa: E402
import scenes_export as scenes  # noqa: E402
from scenes_export import node, shader  # noqa: E402
from seen_through import SeenThrough  # noqa: E402
from vdb_files import FILES, FOLDER  # noqa: E402

from addon.export import density, other_blender, vdb  # noqa: E402
from addon.export.report import Report  # noqa: E402
from addon.export.scene import export  # noqa: E402
from addon.host import Cancelled  # noqa: E402

#: Before Blender 5.0 Cycles shows them half a cell farther along each axis.
HALF = 0.5 if bpy.app.version < (5, 0) else 0.0

#: For Vdb.compare: 256 samples in each of 256 pixels, that Cycles lets through or not, have a mean with a deviation of .0017.
FEW = {"pixels": 16, "within": 5e-3}

PRINCIPLED = shader("VolumePrincipled", {"Density": 6.0, "Color": (0.8, 0.5, 0.3)})


def by_name(kind, name):
    """A function for scenes.material: a shader whose density is what a grid has."""

    def make(tree):
        made = node(tree, kind, {"Color": (1, 1, 1)})
        tree.links.new(node(tree, "Attribute", attribute_name=name).outputs["Fac"], made.inputs["Density"])
        return made

    return make


def of_nodes(tree):
    """Absorption by a grid of colours, and scattering by another grid, mixed by the first."""
    absorb, scatter, both = node(tree, "VolumeAbsorption"), node(tree, "VolumeScatter", {"Color": (1, 1, 1)}), node(tree, "MixShader")
    thick = node(tree, "Math", {"Value_001": 8.0}, operation="MULTIPLY")
    tree.links.new(node(tree, "Attribute", attribute_name="density").outputs["Fac"], thick.inputs[0])
    tree.links.new(thick.outputs[0], absorb.inputs["Density"])
    tree.links.new(node(tree, "Attribute", attribute_name="colour").outputs["Color"], absorb.inputs["Color"])
    tree.links.new(node(tree, "VolumeInfo").outputs["Flame"], scatter.inputs["Density"])
    tree.links.new(absorb.outputs[0], both.inputs[1])
    tree.links.new(scatter.outputs[0], both.inputs[2])
    return both


def volume(path, material=PRINCIPLED, **settings):
    """Adds a volume of a file; material: its volume shader, or None; settings: of the data."""
    data = bpy.data.volumes.new("Cloud")
    data.filepath = str(path)
    for name, value in settings.items():
        setattr(data, name, value)
    if material is not None:
        data.materials.append(scenes.material("Fog", volume=material))
    return scenes.add(data, "Cloud")


class Vdb(SeenThrough):
    def setUp(self):
        super().setUp()
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def read(self, path, *names, report=""):
        """The Grids of these names of a file."""
        thing = volume(path, by_name("VolumeScatter", names[0]))
        evaluated = thing.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        said = Report()
        found = vdb.vdb(evaluated, set(names), "Cloud", said, None)
        self.assertRegex(str(said), f"^{report}$")
        bpy.data.objects.remove(thing)
        return found

    def refused(self, path, what, in_fog=True, **settings):
        """Exports a scene with such a file: it is named, and there is nothing in the scene."""
        thing = volume(path, **settings)
        made, report = scenes.exported()
        bpy.data.objects.remove(thing)
        self.assertEqual(made.volumes, [])
        (entry,) = report.entries
        self.assertRegex(str(entry), what)
        self.assertEqual(entry.in_fog, in_fog)
        return str(entry)

    def test_cells_are_those_written(self):
        """Bit by bit, where they were written."""
        for file, grids in FILES.items():
            if file not in ("cloud", "straight"):
                continue
            found = self.read(FOLDER / f"{file}.vdb", *grids)
            for name, (first, values, transform) in grids.items():
                grid = found.find(name)
                np.testing.assert_array_equal(grid.values, values.transpose(2, 1, 0, 3))
                expected = np.linalg.inv(transform)
                expected[:3, 3] -= np.array(first) + HALF
                np.testing.assert_allclose(grid.to_cells, expected, rtol=1e-6, atol=1e-5)

    def test_the_finest_grid_decides_how_fine_voxels_are(self):
        both, coarse = (self.read(FOLDER / "cloud.vdb", *names) for names in (("density", "flame"), ("flame",)))
        np.testing.assert_allclose(both.cells_a_metre(np.eye(4)), 2 * coarse.cells_a_metre(np.eye(4)), rtol=1e-6)
        inside = np.array([both.low + 1e-6, both.high - 1e-6])
        self.assertTrue((both.low <= coarse.low).all() and (both.high >= coarse.high).all(), inside)

    def test_fog_is_as_dense_as_in_cycles(self):
        volume(FOLDER / "straight.vdb")
        self.compare(self.baked(), width=1.6, **FEW, steps=100)

    def test_object_and_grid_are_turned_and_stretched(self):
        """Pixels, through nodes that ask for three grids, of which one is coarser."""
        thing = volume(FOLDER / "cloud.vdb", of_nodes)
        thing.rotation_euler, thing.scale, thing.location = (0.4, -0.3, 0.8), (1.0, 0.7, 1.3), (0.1, 0.3, -0.1)
        bpy.context.view_layer.update()
        self.compare(self.looked_up(), width=2.0, **FEW, steps=60)

    def test_voxels_of_a_turned_volume(self):
        thing = volume(FOLDER / "cloud.vdb", shader("VolumePrincipled", {"Density": 6.0, "Color": (1, 1, 1)}))
        thing.rotation_euler, thing.scale, thing.location = (0.4, -0.3, 0.8), (1.0, 0.7, 1.3), (0.1, 0.3, -0.1)
        off = r'Material "Fog": density that varies finely: .* voxels, which are \d+\.\d% off on average'
        self.compare(self.baked(off), width=2.0, pixels=16, within=6e-3, steps=100)

    def test_generated_coordinates_are_those_of_the_object(self):
        def make(tree):
            made, place, parts, both = (node(tree, kind) for kind in ("VolumePrincipled", "TexCoord", "SeparateXYZ", "Math"))
            both.operation = "MULTIPLY"
            tree.links.new(place.outputs["Generated"], parts.inputs[0])
            tree.links.new(parts.outputs["X"], both.inputs[0])
            both.inputs[1].default_value = 30.0
            tree.links.new(both.outputs[0], made.inputs["Density"])
            return made

        volume(FOLDER / "straight.vdb", make)
        self.compare(self.looked_up(), width=1.6, **FEW, steps=100)

    def test_instances(self):
        kept = bpy.data.collections.new("Kept")
        kept.objects.link(volume(FOLDER / "straight.vdb"))
        scenes.add(None, "Again", instance_type="COLLECTION", instance_collection=kept, location=(5, 0, 0))
        first, second = scenes.exported()[0].volumes
        np.testing.assert_allclose(second.min - first.min, (5, 0, 0), atol=1e-3)
        np.testing.assert_allclose(second.density.values, first.density.values, atol=2e-3)

    def test_more_cells_than_there_may_be_become_their_means(self):
        vdb._read.cache_clear()
        self.addCleanup(vdb._read.cache_clear)
        report = "Cloud: grid density of OpenVDB file straight.vdb with more than 50 cells: means of 2 x 2 x 2 cells"
        with mock.patch.object(density, "MOST", 50):
            found = self.read(FOLDER / "straight.vdb", "density", report=report)
        first, values, transform = FILES["straight"]["density"]
        grid = found.find("density")
        expected = np.zeros((8, 8, 6))
        expected[:, :7] = values[..., 0]
        expected = expected.reshape(4, 2, 4, 2, 3, 2).mean(axis=(1, 3, 5))
        np.testing.assert_allclose(grid.values[..., 0], expected.transpose(2, 1, 0), rtol=1e-6)
        # The middle of the first of them is the corner between eight cells.
        corner = transform @ [*(np.array(first) + 0.5 + HALF), 1]
        np.testing.assert_allclose((grid.to_cells @ corner)[:3], 0, atol=1e-5)

    def test_frames_of_a_sequence(self):
        for frame, file in ((7, "straight"), (8, "cloud"), (9, "straight")):
            shutil.copy(FOLDER / f"{file}.vdb", self.folder / f"fog_{frame:04}.vdb")
        settings = {"is_sequence": True, "frame_start": 11, "frame_duration": 2, "frame_offset": 6}
        volume(self.folder / "fog_0007.vdb", sequence_mode="CLIP", **settings)
        shapes = []
        for frame in (10, 11, 12, 13):
            bpy.context.scene.frame_set(frame)
            made, report = scenes.exported()
            self.assertNotIn("OpenVDB", str(report))
            shapes.append([v.max[0] for v in made.volumes])
        (straight,), (cloud,) = shapes[1:3]
        self.assertEqual((shapes[0], shapes[3]), ([], []))
        self.assertLess(cloud, straight)
        bpy.data.volumes["Cloud"].sequence_mode = "REPEAT"
        bpy.context.scene.frame_set(14)
        self.assertEqual([v.max[0] for v in scenes.exported()[0].volumes], [cloud])

    def test_a_frame_that_is_missing_is_named(self):
        shutil.copy(FOLDER / "straight.vdb", self.folder / "fog_0007.vdb")
        bpy.context.scene.frame_set(2)
        settings = {"is_sequence": True, "frame_start": 1, "frame_duration": 5, "frame_offset": 6}
        self.refused(self.folder / "fog_0007.vdb", r"fog_0008\.vdb not found.*set its path", **settings)

    def test_a_file_is_read_once(self):
        path = self.folder / "fog.vdb"
        shutil.copy(FOLDER / "straight.vdb", path)
        volume(path)
        scenes.exported()
        with mock.patch.object(other_blender, "_run", side_effect=AssertionError):
            self.assertEqual(len(scenes.exported()[0].volumes), 1)
        # Nor is a bad one tried again; a new one is read.
        path.write_bytes(path.read_bytes()[:-15000])
        _, first = scenes.exported()
        self.assertIn("fog.vdb", str(first))
        with mock.patch.object(other_blender, "_run", side_effect=AssertionError):
            self.assertEqual(str(scenes.exported()[1]), str(first))

    def test_files_that_cannot_be_read_are_named(self):
        whole = (FOLDER / "straight.vdb").read_bytes()
        for file, content in (("nothing", b""), ("text", b"fog " * 99), ("header", whole[:60]), ("cut", whole[: len(whole) // 2])):
            with self.subTest(file):
                path = self.folder / f"{file}.vdb"
                path.write_bytes(content)
                self.refused(path, rf"{file}\.vdb.*write the file anew")

    def test_a_file_that_lies_about_its_size_is_named(self):
        """Blender itself takes four gigabytes for it; the other one must not."""
        lying = bytearray((FOLDER / "straight.vdb").read_bytes())
        name = lying.index(b"density")
        lying[name - 4 : name] = struct.pack("<I", 0xF0000000)
        path = self.folder / "lying.vdb"
        path.write_bytes(lying)
        found = vdb._read(str(path), 0, len(lying), ("density",), other_blender.Unseen(None))
        self.assertIsInstance(found, str)
        if sys.platform == "linux":
            self.assertLess(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss, 3 << 20)

    def test_a_file_that_is_not_there_is_named(self):
        self.refused(self.folder / "fog.vdb", r"^Object \"Cloud\": OpenVDB file fog\.vdb \(.*not found\): left out; set its path, or write the file anew$")

    def test_grids_that_are_not_there_are_named(self):
        self.refused(FOLDER / "straight.vdb", "straight.vdb without the grid soot .*it has density, temperature.*", material=by_name("VolumeScatter", "soot"))
        self.refused(FOLDER / "none.vdb", r"none\.vdb without the grid density \(it has nothing\)")
        self.refused(FOLDER / "double.vdb", r"grid density of OpenVDB file double\.vdb \(it is of type DOUBLE\)")
        self.refused(FOLDER / "empty.vdb", r"grid density of OpenVDB file empty\.vdb .*nothing in it")
        self.refused(FOLDER / "empty.vdb", "nothing in it", in_fog=False, is_sequence=True, frame_duration=100)

    def test_what_is_all_around_a_grid_is_named(self):
        volume(FOLDER / "background.vdb")
        made, report = scenes.exported()
        self.assertEqual(len(made.volumes), 1)
        self.assertRegex(str(report), r"grid density of OpenVDB file background\.vdb with a background of 0\.5: it ends")

    def test_a_volume_without_a_material_is_named(self):
        self.refused(FOLDER / "straight.vdb", "OpenVDB volume without a material", material=None)

    def test_fog_that_asks_for_nothing_is_not_seen(self):
        volume(FOLDER / "straight.vdb", shader("VolumeScatter", {"Density": 3.0}))
        made, report = scenes.exported()
        self.assertEqual((made.volumes, str(report)), ([], ""))
        self.see_through()

    def test_a_blender_that_fails_or_hangs_is_stopped(self):
        path = self.folder / "fog.vdb"
        shutil.copy(FOLDER / "straight.vdb", path)
        asked = []

        def poll():
            asked.append(None)
            return len(asked) < 20

        volume(path)
        bpy.context.view_layer.update()
        with mock.patch.object(other_blender, "command", return_value=[sys.executable, "-c", "import time; time.sleep(60)"]):
            self.assertRaises(Cancelled, export, bpy.context.evaluated_depsgraph_get(), poll)
            with mock.patch.object(other_blender, "PATIENCE", 0.3):
                self.assertIn("more than 0.3 s", str(scenes.exported()[1]))

    def test_wrong_answers_are_refused(self):
        liars = ('{"shapes": [[1e9]]}', '{"shapes": [[2, 2]]}', '{"shapes": [[-1, -1]]}', "{}", "no", '{"shapes": [[0]], "grids": {}, "names": []}', '{"shapes": []}')
        for k, answer in enumerate(liars):
            path = self.folder / f"fog{k}.vdb"
            shutil.copy(FOLDER / "straight.vdb", path)
            program = f"import sys, pathlib; f = pathlib.Path(sys.argv[-1]); (f / '0.f32').write_bytes(bytes(4)); (f / 'answer.json').write_text({answer!r})"
            with mock.patch.object(other_blender, "command", return_value=[sys.executable, "-c", program]):
                self.refused(path, "wrong answer")


if __name__ == "__main__":
    harness.main()
