//! The store of a campaign as programs meet it: killed, cut, full, locked, read-only; and what a withdrawal leaves.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::collections::BTreeSet;
use std::io::{Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use piezotact_dataset::study::{
    IdentityError, Passphrase, PersonalData, Pseudonym, SignedConsent, SqliteStore, StudyError,
    WithdrawError, Withdrawn,
};
use piezotact_people::campaign::chain::Link;
use piezotact_people::campaign::store::{
    NewEvent, Purpose, SessionEntry, SessionKey, Store as _, StoreError,
};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};

const AT_MS: i64 = 1_700_000_000_000;

fn key() -> SessionKey {
    SessionKey::new("P01", "discrimination")
}

fn text(number: u64) -> String {
    format!("{{\"answer\":\"quince-{number}\"}}")
}

fn append(store: &mut SqliteStore, key: &SessionKey, number: u64) -> Result<Link, StoreError> {
    let json = text(number);
    let event = NewEvent {
        at_ms: AT_MS + number as i64,
        json: &json,
        salt: u128::from(number + 1).to_le_bytes(),
    };
    store.append(key, number, event)
}

/// A study with `count` events of P01.
fn study(folder: &Path, count: u64) -> SqliteStore {
    let mut store = SqliteStore::create(folder).unwrap();
    store.begin(&key(), Purpose::Volunteer).unwrap();
    for number in 0..count {
        append(&mut store, &key(), number).unwrap();
    }
    store
}

/// The number of events of P01, each of which is the one that was stored.
fn whole(store: &SqliteStore) -> u64 {
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

// ---- another process -----------------------------------------------------------------------------------------------------------

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
        "append" => SqliteStore::create(&folder).or_else(|_| SqliteStore::open(&folder)),
        _ => SqliteStore::open(&folder),
    };
    let mut store = match opened {
        Ok(store) => store,
        Err(error) => return say(&format!("refused {error}")),
    };
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

// ---- kills ---------------------------------------------------------------------------------------------------------------------

/// Kills a process that appends, `count` times at random moments from its start on.
fn kills(count: u32) {
    let folder = tempfile::tempdir().unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(66);
    let mut stored: BTreeSet<u64> = BTreeSet::new();
    let mut within = 0;
    for _ in 0..count {
        let mut child = start("append", folder.path());
        std::thread::sleep(Duration::from_millis(u64::from(random.next_u32() % 150)));
        child.kill().unwrap();
        let lines = lines(child);
        assert!(
            !lines.iter().any(|line| line.starts_with("refused")),
            "{lines:?}"
        );
        let new = acknowledged(&lines);
        within += u32::from(!new.is_empty());
        for number in &new {
            assert!(
                stored.insert(*number),
                "event {number} was acknowledged twice"
            );
        }
        let Ok(store) = SqliteStore::open(folder.path()) else {
            // Killed before there was a study: nothing was acknowledged.
            assert!(stored.is_empty());
            continue;
        };
        if store.sessions().unwrap().is_empty() {
            assert!(stored.is_empty());
            continue;
        }
        let there = whole(&store);
        let last = stored.last().map_or(0, |last| last + 1);
        // One may be stored that was not acknowledged any more.
        assert!(there == last || there == last + 1, "{there} of {last}");
        // It is one that the next process has read, and will not say.
        stored.extend(last..there);
        assert_eq!(stored.len() as u64, there);
    }
    assert!(
        within * 2 > count,
        "{within} of {count} kills were among answers: wait longer"
    );
}

#[test]
fn an_acknowledged_event_survives_a_kill() {
    kills(20);
}

#[test]
#[ignore = "300 kills"]
fn soak_store_kill() {
    kills(300);
}

