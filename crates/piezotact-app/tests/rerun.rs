//! Reports and documents say how they were made, and are made again.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::path::Path;

use serde_json::Value;

use crate::support::{Done, Folder, noise, wav};

fn run(folder: &Folder, line: &str) -> Done {
    let words: Vec<&str> = line.split(' ').collect();
    folder.run_as_given(&words)
}

/// Commands that leave a report or print a document, in an order in which each has its inputs.
const MADE: &[&str] = &[
    "twin record --bench acttouch --sample S4 --participant 3 --speed 30mm/s --strokes 3 --out S4.parquet",
    "twin record --bench acttouch --sample S8 --participant 3 --speed 30mm/s --strokes 3 --out S8.parquet",
    "info S4.parquet",
    "strokes S4.parquet --report segment.html --cuts-only",
    "strokes S4.parquet S8.parquet --by sample --csv strokes.csv --report analyse.html",
    "compare S4.parquet S8.parquet --by sample --report compare.html",
    "spectrum S4.parquet --channel acceleration",
    "spectrum S4.parquet --channel acceleration --report noise.html --rest",
    "manipulate S8.parquet --stroke 2 --band 50..100:+6dB --gain -3dB --loop 1s --out m.wav --report manipulate.html",
    "characterise --bench twin:participant=1,seed=7 --seconds 4 --out tf.json --record raw.parquet --report characterise.html",
    "transfer raw.parquet --drive drive --response acceleration --out again.json --report transfer.html",
    "render m.wav --transfer tf.json --level fit --out drive.wav",
    "render m.wav --transfer tf.json --mode texture --level fit --bench twin:participant=1,seed=7 --iterations 1 --out loop.wav --report loop.html",
    "play drive.wav --bench twin:participant=1,seed=7 --record measured.parquet",
    "verify --target m.wav --measured measured.parquet --transfer tf.json --report verify.html",
    "score m.wav measured.parquet --report score.html",
    "export m.wav --out m.haptic",
    "panel run --bench twin:seed=7 --participants 1..3 --loads 0.2 --angles 20 --repeats 2 --seconds 4 --out panel",
    "panel analyse panel --report panel.html",
    "panel average panel --out average.json",
    "twin surface S4 --size 2mm --step 20um --out S4.sur",
    "roughness S4.sur --report roughness.html",
];

/// Every kind of report and document, and every number of them.
#[cfg(feature = "every-command")]
#[test]
fn every_report_and_document_is_made_again_with_the_same_values() {
    let folder = Folder::new();
    for (i, command) in MADE.iter().enumerate() {
        let printed = run(&folder, &format!("{command} --json"));
        assert!(
            matches!(printed.code(), Some(0 | 3..=5)),
            "{}",
            printed.err()
        );
        folder.write(&format!("document-{i}.json"), printed.out());
    }
    let made = folder.names().into_iter();
    let made: Vec<String> = made
        .filter(|name| name.ends_with(".html") || name.starts_with("document-"))
        .collect();
    assert_eq!(made.len(), 12 + MADE.len(), "{made:?}");
    let before = folder.names();
    for name in &made {
        let again = run(&folder, &format!("rerun {name} --json"));
        let found = again.json();
        assert_eq!(found["same"], true, "{name}: {found}");
        assert_eq!(found["changed"], serde_json::json!([]), "{name}");
        let least = if name.ends_with(".html") { 15 } else { 4 };
        assert!(
            found["compared"].as_u64().unwrap() > least,
            "{name}: {found}"
        );
    }
    // Nothing is left in the folder, nor written over.
    assert_eq!(folder.names(), before);
}

#[test]
fn the_demo_and_a_chapter_of_the_thesis_are_made_again() {
    let folder = Folder::new();
    run(&folder, "demo --out demo --seed 3").expect_success();
    for name in ["demo/report.html", "demo/verification.json"] {
        let again = run(&folder, &format!("rerun {name}"));
        again.expect_success();
        assert!(again.out().starts_with("the same: "), "{}", again.out());
    }
}

