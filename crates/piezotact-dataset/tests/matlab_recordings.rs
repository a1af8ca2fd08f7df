//! Recordings as laboratories save them in MATLAB: structures, cells, channels of several rates; in version 7 and in 7.3.
#![allow(
    clippy::unwrap_used,
    reason = "a test that fails where it cannot go on"
)]

use std::path::Path;

use crate::matlab::parse;
use crate::shared_data;
use crate::support::Lcg;
use piezotact::quantity::Unit;
use piezotact::recording::Recording;
use piezotact_dataset::matlab::{MatValue, parse_mat};
use piezotact_dataset::{ReadOptions, read_recording};

fn element(kind: u32, data: &[u8]) -> Vec<u8> {
    let mut whole = [kind, data.len() as u32].map(u32::to_le_bytes).concat();
    whole.extend(data);
    whole.resize(whole.len().next_multiple_of(8), 0);
    whole
}

/// An array of version 5, whose content follows its name.
fn array(name: &str, class: u32, dims: [usize; 2], content: &[u8]) -> Vec<u8> {
    let dims = dims.map(|length| (length as u32).to_le_bytes()).concat();
    let head = [
        element(6, &[class, 0].map(u32::to_le_bytes).concat()),
        element(5, &dims),
        element(1, name.as_bytes()),
    ];
    element(14, &[&head.concat(), content].concat())
}

fn numbers(name: &str, dims: [usize; 2], values: &[f64]) -> Vec<u8> {
    let bytes: Vec<u8> = values
        .iter()
        .flat_map(|value| value.to_le_bytes())
        .collect();
    array(name, 6, dims, &element(9, &bytes))
}

pub(crate) fn column(name: &str, values: &[f64]) -> Vec<u8> {
    numbers(name, [values.len(), 1], values)
}

pub(crate) fn text(name: &str, value: &str) -> Vec<u8> {
    array(
        name,
        4,
        [1, value.chars().count()],
        &element(16, value.as_bytes()),
    )
}

pub(crate) fn cells(name: &str, values: &[Vec<u8>]) -> Vec<u8> {
    array(name, 1, [1, values.len()], &values.concat())
}

/// Structures with these fields, the values of the first element first.
pub(crate) fn structures(name: &str, fields: &[&str], elements: &[Vec<Vec<u8>>]) -> Vec<u8> {
    let names: Vec<u8> = fields
        .iter()
        .flat_map(|field| {
            let mut name = field.as_bytes().to_vec();
            name.resize(32, 0);
            name
        })
        .collect();
    let content = [element(5, &32_u32.to_le_bytes()), element(1, &names)].concat();
    let values: Vec<u8> = elements.concat().concat();
    array(name, 2, [1, elements.len()], &[content, values].concat())
}

fn file_of(arrays: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = b"MATLAB 5.0 MAT-file".to_vec();
    bytes.resize(124, b' ');
    bytes.extend([0, 1]);
    bytes.extend(b"IM");
    bytes.extend(arrays.concat());
    bytes
}

pub(crate) fn read(arrays: &[Vec<u8>]) -> Result<Recording, String> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.mat");
    std::fs::write(&file, file_of(arrays)).unwrap();
    let contents = read_recording(&file, &ReadOptions::default());
    contents
        .map(|contents| contents.recording)
        .map_err(|error| error.to_string())
}

/// The channels: name, rate in Hz, start in s, samples.
fn channels(recording: &Recording) -> Vec<(&str, f64, f64, &[f64])> {
    (recording.channels_with_clocks())
        .map(|(channel, clock)| {
            let (hz, start_s) = (clock.rate_hz.hz(), clock.start_s.0);
            (
                channel.name.as_str(),
                hz,
                start_s,
                channel.samples.as_slice(),
            )
        })
        .collect()
}

pub(crate) fn says(recording: &Recording, part: &str) -> bool {
    let mut warnings = recording.about.warnings.iter();
    warnings.any(|warning| warning.to_string().contains(part))
}

