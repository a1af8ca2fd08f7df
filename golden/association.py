"""Golden values for association matrices, from SciPy and statsmodels: exact, score and clustered intervals, Kendall's tau_b.

    python3 golden/association.py > crates/piezotact-people/tests/golden/association.json
"""

import json

import numpy as np
import scipy
import statsmodels
import statsmodels.api as sm
from scipy import stats
from statsmodels.stats.proportion import proportion_confint

SHARES = [(10, 10), (7, 10), (30, 30), (0, 12), (1, 30), (59, 240)]
# (declared, presented) of each participant.
CLUSTERS = [
    [(3, 12), (9, 12), (12, 12), (6, 12), (11, 12), (2, 12), (8, 12), (10, 12), (5, 12), (7, 12)],
    [(1, 3), (0, 3), (2, 3), (3, 3)],
    [(1, 6), (1, 6), (1, 6)],
    [(4, 5), (2, 9), (7, 7), (0, 2), (3, 4)],
    [(6, 6), (6, 6), (6, 6), (6, 6), (6, 6)],
    [(0, 4), (0, 3), (1, 5), (0, 6), (2, 6)],
    [(5, 5), (0, 5), (0, 5), (0, 5)],
]
ORDERS = [
    (list(range(14)), list(range(1, 14)) + [0]),
    (list(range(6)), [5, 4, 3, 2, 1, 0]),
    ([1, 2, 2, 3, 4, 4, 5], [2, 1, 3, 3, 5, 4, 4]),
    ([0, 1, 2, 3, 4], [2, 0, 1, 4, 3]),
]


def exact(p, n):
    """The interval of R's svyciprop(method = "beta"): binomial with n that need not be whole."""
    x = p * n
    low = 0.0 if x <= 0 else stats.beta.ppf(0.025, x, n - x + 1)
    high = 1.0 if x >= n else stats.beta.ppf(0.975, x + 1, n - x)
    return [low, high]


def clustered(people):
    x = np.array([a for a, _ in people], float)
    n = np.array([b for _, b in people], float)
    k, total = len(people), n.sum()
    p = x.sum() / total
    most = total
    if ((x > 0) if p <= 0.5 else (x < n)).sum() < 3:
        most = total / (1 + ((n * n).sum() / total - 1) * 0.2)
    # statsmodels' sandwich of the mean of all answers, clustered by participant, with the correction k / (k - 1) alone.
    answers = np.concatenate([[1.0] * a + [0.0] * (b - a) for a, b in people])
    groups = np.concatenate([[i] * b for i, (_, b) in enumerate(people)])
    fit = sm.OLS(answers, np.ones_like(answers)).fit(
        cov_type="cluster", cov_kwds={"groups": groups, "use_correction": False}
    )
    variance = fit.bse[0] ** 2 * k / (k - 1)
    ratio = (stats.t.ppf(0.975, total - 1) / stats.t.ppf(0.975, k - 1)) ** 2
    # Participants with the same share have no variance.
    effective = most if variance < 1e-15 else min(p * (1 - p) / variance * ratio, most)
    return {"people": people, "share": p, "effective": effective, "interval": exact(p, effective)}


def interval(x, n, method):
    return list(stats.binomtest(x, n).proportion_ci(method=method))


for x, n in SHARES:
    both = proportion_confint(x, n, method="beta")
    assert np.allclose(both, interval(x, n, "exact"), atol=1e-12)

print(
    json.dumps(
        {
            "made_by": f"SciPy {scipy.__version__}, statsmodels {statsmodels.__version__}, golden/association.py",
            "shares": [
                {"declared": x, "presented": n, "exact": interval(x, n, "exact")}
                for x, n in SHARES
            ],
            "clustered": [clustered(people) for people in CLUSTERS],
            "tau_b": [{"a": a, "b": b, "tau": stats.kendalltau(a, b).statistic} for a, b in ORDERS],
        },
        indent=1,
    )
)
