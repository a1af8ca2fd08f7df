//! Recordings of a study, named and cut: what a person states counts before what the recording says, and that before its name.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use super::StudyError;
use crate::feature::Analysis;
use crate::quantity::{SampleRate, Seconds, Unit};
use crate::recording::{Condition, NotUsed, Recording, RecordingWarning};
use crate::roles::{Motion, Roles};
use crate::statistics::mean;
use crate::stroke::{Cuts, Expected, Judging, MotionKind, Segmentation, Signals, segment_of_sign};
use crate::warning::{Warning, Warnings};

/// A faster sliding speed is none of a finger, m/s: an arm that throws reaches about this.
pub(super) const FASTEST_M_S: f64 = 10.0;

/// The information in a file name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Naming {
    /// The fields that a condition knows.
    pub condition: Condition,
    /// All other fields, and all fields as they were written.
    pub labels: BTreeMap<String, String>,
    /// What a person should know before relying on it.
    pub warnings: Vec<Warning>,
}

impl Naming {
    /// Completes the condition and the labels of `recording` by its name. What it says itself counts.
    ///
    /// # Errors
    /// None.
    ///
    /// Source: house rule for the order in which conditions count.
    pub fn complete(self, recording: &mut Recording) {
        let own = std::mem::take(&mut recording.about.condition);
        recording.about.condition = condition_of(&Condition::default(), own, self.condition);
        recording.about.warnings.extend(self.warnings);
        for (name, label) in self.labels {
            let labels = &mut recording.annotations.labels;
            labels.entry(name).or_insert(label);
        }
    }
}

/// A recording as it comes to a study.
#[derive(Clone, Debug)]
pub struct Recorded {
    /// Where it is stored, for results and messages to cite.
    pub file: String,
    /// What it is called in texts and tables.
    pub name: String,
    /// The recording, with the condition and the labels that it states itself.
    pub recording: Recording,
    /// What its name says.
    pub naming: Naming,
    /// A person's cuts, where there are any.
    pub cuts: Option<Cuts>,
    /// Where a person's cuts are looked for.
    pub cuts_are_looked_for_in: String,
}

/// What a person states of all recordings of a study, whatever the recordings and their names say.
#[derive(Clone, Debug, PartialEq)]
pub struct Stated {
    /// The condition; what is absent is as the recordings or their names say.
    pub condition: Condition,
    /// The channels that vibrate; those that names and units speak for where there are none.
    pub vibration: Vec<String>,
    /// The channel of the normal force.
    pub normal_force: Option<String>,
    /// The channels of the tangential forces, two at most.
    pub tangential_force: Vec<String>,
    /// The channel of speed or position.
    pub motion: Option<String>,
    /// What counts as a stroke.
    pub judging: Judging,
}

impl Stated {
    /// Nothing stated; strokes are where the finger slides.
    #[must_use]
    pub fn nothing() -> Self {
        Self {
            condition: Condition::default(),
            vibration: Vec::new(),
            normal_force: None,
            tangential_force: Vec::new(),
            motion: None,
            judging: Judging::Sliding,
        }
    }

    /// Whether it can be.
    ///
    /// # Errors
    /// [`StudyError::TangentialForces`] for more than two channels, [`StudyError::Load`] for a load that is not above 0 N,
    /// [`StudyError::Speed`] for a speed that is not above 0, or above 10 m/s.
    pub fn check(&self) -> Result<(), StudyError> {
        let forces = self.tangential_force.len();
        if forces > 2 {
            return Err(StudyError::TangentialForces { found: forces });
        }
        if let Some(found_m_s) = self.condition.speed_m_s
            && !(found_m_s > 0.0 && found_m_s <= FASTEST_M_S)
        {
            return Err(StudyError::Speed { found_m_s });
        }
        match self.condition.load_n {
            Some(load) if !(load.0 > 0.0 && load.0.is_finite()) => {
                Err(StudyError::Load { found: load })
            }
            _ => Ok(()),
        }
    }

    /// The roles that are stated, and for the others those of `guessed`.
    fn roles(
        &self,
        guessed: Roles,
        recording: &Recording,
    ) -> Result<Roles, crate::recording::RecordingError> {
        let motion = match &self.motion {
            // What a person names as the vibration is not the motion.
            None => (guessed.motion).filter(|m| !self.vibration.iter().any(|v| v == m.channel())),
            Some(name) => {
                let channel = recording.pick(Some(name), &Unit::MetrePerSecond)?;
                Some(match channel.unit {
                    Unit::Metre => Motion::Position(name.clone()),
                    _ => Motion::Speed(name.clone()),
                })
            }
        };
        let stated = |names: &[String], guessed: Vec<String>| {
            if names.is_empty() {
                guessed
            } else {
                names.to_vec()
            }
        };
        let roles = Roles {
            vibration: stated(&self.vibration, guessed.vibration),
            normal_force: self.normal_force.clone().or(guessed.normal_force),
            tangential_force: stated(&self.tangential_force, guessed.tangential_force),
            motion,
        };
        for name in roles.vibration.iter().chain(&roles.tangential_force) {
            recording.pick(Some(name), &Unit::Newton)?;
        }
        Ok(Roles {
            // A force named normal is not tangential, whatever its name suggests.
            tangential_force: roles
                .tangential_force
                .into_iter()
                .filter(|name| roles.normal_force.as_ref() != Some(name))
                .collect(),
            ..roles
        })
    }
}

