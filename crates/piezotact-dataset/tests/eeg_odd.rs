//! EEG and sound files as laboratories have them: with losses, wrong clocks, held codes, cut short, with one entry that cannot be read.
#![allow(
    clippy::unwrap_used,
    reason = "a test that fails where it cannot go on"
)]

use std::path::{Path, PathBuf};

use piezotact::Warning;
use piezotact::recording::Recording;
use piezotact::statistics::{mean, standard_deviation};
use piezotact_dataset::document::event_counts;
use piezotact_dataset::eeg::{EegSegment, read_eeg, read_eeg_source, read_xdf};
use piezotact_dataset::{ReadOptions, read_recording};

use crate::eeg::kept;
use crate::shared_data;

fn part(path: &Path, part: Option<usize>) -> Recording {
    let options = ReadOptions {
        part,
        ..ReadOptions::default()
    };
    let read = read_recording(path, &options);
    read.unwrap_or_else(|error| unreachable!("{error}"))
        .recording
}

pub(crate) fn segments(path: &Path) -> Vec<EegSegment> {
    read_eeg_source(path).unwrap().segments
}

#[track_caller]
pub(crate) fn said(warnings: &[Warning], text: &str) {
    let texts: Vec<String> = warnings.iter().map(ToString::to_string).collect();
    assert!(texts.iter().any(|one| one.contains(text)), "{texts:?}");
}

fn onsets(recording: &Recording) -> Vec<f64> {
    let events = recording.annotations.events.iter();
    events.map(|event| event.onset_s.0).collect()
}

/// 2, 6, … `to` s, to 0.1 ms.
#[track_caller]
fn every_four_seconds(found: &[f64], to: f64) {
    let wanted: Vec<f64> = (0..)
        .map(|k| 2.0 + 4.0 * f64::from(k))
        .take_while(|t| *t <= to)
        .collect();
    let same = |(found, wanted): (&f64, &f64)| (found - wanted).abs() < 1e-4;
    assert!(
        found.len() == wanted.len() && found.iter().zip(&wanted).all(same),
        "{found:?}"
    );
}

pub(crate) fn chunk(tag: u16, content: &[u8]) -> Vec<u8> {
    let mut bytes = vec![4];
    bytes.extend((content.len() as u32 + 2).to_le_bytes());
    bytes.extend(tag.to_le_bytes());
    bytes.extend(content);
    bytes
}

/// The header of a stream with the type, host, rate and format of `about`.
pub(crate) fn header(id: u32, channels: usize, about: [&str; 4]) -> Vec<u8> {
    let [kind, host, rate, format] = about;
    let xml = format!(
        "<?xml version='1.0'?><info><name>{kind}{id}</name><type>{kind}</type><hostname>{host}</hostname><channel_count>{channels}</channel_count>\
         <nominal_srate>{rate}</nominal_srate><channel_format>{format}</channel_format></info>"
    );
    chunk(2, &[&id.to_le_bytes()[..], xml.as_bytes()].concat())
}

/// A chunk of samples: a time stamp and the bytes of each.
pub(crate) fn samples(id: u32, each: &[(f64, Vec<u8>)]) -> Vec<u8> {
    let mut content = id.to_le_bytes().to_vec();
    content.push(4);
    content.extend((each.len() as u32).to_le_bytes());
    for (time, bytes) in each {
        content.push(8);
        content.extend(time.to_le_bytes());
        content.extend(bytes);
    }
    chunk(3, &content)
}

fn offset(id: u32, time: f64, value: f64) -> Vec<u8> {
    let numbers = [time.to_le_bytes(), value.to_le_bytes()].concat();
    chunk(4, &[&id.to_le_bytes()[..], &numbers].concat())
}

pub(crate) fn footer(id: u32) -> Vec<u8> {
    chunk(6, &[&id.to_le_bytes()[..], b"<info></info>"].concat())
}

