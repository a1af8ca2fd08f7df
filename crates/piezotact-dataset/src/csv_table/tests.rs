use piezotact::quantity::Unit;

use super::*;

fn read(text: &str) -> Result<Recording, ReadError> {
    read_table(Path::new("t.csv"), text.as_bytes(), &ReadOptions::default())
}

#[test]
fn units_stand_in_the_header_or_in_a_row() {
    for text in [
        "time (s),acc (g),fz [mN]\n0,1,200\n0.001,2,100\n0.002,3,0\n",
        "time\tacc\tfz\ns\tg\tmN\n0\t1\t200\n0.001\t2\t100\n0.002\t3\t0\n\n\n",
        "time;acc;fz\n(s);(g);(mN)\n0;1,0;200\n0,001;2,0;100\n0,002;3,0;0\n",
        "\u{feff}time (ms), acc (g), fz (mN),\n0, 1, 200,\n1, 2, 100,\n2, 3, 0,\n",
    ] {
        let r = read(text).unwrap();
        assert!((r.rate().hz() - 1000.0).abs() < 1e-9, "{text}");
        assert_eq!(r.channels()[0].unit, Unit::MetrePerSecondSquared, "{text}");
        assert!(
            (r.channels()[0].samples[2] - 3.0 * 9.80665).abs() < 1e-12,
            "{text}"
        );
        assert!((r.channels()[1].samples[0] - 0.2).abs() < 1e-12, "{text}");
        assert_eq!(r.about.warnings, [], "{text}");
    }
}

#[test]
fn what_is_wrong_is_named_with_its_place() {
    for (text, part) in [
        ("", "a table with a header"),
        ("1,2\n3,4\n", "a header"),
        ("acc (g)\n1\n2\n", "--rate"),
        (
            "time (s),acc (g)\n0,1\n0.1,nan\n",
            "`nan` in row 3, column `acc`",
        ),
        ("time (s),acc (g)\n0,1\n0.1\n", "1 in row 3"),
        ("time (s),acc (g)\n0,1\n0,2\n", "increase"),
        ("time (s),acc (g)\n0,1\n0,1\n", "two rows"),
        (
            "time (s),acc (g)\n0,1\n0.1,1\n0.05,1\n",
            "0.05 after 0.1 in row 3",
        ),
        (
            "time (s),acc (g)\n0,1\n0,2\n1,1\n1,2\n2,3\n",
            "export the time with more digits",
        ),
        ("time (kg),acc (g)\n0,1\n1,1\n", "kg"),
        ("time (s),acc (g)\n", "rows of numbers"),
        (
            "time (ms),acc (g)\n0,1,5\n1,1,6\n",
            "one more, `5`, in row 2",
        ),
        ("time (s),acc (g)\n0,1\n", "two rows"),
    ] {
        let error = read(text).unwrap_err().to_string();
        assert!(error.contains(part), "{text:?}: {error}");
    }
}

/// 40 rows at 100 Hz whose time stamps and values `change` may alter.
fn rows(change: impl Fn(usize) -> (f64, f64)) -> String {
    let mut text = String::from("time (s),acc (m/s2)\n");
    for i in 0..40 {
        let (time, value) = change(i);
        text += &format!("{time:.2},{value}\n");
    }
    text
}

