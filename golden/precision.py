"""How far SciPy's transfer functions in ../shared/reference/transfer.npz are from extended precision.

The drive of that reference ends at 1 kHz. Above, its power falls to 1e-16 of its largest: the rounding of a
double-precision FFT. This prints why tests/reference.rs asks for 2e-10 on the excited lines and 2e-6 on the
others. Made with NumPy 2.4.6 and SciPy 1.17.1:

    python3 golden/precision.py ../shared/reference/transfer.npz
"""

import sys

import numpy as np
import scipy.fft
from scipy import signal

reference = np.load(sys.argv[1])
for n in (2048, 4096):
    window = signal.windows.hann(n, sym=False).astype(np.longdouble)

    def spectra(samples):
        samples = samples.astype(np.longdouble)
        segments = np.lib.stride_tricks.sliding_window_view(samples, n)[:: n // 2]
        return scipy.fft.rfft((segments - segments.mean(-1, keepdims=True)) * window)

    drive, response = spectra(reference["x"]), spectra(reference["y"])
    sxx, syy = (abs(drive) ** 2).sum(0), (abs(response) ** 2).sum(0)
    sxy = (drive.conj() * response).sum(0)
    excited = sxx >= 1e-10 * sxx.max()
    for key, truth in (("H1", sxy / sxx), ("H2", syy / sxy.conj()), ("coh", abs(sxy) ** 2 / (sxx * syy))):
        error = abs(reference[f"{key}_{n}"] / truth - 1)
        print(f"{key}_{n}: excited lines {error[excited].max():.1e}, others {error[~excited].max():.1e}")