/// 60 s of EEG at 250 Hz, sample k being k, without those of `lost`, and 14 markers at 2, 6, … s on a clock 300 s behind; `offsets` are those
/// of the markers' clock.
fn eeg_with_markers(
    lost: std::ops::Range<usize>,
    offsets: &[(f64, f64)],
) -> (tempfile::TempDir, PathBuf) {
    let mut bytes = b"XDF:".to_vec();
    bytes.extend(header(1, 1, ["EEG", "lab1", "250", "double64"]));
    bytes.extend(header(2, 1, ["Markers", "lab2", "0", "string"]));
    let each: Vec<_> = (0..15_000_usize)
        .filter(|k| !lost.contains(k))
        .map(|k| (1000.0 + k as f64 / 250.0, (k as f64).to_le_bytes().to_vec()))
        .collect();
    bytes.extend(samples(1, &each));
    let marks = (0..14).map(|k| (702.0 + 4.0 * f64::from(k), b"\x01\x01S".to_vec()));
    bytes.extend(samples(2, &marks.collect::<Vec<_>>()));
    for k in 0..12 {
        bytes.extend(offset(1, 1000.0 + 5.0 * f64::from(k), 0.0));
    }
    for (time, value) in offsets {
        bytes.extend(offset(2, *time, *value));
    }
    bytes.extend([footer(1), footer(2)].concat());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.xdf");
    std::fs::write(&path, bytes).unwrap();
    (folder, path)
}

fn steady() -> Vec<(f64, f64)> {
    (0..12)
        .map(|k| (700.0 + 5.0 * f64::from(k), 300.0))
        .collect()
}

/// pyxdf 1.17.5 fits one line over a gap below 1 s or 500 samples: 249.92 and 247.17 Hz, markers up to 1.04 s off.
#[test]
fn lost_samples_change_no_rate_and_move_no_marker() {
    // The marker at 6 s lies within the second gap.
    for (lost, count, events) in [(1250..1260, 10, [1, 13]), (1250..1625, 375, [2, 12])] {
        let (_folder, path) = eeg_with_markers(lost.clone(), &steady());
        let whole = part(&path, None);
        assert!((whole.rate().hz() - 250.0).abs() < 1e-6, "{}", whole.rate());
        assert_eq!(whole.len(), 15_000);
        every_four_seconds(&onsets(&whole), 54.0);
        assert_eq!(event_counts(&whole), [("Markers2 S".to_owned(), 14)]);
        // Straight lines stand in the place of what was lost, and the losses say so.
        for (k, value) in whole.channels()[0].samples.iter().enumerate() {
            assert!((value - k as f64).abs() < 1e-9, "{k} {value}");
        }
        let losses = &whole.about.provenance.losses;
        assert_eq!(losses.samples, count);
        let [[from, to]] = losses.stretches_s[..] else {
            unreachable!("{losses:?}");
        };
        let ends = [(from, 1250.0), (to, 1250.0 + count as f64)];
        assert!(
            ends.iter().all(|(s, k)| (s - k / 250.0).abs() < 1e-6),
            "{from} {to}"
        );
        said(
            &whole.about.warnings,
            "missing between the time stamps at 1 place",
        );
        // Epochs must not be cut over them.
        let parts = segments(&path);
        let lengths: Vec<usize> = parts.iter().map(|one| one.recording.len()).collect();
        assert_eq!(lengths, [1250, 13_750 - count as usize]);
        assert!((parts[1].start_s.0 - lost.end as f64 / 250.0).abs() < 1e-6);
        let found: Vec<usize> = parts.iter().map(|one| one.event_samples.len()).collect();
        assert_eq!(found, events);
        let last = parts[1].event_samples.last();
        assert_eq!(last, Some(&(54 * 250 - lost.end as i64)));
    }
}

