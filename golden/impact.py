"""Golden values for impact tests: a structure of six degrees of freedom hit by half-sine pulses, from SciPy.

    python3 golden/impact.py > crates/piezotact/tests/golden/impact.json

Made with Python 3.11, NumPy 2.4.6 and SciPy 1.17.1. The motion is that of the matrix exponential, from sample to sample and
exactly at both ends of a pulse; the Rust test computes it in closed form. References are discrete transforms of segments cut at the
known times, with a rectangular window or exp(-sigma t), and the analytic inertance.
"""

import json

import numpy as np
import scipy
from scipy.linalg import expm

RATE = 51_200
# Natural frequency in Hz, damping ratio, modal constant in 1/kg.
MODES = [
    (120.3, 0.020, 1.2),
    (231.7, 0.015, 0.8),
    (412.9, 0.012, 1.0),
    (698.1, 0.010, 0.6),
    (1103.4, 0.008, 0.9),
    (1695.2, 0.008, 0.5),
]
# Onset in s, duration in s, peak in N.
HITS = [
    (0.3000071, 0.00061, 92.0),
    (1.3500013, 0.00058, 118.0),
    (2.3200179, 0.00064, 74.0),
    (3.4100037, 0.00060, 103.0),
    (4.4300111, 0.00057, 131.0),
]
SECONDS = 5.4
NOISE = {"force_n": 0.02, "response_m_per_s2": 0.4}
SEGMENT = 40_960
BEFORE = 200
SHORT = 8_192
SIGMA = 45.0
SINGLE_NOISE = {"force_n": 0.02, "response_m_per_s2": 0.05}

state = 52


def uniform():
    global state
    state = (state * 6364136223846793005 + 1442695040888963407) % 2**64
    return (state >> 11) / 2**53


def normal():
    return (uniform() + uniform() + uniform() + uniform() - 2.0) * 3**0.5


def system(duration):
    """q'' + 2 zeta w q' + w^2 q = f of every mode, and f itself as an oscillator."""
    n = 2 * len(MODES)
    a = np.zeros((n + 2, n + 2))
    for k, (hz, zeta, _) in enumerate(MODES):
        w = 2 * np.pi * hz
        a[2 * k, 2 * k + 1] = 1
        a[2 * k + 1, 2 * k : 2 * k + 2] = [-w * w, -2 * zeta * w]
        a[2 * k + 1, n] = 1
    a[n, n + 1] = 1
    a[n + 1, n] = -((np.pi / duration) ** 2)
    return a


def simulate(hits, seconds):
    count = round(seconds * RATE)
    n = 2 * len(MODES)
    z = np.zeros(n + 2)
    force, response = np.zeros(count), np.zeros(count)
    constants = np.array([a for _, _, a in MODES])
    w = 2 * np.pi * np.array([hz for hz, _, _ in MODES])
    zeta = np.array([d for _, d, _ in MODES])
    events = sorted([(t, "on", d, p) for t, d, p in hits] + [(t + d, "off", d, p) for t, d, p in hits])
    duration = hits[0][1]
    step = expm(system(duration) / RATE)
    for i in range(count):
        force[i] = z[n]
        response[i] = constants @ (z[n] - w**2 * z[0:n:2] - 2 * zeta * w * z[1:n:2])
        now, end = i / RATE, (i + 1) / RATE
        if not (events and events[0][0] <= end):
            z = step @ z
            continue
        while events and events[0][0] <= end:
            at, kind, own, peak = events.pop(0)
            z = expm(system(duration) * (at - now)) @ z
            now = at
            z[n:] = 0.0
            if kind == "on":
                duration = own
                z[n + 1] = peak * np.pi / own
        z = expm(system(duration) * (end - now)) @ z
        step = expm(system(duration) / RATE)
    return force, response


def noisy(force, response, noise):
    f, y = force.copy(), response.copy()
    for i in range(len(f)):
        f[i] += noise["force_n"] * normal()
        y[i] += noise["response_m_per_s2"] * normal()
    return f, y


def inertance(s):
    h = np.zeros_like(s)
    for hz, zeta, a in MODES:
        w = 2 * np.pi * hz
        h += a * s * s / (s * s + 2 * zeta * w * s + w * w)
    return h


def spectra(force, response, hits, segment, sigma):
    xx, yy, xy = 0.0, 0.0, 0.0
    decay = np.exp(-sigma * np.arange(segment) / RATE)
    for at, _, _ in hits:
        i = round(at * RATE) - BEFORE
        x = np.fft.rfft(force[i : i + segment] * decay)
        y = np.fft.rfft(response[i : i + segment] * decay)
        xx, yy, xy = xx + abs(x) ** 2, yy + abs(y) ** 2, xy + np.conj(x) * y
    return xx, yy, xy


def lines(segment, low, high, step):
    hz = np.fft.rfftfreq(segment, 1 / RATE)
    chosen = np.flatnonzero((hz >= low) & (hz <= high))
    return chosen[::step], hz


clean = simulate(HITS, SECONDS)
force, response = noisy(*clean, NOISE)

xx, yy, xy = spectra(force, response, HITS, SEGMENT, 0.0)
k, hz = lines(SEGMENT, 10.0, 2200.0, 7)
true = inertance(2j * np.pi * hz)
rectangular = {
    "hz": hz[k].tolist(),
    "real": (xy / xx)[k].real.tolist(),
    "imaginary": (xy / xx)[k].imag.tolist(),
    "coherence": (abs(xy) ** 2 / (xx * yy))[k].tolist(),
    "true_real": true[k].real.tolist(),
    "true_imaginary": true[k].imag.tolist(),
}

xx, yy, xy = spectra(*clean, HITS, SHORT, SIGMA)
k, hz = lines(SHORT, 10.0, 2200.0, 2)
damped = inertance(SIGMA + 2j * np.pi * hz)
exponential = {
    "hz": hz[k].tolist(),
    "real": (xy / xx)[k].real.tolist(),
    "imaginary": (xy / xx)[k].imag.tolist(),
    "true_real": damped[k].real.tolist(),
    "true_imaginary": damped[k].imag.tolist(),
}

json.dump(
    {
        "made_with": f"NumPy {np.__version__}, SciPy {scipy.__version__}",
        "rate_hz": RATE,
        "modes": MODES,
        "hits": HITS,
        "seconds": SECONDS,
        "noise": NOISE,
        "single_noise": SINGLE_NOISE,
        "segment": SEGMENT,
        "short_segment": SHORT,
        "damping_per_s": SIGMA,
        "clean_force": clean[0][15360:15400].tolist(),
        "clean_response": clean[1][15360:17360:40].tolist(),
        "noisy_force_sum": float(np.sum(force)),
        "rectangular": rectangular,
        "exponential": exponential,
    },
    __import__("sys").stdout,
)
