# SPDX-License-Identifier: GPL-3.0-or-later
"""Volume shader nodes -> media, by the definitions of Cycles."""

from dataclasses import dataclass

import covbeam
import numpy as np

from ..host.scene import Volume
from . import phases
from .density import bake
from .nodes import Values, closures
from .textures import Places


@dataclass(frozen=True)
class Fog:
    """What a Volume socket describes, wherever it is; fields as in host.scene.Volume."""

    medium: covbeam.Medium
    scattering: np.ndarray
    absorption: np.ndarray
    asymmetry: float
    varies: bool = False


@dataclass(frozen=True)
class VariedFog:
    """What a Volume socket describes whose values vary from place to place: what it is depends on where it is."""

    values: Values
    #: The bpy.types.NodeSocket, which lives as long as the depsgraph.
    socket: object

    def placed(self, frame, low, high, poll):
        """The Fog between the corners `low` and `high` [m] in an object of some Frame; poll: as for export."""

        def coefficients(world):
            total = _Sum()
            _add(self.values.in_fog(frame.places(world)), self.socket, (), 1.0, total)
            found.append(total)
            return [np.nan_to_num(np.broadcast_to(of, world.shape), posinf=0.0, neginf=0.0) for of in (total.scattering, total.absorption)]

        found = []
        baked = bake(coefficients, low, high, poll)
        if baked.error > 0.01:
            cells = " x ".join(map(str, baked.cells))
            self.values.note("density that varies finely", f"{cells} voxels, which are {baked.error:.1%} off on average", in_fog=True)
        if baked.coloured > 0.01:
            self.values.note("colour that varies in a volume", "its mean; the density varies", in_fog=True)
        # The first places are scattered over all of it.
        asymmetry, phase = _phase(self.values, found[0].phases)
        medium = covbeam.Medium(tuple(baked.scattering), tuple(baked.absorption), phase, baked.density)
        return Fog(medium, baked.scattering, baked.absorption, asymmetry, baked.density is not None)


@dataclass(frozen=True)
class Frame:
    """Where an object is, for what varies in it."""

    #: From the object's space to the world: float64 (4, 4).
    matrix: np.ndarray
    #: Middle and half size of the mesh's texture space, float64 (3,).
    middle: np.ndarray
    half: np.ndarray

    def places(self, world):
        """The textures.Places of places in the world [m], float64 (n, 3)."""
        inverse = np.linalg.pinv(self.matrix)
        inside = world @ inverse[:3, :3].T + inverse[:3, 3]
        half = np.where(self.half > 0, self.half, 1)
        return Places(world, inside, 0.5 * (inside - self.middle) / half + 0.5)


class _Sum:
    """Coefficients [1/m] of the closures added so far, and the phase function of each that scatters."""

    def __init__(self):
        self.scattering, self.absorption = np.zeros(3), np.zeros(3)
        # (scattering coefficient, mean cosine, is it Rayleigh's)
        self.phases = []

    def scatter(self, coefficient, asymmetry, rayleigh=False):
        coefficient = np.maximum(coefficient, 0)
        self.scattering = self.scattering + coefficient
        if coefficient.any():
            # Cycles leaves out the last thousandth before +-1 too.
            cosine = min(max(float(np.mean(asymmetry)), -0.999), 0.999)
            self.phases.append((float(coefficient.sum()) / coefficient.size, cosine, rayleigh))

    def absorb(self, coefficient):
        self.absorption = self.absorption + np.maximum(coefficient, 0)


def fog(values, socket, may_vary=False):
    """The Fog that leads to the Volume socket of an output node, or None if it neither scatters nor absorbs; a VariedFog if its values
    vary and that is wanted."""
    values, total = values.in_fog(), _Sum()
    trial = values.quiet()
    _add(trial, socket, (), 1.0, _Sum())
    if may_vary and trial.varies:
        return VariedFog(values, socket)
    _add(values, socket, (), 1.0, total)
    if not (total.scattering.any() or total.absorption.any()):
        return None
    asymmetry, phase = _phase(values, total.phases)
    return Fog(
        medium=covbeam.Medium(tuple(total.scattering), tuple(total.absorption), phase),
        scattering=total.scattering,
        absorption=total.absorption,
        asymmetry=asymmetry,
    )


def _phase(values, lobes):
    """Mean cosine and covbeam.Phase of a sum of phase functions."""
    if not lobes:
        return 0.0, covbeam.Phase.isotropic()
    if all(rayleigh for _, _, rayleigh in lobes):
        return 0.0, covbeam.Phase.rayleigh()
    weights, cosines = (np.array([lobe[k] for lobe in lobes]) for k in range(2))
    asymmetry = float(weights @ cosines / weights.sum())
    if np.ptp(cosines) > 1e-6 or any(rayleigh for _, _, rayleigh in lobes):
        values.note("sum of different phase functions", f"Henyey-Greenstein with their mean cosine, {asymmetry:.3g}")
    # As Cycles: so little anisotropy is none.
    if abs(asymmetry) < 1e-3:
        return 0.0, covbeam.Phase.isotropic()
    return asymmetry, covbeam.Phase.henyey_greenstein(asymmetry)


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
    if values.colour(node, "Emission Coefficients", groups).any():
        _note_emission(values)


def _principled(values, node, groups, weight, total):
    density = _density(values, node, groups, weight)
    colour = values.colour(node, "Color", groups)
    tint = np.sqrt(np.maximum(values.colour(node, "Absorption Color", groups), 0))
    total.scatter(density * colour, values.number(node, "Anisotropy", groups))
    total.absorb(density * np.maximum(1 - colour, 0) * np.maximum(1 - tint, 0))
    if any(np.any(values.number(node, name, groups) > 0) for name in ("Emission Strength", "Blackbody Intensity")):
        _note_emission(values)


def _emission(values, node, groups, weight, total):
    _note_emission(values)


def _note_emission(values):
    values.note("light that the volume emits", "it is dark", in_fog=True)


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
    values.note(f"{name} phase function", f"Henyey-Greenstein with its mean cosine, {cosine:.3g}")
    return cosine, False


_CLOSURES = {
    "VOLUME_SCATTER": _scatter,
    "VOLUME_ABSORPTION": _absorption,
    "VOLUME_COEFFICIENTS": _coefficients,
    "PRINCIPLED_VOLUME": _principled,
    "EMISSION": _emission,
}


def volume(name, fog, low, high):
    """The host.scene.Volume of a Fog between the corners `low` and `high` [m]."""
    return Volume(
        name=name,
        medium=fog.medium,
        scattering=fog.scattering,
        absorption=fog.absorption,
        asymmetry=fog.asymmetry,
        min=np.asarray(low, np.float64),
        max=np.asarray(high, np.float64),
        varies=fog.varies,
    )


def note_overlaps(volumes, report):
    """Reports each of the host.scene.Volumes whose box overlaps that of another one: Cycles adds them up."""
    low, high = (np.array([getattr(v, end) for v in volumes]).reshape(-1, 3) for end in ("min", "max"))
    for k, one in enumerate(volumes):
        touching = np.all((low < one.max) & (high > one.min), axis=1)
        touching[k] = False
        if touching.any():
            report.add(f'Volume of "{one.name}"', "may overlap another volume", "only the smaller one is there", True)