#[test]
fn parts_after_a_gap_are_parts() {
    let (_folder, path) = eeg_with_markers(7500..9250, &steady());
    let parts = segments(&path);
    let lengths: Vec<usize> = parts.iter().map(|one| one.recording.len()).collect();
    assert_eq!(lengths, [7500, 5750]);
    assert!((parts[1].start_s.0 - 37.0).abs() < 1e-6);
    let events: usize = parts.iter().map(|one| one.event_samples.len()).sum();
    assert_eq!(events, 14);
    let first = part(&path, None);
    assert_eq!(first.len(), 7500);
    said(&first.about.warnings, "2 parts with gaps between them");
    let second = part(&path, Some(2));
    assert_eq!(
        (second.len(), second.channels()[0].samples[0]),
        (5750, 9250.0)
    );
    assert_eq!(onsets(&second).len(), 5);
    let options = |part| ReadOptions {
        part: Some(part),
        ..ReadOptions::default()
    };
    for number in [0, 3] {
        let refused = read_recording(&path, &options(number))
            .unwrap_err()
            .to_string();
        assert!(refused.contains("a part from 1 to 2"), "{refused}");
    }
    assert_eq!(part(&kept("gaps.edf"), Some(3)).len(), 200);
    assert!(read_recording(&kept("plus.edf"), &options(2)).is_err());
}

#[test]
fn wrong_and_missing_clock_offsets_are_said() {
    for (at, by_s) in [(11, 0.5), (11, 3000.0), (0, -0.5)] {
        let mut offsets = steady();
        offsets[at].1 += by_s;
        let (_folder, path) = eeg_with_markers(0..0, &offsets);
        let read = part(&path, None);
        every_four_seconds(&onsets(&read), 54.0);
        said(
            &read.about.warnings,
            "1 of 12 clock offsets of stream `Markers2`",
        );
    }
    let (_folder, path) = eeg_with_markers(0..0, &[]);
    let read = part(&path, None);
    said(
        &read.about.warnings,
        "stream `Markers2` has no clock offsets",
    );
    let (_folder, path) = eeg_with_markers(0..0, &steady());
    assert_eq!(part(&path, None).about.warnings, []);
}

#[test]
fn a_stream_without_a_rate_is_named() {
    let mut bytes = b"XDF:".to_vec();
    bytes.extend(header(1, 2, ["Force", "lab1", "0", "float32"]));
    bytes.extend(samples(1, &[(1.0, vec![0; 8]), (1.1, vec![0; 8])]));
    bytes.extend(footer(1));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.xdf");
    std::fs::write(&path, bytes).unwrap();
    let refused = read_recording(&path, &ReadOptions::default())
        .unwrap_err()
        .to_string();
    assert!(
        refused.contains("`Force1` of no constant rate (nominal_srate 0)"),
        "{refused}"
    );
}

/// A chunk of a later version of the format: what follows it is read, and its bytes are named.
#[test]
fn what_follows_an_unknown_chunk_is_read() {
    let (_folder, path) = eeg_with_markers(0..0, &steady());
    let whole = part(&path, None);
    let bytes = std::fs::read(&path).unwrap();
    let end = 4 + header(1, 1, ["EEG", "lab1", "250", "double64"]).len();
    let with = [&bytes[..end], &chunk(9, &[0; 40]), &bytes[end..]].concat();
    std::fs::write(&path, with).unwrap();
    let read = part(&path, None);
    assert_eq!(read.channels(), whole.channels());
    said(&read.about.warnings, "47 bytes of the file");
}

/// pyxdf 1.17.5: 12 876 and 14 939 samples at 93.23879 and 92.67358 Hz, the second from 411.965 s on; 175 markers.
#[test]
fn a_reset_of_the_clock_keeps_both_parts() {
    let Some(path) = shared_data::shared("data/eeg/xdf/clock_resets.xdf") else {
        return;
    };
    let parts = segments(&path);
    let found: Vec<(usize, f64)> = parts
        .iter()
        .map(|one| (one.recording.len(), one.recording.rate().hz()))
        .collect();
    let [(12_876, first), (14_939, second)] = found[..] else {
        unreachable!("{found:?}");
    };
    assert!(
        (first - 93.238_79).abs() < 1e-5 && (second - 92.673_58).abs() < 1e-5,
        "{found:?}"
    );
    assert!(
        (parts[1].start_s.0 - 411.965_065).abs() < 1e-5,
        "{}",
        parts[1].start_s
    );
    let events: usize = parts.iter().map(|one| one.event_samples.len()).sum();
    assert_eq!(events, 175);
    // Its time stamps wander.
    said(
        &parts[0].recording.about.warnings,
        "leave its constant rate",
    );
    assert!(read_xdf(&path).unwrap().streams[1].residual_s > 0.1);
}

