//! Sessions with participants, typed by a script: what is stored, what is refused, and in which words.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]
#![allow(clippy::print_stderr, reason = "a test says what it left out")]

use std::path::Path;

use crate::support::session::{Session, naming, table};
use crate::support::{Done, Folder};

pub(crate) fn run(folder: &Folder, line: &str) -> Done {
    folder.run_as_given(&line.split_whitespace().collect::<Vec<_>>())
}

pub(crate) fn session(folder: &Folder, line: &str) -> Session {
    Session::begin(folder.command(&line.split_whitespace().collect::<Vec<_>>()))
}

/// A study in a folder: five samples, each named once, behind the learning.
pub(crate) fn study() -> Folder {
    let folder = Folder::new();
    folder.write("protocol.toml", naming(1));
    run(
        &folder,
        "campaign new study --protocol protocol.toml --seed 7",
    )
    .expect_success();
    folder
}

/// What a script types at a prompt: it consents, confirms, and answers with the choices in the order in which they stand there.
pub(crate) fn line_for(text: &str) -> String {
    let words: Vec<&str> = text.split_whitespace().collect();
    let text = words.join(" ");
    let between = |from: &str, to: &str| {
        let (_, after) = text.rsplit_once(from)?;
        Some(after.split_once(to)?.0.to_owned())
    };
    if text.ends_with("consent>") {
        return "yes".into();
    }
    if !text.ends_with(" answer>")
        || text.ends_with("or another answer>")
        || text.ends_with("Enter when it is done answer>")
    {
        return String::new();
    }
    if let Some(samples) = between("all of ", " in order") {
        return samples;
    }
    let count = between("for each of the ", ", one of").map_or(1, |count| count.parse().unwrap());
    let choices = between("one of ", " answer>").unwrap_or_else(|| panic!("{text}"));
    let choices: Vec<&str> = choices.split(' ').collect();
    let answer: Vec<&str> = choices.into_iter().cycle().take(count).collect();
    answer.join(" ")
}

/// Types a session to its end; gives everything that stood on the screen.
#[track_caller]
pub(crate) fn whole(folder: &Folder, line: &str) -> String {
    let mut session = session(folder, line);
    while let Some(text) = session.prompt() {
        session.type_line(&line_for(&text));
    }
    let seen = session.seen.clone();
    let (status, said) = session.end();
    assert!(status.success(), "{seen}\n{said}");
    seen
}

/// Types a session until `wanted` stands on the screen.
#[track_caller]
pub(crate) fn until(session: &mut Session, wanted: &str) -> String {
    while let Some(text) = session.prompt() {
        if text.contains(wanted) {
            return text;
        }
        session.type_line(&line_for(&text));
    }
    panic!("`{wanted}` did not come: {}", session.seen);
}

#[track_caller]
pub(crate) fn holds(text: &str, parts: &[&str]) {
    let joined = text.split_whitespace().collect::<Vec<_>>().join(" ");
    for part in parts {
        assert!(joined.contains(part), "expected `{part}` in: {text}");
    }
}

