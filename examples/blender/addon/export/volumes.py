# SPDX-License-Identifier: GPL-3.0-or-later
"""Volume shader nodes -> media, by the definitions of Cycles."""

from dataclasses import dataclass, replace

import bpy
import numpy as np

from ..host.scene import Glow, Phase, Volume
from . import blackbody, phases
from .density import bake
from .grids import Asked, Grids, Lookup
from .mixture import Part, mixed
from .nodes import Values, closures
from .textures import Places

#: Sets of objects whose fog overlaps that are told apart: each has a grid of its own.
_MOST_SETS = 16

#: Places where it is looked at what fog asks for.
_LOOKS = 64

#: What varies so finely that voxels are off by more on average is another picture.
_TOO_COARSE = 0.05

#: What is flat is as thick as this [m], for what it sends out: no voxel is thinner.
_THINNEST = 1e-6

#: No coefficient is larger [1/m] or [W/(m^3 sr)]: a nanometre of it is opaque.
_MOST = 1e9


@dataclass(frozen=True)
class Fog:
    """What a Volume socket describes."""

    values: Values
    #: The bpy.types.NodeSocket, which lives as long as the depsgraph.
    socket: object
    #: Whether it varies from place to place.
    varies: bool
    #: Whether shadow rays do not see it: straight light is not dimmed by it, and scattered all the same.
    is_unshadowed: bool = False

    def at(self, places=None):
        """The Sum of its closures at textures.Places, or wherever it is."""
        total = Sum()
        # Whatever nodes make of hostile numbers is brought to sound coefficients.
        with np.errstate(all="ignore"):
            _add(self.values.at(places), self.socket, (), 1.0, total)
        # Cycles looks for fog where there is something of what it asks for.
        return Sum() if places is not None and places.held.misses_all else total

    def names(self):
        """What it asks an object for that holds something of its own: set of names."""
        places = np.random.default_rng(0).random((_LOOKS, 3))
        asked = Asked(_LOOKS)
        with np.errstate(all="ignore"):
            _add(self.values.quiet().at(Places(places, places, places, held=asked)), self.socket, (), 1.0, Sum())
        return asked.names


@dataclass(frozen=True)
class Frame:
    """Where an object is, for what varies in it."""

    #: From the object's space to the moved world: float64 (4, 4).
    matrix: np.ndarray
    #: Middle and half size of the mesh's texture space, float64 (3,).
    middle: np.ndarray
    half: np.ndarray
    #: What the world is moved by, float64 (3,).
    home: np.ndarray
    #: What the object holds of its own, or None.
    grids: Grids | None = None

    def places(self, world):
        """The textures.Places of places in the moved world [m], float64 (n, 3)."""
        inverse = np.linalg.pinv(self.matrix)
        inside = world @ inverse[:3, :3].T + inverse[:3, 3]
        half = np.where(self.half > 0, self.half, 1)
        return Places(world + self.home, inside, 0.5 * (inside - self.middle) / half + 0.5, held=Lookup(self.grids, inside))


class Sum:
    """Coefficients [1/m] of the closures added so far, that of emission [W/(m^3 sr)], and the phase function of each that scatters."""

    def __init__(self):
        self.scattering, self.absorption, self.emission = np.zeros(3), np.zeros(3), np.zeros(3)
        #: mixture.Part of each.
        self.phases = []

    def scatter(self, coefficient, asymmetry, rayleigh=False):
        coefficient = _sound(coefficient)
        self.scattering = self.scattering + coefficient
        if coefficient.any():
            # Cycles leaves out the last thousandth before +-1 too.
            cosine = min(max(float(np.nan_to_num(np.mean(asymmetry))), -0.999), 0.999)
            self.phases.append(Part(coefficient, Phase.RAYLEIGH if rayleigh else Phase.HENYEY_GREENSTEIN, 0.0 if rayleigh else cosine))

    def absorb(self, coefficient):
        self.absorption = self.absorption + _sound(coefficient)

    def emit(self, coefficient):
        self.emission = self.emission + _sound(coefficient)

    @property
    def is_nothing(self):
        return not (self.scattering.any() or self.absorption.any() or self.emission.any())


