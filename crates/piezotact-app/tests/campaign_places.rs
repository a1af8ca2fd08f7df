//! Studies where something outside is not as it should be: a medium that is only read, a clock that is behind.
#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::path::Path;

use piezotact_people::campaign::store::{NewEvent, Purpose, SessionKey, Store as _};
use piezotact_study::store::StudyStore;

use crate::campaign_session::{holds, run, session, study, until, whole};

/// A study on a medium that is only read: everything is looked at, nothing in it is changed, and no session runs.
#[test]
fn a_study_that_is_only_read_is_looked_at() {
    use std::os::unix::fs::{MetadataExt as _, PermissionsExt as _};
    use std::os::unix::process::CommandExt as _;
    let folder = study();
    whole(&folder, "campaign run study P01 naming");
    let program = folder.path("program");
    std::fs::copy(env!("CARGO_BIN_EXE_piezotact"), &program).unwrap();
    let root = std::fs::metadata(folder.path("")).unwrap().uid() == 0;
    let mode = |path: &Path, mode: u32| {
        std::fs::set_permissions(path, std::fs::Permissions::from_mode(mode)).unwrap();
    };
    let each = |of_folder: u32, of_file: u32| {
        let mut open = vec![folder.path("study")];
        while let Some(path) = open.pop() {
            match path.is_dir() {
                true => {
                    let entries = std::fs::read_dir(&path).unwrap();
                    open.extend(entries.map(|entry| entry.unwrap().path()));
                    mode(&path, of_folder);
                }
                false => mode(&path, of_file),
            }
        }
    };
    std::fs::create_dir(folder.path("outside")).unwrap();
    mode(&folder.path("outside"), 0o777);
    mode(&folder.path(""), 0o755);
    each(0o555, 0o444);
    let done = |line: &str| {
        let mut command = std::process::Command::new(&program);
        command
            .args(line.split_whitespace())
            .stdin(std::process::Stdio::null())
            .current_dir(folder.path(""));
        if root {
            command.uid(65534).gid(65534);
        }
        let output = command.output().unwrap();
        let said =
            [output.stdout, output.stderr].map(|of| String::from_utf8_lossy(&of).into_owned());
        (output.status.code(), said.concat())
    };
    let looked: Vec<_> = [
        ("campaign status study", "P01"),
        ("campaign verify study", "1 session verified"),
        ("answers study --report outside/matrix.html", "K1"),
        ("campaign export study --out outside/tables", "1 session"),
        ("bids export study --out outside/bids", "1 participant"),
        ("campaign plan study P02 naming", "P02"),
    ]
    .map(|(line, part)| (line, part, done(line)))
    .into();
    let run = done("campaign run study P02 naming");
    each(0o755, 0o644);
    for (line, part, (code, said)) in looked {
        assert!(code == Some(0) && said.contains(part), "{line}: {said}");
    }
    assert_eq!(run.0, Some(1), "{}", run.1);
    assert!(
        run.1
            .contains("a session needs a folder that can be written"),
        "{}",
        run.1
    );
}

/// The newest event of the study is six days ahead of the clock.
#[test]
fn a_clock_that_is_behind_the_study_is_said_where_a_session_begins_and_goes_on() {
    let folder = study();
    let mut one = session(&folder, "campaign run study P01 naming");
    until(&mut one, "trial 2 of 6");
    one.kill();
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    let ahead = NewEvent {
        at_ms: now.unwrap().as_millis() as i64 + 6 * 86_400_000 + 60_000,
        json: "{}",
        salt: Default::default(),
    };
    let mut store = StudyStore::open(&folder.path("study")).unwrap();
    let key = SessionKey::new("P09", "naming");
    store.begin(&key, Purpose::Rehearsal).unwrap();
    store.append(&key, 0, ahead).unwrap();
    drop(store);
    for line in [
        "campaign run study P01 naming",
        "campaign run study P02 naming",
    ] {
        let mut one = session(&folder, line);
        assert!(one.prompt().is_some());
        let (_, said) = one.end();
        holds(
            &said,
            &[
                "warning: the clock of this computer",
                "6 days before the newest event of the study",
            ],
        );
    }
    assert!(
        !run(&folder, "campaign status study")
            .err()
            .contains("clock of this computer")
    );
}

/// A command that is given again changes nothing, and the store counts no change that is not there.
#[test]
fn a_withdrawal_that_is_given_twice_leaves_a_journal_that_verifies() {
    let folder = study();
    whole(&folder, "campaign run study P01 naming");
    for line in ["withdraw study P01", "withdraw study P01", "verify study"] {
        run(&folder, &format!("campaign {line}")).expect_success();
    }
}
