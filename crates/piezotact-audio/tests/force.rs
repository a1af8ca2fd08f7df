//! Sources of force: a serial port, over a pseudo-terminal, and a file that grows.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use piezotact::recording::{LostBy, RecordingWarning};
use piezotact::stroke::{ForceFault, ForceWarning};
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::Path;
use std::time::{Duration, Instant};

use piezotact::Warning;
use piezotact_audio::force::{
    Columns, ForceError, ForceReading, ForceSource, ForceUnit, GrowingFile, GrowingSettings,
    SerialForceCell, SerialSettings, TimeUnit,
};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};

/// What nothing here takes, on a busy machine.
const LONG: Duration = Duration::from_secs(20);

/// The end of a pseudo-terminal at which the device is, and a cell at the other.
fn cell(unit: Option<ForceUnit>) -> (File, SerialForceCell) {
    let device = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
    grantpt(&device).unwrap();
    unlockpt(&device).unwrap();
    let port = ptsname(&device, Vec::new()).unwrap();
    let mut cell = SerialForceCell::new(SerialSettings {
        unit,
        // Time enough for a busy machine; tests of silence have less.
        first_within: LONG,
        longest_pause: LONG,
        ..SerialSettings::usual(port.to_str().unwrap())
    });
    cell.start().unwrap();
    (File::from(device), cell)
}

/// The readings until there are `count`, or the error before.
fn read(source: &mut dyn ForceSource, count: usize) -> Result<Vec<ForceReading>, ForceError> {
    let since = Instant::now();
    let mut readings = Vec::new();
    while readings.len() < count {
        assert!(since.elapsed() < LONG, "only {} readings", readings.len());
        readings.extend(source.poll()?);
        std::thread::sleep(Duration::from_millis(2));
    }
    Ok(readings)
}

/// The error that comes, after any readings.
fn error(source: &mut dyn ForceSource) -> ForceError {
    let since = Instant::now();
    loop {
        assert!(since.elapsed() < LONG, "no error");
        match source.poll() {
            Ok(_) => std::thread::sleep(Duration::from_millis(2)),
            Err(error) => return error,
        }
    }
}

fn forces(readings: &[ForceReading]) -> Vec<f64> {
    // Units are factors that are no binary fractions.
    let rounded = |reading: &ForceReading| (reading.force_n * 1e9).round() / 1e9;
    readings.iter().map(rounded).collect()
}

fn unreadable(warnings: &[Warning]) -> Option<(usize, usize)> {
    warnings.iter().find_map(|warning| match warning.kind() {
        Some(RecordingWarning::SamplesLost {
            by: LostBy::ForceLines {
                unreadable, lines, ..
            },
        }) => Some((unreadable, lines)),
        _ => None,
    })
}

#[test]
fn lines_are_read_as_they_come() {
    let (mut device, mut cell) = cell(None);
    // The rest of a line, a header, lines with both ends, and a line in two parts.
    device
        .write_all(b"7 950.1\r\n# force cell unit=mN rate=80\r\nF 1000 200\r\nF 1012 201.5\nF 10")
        .unwrap();
    let before = Instant::now();
    let mut readings = read(&mut cell, 2).unwrap();
    device.write_all(b"25 203\r\n").unwrap();
    readings.extend(read(&mut cell, 1).unwrap());
    assert_eq!(forces(&readings), [0.2, 0.2015, 0.203]);
    let times: Vec<f64> = readings
        .iter()
        .map(|reading| (reading.device_s.unwrap() * 1e3).round())
        .collect();
    assert_eq!(times, [0.0, 12.0, 25.0]);
    assert!(readings.windows(2).all(|pair| pair[0].at <= pair[1].at));
    assert!(readings[2].at > before);
    let about = cell.describe();
    assert_eq!(
        (about.unit, about.nominal_rate_hz),
        (Some(ForceUnit::Millinewton), Some(80.0))
    );
    assert!(cell.warnings().is_empty());
    cell.stop();
    assert_eq!(cell.poll(), Ok(Vec::new()));
    // It can be started again.
    cell.start().unwrap();
    device.write_all(b"# unit=N\nF 5000 0.5\n").unwrap();
    assert_eq!(forces(&read(&mut cell, 1).unwrap()), [0.5]);
}