/// A folder with a report and the document of a score.
fn scored() -> Folder {
    let folder = Folder::new();
    folder.write("a.wav", wav(noise(20_000), 5_000));
    folder.write("b.wav", wav(noise(20_000).map(|v| 0.7 * v), 5_000));
    let score = run(
        &folder,
        "score a.wav b.wav --scale 1m/s2 --report score.html --json",
    );
    score.expect_success();
    folder.write("score.json", score.out());
    folder
}

#[test]
fn a_document_says_how_it_was_made() {
    let folder = scored();
    let text = std::fs::read(folder.path("score.json")).unwrap();
    let document: Value = serde_json::from_slice(&text).unwrap();
    let made = &document["invocation"];
    assert_eq!(made["command"][1], "a.wav");
    assert_eq!(
        made["program"],
        concat!("piezotact ", env!("CARGO_PKG_VERSION"))
    );
    let folder_of = std::fs::canonicalize(folder.path(".")).unwrap();
    assert_eq!(made["folder"], folder_of.to_str().unwrap());
    let setting = |name: &str| {
        let settings = made["settings"].as_array().unwrap();
        settings
            .iter()
            .find(|setting| setting["name"] == name)
            .cloned()
    };
    assert_eq!(setting("scale").unwrap()["values"][0], "1m/s2");
    let band = setting("band").unwrap();
    assert_eq!(
        (&band["values"][0], &band["given"]),
        (&"20..1000".into(), &false.into())
    );
    let inputs = made["inputs"].as_array().unwrap();
    let of = |name: &str| inputs.iter().find(|input| input["path"] == name).unwrap();
    // As `sha256sum` says of the file.
    let sum = piezotact_dataset::reads::sha256(&std::fs::read(folder.path("a.wav")).unwrap());
    assert_eq!(of("a.wav")["sha256"], sum.as_str());
    assert_eq!(of("a.wav.json")["found"], "nothing");
    let report = std::fs::read_to_string(folder.path("score.html")).unwrap();
    for part in [
        "How this report was made",
        sum.as_str(),
        "<span>--scale</span> <span>1m/s2</span>",
        "All settings",
    ] {
        assert!(report.contains(part), "{part}");
    }
}

/// One seed gives the same values on every day: the date is beside the results.
#[test]
fn the_date_is_no_part_of_the_results() {
    let folder = scored();
    let on = |date: &str| {
        let score = format!("score a.wav b.wav --scale 1m/s2 --json --date {date}");
        let mut document = run(&folder, &score).json();
        let made = document
            .as_object_mut()
            .unwrap()
            .remove("invocation")
            .unwrap();
        (document, made)
    };
    let (first, made) = on("2024-03-01");
    let (second, later) = on("2026-11-22T18:00:00Z");
    assert_eq!(first, second);
    assert_eq!(made["date"], "2024-03-01T00:00:00Z");
    assert_eq!(later["date"], "2026-11-22T18:00:00Z");
    assert_eq!(made["results_sha256"], later["results_sha256"]);
    run(&folder, "info a.wav --date tomorrow").expect_failure(2, &["tomorrow", "2026-03-01"]);
}

