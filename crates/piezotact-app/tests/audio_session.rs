//! A session of a campaign on a sound device: its stimuli are played and verified there, and a playing that was interrupted makes its trial void.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::sync::OnceLock;

use crate::audio::setup;
use crate::campaign_session::{holds, run, whole};
use crate::support::session::{table, two_sets};
use crate::support::{Folder, copy};

/// Drives that were prepared on the sound device for P01, and its calibration.
fn prepared() -> &'static Folder {
    static PREPARED: OnceLock<Folder> = OnceLock::new();
    PREPARED.get_or_init(|| {
        let folder = Folder::new();
        folder.write("setup.toml", setup(""));
        for sample in ["S2", "S4", "S8", "S9"] {
            let line = format!(
                "twin record --bench acttouch --sample {sample} --participant 1 --seed 7 --strokes 3 --stroke-time 1s --out {sample}.parquet"
            );
            run(&folder, &line).expect_success();
        }
        for line in [
            "sound calibrate setup.toml --input-volts 2.8284",
            "characterise --bench audio:setup.toml --out tf.json",
            "prepare S2.parquet S4.parquet S8.parquet S9.parquet --transfer tf.json --bench audio:setup.toml --mode texture --out drives",
        ] {
            run(&folder, line).expect_success();
        }
        folder
    })
}

/// A study in which P01 was measured, with the drives, and the sound device with `more` in its loop.
fn measured(more: &str) -> Folder {
    let folder = Folder::new();
    folder.write("protocol.toml", two_sets());
    folder.write("setup.toml", setup(more));
    copy(&prepared().path("drives"), &folder.path("drives"));
    let calibration = "setup.toml.calibration.json";
    std::fs::copy(prepared().path(calibration), folder.path(calibration)).unwrap();
    let line = "campaign new study --protocol protocol.toml --seed 7";
    run(&folder, line).expect_success();
    whole(&folder, "campaign run study P01 measurement");
    folder
}

const DISCRIMINATE: &str =
    "campaign run study P01 discrimination --drives drives --bench audio:setup.toml";

#[test]
fn a_session_runs_on_a_sound_device() {
    let folder = measured("");
    let seen = whole(&folder, DISCRIMINATE);
    let complete = "is complete: task1: 3 of 3 trials, task2: 2 of 2 trials, task3: 2 of 2 trials";
    holds(&seen, &["texture 1: force", complete]);
    run(&folder, "campaign export study --out exported").expect_success();
    let evidence = table(&folder.path("exported/evidence.csv"));
    assert!(!evidence.is_empty());
    for row in &evidence {
        assert_eq!(row["reached"], "met", "{row:?}");
        let level_db: f64 = row["level_re_target_db"].parse().unwrap();
        assert!(level_db.abs() < 1.0, "{row:?}");
        // Short strokes have no score.
        let score = row["score_jnd"].parse::<f64>();
        assert!(
            score.is_ok_and(|score| score < 1.0) || row["score_jnd"].is_empty(),
            "{row:?}"
        );
    }
}

#[test]
fn a_trial_with_an_interrupted_playing_is_void_and_repeated() {
    // In the first seconds, until the playings have begun.
    let faults: Vec<String> = (0..12)
        .map(|k| {
            format!(
                "{{ what = \"underrun\", at_s = {}, for_s = 0.05 }}",
                1.5 + 0.4 * f64::from(k)
            )
        })
        .collect();
    let folder = measured(&format!("faults = [{}]", faults.join(", ")));
    let seen = whole(&folder, DISCRIMINATE);
    let complete = "is complete: task1: 3 of 3 trials, task2: 2 of 2 trials, task3: 2 of 2 trials";
    holds(&seen, &["the playback was interrupted", complete]);
    run(&folder, "campaign export study --out exported").expect_success();
    let trials = table(&folder.path("exported/trials.csv"));
    assert!(trials.iter().any(|row| row["voided"] != "0"), "{trials:?}");
    // What the participant felt in attempts that count was whole.
    let evidence = table(&folder.path("exported/evidence.csv"));
    assert!(
        evidence.iter().all(|row| row["reached"] == "met"),
        "{evidence:?}"
    );
}
