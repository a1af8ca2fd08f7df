//! `.haptic` clips: envelopes of amplitude and frequency, in versions 0 and 1.
//!
//! Source of the layout: Lofelt `NiceVibrations` (MIT, Meta Platforms), `core/datamodel/src/v0.rs` and `v1.rs`.

use crate::HapticError;
use piezotact::clipping::{ClippedAt, ClippingWarning};
use piezotact::recording::RecordingWarning;

use crate::envelope::{
    AmplitudePoint, Emphasis, EnvelopeConfig, Envelopes, FrequencyPoint, analyse,
};
use piezotact::Warning;
use piezotact::quantity::{Measure, Quantity, Unit};
use piezotact::series::Series;
use serde::{Deserialize, Serialize};

use super::{Exported, json, loses};

/// The version of a clip's format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct HapticVersion {
    /// 0 or 1.
    pub major: u32,
    #[serde(default)]
    pub minor: u32,
    #[serde(default)]
    pub patch: u32,
}

impl std::fmt::Display for HapticVersion {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}.{}.{}", self.major, self.minor, self.patch)
    }
}

/// Where a clip comes from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct HapticMetadata {
    /// The program that made it.
    pub editor: String,
    /// The person who made it.
    pub author: String,
    /// What it was made from.
    pub source: String,
    /// The project it belongs to.
    pub project: String,
    pub tags: Vec<String>,
    pub description: String,
}

/// A clip as it stands in a `.haptic` file.
#[derive(Clone, Debug, PartialEq)]
pub struct HapticClip {
    /// The version that the file had.
    pub version: HapticVersion,
    /// Where it comes from.
    pub metadata: HapticMetadata,
    pub envelopes: Envelopes,
    /// What a person should know before relying on it.
    pub warnings: Vec<Warning>,
}

impl HapticClip {
    /// The version that is written.
    pub const WRITTEN: HapticVersion = HapticVersion {
        major: 1,
        minor: 0,
        patch: 0,
    };
}

#[derive(Deserialize)]
struct Versioned {
    version: Option<HapticVersion>,
}

#[derive(Serialize, Deserialize)]
struct FileV1 {
    version: HapticVersion,
    #[serde(default)]
    metadata: HapticMetadata,
    signals: Signals,
}

#[derive(Serialize, Deserialize)]
struct Signals {
    continuous: Continuous,
}

#[derive(Serialize, Deserialize)]
struct Continuous {
    envelopes: FileEnvelopes,
}

#[derive(Serialize, Deserialize)]
struct FileEnvelopes {
    amplitude: Vec<FileAmplitude>,
    #[serde(skip_serializing_if = "Option::is_none")]
    frequency: Option<Vec<FileFrequency>>,
}

#[derive(Serialize, Deserialize)]
struct FileAmplitude {
    time: f64,
    amplitude: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    emphasis: Option<Emphasis>,
}

#[derive(Serialize, Deserialize)]
struct FileFrequency {
    time: f64,
    frequency: f64,
}