/// A withdrawal that is killed at a random moment has not happened, or is complete once the study was opened.
fn killed_withdrawals(count: u32) {
    let mut random = ChaCha8Rng::seed_from_u64(67);
    let mut after = 0;
    for _ in 0..count {
        let folder = tempfile::tempdir().unwrap();
        let mut store = study(folder.path(), 40);
        fill(&mut store, "P01");
        drop(store);
        let mut child = start("withdraw", folder.path());
        std::thread::sleep(Duration::from_millis(u64::from(random.next_u32() % 60)));
        child.kill().unwrap();
        drop(lines(child));
        let store = SqliteStore::open(folder.path()).unwrap();
        assert_eq!(store.verify().unwrap(), 1);
        let found = holding(folder.path(), "quince");
        let people = store.identities(&passphrase()).unwrap();
        if store.sessions().unwrap()[0].withdrawn_at_ms.is_none() {
            assert_eq!((whole(&store), people.len()), (40, 1));
            assert_eq!(found.len(), 4, "{found:?}");
        } else {
            after += 1;
            assert!(
                found.is_empty() && people.is_empty(),
                "{found:?} {people:?}"
            );
        }
        assert!(!folder.path().join("identity.age.next").exists());
    }
    assert!(
        count < 20 || after > 0,
        "no kill came after an intention: wait longer"
    );
}

#[test]
fn a_killed_withdrawal_has_not_happened_or_is_completed() {
    killed_withdrawals(20);
}

#[test]
#[ignore = "300 kills"]
fn soak_store_withdrawal_kill() {
    killed_withdrawals(300);
}

// ---- torn and damaged logs -----------------------------------------------------------------------------------------------------

fn copy(from: &Path, to: &Path) {
    for name in ["study.sqlite", "study.sqlite-wal", "study.seal"] {
        std::fs::copy(from.join(name), to.join(name)).unwrap();
    }
}

/// The commits whose frames all end before byte `end` of a log: frames of 24 bytes and a page of 4096, behind a header of 32; the
/// second number of a frame is not 0 where it ends a commit.
fn commits_before(log: &[u8], end: usize) -> u64 {
    let frames = log[32..].chunks_exact(24 + 4096).enumerate();
    let whole = frames.filter(|(i, _)| 32 + (i + 1) * (24 + 4096) <= end);
    whole.filter(|(_, frame)| frame[4..8] != [0; 4]).count() as u64
}

/// What SQLite guarantees: all commits before the first damaged frame. What the seal adds: where any that was acknowledged is not among
/// them, opening says so.
#[test]
fn a_cut_or_damaged_log_is_never_opened_with_fewer_events_without_a_word() {
    let (source, target) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let store = study(source.path(), 30);
    let log = std::fs::read(source.path().join("study.sqlite-wal")).unwrap();
    // The begin of the session, and the events.
    assert_eq!(commits_before(&log, log.len()), 31);
    let mut random = ChaCha8Rng::seed_from_u64(68);
    let (mut lost, mut kept) = (0, 0);
    for round in 0..60 {
        copy(source.path(), target.path());
        let _shared = std::fs::remove_file(target.path().join("study.sqlite-shm"));
        let path = target.path().join("study.sqlite-wal");
        let at = random.next_u64() as usize % log.len();
        let mut damaged = log.clone();
        match round % 3 {
            0 => damaged.truncate(at),
            1 => damaged[at] ^= 1 << (random.next_u32() % 8),
            // Bytes behind the last frame.
            _ => damaged.extend((0..at % 9000).map(|_| random.next_u32() as u8)),
        }
        std::fs::write(&path, &damaged).unwrap();
        let expected = match round % 3 {
            2 => 31,
            // A damaged header makes all of the log invalid. Two numbers of it are not looked at: format and sequence.
            _ if at < 32 => continue,
            _ => commits_before(&log, at),
        };
        match SqliteStore::open(target.path()) {
            Ok(store) => {
                assert_eq!((whole(&store), expected), (30, 31), "{round} at {at}");
                kept += 1;
            }
            Err(StudyError::Lost {
                acknowledged,
                found,
                ..
            }) => {
                assert_eq!((acknowledged, found), (31, expected), "{round} at {at}");
                lost += 1;
                // Without the seal, somebody goes on with what is there.
                std::fs::remove_file(target.path().join("study.seal")).unwrap();
                let store = SqliteStore::open(target.path()).unwrap();
                if expected > 0 {
                    assert_eq!(whole(&store), expected - 1);
                }
            }
            Err(other) => panic!("{round} at {at}: {other}"),
        }
    }
    assert!(lost >= 30 && kept >= 20, "{lost} {kept}");
    drop(store);
}