#[test]
fn what_does_not_fit_is_refused_and_the_session_waits_at_the_same_step() {
    let folder = study();
    let mut session = session(
        &folder,
        "campaign run study P01 naming --experimenter AB --age 30 --handedness left",
    );
    let text = session.prompt().unwrap();
    holds(&text, &["Does the participant consent? yes or no"]);
    holds(
        &session.type_and_read("perhaps"),
        &["expected yes or no", "consent>"],
    );
    holds(
        &session.type_and_read("/fix 1 K1 because so"),
        &["not now:", "consent>"],
    );
    let text = session.type_and_read("yes");
    holds(&text, &["check: blindfold on", "Enter when it is so>"]);
    let text = session.type_and_read("");
    holds(&text, &["trial 1 of 6", "from the left: 1 K", "present>"]);
    holds(
        &session.type_and_read("K1"),
        &["expected Enter or a key", "present>"],
    );
    holds(
        &session.type_and_read(""),
        &["Enter when it is done", "answer>"],
    );
    holds(
        &session.type_and_read("K1"),
        &["expected Enter when it is done"],
    );
    holds(
        &session.type_and_read(""),
        &["trial 2 of 6", "hand over: K", "(notch left), then Enter"],
    );
    holds(
        &session.type_and_read("/wrong K9"),
        &["`K9` is not one of the samples or stimuli", "present>"],
    );
    holds(
        &session.type_and_read("/wrong K1 K2"),
        &["expected 1 of K1 K2 K3 K4 K5, found 2"],
    );
    holds(
        &session.type_and_read("/play 1"),
        &["nothing was presented yet"],
    );
    holds(&session.type_and_read("/wrong K3"), &["one of K1 K2"]);
    for (typed, said) in [
        ("K9", "`K9` is not one of the choices K1 K2 K3 K4 K5"),
        ("K1 K2", "expected 1 of K1 K2 K3 K4 K5, found 2"),
        ("", "expected an answer; /help explains the keys"),
        ("/play 2", "expected an element from 1 to 1, found `2`"),
        ("/nothing", "there is no key /nothing; /help lists the keys"),
        ("/note", "expected the text of the note behind /note"),
        ("/stop", "expected why the session is stopped behind /stop"),
        (
            "/fix 2 K1",
            "expected /fix N ANSWER because WHY, such as /fix 3 S4 because misheard",
        ),
        (
            "/fix 2 K1 because misheard",
            "is not confirmed yet; until then its answer is revised",
        ),
        (
            "/fix 7 K1 because misheard",
            "expected the number of a trial from 1 to 6, found `7`",
        ),
        (
            "/fix memory.task1.9 K1 because misheard",
            "expected the number of a trial from 1 to 6, found `memory.task1.9`",
        ),
        ("/go", "not now: an answer is awaited"),
    ] {
        holds(&session.type_and_read(typed), &[said, "answer>"]);
    }
    holds(
        &session.type_and_read("k2"),
        &["noted: K2", "another answer>"],
    );
    holds(
        &session.type_and_read("K4"),
        &["noted: K4", "another answer>"],
    );
    holds(
        &session.type_and_read("K9"),
        &["`K9` is not one", "noted: K4"],
    );
    holds(&session.type_and_read(""), &["trial 3 of 6"]);
    // A confirmed trial is corrected with a reason, by the number of its heading.
    holds(
        &session.type_and_read("/fix 2 K5 because I misheard"),
        &["trial 2: K4 → K5", "present>"],
    );
    holds(&session.type_and_read("/pause"), &["Enter to go on>"]);
    holds(&session.type_and_read("K1"), &["expected Enter or a key"]);
    holds(&session.type_and_read(""), &["trial 3 of 6"]);
    holds(&session.type_and_read("/status"), &["task1: 2 of 6 trials"]);
    holds(&session.type_and_read("/help"), &["/wrong NAMES", "/leave"]);
    session.type_line("/leave");
    let (status, said) = session.end();
    assert_eq!(status.code(), Some(0), "{said}");
    holds(
        &said,
        &["task1: 2 of 6 trials", "campaign run study P01 naming"],
    );
    let seen = whole(&folder, "campaign run study P01 naming --experimenter CD");
    holds(
        &seen,
        &[
            "goes on where it was left",
            "trial 3 of 6",
            "is complete: task1: 6 of 6",
        ],
    );
    run(&folder, "campaign export study --out exported").expect_success();
    // The same again is done, also after a kill; a table that a person changed is not replaced unasked.
    let answers = folder.path("exported/answers.csv");
    let written = std::fs::read_to_string(&answers).unwrap();
    std::fs::remove_file(folder.path("exported/trials.csv")).unwrap();
    let again = "campaign export study --out exported";
    run(&folder, again).expect_success();
    std::fs::write(&answers, format!("{written}mine\n")).unwrap();
    run(&folder, again).expect_failure(
        2,
        &[
            "exported/answers.csv already exists",
            "its content differs from line",
            "--force",
        ],
    );
    assert!(
        std::fs::read_to_string(&answers)
            .unwrap()
            .ends_with("mine\n")
    );
    run(&folder, "campaign export study --out exported --force").expect_success();
    assert_eq!(std::fs::read_to_string(&answers).unwrap(), written);
    let trials = table(&folder.path("exported/trials.csv"));
    let second = &trials[1];
    assert_eq!(second["presented"], "K3");
    assert_eq!(
        [
            &second["answer"],
            &second["first_answer"],
            &second["revisions"]
        ],
        ["K5", "K2", "1"]
    );
    assert_eq!(second["corrected_because"], "I misheard");
    assert!(
        trials[2]["interrupted"] == "0" && trials.iter().all(|row| row["attempts"] == "1"),
        "{trials:?}"
    );
    let people = table(&folder.path("exported/participants.csv"));
    assert_eq!(
        [&people[0]["age_years"], &people[0]["handedness"]],
        ["30", "left"]
    );
    // Of a complete session the same command says that it is complete; it cannot be begun as a rehearsal.
    let again = run(&folder, "campaign run study P01 naming");
    again.expect_success();
    holds(&again.out(), &["is complete: task1: 6 of 6 trials"]);
    run(&folder, "campaign run study P01 naming --rehearsal")
        .expect_failure(1, &["begun as a session with a volunteer"]);
    run(&folder, "campaign verify study").expect_success();
}

