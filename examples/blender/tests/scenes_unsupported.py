# SPDX-License-Identifier: GPL-3.0-or-later
"""A Blender scene with everything in it that covbeam cannot render as Cycles does, and what the report has to say."""

import bpy
import scenes_export as scenes
from scenes_export import add, joined, node, shader


def build():
    """Makes the scene. Returns the expected entries: set of pairs of a source and the start of `what`."""
    scene = scenes.empty()
    scenes.look(scene.camera, (0, -20, 5), (0, 0, 0))
    expected = set()
    for part in (_settings, _world, _objects, _flags, _surfaces, _textures, _volumes, _lights):
        expected |= part(scene)
    bpy.context.view_layer.update()
    return expected


def _all(source, *whats):
    return {(source, what) for what in whats}


def _settings(scene):
    scene.render.use_multiview = scene.cycles.use_fast_gi = True
    scene.cycles.sample_clamp_direct, scene.cycles.sample_clamp_indirect = 1.0, 0.5
    scene.cycles.transparent_max_bounces = 0
    layer = bpy.context.view_layer
    layer.use_solid = layer.use_volumes = False
    camera = scene.camera.data
    camera.dof.use_dof = True
    camera.clip_end, camera.clip_start = 15.0, 0.1
    return (
        _all("Scene", "stereoscopy", "Fast GI Approximation", "Clamp Direct", "Clamp Indirect", "Transparent Max Bounces")
        | _all('View layer "ViewLayer"', "Surfaces", "Volumes")
        | _all('Camera "Camera"', "objects beyond Clip End", "Clip End, which ends the fog")
    )


def _world(scene):
    scenes.world(None, shader("VolumePrincipled", {"Density": 0.02, "Emission Strength": 1.0}))
    return _all('World "World"', "light that fog without end sends out")


def _objects(scene):
    cloud = bpy.data.volumes.new("Cloud")
    cloud.filepath = "/there/is/no/cloud.vdb"
    cloud.materials.append(scenes.material("Cloudy", volume=shader("VolumePrincipled")))
    add(cloud)
    pencil = bpy.ops.object.grease_pencil_add if bpy.app.version >= (4, 3) else bpy.ops.object.gpencil_add
    pencil(type="EMPTY")
    bpy.context.object.name = "Pencil"
    smoke = scenes.box("Smoke").modifiers.new("Fluid", "FLUID")
    smoke.fluid_type = "DOMAIN"
    # Nothing is simulated: that aborts in the bpy package.
    smoke.show_viewport = smoke.show_render = False
    diced = scenes.box("Diced")
    modifier = diced.modifiers.new("Subdivision", "SUBSURF")
    (modifier if bpy.app.version >= (5, 0) else diced.cycles).use_adaptive_subdivision = True
    scenes.box("Broken").data.vertices[0].co.x = float("inf")
    return (
        _all('Object "Cloud"', "OpenVDB file cloud.vdb (cloud.vdb not found)")
        | _all('Object "Pencil"', "grease pencil")
        | _all('Object "Smoke"', "smoke domain without smoke")
        | _all('Object "Diced"', "adaptive subdivision")
        | _all('Object "Broken"', "coordinates that are too large")
    )


def _flags(scene):
    thing = scenes.box("Hidden", material=scenes.material("Haze", volume=scenes.shader("VolumeScatter")))
    for rays in ("camera", "diffuse", "glossy", "transmission", "volume_scatter", "shadow"):
        setattr(thing, f"visible_{rays}", False)
    thing.is_shadow_catcher = thing.is_holdout = True
    thing.light_linking.blocker_collection = bpy.data.collections.new("Blockers")
    # What hides things before Blender 5.0 from volume scatter rays has no effect, and fog from shadow rays another one.
    last = "is hidden from volume scatter" if bpy.app.version >= (5, 0) else "casts no shadow"
    rays = "is hidden from diffuse", "is hidden from glossy", "is hidden from transmission", last
    expected = _all('Object "Hidden"', *(f"fog that {each}" for each in (*rays, "is a shadow catcher")))
    maker = add(None, "Maker", instance_type="COLLECTION", instance_collection=bpy.data.collections.new("Made"))
    maker.instance_collection.objects.link(bpy.data.objects.new("Twin", scenes.box("First").data))
    maker.visible_camera = False
    for name in ("holdout", "indirect_only"):
        collection = bpy.data.collections.new(name)
        scene.collection.children.link(collection)
        setattr(bpy.context.view_layer.layer_collection.children[name], name, True)
        member = scenes.box(f"In {name}")
        scene.collection.objects.unlink(member)
        collection.objects.link(member)
    return expected


