//! Commands on a scripted fake: two clocks, drop-outs, lost devices and Ctrl-C end in order, with what was acquired kept.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::support::{Done, Folder, noise, wav};

const FAULTS: &str =
    "clock_ppm = 50\nchunks_s = [0.05, 0.2, 0.013]\ndrop_outs = [{ at_s = 1, samples = 25 }]\n";

/// A folder with a drive, a texture, and scripts: `good`, with two clocks and `gaps` that are lost, and with halves that are lost.
fn prepared() -> Folder {
    let folder = Folder::new();
    folder.write("drive.wav", wav(noise(144_000).map(|v| 0.5 * v), 48_000));
    folder.write("texture.wav", wav(noise(10_000), 5_000));
    folder.write("good.toml", "seed = 1\n");
    folder.write("gaps.toml", FAULTS);
    folder.write(
        "lost.toml",
        format!("{FAULTS}lost = {{ half = \"input\", after_s = 1.5 }}\n"),
    );
    folder.write("mute.toml", "lost = { half = \"output\", after_s = 1.5 }\n");
    folder.write(
        "wrong.toml",
        "fault = { what = \"time_backwards\", at_s = 1 }\n",
    );
    folder.write(
        "short.toml",
        "fault = { what = \"ends_early\", at_s = 1 }\n",
    );
    folder
}

const LOST: &str = "the input of the scripted fake no longer answers after 1.50 s";

/// What `info` says of the recording in `file`.
#[track_caller]
fn told(folder: &Folder, file: &str) -> String {
    let info = folder.run(&["info", file]);
    info.expect_success();
    info.out()
}

#[track_caller]
fn one_sentence(done: &Done) {
    let said = done.err();
    let lines = said.lines().filter(|line| line.starts_with("piezotact: "));
    assert_eq!(lines.count(), 1, "{said}");
}

fn play(folder: &Folder, script: &str, record: &str) -> Done {
    let bench = format!("fake:{script}");
    folder.run(&["play", "drive.wav", "--bench", &bench, "--record", record])
}

#[test]
fn a_drive_is_played_on_a_fake() {
    let folder = prepared();
    let done = play(&folder, "gaps.toml", "m.parquet");
    done.expect_success();
    assert!(
        done.err().contains("lost 25 samples at 1 place,"),
        "{}",
        done.err()
    );
    let said = told(&folder, "m.parquet");
    assert!(
        said.contains("scripted fake") && said.contains("lost 25 samples"),
        "{said}"
    );
    for (script, part, early) in [
        ("lost.toml", LOST, "the run ended early, after 1.50 s"),
        (
            "mute.toml",
            "output of the scripted fake no longer answers",
            "the run ended early, after 1.",
        ),
        (
            "short.toml",
            "the 15000 samples announced with a drive of 3.00 s, found 5000 samples delivered",
            "the run ended early, after 1.00 s",
        ),
        (
            "wrong.toml",
            "a device time that does not run backwards",
            "the run ended early, after 1.00 s",
        ),
    ] {
        let record = script.replace("toml", "parquet");
        let done = play(&folder, script, &record);
        done.expect_failure(1, &[part]);
        one_sentence(&done);
        let said = told(&folder, &record);
        assert!(said.contains(early), "{script}: {said}");
    }
}

#[test]
fn the_help_names_the_fake() {
    let folder = Folder::new();
    for command in [
        vec!["characterise"],
        vec!["render"],
        vec!["play"],
        vec!["panel", "run"],
    ] {
        let help = folder.run(&[command, vec!["--help"]].concat()).out();
        assert!(help.contains("fake:FILE.toml"), "{help}");
    }
}

#[test]
fn scripts_that_are_none_are_refused() {
    let folder = prepared();
    folder.write("bad.toml", "clock_ppm = 2e6\n");
    folder.write("worse.toml", "colour = \"red\"\n");
    play(&folder, "bad.toml", "m.parquet")
        .expect_failure(1, &["bad.toml", "clock_ppm from -10000 to 10000"]);
    play(&folder, "worse.toml", "m.parquet").expect_failure(1, &["worse.toml", "colour"]);
    play(&folder, "none.toml", "m.parquet").expect_failure(1, &["none.toml"]);
    play(&folder, "", "m.parquet").expect_failure(2, &["fake:FILE"]);
    play(&folder, "good.toml,colour=red", "m.parquet").expect_failure(2, &["participant=N"]);
}