#[test]
fn a_scale_sends_numbers_alone() {
    let (mut device, mut cell) = cell(Some(ForceUnit::Gram));
    // The first line may be the rest of one: 120.394 would be 0.394.
    device.write_all(b".394\n20.394\n +20.394 g\n").unwrap();
    let readings = read(&mut cell, 2).unwrap();
    for reading in readings {
        assert!((reading.force_n - 0.2).abs() < 1e-5 && reading.device_s.is_none());
    }
}

#[test]
fn garbage_is_counted_and_told() {
    let (mut device, mut cell) = cell(Some(ForceUnit::Newton));
    device.write_all(b"\n").unwrap();
    for i in 0..50 {
        let line = match i % 5 {
            0 => "F 1\u{fffd}7 x\n".to_owned(),
            1 => format!("F {} nan\n", 10 * i),
            _ => format!("F {} 0.25\n", 10 * i),
        };
        device.write_all(line.as_bytes()).unwrap();
    }
    device.write_all(&[b'9'; 2_000]).unwrap();
    device.write_all(b"\nF 500 0.5\n").unwrap();
    let readings = read(&mut cell, 31).unwrap();
    assert!(readings[..30].iter().all(|reading| reading.force_n == 0.25));
    assert_eq!(readings[30].force_n, 0.5);
    assert_eq!(unreadable(&cell.warnings()), Some((21, 52)));
}

/// The device's time wraps after 2³² ms, and goes on.
#[test]
fn device_time_wraps() {
    let (mut device, mut cell) = cell(Some(ForceUnit::Newton));
    device
        .write_all(b"F 4294967290 1\nF 4294967295 1\nF 4 1\nF 14 1\n")
        .unwrap();
    let readings = read(&mut cell, 4).unwrap();
    let times = readings.iter().map(|reading| reading.device_s.unwrap());
    let expected = [0.0, 0.005, 0.010, 0.020];
    assert!(times.zip(expected).all(|(a, b)| (a - b).abs() < 1e-6));
}

#[test]
fn what_ends_a_run() {
    let (mut device, mut changed) = cell(None);
    device
        .write_all(b"# unit=mN\nF 10 200\n# unit=g\nF 20 20\n")
        .unwrap();
    assert_eq!(forces(&read(&mut changed, 1).unwrap()), [0.2]);
    let found = error(&mut changed);
    assert!(
        matches!(
            found,
            ForceError::Unit {
                expected: ForceUnit::Millinewton,
                found: ForceUnit::Gram,
                ..
            }
        ),
        "{found}"
    );
    // It stays.
    assert_eq!(error(&mut changed), found);

    let (mut device, mut restarted) = cell(Some(ForceUnit::Newton));
    device
        .write_all(b"F 90000 1\nF 90010 1\nF 3 1\nF 13 1\nF 23 1\n")
        .unwrap();
    read(&mut restarted, 2).unwrap();
    assert!(matches!(
        error(&mut restarted),
        ForceError::Restarted { from_s, .. } if (from_s - 90.01).abs() < 1e-9
    ));

    let (mut device, mut vanished) = cell(Some(ForceUnit::Newton));
    device.write_all(b"F 10 1\n").unwrap();
    read(&mut vanished, 1).unwrap();
    drop(device);
    assert!(matches!(
        error(&mut vanished),
        ForceError::Vanished { readings: 1, .. }
    ));
    let found = vanished.start().unwrap_err();
    assert!(matches!(found, ForceError::Open { .. }), "{found}");
}

