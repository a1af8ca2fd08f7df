"""Figures: labels and units of the report, numbers of the document."""

from __future__ import annotations

import html
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import piezotact as pz
import pytest
from scipy import signal  # type: ignore[import-untyped]

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

pytestmark = pytest.mark.filterwarnings("ignore::piezotact.Warning")


@pytest.fixture(autouse=True)
def closed() -> Any:
    yield
    plt.close("all")


def decibels(power: Any) -> Any:
    return 10 * np.log10(power)


def xy(line: Any) -> tuple[Any, Any]:
    return np.asarray(line.get_xdata()), np.asarray(line.get_ydata())


def test_a_spectrum_is_its_arrays(data: Path) -> None:
    found = pz.spectrum(data / "texture.wav")
    ax = found.plot()
    (line,) = ax.lines
    x, y = xy(line)
    assert np.array_equal(x, found.frequency_hz[1:])
    assert np.allclose(y, decibels(found.psd[1:]), rtol=0, atol=1e-9)
    assert ax.get_xlabel() == "frequency, Hz" and ax.get_ylabel() == f"PSD, dB re 1 {found.unit}"
    assert ax.get_xscale() == "log" and ax.get_xlim()[1] == found.frequency_hz[-1]


def test_a_chart_is_drawn_into_axes_that_are_there(data: Path) -> None:
    _, ax = plt.subplots()
    found = pz.spectrum(data / "texture.wav")
    assert found.plot(ax=ax) is ax and found.plot(1, ax=ax) is ax
    assert len(ax.lines) == 2
    matrix = pz.answers(data / "answers.csv")
    with pytest.raises(pz.UsageError, match="expected a figure that is one chart, found"):
        matrix.plot(1, ax=ax)


def test_a_spectrogram_is_its_powers(data: Path) -> None:
    texture = pz.read(data / "texture.wav")
    x, rate = texture["acceleration"][:4000], texture.rate_hz
    found = pz.spectrogram(x, rate=rate, unit="m/s2", segment=512)
    ax = found.plot()
    (mesh,) = ax.collections
    hz, time_s, psd = signal.spectrogram(x, rate, "hann", nperseg=512, noverlap=448, detrend="constant")
    shown = np.asarray(mesh.get_array())
    assert shown.shape == found.over_time.psd.shape and shown.shape[1] == len(time_s)
    # Sums in another order, in dB.
    assert np.allclose(shown, decibels(psd[: len(shown)]), rtol=0, atol=1e-6)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("time, s", "frequency, Hz")
    assert f"PSD, dB re 1 {found.unit}" in [other.get_ylabel() for other in ax.figure.axes]
    assert found.plot(1).get_xlabel() == "frequency, Hz"
    # Of silence there is no spectrum in decibels, and the figure over time stands alone.
    assert pz.spectrogram(np.zeros(4000), rate=rate, unit="m/s2").plot().get_xlabel() == "time, s"


def test_a_transfer_function_is_its_lines(data: Path) -> None:
    measured = pz.transfer(data / "bench.parquet", drive="drive", response="acceleration")
    h = measured.function()
    axes = [ax for number in range(1, len(measured.captions) + 1) for ax in np.atleast_1d(measured.plot(number))]
    gain = decibels(np.abs(h.response) ** 2)
    drawn = [xy(line) for ax in axes for line in ax.lines]
    wanted = dict(zip(h.frequency_hz, gain))
    matching = [x for x, y in drawn if len(x) > 100 and all(value in wanted for value in x) and np.allclose(y, [wanted[value] for value in x], rtol=0, atol=1e-6)]
    assert matching, "no line is the gain in dB"
    coherence = dict(zip(h.frequency_hz, h.coherence))
    assert any(len(x) > 100 and all(value in coherence for value in x) and np.allclose(y, [coherence[value] for value in x]) for x, y in drawn)


def test_an_association_matrix_is_its_percentages(data: Path) -> None:
    found = pz.answers(data / "answers.csv")
    numbers = [number for number in range(1, len(found.captions) + 1) if np.ndim(found.plot(number)) == 0 and found.plot(number).images]
    assert numbers
    ax = found.plot(numbers[0])
    shown = np.asarray(ax.images[0].get_array())
    names = [text.get_text() for text in ax.get_yticklabels()]
    assert names == [text.get_text() for text in ax.get_xticklabels()] == ["S0", "S1", "S2", "S3"]
    for i, presented in enumerate(names):
        rows = [(p, a) for p, a in answers(data) if p == presented]
        for j, answered in enumerate(names):
            share = 100 * sum(a == answered for _, a in rows) / len(rows)
            assert abs(shown[i, j] - share) < 1e-9, (presented, answered)


def answers(data: Path) -> list[tuple[str, str]]:
    rows = (data / "answers.csv").read_text(encoding="utf-8").splitlines()[1:]
    return [(row.split(",")[3], row.split(",")[4]) for row in rows]


def test_every_figure_of_every_report_is_drawn(data: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(data)
    results: list[pz.Result] = [
        pz.spectrum("texture.wav"),
        pz.noise("S8.parquet", channel="acceleration"),
        pz.strokes(["S8.parquet", "S1.parquet"], by="sample"),
        pz.compare(["S8.parquet", "S1.parquet"], by="sample"),
        pz.roughness("profile.txt", cutoff="0.8mm", x_unit="mm", z_unit="um"),
        pz.transfer("bench.parquet", drive="drive", response="acceleration"),
        pz.verify(target="texture.wav", measured="measured.parquet"),
        pz.score("S8.parquet", "S1.parquet"),
        pz.manipulate("texture.wav", [("gain", "-3dB")]),
        pz.answers("answers.csv"),
        pz.eeg_erd("P01_natural.vhdr", participant="P01", task="natural", event="natural", eog="VEOG,HEOG", reject_above=150.0),
    ]
    for found in results:
        page = html.unescape(re.sub(r"<[^>]*>", "", found.to_html()))
        assert found.captions, type(found).__name__
        for number, caption in enumerate(found.captions, start=1):
            assert caption in page
            axes = list(np.atleast_1d(found.plot(number)))
            figure = axes[0].figure
            figure.canvas.draw()
            labels = [label for ax in figure.axes for label in (ax.get_xlabel(), ax.get_ylabel()) if label]
            assert labels or caption, (type(found).__name__, number)
            for label in labels:
                assert label in page, (type(found).__name__, number, label)
            plt.close(figure)
        with pytest.raises(pz.UsageError, match=f"expected a number from 1 to {len(found.captions)}, found 99"):
            found.plot(99)


def test_a_result_without_a_figure_says_so(data: Path) -> None:
    with pytest.raises(pz.UsageError, match="Info has no figure"):
        pz.info(data / "texture.wav").plot()
    rendered = pz.render(data / "texture.wav", transfer=data / "tf.json", level="fit")
    with pytest.raises(pz.UsageError, match="Rendering has no figure"):
        rendered.plot()


def test_without_matplotlib_the_error_says_what_to_install(data: Path) -> None:
    code = f"""
import sys
sys.modules["matplotlib"] = None
import piezotact as pz
found = pz.spectrum({str(data / "texture.wav")!r})
try:
    found.plot()
except ModuleNotFoundError as error:
    print(error)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "pip install matplotlib" in done.stdout and "piezotact[plot]" in done.stdout
