//! What changes from group to group.

use serde::Serialize;

use super::grouping::{Grouping, Setting, differ_in, left_out};
use super::way::travelled_of;
use super::{AnalysedRecording, Factor, Group, StudyError};
use crate::compare::{
    AcrossSamples, ActivePassive, CompareWarning, Confounder, Contacts, Contrast, ContrastSetting,
    ContrastTrend, DiscriminationConfig, FrictionChange, Groups, LevelSpread, LoadTrend, Mixed,
    PerceivedStrokes, RoughnessTrend, Sliding, SpatialPeriod, Summary, TextureWithLines,
    ValueDifference, WithheldCause, across_participants, across_roughness, active_against_passive,
    add_over_time, comparable, compare_periods, confounders, contrast_trend, contrasts,
    discriminate_without, friction_against_rms, friction_on_speed, load_trend, rms_on_speed,
    spatial_period,
};
use crate::criterion::Outcome;
use crate::discrimination::Model;
use crate::feature::{Analysis, Vibrations, vibrations};
use crate::perception::{Parameters, PerceivedVibration};
use crate::quantity::{Acceleration, Band, Hertz, Seconds};
use crate::recording::Touch;
use crate::series::Series;
use crate::statistics::{Direction, LogFit, RankCorrelation};
use crate::stroke::Reason;
use crate::warning::Warning;

/// The band over which active and passive touch are compared, Hz.
const ACTIVE_PASSIVE_HZ: [f64; 2] = [20.0, 500.0];

/// Strokes that are longer than those of another sample by more than this factor are compared over time in their middle alone.
const LONGER: f64 = 1.1;
/// The share of the power in lines that may not be the textures' from which on it is a warning.
const IN_DOUBT: f64 = 0.2;

/// Lines at rest that are nearer than this are one.
const SAME_LINE_HZ: f64 = 2.0;

/// What changes with one thing: one comparison for each setting of all others.
#[derive(Clone, Debug)]
pub struct Across {
    pub by: Factor,
    /// The comparisons, in the order of participants, samples, speeds and touch.
    pub comparisons: Vec<Comparison>,
    /// How levels differ between directions, two loads, or the values of a label, over all comparisons; empty for what else is compared.
    pub contrasts: Vec<Contrast>,
}

/// Groups that differ in one thing and share all others, with what follows.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Comparison {
    /// What they share, as a person says it; empty where all comparisons share it.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub setting: String,
    /// The groups, in order.
    pub groups: Vec<Group>,
    /// What changes from one to the next.
    #[serde(flatten)]
    pub trend: Trend,
    /// What else differs between the groups: speed or load.
    #[serde(skip)]
    pub confounders: Vec<Confounder>,
    /// What this leaves open; a document has these among its own.
    #[serde(skip)]
    pub warnings: Vec<Warning>,
}

/// What changes from group to group.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum Trend {
    /// With the sample.
    Samples(SampleTrend),
    /// With the speed.
    Speeds(SpeedTrend),
    /// How far participants differ.
    Participants {
        /// The spread of their levels; absent without a group above zero.
        #[serde(skip_serializing_if = "Option::is_none")]
        level_spread: Option<LevelSpread>,
    },
    /// With the load.
    Loads(LoadTrend),
    /// With the direction of sliding, or the value of a label.
    Values(ContrastTrend),
    /// Nothing beside what [`BothWays`] says of active and passive touch.
    Touch {},
}

/// What changes with the sample.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct SampleTrend {
    /// How vibration and friction follow the roughness that is known of the samples.
    pub roughness: RoughnessTrend,
    /// The rank correlation of friction and rms over samples.
    #[serde(rename = "friction_rms_rank_correlation")]
    pub friction_on_rms: Option<RankCorrelation>,
    /// Sets of samples below the just-noticeable difference, by name; absent where that is withheld or not asked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub below_jnd: Option<Vec<Vec<String>>>,
    /// By how much friction changes with the rms.
    #[serde(skip)]
    pub friction_change_on_rms: Option<FrictionChange>,
    /// How many samples have one stroke only.
    #[serde(skip)]
    pub single_strokes: usize,
    #[serde(skip)]
    pub samples: usize,
}

