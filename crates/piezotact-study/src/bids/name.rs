//! Names of files: entities, suffix, ending.

use std::fmt;

/// The recording with the acceleration of the finger: the label in names of files.
pub(super) const RECORDING_FIV: &str = "fiv";

/// The suffix of drives.
pub(super) const STIM: &str = "stim";

/// The label of the events of a session, beside which recordings have events with onsets of their own.
pub(super) const TRIALS: &str = "trials";

/// All entities in the order in which names have them.
///
/// Source: BIDS 1.11, schema `rules.entities` and `objects.entities`.
const ORDER: [&str; 38] = [
    "sub",
    "tpl",
    "ses",
    "cohort",
    "sample",
    "task",
    "tracksys",
    "acq",
    "nuc",
    "voi",
    "ce",
    "trc",
    "stain",
    "rec",
    "dir",
    "run",
    "mod",
    "echo",
    "flip",
    "inv",
    "mt",
    "part",
    "proc",
    "hemi",
    "space",
    "split",
    "recording",
    "chunk",
    "atlas",
    "seg",
    "scale",
    "res",
    "den",
    "label",
    "desc",
    "stim",
    "meas",
    "phase",
];

/// The folders of data.
pub(super) const DATATYPES: [&str; 15] = [
    "anat", "beh", "dwi", "eeg", "emg", "fmap", "func", "ieeg", "meg", "micr", "motion", "mrs",
    "nirs", "perf", "pet",
];

/// The entities of one of our files, by their labels.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Entities {
    pub sub: String,
    pub ses: Option<String>,
    pub task: Option<String>,
    /// The condition: the sample or stimulus.
    pub acq: Option<String>,
    /// The number of the run, from 1.
    pub run: Option<u32>,
    /// Which of the recordings that run together.
    pub recording: Option<String>,
    /// The description of a derived file.
    pub desc: Option<String>,
}

impl Entities {
    /// The folder of the session, from the root.
    #[must_use]
    pub fn folder(&self) -> String {
        match &self.ses {
            Some(ses) => format!("sub-{}/ses-{ses}", self.sub),
            None => format!("sub-{}", self.sub),
        }
    }

    /// The same of the session as a whole, where recordings of the task have events of their own.
    pub(super) fn of_session(&self) -> Self {
        Self {
            acq: Some(TRIALS.to_owned()),
            ..self.clone()
        }
    }

    /// The file with this suffix and ending in the folder `beh`, from the root.
    pub(super) fn file(&self, suffix: &str, ending: &str) -> String {
        self.file_in("beh", suffix, ending)
    }

    /// The file with this suffix and ending in the folder of a kind of data, from the root.
    pub(super) fn file_in(&self, datatype: &str, suffix: &str, ending: &str) -> String {
        format!("{}/{datatype}/{self}_{suffix}.{ending}", self.folder())
    }
}

impl fmt::Display for Entities {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "sub-{}", self.sub)?;
        let run = self.run.map(|run| run.to_string());
        let others = [
            ("ses", &self.ses),
            ("task", &self.task),
            ("acq", &self.acq),
            ("run", &run),
            ("recording", &self.recording),
            ("desc", &self.desc),
        ];
        for (key, label) in others {
            if let Some(label) = label {
                write!(f, "_{key}-{label}")?;
            }
        }
        Ok(())
    }
}

/// The name of a file, in its parts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Parsed {
    pub(super) entities: Vec<(String, String)>,
    pub(super) suffix: String,
    /// Without the dot: `tsv.gz`.
    pub(super) ending: String,
}

impl Parsed {
    /// The parts of `name`; a sentence that says what is wrong with it.
    pub(super) fn of(name: &str) -> Result<Self, String> {
        let Some((stem, ending)) = name.split_once('.') else {
            return Err("expected an ending such as .tsv, found none".into());
        };
        let mut parts: Vec<&str> = stem.split('_').collect();
        let suffix = parts.pop().unwrap_or_default();
        if suffix.is_empty() || !suffix.chars().all(|sign| sign.is_ascii_alphanumeric()) {
            return Err(format!(
                "expected a suffix of letters and digits, such as events, found `{suffix}`"
            ));
        }
        let mut entities: Vec<(String, String)> = Vec::new();
        let mut last = 0;
        for part in parts {
            let Some((key, label)) = part.split_once('-') else {
                return Err(format!(
                    "expected entities such as task-NAME between underscores, found `{part}`"
                ));
            };
            let fits = |sign: char| sign.is_ascii_alphanumeric() || sign == '+';
            if label.is_empty() || !label.chars().all(fits) {
                return Err(format!(
                    "expected letters and digits behind {key}-, found `{label}`"
                ));
            }
            let Some(place) = ORDER.iter().position(|known| *known == key) else {
                return Err(format!(
                    "expected an entity that BIDS knows, such as task or run, found `{key}`"
                ));
            };
            if let Some((before, _)) = entities.last()
                && place <= last
            {
                return Err(match before == key {
                    true => format!("expected the entity {key} once, found it twice"),
                    false => format!("expected {key} before {before}, found it behind"),
                });
            }
            last = place;
            entities.push((key.to_owned(), label.to_owned()));
        }
        Ok(Self {
            entities,
            suffix: suffix.to_owned(),
            ending: ending.to_owned(),
        })
    }