fn characterise(folder: &Folder, script: &str, out: &str, more: &[&str]) -> Done {
    let bench = format!("fake:{script}");
    let mut arguments = vec![
        "characterise",
        "--bench",
        &bench,
        "--seconds",
        "6",
        "--out",
        out,
    ];
    arguments.extend(more);
    folder.run(&arguments)
}

#[test]
fn a_fake_is_characterised() {
    let folder = prepared();
    let done = characterise(
        &folder,
        "gaps.toml",
        "tf.json",
        &["--record", "raw.parquet"],
    );
    done.expect_success();
    assert!(done.err().contains("lost 25 samples"), "{}", done.err());
    told(&folder, "tf.json");
    let done = characterise(
        &folder,
        "lost.toml",
        "lost.json",
        &["--record", "lost.parquet"],
    );
    done.expect_failure(1, &[LOST]);
    one_sentence(&done);
    assert!(!folder.path("lost.json").exists());
    let said = told(&folder, "lost.parquet");
    assert!(said.contains("the run ended early, after 1.50 s"), "{said}");
    // Without --record what was acquired is kept beside the output.
    let done = characterise(&folder, "short.toml", "short.json", &[]);
    done.expect_failure(1, &["30000 samples announced", "5000 samples delivered"]);
    one_sentence(&done);
    assert!(!folder.path("short.json").exists());
    let kept = recordings(&folder, "short.json.runs");
    assert_eq!(kept.len(), 1);
    assert!(told(&folder, &kept[0]).contains("the run ended early, after 1.00 s"));
}

/// The recordings in a folder of runs.
fn recordings(folder: &Folder, name: &str) -> Vec<String> {
    let entries = std::fs::read_dir(folder.path(name)).unwrap();
    let mut files: Vec<String> = entries
        .map(|entry| format!("{name}/{}", entry.unwrap().file_name().to_string_lossy()))
        .filter(|file| file.ends_with(".parquet"))
        .collect();
    files.sort();
    files
}

#[test]
fn a_texture_is_rendered_in_a_closed_loop_on_a_fake() {
    let folder = prepared();
    characterise(&folder, "good.toml", "tf.json", &[]).expect_success();
    let render = |script: &str, out: &str| {
        let bench = format!("fake:{script}");
        folder.run(&[
            "render",
            "texture.wav",
            "--transfer",
            "tf.json",
            "--scale",
            "2 m/s2",
            "--mode",
            "texture",
            "--iterations",
            "1",
            "--bench",
            &bench,
            "--out",
            out,
        ])
    };
    folder.write(
        "clocks.toml",
        "clock_ppm = 50\nchunks_s = [0.05, 0.2, 0.013]\n",
    );
    render("clocks.toml", "drive.out.wav").expect_success();
    // Every measurement loses samples: none is believed.
    let done = render("gaps.toml", "gaps.wav");
    done.expect_failure(1, &["the device lost 25 samples"]);
    one_sentence(&done);
    folder.write("late.toml", "lost = { half = \"input\", after_s = 5.5 }\n");
    let done = render("late.toml", "late.wav");
    done.expect_failure(
        1,
        &[
            "input of the scripted fake no longer answers after 5.50 s",
            "give the same command again to continue",
        ],
    );
    one_sentence(&done);
    assert!(!folder.path("late.wav").exists());
    let kept = recordings(&folder, "late.wav.runs");
    assert_eq!(kept.len(), 2, "{kept:?}");
    let early = |file: &&String| told(&folder, file).contains("the run ended early");
    assert_eq!(kept.iter().filter(early).count(), 1);
}

/// A closed loop is rendered from `targets` into `out`.
fn looped(folder: &Folder, targets: &[&str], script: &str, out: &str, more: &[&str]) -> Command {
    let bench = format!("fake:{script}");
    let mut arguments = vec!["render"];
    arguments.extend(targets);
    arguments.extend([
        "--transfer",
        "tf.json",
        "--scale",
        "2 m/s2",
        "--mode",
        "texture",
        "--iterations",
        "1",
        "--bench",
        &bench,
        "--out",
        out,
    ]);
    arguments.extend(more);
    folder.command(&arguments)
}