@dataclass(frozen=True)
class Filled:
    """A Fog and what it fills between the corners `low` and `high` [m]: an object, whose Frame it is in, or the world, without one."""

    name: str
    fog: Fog
    low: np.ndarray
    high: np.ndarray
    frame: Frame | None = None

    @property
    def varies(self):
        """Whether it varies from place to place."""
        return self.fog.varies or (self.frame is not None and self.frame.grids is not None)

    @property
    def is_turned(self):
        """Whether what the object holds of its own lies otherwise than the axes of the world."""
        if self.frame is None or self.frame.grids is None:
            return False
        axes = np.abs(self.frame.matrix[:3, :3])
        return bool((axes.sum(axis=0) > 1.001 * axes.max(axis=0)).any())

    def cells(self, size):
        """How many voxels of some `size` [m] are as fine as what the object holds of its own; ones if that is nothing: int (3,)."""
        grids = self.frame.grids if self.frame is not None else None
        if grids is None:
            return np.ones(3, np.int64)
        return np.maximum(1, np.round(np.minimum(grids.cells_a_metre(self.frame.matrix) * size, 1e6))).astype(np.int64)


def _sound(coefficient):
    """Coefficients without what is negative or no number; none is above _MOST."""
    return np.clip(np.nan_to_num(coefficient), 0, _MOST)


def fog(values, socket, may_vary=False):
    """The Fog that leads to the Volume socket of an output node, or None if it neither scatters nor absorbs, nor sends out light.

    - may_vary: whether its values may vary from place to place; if not, what does is reported.
    """
    values = values.of_fog()
    trial = values.quiet()
    with np.errstate(all="ignore"):
        _add(trial, socket, (), 1.0, Sum())
    made = Fog(values, socket, may_vary and trial.varies)
    if not made.varies and made.at().is_nothing:
        return None
    return replace(made, is_unshadowed=_is_unshadowed(made, may_vary))


def _is_unshadowed(fog, has_bounds):
    """Whether shadow rays see nothing of a Fog, by a Light Path node in it; what is between that and all of it is reported."""
    random = np.random.default_rng(0).random((_LOOKS, 3))
    places = Places(random, random, random, held=Asked(_LOOKS)) if fog.varies else None
    sums = []
    for values in (fog.values.quiet(), fog.values.for_shadows()):
        sums.append(Sum())
        with np.errstate(all="ignore"):
            _add(values.at(places), fog.socket, (), 1.0, sums[-1])
    seen, by_shadows = (np.stack(np.broadcast_arrays(each.scattering, each.absorption)) for each in sums)
    if seen.shape == by_shadows.shape and np.array_equal(seen, by_shadows):
        return False
    if has_bounds and not by_shadows.any():
        return True
    fog.values.note("fog that shadow rays see otherwise, by Light Path", "as all other rays see it", in_fog=True)
    return False


def _add(values, socket, groups, weight, total):
    for node, of, share in closures(values, socket, groups, weight):
        if node.type in _CLOSURES:
            _CLOSURES[node.type](values, node, of, share, total)
        else:
            values.note(f"{node.bl_label} as a volume", "ignored", in_fog=True)


def _density(values, node, groups, weight):
    return weight * np.maximum(values.number(node, "Density", groups), 0)


def _scatter(values, node, groups, weight, total):
    coefficient = _density(values, node, groups, weight) * values.colour(node, "Color", groups)
    total.scatter(coefficient, *_asymmetry(values, node, groups))


def _absorption(values, node, groups, weight, total):
    total.absorb(_density(values, node, groups, weight) * (1 - values.colour(node, "Color", groups)))


