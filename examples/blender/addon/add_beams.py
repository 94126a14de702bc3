# SPDX-License-Identifier: GPL-3.0-or-later
"""Adding covbeam's fog light to a scene that Cycles renders, and taking it out again."""

import bpy

from . import beam_render, compositor, latest, requirements, text


#: Noise of beams (passes.noise_of) from which a denoiser helps them. Of pictures of people.md's scenes after 4 and 16 CPU-seconds it lowers the
#: error of all above: sixty spots with .09 to .86, a cloud with .07 to a half. The others are below .04, and come to .9 to 3.5 times their error by
#: it, which takes the finest light for noise. Single passes come to .34 to 1.0, wine in a glass to 1.28.
NOISY = 0.05


def _problem(context):
    """Why beams cannot be added, as text for artists, or None."""
    scene = context.scene
    problem = requirements.check()
    if problem is not None:
        return problem
    if scene.render.engine != "CYCLES":
        return "Add Beams needs a scene that Cycles renders: choose Cycles as the render engine."
    if scene.camera is None:
        return "The scene has no camera: add one, or make one active (Ctrl Numpad 0)."
    if not beam_render.rendered(scene, context.view_layer):
        return "No view layer is rendered: switch on Use for Rendering in the properties of one."
    if scene.render.use_multiview:
        return "Stereoscopy is not supported: switch it off in the output properties."
    return beam_render.folder_problem(scene)


class COVBEAM_OT_add_beams(bpy.types.Operator):
    """Render the fog's light with Covbeam, and let the compositor put it in the place of Cycles' fog light. \
Esc stops it: what was rendered of the frame is dropped, frames that are done are kept, and nodes stay as they were"""

    bl_idname = "covbeam.add_beams"
    bl_label = "Add Beams to Cycles"
    bl_options = {"REGISTER", "UNDO"}

    animation: bpy.props.BoolProperty(
        name="Animation",
        description="All frames of the scene's range instead of the current one",
        options={"SKIP_SAVE"},
    )
    replace: bpy.props.BoolProperty(
        name="Replace All Fog Light",
        description="Take Cycles' fog light away even if Covbeam does not have all of it",
        options={"SKIP_SAVE"},
    )

    def execute(self, context):
        """Renders to the end: in background, and from scripts."""
        if not self._begin(context):
            return {"CANCELLED"}
        try:
            beam_render.render(self._render)
        except RuntimeError as error:
            # What the engine or Blender has reported, of any frame.
            beam_render.discard()
            latest.settle()
            self.report({"ERROR"}, str(error).strip().removeprefix("Error: "))
            return {"CANCELLED"}
        return self._end()

    def invoke(self, context, event):
        """Renders as F12 does, in a job of Blender's; `modal` waits for its end."""
        if bpy.app.background:
            return self.execute(context)
        if bpy.app.is_job_running("RENDER"):
            self.report({"ERROR"}, "Another render is running: wait for it, or stop it.")
            return {"CANCELLED"}
        if not self._begin(context):
            return {"CANCELLED"}
        beam_render.render(self._render, "INVOKE_DEFAULT")
        manager = context.window_manager
        self._timer = manager.event_timer_add(0.1, window=context.window)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type != "TIMER" or bpy.app.is_job_running("RENDER"):
            return {"PASS_THROUGH"}
        context.window_manager.event_timer_remove(self._timer)
        done = self._end()
        if COVBEAM_OT_replace_fog.poll(context):
            bpy.ops.covbeam.replace_fog("INVOKE_DEFAULT")
        return done

    def _begin(self, context):
        problem = _problem(context)
        if problem is not None:
            self.report({"ERROR"}, problem)
            return False
        latest.clear()
        _kept.clear()
        self._render = beam_render.begin(context.scene, context.view_layer, self.animation)
        return True

    def _end(self):
        beam_render.discard()
        record = latest.settle()
        if record.outcome == latest.Outcome.FAILED:
            self.report({"ERROR"}, record.error)
            return {"CANCELLED"}
        if record.outcome != latest.Outcome.DONE:
            self.report({"INFO"}, "Add Beams was stopped")
            return {"CANCELLED"}
        missing = self._render.missing()
        if missing:
            self.report({"ERROR"}, f"{missing[0]} has not been written: was the render stopped, or is the disk full?")
            return {"CANCELLED"}
        foggy = [name for name in self._render.view_layers if latest.had_fog_light(name)]
        if not foggy:
            self.report({"WARNING"}, f"Nothing was changed. {record.advice[-1]}")
            return {"CANCELLED"}
        lacking = latest.missing_in_fog()
        if lacking and not self.replace:
            # What stands there shows the new picture, which has not all that it would take away.
            scene = bpy.data.scenes.get(self._render.scene)
            if scene is not None:
                compositor.remove(scene)
            _kept.append((self._render, foggy))
            # The report of the latest view layer and frame gets what others lack.
            record.untranslated += [what for what in lacking if what not in record.untranslated]
            words = f"Cycles' fog light stays, as Covbeam's lacks some of it: {_lacking(lacking)}"
            record.advice.append(f"{words}. Replace Fog Light takes it all the same.")
            self.report({"WARNING"}, words)
            return {"CANCELLED"}
        return _replace(self, self._render, foggy)


