"""Data sets that the program writes, in front of the validators that others use; and data sets of others in front of its own check.

    python oracles/bids.py PROGRAM

A study of two people on the digital twin (measurement and discrimination) is led and exported, and has no error in
bids-validator-deno (every row of every table, derivatives too), in the legacy bids-validator and in hedtools, without a network.
The check of the program finds nothing in it, and nothing in two data sets that mne-bids writes. Samples are read back by NumPy.
Versions: requirements.txt and package.json beside this file.
"""

import gzip
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
PROGRAM = str(pathlib.Path(sys.argv[1]).resolve())
SAMPLES = ["S2", "S4", "S8", "S9"]


def offline():
    """What runs a program without a network, where the system can."""
    command = ["unshare", "-rn"]
    can = shutil.which("unshare") and subprocess.run(command + ["true"], capture_output=True).returncode == 0
    return command if can else []


OFFLINE = offline()


def done(command, **options):
    result = subprocess.run(command, capture_output=True, text=True, **options)
    if result.returncode:
        raise SystemExit(f"{' '.join(map(str, command))}: {result.returncode}\n{result.stdout[-3000:]}\n{result.stderr[-3000:]}")
    return result.stdout


def ours(folder, line):
    return done([PROGRAM] + line.split(), cwd=folder)


def answer(text):
    """What is typed at a prompt: consent, Enter, and the choices in the order in which they stand there."""
    text = " ".join(text.split())
    if text.endswith("consent>"):
        return "yes"
    if not text.endswith(" answer>") or text.endswith(("or another answer>", "Enter when it is done answer>")):
        return ""
    order = re.findall(r"all of (.*?) in order", text)
    if order:
        return order[-1]
    count = re.findall(r"for each of the (\d+), one of", text)
    count = int(count[-1]) if count else 1
    choices = text.rsplit("one of ", 1)[1].split(" answer>")[0].split(" ")
    return " ".join((choices * count)[:count])


def session(folder, line):
    """A session on the terminal, typed to its end."""
    said = open(folder / "said.txt", "w+b")
    process = subprocess.Popen(
        [PROGRAM] + line.split(), cwd=folder, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=said
    )
    shown = b""
    while True:
        more = os.read(process.stdout.fileno(), 1 << 16)
        if not more:
            break
        shown += more
        if shown.rstrip(b" ").endswith(b">"):
            # Two trials within one millisecond have one onset, and HED takes them for one event; a person is slower.
            time.sleep(0.005)
            process.stdin.write((answer(shown.decode()) + "\n").encode())
            process.stdin.flush()
            shown = b""
    if process.wait():
        said.seek(0)
        raise SystemExit(f"{line}: {process.returncode}\n{shown.decode()}\n{said.read().decode()}")


def protocol(text):
    """The isotropic protocol of the library with four samples, two sets, and both sessions on one day."""
    head, rest = text.split("[[sets]]", 1)
    head = re.sub(r"samples = \[.*?\]", f"samples = {json.dumps(SAMPLES)}", head, count=1)
    sets = '[[sets]]\nname = "A"\nsamples = ["S2", "S4", "S8"]\n\n[[sets]]\nname = "M"\nsamples = ["S4", "S8", "S9"]\n\n[[tasks]]'
    text = head + sets + rest.split("[[tasks]]", 1)[1]
    text = text.replace('playing = { how = "repeated", pause_s = 0.5, duration_s = 30 }', 'playing = { how = "once" }')
    return text.replace("another_day", "any_time")


