# SPDX-License-Identifier: GPL-3.0-or-later
"""What walk.py changes in a scene: nodes of shaders in all their roles, and settings of what scenes are made of."""

from dataclasses import dataclass
from typing import Callable

import bpy
import cycles_scenes as scenes
from walk_stage import card, stage


@dataclass(frozen=True)
class Subject:
    """One thing that is changed.

    - group: of the table, such as "Nodes: fog"; name: within it.
    - build: makes the scene, and returns it; None: there is no such thing here.
    """

    group: str
    name: str
    build: Callable


#: Nodes that are no more than ends, frames and programs of others: nothing of a picture is theirs.
_NO_NODES = {
    *("ShaderNode", "ShaderNodeTree", "ShaderNodeCustomGroup", "ShaderNodeGroup", "ShaderNodeOutputMaterial", "ShaderNodeOutputWorld"),
    *("ShaderNodeOutputLight", "ShaderNodeOutputLineStyle", "ShaderNodeOutputAOV", "ShaderNodeUVAlongStroke"),
}


def node_types():
    """Names of all types of shader nodes, ascending."""
    return sorted(name for name in dir(bpy.types) if name.startswith("ShaderNode") and name not in _NO_NODES)


def _coordinates(tree, role):
    """The output that a texture is read by."""
    if role == "lamps":
        return tree.nodes.new("ShaderNodeTexCoord").outputs["Normal"]
    return tree.nodes.new("ShaderNodeTexCoord").outputs["Generated" if role == "sky" else "Object"]


def _fed(tree, kind, role, settings):
    """A node whose first vector is a coordinate, or else its first other input, and whose other inputs differ; its first output of values, or None."""
    node = tree.nodes.new(kind)
    for key, value in settings.items():
        setattr(node, key, value)
    usable = [socket for socket in node.inputs if socket.enabled and socket.type != "SHADER"]
    vector = next((s for s in usable if s.type == "VECTOR" and s.identifier not in ("Normal", "Tangent")), None)
    # A factor of 1 is all of what a node does.
    numbers = [s for s in usable if s.type in ("VALUE", "RGBA") and s.identifier != "Scale"]
    number = next((s for s in numbers if s.name not in ("Factor", "Fac") or "MIX" in node.type), next(iter(numbers), None))
    for socket, colour in zip((s for s in usable if s.type == "RGBA"), ((0.9, 0.5, 0.1, 1), (0.1, 0.3, 0.8, 1))):
        socket.default_value = colour
    if vector is not None:
        tree.links.new(_coordinates(tree, role), vector)
    elif number is not None:
        split = tree.nodes.new("ShaderNodeSeparateXYZ")
        tree.links.new(_coordinates(tree, role), split.inputs[0])
        tree.links.new(split.outputs["X"], number)
    return next((s for s in node.outputs if s.enabled and s.type != "SHADER"), None)


def _number(tree, output):
    """What any output is, between 0 and 1."""
    clamp = tree.nodes.new("ShaderNodeClamp")
    tree.links.new(output, clamp.inputs["Value"])
    return clamp.outputs[0]


def _scaled(tree, output, factor, more):
    """factor * output + more."""
    node = tree.nodes.new("ShaderNodeMath")
    node.operation = "MULTIPLY_ADD"
    tree.links.new(output, node.inputs[0])
    node.inputs[1].default_value, node.inputs[2].default_value = factor, more
    return node.outputs[0]


def _nodes_of(owner):
    owner.use_nodes = True
    return owner.node_tree


def _find(tree, type_):
    return next(node for node in tree.nodes if node.type == type_)


def _fed_by(role, target):
    """A Subject's build: what a node gives, between 0 and 1, goes into something of the stage.

    target: changes a scene; gives a tree of nodes, the socket of it that is fed, and (factor, more) of what it is fed with.
    """

    def build(kind, settings):
        scene = stage()
        tree, socket, (factor, more) = target(scene)
        output = _fed(tree, kind, role, settings)
        if output is None:
            return None
        tree.links.new(_scaled(tree, _number(tree, output), factor, more), socket)
        return scene

    return build


