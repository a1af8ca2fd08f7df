//! `piezotact eeg` as a black box, on small recordings whose desynchronisation is known.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::path::Path;

use piezotact::quantity::{SampleRate, Seconds, Unit};
use piezotact::recording::{Channel, Condition, Event, EventValue, Provenance, Recording};
use piezotact_dataset::eeg::{markers_of, write_brainvision, write_edf};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};

use crate::support::Folder;

const RATE_HZ: f64 = 200.0;
const NAMES: [&str; 11] = [
    "C3", "Cz", "C4", "FC3", "FC4", "CP3", "CP4", "F3", "F4", "P3", "P4",
];
/// One marker every so many seconds.
const EVERY_S: f64 = 4.0;

/// Uniform numbers from −½ to ½.
fn uniform(seed: u64) -> impl FnMut() -> f64 {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    move || rng.next_u64() as f64 / u64::MAX as f64 - 0.5
}

/// A marker.
fn event(onset_s: f64, kind: &str, value: &str) -> Event {
    Event {
        onset_s: Seconds(onset_s),
        duration_s: Seconds(0.0),
        kind: kind.into(),
        value: Some(EventValue::Text(value.into())),
    }
}

/// Alpha in noise at `names`; its power falls by the share `loss` for a second after each marker at electrodes on the left. Surfaces S 1
/// and S 2 alternate.
fn recording(names: &[&str], epochs: usize, loss: f64, seed: u64) -> Recording {
    let mut draw = uniform(seed);
    let markers: Vec<f64> = (0..epochs).map(|i| 3.0 + EVERY_S * i as f64).collect();
    let samples = ((3.0 + EVERY_S * epochs as f64) * RATE_HZ) as usize;
    let mut gaussian = move || (0..6).map(|_| draw()).sum::<f64>();
    let channels = names.iter().map(|name| {
        let left = ["C3", "FC3", "CP3"].contains(name);
        let (mut re, mut im) = (0.0, 0.0);
        let values = (0..samples).map(|i| {
            let t = i as f64 / RATE_HZ;
            // An amplitude that wanders over about 0.3 s.
            re = 0.985 * re + 0.17 * gaussian();
            im = 0.985 * im + 0.17 * gaussian();
            let inside = markers.iter().any(|m| t >= *m && t < m + 1.0);
            let gain = if left && inside {
                (1.0 - loss).sqrt()
            } else {
                1.0
            };
            let phase = std::f64::consts::TAU * 10.0 * t;
            1e-5 * gain * (re * phase.cos() - im * phase.sin()) + 1.5e-6 * gaussian()
        });
        Channel {
            name: (*name).into(),
            unit: Unit::Volt,
            samples: values.collect(),
        }
    });
    let channels: Vec<Channel> = channels.collect();
    let rate = SampleRate::new(RATE_HZ).unwrap();
    let mut made =
        Recording::new(channels, rate, Condition::default(), Provenance::default()).unwrap();
    let each = markers.iter().enumerate();
    made.annotations.events = each
        .map(|(i, t)| event(*t, "Stimulus", if i % 2 == 0 { "S  1" } else { "S  2" }))
        .collect();
    made
}

fn write(path: &Path, recording: &Recording) {
    write_brainvision(path, recording, &markers_of(recording)).unwrap();
}

/// The words of a command without quotes.
fn run(folder: &Folder, command: &str) -> crate::support::Done {
    let words: Vec<&str> = command.split(' ').collect();
    folder.run(&words)
}

/// A command with the markers of both surfaces.
fn with_events(folder: &Folder, command: &str) -> crate::support::Done {
    let mut words: Vec<&str> = command.split(' ').collect();
    words.extend(["--event", "S  1=M8", "--event", "Stimulus/S 2=BIO"]);
    folder.run(&words)
}

fn read(folder: &Folder, name: &str) -> String {
    std::fs::read_to_string(folder.path(name)).unwrap()
}

