"""Thresholds: the posterior of QUEST+ after one fixed sequence of answers, and how often Student's t over the pairs of a staircase's
reversals holds the truth. Constants of crates/piezotact-people/tests/adaptive.rs and docs/decisions/answers.md.

questplus 2023.1 (which psychopy wraps), numpy 2.4.6, scipy 1.17.1, xarray 2026.9.0

    pip install questplus numpy scipy xarray
    python golden/thresholds.py
"""

import math

import numpy as np
import questplus
from scipy.stats import t as student

# The grid of the library protocol detection_threshold.
LEVELS = np.arange(-40.0, -7, 2)
THRESHOLDS = np.arange(-48.0, 1, 1)
ANSWERS = [(-12, 1), (-20, 1), (-28, 0), (-24, 1), (-26, 0), (-22, 1), (-26, 1), (-28, 0),
           (-24, 0), (-20, 1), (-22, 1), (-26, 0), (-22, 0), (-18, 1), (-24, 1), (-20, 1)]


def posterior():
    run = questplus.QuestPlusWeibull(
        intensities=LEVELS, thresholds=THRESHOLDS, slopes=[1, 2, 3], lower_asymptotes=[0.5], lapse_rates=[0, 0.02, 0.04],
        responses=["correct", "wrong"], stim_scale="dB", stim_selection_method="min_entropy", param_estimation_method="mean",
    )
    for level, correct in ANSWERS:
        run.update(intensity=float(level), response="correct" if correct else "wrong")
    share = np.asarray(run.marginal_posterior["threshold"])
    mean = (share * THRESHOLDS).sum()
    sd = math.sqrt((share * (THRESHOLDS - mean) ** 2).sum())
    print("mean", mean, "SD", sd, "mode", THRESHOLDS[share.argmax()], run.param_estimate, "next", float(run.next_intensity))


def reversals(random, threshold, slope, lapse):
    """A staircase of the library protocol roughness_jnd: three down, one up, steps 4, 4 and 2 dB, 12 reversals and 30 trials."""
    level, row, last, rising, found, trials = -2.0, 0, None, 0, [], 0
    while (len(found) < 12 or trials < 30) and trials < 90:
        right = random.random() < 1 - lapse - (0.5 - lapse) * math.exp(-(10 ** (slope * (level - threshold) / 20)))
        trials += 1
        row = row + (1 if right else -1) if last == right else (1 if right else -1)
        last = right
        down, up = (3, 1) if found else (1, 1)
        if row < down and row > -up:
            continue
        turn = -1 if row >= down else 1
        if rising and rising != turn:
            found.append(level)
        rising, row = turn, 0
        level = min(max(level + turn * [4, 4, 2][min(len(found), 2)], -26.0), 0.0)
    return found


def coverage(runs=600):
    random = np.random.default_rng(1)
    target, held, errors = 0.5 ** (1 / 3), 0, []
    for _ in range(runs):
        slope, lapse = random.choice([1.0, 2.0, 3.0]), random.choice([0, 0.04])
        threshold = random.uniform(-20, -4)
        truth = threshold + 20 / slope * math.log10(-math.log((1 - lapse - target) / (0.5 - lapse)))
        found = np.array(reversals(random, threshold, slope, lapse)[4:])
        pairs = found[len(found) % 2:].reshape(-1, 2).mean(1)
        if len(pairs) < 2:
            continue
        half = student.ppf(0.975, len(pairs) - 1) * pairs.std(ddof=1) / math.sqrt(len(pairs))
        errors.append(pairs.mean() - truth)
        held += abs(errors[-1]) <= half
    print("pairs of reversals hold", held / len(errors), "bias", np.mean(errors), "spread", np.std(errors, ddof=1))


posterior()
coverage()
