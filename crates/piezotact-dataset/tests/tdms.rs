//! NI TDMS: files of other programs, which lie beside the checkout, files of npTDMS, and variants made here.
#![allow(
    clippy::unwrap_used,
    reason = "a test that fails where it cannot go on"
)]

use std::io::Cursor;
use std::path::{Path, PathBuf};

use crate::shared_data;
use piezotact::Warning;
use piezotact::quantity::{SampleRate, Unit};
use piezotact::recording::Recording;
use piezotact_dataset::tdms::parse_tdms;
use piezotact_dataset::{FileKind, ReadError, ReadOptions, read_recording};
use serde_json::Value;

pub(crate) fn parse(bytes: &[u8], rate: Option<f64>) -> Result<Recording, ReadError> {
    let options = ReadOptions {
        rate: rate.map(|hz| SampleRate::new(hz).unwrap()),
        ..ReadOptions::default()
    };
    parse_tdms(Path::new("a.tdms"), Cursor::new(bytes), &options)
}

pub(crate) fn said(recording: &Recording) -> String {
    let texts = recording.about.warnings.iter().map(Warning::to_string);
    texts.collect::<Vec<_>>().join("\n")
}

pub(crate) fn samples<'a>(recording: &'a Recording, name: &str) -> &'a [f64] {
    let found = recording.channels().iter().find(|c| c.name == name);
    &found.unwrap_or_else(|| panic!("no `{name}`")).samples
}

pub(crate) fn clocks(recording: &Recording) -> Vec<(f64, f64, usize)> {
    let each = recording.channels_with_clocks();
    each.map(|(c, clock)| (clock.rate_hz.hz(), clock.start_s.0, c.samples.len()))
        .collect()
}

/// Every TDMS file beside the checkout.
pub(crate) fn shared_files() -> Vec<PathBuf> {
    let folders = ["data/daq/tdms", "data/daq/tdms/layouts", "data/daq/tdms/ni"];
    let folders = folders.into_iter().filter_map(shared_data::shared);
    let files = folders.flat_map(|folder| std::fs::read_dir(folder).unwrap());
    let mut files: Vec<PathBuf> = files.map(|file| file.unwrap().path()).collect();
    files.retain(|file| file.extension().is_some_and(|ending| ending == "tdms"));
    files.sort();
    files
}

/// What npTDMS reads of the files in a folder.
fn expected(folder: &str) -> Option<Value> {
    let file = shared_data::shared(&format!("{folder}/expected.json"))?;
    Some(serde_json::from_slice(&std::fs::read(file).unwrap()).unwrap())
}

/// Compares a channel with what npTDMS read of it, whose mean and deviation NumPy summed in another order.
fn compare(file: &str, name: &str, found: &[f64], expected: &Value) {
    let number = |key: &str| expected[key].as_f64();
    assert_eq!(
        found.len() as u64,
        expected["n"].as_u64().unwrap(),
        "{file}: {name}"
    );
    let mean = found.iter().sum::<f64>() / found.len() as f64;
    let variance = found.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / found.len() as f64;
    let largest = found
        .iter()
        .fold(0.0_f64, |largest, v| largest.max(v.abs()));
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-7 * largest;
    assert!(
        number("mean").is_none_or(|b| near(mean, b)),
        "{file}: {name}: {mean}"
    );
    let deviation = variance.sqrt();
    assert!(
        number("std").is_none_or(|b| near(deviation, b)),
        "{file}: {name}: {deviation}"
    );
    let numbers = |key: &str| {
        let all = expected[key].as_array().into_iter().flatten();
        let number = |v: &Value| {
            v.as_f64()
                .or_else(|| v.as_bool().map(|b| f64::from(u8::from(b))))
        };
        all.map(|v| number(v).unwrap()).collect::<Vec<f64>>()
    };
    let (first, last) = (numbers("first"), numbers("last"));
    assert!(
        first.iter().zip(found).all(|(a, b)| near(*a, *b)),
        "{file}: {name}: {found:?}"
    );
    let end = &found[found.len() - last.len()..];
    assert!(
        last.iter().zip(end).all(|(a, b)| near(*a, *b)),
        "{file}: {name}: {end:?}"
    );
}

