//! Places that take nothing: full, read-only, held by another program.

use std::path::Path;
use std::process::Command;
use std::time::Duration;

use piezotact_people::campaign::store::StoreError;
use piezotact_study::store::StudyStore;

use crate::{acknowledged, append, key, lines, process, start, study, whole};

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
        last.contains("nothing was stored") && last.contains(advice),
        "{last}"
    );
    let stored = acknowledged(lines);
    let count = stored.last().unwrap() + 1;
    assert!(lines.contains(&format!("there Ok({count})")), "{lines:?}");
    let mut store = StudyStore::open(folder).unwrap();
    let there = whole(&store);
    assert!(there == count || there == count + 1, "{there} of {count}");
    // With space again, it goes on.
    append(&mut store, &key(), there).unwrap();
}

/// A file system that is full.
#[cfg(target_os = "linux")]
#[test]
#[ignore = "mounts a file system, which takes root; ./x soak runs it"]
fn soak_store_full_disk() {
    use std::os::unix::fs::MetadataExt as _;
    let folder = tempfile::tempdir().unwrap();
    if std::fs::metadata(folder.path()).unwrap().uid() != 0 {
        // Only root mounts; the limit on the size of files is met in any case.
        return;
    }
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

/// A folder that this user may read and not write, to another user where the tests run as root, whom no permission binds: it is looked
/// at, and takes nothing. One that was not closed has changes that cannot be read there.
#[cfg(target_os = "linux")]
#[test]
fn a_study_that_cannot_be_written_is_looked_at_and_refuses_changes() {
    use std::os::unix::fs::{MetadataExt as _, PermissionsExt as _};
    use std::os::unix::process::CommandExt as _;
    let top = tempfile::tempdir().unwrap();
    let folder = top.path().join("study");
    let open = study(&folder, 3);
    let unclosed = top.path().join("unclosed");
    std::fs::create_dir(&unclosed).unwrap();
    for entry in std::fs::read_dir(&folder).unwrap().map(Result::unwrap) {
        if entry.path().is_file() {
            std::fs::copy(entry.path(), unclosed.join(entry.file_name())).unwrap();
        }
    }
    drop(open);
    let mode = |path: &Path, mode: u32| {
        std::fs::set_permissions(path, std::fs::Permissions::from_mode(mode)).unwrap();
    };
    let program = top.path().join("program");
    std::fs::copy(std::env::current_exe().unwrap(), &program).unwrap();
    for path in [top.path(), &program] {
        mode(path, 0o755);
    }
    let looked_at = |folder: &Path| {
        let modes = |of_folder: u32, of_file: u32| {
            for entry in std::fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                mode(&path, if path.is_dir() { of_folder } else { of_file });
            }
            mode(folder, of_folder);
        };
        modes(0o555, 0o444);
        let mut command = process(&program, "look", folder, "exec \"$0\" \"$@\"");
        if std::fs::metadata(top.path()).unwrap().uid() == 0 {
            command.uid(65534).gid(65534);
        }
        let said = lines(command.current_dir("/").spawn().unwrap());
        modes(0o755, 0o644);
        said
    };
    let names = || {
        let entries = std::fs::read_dir(&folder).unwrap();
        let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name()).collect();
        names.sort();
        names
    };
    let before = names();
    let said = looked_at(&folder);
    assert!(said.contains(&"looked 1 3".to_owned()), "{said:?}");
    let refused = |said: &[String], part: &str| {
        let last = said.iter().find(|line| line.starts_with("refused"));
        let last = last.unwrap_or_else(|| panic!("{said:?}"));
        assert!(last.contains(part), "{last}");
    };
    refused(
        &said,
        "this study can only be read; copy its folder to a disk that can be written",
    );
    assert_eq!(names(), before);
    assert_eq!(whole(&StudyStore::open(&folder).unwrap()), 3);
    refused(
        &looked_at(&unclosed),
        "make the folder and its files writable for this user, or open a copy of the whole folder",
    );
    assert_eq!(whole(&StudyStore::open(&unclosed).unwrap()), 3);
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
    let mut store = StudyStore::open_waiting(folder.path(), wait).unwrap();
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
    // Of two programs that run the same session, the second to write gets an error.
    let mut second = StudyStore::open(folder.path()).unwrap();
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
