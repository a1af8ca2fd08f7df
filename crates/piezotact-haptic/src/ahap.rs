//! Apple Haptic and Audio Patterns: events and parameter curves.
//!
//! Source of the structure: Apple, *Representing haptic patterns in AHAP files*; of the times in a curve: Apple,
//! `CHHapticParameterCurve.ControlPoint`; of the conversion: Lofelt `NiceVibrations` (MIT, Meta Platforms),
//! `core/datamodel/src/ios/v1.rs`.

use crate::HapticError;
use crate::envelope::{
    AmplitudePoint, FrequencyPoint, continuous_intensity, sharpness_control, transient_intensity,
};
use serde::{Deserialize, Serialize};

use super::{Exported, HapticClip, json, loses};

/// The control points that one curve holds at most.
const POINTS_A_CURVE: usize = 16;
/// The longest continuous event, s.
const LONGEST_EVENT_S: f64 = 30.0;

/// A pattern as it stands in an AHAP file. Numbers are single precision, as Core Haptics keeps them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "PascalCase", deny_unknown_fields)]
pub struct Ahap {
    /// The version of the format, 1.
    pub version: f32,
    /// Where it comes from.
    #[serde(default)]
    pub metadata: AhapMetadata,
    pub pattern: Vec<AhapPattern>,
}

/// Where a pattern comes from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "PascalCase", default)]
pub struct AhapMetadata {
    pub project: String,
    /// When or by whom.
    pub created: String,
    pub description: String,
}

/// One entry of a pattern.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum AhapPattern {
    /// Something that is played.
    Event(AhapEvent),
    /// A parameter that changes at once.
    Parameter(AhapDynamic),
    /// A parameter that changes along a curve.
    ParameterCurve(AhapCurve),
}

/// Something that is played.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "PascalCase", deny_unknown_fields)]
pub struct AhapEvent {
    pub event_type: AhapEventType,
    /// When, s.
    pub time: f32,
    /// How long, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub event_duration: Option<f32>,
    /// The sound it plays.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub event_waveform_path: Option<String>,
    /// Whether its sound fades in and out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub event_waveform_use_volume_envelope: Option<bool>,
    /// Whether its sound is repeated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub event_waveform_loop_enabled: Option<bool>,
    #[serde(default)]
    pub event_parameters: Vec<AhapParameter>,
}

/// What an event is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "Apple's names say it")]
pub enum AhapEventType {
    HapticContinuous,
    HapticTransient,
    AudioContinuous,
    AudioCustom,
}

/// A parameter of an event.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "PascalCase", deny_unknown_fields)]
pub struct AhapParameter {
    #[serde(rename = "ParameterID")]
    pub parameter_id: AhapParameterId,
    pub parameter_value: f32,
}

/// A parameter that changes at once.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "PascalCase", deny_unknown_fields)]
pub struct AhapDynamic {
    #[serde(rename = "ParameterID")]
    pub parameter_id: AhapParameterId,
    /// When, s.
    pub time: f32,
    pub parameter_value: f32,
}

/// Which parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "Apple's names say it")]
pub enum AhapParameterId {
    HapticIntensity,
    HapticSharpness,
    AttackTime,
    DecayTime,
    ReleaseTime,
    Sustained,
    AudioVolume,
    AudioPan,
    AudioPitch,
    AudioBrightness,
    HapticIntensityControl,
    HapticSharpnessControl,
    HapticAttackTimeControl,
    HapticDecayTimeControl,
    HapticReleaseTimeControl,
    AudioVolumeControl,
    AudioPanControl,
    AudioPitchControl,
    AudioBrightnessControl,
    AudioAttackTimeControl,
    AudioDecayTimeControl,
    AudioReleaseTimeControl,
}

/// A parameter that changes along a curve of straight lines.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "PascalCase", deny_unknown_fields)]
pub struct AhapCurve {
    #[serde(rename = "ParameterID")]
    pub parameter_id: AhapParameterId,
    /// When the curve begins, s after the pattern.
    pub time: f32,
    pub parameter_curve_control_points: Vec<AhapControlPoint>,
}

/// A point of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "PascalCase", deny_unknown_fields)]
pub struct AhapControlPoint {
    /// When, s after its curve begins.
    pub time: f32,
    pub parameter_value: f32,
}

/// Reads an AHAP file strictly: what its structure does not name is refused.
///
/// # Errors
/// [`HapticError::Content`] when a field is missing, unknown or of another type, each named with its place.
pub fn parse_ahap(bytes: &[u8]) -> Result<Ahap, HapticError> {
    json(
        bytes,
        "an AHAP file with `Version` and a `Pattern` of `Event`, `Parameter` and `ParameterCurve`",
        "correct that field",
    )
}