#[test]
fn a_repeated_time_stamp_is_said_and_the_rate_stays() {
    let said = |text: &str| {
        let r = read(text).unwrap();
        let [warning] = r.about.warnings.as_slice() else {
            panic!("{:?}", r.about.warnings);
        };
        (
            r.rate().hz(),
            r.channels()[0].samples.len(),
            format!("{warning:?}"),
        )
    };
    let time = |i: usize| i as f64 * 0.01;
    // the stamp before, in place of its own
    let slipped = rows(|i| (time(if i == 20 { 19 } else { i }), i as f64));
    let (rate, samples, warning) = said(&slipped);
    assert_eq!((rate, samples), (100.0, 40));
    assert!(
        warning.contains("1 time stamp is repeated") && warning.contains("0.19"),
        "{warning}"
    );
    // one row more than the time has room for: those behind it are late
    let r = read(&rows(|i| (time(if i < 20 { i } else { i - 1 }), i as f64))).unwrap();
    assert_eq!((r.rate().hz(), r.len()), (100.0, 40));
    let warnings = format!("{:?}", r.about.warnings);
    assert!(
        warnings.contains("1 time stamp is repeated") && warnings.contains("up to 0.5"),
        "{warnings}"
    );
    // the same row twice
    let twice = |i: usize| if i < 20 { i } else { i - 1 };
    let (rate, samples, warning) = said(&rows(|i| (time(twice(i)), twice(i) as f64)));
    assert_eq!((rate, samples), (100.0, 39));
    assert!(warning.contains("1 row that"), "{warning}");
    // a gap stays one: a straight line stands in it
    let gap = |i: usize| if i < 20 { i } else { i + 1 };
    let (rate, samples, warning) = said(&rows(|i| (time(gap(i)), gap(i) as f64)));
    assert_eq!((rate, samples), (100.0, 41));
    assert!(warning.contains("Number(0.2), Number(0.21)"), "{warning}");
}

#[test]
fn separators_of_thousands_are_no_decimals() {
    let text = "time (ms)\tacc (m/s2)\n0\t988\n1\t-7,382\n2\t12\n";
    let r = read(text).unwrap();
    assert_eq!(r.channels()[0].samples, [988.0, -7382.0, 12.0]);
    let warning = format!("{:?}", r.about.warnings);
    assert!(warning.contains("`-7,382` beside `988`"), "{warning}");
    // in quotes between commas too
    let r = read("time (ms),acc (m/s2)\n0,988\n1,\"-7,382\"\n2,12\n").unwrap();
    assert_eq!(r.channels()[0].samples[1], -7382.0);
    // whole numbers of another column show nothing
    let r = read("time (ms);acc (m/s2)\n0;7,382\n1;8,100\n2;9,250\n").unwrap();
    assert_eq!(r.channels()[0].samples, [7.382, 8.1, 9.25]);
    // decimals stay decimals
    let r = read("time (ms);acc (m/s2)\n0;7,382\n1;0,5\n2;12\n").unwrap();
    assert_eq!(r.channels()[0].samples, [7.382, 0.5, 12.0]);
    assert_eq!(r.about.warnings, []);
}

#[test]
fn a_table_of_channels_in_rows_is_refused_at_its_header() {
    let header: Vec<String> = (0..200_000).map(|i| format!("c{i}")).collect();
    let text = format!("{}\n{}\n", header.join(","), vec!["1"; 200_000].join(","));
    let error = read(&text).unwrap_err().to_string();
    assert!(
        error.contains("found 200000") && error.contains("transpose"),
        "{error}"
    );
}

#[test]
fn a_table_with_more_channels_than_samples_is_taken_for_channels_in_rows() {
    let table = |channels: usize, rows: usize| {
        let names: String = (0..channels).map(|i| format!(",c{i} (N)")).collect();
        let row = |at: usize| format!("{}{}\n", at as f64 / 1000.0, ",1.5".repeat(channels));
        format!(
            "time (s){names}\n{}",
            (0..rows).map(row).collect::<String>()
        )
    };
    let error = read(&table(100, 3)).unwrap_err().to_string();
    for part in [
        "expected samples in rows and channels in columns",
        "found 3 rows with 100 columns",
        "transpose it",
    ] {
        assert!(error.contains(part), "no {part} in {error}");
    }
    // A skin of many taxels has more samples; a table of a few rows is short, and no more.
    for (channels, rows) in [(100, 100), (6, 3)] {
        assert_eq!(read(&table(channels, rows)).unwrap().len(), rows);
    }
}

#[test]
fn a_guess_is_a_warning() {
    let r = read("timestamp, channel1\n266239,106\n266267,103\n266295,101\n").unwrap();
    assert!((r.rate().hz() - 35.714).abs() < 1e-3);
    assert_eq!(r.about.warnings.len(), 2, "{:?}", r.about.warnings);
}