def _coefficients(values, node, groups, weight, total):
    total.scatter(weight * values.colour(node, "Scatter Coefficients", groups), *_asymmetry(values, node, groups))
    total.absorb(weight * values.colour(node, "Absorption Coefficients", groups))
    total.emit(weight * values.colour(node, "Emission Coefficients", groups))


def _principled(values, node, groups, weight, total):
    density, colour = _density(values, node, groups, weight), values.colour(node, "Color", groups)
    held, name = values.held(node, "Density Attribute")
    of_object = held.number(name) if held is not None else None
    if of_object is not None:
        density = density * np.maximum(of_object, 0)
    held, name = values.held(node, "Color Attribute")
    of_object = held.colour(name) if held is not None else None
    if of_object is not None:
        colour = colour * of_object
    tint = np.sqrt(np.maximum(values.colour(node, "Absorption Color", groups), 0))
    total.scatter(density * colour, values.number(node, "Anisotropy", groups))
    total.absorb(density * np.maximum(1 - colour, 0) * np.maximum(1 - tint, 0))
    # What it sends out does not depend on its density.
    strength = np.maximum(values.number(node, "Emission Strength", groups), 0)
    if np.any(strength > 0):
        total.emit(weight * strength * values.colour(node, "Emission Color", groups))
    intensity = np.maximum(values.number(node, "Blackbody Intensity", groups), 0)
    if np.any(intensity > 0):
        held, name = values.held(node, "Temperature Attribute")
        of_object = held.number(name) if held is not None else None
        kelvin = values.number(node, "Temperature", groups) * (1 if of_object is None else np.maximum(of_object, 0))
        glow = np.where(intensity > 0, blackbody.glow(kelvin, intensity), 0)
        total.emit(weight * values.colour(node, "Blackbody Tint", groups) * glow)


def _emission(values, node, groups, weight, total):
    total.emit(weight * np.maximum(values.number(node, "Strength", groups), 0) * values.colour(node, "Color", groups))


def _asymmetry(values, node, groups):
    """Mean cosine, and whether the phase function is Rayleigh's."""
    # Before Blender 4.3 there is Henyey-Greenstein only.
    kind = getattr(node, "phase", "HENYEY_GREENSTEIN")
    if kind == "HENYEY_GREENSTEIN":
        return values.number(node, "Anisotropy", groups), False
    if kind == "RAYLEIGH":
        return 0.0, True
    if kind == "DRAINE":
        cosine = phases.draine(values.number(node, "Anisotropy", groups), values.number(node, "Alpha", groups))
    elif kind == "MIE":
        cosine = phases.mie(values.number(node, "Diameter", groups))
    else:
        cosine = phases.fournier_forand(values.number(node, "Backscatter", groups), values.number(node, "IOR", groups))
    name = kind.replace("_", "-").title()
    values.note(f"{name} phase function", f"Henyey-Greenstein with its mean cosine, {cosine:.3g}", in_fog=True)
    return cosine, False


_CLOSURES = {
    "VOLUME_SCATTER": _scatter,
    "VOLUME_ABSORPTION": _absorption,
    "VOLUME_COEFFICIENTS": _coefficients,
    "PRINCIPLED_VOLUME": _principled,
    "EMISSION": _emission,
}


def volumes(filled, report, poll):
    """The host.scene.Volumes of some Filled, as many and in that order; and then, as Cycles adds up what overlaps, those of each set of
    objects that may. The world's fog is everywhere.

    - poll: as for export.
    """
    world = [each for each in filled if each.frame is None]
    made = [_volume([each] if each.frame is None else [each, *world], poll) for each in filled]
    sets, rest = _overlaps(filled)
    for parts in sets:
        together = _volume([*(filled[k] for k in parts), *world], poll)
        made.append(replace(together, parts=parts))
    for each in world:
        if each.fog.at().emission.any():
            each.fog.values.note("light that fog without end sends out", "it is dark", in_fog=True)
    for k in rest:
        report.add(f'Volume of "{filled[k].name}"', "overlaps too many others", "only the smallest one is there", True)
    return made