// ---- places that refuse --------------------------------------------------------------------------------------------------------

/// A limit on the size of files is met in the middle of a session: the answer is refused aloud and not kept, and the study is whole.
#[cfg(target_os = "linux")]
#[test]
fn an_answer_that_does_not_fit_is_refused_aloud() {
    let folder = tempfile::tempdir().unwrap();
    drop(study(folder.path(), 3));
    let program = std::env::current_exe().unwrap();
    // In blocks of 512 bytes; the signal is ignored so that writing fails instead.
    let shell = "trap '' XFSZ; ulimit -f 800; exec \"$0\" \"$@\"";
    let child = process(&program, "append", folder.path(), shell)
        .spawn()
        .unwrap();
    refused_whole(&lines(child), folder.path(), "check the free space");
}

/// The last answers of a process: some were stored, one was refused with `advice`, and the study is as it was acknowledged.
#[cfg(target_os = "linux")]
fn refused_whole(lines: &[String], folder: &Path, advice: &str) {
    let last = lines
        .iter()
        .find(|line| line.starts_with("refused"))
        .unwrap();
    assert!(
        last.contains("the answer is not stored") && last.contains(advice),
        "{last}"
    );
    let stored = acknowledged(lines);
    let count = stored.last().unwrap() + 1;
    assert!(lines.contains(&format!("there Ok({count})")), "{lines:?}");
    let mut store = SqliteStore::open(folder).unwrap();
    let there = whole(&store);
    assert!(there == count || there == count + 1, "{there} of {count}");
    // With space again, it goes on.
    append(&mut store, &key(), there).unwrap();
}

/// A file system that is full.
#[cfg(target_os = "linux")]
#[test]
#[ignore = "mounts a file system, which takes root"]
fn soak_store_full_disk() {
    let folder = tempfile::tempdir().unwrap();
    let mount = |words: &[&str]| {
        let done = Command::new(words[0])
            .args(&words[1..])
            .arg(folder.path())
            .status();
        assert!(done.unwrap().success(), "{words:?}");
    };
    mount(&["mount", "-t", "tmpfs", "-o", "size=400k", "tmpfs"]);
    drop(study(folder.path(), 3));
    let said = lines(start("append", folder.path()));
    let last = said.last().cloned().unwrap_or_default();
    let room = Command::new("mount")
        .args(["-o", "remount,size=4m"])
        .arg(folder.path())
        .status();
    let whole =
        std::panic::catch_unwind(|| refused_whole(&said, folder.path(), "free space on the disk"));
    mount(&["umount"]);
    assert!(room.unwrap().success());
    assert!(whole.is_ok(), "{last}");
}

