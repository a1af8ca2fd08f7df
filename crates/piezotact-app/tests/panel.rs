//! `panel` as a black box: a small campaign on the twin from end to end, fingers with the bench's artefact taken out,
//! three measured hands against NumPy, and refusals.
#![allow(
    clippy::print_stderr,
    clippy::unwrap_used,
    reason = "a test prints what it measured, and fails where it cannot go on"
)]

use std::f64::consts::TAU;
use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering};

use crate::support::{self, Folder, noise, shared, wav};
use piezotact::quantity::{Degrees, Newtons};
use piezotact::statistics::rms;
use piezotact_dataset::{TransferDocument, read_transfer, write_transfer};
use serde_json::Value;

const RUN: &str = "panel run --bench twin:seed=7 --participants 1..3 --loads 0.2,0.6 --angles 20 --repeats 2 --seconds 4 --out panel";

fn run(folder: &Folder, line: &str) -> support::Done {
    let words: Vec<&str> = line.split(' ').collect();
    folder.run(&words)
}

fn index(folder: &Folder) -> Value {
    serde_json::from_slice(&std::fs::read(folder.path("panel/panel.json")).unwrap()).unwrap()
}

/// Twelve measurements; what is there is not measured again, what a crash left behind is taken up, and what is lost is
/// measured again to the same bytes. Then report, table, average, and a texture rendered with it.
#[test]
fn a_campaign_runs_goes_on_and_is_analysed() {
    let folder = Folder::new();
    let first = run(&folder, &format!("{RUN} --json")).json();
    assert_eq!(
        (first["measured"].as_u64(), first["measurements"].as_u64()),
        (Some(12), Some(12))
    );
    // What each was accepted by, rule by rule.
    let accepted = first["entries"].as_array().unwrap();
    assert_eq!(accepted.len(), 12);
    for one in accepted {
        let attempts = one["attempts"].as_array().unwrap();
        let rules: Vec<[&str; 2]> = attempts[attempts.len() - 1]["criteria"]
            .as_array()
            .unwrap()
            .iter()
            .map(|rule| ["what", "outcome"].map(|field| rule[field].as_str().unwrap()))
            .collect();
        assert_eq!(rules, [["force", "met"], ["coherence", "met"]], "{one}");
    }
    assert_eq!(run(&folder, &format!("{RUN} --json")).json()["measured"], 0);

    // Between a file and the index: the file is there, and not listed.
    let mut listed = index(&folder);
    let entries = listed["entries"].as_array_mut().unwrap();
    let (lost, left) = (entries.remove(7), entries.remove(3));
    let (lost, left) = (
        lost["file"].as_str().unwrap(),
        left["file"].as_str().unwrap(),
    );
    assert_eq!(left, "P01_20deg_0.6N_p1_r2.json");
    std::fs::write(folder.path("panel/panel.json"), listed.to_string()).unwrap();
    let bytes = std::fs::read(folder.path(&format!("panel/{lost}"))).unwrap();
    std::fs::remove_file(folder.path(&format!("panel/{lost}"))).unwrap();
    let reported = run(&folder, "panel analyse panel --json").json();
    assert!(
        reported["warnings"].to_string().contains(left),
        "{}",
        reported["warnings"]
    );
    let again = run(&folder, &format!("{RUN} --json")).json();
    assert_eq!(
        (again["measured"].as_u64(), again["there_already"].as_u64()),
        (Some(1), Some(11))
    );
    assert!(bytes == std::fs::read(folder.path(&format!("panel/{lost}"))).unwrap());

    // A damaged file is kept beside, and measured again to the same bytes.
    folder.write(&format!("panel/{lost}"), "{");
    let repaired = run(&folder, &format!("{RUN} --json"));
    assert_eq!(repaired.json()["measured"], 1);
    assert!(bytes == std::fs::read(folder.path(&format!("panel/{lost}"))).unwrap());
    assert!(folder.path(&format!("panel/{lost}.damaged1")).exists());
    // Measurements of another campaign under the same names are not taken over: there is no index that says so.
    std::fs::create_dir(folder.path("moved")).unwrap();
    std::fs::copy(
        folder.path(&format!("panel/{lost}")),
        folder.path(&format!("moved/{lost}")),
    )
    .unwrap();
    run(
        &folder,
        &RUN.replace("--out panel", "--out moved")
            .replace("seed=7", "seed=8"),
    )
    .expect_failure(2, &["no index, but", lost, "panel add"]);
    run(
        &folder,
        &RUN.replace("--seconds 4", "--gate off --seconds 4"),
    )
    .expect_failure(2, &["no gate", "another folder"]);

    let more = run(
        &folder,
        "panel run --bench twin:seed=7 --participants 4 --loads 0.2,0.6 --angles 20 --repeats 2 --seconds 4 --out panel",
    );
    more.expect_success();
    let said = run(
        &folder,
        "panel analyse panel --report panel.html --csv panel.csv --json",
    )
    .json();
    assert_eq!(
        (said["measurements"].as_u64(), said["complete"].as_u64()),
        (Some(16), Some(4))
    );
    let lengths = ["members", "accepted"].map(|list| said[list].as_array().unwrap().len());
    assert_eq!(lengths, [16, 16]);
    assert_eq!(
        (said["kind"].as_str(), said["will_the_average_do"].as_str()),
        (Some("device"), Some("not decided"))
    );
    let db = |value: &Value| value.as_f64().unwrap();
    // Two of the twin's numbers: people spread by 6 dB at most, and press 0.6 N some 2.3 dB louder than 0.2 N.
    assert!((1.0..9.0).contains(&db(&said["worst"]["max_deviation_db"])));
    assert!((1.0..4.0).contains(&db(&said["load_steps"][0]["mean_db"])));
    assert_eq!(said["load_steps"][0]["rising"], 4);
    assert!(db(&said["repeatability"]["lying"]["median_db_rms"]) < 0.5);
    assert!(said["repeatability"]["put_back"].is_null());
    assert!(db(&said["repeatability"]["components"][0]["persons_share"]) > 0.8);
    let report = std::fs::read_to_string(folder.path("panel.html")).unwrap();
    for part in [
        "Whether the average is sufficient at 20°, 0.2 N is not decided: ",
        "participants with an error within 3 dB rms",
        "At which load and angle participants differ most is not decided; the largest measured deviation is at 20°, 0.2 N: ",
        "1000 random halves of these 4 participants",
        "Maximum deviation by load and angle",
        "Number of participants needed",
        "16 measurements in the averages, 16 of them with all criteria met.",
        "16 measurements were checked window by window",
        "median coherence of the excited lines",
        "no person took part",
        "twin:seed=7,gain=B3: random, 4 s",
    ] {
        assert!(report.contains(part), "{part}");
    }
    let table = std::fs::read_to_string(folder.path("panel.csv")).unwrap();
    assert!(table.starts_with("angle_deg,load_n,low_hz,high_hz,participants,max_deviation_db"));
    assert_eq!(table.lines().count(), 1 + 2 * 6);
    let words = run(&folder, "panel analyse panel").out();
    assert!(
        words.contains(
            "It would be decided by at least 6 participants measured at every load and angle"
        ),
        "{words}"
    );

    for average in ["complex", "log-magnitude"] {
        let line =
            format!("panel average panel --load 0.2 --average {average} --out average.json --json");
        let made = run(&folder, &line).json();
        assert_eq!(made["participants"].as_array().unwrap().len(), 4);
        let written = std::fs::read_to_string(folder.path("average.json")).unwrap();
        assert!(
            written.contains("participants P01, P02, P03, P04")
                && written.contains("penalty_db_rms")
        );
        assert!(!written.contains("\"participant\""));
    }
    folder.write("texture.wav", wav(noise(20_000).map(|v| v * 0.01), 5_000));
    folder
        .run(&[
            "render",
            "texture.wav",
            "--scale",
            "200 m/s2",
            "--transfer",
            "average.json",
            "--out",
            "drive.wav",
        ])
        .expect_success();
}

