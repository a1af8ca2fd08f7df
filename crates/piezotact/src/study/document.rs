//! The documents of a study: what `segment`, `analyse` and `compare` hand out.

use std::collections::BTreeMap;

use serde::Serialize;

use super::{
    AnalysedRecording, BothWays, Comparison, Discrimination, Factor, Group, SampleTrend,
    SpeedTrend, StudyAnalysis, Trend,
};
use crate::compare::{
    ActivePassive, CommonLine, DirectionContrast, DirectionTrend, DiscriminationConfig,
    DiscriminationError, GroupPeriod, Groups, LevelSpread, LoadTrend, PeriodCriterion, PeriodUnit,
    RoughnessTrend, SampleUnit, Summary,
};
use crate::criterion::{Criterion, Outcome};
use crate::document::{Content, FailedFile};
use crate::feature::{FeatureConfig, StrokeFeatures};
use crate::quantity::{SampleRate, Seconds};
use crate::recording::Condition;
use crate::roles::Roles;
use crate::statistics::{Direction, LogFit, RankCorrelation};
use crate::stroke::{CutBy, Reason, Rule, StrokeCriterion};
use crate::surface::Duplex;
use crate::warning::{Merged, Warnings, merged};

/// Recordings cut into strokes.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct CutsDocument<'a> {
    /// One for each recording.
    pub recordings: Vec<CutRecording<'a>>,
    /// The files that could not be read or cut; absent without any.
    #[serde(skip_serializing_if = "<[FailedFile]>::is_empty")]
    pub failed: &'a [FailedFile],
}

impl Content for CutsDocument<'_> {
    const SCHEMA: &'static str = "segmentation";
}

/// A recording that was cut.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct CutRecording<'a> {
    /// What it is, and what was rejected.
    #[serde(flatten)]
    pub recording: RecordingEntry<'a>,
    /// Its strokes.
    pub strokes: Vec<StrokeEntry<'a>>,
}

/// A recording of a study.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct RecordingEntry<'a> {
    /// Where it is stored.
    pub file: &'a str,
    /// Its rate.
    pub rate_hz: SampleRate,
    /// How long it lasts.
    pub duration_s: Seconds,
    /// The condition that counts.
    pub condition: &'a Condition,
    /// The labels of the recording and of its name.
    pub labels: &'a BTreeMap<String, String>,
    /// Which channel plays which part.
    pub roles: &'a Roles,
    /// The rule that cut it.
    pub cut: &'a Rule,
    /// The file of a person's cuts that were applied.
    pub cuts_file: Option<&'a str>,
    /// What looked like a stroke and is none.
    pub rejected: Vec<RejectEntry<'a>>,
    /// What is in warning about it.
    pub warnings: Vec<Merged>,
    /// Where a person's cuts are looked for.
    pub cuts_are_looked_for_in: &'a str,
}

/// A stroke.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct StrokeEntry<'a> {
    /// Where the steady part begins, s.
    pub start_s: f64,
    /// Where it ends, s.
    pub end_s: f64,
    /// Where the contact begins, s.
    pub contact_start_s: f64,
    /// Where it ends, s.
    pub contact_end_s: f64,
    /// Who cut it.
    pub cut_by: CutBy,
    /// What was judged.
    pub criteria: &'a [Criterion<StrokeCriterion>],
}

/// A part that is no stroke.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct RejectEntry<'a> {
    /// Where it begins, s.
    pub start_s: f64,
    /// Where it ends, s.
    pub end_s: f64,
    /// Why.
    pub reason: &'a Reason,
    /// Why, in words.
    pub text: String,
    /// What was judged.
    pub criteria: &'a [Criterion<StrokeCriterion>],
}

impl<'a> CutsDocument<'a> {
    /// The strokes and rejects of `takes`, with times in s.
    #[must_use]
    pub fn of(takes: &'a [AnalysedRecording]) -> Self {
        let recordings = takes.iter().map(|take| CutRecording {
            recording: RecordingEntry::of(take),
            strokes: StrokeEntry::all(take),
        });
        Self {
            recordings: recordings.collect(),
            failed: &[],
        }
    }
}

