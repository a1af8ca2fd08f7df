//! What README and guide tell a user to do is done, in its order.
//!
//! Each document runs in a folder of its own, which is empty at first. A block in `sh` is run by bash; it fails with its first command
//! that fails. What a document says beside its blocks:
//!
//! - `<!-- not run: REASON -->` on the line before a block: it is not run, as it waits for a person, needs hardware or another program. Its
//!   commands must exist all the same.
//! - `<!-- file NAME -->` on the line before a block: its text becomes that file.
//! - `# exit code 3` at the end of a line: the command ends with this code.
#![cfg(unix)]
#![allow(
    clippy::print_stderr,
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test fails where it cannot go on, and says what it did not run"
)]

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::support::{COMMANDS, Folder, noise, wav};
use piezotact::quantity::{Drive, SampleRate};
use piezotact::resample::resample;
use piezotact_dataset::{ReadOptions, read_recording};

fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

/// A line of shell as words, with what stands in quotes kept together.
fn words(line: &str) -> Vec<&str> {
    line.split(['"', '\''])
        .enumerate()
        .flat_map(|(i, part)| {
            if i % 2 == 1 {
                vec![part]
            } else {
                part.split_whitespace().collect()
            }
        })
        .collect()
}

/// A block of a document between two fences.
struct Block {
    language: String,
    /// What stands between `<!--` and `-->` on the line before.
    note: Option<String>,
    line: usize,
    text: String,
}

fn blocks(document: &str) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut before = "";
    let mut lines = document.lines().enumerate();
    while let Some((at, line)) = lines.next() {
        let Some(language) = line.trim_start().strip_prefix("```") else {
            before = line.trim();
            continue;
        };
        let indent = line.len() - line.trim_start().len();
        let note = before
            .strip_prefix("<!--")
            .and_then(|rest| rest.strip_suffix("-->"));
        let text: String = lines
            .by_ref()
            .map(|(_, line)| line)
            .take_while(|line| line.trim_start() != "```")
            .map(|line| format!("{}\n", line.get(indent..).unwrap_or_default()))
            .collect();
        blocks.push(Block {
            language: language.trim().to_owned(),
            note: note.map(|note| note.trim().to_owned()),
            line: at + 1,
            text,
        });
        before = "";
    }
    blocks
}

/// A block as a script: a line that says its exit code ends with it.
fn script(block: &Block) -> String {
    let mut script = String::from("trap 'echo \"stopped at: $BASH_COMMAND\" >&2' ERR\n");
    for line in block.text.lines() {
        match line.rsplit_once("# exit code ") {
            Some((command, code)) => {
                script += &format!("code=0; {command} || code=$?; test $code = {code}\n");
            }
            None => script += &format!("{line}\n"),
        }
    }
    script
}

/// The commands of the program that a line calls, such as `panel add`, must exist.
fn known(place: &str, line: &str) {
    for (_, call) in line
        .match_indices("piezotact ")
        .map(|(at, name)| (at, &line[at + name.len()..]))
    {
        let called = words(call);
        let named = called.first().copied().unwrap_or_default();
        let both = called.iter().take(2).copied().collect::<Vec<_>>().join(" ");
        let groups = COMMANDS.iter().any(|c| c.starts_with(&format!("{named} ")));
        let exists = COMMANDS.contains(&both.as_str()) || (COMMANDS.contains(&named) && !groups);
        assert!(
            exists || named.starts_with('-'),
            "{place} names `piezotact {both}`"
        );
    }
}

/// Runs the blocks of a document; `prepare` puts what a user's own hardware measures into the folder before each block.
fn run(document: &str, prepare: impl Fn(&Folder, &str)) -> Folder {
    let text = std::fs::read_to_string(root().join(document)).unwrap();
    let folder = Folder::new();
    let program = Path::new(env!("CARGO_BIN_EXE_piezotact")).parent().unwrap();
    let path = std::env::join_paths(std::iter::once(program.to_owned()).chain(
        std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default()),
    ));
    let path = path.unwrap();
    let mut ran = 0;
    for block in blocks(&text) {
        let place = format!("{document}:{}", block.line);
        if let Some(name) = block.note.as_deref().and_then(|n| n.strip_prefix("file ")) {
            folder.write(name, &block.text);
            continue;
        }
        let reason = block
            .note
            .as_deref()
            .and_then(|n| n.strip_prefix("not run: "));
        if let Some(reason) = reason {
            for line in block
                .text
                .lines()
                .filter(|line| line.trim_start().starts_with("piezotact "))
            {
                known(&place, line);
            }
            eprintln!("{place} is not run: {reason}");
            continue;
        }
        if block.language != "sh" {
            let hidden = block
                .text
                .lines()
                .find(|line| line.trim_start().starts_with("piezotact "));
            assert_eq!(hidden, None, "{place}: neither run nor said why it is not");
            continue;
        }
        prepare(&folder, &block.text);
        let done = Command::new("bash")
            .args(["-eu", "-c", &script(&block)])
            .current_dir(folder.path(""))
            .env("PATH", &path)
            .stdin(std::process::Stdio::null())
            .output()
            .unwrap();
        assert!(
            done.status.success(),
            "{place}: {}\n{}",
            String::from_utf8_lossy(&done.stderr),
            String::from_utf8_lossy(&done.stdout)
        );
        ran += 1;
    }
    assert!(ran > 0, "{document} runs nothing");
    folder
}

