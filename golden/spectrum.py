"""Golden values for windows, detrending, odd segments, overlaps, averages and spectrograms, from SciPy 1.17.1.

    python3 golden/spectrum.py > crates/piezotact/tests/golden/spectrum.json
"""

import json

import numpy as np
import scipy
from scipy import signal

RATE = 1000.0
random = np.random.Generator(np.random.PCG64(42))
time = np.arange(400) / RATE
x = random.standard_normal(400) + 3.0 + 20.0 * time + np.sin(2 * np.pi * 123.0 * time)

WINDOWS = {
    "hann": "hann",
    "hamming": "hamming",
    "blackman": "blackman",
    "blackman-harris": "blackmanharris",
    "flat-top": "flattop",
    "rectangular": "boxcar",
}
AVERAGES = {"mean": "mean", "median": "median"}
DETRENDS = {"none": False, "constant": "constant", "linear": "linear"}
SCALINGS = {"density": "density", "spectrum": "spectrum"}


def case(window="hann", segment=64, overlap=0.5, detrend="constant", averaging="mean", scaling="density"):
    _, values = signal.welch(
        x,
        RATE,
        window=WINDOWS[window],
        nperseg=segment,
        noverlap=int(segment * overlap),
        detrend=DETRENDS[detrend],
        average=AVERAGES[averaging],
        scaling=SCALINGS[scaling],
    )
    return dict(
        window=window,
        segment=segment,
        overlap=overlap,
        detrend=detrend,
        averaging=averaging,
        scaling=scaling,
        values=list(values),
    )


def spectrogram(window="hann", segment=64, overlap=0.5, detrend="constant"):
    frequencies, times, values = signal.spectrogram(
        x,
        RATE,
        window=WINDOWS[window],
        nperseg=segment,
        noverlap=int(segment * overlap),
        detrend=DETRENDS[detrend],
        scaling="density",
        mode="psd",
    )
    return dict(
        window=window,
        segment=segment,
        overlap=overlap,
        detrend=detrend,
        frequencies_hz=list(frequencies),
        times_s=list(times),
        # One column after the other.
        values=list(values.T.ravel()),
    )


cases = [case(window=name) for name in WINDOWS]
cases += [case(detrend=name) for name in DETRENDS]
cases += [case(segment=n) for n in (2, 3, 63, 65, 100, 399, 400)]
cases += [case(overlap=share) for share in (0.0, 0.25, 0.75, 0.9)]
cases += [case(averaging="median", segment=n) for n in (63, 64, 100)]
cases += [case(scaling="spectrum", window=name, segment=63) for name in ("hann", "flat-top")]
spectrograms = [
    spectrogram(),
    spectrogram(window="blackman-harris", segment=63, overlap=0.25, detrend="linear"),
    spectrogram(window="hamming", segment=40, overlap=0.65),
    spectrogram(window="flat-top", segment=100, overlap=0.0, detrend="none"),
    spectrogram(segment=399, overlap=0.75),
]
symmetric = {name: list(signal.get_window(scipy_name, 9, fftbins=False)) for name, scipy_name in WINDOWS.items()}
bins = np.fft.rfft(x[:399])
amplitudes = 2 * abs(bins) / 399
amplitudes[0] /= 2
print(
    json.dumps(
        dict(
            made_with=f"NumPy {np.__version__}, SciPy {scipy.__version__}",
            rate_hz=RATE,
            x=list(x),
            cases=cases,
            spectrograms=spectrograms,
            symmetric=symmetric,
            amplitude_spectrum_of_399=list(amplitudes),
        )
    )
)
