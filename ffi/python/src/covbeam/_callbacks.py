"""Python functions that the library calls: what they raise ends the call, and is raised by it."""

import ctypes
from functools import partial

import numpy as np

from . import _abi
from ._library import check
from .dtypes import CONTACT

# ctypes cannot pass an exception on: it prints it and lets the library go on with 0. So the functions run inside a `try`.
# Handlers of signals (Ctrl-C) run when Python is entered, *before* the first line of a function, where its `try` does not
# reach. A generator that waits inside a `try` is entered there: that is why the callbacks are generators.


class Call:
    """The callbacks of one call: `poll()` and `shade(contacts, values)`, either None."""

    def __init__(self, poll=None, shade=None):
        for name, function in [("poll", poll), ("shade", shade)]:
            if function is not None and not callable(function):
                raise TypeError(f"{name}: a {type(function).__name__}; give a function")
        self._raised = None
        self.poll = self.shade = None
        if poll is not None:
            self.poll = _abi.Poll(_started(self._polling(poll)))
        if shade is not None:
            # `max` hands its four arguments to the key, one after the other, and returns the one with the largest key.
            self.shade = _abi.Shade(partial(max, key=_started(self._shading(shade))))

    def check(self, status):
        """Ends the call: raises what a callback has raised, else what the status means."""
        # Otherwise the generators and this would keep each other alive.
        self.poll = self.shade = None
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

    def _shading(self, shade):
        batch, numbers, key = _Batch(), [], None
        try:
            while True:
                numbers.append((yield key))
                # The user pointer, 0, has the largest key: "go on".
                key = 1 if len(numbers) == 1 else 0
                if len(numbers) == 4:
                    batch.run(shade, *numbers[1:])
                    numbers.clear()
        except GeneratorExit:
            return
        except BaseException as raised:
            self._raised = raised
        key = 1
        while True:
            # The last argument, the address of the values, has the largest: "give up".
            key += 1
            yield key


def _started(generator):
    next(generator)
    return generator.send


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
