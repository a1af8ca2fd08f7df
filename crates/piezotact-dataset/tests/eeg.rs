//! EEG files of other programs against the values of MNE, edfio and pyxdf (`golden/eeg_files.py`).
#![allow(
    clippy::unwrap_used,
    reason = "a test that fails where it cannot go on"
)]

use std::path::{Path, PathBuf};

use piezotact::quantity::Unit;
use piezotact::recording::{Event, EventValue, RecordingWarning};
use piezotact_dataset::eeg::{EegFile, EegKind, XdfFile, XdfValues, read_eeg, read_xdf};
use piezotact_dataset::{FileKind, ReadOptions, read_recording};
use serde_json::Value;

use crate::shared_data;

pub(super) fn kept(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/golden/eeg")
        .join(name)
}

fn golden() -> Value {
    serde_json::from_str(&std::fs::read_to_string(kept("mne.json")).unwrap()).unwrap()
}

/// As MNE describes an event: `Stimulus/S  1`, with an empty value for none.
fn described(event: &Event, kind: EegKind) -> String {
    match (&event.value, kind) {
        (Some(EventValue::Text(text)), _) => format!("{}/{text}", event.kind),
        (Some(EventValue::Number(number)), _) => format!("{}#{number}", event.kind),
        (None, EegKind::BrainVision) => format!("{}/", event.kind),
        (None, _) => event.kind.clone(),
    }
}

/// The samples of a channel over all segments.
fn joined(file: &EegFile, name: &str) -> (Unit, Vec<f64>) {
    let parts = file.segments.iter().map(|part| {
        let found = part.recording.channels().iter().find(|c| c.name == name);
        found.unwrap_or_else(|| unreachable!("no channel {name}"))
    });
    let unit = file.segments[0]
        .recording
        .channels()
        .iter()
        .find(|c| c.name == name);
    let samples = parts.flat_map(|channel| channel.samples.iter().copied());
    (unit.unwrap().unit.clone(), samples.collect())
}

/// Every event with the index of its sample in the file whose gaps are closed, as MNE counts.
fn counted(file: &EegFile) -> Vec<(i64, String)> {
    let mut before = 0;
    let mut events = Vec::new();
    for part in &file.segments {
        let channels = part.recording.channels().iter();
        let length = channels.map(|c| c.samples.len()).max().unwrap() as i64;
        let own = part
            .recording
            .annotations
            .events
            .iter()
            .zip(&part.event_samples);
        for (event, sample) in own {
            // MNE leaves out what is outside the samples.
            if (0..length).contains(sample) {
                events.push((before + sample, described(event, file.kind)));
            }
        }
        before += length;
    }
    events
}

