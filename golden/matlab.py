"""MATLAB files between SciPy 1.17.1 (NumPy 2.4.6), h5py 3.16.0, mat73 0.65 and piezotact-dataset, both ways.

    UPDATE_GOLDEN=1 cargo test --workspace --test all matlab::files
    python3 golden/matlab.py [../shared/data/daq/mat]

Reads the file that the Rust test wrote and writes others for the Rust test to read: one of SciPy, and one of version 7.3 (h5py in
MATLAB's layout, read back by mat73) with its twin of version 7. With a folder it says which of its files SciPy reads, as the test's
list does, and compares `mat73/lab` beside it with h5py and mat73.
"""

import json
import sys
import warnings
from pathlib import Path

import h5py
import mat73
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

# One content twice: as MATLAB saves it with -v7.3, and with -v7.
t = np.arange(400) / 100
runs = [np.sin(t[:250]), np.cos(t[:150])]
with h5py.File(folder / "h5py73.mat", "w", userblock_size=512, libver="earliest") as file:

    def put(group, name, values, class_, **more):
        made = group.create_dataset(name, data=np.atleast_2d(values).T, **more)
        made.attrs["MATLAB_class"] = np.bytes_(class_)
        return made

    def text(group, name, value):
        units = np.frombuffer(value.encode("utf-16-le"), "u2")
        put(group, name, units[None, :], "char").attrs["MATLAB_int_decode"] = np.int32(2)

    put(file, "big", np.array([[2**53 + 1]], "i8"), "int64")
    put(file, "flag", np.array([[1, 0, 1]], "u1"), "logical").attrs["MATLAB_int_decode"] = np.int32(1)
    put(file, "fs", 100.0, "double")
    put(file, "H", np.array([[(1, 2), (3, -4)]], [("real", "f8"), ("imag", "f8")]), "double")
    nothing = file.create_dataset("nothing", data=np.array([0, 3], "u8"))
    nothing.attrs["MATLAB_class"] = np.bytes_("double")
    nothing.attrs["MATLAB_empty"] = np.uint8(1)
    rec = file.create_group("rec")
    rec.attrs["MATLAB_class"] = np.bytes_("struct")
    names = np.empty(3, object)
    names[:] = [np.array(list(name), "S1") for name in ("unit", "acc", "force")]
    rec.attrs.create("MATLAB_fields", names, dtype=h5py.vlen_dtype(np.dtype("S1")))
    put(rec, "acc", np.sin(t)[:, None], "double", chunks=(1, 100), compression="gzip", shuffle=True)
    put(rec, "force", np.cos(t).astype("f4")[:, None], "single")
    text(rec, "unit", "m/s²")
    refs = file.create_group("#refs#")
    cells = [put(refs, name, run[:, None], "double").ref for name, run in zip("ab", runs)]
    strokes = file.create_dataset("strokes", data=np.array([cells], object).T, dtype=h5py.ref_dtype)
    strokes.attrs["MATLAB_class"] = np.bytes_("cell")
    trial = file.create_group("trial")
    trial.attrs["MATLAB_class"] = np.bytes_("struct")
    each = [[put(refs, f"{name}{k}", np.array([[k + 0.5]]), "double").ref for k in range(2)] for name in ("p", "q")]
    for name, of in zip("pq", each):
        trial.create_dataset(name, data=np.array([of], object).T, dtype=h5py.ref_dtype)
with open(folder / "h5py73.mat", "r+b") as file:
    file.write(b"MATLAB 7.3 MAT-file".ljust(116) + bytes(8) + b"\0\2IM")
back = mat73.loadmat(folder / "h5py73.mat")
np.testing.assert_array_equal(back["rec"]["acc"], np.sin(t))
np.testing.assert_array_equal(back["strokes"][1], runs[1])
trial = np.zeros((1, 2), [("p", "O"), ("q", "O")])
trial["p"], trial["q"] = [[0.5, 1.5]], [[0.5, 1.5]]
cells = np.empty((1, 2), object)
cells[0, :] = [run[:, None] for run in runs]
savemat(
    folder / "scipy7.mat",
    {
        "H": np.array([[1 + 2j, 3 - 4j]]),
        "big": np.array([[2**53 + 1]]),
        "flag": np.array([[True, False, True]]),
        "fs": 100.0,
        "nothing": np.zeros((0, 3)),
        "rec": {"unit": "m/s²", "acc": np.sin(t)[:, None], "force": np.cos(t).astype("f4")[:, None]},
        "strokes": cells,
        "trial": trial,
    },
    do_compression=True,
)
print("h5py73.mat and scipy7.mat written")

warnings.simplefilter("ignore")
for file in sorted(Path(sys.argv[1]).glob("*.mat")) if len(sys.argv) > 1 else []:
    try:
        loadmat(file)
    except Exception as error:
        print(f"SciPy refuses {file.name}: {error}")
lab = Path(sys.argv[1]).parent / "mat73/lab" if len(sys.argv) > 1 else Path("nowhere")
for file in sorted(lab.glob("*.mat")):
    expected = json.loads((lab / "expected.json").read_text())
    read = mat73.loadmat(file)
    read = read.get("rec", read)
    strokes = [np.std(stroke) for stroke in read.get("strokes", [])]
    np.testing.assert_allclose(strokes, expected["cell strokes std"][: len(strokes)], rtol=1e-12)
    for name in {"acc", "force"} & read.keys():
        values, of = np.asarray(read[name], float), expected[name]
        np.testing.assert_allclose([values.mean(), values.std()], [of["mean"], of["std"]], rtol=1e-6)
    print("mat73 reads", file.name)
