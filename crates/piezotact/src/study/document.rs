//! The documents of a study: what `strokes` and `compare` hand out.

use std::collections::BTreeMap;

use serde::Serialize;

use super::{
    AnalysedRecording, BothWays, Comparison, Discrimination, Factor, Group, StudyAnalysis,
};
use crate::compare::{ActivePassive, CommonLine, Contrast};
use crate::criterion::Criterion;
use crate::document::{Content, FailedFile};
use crate::feature::{FeatureConfig, StrokeFeatures};
use crate::quantity::{SampleRate, Seconds};
use crate::recording::Condition;
use crate::roles::Roles;
use crate::stroke::{CutBy, Reason, Rule, StrokeCriterion};
use crate::warning::{Merged, Warnings, merged};

/// Recordings cut into strokes. It differs from the recordings by times in s for places of samples.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct CutsDocument<'a> {
    /// One for each recording.
    pub recordings: Vec<RecordingEntry<'a>>,
    /// The files that could not be read or cut; absent without any.
    #[serde(skip_serializing_if = "<[FailedFile]>::is_empty")]
    pub failed: &'a [FailedFile],
    /// What its report shows.
    #[serde(skip)]
    pub(super) takes: &'a [AnalysedRecording],
}

impl Content for CutsDocument<'_> {
    const SCHEMA: &'static str = "segmentation";
    const VERSION: u32 = 2;
}

/// A recording of a study: times in s for places of samples.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct RecordingEntry<'a> {
    /// Where it is stored.
    pub file: &'a str,
    /// Its rate.
    pub rate_hz: SampleRate,
    /// How long it lasts.
    pub duration_s: Seconds,
    /// In how many sections it was cut and analysed, as it is larger than memory; absent elsewhere.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sections: Option<usize>,
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
    /// Warnings about it.
    pub warnings: Vec<Merged>,
    /// Where a person's cuts are looked for.
    pub cuts_are_looked_for_in: &'a str,
    /// Where its strokes lie; absent from an analysis for a recording without strokes, as unit and settings are.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cuts: Option<Vec<StrokeEntry<'a>>>,
    /// What its strokes say; absent before an analysis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub strokes: Option<&'a [StrokeFeatures]>,
    /// The unit of the vibration.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<&'a str>,
    /// How features were computed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub config: Option<&'a FeatureConfig>,
}

/// A stroke: times in s for places of samples.
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

/// A part that is no stroke: times in s for places of samples.
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
    /// The strokes and rejects of `takes`, with times in s, and the files that `failed`.
    #[must_use]
    pub fn of(takes: &'a [AnalysedRecording], failed: &'a [FailedFile]) -> Self {
        let recordings = takes.iter().map(|take| RecordingEntry {
            cuts: Some(StrokeEntry::all(take)),
            ..RecordingEntry::of(take)
        });
        Self {
            recordings: recordings.collect(),
            failed,
            takes,
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
            duration_s: take.duration(),
            sections: (take.sections > 1).then_some(take.sections),
            condition: take.condition(),
            labels: &take.labels,
            roles: &segmentation.roles,
            cut: &segmentation.rule,
            cuts_file: segmentation.cuts.as_deref(),
            rejected: rejected.collect(),
            warnings: merged(&take.warnings()),
            cuts_are_looked_for_in: &take.cuts_are_looked_for_in,
            cuts: None,
            strokes: None,
            unit: None,
            config: None,
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

/// What strokes say, by recording and by group. It differs from the study by times in s and by the warnings of all groups.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct AnalysisDocument<'a> {
    /// What the groups are of.
    pub by: Factor,
    /// One for each recording.
    pub recordings: Vec<RecordingEntry<'a>>,
    /// One for each group.
    pub groups: &'a [Group],
    /// Warnings about the groups.
    pub warnings: Vec<Merged>,
    /// The files that could not be read or cut; absent without any.
    #[serde(skip_serializing_if = "<[FailedFile]>::is_empty")]
    pub failed: &'a [FailedFile],
    /// What its report shows.
    #[serde(skip)]
    pub(super) study: &'a StudyAnalysis,
}

impl Content for AnalysisDocument<'_> {
    const SCHEMA: &'static str = "analysis";
}

impl<'a> AnalysisDocument<'a> {
    /// The features of `study`, by recording and by group.
    #[must_use]
    pub fn of(study: &'a StudyAnalysis) -> Self {
        let recordings = study.takes.iter().map(|take| {
            let analysis = take.analysis.as_ref();
            RecordingEntry {
                strokes: Some(analysis.map_or(&[], |a| &a.strokes)),
                cuts: analysis.map(|_| StrokeEntry::all(take)),
                unit: analysis.map(|a| a.unit.symbol()),
                config: analysis.map(|a| &a.config),
                ..RecordingEntry::of(take)
            }
        });
        let groups = study.groups.iter();
        Self {
            study,
            by: study.by,
            recordings: recordings.collect(),
            failed: &study.failed,
            warnings: merged(groups.flat_map(|group| &group.summary.warnings)),
            groups: &study.groups,
        }
    }
}

/// What changes from group to group. It differs from the study by one comparison at the top, and by all warnings in one list.
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
    /// How levels differ between directions, two loads, or the values of a label, over all comparisons.
    #[serde(skip_serializing_if = "<[Contrast]>::is_empty")]
    pub contrasts: &'a [Contrast],
    /// Which samples are distinguishable, where samples are compared.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub discrimination: Option<&'a Discrimination>,
    /// The comparisons.
    #[serde(flatten)]
    pub compared: Compared<'a>,
    /// Warnings about the comparison.
    pub warnings: Vec<Merged>,
    /// The files that could not be read or cut; absent without any.
    #[serde(skip_serializing_if = "<[FailedFile]>::is_empty")]
    pub failed: &'a [FailedFile],
    /// What its report shows.
    #[serde(skip)]
    pub(super) study: &'a StudyAnalysis,
}

impl Content for ComparisonDocument<'_> {
    const SCHEMA: &'static str = "comparison";
    const VERSION: u32 = 3;
}

/// One comparison stands at the top; several stand in a list.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum Compared<'a> {
    /// One.
    One(&'a Comparison),
    /// Several.
    Several {
        /// One for each setting.
        comparisons: &'a [Comparison],
    },
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
        let compared = match comparisons {
            [only] => Compared::One(only),
            _ => Compared::Several { comparisons },
        };
        let touch = study
            .both_ways
            .as_ref()
            .filter(|_| study.by == Factor::Touch);
        Self {
            study,
            failed: &study.failed,
            by: study.by,
            common_lines: &study.common_lines,
            active_against_passive: touch.map(|BothWays { found, .. }| found),
            contrasts: study.asked.as_ref().map_or(&[], |asked| &asked.contrasts),
            discrimination,
            compared,
            warnings: warnings.merged(),
        }
    }
}
