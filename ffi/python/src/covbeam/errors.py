"""What a call of the library raises when it fails."""

from enum import IntEnum


class Status(IntEnum):
    """How a call ended: covbeam_status of the header."""

    OK = 0
    NULL_POINTER = 1
    MISALIGNED = 2
    INVALID_VALUE = 3
    INVALID_ARRAY = 4
    SHORT_BUFFER = 5
    INVALID_HANDLE = 6
    WRONG_ORDER = 7
    MISMATCH = 8
    BAD_DATA = 9
    OUT_OF_MEMORY = 10
    CANCELLED = 11
    CALLBACK_FAILED = 12
    POISONED = 13
    PANICKED = 14
    BUSY = 15


class Error(Exception):
    """A call failed and has changed nothing.

    - status: a Status.
    - message: which argument it was, and what to do.
    """

    def __init__(self, status: Status, message: str):
        super().__init__(f"{message} ({status.name})")
        self.status = status
        self.message = message

    def __reduce__(self):
        return type(self), (self.status, self.message)


class InvalidValue(Error, ValueError):
    """A number, or what it stands for, is wrong."""


class OutOfMemory(Error, MemoryError):
    """There is not enough memory."""


class Cancelled(Error):
    """The poll of the call asked to stop."""
