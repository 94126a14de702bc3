# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that put covbeam's fog light in the place of Cycles', in each view layer:

    (noisy) image of Cycles - volume direct - volume indirect [-> denoise] + in-scattered light of covbeam [-> denoise]

Cycles' fog is subtracted, not switched off: that is exact whatever the scene has, and undone by taking nodes away. In frames that have no
beams, or whose file is not there, a switch behind the sum lets Cycles' image through as it is.

They stand between the render layers and whatever these went to, carry a mark, and are made once.
"""

import os

import bpy

#: Custom properties of our nodes: what a node is for, and the name of its view layer. The last one is the switch.
_ROLE = "covbeam"
_LAYER = "covbeam_layer"
_SWITCH = "switch"

#: Custom properties of the switch: the socket of the render layers that it stands for, passes that were off before, the frames that have
#: beams (first, last, step), and what is to be told of missing files, if any are.
_SOURCE = "covbeam_source"
_SWITCHED_ON = "covbeam_passes"
_FRAMES = "covbeam_frames"
_MISSING = "covbeam_missing"

_VOLUME_PASSES = ("use_pass_volume_direct", "use_pass_volume_indirect")

#: What Cycles' denoiser knows of surfaces: of the view layer, and its sockets by those of the compositor's Denoise node.
_GUIDES = "denoising_store_passes"
_GUIDE_SOCKETS = {"Albedo": "Denoising Albedo", "Normal": "Denoising Normal"}

#: The sockets' names before Blender 5.0 and since.
_VOLUME_SOCKETS = (("VolumeDir", "Volume Direct"), ("VolumeInd", "Volume Indirect"))

_PASS = "In-Scattered"


def _tree(scene):
    """The scene's compositor nodes, or None."""
    if bpy.app.version >= (5, 0, 0):
        return scene.compositing_node_group
    return scene.node_tree if scene.use_nodes else None


def _make_tree(scene):
    """The scene's compositor nodes, made if there are none."""
    if _tree(scene) is None:
        if bpy.app.version >= (5, 0, 0):
            tree = bpy.data.node_groups.new(f"{scene.name} Compositing", "CompositorNodeTree")
            tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
            scene.compositing_node_group = tree
        else:
            # Makes render layers that go to the output, if there were no nodes.
            scene.use_nodes = True
    return _tree(scene)


def _output_input(tree):
    """The socket that the final picture goes to; its node is made if there is none."""
    kind = "NodeGroupOutput" if bpy.app.version >= (5, 0, 0) else "CompositorNodeComposite"
    node = next((node for node in tree.nodes if node.bl_idname == kind), None)
    if node is None:
        node = tree.nodes.new(kind)
        node.location = (900, 0)
    return node.inputs[0]


def _ours(tree):
    return [node for node in tree.nodes if _ROLE in node]


def has_beams(scene):
    tree = _tree(scene)
    return tree is not None and bool(_ours(tree))


def _render_layers(tree, scene, view_layer):
    """The nodes that give the view layer's passes, at least one: it is made if there is none."""
    nodes = [node for node in tree.nodes if node.bl_idname == "CompositorNodeRLayers"]
    found = [node for node in nodes if node.scene == scene and node.layer == view_layer.name]
    if not found:
        node = tree.nodes.new("CompositorNodeRLayers")
        node.scene = scene
        node.layer = view_layer.name
        node.location = (-600, 0 if not nodes else min(node.location.y for node in nodes) - 700)
        found = [node]
    return found


def _mix(tree, role, operation, label):
    """A node that computes with two colours, and its sockets: node, factor, A, B, result."""
    # Blender 5.0 has another kind of node than those before, with sockets for each kind of data; some are enabled.
    new = bpy.app.version >= (5, 0, 0)
    node = tree.nodes.new("ShaderNodeMix" if new else "CompositorNodeMixRGB")
    if new:
        node.data_type = "RGBA"
    node.blend_type = operation
    node.label = label
    node[_ROLE] = role
    factor, a, b = [socket for socket in node.inputs if socket.enabled][:3]
    factor.default_value = 1.0
    return node, factor, a, b, next(socket for socket in node.outputs if socket.enabled)


def _image_node(tree, beams, view_layer):
    """A node that shows the view layer's picture in the file of each frame."""
    image = bpy.data.images.load(beams.path(beams.first), check_existing=True)
    image.source = "SEQUENCE"
    # The compositor's preview keeps what it has loaded.
    image.reload()
    node = tree.nodes.new("CompositorNodeImage")
    node.label = "Light in Fog (Covbeam)"
    node[_ROLE] = "image"
    node.image = image
    node.frame_duration = beams.last - beams.first + 1
    node.frame_start = beams.first
    node.frame_offset = beams.first - 1
    node.use_auto_refresh = True
    node.layer = view_layer.name
    return node


