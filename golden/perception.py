"""Golden values for how different vibrations feel: the prototype of `piezotact::perception`, in NumPy and SciPy.

    python3 golden/perception.py > crates/piezotact/tests/golden/perception.json

Made with NumPy 2.4.6 and SciPy 1.17.1. The signals are those of `crates/piezotact/tests/perception/signals.rs`, the keys those of
`expected.txt` beside it.
"""

import json
import dataclasses
import math

import numpy as np
from scipy.signal import lfilter
from scipy.special import ndtr

RATE = 1000.0
DB = 10 / math.log(10)
BANDS = (1.5, 3.0, 6.0, 12.0, 24.0, 48.0, 90.0)
K, HIGHER = 6, 30  # slow coefficients; those from which their chance part is estimated
POINTS = 64
CHANNELS = ("RA", "P")


@dataclasses.dataclass
class Parameters:
    low_hz: float = 10.0
    ra_knee_hz: float = 100.0
    demodulation_hz: float = 500.0
    envelope_ra_s: float = 0.008
    envelope_p_s: float = 0.004
    tail_ra_s: float = 0.100
    tail_p_s: float = 0.040
    tail_jump: float = 0.6
    tail_residue: float = 0.2
    residue_s: float = 1.0
    integration_p_s: float = 0.200
    growth: float = 0.89
    level_jnd_20_db: float = 2.3
    level_jnd_35_db: float = 2.15
    pitch_jnd_20: float = 0.25
    pitch_slope: float = -0.30
    pitch_jnd_35: float = 0.20
    pitch_spread: float = 1.0
    rate_jnd: float = 0.20
    duration_s: float = 0.011
    duration_share: float = 0.125
    rise_s: float = 0.017
    rise_share: float = 0.5
    modulation_db: tuple = (0.60, 0.60, 0.45, 0.35, 0.28, 0.35, 0.60)
    modulation_share: float = 0.20
    course_pitch: float = 0.30
    course_whole_s: float = 0.30
    course_blur_s: float = 0.040
    course_power: float = 8.0
    dip_db: float = 6.5
    onset_masking: float = 0.9
    onset_s: float = 0.25


# Standard errors squared that are taken off: level, pitch; modulation; course (x 2.5 for pitch); rise and fall.
TAKEN_OFF, OFF_MODULATION, OFF_COURSE, OFF_PITCH_COURSE, OFF_RISE = 5.0, 9.0, 4.0, 10.0, 25.0
# Ratio by which the JND of a feature may be smaller or larger (published ranges).
RANGES = {"level": 1.35, "pitch": 1.6, "pulse rate": 1.8, "duration": 1.3, "rise": 1.8, "fall": 1.8, "accents": 1.4,
          "rhythm": 1.4, "course of level": 1.4, "course of pitch": 1.6, "modulation": 1.5, "dip": 1.6, "bump": 1.6}


def threshold_ra(f, p):
    db = np.clip(28.0 - 6.0 * np.log2(f / 3.0), 6.0, 28.0) + 12.0 * np.maximum(np.log2(f / p.ra_knee_hz), 0.0)
    return 1e-6 * 10 ** (db / 20) * (2 * np.pi * f) ** 2 / np.sqrt(2)


def threshold_p(f):
    db = np.where(f < 250, -20 + 12 * np.log2(250 / f), -20 + 10 * np.log2(f / 250))
    return 1e-6 * 10 ** (db / 20) * (2 * np.pi * f) ** 2 / np.sqrt(2)


def fast_length(n):
    m = max(n, 2)
    while True:
        if m % 2 == 0:
            k = m
            for q in (2, 3, 5):
                while k % q == 0:
                    k //= q
            if k == 1:
                return m
        m += 1


def one_pole(e, tau, dt):
    a = math.exp(-dt / tau)
    return lfilter([1 - a], [1, -a], e)


def two_poles(e, tau, dt):
    return one_pole(one_pole(e, tau, dt), tau, dt)


def tail(level, tau, p, dt):
    a, b = math.exp(-dt / tau), math.exp(-dt / p.residue_s)
    fast = slow = 0.0
    out = np.empty_like(level)
    for i, l in enumerate(level):
        out[i] = fast + slow
        slow = max(p.tail_residue * l, slow * b)
        fast = max(p.tail_jump * l - slow, fast * a, 0.0)
    return out


