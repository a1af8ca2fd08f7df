//! Warnings about a verification.

use std::fmt;

use crate::quantity::Band;
use crate::warning::words::{bands as list, percent};
use crate::warning::{Advice, Subject, WarningKind, warnings};

warnings! {
    /// Warnings about a verification.
    pub enum VerifyWarning {
        /// The clocks of playback and recording differ, and the measurement was compared after correcting for it.
        ClockDrift("clock_drift") {
            /// By how much, parts per million.
            ppm: f64,
        },
        /// The recording lost samples, and was compared after correcting for it.
        LostSamples("lost_samples") {
            /// How many.
            samples: f64,
            /// At how many places.
            places: usize,
        },
        /// The delay changes over time in a way that neither clock drift nor lost samples explain.
        DelayWanders("delay_wanders") {
            /// The rms of the delay about a steady one, s.
            rms_s: f64,
        },
        /// Part of the target's lines is hidden by the sensor's noise and was not compared.
        HiddenByNoise("hidden_by_noise") {
            /// Their share of the lines, 0–1.
            line_share: f64,
            /// Their share of the target's power, 0–1.
            power_share: f64,
        },
        /// The measurement equals the target.
        CopyOfTarget("copy_of_target"),
        /// A measurement is compared with another texture than the one its drive was rendered from.
        OtherTarget("other_target") {
            /// What the drive was rendered from.
            rendered: String,
            /// What it is compared with.
            compared: String,
        },
        /// The measurement follows its target with the sign reversed.
        Inverted("inverted") {
            /// The correlation, below zero.
            correlation: f64,
        },
        /// Part of the band holds almost no target power: errors in dB are meaningless there and are left out.
        NoTargetPower("no_target_power") {
            /// The share of the band's lines left out, 0–1.
            share: f64,
        },
        /// Only part of the band is judged.
        PartJudged("part_judged") {
            /// The share of the band's lines that are judged, 0–1.
            share: f64,
            /// The bands that the drive was rendered to reach.
            judged: Vec<Band>,
            /// The band that was asked for.
            band: Band,
        },
        /// The measurement holds power on lines where the target has none.
        PowerAdded("power_added") {
            /// That power over the target's.
            ratio: f64,
        },
        /// The measurement ends before the target does.
        Cut("cut") {
            /// How much of the target was compared, in s.
            compared_s: f64,
            /// How long the target is, in s.
            target_s: f64,
        },
        /// The texture was intentionally rendered at another level, and is compared at that level.
        LevelChanged("level_changed") {
            /// The level relative to the target, dB.
            level_db: f64,
        },
    }
}

impl WarningKind for VerifyWarning {
    fn of(warning: &crate::Warning) -> Option<Self> {
        Self::of_warning(warning)
    }

    fn advice(&self) -> Vec<Advice> {
        use Advice::Check;
        match self {
            Self::ClockDrift { .. } => vec![Advice::OneClock],
            Self::LostSamples { .. } => vec![Check(Subject::Recorder), Advice::RecordAgain],
            Self::DelayWanders { .. } => vec![Check(Subject::OutputClock)],
            Self::HiddenByNoise { .. } => vec![Advice::QuieterSensor],
            Self::CopyOfTarget => vec![Advice::GiveRecording],
            Self::OtherTarget { .. } => vec![Check(Subject::Belonging)],
            Self::Inverted { .. } => vec![Check(Subject::Polarity)],
            Self::NoTargetPower { .. } => vec![Advice::NarrowBand],
            Self::PartJudged { .. } | Self::LevelChanged { .. } => Vec::new(),
            Self::PowerAdded { .. } => vec![Check(Subject::OtherSources)],
            Self::Cut { .. } => vec![Advice::RecordWholePlayback, Check(Subject::Belonging)],
        }
    }
}

impl fmt::Display for VerifyWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ClockDrift { ppm } => write!(
                f,
                "the clocks of playback and recording differ by {ppm:+.1} ppm: compared after correcting for it"
            ),
            Self::LostSamples { samples, places } => write!(
                f,
                "the recording lost {samples:.0} samples at {places} place(s): compared after correcting for it"
            ),
            Self::DelayWanders { rms_s } => write!(
                f,
                "the delay of the measurement varies by {:.2} ms rms, which neither two clocks nor lost samples explain",
                rms_s * 1e3
            ),
            Self::HiddenByNoise {
                line_share,
                power_share,
            } => write!(
                f,
                "the sensor noise hides {:.0} % of the spectral lines of the target, with {:.2} % of its power: they are not \
                    compared",
                line_share * 100.0,
                power_share * 100.0
            ),
            Self::CopyOfTarget => f.write_str(
                "the measurement is proportional to the target: it is a copy and says nothing about a device",
            ),
            Self::OtherTarget { rendered, compared } => write!(
                f,
                "the drive was rendered from {rendered} and is compared with {compared}"
            ),
            Self::Inverted { correlation } => write!(
                f,
                "the measurement follows its target with the sign reversed (correlation {correlation:.3})"
            ),
            Self::NoTargetPower { share } => write!(
                f,
                "in {} of the band, the target has almost no power; this part was left out of the error",
                percent(*share)
            ),
            Self::PartJudged {
                share,
                judged,
                band,
            } => write!(
                f,
                "{} of {band} is evaluated: the drive was computed to reach only {}, and the vibration elsewhere is missing or \
                    wrong",
                percent(*share),
                list(judged)
            ),
            Self::PowerAdded { ratio } => write!(
                f,
                "where the target has no power, the measurement has {} of the power of the target: there is vibration that was \
                    not intended",
                percent(*ratio)
            ),
            Self::Cut {
                compared_s,
                target_s,
            } => write!(
                f,
                "target and measurement overlap for {compared_s:.2} s of the {target_s:.2} s of the target"
            ),
            Self::LevelChanged { level_db } => write!(
                f,
                "the texture was intentionally rendered at {level_db:+.1} dB and is compared at this level: the presented level \
                    is not the recorded one"
            ),
        }
    }
}
