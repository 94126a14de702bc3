#!/usr/bin/env python3
"""Render one picture on many Dask workers.

The workers must see the scene, the picture's folder and covbeam under the paths that are given
here; of this file they need nothing. Start them with one thread each: `dask worker ADDRESS
--nthreads 1`, since covbeam itself uses all cores. For Linux and macOS.
"""

from __future__ import annotations

import argparse
import fcntl
import json
import os
import shutil
import socket
import subprocess
import sys
import time
import uuid
from concurrent.futures import CancelledError
from contextlib import ExitStack, suppress
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

from distributed import Client, Event, Future, KilledWorker, LocalCluster, as_completed, wait

# Exit codes of covbeam: wrong usage and refused input come again however often it is tried.
FAILED, USAGE, REFUSED, INTERRUPTED = 1, 2, 3, 130

# Becomes covbeam, which gets SIGTERM when its worker dies. Not preexec_fn: a worker has threads.
BECOME = """
import ctypes, os, sys
if sys.platform == "linux":
    ctypes.CDLL(None).prctl(1, 15)  # PR_SET_PDEATHSIG
if os.getppid() == int(sys.argv[1]):
    os.execv(sys.argv[2], sys.argv[2:])
"""


class Failure(Exception):
    """Ends the program with a message and an exit code."""

    def __init__(self, message: str, code: int = FAILED) -> None:
        super().__init__(message)
        self.code = code


class Piece(NamedTuple):
    passes: str  # A..B
    shard: Path


def render_piece(command: list[str], shard: str, stop: str) -> tuple[int, str]:
    """On a worker: render into a shard, after the passes that it holds already.

    Answers an exit code and a reason. What is worth another try is raised, for Dask to try it.
    """
    host, folder, stopped = socket.gethostname(), os.path.dirname(shard), Event(stop)
    program = shutil.which(command[0])
    if program is None:
        remedy = "install it there, or say with --covbeam where it is"
        return USAGE, f"{command[0]} is not on {host}: {remedy}"
    if not os.path.isdir(folder):
        remedy = "choose --out in a folder that all workers share"
        return USAGE, f"{folder} is not on {host}: {remedy}"

    with open(f"{shard}.lock", "w") as lock:
        # covbeam inherits the lock and holds it until it ends. One that outlives its worker thus
        # keeps the next one waiting: of two that write one shard, the slower would put its fewer
        # passes over those of the other.
        while not stopped.is_set():
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                break
            except BlockingIOError:
                time.sleep(0.5)
        if stopped.is_set():
            return INTERRUPTED, "stopped"
        guard = [sys.executable, "-I", "-c", BECOME, str(os.getpid())]
        process = subprocess.Popen(
            [*guard, program, *command[1:], "--progress", "json"],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            pass_fds=[lock.fileno()],
            start_new_session=True,
        )
        told = False
        try:
            while True:
                try:
                    events, errors = process.communicate(timeout=1)
                    break
                except subprocess.TimeoutExpired:
                    told = stopped.is_set()
                    if told:
                        process.terminate()
        finally:
            if process.poll() is None:
                process.terminate()
                process.wait()

    if told:
        return INTERRUPTED, "stopped"
    if process.returncode in (0, USAGE, REFUSED):
        last = json.loads(events.splitlines()[-1]) if events else {}
        return process.returncode, last.get("message") or errors
    raise RuntimeError(f"covbeam on {host} ended with {process.returncode}: {errors.strip()}")


def merge(covbeam: str, shards: list[Path], out: Path, *options: str) -> None:
    command = [covbeam, "merge", *map(str, shards), "--out", str(out), *options]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    if result.returncode:
        raise Failure(f"cannot merge: {result.stderr.strip()}", result.returncode)


class SoFar:
    """The picture of what is there; writing it takes a tenth of the time at most."""

    def __init__(self, covbeam: str, shards: list[Path], out: Path) -> None:
        self.covbeam, self.shards, self.out = covbeam, shards, out
        self.next = 0.0

    def show(self) -> None:
        begun = time.monotonic()
        # Shards that are still written have some of their passes, too.
        there = [shard for shard in self.shards if shard.exists()]
        if begun < self.next or not there:
            return
        merge(self.covbeam, there, self.out, "--allow-gaps")
        print(f"wrote {self.out}")
        now = time.monotonic()
        self.next = now + max(1.0, 9 * (now - begun))


def gather(futures: dict[Future, Piece], so_far: SoFar | None) -> None:
    for done, future in enumerate(as_completed(futures), 1):
        passes = futures[future].passes
        try:
            code, why = future.result()
        except KilledWorker as error:
            raise Failure(f"passes {passes}: {error}") from error
        except CancelledError as error:
            raise Failure(f"passes {passes}: the scheduler is gone or dropped them") from error
        except (RuntimeError, OSError) as error:
            raise Failure(f"passes {passes}: {error}") from error
        if code:
            raise Failure(f"passes {passes}: {why}", code)
        print(f"passes {passes} are there, {done} of {len(futures)} pieces", flush=True)
        if so_far:
            so_far.show()


def halt(client: Client, futures: dict[Future, Piece], stop: Event) -> None:
    """Those that run write what they have, those that wait do not begin."""
    if client.status != "running":
        return
    with suppress(TimeoutError, OSError):
        stop.set()
        begun = {key for keys in client.processing().values() for key in keys}
        client.cancel([future for future in futures if future.key not in begun])
        wait([future for future in futures if future.key in begun], timeout=60)


