//! A study as a value: recordings cut, analysed, grouped and compared.
//!
//! [`cut`] makes a [`AnalysedRecording`] of each recording, and [`analyse`] a [`StudyAnalysis`] of all of them. It holds everything that is
//! said of a study; texts, documents and reports show it and compute nothing.

mod comparison;
mod document;
mod error;
mod grouping;
mod page;
mod sections;
mod table;
mod take;
mod way;
mod words;

use std::collections::BTreeMap;

use comparison::why_without_strokes;
pub use comparison::{
    Across, BothWays, Comparison, Discrimination, SampleTrend, SpeedTrend, Trend,
};
pub use document::*;
pub use error::{NoStrokes, StudyError};
pub use grouping::{Factor, Group};
pub use sections::{Cutting, InSections, Measuring, SECTION_BYTES};
pub use table::{EVENT_NAMES, cuts_table, events_table, strokes_table};
pub use take::{AnalysedRecording, Label, Naming, Recorded, Stated, cut, label_by};

use crate::checksum::Checksum;
use crate::compare::{CommonLine, CompareWarning, Contrast, Mixed, Named, plain_name};
use crate::discrimination::Model;
use crate::document::FailedFile;
use crate::feature::{self, FeatureConfig, StrokeForces};
use crate::filter::HighPass;
use crate::integrity::copied;
use crate::quantity::{Band, Hertz, Unit};
use crate::stroke::{Interval, Signals};
use crate::surface::SampleSet;
use crate::warning::{Merged, Warning, merged_of};
use grouping::{Grouping, lines_of_all, usual};

/// How a study is analysed.
#[derive(Clone, Debug)]
pub struct StudySettings {
    /// What takes the gesture away.
    pub gesture: Gesture,
    /// Samples in a segment of the PSDs; lines about 5 Hz apart where it is not stated.
    pub segment: Option<usize>,
    /// What a person states of samples; the first set that has a sample counts. Samples of two laboratories may share a name, so that a set
    /// says nothing of a recording unless it is stated for it.
    pub sets: Vec<SampleSet>,
    /// The sets that the digital twin touches: they count for its own recordings.
    pub twin_sets: Vec<SampleSet>,
    /// The wavelength of the finger's ridges, m.
    pub ridge_m: Option<f64>,
    pub question: Question,
    /// How much is computed beside it.
    pub breadth: Breadth,
}

/// What takes the gesture away from the vibration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Gesture {
    /// [`HighPass::gesture`] for accelerations, nothing for signals of another quantity: what those hold at low frequencies is
    /// not known to be a gesture.
    Usual,
    /// What a person states: a high-pass, or none.
    Stated(Option<HighPass>),
}

/// What is asked of a study.
#[derive(Clone, Debug, PartialEq)]
pub enum Question {
    /// What the strokes of each group say. Unless stated, groups are samples where every recording names one, else files.
    Groups(Option<Factor>),
    /// What changes from group to group.
    Changes {
        /// What groups differ in.
        by: Factor,
        /// What a finger feels: samples are distinguished by it.
        model: Model,
    },
}

/// How much is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Breadth {
    /// What is asked.
    Question,
    /// What changes with sample, speed, load, direction and touch as well, wherever recordings differ in them, and an example of one stroke: all
    /// that a report shows.
    Report,
}

/// Where comparisons are of spectra, their lines are no farther apart, Hz: the least bands of what is felt are a third of an octave wide.
pub(crate) const COARSEST_HZ: f64 = 25.0;
/// So many samples of a stroke are looked at for copies.
const EXCERPT: usize = 16_384;

/// What a study takes in memory at most beside its recordings, in bytes for each sample in time of the longest one.
///
/// Source: measured by `tests/memory.rs`; docs/decisions/verification.md.
pub const MEMORY_BYTES_A_SAMPLE: usize = 64;