/// The last number of a file that was cut: 0.12 of 0.1234, where the others have four decimals or any number of them.
#[test]
fn a_last_row_without_its_end_is_left_out() {
    let file = |decimals: fn(usize) -> String, last: &str| {
        let rows = (0..20).map(|k| format!("{:.2},{}\n", k as f64 / 100.0, decimals(k)));
        let text = "time (s),acc (m/s2)\n".to_owned() + &rows.collect::<String>() + last;
        let read = read(&text).unwrap();
        let said: String = (read.about.warnings.iter())
            .map(Warning::to_string)
            .collect();
        (read.channels()[0].samples.len(), said)
    };
    let fixed: fn(usize) -> String = |k| format!("{:.4}", k as f64 / 7.0);
    let free: fn(usize) -> String = |k| format!("{}", k as f64 / 8.0);
    for (decimals, last) in [(fixed, "0.20,0.12"), (fixed, "0.20"), (free, "0.20,0.12")] {
        let (rows, said) = file(decimals, last);
        assert!(
            rows == 20 && said.contains("row 22 has no end of line"),
            "{rows}: {said}"
        );
    }
    assert_eq!(file(fixed, "0.20,0.1234"), (21, String::new()));
    assert_eq!(file(free, "0.20,0.12\n"), (21, String::new()));
}

/// What warnings say.
fn said(recording: &Recording) -> String {
    let warnings = recording.about.warnings.iter();
    warnings.map(Warning::to_string).collect()
}

#[test]
fn a_rate_that_a_file_contradicts_is_said() {
    let rows = |time: fn(usize) -> String| -> String {
        (0..400).map(|k| format!("{}\n", time(k))).collect()
    };
    let both = |k: usize| format!("{0:.2},2024-03-01 10:00:{0:06.3},1", k as f64 / 100.0);
    let twice = |k: usize| {
        format!(
            "{:.2},2024-03-01 10:00:{:06.3},1",
            k as f64 / 100.0,
            k as f64 / 50.0
        )
    };
    let whole = |k: usize| format!("{:.2},2024-03-01 10:00:{:02},1", k as f64 / 100.0, k / 100);
    let header = "Elapsed (s),Date,acc (g)\n".to_owned();
    for (time, contradicts) in [
        (both as fn(usize) -> String, false),
        (twice, true),
        // Moments to the second are as even as they can be.
        (whole, false),
    ] {
        let r = read(&(header.clone() + &rows(time))).unwrap();
        assert!((r.rate().hz() - 100.0).abs() < 1e-9);
        let says = said(&r).contains("`Elapsed` lasts 3.99 s and `Date` 7.98 s in the same rows");
        assert_eq!(says, contradicts, "{}", said(&r));
    }
    // Two columns of numbers.
    let numbers = "time (s),timestamp (ms),acc (g)\n".to_owned();
    let r =
        read(&(numbers.clone() + &rows(|k| format!("{},{},1", k as f64 / 100.0, 10 * k)))).unwrap();
    assert_eq!(said(&r), "");
    let r = read(&(numbers + &rows(|k| format!("{},{},1", k as f64 / 100.0, 5 * k)))).unwrap();
    assert!(
        said(&r).contains("`time` lasts 3.99 s and `timestamp` 2"),
        "{}",
        said(&r)
    );
    // Two lines above the header.
    let lines = "Sample rate: 100 Hz\nScan rate: 200 Hz\n\nacc (g)\n".to_owned();
    let r = read(&(lines + &rows(|k| format!("{k}")))).unwrap();
    assert!(
        said(&r).contains("`Scan rate: 200 Hz` contradicts `Sample rate: 100 Hz`"),
        "{}",
        said(&r)
    );
}

