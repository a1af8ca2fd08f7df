"""MATLAB files between SciPy 1.17.1 (NumPy 2.4.6) and piezotact-dataset, both ways.

    UPDATE_GOLDEN=1 cargo test --workspace --test all matlab::files
    python3 golden/matlab.py [../shared/data/daq/mat]

Reads the file that the Rust test wrote and writes one of its own for the Rust test to read. With a folder it says
which of its files SciPy reads, as the test's list does.
"""

import json
import sys
import warnings
from pathlib import Path

import numpy as np
from scipy.io import loadmat, savemat

folder = Path(__file__).parent.parent / "crates/piezotact-dataset/tests/golden"
k = np.arange(65)

ours = loadmat(folder / "transfer.mat", squeeze_me=True)
assert ours["H"].dtype == complex and ours["H"].shape == (65,)
np.testing.assert_allclose(ours["H"], np.cos(k * 0.3) + 1j * np.sin(k * 0.7) / 3, rtol=1e-13)
np.testing.assert_array_equal(ours["coherence"], 1 / (1 + k))
np.testing.assert_array_equal(ours["frequency_hz"], k * 10000 / 128)
assert (ours["rate_hz"], ours["averages"], ours["load_n"], ours["angle_deg"]) == (10000, 12, 0.2, 15)
assert (str(ours["estimator"]), str(ours["drive_unit"]), str(ours["response_unit"])) == ("Hv(0.25)", "FS", "m/s²")
assert str(ours["participant"]).startswith("Zoë"), repr(ours["participant"])
assert json.loads(str(ours["description"]))["drive"]["gain"] == "B3"
print("transfer.mat:", ", ".join(name for name in ours if not name.startswith("__")))

savemat(
    folder / "scipy.mat",
    {
        "int64": np.array([-9, 9]),
        "beyond": np.array([2**53 + 1]),
        "text": "Zoë 𝄞",
        "matrix": np.arange(6.0).reshape(2, 3),
        "H": np.array([1, 0.5 - 1j, 0.25 - 2j]),
        "f": np.array([0, 2.5, 5]),
        "coherence": np.array([0.5, 0.75, 1], "f4"),
    },
    do_compression=True,
)
print("scipy.mat written")

warnings.simplefilter("ignore")
for file in sorted(Path(sys.argv[1]).glob("*.mat")) if len(sys.argv) > 1 else []:
    try:
        loadmat(file)
    except Exception as error:
        print(f"SciPy refuses {file.name}: {error}")
