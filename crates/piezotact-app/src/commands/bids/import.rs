//! `piezotact bids import`: a data set as recordings and tables.

use std::path::PathBuf;

use anyhow::{Error, anyhow};
use clap::Args;
use piezotact::number::counted;
use piezotact::page::{Cell, Column, Table};
use piezotact_dataset::write_recording;
use piezotact_people::association::{
    Answer, Declared, ReadBehaviour, answers_table, declared, evidence_of_behaviour, holds_orders,
    read_behaviour, trials_of_behaviour,
};
use piezotact_people::campaign::protocol::{Protocol, read};
use piezotact_report::report;
use piezotact_study::bids::{BidsFolder, Imported, NewFolder};

use crate::deliver::{Outputs, deliver_and};
use crate::failure::{Failure, Outcome};
use crate::interrupt::{Between, interrupted};
use crate::places::outputs;
use crate::progress::{Words, Work};

const READING: Words = Words {
    doing: "reading",
    done: "read",
    item: "recording",
    then: "reading",
};

#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The folder of the data set.
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
    /// The folder to write: recordings/, eeg/, drives/, answers.csv, orders.csv, trials.csv, evidence.csv, participants.csv and protocol.toml.
    #[arg(long, value_name = "FOLDER")]
    out: PathBuf,
    #[command(flatten)]
    outputs: Outputs,
}

pub(super) fn run(args: &Arguments) -> Outcome {
    let dataset = BidsFolder::open(&args.folder)?;
    dataset.require_outside(&args.out)?;
    outputs(&[], &args.outputs.files())?;
    let mut out = NewFolder::beside(&args.out)?;
    let [recordings, drives] = copied(&dataset, &mut out)?;
    let eeg_recordings = brains(&dataset, &mut out)?;
    let behaviour = dataset.behaviour()?;
    let protocol = protocol(&dataset)?;
    let answers = answers(&behaviour)?;
    for (name, table) in tables(&dataset, &behaviour, (protocol.as_ref(), &answers))? {
        if !table.rows.is_empty() {
            out.put_text(name, &report::csv(&table)?)?;
        }
    }
    if let Some(text) = dataset.protocol()? {
        out.put_text("protocol.toml", &text)?;
    }
    out.commit()?;
    let imported = Imported {
        dataset: args.folder.clone(),
        recordings,
        eeg_recordings,
        drives,
        answers: answers.len(),
        not_imported: left_out(&dataset, &behaviour, &answers),
    };
    deliver_and(&args.outputs, &imported, &[&args.out])
}

/// Copies the files of EEG, which name each other; gives how many recordings they are.
fn brains(dataset: &BidsFolder, out: &mut NewFolder) -> Outcome<usize> {
    let mut count = 0;
    for file in dataset.eeg() {
        let name = crate::report::name(&file);
        let ends = |endings: &[&str]| endings.iter().any(|ending| name.ends_with(ending));
        count += usize::from(ends(&["_eeg.vhdr", "_eeg.edf", "_eeg.bdf", "_eeg.set"]));
        out.copy(&format!("eeg/{name}"), &dataset.path(&file))?;
    }
    Ok(count)
}

/// What the data set has and the tables and recordings do not.
fn left_out(dataset: &BidsFolder, behaviour: &[ReadBehaviour], answers: &[Answer]) -> Vec<String> {
    let mut lines = Vec::new();
    for of in behaviour.iter().filter(|of| !of.responses.rows.is_empty()) {
        let of_task =
            |answer: &&Answer| answer.task == of.task && answer.participant == of.participant;
        if answers.iter().find(of_task).is_none() {
            lines.push(format!(
                "{} of {} to task {}: nothing says what was presented and which response is right (events of trials are in trials.csv)",
                counted(of.responses.rows.len(), "answer"),
                of.participant,
                of.task
            ));
        }
    }
    if dataset.sessions().is_empty() {
        lines.push("participants: the data set has no table of sessions".to_owned());
    }
    lines.push(
        "strokes (piezotact strokes cuts them again), and what was derived from recordings and answers".to_owned(),
    );
    lines
}

