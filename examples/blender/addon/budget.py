# SPDX-License-Identifier: GPL-3.0-or-later
"""When a render has enough passes, and how far it is."""

from dataclasses import dataclass

#: How late a render may end: a share of its time, or seconds if these are more.
_LATE, _LATE_SECONDS = 0.025, 0.5


@dataclass(frozen=True)
class Budget:
    """passes: at least 1. seconds: 0 is no limit. Times are those since the scene has begun to be read."""

    passes: int
    seconds: float

    def enough(self, done, elapsed, pass_, picture):
        """Whether to stop after `done` passes, since another one and the picture after it would end too late.

        - pass_, picture: how long they are expected to take [s].
        """
        if done == 0:
            return False
        return done >= self.passes or (self.seconds > 0 and elapsed + pass_ + picture > self.seconds)

    def late(self, done, elapsed, picture):
        """Whether a pass is to be given up, because the picture would be late."""
        slack = max(_LATE * self.seconds, _LATE_SECONDS)
        return done > 0 and self.seconds > 0 and elapsed + picture > self.seconds + slack

    def left(self, done, elapsed):
        """Seconds that are left after `done` >= 1 passes."""
        left = (self.passes - done) * elapsed / done
        if self.seconds > 0:
            left = min(left, self.seconds - elapsed)
        return max(left, 0.0)

    def progress(self, done, elapsed):
        """From 0 to 1."""
        progress = done / self.passes
        if self.seconds > 0:
            progress = max(progress, elapsed / self.seconds)
        return min(progress, 1.0)
