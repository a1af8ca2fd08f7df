"""Arrays of samples as NumPy 2.4.6 saves them, for piezotact-dataset to read.

    python3 golden/npy.py

Sample k of a channel c is (c + 1) sin(0.37 k), k from 0 to 39.
"""

from pathlib import Path

import numpy as np

folder = Path(__file__).parent.parent / "crates/piezotact-dataset/tests/golden/npy"
folder.mkdir(exist_ok=True)
k = np.arange(40)
one = np.sin(0.37 * k)
three = one[:, None] * np.array([1, 2, 3])

np.save(folder / "one.npy", one)
np.save(folder / "big_endian.npy", one.astype(">f4"))
np.save(folder / "int16.npy", np.round(one * 1000).astype("<i2"))
np.save(folder / "three.npy", three)
np.save(folder / "fortran.npy", np.asfortranarray(three))
np.savez(folder / "named.npz", acc=one, force=2 * one, fs=5000, note="first run")
np.savez_compressed(folder / "timed.npz", t=k / 2000, acc=one)
np.save(folder / "object.npy", np.array([1.0, "a", None], dtype=object), allow_pickle=True)
np.save(folder / "complex.npy", one + 1j * one)
np.save(folder / "channels_in_rows.npy", three.T.copy())
