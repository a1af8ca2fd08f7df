//! Haptic files read and written: the formats are those of `piezotact-haptic`.

use std::path::Path;

use piezotact::quantity::Quantity;
use piezotact::recording::Recording;
use piezotact::series::Series;
use piezotact_haptic::{Ahap, Asked, Exported, HapticClip, Hjif, HjifTexture, clip_file, hjif_of};

use crate::error::{ReadError, WriteError};
use crate::open::ReadOptions;
use crate::sidecar::{prepare_compact_json, write_json};

/// Reads a `.haptic` clip of version 0 or 1 in `bytes`; `path` is only named in errors.
///
/// # Errors
/// Those of [`piezotact_haptic::parse_haptic`], with the name of the file.
pub fn parse_haptic(path: &Path, bytes: &[u8]) -> Result<HapticClip, ReadError> {
    piezotact_haptic::parse_haptic(bytes).map_err(ReadError::of(path))
}

/// Reads an AHAP file strictly; `path` is only named in errors.
///
/// # Errors
/// Those of [`piezotact_haptic::parse_ahap`], with the name of the file.
pub fn parse_ahap(path: &Path, bytes: &[u8]) -> Result<Ahap, ReadError> {
    piezotact_haptic::parse_ahap(bytes).map_err(ReadError::of(path))
}

/// Reads HJIF; `path` is only named in errors.
///
/// # Errors
/// Those of [`piezotact_haptic::parse_hjif`], with the name of the file.
pub fn parse_hjif(path: &Path, bytes: &[u8]) -> Result<Hjif, ReadError> {
    piezotact_haptic::parse_hjif(bytes).map_err(ReadError::of(path))
}

/// Reads a `.haptic` clip.
///
/// # Errors
/// [`ReadError::Io`] when the file cannot be read; those of [`parse_haptic`].
pub fn read_haptic(path: &Path) -> Result<HapticClip, ReadError> {
    let bytes = crate::input::read_input(path)?;
    parse_haptic(path, &bytes)
}

/// A clip as a recording of one channel, at the rate of the options or 8 kHz.
pub(crate) fn recording_of_clip(
    path: &Path,
    clip: HapticClip,
    options: &ReadOptions,
) -> Result<Recording, ReadError> {
    let source = path.display().to_string();
    piezotact_haptic::recording_of_clip(clip, &asked(&source, options)).map_err(ReadError::of(path))
}

/// The channels of an HJIF file as those of a recording, at the rate of the options, that of the file, or 8 kHz.
pub(crate) fn recording_of_hjif(
    path: &Path,
    file: &Hjif,
    options: &ReadOptions,
) -> Result<Recording, ReadError> {
    let source = path.display().to_string();
    piezotact_haptic::recording_of_hjif(file, &asked(&source, options)).map_err(ReadError::of(path))
}

fn asked<'a>(source: &'a str, options: &'a ReadOptions) -> Asked<'a> {
    Asked {
        source,
        scale: options.scale.as_ref(),
        rate: options.rate,
        is_drive: options.is_drive,
    }
}

/// Writes a pattern as an AHAP file, whole or not at all.
///
/// # Errors
/// [`WriteError`] when it cannot be written.
pub fn write_ahap(path: &Path, pattern: &Ahap) -> Result<(), WriteError> {
    write_json(path, pattern)
}

/// Writes `clip` as a `.haptic` file of version 1.0.0, whole or not at all.
///
/// # Errors
/// [`WriteError`] when it cannot be written.
pub fn write_haptic(path: &Path, clip: &HapticClip) -> Result<(), WriteError> {
    write_json(path, &clip_file(clip))
}

/// Writes `x`, in shares of full scale, as HJIF for the device of `texture`, whole or not at all, and says what it does
/// not carry.
///
/// # Errors
/// [`WriteError::Content`] for what [`hjif_of`] refuses; [`WriteError::Io`] when it cannot be written.
pub fn write_hjif<Q: Quantity>(
    path: &Path,
    x: &Series<Q>,
    texture: &HjifTexture,
) -> Result<Exported<Hjif>, WriteError> {
    let exported = hjif_of(x, texture)
        .map_err(|wrong| WriteError::content(path, wrong.expected, wrong.found, wrong.todo))?;
    prepare_compact_json(path, &exported.content)?.commit()?;
    Ok(exported)
}
