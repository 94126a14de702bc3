"""Sessions: passes and pictures of a scene."""

import ctypes
from dataclasses import dataclass

import numpy as np

from ._arrays import number, whole
from ._library import Handle, check, lib, wait

_PASS, _PICTURE = 0, 1

_u, _d = ctypes.c_uint32, ctypes.c_double


class _Settings(ctypes.Structure):
    _fields_ = [("radius", _d), ("quality", _d), ("seed", _u), ("photons", _u), ("grid", _u), ("bounces", ctypes.c_int32)]
    _fields_ += [("beyond", _u), ("threads", _u)]


#: What the time goes into, in the library's order.
_PARTS = ("photons", "light fields", "grid", "beams", "plan", "gather", "picture")


class _Info(ctypes.Structure):
    _fields_ = [("times", _d * len(_PARTS)), ("pairs", ctypes.c_uint64), ("memory", ctypes.c_uint64)]
    _fields_ += [("passes", _u), ("photons", _u), ("most_photons", _u)]


@dataclass(frozen=True)
class Picture:
    """A picture, rows from the top, linear Rec. 709 in Blender's unit of radiance [W/(m^2 sr)]; float32."""

    #: All light that fog scatters to the camera, through glass and mirrors too: (h, w, 3).
    in_scattered: np.ndarray
    #: The part of it that is scattered before the first surface: (h, w, 3).
    first: np.ndarray
    #: Of that part: mean kernel radius [m] and mean bandwidth of the fluence across the kernel [cycles/m], weighted by light:
    #: (h, w), 0 where nothing was gathered.
    radius: np.ndarray
    bandwidth: np.ndarray
    #: Standard error of the luminance of all light: (h, w). 0 after a single pass.
    error: np.ndarray


class Session:
    """Renders the passes of one picture. A pass is a function of (scene, settings, its number): the same bits for any number of
    threads. Cancelled anywhere, the passes done stay. Closed with the last reference or by close().

    - scene: a Scene.
    - instants: more Scenes, the same one at other instants while a shutter is open, so that there are n of them, a power of two. Passes 2 i - 1
      and 2 i are of one instant, the next two of another far from it; 2 n passes have each of them twice. What moves is blurred.
    - seed: the same picture for the same seed.
    - photons: light paths a pass, up to 2^28; 0: as many as the scene asks for.
    - grid: voxels along the longest side of the grid that keeps how fine the light is, up to 256; 0: the scene's own.
    - radius: of the beams' kernels in the first pass [m]; 0: the scene's own.
    - quality: relative bias that kernels and filters of the first pass may cause, 1e-6 to 1; it falls with the passes.
    - bounces: largest number of scatterings and reflections of light, None for any.
    - beyond: whether fog behind the first surface is rendered too, through glass and in mirrors.
    - threads: up to 1024; 0 for all cores.
    - poll: as in render_pass; it takes a second or two to get ready.
    """

    def __init__(
        self, scene, *, instants=(), seed=0, photons=0, grid=0, radius=0.0, quality=0.01, bounces=None, beyond=True, threads=0, poll=None
    ):
        settings = _Settings(
            radius=number("settings.radius", radius),
            quality=number("settings.quality", quality),
            seed=whole("settings.seed", seed),
            photons=whole("settings.photons", photons),
            grid=whole("settings.grid", grid),
            bounces=-1 if bounces is None else whole("settings.bounces", bounces, 0, 2**31 - 1),
            beyond=bool(beyond),
            threads=whole("settings.threads", threads),
        )
        make, free = lib.covbeam_rays_session_new, lib.covbeam_rays_session_free
        handles = [each._open() for each in (scene, *instants)]
        scenes = (ctypes.c_void_p * len(handles))(*(handle._as_parameter_.value for handle in handles))
        self._handle = Handle(make, free, len(scenes), ctypes.addressof(scenes), ctypes.addressof(settings))
        self._shape, self._last = scene.shape, _Info()
        self._wait(poll)

    def render_pass(self, poll=None):
        """Renders the next pass. poll() is asked at least ten times a second; False raises Cancelled and the pass is lost."""
        check(lib.covbeam_rays_session_start(self._open(), _PASS))
        self._wait(poll)

    def picture(self, poll=None):
        """The Picture of the passes done, at least one."""
        check(lib.covbeam_rays_session_start(self._open(), _PICTURE))
        self._wait(poll)
        height, width = self._shape
        colors = [np.empty((height, width, 3), np.float32) for _ in range(2)]
        values = [np.empty((height, width), np.float32) for _ in range(3)]
        arrays = (array.ctypes.data for array in (*colors, *values))
        check(lib.covbeam_rays_session_picture(self._open(), height * width, *arrays))
        return Picture(*colors, *values)

    def restart(self, photons, plain=False):
        """Forgets all passes; those to come have so many light paths, at most those of the settings. plain: light paths do not learn first
        where they are needed: there is far more noise, but the first pass takes no longer than others."""
        check(lib.covbeam_rays_session_restart(self._open(), whole("photons", photons), bool(plain)))

    def close(self):
        """Stops what goes on and gives all memory back; what was done can still be asked. Closing twice is harmless."""
        self._last = self._info()
        self._handle = None

    @property
    def passes(self) -> int:
        """Passes done so far."""
        return self._info().passes

    @property
    def photons(self) -> int:
        """Light paths of a pass."""
        return self._info().photons

    @property
    def times(self):
        """Seconds by part, over all passes and pictures."""
        return dict(zip(_PARTS, self._info().times))

    @property
    def pairs(self) -> int:
        """Accepted pairs of eye ray and beam, over all passes."""
        return self._info().pairs

    @property
    def memory(self) -> int:
        """Bytes that beams, grid and sums take at most, as expected."""
        return self._info().memory

    def _wait(self, poll):
        handle = self._open()
        try:
            wait(lib.covbeam_rays_session_wait, handle, poll)
        except BaseException:
            lib.covbeam_rays_session_stop(handle)
            raise

    def _info(self):
        if self._handle is None:
            return self._last
        info = _Info()
        check(lib.covbeam_rays_session_info(self._open(), ctypes.addressof(info)))
        return info

    def _open(self):
        if self._handle is None:
            raise ValueError("Session: used after close(); make a new one")
        return self._handle
