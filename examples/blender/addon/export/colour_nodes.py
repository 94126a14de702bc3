# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader nodes that compute colours from colours, as Cycles does. Values are as in arithmetic."""

import bpy
import numpy as np

from .arithmetic import Elsewhere, as_colour, as_number, clamped, component, joined, mixed, plain
from .math_nodes import divided


def _extremes(colour):
    high, low = colour.max(axis=-1, keepdims=True), colour.min(axis=-1, keepdims=True)
    return high, low, high - low


def _hue(colour, high, span):
    """Hue of colours, from 0 to 1, a sixth of it for each of six pure colours; 0 of grey."""
    r, g, b = (colour[..., k : k + 1] for k in range(3))
    safe = np.where(span != 0, span, 1)
    sixth = np.where(r == high, (g - b) / safe, np.where(g == high, 2 + (b - r) / safe, 4 + (r - g) / safe)) / 6
    return np.where(span != 0, np.where(sixth < 0, sixth + 1, sixth), 0.0)


def to_hsv(colour):
    """Hue, saturation and value of colours, (3,) or (n, 3)."""
    high, _, span = _extremes(colour)
    saturation = divided(span, high)
    hue = np.where(saturation != 0, _hue(colour, high, span), 0.0)
    return np.concatenate([hue, saturation, high], axis=-1)


def from_hsv(hsv):
    """Colours of hue, saturation and value."""
    hue, saturation, value = (hsv[..., k : k + 1] for k in range(3))
    turn = np.where(hue == 1, 0.0, hue) * 6
    sector = np.floor(turn)
    rest = turn - sector
    p, q, t = value * (1 - saturation), value * (1 - saturation * rest), value * (1 - saturation * (1 - rest))
    ways = [(value, t, p), (q, value, p), (p, value, t), (p, q, value), (t, p, value)]
    # A hue beyond 0 to 1 is that of the last sector.
    found = np.concatenate([value, p, q], axis=-1)
    for k, way in enumerate(ways):
        found = np.where(sector == k, np.concatenate(way, axis=-1), found)
    return np.where(saturation != 0, found, value)


def to_hsl(colour):
    """Hue, saturation and lightness of colours."""
    high, low, span = _extremes(colour)
    light = np.minimum(1, (high + low) / 2)
    saturation = np.where(light > 0.5, divided(span, 2 - high - low), divided(span, high + low))
    return np.concatenate([_hue(colour, high, span), np.where(span != 0, saturation, 0.0), light], axis=-1)


def from_hsl(hsl):
    """Colours of hue, saturation and lightness."""
    hue, saturation, light = (hsl[..., k : k + 1] for k in range(3))
    pure = [np.abs(hue * 6 - 3) - 1, 2 - np.abs(hue * 6 - 2), 2 - np.abs(hue * 6 - 4)]
    chroma = (1 - np.abs(2 * light - 1)) * saturation
    return (clamped(np.concatenate(pure, axis=-1)) - 0.5) * chroma + light


_SPLIT = {"RGB": lambda colour: colour, "HSV": to_hsv, "HSL": to_hsl}
_OLD = {"SEPRGB": "RGB", "SEPHSV": "HSV", "COMBRGB": "RGB", "COMBHSV": "HSV"}
_JOIN = {"RGB": lambda colour: colour, "HSV": from_hsv, "HSL": from_hsl}


def _separate_colour(node, output, argument, note):
    # Before Blender 5.0 there is one node for each way, too.
    kind, colour = _OLD.get(node.type, ""), argument(node.inputs[0].identifier)
    return component(_SPLIT[kind or node.mode](as_colour(colour)), list(node.outputs).index(output))


def _combine_colour(node, output, argument, note):
    return _JOIN[_OLD.get(node.type, "") or node.mode](joined([argument(socket.identifier) for socket in node.inputs]))


def _hue_saturation(node, output, argument, note):
    colour = as_colour(argument("Color"))
    hue, saturation, value = (argument(name) for name in ("Hue", "Saturation", "Value"))
    hsv = to_hsv(colour)
    turned = hsv[..., :1] + hue + 0.5
    # Hues below 0 had no such place.
    turned = turned - np.floor(turned) if bpy.app.version >= (5, 0) else np.fmod(turned, 1)
    changed = [turned, clamped(hsv[..., 1:2] * saturation), hsv[..., 2:] * value]
    return np.maximum(mixed(colour, from_hsv(joined(changed)), argument("Fac")), 0)


def _gamma(node, output, argument, note):
    colour, gamma = as_colour(argument("Color")), argument("Gamma")
    positive = colour > 0
    return np.where(gamma == 0, 1.0, np.where(positive, np.power(np.where(positive, colour, 1), gamma), colour))


def _invert(node, output, argument, note):
    colour = as_colour(argument("Color"))
    return mixed(colour, 1 - colour, argument("Fac"))


def _bright_contrast(node, output, argument, note):
    bright, contrast = argument("Bright"), argument("Contrast")
    return np.maximum((1 + contrast) * as_colour(argument("Color")) + (bright - contrast * 0.5), 0)


def _to_grey(node, output, argument, note):
    return as_number(as_colour(argument("Color")))