/// What changes with the speed.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct SpeedTrend {
    /// The power law of rms on speed; absent for fewer than two speeds, and where all are within 20 %.
    pub rms_on_speed: Option<LogFit>,
    /// Its direction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms_trend: Option<Direction>,
    /// The power law of the friction coefficient on speed; absent where friction was not measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction_on_speed: Option<LogFit>,
    /// By how much friction changes.
    #[serde(skip)]
    pub friction_change: Option<FrictionChange>,
    /// The strongest candidate of a spatial period; absent where nothing was found.
    pub period: Option<SpatialPeriod>,
}

impl SpeedTrend {
    /// The spatial period, where it stands out at all speeds.
    #[must_use]
    pub fn standing_out(&self) -> Option<&SpatialPeriod> {
        let period = self.period.as_ref();
        period.filter(|period| period.outcome == Outcome::Met)
    }
}

impl Comparison {
    /// What the groups say, in order.
    #[must_use]
    pub fn summaries(&self) -> Vec<&Summary> {
        summaries(&self.groups)
    }

    /// What the comparison leaves open: of its groups, then of what changes.
    pub fn warnings(&self) -> impl Iterator<Item = &Warning> {
        let groups = self.groups.iter().flat_map(|group| &group.summary.warnings);
        groups.chain(self.own_warnings())
    }

    /// What the change leaves open.
    fn own_warnings(&self) -> impl Iterator<Item = &Warning> {
        self.trend_warnings().iter().chain(&self.warnings)
    }

    /// What the trend leaves open.
    pub(super) fn trend_warnings(&self) -> &[Warning] {
        match &self.trend {
            Trend::Speeds(trend) => trend.period.as_ref().map_or(&[], |period| &period.warnings),
            Trend::Loads(trend) => &trend.warnings,
            Trend::Values(trend) => &trend.warnings,
            Trend::Samples(_) | Trend::Participants { .. } | Trend::Touch {} => &[],
        }
    }
}

/// The warning that lines which may not be the textures' hold more than a fifth of the power of some group: 1 dB.
fn warning_of_lines(groups: &[Group]) -> Option<Warning> {
    let most = groups.iter().map(|group| &group.summary);
    let most = most.max_by(|a, b| a.share_in_doubt.total_cmp(&b.share_in_doubt))?;
    (most.share_in_doubt > IN_DOUBT).then(|| {
        Warning::from(CompareWarning::Mixed {
            how: Mixed::LinesInDoubt {
                lines_hz: most.lines_in_doubt_hz.clone(),
                share: most.share_in_doubt,
            },
        })
    })
}

fn summaries(groups: &[Group]) -> Vec<&Summary> {
    groups.iter().map(|group| &group.summary).collect()
}

/// Which samples are distinguishable in each setting, or why that is withheld.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum Discrimination {
    /// It is known.
    Found(Box<AcrossSamples>),
    /// It is withheld.
    Withheld {
        /// Why.
        #[serde(flatten)]
        why: WithheldCause,
        /// Why, in a sentence.
        sentence: String,
    },
}

impl Discrimination {
    /// What was found; none where it is withheld.
    fn found(&self) -> Option<&AcrossSamples> {
        match self {
            Self::Found(found) => Some(found),
            Self::Withheld { .. } => None,
        }
    }

    /// What was found in the setting number `setting`.
    #[must_use]
    pub fn groups(&self, setting: usize) -> Option<&Groups> {
        self.found()?.settings.get(setting)
    }

    /// What it leaves open.
    pub fn warnings(&self) -> impl Iterator<Item = &Warning> {
        self.found().into_iter().flat_map(|found| &found.warnings)
    }
}

/// The same samples, touched actively and passively at one speed by one participant.
#[derive(Clone, Debug)]
pub struct BothWays {
    /// Active touch, one group for each sample.
    pub active: Vec<Group>,
    pub passive: Vec<Group>,
    /// How they differ, for the samples that are in both.
    pub found: ActivePassive,
}