#[derive(Deserialize)]
struct FileV0 {
    #[serde(default)]
    metadata: MetadataV0,
    voices: VoicesV0,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct MetadataV0 {
    editor: String,
    duration: f64,
}

#[derive(Deserialize)]
struct VoicesV0 {
    envelopes: Vec<Vec<PointV0>>,
    transients: Vec<Vec<PointV0>>,
}

#[derive(Deserialize)]
struct PointV0 {
    time: f64,
    amplitude: f64,
}

const AGAIN: &str = "export the clip again";

/// Reads a `.haptic` clip of version 0 or 1. One of version 0 becomes one of version 1: its transients become emphases
/// of the breakpoints of their time, and its envelope reaches to the stated duration.
///
/// # Errors
/// [`HapticError::Content`] when it is no clip, or of another version, a field is missing or of another type, or a
/// breakpoint breaks a rule of [`Envelopes`]; each named with its place.
pub fn parse_haptic(bytes: &[u8]) -> Result<HapticClip, HapticError> {
    let expected = "a `.haptic` clip with `signals.continuous.envelopes.amplitude`, or with `voices` in version 0";
    let stated: Versioned = json(bytes, expected, AGAIN)?;
    match stated.version {
        Some(version) if version.major == 1 => {
            let file: FileV1 = json(bytes, expected, AGAIN)?;
            let envelopes = file.signals.continuous.envelopes;
            let envelopes = Envelopes::new(
                envelopes
                    .amplitude
                    .into_iter()
                    .map(|point| AmplitudePoint {
                        time_s: point.time,
                        amplitude: point.amplitude,
                        emphasis: point.emphasis,
                    })
                    .collect(),
                envelopes
                    .frequency
                    .unwrap_or_default()
                    .into_iter()
                    .map(|point| FrequencyPoint {
                        time_s: point.time,
                        frequency: point.frequency,
                    })
                    .collect(),
            );
            Ok(HapticClip {
                version,
                metadata: file.metadata,
                envelopes: envelopes?,
                warnings: Vec::new(),
            })
        }
        Some(version) if version.major > 1 => Err(HapticError::content(
            "a `.haptic` clip of version 0 or 1",
            format!("version {version}"),
            "export it as version 1.0.0",
        )),
        older => upgraded(
            older.unwrap_or(HapticVersion {
                major: 0,
                minor: 2,
                patch: 0,
            }),
            json(bytes, expected, AGAIN)?,
        ),
    }
}

fn upgraded(version: HapticVersion, file: FileV0) -> Result<HapticClip, HapticError> {
    let wrong = |expected: &str, found: String| Err(HapticError::content(expected, found, AGAIN));
    let mut voices = file.voices.envelopes.into_iter();
    let duration_s = file.metadata.duration;
    let mut amplitude: Vec<AmplitudePoint> = voices
        .next()
        .unwrap_or_default()
        .into_iter()
        .map(|point| AmplitudePoint {
            time_s: point.time,
            amplitude: point.amplitude,
            emphasis: None,
        })
        .collect();
    let frequency: Vec<FrequencyPoint> = voices
        .next()
        .unwrap_or_default()
        .into_iter()
        .map(|point| FrequencyPoint {
            time_s: point.time,
            frequency: point.amplitude,
        })
        .collect();
    let last = amplitude.last().copied();
    let Some(last) = last else {
        return wrong("a breakpoint of amplitude", "none".into());
    };
    let latest_s = frequency
        .last()
        .map_or(last.time_s, |point| point.time_s.max(last.time_s));
    if latest_s > duration_s {
        return wrong(
            "breakpoints within the stated duration",
            format!("one at {latest_s} s in {duration_s} s"),
        );
    }
    if duration_s > last.time_s {
        amplitude.push(AmplitudePoint {
            time_s: duration_s,
            ..last
        });
    }
    let mut warnings = Vec::new();
    match file.voices.transients.as_slice() {
        [] => {}
        [levels, pitches] if levels.len() == pitches.len() => {
            let (mut placed, mut raised) = (0, 0);
            for (level, pitch) in levels.iter().zip(pitches) {
                // Both come from one number in the file.
                #[allow(clippy::float_cmp, reason = "the same number was written twice")]
                let at = |point: &&mut AmplitudePoint| {
                    point.time_s == level.time && pitch.time == level.time
                };
                if let Some(point) = amplitude.iter_mut().find(at) {
                    raised += usize::from(level.amplitude < point.amplitude);
                    placed += 1;
                    point.emphasis = Some(Emphasis {
                        amplitude: level.amplitude.max(point.amplitude),
                        frequency: pitch.amplitude,
                    });
                }
            }
            if placed < levels.len() {
                warnings.push(Warning::from(RecordingWarning::Guessed {
                    what: format!(
                        "{} of {} transients are not at a breakpoint of the amplitude and are left out",
                        levels.len() - placed,
                        levels.len()
                    ),
                }));
            }
            if raised > 0 {
                warnings.push(Warning::from(RecordingWarning::Guessed {
                    what: format!(
                        "{raised} transients are weaker than the envelope around them and were raised to it"
                    ),
                }));
            }
        }
        lists => {
            let lengths: Vec<usize> = lists.iter().map(Vec::len).collect();
            return wrong(
                "an amplitude and a frequency for every transient",
                format!("lists of {lengths:?}"),
            );
        }
    }
    let envelopes = Envelopes::new(amplitude, frequency)?;
    Ok(HapticClip {
        version,
        metadata: HapticMetadata {
            editor: file.metadata.editor,
            ..HapticMetadata::default()
        },
        envelopes,
        warnings,
    })
}

/// What stands in a `.haptic` file of version 1.0.0 with `clip`.
#[must_use]
pub fn clip_file(clip: &HapticClip) -> impl Serialize {
    let frequency: Vec<FileFrequency> = clip
        .envelopes
        .frequency()
        .iter()
        .map(|point| FileFrequency {
            time: point.time_s,
            frequency: point.frequency,
        })
        .collect();
    FileV1 {
        version: HapticClip::WRITTEN,
        metadata: clip.metadata.clone(),
        signals: Signals {
            continuous: Continuous {
                envelopes: FileEnvelopes {
                    amplitude: clip
                        .envelopes
                        .amplitude()
                        .iter()
                        .map(|point| FileAmplitude {
                            time: point.time_s,
                            amplitude: point.amplitude,
                            emphasis: point.emphasis,
                        })
                        .collect(),
                    frequency: (!frequency.is_empty()).then_some(frequency),
                },
            },
        },
    }
}

/// The clip of a texture `x`, in shares of a full scale that stands for `full_scale`, with what a clip does not carry in `format`. An
/// amplitude beyond full scale is written as 1, and said.
///
/// # Errors
/// Those of [`analyse`].
pub fn clip_of<Q: Quantity>(
    x: &Series<Q>,
    full_scale: &Measure,
    config: &EnvelopeConfig,
    metadata: HapticMetadata,
    format: &str,
) -> Result<Exported<HapticClip>, HapticError> {
    let envelopes = analyse(x, 1.0, config)?;
    let mut losses = vec![
        loses(
            format,
            format!(
                "the waveform, only its amplitude and centroid, {:.0} times per second (two textures with equal level and \
                 centroid become identical)",
                1.0 / config.hop_s
            ),
        ),
        loses(
            format,
            format!(
                "frequencies in Hz (0 and 1 correspond to {} here, and to the range of the actuator on another player)",
                config.range.band()
            ),
        ),
    ];
    let points = envelopes.amplitude();
    let full = points.iter().filter(|point| point.amplitude >= 1.0).count();
    if full > 0 {
        losses.push(Warning::from(ClippingWarning::Clipped {
            signal: "the amplitude envelope".into(),
            at: ClippedAt::Recorded {
                fraction: full as f64 / points.len() as f64,
            },
        }));
    }
    if full_scale.unit != Unit::FullScale {
        losses.push(loses(format, scale_text(full_scale)));
    }
    Ok(Exported {
        content: HapticClip {
            version: HapticClip::WRITTEN,
            metadata,
            envelopes,
            warnings: Vec::new(),
        },
        losses,
    })
}

/// The loss of a physical scale, with what brings it back.
pub(super) fn scale_text(full_scale: &Measure) -> String {
    format!(
        "a physical unit (1 corresponds to {} {}; give --scale \"{full_scale}\" when the file is read)",
        piezotact::number::rounded(full_scale.value),
        full_scale.unit
    )
}
