//! What a person reads, as it was reviewed: the help of every command, and printed text with its warnings. What a program parses is held
//! by `docs/schemas/` and `same_numbers.rs`.
//!
//! `INSTA_UPDATE=always cargo test --locked --workspace snapshots` writes the snapshots again; read the difference before it is committed.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use crate::support::{COMMANDS, Folder, noise, wav};

/// A chain of commands from a twin's recording to a verdict, a panel and a surface; its last word is the name of the snapshot.
const CHAIN: &[(&str, &str)] = &[
    (
        "twin record --bench acttouch --sample S4 --participant 3 --speed 30mm/s --strokes 3 --out S4.parquet",
        "record",
    ),
    (
        "twin record --bench acttouch --sample S8 --participant 3 --speed 30mm/s --strokes 3 --out S8.parquet",
        "",
    ),
    ("info S4.parquet", "info"),
    ("strokes S4.parquet --report cuts.html --cuts-only", "cuts"),
    (
        "strokes S4.parquet S8.parquet --by sample --csv strokes.csv",
        "strokes",
    ),
    ("compare S4.parquet S8.parquet --by sample", "compare"),
    ("spectrum S4.parquet --channel acceleration", "spectrum"),
    ("spectrum S4.parquet --channel acceleration --rest", "rest"),
    (
        "manipulate S8.parquet --stroke 2 --band 50..100:+6dB --loop 2s --out texture.wav",
        "manipulate",
    ),
    (
        "characterise --bench twin:participant=1,seed=7 --seconds 6 --out tf.json --record raw.parquet",
        "characterise",
    ),
    (
        "transfer raw.parquet --drive drive --response acceleration --out again.json",
        "transfer",
    ),
    (
        "render texture.wav --transfer tf.json --level fit --out drive.wav",
        "render",
    ),
    (
        "render texture.wav --transfer tf.json --mode texture --level fit --bench twin:participant=1,seed=7 --iterations 1 --out loop.wav",
        "loop",
    ),
    (
        "play drive.wav --bench twin:participant=1,seed=7 --record measured.parquet",
        "play",
    ),
    (
        "verify --target texture.wav --measured measured.parquet --transfer tf.json",
        "verify",
    ),
    ("score texture.wav measured.parquet", "score"),
    ("export texture.wav --out texture.haptic", "export"),
    (
        "panel run --bench twin:seed=7 --participants 1..3 --loads 0.2 --angles 20 --repeats 2 --seconds 4 --out panel",
        "panel_run",
    ),
    ("panel analyse panel", "panel_analyse"),
    ("panel average panel --out average.json", "panel_average"),
    (
        "twin surface S4 --size 2mm --step 20um --out S4.sur",
        "surface",
    ),
    ("roughness S4.sur", "roughness"),
];

#[test]
fn the_help_of_every_command() {
    let folder = Folder::new();
    for command in ["", "strokes --all"].iter().chain(COMMANDS) {
        let arguments: Vec<&str> = command.split_whitespace().chain(["--help"]).collect();
        let help = folder.run(&arguments).out();
        let name = format!("help {}", command.replace("--", ""));
        insta::assert_snapshot!(name.trim().replace(' ', "_"), help);
    }
}

#[test]
fn printed_text() {
    let folder = Folder::new();
    folder.write("texture.wav", wav(noise(10_000).map(|v| v * 0.2), 5_000));
    for (command, name) in CHAIN {
        let arguments: Vec<&str> = command.split_whitespace().collect();
        let done = folder.run(&arguments);
        if name.is_empty() {
            continue;
        }
        let text = format!(
            "$ piezotact {command}\n{}\n-- warnings and progress\n{}-- exit code {:?}",
            done.out(),
            done.err(),
            done.code()
        );
        insta::assert_snapshot!(format!("text_{name}"), text);
    }
}
