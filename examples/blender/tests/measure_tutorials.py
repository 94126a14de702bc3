# SPDX-License-Identifier: GPL-3.0-or-later
"""Add Beams beside Cycles in twelve scenes as people make them (tutorials.py): with its default answer, and with the scene's own settings of Cycles.

    python measure_tutorials.py FOLDER [--width 160] [--seconds 10] [--only bars ...]

Of each scene, the light of the fog before the first surface, in two pictures of half as many seconds by covbeam, over two of Cycles of as many
seconds, not denoised, without clamping and adaptive sampling, which are the reference:

- the mean, its standard error, and what Cycles' own clamping leaves of the light;
- the means of 4 x 4 blocks, and how many are off by more than 2 % and three standard errors (*); `--`: darker than 2 % of the mean, or neither known
  to 10 % nor seen to be off;
- what the report names, and what Add Beams does: it replaces Cycles' fog light, or asks, or finds nothing to replace; then Cycles' stays;
- variance times CPU seconds, Cycles' over covbeam's: of all pixels, and the median of blocks of pixels, which leaves bright dots out.

And the finished picture, half of the seconds for Add Beams and half for Cycles, beside Cycles with its denoiser (OpenImageDenoise by albedo and
normal, as Blender sets it) in as much CPU time: how far each is from the reference, root of the mean square of what is shown (a gamma of 2.2, white
where 1 % of the reference is brighter), without the reference's own noise. No error is judged where Cycles lacks a caustic: the reference does, too.

Writes NAME.png: the finished picture, Cycles denoised, the reference; below, the fog's light alone by covbeam, in the render that Cycles denoised,
and the reference. CPU seconds are those of all threads. Seconds of pictures are by the clock: twelve scenes take 11 minutes at 10 s.
"""

import argparse
import os
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import exr
import fog_light
import harness
from measure_glass_ball import show
from tutorials import TUTORIALS, make

import addon
from addon import latest

#: Blocks along each side of a picture; what may be seen as wrong; darker ones, over the mean, and less certain ones are left out.
BLOCKS, WANTED, DARK, KNOWN = 4, 0.02, 0.02, 0.1

#: What makes Cycles' noise smaller and its light another.
_SOFTENED = ("use_denoising", "use_adaptive_sampling", "sample_clamp_direct", "sample_clamp_indirect")


@dataclass(frozen=True)
class Rendered:
    """What one render has made, float64 (h, w, 3): fog, the light of the fog, or None; whole, the picture, or None; CPU and clock seconds."""

    fog: np.ndarray | None
    whole: np.ndarray | None
    cpu: float
    wall: float


def _colours(channels, *ends):
    """The sum of layers whose names end so, or None."""
    names = {name.rsplit(".", 1)[0] for name in channels if "." in name}
    found = [np.stack([channels[f"{name}.{c}"] for c in "RGB"], axis=-1) for name in sorted(names) if name.endswith(ends)]
    return sum(found).astype(np.float64) if found else None


def _timed(work):
    """CPU and clock seconds that a call takes."""
    start, cpu = perf_counter(), fog_light.cpu_seconds()
    work()
    return fog_light.cpu_seconds() - cpu, perf_counter() - start


def _rendered(scene, seconds, seed, layers):
    """Channels of a render of Cycles, as much of it as some seconds allow, and how long it took. layers: those of the passes, or the compositor's."""
    scene.cycles.seed, scene.cycles.time_limit, scene.cycles.samples = seed, seconds, 1 << 20
    harness.write_exr(scene.render.image_settings, layers=layers)
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = str(Path(folder) / "picture.exr")
        spent = _timed(lambda: bpy.ops.render.render(write_still=True))
        return exr.read(Path(scene.render.filepath)), spent


def rendered_plainly(scene, seconds, seed, layers):
    """The same, not denoised, without clamping and adaptive sampling."""
    kept = {name: getattr(scene.cycles, name) for name in _SOFTENED}
    for name in kept:
        setattr(scene.cycles, name, 0)
    found = _rendered(scene, seconds, seed, layers)
    for name, value in kept.items():
        setattr(scene.cycles, name, value)
    return found


