# SPDX-License-Identifier: GPL-3.0-or-later
"""What the latest render has to say, for the report panel.

Plain Python: a render runs in a thread of Blender's in which Blender's own data must not be changed.
"""

from dataclasses import dataclass, field
from enum import Enum
from statistics import median


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

#: Of all renders since `clear`: what of the light in fog is missing, a dict as an ordered set; names of view layers that had any, with the noise of
#: each frame; and the record of the first render that has failed, or None.
_missing_in_fog, _foggy, _failed = {}, {}, None


def clear():
    """Forgets the renders so far, so that none is taken for one that is about to begin."""
    global _latest, _failed
    _latest, _failed = Latest(), None
    _missing_in_fog.clear()
    _foggy.clear()


def lacks(what):
    """Notes what of the light in fog, as text for artists, a render lacks."""
    _missing_in_fog[what] = None


def missing_in_fog():
    """What renders since `clear` lack of the light in fog."""
    return list(_missing_in_fog)


def note_fog_light(view_layer):
    """Notes that a render of the view layer of this name has light in fog."""
    _foggy.setdefault(view_layer, [])


def note_noise(view_layer, noise):
    """Notes how noisy the light in fog of a frame is, as passes.noise_of gives it."""
    _foggy[view_layer].append(noise)


def noise(view_layer):
    """How noisy the light in fog of the view layer of this name is: in half of its frames since `clear` it is more, in half less."""
    return median(_foggy.get(view_layer) or [0.0])


def had_fog_light(view_layer):
    """Whether a render of the view layer of this name, in any frame since `clear`, had light in fog."""
    return view_layer in _foggy


def fail(record, message):
    """Notes in its record that a render has failed, and why, as text for artists."""
    global _failed
    record.outcome, record.error = Outcome.FAILED, message
    _failed = _failed or record


def settle():
    """What the renders since `clear` have come to: the first that has failed, else the latest one. From now on `get` gives it."""
    global _latest
    _latest = _failed or _latest
    return _latest


def begin(title):
    """A new render: its record, to be filled in."""
    global _latest
    _latest = Latest(Outcome.RUNNING, title)
    return _latest


def get():
    return _latest