#[test]
fn names_that_cannot_be_are_refused_with_those_that_can() {
    let folder = study();
    whole(&folder, "campaign run study P01 naming");
    for (line, code, parts) in [
        ("campaign run study p01 naming", 2, &["p01", "P01"][..]),
        ("campaign plan study p01 naming", 2, &["p01", "P01"]),
        (
            "campaign run study P02 nameing",
            2,
            &["no session `nameing`", "its sessions are naming"],
        ),
        ("campaign run study ../P02 naming", 2, &["P02"]),
        (
            "campaign run nowhere P01 naming",
            1,
            &["nowhere", "study.sqlite"],
        ),
        (
            "campaign status nowhere",
            1,
            &["no study is in this folder"],
        ),
        (
            "campaign export nowhere --out x",
            1,
            &["no study is in this folder"],
        ),
        (
            "campaign verify nowhere",
            1,
            &["no study is in this folder"],
        ),
        (
            "campaign withdraw nowhere P01",
            1,
            &["no study is in this folder"],
        ),
        ("campaign withdraw study P09", 1, &["P09"]),
        ("campaign run study P02 naming --age 0", 2, &["--age"]),
        (
            "campaign run study P02 naming --by-hand --bench twin",
            2,
            &["--bench"],
        ),
        (
            "campaign new study --protocol protocol.toml --seed 7",
            1,
            &["a study is in this folder already"],
        ),
        (
            "campaign new other --protocol nothing.toml --seed 7",
            2,
            &["isotropic_triplets", "nothing.toml"],
        ),
    ] {
        run(&folder, line).expect_failure(code, parts);
    }
    assert!(!folder.path("nowhere").exists() && !folder.path("other").exists());
    // Nobody was entered.
    run(&folder, "campaign status study --csv status.csv --force").expect_success();
    let status = std::fs::read_to_string(folder.path("status.csv")).unwrap();
    assert_eq!(status.lines().count(), 2, "{status}");
    assert!(!folder.path("study/participants/P02").exists());
}

#[test]
fn a_changed_protocol_under_a_running_study_is_refused_with_the_choices() {
    let folder = study();
    let path = folder.path("study/protocol.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(
        &path,
        text.replace("presentations = 1", "presentations = 2"),
    )
    .unwrap();
    let choices = ["restore it from a copy", "make a new study"];
    for line in [
        "campaign run study P01 naming",
        "campaign plan study P01 naming",
        "campaign status study",
        "campaign export study --out x",
    ] {
        run(&folder, line).expect_failure(1, &choices);
    }
    std::fs::write(&path, text).unwrap();
    whole(&folder, "campaign run study P01 naming");
}

#[test]
fn nobody_of_a_disjoint_panel_takes_part() {
    let folder = Folder::new();
    let new = "campaign new study --protocol averaged_transfer_function --seed 7";
    run(&folder, new).expect_failure(2, &["`panel of 5`", "`panel of 20`", "--panel"]);
    assert!(!folder.path("study").exists());
    folder.write("members.txt", "P05 # the first\n\nP06\n");
    folder.write("empty.txt", "# nobody\n");
    let with = |file: &str| {
        let mut words: Vec<String> = new.split(' ').map(str::to_owned).collect();
        for panel in ["panel of 5", "panel of 20", "isotropic panel of 10"] {
            words.extend(["--panel".to_owned(), format!("{panel}={file}")]);
        }
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        folder.run_as_given(&words)
    };
    with("empty.txt").expect_failure(1, &["expected one pseudonym a line"]);
    with("members.txt").expect_success();
    let refused = run(&folder, "campaign run study P05 measurement");
    refused.expect_failure(
        1,
        &[
            "P05 belongs to the panel `panel of 5`",
            "choose another participant",
            "nothing was stored",
        ],
    );
    let mut other = session(&folder, "campaign run study P07 measurement");
    holds(&other.prompt().unwrap(), &["consent>"]);
}