#[test]
fn times_are_known_by_the_units_at_their_ends() {
    for (name, step) in [
        ("t_us", 500.0),
        ("micros", 500.0),
        ("time_us", 500.0),
        ("unix_time_ms", 0.5),
        ("Timestamp_ns", 5e5),
        ("millis", 0.5),
        ("elapsed_s", 5e-4),
        ("time ms", 0.5),
    ] {
        let rows: String = (0..20)
            .map(|k| format!("{},1\n", f64::from(k) * step))
            .collect();
        let r = read(&format!("{name},acc (g)\n{rows}")).unwrap();
        assert!(
            (r.rate().hz() - 2000.0).abs() < 1e-6,
            "{name}: {}",
            r.rate()
        );
        assert_eq!(said(&r), "", "{name}");
    }
    // What ends so and is no time is a channel.
    let r = read("time (s),contact_s,bias_ms\n0,1,2\n0.1,1,2\n0.2,1,2\n").unwrap();
    assert_eq!(r.channels()[0].name, "contact_s");
    assert_eq!(r.channels()[1].name, "bias_ms");
}

#[test]
fn days_are_times_where_they_are_stated_or_whole_rates() {
    let rows = |rate: f64, digits: usize| -> String {
        let row = |k: i32| format!("{:.digits$},1\n", f64::from(k) / rate / 86_400.0);
        (0..3000).map(row).collect()
    };
    for (header, rate, said_of) in [
        ("Time (d)", 1000.0, ""),
        ("Time [days]", 10.0, ""),
        ("Time (hh:mm:ss)", 10.0, ""),
        ("Time", 1000.0, "read as days"),
        ("Time", 1.0, "read as days"),
    ] {
        let r = read(&format!("{header},acc (g)\n{}", rows(rate, 12))).unwrap();
        assert!(
            (r.rate().hz() / rate - 1.0).abs() < 1e-3,
            "{header}: {}",
            r.rate()
        );
        assert!(said(&r).contains(said_of), "{header}: {}", said(&r));
    }
    let min = read("time (min),acc (g)\n0,1\n0.5,1\n1,1\n").unwrap();
    assert!((min.rate().hz() - 1.0 / 30.0).abs() < 1e-12);
    // A fast digitiser is in s.
    let fast: String = (0..500)
        .map(|k| format!("{:.7},1\n", f64::from(k) * 1e-6))
        .collect();
    let r = read(&format!("Time,acc (g)\n{fast}")).unwrap();
    assert!((r.rate().hz() - 1e6).abs() < 1.0, "{}", r.rate());
    // Neither.
    let refused = read(&format!("Time,acc (g)\n{}", rows(1000.4, 14))).unwrap_err();
    assert!(
        refused.to_string().contains("--scale \"Time=d\""),
        "{refused}"
    );
}

#[test]
fn intervals_above_the_header_state_the_rate() {
    for (line, hz) in [
        ("Sample interval (ms),2", 500.0),
        ("Sample Interval;0.5 ms", 2000.0),
        ("Sample Interval,4.0e-04,s", 2500.0),
        ("Sampling period: 250 µs", 4000.0),
        ("Sample Interval,0.001", 1000.0),
        ("Sample Rate,1.000000e+03", 1000.0),
        ("Time increment [us] = 100", 10_000.0),
    ] {
        let rows = "1,2\n".repeat(12);
        let sign = if line.contains(';') { ";" } else { "," };
        let table = format!("acc (g),fz (N)\n{rows}").replace(',', sign);
        let r = read(&format!("Device X\n{line}\n{table}")).unwrap();
        assert!(
            (r.rate().hz() / hz - 1.0).abs() < 1e-9,
            "{line}: {}",
            r.rate()
        );
        assert!(said(&r).contains(line), "{}", said(&r));
    }
    // 2 of what?
    assert!(
        read(&format!(
            "Device X\nSample interval,2\nacc (g)\n{}",
            "1\n".repeat(12)
        ))
        .is_err()
    );
}

#[test]
fn minutes_and_seconds_are_times() {
    let row = |k: usize| format!("{:02}:{:06.3},1\n", 59 + k / 500, (k % 500) as f64 * 0.12);
    let rows: String = (0..499).map(row).collect();
    let r = read(&format!("Time,acc (g)\n{rows}00:00.000,1\n00:00.120,1\n")).unwrap();
    assert!((r.rate().hz() - 1.0 / 0.12).abs() < 1e-6, "{}", r.rate());
    assert_eq!(r.len(), 502);
}
