//! Sessions with rendered textures: what is played, what is refused before, and what the experimenter sees.

#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]
#![allow(clippy::print_stderr, reason = "a test says what it left out")]

use std::sync::OnceLock;
use std::time::{Duration, SystemTime};

use piezotact::recording::StartTime;
use piezotact_dataset::{ReadOptions, read_recording, write_measurement};

use crate::campaign_session::{holds, run, session, until, whole};
use crate::support::session::{table, two_sets};
use crate::support::{BENCH, Done, Folder, copy};

/// Four textures, their strokes, the transfer function and the drives of P01.
pub(crate) fn prepared() -> &'static Folder {
    static PREPARED: OnceLock<Folder> = OnceLock::new();
    PREPARED.get_or_init(|| {
        let folder = Folder::new();
        for sample in ["S2", "S4", "S8", "S9"] {
            let line = format!(
                "twin record --bench acttouch --sample {sample} --participant 1 --seed 7 --strokes 3 --stroke-time 1s --out {sample}.parquet"
            );
            run(&folder, &line).expect_success();
        }
        let line = format!("characterise --bench {BENCH} --out tf.json");
        run(&folder, &line).expect_success();
        let line = format!(
            "prepare S2.parquet S4.parquet S8.parquet S9.parquet --transfer tf.json --bench {BENCH} --mode texture --out drives"
        );
        run(&folder, &line).expect_success();
        folder
    })
}

/// A study with that protocol in which P01 was measured.
pub(crate) fn measured() -> Folder {
    let folder = Folder::new();
    folder.write("protocol.toml", two_sets());
    copy(&prepared().path("drives"), &folder.path("drives"));
    run(
        &folder,
        "campaign new study --protocol protocol.toml --seed 7",
    )
    .expect_success();
    whole(&folder, "campaign run study P01 measurement");
    folder
}

pub(crate) const DISCRIMINATE: &str =
    "campaign run study P01 discrimination --drives drives --bench";

#[test]
fn a_session_with_rendered_textures_runs_to_its_end_on_the_twin() {
    let folder = measured();
    let seen = whole(&folder, &format!("{DISCRIMINATE} {BENCH}"));
    holds(
        &seen,
        &[
            "trial 1 of 7 · task1",
            "in order, from the roughest to the smoothest",
            "textures on the device: Enter plays them one after the other",
            "on the tray, in the participant's order: A S",
            "texture 1 is played …",
            "texture 1: force",
            "is complete: task1: 3 of 3 trials, task2: 2 of 2 trials, task3: 2 of 2 trials",
        ],
    );
    // Which texture met its target could tell which one it is.
    assert!(!seen.contains("texture 1, target") && seen.contains("target met, texture 1"));
    let verified = run(&folder, "campaign verify study");
    verified.expect_success();
    assert!(!verified.err().contains("no answer counts"));
    // What an attempt that was killed leaves is named.
    let runs = folder.path("study/participants/P01/discrimination/runs");
    std::fs::write(runs.join("x-1-1-1.parquet.part"), "").unwrap();
    let verified = run(&folder, "campaign verify study");
    verified.expect_success();
    let said = verified.err();
    assert!(
        said.contains("1 recording of attempts that were void, repeated or interrupted")
            && said.contains("x-1-1-1"),
        "{said}"
    );
    run(&folder, "campaign export study --out exported").expect_success();
    for session in ["measurement", "discrimination"] {
        let report = folder.path(&format!("exported/reports/P01_{session}.html"));
        let report = std::fs::read_to_string(report).unwrap();
        assert!(report.contains(&format!("Session {session} of P01")));
    }
    let trials = table(&folder.path("exported/trials.csv"));
    let of = |task: &str| {
        let rows = trials.iter().filter(|row| row["task"] == task);
        rows.cloned().collect::<Vec<_>>()
    };
    let evidence = table(&folder.path("exported/evidence.csv"));
    let played: usize = of("task3")
        .iter()
        .map(|row| row["presented"].split('|').count())
        .sum();
    assert_eq!(evidence.len(), played);
    for row in &evidence {
        assert_eq!(row["verified"], "met", "{row:?}");
        assert!(row["drive_sha256"].len() == 64 && !row["onset_s"].is_empty());
        let journal = folder
            .path("study/participants/P01/discrimination")
            .join(&row["journal"]);
        assert!(journal.is_file(), "{}", journal.display());
        // The screen never says which stimulus it was.
        let line = format!("texture {}", row["element"]);
        assert!(seen.contains(&line), "{line}");
    }
    // In task 3 A, B and C are the participant's own order of task 2.
    let answers = table(&folder.path("exported/answers.csv"));
    for (order, trial) in of("task2").iter().zip(of("task3")) {
        let own: Vec<&str> = order["answer"].split('|').collect();
        let count = trial["presented"].split('|').count();
        let said: Vec<&str> = own.iter().copied().cycle().take(count).collect();
        assert_eq!(trial["answer"], said.join("|"));
        // In the table of answers a trial has a row for each position.
        let rows = answers.iter().filter(|row| row["trial"] == trial["trial"]);
        let rows: Vec<&str> = rows.map(|row| row["answered"].as_str()).collect();
        assert_eq!(rows, said);
    }
}