#[test]
fn after_a_withdrawal_no_byte_of_the_participant_is_left() {
    let folder = study();
    whole(&folder, "campaign run study P02 naming");
    let mut one = session(&folder, "campaign run study P01 naming --language kurmanji");
    until(&mut one, "trial 4 of 6");
    // What is led now is withdrawn from there: it would go on.
    run(&folder, "campaign withdraw study P01").expect_failure(1, &["another program"]);
    one.type_and_read("/note the left hand hurts, quincebitternote");
    holds(
        &one.type_and_read("/withdraw"),
        &["type WITHDRAW to confirm>"],
    );
    holds(
        &one.type_and_read("no"),
        &["nothing was withdrawn", "present>"],
    );
    one.type_and_read("/withdraw");
    one.type_line("WITHDRAW");
    let (status, said) = one.end();
    assert!(status.success(), "{said}");
    assert!(holding(&folder.path("study"), "quincebitternote") > 0);
    let again = run(&folder, "campaign run study P01 naming");
    again.expect_failure(1, &["campaign withdraw study P01"]);
    let status = run(&folder, "campaign status study");
    holds(&status.out(), &["withdrawn, not erased yet"]);
    run(&folder, "campaign withdraw study P01").expect_success();
    for word in ["quincebitternote", "kurmanji"] {
        assert_eq!(holding(&folder.path("study"), word), 0, "{word}");
    }
    // The answers of the other are there, and none of this one: five.
    let answers = holding(&folder.path("study"), "\"event\":\"answered\"");
    assert_eq!(answers, 5);
    assert!(!folder.path("study/participants/P01").exists());
    let status = run(&folder, "campaign status study");
    status.expect_success();
    holds(
        &status.out(),
        &["withdrawn and erased", "P02 naming complete"],
    );
    let exported = run(&folder, "campaign export study --out exported");
    exported.expect_success();
    holds(
        &exported.out(),
        &[
            "5 answers that name a sample and 0 places in orders, of 1 session",
            "left out, of participants who withdrew: 1 session",
        ],
    );
    let verified = run(&folder, "campaign verify study");
    verified.expect_success();
    holds(
        &verified.out(),
        &["erased after a withdrawal, the chain is whole"],
    );
    run(&folder, "campaign run study P01 naming")
        .expect_failure(2, &["P01 has withdrawn", "use another pseudonym"]);
    run(&folder, "campaign withdraw study P01");
}

/// How often `word` stands in the files below `folder`.
fn holding(folder: &Path, word: &str) -> usize {
    let entries = std::fs::read_dir(folder).unwrap();
    let each = entries.map(|entry| {
        let path = entry.unwrap().path();
        if path.is_dir() {
            return holding(&path, word);
        }
        let bytes = std::fs::read(&path).unwrap();
        let windows = bytes.windows(word.len());
        windows.filter(|bytes| *bytes == word.as_bytes()).count()
    });
    each.sum()
}

#[test]
fn a_rehearsal_is_marked_and_changes_no_plan() {
    let folder = study();
    let plan = || run(&folder, "campaign plan study P03 naming --json").out();
    let before = plan();
    let seen = whole(&folder, "campaign run study P02 naming --rehearsal");
    holds(&seen, &["The rehearsal naming of P02 is complete"]);
    assert_eq!(plan(), before);
    let status = run(&folder, "campaign status study").out();
    holds(
        &status,
        &[
            "0 of 3 participants completed naming",
            "rehearsal: complete",
        ],
    );
    run(&folder, "campaign run study P02 naming")
        .expect_failure(1, &["was begun as a rehearsal", "another pseudonym"]);
    whole(&folder, "campaign run study P01 naming");
    run(&folder, "campaign export study --out exported").expect_success();
    let answers = table(&folder.path("exported/answers.csv"));
    assert_eq!(answers.len(), 10);
    for row in answers {
        let marked = if row["participant"] == "P02" {
            "yes"
        } else {
            "no"
        };
        assert_eq!(row["rehearsal"], marked);
    }
    let status = run(&folder, "campaign status study").out();
    holds(&status, &["1 of 3 participants completed naming"]);
}

