"""covbeam_rays: renders the light that fog scatters, on native threads.

- Geometry: meshes and their instances.
- Scene: a geometry with materials, media, lights and a camera.
- Session: passes and pictures of a scene.

Results are the same, to the bit, for any number of threads. Whatever numbers arguments have, those that are wrong raise ValueError or
TypeError with the name of the field and what to do, and change nothing. A long call asks its `poll` at least every 50 ms whether to go on,
and raises Cancelled if not. What the order of calls refuses raises Error; a picture that memory cannot hold raises MemoryError.
"""

from ._geometry import HIT, Geometry
from ._library import Cancelled, Error
from ._library import version as __version__
from ._scene import MATERIAL, Scene
from ._session import Picture, Session

__all__ = ["HIT", "MATERIAL", "Cancelled", "Error", "Geometry", "Picture", "Scene", "Session", "__version__"]
