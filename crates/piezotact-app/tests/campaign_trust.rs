//! What must not count: sessions on somebody else's finger or nobody's, of who has withdrawn, of two programs, by a changed plan.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use piezotact_people::campaign::plan::Plan;
use piezotact_people::campaign::store::{Purpose, SessionKey, Store as _};
use piezotact_study::store::{Pseudonym, StudyStore};

use crate::campaign_drives::{DISCRIMINATE, measured};
use crate::campaign_session::{holds, run, session, study, until, whole};
use crate::support::{BENCH, Folder};

#[test]
fn a_session_with_a_volunteer_is_played_to_the_finger_of_the_volunteer() {
    let folder = measured();
    for (bench, said) in [
        (
            "measured:tf.json",
            "expected a bench with a finger on it, found a measured transfer function: nobody feels what it plays",
        ),
        (
            "twin:participant=2,seed=7",
            "expected the finger of P01 on the bench, found that of P02",
        ),
    ] {
        let line = format!("{DISCRIMINATE} {bench}");
        std::fs::copy(
            crate::campaign_drives::prepared().path("tf.json"),
            folder.path("tf.json"),
        )
        .unwrap();
        run(&folder, &line).expect_failure(1, &[said, "nothing was stored"]);
        let mut rehearsal = session(&folder, &format!("{line} --rehearsal"));
        holds(&rehearsal.prompt().unwrap(), &["consent>"]);
        drop(rehearsal);
        std::fs::remove_dir_all(folder.path("study")).unwrap();
        run(
            &folder,
            "campaign new study --protocol protocol.toml --seed 7",
        )
        .expect_success();
        whole(&folder, "campaign run study P01 measurement");
    }
    // The participant's own twin plays, and nothing that is made from it is taken for a person's.
    whole(&folder, &format!("{DISCRIMINATE} {BENCH}"));
    for line in [
        "campaign status study",
        "campaign export study --out exported",
        "answers study",
    ] {
        let done = run(&folder, line);
        done.expect_success();
        holds(
            &done.err(),
            &[
                "session discrimination of P01",
                "on a simulated bench: no person felt them",
            ],
        );
    }
}

#[test]
fn a_session_is_run_by_one_program_and_its_recordings_are_those_that_were_made() {
    let folder = measured();
    let line = format!("{DISCRIMINATE} {BENCH}");
    let mut first = session(&folder, &line);
    until(&mut first, "texture 1: force");
    let runs = folder.path("study/participants/P01/discrimination/runs");
    let files = || {
        let there = std::fs::read_dir(&runs).unwrap();
        let mut there: Vec<_> = there.map(|entry| entry.unwrap().path()).collect();
        there.sort();
        there
    };
    let before: Vec<_> = files()
        .iter()
        .map(|file| std::fs::read(file).unwrap())
        .collect();
    assert!(before.len() >= 2);
    run(&folder, &line).expect_failure(
        1,
        &[
            "session discrimination of P01 is run by another program",
            "end it there",
        ],
    );
    let after: Vec<_> = files()
        .iter()
        .map(|file| std::fs::read(file).unwrap())
        .collect();
    assert!(before == after, "the second program has written");
    first.kill();
    // A killed program holds nothing.
    whole(&folder, &line);
    let verified = run(&folder, "campaign verify study");
    verified.expect_success();
    holds(&verified.out(), &["recordings of what was played"]);
    // Drives that are given to a finished session do not replace those that it was played with.
    let drive = folder.path("study/participants/P01/discrimination/drives/S8.wav");
    let played = std::fs::read(&drive).unwrap();
    std::fs::copy(
        folder.path("drives/drives/S2.wav"),
        folder.path("drives/drives/S8.wav"),
    )
    .unwrap();
    let _whatever_it_says = run(&folder, &line);
    assert!(std::fs::read(&drive).unwrap() == played);
    // Recordings that were exchanged are found.
    let of_session: Vec<_> = files()
        .into_iter()
        .filter(|file| file.extension().is_some_and(|ending| ending == "parquet"))
        .collect();
    let [.., other, last] = of_session.as_slice() else {
        panic!("{of_session:?}");
    };
    std::fs::copy(other, last).unwrap();
    run(&folder, "campaign verify study").expect_failure(
        1,
        &["expected the recording that was made in session discrimination of P01, found another"],
    );
}

