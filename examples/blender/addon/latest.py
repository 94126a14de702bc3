# SPDX-License-Identifier: GPL-3.0-or-later
"""What the latest render has to say, for the report panel.

Plain Python: a render runs in a thread of Blender's in which Blender's own data must not be changed.
"""

from dataclasses import dataclass, field
from enum import Enum


class Outcome(Enum):
    NONE = "No render yet"
    RUNNING = "Rendering"
    DONE = "Done"
    CANCELLED = "Cancelled"
    FAILED = "Failed"


@dataclass
class Latest:
    """The latest render of a view layer."""

    outcome: Outcome = Outcome.NONE
    #: Scene, view layer and frame.
    title: str = ""
    #: Why it failed, as told to the artist.
    error: str = ""
    #: What could not be translated.
    untranslated: list[str] = field(default_factory=list)
    #: Times and memory.
    figures: list[str] = field(default_factory=list)
    #: What else the artist should know, such as about nodes that were set up.
    advice: list[str] = field(default_factory=list)


_latest = Latest()


def clear():
    """Forgets the latest render, so that none is taken for one that is about to begin."""
    global _latest
    _latest = Latest()


def begin(title):
    """A new render: its record, to be filled in."""
    global _latest
    _latest = Latest(Outcome.RUNNING, title)
    return _latest


def get():
    return _latest
