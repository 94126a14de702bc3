# SPDX-License-Identifier: GPL-3.0-or-later
"""What surfaces do to rays: which lobes there are, how much light each takes, and where it sends it."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from .vectors import basis, dot, normalized, reflected

#: GGX's alpha below which a surface is perfectly smooth.
SMOOTH = 1e-3


class Lobe(IntEnum):
    """The ways on from a surface."""

    TRANSPARENT = 0
    DIFFUSE = 1
    TRANSLUCENT = 2
    METAL = 3
    GLASS_REFLECTION = 4
    GLASS_TRANSMISSION = 5
    COAT = 6


#: Lobes that an eye path follows.
SPECULAR = (Lobe.TRANSPARENT, Lobe.METAL, Lobe.GLASS_REFLECTION, Lobe.GLASS_TRANSMISSION, Lobe.COAT)


@dataclass
class Encounter:
    """Rays at the surfaces that they have hit."""

    direction: np.ndarray
    hit: np.ndarray
    material: np.ndarray
    #: Whether the ray came from the side that the triangle's normal points to.
    front: np.ndarray
    #: Geometric and shading normals, turned against the ray; the latter is a microfacet's on a rough surface.
    geometric: np.ndarray
    shading: np.ndarray
    facet: np.ndarray
    #: Refractive index on this side over that on the other.
    eta: np.ndarray
    #: Cosines of incidence and refraction at the facet; the latter is 0 for total reflection.
    cos_i: np.ndarray
    cos_t: np.ndarray
    #: Share that Fresnel's equations reflect.
    fresnel: np.ndarray

    def take(self, chosen):
        """Some of them."""
        return Encounter(*(getattr(self, name)[chosen] for name in self.__dataclass_fields__))


def meet(direction, hit, materials, xi):
    """The Encounter of rays with hits, none of which is a miss. xi: uniform numbers for microfacets, (n, 2)."""
    material = materials[hit["material"]]
    front = dot(direction, hit["geometric_normal"]) < 0
    against = np.where(front, np.float32(1), np.float32(-1))[:, None]
    geometric = against * hit["geometric_normal"]
    shading = against * hit["normal"]
    # Where smoothing would turn the surface's side, the triangle decides.
    wrong = dot(direction, shading) >= -1e-4
    shading[wrong] = geometric[wrong]
    facet = shading.copy()
    rough = np.flatnonzero(material["roughness"] >= SMOOTH)
    if len(rough):
        facet[rough] = _visible_facet(direction[rough], shading[rough], material["roughness"][rough], xi[rough])
    ior = material["ior"]
    eta = np.where(front, 1 / ior, ior).astype(np.float32)
    cos_i = np.clip(-dot(direction, facet), 1e-6, 1)
    fresnel, cos_t = _fresnel(cos_i, eta)
    return Encounter(direction, hit, material, front, geometric, shading, facet, eta, cos_i, cos_t, fresnel)


def _fresnel(cos_i, eta):
    """(share of unpolarised light that a dielectric boundary reflects, cosine of refraction, 0 for total reflection)."""
    cos2_t = 1 - eta * eta * (1 - cos_i * cos_i)
    cos_t = np.sqrt(np.maximum(cos2_t, 0))
    s, p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t), (cos_i - eta * cos_t) / (cos_i + eta * cos_t)
    return np.where(cos2_t > 0, 0.5 * (s * s + p * p), np.float32(1)), cos_t


def _visible_facet(direction, normal, alpha, xi):
    """Normals of GGX microfacets in proportion to how much of them a ray sees.

    Source: E. Heitz, "Sampling the GGX Distribution of Visible Normals", JCGT 7(4), 2018.
    """
    e, f = basis(normal)
    view = np.stack([-dot(direction, e), -dot(direction, f), -dot(direction, normal)], axis=1)
    a = alpha[:, None]
    stretched = normalized(np.concatenate([a * view[:, :2], view[:, 2:]], axis=1))
    across, other = basis(stretched)
    r, phi = np.sqrt(xi[:, 0]), np.float32(2 * np.pi) * xi[:, 1]
    x, y = r * np.cos(phi), r * np.sin(phi)
    # The part of the disk that the stretched normals' hemisphere covers: squeezed along the direction of the normal.
    up = np.broadcast_to(np.array([0, 0, 1], np.float32), stretched.shape)
    lean = 0.5 * (1 + stretched[:, 2])
    # `across` has to be horizontal: turn the disk's axes so that y points up.
    horizontal = np.cross(up, stretched)
    length = np.sqrt(dot(horizontal, horizontal))
    flat = length > 1e-6
    across = np.where(flat[:, None], horizontal / np.maximum(length, 1e-6)[:, None], across)
    other = np.cross(stretched, across)
    y = (1 - lean) * np.sqrt(np.maximum(1 - x * x, 0)) + lean * y
    z = np.sqrt(np.maximum(1 - x * x - y * y, 0))
    h = x[:, None] * across + y[:, None] * other + z[:, None] * stretched
    h = normalized(np.concatenate([a * h[:, :2], np.maximum(h[:, 2:], 1e-6)], axis=1))
    return normalized(h[:, :1] * e + h[:, 1:2] * f + h[:, 2:] * normal)


def weights(m: Encounter):
    """What share of the light each lobe takes, per channel: float32 (lobes, n, 3). They add up to at most 1 for real materials."""
    material, reflects = m.material, m.fresnel[:, None]
    out = np.zeros((len(Lobe), len(m.front), 3), np.float32)
    out[Lobe.TRANSPARENT] = material["transparent"]
    # A coat is as thin as the wall: it is met from outside on both sides.
    coat = material["coat"] * _fresnel(m.cos_i, 1 / material["ior"])[0][:, None]
    out[Lobe.COAT] = coat
    out[Lobe.DIFFUSE] = material["diffuse"] * (1 - coat)
    out[Lobe.TRANSLUCENT] = material["translucent"]
    grazing = ((1 - m.cos_i) ** 5)[:, None]
    out[Lobe.METAL] = material["metal"] + (material["edge"] - material["metal"]) * grazing
    out[Lobe.GLASS_REFLECTION] = material["glass_reflection"] * reflects
    out[Lobe.GLASS_TRANSMISSION] = material["glass_transmission"] * (1 - reflects)
    return out


def follow(m: Encounter, lobe, xi):
    """Directions of rays that take a lobe: unit. `lobe` is one Lobe; xi (n, 2) is used by diffuse lobes."""
    if lobe == Lobe.TRANSPARENT:
        return m.direction.copy()
    if lobe in (Lobe.DIFFUSE, Lobe.TRANSLUCENT):
        normal = m.shading if lobe == Lobe.DIFFUSE else -m.shading
        e, f = basis(normal)
        r, phi = np.sqrt(xi[:, 0]), np.float32(2 * np.pi) * xi[:, 1]
        height = np.sqrt(np.maximum(1 - xi[:, 0], np.float32(1e-12)))
        d = (r * np.cos(phi))[:, None] * e + (r * np.sin(phi))[:, None] * f + height[:, None] * normal
        return _on_side(normalized(d), m.geometric, 1 if lobe == Lobe.DIFFUSE else -1)
    if lobe == Lobe.GLASS_TRANSMISSION:
        d = m.eta[:, None] * m.direction + (m.eta * m.cos_i - m.cos_t)[:, None] * m.facet
        return _on_side(normalized(d), m.geometric, -1)
    return _on_side(reflected(m.direction, m.facet), m.geometric, 1)


def _on_side(d, geometric, side):
    """A shading normal or a facet may send a ray to the wrong side of the true surface: it is mirrored back."""
    wrong = side * dot(d, geometric) < 0
    d[wrong] = reflected(d[wrong], geometric[wrong])
    return d


def leave(m: Encounter, direction):
    """(start, normal) of rays that leave along `direction`: off the surface, and its normal on the side they leave to."""
    side = np.where(dot(direction, m.geometric) < 0, np.float32(-1), np.float32(1))[:, None]
    normal = side * m.geometric
    return m.hit["position"] + m.hit["offset"][:, None] * normal, normal
