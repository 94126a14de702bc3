# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that put covbeam's fog light in the place of Cycles':

    (noisy) image of Cycles - volume direct - volume indirect [-> denoise] + in-scattered light of covbeam

Cycles' fog is subtracted, not switched off: that is exact whatever the scene has, and undone by taking nodes away.

They stand between the render layers and whatever these went to, carry a mark, and are made once.
"""

import bpy

#: Custom property of our nodes: what a node is for. The last one is the sum.
_ROLE = "covbeam"
_SUM = "sum"

#: Custom properties of the sum: the socket of the render layers that it stands for, and passes that were off before.
_SOURCE = "covbeam_source"
_SWITCHED_ON = "covbeam_passes"

_VOLUME_PASSES = ("use_pass_volume_direct", "use_pass_volume_indirect")

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
    return {node[_ROLE]: node for node in tree.nodes if _ROLE in node}


def has_beams(scene):
    tree = _tree(scene)
    return tree is not None and bool(_ours(tree))


def _render_layers(tree, scene, view_layer):
    """The node that gives the view layer's passes; made if there is none."""
    nodes = [node for node in tree.nodes if node.bl_idname == "CompositorNodeRLayers"]
    for node in nodes:
        if node.scene == scene and node.layer == view_layer.name:
            return node
    node = tree.nodes.new("CompositorNodeRLayers")
    node.scene = scene
    node.layer = view_layer.name
    node.location = (-600, 0)
    return node


def _mix(tree, role, operation, label):
    """A node that computes with two colours, and its sockets: node, A, B, result."""
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
    return node, a, b, next(socket for socket in node.outputs if socket.enabled)


def _image_node(tree, beams):
    """A node that shows the file of each frame; before and after them, that of the nearest one."""
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
    node.layer = beams.view_layer
    return node


def _source(layers):
    """The socket of the render layers that the artist uses: the denoised image, else the noisy one."""
    linked = [name for name in ("Image", "Noisy Image") if name in layers.outputs and layers.outputs[name].is_linked]
    return layers.outputs[linked[0] if linked else "Image"]


def add(scene, view_layer, beams):
    """Sets up the nodes, in the place of those from an earlier call. Returns what the artist should know."""
    advice = []
    if not scene.render.use_compositing:
        scene.render.use_compositing = True
        advice.append("Compositing was off in the output properties: it is on now.")
    remove(scene)
    switched_on = [name for name in _VOLUME_PASSES if not getattr(view_layer.cycles, name)]
    for name in switched_on:
        setattr(view_layer.cycles, name, True)

    tree = _make_tree(scene)
    layers = _render_layers(tree, scene, view_layer)
    source = _source(layers)
    targets = [link.to_socket for link in source.links]
    output = _output_input(tree)
    if not targets and not output.is_linked:
        targets = [output]
    if not targets:
        advice.append(
            "The compositor's output does not come from the render layers: connect the node Add Light in Fog where it "
            "belongs."
        )

    # Cycles denoises its image, not its passes of fog light: only from the noisy image can they be subtracted.
    denoised = source.name == "Image" and scene.cycles.use_denoising and view_layer.cycles.use_denoising
    light = layers.outputs["Noisy Image"] if denoised else source
    x, y = layers.location.x + 320, layers.location.y
    nodes = []
    for names in _VOLUME_SOCKETS:
        volume = next(layers.outputs[name] for name in names if name in layers.outputs)
        node, a, b, result = _mix(tree, volume.name, "SUBTRACT", f"Without {volume.name}")
        tree.links.new(light, a)
        tree.links.new(volume, b)
        nodes.append(node)
        light = result
    if denoised:
        node = tree.nodes.new("CompositorNodeDenoise")
        node[_ROLE] = "denoise"
        tree.links.new(light, node.inputs["Image"])
        nodes.append(node)
        light = node.outputs["Image"]
        advice.append(
            "Cycles denoises this scene: the nodes take its noisy image, remove Cycles' fog light from it, and denoise "
            "what is left."
        )
    image = _image_node(tree, beams)
    node, a, b, result = _mix(tree, _SUM, "ADD", "Add Light in Fog")
    tree.links.new(light, a)
    tree.links.new(image.outputs[_PASS], b)
    for target in targets:
        tree.links.new(result, target)
    node[_SOURCE] = source.name
    node[_SWITCHED_ON] = {"view_layer": view_layer.name, "passes": ",".join(switched_on)}
    nodes.append(node)
    for index, node in enumerate(nodes):
        node.location = (x + 200 * index, y)
    image.location = (x, y - 300)
    return advice


def remove(scene):
    """Removes the nodes, connects what they stood between, and switches off the passes that were off before."""
    if not has_beams(scene):
        return
    tree = _tree(scene)
    ours = _ours(tree)
    last = ours.get(_SUM)
    if last is not None:
        layers = next((node for node in map(_feeding_layers, ours.values()) if node is not None), None)
        result = next(socket for socket in last.outputs if socket.enabled)
        if layers is not None:
            for link in list(result.links):
                tree.links.new(layers.outputs[last[_SOURCE]], link.to_socket)
        switched_on = last[_SWITCHED_ON]
        view_layer = scene.view_layers.get(switched_on["view_layer"])
        if view_layer is not None:
            for name in filter(None, switched_on["passes"].split(",")):
                setattr(view_layer.cycles, name, False)
    for node in ours.values():
        image = node.image if node.bl_idname == "CompositorNodeImage" else None
        tree.nodes.remove(node)
        if image is not None and image.users == 0:
            bpy.data.images.remove(image)


def _feeding_layers(node):
    """The render layers that a node of ours reads, or None."""
    links = (link for socket in node.inputs for link in socket.links)
    return next((link.from_node for link in links if link.from_node.bl_idname == "CompositorNodeRLayers"), None)
