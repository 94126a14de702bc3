# SPDX-License-Identifier: GPL-3.0-or-later
"""A world's background -> host.scene.Light."""

from dataclasses import replace

import numpy as np
from mathutils import Euler

from ..host.scene import Light, LightKind, Rays
from .images import SKY_COLUMNS, blocks, is_plain
from .materials import has_nodes
from .nodes import Values, closures, find, follow
from .other_blender import Failed
from .sky_texture import sky_of
from .textures import Places
from .trees import nodes_in

#: By a setting of a world's Ray Visibility that is off: what does not see its background.
_RAYS = {"diffuse": Rays.DIFFUSE, "glossy": Rays.GLOSSY, "transmission": Rays.TRANSMISSION, "scatter": Rays.VOLUME}


def sky(world, report, poll, facts=()):
    """The light that comes from a bpy.types.World's background: a list of host.scene.Light.

    Colours, pictures of the whole sky, which may be turned, and what nodes compute from directions, with the suns of Sky Textures. In the
    world's own fog the caller must not ask: that has no end, and nothing gets through. poll: as for export; facts: as nodes.Values has them.
    """
    if world is None:
        return []
    hidden = Rays(sum(rays for name, rays in _RAYS.items() if not getattr(world.cycles_visibility, name)))
    return [replace(light, hidden_from=hidden) for light in _lights(world, report, poll, facts)]


def _lights(world, report, poll, facts):
    values = Values(f'World "{world.name}"', report, facts=facts)
    if not has_nodes(world):
        return _light(world, np.array(world.color, np.float64), None)
    output = world.node_tree.get_output_node("CYCLES")
    if output is None:
        return []
    surface, trial, suns = output.inputs["Surface"], values.quiet(), []
    constant, picture = _parts(trial, surface)
    if trial.varies:
        skies = _skies(world.node_tree, poll)
        constant, picture = _varied(values, surface, skies), None
        suns = [light for node, of in skies.values() if (light := _sun(world, values, surface, node, skies, of)) is not None]
    else:
        report.extend(trial.report)
    return _light(world, constant, picture) + suns


def _skies(tree, poll):
    """By pointer of the Sky Textures of a tree, and of the groups in it: the node, and its sky_texture.Sky, or why there is none as text."""
    found = {}
    for node in nodes_in(tree):
        if node.type == "TEX_SKY" and node.outputs[0].is_linked:
            try:
                made = sky_of(node, poll)
            except Failed as reason:
                made = str(reason)
            found[node.as_pointer()] = node, made
    return found


def _sun(world, values, surface, node, skies, sky):
    """The disc of a Sky Texture's sun as a Light, or None."""
    if isinstance(sky, str) or not sky.irradiance.any():
        return None
    # What becomes of the disc's mean radiance on its way to the background.
    radiance = sky.irradiance / (np.pi * np.sin(sky.angle) ** 2)
    off, on = (_radiance(values, surface, sky.direction[None], skies, suns)[0] for suns in ({}, {node.as_pointer(): radiance}))
    share = np.maximum(on - off, 0) / np.where(radiance > 0, radiance, 1)
    if not (share * sky.irradiance).any():
        return None
    return Light(name=f"{world.name}, {node.name}", kind=LightKind.SUN, axis=-sky.direction, irradiance=share * sky.irradiance, angle=sky.angle)


def _parts(values, surface):
    """Radiance of the constant parts of a background, (3,), and one picture: its cells and how it is turned, or None."""
    constant, picture = np.zeros(3), None
    for node, groups, share in _backgrounds(values, surface):
        strength = share * values.number(node, "Strength", groups)
        if not np.any(strength > 0):
            continue
        end = follow(find(node.inputs, "Color"), groups)
        if end.node is not None and end.node.type == "TEX_ENVIRONMENT":
            found = _picture(values, end.node, end.groups)
            if found is None:
                continue
            if picture is not None:
                _left_out(values, f"a second picture of the sky, {end.node.name}")
                continue
            cells, turn = found
            picture = strength * cells, turn
            continue
        constant += strength * _colour(values, node, groups)
    return constant, picture


