"""What the guide says: its commands, its Python, and its MATLAB in Octave."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sysconfig
from pathlib import Path

import pytest
from piezotact._batch import TABLE

GUIDE = Path(__file__).parents[2] / "docs" / "guide"


def blocks(page: str, language: str) -> list[str]:
    """The blocks of a language in a page."""
    text = (GUIDE / page).read_text(encoding="utf-8")
    found = re.findall(rf"^```{language}\n(.*?)^```", text, flags=re.MULTILINE | re.DOTALL)
    assert found, f"{page} has no block of {language}"
    return found


def shell(script: str, folder: Path) -> None:
    path = os.pathsep.join([sysconfig.get_path("scripts"), os.environ["PATH"]])
    subprocess.run(["bash", "-euc", script], cwd=folder, env={**os.environ, "PATH": path}, check=True, capture_output=True)


@pytest.mark.filterwarnings("ignore::piezotact.Warning")
def test_the_chapter_on_python(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    shell("\n".join(blocks("python.md", "sh")), tmp_path)
    names: dict[str, object] = {}
    for block in blocks("python.md", "python"):
        exec(compile(block, "python.md", "exec"), names)
    out = capsys.readouterr().out
    assert "coherence 0.9" in out and "passed" in out, out
    assert (tmp_path / "verification.html").read_text(encoding="utf-8").startswith("<!DOCTYPE html>")


def test_the_chapter_on_python_explains_the_columns_of_strokes() -> None:
    text = (GUIDE / "python.md").read_text(encoding="utf-8")
    rows = [line.split("|")[1] for line in text.splitlines() if line.startswith("| `")]
    assert sorted(re.findall(r"`(\w+)`", " ".join(rows))) == sorted(["file", *TABLE, "label_NAME"])


@pytest.mark.skipif(shutil.which("octave-cli") is None, reason="this system has no Octave")
def test_the_page_on_matlab(tmp_path: Path) -> None:
    shell("\n".join(blocks("matlab.md", "sh")), tmp_path)
    (tmp_path / "page.m").write_text(blocks("matlab.md", "matlab")[0], encoding="utf-8")
    path = os.pathsep.join([sysconfig.get_path("scripts"), os.environ["PATH"]])
    done = subprocess.run(
        ["octave-cli", "--norc", "page.m"], cwd=tmp_path, env={**os.environ, "PATH": path}, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0 and re.match(r"\d+\.\d Hz, ", done.stdout), done.stdout + done.stderr
