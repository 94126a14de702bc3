"""numpy arrays as arguments of the library: by address and stride, never copied.

What an array cannot be without a copy (another dtype, numbers that are not side by side, backward strides) is refused with
the name of the argument and the call that makes a copy of the right kind.
"""

import ctypes
from numbers import Real
from typing import NamedTuple

import numpy as np

from ._library import check


class Kind(NamedTuple):
    """What one element of an argument is."""

    dtype: np.dtype
    #: Numbers in a row that make an element; 0 for an element that is one number or one struct.
    width: int = 0


FLOAT = Kind(np.dtype(np.float32))
PAIR = Kind(np.dtype(np.float32), 2)
VECTOR = Kind(np.dtype(np.float32), 3)
HESSIAN = Kind(np.dtype(np.float32), 6)
FLAG = Kind(np.dtype(np.bool_))
WORD = Kind(np.dtype(np.uint32))
PIXEL = Kind(np.dtype(np.uint32), 2)

#: Stands for the number of elements among the arguments of `elementwise`.
COUNT = object()


class Argument:
    """An array as the library takes it. `count` is None for one element, which serves all the others."""

    __slots__ = ("name", "kind", "written", "memory", "address", "stride", "count")

    def __init__(self, name, kind, written):
        self.name, self.kind, self.written = name, kind, written
        #: What must live as long as the address is used.
        self.memory = None
        self.address, self.stride, self.count = None, 0, None

    def view(self, array):
        """Points at the elements of an array."""
        name, kind = self.name, self.kind
        if not isinstance(array, np.ndarray):
            raise TypeError(f"{name}: a {type(array).__name__}; give a numpy array of {_wanted(kind)}")
        _check_dtype(name, array, kind.dtype)
        axes = array.ndim - (kind.width > 0)
        if axes not in (0, 1) or (kind.width and array.shape[-1] != kind.width):
            one, many = (f"({kind.width},)", f"(n, {kind.width})") if kind.width else ("()", "(n,)")
            raise ValueError(f"{name}: shape {array.shape} is neither {one} nor {many}; reshape it")
        if self.written and not array.flags.writeable:
            raise ValueError(f"{name}: the array is read-only, but the call writes to it; give a writeable one")
        self.memory = array
        self.address = array.ctypes.data
        if axes == 1:
            self.count = len(array)
            # numpy may leave any stride where there is nothing to stride over.
            self.stride = array.strides[0] if self.count > 1 else array.itemsize * max(kind.width, 1)
        if array.size == 0:
            return self
        if kind.width and array.strides[-1] != array.itemsize:
            raise ValueError(
                f"{name}: the {kind.width} numbers of an element are {array.strides[-1]} bytes apart, not side by side; "
                "use np.ascontiguousarray(...)"
            )
        if self.stride < 0:
            raise ValueError(f"{name}: runs backwards (stride {self.stride}); use np.ascontiguousarray(...)")
        if (self.address | self.stride) % kind.dtype.alignment:
            raise ValueError(
                f"{name}: elements are not aligned to {kind.dtype.alignment} bytes (address {self.address:#x}, "
                f"stride {self.stride}); use a dtype with align=True, or .copy()"
            )
        return self


class Made(Argument):
    """An output that the call makes, unless the caller has given an array for it."""

    __slots__ = ("fresh",)

    def make(self, count):
        shape = () if count is None else (count,)
        self.view(np.zeros(shape + (self.kind.width,) if self.kind.width else shape, self.kind.dtype))
        self.fresh = True

    def result(self):
        """The array; a number if the call made only one. A struct stays an array, so that it can be changed in place."""
        number = self.fresh and self.memory.ndim == 0 and self.kind.dtype.names is None
        return self.memory[()] if number else self.memory


def _wanted(kind):
    if kind.dtype.names is not None:
        return f"records with the fields {', '.join(kind.dtype.names)}"
    return f"{kind.width} x {kind.dtype.name}" if kind.width else kind.dtype.name


def _check_dtype(name, array, dtype):
    if array.dtype == dtype:
        return
    if array.dtype.newbyteorder("=") == dtype:
        remedy = "its bytes are in the other order; use .astype(array.dtype.newbyteorder('='))"
    elif dtype.names is None:
        remedy = f"use .astype(np.{dtype.name.removesuffix('_')}{'_' if dtype == np.bool_ else ''})"
    else:
        remedy = f"make it with the dtype of covbeam.dtypes that has the fields {', '.join(dtype.names)}"
    raise TypeError(f"{name}: dtype {array.dtype} is not {dtype if dtype.names is None else 'as in C'}; {remedy}")