#[test]
fn files_of_the_cases_are_read() {
    let Some(folder) = shared_data::shared("cases") else {
        return;
    };
    for name in [
        "gap40ms_at_5s.xdf",
        "gap1s5_at_5s.xdf",
        "last_offset_off_0.5s.xdf",
    ] {
        let read = part(&folder.join(name), None);
        every_four_seconds(&onsets(&read), 54.0);
        assert!(
            (read.rate().hz() - 250.0).abs() < 1e-6,
            "{name} {}",
            read.rate()
        );
    }
    let counts = event_counts(&part(&folder.join("held_codes.bdf"), None));
    assert_eq!(
        counts,
        [("Status 2".to_owned(), 3), ("Status 8".to_owned(), 3)]
    );
    for (name, text) in [
        ("no_offsets_3s.xdf", "stream `Marks` has no clock offsets"),
        (
            "nrec_too_many.edf",
            "states 12 records of 1 s, and the file holds 10: 2 (2 s) are missing",
        ),
        ("pmin_eq_pmax.edf", "`EEG C4` is left out"),
        ("comma_onset.edf", "`+6,5` as an onset in record"),
        ("outside.vhdr", "`Mk2=Stimulus,S  1,0,1,0` has no position"),
        ("stream_ffff.wav", "the 8001 up to the end"),
        ("two_data.wav", "2 chunks"),
    ] {
        let read = part(&folder.join(name), None);
        said(&read.about.warnings, text);
        if name.ends_with(".wav") {
            // NumPy of the samples that were written.
            let own = &read.channels()[0].samples;
            assert_eq!(own.len(), 8001, "{name}");
            let near =
                (mean(own) - 0.1).abs() < 1e-3 && (standard_deviation(own) - 0.2828).abs() < 1e-3;
            assert!(
                near || name == "two_data.wav",
                "{} {}",
                mean(own),
                standard_deviation(own)
            );
        }
    }
}

fn copied(names: &[&str]) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    for name in names {
        std::fs::copy(kept(name), folder.path().join(name)).unwrap();
    }
    let path = folder.path().join(names[0]);
    (folder, path)
}

fn changed(path: &Path, change: impl Fn(&mut Vec<u8>)) {
    let mut bytes = std::fs::read(path).unwrap();
    change(&mut bytes);
    std::fs::write(path, bytes).unwrap();
}

fn replaced(path: &Path, from: &str, to: &str) {
    changed(path, |bytes| {
        let at = bytes
            .windows(from.len())
            .position(|part| part == from.as_bytes());
        let at = at.unwrap_or_else(|| unreachable!("{from}"));
        bytes.splice(at..at + from.len(), to.bytes());
    });
}

#[test]
fn edf_records_that_are_missing_are_counted() {
    let (_folder, path) = copied(&["plus.edf"]);
    let whole = std::fs::read(&path).unwrap();
    for (cut, field, records, text) in [
        (1, "10", 9, "1 (1 s) are missing; "),
        (whole.len() / 2, "10", 3, "7 (7 s) are missing"),
        (0, "12", 10, "2 (2 s) are missing"),
        (0, "8", 10, "states 8 records of 1 s, and the file holds 10"),
    ] {
        let mut bytes = whole[..whole.len() - cut].to_vec();
        bytes[236..244].copy_from_slice(format!("{field:8}").as_bytes());
        std::fs::write(&path, bytes).unwrap();
        let read = &read_eeg(&path).unwrap().segments[0].recording;
        assert_eq!(read.len(), 100 * records);
        said(&read.about.warnings, text);
        assert_eq!(read.about.provenance.losses.is_interrupted, field != "8");
    }
}

