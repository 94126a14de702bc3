"""Build hook of wheels: the shared library goes in, with the licences of what is linked into it; the tag says where it runs, as the file
itself does, whatever this machine is.

Its table in pyproject.toml has: package, of the workspace; library, whose module the wheel has; variable of the environment
that names a built library.
"""

import json
import os
import re
import struct
import subprocess
import tempfile
from pathlib import Path

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


#: Processors in the headers of libraries, by their names in tags.
ELF_MACHINES = {62: "x86_64", 183: "aarch64"}
MACH_O_MACHINES = {0x01000007: "x86_64", 0x0100000C: "arm64"}
PE_MACHINES = {0x8664: "amd64", 0xAA64: "arm64"}

LICENCE = re.compile("licen[cs]e|copying|notice|copyright", re.IGNORECASE)


class Unfit(Exception):
    """Why no wheel can be made of a library."""


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


def licences_of(crate: dict) -> list[Path]:
    """The files of a crate that have its licence."""
    return sorted(f for f in Path(crate["manifest_path"]).parent.iterdir() if LICENCE.match(f.name))


def third_party(package: str, target: str, root: str) -> str:
    """The licences of all crates that are linked into a package's library for a target, and of Rust's own: each text once."""
    tree = ["tree", "--locked", "--package", package, "--target", target, "--edges", "normal,no-proc-macro", "--prefix", "none"]
    linked = set(said(root, "cargo", *tree, "--format", "{p}").splitlines())
    of_text = {}
    crates = json.loads(said(root, "cargo", "metadata", "--locked", "--format-version", "1"))["packages"]
    for crate in crates:
        name = f"{crate['name']} v{crate['version']}"
        # Packages of the workspace have no source, and their path behind their name.
        if crate["source"] is None or name not in linked:
            continue
        # Some parts of a repository leave the text to the others.
        siblings = [other for other in crates if crate["repository"] and other["repository"] == crate["repository"]]
        files = next((files for files in map(licences_of, [crate, *siblings]) if files), None)
        if not files and "Apache-2.0" in re.split(" OR |/", crate["license"]):
            files = [Path(__file__).parents[2] / "LICENSE-APACHE"]
        if not files:
            raise RuntimeError(f"{name} ({crate['license']}) has no file with its licence")
        for file in files:
            names = of_text.setdefault(file.read_text(encoding="utf-8").strip(), [])
            names.append(f"{name} ({crate['license']}), {file.name}")
    sysroot = said(root, "rustc", "--print", "sysroot").strip()
    # Rust as rustup installs it has all notices of its standard library. Distributions leave that file out: then a summary has to do.
    complete = Path(sysroot, "share/doc/rust/COPYRIGHT-library.html")
    if complete.exists():
        of_text[complete.read_text(encoding="utf-8").strip()] = ["Rust's standard library, as HTML"]
    else:
        summary = Path(__file__).with_name("rust-standard-library.txt")
        of_text[summary.read_text(encoding="utf-8").strip()] = ["Rust's standard library, in short"]
    line = "\n" + "-" * 110 + "\n"
    return line.join("\n".join(names) + "\n\n" + text + "\n" for text, names in of_text.items())


def elf_platform(data: bytes) -> str:
    """Linux: manylinux of the newest glibc whose symbols the library asks for."""
    machine = ELF_MACHINES.get(int.from_bytes(data[18:20], "little"))
    # Names of needed versions are strings of the file. One in an unrelated place could only make the tag too strict.
    versions = [(int(major), int(minor)) for major, minor in re.findall(rb"GLIBC_(\d+)\.(\d+)", data)]
    if machine is None or not versions:
        raise Unfit("is for a processor that no tag is known of, or asks for no glibc: wheels are for Linux with glibc on x86-64 and aarch64")
    # Rust's own programs need 2.17, and pip knows no older one on aarch64.
    major, minor = max(*versions, (2, 17))
    return f"manylinux_{major}_{minor}_{machine}"


