# SPDX-License-Identifier: GPL-3.0-or-later
"""Follows the links of shader nodes to values."""

from typing import NamedTuple
from zlib import crc32

import numpy as np

from .arithmetic import COMPUTED, Elsewhere, NotConstant, as_colour, as_number
from .asked_nodes import ASKED, asked, is_mapped
from .colour_nodes import COLOURS
from .curve_nodes import CURVES
from .facts import told
from .images import mean_colour, picture
from .math_nodes import MATHS
from .report import Report
from .textures import TEXTURES, UNLINKED, Places, image_at

#: By type of node, as arithmetic.COMPUTED.
COMPUTED_NODES = {**COMPUTED, **MATHS, **COLOURS, **CURVES}

#: Stands for places where all that textures give is drawn at random, so many times, to see what depends on them.
PROBE, _DRAWS = Places(), 64


class End(NamedTuple):
    """Where the links that lead to an input begin."""

    #: The node, or None if nothing is linked.
    node: object
    #: Its output, or the input that has a value of its own; None: there is none, but a muted node before it.
    socket: object
    #: The group nodes that this is inside of, outermost first.
    groups: tuple


def find(sockets, identifier):
    """The socket of this identifier, or None if the node, of this version of Blender, has none."""
    return next((s for s in sockets if s.identifier == identifier), None)


def follow(socket, groups=()):
    """The End of an input `socket`, through reroutes, groups and muted nodes."""
    muted = False
    while True:
        link = next((k for k in socket.links if k.is_valid and not k.is_muted), None) if socket.is_linked else None
        if link is None:
            # The value of a muted node's own input does not count.
            return End(None, None if muted else socket, groups)
        node, output = link.from_node, link.from_socket
        if node.type == "REROUTE":
            socket = node.inputs[0]
        elif node.mute:
            muted = True
            through = next((k for k in node.internal_links if k.to_socket == output), None)
            if through is None:
                return End(None, None, groups)
            socket = through.from_socket
        elif node.type == "GROUP" and node.node_tree is not None:
            inside = next((n for n in node.node_tree.nodes if n.type == "GROUP_OUTPUT" and n.is_active_output), None)
            if inside is None:
                return End(None, None, groups)
            socket, groups = find(inside.inputs, output.identifier), (*groups, node)
        elif node.type == "GROUP_INPUT" and groups:
            socket, groups = find(groups[-1].inputs, output.identifier), groups[:-1]
        else:
            return End(node, output, groups)


def closures(values, socket, groups, weight):
    """The shader nodes that lead to the input `socket` by way of Add and Mix Shader nodes: (node, its groups, its share of `weight`)
    for each whose share is not 0. values: Values."""
    end = follow(socket, groups)
    if not np.any(weight) or end.node is None:
        return
    node, groups = end.node, end.groups
    if node.type == "ADD_SHADER":
        for shader in node.inputs:
            yield from closures(values, shader, groups, weight)
    elif node.type == "MIX_SHADER":
        factor = np.clip(values.number(node, "Fac", groups), 0, 1)
        yield from closures(values, node.inputs[1], groups, weight * (1 - factor))
        yield from closures(values, node.inputs[2], groups, weight * factor)
    else:
        yield node, groups, weight


