"""Recordings of the digital twin, made once by the command of the wheel."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

DATE = "2026-03-01T10:22:33Z"


def command(*words: str, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    """The program of the wheel with `words`."""
    return subprocess.run(
        [sys.executable, "-m", "piezotact", *words], cwd=cwd, capture_output=True, text=True, encoding="utf-8", check=False
    )


def made(folder: Path, *words: str) -> None:
    done = command(*words, cwd=folder)
    assert done.returncode == 0, done.stderr


@pytest.fixture(scope="session")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with two recordings of touch, a texture, a transfer function, a drive and its measurement, answers."""
    folder = tmp_path_factory.mktemp("data")
    for sample, seed in (("S8", "7"), ("S1", "7")):
        made(
            folder, "twin", "record", "--bench", "acttouch", "--sample", sample, "--participant", "4", "--speed", "30mm/s",
            "--strokes", "6", "--seed", seed, "--out", f"{sample}.parquet",
        )
    made(folder, "manipulate", "S8.parquet", "--stroke", "2", "--loop", "3s", "--out", "texture.wav")
    made(folder, "characterise", "--bench", "twin:participant=4,seed=7", "--seconds", "6", "--record", "bench.parquet", "--out", "tf.json")
    made(folder, "render", "texture.wav", "--transfer", "tf.json", "--level", "fit", "--out", "drive.wav")
    made(folder, "play", "drive.wav", "--bench", "twin:participant=4,seed=7", "--record", "measured.parquet")
    made(folder, "twin", "record", "--bench", "eeg", "--task", "natural", "--participant", "1", "--seed", "7", "--trials", "10", "--out", "P01_natural.vhdr")
    answers = ["participant,task,trial,presented,answered"]
    answers += [f"P{n},task,{n * 4 + i},S{i},S{(i * n) % 4}" for n in range(1, 7) for i in range(4)]
    (folder / "answers.csv").write_text("\n".join(answers) + "\n", encoding="utf-8")
    profile = "\n".join(f"{i * 0.001:.4f}\t{((i * 37) % 101) / 50 - 1:.4f}" for i in range(8000))
    (folder / "profile.txt").write_text(profile + "\n", encoding="utf-8")
    return folder
