# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader nodes that compute values from values.

A number is a float, or float64 (n, 1) where it varies over n places; a colour or vector is float64 (3,), or (n, 3).
"""

import numpy as np

from .blackbody import blackbody


class NotConstant(Exception):
    """A value that is not known; the message names where it comes from."""


class Elsewhere(NotConstant):
    """A value that is not computed here; asked_nodes has Blender compute it."""


#: Rec. 709, as Blender turns colours into numbers.
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def is_number(value):
    """Whether a value is no colour and no vector."""
    return np.ndim(value) == 0 or value.shape[-1] == 1


def as_number(value, is_vector=False):
    """A value as a number: the luminance of a colour, the mean of a vector."""
    if is_number(value):
        return value
    weights = np.full(3, 1 / 3) if is_vector else LUMINANCE
    return float(value @ weights) if np.ndim(value) == 1 else (value @ weights)[:, None]


def as_colour(value):
    """A value as a colour or vector."""
    if np.ndim(value) == 0:
        return np.full(3, float(value))
    return np.repeat(value, 3, axis=1) if is_number(value) else np.asarray(value, np.float64)


def _clamped(value):
    return np.clip(value, 0.0, 1.0)


def _divided(a, b):
    # As Blender: what cannot be computed is 0.
    return np.where(b != 0, a / np.where(b != 0, b, 1), 0.0)


def _power(a, b):
    whole = b == np.round(b)
    defined = (a > 0) | (whole & ((a != 0) | (b > 0)))
    result = np.power(np.where(defined, a, 1), np.where(defined, b, 1))
    return np.where(defined, result, b == 0) + 0.0


def _wave(value, period):
    safe = np.where(period != 0, period, 1)
    return np.where(period != 0, np.abs((value / (2 * safe) - np.floor(value / (2 * safe))) * 2 * safe - safe), 0) * 1.0


#: Operations of the Math node on numbers a, b and c; others are left to the report.
_MATH = {
    "ADD": lambda a, b, c: a + b,
    "SUBTRACT": lambda a, b, c: a - b,
    "MULTIPLY": lambda a, b, c: a * b,
    "DIVIDE": lambda a, b, c: _divided(a, b),
    "MULTIPLY_ADD": lambda a, b, c: a * b + c,
    "POWER": lambda a, b, c: _power(a, b),
    "SQRT": lambda a, b, c: np.sqrt(np.maximum(a, 0)),
    "ABSOLUTE": lambda a, b, c: np.abs(a),
    "EXPONENT": lambda a, b, c: np.exp(a),
    "MINIMUM": lambda a, b, c: np.minimum(a, b),
    "MAXIMUM": lambda a, b, c: np.maximum(a, b),
    "LESS_THAN": lambda a, b, c: (a < b) + 0.0,
    "GREATER_THAN": lambda a, b, c: (a > b) + 0.0,
    "SIGN": lambda a, b, c: np.sign(a),
    "FLOOR": lambda a, b, c: np.floor(a),
    "CEIL": lambda a, b, c: np.ceil(a),
    "FRACT": lambda a, b, c: a - np.floor(a),
    "PINGPONG": lambda a, b, c: _wave(a - b, b),
    "SINE": lambda a, b, c: np.sin(a),
    "COSINE": lambda a, b, c: np.cos(a),
}

#: Operations of the Vector Math node on vectors a and b.
_VECTOR_MATH = {
    "ADD": lambda a, b: a + b,
    "SUBTRACT": lambda a, b: a - b,
    "MULTIPLY": lambda a, b: a * b,
    "DIVIDE": _divided,
    "MINIMUM": np.minimum,
    "MAXIMUM": np.maximum,
    "ABSOLUTE": lambda a, b: np.abs(a),
    "DOT_PRODUCT": lambda a, b: _sum(a * b),
    "LENGTH": lambda a, b: np.sqrt(_sum(a * a)),
    "DISTANCE": lambda a, b: np.sqrt(_sum((a - b) ** 2)),
}


def _sum(products):
    return products.sum(axis=-1, keepdims=np.ndim(products) > 1)


def _value(node, output, argument, note):
    return float(output.default_value)


def _rgb(node, output, argument, note):
    return np.array(output.default_value[:3], np.float64)


def _operation(node, operations):
    operation = operations.get(node.operation)
    if operation is None:
        raise NotConstant(f"{node.name} ({node.operation.replace('_', ' ').lower()})")
    return operation


def _math(node, output, argument, note):
    operation = _operation(node, _MATH)
    with np.errstate(all="ignore"):
        result = operation(argument("Value"), argument("Value_001"), argument("Value_002"))
    if node.use_clamp:
        result = _clamped(result)
    return float(result) if np.ndim(result) == 0 else result


def _vector_math(node, output, argument, note):
    operation = _operation(node, _VECTOR_MATH)
    if node.operation == "ABSOLUTE" or node.operation == "LENGTH":
        return operation(argument("Vector"), None)
    return operation(argument("Vector"), argument("Vector_001"))


def _scale(node, output, argument, note):
    return argument("Vector") * argument("Scale")


def _mix(node, output, argument, note):
    if node.data_type not in ("FLOAT", "RGBA") or (node.data_type == "RGBA" and node.blend_type not in _BLEND):
        raise NotConstant(node.name)
    kind = {"FLOAT": "Float", "RGBA": "Color"}[node.data_type]
    factor = argument("Factor_Float")
    factor = _clamped(factor) if node.clamp_factor else factor
    a, b = argument(f"A_{kind}"), argument(f"B_{kind}")
    if node.data_type == "FLOAT":
        return (1 - factor) * a + factor * b
    result = _BLEND[node.blend_type](a, b, factor)
    return _clamped(result) if node.clamp_result else result


def _mix_rgb(node, output, argument, note):
    if node.blend_type not in _BLEND:
        raise NotConstant(node.name)
    result = _BLEND[node.blend_type](argument("Color1"), argument("Color2"), _clamped(argument("Fac")))
    return _clamped(result) if node.use_clamp else result


_BLEND = {
    "MIX": lambda a, b, f: (1 - f) * a + f * b,
    "ADD": lambda a, b, f: a + f * b,
    "MULTIPLY": lambda a, b, f: a * (1 - f + f * b),
    "SUBTRACT": lambda a, b, f: a - f * b,
}


def _map_range(node, output, argument, note):
    if node.data_type != "FLOAT" or node.interpolation_type == "STEPPED":
        raise NotConstant(f"{node.name} ({node.data_type}, {node.interpolation_type})".lower())
    low, high = argument("From Min"), argument("From Max")
    to_low, to_high = argument("To Min"), argument("To Max")
    share = _divided(argument("Value") - low, high - low)
    if node.interpolation_type == "LINEAR":
        # Values of the two ends are not those of what lies beyond, unless that is asked for.
        share = _clamped(share) if node.clamp else share
    else:
        share = _clamped(share)
        smoother = node.interpolation_type == "SMOOTHERSTEP"
        share = share**3 * (share * (6 * share - 15) + 10) if smoother else share * share * (3 - 2 * share)
    result = np.where(low == high, 0.0, to_low + share * (to_high - to_low))
    return float(result) if np.ndim(result) == 0 else result


def _clamp(node, output, argument, note):
    low, high = argument("Min"), argument("Max")
    if node.clamp_type == "RANGE":
        low, high = np.minimum(low, high), np.maximum(low, high)
    result = np.minimum(np.maximum(argument("Value"), low), high)
    return float(result) if np.ndim(result) == 0 else result


#: Values of a colour ramp between which Cycles interpolates.
_RAMP = 256


def _ramp(node, output, argument, note):
    ramp, at = node.color_ramp, argument("Fac")
    if np.ndim(at) == 0:
        colour = np.array(ramp.evaluate(at), np.float64)
    else:
        table = np.array([ramp.evaluate(i / (_RAMP - 1)) for i in range(_RAMP)], np.float64)
        place = np.clip(np.nan_to_num(at[:, 0]), 0, 1) * (_RAMP - 1)
        low = place.astype(int)
        rest = np.float64(0) if ramp.interpolation == "CONSTANT" else (place - low)[:, None]
        colour = (1 - rest) * table[low] + rest * table[np.minimum(low + 1, _RAMP - 1)]
    if output.identifier == "Alpha":
        return float(colour[3]) if colour.ndim == 1 else colour[:, 3:]
    return colour[..., :3]


def _blackbody(node, output, argument, note):
    return blackbody(as_number(argument("Temperature")))


def _light_path(node, output, argument, note):
    if not output.identifier.startswith("Is "):
        raise NotConstant(node.name)
    # Light is traced from the lights here: glass must be glass for light that reaches the fog, whatever it pretends to
    # be for shadow rays.
    note(f"Light Path, {output.name}", "0, as if the answer were no, for all light")
    return 0.0


def _fresnel(node, output, argument, note):
    ior = np.maximum(argument("IOR"), 1e-5)
    note("Fresnel as a factor", "its value at normal incidence, for all directions")
    return ((ior - 1) / (ior + 1)) ** 2


def _layer_weight(node, output, argument, note):
    note("Layer Weight as a factor", "its value at normal incidence, for all directions")
    if output.identifier == "Facing":
        return 0.0
    eta = np.maximum(1 - argument("Blend"), 1e-5)
    return ((1 - eta) / (1 + eta)) ** 2


#: By type of node: function of the node, its output, the values of its inputs by identifier, and one for notes.
COMPUTED = {
    "VALUE": _value,
    "RGB": _rgb,
    "MATH": _math,
    "VECT_MATH": lambda node, *rest: (_scale if node.operation == "SCALE" else _vector_math)(node, *rest),
    "MIX": _mix,
    "MIX_RGB": _mix_rgb,
    "MAP_RANGE": _map_range,
    "CLAMP": _clamp,
    "VALTORGB": _ramp,
    "BLACKBODY": _blackbody,
    "LIGHT_PATH": _light_path,
    "FRESNEL": _fresnel,
    "LAYER_WEIGHT": _layer_weight,
}