/// Compares a file with what MNE found in it: number, mean and ends of every channel to 1e-12 of its size; events exactly.
fn same_as_mne(path: &Path, expected: &Value) {
    let file = read_eeg(path).unwrap_or_else(|error| unreachable!("{error}"));
    let fastest = file.segments[0]
        .recording
        .clocks()
        .iter()
        .map(|c| c.rate_hz.hz());
    let rate_hz = fastest.fold(0.0, f64::max);
    assert!(
        (rate_hz - expected["rate_hz"].as_f64().unwrap()).abs() < 1e-9,
        "{path:?}"
    );
    for channel in expected["channels"].as_array().unwrap() {
        let name = channel["name"].as_str().unwrap();
        let (_, samples) = joined(&file, name);
        assert_eq!(
            samples.len() as u64,
            channel["count"].as_u64().unwrap(),
            "{path:?} {name}"
        );
        let size = samples.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let near = |found: f64, wanted: &Value, what: &str| {
            let wanted = wanted.as_f64().unwrap();
            // 15 digits of the golden values, and sums in another order.
            assert!(
                (found - wanted).abs() <= 1e-12 * size.max(wanted.abs()),
                "{path:?} {name} {what}: {found} {wanted}"
            );
        };
        let mean = samples.iter().sum::<f64>() / samples.len() as f64;
        near(mean, &channel["mean"], "mean");
        for k in 0..2 {
            near(samples[k], &channel["first"][k], "first");
            near(samples[samples.len() - 2 + k], &channel["last"][k], "last");
        }
    }
    let wanted: Vec<(i64, String)> = expected["events"]
        .as_array()
        .unwrap()
        .iter()
        .map(|event| {
            (
                event[0].as_i64().unwrap(),
                event[1].as_str().unwrap().to_owned(),
            )
        })
        .collect();
    let found = counted(&file);
    let mut annotated: Vec<(i64, String)> = found
        .iter()
        .filter(|(_, text)| !text.contains('#'))
        .cloned()
        .collect();
    // MNE takes the first new segment for the start of the recording alone.
    annotated.retain(|(at, text)| !(*at == 0 && text == "New Segment/"));
    let sorted = |mut list: Vec<(i64, String)>| {
        list.sort();
        list
    };
    assert_eq!(sorted(annotated), sorted(wanted), "{path:?}");
    let triggers: Vec<(i64, String)> = found
        .into_iter()
        .filter(|(_, text)| text.contains('#'))
        .collect();
    let wanted = expected["triggers"].as_array().cloned().unwrap_or_default();
    assert_eq!(triggers.len(), wanted.len(), "{path:?} {triggers:?}");
    for ((at, text), wanted) in triggers.iter().zip(&wanted) {
        let code = text.rsplit('#').next().unwrap();
        assert_eq!(
            (*at, code),
            (wanted[0].as_i64().unwrap(), wanted[1].to_string().as_str()),
            "{path:?}"
        );
    }
    let start = file.segments[0].recording.annotations.started_at.as_ref();
    match (start, expected["start"].as_str()) {
        (Some(start), Some(wanted)) => {
            // MNE knows no part of a second in EDF+.
            let digits = if file.kind == EegKind::BrainVision {
                23
            } else {
                19
            };
            let upto = |text: &str| text.chars().take(digits).collect::<String>();
            assert_eq!(upto(&start.to_string()), upto(wanted), "{path:?}");
        }
        (found, wanted) => assert_eq!(
            found.map(ToString::to_string).as_deref(),
            wanted,
            "{path:?}"
        ),
    }
}

#[test]
fn shared_files_have_the_values_of_mne() {
    let Some(folder) = shared_data::shared("data/eeg") else {
        return;
    };
    let golden = golden();
    let files = golden["shared"].as_object().unwrap();
    assert_eq!(files.len(), 14);
    for (name, expected) in files {
        same_as_mne(&folder.join(name), expected);
    }
}

#[test]
fn files_of_other_programs_have_the_values_of_mne() {
    let golden = golden();
    for (name, expected) in golden["own"].as_object().unwrap() {
        same_as_mne(&kept(name), expected);
    }
}

/// The samples of EEGLAB's reader in MATLAB, as MNE keeps them for its own tests: µV, one row for each channel.
#[test]
fn bdf_and_edf_have_the_samples_of_eeglab() {
    let Some(folder) = shared_data::shared("data/eeg/edf") else {
        return;
    };
    for (name, matlab) in [
        ("test.bdf", "test_bdf_eeglab.mat"),
        ("test.edf", "test_edf_eeglab.mat"),
    ] {
        let file = read_eeg(&folder.join(name)).unwrap();
        let path = folder.join(matlab);
        let content =
            piezotact_dataset::matlab::parse_mat(&path, &std::fs::read(&path).unwrap()).unwrap();
        let piezotact_dataset::matlab::MatValue::Numbers(numbers) = content.get("data").unwrap()
        else {
            unreachable!("numbers");
        };
        let channels = file.segments[0].recording.channels();
        let (rows, columns) = (numbers.dims[0], numbers.dims[1]);
        let mut compared = 0;
        for (row, channel) in channels.iter().enumerate().take(rows) {
            if channel.unit != Unit::Volt {
                continue;
            }
            for column in 0..columns {
                let wanted = numbers.real[row + column * rows] * 1e-6;
                let found = channel.samples[column];
                // EEGLAB keeps single precision.
                assert!(
                    (found - wanted).abs() <= 2e-7 * wanted.abs().max(1e-6),
                    "{name} {row} {column}: {found} {wanted}"
                );
            }
            compared += 1;
        }
        assert!(compared > 60, "{name}: {compared}");
    }
}