#[test]
fn the_layouts_of_nptdms() {
    let Some(all) = expected("data/daq/tdms/layouts") else {
        return;
    };
    for (file, channels) in all.as_object().unwrap() {
        let path = shared_data::shared(&format!("data/daq/tdms/layouts/{file}")).unwrap();
        let read = parse(&std::fs::read(path).unwrap(), Some(1000.0));
        let refused = match file.strip_suffix(".tdms").unwrap() {
            "scenario_add_new_channel" => "2 of `channel3`",
            "scenario_increase_channel_size" => "6 of `channel2`",
            "scenario_channel_without_data" | "scenario_channel_without_data_or_data_type" => {
                "`channel1` (no samples)"
            }
            "scenario_complex_data" => "`complex_single_channel` (complex numbers)",
            "scenario_timestamp_data" | "scenario_interleaved_timestamp_data" => {
                "`TimeChannel1` (times)"
            }
            "daqmx_exception_on_mismatch_of_raw_data_widths" => "the same widths of DAQmx buffers",
            "daqmx_multiple_scalers_with_same_type" => "2 scalers and no scale that joins them",
            _ => {
                let read = read.unwrap_or_else(|error| panic!("{file}: {error}"));
                for (name, expected) in channels.as_object().unwrap() {
                    let (_, name) = name.split_once('/').unwrap();
                    // npTDMS refuses DAQmx raw data without a scale; here they are counts.
                    let is_number = expected["dtype"]
                        .as_str()
                        .is_some_and(|t| !t.contains("time"));
                    if is_number {
                        compare(file, name, samples(&read, name), expected);
                    }
                }
                continue;
            }
        };
        let error = read.unwrap_err().to_string();
        assert!(error.contains(refused), "{file}: {error}");
    }
    let counts = |file: &str| {
        let path =
            shared_data::shared(&format!("data/daq/tdms/layouts/daqmx_{file}.tdms")).unwrap();
        let read = parse(&std::fs::read(path).unwrap(), Some(1000.0)).unwrap();
        let each = read
            .channels()
            .iter()
            .map(|channel| channel.samples.clone());
        (each.collect::<Vec<_>>(), said(&read))
    };
    // As npTDMS gives their scalers.
    let (found, said) = counts("digital_line_scaler_data");
    assert_eq!((found, said.as_str()), (vec![vec![0.0, 1.0, 0.0, 1.0]], ""));
    let (found, said) = counts("single_channel_i16");
    assert_eq!(found, [[1.0, 2.0, -1.0, -2.0]]);
    assert!(said.contains("contains integers without a scale"), "{said}");
    let (found, _) = counts("two_channel_i16");
    assert_eq!(found, [[1.0, 2.0, 3.0, 4.0], [17.0, 18.0, 19.0, 20.0]]);
    let (found, _) = counts("mixed_channel_widths");
    assert_eq!(
        found,
        [
            [1.0, 2.0, 3.0, 4.0],
            [17.0, 18.0, 19.0, 20.0],
            [33.0, 34.0, 35.0, 36.0]
        ]
    );
    let (found, _) = counts("multiple_raw_data_buffers");
    let from = |first: i32| (first..first + 8).step_by(2).map(f64::from);
    let each = [1, 2, 9, 10].map(|first| from(first).collect::<Vec<_>>());
    assert_eq!(found, each);
}

