//! What the program concludes, as a black box: a direction, a verdict or a number only where the data carry it.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::f64::consts::TAU;
use std::fmt::Write as _;

use crate::support::{Done, Folder, noise, shared};

fn run(folder: &Folder, line: &str) -> Done {
    let words: Vec<&str> = line.split(' ').collect();
    folder.run(&words)
}

/// Two seconds of noise of `level` m/s² and a line of the machine at 137 Hz, as one stroke.
fn one_stroke(seed: usize, level: f64) -> String {
    let mut text = String::from("t (s),a (m/s2)\n");
    for (i, value) in noise(4000 * (seed + 1)).skip(4000 * seed).enumerate() {
        let t = i as f64 / 2000.0;
        let line = 2.0 * level * (TAU * 137.0 * t).sin();
        writeln!(text, "{t:.5},{:.6}", level * value + line).unwrap();
    }
    text
}

/// Four speeds of one level: no direction, which was told as "grows … to the power −0.05". Where the level follows the
/// speed, it rises.
#[test]
fn a_direction_is_said_where_the_interval_has_one() {
    let folder = Folder::new();
    for (i, speed) in [10, 20, 30, 40].into_iter().enumerate() {
        let scatter = [1.0, 0.93, 1.04, 0.96][i];
        folder.write(&format!("E_{speed}.csv"), one_stroke(1 + i, scatter));
        let rising = scatter * f64::from(speed) / 10.0;
        folder.write(&format!("R_{speed}.csv"), one_stroke(9 + i, rising));
    }
    let said = |name: &str| {
        let files: Vec<String> = [10, 20, 30, 40].map(|v| format!("{name}_{v}.csv")).to_vec();
        let line = format!(
            "compare {} --meta {{sample}}_{{speed:mm/s}} --by speed",
            files.join(" ")
        );
        run(&folder, &line).out()
    };
    let even = said("E");
    assert!(
        even.contains("rms and speed: no trend shown: exponent")
            && even.contains("over 4 speeds, p = "),
        "{even}"
    );
    assert!(!even.contains("rises") && !even.contains("falls"), "{even}");
    let rising = said("R");
    assert!(
        rising.contains("rms rises with speed: exponent"),
        "{rising}"
    );
}

/// One stroke a sample, three samples at two speeds: what scatters is not known, four samples show no order, and the line
/// that all have is the machine's.
#[test]
fn one_stroke_a_sample_leaves_open_what_it_cannot_decide() {
    let folder = Folder::new();
    let mut names = Vec::new();
    for (i, sample) in ["A", "B", "C", "D"].into_iter().enumerate() {
        for speed in [10, 20] {
            let name = format!("{sample}_{speed}.csv");
            folder.write(&name, one_stroke(20 + 2 * i + speed / 10, 1.0 + i as f64));
            names.push(name);
        }
    }
    let line = format!(
        "compare {} --meta {{sample}}_{{speed:mm/s}} --by sample",
        names.join(" ")
    );
    let said = run(&folder, &line).out();
    assert!(
        said.contains("4 of 4 samples have only one stroke"),
        "{said}"
    );
    assert!(
        said.contains("137 Hz: in all 8 recordings of 4 samples at speeds that differ by a factor of up to 2.0: due to the \
 machine"),
        "{said}"
    );
    let json = run(&folder, &format!("{line} --json")).json();
    assert_eq!(
        json["common_lines"][0]["origin"], "machine",
        "{}",
        json["common_lines"]
    );
}

/// The ridged board: the interval of the period is over its recordings and holds ridge and gap; the level shows no trend.
#[test]
fn a_measured_board_has_a_period_and_no_trend() {
    let Some(folder) = shared("data/vibration/fabricslide") else {
        return;
    };
    let mut words = vec!["compare".to_owned()];
    for v in [5, 10, 20, 30] {
        let file = folder.join(format!("Board2mm_F135_V-{v}mmps_0.csv"));
        words.push(file.to_string_lossy().into_owned());
    }
    words.extend(["--by", "speed"].map(str::to_owned));
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let said = Folder::new().run(&words).out();
    assert!(
        said.contains("spatial period 3.97") && said.contains("over 4 recordings"),
        "{said}"
    );
    assert!(said.contains("rms and speed: no trend shown"), "{said}");
}

