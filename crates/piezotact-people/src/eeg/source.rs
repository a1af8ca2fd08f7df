//! What a file of EEG holds: parts without a gap, kinds of channels, markers and tasks.

use std::collections::BTreeMap;
use std::fmt;

use piezotact::Warning;
use piezotact::integrity::holds_codes;
use piezotact::quantity::{Seconds, Unit};
use piezotact::recording::{BenchKind, Event, EventValue, Recording, RecordingWarning, Simulated};
use piezotact::warning::Warnings;
use serde::{Deserialize, Serialize};

use super::reference::Montage;

/// The kind of a marker with which a task begins; its value is the name of the task.
const TASK: &str = "task";

/// A part of a recording without a gap.
#[derive(Clone, Copy, Debug)]
pub struct Segment<'a> {
    /// Its channels and the events from its first sample on.
    pub recording: &'a Recording,
    /// The time of its first sample from that of the file, s.
    pub start_s: Seconds,
    /// The index of the sample of each event, from the first one of the segment.
    pub event_samples: &'a [i64],
    /// What a table beside the file states of its channels; empty where there is none.
    pub stated: &'a [StatedChannel],
}

/// What was found in the file, each once, and whether the twin made it.
pub(super) fn warnings_of(segments: &[Segment<'_>]) -> Vec<Warning> {
    let simulated = segments
        .iter()
        .any(|one| one.recording.about.provenance.bench == Some(BenchKind::Twin));
    let twin = RecordingWarning::Simulated {
        by: Simulated::Twin,
    };
    let simulated = simulated.then(|| twin.into());
    let of_segments = segments
        .iter()
        .flat_map(|one| &one.recording.about.warnings);
    let all: Warnings = simulated.into_iter().chain(of_segments.cloned()).collect();
    all.into()
}

/// What a table states of a channel (BIDS `_channels.tsv`).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StatedChannel {
    pub name: String,
    /// What it records; absent where the table does not say.
    pub kind: Option<SignalKind>,
    /// Whether its status is bad.
    pub is_bad: bool,
}

impl StatedChannel {
    /// A row of the table: `kind` is the `type` of BIDS ("EEG", "VEOG"), `status` is "good", "bad" or nothing.
    ///
    /// Source: BIDS 1.10.1, electroencephalography, `_channels.tsv`.
    #[must_use]
    pub fn of_bids(name: &str, kind: Option<&str>, status: Option<&str>) -> Self {
        let kind = kind.map(str::to_ascii_uppercase);
        let kind = kind.as_deref().and_then(|kind| match kind {
            "EEG" => Some(SignalKind::Eeg),
            "EOG" | "HEOG" | "VEOG" | "EYEGAZE" | "PUPIL" => Some(SignalKind::Eye),
            "EMG" => Some(SignalKind::Muscle),
            "ECG" => Some(SignalKind::Heart),
            "TRIG" => Some(SignalKind::Trigger),
            "" | "N/A" => None,
            _ => Some(SignalKind::Other),
        });
        Self {
            name: name.to_owned(),
            kind,
            is_bad: status.is_some_and(|status| status.eq_ignore_ascii_case("bad")),
        }
    }
}

