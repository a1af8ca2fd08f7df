"""Results: the document that ``--json`` prints, with attributes, and the report."""

from __future__ import annotations

import csv
import html
import io
import json
import keyword
import math
import os
import shutil
import tempfile
import weakref
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from ._arrays import path_of
from ._errors import UsageError, Warning
from ._piezotact import Called, transfer_function
from ._plot import draw
from ._recording import Recording, read


#: Longer lists are counted where a result is printed.
MOST_SHOWN = 20


class Record:
    """A part of a document: its fields are attributes.

    Rows of numbers are arrays that cannot be written, in which an absent number is NaN; rows of one length are an array of two dimensions.
    A field whose name a result has itself, or which is a word of Python, has an underscore behind it: `report_`, `is_`.
    """

    def __init__(self, fields: dict[str, Any]) -> None:
        self._fields = fields
        self._shown: dict[str, Any] = {}

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__") or name in {"_fields", "_shown"}:
            raise AttributeError(name)
        if name.endswith("_") and (hasattr(type(self), name[:-1]) or keyword.iskeyword(name[:-1])):
            name = name[:-1]
        if name not in self._fields:
            raise AttributeError(f"{type(self).__name__} has no {name!r}: it has {', '.join(self._fields)}")
        if name not in self._shown:
            self._shown[name] = shown(self._fields[name])
        return self._shown[name]

    def __dir__(self) -> Iterator[str]:
        yield from super().__dir__()
        yield from self._fields

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {', '.join(self._fields)}>"

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and other._fields == self._fields

    __hash__ = None  # type: ignore[assignment]

    def to_dict(self) -> dict[str, Any]:
        """The fields as JSON has them: texts, numbers, lists and dicts."""
        copied: dict[str, Any] = json.loads(json.dumps(self._fields))
        return copied


def shown(value: Any) -> Any:
    """`value` of a document as an attribute."""
    if isinstance(value, dict):
        return Record(value)
    if isinstance(value, list):
        if value and all(_is_number(one) or one is None for one in value) and any(map(_is_number, value)):
            whole = all(isinstance(one, int) for one in value)
            array = np.array(value, dtype=np.int64 if whole and _fits(value) else np.float64)
            array.flags.writeable = False
            return array
        if value and all(_is_row(one) and len(one) == len(value[0]) for one in value) and any(_is_number(one) for row in value for one in row):
            table = np.array(value, dtype=np.float64)
            table.flags.writeable = False
            return table
        return [shown(one) for one in value]
    return value


def _fits(numbers: list[int]) -> bool:
    return all(-(2**63) <= one < 2**63 for one in numbers)