/// A file of the study grows no more in the middle of a session: the answer is refused aloud, and once there is room the same line works.
#[cfg(target_os = "linux")]
#[test]
fn an_answer_that_does_not_fit_on_the_disk_is_refused_aloud() {
    let folder = Folder::new();
    folder.write("protocol.toml", naming(8));
    run(
        &folder,
        "campaign new study --protocol protocol.toml --seed 7",
    )
    .expect_success();
    let mut command = std::process::Command::new("prlimit");
    // The signal is ignored so that writing fails instead.
    let shell = "trap '' XFSZ; exec \"$0\" campaign run study P01 naming";
    command
        .args(["--fsize=300000:unlimited", "sh", "-c", shell])
        .arg(env!("CARGO_BIN_EXE_piezotact"))
        .current_dir(folder.path(""));
    let session = Session::begin(command);
    let id = session.id().to_string();
    let room = || {
        let done = std::process::Command::new("prlimit")
            .args(["--fsize=unlimited", "--pid", &id])
            .status();
        assert!(done.unwrap().success());
    };
    refused_until_there_is_room(&folder, session, room);
}

/// Types `session` until an answer is refused, makes `room`, and types it to its end.
#[cfg(target_os = "linux")]
fn refused_until_there_is_room(folder: &Folder, mut session: Session, room: impl Fn()) {
    let mut text = session.prompt().unwrap();
    let (line, refused) = loop {
        let line = line_for(&text);
        session.type_line(&line);
        let next = session
            .prompt()
            .unwrap_or_else(|| panic!("{}", session.seen));
        if next.contains("NOT STORED") {
            break (line, next);
        }
        text = next;
    };
    holds(&refused, &["nothing was stored", "Then give it again."]);
    let prompt = |text: &str| text.lines().last().unwrap().to_owned();
    // It waits at the same step, as long as it takes.
    assert_eq!(prompt(&refused), prompt(&text));
    let again = session.type_and_read(&line);
    holds(&again, &["NOT STORED"]);
    room();
    let stored = session.type_and_read(&line);
    assert!(!stored.contains("NOT STORED"), "{stored}");
    let mut text = stored;
    loop {
        session.type_line(&line_for(&text));
        match session.prompt() {
            Some(next) => text = next,
            None => break,
        }
    }
    let (status, said) = session.end();
    assert!(status.success(), "{said}");
    run(folder, "campaign verify study").expect_success();
    run(folder, "campaign export study --out exported").expect_success();
    let trials = table(&folder.path("exported/trials.csv"));
    assert_eq!(trials.len(), 41);
    for row in &trials[1..] {
        assert!(
            row["attempts"] == "1" && !row["answer"].is_empty(),
            "{row:?}"
        );
    }
    assert_eq!(table(&folder.path("exported/answers.csv")).len(), 40);
}

/// A file system that is full in the middle of a session.
#[cfg(target_os = "linux")]
#[test]
#[ignore = "mounts a file system, which takes root: ./x soak session_full_disk"]
fn soak_session_full_disk() {
    use std::os::unix::fs::MetadataExt as _;
    use std::process::Command;
    let folder = Folder::new();
    if std::fs::metadata(folder.path("")).unwrap().uid() != 0 {
        eprintln!("left out: only root mounts a file system");
        return;
    }
    folder.write("protocol.toml", naming(8));
    let place = folder.path("study");
    std::fs::create_dir(&place).unwrap();
    let mount = |words: &[&str]| {
        let done = Command::new(words[0])
            .args(&words[1..])
            .arg(&place)
            .status();
        assert!(done.unwrap().success(), "{words:?}");
    };
    mount(&["mount", "-t", "tmpfs", "-o", "size=400k", "tmpfs"]);
    let done = std::panic::catch_unwind(|| {
        run(
            &folder,
            "campaign new study --protocol protocol.toml --seed 7",
        )
        .expect_success();
        let room = || {
            let done = Command::new("mount")
                .args(["-o", "remount,size=8m"])
                .arg(&place)
                .status();
            assert!(done.unwrap().success());
        };
        let begun = session(&folder, "campaign run study P01 naming");
        refused_until_there_is_room(&folder, begun, room);
    });
    mount(&["umount"]);
    assert!(done.is_ok());
}

