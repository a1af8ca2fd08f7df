//! Recordings larger than memory: they come part by part, twice, and are cut and analysed in sections that end where nothing touches.

use super::take::{Prepared, signs_of_motion};
use super::{
    AnalysedRecording, NoStrokes, Recorded, Stated, StudyAnalysis, StudyError, StudySettings,
    analyse, config_of,
};
use crate::feature::{Analysis, FeatureConfig, FeatureError, long_enough, measured, shortest};
use crate::quantity::{SampleRate, Seconds};
use crate::recording::{Channel, Recording};
use crate::stroke::{Interval, Reason, Rejected, Rule, SegmentError, Segmentation};
use crate::warning::{Warning, Warnings};

/// The usual size from which on a section is cut off what waits, bytes of samples.
pub const SECTION_BYTES: usize = 32 << 20;
/// Without a moment to end in, it grows to so many times this size.
const GROWS: usize = 3;
/// So many strokes say which sign the force has in contact.
const SIGN_STROKES: f64 = 5.0;
/// A section ends in the middle of a pause between contacts that is no shorter.
const PAUSE: Seconds = Seconds(0.2);

/// The first of two passes: strokes are cut.
#[derive(Clone, Debug)]
pub struct Cutting {
    recorded: Recorded,
    stated: Stated,
    section_bytes: usize,
    waiting: Waiting,
    sections: Vec<Section>,
    /// The first section.
    start: Option<Prepared>,
    /// Why a section could not be cut.
    failed: Option<StudyError>,
}

/// A recording cut in sections.
#[derive(Clone, Debug)]
pub struct InSections {
    /// The recording with all its strokes; it holds the samples of its first section.
    pub take: AnalysedRecording,
    recorded: Recorded,
    stated: Stated,
    sections: Vec<Section>,
}

/// The second pass: features of the strokes are measured.
#[derive(Clone, Debug)]
pub struct Measuring {
    of: InSections,
    settings: StudySettings,
    /// How features are computed, the samples of the shortest stroke, and the warning about those that are too short; absent without strokes.
    plan: Option<(FeatureConfig, usize, Option<Warning>)>,
    waiting: Waiting,
    /// How many sections are measured.
    done: usize,
    analysis: Option<Analysis>,
}

/// A part of the recording, with its strokes by their places in it.
#[derive(Clone, Debug)]
struct Section {
    samples: Interval,
    /// Absent where nothing could be cut.
    segmentation: Option<Segmentation>,
    signs_of_motion: Option<[usize; 2]>,
}

/// Where a section ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum End {
    Pause,
    Recording,
}

/// Samples that came and belong to no section yet.
#[derive(Clone, Debug, Default)]
struct Waiting {
    /// The place of the first of them in the recording.
    first: usize,
    channels: Vec<Channel>,
}

impl Waiting {
    fn samples(&self) -> usize {
        let first = self.channels.first();
        first.map_or(0, |channel| channel.samples.len())
    }

    fn bytes(&self) -> usize {
        size_of::<f64>() * self.samples() * self.channels.len()
    }

    fn add(&mut self, part: &Recording) {
        if self.channels.is_empty() {
            self.channels = part.channels().to_vec();
            return;
        }
        for (own, part) in self.channels.iter_mut().zip(part.channels()) {
            own.samples.extend_from_slice(&part.samples);
        }
    }

    /// Takes the first `samples` away.
    fn take(&mut self, samples: usize) -> Vec<Channel> {
        self.first += samples;
        let channels = self.channels.iter_mut().map(|channel| {
            let later = channel.samples.split_off(samples);
            Channel {
                name: channel.name.clone(),
                unit: channel.unit.clone(),
                samples: std::mem::replace(&mut channel.samples, later),
            }
        });
        channels.collect()
    }
}

/// `channels`, described as `recorded` is, ready to be cut.
fn prepared(
    channels: Vec<Channel>,
    recorded: &Recorded,
    stated: &Stated,
) -> Result<Prepared, StudyError> {
    let mut described = recorded.clone();
    let about = recorded.recording.about.clone();
    let section = Recording::on_clocks(channels, recorded.recording.rate(), &[], about);
    described.recording = section.map_err(|error| StudyError::Recording {
        file: recorded.file.clone(),
        error,
    })?;
    described.recording.annotations = recorded.recording.annotations.clone();
    Prepared::of(described, stated)
}

