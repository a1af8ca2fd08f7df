"""Strokes of many recordings, as engines that spread work over processes and computers take them: Arrow in, Arrow out."""

from __future__ import annotations

import csv
import inspect
import io
import math
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any

from ._call import commands, done
from ._errors import DataError, Error, UsageError
from ._functions import Strokes, strokes
from ._piezotact import __version__
from ._recording import Unit

if TYPE_CHECKING:
    import pyarrow

#: The columns of `Strokes.to_csv` but for `file`, for which the column `path` stands.
TEXTS = ["sample", "participant", "touch", "direction", "unit"]
WHOLE = ["stroke"]
TABLE = [
    "sample", "participant", "touch", "direction", "load_n", "stated_speed_m_s", "stroke", "start_s", "duration_s", "unit",
    "rms", "peak", "crest_factor", "merkel_power", "meissner_power", "pacini_power", "ruffini_power", "centroid_hz", "spread_hz",
    "strongest_hz", "friction_mean", "friction_sd", "friction_median", "normal_force_mean_n", "normal_force_sd_n", "speed_mean_m_s",
    "speed_sd_m_s", "pacinian_power", "detection_power", "kurtosis", "level_spread_db", "meissner_level_db", "pacini_level_db",
    "meissner_from_hz", "meissner_level_at_most_db",
]  # fmt: skip
#: Columns of the input that say what was recorded, with the option of `strokes` that does.
STATED = {"touch": "touch", "direction": "direction", "load_n": "load", "speed_m_s": "speed", "rate_hz": "rate"}
#: Columns of the input that name whose recording it is, and nothing is computed from.
NAMED = ["sample", "participant"]
#: Options of `strokes` that are not the same for all rows, or make files or groups.
NOT_FOR_ROWS = {"recordings", "unit", "cuts", "by", "set", "report", "csv", "figures", "tables", "columns", "date", "force"}
#: Where the schema has the version of this package.
VERSION = b"piezotact"


@dataclass
class _Plan:
    """What the columns of the input are, and the schema of the output."""

    #: None where `path` names files.
    channels: list[str] | None
    carried: list[str]
    schema: pyarrow.Schema


