//! The verdict of a verification, and the criteria from which it follows.

use crate::number::{plus, signed};
use std::fmt;

use serde::{Deserialize, Serialize};

use super::Verification;
use crate::criterion::{Criterion, Limit, Outcome};
use crate::lineage::Mode;
use crate::quantity::{Decibels, Seconds};

/// The verdict of a verification.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "is", rename_all = "snake_case")]
pub enum Verdict {
    /// Every criterion is met, over all of the target.
    Passed,
    /// Every criterion is met over the part that could be judged, which is not all of the target.
    PassedInPart {
        /// The share of the target's power in the band that was judged, 0–1: in the band and in time.
        power_share: f64,
    },
    /// At least one criterion is not met.
    NotPassed,
    /// No criterion is known not to be met, and at least one is not known to be met.
    NotDecided,
}

impl Verdict {
    /// The verdict in plain words: "passed", "passed in part", "not passed" or "not decided".
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Passed => "passed",
            Self::PassedInPart { .. } => "passed in part",
            Self::NotPassed => "not passed",
            Self::NotDecided => "not decided",
        }
    }

    /// The verdict that follows from `criteria`. A recording that is a copy of its target, or in which the sensor froze, gives
    /// [`Self::NotDecided`]. Otherwise any criterion that is not met decides, then any that is not decided, then a part that
    /// could not be judged; a measurement of less than `least` of the target gives [`Self::NotDecided`].
    #[must_use]
    pub(super) fn of(criteria: &[Criterion<VerifyCriterion>], least: f64) -> Self {
        let of = |extent: bool| {
            let chosen = criteria
                .iter()
                .filter(move |c| c.what.is_extent() == extent);
            Outcome::of_all(chosen.map(|criterion| criterion.outcome))
        };
        let found = |what: VerifyCriterion| {
            let criterion = criteria.iter().find(|criterion| criterion.what == what);
            criterion.and_then(|c| c.found).unwrap_or(1.0)
        };
        // Whatever a recording does not show counts neither for nor against the rendering.
        let shows = |c: &Criterion<VerifyCriterion>| {
            !c.what.is_of_the_recording() || c.outcome == Outcome::Met
        };
        if !criteria.iter().all(shows) {
            return Self::NotDecided;
        }
        match (of(false), of(true)) {
            (Outcome::NotMet, _) | (_, Outcome::NotMet) => Self::NotPassed,
            (Outcome::NotDecided, _) => Self::NotDecided,
            (Outcome::Met, Outcome::Met) => Self::Passed,
            (Outcome::Met, Outcome::NotDecided) if found(VerifyCriterion::Covered) < least => {
                Self::NotDecided
            }
            (Outcome::Met, Outcome::NotDecided) => Self::PassedInPart {
                power_share: found(VerifyCriterion::JudgedPower) * found(VerifyCriterion::Covered),
            },
        }
    }
}

/// The quantity that a criterion of a verification judges.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum VerifyCriterion {
    /// 20·log10 of the measured over the target rms, over what is judged, less the sensor's noise, dB: of all that was measured, with
    /// what was added to the texture. Not the gain of the texture alone: under added noise of −10 dB, a gain of 0.70 dB reads 0.83 dB.
    Level,
    /// The rms error of the judged lines, corrected for the scatter of the estimates and the sensor's noise, dB.
    SpectrumError,
    /// The same, lines weighted by the power of the target.
    PowerWeightedError,
    /// The same, lines weighted by the power of the target over the detection threshold.
    FeltWeightedError,
    /// Pearson's correlation of the waveforms over what is judged, less the sensor's noise.
    WaveformCorrelation,
    /// The power of the waveforms' difference over that of the target, over what is judged, less the sensor's noise, dB.
    WaveformError,
    /// The share of samples at a limit.
    Clipped,
    /// The power on lines of the band without target, re the target's.
    AddedPower,
    /// The perceptible power outside the band that the target does not have, re the perceptible power of the target in the band.
    FeltOutside,
    /// The longest drop-out that the target does not have, s.
    DropOut,
    /// The longest event that the target does not have, s.
    AddedEvent,
    /// The largest departure of a short-time level, dB.
    ShortTimeLevel,
    /// The rms difference between the distributions of short-time levels of measurement and target, dB.
    ShortTimeDistribution,
    /// The share of the target's power in the band on the lines that are judged.
    JudgedPower,
    /// The share of the lines of the band that are judged.
    JudgedLines,
    /// The share of the target's length that was measured.
    Covered,
    /// Whether the measurement is independent of the target: not a copy of it.
    Independent,
    /// The longest part of the recording in which the sensor holds still, s.
    Frozen,
    /// The difference that a finger could feel, in just-noticeable differences.
    FeltDifference,
}