def study(folder):
    ours(folder, "campaign protocol isotropic_triplets --out library.toml")
    (folder / "protocol.toml").write_text(protocol((folder / "library.toml").read_text()))
    ours(folder, "campaign new study --protocol protocol.toml --seed 7")
    recordings = []
    for person in (1, 2):
        bench = f"twin:participant={person},seed=7"
        own = [f"P0{person}_{sample}.parquet" for sample in SAMPLES]
        for sample, name in zip(SAMPLES, own):
            ours(
                folder,
                f"twin record --bench acttouch --sample {sample} --participant {person} --seed 7 --strokes 3 --stroke-time 1s --out {name}",
            )
        ours(folder, f"characterise --bench {bench} --out tf{person}.json")
        ours(folder, f"prepare {' '.join(own)} --transfer tf{person}.json --bench {bench} --mode texture --out drives{person}")
        session(folder, f"campaign run study P0{person} measurement --age {30 * person} --sex female --handedness right")
        session(folder, f"campaign run study P0{person} discrimination --drives drives{person} --bench {bench}")
        recordings += own
    # EEG while strokes were felt, and while samples were touched: as BrainVision and as EDF+.
    brains = ["P01_task3.vhdr", "P02_measure.edf"]
    for person, task, name in [(1, "control", brains[0]), (2, "natural", brains[1])]:
        ours(folder, f"twin record --bench eeg --task {task} --trials 2 --participant {person} --seed 7 --out {name}")
    ours(
        folder,
        f"bids export study --recordings {' '.join(recordings)} --eeg {' '.join(brains)} --eeg-reference ideal --line 50Hz"
        " --transfer tf1.json tf2.json --license CC0 --author A --author B --out bids",
    )
    return folder / "bids"


def errors_of_deno(value, place="/"):
    issues = value["issues"]["issues"]
    found = [(place, issue.get("location"), issue["code"], issue.get("issueMessage")) for issue in issues if issue["severity"] == "error"]
    for name, of in (value.get("derivativesSummary") or {}).items():
        # Names of derived files are in its .bidsignore, which is read where it is the root.
        found += [one for one in errors_of_deno(of, name) if one[2] != "NOT_INCLUDED"]
    return found


def deno(dataset, *options):
    command = [*OFFLINE, str(pathlib.Path(sys.executable).parent / "bids-validator-deno"), "--format", "json", "--max-rows", "-1"]
    result = subprocess.run(command + [*options, dataset], capture_output=True, text=True)
    return errors_of_deno(json.loads(result.stdout))


def legacy(dataset):
    command = [*OFFLINE, "node", str(HERE / "node_modules/.bin/bids-validator"), dataset, "--json"]
    result = subprocess.run(command, capture_output=True, text=True)
    return [(one["key"], len(one["files"])) for one in json.loads(result.stdout)["issues"]["errors"]]


def hed(dataset):
    code = "import json, sys; from hed.tools import BidsDataset; print(json.dumps([str(one) for one in BidsDataset(sys.argv[1]).validate()]))"
    out = done([*OFFLINE, sys.executable, "-c", code, str(dataset)])
    return json.loads(out.strip().splitlines()[-1])


def ours_finds(dataset):
    command = [*OFFLINE, PROGRAM, "bids", "check", str(dataset), "--json", "--second-opinion", "none"]
    result = subprocess.run(command, capture_output=True, text=True)
    return json.loads(result.stdout)["problems"]


def samples_agree(dataset):
    """The samples of every signal as NumPy reads them: as many rows and columns as stated, all finite."""
    count = 0
    for path in dataset.rglob("*.tsv.gz"):
        sidecar = json.loads(path.with_name(path.name.replace(".tsv.gz", ".json")).read_text())
        with gzip.open(path, "rt") as file:
            rows = np.loadtxt(file, delimiter="\t", ndmin=2)
        assert rows.shape[1] == len(sidecar["Columns"]) and np.isfinite(rows).all(), path
        count += 1
    assert count > 20
    return count


