"""Golden values for the place of a recording in its drive, from SciPy: the sweep of a burst, and a recording by another clock, by a cubic
spline, with offset and drift by correlation and Hilbert transform of each block.

    python3 golden/align.py > crates/piezotact/tests/golden/align.json
"""

import json

import numpy as np
import scipy
from scipy import interpolate, signal

# The sweep at the middles of samples.
RATE, BAND, DURATION, PEAK = 4000, (100.0, 1000.0), 0.5, 0.4
count = round(RATE * DURATION)
time = (np.arange(count) + 0.5) / RATE
sweep = signal.chirp(time, BAND[0], DURATION, BAND[1], phi=-90)
# A Tukey window has its zeros on its first and last point: that of twice as many and one samples has ours in between.
window = signal.windows.tukey(2 * count + 1, 0.2)[1::2]
burst = PEAK * window * sweep

# A drive at 2 kHz from 50 to 600 Hz, and its recording at 1.6 kHz by a clock 90 ppm fast.
rng = np.random.default_rng(87)
drive_rate, rate, ppm, offset = 2000, 1600, 90.0, 0.41237
n = 6 * drive_rate
filtered = signal.sosfiltfilt(signal.butter(6, [50, 600], "bandpass", fs=drive_rate, output="sos"), rng.standard_normal(n))
drive = np.round(0.3 * filtered / np.abs(filtered).max(), 5)
# At sixteen times the rate, so that the spline is exact.
fine = signal.resample(drive, 16 * n)
spline = interpolate.CubicSpline(np.arange(16 * n) / (16 * drive_rate), fine)
at = offset + np.arange(int(5.2 * rate)) / (rate * (1 + 1e-6 * ppm))
recorded = np.round(spline(at) + 0.01 * rng.standard_normal(len(at)), 5)

# Independently: both at 8 kHz, blocks of half a second, the maximum of the envelope by a spline.
up = 8000
x = signal.resample_poly(drive, 4, 1)
y = signal.resample_poly(recorded, 5, 1)
length = up // 2
middles, lags = [], []
for start in range(0, len(y) - length + 1, length):
    block = y[start : start + length]
    envelope = np.abs(signal.hilbert(signal.correlate(x, block, "valid")))
    best = int(np.argmax(envelope))
    near = np.arange(max(best - 6, 0), min(best + 7, len(envelope)))
    smooth = interpolate.CubicSpline(near, envelope[near])
    roots = smooth.derivative().roots(extrapolate=False)
    place = roots[np.argmax(smooth(roots))]
    middles.append((start + length / 2) / up)
    lags.append((place - start) / up)
slope, level = np.polyfit(middles, lags, 1)

print(
    json.dumps(
        {
            "made_with": f"NumPy {np.__version__}, SciPy {scipy.__version__}",
            "burst": burst[::10].tolist(),
            "drive_hz": drive_rate,
            "rate_hz": rate,
            "drive": drive.tolist(),
            "recorded": recorded.tolist(),
            "truth": {"offset_s": offset, "drift_ppm": ppm},
            "scipy": {"offset_s": level, "drift_ppm": 1e6 * (1 / (1 + slope) - 1)},
        }
    )
)