def render(args: argparse.Namespace, client: Client) -> None:
    folder = args.out.with_suffix(".pieces")
    folder.mkdir(parents=True, exist_ok=True)
    command = [args.covbeam, "render", str(args.scene), f"--method={args.method}"]
    command += [f"--threads={args.threads}", f"--checkpoint={args.checkpoint}"]
    if args.seed is not None:
        command.append(f"--seed={args.seed}")

    stop = Event(f"covbeam-{uuid.uuid4()}", client=client)
    futures: dict[Future, Piece] = {}
    for a, b in pairwise([*range(0, args.passes, args.chunk), args.passes]):
        piece = Piece(f"{a}..{b}", folder / f"{a}-{b}.shard")
        options = [f"--passes={piece.passes}", f"--out={piece.shard}"]
        future = client.submit(
            render_piece,
            [*command, *options],
            str(piece.shard),
            stop.name,
            # Another key each time: what was done before, the shard knows better than Dask.
            key=f"passes-{piece.passes}-{stop.name}",
            retries=args.retries,
        )
        futures[future] = piece
    shards = [piece.shard for piece in futures.values()]
    so_far = SoFar(args.covbeam, shards, args.out.with_name(f"{args.out.stem}-so-far.exr"))

    try:
        gather(futures, so_far if args.show else None)
    except KeyboardInterrupt:
        print("stopping; Ctrl-C again to leave at once", file=sys.stderr)
        halt(client, futures, stop)
        remedy = f"the passes so far are in {folder}, the same command goes on from there"
        raise Failure(f"stopped; {remedy}", INTERRUPTED) from None
    except Failure:
        halt(client, futures, stop)
        raise
    merge(args.covbeam, shards, args.out, f"--passes={args.passes}")
    print(f"wrote {args.out}")


def arguments() -> argparse.Namespace:
    def positive(text: str) -> int:
        number = int(text)
        if number < 1:
            raise argparse.ArgumentTypeError("must be at least 1")
        return number

    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("scene", type=Path, help="the scene file, SCENE.toml")
    parser.add_argument(
        "--out",
        type=Path,
        required=True,
        metavar="F.exr",
        help="the picture; pieces: F.pieces beside it",
    )
    parser.add_argument(
        "--passes", type=positive, default=64, help="passes of the picture [%(default)s]"
    )
    size = parser.add_mutually_exclusive_group()
    size.add_argument("--chunk", type=positive, default=8, help="passes of a piece [%(default)s]")
    size.add_argument("--pieces", type=positive, help="at most so many pieces instead")
    parser.add_argument("--method", default="adaptive", help="as of covbeam render [%(default)s]")
    parser.add_argument("--seed", type=int, help="as of covbeam render [the scene's]")
    parser.add_argument(
        "--checkpoint",
        type=float,
        default=60,
        metavar="S",
        help="a kill loses S seconds [%(default)s]",
    )
    parser.add_argument(
        "--covbeam", default="covbeam", help="the executable, as all workers find it [%(default)s]"
    )
    parser.add_argument(
        "--scheduler", metavar="ADDRESS", help="a running cluster, else workers on this machine"
    )
    parser.add_argument(
        "--workers", type=positive, default=2, help="so many, without --scheduler [%(default)s]"
    )
    parser.add_argument(
        "--threads", type=int, help="of one covbeam [all cores, on this machine shared evenly]"
    )
    parser.add_argument(
        "--retries", type=int, default=3, help="tries after a failed one of a piece [%(default)s]"
    )
    parser.add_argument(
        "--show", action="store_true", help="write F-so-far.exr as the pieces come in"
    )
    args = parser.parse_args()

    if args.out.suffix != ".exr":
        parser.error(f"--out {args.out}: must end in .exr")
    if not args.scene.is_file():
        parser.error(f"{args.scene}: no such scene file")
    if shutil.which(args.covbeam) is None:
        parser.error(f"{args.covbeam}: no such program; say with --covbeam where covbeam is")
    args.scene, args.out = args.scene.resolve(), args.out.resolve()
    if os.path.dirname(args.covbeam):
        args.covbeam = os.path.abspath(args.covbeam)
    if args.pieces:
        args.chunk = -(-args.passes // args.pieces)
    if args.threads is None:
        args.threads = 0 if args.scheduler else max(1, (os.cpu_count() or 1) // args.workers)
    return args


def main() -> int:
    args = arguments()
    try:
        with ExitStack() as stack:
            cluster = args.scheduler
            if cluster is None:
                cluster = LocalCluster(
                    n_workers=args.workers,
                    threads_per_worker=1,
                    dashboard_address=None,
                    # Ctrl-C goes to them, too, but it is for this process to answer.
                    preload="import signal; signal.signal(signal.SIGINT, signal.SIG_IGN)",
                )
                stack.enter_context(cluster)
            try:
                client = stack.enter_context(Client(cluster, timeout=20))
            except (OSError, ValueError) as error:
                remedy = "start one with `dask scheduler`, or leave --scheduler out"
                raise Failure(f"no scheduler at {cluster} ({error}): {remedy}") from error
            if not client.scheduler_info()["workers"]:
                print(f"no workers yet: dask worker {args.scheduler} --nthreads 1", file=sys.stderr)
            render(args, client)
    except Failure as failure:
        print(f"error: {failure}", file=sys.stderr)
        return failure.code
    except KeyboardInterrupt:
        return INTERRUPTED
    return 0


if __name__ == "__main__":
    sys.exit(main())
