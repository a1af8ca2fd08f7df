//! Warnings as values: their written form, and those of a version that is not there yet.
#![allow(
    clippy::unwrap_used,
    reason = "a test that fails where it cannot go on"
)]

use piezotact::Warning;
use piezotact::integrity::{ChannelFault, SignalWarning};
use piezotact::panel::PanelWarning;
use piezotact::quantity::{Band, Hertz};
use piezotact::recording::{LostBy, RecordingWarning};
use piezotact::render::RenderWarning;
use piezotact::run::{Ended, RunWarning};
use piezotact::transfer::TransferWarning;
use piezotact::verify::VerifyWarning;
use piezotact::warning::{Example, Warnings};
use serde_json::json;

fn band(low: f64, high: f64) -> Band {
    Band::new(Hertz(low), Hertz(high)).unwrap()
}

fn read(text: &str) -> Warning {
    serde_json::from_str(text).unwrap()
}

/// `warning` written and read again.
fn again(warning: &Warning) -> Warning {
    read(&serde_json::to_string(warning).unwrap())
}

#[test]
fn warning_is_written_as_code_fields_and_sentence() {
    let warning = Warning::from(RunWarning::ForceNotMeasured { load_n: 0.3 });
    assert_eq!(
        serde_json::to_value(&warning).unwrap(),
        json!({
            "code": "force_not_measured",
            "load_n": 0.3,
            "text": "no force was measured: it is not known whether 0.3 N was held; measure the force together with the acceleration",
            "seen": 1
        })
    );
    let warning = Warning::from(RenderWarning::PowerOutsideBand {
        share: 0.1,
        band: band(20.0, 97.5),
    });
    let written = serde_json::to_value(&warning).unwrap();
    assert_eq!(written["band"], json!([20.0, 97.5]));
    assert_eq!(warning.to_string(), written["text"].as_str().unwrap());
}

/// All field types, written and read again, are the warning that they were, and have the same text.
#[test]
fn what_is_written_is_read_again() {
    let member = TransferWarning::LowCoherence {
        asked: 0.9,
        lowest: 0.421_356_789_012_345_6,
        at_hz: 100.0 / 3.0,
        share: 0.2,
    };
    let warnings: [Warning; 9] = [
        member.clone().into(),
        PanelWarning::OfMembers {
            count: 3,
            of: 9,
            measurement: Example::from("b, 0.2 N".to_owned()),
            example: member.into(),
        }
        .into(),
        PanelWarning::Averaged {
            participants: 5,
            penalty_db_rms: 4.0,
            new_person_db_rms: Some([3.0, 5.5]),
            worst: "c".into(),
            worst_db_rms: 7.0,
        }
        .into(),
        RecordingWarning::SamplesLost {
            by: LostBy::Journal {
                places: 2,
                lost_s: vec![[0.5, 1.25], [3.0, 4.0]],
            },
        }
        .into(),
        RunWarning::EndedEarly {
            ended: Ended::Failed {
                said: "no device".into(),
            },
            after_s: 2.0,
        }
        .into(),
        SignalWarning::Channel {
            channel: "nail".into(),
            fault: ChannelFault::MainsHum {
                mains_hz: 50.01,
                harmonics: vec![1, 3],
                share: 0.2,
                above_db: 31.0,
            },
        }
        .into(),
        RenderWarning::PowerOutsideBand {
            share: 0.5,
            band: band(20.0, 500.0),
        }
        .into(),
        VerifyWarning::Cut {
            compared_s: 1.5,
            target_s: 2.0,
        }
        .into(),
        TransferWarning::Unrelated {
            coherence: f64::NAN,
            limit: 0.1,
            averages: 10.0,
        }
        .into(),
    ];
    for warning in &warnings[..8] {
        assert_eq!(&again(warning), warning);
    }
    for warning in &warnings {
        let text = warning.to_string();
        assert_eq!(again(warning).to_string(), text);
        assert!(!text.contains("another version"), "{text}");
        assert!(!text.contains("--"), "{text}");
    }
    let mut often = warnings[0].clone();
    often.seen = 20;
    assert_eq!(again(&often), often);
    assert!(often.is_equivalent_to(&warnings[0]));
}