def _fog(scene):
    tree = bpy.data.materials["Mist"].node_tree
    return tree, _find(tree, "VOLUME_SCATTER").inputs["Density"], (0.25, 0.05)


def _lamp(scene):
    tree = _nodes_of(bpy.data.objects["Key"].data)
    return tree, _find(tree, "EMISSION").inputs["Strength"], (0.7, 0.3)


def _sky(scene):
    bpy.data.objects["Key"].data.energy = 50
    tree = scene.world.node_tree
    background = _find(tree, "BACKGROUND")
    background.inputs["Color"].default_value = (1, 0.8, 0.6, 1)
    return tree, background.inputs["Strength"], (0.4, 0.1)


def _card(scene):
    made = scenes.material("Card")
    tree = made.node_tree
    mix = tree.nodes.new("ShaderNodeMixShader")
    tree.links.new(tree.nodes.new("ShaderNodeBsdfTransparent").outputs[0], mix.inputs[1])
    tree.links.new(tree.nodes.new("ShaderNodeBsdfDiffuse").outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], _find(tree, "OUTPUT_MATERIAL").inputs["Surface"])
    card(made)
    return tree, mix.inputs[0], (1.0, 0.0)


def _screen(scene):
    bpy.data.objects["Key"].data.energy = 50
    made = scenes.material("Screen", ("ShaderNodeEmission", {}, "Surface"))
    card(made)
    return made.node_tree, _find(made.node_tree, "EMISSION").inputs["Strength"], (6.0, 1.0)


def _floor(scene):
    tree = bpy.data.materials["Grey"].node_tree
    return tree, _find(tree, "BSDF_DIFFUSE").inputs["Color"], (0.8, 0.1)


def _as_shader(owner, socket):
    """Puts a shader node of its own onto a ball or into fog."""

    def build(kind, settings):
        scene = stage()
        # Cycles finds the light of small lamps by way of glass so rarely that few samples tell nothing.
        bpy.data.objects["Key"].data.shadow_soft_size = 0.8
        tree = bpy.data.materials[owner].node_tree
        node = tree.nodes.new(kind)
        for key, value in settings.items():
            setattr(node, key, value)
        output = next((s for s in node.outputs if s.enabled and s.type == "SHADER"), None)
        if output is None:
            return None
        target = _find(tree, "OUTPUT_MATERIAL").inputs[socket]
        if kind in ("ShaderNodeMixShader", "ShaderNodeAddShader"):
            tree.links.new(target.links[0].from_socket, [s for s in node.inputs if s.type == "SHADER"][0])
        if "Density" in node.inputs:
            node.inputs["Density"].default_value = 0.2
        tree.links.new(output, target)
        return scene

    return build


def _as_normal(kind, settings):
    scene = stage()
    tree = bpy.data.materials["Skin"].node_tree
    node = tree.nodes.new(kind)
    for key, value in settings.items():
        setattr(node, key, value)
    if "Height" in node.inputs:
        wave = tree.nodes.new("ShaderNodeTexNoise")
        tree.links.new(wave.outputs[0], node.inputs["Height"])
    target = "Displacement" if "isplacement" in kind else "Normal"
    if target == "Normal" and "Normal" not in node.outputs:
        return None
    end = _find(tree, "OUTPUT_MATERIAL").inputs["Displacement"] if target == "Displacement" else _find(tree, "BSDF_DIFFUSE").inputs["Normal"]
    if target == "Displacement":
        bpy.data.materials["Skin"].displacement_method = "BOTH"
    tree.links.new(node.outputs[0], end)
    return scene


