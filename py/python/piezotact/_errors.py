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


#: How the parser of the command line refuses a value: what it found, the option or the place, and why.
REFUSED = re.compile(r"error: invalid value '(?P<found>.*?)' for '(?:--(?P<option>[a-z0-9-]+)|[<\[](?P<place>\w+)).*?'(?:: (?P<why>[^\n]*))?", re.DOTALL)
KINDS = {"integer": "a whole number from 0 on", "number": "a number"}


def of_argument(sentence: str, arguments: Sequence[Mapping[str, Any]]) -> str:
    """What the parser of the command line says, as a sentence about the argument; another `sentence` as it is.

    `arguments` are those of the command, as the program describes them.
    """
    if not sentence.startswith("error: "):
        return sentence
    refused = REFUSED.match(sentence)
    named = [one for one in arguments if refused and refused["option"] == one["option"] and refused["place"] in {None, one["value"]}]
    if refused is None or not named:
        return " ".join(sentence.removeprefix("error: ").partition("\n\n")[0].split())
    found = refused["found"] if re.fullmatch(r"[-+.\dEe]+", refused["found"]) else repr(refused["found"])
    why, advice = refused["why"] or "", ""
    if named[0]["choices"]:
        why = f"expected one of {', '.join(named[0]['choices'])}"
    elif not why.startswith("expected"):
        why = f"expected {KINDS[named[0]['kind']]}" if named[0]["kind"] in KINDS else f"expected another value ({why})"
    else:
        why, _, advice = why.partition("; ")
    why = why if ", found" in why else f"{why}, found {found}"
    return f"{named[0]['name'].replace('-', '_')}: {why}{'; ' if advice else ''}{advice}"
