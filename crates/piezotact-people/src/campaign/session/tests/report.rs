//! What the report of a session says, beside what was done in it.

use piezotact::page::{Block, Page, Table};

use super::*;
use crate::association::session_page;

fn table<'a>(page: &'a Page, heading: &str) -> Option<&'a Table> {
    let section = page.sections.iter().find(|one| one.heading == heading)?;
    section.blocks.iter().find_map(|block| match block {
        Block::Table(table) => Some(table),
        _ => None,
    })
}

fn row(table: &Table, at: usize) -> Vec<String> {
    table.rows[at].iter().map(|cell| cell.text()).collect()
}

fn number(page: &Page, name: &str) -> String {
    let Some(Block::Numbers { numbers }) = page.sections[0].blocks.first() else {
        panic!("no numbers");
    };
    let found = numbers.iter().find(|one| one.name == name).unwrap();
    found.value.clone()
}

#[test]
fn a_report_shows_what_was_presented_answered_and_changed() {
    let (protocol, plan) = isotropic();
    let mut run = Run::begun(&protocol, &plan);
    run.trial();
    run.does(Command::Note {
        text: "the fan was loud".to_owned(),
    });
    run.present();
    let first = plan.trials[1].presented.names().to_vec();
    let mut turned = first.clone();
    turned.reverse();
    let _revised = run
        .answers(&turned.join(" "))
        .and_then(|()| run.answers(&first.join(" ")));
    run.does(Command::Confirm);
    let page = session_page(&run.state, &run.events);
    assert_eq!(page.title, "Session discrimination of P01");
    assert!(!page.origin.contains("rehearsal"), "{}", page.origin);
    assert_eq!(number(&page, "session"), "under way");
    let needed = plan.trials.len();
    assert_eq!(number(&page, "trials confirmed"), format!("2 of {needed}"));
    let trials = table(&page, "Trials").unwrap();
    assert_eq!(
        trials.rows.len(),
        2,
        "trials that were not presented are not shown"
    );
    let second = row(trials, 1);
    assert_eq!(second[0], "2");
    assert_eq!(second[4], first.join(", "));
    assert_eq!(second[5], first.join(", "), "the answer that counts");
    assert_eq!(second[7], "revised once");
    // Each event of this session comes 1 s after the one before; presented, answered, revised, confirmed.
    assert_eq!(second[6], "3.0");
    assert_eq!(row(trials, 0)[1], "0:00");
    let happened = table(&page, "What happened besides").unwrap();
    let said: Vec<String> = happened.rows.iter().map(|row| row[1].text()).collect();
    assert_eq!(said.len(), 3, "{said:?}");
    assert_eq!(said[2], "note: the fan was loud");
    assert!(
        happened.rows[0][0].text().starts_with('−'),
        "before the first trial"
    );
}

#[test]
fn a_report_of_a_session_without_trials_is_whole() {
    let (protocol, plan) = isotropic();
    let mut run = Run::new(&protocol, &plan);
    run.does(Command::Begin {
        experimenter: "EX".to_owned(),
        program: "piezotact 0.1.0".to_owned(),
        purpose: Purpose::Rehearsal,
        participant: Participant::default(),
    });
    run.does(Command::RefuseConsent);
    let page = session_page(&run.state, &run.events);
    assert!(page.origin.contains("A rehearsal"), "{}", page.origin);
    assert_eq!(number(&page, "session"), "no consent");
    assert!(table(&page, "Trials").unwrap().rows.is_empty());
}

/// A playing whose target is not decided is neither met nor missed.
#[test]
fn a_report_does_not_take_what_is_not_decided_for_met() {
    let (protocol, plan) = isotropic();
    let mut run = Run::begun(&protocol, &plan);
    let at = plan.trials.iter().position(|trial| trial.task == "task3");
    let at = at.unwrap();
    for _ in 0..at {
        run.trial();
    }
    while let Step::Check { .. } = run.state.step() {
        run.does(Command::Check);
    }
    let stimuli = plan.trials[at].presented.names();
    let outcomes = [Outcome::NotDecided, Outcome::NotMet];
    let reached = outcomes.into_iter().chain(std::iter::repeat(Outcome::Met));
    let each = stimuli.iter().zip(reached);
    let evidence = each.map(|(one, reached)| playing(one, reached, BenchKind::Hardware));
    let evidence = evidence.collect();
    run.does(Command::Present { evidence });
    let page = session_page(&run.state, &run.events);
    let all = stimuli.len();
    let missed = number(&page, "stimuli that missed their target");
    assert_eq!(missed, format!("1 of {all}"));
    let open = number(&page, "stimuli of which it is not decided");
    assert_eq!(open, format!("1 of {all}"));
    let remarks = &row(table(&page, "Trials").unwrap(), at)[7];
    assert_eq!(
        remarks,
        "not confirmed; target missed once; target not decided once"
    );
}
