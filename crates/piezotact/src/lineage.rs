//! The lineage of a texture: its source and all operations on it, in order; stored in its file.

use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize};

use crate::quantity::{Band, Measure};

/// The source of a texture and all operations on it, oldest first.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct Lineage {
    /// What it began with: a recording or a sample, as a person would name it.
    pub source: String,
    /// The sample that was touched, where the source states it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sample: Option<String>,
    /// What was done, oldest first.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub steps: Vec<Step>,
}

/// One operation on a texture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Step {
    /// What, with its parameters.
    pub operation: Operation,
    /// The level before, rms about the mean.
    pub rms_before: Measure,
    /// The level after, rms about the mean.
    pub rms_after: Measure,
}

/// An operation on a texture, with its parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "name", rename_all = "snake_case")]
pub enum Operation {
    /// One stroke of a recording.
    Stroke {
        /// Which, from 1.
        number: usize,
        /// From when, s.
        from_s: f64,
        /// Until when, s.
        to_s: f64,
        /// The cut-off of the high-pass that removed the gesture before, Hz.
        high_pass_hz: f64,
    },
    /// The mean was taken away.
    MeanTakenAway {
        /// The mean, in the unit of the texture.
        mean: f64,
    },
    /// Another level.
    Gain {
        /// By how much, dB.
        gain_db: f64,
    },
    /// The level of another texture.
    RmsOf {
        /// The other texture.
        of: Lineage,
        /// The level that was taken, rms about the mean.
        rms: f64,
        /// Where it was measured, in both.
        measured: Level,
        /// The gain that it took, dB.
        gain_db: f64,
    },
    /// A band raised, lowered or removed.
    BandChanged {
        /// The band.
        band_hz: Band,
        /// How.
        change: BandChange,
        /// The width of the edges outside the band, as a ratio of its ends.
        edge_ratio: f64,
    },
    /// A slope over frequency.
    Tilted {
        /// The slope, dB an octave.
        db_per_octave: f64,
        /// Where nothing changes, Hz.
        pivot_hz: f64,
        /// Below this the gain stays what it is here, Hz.
        held_below_hz: f64,
    },
    /// Every frequency moved by as many Hz.
    Shifted {
        /// By how much, Hz.
        by_hz: f64,
    },
    /// Every frequency multiplied, as by another sliding speed.
    Warped {
        /// By how much.
        ratio: f64,
        /// Whether the length is kept.
        length: WarpedLength,
    },
    /// The spectrum of another texture at the level of this one.
    SpectrumOf {
        /// The other texture.
        of: Lineage,
        /// The lines of its PSD are as far apart, Hz.
        resolution_hz: f64,
        /// The segments in its PSD.
        averages: usize,
    },
    /// Other phases.
    PhasesRandomised {
        /// Where they were drawn from: generator and seed.
        drawn_by: String,
    },
    /// Another length.
    Looped {
        /// The length, s.
        duration_s: f64,
        /// How it was joined; absent where it was cut short.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        join: Option<Join>,
    },
    /// An operation that its name and its numbers say.
    Named {
        /// What was done, in words.
        operation: String,
        /// Its parameters, by names that end in their units.
        #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
        parameters: BTreeMap<String, f64>,
    },
    /// Rendered as the drive of a device.
    Rendered {
        /// Where the transfer function came from.
        transfer: String,
        /// The name of the amplifier's gain, as its description has it; absent when the transfer function did not say.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        gain: Option<String>,
        /// The level it was rendered at, dB.
        level_db: f64,
        /// The band that was rendered.
        band_hz: Band,
        /// The aim of the closed loop that corrected it; none for an open loop.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        aim: Option<Mode>,
    },
}

/// The aim of a rendering, and so what a verification judges: the waveform or the spectrum.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// The waveform.
    Replicate,
    /// The power spectrum.
    Texture,
}

