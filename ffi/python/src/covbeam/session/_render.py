"""Sessions: passes and pictures of a scene."""

import ctypes
from dataclasses import asdict, dataclass
from enum import IntEnum

import numpy as np

from .. import _session_abi as abi
from .._callbacks import Call
from .._handles import Object, Owner, using
from .._library import check, lib
from . import _library  # noqa: F401
from ._packed import number, whole
from ._scene import Scene


class Method(IntEnum):
    """How pictures are made."""

    #: covbeam's: guided light paths, shadow rays for straight light, adaptive kernels, few eye rays and verified filters.
    COVBEAM = 0
    #: Section 5.3 of the thesis alone.
    THESIS = 1
    #: Plain photon beams.
    PLAIN = 2
    #: Light paths connected with the camera: an oracle without bias.
    LIGHT_TRACE = 3
    #: Light scattered once, by shadow rays along eye rays.
    MARCH = 4


class Layer(IntEnum):
    """What of a picture is asked for: colours (h, w, 3), linear Rec. 709 [W/(m^2 sr)], the last three numbers (h, w)."""

    ALL = 0
    #: By what light has met before what sends it to the camera: nothing, mirrors and glass alone, fog or diffuse surfaces; with kinds_apart.
    STRAIGHT = 1
    FOCUSED = 2
    SCATTERED = 3
    #: What fog scatters before the first surface; with first_apart.
    FIRST = 4
    #: Standard error of the luminance of all light; 0 after a single pass.
    ERROR = 5
    #: Mean kernel radius [m] and mean bandwidth of the fluence across the kernel [cycles/m], weighted by light.
    RADIUS = 6
    BANDWIDTH = 7


class End(IntEnum):
    """How `until` has ended: at its goal; without an error that is small enough; without any light."""

    REACHED = 0
    NOT_REACHED = 1
    DARK = 2


@dataclass(frozen=True)
class BounceLimits:
    """Limits of scatterings and reflections by kind, as path tracers have them: they count from the camera, every event on the way but the last
    one before the lamp. 32-bit numbers >= 0.

    - total: of all kinds together.
    - diffuse, glossy: of reflections; transmission: of what is sent on behind a surface, but for what goes straight on.
    - volume: of scatterings by media, the one that sends light to the camera included.
    - free_reflections, free_transmissions: whether sharp ones on the way from a lamp count as glossy or transmission alone, from the second one on,
      so that caustics are there whatever the other limits say.
    """

    total: int
    diffuse: int
    glossy: int
    transmission: int
    volume: int
    free_reflections: bool = False
    free_transmissions: bool = False


#: What the time goes into, in the library's order.
_PARTS = ("photons", "light fields", "grid", "beams", "plan", "gather")


def _whole_limits(limits):
    """The fields of a BounceLimits that the library takes; none of None."""
    return {} if limits is None else {name: whole(f"settings.limits.{name}", value) for name, value in asdict(limits).items()}


