# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders a scene pass by pass."""

from dataclasses import dataclass, replace
from time import perf_counter

import covbeam
import covbeam_rays
import numpy as np

from . import Cancelled, ask
from .emission import Emitter
from .emitting import Ball
from .extent import grid_layout, lit_ball, scene_ball, typical_radiance
from .eyes import EyeTracer
from .film import Film
from .interior import Interiors
from .photons import PhotonTracer
from .plan import View, wanted
from .sampler import pixel_offset
from .scene import BLACK

#: Sequences of light paths: without a light field, and with one.
_PLAIN, _FIELD = 0, 1

#: Share of the light paths that carry a light field.
_FIELD_SHARE = 0.1

#: The progressive radius falls as pass^(_ALPHA - 1).
_ALPHA = 0.5

#: The automatic radius, as a share of the diagonal of what is lit; and how far spectra may widen it.
_RADIUS_SHARE, _WIDEST = 0.0045, 2.0

#: Bytes of a voxel: its sums, and their means.
_VOXEL = 84

#: Eye rays of a pixel and pass where a lens blurs a border.
_LOOKS = 4

#: Eye rays in one task of a thread; and light and eye paths that are traced side by side.
_TASK, _WAVE = 512, 32768


@dataclass(frozen=True)
class Settings:
    """How to render.

    - seed: the same picture for the same seed.
    - photons: light paths a pass, > 0.
    - grid: voxels along the longest side of the covariance grid, 4 to 256.
    - radius: of the kernels in pass 1 [m]; 0 is automatic.
    - quality: relative bias that kernels and filters of pass 1 may cause, in (0, 1]; it falls with the passes.
    - bounces: largest number of scatterings and reflections of light, None for any.
    - beyond: whether fog behind the first surface is rendered too, through glass and in mirrors.
    - threads: 0 for all cores.
    """

    seed: int = 0
    photons: int = 50_000
    grid: int = 48
    radius: float = 0.0
    quality: float = 0.01
    bounces: int | None = None
    beyond: bool = True
    threads: int = 0


