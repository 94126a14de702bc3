"""Where the picture needs photons, and what follows from it for a light path: how often it goes on.

    importance = Importance(layout)
    importance.add_eye_rays(medium, rays, weights)     # of a coarse picture: 1 / (pixels x luminance)
    importance.add_paths(medium, segments, weights)    # what these rays see scattered
    importance.resolve()
    worth = importance.of_segments(medium, candidates) # directions in which a photon may go on
    factors = power * (worth["beam"] + worth["scattered"]) / wanted
    weight_window(factors, u)                          # of its power; 0: it ends
"""

import ctypes

from ._arrays import COUNT, FLOAT, VECTOR, Kind, changed, elementwise, given, made, struct
from ._handles import Object, Owner, using
from ._library import check, lib
from .dtypes import EYE_RAY, IMPORTANCE_CELL, SEGMENT_IMPORTANCE
from .media import Medium, _layout


class Importance(Object):
    """The share of the picture's light, relative to its brightness, that a watt brings about, in voxels. It collects what the camera
    sees (add_eye_rays, add_paths, add_surfaces), is resolved once, before the first pass, and is looked up from then on.

    Only probabilities follow from it: a wrong importance costs noise and never makes a picture wrong. 24 bytes a voxel, and 12 more
    from the first resolve on.
    """

    def __init__(self, layout):
        box = _layout(layout)
        self._owner = Owner(lib.covbeam_importance_new, lib.covbeam_importance_free, ctypes.addressof(box))

    def add_eye_rays(self, medium, rays, weights):
        """Adds pieces of eye rays: beams that cross them are seen.

        - medium: a Medium that the pieces run through.
        - rays: EYE_RAY of shape () or (n,).
        - weights: of the ray at the piece's origin, finite and >= 0; at the camera 1/(N L), for N pixels and the luminance L that this
          one has about. Where L is next to nothing, bound it.
        """
        self._add(lib.covbeam_importance_add_eye_rays, medium, "rays", rays, weights)

    def add_paths(self, medium, paths, weights):
        """Adds segments that paths from the camera fly after they were scattered, by the medium or by a diffuse surface.

        - paths: EYE_RAY, away from the camera.
        - weights: of the path at the segment's origin.
        """
        self._add(lib.covbeam_importance_add_paths, medium, "paths", paths, weights)

    def _add(self, function, medium, name, pieces, weights):
        medium, pieces = struct("medium", medium, Medium), given(name, pieces, Kind(EYE_RAY))
        with using(changed=self) as [importance]:
            elementwise(function, importance, medium, COUNT, pieces, given("weights", weights, FLOAT))

    def add_surfaces(self, positions, weights):
        """Adds places on diffuse surfaces that paths from the camera see.

        - positions: [m]; one outside the box adds nothing.
        - weights: of the path there times albedo/pi.
        """
        with using(changed=self) as [importance]:
            elementwise(
                lib.covbeam_importance_add_surfaces,
                importance,
                COUNT,
                given("positions", positions, VECTOR),
                given("weights", weights, FLOAT),
            )

    def merge(self, others):
        """Adds what others of the same layout have collected, in their order; they stay as they are."""
        others = list(others)
        with using(*others, changed=self) as [*handles, importance]:
            array = (ctypes.c_void_p * len(handles))(*handles)
            check(lib.covbeam_importance_merge(importance, ctypes.addressof(array), len(handles)))

    def resolve(self):
        """Computes the importance of every voxel, smoothed; look-ups see the state of this call until the next one."""
        with using(changed=self) as [importance]:
            check(lib.covbeam_importance_resolve(importance))

    def at(self, positions, *, out=None):
        """The importance around points [m]: IMPORTANCE_CELL; outside the box that of the nearest voxel."""
        with using(self) as [importance]:
            return elementwise(
                lib.covbeam_importance_at,
                importance,
                COUNT,
                given("positions", positions, VECTOR),
                made("out", out, Kind(IMPORTANCE_CELL)),
            )

    def of_segments(self, medium, segments, *, out=None):
        """What a watt that flies along segments of light paths is worth: SEGMENT_IMPORTANCE; nothing outside the box.

        - medium: a Medium that the segments run through.
        - segments: EYE_RAY, with the direction of the light, each to the next surface.
        """
        with using(self) as [importance]:
            return elementwise(
                lib.covbeam_importance_of_segments,
                importance,
                struct("medium", medium, Medium),
                COUNT,
                given("segments", segments, Kind(EYE_RAY)),
                made("out", out, Kind(SEGMENT_IMPORTANCE)),
            )


def weight_window(factors, u):
    """Splits and ends light paths: of some candidates, which go on, and by what their power is multiplied. In place.

    - factors: float32 of shape (n,). In: of each candidate, how many of it should go on: its power times its importance, over what
      power times importance is to be; finite and >= 0. Out: the factor of its power, 0 where it ends; its mean over u is 1.
    - u: uniform in [0, 1), a new one for each call.
    """
    elementwise(lib.covbeam_weight_window, COUNT, changed("factors", factors, FLOAT), u)
