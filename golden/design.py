"""Reference values of a campaign's design: crates/piezotact-people/tests/golden/design.json.

Power of the paired t-test (noncentral t), right answers by chance (binomial; permutations enumerated or by derangements),
spread of Kendall's tau by the Mahonian numbers, and the bound of Clopper and Pearson. Made with NumPy 2.4.6 and SciPy 1.17.1:

    python3 golden/design.py > crates/piezotact-people/tests/golden/design.json
"""

import itertools
import json
import math

import numpy as np
import scipy
from scipy import stats


def power(n, d):
    df, critical = n - 1, stats.t.ppf(0.975, n - 1)
    shift = d * math.sqrt(n)
    return stats.nct.sf(critical, df, shift) + stats.nct.cdf(-critical, df, shift)


def permuted(n):
    counts = [0] * (n + 1)
    for order in itertools.permutations(range(n)):
        counts[sum(i == j for i, j in enumerate(order))] += 1
    return np.array(counts) / math.factorial(n)


def tau_sd(n):
    counts = [1]
    for k in range(2, n + 1):
        counts = np.convolve(np.array(counts, object), np.ones(k, object))
    total, pairs = math.factorial(n), n * (n - 1) // 2
    return math.sqrt(sum(c / total * (1 - 2 * i / pairs) ** 2 for i, c in enumerate(counts)))


ten = np.array([1.0])
for _ in range(10):
    ten = np.convolve(ten, permuted(3))
print(
    json.dumps(
        {
            "made_with": {"numpy": np.__version__, "scipy": scipy.__version__},
            "power": [[n, d, power(n, d)] for n in (5, 10, 20, 34) for d in (0.2, 0.5, 0.8, 1.0)],
            "permutations": {str(n): permuted(n).tolist() for n in (2, 3, 4, 7)},
            "ten_triplets_permuted": ten.tolist(),
            "ten_triplets_independent": stats.binom.pmf(np.arange(31), 30, 1 / 3).tolist(),
            "tau_sd": [[n, tau_sd(n)] for n in (3, 6, 14)],
        },
        indent=1,
    )
)
