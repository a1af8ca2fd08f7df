use super::*;
use crate::eeg::{markers_of, write_brainvision};
use piezotact::quantity::{SampleRate, Unit};
use piezotact::recording::{Channel, Condition, EventValue, Provenance, Recording};

/// A BIDS recording of C3 and C4 at 250 Hz.
fn written(folder: &Path) -> PathBuf {
    let channels = ["C3", "C4"].map(|name| Channel {
        name: name.into(),
        unit: Unit::Volt,
        samples: (0..500).map(|i| 1e-5 * f64::from(i % 7)).collect(),
    });
    let rate = SampleRate::new(250.0).unwrap();
    let recording = Recording::new(
        channels.to_vec(),
        rate,
        Condition::default(),
        Provenance::default(),
    )
    .unwrap();
    let path = folder.join("sub-01_ses-eeg_task-control_eeg.vhdr");
    write_brainvision(&path, &recording, &markers_of(&recording)).unwrap();
    path
}

#[test]
fn what_stands_beside_is_held_against_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = written(folder.path());
    let beside = |suffix: &str, text: &str| {
        let name = format!("sub-01_ses-eeg_task-control_{suffix}");
        std::fs::write(folder.path().join(name), text).unwrap();
    };
    let refused = |parts: &[&str]| {
        let text = read_eeg_source(&path).unwrap_err().to_string();
        for part in parts {
            assert!(text.contains(part), "expected `{part}` in: {text}");
        }
    };
    let found = read_eeg_source(&path).unwrap();
    assert_eq!(found.participant.as_deref(), Some("01"));
    assert_eq!(
        (found.task.as_deref(), found.kind.as_str()),
        (Some("control"), "BrainVision")
    );
    beside(
        "eeg.json",
        r#"{"SamplingFrequency": 500, "TaskName": "control"}"#,
    );
    refused(&["expected SamplingFrequency 250", "found 500 Hz"]);
    beside(
        "eeg.json",
        r#"{"SamplingFrequency": 250, "TaskName": "imagery"}"#,
    );
    refused(&["expected TaskName `control`", "found `imagery`"]);
    beside(
        "eeg.json",
        r#"{"SamplingFrequency": 250, "TaskName": "Control"}"#,
    );
    beside(
        "channels.tsv",
        "name\ttype\tunits\nC3\tEEG\tuV\nCz\tEEG\tuV\n",
    );
    refused(&["`Cz` in the table and `C4` in the recording"]);
    beside("channels.tsv", "name\ttype\tunits\nC3\tEEG\tuV\n");
    refused(&["`C4` in the recording alone"]);
    beside(
        "channels.tsv",
        "name\ttype\tunits\nC3\tEEG\tuV\nC4\tEEG\tuV\n",
    );
    assert!(read_eeg_source(&path).is_ok());
}

#[test]
fn the_table_beside_a_file_and_its_own_files_are_known() {
    let folder = tempfile::tempdir().unwrap();
    let path = written(folder.path());
    let table = folder
        .path()
        .join("sub-01_ses-eeg_task-control_channels.tsv");
    let text = "name\ttype\tunits\tstatus\nC3\tEEG\tuV\tbad\nC4\tVEOG\tuV\tn/a\n";
    std::fs::write(&table, text).unwrap();
    let found = read_eeg_source(&path).unwrap().channels;
    let states: Vec<_> = found
        .iter()
        .map(|row| (row.kind.as_deref(), row.status.as_deref()))
        .collect();
    assert_eq!(states, [(Some("EEG"), Some("bad")), (Some("VEOG"), None)]);
    let mut endings: Vec<String> = files_of(&path)
        .iter()
        .map(|file| shown(file).split("control_").nth(1).unwrap().to_owned())
        .collect();
    endings.sort();
    assert_eq!(endings, ["channels.tsv", "eeg.eeg", "eeg.vhdr", "eeg.vmrk"]);
}

