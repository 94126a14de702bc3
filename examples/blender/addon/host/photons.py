# SPDX-License-Identifier: GPL-3.0-or-later
"""Light paths: from a light through media and surfaces until they are absorbed or escape, all of a pass side by side."""

from dataclasses import dataclass, field

import numpy as np
from covbeam import BEAM, CURVATURE, SEGMENT, Medium, light_field, segment

from . import ask
from .columns import Columns
from .sampler import Sampler
from .scene import LightKind
from .surfaces import SMOOTH, Lobe, follow, leave, meet, weights

#: After this many events a path goes on with a probability only, so that every path ends.
_LONG_PATH, _GOING_ON = 64, np.float32(0.95)

#: Light fields of fog that is as dense everywhere travel as in vacuum.
_VACUUM = Medium(0)

#: Light is opaque after this optical depth: e^-17 = 4e-8.
_OPAQUE = 17.0


@dataclass
class Record:
    """What light paths leave: BEAM by region (2 x volume + 1 inside glass), SEGMENT by volume, each in a fixed order."""

    beams: dict = field(default_factory=dict)
    segments: dict = field(default_factory=dict)

    def add(self, kind, number, values):
        """Appends values to the list of one region or volume."""
        if len(values):
            getattr(self, kind).setdefault(int(number), []).append(values)


@dataclass
class _Photons:
    """Photons on their way; arrays side by side."""

    origin: np.ndarray
    direction: np.ndarray
    power: np.ndarray
    #: Of the surface that they left, 0 in the open.
    normal: np.ndarray
    inside: np.ndarray
    glass: np.ndarray
    #: Straight from the light, or through smooth surfaces only.
    unscattered: np.ndarray
    #: How often they have been scattered or reflected; what goes straight on does not count.
    bounces: np.ndarray
    #: How far from here their light begins, and ends [m]: of lamps with a size, as long as they go straight on.
    dark: np.ndarray
    until: np.ndarray
    #: LIGHT_FIELD, or None.
    light: np.ndarray | None

    def take(self, chosen):
        values = {name: getattr(self, name) for name in self.__dataclass_fields__}
        return _Photons(**{name: None if v is None else v[chosen] for name, v in values.items()})


