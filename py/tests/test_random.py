"""Random calls: a result or an exception, never a crash, and no memory that stays."""

from __future__ import annotations

import os
import random
import resource
from pathlib import Path
from typing import Any

import numpy as np
import piezotact as pz
import pytest

COUNT = int(os.environ.get("PIEZOTACT_RANDOM_CALLS", "2000"))
SEED = 1953

ODD: list[Any] = [
    None, True, False, 0, -1, 1, 2**63, 1e308, -1e308, 1e-308, float("nan"), float("inf"), "", " ", "a", "m/s2", "--help", "-x", "N", "200 m/s2",
    "\0", "é" * 300, "..", "20..500", (20, 500), (1, 2, 3), [], [1, 2], ["a"], {}, {"a": 1}, b"x", object(), np.nan, np.int64(3), np.float32(2),
    np.array(3), np.array([]), np.zeros((2, 2)), Path("missing"), range(3), "hann", "sample", "acceleration", "fz=N",
]
DTYPES = ["f8", "f4", ">f8", "f2", "i1", "u2", ">i4", "i8", "u8", "bool", "c16", "O", "U3", "M8[s]"]
NAMES = ["spectrum", "spectrogram", "noise", "strokes", "cut", "compare", "score", "transfer", "verify", "render", "roughness", "answers", "recording", "read"]


def array(dice: random.Random) -> Any:
    """An array of some type, shape and content."""
    count = dice.choice([0, 1, 2, 7, 64, 300, 5000, 5000, 5000])
    values: Any = np.array([dice.gauss(0, 50) for _ in range(count)])
    values = values.astype(dice.choice(["f8", "f8", "f4", ">f8", "<i4", *DTYPES]) if dice.random() < 0.7 else "f8")
    if dice.random() < 0.1 and values.dtype.kind == "f" and count:
        values[dice.randrange(count)] = dice.choice([np.nan, np.inf, 1e200 if values.dtype.itemsize == 8 else 1e4])
    if dice.random() < 0.2:
        values = values[:: dice.choice([-1, 2, -3])]
    if dice.random() < 0.05:
        values = values.reshape(1, -1)
    return values


def value(dice: random.Random) -> Any:
    if dice.random() < 0.2:
        return dice.choice(ODD)
    if dice.random() < 0.8:
        return array(dice)
    return {dice.choice(["acc", "fz", "drive", "", 3]): array(dice) for _ in range(dice.randrange(3))}


def plausible_call(dice: random.Random, arguments: dict[str, list[str]]) -> None:
    """A call that may well be right, with one odd argument every second time."""
    name = dice.choice(["spectrum", "noise", "recording", "score", "strokes"])
    named: dict[str, Any] = {}
    for one in arguments[name + ":required"]:
        values: Any = np.array([dice.gauss(0, 3) for _ in range(5000)]).astype(dice.choice(["f8", ">f4", "f4", "<i2"]))
        named[one] = {"acc": values} if dice.random() < 0.3 else values[:: dice.choice([1, 1, -1, 2])]
    named["rate"], named["unit"] = dice.choice([5000, 2000.5]), dice.choice(["m/s2", "g", "2 g"])
    if dice.random() < 0.5:
        named[dice.choice(arguments[name])] = dice.choice(ODD)
    getattr(pz, name)(**named)


def one_call(dice: random.Random, arguments: dict[str, list[str]]) -> None:
    name = dice.choice(NAMES if dice.random() < 0.5 else ["spectrum", "noise", "recording", "score"])
    function = getattr(pz, name)
    required, optional = arguments[name + ":required"], arguments[name]
    named = {one: value(dice) for one in required}
    if dice.random() < 0.6:
        for one in dice.sample(optional, min(len(optional), dice.randrange(1, 4))):
            named[one] = dice.choice(ODD)
    if ("rate" in optional or "rate" in required) and dice.random() < 0.9:
        named["rate"] = dice.choice([5000.0, 5000.0, 48000, 1e-3, 1e12, 100])
        if "unit" in optional:
            named["unit"] = dice.choice(["m/s2", "m/s2", "g", "N", "1", None, {"acc": "m/s2"}])
    function(**named)


@pytest.fixture(scope="module")
def arguments() -> dict[str, list[str]]:
    """The arguments of each function, without those that write."""
    import inspect

    found: dict[str, list[str]] = {}
    for name in NAMES:
        every = inspect.signature(getattr(pz, name)).parameters.values()
        found[name + ":required"] = [one.name for one in every if one.default is one.empty]
        writing = {"report", "csv", "figures", "tables", "out", "record", "write_cuts", "bench", "columns"}
        found[name] = [one.name for one in every if one.default is not one.empty and one.name not in writing]
    return found


@pytest.mark.filterwarnings("ignore")
def test_random_calls_give_results_or_exceptions(arguments: dict[str, list[str]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    dice = random.Random(SEED)
    given = refused = 0
    sizes = []
    for number in range(COUNT):
        try:
            (plausible_call if dice.random() < 0.3 else one_call)(dice, arguments)
            given += 1
        except (pz.Error, TypeError, ValueError, OverflowError) as error:
            assert str(error), f"call {number} of seed {SEED} was refused without a sentence: {error!r}"
            refused += 1
        if number % 100 == 99:
            sizes.append(resident_mb())
    assert given > COUNT // 10 and refused > COUNT // 3, (given, refused)
    # After a quarter of the calls everything that is kept is there: what is freed late is a few MB.
    assert max(sizes[-5:]) < sizes[4] + 40, sizes


def resident_mb() -> float:
    """The memory that this process has now, in MB."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * resource.getpagesize() / 1e6


@pytest.mark.filterwarnings("ignore")
def test_memory_stays_flat_over_calls_of_a_large_array() -> None:
    """40 calls of an array of 16 MB: were one kept, 640 MB would be."""
    values = np.random.default_rng(1).standard_normal(2_000_000)
    sizes = []
    for _ in range(40):
        pz.spectrum(values, rate=5000.0, unit="m/s2")
        sizes.append(resident_mb())
    assert max(sizes[10:]) < sizes[9] + 60, sizes
