//! Doubts as values: their written form, and those of a version that is not there yet.
#![allow(
    clippy::unwrap_used,
    reason = "a test that fails where it cannot go on"
)]

use piezotact::Doubt;
use piezotact::doubt::{About, Advice, Doubts, Example, Subject, Value};
use piezotact::integrity::SignalDoubt;
use piezotact::panel::PanelDoubt;
use piezotact::quantity::{Band, Hertz};
use piezotact::recording::RecordingDoubt;
use piezotact::render::RenderDoubt;
use piezotact::run::{Ended, RunDoubt};
use piezotact::transfer::TransferDoubt;
use piezotact::verify::VerifyDoubt;
use piezotact::wording;
use serde_json::json;

fn band(low: f64, high: f64) -> Band {
    Band::new(Hertz(low), Hertz(high)).unwrap()
}

fn read(text: &str) -> Doubt {
    serde_json::from_str(text).unwrap()
}

/// `doubt` written and read again.
fn again(doubt: &Doubt) -> Doubt {
    read(&serde_json::to_string(doubt).unwrap())
}

#[test]
fn a_doubt_is_a_code_with_values_and_advice() {
    let doubt = Doubt::from(RunDoubt::ForceNotMeasured { load_n: 0.3 });
    assert_eq!(
        serde_json::to_value(&doubt).unwrap(),
        json!({
            "code": "force_not_measured",
            "values": { "load_n": 0.3 },
            "advice": ["measure_force"]
        })
    );
    let doubt = Doubt::from(RenderDoubt::TurnedDown {
        bands: vec![band(20.0, 97.5)],
        share: 0.1,
        fits_at_db: -3.5,
    });
    assert_eq!(
        serde_json::to_value(&doubt).unwrap(),
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
    let doubt = Doubt::from(RecordingDoubt::Uncalibrated {
        channel: "nail".into(),
    });
    assert_eq!(
        serde_json::to_value(&doubt).unwrap(),
        json!({
            "code": "uncalibrated",
            "about": { "channel": "nail" },
            "advice": ["state_scale"]
        })
    );
}

/// All field types, written and read again, are the doubt that they were, and have the same text.
#[test]
fn what_is_written_is_read_again() {
    let member = TransferDoubt::LowCoherence {
        asked: 0.9,
        lowest: 0.421_356_789_012_345_6,
        at_hz: 100.0 / 3.0,
        share: 0.2,
    };
    let doubts: [Doubt; 9] = [
        member.clone().into(),
        PanelDoubt::OfMembers {
            count: 3,
            of: 9,
            measurement: Example("b, 0.2 N".into()),
            example: member.into(),
        }
        .into(),
        PanelDoubt::Averaged {
            participants: 5,
            penalty_db_rms: 4.0,
            interval_db_rms: Some([3.0, 5.5]),
            worst: "c".into(),
            worst_db_rms: 7.0,
        }
        .into(),
        RunDoubt::JournalDamaged {
            places: 2,
            lost_s: vec![[0.5, 1.25], [3.0, 4.0]],
        }
        .into(),
        RunDoubt::EndedEarly {
            ended: Ended::Failed {
                said: "no device".into(),
            },
            after_s: 2.0,
        }
        .into(),
        SignalDoubt::MainsHum {
            channel: "nail".into(),
            mains_hz: 50.01,
            harmonics: vec![1, 3],
            share: 0.2,
            above_db: 31.0,
        }
        .into(),
        VerifyDoubt::PartJudged {
            share: 0.5,
            judged: Vec::new(),
            band: band(20.0, 500.0),
        }
        .into(),
        VerifyDoubt::CopyOfTarget.into(),
        TransferDoubt::Unrelated {
            coherence: f64::NAN,
            limit: 0.1,
            averages: 10.0,
        }
        .into(),
    ];
    for doubt in &doubts[..8] {
        assert_eq!(&again(doubt), doubt);
    }
    for doubt in &doubts {
        let text = doubt.to_string();
        assert_eq!(again(doubt).to_string(), text);
        assert!(!text.contains("another version"), "{text}");
        assert!(!text.contains("--"), "{text}");
    }
    let mut often = doubts[0].clone();
    often.seen = 20;
    assert_eq!(again(&often), often);
    assert!(often.is_equivalent_to(&doubts[0]));
}

/// A tag and its fields, as doubts were once written, are refused, and not half read.
#[test]
fn an_earlier_form_is_refused() {
    let text = r#"{"doubt": "force_not_measured", "load_n": 0.3}"#;
    let said = serde_json::from_str::<Doubt>(text).unwrap_err().to_string();
    assert!(said.contains("make the file again"), "{said}");
    assert!(serde_json::from_str::<Doubt>(r#"{"share": 0.1}"#).is_err());
}

/// What a newer version writes is kept and written again as it was, and is readable.
#[test]
fn a_doubt_of_a_newer_version_is_kept() {
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
    let doubt: Doubt = serde_json::from_value(written.clone()).unwrap();
    assert_eq!(serde_json::to_value(&doubt).unwrap(), written);
    assert_eq!(doubt.advice[2], Advice::MeasureAgain);
    assert!(matches!(doubt.about, Some(About::Other(_))));
    assert_eq!(doubt.values["skin_c"], Value::Number(17.5));
    let text = doubt.to_string();
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
    assert_eq!(changed.kind::<RunDoubt>(), None);
    assert!(changed.to_string().contains("load_mn = 300"), "{changed}");
    assert_eq!(again(&changed), changed);
}

#[test]
fn doubts_are_held_once() {
    let outside = |share| RenderDoubt::PowerOutsideBand {
        share,
        band: band(20.0, 500.0),
    };
    let mut doubts = Doubts::new();
    doubts.push(outside(0.2));
    doubts.extend([outside(0.2), outside(0.4)]);
    doubts.push(VerifyDoubt::CopyOfTarget);
    assert_eq!(doubts.len(), 3);
    doubts.put_first([RunDoubt::ForceNotMeasured { load_n: 0.3 }.into()]);
    assert_eq!(doubts[0].code, "force_not_measured");
    let merged = doubts.merged();
    assert_eq!(merged.len(), 3);
    assert_eq!(merged[1].doubt.seen, 2);
    assert_eq!(
        (merged[1].ranges[0].low, merged[1].ranges[0].high),
        (0.2, 0.4)
    );
    let written = serde_json::to_string(&doubts).unwrap();
    assert_eq!(serde_json::from_str::<Doubts>(&written).unwrap(), doubts);
}

#[test]
fn a_front_end_words_advice_its_own_way() {
    let doubt = Doubt::from(TransferDoubt::Acausal {
        lead_s: 0.01,
        reach_s: 0.001,
    });
    assert_eq!(doubt.advice, [Advice::Check(Subject::Channels)]);
    let button = |_: &Advice| "[check]".to_owned();
    let text = wording::text_with(&doubt, &button);
    assert!(text.ends_with("out of step; [check]"), "{text}");
}

/// A cause is a value within the doubt, or a sentence, which is read, said and written unchanged.
#[test]
fn causes_are_values_or_sentences() {
    use piezotact::correct::{LoopDoubt, LoopStop, MeasurementFaultDoubt};
    let stopped = |why| Doubt::from(LoopDoubt::LoopStopped { best: 2, why });
    let cause = MeasurementFaultDoubt::SensorClips { fraction: 0.02 }.into();
    let doubt = stopped(LoopStop::NotBelieved { cause });
    let json = serde_json::to_value(&doubt).unwrap();
    let why = &json["values"]["why"];
    assert_eq!(why["code"], "not_believed", "{json}");
    assert_eq!(why["values"]["cause"]["code"], "sensor_clips", "{json}");
    let read: Doubt = serde_json::from_value(json).unwrap();
    assert_eq!(read.kind::<LoopDoubt>(), doubt.kind());
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
    let read: Doubt = serde_json::from_value(sentence.clone()).unwrap();
    assert!(
        read.to_string().contains("ended early (it was dark)"),
        "{read}"
    );
    let again = serde_json::to_value(&read).unwrap();
    assert_eq!(again["values"], sentence["values"]);
    // Two causes are two things to know.
    let both = [read, stopped(LoopStop::GotWorse)];
    assert_eq!(piezotact::doubt::merged(&both).len(), 2);
}