impl<'a> RecordingEntry<'a> {
    fn of(take: &'a AnalysedRecording) -> Self {
        let segmentation = &take.segmentation;
        let rejected = segmentation.rejected.iter().map(|rejected| RejectEntry {
            start_s: take.seconds(rejected.interval.start),
            end_s: take.seconds(rejected.interval.end),
            reason: &rejected.reason,
            text: rejected.reason.to_string(),
            criteria: &rejected.criteria,
        });
        Self {
            file: &take.file,
            rate_hz: take.recording.rate(),
            duration_s: take.recording.duration(),
            condition: take.condition(),
            labels: &take.labels,
            roles: &segmentation.roles,
            cut: &segmentation.rule,
            cuts_file: segmentation.cuts.as_deref(),
            rejected: rejected.collect(),
            warnings: merged(&take.warnings()),
            cuts_are_looked_for_in: &take.cuts_are_looked_for_in,
        }
    }
}

impl<'a> StrokeEntry<'a> {
    fn all(take: &'a AnalysedRecording) -> Vec<Self> {
        let strokes = take.segmentation.strokes.iter();
        let strokes = strokes.map(|stroke| Self {
            start_s: take.seconds(stroke.steady.start),
            end_s: take.seconds(stroke.steady.end),
            contact_start_s: take.seconds(stroke.contact.start),
            contact_end_s: take.seconds(stroke.contact.end),
            cut_by: stroke.cut_by,
            criteria: &stroke.criteria,
        });
        strokes.collect()
    }
}

/// What strokes say, by recording and by group.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct AnalysisDocument<'a> {
    /// What the groups are of.
    pub by: Factor,
    /// One for each recording.
    pub recordings: Vec<AnalysedRecordingEntry<'a>>,
    /// One for each group.
    pub groups: Vec<GroupEntry<'a>>,
    /// What is in warning about the groups.
    pub warnings: Vec<Merged>,
    /// The files that could not be read or cut; absent without any.
    #[serde(skip_serializing_if = "<[FailedFile]>::is_empty")]
    pub failed: &'a [FailedFile],
}

impl Content for AnalysisDocument<'_> {
    const SCHEMA: &'static str = "analysis";
}

/// A recording with the features of its strokes.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct AnalysedRecordingEntry<'a> {
    /// What it is, and what was rejected.
    #[serde(flatten)]
    pub recording: RecordingEntry<'a>,
    /// What its strokes say.
    pub strokes: &'a [StrokeFeatures],
    /// Where they lie; absent for a recording without strokes, as what follows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cuts: Option<Vec<StrokeEntry<'a>>>,
    /// The unit of the vibration.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<&'a str>,
    /// How features were computed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub config: Option<&'a FeatureConfig>,
}

/// A group.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct GroupEntry<'a> {
    /// What its strokes say together.
    #[serde(flatten)]
    pub summary: &'a Summary,
    /// The names of its recordings.
    pub files: Vec<&'a str>,
    /// The class of its sample by the duplex theory.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub duplex: Option<Duplex>,
    /// Its mean PSD.
    pub psd: PsdEntry<'a>,
}

/// A PSD over strokes.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct PsdEntry<'a> {
    /// The unit of the values.
    pub unit: String,
    /// The step between the lines, Hz.
    pub resolution_hz: f64,
    /// The lines, Hz.
    pub frequency_hz: Vec<f64>,
    /// The mean over strokes.
    pub mean: &'a [f64],
    /// The standard deviation over strokes.
    pub sd: &'a [f64],
}