def with_cycles(scene, seconds, seed, plain=False):
    """Cycles' picture and its passes of volumes; plain: not denoised, without clamping and adaptive sampling."""
    channels, spent = (rendered_plainly if plain else _rendered)(scene, seconds, seed, True)
    # By their names before Blender 5.0 and since. The compositor's picture has a layer "Composite", as soon as there are nodes.
    fog = _colours(channels, ".VolumeDir", ".VolumeInd", ".Volume Direct", ".Volume Indirect")
    return Rendered(fog, _colours(channels, f"{scene.view_layers[0].name}.Combined"), *spent)


def finished(scene, seconds, seed):
    """What comes out of the compositor after a render of Cycles."""
    channels, spent = _rendered(scene, seconds, seed, False)
    return Rendered(None, np.stack([channels[c] for c in "RGB"], axis=-1).astype(np.float64), *spent)


def with_beams(scene, seconds, seed, folder):
    """covbeam's picture of the fog's light, in a folder of its own. If Add Beams has replaced Cycles' fog light, the compositor's nodes read it."""
    settings = scene.covbeam
    settings.time_limit, settings.passes, settings.seed, settings.folder = seconds, 1 << 20, seed, str(folder)
    scene.render.image_settings.exr_codec = "NONE"
    spent = _timed(bpy.ops.covbeam.add_beams)
    path = Path(folder) / f"beams_{scene.view_layers[0].name}_{scene.frame_current:04}.exr"
    return Rendered(_colours(exr.read(path), ".In-Scattered") if path.exists() else None, None, *spent)


