//! What a command keeps of the commands before it, as a black box.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

mod support;

use support::{Done, Folder};

/// A folder with the script of a fake without faults.
fn prepared() -> Folder {
    let folder = Folder::new();
    folder.write("good.toml", "seed = 1\n");
    folder
}

fn run(folder: &Folder, line: &str) -> Done {
    let words: Vec<&str> = line.split(' ').collect();
    folder.run(&words)
}

/// The recordings in a folder of runs.
fn recordings(folder: &Folder, name: &str) -> Vec<String> {
    let entries = std::fs::read_dir(folder.path(name)).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned());
    let mut names: Vec<String> = names.filter(|name| name.contains(".parquet")).collect();
    names.sort();
    names
}

/// A panel whose raw recordings were kept keeps them when it goes on with `--discard-raw`.
#[test]
fn only_the_raw_recordings_of_the_command_are_discarded() {
    let folder = prepared();
    let panel = "panel run --bench fake:good.toml --participants 1 --angles 20 --seconds 4 --repeats 1 --out p";
    run(&folder, &format!("{panel} --loads 0.2")).expect_success();
    let kept = recordings(&folder, "p/raw");
    assert_eq!(kept.len(), 1);
    let more = run(
        &folder,
        &format!("{panel} --loads 0.2,0.4,0.6 --discard-raw"),
    );
    more.expect_success();
    assert_eq!(recordings(&folder, "p/raw"), kept);
    let said = "discarded 2 raw recordings of this command; 1 of before is kept in p/raw";
    assert!(more.err().contains(said), "{}", more.err());
    let alone = run(
        &folder,
        &format!("{panel} --loads 0.2 --discard-raw").replace("--out p", "--out q"),
    );
    alone.expect_success();
    assert!(
        alone
            .err()
            .contains("discarded 1 raw recording of this command\n"),
        "{}",
        alone.err()
    );
    assert!(!folder.path("q/raw").exists());
}