impl Grouping<'_> {
    /// What changes with `by`; nothing where no recordings differ in it and agree in all else.
    pub(super) fn across(&self, by: Factor) -> Result<Across, StudyError> {
        let comparison = |(setting, groups): Setting| {
            let summaries = summaries(&groups);
            let trend = match by {
                Factor::Speed => {
                    let fit = rms_on_speed(&summaries);
                    let friction = friction_on_speed(&summaries).unzip();
                    Trend::Speeds(SpeedTrend {
                        rms_trend: fit.as_ref().map(LogFit::direction),
                        rms_on_speed: fit,
                        friction_on_speed: friction.0,
                        friction_change: friction.1.flatten(),
                        period: self.period(&groups)?,
                    })
                }
                Factor::Sample | Factor::File => Trend::Samples(self.samples(&groups)),
                Factor::Participant => Trend::Participants {
                    level_spread: across_participants(&summaries),
                },
                Factor::Touch => Trend::Touch {},
                Factor::Load => Trend::Loads(self.loads(&groups)),
                Factor::Direction | Factor::Label => Trend::Values(self.values(&groups, by)),
            };
            let stated_n = self.stated_loads_n(&groups);
            let confounders = confounders(&self::summaries(&groups), &stated_n, by.word());
            let mut warnings = match by {
                // Those of the trend say it, and what is not known.
                Factor::Load | Factor::Direction | Factor::Label => Vec::new(),
                _ => confounders.iter().map(|c| c.warning(by.word())).collect(),
            };
            warnings.extend(warning_of_lines(&groups));
            Ok(Comparison {
                setting,
                groups,
                trend,
                confounders,
                warnings,
            })
        };
        let settings = self.settings(by)?.into_iter();
        let mut comparisons: Vec<Comparison> = settings
            .map(comparison)
            .collect::<Result<_, StudyError>>()?;
        self.compare_periods(&mut comparisons);
        let two_loads = |groups: &[Group]| by == Factor::Load && groups.len() == 2;
        let trends = comparisons.iter().map(|c| match &c.trend {
            Trend::Values(trend) => Some(trend.clone()),
            Trend::Loads(_) if two_loads(&c.groups) => Some(self.values(&c.groups, by)),
            _ => None,
        });
        let trends: Vec<Option<ContrastTrend>> = trends.collect();
        let compared = comparisons.iter().zip(&trends).filter_map(|(c, trend)| {
            let first = c.groups.first().and_then(|group| group.takes.first())?;
            Some(ContrastSetting {
                participant: self.takes[*first].condition().participant.as_deref(),
                trend: trend.as_ref()?,
                confounders: &c.confounders,
            })
        });
        Ok(Across {
            by,
            contrasts: contrasts(compared),
            comparisons,
        })
    }

    /// As [`Self::across`], where there is something to compare and all groups of a comparison have one unit.
    pub(super) fn required_across(&self, by: Factor) -> Result<Across, StudyError> {
        if let [only] = self.takes {
            return Err(StudyError::OneRecording {
                by,
                recording: only.name.clone(),
            });
        }
        let across = self.across(by)?;
        if across.comparisons.is_empty() {
            return Err(StudyError::NothingToCompare {
                by,
                differ_in: differ_in(self.takes, by),
                rejected: self
                    .takes
                    .iter()
                    .filter(|take| take.analysis.is_none())
                    .map(|take| (take.name.clone(), why_without_strokes(take)))
                    .collect(),
            });
        }
        for comparison in &across.comparisons {
            comparable(&comparison.summaries())?;
        }
        Ok(across)
    }

    fn samples(&self, groups: &[Group]) -> SampleTrend {
        let summaries = &summaries(groups);
        let ra_m = |name: &str| {
            let group = groups.iter().find(|group| group.summary.name == name)?;
            let known = self.known_of(&group.takes);
            known.filter(|of| of.name.eq_ignore_ascii_case(name))?.ra_m
        };
        let (friction_on_rms, friction_change_on_rms) = friction_against_rms(summaries);
        SampleTrend {
            roughness: across_roughness(summaries, ra_m),
            friction_on_rms,
            below_jnd: None,
            friction_change_on_rms,
            single_strokes: summaries.iter().filter(|s| s.strokes < 2).count(),
            samples: summaries.len(),
        }
    }

    /// How level and friction follow the load.
    fn loads(&self, groups: &[Group]) -> LoadTrend {
        load_trend(&summaries(groups), &self.stated_loads_n(groups))
    }

    /// How level and stick-slip differ between directions, loads or the values of a label.
    fn values(&self, groups: &[Group], by: Factor) -> ContrastTrend {
        let contacts = groups.iter().map(|group| {
            let takes = group.takes.iter().map(|place| &self.takes[*place]);
            takes.fold(Contacts::default(), |sum, take| {
                let stick_slip = stick_slips(take);
                Contacts {
                    all: sum.all + take.segmentation.strokes.len() + stick_slip,
                    stick_slip: sum.stick_slip + stick_slip,
                }
            })
        });
        let mut trend = contrast_trend(
            &summaries(groups),
            &contacts.collect::<Vec<_>>(),
            &self.stated_loads_n(groups),
            by.word(),
        );
        // A direction in which every stroke stuck and slipped has no level, but is no less said.
        let first = groups.first().and_then(|group| group.takes.first());
        let first = first.filter(|_| by == Factor::Direction);
        for place in first.map_or_else(Vec::new, |first| self.without_strokes(*first)) {
            let take = &self.takes[place];
            let stick_slip = stick_slips(take);
            let Some(direction) = take.condition().direction.filter(|_| stick_slip > 0) else {
                continue;
            };
            let mut known = trend.values.iter_mut();
            match known.find(|one| one.value == direction.word()) {
                Some(one) => {
                    one.contacts.all += stick_slip;
                    one.contacts.stick_slip += stick_slip;
                }
                None => trend.values.push(ValueDifference {
                    value: direction.word().into(),
                    level_difference_db: None,
                    contacts: Contacts {
                        all: stick_slip,
                        stick_slip,
                    },
                }),
            }
        }
        trend
    }

    /// The mean of the loads that the recordings of each group state, N; absent where one states none.
    fn stated_loads_n(&self, groups: &[Group]) -> Vec<Option<f64>> {
        let stated = |group: &Group| -> Option<f64> {
            let takes = group.takes.iter().map(|place| &self.takes[*place]);
            let loads: Option<Vec<f64>> =
                takes.map(|take| Some(take.condition().load_n?.0)).collect();
            loads.map(|loads| crate::statistics::mean(&loads))
        };
        groups.iter().map(stated).collect()
    }

    /// The spatial period on which all speeds agree.
    fn period(&self, groups: &[Group]) -> Result<Option<SpatialPeriod>, StudyError> {
        let mut slidings = Vec::new();
        for group in groups {
            let Some(speed) = group.summary.speed_m_s else {
                continue;
            };
            for place in &group.takes {
                let take = &self.takes[*place];
                if let Some(analysis) = &take.analysis {
                    let vibrations = vibrations(
                        &take.recording,
                        &take.segmentation,
                        analysis.config.high_pass,
                    )
                    .map_err(|error| take.failed(error))?;
                    slidings.push((take, speed.mean, vibrations));
                }
            }
        }
        let even: Vec<Option<Vec<Vec<f64>>>> = (slidings.iter())
            .map(|(take, speed_m_s, vibrations)| evenly(take, vibrations, *speed_m_s))
            .collect();
        let parts: Vec<_> = (slidings.iter().zip(&even))
            .map(|((take, speed_m_s, vibrations), even)| Sliding {
                group: take
                    .condition()
                    .load_n
                    .map_or("load not stated".to_owned(), |load| load.to_string()),
                speed_m_s: *speed_m_s,
                rate: take.recording.rate(),
                stretches: match even {
                    Some(even) => even.iter().map(Vec::as_slice).collect(),
                    None => stretches(take, vibrations),
                },
            })
            .collect();
        let filtered = groups.iter().flat_map(|group| &group.takes);
        let lowest_hz = filtered
            .filter_map(|place| Some(self.takes[*place].analysis.as_ref()?.config.passes_from().0))
            .fold(0.0, f64::max);
        Ok(spatial_period(&parts, Hertz(lowest_hz)))
    }

    /// Says of the periods of several samples whether all have the same.
    fn compare_periods(&self, comparisons: &mut [Comparison]) {
        let mut periods: Vec<(&str, &mut SpatialPeriod)> = Vec::new();
        for comparison in comparisons {
            let first = comparison
                .groups
                .first()
                .and_then(|group| group.takes.first());
            let sample = first.and_then(|place| self.takes[*place].condition().sample.as_deref());
            if let (Some(sample), Trend::Speeds(trend)) = (sample, &mut comparison.trend) {
                periods.extend(trend.period.as_mut().map(|period| (sample, period)));
            }
        }
        let mut samples = periods.iter().map(|(sample, _)| *sample);
        let first = samples.next();
        if samples.any(|sample| Some(sample) != first) {
            compare_periods(&mut periods);
        }
    }

    /// Which samples of `across` are distinguishable; its comparisons hold the sets below the just-noticeable difference then.
    pub(super) fn discrimination(&self, across: &mut Across, model: Model) -> Discrimination {
        let lines_hz = self.lines_of_no_texture_hz();
        let texture = |group: &Group| {
            let takes = group.takes.iter().map(|place| &self.takes[*place]);
            let analyses: Vec<_> = takes.filter_map(|take| take.analysis.as_ref()).collect();
            TextureWithLines::of(&group.summary.name, &analyses)
        };
        let all = across.comparisons.iter();
        let textures: Vec<Vec<TextureWithLines>> = all
            .map(|comparison| comparison.groups.iter().filter_map(texture).collect())
            .collect();
        let config = DiscriminationConfig::usual(model);
        let in_doubt_hz: Vec<Vec<f64>> = across
            .comparisons
            .iter()
            .map(|comparison| {
                let places = comparison.groups.iter().flat_map(|group| &group.takes);
                self.in_doubt_hz(places.copied())
            })
            .collect();
        let mut found = match discriminate_without(&textures, &lines_hz, &in_doubt_hz, &config) {
            Ok(found) => found,
            Err(why) => {
                let sentence = why.to_string();
                return Discrimination::Withheld { why, sentence };
            }
        };
        let strokes: Vec<Vec<Option<PerceivedStrokes>>> = across
            .comparisons
            .iter()
            .map(|comparison| {
                let longest_s = self.common_length_s(&comparison.groups);
                let of = |group: &Group| self.perceived(group, &config.model, longest_s);
                comparison.groups.iter().map(of).collect()
            })
            .collect();
        add_over_time(&mut found, &strokes);
        for (groups, comparison) in found.settings.iter_mut().zip(&mut across.comparisons) {
            groups.setting.clone_from(&comparison.setting);
            if let Trend::Samples(trend) = &mut comparison.trend {
                trend.below_jnd = Some(groups.below_by_name());
            }
        }
        Discrimination::Found(Box::new(found))
    }

    /// The median length of the strokes of the group whose strokes are shortest, s.
    fn common_length_s(&self, groups: &[Group]) -> f64 {
        let lengths = groups.iter().map(|group| group.summary.duration_s.median);
        lengths.fold(f64::INFINITY, f64::min)
    }

    /// What is felt of the strokes of `group`, by recording, in the channel of each recording that vibrates most; `None` where the model of
    /// perception does not hold. Of a stroke clearly longer than `longest_s` its middle counts: the course of a level and its events are felt
    /// over a whole stroke, and how long somebody stroked is no property of a texture.
    fn perceived(&self, group: &Group, model: &Model, longest_s: f64) -> Option<PerceivedStrokes> {
        let parameters = Parameters::published();
        let skin = |at: Hertz| model.skin_over_nail(at);
        let takes = group.takes.iter().map(|place| &self.takes[*place]);
        let analysed = takes.filter_map(|take| Some((take, take.analysis.as_ref()?)));
        let of = |(take, analysis): (&AnalysedRecording, &Analysis)| {
            let found = vibrations(
                &take.recording,
                &take.segmentation,
                analysis.config.high_pass,
            )
            .ok()?;
            let strongest = found.channels.iter().max_by(|a, b| {
                let squares = |all: &[f64]| all.iter().map(|v| v * v).sum::<f64>();
                squares(a).total_cmp(&squares(b))
            })?;
            let strokes = take.segmentation.strokes.iter();
            let most = longest_s * take.recording.rate().hz();
            let perceived = strokes.map(|stroke| {
                let samples = stroke.steady.of(strongest.as_slice());
                let length = match samples.len() as f64 > LONGER * most {
                    true => most as usize,
                    false => samples.len(),
                };
                let from = (samples.len() - length) / 2;
                let samples = samples[from..from + length].to_vec();
                let series = Series::<Acceleration>::new(samples, take.recording.rate()).ok()?;
                PerceivedVibration::of("the stroke", &series, &parameters, &skin).ok()
            });
            perceived.collect::<Option<Vec<_>>>()
        };
        analysed.map(of).collect()
    }

    /// The lines that are there at rest too, or in all samples at all speeds: they come from the mains or a machine, Hz.
    fn lines_of_no_texture_hz(&self) -> Vec<f64> {
        let analyses = self.takes.iter().filter_map(|take| take.analysis.as_ref());
        let at_rest = analyses.flat_map(|analysis| &analysis.rest_lines);
        let at_rest = at_rest.map(|line| line.frequency_hz);
        let common = self.lines.iter().filter(|line| line.is_the_machines());
        let mut all: Vec<f64> = at_rest
            .chain(common.map(|line| line.frequency_hz))
            .collect();
        all.sort_by(f64::total_cmp);
        all.dedup_by(|a, b| (*a - *b).abs() < SAME_LINE_HZ);
        all
    }

    /// The warning that some recordings stand in no comparison.
    pub(super) fn left_out(&self, across: &Across) -> Option<Warning> {
        let groups = across.comparisons.iter().flat_map(|c| &c.groups);
        left_out(self.takes, groups)
    }

    /// Active against passive touch, sample by sample.
    pub(super) fn both_ways(&self) -> Result<BothWays, StudyError> {
        let active = self.with_counterpart(Touch::Active, Touch::Passive)?;
        let passive = self.with_counterpart(Touch::Passive, Touch::Active)?;
        let [low, high] = ACTIVE_PASSIVE_HZ.map(Hertz);
        let stated = |groups: &[Group], sample: &str| {
            let place = groups.iter().position(|g| g.summary.name == sample)?;
            self.stated_loads_n(&groups[place..=place])[0]
        };
        let found = active_against_passive(
            &summaries(&active),
            &summaries(&passive),
            |sample| [stated(&active, sample), stated(&passive, sample)],
            Band::new(low, high)?,
        );
        Ok(BothWays {
            active,
            passive,
            found,
        })
    }
}