/// Silence, lines that are no forces and forces without a unit are three errors.
#[test]
fn what_is_missing_is_named() {
    let (first_within, longest_pause) = (Duration::from_millis(900), Duration::from_millis(300));
    let quick = || {
        let (device, cell) = cell(None);
        let port = cell.describe().name;
        drop(cell);
        let cell = SerialForceCell::new(SerialSettings {
            first_within,
            longest_pause,
            ..SerialSettings::usual(port)
        });
        (device, cell)
    };
    let (_device, mut silent) = quick();
    silent.start().unwrap();
    let since = Instant::now();
    assert!(matches!(
        error(&mut silent),
        ForceError::Silent { readings: 0, .. }
    ));
    assert!(since.elapsed() >= first_within);

    let (mut device, mut stops) = quick();
    stops.start().unwrap();
    device.write_all(b"# unit=N\nF 10 1\n").unwrap();
    read(&mut stops, 1).unwrap();
    assert!(matches!(
        error(&mut stops),
        ForceError::Silent { readings: 1, pause, .. } if pause == longest_pause
    ));

    let (mut device, mut garbled) = quick();
    garbled.start().unwrap();
    device.write_all(b"\n\xf0\x80\x81x\n??\n").unwrap();
    assert!(matches!(error(&mut garbled), ForceError::Unreadable { .. }));

    let (mut device, mut unitless) = quick();
    unitless.start().unwrap();
    device.write_all(b"\n0.2\n0.3\n").unwrap();
    assert!(matches!(error(&mut unitless), ForceError::NoUnit { .. }));
}

#[test]
fn a_port_that_is_not_there() {
    let mut cell = SerialForceCell::new(SerialSettings::usual("/dev/no-such-port"));
    assert!(matches!(cell.start(), Err(ForceError::Open { .. })));
    assert_eq!(cell.poll(), Ok(Vec::new()));
}

fn growing(path: &Path) -> GrowingFile {
    GrowingFile::new(GrowingSettings {
        first_within: LONG,
        longest_pause: LONG,
        ..GrowingSettings::usual(path)
    })
}

fn append(path: &Path, text: &str) {
    let mut file = OpenOptions::new()
        .append(true)
        .create(true)
        .open(path)
        .unwrap();
    file.write_all(text.as_bytes()).unwrap();
}

fn began_again(warnings: &[Warning]) -> usize {
    let times = warnings.iter().find_map(|warning| match warning.kind() {
        Some(ForceWarning::Doubtful {
            fault: ForceFault::BeganAgain { times, .. },
        }) => Some(times),
        _ => None,
    });
    times.unwrap_or(0)
}

#[test]
fn a_file_is_followed_from_its_end() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("force.csv");
    append(&path, "time_s,force_mN\n0.00,100\n0.01,100\n0.02,1");
    let mut file = growing(&path);
    file.start().unwrap();
    assert_eq!(file.describe().unit, Some(ForceUnit::Millinewton));
    assert_eq!(file.poll(), Ok(Vec::new()));
    // The end of a line that began before, a line, and one without its end.
    append(&path, "00\n0.03,200\n0.04,2");
    let readings = read(&mut file, 1).unwrap();
    assert_eq!(forces(&readings), [0.2]);
    std::thread::sleep(Duration::from_millis(50));
    assert_eq!(file.poll(), Ok(Vec::new()));
    append(&path, "10\nbroken\n0.05,220\n");
    let readings = read(&mut file, 2).unwrap();
    assert_eq!(forces(&readings), [0.21, 0.22]);
    let times = readings.iter().map(|reading| reading.device_s.unwrap());
    assert!(times.zip([0.01, 0.02]).all(|(a, b)| (a - b).abs() < 1e-9));
    assert_eq!(unreadable(&file.warnings()), Some((1, 4)));
    assert_eq!(began_again(&file.warnings()), 0);
}

