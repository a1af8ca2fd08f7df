"""Golden values for permutation tests, Holm's adjustment and Welch's limits, from SciPy.

    python3 golden/discrimination.py > crates/piezotact/tests/golden/discrimination.json

Made with SciPy 1.17.1 and NumPy 2.4.6. The statistic is the absolute difference of two means; `permutation_test` is asked for all
divisions of small groups and for 99 999 of large ones. Paired differences change their signs (`permutation_type="samples"`) with the
absolute mean as the statistic. Holm's adjustment is written out from its definition; Welch's degrees of
freedom are those of `scipy.stats.ttest_ind(equal_var=False)`, applied to powers and brought to JND of 1.58 dB by the derivative
of 10·log10.
"""

import json

import numpy as np
import scipy
from scipy import stats

random = np.random.Generator(np.random.PCG64(13))


def statistic(a, b, axis):
    return np.abs(np.mean(a, axis=axis) - np.mean(b, axis=axis))


def case(n, m, shift, draws):
    a, b = random.standard_normal(n), random.standard_normal(m) * 1.5 + shift
    found = stats.permutation_test(
        (a, b), statistic, alternative="greater", n_resamples=draws, vectorized=True, rng=random, batch=10_000
    )
    return {"a": a.tolist(), "b": b.tolist(), "p": float(found.pvalue)}


def holm(p):
    order = np.argsort(p)
    steps = np.maximum.accumulate(np.minimum(1.0, np.asarray(p)[order] * (len(p) - np.arange(len(p)))))
    adjusted = np.empty(len(p))
    adjusted[order] = steps
    return adjusted.tolist()


def welch(n, m, gain):
    a, b = random.gamma(20.0, 5.0, n), gain * random.gamma(12.0, 7.0, m)
    def relative(x):
        return stats.sem(x) / np.mean(x)
    ea, eb = relative(a), relative(b)
    freedom = (ea**2 + eb**2) ** 2 / (ea**4 / (len(a) - 1) + eb**4 / (len(b) - 1))
    check = stats.ttest_ind(a / a.mean(), b / b.mean(), equal_var=False)
    assert abs(check.df - freedom) < 1e-9 * freedom
    reach = stats.t.ppf(0.975, freedom) * np.hypot(ea, eb) * 10.0 / np.log(10.0) / 1.58
    return {"a": a.tolist(), "b": b.tolist(), "reach": float(reach)}


def flipped(n, shift, draws):
    d = random.standard_normal(n) + shift
    found = stats.permutation_test(
        (d, -d), lambda a, b, axis: np.abs(np.mean(a, axis=axis)), permutation_type="samples", alternative="greater",
        n_resamples=draws, vectorized=True, rng=random, batch=10_000,
    )
    return {"d": d.tolist(), "p": float(found.pvalue)}


p_values = [random.random(n) ** 2 for n in (1, 6, 15)]
print(
    json.dumps(
        {
            "scipy": scipy.__version__,
            "numpy": np.__version__,
            "exhaustive": [case(n, m, s, np.inf) for n, m, s in ((3, 3, 1.0), (4, 6, 0.5), (7, 7, 1.5), (8, 8, 0.2))],
            "sampled": [case(n, m, s, 99_999) for n, m, s in ((15, 15, 0.8), (10, 20, 0.3), (12, 9, 1.4))],
            "holm": [[p.tolist(), holm(p)] for p in p_values],
            "welch": [welch(n, m, g) for n, m, g in ((15, 15, 2.0), (5, 12, 1.3), (3, 4, 0.5))],
            "signs": [flipped(n, s, d) for n, s, d in ((5, 1.5, np.inf), (10, 0.7, np.inf), (14, 0.3, np.inf), (24, 0.5, 99_999))],
        }
    )
)
