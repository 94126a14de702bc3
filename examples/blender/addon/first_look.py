# SPDX-License-Identifier: GPL-3.0-or-later
"""A picture of large pixels, to be seen long before the first pass of a large picture is done. No Blender."""

from contextlib import closing
from dataclasses import fields, replace

import numpy as np

from .host.session import Picture, Session

#: Pictures of fewer pixels than this have none: their first pass is done about as soon.
_LARGE = 200_000

#: The most pixels that it has.
_PIXELS = 35_000

#: Light paths of its pass: enough for the shape of beams, and done in no time.
_PHOTONS = 1000


def pixel_size(width, height):
    """Side of its pixels, in those of a picture of that size: a power of two; 1: it needs no first look."""
    pixel = 1
    while width * height >= _LARGE and width * height > _PIXELS * pixel**2:
        pixel *= 2
    return pixel


def first_look(scene, settings, pixel, poll):
    """A host.session.Picture as large as the scene's, in pixels of `pixel` x `pixel` of these.

    - scene: host.scene.Scene; settings: host.session.Settings; poll: asked whether to go on, raises Cancelled if not.
    """
    camera = scene.camera
    with closing(Session(replace(scene, camera=camera.coarser(pixel)), settings, poll)) as session:
        session.restart(_PHOTONS, plain=True)
        session.render_pass(poll)
        picture = session.picture(poll)
    layers = [part.name for part in fields(picture) if part.name != "groups"]
    return Picture(**{name: _enlarged(getattr(picture, name), pixel, camera) for name in layers})


def _enlarged(values, pixel, camera):
    return np.repeat(np.repeat(values, pixel, axis=0), pixel, axis=1)[: camera.height, : camera.width]
