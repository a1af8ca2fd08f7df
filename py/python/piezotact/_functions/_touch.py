"""Strokes of a finger over a surface. Written by ``generate.py``; do not edit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar, Literal

from .._call import run
from .._recording import Data, Path, Text, Unit
from .._results import Record, Result


class Strokes(Result):
    """What strokes say, by recording and by group. It differs from the study by times in s and by the warnings of all
    groups.

    Attributes: `by`, `failed`, `groups`, `recordings`, `version`.
    ``found.to_dict()`` is the document.
    """

    SCHEMA: ClassVar[str] = "analysis"
    #: What the groups are of.
    by: Any
    #: The files that could not be read or cut; absent without any.
    failed: list[Record] | None
    #: One for each group.
    groups: list[Record]
    #: One for each recording.
    recordings: list[Record]
    version: int


class Cuts(Result):
    """Recordings cut into strokes. It differs from the recordings by times in s for places of samples.

    Attributes: `failed`, `recordings`, `version`.
    ``found.to_dict()`` is the document.
    """

    SCHEMA: ClassVar[str] = "segmentation"
    #: The files that could not be read or cut; absent without any.
    failed: list[Record] | None
    #: One for each recording.
    recordings: list[Record]
    version: int


class Comparison(Result):
    """What changes from group to group. It differs from the study by one comparison at the top, and by all warnings in one
    list.

    Attributes: `active_against_passive`, `by`, `common_lines`, `contrasts`, `discrimination`, `failed`, `version`.
    ``found.to_dict()`` is the document.
    """

    SCHEMA: ClassVar[str] = "comparison"
    #: Active against passive touch, where touch is compared.
    active_against_passive: Record | None
    #: What groups differ in.
    by: Any
    #: Lines that every sample has.
    common_lines: list[Record]
    #: How levels differ between directions, two loads, or the values of a label, over all comparisons.
    contrasts: list[Record] | None
    #: Which samples are distinguishable, where samples are compared.
    discrimination: Any
    #: The files that could not be read or cut; absent without any.
    failed: list[Record] | None
    version: int


def strokes(
    recordings: Data | Sequence[Data],
    *,
    unit: Unit = None,
    meta: Text | None = None,
    touch: Literal["active", "passive"] | None = None,
    direction: Literal["proximal", "distal", "transversal", "circular"] | None = None,
    load: float | None = None,
    speed: Text | None = None,
    vibration: Text | Sequence[Text] | None = None,
    normal_force: Text | None = None,
    tangential_force: Text | Sequence[Text] | None = None,
    motion: Text | None = None,
    every_contact: bool = False,
    cuts: Path | None = None,
    scale: Text | Sequence[Text] | None = None,
    rate: float | None = None,
    part: int | None = None,
    by: Text | None = None,
    high_pass: Text | None = None,
    segment: int | None = None,
    ridge: Text | None = None,
    set: Path | None = None,
    report: Path | None = None,
    csv: Path | None = None,
    figures: Path | None = None,
    tables: Path | None = None,
    columns: Literal["1", "2"] | None = None,
    date: str | None = None,
    force: bool = False,
) -> Strokes:
    """Cuts recordings into strokes and computes vibration, spectral and friction features of each, and their averages.

    Parameters
    ----------
    recordings : path, Recording, array_like or dict of array_like, or a list
        Recordings (Parquet, TDMS, WAV, FLAC, LVM, UFF, VHDR, EDF, BDF, XDF, SET, MAT, NPY, NPZ, catman BIN, HAPTIC,
        HJIF, CSV, TSV).
    unit : str or dict of str, optional
        The unit of an array, or of each channel by its name: ``"m/s2"``, ``"g"``, ``"N"``; ``"1"`` relative to full
        scale.
    meta : str or number, optional
        Pattern that reads the conditions from the file names, such as '{sample}_F{load:N}_V{speed:mm/s}_{repeat}'.
        Fields: sample, participant, load, speed, angle, touch (active or passive), direction (proximal, distal,
        transversal or circular); other fields are kept as labels.
    touch : {'active', 'passive'}, optional
        Active or passive touch; overrides what the recordings state.
    direction : {'proximal', 'distal', 'transversal', 'circular'}, optional
        The direction of sliding relative to the finger; overrides what the recordings state.
    load : float, optional
        The nominal normal force, in N; overrides what the recordings state. If it is stated nowhere, the thresholds are
        those for 0.2 N.
    speed : str or number, optional
        The sliding speed, such as "30 mm/s"; overrides what the recordings state.
    vibration : str or number, or a list, optional
        The vibration channels, separated by commas.
    normal_force : str or number, optional
        The channel of the normal force.
    tangential_force : str or number, or a list, optional
        The channels of the tangential forces, separated by commas.
    motion : str or number, optional
        The channel of the speed or position of the surface.
    every_contact : bool, optional
        Also accepts contacts without sliding, or with stick-slip, as strokes (if strokes are cut by force).
    cuts : path, optional
        A file of cuts for one recording; by default, RECORDING.cuts beside each recording is applied.
    scale : str or number, or a list, optional
        What the number 1 in the file means, such as "200 m/s2": for a WAV file (1 = full scale) without a sidecar
        FILE.json, or for table columns without units that can be in it; "fz=N" or "fz=2 N" of one channel, as often as
        needed.
    rate : float, optional
        The sampling rate of an array, in Hz. Of a file: the sampling rate, in Hz, of a table without a time column, or
        the rate at which a haptic file is played (default: the rate of the HJIF curves, otherwise 8000).
    part : int, optional
        The part of a recording with gaps (EEG formats, XDF) that is read, from 1 on; default: the first, with a
        warning.
    by : str or number, optional
        The grouping for the averages: sample, speed, participant, touch, load, direction, file, or a label of the
        recordings, such as a field of `meta`. Default: by sample if all recordings name one, otherwise by file.
    high_pass : str or number, optional
        Cut-off, in Hz, of the high-pass filter that removes the movement of the hand (the gesture), or none. Default: 5
        Hz for accelerations, none for signals of another or an unknown quantity.
    segment : int, optional
        Samples in a segment of the PSDs; by default, the frequency resolution is about 5 Hz.
    ridge : str or number, optional
        The spatial period of the fingerprint ridges, such as 0.545mm.
    set : path, optional
        The sample set that the recordings name their samples by: `isotropic` (S1–S13), `periodic` (M1–M12), or your own
        (TOML). Roughness and periods are not known without it, except for recordings of the digital twin.
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
    Strokes
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
    Source: ``piezotact strokes``, ``docs/schemas/analysis.json``.
    """
    return run(Strokes, "strokes", locals(), data=("recordings",))


def cut(
    recordings: Data | Sequence[Data],
    *,
    unit: Unit = None,
    meta: Text | None = None,
    touch: Literal["active", "passive"] | None = None,
    direction: Literal["proximal", "distal", "transversal", "circular"] | None = None,
    load: float | None = None,
    speed: Text | None = None,
    vibration: Text | Sequence[Text] | None = None,
    normal_force: Text | None = None,
    tangential_force: Text | Sequence[Text] | None = None,
    motion: Text | None = None,
    every_contact: bool = False,
    cuts: Path | None = None,
    scale: Text | Sequence[Text] | None = None,
    rate: float | None = None,
    part: int | None = None,
    write_cuts: Path | None = None,
    high_pass: Text | None = None,
    segment: int | None = None,
    ridge: Text | None = None,
    set: Path | None = None,
    report: Path | None = None,
    csv: Path | None = None,
    figures: Path | None = None,
    tables: Path | None = None,
    columns: Literal["1", "2"] | None = None,
    date: str | None = None,
    force: bool = False,
) -> Cuts:
    """Cuts recordings into strokes and lists them, with the rejected parts and their reasons.

    Parameters
    ----------
    recordings : path, Recording, array_like or dict of array_like, or a list
        Recordings (Parquet, TDMS, WAV, FLAC, LVM, UFF, VHDR, EDF, BDF, XDF, SET, MAT, NPY, NPZ, catman BIN, HAPTIC,
        HJIF, CSV, TSV).
    unit : str or dict of str, optional
        The unit of an array, or of each channel by its name: ``"m/s2"``, ``"g"``, ``"N"``; ``"1"`` relative to full
        scale.
    meta : str or number, optional
        Pattern that reads the conditions from the file names, such as '{sample}_F{load:N}_V{speed:mm/s}_{repeat}'.
        Fields: sample, participant, load, speed, angle, touch (active or passive), direction (proximal, distal,
        transversal or circular); other fields are kept as labels.
    touch : {'active', 'passive'}, optional
        Active or passive touch; overrides what the recordings state.
    direction : {'proximal', 'distal', 'transversal', 'circular'}, optional
        The direction of sliding relative to the finger; overrides what the recordings state.
    load : float, optional
        The nominal normal force, in N; overrides what the recordings state. If it is stated nowhere, the thresholds are
        those for 0.2 N.
    speed : str or number, optional
        The sliding speed, such as "30 mm/s"; overrides what the recordings state.
    vibration : str or number, or a list, optional
        The vibration channels, separated by commas.
    normal_force : str or number, optional
        The channel of the normal force.
    tangential_force : str or number, or a list, optional
        The channels of the tangential forces, separated by commas.
    motion : str or number, optional
        The channel of the speed or position of the surface.
    every_contact : bool, optional
        Also accepts contacts without sliding, or with stick-slip, as strokes (if strokes are cut by force).
    cuts : path, optional
        A file of cuts for one recording; by default, RECORDING.cuts beside each recording is applied.
    scale : str or number, or a list, optional
        What the number 1 in the file means, such as "200 m/s2": for a WAV file (1 = full scale) without a sidecar
        FILE.json, or for table columns without units that can be in it; "fz=N" or "fz=2 N" of one channel, as often as
        needed.
    rate : float, optional
        The sampling rate of an array, in Hz. Of a file: the sampling rate, in Hz, of a table without a time column, or
        the rate at which a haptic file is played (default: the rate of the HJIF curves, otherwise 8000).
    part : int, optional
        The part of a recording with gaps (EEG formats, XDF) that is read, from 1 on; default: the first, with a
        warning.
    write_cuts : path, optional
        Writes the strokes and the rejected parts of one recording as a file of cuts that can be edited.
    high_pass : str or number, optional
        Cut-off, in Hz, of the high-pass filter that removes the movement of the hand (the gesture), or none. Default: 5
        Hz for accelerations, none for signals of another or an unknown quantity.
    segment : int, optional
        Samples in a segment of the PSDs; by default, the frequency resolution is about 5 Hz.
    ridge : str or number, optional
        The spatial period of the fingerprint ridges, such as 0.545mm.
    set : path, optional
        The sample set that the recordings name their samples by: `isotropic` (S1–S13), `periodic` (M1–M12), or your own
        (TOML). Roughness and periods are not known without it, except for recordings of the digital twin.
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
    Cuts
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
    Source: ``piezotact strokes``, ``docs/schemas/segmentation.json``.
    """
    return run(Cuts, "strokes", {**locals(), "cuts_only": True}, data=("recordings",))


def compare(
    recordings: Data | Sequence[Data],
    by: Text,
    *,
    unit: Unit = None,
    meta: Text | None = None,
    touch: Literal["active", "passive"] | None = None,
    direction: Literal["proximal", "distal", "transversal", "circular"] | None = None,
    load: float | None = None,
    speed: Text | None = None,
    vibration: Text | Sequence[Text] | None = None,
    normal_force: Text | None = None,
    tangential_force: Text | Sequence[Text] | None = None,
    motion: Text | None = None,
    every_contact: bool = False,
    cuts: Path | None = None,
    scale: Text | Sequence[Text] | None = None,
    rate: float | None = None,
    part: int | None = None,
    jnd: float | None = None,
    frequency_jnd: float | None = None,
    contact_map: Path | None = None,
    high_pass: Text | None = None,
    segment: int | None = None,
    ridge: Text | None = None,
    set: Path | None = None,
    report: Path | None = None,
    csv: Path | None = None,
    figures: Path | None = None,
    tables: Path | None = None,
    columns: Literal["1", "2"] | None = None,
    date: str | None = None,
    force: bool = False,
) -> Comparison:
    """Compares samples, speeds, participants, or active with passive touch.

    Parameters
    ----------
    recordings : path, Recording, array_like or dict of array_like, or a list
        Recordings (Parquet, TDMS, WAV, FLAC, LVM, UFF, VHDR, EDF, BDF, XDF, SET, MAT, NPY, NPZ, catman BIN, HAPTIC,
        HJIF, CSV, TSV).
    by : str or number
        What is compared: sample, speed, participant, touch, load, direction, file, or a label of the recordings, such
        as a field of `meta`.
    unit : str or dict of str, optional
        The unit of an array, or of each channel by its name: ``"m/s2"``, ``"g"``, ``"N"``; ``"1"`` relative to full
        scale.
    meta : str or number, optional
        Pattern that reads the conditions from the file names, such as '{sample}_F{load:N}_V{speed:mm/s}_{repeat}'.
        Fields: sample, participant, load, speed, angle, touch (active or passive), direction (proximal, distal,
        transversal or circular); other fields are kept as labels.
    touch : {'active', 'passive'}, optional
        Active or passive touch; overrides what the recordings state.
    direction : {'proximal', 'distal', 'transversal', 'circular'}, optional
        The direction of sliding relative to the finger; overrides what the recordings state.
    load : float, optional
        The nominal normal force, in N; overrides what the recordings state. If it is stated nowhere, the thresholds are
        those for 0.2 N.
    speed : str or number, optional
        The sliding speed, such as "30 mm/s"; overrides what the recordings state.
    vibration : str or number, or a list, optional
        The vibration channels, separated by commas.
    normal_force : str or number, optional
        The channel of the normal force.
    tangential_force : str or number, or a list, optional
        The channels of the tangential forces, separated by commas.
    motion : str or number, optional
        The channel of the speed or position of the surface.
    every_contact : bool, optional
        Also accepts contacts without sliding, or with stick-slip, as strokes (if strokes are cut by force).
    cuts : path, optional
        A file of cuts for one recording; by default, RECORDING.cuts beside each recording is applied.
    scale : str or number, or a list, optional
        What the number 1 in the file means, such as "200 m/s2": for a WAV file (1 = full scale) without a sidecar
        FILE.json, or for table columns without units that can be in it; "fz=N" or "fz=2 N" of one channel, as often as
        needed.
    rate : float, optional
        The sampling rate of an array, in Hz. Of a file: the sampling rate, in Hz, of a table without a time column, or
        the rate at which a haptic file is played (default: the rate of the HJIF curves, otherwise 8000).
    part : int, optional
        The part of a recording with gaps (EEG formats, XDF) that is read, from 1 on; default: the first, with a
        warning.
    jnd : float, optional
        The just-noticeable difference (JND) in level between spectra, in dB: smaller differences are not noticed;
        between it and 2.5 dB, the upper end of the published range, the result is not decided. Default: 1.58.
    frequency_jnd : float, optional
        The just-noticeable difference in frequency between spectra, as a fraction of the frequency. Default: 0.2.
    contact_map : path, optional
        The measured ratio of skin to nail vibration: a table of frequency (Hz) and skin over nail (dB, or ratio). By
        default, skin and nail are assumed to move equally.
    high_pass : str or number, optional
        Cut-off, in Hz, of the high-pass filter that removes the movement of the hand (the gesture), or none. Default: 5
        Hz for accelerations, none for signals of another or an unknown quantity.
    segment : int, optional
        Samples in a segment of the PSDs; by default, the frequency resolution is about 5 Hz.
    ridge : str or number, optional
        The spatial period of the fingerprint ridges, such as 0.545mm.
    set : path, optional
        The sample set that the recordings name their samples by: `isotropic` (S1–S13), `periodic` (M1–M12), or your own
        (TOML). Roughness and periods are not known without it, except for recordings of the digital twin.
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
    Comparison
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
    Source: ``piezotact compare``, ``docs/schemas/comparison.json``.
    """
    return run(Comparison, "compare", locals(), data=("recordings",))