/// Two people have one penalty, twice: nothing is decided, and how people scatter is said to be open.
#[test]
fn a_panel_of_two_decides_nothing() {
    let folder = Folder::new();
    run(
        &folder,
        "panel run --bench twin:seed=7 --participants 1..2 --loads 0.2,0.6 --angles 20 --repeats 1 --seconds 4 --out panel",
    )
    .expect_success();
    let said = run(&folder, "panel analyse panel").out();
    for part in [
        "At which load and angle participants differ most is not decided",
        "whether it changes with load cannot be decided from 2 participants",
        "N is not decided: the error is within 3 dB rms for 2 of 2 participants (too few participants for an interval)",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    let json = run(&folder, "panel analyse panel --json").json();
    assert_eq!(json["will_the_average_do"], "not decided");
}

/// A drive of silence has no headroom: "236 dB below the amplifier" was a clamp.
#[test]
fn the_headroom_of_silence_is_no_number() {
    let folder = Folder::new();
    run(&folder, "demo --out d").expect_success();
    // Nothing but one sample that is next to nothing.
    let mut text = String::from("t (s),a (m/s2)\n");
    for i in 0..8000 {
        writeln!(
            text,
            "{:.5},{}",
            f64::from(i) / 4000.0,
            if i == 7999 { 1e-30 } else { 0.0 }
        )
        .unwrap();
    }
    folder.write("silence.csv", text);
    let done = run(
        &folder,
        "render silence.csv --transfer d/tf.json --out out.wav",
    );
    let said = done.out() + &done.err();
    assert!(
        said.contains("the drive is silent") && !said.contains(" dB below"),
        "{said}"
    );
}

/// Twelve strokes of 1 s with rests between them, by a force and an acceleration; lines at 50 Hz, one of the texture and a hum of the mains
/// throughout, of these amplitudes.
fn strokes_with_hum(seed: usize, lines_m_s2: [f64; 2]) -> String {
    strokes_with_line(seed, 50.0, lines_m_s2)
}

/// Strokes with a line of the texture at `texture_hz`, and a hum of 50 Hz throughout.
fn strokes_with_line(seed: usize, texture_hz: f64, [texture_m_s2, hum_m_s2]: [f64; 2]) -> String {
    let mut text = String::from("t (s),acc (m/s2),fn (N)\n");
    let mut noise = noise(80_000 * (seed + 1)).skip(80_000 * seed);
    for i in 0..34_000 {
        let t = f64::from(i) / 2000.0;
        let phase_s = t % 1.4;
        let touching = if (0.25..1.3).contains(&phase_s) {
            1.0
        } else {
            0.0
        };
        let line = (TAU * 50.0 * t).sin();
        let own = texture_m_s2 * (TAU * texture_hz * t).sin();
        let texture = touching * (10.0 * noise.next().unwrap() + own);
        let sensor = 0.8 * noise.next().unwrap();
        let force = 0.5 * touching + 0.002 * (TAU * 3.1 * t).sin();
        let all = texture + hum_m_s2 * line + sensor;
        writeln!(text, "{t:.5},{all:.6},{force:.5}").unwrap();
    }
    text
}

/// What is concluded of two samples with these lines, with the text.
fn told(lines_m_s2: [[f64; 2]; 2]) -> (String, String) {
    told_at(50.0, lines_m_s2)
}

/// As [`told`], with the line of the texture at `texture_hz`.
fn told_at(texture_hz: f64, lines_m_s2: [[f64; 2]; 2]) -> (String, String) {
    let folder = Folder::new();
    for (name, (seed, lines)) in ["A_1.csv", "B_1.csv"]
        .iter()
        .zip([1, 3].into_iter().zip(lines_m_s2))
    {
        folder.write(name, strokes_with_line(seed, texture_hz, lines));
    }
    let line = "compare A_1.csv B_1.csv --meta {sample}_{trial} --by sample";
    let done = run(&folder, line);
    let json = run(&folder, &format!("{line} --json")).json();
    let outcome = json["discrimination"]["settings"][0]["pairs"][0]["outcome"].as_str();
    (outcome.unwrap().to_owned(), done.out() + &done.err())
}

/// One texture twice, once with a hum of the mains: this was told apart (2.74 JND), and the hum not named.
#[test]
fn hum_is_named_and_tells_no_samples_apart() {
    let (outcome, said) = told([[0.0, 0.0], [0.0, 2.4]]);
    assert_ne!(outcome, "told_apart", "{said}");
    for part in [
        "has lines at 50.0 Hz while nothing is touched",
        "lines at 50.0 Hz, of the mains or a machine, are left out",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
}

/// A line of the texture itself, where a weak hum is left out: the samples were called alike. Without hum they are told apart.
#[test]
fn what_lies_around_a_line_that_is_left_out_is_not_called_alike() {
    let (outcome, said) = told([[0.0, 0.3], [6.0, 0.3]]);
    assert_eq!(outcome, "not_decided", "{said}");
    assert!(
        said.contains("a difference may lie around the lines that are left out"),
        "{said}"
    );
    let (outcome, said) = told_at(63.0, [[0.0, 0.0], [6.0, 0.0]]);
    assert_eq!(outcome, "told_apart", "{said}");
    // At 50 Hz it may be hum that comes with the sliding.
    let (outcome, said) = told([[0.0, 0.0], [6.0, 0.0]]);
    assert_eq!(outcome, "not_decided", "{said}");
    let why = "another one without the lines that may be of the machine or the mains";
    assert!(said.contains(why), "{said}");
    // The hum alone, in both, hides nothing.
    let (outcome, said) = told([[0.0, 0.3], [0.0, 0.3]]);
    assert_eq!(outcome, "below_jnd", "{said}");
}

/// Copies of one recording were repeats: as they are, and with another time axis and other forces, by which other parts are strokes.
#[test]
fn copies_are_no_repeats() {
    let once = strokes_with_hum(5, [0.0, 0.0]);
    let mut other = String::new();
    for (i, line) in once.lines().enumerate() {
        let mut cells = line.split(',');
        let [t, acceleration, force] = [(); 3].map(|()| cells.next().unwrap());
        if i == 0 {
            writeln!(other, "{line}").unwrap();
        } else {
            let t: f64 = t.parse().unwrap();
            let force: f64 = force.parse().unwrap();
            writeln!(
                other,
                "{:.6},{acceleration},{:.5}",
                1.013 * t,
                force - 0.02 * t
            )
            .unwrap();
        }
    }
    for copy in [once.clone(), other] {
        let folder = Folder::new();
        folder.write("A_1.csv", &once);
        folder.write("A_2.csv", copy);
        for command in ["compare", "strokes"] {
            let done = run(
                &folder,
                &format!("{command} A_1.csv A_2.csv --meta {{sample}}_{{trial}} --by sample"),
            );
            done.expect_failure(1, &["found the same signal in A_1.csv and A_2.csv"]);
        }
    }
}

/// Recordings of one name in two folders were one group of `--by file`.
#[test]
fn files_of_one_name_are_told_by_their_folders() {
    let folder = Folder::new();
    for (seed, name) in [(1, "monday/S_1.csv"), (2, "tuesday/S_1.csv")] {
        std::fs::create_dir_all(folder.path(name).parent().unwrap()).unwrap();
        folder.write(name, strokes_with_hum(seed, [0.0, 0.0]));
    }
    let done = run(
        &folder,
        "strokes monday/S_1.csv tuesday/S_1.csv --by file --json",
    );
    let document = done.json();
    let groups = document["groups"].as_array().unwrap();
    let names: Vec<&str> = groups.iter().filter_map(|g| g["name"].as_str()).collect();
    assert_eq!(names, ["monday/S_1.csv", "tuesday/S_1.csv"], "{document:#}");
}

/// Own samples that are called as those of a built-in set: its roughness holds where the set is stated, and nowhere else.
#[test]
fn a_built_in_set_applies_where_it_is_stated() {
    let folder = Folder::new();
    let names = ["S1", "S4", "S6", "S8"];
    let mut files = Vec::new();
    for (i, name) in names.into_iter().enumerate() {
        for repeat in 0..2 {
            let file = format!("{name}_{repeat}.csv");
            let level = 2.0 / (i + 1) as f64;
            folder.write(&file, one_stroke(2 * i + repeat, level));
            files.push(file);
        }
    }
    let line = format!(
        "compare {} --meta {{sample}}_{{repeat}} --by sample",
        files.join(" ")
    );
    let own = run(&folder, &line).out();
    assert!(own.contains("S8") && !own.contains("Ra"), "{own}");
    let stated = run(&folder, &format!("{line} --set isotropic")).out();
    assert!(stated.contains("rms rises with Ra"), "{stated}");
    let line = line
        .replace("compare", "strokes")
        .replace(" --by sample", "");
    assert!(!run(&folder, &line).out().contains("sandpaper"));
    let stated = run(&folder, &format!("{line} --set isotropic")).out();
    assert!(stated.contains("sandpaper"), "{stated}");
    let Some(case) = shared("cases/samples_named_S1") else {
        return;
    };
    let case = case.display();
    let all = names.into_iter().chain(["S12"]);
    let files: Vec<String> = all
        .flat_map(|name| [1, 2].map(|i| format!("{case}/{name}_{i}.wav")))
        .collect();
    let mut words = vec![
        "compare",
        "--by",
        "sample",
        "--scale",
        "200 m/s2",
        "--meta",
        "{sample}_{repeat}",
    ];
    words.extend(files.iter().map(String::as_str));
    let own = folder.run(&words).out();
    assert!(own.contains("S12") && !own.contains("Ra"), "{own}");
}

/// A recording of the twin states that it is simulated and which samples it touches: both stand in the result.
#[test]
fn a_simulated_recording_is_called_so_and_its_sample_is_known() {
    let folder = Folder::new();
    for name in ["S2", "S8"] {
        let line =
            format!("twin record --bench acttouch --sample {name} --seed 3 --out {name}.wav");
        run(&folder, &line).expect_success();
    }
    let simulated = "Digital twin: no hardware and no person took part.";
    let commands = [
        "strokes S2.wav S8.wav",
        "strokes --cuts-only S2.wav",
        "compare S2.wav S8.wav --by sample",
        "score S2.wav S8.wav",
    ];
    for (i, line) in commands.into_iter().enumerate() {
        let page = format!("{i}.html");
        let done = run(&folder, &format!("{line} --report {page}"));
        let text = done.out();
        assert_eq!(text.lines().next(), Some(simulated), "{line}: {text}");
        let report = std::fs::read_to_string(folder.path(&page)).unwrap();
        let (said, first) = (report.find(simulated), report.find("<section"));
        assert!(said.is_some() && said < first, "{line}");
    }
    assert!(
        run(&folder, "strokes S2.wav S8.wav")
            .out()
            .contains("sandpaper")
    );
    folder.write("own.csv", one_stroke(1, 1.0));
    let mixed = run(&folder, "strokes S2.wav own.csv").out();
    assert!(
        mixed.starts_with("1 of 2 recordings are simulated. Digital twin:"),
        "{mixed}"
    );
    assert!(!run(&folder, "strokes own.csv").out().contains("twin"));
}

/// Samples whose names differ in capital letters alone are two samples, and both names are said.
#[test]
fn names_that_differ_in_capital_letters_alone_are_a_warning() {
    let folder = Folder::new();
    for (i, name) in ["text9_1", "Text9_2", "text3_1"].into_iter().enumerate() {
        folder.write(&format!("{name}.csv"), one_stroke(i, 1.0));
    }
    let said = |files: &str| {
        let line = format!("compare {files} --meta {{sample}}_{{repeat}} --by sample");
        run(&folder, &line).err()
    };
    let alike = said("text9_1.csv Text9_2.csv text3_1.csv");
    assert!(
        alike.contains("the samples `text9` and `Text9` count as two"),
        "{alike}"
    );
    assert!(!said("text9_1.csv text3_1.csv").contains("count as two"));
}
