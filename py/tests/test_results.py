"""Results: what they print, what goes with them to other processes, what they write without being told where."""

from __future__ import annotations

import copy
import gc
import multiprocessing
import os
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import piezotact as pz
import pytest

pytestmark = pytest.mark.filterwarnings("ignore::piezotact.Warning")


def transfer_of(path: str) -> pz.Transfer:
    return pz.transfer(path, drive="drive", response="acceleration")


def test_the_file_of_a_result_goes_to_another_process(data: Path) -> None:
    here = transfer_of(str(data / "bench.parquet"))
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        (there,) = pool.map(transfer_of, [str(data / "bench.parquet")])
    assert there.function() == here.function()
    place = there.files["out"]
    assert pz.render(data / "texture.wav", transfer=there, level="fit").to_dict()["target"]
    del there
    gc.collect()
    assert not place.exists()


def test_files_go_with_pickle_and_copies(data: Path) -> None:
    measured = pz.transfer(data / "bench.parquet", drive="drive", response="acceleration")
    function, wanted = measured.function(), Path(measured).read_bytes()
    again, its = pickle.loads(pickle.dumps((measured, function)))
    places = {os.fspath(one) for one in (measured, again)}
    del measured, function
    gc.collect()
    # Once more, and as a copy.
    again, its = pickle.loads(pickle.dumps((again, its)))
    copied = copy.deepcopy(again)
    assert Path(again).read_bytes() == Path(its).read_bytes() == Path(copied).read_bytes() == wanted
    assert not places & {os.fspath(again), os.fspath(copied)} and os.fspath(again) != os.fspath(copied)
    stated = pz.transfer(data / "bench.parquet", drive="drive", response="acceleration", out=data / "stated.json")
    assert os.fspath(pickle.loads(pickle.dumps(stated))) == os.fspath(data / "stated.json")


def test_a_transfer_function_without_coherence_at_some_lines_goes_to_another_process() -> None:
    """Where nothing limits the interval of a line, its area in the figure has no end, which JSON does not have."""
    random = np.random.default_rng(5)
    drive = random.standard_normal(20_000)
    unrelated = random.standard_normal(20_000)
    measured = pz.transfer({"drive": drive, "acceleration": unrelated}, rate=5000, unit={"drive": "1", "acceleration": "m/s2"}, drive="drive", response="acceleration")
    again = pickle.loads(pickle.dumps(measured))
    assert again == measured and again.to_html() == measured.to_html()
    assert copy.deepcopy(measured).function() == measured.function()


def test_fields_that_are_words_of_python_have_an_underscore(data: Path) -> None:
    verified = pz.verify(target=data / "texture.wav", measured=data / "measured.parquet")
    document = verified.to_dict()
    assert verified.verdict.is_ == document["verdict"]["is"]
    assert [one.limit.is_ for one in verified.criteria] == [one["limit"]["is"] for one in document["criteria"]]
    with pytest.raises(pz.UsageError, match="a folder that is there"):
        verified.report(data / "nowhere" / "report.html")


def test_a_target_is_known_by_its_samples(data: Path) -> None:
    texture = pz.read(data / "texture.wav")
    x, rate = texture["acceleration"], texture.rate_hz
    rendered = pz.render(x, rate=rate, unit="m/s2", transfer=data / "tf.json", level="fit")
    played = pz.play(rendered, bench="twin:participant=4,seed=7")
    for target, is_other in [(x, False), (1.5 * x, True)]:
        verified = pz.verify(target=target, measured=played, rate=rate, unit="m/s2")
        assert ("other_origin" in [one.code for one in verified.warnings]) == is_other


def test_folders_go_with_pickle(data: Path) -> None:
    textures: list[Any] = [data / "texture.wav", pz.read(data / "S1.parquet")["acceleration"]]
    rendered = pz.render(textures, rate=5000, unit="m/s2", transfer=data / "tf.json", level="fit")
    assert isinstance(rendered, pz.Renderings)
    place = rendered.files["out"]
    wanted = {file.name: file.read_bytes() for file in place.iterdir()}
    assert sum(name.endswith(".wav") for name in wanted) == 2
    again = pickle.loads(pickle.dumps(rendered))
    del rendered
    gc.collect()
    assert not place.exists()
    assert {file.name: file.read_bytes() for file in again.files["out"].iterdir()} == wanted


def test_several_participants_are_rendered_to_a_folder(data: Path) -> None:
    (data / "other.json").write_bytes((data / "tf.json").read_bytes())
    found = pz.render(data / "texture.wav", transfer=[data / "tf.json", data / "other.json"], level="fit")
    assert isinstance(found, pz.Renderings) and found.files["out"].is_dir()
    found = pz.render([data / "texture.wav"], transfer=[data / "tf.json"], level="fit")
    assert found.files["out"].is_file()
    with pytest.raises(pz.UsageError, match=r"^drive.texture\.wav is written twice"):
        pz.render([data / "texture.wav"] * 2, transfer=data / "tf.json")


def test_a_recording_is_its_own_copy(data: Path) -> None:
    recording = pz.read(data / "texture.wav")
    assert copy.copy(recording) is recording and copy.deepcopy({"a": recording})["a"] is recording


def test_results_without_a_report_print_their_facts(data: Path) -> None:
    shown = dict(line.split(maxsplit=1) for line in str(pz.info(data / "S8.parquet")).split("\n") if not line.startswith("channels"))
    assert shown["samples"] == "61081" and shown["rate_hz"] == "5000" and "sample S8" in shown["condition"], shown
    channels = [line for line in str(pz.info(data / "S8.parquet")).split("\n") if line.startswith("channels")]
    assert len(channels) == 4 and "name acceleration" in channels[0] and "unit m/s²" in channels[0]
    played = pz.play(data / "drive.wav", bench="twin:participant=4,seed=7")
    lines = str(played).split("\n")
    assert lines[:3] == ["channels    drive, FS", "channels    acceleration, m/s²", "channels    normal_force, N"], lines
    assert "duration_s  4" in lines
    assert "coherence  " in str(pz.info(data / "tf.json"))


def test_a_field_of_the_name_of_a_method_is_there_too(tmp_path: Path) -> None:
    found = pz.campaign_design("isotropic_triplets")
    assert found.report_.to_dict() == found.to_dict()["report"]
    assert found.report(tmp_path / "design.html").exists()
    with pytest.raises(AttributeError, match="has no 'captions'"):
        _ = found.captions_


@pytest.mark.parametrize("kind", [pz.Spectrum, pz.Strokes, pz.Score])
def test_classes_name_their_attributes(kind: Any) -> None:
    names = [name for name in kind.__annotations__ if name != "SCHEMA"]
    assert names and all(f"`{name}`" in kind.__doc__ for name in names)


def test_attributes_are_listed(data: Path) -> None:
    found = pz.info(data / "S8.parquet")
    assert set(found.to_dict()) <= set(dir(found))
    assert np.asarray([channel.mean for channel in found.channels]).shape == (4,)