def given(name, value, kind):
    """An input: an array, a number, or a tuple for one vector."""
    argument = Argument(name, kind, written=False)
    if isinstance(value, np.ndarray):
        return argument.view(value)
    if kind.dtype != np.float32:
        raise TypeError(f"{name}: a {type(value).__name__}; give a numpy array of {_wanted(kind)}")
    if kind.width == 0 and isinstance(value, Real) and not isinstance(value, (bool, np.bool_)):
        argument.memory = ctypes.c_float(value)
    elif kind.width and isinstance(value, (tuple, list)):
        if len(value) != kind.width or not all(isinstance(number, Real) for number in value):
            raise ValueError(f"{name}: {value!r} is not {kind.width} numbers")
        argument.memory = (ctypes.c_float * kind.width)(*value)
    else:
        what = f"a tuple of {kind.width} numbers" if kind.width else "a number"
        raise TypeError(f"{name}: a {type(value).__name__}; give {what}, or a numpy array of {_wanted(kind)}")
    argument.address = ctypes.addressof(argument.memory)
    return argument


def optional(name, value, kind):
    """An input that may be None: NULL."""
    return Argument(name, kind, written=False) if value is None else given(name, value, kind)


def changed(name, array, kind):
    """An array that is read and written."""
    return Argument(name, kind, written=True).view(array)


def struct(name, value, kind):
    """The address of the C struct of an object such as a Medium."""
    if not isinstance(value, kind):
        raise TypeError(f"{name}: a {type(value).__name__}; give a {kind.__name__}")
    return ctypes.addressof(value._struct)


def word(name, number):
    """An uint32 that is no array."""
    # ctypes would take it modulo 2^32.
    if not 0 <= number < 1 << 32:
        raise ValueError(f"{name}: {number} is not in 0 to 2^32 - 1")
    return int(number)


def single(name, array, kind, written=False):
    """One struct: a view of shape () or (1,)."""
    argument = Argument(name, kind, written).view(array)
    if argument.count not in (None, 1):
        raise ValueError(f"{name}: {argument.count} elements, but one is wanted; give {name}[i, ...], a view of element i")
    return argument


def made(name, out, kind):
    """An output: a new array, unless the caller gives one."""
    argument = Made(name, kind, written=True)
    argument.fresh = False
    return argument if out is None else argument.view(out)


def two_outs(out):
    """`out` of a function with two results."""
    if out is None:
        return None, None
    if not isinstance(out, tuple) or len(out) != 2:
        raise TypeError("out: the call has two results; give a tuple of two arrays, None for one that is to be made")
    return out


def elementwise(function, *arguments, ended=check):
    """Calls a function on arrays of one length; single elements serve all. Returns what was `made`, in order.

    - ended: gets the status.
    """
    count = named = None
    for argument in arguments:
        if not isinstance(argument, Argument) or argument.count is None:
            continue
        if count is None:
            count, named = argument.count, argument.name
        elif argument.count != count:
            raise ValueError(
                f"{argument.name}: {argument.count} elements, but {named} has {count}; "
                "give as many, or a single one to serve all"
            )
    words, results = [], []
    for argument in arguments:
        if argument is COUNT:
            words.append(1 if count is None else count)
        elif isinstance(argument, Argument):
            if isinstance(argument, Made):
                results.append(argument)
                if argument.memory is None:
                    argument.make(count)
            if argument.written and argument.count is None and count is not None:
                raise ValueError(f"{argument.name}: one element, but {named} has {count}; give as many")
            words += (argument.address, argument.stride)
        else:
            words.append(argument)
    ended(function(*words))
    results = tuple(argument.result() for argument in results)
    return results[0] if len(results) == 1 else results or None


def voxels(name, array, dtype, cells, *, written=False, packed=False):
    """One element a voxel, of shape (nz, ny, nx) or (n,): x runs fastest. Returns an Argument of count n."""
    nx, ny, nz = cells
    kind = Kind(dtype)
    if not isinstance(array, np.ndarray) or array.ndim != 3:
        argument = Argument(name, kind, written).view(array)
    else:
        if array.shape != (nz, ny, nx):
            raise ValueError(f"{name}: shape {array.shape} is not (nz, ny, nx) = {(nz, ny, nx)}; voxels lie x first")
        if array.size and not _one_stride(array):
            raise ValueError(f"{name}: the voxels are not evenly spaced in memory; use np.ascontiguousarray(...)")
        # A view: the strides follow from each other.
        argument = Argument(name, kind, written).view(array.reshape(-1))
    if argument.count != nx * ny * nz:
        raise ValueError(f"{name}: {argument.count} elements, but the layout has {nx * ny * nz} voxels")
    if packed and argument.count > 1 and argument.stride != dtype.itemsize:
        raise ValueError(f"{name}: elements are {argument.stride} bytes apart, not packed; use np.ascontiguousarray(...)")
    return argument


def _one_stride(array):
    """Whether going through the array in C order is going on by one stride."""
    expected = None
    for length, stride in zip(reversed(array.shape), reversed(array.strides)):
        if length == 1:
            continue
        if expected is not None and stride != expected:
            return False
        expected = stride * length
    return True


def packed(name, array, dtype):
    """An input whose elements lie side by side: (address, count)."""
    argument = Argument(name, Kind(dtype), written=False).view(array)
    if argument.count is None or (argument.count > 1 and argument.stride != dtype.itemsize):
        raise ValueError(f"{name}: not a packed array of shape (n,); use np.ascontiguousarray(...).reshape(-1)")
    return argument
