//! Answers from the terminal to the tables: what a correction changes, what an export holds, what a matrix says of them.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::collections::BTreeSet;

use piezotact_people::campaign::protocol::LIBRARY;

use crate::campaign_drives::{DISCRIMINATE, measured};
use crate::campaign_session::{holds, run, session, until, whole};
use crate::support::session::table;
use crate::support::{BENCH, Folder};

/// A study of inverted textures, both sessions on one day, in which P01 was measured.
fn inverted() -> Folder {
    let folder = Folder::new();
    let (_, library) = LIBRARY
        .iter()
        .find(|(name, _)| *name == "amplitude_inversion")
        .unwrap();
    folder.write("protocol.toml", library.replace("another_day", "any_time"));
    run(
        &folder,
        "campaign new study --protocol protocol.toml --seed 7",
    )
    .expect_success();
    whole(&folder, "campaign run study P01 measurement");
    folder
}

const BY_HAND: &str = "campaign run study P01 discrimination --by-hand";

#[test]
fn a_corrected_order_says_what_it_changes_and_the_tables_keep_both() {
    let folder = inverted();
    let mut first = session(&folder, BY_HAND);
    let text = until(&mut first, "for each of the 3, one of A B C");
    holds(&text, &["answer>"]);
    holds(
        &first.type_and_read("AAD"),
        &["`D` is not one of the choices A B C", "answer>"],
    );
    holds(
        &first.type_and_read("AB"),
        &["expected 3 of A B C, found 2", "answer>"],
    );
    holds(&first.type_and_read("abc"), &["noted: A B C"]);
    holds(&first.type_and_read(""), &["trial 3 of 10"]);
    holds(
        &first.type_and_read("/fix 9 A B C because so"),
        &["trial 9 is not confirmed"],
    );
    let fixed = first.type_and_read("/fix 1 S13 S2 S6 because noted one slot off");
    holds(
        &fixed,
        &[
            "→ S13 S2 S6",
            "the letters of this order stand for other samples now, also in:",
            "trial 2: A B C (",
            "→ A B C (S13 S2 S6)",
            "the tables keep both, with the reason",
        ],
    );
    // What is answered with the corrected letters is read with them, also after a second correction.
    holds(&first.type_and_read(""), &["one of A B C"]);
    holds(&first.type_and_read("bcc"), &["noted: B C C (S2 S6 S6)"]);
    holds(&first.type_and_read(""), &["trial 4 of 10"]);
    first.type_and_read("/fix 1 S6 S2 S13 because read from the wrong side");
    first.type_line("/leave");
    assert!(first.end().0.success());
    for line in [
        "answers study",
        "campaign export study --out exported",
        "campaign status study",
    ] {
        let done = run(&folder, line);
        done.expect_success();
        holds(
            &done.err(),
            &[
                "session discrimination of P01 is under way: 3 of 10 trials",
                "own order of trial 1 was corrected after its letters had been used in answers, so that 2 answers mean another sample now",
            ],
        );
    }
    let trials = table(&folder.path("exported/trials.csv"));
    let rows: Vec<_> = trials
        .iter()
        .filter(|row| row["session"] == "discrimination")
        .collect();
    let before = rows[0]["confirmed_answer"].clone();
    assert_ne!(before, "S13|S2|S6");
    let of = |row: usize| {
        [
            "first_answer",
            "confirmed_answer",
            "answer",
            "corrected_because",
        ]
        .map(|column| rows[row][column].as_str())
    };
    let twice = "order of trial 1 corrected: noted one slot off; order of trial 1 corrected: read from the wrong side";
    assert_eq!(
        of(0),
        [
            &*before,
            &*before,
            "S6|S2|S13",
            "noted one slot off; read from the wrong side"
        ]
    );
    assert_eq!(of(1)[..2], [&*before, &*before]);
    assert_eq!(of(1)[2], "S6|S2|S13");
    assert_eq!(of(1)[3], twice);
    assert_eq!(
        of(2),
        [
            "S2|S6|S6",
            "S2|S6|S6",
            "S2|S13|S13",
            "order of trial 1 corrected: read from the wrong side"
        ]
    );
    assert_eq!(of(3)[3], "");
}

/// The figures of a matrix: the first line.
fn headline(text: &str) -> String {
    text.lines().next().unwrap().to_owned()
}

#[test]
fn an_export_gives_the_matrix_of_the_study_and_keeps_orders_apart() {
    let folder = inverted();
    whole(&folder, BY_HAND);
    run(&folder, "campaign export study --out exported").expect_success();
    let of = |line: &str| {
        let done = run(&folder, line);
        done.expect_success();
        done
    };
    let study = of("answers study");
    holds(
        &study.out(),
        &[
            "24 answers of 1 participant",
            "chance 33.3 %; no interval: not decided",
            "16 to plain stimuli",
            "8 to manipulated ones",
        ],
    );
    holds(
        &study.err(),
        &["24 flagged answers (in 24 what was played was not measured)"],
    );
    // Orders beside it change nothing of the associations.
    for line in [
        "answers exported/answers.csv --samples S2,S5,S6,S8,S11,S13",
        "answers study --ordering task2",
    ] {
        assert_eq!(headline(&of(line).out()), headline(&study.out()), "{line}");
    }
    let orders = of("answers exported/orders.csv --samples S2,S5,S6,S8,S11,S13 --ordering task2");
    holds(&orders.out(), &["task task2: 2 orders"]);
    let mut keys = BTreeSet::new();
    for row in table(&folder.path("exported/answers.csv")) {
        assert_eq!(row["task"], "task3");
        keys.insert(row["trial"].clone());
    }
    let known: BTreeSet<String> = table(&folder.path("exported/trials.csv"))
        .into_iter()
        .map(|row| row["trial"].clone())
        .collect();
    assert!(
        keys.len() == 8 && keys.is_subset(&known),
        "{keys:?} {known:?}"
    );
}

#[test]
fn a_rehearsal_without_drives_waits_and_says_what_is_missing() {
    let folder = inverted();
    let line = format!("campaign run study P02 discrimination --rehearsal --bench {BENCH}");
    let mut rehearsal = session(&folder, &line);
    until(&mut rehearsal, "textures on the device");
    holds(
        &rehearsal.type_and_read(""),
        &["NOT PRESENTED:", "S2 INVERTED", "/leave", "present>"],
    );
    holds(
        &rehearsal.type_and_read("/note no drives yet"),
        &["present>"],
    );
    rehearsal.type_line("/leave");
    assert!(rehearsal.end().0.success());
}

#[test]
fn textures_that_are_no_longer_measured_are_said_and_flagged() {
    let folder = measured();
    let mut on_bench = session(&folder, &format!("{DISCRIMINATE} {BENCH}"));
    until(&mut on_bench, "texture 1: force");
    on_bench.type_line("/leave");
    assert!(on_bench.end().0.success());
    let seen = whole(&folder, BY_HAND);
    holds(
        &seen,
        &["From here on they are played by hand: nothing is measured"],
    );
}
