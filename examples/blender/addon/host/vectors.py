# SPDX-License-Identifier: GPL-3.0-or-later
"""Algebra on arrays of vectors, float32 of shape (n, 3)."""

import numpy as np


def dot(a, b):
    """Scalar products: (n,)."""
    return np.einsum("ij,ij->i", a, b)


def normalized(v):
    """Unit vectors."""
    return v / np.sqrt(dot(v, v))[:, None]


def basis(n):
    """Two unit vectors orthogonal to each of the unit vectors n and to each other.

    Source: T. Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017.
    """
    x, y, z = n[:, 0], n[:, 1], n[:, 2]
    sign = np.copysign(np.float32(1), z)
    a = -1 / (sign + z)
    b = x * y * a
    first = np.stack([1 + sign * x * x * a, sign * b, -sign * x], axis=1)
    second = np.stack([b, sign + y * y * a, -y], axis=1)
    return first, second


def around(axis, cosine, turn):
    """Unit directions at angles of the given cosines from the unit vectors `axis`, turned by 2 pi `turn` about them."""
    e, f = basis(axis)
    sine = np.sqrt(np.maximum(1 - cosine * cosine, 0))
    phi = np.float32(2 * np.pi) * turn
    d = (sine * np.cos(phi))[:, None] * e + (sine * np.sin(phi))[:, None] * f + cosine[:, None] * axis
    return normalized(d)


def reflected(d, n):
    """Mirror directions of d at surfaces of unit normal n."""
    return normalized(d - (2 * dot(d, n))[:, None] * n)
