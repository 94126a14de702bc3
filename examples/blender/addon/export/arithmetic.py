# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader nodes that compute values from values.

A number is a float, or float64 (n, 1) where it varies over n places; a colour or vector is float64 (3,), or (n, 3).
"""

import numpy as np

from .blackbody import blackbody
from .working_space import luminance


class NotConstant(Exception):
    """A value that is not known; the message names where it comes from."""


class Elsewhere(NotConstant):
    """A value that is not computed here; asked_nodes has Blender compute it."""


def is_number(value):
    """Whether a value is no colour and no vector."""
    return np.ndim(value) == 0 or value.shape[-1] == 1


def as_number(value, is_vector=False):
    """A value as a number: the luminance of a colour, the mean of a vector."""
    if is_number(value):
        return value
    weights = np.full(3, 1 / 3) if is_vector else luminance()
    return float(value @ weights) if np.ndim(value) == 1 else (value @ weights)[:, None]


def as_colour(value):
    """A value as a colour or vector."""
    if np.ndim(value) == 0:
        return np.full(3, float(value))
    return np.repeat(value, 3, axis=1) if is_number(value) else np.asarray(value, np.float64)


def clamped(value):
    """A value between 0 and 1."""
    return np.clip(value, 0.0, 1.0)


def plain(value):
    """A value of one place as a float or (3,), whatever arrays it was computed with."""
    return float(np.ravel(value)[0]) if np.size(value) == 1 and np.ndim(value) < 2 else np.asarray(value, np.float64)


def mixed(a, b, share):
    """a where the share of b is 0, b where it is 1."""
    return (1 - share) * a + share * b


def total(products):
    """Sums over channels: a number."""
    return products.sum(axis=-1, keepdims=True)


def unit(vector):
    """A vector of length 1 along another; 0 if that is."""
    length = np.sqrt(total(vector * vector))
    return vector / np.where(length > 0, length, 1)


def component(value, k):
    """A channel of a colour or vector as a number."""
    return float(value[k]) if value.ndim == 1 else value[:, k : k + 1]


def joined(numbers):
    """Three numbers as a colour or vector."""
    rows = max(len(value) if np.ndim(value) == 2 else 1 for value in numbers)
    made = np.concatenate([np.broadcast_to(value, (rows, 1)) for value in numbers], axis=1)
    return made if any(np.ndim(value) == 2 for value in numbers) else made[0]


def _value(node, output, argument, note):
    return float(output.default_value)


def _rgb(node, output, argument, note):
    return np.array(output.default_value[:3], np.float64)


def _blackbody(node, output, argument, note):
    return blackbody(as_number(argument("Temperature")))


def _light_path(node, output, argument, note):
    if not output.identifier.startswith("Is "):
        raise NotConstant(node.name)
    # No ray that meets what lights fog comes from the camera: that has met the fog before.
    if output.identifier != "Is Camera Ray":
        note(f"Light Path, {output.name}", "0, as if the answer were no, for all light", in_fog=True)
    return 0.0


def _fresnel(node, output, argument, note):
    ior = np.maximum(argument("IOR"), 1e-5)
    note("Fresnel as a factor", "its value at normal incidence, for all directions", in_fog=True)
    return ((ior - 1) / (ior + 1)) ** 2


def _layer_weight(node, output, argument, note):
    note("Layer Weight as a factor", "its value at normal incidence, for all directions", in_fog=True)
    if output.identifier == "Facing":
        return 0.0
    eta = np.maximum(1 - argument("Blend"), 1e-5)
    return ((1 - eta) / (1 + eta)) ** 2


#: By type of node: function of the node, its output, the values of its inputs by identifier, and one for notes.
COMPUTED = {
    "VALUE": _value,
    "RGB": _rgb,
    "BLACKBODY": _blackbody,
    "LIGHT_PATH": _light_path,
    "FRESNEL": _fresnel,
    "LAYER_WEIGHT": _layer_weight,
}
