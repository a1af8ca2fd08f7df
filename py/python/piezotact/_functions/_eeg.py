"""EEG during touch. Written by ``generate.py``; do not edit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, Literal

import numpy as np
import numpy.typing as npt

from .._call import run
from .._recording import Path, Text
from .._results import Record, Result


class EegErd(Result):
    """The desynchronisation of one person in one task.

    Attributes: `channels`, `config`, `counts`, `electrodes`, `file`, `maps`, `positions`, `preparation`, `rate_hz`,
    `regions`, `smears`, `subject`, `surfaces`, `times_s`, `trace`, `version`.
    ``found.to_dict()`` is the document.
    """

    SCHEMA: ClassVar[str] = "eeg_erd"
    #: The electrodes of the maps.
    channels: list[str]
    #: What was compared.
    config: Record
    #: Which markers have an epoch.
    counts: Record
    #: The change at each electrode.
    electrodes: list[Record]
    #: The file.
    file: str
    #: The change over time and frequency, averaged over epochs first whatever the order of the other values, and free
    #: of the bias of the logarithm.
    maps: list[Record]
    #: Those of them whose position is known.
    positions: list[Record]
    #: How epochs were made.
    preparation: Record
    #: The rate of the signals.
    rate_hz: float
    #: The change in each region.
    regions: list[Record]
    #: How far wavelets smear.
    smears: list[Record]
    #: Who and what it is of.
    subject: Record
    #: The surfaces, in the order in which they were asked for.
    surfaces: list[str]
    #: The times of the maps from the marker, s: those that the ends of epochs do not touch.
    times_s: npt.NDArray[np.float64]
    #: What tells this recording from others.
    trace: Record
    version: int


class EegStats(Result):
    """What differs over people.

    Attributes: `changes`, `clusters`, `config`, `contrasts`, `documents`, `electrodes`, `epochs`, `gradients`,
    `measured`, `participants`, `scalps`, `surfaces`, `tasks`, `version`.
    ``found.to_dict()`` is the document.
    """

    SCHEMA: ClassVar[str] = "eeg_stats"
    #: The changes by task, surface, region and band.
    changes: list[Record]
    #: The cluster tests.
    clusters: list[Record]
    #: How people were compared.
    config: Record
    #: The contrasts of tasks.
    contrasts: list[Record]
    #: How many documents it is of.
    documents: int
    #: The electrodes of the scalp maps.
    electrodes: list[Record]
    #: The epochs of each task.
    epochs: list[Record]
    #: The order of tasks, where one is claimed.
    gradients: list[Record] | None
    #: What was compared in each person.
    measured: Record
    #: The participants.
    participants: list[str]
    #: The means over people on the scalp.
    scalps: list[Record]
    #: The surfaces.
    surfaces: list[str]
    #: The tasks.
    tasks: list[str]
    version: int


def eeg_erd(
    file: Path,
    *,
    baseline: Text | None = None,
    window: Text | None = None,
    epoch: Text | None = None,
    band: Text | Sequence[Text] | None = None,
    region: Text | Sequence[Text] | None = None,
    cycles: Text | None = None,
    order: Literal["power-first", "percent-of-each-epoch"] | None = None,
    min_epochs: int | None = None,
    electrodes: Path | None = None,
    participant: Text | None = None,
    task: Text | None = None,
    event: Text | Sequence[Text] | None = None,
    events: Path | None = None,
    channels: Text | Sequence[Text] | None = None,
    without: Text | Sequence[Text] | None = None,
    high_pass: float | None = None,
    low_pass: float | None = None,
    notch: float | Sequence[float] | None = None,
    eog: Text | Sequence[Text] | None = None,
    interpolate: Text | Sequence[Text] | None = None,
    reference: Text | None = None,
    reject_above: float | None = None,
    reject_below: float | None = None,
    reject_drift: float | None = None,
    out: Path | None = None,
    report: Path | None = None,
    csv: Path | None = None,
    figures: Path | None = None,
    tables: Path | None = None,
    columns: Literal["1", "2"] | None = None,
    date: str | None = None,
    force: bool = False,
) -> EegErd:
    """Computes event-related desynchronisation (ERD) and synchronisation of one person in one task, by surface, band and
    region.

    Parameters
    ----------
    file : path
        An EEG file of one task.
    baseline : str or number, optional
        The baseline relative to the marker, s: at rest, before a movement is planned. Default: -1.5,-0.5.
    window : str or number, optional
        The window relative to the marker, s. Default: 0,0.8.
    epoch : str or number, optional
        Start and end of the epochs relative to the marker, s; default: baseline and window, extended by the reach of
        the wavelets.
    band : str or number, or a list, optional
        A band; several are allowed. Default: alpha=8..12.
    region : str or number, or a list, optional
        A region, and the electrodes whose changes are averaged; several are allowed. Default: C3, Cz and C4, those of
        them that were recorded.
    cycles : str or number, optional
        The cycles of the wavelets: a number, or f/2 for half the frequency in Hz (80 ms SD at every frequency).
        Default: f/2.
    order : {'power-first', 'percent-of-each-epoch'}, optional
        What is averaged before the baseline is divided. Default: power-first.
    min_epochs : int, optional
        The fewest epochs of a surface. Default: 10.
    electrodes : path, optional
        Measured positions of electrodes: a table with columns name, x (to the right), y (to the front) and z (up).
        Default: those of the names of the 10-10 system, or those inside an EEGLAB file.
    participant : str or number, optional
        The participant's pseudonym; default: that of a BIDS name.
    task : str or number, optional
        The task; default: that of a BIDS name, or of the only marker `task`. Of a file with markers of several tasks,
        the one whose epochs are taken.
    event : str or number, or a list, optional
        A marker around which epochs are cut, by its whole name, kind or value, and the condition (surface) that it
        stands for; several are allowed. A kind alone (`control` for `control/BIO`) makes its values the conditions.
        `piezotact eeg info` lists the markers.
    events : path, optional
        A table of markers that is read in the place of those of the file: columns onset (s from its first sample),
        duration, and `trial_type` or value (BIDS `_events.tsv`).
    channels : str or number, or a list, optional
        The electrodes, separated by commas; default: all.
    without : str or number, or a list, optional
        Channels that are left out, separated by commas.
    high_pass : float, optional
        Passes frequencies above this one, Hz, without delay.
    low_pass : float, optional
        Passes frequencies below this one, Hz, without delay.
    notch : float, or a list, optional
        Takes away the mains and its multiples, Hz, separated by commas: 50,100.
    eog : str or number, or a list, optional
        EOG channels, separated by commas: their part in the others is taken away by regression.
    interpolate : str or number, or a list, optional
        Electrodes to interpolate from the others by spherical splines, separated by commas; `bad`: those that the table
        of channels beside the file marks as bad.
    reference : str or number, optional
        The reference: `as-recorded`, `average` of all electrodes, or names of channels, separated by commas. Default:
        as-recorded.
    reject_above : float, optional
        Rejects epochs in which a channel spans more than this, µV peak to peak.
    reject_below : float, optional
        Rejects epochs in which a channel spans less than this, µV peak to peak: it is flat.
    reject_drift : float, optional
        Rejects epochs in which a channel drifts by more than this, µV over the epoch.
    out : path, optional
        Writes the result for `piezotact eeg stats`.
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
    EegErd
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
    Source: ``piezotact eeg erd``, ``docs/schemas/eeg_erd.json``.
    """
    return run(EegErd, "eeg erd", locals())


def eeg_stats(
    files: Path | Sequence[Path],
    *,
    unit: Literal["percent", "db"] | None = None,
    gradient: Text | Sequence[Text] | None = None,
    margin: float | None = None,
    band: Text | Sequence[Text] | None = None,
    region: Text | Sequence[Text] | None = None,
    neighbours: float | None = None,
    flips: int | None = None,
    seed: int | None = None,
    report: Path | None = None,
    csv: Path | None = None,
    figures: Path | None = None,
    tables: Path | None = None,
    columns: Literal["1", "2"] | None = None,
    date: str | None = None,
    force: bool = False,
) -> EegStats:
    """Compares tasks over participants: paired contrasts, the order of tasks, cluster tests, scalp maps.

    Parameters
    ----------
    files : path, or a list
        Documents of `piezotact eeg erd`, one for each participant and task.
    unit : {'percent', 'db'}, optional
        The unit of changes: percent of the baseline, or dB. Clusters are always of dB. Default: percent.
    gradient : str or number, or a list, optional
        The tasks from the most to the least desynchronised one, as it is claimed, separated by commas: whether this
        order holds.
    margin : float, optional
        A difference of no interest, in the unit, stated before the data are seen: tasks whose 95 % interval lies within
        it are alike.
    band : str or number, or a list, optional
        Only these bands of the documents, separated by commas: contrasts that were planned are adjusted among
        themselves. Default: all.
    region : str or number, or a list, optional
        Only these regions of the documents, separated by commas. Default: all.
    neighbours : float, optional
        Electrodes up to this angle apart, seen from the centre of the head, are neighbours in clusters, degrees.
        Default: 35.
    flips : int, optional
        Sign flips of the cluster test; all are tried where there are no more. Default: 10000.
    seed : int, optional
        The seed of sign flips that are drawn. Default: 1.
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
    EegStats
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
    Source: ``piezotact eeg stats``, ``docs/schemas/eeg_stats.json``.
    """
    return run(EegStats, "eeg stats", locals())