/// What the commands of a document leave.
fn expect_files(folder: &Folder, names: &[&str]) {
    for name in names {
        assert!(folder.path(name).exists(), "the commands leave no {name}");
    }
}

#[test]
fn the_readme_runs() {
    let folder = run("README.md", |folder, block| {
        if block.contains("setup.toml") {
            // The loop within the program, as no device is here.
            folder.write("setup.toml", crate::audio::setup(""));
        }
    });
    expect_files(
        &folder,
        &["demo/report.html", "strokes.html", "report.html"],
    );
}

#[test]
fn the_chapter_of_the_tribologist_runs() {
    let folder = run("docs/guide/tribologist.md", |_, _| ());
    expect_files(&folder, &["speeds.html", "figures"]);
}

#[test]
fn the_chapter_of_the_haptics_engineer_runs() {
    let folder = run("docs/guide/haptics.md", |_, _| ());
    expect_files(&folder, &["fingers.html", "wrong.html", "both.html"]);
}

#[test]
fn the_chapter_of_the_psychophysicist_runs() {
    let folder = run("docs/guide/psychophysicist.md", |_, _| ());
    expect_files(&folder, &["design.html", "answers.html", "figures"]);
}

#[test]
fn the_chapter_on_exchanged_levels_runs() {
    let folder = run("docs/guide/exchanged.md", |_, _| ());
    let made = [
        "stimuli.html",
        "answers.html",
        "spectra.html",
        "own-or-average.html",
    ];
    expect_files(&folder, &made);
}

#[test]
fn the_chapter_of_the_neuroscientist_runs() {
    let folder = run("docs/guide/neuroscientist.md", |_, _| ());
    expect_files(&folder, &["P01.html", "stats.html", "figures"]);
}

#[test]
fn the_chapter_on_sessions_runs() {
    let folder = run("docs/guide/sessions.md", |_, _| ());
    expect_files(&folder, &["prepared.html", "align.html", "tables"]);
}

#[test]
fn the_chapter_of_the_twin_runs() {
    let folder = run("docs/guide/twin.md", |_, _| ());
    expect_files(&folder, &["speeds.html", "figures"]);
}

/// What stands in them for Python and MATLAB is run by `py/tests/test_guide.py`.
#[test]
fn the_chapters_on_python_and_matlab_run() {
    let folder = run("docs/guide/python.md", |_, _| ());
    expect_files(&folder, &["S8.parquet", "S8.wav", "hand.json"]);
    run("docs/guide/matlab.md", |_, _| ());
}

#[test]
fn the_chapter_on_bids_runs() {
    run("docs/guide/bids-touch.md", |_, _| ());
}

#[test]
fn the_chapter_on_files_runs() {
    let folder = run("docs/guide/files.md", |folder, block| {
        if block.contains("own.csv") {
            own_measurement(folder);
        } else {
            own_files(folder);
        }
    });
    expect_files(&folder, &["own-tf.json", "inertance.json"]);
}

/// The table of contents has every page of the guide, and each that has commands has a test.
#[test]
fn the_guide_has_all_its_pages() {
    let contents = std::fs::read_to_string(root().join("docs/guide/SUMMARY.md")).unwrap();
    let tests = include_str!("docs.rs");
    for page in pages("docs/guide") {
        let name = page.strip_prefix("docs/guide/").unwrap();
        assert!(
            name == "SUMMARY.md" || contents.contains(&format!("]({name})")),
            "SUMMARY.md lacks {name}"
        );
        let text = std::fs::read_to_string(root().join(&page)).unwrap();
        let runs = blocks(&text).iter().any(|block| block.language == "sh");
        assert!(
            !runs || tests.contains(&format!("run(\"{page}\"")),
            "{page} is not run"
        );
    }
}

