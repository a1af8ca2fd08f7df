"""Strokes of many recordings: equal to those of each, whatever the parts, the engine, and the worker that died."""

from __future__ import annotations

import importlib.util
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import piezotact as pz
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

RECIPES = Path(__file__).parents[2] / "docs" / "guide" / "recipes"
UNITS = {"acceleration": "m/s2", "force_z": "N"}


def bytes_of(parts: list[Any]) -> bytes:
    """The parts in one batch, as the format of Arrow for streams has it."""
    whole = pa.Table.from_batches(parts).combine_chunks()
    sink = pa.BufferOutputStream()
    with pa.ipc.new_stream(sink, whole.schema) as stream:
        stream.write_table(whole)
    found: bytes = sink.getvalue().to_pybytes()
    return found


def paths_of(data: Path) -> Any:
    """Eight recordings in files, of which one is missing and one is null, with labels."""
    paths = [str(data / name) for name in ["S8.parquet", "S1.parquet", "missing.parquet", "S1.parquet", "S8.parquet", "S8.parquet", "S1.parquet"]]
    labels = {"session": [1, 1, 2, 2, None, 3, 3, 4], "note": pa.array(["a", None, "b", "a", "b", "b", "a", "a"]).dictionary_encode()}
    return pa.record_batch({"path": [*paths, None], "load_n": [0.2, None, 0.2, 0.3, None, 0.2, None, None], **labels})


def arrays_of(data: Path, kind: Any = None) -> Any:
    """Two recordings in lists, of which the second has no force."""
    read = [pz.read(data / "S8.parquet"), pz.read(data / "S1.parquet")]
    channels: dict[str, list[Any]] = {name: [one[name] for one in read] for name in UNITS}
    channels["force_z"][1] = None
    columns = {name: pa.array(values, kind or pa.list_(pa.float64())) for name, values in channels.items()}
    return pa.record_batch({"participant": [4, 5], **columns, "rate_hz": [one.rate_hz for one in read]})


def same(line: dict[str, Any], table: dict[str, list[Any]], number: int) -> None:
    """A line of a batch has the values of a table of strokes, to the last bit."""
    for name, values in table.items():
        if name == "file" or name.startswith("label_"):
            continue
        value = values[number]
        value = None if value is None or value != value else value
        found = line[name]
        assert (found.hex() == float(value).hex()) if isinstance(found, float) and value is not None else str(found) == str(value), name


@pytest.mark.filterwarnings("ignore::piezotact.Warning")
def test_the_lines_of_files_are_the_strokes_of_each(data: Path) -> None:
    rows = paths_of(data)
    lines = pz.batch(rows, high_pass=10).to_pylist()
    at = 0
    for row in rows.to_pylist():
        if row["path"] is None or "missing" in row["path"]:
            assert lines[at]["stroke"] is None and lines[at]["rms"] is None and lines[at]["path"] == row["path"]
            assert ("missing.parquet" if row["path"] else "found null") in lines[at]["error"], lines[at]
            at += 1
            continue
        found = pz.strokes(row["path"], load=row["load_n"], high_pass=10)
        table = found.to_columns()
        assert len(table["stroke"]) == 6
        for number in range(6):
            line = lines[at]
            same(line, table, number)
            assert (line["session"], line["note"], line["error"]) == (row["session"], row["note"], None)
            assert (line["warnings"] or "").split() == list(dict.fromkeys(one.code for one in found.warnings))
            at += 1
    assert at == len(lines) == 38


@pytest.mark.filterwarnings("ignore::piezotact.Warning")
@pytest.mark.parametrize("kind", [None, pa.list_(pa.float32()), pa.large_list(pa.float64())])
def test_the_lines_of_arrays_are_the_strokes_of_each(data: Path, kind: Any) -> None:
    rows = arrays_of(data, kind)
    found = pz.batch(rows, unit=UNITS, vibration="acceleration")
    assert found.schema == pz.batch_schema(rows.schema)
    lines, at = found.to_pylist(), 0
    for number, row in enumerate(rows.to_pylist()):
        dtype = "f4" if kind == pa.list_(pa.float32()) else "f8"
        arrays = {name: np.array(row[name], dtype=dtype) for name in UNITS if row[name] is not None}
        table = pz.strokes(arrays, rate=row["rate_hz"], unit={name: UNITS[name] for name in arrays}, vibration="acceleration").to_columns()
        table["participant"] = [4 + number] * len(table["stroke"])
        for stroke in range(len(table["stroke"])):
            same(lines[at], table, stroke)
            assert lines[at]["rate_hz"] == row["rate_hz"]
            at += 1
    assert at == len(lines) > 6