/// Earlier forms are refused, and not half read.
#[test]
fn earlier_forms_are_refused() {
    for text in [
        r#"{"warning": "force_not_measured", "load_n": 0.3}"#,
        r#"{"code": "force_not_measured", "values": {"load_n": 0.3}, "advice": ["measure_force"]}"#,
        r#"{"share": 0.1}"#,
        // What a recording lacks, before it said so in its losses.
        r#"{"code": "samples_lost", "gaps": 1, "samples": 25, "text": "the device lost samples", "seen": 1}"#,
        r#"{"code": "playback_incomplete", "underruns": 1, "text": "not played whole", "seen": 1}"#,
    ] {
        let said = serde_json::from_str::<Warning>(text).unwrap_err();
        assert!(said.to_string().contains("make the file again"), "{said}");
    }
}

/// What a newer version writes is kept and written again as it was, with its sentence.
#[test]
fn warning_of_a_newer_version_is_kept() {
    let written = json!({
        "code": "finger_too_cold",
        "skin_c": 17.5,
        "at": { "example": "index" },
        "flags": [true, null, "x"],
        "text": "the finger is too cold: warm it up",
        "seen": 4
    });
    let warning: Warning = serde_json::from_value(written.clone()).unwrap();
    assert_eq!(serde_json::to_value(&warning).unwrap(), written);
    assert_eq!(warning.to_string(), "the finger is too cold: warm it up");
    // A known code whose fields are not those of today is no variant of today.
    let changed = read(r#"{"code": "force_not_measured", "load_mn": 300, "text": "no force"}"#);
    assert_eq!(changed.kind::<RunWarning>(), None);
    assert_eq!(again(&changed), changed);
}

#[test]
fn warnings_are_held_once() {
    let outside = |share| RenderWarning::PowerOutsideBand {
        share,
        band: band(20.0, 500.0),
    };
    let mut warnings = Warnings::new();
    warnings.push(outside(0.2));
    warnings.extend([outside(0.2), outside(0.4)]);
    warnings.push(VerifyWarning::Cut {
        compared_s: 1.5,
        target_s: 2.0,
    });
    assert_eq!(warnings.len(), 3);
    warnings.put_first([RunWarning::ForceNotMeasured { load_n: 0.3 }.into()]);
    assert_eq!(warnings[0].code, "force_not_measured");
    let merged = warnings.merged();
    assert_eq!(merged.len(), 3);
    assert_eq!(merged[1].warning.seen, 2);
    assert_eq!(
        (merged[1].ranges[0].low, merged[1].ranges[0].high),
        (0.2, 0.4)
    );
    // Written as merged, and what is read of that is written again unchanged.
    let written = serde_json::to_value(&warnings).unwrap();
    assert_eq!(written, serde_json::to_value(&merged).unwrap());
    let read: Warnings = serde_json::from_value(written.clone()).unwrap();
    assert_eq!(serde_json::to_value(&read).unwrap(), written);
}

/// A cause is a warning within the warning, and is written with its own code and sentence.
#[test]
fn cause_is_written_within_the_warning() {
    use piezotact::correct::{LoopStop, LoopWarning, MeasurementFault, MeasurementFaultWarning};
    let cause = MeasurementFaultWarning::Failed {
        fault: MeasurementFault::SensorClips { fraction: 0.02 },
    }
    .into();
    let why = LoopStop::NotBelieved { cause };
    let warning = Warning::from(LoopWarning::LoopStopped { best: 2, why });
    let json = serde_json::to_value(&warning).unwrap();
    let why = &json["why"];
    assert_eq!(why["code"], "not_believed", "{json}");
    assert_eq!(why["cause"]["code"], "measurement_failed", "{json}");
    assert_eq!(why["cause"]["fault"], "sensor_clips", "{json}");
    let read: Warning = serde_json::from_value(json).unwrap();
    assert_eq!(read.kind::<LoopWarning>(), warning.kind());
    let said = read.to_string();
    assert!(
        said.contains(
            "a measurement was invalid: 2.0 % of the samples of the response are at a limit"
        ),
        "{said}"
    );
}
