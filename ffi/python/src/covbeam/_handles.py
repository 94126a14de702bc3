"""Objects of the library: who owns them, when they are freed, and which calls may go on at once."""

import ctypes
import threading
from contextlib import contextmanager

from ._library import check
from .errors import Error, Status

# Guards the counts of users below; held for a few instructions.
_lock = threading.Lock()


class Owner:
    """Owns one handle and frees it when nothing refers to it any more: objects, numpy views, other owners, running calls."""

    __slots__ = ("handle", "_free", "_borrowed", "users", "__weakref__")

    def __init__(self, make, free, *arguments, borrowed=()):
        handle = ctypes.c_void_p()
        check(make(*arguments, ctypes.addressof(handle)))
        self.handle = handle.value
        self._free = free
        self._borrowed = borrowed
        #: Calls that share the object; -1 for one that changes it.
        self.users = 0

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
    """Claims objects for a call, as the header's contract for threads wants it: many may read, or one may change.

    None among `shared` is skipped. Gives the handles in order, those of `shared` first.
    """
    for object in (*shared, changed):
        if object is not None and not isinstance(object, Object):
            raise TypeError(f"a {type(object).__name__} where an object such as a Grid is wanted")
    readers = [object and object._owned() for object in shared]
    writer = changed and changed._owned()
    with _lock:
        for owner, object in [*zip(readers, shared), (writer, changed)]:
            if owner is None:
                continue
            if owner.users < 0 or (owner is writer and (owner.users or owner in readers)):
                raise Error(
                    Status.WRONG_ORDER,
                    f"{type(object).__name__}: in use by another call; wait for that (a callback cannot use the objects of its call)",
                )
        for owner in readers:
            if owner is not None:
                owner.users += 1
        if writer is not None:
            writer.users = -1
    try:
        yield [owner and owner.handle for owner in (readers if changed is None else [*readers, writer])]
    finally:
        with _lock:
            for owner in readers:
                if owner is not None:
                    owner.users -= 1
            if writer is not None:
                writer.users = 0
