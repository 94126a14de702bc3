# SPDX-License-Identifier: GPL-3.0-or-later
"""The Math and Vector Math nodes, and others that turn and map numbers and vectors, as Cycles computes them.

Values are as in arithmetic. What cannot be computed, such as a root of a negative number, is 0.
"""

import numpy as np
from mathutils import Euler

from .arithmetic import Elsewhere, as_colour, clamped, component, joined, plain, total, unit

#: Numbers that differ by less are equal.
_EPSILON = 1.1920929e-07


def divided(a, b):
    """a / b; 0 where b is 0."""
    return np.where(b != 0, a / np.where(b != 0, b, 1), 0.0)


def _power(a, b):
    whole = b == np.round(b)
    defined = (a > 0) | (whole & ((a != 0) | (b > 0)))
    result = np.power(np.where(defined, a, 1), np.where(defined, b, 1))
    return np.where(defined, result, b == 0) + 0.0


def _logarithm(a, b):
    defined = (a > 0) & (b > 0)
    return np.where(defined, divided(np.log(np.where(defined, a, 1)), np.log(np.where(defined, b, 1))), 0.0)


def _zigzag(value, period):
    safe = np.where(period != 0, period, 1)
    return np.where(period != 0, np.abs((value / (2 * safe) - np.floor(value / (2 * safe))) * 2 * safe - safe), 0) * 1.0


def _wrapped(value, high, low):
    span = high - low
    return np.where(span != 0, value - span * np.floor((value - low) / np.where(span != 0, span, 1)), low)


def _remainder(a, b):
    return np.where(b != 0, np.fmod(a, np.where(b != 0, b, 1)), 0.0)


def _smooth_minimum(a, b, c):
    near = np.maximum(c - np.abs(a - b), 0) / np.where(c != 0, c, 1)
    return np.where(c != 0, np.minimum(a, b) - near**3 * c / 6, np.minimum(a, b))


def _snapped(a, b):
    return np.floor(divided(a, b)) * b


#: Operations of the Math node on numbers a, b and c.
_MATH = {
    "ADD": lambda a, b, c: a + b,
    "SUBTRACT": lambda a, b, c: a - b,
    "MULTIPLY": lambda a, b, c: a * b,
    "DIVIDE": lambda a, b, c: divided(a, b),
    "MULTIPLY_ADD": lambda a, b, c: a * b + c,
    "POWER": lambda a, b, c: _power(a, b),
    "LOGARITHM": lambda a, b, c: _logarithm(a, b),
    "SQRT": lambda a, b, c: np.sqrt(np.maximum(a, 0)),
    "INVERSE_SQRT": lambda a, b, c: np.where(a > 0, 1 / np.sqrt(np.where(a > 0, a, 1)), 0.0),
    "ABSOLUTE": lambda a, b, c: np.abs(a),
    "EXPONENT": lambda a, b, c: np.exp(a),
    "MINIMUM": lambda a, b, c: np.minimum(a, b),
    "MAXIMUM": lambda a, b, c: np.maximum(a, b),
    "LESS_THAN": lambda a, b, c: (a < b) + 0.0,
    "GREATER_THAN": lambda a, b, c: (a > b) + 0.0,
    "SIGN": lambda a, b, c: np.sign(a),
    "COMPARE": lambda a, b, c: ((a == b) | (np.abs(a - b) <= np.maximum(c, _EPSILON))) + 0.0,
    "SMOOTH_MIN": _smooth_minimum,
    "SMOOTH_MAX": lambda a, b, c: -_smooth_minimum(-a, -b, c),
    "ROUND": lambda a, b, c: np.floor(a + 0.5),
    "FLOOR": lambda a, b, c: np.floor(a),
    "CEIL": lambda a, b, c: np.ceil(a),
    "TRUNC": lambda a, b, c: np.trunc(a),
    "FRACT": lambda a, b, c: a - np.floor(a),
    "MODULO": lambda a, b, c: _remainder(a, b),
    "FLOORED_MODULO": lambda a, b, c: np.where(b != 0, a - np.floor(divided(a, b)) * b, 0.0),
    "WRAP": _wrapped,
    "SNAP": lambda a, b, c: _snapped(a, b),
    "PINGPONG": lambda a, b, c: _zigzag(a - b, b),
    "SINE": lambda a, b, c: np.sin(a),
    "COSINE": lambda a, b, c: np.cos(a),
    "TANGENT": lambda a, b, c: np.tan(a),
    "ARCSINE": lambda a, b, c: np.arcsin(np.clip(a, -1, 1)),
    "ARCCOSINE": lambda a, b, c: np.arccos(np.clip(a, -1, 1)),
    "ARCTANGENT": lambda a, b, c: np.arctan(a),
    "ARCTAN2": lambda a, b, c: np.arctan2(a, b),
    "SINH": lambda a, b, c: np.sinh(a),
    "COSH": lambda a, b, c: np.cosh(a),
    "TANH": lambda a, b, c: np.tanh(a),
    "RADIANS": lambda a, b, c: np.radians(a),
    "DEGREES": lambda a, b, c: np.degrees(a),
}