#[test]
fn changed_missing_and_new_inputs_are_named() {
    let folder = scored();
    folder.write("b.wav", wav(noise(20_000).map(|v| 0.5 * v), 5_000));
    for name in ["score.html", "score.json"] {
        let changed = run(&folder, &format!("rerun {name}"));
        changed.expect_failure(3, &["b.wav: is another file now"]);
        assert!(!changed.err().contains("a.wav:"), "{}", changed.err());
        assert!(
            changed.out().starts_with("different: "),
            "{}",
            changed.out()
        );
    }
    folder.write("b.wav", wav(noise(20_000).map(|v| 0.7 * v), 5_000));
    let sidecar = r#"{"condition": {"sample": "S4"}}"#;
    folder.write("a.wav.json", sidecar);
    let new = run(&folder, "rerun score.json");
    assert!(
        new.err().contains("a.wav.json: is read now"),
        "{}",
        new.err()
    );
    std::fs::remove_file(folder.path("a.wav.json")).unwrap();
    run(&folder, "rerun score.json").expect_success();
    std::fs::remove_file(folder.path("a.wav")).unwrap();
    run(&folder, "rerun score.html").expect_failure(1, &["cannot be run again", "a.wav"]);
}

/// A study that is copied to another place is compared there.
#[test]
fn a_moved_study_is_made_again_where_it_stands_now() {
    let folder = scored();
    let there = Folder::new();
    for name in ["a.wav", "b.wav", "score.html"] {
        std::fs::rename(folder.path(name), there.path(name)).unwrap();
    }
    let elsewhere = Folder::new();
    let report = there.path("score.html");
    let again = elsewhere.run_as_given(&["rerun", report.to_str().unwrap()]);
    again.expect_success();
}

#[test]
fn a_report_that_was_edited_is_noticed() {
    let folder = scored();
    let report = std::fs::read_to_string(folder.path("score.html")).unwrap();
    folder.write(
        "score.html",
        report.replacen("</h2><p>", "</h2><p>Excellent. ", 1),
    );
    let again = run(&folder, "rerun score.html");
    again.expect_failure(3, &["the file itself was changed after it was written"]);
    assert!(again.out().contains("Excellent"), "{}", again.out());
    for (name, text) in [
        ("page.html", "<html><main>no</main></html>"),
        ("x.json", "{}"),
        ("bytes", "\u{1}"),
    ] {
        folder.write(name, text);
        let refused = run(&folder, &format!("rerun {name}"));
        refused.expect_failure(1, &[name, "says how it was made"]);
    }
}

/// What a person reads of how it was made is what was run: neither the command, nor a setting, nor a checksum can be edited unseen.
#[test]
fn a_report_whose_origin_was_edited_is_noticed() {
    let folder = scored();
    let report = std::fs::read_to_string(folder.path("score.html")).unwrap();
    let origin = report.rfind("<section id=\"invocation\">").unwrap();
    let (results, section) = report.split_at(origin);
    let shown = section.find("<span>score</span>").unwrap();
    let sum = section.find("<td").unwrap();
    let digit = sum + section[sum..].find(|c: char| c.is_ascii_digit()).unwrap();
    for (name, at, old, new) in [
        ("command.html", shown, "score", "score --jnd 3"),
        ("checksum.html", digit, &section[digit..=digit], "x"),
    ] {
        let edited = section[at..].replacen(old, new, 1);
        folder.write(name, format!("{results}{}{edited}", &section[..at]));
        let again = run(&folder, &format!("rerun {name}"));
        again.expect_failure(3, &[]);
        assert!(again.out().contains("changed by hand"), "{}", again.out());
    }
    // In a document: a setting, and the list of files.
    let made = run(&folder, "score a.wav b.wav --scale 1m/s2 --json").out();
    let mut document: Value = serde_json::from_str(&made).unwrap();
    for setting in document["invocation"]["settings"].as_array_mut().unwrap() {
        if setting["name"] == "jnd" {
            setting["values"] = serde_json::json!(["9"]);
        }
    }
    folder.write("setting.json", document.to_string());
    let mut document: Value = serde_json::from_str(&made).unwrap();
    document["invocation"]["inputs"] = serde_json::json!([]);
    folder.write("inputs.json", document.to_string());
    for (name, said) in [("setting.json", "setting jnd"), ("inputs.json", "a.wav")] {
        let again = run(&folder, &format!("rerun {name}"));
        again.expect_failure(3, &[]);
        assert!(again.out().contains(said), "{}", again.out());
    }
    // A report under another name is the same report.
    folder.write("renamed.html", report);
    run(&folder, "rerun renamed.html").expect_success();
}

