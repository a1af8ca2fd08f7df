"""How close a rendering comes. Written by ``generate.py``; do not edit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar, Literal

import numpy as np
import numpy.typing as npt

from .._call import run
from .._recording import Data, Path, Text, Unit
from .._results import Record, Result


class Played(Result):
    """A result with the file that holds it.

    Attributes: ``dir(found)`` lists them.
    ``found.to_dict()`` is the document.
    """

    SCHEMA: ClassVar[str] = "play"
    version: int


class Verification(Result):
    """How close a measurement came to its target, with the other measurements that were asked for: several values of one
    command.

    Attributes: `achievable_band_hz`, `added_power`, `also`, `averages`, `band_hz`, `before`, `clipped_fraction`,
    `clock`, `criteria`, `delay_s`, `error_db`, `error_db_max`, `error_db_rms`, `error_db_rms_achievable`,
    `error_db_rms_level_matched`, `error_frequency_hz`, `error_max_at_hz`, `frequency_hz`, `is_rehearsal`, `level_db`,
    `level_error_db`, `limits`, `measured_psd`, `mode`, `passed`, `psd_unit`, `rate_hz`, `sentence`, `silence_s`,
    `target_psd`, `uncompensated_predicted`, `verdict`, `version`, `waveform_correlation`, `waveform_nmse_db`, `welch`,
    `whole_texture_jnd`.
    ``found.to_dict()`` is the document.
    """

    SCHEMA: ClassVar[str] = "verify"
    #: The parts of the band that the inverse declared achievable.
    achievable_band_hz: Any
    #: The power of the measurement on lines of the band without target, over the target's in the band.
    added_power: float
    #: Further measurements.
    also: list[Record] | None
    #: The number of segments averaged.
    averages: int
    #: The band over which they were compared, Hz.
    band_hz: npt.NDArray[np.float64]
    #: Textures before their manipulation.
    before: list[Record] | None
    #: The share of samples at a limit, of the sensor or of the device, 0–1.
    clipped_fraction: float
    #: How the clock of the measurement differs from that of the target, and what was corrected for it.
    clock: Record
    #: The criteria, each with the value found, its limit and its outcome; the verdict follows from them.
    criteria: list[Record]
    #: How much later the measurement is than the target, s.
    delay_s: float
    #: Their errors, 10·log10(measured/target) of the band-limited signals, dB.
    error_db: npt.NDArray[np.float64]
    #: The largest absolute error of a line in the band, dB.
    error_db_max: float
    #: Root mean square over all of the band's lines of the spectrum error as measured, dB; the criterion is
    #: [`VerifyCriterion::SpectrumError`].
    error_db_rms: float
    #: The rms error over the achievable parts, as measured, dB.
    error_db_rms_achievable: float | None
    #: The same rms after removing the mean error of the lines: the error of the spectral shape alone, dB.
    error_db_rms_level_matched: float
    #: The lines that are judged, Hz: those of the band that hold target power.
    error_frequency_hz: npt.NDArray[np.float64]
    #: The frequency of the largest error, Hz.
    error_max_at_hz: float
    #: The lines of the spectra, Hz.
    frequency_hz: npt.NDArray[np.float64]
    #: Whether the drive was played through the transfer function that it was made with: no evidence.
    is_rehearsal: bool | None
    #: The level re the target at which it was intentionally rendered, dB.
    level_db: float
    #: 20·log10 of the measured over the target rms in all of the band, with the sensor's noise, dB; the criterion is
    #: [`VerifyCriterion::Level`].
    level_error_db: float
    #: The limits.
    limits: Record
    #: The PSD of the measurement, unit²/Hz.
    measured_psd: npt.NDArray[np.float64]
    #: Whether the waveform is judged, or the spectrum alone.
    mode: Any
    #: Whether every criterion is met.
    passed: bool
    #: The unit of the PSDs.
    psd_unit: str
    #: The rate at which they were compared, Hz.
    rate_hz: float
    #: The verdict in one sentence.
    sentence: str
    #: The silence on either side of a target that is shorter than two segments, s, which belongs to what is compared.
    silence_s: float | None
    #: The PSD of the target, unit²/Hz.
    target_psd: npt.NDArray[np.float64]
    #: What the texture itself as a drive would give; absent without a transfer function.
    uncompensated_predicted: Any
    #: What is concluded.
    verdict: Any
    version: int
    #: Pearson's correlation of the waveforms in all of the band, with the sensor's noise, after aligning the delay; the
    #: criterion is [`VerifyCriterion::WaveformCorrelation`].
    waveform_correlation: float
    #: The power of the difference of those waveforms re that of the target (NMSE), dB; silence would give 0 dB. Over
    #: all of the band, with the sensor's noise; the criterion is [`VerifyCriterion::WaveformError`].
    waveform_nmse_db: float
    #: How the spectra were estimated.
    welch: Record
    #: The difference that a finger could feel between the whole texture and the measurement, at all frequencies that
    #: are felt, JND; absent where nearly all of the texture is in the band, and where it could not be computed.
    whole_texture_jnd: float | None


class Score(Result):
    """The perceptual distance of two recordings with its verdict, and further measures of their difference.

    Attributes: `balance`, `bands`, `config`, `criteria`, `extent`, `is_nonstationary`, `jnd_source`, `level`,
    `level_error_db`, `literature`, `modulation_db`, `perceived`, `rate_hz`, `reference_centroid_hz`,
    `reference_sensation_db`, `segments`, `sentence`, `spectral`, `spectrum`, `spectrum_error`, `test_centroid_hz`,
    `test_sensation_db`, `verdict`, `version`, `waveform`, `within_jnd`.
    ``found.to_dict()`` is the document.
    """

    SCHEMA: ClassVar[str] = "score"
    #: The difference of the mean frequency of what is excited.
    balance: Record
    #: Third octaves.
    bands: list[Record]
    #: How it was computed.
    config: Record
    #: The criteria: the difference that decides re the just-noticeable difference and, for two realisations, re the
    #: distance between the halves of one recording.
    criteria: list[Record]
    #: What of the two is compared.
    extent: Any
    #: Whether level or spectrum of one of the two change over time by more than chance explains.
    is_nonstationary: bool | None
    #: Where the just noticeable differences of level and spectrum come from; those of the perceived difference have
    #: their sources in `perception`.
    jnd_source: str
    #: The difference of the overall level over threshold.
    level: Record
    #: 20·log10 of the rms of the test over that of the reference in the band, dB.
    level_error_db: float
    #: ST-SIM and SPQI, for comparison with the literature; not part of the score.
    literature: Record | None
    #: The spread of short-time levels of the reference and the test, dB; it is not part of the score.
    modulation_db: npt.NDArray[np.float64] | None
    #: The score: the perceived difference, over time and by channel; absent where the spectra decide.
    perceived: Record | None
    #: The rate at which they were compared, Hz.
    rate_hz: float
    #: The mean frequency of what the reference excites, Hz.
    reference_centroid_hz: float
    #: The level of what the reference excites, dB re the detection threshold.
    reference_sensation_db: float
    #: The segments averaged, of the one that has fewer.
    segments: int
    #: One sentence that says whether a finger could tell A, the reference, from B, the test, by how much, and how.
    sentence: str
    #: The difference of the spectra, JND: the largest of the three below.
    spectral: Record
    #: The mean difference of the bands' levels, weighed by what they excite.
    spectrum: Record
    #: The spectra line by line.
    spectrum_error: Record
    #: The mean frequency of what the test excites, Hz.
    test_centroid_hz: float
    #: The level of what the test excites, dB re the detection threshold.
    test_sensation_db: float
    #: The verdict that follows from the criteria.
    verdict: Any
    version: int
    #: How alike the waveforms are; it is not part of the score.
    waveform: Record | None
    #: How far the spectra of the halves of the reference lie apart, and those of the test, JND; absent where they are
    #: too short.
    within_jnd: npt.NDArray[np.float64] | None


def play(
    drive: Path,
    bench: Text,
    *,
    record: Path | None = None,
    live: bool = False,
    gain: Text | None = None,
    load: float | None = None,
    angle: float | None = None,
    date: str | None = None,
    force: bool = False,
) -> Played:
    """Plays a drive on a bench and records the response of the finger.

    Parameters
    ----------
    drive : path
        The drive (WAV) that `render` wrote.
    bench : str or number
        The bench: twin, or twin:participant=K,seed=N,gain=B3,device=NAME|FILE.toml; or measured:FILE,noise=0.003,seed=N
        (noise in m/s² rms), which simulates the response with the transfer function in FILE; with
        panel=FOLDER,placement=N, for another placement of that finger, drawn from the variability between placements in
        the panel; or fake:FILE.toml,participant=K, which follows the script in FILE.toml and simulates device faults,
        for tests and for training.
    record : path, optional
        The recording to write (Parquet). Default: a temporary file, which is removed with the result.
    live : bool, optional
        Prints the documents of every run (start, samples, judgements, end) as lines of JSON while it is acquired; a
        simulated bench then takes as long as a real one.
    gain : str or number, optional
        The gain for which a drive without a sidecar was made.
    load : float, optional
        The normal force that the participant holds, in N; default: that of the measured bench, otherwise 0.2.
    angle : float, optional
        The angle between finger and surface, in degrees; default: that of the measured bench, otherwise 20.
    date : str, optional
        The date that reports and documents carry, in UTC, such as 2026-03-01T10:22:33Z; default: now.
    force : bool, optional
        Replaces existing files that the command did not write before.

    Returns
    -------
    Played
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
    Source: ``piezotact play``, ``docs/schemas/play.json``.
    """
    return run(Played, "play", locals(), outputs={"record": "measured.parquet"})


def verify(
    target: Data,
    measured: Data,
    *,
    unit: Unit = None,
    channel: str | None = None,
    measured_channel: str | None = None,
    measured_scale: Text | None = None,
    drive: Path | None = None,
    band: Text | None = None,
    transfer: Path | None = None,
    also: Data | Sequence[Data] | None = None,
    before: Path | Sequence[Path] | None = None,
    before_channel: str | None = None,
    before_stroke: int | None = None,
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
) -> Verification:
    """Verifies how close a measurement is to its target.

    Parameters
    ----------
    target : path, Recording, array_like or dict of array_like
        The texture that was rendered.
    measured : path, Recording, array_like or dict of array_like
        The recording made while it was played.
    unit : str or dict of str, optional
        The unit of an array, or of each channel by its name: ``"m/s2"``, ``"g"``, ``"N"``; ``"1"`` relative to full
        scale.
    channel : str, optional
        The channel of the target; optional if there is only one, or only one of acceleration.
    measured_channel : str, optional
        The channel of the measurement; optional if there is only one, or only one of acceleration.
    measured_scale : str or number, optional
        What the number 1 in the measurement means, if it differs from `scale`.
    drive : path, optional
        The drive (WAV) that was played, if the measurement does not contain it: its level and its achievable band are
        used.
    band : str or number, optional
        The band in which target and measurement are compared, in Hz; default: 20..1000, wider where the drive was
        rendered in a wider one.
    transfer : path, optional
        The transfer function: its figures are shown in the report, and the result of playing the texture directly on
        the device, without rendering, is predicted with it.
    also : path, Recording, array_like or dict of array_like, or a list, optional
        A further measurement of the same target, such as one rendered with an averaged transfer function; may be
        repeated. Each is verified in the same way, at the level stored with its rendering (`drive` applies to
        `measured` only); the verdict and the exit code are those of `measured`.
    before : path, or a list, optional
        A source of a manipulated target (`manipulate`): the original texture, or a texture whose level or spectrum was
        used; may be repeated. Levels, waveforms and spectra before and after the manipulation are compared.
    before_channel : str, optional
        The channel of the source textures; optional if there is only one, or only one of acceleration.
    before_stroke : int, optional
        Uses one stroke of the source textures, numbered from 1, as `manipulate `stroke`` does.
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
    Verification
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
    Source: ``piezotact verify``, ``docs/schemas/verify.json``.
    """
    return run(Verification, "verify", locals(), data=("target", "measured", "also"))


def score(
    reference: Data,
    test: Data,
    *,
    unit: Unit = None,
    channel: str | None = None,
    test_channel: str | None = None,
    test_scale: Text | None = None,
    band: Text | None = None,
    model: Literal["perceived", "spectral"] | None = None,
    jnd: float | None = None,
    frequency_jnd: float | None = None,
    contact_map: Path | None = None,
    full_scale: Text | None = None,
    curve: Literal["vibromaf", "mpeg"] | None = None,
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
) -> Score:
    """Estimates whether a person can discriminate two vibrations, in just-noticeable differences (JND).

    Parameters
    ----------
    reference : path, Recording, array_like or dict of array_like
        The reference: what should be felt.
    test : path, Recording, array_like or dict of array_like
        The vibration that is compared with A.
    unit : str or dict of str, optional
        The unit of an array, or of each channel by its name: ``"m/s2"``, ``"g"``, ``"N"``; ``"1"`` relative to full
        scale.
    channel : str, optional
        The channel of A; optional if there is only one, or only one of acceleration.
    test_channel : str, optional
        The channel of B, if it differs from `channel`.
    test_scale : str or number, optional
        What the number 1 in B means, if it differs from `scale`.
    band : str or number, optional
        The band in which A and B are compared, in Hz. Default: 20..1000.
    model : {'perceived', 'spectral'}, optional
        Which difference decides: the perceived one, or that of long-time spectra, which `jnd` and `frequency_jnd`
        concern. Default: perceived.
    jnd : float, optional
        The just-noticeable difference (JND) in level between spectra, in dB: smaller differences are not noticed;
        between it and 2.5 dB, the upper end of the published range, the result is not decided. Default: 1.58.
    frequency_jnd : float, optional
        The just-noticeable difference in frequency between spectra, as a fraction of the frequency. Default: 0.2.
    contact_map : path, optional
        The measured ratio of skin to nail vibration: a table of frequency (Hz) and skin over nail (dB, or ratio). By
        default, skin and nail are assumed to move equally.
    full_scale : str or number, optional
        The full scale that ST-SIM and SPQI assume, which neither paper states. Default: 1 m/s2.
    curve : {'vibromaf', 'mpeg'}, optional
        The threshold curve of ST-SIM and SPQI. Default: vibromaf.
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
    Score
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
    Source: ``piezotact score``, ``docs/schemas/score.json``.
    """
    return run(Score, "score", locals(), data=("reference", "test"))
