//! An amplifier and an actuator of one's own, described in a file.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use crate::support::{Done, Folder, noise, wav};
use serde_json::Value;

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
        ("120e-9", "-1e-9", "1e-12 to 1 F, found -1e-9"),
        ("1e6", "0", "slew above 0 V/s, found 0"),
        ("divider", "diviser", "an entry called `diviser`"),
        (
            "120e-9",
            "120e-9\nlimit_v = 5",
            "at least 10 V, which its lowest gain low can give, found a limit of 5 V",
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

/// The samples of a WAV file of 32-bit floats.
fn samples(folder: &Folder, name: &str) -> Vec<f32> {
    let bytes = std::fs::read(folder.path(name)).unwrap();
    let data = bytes.windows(4).position(|four| four == b"data").unwrap();
    let four = bytes[data + 8..].chunks_exact(4);
    four.map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
        .collect()
}

/// What is cut is cut where the device ends, far below the digital full scale, and said.
#[test]
fn allowed_clipping_cuts_at_the_limit_of_the_device() {
    let folder = folder();
    let transfer = TRANSFER.replace("full-scale 8", "full-scale 7");
    run(
        &folder,
        &format!("{transfer} --device own.toml --gain high"),
    )
    .expect_success();
    let render = "render texture.wav --scale 60m/s2 --transfer tf.json --out drive.wav";
    let said = run(&folder, &format!("{render} --allow-clipping --json")).json();
    let limit = said["headroom"]["limit"].as_f64().unwrap();
    close(&said["headroom"]["limit"], 1.0 / 7.0);
    assert!(said["headroom"]["peak"].as_f64().unwrap() > 1.5 * limit);
    let drive = samples(&folder, "drive.wav");
    let highest = drive.iter().fold(0.0f32, |most, v| most.max(v.abs()));
    assert!(f64::from(highest) <= limit && f64::from(highest) > 0.999_999 * limit);
    let cut = drive.iter().filter(|v| v.abs() >= highest).count();
    let share = cut as f64 / drive.len() as f64;
    assert!(share > 0.001);
    close(&said["headroom"]["clipped_fraction"], share);
    let sidecar: Value =
        serde_json::from_slice(&std::fs::read(folder.path("drive.wav.json")).unwrap()).unwrap();
    let warnings = sidecar["rendering"]["warnings"].as_array().unwrap();
    let warning = warnings
        .iter()
        .find(|d| d["code"] == "clipped" && d["at"] == "rendered");
    let text = warning.unwrap().to_string();
    assert!(text.contains("the amplifier"), "{text}");
    let told = run(&folder, &format!("{render} --allow-clipping")).err();
    assert!(
        told.contains("were clipped at the limit of the amplifier"),
        "{told}"
    );
}

/// `--level fit` and `drive-limited` keep to the slope that the amplifier follows, in texture mode too; a stated level that is
/// too steep is refused, and where it is allowed a warning says so when it is rendered and when it is played.
#[test]
fn what_fits_is_no_steeper_than_the_amplifier_follows() {
    let folder = folder();
    folder.write("own.toml", OWN.replace("v_per_s = 1e6", "v_per_s = 3000"));
    run(
        &folder,
        &format!("{TRANSFER} --device own.toml --gain high"),
    )
    .expect_success();
    let codes = |said: &Value| said["warnings"].to_string();
    let render = "render texture.wav --scale 1m/s2 --transfer tf.json --out drive.wav --json";
    let slope = [
        "slew rate",
        "3.000e3 V/s",
        "--level",
        "fits",
        "--allow-clipping",
    ];
    run(&folder, render).expect_failure(1, &slope);
    assert!(!folder.path("drive.wav").exists());
    let steep = run(&folder, &format!("{render} --allow-clipping")).json();
    let asked = steep["headroom"]["slope_v_per_s"].as_f64().unwrap();
    let beyond = steep["headroom"]["headroom_db"].as_f64().unwrap();
    assert!(asked > 4000.0, "{asked} V/s");
    assert!(
        (beyond - 20.0 * (3000.0 / asked).log10()).abs() < 0.01,
        "{beyond} dB"
    );
    assert!(codes(&steep).contains("slew_limited"));
    let played = run(
        &folder,
        "play drive.wav --bench measured:tf.json --record felt.parquet --json",
    );
    assert!(codes(&played.json()).contains("slew_limited"));
    for more in [
        "--level fit",
        "--inverse drive-limited",
        "--level fit --mode texture --bench measured:tf.json --iterations 1",
        "--inverse drive-limited --mode texture --bench measured:tf.json --iterations 1",
    ] {
        let said = run(&folder, &format!("{render} {more}")).json();
        let slope = said["headroom"]["slope_v_per_s"].as_f64().unwrap();
        assert!(slope <= 3000.0 && slope > 2000.0, "{more}: {slope}");
        assert!(!codes(&said).contains("slew_limited"), "{more}");
        let turned_down = codes(&said).contains("turned_down");
        assert_eq!(turned_down, more.contains("drive-limited"), "{more}");
        let level = said["level_db"].as_f64().unwrap();
        assert_eq!(level < -1.0, more.contains("fit"), "{more}: {level}");
    }
}

/// A recording that states its device is not described otherwise, and the band that it states is the one that was excited.
#[test]
fn a_recording_keeps_the_device_and_the_band_that_it_states() {
    let folder = folder();
    let line = "characterise --bench twin:participant=2,seed=7 --seconds 6 --out tf.json --record raw.parquet --json";
    let said = run(&folder, line).json();
    let transfer =
        "transfer raw.parquet --drive drive --response acceleration --out again.json --json";
    let again = run(&folder, transfer).json();
    assert_eq!(again["excited_hz"], said["excited_hz"]);
    assert_eq!(again["excited_hz"], serde_json::json!([2.0, 1200.0]));
    assert!(
        !again["warnings"].to_string().contains("not_excited"),
        "{again}"
    );
    let same = "--gain B3 --volts-per-full-scale 1.41421356";
    run(&folder, &format!("{transfer} {same}")).expect_success();
    let setup =
        |name: &str| run(&folder, &format!("info {name} --json")).json()["drive_setup"].clone();
    assert_eq!(setup("again.json"), setup("raw.parquet"));
    for (other, named) in [
        ("--gain B4 --volts-per-full-scale 0.5", "gain B4"),
        ("--gain B3 --volts-per-full-scale 0.5", "0.5000 V"),
        (
            "--gain B3 --volts-per-full-scale 1.41421356 --load-nf 90",
            "90.0000 nF",
        ),
        (
            "--device fixed --volts-per-full-scale 1.41421356",
            "gain x20",
        ),
    ] {
        run(&folder, &format!("{transfer} {other}")).expect_failure(
            1,
            &[
                "raw.parquet",
                "recording states",
                "gain B3",
                "1.4142 V",
                named,
            ],
        );
    }
}

/// A voice coil is described without a capacitance or a slew; its rms current refuses a drive, and HJIF names its kind.
#[test]
fn a_voice_coil_is_rendered_for_and_exported() {
    let folder = folder();
    let coil = "name = \"coil amplifier\"\n[amplifier]\n[[amplifier.gains]]\nname = \"x1\"\ngain = { ratio = 1 }\nlimit_v = 8\n\
                [actuator]\nkind = \"voice_coil\"\nresistance_ohm = 8\nlimit_current_rms_a = 0.5\n";
    folder.write("coil.toml", coil);
    let transfer = "transfer bench.csv --rate 5000 --drive drive --response nail --out tf.json --volts-per-full-scale 8 --device coil.toml";
    run(&folder, transfer).expect_success();
    let info = run(&folder, "info tf.json");
    info.expect_success();
    let render = "render texture.wav --scale 1m/s2 --transfer tf.json --out drive.wav";
    run(&folder, render).expect_success();
    run(&folder, "export drive.wav --out drive.hjif").expect_success();
    let hjif: Value =
        serde_json::from_slice(&std::fs::read(folder.path("drive.hjif")).unwrap()).unwrap();
    assert!(hjif.to_string().contains("\"VCA\""), "{hjif}");
    folder.write("coil.toml", coil.replace("0.5", "0.001"));
    run(&folder, transfer).expect_success();
    let refused = run(&folder, &render.replace("drive.wav", "other.wav"));
    refused.expect_failure(1, &["rms current", "0.001 A", "--level", "fits"]);
}