def batch(rows: pyarrow.RecordBatch, *, unit: Unit = None, schema: pyarrow.Schema | None = None, **options: Any) -> pyarrow.RecordBatch:
    """Cuts the recording of each row into strokes, and gives one row for each stroke with its features.

    It is what Dask (``map_partitions``) or Spark (``mapInArrow``) does to its parts: rows do not depend on each other, and their order stays.

    Parameters
    ----------
    rows : pyarrow.RecordBatch
        A recording in each row: the column ``path`` names its file; or, without such a column, columns of lists of numbers are its
        channels, with ``rate_hz`` (or ``rate=``) and ``unit=``. A channel that is null in a row is not in that recording.
        ``touch``, ``direction``, ``load_n`` and ``speed_m_s`` state what was recorded, as the options of `strokes` do, where they are not
        null. ``sample`` and ``participant`` (texts or integers) name it. Other columns are labels of yours.
    unit : str or dict of str, optional
        The unit of all channels, or of each by its name: ``"m/s2"``, ``"g"``, ``"N"``. Only of channels in the batch.
    schema : pyarrow.Schema, optional
        What `batch_schema` gave where the work was planned. A process with another version of this package refuses it.
    **options
        Those of `strokes` that are the same for all rows: ``load=0.2``, ``touch="active"``, ``high_pass=5``.

    Returns
    -------
    pyarrow.RecordBatch
        With the schema of `batch_schema`: the columns of `rows` but for the channels; those of the table of `strokes`, with null where
        nothing was measured; ``warnings``, the codes of the warnings with blanks between; ``error``, the sentence where a recording
        cannot be analysed or has no stroke. Such a recording has one row, without features.

    Raises
    ------
    UsageError
        For columns of other types than expected, a channel without unit or rate, options that `strokes` does not have, or another
        version of this package.

    Notes
    -----
    Source: ``piezotact strokes``.

    Examples
    --------
    >>> import os, pyarrow
    >>> from piezotact import twin_record
    >>> silk = twin_record(bench="acttouch", sample="S3", participant=4, speed="30mm/s", strokes=2, seed=1)
    >>> rows = pyarrow.record_batch({"path": [os.fspath(silk), "missing.csv"], "session": ["first", "second"]})
    >>> found = batch(rows)
    >>> found.select(["session", "sample", "stroke"]).to_pylist()[:2]
    [{'session': 'first', 'sample': 'S3', 'stroke': 1}, {'session': 'first', 'sample': 'S3', 'stroke': 2}]
    >>> found["error"].to_pylist()
    [None, None, 'no such file: missing.csv; check the path']
    """
    pa = _arrow()
    if not isinstance(rows, pa.RecordBatch):
        found = type(rows).__name__
        raise UsageError(f"rows: expected a pyarrow.RecordBatch, found a {found}; pyarrow.RecordBatch.from_pandas or Table.to_batches makes one")
    plan = _plan(rows.schema)
    _require_same(schema, plan.schema)
    _require_options(options, plan, rows.schema.names)
    units = _units(plan, rows.schema, unit)

    looked_at = [name for name in ["path", *NAMED, *STATED, *(plan.channels or [])] if name in rows.schema.names]
    of: list[int] = []
    cells: dict[str, list[Any]] = {name: [] for name in [*TABLE, "warnings", "error"]}
    for number in range(rows.num_rows):
        for line in _lines({name: rows.column(name)[number] for name in looked_at}, plan, units, options):
            of.append(number)
            for name, values in cells.items():
                values.append(line.get(name))
    arrays = []
    for field in plan.schema:
        if field.name in cells:
            arrays.append(pa.array(cells[field.name], field.type))
        else:
            # take() has no kernel for some types, such as string_view.
            column = rows.column(field.name)
            arrays.append(pa.concat_arrays([column.slice(0, 0), *(column.slice(number, 1) for number in of)]))
    return pa.RecordBatch.from_arrays(arrays, schema=plan.schema)


def batch_schema(columns: pyarrow.Schema) -> pyarrow.Schema:
    """The schema of what `batch` gives of rows with these columns, which engines want in advance.

    Parameters
    ----------
    columns : pyarrow.Schema
        That of the rows.

    Returns
    -------
    pyarrow.Schema
        Its metadata hold the version of this package. Given to `batch`, it lets a process with another version refuse the work.

    Raises
    ------
    UsageError
        For columns that are no recordings, or have names of columns of the output.

    Notes
    -----
    Source: ``piezotact strokes``.

    Examples
    --------
    >>> import pyarrow
    >>> found = batch_schema(pyarrow.schema({"path": pyarrow.string(), "session": pyarrow.string()}))
    >>> found.names[:4], found.names[-2:]
    (['path', 'session', 'sample', 'participant'], ['warnings', 'error'])
    """
    if not isinstance(columns, _arrow().Schema):
        raise UsageError(f"columns: expected a pyarrow.Schema, found a {type(columns).__name__}")
    return _plan(columns).schema


def _arrow() -> Any:
    try:
        return import_module("pyarrow")
    except ImportError as error:
        raise UsageError("expected the package pyarrow, found none: pip install pyarrow") from error


