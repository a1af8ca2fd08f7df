"""Golden values for judges: normal probabilities of two dimensions, choices and orders, from SciPy.

    python3 golden/judge.py > crates/piezotact-people/tests/golden/judge.json

Made with NumPy 2.4.6 and SciPy 1.17.1. Two alternatives are closed-form (norm.cdf). Three are SciPy's multivariate normal of two
dimensions, exact to about 1e-10. Orders of three likewise; orders of five are SciPy's quasi-random integral with an error of 1e-6.
Four alternatives are a count over 4e6 draws (standard error at most 2.5e-4). The formulas are written out again here and share
nothing with the program.
"""

import itertools
import json

import numpy as np
import scipy
from scipy.stats import multivariate_normal, norm

# The mean person.
LEVEL_REAL, LEVEL_RENDERED, BAND, LAPSE = 0.18, 0.21, 2.5 / np.sqrt(2), 0.015
LEVEL_STEP, BAND_STEP, LOOKS = 0.06 * np.sqrt(2), 2.5, 9
# Judgement 25 of a session.
NOW = 1 + 0.2 * np.exp(-25 / 10) + 0.1 * 25 / 100

TEXTURES = [  # ln rms and five bands in dB
    [0.48, -14.1, -8.3, -4.2, -3.9, -9.0],
    [0.41, -14.9, -8.8, -4.0, -4.0, -8.2],
    [0.26, -13.0, -7.0, -4.8, -4.2, -8.9],
    [-0.05, -16.0, -9.4, -3.7, -3.8, -8.0],
]
PRESENTED = [[0.44, -14.3, -8.9, -4.5, -3.5, -8.8], [0.20, -14.0, -8.0, -4.3, -4.1, -8.3]]


def both_above():
    rows = []
    for h, k in itertools.product([-2.1, -0.4, 0.0, 0.7, 2.5], repeat=2):
        for r in [-0.999, -0.95, -0.6, 0.0, 0.3, 0.9, 0.97, 0.9999]:
            p = multivariate_normal.cdf([-h, -k], cov=[[1, r], [r, 1]], abseps=1e-13, releps=1e-13, maxpts=10**7)
            rows.append([h, k, r, float(p)])
    return rows


def coordinates(t, weights):
    level, spectrum = weights
    t = np.array(t)
    return np.concatenate([[np.sqrt(level) * t[0] / LEVEL_STEP], np.sqrt(spectrum / 5) * t[1:] / BAND_STEP])


def choice(presented, alternatives, weights):
    level, spectrum = weights
    x, a = coordinates(presented, weights), [coordinates(t, weights) for t in alternatives]
    sd = NOW * np.concatenate(
        [
            [np.sqrt(level) / LEVEL_STEP * np.sqrt((LEVEL_RENDERED**2 + LEVEL_REAL**2) / LOOKS)],
            np.full(5, np.sqrt(spectrum / 5) / BAND_STEP * BAND * np.sqrt(2 / LOOKS)),
        ]
    )
    if len(a) > 3:
        draws = x + sd * np.random.default_rng(19).standard_normal((4_000_000, 6))
        nearest = np.argmin([((draws - t) ** 2).sum(1) for t in a], axis=0)
        p = np.bincount(nearest, minlength=len(a)) / len(draws)
    else:
        p = []
        for j, own in enumerate(a):
            others = [t for k, t in enumerate(a) if k != j]
            mean = np.array([((x - own) ** 2).sum() - ((x - t) ** 2).sum() for t in others])
            gradient = np.array([2 * (t - own) * sd for t in others])
            if len(others) == 1:
                p.append(norm.cdf(0, mean[0], np.linalg.norm(gradient[0])))
            else:
                scale = np.linalg.norm(gradient, axis=1)
                r = float(np.clip(gradient[0] @ gradient[1] / scale.prod(), -1 + 1e-15, 1 - 1e-15))
                p.append(
                    multivariate_normal.cdf(-mean / scale, cov=[[1, r], [r, 1]], allow_singular=True, abseps=1e-13, releps=1e-13)
                )
        p = np.array(p)
    return (LAPSE / len(a) + (1 - LAPSE) * p).tolist()


def order(levels):
    n, sd = len(levels), NOW * LEVEL_REAL / np.sqrt(LOOKS)
    difference = np.zeros((n - 1, n))
    for i in range(n - 1):
        difference[i, i], difference[i, i + 1] = -1, 1
    mean = difference @ np.array(levels)
    cov = sd**2 * difference @ difference.T
    return float(multivariate_normal.cdf(np.zeros(n - 1), mean=mean, cov=cov, abseps=1e-8, releps=1e-8, maxpts=10**7, rng=1))


WEIGHTS = {"thurstone": (1, 1), "level_only": (1, 0), "spectrum_only": (0, 1)}
CHOICES = [
    {"judge": judge, "presented": x, "alternatives": TEXTURES[:n], "probabilities": choice(x, TEXTURES[:n], WEIGHTS[judge])}
    for judge in WEIGHTS
    for n in (2, 3, 4)
    for x in PRESENTED
]
LEVELS = [[0.48, 0.41, 0.26], [0.26, 0.41, 0.48], [0.30, 0.31, 0.30], [0.48, 0.45, 0.41, 0.43, 0.36]]
print(
    json.dumps(
        {
            "made_with": {"numpy": np.__version__, "scipy": scipy.__version__},
            "both_above": both_above(),
            "choices": CHOICES,
            "orders": [{"levels": levels, "attentive": order(levels)} for levels in LEVELS],
        },
        indent=1,
    )
)
