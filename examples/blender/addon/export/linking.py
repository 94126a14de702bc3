# SPDX-License-Identifier: GPL-3.0-or-later
"""Light and shadow linking: Blender's collections of receivers and blockers -> sets of objects, and what each lamp does with them."""

import numpy as np

#: As many sets as the host, and Cycles, tell apart.
_SETS = 64

#: What lamps are linked to: the names of Blender's collections of it.
RECEIVERS, BLOCKERS = "receiver_collection", "blocker_collection"


class Linking:
    """The collections of one kind that emitters name, and the sets that they divide all objects into.

    What is placed is told apart by pointers to the originals of an object and, or None, of what makes it as an instance; None stands for the world,
    which no collection has.
    """

    def __init__(self, kind):
        self._kind = kind
        # By pointer of a collection: objects that it includes, and that it excludes.
        self._members = {}

    def of(self, thing):
        """The key of an evaluated emitter's collection, or None. That of what makes it as an instance does not count."""
        # Python's settings of an instance would never be freed: those of originals.
        linked = getattr(thing.original.light_linking, self._kind)
        if linked is None:
            return None
        key = linked.as_pointer()
        if key not in self._members:
            self._members[key] = _members(linked)
        return key

    def sets(self, things):
        """Numbers of the sets that some things are in, uint32 (n,), and a function that makes of an emitter's key the bits of the sets that do not count
        for it. What counts for all is in set 0. None: there are more sets than the host tells apart."""
        keys = list(self._members)
        signatures = [tuple(self._counts(key, thing) for key in keys) for thing in things]
        numbers = {(True,) * len(keys): 0}
        found = [numbers.setdefault(signature, len(numbers)) for signature in signatures]
        if len(numbers) > _SETS:
            return None

        def left_out(key):
            if key is None:
                return 0
            return sum(1 << number for signature, number in numbers.items() if not signature[keys.index(key)])

        return np.array(found, np.uint32), left_out

    @staticmethod
    def none(things):
        """The same as of sets, as if no emitter were linked."""
        return np.zeros(len(things), np.uint32), lambda key: 0

    def _counts(self, key, thing):
        included, excluded = self._members[key]
        if thing is not None:
            one, maker = thing
            # What makes an object as an instance counts first, if it is linked at all.
            named = any(maker in members for both in self._members.values() for members in both)
            thing = maker if named else one
        return thing not in excluded and (not included or thing in included)


def _members(collection):
    """Pointers of the objects that a collection for linking includes, and that it excludes: children go with the state of the outermost one."""
    found = {"INCLUDE": set(), "EXCLUDE": set()}
    for thing, link in zip(collection.objects, collection.collection_objects):
        found[link.light_linking.link_state].add(thing.original.as_pointer())
    for child, link in zip(collection.children, collection.collection_children):
        found[link.light_linking.link_state].update(each.original.as_pointer() for each in child.all_objects)
    return found["INCLUDE"], found["EXCLUDE"]