#[test]
fn a_file_shows_what_it_holds() {
    let folder = Folder::new();
    let mut made = recording(&["C3", "C4", "E1"], 4, 0.0, 1);
    let mut channels = made.channels().to_vec();
    channels[1].samples.fill(0.0);
    let rate = SampleRate::new(RATE_HZ).unwrap();
    let events = made.annotations.events.clone();
    made = Recording::new(channels, rate, Condition::default(), Provenance::default()).unwrap();
    made.annotations.events = events;
    write(&folder.path("a.vhdr"), &made);
    let done = run(
        &folder,
        "eeg info a.vhdr --report info.html --csv channels.csv",
    );
    done.expect_success();
    for part in [
        "BrainVision: 3 electrodes",
        "200 Hz",
        "2 of 3 names have a position",
        "without a position: E1",
        "Channels that are flat: C4",
        "Stimulus/S 1",
    ] {
        assert!(
            done.out().contains(part),
            "expected `{part}` in: {}",
            done.out()
        );
    }
    // It has no figure: no empty folder is made of them.
    run(
        &folder,
        "eeg info a.vhdr --report other.html --figures drawn",
    )
    .expect_failure(2, &["expected figures in the report for --figures"]);
    assert!(!folder.path("drawn").exists() && !folder.path("other.html").exists());
    let document = run(&folder, "eeg info a.vhdr --json").json();
    assert_eq!(document["schema"], "eeg_info");
    assert_eq!(document["channels"][1]["flat"], true);
    assert_eq!(document["markers"][0]["count"], 2);
    assert!(read(&folder, "info.html").contains("10-10"));
    assert!(read(&folder, "channels.csv").lines().count() == 4);
}

/// Pulses at irregular intervals over ten minutes, on two clocks that are 50 ppm apart.
#[test]
fn the_drift_of_two_clocks_is_found() {
    let folder = Folder::new();
    let mut draw = uniform(3);
    let mut t = 1.0;
    let mut pulses = Vec::new();
    while t < 600.0 {
        pulses.push(t);
        t += 4.0 + 2.0 * draw();
    }
    for (name, kind, drift) in [("a.edf", "pulse", 0.0), ("b.edf", "sync", 50e-6)] {
        let rate = SampleRate::new(100.0).unwrap();
        let channel = Channel {
            name: "C3".into(),
            unit: Unit::Volt,
            samples: (0..60_600).map(|_| 1e-5 * draw()).collect(),
        };
        let mut made = Recording::new(
            vec![channel],
            rate,
            Condition::default(),
            Provenance::default(),
        )
        .unwrap();
        let events = pulses.iter().map(|t| Event {
            onset_s: Seconds(t * (1.0 + drift) + 2e-4 * draw()),
            duration_s: Seconds(0.0),
            kind: kind.into(),
            value: None,
        });
        made.annotations.events = events.collect();
        write_edf(&folder.path(name), &made).unwrap();
    }
    let command =
        "eeg info a.edf --pulses pulse --against b.edf --against-pulses sync --report c.html";
    let document = run(&folder, &format!("{command} --json")).json();
    let clock = &document["clock"];
    let drift = clock["drift_ppm"].as_f64().unwrap();
    assert!((drift - 50.0).abs() < 1.0, "{clock}");
    assert_eq!(clock["matched"].as_u64().unwrap(), pulses.len() as u64);
    assert!(run(&folder, command).out().contains("shared pulses"));
    let few = run(&folder, "eeg info a.edf --pulses sync --against b.edf");
    few.expect_failure(1, &["b.edf", "3 are needed", "only 0 pulses"]);
}

