# SPDX-License-Identifier: GPL-3.0-or-later
"""The evaluated scene at instants while the shutter is open -> host.scene.Scenes, for motion blur."""

from dataclasses import fields, is_dataclass, replace
from math import floor

import numpy as np
from covbeam.session import Geometry

from ..host.scene import LightKind
from .scene import export, home_of

#: How many, a power of two. What moves is seen at as many places: they take as long to read, and as much memory for what moves.
INSTANTS = 8

#: Places where the shutter's curve is looked up.
_PLACES = 256


def exposures(depsgraph, frame_set, poll=None):
    """What `export` reads at instants of the time that the shutter is open, each of an equal share of its light, in their order.

    - frame_set: a function of a frame and the part of one beyond it, that evaluates `depsgraph` there: RenderEngine.frame_set.

    Returns a list of host.scene.Scene and a Report: of a single scene, at the frame, without motion blur and where nothing moves. Raises
    report.Untranslatable.
    """
    scene = depsgraph.scene_eval
    if not scene.render.use_motion_blur:
        made, report = export(depsgraph, poll)
        return [made], report
    frame, part = scene.frame_current, scene.frame_subframe
    times = frame + part + moments(scene.render, INSTANTS)
    found, home = {}, home_of(depsgraph)
    try:
        # Where the first of them, which are far apart, are alike, so are all.
        for number in _far_apart(INSTANTS):
            frame_set(floor(times[number]), times[number] - floor(times[number]))
            found[number] = export(depsgraph, poll, home)
            if len(found) == 3 and all(_alike(made, found[0][0]) for made, _ in found.values()):
                return [found[0][0]], found[0][1]
    finally:
        frame_set(frame, part)
    scenes = [_shared(found[number][0], found[0][0]) for number in range(INSTANTS)]
    report = found[0][1]
    _note(depsgraph, scenes, report)
    if len({_kind(made) for made in scenes}) > 1:
        made, report = export(depsgraph, poll)
        source = "Scene"
        report.add(source, "motion blur of light or fog that is not there all the time", "everything stands still at the frame", in_fog=True)
        return [made], report
    return scenes, report


def moments(render, count):
    """When the shutter lets through the middles of `count` equal shares of the light, from the frame on [frames], for RenderSettings."""
    curve = render.motion_blur_shutter_curve
    curve.initialize()
    middles = (np.arange(_PLACES) + 0.5) / _PLACES
    open_ = np.maximum([curve.evaluate(curve.curves[0], place) for place in middles], 0)
    let_through = np.concatenate([[0], np.cumsum(open_)])
    if let_through[-1] == 0:
        let_through = np.arange(_PLACES + 1.0)
    shares = (np.arange(count) + 0.5) / count
    of_open = np.interp(shares, let_through / let_through[-1], np.linspace(0, 1, _PLACES + 1))
    begins = {"START": 0, "CENTER": -0.5, "END": -1}[render.motion_blur_position]
    return render.motion_blur_shutter * (begins + of_open)


def _far_apart(count):
    """The numbers below a power of two, each far from those before it: 0, then the middle, then the quarters."""
    order = [0]
    while len(order) < count:
        step = count // (2 * len(order))
        order += [number + step for number in order]
    return order


def _alike(one, other):
    """Whether two things that are exported are the same."""
    if is_dataclass(one):
        return type(one) is type(other) and all(_alike(getattr(one, each.name), getattr(other, each.name)) for each in fields(one))
    if isinstance(one, (list, tuple)):
        return len(one) == len(other) and all(map(_alike, one, other))
    if isinstance(one, np.ndarray):
        return np.array_equal(one, other)
    if isinstance(one, Geometry):
        return one.digest == other.digest
    return one == other


def _shared(made, first):
    """A Scene that shares the geometry of the first, if that is the same."""
    return replace(made, geometry=first.geometry) if _alike(made.geometry, first.geometry) else made


def _kind(made):
    """What instants must have in common to be of one picture."""
    return len(made.volumes), bool(made.lights)


def _note(depsgraph, scenes, report):
    """Reports what Cycles blurs otherwise of scenes in which something moves."""
    scene = depsgraph.scene_eval
    source = "Scene"
    lamps = [[light for light in made.lights if light.kind not in {LightKind.MESH, LightKind.WORLD}] for made in scenes]
    if not all(_alike(each, lamps[0]) for each in lamps):
        report.add(source, "lamps that move while the shutter is open", "blurred; in Cycles they stand still", in_fog=True)
    # Without Cycles there are none of its settings.
    if hasattr(scene, "cycles") and scene.cycles.rolling_shutter_type != "NONE":
        report.add(source, "rolling shutter", "all of the picture at the same time", in_fog=True)
    for thing in depsgraph.objects:
        if hasattr(thing, "cycles") and not thing.cycles.use_motion_blur:
            report.add(f'Object "{thing.name}"', "Motion Blur is off", "blurred as all others", in_fog=True)
