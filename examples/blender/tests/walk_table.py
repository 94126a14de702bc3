# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of the README of what a walk has found. For walk.py."""

import json


def table(folder):
    """Markdown, of the answers of all versions of Blender that are kept in a folder."""
    # By group and name: what has come of it, by version.
    found = {}
    for path in sorted(folder.glob("walk-*.json")):
        version = path.stem.removeprefix("walk-")
        for group, name, kind, words in json.loads(path.read_text()).values():
            # Where Blender itself has no picture nothing is said.
            if kind not in ("died", "fails"):
                found.setdefault(group, {}).setdefault(name, {})[version] = kind, words
    lines = ["| what | same picture | named, and Cycles' fog kept |", "| --- | --- | --- |"]
    for group, names in found.items():
        same = [name for name, answers in sorted(names.items()) if all(kind == "same" for kind, _ in answers.values())]
        others = [_shown(name, answers) for name, answers in sorted(names.items()) if name not in same]
        lines.append(f"| {group} | {', '.join(same)} | {', '.join(others)} |")
    return "\n".join(lines) + "\n"


def _shown(name, answers):
    """A name, with the versions in which its answer is another one than in all of them."""
    kinds = {kind for kind, _ in answers.values()}
    if "differs" in kinds:
        raise ValueError(f"{name} differs: {answers}")
    if len(kinds) == 1:
        return name
    return f"{name} ({', '.join(version for version, (kind, _) in answers.items() if kind != 'same')})"