impl Segment<'_> {
    /// What a channel records: as the table beside the file states, or by its name and unit.
    #[must_use]
    pub fn kind_of(&self, name: &str, unit: &Unit) -> SignalKind {
        let stated = self.stated.iter().find(|stated| stated.name == name);
        let kind = stated.and_then(|stated| stated.kind);
        kind.unwrap_or_else(|| SignalKind::of(name, unit))
    }

    /// The channels with the name of a position of the 10-10 system in a unit that is not known here, by that unit.
    #[must_use]
    pub fn electrodes_in_other_units(&self) -> BTreeMap<String, Vec<String>> {
        let names: Vec<String> = (self.recording.channels().iter())
            .map(|channel| channel.name.clone())
            .collect();
        let known = Montage::known(&names);
        let mut found = BTreeMap::<String, Vec<String>>::new();
        for (channel, known) in self.recording.channels().iter().zip(known) {
            if let (Some(_), Unit::Other(unit)) = (known, &channel.unit)
                && self.kind_of(&channel.name, &channel.unit) == SignalKind::Other
            {
                let unit = match unit.as_str() {
                    "" => "no unit".to_owned(),
                    unit => unit.to_owned(),
                };
                found.entry(unit).or_default().push(channel.name.clone());
            }
        }
        found
    }

    /// The channels that are no electrodes, each with its kind in brackets: those among `names`, and the others.
    #[must_use]
    pub fn no_electrodes(&self, names: &[String]) -> [Vec<String>; 2] {
        let channels = self.recording.channels().iter().filter_map(|channel| {
            let kind = self.kind_of(&channel.name, &channel.unit);
            let text = format!("{} ({})", channel.name, kind.word());
            (kind != SignalKind::Eeg).then(|| (names.contains(&channel.name), text))
        });
        let (among, others): (Vec<_>, Vec<_>) = channels.partition(|(is_among, _)| *is_among);
        [among, others].map(|all| all.into_iter().map(|(_, text)| text).collect())
    }

    /// Whether the table beside the file calls a channel bad.
    #[must_use]
    pub fn is_bad(&self, name: &str) -> bool {
        let mut stated = self.stated.iter();
        stated.any(|stated| stated.name == name && stated.is_bad)
    }
}

/// What a channel of an EEG file records.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum SignalKind {
    /// An electrode on the scalp.
    Eeg,
    /// Eye movements: EOG.
    Eye,
    /// Muscles: EMG.
    Muscle,
    /// The heart: ECG.
    Heart,
    /// Trigger codes.
    Trigger,
    /// Something else, such as a force.
    Other,
}

impl SignalKind {
    /// What a channel of this name and unit records: names of the 10-10 system are electrodes; EOG, EMG, ECG and triggers are known by
    /// their names; another channel in V is taken for an electrode.
    #[must_use]
    pub fn of(name: &str, unit: &Unit) -> Self {
        let upper = name.to_ascii_uppercase();
        let has = |parts: &[&str]| parts.iter().any(|part| upper.contains(part));
        if holds_codes(name) || upper.starts_with("STI") {
            return Self::Trigger;
        }
        // Inputs of amplifiers beside the electrodes: DC01, EXG1, AUX2, REF, DIG.
        let beside = [
            "DC", "EXG", "AUX", "REF", "DIG", "GSR", "RESP", "PLETH", "TEMP", "ACC",
        ];
        let behind = |word: &str| {
            let rest = upper.strip_prefix(word);
            rest.is_some_and(|rest| !rest.starts_with(|sign: char| sign.is_ascii_alphabetic()))
        };
        if beside.iter().any(|word| behind(word)) {
            return Self::Other;
        }
        if *unit != Unit::Volt {
            return Self::Other;
        }
        if has(&["EOG"]) {
            return Self::Eye;
        }
        if has(&["EMG"]) {
            return Self::Muscle;
        }
        if has(&["ECG", "EKG"]) {
            return Self::Heart;
        }
        Self::Eeg
    }

    /// Its word: "EEG".
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Eeg => "EEG",
            Self::Eye => "EOG",
            Self::Muscle => "EMG",
            Self::Heart => "ECG",
            Self::Trigger => "trigger",
            Self::Other => "other",
        }
    }
}

impl fmt::Display for SignalKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.word())
    }
}

/// Whether channels are called by the layouts of letters and numbers (A1 to A32, B1 to B32, C1 …) of 128 and more electrodes, whose C3 is
/// not that of the 10-10 system.
///
/// Source: the caps of `BioSemi`, whose names run from A1 to H32; A and B have no numbers above 2 in the 10-10 system.
#[must_use]
pub fn is_lettered(names: &[String]) -> bool {
    let of = |letter: char| {
        let own = names.iter().filter_map(|name| {
            let number = name.trim().strip_prefix(letter)?.parse::<u8>().ok()?;
            (number > 2).then_some(number)
        });
        own.count()
    };
    of('A') > 2 && of('B') > 2
}