def trigamma(n):
    s = 0.0
    while n < 10:
        s += 1 / n ** 2
        n += 1
    i = 1 / n
    return s + i + i * i / 2 + i ** 3 / 6 - i ** 5 / 30 + i ** 7 / 42 - i ** 9 / 30


def sin2(n):
    return np.sin(np.pi / 2 * (np.arange(n) + 0.5) / max(n, 1)) ** 2


def tapered(x, fs):
    """`x` faded over 20 ms where it begins or ends abruptly, and whether it is whole: it does neither, or silence stands at one end."""
    own = math.sqrt((x ** 4).sum() / max((x * x).sum(), 1e-300))
    n = min(math.floor(0.020 * fs + 0.5), len(x) // 4)

    def shares(seconds):
        edge = min(max(1, math.floor(seconds * fs + 0.5)), len(x))
        return [math.sqrt(np.mean(v ** 2)) / max(own, 1e-300) for v in (x[:edge], x[len(x) - edge:])]
    if min(shares(0.010)) <= 0.02:
        return x, True
    y = x.copy()
    first, last = (shares(0.001)[end] > 0.2 or shares(0.004)[end] > 0.4 for end in (0, 1))
    if first:
        y[:n] *= sin2(n)
    if last:
        y[len(y) - n:] *= sin2(n)[::-1]
    return y, not first and not last


def excite(x, fs, p):
    """Power over threshold of both channels, and the sum of power x ln f, at about 1 kHz; dt; spectrum; own ends."""
    x, whole = tapered(x, fs)
    if whole:
        # What begins and ends by itself is felt alike with silence around it and without.
        silence = np.zeros(math.floor(0.1 * fs + 0.5))
        x = np.concatenate([silence, x, silence])
    n = len(x)
    pad = fast_length(n + int(0.25 * fs))
    X = np.fft.rfft(x, pad)
    f = np.arange(len(X)) * (fs / pad)
    high = f >= p.demodulation_hz
    if high.any():
        Z = np.zeros(pad, complex)
        Z[: len(X)][high] = 2 * X[high] / (2 * np.pi * f[high]) ** 2
        U = np.fft.rfft(np.abs(np.fft.ifft(Z)) / np.pi)
        low = (f >= 20) & (f < p.demodulation_hz)
        X[low] += U[low] * (2 * np.pi * f[low]) ** 2
    m = int(RATE * pad / fs)
    dt = pad / fs / m
    bins = min(m, len(X))
    ff = np.maximum(f[:bins], 0.5)
    Y = X[:bins] * (f[:bins] >= 1.0) / np.sqrt(1 + (p.low_hz / ff) ** 4)
    ln_f = np.log(ff)
    keep = min(m, math.ceil(n / fs / dt))

    def power(w):
        Z = np.zeros(m, complex)
        Z[:bins] = 2 * Y * w
        return (0.5 * np.abs(np.fft.ifft(Z) * (m / pad)) ** 2)[:keep]

    ra, pc = 1 / threshold_ra(ff, p), 1 / threshold_p(ff)
    root = np.sqrt(np.maximum(ln_f, 0))
    S = np.abs(Y) ** 2 * (ra ** 2 + pc ** 2)
    S = S / max(S.sum(), 1e-300)
    return [power(ra), power(pc)], power(ra * root) + power(pc * root), dt, (S, ff), whole


def centre(S, f, total, p):
    """Mean and standard deviation of ln f, weighted by felt intensity: what lies within a third of an octave is felt together."""
    c = np.concatenate([[0.0], np.cumsum(S)])
    ln_f = np.log(f)
    low = np.searchsorted(f, f * 2 ** (-1 / 6), "left")
    high = np.searchsorted(f, f * 2 ** (1 / 6), "right")
    E = np.maximum(total * (c[high] - c[low]), 1e-12)
    w = S / E * ((1 + E) ** (p.growth / 2) - 1)
    w = w / max(w.sum(), 1e-300)
    mean = float((w * ln_f).sum())
    return mean, math.sqrt(max(0.0, (w * ln_f ** 2).sum() - mean ** 2))


def cosines(n):
    k = np.arange(1, HIGHER + 1)[:, None]
    t = (np.arange(n) + 0.5)[None, :] / n
    return np.sqrt(2) * np.cos(np.pi * k * t) / n


def chance(c):
    """Variance of the coefficients above K, without the largest quarter, where lines of a periodic course stand."""
    v = np.sort(c[K:] ** 2)
    return v[:18].mean() / 0.3962


def wandering(c):
    """The same of the mean of an excerpt: what wanders slowly shows in the first coefficients."""
    return max(chance(c), (c[:4] ** 2).mean())


WAVES = np.sqrt(2) * np.cos(np.pi * np.arange(1, K + 1)[:, None] * (np.arange(POINTS) + 0.5)[None, :] / POINTS)


@dataclasses.dataclass
class Felt:
    """What is felt of one vibration."""
    length: float = 0.0
    whole: bool = False
    level: tuple = ()
    level_error: tuple = ()
    log_f: float = 0.0
    log_f_error: float = 0.0
    spread: float = 0.0
    rise: float = 0.0
    fall: float = 0.0
    wait: float = 0.0
    course: tuple = ()
    chance: tuple = ()
    modulation: tuple = ()
    dip: object = None
    bump: object = None
    events: object = None
    rate: object = None


def analyse(x, fs, p=Parameters()):
    raw, raw_ln, dt, spectrum, whole = excite(np.asarray(x, float), fs, p)
    e = [two_poles(r, t, dt) for r, t in zip(raw, (p.envelope_ra_s, p.envelope_p_s))]
    level = [10 * np.log10(1 + v) for v in e]
    tailed = [10 * np.log10(v + 10 ** (tail(l, t, p, dt) / 10)) for v, l, t in zip(e, level, (p.tail_ra_s, p.tail_p_s))]
    q = max(1, math.floor(0.003 / dt + 0.5))
    bell = np.hanning(2 * q + 3)[1:-1]
    louder = np.convolve(np.maximum(*raw), bell / bell.sum(), "same") if len(raw[0]) >= len(bell) else np.maximum(*raw)
    peak = louder.max()
    at = np.flatnonzero(louder >= max(1.0, peak / 10 ** 2.5))
    on, off = (int(at[0]), int(at[-1]) + 1) if len(at) else (0, len(louder))
    n = off - on
    cut = slice(on, off)
    g = Felt(length=n * dt, whole=whole)
    # level
    levels, errors = [], []
    C = cosines(n)
    for i in range(2):
        s = e[i] if i == 0 else one_pole(e[i], p.integration_p_s, dt)
        s, v = s[cut], e[i][cut]
        levels.append(float((s * s).sum() / max(s.sum(), 1e-30)))
        psi = v * v / max((v * v).mean(), 1e-30) - v / max(v.mean(), 1e-30)
        errors.append(DB * math.sqrt(2 * (chance if whole else wandering)(C @ psi)))
    g.level, g.level_error = tuple(levels), tuple(errors)
    # What has no chance in it is a stimulus and no excerpt.
    g.whole = whole or errors[0 if levels[0] > levels[1] else 1] * math.sqrt(n * dt) < 0.15
    # pitch
    total = raw[0] + raw[1]
    sum_ = total[cut].sum()
    at = float(raw_ln[cut].sum() / sum_) if sum_ > 0 else 0.0
    g.log_f, g.spread = centre(*spectrum, sum(levels), p)
    g.log_f_error = math.sqrt(2 * (chance if whole else wandering)(C @ ((raw_ln[cut] - at * total[cut]) / max(total[cut].mean(), 1e-12))))
    # course
    margin = min(int(0.030 / dt), n // 8)
    inner = slice(on + margin, off - margin)
    CI = cosines(n - 2 * margin)
    smooth, smooth_ln = two_poles(total, 0.015, dt), two_poles(raw_ln, 0.015, dt)
    moved = smooth / (1 + smooth) * (np.where(smooth > 1e-9, smooth_ln / np.maximum(smooth, 1e-12), at) - at)
    g.course = tuple((C @ (v[cut] - v[cut].mean()))[:K] for v in (*level, moved))
    g.chance = tuple(chance(CI @ (v[inner] - v[inner].mean())) for v in (*level, moved))
    g.modulation = tuple(modulation(l, on, off, dt) for l in tailed)
    # brief dips and bumps
    margin = math.floor(0.040 / dt + 0.5)
    if n - 2 * margin >= 60:
        gain = 1 / (1 + p.onset_masking * np.exp(-(np.arange(n - 2 * margin) + margin) * dt / p.onset_s))
        dips, bumps = [], []
        for l in tailed:
            v = l[on + margin:off - margin]
            middle = np.median(v)
            mad = 1.4826 * np.median(np.abs(v - middle))
            dips.append(max(0.0, (gain * (middle - v - 5 * mad)).max()))
            bumps.append(max(0.0, (gain * (v - middle - 4 * mad)).max()))
        g.dip, g.bump = max(dips), max(bumps)
    # ends and events
    v = louder[cut]
    reach = 0.25 * (v * v).sum() / max(v.sum(), 1e-30)
    at = np.flatnonzero(v >= reach)
    if len(at):
        g.rise, g.fall = at[0] * dt, (n - 1 - at[-1]) * dt
        i = 0 if levels[0] > levels[1] else 1
        g.wait = wait(v[at[0]:at[-1] + 1] < reach, dt) / (n * dt) + (0.020 * errors[i]) ** 2 * n * dt
    l = 10 * np.log10(1 + v)
    peaks = peaks_of(l, 15.0)
    # Noise has smaller dips between the large ones, events have none.
    g.events = events(l, peaks, dt) if g.whole and len(peaks_of(l, 6.0)) == len(peaks) else None
    g.rate = pulse_rate(l, peaks, dt)
    return g


def modulation(level, on, off, dt):
    """By band: mean square of the sustained modulation, dB2, and the variance of its logarithm; None where too short."""
    margin = math.floor(0.030 / dt + 0.5)
    v = level[on + margin:off - margin]
    n = off - on - 2 * margin
    if n < 40:
        return (None,) * len(BANDS)
    t = (np.arange(n) + 0.5) / n - 0.5
    v = v - v.mean()
    v = v - t * (t @ v) / (t @ t)
    w = np.sin(np.pi / 2 * np.minimum(1.0, (0.5 - np.abs(t)) / 0.10)) ** 2
    Z = np.fft.rfft(v * w)
    S = 2 * np.abs(Z) ** 2 / n ** 2
    f = np.arange(len(S)) / (n * dt)
    out = []
    for fb in BANDS:
        if fb * n * dt < 5.0:
            out.append(None)
            continue
        h = 1 / np.sqrt(1 + (f / fb - fb / np.maximum(f, 1e-9)) ** 2)
        h[0] = 0
        F = np.zeros(n, complex)
        F[: len(Z)] = 2 * Z * h
        root = np.sqrt(np.abs(np.fft.ifft(F)))[n // 10:n - n // 10]
        size = len(root) // 8
        of = root[: size * 8].reshape(8, size).mean(axis=1)
        blocks = 16 * of.var(ddof=1) / 8 / max(of.mean(), 1e-9) ** 2
        all_ = (h * h * S).sum()
        noise = min(all_, np.median(S[(f >= fb / 2) & (f <= fb * 2)]) / 0.693 * (h * h).sum())
        gauss = (noise ** 2 + 2 * noise * (all_ - noise)) / max(all_, 1e-12) ** 2 * trigamma(max(0.6 * fb * n * dt, 1.0))
        out.append((0.5 * root.mean() ** 4, max(gauss, blocks)))
    return tuple(out)


def wait(below, dt):
    """Sum of the cubed durations of the runs of `below`, over 3."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], below.astype(int), [0]])))
    runs = (edges[1::2] - edges[::2]) * dt
    return float((runs ** 3).sum() / 3)


def peaks_of(l, depth):
    """Maxima between dips of at least `depth` dB."""
    peaks = []
    hi = lo = l[0]
    at, rising = 0, True
    for i, v in enumerate(l):
        if rising:
            if v > hi:
                hi, at = v, i
            if v < hi - depth:
                peaks.append(at)
                rising, lo = False, v
        else:
            lo = min(lo, v)
            if v > lo + depth:
                rising, hi, at = True, v, i
    if rising and hi - lo > depth:
        peaks.append(at)
    return peaks


def pulse_rate(l, peaks, dt):
    """ln of the inverse silent gap of short pulses, weighted by length, 1/s, and its standard error; None of others."""
    if len(peaks) < 4 or len(peaks_of(l, 10.0)) > len(peaks):
        return None
    widths = sorted(np.count_nonzero(l[max(0, k - 40):k + 41] > l[k] - 6) for k in peaks)
    if np.median(widths) * dt > 0.025:
        return None
    gaps = []
    for a, b in zip(peaks[:-1], peaks[1:]):
        below = np.flatnonzero(l[a:b + 1] < min(l[a], l[b]) - 6)
        gaps.append((below[-1] - below[0] + 1) * dt + 0.008)
    gaps = np.array(gaps)
    return math.log(gaps.sum() / (gaps ** 2).sum()), 2 * gaps.std() / gaps.mean() / math.sqrt(len(gaps))


def events(l, peaks, dt):
    """Onsets, s, and levels, dB, of events; None of fewer than three, and where half of the silences between them are shorter than 40 ms."""
    if len(peaks) < 3:
        return None
    quiet = max(3.0, l.max() - 20)
    onsets, short = [], 0
    for i, k in enumerate(peaks):
        start = 0 if i == 0 else peaks[i - 1]
        part = l[start:k + 1]
        short += bool(i) and np.count_nonzero(part < quiet) * dt < 0.040
        below = np.flatnonzero(part < l[k] - 6)
        onsets.append((start + (below[-1] + 1 if len(below) else 0)) * dt)
    return None if 2 * short >= len(peaks) - 1 else (np.array(onsets), l[peaks])


def autocorrelation(v):
    v = v - v.mean()
    own = (v * v).mean()
    if own < 1e-9:
        return np.zeros(3), 0.0
    return np.array([(v[k:] * v[:-k]).mean() / own for k in (2, 3, 4)]), math.sqrt(own)


def left(delta, variance, times):
    """|delta| without what its sampling error explains."""
    return math.sqrt(max(0.0, delta * delta - times * variance))


def rhythm(a, b, level_jnd, p):
    accents = intervals = 0.0
    if a is None or b is None:
        return accents, intervals
    if min(len(a[0]), len(b[0])) >= 6:
        (ra, sa), (rb, sb) = autocorrelation(a[1]), autocorrelation(b[1])
        regular = [min(1.0, max(r.max(), 0.0)) for r in (ra, rb)]
        variance = 2 * (sa ** 2 * (1 - regular[0]) / len(a[0]) + sb ** 2 * (1 - regular[1]) / len(b[0]))
        accents = left(math.sqrt(np.mean((ra * sa - rb * sb) ** 2)), variance, 5.0) / level_jnd
    # In order where both have few.
    if max(len(a[0]), len(b[0])) <= 10:
        d = [left(math.log(y / x), 2 * (0.005 / x) ** 2 + 2 * (0.005 / y) ** 2, 2.0) for x, y in zip(np.diff(a[0]), np.diff(b[0]))]
        intervals = math.sqrt(np.mean(np.square(d))) / math.log1p(p.duration_share)
    else:
        x, y = (float(np.median(np.diff(e[0]))) for e in (a, b))
        intervals = left(math.log(y / x), 2 * (0.005 / x) ** 2 + 2 * (0.005 / y) ** 2, 2.0) / math.log1p(p.duration_share)
    return accents, intervals


def between(at_20, at_35, level_db, low):
    s = min(max(level_db, low), 45.0)
    return at_20 * (at_35 / at_20) ** ((s - 20) / 15)


def compare(a, b, p=Parameters()):
    """The features as (name, channel, band, JND), their sampling errors in JND, and the whole."""
    features, errors = [], []
    both = (a, b)
    levels = [10 * math.log10(max(*g.level, 1e-3)) for g in both]
    level_jnd = between(p.level_jnd_20_db, p.level_jnd_35_db, max(levels), 20.0)
    felt = [[(1 + l) ** (p.growth / 2) - 1 for l in g.level] for g in both]
    strongest = max(max(f) for f in felt) or 1e-9
    share = [(max(felt[0][c], felt[1][c]) / strongest) ** 2 for c in range(2)]
    heard = min(max(g.level) / (1 + max(g.level)) for g in both)
    # level
    of, raw = [], []
    for c in range(2):
        d = 10 * math.log10((1 + b.level[c]) / (1 + a.level[c]))
        variance = a.level_error[c] ** 2 + b.level_error[c] ** 2
        of.append(share[c] * left(d, variance, TAKEN_OFF) / level_jnd)
        raw.append(share[c] * abs(d) / level_jnd)
        errors.append(share[c] * math.sqrt(variance) / level_jnd)
    c = 0 if of[0] > of[1] else 1
    features.append(("level", CHANNELS[c], None, of[c]))
    hidden = max(raw) ** 2 - of[c] ** 2
    # pitch
    hz = math.exp(0.5 * (a.log_f + b.log_f))
    jnd = between(p.pitch_jnd_20 * (hz / 80) ** p.pitch_slope, p.pitch_jnd_35, min(levels), 10.0)
    jnd *= math.sqrt(1 + 0.5 * (a.spread ** 2 + b.spread ** 2) / p.pitch_spread ** 2)
    variance = a.log_f_error ** 2 + b.log_f_error ** 2
    pitch = heard * left(b.log_f - a.log_f, variance, TAKEN_OFF) / math.log1p(jnd)
    errors.append(heard * math.sqrt(variance) / math.log1p(jnd))
    features.append(("pitch", None, None, pitch))
    hidden += (heard * (b.log_f - a.log_f) / math.log1p(jnd)) ** 2 - pitch ** 2
    if a.rate and b.rate:
        pitch = heard * left(a.rate[0] - b.rate[0], a.rate[1] ** 2 + b.rate[1] ** 2, TAKEN_OFF) / math.log1p(p.rate_jnd)
        features.append(("pulse rate", None, None, pitch))
    # duration, rise, fall
    if a.whole and b.whole and heard > 0.5:
        w = p.duration_share
        d = abs(math.log((p.duration_s + w * a.length) / (p.duration_s + w * b.length))) / w
        features.append(("duration", None, None, d))
        for name in ("rise", "fall"):
            x, y = getattr(a, name), getattr(b, name)
            more = left(y - x, a.wait + b.wait, OFF_RISE)
            d = math.log1p(p.rise_share * more / (p.rise_s + p.rise_share * min(x, y))) / p.rise_share
            features.append((name, None, None, d))
    accents, intervals = rhythm(a.events, b.events, level_jnd, p)
    features += [("accents", None, None, accents), ("rhythm", None, None, intervals)]
    # course
    length = math.sqrt(a.length * b.length)
    whole = math.sqrt(length / (length + p.course_whole_s))
    k = np.arange(1, K + 1)
    slow = 1 / (1 + (np.pi * k / length * p.course_blur_s) ** 2) ** 2
    of = []
    for c in range(3 if a.whole and b.whole else 0):
        by = math.log1p(p.course_pitch) if c == 2 else level_jnd
        weight = whole / by * (1.0 if c == 2 else share[c])
        noise = slow * K / k * (a.chance[c] + b.chance[c])
        delta = np.sqrt(slow) * (a.course[c] - b.course[c])
        best = 0.0
        for m in range(1, K + 1):
            own = (delta[:m] ** 2).sum()
            kept = own - (OFF_PITCH_COURSE if c == 2 else OFF_COURSE) * noise[:m].sum()
            if kept > 0:
                size = (np.abs(delta[:m] @ WAVES[:m]) ** p.course_power).mean() ** (1 / p.course_power)
                best = max(best, math.sqrt(kept / own) * size)
        of.append(weight * best)
        errors.append(weight * math.sqrt(2 * noise.sum() / K))
    if of:  # two excerpts have no common begin
        c = 0 if of[0] > of[1] else 1
        features += [("course of level", CHANNELS[c], None, of[c]), ("course of pitch", None, None, of[2])]
    # modulation
    of = []
    for c in range(2):
        ds = []
        for i in range(len(BANDS)):
            x, y = a.modulation[c][i], b.modulation[c][i]
            if x is None or y is None:
                ds.append(0.0)
                continue
            hi, lo = max(x[0], y[0], 1e-9), max(min(x[0], y[0]), 1e-9)
            r = left(math.log(hi / lo), x[1] + y[1], OFF_MODULATION)
            s = p.modulation_db[i]

            def apart(r):
                lo = hi * math.exp(-r)
                return (hi - lo) / math.sqrt(s ** 4 + s * s * (hi + lo) + (p.modulation_share * (hi + lo)) ** 2)
            ds.append(apart(r))
            errors.append(apart(r + math.sqrt(x[1] + y[1])) - ds[-1])
        of.append(ds)
    c = 0 if sum(d * d for d in of[0]) > sum(d * d for d in of[1]) else 1
    features += [("modulation", CHANNELS[c], fb, d) for fb, d in zip(BANDS, of[c])]
    if a.dip is not None and b.dip is not None:
        for name in ("dip", "bump"):
            x, y = getattr(a, name), getattr(b, name)
            features.append((name, None, None, abs(x - y) / (p.dip_db + 0.5 * min(x, y))))
    jnd = math.sqrt(sum(f[3] ** 2 for f in features))
    spread = math.sqrt(sum((f[3] ** 2 * math.log(RANGES[f[0]])) ** 2 for f in features)) / max(jnd * jnd, 1e-12)
    sampling = 1.28 * math.sqrt(np.mean(np.square(errors)))
    low = math.sqrt(max(0.0, jnd ** 2 - sampling ** 2)) * math.exp(-spread)
    high = math.sqrt(jnd ** 2 + max(0.0, hidden) + sampling ** 2) * math.exp(spread)
    total = [1 + max(f) + 0.5 * min(f) for f in felt]
    return dict(jnd=jnd, low=low, high=high, d_prime=1.16 * jnd, percent=100 * ndtr(1.16 * jnd / math.sqrt(2)), pitch=pitch,
                features=features, sampling=sampling, level_db=20 / p.growth * math.log10(total[1] / total[0]), felt_db=levels,
                parts={(f[0] + (f" {f[2]:g} Hz" if f[2] else ""), f[1] or ""): f[3] for f in features})


def difference(x, y, fs, p=Parameters()):
    return compare(analyse(x, fs, p), analyse(y, fs, p), p)


FS = 8000.0


def threshold(f, duration=1.0):
    f = np.asarray(f, float)
    ra = 1e-6 * 10 ** (np.clip(28.0 - 6.0 * np.log2(f / 3.0), 6.0, 28.0) / 20) * (2 * np.pi * f) ** 2 / np.sqrt(2)
    return np.minimum(ra, threshold_p(f) / np.sqrt(1 - np.exp(-duration / 0.2)))


def times(d):
    return np.arange(int(round(d * FS))) / FS


def ramp(x, s=0.010):
    w = sin2(int(round(s * FS)))
    y = np.array(x, float)
    y[: len(w)] *= w
    y[len(y) - len(w):] *= w[::-1]
    return y


def tone(f, sl, d=1.0, phase=0.0, ramps=0.010, of=None):
    x = threshold(f, of or d) * 10 ** (sl / 20) * np.sqrt(2) * np.sin(2 * np.pi * f * times(d) + phase)
    return ramp(x, ramps) if ramps else x


def db(x, g):
    return x * 10 ** (g / 20)


def equal_energy(x, like):
    return x * np.sqrt(np.sum(like ** 2) / np.sum(x ** 2))


def am(f, fm, m):
    flat = tone(f, 25, ramps=0)
    x = flat * (1 + m * np.sin(2 * np.pi * fm * times(1) - np.pi / 2))
    return equal_energy(ramp(x), ramp(flat))


def hashed(i, seed):
    h = (i * 2654435761 + seed * 40503 + 12345) & 0xFFFFFFFF
    h ^= h >> 16
    h = (h * 2246822519) & 0xFFFFFFFF
    h ^= h >> 13
    h = (h * 3266489917) & 0xFFFFFFFF
    h ^= h >> 16
    return (h + 0.5) / 2 ** 32


def noise(low, high, sl, d, seed):
    n = int(round(d * FS))
    k = np.array([k for k in range(1, n // 2 + 1) if low <= k * FS / n <= high])
    size = 10 ** (sl / 20) / np.sqrt(np.sum(threshold(k * FS / n, 1e9) ** -2.0)) * n / 2
    bins = np.zeros(n // 2 + 1, complex)
    for j in k:
        u, v = hashed(2 * int(j), seed), hashed(2 * int(j) + 1, seed)
        bins[j] = size * np.sqrt(-2 * np.log(u)) * np.exp(2j * np.pi * v)
    return ramp(np.fft.irfft(bins, n))


def place(d, *parts):
    out = np.zeros(int(round(d * FS)))
    for start, x in parts:
        i = int(round(start * FS))
        out[i:i + len(x)] += x[: len(out) - i]
    return out


def padded(x):
    return place(len(x) / FS + 0.1, (0.05, x))


def decay(tau):
    t = times(max(0.1, 6 * tau))
    return padded(threshold(200.0) * 10 ** 1.5 * np.sqrt(2) * np.exp(-t / tau) * np.sin(2 * np.pi * 200 * t))


def taps(every):
    tap = tone(250, 20, 0.05, of=1.0)
    return place(3.6, *[(i * 0.3, db(tap, 4.0) if i % every == 0 else tap) for i in range(12)])


def pulses(starts):
    t = times(0.003)
    p = threshold(250.0) * 10 ** 1.25 * 4 * np.sin(2 * np.pi * t / 0.003) * np.sin(np.pi * t / 0.003) ** 2
    return place(1.05, *[(0.01 + s, p) for s in starts])


def three(f):
    return tone(25, 20) + tone(300, 20, phase=1.0) + tone(f, 20, phase=2.0)


def unfelt(m):
    t = times(1)
    return ramp(0.65 * threshold(1000.0) * np.sqrt(2) * np.sin(2 * np.pi * 1000 * t) * (1 + m * np.sin(2 * np.pi * 200 * t)))


def rising():
    flat = tone(250, 25, ramps=0)
    return [equal_energy(ramp(flat * e), flat) for e in (times(1), 1.0)]


def in_order(f, g, start, later, d, sl):
    a, b = tone(f, sl, d), tone(g, sl, d)
    return place(start, (0.05, a), (0.05 + later, b))


def after_masker(f):
    masker, probe = tone(f, 25, 0.03, ramps=0.005), tone(f, 8, 0.02, ramps=0.005)
    return [place(0.35, (0.05, masker)), place(0.35, (0.05, masker), (0.18, probe))]


def gapped(gap):
    one = tone(250, 25, 0.1, of=0.2)
    return place(0.3 + gap, (0.05, one), (0.15 + gap, one))


BURSTS = [k * 0.05 + j for k in range(20) for j in (0, 0.005, 0.010)]
PAIRS = {
    "1.80": lambda: [tone(80, 20), db(tone(80, 20), 2.4)],
    "5": lambda: [tone(125, 10), db(tone(125, 10), 1.6)],
    "12": lambda: [three(80), three(100)],
    "13.30": lambda: [tone(300, 25), am(300, 30, 1.0)],
    "15": lambda: [unfelt(0.0), unfelt(0.9)],
    "17": lambda: [decay(0.0108), decay(0.0173)],
    "19": lambda: [in_order(50, 250, 0.3, 0.034, 0.1, 20), in_order(250, 50, 0.3, 0.034, 0.1, 20)],
    "20": lambda: [taps(2), taps(3)],
    "II.8": rising,
    "II.10": lambda: [in_order(100, 200, 0.42, 0.16, 0.16, 25), in_order(200, 100, 0.42, 0.16, 0.16, 25)],
    "II.18a": lambda: [pulses(BURSTS), pulses(np.arange(25) / 25)],
    "II.20": lambda: [noise(60, 400, 20, 1.0, 3), noise(60, 400, 20, 1.0, 4)],
    "II.24": lambda: [tone(50, 20) + tone(140, 20), tone(140, 20)],
    "II.28": lambda: [place(0.3, (0.05, tone(250, 25, 0.2))), gapped(0.010)],
    "II.30.20": lambda: [padded(tone(20, 10, d, of=0.05)) for d in (0.05, 0.5)],
    "II.34.500": lambda: after_masker(500),
}
NAMES = {"rise": "onset", "fall": "release", "bump": "single event"}


def case(key):
    found = difference(*PAIRS[key](), FS)
    named = {(f"modulation {f[2]:g}" if f[2] else NAMES.get(f[0], f[0])): float(f[3]) for f in found["features"]}
    return {
        "key": key,
        "jnd": float(found["jnd"]),
        "low": float(found["low"]),
        "high": float(found["high"]),
        "pitch_jnd": float(found["pitch"]),
        "felt_level_db": float(found["level_db"]),
        "percent_correct": float(found["percent"]),
        "contributions": named,
    }


if __name__ == "__main__":
    print(json.dumps({"cases": [case(key) for key in PAIRS]}, indent=1))
