//! The clocks of channels in NI TDMS files: the unit of their step, and starts of another time.
#![allow(
    clippy::unwrap_used,
    reason = "a test that fails where it cannot go on"
)]

use crate::tdms::Holds::{Number, Text, Time};
use crate::tdms::{META, RAW, clocks, doubles, object, parse, said, samples_of, segment};

/// A step in ms, and a channel that begins 20 years after the others.
#[test]
fn the_unit_of_a_step_counts_and_a_start_of_another_time_is_said() {
    let of = |seconds: i64| {
        [
            ("wf_start_time", Time(seconds, 0)),
            ("wf_start_offset", Number(500.0)),
            ("wf_increment", Number(0.5)),
            ("wf_xunit_string", Text("ms")),
        ]
    };
    let at = 3_855_460_087;
    let read = |other: i64| {
        let objects = [
            object("/'a'/'x'", &samples_of(10, 2), &of(at)),
            object("/'a'/'y'", &samples_of(10, 2), &of(other)),
        ];
        let raw = doubles(&[1.0, 2.0, 3.0, 4.0]);
        parse(&segment(META | RAW, &objects, &raw), None).unwrap()
    };
    let together = read(at);
    assert_eq!(clocks(&together), [(2000.0, 0.0, 2); 2]);
    let started = together.annotations.started_at.as_ref();
    assert_eq!(started.unwrap().to_string(), "2026-03-04T09:08:07.5Z");
    assert!(!said(&together).contains("not recorded together"));
    let apart = read(at + 631_152_000);
    assert_eq!(clocks(&apart)[1], (2000.0, 631_152_000.0, 2));
    assert!(
        said(&apart).contains(
            "`y` begin 6.31e8 s after `x`, which lasts 0.00100 s: they were not recorded together"
        ),
        "{}",
        said(&apart)
    );
}

/// Modules of a chassis begin some hundredths of a sample apart: on one clock, and said.
#[test]
fn a_start_within_half_a_sample_is_said() {
    let read = |offset: f64| {
        let of = |offset| {
            [
                ("wf_start_offset", Number(offset)),
                ("wf_increment", Number(0.001)),
            ]
        };
        let objects = [
            object("/'a'/'x'", &samples_of(10, 2), &of(0.0)),
            object("/'a'/'y'", &samples_of(10, 2), &of(offset)),
        ];
        let raw = doubles(&[1.0, 2.0, 3.0, 4.0]);
        parse(&segment(META | RAW, &objects, &raw), None).unwrap()
    };
    for (offset, is_said) in [(4e-4, true), (-4e-4, true), (1e-6, false)] {
        let recording = read(offset);
        assert_eq!(recording.clocks().len(), 1);
        let text = format!(
            "taken at once with it: `y` by {:.3} samples later",
            1e3 * offset
        );
        assert_eq!(
            said(&recording).contains(&text),
            is_said,
            "{}",
            said(&recording)
        );
    }
    // Later than that it has its own start, and nothing relates the two sample by sample.
    let later = read(7e-4);
    let refused = later.require_one_clock(["x", "y"]).unwrap_err().to_string();
    let expected =
        "`y` at 1000 Hz from 0.0007 s on: they have one rate and begin at different times";
    assert!(refused.contains(expected), "{refused}");
}
