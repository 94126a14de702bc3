# SPDX-License-Identifier: GPL-3.0-or-later
"""What tests inside Blender, or in the bpy package, have in common. Finds the add-on in the source tree."""

import os
import sys
import tempfile
import unittest
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parents[1]))


def main():
    """Runs the tests of the program that calls this, and ends the process."""
    program = unittest.main(exit=False)
    sys.stdout.flush()
    sys.stderr.flush()
    # The bpy package 4.2 crashes when Python ends after a class with methods was registered, even if it has been
    # unregistered: it frees panels after Python has gone.
    os._exit(not program.result.wasSuccessful())


def folder_of(case):
    """The path of a folder that goes with a test of a unittest.TestCase."""
    folder = tempfile.TemporaryDirectory()
    case.addCleanup(folder.cleanup)
    return Path(folder.name)


def with_addon(case):
    """Lets a test of a unittest.TestCase have the add-on, and returns the path of a folder: both go with it."""
    import addon

    addon.register()
    case.addCleanup(addon.unregister)
    return folder_of(case)


def start_gpu():
    """Lets Blender draw: in background it has no GPU, nor what stands in for one, before something was rendered with it."""
    scene = bpy.data.scenes.new("Start")
    scene.render.engine = "BLENDER_WORKBENCH"
    scene.render.resolution_x = scene.render.resolution_y = 4
    scene.camera = bpy.data.objects.new("Start", bpy.data.cameras.new("Start"))
    scene.collection.objects.link(scene.camera)
    bpy.ops.render.render(scene=scene.name)
    bpy.data.scenes.remove(scene)


def write_exr(image_settings, *, layers=True):
    """32 bits, uncompressed, so that exr.py can read it."""
    if bpy.app.version >= (5, 0, 0):
        image_settings.media_type = "MULTI_LAYER_IMAGE" if layers else "IMAGE"
    image_settings.file_format = "OPEN_EXR_MULTILAYER" if layers else "OPEN_EXR"
    image_settings.color_depth, image_settings.exr_codec = "32", "NONE"
