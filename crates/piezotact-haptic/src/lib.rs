//! Files for consumer haptic devices: `.haptic` clips, Apple's AHAP, and the interchange format of MPEG, HJIF, from bytes to values
//! and back; and the envelopes that they hold instead of a waveform. Nothing here touches a file.
//!
//! None of them holds a waveform in m/s², as a texture is here. Whatever a format cannot represent is returned as
//! [`RecordingWarning::FormatLoses`], so that nobody takes such a file for a complete copy.

mod ahap;
mod clip;
pub mod envelope;
mod hjif;
mod hjif_check;
mod hjif_write;
mod target;

use piezotact::Warning;
use piezotact::number::rounded;
use piezotact::quantity::QuantityError;
use piezotact::recording::{RecordingError, RecordingWarning};
use piezotact::series::SeriesError;

pub use ahap::{
    Ahap, AhapControlPoint, AhapCurve, AhapDynamic, AhapEvent, AhapEventType, AhapMetadata,
    AhapParameter, AhapParameterId, AhapPattern, ahap_of, parse_ahap,
};
pub use clip::{HapticClip, HapticMetadata, HapticVersion, clip_file, clip_of, parse_haptic};
pub use hjif::{
    Hjif, HjifAvatar, HjifBand, HjifBandType, HjifBaseSignal, HjifChannel, HjifCurveType,
    HjifEffect, HjifEffectType, HjifKeyframe, HjifPerception, HjifReferenceDevice, HjifSync,
    parse_hjif,
};
pub use hjif_write::{HjifTexture, date_of, hjif_of, reference_device};
pub use target::{Asked, recording_of_clip, recording_of_hjif};

/// What a format holds, what was found instead, and what to do.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("expected {expected}, found {found}; {todo}")]
pub struct Mismatch {
    /// What the format holds.
    pub expected: String,
    /// What was found.
    pub found: String,
    /// What to do.
    pub todo: String,
}

impl Mismatch {
    fn new(expected: impl Into<String>, found: impl Into<String>, todo: impl Into<String>) -> Self {
        Self {
            expected: expected.into(),
            found: found.into(),
            todo: todo.into(),
        }
    }
}

/// What to do with a file that cannot be played.
const AGAIN: &str = "export the file again";

/// Why bytes cannot be read as a haptic file, or a file or signal not be played or exported.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum HapticError {
    /// The content is not what is needed.
    #[error(transparent)]
    Content(#[from] Mismatch),
    /// An invalid rate or band.
    #[error(transparent)]
    Quantity(#[from] QuantityError),
    /// The channels make no recording.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// No breakpoint of amplitude.
    #[error("the clip has no breakpoint of amplitude: export it again")]
    Empty,
    /// A breakpoint that breaks a rule.
    #[error(
        "expected {expected}, found {found} in breakpoint {at} of the {envelope} envelope; correct it or export the clip again",
        found = rounded(*found)
    )]
    Point {
        envelope: &'static str,
        /// Which breakpoint, from 0.
        at: usize,
        expected: String,
        found: f64,
    },
    /// A signal without length.
    #[error("the clip lasts {found}: a duration above 0 s is needed")]
    NoLength { found: String },
    /// More samples than are made.
    #[error(
        "expected at most {MOST_SAMPLES} samples in all, found {found}; give a lower rate, or a shorter file",
        MOST_SAMPLES = envelope::MOST_SAMPLES
    )]
    TooMany { found: String },
    /// A full scale that is no number above zero.
    #[error(
        "expected a full scale above zero, found {found}; the signal is silent or the scale is wrong",
        found = rounded(*found)
    )]
    FullScale { found: f64 },
    /// Samples that make no series.
    #[error(transparent)]
    Series(#[from] SeriesError),
}

impl HapticError {
    fn content(
        expected: impl Into<String>,
        found: impl Into<String>,
        todo: impl Into<String>,
    ) -> Self {
        Self::Content(Mismatch::new(expected, found, todo))
    }
}

/// The result of an export, and the information that the format could not represent.
#[derive(Clone, Debug, PartialEq)]
pub struct Exported<T> {
    /// The content of the file.
    pub content: T,
    /// The warnings about information that was lost.
    pub losses: Vec<Warning>,
}

/// The loss of `what` by `format`.
fn loses(format: &str, what: impl Into<String>) -> Warning {
    Warning::from(RecordingWarning::FormatLoses {
        format: format.into(),
        what: what.into(),
    })
}

/// The bytes without the mark that some editors put before UTF-8.
fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes)
}

/// Reads JSON as `T`; what is missing or of another type is named with its place.
fn json<T: serde::de::DeserializeOwned>(
    bytes: &[u8],
    expected: &str,
    todo: &str,
) -> Result<T, HapticError> {
    serde_json::from_slice(without_mark(bytes))
        .map_err(|error| HapticError::content(expected, error.to_string(), todo))
}
