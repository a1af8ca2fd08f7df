"""Know a device. Written by ``generate.py``; do not edit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar, Literal

import numpy as np
import numpy.typing as npt

from .._call import run
from .._recording import Data, Path, Text, Unit
from .._results import Record, Result


class Transfer(Result):
    """A result with the file that holds it.

    Attributes: `averages`, `bias`, `change`, `condition`, `drive_setup`, `drive_unit`, `effective_averages`,
    `estimator`, `excited_hz`, `impact`, `known_input`, `limits`, `provenance`, `rate_hz`, `resolution_hz`,
    `response_unit`, `version`.
    ``found.to_dict()`` is the document.
    """

    SCHEMA: ClassVar[str] = "transfer"
    #: The number of segments averaged.
    averages: int
    #: How far H2 lies above H1 from 20 Hz on; absent where no line lies there.
    bias: Record | None
    #: How the response changed while it was measured: the transfer function is a mean of several states then. Absent
    #: where no change is shown.
    change: Record | None
    #: Who touched what, and how.
    condition: Record
    #: Gain and level of the device it was measured with; absent for a system that is not a PIEZOTACT.
    drive_setup: Record | None
    #: The unit of the drive.
    drive_unit: str
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
    #: What the confidence limits hold.
    limits: Any
    #: Where it comes from.
    provenance: Record
    #: The rate of the recording it was estimated from.
    rate_hz: float
    #: The distance of two lines, Hz.
    resolution_hz: float
    #: The unit of the response.
    response_unit: str
    version: int


class Characterisation(Result):
    """A result with the file that holds it.

    Attributes: `attempts`, `averages`, `band_hz`, `bias`, `change`, `condition`, `distortion`, `drive_setup`,
    `effective_averages`, `estimator`, `excited_hz`, `impact`, `known_input`, `limits`, `provenance`, `rate_hz`,
    `refused`, `repeats`, `repeats_apart_db_rms`, `resolution_hz`, `version`.
    ``found.to_dict()`` is the document.
    """

    SCHEMA: ClassVar[str] = "characterise"
    #: All attempts with their judgements, in order; none if nothing was judged.
    attempts: list[Record]
    #: The number of segments averaged.
    averages: int
    #: The band of the excitation.
    band_hz: npt.NDArray[np.float64]
    #: How far H2 lies above H1 from 20 Hz on; absent where no line lies there.
    bias: Record | None
    #: How the response changed while it was measured: the transfer function is a mean of several states then. Absent
    #: where no change is shown.
    change: Record | None
    #: Who touched what, and how.
    condition: Record
    #: Noise and distortion of all repeats together; absent where the excitation cannot separate them.
    distortion: Record | None
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
    #: What the confidence limits hold.
    limits: Any
    #: Where it comes from.
    provenance: Record
    #: The rate of the recording it was estimated from.
    rate_hz: float
    #: What was refused.
    refused: list[Record]
    #: Each of them; in documents their number.
    repeats: int
    #: How far the two that differ most lie apart over the excited band from 20 Hz up, dB rms; absent for one.
    repeats_apart_db_rms: float | None
    #: The distance of two lines, Hz.
    resolution_hz: float
    version: int


def transfer(
    recording: Data,
    drive: Text,
    response: Text,
    *,
    unit: Unit = None,
    scale: Text | Sequence[Text] | None = None,
    rate: float | None = None,
    part: int | None = None,
    excitation: Literal["auto", "random", "impact"] | None = None,
    segment: int | None = None,
    force_window: Literal["on", "off"] | None = None,
    exponential: Text | None = None,
    estimator: Literal["h1", "h2", "hv"] | None = None,
    noise_ratio: float | None = None,
    known_input: bool = False,
    device: Text | None = None,
    gain: Text | None = None,
    volts_per_full_scale: float | None = None,
    load_nf: float | None = None,
    out: Path | None = None,
    report: Path | None = None,
    csv: Path | None = None,
    figures: Path | None = None,
    tables: Path | None = None,
    columns: Literal["1", "2"] | None = None,
    date: str | None = None,
    force: bool = False,
) -> Transfer:
    """Estimates the transfer function between two channels of a recording.

    Parameters
    ----------
    recording : path, Recording, array_like or dict of array_like
        A recording that holds both channels.
    drive : str or number
        The channel of the drive.
    response : str or number
        The channel of the response.
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
    excitation : {'auto', 'random', 'impact'}, optional
        What the drive is taken for; a random estimate refuses a drive of short pulses. Default: auto.
    segment : int, optional
        Samples in a segment. Default: 0.41 s, 2048 at 5 kHz; for impacts, twice as long as the response takes to decay.
    force_window : {'on', 'off'}, optional
        Impacts: whether the force is set to zero after its pulse, which leaves out its noise. Default: on.
    exponential : str or number, optional
        Impacts: an exponential window for force and response, with its added damping in 1/s; auto takes as much as
        leaves 1 % of the response at the end of the segment, if more is left there. Default: off.
    estimator : {'h1', 'h2', 'hv'}, optional
        The estimator of the transfer function. Default: h1.
    noise_ratio : float, optional
        For `estimator` hv: the power of the noise on the response over that on the drive, in (units of the response per
        unit of the drive)². Without it Hv is the geometric mean of H1 and H2.
    known_input : bool, optional
        The drive is random and its channel holds the signal that was sent, not a measurement of it. Only then are the
        limits of H1 95 % confidence limits of the best linear approximation. A drive that repeats itself has none.
    device : str or number, optional
        The amplifier and the actuator: drv2667 (that of the thesis, the default), fixed, or a TOML file that describes
        them.
    gain : str or number, optional
        The gain set on the amplifier, by its name on the device, such as B3; together with `volts_per_full_scale` it
        describes the device. Optional if the device has only one gain.
    volts_per_full_scale : float, optional
        The peak voltage at the PC's output for a drive at full scale, in V. A drive channel in V is then converted to
        full scale = 1.
    load_nf : float, optional
        The capacitance of the actuator, in nF, if it differs from the description of the device.
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
    Transfer
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
    Source: ``piezotact transfer``, ``docs/schemas/transfer.json``.
    """
    return run(Transfer, "transfer", locals(), data=("recording",), outputs={"out": "transfer.json"})


def characterise(
    bench: Text,
    *,
    excitation: Text | None = None,
    seconds: float | None = None,
    repeats: Text | None = None,
    gating: Literal["on", "off"] | None = None,
    force_tolerance: float | None = None,
    least_coherence: float | None = None,
    attempts: Text | None = None,
    load: float | None = None,
    angle: float | None = None,
    band: Text | None = None,
    peak: float | None = None,
    segment: int | None = None,
    seed: int | None = None,
    record: Path | None = None,
    out: Path | None = None,
    live: bool = False,
    report: Path | None = None,
    csv: Path | None = None,
    figures: Path | None = None,
    tables: Path | None = None,
    columns: Literal["1", "2"] | None = None,
    date: str | None = None,
    force: bool = False,
) -> Characterisation:
    """Measures the transfer function of a device with a finger on it.

    Parameters
    ----------
    bench : str or number
        The bench: twin, or twin:participant=K,seed=N,gain=B3,device=NAME|FILE.toml; or measured:FILE,noise=0.003,seed=N
        (noise in m/s² rms), which simulates the response with the transfer function in FILE; with
        panel=FOLDER,placement=N, for another placement of that finger, drawn from the variability between placements in
        the panel; or fake:FILE.toml,participant=K, which follows the script in FILE.toml and simulates device faults,
        for tests and for training.
    excitation : str or number, optional
        random (band-limited noise, as in the thesis), sweep (three exponential sine sweeps) or multisine, which
        separates noise from distortion. Default: random.
    seconds : float, optional
        Maximum duration of the drive, in s. Default: 60.
    repeats : str or number, optional
        Number of measurements without repositioning the finger; the estimate uses all of them. Default: 1.
    gating : {'on', 'off'}, optional
        Whether a measurement is stopped and repeated when the force or the coherence is outside its limits. Default:
        on.
    force_tolerance : float, optional
        Largest relative deviation from the load of the mean force in every ten seconds; default 0.1.
    least_coherence : float, optional
        Smallest median coherence over the excited frequency lines in every ten seconds; default 0.9.
    attempts : str or number, optional
        Largest number of attempts at one measurement. Default: 3.
    load : float, optional
        The normal force that the participant holds, in N; default: that of the measured bench, otherwise 0.2.
    angle : float, optional
        The angle between finger and surface, in degrees; default: that of the measured bench, otherwise 20.
    band : str or number, optional
        The band that is excited, in Hz. Default: 2..1200.
    peak : float, optional
        The peak of the drive, as a fraction of the largest drive that the device can play. Default: 0.8.
    segment : int, optional
        Samples in a segment; default: 0.41 s, 2048 at 5 kHz.
    seed : int, optional
        Seed of the random drive. Default: 1.
    record : path, optional
        Also stores the recording; several recordings are numbered.
    out : path, optional
        The transfer function to write: JSON (.json), a universal file (.uff, .unv) or MATLAB (.mat). Default: a
        temporary file, which is removed with the result.
    live : bool, optional
        Prints the documents of every run (start, samples, judgements, end) as lines of JSON while it is acquired; a
        simulated bench then takes as long as a real one.
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
    Characterisation
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
    Source: ``piezotact characterise``, ``docs/schemas/characterise.json``.
    """
    return run(Characterisation, "characterise", locals(), outputs={"out": "transfer.json"})
