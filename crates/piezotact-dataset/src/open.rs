//! One door for every recording: what a file is stands in its content, not in its name.

use std::io::Read as _;
use std::path::Path;

use piezotact::Doubt;
use piezotact::device::DriveSetup;
use piezotact::quantity::{Measure, SampleRate};
use piezotact::recording::{Channel, Provenance, Recording, played_through_its_own};
use piezotact::series::is_sample;

use crate::csv_table::read_table;
use crate::error::ReadError;
use crate::haptic::{self, HapticKind};
use crate::journal::{is_journal, journal_path, read_run_journal};
use crate::lvm::{looks_like_lvm, parse_lvm};
use crate::matlab;
use crate::recording_file::{Stored, read_journal, read_parquet};
use crate::sidecar::{Rendering, read_with_samples, sidecar_path, unit_and_factor};
use crate::uff;
use crate::wav::{SampleFormat, fingerprint, parse_wav};

/// What a person adds to what a file says of itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadOptions {
    /// What a sample of 1 stands for: full scale of a WAV file, or plain numbers of a table.
    pub scale: Option<Measure>,
    /// The rate, for a table without a time column.
    pub rate: Option<SampleRate>,
}

/// What kind of file a recording was read from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    /// A WAV file and how it stores its samples.
    Wav(SampleFormat),
    /// A Parquet file.
    Parquet,
    /// The journal of an interrupted recording.
    Journal,
    /// A table of text.
    Table,
    /// A LabVIEW measurement file.
    Lvm,
    /// A universal file.
    Uff,
    /// A MATLAB file.
    Matlab,
    /// A `.haptic` clip.
    HapticClip,
    /// MPEG haptics JSON.
    Hjif,
}

impl std::fmt::Display for FileKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Wav(format) => write!(f, "WAV, {format}"),
            Self::Parquet => f.write_str("Parquet"),
            Self::Journal => f.write_str("journal of an interrupted recording"),
            Self::Table => f.write_str("table of text"),
            Self::Lvm => f.write_str("LabVIEW measurement"),
            Self::Uff => f.write_str("universal file"),
            Self::Matlab => f.write_str("MATLAB"),
            Self::HapticClip => f.write_str("haptic clip"),
            Self::Hjif => f.write_str("MPEG haptics JSON (HJIF)"),
        }
    }
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
    let mut file = std::fs::File::open(path).map_err(|error| ReadError::io(path, &error))?;
    let mut head = Vec::new();
    file.by_ref()
        .take(12)
        .read_to_end(&mut head)
        .map_err(|error| ReadError::io(path, &error))?;
    let known_elsewhere =
        |what: &str, todo: &str| ReadError::content(path, "a recording", what, todo);
    match head.as_slice() {
        [] => Err(known_elsewhere("an empty file", "copy or export it again")),
        [b'P', b'A', b'R', b'1', ..] => {
            let stored = read_parquet(path, options.rate)?;
            finite(path, contents_of(stored, FileKind::Parquet))
        }
        head if is_journal(head) => from_journal(path),
        [0xFF, 0xFF, 0xFF, 0xFF, ..] => from_journal(path),
        [b'T', b'D', b'S', b'm', ..] => Err(known_elsewhere(
            "a TDMS file",
            "export it as CSV with a header",
        )),
        _ => {
            let mut bytes = head;
            file.read_to_end(&mut bytes)
                .map_err(|error| ReadError::io(path, &error))?;
            if bytes.starts_with(b"RIFF") || bytes.starts_with(b"RF64") {
                return from_wav(path, &bytes, options);
            }
            match haptic::haptic_kind(&bytes) {
                None if haptic::is_called_haptic(path, &bytes) => {
                    return Err(ReadError::content(
                        path,
                        "a haptic clip with `signals` (or `voices`), or HJIF with `perceptions`",
                        "JSON without any of them",
                        "export it again, or give the recording that it was made from",
                    ));
                }
                None if bytes.starts_with(b"{") => {
                    return Err(known_elsewhere(
                        "JSON",
                        "give a WAV, CSV, Parquet, LVM, UFF, MAT, HAPTIC or HJIF file",
                    ));
                }
                None => {}
                Some(kind) => return from_haptic(path, &bytes, kind, options),
            }
            let (recording, kind) = if looks_like_lvm(&bytes) {
                (parse_lvm(path, &bytes, options)?, FileKind::Lvm)
            } else if uff::looks_like_uff(&bytes) {
                let functions = uff::parse_uff(path, &bytes)?;
                let recording = uff::recording_of(path, &functions, options)?;
                (recording, FileKind::Uff)
            } else if matlab::looks_like_mat(&bytes) {
                let file = matlab::parse_mat(path, &bytes)?;
                let recording = matlab::recording_of(path, &file, options)?;
                (recording, FileKind::Matlab)
            } else if bytes.contains(&0) {
                return Err(known_elsewhere(
                    "a binary file of an unknown kind",
                    "export it as WAV, CSV, MAT or Parquet",
                ));
            } else {
                (read_table(path, &bytes, options)?, FileKind::Table)
            };
            let stored = Stored {
                recording,
                setup: None,
                rendering: None,
            };
            finite(path, contents_of(stored, kind))
        }
    }
}