/// The folder may not be written any more when a session goes on: another user where the tests run as root, whom no permission binds.
#[cfg(target_os = "linux")]
#[test]
fn a_session_in_a_folder_that_became_read_only_is_refused_aloud() {
    use std::os::unix::fs::{MetadataExt as _, PermissionsExt as _, chown};
    use std::os::unix::process::CommandExt as _;
    let folder = study();
    let program = folder.path("program");
    std::fs::copy(env!("CARGO_BIN_EXE_piezotact"), &program).unwrap();
    let root = std::fs::metadata(folder.path("")).unwrap().uid() == 0;
    let each = |act: &dyn Fn(&Path)| {
        let mut open = vec![folder.path("study")];
        while let Some(path) = open.pop() {
            if path.is_dir() {
                let entries = std::fs::read_dir(&path).unwrap();
                open.extend(entries.map(|entry| entry.unwrap().path()));
            }
            act(&path);
        }
    };
    let mode = |path: &Path, mode: u32| {
        std::fs::set_permissions(path, std::fs::Permissions::from_mode(mode)).unwrap();
    };
    mode(&folder.path(""), 0o755);
    if root {
        each(&|path| chown(path, Some(65534), Some(65534)).unwrap());
    }
    let begin = || {
        let mut command = std::process::Command::new(&program);
        command
            .args(["campaign", "run", "study", "P01", "naming"])
            .current_dir(folder.path(""));
        if root {
            command.uid(65534).gid(65534);
        }
        Session::begin(command)
    };
    let mut one = begin();
    until(&mut one, "trial 3 of 6");
    one.kill();
    drop(one);
    each(&|path| mode(path, if path.is_dir() { 0o555 } else { 0o444 }));
    let (status, said) = begin().end();
    each(&|path| mode(path, if path.is_dir() { 0o755 } else { 0o644 }));
    assert_eq!(status.code(), Some(1), "{said}");
    holds(
        &said,
        &["make the folder and its files writable for this user"],
    );
    let mut one = begin();
    holds(
        &one.prompt().unwrap(),
        &[
            "goes on where it was left: task1: 2 of 6",
            "check: blindfold on",
        ],
    );
    holds(&one.type_and_read(""), &["trial 3 of 6"]);
}

#[test]
fn an_identity_forges_no_line_and_keeps_a_signed_consent() {
    let folder = Folder::new();
    folder.write("protocol.toml", naming(1));
    folder.write("consent.txt", "I take part.");
    folder.write("secret.txt", "four words of wood");
    run(
        &folder,
        "campaign new study --protocol protocol.toml --seed 7 --consent consent.txt",
    )
    .expect_success();
    let identity = |name: &str, more: &[&str]| {
        let known = ["campaign", "identity", "study", "P01", "--name", name];
        let more = [&["--contact", "room 7", "--passphrase", "secret.txt"], more].concat();
        folder.run_as_given(&[&known[..], &more].concat())
    };
    folder.write("secret.txt", "a");
    let weak = identity("Rosa", &[]);
    weak.expect_failure(1, &["1 characters are too few, 12 are needed"]);
    assert!(!folder.path("study/identity.age").exists());
    folder.write("secret.txt", "four words of wood");
    let refused = identity("Rosa\nP02: Quentin, room 8, no consent signed", &[]);
    refused.expect_failure(1, &["(U+000A)"]);
    let said = identity("Rosa", &["--signed", "2"]).out();
    assert!(said.contains("the consent is signed"), "{said}");
    let said = identity("Rosa B", &[]).out();
    assert!(said.contains("signed before is kept"), "{said}");
    let listed = run(&folder, "campaign identity study --passphrase secret.txt");
    assert_eq!(listed.out().trim().lines().count(), 1);
    assert!(listed.out().contains("P01: Rosa B, room 7, consent 2 of "));
}
