# SPDX-License-Identifier: GPL-3.0-or-later
"""Smoke that Blender simulates, in the bpy package too."""

import contextlib
import ctypes
import sys
import tempfile

import bpy
import scenes_export as scenes

#: Words of CPython 3.11's PyTypeObject before its base, its bases and its order of method resolution.
_BASE, _BASES, _MRO = 32, 42, 43


def mend():
    """Gives classes of mantaflow's grids the bases that they have in Blender: in the bpy package they have none, so that nothing is
    simulated. Does nothing where they have them."""
    import manta

    for kind, base in ((manta.LevelsetGrid, manta.RealGrid), (manta.MACGrid, manta.VecGrid), (manta.FlagGrid, manta.IntGrid)):
        if base not in kind.__mro__:
            for word, value in ((_BASE, base), (_BASES, (base,)), (_MRO, (kind, base, object))):
                ctypes.pythonapi.Py_IncRef(ctypes.py_object(value))
                ctypes.c_void_p.from_address(id(kind) + 8 * word).value = id(value)
            ctypes.pythonapi.PyType_Modified(ctypes.py_object(kind))


def domain(resolution=17, frames=6, material=None, **settings):
    """A box of smoke and fire that has been simulated up to a frame; settings: of the domain. Returns its object, evaluated."""
    scene = bpy.context.scene
    box = scenes.box("Domain", material=material)
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.35, location=(0.2, -0.1, -0.4))
    ball = bpy.context.object
    ball.hide_render = True
    flow = ball.modifiers.new("Flow", "FLUID")
    flow.fluid_type = "FLOW"
    flow.flow_settings.flow_type, flow.flow_settings.flow_behavior = "BOTH", "INFLOW"
    flow.flow_settings.smoke_color = (0.9, 0.5, 0.1)
    modifier = box.modifiers.new("Fluid", "FLUID")
    modifier.fluid_type = "DOMAIN"
    made = modifier.domain_settings
    made.domain_type, made.cache_type, made.cache_directory = "GAS", "REPLAY", tempfile.mkdtemp(dir=bpy.app.tempdir)
    # Mantaflow's classes are there as soon as there is a domain; it begins anew with another resolution.
    made.resolution_max = resolution - 1
    if "manta" not in sys.modules:
        scene.frame_set(1)
    mend()
    made.resolution_max = resolution
    for name, value in settings.items():
        setattr(made, name, value)
    # Mantaflow leaves a file of noise in the current folder.
    with contextlib.chdir(bpy.app.tempdir):
        for frame in range(1, frames + 1):
            scene.frame_set(frame)
    return box