def _plan(columns: pyarrow.Schema) -> _Plan:
    pa = _arrow()
    names = columns.names
    twice = [name for name in names if names.count(name) > 1]
    if twice:
        raise UsageError(f"rows: expected columns of different names, found {twice[0]!r} twice")
    channels = None if "path" in names else [field.name for field in columns if _is_samples(field.type)]
    if channels == []:
        raise UsageError(
            "rows: expected a column 'path' of texts, or columns of lists of numbers, one for each channel, "
            f"found {', '.join(f'{field.name!r} ({field.type})' for field in columns) or 'none'}"
        )
    for field in columns:
        _require_type(field)
    carried = [name for name in names if name not in [*NAMED, *STATED, *(channels or [])] or name == "rate_hz"]
    taken = [name for name in carried if name in [*TABLE, "warnings", "error"]]
    if taken:
        raise UsageError(f"rows: expected labels of other names than the columns of the output, found {taken[0]!r}; rename it")
    types = {**dict.fromkeys(TABLE, pa.float64()), **dict.fromkeys(TEXTS, pa.string()), **dict.fromkeys(WHOLE, pa.int64())}
    fields = [columns.field(name).remove_metadata() for name in carried]
    fields += [pa.field(name, types[name]) for name in TABLE] + [pa.field("warnings", pa.string()), pa.field("error", pa.string())]
    return _Plan(channels, carried, pa.schema(fields, {VERSION: __version__.encode()}))


def _require_type(field: pyarrow.Field) -> None:
    texts, numbers = field.name in ["path", "touch", "direction"], field.name in ["load_n", "speed_m_s", "rate_hz"]
    kind = field.type
    if _arrow().types.is_null(kind):
        return
    if texts and not _is_text(kind):
        raise UsageError(f"{field.name}: expected a column of texts, found {kind}")
    if numbers and not _is_number(kind):
        raise UsageError(f"{field.name}: expected a column of numbers, found {kind}")
    if field.name in NAMED and not (_is_text(kind) or _arrow().types.is_integer(kind)):
        raise UsageError(f"{field.name}: expected a column of texts or integers, found {kind}")


def _is_text(kind: Any) -> bool:
    of = _arrow().types
    return bool(of.is_string(kind) or of.is_large_string(kind) or of.is_string_view(kind) or of.is_dictionary(kind) and _is_text(kind.value_type))


def _is_number(kind: Any) -> bool:
    return bool(_arrow().types.is_integer(kind) or _arrow().types.is_floating(kind))


def _is_samples(kind: Any) -> bool:
    of = _arrow().types
    return bool(of.is_list(kind) or of.is_large_list(kind) or of.is_fixed_size_list(kind)) and _is_number(kind.value_type)


def _require_same(planned: Any, own: pyarrow.Schema) -> None:
    """Refuses a schema of another version or of other columns."""
    if planned is None:
        return
    if not isinstance(planned, _arrow().Schema) or VERSION not in (planned.metadata or {}):
        raise UsageError("schema: expected what batch_schema gave, found a schema without the version of piezotact")
    version = planned.metadata[VERSION].decode("utf-8", "replace")
    if version != __version__:
        raise UsageError(
            f"schema: expected piezotact {version}, with which the work was planned, found {__version__} in this process; "
            "install one version everywhere"
        )
    if not planned.equals(own):
        unlike = [f"{one.name} ({one.type})" for one in own if one not in planned]
        unlike += [f"no {one.name} ({one.type})" for one in planned if one not in own]
        raise UsageError(f"schema: expected the columns with which the work was planned, found {', '.join(unlike) or 'another order'}")


def _require_options(options: Mapping[str, Any], plan: _Plan, names: list[str]) -> None:
    known = [name for name in inspect.signature(strokes).parameters if name not in NOT_FOR_ROWS]
    for name in options:
        if name not in known:
            raise UsageError(f"{name}: expected one of the options {', '.join(known)}, found another")
    for column, option in STATED.items():
        if column in names and options.get(option) is not None:
            raise UsageError(f"{option}: expected it as an option or as the column {column!r}, found both")
    if plan.channels and "rate_hz" not in names and options.get("rate") is None:
        raise UsageError("rate: expected the sampling rate of the channels, in Hz, found none; give it as rate= or as the column 'rate_hz'")


