//! The values that the program gives, held against tables that were stored before its code was redesigned.
//!
//! Chains of commands run in a folder each, over the twin and over measured files of `../shared/data`. What a command
//! prints as JSON, and every file that it writes, becomes rows of field path and value (`same_numbers/rows.rs`); the rows
//! are held against `golden/same_numbers/CHAIN.json` field by field. A stored field that is missing now fails, unless
//! `RENAMED` says where it went. New fields are free.
//!
//! The tables are written again, only where numbers are meant to change, by
//! `PIEZOTACT_WRITE_GOLDEN=1 cargo test --locked --workspace --test same_numbers`.
#![allow(
    clippy::print_stderr,
    clippy::unwrap_used,
    reason = "a test says what it skipped, and fails where it cannot go on"
)]

#[path = "same_numbers/rows.rs"]
mod rows;
#[path = "same_numbers/schema.rs"]
mod schema;
mod support;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use rows::{Checksums, Rows, differences, file_rows, json_rows};
use support::{Folder, noise, shared, wav};

/// Fields that have another path now: a run of segments in the stored path, and what stands there now. `CHANGELOG.md`
/// repeats this list.
const RENAMED: &[(&str, &str)] = &[];

/// Touch on the twin: recordings, strokes, comparisons, a surface.
const TOUCH: &[&str] = &[
    "twin record --bench acttouch --sample S4 --participant 3 --speed 30mm/s --strokes 3 --out S4.parquet",
    "twin record --bench acttouch --sample S8 --participant 3 --speed 30mm/s --strokes 3 --out S8.parquet",
    "twin record --bench acttouch --sample M8 --participant 2 --free --strokes 2 --seed 5 --out M8.wav",
    "twin record --bench triboair --sample S4 --participant 3 --speed 20mm/s --strokes 2 --out T4_20.parquet",
    "twin record --bench triboair --sample S4 --participant 3 --speed 30mm/s --strokes 2 --out T4_30.parquet",
    "twin record --bench acttouch --sample S4 --participant 4 --speed 30mm/s --strokes 3 --out P4.parquet",
    "info S4.parquet",
    "info M8.wav",
    "segment S4.parquet --write-cuts S4.cuts --csv cuts.csv",
    "segment T4_20.parquet",
    "analyse S4.parquet S8.parquet --by sample --csv strokes.csv",
    "analyse T4_20.parquet --high-pass none --segment 2048 --ridge 0.545mm",
    "compare S4.parquet S8.parquet --by sample",
    "compare T4_20.parquet T4_30.parquet --by speed",
    "compare S4.parquet P4.parquet --by participant",
    "compare S4.parquet T4_30.parquet --by touch",
    "spectrum S4.parquet --channel acceleration",
    "spectrum S4.parquet --channel acceleration --segment 2048 --window blackman-harris --median",
    "manipulate S8.parquet --stroke 2 --band 50..100:+6dB --loop 2s --out stroke.wav",
    "twin surface S4 --size 3mm --step 10um --out S4.sur",
    "twin surface M8 --size 3mm --step 20um --seed 2 --out M8.sur",
    "roughness S4.sur",
    "roughness M8.sur --cutoff 0.8mm --form poly2",
];

