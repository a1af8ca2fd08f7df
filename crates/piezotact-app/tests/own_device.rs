//! An amplifier and an actuator of one's own, described in a file.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

mod support;

use serde_json::Value;
use support::{Done, Folder, noise, wav};

/// 10 V at most, at ×5 or ×20, behind a divider by two.
const OWN: &str = r#"
name = "own amplifier"
[amplifier]
[[amplifier.gains]]
name = "low"
gain = { ratio = 5 }
limit_v = 10
slew = { current_a = 0.05 }
[[amplifier.gains]]
name = "high"
gain = { ratio = 20 }
limit_v = 10
slew = { v_per_s = 1e6 }
[actuator]
capacitance_f = 120e-9
[input]
divider = 0.5
"#;

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("own.toml", OWN);
    folder.write("texture.wav", wav(noise(5_000), 5_000));
    let rows = noise(20_000).map(|v| format!("{},{}\n", 0.5 * v, 3.0 * v));
    folder.write(
        "bench.csv",
        format!("drive (V),nail (m/s2)\n{}", rows.collect::<String>()),
    );
    folder
}

fn run(folder: &Folder, line: &str) -> Done {
    folder.run(&line.split(' ').collect::<Vec<_>>())
}

fn close(found: &Value, expected: f64) {
    let found = found.as_f64().unwrap();
    assert!((found / expected - 1.0).abs() < 1e-12, "{found}");
}

const TRANSFER: &str = "transfer bench.csv --rate 5000 --drive drive --response nail --out tf.json --volts-per-full-scale 8";

#[test]
fn a_transfer_function_carries_the_device_that_was_described() {
    let folder = folder();
    let out = run(
        &folder,
        &format!("{TRANSFER} --device own.toml --gain high"),
    );
    out.expect_success();
    let drive = run(&folder, "info tf.json --json").json()["drive_setup"].clone();
    assert_eq!(drive["gain"], "high");
    assert_eq!(drive["device"]["name"], "own amplifier");
    close(&drive["load_f"], 120e-9);
    // 8 V behind the divider and ×20 are 80 V: the 10 V of the amplifier are reached at an eighth.
    let render = "render texture.wav --scale 0.001m/s2 --transfer tf.json --out drive.wav";
    let said = run(&folder, &format!("{render} --json")).json();
    close(&said["headroom"]["limit"], 0.125);
    assert_eq!(said["headroom"]["limited_by"], "the amplifier");
    // The gain is one of the device's, and the one that was measured with.
    run(&folder, &format!("{render} --gain high --device own.toml")).expect_success();
    run(&folder, &format!("{render} --gain low")).expect_failure(1, &["gain high", "low"]);
    run(&folder, &format!("{render} --gain B3"))
        .expect_failure(2, &["own amplifier (low or high)", "`B3`"]);
    run(&folder, &format!("{render} --device fixed"))
        .expect_failure(1, &["own amplifier at gain high", "voltage amplifier x20"]);
    // It is not played on a bench with another amplifier.
    let play = "play drive.wav --record felt.parquet --bench";
    run(&folder, &format!("{play} twin")).expect_failure(
        1,
        &[
            "own amplifier at gain high (×20.0, up to 10 V) behind a divider of 0.5",
            "DRV2667",
        ],
    );
    run(&folder, &format!("{play} measured:tf.json")).expect_success();
    let played = run(&folder, "info felt.parquet --json").json();
    assert_eq!(played["drive_setup"], drive);
}

#[test]
fn the_twin_has_the_device_that_is_described() {
    let folder = folder();
    let line = "characterise --bench twin:device=own.toml,gain=low --seconds 3 --gate off --out tf.json --json";
    let setup = run(&folder, line).json()["drive_setup"].clone();
    assert_eq!(setup["gain"], "low");
    close(&setup["load_f"], 120e-9);
    let fixed =
        "characterise --bench twin:device=fixed --seconds 3 --gate off --out tf2.json --json";
    let setup = run(&folder, fixed).json()["drive_setup"].clone();
    assert_eq!(setup["gain"], "x20");
    let wrong = "characterise --bench twin:device=own.toml,gain=B3 --out x.json";
    run(&folder, wrong).expect_failure(2, &["own amplifier (low or high)", "`B3`"]);
}

#[test]
fn what_no_device_can_be_is_refused() {
    let folder = folder();
    run(&folder, &format!("{TRANSFER} --device own.toml")).expect_failure(
        2,
        &["expected --gain", "own amplifier was set, low or high"],
    );
    run(&folder, TRANSFER).expect_failure(2, &["expected --gain", "B1, B2, B3 or B4"]);
    run(&folder, &format!("{TRANSFER} --gain B7")).expect_failure(2, &["`B7`", "DRV2667"]);
    run(&folder, &format!("{TRANSFER} --device none.toml"))
        .expect_failure(1, &["none.toml", "drv2667, fixed", "neither"]);
    run(&folder, &format!("{TRANSFER} --device fixed")).expect_success();
    for (from, to, part) in [
        ("\"low\"", "\"high\"", "found high twice"),
        ("120e-9", "-1e-9", "1e-12 to 1 F, found -0.000000001"),
        ("1e6", "0", "slew above 0 V/s, found 0"),
        ("divider", "diviser", "an entry called `diviser`"),
        (
            "120e-9",
            "120e-9\nlimit_v = 5",
            "at least the 10 V of gain low, the lowest, found a limit of 5 V",
        ),
    ] {
        folder.write("wrong.toml", OWN.replace(from, to));
        run(
            &folder,
            &format!("{TRANSFER} --device wrong.toml --gain high"),
        )
        .expect_failure(1, &["wrong.toml: expected", part]);
    }
}