/// A study, analysed.
#[derive(Clone, Debug)]
pub struct StudyAnalysis {
    /// The recordings, in the order in which they came.
    pub takes: Vec<AnalysedRecording>,
    /// What is asked by.
    pub by: Factor,
    /// The recordings that have strokes, grouped by it.
    pub groups: Vec<Group>,
    /// The lines that all recordings have.
    pub common_lines: Vec<CommonLine>,
    /// What changes with the thing that is asked; absent where no change is asked.
    pub asked: Option<Across>,
    /// The warning that recordings stand in no comparison of what is asked.
    pub left_out: Option<Warning>,
    /// Which samples are distinguishable; absent unless samples or files are compared.
    pub discrimination: Option<Discrimination>,
    /// Active against passive touch; computed where it is asked, and for a report.
    pub both_ways: Option<BothWays>,
    /// What changes with sample, speed, load and direction where that is not asked; computed for a report.
    pub beside: Vec<Across>,
    /// One stroke; computed for a report.
    pub example: Option<Example>,
    /// The band of the features over all recordings, Hz: from the lowest that one of them shows to the highest. Absent without
    /// an analysed recording.
    pub band_hz: Option<[f64; 2]>,
    /// The files that could not be read or cut.
    pub failed: Vec<FailedFile>,
}

/// The first stroke of the first recording that has one, freed of the gesture.
#[derive(Clone, Debug, PartialEq)]
pub struct Example {
    /// The recording's place in the study.
    pub take: usize,
    /// The samples of the stroke in the unit of the vibration; absent where several channels vibrate.
    pub samples: Option<Vec<f64>>,
    /// The forces of the stroke; absent where none was measured.
    pub forces: Option<StrokeForces>,
}

/// Features, groups and comparisons of `takes`.
///
/// Recordings of one nominal rate have PSDs with the same lines, so that they can be averaged.
///
/// Source: house rule; features, groups and comparisons name theirs.
///
/// # Errors
/// [`StudyError::NoStrokes`] where no recording has one; [`StudyError::Unknown`] where a recording does not say what is grouped
/// by; [`StudyError::OneRecording`] where one is compared; [`StudyError::NothingToCompare`] where nothing differs in what is asked and shares all else; those of features and of
/// [`crate::compare`].
pub fn analyse(
    takes: Vec<AnalysedRecording>,
    settings: &StudySettings,
) -> Result<StudyAnalysis, StudyError> {
    analyse_watched(takes, settings, &mut || ())
}

/// As [`analyse`], with a call of `done` for every recording whose features were computed.
///
/// Source: as [`analyse`].
///
/// # Errors
/// As [`analyse`].
pub fn analyse_watched(
    mut takes: Vec<AnalysedRecording>,
    settings: &StudySettings,
    done: &mut dyn FnMut(),
) -> Result<StudyAnalysis, StudyError> {
    names_alike(&mut takes);
    // Recordings that stand each by itself are no repeats of each other.
    if settings.question != Question::Groups(Some(Factor::File)) {
        no_copies(&takes)?;
    }
    features(&mut takes, settings, done)?;
    let common_lines = lines_of_all(&takes);
    let grouping = Grouping::new(&takes, settings, &common_lines);
    let by = match &settings.question {
        Question::Groups(by) => by.unwrap_or_else(|| usual(&takes)),
        Question::Changes { by, .. } => *by,
    };
    let mut groups = grouping.groups(by)?;
    way::add(&takes, &mut groups)?;
    let (mut asked, mut discrimination) = (None, None);
    if let Question::Changes { model, .. } = &settings.question {
        let mut across = grouping.required_across(by)?;
        if matches!(by, Factor::Sample | Factor::File) {
            discrimination = Some(grouping.discrimination(&mut across, model.clone()));
        }
        asked = Some(across);
    }
    let left_out = asked.as_ref().and_then(|across| grouping.left_out(across));
    let whole = settings.breadth == Breadth::Report;
    let touch = asked.is_some() && by == Factor::Touch;
    let both_ways = (whole || touch).then(|| grouping.both_ways()).transpose()?;
    let mut beside = Vec::new();
    for factor in [
        Factor::Sample,
        Factor::Speed,
        Factor::Load,
        Factor::Direction,
    ] {
        // Where a recording does not say it, or not all can be averaged by it, nothing is shown of it.
        if whole && asked.as_ref().is_none_or(|a| a.by != factor) && grouping.groups(factor).is_ok()
        {
            beside.push(grouping.across(factor)?);
        }
    }
    let example = if whole { example(&takes)? } else { None };
    Ok(StudyAnalysis {
        by,
        groups,
        asked,
        left_out,
        discrimination,
        both_ways,
        beside,
        example,
        band_hz: band_hz(&takes),
        common_lines,
        takes,
        failed: Vec::new(),
    })
}

