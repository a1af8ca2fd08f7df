//! Which recordings belong together.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use serde::{Deserialize, Serialize};

use super::{AnalysedRecording, StudyError, StudySettings};
use crate::compare::{
    AlongTheWay, CommonLine, CompareWarning, LinesOf, Mixed, Periods, Summary, common_lines,
    lines_in_doubt, lines_of_strokes, set_apart, summarise,
};
use crate::feature::vibrations;
use crate::quantity::Hertz;
use crate::recording::{BenchKind, SlidingDirection, Touch};
use crate::surface::{Duplex, SampleSet, SurfaceSample};
use crate::warning::Warning;

/// What recordings are grouped by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Factor {
    /// The surface sample.
    Sample,
    /// The sliding speed.
    Speed,
    /// The participant.
    Participant,
    /// Active or passive touch.
    Touch,
    /// The normal force that is asked for.
    Load,
    /// The direction of sliding.
    Direction,
    /// The value of a label, see [`super::label_by`].
    Label,
    /// Each recording by itself.
    File,
}

impl Factor {
    /// As documents have it: `sample`.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Sample => "sample",
            Self::Speed => "speed",
            Self::Participant => "participant",
            Self::Touch => "touch",
            Self::Load => "load",
            Self::Direction => "direction",
            Self::Label => "label",
            Self::File => "file",
        }
    }

    /// What a recording has to say for it.
    #[must_use]
    pub(super) fn noun(self) -> &'static str {
        match self {
            Self::Sample => "a sample",
            Self::Speed => "a sliding speed",
            Self::Participant => "a participant",
            Self::Touch => "active or passive touch",
            Self::Load => "a load",
            Self::Direction => "a direction of sliding",
            Self::Label => "a value of the label",
            Self::File => "a name",
        }
    }
}

impl fmt::Display for Factor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.word())
    }
}

/// What a recording is grouped by; what is not known is empty.
#[derive(Clone, Debug, Default, PartialEq)]
struct Key {
    sample: String,
    speed: String,
    participant: String,
    touch: String,
    load: String,
    direction: String,
    label: String,
    file: String,
}

/// What recordings may differ in, in the order in which a person says it.
const FACTORS: [Factor; 6] = [
    Factor::Participant,
    Factor::Sample,
    Factor::Speed,
    Factor::Load,
    Factor::Direction,
    Factor::Touch,
];

impl Key {
    fn of(take: &AnalysedRecording) -> Self {
        let condition = take.condition();
        Self {
            sample: condition.sample.clone().unwrap_or_default(),
            // A measured plateau is steady to a mm/s.
            speed: match condition.speed_m_s {
                Some(stated) => speed_text(stated),
                // A hand holds none.
                None if condition.touch == Some(Touch::Active) => String::new(),
                None => take
                    .speed_m_s()
                    .map_or(String::new(), |v| format!("{:.0} mm/s", v * 1e3)),
            },
            participant: condition.participant.clone().unwrap_or_default(),
            touch: match condition.touch {
                Some(Touch::Active) => "active".into(),
                Some(Touch::Passive) => "passive".into(),
                Some(Touch::Resting) => "resting".into(),
                None => String::new(),
            },
            load: condition
                .load_n
                .map_or(String::new(), |load| load.to_string()),
            direction: condition
                .direction
                .map_or(String::new(), |direction| direction.to_string()),
            label: (take.label.as_ref()).map_or(String::new(), |label| label.value.clone()),
            file: take.name.clone(),
        }
    }

    fn part(&mut self, by: Factor) -> &mut String {
        match by {
            Factor::Sample => &mut self.sample,
            Factor::Speed => &mut self.speed,
            Factor::Participant => &mut self.participant,
            Factor::Touch => &mut self.touch,
            Factor::Load => &mut self.load,
            Factor::Direction => &mut self.direction,
            Factor::Label => &mut self.label,
            Factor::File => &mut self.file,
        }
    }

    /// The parts in which the recordings differ, as a person says them.
    fn text(&self, varying: &Self) -> String {
        let parts = [
            (&self.participant, &varying.participant),
            (&self.sample, &varying.sample),
            (&self.speed, &varying.speed),
            (&self.load, &varying.load),
            (&self.direction, &varying.direction),
            (&self.touch, &varying.touch),
        ];
        let known: Vec<&str> = parts
            .into_iter()
            .filter(|(part, varies)| !part.is_empty() && !varies.is_empty())
            .map(|(part, _)| part.as_str())
            .collect();
        known.join(", ")
    }

