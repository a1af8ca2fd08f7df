"""Golden values for the analysis of EEG, from MNE-Python and SciPy.

    python3 golden/eeg.py > crates/piezotact-people/tests/golden/eeg.json
    python3 golden/eeg.py positions > /tmp/positions.txt

Made with MNE-Python 1.13.2, SciPy 1.17.1 and NumPy 2.4.6. Signals are sums of sines and a linear congruential noise that the tests compute
again, so that only results are stored. `positions` prints the tables of crates/piezotact-people/src/eeg/reference/positions.rs: the 64
names of a 10-10 cap (`biosemi64`) and six of other caps at their places of `standard_1005`, in head coordinates, seen from the centre of the sphere that MNE
fits to the whole montage.
"""

import json
import sys

import mne
import numpy as np
import scipy
from mne.bem import fit_sphere_to_headshape
from mne.channels.interpolation import _make_interpolation_matrix
from mne.time_frequency import tfr_array_morlet
from scipy.stats import nct, t as student
from scipy.optimize import brentq

mne.set_log_level("ERROR")
NAMES = mne.channels.make_standard_montage("biosemi64").ch_names
OF_OTHER_CAPS = ["FT9", "FT10", "TP9", "TP10", "PO9", "PO10"]


def positions(names):
    """Unit vectors of `names`, rounded as they are stored."""
    montage = mne.channels.make_standard_montage("standard_1005")
    info = mne.create_info(montage.ch_names, 1000.0, "eeg")
    info.set_montage(montage)
    _, centre, _ = fit_sphere_to_headshape(info)
    cap = mne.create_info(names, 1000.0, "eeg")
    cap.set_montage(montage)
    found = np.array([channel["loc"][:3] for channel in cap["chs"]]) - centre
    return np.round(found / np.linalg.norm(found, axis=1, keepdims=True), 6)


def noise(n, seed):
    """Numbers from -1 to 1 that any language computes alike."""
    state, out = seed, np.empty(n)
    for i in range(n):
        state = (1664525 * state + 1013904223) % 2**32
        out[i] = state / 2**31 - 1
    return out


def signal(n, rate, seed):
    t = np.arange(n) / rate
    return 1e-6 * (8 * np.sin(2 * np.pi * 10 * t + seed) + 3 * np.sin(2 * np.pi * 50 * t) + 5 * noise(n, seed) + 20 * t)


def filters():
    x = signal(4000, 500.0, 1)
    rows = []
    for low, high in [(1.0, 40.0), (0.5, None), (None, 30.0), (8.0, 12.0), (None, 240.0)]:
        h = mne.filter.create_filter(None, 500.0, low, high)
        y = mne.filter.filter_data(x.copy(), 500.0, low, high)
        rows.append({"low": low, "high": high, "length": len(h), "taps": h[: len(h) // 2 + 1][::37].tolist(), "y": y[::100].tolist()})
    y = mne.filter.notch_filter(x.copy(), 500.0, [50.0, 100.0])
    short = mne.filter.filter_data(x[:400].copy(), 500.0, 1.0, 40.0)
    return {"rows": rows, "notch": y[::100].tolist(), "short": short[::10].tolist()}


def power():
    epochs = np.array([[signal(1000, 500.0, 10 * c + e) for c in range(2)] for e in range(3)])
    freqs = np.array([8.0, 10.0, 12.5, 20.0])
    cycles = np.array([4.0, 5.0, 5.0, 7.0])
    keep = lambda a: a.reshape(-1).tolist()
    morlet = tfr_array_morlet(epochs, 500.0, freqs, n_cycles=cycles, zero_mean=True, output="avg_power", decim=40)
    single = tfr_array_morlet(epochs, 500.0, freqs, n_cycles=cycles, zero_mean=True, output="power")
    # Band 8 to 12.5 Hz, samples 100 to 300 (0.2 s to 0.6 s from the first), epochs x channels.
    window = single[:, :, :3, 100:301].mean(axis=(2, 3))
    return {
        "freqs": freqs.tolist(), "cycles": cycles.tolist(), "morlet": keep(morlet), "window": keep(window.T),
    }


def splines():
    pos = positions(NAMES)
    volts = np.array([signal(50, 500.0, 100 + c) for c in range(64)])
    where = np.array([[0.0, 0.0, 1.0], [0.5, 0.3, 0.7], [-0.7, -0.6, 0.1], [0.1, -0.9, -0.2]])
    weights = _make_interpolation_matrix(pos, where)
    return {"where": where.tolist(), "interpolated": (weights @ volts[:, ::10]).tolist()}


def regression():
    info = mne.create_info(["Fz", "Cz", "VEOG", "HEOG"], 500.0, ["eeg", "eeg", "eog", "eog"])
    data = np.array([[signal(400, 500.0, 30 + 10 * c + e) for c in range(4)] for e in range(3)])
    data[:, 0] += 0.4 * data[:, 2] - 0.1 * data[:, 3]
    epochs = mne.EpochsArray(data, info)
    model = mne.preprocessing.EOGRegression(picks="eeg", picks_artifact="eog").fit(mne.set_eeg_reference(epochs, [])[0])
    clean = model.apply(mne.set_eeg_reference(epochs, [])[0]).get_data()
    return {"coefficients": model.coef_.reshape(-1).tolist(), "clean": clean[:, :2, ::40].transpose(1, 0, 2).reshape(-1).tolist()}


def contrast():
    a = np.array([1.0, 2.5, 3.0, 2.2, 0.7, 1.9, 2.8, 3.3, 0.2, 1.1])
    b = np.array([1.5, 2.7, 4.2, 2.1, 1.9, 2.6, 3.5, 3.2, 1.4, 1.0])
    t = scipy.stats.ttest_rel(b, a).statistic
    ends = [brentq(lambda d: nct.cdf(t, 9, d) - share, -20, 20, xtol=1e-12) / np.sqrt(10) for share in (0.975, 0.025)]
    return {"a": a.tolist(), "b": b.tolist(), "t": float(t), "d_z": float(t / np.sqrt(10)), "interval": ends}


def interval():
    """The jackknife of the logarithm of a ratio of mean powers, in %."""
    window, baseline = (np.array(contrast()[key]) for key in "ab")
    n = len(window)
    change = lambda keep: 100 * (window[keep].mean() / baseline[keep].mean() - 1)
    without = np.array([change(np.arange(n) != e) for e in range(n)])
    y = np.log1p(without / 100)
    reach = student.ppf(0.975, n - 1) * np.sqrt((n - 1) * y.var())
    ends = 100 * np.expm1(np.log1p(change(np.arange(n) >= 0) / 100) + reach * np.array([-1, 1]))
    return {"percent": float(change(np.arange(n) >= 0)), "without_each": without.tolist(), "ends": ends.tolist()}


if sys.argv[1:] == ["positions"]:
    names = NAMES + OF_OTHER_CAPS
    for name, (x, y, z) in zip(names, positions(names)):
        print(f'    ("{name}", [{x:.6f}, {y:.6f}, {z:.6f}]),')
else:
    made_with = {"mne": mne.__version__, "scipy": scipy.__version__, "numpy": np.__version__}
    print(json.dumps({
        "made_with": made_with, "filters": filters(), "power": power(), "splines": splines(),
        "regression": regression(), "contrast": contrast(), "interval": interval(),
    }, indent=0))
