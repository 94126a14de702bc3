# SPDX-License-Identifier: GPL-3.0-or-later
"""A look before each render whether the files that Add Beams has written are still there: Blender would leave the fog dark, or too bright."""

import bpy

from . import compositor


@bpy.app.handlers.persistent
def _look(scene):
    # Also called for the copy that Add Beams renders, which has no compositing.
    if scene.render.use_compositing:
        for words in compositor.look_for_files(scene):
            print(f"covbeam: {words}")


def register():
    bpy.app.handlers.render_init.append(_look)


def unregister():
    bpy.app.handlers.render_init.remove(_look)
