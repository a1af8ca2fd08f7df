//! `piezotact campaign design` and `protocol` as a black box.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use serde_json::Value;

use crate::support::{Folder, results};

const DESIGN: [&str; 2] = ["campaign", "design"];

fn design(folder: &Folder, more: &[&str]) -> crate::support::Done {
    folder.run(&[&DESIGN[..], more].concat())
}

/// The faults by name.
fn faults(document: &Value) -> Vec<Value> {
    let faults = document["report"]["faults"].as_array().unwrap();
    faults.iter().map(|found| found["fault"].clone()).collect()
}

fn fault(document: &Value, name: &str) -> Option<Value> {
    faults(document).into_iter().find(|f| f["fault"] == name)
}

/// A protocol of the library, changed in one place.
fn changed(folder: &Folder, name: &str, from: &str, to: &str) -> String {
    let toml = folder.run(&["campaign", "protocol", name]).out();
    assert!(toml.contains(from), "{from}");
    folder.write("own.toml", toml.replacen(from, to, 1));
    "own.toml".into()
}

#[test]
fn table_5_leaves_47_of_78_pairs_untested() {
    let folder = Folder::new();
    let done = design(&folder, &["isotropic_triplets", "--report", "r.html"]);
    done.expect_success();
    let out = done.out();
    for part in [
        "31 of 78 pairs are together in a set (26 in 1 set, 5 in 2 sets). The other 47 are never: untested, which is not 0 %.",
        "47 of 78 pairs are never together in a set",
        "Better: 26 sets put 78 of 78 pairs together. Cost: 26 sets for each participant instead of 12",
        "shared by two participants, at most 13 sets",
        "leaves 0 of 14 in position, with Kendall's τ 0.714",
        "measurement 42 min, discrimination 90 min (21.0 min of it textures play); 132 min in all",
        "The source has 60 min for measurement, not 42. It also has the measurement of the transfer function",
        "The source has 90 min for discrimination: as here.",
        "14 samples, 13 of them in 12 sets of 3",
        "report: r.html",
    ] {
        assert!(out.contains(part), "no `{part}` in: {out}");
    }
    let document = design(&folder, &["isotropic_triplets", "--json"]).json();
    assert_eq!(document["schema"], "campaign_design");
    let never = fault(&document, "pairs_never_together").unwrap();
    assert_eq!(
        (&never["together"], &never["pairs"]),
        (&31.into(), &78.into())
    );
    assert_eq!(never["rarest"][0]["sample"], "S6");
    assert_eq!(never["rarest"][1]["sample"], "S11");
    let better = &document["report"]["faults"][0]["better"]["change"];
    assert_eq!(better["sets"].as_array().unwrap().len(), 26);
    assert_eq!(
        (&better["together"], &better["pairs"]),
        (&78.into(), &78.into())
    );
    assert!(fault(&document, "position_overstates_confusion").is_some());
    assert!(fault(&document, "answers_by_exclusion").is_none());
    // Both halves of the matrix, and one in the legend, in two formats.
    let page = std::fs::read_to_string(folder.path("r.html")).unwrap();
    let hatched = page.matches("class=\"untested\"").count();
    // The narrow format has no legend.
    assert_eq!(hatched, 2 * 2 * 47 + 1);
    assert!(
        page.contains("47 of 78 pairs") && page.contains("S1, S2, S5"),
        "{page}"
    );
}