    /// A key whose parts say something where `keys` differ, and nothing where they all agree.
    fn varying(keys: &[Self]) -> Self {
        let mut varying = Self::default();
        for by in FACTORS {
            let mut values = keys.iter().map(|key| key.clone().part(by).clone());
            let first = values.next();
            if values.any(|value| Some(&value) != first.as_ref()) {
                *varying.part(by) = "varies".into();
            }
        }
        varying
    }
}

fn speed_text(speed_m_s: f64) -> String {
    let text = format!("{:.3}", speed_m_s * 1e3);
    format!("{} mm/s", text.trim_end_matches('0').trim_end_matches('.'))
}

/// Recordings that have one value of what they are grouped by, with their strokes taken together.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Group {
    /// What their strokes say together.
    #[serde(flatten)]
    pub summary: Summary,
    /// Their places among the recordings of the study.
    #[serde(skip)]
    pub takes: Vec<usize>,
    /// Their names.
    pub files: Vec<String>,
    /// The class of their sample by the duplex theory; absent where they have several samples, or one of which nothing is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub duplex: Option<Duplex>,
    /// What strokes of several speeds whose motion was measured say along the way; absent for several samples, and in comparisons.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub way: Option<AlongTheWay>,
}

/// The analysed recordings of a study, by their places.
pub(super) fn analysed(takes: &[AnalysedRecording]) -> Vec<usize> {
    (0..takes.len())
        .filter(|place| takes[*place].analysis.is_some())
        .collect()
}

/// By sample where every analysed recording names one, else each file by itself.
pub(super) fn usual(takes: &[AnalysedRecording]) -> Factor {
    let mut analysed = takes.iter().filter(|take| take.analysis.is_some());
    if analysed.all(|take| take.condition().sample.is_some()) {
        Factor::Sample
    } else {
        Factor::File
    }
}

/// Recordings to be grouped, with what is known of samples and finger and the lines that all recordings have.
pub(super) struct Grouping<'a> {
    pub(super) takes: &'a [AnalysedRecording],
    pub(super) settings: &'a StudySettings,
    pub(super) lines: &'a [CommonLine],
    /// For each recording the lines of which it is not known whether its texture makes them, Hz.
    in_doubt_hz: Vec<Vec<f64>>,
}

/// Groups that differ in one thing and share all others, with what they share as a person says it.
pub(super) type Setting = (String, Vec<Group>);

impl<'a> Grouping<'a> {
    pub(super) fn new(
        takes: &'a [AnalysedRecording],
        settings: &'a StudySettings,
        lines: &'a [CommonLine],
    ) -> Self {
        Self {
            takes,
            settings,
            lines,
            in_doubt_hz: in_doubt_hz(takes),
        }
    }

    /// The lines of which it is not known whether the textures of some recordings make them, Hz, lowest first.
    pub(super) fn in_doubt_hz(&self, places: impl Iterator<Item = usize>) -> Vec<f64> {
        let lines = places.flat_map(|place| &self.in_doubt_hz[place]);
        let mut lines: Vec<f64> = lines.copied().collect();
        lines.sort_by(f64::total_cmp);
        lines.dedup();
        lines
    }

    /// The recordings grouped by one thing.
    pub(super) fn groups(&self, by: Factor) -> Result<Vec<Group>, StudyError> {
        let analysed = analysed(self.takes);
        self.require(&analysed, by)?;
        self.of(&analysed, by, self.settings.ridge_m)
    }

    fn require(&self, places: &[usize], by: Factor) -> Result<(), StudyError> {
        let mut takes = places.iter().map(|place| &self.takes[*place]);
        match takes.find(|take| Key::of(take).part(by).is_empty()) {
            Some(take) => Err(StudyError::Unknown {
                by,
                recording: take.name.clone(),
            }),
            None => Ok(()),
        }
    }

    fn of(
        &self,
        places: &[usize],
        by: Factor,
        ridge_m: Option<f64>,
    ) -> Result<Vec<Group>, StudyError> {
        let mut groups: Vec<(String, Vec<usize>)> = Vec::new();
        for place in places {
            let key = Key::of(&self.takes[*place]).part(by).clone();
            match groups.iter_mut().find(|(other, _)| *other == key) {
                Some((_, members)) => members.push(*place),
                None => groups.push((key, vec![*place])),
            }
        }
        let known = self.all_sets();
        groups.sort_by(|(a, _), (b, _)| order(a, b, by, &known));
        let group = |(key, places): (String, Vec<usize>)| {
            let takes: Vec<&AnalysedRecording> =
                places.iter().map(|place| &self.takes[*place]).collect();
            let members: Vec<_> = takes
                .iter()
                .filter_map(|take| Some((take.analysis.as_ref()?, take.condition())))
                .collect();
            let first = takes.first().and_then(|take| self.known(take));
            let periods = Periods {
                ridge_m,
                texture_m: first.and_then(|sample| sample.wavelength_m),
            };
            let duplex = self.known_of(&places).and_then(SurfaceSample::duplex);
            let mut summary = summarise(&key, &members, periods)?;
            set_apart(
                &mut summary,
                self.lines,
                &self.in_doubt_hz(places.iter().copied()),
            );
            Ok(Group {
                summary,
                files: takes.iter().map(|take| take.name.clone()).collect(),
                takes: places,
                duplex,
                way: None,
            })
        };
        groups.into_iter().map(group).collect()
    }

