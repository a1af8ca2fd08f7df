"""Golden values for comparisons of groups of people, from SciPy: Welch's t, its permutation, and Student's probability.

    python3 golden/differences.py > crates/piezotact-people/tests/golden/differences.json
"""

import json

import numpy as np
import scipy
from scipy import stats

# Shares of people of two groups.
GROUPS = [
    ([0.90, 0.80, 0.95, 1.00, 0.70], [0.40, 0.60, 0.55, 0.30, 0.65]),
    ([0.71, 0.69, 0.74, 0.66, 0.70, 0.73, 0.68, 0.72, 0.70, 0.67, 0.75, 0.71], [0.25, 0.75, 0.50, 0.92, 0.33]),
    ([0.25, 0.75, 0.50, 0.92, 0.33, 0.83], [0.71, 0.69, 0.74, 0.66, 0.70, 0.73, 0.68]),
    ([0.50, 0.58, 0.67, 0.75, 0.42, 0.83, 0.92], [0.33, 0.50, 0.58, 0.42, 0.67, 0.25, 0.50]),
    ([1.00, 1.00, 1.00, 0.92, 1.00], [0.33, 0.42, 0.25, 0.33, 0.50, 0.33]),
]


def welch(x, y, axis=-1):
    return np.abs(stats.ttest_ind(x, y, axis=axis, equal_var=False).statistic)


def case(a, b):
    permuted = stats.permutation_test((a, b), welch, n_resamples=np.inf, alternative="greater", vectorized=True)
    found = stats.ttest_ind(a, b, equal_var=False)
    return {
        "a": a,
        "b": b,
        "t": found.statistic,
        "freedom_welch": found.df,
        "p_permuted": permuted.pvalue,
        "p_welch": found.pvalue,
    }


print(json.dumps({
    "scipy": scipy.__version__,
    "numpy": np.__version__,
    "groups": [case(a, b) for a, b in GROUPS],
}, indent=1))