#[test]
fn drives_that_are_missing_or_of_somebody_else_are_refused() {
    let folder = measured();
    let refused = |line: &str, code: i32, parts: &[&str]| {
        run(&folder, line).expect_failure(code, parts);
        run(&folder, "campaign status study --csv status.csv --force").expect_success();
        let status = std::fs::read_to_string(folder.path("status.csv")).unwrap();
        assert!(!status.contains("discrimination"), "{status}");
        assert!(
            !folder
                .path("study/participants/P01/discrimination")
                .exists()
        );
    };
    let on_bench = format!("{DISCRIMINATE} {BENCH}");
    refused(
        "campaign run study P01 discrimination --drives drives",
        2,
        &["name the bench with --bench, or play them on another system with --by-hand"],
    );
    refused(
        &format!("campaign run study P01 discrimination --bench {BENCH}"),
        1,
        &[
            "there is no drive; prepare it",
            "cannot begin, for the",
            "nothing was stored",
        ],
    );
    let measured = |sample: &str| folder.path(&format!("drives/measured/{sample}.parquet"));
    let right = std::fs::read(measured("S8")).unwrap();
    std::fs::remove_file(measured("S8")).unwrap();
    refused(
        &on_bench,
        1,
        &[
            "S8: expected drives/measured/S8.parquet beside its other files, found nothing",
            "for the reason above",
        ],
    );
    std::fs::copy(measured("S2"), measured("S8")).unwrap();
    refused(
        &on_bench,
        1,
        &["S8: the measurement beside it was made with another drive"],
    );
    let elsewhere = |bench: &str| {
        let line = format!(
            "--force play drives/drives/S8.wav --bench {bench} --record drives/measured/S8.parquet"
        );
        run(&folder, &line).expect_success();
    };
    // Another finger may come to the target: that decides nothing.
    elsewhere("twin:participant=4,seed=7");
    refused(
        &on_bench,
        1,
        &["S8: its verification is not decided; prepare it again"],
    );
    elsewhere("twin:participant=1,seed=9");
    let wrong = std::fs::read(measured("S8")).unwrap();
    refused(
        &on_bench,
        1,
        &[
            "S8: its verification is not met; prepare it again",
            "found the twin of seed 9; name that bench",
            "for the 2 reasons above",
        ],
    );
    std::fs::write(measured("S8"), right).unwrap();
    // The recording says itself when it was made: a touch does not renew it.
    let right = std::fs::read(measured("S4")).unwrap();
    let touch = |at: SystemTime| {
        let mut options = std::fs::File::options();
        let file = options.write(true).open(measured("S4")).unwrap();
        file.set_modified(at).unwrap();
    };
    let date = |date: &str| {
        let file = measured("S4");
        let mut read = read_recording(&file, &ReadOptions::default()).unwrap();
        read.recording.annotations.started_at = StartTime::try_from(date.to_owned()).ok();
        let (setup, rendering) = (read.setup.as_ref(), read.rendering.as_ref());
        write_measurement(&file, &read.recording, setup, rendering).unwrap();
        touch(SystemTime::now());
    };
    date("2024-03-01T00:00:00Z");
    refused(
        &on_bench,
        1,
        &[
            "S4: expected a measurement of the drive of the last 720 h, found an age of",
            "for the reason above",
        ],
    );
    date("2999-01-01T00:00:00Z");
    refused(
        &on_bench,
        1,
        &["S4: expected a measurement of the drive with its date, found a date"],
    );
    std::fs::write(measured("S4"), right).unwrap();
    let long = SystemTime::now() - Duration::from_secs(3600 * 721);
    touch(long);
    // Somebody else's.
    whole(&folder, "campaign run study P02 measurement");
    let other = on_bench.replace("P01", "P02");
    run(&folder, &other).expect_failure(
        1,
        &[
            "expected strokes of P02, found those of P01; prepare the drives of P02",
            "expected the transfer function of P02, found the transfer function of P01",
        ],
    );
    assert!(
        !folder
            .path("study/participants/P02/discrimination")
            .exists()
    );
    // A rehearsal says it only; so nobody is called in vain.
    let mut rehearsal = session(
        &folder,
        &format!("{} --rehearsal", other.replace("P02", "P03")),
    );
    holds(&rehearsal.prompt().unwrap(), &["consent>"]);
    drop(rehearsal);
    // A session that was begun takes no other drives than those that it may be begun with.
    let mut begun = session(&folder, &on_bench);
    until(&mut begun, "trial 2 of 7");
    begun.kill();
    std::fs::write(measured("S8"), wrong).unwrap();
    run(&folder, &on_bench).expect_failure(
        1,
        &[
            "S8: its verification is not met",
            "cannot go on, for the 2 reasons above",
        ],
    );
    let without = on_bench.replace("--drives drives ", "");
    let mut goes_on = session(&folder, &without);
    holds(
        &goes_on.prompt().unwrap(),
        &["goes on where it was left: task1: 1 of 3 trials"],
    );
    goes_on.type_line("");
    until(&mut goes_on, "trial 2 of 7");
    goes_on.kill();
    // Who takes part was stated when it began.
    let mut other = session(&folder, &format!("{without} --language it"));
    other.prompt().unwrap();
    other.type_line("/leave");
    holds(
        &other.end().1,
        &["--language it is not applied: the session goes on without it, as it was begun"],
    );
}

