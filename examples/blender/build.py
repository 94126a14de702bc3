#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the extension: covbeam-VERSION-PLATFORM.zip, to be dropped into Blender.

With wheels of covbeam's Python module, for any number of platforms, they go in. Without, one is built for the machine that this runs on, by
cargo, unless COVBEAM_LIBRARY names a built library; that needs hatchling. Python 3.11 or newer. The same input gives the same bytes.
"""

import argparse
import importlib.util
import json
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
ADDON = HERE / "addon"
REPOSITORY = HERE.parent.parent

#: The project of the wheel: covbeam's Python module.
PROJECT = REPOSITORY / "ffi" / "python"

#: The line of the manifest that is replaced.
PLACE = "# build.py puts version, platforms and wheels here.\n"

#: Blender's names of platforms, by how the platform of a wheel begins and ends.
PLATFORMS = {
    ("manylinux", "x86_64"): "linux-x64",
    ("manylinux", "aarch64"): "linux-arm64",
    ("macosx", "arm64"): "macos-arm64",
    ("macosx", "x86_64"): "macos-x64",
    ("win", "amd64"): "windows-x64",
    ("win", "arm64"): "windows-arm64",
}


def build_wheel(folder):
    """Builds the wheel into `folder`; returns its path."""
    print(f"building the wheel of {PROJECT.relative_to(REPOSITORY)}, with its library", flush=True)
    command = [sys.executable, "-m", "hatchling", "build", "--target", "wheel", "--directory", str(folder)]
    # cargo tells how far it is: the minutes that it may take are not silent.
    if subprocess.run(command, cwd=PROJECT).returncode != 0:
        sys.exit(f"build.py: {PROJECT} could not be built (above).")
    (wheel,) = folder.glob("*.whl")
    return wheel


def platform_of(wheel):
    """Blender's name of the platform that a wheel is for."""
    tag = wheel.stem.split("-")[-1]
    for (begin, end), platform in PLATFORMS.items():
        if tag.startswith(begin) and tag.endswith(end):
            return platform
    sys.exit(f"build.py: Blender has no name for the platform of {wheel.name}.")


def manifest(version, platforms, wheels):
    """The text of the manifest, with what is known only now."""
    text = (ADDON / "blender_manifest.toml").read_text(encoding="utf-8")
    if text.count(PLACE) != 1:
        sys.exit(f"build.py: blender_manifest.toml must have this line once: {PLACE}")
    # Strings of JSON are strings of TOML.
    lines = {"version": version, "platforms": platforms, "wheels": [f"./wheels/{wheel.name}" for wheel in wheels]}
    return text.replace(PLACE, "".join(f"{key} = {json.dumps(value)}\n" for key, value in lines.items()))


def write_zip(path, contents):
    """Writes a zip of {name: bytes} whose bytes depend on nothing else: sorted, with one date, readable by all."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name, data in sorted(contents.items()):
            entry = zipfile.ZipInfo(name)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3
            entry.external_attr = 0o100644 << 16
            archive.writestr(entry, data)


def sorted_wheels(wheels):
    """The version of all wheels, and them by platform: one a platform, or the artist would have either."""
    for wheel in wheels:
        if not wheel.is_file() or wheel.suffix != ".whl" or wheel.name.split("-")[0] != "covbeam" or wheel.name.count("-") < 4:
            sys.exit(f"build.py: {wheel} is no wheel of covbeam's: build them with python -m build --wheel ffi/python.")
    versions = sorted({wheel.name.split("-")[1] for wheel in wheels})
    if len(versions) != 1:
        sys.exit(f"build.py: the wheels are of versions {' and '.join(versions)}: give those of one.")
    of_platform = {}
    for wheel in wheels:
        other = of_platform.setdefault(platform_of(wheel), wheel)
        if other != wheel:
            sys.exit(f"build.py: {other.name} and {wheel.name} are for the same platform: give one of them.")
    return versions[0], dict(sorted(of_platform.items()))


def build(output, wheels):
    """Builds the zip into the folder `output`, with these wheels or one that is built now; returns its path."""
    with tempfile.TemporaryDirectory() as folder:
        version, of_platform = sorted_wheels(wheels or [build_wheel(Path(folder))])
        contents = {f"wheels/{wheel.name}": wheel.read_bytes() for wheel in of_platform.values()}
        contents["blender_manifest.toml"] = manifest(version, list(of_platform), of_platform.values()).encode()
        contents["LICENSE"] = (ADDON / "LICENSE").read_bytes()
        for source in ADDON.rglob("*.py"):
            contents[source.relative_to(ADDON).as_posix()] = source.read_bytes()
        output.mkdir(parents=True, exist_ok=True)
        names = ["covbeam", version, *(of_platform if len(of_platform) == 1 else [])]
        path = output / f"{'-'.join(names)}.zip"
        print(f"packing {len(contents)} files: the extension and {', '.join(wheel.name for wheel in of_platform.values())}", flush=True)
        write_zip(path, contents)
    return path


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("wheels", nargs="*", type=Path, metavar="WHEEL", help="of covbeam, one a platform [default: built for this machine]")
    parser.add_argument(
        "--output", type=Path, default=Path.cwd(), metavar="DIR", help="where the zip goes [default: here]"
    )
    options = parser.parse_args()
    if not options.wheels and importlib.util.find_spec("hatchling") is None:
        sys.exit(
            f"build.py: {sys.executable} has no hatchling. Install it into an environment of its own, as the README says:\n"
            "python3 -m venv build/venv && build/venv/bin/pip install hatchling && build/venv/bin/python examples/blender/build.py"
        )
    path = build(options.output, options.wheels)
    print(f"{path}: {path.stat().st_size / 1e6:.1f} MB; drop it into Blender's window")


if __name__ == "__main__":
    main()