impl Mode {
    /// The aim as text.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::Replicate => "to replicate the waveform",
            Self::Texture => "to match the spectrum of the texture, with free phases",
        }
    }

    /// The name as it is written on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Replicate => "replicate",
            Self::Texture => "texture",
        }
    }
}

/// Where a level is measured.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "over", content = "band_hz", rename_all = "snake_case")]
pub enum Level {
    /// Over all frequencies.
    Whole,
    /// Over the lines of a band.
    Within(Band),
}

/// What is done to a band.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "how", rename_all = "snake_case")]
pub enum BandChange {
    /// Raised or lowered.
    Gain {
        /// By how much, dB.
        gain_db: f64,
    },
    /// Removed.
    Removed,
}

/// The length of a warped texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum WarpedLength {
    /// It is divided by the ratio: the same surface in less time.
    Follows,
    /// It is kept: more of the surface, by joining the texture with itself, or less of it.
    Kept,
}

/// How a texture was joined with itself, and how the join compares with the rest of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Join {
    /// How often.
    pub joins: usize,
    /// The texture comes again after this, s.
    pub period_s: f64,
    /// How long one end is faded into the other, s.
    pub crossfade_s: f64,
    /// How alike the two ends are there, −1 to 1.
    pub correlation: f64,
    /// The largest step between two samples at the join, relative to the largest of the texture itself.
    pub step_ratio: f64,
    /// The strongest short-time spectrum at the join relative to the strongest of the texture itself, each line
    /// weighed by its mean over the texture, dB.
    pub spectrum_db: f64,
}

impl Lineage {
    /// The lineage of `source` without any operation.
    #[must_use]
    pub fn of(source: impl Into<String>) -> Self {
        Self {
            source: source.into(),
            ..Self::default()
        }
    }

    /// The lineage of a texture of `sample`, where it is stated, in the file called `source`, without any operation.
    #[must_use]
    pub fn of_sample(source: impl Into<String>, sample: Option<String>) -> Self {
        Self {
            sample,
            ..Self::of(source)
        }
    }

    /// The same lineage with one more step at its end.
    #[must_use]
    pub fn then(mut self, step: Step) -> Self {
        self.steps.push(step);
        self
    }

    /// Whether more was done than to cut a stroke, to subtract the mean and to render.
    #[must_use]
    pub fn is_manipulated(&self) -> bool {
        let is_plain = |step: &Step| {
            matches!(
                step.operation,
                Operation::Stroke { .. }
                    | Operation::MeanTakenAway { .. }
                    | Operation::Rendered { .. }
            )
        };
        !self.steps.iter().all(is_plain)
    }

    /// The level that its steps set: the texture whose rms level it was given last, none where it is its own, and the sum of the gains
    /// after that, in dB. The level of a rendering is not among them.
    ///
    /// ```
    /// use piezotact::lineage::Lineage;
    /// assert_eq!(Lineage::of("S2").level(), (None, 0.0));
    /// ```
    #[must_use]
    pub fn level(&self) -> (Option<&Self>, f64) {
        let steps = self.steps.iter();
        steps.fold((None, 0.0), |(of, sum_db), step| match &step.operation {
            Operation::Gain { gain_db } => (of, sum_db + gain_db),
            Operation::RmsOf { of, .. } => (Some(of), 0.0),
            _ => (of, sum_db),
        })
    }
}

impl Operation {
    /// What was done, with the name of another texture instead of its lineage.
    #[must_use]
    pub fn brief_text(&self) -> String {
        let named = |of: &Lineage| Lineage::of(of.source.clone());
        let mut brief = self.clone();
        if let Self::RmsOf { of, .. } | Self::SpectrumOf { of, .. } = &mut brief {
            *of = named(of);
        }
        brief.to_string()
    }
}

impl Step {
    /// A step: `operation` changed the level of a texture from `before` to `after`, both rms about the mean.
    #[must_use]
    pub fn between(operation: Operation, before: Measure, after: Measure) -> Self {
        Self {
            operation,
            rms_before: before,
            rms_after: after,
        }
    }
}