/// Drives that were prepared again between two parts of a session are not what its first trials presented.
#[test]
fn a_session_goes_on_with_the_drives_that_it_played() {
    let folder = measured();
    let on_bench = format!("{DISCRIMINATE} {BENCH}");
    let mut begun = session(&folder, &on_bench);
    until(&mut begun, "texture 1: force");
    begun.kill();
    let from = |file: &str| prepared().path(file).display().to_string();
    let strokes = ["S2", "S4", "S8", "S9"].map(|sample| from(&format!("{sample}.parquet")));
    let prepare = format!(
        "prepare {} --transfer {} --bench {BENCH} --out again",
        strokes.join(" "),
        from("tf.json")
    );
    run(&folder, &prepare);
    let exchanged = run(&folder, &on_bench.replace("drives drives", "drives again"));
    exchanged.expect_failure(
        1,
        &[
            "expected the drive that this session played before, found another one in",
            "the session keeps its own",
        ],
    );
    for line in [on_bench.replace("--drives drives ", ""), on_bench] {
        let mut goes_on = session(&folder, &line);
        holds(&goes_on.prompt().unwrap(), &["goes on where it was left"]);
        goes_on.kill();
    }
}

/// The refusals of `done` for what is there, by their first words: most stimuli have no drive in this test.
fn not_ready(done: &Done) -> Vec<String> {
    let said = done.err();
    let lines = said
        .lines()
        .filter_map(|line| line.strip_prefix("not ready: "));
    let lines = lines.filter(|line| !line.contains("there is no drive"));
    lines.map(str::to_owned).collect()
}

/// The files of a stimulus.
const PARTS: [(&str, &str); 5] = [
    ("targets", "wav"),
    ("targets", "wav.json"),
    ("drives", "wav"),
    ("drives", "wav.json"),
    ("measured", "parquet"),
];

