"""Arrays of samples as the extension takes them: float64, one after the other; or refused, with what was found."""

from __future__ import annotations

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
    if isinstance(values, (str, bytes, dict, set)):
        raise UsageError(f"{what}: expected an array of samples, found {_called(values)}")
    try:
        array = np.asarray(values)
    except (ValueError, TypeError) as error:
        raise UsageError(f"{what}: expected an array of samples, found {_called(values)} ({error})") from error
    _require_numbers(array, what)
    if array.ndim == 0:
        raise UsageError(f"{what}: expected an array of samples, found a single number")
    if array.ndim > 1:
        raise UsageError(
            f"{what}: expected one row of samples, found an array of shape {array.shape}; "
            "give each channel by its name: {'acc': x[:, 0], 'force': x[:, 1]}"
        )
    if array.size == 0:
        raise DataError(f"{what}: expected samples, found none")
    if isinstance(values, np.ma.MaskedArray) and np.ma.is_masked(values):
        masked = int(np.ma.getmaskarray(values).sum())
        raise DataError(f"{what}: expected samples without gaps, found {masked} masked; cut that part")
    return np.require(array, np.float64, ["C", "A"])


def _require_numbers(array: npt.NDArray[Any], what: str) -> None:
    kind, size = array.dtype.kind, array.dtype.itemsize
    if kind not in "fiu" or size > 8:
        raise UsageError(
            f"{what}: expected real numbers (float32, float64 or integers), found {array.dtype}; convert them with astype(float)"
        )
    if kind in "iu" and size == 8 and array.size and (int(array.max()) > LARGEST_INTEGER or int(array.min()) < -LARGEST_INTEGER):
        raise UsageError(
            f"{what}: expected integers within ±2**53, which float64 holds exactly, found {array.max()} and {array.min()}; "
            "subtract an offset first"
        )


def _called(values: Any) -> str:
    return f"a {type(values).__name__}"