/// A folder that this user may read and not write: another user where the tests run as root, whom no permission binds.
#[cfg(target_os = "linux")]
#[test]
fn a_study_that_cannot_be_written_is_refused_with_what_to_do() {
    use std::os::unix::fs::{MetadataExt as _, PermissionsExt as _};
    use std::os::unix::process::CommandExt as _;
    let top = tempfile::tempdir().unwrap();
    let folder = top.path().join("study");
    drop(study(&folder, 3));
    let mode = |path: &Path, mode: u32| {
        std::fs::set_permissions(path, std::fs::Permissions::from_mode(mode)).unwrap();
    };
    let program = top.path().join("program");
    std::fs::copy(std::env::current_exe().unwrap(), &program).unwrap();
    for (path, bits) in [(top.path(), 0o755), (&program, 0o755), (&folder, 0o555)] {
        mode(path, bits);
    }
    for entry in std::fs::read_dir(&folder).unwrap() {
        let path = entry.unwrap().path();
        mode(&path, if path.is_dir() { 0o555 } else { 0o444 });
    }
    let mut command = process(&program, "open", &folder, "exec \"$0\" \"$@\"");
    if std::fs::metadata(top.path()).unwrap().uid() == 0 {
        command.uid(65534).gid(65534);
    }
    let said = lines(command.current_dir("/").spawn().unwrap());
    mode(&folder, 0o755);
    let last = said.iter().find(|line| line.starts_with("refused"));
    let last = last.unwrap_or_else(|| panic!("{said:?}"));
    assert!(
        last.contains("make the folder and its files writable"),
        "{last}"
    );
    for entry in std::fs::read_dir(&folder).unwrap() {
        let path = entry.unwrap().path();
        mode(&path, if path.is_dir() { 0o755 } else { 0o644 });
    }
    assert_eq!(whole(&SqliteStore::open(&folder).unwrap()), 3);
}

#[test]
fn a_study_that_another_program_holds_is_refused_after_a_wait() {
    let folder = tempfile::tempdir().unwrap();
    let holder = study(folder.path(), 3);
    drop(holder);
    let runtime = tokio::runtime::Builder::new_current_thread()
        .build()
        .unwrap();
    let address = format!("sqlite://{}", folder.path().join("study.sqlite").display());
    let mut other = runtime
        .block_on(<sqlx::SqliteConnection as sqlx::Connection>::connect(
            &address,
        ))
        .unwrap();
    let wait = Duration::from_millis(50);
    let mut store = SqliteStore::open_waiting(folder.path(), wait).unwrap();
    runtime
        .block_on(sqlx::raw_sql("BEGIN IMMEDIATE").execute(&mut other))
        .unwrap();
    let refused = append(&mut store, &key(), 3).unwrap_err().to_string();
    assert!(
        refused.contains("end the other program that uses this study"),
        "{refused}"
    );
    // Reading needs no turn.
    assert_eq!(whole(&store), 3);
    runtime
        .block_on(sqlx::raw_sql("ROLLBACK").execute(&mut other))
        .unwrap();
    append(&mut store, &key(), 3).unwrap();
    // Of two programs that run the same session, the one that was overtaken is told.
    let mut second = SqliteStore::open(folder.path()).unwrap();
    append(&mut second, &key(), 4).unwrap();
    assert!(matches!(
        append(&mut store, &key(), 4),
        Err(StoreError::Overtaken {
            expected: 4,
            found: 5,
            ..
        })
    ));
}

/// Pages in the middle of the database are overwritten: the database says so, or the chain does.
#[test]
fn a_damaged_database_is_found() {
    let folder = tempfile::tempdir().unwrap();
    drop(study(folder.path(), 200));
    let path = folder.path().join("study.sqlite");
    let good = std::fs::read(&path).unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(69);
    let mut found = 0;
    for page in 1..good.len() / 4096 {
        let mut bad = good.clone();
        for byte in &mut bad[page * 4096..(page + 1) * 4096] {
            *byte = random.next_u32() as u8;
        }
        std::fs::write(&path, bad).unwrap();
        match SqliteStore::open(folder.path()) {
            Ok(store) => found += u32::from(store.verify().is_err()),
            Err(error) => {
                assert!(error.to_string().contains("restore"), "{error}");
                found += 1;
            }
        }
    }
    assert_eq!(found as usize, good.len() / 4096 - 1);
    std::fs::write(&path, good).unwrap();
    assert_eq!(whole(&SqliteStore::open(folder.path()).unwrap()), 200);
}

// ---- withdrawals ---------------------------------------------------------------------------------------------------------------