#[test]
fn files_of_labview_and_of_a_laboratory() {
    for folder in ["data/daq/tdms", "data/daq/tdms/ni"] {
        let Some(all) = expected(folder) else { return };
        for (file, channels) in all.as_object().unwrap() {
            let path = shared_data::shared(&format!("{folder}/{file}")).unwrap();
            if ["finger_int16_cut_short.tdms", "time_channel.tdms"].contains(&file.as_str()) {
                continue;
            }
            let contents = read_recording(&path, &ReadOptions::default()).unwrap();
            assert_eq!(contents.kind, FileKind::TDMS);
            let read = contents.recording;
            let channels = channels.get("first_channels").unwrap_or(channels);
            for (name, expected) in channels.as_object().unwrap() {
                if expected["dtype"] == "object" {
                    continue;
                }
                let (group, name) = name.rsplit_once('/').unwrap();
                let several = format!("{group}: {name}");
                let mut all = read.channels_with_clocks();
                let (channel, clock) = all
                    .find(|(c, _)| c.name == name || c.name == several)
                    .unwrap();
                let (unit, si) = Unit::parse(match expected["unit"].as_str() {
                    Some("Volts") => "V",
                    unit => unit.unwrap_or(""),
                });
                assert_eq!(channel.unit, unit, "{name}");
                let stored: Vec<f64> = channel.samples.iter().map(|v| v / si).collect();
                compare(file, name, &stored, expected);
                assert!(
                    (clock.rate_hz.hz() / expected["rate"].as_f64().unwrap() - 1.0).abs() < 1e-12
                );
                let start = read.annotations.started_at.as_ref().unwrap();
                let start = start.later(clock.start_s).to_string();
                // To the microsecond, as npTDMS gives it.
                let stated = expected["start"].as_str().unwrap().trim_end_matches('0');
                assert!(
                    start.starts_with(stated.trim_end_matches('.')),
                    "{start} {stated}"
                );
            }
        }
    }
    let read = |file: &str| {
        let path = shared_data::shared(&format!("data/daq/tdms/{file}")).unwrap();
        read_recording(&path, &ReadOptions::default()).map(|contents| contents.recording)
    };
    // Its own statistics, of which INDEX.md has those of the first channel: g, single precision.
    let good = read("good_tdms_1.tdms").unwrap();
    let first = samples(&good, "TP_ACC_LAT19_315deg_X");
    let g = 9.80665;
    let extreme = |of: fn(f64, f64) -> f64| first.iter().copied().reduce(of).unwrap() / g;
    assert_eq!(
        (good.channels().len(), good.len(), said(&good).as_str()),
        (8, 18_000, "")
    );
    assert!((good.rate().hz() - 30.0).abs() < 1e-9);
    assert!((extreme(f64::min) + 0.007_484_036_032_110_453).abs() < 1e-15);
    assert!((extreme(f64::max) - 0.008_403_714_746_236_801).abs() < 1e-15);
    let mean = first.iter().sum::<f64>() / 18_000.0 / g;
    assert!((mean - 0.000_409_661_015_236_519_3).abs() < 1e-9, "{mean}");
    let faulty = read("faulty_tdms_01.tdms").unwrap_err().to_string();
    assert!(
        faulty.contains("expected the tag `TDSm` of a segment, found"),
        "{faulty}"
    );
    assert!(faulty.contains("at byte "), "{faulty}");
    let index = shared_data::shared("data/daq/tdms/ni/finger_int16_scaled.tdms_index").unwrap();
    let index = read_recording(&index, &ReadOptions::default())
        .unwrap_err()
        .to_string();
    assert!(
        index.contains("the index of one")
            && index.ends_with("finger_int16_scaled.tdms, the file that it belongs to"),
        "{index}"
    );
    let text = said(&read("ni/two_rates.tdms").unwrap());
    assert!(
        text.contains("left out: `remark` (3 texts, the first `"),
        "{text}"
    );
    let labelled = read("ni/finger_int16_scaled.tdms")
        .unwrap()
        .annotations
        .labels;
    assert_eq!(labelled["Description"], "made for tests: 160 Hz and 323 Hz");
    assert_eq!(
        labelled["Nail acceleration: NI_ChannelName"],
        "cDAQ1Mod1/ai0"
    );
    // The times of the channel Time are found; the sample that is no number is refused as in other files.
    let gap = read("ni/time_channel.tdms").unwrap_err().to_string();
    assert!(
        gap.contains("NaN at sample") && gap.contains("of `acc 'nail'/x`"),
        "{gap}"
    );
    // The force ends 3501 samples early: rows are whole, and what is missing is said.
    let cut = read("ni/finger_int16_cut_short.tdms").unwrap();
    assert_eq!((cut.len(), cut.channels().len()), (47_699, 2));
    let force = samples(&cut, "Normal force");
    let mean = force.iter().sum::<f64>() / force.len() as f64;
    assert!((mean - 0.522_057_946_225_058_1).abs() < 1e-12, "{mean}");
    let text = said(&cut);
    assert!(
        text.contains("3501 of 51200 samples of `Normal force`"),
        "{text}"
    );
    assert!(
        text.contains("the last 3501 samples of `Nail acceleration` were left out"),
        "{text}"
    );
}

