"""What the functions raise and what they warn of."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

__all__ = ["DataError", "Error", "UsageError", "Warning"]


class Error(Exception):
    """Why there is no result: what was expected, what was found, and what to do.

    The sentence is that of the command ``piezotact``; an option ``--max-frequency`` in it is the argument ``max_frequency``.

    Attributes
    ----------
    kind : str
        ``"usage"`` where something was asked for that cannot be, ``"data"`` where a file, an array or a device is not what it must be.
    """

    kind: str = "error"
    #: The value that the parser of the command line refuses: its argument, the value, and what its type says of it.
    _refused: tuple[str, str, str | None] | None = None


class UsageError(Error, ValueError):
    """Something was asked for that cannot be."""

    kind = "usage"


class DataError(Error, ValueError):
    """A file, an array or a device is not what it must be."""

    kind = "data"


class Warning(UserWarning):  # noqa: A001, the name that numpy and others use in their modules too
    """What a person should know before relying on a result.

    Attributes
    ----------
    code : str
        What it is, in a word that never changes its meaning: ``"clipped"``. ``docs/guide/warnings.md`` lists them.
    """

    def __init__(self, text: str, code: str = "") -> None:
        super().__init__(text)
        self.code = code

    def __reduce__(self) -> tuple[type[Warning], tuple[str, str]]:
        return type(self), (str(self), self.code)


KINDS = {"integer": "a whole number from 0 on", "number": "a number"}


def of_argument(error: Error, arguments: Sequence[Mapping[str, Any]]) -> str:
    """The sentence of `error`; of a value that the parser of the command line refuses, a sentence about the argument.

    `arguments` are those of the command, as the program describes them.
    """
    argument, value, why = error._refused or ("", "", None)
    named = [one for one in arguments if argument == (one["option"] or one["value"])]
    if not named:
        return str(error)
    found = value if re.fullmatch(r"[-+.\dEe]+", value) else repr(value)
    advice = ""
    if named[0]["choices"]:
        why = f"expected one of {', '.join(named[0]['choices'])}"
    elif why is None or not why.startswith("expected"):
        why = f"expected {KINDS[named[0]['kind']]}" if named[0]["kind"] in KINDS else f"expected another value ({why or 'it is empty'})"
    else:
        why, _, advice = why.partition("; ")
    why = why if ", found" in why else f"{why}, found {found}"
    return f"{named[0]['name'].replace('-', '_')}: {why}{'; ' if advice else ''}{advice}"
