"""``python -m piezotact`` is the program ``piezotact``."""

import sys

from ._command import main

sys.exit(main())
