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
            "loopback": {"drive": drive.tolist(), "recorded": recorded.tolist(), "lag": lag, "gain": gain},
            "latencies_s": latencies.tolist(),
            "percentiles_s": percentiles,
        }
    )
)
