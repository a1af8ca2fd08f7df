"""Arrays: right, or refused with what was expected and what was found."""

from __future__ import annotations

import gc
import pickle
import threading
from pathlib import Path
from typing import Any

import numpy as np
import piezotact as pz
import pytest

RATE = 5000.0


def sine(count: int = 5000) -> Any:
    return np.sin(np.arange(count) / 5)


@pytest.mark.parametrize(
    ("values", "expected", "found"),
    [
        (np.array([1, "a"], dtype=object), "expected real numbers", "found object"),
        (np.array(["1", "2"]), "expected real numbers", "found <U1"),
        (sine().astype(complex), "expected real numbers", "found complex128"),
        (sine() > 0, "expected real numbers", "found bool"),
        (sine().astype(np.longdouble), "expected real numbers", "found"),
        (np.array(["2026-01-01"], dtype="datetime64[D]"), "expected real numbers", "found datetime64"),
        (np.float64(3), "expected an array of samples", "found a single number"),
        (3.5, "expected an array of samples", "found a single number"),
        (np.zeros((3, 4)), "expected one row of samples", "found an array of shape (3, 4)"),
        (np.array([]), "expected samples", "found none"),
        ([], "expected samples", "found none"),
        ([[1.0], [1.0, 2.0]], "expected an array of samples", "found a list"),
        (np.array([1.0, np.nan, 2.0]), "expected samples within", "found NaN at sample 1"),
        (np.array([1.0, np.inf, 2.0]), "expected samples within", "found inf at sample 1"),
        (np.array([2**60, 1]), "expected integers within ±2**53", "found 1152921504606846976"),
        (np.ma.masked_less(sine(), 0), "expected samples without gaps", "masked"),
    ],
)
def test_what_is_no_row_of_samples_is_refused(values: Any, expected: str, found: str) -> None:
    with pytest.raises(pz.Error) as refused:
        pz.spectrum(values, rate=RATE, unit="m/s2")
    assert expected in str(refused.value) and found in str(refused.value), refused.value


@pytest.mark.parametrize(
    ("named", "expected"),
    [
        ({"unit": "m/s2"}, "expected the sampling rate of the array"),
        ({"rate": "5 kHz", "unit": "m/s2"}, "expected a number in Hz, found '5 kHz'"),
        ({"rate": -1.0, "unit": "m/s2"}, "-1"),
        ({"rate": float("nan"), "unit": "m/s2"}, "NaN"),
        ({"rate": True, "unit": "m/s2"}, "expected a number in Hz, found True"),
        ({"rate": RATE, "unit": 3}, "expected a unit such as 'm/s2', found 3"),
        ({"rate": RATE, "unit": {"acc": "m/s2"}}, "expected units of the channels signal"),
    ],
)
def test_a_rate_and_a_unit_are_asked_for(named: dict[str, Any], expected: str) -> None:
    with pytest.raises(pz.Error, match=expected.replace("(", r"\(")):
        pz.spectrum(sine(), **named)


def test_an_array_without_a_unit_is_refused_where_the_unit_decides() -> None:
    for unit in (None, "N"):
        with pytest.raises(pz.Error, match=r"expected .*m/s²"):
            pz.score(sine(), sine(), rate=RATE, unit=unit)
    with pytest.raises(pz.Error, match="expected an array"):
        pz.spectrum("missing.wav", unit="m/s2")


@pytest.mark.filterwarnings("ignore::piezotact.Warning")
def test_a_unit_that_is_not_known_is_refused() -> None:
    functions: list[Any] = [pz.info, pz.spectrum, pz.strokes]
    for function in functions:
        with pytest.raises(pz.DataError, match=r"one of the units m/s2, .*, found `bananas`"):
            function(sine(), rate=RATE, unit="bananas")
    with pytest.raises(pz.DataError, match="for `fz` one of the units"):
        pz.recording({"acc": sine(), "fz": sine()}, rate=RATE, unit={"acc": "g", "fz": "2 bananas"})
    # What the program computes nothing from is kept, and what a recording says of its units can be stated again.
    made = pz.recording({"acc": sine(), "tz": sine(), "count": sine()}, rate=RATE, unit={"acc": "g", "tz": "Nm"})
    assert made.units == {"acc": "m/s²", "tz": "Nm", "count": "no unit"}
    assert pz.recording(dict(made), rate=RATE, unit=made.units).units == made.units


def test_what_files_state_is_not_left_out_silently_of_a_recording(data: Path) -> None:
    plain = pz.recording(sine(), rate=RATE)
    with pytest.raises(pz.UsageError, match="state the unit where the recording is made"):
        pz.spectrum(plain, scale="200 m/s2")
    with pytest.raises(pz.UsageError, match="found a recording in memory"):
        pz.spectrum(plain, part=2)