/// The AHAP pattern of `clip`, with what it does not carry: curves of intensity and sharpness in pieces of 16 control
/// points, the last of one being the first of the next, with times from their own beginning; continuous events of at most 30 s; a transient for every
/// emphasis but that of the first breakpoint, whose continuous intensity gives way.
#[must_use]
pub fn ahap_of(clip: &HapticClip) -> Exported<Ahap> {
    let amplitude: Vec<[f64; 2]> = clip
        .envelopes
        .amplitude()
        .iter()
        .map(|point: &AmplitudePoint| [point.time_s, continuous_intensity(point)])
        .collect();
    let frequency: Vec<[f64; 2]> = clip
        .envelopes
        .frequency()
        .iter()
        .map(|point: &FrequencyPoint| [point.time_s, sharpness_control(point)])
        .collect();
    let mut pattern = curves(AhapParameterId::HapticIntensityControl, &amplitude);
    pattern.extend(curves(AhapParameterId::HapticSharpnessControl, &frequency));
    let duration_s = clip.envelopes.duration().0;
    let mut start_s = 0.0;
    while start_s < duration_s {
        pattern.push(AhapPattern::Event(AhapEvent {
            event_type: AhapEventType::HapticContinuous,
            time: start_s as f32,
            event_duration: Some((duration_s - start_s).min(LONGEST_EVENT_S) as f32),
            event_waveform_path: None,
            event_waveform_use_volume_envelope: None,
            event_waveform_loop_enabled: None,
            event_parameters: felt(1.0, 0.0),
        }));
        start_s += LONGEST_EVENT_S;
    }
    let emphasised = clip.envelopes.amplitude().iter().skip(1);
    pattern.extend(emphasised.filter_map(|point| {
        let emphasis = point.emphasis.as_ref()?;
        Some(AhapPattern::Event(AhapEvent {
            event_type: AhapEventType::HapticTransient,
            time: point.time_s as f32,
            event_duration: None,
            event_waveform_path: None,
            event_waveform_use_volume_envelope: None,
            event_waveform_loop_enabled: None,
            event_parameters: felt(transient_intensity(emphasis), emphasis.frequency),
        }))
    }));
    let mut losses = vec![loses(
        "AHAP",
        "an amplitude or a frequency in a physical unit (the effect of intensity and sharpness depends on the iPhone)",
    )];
    let first = clip.envelopes.amplitude().first();
    if first.is_some_and(|point| point.emphasis.is_some()) {
        losses.push(loses(
            "AHAP",
            "the emphasis of the first breakpoint, which the usual conversion omits",
        ));
    }
    if frequency.is_empty() {
        losses.push(loses(
            "AHAP",
            "a clip without frequencies, whose sharpness is chosen by the player (0, the lowest, is written instead)",
        ));
    }
    if first.is_some_and(|point| point.time_s > 0.0) && amplitude.len() > 1 {
        losses.push(loses(
            "AHAP",
            "the amplitude before the first breakpoint (full intensity is written instead, as in the usual conversion)",
        ));
    }
    let metadata = &clip.metadata;
    if [&metadata.editor, &metadata.source]
        .iter()
        .any(|text| !text.is_empty())
        || !metadata.tags.is_empty()
    {
        losses.push(loses(
            "AHAP",
            "the editor, the source and the tags of a clip",
        ));
    }
    Exported {
        content: Ahap {
            version: 1.0,
            metadata: AhapMetadata {
                project: metadata.project.clone(),
                created: metadata.author.clone(),
                description: metadata.description.clone(),
            },
            pattern,
        },
        losses,
    }
}

fn felt(intensity: f64, sharpness: f64) -> Vec<AhapParameter> {
    [
        (AhapParameterId::HapticIntensity, intensity),
        (AhapParameterId::HapticSharpness, sharpness),
    ]
    .into_iter()
    .map(|(parameter_id, value)| AhapParameter {
        parameter_id,
        parameter_value: value as f32,
    })
    .collect()
}

/// Pieces of at most 16 points (a time in s and a value) that share their ends; the value itself where there is one point.
fn curves(parameter_id: AhapParameterId, points: &[[f64; 2]]) -> Vec<AhapPattern> {
    let starts = (0..points.len().saturating_sub(1)).step_by(POINTS_A_CURVE - 1);
    let held = points.first().filter(|_| points.len() == 1).map(|first| {
        AhapPattern::Parameter(AhapDynamic {
            parameter_id,
            time: 0.0,
            parameter_value: first[1] as f32,
        })
    });
    held.into_iter()
        .chain(starts.map(|start| {
            let piece = &points[start..points.len().min(start + POINTS_A_CURVE)];
            let begins_s = piece[0][0];
            let control = |[time_s, value]: &[f64; 2]| AhapControlPoint {
                time: (time_s - begins_s) as f32,
                parameter_value: *value as f32,
            };
            AhapPattern::ParameterCurve(AhapCurve {
                parameter_id,
                time: begins_s as f32,
                parameter_curve_control_points: piece.iter().map(control).collect(),
            })
        }))
        .collect()
}
