"""Look at signals and surfaces. Written by ``generate.py``; do not edit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar, Literal

import numpy as np
import numpy.typing as npt

from .._call import run
from .._recording import Data, Path, Text, Unit
from .._results import Record, Result


class Info(Result):
    """What is in a file or a folder: one form for each kind.

    Attributes: ``dir(found)`` lists them.
    ``found.to_dict()`` is the document.
    """

    SCHEMA: ClassVar[str] = "info"
    version: int


class Spectrum(Result):
    """The PSD of one channel of a file, with its frequencies and the rate of the channel, which the spectrum alone does
    not hold.

    Attributes: `averages`, `channel`, `config`, `file`, `frequency_hz`, `over_time`, `psd`, `rate_hz`, `resolution_hz`,
    `unit`, `version`.
    ``found.to_dict()`` is the document.
    """

    SCHEMA: ClassVar[str] = "spectrum"
    #: How many segments were averaged.
    averages: int
    #: The channel.
    channel: str
    #: How it was estimated.
    config: Record
    #: The file.
    file: str
    #: The frequencies of the lines, Hz.
    frequency_hz: npt.NDArray[np.float64]
    #: The PSD over time; absent where it was not asked for.
    over_time: Record | None
    #: The PSD of each line, in `unit`.
    psd: npt.NDArray[np.float64]
    #: The rate of the channel, Hz.
    rate_hz: float
    #: The distance of two lines, Hz.
    resolution_hz: float
    #: The unit of the values.
    unit: str
    version: int


class Spectrogram(Result):
    """The PSD of one channel of a file, with its frequencies and the rate of the channel, which the spectrum alone does
    not hold.

    Attributes: `averages`, `channel`, `config`, `file`, `frequency_hz`, `over_time`, `psd`, `rate_hz`, `resolution_hz`,
    `unit`, `version`.
    ``found.to_dict()`` is the document.
    """

    SCHEMA: ClassVar[str] = "spectrum"
    FIGURE: ClassVar[int] = 2
    #: How many segments were averaged.
    averages: int
    #: The channel.
    channel: str
    #: How it was estimated.
    config: Record
    #: The file.
    file: str
    #: The frequencies of the lines, Hz.
    frequency_hz: npt.NDArray[np.float64]
    #: The PSD over time; absent where it was not asked for.
    over_time: Record
    #: The PSD of each line, in `unit`.
    psd: npt.NDArray[np.float64]
    #: The rate of the channel, Hz.
    rate_hz: float
    #: The distance of two lines, Hz.
    resolution_hz: float
    #: The unit of the values.
    unit: str
    version: int


class Noise(Result):
    """The noise of one channel.

    Attributes: `averages`, `channel`, `config`, `criteria`, `densities`, `drift`, `duration_s`, `floor_rms`, `levels`,
    `mains`, `means`, `psd`, `rate_hz`, `resolution_hz`, `rms`, `unit`, `version`.
    ``found.to_dict()`` is the document.
    """

    SCHEMA: ClassVar[str] = "noise"
    #: The number of segments of the PSD.
    averages: int
    #: The channel.
    channel: str
    #: How it was analysed.
    config: Record
    #: What was decided: about rest, lines of the mains, and drift.
    criteria: list[Record]
    #: The amplitude density at 10, 100 and 1000 Hz, as far as the rate allows.
    densities: list[Record]
    #: The slow trend of the means of segments over time, s; absent for recordings shorter than ten segments.
    drift: Record | None
    #: How long it was recorded.
    duration_s: float
    #: The rms over the band of the noise floor, in the unit of the channel: from the PSD of medians, with lines
    #: replaced by the floor around them.
    floor_rms: float
    #: The rms above the band's lower end over each quarter of a segment's length in turn, in the unit of the channel;
    #: without the parts at both ends that the high-pass disturbs.
    levels: npt.NDArray[np.float64]
    #: Multiples of 50 and 60 Hz.
    mains: list[Record]
    #: The mean of each segment's length in turn, in the unit of the channel.
    means: npt.NDArray[np.float64]
    #: The one-sided PSD from 0 Hz up, in the unit of the channel squared per Hz: the median of the segments, over its
    #: expectation for Gaussian noise.
    psd: npt.NDArray[np.float64]
    #: Its rate.
    rate_hz: float
    #: The step between the lines of the PSD, Hz.
    resolution_hz: float
    #: The rms over the band, in the unit of the channel: of everything in the recording, from the mean PSD.
    rms: float
    #: Its unit.
    unit: str
    version: int


class Roughness(Result):
    """The roughness of a surface: lengths in µm and mm, and parameters by their symbol.

    Attributes: `cutoff_by`, `cutoff_mm`, `ends`, `evaluation_length_mm`, `file`, `filter`, `form`, `format`,
    `instrument`, `lambda_s_um`, `lines`, `section_ra_um`, `sections`, `standard`, `texture`, `unit`, `version`.
    ``found.to_dict()`` is the document.
    """

    SCHEMA: ClassVar[str] = "roughness"
    #: What the cut-off follows from: "stated", "iso4288", "`iso4288_periodic`" or "instrument"; absent without one.
    cutoff_by: str | None
    #: The cut-off of long waves, mm; absent without one.
    cutoff_mm: float | None
    #: What was done at the ends; absent for a map.
    ends: Any
    #: The length that was evaluated, mm; absent for a map.
    evaluation_length_mm: float | None
    #: The file.
    file: str
    #: Which filter: "gauss", "none", or "instrument" for a profile that the instrument had filtered.
    filter: str
    #: Which form was taken away: "level", "poly2".
    form: str
    #: What kind of file it is.
    format: str
    #: What the instrument states of it; absent without such a file.
    instrument: Record | None
    #: The cut-off of short waves, µm; absent without one.
    lambda_s_um: float | None
    #: The roughness of the lines of a map in one direction; absent where it was not asked for.
    lines: Record | None
    #: Ra of the section in which it is lowest and of that in which it is highest, µm; absent for a map.
    section_ra_um: npt.NDArray[np.float64] | None
    #: How many sections were evaluated; absent for a map.
    sections: int | None
    #: By which standard: "iso4287".
    standard: str
    #: Whether a map repeats itself, and how; absent for a profile and for a flat map.
    texture: Record | None
    #: The unit of lengths among the parameters.
    unit: str
    version: int


class RoughnessSet(Result):
    """The roughness of several surfaces, the roughest first.

    Attributes: `failed`, `surfaces`, `version`.
    ``found.to_dict()`` is the document.
    """

    SCHEMA: ClassVar[str] = "roughness_set"
    #: The files that could not be read or evaluated.
    failed: list[Record]
    #: The surfaces, ordered by Ra (of maps: Sa), the roughest first; last those profiles whose sections are not those
    #: of one surface.
    surfaces: list[Record]
    version: int


def info(
    file: Data,
    *,
    unit: Unit = None,
    scale: Text | Sequence[Text] | None = None,
    rate: float | None = None,
    part: int | None = None,
    date: str | None = None,
    force: bool = False,
) -> Info:
    """Shows the contents of a file: channels, units, sampling rate, duration, warnings.

    Parameters
    ----------
    file : path, Recording, array_like or dict of array_like
        A recording (Parquet, TDMS, WAV, FLAC, LVM, UFF, VHDR, EDF, BDF, XDF, SET, MAT, NPY, NPZ, catman BIN, HAPTIC,
        HJIF, CSV, TSV) or a transfer function (UFF, MAT, JSON).
    unit : str or dict of str, optional
        The unit of an array, or of each channel by its name: ``"m/s2"``, ``"g"``, ``"N"``; ``"1"`` relative to full
        scale.
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
    date : str, optional
        The date that reports and documents carry, in UTC, such as 2026-03-01T10:22:33Z; default: now.
    force : bool, optional
        Replaces existing files that the command did not write before.

    Returns
    -------
    Info
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
    Source: ``piezotact info``, ``docs/schemas/info.json``.
    """
    return run(Info, "info", locals(), data=("file",))


def spectrum(
    file: Data,
    *,
    unit: Unit = None,
    channel: str | None = None,
    segment: int | None = None,
    overlap: float | None = None,
    window: Text | None = None,
    median: bool = False,
    over_time: bool = False,
    max_frequency: float | None = None,
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
) -> Spectrum:
    """Estimates the power spectral density (PSD) of one channel, averaged or over time.

    Parameters
    ----------
    file : path, Recording, array_like or dict of array_like
        A recording.
    unit : str or dict of str, optional
        The unit of an array, or of each channel by its name: ``"m/s2"``, ``"g"``, ``"N"``; ``"1"`` relative to full
        scale.
    channel : str, optional
        The channel; optional if there is only one, or only one of acceleration.
    segment : int, optional
        Samples in a segment; default 1024, and about 0.1 s for `over_time`.
    overlap : float, optional
        Overlap of consecutive segments, as a fraction of a segment; default 0.5, and 0.875 for `over_time`.
    window : str or number, optional
        hann, hamming, blackman, blackman-harris, flat-top or rectangular. Default: hann.
    median : bool, optional
        Averages the segments by their median instead of their mean: robust against isolated disturbances.
    over_time : bool, optional
        Adds the PSD over time (spectrogram): a figure to the report, and at most 600 times × 300 frequencies to the
        JSON.
    max_frequency : float, optional
        The highest frequency of `over_time`, in Hz; default: half the sampling rate, but at most 1000.
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
    Spectrum
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
    Source: ``piezotact spectrum``, ``docs/schemas/spectrum.json``.
    """
    return run(Spectrum, "spectrum", locals(), data=("file",))


def spectrogram(
    file: Data,
    *,
    unit: Unit = None,
    channel: str | None = None,
    segment: int | None = None,
    overlap: float | None = None,
    window: Text | None = None,
    max_frequency: float | None = None,
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
) -> Spectrogram:
    """Estimates the power spectral density (PSD) of one channel over time.

    Parameters
    ----------
    file : path, Recording, array_like or dict of array_like
        A recording.
    unit : str or dict of str, optional
        The unit of an array, or of each channel by its name: ``"m/s2"``, ``"g"``, ``"N"``; ``"1"`` relative to full
        scale.
    channel : str, optional
        The channel; optional if there is only one, or only one of acceleration.
    segment : int, optional
        Samples in a segment; default 1024, and about 0.1 s for `over_time`.
    overlap : float, optional
        Overlap of consecutive segments, as a fraction of a segment; default 0.5, and 0.875 for `over_time`.
    window : str or number, optional
        hann, hamming, blackman, blackman-harris, flat-top or rectangular. Default: hann.
    max_frequency : float, optional
        The highest frequency of `over_time`, in Hz; default: half the sampling rate, but at most 1000.
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
    Spectrogram
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
    `over_time` has `times_s`, `frequencies_hz` and `psd`, a row for each frequency, in `unit`. There are at most 600
    times and 300 frequencies: neighbouring segments and lines of longer signals are averaged. The other attributes are
    those of `spectrum`.

    Source: ``piezotact spectrum``, ``docs/schemas/spectrum.json``.
    """
    return run(Spectrogram, "spectrum", {**locals(), "over_time": True}, data=("file",))


def noise(
    file: Data,
    *,
    unit: Unit = None,
    channel: str | None = None,
    band: Text | None = None,
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
) -> Noise:
    """Measures the noise of a sensor at rest: noise floor, mains hum, drift, and whether it was at rest.

    Parameters
    ----------
    file : path, Recording, array_like or dict of array_like
        A recording.
    unit : str or dict of str, optional
        The unit of an array, or of each channel by its name: ``"m/s2"``, ``"g"``, ``"N"``; ``"1"`` relative to full
        scale.
    channel : str, optional
        The channel; optional if there is only one, or only one of acceleration.
    band : str or number, optional
        The band of the rms of `rest`, in Hz; default: 10..1000, as far as the rate allows.
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
    Noise
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
    Source: ``piezotact spectrum``, ``docs/schemas/noise.json``.
    """
    return run(Noise, "spectrum", {**locals(), "rest": True}, data=("file",))


def roughness(
    files: Path | Sequence[Path],
    *,
    standard: Literal["iso4287", "iso21920"] | None = None,
    cutoff: Text | None = None,
    periodic: bool = False,
    filter: Literal["gauss", "none"] | None = None,
    form: Text | None = None,
    s_filter: Text | None = None,
    x_unit: Text | None = None,
    z_unit: Text | None = None,
    step: Text | None = None,
    along: Text | None = None,
    report: Path | None = None,
    csv: Path | None = None,
    figures: Path | None = None,
    tables: Path | None = None,
    columns: Literal["1", "2"] | None = None,
    date: str | None = None,
    force: bool = False,
) -> Roughness | RoughnessSet:
    """Computes the roughness of a measured profile or height map.

    Parameters
    ----------
    files : path, or a list
        Profiles or height maps (SUR, X3P, AL3D, BCR, SDF, PLU, NPY, MAT, text); several are ordered by Ra.
    standard : {'iso4287', 'iso21920'}, optional
        The standard that defines the averages along a profile; default iso4287.
    cutoff : str or number, optional
        The cut-off λc of a profile, such as 2.5mm; by default chosen by the rule of ISO 4288. On a height map, the
        nesting index of the L-filter; by default there is no L-filter.
    periodic : bool, optional
        Chooses the cut-off by the mean width of the profile elements (RSm), as ISO 4288 requires for turned, planed and
        other periodic profiles.
    filter : {'gauss', 'none'}, optional
        The filter that separates roughness from waviness. Default: gauss, and none for a roughness profile that the
        instrument has filtered (.tx2 with its .tx3).
    form : str or number, optional
        The form that is removed first: mean, level (least-squares line or plane) or poly2 … poly10. Default: level, or
        mean with `filter` none.
    s_filter : str or number, optional
        The S-filter, which removes short wavelengths: iso (λs of ISO 3274), none, or a length such as 8um. Default: iso
        for a profile and none for a height map.
    x_unit : str or number, optional
        The unit of the coordinates in a text file without units, such as mm.
    z_unit : str or number, optional
        The unit of the heights in a text file without units, or in an array (NPY, MAT), such as um.
    step : str or number, optional
        The spacing of the points in a text file without coordinates, or in an array (NPY, MAT), such as 0.5um.
    along : str or number, optional
        Also evaluates the lines of a height map along its rows (x) or columns (y) as profiles: Ra, Rz and Rq beside Sa,
        and the slope of their spectrum.
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
    Roughness or RoughnessSet
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
    Source: ``piezotact roughness``, ``docs/schemas/roughness.json``, ``docs/schemas/roughness_set.json``.
    """
    return run((Roughness, RoughnessSet), "roughness", locals())  # type: ignore[return-value]
