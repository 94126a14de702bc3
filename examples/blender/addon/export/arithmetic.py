# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader nodes that compute values from values, for constants."""

import numpy as np

from .blackbody import blackbody


class NotConstant(Exception):
    """A value that no constant stands for; the message names where it comes from."""


#: Operations of the Math node on two numbers; others are left to the report.
_MATH = {
    "ADD": lambda a, b: a + b,
    "SUBTRACT": lambda a, b: a - b,
    "MULTIPLY": lambda a, b: a * b,
    # As Blender: what cannot be computed is 0.
    "DIVIDE": lambda a, b: a / b if b else 0.0,
    "POWER": lambda a, b: a**b if a > 0 or (b == int(b) and (a or b > 0)) else float(b == 0),
    "MINIMUM": min,
    "MAXIMUM": max,
    "SQRT": lambda a, _: max(a, 0.0) ** 0.5,
    "ABSOLUTE": lambda a, _: abs(a),
}


def _scalar(value):
    return float(value) if np.ndim(value) == 0 else float(np.dot(value, (0.2126, 0.7152, 0.0722)))


def _value(node, output, argument, note):
    return float(output.default_value)


def _rgb(node, output, argument, note):
    return np.array(output.default_value[:3], np.float64)


def _math(node, output, argument, note):
    operation = _MATH.get(node.operation)
    if operation is None:
        raise NotConstant(f"{node.name} ({node.operation.replace('_', ' ').lower()})")
    result = operation(_scalar(argument("Value")), _scalar(argument("Value_001")))
    return min(max(result, 0.0), 1.0) if node.use_clamp else result


def _mix(node, output, argument, note):
    if node.data_type not in ("FLOAT", "RGBA") or (node.data_type == "RGBA" and node.blend_type not in _BLEND):
        raise NotConstant(node.name)
    kind = {"FLOAT": "Float", "RGBA": "Color"}[node.data_type]
    factor = _scalar(argument("Factor_Float"))
    factor = min(max(factor, 0.0), 1.0) if node.clamp_factor else factor
    a, b = argument(f"A_{kind}"), argument(f"B_{kind}")
    if node.data_type == "FLOAT":
        return (1 - factor) * _scalar(a) + factor * _scalar(b)
    result = _BLEND[node.blend_type](a, b, factor)
    return np.clip(result, 0, 1) if node.clamp_result else result


def _mix_rgb(node, output, argument, note):
    if node.blend_type not in _BLEND:
        raise NotConstant(node.name)
    factor = min(max(_scalar(argument("Fac")), 0.0), 1.0)
    result = _BLEND[node.blend_type](argument("Color1"), argument("Color2"), factor)
    return np.clip(result, 0, 1) if node.use_clamp else result


_BLEND = {
    "MIX": lambda a, b, f: (1 - f) * a + f * b,
    "ADD": lambda a, b, f: a + f * b,
    "MULTIPLY": lambda a, b, f: a * (1 - f + f * b),
    "SUBTRACT": lambda a, b, f: a - f * b,
}


def _ramp(node, output, argument, note):
    colour = node.color_ramp.evaluate(_scalar(argument("Fac")))
    return colour[3] if output.identifier == "Alpha" else np.array(colour[:3], np.float64)


def _blackbody(node, output, argument, note):
    return blackbody(_scalar(argument("Temperature")))


def _light_path(node, output, argument, note):
    if not output.identifier.startswith("Is "):
        raise NotConstant(node.name)
    # Light is traced from the lights here: glass must be glass for light that reaches the fog, whatever it pretends to
    # be for shadow rays.
    note(f"Light Path, {output.name}", "0, as if the answer were no, for all light")
    return 0.0


def _fresnel(node, output, argument, note):
    ior = max(_scalar(argument("IOR")), 1e-5)
    note("Fresnel as a factor", "its value at normal incidence, for all directions")
    return ((ior - 1) / (ior + 1)) ** 2


def _layer_weight(node, output, argument, note):
    note("Layer Weight as a factor", "its value at normal incidence, for all directions")
    if output.identifier == "Facing":
        return 0.0
    eta = max(1 - _scalar(argument("Blend")), 1e-5)
    return ((1 - eta) / (1 + eta)) ** 2


#: By type of node: function of the node, its output, the values of its inputs by identifier, and one for notes.
COMPUTED = {
    "VALUE": _value,
    "RGB": _rgb,
    "MATH": _math,
    "MIX": _mix,
    "MIX_RGB": _mix_rgb,
    "VALTORGB": _ramp,
    "BLACKBODY": _blackbody,
    "LIGHT_PATH": _light_path,
    "FRESNEL": _fresnel,
    "LAYER_WEIGHT": _layer_weight,
}