#[test]
fn a_structure_for_each_channel_has_its_own_rate_unit_and_name() {
    let fields = ["data", "fs", "unit", "name"];
    let channel = |values: &[f64], fs: f64, unit: &str, name: &str| {
        vec![
            column("", values),
            column("", &[fs]),
            text("", unit),
            text("", name),
        ]
    };
    let acc = channel(&[1.0, 2.0, 3.0, 4.0], 1000.0, "g", "Finger");
    let force = channel(&[0.5, 0.25], 500.0, "N", "");
    let recording = read(&[
        structures("acc", &fields, &[acc]),
        structures("force", &fields, &[force]),
        column("calibration", &[1.0, 2.0, 3.0]),
    ])
    .unwrap();
    let g = 9.80665;
    assert_eq!(
        channels(&recording),
        [
            ("Finger", 1000.0, 0.0, &[g, 2.0 * g, 3.0 * g, 4.0 * g][..]),
            ("force", 500.0, 0.0, &[0.5, 0.25]),
        ]
    );
    assert_eq!(recording.channels()[0].unit, Unit::MetrePerSecondSquared);
    assert_eq!(recording.channels()[1].unit, Unit::Newton);
    assert!(says(
        &recording,
        "no time and no rate and were left out: calibration"
    ));
}

/// What is not as long as the time of a file is no channel on its clock, unless it has its own rate.
#[test]
fn a_time_holds_for_structures_within_it() {
    let arrays = [
        column("t", &[0.0, 0.1, 0.2]),
        column("acc", &[1.0, 2.0, 3.0]),
        column("fs", &[10.0]),
        structures("cal", &["points"], &[vec![column("", &[1.0, 2.0])]]),
        structures("rec", &["fz"], &[vec![column("", &[4.0, 5.0, 6.0])]]),
        structures(
            "eye",
            &["x", "fs"],
            &[vec![column("", &[7.0, 8.0]), column("", &[5.0])]],
        ),
    ];
    let recording = read(&arrays).unwrap();
    assert_eq!(
        channels(&recording),
        [
            ("acc", 10.0, 0.0, &[1.0, 2.0, 3.0][..]),
            ("rec.fz", 10.0, 0.0, &[4.0, 5.0, 6.0]),
            ("eye", 5.0, 0.0, &[7.0, 8.0]),
        ]
    );
    assert!(says(
        &recording,
        "not as long as the time (3) and were left out: cal.points"
    ));
}

/// A tracker with times of its own beside sensors with a rate alone keeps its start, and what is assumed of the sensors is said.
#[test]
fn a_time_beside_a_rate_keeps_its_start() {
    let sensor = structures(
        "sensor",
        &["acc", "fs"],
        &[vec![column("", &[1.0, 2.0, 3.0, 4.0]), column("", &[10.0])]],
    );
    let tracker = |from_s: f64| {
        let t = [0.0, 0.2, 0.4].map(|t| t + from_s);
        let fields = vec![column("", &[7.0, 8.0, 9.0]), column("", &t)];
        structures("tracker", &["x", "t"], &[fields])
    };
    for from_s in [0.0, 0.3] {
        let recording = read(&[sensor.clone(), tracker(from_s)]).unwrap();
        let starts: Vec<(&str, f64)> = (channels(&recording).into_iter())
            .map(|(name, _, start_s, _)| (name, (start_s * 1e9).round() / 1e9))
            .collect();
        assert_eq!(starts, [("sensor.acc", 0.0), ("tracker", from_s)]);
        let assumed = "`sensor.acc` has a rate and no time, and is taken to begin at 0 s";
        assert_eq!(says(&recording, assumed), from_s > 0.0);
    }
}

/// LabVIEW's waveforms, and what converters of TDMS to MATLAB write.
#[test]
fn waveforms_and_tables_of_properties_of_labview_are_read() {
    let recording = read(&[structures(
        "wave",
        &["t0", "dt", "Y"],
        &[vec![
            column("", &[0.0]),
            column("", &[0.01]),
            column("", &[1.0, 2.0, 3.0]),
        ]],
    )])
    .unwrap();
    assert_eq!(
        channels(&recording),
        [("wave", 100.0, 0.0, &[1.0, 2.0, 3.0][..])]
    );

    let property = |name: &str, value: Vec<u8>| vec![text("", name), value];
    let properties = |dt: f64| {
        let list = [
            property("wf_increment", column("", &[dt])),
            property("unit_string", text("", "N")),
        ];
        structures("", &["Name", "Value"], &list)
    };
    let fields = ["Name", "Data", "Property"];
    let recording = read(&[structures(
        "MeasuredData",
        &fields,
        &[
            vec![text("", "Root"), column("", &[]), cells("", &[])],
            vec![
                text("", "run/fz"),
                column("", &[1.0, 2.0, 3.0, 4.0]),
                properties(0.25),
            ],
            vec![text("", "run/fx"), column("", &[5.0, 6.0]), properties(0.5)],
        ],
    )])
    .unwrap();
    assert_eq!(
        channels(&recording),
        [
            ("run/fz", 4.0, 0.0, &[1.0, 2.0, 3.0, 4.0][..]),
            ("run/fx", 2.0, 0.0, &[5.0, 6.0]),
        ]
    );
}

