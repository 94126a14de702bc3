"""covbeam.session: covbeam's whole method, for hosts that describe their scenes. Meshes, materials, lights, volumes and a camera go in, pictures
come out.

- Geometry: meshes and their instances.
- Scene: a geometry with materials, media, lights and a camera.
- Session: passes and pictures of a scene.

Results are the same, to the bit, for any number of threads. What is wrong raises Error (also a ValueError), TypeError or ValueError with the name of
the field and what to do, and changes nothing. A long call asks its `poll` at least every 50 ms whether to go on, and raises Cancelled if not; what
poll raises ends the call, Ctrl-C too. covbeam_session.h is the manual of the fields. Experimental until 0.2.
"""

from ._described import Camera, Light, LightKind, Projection, Rays, Volume, Voxels
from ._geometry import HIT, Geometry
from ._render import BounceLimits, End, Layer, Method, Session
from ._scene import MATERIAL, OBJECT_RULES, SHAPE, Scene, ShapeKind

__all__ = [
    "HIT",
    "MATERIAL",
    "OBJECT_RULES",
    "SHAPE",
    "BounceLimits",
    "Camera",
    "End",
    "Geometry",
    "Layer",
    "Light",
    "LightKind",
    "Method",
    "Projection",
    "Rays",
    "Scene",
    "Session",
    "ShapeKind",
    "Volume",
    "Voxels",
]