def _dot(a, b):
    return total(a * b)


def _refracted(a, b, eta):
    normal, cosine = unit(b), _dot(unit(b), a)
    rest = 1 - eta * eta * (1 - cosine * cosine)
    return np.where(rest < 0, 0.0, eta * a - (eta * cosine + np.sqrt(np.maximum(rest, 0))) * normal)


#: Operations of the Vector Math node on vectors a, b and c, and the number s.
_VECTOR_MATH = {
    "ADD": lambda a, b, c, s: a + b,
    "SUBTRACT": lambda a, b, c, s: a - b,
    "MULTIPLY": lambda a, b, c, s: a * b,
    "DIVIDE": lambda a, b, c, s: divided(a, b),
    "MULTIPLY_ADD": lambda a, b, c, s: a * b + c,
    "CROSS_PRODUCT": lambda a, b, c, s: np.cross(a, b),
    "PROJECT": lambda a, b, c, s: divided(_dot(a, b), _dot(b, b)) * b,
    "REFLECT": lambda a, b, c, s: a - 2 * unit(b) * _dot(a, unit(b)),
    "REFRACT": lambda a, b, c, s: _refracted(a, b, s),
    "FACEFORWARD": lambda a, b, c, s: np.where(_dot(c, b) < 0, a, -a),
    "DOT_PRODUCT": lambda a, b, c, s: _dot(a, b),
    "DISTANCE": lambda a, b, c, s: np.sqrt(_dot(a - b, a - b)),
    "LENGTH": lambda a, b, c, s: np.sqrt(_dot(a, a)),
    "SCALE": lambda a, b, c, s: a * s,
    "NORMALIZE": lambda a, b, c, s: unit(a),
    "ABSOLUTE": lambda a, b, c, s: np.abs(a),
    "POWER": lambda a, b, c, s: _power(a, b),
    "SIGN": lambda a, b, c, s: np.sign(a),
    "MINIMUM": lambda a, b, c, s: np.minimum(a, b),
    "MAXIMUM": lambda a, b, c, s: np.maximum(a, b),
    "FLOOR": lambda a, b, c, s: np.floor(a),
    "CEIL": lambda a, b, c, s: np.ceil(a),
    "FRACTION": lambda a, b, c, s: a - np.floor(a),
    "MODULO": lambda a, b, c, s: _remainder(a, b),
    "WRAP": lambda a, b, c, s: _wrapped(a, b, c),
    "SNAP": lambda a, b, c, s: _snapped(a, b),
    "SINE": lambda a, b, c, s: np.sin(a),
    "COSINE": lambda a, b, c, s: np.cos(a),
    "TANGENT": lambda a, b, c, s: np.tan(a),
}


def _math(node, output, argument, note):
    if node.operation not in _MATH:
        raise Elsewhere(f"{node.name} ({node.operation.replace('_', ' ').lower()})")
    result = _MATH[node.operation](argument("Value"), argument("Value_001"), argument("Value_002"))
    return plain(clamped(result) if node.use_clamp else result)


