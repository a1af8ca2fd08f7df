"""Golden values of measured topographies, as SurfaceTopography 1.27.1 reads them; the Surfcom profiles with NumPy.

    python3 golden/topography.py ../shared/data/topography > crates/piezotact-surface/tests/golden/topography.json

Lengths in m. Heights are taken from their mean, since programs differ in whether they add an offset.
"""

import json
import sys
import warnings
from pathlib import Path

import numpy as np
from SurfaceTopography import open_topography

warnings.filterwarnings("ignore")
data = Path(sys.argv[1])
UNITS = {"m": 1.0, "mm": 1e-3, "µm": 1e-6, "nm": 1e-9}
# Files that do not name their units: what 1 stands for along the surface and in height, as the tests state it.
STATED = {"xy-4.txt": (1e-3, 1e-3), "test1.txt": (1e-3, 1e-6)}
MAPS = [
    "surfacetopography/al3d-1.al3d",
    "surfacetopography/bcrf-1.bcrf",
    "surfacetopography/matrix-4.txt",
    "surfacetopography/plu-1.plu",
    "surfacetopography/sdf-1.sdf",
    "surfacetopography/sur-3.sur",
    "surfacetopography/x3p-2.x3p",
    "nanovea/test1.txt",
]


def figures(file, heights, step_x, step_y):
    """`heights`: rows of a map, or one row of a profile; masked where nothing was measured."""
    heights = np.ma.masked_invalid(np.ma.asarray(heights, dtype=float))
    if heights.ndim == 1:
        heights = heights.reshape(1, -1)
    off = heights - heights.mean()
    sq = np.sqrt((off**2).mean())

    def corner(row, column):
        return None if np.ma.getmaskarray(off)[row, column] else float(off[row, column])

    return dict(
        file=file,
        rows=heights.shape[0],
        columns=heights.shape[1],
        step_x_m=float(step_x),
        step_y_m=float(step_y),
        missing=int(np.ma.count_masked(heights)),
        sq_m=float(sq),
        ssk=float((off**3).mean() / sq**3),
        sku=float((off**4).mean() / sq**4),
        lowest_m=float(off.min()),
        highest_m=float(off.max()),
        first_m=corner(0, 0),
        second_m=corner(0, 1),
        last_m=corner(-1, -1),
        end_of_first_row_m=corner(0, -1),
    )


cases = []
for file in MAPS:
    topography = open_topography(data / file).topography()
    lateral, height = STATED.get(Path(file).name, (UNITS.get(topography.unit),) * 2)
    (columns, rows), (width, length) = topography.nb_grid_pts, topography.physical_sizes
    heights = np.ma.masked_invalid(topography.heights()).T * height
    cases.append(figures(file, heights, width * lateral / columns, length * lateral / rows))

x, z = np.loadtxt(data / "surfacetopography/xy-4.txt", unpack=True) * 1e-3
step = (x[-1] - x[0]) / (len(x) - 1)
cases.append(figures("surfacetopography/xy-4.txt", z, step, step))
for file in ["surfcom/specimen_1_primary.tx1", "surfcom/specimen_1_roughness.tx2"]:
    values = np.loadtxt(data / file)
    step = values[0] * 1e-3 / values[1]
    cases.append(figures(file, values[2:] * 1e-6, step, step))
json.dump(cases, sys.stdout, indent=1)
print()
