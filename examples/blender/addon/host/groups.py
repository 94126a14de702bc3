# SPDX-License-Identifier: GPL-3.0-or-later
"""Light groups: one picture whose light in fog is told apart by the lamps that it comes from. numpy; no Blender."""

from dataclasses import dataclass, replace

import numpy as np

from .session import Picture, Session

#: Weights of linear Rec. 709 in luminance, float32.
LUMINANCE = np.float32([0.2126, 0.7152, 0.0722])


def split(scenes, names):
    """The same scene at instants, lit by each light group alone: list of (name, list of host.scene.Scene), the last one of name "".

    - names: of the groups that are told apart. Lights of no group or another one, and what glows, are in the last, which is left out if it
      is dark, as are groups that are dark at one of the instants: light that these have at another is in the last.
    """
    lit = [name for name in names if all(any(light.group == name for light in scene.lights) for scene in scenes)]
    parts = [(name, [replace(scene, lights=_of(scene, name), volumes=_dark(scene)) for scene in scenes]) for name in lit]
    rest = [replace(scene, lights=[light for light in scene.lights if light.group not in lit]) for scene in scenes]
    if any(scene.shines for scene in rest):
        parts.append(("", rest))
    return parts


def _of(scene, name):
    return [light for light in scene.lights if light.group == name]


def _dark(scene):
    return [volume if volume.glow is None else replace(volume, glow=None) for volume in scene.volumes]


@dataclass
class _Part:
    name: str
    session: Session
    #: The most light paths a pass, of those of all parts.
    share: float = 1.0


class GroupSession:
    """A host.session.Session for each part of a scene, all used as if they were one: a pass is one of each.

    - parts: as `split` gives them; settings: host.session.Settings, whose photons are those of all parts together.
    """

    def __init__(self, parts, settings, poll=None):
        self._parts = []
        photons = -(-settings.photons // len(parts))
        try:
            for name, (first, *instants) in parts:
                self._parts.append(_Part(name, Session(first, replace(settings, photons=photons), poll, instants)))
        except BaseException:
            self.close()
            raise
        for part in self._parts:
            part.share = part.session.photons / self.photons

    @property
    def passes(self):
        """Passes that all parts have done."""
        return min(part.session.passes for part in self._parts)

    @property
    def photons(self):
        """Light paths of a pass, of all parts together."""
        return sum(part.session.photons for part in self._parts)

    @property
    def memory(self):
        return sum(part.session.memory for part in self._parts)

    @property
    def times(self):
        times = [part.session.times for part in self._parts]
        return {name: sum(each[name] for each in times) for name in times[0]}

    @property
    def pairs(self):
        return sum(part.session.pairs for part in self._parts)

    def restart(self, photons, plain=False):
        for part in self._parts:
            part.session.restart(max(round(part.share * photons), 1), plain)

    def render_pass(self, poll=None):
        # Parts that are ahead, as one was cancelled, wait for the others.
        done = self.passes
        for part in self._parts:
            if part.session.passes == done:
                part.session.render_pass(poll)

    def picture(self, poll=None):
        """The Picture of the passes done, at least one, with the light of each group: their sum with the rest is that of all."""
        pictures = [part.session.picture(poll) for part in self._parts]
        weights = [picture.first @ LUMINANCE for picture in pictures]
        total = np.maximum(sum(weights), np.finfo(np.float32).tiny)
        groups = {part.name: picture.first for part, picture in zip(self._parts, pictures) if part.name}
        return Picture(
            in_scattered=sum(picture.in_scattered for picture in pictures),
            first=sum(picture.first for picture in pictures),
            radius=sum(weight * picture.radius for weight, picture in zip(weights, pictures)) / total,
            bandwidth=sum(weight * picture.bandwidth for weight, picture in zip(weights, pictures)) / total,
            error=np.sqrt(sum(picture.error**2 for picture in pictures)),
            groups=groups,
        )

    def close(self):
        for part in self._parts:
            part.session.close()
