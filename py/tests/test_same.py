"""Every function gives the document that the command prints, to the last bit."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import piezotact as pz
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from conftest import DATE, command, made

FIRST = "twin:participant=4,seed=7"

#: Two tasks of two participants.
DESYNCHRONISATIONS = [f"erd_P0{participant}_{task}.json" for participant in (1, 2) for task in ("natural", "imagery")]

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
    ("eeg_stats", (DESYNCHRONISATIONS,), {"flips": 100, "seed": 3}),
    ("twin_record", (), {"bench": "acttouch", "sample": "S3", "participant": 4, "speed": "30mm/s", "strokes": 2, "seed": 1, "out": "S3.parquet"}),
]


#: What takes arrays: what each of them is cut from, and the other arguments.
OF_ARRAYS: list[tuple[str, list[str], dict[str, Any]]] = [
    ("info", ["S8.parquet"], {}),
    ("spectrum", ["S8.parquet"], {"channel": "acceleration", "segment": 500}),
    ("spectrogram", ["texture.wav"], {"segment": 256}),
    ("noise", ["S8.parquet"], {"channel": "acceleration"}),
    ("strokes", ["S8.parquet"], {"load": 0.2, "touch": "active"}),
    ("cut", ["S8.parquet", "S1.parquet"], {}),
    ("compare", ["S8.parquet", "S1.parquet"], {"by": "file", "load": 0.2, "touch": "active"}),
    ("transfer", ["bench.parquet"], {"drive": "drive", "response": "acceleration", "segment": 512}),
    ("render", ["texture.wav"], {"transfer": "tf.json", "level": "fit"}),
    ("manipulate", ["texture.wav"], {"operations": [("tilt", "3dB/oct@200Hz"), "randomise_phases"], "seed": 7}),
    ("verify", ["texture.wav", "measured.parquet"], {}),
    ("score", ["S8.parquet", "S1.parquet"], {"band": (20, 500)}),
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
    if name == "eeg_stats":
        desynchronise(data)
    document = call(name, positional, named).to_dict()
    words = document["invocation"]["command"]
    if name in {"panel_run", "panel_add"}:
        # It would go on with what is there.
        shutil.rmtree(data / {"panel_run": "panel", "panel_add": "added"}[name])
    printed = command(*words, cwd=data)
    assert printed.returncode in {0, 3, 4, 5}, printed.stderr
    assert json.loads(printed.stdout) == document


def desynchronise(data: Path) -> None:
    """Makes the documents of two tasks of two participants."""
    for file in DESYNCHRONISATIONS:
        _, participant, task = file.removesuffix(".json").split("_")
        recording = f"{participant}_{task}.vhdr"
        if not (data / recording).exists():
            made(data, "twin", "record", "--bench", "eeg", "--task", task, "--participant", participant[-1], "--seed", "7", "--trials", "10", "--out", recording)
        made(data, "eeg", "erd", recording, "--participant", participant, "--task", task, "--event", task, "--out", file)


#: Fields that hold a name of a file or of an argument.
PLACES = {"invocation", "file", "provenance", "name", "recording", "out", "target", "called", "source", "cuts_are_looked_for_in"}


def bare(value: Any) -> Any:
    """A document without where its data come from and go to."""
    if isinstance(value, dict):
        return {key: bare(one) for key, one in value.items() if key not in PLACES and one not in ("arrays", "Parquet")}
    if isinstance(value, list):
        return [bare(one) for one in value]
    # What has no name is called after its argument.
    return re.sub(r"^(odd0\.parquet|recordings)(?=$|[ :(])", "input", value) if isinstance(value, str) else value


def differences(one: Any, other: Any, place: str = "") -> list[str]:
    """Where two documents differ."""
    if isinstance(one, dict) and isinstance(other, dict) and one.keys() == other.keys():
        return [found for key in one for found in differences(one[key], other[key], f"{place}.{key}")]
    if isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        return [found for at, pair in enumerate(zip(one, other)) for found in differences(*pair, f"{place}[{at}]")]
    return [] if one == other else [f"{place}: {one} and {other}"]


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
        ("cut", (["S8.parquet", "S1.parquet"],), {}),
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


@pytest.mark.filterwarnings("ignore::piezotact.Warning")
@pytest.mark.parametrize(("name", "sources", "named"), OF_ARRAYS, ids=[one[0] for one in OF_ARRAYS])
def test_odd_arrays_give_what_the_command_prints_of_their_file(
    data: Path, monkeypatch: pytest.MonkeyPatch, name: str, sources: list[str], named: dict[str, Any]
) -> None:
    """Properties over 6 random cuts for each function that takes arrays, seed 54."""
    monkeypatch.chdir(data)
    random = np.random.default_rng(54)
    for _ in range(6):
        share, rate = float(random.uniform(0, 0.1)), 0.0
        given: list[Any] = []
        files, units = [], []
        for number, source in enumerate(sources):
            recording = pz.read(source)
            rate = recording.rate_hz
            cuts = {one: values[int(share * len(values)) :] for one, values in recording.items()}
            channels = {one: odd(random, values, recording.units[one]) for one, values in cuts.items()}
            files.append(f"odd{number}.parquet")
            columns = {f"{one} ({unit})": [float(value) for value in values] for one, (values, unit) in channels.items()}
            pq.write_table(pa.table(columns), files[-1])
            given.append({one: values for one, (values, _) in channels.items()})
            units.append({one: unit for one, (_, unit) in channels.items()})
        options: dict[str, Any] = {"unit": units[0], "rate": rate}
        if len(sources) > 1:
            # Each has units of its own, and what is compared by file is called as the file.
            given = [pz.recording(channels, rate=rate, unit=unit, name=file) for channels, unit, file in zip(given, units, files)]
            options = {}
        several = name in {"cut", "compare"}
        of_arrays = call(name, (given,) if several else tuple(given), {**named, **options})
        of_files = call(name, (files,) if several else tuple(files), {**named, "rate": rate})
        printed = command(*of_files.to_dict()["invocation"]["command"], cwd=data)
        assert printed.returncode in {0, 3, 4, 5}, printed.stderr
        differ = differences(bare(of_arrays.to_dict()), bare(json.loads(printed.stdout)))
        assert not differ, differ
        assert written(of_arrays) == written(of_files)


#: A thousandth of a unit, in which integers are given.
MILLI = {"m/s²": "mm/s2", "N": "mN"}


def odd(random: np.random.Generator, values: np.ndarray[Any, Any], unit: str) -> tuple[np.ndarray[Any, Any], str]:
    """The samples in some type and layout, and their unit."""
    dtype = str(random.choice(["<f8", ">f8", "<f4", ">f4", *(["<i4", ">i4", "i8"] if unit in MILLI else [])]))
    if "i" in dtype:
        values, unit = values * 1000, MILLI[unit]
    values = values.astype(dtype)
    layout = random.integers(0, 5)
    if layout == 0:
        values.flags.writeable = False
    elif layout == 1:
        values = values[::-1].copy()[::-1]
    elif layout == 2:
        values = np.column_stack([values, values * 0])[:, 0]
    elif layout == 3:
        values = unaligned(values)
    return values, {"FS": "1"}.get(unit, unit)


def written(result: pz.Result) -> Any:
    """The numbers of the file that a function wrote."""
    if isinstance(result, pz.Transfer):
        function = result.function()
        return function.frequency_hz.tolist(), function.response.tolist(), function.coherence.tolist()
    return {name: values.tolist() for name, values in result.recording().items()} if "out" in result.files else None


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
