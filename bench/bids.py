"""B1: the export of a study as a BIDS data set beside `gzip -6` on the same tables, for `./x bench`.

    python3 bench/bids.py PROGRAM [PEOPLE SAMPLES STROKES]

A study on the digital twin of 10 people × 14 samples × 15 strokes is exported, and its tables are compressed by gzip, one after the
other, alternating, five times. CPU seconds of the processes, all on one core; the ratio is to be 2 or less. The peak memory of an
export of all recordings is given beside that of the longest recording alone: it must not grow with the study.
"""

import gzip
import json
import os
import pathlib
import shutil
import statistics
import subprocess
import sys
import tempfile

ROUNDS = 5
LIMIT = 2.0
PROGRAM = str(pathlib.Path(sys.argv[1]).resolve())
PEOPLE, SAMPLES, STROKES = (int(text) for text in (sys.argv[2:] or ["10", "14", "15"]))


def used(command, **options):
    """CPU seconds and peak memory (MB) of a command, on one core."""
    one_core = {min(os.sched_getaffinity(0))}
    process = subprocess.Popen(command, preexec_fn=lambda: os.sched_setaffinity(0, one_core), **options)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise SystemExit(f"{command[:4]}: {process.returncode}")
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def ours(folder, line, **options):
    subprocess.run([PROGRAM] + line.split(), cwd=folder, check=True, capture_output=True, **options)


def study(folder):
    """A measurement session of everybody, typed, and a recording of every sample."""
    ours(folder, "campaign new study --protocol isotropic_triplets --seed 7")
    names = [f"S{number}" for number in range(1, 14)] + ["NO"]
    recordings = []
    for person in range(1, PEOPLE + 1):
        typed = "yes\n" + "\n" * 400
        ours(folder, f"campaign run study P{person:02} measurement", input=typed.encode())
        for sample in names[:SAMPLES]:
            name = f"P{person:02}_{sample}.parquet"
            ours(
                folder,
                f"twin record --bench acttouch --sample {sample} --participant {person} --seed 7 --strokes {STROKES} --out {name}",
            )
            recordings.append(name)
    return recordings


def export(folder, recordings, out):
    shutil.rmtree(folder / out, ignore_errors=True)
    command = [PROGRAM, "bids", "export", "study", "--recordings", *recordings, "--out", out]
    return used(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def main():
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        recordings = study(folder)
        export(folder, recordings, "bids")
        tables = folder / "tables"
        tables.mkdir()
        size = 0
        for number, path in enumerate(sorted((folder / "bids").rglob("*.tsv.gz"))):
            text = gzip.decompress(path.read_bytes())
            size += len(text)
            (tables / f"{number}.tsv").write_bytes(text)
        files = sorted(map(str, tables.iterdir()))
        ratios = []
        for _ in range(ROUNDS):
            own, memory = export(folder, recordings, "bids")
            peer, _ = used(["gzip", "-6", "-c", *files], stdout=subprocess.DEVNULL)
            ratios.append(own / peer)
        _, alone = export(folder, recordings[:1], "one")
        median, spread = statistics.median(ratios), max(ratios) - min(ratios)
        kept = sum(path.stat().st_size for path in (folder / "bids").rglob("*.tsv.gz"))
        print(
            json.dumps(
                {
                    "work": f"B1: a study of {PEOPLE} × {SAMPLES} × {STROKES} as BIDS, beside gzip -6 on the same {size / 1e6:.0f} MB of tables",
                    "ratio": round(median, 2),
                    "spread": round(spread, 2),
                    "limit": LIMIT,
                    "compressed_mb": round(kept / 1e6, 1),
                    "peak_memory_mb": round(memory, 1),
                    "peak_memory_of_one_recording_mb": round(alone, 1),
                },
                ensure_ascii=False,
                indent=2,
            )
        )
        if median > LIMIT:
            raise SystemExit(f"B1: expected a ratio of {LIMIT} or less, found {median:.2f}")


if __name__ == "__main__":
    main()
