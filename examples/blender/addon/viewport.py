# SPDX-License-Identifier: GPL-3.0-or-later
"""What a viewport shows: a coarse picture at once, then finer and better ones, in slices of time. No Blender.

A pass of a session cannot be cut in two, but it can have few light paths and large pixels. How much of both there is time for is
measured as it goes, and kept for the next view.
"""

from dataclasses import dataclass, fields, replace
from time import perf_counter

import numpy as np

from .host import Cancelled

#: Light paths of a first pass, which tells what the eye rays cost, and what light paths do.
_FEW = 1000

#: What a pass is to take [s]. Where eye rays alone take half of that and more, it takes twice what they do, but at most `PATIENCE`.
SLICE = 0.1

#: Seconds that nothing may take but the very first picture of a view. What takes longer is given up, and pixels stay larger.
PATIENCE = 0.5

#: How much longer than that smaller pixels may be expected to take, and are tried: not all that pixels cost grows with their number.
_HOPE = 3.0

#: How long pixels are looked at before smaller ones are begun [s].
_HEAD_START = 0.3

#: Sides of the pixels of a view's first picture, in those of the finest: usually, and at most. They grow where that takes longer than
#: `_AT_ONCE` [s].
_COARSE, _COARSEST, _AT_ONCE = 4, 16, 0.3

#: Share of the time that may go into making pictures of passes.
_DISPLAY_SHARE = 0.25

#: Later than this, passes keep their number of light paths: another number would throw away too much.
_SETTLED = 4

#: How long a light path takes before one has been seen [s].
_FIRST_RATE = 2e-5


@dataclass(frozen=True)
class Shown:
    """What is to be drawn: a host Picture, after so many passes of so many light paths, whose pixels cover pixel x pixel ones of the view.
    It begins at the view's upper left corner, and may be larger by a part of a pixel."""

    picture: object
    pixel: int
    passes: int
    photons: int


@dataclass
class _Learned:
    """What views have taught about the computer and the scene: for those to come.

    - coarse: side of the pixels of a first picture, in those of the finest; finest: that of those that there is time for.
    - rate: how long a light path takes [s].
    """

    coarse: int = _COARSE
    finest: int = 1
    rate: float = _FIRST_RATE


class Viewport:
    """Renders one view of one scene at a time, a slice in each `step`.

    - make_session: host.session.Session, or what has its interface.
    - clock: seconds; perf_counter but in tests.
    """

    def __init__(self, make_session, clock=perf_counter):
        self._make, self._clock = make_session, clock
        self._what = self._where = self._work = None
        self._is_fresh = True
        self._learned = _Learned()

    def update(self, scene, settings, budget):
        """Sets what is rendered, and begins anew if any of it has changed; returns whether it did.

        - scene: host.scene.Scene whose camera does not matter, or None: nothing is rendered.
        - settings: host.session.Settings; `photons` is the most that a pass may have.
        - budget: budget.Budget: passes of the finest pixels, and seconds since the view began, whichever comes first.
        """
        if self._what is not None and scene is self._what[0] and (settings, budget) == self._what[1:]:
            return False
        self._what = scene, settings, budget
        self._learned.finest = 1
        self._begin()
        return True

    def view(self, camera, pixel=1):
        """Sets whence it is seen, and begins anew if that has changed; returns whether it did.

        - camera: host.scene.Camera of all pixels; pixel: how many of them along each side are rendered as one, at best.
        """
        if self._where is not None and pixel == self._where[1] and _same(camera, self._where[0]):
            return False
        size = (camera.width, camera.height, pixel)
        if self._where is None or size != (self._where[0].width, self._where[0].height, self._where[1]):
            self._learned.finest = 1
        self._where = camera, pixel
        self._begin()
        return True

    def step(self, seconds):
        """Works for about so long, at least until a new view has its first picture; returns the latest Shown, or None if there is none yet.

        What a session raises, this does too; then there is nothing to be done until scene or view changes.
        """
        start, shown = self._clock(), None
        while self._work is not None:
            begun = self._clock()
            work, self._work = self._work, None
            try:
                shown, self._work = next(work) or shown, work
            except StopIteration:
                break
            self._is_fresh &= shown is None
            now = self._clock()
            if not self._is_fresh and now - start + (now - begun) > seconds:
                break
        return shown

    @property
    def done(self):
        """Whether nothing is left to do for this view."""
        return self._work is None

    def close(self):
        """Gives all memory back; scene and view are forgotten."""
        if self._work is not None:
            self._work.close()
        self._what = self._where = self._work = None

    def _begin(self):
        if self._work is not None:
            self._work.close()
        self._work, self._is_fresh = None, True
        if self._what is not None and self._what[0] is not None and self._where is not None:
            self._work = _Refinement(self._make, self._clock, self._what, self._where, self._learned).run()


