"""Build hook of wheels: the shared library goes in, and the tag says where it runs.

Its table in pyproject.toml has: package, of the workspace; library, whose module the wheel has; variable of the environment
that names a built library.
"""

import json
import os
import re
import subprocess
import sysconfig
from pathlib import Path

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


def built_library(package: str, root: str) -> Path:
    """Builds the library of a package with cargo and returns where cargo has put it."""
    command = ["cargo", "rustc", "--release", "--package", package, "--crate-type", "cdylib"]
    # What debuggers read would be many times the library.
    command += ["--message-format", "json-render-diagnostics", "--", "-C", "strip=debuginfo"]
    output = subprocess.run(command, cwd=root, check=True, stdout=subprocess.PIPE).stdout
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
    """Takes the library that the variable names; without it cargo builds one."""

    def initialize(self, version, build_data):
        given = os.environ.get(self.config["variable"])
        # A link such as libcovbeam.so -> libcovbeam.so.1 stands for its target.
        library = (Path(given) if given else built_library(self.config["package"], self.root)).resolve(strict=True)
        extension = next(e for e in (".so", ".dylib", ".dll") if e in library.name)
        module = self.config["library"]
        name = f"{module}{extension}" if extension == ".dll" else f"lib{module}{extension}"
        build_data["force_include"][str(library)] = f"{module}/{name}"
        build_data["pure_python"] = False
        build_data["tag"] = f"py3-none-{platform_tag(library)}"