class Values:
    """Values of inputs of the nodes of one `source` (such as 'Material "Wall"'); what is not known is reported.

    Numbers are floats and colours float64 (3,); where they vary over the n places that they are asked for, (n, 1) and (n, 3).
    """

    def __init__(self, source, report, places=None, pictures=None, facts=(), for_shadows=False, is_fog=False):
        """places: textures.Places; None: what varies from place to place is not known. pictures: of images that have been read.

        facts: of the object that the nodes are used by, as facts.found has made them.
        for_shadows: whether a shadow ray asks, and not any other; is_fog: whether the nodes are those of fog.
        """
        self.source, self.report, self._places = source, report, places
        self._pictures, self._facts = {} if pictures is None else pictures, facts
        self._for_shadows, self._is_fog = for_shadows, is_fog
        #: Whether a value has been asked for that varies from place to place.
        self.varies = False

    def at(self, places):
        """The same, at some textures.Places."""
        return self._changed(places=places)

    def quiet(self):
        """The same, without a report."""
        return self._changed(report=Report())

    def of_fog(self):
        """The same, for nodes of fog."""
        return self._changed(is_fog=True)

    def for_shadows(self):
        """The same for shadow rays, without a report."""
        return self._changed(report=Report(), for_shadows=True)

    def _changed(self, **changes):
        kept = {"report": self.report, "places": self._places, "pictures": self._pictures, "facts": self._facts}
        return Values(self.source, **kept | {"for_shadows": self._for_shadows, "is_fog": self._is_fog} | changes)

    def number(self, node, identifier, groups, missing=0.0):
        """A number. `missing`: what it is if this version of Blender has no such input."""
        socket = find(node.inputs, identifier)
        return missing if socket is None else as_number(self._constant(node, socket, groups))

    def colour(self, node, identifier, groups):
        """Linear Rec. 709, or a vector."""
        return as_colour(self._constant(node, find(node.inputs, identifier), groups))

    def linked(self, node, identifier):
        """Whether the input exists and a link leads to it."""
        socket = find(node.inputs, identifier)
        return socket is not None and socket.is_linked

    def known(self, node, identifier, groups):
        """A colour, float64 (3,), or why no constant stands for it, as text."""
        try:
            return as_colour(self._evaluate(find(node.inputs, identifier), groups))
        except NotConstant as reason:
            return str(reason)

    def held(self, node, identifier):
        """The grids.Lookup of what a volume holds where the places are, and the name that an input has of it; None, and the name."""
        return self._places.held if self._places is not None else None, find(node.inputs, identifier).default_value

    def note(self, what, instead, in_fog=False):
        """Adds to the report, for the source."""
        self.report.add(self.source, what, instead, in_fog)

    def _constant(self, node, socket, groups):
        try:
            return self._evaluate(socket, groups)
        except NotConstant as reason:
            value = _plain(socket.default_value)
            shown = f"{value:.4g}" if np.ndim(value) == 0 else "(" + ", ".join(f"{x:.4g}" for x in value) + ")"
            what = f"{socket.name} of {node.name} comes from {reason}"
            self.note(what, f"{shown}, the value of the socket, is used", in_fog=True)
            return value

    def _evaluate(self, socket, groups):
        end = follow(socket, groups)
        if end.node is None and end.socket is None:
            raise NotConstant("a muted node")
        if end.node is None:
            return _plain(end.socket.default_value)

        def argument(identifier):
            socket = find(end.node.inputs, identifier)
            if socket is None:
                raise NotConstant(end.node.name)
            # A Sky Texture with a sun has its input switched off, and does not heed links to it.
            unlinked = not socket.enabled or follow(socket, end.groups).node is None
            if identifier == "Vector" and end.node.type in UNLINKED and unlinked:
                place = getattr(self._places, UNLINKED[end.node.type])
                if place is None:
                    raise NotConstant(end.node.name)
                return place
            return self._evaluate(socket, end.groups)

        kind = end.node.type
        is_told = kind == "OBJECT_INFO" or (kind == "ATTRIBUTE" and end.node.attribute_type != "GEOMETRY")
        is_texture = (kind in TEXTURES and not is_told) or (kind in ASKED and kind in UNLINKED)
        if is_told:
            value = told(end.node, end.socket, self._facts)
            if value is None:
                raise NotConstant(end.node.name)
        elif self._places is PROBE and (kind == "TEX_IMAGE" or is_texture):
            self.varies = True
            value = _drawn(end.node.name, 1 if end.socket.type == "VALUE" else 3)
        elif kind == "TEX_IMAGE":
            value = self._image(end, argument)
        elif end.socket.identifier == "Is Shadow Ray" and kind == "LIGHT_PATH":
            # Surfaces and fog are looked at twice: materials.py, volumes.py. Lamps and skies never shine on shadow rays.
            value = float(self._for_shadows)
        elif end.socket.identifier == "Is Camera Ray" and kind == "LIGHT_PATH" and self._is_fog:
            self.note("fog that the camera sees otherwise, by Light Path", "as all other rays see it", in_fog=True)
            value = 0.0
        elif is_texture and self._places is None:
            self.varies = True
            raise NotConstant(end.node.name)
        else:
            self.varies |= is_texture
            value = self._computed(end, argument)
        # Nodes compute with what their inputs are: a colour that is linked to a number is its luminance.
        return as_number(value, end.socket.type == "VECTOR") if socket.type in ("VALUE", "INT") else value

    def _computed(self, end, argument):
        """What a node gives: by our arithmetic, or else by Blender's own."""
        node, output = end.node, end.socket
        try:
            if node.type in TEXTURES and not is_mapped(node):
                return TEXTURES[node.type](node, output, argument, self._places)
            if node.type in COMPUTED_NODES:
                with np.errstate(all="ignore"):
                    return COMPUTED_NODES[node.type](node, output, argument, self.note)
        except Elsewhere:
            pass
        if node.type not in ASKED:
            raise NotConstant(node.name)
        return asked(node, output, argument)

    def _image(self, end, argument):
        """An image texture where the places are, or its mean if they are not known."""
        node = end.node
        on_surface = self._places is not None and self._places.surface is not None
        if on_surface or follow(find(node.inputs, "Vector"), end.groups).node is not None:
            self.varies = True
            pixels = self._picture(node.image) if self._places is not None else None
            if pixels is not None:
                try:
                    return asked(node, end.socket, argument) if is_mapped(node) else image_at(node, end.socket, argument, pixels)
                except Elsewhere:
                    return asked(node, end.socket, argument)
                except NotConstant:
                    # Its mean then, which is said.
                    pass
        mean = mean_colour(node.image)
        if mean is None:
            raise NotConstant(f"{node.name}, whose image cannot be read")
        self.note(f"image texture {node.image.name}", "its mean colour is used", in_fog=True)
        return mean[3] if end.socket.identifier == "Alpha" else mean[:3]

    def _picture(self, image):
        """images.picture, read once for all places of the source."""
        key = image.as_pointer() if image is not None else None
        if key not in self._pictures:
            self._pictures[key] = picture(image)
        return self._pictures[key]


def _drawn(name, channels):
    """Random numbers or colours of a node, with the ends of what they may be among them: (n, channels)."""
    values = np.random.default_rng(crc32(name.encode())).random((_DRAWS, channels))
    values[:2] = [[0.0], [1.0]]
    return values


def _plain(value):
    """A socket's value as a float or a float64 array (3,)."""
    return float(value) if np.ndim(value) == 0 else np.array(value, np.float64)[:3]