def _overlaps(filled):
    """Sets of objects that have a place in common, as tuples of indices, smaller sets first; and which overlap in more ways than that."""
    bodies = [k for k, each in enumerate(filled) if each.frame is not None]
    boxes = {(k,): (filled[k].low, filled[k].high) for k in bodies}
    found, rest = [], set()
    while boxes:
        larger = {}
        for parts, (low, high) in boxes.items():
            for k in bodies:
                # Boxes that overlap in pairs have a place in common.
                both = np.maximum(low, filled[k].low), np.minimum(high, filled[k].high)
                if k <= parts[-1] or not np.all(both[0] < both[1]):
                    continue
                if len(found) + len(larger) < _MOST_SETS:
                    larger[*parts, k] = both
                else:
                    rest |= {*parts, k}
        found += larger
        boxes = larger
    return found, sorted(rest)


def _volume(parts, poll):
    """The host.scene.Volume where all `parts` are, each a Filled."""
    low = np.max([part.low for part in parts], axis=0)
    high = np.min([part.high for part in parts], axis=0)
    values, density, glow = parts[0].fog.values, None, None
    if any(part.varies for part in parts):
        baked, lobes = _baked(parts, low, high, poll)
        scattering, absorption, density, glow = baked.scattering, baked.absorption, baked.density, baked.glow
    else:
        scattering, absorption, emission, lobes = _added(parts)
        if emission.any():
            glow = Glow(low, np.maximum(high, low + _THINNEST), np.float32(emission).reshape(1, 1, 1, 3))
    phase, asymmetry, lobes = mixed(values, lobes)
    return Volume(
        name=parts[0].name,
        scattering=scattering,
        absorption=absorption,
        phase=phase,
        asymmetry=asymmetry,
        lobes=lobes,
        min=low,
        max=high,
        density=density,
        glow=glow,
    )


def _added(parts, world=None):
    """Coefficients of scattering, absorption and emission of some Filled together, and their phase functions; world: places, where they
    vary [m]. What has no end is dark."""
    totals = [part.fog.at(part.frame.places(world) if part.varies else None) for part in parts]
    lobes = [lobe for total in totals for lobe in total.phases]
    emission = sum((total.emission for part, total in zip(parts, totals) if part.frame is not None), np.zeros(3))
    return sum(total.scattering for total in totals), sum(total.absorption for total in totals), emission, lobes


def _baked(parts, low, high, poll):
    """The density.Baked of some Filled together, and their phase functions."""

    def coefficients(world):
        *sums, phases = _added(parts, world)
        lobes.append(phases)
        return [np.broadcast_to(of, world.shape) for of in sums]

    lobes = []
    varying = [part for part in parts if part.varies]
    finest = np.max([part.cells(high - low) for part in varying], axis=0)
    baked, values = bake(coefficients, low, high, finest, poll), varying[0].fog.values
    if baked.error > 0.01:
        cells = " x ".join(map(str, baked.cells))
        values.note("density that varies finely", f"{cells} voxels, which are {baked.error:.1%} off on average", in_fog=baked.error > _TOO_COARSE)
    if baked.glow is not None and bpy.app.version >= (5, 0) and any(part.is_turned for part in varying):
        values.note("emission of a domain that is turned", "its voxels lie otherwise than its cells, and are off where flames have borders", in_fog=True)
    if baked.glow_error > 0.01:
        cells = " x ".join(map(str, baked.glow.values.shape[2::-1]))
        values.note("emission that varies finely", f"{cells} voxels, which are {baked.glow_error:.1%} off on average", in_fog=baked.glow_error > _TOO_COARSE)
    if baked.coloured > 0.01:
        values.note("colour that varies in a volume", "its mean; the density varies", in_fog=True)
    # The first places are scattered over all of it.
    return baked, lobes[0]
