"""The open instrument for the sense of touch.

Functions are the commands of ``piezotact``: the same names, the same arguments, the same numbers. They take files, recordings
(`read`, `recording`), or arrays with ``rate=`` and ``unit=``, and return results whose attributes are the fields of the documents
that the commands print as JSON.

>>> import numpy as np, piezotact as pz
>>> x = np.sin(2 * np.pi * 250 * np.arange(50_000) / 5000)
>>> found = pz.spectrum(x, rate=5000, unit="m/s2", segment=1000)
>>> float(found.frequency_hz[found.psd.argmax()])
250.0
"""

from . import _functions
from ._batch import batch, batch_schema
from ._errors import DataError, Error, UsageError, Warning
from ._functions import *  # noqa: F403, the list is that of the module
from ._piezotact import __version__
from ._recording import Recording, read, recording
from ._results import Record, Result, TransferFunction, read_transfer

__all__ = [
    "DataError",
    "Error",
    "Record",
    "Recording",
    "Result",
    "TransferFunction",
    "UsageError",
    "Warning",
    "__version__",
    "batch",
    "batch_schema",
    "read",
    "read_transfer",
    "recording",
    *_functions.__all__,
]