def brains_agree(folder, dataset):
    """What differs between the EEG that was recorded and what mne-bids reads of the data set: samples (32 bits) and events."""
    import mne
    import mne_bids

    mne.set_log_level("ERROR")
    differ = []
    for subject, session, task, own in [
        ("P01", "discrimination", "task3", "P01_task3.vhdr"),
        ("P02", "measurement", "measure", "P02_measure.edf"),
    ]:
        path = mne_bids.BIDSPath(subject=subject, session=session, task=task, run="1", datatype="eeg", root=dataset)
        read = mne_bids.read_raw_bids(path, verbose=False)
        readers = {".vhdr": mne.io.read_raw_brainvision, ".edf": mne.io.read_raw_edf}
        made = readers[pathlib.Path(own).suffix](folder / own)
        apart = np.abs(read.get_data() - made.get_data()).max()
        # The largest sample has 24 bits of a 32-bit number.
        if read.ch_names != made.ch_names or apart > np.abs(made.get_data()).max() * 2.0**-23:
            differ.append(f"{own}: samples {apart} V apart")
        rows = [line.split("\t") for line in (dataset / path.fpath.relative_to(dataset)).with_name(path.basename.replace("_eeg", "") + "_events.tsv").read_text().splitlines()[1:]]
        onsets = np.array([float(row[0]) for row in rows])
        rate_hz = made.info["sfreq"]
        if len(onsets) != len(read.annotations) or np.abs(np.round(read.annotations.onset * rate_hz) - np.round(onsets * rate_hz)).max() > 0:
            differ.append(f"{own}: {len(read.annotations)} events for {len(onsets)}, or other samples")
        own_events = made.annotations[[not text.startswith("New Segment") for text in made.annotations.description]]
        markers = np.round(np.sort(own_events.onset) * rate_hz)
        if len(markers) != len(onsets) or np.abs(markers - np.round(np.sort(onsets) * rate_hz)).max() > 0:
            differ.append(f"{own}: events are not those that were recorded")
    return differ


def of_mne(folder):
    """Two data sets that mne-bids writes: BrainVision with events and sessions, and EDF of two people without."""
    import mne
    import mne_bids

    mne.set_log_level("ERROR")
    random = np.random.Generator(np.random.PCG64(1))

    def raw(rate_hz, seconds, names):
        info = mne.create_info(names, rate_hz, "eeg")
        made = mne.io.RawArray(random.standard_normal((len(names), int(rate_hz * seconds))) * 1e-5, info)
        made.set_montage("standard_1020")
        made.info["line_freq"] = 50
        return made

    sets = [folder / "brainvision", folder / "edf"]
    one = raw(500.0, 20.0, ["Fz", "C3", "Cz", "C4", "Pz"])
    one.set_annotations(mne.Annotations([1.0, 4.5, 19.9], [0.0, 0.5, 0.0], ["touch", "rest", "touch"]))
    for run in (1, 2):
        path = mne_bids.BIDSPath(subject="01", session="a", task="touch", run=run, datatype="eeg", root=sets[0])
        mne_bids.write_raw_bids(one, path, allow_preload=True, format="BrainVision", verbose=False)
    for subject in ("01", "02"):
        other = raw(256.0, 10.0, ["C3", "C4"])
        path = mne_bids.BIDSPath(subject=subject, task="rest", datatype="eeg", root=sets[1])
        mne_bids.write_raw_bids(other, path, allow_preload=True, format="EDF", verbose=False)
    return sets


def main():
    failed = []
    checks = 0

    def none(what, found):
        nonlocal checks
        checks += 1
        print(f"{what}: {len(found)} errors", flush=True)
        if found:
            failed.append(f"{what}: {found[:10]}")

    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        dataset = study(folder)
        none("bids-validator-deno", deno(dataset))
        none("bids-validator-deno with derivatives", deno(dataset, "-r"))
        none("bids-validator-deno on the derivatives alone", deno(dataset / "derivatives/piezotact"))
        none("legacy bids-validator", legacy(dataset))
        none("hedtools", hed(dataset))
        none("piezotact bids check", ours_finds(dataset))
        none("mne_bids.read_raw_bids", brains_agree(folder, dataset))
        print(f"NumPy: {samples_agree(dataset)} files of signals read")
        sums = subprocess.run(["sha256sum", "--quiet", "-c", "SHA256SUMS"], cwd=dataset / "sourcedata", capture_output=True, text=True)
        none("sha256sum", sums.stdout.split("\n")[:-1])
        for other in of_mne(folder):
            none(f"piezotact bids check on {other.name} of mne-bids", ours_finds(other))
            none(f"bids-validator-deno on {other.name} of mne-bids", deno(other))
    if failed:
        raise SystemExit("\n".join(failed))
    print(f"{checks} passed, 0 failed")


if __name__ == "__main__":
    main()