fn ended(mut command: Command) -> (Option<i32>, String) {
    let output = command.output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    (output.status.code(), said)
}

/// The runs of a command that still runs are its own: another one on the same output is refused, and a killed one holds nobody up.
#[test]
fn one_closed_loop_at_a_time_has_the_runs_of_an_output() {
    let folder = prepared();
    characterise(&folder, "good.toml", "tf.json", &[]).expect_success();
    folder.write("paced.toml", "pace = \"real_time\"\nchunks_s = [0.2]\n");
    let mut first = looped(&folder, &["texture.wav"], "paced.toml", "d.wav", &[])
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let began = Instant::now();
    while !folder.path("d.wav.runs").exists() {
        assert!(began.elapsed() < Duration::from_secs(60));
        std::thread::sleep(Duration::from_millis(10));
    }
    let discard = ["--discard-raw"];
    let second = looped(&folder, &["texture.wav"], "good.toml", "d.wav", &discard);
    let (code, said) = ended(second);
    assert_eq!(code, Some(1), "{said}");
    let who = format!("process {} is still writing to it", first.id());
    assert!(
        said.contains(&who) && said.contains("give another output"),
        "{said}"
    );
    assert!(folder.path("d.wav.runs").exists());
    first.kill().unwrap();
    first.wait().unwrap();
    let again = looped(&folder, &["texture.wav"], "good.toml", "d.wav", &discard);
    let (code, said) = ended(again);
    assert_eq!(code, Some(0), "{said}");
    let left = folder.names();
    assert!(
        !left.iter().any(|name| name.starts_with("d.wav.runs")),
        "{left:?}"
    );
}

/// A closed loop whose device is lost fails, keeps what it has, and goes on with the same command; so does a batch.
#[test]
fn a_closed_loop_that_loses_its_device_goes_on_later() {
    let folder = prepared();
    characterise(&folder, "good.toml", "tf.json", &[]).expect_success();
    folder.write("rough.wav", wav(noise(10_000).map(|v| 0.7 * v), 5_000));
    // Silence of 4 s and the open loop's two runs of 2 s each, with a rest behind each, are over; a batch opens the bench anew
    // for each texture.
    let lost = "lost = { half = \"input\", after_s = 10.5 }\n";
    for (targets, out) in [
        (vec!["texture.wav"], "d.wav"),
        (vec!["texture.wav", "rough.wav"], "drives"),
    ] {
        folder.write("bench.toml", lost);
        let (code, said) = ended(looped(
            &folder,
            &targets,
            "bench.toml",
            out,
            &["--discard-raw"],
        ));
        assert_eq!(code, Some(1), "{said}");
        assert!(said.contains("no longer answers after 10.50 s"), "{said}");
        assert!(said.contains("holds the best drive so far"), "{said}");
        let last = said.lines().last().unwrap();
        assert!(
            last.contains("give the same command again to continue"),
            "{said}"
        );
        folder.write("bench.toml", "seed = 1\n");
        let (code, said) = ended(looped(
            &folder,
            &targets,
            "bench.toml",
            out,
            &["--discard-raw"],
        ));
        assert_eq!(code, Some(0), "{said}");
        let taken = said.matches("taken from the interrupted").count();
        assert_eq!(taken, targets.len(), "{said}");
    }
    assert!(!folder.path("d.wav.runs").exists());
    assert_eq!(std::fs::read_dir(folder.path("drives")).unwrap().count(), 4);
}