#[test]
#[ignore = "many repetitions: ./x soak runs it"]
fn soak_table_4_holds_every_pair() {
    let folder = Folder::new();
    let done = design(&folder, &["periodic_pilot", "--report", "r.html"]);
    let out = done.out();
    assert!(
        out.contains("66 of 66 pairs are together in a set (60 in 1 set, 6 in 2 sets). Each sample stands in 5 sets."),
        "{out}"
    );
    assert!(!out.contains("never"), "{out}");
    let page = std::fs::read_to_string(folder.path("r.html")).unwrap();
    assert!(!page.contains("class=\"untested\"") && !page.contains("Hatched"));
    let document = design(&folder, &["periodic_pilot", "--json"]).json();
    assert_eq!(
        document["report"]["coverage"]["presentations"],
        serde_json::json!(vec![5; 12])
    );
    assert!(fault(&document, "pairs_never_together").is_none());
    // With enough people the only fault is gone, and it says so.
    let enough = design(&folder, &["periodic_pilot", "--participants", "40"]).out();
    assert!(
        enough.contains("No fault was found: 4 rules judged."),
        "{enough}"
    );
    // Nor is there none where a stated difference is found too rarely.
    let line = "periodic_pilot --participants 40 --power samples:M1,M8 --task task2 --shares 50,35";
    let rarely = design(&folder, &line.split(' ').collect::<Vec<_>>()).out();
    assert!(
        rarely.contains("1 fault found: of 5 rules judged, 1 not met.")
            && rarely.contains("M1 and M8: 40 participants find the stated difference in "),
        "{rarely}"
    );
    assert!(!rarely.contains("No fault"), "{rarely}");
    // One participant, as in the thesis: nothing is known of people.
    assert_eq!(document["campaign"]["participants"], 1);
    assert!(fault(&document, "interval_too_wide").is_some());
}

#[test]
fn table_6_is_answered_by_exclusion() {
    let folder = Folder::new();
    let document = design(&folder, &["amplitude_inversion", "--json"]).json();
    let found = fault(&document, "answers_by_exclusion").unwrap();
    assert_eq!(found["permutations"], 8);
    let sd = |name: &str| found[name].as_f64().unwrap();
    // √8, and √(24·2/9).
    assert!((sd("chance_sd") - 2.828).abs() < 1e-3);
    assert!((sd("chance_sd_independent") - 2.309).abs() < 1e-3);
    let out = design(&folder, &["amplitude_inversion"]).out();
    for part in [
        "task3: every sequence holds each sample of its set once",
        "a standard deviation of 2.83, not 2.31",
        "9 are never, and are not meant to be compared",
    ] {
        assert!(out.contains(part), "no `{part}` in: {out}");
    }
}

#[test]
fn chapter_6_confounds_natural_touch_with_order_and_has_too_few_people() {
    let folder = Folder::new();
    let document = design(&folder, &["touch_control_imagery", "--json"]).json();
    let order = fault(&document, "confounded_with_order").unwrap();
    assert_eq!(
        (&order["task"], &order["position"]),
        (&"natural".into(), &1.into())
    );
    let cells = fault(&document, "cannot_be_balanced").unwrap();
    assert_eq!(
        (&cells["cells"], &cells["participants"]),
        (&12.into(), &10.into())
    );
    assert!(fault(&document, "power_too_low").is_some());
    let out = design(&folder, &["touch_control_imagery"]).out();
    for part in [
        "natural is always number 1 of natural, control, imagery",
        "10 participants cannot fill 12 cells equally",
        "10 participants have a power of 0.62",
        "Better: 15 participants. Cost: 5 participants more, 8.2 h of all together instead of 5.5 h",
        "with natural before it: 33 min",
    ] {
        assert!(out.contains(part), "no `{part}` in: {out}");
    }
    // As many as fill the cells and have the power: those two faults are gone, that of the order is not.
    let more = ["touch_control_imagery", "--participants", "24", "--json"];
    let more = design(&folder, &more).json();
    assert_eq!(more["campaign"]["participants"], 24);
    assert!(
        fault(&more, "cannot_be_balanced").is_none() && fault(&more, "power_too_low").is_none()
    );
    assert!(fault(&more, "confounded_with_order").is_some());
}

#[test]
fn the_same_inputs_give_the_same_bytes() {
    let folder = Folder::new();
    let of = |seed: &str| {
        let words = ["averaged_transfer_function", "--seed", seed, "--json"];
        serde_json::to_vec(&results(design(&folder, &words).json())).unwrap()
    };
    assert_eq!(of("7"), of("7"));
    assert_ne!(of("7"), of("8"));
    // The file of a protocol is the protocol.
    let out = [
        "campaign",
        "protocol",
        "isotropic_triplets",
        "--out",
        "own.toml",
    ];
    folder.run(&out).expect_success();
    let file = results(design(&folder, &["own.toml", "--json"]).json());
    assert_eq!(
        file,
        results(design(&folder, &["isotropic_triplets", "--json"]).json())
    );
    folder
        .run(&["campaign", "design", "own.toml", "--report", "r.html"])
        .expect_success();
    let again = folder.run(&["rerun", "r.html"]);
    again.expect_success();
}

