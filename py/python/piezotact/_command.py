"""The program ``piezotact``: the same as the one that cargo builds, but for sound devices."""

from __future__ import annotations

import signal
import sys

from . import _piezotact


def main() -> int:
    """Does what the command line asks for; the exit code."""
    # The program answers signals itself. Where whoever started it ignores Ctrl-C, Python leaves it so.
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.stdout.flush()
    sys.stderr.flush()
    return _piezotact.program(["piezotact", *sys.argv[1:]], [sys.executable, "-m", "piezotact"])