    /// The sets that are stated, then those of the twin.
    fn all_sets(&self) -> Vec<&SampleSet> {
        let settings = self.settings;
        settings.sets.iter().chain(&settings.twin_sets).collect()
    }

    /// What is known of the sample of a recording: by a set that is stated, or for a recording of the twin by the sets that it touches.
    fn known(&self, take: &AnalysedRecording) -> Option<&SurfaceSample> {
        let name = take.condition().sample.as_deref()?;
        let is_twin = take.recording.about.provenance.bench == Some(BenchKind::Twin);
        let own: &[SampleSet] = match is_twin {
            true => &self.settings.twin_sets,
            false => &[],
        };
        let mut sets = self.settings.sets.iter().chain(own);
        sets.find_map(|set| set.sample(name))
    }

    /// What is known of the sample of recordings that have all one sample.
    pub(super) fn known_of(&self, places: &[usize]) -> Option<&SurfaceSample> {
        let mut all = places.iter().map(|place| self.known(&self.takes[*place]));
        let first = all.next()??;
        all.all(|other| other == Some(first)).then_some(first)
    }

    /// Every set of recordings that differ in `by` and agree in all else.
    pub(super) fn settings(&self, by: Factor) -> Result<Vec<Setting>, StudyError> {
        let analysed = analysed(self.takes);
        self.require(&analysed, by)?;
        // Where active touch has no known speed, speeds do not set active and passive touch apart.
        let mut speeds = analysed.iter().map(|place| self.takes[*place].speed_m_s());
        let all_speeds = speeds.all(|speed| speed.is_some());
        let load_by_load = splits_loads(by) || by == Factor::Sample && self.samples_share_loads();
        let mut settings: Vec<(Key, Vec<usize>)> = Vec::new();
        for place in analysed {
            let mut key = Key::of(&self.takes[place]);
            key.part(by).clear();
            key.file.clear();
            // What is compared with another question takes loads together, with a warning, unless all samples were touched with each.
            if !load_by_load {
                key.load.clear();
            }
            if by == Factor::Touch && !all_speeds {
                key.speed.clear();
            }
            match settings.iter_mut().find(|(other, _)| *other == key) {
                Some((_, members)) => members.push(place),
                None => settings.push((key, vec![place])),
            }
        }
        let sets = &self.all_sets();
        settings.sort_by(|(a, _), (b, _)| {
            order(&a.participant, &b.participant, Factor::Participant, sets)
                .then_with(|| order(&a.sample, &b.sample, Factor::Sample, sets))
                .then_with(|| order(&a.speed, &b.speed, Factor::Speed, sets))
                .then_with(|| order(&a.load, &b.load, Factor::Load, sets))
                .then_with(|| order(&a.direction, &b.direction, Factor::Direction, sets))
                .then_with(|| a.touch.cmp(&b.touch))
        });
        // A recording with nothing to be compared with is no comparison.
        settings.retain(|(_, members)| {
            let value = |place: &usize| Key::of(&self.takes[*place]).part(by).clone();
            let values: Vec<String> = members.iter().map(value).collect();
            values.iter().any(|value| *value != values[0])
        });
        let keys: Vec<Key> = settings.iter().map(|(key, _)| key.clone()).collect();
        let varying = Key::varying(&keys);
        settings
            .into_iter()
            .map(|(key, members)| {
                let groups = self.of(&members, by, self.settings.ridge_m)?;
                Ok((key.text(&varying), groups))
            })
            .collect()
    }

    /// Whether all samples were touched with the same loads, which are known: then they are compared load by load.
    fn samples_share_loads(&self) -> bool {
        let mut loads: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        for place in analysed(self.takes) {
            let Key { sample, load, .. } = Key::of(&self.takes[place]);
            loads.entry(sample).or_default().insert(load);
        }
        let first = loads.values().next();
        let shared = |own: &BTreeSet<String>| Some(own) == first && !own.contains("");
        loads.values().all(shared)
    }