/// Whoever edits the command in a report gets nothing written outside of the temporary folder, and no other command run.
#[test]
fn a_hostile_report_writes_nowhere_else() {
    let folder = scored();
    let text = std::fs::read_to_string(folder.path("score.json")).unwrap();
    let with = |change: &dyn Fn(&mut Value)| {
        let mut document: Value = serde_json::from_str(&text).unwrap();
        change(&mut document["invocation"]);
        folder.write("hostile.json", document.to_string());
        run(&folder, "rerun hostile.json")
    };
    let target = folder.path("victim.html");
    std::fs::write(&target, "mine").unwrap();
    let aim = target.to_str().unwrap();
    let words = |line: &str| Value::from(line.split(' ').collect::<Vec<_>>());
    let names = folder.names();
    let score = format!("score a.wav b.wav --scale 1m/s2 --json --report {aim}");
    with(&|made| made["command"] = words(&score)).expect_success();
    // Nor where the words are put together in another way, or lead to another command.
    for line in [
        format!("score a.wav b.wav --scale=1m/s2 --json --report={aim}"),
        format!("spectrum a.wav {aim} --json"),
        format!("twin record --bench shaker --seconds 1 --out {aim}.parquet --json"),
        "panel add panel tf.json".into(),
        "rerun score.json".into(),
        "--help".into(),
        "score a.wav b.wav; touch x".into(),
        String::new(),
    ] {
        let _whatever = with(&|made| made["command"] = words(&line));
        assert_eq!(std::fs::read_to_string(&target).unwrap(), "mine", "{line}");
        let mut after = folder.names();
        after.retain(|name| name != "hostile.json");
        assert_eq!(after, names, "{line}");
    }
    // Results are read from outputs alone.
    for below in ["../../etc/passwd", "/etc/passwd"] {
        let output = serde_json::json!({ "setting": "report", "below": below });
        let escaped = with(&|made| {
            made["command"] = words(&score);
            made["output"] = output.clone();
        });
        escaped.expect_failure(1, &["changed by hand"]);
    }
    assert!(!Path::new("x").exists());
}

/// What stood at an output before is kept beside it. It is no input: the report of the new measurement is made again without it.
#[test]
fn an_earlier_measurement_is_kept_and_is_no_input() {
    let folder = Folder::new();
    let characterise = |seed: u32| {
        let line = format!(
            "characterise --bench twin:participant=1,seed={seed} --seconds 2 --out k.json --report k.html --force"
        );
        run(&folder, &line).expect_success();
    };
    characterise(7);
    let first = std::fs::read(folder.path("k.json")).unwrap();
    characterise(8);
    let kept = std::fs::read(folder.path("k.json.before-1")).unwrap();
    assert!(
        kept == first,
        "the first measurement is not the one that is kept"
    );
    run(&folder, "rerun k.html").expect_success();
}

/// A demo with another seed keeps what it measured before; one with the same seed has nothing to keep.
#[test]
fn a_demo_keeps_what_it_measured_before() {
    let folder = Folder::new();
    let demo = |seed: u32| run(&folder, &format!("demo --out d --seed {seed}")).expect_success();
    demo(1);
    let first = ["d/tf.json", "d/target.wav"].map(|name| std::fs::read(folder.path(name)).unwrap());
    demo(1);
    for name in ["d/tf.json.before-1", "d/target.wav.before-1"] {
        assert!(
            !folder.path(name).exists(),
            "{name} is kept of the same demo"
        );
    }
    demo(2);
    let kept = ["d/tf.json.before-1", "d/target.wav.before-1"]
        .map(|name| std::fs::read(folder.path(name)).unwrap());
    assert!(kept == first, "what was measured first is not what is kept");
}
