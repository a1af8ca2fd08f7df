"""Staircases and QUEST+ on 500 simulated observers, by programs from the Python package index.

Writes crates/piezotact-people/tests/golden/adaptive.json. QUEST+: questplus. Staircase: psychopy's StairHandler, of which only the
module psychopy/data/staircase.py is run (`pip install --no-deps psychopy`); nothing of it is linked or copied.

    pip install questplus numpy scipy xarray && pip install --no-deps psychopy
    python golden/adaptive.py
"""

import importlib.metadata
import importlib.util
import json
import math
import pathlib
import sys
import types

import numpy as np
import questplus

OBSERVERS = 500
TRIALS = 48
GUESS, LAPSE, SLOPE = 0.5, 0.02, 3.5
LEVELS = np.arange(-40.0, 0.5, 1.0)
THRESHOLDS = np.arange(-40.0, 0.5, 1.0)
SLOPES = [2.0, 3.5, 5.0]
LAPSES = [0.0, 0.02, 0.04]


def uniforms(seed):
    """SplitMix64 (Steele, Lea and Flood 2014): the same numbers in any language."""
    mask = (1 << 64) - 1
    state = seed & mask
    while True:
        state = (state + 0x9E3779B97F4A7C15) & mask
        z = state
        z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & mask
        z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & mask
        z ^= z >> 31
        yield (z >> 11) / float(1 << 53)


def share(level_db, threshold_db):
    return 1 - LAPSE - (1 - GUESS - LAPSE) * math.exp(-(10 ** (SLOPE * (level_db - threshold_db) / 20)))


def observer(index):
    """The true threshold, spread over -30 to -10 dB, and the numbers that decide its answers."""
    numbers = uniforms(index + 1)
    return -30 + 20 * next(numbers), numbers


def quest(index):
    truth, numbers = observer(index)
    run = questplus.QuestPlusWeibull(
        intensities=LEVELS,
        thresholds=THRESHOLDS,
        slopes=SLOPES,
        lower_asymptotes=[GUESS],
        lapse_rates=LAPSES,
        responses=["correct", "wrong"],
        stim_scale="dB",
        stim_selection_method="min_entropy",
        param_estimation_method="mean",
    )
    levels = []
    for _ in range(TRIALS):
        level = float(run.next_intensity)
        levels.append(level)
        answer = "correct" if next(numbers) < share(level, truth) else "wrong"
        run.update(intensity=level, response=answer)
    return truth, float(run.param_estimate["threshold"]), levels


def stair_handler():
    """psychopy.data.staircase without the rest of psychopy."""

    class Quiet:
        def __getattr__(self, name):
            return lambda *a, **k: None

    class Base:
        def __init__(self, *a, **k):
            pass

        def getExp(self):
            return None

        def getOriginPathAndFile(self, path):
            return path, None

        def _terminate(self):
            raise StopIteration

    found = importlib.util.find_spec("psychopy").submodule_search_locations[0]
    source = pathlib.Path(found, "data", "staircase.py").read_text()
    fakes = {
        "psychopy": types.ModuleType("psychopy"),
        "psychopy.data": types.ModuleType("psychopy.data"),
    }
    fakes["psychopy"].logging = Quiet()
    fakes["psychopy.data"].__path__ = []
    for name, parts in {
        "psychopy.logging": {},
        "psychopy.tools": {},
        "psychopy.tools.filetools": {"openOutputFile": None, "genDelimiter": None, "genFilenameFromDelimiter": None},
        "psychopy.tools.fileerrortools": {"handleFileCollision": None},
        "psychopy.contrib": {},
        "psychopy.contrib.quest": {"QuestObject": type("QuestObject", (), {})},
        "psychopy.contrib.psi": {"PsiObject": type("PsiObject", (), {})},
        "psychopy.data.base": {"_BaseTrialHandler": Base, "_ComparisonMixin": type("Comparison", (), {})},
        "psychopy.data.utils": {"_getExcelCellName": None},
    }.items():
        module = types.ModuleType(name)
        module.__dict__.update(parts)
        module.__path__ = []
        fakes[name] = module
    fakes["psychopy.data"].base = fakes["psychopy.data.base"]
    sys.modules.update(fakes)
    module = types.ModuleType("psychopy.data.staircase")
    module.__package__ = "psychopy.data"
    exec(compile(source, "staircase.py", "exec"), module.__dict__)
    return module.StairHandler


def staircase(handler, index):
    truth, numbers = observer(index)
    run = handler(
        startVal=0.0, nReversals=12, stepSizes=[4.0, 4.0, 2.0, 2.0, 1.0], nTrials=0, nUp=1, nDown=3,
        applyInitialRule=True, stepType="lin", minVal=-60.0, maxVal=0.0,
    )
    levels = []
    while True:
        try:
            level = next(run)
        except StopIteration:
            break
        levels.append(float(level))
        run.addResponse(1 if next(numbers) < share(level, truth) else 0)
    reversals = [float(level) for level in run.reversalIntensities]
    return truth, float(np.mean(reversals[4:])), levels


def summary(pairs):
    errors = np.array([estimate - truth for truth, estimate in pairs])
    return {"bias_db": float(errors.mean()), "sd_db": float(errors.std(ddof=1))}


def main():
    handler = stair_handler()
    quests = [quest(index) for index in range(OBSERVERS)]
    stairs = [staircase(handler, index) for index in range(OBSERVERS)]
    out = {
        "versions": {name: importlib.metadata.version(name) for name in ("questplus", "psychopy", "numpy", "scipy")},
        "observers": OBSERVERS,
        "trials": TRIALS,
        "quest": {
            **summary([(t, e) for t, e, _ in quests]),
            "estimates_db": [e for _, e, _ in quests],
            "levels_db": [levels for _, _, levels in quests[:20]],
        },
        "staircase": {
            **summary([(t, e) for t, e, _ in stairs]),
            "estimates_db": [e for _, e, _ in stairs],
            "levels_db": [levels for _, _, levels in stairs[:20]],
        },
    }
    path = pathlib.Path(__file__).parent.parent / "crates/piezotact-people/tests/golden/adaptive.json"
    path.parent.mkdir(exist_ok=True)
    path.write_text(json.dumps(out) + "\n")
    print(out["versions"], out["quest"]["bias_db"], out["quest"]["sd_db"], out["staircase"]["bias_db"], out["staircase"]["sd_db"])


main()