class PhotonTracer:
    """Traces light paths of a scene.

    - emitter: its lights; interiors: its insides.
    - bounces: largest number of times that light is scattered or reflected before it is seen, None for any.
    """

    def __init__(self, scene, emitter, interiors, seed, bounces=None):
        self._scene, self._emitter, self._interiors, self._seed = scene, emitter, interiors, seed
        self._bounces = bounces
        self._places = np.array([self._place(light) for light in scene.lights], np.float64).reshape(-1, 3)
        starts = [interiors.at(place) for place in self._places]
        self._inside = np.array([inside for inside, _ in starts], np.uint64)
        self._glass = np.array([glass for _, glass in starts], bool)
        # What comes from infinitely far away starts ahead of everything.
        self._far = np.array([light.kind in (LightKind.SUN, LightKind.WORLD) for light in scene.lights], bool)
        self._inside[self._far], self._glass[self._far] = 0, False
        count = len(scene.volumes)
        self._scattering = np.zeros((count, 3), np.float32)
        for index, volume in enumerate(scene.volumes):
            self._scattering[index] = volume.scattering
        self._extinction, self._columns = scene.extinctions, Columns(scene)
        # A channel in which nothing is scattered shows nothing, however far its light gets.
        shows = np.zeros((count + 1, 3), bool)
        shows[:count] = self._scattering > 0
        least = np.where(shows, self._extinction, np.inf).min(axis=1)
        self._opaque = np.where(shows.any(axis=1), _OPAQUE / np.maximum(least, 1e-30), np.inf).astype(np.float32)
        self._lobes = [volume.medium.phase.angular_variance() for volume in scene.volumes]
        self._bounds = scene.bounds

    def _place(self, light):
        """A point of a light, on the side that shines: what a photon's start is inside of is found from there."""
        if light.kind == LightKind.AREA:
            normal = np.cross(light.u, light.v)
            return light.position + 1e-4 * normal / np.sqrt(max(np.linalg.norm(normal), 1e-30))
        if light.kind == LightKind.MESH:
            corners = light.triangles[0].astype(np.float64)
            normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
            return corners.mean(axis=0) + 1e-4 * normal / np.sqrt(max(np.linalg.norm(normal), 1e-30))
        return light.position

    def trace(self, sequence, first, count, paths, with_fields, poll):
        """Traces paths `first` to `first + count` of a sequence: a Record.

        - paths: what the power is divided by: the number of paths of the whole pass.
        - with_fields: whether the paths carry light fields and leave segments.
        """
        record = Record()
        if self._emitter.is_dark or count == 0:
            return record
        indices = np.arange(first, first + count, dtype=np.uint64).astype(np.uint32)
        sampler = Sampler(self._seed, sequence, indices)
        start = self._emitter.emit(sampler, count, with_fields)
        inside, glass = self._inside[start.light], self._glass[start.light]
        placed = np.flatnonzero(~self._far[start.light])
        inside[placed], glass[placed] = self._interiors.moved(
            inside[placed], glass[placed], self._places[start.light[placed]], start.origin[placed]
        )
        photons = _Photons(
            start.origin,
            start.direction,
            start.power / np.float32(paths),
            start.normal,
            inside,
            glass,
            np.ones(count, bool),
            np.zeros(count, np.int32),
            start.dark,
            start.until,
            start.field,
        )
        alive = photons.power.max(axis=1) > 0
        event = 0
        while True:
            if not alive.all():
                photons = photons.take(alive)
                sampler.take(alive)
            if len(photons.origin) == 0:
                return record
            ask(poll)
            alive = self._step(photons, sampler, record, poll)
            if self._bounces is not None:
                alive &= photons.bounces <= self._bounces
            event += 1
            if event > _LONG_PATH:
                stays = sampler.uniform() < _GOING_ON
                photons.power /= _GOING_ON
                alive &= stays

    def _step(self, photons, sampler, record, poll):
        """One segment of all photons, and the events at their ends. Returns which go on."""
        scene = self._scene
        hit = scene.geometry.cast(photons.origin, photons.direction)
        ask(poll)
        reach = hit["distance"]
        volume = self._interiors.volumes(photons.inside)
        extinction = self._extinction[volume]
        # As far as a beam is seen.
        opaque = self._columns.distance(volume, photons.origin, photons.direction, self._opaque[volume])
        self._leave_beams(photons, hit, volume, opaque, record)
        column = _free_flight(photons.power, extinction, sampler.uniform())
        target = self._columns.distance(volume, photons.origin, photons.direction, column)
        collides = target < reach
        flight = np.minimum(target, reach)
        if photons.light is not None:
            self._carry(photons, hit, volume, opaque, flight, record)
            ask(poll)
        choice, xi, facets = sampler.uniform(), sampler.pair(), sampler.pair()
        alive = np.zeros(len(reach), bool)

        # Where a lamp does not shine, nothing is lit; photons still cross the bounds of fog.
        collides &= target < photons.until
        at = np.flatnonzero(collides & (target >= photons.dark))
        if len(at):
            alive[at] = self._scatter(
                photons, at, volume[at], extinction[at], target[at], column[at], choice[at], xi[at]
            )
        # What gets through is weighed by how likely that was; escapes into emptiness end there.
        at = np.flatnonzero((target >= reach) & (reach < photons.until) & np.isfinite(reach))
        if len(at):
            passed = self._columns.at(volume[at], photons.origin[at], photons.direction[at], reach[at])
            left = np.exp(-extinction[at] * passed[:, None])
            photons.power[at] *= left / _weighted(left, photons.power[at])
            alive[at] = self._interact(photons, at, hit[at], choice[at], xi[at], facets[at])
        return alive

    def _leave_beams(self, photons, hit, volume, opaque, record):
        """Beams run to the next surface, or until nothing is left: not to the next collision."""
        opaque = np.minimum(opaque, photons.until)
        length = np.minimum(hit["distance"], opaque) - photons.dark
        ends = hit["distance"] <= opaque
        normal = hit["geometric_normal"]
        behind = np.einsum("ij,ij->i", normal, photons.direction) > 0
        end_normal = np.where(ends[:, None], np.where(behind[:, None], -normal, normal), np.float32(0))
        region = 2 * volume + photons.glass
        wanted = (volume >= 0) & np.isfinite(length) & (length > 0)
        for number in np.unique(region[wanted]):
            at = np.flatnonzero(wanted & (region == number))
            if not self._scattering[number // 2].any():
                continue
            beams = np.zeros(len(at), BEAM)
            dark = photons.dark[at, None]
            beams["origin"], beams["direction"] = photons.origin[at] + dark * photons.direction[at], photons.direction[at]
            passed = self._columns.at(volume[at], photons.origin[at], photons.direction[at], photons.dark[at])
            beams["length"] = length[at]
            beams["power"] = photons.power[at] * np.exp(-self._extinction[number // 2] * passed[:, None])
            beams["start_normal"], beams["end_normal"] = photons.normal[at], end_normal[at]
            record.add("beams", number, beams)

    def _carry(self, photons, hit, volume, opaque, flight, record):
        """Records whole segments with the silhouettes beside them, and moves light fields on by the flight."""
        segments = np.zeros(len(flight), SEGMENT)
        segments["origin"], segments["field"] = photons.origin, photons.light
        counts, edges = self._scene.geometry.edges(photons.origin, photons.direction, hit, self._bounds)
        segments["edge_count"], segments["edges"] = counts, edges
        # What escapes ends there.
        distance = np.where(np.isfinite(flight), flight, 0).astype(np.float32)
        photons.light = self._field_at(segments, volume, distance)
        self._leave_segments(photons, segments, hit["distance"], volume, opaque, record)

    def _field_at(self, segments, volume, distance):
        """Light fields of SEGMENTs in some volumes at distances."""
        field = segment.field_at(segments, _VACUUM, distance)
        for medium, of in self._columns.media(volume):
            field[of] = segment.field_at(segments[of], medium, distance[of])
        return field

    def _leave_segments(self, photons, segments, reach, volume, opaque, record):
        """Like beams, segments run from where their light begins to the next surface."""
        dark = photons.dark
        length = np.minimum(np.minimum(reach, opaque), photons.until) - dark
        passed = self._columns.at(volume, photons.origin, photons.direction, dark)
        power = photons.power.mean(axis=1) * np.exp(-self._extinction[volume].mean(axis=1) * passed)
        wanted = (volume >= 0) & ~photons.glass & np.isfinite(length) & (length > 0) & (power > 0)
        late = np.flatnonzero(wanted & (dark > 0))
        if len(late):
            # Edges before that lie behind the segment then.
            segments["field"][late] = self._field_at(segments[late], volume[late], dark[late])
            segments["origin"][late] += dark[late, None] * photons.direction[late]
            segments["edges"]["depth"][late] -= dark[late, None]
        segments["length"], segments["power"], segments["unscattered"] = length, power, photons.unscattered
        for number in np.unique(volume[wanted]):
            record.add("segments", number, segments[wanted & (volume == number)])

    def _scatter(self, photons, at, volume, extinction, flight, column, choice, xi):
        """Collisions in media: which photons scatter on."""
        before = photons.power[at]
        density = extinction * np.exp(-extinction * column[:, None])
        collided = before * (density / _weighted(density, before))
        after = collided * (self._scattering[volume] / np.maximum(extinction, np.float32(1e-38)))
        photons.origin[at] += flight[:, None] * photons.direction[at]
        direction = photons.direction[at]
        for number in np.unique(volume):
            of = np.flatnonzero(volume == number)
            direction[of] = self._scene.volumes[number].medium.phase.sample(direction[of], xi[of])
            if photons.light is not None:
                field = photons.light[at[of]]
                light_field.scatter(field, direction[of], self._lobes[number])
                photons.light[at[of]] = field
        photons.direction[at] = direction
        photons.normal[at] = 0
        photons.unscattered[at] = False
        photons.bounces[at] += 1
        photons.dark[at], photons.until[at] = 0, np.inf
        return _survive(photons, at, before, after, choice)

    def _interact(self, photons, at, hit, choice, xi, facets):
        """Surfaces: which photons go on. One lobe is drawn in proportion to what it takes."""
        m = meet(photons.direction[at], hit, self._scene.materials, facets)
        light = weights(m) * photons.power[at]
        brightest = photons.power[at].max(axis=1)
        shares = light.max(axis=2) / brightest
        total = np.maximum(shares.sum(axis=0), 1)
        bounds = np.cumsum(shares / total, axis=0)
        # What none of the lobes takes is absorbed.
        lobe = (choice >= bounds).sum(axis=0)
        lives = lobe < len(bounds)
        for kind in Lobe:
            of = np.flatnonzero(lobe == kind)
            if len(of) == 0:
                continue
            here, some = at[of], m.take(of)
            photons.power[here] = light[kind, of] / (shares[kind, of] / total[of])[:, None]
            direction = follow(some, kind, xi[of])
            if photons.light is not None:
                photons.light[here] = _turned(photons.light[here], some, kind, direction)
            photons.origin[here], photons.normal[here] = leave(some, direction)
            photons.direction[here] = direction
            if kind in (Lobe.TRANSPARENT, Lobe.GLASS_TRANSMISSION, Lobe.TRANSLUCENT):
                objects = some.hit["object"]
                photons.inside[here] = self._interiors.crossed(photons.inside[here], objects, some.front)
            if kind == Lobe.GLASS_TRANSMISSION:
                photons.glass[here] = self._interiors.glazed(photons.glass[here], some.hit["object"], some.front)
            smooth = some.material["roughness"] < SMOOTH
            if kind in (Lobe.DIFFUSE, Lobe.TRANSLUCENT):
                smooth = False
            if kind == Lobe.TRANSPARENT:
                photons.dark[here] = np.maximum(photons.dark[here] - hit["distance"][of], 0)
                photons.until[here] -= hit["distance"][of]
            else:
                lives[of] = photons.dark[here] <= hit["distance"][of]
                photons.dark[here], photons.until[here] = 0, np.inf
                photons.unscattered[here] &= smooth
                photons.bounces[here] += 1
        return lives


def _weighted(values, power):
    """Means of values over the channels, weighted by power: (n, 1)."""
    return (np.einsum("ij,ij->i", values, power) / power.sum(axis=1))[:, None]


def _free_flight(power, extinction, u):
    """Columns up to the next collision: one channel, drawn by its power, decides for all three."""
    share = power / power.sum(axis=1, keepdims=True)
    grey = (extinction[:, 0] == extinction[:, 1]) & (extinction[:, 1] == extinction[:, 2])
    bounds = np.cumsum(share, axis=1)
    rows = np.arange(len(u))
    channel = np.where(grey, 0, np.minimum((u[:, None] >= bounds[:, :2]).sum(axis=1), 2))
    # Rounding of the sums may leave room for a channel without power.
    channel = np.where(share[rows, channel] > 0, channel, power.argmax(axis=1))
    below = np.where(channel > 0, bounds[rows, channel - 1], np.float32(0))
    rest = np.where(grey, u, (u - below) / np.maximum(share[rows, channel], np.float32(1e-38)))
    rest = np.clip(rest, 0, np.float32(1 - 2.0**-24))
    rate = extinction[rows, channel]
    return np.where(rate > 0, -np.log1p(-rest) / np.maximum(rate, np.float32(1e-30)), np.float32(np.inf))


def _survive(photons, at, before, after, choice):
    """Keeps photons with the probability after / before, and their power unchanged on average."""
    survival = np.minimum(after.max(axis=1) / before.max(axis=1), 1)
    photons.power[at] = after / np.maximum(survival, np.float32(1e-38))[:, None]
    return choice < survival


def _turned(field, m, kind, direction):
    """Light fields after a surface."""
    if kind == Lobe.TRANSPARENT:
        return field
    if kind in (Lobe.DIFFUSE, Lobe.TRANSLUCENT):
        light_field.diffuse(field, m.shading, direction)
        return field
    curvature = np.ascontiguousarray(m.hit["curvature"]).astype(CURVATURE)
    # Seen from the other side, what was convex is concave.
    turned = np.einsum("ij,ij->i", m.hit["normal"], m.facet) < 0
    for name in ("along", "across"):
        curvature[name][turned] *= -1
    if kind == Lobe.GLASS_TRANSMISSION:
        light_field.refract(field, m.facet, curvature, m.eta)
    else:
        light_field.reflect(field, m.facet, curvature)
    rough = np.flatnonzero(m.material["roughness"] >= SMOOTH)
    if len(rough):
        # A facet turns by alpha / sqrt(2) in each direction; a mirror turns light by twice that, a lens by |1 - eta| times.
        turn = 2 if kind != Lobe.GLASS_TRANSMISSION else np.abs(1 - m.eta[rough])
        deviation = np.maximum(turn * m.material["roughness"][rough] / np.sqrt(2), 1e-3)
        some = field[rough]
        light_field.scatter(some, direction[rough], (1 / (2 * np.pi * deviation) ** 2).astype(np.float32))
        field[rough] = some
    return field