    /// The recordings without strokes that differ from recording number `like` in nothing but the direction.
    pub(super) fn without_strokes(&self, like: usize) -> Vec<usize> {
        let key = |place: usize| {
            let mut key = Key::of(&self.takes[place]);
            key.direction.clear();
            key.file.clear();
            key
        };
        let wanted = key(like);
        (0..self.takes.len())
            .filter(|place| self.takes[*place].analysis.is_none() && key(*place) == wanted)
            .collect()
    }

    /// The analysed recordings of `touch` by sample, each with a counterpart among those of `other` at its speed and by its
    /// participant.
    pub(super) fn with_counterpart(
        &self,
        touch: Touch,
        other: Touch,
    ) -> Result<Vec<Group>, StudyError> {
        let of = |touch: Touch| -> Vec<usize> {
            let mut places = analysed(self.takes);
            places.retain(|place| {
                let condition = self.takes[*place].condition();
                condition.sample.is_some() && condition.touch == Some(touch)
            });
            places
        };
        let others = of(other);
        let mut places = of(touch);
        places.retain(|place| {
            let mut others = others.iter().map(|other| &self.takes[*other]);
            others.any(|other| counterparts(&self.takes[*place], other))
        });
        self.of(&places, Factor::Sample, None)
    }
}

/// The lines that all analysed recordings have.
pub(super) fn lines_of_all(takes: &[AnalysedRecording]) -> Vec<CommonLine> {
    let all = takes.iter().filter_map(|take| lines_of(take, &[]));
    common_lines(&all.collect::<Vec<_>>())
}

/// The lines of the strokes of a recording that is analysed, each with its width, Hz; none where its vibration cannot be filtered again.
fn fine_hz(take: &AnalysedRecording) -> Vec<[f64; 2]> {
    let Some(config) = take.analysis.as_ref().map(|analysis| &analysis.config) else {
        return Vec::new();
    };
    let vibrations = vibrations(&take.recording, &take.segmentation, config.high_pass);
    let Ok(vibrations) = vibrations else {
        return Vec::new();
    };
    let stretches = vibrations.channels.iter().flat_map(|channel| {
        let strokes = take.segmentation.strokes.iter();
        strokes.map(|stroke| stroke.steady.of(channel.as_slice()))
    });
    let stretches = stretches.collect();
    let lowest = Hertz(config.passes_from().0);
    lines_of_strokes(take.recording.rate(), stretches, lowest)
}

fn lines_of<'a>(take: &'a AnalysedRecording, fine_hz: &'a [[f64; 2]]) -> Option<LinesOf<'a>> {
    let analysis = take.analysis.as_ref()?;
    Some(LinesOf {
        sample: take.condition().sample.as_deref()?,
        speed_m_s: take.speed_m_s(),
        psd: &analysis.psd,
        band: analysis.config.band,
        fine_hz,
    })
}

/// For each recording the lines of which it is not known whether its texture makes them, Hz: those that it has at rest, and those that all
/// samples share where nothing but sample and load differ.
fn in_doubt_hz(takes: &[AnalysedRecording]) -> Vec<Vec<f64>> {
    let by = |parts: &[Factor]| {
        let mut groups: Vec<(Key, Vec<usize>)> = Vec::new();
        for place in analysed(takes) {
            let mut key = Key::of(&takes[place]);
            parts.iter().for_each(|part| key.part(*part).clear());
            match groups.iter_mut().find(|(other, _)| *other == key) {
                Some((_, members)) => members.push(place),
                None => groups.push((key, vec![place])),
            }
        }
        groups
    };
    let of_settings = by(&[Factor::Sample, Factor::Load, Factor::File]);
    let mut fine: Vec<Vec<[f64; 2]>> = vec![Vec::new(); takes.len()];
    for (_, places) in &of_settings {
        let sample = |place: usize| &takes[place].condition().sample;
        if places
            .iter()
            .any(|place| sample(*place) != sample(places[0]))
        {
            for place in places {
                fine[*place] = fine_hz(&takes[*place]);
            }
        }
    }
    let of = |places: &[usize]| -> Vec<LinesOf<'_>> {
        let lines = places.iter();
        let lines = lines.filter_map(|place| lines_of(&takes[*place], &fine[*place]));
        lines.collect()
    };
    let all_but = [Factor::Speed, Factor::Load, Factor::Direction, Factor::File];
    let of_samples = by(&all_but).into_iter();
    let of_samples: Vec<Vec<LinesOf<'_>>> = of_samples.map(|(_, places)| of(&places)).collect();
    let mut found = vec![Vec::new(); takes.len()];
    for (_, places) in of_settings {
        let lines = lines_in_doubt(&of(&places), &of_samples);
        for place in places {
            let analysis = takes[place].analysis.iter();
            let at_rest = analysis.flat_map(|analysis| &analysis.rest_lines);
            found[place] = lines.clone();
            found[place].extend(at_rest.map(|line| line.frequency_hz));
        }
    }
    found
}

