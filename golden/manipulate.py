"""Golden values for shifts, tilts, band edits, spectra and warps of textures, from NumPy 2.4.6 and SciPy 1.17.1.

    python3 golden/manipulate.py > crates/piezotact/tests/golden/manipulate.json

The textures are made from a formula that the test has too, so that only results stand in the file.
"""

import json

import numpy as np
import scipy
from scipy import signal

RATE = 1000.0


def texture(n):
    i = np.arange(n)
    t = i / RATE
    tones = np.sin(2 * np.pi * 73.3 * t) + 0.5 * np.sin(2 * np.pi * 211.7 * t) * (1 + 0.3 * np.sin(2 * np.pi * 3.0 * t))
    return tones + 0.2 * np.sin(0.01 * i * i) + 0.25


def weight(f, low, high, edge=0.1):
    """1 in the band, raised-cosine edges outside it."""
    w = ((f >= low) & (f <= high)).astype(float)
    rising = (f > low * (1 - edge)) & (f < low)
    falling = (f > high) & (f < high * (1 + edge))
    w[rising] = 0.5 - 0.5 * np.cos(np.pi * (f[rising] - low * (1 - edge)) / (low * edge))
    w[falling] = 0.5 + 0.5 * np.cos(np.pi * (f[falling] - high) / (high * edge))
    return w


def filtered(x, gain):
    mean = x.mean()
    f = np.fft.rfftfreq(len(x), 1 / RATE)
    return np.fft.irfft(np.fft.rfft(x - mean) * gain(f), len(x)) + mean


def shifted(x, by):
    f = np.fft.rfftfreq(len(x), 1 / RATE)
    bins = np.fft.rfft(x)
    kept = (f > 0) & (f + by > 0) & (f + by < RATE / 2)
    stays = np.fft.irfft(bins * kept, len(x))
    share = 1 - (abs(bins) ** 2 * kept).sum() / (abs(bins[1:]) ** 2).sum()
    turn = np.exp(2j * np.pi * by * np.arange(len(x)) / RATE)
    return dict(n=len(x), by_hz=by, share=share, values=list((signal.hilbert(stays) * turn).real))


def tilted(x, slope, pivot, held):
    y = filtered(x, lambda f: 10 ** (slope * np.log2(np.maximum(f, held) / pivot) / 20))
    return dict(n=len(x), db_per_octave=slope, pivot_hz=pivot, held_below_hz=held, values=list(y))


def changed(x, low, high, gain_db):
    ratio = 0.0 if gain_db is None else 10 ** (gain_db / 20)
    y = filtered(x, lambda f: 1 + (ratio - 1) * weight(f, low, high))
    return dict(n=len(x), low_hz=low, high_hz=high, gain_db=gain_db, values=list(y))


def spectrum_swapped(x, other, segment):
    f, psd = signal.welch(other, RATE, nperseg=segment)
    lines = np.fft.rfftfreq(len(x), 1 / RATE)
    bins = np.fft.rfft(x - x.mean())
    amplitudes = np.sqrt(np.interp(lines, f, psd))
    amplitudes[0] = 0
    y = np.fft.irfft(amplitudes * np.exp(1j * np.angle(bins)), len(x))
    return dict(n=len(x), segment=segment, values=list(y * x.std() / y.std()))


def noise(n):
    i = np.arange(n)
    return np.sin(0.003 * i * i) * np.cos(0.7 * i) + 0.1 * np.cos(0.02 * i * i)


textures = [texture(160), texture(161)]
print(
    json.dumps(
        dict(
            made_with=f"NumPy {np.__version__}, SciPy {scipy.__version__}",
            shifts=[shifted(x, by) for x in textures for by in (20.0, -30.5, 320.0)],
            tilts=[tilted(x, *how) for x in textures for how in ((3.0, 200.0, 10.0), (-6.5, 50.0, 5.0))],
            bands=[
                changed(x, *how)
                for x in textures
                for how in ((50.0, 100.0, 6.0), (150.0, 300.0, None), (0.0, 80.0, -12.0), (200.0, 500.0, 3.0))
            ],
            spectra=[spectrum_swapped(x, noise(300), 64) for x in textures],
        )
    )
)
