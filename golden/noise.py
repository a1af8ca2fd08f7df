"""Golden values for the noise of a sensor at rest, from SciPy: the PSD of medians, levels over bands and lines, and the trend.

    python3 golden/noise.py > crates/piezotact/tests/golden/noise.json
"""

import json
import math

import numpy as np
import scipy
from scipy import signal, stats

RATE = 2500
SECONDS = 20

state = 7


def uniform():
    global state
    state = (state * 6364136223846793005 + 1442695040888963407) % 2**64
    return (state >> 11) / 2**53


def normal():
    return sum(uniform() for _ in range(12)) - 6.0


time = np.arange(RATE * SECONDS) / RATE
x = np.array([0.01 * normal() for _ in time])
x += 0.02 + 1e-4 * time + 0.004 * np.sin(2 * np.pi * 50.0 * time)

frequencies, psd = signal.welch(x, RATE, window="hann", nperseg=RATE, noverlap=RATE // 2, average="median")


def third_octave(centre):
    third = 2 ** (1 / 6)
    inside = (frequencies >= centre / third) & (frequencies <= centre * third)
    return math.sqrt(np.median(psd[inside]))


mean_psd = signal.welch(x, RATE, window="hann", nperseg=RATE, noverlap=RATE // 2)[1]
band = (frequencies >= 10) & (frequencies <= 1000)
around = [k for k in range(42, 59) if abs(k - 50) > 3]

without_line = psd.copy()
without_line[48:53] = np.minimum(psd[48:53], np.median(psd[around]))

means = x.reshape(SECONDS, RATE).mean(axis=1)
seconds = np.arange(SECONDS)
line = stats.linregress(seconds, means)
left = means - line.intercept - line.slope * seconds
together = min(max(np.sum(left[1:] * left[:-1]) / np.sum(left**2), 0.0), 0.99)
independent = SECONDS * (1 - together) / (1 + together)
freedom = independent - 2
error = math.sqrt(np.sum(left**2) / freedom / np.sum((seconds - seconds.mean()) ** 2))
reach = stats.t.ppf(0.975, math.floor(freedom)) * error

print(
    json.dumps(
        dict(
            scipy=scipy.__version__,
            rms=math.sqrt(np.sum(mean_psd[band])),
            floor_rms=math.sqrt(np.sum(without_line[band])),
            densities=[third_octave(hz) for hz in (10, 100, 1000)],
            psd=list(psd[::50]),
            above_db=10 * math.log10(psd[50] / np.median(psd[around])),
            slope=line.slope,
            slope_interval=[line.slope - reach, line.slope + reach],
            independent=independent,
            range=float(means.max() - means.min()),
        ),
        indent=1,
    )
)
