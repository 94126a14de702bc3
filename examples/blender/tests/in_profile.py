# SPDX-License-Identifier: GPL-3.0-or-later
"""Programs that run in a Blender of their own, with a fresh profile, as the zip's tests need them.

COVBEAM_ZIP names the zip. Blender is the bpy package of the Python that runs this.
"""

import ctypes
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import bpy

ZIP = Path(os.environ["COVBEAM_ZIP"]).resolve()
SCRIPTS = Path(bpy.utils.system_resource("SCRIPTS"))
BLENDER_EXT = SCRIPTS / "addons_core" / "bl_pkg" / "cli" / "blender_ext.py"

MODULE = "bl_ext.user_default.covbeam"

#: What every program below begins with. The engine renders the factory's cube, filled with fog.
BEGIN = f"""
import os, sys, bpy
module = {MODULE!r}
zip_path = {str(ZIP)!r}

def install():
    bpy.ops.extensions.package_install_files(filepath=zip_path, repo="user_default", enable_on_install=True)

def refused():
    # Blender loses the last words of its tool for zips if the tool ends between its last read and its question whether
    # the tool has ended (seen once, on a loaded machine); three tries in a row do not lose them all.
    for attempt in range(3):
        try:
            install()
        except Exception as error:
            print("raised:", type(error).__name__, error)

def enable():
    # What Blender does when it starts; the bpy package does not read preferences.
    import addon_utils
    addon_utils.enable(module, default_set=True)

def extension(name):
    return __import__("importlib").import_module(module + "." + name)

def addons():
    return bpy.context.preferences.addons.keys()

def fog():
    material = bpy.data.objects["Cube"].data.materials[0]
    tree = material.node_tree
    tree.nodes.clear()
    volume, output = tree.nodes.new("ShaderNodeVolumeScatter"), tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(volume.outputs["Volume"], output.inputs["Volume"])

def render(path):
    scene = bpy.context.scene
    scene.render.engine = "COVBEAM"
    scene.render.resolution_x, scene.render.resolution_y = 32, 24
    scene.covbeam.passes, scene.covbeam.photons, scene.covbeam.time_limit = 2, 1000, 0.0
    scene.render.image_settings.file_format = "PNG"
    scene.render.filepath = os.path.abspath(path)
    bpy.ops.render.render(write_still=True)
"""

#: And what it ends with: the bpy package 4.2 crashes when Python ends (see harness.py); what counts is to get here.
END = """
print("alive", flush=True)
sys.stderr.flush()
os._exit(0)
"""

CAP_DAC_OVERRIDE = 1
PR_CAPBSET_DROP = 24


def obey_permissions():
    """Lets a program started by root obey the permissions of files, as everyone else's do."""
    if os.getuid() == 0:
        libc = ctypes.CDLL(None, use_errno=True)
        if libc.prctl(PR_CAPBSET_DROP, CAP_DAC_OVERRIDE, 0, 0, 0) != 0:
            raise OSError(ctypes.get_errno(), "prctl")


class InProfile(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.profile = self.folder / "profile"
        self.profile.mkdir()
        self.installed = self.profile / "extensions" / "user_default" / "covbeam"
        version = "python{}.{}".format(*sys.version_info[:2])
        self.site = self.profile / "extensions" / ".local" / "lib" / version / "site-packages"

    def run_blender(self, program, **options):
        """Runs a program in Blender; returns what it has printed. It must come to its end."""
        environment = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "COVBEAM_LIBRARY")}
        environment["BLENDER_USER_RESOURCES"] = str(self.profile)
        # Blender's folder for this session is not left behind, nor taken away by whoever tidies up the system's.
        environment["TMPDIR"] = str(self.folder)
        ended = subprocess.run(
            [sys.executable, "-c", BEGIN + program + END],
            cwd=self.folder,
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=120,
            **options,
        )
        self.assertEqual(ended.returncode, 0, ended.stdout)
        self.assertIn("alive", ended.stdout)
        return ended.stdout

    def assert_told(self, output, *words):
        """The output has all words, and no traceback."""
        for word in words:
            self.assertIn(word, output)
        self.assertNotIn("Traceback", output)
