# SPDX-License-Identifier: GPL-3.0-or-later
"""The host: traces photons and eye rays of a scene and lets covbeam gather. numpy, covbeam and covbeam_rays; no Blender."""


class Cancelled(Exception):
    """The caller's poll has said no; what was done before is kept."""


def ask(poll):
    """Raises Cancelled if the caller wants to stop."""
    if poll is not None and not poll():
        raise Cancelled
