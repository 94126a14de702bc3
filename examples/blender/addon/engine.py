# SPDX-License-Identifier: GPL-3.0-or-later
"""The render engine: Blender's calls, turned into an export and a session of passes.

Everything happens in the thread that Blender calls from. Blender locks its interface while `update` reads the scene;
`render` touches nothing of Blender but the engine itself. Viewports have engines of their own: `view_update`, `view_draw`.
"""

import traceback
from contextlib import closing
from time import perf_counter

import bpy

from . import latest, requirements, text
from .budget import Budget
from .pass_names import passes_of
from .settings import session_settings


class CovbeamEngine(bpy.types.RenderEngine):
    """Renders the light that fog scatters towards the camera, and nothing else: surfaces are black."""

    bl_idname = "COVBEAM"
    bl_label = "Covbeam"
    bl_use_preview = False
    bl_use_postprocess = True
    # Materials are those of Cycles: EEVEE shows them in the material preview.
    bl_use_eevee_viewport = True
    bl_use_shading_nodes_custom = False

    #: What the viewport needs, if this is the engine of one.
    view3d = None

    def update_render_passes(self, scene, view_layer):
        for name, channels, letters, kind in passes_of(view_layer):
            self.register_pass(scene, view_layer, name, channels, letters, kind)

    def update(self, data, depsgraph):
        """Reads the scene; `render` takes what this leaves in `job`."""
        scene, view_layer = depsgraph.scene, depsgraph.view_layer
        record = latest.begin(f"{scene.name}, {view_layer.name}, frame {scene.frame_current}")
        self.job = None
        problem = requirements.check()
        if problem is not None:
            self._fail(record, problem)
            return
        self.update_stats("", "Covbeam: reading the scene")
        self.job = self._guarded(record, lambda: _Job(depsgraph, record, self))

    def render(self, depsgraph):
        job, self.job = self.job, None
        view_layer = depsgraph.view_layer.name
        for name, channels, letters, _ in passes_of(depsgraph.view_layer)[1:]:
            self.add_pass(name, channels, letters, layer=view_layer)
        # Blender crashes when it saves a picture that nothing has been put into.
        self.end_result(self.begin_result(0, 0, 1, 1, layer=view_layer))
        if job is not None:
            self._guarded(job.record, lambda: self._render(job))
            # Blender writes them into the header of the image's file.
            for name, value in job.record.fields().items():
                self.get_result().stamp_data_add_field(f"covbeam.{view_layer}.{name}", value)

    def _render(self, job):
        from .first_look import first_look, pixel_size
        from .host.groups import GroupSession, split
        from .host.session import Session
        from .passes import Passes, put

        missing = [what for what, given in (("fog", job.scene.volumes), ("light", job.scene.shines)) if not given]
        if missing:
            # As in a scene without lamps, the picture stays black.
            job.record.advice.append(
                f"There is no {' and no '.join(missing)} in this view layer that Covbeam can render."
            )
            job.record.outcome = latest.Outcome.DONE
            self.report({"WARNING"}, f"Covbeam: {job.record.advice[-1]}")
            return
        latest.note_fog_light(job.view_layer)
        camera = job.scene.camera
        result = self.begin_result(0, 0, camera.width, camera.height, layer=job.view_layer)
        try:
            pixel = pixel_size(camera.width, camera.height)
            if pixel > 1:
                put(self, result, first_look(job.scene, job.settings, pixel, self.goes_on))
                taken = text.duration(perf_counter() - job.start)
                job.record.figures.append(f"First look, in pixels of {pixel} x {pixel}: after {taken}")
            if job.groups:
                made = GroupSession(split([job.scene, *job.instants], job.groups), job.settings, self.goes_on)
            else:
                made = Session(job.scene, job.settings, self.goes_on, job.instants)
            with closing(made) as session:
                passes = Passes(self, session, job.budget, result, job.start, job.settings.threads)
                passes.run()
        finally:
            # What has been shown is kept, cancelled or not.
            self.end_result(result)
        job.record.figures += passes.figures()
        latest.note_noise(job.view_layer, passes.noise)
        job.record.outcome = latest.Outcome.CANCELLED if passes.cancelled else latest.Outcome.DONE

    def view_update(self, context, depsgraph):
        problem = requirements.check()
        if problem is not None:
            self.update_stats("", f"Covbeam: {problem}")
            return
        if self.view3d is None:
            from .view3d import View3D

            self.view3d = View3D()
        self.view3d.update(self, context, depsgraph)

    def view_draw(self, context, depsgraph):
        if self.view3d is not None:
            self.view3d.draw(self, context, depsgraph)

    def goes_on(self):
        """Whether the artist has not stopped the render."""
        return not self.test_break()

    def _guarded(self, record, step):
        """What `step` returns; None if it was cancelled or has failed, which is then told."""
        from .export.report import Untranslatable
        from .host import Cancelled

        try:
            return step()
        except Cancelled:
            record.outcome = latest.Outcome.CANCELLED
        except Untranslatable as error:
            self._fail(record, str(error))
        except MemoryError:
            self._fail(record, "There is not enough memory: choose fewer photons, a smaller grid or a smaller image.")
        except Exception as error:
            # Whatever it is, Blender goes on; the console has where it came from.
            traceback.print_exc()
            self._fail(record, str(error) or type(error).__name__)
        return None

    def _fail(self, record, message):
        latest.fail(record, message)
        # The one is shown over the picture, the other in the status bar, and raised in scripts.
        self.error_set(f"Covbeam: {message}")
        self.report({"ERROR"}, f"Covbeam: {message}")


class _Job:
    """What `render` needs of a view layer; nothing in it belongs to Blender."""

    def __init__(self, depsgraph, record, engine):
        from .export.motion import exposures

        scene = depsgraph.scene_eval
        chosen = scene.covbeam
        self.record = record
        self.view_layer = depsgraph.view_layer.name
        self.groups = [group.name for group in depsgraph.view_layer.lightgroups]
        self.budget = Budget(chosen.passes, chosen.time_limit)
        self.settings = session_settings(scene)
        self.start = perf_counter()
        # The first instant while the shutter is open, and the others, if anything moves.
        (self.scene, *self.instants), report = exposures(depsgraph, engine.frame_set, engine.goes_on)
        geometry = self.scene.geometry
        record.settings = f"{self.budget}, {self.settings}"
        record.untranslated = [str(entry) for entry in report.entries]
        for entry in report.entries:
            if entry.in_fog:
                latest.lacks(str(entry))
        record.figures += [
            f"Reading the scene: {text.duration(perf_counter() - self.start)}",
            f"Geometry: {geometry.triangle_count:,} triangles, {text.memory(geometry.memory)}",
        ]


def register():
    bpy.utils.register_class(CovbeamEngine)


def unregister():
    bpy.utils.unregister_class(CovbeamEngine)
