# SPDX-License-Identifier: GPL-3.0-or-later
"""Eye paths: from the camera through specular surfaces to the first that is not, all of a pass side by side."""

from dataclasses import dataclass

import numpy as np
from covbeam import EYE_RAY

from . import ask
from .columns import Columns
from .interior import cleared
from .sampler import Sampler, lens_offsets, mix
from .surfaces import SPECULAR, Lobe, follow, leave, meet, weights
from .vectors import normalized

#: Paths split at a surface this many times in a row, then one of its lobes is drawn.
_SPLITS = 4

#: Paths lighter than this play roulette; a path that meets more surfaces than this ends.
_LIGHT_PATH, _SURFACES = np.float32(0.02), 64

#: Sequences of random numbers, apart from those of light paths.
EYE_SEQUENCE = 0xE7E


@dataclass
class Segments:
    """Straight pieces of eye paths inside media; arrays side by side."""

    ray: np.ndarray
    #: 2 x volume + 1 inside glass.
    region: np.ndarray
    #: What the camera sees of radiance that arrives at a piece's start, per channel.
    throughput: np.ndarray
    #: Index of the eye ray it belongs to.
    eye: np.ndarray
    #: Equal for paths that have met the same surfaces in the same way; 0 before the first that is more than a bound
    #: of fog.
    signature: np.ndarray


@dataclass
class _Paths:
    origin: np.ndarray
    direction: np.ndarray
    throughput: np.ndarray
    inside: np.ndarray
    glass: np.ndarray
    eye: np.ndarray
    depth: np.ndarray
    signature: np.ndarray

    def take(self, chosen):
        return _Paths(*(getattr(self, name)[chosen] for name in self.__dataclass_fields__))