impl<'a> AnalysisDocument<'a> {
    /// The features of `study`, by recording and by group.
    #[must_use]
    pub fn of(study: &'a StudyAnalysis) -> Self {
        let recordings = study.takes.iter().map(|take| {
            let analysis = take.analysis.as_ref();
            AnalysedRecordingEntry {
                recording: RecordingEntry::of(take),
                strokes: analysis.map_or(&[], |a| &a.strokes),
                cuts: analysis.map(|_| StrokeEntry::all(take)),
                unit: analysis.map(|a| a.unit.symbol()),
                config: analysis.map(|a| &a.config),
            }
        });
        let groups = study.groups.iter();
        Self {
            by: study.by,
            recordings: recordings.collect(),
            failed: &study.failed,
            warnings: merged(groups.clone().flat_map(|group| &group.summary.warnings)),
            groups: groups.map(|group| GroupEntry::of(study, group)).collect(),
        }
    }
}

impl<'a> GroupEntry<'a> {
    fn of(study: &'a StudyAnalysis, group: &'a Group) -> Self {
        let summary = &group.summary;
        Self {
            summary,
            files: study
                .takes_of(group)
                .map(|take| take.name.as_str())
                .collect(),
            duplex: group.duplex,
            psd: PsdEntry {
                unit: summary.unit.of_psd(),
                resolution_hz: summary.psd.resolution_hz,
                frequency_hz: summary.psd.frequencies_hz(),
                mean: &summary.psd.mean,
                sd: &summary.psd.sd,
            },
        }
    }
}

/// What changes from group to group.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ComparisonDocument<'a> {
    /// What groups differ in.
    pub by: Factor,
    /// Lines that every sample has.
    pub common_lines: &'a [CommonLine],
    /// Active against passive touch, where touch is compared.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub active_against_passive: Option<&'a ActivePassive>,
    /// How levels differ between directions over all comparisons, where directions are compared.
    #[serde(skip_serializing_if = "<[DirectionContrast]>::is_empty")]
    pub direction_contrasts: &'a [DirectionContrast],
    /// Which samples are distinguishable, where samples are compared.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub discrimination: Option<DiscriminationEntry<'a>>,
    /// The comparisons.
    #[serde(flatten)]
    pub compared: Compared<'a>,
    /// What is in warning.
    pub warnings: Vec<Merged>,
    /// The files that could not be read or cut; absent without any.
    #[serde(skip_serializing_if = "<[FailedFile]>::is_empty")]
    pub failed: &'a [FailedFile],
}

impl Content for ComparisonDocument<'_> {
    const SCHEMA: &'static str = "comparison";
}

/// One comparison stands at the top; several stand in a list.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum Compared<'a> {
    /// One.
    One(Box<ComparisonEntry<'a>>),
    /// Several.
    Several {
        /// One for each setting.
        comparisons: Vec<ComparisonEntry<'a>>,
    },
}

/// One comparison.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ComparisonEntry<'a> {
    /// What its groups share, where comparisons differ in it.
    #[serde(skip_serializing_if = "str::is_empty")]
    pub setting: &'a str,
    /// Its groups.
    pub groups: Vec<GroupEntry<'a>>,
    /// What changes.
    #[serde(flatten)]
    pub trend: TrendEntry<'a>,
}

