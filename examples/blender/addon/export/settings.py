# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of the scene, the view layer and the camera that the host does not honour: all reported."""

import numpy as np

from ..host.scene import LightKind

#: Kinds of lamps whose light thins out.
_THINNING = {LightKind.POINT, LightKind.SPOT, LightKind.AREA, LightKind.MESH}


def note_settings(depsgraph, camera_object, report):
    """Reports what differs from what is rendered."""
    scene, layer = depsgraph.scene_eval, depsgraph.view_layer_eval
    source = "Scene"
    data = None if camera_object is None else camera_object.evaluated_get(depsgraph).data
    if data is not None and data.type == "PANO" and data.dof.use_dof and (data.dof.aperture_blades > 2 or data.dof.aperture_ratio != 1):
        report.add(f'Camera "{camera_object.name}"', "shape of a panorama's aperture", "turned otherwise about each ray", in_fog=True)
    if scene.render.use_multiview:
        report.add(source, "stereoscopy", "one view, from the camera itself")
    if hasattr(scene, "covbeam") and scene.covbeam.orders == "ALL":
        report.add(source, "limits of Cycles' Light Paths", "light of all orders, as Light in Advanced says")
    if hasattr(scene, "cycles"):
        if scene.cycles.use_fast_gi:
            report.add(source, "Fast GI Approximation", "light is followed as often as Light Paths let", in_fog=True)
        if scene.cycles.sample_clamp_direct > 0:
            report.add(source, "Clamp Direct", "nothing is clamped; set it to 0", in_fog=True)
        # What is brighter than all that a picture shows is taken for noise.
        if 0 < scene.cycles.sample_clamp_indirect < 1:
            report.add(source, "Clamp Indirect below 1", "nothing is clamped", in_fog=True)
        # Blender's default. Before 5.0 faces of fog count too.
        if scene.cycles.transparent_max_bounces < 8:
            report.add(source, "Transparent Max Bounces below 8", "light passes through as much as there is", in_fog=True)
    source = f'View layer "{layer.name}"'
    for name, what in (("use_solid", "Surfaces"), ("use_volumes", "Volumes")):
        if not getattr(layer, name):
            report.add(source, f"{what} are filtered out", "they are rendered", in_fog=True)


def exposure(scene):
    """The factor on all light of a scene's picture: Film Exposure of Cycles, without which there is none of its settings."""
    return scene.cycles.film_exposure if hasattr(scene, "cycles") else 1.0


def note_clipping(depsgraph, camera_object, scene, world_fog, report):
    """Reports that Cycles ends what the camera sees at its clip distance, where something is there.

    - scene: host.scene.Scene; world_fog: volumes.Fog or None.
    """
    data = camera_object.evaluated_get(depsgraph).data
    source = f'Camera "{camera_object.name}"'
    eye, (low, high) = scene.camera.position, scene.geometry.bounds
    farthest = np.linalg.norm(np.maximum(np.abs(low - eye), np.abs(high - eye)))
    if np.isfinite(farthest) and farthest > data.clip_end:
        report.add(source, "objects beyond Clip End", "seen all the same", in_fog=True)
    if world_fog is not None and _lost(eye, scene.lights, world_fog, data.clip_end) > 0.01:
        report.add(source, "Clip End, which ends the fog of the world in Cycles", "the fog goes on; raise Clip End", in_fog=True)


def _lost(eye, lights, world_fog, clip_end):
    """A bound on the share of the light in fog that is farther away than clip_end [m]."""
    total = world_fog.at()
    left = float(np.exp(-np.min(total.scattering + total.absorption) * clip_end))
    # Light of a lamp thins out with the square of the distance from it: along a ray that passes it at h the share beyond x is h / (pi x). What a
    # lamp shines on is about as far away as the camera.
    near = [light for light in lights if light.kind in _THINNING and light.falloff == 0]
    if len(near) < len(lights):
        return left
    places = [light.triangles.reshape(-1, 3).astype(np.float64) if len(light.triangles) else light.position[None] for light in near]
    reach = max((float(np.linalg.norm(place - eye, axis=1).max()) for place in places), default=0.0)
    return left if reach >= clip_end else left * reach / (np.pi * (clip_end - reach))
