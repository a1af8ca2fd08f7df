"""What the functions raise and what they warn of."""

from __future__ import annotations

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