/// What changes in a comparison.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum TrendEntry<'a> {
    /// With the sample.
    Samples {
        /// How vibration and friction follow the roughness.
        roughness: &'a RoughnessTrend,
        /// The rank correlation of friction and rms.
        friction_rms_rank_correlation: Option<&'a RankCorrelation>,
        /// Sets of samples below the just-noticeable difference; absent where that is withheld.
        #[serde(skip_serializing_if = "Option::is_none")]
        below_jnd: Option<Vec<Vec<&'a str>>>,
    },
    /// With the speed.
    Speeds(Box<SpeedEntry<'a>>),
    /// How far participants differ.
    Participants {
        /// The spread of their levels.
        #[serde(skip_serializing_if = "Option::is_none")]
        level_spread: Option<&'a LevelSpread>,
    },
    /// With the load.
    Loads(&'a LoadTrend),
    /// With the direction of sliding.
    Directions(&'a DirectionTrend),
    /// Nothing beside active against passive touch.
    Touch {},
}

/// What changes with the speed.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct SpeedEntry<'a> {
    /// The exponent of rms on speed.
    pub rms_log_slope: Option<f64>,
    /// Its 95 % interval.
    pub rms_log_slope_interval: Option<[f64; 2]>,
    /// The power law.
    pub rms_on_speed: Option<LogFit>,
    /// Its direction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms_trend: Option<Direction>,
    /// The strongest candidate of a period that does not stand out, mm.
    pub spatial_period_candidate_mm: Option<f64>,
    /// The spatial period, where it stands out, mm.
    pub spatial_period_mm: Option<f64>,
    /// Its 95 % interval, mm.
    pub spatial_period_interval_mm: Option<[f64; 2]>,
    /// How the period is judged; absent where nothing was found.
    #[serde(flatten)]
    pub period: Option<PeriodEntry<'a>>,
    /// The peak at each speed.
    pub peaks: Vec<PeakEntry>,
}

/// How a spatial period is judged.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct PeriodEntry<'a> {
    /// Whether it is a period.
    pub spatial_period_outcome: Outcome,
    /// What decides it.
    pub spatial_period_criteria: &'a [Criterion<PeriodCriterion>],
    /// What its interval is over.
    pub spatial_period_over: OverEntry,
    /// What each group says of it.
    pub spatial_period_groups: &'a [GroupPeriod],
    /// Multiples of it that may be the period, mm.
    pub spatial_period_open_multiples_mm: Vec<f64>,
}

/// What an interval is over.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct OverEntry {
    /// What.
    pub what: PeriodUnit,
    /// How many.
    pub count: usize,
}

/// The peak at one speed.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct PeakEntry {
    /// The speed, mm/s.
    pub speed_mm_s: f64,
    /// The peak, Hz.
    pub frequency_hz: f64,
    /// How far it stands above the background, dB.
    pub prominence_db: f64,
}

/// Which samples are distinguishable, or why that is withheld.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum DiscriminationEntry<'a> {
    /// It is known.
    Found {
        /// One for each setting.
        settings: Vec<SettingEntry<'a>>,
        /// What is taken for independent.
        units: SampleUnit,
        /// The pairs over which errors are controlled.
        family: usize,
        /// How it was done.
        config: &'a DiscriminationConfig,
        /// What decides, in a sentence.
        sentence: String,
        /// Where the just-noticeable differences come from.
        jnd_source: &'static str,
    },
    /// It is withheld.
    DiscriminationError {
        /// Why.
        #[serde(flatten)]
        withheld: &'a DiscriminationError,
        /// Why, in a sentence.
        sentence: String,
    },
}

/// The samples of one setting.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct SettingEntry<'a> {
    /// Which of them are distinguishable.
    #[serde(flatten)]
    pub groups: &'a Groups,
    /// The setting.
    pub setting: &'a str,
}

impl<'a> ComparisonDocument<'a> {
    /// What changes in `study` with the thing that is asked, with all warnings about recordings and comparisons.
    #[must_use]
    pub fn of(study: &'a StudyAnalysis) -> Self {
        let comparisons = study.comparisons();
        let mut warnings: Warnings = study
            .takes
            .iter()
            .flat_map(AnalysedRecording::warnings)
            .collect();
        for number in 0..comparisons.len() {
            warnings.extend(study.warnings_of_comparison(number));
        }
        let discrimination = study.discrimination.as_ref();
        let of_pairs = discrimination
            .into_iter()
            .flat_map(Discrimination::warnings);
        warnings.extend(of_pairs.cloned());
        let numbered = comparisons.iter().enumerate();
        let mut entries: Vec<ComparisonEntry<'a>> = numbered
            .map(|(number, comparison)| ComparisonEntry::of(study, number, comparison))
            .collect();
        let compared = match (entries.len(), entries.pop()) {
            (1, Some(only)) => Compared::One(Box::new(only)),
            (_, last) => {
                entries.extend(last);
                Compared::Several {
                    comparisons: entries,
                }
            }
        };
        let touch = study
            .both_ways
            .as_ref()
            .filter(|_| study.by == Factor::Touch);
        Self {
            failed: &study.failed,
            by: study.by,
            common_lines: &study.common_lines,
            active_against_passive: touch.map(|BothWays { found, .. }| found),
            direction_contrasts: study.asked.as_ref().map_or(&[], |asked| &asked.directions),
            discrimination: discrimination.map(DiscriminationEntry::of),
            compared,
            warnings: warnings.merged(),
        }
    }
}

