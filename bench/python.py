"""The package for Python beside SciPy and beside the command, in one run.

    python3 bench/python.py PROGRAM FOLDER [REPETITIONS [WORK ...]]    in an environment with the wheel, scipy and pyarrow

W1  the PSD of one channel of 10 min at 5 kHz        spectrum
W2  the transfer function of a pair of 60 s at 5 kHz  transfer
W5  strokes of an hour, four channels at 5 kHz        strokes

The inputs and SciPy's side are those of `bench/peers.py`. Each repetition takes its turn: SciPy on arrays, the function on the same
arrays, the function on a file, PROGRAM on that file with `--json`, and `PROGRAM --version`, whose median is subtracted: PROGRAM may be
the command of the wheel, which starts Python and NumPy. Times are of the processor, of all threads. A function does what its command
does: it looks for what is wrong with the samples, and makes a document and a report. Printed are medians with their quartiles, SciPy's
time over each, and its time over the command's on the file. Of W5 SciPy does less: it judges no stroke.
"""

import json
import os
import pathlib
import statistics
import subprocess
import sys
import time
import warnings

import numpy as np
import peers
import piezotact as pz
import pyarrow as pa
import pyarrow.parquet as pq

NAMES = {"W1": ["acceleration"], "W2": ["drive", "nail"], "W5": ["acceleration", "fx", "fy", "force_z"]}
UNITS = {"acceleration": "m/s2", "drive": "1", "nail": "m/s2", "fx": "N", "fy": "N", "force_z": "N"}


def stored(folder, work):
    """The arrays of a work, and a file of them."""
    kept = {"W1": "W1a", "W2": "W2a", "W5": "W5"}[work]
    if not (folder / f"{kept}.f64").exists():
        made = {"W1": lambda: [peers.texture(3_000_000, 1)], "W2": lambda: peers.pair(300_000, 2), "W5": peers.an_hour_of_strokes}
        peers.keep(folder, kept, *made[work]())
    arrays = dict(zip(NAMES[work], peers.load(folder, kept).reshape(len(NAMES[work]), -1)))
    path = folder / f"{work}.parquet"
    if not path.exists():
        columns = {"time (s)": np.arange(len(next(iter(arrays.values())))) / peers.RATE}
        columns |= {f"{name} ({UNITS[name]})": values for name, values in arrays.items()}
        pq.write_table(pa.table(columns), path)
    return arrays, str(path)


def contestants(program, folder, work):
    arrays, path = stored(folder, work)
    given = dict(rate=peers.RATE, unit={name: UNITS[name] for name in arrays})
    if work == "W1":
        scipy, function, named = peers.w1a_scipy(folder)[1], pz.spectrum, {}
    elif work == "W2":
        scipy, function = peers.w2a(peers.scipy_transfer)(folder)[1], pz.transfer
        named = dict(drive="drive", response="nail", segment=2048)
    else:
        scipy, function, named = peers.w5_scipy(folder)[1], pz.strokes, dict(load=0.5, touch="active")
    words = [program, function.__name__, path, "--json", *(f"--{name}={value}" for name, value in named.items())]
    out = folder / "bench-python.json"

    def command():
        out.unlink(missing_ok=True)
        return child([*words, f"--out={out}"] if work == "W2" else words)

    return {
        "SciPy, arrays": lambda: own(scipy),
        "function, arrays": lambda: own(lambda: function(arrays, **given, **named)),
        "function, file": lambda: own(lambda: function(path, **named)),
        "command, file": command,
        "command, start": lambda: child([program, "--version"]),
    }


def own(run):
    start = time.process_time()
    run()
    return time.process_time() - start


def child(words):
    running = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    said = running.stderr.read().decode()
    _, status, used = os.wait4(running.pid, 0)
    running.returncode = os.waitstatus_to_exitcode(status)
    running.stderr.close()
    if running.returncode != 0:
        sys.exit(f"{' '.join(words)}: {said}")
    return used.ru_utime + used.ru_stime


def main():
    program, folder, repetitions = sys.argv[1], pathlib.Path(sys.argv[2]), int((sys.argv[3:] or ["9"])[0])
    folder.mkdir(parents=True, exist_ok=True)
    warnings.simplefilter("ignore")
    print(f"{'work':4} {'contestant':17} {'median, ms':>10} {'quartiles, ms':>17} {'SciPy / it':>10} {'it / command':>12}")
    for work in sys.argv[4:] or NAMES:
        runs = contestants(program, folder, work)
        times = {name: [] for name in runs}
        for turn in range(repetitions + 1):
            for name, run in runs.items():
                took = run()
                # The first turn is not counted.
                if turn > 0:
                    times[name].append(took)
        start = statistics.median(times["command, start"])
        times["command, file"] = [took - start for took in times["command, file"]]
        medians = {name: statistics.median(taken) for name, taken in times.items()}
        for name, taken in times.items():
            low, _, high = statistics.quantiles(taken, n=4)
            ratio, beside = medians["SciPy, arrays"] / medians[name], medians[name] / medians["command, file"]
            print(f"{work:4} {name:17} {medians[name] * 1e3:10.1f} {f'{low * 1e3:.1f} to {high * 1e3:.1f}':>17} {ratio:10.2f} {beside:12.3f}", flush=True)
        print(json.dumps({"work": work, "ms": {name: [round(one * 1e3, 2) for one in taken] for name, taken in times.items()}}), file=sys.stderr)


if __name__ == "__main__":
    main()