#[test]
fn a_panel_is_measured_on_a_fake() {
    let folder = prepared();
    let panel = |script: &str, out: &str| {
        let bench = format!("fake:{script}");
        folder.run(&[
            "panel",
            "run",
            "--bench",
            &bench,
            "--participants",
            "1..2",
            "--loads",
            "0.2",
            "--angles",
            "20",
            "--seconds",
            "4",
            "--repeats",
            "1",
            "--out",
            out,
        ])
    };
    panel("gaps.toml", "people").expect_success();
    assert_eq!(recordings(&folder, "people/raw").len(), 2);
    // It goes on with the same script, or not at all.
    let measured = "2 of 2 measurements already exist";
    let again = panel("gaps.toml", "people");
    again.expect_success();
    assert!(again.err().contains(measured), "{}", again.err());
    let written = std::fs::read_to_string(folder.path("people/panel.json")).unwrap();
    folder.write("gaps.toml", "device = { gain_m_s2 = 24.0 }\n");
    let done = panel("gaps.toml", "people");
    done.expect_failure(
        2,
        &[
            "gaps.toml as it was when the panel was started",
            "another folder",
        ],
    );
    one_sentence(&done);
    let written: serde_json::Value = serde_json::from_str(&written).unwrap();
    assert_eq!(written["bench_files"][0]["file"], "gaps.toml");
    let done = panel("lost.toml", "lost");
    done.expect_failure(1, &[LOST]);
    one_sentence(&done);
    let kept = recordings(&folder, "lost/raw");
    assert_eq!(kept.len(), 1);
    assert!(told(&folder, &kept[0]).contains("the run ended early, after 1.50 s"));
}

