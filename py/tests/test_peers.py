"""The numbers of others on the same samples, with the tolerances of the Rust tests (`crates/piezotact/tests/reference.rs`)."""

from __future__ import annotations

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
