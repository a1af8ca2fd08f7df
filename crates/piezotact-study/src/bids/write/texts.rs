//! What a data set says in words: the read-me, the columns that every study has, and the tags of events.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use piezotact::number::counted;
use piezotact_people::campaign::dictionary::columns_of;
use serde::Serialize;

use super::super::about::DatasetAbout;
use super::super::json::{Columns, Tags};
use super::Exported;
use super::parts::sidecars;

/// What the program is.
pub(super) const PROGRAM: &str = "The open instrument for the sense of touch: friction-induced vibrations, measured, rendered and verified.";

/// The columns of the tables of sessions.
pub(super) const SESSION_COLUMNS: [&str; 12] = [
    "session_id",
    "acq_time",
    "session",
    "ended",
    "confirmed",
    "planned",
    "stated_sex",
    "age",
    "handedness",
    "finger",
    "language",
    "judge",
];

/// What the answers to a task say of it.
#[derive(Debug, Serialize)]
#[serde(rename_all = "PascalCase")]
pub(super) struct TaskSidecar<'a> {
    pub(super) task_name: &'a str,
    pub(super) task_description: &'a str,
    pub(super) instructions: &'a str,
    pub(super) study: &'a str,
    #[serde(flatten)]
    pub(super) columns: Columns,
}

/// What the kinds of events are; others are as the recording calls them.
fn kind_meaning(kind: &str) -> String {
    match kind {
        "stroke" => "the part of a stroke that is analysed, without landing and take-off".into(),
        "rejected" => "a contact or motion that is no stroke".into(),
        "event" => "an event of the recording; a name that somebody typed is left out".into(),
        other => format!("event `{other}` of the recording"),
    }
}

/// Adds what events of recordings have, of these kinds.
pub(super) fn with_recording_events(columns: &mut Columns, kinds: &BTreeSet<String>) {
    // Playings have no columns of their own.
    if kinds.iter().any(|kind| kind != "stimulus") {
        columns.extend(sidecars(&columns_of("recording_events")));
    }
    with_kinds(columns, kinds);
    let more = [
        (
            "onset",
            " In a table of one recording (acq- and run- in its name): after the first sample of the recording.",
        ),
        ("duration", " In a table of one recording: of the part."),
    ];
    for (name, sentence) in more {
        if let Some(column) = columns.get_mut(name) {
            column.meaning.description.push_str(sentence);
        }
    }
}

/// What events of recordings of these kinds have, where there are no trials.
pub(super) fn of_recording_events(kinds: &BTreeSet<String>) -> Columns {
    let mut columns = sidecars(&columns_of("own_events"));
    columns.extend(sidecars(&columns_of("recording_events")));
    with_kinds(&mut columns, kinds);
    with_tags(&mut columns);
    columns
}

fn with_kinds(columns: &mut Columns, kinds: &BTreeSet<String>) {
    if let Some(column) = columns.get_mut("trial_type") {
        for kind in kinds {
            let levels = &mut column.meaning.levels;
            let meaning = || kind_meaning(kind);
            levels.entry(kind.clone()).or_insert_with(meaning);
        }
    }
}

/// The read-me of what is derived.
pub(super) const DERIVED: &str = "# What was computed of the study

Tables with a JSON file each: its description, the recordings that it was made from (`Sources`), and how (`Provenance`: settings, warnings, verdicts).

- `*_psd`: power spectral density of the friction-induced vibration over strokes. `*_features`: features of each stroke.
- `*_verification`: how close a drive came to the recorded stroke when it was prepared.
- `*_transfer`: transfer function of the device with the participant's finger on it.
- `desc-association_matrix`: association matrices. `desc-adaptive_thresholds`: thresholds of adaptive comparisons.
";

/// The files of what is derived that BIDS has no names for.
pub(super) const NOT_OF_BIDS: &str =
    "*_psd.*\n*_features.*\n*_verification.*\n*_transfer.*\n*_matrix.*\n*_thresholds.*\n";

/// The tag of the place of a stimulus, which tells those apart that were noted at one time.
const OF_ELEMENT: (&str, &str) = ("element", "Label/#");

/// The tags of the kinds of events.
///
/// Source: HED 8.3.0, standard schema.
const TAGS: [(&str, &str); 4] = [
    ("trial", "Experimental-trial"),
    (
        "stimulus",
        "(Measurement-event, Experimental-stimulus, Tactile-presentation, Tactile-vibration, {element})",
    ),
    (
        "stroke",
        "Agent-action, Participant-response, (Touch, Tactile-texture)",
    ),
    ("rejected", "Agent-action, Touch"),
];