/// Every stroke of every channel.
fn stretches<'v>(take: &AnalysedRecording, vibrations: &'v Vibrations) -> Vec<&'v [f64]> {
    let channels = vibrations.channels.iter();
    let of = |channel: &'v Vec<f64>| {
        let strokes = take.segmentation.strokes.iter();
        strokes.map(|s| s.steady.of(channel.as_slice()))
    };
    channels.flat_map(of).collect()
}

/// The same as at one speed, by the measured motion; `None` where the motion was not measured, or is steady.
fn evenly(
    take: &AnalysedRecording,
    vibrations: &Vibrations,
    speed_m_s: f64,
) -> Option<Vec<Vec<f64>>> {
    let rate = take.recording.rate();
    let parts = travelled_of((0, Seconds(0.0)), take, vibrations);
    let even: Vec<_> = parts
        .iter()
        .map(|part| part.at_speed(rate, speed_m_s))
        .collect();
    let any = even.iter().any(Option::is_some);
    any.then(|| {
        let each = even.into_iter().zip(&parts);
        let each = each.map(|(even, part)| even.unwrap_or_else(|| part.samples()));
        each.flatten().collect()
    })
}

/// Why a recording has no strokes, where that is known.
pub(super) fn why_without_strokes(take: &AnalysedRecording) -> Option<Warning> {
    let found = &take.segmentation;
    found
        .untouched_warning()
        .or_else(|| found.rejection_warning())
}

/// How many contacts were rejected for stick-slip.
fn stick_slips(take: &AnalysedRecording) -> usize {
    let rejected = take.segmentation.rejected.iter();
    rejected
        .filter(|rejected| matches!(rejected.reason, Reason::StickSlip { .. }))
        .count()
}

impl AnalysedRecording {
    pub(super) fn failed(&self, error: crate::feature::FeatureError) -> StudyError {
        StudyError::Feature {
            file: self.file.clone(),
            error,
        }
    }
}
