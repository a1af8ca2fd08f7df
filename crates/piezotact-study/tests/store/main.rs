//! The store of a campaign as programs meet it: killed, cut, full, locked, read-only; and what a withdrawal leaves.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

mod campaigns;
mod damage;
mod identities;
mod kills;
mod outages;
mod places;
#[path = "../support/postgres.rs"]
mod postgres;
mod server;
mod withdrawals;

use std::io::{Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use piezotact_people::campaign::chain::Link;
use piezotact_people::campaign::store::{NewEvent, Purpose, SessionKey, Store as _, StoreError};
use piezotact_study::store::{Passphrase, PersonalData, Pseudonym, SignedConsent, StudyStore};

const AT_MS: i64 = 1_700_000_000_000;

fn key() -> SessionKey {
    SessionKey::new("P01", "discrimination")
}

fn text(number: u64) -> String {
    format!("{{\"answer\":\"quince-{number}\"}}")
}

fn append(store: &mut StudyStore, key: &SessionKey, number: u64) -> Result<Link, StoreError> {
    let json = text(number);
    let event = NewEvent {
        at_ms: AT_MS + number as i64,
        json: &json,
        salt: u128::from(number + 1).to_le_bytes(),
    };
    store.append(key, number, event)
}

/// A study with `count` events of P01.
fn study(folder: &Path, count: u64) -> StudyStore {
    let mut store = StudyStore::create(folder).unwrap();
    store.begin(&key(), Purpose::Volunteer).unwrap();
    for number in 0..count {
        append(&mut store, &key(), number).unwrap();
    }
    store
}

/// The number of events of P01, each of which is the one that was stored.
fn whole(store: &StudyStore) -> u64 {
    assert!(store.verify().unwrap() >= 1);
    let links = store.events(&key()).unwrap();
    for (link, number) in links.iter().zip(0..) {
        let payload = link.payload.as_ref().unwrap();
        assert_eq!((link.number, &payload.json), (number, &text(number)));
    }
    links.len() as u64
}

fn is_in(bytes: &[u8], words: &str) -> bool {
    bytes
        .windows(words.len())
        .any(|window| window == words.as_bytes())
}

/// The files under `folder` that hold `words`; links are not followed.
fn holding(folder: &Path, words: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let kind = std::fs::symlink_metadata(&path).unwrap();
        if kind.is_dir() {
            found.extend(holding(&path, words));
        } else if kind.is_file() && is_in(&std::fs::read(&path).unwrap(), words) {
            found.push(path);
        }
    }
    found
}

fn passphrase() -> Passphrase {
    let passphrase = Passphrase::new("four words of wood".into()).unwrap();
    passphrase.with_work_factor(2)
}

fn name(text: &str) -> Pseudonym {
    Pseudonym::new(text).unwrap()
}

/// An identity, and files that hold `quince`: one beside, one set aside, and one in a folder that was set aside.
fn fill(store: &mut StudyStore, participant: &str) {
    let person = PersonalData {
        name: "Quentin quince".into(),
        contact: "quince@example.org".into(),
        consent: Some(SignedConsent::new("2", "I take part. quince", AT_MS)),
    };
    store
        .set_identity(&name(participant), person, &passphrase())
        .unwrap();
    let own = store.participant_folder(&name(participant));
    let aside = own.with_file_name(format!("{participant}.before-1"));
    for (folder, file) in [
        (own.clone(), "S2.parquet"),
        (own.join("drives"), "S2.wav.before-2"),
        (aside, "S2.parquet"),
    ] {
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join(file), "samples of quince").unwrap();
    }
}

/// What the other process does, and where: `append FOLDER` or `withdraw FOLDER`.
const TASK: &str = "PIEZOTACT_STUDY_TASK";

/// This program again, as the command that `shell` runs with it as `"$0"` and its arguments.
fn process(program: &Path, task: &str, folder: &Path, shell: &str) -> Command {
    let mut command = Command::new("sh");
    command.args(["-c", shell]).arg(program);
    command.args([
        "--exact",
        "a_process_of_other_tests",
        "--ignored",
        "--nocapture",
    ]);
    command
        .env(TASK, task)
        .env("PIEZOTACT_STUDY_FOLDER", folder);
    command.stdout(Stdio::piped()).stderr(Stdio::null());
    command
}

fn start(task: &str, folder: &Path) -> Child {
    let program = std::env::current_exe().unwrap();
    process(&program, task, folder, "exec \"$0\" \"$@\"")
        .spawn()
        .unwrap()
}

/// One and a half times what a withdrawal takes on this machine, from the start of its process to its end, ms: kills come within that.
fn kill_within_ms(folder: &Path) -> u64 {
    let begun = std::time::Instant::now();
    lines(start("withdraw", folder));
    begun.elapsed().as_millis() as u64 * 3 / 2 + 1
}

/// What it said, until it ended or was killed.
fn lines(mut child: Child) -> Vec<String> {
    let mut said = String::new();
    child
        .stdout
        .take()
        .unwrap()
        .read_to_string(&mut said)
        .unwrap();
    child.wait().unwrap();
    // A line without its end was not said.
    let (whole, _) = said.rsplit_once('\n').unwrap_or_default();
    whole.lines().map(str::to_owned).collect()
}

fn say(words: &str) {
    let mut out = std::io::stdout().lock();
    writeln!(out, "{words}").unwrap();
    out.flush().unwrap();
}

/// The numbers of the events that were acknowledged.
fn acknowledged(lines: &[String]) -> Vec<u64> {
    let number = |line: &String| line.strip_prefix("stored ").map(|n| n.parse().unwrap());
    lines.iter().filter_map(number).collect()
}

#[test]
#[ignore = "the other process of the tests below"]
fn a_process_of_other_tests() {
    let Ok(task) = std::env::var(TASK) else {
        return;
    };
    let folder = PathBuf::from(std::env::var_os("PIEZOTACT_STUDY_FOLDER").unwrap());
    say("begun");
    let opened = match task.as_str() {
        "append" => StudyStore::create(&folder).or_else(|_| StudyStore::open(&folder)),
        _ => StudyStore::open(&folder),
    };
    let mut store = match opened {
        Ok(store) => store,
        Err(error) => return say(&format!("refused {error}")),
    };
    if task == "look" {
        let events = whole(&store);
        say(&format!("looked {} {events}", store.verify().unwrap()));
        let refused = append(&mut store, &key(), events).unwrap_err();
        return say(&format!("refused {refused}"));
    }
    if task == "withdraw" {
        let done = store.withdraw(&name("P01"), AT_MS, Some(&passphrase()));
        return say(&format!("withdrawn {}", done.is_ok()));
    }
    let begun = store.begin(&key(), Purpose::Volunteer);
    assert!(matches!(begun, Ok(()) | Err(StoreError::Exists { .. })));
    let first = store.events(&key()).unwrap().len() as u64;
    for number in first..first + 4000 {
        match append(&mut store, &key(), number) {
            Ok(link) => say(&format!("stored {}", link.number)),
            Err(error) => {
                let there = store.events(&key()).map(|links| links.len());
                say(&format!("there {there:?}"));
                return say(&format!("refused {error}"));
            }
        }
    }
}