/// Fingers on the shaker: the dip of 12 dB at 265 Hz is in all, and gone with the control.
#[test]
fn fingers_are_freed_of_the_bench_s_artefact() {
    let folder = Folder::new();
    let record = |more: &str, name: &str, input: &str| {
        run(
            &folder,
            &format!("twin record --bench shaker --seconds 20 {more} --out {name}.parquet"),
        )
        .expect_success();
        let line = format!(
            "transfer {name}.parquet --drive {input} --response acceleration --out {name}.json"
        );
        run(&folder, &line).expect_success();
    };
    record("--control", "control", "drive");
    for participant in 1..=3 {
        let name = format!("finger{participant}");
        record(
            &format!("--participant {participant} --load 0.4"),
            &name,
            "force",
        );
        run(&folder, &format!("panel add fingers {name}.json")).expect_success();
    }
    let said = run(
        &folder,
        "panel analyse fingers --control control.json --report fingers.html --json",
    )
    .json();
    assert_eq!(
        (said["kind"].as_str(), said["measurements"].as_u64()),
        (Some("finger"), Some(3))
    );
    let artefact = &said["artefact"];
    assert!(
        (artefact["at_hz"].as_f64().unwrap() - 265.0).abs() < 5.0,
        "{artefact}"
    );
    for finger in artefact["fingers"].as_array().unwrap() {
        let depth = |when: &str| finger[when]["depth_db"].as_f64().unwrap();
        assert!(depth("before") > 6.0 && depth("after") < 1.0, "{finger}");
    }
    let report = std::fs::read_to_string(folder.path("fingers.html")).unwrap();
    assert!(report.contains("Compensation of the dip of the bench"));
    // A control of other lines.
    run(&folder, "transfer control.parquet --drive drive --response acceleration --segment 1024 --out coarse.json").expect_success();
    run(&folder, "panel analyse fingers --control coarse.json")
        .expect_failure(1, &["513 lines", "1025 lines", "the same rate and segment"]);
    // A finger is no control: nothing narrow is left once the dip is.
    run(
        &folder,
        "panel analyse fingers --control control.json --band 400..1000",
    )
    .expect_failure(1, &["no dip of", "without a finger"]);
}

