//! `render` in a closed loop and with its other inverses, as a black box.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

mod support;

use support::Folder;

const BENCH: &str = "twin:participant=2,seed=7";

fn ready() -> Folder {
    let folder = Folder::new();
    folder.run(&["demo", "--out", "d"]).expect_success();
    let characterise = [
        "characterise",
        "--bench",
        BENCH,
        "--seconds",
        "20",
        "--out",
        "tf.json",
    ];
    folder.run(&characterise).expect_success();
    folder
}

fn render(folder: &Folder, rest: &str) -> support::Done {
    let all: Vec<&str> = [
        "render",
        "d/target.wav",
        "--transfer",
        "tf.json",
        "--out",
        "drive.wav",
    ]
    .into_iter()
    .chain(rest.split(' '))
    .collect();
    folder.run(&all)
}

#[test]
fn a_drive_is_corrected_on_the_bench_and_verifies() {
    let folder = ready();
    for mode in ["replicate", "texture"] {
        let said = render(
            &folder,
            &format!("--level -3 --mode {mode} --bench {BENCH} --iterations 3 --json"),
        )
        .json();
        let each = said["loop"]["iterations"].as_array().unwrap();
        let best = said["loop"]["best"].as_u64().unwrap() as usize;
        let error = |i: usize| each[i]["error_db_rms"].as_f64().unwrap();
        assert!(
            error(best) <= error(0) && error(best) < 0.5,
            "{mode}: {said}"
        );
        assert!(said["gains"].as_array().unwrap().len() == 4, "{said}");
        folder
            .run(&[
                "play",
                "drive.wav",
                "--bench",
                BENCH,
                "--record",
                &format!("{mode}.parquet"),
            ])
            .expect_success();
        folder
            .run(&[
                "verify",
                "--target",
                "d/target.wav",
                "--measured",
                &format!("{mode}.parquet"),
            ])
            .expect_success();
    }
}

#[test]
fn what_does_not_fit_is_said_with_what_would() {
    let folder = ready();
    let parts = ["lower the target by", "--level", "--inverse drive-limited"];
    render(&folder, "--level 12").expect_failure(1, &parts);
    render(
        &folder,
        &format!("--level 12 --mode texture --bench {BENCH}"),
    )
    .expect_failure(1, &parts);
    let said = render(&folder, "--level 12 --inverse drive-limited --json").json();
    let headroom = &said["headroom"];
    assert!(
        headroom["peak"].as_f64().unwrap() <= headroom["limit"].as_f64().unwrap(),
        "{said}"
    );
    assert!(!said["given_up_band_hz"].as_array().unwrap().is_empty());
    for inverse in ["plain", "constant", "coherence"] {
        let said = render(&folder, &format!("--inverse {inverse} --json")).json();
        assert!(
            said["headroom"]["clipped_fraction"].as_f64().unwrap() == 0.0,
            "{said}"
        );
    }
    // The spectrum alone is meant, and the verdict says so.
    render(&folder, "--phase minimum").expect_success();
    folder
        .run(&[
            "play",
            "drive.wav",
            "--bench",
            BENCH,
            "--record",
            "minimum.parquet",
        ])
        .expect_success();
    let done = folder.run(&[
        "verify",
        "--target",
        "d/target.wav",
        "--measured",
        "minimum.parquet",
        "--json",
    ]);
    let (said, code) = done.json_and_code();
    assert!(
        said["error_db_rms"].as_f64().unwrap() < 1.0
            && code == Some(0)
            && said["verdict"]
                .as_str()
                .unwrap()
                .contains("the spectrum alone"),
        "{code:?} {}",
        said["verdict"]
    );
}

#[test]
fn a_loop_needs_a_bench_and_says_whose_finger_it_is() {
    let folder = ready();
    render(&folder, "--mode texture").expect_failure(2, &["--bench"]);
    render(&folder, &format!("--bench {BENCH}")).expect_failure(2, &["--mode"]);
    render(
        &folder,
        &format!("--mode texture --bench {BENCH} --iterations 0"),
    )
    .expect_failure(2, &["--iterations"]);
    let done = render(
        &folder,
        "--level -3 --mode texture --bench twin:participant=4,seed=7 --iterations 1",
    );
    done.expect_success();
    assert!(
        done.err().contains("P02") && done.err().contains("P04"),
        "{}",
        done.err()
    );
}