/// Adds the tags of those kinds of events that have some.
pub(super) fn with_tags(columns: &mut Columns) {
    if let Some(kind) = columns.get_mut("trial_type") {
        let known = kind.meaning.levels.keys();
        let tags = known.filter_map(|level| {
            let tag = TAGS.iter().find(|(known, _)| known == level)?;
            Some((level.clone(), tag.1.to_owned()))
        });
        kind.hed = Tags::Levels(tags.collect());
    }
    if let Some(element) = columns.get_mut(OF_ELEMENT.0) {
        element.hed = Tags::Every(OF_ELEMENT.1);
    }
}

/// The read-me of a data set.
pub(super) fn readme(
    about: &DatasetAbout<'_>,
    (exported, warnings): (&Exported, &[String]),
) -> String {
    let mut text = format!("# {}\n\n", about.name);
    if let Some(simulated) = about.simulated {
        let _never_fails = writeln!(
            text,
            "**Simulated: no person took part.** Virtual volunteers of a digital twin: {simulated}.\n"
        );
    }
    let [people, recordings] = [
        counted(exported.participants, "participant"),
        counted(exported.recordings, "recording"),
    ];
    let protocol = about.followed.map(|of| of.protocol);
    let _never_fails = match protocol {
        Some(protocol) => writeln!(
            text,
            "A study of touch with {people} in {}: {recordings}, {} and {}. Protocol: {} ({}), written whole in `sourcedata/protocol.toml`.\n",
            counted(exported.sessions, "session"),
            counted(exported.eeg_recordings, "EEG recording"),
            counted(exported.answers, "answer"),
            protocol.name,
            protocol.source
        ),
        None => writeln!(
            text,
            "Recordings of touch: {recordings} of {people}, without sessions, as no campaign was led.\n"
        ),
    };
    if !(about.warnings.is_empty() && warnings.is_empty()) {
        text.push_str("## What to know before relying on it\n\n");
        for warning in about.warnings.iter().chain(warnings) {
            let _never_fails = writeln!(text, "- {warning}");
        }
        text.push('\n');
    }
    if let Some(protocol) = protocol {
        text.push_str("## Tasks\n\n");
        for task in &protocol.tasks {
            let _never_fails = writeln!(
                text,
                "- `{}`: {}. {}",
                task.name, task.title, task.instruction
            );
        }
        text.push('\n');
    }
    text.push_str(match protocol {
        Some(_) => OF_STUDY,
        None => OF_RECORDINGS,
    });
    text.push_str("\n## What this data set does not carry\n\n");
    for what in &exported.not_carried {
        let _never_fails = writeln!(text, "- {what}");
    }
    text
}

/// Where what is in the data set of a study.
const OF_STUDY: &str = "## Where what is\n\n\
    - `sub-*/ses-*/beh/*_physio.tsv.gz`: acceleration and forces of a finger, one column a channel, described in the JSON file beside; `*_stim.tsv.gz`: the drive as it was recorded while it was played. `acq-` is the sample or stimulus, `run-` the number of the recording.\n\
    - `*_events.tsv` with `acq-` and `run-`: the strokes, or the onset of the stimulus, in that recording. Without, or with `acq-trials`: the trials of the task, with onsets after the beginning of the session, and the stimuli that were played in them.\n\
    - `sub-*/ses-*/eeg/`: EEG as BrainVision files, with channels, events (their exact onsets) and template positions of the electrodes.\n\
    - `*_beh.tsv`: the answers. `expected` is the right answer, `offered` what could be answered.\n\
    - `stimuli/`: the files of the drives that were played.\n\
    - `sourcedata/`: recordings as they were made, bit by bit, the protocol, and SHA256SUMS of all files but read-mes and `dataset_description.json` (`cd sourcedata && sha256sum -c SHA256SUMS`).\n\
    - `derivatives/piezotact/`: what was computed, with settings and sources.\n";

/// Where what is in the data set of recordings without a campaign.
const OF_RECORDINGS: &str = "## Where what is\n\n\
    - `sub-*/beh/*_physio.tsv.gz`: acceleration and forces of a finger, one column a channel, described in the JSON file beside; `*_stim.tsv.gz`: the drive as it was recorded while it was played. `acq-` is the sample, `run-` the number of the recording.\n\
    - `*_events.tsv`: the strokes, and the events that the recording states, after its first sample.\n\
    - `sourcedata/`: recordings as they were made, bit by bit, where they state neither date nor label, and SHA256SUMS of all files but read-mes and `dataset_description.json` (`cd sourcedata && sha256sum -c SHA256SUMS`).\n\
    - `derivatives/piezotact/`: what was computed, with settings and sources.\n";
