# SPDX-License-Identifier: GPL-3.0-or-later
"""Smoke domains of Blender's fluid simulation -> Grids."""

import numpy as np

from .grids import Grid, Grids

#: Names by which Cycles' nodes ask for what a domain holds, and channels.
_CHANNELS = {"density": 1, "flame": 1, "heat": 1, "temperature": 1, "color": 4, "velocity": 3}


def gas_domain(thing):
    """The bpy.types.FluidDomainSettings of an object that is a domain of smoke or fire, or None."""
    for modifier in thing.modifiers:
        if modifier.type == "FLUID" and modifier.fluid_type == "DOMAIN":
            return modifier.domain_settings if modifier.domain_settings.domain_type == "GAS" else None
    return None


def smoke(thing, depsgraph):
    """The Grids of an evaluated object that is such a domain, or None if it is empty.

    As in Cycles, they fill the texture space of its mesh, whatever shape that has.
    """
    domain, original = gas_domain(thing), thing.original
    cells = _cells(domain, len(domain.density_grid))
    middle, half = (np.array(of, np.float64) for of in (thing.data.texspace_location, thing.data.texspace_size))
    if cells is None or not (half > 0).all():
        return None

    def transform(cells):
        made = np.eye(4)
        made[:3, :3] = np.diag(cells / (2 * half))
        made[:3, 3] = (half - middle) * cells / (2 * half) - 0.5
        return made

    def read(name):
        channels = _CHANNELS.get(name)
        if channels is None:
            return None
        # The object of an instance is Blender's only for a moment; this one lives as long as the depsgraph.
        domain = gas_domain(original.evaluated_get(depsgraph))
        found = getattr(domain, f"{name}_grid")
        values = np.empty(len(found), np.float32)
        cells = _cells(domain, len(found) // channels)
        if cells is None:
            return None
        found.foreach_get(values)
        values = np.nan_to_num(values, nan=0.0, posinf=0.0, neginf=0.0)
        return Grid(values.reshape(*cells[::-1], channels), transform(cells))

    return Grids(read, [(cells, transform(cells))])


def _cells(domain, count):
    """Cells along x, y and z, int (3,), of a grid that has so many in all; None if there are none."""
    cells = np.array(domain.domain_resolution, np.int64)
    # Noise makes some of them finer.
    for finer in (1, domain.noise_scale):
        if count and np.prod(cells * finer) == count:
            return cells * finer
    return None
