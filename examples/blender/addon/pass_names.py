# SPDX-License-Identifier: GPL-3.0-or-later
"""The passes of a view layer, by Blender's names: known where nothing can be rendered, too."""

#: Name, channels, their letters and kind of each pass, in Blender's words.
_PASSES = (
    ("Combined", 4, "RGBA", "COLOR"),
    ("In-Scattered", 3, "RGB", "COLOR"),
    ("Radius", 1, "X", "VALUE"),
    ("Bandwidth", 1, "X", "VALUE"),
    ("Standard Error", 1, "X", "VALUE"),
)


def passes_of(view_layer):
    """Passes of a view layer: those that all have, and those of its light groups."""
    return _PASSES + tuple((group_pass(group.name), 3, "RGB", "COLOR") for group in view_layer.lightgroups)


def group_pass(group):
    """The name of a light group's pass, as Blender names Cycles': at most 63 bytes."""
    return f"In-Scattered_{group}".encode()[:63].decode(errors="ignore")