#: What a material has, and what the report says of it.
_SURFACES = {
    "Car": (
        shader(
            "BsdfPrincipled",
            {
                **{"Coat Weight": 1.0, "Sheen Weight": 1.0, "Anisotropic": 0.5, "Thin Film Thickness": 300.0},
                **{"Subsurface Weight": 0.5, "Specular Tint": (1, 0.5, 0.2)},
            },
        ),
        ("coat", "sheen", "anisotropic reflection", "thin film", "subsurface scattering", "specular tint"),
    ),
    "Gold": (shader("BsdfPrincipled", {"Metallic": 1.0, "Specular Tint": (1, 0.5, 0.2)}), ("edge tint of metal",)),
    "Clay": (shader("BsdfDiffuse", {"Roughness": 0.5}), ("roughness of Diffuse",)),
    "Lens": (shader("BsdfRefraction", {"Roughness": 0.2}), ("Refraction BSDF", "Beckmann microfacets")),
    "Brushed": (shader("BsdfAnisotropic", {"Anisotropy": 0.5}), ("anisotropic reflection",)),
    "Skin": (shader("SubsurfaceScattering"), ("subsurface scattering",)),
    "Toon": (shader("BsdfToon"), ("Toon BSDF",)),
    "Velvet": (shader("BsdfSheen"), ("Sheen BSDF",)),
    "Hair": (shader("BsdfHair"), ("Hair BSDF",)),
    "Hole": (shader("Holdout"), ("Holdout",)),
    "Door": (shader("BsdfRayPortal"), ("Ray Portal BSDF",)),
    "Two": (
        joined(
            "AddShader",
            shader("BsdfGlass", {"Roughness": 0.3, "IOR": 1.3}),
            joined("MixShader", shader("BsdfGlass", {"IOR": 1.8}), shader("BsdfTransparent"), 0.3),
        ),
        ("several indices of refraction", "several roughnesses", "reflects more light"),
    ),
}


def _surfaces(scene):
    expected = set()
    for name, (surface, whats) in _SURFACES.items():
        material = scenes.material(name, surface)
        material.use_transparent_shadow = name != "Two"
        scenes.box(name, material=material)
        expected |= _all(f'Material "{name}"', *whats)
    return expected


def _linked(kind, output, target, **settings):
    """A closure of type `target`, whose first input comes from an output of a node of type `kind`."""

    def make(tree):
        source, closure = node(tree, kind, **settings), node(tree, target)
        tree.links.new(source.outputs[output], closure.inputs[0])
        return closure

    return make


def _textures(scene):
    def bumpy(tree):
        diffuse = node(tree, "BsdfDiffuse")
        tree.links.new(node(tree, "Bump").outputs[0], diffuse.inputs["Normal"])
        return diffuse

    materials = {
        "Attribute": (_linked("Attribute", 0, "BsdfDiffuse"), "Color of Diffuse BSDF comes from Attribute"),
        "Lost": (_linked("TexImage", 0, "BsdfDiffuse"), "Color of Diffuse BSDF comes from Image Texture, whose image"),
        "Bumpy": (bumpy, "bump or normal map"),
        "Path": (_linked("LightPath", "Is Diffuse Ray", "MixShader"), "Light Path, Is Diffuse Ray"),
        "Fresnel": (_linked("Fresnel", 0, "MixShader"), "Fresnel as a factor"),
        "Facing": (_linked("LayerWeight", "Facing", "MixShader"), "Layer Weight as a factor"),
    }
    expected = set()
    for name, (surface, what) in materials.items():
        scenes.box(name, material=scenes.material(name, surface))
        expected.add((f'Material "{name}"', what))
    for method, what in (("DISPLACEMENT", "displacement by Light Path"), ("BUMP", "bump or normal map of a matt surface")):
        material = scenes.material(method, shader("BsdfDiffuse"))
        material.displacement_method = method
        tree = material.node_tree
        displacement = node(tree, "Displacement")
        tree.links.new(node(tree, "LightPath").outputs["Ray Length"], displacement.inputs["Height"])
        tree.links.new(displacement.outputs[0], tree.nodes["Material Output"].inputs["Displacement"])
        scenes.box(method, material=material)
        expected.add((f'Material "{method}"', what))
    return expected