/// What is `stated` counts, then what the recording says itself, then its name. Only a recording knows its twin.
fn condition_of(stated: &Condition, own: Condition, named: Condition) -> Condition {
    let stated = stated.clone();
    Condition {
        sample: stated.sample.or(own.sample).or(named.sample),
        participant: stated.participant.or(own.participant).or(named.participant),
        load_n: stated.load_n.or(own.load_n).or(named.load_n),
        angle_deg: stated.angle_deg.or(own.angle_deg).or(named.angle_deg),
        speed_m_s: stated.speed_m_s.or(own.speed_m_s).or(named.speed_m_s),
        touch: stated.touch.or(own.touch).or(named.touch),
        direction: stated.direction.or(own.direction).or(named.direction),
        twin_seed: own.twin_seed,
    }
}

/// One recording with its strokes.
#[derive(Clone, Debug)]
pub struct AnalysedRecording {
    /// Where it is stored.
    pub file: String,
    /// What it is called.
    pub name: String,
    /// The channels on the clock of those that play a part, with the condition that counts; of a recording that is larger than memory its
    /// first section.
    pub recording: Recording,
    /// The samples of all of it.
    pub samples: usize,
    /// How many sections it was cut into to be analysed: 1, and more where it is larger than memory.
    pub sections: usize,
    /// The labels of the recording and of its name.
    pub labels: BTreeMap<String, String>,
    /// Its strokes and rejects.
    pub segmentation: Segmentation,
    /// What its strokes say; absent until it is analysed, and for a recording without strokes.
    pub analysis: Option<Analysis>,
    /// Where a person's cuts are looked for.
    pub cuts_are_looked_for_in: String,
    /// The label that recordings are compared by; absent unless one is chosen, see [`label_by`].
    pub label: Option<Label>,
    /// In how many strokes the motion is positive, and in how many it is negative: the mean of the speed, or the change of the position;
    /// absent where no motion was measured.
    pub signs_of_motion: Option<[usize; 2]>,
}

/// What a recording says of itself beside its condition.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Label {
    pub name: String,
    pub value: String,
}

/// Chooses the label `name` of `takes` as what [`super::Factor::Label`] compares.
///
/// # Errors
/// [`StudyError::Label`] where a recording has no such label.
///
/// Source: none; labels are what recordings, files beside them and their names say.
pub fn label_by(takes: &mut [AnalysedRecording], name: &str) -> Result<(), StudyError> {
    let known: BTreeSet<&String> = takes.iter().flat_map(|take| take.labels.keys()).collect();
    let known: Vec<String> = known.into_iter().cloned().collect();
    for take in takes {
        let Some(value) = take.labels.get(name).filter(|value| !value.is_empty()) else {
            return Err(StudyError::Label {
                name: name.into(),
                recording: take.name.clone(),
                known,
            });
        };
        take.label = Some(Label {
            name: name.into(),
            value: value.clone(),
        });
    }
    Ok(())
}

impl AnalysedRecording {
    /// The condition that counts.
    #[must_use]
    pub fn condition(&self) -> &Condition {
        &self.recording.about.condition
    }

    /// All warnings about it, each once.
    #[must_use]
    pub fn warnings(&self) -> Vec<Warning> {
        let analysis = self.analysis.iter().flat_map(|a| &a.warnings);
        let own = self.recording.about.warnings.iter();
        let all = own.chain(&self.segmentation.warnings).chain(analysis);
        all.cloned().collect::<Warnings>().into()
    }

    /// Where sample number `sample` lies, s from the start.
    #[must_use]
    pub fn seconds(&self, sample: usize) -> f64 {
        self.recording.rate().duration_of(sample).0
    }

    /// How long it lasts.
    #[must_use]
    pub fn duration(&self) -> Seconds {
        match self.sections {
            1 => self.recording.duration(),
            _ => self.recording.rate().duration_of(self.samples),
        }
    }

    /// The speed that counts, m/s: the one stated, or else the one that was measured.
    #[must_use]
    pub fn speed_m_s(&self) -> Option<f64> {
        let stated = self.condition().speed_m_s;
        stated.or_else(|| self.analysis.as_ref()?.speed_m_s())
    }
}