/// A device on the twin: transfer functions, drives open and closed, playback, verification, manipulation, export.
const DEVICE: &[&str] = &[
    "characterise --bench twin:participant=1,seed=7 --seconds 10 --out tf.json --record raw.parquet",
    "characterise --bench twin:participant=2,seed=7 --seconds 10 --repeats 2 --out tf2.json",
    "characterise --bench twin:participant=1,seed=7 --seconds 6 --excitation sweep --out sweep.json",
    "characterise --bench twin:participant=1,seed=7 --seconds 10 --excitation multisine --out multisine.json",
    "info tf.json",
    "transfer raw.parquet --drive drive --response acceleration --estimator h2 --out h2.json",
    "transfer raw.parquet --drive drive --response acceleration --estimator hv --segment 1024 --out hv.json",
    "twin record --bench shaker --participant 3 --load 0.4 --duration 5s --out finger.parquet",
    "twin record --bench shaker --control --duration 5s --out control.parquet",
    "transfer finger.parquet --drive force --response acceleration --out finger.json",
    "render texture.wav --scale 200m/s2 --transfer tf.json --level fit --inverse plain --out plain.wav",
    "render texture.wav --scale 200m/s2 --transfer tf.json --level fit --inverse constant --out constant.wav",
    "render texture.wav --scale 200m/s2 --transfer tf.json --level fit --inverse coherence --out coherence.wav",
    "render texture.wav --scale 200m/s2 --transfer tf.json --level fit --inverse drive-limited --out limited.wav",
    "render texture.wav --scale 200m/s2 --transfer tf.json --level -3 --phase minimum --band 30..500 --out minimum.wav",
    "play plain.wav --bench twin:participant=1,seed=7 --record measured.parquet",
    "info measured.parquet",
    "verify --target texture.wav --scale 200m/s2 --measured measured.parquet --transfer tf.json",
    "score texture.wav measured.parquet --scale 200m/s2",
    "play plain.wav --bench measured:tf2.json,seed=7 --record rehearsed.parquet",
    "verify --target texture.wav --scale 200m/s2 --measured rehearsed.parquet --also measured.parquet",
    "render texture.wav --scale 200m/s2 --transfer tf.json --mode texture --bench twin:participant=1,seed=7 --iterations 2 --level fit --out loop_t.wav --record loop_t.parquet",
    "render texture.wav --scale 200m/s2 --transfer tf.json --mode replicate --bench twin:participant=1,seed=7 --iterations 2 --level fit --out loop_r.wav --record loop_r.parquet",
    "render texture.wav --scale 200m/s2 --transfer tf.json --mode replicate --inverse drive-limited --bench measured:tf2.json,seed=7 --iterations 1 --level fit --out loop_m.wav",
    "manipulate texture.wav --scale 200m/s2 --band 50..100:+6dB --tilt 3dB/oct@200Hz --gain -3dB --loop 2s --out m1.wav",
    "manipulate texture.wav --scale 200m/s2 --shift 20Hz --warp 1.25:keep-length --randomise-phases --seed 7 --out m2.wav",
    "manipulate texture.wav --scale 200m/s2 --rms-of m1.wav --spectrum-of m2.wav --out m3.wav",
    "verify --target m1.wav --measured measured.parquet --before texture.wav --scale 200m/s2",
    "render m1.wav m2.wav --transfer tf.json --transfer tf2.json --level fit --out batch",
    "export texture.wav --scale 200m/s2 --out texture.haptic",
    "export texture.wav --scale 200m/s2 --out texture.ahap",
    "export plain.wav --transfer tf.json --out plain.hjif",
    "export tf.json --out tf.uff",
    "info tf.uff",
];

/// A panel of the twin's people, and what is rendered with its averages and placements.
const PANEL: &[&str] = &[
    "panel run --bench twin:seed=7 --participants 1..3 --loads 0.2,0.6 --angles 20 --repeats 2 --seconds 4 --out panel",
    "panel analyse panel --csv panel.csv",
    "panel analyse panel --average complex --band 30..500 --criterion 1",
    "panel average panel --load 0.2 --average complex --out complex.json",
    "panel average panel --load 0.6 --out average.json",
    "characterise --bench twin:participant=9,seed=7 --seconds 6 --out tf.json",
    "panel add filed tf.json",
    "render texture.wav --scale 200m/s2 --transfer complex.json --level fit --out drive.wav",
    "play drive.wav --bench measured:tf.json,seed=7,panel=panel,placement=2 --record placed.parquet",
    "verify --target texture.wav --scale 200m/s2 --measured placed.parquet",
];

/// A chapter of the thesis on the twin, and the demo.
const THESIS: &[&str] = &[
    "replay --chapter 6 --out replay",
    "demo --out demo --seed 3",
];

/// Measured files of others; `DATA` is their folder.
const FILES: &[&str] = &[
    "info DATA/vibration/textsense/text3_v1.wav --scale 1m/s2",
    "spectrum DATA/vibration/textsense/text3_v1.wav --scale 1m/s2",
    "analyse DATA/vibration/textsense/text3_v1.wav DATA/vibration/textsense/text9_v1.wav --scale 1m/s2 --by file",
    "score DATA/vibration/textsense/text3_v2.wav DATA/vibration/textsense/text9_v2.wav --scale 100m/s2",
    "manipulate DATA/vibration/textsense/text3_v2.wav --scale 100m/s2 --gain 3dB --out louder.wav",
    "segment DATA/vibration/fabricslide/Board2mm_F135_V-10mmps_0.csv",
    "compare DATA/vibration/fabricslide/Board2mm_F135_V-5mmps_0.csv DATA/vibration/fabricslide/Board2mm_F135_V-10mmps_0.csv DATA/vibration/fabricslide/Board2mm_F135_V-20mmps_0.csv --meta {sample}_F{load:N}_V-{speed:mm/s}mmps_{repeat} --by speed",
    "info DATA/vibration/hapmat/fabric_1.csv",
    "spectrum DATA/vibration/hapmat/fabric_1.csv --channel accel_x",
    "info DATA/frf/vibrationtesting/case1.mat",
    "info DATA/frf/uff/Sample_UFF58b_bin.uff",
    "info DATA/frf/uff/Sample_UFF58_ascii.uff",
    "spectrum DATA/frf/uff/Sample_UFF58b_bin.uff",
    "info DATA/frf/lvm/short.lvm",
    "info DATA/frf/lvm/long_single_header_multi_ch.lvm",
    "roughness DATA/topography/surfcom/specimen_1_primary.tx1",
    "roughness DATA/topography/surfcom/specimen_1_primary.tx1 --standard iso21920 --cutoff 2.5mm",
    "roughness DATA/topography/surfacetopography/plu-1.plu",
    "roughness DATA/topography/surfacetopography/al3d-1.al3d",
    "roughness DATA/topography/surfacetopography/x3p-2.x3p",
    "roughness DATA/topography/nanovea/test1.txt --x-unit mm --z-unit um",
    "info DATA/haptic/haptic/3_points.haptic --scale 1m/s2",
    "info DATA/haptic/hjif/0.hmpg --scale 1m/s2",
    "spectrum DATA/haptic/haptic/long_clip.haptic --scale 1m/s2",
];