#[test]
fn runs_in_cells_and_arrays_of_structures_keep_their_lengths() {
    let strokes = [column("", &[1.0, 2.0]), column("", &[3.0, 4.0, 5.0])];
    let recording = read(&[cells("strokes", &strokes), column("fs", &[10.0])]).unwrap();
    assert_eq!(
        channels(&recording),
        [
            ("strokes{1}", 10.0, 0.0, &[1.0, 2.0][..]),
            ("strokes{2}", 10.0, 0.2, &[3.0, 4.0, 5.0]),
        ]
    );
    assert!(says(&recording, "one after the other"));
    // Of one length they may be channels that were taken together.
    let together = [column("", &[1.0, 2.0]), column("", &[3.0, 4.0])];
    let recording = read(&[cells("c", &together), column("fs", &[10.0])]).unwrap();
    assert_eq!(recording.clocks().len(), 1);
    // A time for each run.
    let times = [column("", &[0.0, 0.5]), column("", &[2.0, 2.25, 2.5])];
    let recording = read(&[cells("acc", &strokes), cells("t", &times)]).unwrap();
    assert_eq!(
        channels(&recording),
        [
            ("acc{1}", 2.0, 0.0, &[1.0, 2.0][..]),
            ("acc{2}", 4.0, 2.0, &[3.0, 4.0, 5.0]),
        ]
    );
    let run = |values: &[f64]| vec![column("", values), text("", "S1")];
    let recording = read(&[
        structures(
            "run",
            &["acc", "sample"],
            &[run(&[1.0, 2.0, 3.0]), run(&[4.0, 5.0])],
        ),
        column("fs", &[10.0]),
    ])
    .unwrap();
    let names: Vec<&str> = channels(&recording)
        .iter()
        .map(|channel| channel.0)
        .collect();
    assert_eq!(names, ["run(1).acc", "run(2).acc"]);
    // What stands beside runs is no run: its length is wrong.
    let refused = read(&[
        column("a", &[1.0; 3]),
        column("b", &[1.0; 4]),
        cells("strokes", &strokes),
        column("fs", &[10.0]),
    ]);
    assert!(refused.unwrap_err().contains("one length"));
}

/// DewesoftX writes a time for each channel, and the units in a table.
#[test]
fn each_channel_of_dewesoft_has_its_own_time() {
    let info = |name: &str, unit: &str| vec![text("", name), text("", unit)];
    let fast: Vec<f64> = (0..6).map(|k| f64::from(k) / 1000.0).collect();
    let slow: Vec<f64> = (0..3).map(|k| f64::from(k) / 500.0).collect();
    let late: Vec<f64> = slow.iter().map(|t| t + 0.5).collect();
    let arrays = [
        column("Data1_time_acc", &fast),
        column("Data1_acc", &[1.0; 6]),
        column("Data1_time_fz", &slow),
        column("Data1_fz", &[2.0; 3]),
        column("Data1_time_late", &late),
        column("Data1_late", &[3.0; 3]),
        column("Sample_rate", &[1000.0]),
        structures(
            "Channel_info",
            &["name", "unit"],
            &[info("acc", "g"), info("fz", "mN"), info("late", "N")],
        ),
    ];
    let recording = read(&arrays).unwrap();
    assert_eq!(
        channels(&recording),
        [
            ("Data1_acc", 1000.0, 0.0, &[9.80665; 6][..]),
            ("Data1_fz", 500.0, 0.0, &[2e-3; 3]),
            ("Data1_late", 500.0, 0.5, &[3.0; 3]),
        ]
    );
    assert!(
        !says(&recording, "Sample_rate"),
        "{:?}",
        recording.about.warnings
    );
    // One whose time jumps is left out, and that is said.
    let mut jumps = fast.clone();
    jumps[3] += 7.0;
    jumps[4] += 7.0;
    jumps[5] += 7.0;
    let other = [
        column("Data1_time_can", &jumps),
        column("Data1_can", &[0.0; 6]),
    ];
    let recording = read(&[arrays.as_slice(), &other].concat()).unwrap();
    assert_eq!(recording.channels().len(), 3);
    assert!(says(&recording, "Data1_can was left out"));
}

