"""Golden values of a panel: the hands of three people (SkinSource, input location 7), each by its strongest axis, once more
with NumPy 2.4.6: bundle, both averages, leave-one-out penalty; and the error of a new person, with SciPy 1.17.1.

    python3 golden/panel.py ../shared/data/frf/skinsource > crates/piezotact-app/tests/golden/panel.json

The files hold impulse responses, 522 samples x 72 places x 3 axes, samples first, 32-bit floats at 1300 Hz. The Rust test
reads them and transforms them by a sum of its own.
"""

import json
import sys
from pathlib import Path

import numpy as np
import scipy
from scipy.stats import t as student

RATE_HZ, SAMPLES = 1300.0, 522
BAND = (20.0, 600.0)
PARTS = [(20.0, 50.0), (50.0, 100.0), (100.0, 250.0), (250.0, 500.0), (500.0, 600.0)]

folder = Path(sys.argv[1])
hands, chosen = [], []
for model in (1, 2, 3):
    axes = np.fromfile(folder / f"model-{model}-location-07.f32", "<f4").astype(float).reshape(-1, SAMPLES)
    strongest = int(np.argmax((axes**2).mean(axis=1)))
    chosen.append(strongest)
    hands.append(np.fft.rfft(axes[strongest]))
hands = np.array(hands)
hz = np.fft.rfftfreq(SAMPLES, 1 / RATE_HZ)
db = 20 * np.log10(np.abs(hands))


def rms(x):
    return float(np.sqrt(np.mean(x**2)))


def within(low, high):
    return (hz >= low) & (hz <= high)


def log_mean(h):
    """Mean of log magnitudes, and the phase of the sum with the mean of the phases about it."""
    total = h.sum(axis=0)
    about = np.angle(h * np.conj(total)).mean(axis=0)
    return np.exp(np.log(np.abs(h)).mean(axis=0)) * np.exp(1j * (np.angle(total) + about))


def penalties(mean):
    found = []
    for i in range(len(hands)):
        others = mean(np.delete(hands, i, axis=0))
        off = (20 * np.log10(np.abs(others)) - db[i])[within(*BAND)]
        found.append({"db_rms": rms(off), "db_max": float(np.abs(off).max())})
    return found


def deviation(low, high):
    inside = np.flatnonzero(within(low, high))
    spread = np.ptp(db[:, inside], axis=0)
    at = int(np.argmax(spread))
    sd = db[:, inside].std(axis=0, ddof=1)
    return {"max_deviation_db": float(spread[at]), "at_hz": float(hz[inside[at]]), "spread_rms_db": rms(sd)}


def prediction(errors):
    """The 95 % interval of the error of one new person, and of the error of a typical person by the average of very many, with SciPy."""
    roots, n = np.sqrt(errors), len(errors)
    reach = student.ppf(0.975, n - 1) * roots.std(ddof=1) * np.sqrt((n + 1) / (n - 1))
    middle = roots.mean() * (1 - 1 / n**2) ** 0.25
    new = [max(middle - reach, 0) ** 2, (middle + reach) ** 2]
    typical = [max(roots.mean() + sign * reach / np.sqrt(n), 0) ** 2 * np.sqrt(1 - 1 / n) for sign in (0, -1, 1)]
    return [float(db) for db in new + typical]


def learning(n):
    """The mean over people and over sets of n others of the rms error of the mean of log magnitudes."""
    inside = within(*BAND)
    costs = []
    for i in range(3):
        others = [j for j in range(3) if j != i]
        sets = [[j] for j in others] if n == 1 else [others]
        costs.append(np.mean([rms(db[s].mean(axis=0)[inside] - db[i][inside]) for s in sets]))
    return float(np.mean(costs))


log, complex_mean = log_mean(hands), hands.mean(axis=0)
inside = within(*BAND)
difference = 20 * np.log10(np.abs(complex_mean) / np.abs(log))
json.dump(
    {
        "made_with": f"NumPy {np.__version__}, SciPy {scipy.__version__}",
        "axes": chosen,
        "whole": deviation(*BAND),
        "parts": [{"band_hz": part} | deviation(*part) for part in PARTS],
        "log_magnitude_db": (20 * np.log10(np.abs(log)))[inside].tolist(),
        "complex_db": (20 * np.log10(np.abs(complex_mean)))[inside].tolist(),
        "penalties_log_magnitude": penalties(log_mean),
        "penalties_complex": penalties(lambda h: h.mean(axis=0)),
        "difference_mean_db": float(difference[inside].mean()),
        "difference_lowest_db": float(difference[inside].min()),
        "learning_db": [learning(1), learning(2)],
        # As crates/piezotact/src/panel/prediction.rs has it.
        "prediction_db": prediction([1.2, 0.4, 2.6, 1.9, 0.8, 1.1]),
    },
    sys.stdout,
    indent=1,
)
print()
