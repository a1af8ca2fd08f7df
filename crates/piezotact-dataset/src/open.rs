//! Reads recordings of every format; the format is recognised from the content of a file, not from its name.

mod arrays;
mod beside;
mod blocks;
mod finite;
mod npy;
mod sound;

use piezotact::checksum::Checksum;
use std::collections::BTreeMap;
use std::path::Path;

use piezotact::Warning;
use piezotact::device::DriveSetup;
use piezotact::lineage::Lineage;
use piezotact::quantity::{Measure, SampleRate};
use piezotact::recording::{
    Channel, Condition, Provenance, Recording, RecordingWarning, Stated, played_through_its_own,
};

use crate::catman::{looks_like_catman, parse_catman};
use crate::csv_table::read_table;
#[cfg(feature = "eeg")]
use crate::eeg;
use crate::error::ReadError;
use crate::format::{self, Format, Opened, Recognition};
use crate::haptic::{self, HapticKind, haptic_kind};
use crate::journal::{is_journal, journal_path, read_run_journal};
use crate::lvm::{looks_like_lvm, parse_lvm};
use crate::matlab;
use crate::recording_file::{Stored, of_another, read_parquet};
use crate::sidecar::{OfSamples, Rendering, measure_or_unit, sidecar_path, unit_and_factor};
use crate::tdms::{looks_like_tdms, read_tdms};
use crate::text::is_text;
use crate::uff;
use crate::wav::{SampleFormat, Wav, fingerprint, parse_wav, start_in};
pub use arrays::{ArrayChannel, recording_of_arrays};
use beside::{Beside, completed};
pub use blocks::{RecordingInBlocks, recording_in_blocks};
use finite::{finite, not_a_sample};
pub use npy::{NumberTable, is_npy, parse_npy};

/// Information stated by the user in addition to that in the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadOptions {
    /// What the number 1 stands for: full scale of a WAV file, or plain numbers of a table.
    pub scale: Option<Measure>,
    /// The unit of single channels by their name, or what 1 in them stands for: `N`, `2 mN`.
    pub units: BTreeMap<String, String>,
    /// The rate, for a table without a time column.
    pub rate: Option<SampleRate>,
    /// Whether it is read as a drive: full scale is its unit, and needs no scale.
    pub is_drive: bool,
    /// Which part of a recording with gaps is read, from 1 on; `None`: the first, with a warning.
    pub part: Option<usize>,
}

/// What kind of file a recording was read from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FileKind {
    name: &'static str,
    samples: Option<SampleFormat>,
}

impl FileKind {
    /// No file: arrays of numbers.
    pub const ARRAYS: Self = Self::named("arrays");
    /// A WAV file.
    pub const WAV: Self = Self::named("WAV");
    /// A FLAC file.
    pub const FLAC: Self = Self::named("FLAC");
    /// A Parquet file.
    pub const PARQUET: Self = Self::named("Parquet");
    /// The journal of an interrupted recording.
    pub const JOURNAL: Self = Self::named("journal of an interrupted recording");
    /// A table of text.
    pub const TABLE: Self = Self::named("table of text");
    /// A LabVIEW measurement file.
    pub const LVM: Self = Self::named("LabVIEW measurement");
    /// An NI TDMS file.
    pub const TDMS: Self = Self::named("TDMS");
    /// A universal file.
    pub const UFF: Self = Self::named("universal file");
    /// A MATLAB file.
    pub const MATLAB: Self = Self::named("MATLAB");
    /// A `.haptic` clip.
    pub const HAPTIC_CLIP: Self = Self::named("haptic clip");
    /// MPEG haptics JSON.
    pub const HJIF: Self = Self::named("MPEG haptics JSON (HJIF)");
    /// Apple's AHAP, which is no recording.
    pub const AHAP: Self = Self::named("AHAP");

    /// The kind called `name`.
    pub(crate) const fn named(name: &'static str) -> Self {
        Self {
            name,
            samples: None,
        }
    }

    /// The kind of files with the ending of `path`; `None` where no format has it.
    #[must_use]
    pub fn of_ending(path: &Path) -> Option<Self> {
        format::of_ending(RECORDINGS, path).map(|format| format.kind)
    }