    /// The label of an entity.
    pub(super) fn label(&self, key: &str) -> Option<&str> {
        let mut found = self.entities.iter();
        found
            .find(|(known, _)| known == key)
            .map(|(_, label)| label.as_str())
    }

    /// What is wrong with such a file in the folder of `datatype`.
    pub(super) fn fault_in(&self, datatype: &str) -> Option<String> {
        let tables = ["tsv", "json"];
        let signals = ["tsv.gz", "json"];
        let (endings, others): (&[&str], &[&str]) = match (datatype, self.suffix.as_str()) {
            (_, "physio" | "stim" | "physioevents") => {
                (&signals, &["task", "acq", "run", "recording"])
            }
            (_, "events") => (
                &tables,
                &[
                    "task", "acq", "run", "ce", "rec", "dir", "trc", "echo", "tracksys",
                ],
            ),
            ("beh", "beh") => (&tables, &["task", "acq", "run"]),
            ("beh", other) => {
                return Some(format!(
                    "expected the suffix beh, events, physio or stim in the folder beh, found `{other}`"
                ));
            }
            _ => return None,
        };
        if !endings.contains(&self.ending.as_str()) {
            return Some(format!(
                "expected a name that ends in .{}, found .{}",
                endings.join(" or ."),
                self.ending
            ));
        }
        if datatype != "beh" {
            return None;
        }
        if self.label("task").is_none() {
            return Some("expected the entity task, found none".into());
        }
        let mut keys = self.entities.iter().map(|(key, _)| key.as_str());
        let odd = keys.find(|key| !["sub", "ses"].contains(key) && !others.contains(key));
        let odd = odd.map(|key| format!("expected no entity {key} for {}, found one", self.suffix));
        let run = self.label("run");
        let run = run.filter(|run| !run.chars().all(|sign| sign.is_ascii_digit()));
        odd.or_else(|| run.map(|run| format!("expected a number behind run-, found `{run}`")))
    }

    /// The entities but `recording`: what belongs together has the same.
    pub(super) fn together(&self) -> Vec<(&str, &str)> {
        let all = self.entities.iter();
        let all = all.filter(|(key, _)| key != "recording");
        all.map(|(key, label)| (key.as_str(), label.as_str()))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn our_names_are_read_as_they_are_written() {
        let of = Entities {
            sub: "P01".into(),
            ses: Some("measurement".into()),
            task: Some("measure".into()),
            acq: Some("S2".into()),
            run: Some(1),
            recording: Some("fiv".into()),
            desc: None,
        };
        let path = of.file("physio", "tsv.gz");
        assert_eq!(
            path,
            "sub-P01/ses-measurement/beh/sub-P01_ses-measurement_task-measure_acq-S2_run-1_recording-fiv_physio.tsv.gz"
        );
        let parsed = Parsed::of(path.rsplit('/').next().unwrap()).unwrap();
        assert_eq!(parsed.label("acq"), Some("S2"));
        assert_eq!(
            (parsed.suffix.as_str(), parsed.ending.as_str()),
            ("physio", "tsv.gz")
        );
        assert_eq!(parsed.fault_in("beh"), None);
    }

    #[test]
    fn names_that_are_none_of_bids_are_refused_with_the_reason() {
        for (name, part) in [
            ("sub-01_task-a_run-1_acq-b_physio.tsv.gz", "acq before run"),
            ("sub-01_task-a_task-b_events.tsv", "task once"),
            ("sub-01_tsk-a_events.tsv", "`tsk`"),
            ("sub-01_task-a-b_events.tsv", "`a-b`"),
            ("sub-01_events-raw.tsv", "suffix"),
            ("sub-01 task-a_events.tsv", "letters and digits"),
            ("notes", "ending"),
        ] {
            let said = Parsed::of(name).unwrap_err();
            assert!(said.contains(part), "{name}: {said}");
        }
        for (name, part) in [
            ("sub-01_task-a_physio.tsv", ".tsv.gz"),
            ("sub-01_beh.tsv", "task"),
            ("sub-01_task-a_recording-x_events.tsv", "recording"),
            ("sub-01_task-a_run-x_events.tsv", "number"),
            ("sub-01_task-a_answers.tsv", "`answers`"),
        ] {
            let said = Parsed::of(name).unwrap().fault_in("beh").unwrap();
            assert!(said.contains(part), "{name}: {said}");
        }
    }
}