/// Warns of samples and participants whose names differ in capital letters, blanks or leading zeros alone: they count as two, and may be
/// meant as one.
fn names_alike(takes: &mut [AnalysedRecording]) {
    for of in [Named::Sample, Named::Participant] {
        let mut known: BTreeMap<String, String> = BTreeMap::new();
        for take in takes.iter_mut() {
            let condition = take.condition();
            let name = match of {
                Named::Sample => condition.sample.clone(),
                Named::Participant => condition.participant.clone(),
            };
            let Some(name) = name else {
                continue;
            };
            let first = known
                .entry(plain_name(&name))
                .or_insert_with(|| name.clone());
            if *first != name {
                let how = Mixed::NamesAlike {
                    of,
                    one: first.clone(),
                    other: name,
                };
                let warning = Warning::from(CompareWarning::Mixed { how });
                take.recording.about.add_warnings([warning]);
            }
        }
    }
}

/// Whether all recordings are different: copies would count as repeats, whatever they are multiplied by and however late they begin.
/// Other parts of one recording, chosen by cuts, are none.
///
/// # Errors
/// [`StudyError::Copy`].
fn no_copies(takes: &[AnalysedRecording]) -> Result<(), StudyError> {
    let mut strokes_of: BTreeMap<Checksum, usize> = BTreeMap::new();
    let mut channels_of: BTreeMap<Checksum, Vec<usize>> = BTreeMap::new();
    let mut excerpts: Vec<(usize, u64, &[f64])> = Vec::new();
    for (place, take) in takes.iter().enumerate() {
        let vibration = take.segmentation.roles.vibration.first();
        let mut channels = take.recording.channels().iter();
        let Some(channel) = channels.find(|channel| Some(&channel.name) == vibration) else {
            continue;
        };
        let samples = &channel.samples[..];
        let strokes = take.segmentation.strokes.iter().map(|stroke| stroke.steady);
        // Silence is like any other; of a recording larger than memory the first samples are there.
        let sounds = |part: &Interval| {
            let is_there = part.end <= samples.len();
            let part = part.of(samples);
            is_there && part.iter().any(|value| *value != part[0])
        };
        let strokes: Vec<Interval> = strokes.filter(sounds).collect();
        let mut copy_of = None;
        for stroke in &strokes {
            let checksum = Checksum::of(stroke.of(samples).iter().copied());
            let known = strokes_of.insert(checksum, place);
            copy_of = copy_of.or(known.filter(|other| *other != place));
        }
        if let Some(longest) = strokes.iter().max_by_key(|stroke| stroke.len()) {
            // With another time axis, strokes begin and end elsewhere.
            let alike = channels_of.entry(Checksum::of(samples.iter().copied()));
            let alike = alike.or_default();
            let shares = |other: &&usize| {
                let mut others = takes[**other].segmentation.strokes.iter();
                others.any(|other| strokes.iter().any(|own| own.meets(other.steady)))
            };
            copy_of = copy_of.or(alike.iter().find(shares).copied());
            alike.push(place);
            let excerpt = &longest.of(samples)[..longest.len().min(EXCERPT)];
            let rate = nominal_rate(take);
            let mut others = excerpts.iter().filter(|(_, of, _)| *of == rate);
            let changed = others.find(|(_, _, its)| copied(its, excerpt).is_some());
            copy_of = copy_of.or(changed.map(|(other, ..)| *other));
            excerpts.push((place, rate, excerpt));
        }
        if let Some(other) = copy_of {
            return Err(StudyError::Copy {
                one: takes[other].file.clone(),
                other: take.file.clone(),
            });
        }
    }
    Ok(())
}