/// One transfer function, changed in one thing, and a little in another: no two measurements are the same bit by bit.
fn changed(from: &Path, to: &Path, change: impl FnOnce(&mut TransferDocument)) {
    static CHANGES: AtomicU32 = AtomicU32::new(1);
    let mut document = read_transfer(from).unwrap();
    document.real[7] *= 1.0 + 1e-9 * f64::from(CHANGES.fetch_add(1, Ordering::Relaxed));
    change(&mut document);
    write_transfer(to, &document).unwrap();
}

#[test]
fn what_does_not_belong_in_a_panel_is_refused() {
    let folder = Folder::new();
    run(&folder, "panel analyse gone").expect_failure(1, &["gone", "no such folder", "panel run"]);
    std::fs::create_dir(folder.path("empty")).unwrap();
    for line in ["panel analyse empty", "panel average empty --out a.json"] {
        run(&folder, line).expect_failure(1, &["empty", "panel.json", "none in it"]);
    }
    for (number, name) in [(1, "a"), (2, "b")] {
        let line = format!(
            "characterise --bench twin:participant={number},seed=7 --seconds 4 --out {name}.json"
        );
        run(&folder, &line).expect_success();
    }
    run(&folder, "panel add panel a.json").expect_success();
    run(&folder, "panel analyse panel").expect_failure(1, &["at least 2 participants", "found 1"]);
    let kept = std::fs::read(folder.path("panel/panel.json")).unwrap();
    // Repeats of different people.
    run(&folder, "panel add panel b.json --participant P01")
        .expect_failure(1, &["cannot mix participants", "P01", "P02"]);
    run(&folder, "panel add panel b.json --load 0.4")
        .expect_failure(1, &["measured at 20°, 0.2 N"]);
    // The same again is there already; the same as another placement, or another measurement in its place, is refused.
    for line in [
        "panel add panel a.json",
        "panel add panel a.json --repeat 1",
    ] {
        let again = run(&folder, line);
        again.expect_success();
        assert!(
            again
                .err()
                .contains("a.json is there already as participant P01"),
            "{}",
            again.err()
        );
    }
    run(&folder, "panel add panel a.json --placement 2")
        .expect_failure(1, &["bit-identical", "placement 2"]);
    let line = "characterise --bench twin:participant=1,seed=8 --seconds 4 --out again.json";
    run(&folder, line).expect_success();
    run(&folder, "panel add panel again.json --repeat 1")
        .expect_failure(1, &["participant P01", "twice"]);
    changed(&folder.path("b.json"), &folder.path("bare.json"), |d| {
        d.about.condition = piezotact::recording::Condition::default();
    });
    for (filed, part) in [
        ("--participant P09 --load 0 --angle 20", "the load of"),
        ("--participant P09 --load -1 --angle 20", "the load of"),
        ("--participant P09 --load 0.2 --angle 91", "the angle of"),
        (
            "--participant a/b --load 0.2 --angle 20",
            "the participant of",
        ),
    ] {
        run(&folder, &format!("panel add panel bare.json {filed}")).expect_failure(1, &[part]);
    }
    run(&folder, "panel add panel b.json --load nan").expect_failure(2, &["number", "NaN"]);
    let line = "characterise --bench twin:participant=2,seed=7 --seconds 4 --segment 1024 --out coarse.json";
    run(&folder, line).expect_success();
    run(&folder, "panel add panel coarse.json")
        .expect_failure(1, &["different lines", "1025 lines", "513 lines"]);
    let path = |name: &str| folder.path(name);
    changed(&path("b.json"), &path("nobody.json"), |d| {
        d.about.condition.participant = None
    });
    run(&folder, "panel add panel nobody.json")
        .expect_failure(1, &["participant", "--participant"]);
    changed(&path("b.json"), &path("nowhere.json"), |d| {
        d.about.condition.load_n = None
    });
    run(&folder, "panel add panel nowhere.json").expect_failure(1, &["load", "--load"]);
    changed(&path("b.json"), &path("force.json"), |d| {
        d.drive_unit = "N".to_owned().into()
    });
    run(&folder, "panel add panel force.json")
        .expect_failure(1, &["from FS", "from N", "separate panels"]);
    changed(&path("b.json"), &path("louder.json"), |d| {
        if let Some(setup) = &mut d.drive {
            setup.volts_per_full_scale *= 2.0;
        }
    });
    run(&folder, "panel add panel louder.json")
        .expect_failure(1, &["different device", "V at full scale"]);
    assert!(kept == std::fs::read(folder.path("panel/panel.json")).unwrap());
    // The index, one measurement, and the lock.
    assert_eq!(std::fs::read_dir(folder.path("panel")).unwrap().count(), 3);

    // What a file does not say can be stated.
    run(
        &folder,
        "panel add panel nobody.json --participant P07 --placement 2",
    )
    .expect_success();
    run(&folder, "panel add panel b.json").expect_success();
    run(&folder, "panel analyse panel --band 3000..4000")
        .expect_failure(1, &["no line of the transfer functions", "widen"]);
    run(&folder, "panel analyse panel --criterion 0").expect_failure(2, &["criterion above zero"]);
    run(&folder, "panel analyse panel --csv panel/panel.json")
        .expect_failure(2, &["is read and would be replaced"]);
    run(&folder, "panel average panel --load 0.5 --out a2.json")
        .expect_failure(2, &["20°, 0.2 N", "no match"]);
    run(
        &folder,
        "panel average panel --out panel/P02_20deg_0.2N_p1_r1.json",
    )
    .expect_failure(2, &["would be replaced"]);
    changed(&path("b.json"), &path("heavy.json"), |d| {
        d.about.condition.load_n = Some(Newtons(0.4))
    });
    run(&folder, "panel add panel heavy.json").expect_success();
    run(&folder, "panel average panel --angle 20 --out a2.json")
        .expect_failure(2, &["20°, 0.2 N; 20°, 0.4 N", "choose one"]);
    assert!(!folder.path("a2.json").exists());

    // A file that went missing, and an index that was damaged.
    std::fs::remove_file(folder.path("panel/P02_20deg_0.2N_p1_r1.json")).unwrap();
    for line in [
        "panel analyse panel",
        "panel average panel --load 0.2 --out a2.json",
        "panel add panel a.json",
    ] {
        run(&folder, line).expect_failure(
            1,
            &["P02_20deg_0.2N_p1_r1.json", "no file", "participant P02"],
        );
    }
    let index = String::from_utf8(kept).unwrap();
    folder.write("panel/panel.json", &index[..index.len() / 2]);
    for line in [
        "panel analyse panel",
        "panel average panel --out a2.json",
        "panel add panel a.json",
    ] {
        run(&folder, line).expect_failure(1, &["panel.json", "expected the index of a panel"]);
    }
}