fn sine(k: usize, channel: i32, rate_hz: f64) -> f64 {
    let hz = f64::from(10 + channel);
    100e-6 / 2_f64.powi(channel) * (std::f64::consts::TAU * hz * k as f64 / rate_hz).sin()
}

/// 100 µV is 1e-4 V, to one step of 16 bits over ±200 µV.
#[test]
fn a_sine_of_100_microvolt_is_1e_4_volt() {
    for name in ["plus.edf", "plus.bdf"] {
        let file = read_eeg(&kept(name)).unwrap();
        let (unit, samples) = joined(&file, "C1");
        assert_eq!(unit, Unit::Volt);
        let step = if name == "plus.edf" {
            400e-6 / 65_535.0
        } else {
            400e-6 / 16_777_215.0
        };
        for (k, sample) in samples.iter().enumerate() {
            assert!((sample - sine(k, 0, 100.0)).abs() <= step, "{name} {k}");
        }
    }
}

#[test]
fn gaps_become_segments_with_their_start() {
    let file = read_eeg(&kept("gaps.edf")).unwrap();
    assert_eq!(file.kind, EegKind::EdfPlusGaps);
    let starts: Vec<f64> = file.segments.iter().map(|part| part.start_s.0).collect();
    let lengths: Vec<usize> = file
        .segments
        .iter()
        .map(|part| part.recording.len())
        .collect();
    assert_eq!(
        (starts.as_slice(), lengths.as_slice()),
        (&[0.0, 5.0, 8.0][..], &[300, 200, 200][..])
    );
    let started = |k: usize| {
        file.segments[k]
            .recording
            .annotations
            .started_at
            .as_ref()
            .unwrap()
            .to_string()
    };
    assert_eq!(started(0), "2024-03-01T10:22:33.25");
    assert_eq!(started(1), "2024-03-01T10:22:38.25");
    for part in &file.segments {
        let first = (part.start_s.0 * 100.0) as usize;
        for (k, sample) in part.recording.channels()[1].samples.iter().enumerate() {
            assert!((sample - sine(first + k, 1, 100.0)).abs() < 400e-6 / 65_535.0);
        }
    }
    let events: Vec<(usize, i64, &str)> = file
        .segments
        .iter()
        .enumerate()
        .flat_map(|(n, part)| {
            let own = part
                .recording
                .annotations
                .events
                .iter()
                .zip(&part.event_samples);
            own.map(move |(event, sample)| (n, *sample, event.kind.as_str()))
        })
        .collect();
    // `golden/eeg_files.py` puts its annotations into the first records.
    assert!(
        events.contains(&(0, 50, "start")) && events.contains(&(0, 212, "S  1")),
        "{events:?}"
    );
    assert!(events.contains(&(2, 199, "µ")), "{events:?}");

    let file = read_eeg(&kept("gap.vhdr")).unwrap();
    let starts: Vec<f64> = file.segments.iter().map(|part| part.start_s.0).collect();
    assert_eq!(starts, [0.0, 6.0]);
    assert_eq!(file.segments[0].event_samples, [0, 50]);
    assert_eq!(file.segments[1].event_samples, [0, 0, 100, 199]);
    let second = file.segments[1]
        .recording
        .annotations
        .started_at
        .as_ref()
        .unwrap();
    assert_eq!(second.to_string(), "2024-03-01T10:22:39.5");
    assert_eq!(
        file.segments[1].recording.channels()[1].unit,
        Unit::Other("°C".into())
    );

    let file = read_eeg(&kept("struct.set")).unwrap();
    let starts: Vec<f64> = file.segments.iter().map(|part| part.start_s.0).collect();
    assert_eq!(starts, [0.0, 3.5, 4.8]);
    let event = &file.segments[1].recording.annotations.events[1];
    assert_eq!(
        (event.kind.as_str(), file.segments[1].event_samples[1]),
        ("7", 50)
    );

    let contents = read_recording(&kept("gaps.edf"), &ReadOptions::default()).unwrap();
    assert_eq!(contents.recording.len(), 300);
    let warnings = contents.recording.about.warnings.iter();
    let said = warnings
        .filter_map(piezotact::Warning::kind)
        .any(|warning: RecordingWarning| {
            matches!(warning, RecordingWarning::OneSegment { count: 3, .. })
        });
    assert!(said, "{:?}", contents.recording.about.warnings);
}