#[test]
fn truncation_and_replacement_are_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("force.txt");
    append(&path, "# unit=N rate=100\nF 5000 0.1\n");
    let mut file = growing(&path);
    file.start().unwrap();
    append(&path, "F 5010 0.2\n");
    assert_eq!(forces(&read(&mut file, 1).unwrap()), [0.2]);
    // Shorter than before.
    std::fs::write(&path, "# unit=N\nF 10 0.3\n").unwrap();
    let readings = read(&mut file, 1).unwrap();
    assert_eq!((forces(&readings), readings[0].clock), (vec![0.3], 1));
    assert_eq!(readings[0].device_s, Some(0.0));
    // Emptied and longer than before at once.
    std::fs::write(
        &path,
        format!("# another one unit=N\n{}", "F 10 0.4\n".repeat(20)),
    )
    .unwrap();
    let readings = read(&mut file, 20).unwrap();
    assert_eq!((readings[19].force_n, readings[19].clock), (0.4, 2));
    // Replaced, with what was still appended to the old one.
    append(&path, "F 20 0.5\n");
    let new = folder.path().join("new");
    append(&new, "# unit=N\nF 10 0.6\n");
    std::fs::rename(&new, &path).unwrap();
    let readings = read(&mut file, 2).unwrap();
    assert_eq!(forces(&readings), [0.5, 0.6]);
    assert_eq!((readings[0].clock, readings[1].clock), (2, 3));
    assert_eq!(began_again(&file.warnings()), 3);
    // Replaced by one in another unit.
    append(&new, "force_g\n1\n");
    std::fs::rename(&new, &path).unwrap();
    assert!(matches!(error(&mut file), ForceError::Unit { .. }));
}

/// A file that does not exist yet is read from its beginning once it does; one that never comes is silence.
#[test]
fn a_file_may_come_later() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("force.tsv");
    let mut file = growing(&path);
    file.start().unwrap();
    assert_eq!(file.poll(), Ok(Vec::new()));
    append(&path, "Fz [N]\tt [ms]\n0,2\t100");
    assert_eq!(file.poll(), Ok(Vec::new()));
    append(&path, "\n0,3\t110\n");
    assert_eq!(forces(&read(&mut file, 2).unwrap()), [0.2, 0.3]);

    let mut never = GrowingFile::new(GrowingSettings {
        first_within: Duration::from_millis(100),
        ..GrowingSettings::usual(folder.path().join("never"))
    });
    never.start().unwrap();
    assert!(matches!(error(&mut never), ForceError::Silent { .. }));
    let mut no_file = GrowingFile::new(GrowingSettings::usual(folder.path()));
    assert!(matches!(no_file.start(), Err(ForceError::Open { .. })));
}

#[test]
fn columns_are_named_or_stated() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("export.csv");
    append(&path, "# exported today\n\"t\";\"channel 3\"\n");
    let mut by_header = growing(&path);
    let found = by_header.start().unwrap_err();
    assert!(matches!(found, ForceError::Columns { .. }), "{found}");
    let mut named = GrowingFile::new(GrowingSettings {
        columns: Columns::Named {
            force: "channel 3".into(),
            unit: ForceUnit::Newton,
            time: Some(("t".into(), TimeUnit::Millisecond)),
        },
        ..GrowingSettings::usual(&path)
    });
    named.start().unwrap();
    append(&path, "10;0,25\n20;0,35\n");
    let readings = read(&mut named, 2).unwrap();
    assert_eq!(forces(&readings), [0.25, 0.35]);
    // Its time goes back: after three readings that agree it began again.
    append(&path, "1;0,1\n2;0,2\n3;0,3\n4;0,4\n");
    let readings = read(&mut named, 2).unwrap();
    assert_eq!((forces(&readings), readings[0].clock), (vec![0.3, 0.4], 1));
    assert_eq!(began_again(&named.warnings()), 1);
}
