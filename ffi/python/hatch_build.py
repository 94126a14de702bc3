"""Build hook of wheels: the shared library goes in, with the licences of what is linked into it; the tag says where it runs.

Its table in pyproject.toml has: package, of the workspace; library, whose module the wheel has; variable of the environment
that names a built library.
"""

import json
import os
import re
import subprocess
import sysconfig
import tempfile
from pathlib import Path

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


LICENCE = re.compile("licen[cs]e|copying|notice|copyright", re.IGNORECASE)


def said(root: str, program: str, *arguments: str) -> str:
    """What cargo or rustc prints; the environment may name others, as for cargo itself."""
    command = [os.environ.get(program.upper(), program), *arguments]
    return subprocess.run(command, cwd=root, check=True, stdout=subprocess.PIPE, text=True).stdout


def built_library(package: str, root: str) -> Path:
    """Builds the library of a package with cargo and returns where cargo has put it."""
    arguments = ["rustc", "--locked", "--release", "--package", package, "--crate-type", "cdylib"]
    # What debuggers read would be many times the library.
    arguments += ["--message-format", "json-render-diagnostics", "--", "-C", "strip=debuginfo"]
    for line in said(root, "cargo", *arguments).splitlines():
        message = json.loads(line)
        if message["reason"] == "compiler-artifact" and "cdylib" in message["target"]["crate_types"]:
            return Path(next(f for f in message["filenames"] if Path(f).suffix in (".so", ".dylib", ".dll")))
    raise RuntimeError("cargo built no shared library")


def third_party(package: str, root: str) -> str:
    """The licences of all crates that are linked into a package's library, and of Rust's own: each text once."""
    tree = ["tree", "--locked", "--package", package, "--edges", "normal,no-proc-macro", "--prefix", "none"]
    linked = set(said(root, "cargo", *tree, "--format", "{p}").splitlines())
    of_text = {}
    for crate in json.loads(said(root, "cargo", "metadata", "--locked", "--format-version", "1"))["packages"]:
        name = f"{crate['name']} v{crate['version']}"
        # Packages of the workspace have no source, and their path behind their name.
        if crate["source"] is None or name not in linked:
            continue
        folder = Path(crate["manifest_path"]).parent
        files = sorted(f for f in folder.iterdir() if LICENCE.match(f.name))
        if not files:
            raise RuntimeError(f"{name} ({crate['license']}) has no file with its licence")
        for file in files:
            names = of_text.setdefault(file.read_text(encoding="utf-8").strip(), [])
            names.append(f"{name} ({crate['license']}), {file.name}")
    sysroot = said(root, "rustc", "--print", "sysroot").strip()
    standard = Path(sysroot, "share/doc/rust/COPYRIGHT-library.html")
    of_text[standard.read_text(encoding="utf-8").strip()] = ["Rust's standard library, as HTML"]
    line = "\n" + "-" * 110 + "\n"
    return line.join("\n".join(names) + "\n\n" + text + "\n" for text, names in of_text.items())


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
        self.folder = tempfile.TemporaryDirectory()
        licences = Path(self.folder.name, "THIRD-PARTY")
        licences.write_text(third_party(self.config["package"], self.root), encoding="utf-8")
        build_data["force_include"][str(licences)] = f"{module}/THIRD-PARTY"
        build_data["pure_python"] = False
        build_data["tag"] = f"py3-none-{platform_tag(library)}"

    def finalize(self, version, build_data, artifact_path):
        self.folder.cleanup()
