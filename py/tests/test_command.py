"""The program in the wheel: exit codes, what it prints, Ctrl-C."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import sysconfig
import time
from pathlib import Path

import numpy as np
import piezotact as pz
import pytest
from conftest import command


def test_exit_codes_and_where_it_prints(data: Path) -> None:
    done = command("--version")
    assert (done.returncode, done.stdout, done.stderr) == (0, f"piezotact {pz.__version__}\n", "")
    done = command("spectrum", "--help")
    assert done.returncode == 0 and "Example:" in done.stdout and not done.stderr
    done = command("spectrum", "missing.wav")
    assert (done.returncode, done.stdout, done.stderr) == (1, "", "piezotact: no such file: missing.wav; check the path\n")
    for words in (["spectre"], ["spectrum"], ["spectrum", "--nonsense"], ["spectrum", "texture.wav", "--overlap", "2"]):
        done = command(*words, cwd=data)
        assert done.returncode == 2 and not done.stdout and done.stderr, words
    # Silence is no measurement of the texture.
    done = command("verify", "--target", "texture.wav", "--measured", "S1.parquet", cwd=data)
    assert done.returncode in {1, 3, 5} and (done.returncode == 1) == (not done.stdout)


def test_sound_devices_are_said_to_be_left_out() -> None:
    done = command("sound", "devices")
    assert done.returncode == 2 and "this build does not have `piezotact sound devices`" in done.stderr


def test_the_script_is_the_module() -> None:
    script = shutil.which("piezotact", path=sysconfig.get_path("scripts"))
    assert script is not None
    done = subprocess.run([script, "--version"], capture_output=True, text=True, check=True)
    assert done.stdout == f"piezotact {pz.__version__}\n"


def test_the_demo(tmp_path: Path) -> None:
    done = command("demo", "--out", "demo", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "demo" / "report.html").exists()


def test_it_runs_itself_again(data: Path) -> None:
    done = command("spectrum", "texture.wav", "--report", "rerun.html", "--force", cwd=data)
    assert done.returncode == 0, done.stderr
    done = command("rerun", "rerun.html", cwd=data)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.skipif("PIEZOTACT_PROGRAM" not in os.environ, reason="PIEZOTACT_PROGRAM names no program to compare with")
@pytest.mark.parametrize(
    "words",
    [
        ["--help"], ["spectrum", "--help"], ["spectrum", "texture.wav"], ["strokes", "S8.parquet"], ["spectrum"], ["no"], ["info", "S8.parquet"],
        ["score", "S8.parquet", "S1.parquet"], ["spectrum", "missing.wav"], ["verify", "--target", "texture.wav", "--measured", "measured.parquet"],
        ["sound", "devices"], ["verify", "--target", "texture.wav", "--measured", "S1.parquet"],
    ],
)
def test_it_is_the_program_that_cargo_builds(data: Path, words: list[str]) -> None:
    program = subprocess.run([os.environ["PIEZOTACT_PROGRAM"], *words], cwd=data, capture_output=True, text=True, check=False)
    wheel = command(*words, cwd=data)
    assert (wheel.returncode, wheel.stdout, wheel.stderr) == (program.returncode, program.stdout, program.stderr)


@pytest.mark.filterwarnings("ignore::piezotact.Warning")
def test_ctrl_c_ends_the_program_in_order(data: Path) -> None:
    words = ["twin", "record", "--bench", "acttouch", "--sample", "S8", "--participant", "4", "--strokes", "5000", "--seed", "2", "--out", "stopped.parquet"]
    running = subprocess.Popen(
        [sys.executable, "-m", "piezotact", *words], cwd=data, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    time.sleep(2)
    running.send_signal(signal.SIGINT)
    began = time.monotonic()
    out, said = running.communicate(timeout=20)
    assert running.returncode == 130, (running.returncode, out, said)
    assert time.monotonic() - began < 0.5 and said.startswith("piezotact: stopped by hand") and "Traceback" not in said, said
    # What was acquired is kept.
    assert pz.read(data / "stopped.parquet").duration_s > 1


@pytest.mark.filterwarnings("ignore::piezotact.Warning")
def test_ctrl_c_ends_a_function_within_a_third_of_a_second() -> None:
    code = """
import numpy as np, piezotact as pz, signal, time
# Whoever runs the tests in the background may have Ctrl-C ignored.
signal.signal(signal.SIGINT, signal.default_int_handler)
values = np.random.default_rng(1).standard_normal(3_000_000)
print("begins", flush=True)
try:
    while True:
        pz.spectrum(values, rate=5000.0, unit="m/s2", segment=16384, overlap=0.99, median=True)
except KeyboardInterrupt:
    print(time.time(), flush=True)
    import os
    os._exit(0)
"""
    running = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert running.stdout is not None and running.stdout.readline() == "begins\n"
    time.sleep(1.0)
    sent = time.time()
    running.send_signal(signal.SIGINT)
    try:
        answered = float(running.communicate(timeout=20)[0])
    finally:
        running.kill()
    assert 0 <= answered - sent < 0.3


@pytest.mark.filterwarnings("ignore::piezotact.Warning")
def test_other_threads_of_python_go_on_meanwhile() -> None:
    import threading

    values = np.random.default_rng(1).standard_normal(2_000_000)
    ends: list[float] = []
    counted = 0

    def compute() -> None:
        pz.spectrum(values, rate=5000.0, unit="m/s2", segment=8192, overlap=0.95)
        ends.append(time.monotonic())

    thread = threading.Thread(target=compute)
    thread.start()
    while thread.is_alive():
        counted += 1
        time.sleep(0.001)
    assert ends and counted > 10, counted


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("method", ["spawn", "fork"])
def test_other_processes(method: str) -> None:
    import multiprocessing

    values = np.random.default_rng(1).standard_normal(20_000)
    here = spectrum_of(values)
    with multiprocessing.get_context(method).Pool(2) as pool:
        assert pool.map(spectrum_of, [values] * 3) == [here] * 3


def spectrum_of(values: "np.ndarray[tuple[int], np.dtype[np.float64]]") -> dict[str, object]:
    return pz.spectrum(values, rate=5000.0, unit="m/s2").to_dict()
