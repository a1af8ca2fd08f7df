"""The memory that commands take on recordings of any length, as of touch.

    python3 bench/large.py make FORMAT HOURS FILE             FORMAT: parquet, time (Parquet with a column of times) or tdms
    python3 bench/large.py memory PROGRAM FOLDER [HOURS ...]  make them, and run the commands on them; 1 and 4 hours where none are stated

Four channels at 5 kHz, from a seed, made in blocks of ten minutes: `acceleration` (m/s2), `normal_force` and `tangential_force` (N) of strokes of
0.8 s with lifts of 0.4 s between them, and `drive`, noise that the acceleration answers by three taps. TDMS has one segment a block. The peak is
that of the resident memory, as the system counts it.

Versions: NumPy 2.4.6, pyarrow 26.0.1, npTDMS 1.13.0.
"""

import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

RATE, BLOCK_S = 5000, 600
NAMES = ["acceleration", "normal_force", "tangential_force", "drive"]
UNITS = ["m/s2", "N", "N", "V"]


def blocks(hours):
    rng = np.random.default_rng(20).standard_normal
    left, at, before = round(hours * 3600 * RATE), 0, np.zeros(2)
    while left > 0:
        n = min(left, BLOCK_S * RATE)
        t = (at + np.arange(n)) / RATE
        drive = rng(n)
        both = np.concatenate([before, drive])
        answer = 0.5 * both[2:] - 0.3 * both[1:-1] + 0.1 * both[:-2]
        before = drive[-2:]
        phase = t % 1.2
        touch = np.clip(np.minimum(phase / 0.1, (0.9 - phase) / 0.1), 0, 1)
        vibration = touch * rng(n) * 2 + 0.02 * rng(n)
        normal = 0.8 * touch * (1 + 0.05 * np.sin(2 * np.pi * 3 * t)) + 0.004 * rng(n)
        tangential = 0.4 * touch * (1 + 0.05 * np.sin(2 * np.pi * 5 * t)) + 0.004 * rng(n)
        yield t, [vibration + 0.5 * answer, normal, tangential, drive]
        left, at = left - n, at + n


def parquet(hours, path, with_time):
    import pyarrow as pa
    import pyarrow.parquet as pq

    names = [f"{name} ({unit})" for name, unit in zip(NAMES, UNITS)]
    schema = pa.schema([(name, pa.float64()) for name in (["time (s)"] if with_time else []) + names])
    with pq.ParquetWriter(path, schema) as writer:
        for t, columns in blocks(hours):
            columns = ([t] if with_time else []) + columns
            writer.write_table(pa.table(columns, schema=schema))


def tdms(hours, path):
    from nptdms import ChannelObject, TdmsWriter

    with TdmsWriter(path) as writer:
        for _, columns in blocks(hours):
            each = zip(NAMES, UNITS, columns)
            writer.write_segment([ChannelObject("touch", n, c, {"wf_increment": 1 / RATE, "unit_string": u}) for n, u, c in each])


def make(kind, hours, path):
    tdms(hours, path) if kind == "tdms" else parquet(hours, path, kind == "time")


def memory(program, folder, hours):
    print(f"{'format':8} {'hours':>6} {'command':10} {'peak, MB':>9} {'time, s':>8} exit")
    for kind in ["parquet", "time", "tdms"]:
        for length in hours:
            file = Path(folder) / f"{kind}.{'tdms' if kind == 'tdms' else 'parquet'}"
            out = Path(folder) / "transfer.json"
            make(kind, length, file)
            rate = ["--rate", str(RATE)] if kind == "parquet" else []
            commands = {
                "spectrum": ["spectrum", file, "--channel", "acceleration"],
                "transfer": ["transfer", file, "--drive", "drive", "--response", "acceleration", "--out", out],
                "strokes": ["strokes", file],
            }
            for name, words in commands.items():
                out.unlink(missing_ok=True)
                began = time.monotonic()
                child = subprocess.Popen([program, *words, *rate], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
                _, status, used = os.wait4(child.pid, 0)
                took = time.monotonic() - began
                code = os.waitstatus_to_exitcode(status)
                print(f"{kind:8} {length:6g} {name:10} {used.ru_maxrss / 1e3:9.0f} {took:8.1f} {code:4}", flush=True)
            file.unlink()


match sys.argv[1:]:
    case ["make", kind, hours, path]:
        make(kind, float(hours), path)
    case ["memory", program, folder, *hours]:
        memory(program, folder, [float(h) for h in hours] or [1.0, 4.0])
    case _:
        sys.exit(__doc__)
