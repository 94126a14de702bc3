"""Python functions that the library calls: what they raise ends the call, and is raised by it."""

import ctypes
from functools import partial

import numpy as np

from . import _abi
from ._library import check
from .dtypes import CONTACT, PROBE_HIT

# ctypes cannot pass an exception on: it prints it and lets the library go on with 0. So the functions run inside a `try`.
# Handlers of signals (Ctrl-C) run when Python is entered, *before* the first line of a function, where its `try` does not
# reach. A generator that waits inside a `try` is entered there: that is why the callbacks are generators.


class Call:
    """The callbacks of one call: `poll()`, `shade(contacts, values)` and `probe(direction)`, each may be None."""

    def __init__(self, poll=None, shade=None, probe=None):
        for name, function in [("poll", poll), ("shade", shade), ("probe", probe)]:
            if function is not None and not callable(function):
                raise TypeError(f"{name}: a {type(function).__name__}; give a function")
        self._raised = None
        self.poll = self.shade = self.probe = None
        if poll is not None:
            self.poll = _abi.Poll(_started(self._polling(poll)))
        # `max` hands its arguments to the key, one after the other, and returns the one with the largest key.
        if shade is not None:
            self.shade = _abi.Shade(partial(max, key=_started(self._taking(3, partial(_Batch().run, shade)))))
        if probe is not None:
            self.probe = _abi.Probe(partial(max, key=_started(self._taking(2, partial(_cast, probe)))))

    def check(self, status):
        """Ends the call: raises what a callback has raised, else what the status means."""
        # Otherwise the generators and this would keep each other alive.
        self.poll = self.shade = self.probe = None
        if self._raised is not None:
            raise self._raised
        check(status)

    def _polling(self, poll):
        stop = 0
        try:
            while True:
                yield stop
                go_on = poll()
                if go_on is None:
                    raise TypeError("poll: returned None; return True to go on, False to stop")
                stop = 0 if go_on else 1
        except GeneratorExit:
            return
        except BaseException as raised:
            self._raised = raised
        while True:
            yield 1

    def _taking(self, count, run):
        """Runs a function of so many arguments, all addresses or sizes, that come one by one after the user pointer."""
        numbers, key = [], None
        try:
            while True:
                numbers.append((yield key))
                # The user pointer, 0, has the largest key: "go on".
                key = 1 if len(numbers) == 1 else 0
                if len(numbers) == 1 + count:
                    run(*numbers[1:])
                    numbers.clear()
        except GeneratorExit:
            return
        except BaseException as raised:
            self._raised = raised
        key = 1
        while True:
            # The last argument, an address, has the largest: "give up".
            key += 1
            yield key


def _started(generator):
    next(generator)
    return generator.send


def _cast(probe, direction, hit):
    """Lets a function cast one probe ray; copies both ways, as `_Batch` does."""
    towards = np.empty(3, np.float32)
    ctypes.memmove(towards.ctypes.data, direction, towards.nbytes)
    found = probe(towards)
    if found is None:
        return
    try:
        distance, normal, offset = found
        record = np.array((distance, tuple(normal), offset), PROBE_HIT)
    except (TypeError, ValueError) as error:
        raise TypeError(f"probe: returned {found!r}; return (distance, normal, offset), or None where nothing is met") from error
    ctypes.memmove(hit, record.ctypes.data, record.nbytes)


class _Batch:
    """Contacts and values in memory of our own. An array on the library's memory would dangle if the script kept it; moving
    256 contacts takes a microsecond."""

    def __init__(self):
        self._reserve(256)

    def _reserve(self, count):
        self.contacts = np.zeros(count, CONTACT)
        self.values = np.zeros((count, 3), np.float32)
        self.first, self.result = self.contacts.ctypes.data, self.values.ctypes.data
        self.contacts.flags.writeable = False

    def run(self, shade, first, count, result):
        if count > len(self.contacts):
            self._reserve(count)
        ctypes.memmove(self.first, first, count * CONTACT.itemsize)
        values = self.values[:count]
        values.fill(0)
        if shade(self.contacts[:count], values) is not None:
            raise TypeError("shade: returned something; write into values, return nothing, raise to give up")
        ctypes.memmove(result, self.result, values.nbytes)