/// What a file says of the units of its rates and times, and where it contradicts itself.
#[test]
fn units_of_rates_and_times_are_those_stated_beside_them() {
    let acc = || column("acc", &[1.0; 40]);
    let half_ms: Vec<f64> = (0..40).map(|k| 0.5 * f64::from(k)).collect();
    for other in [
        vec![column("fs", &[2.0]), text("fs_unit", "kHz")],
        vec![column("fs_khz", &[2.0])],
        vec![column("dt", &[0.5]), text("dt_unit", "ms")],
        vec![
            column("wf_increment", &[0.5]),
            text("wf_xunit_string", "ms"),
        ],
        vec![column("t", &half_ms), text("t_unit", "ms")],
        vec![column("time_ms", &half_ms)],
        vec![column("fs", &[2000.0]), column("dt", &[5e-4])],
    ] {
        let recording = read(&[vec![acc()], other].concat()).unwrap();
        assert_eq!(recording.rate().hz(), 2000.0);
        assert!(
            !says(&recording, "read as"),
            "{:?}",
            recording.about.warnings
        );
    }
    let refused = read(&[acc(), column("fs", &[1000.0]), column("dt", &[5e-4])]).unwrap_err();
    assert!(
        refused.contains("`fs` states 1000 Hz, found 2000 Hz of `dt`"),
        "{refused}"
    );
    let refused = read(&[acc(), column("fs", &[2.0]), text("fs_unit", "mm")]).unwrap_err();
    assert!(refused.contains("`fs` in Hz or kHz, found mm"), "{refused}");
    let scaled = read(&[
        acc(),
        column("fs", &[2000.0]),
        column("sensitivity", &[0.1]),
    ])
    .unwrap();
    assert!(
        says(&scaled, "not applied: `sensitivity` (0.1)"),
        "{:?}",
        scaled.about.warnings
    );
}

#[test]
fn a_dewesoft_export_has_the_values_of_scipy() {
    let Some(path) = shared_data::shared("cases/dewesoft_like.mat") else {
        return;
    };
    let contents = read_recording(&path, &ReadOptions::default()).unwrap();
    let recording = contents.recording;
    let found = channels(&recording);
    assert_eq!(
        (found[0].0, found[0].1, found[0].3.len()),
        ("Data1_acc", 1000.0, 2000)
    );
    assert_eq!(
        (found[1].0, found[1].1, found[1].3.len()),
        ("Data1_fz", 500.0, 1000)
    );
    assert_eq!(found[0].3[..3], [2.5, 2.89, 3.27]);
    assert_eq!(recording.channels()[0].unit, Unit::MetrePerSecondSquared);
    assert_eq!(recording.channels()[1].unit, Unit::Newton);
}

#[test]
fn a_matrix_has_its_time_in_its_first_column_and_the_names_beside_it() {
    let data = [0.0, 0.1, 0.2, 0.3, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0];
    let matrix = numbers("data", [4, 3], &data);
    let recording = read(std::slice::from_ref(&matrix)).unwrap();
    assert_eq!(
        channels(&recording),
        [
            ("data 2", 10.0, 0.0, &[1.0, 2.0, 3.0, 4.0][..]),
            ("data 3", 10.0, 0.0, &[5.0, 6.0, 7.0, 8.0]),
        ]
    );
    assert!(says(&recording, "read as their time"));
    let names = cells(
        "names",
        &[text("", "time"), text("", "acc"), text("", "force")],
    );
    let units = cells("units", &[text("", "s"), text("", "g"), text("", "N")]);
    let recording = read(&[matrix.clone(), names, units]).unwrap();
    assert_eq!(recording.channels()[0].name, "acc");
    assert_eq!(recording.channels()[0].samples[0], 9.80665);
    assert_eq!(recording.channels()[1].unit, Unit::Newton);
    // One unit for all columns of one matrix; for two variables it is not known whose it is.
    let unit = || text("unit", "g");
    let recording = read(&[matrix.clone(), unit()]).unwrap();
    assert_eq!(recording.channels()[1].samples[0], 5.0 * 9.80665);
    let pair = |name: &str| column(name, &[1.0, 2.0]);
    let recording = read(&[pair("acc"), pair("fz"), unit(), column("fs", &[9.0])]).unwrap();
    assert_eq!(recording.channels()[0].samples[0], 1.0);
    assert!(says(&recording, "`unit` states g for 2 variables"));
    // With another rate beside it, a first column that rises is a channel.
    let recording = read(&[matrix, column("fs", &[500.0])]).unwrap();
    assert_eq!(recording.channels().len(), 3);
}