impl<'a> ComparisonEntry<'a> {
    fn of(study: &'a StudyAnalysis, number: usize, comparison: &'a Comparison) -> Self {
        let groups = comparison.groups.iter();
        let discrimination = study.discrimination.as_ref();
        let discrimination = discrimination.and_then(|found| found.groups(number));
        Self {
            setting: &comparison.setting,
            groups: groups.map(|group| GroupEntry::of(study, group)).collect(),
            trend: match &comparison.trend {
                Trend::Samples(trend) => TrendEntry::of_samples(trend, discrimination),
                Trend::Speeds(trend) => TrendEntry::Speeds(Box::new(SpeedEntry::of(trend))),
                Trend::Participants(spread) => TrendEntry::Participants {
                    level_spread: spread.as_ref(),
                },
                Trend::Loads(trend) => TrendEntry::Loads(trend),
                Trend::Directions(trend) => TrendEntry::Directions(trend),
                Trend::Touch => TrendEntry::Touch {},
            },
        }
    }
}

impl<'a> TrendEntry<'a> {
    fn of_samples(trend: &'a SampleTrend, groups: Option<&'a Groups>) -> Self {
        Self::Samples {
            roughness: &trend.roughness,
            friction_rms_rank_correlation: trend.friction_on_rms.as_ref(),
            below_jnd: groups.map(Groups::below_by_name),
        }
    }
}

impl<'a> SpeedEntry<'a> {
    fn of(trend: &'a SpeedTrend) -> Self {
        let fit = trend.rms_on_speed;
        let mm = |m: f64| m * 1e3;
        let period = trend.standing_out();
        let found = trend.period.as_ref();
        let peaks = found.into_iter().flat_map(|period| &period.peaks);
        Self {
            rms_log_slope: fit.map(|fit| fit.slope),
            rms_log_slope_interval: fit.and_then(|fit| fit.slope_interval),
            rms_on_speed: fit,
            rms_trend: fit.map(|fit| fit.direction()),
            spatial_period_candidate_mm: trend.candidate().map(|p| mm(p.period_m)),
            spatial_period_mm: period.map(|p| mm(p.period_m)),
            spatial_period_interval_mm: period.and_then(|p| p.interval_m.map(|i| i.map(mm))),
            period: found.map(|period| PeriodEntry {
                spatial_period_outcome: period.outcome(),
                spatial_period_criteria: &period.criteria,
                spatial_period_over: OverEntry {
                    what: period.over,
                    count: period.units,
                },
                spatial_period_groups: &period.groups,
                spatial_period_open_multiples_mm: period
                    .open_multiples_m
                    .iter()
                    .map(|m| mm(*m))
                    .collect(),
            }),
            peaks: peaks
                .map(|peak| PeakEntry {
                    speed_mm_s: mm(peak.speed_m_s),
                    frequency_hz: peak.frequency_hz,
                    prominence_db: peak.prominence_db,
                })
                .collect(),
        }
    }
}

impl<'a> DiscriminationEntry<'a> {
    fn of(discrimination: &'a Discrimination) -> Self {
        let found = match &discrimination.found {
            Ok(found) => found,
            Err(withheld) => {
                return Self::DiscriminationError {
                    withheld,
                    sentence: withheld.to_string(),
                };
            }
        };
        let settings = found.settings.iter().zip(&discrimination.settings);
        Self::Found {
            settings: settings
                .map(|(groups, setting)| SettingEntry { groups, setting })
                .collect(),
            units: found.units,
            family: found.family,
            config: &found.config,
            sentence: discrimination.line(),
            jnd_source: found.config.model.jnd_source(),
        }
    }
}