/// An identity, and files that hold `quince`: one beside, one set aside, and one in a folder that was set aside.
fn fill(store: &mut SqliteStore, participant: &str) {
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

#[test]
fn a_withdrawal_leaves_no_byte_of_the_participant_and_all_of_the_others() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = study(folder.path(), 300);
    // Long payloads are on pages of their own.
    let long = format!("{{\"note\":\"{}\"}}", "quince ".repeat(3000));
    let event = NewEvent {
        at_ms: AT_MS,
        json: &long,
        salt: [3; 16],
    };
    store.append(&key(), 300, event).unwrap();
    let other = SessionKey::new("P01-b", "discrimination");
    store.begin(&other, Purpose::Volunteer).unwrap();
    let medlar = NewEvent {
        at_ms: AT_MS,
        json: "{\"answer\":\"medlar\"}",
        salt: [4; 16],
    };
    store.append(&other, 0, medlar).unwrap();
    fill(&mut store, "P01");
    let person = PersonalData {
        name: "Rosa".into(),
        contact: String::new(),
        consent: None,
    };
    store
        .set_identity(&name("P01-b"), person.clone(), &passphrase())
        .unwrap();
    let others = store.participant_folder(&name("P01-b"));
    std::fs::create_dir_all(&others).unwrap();
    std::fs::write(others.join("S2.parquet"), "samples of medlar").unwrap();
    let heads = (store.head(&key()).unwrap(), store.head(&other).unwrap());
    assert!(holding(folder.path(), "quince").len() >= 4);

    let refused = store.withdraw(&name("P01"), AT_MS, None).unwrap_err();
    assert!(matches!(refused, WithdrawError::PassphraseNeeded { .. }));
    let wrong = Passphrase::new("other words".into())
        .unwrap()
        .with_work_factor(2);
    let refused = store
        .withdraw(&name("P01"), AT_MS, Some(&wrong))
        .unwrap_err();
    assert!(matches!(
        refused,
        WithdrawError::Identity(IdentityError::Passphrase { .. })
    ));
    let unknown = store
        .withdraw(&name("P09"), AT_MS, Some(&passphrase()))
        .unwrap_err();
    assert!(matches!(unknown, WithdrawError::Unknown { .. }));
    assert!(
        holding(folder.path(), "quince").len() >= 4,
        "nothing is erased by a refusal"
    );

    let done = store
        .withdraw(&name("P01"), AT_MS + 7, Some(&passphrase()))
        .unwrap();
    let expected = Withdrawn {
        sessions: 1,
        files: 3,
        identities: 1,
    };
    assert_eq!(done, expected);
    for words in ["quince", "Quentin"] {
        assert_eq!(holding(folder.path(), words), Vec::<PathBuf>::new());
    }
    assert_eq!(
        heads,
        (store.head(&key()).unwrap(), store.head(&other).unwrap())
    );
    assert_eq!(store.verify().unwrap(), 2);
    let entries = store.sessions().unwrap();
    let withdrawn: Vec<_> = entries
        .iter()
        .map(|entry: &SessionEntry| entry.withdrawn_at_ms)
        .collect();
    assert_eq!(withdrawn, [Some(AT_MS + 7), None]);
    assert!(holding(folder.path(), "medlar").len() >= 2);
    assert_eq!(store.identities(&passphrase()).unwrap()["P01-b"], person);
    assert!(matches!(
        store.begin(&SessionKey::new("P01", "another"), Purpose::Volunteer),
        Err(StoreError::Withdrawn { .. })
    ));
    // Again is no error, and keeps the time.
    store
        .withdraw(&name("P01"), AT_MS + 9, Some(&passphrase()))
        .unwrap();
    assert_eq!(
        store.sessions().unwrap()[0].withdrawn_at_ms,
        Some(AT_MS + 7)
    );
    // One who was measured and had no session yet.
    let measured = store.participant_folder(&name("P03"));
    std::fs::create_dir_all(&measured).unwrap();
    std::fs::write(measured.join("S2.parquet"), "samples").unwrap();
    let done = store
        .withdraw(&name("P03"), AT_MS, Some(&passphrase()))
        .unwrap();
    assert_eq!(
        (done.sessions, done.files, measured.exists()),
        (0, 1, false)
    );
}