#[test]
fn campaigns_that_cannot_be_are_refused_before_they_begin() {
    let folder = Folder::new();
    for (more, parts) in [
        ("--participants 3..1", &["1..5"] as &[&str]),
        ("--participants 1 --loads 0.2,0.2", &["once", "0.2 N twice"]),
        ("--participants 1 --loads -1", &["expected"]),
        ("--participants 1 --loads nan", &["expected"]),
        ("--participants 1 --angles 400", &["expected"]),
        ("--participants 1 --seconds 0", &["expected"]),
        ("--participants 1 --repeats 0", &["repeats"]),
        ("--participants 1 --segment 1", &["segment"]),
    ] {
        run(
            &folder,
            &format!("panel run --bench twin:seed=7 --out panel {more}"),
        )
        .expect_failure(2, parts);
        assert!(!folder.path("panel").exists(), "{more}");
    }
    run(&folder, "panel run --bench twin:seed=7 --participants 1 --loads 0.2 --angles 20 --repeats 1 --seconds 4 --out panel").expect_success();
    run(&folder, "panel run --bench twin:seed=8 --participants 1 --loads 0.2 --angles 20 --repeats 1 --seconds 4 --out panel")
        .expect_failure(2, &["twin:seed=7", "twin:seed=8", "another folder"]);
}

