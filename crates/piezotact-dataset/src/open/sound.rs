//! Sound files other than WAV: FLAC is decoded, the others are known to be refused by their names.

use super::ReadOptions;
use crate::error::ReadError;
use crate::format::Opened;
use crate::recording_file::Stored;

#[cfg(feature = "flac")]
pub(super) fn from_flac(file: &mut Opened<'_>, options: &ReadOptions) -> Result<Stored, ReadError> {
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
pub(super) fn from_flac(file: &mut Opened<'_>, _: &ReadOptions) -> Result<Stored, ReadError> {
    let todo = "convert it to WAV, or build piezotact with ./x build, which reads it";
    Err(super::none(
        file,
        "a FLAC file, which this build does not read",
        todo.into(),
    ))
}

/// What a sound file that is not read is called, by its first bytes.
pub(super) fn sound_name(head: &[u8]) -> Option<&'static str> {
    match (head.get(..4)?, head.get(8..12)?) {
        (b"FORM", b"AIFF") => Some("AIFF"),
        (b"FORM", b"AIFC") => Some("AIFF-C"),
        (b"caff", _) => Some("CAF"),
        (b"riff", b"\xa5\xd6\x28\xdb") => Some("Wave64 (W64)"),
        (b"BW64", b"WAVE") => Some("BW64"),
        _ => None,
    }
}
