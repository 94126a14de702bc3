# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of the scene, the view layer and the camera that the host does not honour: all reported."""

import numpy as np


def note_settings(depsgraph, camera_object, report):
    """Reports what differs from what is rendered."""
    scene, layer = depsgraph.scene_eval, depsgraph.view_layer_eval
    source = f'Scene "{scene.name}"'
    data = None if camera_object is None else camera_object.evaluated_get(depsgraph).data
    if data is not None and data.type == "PANO" and data.dof.use_dof and (data.dof.aperture_blades > 2 or data.dof.aperture_ratio != 1):
        report.add(f'Camera "{camera_object.name}"', "shape of a panorama's aperture", "turned otherwise about each ray", in_fog=True)
    if scene.render.use_multiview:
        report.add(source, "stereoscopy", "one view, from the camera itself")
    if hasattr(scene, "covbeam") and scene.covbeam.orders == "ALL":
        report.add(source, "limits of Cycles' Light Paths", "light of all orders, as Light in Advanced says")
    source = f'View layer "{layer.name}"'
    for name, what in (("use_solid", "Surfaces"), ("use_volumes", "Volumes")):
        if not getattr(layer, name):
            report.add(source, f"{what} are filtered out", "they are rendered", in_fog=True)


def exposure(scene):
    """The factor on all light of a scene's picture: Film Exposure of Cycles, without which there is none of its settings."""
    return scene.cycles.film_exposure if hasattr(scene, "cycles") else 1.0


def note_clipping(depsgraph, camera_object, camera, bounds, world_fog, report):
    """Reports that Cycles ends what the camera sees at its clip distance, where something is there.

    - camera: host.scene.Camera; bounds: corners of all geometry [m]; world_fog: volumes.Fog or None.
    """
    data = camera_object.evaluated_get(depsgraph).data
    source = f'Camera "{camera_object.name}"'
    low, high = bounds
    farthest = np.linalg.norm(np.maximum(np.abs(low - camera.position), np.abs(high - camera.position)))
    if np.isfinite(farthest) and farthest > data.clip_end:
        report.add(source, "objects beyond Clip End", "seen all the same", in_fog=True)
    if world_fog is not None:
        total = world_fog.at()
        extinction = np.min(total.scattering + total.absorption)
        # Beyond 7 mean free paths less than a thousandth of the light arrives.
        if extinction * data.clip_end < 7:
            report.add(source, "Clip End, which ends the fog of the world in Cycles", "the fog goes on; raise Clip End", in_fog=True)
