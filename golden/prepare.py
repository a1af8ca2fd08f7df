"""Golden values for the typical stroke of a texture, from SciPy: levels in third octaves, their distance from the median.

    python3 golden/prepare.py > crates/piezotact/tests/golden/prepare.json
"""

import json
import math

import numpy as np
import scipy
from scipy import signal

RATE = 5000
LOW_HZ, HIGH_HZ = 20.0, 1000.0

state = 11


def uniform():
    global state
    state = (state * 6364136223846793005 + 1442695040888963407) % 2**64
    return (state >> 11) / 2**53


def normal():
    return sum(uniform() for _ in range(12)) - 6.0


# Length in samples, level, tone in Hz: the fourth is twice as strong, the fifth has another tone.
STROKES = [(5000, 1.0, 180.0), (4400, 1.05, 180.0), (6000, 0.97, 180.0), (5200, 2.0, 180.0), (4800, 1.0, 420.0)]


def stroke(samples, level, tone_hz):
    noise = np.array([normal() for _ in range(samples)])
    time = np.arange(samples) / RATE
    return level * (0.5 * noise + 2.0 * np.sin(2 * np.pi * tone_hz * time)) + 0.3


strokes = [stroke(*each) for each in STROKES]
least_hz = 2.0 / (min(len(x) for x in strokes) / RATE)
edges = [1000.0 * 2 ** ((k - 0.5) / 3) for k in range(-40, 61)]
bands = []
for low, high in zip(edges, edges[1:]):
    low, high = max(low, LOW_HZ), min(high, HIGH_HZ)
    if high - low >= least_hz:
        bands.append((low, high))


def levels(x):
    frequencies, psd = signal.periodogram(x - x.mean(), RATE, window="hann", detrend="constant")
    step = frequencies[1]
    line = lambda hz: math.ceil(hz / step - 1e-9)
    return [10 * math.log10(psd[line(low) : line(high)].sum() * step) for low, high in bands]


table = np.array([levels(x) for x in strokes])
distances = np.sqrt(((table - np.median(table, axis=0)) ** 2).mean(axis=1))
print(
    json.dumps(
        {
            "made_with": f"SciPy {scipy.__version__}, NumPy {np.__version__}",
            "bands_hz": bands,
            "distances_db": distances.tolist(),
            "closest": int(distances.argmin()),
            "spread_db": float(np.median(distances)),
        },
        indent=1,
    )
)
