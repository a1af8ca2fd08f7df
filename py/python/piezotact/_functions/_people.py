"""What a campaign can show, and what people answered. Written by ``generate.py``; do not edit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, Literal

from .._call import run
from .._recording import Path, Text
from .._results import Record, Result


class CampaignDesign(Result):
    """The design of a campaign.

    Attributes: `campaign`, `earlier_tasks`, `judged_session`, `power`, `protocol`, `report_`, `samples`, `sessions`,
    `source`, `title`, `version`.
    ``found.to_dict()`` is the document.
    """

    SCHEMA: ClassVar[str] = "campaign_design"
    #: What was judged.
    campaign: Record
    #: Tasks of earlier sessions that are judged with it.
    earlier_tasks: list[str] | None
    #: The session whose design is judged.
    judged_session: str
    #: How often a stated difference is found, where one was asked for.
    power: Record | None
    #: The protocol's name.
    protocol: str
    #: What it can show, and its faults.
    report_: Record
    #: All real samples of the protocol, also those that stand in no set.
    samples: list[str]
    #: All sessions of one participant.
    sessions: list[Record]
    #: Where it comes from.
    source: str
    #: Its title.
    title: str
    version: int


class Answers(Result):
    """What answers say: matrices, pairs that are confused, orders.

    Attributes: `answers`, `asked`, `comparisons`, `config`, `expected`, `felt`, `matrices`, `orderings`, `pairs`,
    `participants`, `rehearsals`, `same_people`, `unbalanced`, `version`, `virtual_answers`.
    ``found.to_dict()`` is the document.
    """

    SCHEMA: ClassVar[str] = "association"
    #: How many answers count.
    answers: int
    #: What the study asked; absent for a table of answers.
    asked: Record | None
    #: The differences that were asked for.
    comparisons: list[Record] | None
    #: What was asked for.
    config: Record
    #: How many answers are as expected, beside chance: of all stimuli, and of plain and manipulated ones where there
    #: are both.
    expected: list[Record] | None
    #: What was felt in confused pairs, where recordings of it were given.
    felt: Record | None
    #: The matrix of all answers, then one for each group.
    matrices: list[Record]
    #: The orders of each ordering task.
    orderings: list[Record] | None
    #: All pairs, the confused ones first.
    pairs: list[Record]
    #: Of how many participants.
    participants: int
    #: How many rehearsals were excluded.
    rehearsals: int
    #: People, sessions and tasks whose answers may be those of one person, or the same answers twice.
    same_people: list[Record] | None
    #: Who gave most of the answers, where they say little of people.
    unbalanced: Record | None
    version: int
    #: How many of them virtual volunteers gave.
    virtual_answers: int


def campaign_design(
    protocol: Path,
    *,
    participants: int | None = None,
    seed: int | None = None,
    power: Text | None = None,
    shares: Text | None = None,
    task: Text | None = None,
    spread: float | None = None,
    report: Path | None = None,
    csv: Path | None = None,
    figures: Path | None = None,
    tables: Path | None = None,
    columns: Literal["1", "2"] | None = None,
    date: str | None = None,
    force: bool = False,
) -> CampaignDesign:
    """Checks the design of a campaign before the first participant: time, chance, pairs, precision, faults and better
    plans.

    Parameters
    ----------
    protocol : path
        A protocol (TOML), or the name of one of the library, see `piezotact campaign protocol`.
    participants : int, optional
        The number of participants instead of that of the protocol.
    seed : int, optional
        The seed of simulations and searches. Default: 1.
    power : str or number, optional
        Simulates campaigns to find how many participants, repeats and sets are needed to show a difference (permutation
        of participants at 5 %). `samples:A,B`: two samples are distinguished; `tasks:A,B`: two tasks differ;
        `again:own,averaged`: the same people with two ways of rendering; `people:own,averaged`: two groups of people.
    shares : str or number, optional
        The difference that `power` looks for, in percent, for the median participant: expected answers in A and in B;
        for two samples, right answers and answers that name the other sample.
    task : str or number, optional
        The task of `power`, where several tasks have answers of the samples or groups.
    spread : float, optional
        How participants differ: the standard deviation of the logits of `shares`. Default: from the protocol's aims.
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
    CampaignDesign
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
    Source: ``piezotact campaign design``, ``docs/schemas/campaign_design.json``.
    """
    return run(CampaignDesign, "campaign design", locals())


def answers(
    answers: Path,
    *,
    samples: Text | Sequence[Text] | None = None,
    task: Text | None = None,
    by: Literal["task", "participant", "set"] | None = None,
    ordering: Text | Sequence[Text] | None = None,
    compare: Text | Sequence[Text] | None = None,
    without_flagged: bool = False,
    felt: Path | None = None,
    band: Text | None = None,
    jnd: float | None = None,
    frequency_jnd: float | None = None,
    contact_map: Path | None = None,
    scale: Text | Sequence[Text] | None = None,
    rate: float | None = None,
    part: int | None = None,
    report: Path | None = None,
    csv: Path | None = None,
    figures: Path | None = None,
    tables: Path | None = None,
    columns: Literal["1", "2"] | None = None,
    date: str | None = None,
    force: bool = False,
) -> Answers:
    """Computes association matrices of participants' answers: what was presented, and what it was declared to be.

    Parameters
    ----------
    answers : path
        A table of answers (CSV), one row for each trial, or the folder of a study. Names in the column `offered` are
        separated by | or blanks; n/a in `answered` is no answer.
    samples : str or number, or a list, optional
        All samples that could be answered, in their order, separated by commas, such as S1,S2,S3; a sample that was
        never presented or answered keeps its row and column. Default: those that the table names.
    task : str or number, optional
        Only the answers of this task.
    by : {'task', 'participant', 'set'}, optional
        One matrix more for each task, participant or set.
    ordering : str or number, or a list, optional
        The tasks in which samples were put in order, separated by commas: places, dominance and Kendall's τ.
    compare : str or number, or a list, optional
        Whether two differ, by a permutation of participants at 5 %, once for each; several are adjusted by Holm.
        `samples:S2,S3`: right answers against those that name the other; `tasks:A,B`: shares of answers as expected in
        two tasks of the same people; `people:OTHER`: this study against another, of different people; `again:OTHER`:
        against another of the same people.
    without_flagged : bool, optional
        Leaves out trials in which the stimulus missed its target or was not measured, or the wrong sample was handed
        over.
    felt : path, optional
        What was felt: a folder with one recording for each sample, named as the sample (S1.parquet, S1.wav …), such as
        the folder of `piezotact prepare`; or such folders, each named by the pseudonym of its participant. Draws the
        spectra of confused pairs side by side and states whether level, spectrum or time course separates them.
    band : str or number, optional
        The band in which `felt` compares, in Hz. Default: 20..1000.
    jnd : float, optional
        The just-noticeable difference (JND) in level between spectra, in dB: smaller differences are not noticed;
        between it and 2.5 dB, the upper end of the published range, the result is not decided. Default: 1.58.
    frequency_jnd : float, optional
        The just-noticeable difference in frequency between spectra, as a fraction of the frequency. Default: 0.2.
    contact_map : path, optional
        The measured ratio of skin to nail vibration: a table of frequency (Hz) and skin over nail (dB, or ratio). By
        default, skin and nail are assumed to move equally.
    scale : str or number, or a list, optional
        What the number 1 in the file means, such as "200 m/s2": for a WAV file (1 = full scale) without a sidecar
        FILE.json, or for table columns without units that can be in it; "fz=N" or "fz=2 N" of one channel, as often as
        needed.
    rate : float, optional
        The sampling rate, in Hz, of a table without a time column, or the rate at which a haptic file is played
        (default: the rate of the HJIF curves, otherwise 8000).
    part : int, optional
        The part of a recording with gaps (EEG formats, XDF) that is read, from 1 on; default: the first, with a
        warning.
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
    Answers
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
    The columns `participant`, `task`, `trial`, `presented` and `answered` are needed; `set` and `offered` may be there.
    A DataFrame is written to a file first: ``table.to_csv('answers.csv', index=False)``.

    Source: ``piezotact answers``, ``docs/schemas/association.json``.
    """
    return run(Answers, "answers", locals())
