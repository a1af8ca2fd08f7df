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
        let stated = SampleRate::new(stated).ok();
        let base = choose_base(
            Path::new("t"),
            stated,
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