impl VerifyCriterion {
    /// Whether the aspect describes how much was judged, and not how well it was rendered.
    fn is_extent(self) -> bool {
        matches!(self, Self::JudgedPower | Self::JudgedLines | Self::Covered)
    }

    /// Whether the aspect is an rms error corrected for the scatter of the estimates.
    fn is_an_error(self) -> bool {
        matches!(
            self,
            Self::SpectrumError | Self::PowerWeightedError | Self::FeltWeightedError
        )
    }

    /// Whether the aspect says that the recording does not show, or only partly shows, the delivered vibration.
    fn is_of_the_recording(self) -> bool {
        matches!(self, Self::Independent | Self::Frozen)
    }

    /// A value of this aspect as text with its unit.
    fn value(self, value: f64) -> String {
        match self {
            Self::Level => format!("{} dB", plus(value, 2)),
            Self::SpectrumError | Self::PowerWeightedError | Self::FeltWeightedError => {
                format!("{value:.2} dB rms")
            }
            Self::WaveformCorrelation => format!("{value:.3}"),
            Self::WaveformError | Self::ShortTimeLevel | Self::ShortTimeDistribution => {
                format!("{} dB", signed(value, 1))
            }
            Self::Clipped => format!("{:.2} %", value * 100.0),
            Self::AddedPower
            | Self::FeltOutside
            | Self::JudgedPower
            | Self::JudgedLines
            | Self::Covered => format!("{:.0} %", value * 100.0),
            Self::DropOut | Self::AddedEvent | Self::Frozen => format!("{:.0} ms", value * 1e3),
            Self::FeltDifference => format!("{value:.2} JND"),
            Self::Independent => format!("{value:.9}"),
        }
    }
}

impl fmt::Display for VerifyCriterion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Level => "level of what was measured",
            Self::SpectrumError => "spectrum error",
            Self::PowerWeightedError => "spectrum error weighted by power",
            Self::FeltWeightedError => {
                "spectrum error weighted by power re the detection threshold"
            }
            Self::WaveformCorrelation => "waveform correlation",
            Self::WaveformError => "waveform error (NMSE)",
            Self::Clipped => "samples at a limit",
            Self::AddedPower => "power added at lines where the target has none",
            Self::FeltOutside => "power above the detection threshold added outside the band",
            Self::DropOut => "longest drop-out",
            Self::AddedEvent => "longest event that the target does not have",
            Self::ShortTimeLevel => "largest deviation of the short-time level",
            Self::ShortTimeDistribution => "difference in the distribution of short-time levels",
            Self::JudgedPower => "share of the target power in the band that is evaluated",
            Self::JudgedLines => "share of the lines of the band that are evaluated",
            Self::Covered => "share of the length of the target that was measured",
            Self::Independent => "correlation with a copy of the target",
            Self::Frozen => "longest time with a frozen sensor",
            Self::FeltDifference => "perceptual difference",
        })
    }
}

impl Criterion<VerifyCriterion> {
    /// What was found, as text with its unit.
    #[must_use]
    pub fn found_text(&self) -> String {
        // The value found is smaller than the scatter of the estimates.
        if let (Some(found), Some([_, high])) = (self.found, self.interval)
            && self.what.is_an_error()
            && found <= 0.0
        {
            return format!("below {}", self.what.value(high));
        }
        self.found
            .map_or_else(|| "not measured".into(), |found| self.what.value(found))
    }