#[test]
fn touch_on_the_twin_gives_the_stored_values() {
    check("touch", TOUCH);
}

#[test]
fn a_device_on_the_twin_gives_the_stored_values() {
    check("device", DEVICE);
}

#[test]
fn a_panel_on_the_twin_gives_the_stored_values() {
    check("panel", PANEL);
}

#[test]
fn a_chapter_of_the_thesis_and_the_demo_give_the_stored_values() {
    check("thesis", THESIS);
}

#[test]
fn measured_files_give_the_stored_values() {
    check("files", FILES);
}

/// A comparison that finds nothing proves nothing: what it has to find, it finds.
#[test]
fn a_changed_value_a_lost_field_and_a_changed_sample_are_found() {
    let rows = |json: serde_json::Value| {
        let mut rows = Rows::new();
        json_rows(&mut rows, "printed", &json);
        rows
    };
    let stored = rows(serde_json::json!({
        "level_db": 1.25, "verdict": "passed", "psd": (0..40).map(f64::from).collect::<Vec<_>>(),
        "doubts": [{"text": "one"}], "steps": [{"gain_db": 2.0}],
    }));
    let found = |json: serde_json::Value, renamed: &[(&str, &str)]| -> Vec<String> {
        differences(&stored, &rows(json), renamed, Checksums::Compared)
    };
    let same = |level: f64, changed: f64| {
        let psd: Vec<f64> = (0..38).map(f64::from).chain([changed, 39.0]).collect();
        serde_json::json!({
            "level_db": level, "verdict": "passed", "psd": psd, "new": 3,
            "doubts": [{"text": "another sentence", "code": "x"}], "steps": [{"gain_db": 2.0}],
        })
    };
    assert_eq!(found(same(1.25 * (1.0 + 1e-11), 38.0), &[]), [""; 0]);
    assert_eq!(found(same(1.25 * (1.0 + 1e-8), 38.0), &[]).len(), 1);
    // One sample in forty that is not among those kept: the sum and the rms tell.
    assert_eq!(found(same(1.25, 38.001), &[]).len(), 2);

    let mut renamed = same(1.25, 38.0);
    let object = renamed.as_object_mut().unwrap();
    let steps = object.remove("steps").unwrap();
    object.insert("about".into(), serde_json::json!({ "steps": steps }));
    let lost = found(renamed.clone(), &[]);
    assert!(
        lost.len() == 2 && lost[1].contains("printed.steps[0].gain_db is missing"),
        "{lost:?}"
    );
    assert_eq!(found(renamed, &[("steps", "about.steps")]), [""; 0]);

    let mut other = same(1.25, 38.0);
    other["verdict"] = "not passed".into();
    other["doubts"] = serde_json::json!([]);
    assert_eq!(found(other, &[]).len(), 2);
}

/// A schema that everything fits proves nothing.
#[test]
fn a_lost_field_another_type_and_another_version_do_not_fit_the_schema() {
    let play = |change: fn(&mut serde_json::Value)| {
        let mut document = serde_json::json!({
            "schema": "play", "version": 1, "record": "r.parquet", "rate_hz": 5000.0,
            "duration_s": 1.5, "provenance": { "source": "a bench", "steps": [] }, "doubts": [],
        });
        change(&mut document);
        schema::differences(&document)
    };
    assert_eq!(play(|_| ()), [""; 0]);
    assert_eq!(play(|d| d["version"] = 2.into()).len(), 1);
    assert_eq!(play(|d| d["record"] = 1.into()).len(), 1);
    assert!(play(|d| drop(d.as_object_mut().unwrap().remove("doubts")))[0].contains("doubts"));
    assert!(!play(|d| d["doubts"] = serde_json::json!([{ "code": "x" }])).is_empty());
    assert!(play(|d| d["schema"] = "plays".into())[0].contains("plays.json"));
}

