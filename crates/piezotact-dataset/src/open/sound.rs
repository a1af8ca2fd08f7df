//! Sound files other than WAV: FLAC is decoded, the others are known to be refused by their names.

use super::{FileKind, ReadOptions, Reader};
use crate::error::ReadError;
use crate::format::{Format, Opened, Recognition};
use crate::recording_file::Stored;

pub(super) const FLAC: Format<FileKind, Reader> = Format {
    kind: FileKind::FLAC,
    label: if cfg!(feature = "flac") { "FLAC" } else { "" },
    endings: &["flac"],
    sniff: Recognition::Head(|head| head.starts_with(b"fLaC")),
    read: from_flac,
};

pub(super) const OTHERS: Format<FileKind, Reader> = Format {
    kind: FileKind::named("sound"),
    label: "",
    endings: &["aiff", "aif", "aifc", "caf", "w64", "bw64"],
    sniff: Recognition::Head(|head| sound_name(head).is_some()),
    read: |file, _| {
        let name = sound_name(file.head()).unwrap_or("unknown");
        let found = format!("a sound file of the kind {name}");
        Err(super::none(file, &found, "convert it to WAV".into()))
    },
};

#[cfg(feature = "flac")]
fn from_flac(file: &mut Opened<'_>, options: &ReadOptions) -> Result<Stored, ReadError> {
    let path = file.path;
    let bytes = file.bytes()?;
    let flac = crate::flac::parse_flac(path, bytes)?;
    let step = 2_f64.powi(1 - flac.bits as i32);
    let usual = flac.wav.format.step_ratio() == Some(step);
    let mut stored = super::from_sound(path, bytes, flac.wav, Some(step), options)?;
    stored.samples = stored.samples.filter(|_| usual);
    Ok(stored)
}

#[cfg(not(feature = "flac"))]
fn from_flac(file: &mut Opened<'_>, _: &ReadOptions) -> Result<Stored, ReadError> {
    let todo = "convert it to WAV, or build piezotact with ./x build, which reads it";
    Err(super::none(
        file,
        "a FLAC file, which this build does not read",
        todo.into(),
    ))
}

/// What a sound file that is not read is called, by its first bytes.
fn sound_name(head: &[u8]) -> Option<&'static str> {
    match (head.get(..4)?, head.get(8..12)?) {
        (b"FORM", b"AIFF") => Some("AIFF"),
        (b"FORM", b"AIFC") => Some("AIFF-C"),
        (b"caff", _) => Some("CAF"),
        (b"riff", b"\xa5\xd6\x28\xdb") => Some("Wave64 (W64)"),
        (b"BW64", b"WAVE") => Some("BW64"),
        _ => None,
    }
}
