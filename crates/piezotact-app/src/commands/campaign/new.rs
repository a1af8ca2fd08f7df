//! `piezotact campaign new`: makes a study.

use piezotact_study::store::StudyError;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use anyhow::anyhow;
use clap::Args;
use piezotact_dataset::read_input_text;
use piezotact_people::campaign::protocol::Protocol;
use piezotact_study::store::{DatabaseUrl, NewCampaign, Pseudonym, StudyCampaign};

use super::protocol_text;
use super::run::require_names;
use crate::failure::{Failure, Outcome, usage};
use crate::output::{print, say};

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// The folder of the study, which is made.
    #[arg(value_name = "STUDY")]
    study: PathBuf,
    /// The protocol: a file, or a name of the library.
    #[arg(long)]
    protocol: PathBuf,
    /// The seed of all draws.
    #[arg(long)]
    seed: u64,
    /// The text that participants consent to, shown before each session.
    #[arg(long, value_name = "TEXT")]
    consent: Option<PathBuf>,
    /// Who belongs to a panel from which the campaign is disjoint: its name in the protocol and a file with one pseudonym a line.
    #[arg(long, value_name = "NAME=FILE")]
    panel: Vec<PanelFile>,
    /// The PostgreSQL database that keeps sessions and answers, where several stations share the study; default: a file in the folder.
    /// The password is that of PGPASSWORD or ~/.pgpass.
    #[arg(long, value_name = "URL")]
    store: Option<String>,
}

/// A panel with the file of its members.
#[derive(Clone, Debug)]
struct PanelFile {
    name: String,
    file: PathBuf,
}

impl FromStr for PanelFile {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once('=') {
            Some((name, file)) if !name.is_empty() && !file.is_empty() => Ok(Self {
                name: name.to_owned(),
                file: file.into(),
            }),
            _ => Err(format!("expected NAME=FILE, found `{text}`")),
        }
    }
}

/// The address of a database. Read here, as the parser of the command line would repeat a password that stands in it.
pub(super) fn database_url(text: &str) -> Outcome<DatabaseUrl> {
    text.parse().map_err(usage::<StudyError>)
}

pub(crate) fn run(args: &Arguments) -> Outcome {
    let (protocol, text) = protocol_text(&args.protocol)?;
    let consent = args.consent.as_deref().map(read_input_text).transpose()?;
    if consent.as_ref().is_some_and(|text| text.trim().is_empty()) {
        return Err(usage(anyhow!(
            "expected the text that participants consent to, found an empty file; write it, or leave --consent out"
        )));
    }
    let url = args.store.as_deref().map(database_url).transpose()?;
    let panels = panels(args)?;
    require_playable(&protocol, &panels)?;
    let new = NewCampaign {
        protocol: &text,
        seed: args.seed,
        consent: consent.as_deref(),
        panels,
        program: crate::invocation::PROGRAM,
    };
    match &url {
        None => StudyCampaign::create(&args.study, &new)?,
        Some(url) => StudyCampaign::create_on(&args.study, url, &new)?,
    };
    if consent.is_none() {
        say("no text of consent was given: each session asks for it in words only");
    }
    let sessions: Vec<&str> = protocol.sessions.iter().map(|s| s.name.as_str()).collect();
    print(&format!(
        "{}: a study with the protocol {} and the seed {}; sessions: {}",
        args.study.display(),
        protocol.name,
        args.seed,
        sessions.join(", ")
    ))?;
    if let Some(url) = &url {
        say(&format!(
            "sessions and answers are kept in {url}; another station takes part with: piezotact campaign join {url} FOLDER"
        ));
    }
    Ok(())
}

/// Refuses stimuli whose files would have one name, panels that the protocol does not name, and a protocol that names others.
fn require_playable(protocol: &Protocol, panels: &BTreeMap<String, BTreeSet<String>>) -> Outcome {
    require_names(protocol.rendered())?;
    let disjoint_from = &protocol.panel.disjoint_from;
    let unknown = panels.keys().find(|name| !disjoint_from.contains(name));
    if let Some(unknown) = unknown {
        return Err(usage(anyhow!(
            "the protocol is not disjoint from a panel `{unknown}`; it names {}",
            named(disjoint_from)
        )));
    }
    let missing: Vec<String> = disjoint_from
        .iter()
        .filter(|name| !panels.contains_key(*name))
        .cloned()
        .collect();
    if !missing.is_empty() {
        return Err(usage(anyhow!(
            "no participant may belong to {}: say who does, with --panel \"NAME=FILE\" for each, one pseudonym a line",
            named(&missing)
        )));
    }
    Ok(())
}

fn named(names: &[String]) -> String {
    match names {
        [] => "none".to_owned(),
        _ => format!("`{}`", names.join("`, `")),
    }
}

fn panels(args: &Arguments) -> Outcome<BTreeMap<String, BTreeSet<String>>> {
    let each = args.panel.iter();
    each.map(|panel| Ok((panel.name.clone(), members(&panel.file)?)))
        .collect()
}

/// The pseudonyms in `file`, one a line; empty lines and what follows a `#` are left out.
fn members(file: &Path) -> Outcome<BTreeSet<String>> {
    let text = read_input_text(file)?;
    let lines = text
        .lines()
        .map(|line| line.split('#').next().unwrap_or(""));
    let mut members = BTreeSet::new();
    for line in lines.map(str::trim).filter(|line| !line.is_empty()) {
        let one = Pseudonym::new(line).map_err(|error| {
            Failure::Data(anyhow::Error::new(error).context(file.display().to_string()))
        })?;
        members.insert(one.to_string());
    }
    match members.is_empty() {
        true => Err(Failure::Data(anyhow!(
            "{}: expected one pseudonym a line, found none; name the members of the panel",
            file.display()
        ))),
        false => Ok(members),
    }
}