/// Computes the features of every recording that has strokes.
fn features(
    takes: &mut [AnalysedRecording],
    settings: &StudySettings,
    done: &mut dyn FnMut(),
) -> Result<(), StudyError> {
    let mut longest: BTreeMap<u64, Vec<usize>> = BTreeMap::new();
    for take in takes.iter() {
        let lengths = take.segmentation.strokes.iter().map(|s| s.steady.len());
        let of_rate = longest.entry(nominal_rate(take)).or_default();
        of_rate.extend(lengths.max());
    }
    for take in takes.iter_mut() {
        done();
        if take.segmentation.strokes.is_empty() || take.analysis.is_some() {
            continue;
        }
        let longest = longest.get(&nominal_rate(take));
        let config = config_of(take, longest.map_or(&[][..], Vec::as_slice), settings)?;
        let analysis = feature::analyse(&take.recording, &take.segmentation, &config)
            .map_err(|error| take.failed(error))?;
        take.analysis = Some(analysis);
    }
    if takes.iter().any(|take| take.analysis.is_some()) {
        return Ok(());
    }
    let because = takes.iter().find_map(why_without_strokes);
    Err(StudyError::NoStrokes {
        found: Box::new(NoStrokes {
            recordings: takes.iter().map(|take| take.name.clone()).collect(),
            because,
            warnings: warnings_of(takes, &[]),
        }),
    })
}

/// How the features of a recording are computed, which has strokes of its rate whose `longest` have so many samples.
fn config_of(
    take: &AnalysedRecording,
    longest: &[usize],
    settings: &StudySettings,
) -> Result<FeatureConfig, StudyError> {
    let high_pass = match settings.gesture {
        Gesture::Stated(stated) => stated,
        Gesture::Usual => usual_high_pass(take),
    };
    let mut config = FeatureConfig::usual(take.recording.rate(), longest, high_pass)
        .map_err(|error| take.failed(error))?;
    if let Some(segment) = settings.segment {
        let needed = (take.recording.rate().hz() / COARSEST_HZ).ceil() as usize;
        if segment < needed && matches!(settings.question, Question::Changes { .. }) {
            let found = segment;
            return Err(StudyError::Coarse { needed, found });
        }
        config.welch.segment = segment;
    }
    Ok(config)
}

/// Time stamps give rates that differ in the last digits: recordings of one instrument share lines.
fn nominal_rate(take: &AnalysedRecording) -> u64 {
    (take.recording.rate().hz() * 10.0).round() as u64 / 2
}

/// The gesture is taken away from accelerations; what another signal holds below 5 Hz is not known to be one.
fn usual_high_pass(take: &AnalysedRecording) -> Option<HighPass> {
    let vibration = take.segmentation.roles.vibration.first()?;
    let channel = take
        .recording
        .pick(Some(vibration), &Unit::MetrePerSecondSquared)
        .ok()?;
    (channel.unit == Unit::MetrePerSecondSquared).then(HighPass::gesture)
}

