# SPDX-License-Identifier: GPL-3.0-or-later
"""The Principled BSDF -> Lobes: its layers in the order and with the weights of Cycles."""

import numpy as np


def principled(values, node, groups, weight, lobes):
    """Adds the lobes of a Principled BSDF node, times `weight`."""

    def number(identifier):
        return values.number(node, identifier, groups)

    def share(identifier):
        return np.clip(number(identifier), 0.0, 1.0)

    base = np.maximum(values.colour(node, "Base Color", groups), 0)
    tint = np.maximum(values.colour(node, "Specular Tint", groups), 0)
    ior, roughness = np.maximum(number("IOR"), 1e-5), number("Roughness")
    alpha = share("Alpha")
    lobes.add(transparent=weight * (1 - alpha))
    weight = weight * alpha
    for name in ("Sheen Weight", "Coat Weight"):
        if np.any(number(name) > 0):
            values.note(name.removesuffix(" Weight").lower(), "ignored", in_fog=True)
    strength = number("Emission Strength")
    if np.any(strength != 0):
        lobes.emission = lobes.emission + weight * strength * values.colour(node, "Emission Color", groups)

    metallic = share("Metallic")
    if np.any(metallic > 0):
        reflectance = np.minimum(base, 1)
        edge = edge_of_tint(values, reflectance, np.minimum(tint, 1))
        part = weight * metallic
        lobes.add_specular(None, roughness, metal=part * reflectance, edge=part * edge)
    weight = weight * (1 - metallic)

    transmission = share("Transmission Weight")
    if np.any(transmission * weight > 0):
        part = weight * transmission
        # Light passes two surfaces on its way through: each takes the root of the colour.
        through = part * np.sqrt(np.minimum(base, 1))
        lobes.add_specular(ior, roughness, glass_reflection=part, glass_transmission=through)
        _note_tint(values, tint)
    weight = weight * (1 - transmission)
    if not np.any(weight):
        return

    level = np.maximum(number("Specular IOR Level"), 0.0)
    eta = _adjusted(ior, level)
    if np.any(eta != 1):
        lobes.add_specular(eta, roughness, coat=weight)
        if np.any(eta < 1):
            values.note("index of refraction below 1", "reflects less than in Cycles", in_fog=True)
        _note_tint(values, tint)
    if np.any(share("Subsurface Weight") > 0):
        values.note("subsurface scattering", "diffuse", in_fog=True)
    if np.any(values.number(node, "Diffuse Roughness", groups) > 0):
        values.note("roughness of diffuse", "smooth (Lambert)", in_fog=True)
    lobes.add(diffuse=weight * base)


def edge_of_tint(values, base, tint):
    """The colour at grazing incidence that puts Schlick's curve where Cycles has it at the edge tint's 82 degrees."""
    if np.all(tint == 1):
        return np.ones(3)
    values.note("edge tint of metal", "Schlick's curve through its value at 82 degrees")
    # (1 - cos)^5 where Cycles anchors the tint: cos = 1/7.
    rise = (6 / 7) ** 5
    return np.clip((tint * (base + (1 - base) * rise) - base * (1 - rise)) / rise, 0, 1)


def _adjusted(ior, level):
    """The index of refraction whose reflectance at normal incidence is that of `ior`, times twice the level."""
    reflectance = ((ior - 1) / (ior + 1)) ** 2 * 2 * level
    root = np.minimum(reflectance, 0.99) ** 0.5
    eta = (1 + root) / (1 - root)
    return np.where(level == 0.5, ior, np.where(ior < 1, 1 / eta, eta))


def _note_tint(values, tint):
    if np.any(tint != 1):
        values.note("specular tint", "reflections of dielectrics stay white", in_fog=True)