impl Cutting {
    /// A recording that is `recorded` but for its samples, to be cut as it is `stated`, in sections that end from so many bytes of samples
    /// on. A person's cuts are of whole recordings.
    ///
    /// # Errors
    /// Those of [`Stated::check`].
    pub fn new(
        recorded: Recorded,
        stated: &Stated,
        section_bytes: usize,
    ) -> Result<Self, StudyError> {
        stated.check()?;
        Ok(Self {
            recorded,
            stated: stated.clone(),
            section_bytes,
            waiting: Waiting::default(),
            sections: Vec::new(),
            start: None,
            failed: None,
        })
    }

    /// Takes the next `part` of the recording, with all its channels.
    ///
    /// # Errors
    /// As [`super::cut`]; [`StudyError::Undivided`] where no moment without contact is found.
    pub fn add(&mut self, part: &Recording) -> Result<(), StudyError> {
        self.waiting.add(part);
        while self.waiting.bytes() >= self.section_bytes {
            let first = self.waiting.first;
            self.close(End::Pause)?;
            if self.waiting.first == first {
                break;
            }
        }
        Ok(())
    }

    /// Cuts what waits, up to its `end`.
    fn close(&mut self, end: End) -> Result<(), StudyError> {
        let rate = self.recorded.recording.rate();
        let samples = self.waiting.samples();
        let waiting = self.waiting.channels.clone();
        let section = prepared(waiting, &self.recorded, &self.stated)?;
        let segmentation = match section.segmented(&self.stated, known_sign(&self.sections)) {
            Ok(found) if matches!(found.rule, Rule::Whole) => return Err(self.undivided(rate)),
            // What a drive plays while nobody touches is no stroke.
            Ok(found) if matches!(found.rule, Rule::Played) => None,
            Ok(found) => Some(found),
            // A force that does not change while somebody pauses.
            Err(StudyError::Segment { file, error })
                if matches!(
                    error,
                    SegmentError::Dead { .. } | SegmentError::TooShort { .. }
                ) =>
            {
                let failed = StudyError::Segment { file, error };
                self.failed.get_or_insert(failed);
                None
            }
            Err(error) => return Err(error),
        };
        let end = match &segmentation {
            _ if end == End::Recording => samples,
            None => samples / 3 * 2,
            Some(found) => match pause(found, samples, rate) {
                Some(end) => end,
                None if self.waiting.bytes() < GROWS * self.section_bytes => return Ok(()),
                None => return Err(self.undivided(rate)),
            },
        };
        let start = self.waiting.first;
        self.waiting.take(end);
        let segmentation = segmentation.map(|found| until(found, end));
        let signs = segmentation.as_ref();
        let signs = signs.and_then(|of| signs_of_motion(&section.recording, of));
        self.sections.push(Section {
            samples: Interval {
                start,
                end: start + end,
            },
            segmentation,
            signs_of_motion: signs,
        });
        self.start.get_or_insert(section);
        Ok(())
    }

    fn undivided(&self, rate: SampleRate) -> StudyError {
        StudyError::Undivided {
            file: self.recorded.file.clone(),
            from: rate.duration_of(self.waiting.first),
            lasts: rate.duration_of(self.waiting.samples()),
        }
    }

    /// The strokes of all sections, with the `warnings` about the whole recording.
    ///
    /// # Errors
    /// As [`Self::add`]; [`StudyError::NoStrokes`] where there is nothing to cut.
    pub fn cut(
        mut self,
        warnings: impl IntoIterator<Item = Warning>,
    ) -> Result<InSections, StudyError> {
        if self.waiting.samples() > 0 {
            self.close(End::Recording)?;
        }
        of_one_sign(&mut self.sections);
        let nothing = || {
            let found = NoStrokes {
                recordings: vec![self.recorded.name.clone()],
                because: None,
                warnings: Vec::new(),
            };
            self.failed.clone().unwrap_or(StudyError::NoStrokes {
                found: Box::new(found),
            })
        };
        let joined = joined(&self.sections).zip(self.start);
        let (segmentation, start) = joined.ok_or_else(nothing)?;
        let mut take = start.with(segmentation);
        take.samples = self.sections.last().map_or(0, |last| last.samples.end);
        take.sections = self.sections.len();
        take.recording.about.add_warnings(warnings);
        let signs = self.sections.iter().filter_map(|s| s.signs_of_motion);
        take.signs_of_motion = signs.reduce(|a, b| [a[0] + b[0], a[1] + b[1]]);
        Ok(InSections {
            take,
            recorded: self.recorded,
            stated: self.stated,
            sections: self.sections,
        })
    }
}

