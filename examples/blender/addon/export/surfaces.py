# SPDX-License-Identifier: GPL-3.0-or-later
"""Surface shader nodes -> Lobes, by the definitions of Cycles."""

import numpy as np

from .nodes import closures
from .principled import edge_of_tint, principled


def add_surface(values, socket, groups, weight, lobes):
    """Adds the closures that lead to the shader input `socket`, times `weight`, to `lobes`. values: nodes.Values."""
    for node, of, share in closures(values, socket, groups, weight):
        if node.type in _CLOSURES:
            _CLOSURES[node.type](values, node, of, share, lobes)
        else:
            values.note(node.bl_label, "black there", in_fog=True)


def _diffuse(values, node, groups, weight, lobes):
    if np.any(values.number(node, "Roughness", groups) > 0):
        values.note("roughness of Diffuse", "smooth (Lambert)", in_fog=True)
    lobes.add(diffuse=weight * values.colour(node, "Color", groups))


def _translucent(values, node, groups, weight, lobes):
    lobes.add(translucent=weight * values.colour(node, "Color", groups))


def _transparent(values, node, groups, weight, lobes):
    lobes.add(transparent=weight * values.colour(node, "Color", groups))


def _emission(values, node, groups, weight, lobes):
    lobes.emission = lobes.emission + weight * values.number(node, "Strength", groups) * values.colour(node, "Color", groups)


def _glass(values, node, groups, weight, lobes):
    colour = weight * values.colour(node, "Color", groups)
    roughness = _roughness(values, node, groups)
    note_thin_film(values, node, groups)
    ior = np.maximum(values.number(node, "IOR", groups), 1e-5)
    lobes.add_specular(ior, roughness, glass_reflection=colour, glass_transmission=colour)


def _refraction(values, node, groups, weight, lobes):
    values.note("Refraction BSDF", "refracts what Fresnel's equations leave, as glass, and reflects nothing", in_fog=True)
    ior = np.maximum(values.number(node, "IOR", groups), 1e-5)
    colour = weight * values.colour(node, "Color", groups)
    lobes.add_specular(ior, _roughness(values, node, groups), glass_transmission=colour)


def _glossy(values, node, groups, weight, lobes):
    colour = weight * values.colour(node, "Color", groups)
    roughness = _roughness(values, node, groups)
    note_anisotropy(values, node, groups, "Anisotropy")
    lobes.add_specular(None, roughness, metal=colour, edge=colour)


def _metallic(values, node, groups, weight, lobes):
    roughness = _roughness(values, node, groups)
    note_anisotropy(values, node, groups, "Anisotropy")
    note_thin_film(values, node, groups)
    if node.fresnel_type == "F82":
        base = np.clip(values.colour(node, "Base Color", groups), 0, 1)
        edge = edge_of_tint(values, base, np.clip(values.colour(node, "Edge Tint", groups), 0, 1))
    else:
        n, k = (np.maximum(values.colour(node, name, groups), 0) for name in ("IOR", "Extinction"))
        base, edge = ((n - 1) ** 2 + k**2) / ((n + 1) ** 2 + k**2), np.ones(3)
        values.note("Physical Conductor", "its reflectance at normal incidence, and Schlick's curve from there")
    lobes.add_specular(None, roughness, metal=weight * base, edge=weight * edge)


def _roughness(values, node, groups):
    roughness = values.number(node, "Roughness", groups)
    if np.any(roughness > 0) and node.distribution not in ("GGX", "MULTI_GGX"):
        values.note(f"{node.distribution.replace('_', ' ').title()} microfacets", "GGX with the same roughness")
    return roughness


def _subsurface(values, node, groups, weight, lobes):
    values.note("subsurface scattering", "diffuse", in_fog=True)
    lobes.add(diffuse=weight * values.colour(node, "Color", groups))


def _as_diffuse(values, node, groups, weight, lobes):
    values.note(node.bl_label, "diffuse with its colour", in_fog=True)
    lobes.add(diffuse=weight * values.colour(node, "Color", groups))


def _portal(values, node, groups, weight, lobes):
    values.note("Ray Portal BSDF", "transparent with its colour: light stays where it is", in_fog=True)
    lobes.add(transparent=weight * values.colour(node, "Color", groups))


def note_anisotropy(values, node, groups, name):
    """Reports anisotropic microfacets; `name`: identifier of the input."""
    if np.any(np.abs(values.number(node, name, groups)) > 1e-4):
        values.note("anisotropic reflection", "isotropic with the same roughness", in_fog=True)


def note_thin_film(values, node, groups):
    """Reports a thin film."""
    if np.any(values.number(node, "Thin Film Thickness", groups) > 0):
        values.note("thin film", "ignored", in_fog=True)


def _principled(values, node, groups, weight, lobes):
    note_anisotropy(values, node, groups, "Anisotropic")
    note_thin_film(values, node, groups)
    principled(values, node, groups, weight, lobes)


_CLOSURES = {
    "BSDF_PRINCIPLED": _principled,
    "BSDF_DIFFUSE": _diffuse,
    "BSDF_TRANSLUCENT": _translucent,
    "BSDF_TRANSPARENT": _transparent,
    "BSDF_GLASS": _glass,
    "BSDF_REFRACTION": _refraction,
    "BSDF_GLOSSY": _glossy,
    "BSDF_METALLIC": _metallic,
    "BSDF_RAY_PORTAL": _portal,
    "BSDF_TOON": _as_diffuse,
    "BSDF_SHEEN": _as_diffuse,
    "BSDF_HAIR": _as_diffuse,
    "BSDF_HAIR_PRINCIPLED": _as_diffuse,
    "SUBSURFACE_SCATTERING": _subsurface,
    "EMISSION": _emission,
}