/// The pages of a folder, as paths from the root of the checkout.
fn pages(folder: &str) -> Vec<String> {
    let entries = std::fs::read_dir(root().join(folder)).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let pages = names.filter(|name| name.ends_with(".md"));
    pages.map(|name| format!("{folder}/{name}")).collect()
}

/// The files of the guide that come from a user's own hardware, of a device that is known: 3 m/s² a volt.
fn own_files(folder: &Folder) {
    folder.write("texture.wav", wav(noise(20_000).map(|v| v * 0.01), 5_000));
    let rows = noise(60_000)
        .enumerate()
        .map(|(i, v)| format!("{},{},{}\n", i as f64 / 5000.0, v, 3.0 * v));
    let rows: String = rows.collect();
    folder.write(
        "bench.csv",
        format!("time (s),drive (V),nail (m/s2)\n{rows}"),
    );
    folder.write("hits.csv", crate::impact::four_hits());
}

/// What that device answers to `own-drive.wav`, as `own.csv`.
fn own_measurement(folder: &Folder) {
    let drive = read_recording(&folder.path("own-drive.wav"), &ReadOptions::default());
    let drive = drive.unwrap().recording.series::<Drive>(None).unwrap();
    let felt = resample(&drive, SampleRate::new(5000.0).unwrap()).unwrap();
    let rows = felt.samples().iter().enumerate();
    let rows = rows.map(|(i, v)| format!("{},{:.9}\n", i as f64 / 5000.0, 3.0 * 1.41 * v));
    let rows: String = rows.collect();
    folder.write("own.csv", format!("time (s),nail (m/s2)\n{rows}"));
}

#[test]
fn links_of_the_documents_lead_somewhere() {
    let mut documents = pages("docs/guide");
    documents.extend(
        [
            "README.md",
            "ARCHITECTURE.md",
            "CONTRIBUTING.md",
            "CHANGELOG.md",
        ]
        .map(String::from),
    );
    for document in documents {
        let document = PathBuf::from(document);
        let text = std::fs::read_to_string(root().join(&document)).unwrap();
        let place = root().join(document.parent().unwrap());
        let document = document.display();
        for link in text
            .split("](")
            .skip(1)
            .filter_map(|rest| rest.split(')').next())
            .filter(|link| !link.starts_with("https://"))
        {
            let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
            assert!(place.join(file).exists(), "{document} links to {link}");
            let slug = |heading: &str| {
                heading
                    .trim_start_matches('#')
                    .trim()
                    .to_lowercase()
                    .replace(' ', "-")
            };
            let there = match file {
                "" => text.clone(),
                _ if anchor.is_empty() => continue,
                _ => std::fs::read_to_string(place.join(file)).unwrap(),
            };
            assert!(
                there
                    .lines()
                    .any(|line| line.starts_with('#') && slug(line) == anchor),
                "{document}: {link}"
            );
        }
        for path in text
            .split('`')
            .skip(1)
            .step_by(2)
            .filter(|code| code.starts_with("crates/"))
        {
            assert!(root().join(path).exists(), "{document} names {path}");
        }
    }
}

/// The files that the chapter on extending the program names exist, its commands run, and the tests that it names are modules of a
/// test program.
#[test]
fn what_the_guide_says_of_extending_the_program_is_true() {
    run("docs/guide/extending.md", |_, _| ());
    let text = std::fs::read_to_string(root().join("docs/guide/extending.md")).unwrap();
    let programs: String = std::fs::read_dir(root().join("crates"))
        .unwrap()
        .filter_map(|krate| {
            std::fs::read_to_string(krate.unwrap().path().join("tests/all.rs")).ok()
        })
        .collect();
    let (mut files, mut tests) = (0, 0);
    for path in text.split('`').skip(1).step_by(2) {
        if ["crates/", "docs/", "golden/"]
            .iter()
            .any(|start| path.starts_with(start))
        {
            assert!(root().join(path).exists(), "{path} is named");
            files += 1;
        }
    }
    for line in text.lines() {
        if let Some(module) = line.strip_prefix("cargo test --workspace --test all ") {
            let module = module.trim_end_matches("::");
            let named = programs.contains(&format!("mod {module};"));
            assert!(named, "the tests {module} are named");
            tests += 1;
        }
    }
    assert!(files >= 25 && tests >= 5, "{files} files, {tests} tests");
}
