# SPDX-License-Identifier: GPL-3.0-or-later
"""Measured light of lamps, from IES files (ANSI/IES LM-63), as Cycles understands them."""

from pathlib import Path

import bpy
import numpy as np

#: Candela to Blender's watts of lamps: 4 pi over the lumens a watt of daylight (D65), 177.83.
_WATTS = 4 * np.pi / 177.83

#: More angles than this are no measurement.
_MOST = 10_000


class Unreadable(Exception):
    """The text is no IES file; the message says why."""


class Measured:
    """Light by angles [rad] from a lamp's foot, `vertical`, and around it, `horizontal`; `values`: (h, v)."""

    def __init__(self, text):
        vertical, horizontal, values = _whole(*_read(text))
        self._vertical, self._horizontal, self._values = np.radians(vertical), np.radians(horizontal), values

    def at(self, vertical, horizontal):
        """Light in directions, angles (n,) [rad]: (n,). None where nothing was measured."""
        inside = (vertical >= self._vertical[0]) & (vertical < self._vertical[-1])
        v, across = _place(self._vertical, vertical)
        h, around = _place(self._horizontal, horizontal % (2 * np.pi))
        count = len(self._horizontal) - 1
        rows = [self._along(np.clip(h + k, 0, count), v, across) for k in range(-1, 3)]
        # In single precision Cycles never sees that the last angle around is the first, nor that the last vertical one is straight up.
        rows[0] = np.where(h > 0, rows[0], _beyond(rows[1]))
        rows[3] = np.where(h + 2 <= count, rows[3], _beyond(rows[1]))
        return np.where(inside, np.maximum(_cubic(rows, around), 0), 0.0)

    def _along(self, row, v, across):
        """Light `across` from vertical angle v to the next, at a horizontal one, indices (n,)."""
        last = len(self._vertical) - 1
        a, b, c, d = (self._values[row, np.clip(v + k, 0, last)] for k in range(-1, 3))
        # Beyond straight down it goes on as it came.
        a = np.where(v > 0, a, self._values[row, 1] if self._vertical[0] < 1e-7 else _beyond(b))
        return _cubic((a, b, c, np.where(v + 2 <= last, d, _beyond(c))), across)


def measured(node):
    """The Measured of an IES Texture node. Raises Unreadable, or OSError if its file cannot be read."""
    if node.mode == "INTERNAL":
        return Measured(node.ies.as_string() if node.ies is not None else "")
    return Measured(Path(bpy.path.abspath(node.filepath)).read_text(encoding="latin-1"))


def _read(text):
    """Vertical and horizontal angles [degrees], and values (h, v) in Blender's watts."""
    _, found, rest = text.partition("TILT=")
    if not found:
        raise Unreadable("no line TILT=")
    kind, _, rest = rest.partition("\n")
    words = rest.replace(",", " ").split()
    try:
        numbers = np.array(words, np.float64)
        if kind.strip() == "INCLUDE":
            # How the lamp hangs, and what that does to it.
            numbers = numbers[2 + 2 * int(numbers[1]) :]
        factor, across, around, geometry = numbers[2], int(numbers[3]), int(numbers[4]), int(numbers[5])
        if not (1 < across <= _MOST and 0 < around <= _MOST):
            raise Unreadable(f"{across} vertical and {around} horizontal angles")
        factor *= numbers[10] * numbers[11] * _WATTS
        numbers = numbers[13:]
        vertical, horizontal = numbers[:across], numbers[across : across + around]
        values = numbers[across + around :][: across * around].reshape(around, across)
    except (ValueError, IndexError, OverflowError) as error:
        raise Unreadable("too few numbers, or words among them") from error
    if geometry != 1:
        raise Unreadable("its angles are not of type C")
    if not (np.isfinite(numbers[: across + around]).all() and (np.diff(vertical) > 0).all() and (np.diff(horizontal) > 0).all()):
        raise Unreadable("its angles do not rise")
    return vertical, horizontal, np.nan_to_num(values * factor, posinf=0.0, neginf=0.0)


def _whole(vertical, horizontal, values):
    """The same all around: what is measured of a half or a quarter is mirrored."""
    horizontal = horizontal - horizontal[0]
    if len(horizontal) == 1:
        return vertical, np.array([0.0, 360.0]), np.repeat(values, 2, axis=0)
    for end in (90, 180):
        if abs(horizontal[-1] - end) < 1e-3:
            horizontal = np.concatenate([horizontal, 2 * end - horizontal[-2::-1]])
            values = np.concatenate([values, values[-2::-1]])
    if horizontal[-1] < 360 - 1e-3:
        horizontal, values = np.append(horizontal, 360.0), np.concatenate([values, values[:1]])
    return vertical, horizontal, values


def _place(angles, at):
    """Between which of the angles others lie, and how far along."""
    low = np.clip(np.searchsorted(angles, at, side="right") - 1, 0, len(angles) - 2)
    return low, np.clip((at - angles[low]) / (angles[low + 1] - angles[low]), 0, 1)


def _beyond(value):
    """What Cycles takes for the light beyond the last angle: before Blender 5.0 none."""
    return value if bpy.app.version >= (5, 0) else np.zeros_like(value)


def _cubic(values, t):
    """Catmull and Rom's curve through four values."""
    a, b, c, d = values
    return b + 0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)))