def _volumes(scene):
    """Each in a box of its own; those of 4.2 can be fewer."""

    def noisy(tree):
        fog = node(tree, "VolumePrincipled", {"Blackbody Intensity": 1.0})
        tree.links.new(node(tree, "AmbientOcclusion").outputs[0], fog.inputs["Density"])
        return fog

    def lights(tree):
        """Dimmer for shadow rays, and for the camera."""
        fog, path, half = node(tree, "VolumeScatter"), node(tree, "LightPath"), node(tree, "Math")
        half.operation = "SUBTRACT"
        half.inputs[0].default_value = 1.5
        tree.links.new(path.outputs["Is Shadow Ray"], half.inputs[1])
        tree.links.new(half.outputs[0], fog.inputs["Density"])
        tree.links.new(path.outputs["Is Camera Ray"], fog.inputs["Anisotropy"])
        return fog

    volumes = {
        "Noisy Fog": (noisy, ("Density of Principled Volume comes from Ambient Occlusion",)),
        "Two Fogs": (lights, ("fog that shadow rays see otherwise", "fog that the camera sees otherwise")),
        "No Fog": (shader("BsdfDiffuse"), ("Diffuse BSDF as a volume",)),
    }
    if bpy.app.version >= (4, 3):
        for kind in ("MIE", "DRAINE", "FOURNIER_FORAND"):
            name = kind.replace("_", "-").title()
            volumes[name] = (shader("VolumeScatter", phase=kind), (f"{name} phase function",))
    expected = set()
    for k, (name, (volume, whats)) in enumerate(volumes.items()):
        scenes.box(name, material=scenes.material(name, volume=volume)).location = (5 * k, 30, 0)
        expected |= _all(f'Material "{name}"', *whats)
    mixed = scenes.box("Mixed", material=bpy.data.materials["Two Fogs"])
    mixed.data.materials.append(bpy.data.materials["Noisy Fog"])
    mixed.data.polygons[0].material_index, mixed.location = 1, (0, 40, 0)
    scenes.grid("Open", material=bpy.data.materials["Two Fogs"]).location = (5, 40, 0)
    for name, what in (("Mixed", "several materials with volumes"), ("Open", "a volume in a mesh that is open")):
        expected.add((f'Object "{name}"', what))
    return expected


def _lights(scene):
    def lamp(name, kind, **settings):
        data = bpy.data.lights.new(name, kind)
        for key, value in settings.items():
            setattr(data, key, value)
        return add(data)

    thing = lamp("Lamp", "POINT", shadow_soft_size=0.2, use_shadow=False)
    thing.visible_diffuse = thing.visible_glossy = thing.visible_transmission = False
    thing.data.cycles.max_bounces = 3
    thing.light_linking.receiver_collection = bpy.data.collections.new("Lit")
    lamp("Dark", "SUN", energy=-1.0)
    lamp("Wide", "SPOT", shadow_soft_size=0.0).scale = (2, 1, 1)
    lamp("Narrow", "AREA", spread=0.0)
    lamp("Nothing", "POINT", shadow_soft_size=0.0).scale = (1, 0, 1)
    parent = add(None, "Parent", scale=(1, 1, 3), rotation_euler=(0.5, 0, 0))
    lean = lamp("Leaning", "AREA")
    lean.parent, lean.rotation_euler = parent, (0, 0.7, 0)
    for name, kind in (("Measured", "TexIES"), ("Falling", "LightFalloff")):
        tree = scenes.tree_of(lamp(name, "POINT", shadow_soft_size=0.0).data)
        emission, root = node(tree, "Emission"), node(tree, "Math", {"Value_001": 0.5}, operation="POWER")
        tree.links.new(node(tree, kind).outputs[1 if name == "Falling" else 0], root.inputs[0])
        tree.links.new(root.outputs[0], emission.inputs["Strength"])
        tree.links.new(emission.outputs[0], node(tree, "OutputLight").inputs["Surface"])
    return (
        _all('Light "Lamp"', "Cast Shadow is off")
        | _all('Light "Dark"', "negative strength")
        | _all('Light "Nothing"', "a scale of 0")
        | _all('Light "Wide"', "spot with uneven scale")
        | _all('Light "Narrow"', "area light without spread")
        | _all('Light "Leaning"', "sheared area light")
        | _all('Light "Measured"', "Strength of Emission comes from IES Texture")
        | _all('Light "Falling"', "a strength that changes with distance")
    )