#[test]
fn who_withdrew_in_a_session_counts_nowhere_from_then_on() {
    let folder = study();
    whole(&folder, "campaign run study P01 naming");
    let mut two = session(&folder, "campaign run study P02 naming");
    until(&mut two, "trial 4 of");
    two.type_and_read("/withdraw");
    two.type_line("WITHDRAW");
    let (status, said) = two.end();
    assert!(status.success(), "{said}");
    let exported = run(&folder, "campaign export study --out exported");
    exported.expect_success();
    holds(
        &exported.out(),
        &[
            "5 answers that name a sample and 0 places in orders, of 1 session",
            "left out, of participants who withdrew: 1 session",
        ],
    );
    assert!(!folder.path("exported/events/P02_naming.jsonl").exists());
    for line in [
        "campaign export study --out exported",
        "campaign status study",
        "answers study",
    ] {
        let done = run(&folder, line);
        holds(&done.err(), &["P02 has withdrawn and is not erased yet"]);
    }
    for file in ["answers.csv", "trials.csv", "participants.csv"] {
        let text = std::fs::read_to_string(folder.path(&format!("exported/{file}"))).unwrap();
        assert!(text.contains("P01") && !text.contains("P02"), "{file}");
    }
    run(&folder, "campaign withdraw study P02").expect_success();
    let status = run(&folder, "campaign status study");
    assert!(!status.err().contains("not erased"), "{}", status.err());
}

#[test]
fn another_seed_than_that_of_the_plans_is_refused() {
    let folder = study();
    whole(&folder, "campaign run study P01 naming");
    let file = folder.path("study/campaign.json");
    let text = std::fs::read_to_string(&file).unwrap();
    std::fs::write(&file, text.replace("\"seed\": 7", "\"seed\": 8")).unwrap();
    for line in [
        "campaign verify study",
        "campaign status study",
        "campaign plan study P02 naming",
        "campaign export study --out exported",
        "answers study",
    ] {
        run(&folder, line).expect_failure(
            1,
            &[
                "expected the seed 7 in campaign.json, with which session naming of P01 was planned, found 8",
            ],
        );
    }
    std::fs::write(&file, text).unwrap();
    run(&folder, "campaign verify study").expect_success();
}

#[test]
fn what_a_script_types_after_the_end_is_not_lost_without_a_word() {
    let folder = study();
    whole(&folder, "campaign run study P01 naming");
    let mut over = session(&folder, "campaign run study P01 naming");
    over.type_line("/fix 1 S2 because late");
    let seen = over.type_and_read("");
    let (status, said) = over.end();
    assert!(status.success(), "{said}");
    holds(
        &seen,
        &[
            "is complete",
            "1 line after the end: not taken",
            "no corrections",
        ],
    );
}

#[test]
fn a_plan_that_was_changed_before_the_session_began_is_refused() {
    let folder = study();
    let planned = run(&folder, "campaign plan study P01 naming --json");
    let mut plan: Plan = serde_json::from_str(&planned.out()).unwrap();
    let key = SessionKey::new("P01", "naming");
    let mut store = StudyStore::open(&folder.path("study")).unwrap();
    store.write_plan(&plan).unwrap();
    store.begin(&key, Purpose::Volunteer).unwrap();
    drop(store);
    run(&folder, "campaign plan study P01 naming").expect_success();
    plan.trials.swap(1, 2);
    let participant = Pseudonym::new("P01").unwrap();
    let store = StudyStore::open(&folder.path("study")).unwrap();
    let file = store
        .session_folder(&participant, "naming")
        .unwrap()
        .join("plan.json");
    std::fs::write(file, plan.bytes()).unwrap();
    run(&folder, "campaign run study P01 naming").expect_failure(
        1,
        &[
            "the plan of session naming of P01 is not the one that follows",
            "restore it",
        ],
    );
}

