"""numpy arrays as the library takes them: packed, of one dtype. Inputs of another layout are copied."""

import numpy as np


def packed(name, value, dtype, shape):
    """`value` as a packed array; None in `shape` stands for any number. Integers that do not fit are refused."""
    array = np.asarray(value)
    if dtype.names is not None and array.dtype != dtype:
        raise TypeError(f"{name}: dtype {array.dtype}; give records with the fields {', '.join(dtype.names)}")
    if dtype.kind == "i":
        if array.dtype.kind not in "iu":
            raise TypeError(f"{name}: dtype {array.dtype}; give integers, such as .astype(np.int32)")
        limits = np.iinfo(dtype)
        if array.dtype != dtype and array.size and (array.min() < limits.min or array.max() > limits.max):
            raise ValueError(f"{name}: {array.min()} to {array.max()}; give numbers that fit {dtype}")
    if array.ndim != len(shape) or any(want not in (None, got) for want, got in zip(shape, array.shape)):
        wanted = ", ".join("n" if want is None else str(want) for want in shape)
        raise ValueError(f"{name}: shape {array.shape}; give ({wanted}{',' if len(shape) == 1 else ''})")
    return np.ascontiguousarray(array, dtype=dtype)


def result(name, out, dtype, shape):
    """A new array, or `out` if it can be written as it is."""
    if out is None:
        return np.empty(shape, dtype)
    if not isinstance(out, np.ndarray) or out.dtype != dtype:
        raise TypeError(f"{name}: give a numpy array of {dtype if dtype.names is None else ', '.join(dtype.names)}")
    if out.shape != shape or not out.flags.c_contiguous or not out.flags.writeable or not out.flags.aligned:
        raise ValueError(f"{name}: shape {out.shape}; give a packed, aligned, writeable array of shape {shape}")
    return out
