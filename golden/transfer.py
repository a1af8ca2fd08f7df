"""Hv of pyFRF, for the test `hv_equals_pyfrf` in crates/piezotact/tests/reference.rs.

    python3 golden/transfer.py

Made with pyFRF 1.5.0 and NumPy 2.4.6, from ../shared/reference/transfer.npz. pyFRF's ratio of noise powers is 1 and its
Hann window symmetric.
"""

import numpy as np
import pyFRF

data = np.load("../shared/reference/transfer.npz")
frf = pyFRF.FRF(
    sampling_freq=int(data["fs"]),
    exc=data["x"],
    resp=data["y"],
    exc_type="f",
    resp_type="d",
    window="hann",
    nperseg=2048,
    noverlap=1024,
    fft_len=2048,
)
hv = frf.get_Hv().ravel()
for line in (10, 41, 100, 200, 400):
    print(line, float(hv[line].real), float(hv[line].imag))