#[test]
fn epochs_become_segments() {
    let golden = golden();
    let file = read_eeg(&kept("epochs.set")).unwrap();
    let trials = golden["epochs"].as_array().unwrap();
    assert_eq!(file.segments.len(), trials.len());
    for (part, trial) in file.segments.iter().zip(trials) {
        for (channel, wanted) in part
            .recording
            .channels()
            .iter()
            .zip(trial.as_array().unwrap())
        {
            assert_eq!(channel.name, wanted["name"].as_str().unwrap());
            assert_eq!(
                channel.samples.len() as u64,
                wanted["count"].as_u64().unwrap()
            );
            let first = wanted["first"][1].as_f64().unwrap();
            assert!(
                (channel.samples[1] - first).abs() < 1e-10,
                "{} {first}",
                channel.samples[1]
            );
        }
        assert_eq!(part.event_samples, [20]);
    }
}

/// Channels of other rates keep theirs; annotations stand in any channel and any record; the first record begins 0.75 s late.
#[test]
fn several_rates_and_annotation_channels() {
    let file = read_eeg(&kept("two.edf")).unwrap();
    let [part] = file.segments.as_slice() else {
        unreachable!("one segment");
    };
    let rates: Vec<f64> = part
        .recording
        .clocks()
        .iter()
        .map(|clock| clock.rate_hz.hz())
        .collect();
    assert_eq!(rates, [64.0, 8.0]);
    let started = part.recording.annotations.started_at.as_ref().unwrap();
    assert_eq!(started.to_string(), "2091-06-05T23:59:59.75");
    let early = &part.recording.annotations.events[0];
    assert_eq!((early.onset_s.0, early.duration_s.0), (0.0, 0.0));
    let also = part
        .recording
        .annotations
        .events
        .iter()
        .find(|event| event.kind == "also")
        .unwrap();
    assert_eq!((also.onset_s.0, also.duration_s.0), (0.25, 0.5));
}

#[test]
fn info_reads_every_kind() {
    for (name, kind, channels) in [
        ("pybv_float.vhdr", "BrainVision", 3),
        ("plus.edf", "EDF or BDF", 2),
        ("plus.bdf", "EDF or BDF", 2),
        ("eeglabio.set", "EEGLAB", 3),
        ("streams.xdf", "XDF", 3),
    ] {
        let contents = read_recording(&kept(name), &ReadOptions::default()).unwrap();
        assert_eq!(
            (
                contents.kind.to_string().as_str(),
                contents.recording.channels().len()
            ),
            (kind, channels)
        );
    }
    assert_eq!(
        FileKind::of_ending(Path::new("a.edf")).unwrap().to_string(),
        "EDF or BDF"
    );
    for name in ["gap.vmrk", "gap.eeg"] {
        let refused = read_eeg(&kept(name)).unwrap_err().to_string();
        assert!(refused.contains("gap.vhdr"), "{refused}");
    }
}

#[test]
fn streams_have_the_times_of_pyxdf() {
    let golden = golden();
    let own = read_xdf(&kept("streams.xdf")).unwrap();
    assert!(own.warnings.is_empty(), "{:?}", own.warnings);
    same_as_pyxdf(&own, &golden["xdf"]["streams.xdf"]);
    if let Some(path) = shared_data::shared("data/eeg/xdf/clock_resets.xdf") {
        same_as_pyxdf(
            &read_xdf(&path).unwrap(),
            &golden["xdf"]["clock_resets.xdf"],
        );
    }
}