def _vector_math(node, output, argument, note):
    if node.operation not in _VECTOR_MATH:
        raise Elsewhere(f"{node.name} ({node.operation.replace('_', ' ').lower()})")
    enabled = {s.identifier for s in node.inputs if s.enabled}
    vectors = [as_colour(argument(name)) if name in enabled else np.zeros(3) for name in ("Vector", "Vector_001", "Vector_002")]
    return plain(_VECTOR_MATH[node.operation](*vectors, argument("Scale") if "Scale" in enabled else 1.0))


#: What is made of a share of the way from one end of a range to the other.
_SMOOTHED = {"SMOOTHSTEP": lambda t: t * t * (3 - 2 * t), "SMOOTHERSTEP": lambda t: t**3 * (t * (6 * t - 15) + 10)}


def _map_range(node, output, argument, note):
    names = ("Value", "From Min", "From Max", "To Min", "To Max", "Steps")
    if node.data_type == "FLOAT_VECTOR":
        names = "Vector", *(f"{name.replace(' ', '_')}_FLOAT3" for name in names[1:])
    stepped = node.interpolation_type == "STEPPED"
    value, low, high, to_low, to_high = (argument(name) for name in names[:5])
    share = divided(value - low, high - low)
    if stepped:
        steps = argument(names[5])
        share = np.where(steps > 0, divided(np.floor(share * (steps + 1)), steps), 0.0)
    elif node.interpolation_type in _SMOOTHED:
        share = _SMOOTHED[node.interpolation_type](clamped(share))
    result = to_low + share * (to_high - to_low)
    if node.data_type == "FLOAT":
        result = np.where(low == high, 0.0, result)
    if node.clamp:
        # Values of the two ends are not those of what lies beyond, unless that is asked for.
        result = np.clip(result, np.minimum(to_low, to_high), np.maximum(to_low, to_high))
    return plain(result)


def _clamp(node, output, argument, note):
    low, high = argument("Min"), argument("Max")
    if node.clamp_type == "RANGE":
        low, high = np.minimum(low, high), np.maximum(low, high)
    return plain(np.minimum(np.maximum(argument("Value"), low), high))


def _normal(node, output, argument, note):
    direction = unit(np.array(node.outputs["Normal"].default_value, np.float64))
    return direction if output.identifier == "Normal" else plain(_dot(unit(as_colour(argument("Normal"))), direction))


#: Axes by kind of a Vector Rotate node.
_AXES = {"X_AXIS": (1.0, 0.0, 0.0), "Y_AXIS": (0.0, 1.0, 0.0), "Z_AXIS": (0.0, 0.0, 1.0)}


def _rotated(node, output, argument, note):
    centre = as_colour(argument("Center"))
    vector = as_colour(argument("Vector")) - centre
    if node.rotation_type == "EULER_XYZ":
        rotation = as_colour(argument("Rotation"))
        if rotation.ndim > 1:
            raise Elsewhere(f"{node.name}, whose rotation varies")
        turn = np.array(Euler(rotation, "XYZ").to_matrix(), np.float64)
        return vector @ (turn if node.invert else turn.T) + centre
    axis = np.array(_AXES[node.rotation_type]) if node.rotation_type in _AXES else as_colour(argument("Axis"))
    angle = argument("Angle") * (-1 if node.invert else 1)
    along, cosine = unit(axis), np.cos(angle)
    turned = vector * cosine + np.cross(along, vector) * np.sin(angle) + along * _dot(along, vector) * (1 - cosine)
    return np.where(_dot(axis, axis) != 0, turned, vector) + centre


def _separated(node, output, argument, note):
    return component(as_colour(argument("Vector")), "XYZ".index(output.identifier))


def _combined(node, output, argument, note):
    return joined([argument(axis) for axis in "XYZ"])


#: As arithmetic.COMPUTED.
MATHS = {
    "MATH": _math,
    "VECT_MATH": _vector_math,
    "MAP_RANGE": _map_range,
    "CLAMP": _clamp,
    "NORMAL": _normal,
    "VECTOR_ROTATE": _rotated,
    "SEPXYZ": _separated,
    "COMBXYZ": _combined,
}