#[test]
fn what_is_no_channel_is_named() {
    let complex = {
        let mut whole = column("spectrum", &[1.0, 2.0, 3.0]);
        // The flag of complex numbers, and their imaginary parts.
        whole[17] |= 8;
        whole.extend(element(9, &[0; 24]));
        let length = (whole.len() - 8) as u32;
        whole[4..8].copy_from_slice(&length.to_le_bytes());
        whole
    };
    let recording = read(&[
        column("acc", &[1.0, 2.0, 3.0]),
        complex,
        column("fs", &[9.0]),
    ])
    .unwrap();
    assert_eq!(recording.channels().len(), 1);
    assert!(says(&recording, "left out: spectrum (3×1 complex)"));
}

/// The opaque object that MATLAB writes: flags, name, system, class, and numbers of its own.
fn object(name: &str, class: &str) -> Vec<u8> {
    let parts = [
        element(6, &[17_u32, 0].map(u32::to_le_bytes).concat()),
        element(1, name.as_bytes()),
        element(1, b"MCOS"),
        element(1, class.as_bytes()),
        numbers("", [1, 2], &[1.0, 2.0]),
    ];
    element(14, &parts.concat())
}

#[test]
fn objects_of_classes_are_named_with_how_to_save_them() {
    let vectors = || vec![column("acc", &[1.0, 2.0, 3.0]), column("fs", &[9.0])];
    for (class, how) in [
        ("table", "table2struct(x, 'ToScalar', true)"),
        ("datetime", "t = seconds(x - x(1))"),
        ("string", "x = cellstr(x)"),
        ("Sensor", "as vectors"),
    ] {
        let recording = read(&[vectors(), vec![object("x", class)]].concat()).unwrap();
        assert_eq!(recording.channels().len(), 1);
        assert!(says(
            &recording,
            &format!("`x`, an object of the class {class}, was left out")
        ));
        assert!(says(&recording, how), "{class}");
    }
    assert!(!says(&read(&vectors()).unwrap(), "object"));
    // A time that is one: no rate.
    let refused = read(&[column("acc", &[1.0, 2.0]), object("t", "datetime")]).unwrap_err();
    assert!(
        refused.contains("--rate, or save it in MATLAB as seconds"),
        "{refused}"
    );
}

#[test]
fn a_table_is_refused_with_how_to_save_its_columns() {
    let refused = read(&[object("T", "table")]).unwrap_err();
    for part in [
        "T (an object of the class table)",
        "table2struct(T, 'ToScalar', true)",
    ] {
        assert!(refused.contains(part), "{refused}");
    }
}

/// One content that h5py wrote as version 7.3 and SciPy as version 7 (`golden/matlab.py`).
#[test]
fn version_7_3_says_the_same_as_version_7() {
    let kept = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden");
    let [newer, older] = ["h5py73.mat", "scipy7.mat"].map(|name| parse(&kept.join(name)).unwrap());
    assert_eq!(newer.variables.len(), 8);
    for variable in &newer.variables {
        assert_eq!(
            Some(&variable.value),
            older.get(&variable.name),
            "{}",
            variable.name
        );
    }
}

/// The files of matio, whose twins MATLAB itself wrote.
#[test]
fn twins_of_matlab_say_the_same() {
    for (newer, older) in [
        ("test_basic_v73.mat", "test_basic_v7.mat"),
        ("test_string_v73.mat", "test_string_v7.mat"),
        ("test_time_v73.mat", "test_time_v7.mat"),
        ("test_tables_v73.mat", "test_tables_v7.mat"),
        ("chars_hdf.mat", "chars.mat"),
    ] {
        let files =
            [newer, older].map(|name| shared_data::shared(&format!("data/daq/mat73/{name}")));
        let [Some(newer), Some(older)] = files else {
            continue;
        };
        let (newer, older) = (parse(&newer).unwrap(), parse(&older).unwrap());
        for variable in newer.variables.iter().filter(|v| !v.name.is_empty()) {
            let other = older.get(&variable.name).unwrap();
            let [value, other] = [&variable.value, other].map(by_name);
            assert_eq!(value, other, "{}", variable.name);
        }
    }
}