def _is_row(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(_is_number(one) or one is None for one in value)


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


class Folder:
    """A temporary folder, which is removed when nobody has it any more, and at the end of the process.

    In another process it is a folder of its own with the same files.
    """

    def __init__(self, path: str, was: str = "") -> None:
        self.path = path
        #: Where it was in the process that made it.
        self._was = was
        self._removed = weakref.finalize(self, shutil.rmtree, path, ignore_errors=True)

    def here(self, path: str) -> str:
        """`path` of the other process in this one."""
        return self.path + path.removeprefix(self._was) if self._was and path.startswith(self._was + os.sep) else path

    def __reduce__(self) -> Any:
        place = Path(self.path)
        held = {file.relative_to(place).as_posix(): file.read_bytes() for file in place.rglob("*") if file.is_file()}
        return _folder_again, (self.path, held)


def _folder_again(was: str, held: dict[str, bytes]) -> Folder:
    folder = Folder(tempfile.mkdtemp(prefix="piezotact-"), was)
    for name, content in held.items():
        place = Path(folder.path, name)
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_bytes(content)
    return folder


class Result(Record):
    """What a command gave.

    Its attributes are the fields of the document that the command prints with ``--json``; `to_dict` is that document. A result
    that wrote a file stands for it wherever a path is expected.
    """

    SCHEMA: ClassVar[str] = ""
    #: The figure that it is about.
    FIGURE: ClassVar[int] = 1

    def __init__(self, called: Called, files: dict[str, str], folder: Folder | None = None) -> None:
        super().__init__(json.loads(called.document or "{}"))
        self._called = called
        self._files = files
        self._folder = folder

    @property
    def warnings(self) -> list[Warning]:
        """What a person should know before relying on it."""
        return [Warning(text, code) for code, text in self._called.warnings]

    @property
    def ended(self) -> str:
        """``"done"``, or of what is verified ``"not passed"``, ``"passed in part"``, ``"not decided"``; ``"done in part"`` where some of several files failed."""
        return self._called.ended

    @property
    def said(self) -> list[str]:
        """What the command says beside its result."""
        return [*self._called.printed, *self._called.said]

    @property
    def files(self) -> dict[str, Path]:
        """What was written, by the name of the argument."""
        return {name: Path(path) for name, path in self._files.items()}

    def __fspath__(self) -> str:
        found = self._files.get("out") or self._files.get("record")
        if found is None:
            raise UsageError(f"expected a file, found a {type(self).__name__} that wrote none")
        return found

    def recording(self) -> Recording:
        """The recording that was written: the texture, the drive or what was measured."""
        return read(self._files.get("record") or os.fspath(self))

    def function(self) -> TransferFunction:
        """The transfer function that was written."""
        found = read_transfer(os.fspath(self))
        # Its file is there as long as it is.
        found._folder = self._folder
        return found

    def to_dict(self) -> dict[str, Any]:
        """The document that the command prints with ``--json``, equal to the last bit."""
        document: dict[str, Any] = json.loads(self._called.document or "{}")
        return document

    def to_csv(self) -> str:
        """The table that the command writes with ``--csv``."""
        table = self._called.csv()
        if table is None:
            raise UsageError(f"{type(self).__name__} has no table; to_dict() has all of it")
        return table

    def to_columns(self) -> dict[str, list[Any]]:
        """The table by its columns, which are of integers, of floats or of texts; what is empty is None, in a column of floats NaN."""
        header, *rows = csv.reader(io.StringIO(self.to_csv()))
        return {name: _column([row[at] for row in rows]) for at, name in enumerate(header)}

    def to_pandas(self) -> Any:
        """The table as a ``pandas.DataFrame``."""
        return _library("pandas").DataFrame(self.to_columns())

    def to_polars(self) -> Any:
        """The table as a ``polars.DataFrame``."""
        return _library("polars").DataFrame(self.to_columns())

    def to_arrow(self) -> Any:
        """The table as a ``pyarrow.Table``."""
        return _library("pyarrow").table(self.to_columns())

    @property
    def captions(self) -> list[str]:
        """What each figure of the report shows: the captions, in order."""
        return [figure["caption"] for figure in self._figures()]

    def plot(self, number: int | None = None, *, ax: Any = None) -> Any:
        """Draws a figure of the report with matplotlib, with its labels, units and numbers.

        Parameters
        ----------
        number : int, optional
            Which one, from 1 on; `captions` says what each of them shows. Default: the first, of a spectrogram that over time.
        ax : matplotlib.axes.Axes, optional
            Where a figure that is one chart is drawn; default: a figure of its own.

        Returns
        -------
        matplotlib.axes.Axes
            The axes, to go on with; a list of them where the figure has several.
        """
        figures = self._figures()
        if not figures:
            raise UsageError(f"{type(self).__name__} has no figure; to_dict() has all of it")
        if number is None:
            # One that nothing can be drawn of is left out.
            number = min(self.FIGURE, len(figures))
        if isinstance(number, bool) or not isinstance(number, int) or not 1 <= number <= len(figures):
            raise UsageError(f"number: expected a number from 1 to {len(figures)}, found {number!r}")
        return draw(figures[number - 1], ax)

    def _figures(self) -> list[dict[str, Any]]:
        figures: list[dict[str, Any]] = json.loads(self._called.figures())
        return figures

    def to_html(self) -> str:
        """The report as one HTML file without anything beside it."""
        page = self._called.html()
        if page is None:
            raise UsageError(f"{type(self).__name__} has no report")
        return page

    def report(self, path: str | os.PathLike[str], *, force: bool = False) -> Path:
        """Writes the report to `path`, which ends in ``.html``. A file of another content is only replaced with `force`."""
        place = Path(path)
        if place.suffix.lower() not in {".html", ".htm"}:
            raise UsageError(f"{place}: expected a name that ends in .html, found another extension")
        page = self.to_html()
        if not place.parent.is_dir():
            raise UsageError(f"{place}: expected a folder that is there, found none; make it first")
        if place.exists() and not force and place.read_text(encoding="utf-8", errors="replace") != page:
            raise UsageError(f"{place} exists already: give another name, or force=True to replace it")
        place.write_text(page, encoding="utf-8")
        return place

    def _repr_html_(self) -> str | None:
        if not self._called.has_page:
            return None
        return (
            f'<iframe srcdoc="{html.escape(self.to_html())}" style="width:100%;height:36em;border:0" '
            f'title="{html.escape(type(self).__name__)}"></iframe>'
        )

    def __str__(self) -> str:
        return self._called.text() or "\n".join(self._called.printed) or _facts(self._fields)

    def __reduce__(self) -> Any:
        return _again, (type(self), self._called.to_json(), dict(self._files), self._folder)


def _library(name: str) -> Any:
    """The library that a table is of."""
    try:
        return import_module(name)
    except ModuleNotFoundError as missing:
        if missing.name == name:
            short = name.removeprefix("py")
            raise ModuleNotFoundError(f"to_{short}() gives a table of {name}, which is not installed: pip install {name}", name=name) from None
        raise


def _facts(fields: dict[str, Any]) -> str:
    """The fields of a document, one in a line, without how it was made and what its rows would fill pages with."""
    shown = {name: _fact(value) for name, value in fields.items() if name not in {"schema", "version", "invocation", "warnings"}}
    width = max(map(len, shown), default=0)
    return "\n".join(f"{name:{width}}  {line}" for name, lines in shown.items() for line in lines)


def _fact(value: Any) -> list[str]:
    """The lines that show a value: one, or one for each item of a table."""
    if isinstance(value, dict):
        parts = ((name, " ".join(_fact(one))) for name, one in value.items() if not isinstance(one, (dict, list)))
        return [line] if (line := ", ".join(f"{name} {one}" for name, one in parts if one)) else []
    if isinstance(value, list) and len(value) <= MOST_SHOWN:
        is_table = any(isinstance(one, (dict, list)) for one in value)
        lines = [" ".join(_fact(one)) for one in value]
        return lines if is_table else [", ".join(lines)] if lines else []
    if isinstance(value, list):
        return [f"{len(value)} values"]
    if value is None:
        return []
    return [f"{value:.6g}" if isinstance(value, float) else str(value)]


def _column(cells: list[str]) -> list[Any]:
    """The cells of a column of CSV as numbers, where all that are not empty are numbers."""
    if not any(cells):
        return [None] * len(cells)
    try:
        return [int(cell) for cell in cells]
    except ValueError:
        pass
    try:
        return [float(cell) if cell else math.nan for cell in cells]
    except ValueError:
        return [cell or None for cell in cells]


class TransferFunction(Record):
    """A transfer function: `frequency_hz`, `response`, `coherence`, its units, how it was estimated and measured."""

    def __init__(self, fields: dict[str, Any], path: str) -> None:
        super().__init__(fields)
        self._path = path
        self._folder: Folder | None = None

    @property
    def response(self) -> npt.NDArray[np.complex128]:
        """Response ÷ drive of each line, in `response_unit` / `drive_unit`."""
        response = np.empty(len(self._fields["real"]), dtype=np.complex128)
        response.real, response.imag = self.real, self.imaginary
        return response

    @property
    def warnings(self) -> list[Warning]:
        """What a person should know before relying on it."""
        return [Warning(one["text"], one["code"]) for one in self._fields["warnings"]]

    def __fspath__(self) -> str:
        return self._path

    def __reduce__(self) -> Any:
        return _transfer_again, (self._fields, self._path, self._folder)


def read_transfer(path: str | os.PathLike[str]) -> TransferFunction:
    """Reads a transfer function from a file of any format that the command reads: JSON of this program, UFF, MAT.

    Parameters
    ----------
    path : path
        The file, or a result that wrote one.

    Returns
    -------
    TransferFunction

    Raises
    ------
    Error
        What was expected of the file and what was found.

    Notes
    -----
    Source: ``piezotact info``.
    """
    name = path_of(path, "path")
    return TransferFunction(json.loads(transfer_function(name)), name)


def _again(kind: type[Result], called: str, files: dict[str, str], folder: Folder | None) -> Result:
    if folder is not None:
        files = {name: folder.here(path) for name, path in files.items()}
    return kind(Called.from_json(called), files, folder)


def _transfer_again(fields: dict[str, Any], path: str, folder: Folder | None) -> TransferFunction:
    found = TransferFunction(fields, path if folder is None else folder.here(path))
    found._folder = folder
    return found
