# SPDX-License-Identifier: GPL-3.0-or-later
"""What an artist sets, kept with each scene."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

# Blender 5.0 wants to be told that // is understood; those before do not know the word.
_FOLDER_OPTIONS = {"ANIMATABLE", "PATH_SUPPORTS_BLEND_RELATIVE"} if bpy.app.version >= (5, 0, 0) else {"ANIMATABLE"}


class CovbeamSettings(bpy.types.PropertyGroup):
    """Settings of a scene for light in fog."""

    passes: IntProperty(
        name="Passes",
        description=(
            "How many passes are rendered, each with photons of its own. Noise falls with their number, and so does "
            "what is left of the blur"
        ),
        default=1024,
        min=1,
        soft_max=4096,
    )
    time_limit: FloatProperty(
        name="Time Limit",
        description=(
            "Rendering of a frame ends after this time even if passes are left. 0: no limit. With a limit, number and photons "
            "of the passes depend on how fast the computer is, and with them the image"
        ),
        default=30.0,
        min=0.0,
        soft_max=3600.0,
        step=100,
        precision=1,
        unit="TIME_ABSOLUTE",
    )
    photons: IntProperty(
        name="Photons",
        description=(
            "Light paths of each pass, which go where the image needs them. More make a pass slower and less noisy, and need more memory. "
            "0: as many as suit the scene"
        ),
        default=0,
        min=0,
        max=10_000_000,
        soft_max=100_000,
    )
    quality: FloatProperty(
        name="Accepted Blur",
        description=(
            "Relative error of the light's brightness that blur may cause in the first pass; it falls as passes are "
            "added. Lower is sharper and noisier"
        ),
        default=0.01,
        min=0.0001,
        max=0.5,
        soft_max=0.1,
        precision=4,
        step=0.1,
    )
    grid: IntProperty(
        name="Grid Resolution",
        description=(
            "Voxels along the longest side of the light that is seen, which keep how fine the light is at each place. More "
            "tell finer features apart, and need more photons to fill. 0: as many as suit the scene"
        ),
        default=0,
        min=0,
        max=256,
    )
    radius: FloatProperty(
        name="Radius",
        description=(
            "Radius of a photon beam in the first pass where nothing is known about how fine the light is. "
            "0: chosen from the size of the scene"
        ),
        default=0.0,
        min=0.0,
        soft_max=1.0,
        precision=4,
        unit="LENGTH",
    )
    orders: EnumProperty(
        name="Light",
        description="Which light reaches the fog",
        items=[
            (
                "CYCLES",
                "As Cycles",
                "What the Light Paths settings of Cycles let through, and caustics of sharp glass and mirrors, if they are on there",
            ),
            ("ALL", "All Orders", "However often light is scattered and reflected: brighter fog, wherever Cycles counts few bounces"),
        ],
        default="CYCLES",
    )
    bounces: IntProperty(
        name="Max Bounces",
        description="Events after which a light path ends, on surfaces and in fog. 0: no limit",
        default=0,
        min=0,
        soft_max=64,
    )
    beyond: BoolProperty(
        name="Behind Glass and in Mirrors",
        description=(
            "Fog that is seen through glass and in mirrors too. It takes most of the time where there is much of them. "
            "Add Beams never needs it: there it stays Cycles'"
        ),
        default=True,
    )
    seed: IntProperty(
        name="Seed",
        description="Another seed gives another noise. The same seed gives the same image",
        default=0,
        min=0,
    )
    animate_seed: BoolProperty(
        name="Animate Seed",
        description="Another noise in each frame of an animation, instead of one that sticks to the screen",
        default=True,
    )
    folder: StringProperty(
        name="Folder",
        description=(
            "Where Add Beams to Cycles keeps its images, one multilayer EXR a frame. // stands for the folder of the "
            ".blend file"
        ),
        default="//covbeam/",
        subtype="DIR_PATH",
        options=_FOLDER_OPTIONS,
    )

    def seed_of(self, frame):
        """The seed for a frame's number: 31 bits."""
        if not self.animate_seed:
            return self.seed
        # An odd multiplier is a bijection of 32 bits: no two frames in a row share a seed.
        return (self.seed + frame * 0x9E3779B1) & 0x7FFFFFFF


def bounce_limits(scene):
    """The covbeam.session.BounceLimits that are Cycles' for a scene; None without Cycles.

    Cycles would show no caustics in fog with its default of 0 volume bounces, and hardly any with more. They are what beams are for, so that
    light that sharp glass and mirrors send into fog straight from a lamp does not count, unless caustics are switched off.
    """
    from covbeam.session import BounceLimits

    cycles = getattr(scene, "cycles", None)
    if cycles is None:
        return None
    return BounceLimits(
        total=cycles.max_bounces,
        diffuse=cycles.diffuse_bounces,
        glossy=cycles.glossy_bounces,
        transmission=cycles.transmission_bounces,
        volume=cycles.volume_bounces,
        free_reflections=cycles.caustics_reflective,
        free_transmissions=cycles.caustics_refractive,
    )


def session_settings(scene):
    """The host.session.Settings of a scene. Settings can be animated: one that was evaluated for a render has their values."""
    from .host.session import Settings

    chosen = scene.covbeam
    return Settings(
        seed=chosen.seed_of(scene.frame_current),
        photons=chosen.photons,
        grid=chosen.grid,
        # Like Cycles: a unit of Blender is a metre, whatever it is shown as.
        radius=chosen.radius,
        quality=chosen.quality,
        bounces=chosen.bounces or None,
        limits=bounce_limits(scene) if chosen.orders == "CYCLES" else None,
        beyond=chosen.beyond,
        # Blender answers with all processors where the artist has set no number.
        threads=scene.render.threads,
    )


def register():
    bpy.utils.register_class(CovbeamSettings)
    bpy.types.Scene.covbeam = PointerProperty(type=CovbeamSettings, name="Covbeam")


def unregister():
    del bpy.types.Scene.covbeam
    bpy.utils.unregister_class(CovbeamSettings)
