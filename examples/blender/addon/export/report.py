# SPDX-License-Identifier: GPL-3.0-or-later
"""What of a Blender scene is not rendered as Cycles renders it."""

from dataclasses import dataclass

#: Of more sources than this an entry names but the first: a line is to be read.
_NAMED = 3


class Untranslatable(Exception):
    """Nothing sensible can be rendered; the message names the object and the remedy."""


@dataclass(frozen=True)
class Entry:
    """`what` of the `sources` (such as 'Material "Wall"') is not honoured, and what is done `instead`.

    in_fog: whether fog, or light in it, is missing or of another shape for that: what Cycles has of it must not be taken away.
    """

    what: str
    instead: str
    sources: tuple[str, ...]
    in_fog: bool = False

    def __str__(self):
        named = ", ".join(self.sources)
        if len(self.sources) > _NAMED:
            named = f"{self.sources[0]} and {len(self.sources) - 1} more"
        return f"{named}: {self.what}: {self.instead}"


class Report:
    """Collects entries in the order of their first source; equal ones are one, with all their sources."""

    def __init__(self):
        # A dict of dicts as an ordered set of sources for each entry.
        self._sources = {}

    def add(self, source, what, instead, in_fog=False):
        """Notes that `what` of `source` is not honoured, and what is done `instead`; in_fog as in Entry."""
        self._sources.setdefault((what, instead, in_fog), {})[source] = None

    def extend(self, other):
        """Adds what another Report says."""
        for entry in other.entries:
            for source in entry.sources:
                self.add(source, entry.what, entry.instead, entry.in_fog)

    @property
    def entries(self):
        """The entries so far: list of Entry."""
        return [Entry(what, instead, tuple(sources), in_fog) for (what, instead, in_fog), sources in self._sources.items()]

    def __len__(self):
        return len(self._sources)

    def __str__(self):
        """One line an entry, without an end of line after the last; empty without entries."""
        return "\n".join(map(str, self.entries))