/// The middle of the longest pause between the contacts of `samples`: in their middle third if there is one, else before it. What is left is
/// long enough to be cut too.
fn pause(segmentation: &Segmentation, samples: usize, rate: SampleRate) -> Option<usize> {
    let strokes = segmentation.strokes.iter().map(|stroke| stroke.contact);
    let rejected = segmentation.rejected.iter().map(|part| part.interval);
    let mut contacts: Vec<Interval> = strokes.chain(rejected).collect();
    contacts.sort_by_key(|contact| contact.start);
    contacts.push(Interval {
        start: samples,
        end: samples,
    });
    let mut from = 0;
    let mut pauses = Vec::new();
    for contact in contacts {
        if contact.start >= from + rate.samples_in(PAUSE) {
            // Of a long one any moment will do.
            let [first, last] =
                [from, contact.start].map(|at| at.clamp(samples / 3, samples / 3 * 2));
            let middle = match first < last {
                true => first.midpoint(last),
                false => from.midpoint(contact.start),
            };
            pauses.push((contact.start - from, middle));
        }
        from = from.max(contact.end);
    }
    let longest = |from: usize| {
        let pauses = pauses
            .iter()
            .filter(|(_, middle)| (from..=samples / 3 * 2).contains(middle));
        pauses.max().map(|(_, middle)| *middle)
    };
    longest(samples / 3).or_else(|| longest(1))
}

/// What of `segmentation` lies before sample `end`, where nothing touches.
fn until(mut segmentation: Segmentation, end: usize) -> Segmentation {
    segmentation
        .strokes
        .retain(|stroke| stroke.contact.end <= end);
    segmentation
        .rejected
        .retain(|part| part.interval.end <= end);
    segmentation
}

/// The sign of the force in the contacts of a section, and how many strokes speak for it.
fn sign(section: &Section) -> Option<(f64, usize)> {
    let found = section.segmentation.as_ref()?;
    Some((found.force_zeros.as_ref()?.sign, found.strokes.len()))
}

/// The strokes of positive sign less those of negative sign.
fn signed_strokes(sections: &[Section]) -> f64 {
    let signed = |(sign, strokes): (f64, usize)| sign * strokes as f64;
    sections.iter().filter_map(sign).map(signed).sum()
}

/// The sign of the force in contact, where enough strokes speak for it: a force cell keeps its sign.
fn known_sign(sections: &[Section]) -> Option<f64> {
    let usual = signed_strokes(sections);
    (usual.abs() >= SIGN_STROKES).then(|| usual.signum())
}

/// Sections whose contacts have another sign than those with most strokes hold none: while somebody pauses before the first strokes, noise
/// decides it.
fn of_one_sign(sections: &mut [Section]) {
    let usual = signed_strokes(sections);
    let others = sections
        .iter_mut()
        .filter(|section| sign(section).is_some_and(|(own, _)| own * usual < 0.0));
    for section in others {
        section.signs_of_motion = None;
        let Some(found) = &mut section.segmentation else {
            continue;
        };
        let strokes = found.strokes.drain(..).map(|stroke| Rejected {
            interval: stroke.contact,
            reason: Reason::NoContact,
            criteria: Vec::new(),
        });
        found.rejected = strokes.collect();
        found.warnings.clear();
    }
}

/// The strokes of all sections by their places in the recording; `None` where nothing could be cut. Roles, rule and warnings are those of
/// sections with strokes, where there are some.
fn joined(sections: &[Section]) -> Option<Segmentation> {
    let cut = || {
        let found =
            |section: &'_ Section| Some((section.samples.start, section.segmentation.clone()?));
        sections.iter().filter_map(found)
    };
    let has_strokes = cut().any(|(_, found)| !found.strokes.is_empty());
    let speaks = |found: &Segmentation| !has_strokes || !found.strokes.is_empty();
    let (_, first) = cut().find(|(_, found)| speaks(found))?;
    let mut all = Segmentation {
        strokes: Vec::new(),
        rejected: Vec::new(),
        warnings: Vec::new(),
        force_zeros: first.force_zeros.clone().map(|mut of| {
            of.zeros.clear();
            of
        }),
        untouched: first.untouched.filter(|_| !has_strokes),
        ..first
    };
    let mut warnings = Warnings::new();
    for (start, found) in cut() {
        if speaks(&found) {
            warnings.extend(found.warnings);
        }
        let later = |part: &mut Interval| {
            part.start += start;
            part.end += start;
        };
        all.strokes
            .extend(found.strokes.into_iter().map(|mut stroke| {
                later(&mut stroke.steady);
                later(&mut stroke.contact);
                stroke
            }));
        all.rejected
            .extend(found.rejected.into_iter().map(|mut part| {
                later(&mut part.interval);
                part
            }));
        if let (Some(all), Some(own)) = (&mut all.force_zeros, found.force_zeros) {
            let zeros = own.zeros.into_iter();
            all.zeros
                .extend(zeros.map(|(at, zeros)| (at + start, zeros)));
        }
    }
    all.warnings = warnings.into();
    Some(all)
}

