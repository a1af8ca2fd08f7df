//! Values that were derived.

use std::collections::BTreeMap;

use piezotact::page::Table;
use piezotact_people::campaign::dictionary::ColumnMeaning;

use super::super::error::BidsError;
use super::super::label_of;
use super::super::name::{Entities, Parsed};
use super::super::table::tsv_text;
use super::parts::texts_carried;
use super::{BidsWriter, DERIVATIVES, PARTICIPANT, SAMPLE, TASK};

/// A value that was derived, with the recordings that it was made from.
#[derive(Clone, Debug)]
pub struct Derived<'a> {
    /// Whose it is, with the session where there are sessions; absent for one of the whole study.
    pub of: Option<(&'a str, Option<&'a str>)>,
    pub task: Option<&'a str>,
    /// The sample or stimulus.
    pub sample: Option<&'a str>,
    /// What it is, in one word: `average`.
    pub desc: &'a str,
    /// Its kind, in one word: `psd`.
    pub suffix: &'a str,
    /// The value as a table.
    pub table: &'a Table,
    /// What its columns mean.
    pub columns: BTreeMap<String, ColumnMeaning>,
    /// What it is, in a sentence.
    pub description: &'a str,
    /// How it was made: settings, warnings and verdicts, as its document has them.
    pub provenance: serde_json::Value,
    /// What it was made from.
    pub sources: Sources<'a>,
}

/// What a value was made from.
#[derive(Clone, Copy, Debug)]
pub enum Sources<'a> {
    /// Files, re the folder of its session.
    Session(&'a [String]),
    /// The drive of its stimulus.
    Drive,
    /// All answers.
    Answers,
}

impl BidsWriter<'_> {
    /// Adds a value that was derived.
    ///
    /// # Errors
    /// [`BidsError::Write`], [`BidsError::Text`], and those of labels.
    pub fn derived(&mut self, derived: &Derived<'_>) -> Result<(), BidsError> {
        let mut of = Entities {
            desc: label_of(derived.desc),
            ..Entities::default()
        };
        if let Some(task) = derived.task {
            of.task = Some(self.labels[TASK].label(task)?);
        }
        if let Some(sample) = derived.sample {
            of.acq = Some(self.labels[SAMPLE].label(sample)?);
        }
        let stem = match derived.of {
            Some((participant, session)) => {
                of.sub = self.labels[PARTICIPANT].label(participant)?;
                of.ses = self.session_label(session)?;
                of.run = match derived.sources {
                    Sources::Session([file]) => run_of(file),
                    _ => self.repeated(&of, derived.suffix),
                };
                format!("{DERIVATIVES}/{}/beh/{of}_{}", of.folder(), derived.suffix)
            }
            None => {
                let text = of.to_string();
                let without = text.trim_start_matches("sub-").trim_start_matches('_');
                format!("{DERIVATIVES}/{without}_{}", derived.suffix)
            }
        };
        let file = format!("{stem}.tsv");
        self.folder
            .put_text(&file, &tsv_text(derived.table, &file)?)?;
        let mut sidecar = serde_json::Map::new();
        sidecar.insert("Description".into(), derived.description.into());
        let sources: Vec<String> = match derived.sources {
            Sources::Session(files) => (files.iter())
                .map(|file| format!("bids:study:{}/{file}", of.folder()))
                .collect(),
            Sources::Drive => self.drives_of(&of),
            Sources::Answers => (self.scans.values().flatten())
                .filter(|(name, _)| name.ends_with("_beh.tsv"))
                .map(|(name, _)| format!("bids:study:{}", beside(name)))
                .collect(),
        };
        sidecar.insert("Sources".into(), sources.into());
        sidecar.insert("Provenance".into(), texts_carried(&derived.provenance));
        let has = |name: &String| derived.table.columns.iter().any(|one| one.name == *name);
        for (name, meaning) in derived.columns.iter().filter(|(name, _)| has(name)) {
            sidecar.insert(
                name.clone(),
                serde_json::to_value(meaning).unwrap_or_default(),
            );
        }
        self.folder.put_json(&format!("{stem}.json"), &sidecar)
    }

    /// The number of a value that is of no one recording, where it is not the first of its kind.
    fn repeated(&mut self, of: &Entities, suffix: &str) -> Option<u32> {
        let key = (of.clone(), suffix.to_owned());
        let counted = self.kinds_derived.entry(key).or_default();
        *counted += 1;
        (*counted > 1).then_some(*counted)
    }

    /// The drive of a stimulus, as a URI.
    fn drives_of(&self, of: &Entities) -> Vec<String> {
        let label = of.acq.as_deref().unwrap_or_default();
        let file = format!("stimuli/{}/{label}_drive.wav", of.folder());
        let is_there = self.folder.has(&file);
        is_there
            .then(|| format!("bids:study:{file}"))
            .into_iter()
            .collect()
    }
}

/// The run of the recording whose file is `name`: what is derived of it has the same.
fn run_of(name: &str) -> Option<u32> {
    let file = name.rsplit('/').next()?;
    Parsed::of(file).ok()?.label("run")?.parse().ok()
}

/// The file `name` of the folder `beh`, from the root: its name says whose it is.
fn beside(name: &str) -> String {
    let file = name.rsplit('/').next().unwrap_or_default();
    let mut parts = file.split('_');
    let sub = parts.next().unwrap_or_default();
    let ses = parts.next().unwrap_or_default();
    format!("{sub}/{ses}/{name}")
}