/// A level that is compared with another one is rendered, not copied: one texture for all is no experiment.
#[test]
fn stimuli_are_made_by_manipulate_and_prepare_and_copies_of_one_drive_are_refused() {
    let folder = Folder::new();
    let from = |file: &str| prepared().path(file).display().to_string();
    let prepare = format!(
        "--transfer {} --bench {BENCH} --mode texture --out drives",
        from("tf.json")
    );
    let lines = [
        format!(
            "manipulate {} --gain 0.425dB --out S8_increment_-26.wav",
            from("drives/targets/S8.wav")
        ),
        format!(
            "manipulate {} --gain 0.5dB --out S8_increment_-22.wav",
            from("drives/targets/S8.wav")
        ),
        format!(
            "prepare {} S8_increment_-26.wav S8_increment_-22.wav {prepare}",
            from("S8.parquet")
        ),
        "campaign new study --protocol roughness_jnd --seed 7".to_owned(),
    ];
    for line in &lines {
        run(&folder, line).expect_success();
    }
    let session = format!("campaign run study P01 discrimination --drives drives --bench {BENCH}");
    let faults = not_ready(&run(&folder, &session));
    assert!(
        faults.len() == 1
            && faults[0].starts_with("S8 increment -22: expected the level of S8 itself +0.664 dB, found its own level +0.500 dB"),
        "{faults:?}"
    );
    for (part, ending) in PARTS {
        let file = |name: &str| folder.path(&format!("drives/{part}/{name}.{ending}"));
        std::fs::copy(file("S8"), file("S8_increment_-22")).unwrap();
    }
    let done = run(&folder, &session);
    done.expect_failure(1, &["cannot begin, for the", "nothing was stored"]);
    let faults = not_ready(&done);
    let parts = [
        "S8 increment -22: expected a drive of its own in",
        "S8_increment_-22.wav, found that of S8 in",
        "prepare both again as the protocol states them",
    ];
    assert!(
        faults.len() == 1 && parts.iter().all(|part| faults[0].contains(part)),
        "{faults:?}"
    );
}