/// The strokes of `recorded`, with its condition and labels completed by what is `stated` and by its name, its roles stated or
/// else guessed, and a person's cuts applied.
///
/// Source: house rule for the order in which conditions count; the strokes are those of [`crate::stroke::segment`].
///
/// # Errors
/// Those of [`Stated::check`]; [`StudyError::Recording`] where a channel that is named is missing or the channels share no
/// clock; [`StudyError::Segment`] as [`crate::stroke::segment`].
pub fn cut(mut recorded: Recorded, stated: &Stated) -> Result<AnalysedRecording, StudyError> {
    stated.check()?;
    let cuts = recorded.cuts.take();
    let prepared = Prepared::of(recorded, stated)?;
    let (samples, rate) = (prepared.recording.len(), prepared.recording.rate());
    let segmentation = prepared.segmented(stated, None)?;
    Ok(prepared.with(with_cuts(segmentation, cuts.as_ref(), samples, rate)))
}

/// A recording that can be cut: named, with roles, on one clock.
#[derive(Clone, Debug)]
pub(super) struct Prepared {
    file: String,
    name: String,
    pub(super) recording: Recording,
    labels: BTreeMap<String, String>,
    roles: Roles,
    /// Where its motion was measured.
    measured: Vec<Range<usize>>,
    cuts_are_looked_for_in: String,
}

impl Prepared {
    pub(super) fn of(recorded: Recorded, stated: &Stated) -> Result<Self, StudyError> {
        let Recorded {
            file,
            name,
            mut recording,
            naming,
            cuts_are_looked_for_in,
            ..
        } = recorded;
        let in_recording = |error| StudyError::Recording {
            file: file.clone(),
            error,
        };
        let mut labels = naming.labels;
        labels.extend(recording.annotations.labels.clone());
        recording.about.warnings.extend(naming.warnings);
        let own = std::mem::take(&mut recording.about.condition);
        recording.about.condition = condition_of(&stated.condition, own, naming.condition);
        let (guessed, warnings) = Roles::guess(&recording);
        let roles = stated.roles(guessed, &recording).map_err(in_recording)?;
        if stated.vibration.is_empty() {
            recording.about.warnings.extend(warnings);
        }
        (recording.about.warnings).extend(roles.force_in_other_unit(&recording));
        recording.differentiate_velocities(&roles.vibration);
        let (recording, measured) = roles.on_one_clock(recording).map_err(in_recording)?;
        Ok(Self {
            file,
            name,
            recording,
            labels,
            roles,
            measured,
            cuts_are_looked_for_in,
        })
    }

    /// Its strokes, without what follows from all of them; the sign of the force in contact is found where it is not known.
    pub(super) fn segmented(
        &self,
        stated: &Stated,
        contact_sign: Option<f64>,
    ) -> Result<Segmentation, StudyError> {
        let condition = &self.recording.about.condition;
        let expected = Expected {
            load_n: condition.load_n,
            speed_m_s: condition.speed_m_s,
            judging: stated.judging,
        };
        match segment_of_sign(&self.recording, &self.roles, expected, contact_sign) {
            Ok(found) => Ok(found.within(&self.measured)),
            Err(error) => Err(StudyError::Segment {
                file: self.file.clone(),
                error,
            }),
        }
    }

    /// With its strokes.
    pub(super) fn with(self, segmentation: Segmentation) -> AnalysedRecording {
        AnalysedRecording {
            samples: self.recording.len(),
            sections: 1,
            signs_of_motion: signs_of_motion(&self.recording, &segmentation),
            segmentation,
            file: self.file,
            name: self.name,
            recording: self.recording,
            labels: self.labels,
            analysis: None,
            cuts_are_looked_for_in: self.cuts_are_looked_for_in,
            label: None,
        }
    }
}

/// As [`AnalysedRecording::signs_of_motion`].
pub(super) fn signs_of_motion(
    recording: &Recording,
    segmentation: &Segmentation,
) -> Option<[usize; 2]> {
    let signals = Signals::of(recording, &segmentation.roles).ok()?;
    let (motion, kind) = signals.motion?;
    let positive = segmentation.strokes.iter().filter(|stroke| {
        let part = stroke.steady.of(motion);
        match (kind, part) {
            (MotionKind::Position, [first, .., last]) => last > first,
            _ => mean(part) > 0.0,
        }
    });
    let positive = positive.count();
    Some([positive, segmentation.strokes.len() - positive])
}

fn with_cuts(
    mut segmentation: Segmentation,
    cuts: Option<&Cuts>,
    samples: usize,
    rate: SampleRate,
) -> Segmentation {
    if let Some(cuts) = cuts {
        let (cut, outside) = cuts.apply(segmentation, samples, rate);
        segmentation = cut;
        if !outside.is_empty() {
            let warning = RecordingWarning::NotUsed {
                what: NotUsed::Cuts {
                    file: cuts.source.clone(),
                    count: outside.len(),
                },
            };
            segmentation.warnings.push(Warning::from(warning));
        }
    }
    let own = segmentation.own_warnings(rate);
    segmentation.warnings.extend(own);
    segmentation
}
