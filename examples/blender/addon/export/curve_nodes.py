# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader nodes with colour ramps and curves, of which Cycles has tables. Values are as in arithmetic."""

import numpy as np

from .arithmetic import as_colour, mixed, plain

#: Values of a ramp or curve between which Cycles interpolates.
_TABLE = 256


def _between(table, place):
    """Values of a table (256,) at places, 0 for the first and 1 for the last, of which nothing is beyond them."""
    place = np.clip(np.nan_to_num(place), 0, 1) * (_TABLE - 1)
    low = place.astype(int)
    rest = place - low
    return (1 - rest) * table[low] + rest * table[np.minimum(low + 1, _TABLE - 1)]


def _ramp(node, output, argument, note):
    ramp, at = node.color_ramp, argument("Fac")
    table = np.array([ramp.evaluate(i / (_TABLE - 1)) for i in range(_TABLE)], np.float64)
    places = np.atleast_1d(at)[..., 0]
    if ramp.interpolation == "CONSTANT":
        found = table[(np.clip(np.nan_to_num(places), 0, 1) * (_TABLE - 1)).astype(int)]
    else:
        found = np.stack([_between(channel, places) for channel in table.T], axis=-1)
    if output.identifier == "Alpha":
        return float(found[3]) if found.ndim == 1 else found[:, 3:]
    return found[..., :3]


def _curved(mapping, values, channels):
    """Values (n, channels) of a bpy.types.CurveMapping; channels: for each, the curves that it goes through, in this order."""
    mapping.update()
    low = min(curve.points[0].location[0] for curve in mapping.curves)
    high = max(curve.points[-1].location[0] for curve in mapping.curves)
    inputs, found = np.linspace(low, high, _TABLE), []
    for k, through in enumerate(channels):
        table = inputs
        for curve in through:
            table = np.array([mapping.evaluate(mapping.curves[curve], x) for x in table])
        place = (values[..., k] - low) / max(high - low, 1e-30)
        made = _between(table, place)
        if mapping.extend == "EXTRAPOLATED":
            made = np.where(place < 0, table[0] + place * (_TABLE - 1) * (table[1] - table[0]), made)
            made = np.where(place > 1, table[-1] + (place - 1) * (_TABLE - 1) * (table[-1] - table[-2]), made)
        found.append(made)
    return np.stack(found, axis=-1)


def _rgb_curves(node, output, argument, note):
    colour = as_colour(argument("Color"))
    # The last curve is for all channels.
    return mixed(colour, _curved(node.mapping, colour, [(3, 0), (3, 1), (3, 2)]), argument("Fac"))


def _vector_curves(node, output, argument, note):
    vector = as_colour(argument("Vector"))
    return mixed(vector, _curved(node.mapping, vector, [(0,), (1,), (2,)]), argument("Fac"))


def _float_curve(node, output, argument, note):
    value = argument("Value")
    made = _curved(node.mapping, np.atleast_1d(value), [(0,)])
    return plain(mixed(value, made if np.ndim(value) else float(made[0]), argument("Factor")))


#: As arithmetic.COMPUTED.
CURVES = {"VALTORGB": _ramp, "CURVE_RGB": _rgb_curves, "CURVE_VEC": _vector_curves, "CURVE_FLOAT": _float_curve}
