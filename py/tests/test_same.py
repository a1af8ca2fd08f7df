"""Every function gives the document that the command prints, to the last bit."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import piezotact as pz
import pytest
from conftest import DATE, command

FIRST = "twin:participant=4,seed=7"

#: A function, its arguments, and which of them are files of the folder.
CALLS: list[tuple[str, tuple[Any, ...], dict[str, Any]]] = [
    ("info", ("S8.parquet",), {}),
    ("info", ("tf.json",), {}),
    ("info", ("drive.wav",), {}),
    ("spectrum", ("texture.wav",), {}),
    ("spectrum", ("texture.wav",), {"segment": 512, "overlap": 0.25, "window": "blackman", "median": True}),
    ("spectrum", ("S8.parquet",), {"channel": "acceleration"}),
    ("spectrogram", ("S8.parquet",), {"channel": "acceleration", "max_frequency": 500.0}),
    ("noise", ("S8.parquet",), {"channel": "acceleration", "band": (20, 500)}),
    ("strokes", ("S8.parquet",), {}),
    ("strokes", (["S8.parquet", "S1.parquet"],), {"by": "sample"}),
    ("cut", ("S8.parquet",), {}),
    ("compare", (["S8.parquet", "S1.parquet"],), {"by": "sample"}),
    ("roughness", ("profile.txt",), {"cutoff": "0.8mm", "x_unit": "mm", "z_unit": "um"}),
    ("transfer", ("bench.parquet",), {"drive": "drive", "response": "acceleration", "out": "own.json"}),
    ("transfer", ("bench.parquet",), {"drive": "drive", "response": "acceleration", "estimator": "h2", "segment": 1024, "out": "own2.json"}),
    ("characterise", (), {"bench": FIRST, "seconds": 3.0, "out": "again.json"}),
    ("render", ("texture.wav",), {"transfer": "tf.json", "level": "fit", "out": "again.wav"}),
    ("play", ("drive.wav",), {"bench": FIRST, "record": "again.parquet"}),
    ("verify", (), {"target": "texture.wav", "measured": "measured.parquet"}),
    ("score", ("texture.wav", "measured.parquet"), {}),
    ("score", ("S8.parquet", "S1.parquet"), {"band": (20, 500)}),
    ("answers", ("answers.csv",), {}),
    ("campaign_design", ("isotropic_triplets",), {"participants": 8}),
    ("manipulate", ("S8.parquet", [("gain", "-3dB"), ("tilt", "3dB/oct@200Hz"), ("gain", "1dB")]), {"stroke": 2, "out": "soft.wav"}),
    ("manipulate", ("texture.wav", [("tilt", "3dB/oct@200Hz"), "randomise_phases"]), {"seed": 7, "out": "phases.wav"}),
    ("prepare", (["S8.parquet", "S1.parquet"],), {"transfer": "tf.json", "bench": FIRST, "out": "prepared"}),
    ("panel_run", (), {"bench": "twin:seed=7", "participants": "1..3", "loads": [0.2], "angles": [20], "repeats": 1, "seconds": 3.0, "out": "panel"}),
    ("panel_add", ("added", ["tf.json"]), {"participant": "P04", "load": 0.2, "angle": 20.0, "placement": 2}),
    ("panel_analyse", ("panel",), {}),
    ("panel_average", ("panel",), {"out": "average.json"}),
    ("eeg_erd", ("P01_natural.vhdr",), {"participant": "P01", "task": "natural", "event": "natural", "eog": "VEOG,HEOG", "reject_above": 150.0}),
    ("twin_record", (), {"bench": "acttouch", "sample": "S3", "participant": 4, "speed": "30mm/s", "strokes": 2, "seed": 1, "out": "S3.parquet"}),
]


def call(name: str, positional: tuple[Any, ...], named: dict[str, Any]) -> pz.Result:
    found: pz.Result = getattr(pz, name)(*positional, **named, date=DATE, force=True)
    return found


@pytest.mark.filterwarnings("ignore::piezotact.Warning")
@pytest.mark.parametrize(("name", "positional", "named"), CALLS)
def test_a_function_equals_its_command(
    data: Path, monkeypatch: pytest.MonkeyPatch, name: str, positional: tuple[Any, ...], named: dict[str, Any]
) -> None:
    monkeypatch.chdir(data)
    document = call(name, positional, named).to_dict()
    words = document["invocation"]["command"]
    if name in {"panel_run", "panel_add"}:
        # It would go on with what is there.
        shutil.rmtree(data / {"panel_run": "panel", "panel_add": "added"}[name])
    printed = command(*words, cwd=data)
    assert printed.returncode in {0, 3, 4, 5}, printed.stderr
    assert json.loads(printed.stdout) == document


def bare(value: Any) -> Any:
    """A document without where its data come from."""
    if isinstance(value, dict):
        return {key: bare(one) for key, one in value.items() if key not in {"invocation", "file", "provenance", "name", "recording"}}
    if isinstance(value, list):
        return [bare(one) for one in value]
    return value


@pytest.mark.filterwarnings("ignore::piezotact.Warning")
@pytest.mark.parametrize(
    ("name", "positional", "named"),
    [
        ("info", ("S8.parquet",), {}),
        ("spectrum", ("texture.wav",), {"segment": 1024}),
        ("spectrum", ("S8.parquet",), {"channel": "acceleration", "over_time": True, "report": "over.html"}),
        ("spectrogram", ("texture.wav",), {"segment": 512}),
        ("noise", ("S8.parquet",), {"channel": "acceleration"}),
        ("strokes", ("S8.parquet",), {}),
        ("strokes", (["S8.parquet", "S1.parquet"],), {"by": "sample"}),
        ("compare", (["S8.parquet", "S1.parquet"],), {"by": "sample"}),
        ("score", ("S8.parquet", "S1.parquet"), {}),
        ("transfer", ("bench.parquet",), {"drive": "drive", "response": "acceleration"}),
    ],
)
def test_a_recording_in_memory_is_the_same_as_its_file(
    data: Path, monkeypatch: pytest.MonkeyPatch, name: str, positional: tuple[Any, ...], named: dict[str, Any]
) -> None:
    monkeypatch.chdir(data)

    def read(path: Any) -> Any:
        return [pz.read(one) for one in path] if isinstance(path, list) else pz.read(path)

    of_file = call(name, positional, named).to_dict()
    of_memory = call(name, tuple(read(path) for path in positional), named).to_dict()
    assert "invocation" in of_file and "invocation" not in of_memory
    for document in (of_file, of_memory):
        document.pop("invocation", None)
        document.pop("out", None)
    assert of_memory == of_file


@pytest.mark.filterwarnings("ignore::piezotact.Warning")
def test_slices_strides_and_dtypes_are_the_same_as_their_copies(data: Path) -> None:
    """Properties over 60 random pieces, seed 53."""
    random = np.random.default_rng(53)
    recording = pz.read(data / "S8.parquet")
    whole = recording["acceleration"]
    for _ in range(60):
        first = int(random.integers(0, len(whole) // 2))
        last = int(random.integers(first + 4096, len(whole) + 1))
        step = int(random.choice([-2, -1, 1, 2, 3]))
        dtype = random.choice(["<f8", ">f8", "<f4", ">f4", "<i2", ">i4", "i8", "u1"])
        scale = 1.0 if dtype.endswith(("f8", "f4")) else 10.0
        piece = (whole[first:last] * scale + (50 if dtype == "u1" else 0)).clip(*((0, 200) if dtype == "u1" else (-3e4, 3e4)))
        piece = piece.astype(dtype)[::step]
        if random.random() < 0.3:
            piece = unaligned(piece)
        if random.random() < 0.3:
            piece = piece.copy()
            piece.flags.writeable = False
        plain = np.array([float(value) for value in piece])
        options: dict[str, Any] = {"rate": recording.rate_hz, "unit": "m/s2", "segment": int(random.choice([128, 256, 500]))}
        assert pz.spectrum(piece, **options).to_dict() == pz.spectrum(plain, **options).to_dict()


def unaligned(array: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """The same numbers at an address that no processor likes."""
    buffer = np.zeros(array.nbytes + 1, dtype=np.uint8)
    moved: np.ndarray[Any, Any] = buffer[1:].view(array.dtype)
    moved[:] = array
    assert not moved.flags.aligned or array.dtype.itemsize == 1
    return moved


def test_attributes_are_the_fields_of_the_document(data: Path) -> None:
    found = pz.spectrum(data / "texture.wav")
    document = found.to_dict()
    assert found.psd.tolist() == document["psd"] and found.frequency_hz.dtype == np.float64
    assert found.config.segment == document["config"]["segment"]
    assert found.unit == "(m/s²)²/Hz" or found.unit == document["unit"]
    with pytest.raises(ValueError, match="read-only"):
        found.psd[0] = 1
    with pytest.raises(AttributeError, match="it has .*psd"):
        _ = found.density


@pytest.mark.filterwarnings("ignore::piezotact.Warning")
def test_the_table_is_that_of_the_command(data: Path, tmp_path: Path) -> None:
    table = tmp_path / "strokes.csv"
    found = pz.strokes([data / "S8.parquet", data / "S1.parquet"], by="sample", csv=table)
    assert found.to_csv() == table.read_text(encoding="utf-8")
    columns = found.to_columns()
    assert len(columns["stroke"]) == 12 and all(isinstance(one, int) for one in columns["stroke"])
    assert found.to_pandas().to_dict("list").keys() == columns.keys()
    numbers = [name for name, values in columns.items() if all(isinstance(one, float) and one == one for one in values)]
    assert len(numbers) > 5
    for name in numbers:
        assert found.to_arrow()[name].to_pylist() == columns[name] == found.to_pandas()[name].tolist()
    # Numbers are whole in the table: those of the document.
    first = found.to_dict()["recordings"][0]["strokes"][0]
    assert any(columns[name][0] in first.values() for name in numbers), first


@pytest.mark.filterwarnings("ignore::piezotact.Warning")
def test_a_report_is_that_of_the_command(data: Path, tmp_path: Path) -> None:
    own = tmp_path / "own.html"
    found = pz.spectrum(data / "texture.wav", report=own)
    again = tmp_path / "again.html"
    assert found.report(again) == again and found.report(again) == again
    # The one of the command holds besides how it was made.
    title = "<title>"
    page, made = again.read_text(encoding="utf-8"), own.read_text(encoding="utf-8")
    assert page.startswith("<!DOCTYPE html>") and title in page and "<svg" in page
    assert made.startswith(page.split("</body>")[0][:2000]) and "rerun" in made and "rerun" not in page
    again.write_text("notes of mine", encoding="utf-8")
    with pytest.raises(pz.UsageError, match="exists already"):
        found.report(again)
    assert found.report(again, force=True).read_text(encoding="utf-8") == page
    with pytest.raises(pz.UsageError, match="ends in .html"):
        found.report(tmp_path / "report.pdf")
    shown = found._repr_html_()
    assert shown is not None and shown.startswith("<iframe srcdoc=")


@pytest.mark.filterwarnings("ignore::piezotact.Warning")
def test_what_is_written_to_a_temporary_folder_goes_with_the_result(data: Path) -> None:
    import gc

    measured = pz.transfer(data / "bench.parquet", drive="drive", response="acceleration")
    place = measured.files["out"]
    function = measured.function()
    stored = json.loads(place.read_text(encoding="utf-8"))
    assert function.response.real.tolist() == stored["real"] and function.response.imag.tolist() == stored["imaginary"]
    assert function.frequency_hz.tolist() == stored["frequency_hz"]
    rendered = pz.render(data / "texture.wav", transfer=measured, level="fit")
    assert rendered.recording().units == {"drive": "FS"}
    del measured
    gc.collect()
    # The function stands for the file too.
    assert pz.read_transfer(function) == function
    del function
    gc.collect()
    assert not place.exists()


def test_one_of_several_files_that_fails_is_said(data: Path, tmp_path: Path) -> None:
    (tmp_path / "noise.csv").write_text("time (s),acc (m/s2)\n0,1\n", encoding="utf-8")
    import warnings

    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        found = pz.strokes([data / "S8.parquet", tmp_path / "noise.csv"])
    assert found.ended == "done in part" and found.failed is not None and len(found.failed) == 1
    assert any("noise.csv" in str(one.message) and one.category is pz.Warning for one in warned)
