//! The values that the program gives, held against a table that was stored before its code was redesigned, as those of `piezotact` are.
//!
//! The table is written again, only where numbers are meant to change, by
//! `PIEZOTACT_WRITE_GOLDEN=1 cargo test --locked --workspace --test all -- same_numbers`.

use std::collections::BTreeMap;
use std::path::Path;

use crate::rows::{Checksums, Rows, differences, file_rows, json_rows, machine, of_table, table};
use crate::support::Folder;

/// Fields that have another path now: a run of segments in the stored path, and what stands there now.
const RENAMED: &[(&str, &str)] = &[("findings", "chapters[0].findings")];

#[test]
fn a_chapter_of_the_thesis_gives_the_stored_values() {
    gives_the_stored_values(3);
}

#[test]
#[ignore = "chapter 6 takes a minute: ./x soak runs it"]
fn soak_chapter_6_gives_the_stored_values() {
    gives_the_stored_values(6);
}

/// A chapter of the thesis on the twin.
fn gives_the_stored_values(chapter: u8) {
    let command = format!("replay --chapter {chapter} --out replay");
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden");
    let file = golden.join(format!("replay-{chapter}.json"));
    let mut found = rows_of(&Folder::new(), &command);
    if std::env::var_os("PIEZOTACT_WRITE_GOLDEN").is_some() {
        // How a document was made names a temporary folder and a version.
        found.retain(|key, _| !key.contains(".invocation."));
        let rows = BTreeMap::from([(command, found)]);
        std::fs::write(&file, table(&machine(), &rows)).unwrap();
        return;
    }
    let stored: serde_json::Value = serde_json::from_slice(&std::fs::read(&file).unwrap()).unwrap();
    let checksums = match stored["machine"] == machine().as_str() {
        true => Checksums::Compared,
        false => Checksums::LeftOut,
    };
    let stored = of_table(&stored["commands"][&command]);
    assert!(!stored.is_empty(), "{} holds no {command}", file.display());
    let wrong = differences(&stored, &found, RENAMED, checksums);
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// The rows of a command: its exit code, what it prints, and every file that it writes.
fn rows_of(folder: &Folder, command: &str) -> Rows {
    let words: Vec<&str> = command.split(' ').chain(["--json"]).collect();
    let done = folder.run(&words);
    let mut rows = Rows::new();
    rows.insert("exit code".into(), done.code().into());
    json_rows(&mut rows, "printed", &done.json());
    for file in std::fs::read_dir(folder.path("replay")).unwrap() {
        let path = file.unwrap().path();
        let name = format!("replay/{}", path.file_name().unwrap().to_string_lossy());
        let bytes = std::fs::read(&path).unwrap();
        file_rows(&mut rows, &path, &name, &bytes);
    }
    rows
}
