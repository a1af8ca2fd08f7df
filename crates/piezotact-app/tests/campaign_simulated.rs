//! Campaigns with virtual volunteers.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use piezotact_study::store::StudyStore;

use crate::campaign_session::{holds, run, study, whole};
use crate::support::Folder;
use crate::support::session::{table, two_sets};

const SIMULATE: &str =
    "campaign simulate st --protocol protocol.toml --participants 2 --seed 7 --iterations 0";

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
            "piezotact answers st",
        ],
    );
    folder
}

#[test]
fn a_simulated_study_is_read_as_any_other_and_never_taken_for_one_of_people() {
    let folder = simulated();
    for line in [
        "campaign status st",
        "answers st",
        "campaign export st --out exported",
        "campaign verify st",
    ] {
        let done = run(&folder, line);
        done.expect_success();
        if !line.contains("verify") {
            holds(
                &done.err(),
                &[
                    "virtual volunteers answered in 4 sessions, judging as the model `thurstone`: no person answered",
                ],
            );
        }
    }
    // Nor does it get lost in a table that is read alone.
    let exported = run(&folder, "answers exported/answers.csv");
    exported.expect_success();
    holds(
        &exported.err(),
        &[
            "virtual volunteers answered in 2 sessions, judging as the model `thurstone`: no person answered",
        ],
    );
    let orders = run(&folder, "answers exported/orders.csv");
    holds(
        &orders.err(),
        &["answered in 2 sessions", "no person answered"],
    );
    let people = table(&folder.path("exported/participants.csv"));
    assert_eq!(people.len(), 4);
    assert!(people.iter().all(|row| row["judge"] == "thurstone"));
    for file in ["evidence", "trials"] {
        let rows = table(&folder.path(&format!("exported/{file}.csv")));
        assert!(!rows.is_empty() && rows.iter().all(|row| row["judge"] == "thurstone"));
    }
    // The first page says what was asked, that nobody was asked, what was found and how sure.
    let status = run(&folder, "campaign status st").out();
    holds(
        &status,
        &["2 of 10 virtual volunteers (no person) completed"],
    );
    let matrix = run(&folder, "answers st --report st.html");
    holds(&matrix.out(), &["Simulated: ", "of 2 virtual volunteers"]);
    let page = std::fs::read_to_string(folder.path("st.html")).unwrap();
    for words in [
        "2 virtual volunteers of 10 planned",
        "Simulated: no person touched anything or answered.",
        "rendering: open loop, one level for all textures; judge: thurstone.",
        "What was found, task by task",
        "fewer than 4 participants decide nothing",
        "Akaike weight",
    ] {
        assert!(page.contains(words), "{words}");
    }
    run(&folder, "campaign run st P09 measurement").expect_failure(
        2,
        &["expected a study with people, found one that was simulated"],
    );
    let open = StudyStore::open(&folder.path("st")).unwrap();
    let other = open.simulate_alone().unwrap();
    run(&folder, SIMULATE).expect_failure(1, &["another program simulates this study"]);
    drop((other, open));
    let plan = folder.path("st/participants/P01/discrimination/plan.json");
    let text = std::fs::read(&plan).unwrap();
    std::fs::remove_file(&plan).unwrap();
    run(&folder, SIMULATE).expect_failure(1, &["the plan of session discrimination of P01"]);
    std::fs::write(&plan, text).unwrap();
    // The same command finds everything done; another simulation goes elsewhere.
    let again = run(&folder, SIMULATE);
    again.expect_success();
    holds(
        &again.out(),
        &[
            "4 sessions (4 of them were complete before)",
            // What was felt is kept with the study.
            "answers of 2 participants do not decide which judge it was",
        ],
    );
    for (line, said) in [
        (
            SIMULATE.replace("--seed 7", "--seed 8"),
            "expected a study of this protocol with the seed 8",
        ),
        (
            SIMULATE.replace("--participants 2", "--participants 1"),
            "expected at least the 2 volunteers that this study has, found 1",
        ),
        (
            SIMULATE.replace("--iterations 0", "--iterations 1"),
            "expected --iterations 0, with which this simulation was begun, found 1",
        ),
        (
            format!("{SIMULATE} --level fit"),
            "expected --level common, with which this simulation was begun, found fit",
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
    let line = "campaign simulate study --protocol protocol.toml --participants 2 --seed 7";
    run(&folder, line).expect_failure(2, &["found session naming of P01 with a person"]);
    // Nor can what the twin does not have be touched.
    let line = "campaign simulate other --protocol protocol.toml --participants 2 --seed 7";
    run(&folder, line).expect_failure(1, &["K1"]);
}

/// Five samples named from memory, under names of the protocol's own: several panels, each a study that the same command finds done.
#[test]
fn panels_are_other_people_and_stay_the_same() {
    const LINE: &str = "campaign simulate st --protocol protocol.toml --participants 2 --seed 7 --panels 2 --surface K1=S1 --surface K2=S5 --surface K3=S8 --surface K4=S11 --surface K5=NO";
    let folder = study();
    let done = run(&folder, LINE);
    done.expect_success();
    holds(
        &done.out(),
        &[
            "st: 2 panels of virtual volunteers who judge as thurstone; as expected",
            "from panel to panel",
        ],
    );
    let said = |done: &crate::support::Done| {
        let mut lines: Vec<String> = done
            .err()
            .lines()
            .filter(|line| line.starts_with("seed "))
            .map(str::to_owned)
            .collect();
        lines.sort();
        lines
    };
    let first = said(&done);
    assert_eq!(first.len(), 2, "{}", done.err());
    assert_ne!(
        first[0].replace("seed 7", ""),
        first[1].replace("seed 8", "")
    );
    let again = run(&folder, LINE);
    again.expect_success();
    assert_eq!((said(&again), again.out()), (first, done.out()));
    // A panel is a study as any other, and what one panel alone gives.
    let alone = LINE
        .replace("simulate st ", "simulate alone ")
        .replace(" --panels 2", "");
    run(&folder, &alone).expect_success();
    let [one, other] = ["answers st/seed-7", "answers alone"].map(|line| run(&folder, line).out());
    assert_eq!(one, other);
    run(&folder, &LINE.replace("K1=S1", "K9=S1")).expect_failure(
        2,
        &["expected a sample of the protocol (K1, K2, K3, K4, K5), found `K9`"],
    );
    run(&folder, &LINE.replace("K1=S1", "K1")).expect_failure(2, &["such as P60=S2, found `K1`"]);
    let line = "campaign simulate av --protocol averaged_transfer_function --participants 4 --seed 7 --panel 3..5";
    run(&folder, line).expect_failure(2, &["volunteer 3 is in the panel and takes part"]);
}

/// Nothing is made where the twin has no such sample, and a link that leads nowhere is no folder.
#[test]
fn what_cannot_be_simulated_leaves_no_folder() {
    let folder = Folder::new();
    let line = "campaign simulate made --protocol isotropic_triplets --participants 1 --seed 1 --surface S2=S99";
    folder
        .run(&line.split(' ').collect::<Vec<_>>())
        .expect_failure(1, &["expected a sample of the twin", "found `S99`"]);
    assert!(!folder.path("made").exists());
    // Own names: the refusal says which option gives them a surface.
    folder.write("own.toml", two_sets().replace("\"S2\"", "\"felt\""));
    let line = "campaign simulate made --protocol own.toml --participants 1 --seed 1";
    run(&folder, line).expect_failure(
        1,
        &[
            "the twin has no surface for felt of the protocol",
            "--surface felt=S8",
        ],
    );
    assert!(!folder.path("made").exists());
    let line = "campaign simulate made --protocol isotropic_triplets --participants 1 --seed 18446744073709551615 --panels 2";
    folder
        .run(&line.split(' ').collect::<Vec<_>>())
        .expect_failure(2, &["expected one that 1 other can follow"]);
    assert!(!folder.path("made").exists());
    std::os::unix::fs::symlink("nowhere", folder.path("link")).unwrap();
    let line = "campaign simulate link --protocol isotropic_triplets --participants 1 --seed 1";
    folder
        .run(&line.split(' ').collect::<Vec<_>>())
        .expect_failure(1, &["a link that leads nowhere", "name another folder"]);
}

/// A sample of an own name with strokes that were recorded on it: every volunteer meets these strokes, and another file is another simulation.
#[test]
fn own_samples_are_simulated_from_their_recordings() {
    let folder = Folder::new();
    folder.write(
        "own.toml",
        two_sets()
            .replace("\"S4\"", "\"velvet\"")
            .replace("\"S8\"", "\"denim\""),
    );
    let record = |seed: u32| {
        format!(
            "twin record --bench acttouch --sample S5 --participant 3 --seed {seed} --out velvet.parquet --force"
        )
    };
    run(&folder, &record(9)).expect_success();
    let line = "campaign simulate own --protocol own.toml --participants 1 --seed 7 --iterations 0 --surface velvet=velvet.parquet --surface denim=S8";
    run(&folder, line).expect_success();
    run(&folder, "campaign export own --out tables").expect_success();
    let answers = table(&folder.path("tables/answers.csv"));
    assert!(answers.iter().any(|row| row["presented"] == "velvet"));
    run(&folder, line).expect_success();
    run(&folder, &record(10)).expect_success();
    run(&folder, line).expect_failure(
        2,
        &["expected --surface", "with which this simulation was begun"],
    );
    run(
        &folder,
        &line
            .replace("=velvet.parquet", "=satin.parquet")
            .replace("simulate own", "simulate other"),
    )
    .expect_failure(1, &["satin.parquet"]);
    assert!(!folder.path("other").exists());
}

/// Detection of a person of the twin, with few trials: each method has the standard deviation that is its own, and no matrix is asked for.
#[test]
fn thresholds_are_printed_where_no_answer_names_a_sample() {
    let folder = Folder::new();
    let library = run(&folder, "campaign protocol detection_threshold").out();
    let few = library
        .replace("trials = 50", "trials = 6")
        .replace("at_most = 90", "at_most = 30")
        .replace("{ trials = 6, ", "{ trials = 1, ")
        .replace("{ trials = 5, ", "{ trials = 2, ");
    folder.write("few.toml", few);
    run(
        &folder,
        "campaign simulate st --protocol few.toml --participants 1 --seed 7 --iterations 0",
    )
    .expect_success();
    let printed = run(&folder, "answers st");
    printed.expect_success();
    holds(
        &printed.out(),
        &["thresholds.quest", "thresholds.staircase", "not decided"],
    );
    run(&folder, "answers st --json")
        .expect_failure(2, &["found thresholds alone", "campaign export"]);
    run(&folder, "campaign export st --out tables").expect_success();
    let rows = table(&folder.path("tables/thresholds.csv"));
    assert_eq!(rows.len(), 2);
    for row in rows {
        let of_quest = row["task"] == "quest";
        assert_eq!(row["posterior_sd"].is_empty(), !of_quest, "{row:?}");
        assert!(row["reversals_sd"].is_empty() || !of_quest, "{row:?}");
        assert!(
            row["interval_low"].is_empty() && row["interval_high"].is_empty(),
            "{row:?}"
        );
    }
}

/// The same answers, as a study and as its exported table: compared with themselves they do not differ, whichever stands first. Places in
/// orders are no answers of either.
#[test]
fn a_study_and_its_table_are_the_same_in_both_ways() {
    let folder = simulated();
    run(&folder, "campaign export st --out exported").expect_success();
    for line in [
        "answers st --compare people:exported/answers.csv",
        "answers exported/answers.csv --compare people:st",
    ] {
        let found = run(&folder, line);
        found.expect_success();
        holds(&found.out(), &["difference 0.0 points", "p = 1.000"]);
    }
}

/// A panel that overlaps with the volunteers is refused before a folder is made.
#[test]
fn a_panel_that_overlaps_leaves_no_folder() {
    let folder = Folder::new();
    let line = "campaign simulate made --protocol averaged_transfer_function --participants 2 --seed 7 --panel 1..3";
    run(&folder, line).expect_failure(2, &["volunteer 1 is in the panel and takes part"]);
    assert!(!folder.path("made").exists());
}

/// Lines without end that are never taken end the session, which can be gone on with.
#[test]
fn endless_wrong_lines_end() {
    let folder = Folder::new();
    folder.write("protocol.toml", two_sets());
    run(&folder, "campaign new st --protocol protocol.toml --seed 7").expect_success();
    let mut command = folder.command(&["campaign", "run", "st", "P01", "measurement"]);
    let mut child = command
        .stdin(std::process::Stdio::piped())
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let mut typed = child.stdin.take().unwrap();
    while std::io::Write::write_all(&mut typed, b"y\n").is_ok() {}
    let ended = child.wait_with_output().unwrap();
    assert_eq!(ended.status.code(), Some(1));
    let said = String::from_utf8(ended.stderr).unwrap();
    holds(
        &said,
        &[
            "100 lines in a row were refused",
            "the same command goes on",
        ],
    );
}