def test_kinds_of_errors(tmp_path: Path) -> None:
    with pytest.raises(pz.DataError, match="no such file") as data_error:
        pz.read(tmp_path / "none.wav")
    assert data_error.value.kind == "data" and isinstance(data_error.value, pz.Error)
    with pytest.raises(pz.UsageError, match="overlap") as usage_error:
        pz.spectrum(sine(), rate=RATE, unit="m/s2", overlap=2)
    assert usage_error.value.kind == "usage"
    with pytest.raises(TypeError, match="unexpected keyword"):
        pz.spectrum(sine(), rate=RATE, unit="m/s2", overlapp=0.5)  # type: ignore[call-arg]


def test_samples_are_views_that_outlive_their_recording(data: Path) -> None:
    recording = pz.read(data / "S8.parquet")
    first, again = recording["acceleration"], recording["acceleration"]
    assert np.shares_memory(first, again) and not first.flags.writeable and not first.flags.owndata
    with pytest.raises(ValueError):
        first.flags.writeable = True
    before = first[:100].copy()
    del recording, again
    gc.collect()
    assert (first[:100] == before).all()


@pytest.mark.filterwarnings("ignore::piezotact.Warning")
def test_a_recording_says_what_it_is() -> None:
    made = pz.recording(
        {"acc": sine(), "fz": np.full(5000, 200)}, rate=RATE, unit={"acc": "g", "fz": "mN"}, name="S8", condition={"sample": "S8", "load_n": 0.2}
    )
    assert made.units == {"acc": "m/s²", "fz": "N"} and list(made) == ["acc", "fz"]
    assert made["fz"][0] == 200 * 1e-3 and made["acc"][1] == sine()[1] * 9.80665
    assert made.condition == {"sample": "S8", "load_n": 0.2} and made.rate_hz == RATE and made.duration_s == 1.0
    about = pz.info(made).to_dict()
    assert [channel["name"] for channel in about["channels"]] == ["acc", "fz"] and about["file"] == "S8", about
    with pytest.raises(KeyError, match="expected one of the channels acc, fz"):
        made["force"]
    with pytest.raises(pz.UsageError, match="found wight"):
        pz.recording(sine(), rate=RATE, condition={"wight": 3})
    with pytest.raises(ValueError, match="load_n|invalid"):
        pz.recording(sine(), rate=RATE, condition={"load_n": "heavy"})
    with pytest.raises(TypeError, match="give the path"):
        pickle.dumps(made)


@pytest.mark.filterwarnings("ignore::piezotact.Warning")
def test_a_table_of_pandas_is_channels_by_their_names() -> None:
    pandas = pytest.importorskip("pandas")
    table = pandas.DataFrame({"acc": sine(), "fz": np.cos(np.arange(5000)), "note": "rough"})
    units = {"acc": "m/s2", "fz": "N"}
    made = pz.recording(table[["acc", "fz"]], rate=RATE, unit=units)
    assert made.units == {"acc": "m/s²", "fz": "N"} and (made["acc"] == sine()).all()
    assert pz.spectrum(table["acc"], rate=RATE, unit="m/s2").psd.tolist() == pz.spectrum(sine(), rate=RATE, unit="m/s2").psd.tolist()
    with pytest.raises(pz.UsageError, match=r"array, note: expected real numbers .* found (object|str)"):
        pz.recording(table, rate=RATE, unit=units)
    with pytest.raises(pz.UsageError, match="expected one row of samples"):
        pz.spectrum(table.to_numpy()[:, :2].astype(float), rate=RATE, unit="m/s2")


@pytest.mark.filterwarnings("ignore::piezotact.Warning")
def test_what_python_does_with_an_array_later_changes_nothing() -> None:
    values = sine()
    made = pz.recording(values, rate=RATE, unit="m/s2")
    before = pz.spectrum(made).to_dict()
    values[:] = 0
    assert pz.spectrum(made).to_dict() == before


@pytest.mark.filterwarnings("ignore::piezotact.Warning")
def test_threads_give_the_same_as_one_after_the_other() -> None:
    rows = [np.random.default_rng(number).standard_normal(20_000) for number in range(8)]
    alone = [pz.spectrum(row, rate=RATE, unit="m/s2").to_dict() for row in rows]
    together: dict[int, Any] = {}

    def work(number: int) -> None:
        together[number] = pz.spectrum(rows[number], rate=RATE, unit="m/s2").to_dict()

    threads = [threading.Thread(target=work, args=(number,)) for number in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert [together[number] for number in range(8)] == alone


@pytest.mark.filterwarnings("ignore::piezotact.Warning")
def test_results_go_to_other_processes() -> None:
    found = pz.spectrum(sine(), rate=RATE, unit="m/s2")
    again = pickle.loads(pickle.dumps(found))
    assert type(again) is pz.Spectrum and again == found
    assert again.to_dict() == found.to_dict() and again.to_html() == found.to_html() and str(again) == str(found)