def mach_o_platform(data: bytes) -> str:
    """macOS: the oldest version that the library says it runs on, as pip counts them: from 11 on by whole numbers."""
    machine = MACH_O_MACHINES.get(int.from_bytes(data[4:8], "little"))
    count, at = int.from_bytes(data[16:20], "little"), 32
    for _ in range(count):
        command, size, *words = struct.unpack_from("<4I", data, at)
        # LC_VERSION_MIN_MACOSX has the version, LC_BUILD_VERSION platform 1 and the version.
        version = words[0] if command == 0x24 else words[1] if (command, words[0]) == (0x32, 1) else None
        if version is not None and machine is not None:
            major, minor = version >> 16, version >> 8 & 255
            if major >= 11:
                major, minor = major + (version & 0xFFFF > 0), 0
            return f"macosx_{major}_{minor}_{machine}"
        at += size
    raise Unfit("does not say which macOS and processor it is for: build it with MACOSX_DEPLOYMENT_TARGET set")


def pe_platform(data: bytes) -> str:
    """Windows: by the processor."""
    header = int.from_bytes(data[60:64], "little")
    machine = PE_MACHINES.get(int.from_bytes(data[header + 4 : header + 6], "little"))
    if data[header : header + 4] != b"PE\0\0" or machine is None:
        raise Unfit("is for a processor that no tag is known of: wheels are for Windows on x86-64 and ARM64")
    return f"win_{machine}"


def platform_of(library: Path) -> tuple[str, str, str]:
    """What the file itself says it is for: the wheel's platform tag, the library's name there with {} for the module's, Rust's name of the target."""
    data = library.read_bytes()
    try:
        if data[:6] == b"\x7fELF\x02\x01":
            tag, name, target = elf_platform(data), "lib{}.so", "unknown-linux-gnu"
        elif data[:4] == b"\xcf\xfa\xed\xfe":
            tag, name, target = mach_o_platform(data), "lib{}.dylib", "apple-darwin"
        elif data[:2] == b"MZ":
            tag, name, target = pe_platform(data), "{}.dll", "pc-windows-msvc"
        elif data[:4] == b"\xca\xfe\xba\xbe":
            raise Unfit("is for several processors: take one of them out with `lipo -thin`")
        else:
            raise Unfit("is no shared library of Linux, macOS or Windows")
    except (Unfit, struct.error) as error:
        raise Unfit(f"{library} {error if isinstance(error, Unfit) else 'is cut off: build it anew'}.") from None
    return tag, name, f"{'x86_64' if tag.endswith(('x86_64', 'amd64')) else 'aarch64'}-{target}"


class LibraryHook(BuildHookInterface):
    """Takes the library that the variable names; without it cargo builds one."""

    def initialize(self, version, build_data):
        if self.target_name != "wheel":
            self.app.abort("There is no source distribution: the library's sources lie outside of this folder. Build wheels, in a checkout: python -m build --wheel")
        given = os.environ.get(self.config["variable"])
        if given and not Path(given).is_file():
            self.app.abort(f"{self.config['variable']} is {given}, where there is no file: set it to the path of the shared library, or unset it.")
        # A link such as libcovbeam.so -> libcovbeam.so.1 stands for its target.
        library = (Path(given) if given else built_library(self.config["package"], self.root)).resolve(strict=True)
        try:
            tag, name, target = platform_of(library)
        except Unfit as error:
            self.app.abort(str(error))
        module = self.config["library"]
        build_data["force_include"][str(library)] = f"{module}/{name.format(module)}"
        self.folder = tempfile.TemporaryDirectory()
        licences = Path(self.folder.name, "THIRD-PARTY")
        licences.write_text(third_party(self.config["package"], target, self.root), encoding="utf-8")
        build_data["force_include"][str(licences)] = f"{module}/THIRD-PARTY"
        build_data["pure_python"] = False
        build_data["tag"] = f"py3-none-{tag}"

    def finalize(self, version, build_data, artifact_path):
        self.folder.cleanup()