    /// The usual ending of its files, without the dot; `None` where they have none.
    #[must_use]
    pub fn ending(self) -> Option<&'static str> {
        let row = RECORDINGS
            .iter()
            .find(|format| format.kind.name == self.name);
        row.and_then(|format| format.endings.first().copied())
    }
}

impl std::fmt::Display for FileKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name)?;
        self.samples
            .map_or(Ok(()), |format| write!(f, ", {format}"))
    }
}

/// What reads a recording.
type Reader = fn(&mut Opened<'_>, &ReadOptions) -> Result<Stored, ReadError>;

/// The formats of recordings, in the order in which they are looked for.
static RECORDINGS: &[Format<FileKind, Reader>] = &[
    Format {
        kind: FileKind::PARQUET,
        label: "Parquet",
        endings: &["parquet"],
        sniff: Recognition::Head(|head| head.starts_with(b"PAR1")),
        read: |file, options| {
            let path = file.path;
            if of_another(path)? {
                let read = |options: &ReadOptions| Ok(read_parquet(path, options)?.recording);
                return completed(path, options, read);
            }
            if let Some(part) = options.part.filter(|part| *part != 1) {
                return Err(no_part(path, part, 1));
            }
            let mut stored = read_parquet(path, options)?;
            let unread = beside::unread(path, FileKind::PARQUET);
            stored.recording.about.warnings.extend(unread);
            Ok(stored)
        },
    },
    Format {
        kind: FileKind::JOURNAL,
        label: "",
        endings: &["part"],
        sniff: Recognition::Head(is_journal),
        read: |file, _| read_run_journal(file.path),
    },
    Format {
        kind: FileKind::TDMS,
        label: "TDMS",
        endings: &["tdms"],
        sniff: Recognition::Head(looks_like_tdms),
        read: |file, options| Ok(read_tdms(file.path, options)?.into()),
    },
    // Of files of other versions, nothing public says how they begin: they are known by their names too.
    Format {
        kind: FileKind::named("DewesoftX"),
        label: "",
        endings: &["dxd", "d7d"],
        sniff: Recognition::Whole(|path, bytes| {
            let ending = path.extension().map(|ending| ending.to_ascii_lowercase());
            bytes.starts_with(b"MULTI_STREAM_FILE_VER")
                || ending.is_some_and(|ending| ending == "dxd" || ending == "d7d")
                    && bytes.contains(&0)
        }),
        read: |file, _| {
            let todo = "export it in DewesoftX as CSV with a header, universal file (UFF 58) or MATLAB (-v7)";
            Err(none(file, "a DewesoftX file", todo.into()))
        },
    },
    Format {
        kind: FileKind::WAV,
        label: "WAV",
        endings: &["wav"],
        sniff: Recognition::Head(|head| head.starts_with(b"RIFF") || head.starts_with(b"RF64")),
        read: |file, options| from_wav(file.path, file.bytes()?, options),
    },
    sound::FLAC,
    sound::OTHERS,
    Format {
        kind: FileKind::LVM,
        label: "LVM",
        endings: &["lvm"],
        sniff: Recognition::Head(looks_like_lvm),
        read: |file, options| {
            let (path, bytes) = (file.path, file.bytes()?);
            completed(path, options, |options| parse_lvm(path, bytes, options))
        },
    },
    Format {
        kind: FileKind::UFF,
        label: "UFF",
        endings: &["uff", "unv"],
        sniff: Recognition::Head(uff::looks_like_uff),
        read: |file, options| {
            let path = file.path;
            let functions = uff::parse_uff(path, file.bytes()?)?;
            let read = |options: &ReadOptions| uff::recording_of(path, &functions, options);
            completed(path, options, read)
        },
    },
    #[cfg(feature = "eeg")]
    Format {
        kind: FileKind::named("BrainVision"),
        label: "VHDR",
        endings: &["vhdr"],
        sniff: Recognition::Head(eeg::looks_like_brainvision),
        read: from_eeg,
    },
    #[cfg(feature = "eeg")]
    Format {
        kind: FileKind::named("BrainVision markers"),
        label: "",
        endings: &["vmrk"],
        sniff: Recognition::Head(eeg::looks_like_markers),
        read: |file, _| Err(eeg::not_the_header(file.path)),
    },
    #[cfg(feature = "eeg")]
    Format {
        kind: FileKind::named("EDF or BDF"),
        label: "EDF, BDF",
        endings: &["edf", "bdf"],
        sniff: Recognition::Head(|head| eeg::looks_like_edf(head) || eeg::looks_like_bdf(head)),
        read: from_eeg,
    },
    #[cfg(feature = "eeg")]
    Format {
        kind: FileKind::named("XDF"),
        label: "XDF",
        endings: &["xdf"],
        sniff: Recognition::Head(eeg::looks_like_xdf),
        read: |file, options| {
            let part = options.part;
            Ok(eeg::recording_of_xdf(file.path, file.bytes()?, part)?.into())
        },
    },
    // Known by its name too: it is a MATLAB file.
    #[cfg(feature = "eeg")]
    Format {
        kind: FileKind::named("EEGLAB"),
        label: "SET",
        endings: &["set"],
        sniff: Recognition::Whole(eeg::is_called_set),
        read: from_eeg,
    },
    #[cfg(not(feature = "eeg"))]
    Format {
        kind: FileKind::named("EEG"),
        label: "",
        endings: &["vhdr", "vmrk", "edf", "bdf", "xdf", "set"],
        sniff: Recognition::Whole(|path, _| {
            let ending = path.extension().map(|ending| ending.to_ascii_lowercase());
            let known = ["vhdr", "vmrk", "edf", "bdf", "xdf", "set"];
            ending.is_some_and(|ending| known.iter().any(|known| ending == *known))
        }),
        read: |file, _| {
            let todo = "build piezotact with ./x build, which reads it";
            Err(none(
                file,
                "an EEG file, which this build does not read",
                todo.into(),
            ))
        },
    },
    Format {
        kind: FileKind::MATLAB,
        label: "MAT",
        endings: &["mat"],
        sniff: Recognition::Head(matlab::looks_like_mat),
        read: |file, options| {
            let path = file.path;
            let content = matlab::parse_mat(path, &file.take_bytes()?)?;
            let read = |options: &ReadOptions| matlab::recording_of(path, &content, options);
            completed(path, options, read)
        },
    },
    npy::NPY,
    Format {
        kind: FileKind::named("catman"),
        label: "catman BIN",
        endings: &["bin"],
        sniff: Recognition::Head(looks_like_catman),
        read: |file, options| Ok(parse_catman(file.path, file.bytes()?, options)?.into()),
    },
    Format {
        kind: FileKind::HAPTIC_CLIP,
        label: if cfg!(feature = "haptic") {
            "HAPTIC"
        } else {
            ""
        },
        endings: &["haptic"],
        sniff: Recognition::Whole(|_, bytes| haptic_kind(bytes) == Some(HapticKind::Clip)),
        read: from_clip,
    },
    Format {
        kind: FileKind::HJIF,
        label: if cfg!(feature = "haptic") { "HJIF" } else { "" },
        endings: &["hjif"],
        sniff: Recognition::Whole(|_, bytes| haptic_kind(bytes) == Some(HapticKind::Hjif)),
        read: from_hjif,
    },
    Format {
        kind: FileKind::AHAP,
        label: "",
        endings: &["ahap"],
        sniff: Recognition::Whole(|_, bytes| haptic_kind(bytes) == Some(HapticKind::Ahap)),
        read: |file, _| {
            let what = "an AHAP file, whose intensity and sharpness do not define a vibration";
            let todo = "give the .haptic clip or the recording that it was made from";
            Err(none(file, what, todo.into()))
        },
    },
    Format {
        kind: FileKind::named("JSON"),
        label: "",
        endings: &["json"],
        sniff: Recognition::Whole(|path, bytes| {
            haptic::is_called_haptic(path, bytes) || bytes.starts_with(b"{")
        }),
        read: refuse_json,
    },
    // Any other text: this row must stay the last one.
    Format {
        kind: FileKind::TABLE,
        label: "CSV, TSV",
        endings: &["csv", "tsv", "txt"],
        sniff: Recognition::Whole(|_, bytes| is_text(bytes)),
        read: |file, options| {
            let (path, bytes) = (file.path, file.bytes()?);
            completed(path, options, |options| read_table(path, bytes, options))
        },
    },
];

/// The formats of recordings that can be read, for people: `WAV, MAT, CSV`.
#[must_use]
pub fn recording_formats() -> String {
    format::list(RECORDINGS, ", ")
}

/// A recording, the kind of file it came from, and the drive that was played with it.
#[derive(Clone, Debug, PartialEq)]
pub struct Contents {
    /// The recording, in SI.
    pub recording: Recording,
    /// The kind of file.
    pub kind: FileKind,
    /// The device that played while it was recorded, or that a drive is for.
    pub setup: Option<DriveSetup>,
    /// How the drive was made: of a drive's own WAV file, or of the drive that was played while recording.
    pub rendering: Option<Rendering>,
    /// The checksum of the drive that was played while recording; absent where the file does not say it.
    pub played: Option<Checksum>,
}

impl Contents {
    /// The lineage of the texture in the file, or of the one that was rendered and played.
    #[must_use]
    pub fn lineage(&self) -> Option<&Lineage> {
        let own = self.recording.about.provenance.lineage.as_ref();
        let rendering = self.rendering.as_ref();
        own.or_else(|| rendering?.about.provenance.lineage.as_ref())
    }
}

/// Reads the recording in `path`, whatever kind of file it is. An interrupted recording is read from its
/// journal.
///
/// # Errors
/// [`ReadError`] naming the file, what was expected, what was found, and what to do.
pub fn read_recording(path: &Path, options: &ReadOptions) -> Result<Contents, ReadError> {
    if !path.exists() && journal_path(path).exists() {
        return from_journal(&journal_path(path));
    }
    let mut file = Opened::open(path)?;
    if file.head().is_empty() {
        return Err(none(
            &file,
            "an empty file",
            "copy or export it again".into(),
        ));
    }
    let Some(format) = format::recognise(RECORDINGS, &mut file)? else {
        let todo = format!("export it as {}", format::list(RECORDINGS, " or "));
        return Err(none(&file, "a binary file of an unknown kind", todo));
    };
    let mut stored = (format.read)(&mut file, options)?;
    // The others are sampled evenly without a pause.
    let has_parts = [
        "vhdr", "edf", "xdf", "set", "csv", "lvm", "uff", "mat", "npy", "bin", "tdms", "parquet",
    ]
    .contains(format.endings.first().unwrap_or(&""));
    if let Some(part) = options.part.filter(|part| *part != 1 && !has_parts) {
        return Err(no_part(path, part, 1));
    }
    stored
        .recording
        .about
        .warnings
        .extend(beside::not_read(path, format.kind));
    finite(path, contents_of(stored, format.kind))
}

/// A file that holds no recording.
fn none(file: &Opened<'_>, found: &str, todo: String) -> ReadError {
    ReadError::content(file.path, "a recording", found, todo)
}

fn refuse_json(file: &mut Opened<'_>, _: &ReadOptions) -> Result<Stored, ReadError> {
    if haptic::is_called_haptic(file.path, file.bytes()?) {
        return Err(ReadError::content(
            file.path,
            "a haptic clip with `signals` (or `voices`), or HJIF with `perceptions`",
            "JSON without any of them",
            "export it again, or give the recording that it was made from",
        ));
    }
    let todo = format!("give a file that is {}", format::list(RECORDINGS, " or "));
    Err(none(file, "JSON", todo))
}

#[cfg(feature = "haptic")]
fn from_clip(file: &mut Opened<'_>, options: &ReadOptions) -> Result<Stored, ReadError> {
    let clip = haptic::parse_haptic(file.path, file.bytes()?)?;
    Ok(haptic::recording_of_clip(file.path, clip, options)?.into())
}

#[cfg(feature = "haptic")]
fn from_hjif(file: &mut Opened<'_>, options: &ReadOptions) -> Result<Stored, ReadError> {
    let content = haptic::parse_hjif(file.path, file.bytes()?)?;
    Ok(haptic::recording_of_hjif(file.path, &content, options)?.into())
}

#[cfg(not(feature = "haptic"))]
use {not_here as from_clip, not_here as from_hjif};

/// A haptic file, in a build that reads none.
#[cfg(not(feature = "haptic"))]
fn not_here(file: &mut Opened<'_>, _: &ReadOptions) -> Result<Stored, ReadError> {
    let todo = "build piezotact with ./x build, which reads it";
    Err(none(
        file,
        "a haptic file, which this build does not read",
        todo.into(),
    ))
}

/// A part of an EEG file.
#[cfg(feature = "eeg")]
fn from_eeg(file: &mut Opened<'_>, options: &ReadOptions) -> Result<Stored, ReadError> {
    Ok(eeg::recording_of_eeg(file.path, options.part)?.into())
}

/// A part that a recording of `count` parts does not have.
pub(crate) fn no_part(path: &Path, part: usize, count: usize) -> ReadError {
    let expected = match count {
        1 => "part 1: the recording has no gap".into(),
        _ => format!("a part from 1 to {count}"),
    };
    ReadError::content(path, expected, format!("part {part}"), "give another part")
}

fn from_journal(path: &Path) -> Result<Contents, ReadError> {
    finite(
        path,
        contents_of(read_run_journal(path)?, FileKind::JOURNAL),
    )
}

fn contents_of(mut stored: Stored, kind: FileKind) -> Contents {
    let recording = &mut stored.recording;
    if let Some(rendering) = &stored.rendering {
        let its_own =
            played_through_its_own(&rendering.about.provenance, &recording.about.provenance);
        recording.about.add_warnings(its_own);
    }
    let setup = stored.setup.or_else(|| {
        stored
            .rendering
            .as_ref()
            .and_then(|rendering| rendering.setup.clone())
    });
    Contents {
        recording: stored.recording,
        kind: FileKind {
            samples: stored.samples,
            ..kind
        },
        setup,
        rendering: stored.rendering,
        played: stored.played,
    }
}

fn from_wav(path: &Path, bytes: &[u8], options: &ReadOptions) -> Result<Stored, ReadError> {
    let wav = parse_wav(path, bytes)?;
    let step = wav.format.step_ratio();
    from_sound(path, bytes, wav, step, options)
}

/// The samples of a sound file, whose converter has this `step`, with what the sidecar says of them.
fn from_sound(
    path: &Path,
    bytes: &[u8],
    mut wav: Wav,
    step: Option<f64>,
    options: &ReadOptions,
) -> Result<Stored, ReadError> {
    let beside = Beside::read(path)?.unwrap_or_else(|| Beside::none(path));
    let of_samples = beside.of_samples.clone();
    let mut warnings = std::mem::take(&mut wav.warnings);
    require_own_sidecar(path, bytes, &wav, &of_samples)?;
    let count = wav.channels.len();
    if let Some(names) = of_samples.channels.filter(|names| names.len() != count) {
        return Err(beside.other_count(count, names.len()));
    }
    if let Some(stated) = options.rate
        && stated.hz() != f64::from(wav.rate_hz)
    {
        warnings.push(Warning::from(RecordingWarning::StatedDiffers {
            what: Stated::RateKept {
                stated_hz: stated.hz(),
                found_hz: f64::from(wav.rate_hz),
            },
        }));
    }
    let mut options = options.clone();
    beside.scale(&mut options, &mut warnings);
    let (unit, factor) = unit_and_factor(options.scale.as_ref());
    let known = options.scale.is_some();
    let alone = count == 1;
    let channels: Vec<Channel> = wav
        .channels
        .into_iter()
        .enumerate()
        .map(|(i, mut samples)| {
            let fallback = if alone {
                "signal".into()
            } else {
                format!("channel {}", i + 1)
            };
            let name = beside.sidecar.channels.get(i).cloned().unwrap_or(fallback);
            let own = (options.units.get(&name))
                .or_else(|| beside.of_samples.units.get(&name))
                .map(|text| measure_or_unit(text));
            if !known && own.is_none() && !options.is_drive {
                warnings.push(Warning::from(RecordingWarning::Uncalibrated {
                    channel: name.clone(),
                }));
            }
            let (unit, factor) = own.unwrap_or((unit.clone(), factor));
            if let Some(step) = step {
                warnings.extend(piezotact::spectrum::quantisation_warning(
                    &name, &samples, step,
                ));
            }
            for sample in &mut samples {
                *sample *= factor;
            }
            Channel {
                name,
                unit,
                samples,
            }
        })
        .collect();
    beside.names_fit(channels.iter().map(|channel| channel.name.as_str()))?;
    let rate = SampleRate::new(f64::from(wav.rate_hz)).map_err(ReadError::of(path))?;
    let provenance = Provenance {
        source: path.display().to_string(),
        ..Provenance::default()
    };
    let mut recording = Recording::new(channels, rate, Condition::default(), provenance)
        .map_err(ReadError::of(path))?;
    recording.about.warnings = warnings;
    let mut stored = Stored {
        recording,
        setup: None,
        rendering: None,
        played: None,
        samples: Some(wav.format),
    };
    beside.describe(&mut stored);
    let started = &mut stored.recording.annotations.started_at;
    *started = started.take().or_else(|| start_in(bytes));
    Ok(stored)
}

/// Refuses a sidecar that was written for other samples or another rate.
fn require_own_sidecar(
    path: &Path,
    bytes: &[u8],
    wav: &Wav,
    of_samples: &OfSamples,
) -> Result<(), ReadError> {
    if let Some(stated) = &of_samples.samples
        && *stated != fingerprint(path, bytes)?
    {
        return Err(ReadError::content(
            path,
            format!(
                "the samples that {} was written for",
                sidecar_path(path).display()
            ),
            "other samples: an overwrite was interrupted, or another program changed them",
            "write the file again; for a recording whose sidecar is valid for these samples, remove `samples` from it (a drive or a target needs it in a session: make it again)",
        ));
    }
    if let Some(stated_hz) = of_samples.rate_hz
        && stated_hz != f64::from(wav.rate_hz)
    {
        return Err(ReadError::content(
            path,
            format!(
                "the rate that {} states, {stated_hz} Hz",
                sidecar_path(path).display()
            ),
            format!("a header with {} Hz", wav.rate_hz),
            "correct the one that is wrong; all frequencies and times depend on it",
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lists, endings and kinds come from one table; what takes every text stands last in it.
    #[test]
    fn the_table_says_which_formats_there_are() {
        let list = recording_formats();
        for part in ["Parquet", "WAV", "MAT", "CSV, TSV"] {
            assert!(list.contains(part), "{list}");
        }
        assert!(
            !list.contains("Dewesoft") && !list.contains("AHAP"),
            "{list}"
        );
        assert_eq!(FileKind::of_ending(Path::new("A.UNV")), Some(FileKind::UFF));
        assert_eq!(FileKind::of_ending(Path::new("a.xyz")), None);
        assert_eq!(FileKind::HAPTIC_CLIP.ending(), Some("haptic"));
        assert_eq!(RECORDINGS.last().map(|row| row.kind), Some(FileKind::TABLE));
        for (i, row) in RECORDINGS.iter().enumerate() {
            let others = &RECORDINGS[..i];
            assert!(others.iter().all(|other| other.kind != row.kind));
            for ending in row.endings {
                assert!(
                    !others.iter().any(|other| other.endings.contains(ending)),
                    "{ending}"
                );
            }
        }
        let folder = tempfile::tempdir().unwrap();
        for (bytes, part) in [
            (
                &b"{\"a\": 1}"[..],
                "found JSON; give a file that is Parquet, TDMS, WAV,",
            ),
            (b"\x01\x00\x02", "export it as Parquet, TDMS, WAV,"),
            (b"\x01\x00\x02", "found a DewesoftX file; export it"),
            (
                b"MULTI_STREAM_FILE_VER0",
                "found a DewesoftX file; export it",
            ),
        ] {
            let name = if part.contains("Dewesoft") {
                "a.DXD"
            } else {
                "a"
            };
            let path = folder.path().join(name);
            std::fs::write(&path, bytes).unwrap();
            let error = read_recording(&path, &ReadOptions::default()).unwrap_err();
            assert!(error.to_string().contains(part), "{error}");
        }
    }
}
