"""Universal files between pyuff 2.5.8 (NumPy 2.4.6) and piezotact-dataset, both ways.

    UPDATE_GOLDEN=1 cargo test --workspace --test all uff::pyuff
    python3 golden/uff.py

Reads the two files that the Rust test wrote, compares every number with the formula, and writes two files of its own
for the Rust test to read.
"""

from pathlib import Path

import numpy as np
import pyuff

folder = Path(__file__).parent.parent / "crates/piezotact-dataset/tests/golden"
k = np.arange(17)
h, coherence, hz = 1 / (1 + k) - 1j * k / 16, 1 / (1 + k / 64), k * 31.25

for name, rtol in (("transfer.uff", 5.1e-13), ("transfer_binary.uff", 0)):
    file = pyuff.UFF(str(folder / name))
    assert list(file.get_set_types()) == [58, 58], file.get_set_types()
    frf, gamma = file.read_sets()
    assert (frf["func_type"], gamma["func_type"]) == (4, 6)
    np.testing.assert_allclose(frf["data"].real, h.real, rtol=rtol)
    np.testing.assert_allclose(frf["data"].imag, h.imag, rtol=rtol)
    np.testing.assert_allclose(gamma["data"], coherence, rtol=rtol)
    np.testing.assert_allclose(frf["x"], hz, rtol=1e-6)
    assert frf["ordinate_axis_units_lab"].strip() == "m/s^2"
    assert frf["orddenom_axis_units_lab"].strip() == "FS"
    assert (frf["rsp_node"], frf["rsp_dir"], frf["ref_node"], frf["ref_dir"]) == (1, 0, 2, 0)
    print(name, frf["id1"].strip(), "|", frf["id2"].strip())

for name, binary in (("pyuff.uff", 0), ("pyuff_binary.uff", 1)):
    # Overwriting a binary file, pyuff loses its header: it is added to nothing instead.
    (folder / name).unlink(missing_ok=True)
    file = pyuff.UFF(str(folder / name))
    common = {
        "type": 58, "binary": binary, "rsp_node": 7, "rsp_dir": 3, "ref_node": 8, "ref_dir": -3, "x": hz,
        "abscissa_spacing": 1, "abscissa_spec_data_type": 18, "abscissa_axis_units_lab": "Hz",
        "orddenom_spec_data_type": 13,
    }  # fmt: skip
    sets = [
        common | {"func_type": 6, "data": coherence},
        common
        | {"func_type": 4, "data": h, "ordinate_spec_data_type": 12, "ordinate_axis_units_lab": "m/s^2"}
        | {"orddenom_axis_units_lab": "N"},
    ]
    file.write_sets(sets, mode="add")
    print(name, "written")