def _units(plan: _Plan, columns: pyarrow.Schema, unit: Unit) -> dict[str, str]:
    """The unit of each channel."""
    if plan.channels is None:
        if unit is not None:
            raise UsageError("unit: expected channels that it is of, found files; of a file, scale= states what 1 stands for")
        return {}
    units = dict(unit) if isinstance(unit, Mapping) else dict.fromkeys(plan.channels, unit)
    for name, one in units.items():
        if name not in columns.names:
            raise UsageError(f"unit: expected units of the columns {', '.join(plan.channels)}, found one of {name!r}")
        if name not in plan.channels:
            raise UsageError(f"{name}: expected a list of numbers in each row, found {columns.field(name).type}")
    for name in plan.channels:
        if not isinstance(units.get(name), str):
            raise UsageError(f"{name}: expected its unit, such as unit={{{name!r}: 'm/s2'}}, found {units.get(name)!r}")
    return {name: str(one) for name, one in units.items()}


def _lines(row: Mapping[str, Any], plan: _Plan, units: Mapping[str, str], options: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The lines of one recording: one for each stroke, or one that says why there is none."""
    values = {name: row[name].as_py() for name in [*NAMED, *STATED] if name in row}
    named = {name: str(values[name]) for name in NAMED if values.get(name) is not None}
    stated = {option: values[column] for column, option in STATED.items() if values.get(column) is not None}
    try:
        _require_stated(values)
        if "speed" in stated:
            stated["speed"] = f"{stated['speed']!r} m/s"
        given = {**options, **stated, "recordings": _recording(row, plan)}
        if plan.channels is not None:
            given["unit"] = {name: units[name] for name in given["recordings"]}
        result = done(Strokes, "strokes", given, data=("recordings",))
        found = [_line(one) for one in csv.DictReader(io.StringIO(result.to_csv()))]
        if not found:
            raise DataError("expected strokes, found none")
    except Error as error:
        labels = {"load_n": values.get("load_n"), "stated_speed_m_s": values.get("speed_m_s")}
        labels |= {name: values.get(name) for name in ["touch", "direction"]}
        return [{**labels, **named, "error": str(error)}]
    warned = " ".join(dict.fromkeys(one.code for one in result.warnings)) or None
    return [{**line, **named, "warnings": warned} for line in found]


def _require_stated(values: Mapping[str, Any]) -> None:
    """Refuses what a command line would not take, in a sentence of one line."""
    for argument in commands()["strokes"]["arguments"]:
        name, choices = argument["name"], argument["choices"]
        if name in ["touch", "direction"] and values.get(name) not in [None, *choices]:
            raise DataError(f"{name}: expected one of {', '.join(choices)}, found {values[name]!r}")
    speed = values.get("speed_m_s")
    if speed is not None and not 0 < speed < math.inf:
        raise DataError(f"speed_m_s: expected a speed above 0 m/s, found {speed:g}")


def _recording(row: Mapping[str, Any], plan: _Plan) -> Any:
    """The path of a row, or the arrays of its channels."""
    if plan.channels is None:
        path = row["path"].as_py()
        if not path:
            raise DataError(f"path: expected the path of a recording, found {'null' if path is None else 'an empty text'}")
        return path
    if "rate_hz" in row and not row["rate_hz"].is_valid:
        raise DataError("rate_hz: expected the sampling rate, in Hz, found null")
    arrays = {}
    for name in plan.channels:
        if not row[name].is_valid:
            continue
        samples = row[name].values
        if not len(samples):
            raise DataError(f"{name}: expected samples, found none")
        if samples.null_count:
            raise DataError(f"{name}: expected samples without gaps, found {samples.null_count} null")
        arrays[name] = samples.to_numpy(zero_copy_only=False)
    if not arrays:
        raise DataError(f"{', '.join(plan.channels)}: expected the samples of a recording, found null")
    return arrays


def _line(cells: Mapping[str, str]) -> dict[str, Any]:
    """A row of the table of `strokes`, with None where it is empty."""
    return {name: _value(name, cells[name]) for name in TABLE if cells[name] != ""}


def _value(name: str, cell: str) -> Any:
    return cell if name in TEXTS else int(cell) if name in WHOLE else float(cell)