def _blocks(pictures):
    """Means of BLOCKS x BLOCKS blocks of (..., h, w, 3); what is left at the borders is left out."""
    height, width = (size // BLOCKS for size in pictures.shape[-3:-1])
    cut = pictures[..., : height * BLOCKS, : width * BLOCKS, :].mean(axis=-1)
    return cut.reshape(*cut.shape[:-2], BLOCKS, height, BLOCKS, width).mean(axis=(-3, -1))


def _known(pair):
    """The mean of two runs and its standard error. Of two runs a block's own error is uncertain: all blocks' tell of it too."""
    half = np.abs(pair[0] - pair[1]) / 2
    return pair.mean(axis=0), np.sqrt((half**2 + np.mean(half**2)) / 2)


def _noise(runs, mean):
    """Variance between two runs times CPU seconds, over the brightness's square: of all pixels, and the median of squares of 8 x 8 that are lit."""
    variance = np.array([run.fog for run in runs]).var(axis=0, ddof=1) / (mean**2 + (0.05 * mean.mean()) ** 2)
    cost = variance * np.mean([run.cpu for run in runs])
    bright = fog_light.blocks(mean, 8)
    return cost.mean(), np.median(fog_light.blocks(cost, 8)[bright > DARK * bright.mean()])


def _shown(picture, white):
    return np.clip(picture / white, 0, 1) ** (1 / 2.2)


def light(ours, plain):
    """How covbeam's light is beside Cycles', of two runs each: lines of text, the last one for the table."""
    pairs = [np.array([run.fog for run in runs]) for runs in (ours, plain)]
    found, expected = (pair.mean() for pair in pairs)
    if not (found > 0 and expected > 0):
        return [f"light {found:.4g}, Cycles' {expected:.4g}"]
    (blocks, blocks_error), (wanted, wanted_error) = (_known(_blocks(pair)) for pair in pairs)
    # The mean of two runs may be near by chance where their blocks are not.
    ratio = found / expected
    off = ratio * np.hypot(*(np.sqrt((error**2).sum()) / error.size / of for error, of in ((blocks_error, found), (wanted_error, expected))))
    both = np.hypot(blocks_error, wanted_error)
    lit = np.maximum(wanted, blocks) > DARK * max(found, expected)
    wrong = lit & (np.abs(blocks - wanted) > WANTED * wanted + 3 * both)
    seen = wrong | lit & (both < KNOWN * wanted)
    lines = []
    for row in range(BLOCKS):
        of = zip(blocks[row], wanted[row], seen[row], wrong[row])
        lines.append(" ".join(f"{b / max(w, 1e-3 * expected):7.3f}{'*' if x else ' '}" if s else "     -- " for b, w, s, x in of))
    return [*lines, f"light {ratio:6.3f} +- {off:.3f}, blocks off {wrong.sum():2} of {seen.sum():2}"]


def measure(name, width, seconds, folder):
    """Renders a scene, prints what there is to say, and returns its line of the table."""
    start = perf_counter()
    scene, caustic = make(name, width), TUTORIALS[name].caustic
    passes = scene.view_layers[0].cycles
    passes.use_pass_volume_direct = passes.use_pass_volume_indirect = True
    print(f"{name}:", flush=True)
    with tempfile.TemporaryDirectory() as beams:
        ours = [with_beams(scene, seconds / 2, seed, Path(beams) / str(seed)) for seed in (1, 2)]
        entries, asked, advice = list(latest.get().untranslated), latest.missing_in_fog(), list(latest.get().advice)
        composited = finished(scene, seconds / 2, 3)
    replaced = bpy.ops.covbeam.remove_beams.poll()
    if replaced:
        bpy.ops.covbeam.remove_beams()
    answer = "replaces" if replaced else "asks" if asked else "nothing"
    spent = ours[1].cpu + composited.cpu
    # So long by the clock that as much CPU time passes.
    denoised = with_cycles(scene, spent / composited.cpu * composited.wall, 4)
    plain = [with_cycles(scene, seconds, seed, plain=True) for seed in (5, 6)]
    said = (
        [f"entry: {entry}" for entry in entries] + [f"asks for: {what}" for what in asked] + [f"advice: {' '.join(advice)}"] * (answer == "nothing")
    )
    mean = np.mean([run.fog for run in plain], axis=0)
    has_picture = all(run.fog is not None for run in ours)
    lines = light(ours, plain) if has_picture else ["no picture"]
    result = lines[-1]
    said += lines + [f"Cycles' clamping leaves {denoised.fog.mean() / max(mean.mean(), 1e-12):.3f} of its light"]
    if has_picture and min(run.fog.mean() for run in ours) > 0:
        # Brightness: of both.
        both = 0.5 * (mean + np.mean([run.fog for run in ours], axis=0))
        gains = [theirs / covbeams for theirs, covbeams in zip(_noise(plain, both), _noise(ours, both))]
        result += f", variance x CPU {gains[0]:.3g} (median {gains[1]:.3g}) times covbeam's"
    whole = np.array([run.whole for run in plain])
    white = float(np.percentile(whole.mean(axis=0), 99))
    screens = _shown(whole, white)
    own = np.mean((screens[0] - screens[1]) ** 2) / 4
    errors = [100 * np.sqrt(max(np.mean((_shown(run.whole, white) - screens.mean(axis=0)) ** 2) - own, 0)) for run in (composited, denoised)]
    judged = f"not judged: Cycles lacks {caustic}" if caustic else f"{errors[0]:.2f} %, Cycles denoised {errors[1]:.2f} %"
    said.append(f"error of the finished picture {judged} (reference's noise {100 * np.sqrt(own):.2f} %), in {spent:.1f} and {denoised.cpu:.1f} CPU-s")
    said.append(f"{perf_counter() - start:.0f} s")
    print("\n".join(f"  {line}" for line in said), flush=True)
    fogs = [ours[1].fog if has_picture else np.zeros_like(mean), denoised.fog, mean]
    top = max(float(np.percentile(fog, 99)) for fog in (fogs[0], mean))
    rows = [
        [np.clip(p / w, 0, 1) for p in of] for of, w in (((composited.whole, denoised.whole, whole.mean(axis=0)), white), (fogs, max(top, 1e-12)))
    ]
    # Three times as large, for eyes.
    show(folder / name, np.kron(np.concatenate([np.concatenate(row, axis=1) for row in rows]), np.ones((3, 3, 1))))
    return f"{name:15}{answer:9} {result}; error {judged}"


def main(words):
    """Runs the measurement, and prints a table at its end."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--width", type=int, default=160)
    parser.add_argument("--seconds", type=float, default=10, help="of a picture, by the clock")
    parser.add_argument("--only", nargs="*", choices=TUTORIALS, default=list(TUTORIALS))
    arguments = parser.parse_args(words)
    arguments.folder.mkdir(parents=True, exist_ok=True)
    addon.register()
    lines = [measure(name, arguments.width, arguments.seconds, arguments.folder) for name in arguments.only]
    print("\n".join(["", f"Blender {bpy.app.version_string}", *lines]))


if __name__ == "__main__":
    main(sys.argv[1:])
    sys.stdout.flush()
    # Mantaflow ends the process in a way of its own if that is not done here.
    os._exit(0)