/// The warning that some analysed recordings stand in no comparison.
pub(super) fn left_out<'a>(
    takes: &[AnalysedRecording],
    compared: impl Iterator<Item = &'a Group> + Clone,
) -> Option<Warning> {
    let held = |place: &usize| compared.clone().any(|group| group.takes.contains(place));
    let names: Vec<&str> = analysed(takes)
        .into_iter()
        .filter(|place| !held(place))
        .map(|place| takes[place].name.as_str())
        .collect();
    (!names.is_empty()).then(|| {
        Warning::from(CompareWarning::Mixed {
            how: Mixed::LeftOut {
                recordings: names.join(", "),
            },
        })
    })
}

/// What the analysed recordings differ in beside `by`.
pub(super) fn differ_in(takes: &[AnalysedRecording], by: Factor) -> Vec<Factor> {
    let keys: Vec<Key> = analysed(takes)
        .into_iter()
        .map(|place| Key::of(&takes[place]))
        .collect();
    let mut varying = Key::varying(&keys);
    let parts = [
        Factor::Sample,
        Factor::Speed,
        Factor::Participant,
        Factor::Load,
        Factor::Direction,
        Factor::Touch,
    ];
    let varies = |part: &Factor| {
        *part != by
            && (*part != Factor::Load || splits_loads(by))
            && !varying.part(*part).is_empty()
    };
    parts.into_iter().filter(varies).collect()
}

/// Whether recordings of several loads stand in comparisons of their own.
fn splits_loads(by: Factor) -> bool {
    matches!(by, Factor::Load | Factor::Direction | Factor::Label)
}

/// Speeds that differ by no more than this share are compared.
const SAME_SPEED: f64 = 0.1;

/// Whether two recordings differ in nothing that they state but the kind of touch.
fn counterparts(a: &AnalysedRecording, b: &AnalysedRecording) -> bool {
    let (a, b) = (a.condition(), b.condition());
    let people =
        a.participant.is_none() || b.participant.is_none() || a.participant == b.participant;
    let speeds = match (a.speed_m_s, b.speed_m_s) {
        (Some(a), Some(b)) => (a / b - 1.0).abs() <= SAME_SPEED,
        _ => true,
    };
    let directions = a.direction.is_none() || b.direction.is_none() || a.direction == b.direction;
    a.sample == b.sample && people && speeds && directions
}

/// Samples in the order of their set, all else as people count: S2 before S10, 5 mm/s before 10 mm/s.
fn order(a: &str, b: &str, by: Factor, sets: &[&SampleSet]) -> Ordering {
    let place = |name: &str| {
        let sets = sets.iter().enumerate();
        let mut places = sets.filter_map(|(i, set)| {
            let mut samples = set.samples.iter();
            Some((i, samples.position(|sample| sample.name == name)?))
        });
        places.next()
    };
    match (place(a), place(b)) {
        (Some(a), Some(b)) if by == Factor::Sample => a.cmp(&b),
        _ if by == Factor::Load => loads(a).total_cmp(&loads(b)),
        _ if by == Factor::Direction => directions(a).cmp(&directions(b)),
        _ => chunks(a).cmp(&chunks(b)),
    }
}

/// The number of a load such as "0.25 N"; infinity for what is none.
fn loads(name: &str) -> f64 {
    let number = name.split_whitespace().next();
    number
        .and_then(|text| text.parse().ok())
        .unwrap_or(f64::INFINITY)
}

/// The place of a direction among all.
fn directions(name: &str) -> usize {
    let mut all = SlidingDirection::ALL.into_iter();
    all.position(|one| one.word() == name).unwrap_or(usize::MAX)
}

/// A name as text and numbers in turn, so that numbers compare as numbers.
fn chunks(name: &str) -> Vec<(String, u64)> {
    let mut found: Vec<(String, u64)> = vec![(String::new(), 0)];
    let mut counting = false;
    for c in name.chars() {
        let Some((text, value)) = found.last_mut() else {
            continue;
        };
        match c.to_digit(10) {
            Some(digit) => {
                *value = value.saturating_mul(10).saturating_add(u64::from(digit));
                counting = true;
            }
            None if counting => {
                found.push((c.to_string(), 0));
                counting = false;
            }
            None => text.push(c),
        }
    }
    found
}
