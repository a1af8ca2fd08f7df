//! The structure of HJIF, the interchange format of MPEG haptics, as types that refuse what they do not hold.
//!
//! Source: ISO/IEC 23090-31:2025, clause 6.2 (`MPEG_haptics` and the objects below it), read through its published
//! reference software, MPEGGroup/HapticReferenceSoftware (BSD-3), `source/IOHaptics/src/IOJson.cpp` and
//! `source/Types/include`; the names of perceptions as in draft-ietf-avtcore-rtp-haptics, section 6.2.

use crate::HapticError;
use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::{Number, Value};

use super::json;

/// What stands beside the fields that the structure names.
type Unknown = BTreeMap<String, Value>;

/// A haptic experience: the whole file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hjif {
    /// The year of the edition, and the amendment: `2025` or `2025-1`.
    pub version: String,
    /// `Main` or `Simple Parametric`.
    pub profile: String,
    /// 1 or 2.
    pub level: u32,
    /// When it was made, ISO 8601.
    pub date: String,
    pub description: String,
    /// Ticks of a second; 1000 where absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub timescale: Option<u32>,
    /// Bodies that perceptions refer to.
    pub avatars: Vec<HjifAvatar>,
    pub perceptions: Vec<HjifPerception>,
    /// Moments at which a decoder may start.
    pub syncs: Vec<HjifSync>,
    #[serde(flatten)]
    pub(super) unknown: Unknown,
}

/// A body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HjifAvatar {
    /// Its number, not 0.
    pub id: i64,
    /// The level of detail.
    pub lod: i64,
    /// `Vibration`, `Pressure`, `Temperature` or `Custom`.
    #[serde(rename = "type")]
    pub kind: String,
    /// Where its mesh is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh: Option<String>,
}

/// What is perceived, in which way, on which devices.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HjifPerception {
    pub id: i64,
    /// The body's number, 0 for none.
    pub avatar_id: i64,
    pub description: String,
    /// The way: `Vibrotactile`, `Vibrotactile Texture`, `Acceleration` …
    pub perception_modality: String,
    /// The power of ten of the unit of positions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit_exponent: Option<i64>,
    /// The power of ten of the unit of amplitudes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub perception_unit_exponent: Option<i64>,
    /// The devices it was made for.
    #[serde(default)]
    pub reference_devices: Vec<HjifReferenceDevice>,
    /// Effects that bands refer to.
    pub effect_library: Vec<HjifEffect>,
    /// What the keywords of effects are taken from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effect_semantic_scheme: Option<String>,
    pub channels: Vec<HjifChannel>,
    #[serde(flatten)]
    pub(super) unknown: Unknown,
}

/// A device that a perception was made for. Frequencies in Hz, potential in V, the rest in SI.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HjifReferenceDevice {
    pub id: i64,
    pub name: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body_part_mask: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub maximum_frequency: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub minimum_frequency: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub resonance_frequency: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub maximum_amplitude: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub impedance: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub maximum_voltage: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub maximum_current: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub maximum_displacement: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weight: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub custom: Option<f64>,
    /// `LRA`, `VCA`, `ERM`, `Piezo` or `Unknown`.
    #[serde(rename = "type", skip_serializing_if = "Option::is_none")]
    pub kind: Option<String>,
}

/// One channel of a perception: the sum of its bands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HjifChannel {
    pub id: i64,
    pub description: String,
    /// What it is multiplied by.
    pub gain: f64,
    /// How strong it is among others on one actuator.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mixing_coefficient: Option<f64>,
    /// The same under the name that drafts of the standard used.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mixing_weight: Option<f64>,
    /// Where on the body, one bit a part.
    pub body_part_mask: u32,
    /// The device it was made for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference_device_id: Option<i64>,
    /// The rate of the signal it was made from, Hz.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frequency_sampling: Option<u32>,
    /// The samples of the signal it was made from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sample_count: Option<u32>,
    /// The direction of what is felt.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub direction: Option<Value>,
    /// How many actuators there are each way.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub actuator_resolution: Option<Value>,
    /// Parts of the body by name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body_part_target: Option<Vec<String>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub actuator_target: Option<Vec<Value>>,
    /// Points of the body's mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vertices: Option<Vec<i64>>,
    /// What it is the sum of.
    pub bands: Vec<HjifBand>,
    #[serde(flatten)]
    pub(super) unknown: Unknown,
}

/// What a band's effects are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum HjifBandType {
    /// Taps.
    Transient,
    /// The signal itself, as a curve through keyframes.
    Curve,
    /// Oscillations that keyframes modulate.
    VectorialWave,
    /// Blocks of wavelet coefficients.
    WaveletWave,
}

/// How a curve runs between keyframes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the standard's names say it")]
pub enum HjifCurveType {
    Unknown,
    Cubic,
    Linear,
    Akima,
    Bezier,
    #[serde(alias = "Bspline")]
    BSpline,
}

/// A band of frequencies.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HjifBand {
    /// What its effects are.
    pub band_type: HjifBandType,
    /// How curves run; for curves only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub curve_type: Option<HjifCurveType>,
    /// The length of a block of wavelets, in ticks; for wavelets only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub block_length: Option<Number>,
    /// Where it begins, Hz.
    pub lower_frequency_limit: u32,
    /// Where it ends, Hz; for wavelets the rate of their samples.
    pub upper_frequency_limit: u32,
    pub effects: Vec<HjifEffect>,
    #[serde(flatten)]
    pub(super) unknown: Unknown,
}

/// What an effect is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum HjifEffectType {
    /// It has keyframes.
    Basis,
    /// It is one of the library.
    Reference,
    /// It is made of others.
    #[serde(alias = "Timeline")]
    Composite,
}

/// The shape of a period.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the standard's names say it")]
pub enum HjifBaseSignal {
    #[default]
    Sine,
    Square,
    Triangle,
    SawToothUp,
    SawToothDown,
}

/// Something that a band plays.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HjifEffect {
    pub effect_type: HjifEffectType,
    /// Its number in the library.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub id: Option<i64>,
    /// When it starts, in ticks.
    pub position: i64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub semantic_keywords: Option<String>,
    /// Where in its period it starts, rad.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phase: Option<f64>,
    /// The shape of a period.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub base_signal: Option<HjifBaseSignal>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub keyframes: Option<Vec<HjifKeyframe>>,
    #[serde(flatten)]
    pub(super) unknown: Unknown,
}

/// One moment of an effect. Amplitudes are single precision, as in the reference software.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HjifKeyframe {
    /// When, in ticks from the start of the effect.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub relative_position: Option<i64>,
    /// How strong, −1 to 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub amplitude_modulation: Option<f32>,
    /// At which frequency, Hz.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frequency_modulation: Option<i64>,
}

/// A moment at which a decoder may start.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HjifSync {
    /// When, in ticks.
    pub timestamp: i64,
    /// Ticks of a second.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub timescale: Option<u32>,
}

/// Reads HJIF. What a file has beside the published structure, and where it departs from it without being unreadable, is
/// kept: [`Hjif::departures`] lists it.
///
/// # Errors
/// [`HapticError::Content`] when a field that is needed is missing, or of another type, or names what the structure does
/// not know.
pub fn parse_hjif(bytes: &[u8]) -> Result<Hjif, HapticError> {
    json(
        bytes,
        "MPEG haptics JSON (HJIF, ISO/IEC 23090-31) with `perceptions`, their `channels`, `bands` and `effects`",
        "export it again as HJIF of the 2025 edition",
    )
}