#[test]
fn one_channel_without_scale_leaves_the_others() {
    // Two signals and annotations: the physical minimum, the digital minimum and the digital maximum of C1.
    let physical = 256 + 3 * (16 + 80 + 8);
    let digital = physical + 3 * 16;
    for (at, value, text) in [
        (
            physical,
            "200",
            "its physical minimum, 200, and maximum, 200, give no scale",
        ),
        (
            digital,
            "32767",
            "its digital minimum and maximum are both 32767",
        ),
        (
            digital,
            "40000",
            "its digital minimum, 40000, is above its maximum, 32767",
        ),
    ] {
        let (_folder, path) = copied(&["plus.edf"]);
        changed(&path, |bytes| {
            bytes[at..at + 8].copy_from_slice(format!("{value:8}").as_bytes());
        });
        let read = &read_eeg(&path).unwrap().segments[0].recording;
        let names: Vec<&str> = read.channels().iter().map(|c| c.name.as_str()).collect();
        assert_eq!((names.as_slice(), read.len()), (&["C2"][..], 1000));
        said(&read.about.warnings, &format!("`C1` is left out: {text}"));
    }
}

#[test]
fn one_entry_that_cannot_be_read_leaves_the_others() {
    let (_folder, path) = copied(&["plus.edf"]);
    replaced(&path, "+2.373456", "+2,373456");
    let read = &read_eeg(&path).unwrap().segments[0].recording;
    assert_eq!(read.annotations.events.len(), 2);
    said(&read.about.warnings, "1 annotation(s) cannot be read");
    let files = ["pybv_int16.vhdr", "pybv_int16.vmrk", "pybv_int16.eeg"];
    for (to, text) in [
        (
            "Response,R 25,0,1,0",
            "no position in data points from 1 on",
        ),
        ("Response,R 25,x,1,0", "no position in data points"),
        ("Response,R 25,124,-1,0", "no size in data points"),
        ("Response", "no fields such as"),
    ] {
        let (_folder, path) = copied(&files);
        let markers = path.with_extension("vmrk");
        let text_of = String::from_utf8(std::fs::read(&markers).unwrap()).unwrap();
        let line = text_of
            .lines()
            .find(|line| line.contains("Response"))
            .unwrap();
        let (_, entry) = line.split_once('=').unwrap();
        replaced(&markers, entry, to);
        let whole = read_eeg(&kept(files[0])).unwrap().segments[0]
            .recording
            .clone();
        let read = &read_eeg(&path).unwrap().segments[0].recording;
        assert_eq!(read.channels(), whole.channels());
        assert_eq!(
            read.annotations.events.len() + 1,
            whole.annotations.events.len()
        );
        said(&read.about.warnings, text);
    }
}

/// pyxdf reports no marker of such a stream as one: 4 events at a nominal rate of 10 kHz (pyxdf issue 34).
#[test]
fn markers_with_a_rate_are_markers() {
    let mut bytes = b"XDF:".to_vec();
    bytes.extend(header(1, 1, ["EEG", "lab", "250", "double64"]));
    bytes.extend(header(2, 1, ["Markers", "lab", "10000", "double64"]));
    let each = (0..2500).map(|k| {
        (
            1000.0 + f64::from(k) / 250.0,
            f64::from(k).to_le_bytes().to_vec(),
        )
    });
    bytes.extend(samples(1, &each.collect::<Vec<_>>()));
    let marks = [1.0, 3.0, 5.0, 9.0].map(|at| (1000.0 + at, 7.0_f64.to_le_bytes().to_vec()));
    bytes.extend(samples(2, &marks));
    bytes.extend([footer(1), footer(2)].concat());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.xdf");
    std::fs::write(&path, bytes).unwrap();
    let read = part(&path, None);
    assert_eq!(read.channels().len(), 1);
    let near = |(found, wanted): (f64, f64)| (found - wanted).abs() < 1e-6;
    assert!(
        onsets(&read)
            .into_iter()
            .zip([1.0, 3.0, 5.0, 9.0])
            .all(near)
    );
    assert_eq!(event_counts(&read), [("Markers2 7".to_owned(), 4)]);
}

