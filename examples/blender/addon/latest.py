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
    #: What was asked for.
    settings: str = ""
    #: Times and memory.
    figures: list[str] = field(default_factory=list)
    #: What else the artist should know, such as about nodes that were set up.
    advice: list[str] = field(default_factory=list)

    def fields(self):
        """What is kept with the image: texts by name, those that are empty left out."""
        texts = {
            "outcome": self.outcome.value,
            "error": self.error,
            "settings": self.settings,
            "figures": "; ".join(self.figures),
            "not_as_cycles": "; ".join(self.untranslated),
            "advice": " ".join(self.advice),
        }
        return {name: text for name, text in texts.items() if text}


_latest = Latest()

#: Of all renders since `clear`: what of the light in fog is missing, and view layers that have some, dicts as ordered sets; why one has failed.
_missing_in_fog, _lit, _failures = {}, {}, {}


def clear():
    """Forgets the renders so far, so that none is taken for one that is about to begin."""
    global _latest
    _latest = Latest()
    for noted in (_missing_in_fog, _lit, _failures):
        noted.clear()


def lacks(what):
    """Notes what of the light in fog, as text for artists, a render lacks."""
    _missing_in_fog[what] = None


def missing_in_fog():
    """What renders since `clear` lack of the light in fog."""
    return list(_missing_in_fog)


def note_fog_light(view_layer):
    """Notes that a render of a view layer has light in fog."""
    _lit[view_layer] = None


def lit_view_layers():
    """Names of the view layers whose renders since `clear` had light in fog."""
    return list(_lit)


def note_failure(words):
    """Notes why a render has failed, as text for artists."""
    _failures[words] = None


def failure():
    """Why the first of the renders since `clear` that has failed did so, or None."""
    return next(iter(_failures), None)


def begin(title):
    """A new render: its record, to be filled in."""
    global _latest
    _latest = Latest(Outcome.RUNNING, title)
    return _latest


def get():
    return _latest