class EyeTracer:
    """Follows eye paths of a scene."""

    def __init__(self, scene, interiors, seed):
        self._scene, self._interiors, self._seed = scene, interiors, seed
        camera = scene.camera
        self._start = interiors.at(camera.position)
        self._extinction, self._columns = scene.extinctions, Columns(scene)
        materials = scene.materials
        self._bounds = scene.bounds
        names = ("transparent", "metal", "edge", "glass_reflection", "glass_transmission", "coat")
        #: Whether anything can be seen through or in a material.
        self.shows = np.any([materials[name].any(axis=1) for name in names], axis=0)

    def trace(self, directions, pixels, first, beyond, pass_, poll):
        """The pieces in media of the paths of eye rays.

        - directions: of a pinhole's, float32 (n, 3); pixels: uint32 (n,), which with the pass make their random numbers.
        - first, beyond: bool (n,): whether the fog before the first surface is wanted, and what lies beyond it.
        """
        count = len(directions)
        camera, offsets = self._scene.camera, None
        if camera.aperture is not None:
            places = lens_offsets(self._seed, pass_, pixels)
            offsets, directions = camera.through_lens(directions, places[:, 0], places[:, 1])
        origin, _, inside, glass = self._starts(directions, offsets)
        paths = _Paths(
            origin,
            directions,
            np.ones((count, 3), np.float32),
            inside,
            glass,
            np.arange(count),
            np.zeros(count, np.int32),
            np.zeros(count, np.uint64),
        )
        pieces = []
        for surfaces in range(_SURFACES):
            if len(paths.eye) == 0:
                break
            ask(poll)
            paths = self._step(paths, pixels, first, beyond, pass_, surfaces, pieces, poll)
        if not pieces:
            empty = np.zeros(0, np.int64)
            return Segments(np.zeros(0, EYE_RAY), empty, np.zeros((0, 3), np.float32), empty, np.zeros(0, np.uint64))
        return Segments(*(np.concatenate(arrays) for arrays in zip(*pieces)))

    def _starts(self, directions, offsets=None):
        """Where eye rays begin, how far that is from the camera, and what they are inside of there.

        - offsets: float32 (n, 3), of places in the lens from the camera's position; None: a pinhole's.
        """
        camera, count = self._scene.camera, len(directions)
        position, start = cleared(camera.position).astype(np.float32), camera.starts(directions)
        if offsets is not None:
            position = position + offsets
        origin = position + start[:, None] * directions
        inside, glass = (np.full(count, value) for value in self._start)
        if camera.near > 0 or offsets is not None:
            # What is too near to be seen is fog's bound all the same.
            inside, glass = self._interiors.moved(inside, glass, np.broadcast_to(camera.position, (count, 3)), origin)
        return origin, start, inside, glass

    def _step(self, paths, pixels, first, beyond, pass_, surfaces, pieces, poll):
        scene = self._scene
        hit = scene.geometry.cast(paths.origin, paths.direction)
        ask(poll)
        volume = self._interiors.volumes(paths.inside)
        at = np.flatnonzero((volume >= 0) & ((paths.signature != 0) | first[paths.eye]))
        rays = np.zeros(len(at), EYE_RAY)
        rays["origin"], rays["direction"], rays["length"] = paths.origin[at], paths.direction[at], hit["distance"][at]
        region = 2 * volume[at].astype(np.int64) + paths.glass[at]
        pieces.append((rays, region, paths.throughput[at], paths.eye[at], paths.signature[at]))

        # A miss leaves nothing to follow, in fog or not.
        onward = np.isfinite(hit["distance"])
        material = hit["material"]
        # Before its first surface a path that is not wanted beyond it goes on through bounds only.
        bound = self._bounds[material]
        onward &= self.shows[material] & (bound | (paths.signature != 0) | beyond[paths.eye])
        at = np.flatnonzero(onward)
        paths, hit, volume = paths.take(at), hit[at], volume[at]
        if len(at) == 0:
            return paths
        passed = self._columns.at(volume, paths.origin, paths.direction, hit["distance"])
        paths.throughput = paths.throughput * np.exp(-self._extinction[volume] * passed[:, None])
        sequence = EYE_SEQUENCE + (pass_ << 12)
        # Split paths of one eye ray draw different numbers: their signatures differ.
        keys = mix(pixels[paths.eye].astype(np.uint64) ^ paths.signature)
        sampler = Sampler(self._seed, sequence + (surfaces << 44), (keys >> np.uint64(32)).astype(np.uint32))
        facets, choice, roulette = sampler.pair(), sampler.uniform(), sampler.uniform()
        m = meet(paths.direction, hit, scene.materials, facets)
        shares = weights(m)
        # Radiance over the squared index is what refraction keeps.
        shares[Lobe.GLASS_TRANSMISSION] *= (m.eta * m.eta)[:, None]
        shares[[Lobe.DIFFUSE, Lobe.TRANSLUCENT]] = 0
        total = shares.max(axis=2).sum(axis=0)
        draws = paths.depth >= _SPLITS
        bounds = np.cumsum(shares.max(axis=2) / np.maximum(total, np.float32(1e-38)), axis=0)
        drawn = np.minimum((choice >= bounds).sum(axis=0), len(Lobe) - 1)
        branches = []
        for lobe in SPECULAR:
            of = np.flatnonzero((shares[lobe].max(axis=1) > 0) & (~draws | (drawn == lobe)))
            if len(of) == 0:
                continue
            some, next_ = m.take(of), paths.take(of)
            weight = shares[lobe, of]
            probability = np.where(draws[of], weight.max(axis=1) / total[of], 1)
            next_.throughput = next_.throughput * (weight / probability[:, None])
            branches.append(self._branch(next_, some, lobe, roulette[of]))
        names = _Paths.__dataclass_fields__
        if not branches:
            return paths.take(np.zeros(0, np.int64))
        return _Paths(*(np.concatenate([getattr(b, name) for b in branches]) for name in names))

    def _branch(self, paths, m, lobe, roulette):
        """The paths that take a lobe, less those that lose roulette."""
        brightest = paths.throughput.max(axis=1)
        light = np.maximum(brightest / _LIGHT_PATH, np.float32(1e-38))
        paths.throughput /= np.minimum(light, 1)[:, None]
        keep = np.flatnonzero((roulette < light) & (brightest > 0))
        paths, m = paths.take(keep), m.take(keep)
        paths.direction = normalized(follow(m, lobe, None))
        paths.origin, _ = leave(m, paths.direction)
        if lobe in (Lobe.TRANSPARENT, Lobe.GLASS_TRANSMISSION):
            paths.inside = self._interiors.crossed(paths.inside, m.hit["object"], m.front)
        if lobe == Lobe.GLASS_TRANSMISSION:
            paths.glass = self._interiors.glazed(paths.glass, m.hit["object"], m.front)
        bound = self._bounds[m.hit["material"]]
        kind = (m.hit["object"].astype(np.uint64) << np.uint64(3)) ^ np.uint64(lobe)
        met = np.where(bound, paths.signature, mix(paths.signature ^ kind) | np.uint64(1))
        paths.signature = met
        paths.depth = paths.depth + np.where(bound, 0, 1)
        return paths

    def first_surfaces(self, directions, poll):
        """What lies behind pixels: (fog, depth, show).

        - fog: where the first piece of fog starts and ends, and its volume: float32 (n, 2), int32 (n,), -1 for none or
          for more than one piece before the first surface.
        - depth: distance of the first surface that is more than a bound of fog; inf where there is none.
        - show: whether it shows what lies beyond.
        """
        count = len(directions)
        origin, travelled, inside, glass = self._starts(directions)
        depth = np.full(count, np.inf, np.float32)
        stretch, number = np.zeros((count, 2), np.float32), np.full(count, -1, np.int32)
        pieces, show = np.zeros(count, np.int32), np.zeros(count, bool)
        at = np.arange(count)
        for _ in range(_SURFACES):
            if len(at) == 0:
                break
            ask(poll)
            hit = self._scene.geometry.cast(origin[at], directions[at])
            volume = self._interiors.volumes(inside[at])
            fog = volume >= 0
            new = at[fog & (pieces[at] == 0)]
            end = travelled[at] + hit["distance"]
            of = np.isin(at, new)
            stretch[new] = np.stack([travelled[new], end[of]], axis=1)
            number[new] = volume[of]
            pieces[at[fog]] += 1
            hits = np.isfinite(hit["distance"])
            bound = hits & self._bounds[hit["material"]]
            stop = hits & ~bound
            depth[at[stop]] = end[stop]
            show[at[stop]] = self.shows[hit["material"][stop]]
            some, passed = hit[bound], at[bound]
            front = np.einsum("ij,ij->i", directions[passed], some["geometric_normal"]) < 0
            inside[passed] = self._interiors.crossed(inside[passed], some["object"], front)
            side = np.where(front, np.float32(-1), np.float32(1))[:, None]
            origin[passed] = some["position"] + side * some["offset"][:, None] * some["geometric_normal"]
            travelled[passed] = end[bound]
            at = passed
        number[(pieces > 1) | glass] = -1
        return stretch, number, depth, show
