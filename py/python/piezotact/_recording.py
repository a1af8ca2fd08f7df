"""Recordings: channels with their rates, units and condition."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Union

import numpy as np
import numpy.typing as npt

from . import _arrays
from ._errors import Error, UsageError, Warning
from ._piezotact import RecordingData

#: A file, or a result that wrote one.
Path = Union[str, "os.PathLike[str]"]
#: A value with its unit, a name; a number; the two ends of a band.
Text = Union[str, float, "tuple[float, float]"]
#: One row of samples, or channels by their names.
Arrays = Union[npt.ArrayLike, Mapping[str, npt.ArrayLike]]
#: The unit of all channels, or of each by its name.
Unit = Union[str, Mapping[str, Union[str, None]], None]

#: What the channel of one array is called.
ONLY_CHANNEL = "signal"


#: A file, a recording, one array of samples, or arrays by the names of their channels.
Data = Union[Path, "Recording", Arrays]


class Recording(Mapping[str, "npt.NDArray[np.float64]"]):
    """Channels that were acquired together, in SI: a mapping from their names to their samples.

    `read` makes one of a file, `recording` one of arrays. The samples are views that cannot be written; nothing is copied.
    """

    def __init__(self, data: RecordingData, name: str) -> None:
        self._data = data
        self._name = name
        self._channels = {channel[0]: (number, channel) for number, channel in enumerate(data.channels)}

    @property
    def name(self) -> str:
        """The file it was read from, or what it was called."""
        return self._name

    @property
    def rate_hz(self) -> float:
        """The sampling rate of the first channel, and of all where they share a clock (`rates_hz`)."""
        return self._data.rate_hz

    @property
    def rates_hz(self) -> dict[str, float]:
        """The sampling rate of each channel."""
        return {name: channel[2] for name, (_, channel) in self._channels.items()}

    @property
    def starts_s(self) -> dict[str, float]:
        """When each channel begins, on the common clock."""
        return {name: channel[3] for name, (_, channel) in self._channels.items()}

    @property
    def duration_s(self) -> float:
        """The time to the end of the channel that ends last."""
        return self._data.duration_s

    @property
    def units(self) -> dict[str, str]:
        """The SI unit of each channel: ``"m/s²"``, ``"N"``; ``"FS"`` relative to full scale; ``"no unit"``."""
        return {name: channel[1] for name, (_, channel) in self._channels.items()}

    @property
    def condition(self) -> dict[str, Any]:
        """What is known of the sample, the participant, load, speed and touch."""
        found: dict[str, Any] = json.loads(self._data.condition)
        return found

    @property
    def kind(self) -> str:
        """The kind of file."""
        return self._data.kind

    @property
    def warnings(self) -> list[Warning]:
        """What a person should know before relying on it."""
        return [Warning(text, code) for code, text in self._data.warnings]

    def __getitem__(self, name: str) -> npt.NDArray[np.float64]:
        try:
            number, _ = self._channels[name]
        except KeyError:
            raise KeyError(f"{name!r}: expected one of the channels {', '.join(self._channels)}") from None
        return self._data.samples(number)

    def __iter__(self) -> Iterator[str]:
        return iter(self._channels)

    def __len__(self) -> int:
        return len(self._channels)

    def __repr__(self) -> str:
        channels = ", ".join(f"{name} [{channel[1]}]" for name, (_, channel) in self._channels.items())
        return f"<Recording {self._name}: {channels}; {self.rate_hz:g} Hz, {self.duration_s:.3f} s>"

    def __copy__(self) -> Recording:
        return self

    def __deepcopy__(self, memo: Any) -> Recording:
        # Nothing of it can be changed.
        return self

    def __reduce__(self) -> Any:
        raise TypeError("a Recording stays in its process: give the path of its file, or its arrays, to the other one")


def read(
    path: str | os.PathLike[str],
    *,
    scale: str | Sequence[str] = (),
    rate: float | None = None,
    part: int | None = None,
) -> Recording:
    """Reads a recording from a file of any format that the command reads: WAV, CSV, Parquet, MAT, TDMS, UFF, NumPy and others.

    Parameters
    ----------
    path : path
        The file.
    scale : str or list of str
        What 1 in the file means: ``"200 m/s2"``, or ``"fz=2 N"`` of one channel.
    rate : float
        The sampling rate of a table without a time column, in Hz.
    part : int
        The part of a recording with gaps, from 1 on; the first unless stated.

    Returns
    -------
    Recording

    Raises
    ------
    Error
        What was expected of the file and what was found.

    Warns
    -----
    Warning
        What is found in the samples or was guessed.

    Notes
    -----
    Source: ``piezotact info``.
    """
    name = _arrays.path_of(path, "path")
    scales = [scale] if isinstance(scale, str) else [str(one) for one in scale]
    found = Recording(RecordingData.read(name, scales, rate, part), name)
    warn(found.warnings, 3)
    return found


def recording(
    channels: Arrays,
    *,
    rate: float,
    unit: Unit = None,
    name: str = "array",
    condition: Mapping[str, Any] | None = None,
) -> Recording:
    """Makes a recording of arrays.

    Parameters
    ----------
    channels : array_like of shape (n,), dict of them, or DataFrame
        The samples of one channel, which is called ``signal``, or of channels by their names. They are copied once. Integers are
        taken as values in the unit.
    rate : float
        The sampling rate, in Hz.
    unit : str or dict of str
        The unit of all channels, or of each by its name: ``"m/s2"``, ``"g"``, ``"mN"``, ``"200 m/s2"`` where 1 stands for 200 m/s²,
        ``"1"`` relative to full scale. Without it (or with ``"no unit"``), what needs a unit refuses the channel. A unit that is not
        known is refused.
    name : str
        What messages and documents call it.
    condition : dict
        ``sample``, ``participant``, ``load_n``, ``angle_deg``, ``speed_m_s``, ``touch``, ``direction``.

    Returns
    -------
    Recording
        In SI.

    Raises
    ------
    Error
        For arrays that make no recording: of other types than real numbers, empty, of different lengths, with NaN.

    Warns
    -----
    Warning
        What is found in the samples.

    Notes
    -----
    Source: ``piezotact info``.

    Examples
    --------
    >>> import numpy as np
    >>> found = recording(np.sin(np.arange(5000) / 5), rate=5000, unit="g")
    >>> found.units, found.duration_s
    ({'signal': 'm/s²'}, 1.0)
    """
    data = data_of(channels, rate=rate, unit=unit, name=name, condition=condition, wanted=True)
    found = Recording(data, name)
    warn(found.warnings, 3)
    return found


def data_of(
    channels: Any,
    *,
    rate: float | None,
    unit: Unit,
    name: str,
    condition: Mapping[str, Any] | None = None,
    wanted: bool = False,
) -> RecordingData:
    """The recording of arrays in the extension; what is found in the samples is only looked for where it is `wanted`."""
    _arrays.refuse_files(channels, str(name), "arrays" if wanted else "a path or an array")
    rate = _arrays.plain(rate)
    if rate is None:
        raise UsageError(f"{name}: expected the sampling rate of the array, in Hz, found none; give it as rate=")
    if isinstance(rate, bool) or not isinstance(rate, (int, float)):
        raise UsageError(f"rate: expected a number in Hz, found {rate!r}")
    if not isinstance(name, str):
        raise UsageError(f"name: expected a text, found {name!r}")
    named = _named(channels)
    for channel in named:
        if not isinstance(channel, str):
            raise UsageError(f"{name}: expected names of channels, found {channel!r}")
    units = _units(named, unit, name)
    rows = [
        (channel, units.get(channel), _arrays.samples(values, name if len(named) == 1 else f"{name}, {channel}"))
        for channel, values in named.items()
    ]
    try:
        data = RecordingData.of_arrays(name, rows, float(rate), _condition(condition), wanted)
    except UnicodeEncodeError as error:
        raise UsageError(f"{name}: expected names and units of valid text, found {error.object!r}") from None
    except ValueError as error:
        if isinstance(error, Error) or not str(error).startswith("condition: "):
            raise
        raise UsageError(str(error)) from None
    unknown = set(condition or {}) - set(json.loads(data.condition))
    if unknown:
        raise UsageError(f"condition: expected entries of a condition, found {', '.join(sorted(map(str, unknown)))}")
    return data


def _named(channels: Any) -> dict[Any, Any]:
    """Channels by their names: of a dict or a table of pandas or polars; one array is the only channel."""
    if isinstance(channels, Mapping):
        return dict(channels)
    if hasattr(channels, "column_names") and hasattr(channels, "to_pydict"):
        # A table of pyarrow.
        return {name: channels[name].to_numpy() for name in channels.column_names}
    if hasattr(channels, "columns") and hasattr(channels, "__getitem__"):
        return {name: channels[name] for name in channels.columns}
    return {ONLY_CHANNEL: channels}


def _condition(condition: Mapping[str, Any] | None) -> str:
    try:
        return json.dumps(dict(condition or {}))
    except (TypeError, ValueError) as error:
        raise UsageError(f"condition: expected a dict of texts and numbers, found {condition!r}") from error


def _units(channels: Mapping[str, Any], unit: Unit, name: str) -> dict[str, str | None]:
    units: dict[str, str | None] = dict(unit) if isinstance(unit, Mapping) else {channel: unit for channel in channels}
    unknown = [channel for channel in units if channel not in channels]
    if unknown:
        raise UsageError(f"{name}: expected units of the channels {', '.join(channels)}, found one of {unknown[0]!r}")
    for channel, one in units.items():
        if not (one is None or isinstance(one, str)):
            raise UsageError(f"{name}, {channel}: expected a unit such as 'm/s2', found {one!r}")
    return units


def warn(found: Sequence[Warning], level: int) -> None:
    """Hands `found` to Python's `warnings`, `level` functions further out."""
    for one in found:
        warnings.warn(one, stacklevel=level)
