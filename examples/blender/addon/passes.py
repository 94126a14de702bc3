# SPDX-License-Identifier: GPL-3.0-or-later
"""The loop over the passes of a render, and what an artist sees of it meanwhile."""

from time import perf_counter

import numpy as np

from . import text
from .host import Cancelled

#: Share of the time that may go into showing what there is so far.
DISPLAY_SHARE = 0.1

#: Seconds between texts in the status bar while a pass runs.
STATUS_INTERVAL = 0.25

#: How many times as long as a coarse picture a whole one takes, at most.
COARSE = 32

#: A cancelled render shows its last passes only if making the picture takes no longer than this [s].
LAST_PICTURE = 0.1


class Passes:
    """Runs the passes of a session within a budget; hands pictures and progress to the engine.

    - result: Blender's render result, with the layer that is rendered.
    - cancelled: whether the artist has stopped it. What was shown last is kept.
    """

    def __init__(self, engine, session, budget, result):
        self.engine, self.session, self.budget, self.result = engine, session, budget, result
        self.cancelled = False
        self._start = self._told = perf_counter()
        # Seconds spent on pictures, those that the next one is expected to take, and the passes that the latest shows.
        self._display = self._next_display = 0.0
        self._shown = 0

    def run(self):
        try:
            while not self._enough():
                self.session.render_pass(self._poll)
                self._tell()
                affordable = self._display + self._next_display <= DISPLAY_SHARE * self._elapsed()
                if self._enough():
                    self._show(self._poll)
                elif affordable:
                    # Something to see as soon as there is.
                    self._show(self._poll, coarse=self._shown == 0)
        except Cancelled:
            self.cancelled = True
            if self.session.passes > self._shown > 0 and self._next_display <= LAST_PICTURE:
                self._show(None)

    def figures(self):
        """Lines for the report."""
        done, elapsed = self.session.passes, self._elapsed()
        share = 100 * self._display / elapsed
        parts = ", ".join(f"{name} {100 * spent / elapsed:.0f} %" for name, spent in self.session.times.items())
        return [
            f"Passes: {done} of {self.budget.passes} in {text.duration(elapsed)}",
            f"A pass: {text.duration(elapsed / max(done, 1))}; showing the picture: {share:.0f} %",
            f"Of the time: {parts}",
            f"Memory of light and image: {text.memory(self.session.memory)}",
        ]

    def _elapsed(self):
        return perf_counter() - self._start

    def _enough(self):
        return self.budget.enough(self.session.passes, self._elapsed())

    def _poll(self):
        """Asked by the session at least every 0.1 s: whether to go on."""
        if perf_counter() - self._told >= STATUS_INTERVAL:
            self._tell()
        return self.engine.goes_on()

    def _tell(self):
        self._told = perf_counter()
        done, elapsed, budget = self.session.passes, self._elapsed(), self.budget
        left = f", {text.duration(budget.left(done, elapsed))} left" if done else ""
        self.engine.update_progress(budget.progress(done, elapsed))
        self.engine.update_stats("", f"Covbeam: pass {min(done + 1, budget.passes)} of {budget.passes}{left}")

    def _show(self, poll, coarse=False):
        """Hands the picture so far to Blender."""
        start = perf_counter()
        picture = self.session.picture(poll, coarse)
        height, width = picture.radius.shape
        # Light that is added to a picture covers nothing of it, but as a picture of its own it is opaque: alpha is 1.
        combined = np.ones((height, width, 4), np.float32)
        combined[..., :3] = picture.in_scattered
        values = {
            "Combined": combined,
            "In-Scattered": picture.first,
            "Radius": picture.radius,
            "Bandwidth": picture.bandwidth,
        }
        for layer in self.result.layers[0].passes:
            # Blender counts rows from the bottom.
            layer.rect.foreach_set(np.ascontiguousarray(values[layer.name][::-1], np.float32).reshape(-1))
        self.engine.update_result(self.result)
        taken = perf_counter() - start
        self._next_display = COARSE * taken if coarse else taken
        self._display += taken
        self._shown = self.session.passes
