"""Functions as commands: arguments become the words of a command line, and data are given beside them."""

from __future__ import annotations

import functools
import json
import os
import re
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from . import _piezotact
from ._arrays import path_of, plain
from ._errors import Error, UsageError, Warning, of_argument
from ._piezotact import Called, RecordingData
from ._recording import Recording, data_of, warn
from ._results import Folder, Result

R = TypeVar("R", bound=Result)

#: Arguments of every function: of the arrays, of files, and of the command line as a whole.
RATE, UNIT, SCALE = "rate", "unit", "scale"
#: The kind of a recording that is in no file.
ARRAYS = "arrays"
GLOBAL: list[dict[str, Any]] = [
    {"name": name, "option": name, "kind": kind, "value": None, "choices": [], "is_required": False, "is_several": False, "is_operation": False}
    for name, kind in (("date", "text"), ("force", "flag"))
]


@functools.cache
def commands() -> dict[str, dict[str, Any]]:
    """Every command by its name, as the program describes itself."""
    found = json.loads(_piezotact.commands())
    return {command["name"]: command for command in found}


def run(kinds: type[R] | tuple[type[R], ...], command: str, given: Mapping[str, Any], data: Sequence[str] = (), outputs: Mapping[str, str] = {}) -> R:
    """Does `command` with the arguments `given`.

    Parameters
    ----------
    kinds : type, or several
        What is returned: the one whose `SCHEMA` is that of the document.
    command : str
        Its name: ``"panel analyse"``.
    given : dict
        The arguments by their names; None, False and empty lists are left out.
    data : list of str
        The arguments that may be arrays or recordings.
    outputs : dict
        What a required output that is not given is called in a temporary folder, which the result keeps.
    """
    result = done(kinds, command, given, data, outputs)
    warn(result.warnings, 4)
    if result.ended == "done in part":
        warn([Warning(result.said[-1], "failed_files")], 4)
    return result


def done(kinds: type[R] | tuple[type[R], ...], command: str, given: Mapping[str, Any], data: Sequence[str] = (), outputs: Mapping[str, str] = {}) -> R:
    """The same as `run`, but warnings stay in the result: those of Python are of a whole process, and no thread can silence its own."""
    described = commands()[command]
    line = _Line(described, given, data)
    folder, files = _outputs(described, given, outputs)
    kept = Folder(folder) if folder else None
    # Whether arrays are given is known first.
    for argument in [*sorted(described["arguments"], key=lambda one: one["name"] not in data), *GLOBAL]:
        name = argument["name"]
        value = files.get(name, given.get(_keyword(name)))
        line.add(argument, value)
    for operation in given.get("operations") or []:
        line.operate(described["arguments"], operation)
    if any(argument["name"] == "json" for argument in described["arguments"]):
        line.options.append("--json")
    line.all_used()
    try:
        called = _piezotact.call(line.words(), list(line.data.items()))
    except Error as refused:
        said = line.sentence(refused)
        raise type(refused)(said.replace(folder + os.sep, "") if folder else said) from None
    return _kind(kinds, called)(called, files, kept)


def _kind(kinds: type[R] | tuple[type[R], ...], called: Called) -> type[R]:
    if not isinstance(kinds, tuple):
        return kinds
    schema = json.loads(called.document or "{}").get("schema")
    return next((kind for kind in kinds if kind.SCHEMA == schema), kinds[0])


def _keyword(name: str) -> str:
    """The name of an argument in Python."""
    name = name.replace("-", "_")
    return f"{name}_" if name in {"from", "in", "with", "is", "as", "lambda", "import", "global", "class", "def", "return"} else name


def _outputs(
    described: Mapping[str, Any], given: Mapping[str, Any], outputs: Mapping[str, str]
) -> tuple[str | None, dict[str, str]]:
    """What is written, by the name of its argument; what has to be written and is not stated, in a temporary folder."""
    files: dict[str, str] = {}
    folder = None
    for argument in described["arguments"]:
        name = argument["name"]
        if not argument["is_output"]:
            continue
        value = given.get(_keyword(name))
        if value is not None:
            files[name] = _path(name, value)
        elif name in outputs:
            folder = folder or tempfile.mkdtemp(prefix="piezotact-")
            files[name] = str(Path(folder) / outputs[name])
    return folder, files


def called_for(name: str, *several: Any) -> str:
    """What an output is called in a temporary folder: a file, or a folder where one of the inputs is `several`."""
    is_several = any(isinstance(one, (list, tuple)) and len(one) > 1 and not _is_row(one) for one in several)
    return Path(name).stem if is_several else name