/// The campaign of thesis 4.4.1, of two of its samples: levels exchanged, as they are measured again on the bench.
#[test]
fn stimuli_of_a_protocol_are_prepared_from_strokes_and_reach_the_levels_that_it_states() {
    let folder = Folder::new();
    let from = |file: &str| prepared().path(file).display().to_string();
    let line = "twin record --bench acttouch --sample S13 --participant 1 --seed 7 --strokes 3 --stroke-time 1s --out S13.parquet";
    run(&folder, line).expect_success();
    let prepare = format!(
        "prepare {} S13.parquet --protocol amplitude_inversion --transfer {} --bench {BENCH} --mode texture --out drives --json",
        from("S2.parquet"),
        from("tf.json")
    );
    let made = ["S2", "S13", "S2 INVERTED", "S13 INVERTED"];
    let checked = |done: &Done| {
        let (found, code) = done.json_and_code();
        assert_eq!(code, Some(5), "{}", done.err());
        let stimuli = found["stimuli"].as_array().unwrap();
        assert_eq!(stimuli.len(), 10);
        for one in stimuli {
            let name = one["stimulus"].as_str().unwrap();
            if !made.contains(&name) {
                assert_eq!(one["ready"], "not_decided", "{one}");
                assert!(
                    one["reasons"][0]
                        .as_str()
                        .unwrap()
                        .contains("there is no drive"),
                    "{one}"
                );
                continue;
            }
            assert_eq!(one["ready"], "met", "{one}");
            let number = |key: &str| one[key].as_f64().unwrap();
            assert!(
                (number("measured_db") - number("stated_db")).abs() <= 0.5,
                "{one}"
            );
            assert!(number("shape_db") <= 1.0, "{one}");
        }
        let inverted = stimuli.iter().find(|one| one["stimulus"] == "S2 INVERTED");
        assert_eq!(inverted.unwrap()["level_of"], "S13");
    };
    let done = run(&folder, &prepare);
    checked(&done);
    let lacking = "S5 INVERTED: not made: expected strokes on S5, found none";
    assert!(done.err().contains(lacking), "{}", done.err());
    // As a kill leaves it: what is there and holds is not made again.
    let file = |part: &str| folder.path(&format!("drives/{part}"));
    std::fs::remove_file(file("measured/S13_INVERTED.parquet")).unwrap();
    let again = run(&folder, &prepare);
    checked(&again);
    for name in made {
        let held = again.err().contains(&format!("{name}: prepared before"));
        assert_eq!(held, name != "S13 INVERTED", "{name}: {}", again.err());
    }
    // What a session refuses is made again: byte-for-byte copies, and the stroke of another recording.
    let study = "campaign new study --protocol amplitude_inversion --seed 7";
    run(&folder, study).expect_success();
    let session = format!("campaign run study P01 discrimination --drives drives --bench {BENCH}");
    let faults = not_ready(&run(&folder, &session));
    assert!(
        faults
            .iter()
            .all(|fault| fault.starts_with("session measurement")),
        "{faults:?}"
    );
    let copied = |from: &str| {
        for (part, ending) in PARTS {
            std::fs::copy(
                file(&format!("{part}/{from}.{ending}")),
                file(&format!("{part}/S2_INVERTED.{ending}")),
            )
            .unwrap();
        }
    };
    for (from, part) in [
        (
            "S2",
            "S2 INVERTED: expected a drive of its own in drives/drives/S2_INVERTED.wav, found that of S2 in",
        ),
        (
            "S13_INVERTED",
            "S2 INVERTED: expected a drive of its own in drives/drives/S2_INVERTED.wav, found that of S13 INVERTED",
        ),
    ] {
        copied(from);
        let faults = not_ready(&run(&folder, &session));
        assert!(
            faults.iter().any(|fault| fault.contains(part)),
            "{faults:?}"
        );
    }
    let made_again = |done: &Done, of: &str| {
        checked(done);
        let said = done.err();
        for name in made {
            let held = said.contains(&format!("{name}: prepared before"));
            assert_eq!(held, name != of, "{name}: {said}");
        }
    };
    let again = run(&folder, &prepare);
    made_again(&again, "S2 INVERTED");
    let kept = "S2_INVERTED.wav: what an earlier command left is kept as";
    assert!(again.err().contains(kept), "{}", again.err());
    // A sidecar that was edited after the measurement: louder, or without the checksum of its samples.
    let edited = |from: &str, to: &str| {
        let sidecar = file("drives/S13.wav.json");
        let text = std::fs::read_to_string(&sidecar).unwrap();
        let start = text.find(from).unwrap();
        let end = start + text[start..].find('\n').unwrap();
        std::fs::write(&sidecar, format!("{}{to}{}", &text[..start], &text[end..])).unwrap();
    };
    edited("\"value\": 1.0,", "\"value\": 1.5,");
    let faults = not_ready(&run(&folder, &session));
    let part = "S13: the measurement beside it was made with another drive";
    assert!(
        faults.iter().any(|fault| fault.contains(part)),
        "{faults:?}"
    );
    made_again(&run(&folder, &prepare), "S13");
    edited("\"samples\":", "\"remark\": \"none\",");
    // All files that are wrong are named at once.
    let sidecar = file("drives/S2.wav.json");
    let text = std::fs::read(&sidecar).unwrap();
    std::fs::write(&sidecar, "{").unwrap();
    run(&folder, &session).expect_failure(
        1,
        &[
            "S13.wav: expected a drive with a sidecar that states how it was rendered and the checksum of its samples",
            "S2.wav.json",
        ],
    );
    std::fs::write(&sidecar, text).unwrap();
    made_again(&run(&folder, &prepare), "S13");
    // One sample again alone: its own level is not that of the others.
    let alone = format!(
        "prepare {} --protocol amplitude_inversion --transfer {} --bench {BENCH} --out drives",
        from("S2.parquet"),
        from("tf.json")
    );
    run(&folder, &format!("{alone} --level fit")).expect_failure(
        2,
        &["expected one level for all stimuli of a protocol, found --level fit"],
    );
    let done = run(&folder, &format!("{alone} --level -12"));
    let kept = "S2.wav: what an earlier command left is kept as";
    assert!(done.err().contains(kept), "{}", done.err());
    let faults = not_ready(&run(&folder, &session));
    let part = "S2: expected the level of S2 itself, found its own level, rendered -";
    assert!(
        faults.iter().any(|fault| fault.contains(part)),
        "{faults:?}"
    );
}

#[test]
fn stimuli_whose_files_would_have_one_name_are_refused_with_the_study() {
    let folder = Folder::new();
    let line = "campaign protocol amplitude_inversion --out own.toml";
    run(&folder, line).expect_success();
    let text = std::fs::read_to_string(folder.path("own.toml")).unwrap();
    folder.write("own.toml", text.replace("S13 INVERTED", "S2_inverted"));
    run(&folder, "campaign new study --protocol own.toml --seed 7").expect_failure(
        1,
        &[
            "expected stimuli whose files have different names",
            "rename one in the protocol",
        ],
    );
    assert!(!folder.path("study").exists());
}