    /// The interval, as text with its unit; empty where there is none.
    #[must_use]
    pub fn interval_text(&self) -> String {
        match self.interval {
            Some([low, high]) => {
                let low = self.what.value(low);
                let number = low.split(' ').next().unwrap_or(&low);
                format!("{number} to {}", self.what.value(high))
            }
            None => String::new(),
        }
    }

    /// The limit for the outcome "met", as text with its unit.
    fn met_text(&self) -> String {
        let value = self.what.value(self.limit.value());
        match self.limit {
            Limit::AtMost { .. } => format!("at most {value}"),
            Limit::AtLeast { .. } => format!("at least {value}"),
            Limit::Within { .. } => format!("within ±{}", value.trim_start_matches('+')),
        }
    }

    /// The limit as text with its unit, with the limit for "not met" when it differs.
    #[must_use]
    pub fn limit_text(&self) -> String {
        let (met, not_met) = (self.limit.value(), self.limit.not_met_from());
        if (met - not_met).abs() < 1e-12 || not_met <= 0.0 {
            self.met_text()
        } else {
            let beyond = match self.limit {
                Limit::AtLeast { .. } => "below",
                _ => "above",
            };
            format!(
                "{}; not met {beyond} {}",
                self.met_text(),
                self.what.value(not_met)
            )
        }
    }

    /// The criterion in one phrase: the aspect, the value found, its interval where that matters, and the limit.
    #[must_use]
    pub fn phrase(&self) -> String {
        if self.what == VerifyCriterion::Independent {
            return "the measurement is proportional to the target: it is a copy and no measurement".into();
        }
        let interval = match (self.outcome, self.interval) {
            (Outcome::NotDecided, Some(_)) => format!("95 %: {}; ", self.interval_text()),
            _ => String::new(),
        };
        format!(
            "{} {} ({interval}{})",
            self.what,
            self.found_text(),
            self.met_text()
        )
    }
}

impl Verification {
    /// Whether every criterion is met over all of the target.
    #[must_use]
    pub fn passed(&self) -> bool {
        self.verdict == Verdict::Passed
    }

    /// The criterion on `what`, if it was looked at.
    #[must_use]
    pub fn criterion(&self, what: VerifyCriterion) -> Option<&Criterion<VerifyCriterion>> {
        self.criteria
            .iter()
            .find(|criterion| criterion.what == what)
    }

    /// Adds a criterion and derives the verdict again.
    #[must_use]
    pub fn with(mut self, criterion: Criterion<VerifyCriterion>) -> Self {
        self.criteria.retain(|other| other.what != criterion.what);
        self.criteria.push(criterion);
        self.verdict = Verdict::of(&self.criteria, self.limits.least_judged);
        self
    }

    /// The same verification when the device reported lost samples, the longest loss being `longest`: the interval of the
    /// drop-out criterion then extends to that length, wherever in the recording the loss was.
    #[must_use]
    pub fn with_samples_lost(self, longest: Seconds) -> Self {
        let Some(seen) = self.criterion(VerifyCriterion::DropOut).cloned() else {
            return self;
        };
        let found = seen.found.unwrap_or(0.0);
        let [low, high] = seen.interval.unwrap_or([found, found]);
        let interval = [low, high.max(longest.0)];
        self.with(Criterion::new(
            VerifyCriterion::DropOut,
            &seen.unit,
            found.max(longest.0),
            Some(interval),
            seen.limit,
        ))
    }

    /// What the verdict is about: the judged band, with its share of the power of the whole texture where that is not nearly all, and
    /// the share of the lines that could not be evaluated.
    fn over(&self) -> String {
        const NONE: f64 = 0.005;
        let left_out = (self.left_out >= NONE).then(|| {
            format!(
                "{:.0} % of the lines of the band could not be evaluated",
                self.left_out * 100.0
            )
        });
        let unfelt = self.is_unfelt().then(|| {
            "neither the target nor the measurement reaches the detection threshold".to_owned()
        });
        let parts = self.of_the_texture().into_iter().chain(left_out);
        let all: Vec<String> = parts.chain(unfelt).collect();
        let all = match all.as_slice() {
            [] => String::new(),
            some => format!(" ({})", some.join("; ")),
        };
        format!(" over {}{all}", self.judged_band())
    }