class Session:
    """Renders the passes of one picture. A pass is a function of (scene, settings, its number): the same bits for any number of
    threads. Cancelled anywhere, the passes done stay."""

    def __init__(self, scene, settings, poll=None):
        if scene.geometry.triangle_count == 0:
            # A miss has the index -1, which has to mean something where there is nothing.
            scene = replace(scene, materials=np.array([BLACK]), object_volumes=np.array([-1], np.int32), object_closed=np.array([False]))
        self._scene, self._settings = scene, settings
        covbeam_rays.threads(settings.threads)
        self._gather = covbeam_rays.Gather()
        self._interiors = Interiors(scene)
        self._eyes = EyeTracer(scene, self._interiors, settings.seed)
        lit = lit_ball(scene)
        emitter = Emitter(scene.lights, lit, scene_ball(scene, lit))
        self._photons = PhotonTracer(scene, emitter, self._interiors, settings.seed, settings.bounces)
        self._view = View(scene, self._eyes, poll)
        boxes = {i: grid_layout(scene, i, settings.grid) for i in range(len(scene.volumes))}
        self._grids = {i: covbeam.Grid(box) for i, box in boxes.items()}
        # One beam map for each medium, outside of glass and inside.
        self._maps = {2 * i + g: covbeam.BeamMap(v.medium) for i, v in enumerate(scene.volumes) for g in (0, 1)}
        radius = settings.radius or _RADIUS_SHARE * 2 * lit.radius
        self._schedule = covbeam.Schedule(
            covbeam.KernelShape.EPANECHNIKOV, radius, _ALPHA, _WIDEST * radius, settings.quality
        )
        self._typical = typical_radiance(scene, emitter, lit)
        self._film = Film(scene, self._view, self._typical)
        self._light_paths = settings.photons
        #: Passes whose light fields are in the grids.
        self._deposited = 0
        #: Seconds by part, over all passes; and accepted pairs of eye ray and beam.
        self.times = dict.fromkeys(("photons", "grid", "beams", "plan", "eyes", "gather", "picture"), 0.0)
        self.pairs = 0
        #: Bytes of beams, grids and sums in the latest pass.
        self.memory = 0

    @property
    def passes(self):
        """Passes done so far."""
        return self._film.passes

    def render_pass(self, poll=None):
        """Renders the next pass. poll() is asked at least ten times a second; False raises Cancelled and the pass is lost."""
        try:
            self._render_pass(self.passes + 1, poll)
        except (covbeam.Cancelled, covbeam_rays.Cancelled):
            raise Cancelled from None

    def restart(self, photons):
        """Forgets all passes; those to come have so many light paths, at most those of the settings."""
        self._light_paths = min(photons, self._settings.photons)
        for grid in self._grids.values():
            grid.clear()
        self._deposited = 0
        self._film.close()
        self._film = Film(self._scene, self._view, self._typical)

    @property
    def photons(self):
        """Light paths of a pass."""
        return self._light_paths

    def picture(self, poll=None):
        """The Picture of the passes done, at least one."""
        start = perf_counter()
        try:
            return self._film.picture(self._gather, poll)
        except (covbeam.Cancelled, covbeam_rays.Cancelled):
            raise Cancelled from None
        finally:
            self.times["picture"] += perf_counter() - start

    def close(self):
        """Gives all memory back. Closing twice is harmless."""
        for object in (*self._maps.values(), *self._grids.values(), self._gather, self._film):
            object.close()

    def _render_pass(self, number, poll):
        clock = _Clock(self.times)
        settings, photons = self._settings, self._light_paths
        fields = min(max(round(_FIELD_SHARE * photons), 1), photons)
        kernel = self._schedule.kernel(number)

        records = [self._trace(_FIELD, number, fields, True, poll)]
        records += self._trace_plain(number, photons - fields, poll)
        clock.lap("photons")
        self._deposit(number, records[0], poll)
        clock.lap("grid")
        for region, beam_map in self._maps.items():
            beam_map.clear()
            for record in records:
                for beams in record.beams.get(region, ()):
                    beam_map.add(beams)
            beam_map.commit(kernel.max_radius, poll=poll)
        clock.lap("beams")
        density = self._film.plan(number, kernel.error, photons, self._grids, poll)
        first, beyond = wanted(density, self._view, number, settings.seed)
        beyond &= settings.beyond
        clock.lap("plan")
        pieces = self._look(number, first, beyond, poll)
        clock.lap("eyes")
        seen, sums = self._gather_all(pieces, kernel, poll)
        clock.lap("gather")
        ask(poll)
        self._film.add(first, beyond, seen, sums)
        voxels = sum(int(np.prod(grid.layout.cells)) for grid in self._grids.values())
        self.memory = sum(m.memory for m in self._maps.values()) + _VOXEL * voxels + self._film.memory

    def _trace(self, sequence, number, count, with_fields, poll):
        first = (number - 1) * count
        return self._photons.trace(sequence, first, count, self._light_paths, with_fields, poll)

    def _trace_plain(self, number, count, poll):
        for first in range(0, count, _WAVE):
            some = min(_WAVE, count - first)
            start = (number - 1) * count + first
            yield self._photons.trace(_PLAIN, start, some, self._light_paths, False, poll)

    def _deposit(self, number, record, poll):
        # A pass that was cancelled after its deposits is traced again: they are the same.
        if self._deposited < number:
            for volume, lists in record.segments.items():
                for segments in lists:
                    for piece in np.array_split(segments, max(1, len(segments) // 4096)):
                        self._grids[volume].deposit(self._scene.volumes[volume].medium, piece)
            self._deposited = number
        ask(poll)
        for grid in self._grids.values():
            grid.resolve()

    def _look(self, number, first, beyond, poll):
        """The pieces of the pass' eye paths; `eye` is the pixel of each."""
        chosen = np.flatnonzero(first | beyond)
        camera, seed, blurred = self._scene.camera, self._settings.seed, self._view.blurred
        x, y = pixel_offset(seed, number)
        pieces = []
        # Through a lens of some size a pixel beside a border needs more than one look.
        looks = 1 if camera.aperture is None else _LOOKS
        for look in range(looks):
            some = chosen if look == 0 else chosen[blurred[chosen]]
            for start in range(0, len(some), _WAVE):
                at = some[start : start + _WAVE]
                pixels = self._view.pixels[at]
                directions = camera.directions(pixels[:, 0] + x, pixels[:, 1] + y)
                index = (number - 1) * looks + look + 1
                found = self._eyes.trace(directions, at.astype(np.uint32), first[at], beyond[at], index, poll)
                found.eye = at[found.eye]
                if looks > 1:
                    found.throughput = found.throughput / np.where(blurred[found.eye], looks, 1).astype(np.float32)[:, None]
                pieces.append(found)
        return pieces

    def _gather_all(self, pieces, kernel, poll):
        """Radiance before and beyond the first surface, (2, pixels, 3), and the former's gather sums (pixels, 3)."""
        pixels = len(self._view.pixels)
        seen, sums = np.zeros((2, pixels, 3)), np.zeros((pixels, 3))
        narrow = covbeam.Kernel(kernel.shape, kernel.min_radius, kernel.min_radius, kernel.error)
        for segments in pieces:
            ask(poll)
            order = np.lexsort((self._view.curve[segments.eye], segments.signature, segments.region))
            region, signature = segments.region[order], segments.signature[order]
            rays, eye = segments.ray[order], segments.eye[order]
            throughput = segments.throughput[order]
            # Each group of paths that met the same surfaces in the same medium is cut into tasks.
            change = np.flatnonzero((np.diff(region) != 0) | (np.diff(signature) != 0)) + 1
            groups = [0, *change.tolist(), len(region)]
            for number, beam_map in self._maps.items():
                if beam_map.count == 0:
                    continue
                for is_first in (True, False):
                    # Wide kernels cost more than they are worth to rays that no filter thins out; and no grid knows glass.
                    wide = is_first and number % 2 == 0
                    starts, at = _tasks(groups, region, signature, number, is_first)
                    if len(at) == 0:
                        continue
                    gathered = self._gather.gather(
                        beam_map,
                        kernel if wide else narrow,
                        self._grids[number // 2] if wide else None,
                        rays[at],
                        starts,
                        poll=poll,
                    )
                    ask(poll)
                    self._add(seen[0 if is_first else 1], gathered, eye[at], throughput[at])
                    if is_first:
                        for index, name in enumerate(("weight", "radius", "sigma")):
                            sums[:, index] += np.bincount(eye[at], gathered[name], pixels)
        return seen, sums

    def _add(self, seen, gathered, eye, throughput):
        for channel in range(3):
            light = throughput[:, channel] * gathered["radiance"][:, channel]
            seen[:, channel] += np.bincount(eye, light, len(seen))
        self.pairs += int(gathered["pairs"].sum())


def _tasks(groups, region, signature, number, is_first):
    """Where the tasks of some groups start, (k + 1,), and the rays of these groups, in order."""
    starts, at = [0], []
    for begin, end in zip(groups[:-1], groups[1:]):
        if begin == end or region[begin] != number or (signature[begin] == 0) != is_first:
            continue
        at.append(np.arange(begin, end))
        base = starts[-1]
        starts += [base + size for size in range(_TASK, end - begin, _TASK)] + [base + end - begin]
    return np.array(starts, np.intp), np.concatenate(at) if at else np.zeros(0, np.intp)


class _Clock:
    def __init__(self, times):
        self._times, self._start = times, perf_counter()

    def lap(self, part):
        now = perf_counter()
        self._times[part] += now - self._start
        self._start = now
