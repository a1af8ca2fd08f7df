"""What is refused: sentences about the arguments of Python, and no words of the command line."""

from __future__ import annotations

import io
import sys
from pathlib import Path
from typing import Any

import numpy as np
import piezotact as pz
import pytest

RATE = 5000
NOISE = np.random.default_rng(1).standard_normal(20_000)

pytestmark = pytest.mark.filterwarnings("ignore::piezotact.Warning")


def refused(call: Any, *values: Any, **named: Any) -> str:
    with pytest.raises(pz.Error) as found:
        call(*values, **named)
    said = str(found.value)
    for word in ("error:", "Usage:", "For more information", "--help", "\n", "/piezotact-"):
        assert word not in said, said
    return said


@pytest.mark.parametrize(
    ("named", "sentence"),
    [
        ({"segment": 1024.5}, "segment: expected a whole number from 0 on, found 1024.5"),
        ({"segment": -1}, "segment: expected a whole number from 0 on, found -1"),
        ({"segment": "long"}, "segment: expected a whole number from 0 on, found 'long'"),
        ({"overlap": "half"}, "overlap: expected a number, found 'half'"),
        ({"over_time": 1}, "over_time: expected True or False, found 1"),
        ({"columns": "3"}, "columns: expected one of 1, 2, found 3"),
        ({"segment": ""}, "segment: expected a whole number from 0 on, found ''"),
        ({"columns": ""}, "columns: expected one of 1, 2, found ''"),
        ({"date": "yesterday"}, None),
    ],
)
def test_values_of_arguments(named: dict[str, Any], sentence: str | None) -> None:
    said = refused(pz.spectrum, NOISE, rate=RATE, unit="g", **named)
    assert said == sentence or sentence is None and "yesterday" in said


def test_what_the_command_expects_is_said_of_the_argument(data: Path) -> None:
    said = refused(pz.spectrum, NOISE, rate=RATE, unit="g", window="hat")
    assert said.startswith("window: expected a window hann, ") and "found `hat`" in said
    said = refused(pz.manipulate, data / "texture.wav", [("gain", "loud")], out="a.wav")
    assert said == "gain: expected a gain in dB, found 'loud'; write for example -3dB"
    said = refused(pz.strokes, data / "S8.parquet", touch="soft")
    assert said == "touch: expected one of active, passive, found 'soft'"
    said = refused(pz.characterise, bench="twin:participant=4,seed=7", seconds=0.5)
    assert said == "expected a duration from 1 to 600 s, found 0.5 s; 60 s is usual (--seconds)"
    assert refused(pz.spectrum, "a.wav", scale="loud").startswith("scale: expected a value above zero with a unit")


def test_names_and_conditions_that_cannot_be() -> None:
    assert "valid text" in refused(pz.recording, {"a\ud800": NOISE}, rate=RATE, unit="g")
    assert refused(pz.recording, {"a": NOISE}, rate=RATE, unit="g", condition={"touch": "soft"}).startswith("condition: ")
    assert "np.abs()" in refused(pz.spectrum, NOISE + 1j, rate=RATE, unit="g")
    assert "rate=" in refused(pz.spectrum, np.arange(5000).astype("datetime64[ms]"), rate=RATE, unit="g")


def test_a_table_of_arrow_has_its_channels() -> None:
    import pyarrow as pa

    table = pa.table({"acc": NOISE, "acc2": NOISE})
    assert list(pz.recording(table, rate=RATE, unit="g")) == ["acc", "acc2"]


def test_required_arguments() -> None:
    assert refused(pz.spectrum, None) == "file: expected a path or an array, found None"
    assert refused(pz.strokes, []) == "recordings: expected a path or an array, found []"
    assert refused(pz.answers, None) == "answers: expected a path, found None"
    assert refused(pz.compare, NOISE, by=None, rate=RATE) == "by: expected a value, found None"


def test_one_value_of_numpy_is_a_value() -> None:
    found = pz.spectrum(NOISE, rate=RATE, unit="g", segment=512, median=False).to_dict()
    for named in ({"segment": 512.0}, {"segment": np.array(512)}, {"segment": np.float32(512), "median": np.False_}):
        assert pz.spectrum(NOISE, rate=np.array(RATE), unit="g", **named).to_dict() == found  # type: ignore[arg-type]


def test_the_median_is_taken_with_a_flag_of_numpy(tmp_path: Path) -> None:
    with_numpy = pz.spectrum(NOISE, rate=RATE, unit="g", median=np.True_, report=tmp_path / "a.html")  # type: ignore[arg-type]
    assert with_numpy.to_dict() == pz.spectrum(NOISE, rate=RATE, unit="g", median=True, report=tmp_path / "b.html").to_dict()
    assert with_numpy != pz.spectrum(NOISE, rate=RATE, unit="g")
    pz.spectrum(NOISE[:10_000], rate=RATE, unit="g", report=tmp_path / "a.html", force=np.True_)  # type: ignore[arg-type]