    /// Whether neither of the two is felt.
    fn is_unfelt(&self) -> bool {
        let levels = self.sensation_db;
        levels.is_some_and(|levels| levels.iter().all(|level| *level < 0.0))
    }

    /// The share of the power of the whole texture that is evaluated, with the difference from the whole, in words, where a tenth or more is not.
    fn of_the_texture(&self) -> Option<String> {
        self.is_of_a_part().then(|| {
            let whole = self.whole_texture_jnd.map_or(String::new(), |jnd| {
                format!(", from which the measurement differs by {jnd:.2} JND")
            });
            format!(
                "with {:.0} % of the power of the whole texture{whole}",
                self.texture_share * 100.0
            )
        })
    }

    /// Whether a tenth or more of the power of the whole texture is not evaluated.
    #[must_use]
    pub(crate) fn is_of_a_part(&self) -> bool {
        const MUCH: f64 = 0.1;
        1.0 - self.texture_share >= MUCH
    }

    /// The criterion in one phrase, with the correlation as it was measured where noise that was subtracted lowers it.
    fn main_phrase(&self, criterion: &Criterion<VerifyCriterion>) -> String {
        const LOWER: f64 = 0.01;
        let phrase = criterion.phrase();
        match criterion.found {
            Some(found)
                if criterion.what == VerifyCriterion::WaveformCorrelation
                    && found - self.waveform_correlation >= LOWER =>
            {
                let measured = criterion.what.value(self.waveform_correlation);
                format!(
                    "{phrase}, {measured} as measured over all of the band with the noise of the sensor"
                )
            }
            _ => phrase,
        }
    }

    /// One line with the verdict and its reasons: every criterion that is not met or not decided, otherwise the main ones.
    #[must_use]
    pub fn sentence(&self) -> String {
        let named = |outcome: Outcome| -> Vec<String> {
            let chosen = self.criteria.iter().filter(|c| c.outcome == outcome);
            chosen.map(Criterion::phrase).collect()
        };
        let main = || -> Vec<String> {
            use VerifyCriterion::{
                FeltDifference, Level, SpectrumError, WaveformCorrelation, WaveformError,
            };
            [
                Level,
                SpectrumError,
                WaveformCorrelation,
                WaveformError,
                FeltDifference,
            ]
            .into_iter()
            .filter_map(|what| self.criterion(what))
            .map(|criterion| self.main_phrase(criterion))
            .collect()
        };
        let why = match self.verdict {
            Verdict::Passed => main(),
            Verdict::PassedInPart { .. } => [named(Outcome::NotDecided), main()].concat(),
            Verdict::NotPassed => named(Outcome::NotMet),
            Verdict::NotDecided => named(Outcome::NotDecided),
        };
        let over = match self.verdict {
            Verdict::PassedInPart { power_share } => {
                let whole = self.of_the_texture();
                let whole = whole.map_or(String::new(), |share| format!(" ({share})"));
                format!(
                    ", over {:.0} % of the target's power in {}{whole}",
                    power_share * 100.0,
                    self.band_hz
                )
            }
            _ => self.over(),
        };
        let over = match self.mode {
            Mode::Replicate => over,
            Mode::Texture => format!("{over} (only the spectrum is evaluated)"),
        };
        let level = if Decibels(self.level_db).0 == 0.0 {
            String::new()
        } else {
            format!(
                "; rendered at {} dB and compared at that level",
                plus(self.level_db, 1)
            )
        };
        let felt = self.criterion(VerifyCriterion::FeltDifference);
        let felt = match felt.map(|c| c.outcome) {
            Some(Outcome::Met) if self.verdict == Verdict::NotPassed => {
                "; a finger could not distinguish the two (below the just-noticeable difference)"
            }
            _ => "",
        };
        let rehearsed = if self.is_rehearsal {
            "; this was a rehearsal through the transfer function that the drive was rendered with, so it is no evidence"
        } else {
            ""
        };
        format!(
            "{}{over}: {}{felt}{rehearsed}{level}",
            self.verdict.word(),
            why.join(", ")
        )
    }
}