def _source(layers):
    """The name of the sockets of the render layers that the artist uses: the denoised image, else the noisy one."""
    names = ("Image", "Noisy Image")
    linked = [name for name in names if any(name in node.outputs and node.outputs[name].is_linked for node in layers)]
    return linked[0] if linked else "Image"


def _targets(layers):
    """The sockets that the picture of the render layers goes to."""
    source = _source(layers)
    return [link.to_socket for node in layers if source in node.outputs for link in node.outputs[source].links]


def add(scene, view_layers, beams, noisy):
    """Sets up the nodes of view layers, in the place of all from an earlier call. Returns what the artist should know.

    noisy: names of view layers whose beams are better denoised, where Cycles' picture is. The first view layer that is rendered goes to the output if
    nothing does, as it does without a compositor.
    """
    advice = []
    if not scene.render.use_compositing:
        scene.render.use_compositing = True
        advice.append("Compositing was off in the output properties: it is on now.")
    remove(scene)
    tree = _make_tree(scene)
    output = _output_input(tree)
    if not output.is_linked:
        first = _render_layers(tree, scene, scene.view_layers[beams.view_layers[0]])
        if not _targets(first):
            tree.links.new(first[0].outputs["Image"], output)
    for view_layer in view_layers:
        advice += _add(tree, scene, view_layer, beams, view_layer.name in noisy)
    return advice


def _add(tree, scene, view_layer, beams, is_noisy):
    """Sets up the nodes of one view layer. Returns what the artist should know."""
    advice = []
    all_layers = _render_layers(tree, scene, view_layer)
    layers, source, targets = all_layers[0], _source(all_layers), _targets(all_layers)
    # Cycles denoises its image, not its passes of fog light: only from the noisy image can they be subtracted.
    denoised = source == "Image" and scene.cycles.use_denoising and view_layer.cycles.use_denoising
    needed = (*_VOLUME_PASSES, _GUIDES) if denoised else _VOLUME_PASSES
    switched_on = [name for name in needed if not getattr(view_layer.cycles, name)]
    for name in switched_on:
        setattr(view_layer.cycles, name, True)
    if not targets:
        advice.append(
            f'The picture of the view layer "{view_layer.name}" goes nowhere in the compositor: connect its node {_label(beams.frames)} where it '
            "belongs."
        )

    light = layers.outputs["Noisy Image" if denoised else source]
    x, y = layers.location.x + 320, layers.location.y
    nodes = []
    for names in _VOLUME_SOCKETS:
        volume = next(layers.outputs[name] for name in names if name in layers.outputs)
        node, _, a, b, result = _mix(tree, volume.name, "SUBTRACT", f"Without {volume.name}")
        tree.links.new(light, a)
        tree.links.new(volume, b)
        nodes.append(node)
        light = result
    # Beams are added behind the denoiser, which may change how bright they are: of pure blue it takes a tenth. Noisy ones have one of their own.
    if denoised:
        nodes.append(_denoise(tree, layers, light))
        light = nodes[-1].outputs["Image"]
        advice.append(
            "Cycles denoises this scene: the nodes take its noisy image, remove Cycles' fog light from it, and denoise "
            "what is left, guided by Cycles' denoising data."
        )
    image = _image_node(tree, beams, view_layer)
    of_beams, fog = [image], image.outputs[_PASS]
    if denoised and is_noisy:
        of_beams.append(_denoise(tree, layers, fog))
        fog = of_beams[-1].outputs["Image"]
        advice.append(f'The light in fog of "{view_layer.name}" is noisy, so the nodes denoise it, too: more time or passes do without.')
    node, _, a, b, result = _mix(tree, "sum", "ADD", "Add Light in Fog")
    tree.links.new(light, a)
    tree.links.new(fog, b)
    nodes.append(node)
    node, factor, a, b, switched = _mix(tree, _SWITCH, "MIX", _label(beams.frames))
    tree.links.new(layers.outputs[source], a)
    tree.links.new(result, b)
    _show(_drive(factor), beams.frames)
    node[_FRAMES] = beams.first, beams.last, beams.step
    node[_SOURCE] = source
    node[_SWITCHED_ON] = {"view_layer": view_layer.name, "passes": ",".join(switched_on)}
    nodes.append(node)
    for target in targets:
        tree.links.new(switched, target)
    for row, of_row in ((0, nodes), (-300, of_beams)):
        for index, node in enumerate(of_row):
            node.location = (x + 200 * index, y + row)
            node[_LAYER] = view_layer.name
    return advice


