# SPDX-License-Identifier: GPL-3.0-or-later
"""What is rendered, and how: a scene's description, and sessions of the native renderer. numpy and covbeam; no Blender."""

from covbeam import Cancelled, Status

__all__ = ["Cancelled", "ask"]


def ask(poll):
    """Raises Cancelled if the caller wants to stop."""
    if poll is not None and not poll():
        raise Cancelled(Status.CANCELLED, "poll: asked to stop")