#: Roles of nodes: group of the table, and what builds its scene.
ROLES = {
    "Density of fog": _fed_by("fog", _fog),
    "Lamps": _fed_by("lamps", _lamp),
    "Background": _fed_by("sky", _sky),
    "Cut-outs": _fed_by("surfaces", _card),
    "Shining meshes": _fed_by("surfaces", _screen),
    "Colour of surfaces": _fed_by("surfaces", _floor),
    "Surface shader": _as_shader("Skin", "Surface"),
    "Volume shader": _as_shader("Mist", "Volume"),
    "Normals and displacement": _as_normal,
}

#: Nodes that make normals or move surfaces.
_OF_NORMALS = {"ShaderNodeBump", "ShaderNodeNormalMap", "ShaderNodeDisplacement", "ShaderNodeVectorDisplacement", "ShaderNodeNormal"}


def _settings_of(kind, all_of_them):
    """Settings of a node that choose what it computes: {} for its defaults, and each other value of its enumerations."""
    yield {}
    if not all_of_them:
        return
    base = {p.identifier for p in bpy.types.ShaderNode.bl_rna.properties} | {"bl_icon", "warning_propagation"}
    for prop in getattr(bpy.types, kind).bl_rna.properties:
        if prop.identifier in base or prop.is_readonly or prop.type not in ("ENUM", "BOOLEAN"):
            continue
        if prop.type == "BOOLEAN":
            yield {prop.identifier: not prop.default}
            continue
        for item in prop.enum_items:
            if item.identifier != prop.default:
                yield {prop.identifier: item.identifier}


def nodes(all_of_them):
    """Subjects for each type of node in each role that it has. all_of_them: with all values of its enumerations."""
    for kind in node_types():
        for group, build in ROLES.items():
            if (group == "Normals and displacement") != (kind in _OF_NORMALS) and group == "Normals and displacement":
                continue
            for settings in _settings_of(kind, all_of_them):
                label = getattr(bpy.types, kind).bl_rna.name
                shown = ", ".join(str(value).replace("_", " ").lower() for value in settings.values())
                yield Subject(group, f"{label} ({shown})" if shown else label, lambda b=build, k=kind, s=settings: b(k, s))


#: Where settings are: group of the table, kind of lamp of the stage, and what has them.
_OWNERS = (
    ("Objects", "SPOT", lambda scene: bpy.data.objects["Ball"]),
    ("Objects (Cycles)", "SPOT", lambda scene: getattr(bpy.data.objects["Ball"], "cycles", None)),
    ("Fog objects", "SPOT", lambda scene: bpy.data.objects["Fog"]),
    ("Lamp objects", "SPOT", lambda scene: bpy.data.objects["Key"]),
    ("Point lamps", "POINT", lambda scene: bpy.data.objects["Key"].data),
    ("Spot lamps", "SPOT", lambda scene: bpy.data.objects["Key"].data),
    ("Area lamps", "AREA", lambda scene: bpy.data.objects["Key"].data),
    ("Suns", "SUN", lambda scene: bpy.data.objects["Key"].data),
    ("Lamps (Cycles)", "AREA", lambda scene: bpy.data.objects["Key"].data.cycles),
    ("Cameras", "SPOT", lambda scene: scene.camera.data),
    ("Depth of field", "SPOT", lambda scene: scene.camera.data.dof),
    ("Materials", "SPOT", lambda scene: bpy.data.materials["Skin"]),
    ("Materials of fog (Cycles)", "SPOT", lambda scene: getattr(bpy.data.materials["Mist"], "cycles", None)),
    ("World", "SPOT", lambda scene: scene.world),
    ("World (Cycles)", "SPOT", lambda scene: scene.world.cycles),
    ("Ray visibility of the world", "SPOT", lambda scene: scene.world.cycles_visibility),
    ("Render", "SPOT", lambda scene: scene.render),
    ("Cycles", "SPOT", lambda scene: scene.cycles),
    ("View layer", "SPOT", lambda scene: scene.view_layers[0]),
)

