//! Campaigns with virtual volunteers.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use crate::campaign_drives::two_sets;
use crate::campaign_session::{holds, run, study, whole};
use crate::support::Folder;
use crate::support::session::table;

const SIMULATE: &str =
    "campaign simulate protocol.toml --study st --participants 2 --seed 7 --iterations 0";

fn simulated() -> Folder {
    let folder = Folder::new();
    folder.write("protocol.toml", two_sets());
    let done = run(&folder, SIMULATE);
    done.expect_success();
    holds(
        &done.out(),
        &[
            "2 virtual volunteers who judge as thurstone, 4 sessions (0 of them were complete before)",
            "answers of 2 participants",
            "piezotact matrix st",
        ],
    );
    folder
}

#[test]
fn a_simulated_study_is_read_as_any_other_and_never_taken_for_one_of_people() {
    let folder = simulated();
    for line in [
        "campaign status st",
        "matrix st",
        "campaign export st --out exported",
        "campaign verify-journal st",
    ] {
        let done = run(&folder, line);
        done.expect_success();
        if !line.contains("verify") {
            holds(
                &done.err(),
                &["virtual volunteers who judge as `thurstone` answered in 4 sessions, no person"],
            );
        }
    }
    let people = table(&folder.path("exported/participants.csv"));
    assert_eq!(people.len(), 4);
    assert!(people.iter().all(|row| row["judge"] == "thurstone"));
    let evidence = table(&folder.path("exported/evidence.csv"));
    assert!(!evidence.is_empty());
    run(&folder, "campaign run st P09 measurement").expect_failure(
        2,
        &["expected a study with people, found virtual volunteers, such as P01"],
    );
    // The same command finds everything done; another simulation goes elsewhere.
    let again = run(&folder, SIMULATE);
    again.expect_success();
    holds(
        &again.out(),
        &[
            "4 sessions (4 of them were complete before)",
            "is not compared",
        ],
    );
    for (line, said) in [
        (
            SIMULATE.replace("--seed 7", "--seed 8"),
            "expected a study of this protocol with the seed 8",
        ),
        (
            format!("{SIMULATE} --judge guesser"),
            "virtual volunteers who judge as guesser, found",
        ),
        (
            format!("{SIMULATE} --judge everybody"),
            "expected a judge (thurstone, guesser, level_only, spectrum_only)",
        ),
        (
            format!("{SIMULATE} --level loud"),
            "expected common, fit, or a level",
        ),
    ] {
        run(&folder, &line).expect_failure(2, &[said]);
    }
}

#[test]
fn nothing_is_simulated_into_a_study_with_people() {
    let folder = study();
    whole(&folder, "campaign run study P01 naming");
    let line = "campaign simulate protocol.toml --study study --participants 2 --seed 7";
    run(&folder, line).expect_failure(2, &["found session naming of P01 with a person"]);
    // Nor can what the twin does not have be touched.
    let line = "campaign simulate protocol.toml --study other --participants 2 --seed 7";
    run(&folder, line).expect_failure(1, &["K1"]);
}
