# SPDX-License-Identifier: GPL-3.0-or-later
"""The same scenes in the reference renderer and in the extension's sessions: CPU time of a pass.

    python measure_renderer.py COVBEAM [--size 192] [--passes 24] [--photons 5000]

COVBEAM: the renderer's program, from `cargo build --release`; the library in the covbeam wheel must be of a release build, too. A pass is
the difference between a short run and a long one; the start is what is left of the short one.
"""

import argparse
import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from time import process_time

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import bpy  # noqa: F401  the add-on is a package of Blender's
import host_scenes as scenes
from addon.host.session import Session, Settings

#: Passes of the short run.
FEW = 4

#: Of a ball: its material here and there.
BALLS = {"black ball": (scenes.BLACK, '"black"'), "glass ball": (scenes.GLASS, "{ dielectric = { index = 1.5 } }")}

FILE = """outside_medium = "fog"
[camera]
position = [0, 0.5, -5]
look_at = [0, 0, 0]
vertical_fov = 35
width = {size}
height = {size}
[[medium]]
name = "fog"
scattering = 0.2
absorption = 0.02
[[object]]
shape = "mesh"
file = "ball.obj"
smooth = true
material = {material}
[[light]]
kind = "lamp"
position = [0, 2.5, 0]
intensity = 25
[render]
photons = {photons}
"""


def obj(mesh):
    """A mesh of host_scenes as a Wavefront OBJ, with its normals."""
    positions, triangles, normals = mesh
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in positions]
    lines += [f"vn {x:.9g} {y:.9g} {z:.9g}" for x, y, z in normals.reshape(-1, 3)]
    for number, corners in enumerate(triangles + 1):
        lines.append("f " + " ".join(f"{corner}//{3 * number + k + 1}" for k, corner in enumerate(corners)))
    return "\n".join(lines) + "\n"


def by_the_renderer(program, folder, passes):
    """CPU-seconds of a render of scene.toml in the folder, its start and its files included."""

    def spent():
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        return used.ru_utime + used.ru_stime

    before, picture = spent(), folder / "picture.exr"
    subprocess.run(
        [program, "render", folder / "scene.toml", "--passes", str(passes), "--out", picture], check=True, capture_output=True, text=True
    )
    return spent() - before


def by_the_extension(made, photons, passes):
    """CPU-seconds of a session and its picture."""
    start = process_time()
    session = Session(made, Settings(photons=photons, seed=1))
    for _ in range(passes):
        session.render_pass()
    session.picture()
    session.close()
    return process_time() - start


def main(words):
    """Renders, and prints the figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", type=Path)
    parser.add_argument("--size", type=int, default=192)
    parser.add_argument("--passes", type=int, default=24)
    parser.add_argument("--photons", type=int, default=5000)
    given = parser.parse_args(words)
    mesh = scenes.icosphere(0.5, levels=4)
    view = scenes.camera((0, 0.5, -5), (0, 0, 0), 35, given.size, given.size)
    fog, lamp = scenes.volume("fog", 0.2, 0.02), scenes.point((0, 2.5, 0), 25)
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        (folder / "ball.obj").write_text(obj(mesh))
        for name, (here, there) in BALLS.items():
            (folder / "scene.toml").write_text(FILE.format(size=given.size, material=there, photons=given.photons))
            made = scenes.scene([(mesh, here, -1)], [lamp], [fog], view, world=0)
            hosts = {
                "renderer": lambda passes: by_the_renderer(given.program, folder, passes),
                "extension": lambda passes, made=made: by_the_extension(made, given.photons, passes),
            }
            passes = {}
            for host, run in hosts.items():
                # The first run of a process finds caches cold.
                run(1)
                short, long = run(FEW), run(given.passes)
                passes[host] = (long - short) / (given.passes - FEW)
                print(f"{name}, {host}: {passes[host]:.3f} CPU-s a pass, {short - FEW * passes[host]:.2f} before the first")
            print(f"{name}: a pass of the extension takes {passes['extension'] / passes['renderer']:.2f} times as long")


if __name__ == "__main__":
    main(sys.argv[1:])