#: Settings that choose what is written and shown, or how it is computed, and not what the picture is.
_OF_NO_PICTURE = {
    *("use_fake_user", "use_extra_user", "is_runtime_data", "tag", "engine", "samples", "seed", "time_limit", "use_denoising", "device", "threads"),
    *("threads_mode", "resolution_x", "resolution_y", "resolution_percentage", "use_compositing", "use_sequencer", "use_overwrite", "use_placeholder"),
    *("use_file_extension", "views_format", "use_pass_combined", "use_adaptive_sampling", "shading_system", "use_nodes", "use_lock_interface"),
    *("use_persistent_data", "denoiser", "bake_type", "tile_size", "use_auto_tile", "sample_subset_length", "use_sample_subset", "sample_offset"),
    *("use_layer_samples", "preview_pause", "use_single_layer", "use_high_quality_normals", "matrix_local", "matrix_basis", "matrix_parent_inverse"),
    *("use_freestyle", "hide_viewport", "use_stamp", "pass_alpha_threshold", "location", "rotation_euler", "scale", "dimensions", "matrix_world"),
    # What two passes of one scene cannot tell from noise: they are noise.
    *("scrambling_distance", "auto_scrambling_distance", "adaptive_threshold", "use_guiding", "use_layer_samples"),
}

#: How names of others begin that are of the interface, of what is written beside the picture, and of EEVEE.
_OF_INTERFACE = (
    *("preview_", "show_", "display_", "lock_", "use_stamp", "debug_", "guiding_", "simplify_gpencil", "stamp_", "compositor_", "sequencer_"),
    *("denoising_", "use_pass_", "pass_", "active_", "empty_", "track_", "up_axis", "parent_", "use_mesh_mirror", "use_empty", "probe_", "sun_"),
    *("use_sun_shadow", "shadow_buffer", "shadow_filter", "shadow_maximum", "shadow_jitter", "use_shadow_jitter", "use_absolute_resolution"),
    *("passepartout", "composition_", "use_grease_pencil", "simplify_child", "line_", "use_preview", "use_guiding", "use_surface_guiding"),
    *("use_volume_guiding", "surface_guiding", "volume_guiding", "use_deterministic", "hair_", "use_sequencer", "fps", "frame_map", "ppm_", "use_freestyle"),
    *("fisheye_polynomial", "central_cylindrical", "paint_", "custom_", "specular_", "line_priority", "texture_limit", "pass_debug"),
)


def _other_values(prop, value):
    """Values of a setting beside the one that it has: few."""
    if prop.type == "BOOLEAN" and not prop.is_array:
        return [not value]
    if prop.type == "ENUM" and not prop.is_enum_flag:
        return [item.identifier for item in prop.enum_items if item.identifier not in (value, "")][:4]
    if prop.type == "INT" and not prop.is_array:
        return [min(max(n, prop.hard_min), prop.hard_max) for n in (0, 1, value + 2) if n != value][:2]
    if prop.type == "FLOAT" and not prop.is_array:
        return [float(min(max(1.5 * value + 0.25, prop.hard_min), min(prop.soft_max, 1e4)))]
    if prop.type == "FLOAT" and prop.subtype in ("COLOR", "COLOR_GAMMA"):
        return [(0.9, 0.3, 0.2, 1.0)[: len(value)]]
    return []


def _changed(kind, owner, path, value):
    def build():
        scene = stage(kind)
        try:
            setattr(owner(scene), path, value)
        except TypeError:
            # What RNA lists, but this thing cannot be.
            return None
        return scene

    return build


def settings():
    """Subjects for each setting of what a scene is made of."""
    for group, kind, owner in _OWNERS:
        of = owner(stage(kind))
        if of is None:
            continue
        for prop in of.bl_rna.properties:
            if prop.is_readonly or prop.identifier in _OF_NO_PICTURE or prop.identifier.startswith(_OF_INTERFACE):
                continue
            name = prop.name or prop.identifier
            for value in _other_values(prop, getattr(of, prop.identifier)):
                shown = f"{value:.3g}" if isinstance(value, float) else str(value).replace("_", " ").lower()
                yield Subject(group, f"{name}: {shown}", _changed(kind, owner, prop.identifier, value))
