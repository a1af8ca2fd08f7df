"""Other models of how far vibrations are apart, in just-noticeable differences (JND), for `./x bench S1`.

    python3 bench/rivals.py FOLDER KEY …

Reads FOLDER/KEY.a.f64 and FOLDER/KEY.b.f64, accelerations of the skin in m/s² at 8 kHz, and prints one line of JSON: by key the JND of

two_channel  level, modulation bands and pitch of two channels, without anything that is known of chance, brief events or pulses: the
             model that the score began with. Displacement over threshold: Pacinian -20 dB re 1 µm at 250 Hz, 12 dB an octave below and
             9 above; rapidly adapting 28 dB at 3 Hz falling by 5 dB an octave to 60 Hz, 12 dB an octave above. Envelopes with two poles of
             4 or 8 ms, levels 10·lg(1 + e), forward masking from 0.6 of the level to 0.2 with 40 or 100 ms, added as power. Level: rms of
             the difference of levels smoothed by two poles of 40 ms over 2.2 dB, larger channel. Modulation in bands at 3-90 Hz, Q 1, R the
             rms: (R1² - R2²)² / (s² (s² + R1² + R2²)), s 0.28-0.6 dB. Pitch: |ln f1/f2| / ln 1.2, f the centroid of weighted power.
             Duration: |ln| / ln 1.15. The root of the sum of squares.
segments     intensity in segments of time (Cao & Konyo 2018, EuroHaptics): the power over the Pacinian threshold in segments of 8 ms (a
             third of a period at 40 Hz); the rms of the difference of levels 10·lg(1 + e), over 2.2 dB. The carrier does not count.

Both state one number and no interval: above 1 JND they say that people tell the two apart, up to 1 that they do not.
"""

import json
import math
import pathlib
import sys

import numpy as np
from scipy.signal import lfilter

FS = 8000.0
STEP = 8  # levels at 1 kHz
LEVEL_JND_DB = 2.2
BANDS = ((3, 0.60), (6, 0.45), (12, 0.35), (24, 0.28), (48, 0.35), (90, 0.60))


def threshold(f, channel):
    """Displacement at threshold, m."""
    if channel == "P":
        db = np.where(f < 250, -20 + 12 * np.log2(250 / f), -20 + 9 * np.log2(f / 250))
    else:
        db = np.where(f < 60, 28 - 5 * np.log2(f / 3), 28 - 5 * math.log2(20) + 12 * np.log2(f / 60))
    return 1e-6 * 10 ** (db / 20)


def poles(e, tau, rate, count=2):
    a = math.exp(-1 / (tau * rate))
    for _ in range(count):
        e = lfilter([1 - a], [1, -a], e)
    return e


def weighted(x, channel):
    """The displacement of `x` over threshold; its spectrum."""
    spectrum = np.fft.rfft(x)
    f = np.maximum(np.fft.rfftfreq(len(x), 1 / FS), 1.0)
    spectrum = spectrum / (2 * np.pi * f) ** 2 / threshold(f, channel) * (f >= 5) * math.sqrt(2)
    return np.fft.irfft(spectrum, len(x)), np.abs(spectrum) ** 2, f


def tailed(level, tau):
    out, fast, slow = np.empty_like(level), 0.0, 0.0
    a, b = math.exp(-1e-3 / tau), math.exp(-1e-3)
    for i, l in enumerate(level):
        out[i] = fast + slow
        slow = max(0.2 * l, slow * b)
        fast = max(0.6 * l - slow, fast * a, 0.0)
    return 10 * np.log10(10 ** (level / 10) + 10 ** (out / 10) - 1)


def felt(x):
    """Levels by channel, dB; band modulation by channel; centroid of ln f; duration, s."""
    levels, bands, power = [], [], 0.0
    for channel, tau, tail in (("RA", 0.008, 0.100), ("P", 0.004, 0.040)):
        w, spectrum, f = weighted(x, channel)
        power = power + spectrum
        level = 10 * np.log10(1 + poles(w * w, tau, FS)[::STEP])
        levels.append(level)
        l = tailed(level, tail)
        z = np.fft.rfft(l - l.mean())
        g = np.fft.rfftfreq(len(l), 1e-3)
        gain = [1 / (1 + (g / fb - fb / np.maximum(g, 1e-9)) ** 2) * (g > 0) for fb, _ in BANDS]
        bands.append([math.sqrt(2 * (h * np.abs(z) ** 2).sum()) / len(l) for h in gain])
    louder = np.maximum(*levels)
    on = np.flatnonzero(louder >= max(louder.max() - 20, 0.5))
    begin, duration = (on[0], (on[-1] - on[0] + 1) * 1e-3) if len(on) else (0, 1e-3)
    pitch = (power * np.log(f)).sum() / max(power.sum(), 1e-300)
    return [l[begin:] for l in levels], bands, pitch, duration


def apart(a, b):
    n = max(len(a), len(b))
    return np.pad(a, (0, n - len(a))) - np.pad(b, (0, n - len(b)))


def two_channel(x, y):
    (la, ma, fa, da), (lb, mb, fb, db) = felt(x), felt(y)
    level = max(math.sqrt(np.mean(poles(apart(p, q), 0.040, 1e3) ** 2)) for p, q in zip(la, lb)) / LEVEL_JND_DB
    modulation = max(
        sum((r * r - q * q) ** 2 / (s * s * (s * s + r * r + q * q)) for r, q, (_, s) in zip(*of, BANDS)) for of in zip(ma, mb)
    )
    pitch = abs(fa - fb) / math.log(1.2)
    duration = abs(math.log(da / db)) / math.log(1.15)
    return math.sqrt(level ** 2 + modulation + pitch ** 2 + duration ** 2)


def segments(x, y):
    def levels(x):
        w, _, _ = weighted(x, "P")
        size = int(0.008 * FS)
        e = (w[: len(w) // size * size] ** 2).reshape(-1, size).mean(axis=1)
        on = np.flatnonzero(e > max(e.max() / 100, 1e-9))
        return 10 * np.log10(1 + e[on[0] if len(on) else 0 :])

    return math.sqrt(np.mean(apart(levels(x), levels(y)) ** 2)) / LEVEL_JND_DB


def main(folder, keys):
    read = lambda name: np.fromfile(pathlib.Path(folder) / name, "<f8")
    pairs = {key: (read(f"{key}.a.f64"), read(f"{key}.b.f64")) for key in keys}
    print(json.dumps({key: {"two_channel": two_channel(*pair), "segments": segments(*pair)} for key, pair in pairs.items()}))


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
