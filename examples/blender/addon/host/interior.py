# SPDX-License-Identifier: GPL-3.0-or-later
"""What rays are inside of: volumes and glass."""

import numpy as np

from .vectors import dot

#: Volumes whose insides are told apart.
MOST = 64

#: A ray that looks for what a point is inside of gives up after this many surfaces.
_SURFACES = 512

#: No two of its parts are related to each other or to those of a scene.
_PROBE = np.array([[0.4081073, 0.8672051, 0.2853429]], np.float32)
_PROBE /= np.linalg.norm(_PROBE)

#: What points are moved by to be off a surface that they may lie on: more than the rounding of places on it, in
#: shares of the largest coordinate, and for the origin [m].
_CLEAR, _LEAST_CLEAR = 2.0**-21, 1e-9


def cleared(points):
    """Points (..., 3) moved by a hair, all the same way, off surfaces that pass through them: float64."""
    points = np.asarray(points, np.float64)
    return points + clearance(points)[..., None] * _PROBE[0].astype(np.float64)


def clearance(points):
    """How far that is: (...)."""
    return np.maximum(_CLEAR * np.abs(points).max(axis=-1), _LEAST_CLEAR)


class Interiors:
    """Tells which medium fills the places that rays get to.

    A ray's `inside` is a set of volumes, one bit each (uint64), and its `glass` whether it is inside of glass, in which
    fog goes on. Where volumes overlap, that counts which is their sum; if the scene has none, the smallest of them.
    """

    def __init__(self, scene):
        self._scene = scene
        finite = [i for i, volume in enumerate(scene.volumes) if i != scene.world_volume and not volume.parts]
        if len(finite) > MOST:
            raise ValueError(f"{len(finite)} volumes: at most {MOST} can be rendered; join those that touch each other")
        size = {i: float(np.prod(np.asarray(scene.volumes[i].max) - scene.volumes[i].min)) for i in finite}
        #: Largest first: a smaller one that comes later overrides.
        self._order = sorted(finite, key=lambda i: -size[i])
        bits = np.zeros(len(scene.volumes) + 1, np.uint64)
        for bit, volume in enumerate(finite):
            bits[volume] = np.uint64(1) << np.uint64(bit)
        self._bits = bits
        #: Sets of volumes whose sums there are, and these.
        self._sums = [
            (np.bitwise_or.reduce(bits[list(volume.parts)]), i) for i, volume in enumerate(scene.volumes) if volume.parts
        ]
        #: By object: its volume's bit, or 0.
        self._object_bits = bits[scene.object_volumes]
        self._glass = (scene.materials["glass_transmission"] > 0).any(axis=1)
        self._closed = scene.object_closed
        self._is_uniform = not (bits[scene.object_volumes].any() or self._glass.any())

    def volumes(self, inside):
        """Indices of the media that fill places, -1 for none: int32 (n,)."""
        current = np.full(len(inside), self._scene.world_volume, np.int32)
        for volume in self._order:
            current[(inside & self._bits[volume]) != 0] = volume
        for together, volume in self._sums:
            current[inside == together] = volume
        return current

    def crossed(self, inside, objects, fronts):
        """The sets after surfaces have been crossed. fronts: where a ray came from outside."""
        bits = self._object_bits[objects]
        return np.where(fronts, inside | bits, inside & ~bits)

    def glazed(self, glass, objects, fronts):
        """Whether rays are inside of glass after they crossed its surface: a pane without thickness has no inside."""
        return np.where(self._closed[objects], fronts, glass)

    def at(self, point):
        """(inside, glass) of a point, or what is just beside it if it lies on a surface: uint64, bool.

        The first surface of each volume, and the first of glass, tells by its side.
        """
        geometry, materials = self._scene.geometry, self._scene.materials
        origin = cleared(point).astype(np.float32).reshape(1, 3)
        inside, seen, glass = np.uint64(0), np.uint64(0), None
        for _ in range(_SURFACES):
            hit = geometry.cast(origin, _PROBE)[0]
            if not np.isfinite(hit["distance"]):
                break
            behind = float(hit["geometric_normal"] @ _PROBE[0]) > 0
            bit = self._object_bits[hit["object"]]
            if not seen & bit:
                seen |= bit
                inside |= bit if behind else np.uint64(0)
            if glass is None and self._glass[hit["material"]] and self._closed[hit["object"]]:
                glass = behind
            origin = (hit["position"] + np.copysign(hit["offset"], 1 if behind else -1) * hit["geometric_normal"])[None]
        return inside, bool(glass)

    def moved(self, inside, glass, origins, targets):
        """(inside, glass) at targets, from what they are at origins: along straight lines, through whatever is there.

        - inside: uint64 (n,); glass: bool (n,); origins, targets: (n, 3).
        """
        if self._is_uniform:
            return inside, glass
        inside, glass = inside.copy(), glass.copy()
        at, origins = np.arange(len(inside)), cleared(origins).astype(np.float32)
        targets = np.asarray(targets, np.float32)
        for _ in range(_SURFACES):
            way = targets[at] - origins[at]
            length = np.sqrt(dot(way, way))
            some = length > 0
            at, way, length = at[some], way[some], length[some]
            if len(at) == 0:
                break
            hit = self._scene.geometry.cast(origins[at], way / length[:, None], length)
            met = np.isfinite(hit["distance"])
            at, hit, way = at[met], hit[met], way[met]
            front = dot(way, hit["geometric_normal"]) < 0
            inside[at] = self.crossed(inside[at], hit["object"], front)
            of_glass = self._glass[hit["material"]]
            glass[at[of_glass]] = self.glazed(glass[at[of_glass]], hit["object"][of_glass], front[of_glass])
            side = np.where(front, np.float32(-1), np.float32(1)) * hit["offset"]
            origins[at] = hit["position"] + side[:, None] * hit["geometric_normal"]
        return inside, glass