#[test]
fn epochs_are_counted() {
    let folder = Folder::new();
    let mut made = recording(&NAMES[..4], 10, 0.5, 2);
    // A blink in the third epoch, of surface M8.
    let mut channels = made.channels().to_vec();
    let at = (11.0 * RATE_HZ) as usize;
    for i in 0..60 {
        channels[1].samples[at + i] += 4e-4 * (std::f64::consts::PI * i as f64 / 60.0).sin();
    }
    let events = made.annotations.events.clone();
    let rate = SampleRate::new(RATE_HZ).unwrap();
    made = Recording::new(channels, rate, Condition::default(), Provenance::default()).unwrap();
    made.annotations.events = events;
    made.annotations.events.push(event(0.5, "Stimulus", "S  2"));
    write(&folder.path("a.vhdr"), &made);
    let command =
        "eeg epochs a.vhdr --epoch -1.0,0.8 --low-pass 40 --reference average --reject-above 150";
    let done = with_events(&folder, &format!("{command} --report e.html --csv e.csv"));
    done.expect_success();
    assert!(done.out().contains("9 of 11 epochs kept"), "{}", done.out());
    let document = with_events(&folder, &format!("{command} --json")).json();
    let counts = document["counts"]["conditions"].as_array().unwrap();
    assert_eq!(counts[0]["condition"], "M8");
    assert_eq!(
        (counts[0]["kept"].as_u64(), counts[0]["rejected"].as_u64()),
        (Some(4), Some(1))
    );
    assert_eq!(counts[1]["left_out"].as_u64(), Some(1));
    assert_eq!(document["version"], 2);
    let report = read(&folder, "e.html");
    for part in [
        "Reference: average",
        "it begins before the recording",
        "peak-to-peak above 150 µV",
    ] {
        assert!(report.contains(part), "expected `{part}` in the report");
    }
    assert_eq!(read(&folder, "e.csv").lines().nth(1), Some("M8,5,4,1,0"));
    // What is written holds the epochs that are kept, each whole, with its marker, and nothing else.
    with_events(&folder, &format!("{command} --out kept.vhdr")).expect_success();
    let again = "eeg epochs kept.vhdr --epoch -1.0,0.8 --event M8 --event BIO";
    let document = run(&folder, &format!("{again} --json")).json();
    let counts = document["counts"]["conditions"].as_array().unwrap();
    for (of, kept) in counts.iter().zip([4, 5]) {
        let found = ["markers", "kept", "left_out"].map(|key| of[key].as_u64());
        assert_eq!(found, [Some(kept), Some(kept), Some(0)], "{of}");
    }
    let wider = run(&folder, "eeg epochs kept.vhdr --epoch -1.0,0.9 --event M8");
    wider.expect_failure(1, &[]);
    // A marker outside of its epoch has no place; without an epoch nothing is written.
    for (options, code, part) in [
        (
            "--epoch 0.1,0.8 --out o.vhdr",
            2,
            "epochs that hold their marker",
        ),
        ("--epoch -1.0,0.8 --reject-above 1 --out o.vhdr", 1, ""),
        ("--epoch -1.0,0.8 --out o.fif", 2, "vhdr"),
    ] {
        let refused = with_events(&folder, &format!("eeg epochs a.vhdr {options}"));
        refused.expect_failure(code, &[part]);
        assert!(!folder.path("o.vhdr").exists(), "{options}");
    }
}

/// One task of one person: the power at C3 falls by the share that the recording was made with, and not at C4.
#[test]
fn a_known_desynchronisation_is_found() {
    let folder = Folder::new();
    write(
        &folder.path("sub-01_task-control_eeg.vhdr"),
        &recording(&NAMES, 60, 0.6, 5),
    );
    let command = "eeg erd sub-01_task-control_eeg.vhdr --window 0.2,0.8 --out control.json --report erd.html";
    let done = with_events(&folder, command);
    done.expect_success();
    for part in [
        "M8, C3, alpha (8–12 Hz): −",
        "baseline, power averaged over epochs",
        "±80 ms",
        "smear of alpha",
        "30 epochs",
    ] {
        assert!(
            done.out().contains(part),
            "expected `{part}` in: {}",
            done.out()
        );
    }
    let document: serde_json::Value = serde_json::from_str(&read(&folder, "control.json")).unwrap();
    assert_eq!(document["schema"], "eeg_erd");
    for change in document["regions"].as_array().unwrap() {
        let percent = change["percent"].as_f64().unwrap();
        // Thirty epochs of alpha that wanders: the power of an epoch scatters by itself.
        let range = match change["place"] == "C3" {
            true => -75.0..-40.0,
            false => -35.0..35.0,
        };
        assert!(range.contains(&percent), "{change}");
    }
    let report = read(&folder, "erd.html");
    for part in [
        "participant 01, task control",
        "seen from above",
        "One scale",
        "Negative (blue)",
        "over time and frequency",
    ] {
        assert!(report.contains(part), "expected `{part}` in the report");
    }
    // Two surfaces on the scalp, and over time at three electrodes, each in two formats.
    assert_eq!(report.matches("data:image/png").count(), 2 * (2 + 3 * 2));
    let table = with_events(
        &folder,
        "eeg erd sub-01_task-control_eeg.vhdr --csv all.csv --order percent-of-each-epoch",
    );
    table.expect_success();
    assert!(
        table
            .err()
            .contains("percentages of each of 30 epochs were averaged")
    );
    assert!(table.out().contains("biased towards synchronisation"));
    assert_eq!(
        read(&folder, "all.csv").lines().count(),
        1 + 2 * (3 + NAMES.len())
    );
}