class _Refinement:
    """The passes of one view, in one size of pixels after the other.

    `run` is a generator of bits of work: each yields what is to be drawn from now on, a Shown, or None. Closed, it closes its sessions.
    """

    def __init__(self, make_session, clock, what, where, learned):
        self._make, self._clock, self._learned = make_session, clock, learned
        self._scene, self._settings, self._budget = what
        self._camera, self._pixel = where
        self._begun = None
        self._levels = []

    def run(self):
        self._begun = self._clock()
        try:
            level = yield from self._open(self._learned.coarse * self._pixel, None)
            self._choose_coarse(level.spent + level.display)
            yield level.picture
            while (pixel := self._finer(level)) is not None and not self._is_late():
                yield from self._refine(level, lambda: level.spent >= _HEAD_START)
                level = yield from self._go_finer(level, pixel)
            if level.is_plain and not self._is_late():
                yield from self._guide(level, level.light)
            yield from self._refine(level, lambda: level.session.passes >= self._budget.passes)
            if not level.is_shown:
                self._make_picture(level)
                yield level.picture
        finally:
            for level in self._levels:
                level.session.close()

    def _open(self, pixel, patience):
        """A _Level with a first pass and its picture; raises Cancelled if one of the three takes longer than `patience`."""
        start = self._clock()
        scene = replace(self._scene, camera=self._camera.coarser(pixel))
        level = _Level(self._make(scene, self._settings, self._poll(patience)), pixel)
        level.most = level.session.photons
        self._levels.append(level)
        setup = self._clock() - start
        yield None
        start = self._clock()
        level.session.restart(_FEW, plain=True)
        level.session.render_pass(self._poll(patience))
        level.trial = self._clock() - start
        level.spent = setup + level.trial
        yield None
        self._make_picture(level, patience)
        level.opening = max(setup, level.trial, level.display)
        return level

    def _go_finer(self, level, pixel):
        """The level with that many pixels instead, once it has as much light; or the one there is, if that takes too long."""
        try:
            finer = yield from self._open(pixel, PATIENCE)
        except Cancelled:
            self._learned.finest = 2 * pixel // self._pixel
            self._close_but(level)
            yield None
            return level
        if self._finer(finer) is None:
            yield from self._guide(finer, level.light)
        else:
            yield from self._catch_up(finer, level.light)
        if self._is_late() and finer.light < level.light:
            self._close_but(level)
            return level
        self._close_but(finer)
        self._make_picture(finer)
        yield finer.picture
        return finer

    def _guide(self, level, light):
        """Begins anew, with light paths that go where they are needed. What finds that out takes a while, and is part of the first pass."""
        level.is_plain = False
        level.session.restart(_FEW)
        level.session.render_pass(None)
        yield None
        yield from self._catch_up(level, light)

    def _catch_up(self, level, light):
        """Passes that nobody sees until there is as much light as before."""
        level.is_hidden = True
        yield from self._refine(level, lambda: level.light >= light or level.session.passes >= self._budget.passes)
        level.is_hidden = False

    def _refine(self, level, enough):
        """Passes of a level until it has enough, or the view's time is over."""
        while not enough() and not self._is_late():
            self._render_pass(level)
            yield None
            if not level.is_hidden and self._affords_picture(level):
                self._make_picture(level)
                yield level.picture

    def _render_pass(self, level):
        session, learned = level.session, self._learned
        is_settled = session.passes >= _SETTLED
        photons = session.photons if is_settled else self._photons(level)
        if not session.photons <= 2 * photons <= 4 * session.photons:
            session.restart(photons, level.is_plain)
        start, photons = self._clock(), session.photons
        try:
            session.render_pass(self._poll(None if is_settled else max(2 * PATIENCE, 4 * level.trial)))
        except Cancelled:
            session.restart(max(photons // 2, _FEW), level.is_plain)
        took = self._clock() - start
        level.spent += took
        if photons >= 2 * _FEW:
            learned.rate = max(took - level.trial, 0.1 * took) / (photons - _FEW)
        elif not is_settled:
            # So few tell nothing of what more would take: they are tried by and by.
            learned.rate *= 0.9

    def _make_picture(self, level, patience=None):
        start, session = self._clock(), level.session
        picture = session.picture(self._poll(patience))
        level.picture = Shown(picture, level.pixel, session.passes, session.photons)
        level.seconds = self._clock() - start
        level.display += level.seconds

    def _affords_picture(self, level):
        return not level.is_shown and level.seconds + level.display <= _DISPLAY_SHARE * level.spent

    def _is_late(self):
        return 0 < self._budget.seconds <= self._clock() - self._begun

    def _photons(self, level):
        """How many light paths a pass of a level has time for."""
        rate = self._learned.rate
        rays = max(level.trial - _FEW * rate, 0.0)
        time = min(max(2 * rays, SLICE), PATIENCE)
        return min(max(int((time - rays) / rate), _FEW), level.most)

    def _finer(self, level):
        """The smallest pixels that there should be time for, or None if they are not smaller than a level's."""
        for factor in (1, 2, 4, 8):
            pixel = factor * self._pixel
            if factor < self._learned.finest or pixel >= level.pixel:
                continue
            if level.opening * (level.pixel / pixel) ** 2 <= _HOPE * PATIENCE:
                return pixel
        return None

    def _choose_coarse(self, seconds):
        """Of the next view, whose first picture should not take longer than that of this has, or better: more pixels in no time."""
        learned = self._learned
        if seconds > _AT_ONCE:
            learned.coarse = min(2 * learned.coarse, _COARSEST)
        elif seconds < _AT_ONCE / 8:
            learned.coarse = max(learned.coarse // 2, _COARSE)

    def _close_but(self, level):
        for other in self._levels:
            if other is not level:
                other.session.close()
        self._levels = [level]

    def _poll(self, seconds):
        """Says no after so long; None: never."""
        if seconds is None:
            return None
        end = self._clock() + seconds
        return lambda: self._clock() < end


class _Level:
    """A session, the side of its pixels, and its latest picture, a Shown.

    Seconds: `opening`, the longest of its making, its first pass and that pass' picture; `trial`, that pass; `spent`, all passes so far;
    `seconds`, the latest picture; `display`, all pictures. most: light paths that a pass may have; is_plain: whether they go anywhere;
    is_hidden: whether no pictures are made.
    """

    def __init__(self, session, pixel):
        self.session, self.pixel, self.picture = session, pixel, None
        self.opening = self.trial = self.spent = self.seconds = self.display = 0.0
        self.most, self.is_plain, self.is_hidden = _FEW, True, False

    @property
    def is_shown(self):
        """Whether the latest picture has all passes; there is none without any."""
        session, picture = self.session, self.picture
        return session.passes == 0 or (session.passes, session.photons) == (picture.passes, picture.photons)

    @property
    def light(self):
        """Light paths so far."""
        return self.session.passes * self.session.photons


def _same(one, other):
    return all(np.array_equal(getattr(one, field.name), getattr(other, field.name)) for field in fields(one))