def _denoise(tree, layers, light):
    """A denoiser of what a socket gives, guided by what the render layers know of surfaces."""
    node = tree.nodes.new("CompositorNodeDenoise")
    node[_ROLE] = "denoise"
    tree.links.new(light, node.inputs["Image"])
    for name, guide in _GUIDE_SOCKETS.items():
        tree.links.new(layers.outputs[guide], node.inputs[name])
    return node


def _label(frames):
    """Of the switch: which frames, a range, have beams."""
    if len(frames) == 1:
        return f"Light in Fog: frame {frames[0]}"
    every = "" if frames.step == 1 else f", every {frames.step}"
    return f"Light in Fog: frames {frames[0]} to {frames[-1]}{every}"


def _drive(factor):
    """Makes a factor a curve over frames, which it returns, without an action of its own in the file."""
    curve = factor.driver_add("default_value")
    curve.driver.type = "SCRIPTED"
    # Blender computes expressions that are as simple as this one itself, without its permission to run scripts.
    curve.driver.expression = "frame"
    for modifier in list(curve.modifiers):
        curve.modifiers.remove(modifier)
    return curve


def _show(curve, frames):
    """Makes the curve of a switch 1 in frames, a sequence, and 0 in all others."""
    keys = dict.fromkeys((beside for frame in frames for beside in (frame - 1, frame + 1)), 0.0)
    keys.update(dict.fromkeys(frames, 1.0))
    curve.keyframe_points.clear()
    for frame, value in sorted((keys or {0: 0.0}).items()):
        curve.keyframe_points.insert(frame, value, options={"FAST"}).interpolation = "CONSTANT"
    curve.update()


def _shown(curve):
    return [round(point.co.x) for point in curve.keyframe_points if point.co.y == 1]


def look_for_files(scene):
    """Lets Cycles' fog light stand in frames whose files are not there, and beams in all others that were rendered.

    Returns what the artist should know, texts.
    """
    for switch in _switches(scene):
        tree, (first, last, step) = switch.id_data, switch[_FRAMES]
        curve = tree.animation_data and tree.animation_data.drivers.find(_mix_factor(switch).path_from_id("default_value"))
        image = next((node.image for node in _ours(tree) if node[_ROLE] == "image" and node[_LAYER] == switch[_LAYER]), None)
        if curve is None or image is None:
            # The artist has made them something else.
            continue
        frames = range(first, last + 1, step)
        stem = bpy.path.abspath(image.filepath, library=image.library).removesuffix(f"{first:04}.exr")
        there = [frame for frame in frames if os.path.isfile(f"{stem}{frame:04}.exr")]
        if there == _shown(curve):
            continue
        _show(curve, there)
        missing = sorted({*frames}.difference(there))
        switch.label = _label(frames)
        switch.pop(_MISSING, None)
        if missing:
            switch.label += f" ({len(missing)} missing)"
            switch[_MISSING] = (
                f"Light in fog of Covbeam is missing in {len(missing)} of {len(frames)} frames, where Cycles' fog light stands: there is "
                f"no file {stem}{missing[0]:04}.exr. Add Beams renders it again."
            )
    return missing_files(scene)


def missing_files(scene):
    """What the artist should know of files that `look_for_files` has not found, texts."""
    return list(dict.fromkeys(switch[_MISSING] for switch in _switches(scene) if _MISSING in switch))


def _switches(scene):
    return [node for node in _ours(_tree(scene)) if _FRAMES in node] if has_beams(scene) else []


def _mix_factor(node):
    """The factor of a node of `_mix`."""
    return next(socket for socket in node.inputs if socket.enabled)


def remove(scene):
    """Removes the nodes, connects what they stood between, and switches off the passes that were off before."""
    if not has_beams(scene):
        return
    tree = _tree(scene)
    ours = _ours(tree)
    for last in [node for node in ours if _SWITCHED_ON in node]:
        switched_on = last[_SWITCHED_ON]
        layers = next(filter(None, (_feeding_layers(node) for node in ours if node.get(_LAYER) == last.get(_LAYER))), None)
        result = next(socket for socket in last.outputs if socket.enabled)
        if layers is not None:
            for link in list(result.links):
                tree.links.new(layers.outputs[last[_SOURCE]], link.to_socket)
        view_layer = scene.view_layers.get(switched_on["view_layer"])
        if view_layer is not None:
            for name in filter(None, switched_on["passes"].split(",")):
                setattr(view_layer.cycles, name, False)
    for node in ours:
        image = node.image if node.bl_idname == "CompositorNodeImage" else None
        tree.nodes.remove(node)
        if image is not None and image.users == 0:
            bpy.data.images.remove(image)


def _feeding_layers(node):
    """The render layers that a node of ours reads, or None."""
    links = (link for socket in node.inputs for link in socket.links)
    return next((link.from_node for link in links if link.from_node.bl_idname == "CompositorNodeRLayers"), None)