#[test]
fn a_file_is_preferred_to_the_library_and_this_is_said() {
    let folder = Folder::new();
    changed(
        &folder,
        "periodic_pilot",
        "title = \"",
        "title = \"Our own: ",
    );
    std::fs::rename(folder.path("own.toml"), folder.path("periodic_pilot")).unwrap();
    let done = design(&folder, &["periodic_pilot"]);
    done.expect_success();
    assert!(done.out().contains("\nOur own: "), "{}", done.out());
    assert!(
        done.err()
            .contains("a file here and a protocol of the library: the file is read")
    );
}

#[test]
fn the_library_is_listed_and_written() {
    let folder = Folder::new();
    let listed = folder.run(&["campaign", "protocol"]).out();
    assert_eq!(listed.lines().count(), 8, "{listed}");
    for line in listed.lines().skip(1) {
        let name = line.split_whitespace().next().unwrap();
        let document = folder.run(&["campaign", "protocol", name, "--json"]).json();
        assert_eq!(
            (&document["schema"], &document["name"]),
            (&"protocol".into(), &name.into())
        );
        design(&folder, &[name]).expect_success();
        folder
            .run(&["campaign", "protocol", name, "--dictionary"])
            .expect_success();
    }
    let none = ["campaign", "protocol", "triplets"];
    folder.run(&none).expect_failure(
        2,
        &["found neither called `triplets`", "isotropic_triplets"],
    );
}

#[test]
fn a_dictionary_names_columns_by_task() {
    let folder = Folder::new();
    let document = folder
        .run(&[
            "campaign",
            "protocol",
            "amplitude_inversion",
            "--dictionary",
            "--json",
        ])
        .json();
    assert_eq!(document["schema"], "campaign_dictionary");
    let task = &document["tasks"][2];
    assert_eq!(task["task"], "task3");
    let presented = &task["meanings"]["presented"];
    assert_eq!(
        presented["Levels"]["S2 INVERTED"],
        "rendered vibration of S2 at the rms level of S13"
    );
    assert_eq!(task["meanings"]["position"]["Units"], "1");
    let out = folder
        .run(&[
            "campaign",
            "protocol",
            "amplitude_inversion",
            "--dictionary",
        ])
        .out();
    for part in [
        "measure: Strokes on each sample. Nothing is answered.",
        "S2, S2 INVERTED, S5, S5 INVERTED",
        "missed_target, not_measured, simulated, wrong_sample",
    ] {
        assert!(out.contains(part), "no `{part}` in: {out}");
    }
}

#[test]
fn the_fields_of_a_protocol_are_explained_and_wrong_ones_named_with_those_that_are_allowed() {
    let folder = Folder::new();
    let explained = folder.run(&["campaign", "protocol", "--explain"]);
    explained.expect_success();
    assert!(explained.out().contains("[[tasks]] with kind = \"touch\""));
    let toml = folder
        .run(&["campaign", "protocol", "isotropic_triplets"])
        .out();
    for (from, to, part) in [
        (
            "\nchecklist = ",
            "\nchecklst = ",
            "unknown field `checklst` of tasks measure, expected one of `catch`, `checklist`",
        ),
        (
            "strokes = 10",
            "strokes = \"ten\"",
            "tasks measure.strokes: expected whole number from 0, found \"ten\"",
        ),
        (
            "kind = \"touch\"",
            "kind = \"taste\"",
            "expected `kind` to be one of `touch`, `identify`",
        ),
    ] {
        assert!(toml.contains(from), "{from}");
        folder.write("own.toml", toml.replacen(from, to, 1));
        design(&folder, &["own.toml"]).expect_failure(1, &[part]);
    }
}

