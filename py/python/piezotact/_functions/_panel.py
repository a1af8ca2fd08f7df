"""Transfer functions of several people. Written by ``generate.py``; do not edit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar, Literal

import numpy as np
import numpy.typing as npt

from .._call import run
from .._recording import Path, Text
from .._results import Record, Result


class PanelRun(Result):
    """A result with the file that holds it.

    Attributes: `angles_deg`, `bench`, `bench_files`, `drive_unit`, `entries`, `format`, `kind`, `loads_n`, `measured`,
    `measurements`, `participants`, `planned`, `response_unit`, `there_already`, `version`.
    ``found.to_dict()`` is the document.
    """

    SCHEMA: ClassVar[str] = "panel_run"
    #: The angles, degrees.
    angles_deg: npt.NDArray[np.float64]
    #: Which bench measures it, where one does.
    bench: str | None
    #: The files that this bench is made of; empty where there are none.
    bench_files: list[Record] | None
    #: The unit of the drive.
    drive_unit: str | None
    #: The measurements.
    entries: list[Record]
    #: The name and the version of its form.
    format: str
    #: What it is of; absent while nothing is in it.
    kind: Any
    #: The loads, N.
    loads_n: npt.NDArray[np.float64]
    #: How many measurements were made now.
    measured: int
    #: How many measurements there are now.
    measurements: int
    #: The participants, measured and planned.
    participants: list[str]
    #: What was planned and is not measured yet.
    planned: list[Record]
    #: The unit of the response.
    response_unit: str | None
    #: How many were there already.
    there_already: int
    version: int


class PanelAddition(Result):
    """Transfer functions that were filed in a panel.

    Attributes: `filed`, `folder`, `measurements`, `version`.
    ``found.to_dict()`` is the document.
    """

    SCHEMA: ClassVar[str] = "panel_add"
    #: Under what they are filed.
    filed: list[Record]
    #: The folder of the panel.
    folder: str
    #: How many measurements the panel has now.
    measurements: int
    version: int


class PanelAnalysis(Result):
    """What a panel says, with what is known of its measurements: what a report shows and what is handed out as JSON.

    Attributes: `accepted`, `all`, `angle_effects`, `artefact`, `attendances`, `averages`, `cells`, `complete`,
    `config`, `falls`, `judged`, `kind`, `learning`, `load_steps`, `measurements`, `members`, `participants`,
    `repeatability`, `same_people`, `spreads`, `version`, `will_the_average_do`, `worst`.
    ``found.to_dict()`` is the document.
    """

    SCHEMA: ClassVar[str] = "panel_analysis"
    #: The measurements that were judged when they were made.
    accepted: list[Record]
    #: All curves together.
    all: Record
    #: The effect of angle.
    angle_effects: list[Record]
    #: What a control measurement took out; absent without one.
    artefact: Record | None
    #: The number of loads and angles at which each participant was measured; participants without a cell are left out
    #: of comparisons that need it.
    attendances: list[Record]
    #: Averages over people, by cell.
    averages: list[Record]
    #: The cells, by angle and load.
    cells: list[Record]
    #: How many participants were measured in every cell.
    complete: int
    #: How it was analysed.
    config: Record
    #: Whether the difference between people falls with load, by angle.
    falls: list[Record]
    #: The load and angle by which it is judged; absent where there is none.
    judged: Record | None
    #: What its transfer functions are of; absent where nothing says it.
    kind: Any
    #: How many people an average needs, by cell.
    learning: list[Record]
    #: The effect of load.
    load_steps: list[Record]
    #: How many transfer functions there are.
    measurements: int
    #: Every measurement with the criteria that decide whether it is a member of the panel and its averages.
    members: list[Record]
    #: The participants.
    participants: list[str]
    #: How well measurements repeat.
    repeatability: Record
    #: Participants who may be one person: nothing is decided for a new person from an average with them.
    same_people: list[Record] | None
    #: How far people lie apart, by cell.
    spreads: list[Record]
    version: int
    #: Whether the average will do there for a new person: "yes", "no" or "not decided".
    will_the_average_do: str | None
    #: The cell with the largest difference between people; absent when fewer than two people were measured in all
    #: cells.
    worst: Record | None


class PanelAverage(Result):
    """A result with the file that holds it.

    Attributes: `average`, `averages`, `change`, `condition`, `drive_setup`, `effective_averages`, `estimator`,
    `excited_hz`, `impact`, `known_input`, `participants`, `provenance`, `rate_hz`, `resolution_hz`, `version`.
    ``found.to_dict()`` is the document.
    """

    SCHEMA: ClassVar[str] = "panel_average"
    #: How it was averaged.
    average: Any
    #: The number of segments averaged.
    averages: int
    #: How the response changed while it was measured: the transfer function is a mean of several states then. Absent
    #: where no change is shown.
    change: Record | None
    #: Who touched what, and how.
    condition: Record
    #: Gain and level of the device it was measured with; absent for a system that is not a PIEZOTACT.
    drive_setup: Record | None
    #: The equivalent number of independent segments, with the same scatter; 0 when not known.
    effective_averages: float
    #: How it was estimated.
    estimator: str
    #: From the lowest to the highest line that was excited; absent when not known.
    excited_hz: npt.NDArray[np.float64] | None
    #: The hits and the windows of an impact test, with the damping that an exponential window added; absent for other
    #: drives.
    impact: Record | None
    #: Whether the drive is known without noise, as the signal that was sent and not a measurement of it, and does not
    #: repeat itself but in realisations.
    known_input: bool
    #: Who is in it.
    participants: list[str]
    #: Where it comes from.
    provenance: Record
    #: The rate of the recording it was estimated from.
    rate_hz: float
    #: The distance of two lines, Hz.
    resolution_hz: float
    version: int


def panel_run(
    bench: Text,
    participants: Text,
    *,
    discard_raw: bool = False,
    loads: float | Sequence[float] | None = None,
    angles: float | Sequence[float] | None = None,
    repeats: int | None = None,
    placements: int | None = None,
    excitation: Text | None = None,
    seconds: float | None = None,
    gating: Literal["on", "off"] | None = None,
    force_tolerance: float | None = None,
    least_coherence: float | None = None,
    attempts: Text | None = None,
    band: Text | None = None,
    peak: float | None = None,
    segment: int | None = None,
    seed: int | None = None,
    out: Path | None = None,
    date: str | None = None,
    force: bool = False,
) -> PanelRun:
    """Measures a whole panel on a bench: every participant at every load and angle, several times.

    Parameters
    ----------
    bench : str or number
        The bench: twin, or twin:seed=N,gain=B3,device=NAME|FILE.toml; or fake:FILE.toml, which follows the script in
        FILE.toml and simulates device faults, for tests and for training; `participants` gives the participants.
    participants : str or number
        The participants, such as 1..5 or 1,3,7.
    discard_raw : bool, optional
        Discards the raw recordings of this command at its end; by default they are kept in the folder `raw` of the
        panel.
    loads : float, or a list, optional
        The normal forces, in N, separated by commas. Default: 0.2,0.4,0.6.
    angles : float, or a list, optional
        The angles between finger and surface, in degrees, separated by commas. Default: 20,40.
    repeats : int, optional
        Number of consecutive measurements in each placement, without repositioning the finger. Default: 3.
    placements : int, optional
        Number of placements of the finger at each load and angle; the finger is repositioned for each. Default: 1.
    excitation : str or number, optional
        random, sweep or multisine. Default: random.
    seconds : float, optional
        Maximum duration of each drive, in s. Default: 60.
    gating : {'on', 'off'}, optional
        Whether a measurement is stopped and repeated when the force or the coherence is outside its limits. Default:
        on.
    force_tolerance : float, optional
        Largest relative deviation from the load of the mean force in every ten seconds; default 0.1.
    least_coherence : float, optional
        Smallest median coherence over the excited frequency lines in every ten seconds; default 0.9.
    attempts : str or number, optional
        Largest number of attempts at one measurement. Default: 3.
    band : str or number, optional
        The band that is excited, in Hz. Default: 2..1200.
    peak : float, optional
        The peak of the drive, as a fraction of the largest drive that the device can play. Default: 0.8.
    segment : int, optional
        Samples in a segment; default: 0.41 s, 2048 at 5 kHz.
    seed : int, optional
        Seed of the random drives; each repeat uses another drive. Default: 1.
    out : path, optional
        The folder of the panel; it is created if it does not exist. Default: a temporary folder, which is removed with
        the result.
    date : str, optional
        The date that reports and documents carry, in UTC, such as 2026-03-01T10:22:33Z; default: now.
    force : bool, optional
        Replaces existing files that the command did not write before.

    Returns
    -------
    PanelRun
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
    Source: ``piezotact panel run``, ``docs/schemas/panel_run.json``.
    """
    return run(PanelRun, "panel run", locals(), outputs={"out": "panel"})


def panel_add(
    folder: Path,
    files: Path | Sequence[Path],
    *,
    participant: Text | None = None,
    load: float | None = None,
    angle: float | None = None,
    placement: int | None = None,
    repeat: int | None = None,
    date: str | None = None,
    force: bool = False,
) -> PanelAddition:
    """Adds transfer functions that were measured elsewhere to a panel.

    Parameters
    ----------
    folder : path
        The folder of the panel; it is created if it does not exist.
    files : path, or a list
        Transfer functions (UFF, MAT, JSON).
    participant : str or number, optional
        The participant's pseudonym, if a file does not state it.
    load : float, optional
        The normal force in N, if a file does not state it.
    angle : float, optional
        The angle in degrees, if a file does not state it.
    placement : int, optional
        The number of the placement of the finger, from 1. Default: 1.
    repeat : int, optional
        The number of the repeat in this placement for the first file; default: the next free number.
    date : str, optional
        The date that reports and documents carry, in UTC, such as 2026-03-01T10:22:33Z; default: now.
    force : bool, optional
        Replaces existing files that the command did not write before.

    Returns
    -------
    PanelAddition
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
    Source: ``piezotact panel add``, ``docs/schemas/panel_add.json``.
    """
    return run(PanelAddition, "panel add", locals())


def panel_analyse(
    folder: Path,
    *,
    control: Path | None = None,
    band: Text | None = None,
    average: Literal["complex", "log-magnitude"] | None = None,
    criterion: float | None = None,
    seed: int | None = None,
    report: Path | None = None,
    csv: Path | None = None,
    figures: Path | None = None,
    tables: Path | None = None,
    columns: Literal["1", "2"] | None = None,
    date: str | None = None,
    force: bool = False,
) -> PanelAnalysis:
    """Computes how much participants differ, the effects of load and angle, and whether an average is sufficient.

    Parameters
    ----------
    folder : path
        The folder of the panel.
    control : path, optional
        A control measurement without a finger: the narrow dip of the bench that it shows is removed from every
        measurement.
    band : str or number, optional
        The band that is analysed, in Hz. Default: 20..1000.
    average : {'complex', 'log-magnitude'}, optional
        How the participants, and the repeats of each participant, are averaged. Default: log-magnitude.
    criterion : float, optional
        Largest error, in dB rms, at which an average is sufficient for a participant; it has to be for 90 % of people.
        Default: 3.
    seed : int, optional
        Seed of the random halves of the participants (certainty of the largest difference) and of their random order
        (sufficient number of participants). Default: 1.
    report : path, optional
        Writes a report: the conclusion, the numbers, tables, figures, and how it was made.
    csv : path, optional
        Writes the results as a table, with a row for each item.
    figures : path, optional
        Writes every figure of the report to this folder, as SVG; the full build (./x build) also writes PNG and PDF.
    tables : path, optional
        Writes every table of the report to this folder, as CSV.
    columns : {'1', '2'}, optional
        The width of `figures` in columns of a journal: 1 (85 mm) or 2 (174 mm, the default).
    date : str, optional
        The date that reports and documents carry, in UTC, such as 2026-03-01T10:22:33Z; default: now.
    force : bool, optional
        Replaces existing files that the command did not write before.

    Returns
    -------
    PanelAnalysis
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
    Source: ``piezotact panel analyse``, ``docs/schemas/panel_analysis.json``.
    """
    return run(PanelAnalysis, "panel analyse", locals())


def panel_average(
    folder: Path,
    *,
    load: float | None = None,
    angle: float | None = None,
    average: Literal["complex", "log-magnitude"] | None = None,
    band: Text | None = None,
    out: Path | None = None,
    report: Path | None = None,
    csv: Path | None = None,
    figures: Path | None = None,
    tables: Path | None = None,
    columns: Literal["1", "2"] | None = None,
    date: str | None = None,
    force: bool = False,
) -> PanelAverage:
    """Averages the participants at one load and angle, and estimates the error of the average for a new participant.

    Parameters
    ----------
    folder : path
        The folder of the panel.
    load : float, optional
        The normal force in N; optional if the panel has only one.
    angle : float, optional
        The angle in degrees; optional if the panel has only one.
    average : {'complex', 'log-magnitude'}, optional
        How the participants, and the repeats of each participant, are averaged. Default: log-magnitude.
    band : str or number, optional
        The band in which the error of the average is estimated, in Hz. Default: 20..1000.
    out : path, optional
        The transfer function to write: JSON (.json), a universal file (.uff, .unv) or MATLAB (.mat). Default: a
        temporary file, which is removed with the result.
    report : path, optional
        Writes a report: the conclusion, the numbers, tables, figures, and how it was made.
    csv : path, optional
        Writes the results as a table, with a row for each item.
    figures : path, optional
        Writes every figure of the report to this folder, as SVG; the full build (./x build) also writes PNG and PDF.
    tables : path, optional
        Writes every table of the report to this folder, as CSV.
    columns : {'1', '2'}, optional
        The width of `figures` in columns of a journal: 1 (85 mm) or 2 (174 mm, the default).
    date : str, optional
        The date that reports and documents carry, in UTC, such as 2026-03-01T10:22:33Z; default: now.
    force : bool, optional
        Replaces existing files that the command did not write before.

    Returns
    -------
    PanelAverage
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
    Source: ``piezotact panel average``, ``docs/schemas/panel_average.json``.
    """
    return run(PanelAverage, "panel average", locals(), outputs={"out": "transfer.json"})