/// Six people in two tasks: control loses more power than natural touch, at the left alone.
#[test]
fn tasks_are_compared_over_people() {
    let folder = Folder::new();
    let mut files = Vec::new();
    for person in 1..=6u64 {
        for (task, loss) in [("natural", 0.2), ("control", 0.7)] {
            let name = format!("sub-{person:02}_task-{task}_eeg.vhdr");
            let loss = loss + 0.02 * person as f64 - 0.07;
            let seed = 100 * person + u64::from(task == "control");
            write(&folder.path(&name), &recording(&NAMES, 40, loss, seed));
            let out = format!("{person}_{task}.json");
            with_events(
                &folder,
                &format!("eeg erd {name} --window 0.2,0.8 --out {out}"),
            )
            .expect_success();
            files.push(out);
        }
    }
    let all = files.join(" ");
    let command = format!("eeg stats {all} --gradient control,natural");
    let done = run(
        &folder,
        &format!("{command} --report stats.html --csv contrasts.csv"),
    );
    done.expect_success();
    for part in [
        "epochs of each participant and surface, control",
        "control > natural (C3, alpha): holds",
        "control and natural: differ somewhere",
        "natural − control",
    ] {
        assert!(
            done.out().contains(part),
            "expected `{part}` in: {}",
            done.out()
        );
    }
    let document = run(&folder, &format!("{command} --json")).json();
    assert_eq!(document["schema"], "eeg_stats");
    let contrast = &document["contrasts"][2];
    assert_eq!(contrast["surface"], "mean of surfaces");
    let criterion = &contrast["criteria"][0];
    assert_eq!(criterion["outcome"], "met");
    assert!(contrast["contrast"]["difference"]["mean"].as_f64().unwrap() > 30.0);
    let cluster = &document["clusters"][0]["clusters"][0];
    assert!(cluster["p_value"].as_f64().unwrap() <= 0.05, "{cluster}");
    let report = read(&folder, "stats.html");
    for part in [
        "6 participants, tasks control, natural",
        "all 32 sign flips were tried",
        "n = 6: they differ",
        "natural − control, mean of surfaces, C4, alpha",
        "Figure 97 of the thesis",
        "Figure 96 of the thesis",
        "need a model of the head",
    ] {
        assert!(report.contains(part), "expected `{part}` in the report");
    }
    // Half of the people decide nothing; one person in one task is no comparison.
    let few = run(&folder, &format!("eeg stats {}", files[..4].join(" ")));
    few.expect_success();
    assert!(few.out().contains("not decided"), "{}", few.out());
    run(&folder, "eeg stats 1_control.json").expect_failure(1, &["at least two tasks"]);
    run(
        &folder,
        "eeg stats 1_control.json 1_control.json 1_natural.json",
    )
    .expect_failure(1, &["participant 01, task control", "give one of them"]);
    run(
        &folder,
        "eeg stats 1_control.json 1_natural.json --gradient control,imagery",
    )
    .expect_failure(2, &["imagery"]);
    earlier_documents_are_refused(&folder, "1_control.json");
    let done = with_events(
        &folder,
        "eeg erd sub-01_task-control_eeg.vhdr --window 0.3,0.8 --out other.json",
    );
    done.expect_success();
    run(&folder, "eeg stats other.json 1_natural.json").expect_failure(1, &["differ in window"]);
}

/// Documents of the first version are made again; those that independent components cleaned are named.
fn earlier_documents_are_refused(folder: &Folder, name: &str) {
    let mut document: serde_json::Value = serde_json::from_str(&read(folder, name)).unwrap();
    let fields = document.as_object_mut().unwrap();
    fields.remove("invocation");
    fields.insert("version".into(), 1.into());
    let refused = |name: &str, parts: &[&str], document: &serde_json::Value| {
        folder.write(name, document.to_string().as_bytes());
        run(folder, &format!("eeg stats {name} {name}")).expect_failure(1, parts);
    };
    let again = "make it again with `piezotact eeg erd`";
    let version = "expected version 3 of the document `eeg_erd`, found version 1";
    refused("v1.json", &["v1.json", version, again], &document);
    document["eye_components"] = serde_json::json!({ "iterations": 9 });
    let parts = [
        "ica.json",
        version,
        "independent components",
        "docs/guide/mne.md",
    ];
    refused("ica.json", &parts, &document);
}

