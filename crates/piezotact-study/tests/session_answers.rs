//! The answers of a session, written as a table and read as a file.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use piezotact::criterion::Outcome;
use piezotact::page::Table;
use piezotact_people::association::{AnswerTable, Flag, answers_of, answers_table, declared};
use piezotact_people::campaign::plan::AnswerForm;
use piezotact_people::campaign::store::Purpose;
use piezotact_study::read_answers;

use crate::sitting::{Sitting, library, planned};

/// As a spreadsheet writes it, with every cell in quotes.
fn csv(table: &Table) -> String {
    let line = |cells: Vec<String>| {
        let quoted = cells
            .iter()
            .map(|cell| format!("\"{}\"", cell.replace('"', "\"\"")));
        quoted.collect::<Vec<_>>().join(",") + "\n"
    };
    let heads = table.columns.iter().map(|column| column.name.clone());
    let rows = table
        .rows
        .iter()
        .map(|row| row.iter().map(|cell| cell.whole()).collect());
    std::iter::once(heads.collect())
        .chain(rows)
        .map(line)
        .collect()
}

#[test]
fn what_was_answered_is_read_as_it_was_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("answers.csv");
    for (name, rows_expected) in [
        ("isotropic_triplets", 100),
        ("amplitude_inversion", 20),
        ("periodic_pilot", 20),
    ] {
        let protocol = library(name);
        let plan = planned(&protocol, &protocol.sessions.last().unwrap().name);
        let mut sitting = Sitting::begun(&protocol, &plan);
        let mut wrong = false;
        while sitting.state.current().is_some() {
            let (_, _, mut presented) = sitting.current();
            let (trial, _) = sitting.state.current().unwrap();
            let is_answered = trial.answer != AnswerForm::Done;
            let mut samples = protocol.samples.iter();
            let other = samples.find(|one| !presented.contains(one));
            // Once another sample than the planned one.
            if let (false, true, Some(other)) = (wrong, is_answered, other) {
                wrong = true;
                presented[0].clone_from(other);
                sitting.presents_instead(&presented);
                let words = sitting.first_choices();
                sitting.answers(&words);
                continue;
            }
            sitting.anyhow(&[Outcome::Met, Outcome::NotMet]);
        }
        let declared = declared(&protocol);
        let rows = answers_of(&sitting.state, Purpose::Volunteer);
        assert!(rows.len() > rows_expected, "{name}: {}", rows.len());
        let flagged = |flag: Flag| rows.iter().any(|row| row.flags.contains(&flag));
        assert!(
            flagged(Flag::MissedTarget) || name == "periodic_pilot",
            "{name}"
        );
        assert!(flagged(Flag::WrongSample), "{name}");
        std::fs::write(&path, csv(&answers_table(&declared, &rows))).unwrap();
        let read = read_answers(&path, &protocol.samples).unwrap();
        let expected = AnswerTable::new(declared.clone(), rows.clone()).unwrap();
        assert_eq!(read.table.answers(), expected.answers(), "{name}");
        assert_eq!(read.table.answers(), rows, "{name}: nothing was inferred");
        assert_eq!(read.table.inferred(), 0);
        // Stimuli that were presented are declared as before.
        for row in &rows {
            let of = |table: &AnswerTable| {
                let mut stimuli = table.declared().stimuli.iter();
                stimuli.find(|one| one.name == row.presented).cloned()
            };
            assert_eq!(of(&read.table), of(&expected));
        }
        // A rehearsal is read as one, and left out.
        let mut both = rows.clone();
        both.extend(answers_of(&sitting.state, Purpose::Rehearsal));
        std::fs::write(&path, csv(&answers_table(&declared, &both))).unwrap();
        let read = read_answers(&path, &protocol.samples).unwrap();
        assert_eq!(
            (read.table.answers(), read.table.rehearsals()),
            (&rows[..], rows.len())
        );
    }
}
