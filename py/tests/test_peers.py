"""The numbers of others on the same samples, with the tolerances of the Rust tests (`crates/piezotact/tests/reference.rs`, and
`crates/piezotact-people/tests/eeg/golden.rs` of EEG). Versions: `requirements.txt`.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

import numpy as np
import piezotact as pz
import pytest
from scipy import signal  # type: ignore[import-untyped]

RATE = 5000.0
WELCH: dict[str, Any] = {"fs": RATE, "window": "hann", "detrend": "constant"}
#: PSDs: transforms sum in another order.
SPECTRUM = 1e-10
#: H1, H2 and coherence on lines that are driven: SciPy is 1e-10 away from extended precision at the weakest (golden/precision.py).
TRANSFER = 2e-10
#: Wavelet power: transforms of other lengths, and sums in another order.
POWER = 1e-9

pytestmark = pytest.mark.filterwarnings("ignore::piezotact.Warning")


def pair() -> tuple[Any, Any]:
    """A drive and its answer by three taps, with noise 20 dB below."""
    random = np.random.default_rng(53)
    drive = random.standard_normal(60_000)
    return drive, np.convolve(drive, [0.5, -0.3, 0.1])[: len(drive)] + 0.05 * random.standard_normal(len(drive))


@pytest.mark.parametrize("median", [False, True])
@pytest.mark.parametrize(("segment", "overlap"), [(1024, 0.5), (500, 0.25), (4096, 0.75)])
def test_a_spectrum_is_that_of_scipy(segment: int, overlap: float, median: bool) -> None:
    x = pair()[1] + 0.3
    found = pz.spectrum(x, rate=RATE, unit="m/s2", segment=segment, overlap=overlap, median=median)
    average = "median" if median else "mean"
    hz, psd = signal.welch(x, nperseg=segment, noverlap=int(segment * overlap), average=average, **WELCH)
    assert np.array_equal(found.frequency_hz, hz)
    assert np.allclose(found.psd, psd, rtol=SPECTRUM, atol=0)


@pytest.mark.parametrize(("segment", "overlap", "window"), [(512, 0.875, "hann"), (500, 0.5, "blackman"), (256, 0.0, "hann")])
def test_a_spectrogram_is_that_of_scipy(segment: int, overlap: float, window: str) -> None:
    x = pair()[1][:20_000] + 0.3
    found = pz.spectrogram(x, rate=RATE, unit="m/s2", segment=segment, overlap=overlap, window=window, max_frequency=RATE / 2).over_time
    cut = {"nperseg": segment, "noverlap": int(segment * overlap), **WELCH, "window": window}
    hz, time_s, psd = signal.spectrogram(x, **cut)
    assert (found.segments_per_column, found.lines_per_row) == (1, 1) and found.config.overlap == overlap
    assert np.allclose(found.frequencies_hz, hz, rtol=1e-15, atol=0) and np.allclose(found.times_s, time_s, rtol=1e-14, atol=0)
    assert found.psd.shape == psd.shape
    # Single cells of noise come near 0, where the rounding of the whole segment is left.
    assert np.max(np.abs(found.psd - psd)) <= SPECTRUM * psd.mean()
    assert np.quantile(np.abs(found.psd / psd - 1), 0.999) <= SPECTRUM


def test_a_long_spectrogram_has_the_means_of_its_cells() -> None:
    x = pair()[1]
    found = pz.spectrogram(x, rate=RATE, unit="m/s2", segment=1024, overlap=0.95, max_frequency=2500).over_time
    _, _, psd = signal.spectrogram(x, nperseg=1024, noverlap=int(1024 * 0.95), **WELCH)
    per_row, per_column = found.lines_per_row, found.segments_per_column
    assert per_row == 2 and per_column == 2 and found.segments == psd.shape[1]
    assert found.psd.shape == (len(found.frequencies_hz), len(found.times_s)) and found.psd.shape[0] <= 300 and found.psd.shape[1] <= 600
    means = np.array([[psd[i : i + 2, j : j + 2].mean() for j in range(0, psd.shape[1], 2)] for i in range(0, psd.shape[0], 2)])
    assert np.allclose(found.psd, means, rtol=SPECTRUM, atol=SPECTRUM * psd.mean())


def test_a_transfer_function_is_that_of_scipy() -> None:
    drive, response = pair()
    cut = {"nperseg": 2048, "noverlap": 1024, **WELCH}
    hz, sxy = signal.csd(drive, response, **cut)
    sxx, syy = signal.welch(drive, **cut)[1], signal.welch(response, **cut)[1]
    coherence = signal.coherence(drive, response, **cut)[1]
    # The mean is taken away from every segment: nothing is left at 0 Hz and little beside it.
    driven = sxx > 1e-2 * sxx.max()
    assert driven.sum() > 1000
    wanted: dict[Literal["h1", "h2"], Any] = {"h1": sxy / sxx, "h2": syy / sxy.conj()}
    for estimator, expected in wanted.items():
        measured = pz.transfer(
            {"drive": drive, "response": response}, rate=RATE, unit={"drive": "N", "response": "m/s2"},
            drive="drive", response="response", segment=2048, estimator=estimator,
        )
        h = measured.function()
        assert np.array_equal(h.frequency_hz, hz)
        assert np.max(np.abs(h.response / expected - 1)[driven]) <= TRANSFER, estimator
        assert np.allclose(h.coherence[driven], coherence[driven], rtol=TRANSFER, atol=0)


def test_a_transfer_function_is_that_of_pyfrf() -> None:
    """pyFRF is given the segments under the periodic window of this program, as its own is symmetric; its H1 and H2 are the estimates."""
    import pyFRF  # type: ignore[import-untyped]

    drive, response = pair()
    segment = 2048
    window = signal.get_window("hann", segment)
    starts = range(0, len(drive) - segment + 1, segment // 2)

    def segments(samples: Any) -> Any:
        cut = np.array([samples[start : start + segment] for start in starts])
        return (cut - cut.mean(axis=1, keepdims=True)) * window

    peer = pyFRF.FRF(sampling_freq=int(RATE), exc=segments(drive), resp=segments(response), exc_type="f", resp_type="d", window="none")
    wanted: dict[Literal["h1", "h2"], Any] = {"h1": peer.get_H1().ravel(), "h2": peer.get_H2().ravel()}
    coherence = peer.get_coherence().ravel()
    for estimator, expected in wanted.items():
        measured = pz.transfer(
            {"drive": drive, "response": response}, rate=RATE, unit={"drive": "N", "response": "m/s2"},
            drive="drive", response="response", segment=segment, estimator=estimator,
        )
        h = measured.function()
        # Nothing is left at 0 Hz, where the mean was.
        driven = slice(2, -1)
        assert np.allclose(h.frequency_hz, peer.get_f_axis(), rtol=1e-15, atol=0)
        assert np.max(np.abs(h.response / expected - 1)[driven]) <= TRANSFER, estimator
        assert np.allclose(h.coherence[driven], coherence[driven], rtol=TRANSFER, atol=0)


@pytest.mark.filterwarnings("ignore")
def test_a_desynchronisation_is_that_of_mne(data: Path) -> None:
    """Power of Morlet wavelets in baseline and window at every electrode and surface, averaged over the same epochs."""
    import mne  # type: ignore[import-untyped]

    mne.set_log_level("ERROR")
    file = data / "P01_natural.vhdr"
    found = pz.eeg_erd(file, participant="P01", task="natural", event="natural").to_dict()
    assert found["preparation"]["reference"] == "as_recorded" and not found["preparation"]["criteria"] and not found["preparation"]["filters"]
    raw = mne.io.read_raw_brainvision(file, preload=True)
    rate, volts = raw.info["sfreq"], raw.get_data(found["channels"])
    extent, power = found["preparation"]["extent"], found["config"]["power"]
    first, last = round(extent["start_s"] * rate), round(extent["end_s"] * rate)
    times_s = np.arange(first, last + 1) / rate
    parts = [(times_s >= low - 1e-9) & (times_s <= high + 1e-9) for low, high in (found["config"]["baseline_s"], found["config"]["window_s"])]
    hz = np.array(power["frequencies_hz"])
    (band,) = found["config"]["bands"]
    within = (hz >= 8 - 1e-9) & (hz <= 12 + 1e-9)
    assert band["name"] == "alpha" and within.sum() == 5
    surfaces = {one["surface"] for one in found["electrodes"]}
    assert len(surfaces) >= 2
    for surface in surfaces:
        events = [round(one["onset"] * rate) for one in raw.annotations if one["description"].endswith(f"natural/{surface}")]
        epochs = np.array([volts[:, event + first : event + last + 1] for event in events])
        assert len(epochs) == 10
        # As `Epochs` with `detrend=1`: wavelets would see the step of an offset at the ends of an epoch.
        epochs = signal.detrend(epochs, axis=2)
        cells = mne.time_frequency.tfr_array_morlet(epochs, rate, hz, n_cycles=np.array(power["cycles"]), zero_mean=True, output="avg_power")
        expected = np.array([cells[:, within][:, :, part].mean(axis=(1, 2)) for part in parts]).T
        own = {one["place"]: [one["baseline_power_v2"], one["window_power_v2"]] for one in found["electrodes"] if one["surface"] == surface}
        ours = np.array([own[name] for name in found["channels"]])
        assert np.allclose(ours, expected, rtol=POWER, atol=0), np.max(np.abs(ours / expected - 1))