#[test]
fn bad_input_is_named() {
    let folder = Folder::new();
    let good = recording(&NAMES[..3], 6, 0.5, 9);
    write(&folder.path("a.vhdr"), &good);
    let erd = "eeg erd a.vhdr --participant P01 --task control";
    // Markers.
    run(&folder, erd).expect_failure(2, &["a.vhdr", "state the markers", "Stimulus/S 1 (3)"]);
    run(&folder, &format!("{erd} --event S3")).expect_failure(1, &["`S3`", "Stimulus/S 2 (3)"]);
    let mut none = good.clone();
    none.annotations.events.clear();
    write(&folder.path("none.vhdr"), &none);
    run(&folder, "eeg epochs none.vhdr --event touch")
        .expect_failure(1, &["none.vhdr", "no marker at all", "triggers"]);
    // Who and what.
    with_events(&folder, "eeg erd a.vhdr --task control --min-epochs 3")
        .expect_failure(2, &["participant", "--participant"]);
    // Too few epochs.
    with_events(&folder, erd).expect_failure(1, &["at least 10 epochs of M8, found 3"]);
    // Wavelets.
    with_events(
        &folder,
        &format!("{erd} --min-epochs 3 --cycles 20 --epoch -1.6,0.9"),
    )
    .expect_failure(1, &["a.vhdr", "wavelet"]);
    // A renamed channel.
    with_events(
        &folder,
        &format!("{erd} --min-epochs 3 --region left=C3,C1"),
    )
    .expect_failure(2, &["region left", "C1"]);
    with_events(&folder, "eeg epochs a.vhdr --channels C3,CZ")
        .expect_failure(1, &["`CZ`", "C3, Cz, C4"]);
    // Positions of other channels.
    let rows: String = (0..9)
        .map(|i| format!("E{i}\t{}\t{}\t{}\n", i % 3, i % 2, i * i))
        .collect();
    folder.write("electrodes.tsv", format!("name\tx\ty\tz\n{rows}"));
    with_events(
        &folder,
        &format!("{erd} --min-epochs 3 --electrodes electrodes.tsv"),
    )
    .expect_failure(
        1,
        &["expected positions of the channels C3, Cz, C4", "E0, E1"],
    );
    // No part of the recording is replaced, whatever is asked for.
    for part in ["a.eeg", "a.vmrk"] {
        with_events(&folder, &format!("eeg epochs a.vhdr --force --csv {part}"))
            .expect_failure(2, &[part, "is read and would be replaced"]);
    }
    // Half a file of samples: the epochs beyond its end are not whole.
    let samples = std::fs::read(folder.path("a.eeg")).unwrap();
    folder.write("a.eeg", &samples[..samples.len() / 2]);
    with_events(&folder, erd)
        .expect_failure(1, &["at least 10 epochs", "it ends after the recording"]);
}