def test_a_rate_and_a_scale_are_of_something(data: Path) -> None:
    made = pz.recording(NOISE, rate=RATE, unit="g")
    said = refused(pz.spectrum, made, rate=4000)
    assert said == "rate: expected an array or a file that it is of, found a recording, which has its rate; leave it out"
    assert refused(pz.spectrum, made, scale="2 m/s2").endswith("state the unit where the recording is made")
    assert refused(pz.spectrum, pz.read(data / "texture.wav"), scale="2 m/s2").startswith("scale: expected a file")
    assert refused(pz.spectrum, NOISE, rate=RATE, unit="g", scale="2 m/s2").endswith("state the unit with the array, as unit=")
    assert refused(pz.score, data / "texture.wav", made, test_scale="2 m/s2").startswith("test_scale: expected a file")
    # Beside a file they are of the file.
    assert pz.score(made, data / "texture.wav", rate=4000).sentence


@pytest.mark.parametrize(
    ("shape", "advice"),
    [
        ((2, 5000), "{'acc': x[0], 'force': x[1]}"),
        ((5000, 2), "{'acc': x[:, 0], 'force': x[:, 1]}"),
        ((5000, 1), "found an array of shape (5000, 1); give x[:, 0]"),
        ((1, 5000), "found an array of shape (1, 5000); give x[0]"),
        ((2, 2, 5000), "found an array of shape (2, 2, 5000)"),
    ],
)
def test_rows_of_a_table_of_samples(shape: tuple[int, ...], advice: str) -> None:
    assert refused(pz.spectrum, np.zeros(shape), rate=RATE, unit="g").endswith(advice)


@pytest.mark.parametrize(
    ("value", "found"),
    [
        (io.BytesIO(b"RIFF"), "found a BytesIO; give the path"),
        (b"texture.wav", "found a bytes; give a path as str"),
        (["a.wav", Path("b.wav")], "found a list of paths; give one path"),
        ((RATE, NOISE), "found a tuple of a rate and an array; give the array, and its rate as rate="),
    ],
)
def test_what_holds_a_file_and_is_no_path(value: Any, found: str) -> None:
    for named in ({}, {"rate": RATE, "unit": "g"}):
        said = refused(pz.spectrum, value, **named)
        assert said.startswith("file: expected a path or an array, ") and found in said
    assert found in refused(pz.recording, value, rate=RATE)
    for call in (pz.read, pz.read_transfer):
        assert refused(call, value).startswith(f"path: expected a path, {found}")


def test_an_open_file_is_no_path(data: Path) -> None:
    with (data / "texture.wav").open("rb") as opened:
        assert "found a BufferedReader; give the path" in refused(pz.spectrum, opened)


def test_a_unit_that_is_missed_is_asked_for_as_an_argument(data: Path) -> None:
    for values in ((NOISE, NOISE), (pz.recording(NOISE, rate=RATE), pz.recording(NOISE, rate=RATE))):
        said = refused(pz.score, *values, rate=RATE if values[0] is NOISE else None)
        assert said.endswith('use another channel or give its unit: unit="m/s2"')
    assert refused(pz.score, data / "texture.wav", NOISE, rate=RATE).endswith('give its unit: unit="m/s2"')
    assert refused(pz.verify, data / "texture.wav", {"acceleration": NOISE}, rate=RATE).endswith('give its unit: unit="m/s2"')
    plain = data / "plain.npy"
    np.save(plain, NOISE)
    said = refused(pz.score, pz.read(plain, rate=RATE), data / "texture.wav")
    assert said.endswith('use another channel or read it with its unit: scale="1 m/s2"')
    assert pz.score(pz.read(plain, rate=RATE, scale="1 m/s2"), data / "texture.wav").sentence


def test_answers_are_a_file(data: Path) -> None:
    pandas = pytest.importorskip("pandas")
    table = pandas.read_csv(data / "answers.csv")
    said = refused(pz.answers, table)
    assert said == "answers: expected a path, found a DataFrame; write it to a file, answers.to_csv('answers.csv', index=False), and give that path"
    assert pz.answers.__doc__ is not None and "`participant`, `task`, `trial`, `presented` and `answered`" in pz.answers.__doc__
    for name in ("participant", "task", "trial", "presented", "answered"):
        table.drop(columns=name).to_csv(data / "less.csv", index=False)
        with pytest.raises(pz.DataError, match=f"found no {name} among"):
            pz.answers(data / "less.csv")


@pytest.mark.parametrize("name", ["pandas", "polars", "pyarrow"])
def test_a_library_of_tables_that_is_missing(data: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    found = pz.strokes(data / "S8.parquet")
    monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(ModuleNotFoundError, match=f"which is not installed: pip install {name}"):
        getattr(found, f"to_{name.removeprefix('py')}")()