/// What would be found out with the volunteer in the chair is found out before: nothing is stored, nothing is played.
#[test]
fn drives_that_do_not_fit_the_bench_as_it_is_now_are_refused_before_the_session() {
    let folder = measured();
    let refused = |bench: &str, parts: &[&str]| {
        let done = run(&folder, &format!("{DISCRIMINATE} {bench}"));
        done.expect_failure(1, parts);
        done.expect_failure(1, &["cannot begin, for the", "nothing was stored"]);
        // One sentence for each fault, however many drives have it.
        let said = done.err();
        let lines = said.lines().filter(|line| line.starts_with("not ready: "));
        assert_eq!(lines.count(), parts.len(), "{said}");
        run(&folder, "campaign status study --csv status.csv --force").expect_success();
        let status = std::fs::read_to_string(folder.path("status.csv")).unwrap();
        assert!(!status.contains("discrimination"), "{status}");
        assert!(
            !folder
                .path("study/participants/P01/discrimination")
                .exists()
        );
    };
    refused(
        "twin:participant=1,seed=7,gain=B2",
        &["S9: cannot play: the drive was rendered for gain B3, but"],
    );
    refused(
        "twin:participant=1,seed=7,device=fixed",
        &["cannot play: the drive was rendered for DRV2667 at gain B3"],
    );
    refused(
        "twin:participant=1,seed=9",
        &[
            "expected strokes of the twin of seed 9, which is on the bench, found the twin of seed 7",
            "expected a transfer function of the twin of seed 9",
            "expected a measurement of the drive of the twin of seed 9",
        ],
    );
    refused(
        "twin:participant=2,seed=7",
        &["expected the finger of P01 on the bench, found that of P02"],
    );
    // Another finger has the gain wrong too: both are said.
    refused(
        "twin:participant=2,seed=7,gain=B2",
        &[
            "expected the finger of P01 on the bench, found that of P02",
            "rendered for gain B3",
        ],
    );
    let line = format!(
        "--force play drives/drives/S4.wav --bench {BENCH} --load 0.5 --record drives/measured/S4.parquet"
    );
    run(&folder, &line).expect_success();
    let done = run(&folder, &format!("{DISCRIMINATE} {BENCH}"));
    done.expect_failure(
        1,
        &["S4: expected a measurement of the drive with the finger at 0.2 N as in this session, found 0.5 N"],
    );
}

/// What the loopback cannot see: the knob of a sensor.
#[test]
fn a_sensor_that_was_turned_up_is_refused_before_the_session() {
    let folder = measured();
    let gains = [("stored", 12.0), ("same", 12.7), ("double", 24.0)];
    for (seed, (name, gain)) in gains.into_iter().enumerate() {
        folder.write(
            &format!("{name}.toml"),
            format!("seed = {seed}\ndevice = {{ gain_m_s2 = {gain} }}\n"),
        );
        let line = format!(
            "characterise --bench fake:{name}.toml --seconds 5 --gate off --out {name}.json"
        );
        run(&folder, &line).expect_success();
    }
    let line = |today: &str| format!("{DISCRIMINATE} {BENCH} --at-rest stored.json {today}.json");
    run(&folder, &line("double")).expect_failure(
        1,
        &[
            "not ready: expected the level of the sensor relative to its stored response within ±1.5 dB, found +6.0 dB; set its amplifier back",
            "for the reason above",
        ],
    );
    let mut begun = session(&folder, &line("same"));
    until(&mut begun, "trial 1 of 7");
}

#[test]
fn a_session_waits_for_those_before_it_and_for_another_day() {
    let folder = Folder::new();
    run(
        &folder,
        "campaign new study --protocol isotropic_triplets --seed 7",
    )
    .expect_success();
    let line = "campaign run study P01 discrimination --by-hand";
    run(&folder, line).expect_failure(
        1,
        &["session measurement comes before this one and was not ended"],
    );
    whole(&folder, "campaign run study P01 measurement");
    run(&folder, line).expect_failure(
        1,
        &[
            "expected another day than that of session measurement, found 0.0 h between them",
            "come back after 12 h",
            "nothing was stored",
        ],
    );
    let plan = || run(&folder, "campaign plan study P01 discrimination --json").out();
    assert_eq!(plan(), plan());
}

#[test]
fn played_by_hand_the_experimenter_sees_what_to_play() {
    let folder = measured();
    let line = "campaign run study P01 discrimination --by-hand";
    let mut by_hand = session(&folder, line);
    let text = until(&mut by_hand, "play by hand");
    drop(by_hand);
    run(&folder, "campaign export study --out exported").expect_success();
    let trials = table(&folder.path("exported/trials.csv"));
    let first = trials.iter().find(|row| row["task"] == "task3").unwrap();
    let listed = first["planned"].split('|').enumerate();
    let listed: Vec<String> = listed
        .map(|(i, name)| format!("{} {name}", i + 1))
        .collect();
    holds(&text, &[&listed.join(" ")]);
}