#[test]
fn bad_channels_and_sidecars_are_named() {
    let folder = Folder::new();
    let good = recording(&NAMES[..3], 6, 0.5, 9);
    let with = |change: &dyn Fn(f64) -> f64| {
        let mut channels = good.channels().to_vec();
        channels[2].samples = channels[2].samples.iter().map(|v| change(*v)).collect();
        let rate = SampleRate::new(RATE_HZ).unwrap();
        let mut made =
            Recording::new(channels, rate, Condition::default(), Provenance::default()).unwrap();
        made.annotations = good.annotations.clone();
        made
    };
    write(&folder.path("flat.vhdr"), &with(&|_| 0.0));
    with_events(&folder, "eeg epochs flat.vhdr")
        .expect_failure(1, &["C4 never changed", "leave C4 out"]);
    with_events(&folder, "eeg epochs flat.vhdr --without C4").expect_success();
    write(&folder.path("limit.vhdr"), &with(&|v| v.min(4e-6)));
    with_events(&folder, "eeg epochs limit.vhdr").expect_failure(1, &["C4 is at the limit"]);
    let name = "sub-01_task-control_eeg";
    write(&folder.path(&format!("{name}.vhdr")), &good);
    folder.write(&format!("{name}.json"), r#"{"SamplingFrequency": 1000}"#);
    let erd = format!("eeg erd {name}.vhdr --min-epochs 3");
    with_events(&folder, &erd).expect_failure(1, &[".json", "200", "found 1000 Hz"]);
    folder.write(&format!("{name}.json"), r#"{"SamplingFrequency": 200}"#);
    with_events(&folder, &format!("{erd} --task imagery"))
        .expect_failure(2, &["expected task imagery, found control"]);
    with_events(&folder, &format!("{erd} --report erd.html")).expect_success();
    assert!(read(&folder, "erd.html").contains("No scalp map is drawn: 3 of 3"));
    // Two tasks in one file.
    let mut both = good.clone();
    both.annotations
        .events
        .insert(0, event(0.0, "task", "control"));
    both.annotations.events.push(event(14.0, "task", "imagery"));
    write(&folder.path("both.vhdr"), &both);
    with_events(
        &folder,
        "eeg erd both.vhdr --participant P01 --min-epochs 1",
    )
    .expect_failure(2, &["found control, imagery"]);
    let one = with_events(&folder, "eeg epochs both.vhdr --task imagery --json").json();
    let kept = |i: usize| one["counts"]["conditions"][i]["markers"].as_u64().unwrap();
    assert_eq!((kept(0), kept(1)), (1, 2));
}

/// A table of channels calls C3 bad, and a table of events names the surfaces.
#[test]
fn bad_electrodes_are_interpolated_and_markers_come_from_a_table() {
    let folder = Folder::new();
    let mut made = recording(&NAMES, 8, 0.5, 4);
    let name = "sub-01_task-control";
    let mut table = "onset\tduration\ttrial_type\n".to_owned();
    for (i, event) in made.annotations.events.iter().enumerate() {
        let surface = ["M8", "BIO"][i % 2];
        table.push_str(&format!("{}\t0\t{surface}\n", event.onset_s.0));
    }
    made.annotations.events.clear();
    write(&folder.path(&format!("{name}_eeg.vhdr")), &made);
    let rows = NAMES.map(|name| {
        let status = if name == "C3" { "bad" } else { "good" };
        format!("{name}\tEEG\tuV\t{status}\n")
    });
    let channels = format!("name\ttype\tunits\tstatus\n{}", rows.concat());
    folder.write(&format!("{name}_channels.tsv"), channels.as_bytes());
    let command = format!("eeg epochs {name}_eeg.vhdr --epoch -1.0,0.8");
    let surfaces = " --event M8 --event BIO";
    run(&folder, &format!("{command}{surfaces}"))
        .expect_failure(1, &["expected markers `M8`", "found no marker at all"]);
    folder.write("events.tsv", table.as_bytes());
    let of_table = format!("{command}{surfaces} --events events.tsv");
    let left_out = run(&folder, &format!("{of_table} --json")).json();
    assert_eq!(left_out["channels"].as_array().unwrap().len(), 10);
    let is_left_out = |warning: &serde_json::Value| {
        warning["code"] == "eeg_electrodes_left_out" && warning["why"] == "called_bad"
    };
    let warnings = left_out["warnings"].as_array().unwrap();
    assert!(warnings.iter().any(is_left_out), "{left_out}");
    run(
        &folder,
        &format!("{of_table} --interpolate bad --report r.html"),
    )
    .expect_success();
    assert!(read(&folder, "r.html").contains("Interpolated by spherical splines: C3"));
    assert!(read(&folder, "r.html").contains("interpolated from 10 electrodes"));
    // Beside the file the table is found without being named.
    folder.write(&format!("{name}_events.tsv"), table.as_bytes());
    let found = run(
        &folder,
        &format!("{command}{surfaces} --interpolate bad --json"),
    )
    .json();
    assert_eq!(found["channels"][0], "C3");
    assert_eq!(found["counts"]["conditions"][0]["kept"], 4);
    let warnings = found["warnings"].as_array().unwrap();
    assert!(
        warnings.len() == 1
            && warnings[0]["code"] == "eeg_electrodes_doubtful"
            && warnings[0]["fault"] == "interpolated",
        "{found}"
    );
    let info = run(&folder, &format!("eeg info {name}_eeg.vhdr"));
    assert!(
        info.out()
            .contains("markers of sub-01_task-control_events.tsv"),
        "{}",
        info.out()
    );
}