/// What a command that was ended while it finished a recording has left: `info` reads the journal, and the next command of that
/// name removes half copies, keeps the journal, and says both.
#[test]
fn what_an_ended_command_left_is_cleaned_up() {
    let folder = prepared();
    folder.write("paced.toml", "pace = \"real_time\"\nchunks_s = [0.1]\n");
    let bench = ["--bench", "fake:paced.toml", "--record", "m.parquet"];
    let arguments = [vec!["play", "drive.wav"], bench.to_vec()].concat();
    let mut child = folder.command(&arguments);
    let mut child = child.stderr(Stdio::null()).spawn().unwrap();
    let began = Instant::now();
    let length = || std::fs::metadata(folder.path("m.parquet.part")).map_or(0, |part| part.len());
    while length() < 20_000 {
        assert!(began.elapsed() < Duration::from_secs(60));
        std::thread::sleep(Duration::from_millis(10));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    folder.write(".piezotact-unfinished-m.parquet.whole-a1.tmp", "half");
    folder.write("m.parquet.whole", "half");
    let said = told(&folder, "m.parquet");
    assert!(
        said.contains("journal of an interrupted recording"),
        "{said}"
    );
    let done = play(&folder, "good.toml", "m.parquet");
    done.expect_success();
    for part in [
        "removed 2 incomplete copies",
        "is kept as m.parquet.interrupted-1.part",
    ] {
        assert!(done.err().contains(part), "{}", done.err());
    }
    let mut left = folder.names();
    left.retain(|name| name.contains("m.parquet"));
    assert_eq!(left, ["m.parquet", "m.parquet.interrupted-1.part"]);
}

/// Ctrl-C in a run in real time: it ends in order, and what was acquired is kept.
#[cfg(unix)]
#[test]
fn an_interrupt_ends_a_run_in_order() {
    use std::io::Read;

    let folder = prepared();
    folder.write("paced.toml", "pace = \"real_time\"\nchunks_s = [0.2]\n");
    let mut child = folder
        .command(&[
            "play",
            "drive.wav",
            "--bench",
            "fake:paced.toml",
            "--record",
            "m.parquet",
        ])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let began = Instant::now();
    let journal = || {
        folder
            .names()
            .iter()
            .any(|name| name.starts_with("m.") && name != "m.parquet")
    };
    while !journal() {
        assert!(
            began.elapsed() < Duration::from_secs(60),
            "nothing was begun: {:?}",
            folder.names()
        );
        std::thread::sleep(Duration::from_millis(10));
    }
    std::thread::sleep(Duration::from_millis(700));
    let interrupt = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(interrupt.unwrap().success());
    let sent = Instant::now();
    let code = child.wait().unwrap().code();
    assert!(
        sent.elapsed() < Duration::from_secs(5),
        "{:?}",
        sent.elapsed()
    );
    let mut said = String::new();
    child
        .stderr
        .take()
        .unwrap()
        .read_to_string(&mut said)
        .unwrap();
    assert_eq!(code, Some(130), "{said}");
    assert!(said.contains("stopped by hand after"), "{said}");
    let told = told(&folder, "m.parquet");
    assert!(
        told.contains("the run ended early") && told.contains("stopped by hand"),
        "{told}"
    );
    let left: Vec<String> = folder
        .names()
        .into_iter()
        .filter(|name| name.starts_with("m."))
        .collect();
    assert_eq!(left, ["m.parquet"]);
}

/// Segments that touch samples which were lost are left out, when a device is characterised and from its recording.
#[test]
fn a_transfer_function_leaves_out_what_was_lost() {
    let folder = prepared();
    folder.write(
        "holes.toml",
        "drop_outs = [{ at_s = 2, samples = 250, since = \"run\" }, { at_s = 4, samples = 40, since = \"run\" }]\n",
    );
    let plain = characterise(&folder, "good.toml", "good.json", &["--json"]).json();
    let record = ["--record", "raw.parquet", "--json"];
    let said = characterise(&folder, "holes.toml", "holes.json", &record).json();
    let find = |said: &serde_json::Value, by: &str| {
        let warnings = said["warnings"].as_array().unwrap();
        let is = |d: &&serde_json::Value| d["code"] == "samples_lost" && d["by"] == by;
        warnings.iter().find(is).cloned()
    };
    let lost = find(&said, "device").unwrap();
    let places = lost["places_s"].as_array().unwrap().clone();
    assert_eq!(places.len(), 2, "{lost}");
    let left_out = find(&said, "segments").unwrap();
    let count = |what: &str| left_out[what].as_u64().unwrap();
    assert!((3..=6).contains(&count("left_out")), "{left_out}");
    assert_eq!(count("of"), plain["averages"].as_u64().unwrap());
    assert_eq!(
        said["averages"].as_u64().unwrap(),
        count("of") - count("left_out")
    );
    // The straight lines drive nothing any more.
    let mut warnings = said["warnings"].as_array().unwrap().iter();
    assert!(warnings.all(|d| d["code"] != "not_excited"), "{said}");
    let transfer = |segment: &str| {
        folder.run(&[
            "transfer",
            "raw.parquet",
            "--drive",
            "drive",
            "--response",
            "acceleration",
            "--segment",
            segment,
            "--out",
            "again.json",
            "--json",
        ])
    };
    let again = transfer("2048").json();
    assert_eq!(find(&again, "segments"), Some(left_out));
    let numbers = |name: &str| -> Vec<f64> {
        let text = std::fs::read_to_string(folder.path(name)).unwrap();
        let document: serde_json::Value = serde_json::from_str(&text).unwrap();
        let real = document["real"].as_array().unwrap();
        real.iter().map(|v| v.as_f64().unwrap()).collect()
    };
    assert_eq!(numbers("again.json"), numbers("holes.json"));
    transfer("16384").expect_failure(1, &["raw.parquet", "4 segments or more", "found 0 of 2"]);
}

/// A realisation of a multisine, or a sweep, that touches what was lost is left out as a whole; too few left are refused.
#[test]
fn realisations_and_sweeps_that_lost_samples_are_left_out() {
    let folder = prepared();
    folder.write(
        "hole.toml",
        "drop_outs = [{ at_s = 1, samples = 50, since = \"run\" }]\n",
    );
    let holes: Vec<String> = (0..41)
        .map(|k| {
            format!(
                "{{ at_s = {}, samples = 50, since = \"run\" }}",
                0.5 + 0.5 * f64::from(k)
            )
        })
        .collect();
    folder.write(
        "holes.toml",
        format!("drop_outs = [{}]\n", holes.join(", ")),
    );
    for kind in ["multisine", "sweep"] {
        let run = |script: &str| {
            let more = [
                "--excitation",
                kind,
                "--gate",
                "off",
                "--seconds",
                "20",
                "--json",
            ];
            let bench = format!("fake:{script}");
            let fixed = ["characterise", "--bench", &bench, "--out", "tf.json"];
            folder.run(&[&fixed[..], &more].concat())
        };
        let said = run("hole.toml").json();
        let warnings = said["warnings"].as_array().unwrap();
        let left_out = warnings
            .iter()
            .find(|d| d["code"] == "samples_lost" && d["by"] == "segments");
        assert_eq!(left_out.unwrap()["left_out"], 1, "{kind}: {said}");
        run("holes.toml").expect_failure(1, &["sweeps or realisations", "lost samples"]);
    }
}
