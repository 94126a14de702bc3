# SPDX-License-Identifier: GPL-3.0-or-later
"""A walk through all types of shader nodes, and all settings of objects, lamps, cameras, materials, worlds, scenes and view layers: each alone
in a foggy scene, by Cycles and by Add Beams.

    python walk.py FOLDER [--only TEXT ...] [--part K/N] [--all-settings] [--table README.md]

Prints a line for each: `same`, where all that is seen agrees; `asks`, where Add Beams names what is missing and keeps Cycles' fog; `refused`, where it
renders nothing and says why; `fails`, where Blender itself makes no picture; `differs`, which must not be. What the process itself has `died` of is
left out in the next run: try it without the extension. The answers of all runs so far are kept in FOLDER, by version of Blender; --table makes the
README's table of those of all versions. Some 1,300 scenes, a second or two each; --part runs a share of them. Exits with 1 if anything differs.
"""

import argparse
import json
import os
import sys
import tempfile
import traceback
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import bpy
from walk_stage import AGAIN, LOOK, Answer, by_cycles, differs
from walk_subjects import nodes, settings
from walk_table import table

import addon

VERSION = ".".join(map(str, bpy.app.version[:2]))


def judged(subject, folder):
    """What has come of a Subject: its kind and the words for it; None if there is no such thing."""
    found = None
    for effort in (LOOK, AGAIN):
        scene = subject.build()
        if scene is None:
            return None
        found = _looked_at(scene, folder, effort)
        if found[0] != "differs":
            break
    return found


def _looked_at(scene, folder, effort):
    try:
        cycles, error = by_cycles(scene, folder, effort)
    except RuntimeError as reason:
        return "fails", f"in Blender itself: {reason}"
    answer = Answer(scene, folder, effort)
    if answer.refused:
        return "refused", answer.refused
    if answer.asks:
        return "asks", "; ".join(answer.asks)
    if cycles is None or not cycles.any():
        # Nothing of fog is there to be replaced.
        dark = answer.picture is None or not answer.picture.any()
        return ("same", "") if dark else ("differs", "light where Cycles has none")
    if answer.picture is None:
        return ("asks", " ".join(answer.advice)) if answer.advice else ("differs", "no picture")
    words = differs(cycles, error, answer.picture, answer.error)
    return ("differs", f"{words}; entries: {'; '.join(answer.entries)}") if words else ("same", "; ".join(answer.entries))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("folder", type=Path, help="where answers are kept")
    parser.add_argument("--only", nargs="+", default=[], metavar="TEXT", help="those whose group and name have one of these in them")
    parser.add_argument("--part", default="1/1", metavar="K/N", help="every N-th, from the K-th on [default: all]")
    parser.add_argument("--all-settings", action="store_true", help="nodes with each value of their enumerations, too")
    parser.add_argument("--again", action="store_true", help="those that have an answer already, too")
    parser.add_argument("--table", type=Path, metavar="README.md", help="writes the table of the answers into it, and renders nothing")
    options = parser.parse_args()
    if options.table is not None:
        begin, end = "<!-- walk.py writes this table. -->\n", "<!-- the end of the table -->"
        before, rest = options.table.read_text(encoding="utf-8").split(begin)
        after = rest[rest.index(end) :]
        options.table.write_text(before + begin + table(options.folder) + after, encoding="utf-8")
        return 0
    options.folder.mkdir(parents=True, exist_ok=True)
    addon.register()
    kept = options.folder / f"walk-{VERSION}.json"
    answers = json.loads(kept.read_text()) if kept.is_file() else {}
    part, parts = map(int, options.part.split("/"))
    subjects = [*nodes(options.all_settings), *settings()]
    chosen = [s for s in subjects if not options.only or any(text.lower() in f"{s.group}: {s.name}".lower() for text in options.only)]
    wrong = 0
    with tempfile.TemporaryDirectory() as folder:
        for subject in chosen[part - 1 :: parts]:
            key = f"{subject.group}: {subject.name}"
            if key in answers and not options.again:
                continue
            # What the process dies of, the next run does not look at again.
            answers[key] = [subject.group, subject.name, "died", ""]
            kept.write_text(json.dumps(answers, indent=0))
            try:
                found = judged(subject, folder)
            except Exception as reason:
                # A setting that Blender does not take, or a fault of the extension: it is looked at.
                traceback.print_exc()
                found = "differs", f"{type(reason).__name__}: {reason}"
            if found is None:
                del answers[key]
                continue
            wrong += found[0] == "differs"
            print(f"walk {VERSION}: {found[0]}: {key}: {found[1]}", flush=True)
            answers[key] = [subject.group, subject.name, *found]
            kept.write_text(json.dumps(answers, indent=0))
    died = [key for key, (*_, kind, _) in answers.items() if kind == "died"]
    print(f"walk {VERSION}: {len(answers)} answers, {wrong} of this run differ; it has died of: {'; '.join(died) or 'nothing'}", flush=True)
    return wrong > 0


if __name__ == "__main__":
    status = main()
    sys.stdout.flush()
    # The bpy package 4.2 crashes when Python ends.
    os._exit(status)
