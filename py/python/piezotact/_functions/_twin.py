"""Recordings of the digital twin. Written by ``generate.py``; do not edit."""

from __future__ import annotations

from typing import ClassVar, Literal

from .._call import run
from .._recording import Path, Text
from .._results import Result


class TwinRecording(Result):
    """A result with the file that holds it.

    Attributes: ``dir(found)`` lists them.
    ``found.to_dict()`` is the document.
    """

    SCHEMA: ClassVar[str] = "twin_record"
    version: int


def twin_record(
    bench: Literal["acttouch", "triboair", "shaker", "eeg"],
    *,
    sample: Text | None = None,
    task: Literal["natural", "control", "imagery"] | None = None,
    trials: int | None = None,
    participant: int | None = None,
    seed: int | None = None,
    twin: Path | None = None,
    speed: Text | None = None,
    strokes: int | None = None,
    stroke_time: Text | None = None,
    direction: Literal["proximal", "distal", "transversal", "circular"] | None = None,
    free: bool = False,
    load: float | None = None,
    angle: float | None = None,
    seconds: float | None = None,
    control: bool = False,
    label: Text | None = None,
    out: Path | None = None,
    live: bool = False,
    date: str | None = None,
    force: bool = False,
) -> TwinRecording:
    """Simulates the recording of a finger in active touch, in passive touch, or on the shaker, or the EEG of its person.

    Parameters
    ----------
    bench : {'acttouch', 'triboair', 'shaker', 'eeg'}
        The bench.
    sample : str or number, optional
        The sample: S1–S13, NO (without texture), M1–M12, BIO, or one of `twin` FILE. Not on the shaker, and not with
        EEG, where M8, BIO and M3 are touched.
    task : {'natural', 'control', 'imagery'}, optional
        EEG: what the person does.
    trials : int, optional
        EEG: how often each surface is touched, 1 to 500; default 20.
    participant : int, optional
        The number of the participant, from 1; 0 is the reference participant, with all parameters at their means.
        Default: 1.
    seed : int, optional
        Seed of the random participants, surfaces, movements and noise. Default: 1.
    twin : path, optional
        A laboratory's own parameter file, with the changed parameters only (see `piezotact twin parameters`).
    speed : str or number, optional
        The nominal sliding speed; default 30 mm/s.
    strokes : int, optional
        The number of strokes; default 15 in active and 6 in passive touch.
    stroke_time : str or number, optional
        The nominal duration of each active stroke, such as 1s; default: as long as the plate allows.
    direction : {'proximal', 'distal', 'transversal', 'circular'}, optional
        The direction of active strokes. Default: proximal.
    free : bool, optional
        Active touch at the participant's own speed and force.
    load : float, optional
        The nominal normal force, in N; default 0.2.
    angle : float, optional
        The angle between finger and surface, in degrees; default 17.5 on a sample and 20 on the shaker.
    seconds : float, optional
        The duration of the shaker excitation, in s; default 60.
    control : bool, optional
        On the shaker: the control measurement, with the accelerometer on the plate and without a finger.
    label : str or number, optional
        A label for the recording; another label gives other random movements, placements and noise. Default: record.
    out : path, optional
        The recording to write: Parquet with all channels, or WAV with only the acceleration of the nail; EEG: Parquet,
        BrainVision (.vhdr with .eeg and .vmrk beside it) or EDF+ (.edf). Default: a temporary file, which is removed
        with the result.
    live : bool, optional
        Prints the documents of every run (start, samples, judgements, end) as lines of JSON while it is acquired; a
        simulated bench then takes as long as a real one.
    date : str, optional
        The date that reports and documents carry, in UTC, such as 2026-03-01T10:22:33Z; default: now.
    force : bool, optional
        Replaces existing files that the command did not write before.

    Returns
    -------
    TwinRecording
        The document that the command prints with ``--json``, with its report.

    Raises
    ------
    Error
        What was expected and what was found, in the sentence of the command.

    Warns
    -----
    Warning
        What a person should know before relying on the result.

    Notes
    -----
    Source: ``piezotact twin record``, ``docs/schemas/twin_record.json``.
    """
    return run(TwinRecording, "twin record", locals(), outputs={"out": "recording.parquet"})