impl fmt::Display for Lineage {
    /// The source and its steps in one line.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.source)?;
        for (i, step) in self.steps.iter().enumerate() {
            let before = if i == 0 { " (" } else { ", " };
            write!(f, "{before}{}", step.operation)?;
        }
        f.write_str(if self.steps.is_empty() { "" } else { ")" })
    }
}

impl fmt::Display for Step {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}: {} {} rms → {} {} rms",
            self.operation,
            four(self.rms_before.value),
            self.rms_before.unit,
            four(self.rms_after.value),
            self.rms_after.unit
        )
    }
}

/// A level with four decimals, or with four digits where these would say nothing.
fn four(value: f64) -> String {
    if value == 0.0 || (1e-3..1e6).contains(&value.abs()) {
        format!("{value:.4}")
    } else {
        format!("{value:.3e}")
    }
}

impl fmt::Display for Operation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stroke {
                number,
                from_s,
                to_s,
                high_pass_hz,
            } => write!(
                f,
                "stroke {number}, {from_s:.3}–{to_s:.3} s, gesture below {high_pass_hz} Hz filtered out"
            ),
            Self::MeanTakenAway { mean } => write!(f, "mean of {} subtracted", four(*mean)),
            Self::Gain { gain_db } => write!(f, "gain {gain_db:+.3} dB"),
            Self::RmsOf {
                of,
                measured,
                gain_db,
                ..
            } => {
                write!(f, "rms of {of}")?;
                if let Level::Within(band) = measured {
                    write!(f, " within {band}")?;
                }
                write!(f, ", gain {gain_db:+.3} dB")
            }
            Self::BandChanged {
                band_hz, change, ..
            } => match change {
                BandChange::Gain { gain_db } => write!(f, "{band_hz} {gain_db:+} dB"),
                BandChange::Removed => write!(f, "{band_hz} removed"),
            },
            Self::Tilted {
                db_per_octave,
                pivot_hz,
                held_below_hz,
            } => write!(
                f,
                "tilt {db_per_octave:+} dB/octave about {pivot_hz} Hz, constant gain below {held_below_hz} Hz"
            ),
            Self::Shifted { by_hz } => write!(f, "shift {by_hz:+} Hz"),
            Self::Warped { ratio, length } => {
                let kept = match length {
                    WarpedLength::Follows => "",
                    WarpedLength::Kept => ", duration kept",
                };
                write!(f, "warp × {ratio}{kept}")
            }
            Self::SpectrumOf {
                of, resolution_hz, ..
            } => write!(f, "spectrum of {of} in steps of {resolution_hz:.2} Hz"),
            Self::PhasesRandomised { drawn_by } => write!(f, "phases randomised with {drawn_by}"),
            Self::Looped {
                duration_s,
                join: None,
            } => write!(f, "cut to {duration_s:.3} s"),
            Self::Looped {
                duration_s,
                join: Some(join),
            } => write!(
                f,
                "looped to {duration_s:.3} s every {:.3} s, crossfade {:.3} s (correlation {:.2})",
                join.period_s, join.crossfade_s, join.correlation
            ),
            Self::Named {
                operation,
                parameters,
            } => {
                f.write_str(operation)?;
                for (name, value) in parameters {
                    write!(f, ", {name} {value}")?;
                }
                Ok(())
            }
            Self::Rendered {
                transfer,
                gain,
                level_db,
                band_hz,
                aim,
            } => {
                write!(f, "rendered over {band_hz} with {transfer}")?;
                if let Some(gain) = gain {
                    write!(f, ", amplifier gain {gain}")?;
                }
                write!(f, ", level {level_db:+.1} dB")?;
                match aim {
                    Some(aim) => write!(f, ", corrected in a closed loop {}", aim.text()),
                    None => Ok(()),
                }
            }
        }
    }
}
