//! The numbers are those of NumPy (`golden/time_columns.py`).

use super::*;

fn base(times: &[f64]) -> (TimeBase, Vec<String>) {
    let time = Column {
        name: "time".into(),
        unit: Some("s".into()),
        values: times.to_vec(),
    };
    let mut warnings = Vec::new();
    let base = base_of(Path::new("t"), &time, &mut warnings).unwrap();
    (base, warnings.iter().map(Warning::to_string).collect())
}

/// Steps of a noise that is the same every time, from −1 to 1.
fn noise(k: usize) -> f64 {
    let mixed = (k as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    2.0 * (mixed >> 11) as f64 / (1_u64 << 53) as f64 - 1.0
}

/// 100 Hz that slows down by 0.9 % in 60 s: no step is 1 % off, the clock is.
#[test]
fn a_slow_drift_is_said_with_its_largest_distance() {
    let times: Vec<f64> = (0..6000)
        .map(f64::from)
        .map(|k| 0.01 * k * (1.0 + 0.0045 * k / 6000.0))
        .collect();
    let (base, said) = base(&times);
    assert!(
        (base.rate.hz() - 99.5520).abs() < 1e-4,
        "{}",
        base.rate.hz()
    );
    assert!((base.residual - 4.48).abs() < 0.01, "{}", base.residual);
    let [said] = said.as_slice() else {
        panic!("{said:?}")
    };
    assert!(said.contains("up to 4.48 samples (45.0 ms)"), "{said}");
}

/// 1 kHz whose clock jumps by a fifth of a step every 100 rows: the mean step is that of 998 Hz.
#[test]
fn small_breaks_do_not_make_another_rate() {
    let times: Vec<f64> = (0..6000)
        .map(|k| 1e-3 * (k as f64 + 0.2 * (k / 100) as f64 + 1e-3 * noise(k)))
        .collect();
    let (base, said) = base(&times);
    assert!((base.rate.hz() - 1000.0).abs() < 1e-2, "{}", base.rate.hz());
    // 59 breaks of 0.2 are 11.8 samples.
    assert_eq!(base.missing(), 12);
    assert!(base.residual <= 0.7, "{}", base.residual);
    assert!(
        said.iter()
            .any(|said| said.contains("the steps of time differ")),
        "{said:?}"
    );
}

/// Lost samples of a jittering clock: 3 of them at row 500, and 40 at row 2000.
#[test]
fn lost_samples_are_counted_on_a_clock_that_jitters() {
    let lost = |k: usize| 3 * usize::from(k >= 500) + 40 * usize::from(k >= 2000);
    let times: Vec<f64> = (0..4000)
        .map(|k| 4e-3 * ((k + lost(k)) as f64 + 0.1 * noise(k)))
        .collect();
    let (base, _) = base(&times);
    assert_eq!(base.gaps, [(500, 3), (2000, 40)]);
    assert!((base.rate.hz() - 250.0).abs() < 2e-3, "{}", base.rate.hz());
    let mut samples: Vec<f64> = (0..4000).map(|k| (k + lost(k)) as f64).collect();
    base.fill(&mut samples);
    assert!(
        samples
            .iter()
            .enumerate()
            .all(|(k, value)| (value - k as f64).abs() < 1e-9)
    );
}

#[test]
fn rounded_time_stamps_are_no_jitter() {
    // 80 and 600 Hz to the ms: steps of 12 and 13, 1 and 2.
    for rate in [80.0, 600.0] {
        let times: Vec<f64> = (0..4000)
            .map(|k| (f64::from(k) / rate * 1e3).round() / 1e3)
            .collect();
        let (base, said) = base(&times);
        assert_eq!((base.rate.hz(), base.missing()), (rate, 0), "{said:?}");
        assert_eq!(said, [""; 0]);
    }
}

#[test]
fn a_stated_rate_that_the_times_do_not_have_is_said() {
    let times: Vec<f64> = (0..60_000).map(|k| f64::from(k) / 1000.0).collect();
    let (found, _) = base(&times);
    let said = |stated: f64| {
        let mut warnings = Vec::new();
        let stated = ReadOptions {
            rate: SampleRate::new(stated).ok(),
            ..ReadOptions::default()
        };
        let base = choose_base(
            Path::new("t"),
            &stated,
            Some(Ok(found.clone())),
            &mut warnings,
        );
        (base.unwrap().rate.hz(), warnings.len())
    };
    // 0.01 % is 6 samples in a minute.
    assert_eq!(
        [said(1000.0), said(1000.1), said(500.0)],
        [(1000.0, 0), (1000.1, 1), (500.0, 1)]
    );
}

#[test]
fn what_has_no_grid_is_refused() {
    let refused = |times: &[f64]| {
        let time = Column {
            name: "time".into(),
            unit: Some("s".into()),
            values: times.to_vec(),
        };
        base_of(Path::new("t"), &time, &mut Vec::new())
            .unwrap_err()
            .to_string()
    };
    // More is missing than is there, without bound.
    assert!(refused(&[0.0, 1.0, 2.0, 1e15, 1e15 + 1.0]).contains("a step from 2 to"));
    let wild: Vec<f64> = (0..400)
        .map(|k| f64::from(k) + if k % 7 == 0 { 0.4 } else { 0.0 })
        .collect();
    assert!(refused(&wild).contains("in steps of about 1"));
    assert!(refused(&[0.0, 1.0, f64::NAN]).contains("a time in every row"));
}

/// The rate of times without a unit, and what is said of it; or the error.
fn without_unit(times: impl Iterator<Item = f64>) -> Result<(f64, String), String> {
    let time = Column {
        name: "t".into(),
        unit: None,
        values: times.collect(),
    };
    let mut warnings = Vec::new();
    let base = base_of(Path::new("t"), &time, &mut warnings).map_err(|error| error.to_string())?;
    let said = warnings.iter().map(Warning::to_string).collect();
    Ok((base.rate.hz(), said))
}

#[test]
fn times_since_1970_are_in_the_unit_that_they_can_only_have() {
    let rows = || (0..2000).map(f64::from);
    for (times, unit) in [
        (
            rows().map(|k| 1.7e12 + k).collect::<Vec<f64>>(),
            "milliseconds since 1970",
        ),
        (
            rows().map(|k| 1.7e15 + 1e3 * k).collect(),
            "microseconds since 1970",
        ),
        (
            rows().map(|k| 1.7e18 + 1e6 * k).collect(),
            "nanoseconds since 1970",
        ),
        (rows().map(|k| 1.7e9 + 1e-3 * k).collect(), "seconds"),
    ] {
        let (hz, said) = without_unit(times.into_iter()).unwrap();
        assert!((hz - 1000.0).abs() < 1e-3, "{unit}: {hz}");
        assert!(said.contains(&format!("read as {unit} (")), "{said}");
    }
}

/// A counter of ms and one of µs: the second may be either, and is refused with the way to state it.
#[test]
fn whole_numbers_whose_unit_is_not_certain_are_refused() {
    let (hz, said) = without_unit((0..200).map(|k| f64::from(2 * k))).unwrap();
    assert!(
        hz == 500.0 && said.contains("read as milliseconds"),
        "{said}"
    );
    let refused = without_unit((0..200).map(|k| f64::from(1000 * k))).unwrap_err();
    assert!(refused.contains("--scale \"t=us\""), "{refused}");
}

/// Where a rate is stated, what is said of unusable times does not advise to state one.
#[test]
fn a_stated_rate_is_not_advised_again() {
    let options = ReadOptions {
        rate: SampleRate::new(100.0).ok(),
        ..ReadOptions::default()
    };
    let error = ReadError::content(Path::new("t"), "a time", "none", "give --rate");
    let mut warnings = Vec::new();
    choose_base(Path::new("t"), &options, Some(Err(error)), &mut warnings).unwrap();
    let said: String = warnings.iter().map(Warning::to_string).collect();
    assert!(
        said.contains("(expected a time, found none)") && !said.contains("--rate"),
        "{said}"
    );
}

/// A pause of 1 s in 3 s at 1 kHz is no place for straight lines; the 5 samples after it are.
#[test]
fn a_pause_divides_the_recording_into_parts() {
    let late = |k: usize| 1000 * usize::from(k >= 1000) + 5 * usize::from(k >= 1500);
    let times: Vec<f64> = (0..2000).map(|k| 1e-3 * (k + late(k)) as f64).collect();
    let (found, _) = base(&times);
    let part = |part: Option<usize>| {
        let options = ReadOptions {
            part,
            ..ReadOptions::default()
        };
        let mut warnings = Vec::new();
        let base = choose_base(
            Path::new("t"),
            &options,
            Some(Ok(found.clone())),
            &mut warnings,
        );
        let said: String = warnings.iter().map(Warning::to_string).collect();
        base.map(|base| {
            let mut samples: Vec<f64> = (0..2000).map(|k| (k + late(k)) as f64).collect();
            base.cut(&mut samples);
            base.fill(&mut samples);
            (base.offset_s, samples, said)
        })
    };
    let (offset_s, samples, said) = part(None).unwrap();
    assert_eq!((offset_s, samples.len(), samples[999]), (0.0, 1000, 999.0));
    assert!(
        said.contains("2 parts") && said.contains("1.000 s of 2.005 s"),
        "{said}"
    );
    let (offset_s, samples, said) = part(Some(2)).unwrap();
    assert_eq!((samples.len(), said.as_str()), (1005, ""));
    assert!((offset_s - 2.0).abs() < 1e-9, "{offset_s}");
    assert!(
        samples
            .iter()
            .enumerate()
            .all(|(k, value)| *value == (2000 + k) as f64)
    );
    assert!(
        part(Some(3))
            .unwrap_err()
            .to_string()
            .contains("a part from 1 to 2")
    );
}

/// Of a damaged file: a part that ended before its first row was a panic.
#[test]
fn gaps_outside_of_the_rows_are_none() {
    let rate = SampleRate::new(1000.0).unwrap();
    let gaps = vec![(0, 100), (20, 100), (50, 100), (60, 100)];
    let base = TimeBase::with_gaps(rate, gaps, 50);
    assert_eq!(base.starts(), [0, 20]);
    let mut warnings = Vec::new();
    let none = TimeBase::with_gaps(rate, vec![(0, 100)], 0);
    let part = none.part(Path::new("a.lvm"), None, 0, &mut warnings);
    assert!(part.is_ok() && warnings.is_empty());
}
