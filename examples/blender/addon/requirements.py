# SPDX-License-Identifier: GPL-3.0-or-later
"""What the add-on needs to run: Blender's version, numpy, and the library in its wheel."""

import functools
import importlib.metadata
import platform
import re
import sys
from pathlib import Path

import bpy

#: The same as blender_version_min of the manifest.
OLDEST_BLENDER = (4, 2, 0)

_REINSTALL = (
    "Remove the extension in Preferences > Get Extensions, restart Blender, and install the zip made for this system "
    "with Install from Disk."
)


_found = None


def _dotted(version):
    return ".".join(str(number) for number in version)


def too_old():
    """Whether this Blender is older than what the add-on is written for."""
    return tuple(bpy.app.version) < OLDEST_BLENDER


def _system():
    return f"{platform.system()} on {platform.machine()}, Python {_dotted(sys.version_info[:2])}"


def _module_problem(name):
    """Why the module `name` cannot be used, as text for artists, or None."""
    try:
        importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name == "numpy":
            return (
                "numpy is missing from this Blender. Covbeam computes with it. Blender from blender.org brings it; "
                "for a Blender of your system's packages install the package python3-numpy."
            )
        return f"The extension is not installed completely: its module {error.name} is missing. {_REINSTALL}"
    # Whatever goes wrong in loading it, an artist reads this instead of a traceback.
    except Exception as error:
        return (
            f"The library of the extension's module {name} does not run here ({_system()}): it is missing, damaged, "
            f"of another version, or for another system. {_REINSTALL} Details: {error}"
        )
    return None


# Once, as the viewport asks often: only an update changes versions, and it loads the add-on anew.
@functools.cache
def _version_problem():
    """Why the library that is loaded is not the one that is installed, as text for artists, or None."""
    covbeam = importlib.import_module("covbeam")
    folder = Path(covbeam.__file__).parents[1]
    # Numbers alone, as wheels write what may follow them differently. A checkout has no wheel beside it.
    installed = {_numbers(wheel.version) for wheel in importlib.metadata.distributions(name="covbeam", path=[str(folder)])}
    loaded = _numbers(covbeam.__version__)
    if not installed or loaded in installed:
        return None
    return (
        f"Restart Blender: it still runs the library of Covbeam {loaded}, and {' and '.join(sorted(installed))} is installed. "
        f"If this is told again: {_REINSTALL}"
    )


def _numbers(version):
    return re.match(r"[0-9.]*[0-9]", version)[0]


def _problem():
    if too_old():
        return (
            f"This is Blender {_dotted(bpy.app.version)}. "
            f"Covbeam needs Blender {_dotted(OLDEST_BLENDER[:2])} or newer; get it from blender.org."
        )
    problems = map(_module_problem, ("numpy", "covbeam.session"))
    return next((problem for problem in problems if problem is not None), None) or _version_problem()


def check():
    """What keeps the add-on from working, as text for artists, or None."""
    global _found
    _found = _problem()
    return _found


def found():
    """What the last check has found: for panels, which are drawn too often to look for files."""
    return _found