fn from_haptic(
    path: &Path,
    bytes: &[u8],
    kind: HapticKind,
    options: &ReadOptions,
) -> Result<Contents, ReadError> {
    let (recording, kind) = match kind {
        HapticKind::Clip => {
            let clip = haptic::parse_haptic(path, bytes)?;
            let recording = haptic::recording_of_clip(path, clip, options)?;
            (recording, FileKind::HapticClip)
        }
        HapticKind::Hjif => {
            let file = haptic::parse_hjif(path, bytes)?;
            let recording = haptic::recording_of_hjif(path, &file, options)?;
            (recording, FileKind::Hjif)
        }
        HapticKind::Ahap => {
            return Err(ReadError::content(
                path,
                "a recording",
                "an AHAP file, whose intensities and sharpnesses stand for no vibration in particular",
                "give the .haptic clip or the recording that it was made from",
            ));
        }
    };
    let stored = Stored {
        recording,
        setup: None,
        rendering: None,
    };
    finite(path, contents_of(stored, kind))
}

fn from_journal(path: &Path) -> Result<Contents, ReadError> {
    let mut head = [0; 8];
    let begins = std::fs::File::open(path).and_then(|mut file| file.read_exact(&mut head));
    let stored = match begins.is_ok() && is_journal(&head) {
        true => read_run_journal(path)?,
        // Of the version before.
        false => read_journal(path)?,
    };
    finite(path, contents_of(stored, FileKind::Journal))
}

fn contents_of(mut stored: Stored, kind: FileKind) -> Contents {
    let recording = &mut stored.recording;
    // What files of before say in their provenance alone.
    let known = std::mem::take(&mut recording.condition);
    recording.condition = known.with_twin_of(&recording.provenance);
    if let Some(rendering) = &mut stored.rendering {
        let known = std::mem::take(&mut rendering.condition);
        rendering.condition = known.with_twin_of(&rendering.provenance);
        let its_own = played_through_its_own(&rendering.provenance, &recording.provenance);
        let said = its_own.filter(|doubt| !recording.doubts.contains(doubt));
        recording.doubts.extend(said);
    }
    let setup = stored.setup.or_else(|| {
        stored
            .rendering
            .as_ref()
            .and_then(|rendering| rendering.setup.clone())
    });
    Contents {
        recording: stored.recording,
        kind,
        setup,
        rendering: stored.rendering,
    }
}