fn example(takes: &[AnalysedRecording]) -> Result<Option<Example>, StudyError> {
    let Some(place) = takes.iter().position(|take| take.analysis.is_some()) else {
        return Ok(None);
    };
    let take = &takes[place];
    let high_pass = take.analysis.as_ref().and_then(|a| a.config.high_pass);
    let vibrations = feature::vibrations(&take.recording, &take.segmentation, high_pass)
        .map_err(|error| take.failed(error))?;
    let stroke = take.segmentation.strokes.first();
    let stroke = stroke.filter(|stroke| stroke.steady.end <= take.recording.len());
    let samples = match (vibrations.channels.as_slice(), stroke) {
        ([only], Some(stroke)) => Some(stroke.steady.of(only.as_slice()).to_vec()),
        _ => None,
    };
    let signals = Signals::of(&take.recording, &take.segmentation.roles).ok();
    let forces = stroke.zip(signals).and_then(|(stroke, signals)| {
        feature::stroke_forces(&signals, &take.segmentation, stroke.steady)
    });
    Ok(Some(Example {
        take: place,
        samples,
        forces,
    }))
}

fn band_hz(takes: &[AnalysedRecording]) -> Option<[f64; 2]> {
    let analyses = takes.iter().filter_map(|take| take.analysis.as_ref());
    let bands = analyses.map(|a| {
        let band: Band = a.config.band;
        let (Hertz(low_hz), Hertz(high_hz)) = (band.low(), band.high());
        [low_hz.max(a.psd.resolution_hz), high_hz]
    });
    bands.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
}

/// Every warning about `takes` and `groups`, those of one kind once and with all whom they are about.
fn warnings_of(takes: &[AnalysedRecording], groups: &[Group]) -> Vec<Merged> {
    let of_takes: Vec<(&str, Vec<Warning>)> = takes
        .iter()
        .map(|take| (take.name.as_str(), take.warnings()))
        .collect();
    let of_takes = of_takes
        .iter()
        .flat_map(|(name, warnings)| warnings.iter().map(|warning| (Some(*name), warning)));
    let of_groups = groups
        .iter()
        .flat_map(|group| group.summary.warnings.iter().map(|warning| (None, warning)));
    let all = merged_of(of_takes.chain(of_groups)).into_iter();
    all.map(|warning| warning.of_all((takes.len(), "recordings")))
        .collect()
}

impl StudyAnalysis {
    /// The comparisons that are asked; none where no change is asked.
    #[must_use]
    pub fn comparisons(&self) -> &[Comparison] {
        let asked = self.asked.as_ref();
        asked.map_or(&[], |across| &across.comparisons)
    }

    /// What changes with `by`, asked or beside it: one comparison for each setting; none where nothing is known of it.
    #[must_use]
    pub fn across(&self, by: Factor) -> &[Comparison] {
        let mut all = self.asked.iter().chain(&self.beside);
        let across = all.find(|across| across.by == by);
        across.map_or(&[], |across| &across.comparisons)
    }

    /// How levels differ between directions, two loads, or the values of a label; none elsewhere.
    #[must_use]
    pub fn contrasts(&self, by: Factor) -> &[Contrast] {
        let mut all = self.asked.iter().chain(&self.beside);
        let across = all.find(|across| across.by == by);
        across.map_or(&[], |across| &across.contrasts)
    }

    /// The recordings of a group, in order.
    pub fn takes_of<'a>(&'a self, group: &'a Group) -> impl Iterator<Item = &'a AnalysedRecording> {
        group.takes.iter().map(|place| &self.takes[*place])
    }

    /// The number of strokes over all groups.
    #[must_use]
    pub fn strokes(&self) -> usize {
        self.groups.iter().map(|group| group.summary.strokes).sum()
    }

    /// The warnings of the comparison number `number`: those of its groups and of what changes, and at the first that recordings
    /// stand in none.
    #[must_use]
    pub fn warnings_of_comparison(&self, number: usize) -> Vec<Warning> {
        let comparison = self.comparisons().get(number).into_iter();
        let own = comparison.flat_map(Comparison::warnings);
        let left_out = self.left_out.iter().filter(|_| number == 0);
        own.chain(left_out).cloned().collect()
    }
}