#[test]
fn files_of_markers_that_are_cut_are_said() {
    let files = ["pybv_int16.vhdr", "pybv_int16.vmrk", "pybv_int16.eeg"];
    let whole = read_eeg(&kept(files[0])).unwrap().segments[0]
        .recording
        .clone();
    let (_folder, path) = copied(&files);
    let markers = path.with_extension("vmrk");
    let text = String::from_utf8(std::fs::read(&markers).unwrap()).unwrap();
    let line = text.lines().rfind(|line| line.starts_with("Mk")).unwrap();
    let position = line.split(',').nth(2).unwrap();
    let at = text.rfind(line).unwrap() + line.find(&format!(",{position},")).unwrap();
    // Within the position, behind it, and behind the comma: there it is whole.
    for (more, left) in [(2, 1), (1 + position.len(), 1), (2 + position.len(), 0)] {
        std::fs::write(&markers, &text[..at + more]).unwrap();
        let read = &read_eeg(&path).unwrap().segments[0].recording;
        let events = &read.annotations.events;
        let same = events.iter().zip(&whole.annotations.events);
        assert!(
            same.into_iter()
                .all(|(one, other)| one.onset_s == other.onset_s)
        );
        if left > 0 {
            said(&read.about.warnings, "the file ends within `Mk");
        }
    }
    std::fs::write(&markers, b"").unwrap();
    let read = &read_eeg(&path).unwrap().segments[0].recording;
    said(&read.about.warnings, "has no section [Marker Infos]");
}

#[test]
fn brainvision_data_that_are_cut_are_read_in_whole_samples() {
    let files = ["pybv_int16.vhdr", "pybv_int16.vmrk", "pybv_int16.eeg"];
    let (_folder, path) = copied(&files);
    let whole = read_eeg(&path).unwrap().segments[0].recording.clone();
    changed(&path.with_extension("eeg"), |bytes| {
        bytes.truncate(bytes.len() - 7)
    });
    let read = read_eeg(&path).unwrap().segments[0].recording.clone();
    assert_eq!(read.len(), whole.len() - 2);
    for (own, of) in read.channels().iter().zip(whole.channels()) {
        assert_eq!(own.samples, of.samples[..read.len()]);
    }
    said(
        &read.about.warnings,
        "5 bytes of an incomplete sample were left out",
    );
    replaced(&path, "[Common Infos]", "[Common Infos]\r\nDataPoints=500");
    let read = read_eeg(&path).unwrap().segments[0].recording.clone();
    said(&read.about.warnings, "states 500: 2 (0.008 s) are missing");
}

#[test]
fn wav_files_with_open_wrong_or_several_sizes_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.wav");
    let own: Vec<f64> = (0..101).map(|k| f64::from(k) / 256.0).collect();
    let reading = |change: &dyn Fn(&mut Vec<u8>)| {
        let format = piezotact_dataset::wav::SampleFormat::Pcm16;
        piezotact_dataset::wav::write_wav(&path, &[&own], 8000, format).unwrap();
        changed(&path, change);
        part(&path, None)
    };
    let size = |size: u32| {
        move |bytes: &mut Vec<u8>| bytes.splice(40..44, size.to_le_bytes()).for_each(drop)
    };
    for stated in [0, u32::MAX, 0x7FFF_F024] {
        let read = reading(&size(stated));
        assert_eq!(read.channels()[0].samples, own);
        said(
            &read.about.warnings,
            "does not state how many samples there are: the 101 up to the end",
        );
    }
    let read = reading(&|bytes| bytes.truncate(bytes.len() - 21));
    assert_eq!(read.channels()[0].samples, own[..90]);
    said(
        &read.about.warnings,
        "states 101 samples of each channel, and the file holds 90: 11 are missing",
    );
    let read = reading(&|bytes| {
        let second = bytes[36..].to_vec();
        bytes.extend(b"LIST\x04\0\0\0abcd");
        bytes.extend(second);
    });
    assert_eq!(
        read.channels()[0].samples,
        [own.clone(), own.clone()].concat()
    );
    said(&read.about.warnings, "2 chunks");
    let read = reading(&|bytes| bytes.extend(b"LIST\x04\0\0\0abcd"));
    assert!(!read.about.warnings.iter().any(|one| one.code == "guessed"));
}