impl InSections {
    /// The recording with its strokes, without what they say.
    #[must_use]
    pub fn cuts(&self) -> AnalysedRecording {
        let mut take = self.take.clone();
        let own = take.segmentation.own_warnings(take.recording.rate());
        take.segmentation.warnings.extend(own);
        take
    }

    /// Features of these strokes, to be measured in a second pass.
    ///
    /// # Errors
    /// Those of features whose configuration cannot be.
    pub fn measuring(mut self, settings: &StudySettings) -> Result<Measuring, StudyError> {
        let found = &self.take.segmentation;
        let longest = found.strokes.iter().map(|s| s.steady.len()).max();
        let mut plan = None;
        if let Some(longest) = longest {
            let config = config_of(&self.take, &[longest], settings)?;
            let rate = self.take.recording.rate();
            let (kept, left_out) = long_enough(found, &config, rate);
            for section in self.sections.iter_mut().filter(|_| left_out.is_some()) {
                if let Some(own) = &mut section.segmentation {
                    own.strokes
                        .retain(|stroke| stroke.steady.len() >= config.welch.segment);
                }
            }
            plan = Some((config, shortest(&kept), left_out));
        }
        Ok(Measuring {
            of: self,
            settings: settings.clone(),
            plan,
            waiting: Waiting::default(),
            done: 0,
            analysis: None,
        })
    }
}

impl Measuring {
    /// Takes the next `part` of the recording, with all its channels.
    ///
    /// # Errors
    /// Those of features.
    pub fn add(&mut self, part: &Recording) -> Result<(), StudyError> {
        self.waiting.add(part);
        while let Some(section) = self.of.sections.get(self.done) {
            if self.waiting.samples() < section.samples.len() {
                break;
            }
            self.measure()?;
            self.done += 1;
        }
        Ok(())
    }

    /// Measures the strokes of the section that is next; the samples are there.
    fn measure(&mut self) -> Result<(), StudyError> {
        let of = &mut self.of;
        let section = &of.sections[self.done];
        let channels = self.waiting.take(section.samples.len());
        let found = section.segmentation.as_ref();
        let found = found.filter(|found| !found.strokes.is_empty());
        let (Some(found), Some((config, shortest, _))) = (found, &self.plan) else {
            return Ok(());
        };
        let prepared = prepared(channels, &of.recorded, &of.stated)?;
        match measured(&prepared.recording, found, config, *shortest) {
            Ok(mut analysis) => {
                let start_s = of.take.seconds(section.samples.start);
                for stroke in &mut analysis.strokes {
                    stroke.start_s += start_s;
                }
                match &mut self.analysis {
                    Some(all) => all.join(analysis),
                    none => *none = Some(analysis.without_single_spectra()),
                }
            }
            // A sensor that gave nothing here.
            Err(FeatureError::ConstantVibration { .. }) => {
                let lost = section.samples;
                let all = &mut of.take.segmentation;
                let (gone, kept) = std::mem::take(&mut all.strokes)
                    .into_iter()
                    .partition(|stroke| stroke.contact.meets(lost));
                all.strokes = kept;
                all.rejected
                    .extend(Vec::into_iter(gone).map(|stroke| Rejected {
                        interval: stroke.contact,
                        reason: Reason::CutByRecording,
                        criteria: stroke.criteria,
                    }));
                all.rejected.sort_by_key(|part| part.interval.start);
            }
            Err(error) => return Err(of.take.failed(error)),
        }
        Ok(())
    }

    /// The study of this recording.
    ///
    /// # Errors
    /// As [`super::analyse`].
    pub fn finish(self) -> Result<StudyAnalysis, StudyError> {
        let mut take = self.of.cuts();
        if let (Some(mut analysis), Some((config, _, left_out))) = (self.analysis, self.plan) {
            let (kept, _) = long_enough(&take.segmentation, &config, take.recording.rate());
            let concluded = analysis.conclude(&kept, left_out);
            concluded.map_err(|error| take.failed(error))?;
            take.analysis = Some(analysis);
        }
        analyse(vec![take], &self.settings)
    }
}
