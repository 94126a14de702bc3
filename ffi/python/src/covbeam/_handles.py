"""Objects of the library: who owns them, and when they are freed."""

import ctypes
from contextlib import contextmanager

from ._library import check
from .errors import Error, Status


class Owner:
    """Owns one handle and frees it when nothing refers to it any more: objects, numpy views, other owners, running calls."""

    __slots__ = ("handle", "_free", "_borrowed", "__weakref__")

    def __init__(self, make, free, *arguments, borrowed=(), ended=check):
        handle = ctypes.c_void_p()
        ended(make(*arguments, ctypes.addressof(handle)))
        self.handle = handle.value
        self._free = free
        self._borrowed = borrowed

    def __del__(self):
        # Not there if the library refused to make the object.
        if getattr(self, "handle", None) is not None:
            self._free(self.handle)

    def __reduce__(self):
        raise TypeError("objects of the library cannot be copied or pickled; Grid.save() makes bytes")


class Object:
    """What all objects of the library can do. Closed by close() or at the end of a `with`, else with the last reference.

    Closing gives up this reference: the memory goes once views, media and calls that use it are gone too.
    """

    _owner: Owner | None

    def close(self):
        """Gives the object up; nothing happens the second time."""
        self._owner = None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def _owned(self) -> Owner:
        if self._owner is None:
            name = type(self).__name__
            raise Error(Status.INVALID_HANDLE, f"{name}: used after close(); make a new {name}")
        return self._owner


@contextmanager
def using(*shared, changed=None):
    """The handles of a call's objects, those of `shared` first, which live until it is over. None among `shared` is skipped."""
    objects = shared if changed is None else (*shared, changed)
    for object in objects:
        if object is not None and not isinstance(object, Object):
            raise TypeError(f"a {type(object).__name__} where an object such as a Grid is wanted")
    owners = [object and object._owned() for object in objects]
    yield [owner and owner.handle for owner in owners]
