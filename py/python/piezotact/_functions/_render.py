"""Drives that make a finger feel a texture. Written by ``generate.py``; do not edit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar, Literal

import numpy as np
import numpy.typing as npt

from .._call import called_for, run
from .._recording import Data, Path, Text, Unit
from .._results import Record, Result


class Manipulated(Result):
    """A texture that was manipulated: what it was before and what it is after.

    Attributes: `condition`, `duration_s`, `lineage`, `rate_hz`, `rms_after`, `rms_before`, `text`, `unit`, `version`.
    ``found.to_dict()`` is the document.
    """

    SCHEMA: ClassVar[str] = "manipulate"
    #: What still holds of how it was recorded.
    condition: Record
    #: How long it is, s.
    duration_s: float
    #: What was done.
    lineage: Record
    #: Its rate, Hz.
    rate_hz: float
    #: The same after, in `unit`.
    rms_after: float
    #: Its root mean square about the mean before, in `unit`.
    rms_before: float
    #: What was done, in words.
    text: str
    #: Its unit.
    unit: str
    version: int


class Rendering(Result):
    """A texture that was rendered. It differs from the rendered drive by the names of files and by what every gain would
    need.

    Attributes: `achievable_band_hz`, `called`, `condition`, `drive_setup`, `gains`, `given_up_band_hz`, `headroom`,
    `level_db`, `loop`, `rate_hz`, `target`, `transfer`, `version`.
    ``found.to_dict()`` is the document.
    """

    SCHEMA: ClassVar[str] = "render"
    #: The parts of the band that the inverse reaches, Hz.
    achievable_band_hz: Any
    #: What it is called beside others.
    called: str
    #: Whose finger it is for.
    condition: Record
    #: The device it is for.
    drive_setup: Record | None
    #: What it would need, and have, at every gain; absent where the device is not known.
    gains: list[Record] | None
    #: The parts it gives up, Hz.
    given_up_band_hz: Any
    #: How much of the device it uses.
    headroom: Record
    #: The level it was rendered at, relative to the texture, dB.
    level_db: float
    #: What the closed loop found; absent for an open loop.
    loop: Record | None
    #: The rate of the drive, Hz.
    rate_hz: int
    #: The file of the texture.
    target: str
    #: The file of the transfer function.
    transfer: str
    version: int


class Renderings(Result):
    """Several textures or fingers in one go.

    Attributes: `refused`, `renderings`, `version`.
    ``found.to_dict()`` is the document.
    """

    SCHEMA: ClassVar[str] = "render_batch"
    #: What could not be.
    refused: list[Record]
    #: What was rendered: each [`RenderDocument`], or what it is as JSON, so that no samples are held until all is done.
    renderings: list[Record]
    version: int


class Prepared(Result):
    """The drives of one participant, one for each texture.

    Attributes: `band_hz`, `bench`, `failed`, `level_db`, `level_set_by`, `mode`, `not_good_enough`, `outcome`,
    `participant`, `sentence`, `textures`, `transfer`, `version`.
    ``found.to_dict()`` is the document.
    """

    SCHEMA: ClassVar[str] = "prepare"
    #: The band that was rendered and compared.
    band_hz: npt.NDArray[np.float64]
    #: The bench on which the drives were measured; absent if they were not.
    bench: str | None
    #: Recordings that gave no stroke.
    failed: list[Record] | None
    #: The level of all textures relative to their strokes, dB; absent where each has its own.
    level_db: float | None
    #: The texture that sets this level; absent where it was stated, or all fit at their own level.
    level_set_by: str | None
    #: What a closed loop corrected; absent in an open loop.
    mode: Any
    #: The textures that are not good enough.
    not_good_enough: list[Record]
    #: Whether all drives can be used.
    outcome: Any
    #: The participant; absent if nobody is named.
    participant: str | None
    #: The conclusion in one sentence.
    sentence: str
    #: The textures, in the order of their recordings.
    textures: list[Record]
    #: The transfer function.
    transfer: str
    version: int


class PreparedStimuli(Result):
    """The stimuli of a protocol, prepared for one participant.

    Attributes: `band_hz`, `bench`, `failed`, `level_db`, `level_set_by`, `mode`, `not_good_enough`, `outcome`,
    `participant`, `protocol`, `sentence`, `stimuli`, `textures`, `transfer`, `version`.
    ``found.to_dict()`` is the document.
    """

    SCHEMA: ClassVar[str] = "prepare_stimuli"
    #: The band that was rendered and compared.
    band_hz: npt.NDArray[np.float64]
    #: The bench on which the drives were measured; absent if they were not.
    bench: str | None
    #: Recordings that gave no stroke.
    failed: list[Record] | None
    #: The level of all textures relative to their strokes, dB; absent where each has its own.
    level_db: float | None
    #: The texture that sets this level; absent where it was stated, or all fit at their own level.
    level_set_by: str | None
    #: What a closed loop corrected; absent in an open loop.
    mode: Any
    #: The textures that are not good enough.
    not_good_enough: list[Record]
    #: Whether all drives can be used.
    outcome: Any
    #: The participant; absent if nobody is named.
    participant: str | None
    #: The name of the protocol.
    protocol: str
    #: The conclusion in one sentence.
    sentence: str
    #: The stimuli by name.
    stimuli: list[Record]
    #: The textures, in the order of their recordings.
    textures: list[Record]
    #: The transfer function.
    transfer: str
    version: int


def manipulate(
    input: Data,
    operations: Sequence[str | tuple[str, Path | Text]],
    *,
    unit: Unit = None,
    out: Path | None = None,
    stroke: int | None = None,
    of_stroke: int | None = None,
    rms_band: Text | None = None,
    seed: int | None = None,
    channel: str | None = None,
    of_channel: str | None = None,
    of_scale: Text | None = None,
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
) -> Manipulated:
    """Manipulates a texture (level, spectrum, phases, duration) and stores every operation with the result.

    Parameters
    ----------
    input : path, Recording, array_like or dict of array_like
        The texture: a recording in m/s² (Parquet, TDMS, WAV, FLAC, LVM, UFF, VHDR, EDF, BDF, XDF, SET, MAT, NPY, NPZ,
        catman BIN, HAPTIC, HJIF, CSV, TSV).
    operations : list of str or (str, value)
        What is done, in this order:
        ``randomise_phases``: Replaces the phases by random ones (`seed`): the same power spectrum, another waveform.
        ``rms_of`` (FILE): Scales the texture to the rms of another texture: only a gain.
        ``gain`` (DB): Raises or lowers the level, such as -3dB.
        ``band`` (LOW..HIGH:DB): Raises or lowers a band in Hz, such as 50..100:+6dB, or removes it: 50..100:remove.
        ``tilt`` (SLOPE@PIVOT): Tilts the spectrum about a frequency, such as 3dB/oct@200Hz; constant gain below 10 Hz.
        ``shift`` (HZ): Shifts every frequency by this many Hz, such as 20Hz.
        ``warp`` (RATIO): Multiplies every frequency, as at another sliding speed, such as 1.25; 1.25:keep-length keeps
        the duration.
        ``spectrum_of`` (FILE): Uses the shape of the spectrum of another texture; phases and rms are unchanged.
        ``reverse``: Reverses the texture in time: the same power spectrum, attacks become decays.
        ``loop`` (SECONDS): Changes the duration, such as 10s: the texture is repeated without clicks, or cut.
    unit : str or dict of str, optional
        The unit of an array, or of each channel by its name: ``"m/s2"``, ``"g"``, ``"N"``; ``"1"`` relative to full
        scale.
    out : path, optional
        The texture to write (WAV, 32-bit float); its sidecar is written beside it. Default: a temporary file, which is
        removed with the result.
    stroke : int, optional
        Uses one stroke of INPUT, numbered from 1 and with the movement of the hand (the gesture) filtered out, instead
        of the whole recording; RECORDING.cuts is applied.
    of_stroke : int, optional
        The stroke of the other recordings; default: that of `stroke`.
    rms_band : str or number, optional
        The band in which `rms_of` measures both levels; default: all frequencies.
    seed : int, optional
        Seed of the random phases of `randomise_phases`. Default: 1.
    channel : str, optional
        The channel; optional if there is only one, or only one of acceleration.
    of_channel : str, optional
        The channel of the other recordings.
    of_scale : str or number, optional
        What the number 1 in the other recordings means; default: what they state, otherwise `scale`.
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
    Manipulated
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
    Source: ``piezotact manipulate``, ``docs/schemas/manipulate.json``.
    """
    return run(Manipulated, "manipulate", locals(), data=("input",), outputs={"out": "texture.wav"})


def render(
    targets: Data | Sequence[Data],
    transfer: Path | Sequence[Path],
    *,
    unit: Unit = None,
    out: Path | None = None,
    band: Text | None = None,
    channel: str | None = None,
    scale: Text | Sequence[Text] | None = None,
    rate: float | None = None,
    part: int | None = None,
    gain: Text | None = None,
    device: Text | None = None,
    level: Text | None = None,
    drive_rate: int | None = None,
    inverse: Literal["plain", "constant", "coherence", "drive-limited"] | None = None,
    fade: float | None = None,
    phase: Literal["linear", "minimum"] | None = None,
    mode: Literal["replicate", "texture"] | None = None,
    bench: Text | Sequence[Text] | None = None,
    iterations: Text | None = None,
    load: float | None = None,
    angle: float | None = None,
    record: Path | None = None,
    discard_raw: bool = False,
    allow_clipping: bool = False,
    report: Path | None = None,
    csv: Path | None = None,
    figures: Path | None = None,
    tables: Path | None = None,
    columns: Literal["1", "2"] | None = None,
    date: str | None = None,
    force: bool = False,
) -> Rendering | Renderings:
    """Computes the drive that reproduces a texture on a resting finger.

    Parameters
    ----------
    targets : path, Recording, array_like or dict of array_like, or a list
        The textures: recordings in m/s².
    transfer : path, or a list
        The transfer function of the device with the finger on it; may be repeated, for several participants.
    unit : str or dict of str, optional
        The unit of an array, or of each channel by its name: ``"m/s2"``, ``"g"``, ``"N"``; ``"1"`` relative to full
        scale.
    out : path, optional
        The drive to write (WAV, 32-bit float), with its sidecar beside it; a folder for several textures or
        participants. Default: a temporary file, or a folder for several, which is removed with the result.
    band : str or number, optional
        The band that is rendered, in Hz. Default: 20..1000.
    channel : str, optional
        The channel of the texture; optional if there is only one, or only one of acceleration.
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
    gain : str or number, optional
        The gain set on the amplifier; must be the one the transfer function was measured with.
    device : str or number, optional
        The amplifier and the actuator, drv2667, fixed or a TOML file that describes them; must be those the transfer
        function was measured with.
    level : str or number, optional
        Raises or lowers the level of the texture by this many dB; `fit`: its own level, lowered only as much as the
        device requires, with `mode` texture after its peaks were limited. Default: 0.
    drive_rate : int, optional
        The rate of the drive, in Hz. Default: 48000.
    inverse : {'plain', 'constant', 'coherence', 'drive-limited'}, optional
        How the transfer function is inverted: plain (division, as in the thesis), constant (regularised), coherence
        (regularised and reduced where the coherence is low), or drive-limited (reduced where the target needs the
        largest drive, until the drive fits the device). Default: constant.
    fade : float, optional
        Fades the texture in and out over this time, in s. What a fade takes is missing when the rendering is verified.
        Default: 0.
    phase : {'linear', 'minimum'}, optional
        The phase of the inverse: linear (reproduces waveforms, with a delay) or minimum (spectra only; it rings before
        the beginning about as linear phase does, as the edges of the band do). Default: linear.
    mode : {'replicate', 'texture'}, optional
        Corrects the drive in a closed loop on `bench`: `replicate` corrects the waveform, `texture` the spectrum.
    bench : str or number, or a list, optional
        The bench of the closed loop: twin, or twin:participant=K,seed=N,gain=B3,device=NAME|FILE.toml; or
        measured:FILE,noise=0.003,seed=N (noise in m/s² rms), which simulates the response with the transfer function in
        FILE; with panel=FOLDER,placement=N, for another placement of that finger, drawn from the variability between
        placements in the panel; or fake:FILE.toml,participant=K, which follows the script in FILE.toml and simulates
        device faults, for tests and for training. May be repeated: one for each `transfer`; a single bench is used for
        all of them.
    iterations : str or number, optional
        Largest number of corrections, default 6; every drive is played twice, and the best drive once more.
    load : float, optional
        The normal force that the participant holds, in N; default: that of the measured bench, otherwise 0.2.
    angle : float, optional
        The angle between finger and surface, in degrees; default: that of the measured bench, otherwise 20.
    record : path, optional
        Stores the recording of the best drive (Parquet); a folder for several textures or participants.
    discard_raw : bool, optional
        Discards the measurements of the closed loop at the end; by default they are kept in the folder OUT.runs.
    allow_clipping : bool, optional
        Accepts a drive beyond the limits of the device, instead of refusing it: it is clipped, and its slope stays as
        it is. Not available in a closed loop, which never plays such a drive.
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
    Rendering or Renderings
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
    Source: ``piezotact render``, ``docs/schemas/render.json``, ``docs/schemas/render_batch.json``.
    """
    return run((Rendering, Renderings), "render", locals(), data=("targets",), outputs={"out": called_for("drive.wav", targets, transfer)})  # type: ignore[return-value]


def prepare(
    recordings: Path | Sequence[Path],
    transfer: Path,
    *,
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
    protocol: Path | None = None,
    bench: Text | None = None,
    out: Path | None = None,
    band: Text | None = None,
    level: Text | None = None,
    drive_rate: int | None = None,
    inverse: Literal["plain", "constant", "coherence", "drive-limited"] | None = None,
    mode: Literal["replicate", "texture"] | None = None,
    iterations: Text | None = None,
    report: Path | None = None,
    csv: Path | None = None,
    figures: Path | None = None,
    tables: Path | None = None,
    columns: Literal["1", "2"] | None = None,
    date: str | None = None,
    force: bool = False,
) -> Prepared | PreparedStimuli:
    """Prepares one verified drive for each texture from the strokes of a participant who has just touched the samples.

    Parameters
    ----------
    recordings : path, or a list
        Recordings (Parquet, TDMS, WAV, FLAC, LVM, UFF, VHDR, EDF, BDF, XDF, SET, MAT, NPY, NPZ, catman BIN, HAPTIC,
        HJIF, CSV, TSV).
    transfer : path
        The transfer function of the device with this participant's finger on it.
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
        The sampling rate, in Hz, of a table without a time column, or the rate at which a haptic file is played
        (default: the rate of the HJIF curves, otherwise 8000).
    part : int, optional
        The part of a recording with gaps (EEG formats, XDF) that is read, from 1 on; default: the first, with a
        warning.
    protocol : path, optional
        Makes every stimulus of a protocol (a file, or a name of the library) from these strokes, under its name there.
        What an interrupted command has prepared is verified, and not made again.
    bench : str or number, optional
        The bench on which the drives are played and measured: twin, or
        twin:participant=K,seed=N,gain=B3,device=NAME|FILE.toml; or measured:FILE,noise=0.003,seed=N (noise in m/s²
        rms), which simulates the response with the transfer function in FILE; with panel=FOLDER,placement=N, for
        another placement of that finger, drawn from the variability between placements in the panel; or
        fake:FILE.toml,participant=K, which follows the script in FILE.toml and simulates device faults, for tests and
        for training; without it, they are rendered and not verified.
    out : path, optional
        The folder to write: targets/, drives/ and measured/, with one file for each texture. Default: a temporary
        folder, which is removed with the result.
    band : str or number, optional
        The band that is rendered and compared, in Hz. Default: 20..1000.
    level : str or number, optional
        The level re the strokes: `common`, one level for all textures, lowered only as much as the device requires;
        `fit`, for each texture its own; or a number, in dB. Default: common.
    drive_rate : int, optional
        The rate of the drives, in Hz. Default: 48000.
    inverse : {'plain', 'constant', 'coherence', 'drive-limited'}, optional
        How the transfer function is inverted, as in `piezotact render`. Default: constant.
    mode : {'replicate', 'texture'}, optional
        Corrects each drive in a closed loop on `bench`: `replicate` corrects the waveform, `texture` the spectrum.
    iterations : str or number, optional
        Largest number of corrections, default 6.
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
    Prepared or PreparedStimuli
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
    Source: ``piezotact prepare``, ``docs/schemas/prepare.json``, ``docs/schemas/prepare_stimuli.json``.
    """
    return run((Prepared, PreparedStimuli), "prepare", locals(), outputs={"out": "prepared"})  # type: ignore[return-value]