def _dodge(a, b, f):
    rest = 1 - f * b
    return np.where(a != 0, np.where(rest <= 0, 1.0, np.minimum(a / np.where(rest > 0, rest, 1), 1)), 0.0)


def _burn(a, b, f):
    rest = 1 - f + f * b
    return np.where(rest <= 0, 0.0, np.clip(1 - (1 - a) / np.where(rest > 0, rest, 1), 0, 1))


def _overlay(a, b, f):
    return np.where(a < 0.5, a * (1 - f + 2 * f * b), 1 - (1 - f + 2 * f * (1 - b)) * (1 - a))


def _with(hsv, **channels):
    """Colours of hue, saturation and value of which some are others."""
    return from_hsv(np.concatenate([channels.get(name, hsv[..., k : k + 1]) for k, name in enumerate("hsv")], axis=-1))


def _by_hue(a, b, f):
    other = to_hsv(b)
    return np.where(other[..., 1:2] != 0, mixed(a, _with(to_hsv(a), h=other[..., :1]), f), a)


def _by_saturation(a, b, f):
    own, other = to_hsv(a), to_hsv(b)
    return np.where(own[..., 1:2] != 0, _with(own, s=mixed(own[..., 1:2], other[..., 1:2], f)), a)


def _by_value(a, b, f):
    own, other = to_hsv(a), to_hsv(b)
    return _with(own, v=mixed(own[..., 2:], other[..., 2:], f))


def _by_colour(a, b, f):
    other = to_hsv(b)
    return np.where(other[..., 1:2] != 0, mixed(a, _with(to_hsv(a), h=other[..., :1], s=other[..., 1:2]), f), a)


#: Ways to mix colours a and b, float64 (n, 3) both, by a share of b, (n, 1).
_BLEND = {
    "MIX": mixed,
    "ADD": lambda a, b, f: a + f * b,
    "MULTIPLY": lambda a, b, f: a * (1 - f + f * b),
    "SUBTRACT": lambda a, b, f: a - f * b,
    "SCREEN": lambda a, b, f: 1 - (1 - f + f * (1 - b)) * (1 - a),
    "OVERLAY": _overlay,
    "DIVIDE": lambda a, b, f: np.where(b != 0, (1 - f) * a + f * a / np.where(b != 0, b, 1), a),
    "DIFFERENCE": lambda a, b, f: mixed(a, np.abs(a - b), f),
    "EXCLUSION": lambda a, b, f: np.maximum(mixed(a, a + b - 2 * a * b, f), 0),
    "DARKEN": lambda a, b, f: mixed(a, np.minimum(a, b), f),
    "LIGHTEN": lambda a, b, f: mixed(a, np.maximum(a, b), f),
    "DODGE": _dodge,
    "BURN": _burn,
    "HUE": _by_hue,
    "SATURATION": _by_saturation,
    "VALUE": _by_value,
    "COLOR": _by_colour,
    "SOFT_LIGHT": lambda a, b, f: (1 - f) * a + f * ((1 - a) * b * a + a * (1 - (1 - b) * (1 - a))),
    "LINEAR_LIGHT": lambda a, b, f: a + f * (2 * b - 1),
}


def _blended(node, a, b, factor, is_clamped):
    if node.blend_type not in _BLEND:
        raise Elsewhere(f"{node.name} ({node.blend_type.replace('_', ' ').lower()})")
    of = [as_colour(a), as_colour(b), np.atleast_1d(factor)]
    varies = any(value.ndim == 2 for value in of)
    rows = max(len(value) if value.ndim == 2 else 1 for value in of)
    result = _BLEND[node.blend_type](*(np.broadcast_to(value, (rows, value.shape[-1])) for value in of))
    result = clamped(result) if is_clamped else result
    return result if varies else result[0]


def _mix(node, output, argument, note):
    if node.data_type not in ("FLOAT", "VECTOR", "RGBA"):
        raise Elsewhere(node.name)
    kind = {"FLOAT": "Float", "VECTOR": "Vector", "RGBA": "Color"}[node.data_type]
    each = node.data_type == "VECTOR" and node.factor_mode == "NON_UNIFORM"
    factor = as_colour(argument("Factor_Vector")) if each else argument("Factor_Float")
    factor = clamped(factor) if node.clamp_factor else factor
    a, b = argument(f"A_{kind}"), argument(f"B_{kind}")
    if node.data_type == "RGBA":
        return _blended(node, a, b, factor, node.clamp_result)
    return plain(mixed(a, b, factor))


def _mix_rgb(node, output, argument, note):
    return _blended(node, argument("Color1"), argument("Color2"), clamped(argument("Fac")), node.use_clamp)


#: As arithmetic.COMPUTED.
COLOURS = {
    "MIX": _mix,
    "MIX_RGB": _mix_rgb,
    "SEPARATE_COLOR": _separate_colour,
    "COMBINE_COLOR": _combine_colour,
    "SEPRGB": _separate_colour,
    "SEPHSV": _separate_colour,
    "COMBRGB": _combine_colour,
    "COMBHSV": _combine_colour,
    "HUE_SAT": _hue_saturation,
    "GAMMA": _gamma,
    "INVERT": _invert,
    "BRIGHTCONTRAST": _bright_contrast,
    "RGBTOBW": _to_grey,
}