/// Six programs file at once: everybody waits for the others, and nothing is lost. A multisine keeps its distortion.
#[test]
fn measurements_that_are_added_at_once_are_all_there() {
    let folder = Folder::new();
    run(&folder, "panel run --bench twin:seed=7 --participants 1 --loads 0.2 --angles 20 --repeats 1 --excitation multisine --seconds 10 --out sines").expect_success();
    let sines = read_transfer(&folder.path("sines/P01_20deg_0.2N_p1_r1.json")).unwrap();
    assert!(sines.distortion.is_some());
    for number in 1..=6 {
        changed(
            &folder.path("sines/P01_20deg_0.2N_p1_r1.json"),
            &folder.path(&format!("{number}.json")),
            |d| {
                d.real[10] += f64::from(number) * 1e-3;
            },
        );
    }
    std::thread::scope(|scope| {
        for number in 1..=6 {
            let folder = &folder;
            scope.spawn(move || {
                run(folder, &format!("panel add panel {number}.json")).expect_success();
            });
        }
    });
    let mut repeats: Vec<u64> = index(&folder)["entries"]
        .as_array()
        .unwrap()
        .iter()
        .map(|entry| entry["repeat"].as_u64().unwrap())
        .collect();
    repeats.sort_unstable();
    assert_eq!(repeats, [1, 2, 3, 4, 5, 6]);
}

/// The strongest axis of a measured hand: its index, and its impulse response.
fn strongest(path: &Path) -> (usize, Vec<f64>) {
    const SAMPLES: usize = 522;
    let bytes = std::fs::read(path).unwrap();
    let all: Vec<f64> = bytes
        .chunks_exact(4)
        .map(|b| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])))
        .collect();
    let axes: Vec<&[f64]> = all.chunks_exact(SAMPLES).collect();
    let best = (0..axes.len()).max_by(|a, b| rms(axes[*a]).total_cmp(&rms(axes[*b])));
    (best.unwrap(), axes[best.unwrap()].to_vec())
}

/// Its transfer function, by the defining sum. The set says neither load nor angle: 1 N and 0° stand for that.
fn hand(who: &str, impulse: &[f64]) -> TransferDocument {
    const RATE_HZ: f64 = 1300.0;
    let n = impulse.len();
    let lines = 0..=n / 2;
    let sum = |k: usize, part: fn(f64) -> f64| -> f64 {
        // Whole turns are left out, so that the angle stays exact.
        let turn = |i: usize| TAU * ((i * k) % n) as f64 / n as f64;
        impulse
            .iter()
            .enumerate()
            .map(|(i, h)| h * part(turn(i)))
            .sum()
    };
    let mut document: TransferDocument = serde_json::from_value(serde_json::json!({
        "drive_unit": "N",
        "response_unit": "m/s2",
        "rate_hz": RATE_HZ,
        "frequency_hz": lines.clone().map(|k| k as f64 * RATE_HZ / n as f64).collect::<Vec<_>>(),
        "real": lines.clone().map(|k| sum(k, f64::cos)).collect::<Vec<_>>(),
        "imaginary": lines.clone().map(|k| -sum(k, f64::sin)).collect::<Vec<_>>(),
        "coherence": vec![1.0; n / 2 + 1],
    }))
    .unwrap();
    document.about.condition.participant = Some(who.into());
    document.about.condition.load_n = Some(Newtons(1.0));
    document.about.condition.angle_deg = Some(Degrees(0.0));
    document
}