fn same_as_pyxdf(file: &XdfFile, wanted: &Value) {
    let wanted = wanted.as_array().unwrap();
    assert_eq!(file.streams.len(), wanted.len());
    let ranges = |value: &Value| -> Vec<std::ops::Range<usize>> {
        let pair = |pair: &Value, k: usize| pair[k].as_u64().unwrap() as usize;
        value
            .as_array()
            .unwrap()
            .iter()
            .map(|p| pair(p, 0)..pair(p, 1))
            .collect()
    };
    for (stream, wanted) in file.streams.iter().zip(wanted) {
        assert_eq!(stream.name, wanted["name"].as_str().unwrap());
        let count = wanted["count"].as_u64().unwrap() as usize;
        assert_eq!(stream.time_s.len(), count);
        assert_eq!(
            stream.segments,
            ranges(&wanted["segments"]),
            "{}",
            stream.name
        );
        assert_eq!(
            stream.clock_segments,
            ranges(&wanted["clock_segments"]),
            "{}",
            stream.name
        );
        let rate_hz = wanted["effective_hz"].as_f64().unwrap();
        assert!(
            (stream.effective_rate_hz.unwrap_or(0.0) - rate_hz).abs() < 1e-6,
            "{rate_hz}"
        );
        let mut places = vec![0, 1, count / 2, count - 1];
        places.dedup();
        for (at, time) in places.iter().zip(wanted["times"].as_array().unwrap()) {
            let (found, time) = (stream.time_s[*at], time.as_f64().unwrap());
            // The same algorithm with another order of sums: far below a microsecond.
            assert!(
                (found - time).abs() < 1e-7,
                "{} {at}: {found} {time}",
                stream.name
            );
        }
        match &stream.values {
            XdfValues::Numbers(channels) => {
                for (channel, sum) in channels.iter().zip(wanted["sums"].as_array().unwrap()) {
                    let factor = if channel.unit == Unit::Volt { 1e6 } else { 1.0 };
                    let found = channel.samples.iter().sum::<f64>() * factor;
                    let sum = sum.as_f64().unwrap();
                    assert!(
                        (found - sum).abs() < 1e-6 * sum.abs().max(1.0),
                        "{found} {sum}"
                    );
                }
            }
            XdfValues::Texts(texts) => {
                let found: Vec<&str> = texts.iter().map(|row| row[0].as_str()).collect();
                let wanted = wanted["texts"].as_array().unwrap().iter();
                assert_eq!(
                    found,
                    wanted.map(|t| t.as_str().unwrap()).collect::<Vec<_>>()
                );
            }
        }
    }
}

/// A file that was cut is read to its end, with a warning; a damaged part is left out, with a warning.
#[test]
fn a_cut_xdf_file_is_read_with_a_warning() {
    let bytes = std::fs::read(kept("streams.xdf")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.xdf");
    let whole = read_xdf(&kept("streams.xdf")).unwrap();
    std::fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    let half = read_xdf(&path).unwrap();
    assert!(
        half.warnings
            .iter()
            .any(|warning| warning.code == "interrupted"),
        "{:?}",
        half.warnings
    );
    let (XdfValues::Numbers(all), XdfValues::Numbers(some)) =
        (&whole.streams[0].values, &half.streams[0].values)
    else {
        unreachable!("numbers");
    };
    let count = some[0].samples.len();
    assert!(
        900 < count && count < 1100 && all[0].samples[..count] == some[0].samples[..],
        "{count}"
    );
    let mut damaged = bytes.clone();
    let middle = bytes.len() / 2;
    damaged[middle..middle + 40].fill(0xFF);
    std::fs::write(&path, &damaged).unwrap();
    let read = read_xdf(&path).unwrap();
    assert!(
        read.warnings
            .iter()
            .any(|warning| warning.to_string().contains("damaged")),
        "{:?}",
        read.warnings
    );
    assert!(read.streams[0].time_s.len() > 1000);
}
