//! Warnings as values: their written form, and those of a version that is not there yet.
#![allow(
    clippy::unwrap_used,
    reason = "a test that fails where it cannot go on"
)]

use piezotact::Warning;
use piezotact::integrity::SignalWarning;
use piezotact::panel::PanelWarning;
use piezotact::quantity::{Band, Hertz};
use piezotact::recording::RecordingWarning;
use piezotact::render::RenderWarning;
use piezotact::run::{Ended, RunWarning};
use piezotact::transfer::TransferWarning;
use piezotact::verify::VerifyWarning;
use piezotact::warning::{About, Advice, Example, Subject, Value, Warnings};
use piezotact::wording;
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
fn a_warning_is_a_code_with_values_and_advice() {
    let warning = Warning::from(RunWarning::ForceNotMeasured { load_n: 0.3 });
    assert_eq!(
        serde_json::to_value(&warning).unwrap(),
        json!({
            "code": "force_not_measured",
            "values": { "load_n": 0.3 },
            "advice": ["measure_force"]
        })
    );
    let warning = Warning::from(RenderWarning::TurnedDown {
        bands: vec![band(20.0, 97.5)],
        share: 0.1,
        fits_at_db: -3.5,
    });
    assert_eq!(
        serde_json::to_value(&warning).unwrap(),
        json!({
            "code": "turned_down",
            "values": {
                "bands": [{ "low_hz": 20, "high_hz": 97.5 }],
                "share": 0.1,
                "fits_at_db": -3.5
            },
            "advice": [{ "lower_level": { "to_db": -3.5 } }]
        })
    );
    let warning = Warning::from(RecordingWarning::Uncalibrated {
        channel: "nail".into(),
    });
    assert_eq!(
        serde_json::to_value(&warning).unwrap(),
        json!({
            "code": "uncalibrated",
            "about": { "channel": "nail" },
            "advice": ["state_scale"]
        })
    );
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
            measurement: Example("b, 0.2 N".into()),
            example: member.into(),
        }
        .into(),
        PanelWarning::Averaged {
            participants: 5,
            penalty_db_rms: 4.0,
            interval_db_rms: Some([3.0, 5.5]),
            worst: "c".into(),
            worst_db_rms: 7.0,
        }
        .into(),
        RunWarning::JournalDamaged {
            places: 2,
            lost_s: vec![[0.5, 1.25], [3.0, 4.0]],
        }
        .into(),
        RunWarning::EndedEarly {
            ended: Ended::Failed {
                said: "no device".into(),
            },
            after_s: 2.0,
        }
        .into(),
        SignalWarning::MainsHum {
            channel: "nail".into(),
            mains_hz: 50.01,
            harmonics: vec![1, 3],
            share: 0.2,
            above_db: 31.0,
        }
        .into(),
        VerifyWarning::PartJudged {
            share: 0.5,
            judged: Vec::new(),
            band: band(20.0, 500.0),
        }
        .into(),
        VerifyWarning::CopyOfTarget.into(),
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

/// A tag and its fields, as warnings were once written, are refused, and not half read.
#[test]
fn an_earlier_form_is_refused() {
    let text = r#"{"warning": "force_not_measured", "load_n": 0.3}"#;
    let said = serde_json::from_str::<Warning>(text)
        .unwrap_err()
        .to_string();
    assert!(said.contains("make the file again"), "{said}");
    assert!(serde_json::from_str::<Warning>(r#"{"share": 0.1}"#).is_err());
}

/// What a newer version writes is kept and written again as it was, and is readable.
#[test]
fn a_warning_of_a_newer_version_is_kept() {
    let written = json!({
        "code": "finger_too_cold",
        "about": { "phalanx": 3 },
        "values": {
            "skin_c": 17.5,
            "limit_c": 25,
            "at": { "example": "index" },
            "band": { "low_hz": 20, "high_hz": 90.5 },
            "site": { "side": "left", "dry": true },
            "flags": [true, null, "x"]
        },
        "seen": 4,
        "advice": ["warm_up", { "wait": { "for_s": 60 } }, "measure_again"]
    });
    let warning: Warning = serde_json::from_value(written.clone()).unwrap();
    assert_eq!(serde_json::to_value(&warning).unwrap(), written);
    assert_eq!(warning.advice[2], Advice::MeasureAgain);
    assert!(matches!(warning.about, Some(About::Other(_))));
    assert_eq!(warning.values["skin_c"], Value::Number(17.5));
    let text = warning.to_string();
    for part in [
        "another version",
        "finger_too_cold",
        "skin_c = 17.5",
        "measure again",
        "warm_up",
    ] {
        assert!(text.contains(part), "{text}");
    }
    // A known code whose fields are not those of today is no kind of today.
    let changed = read(r#"{"code": "force_not_measured", "values": {"load_mn": 300}}"#);
    assert_eq!(changed.kind::<RunWarning>(), None);
    assert!(changed.to_string().contains("load_mn = 300"), "{changed}");
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
    warnings.push(VerifyWarning::CopyOfTarget);
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
    let written = serde_json::to_string(&warnings).unwrap();
    assert_eq!(
        serde_json::from_str::<Warnings>(&written).unwrap(),
        warnings
    );
}

#[test]
fn a_front_end_words_advice_its_own_way() {
    let warning = Warning::from(TransferWarning::Acausal {
        lead_s: 0.01,
        reach_s: 0.001,
    });
    assert_eq!(warning.advice, [Advice::Check(Subject::Channels)]);
    let button = |_: &Advice| "[check]".to_owned();
    let text = wording::text_with(&warning, &button);
    assert!(text.ends_with("out of step; [check]"), "{text}");
}

/// A cause is a value within the warning, or a sentence, which is read, said and written unchanged.
#[test]
fn causes_are_values_or_sentences() {
    use piezotact::correct::{LoopStop, LoopWarning, MeasurementFaultWarning};
    let stopped = |why| Warning::from(LoopWarning::LoopStopped { best: 2, why });
    let cause = MeasurementFaultWarning::SensorClips { fraction: 0.02 }.into();
    let warning = stopped(LoopStop::NotBelieved { cause });
    let json = serde_json::to_value(&warning).unwrap();
    let why = &json["values"]["why"];
    assert_eq!(why["code"], "not_believed", "{json}");
    assert_eq!(why["values"]["cause"]["code"], "sensor_clips", "{json}");
    let read: Warning = serde_json::from_value(json).unwrap();
    assert_eq!(read.kind::<LoopWarning>(), warning.kind());
    let said = read.to_string();
    assert!(
        said.contains(
            "a measurement was invalid: 2.0 % of the samples of the response are at a limit"
        ),
        "{said}"
    );
    let sentence = serde_json::json!({
        "code": "loop_stopped", "values": { "best": 2, "why": "it was dark" },
    });
    let read: Warning = serde_json::from_value(sentence.clone()).unwrap();
    assert!(
        read.to_string().contains("ended early (it was dark)"),
        "{read}"
    );
    let again = serde_json::to_value(&read).unwrap();
    assert_eq!(again["values"], sentence["values"]);
    // Two causes are two things to know.
    let both = [read, stopped(LoopStop::GotWorse)];
    assert_eq!(piezotact::warning::merged(&both).len(), 2);
}