/// A structure with so many fields that HDF5 keeps their order elsewhere comes in the order of their names.
fn by_name(value: &MatValue) -> MatValue {
    let mut value = value.clone();
    if let MatValue::Struct { fields, values, .. } = &mut value
        && fields.len() > 100
    {
        let mut both: Vec<_> = fields.drain(..).zip(values.drain(..)).collect();
        both.sort_by(|(a, _), (b, _)| a.cmp(b));
        (*fields, *values) = both.into_iter().unzip();
    }
    value
}

/// What a laboratory saves with -v7.3, with the values of h5py and mat73 (`expected.json`).
#[test]
fn recordings_of_version_7_3_have_the_values_of_h5py() {
    for (name, channels, rates) in [
        ("vectors_fs.mat", ["acc", "force"], 10_000.0),
        ("struct_fs.mat", ["rec.acc", "rec.force"], 10_000.0),
        ("matrix_time.mat", ["data 1", "data 2"], 10_000.0),
        (
            "cell_of_strokes.mat",
            ["strokes{1}", "strokes{2}"],
            10_000.0,
        ),
    ] {
        let Some(path) = shared_data::shared(&format!("data/daq/mat73/lab/{name}")) else {
            continue;
        };
        let recording = read_recording(&path, &ReadOptions::default())
            .unwrap()
            .recording;
        let found: Vec<&str> = recording
            .channels()
            .iter()
            .map(|c| c.name.as_str())
            .take(2)
            .collect();
        assert_eq!(
            (found.as_slice(), recording.rate().hz()),
            (&channels[..], rates),
            "{name}"
        );
        let std = |samples: &[f64]| {
            let mean = samples.iter().sum::<f64>() / samples.len() as f64;
            let squares: f64 = samples.iter().map(|x| (x - mean).powi(2)).sum();
            (squares / samples.len() as f64).sqrt()
        };
        let expected = match name {
            "cell_of_strokes.mat" => [1.416_273_406_912_829_8, 1.418_175_271_125_951_4],
            _ => [1.417_504_220_512_696_6, 0.035_403_827_970_266_72],
        };
        for (channel, expected) in recording.channels().iter().zip(expected) {
            // Single precision of the force.
            assert!((std(&channel.samples) - expected).abs() < 1e-6, "{name}");
        }
    }
}

/// Truncations and flipped bytes: an error that says what to do, or values, never a panic, and no memory that the file only claims.
#[test]
fn damage_of_version_7_3_is_an_error_and_no_panic() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/h5py73.mat");
    let bytes = std::fs::read(&path).unwrap();
    damage(&path, &bytes, 600);
}

#[test]
#[ignore = "100 000 rounds; ./x soak numbers"]
fn soak_damage_of_version_7_3() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/h5py73.mat");
    let bytes = std::fs::read(&path).unwrap();
    damage(&path, &bytes, 100_000);
}

fn damage(path: &Path, bytes: &[u8], rounds: usize) {
    let look = |bytes: &[u8]| match parse_mat(path, bytes) {
        Ok(file) => {
            let numbers = |value: &MatValue| matches!(value, MatValue::Numbers(_));
            let _some = file
                .variables
                .iter()
                .any(|variable| numbers(&variable.value));
        }
        Err(error) => assert!(error.to_string().contains(';'), "{error}"),
    };
    for length in (0..bytes.len()).step_by(1 + bytes.len() / 100) {
        look(&bytes[..length]);
    }
    let mut random = Lcg(73);
    let mut damaged = bytes.to_vec();
    for round in 0..rounds {
        // Half of the places lie in the structure of the file, most of whose bytes are not 0.
        let mut at = 512 + random.below(bytes.len() - 512);
        while round % 2 == 0 && bytes[at] == 0 {
            at = 512 + random.below(bytes.len() - 512);
        }
        damaged[at] = match round % 3 {
            0 => 0xFF,
            _ => damaged[at] ^ (1 << random.below(8)),
        };
        look(&damaged);
        if round % 4 == 3 {
            damaged.copy_from_slice(bytes);
        }
    }
}
