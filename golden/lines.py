"""Golden values of the lines of a height map: the spectrum of SciPy 1.17.1 in ten bins a decade, and the
parameters of its rows without a filter; with NumPy 2.4.6.

    python3 golden/lines.py

The map comes from a formula that the Rust test computes too: rows of noise with the power law of a Hurst exponent of 0.7, by
summing waves with phases from a linear congruential generator.
"""

from importlib.metadata import version

import numpy as np
from scipy import signal

ROWS, COLUMNS, STEP = 24, 512, 2e-6


def phases(count):
    state, values = 7, []
    for _ in range(count):
        state = (state * 6364136223846793005 + 1442695040888963407) % 2**64
        values.append((state >> 11) / 2**53 * 2 * np.pi)
    return np.array(values)


def rough_map(slope):
    waves = COLUMNS // 2
    all_phases = phases(ROWS * waves).reshape(ROWS, waves)
    k = np.arange(1, waves + 1)
    x = np.arange(COLUMNS)
    return np.array(
        [1e-6 * np.sum(k ** (slope / 2) * np.cos(2 * np.pi * np.outer(x, k) / COLUMNS + p), axis=1) for p in all_phases]
    )


def main():
    print({name: version(name) for name in ("numpy", "scipy")})
    z = rough_map(-2.4)
    f, p = signal.periodogram(z, 1 / STEP, window="hann", detrend="linear", axis=1)
    p = p.mean(axis=0)
    k = np.arange(1, COLUMNS // 2)
    numbers = np.floor(10 * np.log10(k) + 0.5).astype(int)
    for number in (0, 10, 15, 20, 24):
        inside = k[numbers == number]
        print(number, f"{10 ** np.mean(np.log10(f[inside])):.9e}", f"{p[inside].mean():.9e}")
    leveled = signal.detrend(z, axis=1)
    print("Pa", f"{np.mean(np.abs(leveled)):.9e}", "deviation", f"{np.abs(leveled).mean(axis=1).std():.9e}")
    print("Pq", f"{np.mean(np.sqrt(np.mean(leveled**2, axis=1))):.9e}", "Pz", f"{np.mean(np.ptp(leveled, axis=1)):.9e}")


main()
