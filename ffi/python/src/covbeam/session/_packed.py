"""Numbers and numpy arrays as the library takes them: packed, of one dtype. Inputs of another layout are copied."""

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
    # What is too large becomes infinite, which the library refuses by name.
    with np.errstate(over="ignore", invalid="ignore"):
        return np.ascontiguousarray(array, dtype=dtype)


def number(name, value, bounds=None):
    """One number, within bounds if there are any."""
    array = np.asarray(value, np.float64)
    if array.ndim != 0:
        raise ValueError(f"{name}: shape {array.shape}; give one number")
    if bounds is not None and not bounds[0] <= array <= bounds[1]:
        raise ValueError(f"{name}: {value}; give a number from {bounds[0]} to {bounds[1]}")
    return array.item()


def whole(name, value, least=0, most=2**32 - 1):
    """A whole number within bounds."""
    number = int(value)
    if number != value or not least <= number <= most:
        raise ValueError(f"{name}: {value}; give a whole number from {least} to {most}")
    return number