fn from_wav(path: &Path, bytes: &[u8], options: &ReadOptions) -> Result<Contents, ReadError> {
    let wav = parse_wav(path, bytes)?;
    let (sidecar, of_samples) = read_with_samples(path)?.unwrap_or_default();
    let mut doubts = of_samples.doubts;
    if let Some(stated) = of_samples.samples
        && stated != fingerprint(path, bytes)?
    {
        return Err(ReadError::content(
            path,
            format!(
                "the samples that {} was written for",
                sidecar_path(path).display()
            ),
            "others: an overwrite was interrupted, or another program changed them",
            "write the file again; where the sidecar still holds of these samples, remove `samples` from it",
        ));
    }
    let count = wav.channels.len();
    if let Some(names) = of_samples.channels.filter(|names| names.len() != count) {
        return Err(ReadError::content(
            &sidecar_path(path),
            format!("{count} name(s) in `channels`, as many as the file has channels"),
            format!("{}", names.len()),
            "correct `channels`, or remove it",
        ));
    }
    if let Some(stated) = options.rate
        && stated.hz() != f64::from(wav.rate_hz)
    {
        doubts.push(Doubt::RateNotUsed {
            stated_hz: stated.hz(),
            found_hz: f64::from(wav.rate_hz),
        });
    }
    if let (Some(used), Some(ignored)) = (&options.scale, &sidecar.full_scale)
        && used != ignored
    {
        doubts.push(Doubt::ScaleOverridden {
            used: used.to_string(),
            ignored: ignored.to_string(),
        });
    }
    let (unit, factor) = unit_and_factor(options.scale.as_ref().or(sidecar.full_scale.as_ref()));
    let known = options.scale.is_some() || sidecar.full_scale.is_some();
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
            let name = sidecar.channels.get(i).cloned().unwrap_or(fallback);
            if !known {
                doubts.push(Doubt::Uncalibrated {
                    channel: name.clone(),
                });
            }
            if let Some(step) = wav.format.step_ratio() {
                doubts.extend(piezotact::spectrum::quantisation_doubt(
                    &name, &samples, step,
                ));
            }
            for sample in &mut samples {
                *sample *= factor;
            }
            Channel {
                name,
                unit: unit.clone(),
                samples,
            }
        })
        .collect();
    let rate = SampleRate::new(f64::from(wav.rate_hz)).map_err(|source| ReadError::Quantity {
        path: path.into(),
        source,
    })?;
    let provenance = if sidecar.provenance == Provenance::default() {
        Provenance {
            source: path.display().to_string(),
            ..Provenance::default()
        }
    } else {
        sidecar.provenance
    };
    let mut recording =
        Recording::new(channels, rate, sidecar.condition, provenance).map_err(|source| {
            ReadError::Recording {
                path: path.into(),
                source,
            }
        })?;
    for doubt in doubts {
        // What the sidecar says already is not said again.
        if !recording.doubts.contains(&doubt) {
            recording.doubts.push(doubt);
        }
    }
    finite(
        path,
        contents_of(
            Stored {
                recording,
                setup: None,
                rendering: sidecar.rendering,
            },
            FileKind::Wav(wav.format),
        ),
    )
}

/// Refuses a recording with a sample that is NaN or infinite, or without samples.
fn finite(path: &Path, contents: Contents) -> Result<Contents, ReadError> {
    let rate = contents.recording.rate();
    if contents.recording.is_empty() {
        return Err(ReadError::content(
            path,
            "samples",
            "none",
            "it was stopped before its first second: record again",
        ));
    }
    for channel in contents.recording.channels() {
        if let Some(at) = channel.samples.iter().position(|v| !is_sample(*v)) {
            return Err(ReadError::content(
                path,
                "samples within ±1e100",
                format!(
                    "{} at sample {at} ({:.3}) of `{}`",
                    channel.samples[at],
                    rate.duration_of(at),
                    channel.name
                ),
                "cut that part or repair the export",
            ));
        }
    }
    Ok(contents)
}