@pytest.mark.filterwarnings("ignore::piezotact.Warning")
def test_the_columns_are_those_of_the_table(data: Path) -> None:
    header = list(pz.strokes(data / "S8.parquet").to_columns())
    names = pz.batch_schema(pa.schema({"path": pa.string()})).names
    assert ["path", *[name for name in header if name != "file"], "warnings", "error"] == names


def test_parts_change_no_byte(data: Path) -> None:
    for rows, unit in [(paths_of(data), None), (arrays_of(data), UNITS)]:
        made = []
        for count in (1, 2, 8):
            edges = [rows.num_rows * part // count for part in range(count + 1)]
            made.append(bytes_of([pz.batch(rows.slice(one, other - one), unit=unit) for one, other in zip(edges, edges[1:])]))
        assert made[0] == made[1] == made[2] and len(made[0]) > 1000


def test_an_empty_batch_has_the_schema() -> None:
    columns = pa.schema({"path": pa.string(), "session": pa.int8()})
    found = pz.batch(pa.RecordBatch.from_pylist([], schema=columns), load=0.2)
    assert found.num_rows == 0 and found.schema.equals(pz.batch_schema(columns), check_metadata=True)


def test_what_is_stated_of_a_row_counts(data: Path) -> None:
    path = str(data / "S8.parquet")
    rows = pa.record_batch({"path": [path] * 2, "sample": ["silk", None], "touch": ["passive", None], "speed_m_s": [0.02, None]})
    lines = pz.batch(rows).to_pylist()
    stated, own = lines[0], lines[6]
    assert (stated["sample"], stated["touch"], stated["stated_speed_m_s"]) == ("silk", "passive", 0.02)
    assert (own["sample"], own["touch"], own["stated_speed_m_s"]) == ("S8", "active", 0.03)
    assert stated["rms"] == own["rms"]


def numbers(*values: Any) -> Any:
    return pa.array([[float(one) if one is not None else None for one in values]], pa.list_(pa.float64()))


WAVE = [float(one % 7) for one in range(9000)]


@pytest.mark.parametrize(
    ("columns", "sentence"),
    [
        ({"path": pa.array([None], pa.string())}, "path: expected the path of a recording, found null"),
        ({"path": ["missing.wav"]}, "missing.wav"),
        ({"path": [""]}, "path: expected the path of a recording, found an empty text"),
        ({"acc": numbers(*WAVE, None), "rate_hz": [5000.0]}, "acc: expected samples without gaps, found 1 null"),
        ({"acc": numbers(*WAVE, np.nan), "rate_hz": [5000.0]}, "NaN"),
        ({"acc": numbers(*WAVE), "rate_hz": pa.array([None], pa.float64())}, "rate_hz: expected the sampling rate, in Hz, found null"),
        ({"acc": numbers(*WAVE), "rate_hz": [1e300]}, "expected a sampling rate from 0.001 to 1e7 Hz, found 1000000"),
        ({"acc": numbers(*WAVE), "rate_hz": [-1]}, "expected a sampling rate from 0.001 to 1e7 Hz, found -1"),
        ({"acc": numbers(*WAVE), "rate_hz": [np.nan]}, "expected a sampling rate from 0.001 to 1e7 Hz, found NaN"),
        ({"acc": numbers(*WAVE), "fz": numbers(1, 2), "rate_hz": [5000]}, "9000"),
        ({"acc": numbers(), "rate_hz": [5000]}, "acc: expected samples, found none"),
        ({"acc": pa.array([None], pa.list_(pa.float64())), "rate_hz": [5000]}, "acc: expected the samples of a recording, found null"),
        ({"path": ["S8.parquet"], "touch": ["gently"]}, "touch: expected one of active, passive, found 'gently'"),
        ({"path": ["S8.parquet"], "speed_m_s": [np.inf]}, "speed_m_s: expected a speed above 0 m/s, found inf"),
        ({"path": ["S8.parquet"], "load_n": [-0.2]}, "expected a load above 0 N, found -0.2"),
    ],
)
def test_a_recording_that_cannot_be_analysed_says_why(
    data: Path, monkeypatch: pytest.MonkeyPatch, columns: dict[str, Any], sentence: str
) -> None:
    monkeypatch.chdir(data)
    rows = pa.record_batch({**columns, "session": ["first"]})
    unit = None if "path" in columns else {name: "m/s2" for name in columns if name != "rate_hz"}
    (line,) = pz.batch(rows, unit=unit).to_pylist()
    assert sentence in line["error"] and line["session"] == "first" and line["stroke"] is None, line


ACC = {"acc": numbers(*WAVE)}


@pytest.mark.parametrize(
    ("columns", "options", "sentence"),
    [
        ({"session": [1]}, {}, r"expected a column 'path' of texts, or columns of lists of numbers.*found 'session' \(int64\)"),
        ({"path": [1.5]}, {}, "path: expected a column of texts, found double"),
        ({**ACC, "rate_hz": ["5000"]}, {"unit": "g"}, "rate_hz: expected a column of numbers, found string"),
        ({"path": ["x"], "load_n": ["heavy"]}, {}, "load_n: expected a column of numbers, found string"),
        ({"path": ["x"], "participant": [1.5]}, {}, "participant: expected a column of texts or integers, found double"),
        (ACC, {"unit": "g"}, "rate: expected the sampling rate of the channels, in Hz, found none"),
        (ACC, {"rate": 5000}, "acc: expected its unit, such as unit={'acc': 'm/s2'}, found None"),
        ({**ACC, "fz": numbers(1)}, {"rate": 5000, "unit": {"acc": "g"}}, "fz: expected its unit"),
        (ACC, {"rate": 5000, "unit": {"acc": "g", "fz": "N"}}, "expected units of the columns acc, found one of 'fz'"),
        ({**ACC, "fz": [["1"]]}, {"rate": 5000, "unit": {"acc": "g", "fz": "N"}}, "fz: expected a list of numbers in each row, found list"),
        ({"path": ["x"]}, {"unit": "g"}, "expected channels that it is of, found files"),
        ({"path": ["x"], "rms": [1.0]}, {}, "expected labels of other names than the columns of the output, found 'rms'"),
        ({"path": ["x"], "load_n": [0.2]}, {"load": 0.3}, "load: expected it as an option or as the column 'load_n', found both"),
        ({"path": ["x"]}, {"report": "x.html"}, "report: expected one of the options meta, touch, .*, found another"),
        ({"path": ["x"]}, {"schema": pa.schema({"path": pa.string()})}, "expected what batch_schema gave, found a schema without the version"),
        ({"path": ["x"], "day": [1]}, {"schema": pz.batch_schema(pa.schema({"path": pa.string()}))}, r"found day \(int64\)"),
    ],
)
def test_columns_that_are_not_what_is_expected_are_refused(columns: dict[str, Any], options: dict[str, Any], sentence: str) -> None:
    with pytest.raises(pz.UsageError, match=sentence.replace("{'", r"\{'").replace("'}", r"'\}")):
        pz.batch(pa.record_batch(columns), **options)


def test_what_is_no_batch_is_refused() -> None:
    with pytest.raises(pz.UsageError, match="expected a pyarrow.RecordBatch, found a Table; .*Table.to_batches"):
        pz.batch(pa.table({"path": ["x"]}))
    with pytest.raises(pz.UsageError, match="expected a pyarrow.RecordBatch, found a DataFrame; .*from_pandas"):
        pz.batch(pytest.importorskip("pandas").DataFrame({"path": ["x", 3]}))
    with pytest.raises(pz.UsageError, match="expected a pyarrow.Schema, found a list"):
        pz.batch_schema(["path"])
    twice = pa.RecordBatch.from_arrays([pa.array(["x"])] * 2, names=["path", "path"])
    with pytest.raises(pz.UsageError, match="found 'path' twice"):
        pz.batch(twice)


def test_another_version_is_refused() -> None:
    rows = pa.record_batch({"path": ["x"]})
    with pytest.raises(pz.UsageError, match=f"expected piezotact 0.0.9, with which the work was planned, found {pz.__version__} in this process"):
        pz.batch(rows, schema=pz.batch_schema(rows.schema).with_metadata({"piezotact": "0.0.9"}))


ODD: dict[str, list[Any]] = {
    "path": [["S8.parquet"], ["", "\0"], [".."], ["--help", None], [3], [b"x"], ["tf.json", "answers.csv", "drive.wav"]],
    "acc": [[WAVE], [[1.0, None]], [[np.inf] * 9000], [[]], [None], [["a"]], [[1e308] * 9000], [[3] * 9000], [3.5], [{"a": 1}]],
    "rate_hz": [[5000.0], [-1], [2**62], [np.nan], [1e-9], ["x"], [None], [True]],
    "load_n": [[0.2], [0], [np.nan], [1e300], ["x"], [None]],
    "speed_m_s": [[0.03], [-1.0], [1e-320], [np.inf], [None], [b"x"]],
    "touch": [["active"], [""], ["x"], [None], [1]],
    "sample": [["S8"], ["\0"], [3], [1.5], [None]],
    "note": [["x"], [{"a": [1]}], [None], [b"\xff"]],
    "rms": [[1.0]],
}


def test_random_batches_give_batches_or_exceptions(data: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """300 batches of seed 1953."""
    monkeypatch.chdir(data)
    dice = random.Random(1953)
    given = refused = 0
    for _ in range(300):
        names = [dice.choice(["path", "acc"]), *dice.sample(list(ODD), dice.randrange(5))]
        values = {name: dice.choice(ODD[name][:3] if dice.random() < 0.5 else ODD[name]) for name in names if name != "rms" or dice.random() < 0.2}
        count = min(map(len, values.values()))
        rows = pa.record_batch({name: pa.array(column[:count]) for name, column in values.items()})
        units: list[dict[str, Any]] = [{"unit": "m/s2"}, {"unit": {"acc": "g"}}, {}, {"load": 0.2}, {"rate": 5000, "unit": "N"}]
        options = dice.choice([*units, {"vibration": "acc", "unit": "g"}])
        try:
            found = pz.batch(rows, **options)
        except pz.Error as error:
            assert str(error)
            refused += 1
            continue
        found.validate(full=True)
        assert found.schema.equals(pz.batch_schema(rows.schema), check_metadata=True) and found.num_rows >= rows.num_rows
        assert all((line["stroke"] is None) == bool(line["error"]) for line in found.to_pylist())
        given += 1
    assert given > 50 and refused > 50, (given, refused)


# Engines -------------------------------------------------------------------------------------------------------------

NO_DASK = "Dask is not installed: pip install 'dask[dataframe,distributed]'"
needs_dask = pytest.mark.skipif(importlib.util.find_spec("dask") is None, reason=NO_DASK)
needs_spark = pytest.mark.skipif(
    importlib.util.find_spec("pyspark") is None or shutil.which("java") is None, reason="PySpark or Java is not installed"
)


@pytest.fixture
def two(data: Path, tmp_path: Path) -> Path:
    """A folder with two recordings of touch."""
    folder = tmp_path / "two"
    folder.mkdir()
    for name in ["S8.parquet", "S1.parquet"]:
        shutil.copy(data / name, folder)
    return folder


def recipe(name: str, folder: Path, out: Path, *words: str) -> Any:
    """What the script writes of the recordings of touch in `folder`."""
    done = subprocess.run(
        [sys.executable, RECIPES / name, folder, "--out", out, *words], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0 and "12 strokes of 2 recordings, 0 of them" in done.stdout, done.stdout + done.stderr
    return pq.read_table(out)


def here(folder: Path) -> Any:
    """The same as `recipe` in this process."""
    rows = pa.record_batch({"path": [str(path) for path in sorted(folder.iterdir())]})
    return pz.batch(rows)


@needs_dask
def test_the_script_for_dask_gives_the_same_in_any_number_of_parts(two: Path, tmp_path: Path) -> None:
    expected = bytes_of([here(two)])
    for count in (1, 2, 8):
        found = recipe("dask_strokes.py", two, tmp_path / f"{count}.parquet", "--partitions", str(count))
        assert bytes_of(found.combine_chunks().to_batches()) == expected


@needs_spark
def test_the_script_for_spark_gives_the_same_in_any_number_of_parts(two: Path, tmp_path: Path) -> None:
    expected = bytes_of([here(two)])
    for count in (1, 8):
        found = recipe("spark_strokes.py", two, tmp_path / f"{count}.parquet", "--partitions", str(count))
        assert bytes_of(found.combine_chunks().to_batches()) == expected


def part(paths: list[str], schema: Any, seconds: float) -> tuple[int, Any]:
    """The process that did a part, and what it gave."""
    rows = pa.record_batch({"path": paths})
    found = pz.batch(rows, schema=schema)
    time.sleep(seconds)
    return os.getpid(), found


@pytest.mark.filterwarnings("ignore")
def test_a_worker_of_dask_that_is_killed_changes_nothing(data: Path) -> None:
    engine = pytest.importorskip("dask.distributed", reason=NO_DASK)
    paths = [str(data / name) for name in ["S8.parquet", "S1.parquet"]] * 4
    schema = pz.batch_schema(pa.schema({"path": pa.string()}))
    with engine.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, engine.Client(cluster) as client:
        workers = set(client.run(os.getpid).values())
        futures = [client.submit(part, [path], schema, 0.3, pure=False) for path in paths]
        first = next(iter(engine.as_completed(futures)))
        killed = first.result()[0]
        assert killed in workers
        os.kill(killed, signal.SIGKILL)
        found = [future.result() for future in futures]
        with pytest.raises(pz.UsageError, match="expected piezotact 0.0.9"):
            client.submit(part, paths[:1], schema.with_metadata({"piezotact": "0.0.9"}), 0).result()
    # What the killed one had, others did again.
    assert killed not in {process for process, _ in found[1:]} and len({process for process, _ in found}) > 1
    assert bytes_of([one for _, one in found]) == bytes_of([pz.batch(pa.record_batch({"path": paths}))])