/// Words with single spaces: "S  1" is "S 1".
fn spaced(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The name of a marker: its kind, and its value behind a slash, as in "Stimulus/S 1".
///
/// Source: docs/decisions/eeg.md.
#[must_use]
pub fn marker_name(event: &Event) -> String {
    match &event.value {
        Some(value) => format!("{}/{}", spaced(&event.kind), spaced(&value.to_string())),
        None => spaced(&event.kind),
    }
}

/// Whether an event is the one called `wanted`: by its whole name, its kind or its value.
///
/// Source: docs/decisions/eeg.md.
#[must_use]
pub fn is_marker(event: &Event, wanted: &str) -> bool {
    let wanted = spaced(wanted);
    let (kind, value) = kind_and_value(event);
    marker_name(event) == wanted || kind == wanted || value == Some(wanted)
}

/// The kind of an event and its value. Formats without values write both as one text: `control/BIO`.
pub(super) fn kind_and_value(event: &Event) -> (String, Option<String>) {
    match (&event.value, event.kind.split_once('/')) {
        (Some(value), _) => (spaced(&event.kind), Some(spaced(&value.to_string()))),
        (None, Some((kind, value))) => (spaced(kind), Some(spaced(value))),
        (None, None) => (spaced(&event.kind), None),
    }
}

/// Whether an event says that what it lasts for is not to be used: its name begins with BAD, as those of MNE do.
pub(super) fn is_bad_part(event: &Event) -> bool {
    let begins = |text: &str| {
        let start = text.trim().get(..3);
        start.is_some_and(|start| start.eq_ignore_ascii_case("bad"))
    };
    let value = event.value.as_ref().map(ToString::to_string);
    event.duration_s.0 > 0.0 && (begins(&event.kind) || value.is_some_and(|value| begins(&value)))
}

/// The task that an event begins: of a marker `task` with its name as the value, or `task/NAME`.
///
/// Source: docs/decisions/eeg.md.
#[must_use]
pub fn task_of(event: &Event) -> Option<String> {
    if event.kind.eq_ignore_ascii_case(TASK) {
        return match &event.value {
            Some(EventValue::Text(name)) => Some(spaced(name)),
            Some(EventValue::Number(number)) => Some(number.to_string()),
            None => None,
        };
    }
    // Formats that have no values put the name of a comment into its text.
    let text = match (&event.value, event.kind.as_str()) {
        (Some(EventValue::Text(text)), "Comment") => text,
        (None, kind) => kind,
        _ => return None,
    };
    let (kind, name) = text.split_once(['/', ':', '='])?;
    let is_task = kind.trim().eq_ignore_ascii_case(TASK) && !name.trim().is_empty();
    is_task.then(|| spaced(name))
}

/// Every marker of `segments` with how often it stands.
///
/// Source: docs/decisions/eeg.md.
#[must_use]
pub fn markers(segments: &[Segment<'_>]) -> BTreeMap<String, usize> {
    let mut found = BTreeMap::new();
    for event in events(segments) {
        *found.entry(marker_name(event)).or_default() += 1;
    }
    found
}

/// The tasks that markers of `segments` name, in their order, each once.
///
/// Source: docs/decisions/eeg.md.
#[must_use]
pub fn tasks(segments: &[Segment<'_>]) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    for task in events(segments).filter_map(task_of) {
        if !found.contains(&task) {
            found.push(task);
        }
    }
    found
}

/// When the markers called `wanted` stand, from the first sample of the file, s, ascending, each time once.
///
/// Source: docs/decisions/eeg.md.
#[must_use]
pub fn times_of(segments: &[Segment<'_>], wanted: &str) -> Vec<f64> {
    let mut times: Vec<f64> = segments
        .iter()
        .flat_map(|segment| {
            let events = segment.recording.annotations.events.iter();
            let own = events.filter(|event| is_marker(event, wanted));
            own.map(|event| segment.start_s.0 + event.onset_s.0)
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
    times
}

pub(super) fn events<'a>(segments: &'a [Segment<'_>]) -> impl Iterator<Item = &'a Event> {
    let all = segments.iter();
    let all = all.flat_map(|segment| &segment.recording.annotations.events);
    all.filter(|event| !is_boundary(event))
}

/// Whether an event only says that a part begins (`New Segment` of `BrainVision`, `boundary` of EEGLAB).
fn is_boundary(event: &Event) -> bool {
    matches!(event.kind.as_str(), "New Segment" | "boundary")
}

/// Who and what a recording is of.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Subject {
    /// The participant's pseudonym.
    pub participant: String,
    /// The task.
    pub task: String,
}

impl fmt::Display for Subject {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "participant {}, task {}", self.participant, self.task)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn event(kind: &str, value: Option<&str>) -> Event {
        Event {
            onset_s: Seconds(0.0),
            duration_s: Seconds(0.0),
            kind: kind.into(),
            value: value.map(|text| EventValue::Text(text.into())),
        }
    }

    #[test]
    fn markers_have_the_names_that_people_type() {
        let stimulus = event("Stimulus", Some("S  1"));
        assert_eq!(marker_name(&stimulus), "Stimulus/S 1");
        for wanted in ["Stimulus", "S  1", "S 1", "Stimulus/S 1", "Stimulus/S  1"] {
            assert!(is_marker(&stimulus, wanted), "{wanted}");
        }
        assert!(!is_marker(&stimulus, "S 2") && !is_marker(&stimulus, "S"));
        // An annotation of EDF, which has no value of its own.
        let text = event("control/BIO", None);
        for wanted in ["control", "BIO", "control/BIO"] {
            assert!(is_marker(&text, wanted), "{wanted}");
        }
        for (event, task) in [
            (event("task", Some("control")), Some("control")),
            (event("Comment", Some("task: imagery")), Some("imagery")),
            (event("task/natural touch", None), Some("natural touch")),
            (event("task", None), None),
            (event("touch", None), None),
        ] {
            assert_eq!(task_of(&event).as_deref(), task);
        }
    }

    #[test]
    fn kinds_follow_from_names_and_units() {
        for (name, unit, kind) in [
            ("C3", Unit::Volt, SignalKind::Eeg),
            ("EEG 001", Unit::Volt, SignalKind::Eeg),
            ("VEOG", Unit::Volt, SignalKind::Eye),
            ("EMG-left", Unit::Volt, SignalKind::Muscle),
            ("Status", Unit::Volt, SignalKind::Trigger),
            ("ECG", Unit::Volt, SignalKind::Heart),
            ("TRIG", Unit::Volt, SignalKind::Trigger),
            ("DC01", Unit::Volt, SignalKind::Other),
            ("REF_EEG", Unit::Volt, SignalKind::Other),
            ("EXG1", Unit::Volt, SignalKind::Other),
            ("force", Unit::parse("N").0, SignalKind::Other),
        ] {
            assert_eq!(SignalKind::of(name, &unit), kind, "{name}");
        }
        let positioned = |name: &str| Montage::ten_ten(&[name.to_owned()]).is_ok();
        assert!(positioned("t3") && !positioned("EEG 001"));
        let lettered = |letters: &str| -> Vec<String> {
            let of = |letter| (1..=32).map(move |number| format!("{letter}{number}"));
            letters.chars().flat_map(of).collect()
        };
        let caps = lettered("ABCD");
        assert!(is_lettered(&caps) && !is_lettered(&lettered("FC")));
        // C3 of such a cap is not over the sensorimotor cortex.
        assert!(Montage::known(&caps).iter().all(Option::is_none));
        assert!(Montage::ten_ten(&caps).is_err());
    }
}
