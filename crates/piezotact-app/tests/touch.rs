//! `strokes` and `compare` as a laboratory runs them: on its own tables, and on measured files.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::fmt::Write as _;

use crate::known_cuts::{Kind, RATE_HZ, Random, Recorded, recorded, table};
use crate::support::Folder;
use serde_json::Value;

fn plain(seed: u64, strokes: usize) -> Recorded {
    recorded(&mut Random::new(seed), &vec![Kind::Plain; strokes])
}

/// The same `level` times as loud, with a hundredth of noise of its own: a recording that is scaled alone is a copy.
fn louder(mut made: Recorded, level: f64) -> Recorded {
    let mut random = Random::new((1e3 * level) as u64);
    let squares = made.acceleration.iter().map(|value| value * value);
    let rms = (squares.sum::<f64>() / made.acceleration.len() as f64).sqrt();
    for value in &mut made.acceleration {
        // The noise of the sensor is that of all samples.
        *value = level * *value + 0.01 * rms * random.normal();
    }
    made
}

/// Passive touch: a platform at `speed_mm_s` under a finger; the surface has ridges `period_mm` apart, and the
/// vibration grows with the speed.
fn passive(speed_mm_s: f64, period_mm: f64, level: f64, strokes: usize) -> String {
    // Noise of its own at each level: a recording that is scaled alone is a copy.
    let mut random = Random::new(speed_mm_s as u64 + (1e3 * (1.0 - level)) as u64);
    let mut text = String::from("time (s),acc (m/s2),fx (N),fy (N),fz (N),platform (mm/s)");
    let (ramp_s, plateau_s) = (0.1, 1.0);
    let round_s = 0.6 + 2.0 * ramp_s + plateau_s + 0.6;
    let mut place_mm = 0.0;
    for i in 0..(round_s * strokes as f64 * RATE_HZ) as usize {
        let t = i as f64 / RATE_HZ;
        let phase_s = t % round_s;
        let up = ((phase_s - 0.6) / ramp_s).clamp(0.0, 1.0);
        let down = ((0.6 + 2.0 * ramp_s + plateau_s - phase_s) / ramp_s).clamp(0.0, 1.0);
        let speed = speed_mm_s * up.min(down);
        place_mm += speed / RATE_HZ;
        let touching = if phase_s > 0.2 && phase_s < round_s - 0.2 {
            1.0
        } else {
            0.0
        };
        let ridges = (std::f64::consts::TAU * place_mm / period_mm).sin();
        let share = speed / speed_mm_s;
        let vibration = level * speed_mm_s / 30.0 * share * (ridges + 0.5 * random.normal());
        let force = 0.2 * touching;
        write!(
            text,
            "\n{t:.4},{:.5},{:.5},{:.5},{:.5},{speed:.3}",
            vibration + 0.005 * random.normal(),
            0.002 * random.normal(),
            force * (0.2 + 0.4 * share) + 0.002 * random.normal(),
            force + 0.002 * random.normal(),
        )
        .unwrap();
    }
    text
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

#[test]
fn strokes_and_rejects_are_listed_and_a_person_has_the_last_word() {
    let folder = Folder::new();
    let kinds = [
        Kind::Plain,
        Kind::StickSlip,
        Kind::Plain,
        Kind::TouchOnly,
        Kind::Plain,
    ];
    let made = recorded(&mut Random::new(3), &kinds);
    folder.write("S8.csv", table(&made));
    let found = folder
        .run(&[
            "strokes",
            "--cuts-only",
            "S8.csv",
            "--csv",
            "cuts.csv",
            "--report",
            "cuts.html",
            "--json",
        ])
        .json();
    let take = &found["recordings"][0];
    let (strokes, rejected) = (
        take["cuts"].as_array().unwrap(),
        take["rejected"].as_array().unwrap(),
    );
    assert_eq!((strokes.len(), rejected.len()), (3, 2), "{found}");
    assert_eq!(rejected[0]["reason"]["reason"], "stick_slip");
    assert_eq!(rejected[1]["reason"]["reason"], "no_sliding");
    for (stroke, truth) in strokes.iter().zip([0, 2, 4].map(|i| made.truths[i])) {
        let (start, end) = truth.cut_s(0.1, 0.08).unwrap();
        assert!(
            (number(&stroke["start_s"]) - start).abs() < 0.02,
            "{stroke}"
        );
        assert!((number(&stroke["end_s"]) - end).abs() < 0.02, "{stroke}");
    }
    let rows = std::fs::read_to_string(folder.path("cuts.csv")).unwrap();
    assert_eq!(rows.lines().count(), 6, "{rows}");
    let report = std::fs::read_to_string(folder.path("cuts.html")).unwrap();
    assert!(report.contains("stick-slip") && report.contains("normal force, N"));

    // The cuts as a file, edited, count from then on and are cited.
    folder
        .run(&[
            "strokes",
            "--cuts-only",
            "S8.csv",
            "--write-cuts",
            "S8.csv.cuts",
        ])
        .expect_success();
    let cuts = std::fs::read_to_string(folder.path("S8.csv.cuts")).unwrap();
    assert!(
        cuts.contains("# rejected") && cuts.matches("\nstroke ").count() == 3,
        "{cuts}"
    );
    let slip = &made.truths[1].contact_s;
    let edited = format!(
        "{cuts}stroke {:.3} {:.3}\nleave-out {:.3} {:.3} the participant sneezed\n",
        slip.0 + 0.2,
        slip.0 + 0.6,
        made.truths[4].contact_s.0 + 0.3,
        made.truths[4].contact_s.0 + 0.4,
    );
    folder.write("S8.csv.cuts", edited);
    let again = folder
        .run(&["strokes", "--cuts-only", "S8.csv", "--json"])
        .json();
    let take = &again["recordings"][0];
    assert_eq!(take["cuts"].as_array().unwrap().len(), 3);
    assert_eq!(take["cuts"][1]["cut_by"], "person");
    assert!(again.to_string().contains("the participant sneezed"));
    assert!(take["cuts_file"].as_str().unwrap().ends_with("S8.csv.cuts"));
    let said = folder.run(&["strokes", "--cuts-only", "S8.csv"]).out();
    assert!(
        said.contains("with the cuts in S8.csv.cuts: 3 strokes as it states, 1 stroke left out"),
        "{said}"
    );
    folder
        .run(&[
            "strokes",
            "--cuts-only",
            "S8.csv",
            "--write-cuts",
            "S8.csv.cuts",
        ])
        .expect_failure(2, &["S8.csv.cuts", "would be replaced"]);
}

#[test]
fn an_analysis_holds_levels_friction_and_spectra() {
    let folder = Folder::new();
    let loud = louder(plain(21, 11), 2.0);
    folder.write("P1_S1.csv", table(&loud));
    folder.write("P1_S6.csv", table(&plain(21, 11)));
    let arguments = [
        "strokes",
        "P1_S1.csv",
        "P1_S6.csv",
        "--meta",
        "{participant}_{sample}",
        "--by",
        "sample",
    ];
    let json = folder.run(&[&arguments[..], &["--json"]].concat()).json();
    let groups = json["groups"].as_array().unwrap();
    assert_eq!(groups[0]["name"], "S1");
    assert_eq!(
        (&groups[0]["strokes"], &groups[0]["unit"]),
        (&Value::from(11), &Value::from("m/s²"))
    );
    let ratio = number(&groups[0]["rms"]["mean"]) / number(&groups[1]["rms"]["mean"]);
    assert!((ratio - 2.0).abs() < 1e-3, "{ratio}");
    // The second group is the same finger: friction and force do not change.
    for what in ["friction_coefficient", "normal_force_n"] {
        let [a, b] = [0, 1].map(|i| number(&groups[i][what]["mean"]));
        assert!(
            (a / b - 1.0).abs() < 1e-3 && a > 0.15 && a < 1.0,
            "{what}: {a}, {b}"
        );
    }
    let stroke = &json["recordings"][0]["strokes"][0];
    for field in [
        "rms",
        "peak",
        "crest_factor",
        "centroid_hz",
        "spread_hz",
        "pacinian_power",
        "detection_power",
    ] {
        assert!(number(&stroke[field]) > 0.0, "{field}: {stroke}");
    }
    assert_eq!(stroke["receptor_power"].as_array().unwrap().len(), 4);
    assert_eq!(groups[0]["psd"]["mean"].as_array().unwrap().len(), 513);

    let outputs = ["--csv", "strokes.csv", "--report", "report.html"];
    let done = folder.run(&[&arguments[..], &outputs].concat());
    done.expect_success();
    let row = |line: &str| line.starts_with("S1 ") && line.contains(" 11 ") && line.contains('±');
    assert!(done.out().lines().any(row), "{}", done.out());
    let rows = std::fs::read_to_string(folder.path("strokes.csv")).unwrap();
    assert_eq!(rows.lines().count(), 23);
    assert!(
        rows.starts_with("file,sample,participant,touch,direction,load_n"),
        "{rows}"
    );
    let report = std::fs::read_to_string(folder.path("report.html")).unwrap();
    for part in [
        "Groups",
        "Across samples",
        "Single strokes and their mean",
        "Signals and cuts",
        "Methods",
        "high-pass at 5 Hz",
        "PSD, (m/s²)²/Hz",
    ] {
        assert!(report.contains(part), "{part}");
    }
}

/// Ridges 0.6 mm apart under three speeds: the period, the slope of the level, and the peaks.
#[test]
fn speeds_give_the_spatial_period_and_the_slope_of_the_level() {
    let folder = Folder::new();
    for speed in [10, 20, 30] {
        folder.write(
            &format!("M_{speed}.csv"),
            passive(f64::from(speed), 0.6, 1.0, 10),
        );
    }
    let arguments = [
        "compare",
        "M_10.csv",
        "M_20.csv",
        "M_30.csv",
        "--meta",
        "{sample}_{speed:mm/s}",
        "--by",
        "speed",
    ];
    let json = folder
        .run(&[&arguments[..], &["--json", "--report", "r.html"]].concat())
        .json();
    let found = &json["period"];
    assert_eq!(found["outcome"], "met", "{found}");
    let period = 1e3 * number(&found["period_m"]);
    assert!((period - 0.6).abs() < 0.005, "{period}");
    let interval = [0, 1].map(|i| 1e3 * number(&found["interval_m"][i]));
    assert!(
        interval[0] < period && period < interval[1] && interval[1] - interval[0] < 0.1,
        "{interval:?}"
    );
    assert!(
        (number(&json["rms_on_speed"]["slope"]) - 1.0).abs() < 0.05,
        "{}",
        json["rms_on_speed"]
    );
    for (peak, speed) in found["peaks"]
        .as_array()
        .unwrap()
        .iter()
        .zip([10.0, 20.0, 30.0])
    {
        assert!(
            (number(&peak["frequency_hz"]) / (speed / 0.6) - 1.0).abs() < 0.02,
            "{peak}"
        );
    }
    let speeds: Vec<f64> = json["groups"]
        .as_array()
        .unwrap()
        .iter()
        .map(|g| number(&g["speed_m_s"]["mean"]) * 1e3)
        .collect();
    assert!(
        speeds
            .iter()
            .zip([10.0, 20.0, 30.0])
            .all(|(found, set)| (found - set).abs() < 0.2),
        "{speeds:?}"
    );
    assert!(
        std::fs::read_to_string(folder.path("r.html"))
            .unwrap()
            .contains("spatial period 0.60")
    );
}

/// Samples of the isotropic set whose levels are Ra^0.5, two of them alike; active and passive touch of the same.
#[test]
fn samples_follow_their_roughness_and_active_touch_its_passive_twin() {
    let folder = Folder::new();
    let mut files = Vec::new();
    for (sample, ra_um) in [
        ("S2", 43.7f64),
        ("S4", 14.4),
        ("S7", 5.2),
        ("S8", 5.21),
        ("NO", 0.1),
    ] {
        let level = (ra_um / 43.7).sqrt();
        let made = louder(plain(33, 6), level);
        folder.write(&format!("{sample}_active.csv"), table(&made));
        folder.write(
            &format!("{sample}_passive.csv"),
            passive(30.0, 0.545, level, 6),
        );
        files.extend([
            format!("{sample}_active.csv"),
            format!("{sample}_passive.csv"),
        ]);
    }
    let run = |by: &str, files: &[String]| {
        let mut arguments = vec!["compare"];
        arguments.extend(files.iter().map(String::as_str));
        arguments.extend(["--meta", "{sample}_{touch}", "--by", by]);
        arguments.extend(["--set", "isotropic", "--json"]);
        folder.run(&arguments).json()
    };
    let active: Vec<String> = files
        .iter()
        .filter(|f| f.contains("active"))
        .filter(|f| !f.contains("passive"))
        .cloned()
        .collect();
    let across = run("sample", &active);
    let names: Vec<&str> = across["groups"]
        .as_array()
        .unwrap()
        .iter()
        .map(|g| g["name"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["S2", "S4", "S7", "S8", "NO"]);
    assert!(
        (number(&across["roughness"]["rms_on_ra"]["slope"]) - 0.5).abs() < 0.02,
        "{}",
        across["roughness"]
    );
    assert!(number(&across["roughness"]["rms_rank_correlation"]["rho"]) > 0.97);
    // S7 and S8 have one level, and the others lie 4.8 dB apart or more.
    assert_eq!(across["below_jnd"], serde_json::json!([["S7", "S8"]]));
    let found = &across["discrimination"];
    let pair = |a: usize, b: usize| -> Value {
        let pairs = found["settings"][0]["pairs"].as_array().unwrap();
        let is = |p: &&Value| p["a"] == a && p["b"] == b;
        pairs.iter().find(is).unwrap().clone()
    };
    let first = pair(0, 1);
    assert!(
        (number(&first["distance_jnd"]) - 10.0 * (43.7f64 / 14.4).log10() / 1.58).abs() < 0.2,
        "{first}"
    );
    assert_eq!(pair(2, 3)["outcome"], "below_jnd");
    // Six strokes of each can show a difference over ten pairs.
    assert_eq!(pair(0, 4)["outcome"], "told_apart", "{}", pair(0, 4));
    assert_eq!(
        (&found["family"], &found["units"]),
        (&10.into(), &"strokes".into())
    );
    assert_eq!(pair(0, 4)["criteria"].as_array().unwrap().len(), 4);
    let both = run("touch", &files);
    let compared = &both["active_against_passive"];
    assert_eq!(compared["pairs"].as_array().unwrap().len(), 5, "{compared}");
    // S7 and S8 share a rank in one list and nearly in the other.
    assert!(
        number(&compared["rms_rank_correlation"]["rho"]) > 0.85,
        "{compared}"
    );
    assert!(
        compared["pairs"]
            .as_array()
            .unwrap()
            .iter()
            .all(|p| number(&p["difference_db_rms"]) > 0.0)
    );
}

#[test]
fn what_cannot_be_analysed_is_refused_in_a_sentence() {
    let folder = Folder::new();
    let made = plain(5, 3);
    folder.write("S1.csv", table(&made));
    folder.write("a_b.csv", "time (s),acc (m/s2)\n0,1\n0.001,2\n0.002,1\n");
    let mut silent = plain(6, 3);
    silent
        .fz_n
        .iter_mut()
        .enumerate()
        .for_each(|(i, force)| *force = 0.003 * (i as f64).sin());
    folder.write("silent.csv", table(&silent));
    let mut dead = plain(6, 3);
    dead.fz_n.fill(0.0);
    folder.write("dead.csv", table(&dead));
    let mut still = plain(6, 3);
    still.acceleration.fill(0.25);
    folder.write("still.csv", table(&still));
    // What was rejected has its report, where one is asked for.
    let asked = ["strokes", "silent.csv", "--report", "rejected.html"];
    folder
        .run(&asked)
        .expect_failure(1, &["found none in silent.csv"]);
    let report = std::fs::read_to_string(folder.path("rejected.html"));
    assert!(report.unwrap().contains("silent.csv"));
    folder.write("bad.cuts", "stroke 2 1\n");
    folder.write("outside.cuts", "stroke 900 901\n");
    folder.write("set.toml", "name = \"x\"\nsource = \"y\"\nplate_mm = [1.0, 1.0, 1.0]\n[[sample]]\nname = \"A\"\nra_um = 0.0\n");
    for (arguments, code, parts) in [
        (
            &["strokes", "silent.csv"][..],
            1,
            &[
                "expected strokes, found none in silent.csv",
                "a contact needs 0.1 N",
            ][..],
        ),
        (
            &["strokes", "dead.csv"],
            1,
            &["dead.csv", "the normal force", "0 N", "cable"],
        ),
        (
            &["strokes", "still.csv", "--every-contact"],
            1,
            &[
                "still.csv",
                "a channel of vibration that changes",
                "one value throughout",
            ],
        ),
        (
            &["strokes", "a_b.csv"],
            1,
            &["a_b.csv", "8 samples", "found 3"],
        ),
        (
            &["strokes", "S1.csv", "S1.csv"],
            2,
            &["S1.csv is given twice"],
        ),
        (
            &["strokes", "S1.csv", "--by", "sample"],
            2,
            &["a sample", "--meta", "{sample}"],
        ),
        (
            &["strokes", "S1.csv", "--meta", "{sample}_{speed:mm/s}"],
            2,
            &["{sample}_{speed:mm/s}", "found `S1`"],
        ),
        (
            &["strokes", "S1.csv", "--meta", "{sample"],
            2,
            &["not closed"],
        ),
        (
            &["strokes", "S1.csv", "--load", "-1"],
            2,
            &["--load", "-1", "give it in N"],
        ),
        (
            &["strokes", "S1.csv", "--speed", "30 N"],
            2,
            &["30mm/s", "30 N"],
        ),
        (
            &["strokes", "S1.csv", "--ridge", "3 s"],
            2,
            &["--ridge", "mm"],
        ),
        (
            &["strokes", "S1.csv", "--high-pass", "0"],
            2,
            &["above zero, or none"],
        ),
        (
            &["strokes", "S1.csv", "--high-pass", "2500"],
            1,
            &["cut-off above 0 and below half the rate", "2500"],
        ),
        (
            &["strokes", "S1.csv", "--segment", "100000"],
            1,
            &["100000"],
        ),
        (
            &["strokes", "S1.csv", "--vibration", "nose"],
            1,
            &["`nose`", "nail [m/s²]"],
        ),
        (
            &["strokes", "S1.csv", "--normal-force", "nail"],
            1,
            &["`nail`", "N", "m/s²"],
        ),
        (
            &["strokes", "S1.csv", "--cuts", "bad.cuts"],
            1,
            &["bad.cuts", "line 1", "FROM before TO"],
        ),
        (
            &["strokes", "S1.csv", "--set", "set.toml"],
            1,
            &["set.toml", "ra_um = 0 for A"],
        ),
        (
            &["strokes", "S1.csv", "--report", "S1.csv"],
            2,
            &["S1.csv is read and would be replaced"],
        ),
        (
            &["strokes", "S1.csv", "--csv", "nowhere/x.csv"],
            1,
            &["nowhere"],
        ),
        (
            &["compare", "S1.csv", "silent.csv", "--by", "speed"],
            2,
            &[
                "a sliding speed",
                "S1.csv: say it in the file names with --meta and {speed:mm/s}\n",
            ],
        ),
        (
            &["compare", "S1.csv", "--by", "file"],
            2,
            &["two or more recordings that differ in file", "only S1.csv"],
        ),
        (
            &[
                "compare",
                "S1.csv",
                "silent.csv",
                "--by",
                "file",
                "--jnd",
                "0",
            ],
            2,
            &["just-noticeable difference", "above 0"],
        ),
        (
            &[
                "strokes",
                "--cuts-only",
                "S1.csv",
                "silent.csv",
                "--cuts",
                "bad.cuts",
            ],
            2,
            &["expected one recording with --cuts"],
        ),
        (
            &[
                "strokes",
                "--cuts-only",
                "S1.csv",
                "silent.csv",
                "--write-cuts",
                "x.cuts",
            ],
            2,
            &["expected one recording with --write-cuts"],
        ),
    ] {
        folder.run(arguments).expect_failure(code, parts);
    }
    let outside = folder.run(&["strokes", "--cuts-only", "S1.csv", "--cuts", "outside.cuts"]);
    outside.expect_success();
    assert!(
        outside
            .err()
            .contains("1 cuts of outside.cuts are outside the recording"),
        "{}",
        outside.err()
    );
}

/// What cannot be taken together is refused, what stands alone is said, and what was overridden holds.
#[test]
fn recordings_that_do_not_belong_together_are_told_apart() {
    let folder = Folder::new();
    let text = table(&plain(41, 6));
    folder.write("S1_a.csv", &text);
    let other = table(&plain(44, 6));
    folder.write("S2_a.csv", other.replace("nail (m/s2)", "nail (V)"));
    folder.write("S3_b.csv", table(&plain(42, 6)));
    folder.write("S4_a.csv", table(&plain(43, 6)));
    folder.write("2024_05_13_10_30.csv", &text);
    let meta = ["--meta", "{sample}_{participant}", "--by", "sample"];
    folder
        .run(&[&["compare", "S1_a.csv", "S2_a.csv"][..], &meta].concat())
        .expect_failure(
            1,
            &["the unit of the vibration is m/s² in one and V in another"],
        );
    let compared = folder
        .run(
            &[
                &["compare", "S1_a.csv", "S3_b.csv", "S4_a.csv", "--json"][..],
                &meta,
            ]
            .concat(),
        )
        .json();
    assert!(
        compared["warnings"]
            .to_string()
            .contains("S3_b.csv cannot be compared"),
        "{}",
        compared["warnings"]
    );
    assert_eq!(compared["groups"].as_array().unwrap().len(), 2);
    let mixed = ["strokes", "S1_a.csv", "--vibration", "nail,fz"];
    folder
        .run(&mixed)
        .expect_failure(1, &["one unit", "`fz` in N"]);
    // A date is no condition.
    let dated = folder
        .run(&["strokes", "2024_05_13_10_30.csv", "--json"])
        .json();
    assert_eq!(
        dated["recordings"][0]["strokes"].as_array().unwrap().len(),
        6
    );
    // Leaving out more than there is leaves out what there is.
    folder.write("S1_a.csv.cuts", "\u{feff}leave-out  5   100  the rest\n");
    let left = folder
        .run(&["strokes", "--cuts-only", "S1_a.csv", "--json"])
        .json();
    let strokes = left["recordings"][0]["cuts"].as_array().unwrap().len();
    assert!(strokes > 0 && strokes < 6, "{strokes}");
    let again = ["strokes", "S4_a.csv", "./S4_a.csv"];
    folder.run(&again).expect_failure(2, &["is given twice"]);
}