#[cfg(unix)]
#[test]
fn a_link_is_not_followed_out_of_the_study() {
    use std::os::unix::fs::symlink;
    let (folder, outside) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let kept = outside.path().join("kept");
    std::fs::write(&kept, "kept").unwrap();
    let mut store = study(folder.path(), 1);
    let own = store.participant_folder(&name("P01"));
    std::fs::create_dir_all(&own).unwrap();
    symlink(outside.path(), own.join("link")).unwrap();
    symlink(&kept, own.join("file")).unwrap();
    symlink(outside.path(), own.with_file_name("P01.before-1")).unwrap();
    store.withdraw(&name("P01"), AT_MS, None).unwrap();
    assert!(!own.exists() && !own.with_file_name("P01.before-1").is_symlink());
    assert!(kept.is_file());
    // A link in the place of all participants, or of the identities, is refused.
    store
        .begin(&SessionKey::new("P02", "x"), Purpose::Volunteer)
        .unwrap();
    std::fs::remove_dir(folder.path().join("participants")).unwrap();
    symlink(outside.path(), folder.path().join("participants")).unwrap();
    std::fs::create_dir(outside.path().join("P02")).unwrap();
    let refused = store
        .withdraw(&name("P02"), AT_MS, None)
        .unwrap_err()
        .to_string();
    assert!(
        refused.contains("nothing is removed outside of the study"),
        "{refused}"
    );
    assert!(outside.path().join("P02").is_dir());
    symlink(&kept, folder.path().join("identity.age")).unwrap();
    assert!(matches!(
        store.identities(&passphrase()),
        Err(IdentityError::Damaged { .. })
    ));
}

// ---- identities ----------------------------------------------------------------------------------------------------------------

#[test]
fn identities_are_read_with_their_passphrase_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = study(folder.path(), 1);
    assert!(store.identities(&passphrase()).unwrap().is_empty());
    assert!(matches!(
        Passphrase::new(" ".into()),
        Err(IdentityError::Empty)
    ));
    fill(&mut store, "P01");
    let path = folder.path().join("identity.age");
    let good = std::fs::read(&path).unwrap();
    assert!(good.starts_with(b"age-encryption.org/v1") && !is_in(&good, "quince"));
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        assert_eq!(
            std::fs::metadata(&path).unwrap().permissions().mode() & 0o777,
            0o600
        );
    }
    let people = store.identities(&passphrase()).unwrap();
    assert_eq!(people["P01"].consent.as_ref().unwrap().version, "2");

    let wrong = Passphrase::new("other words".into())
        .unwrap()
        .with_work_factor(2);
    let refused = store.identities(&wrong).unwrap_err();
    assert!(matches!(refused, IdentityError::Passphrase { .. }));
    assert!(refused.to_string().contains("type it again"));
    // Nor is anything written with another one.
    let person = people["P01"].clone();
    let refused = store.set_identity(&name("P02"), person.clone(), &wrong);
    assert!(matches!(refused, Err(IdentityError::Passphrase { .. })));
    let refused = store.set_identity(&name("p01"), person, &passphrase());
    assert!(matches!(refused, Err(IdentityError::Pseudonym(_))));
    assert_eq!(std::fs::read(&path).unwrap(), good);

    // Every byte that is changed, and every length that is cut, is found.
    for at in (0..good.len()).step_by(7) {
        let mut bad = good.clone();
        bad[at] ^= 1;
        std::fs::write(&path, &bad).unwrap();
        assert!(store.identities(&passphrase()).is_err(), "byte {at}");
        std::fs::write(&path, &good[..at]).unwrap();
        let refused = store.identities(&passphrase()).unwrap_err();
        assert!(
            matches!(refused, IdentityError::Damaged { .. }),
            "{at}: {refused}"
        );
    }
    std::fs::write(&path, "name,contact\n").unwrap();
    let refused = store.identities(&passphrase()).unwrap_err().to_string();
    assert!(
        refused.ends_with("restore the file from a copy"),
        "{refused}"
    );
}
