"""Golden values for what a sound device does to a signal, from SciPy and NumPy: a tone by non-linear least squares, the delay of a loopback by
correlation, percentiles of latencies, and the sensitivity of a sensor on a calibrator.

    python3 golden/sound.py > crates/piezotact/tests/golden/sound.json
"""

import json

import numpy as np
import scipy
from scipy import optimize, signal

RATE = 8000
rng = np.random.default_rng(92)

# A tone of 159.2 Hz beside its mean, another tone and noise.
n, hz = 2400, 159.2
t = np.arange(n) / RATE
samples = np.round(0.11 + 0.2 * np.cos(2 * np.pi * hz * t - 2.1) + 0.01 * np.sin(2 * np.pi * 1000 * t) + 2e-3 * rng.standard_normal(n), 6)
model = lambda p: p[0] * np.cos(2 * np.pi * hz * t + p[1]) + p[2] - samples
fit = optimize.least_squares(model, [0.15, -2.0, 0.0], xtol=1e-15, ftol=1e-15, gtol=1e-15)
amplitude, phase, mean = fit.x
residual = np.sqrt(np.mean(fit.fun**2))

# A loopback: 57 samples late, inverted, a little filtered, with noise.
drive = np.round(0.3 * rng.standard_normal(800), 6)
recorded = np.zeros(1000)
recorded[57 : 57 + 800] = -0.42 * drive
recorded = np.round(signal.lfilter([0.05, 0.9, 0.05], [1.0], recorded) + 0.01 * rng.standard_normal(1000), 6)
correlation = signal.correlate(recorded - recorded.mean(), drive)
lags = signal.correlation_lags(len(recorded), len(drive))
lag = int(lags[np.argmax(np.abs(correlation))])
overlap = recorded[lag : lag + 800]
gain = np.dot(drive, overlap) / np.dot(drive, drive)

# The same tone 1.3 % higher than stated: frequency, amplitude, phase and mean by non-linear least squares.
higher = np.round(0.11 + 0.2 * np.cos(2 * np.pi * 1.013 * hz * t - 2.1) + 2e-3 * np.random.default_rng(93).standard_normal(n), 6)
four = lambda p: p[0] * np.cos(2 * np.pi * p[3] * t + p[1]) + p[2] - higher
near = optimize.least_squares(four, [0.15, -2.0, 0.0, 1.012 * hz], xtol=1e-15, ftol=1e-15, gtol=1e-15, x_scale=[0.1, 1.0, 0.1, 100.0])

# A burst, 31.37 samples late by the phases of its spectrum, inverted, with noise before and after it: delay and gain by least squares over
# the spectrum within the length of the burst.
burst = np.round(signal.lfilter([0.25, 0.5, 0.25], [1.0], 0.1 * np.random.default_rng(94).standard_normal(1024)) * np.hanning(1024), 6)
bins = np.fft.rfft(np.concatenate([burst, np.zeros(1024)]))
turn = np.exp(-2j * np.pi * np.arange(1025) / 2048 * 31.37)
late = -0.37 * np.fft.irfft(bins * turn, 2048)
heard = np.round(late + 0.001 * np.random.default_rng(95).standard_normal(2048), 6)
window = np.zeros(2048)
window[:1024] = heard[31 : 31 + 1024] - heard[31 : 31 + 1024].mean()
cross = np.fft.rfft(window) * np.conj(np.fft.rfft(burst, 2048))
omega = 2 * np.pi * np.arange(1025) / 2048
weight = np.abs(cross[1:])
fraction = -np.sum(weight * omega[1:] * np.angle(-cross[1:])) / np.sum(weight * omega[1:] ** 2)
burst_gain = np.sum((cross * np.exp(1j * omega * fraction)).real) / np.sum(np.abs(np.fft.rfft(burst, 2048)) ** 2)

latencies = np.round(0.02 + 0.001 * rng.standard_normal(73), 7)
percentiles = [float(np.percentile(latencies, q, method="inverted_cdf")) for q in (50, 95, 99)]

print(
    json.dumps(
        {
            "made_with": f"NumPy {np.__version__}, SciPy {scipy.__version__}",
            "rate_hz": RATE,
            "tone": {
                "hz": hz,
                "samples": samples.tolist(),
                "rms": abs(amplitude) / np.sqrt(2),
                "phase_rad": phase,
                "mean": mean,
                "residual_rms": residual,
            },
            "near": {
                "samples": higher.tolist(),
                "hz": abs(near.x[3]),
                "rms": abs(near.x[0]) / np.sqrt(2),
                "residual_rms": np.sqrt(np.mean(near.fun**2)),
            },
            "burst": {"drive": burst.tolist(), "recorded": heard.tolist(), "lag": 31, "fraction": fraction, "gain": burst_gain, "true_fraction": 0.37, "true_gain": -0.37},
            "loopback": {"drive": drive.tolist(), "recorded": recorded.tolist(), "lag": lag, "gain": gain},
            "latencies_s": latencies.tolist(),
            "percentiles_s": percentiles,
        }
    )
)