/// Chains of scales and `DAQmx` buffers of two cards, as npTDMS reads them (golden/tdms.py).
#[test]
fn scales_and_cards_as_nptdms_reads_them() {
    let read = parse(include_bytes!("golden/scales.tdms"), None).unwrap();
    let table = [2.0, 2.0, 2.0, 4.25, 9.0, 23.75, 40.0, 40.0, 40.0];
    let difference = [6.5, 1.125, -1.5, -2.125, -1.5, -0.375, 0.5, 0.375, -1.5];
    let sum = [
        -32.5, -21.125, -12.5, -5.875, -0.5, 4.375, 9.5, 15.625, 23.5,
    ];
    assert_eq!(samples(&read, "table of polynomial"), table);
    assert_eq!(samples(&read, "difference"), difference);
    assert_eq!(samples(&read, "sum"), sum);
    // Ends of bridges of strain gauges, rounded where the formula is put otherwise.
    for (bridge, first, last) in [
        (
            "full bridge 1",
            0.022_261_904_761_904_764,
            -0.019_642_857_142_857_146,
        ),
        (
            "full bridge 2",
            0.034_249_084_249_084_25,
            -0.030_219_780_219_780_223,
        ),
        (
            "full bridge 3",
            0.035_051_217_889_241_9,
            -0.029_621_650_733_809_075,
        ),
        (
            "half bridge 1",
            0.072_193_843_276_931_9,
            -0.058_425_440_416_462_346,
        ),
        (
            "half bridge 2",
            0.044_778_231_292_517_02,
            -0.039_510_204_081_632_66,
        ),
        (
            "quarter bridge",
            0.097_875_915_393_479_7,
            -0.073_507_356_430_944_5,
        ),
    ] {
        let found = samples(&read, bridge);
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-14;
        assert!(
            near(found[0], first) && near(found[8], last),
            "{bridge}: {found:?}"
        );
    }
    let text = said(&read);
    assert!(
        text.contains("`table of polynomial`: 6 of 9 samples lie outside the range"),
        "{text}"
    );
    let read = parse(include_bytes!("golden/daqmx.tdms"), None).unwrap();
    let first = [1.0, 6.0, 11.0, 16.0, 21.0, 26.0].map(|mn| mn * 1e-3);
    let second = [1.0, -2.5, -6.0, -9.5, -13.0, -16.5].map(|mn| mn * 1e-3);
    assert_eq!(samples(&read, "first"), first);
    assert_eq!(samples(&read, "second"), second);
    assert_eq!(
        samples(&read, "joined"),
        [0.0, 99_999.0, 199_996.0, 299_991.0, 399_984.0, 499_975.0]
    );
    assert_eq!((read.rate().hz(), said(&read).as_str()), (2.0, ""));
}

pub(crate) const META: u32 = 2 | 4;
pub(crate) const RAW: u32 = 8;
pub(crate) const LISTED_BEFORE: u32 = 2;
pub(crate) const NONE: &[u8] = &[0xFF; 4];
pub(crate) const SAME: &[u8] = &[0; 4];

pub(crate) enum Holds<'a> {
    Text(&'a str),
    Number(f64),
    Time(i64, u64),
}
use Holds::{Number, Text, Time};

