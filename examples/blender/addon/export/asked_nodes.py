# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader nodes that Cycles computes for us at places that we know, in another Blender."""

import atexit
import hashlib
import json
from collections import OrderedDict

import bpy
import numpy as np

from .arithmetic import NotConstant, as_colour, as_number
from .other_blender import Failed, Helper
from .working_space import working_space

#: Types of nodes whose outputs follow from their inputs and settings alone.
ASKED = {
    *("TEX_VORONOI", "TEX_WAVE", "TEX_MAGIC", "TEX_BRICK", "TEX_CHECKER", "TEX_WHITE_NOISE", "TEX_GABOR", "TEX_NOISE", "TEX_GRADIENT"),
    *("TEX_IMAGE", "TEX_ENVIRONMENT", "WAVELENGTH", "MAPPING", "SQUEEZE", "ShaderNodeRadialTiling"),
    *("MATH", "VECT_MATH", "MIX", "MIX_RGB", "VECTOR_ROTATE"),
}

#: Bytes of answers that are kept.
_KEPT = 1 << 27

_answers = OrderedDict()
_helper = Helper("node_values.py")
atexit.register(_helper.stop)


def asked(node, output, argument):
    """What a node of a type in ASKED gives at an output, as arithmetic's functions of nodes do; argument: the values of its inputs by
    identifier. Raises NotConstant."""
    request, arrays, image = _request(node, output, argument)
    key = hashlib.sha256(json.dumps(request).encode())
    for array in (*arrays, *([] if image is None else [image])):
        key.update(array)
    key = key.digest()
    if key not in _answers:
        try:
            found = _helper.values(request, {f"{k}.f32": a for k, a in enumerate(arrays)} | ({} if image is None else {"image.f32": image}))
        except Failed as reason:
            raise NotConstant(f"{node.name} ({reason})") from reason
        _keep(key, np.nan_to_num(found, nan=0.0, posinf=0.0, neginf=0.0))
    _answers.move_to_end(key)
    found = _answers[key].astype(np.float64)
    varies = any(len(array) for array in arrays)
    if output.type == "VALUE":
        return found[:, :1] if varies else float(found[0, 0])
    return found if varies else found[0]


def is_mapped(node):
    """Whether a texture has a mapping of its own, as files and scripts give it: what is computed here has none."""
    own = getattr(node, "texture_mapping", None)
    return own is not None and (any(own.translation) or any(own.rotation) or tuple(own.scale) != (1.0, 1.0, 1.0))


def stop():
    """Ends the other Blender."""
    _helper.stop()


def _keep(key, found):
    _answers[key] = found
    while sum(kept.nbytes for kept in _answers.values()) > _KEPT and len(_answers) > 1:
        _answers.popitem(last=False)


def _request(node, output, argument):
    """What node_values.computed takes, the arrays of its inputs, empty where these are constant, and the pixels of its image, or None."""
    request = _described(node)
    sockets = [s for s in node.inputs if s.enabled and s.type in ("VALUE", "INT", "BOOLEAN", "VECTOR", "RGBA")]
    values = [(as_number if s.type in ("VALUE", "INT", "BOOLEAN") else as_colour)(argument(s.identifier)) for s in sockets]
    count = max((len(v) for v in values if np.ndim(v) == 2), default=1)
    request |= {"output": output.identifier, "count": count, "inputs": []}
    arrays = []
    for socket, value in zip(sockets, values):
        value = np.clip(np.nan_to_num(value), -3e38, 3e38)
        varies = value.ndim == 2
        arrays.append(np.ascontiguousarray(np.broadcast_to(value, (count, value.shape[1])), "<f4") if varies else np.empty((0, 1), "<f4"))
        channels = 1 if value.ndim == 0 else value.shape[-1]
        request["inputs"].append((socket.identifier, channels, None if varies else [float(np.float32(v)) for v in np.atleast_1d(value)]))
    image = None
    if "image" in request:
        image = np.empty(len(node.image.pixels), np.float32)
        node.image.pixels.foreach_get(image)
        image = _of_four(image.reshape(-1, node.image.channels))
    request["space"] = working_space()
    return request, arrays, image


def _of_four(pixels):
    """Pixels of any number of channels with four."""
    channels = pixels.shape[1]
    colour = pixels[:, (0, 1, 2) if channels >= 3 else (0, 0, 0)]
    alpha = pixels[:, -1:] if channels in (2, 4) else np.ones((len(pixels), 1))
    return np.ascontiguousarray(np.concatenate([colour, alpha], axis=1), "<f4")


def _described(node):
    """Type and settings of a node, for JSON."""
    settings, request = {}, {"type": node.bl_idname}
    for name in _own(node, bpy.types.ShaderNode):
        value = getattr(node, name)
        if name == "color_ramp":
            points = [[e.position, list(e.color)] for e in value.elements]
            request["ramp"] = {"settings": {k: getattr(value, k) for k in ("color_mode", "interpolation", "hue_interpolation")}, "elements": points}
        elif name == "mapping":
            curves = [[[list(p.location), p.handle_type] for p in curve.points] for curve in value.curves]
            request["curves"] = {"settings": _simple(value, bpy.types.CurveMapping), "curves": curves}
        elif name == "image":
            request["image"] = _image(node)
        elif name in ("texture_mapping", "color_mapping"):
            settings[name] = _simple(value, type(value))
    return request | {"settings": settings | _simple(node, type(node), bpy.types.ShaderNode)}


def _own(thing, base):
    """Names of the properties that a thing has beside those of its base."""
    common = {prop.identifier for prop in base.bl_rna.properties}
    return [prop.identifier for prop in thing.bl_rna.properties if prop.identifier not in common]


def _simple(thing, kind, base=None):
    """Numbers, words and answers that can be set, by name, as JSON has them."""
    common = {prop.identifier for prop in base.bl_rna.properties} if base is not None else {"rna_type"}
    found = {}
    for prop in kind.bl_rna.properties:
        if prop.identifier not in common and not prop.is_readonly and prop.type in ("BOOLEAN", "INT", "FLOAT", "ENUM", "STRING"):
            value = getattr(thing, prop.identifier)
            found[prop.identifier] = value if isinstance(value, (str, bool, int, float)) else list(value)
    return found


def _image(node):
    """What an image is but for its pixels."""
    image = node.image
    if image is None or image.size[0] * image.size[1] == 0:
        raise NotConstant(f"{node.name}, whose image cannot be read")
    if getattr(node, "projection", "") == "BOX":
        raise NotConstant(f"{node.name} (box: by normals)")
    return {
        "size": list(image.size),
        "is_float": image.is_float,
        # Floats have been brought to the working space when they were read.
        "space": image.colorspace_settings.name if image.colorspace_settings.is_data or not image.is_float else working_space(),
        "alpha_mode": image.alpha_mode,
    }
