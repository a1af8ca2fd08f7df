"""Golden values for the gesture filter, the features of a stroke and the statistics of comparisons, from SciPy.

    python3 golden/touch.py > crates/piezotact/tests/golden/touch.json

Made with SciPy 1.17.1 and NumPy 2.4.6. The signal is a formula that the test computes too.
"""

import json

import numpy as np
import scipy
from scipy import signal, stats

RATE = 5000.0
N = 6000
i = np.arange(N)
t = i / RATE
x = (
    np.sin(2 * np.pi * 55.0 * t)
    + 0.5 * np.sin(2 * np.pi * 180.0 * t + 1.0)
    + 0.3 * ((i * i * 7919 % 1000) / 1000.0 - 0.5)
    + 2.0 * np.sin(2 * np.pi * 1.2 * t)
    + 0.7
)
fz = 0.2 + 0.02 * np.sin(2 * np.pi * 0.9 * t)
fx = 0.03 * np.cos(2 * np.pi * 2.1 * t)
fy = 0.12 + 0.01 * np.sin(2 * np.pi * 3.3 * t)



def high_passed_both_ways(x, order, cutoff):
    """sosfiltfilt over a signal continued, for order/2 periods of the cut-off, by point reflection about the end of a straight
    line through its last half period."""
    sections = signal.butter(order, cutoff, "highpass", fs=RATE, output="sos")
    pad = min(int(np.ceil(0.5 * order * RATE / cutoff)), len(x) - 1)
    edge = int(0.5 * RATE / cutoff + 0.5)
    line = lambda part: np.polyval(np.polyfit(np.arange(edge), part, 1), 0)
    first, last = line(x[:edge]), line(x[::-1][:edge])
    longer = np.concatenate([2 * first - x[1 : pad + 1][::-1], x, 2 * last - x[-pad - 1 : -1][::-1]])
    return signal.sosfiltfilt(sections, longer, padlen=0)[pad : pad + len(x)]


high_passed = {}
for order, cutoff in ((2, 5.0), (4, 5.0), (4, 20.0), (6, 8.0)):
    y = high_passed_both_ways(x, order, cutoff)
    high_passed[f"{order} {cutoff:g}"] = [float(v) for v in y[::250]]

y = high_passed_both_ways(x, 4, 5.0)
f, psd = signal.welch(y, RATE, nperseg=1024)
step = f[1]


def power(low, high):
    return float(psd[(f >= low) & (f < high)].sum() * step)


def level_db(f, psd, low, high, threshold_db_um):
    """Power over the squared threshold, straight lines through the four-channel model of Bolanowski et al. (1988)."""
    inside = (f >= low) & (f < high)
    threshold = 1e-6 * 10 ** (threshold_db_um(f[inside]) / 20) * (2 * np.pi * f[inside]) ** 2 / np.sqrt(2)
    return float(10 * np.log10((psd[inside] / threshold**2).sum() * f[1]))


# Low frequencies have segments of 1 s. The filter passes from 7.5 Hz on; one line more holds the main lobe of a tone there.
f_low, psd_low = signal.welch(y, RATE, nperseg=5000)
with np.errstate(divide="ignore"):
    gain = 1 / (1 + (np.tan(np.pi * 5.0 / RATE) / np.tan(np.pi * f_low / RATE)) ** 8)
psd_low /= np.maximum(gain**2, 0.25)
meissner = level_db(f_low, psd_low, 6.5, 40, lambda f: np.clip(28 - 6 * np.log2(f / 3), 6, 28))
pacini = level_db(f, psd, 40, 500, lambda f: -20 + np.where(f < 250, 12 * np.log2(250 / f), 10 * np.log2(f / 250)))

band = (f >= 10) & (f < 1000)
centroid = (f[band] * psd[band]).sum() / psd[band].sum()
spread = np.sqrt((f[band] ** 2 * psd[band]).sum() / psd[band].sum() - centroid**2)
mean = y.mean()
rms = np.sqrt(np.mean((y - mean) ** 2))
peak = abs(y - mean).max()
powers = ((y - mean)[: N // 500 * 500].reshape(-1, 500) ** 2).mean(axis=1)
levels = 10 * np.log10(np.maximum(powers, 0.01 * powers.mean()))
ratio = np.hypot(fx, fy) / fz
fft = 2 * abs(np.fft.rfft(y - mean)) / N
fft[0] /= 2
fft[-1] /= 2

a = [1.0, 2.0, 2.0, 3.5, 7.0, 7.0, 7.0, 9.0]
b = [2.0, 1.0, 4.0, 3.0, 8.0, 9.0, 7.5, 7.5]
line = stats.linregress(np.log10(a), np.log10(b))
reach = stats.t.ppf(0.975, len(a) - 2) * line.stderr
long_a = [3.1, 0.2, 5.5, 4.0, 4.0, 9.1, 7.7, 6.0, 2.2, 8.8, 1.0, 5.0]
long_b = [1.0, 2.5, 4.4, 2.0, 6.1, 5.0, 9.9, 3.3, 3.3, 7.0, 0.5, 8.0]
# Every order of the eight values, ties and all.
exact = stats.permutation_test(
    (a,),
    lambda x: stats.spearmanr(x, b).statistic,
    permutation_type="pairings",
    n_resamples=np.inf,
)
paired = stats.ttest_rel(b, a)
interval = paired.confidence_interval(0.95)

print(
    json.dumps(
        dict(
            scipy=scipy.__version__,
            numpy=np.__version__,
            high_passed=high_passed,
            rms=float(rms),
            peak=float(peak),
            kurtosis=float(stats.kurtosis(y, fisher=False)),
            level_spread_db=float(levels.std(ddof=1)),
            centroid_hz=float(centroid),
            spread_hz=float(spread),
            receptor_power=[power(2, 16), power(3, 40), power(40, 500), power(100, 500)],
            receptor_level_db=[meissner, pacini],
            friction=[float(ratio.mean()), float(ratio.std(ddof=1)), float(np.median(ratio))],
            force=[float(fz.mean()), float(fz.std(ddof=1))],
            fft_55_hz=float(fft[round(55.0 * N / RATE)]),
            psd_every_40=[float(v) for v in psd[::40]],
            a=a,
            b=b,
            spearman=float(stats.spearmanr(a, b).statistic),
            spearman_p=float(np.mean(abs(exact.null_distribution) >= abs(exact.statistic) - 1e-12)),
            long_a=long_a,
            long_b=long_b,
            long_spearman=[float(v) for v in stats.spearmanr(long_a, long_b)],
            slope_p=float(line.pvalue),
            share_intervals=[[k, n, *(float(v) for v in stats.binomtest(k, n).proportion_ci())] for k, n in ((0, 5), (4, 4), (17, 20), (36, 36))],
            slope=float(line.slope),
            slope_interval=[float(line.slope - reach), float(line.slope + reach)],
            intercept=float(line.intercept),
            r_squared=float(line.rvalue**2),
            paired=[float(np.mean(np.subtract(b, a))), float(interval.low), float(interval.high), float(paired.statistic), float(paired.pvalue)],
        )
    )
)