#[test]
fn a_plan_that_cannot_be_read_stops_its_own_session_only() {
    let folder = study();
    whole(&folder, "campaign run study P01 naming");
    whole(&folder, "campaign run study P02 naming");
    let plan = folder.path("study/participants/P02/naming/plan.json");
    std::fs::write(plan, "{").unwrap();
    for line in [
        "campaign status study",
        "campaign export study --out exported",
        "answers study",
        "campaign plan study P03 naming",
    ] {
        run(&folder, line).expect_success();
    }
    let exported = run(&folder, "--force campaign export study --out exported");
    holds(
        &exported.err(),
        &[
            "session naming of P02",
            "plan.json",
            "all sessions of this participant are left out",
        ],
    );
    let status = run(&folder, "campaign status study");
    holds(&status.out(), &["its plan cannot be read", "1 of "]);
    whole(&folder, "campaign run study P03 naming");
    for line in ["campaign run study P02 naming", "campaign verify study"] {
        run(&folder, line).expect_failure(1, &["plan.json"]);
    }
}

#[cfg(unix)]
#[test]
fn links_and_copies_of_a_participant_are_neither_followed_nor_forgotten() {
    let folder = study();
    let there = folder.path("study/participants");
    std::fs::create_dir_all(&there).unwrap();
    std::fs::create_dir_all(folder.path("elsewhere")).unwrap();
    std::os::unix::fs::symlink(folder.path("elsewhere"), there.join("P01")).unwrap();
    run(&folder, "campaign run study P01 naming").expect_failure(
        1,
        &["participants/P01 is a link", "move the folder to its place"],
    );
    assert!(
        std::fs::read_dir(folder.path("elsewhere"))
            .unwrap()
            .next()
            .is_none()
    );
    std::fs::remove_file(there.join("P01")).unwrap();
    whole(&folder, "campaign run study P01 naming");
    for copy in ["P01-copy", "p01.bak", "P01 (1)", "P010", "XP01"] {
        std::fs::create_dir(there.join(copy)).unwrap();
    }
    std::fs::write(folder.path("study/notes of p01.txt"), "x").unwrap();
    let done = run(&folder, "campaign withdraw study P01");
    done.expect_success();
    holds(
        &done.err(),
        &[
            "P01-copy may hold data",
            "p01.bak may hold",
            "P01 (1) may hold",
            "notes of p01.txt may hold",
        ],
    );
    assert!(
        !done.err().contains("P010") && !done.err().contains("XP01"),
        "{}",
        done.err()
    );
    // A pipe in the place of the seal is refused, and not waited for.
    let seal = folder.path("study/study.seal");
    std::fs::rename(&seal, folder.path("study/kept.seal")).unwrap();
    std::os::unix::fs::symlink(folder.path("study/kept.seal"), &seal).unwrap();
    run(&folder, "campaign status study")
        .expect_failure(1, &["expected the file study.seal, found a link"]);
}

#[cfg(unix)]
#[test]
fn what_is_no_file_of_the_study_is_neither_waited_for_nor_followed() {
    use std::os::unix::fs::symlink;
    // A new study does not wait for the other end of a pipe.
    let folder = Folder::new();
    std::fs::create_dir(folder.path("study")).unwrap();
    let pipe = std::process::Command::new("mkfifo")
        .arg(folder.path("study/protocol.toml"))
        .status();
    assert!(pipe.unwrap().success());
    run(
        &folder,
        "campaign new study --protocol isotropic_triplets --seed 7",
    )
    .expect_failure(1, &["is not the protocol of the new study"]);
    // Files of the study are no links.
    let folder = study();
    for file in ["study/campaign.json", "study/protocol.toml"] {
        let kept = folder.path("kept");
        std::fs::rename(folder.path(file), &kept).unwrap();
        symlink(&kept, folder.path(file)).unwrap();
        run(&folder, "campaign status study")
            .expect_failure(1, &["expected a file of the study, found a link"]);
        std::fs::remove_file(folder.path(file)).unwrap();
        std::fs::rename(&kept, folder.path(file)).unwrap();
    }
    // What a link leads to is not erased, and said.
    std::fs::create_dir(folder.path("elsewhere")).unwrap();
    symlink(
        folder.path("elsewhere"),
        folder.path("study/participants/P01"),
    )
    .unwrap();
    let done = run(&folder, "campaign withdraw study P01");
    done.expect_success();
    holds(
        &done.err(),
        &["elsewhere was linked", "what it led to was not erased"],
    );
    assert!(folder.path("elsewhere").is_dir());
}