/// Writes the recordings and the drives; gives how many there are of each.
fn copied(dataset: &BidsFolder, out: &mut NewFolder) -> Outcome<[usize; 2]> {
    let recordings = dataset.recordings();
    let reading = Work::of_sizes(READING, vec![1.0; recordings.len()]);
    let between = Between::items("recording");
    for of in &recordings {
        if interrupted() {
            return Err(Failure::Data(anyhow!(
                "nothing was written; the same command begins anew"
            )));
        }
        let recording = dataset.read_recording(of)?;
        write_recording(
            &out.path(&format!("recordings/{}.parquet", of.name))?,
            &recording,
        )?;
        reading.one_more();
    }
    drop((reading, between));
    let drives = dataset.stimuli();
    for file in &drives {
        let name = file.strip_prefix("stimuli").unwrap_or(file);
        out.copy(&format!("drives/{}", name.display()), &dataset.path(file))?;
    }
    Ok([recordings.len(), drives.len()])
}

/// The protocol of the study, where the data set has it.
fn protocol(dataset: &BidsFolder) -> Outcome<Option<Protocol>> {
    let Some(text) = dataset.protocol()? else {
        return Ok(None);
    };
    let protocol = read(&text);
    Ok(Some(protocol.map_err(|error| {
        Failure::Data(Error::new(error).context("sourcedata/protocol.toml"))
    })?))
}

fn answers(behaviour: &[ReadBehaviour]) -> Outcome<Vec<Answer>> {
    let mut answers = Vec::new();
    for of in behaviour {
        let read = read_behaviour(of).map_err(|error| {
            let place = format!(
                "task {} of {} in session {}",
                of.task, of.participant, of.session
            );
            Failure::Data(Error::new(error).context(place))
        })?;
        answers.extend(read);
    }
    Ok(answers)
}

/// The tables of a study, in the columns of `piezotact campaign export`.
fn tables(
    dataset: &BidsFolder,
    behaviour: &[ReadBehaviour],
    (protocol, answers): (Option<&Protocol>, &[Answer]),
) -> Outcome<[(&'static str, Table); 5]> {
    let nothing = Declared {
        samples: Vec::new(),
        stimuli: Vec::new(),
    };
    let declared = protocol.map_or(nothing, declared);
    let orders = |answer: &&Answer| {
        let mut of = behaviour.iter().filter(|of| of.task == answer.task);
        of.any(|of| holds_orders(&of.responses))
    };
    let (orders, named): (Vec<&Answer>, Vec<&Answer>) = answers.iter().partition(orders);
    let table = |answers: Vec<&Answer>| {
        let answers: Vec<Answer> = answers.into_iter().cloned().collect();
        answers_table(&declared, &answers)
    };
    Ok([
        ("answers.csv", table(named)),
        ("orders.csv", table(orders)),
        ("trials.csv", trials_of_behaviour(behaviour)?),
        ("evidence.csv", evidence_of_behaviour(behaviour)?),
        ("participants.csv", participants(dataset)),
    ])
}

/// Who took part, one row for each session.
fn participants(dataset: &BidsFolder) -> Table {
    let columns = [
        ("session", "session"),
        ("sex", "stated_sex"),
        ("age_years", "age"),
        ("handedness", "handedness"),
        ("finger", "finger"),
        ("language", "language"),
        ("confirmed", "confirmed"),
        ("planned", "planned"),
        ("rehearsal", "rehearsal"),
        ("judge", "judge"),
    ];
    let names = ["participant"]
        .into_iter()
        .chain(columns.map(|(name, _)| name));
    let mut table = Table::new(names.map(|name| Column::new(name, name)));
    for (participant, row) in dataset.sessions() {
        let cells = columns.map(|(_, from)| match from {
            // Rehearsals are not carried.
            "rehearsal" => Cell::from("no"),
            from => Cell::from(row.get(from).cloned().unwrap_or_default()),
        });
        table
            .rows
            .push([Cell::from(participant)].into_iter().chain(cells).collect());
    }
    table
}
