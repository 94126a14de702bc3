"""Build hook of the wheel: the shared library goes in, and the tag says where it runs."""

import json
import os
import re
import subprocess
import sysconfig
from pathlib import Path

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


def built_library(root: Path) -> Path:
    """Builds the library with cargo and returns where cargo has put it."""
    command = ["cargo", "rustc", "--release", "--package", "covbeam-rays", "--crate-type", "cdylib"]
    # What debuggers read would be 30 times the library.
    command += ["--message-format", "json-render-diagnostics", "--", "-C", "strip=debuginfo"]
    output = subprocess.run(command, cwd=root.parent, check=True, stdout=subprocess.PIPE).stdout
    for line in output.splitlines():
        message = json.loads(line)
        if message["reason"] == "compiler-artifact" and "cdylib" in message["target"]["crate_types"]:
            return Path(next(f for f in message["filenames"] if Path(f).suffix in (".so", ".dylib", ".dll")))
    raise RuntimeError("cargo built no shared library")


def platform_tag(library: Path) -> str:
    """The platform of the wheel. On Linux: manylinux of the newest glibc whose symbols the library asks for."""
    platform = sysconfig.get_platform()
    if not platform.startswith("linux"):
        return re.sub(r"[-.]", "_", platform)
    # Names of needed versions are strings of the file. One in an unrelated place could only make the tag too strict.
    versions = re.findall(rb"GLIBC_(\d+)\.(\d+)", library.read_bytes())
    if not versions:
        raise RuntimeError(f"{library} asks for no glibc: no manylinux tag fits it")
    major, minor = max((int(major), int(minor)) for major, minor in versions)
    return f"manylinux_{major}_{minor}_{platform.removeprefix('linux-').replace('-', '_')}"


class LibraryHook(BuildHookInterface):
    """Takes the library that COVBEAM_RAYS_LIBRARY names; without it cargo builds one."""

    def initialize(self, version, build_data):
        given = os.environ.get("COVBEAM_RAYS_LIBRARY")
        library = (Path(given) if given else built_library(Path(self.root))).resolve(strict=True)
        name = f"covbeam_rays{library.suffix}" if library.suffix == ".dll" else f"libcovbeam_rays{library.suffix}"
        build_data["force_include"][str(library)] = f"covbeam_rays/{name}"
        build_data["pure_python"] = False
        build_data["tag"] = f"py3-none-{platform_tag(library)}"