class Session(Object):
    """Renders the passes of one picture. A pass is a function of (scene, settings, its number): the same bits for any number of
    threads. Cancelled anywhere, the passes done stay. Closed with the last reference or by close().

    - scene: a Scene.
    - instants: more Scenes, the same one at other instants while a shutter is open, so that there are n of them, a power of two. Passes 2 i - 1
      and 2 i are of one instant, the next two of another far from it; 2 n passes have each of them twice. What moves is blurred.
    - method: a Method; seed: the same picture for the same seed.
    - photons: light paths a pass, up to 2^28; 0: as many as the scene asks for. Guided ones that leave few beams are up to 8 times as many.
    - grid: voxels along the longest side of the grid that keeps how fine the light is, up to 256; 0: the scene's own.
    - radius: of the beams' kernels in the first pass [m]; 0: the scene's own.
    - quality: relative bias that kernels and filters of the first pass may cause, 1e-6 to 1; it falls with the passes.
    - bounces: largest number of scatterings and reflections of light before the one that sends it to the camera, None for any.
    - limits: a BounceLimits beside that, or None.
    - kinds_apart, first_apart: whether the layers that need it are kept; beyond: whether there is anything from the first surface on.
    - every_pixel: whether each pass has an eye ray through every pixel.
    - first_pass: number of the first pass, from 0; merge() adds others.
    - threads: up to 1024; 0 for all cores.
    - poll: as in render_pass; it takes up to a second or two to get ready.
    """

    def __init__(
        self,
        scene,
        *,
        instants=(),
        method=Method.COVBEAM,
        seed=0,
        photons=0,
        grid=0,
        radius=0.0,
        quality=0.01,
        bounces=None,
        limits=None,
        kinds_apart=False,
        first_apart=False,
        beyond=True,
        every_pixel=False,
        first_pass=0,
        threads=0,
        poll=None,
    ):
        settings = abi.SessionSettings(
            struct_size=ctypes.sizeof(abi.SessionSettings),
            method=whole("settings.method", method),
            seed=whole("settings.seed", seed),
            photons=whole("settings.photons", photons),
            grid=whole("settings.grid", grid),
            most_events=0 if bounces is None else whole("settings.bounces", bounces, 0, 2**31 - 1) + 1,
            first_pass=whole("settings.first_pass", first_pass),
            threads=whole("settings.threads", threads),
            kinds_apart=bool(kinds_apart),
            first_apart=bool(first_apart),
            first_alone=not beyond,
            every_pixel=bool(every_pixel),
            radius=number("settings.radius", radius),
            error=number("settings.quality", quality, (1e-6, 1.0)),
            limits=abi.BounceLimits(limited=limits is not None, **_whole_limits(limits)),
        )
        scenes = (scene, *instants)
        for each in scenes:
            if not isinstance(each, Scene):
                raise TypeError(f"a {type(each).__name__} where a Scene is wanted")
        call = Call(poll)
        with using(*scenes) as handles:
            array = (ctypes.c_void_p * len(handles))(*handles)
            step = ctypes.sizeof(ctypes.c_void_p)
            self._owner = Owner(
                lib.covbeam_session_new,
                lib.covbeam_session_free,
                len(handles),
                ctypes.addressof(array),
                step,
                ctypes.addressof(settings),
                call.poll,
                None,
                ended=call.check,
            )
        self._shape, self._last = scene.shape, abi.SessionInfo()

    def render_pass(self, poll=None):
        """Renders the next pass. poll() is asked at least ten times a second; False raises Cancelled and the pass is lost."""
        call = Call(poll)
        with using(self) as [session]:
            call.check(lib.covbeam_session_pass(session, call.poll, None))

    def until(self, *, passes=0, seconds=0.0, error=0.0, poll=None) -> End:
        """Renders until a goal is reached: so many passes in all, so long from now, or a median relative error. What is 0 is none."""
        goal = abi.Goal(ctypes.sizeof(abi.Goal), whole("goal.passes", passes), number("goal.seconds", seconds), number("goal.error", error))
        call, end = Call(poll), ctypes.c_uint32()
        with using(self) as [session]:
            call.check(lib.covbeam_session_until(session, ctypes.addressof(goal), call.poll, None, ctypes.addressof(end)))
        return End(end.value)

    def picture(self, layer=Layer.ALL, poll=None):
        """A Layer of the picture of the passes done, at least one: float32 (h, w, 3), or (h, w)."""
        layer, (height, width) = Layer(layer), self._shape
        out = np.empty((height, width, 3) if layer < Layer.ERROR else (height, width), np.float32)
        call = Call(poll)
        with using(self) as [session]:
            call.check(lib.covbeam_session_picture(session, layer, height * width, out.ctypes.data, 0, call.poll, None))
        return out

    def save(self) -> bytes:
        """The exact sums of the passes done: the same bytes for the same passes, whoever has rendered them."""
        needed = ctypes.c_size_t()
        with using(self) as [session]:
            check(lib.covbeam_session_save(session, None, 0, ctypes.addressof(needed)))
            out = ctypes.create_string_buffer(needed.value)
            check(lib.covbeam_session_save(session, out, needed.value, ctypes.addressof(needed)))
        return out.raw

    def merge(self, sums, poll=None):
        """Adds what save() gave, here or elsewhere, of other passes of the same picture."""
        sums, call = bytes(sums), Call(poll)
        with using(self) as [session]:
            call.check(lib.covbeam_session_merge(session, sums, len(sums), call.poll, None))

    def restart(self, photons, plain=False):
        """Forgets all passes; those to come have so many light paths, at most those of the settings. plain: light paths do not learn first
        where they are needed: there is far more noise, but the first pass takes no longer than others."""
        with using(self) as [session]:
            check(lib.covbeam_session_restart(session, whole("photons", photons), bool(plain)))

    def close(self):
        """Gives all memory back; what was done can still be asked. Closing twice is harmless."""
        self._last = self._info()
        super().close()

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
        info = self._info()
        return dict(zip(_PARTS, info.seconds)) | {"picture": info.picture_seconds}

    @property
    def pairs(self) -> int:
        """Accepted pairs of eye ray and beam, over all passes."""
        return self._info().pairs

    @property
    def memory(self) -> int:
        """Bytes that beams, grid and sums take at most, as expected."""
        return self._info().memory

    def _info(self):
        if self._owner is None:
            return self._last
        info = abi.SessionInfo()
        with using(self) as [session]:
            check(lib.covbeam_session_get_info(session, ctypes.addressof(info)))
        return info