#[test]
fn what_is_no_protocol_is_refused_in_one_sentence() {
    let folder = Folder::new();
    design(&folder, &["none.toml"]).expect_failure(
        2,
        &[
            "found neither called `none.toml`",
            "periodic_pilot, isotropic_triplets",
            "correct the name",
        ],
    );
    for (from, to, parts) in [
        (
            "tray_slots = 14",
            "tray_slots = 2",
            [
                "set A has 3 samples, and the tray holds 2",
                "make the set smaller",
            ],
        ),
        (
            "\"S2\", \"S4\", \"S8\"",
            "\"S2\", \"S4\", \"S99\"",
            [
                "set A: sample `S99` is not declared",
                "declare it, or correct the name",
            ],
        ),
        (
            "lengths = [3, 4]",
            "lengths = [30, 40]",
            ["too many to enumerate", "make them shorter"],
        ),
        (
            "participants = 10",
            "participants = 0",
            ["panel.participants: expected at least 1", "found 0"],
        ),
        (
            "session = \"discrimination\"",
            "session = \"discriminate\"",
            [
                "aims: session `discriminate` is not declared",
                "correct the name",
            ],
        ),
        (
            "tray_slots = 14",
            "trays = 14",
            ["unknown field `trays`", "tray_slots"],
        ),
    ] {
        let file = changed(&folder, "isotropic_triplets", from, to);
        let done = design(&folder, &[&file]);
        done.expect_failure(1, &["own.toml: "]);
        done.expect_failure(1, &parts);
        assert_eq!(done.err().trim().lines().count(), 1, "{}", done.err());
    }
    for number in ["0", "-3", "ten", "10001"] {
        let words = ["isotropic_triplets", "--participants", number];
        design(&folder, &words).expect_failure(2, &["expected a whole number from 1 to 10000"]);
    }
    folder.write("own.toml", "");
    let words = ["own.toml", "--report", "own.toml"];
    design(&folder, &words).expect_failure(2, &["own.toml is read and would be replaced"]);
}

#[test]
fn comparisons_and_ratings_are_judged() {
    let folder = Folder::new();
    let jnd = design(&folder, &["roughness_jnd"]).out();
    for part in [
        "quest: ",
        "staircase: ",
        " of 100 simulated runs decide a threshold",
        "rules judged",
    ] {
        assert!(jnd.contains(part), "no `{part}` in: {jnd}");
    }
    assert!(!jnd.contains("nothing was judged"), "{jnd}");
    let few = ["touch_control_imagery", "--participants", "3"];
    let few = design(&folder, &few).out();
    for part in [
        "vividness: a mean rating has an expected 95 % interval of ±",
        "on its scale of 6 steps",
        "vividness: a mean rating of 3 participants has an interval of ±",
    ] {
        assert!(few.contains(part), "no `{part}` in: {few}");
    }
}

#[test]
fn the_power_for_a_stated_difference_is_shown() {
    let folder = Folder::new();
    let line = "campaign design isotropic_triplets --participants 12 --power samples:S2,S3 --shares 75,20 --report power.html";
    let found = folder.run(&line.split(' ').collect::<Vec<_>>());
    found.expect_success();
    for words in [
        "Asked: to find that S2 and S3 differ, by a permutation of participants at 5 %.",
        "in 1 of 12 sets",
        "12 participants find it in ",
        "Needed: ",
        "4 × presentations: found, %",
    ] {
        assert!(found.out().contains(words), "{words}: {}", found.out());
    }
    let page = std::fs::read_to_string(folder.path("power.html")).unwrap();
    assert!(page.contains("<h2>Power</h2>") && page.matches("<svg").count() >= 3);
    for (rest, words) in [
        (
            "--power samples:S4,S5 --shares 75,20",
            "never occur in one set",
        ),
        ("--power samples:S2,S3 --shares 75,40", "at most 1"),
        (
            "--power tasks:task2,task3 --shares 75,40",
            "task3 alone has answers that name a sample; compare samples or people",
        ),
        (
            "--power people:own,averaged --shares 75,40 --spread -1",
            "0 to 10",
        ),
        (
            "--power people:own,averaged --shares 75,400",
            "above 0 and below 100",
        ),
        (
            "--power samples:S2,S3 --shares 0.75,0.20",
            "expected two percentages such as 85,70",
        ),
        (
            "--power samples:S2,S3 --shares 40,40",
            "two shares that differ",
        ),
        ("--power samples:S2,S3", "--shares"),
        ("--power other:S2,S3 --shares 75,20", "expected samples:A,B"),
    ] {
        let line = format!("campaign design isotropic_triplets {rest}");
        folder
            .run(&line.split(' ').collect::<Vec<_>>())
            .expect_failure(2, &[words]);
    }
}
