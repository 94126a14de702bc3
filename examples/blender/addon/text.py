# SPDX-License-Identifier: GPL-3.0-or-later
"""Text for people: durations, memory, long lists, and paragraphs in panels, which do not wrap text themselves."""

import textwrap


def duration(seconds):
    """Such as 0.4 s, 12 s, 3:05 min, 2:10 h."""
    if seconds < 9.95:
        return f"{seconds:.1f} s"
    seconds = round(seconds)
    if seconds < 60:
        return f"{seconds} s"
    minutes, seconds = divmod(seconds, 60)
    if minutes < 60:
        return f"{minutes}:{seconds:02} min"
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02} h"


def memory(count):
    """Bytes, such as 12.3 MB."""
    return f"{count / 1e6:.1f} MB"


def shortened(things, most):
    """Names of things in a sentence: those that fit into `most` characters, the first always, and how many more there are."""
    shown = 1
    while shown < len(things) and len("; ".join(things[: shown + 1])) <= most:
        shown += 1
    more = len(things) - shown
    return "; ".join(things[:shown]) + (f"; and {more} more, which the report has" if more else "")


def draw(layout, paragraph, *, icon="NONE", width=60):
    """Draws a paragraph as labels of at most `width` characters; `icon` stands before the first."""
    column = layout.column(align=True)
    column.scale_y = 0.8
    for index, line in enumerate(textwrap.wrap(paragraph, width, break_on_hyphens=False)):
        column.label(text=line, icon=icon if index == 0 else ("NONE" if icon == "NONE" else "BLANK1"))
