//! Units of separate vectors of MATLAB files, in lists and structures beside them.
#![allow(
    clippy::unwrap_used,
    reason = "a test that fails where it cannot go on"
)]

use crate::matlab_recordings::{cells, column, read, says, structures, text};
use piezotact::quantity::Unit;
use piezotact::recording::Recording;

/// The first sample of each channel, in SI, with its unit.
fn firsts(recording: &Recording) -> Vec<(&str, f64, &Unit)> {
    let channels = recording.channels().iter();
    channels
        .map(|channel| (channel.name.as_str(), channel.samples[0], &channel.unit))
        .collect()
}

const MN: (f64, Unit) = (1e-3, Unit::Newton);
const N: (f64, Unit) = (1.0, Unit::Newton);
const ACC: (f64, Unit) = (1.0, Unit::MetrePerSecondSquared);

fn list(units: &[&str]) -> Vec<u8> {
    let units: Vec<Vec<u8>> = units.iter().map(|unit| text("", unit)).collect();
    cells("units", &units)
}

fn vectors() -> Vec<Vec<u8>> {
    vec![column("", &[1.0, 2.0]); 3]
}

#[test]
fn a_list_holds_for_the_fields_in_their_order() {
    let fields = ["ft", "fn", "acc", "units", "fs"];
    let rate = column("", &[10.0]);
    let units = |units: &[&str]| list(units);
    let run = |units: Vec<u8>| [vectors(), vec![units, rate.clone()]].concat();
    let recording = read(&[structures(
        "run",
        &fields,
        &[run(units(&["mN", "N", "m/s2"]))],
    )])
    .unwrap();
    let expected = [("run.ft", &MN), ("run.fn", &N), ("run.acc", &ACC)];
    let expected = expected.map(|(name, (first, unit))| (name, *first, unit));
    assert_eq!(firsts(&recording), expected);
    assert!(says(
        &recording,
        "order of the fields: `run.ft` in mN, `run.fn` in N, `run.acc` in m/s2"
    ));
    // A list among the variables of the file, and a time that it counts.
    let timed = ["t", "ft", "fn", "acc"];
    let times = [vec![column("", &[0.0, 100.0])], vectors()].concat();
    let arrays = [
        structures("run", &timed, &[times]),
        units(&["ms", "mN", "N", "m/s2"]),
    ];
    let recording = read(&arrays).unwrap();
    assert_eq!(firsts(&recording), expected);
    assert_eq!(recording.rate().hz(), 10.0);
    // Longer or shorter than the fields.
    for wrong in [&["mN", "N"][..], &["mN", "N", "m/s2", "V", "V"]] {
        let recording = read(&[structures("run", &fields, &[run(units(wrong))])]).unwrap();
        assert!(says(
            &recording,
            "were not applied to `run.ft`, `run.fn`, `run.acc`: the list is not as long"
        ));
        assert_eq!(firsts(&recording)[0].1, 1.0);
    }
}

#[test]
fn a_list_of_variables_needs_names() {
    let vectors = |names: [&str; 3]| names.map(|name| column(name, &[1.0, 2.0])).to_vec();
    let rate = column("fs", &[10.0]);
    let own = || {
        [
            vectors(["ft", "fn", "acc"]),
            vec![list(&["m/s2", "mN", "N"]), rate.clone()],
        ]
        .concat()
    };
    let recording = read(&own()).unwrap();
    assert!(says(
        &recording,
        "were not applied to `ft`, `fn`, `acc`: only the fields of a structure"
    ));
    assert_eq!(firsts(&recording)[0].1, 1.0);
    let names = cells("channels", &["Acc", "Ft", "Fn"].map(|name| text("", name)));
    let recording = read(&[own(), vec![names]].concat()).unwrap();
    let found = firsts(&recording);
    assert_eq!((found[0].1, found[1].1), (1e-3, 1.0));
    assert_eq!(found[2].2, &Unit::MetrePerSecondSquared);
    // One unit for all has no order.
    let forces = [
        vectors(["fx", "fy", "fz"]),
        vec![list(&["mN"; 3]), rate.clone()],
    ]
    .concat();
    let recording = read(&forces).unwrap();
    assert!(
        firsts(&recording)
            .iter()
            .all(|(_, first, _)| *first == 1e-3)
    );
    // A place without a unit.
    let units = cells(
        "units",
        &[text("", "mN"), column("", &[]), text("", "m/s2")],
    );
    let run = [vectors(["", "", ""]), vec![units, rate]].concat();
    let recording = read(&[structures(
        "run",
        &["ft", "fn", "acc", "units", "fs"],
        &[run],
    )])
    .unwrap();
    assert_eq!(firsts(&recording)[0].1, 1e-3);
    assert_eq!(firsts(&recording)[2].2, &Unit::MetrePerSecondSquared);
}

#[test]
fn a_structure_of_units_holds_by_names() {
    let units = |called: &str| {
        let fields = ["Ft", "ACC", "t"];
        structures(
            called,
            &fields,
            &[["mN", "m/s2", "ms"].map(|unit| text("", unit)).to_vec()],
        )
    };
    let of_run = [vectors(), vec![column("", &[0.0, 100.0]), units("")]].concat();
    let fields = ["ft", "fn", "acc", "t", "units"];
    let inside = read(&[structures("run", &fields, std::slice::from_ref(&of_run))]).unwrap();
    let beside = read(&[
        structures("run", &fields[..4], &[of_run[..4].to_vec()]),
        units("unit"),
    ])
    .unwrap();
    for recording in [inside, beside] {
        let found = firsts(&recording);
        assert_eq!((found[0].1, found[1].1), (1e-3, 1.0));
        assert_eq!(found[2].2, &Unit::MetrePerSecondSquared);
        assert_eq!(recording.rate().hz(), 10.0);
        assert!(says(&recording, "`run.fn` without a unit is read in N"));
    }
}

/// A rate around a structure that has its own: with both numbers, unless channels have it.
#[test]
fn an_outer_rate_that_no_channel_has_is_said() {
    let rates = |inner: f64, outer: f64| {
        let run = vec![column("", &[1.0, 2.0]), column("", &[inner])];
        vec![
            structures("run", &["acc", "fs"], &[run]),
            column("fs", &[outer]),
        ]
    };
    let recording = read(&rates(500.0, 1000.0)).unwrap();
    assert_eq!(recording.rate().hz(), 500.0);
    assert!(says(
        &recording,
        "`fs` states 1000 Hz and was not used: `run.acc` has 500 Hz"
    ));
    assert_eq!(read(&rates(500.0, 500.0)).unwrap().about.warnings.len(), 1);
    let both = [rates(500.0, 1000.0), vec![column("fz", &[1.0, 2.0, 3.0])]].concat();
    assert!(!says(&read(&both).unwrap(), "was not used"));
}

/// Times of MATLAB with their unit at the end of their names.
#[test]
fn times_have_the_unit_at_their_ends() {
    for (name, step) in [("t_us", 500.0), ("micros", 500.0), ("timestamp_ns", 5e5)] {
        let time = column(name, &[0.0, step, 2.0 * step]);
        let recording = read(&[column("acc", &[1.0, 2.0, 3.0]), time]).unwrap();
        assert_eq!(recording.channels().len(), 1, "{name}");
        assert!((recording.rate().hz() - 2000.0).abs() < 1e-9, "{name}");
    }
}
