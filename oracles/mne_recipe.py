"""The recipe of docs/guide/mne.md, run on a recording whose desynchronisation is known.

    python oracles/mne_recipe.py PROGRAM

The twin records EEG with blinks whose mu rhythm falls by 80 % while surfaces are touched, and nothing else changes alpha.
docs/guide/recipes/clean.py takes the eye movements out in MNE-Python. `eeg erd` of what it exports gives at C3 what was put in, and
the same as the regression of `eeg erd --eog`. Markers keep their samples, and blinks are gone. The short pieces of the chapter run too.
Versions: requirements.txt beside this file.
"""

import json
import pathlib
import re
import subprocess
import sys
import tempfile

import mne
import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
GUIDE = HERE.parent / "docs/guide"
PROGRAM = str(pathlib.Path(sys.argv[1]).resolve())

CHANGE_PERCENT = -80.0
# Ninety trials and a window of 0.7 s of noise 1.5 Hz wide: the mean power of each part is uncertain by 1/sqrt(90 * 1.05), 10 %, so the
# ratio by 15 % of itself, 3 points; the logistic course and the background take less than 1 point. Two standard deviations.
FROM_TRUTH_POINTS = 6.0
# Both see the same alpha in the same trials. What differs is the alpha that each takes out with the blinks: the component or the
# EOG channel holds up to a few percent of it, before and after the onset alike, which moves the ratio by less than its share.
FROM_REGRESSION_POINTS = 2.0

PARAMETERS = {
    "eeg.desynchronisation": {"control": CHANGE_PERCENT / 100, "person_spread": 0.0, "task_spread": 0.0, "surface_spread": 0.0},
    "eeg.alpha": {"occipital_v": 0.0},
    "eeg.background": {"rms_v": 2e-6},
}
SURFACES = ["M8", "BIO", "M3"]


def done(command, folder):
    result = subprocess.run([str(word) for word in command], capture_output=True, text=True, cwd=folder)
    if result.returncode:
        raise SystemExit(f"{command}: {result.returncode}\n{result.stdout[-2000:]}\n{result.stderr[-2000:]}")
    return result.stdout


def recorded(folder):
    lines = []
    for section, values in PARAMETERS.items():
        lines.append(f"[{section}]")
        lines += [f'{name} = {{ value = {value}, origin = "measured", note = "a known change" }}' for name, value in values.items()]
    (folder / "twin.toml").write_text("\n".join(lines) + "\n")
    record = "twin record --bench eeg --task control --participant 3 --trials 30 --twin twin.toml --out P03_control.vhdr"
    done([PROGRAM, *record.split()], folder)


def percent_at_c3(folder, file, *options):
    """The change of alpha at C3 over all surfaces, %."""
    events = [word for surface in SURFACES for word in ("--event", f"control/{surface}=touch")]
    command = f"eeg erd {file} --participant P03 --task control --window 0.5,1.2 --out erd.json".split()
    done([PROGRAM, *command, *events, *options, "--force"], folder)
    regions = json.loads((folder / "erd.json").read_text())["regions"]
    (c3,) = [one for one in regions if one["place"] == "C3"]
    assert c3["epochs"] == 90, c3
    return c3["percent"]


def onsets(path):
    raw = mne.io.read_raw(path)
    own = [one for one in raw.annotations if "control/" in one["description"]]
    return np.round([one["onset"] * raw.info["sfreq"] for one in own]), raw


def epochs_of(raw, names, picks, **options):
    events, names = mne.events_from_annotations(raw, event_id={marker: code for code, marker in enumerate(names, 1)})
    return mne.Epochs(raw, events, names, tmin=-1.0, tmax=0.8, baseline=None, preload=True, picks=picks, **options)