/// Three measured hands through `panel add`, `analyse` and `average`: all numbers as NumPy has them (golden/panel.py).
/// The defining sum and NumPy's FFT differ in rounding alone, 1e-13 of the largest value, which is 1e-8 dB where a hand
/// answers 100 dB less: 1e-6 dB is asked for.
#[test]
fn three_measured_hands_are_as_numpy_has_them() {
    const TOLERANCE_DB: f64 = 1e-6;
    let Some(hands) = shared("data/frf/skinsource") else {
        return;
    };
    let golden: Value = serde_json::from_str(include_str!("golden/panel.json")).unwrap();
    let folder = Folder::new();
    for model in 1..=3 {
        let (axis, impulse) = strongest(&hands.join(format!("model-{model}-location-07.f32")));
        assert_eq!(golden["axes"][model - 1], axis);
        write_transfer(
            &folder.path(&format!("{model}.json")),
            &hand(&format!("hand {model}"), &impulse),
        )
        .unwrap();
    }
    run(&folder, "panel add panel 1.json 2.json 3.json").expect_success();
    let said = run(
        &folder,
        "panel analyse panel --band 20..600 --report panel.html --json",
    )
    .json();
    let same = |found: &Value, expected: &Value, what: &str| {
        let (found, expected) = (found.as_f64().unwrap(), expected.as_f64().unwrap());
        assert!(
            (found - expected).abs() < TOLERANCE_DB,
            "{what}: {found}, NumPy {expected}"
        );
    };
    let spread = &said["spreads"][0];
    let bundle = &spread["bundle"];
    let whole = &golden["whole"];
    same(
        &bundle["max_deviation_db"],
        &whole["max_deviation_db"],
        "deviation",
    );
    same(&bundle["max_deviation_at_hz"], &whole["at_hz"], "its place");
    same(&spread["spread_rms_db"], &whole["spread_rms_db"], "spread");
    let parts = golden["parts"].as_array().unwrap();
    assert_eq!(spread["bands"].as_array().unwrap().len(), parts.len());
    for (found, expected) in spread["bands"].as_array().unwrap().iter().zip(parts) {
        assert_eq!(found["band_hz"], expected["band_hz"]);
        for key in ["max_deviation_db", "at_hz", "spread_rms_db"] {
            same(&found[key], &expected[key], key);
        }
        eprintln!(
            "{}: {:.2} dB",
            found["band_hz"],
            found["max_deviation_db"].as_f64().unwrap()
        );
    }
    let average = &said["averages"][0];
    for (key, penalties) in [("log_magnitude_db", 0), ("complex_db", 1)] {
        let lines = |value: &Value| value[key].as_array().unwrap().clone();
        let (found, expected) = (lines(average), lines(&golden));
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(&expected) {
            same(found, expected, key);
        }
        let name = ["penalties_log_magnitude", "penalties_complex"][penalties];
        let people = average["penalties"][penalties]["people"]
            .as_array()
            .unwrap();
        for (found, expected) in people.iter().zip(golden[name].as_array().unwrap()) {
            same(&found["db_rms"], &expected["db_rms"], name);
            same(&found["db_max"], &expected["db_max"], name);
            eprintln!("{name}: {found}");
        }
    }
    same(
        &average["difference"]["mean_db"],
        &golden["difference_mean_db"],
        "difference",
    );
    same(
        &average["difference"]["lowest_db"],
        &golden["difference_lowest_db"],
        "lowest difference",
    );
    for (point, expected) in said["learning"][0]["points"]
        .as_array()
        .unwrap()
        .iter()
        .zip(golden["learning_db"].as_array().unwrap())
    {
        same(&point["mean_db_rms"], expected, "learning curve");
    }
    // Hands differ more than fingers do, and three say too little.
    assert_eq!(said["will_the_average_do"], "not decided");
    run(
        &folder,
        "panel average panel --band 20..600 --out average.json",
    )
    .expect_success();
    let averaged = read_transfer(&folder.path("average.json")).unwrap();
    let found = averaged.real[100].hypot(averaged.imaginary[100]).log10() * 20.0;
    let line = average["log_magnitude_db"][100 - 9].as_f64().unwrap();
    assert!((found - line).abs() < TOLERANCE_DB, "{found} {line}");
}
