#!/usr/bin/env python3
"""What many machines would do: times real pieces of a picture one after another, on an otherwise idle machine, and
schedules as many such pieces on as many such machines.

    beyond.py BINARY scene.toml [--width 1920 --height 1080] [--passes 1024] [--chunk 4]
"""

import argparse
import heapq
import re
import subprocess
import tempfile
import time
from pathlib import Path


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("binary", type=Path)
    parser.add_argument("scene", type=Path)
    parser.add_argument("--width", type=int, default=1920)
    parser.add_argument("--height", type=int, default=1080)
    parser.add_argument("--passes", type=int, default=1024, help="of the whole picture")
    parser.add_argument("--chunk", type=int, default=4, help="passes of a piece")
    return parser.parse_args()


def sized(scene: Path, width: int, height: int) -> str:
    """The scene in other pixels, its meshes and volumes still found."""
    text = re.sub(r"(?m)^width = \d+", f"width = {width}", scene.read_text())
    text = re.sub(r"(?m)^height = \d+", f"height = {height}", text)
    return re.sub(r'file = "', f'file = "{scene.resolve().parent}/', text)


class Clock:
    """Runs covbeam and says how long it took."""

    def __init__(self, binary: Path, folder: Path) -> None:
        self.binary, self.folder = binary.resolve(), folder

    def __call__(self, *command: str) -> float:
        return self.said(*command)[0]

    def said(self, *command: str) -> tuple[float, str]:
        start = time.monotonic()
        done = subprocess.run(
            [self.binary, *command], cwd=self.folder, check=True, capture_output=True, text=True
        )
        return time.monotonic() - start, done.stdout

    def merge(self, shards: list[str]) -> tuple[float, float]:
        """Time to add a shard, and to make the picture of all."""
        whole, text = self.said("merge", *shards, "--allow-gaps", "--out", "all.exr")
        found = re.search(r"merged .* in ([0-9.]+) s", text)
        assert found, text
        adding = float(found[1])
        return adding / len(shards), whole - adding


def field_passes(passes: int) -> int:
    """How many of so many passes trace light fields: the first eight, every eighth up to 64, then four a doubling."""
    count, at = 0, 1
    while at <= passes:
        count += 1
        at += 1 if at < 8 else max(8, 2 ** (at.bit_length() - 1) // 4)
    return count


def simulate(tasks: list[float], nodes: int) -> float:
    """When the last of the tasks ends, each begun in its turn by the first machine that is free."""
    free = [0.0] * nodes
    for task in tasks:
        heapq.heappush(free, heapq.heappop(free) + task)
    return max(free)


def main() -> None:
    args = arguments()
    last = args.passes - args.chunk
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "scene.toml").write_text(sized(args.scene, args.width, args.height))
        run = Clock(args.binary, folder)
        piece = lambda a, b, *more: run(
            "render", "scene.toml", "--passes", f"{a}..{b}", "--out", f"{a}-{b}.shard", *more
        )
        prepare = run(
            "prepare", "scene.toml", "--passes", str(args.passes), "--out", "scene.fields"
        )
        fields = ("--fields", "scene.fields")
        # Where kernels are wide, narrower, and narrow: passes become cheaper.
        places = [0, args.passes // 16, last]
        whole = [piece(at, at + args.chunk, *fields) for at in places]
        one = piece(last - 1, last, *fields)
        a_pass = [(time - one) / (args.chunk - 1) for time in whole]
        start = one - a_pass[-1]
        retraced = piece(last - 2, last - 1) - one
        bytes_a_shard = (folder / f"{last}-{args.passes}.shard").stat().st_size
        shards = sorted(path.name for path in folder.glob("*.shard"))
        # The least of three: the first one also reads the disk.
        merge, picture = min(run.merge(shards) for _ in range(3))

    def pass_time(at: float) -> float:
        for (x0, y0), (x1, y1) in zip(zip(places, a_pass), zip(places[1:], a_pass[1:])):
            if at <= x1:
                return y0 + (y1 - y0) * (at - x0) / (x1 - x0)
        return a_pass[-1]

    a_field = retraced / field_passes(last - 2)
    passes = [pass_time(at) for at in range(args.passes)]
    alone = start + sum(passes) + picture
    print(
        f"{args.scene.stem}, {args.width} x {args.height}, {args.passes} passes in pieces of {args.chunk}, measured here:"
    )
    print(
        f"  a pass {a_pass[0]:.2f} s at first, {a_pass[1]:.2f} s after {places[1]}, {a_pass[2]:.2f} s at last"
    )
    print(f"  start and end of a piece {start:.2f} s; a shard {bytes_a_shard / 1e6:.0f} MB")
    print(
        f"  light fields {1000 * a_field:.1f} ms for each pass that has some, {retraced:.1f} s before the last piece; prepared {prepare:.1f} s"
    )
    print(f"  merge {merge:.3f} s a shard and {picture:.2f} s for the picture")
    print(
        f"one machine: {alone:.0f} s. Each piece retraces light fields, or all read what was prepared:"
    )
    print("  machines   speed-up   of ideal   with prepare   of ideal   without merge")
    cuts = range(0, args.passes, args.chunk)
    for nodes in (1, 4, 16, 64, 256, 1000):
        bare = [start + sum(passes[at : at + args.chunk]) for at in cuts]
        own = [task + a_field * field_passes(at) for task, at in zip(bare, cuts)]
        # In a tree on the same machines: each merges its own, then the picture is made of what they have.
        per_node = min(nodes, len(bare))
        fan = max(round(per_node**0.5), 1)
        tree = merge * (len(bare) / per_node + fan + per_node / fan) + picture
        times = simulate(own, nodes), prepare + simulate(bare, nodes)
        found = [alone / (time + tree) for time in times]
        free = alone / times[1]
        print(
            f"  {nodes:8} {found[0]:10.1f} {100 * found[0] / nodes:8.0f} % {found[1]:14.1f} {100 * found[1] / nodes:8.0f} % "
            f"{100 * free / nodes:13.0f} %"
        )


if __name__ == "__main__":
    main()