#[test]
fn the_changelog_repeats_what_was_renamed() {
    let changelog = include_str!("../../../CHANGELOG.md");
    for (old, new) in RENAMED {
        let line = format!("`{old}` → `{new}`");
        assert!(changelog.contains(&line), "CHANGELOG.md lacks {line}");
    }
}

fn golden(chain: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/golden/same_numbers/{chain}.json"))
}

/// Runs the commands of `chain` one after the other in one folder, and holds what they give against the stored table.
#[track_caller]
fn check(chain: &str, commands: &[&str]) {
    let folder = Folder::new();
    folder.write("texture.wav", wav(noise(15_000).map(|v| v * 0.01), 5_000));
    let mut found: BTreeMap<String, Rows> = BTreeMap::new();
    for command in commands {
        if let Some(rows) = rows_of(&folder, command) {
            found.insert((*command).to_owned(), rows);
        }
    }
    let file = golden(chain);
    if std::env::var_os("PIEZOTACT_WRITE_GOLDEN").is_some() {
        assert_eq!(found.len(), commands.len(), "a table needs every command");
        // How a document was made names a temporary folder and a version.
        for rows in found.values_mut() {
            rows.retain(|key, _| !key.contains(".invocation."));
        }
        std::fs::create_dir_all(file.parent().unwrap()).unwrap();
        std::fs::write(&file, rows::table(&rows::machine(), &found)).unwrap();
        return;
    }
    let stored: serde_json::Value = serde_json::from_slice(&std::fs::read(&file).unwrap()).unwrap();
    let checksums = match stored["machine"] == rows::machine().as_str() {
        true => Checksums::Compared,
        false => {
            eprintln!(
                "checksums of samples are not compared: stored on {}, and this is {}",
                stored["machine"],
                rows::machine()
            );
            Checksums::LeftOut
        }
    };
    let mut wrong = Vec::new();
    for (command, rows) in &found {
        let stored = rows::of_table(&stored["commands"][command]);
        assert!(
            !stored.is_empty(),
            "{} holds no `{command}`",
            file.display()
        );
        for difference in differences(&stored, rows, RENAMED, checksums) {
            wrong.push(format!("{command}\n    {difference}"));
        }
    }
    let shown: Vec<&str> = wrong.iter().take(40).map(String::as_str).collect();
    assert!(
        wrong.is_empty(),
        "{} values differ from {}, the first of them:\n{}",
        wrong.len(),
        file.display(),
        shown.join("\n")
    );
}

/// The rows of one command: its exit code, what it prints, and every file that it writes. None where a measured file is not
/// there.
#[track_caller]
fn rows_of(folder: &Folder, command: &str) -> Option<Rows> {
    let data = match command.contains("DATA/") {
        true => shared("data")?.to_string_lossy().into_owned(),
        false => String::new(),
    };
    let words: Vec<String> = command
        .split(' ')
        .map(|word| word.replace("DATA", &data))
        .chain(["--json".into()])
        .collect();
    let before = contents(&folder.path(""));
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let done = folder.run(&words);
    let mut rows = Rows::new();
    rows.insert("exit code".into(), done.code().into());
    let printed = serde_json::from_str(&done.out())
        .unwrap_or_else(|error| panic!("{command}: {error}: {}", done.err()));
    let unlike = schema::differences(&printed);
    assert!(unlike.is_empty(), "{command}: {unlike:#?}");
    json_rows(&mut rows, "printed", &printed);
    for (name, bytes) in contents(&folder.path("")) {
        if before.get(&name) != Some(&bytes) {
            file_rows(&mut rows, &folder.path(&name), &name, &bytes);
        }
    }
    // What names the place of the measured files differs from checkout to checkout.
    for value in rows.values_mut() {
        if let Some(text) = value.as_str().filter(|_| !data.is_empty()) {
            *value = text.replace(&data, "DATA").into();
        }
    }
    Some(rows)
}

/// The files below a folder, by their names in it.
fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut folders = BTreeSet::from([folder.to_owned()]);
    while let Some(next) = folders.pop_first() {
        for entry in std::fs::read_dir(&next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.insert(path);
            } else {
                let name = path
                    .strip_prefix(folder)
                    .unwrap()
                    .to_string_lossy()
                    .into_owned();
                files.insert(name, std::fs::read(&path).unwrap());
            }
        }
    }
    files
}
