# SPDX-License-Identifier: GPL-3.0-or-later
"""The loop over the passes of a render, and what an artist sees of it meanwhile."""

from time import perf_counter

import numpy as np

from . import text
from .host import Cancelled
from .host.groups import LUMINANCE
from .pass_names import group_pass

#: Share of the time that may go into showing what there is so far.
DISPLAY_SHARE = 0.1

#: Seconds between texts in the status bar while a pass runs.
STATUS_INTERVAL = 0.25

#: With a time limit, the first pass has this share of the light paths, and no fewer than TRIAL_PATHS, which take no longer than the eye rays of a
#: pass: it tells how many of them a pass has time for.
TRIAL, TRIAL_PATHS = 1 / 16, 5000

#: Share of the time that one pass takes at most, with a time limit; but light paths may take as long as all else in a pass does: where that takes
#: longer, fewer paths would save next to nothing.
PASS_SHARE = 0.15

#: Parts of a pass that take as long as there are many light paths; in the gather, pairs of a beam and an eye ray do, each so long on one core [s].
_OF_PATHS = ("photons", "light fields", "beams")
_PAIR = 6e-8

#: A cancelled render shows its last passes only if making the picture takes no longer than this [s].
LAST_PICTURE = 0.1


class Passes:
    """Runs the passes of a session within a budget; hands pictures and progress to the engine.

    - result: Blender's render result, with the layer that is rendered.
    - start: when the scene began to be read, of perf_counter; threads: of the session.
    - cancelled: whether the artist has stopped it. What was shown last is kept; noise: how noisy that is, as of `noise_of`.
    """

    def __init__(self, engine, session, budget, result, start, threads):
        self.engine, self.session, self.budget, self.result = engine, session, budget, result
        self.cancelled, self.noise = False, 0.0
        self._start, self._told, self._threads = start, perf_counter(), threads
        # Seconds spent on pictures; those that the latest pass and picture took; and the passes that the latest picture shows.
        self._display = self._pass = self._picture = 0.0
        self._shown = 0
        self._late = False

    def run(self):
        try:
            if self.budget.seconds > 0:
                self._try_out()
            while not self._enough():
                self._render_pass()
                affordable = self._display + self._picture <= DISPLAY_SHARE * self._elapsed()
                if affordable or self._enough():
                    self._show(self._poll)
        except Cancelled:
            self.cancelled = not self._late
            news = self.session.passes > self._shown
            if news and (self._late or (self._shown > 0 and self._picture <= LAST_PICTURE)):
                self._show(None)

    def _try_out(self):
        """Finds out what a pass and a picture cost, and gives passes as many light paths as there is time for."""
        most = self.session.photons
        trial = max(int(TRIAL * most), min(TRIAL_PATHS, most))
        if trial < most:
            self.session.restart(trial)
        before, pairs = self.session.times, self.session.pairs
        self._render_pass()
        spent = {name: seconds - before[name] for name, seconds in self.session.times.items()}
        # The first pass finds out where light paths are needed.
        self._pass -= spent["plan"]
        self._show(self._poll)
        of_pairs = _PAIR * (self.session.pairs - pairs) / self._threads
        paths = sum(spent[name] for name in _OF_PATHS) + min(of_pairs, spent["gather"])
        other = max(self._pass - paths, 0.0)
        left = self.budget.seconds - self._elapsed() - self._picture
        # Two passes at least are to fit. Where next to nothing is theirs there may be as many paths as anyone wants.
        of_paths = min(max(PASS_SHARE * left - other, other), 0.5 * left - other)
        photons = min(int(trial * of_paths / max(paths, 1e-6)), most)
        # Where there is no time for more, the trial is the first pass.
        if photons > trial:
            self.session.restart(photons)
            self._pass = other + paths * photons / trial
            self._shown = 0

    def _render_pass(self):
        start = perf_counter()
        self.session.render_pass(self._poll)
        self._pass = perf_counter() - start
        self._tell()

    def figures(self):
        """Lines for the report."""
        done, elapsed = self.session.passes, self._elapsed()
        share = 100 * self._display / elapsed
        parts = ", ".join(f"{name} {100 * spent / elapsed:.0f} %" for name, spent in self.session.times.items())
        return [
            f"Passes: {done} of {self.budget.passes} in {text.duration(elapsed)}",
            f"A pass: {self.session.photons:,} light paths, {text.duration(elapsed / max(done, 1))}; showing the picture: {share:.0f} %",
            f"Of the time: {parts}",
            f"Memory of light and image: {text.memory(self.session.memory)}",
        ]

    def _elapsed(self):
        return perf_counter() - self._start

    def _enough(self):
        return self.budget.enough(self.session.passes, self._elapsed(), self._pass, self._picture)

    def _poll(self):
        """Asked by the session at least every 0.1 s: whether to go on."""
        if perf_counter() - self._told >= STATUS_INTERVAL:
            self._tell()
        self._late = self.budget.late(self.session.passes, self._elapsed(), self._picture)
        return self.engine.goes_on() and not self._late

    def _tell(self):
        self._told = perf_counter()
        done, elapsed, budget = self.session.passes, self._elapsed(), self.budget
        left = f", {text.duration(budget.left(done, elapsed))} left" if done else ""
        self.engine.update_progress(budget.progress(done, elapsed))
        self.engine.update_stats("", f"Covbeam: pass {min(done + 1, budget.passes)} of {budget.passes}{left}")

    def _show(self, poll):
        """Hands the picture so far to Blender."""
        start = perf_counter()
        picture = self.session.picture(poll)
        put(self.engine, self.result, picture)
        self.noise = noise_of(picture, self.session.passes)
        taken = perf_counter() - start
        self._picture = taken
        self._display += taken
        self._shown = self.session.passes


def noise_of(picture, passes):
    """Root of the mean square of a host.session.Picture's standard error, over that of its light's luminance: infinite after a single pass, which
    tells of no error; 0 of a black picture."""
    light, error = (np.square(values, dtype=np.float64).mean() for values in (picture.in_scattered @ LUMINANCE, picture.error))
    if not light > 0:
        return 0.0
    return float(np.sqrt(error / light)) if passes > 1 else np.inf


def put(engine, result, picture):
    """Hands a host.session.Picture to Blender, which shows it.

    - result: Blender's render result, with the layer that is rendered.
    """
    height, width = picture.radius.shape
    # Light that is added to a picture covers nothing of it, but as a picture of its own it is opaque: alpha is 1.
    combined = np.ones((height, width, 4), np.float32)
    combined[..., :3] = picture.in_scattered
    values = {
        "Combined": combined,
        "In-Scattered": picture.first,
        "Radius": picture.radius,
        "Bandwidth": picture.bandwidth,
        "Standard Error": picture.error,
    }
    values |= {group_pass(name): light for name, light in picture.groups.items()}
    for layer in result.layers[0].passes:
        # Of groups that are dark, and of all in a first look, there is nothing.
        if layer.name not in values:
            continue
        # Blender counts rows from the bottom.
        layer.rect.foreach_set(np.ascontiguousarray(values[layer.name][::-1], np.float32).reshape(-1))
    engine.update_result(result)