class _Line:
    """The words of a command, and the data that they name."""

    def __init__(self, described: Mapping[str, Any], given: Mapping[str, Any], names: Sequence[str]) -> None:
        self.names = described["name"].split(" ")
        self._arguments = [*described["arguments"], *GLOBAL]
        self.options: list[str] = []
        self.positional: list[str] = []
        self.data: dict[str, RecordingData] = {}
        self._given = given
        self._takes_data = names
        self._has_arrays = False
        #: The arguments of which one value or more is a file.
        self._of_files: set[str] = set()

    def words(self) -> list[str]:
        behind = ["--", *self.positional] if self.positional else []
        return ["piezotact", *self.names, *self.options, *behind]

    def add(self, argument: Mapping[str, Any], value: Any) -> None:
        """Adds an argument with its `value`."""
        name, kind = argument["name"], argument["kind"]
        value = value if name in self._takes_data else plain(value)
        if argument["is_required"] and (value is None or argument["is_several"] and isinstance(value, (list, tuple)) and not value):
            what = "a path or an array" if name in self._takes_data else "a path" if kind == "path" else "a value"
            raise UsageError(f"{_keyword(name)}: expected {what}, found {value!r}")
        if value is None or value is False or argument["option"] == "json" or argument["is_operation"]:
            return
        if name == RATE and self._has_arrays:
            return
        if kind == "flag":
            if value is not True:
                raise UsageError(f"{_keyword(name)}: expected True or False, found {value!r}")
            self.options.append(f"--{argument['option']}")
            return
        for word in self._words_of(argument, value):
            if argument["option"] is None:
                self.positional.append(word)
            else:
                self.options.append(f"--{argument['option']}={word}")

    def operate(self, arguments: Sequence[Mapping[str, Any]], operation: Any) -> None:
        """Adds an operation: its name, or its name and its value."""
        name, value = operation if isinstance(operation, tuple) and len(operation) == 2 else (operation, None)
        known = {_keyword(one["name"]): one for one in arguments if one["is_operation"]}
        argument = known.get(name.replace("-", "_")) if isinstance(name, str) else None
        if argument is None:
            raise UsageError(f"operations: expected one of {', '.join(known)}, found {name!r}")
        if (argument["kind"] == "flag") != (value is None):
            raise UsageError(f"{name}: expected {'no value' if value is not None else 'a value'}, as ('{name}', value)")
        if value is None:
            self.options.append(f"--{argument['option']}")
        else:
            word = os.fspath(value) if isinstance(value, os.PathLike) else _word(name, value)
            self.options.append(f"--{argument['option']}={word}")

    def _words_of(self, argument: Mapping[str, Any], value: Any) -> list[str]:
        name, kind = argument["name"], argument["kind"]
        several = argument["is_several"]
        if name in self._takes_data:
            values = value if several and isinstance(value, (list, tuple)) and not _is_row(value) else [value]
            names = [name] if len(values) == 1 else [f"{name} {number}" for number in range(1, len(values) + 1)]
            return [self._datum(called, one) for called, one in zip(names, values)]
        if several and isinstance(value, (list, np.ndarray)) or several and kind != "text" and isinstance(value, tuple):
            values = list(value)
        else:
            values = [value]
        return [_path(name, one) if kind == "path" else _word(name, one, kind) for one in values]

    def _datum(self, name: str, value: Any) -> str:
        """The word that stands for a file, a recording, or arrays."""
        if isinstance(value, (str, os.PathLike, Result)):
            self._of_files.add(name.partition(" ")[0])
            return _path(name, value)
        if isinstance(value, Recording):
            called, data = value.name, value._data
        else:
            self._has_arrays = True
            called = name
            data = data_of(value, rate=self._given.get(RATE), unit=self._given.get(UNIT), name=name)
        number = 1
        unlike = called
        while self.data.get(unlike, data) is not data:
            number += 1
            unlike = f"{called} ({number})"
        self.data[unlike] = data
        return unlike

    def all_used(self) -> None:
        """Refuses a unit, a rate or a scale that is of none of the data."""
        if self._given.get(UNIT) is not None and not self._has_arrays:
            raise UsageError("unit: expected an array that it is of, found none; of a file, scale= states what 1 stands for")
        if not self._takes_data:
            return
        if self._given.get(RATE) is not None and not self._has_arrays and not self._of_files:
            raise UsageError("rate: expected an array or a file that it is of, found a recording, which has its rate; leave it out")
        for name in [SCALE, *(f"{one}_{SCALE}" for one in self._takes_data)]:
            of_files = self._of_files if name == SCALE else self._of_files & {name.removesuffix(f"_{SCALE}")}
            if self._given.get(name) not in (None, [], ()) and not of_files:
                where = "with the array, as unit=" if self._has_arrays else "where the recording is made"
                raise UsageError(f"{name}: expected a file that it is of, found none; state the unit {where}")

    def sentence(self, error: Error) -> str:
        """What the command says, of the arguments of Python."""
        said = of_argument(error, self._arguments)
        of = next((data for name, data in self.data.items() if said.startswith(f"{name}: ")), None)
        unit = re.search(r"expected .* in (\S+), found", said)
        if of is None or unit is None:
            return said
        one = unit[1].replace("²", "2")
        stated = f'give its unit: unit="{one}"' if of.kind == ARRAYS else f'read it with its unit: scale="1 {one}"'
        return re.sub(r"state its unit \(--[a-z-]*scale\)", stated, said)


def _is_row(values: Any) -> bool:
    """Whether a list is one row of samples, and not several recordings."""
    return bool(values) and all(isinstance(one, (int, float, np.number)) for one in values)


def _path(name: str, value: Any) -> str:
    if isinstance(value, Recording):
        if value.kind == ARRAYS:
            raise UsageError(f"{_keyword(name)}: expected a file, found a recording of arrays; this argument is read from a file")
        return value.name
    return path_of(value, _keyword(name))


def _word(name: str, value: Any, kind: str = "text") -> str:
    """A value as a command reads it; numbers keep all their digits."""
    value = plain(value)
    if kind == "integer" and isinstance(value, float) and value.is_integer():
        value = int(value)
    if isinstance(value, bool):
        raise UsageError(f"{_keyword(name)}: expected a value, found {value!r}")
    if isinstance(value, str):
        return value
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, tuple) and len(value) == 2:
        return "..".join(_word(name, one) for one in value)
    raise UsageError(f"{_keyword(name)}: expected a text or a number, found a {type(value).__name__}")