#[test]
fn a_table_of_events_gives_the_markers_of_a_file_without_any() {
    let folder = tempfile::tempdir().unwrap();
    let path = written(folder.path());
    let table = folder.path().join("sub-01_ses-eeg_task-control_events.tsv");
    let text = "onset\tduration\ttrial_type\tvalue\n0.403\t0\tcontrol/M8\t2\nn/a\t0\tlost\t1\n1.2\tn/a\tn/a\t8\n-0.1\t0.5\tBAD_start\tn/a\n";
    std::fs::write(&table, text).unwrap();
    let found = read_eeg_source(&path).unwrap();
    assert!(
        found
            .kind
            .ends_with("markers of sub-01_ses-eeg_task-control_events.tsv")
    );
    let [segment] = &found.segments[..] else {
        panic!("one part")
    };
    let said = segment.recording.about.warnings.iter();
    let said: String = said.map(ToString::to_string).collect();
    assert!(said.contains("1 event of "), "{said}");
    assert!(
        said.contains("without an onset or a name (row 3) was left out"),
        "{said}"
    );
    // 0.403 s at 250 Hz lie between two samples, nearer to the later one.
    assert_eq!(segment.event_samples, [101, 300, -25]);
    let events = &segment.recording.annotations.events;
    let names: Vec<String> = events.iter().map(|event| event.kind.clone()).collect();
    assert_eq!(names, ["control/M8", "value", "BAD_start"]);
    assert_eq!(events[1].value, Some(EventValue::Number(8.0)));
    assert!(files_of(&path).contains(&table));
    // Markers of the file itself (one, and the beginning of its part) stay, unless the table is asked for.
    let mut marked = segment.recording.clone();
    marked.annotations.events.truncate(1);
    write_brainvision(&path, &marked, &markers_of(&marked)).unwrap();
    let mut own = read_eeg_source(&path).unwrap();
    assert_eq!(
        (own.kind.as_str(), own.segments[0].event_samples.len()),
        ("BrainVision", 2)
    );
    let beside = own.events.clone().unwrap();
    assert_eq!(
        (beside.events, beside.without_marker, beside.markers),
        (3, 2, 1)
    );
    own.take_events(&table).unwrap();
    assert_eq!(own.events, None);
    assert_eq!(own.segments[0].event_samples, [101, 300, -25]);
    for (text, part) in [
        ("onset\ttrial_type\n1\ta\n", "add the column duration"),
        ("onset\tduration\n1\t0\n", "add the column trial_type"),
        (
            "onset\tduration\ttrial_type\nlate\t0\ta\n",
            "a time in s in row 2",
        ),
        ("onset\tduration\ttrial_type\nn/a\t0\ta\n", "no such row"),
    ] {
        std::fs::write(&table, text).unwrap();
        let said = own.take_events(&table).unwrap_err().to_string();
        assert!(said.contains(part), "{said}");
    }
    // A table without a row is none.
    std::fs::write(&table, "onset\tduration\ttrial_type\n").unwrap();
    assert_eq!(read_eeg_source(&path).unwrap().kind, "BrainVision");
}

#[test]
fn a_recording_that_was_cut_around_markers_has_parts_and_averages_are_none() {
    let folder = tempfile::tempdir().unwrap();
    let path = written(folder.path());
    let header = std::fs::read_to_string(&path).unwrap();
    let stated = |lines: &str| {
        let text = header.replace("[Common Infos]", &format!("[Common Infos]\r\n{lines}"));
        std::fs::write(&path, text).unwrap();
        read_eeg(&path)
    };
    let found = stated("SegmentationType=MARKERBASED\r\nSegmentDataPoints=100").unwrap();
    assert_eq!(found.segments.len(), 5);
    assert_eq!(found.segments[0].recording.about.warnings.len(), 1);
    let refused = |lines: &str, part: &str| {
        let said = stated(lines).unwrap_err().to_string();
        assert!(said.contains(part), "{said}");
    };
    refused("Averaged=YES", "found averages");
    // One sample in each segment would be as many recordings as samples.
    let whole = stated("SegmentationType=NOTSEGMENTED\r\nSegmentDataPoints=1").unwrap();
    assert_eq!(whole.segments.len(), 1);
}

#[test]
fn labels_of_edf_become_names_of_electrodes() {
    let of = |labels: &[&str]| {
        let channels = labels.iter().map(|label| Channel {
            name: (*label).into(),
            unit: Unit::Volt,
            samples: vec![0.0; 8],
        });
        let rate = SampleRate::new(250.0).unwrap();
        let (condition, provenance) = (Condition::default(), Provenance::default());
        let recording = Recording::new(channels.collect(), rate, condition, provenance);
        let mut segments = [EegSegment {
            recording: recording.unwrap(),
            start_s: Seconds(0.0),
            event_samples: Vec::new(),
        }];
        by_electrodes(&mut segments, &mut []);
        let channels = segments[0].recording.channels().iter();
        channels.map(|c| c.name.clone()).collect::<Vec<_>>()
    };
    assert_eq!(
        of(&["EEG C3", "EEG Cz", "EOG left"]),
        ["C3", "Cz", "EOG left"]
    );
    assert_eq!(
        of(&["EEG C3-Ref", "EEG C4-Ref", "Resp"]),
        ["C3", "C4", "Resp"]
    );
    // Pairs of electrodes are kept, and what would share a name.
    assert_eq!(of(&["EEG C3-A2", "EEG C4-A1"]), ["C3-A2", "C4-A1"]);
    assert_eq!(of(&["EEG C3", "C3"]), ["EEG C3", "C3"]);
    assert_eq!(of(&["EEG Fpz-Cz"]), ["Fpz-Cz"]);
}

#[test]
fn positions_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("electrodes.tsv");
    std::fs::write(
        &path,
        "name\tx\ty\tz\nC3\t-0.07\t0\t0.06\nREF\tn/a\tn/a\tn/a\n",
    )
    .unwrap();
    let found = read_electrodes(&path).unwrap();
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].position, [-0.07, 0.0, 0.06]);
    for (text, part) in [
        ("name\tx\ty\n", "add the column z"),
        ("name,x,y,z\nC3,a,0,1\n", "found `a`"),
        ("name,x,y,z\nC3,n/a,0,1\n", "no row with x, y and z"),
    ] {
        std::fs::write(&path, text).unwrap();
        let error = read_electrodes(&path).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    }
}
