"""The functions of the commands, and their results. Written by ``generate.py``; do not edit."""

from ._device import Characterisation, Transfer, characterise, transfer
from ._look import Noise, Roughness, RoughnessSet, Spectrum, noise, roughness, spectrum
from ._people import Answers, Score, answers, score
from ._render import Played, Rendering, Renderings, Verification, play, render, verify
from ._touch import Comparison, Cuts, Strokes, compare, cut, strokes
from ._twin import TwinRecording, twin_record

__all__ = [
    "Answers",
    "Characterisation",
    "Comparison",
    "Cuts",
    "Noise",
    "Played",
    "Rendering",
    "Renderings",
    "Roughness",
    "RoughnessSet",
    "Score",
    "Spectrum",
    "Strokes",
    "Transfer",
    "TwinRecording",
    "Verification",
    "answers",
    "characterise",
    "compare",
    "cut",
    "noise",
    "play",
    "render",
    "roughness",
    "score",
    "spectrum",
    "strokes",
    "transfer",
    "twin_record",
    "verify",
]
