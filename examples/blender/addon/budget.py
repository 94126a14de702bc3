# SPDX-License-Identifier: GPL-3.0-or-later
"""When a render has enough passes, and how far it is."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Budget:
    """passes: at least 1. seconds: 0 is no limit. Times are those since the first pass has begun."""

    passes: int
    seconds: float

    def enough(self, done, elapsed):
        """Whether to stop after `done` passes. The time is met as closely as whole passes allow."""
        if done == 0:
            return False
        return done >= self.passes or (self.seconds > 0 and elapsed + 0.5 * elapsed / done >= self.seconds)

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
