"""Arrays of samples as the extension takes them: float64, one after the other; or refused, with what was found."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
import numpy.typing as npt

from ._errors import DataError, UsageError

#: Integers beyond are not exact as float64.
LARGEST_INTEGER = 2**53


def samples(values: Any, what: str) -> npt.NDArray[np.float64]:
    """`values` as float64 without gaps; the same array where it is that already.

    Parameters
    ----------
    values : array_like, shape (n,)
        Real numbers, in whatever layout and byte order.
    what : str
        What messages call it.

    Raises
    ------
    UsageError
        For anything but one row of real numbers that float64 holds.
    DataError
        Without samples, or with masked ones.
    """
    refuse_files(values, what, "an array of samples")
    if isinstance(values, (str, dict, set)):
        raise UsageError(f"{what}: expected an array of samples, found {_called(values)}")
    try:
        array = np.asarray(values)
    except (ValueError, TypeError) as error:
        raise UsageError(f"{what}: expected an array of samples, found {_called(values)} ({error})") from error
    _require_numbers(array, what)
    if array.ndim == 0:
        raise UsageError(f"{what}: expected an array of samples, found a single number")
    if array.ndim > 1:
        raise UsageError(f"{what}: expected one row of samples, found an array of shape {array.shape}{_rows_of(array.shape)}")
    if array.size == 0:
        raise DataError(f"{what}: expected samples, found none")
    if isinstance(values, np.ma.MaskedArray) and np.ma.is_masked(values):
        masked = int(np.ma.getmaskarray(values).sum())
        raise DataError(f"{what}: expected samples without gaps, found {masked} masked; cut that part")
    return np.require(array, np.float64, ["C", "A"])


def refuse_files(values: Any, what: str, expected: str) -> None:
    """Refuses what holds a file and is neither its path nor an array, as NumPy would say little of it."""
    found = advice = ""
    if hasattr(values, "read") and hasattr(values, "seek"):
        found, advice = _called(values), "give the path of the file; what is only in memory is written to one first"
    elif isinstance(values, (bytes, bytearray)):
        found, advice = _called(values), "give a path as str: os.fsdecode(path)"
    elif isinstance(values, (list, tuple)) and any(isinstance(one, (str, bytes, os.PathLike)) for one in values):
        found, advice = f"{_called(values)} of paths", "give one path; for several, call once for each"
    elif isinstance(values, tuple) and len(values) == 2 and np.ndim(values[0]) == 0 and isinstance(values[1], np.ndarray):
        found, advice = "a tuple of a rate and an array", "give the array, and its rate as rate="
    if found:
        raise UsageError(f"{what}: expected {expected}, found {found}; {advice}")


def plain(value: Any) -> Any:
    """One value of NumPy as one of Python, such as an array without dimensions; anything else as it is."""
    return value.item() if isinstance(value, np.generic) or isinstance(value, np.ndarray) and value.ndim == 0 else value


def path_of(value: Any, what: str) -> str:
    """`value` as a path, or refused."""
    try:
        path = os.fspath(value)
    except TypeError:
        refuse_files(value, what, "a path")
        advice = f"; write it to a file, {what}.to_csv('{what}.csv', index=False), and give that path" if hasattr(value, "to_csv") else ""
        raise UsageError(f"{what}: expected a path, found {_called(value)}{advice}") from None
    if not isinstance(path, str):
        refuse_files(path, what, "a path")
    return str(path)


def _rows_of(shape: tuple[int, ...]) -> str:
    """How the rows of samples in an array of two dimensions are given."""
    if len(shape) != 2:
        return ""
    is_rows = shape[0] < shape[1]
    if 1 in shape:
        return f"; give {'x[0]' if is_rows else 'x[:, 0]'}"
    first, second = ("x[0]", "x[1]") if is_rows else ("x[:, 0]", "x[:, 1]")
    return f"; give each channel by its name: {{'acc': {first}, 'force': {second}}}"


def _require_numbers(array: npt.NDArray[Any], what: str) -> None:
    kind, size = array.dtype.kind, array.dtype.itemsize
    if kind not in "fiu" or size > 8:
        advice = {"c": "give the real part, the imaginary part or np.abs()", "M": "give rate= instead of times", "m": "give rate= instead of times"}
        todo = advice.get(kind, "convert them with astype(float)")
        raise UsageError(f"{what}: expected real numbers (floating point or integers), found {array.dtype}; {todo}")
    if kind in "iu" and size == 8 and array.size and (int(array.max()) > LARGEST_INTEGER or int(array.min()) < -LARGEST_INTEGER):
        raise UsageError(
            f"{what}: expected integers within ±2**53, which float64 holds exactly, found {array.max()} and {array.min()}; "
            "subtract an offset first"
        )


def _called(values: Any) -> str:
    return f"a {type(values).__name__}"
