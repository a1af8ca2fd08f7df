"""The functions of the commands, and their results. Written by ``generate.py``; do not edit."""

from ._device import Characterisation, Transfer, characterise, transfer
from ._eeg import EegErd, EegStats, eeg_erd, eeg_stats
from ._look import Info, Noise, Roughness, RoughnessSet, Spectrogram, Spectrum, info, noise, roughness, spectrogram, spectrum
from ._panel import PanelAddition, PanelAnalysis, PanelAverage, PanelRun, panel_add, panel_analyse, panel_average, panel_run
from ._people import Answers, CampaignDesign, answers, campaign_design
from ._render import Manipulated, Prepared, PreparedStimuli, Rendering, Renderings, manipulate, prepare, render
from ._touch import Comparison, Cuts, Strokes, compare, cut, strokes
from ._twin import TwinRecording, twin_record
from ._verify import Played, Score, Verification, play, score, verify

__all__ = [
    "Answers",
    "CampaignDesign",
    "Characterisation",
    "Comparison",
    "Cuts",
    "EegErd",
    "EegStats",
    "Info",
    "Manipulated",
    "Noise",
    "PanelAddition",
    "PanelAnalysis",
    "PanelAverage",
    "PanelRun",
    "Played",
    "Prepared",
    "PreparedStimuli",
    "Rendering",
    "Renderings",
    "Roughness",
    "RoughnessSet",
    "Score",
    "Spectrogram",
    "Spectrum",
    "Strokes",
    "Transfer",
    "TwinRecording",
    "Verification",
    "answers",
    "campaign_design",
    "characterise",
    "compare",
    "cut",
    "eeg_erd",
    "eeg_stats",
    "info",
    "manipulate",
    "noise",
    "panel_add",
    "panel_analyse",
    "panel_average",
    "panel_run",
    "play",
    "prepare",
    "render",
    "roughness",
    "score",
    "spectrogram",
    "spectrum",
    "strokes",
    "transfer",
    "twin_record",
    "verify",
]