#: The render whose picture has been made, but not put in the place of Cycles' fog light, as it lacks some of that, and the names of
#: its view layers with light in fog; or empty.
_kept = []


def _lacking(entries):
    """What is lacking, as long as a dialog is readable."""
    return text.shortened(entries, 200)


def _replace(operator, render, foggy):
    """Sets up the nodes of view layers with light in fog. While it was rendered, the artist may have gone to another scene."""
    scene = bpy.data.scenes.get(render.scene)
    view_layers = [scene and scene.view_layers.get(name) for name in foggy]
    if None in view_layers:
        operator.report({"ERROR"}, "The scene or a view layer was removed or renamed while it was rendered.")
        return {"CANCELLED"}
    advice = latest.get().advice
    advice += [f'The view layer "{name}" has no light in fog: it stays as it is.' for name in render.view_layers if name not in foggy]
    noisy = {name for name in foggy if latest.noise(name) > NOISY}
    advice += compositor.add(scene, view_layers, render, noisy)
    operator.report({"INFO"}, f"Beams added: {render.path(render.first)}")
    return {"FINISHED"}


class COVBEAM_OT_replace_fog(bpy.types.Operator):
    """Put what Covbeam has rendered in the place of Cycles' fog light, though it lacks what the report names"""

    bl_idname = "covbeam.replace_fog"
    bl_label = "Replace Fog Light"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return bool(_kept)

    def invoke(self, context, event):
        words = _lacking(latest.missing_in_fog())
        manager = context.window_manager
        return manager.invoke_confirm(
            self,
            event,
            title="Take Cycles' fog light away?",
            message=f"Covbeam's lacks some of it: {words}",
            confirm_text="Replace",
            icon="WARNING",
        )

    def execute(self, context):
        render, foggy = _kept.pop()
        missing = render.missing()
        if missing:
            self.report({"ERROR"}, f"{missing[0]} is not there any more: Add Beams renders it again.")
            return {"CANCELLED"}
        return _replace(self, render, foggy)


class COVBEAM_OT_remove_beams(bpy.types.Operator):
    """Take the nodes of Add Beams out of the compositor and connect what they were put between. \
The images stay on disk"""

    bl_idname = "covbeam.remove_beams"
    bl_label = "Remove Beams"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return compositor.has_beams(context.scene)

    def execute(self, context):
        compositor.remove(context.scene)
        return {"FINISHED"}


_CLASSES = (COVBEAM_OT_add_beams, COVBEAM_OT_replace_fog, COVBEAM_OT_remove_beams)


def register():
    for cls in _CLASSES:
        bpy.utils.register_class(cls)


def unregister():
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