def _varied(values, surface, skies):
    """Radiance of a background that nodes compute for each direction: cells of equal angles, (h, w, 3)."""
    rows, columns = SKY_COLUMNS // 2, SKY_COLUMNS
    angle, azimuth = (np.arange(rows) + 0.5) * (np.pi / rows), np.pi - (np.arange(columns) + 0.5) * (2 * np.pi / columns)
    angle, azimuth = np.meshgrid(angle, azimuth, indexing="ij")
    towards = np.stack([np.sin(angle) * np.cos(azimuth), np.sin(angle) * np.sin(azimuth), np.cos(angle)], axis=-1).reshape(-1, 3)
    return _radiance(values, surface, towards, skies, {}).reshape(rows, columns, 3)


def _radiance(values, surface, towards, skies, suns):
    """The same in some directions, unit, (n, 3); suns: of Sky Textures, as textures.Places has them."""
    # In Cycles the sky is a place in each direction, whose normal points back.
    skies = {pointer: sky for pointer, (_, sky) in skies.items()}
    values = values.at(Places(towards, towards, towards, away=-towards, away_in_world=-towards, skies=skies, suns=suns))
    total = np.zeros((len(towards), 3))
    # What is no number is dark.
    with np.errstate(all="ignore"):
        for node, groups, share in _backgrounds(values, surface):
            strength = share * values.number(node, "Strength", groups)
            total += np.nan_to_num(np.maximum(strength, 0) * _colour(values, node, groups), posinf=0.0)
    return np.minimum(total, 1e30)


def _backgrounds(values, surface):
    """The Background nodes of a world, as nodes.closures."""
    for node, groups, share in closures(values, surface, (), 1.0):
        if node.type == "BACKGROUND":
            yield node, groups, share
        else:
            _left_out(values, f"{node.bl_label} as a background")


def _colour(values, node, groups):
    """Colour of a Background node, 0 if it is not known, which is said."""
    colour = values.known(node, "Color", groups)
    if isinstance(colour, str):
        _left_out(values, f"light of the background, which comes from {colour}")
        return np.zeros(3)
    return np.maximum(colour, 0)


def _left_out(values, what):
    values.note(what, "it does not light the fog", in_fog=True)


def _light(world, constant, picture):
    """What a background is, as a list of one Light or none."""
    cells, turn = (np.zeros((1, 1, 3)), np.eye(3)) if picture is None else picture
    cells = (cells + constant).astype(np.float32)
    return [Light(world.name, LightKind.WORLD, sky=cells, turn=turn)] if cells.any() else []


def _picture(values, node, groups):
    """Radiance of the cells of an Environment Texture, and how it is turned; None if it cannot be read."""
    if node.projection != "EQUIRECTANGULAR" or not is_plain(node.image):
        # Looked up direction by direction.
        values.varies = True
        return None
    turn = _turn(values, follow(find(node.inputs, "Vector"), groups))
    cells = blocks(node.image, SKY_COLUMNS)
    if cells is None:
        _left_out(values, f"light of {node.name}, whose image cannot be read")
        return None
    if turn is None:
        # More than turned: looked up direction by direction.
        values.varies = True
        return None
    return cells, turn


def _turn(values, end):
    """The rotation from directions to those in a picture that an input of vectors stands for, (3, 3); None if it is none."""
    node = end.node
    if node is None or (node.type == "TEX_COORD" and end.socket.identifier == "Generated" and node.object is None):
        return np.eye(3)
    if node.type != "MAPPING":
        return None
    before = _turn(values, follow(find(node.inputs, "Vector"), end.groups))
    parts = {}
    for name, plain in (("Location", (0, 0, 0)), ("Rotation", None), ("Scale", (1, 1, 1))):
        socket = find(node.inputs, name)
        if socket is None:
            continue
        parts[name] = values.known(node, name, end.groups)
        if isinstance(parts[name], str) or (plain is not None and not np.allclose(parts[name], plain)):
            return None
    if before is None:
        return None
    turn = np.array(Euler(parts["Rotation"], "XYZ").to_matrix(), np.float64)
    return (turn.T if node.vector_type == "TEXTURE" else turn) @ before