def epochs_are_handed_over(folder, check):
    """What `eeg epochs --out` writes is what MNE cuts and rejects from the same recording: values, times, events."""
    limit_uv = 60
    events = [word for surface in SURFACES for word in ("--event", f"control/{surface}={surface}")]
    command = f"eeg epochs P03_control.vhdr --participant P03 --task control --epoch -1.0,0.8 --reject-above {limit_uv} --out epochs.vhdr --json".split()
    counts = json.loads(done([PROGRAM, *command, *events], folder))["counts"]["conditions"]
    ours = mne.io.read_raw(folder / "epochs.vhdr", preload=True)
    whole = mne.io.read_raw(folder / "P03_control.vhdr", preload=True)
    markers = [next(one for one in whole.annotations.description if one.endswith(f"control/{surface}")) for surface in SURFACES]
    handed = epochs_of(ours, [f"Stimulus/{surface}" for surface in SURFACES], ours.ch_names)
    cut = epochs_of(whole, markers, ours.ch_names, reject={"eeg": limit_uv * 1e-6})
    assert 0 < len(cut) < 90 and sum(one["kept"] for one in counts) == len(cut), (len(cut), counts)
    assert list(handed.events[:, 2]) == list(cut.events[:, 2]) and np.array_equal(handed.times, cut.times)
    # Both are in 32 bits.
    check("epochs handed over, V", np.abs(handed.get_data() - cut.get_data()).max(), 1e-11)
    print(f"epochs: {len(cut)} of 90 handed over, the others rejected in MNE too")


def main():
    mne.set_log_level("ERROR")
    checks = []

    def check(what, found, limit):
        checks.append(found <= limit)
        print(f"{what}: {found:.3g}, at most {limit:g}{'' if found <= limit else ': FAILED'}", flush=True)

    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        recorded(folder)
        epochs_are_handed_over(folder, check)
        clean = [sys.executable, GUIDE / "recipes/clean.py", "P03_control.vhdr", "P03_clean.vhdr", "--eog", "VEOG,HEOG"]
        assert "taken out" in done(clean, folder)
        of_components = percent_at_c3(folder, "P03_clean.vhdr")
        of_regression = percent_at_c3(folder, "P03_control.vhdr", "--eog", "VEOG,HEOG")
        print(f"alpha at C3: {of_components:.2f} % after components of MNE, {of_regression:.2f} % after the regression, {CHANGE_PERCENT:g} % put in")
        check("from what was put in, points", abs(of_components - CHANGE_PERCENT), FROM_TRUTH_POINTS)
        check("from the regression, points", abs(of_components - of_regression), FROM_REGRESSION_POINTS)

        (before, raw), (after, cleaned) = onsets(folder / "P03_control.vhdr"), onsets(folder / "P03_clean.vhdr")
        assert len(before) == len(after) == 90
        check("markers moved, samples", np.abs(before - after).max(), 0)
        # A blink is 100 µV at Fp1 for a third of a second, fifteen times a minute; what is left there is background.
        left = [np.ptp(one.get_data(["Fp1"]).reshape(-1)[: len(one.times) // 512 * 512].reshape(-1, 512), axis=1).max() for one in (cleaned, raw)]
        check("blinks left at Fp1, share", left[0] / left[1], 0.3)

        # What a neuroscientist copies from the chapter runs as it stands there, from top to bottom.
        text = (GUIDE / "mne.md").read_text()
        shell = re.findall(r"```bash\n(.*?)```", text, re.S)
        pieces = re.findall(r"```python\n(.*?)```", text, re.S)
        assert len(shell) == 3 and len(pieces) >= 4, (len(shell), len(pieces))
        chapter = folder / "chapter"
        (chapter / "bin").mkdir(parents=True)
        (chapter / "docs").symlink_to(HERE.parent / "docs")
        for name, of in (("piezotact", PROGRAM), ("python3", sys.executable)):
            (chapter / "bin" / name).write_text(f'#!/bin/sh\nexec "{of}" "$@"\n')
            (chapter / "bin" / name).chmod(0o755)
        done(["bash", "-c", "set -e\nPATH=$PWD/bin:$PATH\n" + "".join(shell)], chapter)
        done([sys.executable, "-c", "import matplotlib\nmatplotlib.use('Agg')\n" + "\n".join(pieces)], chapter)
        print(f"mne.md: {len(shell)} blocks of commands and {len(pieces)} pieces of Python run")
    if not all(checks):
        raise SystemExit(f"{len(checks) - sum(checks)} of {len(checks)} checks failed")
    print(f"{len(checks)} passed, 0 failed")


if __name__ == "__main__":
    main()