pub(crate) fn text(text: &str) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes(), text.as_bytes()].concat()
}

/// An object: its path, how its samples lie, its properties.
pub(crate) fn object(path: &str, index: &[u8], properties: &[(&str, Holds<'_>)]) -> Vec<u8> {
    let mut bytes = [&text(path), index, &(properties.len() as u32).to_le_bytes()].concat();
    for (name, holds) in properties {
        bytes.extend(text(name));
        match holds {
            Text(value) => bytes.extend([&0x20_u32.to_le_bytes(), &text(value)[..]].concat()),
            Number(value) => {
                bytes.extend([&10_u32.to_le_bytes()[..], &value.to_le_bytes()].concat())
            }
            Time(seconds, fraction) => {
                bytes.extend(0x44_u32.to_le_bytes());
                bytes.extend(fraction.to_le_bytes());
                bytes.extend(seconds.to_le_bytes());
            }
        }
    }
    bytes
}

/// So many samples of a type.
pub(crate) fn samples_of(code: u32, count: u64) -> Vec<u8> {
    let words = [0x14, code, 1].map(u32::to_le_bytes).concat();
    [&words[..], &count.to_le_bytes()].concat()
}

pub(crate) fn segment(contents: u32, objects: &[Vec<u8>], raw: &[u8]) -> Vec<u8> {
    let metadata = match contents & LISTED_BEFORE {
        0 => Vec::new(),
        _ => [&(objects.len() as u32).to_le_bytes()[..], &objects.concat()].concat(),
    };
    let mut bytes = b"TDSm".to_vec();
    bytes.extend([contents, 4713].map(u32::to_le_bytes).concat());
    let ends = (metadata.len() + raw.len()) as u64;
    bytes.extend([ends, metadata.len() as u64].map(u64::to_le_bytes).concat());
    [bytes, metadata, raw.to_vec()].concat()
}

pub(crate) fn doubles(values: &[f64]) -> Vec<u8> {
    values
        .iter()
        .flat_map(|value| value.to_le_bytes())
        .collect()
}

/// Two channels at 1 kHz, of three samples a chunk.
pub(crate) fn plain() -> Vec<u8> {
    let step = || [("wf_increment", Number(1e-3)), ("unit_string", Text("N"))];
    let objects = [
        object("/'g'/'a'", &samples_of(10, 3), &step()),
        object("/'g'/'b'", &samples_of(10, 3), &step()),
    ];
    segment(
        META | RAW,
        &objects,
        &doubles(&[1.0, 2.0, 3.0, 10.0, 20.0, 30.0]),
    )
}

#[test]
fn channels_come_go_and_come_again() {
    let mut file = plain();
    // No metadata: as before.
    file.extend(segment(
        RAW,
        &[],
        &doubles(&[4.0, 5.0, 6.0, 40.0, 50.0, 60.0]),
    ));
    // Only `a` has samples; then both again, with what was known of `b`, in another order.
    file.extend(segment(
        LISTED_BEFORE | RAW,
        &[object("/'g'/'b'", NONE, &[])],
        &doubles(&[7.0, 8.0, 9.0]),
    ));
    let objects = [object("/'g'/'b'", SAME, &[]), object("/'g'/'a'", NONE, &[])];
    file.extend(segment(META | RAW, &objects, &doubles(&[70.0, 80.0, 90.0])));
    let read = parse(&file, None).unwrap();
    assert_eq!(
        samples(&read, "a"),
        [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]
    );
    assert_eq!(
        samples(&read, "b"),
        [10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 90.0]
    );
    assert_eq!(
        (clocks(&read)[0], said(&read).as_str()),
        ((1000.0, 0.0, 9), "")
    );
    // A channel that is named before it has samples and a type, and again behind them.
    let nothing = || segment(META, &[object("/'g'/'a'", &samples_of(0, 0), &[])], &[]);
    let read = parse(&[nothing(), plain(), nothing()].concat(), None).unwrap();
    assert_eq!(samples(&read, "a"), [1.0, 2.0, 3.0]);
    // A file without a whole last chunk, whose segment says so: less of every channel.
    let objects = [
        object(
            "/'g'/'a'",
            &samples_of(10, 2),
            &[("wf_increment", Number(1.0))],
        ),
        object(
            "/'g'/'b'",
            &samples_of(3, 2),
            &[("wf_increment", Number(1.0))],
        ),
    ];
    let raw = [
        &doubles(&[1.0, 2.0])[..],
        &7_i64.to_le_bytes(),
        &doubles(&[3.0]),
        &8_i32.to_le_bytes(),
    ]
    .concat();
    let read = parse(&segment(META | RAW, &objects, &raw), None).unwrap();
    assert_eq!(
        (samples(&read, "a"), samples(&read, "b")),
        (&[1.0, 2.0, 3.0][..], &[7.0, 0.0, 8.0][..])
    );
}

#[test]
fn clocks_names_and_times_are_those_of_the_file() {
    // 2026-03-04 09:08:07.25 UTC.
    let (at, quarter) = (3_855_460_087, 1 << 62);
    let of = |step_s: f64, offset_s: f64, seconds: i64| {
        [
            ("wf_start_time", Time(seconds, quarter)),
            ("wf_start_offset", Number(offset_s)),
            ("wf_increment", Number(step_s)),
        ]
    };
    let stamps = |seconds: &[i64]| {
        let stamp = |s: &i64| [0_u64.to_le_bytes(), s.to_le_bytes()].concat();
        seconds.iter().flat_map(stamp).collect::<Vec<u8>>()
    };
    let objects = [
        object("/", NONE, &[("Sensor type", Text("352C23"))]),
        object("/'slow'/'x'", &samples_of(10, 2), &of(0.5, 0.5, at + 3)),
        object("/'fast'/'x'", &samples_of(10, 3), &of(0.25, 0.0, at)),
        object("/'log'/'when'", &samples_of(0x44, 3), &[]),
        object(
            "/'log'/'fz'",
            &samples_of(10, 3),
            &[("NI_UnitDescription", Text("Newtons"))],
        ),
        object(
            "/'over'/'f'",
            &samples_of(10, 1),
            &[
                ("wf_xunit_string", Text("Hz")),
                ("wf_increment", Number(1.0)),
            ],
        ),
        object("/'alone'/'mean'", &samples_of(10, 1), &[]),
    ];
    let raw = [
        doubles(&[1.0, 2.0, 3.0, 4.0, 5.0]),
        stamps(&[at + 1, at + 2, at + 3]),
        doubles(&[6.0, 7.0, 8.0, 9.0, 10.0]),
    ];
    let file = segment(META | RAW, &objects, &raw.concat());
    let read = parse(&file, None).unwrap();
    assert_eq!(
        clocks(&read),
        [(2.0, 3.5, 2), (4.0, 0.0, 3), (1.0, 0.75, 3)]
    );
    let names: Vec<&str> = read.channels().iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["slow: x", "fast: x", "fz"]);
    assert_eq!(read.channels()[2].unit, Unit::Newton);
    let started = read
        .annotations
        .started_at
        .as_ref()
        .map(ToString::to_string);
    assert_eq!(started.as_deref(), Some("2026-03-04T09:08:07.25Z"));
    assert_eq!(read.annotations.labels["Sensor type"], "352C23");
    let text = said(&read);
    assert!(
        text.contains("`f` (over Hz, not over time), `mean` (no rate, no times)"),
        "{text}"
    );
    let refused = parse(&file, Some(10.0)).unwrap_err().to_string();
    assert!(refused.contains("channels of one rate"), "{refused}");
}

#[test]
fn a_scale_that_is_not_known_is_refused_by_its_name() {
    let scaled = |scale: &str, with: &[(&'static str, f64)]| {
        let mut properties = vec![
            ("wf_increment", Number(1.0)),
            ("NI_Number_Of_Scales", Number(1.0)),
            ("NI_Scale[0]_Scale_Type", Text(scale)),
        ];
        properties.extend(with.iter().map(|(name, value)| (*name, Number(*value))));
        object("/'g'/'hot'", &samples_of(2, 2), &properties)
    };
    let alone = |scale: &str, with: &[(&'static str, f64)]| {
        let file = segment(META | RAW, &[scaled(scale, with)], &[1, 0, 2, 0]);
        parse(&file, None).unwrap_err().to_string()
    };
    for (scale, with, part) in [
        (
            "Thermocouple",
            &[][..],
            "`hot` (a scale of type `Thermocouple`, which is not applied here)",
        ),
        ("Linear", &[], "no number `NI_Scale[0]_Linear_Slope`"),
        (
            "Linear",
            &[("NI_Scale[0]_Linear_Input_Source", 0.0)],
            "in a circle",
        ),
        (
            "Linear",
            &[("NI_Scale[0]_Linear_Input_Source", 3.0)],
            "scale 3 of 1",
        ),
        (
            "Table",
            &[("NI_Scale[0]_Table_Pre_Scaled_Values_Size", 1e18)],
            "no number `NI_Scale[0]_Table_Pre_Scaled_Values[0]`",
        ),
        (
            "Linear",
            &[("NI_Number_Of_Scales", 1e12)],
            "1000000000000 scales",
        ),
    ] {
        let error = alone(scale, with);
        assert!(error.contains(part), "{error}");
    }
    // Beside it, other channels are read, and a scale that was applied already is not applied again.
    let properties = [
        ("wf_increment", Number(1.0)),
        ("NI_Number_Of_Scales", Number(1.0)),
        ("NI_Scaling_Status", Text("scaled")),
        ("NI_Scale[0]_Scale_Type", Text("RTD")),
    ];
    let objects = [
        scaled("Thermocouple", &[]),
        object("/'g'/'a'", &samples_of(10, 1), &properties),
    ];
    let file = segment(
        META | RAW,
        &objects,
        &[&[1, 0, 2, 0], &doubles(&[3.5])[..]].concat(),
    );
    let read = parse(&file, None).unwrap();
    assert_eq!(
        (read.channels().len(), samples(&read, "a")),
        (1, &[3.5][..])
    );
    assert!(
        said(&read).contains("`hot` (a scale of type `Thermocouple`"),
        "{}",
        said(&read)
    );
}

/// Triggers that are appended to one channel, and properties that hold for some of its samples alone.
#[test]
fn what_changes_between_samples_is_said() {
    let started = |seconds: i64, step_s: f64, unit: &'static str| {
        let properties = [
            ("wf_start_time", Time(seconds, 0)),
            ("wf_increment", Number(step_s)),
            ("unit_string", Text(unit)),
        ];
        let index = samples_of(10, 4);
        let objects = [object("/'g'/'a'", &index, &properties)];
        segment(META | RAW, &objects, &doubles(&[1.0, 2.0, 3.0, 4.0]))
    };
    let at = 3_855_460_087;
    let first = || started(at, 0.25, "N");
    let read = parse(&[first(), started(at + 1, 0.25, "N")].concat(), None).unwrap();
    assert_eq!((read.len(), said(&read).as_str()), (8, ""));
    let read = parse(
        &[first(), started(at + 3, 0.25, "N"), first()].concat(),
        None,
    )
    .unwrap();
    let start = read.annotations.started_at.as_ref().unwrap().to_string();
    assert_eq!((read.len(), start.as_str()), (12, "2026-03-04T09:08:07Z"));
    let text = said(&read);
    assert!(
        text.contains("further starts: `a` at sample 4, 9.0 samples after"),
        "{text}"
    );
    for (second, part) in [
        (
            started(at + 1, 0.5, "N"),
            "`a` (its `wf_increment` changes between its samples)",
        ),
        (
            started(at + 1, 0.25, "mN"),
            "`a` (its `unit_string` changes between its samples)",
        ),
    ] {
        let error = parse(&[first(), second].concat(), None)
            .unwrap_err()
            .to_string();
        assert!(error.contains(part), "{error}");
    }
}
