//! Names and recordings that fit no data set, and people who withdrew.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use crate::bids::{exported, files};
use crate::campaign_session::{holds, run, whole};
use crate::support::copy;

#[test]
fn names_and_recordings_that_do_not_fit_are_refused_before_anything_is_written() {
    let folder = exported();
    // Pseudonyms that differ in signs alone.
    run(
        folder,
        "campaign new clash --protocol protocol.toml --seed 7",
    )
    .expect_success();
    for participant in ["P-01", "P01"] {
        whole(
            folder,
            &format!("campaign run clash {participant} measurement"),
        );
    }
    let refused = |line: &str, code: i32, parts: &[&str]| {
        run(folder, line).expect_failure(code, parts);
        assert!(!folder.path("refused").exists(), "{line}");
    };
    refused(
        "bids export clash --out refused",
        1,
        &[
            "expected participants that differ in letters and digits",
            "`P-01` and `P01`",
            "rename",
        ],
    );
    run(
        folder,
        "campaign new empty --protocol protocol.toml --seed 7",
    )
    .expect_success();
    refused(
        "bids export empty --out refused",
        1,
        &["expected a study with a session that counts, found none"],
    );
    run(
        folder,
        "twin record --bench acttouch --sample S2 --participant 9 --seed 7 --strokes 2 --stroke-time 1s --out P09.parquet",
    )
    .expect_success();
    refused(
        "bids export study --recordings P09.parquet --out refused",
        2,
        &["expected a recording of a participant of the study (P01, P02), found one of P09"],
    );
    run(
        folder,
        "twin record --bench acttouch --sample S7 --participant 1 --seed 7 --strokes 2 --stroke-time 1s --out S7.parquet",
    )
    .expect_success();
    std::fs::copy(folder.path("S2.parquet"), folder.path("again.parquet")).unwrap();
    refused(
        "bids export study --recordings S2.parquet again.parquet --out refused",
        2,
        &[
            "expected recordings that differ",
            "with the bytes of S2.parquet",
        ],
    );
    refused(
        "bids export study --recordings S7.parquet --out refused",
        2,
        &["expected a recording of a sample of the protocol (S2, S4, S8, S9), found one of S7"],
    );
    // Whoever withdrew is not there.
    copy(&folder.path("study"), &folder.path("fewer"));
    run(folder, "campaign withdraw fewer P01").expect_success();
    let done = run(folder, "bids export fewer --out left");
    done.expect_success();
    holds(
        &done.out(),
        &[
            "1 participant in 2 sessions",
            "2 sessions of participants who withdrew",
        ],
    );
    for path in files(&folder.path("left")) {
        assert!(
            !path.to_string_lossy().contains("P01"),
            "{}",
            path.display()
        );
        if let Ok(text) = std::fs::read_to_string(folder.path("left").join(&path)) {
            assert!(!text.contains("P01"), "{}", path.display());
        }
    }
}
